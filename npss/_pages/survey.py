"""The page of a survey, which asks which of two predictions is closer to the ground truth."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy.typing as npt

from npss._pages._html import figure, pack, page, positions_array, resource
from npss.files._arrays import MAX_SIZE
from npss.files._samples import Pair
from npss.protocol import FPS
from npss.ranking._submissions import naming, read_submissions
from npss.skeleton import H36M, Skeleton, poses_to_positions
from npss.validation import Seed, is_integer

if TYPE_CHECKING:
    from npss.study import Question


def survey(
    directory: Path, *, n_questions: int, seed: Seed, action: str | None = None, max_size: float = MAX_SIZE
) -> str:
    """Make a survey on the predictions of several models for one action.

    Parameters
    ----------
    directory : Path
        A folder with one file of samples per model, such as ``MODEL.npz``: see `read_poses`. Sequences are numbered
        from 0 in the order of their indices.
    n_questions : int
        The number of questions, which `npss.study.design` draws.
    seed : int or numpy.random.Generator
        The seed of the generator that draws them.
    action : str, optional
        The action; may be left out if the files share a single one.
    max_size : float, optional
        The most memory that the arrays of one file may take, in GiB.

    Returns
    -------
    str
        The page, as from `survey_page`.

    Raises
    ------
    ValueError
        If there are fewer than two files, no action is in all files, `action` is not in all files or missing though
        there are several, or the ground truths of two files differ.
    """
    submissions = read_submissions([directory], max_size=max_size)
    if len(submissions) < 2:
        raise ValueError(f"{directory}: a survey needs two or more models; files of samples in it: {len(submissions)}")
    chosen = _action(directory, list(submissions.values()), action)
    pairs = {model: actions[chosen] for model, actions in submissions.items()}
    truth = next(iter(pairs.values())).gt

    from npss import study  # imported here: it is large

    questions = study.design(list(pairs), range(len(truth)), n_questions, seed=seed)
    motions = {}
    for model, pair in pairs.items():
        with naming(model, chosen):
            motions[model] = poses_to_positions(pair.pred)
    return survey_page(poses_to_positions(truth), motions, questions, action=chosen)


def survey_page(
    truth: npt.ArrayLike,
    models: Mapping[str, npt.ArrayLike],
    questions: Sequence[Question],
    *,
    action: str,
    fps: float = FPS,
    skeleton: Skeleton = H36M,
) -> str:
    """Make the page of a survey: the ground truth, A and B as moving skeletons, and a file of answers at the end.

    The page hides the names of the models from participants; its source contains them in base64.

    Parameters
    ----------
    truth : (N, T, J, 3) array_like
        Positions of the ground truth in millimetres.
    models : mapping of str to (N, T, J, 3) array_like
        Positions of each model's predictions.
    questions : sequence of npss.study.Question
        The questions.
    action : str
        The action, for the file of answers.
    fps : float, optional
        Frames per second.
    skeleton : Skeleton, optional
        The skeleton to draw.

    Returns
    -------
    str
        The page as HTML. `npss.study.read_votes` reads the answers that it saves.

    Raises
    ------
    TypeError
        If positions are not real numbers.
    ValueError
        If a shape is wrong, positions are not finite or too far from the origin, there are no questions, or a question
        has an unknown model, the same model twice, or an unknown sequence.
    """
    true = positions_array("truth", truth, skeleton)
    motions = {model: positions_array(f"models[{model!r}]", values, skeleton) for model, values in models.items()}
    for model, values in motions.items():
        if values.shape != true.shape:
            raise ValueError(f"models[{model!r}]: its shape {values.shape} differs from that of truth, {true.shape}")
    if not questions:
        raise ValueError("questions: expected at least one")
    packed: list[str] = []
    places: dict[tuple[str | None, int], int] = {}

    def place(model: str | None, sequence: int) -> int:
        """Return the index of a motion in `packed`."""
        if (model, sequence) not in places:
            places[model, sequence] = len(packed)
            packed.append(pack((true if model is None else motions[model])[sequence], skeleton))
        return places[model, sequence]

    names = sorted(motions)
    asked = []
    for question in questions:
        _require_known(f"questions: question {question.number}", question, names, len(true))
        a, b, sequence = question.model_a, question.model_b, int(question.sequence)
        asked.append(
            {
                "number": int(question.number),
                "sequence": sequence,
                "truth": place(None, sequence),
                "a": place(a, sequence),
                "b": place(b, sequence),
                "model_a": names.index(a),
                "model_b": names.index(b),
            }
        )
    data = {
        "action": action,
        "key": base64.b64encode(json.dumps(names).encode()).decode(),
        "figure": figure(skeleton, fps),
        "questions": asked,
        "motions": packed,
    }
    # The browser stores answers under this name, apart from those to other surveys.
    data["id"] = hashlib.sha256(json.dumps(data).encode()).hexdigest()[:16]
    body = resource("survey.html").replace("{count}", str(len(asked))).replace("{action}", escape(action))
    return page(
        title=f"Survey: {action}",
        body=body,
        scripts=("player.js", "survey.js"),
        data=data,
    )


def _action(directory: Path, samples: Sequence[Mapping[str, Pair]], action: str | None) -> str:
    """Return the action of the survey."""
    common = sorted(set.intersection(*(set(pairs) for pairs in samples)))
    if not common:
        raise ValueError(f"{directory}: no action is in all of its files of samples")
    if action is None and len(common) == 1:
        return common[0]
    if action not in common:
        raise ValueError(f"action: expected one of {', '.join(common)}, which all files have, got {action!r}")
    return action


def _require_known(name: str, question: Question, models: Sequence[str], count: int) -> None:
    for model in (question.model_a, question.model_b):
        if model not in models:
            raise ValueError(f"{name}: no predictions of {model!r}; expected one of {', '.join(models)}")
    if question.model_a == question.model_b:
        raise ValueError(f"{name}: it compares {question.model_a!r} with itself")
    if not is_integer(question.sequence) or not 0 <= question.sequence < count:
        raise ValueError(f"{name}: no sequence {question.sequence!r}; expected 0 to {count - 1}")
