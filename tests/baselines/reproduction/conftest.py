import pytest

from npss_baselines.reproduction.plan import read_plan
from npss_baselines.reproduction.results import Results
from reproduced import records


@pytest.fixture(scope="session")
def of_plan():
    return records()


@pytest.fixture(scope="session")
def results(of_plan):
    return Results(read_plan(), of_plan)
