"""The figure that looks the same whatever the user's settings are; the one module that needs matplotlib."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from npss.extras import install_hint

try:
    import matplotlib as mpl
    from matplotlib.figure import Figure
except ImportError:
    raise ImportError(f"npss.plot needs matplotlib; {install_hint('plot')}") from None


@contextmanager
def defaults() -> Iterator[None]:
    """Let matplotlib's own settings be in force, and then the user's again."""
    with mpl.rc_context():
        mpl.rcdefaults()
        yield


class Picture(Figure):
    """A figure that is drawn by matplotlib's own settings: ticks, for one, are made when it is drawn."""

    def draw(self, renderer: Any) -> None:
        """Draw it."""
        with defaults():
            super().draw(renderer)

    def savefig(self, fname: Any, **options: Any) -> None:
        """Write it to a file."""
        with defaults():
            super().savefig(fname, **options)
