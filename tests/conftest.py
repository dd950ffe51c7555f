"""Settings shared by all tests: deterministic hypothesis, and where real motion is."""

import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

settings.register_profile(
    "npss",
    deadline=None,  # two shared cores: time says nothing
    derandomize=True,  # a failure is the same one on every machine; NPSS_HYPOTHESIS=explore looks for new ones
    max_examples=60,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.register_profile("explore", parent=settings.get_profile("npss"), derandomize=False, max_examples=2000)
settings.load_profile(os.environ.get("NPSS_HYPOTHESIS", "npss"))


def _folder(variable: str, what: str) -> Path:
    root = os.environ.get(variable)
    if not root:
        pytest.skip(f"needs {what}: set {variable} to its folder")
    path = Path(root)
    assert path.is_dir(), f"{variable}={root} is not a folder"
    return path


@pytest.fixture(scope="session")
def h36m_root() -> Path:
    """The folder that holds Human3.6M's ``dataset/S1`` ..."""
    return _folder("NPSS_H36M", "Human3.6M (exponential maps)")


@pytest.fixture(scope="session")
def samples_root() -> Path:
    """The folder that holds ``wookay_walking_10000.h5`` and ``wookay_eating_1000.h5``."""
    return _folder("NPSS_SAMPLES", "prediction files of another project (samples.h5)")


@pytest.fixture(scope="session")
def cmu_root() -> Path:
    """The folder that holds ``clips.csv`` and CMU's ``01/01_01.bvh`` ..."""
    return _folder("NPSS_CMU", "CMU clips (BVH)")


@pytest.fixture(scope="session")
def cmu_styles_root() -> Path:
    """The folder that holds ``indian/04.bvh`` ... of CMU."""
    return _folder("NPSS_CMU_STYLES", "CMU clips of dances and martial arts (BVH)")
