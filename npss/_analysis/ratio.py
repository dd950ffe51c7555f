"""The ratio of two errors on the same sequences, with a paired interval."""

from __future__ import annotations

from collections.abc import Iterable

import numpy.typing as npt

from npss._analysis.blocks import Blocks, Label, read_groups
from npss._analysis.interval import Interval, Range, interval
from npss.validation import Float64, Seed, check_finite, real_array


def ratio_interval(
    a: npt.ArrayLike,
    b: npt.ArrayLike,
    *,
    groups: Iterable[Label | None] | None = None,
    level: float = 0.95,
    seed: Seed = 0,
) -> Interval | Range:
    """Return the confidence interval of the ratio of two errors, summed over the same sequences.

    Parameters
    ----------
    a, b : (N,) array_like
        What each sequence adds to either error, such as sums of distances; not negative.
    groups : sequence of str, int or None, optional
        A label for each sequence. Sequences with the same label depend on each other and are one block; sequences with
        None do not count. By default sequences are assumed to be independent.
    level : float, optional
        The confidence level.
    seed : int or numpy.random.Generator, optional
        The seed of the generator.

    Returns
    -------
    Interval or Range
        The interval of ``sum(a) / sum(b)``, by a studentised bootstrap over blocks: both errors are drawn together, so
        that it is paired. With fewer than ten blocks, the lowest and the highest ratio of a block.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid, the numbers differ in length, or `b` is 0 in all blocks.

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> b = np.arange(1.0, 21.0)
    >>> npss.ratio_interval(0.5 * b, b)
    Interval(low=0.5, high=0.5)
    """
    sums: list[Float64] = []
    for name, values in (("a", a), ("b", b)):
        array = real_array(name, values)
        if array.ndim != 1 or not len(array):
            raise ValueError(f"{name}: expected shape (N,), got {array.shape}")
        check_finite(name, array)
        if (array < 0).any():
            raise ValueError(f"{name}: expected errors of at least 0, got {array.min()} at {int(array.argmin())}")
        sums.append(array.astype("float64"))
    if len(sums[0]) != len(sums[1]):
        raise ValueError(f"b: expected {len(sums[0])} errors, as many as a has, got {len(sums[1])}")
    blocks = Blocks(read_groups("groups", groups, len(sums[0])), sums[1])
    return interval(sums[0], sums[1], blocks, level=level, seed=seed)
