"""The survey of a user study, which asks which of two predictions is closer to the ground truth."""

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
    """Make the survey about the predictions of several models for one action.

    Parameters
    ----------
    directory : Path
        Holds one file of samples for each model, such as ``MODEL.npz``: see `read_poses`. Sequences are
        numbered from 0 on in the order of their indices.
    n_questions : int
        How many questions: see `npss.study.design`, which draws them.
    seed : int or numpy.random.Generator
        Of the generator that draws them.
    action : str, optional
        What the predictions are of; may be left out if the files have a single action in common.
    max_size : float, optional
        How much memory the arrays of one file may take, in GiB.

    Returns
    -------
    str
        A page as of `survey_page`.

    Raises
    ------
    ValueError
        If there are not at least two files, no action is in all, the action is not or would have to be guessed, or the
        ground truths of two files differ.
    """
    submissions = read_submissions([directory], max_size=max_size)
    if len(submissions) < 2:
        raise ValueError(
            f"{directory}: a survey compares two models or more; files of samples in it: {len(submissions)}"
        )
    chosen = _action(directory, list(submissions.values()), action)
    pairs = {model: actions[chosen] for model, actions in submissions.items()}
    truth = next(iter(pairs.values())).gt

    from npss import study  # imported late: it is large

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

    It is blind to whoever looks at it, not to whoever reads its source: the models' names are there in base64.

    Parameters
    ----------
    truth : (N, T, J, 3) array_like
        Positions of the ground truth in millimetres.
    models : mapping of str to (N, T, J, 3) array_like
        Positions of every model's predictions.
    questions : sequence of npss.study.Question
        What is asked.
    action : str
        What is done; for the file of answers.
    fps : float, optional
        Frames per second.
    skeleton : Skeleton, optional
        What to draw.

    Returns
    -------
    str
        HTML. The answers that it saves are a file for `npss.study.read_votes`.

    Raises
    ------
    TypeError
        If positions are not real numbers.
    ValueError
        If a shape is wrong, positions are not finite or too far from the origin, there are no questions, or one names
        an unknown model, the same model twice, or a sequence that there is not.
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
        """Return where in `packed` a motion is."""
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
    # By which the browser tells the answers to this survey from those to others.
    data["id"] = hashlib.sha256(json.dumps(data).encode()).hexdigest()[:16]
    body = resource("survey.html").replace("{count}", str(len(asked))).replace("{action}", escape(action))
    return page(
        title=f"Survey: {action}",
        body=body,
        scripts=("player.js", "survey.js"),
        data=data,
    )


def _action(directory: Path, samples: Sequence[Mapping[str, Pair]], action: str | None) -> str:
    """Return the action that the survey is about."""
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
            raise ValueError(f"{name}: no predictions of {model!r}; there are those of {', '.join(models)}")
    if question.model_a == question.model_b:
        raise ValueError(f"{name}: it compares {question.model_a!r} with itself")
    if not is_integer(question.sequence) or not 0 <= question.sequence < count:
        raise ValueError(f"{name}: no sequence {question.sequence!r}; there are {count}, from 0 on")
