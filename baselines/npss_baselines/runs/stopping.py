"""Signals that ask training to end: it does so at the end of the step, with a checkpoint."""

from __future__ import annotations

import signal
import threading
from types import FrameType, TracebackType

# Ctrl-C, a closed terminal, `kill`, and what batch systems send before a job's time is over.
_SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGUSR1", "SIGUSR2")


class Stopped(BaseException):
    """A signal has ended the work.

    Attributes
    ----------
    signal : signal.Signals
        Which.
    """

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.signal = signal.Signals(number)


class Stop:
    """What a signal has asked for, in a block: the first is remembered, the second raises `Stopped` at once.

    Signals that somebody else handles, or ignores, as ``nohup`` does, are left to them; in another thread than the main
    one, all are.

    Attributes
    ----------
    asked : int or None
        The signal that has come.
    """

    def __init__(self) -> None:
        self.asked: int | None = None
        self._before: dict[int, object] = {}

    def check(self) -> None:
        """Raise `Stopped` if a signal has come."""
        if self.asked is not None:
            raise Stopped(self.asked)

    def _handle(self, number: int, frame: FrameType | None) -> None:
        self.check()
        self.asked = number

    def __enter__(self) -> Stop:
        if threading.current_thread() is threading.main_thread():
            for number in (getattr(signal, name) for name in _SIGNALS if hasattr(signal, name)):
                if signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
                    self._before[number] = signal.signal(number, self._handle)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)  # type: ignore[arg-type]
