"""The texts of a survey's page: English ones in a file beside this one, which a file of the user may replace."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any

from npss._pages._html import resource
from npss.files._json import read_json
from npss.files._text import read_text

#: Texts that are not sentences: what they may be.
_FORMS = {"language": r"[A-Za-z]{2,8}(-[A-Za-z0-9]{1,8})*", "direction": "ltr|rtl"}
_ALONE = "_alone"
_MAY_BE_EMPTY = "about"
_WORD = re.compile(r"\{(\w+)\}")


class Texts:
    """The texts of a page.

    Parameters
    ----------
    texts : mapping of str to str
        All texts by name, and the names of actions under ``actions``.
    """

    def __init__(self, texts: Mapping[str, Any]) -> None:
        self._texts = texts

    def __getitem__(self, name: str) -> str:
        text: str = self._texts[name]
        return text

    def action(self, action: str) -> str:
        """Return the name of an action to show."""
        name: str = self._texts["actions"].get(action, action.replace("_", " "))
        return name[:1].upper() + name[1:]

    def alone(self) -> Texts:
        """Return the texts of a survey that does not show the recording."""
        others = {name.removesuffix(_ALONE): text for name, text in self._texts.items() if name.endswith(_ALONE)}
        return Texts({**self._texts, **others})

    def fill(self, name: str, /, **words: object) -> str:
        """Return a text with its words in braces filled in."""
        return _WORD.sub(lambda match: str(words[match[1]]) if match[1] in words else match[0], self[name])

    def paragraphs(self, name: str, /, **words: object) -> str:
        """Return a text as HTML, a paragraph for each block between empty lines."""
        blocks = re.split(r"\n\s*\n", self.fill(name, **words).strip())
        return "\n".join(f"<p>{escape(block)}</p>" for block in blocks if block)

    def all(self) -> dict[str, str]:
        """Return the texts without the names of actions."""
        return {name: text for name, text in self._texts.items() if name != "actions"}


def english() -> Texts:
    """Return the English texts."""
    return Texts(tomllib.loads(resource("survey.toml")))


def read_texts(path: Path) -> Texts:
    """Read texts from a TOML or JSON file with the names of ``survey.toml``.

    Parameters
    ----------
    path : Path
        The file, ``.toml`` or ``.json``, in UTF-8.

    Returns
    -------
    Texts
        Its texts; in a file in English, those that it lacks are the usual ones.

    Raises
    ------
    ValueError
        If the file is neither, has an unknown name, an empty text or one that is not a string, or words in braces that
        are not filled in, or a file in another language lacks a text.
    OSError
        If the file cannot be read.
    """
    usual = tomllib.loads(resource("survey.toml"))
    given = _read(path)
    if not isinstance(given, dict):
        raise ValueError(f"{path}: expected an object of texts")
    if unknown := sorted(given.keys() - usual.keys()):
        raise ValueError(f"{path}: unknown text {unknown[0]!r}; expected {', '.join(usual)}")
    for name, text in given.items():
        _check(f"{path}: {name}", name, text, usual[name])
    language = given.get("language", "en")
    missing = [name for name in usual if name not in (*given, "actions")]
    if missing and language.split("-")[0].lower() != "en":
        raise ValueError(
            f"{path}: texts in another language, {language}, must be complete; missing: {', '.join(missing)}"
        )
    return Texts({**usual, **given, "actions": {**usual["actions"], **given.get("actions", {})}})


def _read(path: Path) -> Any:
    if path.suffix == ".json":
        return read_json(path)
    if path.suffix != ".toml":
        raise ValueError(f"{path}: expected a .toml or .json file of texts")
    try:
        return tomllib.loads(read_text(path))
    except tomllib.TOMLDecodeError as error:
        raise ValueError(f"{path}: invalid TOML ({error})") from error


def _check(where: str, name: str, text: object, usual: Any) -> None:
    if name == "actions":
        if not isinstance(text, dict) or not all(isinstance(shown, str) and shown.strip() for shown in text.values()):
            raise ValueError(f"{where}: expected names of actions, got {text!r}")
        return
    if not isinstance(text, str):
        raise ValueError(f"{where}: expected a text, got {text!r}")
    if not text.strip() and name != _MAY_BE_EMPTY:
        raise ValueError(f"{where}: expected a text, got an empty one")
    if name in _FORMS and not re.fullmatch(_FORMS[name], text):
        raise ValueError(f"{where}: expected {_FORMS[name]}, got {text!r}")
    known = _WORD.findall(usual)
    for word in _WORD.findall(text):
        if word not in known:
            filled = ", ".join(f"{{{each}}}" for each in known) or "no words in braces"
            raise ValueError(f"{where}: {{{word}}} is not filled in; expected {filled}")
