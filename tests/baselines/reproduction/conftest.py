import pytest


@pytest.fixture(scope="session")
def of_plan():
    # Imported here, so that without torch the files are skipped and not this one.
    from reproduced import records

    return records()


@pytest.fixture(scope="session")
def results(of_plan):
    from npss_baselines.reproduction.plan import read_plan
    from npss_baselines.reproduction.results import Results

    return Results(read_plan(), of_plan)
