"""A testbed of few walks and an untrained manifold, and the records of all applications, computed once."""

import pytest


@pytest.fixture(scope="package", autouse=True)
def few_samples():
    """Measure fewer pairs, samples and joints than the commands do."""
    try:
        from npss_baselines.manifold.evaluation import measure, synthesis
    except ImportError:  # without torch, tests that measure are skipped
        yield
        return
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(synthesis, "PAIRS", 6)
        patch.setattr(synthesis, "SAMPLES", 40)
        patch.setattr(measure, "FILLS", measure.FILLS[:1])
        yield


@pytest.fixture(scope="package")
def motions():
    from npss_baselines.manifold.motion.prepared import motion_set

    return motion_set(quick=True)  # 8 walks


@pytest.fixture(scope="package")
def testbed(motions):
    pytest.importorskip("torch")
    from npss_baselines.manifold.evaluation.testbed import Testbed
    from untrained import manifold_of

    return Testbed(motions, {"manifold": manifold_of(motions)})


@pytest.fixture(scope="package")
def records(testbed):
    from npss_baselines.manifold.evaluation.measure import measure_all

    return list(measure_all(testbed))


@pytest.fixture(scope="package")
def run(motions, tmp_path_factory):
    """Return the folder of an untrained run."""
    pytest.importorskip("torch")
    from dataclasses import replace

    from npss_baselines.manifold.training import folder
    from npss_baselines.manifold.training.config import FILE, defaults, write
    from untrained import manifold_of

    run = tmp_path_factory.mktemp("runs") / "untrained"
    run.mkdir()
    manifold = manifold_of(motions)
    configuration = replace(defaults(), model=manifold.network.config)
    write(run / FILE, configuration, "cpu")
    folder.save(run, manifold.network, manifold.scaling, {})
    return run
