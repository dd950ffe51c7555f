"""Runs of fitted predictors: fit one, write it to a folder, and read it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from npss.extras import install_hint
from npss.files import write_bytes_atomically
from npss.validation import Seed, each, generator, one_of
from npss_baselines.data import SOURCES, PoseSource, pose_sources
from npss_baselines.data.windows import checked_seed
from npss_baselines.fitted import FITTED
from npss_baselines.fitted.base import Fitted, FittedPredictor
from npss_baselines.fitted.motion import read_motion
from npss_baselines.runs import config, weights

try:
    from safetensors import SafetensorError
    from safetensors.numpy import load as deserialized
    from safetensors.numpy import save as serialized
except ImportError:
    raise ImportError(f"trained models need safetensors; {install_hint('all', baselines=True)}") from None


@dataclass(frozen=True)
class FittedConfiguration:
    """Everything that a fitted predictor depends on, except the folder of the data.

    Attributes
    ----------
    name : str
        The name of the predictor, in `npss_baselines.fitted.FITTED`.
    settings : dataclass
        The settings of the fit.
    data : str
        The source of motion, in `npss_baselines.data.pose_sources`.
    actions : tuple of str
        The actions to predict.
    subjects : dict of str to tuple
        The training subjects that were read, by action; empty tuples for generated motion. A predictor may read other
        actions than those to predict.
    seed : int
        Seed of the fit.

    Raises
    ------
    TypeError, ValueError
        If a field is invalid; the message starts with its name.
    """

    name: str
    settings: Any
    data: str
    actions: tuple[str, ...]
    subjects: dict[str, tuple[Any, ...]]
    seed: int

    def __post_init__(self) -> None:
        one_of("name", self.name, tuple(FITTED))
        one_of("data", self.data, tuple(pose_sources()))
        checked_seed(self.seed)
        if not self.actions or len(set(self.actions)) < len(self.actions):
            raise ValueError(f"actions: expected one or more, without duplicates, got {self.actions}")
        for action in (*self.actions, *self.subjects):
            one_of("actions", action, self.source.actions)
        if list(self.subjects)[: len(self.actions)] != list(self.actions):
            raise ValueError(f"subjects: expected those of {', '.join(self.actions)} first, got {self.subjects}")

    @property
    def source(self) -> PoseSource:
        """The source of motion."""
        return pose_sources()[self.data]


@dataclass(frozen=True)
class FittedRun:
    """A fitted predictor with its configuration.

    Attributes
    ----------
    configuration : FittedConfiguration
        The configuration of the run.
    fitted : Fitted
        The predictor of angles.
    """

    configuration: FittedConfiguration
    fitted: Fitted

    def predictor(self, action: str, *, seed: Seed = 0) -> FittedPredictor:
        """Return the predictor of an action.

        Parameters
        ----------
        action : str
            An action that the predictor was fitted to.
        seed : int or numpy.random.Generator, optional
            Not used, as for all predictors without noise.

        Raises
        ------
        ValueError
            If the predictor was not fitted to the action.
        """
        generator(seed)
        actions = self.configuration.actions
        if action not in actions:
            raise ValueError(f"action: this predictor was fitted to {', '.join(actions)}, not to {action!r}")
        return FittedPredictor(self.fitted, actions.index(action))

    def save(self, folder: Path, *, paths: Mapping[str, Path] | None = None) -> None:
        """Write the run: ``config.json``, and what was fitted in ``model.safetensors``.

        Parameters
        ----------
        folder : Path
            The folder of the run, which exists.
        paths : mapping of str to Path, optional
            The folders of the data, by the names of their options.
        """
        write_bytes_atomically(folder / weights.FILE, serialized(self.fitted.arrays()))
        plugins = {FITTED.plugin(self.configuration.name), SOURCES.plugin(self.configuration.data)} - {None}
        config.write(folder / config.FILE, self.configuration, "cpu", paths, sorted(map(str, plugins)))


def fit(
    name: str,
    source: PoseSource,
    folder: Path,
    actions: Sequence[str],
    *,
    subjects: Sequence[Any] | Mapping[str, Sequence[Any]] | None = None,
    seed: int = 0,
    cache: Path | None = None,
    progress: Callable[[float], None] = lambda share: None,
) -> FittedRun:
    """Fit a predictor to training motion.

    Parameters
    ----------
    name : str
        The name of the predictor, in `npss_baselines.fitted.FITTED`.
    source : PoseSource
        The source of motion.
    folder : Path
        The folder of the data set; unused for generated motion.
    actions : sequence of str
        The actions to predict.
    subjects : sequence or dict of str to sequence, optional
        Training subjects, all of whose recordings of these actions must be there; by default, for each action, the
        training subjects whose recordings are. A dict names them for each action, also for others that the predictor
        reads, and all of them must be there.
    seed : int, optional
        Seed of the fit, from 0 to 2**32 - 1; `ridge` and ``nearest-10`` do not depend on it.
    cache : Path, optional
        A folder that caches parsed files.
    progress : callable, optional
        Called with the share of the work that is done.

    Returns
    -------
    FittedRun
        The fitted predictor, on one thread.

    Raises
    ------
    TypeError, ValueError, FileNotFoundError
        If an argument is invalid, or motion is missing or broken.
    """
    one_of("name", name, tuple(FITTED))
    spec = FITTED[name]
    actions = each("actions", actions, "names")
    motion, read = read_motion(source, folder, actions, subjects=subjects, others=spec.kind.others, cache=cache)
    configuration = FittedConfiguration(name, spec.settings, source.name, tuple(actions), read, checked_seed(seed))
    return FittedRun(configuration, spec.kind.fit(motion, spec.settings, seed=seed, progress=progress))


def load(folder: Path) -> FittedRun:
    """Read a run, without running code.

    Raises
    ------
    FileNotFoundError, ValueError
        If a file is missing, broken or does not match the other; names it.
    """
    configuration = read(config.file_in(folder))
    file = folder / weights.FILE
    if not file.exists():
        raise FileNotFoundError(f"{file}: no such file")
    try:
        arrays = deserialized(file.read_bytes())
        kind = FITTED[configuration.name].kind
        fitted = kind.restore(len(configuration.actions), configuration.settings, arrays)
    except (KeyError, SafetensorError, TypeError, ValueError) as error:
        raise ValueError(f"{file}: not what was fitted by {folder / config.FILE} ({error})") from error
    return FittedRun(configuration, fitted)


def read(path: Path) -> FittedConfiguration:
    """Read the configuration of a run.

    Raises
    ------
    FileNotFoundError, ValueError
        If the file is missing or invalid; names it.
    """
    values = config.read_fields(path)
    names = [field.name for field in fields(FittedConfiguration)]
    try:
        config.check_fields("", values, [*config.NOTES, *names])
        if missing := [name for name in names if name not in values]:
            raise ValueError(f"{missing[0]}: missing")
        one_of("name", values["name"], tuple(FITTED))
        settings = _settings(FITTED[values["name"]].settings, values["settings"])
        actions, subjects = values["actions"], values["subjects"]
        if not isinstance(actions, list):
            raise ValueError(f"actions: expected a list, got {actions!r}")
        if not isinstance(subjects, dict) or not all(isinstance(listed, list) for listed in subjects.values()):
            raise ValueError(f"subjects: expected an object of lists, got {subjects!r}")
        by_action = {action: tuple(listed) for action, listed in subjects.items()}
        return FittedConfiguration(values["name"], settings, values["data"], tuple(actions), by_action, values["seed"])
    except (TypeError, ValueError) as error:
        raise ValueError(f"{path}: {error}") from error


def is_fitted(path: Path) -> bool:
    """Return whether a configuration file is that of a fitted predictor."""
    return config.read_fields(path).get("name") in tuple(FITTED)


def _settings(default: Any, values: object) -> Any:
    """Return settings like the default, with these values."""
    names = [field.name for field in fields(default)]
    config.check_fields("settings: ", values, names)
    assert isinstance(values, dict)
    for name in names:
        expected = type(getattr(default, name))
        if name not in values or (
            type(values[name]) is not expected and not (expected is float and type(values[name]) is int)
        ):
            raise ValueError(
                f"settings: {name}: expected a value of type {expected.__name__}, got {values.get(name)!r}"
            )
    return type(default)(**values)
