"""Settings shared by all tests: deterministic hypothesis, and where real motion is."""

import importlib.util
import os
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

if "PYTEST_XDIST_WORKER" in os.environ:  # one thread for each of several processes, before numpy and torch start theirs
    os.environ.setdefault("OMP_NUM_THREADS", "1")
if threads := os.environ.get("NPSS_THREADS"):  # torch takes no more from OMP_NUM_THREADS than there are processors
    import torch

    torch.set_num_threads(int(threads))

settings.register_profile(
    "npss",
    deadline=None,  # two shared cores: time says nothing
    derandomize=True,  # a failure is the same one on every machine; NPSS_HYPOTHESIS=explore looks for new ones
    max_examples=60,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.register_profile("few", parent=settings.get_profile("npss"), max_examples=5)  # where much is run many times
settings.register_profile("explore", parent=settings.get_profile("npss"), derandomize=False, max_examples=2000)
settings.load_profile(os.environ.get("NPSS_HYPOTHESIS", "npss"))

#: What only npss_baselines and the tests of pages need. Without torch, the core's tests run by themselves.
BEYOND_THE_CORE = (
    "docstring_parser",
    "filelock",
    "jsonargparse",
    "lightning",
    "safetensors",
    "selenium",
    "torch",
    "torchmetrics",
    "websocket",
)

#: Markers of the tests that use a fixture.
MARKER_OF_FIXTURE = {
    "browser": "browser",
    "cmu_root": "real_data",
    "cmu_styles_root": "real_data",
    "gpu": "gpu",
    "h36m_root": "real_data",
    "processes": "slow",
    "samples_root": "real_data",
}


@pytest.hookimpl(tryfirst=True)  # before `-m` selects
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark tests by what they use."""
    for item in items:
        for fixture in getattr(item, "fixturenames", ()):
            if fixture in MARKER_OF_FIXTURE:
                item.add_marker(MARKER_OF_FIXTURE[fixture])


def missing_module(error: BaseException | None) -> str | None:
    """Return the module whose absence led to an error."""
    while error is not None:
        if isinstance(error, ModuleNotFoundError):
            return (error.name or "").partition(".")[0]
        error = error.__cause__ or error.__context__
    return None


class Module(pytest.Module):
    """A file of tests; without torch, one that needs what the core does not is skipped, and says so."""

    def collect(self) -> Iterable[pytest.Item | pytest.Collector]:
        try:
            return super().collect()
        except self.CollectError as error:
            missing = missing_module(error)
            if missing in BEYOND_THE_CORE and importlib.util.find_spec("torch") is None:
                pytest.skip(f"the whole file needs {missing}", allow_module_level=True)
            raise


def pytest_runtest_teardown() -> None:
    """Forget the plugins that a test has named, which commands repeat in what they print."""
    if plugins := sys.modules.get("npss.plugins"):
        plugins._named.clear()
        plugins._imported.clear()


def pytest_pycollect_makemodule(module_path: Path, parent: pytest.Collector) -> pytest.Module:
    """Collect the tests of a file as `Module` says."""
    return Module.from_parent(parent, path=module_path)


@pytest.fixture
def registry() -> Iterator[None]:
    """Forget the metrics that a test registers."""
    from npss.metrics import METRICS
    from registered import restored

    with restored(METRICS):
        yield


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


@pytest.fixture
def gpu() -> None:
    """Skip where there is no CUDA device."""
    torch = pytest.importorskip("torch")
    if not torch.cuda.is_available():
        pytest.skip("needs a CUDA device")


@pytest.fixture(scope="module")
def one_thread() -> Iterator[None]:
    """Small tensors on shared cores: threads of torch that wait for each other would cost most of the time."""
    import torch

    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)


@pytest.fixture
def one_thread_and_a_seed(one_thread: None) -> None:
    """One thread, and the same random numbers each time."""
    import torch

    torch.manual_seed(0)
