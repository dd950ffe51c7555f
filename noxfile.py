"""The checks by name: ``nox`` lists them, ``nox -s tests lint`` runs some, in the environment that nox is in.

What a check does is said in ``.ci``, once: ``.ci/run``, which decides, runs the same scripts.
"""

from __future__ import annotations

import nox

nox.options.sessions = ["tests", "lint", "docs"]
nox.options.default_venv_backend = "none"
CHECKS = {
    "tests": (["pytest", "-q", "-n", "logical"], "Run the tests."),
    "oldest": ([".ci/oldest"], "Run the core's tests with the oldest versions that are promised."),
    "newest": ([".ci/thorough", "newest"], "Run the tests with the newest versions."),
    "machines": ([".ci/machines.py"], "Run the numeric tests as other machines would."),
    "lint": ([".ci/lint"], "Check style, types and layers."),
    "docs": ([".ci/docs"], "Build the documentation, with warnings as errors."),
    "commands": ([".ci/thorough", "commands"], "Every command of every page; needs folders of motion."),
    "mutation": ([".ci/thorough", "mutants"], "Change the code place by place; each change must fail a test."),
    "wheels": ([".ci/wheels", "dist"], "Build both wheels and check them."),
    "all": ([".ci/run"], "Run what decides, in fresh environments."),
}


def _add(name: str, command: list[str], description: str) -> None:
    def check(session: nox.Session) -> None:
        session.run(*command, *session.posargs, external=True)

    check.__doc__ = description
    nox.session(name=name)(check)


for _name, (_command, _description) in CHECKS.items():
    _add(_name, _command, _description)
