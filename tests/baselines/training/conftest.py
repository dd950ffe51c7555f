"""A model that is quick to train."""

import pytest

import trainings
from npss_baselines.models import MODELS


@pytest.fixture
def _tiny(monkeypatch):
    """Add the model to the registry."""
    monkeypatch.setitem(MODELS, "tiny", trainings.TINY)
