"""Notices when training becomes many times slower than it was at first."""

from __future__ import annotations

import statistics

_STEPS = 5  # least number of steps to compare: their median ignores a few that were stopped or disturbed
_FIRST, _LATER = 1.0, 30.0  # least seconds that the first steps take together, and those compared with them
_SLOWER = 3.0  # times


class Pace:
    """The pace of training, by its steps.

    Examples
    --------
    >>> pace = Pace()
    >>> durations = [9.0] + [1.0] * 35 + [8.0] * 5 + [9.0] * 99  # the first step also prepares things
    >>> [slower for seconds in durations if (slower := pace(seconds, 1.0))]
    [8.0]
    """

    def __init__(self) -> None:
        self._normal: float | None = None  # seconds per unit of work at first
        self._prepared = self._told = False
        self._restart()

    def __call__(self, seconds: float, work: float) -> float | None:
        """Add a step; return how many times slower training has become, once, when that is many times.

        Parameters
        ----------
        seconds : float
            How long the step took.
        work : float
            The amount of computation in it, in any unit.

        Returns
        -------
        float or None
            The factor, at least 3.
        """
        if self._told:
            return None
        if not self._prepared:
            self._prepared = True
            return None
        self._seconds += seconds
        self._paces.append(seconds / work)
        if len(self._paces) < _STEPS or self._seconds < (_FIRST if self._normal is None else _LATER):
            return None
        pace = statistics.median(self._paces)
        self._restart()
        if self._normal is None:
            self._normal = pace
            return None
        slower = pace / self._normal
        self._told = slower >= _SLOWER
        return slower if self._told else None

    def _restart(self) -> None:
        self._paces: list[float] = []
        self._seconds = 0.0
