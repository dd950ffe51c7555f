"""Pictures of scores and of what they are made of; matplotlib draws them (extra ``plot``).

Each function returns a `matplotlib.figure.Figure`, made without pyplot and windows, and by matplotlib's own settings,
whatever a ``matplotlibrc`` says; its `savefig` writes SVG, PDF or PNG. What the numbers are is in the picture: units,
and the signature.
"""

from __future__ import annotations

from npss.plot._contributions import contributions
from npss.plot._errors import errors
from npss.plot._film_strip import film_strip
from npss.plot._sensitivity import sensitivity
from npss.plot._spectra import spectra

__all__ = ["contributions", "errors", "film_strip", "sensitivity", "spectra"]
