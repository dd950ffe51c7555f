#!/usr/bin/env python3
"""Change the library's code in one place at a time, and see whether a test notices: a seeded sample of mutants.

The mutants are cosmic-ray's (``pip install cosmic-ray``), of which each place in a group of modules gives at most one.
They are drawn by a hash of the function, the line and the seed, so a change elsewhere draws no others. Each is
written into a copy of the checkout and meets the test files of its module, the quick tests first, in a process of its
own with a limit on its time; the first test that fails, or the limit, kills it. The mutants that no test can kill are
listed, with the reason, in ``equivalent_mutants.toml``.

Ends with status 1 if the tests kill less than 95 % of those that are not listed, or more than 10 % are listed.
"""

from __future__ import annotations

import argparse
import ast
import difflib
import hashlib
import importlib.util
import itertools
import json
import os
import resource
import shutil
import signal
import sys
import tempfile
import time
import tomllib
import traceback
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).resolve().parent.parent

#: The modules of each group, with the test files that cover them.
GROUPS: dict[str, dict[str, str]] = {
    "metric": {
        "_metric/convention.py _metric/exact_sum.py _metric/kernel.py _metric/power.py": (
            "metric/score metric/exact_sum metric/kernel metric/parts"
        ),
        "_metric/accumulator.py _metric/contributions.py _metric/frames.py _metric/score.py": (
            "metric/score metric/accumulator metric/frames metric/workers analysis/report"
        ),
        "_metric/metric.py _metric/registry.py": "metrics",
        "_metric/parts.py _analysis/pitfalls/parts.py": "metric/parts analysis/diagnose analysis/report",
        "_metric/speed.py": "metric/speed",
        "_metric/joints.py _metric/position_error.py _metric/times.py": "metric/position_error",
        "_metric/rotation_error.py": "metric/rotation_error",
        "_metric/spectrum.py": "metric/spectrum",
        "_metric/foot_skating.py": "metric/foot_skating",
        "stochastic/_*.py": "stochastic/distances stochastic/score",
    },
    "rotations": {
        "rotations/_[!pu]*.py": (
            "rotations/rotations rotations/accuracy rotations/euler rotations/legacy rotations/continuous "
            "rotations/sixd rotations/slerp"
        ),
        "rotations/_unwrap.py": "rotations/unwrap",
        "rotations/_poses.py _metric/euler_error.py": "rotations/poses metric/euler_error",
    },
    "skeleton": {"skeleton.py": "skeleton"},
    "statistics": {
        "_analysis/blocks.py": "analysis/blocks",
        "_analysis/bootstrap.py _analysis/interval.py": "analysis/bootstrap analysis/compare analysis/report",
        "_analysis/compare.py _analysis/sign_flip.py": "analysis/compare analysis/bootstrap analysis/blocks metrics",
        "_analysis/ties.py": "analysis/ties study/metrics",
        "ranking/_methods.py": "ranking/methods",
        "ranking/_standings.py": "ranking/standings ranking/leaderboard",
        "study/_agreement.py study/_intervals.py study/_paired.py study/_two_samples.py": "study/tests study/metrics",
        "study/_ranking.py": "study/metrics",
        "study/_design.py study/_planning.py": "study/design study/planning",
        "study/_kappa.py study/_votes.py": "study/votes",
    },
}
SHARE_KILLED, SHARE_LISTED = 0.95, 0.10
MEMORY = 4 * 2**30  # bytes that a process may take
LOG = "tests.log"  # what the last run printed, in the copy of the checkout
FIELDS = ("function", "before", "after")  # of the list of equivalent mutants
SECONDS = Path("seconds.json")  # how long each test takes


class Mutant(NamedTuple):
    """One change: `before` and `after` are the lines that it changes, without indentation."""

    path: Path  # in the checkout
    function: str  # or class, by its qualified name; '' for the module's own code
    before: str
    after: str
    code: str
    original: str

    @property
    def key(self) -> tuple[str, str, str]:
        """What the list of equivalent mutants knows it by."""
        return self.function, self.before, self.after


def sample(paths: list[Path], size: int, seed: int) -> list[Mutant]:
    """Draw mutants, at most one of each place in the code while there are places enough."""
    drawn = []  # (turn, hash, ...): the first mutant of every place, then the second ones, ...
    for path in paths:
        places: dict[tuple[int, int], list[tuple[str, str, int, str]]] = {}
        lines = (ROOT / path).read_text(encoding="utf-8").splitlines()
        names = _Names(ast.parse("\n".join(lines)))
        for operator, occurrence, start in _changes(ROOT / path):
            if not names.is_annotation(start):
                text = f"{seed} {names.function(start[0])} {lines[start[0] - 1].strip()} {start[1]} {operator}"
                order = hashlib.sha256(f"{text} {occurrence}".encode()).hexdigest()
                places.setdefault(start, []).append((order, operator, occurrence, names.function(start[0])))
        for changes in places.values():
            drawn += [(turn, *change, path) for turn, change in enumerate(sorted(changes))]
    made: dict[tuple[str, str, str], Mutant] = {}
    for _, _, operator, occurrence, function, path in sorted(drawn):
        if len(made) == size:
            break
        mutant = _mutant(path, operator, occurrence, function)
        if mutant is not None:
            made.setdefault(mutant.key, mutant)
    return list(made.values())


def _changes(path: Path) -> Iterator[tuple[str, int, tuple[int, int]]]:
    """Yield operator, occurrence and place of every mutant that cosmic-ray makes of a file."""
    from cosmic_ray import plugins
    from cosmic_ray.ast import ast_nodes, get_ast

    nodes = list(ast_nodes(get_ast(path.read_text(encoding="utf-8"))))
    for name in plugins.operator_names():
        operator = plugins.get_operator(name)
        if not operator.arguments():
            made = operator()
            starts = [start for node in nodes for start, _ in made.mutation_positions(node)]
            yield from ((name, occurrence, start) for occurrence, start in enumerate(starts))


def _mutant(path: Path, operator: str, occurrence: int, function: str) -> Mutant | None:
    from cosmic_ray import plugins
    from cosmic_ray.mutating import mutate_code

    code = (ROOT / path).read_text(encoding="utf-8")
    changed = mutate_code(code, plugins.get_operator(operator)(), occurrence)
    try:
        if changed is None or ast.dump(ast.parse(changed)) == ast.dump(ast.parse(code)):
            return None
    except SyntaxError:
        return None
    lines = list(difflib.ndiff(code.splitlines(), changed.splitlines()))
    before, after = (" ".join(line[2:].strip() for line in lines if line.startswith(sign)) for sign in "-+")
    return Mutant(path, function, before, " ".join(after.split()), changed, code)


class _Names:
    """Which function a line belongs to, and what is an annotation, which is never evaluated."""

    def __init__(self, tree: ast.Module) -> None:
        self._functions: list[tuple[int, int, str]] = []
        self._annotations: list[ast.expr] = []
        self._visit(tree, "")

    def _visit(self, node: ast.AST, name: str) -> None:
        for child in ast.iter_child_nodes(node):
            inner = name
            if isinstance(child, ast.FunctionDef | ast.ClassDef):
                inner = f"{name}.{child.name}".lstrip(".")
                first = min([child.lineno, *(decorator.lineno for decorator in child.decorator_list)])
                self._functions.append((first, child.end_lineno or first, inner))
            for field in ("annotation", "returns"):
                if (annotation := getattr(child, field, None)) is not None:
                    self._annotations.append(annotation)
            self._visit(child, inner)

    def function(self, line: int) -> str:
        """Return the innermost function or class of a line."""
        return max((first, name) for first, last, name in [(0, line, ""), *self._functions] if first <= line <= last)[1]

    def is_annotation(self, place: tuple[int, int]) -> bool:
        """Say whether a place, (line, column), is in an annotation."""
        return any(
            (one.lineno, one.col_offset) <= place < (one.end_lineno or 0, one.end_col_offset or 0)
            for one in self._annotations
        )


class _Plugin:
    """Run quick tests first; and do without a simple counterexample where the first one will do."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self.is_known = SECONDS.exists()
        if self.is_known:
            self.seconds = json.loads(SECONDS.read_text(encoding="utf-8"))

    def pytest_sessionstart(self) -> None:
        from hypothesis import Phase, settings

        settings.register_profile("unshrunk", settings.get_profile("npss"), phases=[Phase.explicit, Phase.generate])
        settings.load_profile("unshrunk")

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        items.sort(key=lambda item: self.seconds.get(item.nodeid, 0.0))

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self.seconds[report.nodeid] = self.seconds.get(report.nodeid, 0.0) + report.duration

    def pytest_sessionfinish(self) -> None:
        if not self.is_known:
            SECONDS.write_text(json.dumps(self.seconds), encoding="utf-8")


def passes(tests: list[str], seconds: float) -> tuple[bool, float]:
    """Run test files in a process of their own; say whether all passed, and how much processor time they took."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    child = os.fork()
    if child == 0:
        os.setsid()
        resource.setrlimit(resource.RLIMIT_CPU, (int(seconds), int(seconds) + 5))
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        log = os.open(LOG, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        for descriptor in (1, 2):
            os.dup2(log, descriptor)
        status = 70
        try:
            options = ["-x", "-q", "--no-header", "-p", "no:cacheprovider", "-p", "no:randomly"]
            options += ["-W", "ignore:Module already imported"]
            status = pytest.main([*options, *tests], plugins=[_Plugin()])
        except BaseException:
            traceback.print_exc()
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(int(status))
    deadline = time.monotonic() + 20 * seconds  # for what waits instead of computing
    while True:
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            break
        if time.monotonic() > deadline:
            os.killpg(child, signal.SIGKILL)
        time.sleep(0.02)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return status == 0, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def write(path: Path, code: str) -> None:
    """Write code, and drop the bytecode: to Python, two mutants of one size and one second look the same."""
    path.write_text(code, encoding="utf-8")
    Path(importlib.util.cache_from_source(str(path))).unlink(missing_ok=True)


def files(folder: str, patterns: str) -> list[Path]:
    """Return the files of the checkout that patterns, separated by blanks, stand for."""
    return [path.relative_to(ROOT) for pattern in patterns.split() for path in sorted((ROOT / folder).glob(pattern))]


def run(group: str, size: int, seed: int, equivalent: set[tuple[str, str, str]], only: str) -> bool:
    """Test a sample of the mutants of a group; say whether enough are killed."""
    tests, paths = {}, []
    for modules, names in GROUPS[group].items():
        paths += files("npss", modules)
        folders = (one.rpartition("/") for one in names.split())
        covering = [str(Path("tests/npss", folder, f"test_{name}.py")) for folder, _, name in folders]
        tests |= {path: list(dict.fromkeys(covering)) for path in files("npss", modules)}
    mutants = [one for one in sample(paths, size, seed) if only in str(one)]
    rest = [one for one in mutants if one.key not in equivalent]
    print(f"{group}: {len(mutants)} mutants, {len(mutants) - len(rest)} of them listed as equivalent", flush=True)
    n_killed = 0
    rest.sort(key=lambda one: (tests[one.path], one.path))
    for covering, chosen in itertools.groupby(rest, lambda one: tests[one.path]):
        SECONDS.unlink(missing_ok=True)
        passed, seconds = passes(covering, 3600)
        if not passed:
            raise SystemExit(f"{Path(LOG).read_text(encoding='utf-8')}\nthe tests fail without any mutant")
        print(f"{' '.join(covering)}: {seconds:.0f} s", flush=True)
        for mutant in chosen:
            write(mutant.path, mutant.code)
            passed, _ = passes(covering, 3 * seconds + 20)
            write(mutant.path, mutant.original)
            n_killed += not passed
            if passed:
                lines = (mutant.function, mutant.before, mutant.after)
                fields = [f"{name} = '''{line}'''" for name, line in zip(FIELDS, lines, strict=True)]
                print(f"[[mutant]]  # of {mutant.path} survives", *fields, sep="\n", flush=True)
    share = n_killed / max(1, len(rest))
    print(f"{group}: {n_killed} of {len(rest)} killed, {share:.1%}", flush=True)
    return share >= SHARE_KILLED and len(mutants) - len(rest) <= SHARE_LISTED * len(mutants)


def main() -> int:
    """Read the command line, copy the checkout, and run the groups."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("groups", nargs="*", metavar="GROUP", help=f"of {', '.join(GROUPS)} (default: all)")
    parser.add_argument("--sample", type=int, default=150, metavar="N", help="mutants of each group (default: 150)")
    parser.add_argument("--seed", type=int, default=0, help="draws another sample (default: 0)")
    parser.add_argument("--only", default="", metavar="TEXT", help="those whose path, function or text holds TEXT")
    options = parser.parse_args()
    if unknown := set(options.groups) - set(GROUPS):
        parser.error(f"GROUP: expected {', '.join(GROUPS)}, got {', '.join(sorted(unknown))}")
    with (ROOT / ".ci" / "equivalent_mutants.toml").open("rb") as file:
        listed = tomllib.load(file).get("mutant", [])
    equivalent = {(one["function"], one["before"], one["after"]) for one in listed if one["reason"]}
    os.environ["OMP_NUM_THREADS"] = "1"
    with tempfile.TemporaryDirectory() as folder:
        for name in ("npss", "baselines", "tests", "docs", "pyproject.toml"):
            copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
            copy(ROOT / name, Path(folder) / name)
        for cache in Path(folder).rglob("__pycache__"):
            shutil.rmtree(cache)
        os.chdir(folder)
        packages = [folder, str(Path(folder, "baselines"))]
        sys.path[:0] = packages
        os.environ["PYTHONPATH"] = os.pathsep.join(packages)
        import hypothesis  # noqa: F401 - here, so that no process has to
        import scipy.stats  # noqa: F401

        results = [
            run(group, options.sample, options.seed, equivalent, options.only) for group in options.groups or GROUPS
        ]
    return 0 if all(results) else 1


if __name__ == "__main__":
    sys.exit(main())
