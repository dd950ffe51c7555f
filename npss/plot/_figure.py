"""A figure that looks the same under any user settings; the only module that needs matplotlib."""

from __future__ import annotations

import io
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
    """Use matplotlib's default settings in the block, and restore the user's."""
    with mpl.rc_context():
        mpl.rcdefaults()
        yield


class Picture(Figure):
    """A figure drawn by matplotlib's default settings, even where that happens late, as for ticks."""

    def draw(self, renderer: Any) -> None:
        """Draw the figure."""
        with defaults():
            super().draw(renderer)

    def savefig(self, fname: Any, **options: Any) -> None:
        """Write the figure to a file."""
        with defaults():
            super().savefig(fname, **options)

    def _repr_png_(self) -> bytes:
        """Show the figure in a notebook."""
        image = io.BytesIO()
        self.savefig(image, format="png", dpi=100)
        return image.getvalue()
