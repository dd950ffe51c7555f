"""The pages in a browser: they move, can be answered and read, and request nothing from the network."""

import json
import re
import shutil
import time
import tomllib
from itertools import pairwise
from pathlib import Path

import pytest
from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select, WebDriverWait

from npss import gait, study
from npss._pages import Figure, Part, report_page, survey_page
from npss._pages._html import resource
from npss._pages.texts import read_texts
from npss.commands import main, motion_page
from npss.skeleton import H36M, poses_to_positions
from survey_pages import OUT_OF_SIGHT, write_samples

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
DRIVER = shutil.which("chromedriver")
pytestmark = pytest.mark.skipif(not (BROWSER and DRIVER), reason="needs Chromium and chromedriver")

GERMAN = Path(__file__).parents[3] / "docs" / "survey.de.toml"
FLAGS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"),
    *("--disable-component-update", "--disable-sync", "--disable-quic"),
)
MODELS = ('Prior, "quoted"', "zweites Modell é", "Ultimate\u2028<b>")
QUESTIONS = [
    study.Question(1, 1, MODELS[0], MODELS[1]),
    study.Question(2, 0, MODELS[2], MODELS[0]),
    study.Question(3, 1, MODELS[1], MODELS[0]),
]
#: The questions of each participant, in order and with sides.
BLOCK = [[question for _, question in shown] for shown in study.counterbalance({"walking": QUESTIONS}, seed=0)]


def walks(seed):
    return poses_to_positions(gait.gait(2, 30, seed=seed))


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    options = webdriver.ChromeOptions()
    options.binary_location = BROWSER
    for flag in (*FLAGS, f"--user-data-dir={tmp_path_factory.mktemp('profile')}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service(DRIVER))
    yield driver
    driver.quit()


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """Addresses of a survey and a report of generated motion."""
    folder = tmp_path_factory.mktemp("pages")
    part = Part(walks(0), {m: walks(i + 1) for i, m in enumerate(MODELS)}, QUESTIONS)
    survey = survey_page({"walking": part}, seed=0)
    rows = "".join(
        f"<tr><th>{name}</th>" + "<td>1.234</td>" * 9 + "</tr>" for name in ("a model with a long name", "another")
    )
    header = f"<tr><th>model</th>{''.join(f'<th>{80 * k} ms</th>' for k in range(9))}</tr>"
    report = report_page(
        title="Two models",
        boards=[f'<table class="board"><thead>{header}</thead><tbody>{rows}</tbody></table>'],
        notes=["A note."],
        signatures=["npss|version:1|convention:paper|representation:euler|frames:100|fps:25|and:" + "x" * 80],
        figures=[Figure("Title", '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 900 300"/>', "Caption.")],
        findings=[("a model", ["It is slow.", "W" * 200])],
        clips={
            "walking": {"ground truth": walks(0), MODELS[0]: walks(1), MODELS[1]: walks(2)},
            "eating": {"ground truth": walks(3)[:1, :20], MODELS[2]: walks(4)[:1, :20]},
        },
        fps=25,
        skeleton=H36M,
    )
    spans = [("frames 40 to 59: held", 0.4, 0.6), ("frames 80 to 89: jump", 0.8, 0.9)]
    motion = motion_page(
        {"before": walks(0)[0], "after": walks(1)[0]},
        title="A clip",
        fps=25,
        skeleton=H36M,
        truth="before",
        notes=["A note."],
        spans=spans,
        frame_rate=100,
    )
    addresses = {}
    for name, html in (("survey", survey), ("report", report), ("motion", motion)):
        path = folder / f"{name}.html"
        path.write_text(html, encoding="utf-8")
        addresses[name] = path.as_uri()
    return addresses


@pytest.fixture
def open_page(browser, pages):
    """Open a page as somebody would who has never seen it; afterwards, look at what it logged and asked for."""
    scripts = []

    def visit(name, *, width=1280, height=800, scale=1, scheme="light", motion="reduce", before=None):
        browser.get_log("performance")
        screen = {"width": width, "height": height, "deviceScaleFactor": scale, "mobile": False}
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
        media = {"prefers-color-scheme": scheme, "prefers-reduced-motion": motion}
        features = [{"name": key, "value": value} for key, value in media.items()]
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})
        browser.get("about:blank")
        browser.execute_cdp_cmd("Storage.clearDataForOrigin", {"origin": "file://", "storageTypes": "all"})
        if before:
            script = browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": before})
            scripts.append(script)
        browser.get(pages[name])
        wait_for_the_page(browser)
        return browser

    yield visit
    for script in scripts:
        browser.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", script)
    assert browser.get_log("browser") == []
    events = [json.loads(entry["message"])["message"] for entry in browser.get_log("performance")]
    requests = [event["params"] for event in events if event["method"] == "Network.requestWillBeSent"]
    asked = [request["request"]["url"] for request in requests if request["documentURL"].startswith("file:")]
    assert asked  # the page itself: requests are seen
    assert [url for url in asked if not url.startswith(("file:", "data:", "blob:"))] == []


def get(browser, selector):
    return browser.find_element(By.CSS_SELECTOR, selector)


def every(browser, selector):
    return browser.find_elements(By.CSS_SELECTOR, selector)


COPY = """
const copy = (canvas) => {
  // Pixels are read from a copy, for a page that is read from is drawn in another way.
  const made = document.createElement('canvas');
  [made.width, made.height] = [canvas.width, canvas.height];
  made.getContext('2d', {willReadFrequently: true}).drawImage(canvas, 0, 0);
  return made;
};
"""


def pictures(browser):
    """What is drawn on every canvas."""
    script = "return [...document.querySelectorAll('canvas')].map((canvas) => copy(canvas).toDataURL())"
    return browser.execute_script(COPY + script)


def clock(browser):
    return int(get(browser, ".controls output").text.split()[0])


def wait(browser, condition):
    return WebDriverWait(browser, 10, poll_frequency=0.05).until(condition)


def wait_for_the_page(browser):
    """Wait until it shows a title: a survey first looks for answers that it was given before."""
    wait(browser, lambda b: any(title.is_displayed() for title in every(b, "h1")))


def drag(browser, canvas, x, y):
    ActionChains(browser, duration=50).drag_and_drop_by_offset(canvas, x, y).perform()


def started(browser):
    """Wait until the survey has looked for the participant's earlier answers, or says what is missing."""
    wait(browser, lambda b: get(b, "#start-alert").text or not get(b, "#start").is_displayed())


def start(browser, participant="1"):
    get(browser, "#participant").send_keys(participant)
    get(browser, "#start-form button").click()
    started(browser)


def answer(browser, choice):
    get(browser, f"input[value={choice}]").click()
    get(browser, "#next").click()


def answer_all(browser):
    """Choose A for every question from the present one on, by clicks of a script: quick."""
    browser.execute_script(
        """
        while (!document.getElementById('question').hidden) {
          document.querySelector('input[value=A]').click();
          document.getElementById('next').click();
        }
        """
    )


def pause(browser):
    button = get(browser, ".controls button")
    if button.text == "Pause":
        button.click()
    return button


def set_range(browser, selector, value):
    script = "arguments[0].value = arguments[1]; arguments[0].dispatchEvent(new Event('input', {bubbles: true}))"
    browser.execute_script(script, get(browser, selector), value)


@pytest.mark.parametrize("page", ["survey", "report"])
def test_figures_move_in_step_and_can_be_paused_and_scrubbed(open_page, page):
    browser = open_page(page, motion="no-preference")
    if page == "survey":
        start(browser)
    first = wait(browser, lambda b: clock(b) < 600 and pictures(b))
    wait(browser, lambda b: all(now != then for now, then in zip(pictures(b), first, strict=True)))
    button = pause(browser)
    assert button.text == "Play"
    time.sleep(0.15)
    still, at = pictures(browser), clock(browser)
    time.sleep(0.15)
    assert (pictures(browser), clock(browser)) == (still, at)

    slider = get(browser, ".time input")
    slider.send_keys(Keys.END)
    assert get(browser, ".controls output").text == "1200 of 1200 ms"
    end = pictures(browser)
    slider.send_keys(Keys.HOME)
    assert clock(browser) == 40
    assert all(one != other for one, other in zip(pictures(browser), end, strict=True))
    slider.send_keys(Keys.ARROW_RIGHT)
    assert clock(browser) == 80
    assert slider.get_attribute("aria-valuetext") == "80 of 1200 ms"

    slider.send_keys(Keys.END)
    button.click()  # plays again from the beginning
    wait(browser, lambda b: 40 < clock(b) < 1000)  # away from the first frame, to which Home then goes
    assert button.text == "Pause"
    slider.send_keys(Keys.HOME)  # scrubbing pauses
    assert button.text == "Play"


def test_stretches_of_time_can_be_looked_at(open_page):
    browser = open_page("motion")
    output, panels = get(browser, ".controls output"), get(browser, ".panels")
    assert output.text == "frame 0, 0.00 s"  # half a second before the first one, or the beginning
    back, on = every(browser, ".controls .step")
    back.click()
    on.click()
    assert output.text == "frame 4, 0.04 s"
    for _ in range(9):
        assert "within" not in panels.get_attribute("class")
        on.click()
    assert output.text == "frame 40, 0.40 s"
    assert "within" in panels.get_attribute("class")
    slider = get(browser, ".time input").rect
    for mark, (first, last) in zip(every(browser, ".track .span"), ((0.4, 0.6), (0.8, 0.9)), strict=True):
        inside = slider["width"] - 16  # half a thumb on either side
        assert mark.rect["x"] - slider["x"] == pytest.approx(8 + inside * first / 1.16, abs=1)
        assert mark.rect["width"] == pytest.approx(inside * (last - first) / 1.16, abs=1)
    Select(get(browser, ".speed select")).select_by_visible_text("0.25")
    every(browser, "button.link")[1].click()
    wait(browser, lambda b: float(output.text.split()[2]) > 0.36)
    assert float(output.text.split()[2]) < 0.8
    assert pause(browser).text == "Play"
    for width in (1280, 320):
        browser = open_page("motion", width=width)
        assert browser.execute_script("return document.documentElement.scrollWidth") <= width


SAMPLES = """
const done = arguments[0];
let samples = [];
requestAnimationFrame(function look(now) {
  const shown = parseInt(document.querySelector('.controls output').value);
  if (samples.length > 0 && shown < samples.at(-1)[1]) samples = []; // it began again
  samples.push([now, shown]);
  if (shown === 1200 && samples[0][1] < 400) done(samples);
  else requestAnimationFrame(look);
});
"""


def test_it_plays_at_its_rate_and_starts_again(open_page):
    browser = open_page("survey", motion="no-preference")
    start(browser)
    # By the clock of the animation, so that a busy machine changes nothing. What a sample sees was drawn at its own
    # time or at that of the one before, and each frame is shown for 40 ms.
    samples = browser.execute_async_script(SAMPLES)
    (t0, _), (t1, first) = samples[:2]
    for (before, _), (now, shown) in pairwise(samples[1:]):
        assert before - t1 - 40 < shown - first < now - t0 + 40
    wait(browser, lambda b: clock(b) < 600)


def test_turning_by_pointer_and_by_keys(open_page):
    browser = open_page("report")
    before = pictures(browser)
    canvas = every(browser, "canvas")[1]
    drag(browser, canvas, 60, 0)
    turned = pictures(browser)
    assert all(one != other for one, other in zip(turned, before, strict=True))
    assert int(get(browser, ".view input").get_attribute("value")) == 80
    drag(browser, canvas, 0, 40)
    assert pictures(browser) != turned
    view = get(browser, ".view input")
    view.send_keys(Keys.HOME)
    assert view.get_attribute("value") == "-180"
    # A pointer that only passes over turns nothing.
    seen = pictures(browser)
    ActionChains(browser, duration=50).move_to_element(every(browser, "canvas")[0]).move_by_offset(30, 0).perform()
    assert pictures(browser) == seen


CENTROIDS = """
const [canvas, names] = arguments;
const [width, height] = [canvas.width, canvas.height];
const pixels = copy(canvas).getContext('2d').getImageData(0, 0, width, height).data;
return names.map((name) => {
  const hex = getComputedStyle(canvas).getPropertyValue(`--${name}`).trim();
  const colour = [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
  let [count, x, y] = [0, 0, 0];
  for (let i = 0; i < pixels.length; i += 4) {
    if (pixels[i + 3] === 255 && colour.every((value, k) => Math.abs(pixels[i + k] - value) < 3)) {
      count += 1;
      x += (i / 4) % width;
      y += Math.floor(i / 4 / width);
    }
  }
  return [count, x / count / width, y / count / height];
});
"""


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_figures_stand_upright_with_left_and_right_in_colours_of_their_own(open_page, scheme):
    browser = open_page("report", scheme=scheme, scale=2)
    for canvas, kind in zip(every(browser, "canvas"), ("truth", "motion", "motion"), strict=True):
        assert canvas.get_property("width") == 2 * canvas.get_property("clientWidth")  # sharp on such a screen
        names = [f"{kind}-{side}" for side in ("left", "right", "centre")]
        for view, sign in ((0, 1), (180, -1)):
            set_range(browser, ".view input", view)
            left, right, centre = browser.execute_script(COPY + CENTROIDS, canvas, names)
            assert min(left[0], right[0], centre[0]) > 100
            assert sign * (left[1] - right[1]) > 0.02  # one who faces the viewer has his left on the right
            assert centre[2] < max(left[2], right[2])  # the spine is above the legs
        other = "motion-left" if kind == "truth" else "truth-left"
        ((count, _, _),) = browser.execute_script(COPY + CENTROIDS, canvas, [other])
        assert count == 0


@pytest.mark.parametrize("page", ["survey", "report"])
def test_reduced_motion_does_not_start_by_itself(open_page, page):
    browser = open_page(page, motion="reduce")
    if page == "survey":
        start(browser)
    button = get(browser, ".controls button")
    seen = pictures(browser)
    time.sleep(0.2)
    assert (button.text, clock(browser), pictures(browser)) == ("Play", 40, seen)
    button.click()
    wait(browser, lambda b: clock(b) > 200)


@pytest.mark.parametrize("page", ["survey", "report"])
@pytest.mark.parametrize("width", [360, 1280])
def test_nothing_scrolls_sideways_but_tables_in_their_box(open_page, page, width):
    browser = open_page(page, width=width)

    def fits():
        script = "const root = document.documentElement; return [innerWidth, root.scrollWidth, root.clientWidth]"
        window, wide, room = browser.execute_script(script)
        assert window == width
        assert wide <= room

    fits()
    if page == "survey":
        start(browser)
        fits()
        answer_all(browser)
        fits()
    else:
        box = get(browser, ".scroll")
        narrow = browser.execute_script("return arguments[0].scrollWidth > arguments[0].clientWidth", box)
        assert narrow == (width == 360)
        name = get(browser, ".board tbody th")
        at = name.rect["x"]
        browser.execute_script("arguments[0].scrollLeft = 100", box)
        assert name.rect["x"] == at  # the models' names keep in sight
        assert get(browser, ".gallery img").size["width"] <= width


@pytest.mark.parametrize("page", ["survey", "report"])
def test_controls_have_names(open_page, page):
    browser = open_page(page)
    if page == "survey":
        start(browser)
    shown = [e for e in every(browser, "button, input, select, canvas, progress, img, .scroll") if e.is_displayed()]
    assert len(shown) > 6
    assert [element.get_attribute("outerHTML") for element in shown if not element.accessible_name] == []


def saved(browser, folder):
    """Save the answers; return the file."""
    behaviour = {"behavior": "allow", "downloadPath": str(folder)}
    browser.execute_cdp_cmd("Browser.setDownloadBehavior", behaviour)
    get(browser, "#save").click()
    return wait(browser, lambda _: next((path for path in folder.glob("*.csv") if path.stat().st_size), None))


def test_a_survey_is_blind_and_the_file_of_its_answers_right(open_page, tmp_path):
    browser = open_page("survey")
    start(browser, " 2 ")
    choices = ["B", "A", "B"]
    for i, choice in enumerate(choices):
        assert get(browser, "#number").text == f"Question {i + 1} of 3"
        assert [caption.text for caption in every(browser, "figcaption")] == ["Real recording", "A", "B"]
        elements = browser.execute_script("return document.body.outerHTML")
        assert not any(model.split()[0] in elements for model in MODELS)
        answer(browser, choice)
    assert get(browser, "#end").is_displayed()
    path = saved(browser, tmp_path)
    assert path.name == "answers-walking-2.csv"
    votes = study.read_votes(path)
    assert votes == [
        study.Vote("walking", question, "2", choice, position)
        for position, (question, choice) in enumerate(zip(BLOCK[1], choices, strict=True), 1)
    ]


def test_a_question_shows_the_motions_it_is_about(open_page, browser):
    open_page("survey")
    seen = {}
    start(browser)
    for question in BLOCK[0]:
        seen[question.number] = dict(zip(("truth", question.model_a, question.model_b), pictures(browser), strict=True))
        answer(browser, "A")
    assert seen[1] == seen[3]  # which ask about the same motions
    assert not set(seen[1].values()) & set(seen[2].values())


def test_nobody_finishes_without_answering(open_page):
    browser = open_page("survey")
    for wrong in ("", "   ", "0", "-1", "1.5", "p1", "١"):
        get(browser, "#participant").clear()
        start(browser, wrong)
        assert get(browser, "#start").is_displayed()
        assert get(browser, "#start-alert").text == "Please give your number: 1, 2, 3, ..."
    get(browser, "#participant").clear()
    start(browser)
    for i in range(len(QUESTIONS)):
        get(browser, "#next").click()
        assert get(browser, "#number").text == f"Question {i + 1} of 3"
        assert get(browser, "#question-alert").text == "Please choose first."
        assert get(browser, "#progress").get_property("value") == i
        answer(browser, "A")
    assert get(browser, "#end").is_displayed()


def test_a_survey_by_keyboard(open_page):
    browser = open_page("survey")
    keys = ActionChains(browser)
    get(browser, "#participant").send_keys("1", Keys.ENTER)
    started(browser)
    for i in range(len(QUESTIONS)):
        assert browser.switch_to.active_element.text == f"Question {i + 1} of 3"
        # Pause, time, view, and then the choice.
        keys.send_keys(*[Keys.TAB] * 4, Keys.SPACE, Keys.ENTER).perform()
    assert browser.switch_to.active_element.text == "Thank you"


def test_answers_outlast_the_page(open_page):
    browser = open_page("survey")
    start(browser)
    answer(browser, "B")
    get(browser, "input[value=A]").click()  # chosen, not yet on to the next
    browser.refresh()
    wait_for_the_page(browser)
    assert get(browser, "#number").text == "Question 3 of 3"
    get(browser, "#question .back").click()
    assert get(browser, "input[value=A]").is_selected()
    get(browser, "#question .back").click()
    assert get(browser, "input[value=B]").is_selected()
    get(browser, "#question .back").click()
    assert get(browser, "#participant").get_property("value") == "1"


def test_another_participant_starts_anew(open_page, tmp_path):
    browser = open_page("survey")
    start(browser)
    answer_all(browser)
    browser.refresh()
    wait_for_the_page(browser)
    assert get(browser, "#end").is_displayed()
    get(browser, "#end .back").click()
    assert get(browser, "#number").text == "Question 3 of 3"
    answer(browser, "B")
    get(browser, "#again").click()
    assert get(browser, "#participant").get_property("value") == ""
    start(browser, "2")
    assert get(browser, "#number").text == "Question 1 of 3"
    assert every(browser, "input:checked") == []
    answer_all(browser)
    assert {(vote.participant, vote.choice) for vote in study.read_votes(saved(browser, tmp_path))} == {("2", "A")}
    get(browser, "#again").click()
    start(browser, "1")
    assert get(browser, "#end").is_displayed()  # whose answers are still there


def visit(browser, address):
    """Open an address; if it differs from the present one in the number only, the page stays."""
    browser.get(address)
    wait_for_the_page(browser)


def test_the_address_names_the_participant(open_page, pages, tmp_path):
    browser = open_page("survey")
    start(browser)
    answer(browser, "B")
    assert get(browser, "#who").text == "Participant 1"

    browser.get("about:blank")
    visit(browser, pages["survey"] + "#2")
    assert get(browser, "#start").is_displayed()
    assert get(browser, "#participant").get_property("value") == "2"
    start(browser, "")
    assert get(browser, "#number").text == "Question 1 of 3"
    assert get(browser, "#who").text == "Participant 2"
    answer_all(browser)
    path = saved(browser, tmp_path)
    assert path.name == "answers-walking-2.csv"
    assert {(vote.participant, vote.choice) for vote in study.read_votes(path)} == {("2", "A")}

    # The number alone changes, as when somebody edits the address: the page is not loaded again.
    visit(browser, pages["survey"] + "#1")
    wait(browser, lambda b: get(b, "#start").is_displayed())
    assert get(browser, "#participant").get_property("value") == "1"
    start(browser, "")
    assert get(browser, "#number").text == "Question 2 of 3"
    get(browser, "#question .back").click()
    assert get(browser, "input[value=B]").is_selected()

    # The present participant goes on at once, also with no number in the address.
    for address in "#1", "":
        browser.get("about:blank")
        visit(browser, pages["survey"] + address)
        assert get(browser, "#number").text == "Question 2 of 3"


def test_another_number_than_that_of_the_address(open_page, pages):
    browser = open_page("survey")
    visit(browser, pages["survey"] + "#7")
    wait(browser, lambda b: get(b, "#participant").get_property("value") == "7")
    get(browser, "#participant").clear()
    start(browser, "8")
    assert browser.current_url == pages["survey"] + "#8"
    answer(browser, "A")
    browser.refresh()
    wait_for_the_page(browser)
    assert (get(browser, "#who").text, get(browser, "#number").text) == ("Participant 8", "Question 2 of 3")
    visit(browser, pages["survey"] + "#p8")  # no number
    assert get(browser, "#who").text == "Participant 8"


def test_tabs_side_by_side_keep_the_answers_of_each(open_page, pages, tmp_path):
    browser = open_page("survey")
    start(browser)
    first = browser.current_window_handle
    browser.switch_to.new_window("tab")
    second = browser.current_window_handle
    try:
        visit(browser, pages["survey"] + "#2")
        start(browser, "")
        answer(browser, "B")
        browser.switch_to.window(first)
        answer(browser, "A")
    finally:
        browser.switch_to.window(second)
        browser.close()
        browser.switch_to.window(first)
    for number, choice in ("2", "B"), ("1", "A"):
        browser.get("about:blank")
        visit(browser, f"{pages['survey']}#{number}")
        start(browser, "")
        get(browser, "#question .back").click()
        assert get(browser, f"input[value={choice}]").is_selected()


@pytest.mark.parametrize(
    "broken",
    [
        "Object.defineProperty(window, 'indexedDB', {get() { throw new DOMException('refused'); }})",
        "IDBObjectStore.prototype.get = () => { throw new DOMException('broken'); }",
    ],
    ids=["no database", "not readable"],
)
def test_a_survey_without_a_database(open_page, broken):
    browser = open_page("survey", before=broken)
    start(browser)
    answer_all(browser)
    assert get(browser, "#end").is_displayed()


def test_a_report_shows_what_is_chosen(open_page):
    browser = open_page("report")
    assert [caption.text for caption in every(browser, ".panels figcaption")] == ["ground truth", *MODELS[:2]]
    assert every(browser, ".panels figure")[0].get_attribute("class") == "truth"
    first = pictures(browser)
    action, sequence = (Select(get(browser, f"#{name}")) for name in ("action", "sequence"))
    assert [option.text for option in action.options] == ["walking", "eating"]
    assert [option.text for option in sequence.options] == ["0", "1"]
    sequence.select_by_visible_text("1")
    assert not set(pictures(browser)) & set(first)
    action.select_by_visible_text("eating")
    assert [option.text for option in sequence.options] == ["0"]
    assert len(every(browser, "canvas")) == 2
    assert get(browser, ".controls output").text == "40 of 800 ms"
    action.select_by_visible_text("walking")
    assert pictures(browser) == first


def test_signatures_are_copied_or_selected(open_page):
    browser = open_page("report")
    signature = get(browser, ".signature code").text
    copy = get(browser, "button.copy")
    browser.execute_script("navigator.clipboard.writeText = async (text) => { window.copied = text; }")
    copy.click()
    wait(browser, lambda _: copy.text == "Copied")
    assert browser.execute_script("return window.copied") == signature
    browser.execute_script("navigator.clipboard.writeText = async () => { throw new DOMException('refused'); }")
    copy.click()
    wait(browser, lambda _: copy.text == "Selected")
    assert browser.execute_script("return String(getSelection())").strip() == signature


def test_a_report_without_motion(open_page, pages, tmp_path):
    path = tmp_path / "bare.html"
    parts = {"boards": [], "signatures": ["one"], "figures": [], "findings": [], "clips": {}}
    path.write_text(report_page(title="Bare", fps=25, skeleton=H36M, **parts), encoding="utf-8")
    pages["bare"] = path.as_uri()
    browser = open_page("bare")
    assert every(browser, "canvas") == []
    get(browser, "button.copy").click()
    wait(browser, lambda b: get(b, "button.copy").text != "Copy")


def test_injected_scripts_do_not_run(open_page, pages, tmp_path, browser):
    path = tmp_path / "smuggled.html"
    parts = {"signatures": [], "figures": [], "findings": [], "clips": {}}
    board = "<script>document.title = 'run'</script><img src='x' onerror=\"document.title = 'run'\">"
    path.write_text(report_page(title="Safe", boards=[board], fps=25, skeleton=H36M, **parts), encoding="utf-8")
    pages["smuggled"] = path.as_uri()
    open_page("smuggled")
    assert browser.title == "Safe"
    assert any("Content Security Policy" in entry["message"] for entry in browser.get_log("browser"))


@pytest.fixture(scope="module")
def four_actions(tmp_path_factory, pages):
    if not GERMAN.exists():
        pytest.skip("the documentation is not beside the tests")
    folder = tmp_path_factory.mktemp("survey")
    write_samples(folder)
    page = folder / "survey.html"
    options = ["--questions", "3", "--attention-checks", "1", "--ties", "--texts", str(GERMAN)]
    assert not main(["study", "page", str(folder), "-o", str(page), *options])
    pages["four"] = page.as_uri()


class TestFourActions:
    """A survey with ties, attention checks, consent and German texts, from the command to the results."""

    @pytest.fixture
    def open_survey(self, four_actions, open_page):
        def visit(**options):
            return open_page("four", **options)

        return visit

    @pytest.mark.parametrize("size", [(1280, 720), (390, 844), (390, 664)])
    def test_everything_is_in_sight(self, open_survey, size):
        browser = open_survey(width=size[0], height=size[1])
        get(browser, "#consent").click()
        start(browser, "1")
        for _ in range(4):
            get(browser, "#next").click()  # with a message that there is no answer
            assert get(browser, "#question-alert").text == "Bitte wählen Sie zuerst."
            assert browser.execute_script(f"return ({OUT_OF_SIGHT})()") == []
            canvas = get(browser, "canvas").rect
            assert min(canvas["height"], canvas["width"]) > 100
            browser.execute_script("document.querySelector('input[value=A]').click()")
            get(browser, "#next").click()
        answer_all(browser)
        assert browser.execute_script(f"return ({OUT_OF_SIGHT})()") == []

    def test_by_keyboard(self, open_survey):
        browser = open_survey()
        keys = ActionChains(browser)
        keys.send_keys(Keys.TAB, Keys.TAB, "1", Keys.ENTER).perform()
        assert browser.switch_to.active_element.get_attribute("id") == "consent"  # asked for again
        assert get(browser, "#start-alert").text.startswith("Bitte stimmen Sie erst zu")
        keys.send_keys(Keys.SPACE, Keys.ENTER).perform()
        wait(browser, lambda b: not get(b, "#start").is_displayed())
        assert get(browser, "#number").text == "Frage 1 von 16"
        keys.send_keys(*[Keys.TAB] * 4, Keys.SPACE, Keys.ARROW_RIGHT, Keys.ARROW_RIGHT).perform()
        assert get(browser, "input[name=choice]:checked").get_attribute("value") == "tie"
        keys.send_keys(Keys.TAB, Keys.TAB, Keys.ENTER).perform()
        assert get(browser, "#number").text == "Frage 2 von 16"
        keys.send_keys(*[Keys.TAB] * 5, Keys.ENTER).perform()  # without an answer, back is the fifth
        assert get(browser, "#number").text == "Frage 1 von 16"

    def test_no_english_is_left(self, open_survey):
        browser = open_survey()
        english, german = (
            tomllib.loads(text) for text in (resource("survey.toml"), GERMAN.read_text(encoding="utf-8"))
        )
        same = {text for text in english.values() if text in german.values()}  # Pause, A, B
        assert get(browser, "html").get_attribute("lang") == "de"
        script = """return [...document.querySelectorAll('*')].filter((e) => !e.matches('script, style, noscript'))
          .flatMap((e) => [e.ariaLabel, e.ariaValueText, ...[...e.childNodes].filter((n) => n.nodeType === 3)
          .map((n) => n.data)])"""
        shown = set(browser.execute_script(script))
        get(browser, "#consent").click()
        start(browser, "1")
        for _ in range(16):
            shown |= set(browser.execute_script(script))
            browser.execute_script("document.querySelector('input[value=A]').click()")
            get(browser, "#next").click()
        shown |= set(browser.execute_script(script))
        shown = {text.strip() for text in shown if text}
        way = "Gehen. Die dicke Linie auf dem Boden ist der bisherige Weg."
        assert {way, "Bewegte Figur: Echte Aufnahme", "40 von 1000 ms", "Beantwortete Fragen"} <= shown
        for text in english.values():
            if isinstance(text, str) and text not in ("", "en", "ltr", *same):
                parts = [part for part in re.split(r"\{\w+\}|\n", text) if len(part.strip()) > 3]
                assert not [part for part in parts if any(part in other for other in shown)]

    def test_figures_travel_or_the_page_says_that_they_do_not(self, open_survey):
        browser = open_survey()
        get(browser, "#consent").click()
        start(browser, "1")
        for _ in range(16):
            where = get(browser, "#action").text
            if "Essen" in where:
                assert where == "Essen. Die Figuren bleiben am Platz, ob der Mensch umherging oder nicht."
            else:
                assert where in [
                    f"{action}. Die dicke Linie auf dem Boden ist der bisherige Weg."
                    for action in ("Gehen", "Rauchen", "Diskutieren")
                ]
            browser.execute_script("document.querySelector('input[value=A]').click()")
            get(browser, "#next").click()

    def test_three_participants(self, open_survey, tmp_path, capsys):
        browser = open_survey()
        votes = tmp_path / "votes"
        for participant in "123":
            get(browser, "#consent").click()
            start(browser, participant)
            for _ in range(16):
                # All prefer the model whose name comes first, but the third participant always takes B.
                browser.execute_script(
                    """
                    const {modelA, modelB, expected} = question(at);
                    const choice = arguments[0] ? 'B' : expected || (modelA < modelB ? 'A' : 'B');
                    document.querySelector(`input[value=${choice}]`).click();
                    document.getElementById('next').click();
                    """,
                    participant == "3",
                )
            (votes / participant).mkdir(parents=True)
            saved(browser, votes / participant).rename(votes / f"{participant}.csv")
            get(browser, "#again").click()
        cast = study.read_votes(votes)
        of = {who: [vote for vote in cast if vote.participant == who] for who in "123"}
        assert [vote.position for vote in of["1"]] == list(range(1, 17))
        assert [(v.action, v.question.mirrored()) for v in reversed(of["1"])] == [
            (v.action, v.question) for v in of["2"]
        ]
        assert {vote.choice for vote in of["3"]} == {"B"}
        counts = study.count_votes(cast)
        assert len(counts) == 12
        for count in counts:
            first = count.a if count.question.model_a < count.question.model_b else count.b
            assert first >= 2
            assert count.a + count.b == 3
        failed = study.attention(cast)[2]
        wrong = sum(vote.question.expected == "A" for vote in of["3"])
        assert (failed.checks, failed.right) == (4, 4 - wrong)
        capsys.readouterr()
        assert not main(["study", "evaluate", str(votes)])
        out = capsys.readouterr().out
        assert f"attention checks: {int(wrong > 0)} of 3 participants failed" in out
        assert "discussion" in out
        if wrong:
            assert f"    3: {4 - wrong} of 4 right; counted" in out
            assert not main(["study", "evaluate", str(votes), "--exclude-failed"])
            out = capsys.readouterr().out
            assert f"    3: {4 - wrong} of 4 right; left out" in out
            assert ["all", "12", "2", "24"] in [line.split()[:4] for line in out.splitlines()]


@pytest.mark.parametrize("size", [(1280, 720), (390, 664)])
def test_a_survey_without_the_recording(open_page, pages, tmp_path, size):
    part = Part(walks(0), {m: walks(i + 1) for i, m in enumerate(MODELS)}, QUESTIONS)
    page = tmp_path / "survey.html"
    page.write_text(survey_page({"walking": part}, seed=0, recording=False), encoding="utf-8")
    pages["alone"] = page.as_uri()
    browser = open_page("alone", width=size[0], height=size[1])
    start(browser)
    assert get(browser, "legend").text == "Which is more natural?"
    assert [caption.text for caption in every(browser, "figcaption")] == ["A", "B"]
    left, right = (figure.rect for figure in every(browser, "figure"))
    assert left["width"] == pytest.approx(right["width"], abs=1)
    assert left["width"] > 0.35 * size[0]
    assert len(set(pictures(browser))) == 2
    assert browser.execute_script(f"return ({OUT_OF_SIGHT})()") == []
    answer_all(browser)
    assert len(study.read_votes(saved(browser, tmp_path))) == 3


def test_a_survey_from_right_to_left(open_page, pages, tmp_path):
    texts = tmp_path / "texts.json"
    words = {**tomllib.loads(resource("survey.toml")), "language": "he", "direction": "rtl", "start": "התחל"}
    texts.write_text(json.dumps(words), encoding="utf-8")
    part = Part(walks(0), {m: walks(i + 1) for i, m in enumerate(MODELS)}, QUESTIONS)
    page = tmp_path / "survey.html"
    page.write_text(survey_page({"walking": part}, seed=0, texts=read_texts(texts)), encoding="utf-8")
    pages["right to left"] = page.as_uri()
    browser = open_page("right to left")
    assert get(browser, "#start-form button").text == "התחל"
    start(browser)
    assert get(browser, "h1#number").rect["x"] > 400
    for places in ("figure", ".choices label"):
        left = [element.rect["x"] for element in every(browser, places)]
        assert left == sorted(left)
