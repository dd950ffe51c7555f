"""Run the command ``npss``, and write samples for it."""

import pytest

from npss.commands import main


def run(capsys, *arguments):
    """Return exit status, standard output and standard error."""
    try:
        status = main([str(argument) for argument in arguments])
    except SystemExit as end:
        status = end.code
    captured = capsys.readouterr()
    return status, captured.out, captured.err


def samples(poses, curve=None, action="walking"):
    arrays = {}
    for kind, motion in zip(("gt", "preds"), poses, strict=True):
        for index, sample in enumerate(motion):
            arrays[f"expmap/{kind}/{action}_{index}"] = sample
    if curve is not None:
        arrays[f"mean_{action}_error"] = curve
    return arrays


def write_h5(path, arrays):
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        for name, array in arrays.items():
            file[name] = array
    return path
