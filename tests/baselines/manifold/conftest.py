"""A testbed of few walks and an untrained manifold, and the records of all applications, computed once."""

import pytest


@pytest.fixture(scope="package")
def motions():
    from npss_baselines.manifold.motion.prepared import motion_set

    return motion_set(quick=True)  # 8 walks


@pytest.fixture(scope="package")
def testbed(motions):
    from npss_baselines.manifold.evaluation.testbed import Testbed
    from untrained import manifold_of

    return Testbed(motions, {"manifold": manifold_of(motions)})


@pytest.fixture(scope="package")
def records(testbed):
    from npss_baselines.manifold.evaluation.measure import measure_all

    return list(measure_all(testbed))
