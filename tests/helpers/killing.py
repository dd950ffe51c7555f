"""A process that kills itself at an event, as a machine that fails would."""

import os
import signal
from pathlib import Path


def kill_at(moment, number, owner, name, step):
    """Let this process kill itself at the n-th event of a kind.

    Parameters
    ----------
    moment : str
        The kind: ``'writing'``, before a file is renamed to its place, of which half is then there; ``'written'``,
        after that; or `step`, before a call of `owner`'s attribute `name`.
    number : int
        Which event, from 1.
    """
    remaining = [number]

    def count_down():
        remaining[0] -= 1
        if remaining[0] == 0:
            os.kill(os.getpid(), signal.SIGKILL)

    rename, call = Path.replace, getattr(owner, name)

    def replace_file(part, target):
        if moment == "writing":
            if remaining[0] == 1:  # half of it is written
                os.truncate(part, part.stat().st_size // 2)
            count_down()
        rename(part, target)
        if moment == "written":
            count_down()

    def begin(*arguments, **options):
        if moment == step:
            count_down()
        return call(*arguments, **options)

    Path.replace = replace_file
    setattr(owner, name, begin)
