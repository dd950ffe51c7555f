"""Signals that stop training, at the end of a step and with a checkpoint."""

from __future__ import annotations

import signal
import threading
from types import FrameType, TracebackType

# Ctrl-C, `kill`, a closed terminal, and the signals that batch systems send before a job's time ends.
_SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGUSR1", "SIGUSR2")


class Stopped(BaseException):
    """Raised when a signal has stopped training.

    Attributes
    ----------
    signal : signal.Signals
        The signal.
    """

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.signal = signal.Signals(number)


class Stop:
    """A block that defers signals: it remembers the first, and raises `Stopped` at the second.

    Signals that are already handled, or ignored, as by ``nohup``, are left alone; so are all signals outside the main
    thread.

    Attributes
    ----------
    received : int or None
        The signal received.
    """

    def __init__(self) -> None:
        self.received: int | None = None
        self._before: dict[int, object] = {}

    def check(self) -> None:
        """Raise `Stopped` if a signal was received."""
        if self.received is not None:
            raise Stopped(self.received)

    def _handle(self, number: int, frame: FrameType | None) -> None:
        self.check()
        self.received = number

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
