"""Pictures of scores and their parts, drawn by matplotlib (extra ``plot``).

Each function returns a `matplotlib.figure.Figure`, made without pyplot and windows and by matplotlib's default
settings, which no ``matplotlibrc`` changes. Its `savefig` writes SVG, PDF or PNG. Each picture states units and
signatures.
"""

from __future__ import annotations

from npss.plot._contributions import contributions
from npss.plot._errors import errors
from npss.plot._film_strip import film_strip
from npss.plot._models import models
from npss.plot._sensitivity import sensitivity
from npss.plot._spectra import spectra

__all__ = ["contributions", "errors", "film_strip", "models", "sensitivity", "spectra"]
