"""Texts of a survey: complete in other languages, filled in, escaped, and read strictly."""

import json
import tomllib
from pathlib import Path

import pytest

from npss._pages._html import resource
from npss._pages.texts import Texts, english, read_texts

USUAL = tomllib.loads(resource("survey.toml"))
GERMAN = Path(__file__).parents[3] / "docs" / "survey.de.toml"


def write(path, value):
    path.write_text(value if isinstance(value, str) else json.dumps(value), encoding="utf-8")
    return path


def test_the_usual_texts_are_a_file_of_texts(tmp_path):
    path = write(tmp_path / "texts.toml", resource("survey.toml"))
    assert read_texts(path).all() == english().all()
    assert english()["title"] == "Which motion is closer?"
    assert "actions" not in english().all()


def test_every_text_is_used():
    """By the page or by its scripts."""
    code = "".join(resource(name) for name in ("survey.html", "survey.js", "player.js"))
    for name in {name.removesuffix("_alone") for name in USUAL} - {"actions", "language", "direction", "about"}:
        assert any(form in code for form in (f"${name}", f"texts.{name}", f"words.{name}")), name


def test_a_file_in_english_may_hold_a_few(tmp_path):
    path = write(tmp_path / "texts.json", {"title": "Which?", "language": "en-GB", "actions": {"walking": "A walk"}})
    texts = read_texts(path)
    assert texts["title"] == "Which?"
    assert texts["start"] == "Start"
    assert (texts.action("walking"), texts.action("eating")) == ("A walk", "Eating")
    assert (texts.action("sittingdown"), texts.action("my_action")) == ("Sitting down", "My action")
    alone = texts.alone()
    assert (alone["title"], alone["question"]) == ("Which motion is more natural?", "Which is more natural?")


@pytest.mark.skipif(not GERMAN.exists(), reason="the documentation is not beside the tests")
def test_the_german_example_is_complete(tmp_path):
    texts = read_texts(GERMAN)
    assert texts["language"] == "de"
    assert texts.all().keys() == english().all().keys()
    same = {name for name, text in texts.all().items() if text == USUAL[name]}
    assert same == {"direction", "left", "right", "pause"}
    lines = GERMAN.read_text(encoding="utf-8").replace('start = "Beginnen"\n', "")
    with pytest.raises(
        ValueError, match=r"texts\.toml: texts in another language, de, must be complete; missing: start$"
    ):
        read_texts(write(tmp_path / "texts.toml", lines))


def test_words_are_filled_in_once_and_all_is_escaped():
    texts = Texts({"end": "{questions} <b>\n \n{name} {other}", "actions": {}})
    assert texts.fill("end", questions=3, name="{questions}") == "3 <b>\n \n{questions} {other}"
    assert texts.paragraphs("end", questions="&", name="x") == "<p>&amp; &lt;b&gt;</p>\n<p>x {other}</p>"


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ({"titel": "x"}, r"unknown text 'titel'; expected language, direction, title, "),
        ({"title": ""}, r"title: expected a text, got an empty one"),
        ({"title": " \n"}, r"title: expected a text, got an empty one"),
        ({"title": 3}, r"title: expected a text, got 3"),
        ({"title": None}, r"title: expected a text, got None"),
        ({"number": "{number} of {count}"}, r"number: \{count\} is not filled in; expected \{number\}, \{questions\}"),
        ({"title": "{questions}"}, r"title: \{questions\} is not filled in; expected no words in braces"),
        ({"language": "english!"}, r"language: expected .*, got 'english!'"),
        ({"language": "de"}, r"texts in another language, de, must be complete; missing: direction, title, "),
        ({"direction": "left"}, r"direction: expected ltr\|rtl, got 'left'"),
        ({"actions": ["walking"]}, r"actions: expected names of actions, got \['walking'\]"),
        ({"actions": {"walking": ""}}, r"actions: expected names of actions, got"),
        (["title"], r"expected an object of texts"),
        ('{"title": "a", "title": "b"}', r"invalid JSON \(duplicate field 'title'\)|duplicate field 'title'"),
    ],
)
def test_bad_texts(tmp_path, value, message):
    path = write(tmp_path / "texts.json", value)
    with pytest.raises(ValueError, match=rf"texts\.json: {message}"):
        read_texts(path)


def test_bad_files(tmp_path):
    with pytest.raises(ValueError, match=r"texts\.toml: invalid TOML \("):
        read_texts(write(tmp_path / "texts.toml", "title = 'a'\ntitle = 'b'"))
    with pytest.raises(ValueError, match=r"texts\.txt: expected a \.toml or \.json file of texts"):
        read_texts(write(tmp_path / "texts.txt", "title"))
    with pytest.raises(FileNotFoundError):
        read_texts(tmp_path / "none.toml")
