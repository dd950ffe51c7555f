"""Find a form in which a function runs, and the choices whose numbers are those of the function."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from npss._identify import search
from npss._identify.calling import Form, Subject, forms, readings, text_of, torch_is_installed
from npss._identify.choices import Choices
from npss._identify.compute import Numbers
from npss._identify.probes import Probe, ordinary
from npss.validation import Float64

_FRAME = (12,)  # any shape: the lengths of probes do not depend on it


class Found(NamedTuple):
    """A form in which the function runs, and the combinations that fit what it returns."""

    form: Form
    probes: tuple[Probe, ...]
    level: str  # of numbers: "set", "sequence", "column"
    returns: str  # what they are, in words
    values: list[Numbers]
    tolerances: Float64 | None  # of the values of each probe; None if they depend on the scale of motion
    fits: list[Choices]  # none if it is no NPSS
    refused: str = ""  # the first form in which it does not run, and the error

    @property
    def tolerance(self) -> float:
        """The relative difference that rounding explains on well-conditioned motion."""
        if self.tolerances is None:
            return search.LEAST
        return float(self.tolerances[np.isfinite(self.tolerances)].max())


def find(subject: Subject, shape: tuple[int, ...] | None) -> Found:
    """Return the first form and reading that fit a combination of choices; else the first that gives numbers."""
    others: list[Found] = []
    errors: list[str] = []
    for tensors in (False, True):
        if tensors and (others or not torch_is_installed()):
            break
        for form in forms(shape, tensors=tensors):
            try:
                form, probes, outputs = _run(subject, form)
                found = _read(subject, form, probes, outputs)
            except Exception as error:
                if str(error).startswith("function: "):  # our own
                    raise
                errors.append(f"{form.words()}: {text_of(error)}")
                continue
            if form.single and others:  # along its axis 1, it would have fitted with several sequences
                found = found._replace(fits=[choices for choices in found.fits if choices.axis != "features"])
            if not (found.fits or form.single or subject.is_class):
                found = _of_each_sequence(subject, found)
            if found.fits:
                return found
            others.append(found)
    if others:
        return others[0]._replace(refused=errors[0] if errors else "")
    wanted = [error for error in errors if "tensor" in error]
    shown = "; ".join(dict.fromkeys([errors[0], *wanted[:1]]))
    raise ValueError(f"function: {subject.name} runs with no shape of motion; {shown}; {advice(shape)}")


def advice(shape: tuple[int, ...] | None) -> str:
    """Say what a function must take, and how to give it other frames."""
    lengths = [probe.gt.shape[1] for probe in ordinary(_FRAME, _FRAME)]
    text = f"it must take motions of {min(lengths)} to {max(lengths)} frames"
    return text if shape else f"{text}; if it needs one shape of a frame, such as 22 quaternions, pass frame=(22, 4)"


def _of_each_sequence(subject: Subject, found: Found) -> Found:
    """Return what a function of several sequences computes of one, if that fits; else what was found."""
    if found.tolerances is None:
        return found
    form = found.form._replace(single=True, of_one=True)
    try:
        of_one = _read(subject, form, found.probes, [subject(probe, form) for probe in found.probes])
    except Exception:  # pragma: no cover - it takes sets only
        return found
    return of_one if of_one.fits else found


def _run(subject: Subject, form: Form) -> tuple[Form, tuple[Probe, ...], list[list[Any]]]:
    """Run the function on all probes, of one shape of a frame if it takes no other."""
    probes = ordinary(form.frame, form.wider)
    outputs = [subject(probes[0], form)]
    try:
        return form, probes, outputs + [subject(probe, form) for probe in probes[1:]]
    except Exception:
        if form.wider == form.frame:  # pragma: no cover - it fails at a later probe of the same shape
            raise
        form = form._replace(wider=form.frame)
        probes = ordinary(form.frame, form.wider)
        return form, probes, outputs + [subject(probe, form) for probe in probes[1:]]


def _read(subject: Subject, form: Form, probes: tuple[Probe, ...], outputs: list[list[Any]]) -> Found:
    single = form.single and not subject.is_class
    again = search.scaled(probes)
    repeated = readings([subject(probe, form) for probe in again], again, single=single)
    twice = readings([subject(probes[0], form)], probes[:1], single=single)
    first: Found | None = None
    for (level, returns), values in readings(outputs, probes, single=single).items():
        key = (level, returns)
        if key not in repeated:  # pragma: no cover - its result has another form for scaled motion
            continue
        tolerances = search.tolerances(values, repeated[key])
        if tolerances is None and not np.allclose(values[0], twice[key][0], rtol=1e-3, equal_nan=True):
            raise ValueError(
                f"function: {subject.name} returns different values for equal motions: "
                f"{values[0].flat[0]:.6g}, then {twice[key][0].flat[0]:.6g}"
            )
        fits: list[Choices] = []
        if tolerances is not None:
            of_axes = search.tables(level, form.frame, form.wider)
            found = (
                [match for table in tables for match in search.matches(values, table, probes, tolerances)]
                for tables in of_axes
            )
            fits = search.distinct(next(filter(None, found), []))
        found_here = Found(form, probes, level, returns, values, tolerances, fits)
        if fits:
            return found_here
        first = first or found_here
    if first is None:
        raise TypeError(f"function: {subject.name} returns arrays of other sizes than sequences or features")
    return first
