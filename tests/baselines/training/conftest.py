"""A model that is quick to train."""

import pytest


@pytest.fixture
def _tiny():
    """Add the model to the registry."""
    import trainings
    from npss_baselines.models import MODELS
    from registered import registered

    with registered(MODELS, tiny=trainings.TINY):
        yield
