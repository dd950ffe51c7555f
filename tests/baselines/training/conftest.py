"""A model that is quick to train."""

import pytest

import trainings
from npss_baselines.models import MODELS
from registered import registered


@pytest.fixture
def _tiny():
    """Add the model to the registry."""
    with registered(MODELS, tiny=trainings.TINY):
        yield
