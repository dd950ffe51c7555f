"""Settings shared by all tests: deterministic hypothesis, and where real motion is."""

import importlib.util
import os
from collections.abc import Iterable, Iterator
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

#: What only the reference models and their pages need. Without torch, the core's tests run by themselves.
BEYOND_THE_CORE = ("torch", "torchmetrics", "lightning", "jsonargparse", "safetensors", "selenium")


class Module(pytest.Module):
    """A file of tests; without torch, one that needs what the core does not is skipped, and says so."""

    def collect(self) -> Iterable[pytest.Item | pytest.Collector]:
        try:
            return super().collect()
        except self.CollectError as error:
            missing = getattr(error.__cause__, "name", None)
            if missing in BEYOND_THE_CORE and importlib.util.find_spec("torch") is None:
                pytest.skip(f"the whole file needs {missing}", allow_module_level=True)
            raise


def pytest_pycollect_makemodule(module_path: Path, parent: pytest.Collector) -> pytest.Module:
    """Collect the tests of a file as `Module` says."""
    return Module.from_parent(parent, path=module_path)


@pytest.fixture
def registry() -> Iterator[None]:
    """Forget the metrics that a test registers."""
    from npss._metric.registry import _registered

    before = dict(_registered)
    yield
    _registered.clear()
    _registered.update(before)


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
