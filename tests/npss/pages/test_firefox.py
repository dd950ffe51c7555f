"""A survey in Firefox: in sight, taken by keyboard, kept and saved."""

import time

import pytest

from firefox import FIREFOX, firefox
from npss import study
from npss._pages import survey
from survey_pages import ACTIONS, OUT_OF_SIGHT, write_samples

pytestmark = pytest.mark.skipif(not FIREFOX, reason="needs Firefox")

TAB, ENTER, RIGHT = "\ue004", "\ue007", "\ue014"


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    with firefox(tmp_path_factory.mktemp("firefox")) as browser:
        yield browser


def wait(condition):
    """Return what a condition gives once it is true."""
    end = time.monotonic() + 20
    while not (value := condition()):
        assert time.monotonic() < end
        time.sleep(0.05)
    return value


def ready(browser):
    """Wait until the survey has looked for earlier answers."""
    wait(lambda: browser.run("() => [...document.querySelectorAll('section')].some((section) => !section.hidden)"))


def test_a_survey(browser, tmp_path):
    write_samples(tmp_path)
    page = tmp_path / "survey.html"
    page.write_text(survey(tmp_path, n_questions=1, seed=0, ties=True).page, encoding="utf-8")
    browser.open(page.as_uri(), 390, 844)
    ready(browser)
    assert browser.run(OUT_OF_SIGHT) == []
    browser.press(TAB, "1", ENTER)
    wait(lambda: browser.run("() => document.getElementById('start').hidden"))
    for number in range(1, len(ACTIONS) + 1):
        assert browser.run("() => document.activeElement.textContent") == f"Question {number} of 4"
        for size in (390, 844), (1280, 720):
            browser.resize(*size)
            assert browser.run(OUT_OF_SIGHT) == []
        if number == 3:
            browser.open(page.as_uri(), 1280, 720)
            ready(browser)  # answers are kept
            assert browser.run("() => document.activeElement.textContent") == "Question 3 of 4"
        # Play, time, view, A; an arrow chooses the next, B.
        browser.press(TAB, TAB, TAB, TAB, RIGHT, ENTER)
    assert browser.run("() => document.activeElement.textContent") == "Thank you"
    assert browser.run(OUT_OF_SIGHT) == []
    browser.run("() => document.getElementById('save').click()")
    wait(lambda: [path for path in browser.folder.glob("*.csv") if path.stat().st_size])
    votes = study.read_votes(browser.folder)
    assert sorted(vote.action for vote in votes) == sorted(ACTIONS)
    assert {(vote.participant, vote.choice) for vote in votes} == {("1", "B")}
