"""The file of a trained restorer: arrays and a header, in one ``.npz`` file."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from npss.files import parse_json, write_stream_atomically
from npss.validation import Array
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.model.gaussian import SpanGaussian
from npss_baselines.manifold.motion.scaling import Scaling
from npss_baselines.manifold.restorers.by_case import VERSION, ByCase
from npss_baselines.manifold.restorers.camera import Camera
from npss_baselines.manifold.restorers.fill import Fill
from npss_baselines.manifold.restorers.interpolation import Interpolation
from npss_baselines.manifold.restorers.keys import Keys
from npss_baselines.manifold.restorers.net import Net
from npss_baselines.manifold.restorers.restorer import Restorer

__all__ = ["default", "load", "save"]

#: The file in the package, if it ships one.
SHIPPED = Path(__file__).with_name("restorer.npz")
_CASES = ("fill", "keys", "camera")


def default() -> Restorer:
    """Return the restorer of the package: the trained one, if the package has its file, else interpolation by cubics.

    Returns
    -------
    Restorer
        See `npss_baselines.manifold.restorers.restorer`.

    Raises
    ------
    ValueError
        If the file is broken.

    Examples
    --------
    >>> isinstance(default().signature, str)
    True
    """
    return load(SHIPPED) if SHIPPED.exists() else Interpolation("hermite")


def save(path: Path, restorer: ByCase) -> None:
    """Write a trained restorer, atomically.

    Weights, and the Cholesky factors of covariances, are rounded to half precision.

    Parameters
    ----------
    path : Path
        The ``.npz`` file.
    restorer : ByCase
        The restorer, of the skeleton `npss_baselines.data.motion.JOINTS`.

    Raises
    ------
    ValueError
        If the skeleton is another one, or a weight is too large for half precision.
    """
    if restorer.skeleton is not JOINTS:
        raise ValueError("restorer: only restorers of the skeleton JOINTS are stored")
    arrays: dict[str, Array] = {
        "scaling.mean": restorer.keys.scaling.mean,
        "scaling.scale": restorer.keys.scaling.scale,
    }
    for name, gaussian in (("span", restorer.gaussian), ("pose", restorer.fill.pose)):
        arrays |= {
            f"{name}.mean": gaussian.mean,
            f"{name}.root": np.linalg.cholesky(gaussian.covariance)[np.tril_indices(len(gaussian.mean))].astype(
                np.float16
            ),
        }
    arrays["fill.sets"] = restorer.fill.sets.astype(np.float16)
    counts = {}
    for case in _CASES:
        nets = getattr(restorer, case).nets
        counts[case] = [len(net.weights) for net in nets]
        for number, net in enumerate(nets):
            for layer, (weight, bias) in enumerate(zip(net.weights, net.biases, strict=True)):
                arrays[f"{case}.{number}.{layer}.weight"] = weight.astype(np.float16)
                arrays[f"{case}.{number}.{layer}.bias"] = bias.astype(np.float16)
    for name, array in arrays.items():
        if not np.isfinite(array).all():
            raise ValueError(f"restorer: {name} has values that are not finite in half precision")
    header = {"version": VERSION, "span": restorer.gaussian.span, "nets": counts, "seen": restorer.seen}
    arrays["header"] = np.array(json.dumps(header))
    write_stream_atomically(path, lambda stream: np.savez_compressed(stream, allow_pickle=False, **arrays))


def load(path: Path) -> ByCase:
    """Read a trained restorer; the file cannot run code.

    Parameters
    ----------
    path : Path
        Written by `save`, or by ``npss-baselines train restorer``.

    Returns
    -------
    ByCase
        The restorer.

    Raises
    ------
    FileNotFoundError
        If the file does not exist.
    ValueError
        If it is not such a file, of another version, or broken. The message names it.
    """
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
            header = parse_json(file["header"].item())
            arrays = {name: np.asarray(file[name]) for name in file.files if name != "header"}
        if header["version"] != VERSION:
            raise ValueError(f"version {header['version']}, not {VERSION}")
        for name, array in arrays.items():
            if array.dtype.kind != "f" or not np.isfinite(array).all():
                raise ValueError(f"{name}: expected finite numbers")
        return _restorer(header, arrays)
    except (ValueError, TypeError, KeyError, AttributeError, EOFError, zipfile.BadZipFile) as error:
        raise ValueError(f"{path}: not a trained restorer: {error}") from error


def _restorer(header: Mapping[str, Any], arrays: Mapping[str, Array]) -> ByCase:
    n_features = 3 * len(JOINTS.names) + 3
    scaling = Scaling(*(_shaped(arrays, f"scaling.{name}", n_features) for name in ("mean", "scale")))
    gaussians = {}
    for name, span in (("span", int(header["span"])), ("pose", 1)):
        size = span * n_features
        root = np.zeros((size, size))
        root[np.tril_indices(size)] = _shaped(arrays, f"{name}.root", size * (size + 1) // 2)
        if not (np.diag(root) > 0).all():
            raise ValueError(f"{name}.root: expected positive numbers on the diagonal")
        gaussians[name] = SpanGaussian(span, _shaped(arrays, f"{name}.mean", size), root @ root.T, scaling)
    nets = {
        case: tuple(
            Net(
                *(
                    tuple(arrays[f"{case}.{number}.{i}.{part}"].astype(np.float32) for i in range(layers))
                    for part in ("weight", "bias")
                )
            )
            for number, layers in enumerate(header["nets"][case])
        )
        for case in _CASES
    }
    sets = arrays["fill.sets"]
    if sets.ndim != 2 or sets.shape[1] != len(JOINTS.names):
        raise ValueError(f"fill.sets: expected {len(JOINTS.names)} columns, got {sets.shape}")
    return ByCase(
        gaussians["span"],
        Fill(gaussians["pose"], nets["fill"], sets > 0),
        Keys(scaling, nets["keys"]),
        Camera(scaling, nets["camera"]),
        seen=header["seen"],
    )


def _shaped(arrays: Mapping[str, Array], name: str, size: int) -> Array:
    array = arrays[name].astype(np.float64)
    if array.shape != (size,):
        raise ValueError(f"{name}: expected shape ({size},), got {array.shape}")
    return array
