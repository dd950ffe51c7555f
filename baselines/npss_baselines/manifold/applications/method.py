"""What names a way of doing something: a manifold or a baseline, and what is done differently."""

from __future__ import annotations

from typing import NamedTuple


class Method(NamedTuple):
    """A way of doing something, which records name by ``str(method)``.

    Attributes
    ----------
    name : str
        Of the manifold or the baseline; it has no comma.
    variant : str
        What is done differently from what the name alone means; mostly nothing.

    Examples
    --------
    >>> str(Method("pca", "rescaled")), str(Method("linear"))
    ('pca, rescaled', 'linear')
    >>> Method.parse("pca, rescaled")
    Method(name='pca', variant='rescaled')
    """

    name: str
    variant: str = ""

    @classmethod
    def parse(cls, text: str) -> Method:
        """Return the method that a record names."""
        return cls(*text.split(", ", 1))

    def __str__(self) -> str:
        return ", ".join(filter(None, self))
