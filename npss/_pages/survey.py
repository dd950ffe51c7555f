"""The page of a survey, which asks which of two predictions is closer to the ground truth."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from string import Template
from typing import Any, get_args

import numpy as np
import numpy.typing as npt

from npss._pages._html import figure, pack, page, positions_array, resource
from npss._pages.texts import Texts, english
from npss._pages.travel import Root, shown
from npss.files._arrays import MAX_SIZE
from npss.files._samples import Pair
from npss.protocol import FPS
from npss.ranking._submissions import TRUTH, read_submissions
from npss.skeleton import H36M, Skeleton
from npss.study import Question, counterbalance, design
from npss.study._counterbalance import block_size
from npss.study._design import RIGHT, WRONG
from npss.study._files import COLUMNS, OPTIONAL
from npss.validation import Array, Seed, each, is_integer, one_of, positive_integer


@dataclass(frozen=True)
class Part:
    """The part of a survey about one action.

    Attributes
    ----------
    truth : (N, T, J, 3) array_like
        Positions of the ground truth in millimetres.
    models : mapping of str to (N, T, J, 3) array_like
        Positions of each model's predictions.
    questions : sequence of npss.study.Question
        The questions.
    in_place : bool, optional
        Whether the figures do not travel, which the page then says.
    """

    truth: npt.ArrayLike
    models: Mapping[str, npt.ArrayLike]
    questions: Sequence[Question]
    in_place: bool = False


@dataclass(frozen=True, kw_only=True)
class Survey:
    """A survey on one page, and what to know before giving it to participants.

    Attributes
    ----------
    page : str
        The page as HTML, as from `survey_page`.
    n_questions : int
        The number of questions for each participant, attention checks included.
    block : int
        The number of participants over which order and sides are balanced.
    in_place : dict of str to str
        By action, why the figures stay in place; empty if they travel.
    """

    page: str
    n_questions: int
    block: int
    in_place: dict[str, str]

    def __str__(self) -> str:
        """Describe the survey in a few lines."""
        lines = [
            f"{self.n_questions} questions for each participant",
            f"{self.block} participants are a block, balanced in order and sides: give the numbers 1 to {self.block}, "
            f"or to {2 * self.block}, ...",
        ]
        for action, why in self.in_place.items():
            lines.append(f"{action}: the figures {f'stay in place: {why}' if why else 'travel'}")
        return "\n".join(lines)


def survey(
    directory: Path,
    *,
    n_questions: int,
    seed: int,
    actions: Sequence[str] | None = None,
    attention_checks: int = 0,
    ties: bool = False,
    recording: bool = True,
    texts: Texts | None = None,
    root: Root = "known",
    root_steps: int = 1,
    max_size: float = MAX_SIZE,
) -> Survey:
    """Make a survey on the predictions of several models.

    Parameters
    ----------
    directory : Path
        A folder with the results of each model, such as ``MODEL.npz``: see `read_submissions`. Motion of a file with a
        meta must be positions. Sequences are numbered from 0 in the order of their indices.
    n_questions : int
        The number of questions on each action, which `npss.study.design` draws.
    seed : int
        The seed for drawing them, and for their orders and sides.
    actions : sequence of str, optional
        The actions; may be left out if all files have the same.
    attention_checks : int, optional
        The number of attention checks among the questions on each action.
    ties, recording, texts
        As for `survey_page`.
    root : {'known', 'fixed'}, optional
        Whether the figures travel where the motion of the root is known, or stay in place: see `positions`.
    root_steps : int, optional
        The frames of the recording for each frame of the files. Files of the field have every second frame of
        Human3.6M, but the root's displacement since the frame before it in the recording; with 2, it is doubled.
    max_size : float, optional
        The most memory that the arrays of one file may take, in GiB.

    Returns
    -------
    Survey
        The page, and its numbers.

    Raises
    ------
    ValueError
        If there are fewer than two files, no action is in all files, the files have different actions and `actions` is
        missing, one of `actions` is not in all files, the ground truths of two files differ, or motion cannot be shown.
    """
    one_of("root", root, get_args(Root))
    steps = positive_integer("root_steps", root_steps)
    submissions = read_submissions([directory], max_size=max_size)
    if len(submissions) < 2:
        raise ValueError(f"{directory}: a survey needs two or more models; files of samples in it: {len(submissions)}")
    parts, in_place = {}, {}
    rng = np.random.default_rng(seed)
    for action in _actions(directory, submissions, actions):
        pairs = {model: of_model[action] for model, of_model in submissions.items()}
        seen = shown(action, pairs, root=root, steps=steps)
        truth = seen.motions.pop(TRUTH)
        questions = design(list(pairs), range(len(truth)), n_questions, seed=rng, attention_checks=attention_checks)
        parts[action] = Part(truth, seen.motions, questions, in_place=bool(seen.in_place))
        in_place[action] = seen.in_place
    # All actions of a file have the same skeleton and rate.
    look: dict[str, Any] = {"texts": texts, "fps": seen.fps, "skeleton": seen.skeleton}
    surveys = {action: part.questions for action, part in parts.items()}
    return Survey(
        page=survey_page(parts, seed=rng, ties=ties, recording=recording, **look),
        n_questions=sum(map(len, surveys.values())),
        block=block_size(surveys),
        in_place=in_place,
    )


def survey_page(
    parts: Mapping[str, Part],
    *,
    seed: Seed,
    ties: bool = False,
    recording: bool = True,
    texts: Texts | None = None,
    fps: float = FPS,
    skeleton: Skeleton = H36M,
) -> str:
    """Make the page of a survey: the ground truth, A and B as moving skeletons, and a file of answers at the end.

    Participants give a number, which decides the order and sides of their questions: see `npss.study.counterbalance`.
    The page hides the names of the models from them; its source contains them in base64.

    Parameters
    ----------
    parts : mapping of str to Part
        The part about each action.
    seed : int or numpy.random.Generator
        The seed of the orders and sides.
    ties : bool, optional
        Whether participants may have no preference.
    recording : bool, optional
        Whether the ground truth is beside A and B, and the question is which is closer to it. Without, it is which is
        more natural: the texts whose names end in ``_alone``.
    texts : Texts, optional
        The texts of the page (default: the English ones).
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
    words = english() if texts is None else texts
    words = words if recording else words.alone()
    packed: list[str] = []
    asked: list[dict[str, int | None]] = []
    hidden: list[tuple[str, str, str | None]] = []
    # The place of each question in `asked`, doubled, and one more if its sides are swapped.
    codes: dict[tuple[str, Question], int] = {}
    for number, (action, part) in enumerate(parts.items()):
        place = _packer(action, part, skeleton, packed)
        for question in part.questions:
            codes[action, question], codes[action, question.mirrored()] = 2 * len(asked), 2 * len(asked) + 1
            asked.append(
                {
                    "action": number,
                    "number": int(question.number),
                    "sequence": int(question.sequence),
                    "truth": place(RIGHT, question) if recording else None,
                    "a": place(question.model_a, question),
                    "b": place(question.model_b, question),
                }
            )
            hidden.append((question.model_a, question.model_b, question.expected))
    block = counterbalance({action: part.questions for action, part in parts.items()}, seed=seed)
    data: dict[str, Any] = {
        "texts": words.all(),
        "columns": [*COLUMNS, *OPTIONAL],
        "actions": [
            {"action": action, "name": words.action(action), "inPlace": part.in_place} for action, part in parts.items()
        ],
        "key": base64.b64encode(json.dumps(hidden).encode()).decode(),
        "figure": figure(skeleton, fps),
        "questions": asked,
        "orders": [[codes[of_one] for of_one in order] for order in block],
        "motions": packed,
    }
    # The browser stores answers under this name, apart from those to other surveys.
    data["id"] = hashlib.sha256(json.dumps(data).encode()).hexdigest()[:16]
    return page(
        title=words["title"],
        body=_body(words, len(asked), ties),
        scripts=("player.js", "survey.js"),
        data=data,
        language=words["language"],
        direction=words["direction"],
    )


def _packer(action: str, part: Part, skeleton: Skeleton, packed: list[str]) -> Callable[[str, Question], int]:
    """Check a part, and return a function that returns the index of a motion in `packed`, to which it adds new ones."""
    name = f"parts[{action!r}]"
    truth = positions_array(f"{name}: truth", part.truth, skeleton)
    motions = {}
    for model, values in part.models.items():
        motions[model] = positions_array(f"{name}: models[{model!r}]", values, skeleton)
        if motions[model].shape != truth.shape:
            raise ValueError(
                f"{name}: models[{model!r}]: its shape {motions[model].shape} differs from that of truth, {truth.shape}"
            )
    if not part.questions:
        raise ValueError(f"{name}: expected one question or more")
    for question in part.questions:
        _check_question(f"{name}: question {question.number}", question, sorted(motions), len(truth))
    motions |= {RIGHT: truth, WRONG: _upside_down(truth)}
    places: dict[tuple[str, int], int] = {}

    def place(model: str, question: Question) -> int:
        sequence = int(question.sequence)
        if (model, sequence) not in places:
            places[model, sequence] = len(packed)
            packed.append(pack(motions[model][sequence], skeleton))
        return places[model, sequence]

    return place


def _upside_down(motions: Array) -> Array:
    """Turn each sequence of ``(N, T, J, 3)`` upside down, between its lowest and its highest point."""
    y = motions[..., 1]
    turned = motions.copy()
    turned[..., 1] = y.min(axis=(-2, -1), keepdims=True) + y.max(axis=(-2, -1), keepdims=True) - y
    return turned


def _body(texts: Texts, count: int, ties: bool) -> str:
    """Return the body of the page, with all texts escaped."""
    paragraphs = ("introduction", "storage", "end")
    words = {name: escape(text) for name, text in texts.all().items() if name not in paragraphs}
    words |= {name: texts.paragraphs(name, questions=count) for name in paragraphs}
    words["consent"] = ""
    if texts["about"].strip():
        words["consent"] = (
            f'<div class="about">\n{texts.paragraphs("about")}\n</div>\n<label class="consent">'
            f'<input type="checkbox" id="consent" aria-describedby="start-alert">{escape(texts["consent"])}</label>\n'
        )
    words["tie"] = (
        f'<label><input type="radio" name="choice" value="tie">{escape(texts["tie"])}</label>\n' if ties else ""
    )
    return Template(resource("survey.html")).substitute(words)


def _actions(
    directory: Path, submissions: Mapping[str, Mapping[str, Pair]], actions: Sequence[str] | None
) -> list[str]:
    """Return the actions of the survey."""
    of_models = [set(pairs) for pairs in submissions.values()]
    common = sorted(set.intersection(*of_models))
    if not common:
        raise ValueError(f"{directory}: no action is in all of its files of samples")
    if actions is None:
        if others := sorted(set.union(*of_models).difference(common)):
            raise ValueError(
                f"actions: only some files have {', '.join(others)}; expected some of {', '.join(common)}, in all files"
            )
        return common
    chosen = each("actions", actions, "names")
    for action in chosen:
        if action not in common:
            raise ValueError(f"actions: expected some of {', '.join(common)}, which all files have, got {action!r}")
    if not chosen or len(set(chosen)) < len(chosen):
        raise ValueError(f"actions: expected one or more without duplicates, got {chosen}")
    return chosen


def _check_question(name: str, question: Question, models: Sequence[str], count: int) -> None:
    known = {RIGHT, WRONG} if question.expected else set(models)
    for model in (question.model_a, question.model_b):
        if model not in known:
            raise ValueError(f"{name}: no predictions of {model!r}; expected one of {', '.join(sorted(known))}")
    if question.model_a == question.model_b:
        raise ValueError(f"{name}: it compares {question.model_a!r} with itself")
    if not is_integer(question.sequence) or not 0 <= question.sequence < count:
        raise ValueError(f"{name}: no sequence {question.sequence!r}; expected 0 to {count - 1}")
