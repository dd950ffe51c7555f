#!/usr/bin/env python3
"""Run the tests marked ``numeric`` again as other machines would: with other kernels and other numbers of threads.

Run it in the checkout; arguments go to pytest. What a leg leaves of numpy's, OpenBLAS's and torch's kernels is printed
beside its result; a leg that would change nothing on this machine says so and is left out.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

LEFT = """
import os
import numpy as np
print("numpy", *np.show_config(mode="dicts")["SIMD Extensions"].get("found", ["baseline"]), end="")
try:
    import torch
    torch.set_num_threads(int(os.environ.get("NPSS_THREADS", torch.get_num_threads())))
    print("; torch", torch.backends.cpu.get_cpu_capability(), "with", torch.get_num_threads(), "threads", end="")
except ImportError:
    pass
"""


def legs() -> dict[str, dict[str, str]]:
    """Return the variables that make this machine another one."""
    # The names differ between versions of numpy, which refuses those of its baseline and warns of those it lacks.
    found = np.show_config(mode="dicts")["SIMD Extensions"].get("found", [])
    wide = [name for name in found if name.startswith(("AVX512", "X86_V4"))]
    return {
        "OpenBLAS for Haswell": {"OPENBLAS_CORETYPE": "Haswell"},
        "OpenBLAS for Prescott": {"OPENBLAS_CORETYPE": "Prescott"},
        "numpy without AVX-512": {"NPY_DISABLE_CPU_FEATURES": " ".join(wide)},
        "numpy without AVX-512 and AVX2": {"NPY_DISABLE_CPU_FEATURES": " ".join(found)},
        "torch without AVX2": {"ATEN_CPU_CAPABILITY": "default"},
        "oneDNN for SSE4.1": {"ONEDNN_MAX_CPU_ISA": "SSE41"},
        "one thread": {"OMP_NUM_THREADS": "1"},
        "four threads": {"OMP_NUM_THREADS": "4", "NPSS_THREADS": "4"},
    }


def run(name: str, variables: Mapping[str, str]) -> bool:
    """Run the tests of one leg and print how it went; say whether all passed."""
    if not all(variables.values()):
        print(f"{name}: nothing to turn off on this machine", flush=True)
        return True
    files = [
        str(path)
        for path in sorted(Path("tests").rglob("test_*.py"))
        if "mark.numeric" in path.read_text(encoding="utf-8")
    ]
    environment = {"OMP_NUM_THREADS": "1", "NPSS_HYPOTHESIS": "few"} | os.environ | variables
    start = time.monotonic()
    left = subprocess.run(
        [sys.executable, "-c", LEFT],
        env=environment | {"OPENBLAS_VERBOSE": "2"},
        capture_output=True,
        encoding="utf-8",
        check=True,
    )
    tests = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:randomly", "-m", "numeric", *files, *sys.argv[1:]],
        env=environment,
        capture_output=True,
        encoding="utf-8",
        check=False,
    )
    passed = tests.returncode == 0
    report = tests.stdout.strip().splitlines()[-1] if passed else tests.stdout + tests.stderr
    kernels = f"{left.stdout}; OpenBLAS {left.stderr.strip()}"
    print(f"{name} ({kernels}): {report} ({time.monotonic() - start:.0f} s in all)", flush=True)
    return passed


def main() -> int:
    """Run all legs, two at once where there are two processors; that with several threads by itself."""
    chosen = legs()
    alone = {name: chosen.pop(name) for name in ("four threads",)}
    with ThreadPoolExecutor(min(2, os.cpu_count() or 1)) as pool:
        passed = list(pool.map(run, chosen, chosen.values()))
    passed += [run(name, variables) for name, variables in alone.items()]
    return 0 if all(passed) else 1


if __name__ == "__main__":
    sys.exit(main())
