"""Processes that train and may be killed."""

import multiprocessing
import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def processes():
    """Processes that start with everything imported."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["trainings", "manifold_trainings"])
    helpers = Path(__file__).parents[1] / "helpers"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", str(helpers), prepend=os.pathsep)  # for the helper modules
        yield context
