"""Names of methods: a manifold or a baseline, and a variant."""

from __future__ import annotations

from typing import NamedTuple


class Method(NamedTuple):
    """A method, which records name as ``str(method)``.

    Attributes
    ----------
    name : str
        The manifold or the baseline; without a comma.
    variant : str
        A variant of the method; empty for none.

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
        """Parse the method of a record."""
        return cls(*text.split(", ", 1))

    def __str__(self) -> str:
        return ", ".join(filter(None, self))
