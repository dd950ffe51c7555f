"""Time of `import npss`, as a ratio to `import numpy`, in fresh processes in turn. `pytest benchmarks -s`."""

import subprocess
import sys
import time


def seconds(statement):
    start = time.perf_counter()
    subprocess.run([sys.executable, "-c", statement], check=True)
    return time.perf_counter() - start


def test_import_cost():
    pairs = [(seconds("import numpy"), seconds("import npss")) for _ in range(20)]
    numpy, npss = (sorted(times)[len(times) // 2] for times in zip(*pairs, strict=True))
    print(f"\nimport numpy {numpy * 1e3:.0f} ms, import npss {npss * 1e3:.0f} ms, ratio {npss / numpy:.2f}")
    assert npss <= 1.2 * numpy
