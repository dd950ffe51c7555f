"""HTML pages without a browser: contents, escapes, and invalid input. See test_browser.py."""

import base64
import hashlib
import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest

from npss import gait, study
from npss._pages import Figure, Part, report_page, survey, survey_page
from npss._pages.texts import Texts, english
from npss.commands import motion_page
from npss.files._samples import read_poses
from npss.skeleton import H36M, Skeleton, poses_to_positions

EVIL = "</script><script>alert('&amp;')</script><!--\"\u2028{count}"


class Page(HTMLParser):
    """The tags of a page, its text and its data."""

    def __init__(self, html):
        super().__init__()
        self.tags, self.texts, self.data, self.script, self._in = [], [], None, None, None
        self.feed(html)
        self.text = " ".join(self.texts)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        self._in = (tag, dict(attrs).get("id"))

    def handle_endtag(self, tag):
        self._in = None

    def handle_data(self, data):
        if self._in == ("script", "data"):
            self.data = json.loads(data)
        elif self._in == ("script", None):
            self.script = data
        elif self._in != ("style", None):
            self.texts.append(data)

    def attributes(self, tag):
        return [attributes for name, attributes in self.tags if name == tag]


def walks(n=2, n_frames=10, seed=0):
    return poses_to_positions(gait.gait(n, n_frames, seed=seed))


def unpack(text, joints):
    return np.frombuffer(base64.b64decode(text), "<i2").reshape(-1, joints, 3)


def require_motion(text, figure, positions, skeleton=H36M):
    """Assert that packed motion, seen through the bones of the page, is these positions."""
    joints = 1 + max(max(child, parent) for child, parent, _ in figure["bones"])
    motion = unpack(text, joints)
    assert len(figure["bones"]) == len(skeleton.bones)
    for (child, parent, side), (true_child, true_parent) in zip(figure["bones"], skeleton.bones, strict=True):
        assert side == skeleton.sides[true_child]
        for joint, true_joint in ((child, true_child), (parent, true_parent)):
            np.testing.assert_allclose(motion[:, joint], positions[:, true_joint], rtol=0, atol=0.5 + 1e-9)


def questions():
    return [
        study.Question(1, 1, "model one", "model two"),
        study.Question(2, 0, EVIL, "model one"),
        study.Question(3, 1, "model one", "model two"),
    ]


def make_survey(asked=None, action="walking", **options):
    models = {"model one": walks(seed=1), "model two": walks(seed=2), EVIL: walks(seed=3)}
    part = Part(walks(), models, questions() if asked is None else asked)
    return survey_page({action: part}, **{"seed": 0, **options})


def evil_texts():
    usual = english().all()
    texts = {name: text if name in ("language", "direction") else EVIL for name, text in usual.items()}
    return Texts({**texts, "actions": {"walking": EVIL}})


def make_report(**parts):
    empty = {"boards": [], "signatures": [], "figures": [], "findings": [], "clips": {}}
    return report_page(**{"title": "A report", "fps": 25, "skeleton": H36M, **empty, **parts})


PAGES = {
    "survey": lambda: make_survey(action=EVIL),
    "survey with texts": lambda: make_survey(texts=evil_texts(), ties=True),
    "report": lambda: make_report(
        title=EVIL,
        boards=["<table class='board'><tr><td>1</td></tr></table>"],
        signatures=[EVIL],
        figures=[Figure(EVIL, f"<svg xmlns='http://www.w3.org/2000/svg'><!-- {EVIL} --></svg>", EVIL)],
        parts=[(EVIL, [EVIL])],
        findings=[(EVIL, [EVIL])],
        clips={EVIL: {EVIL: walks()}},
    ),
}
pages = pytest.mark.parametrize("html", [make() for make in PAGES.values()], ids=list(PAGES))


@pages
def test_names_cannot_break_out_of_their_place(html):
    page = Page(html)
    assert len(page.attributes("script")) == 2
    assert "alert(" not in page.script
    if "actions" not in page.data or page.data["texts"]["title"] == EVIL:
        assert EVIL in page.text  # a survey shows names of actions by its script
    assert EVIL in json.dumps(page.data, ensure_ascii=False).replace('\\"', '"')
    assert not any(name.startswith("on") for _, attributes in page.tags for name in attributes)


@pages
def test_a_page_asks_nothing_of_the_network(html):
    page = Page(html)
    for _, attributes in page.tags:
        for name in ("src", "href", "action", "data", "srcset"):
            assert attributes.get(name, "data:").startswith(("data:", "#"))
    assert not re.search(r"@import|url\(|fetch\(|XMLHttpRequest|https?://", html)
    policy = next(a["content"] for a in page.attributes("meta") if a.get("http-equiv") == "Content-Security-Policy")
    assert policy.startswith("default-src 'none';")
    digest = base64.b64encode(hashlib.sha256(page.script.encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}';" in policy


@pages
def test_every_control_has_a_label(html):
    page = Page(html)
    labelled = {attributes["for"] for attributes in page.attributes("label") if "for" in attributes}
    for tag in ("input", "select"):
        for attributes in page.attributes(tag):
            assert attributes.get("type") in ("radio", "checkbox") or attributes["id"] in labelled
    assert page.attributes("html") == [{"lang": "en", "dir": "ltr"}]
    ids = [attributes["id"] for _, attributes in page.tags if "id" in attributes]
    assert len(ids) == len(set(ids))


def test_a_survey_holds_the_questions_and_their_motions():
    data = Page(make_survey()).data
    key = json.loads(base64.b64decode(data["key"]))
    truth = walks()
    models = {"model one": walks(seed=1), "model two": walks(seed=2), EVIL: walks(seed=3)}
    assert data["figure"]["fps"] == 25
    for kept, hidden, question in zip(data["questions"], key, questions(), strict=True):
        assert (kept["number"], kept["sequence"]) == (question.number, question.sequence)
        assert hidden == [question.model_a, question.model_b, None]
        for place, motion in (("truth", truth), ("a", models[question.model_a]), ("b", models[question.model_b])):
            require_motion(data["motions"][kept[place]], data["figure"], motion[question.sequence])
    assert len(data["motions"]) == 6  # each once: the third question asks about the motions of the first


def test_a_survey_is_blind():
    html = make_survey([*questions(), study.Question(4, 0, "ground truth", "ground truth, upside down", "A")])
    for secret in ("model one", "model two", "ground truth", "upside down"):
        assert secret not in html.replace(Page(html).script, "")
    assert "This survey has 4 questions" in Page(html).text


def test_a_survey_holds_the_orders_and_sides_of_a_block():
    data = Page(make_survey(seed=5)).data
    assert data["orders"] == [
        [2 * (question.number - 1) + (question not in questions()) for _, question in shown]
        for shown in study.counterbalance({"walking": questions()}, seed=5)
    ]


def test_an_attention_check_shows_the_recording_and_the_recording_upside_down():
    check = study.Question(4, 1, "ground truth, upside down", "ground truth", "B")
    data = Page(make_survey([*questions(), check])).data
    kept = data["questions"][-1]
    assert json.loads(base64.b64decode(data["key"]))[-1] == [check.model_a, check.model_b, "B"]
    truth = walks()[1]
    require_motion(data["motions"][kept["truth"]], data["figure"], truth)
    assert kept["b"] == kept["truth"]
    y = truth[..., 1]
    turned = np.stack([truth[..., 0], y.max() - (y - y.min()), truth[..., 2]], axis=-1)
    require_motion(data["motions"][kept["a"]], data["figure"], turned)


def test_options_of_a_survey():
    def values(html):
        return [a["value"] for a in Page(html).attributes("input") if a.get("type") == "radio"]

    assert values(make_survey()) == ["A", "B"]
    assert values(make_survey(ties=True)) == ["A", "B", "tie"]
    usual = {**english().all(), "actions": {"walking": "Gehen"}}
    consent = [a for a in Page(make_survey()).attributes("input") if a.get("id") == "consent"]
    assert consent == []
    html = make_survey(texts=Texts({**usual, "about": "One.\n\nTwo {count}.", "language": "de"}))
    assert [a["type"] for a in Page(html).attributes("input") if a.get("id") == "consent"] == ["checkbox"]
    assert "<p>One.</p>\n<p>Two {count}.</p>" in html
    assert Page(html).data["actions"] == [{"action": "walking", "name": "Gehen", "inPlace": False}]
    assert Page(html).attributes("html")[0]["lang"] == "de"


def test_another_survey_has_another_place_for_its_answers():
    ids = {
        Page(html).data["id"]
        for html in (
            make_survey(),
            make_survey(),
            make_survey(questions()[:2]),
            make_survey(action="eating"),
            make_survey(fps=50),
        )
    }
    assert len(ids) == 4


def test_other_skeletons():
    stick = Skeleton(["foot", "middle", "LeftEnd"], [-1, 0, 1], [[0, 0, 0], [0, 0, 0], [0, 1000, 0]])
    motion = np.random.default_rng(0).normal(size=(1, 5, 3, 3)) * 1000
    motion[:, :, 0] = motion[:, :, 1]
    data = Page(make_report(clips={"a": {"truth": motion}}, skeleton=stick)).data
    assert data["figure"]["bones"] == [[1, 0, "left"]]
    require_motion(data["clips"][0]["motions"][0]["sequences"][0], data["figure"], motion[0], stick)


def test_a_report_holds_its_parts():
    clips = {"walking": {"ground truth": walks(), "a model": walks(seed=1)}, "eating": {"truth": walks(1, 7)}}
    html = make_report(
        boards=["<table class='board'><tr><td>first</td></tr></table>", "<table class='board'></table>"],
        signatures=["npss|version:1|convention:paper|frames:100", "another"],
        figures=[Figure("Spectra", "<svg>é</svg>", "What."), Figure("Errors", b"\x89PNG", "Why.")],
        parts=[("walking", ["a model: form"])],
        findings=[("a model", ["It is slow.", "It is late."]), ("another", [])],
        clips=clips,
    )
    page = Page(html)
    assert [a["id"] for a in page.attributes("section")] == [
        *("leaderboard", "motion", "parts", "diagnosis", "pictures", "signatures", "cite"),
    ]
    assert len(page.attributes("table")) == 2
    for text in ("npss|version:1|convention:paper|frames:100", "It is late.", "Why.", "Gopalakrishnan"):
        assert text in page.text
    svg, png = (attributes["src"] for attributes in page.attributes("img"))
    assert base64.b64decode(svg.removeprefix("data:image/svg+xml;base64,")).decode() == "<svg>é</svg>"
    assert base64.b64decode(png.removeprefix("data:image/png;base64,")) == b"\x89PNG"
    assert [attributes["alt"] for attributes in page.attributes("img")] == ["Spectra", "Errors"]
    assert [clip["name"] for clip in page.data["clips"]] == ["walking", "eating"]
    for clip, labelled in zip(page.data["clips"], clips.values(), strict=True):
        for kept, (label, motion) in zip(clip["motions"], labelled.items(), strict=True):
            assert kept["label"] == label
            for packed, positions in zip(kept["sequences"], motion, strict=True):
                require_motion(packed, page.data["figure"], positions)


def test_empty_parts_of_a_report_are_left_out():
    page = Page(make_report())
    assert [a["id"] for a in page.attributes("section")] == ["cite"]
    assert "#motion" not in [a["href"] for a in page.attributes("a")]


@pytest.mark.parametrize(
    ("clips", "error", "message"),
    [
        ({"a": {}}, ValueError, r"clips\['a'\]: no motion"),
        (
            {"a": {"t": walks(2), "m": walks(1)}},
            ValueError,
            r"clips\['a'\]: labels have different .*: \[1, 2\]",
        ),
        ({"a": {"t": walks()[0]}}, ValueError, r"clips\['a'\]\['t'\]: expected shape \(N, T, 32, 3\), got"),
        ({"a": {"t": walks()[:, :0]}}, ValueError, r"clips\['a'\]\['t'\]: no motion in an array of shape"),
        ({"a": {"t": walks() * np.nan}}, ValueError, r"clips\['a'\]\['t'\]: nan at index"),
        ({"a": {"t": walks() * 1000}}, ValueError, r"clips\['a'\]\['t'\]: a joint is .* mm from the origin"),
        ({"a": {"t": walks() > 0}}, TypeError, r"clips\['a'\]\['t'\]: expected real numbers"),
    ],
)
def test_bad_clips(clips, error, message):
    with pytest.raises(error, match=f"^{message}"):
        make_report(clips=clips)


def test_bad_rate():
    with pytest.raises(ValueError, match=r"^fps: expected a positive"):
        make_report(fps=0)


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ([], r"parts\['walking'\]: expected one question or more"),
        (
            [study.Question(1, 0, "model one", "model 2")],
            r"parts\['walking'\]: question 1: no predictions of 'model 2'; expected one of",
        ),
        (
            [study.Question(1, 0, "model one", "model one")],
            r"parts\['walking'\]: question 1: it compares 'model one' with itself",
        ),
        (
            [*questions(), study.Question(4, 2, "model one", "model two")],
            r"parts\['walking'\]: question 4: no sequence 2; expected 0 to 1",
        ),
        ([study.Question(1, -1, "model one", "model two")], r"parts\['walking'\]: question 1: no sequence -1"),
        ([study.Question(1, 0.0, "model one", "model two")], r"parts\['walking'\]: question 1: no sequence 0.0"),
        (
            [study.Question(1, 0, "ground truth", "model two", "A")],
            r"parts\['walking'\]: question 1: no predictions of 'model two'; expected one of ground truth, ",
        ),
        (
            [study.Question(1, 0, "ground truth", "model two")],
            r"parts\['walking'\]: question 1: no predictions of 'ground truth'",
        ),
    ],
)
def test_bad_questions(asked, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        make_survey(asked)


def test_bad_models():
    with pytest.raises(
        ValueError, match=r"^parts\['go'\]: models\['a'\]: its shape \(1, 10, 32, 3\) differs from that of truth, \(2, "
    ):
        survey_page({"go": Part(walks(), {"a": walks(1), "b": walks()}, questions())}, seed=0)


def save(path, poses, action="walking", gt=None):
    """Write a file of samples, ground truth from seed 0 unless told."""
    truth = gait.gait(len(poses), poses.shape[1], seed=0) if gt is None else gt
    arrays = {}
    for i, (true, pred) in enumerate(zip(truth, poses, strict=True)):
        arrays[f"expmap/gt/{action}_{i}"], arrays[f"expmap/preds/{action}_{i}"] = true, pred
    np.savez(path, **arrays)


def random_gait(seed, n=3):
    return gait.gait(n, 10, seed=seed)


@pytest.fixture
def folder(tmp_path):
    truth = random_gait(0)
    save(tmp_path / "zero.npz", np.repeat(truth[:, :1], 10, axis=1), gt=truth)
    save(tmp_path / "model.v2.npz", random_gait(1), gt=truth + 5e-4)
    save(tmp_path / "other.npz", random_gait(2), gt=truth)
    (tmp_path / "notes.txt").write_text("not read", encoding="utf-8")
    return tmp_path


def test_a_survey_of_a_folder(folder):
    data = Page(survey(folder, n_questions=7, seed=3, root="fixed").page).data
    key = json.loads(base64.b64decode(data["key"]))
    assert data["actions"] == [{"action": "walking", "name": "Walking", "inPlace": True}]
    # The same questions as drawn here.
    names = ["model.v2", "other", "zero"]
    expected = study.design(names, range(3), 7, seed=3)
    files = {name: read_poses(folder / f"{name}.npz")[0] for name in names}
    for kept, hidden, question in zip(data["questions"], key, expected, strict=True):
        assert study.Question(kept["number"], kept["sequence"], *hidden) == question
        motions = {
            "truth": files["model.v2"].gt,
            "a": files[question.model_a].pred,
            "b": files[question.model_b].pred,
        }
        for place, poses in motions.items():
            motion = poses_to_positions(poses[question.sequence])
            require_motion(data["motions"][kept[place]], data["figure"], motion)
    assert survey(folder, n_questions=7, seed=3, actions=["walking"]) == survey(folder, n_questions=7, seed=3)
    assert survey(folder, n_questions=7, seed=3) != survey(folder, n_questions=7, seed=4)


def test_what_to_know_about_a_survey(folder):
    made = survey(folder, n_questions=7, seed=3, attention_checks=1)
    data = Page(made.page).data
    assert made.n_questions == len(data["questions"]) == 8
    assert made.block == len(data["orders"]) == 8
    assert str(made) == (
        "8 questions for each participant\n"
        "8 participants are a block, balanced in order and sides: give the numbers 1 to 8, or to 16, ...\n"
        "walking: the figures travel"
    )
    fixed = survey(folder, n_questions=7, seed=3, root="fixed")
    assert (fixed.block, fixed.in_place) == (14, {"walking": "fixed on request"})
    assert str(fixed).endswith("\nwalking: the figures stay in place: fixed on request")


def test_a_survey_without_the_recording():
    check = study.Question(4, 1, "ground truth, upside down", "ground truth", "B")
    html = make_survey([*questions(), check], recording=False)
    data = Page(html).data
    assert all(question["truth"] is None for question in data["questions"])
    assert len(data["motions"]) == 6  # four of models, and two of the check
    text = Page(html).text
    assert text.count("more natural") == 4  # the title twice
    assert "recording" not in text.lower()
    assert "Which is closer to the real recording?" in Page(make_survey()).text


def test_a_folder_with_too_few_files(folder):
    (folder / "zero.npz").unlink()
    (folder / "other.npz").unlink()
    with pytest.raises(ValueError, match=r"a survey needs two or more models; files of samples in it: 1$"):
        survey(folder, n_questions=1, seed=0)
    (folder / "model.v2.h5").write_bytes(b"")
    with pytest.raises(ValueError, match=r"duplicate model 'model\.v2'"):
        survey(folder, n_questions=1, seed=0)


def test_the_actions_of_a_survey(folder):
    with pytest.raises(ValueError, match=r"^actions: expected some of walking, which all files have, got 'eating'"):
        survey(folder, n_questions=1, seed=0, actions=["walking", "eating"])
    for wrong in ([], ["walking", "walking"]):
        with pytest.raises(ValueError, match=r"^actions: expected one or more without duplicates, got"):
            survey(folder, n_questions=1, seed=0, actions=wrong)
    save(folder / "third.npz", random_gait(3), action="eating")
    with pytest.raises(ValueError, match=r": no action is in all of its files of samples"):
        survey(folder, n_questions=1, seed=0)


def test_several_actions(tmp_path):
    def save_actions(name, actions):
        poses = {f"expmap/{kind}/{action}_0": random_gait(0)[0] for kind in ("gt", "preds") for action in actions}
        np.savez(tmp_path / f"{name}.npz", **poses)

    def actions_of(**options):
        data = Page(survey(tmp_path, n_questions=2, seed=0, attention_checks=1, **options).page).data
        assert len(data["questions"]) == 3 * len(data["actions"]) == len(data["orders"][0])
        return [action["action"] for action in data["actions"]]

    save_actions("one", "ab")
    save_actions("two", "ab")
    assert actions_of() == ["a", "b"]
    assert actions_of(actions=["b"]) == ["b"]
    save_actions("three", "abc")
    with pytest.raises(ValueError, match=r"^actions: only some files have c; expected some of a, b, in all files"):
        survey(tmp_path, n_questions=1, seed=0)
    assert actions_of(actions=["b", "a"]) == ["b", "a"]


def test_ground_truths_that_differ(folder):
    truth = random_gait(0)
    truth[1, 5, 20] += 0.01
    save(folder / "other.npz", random_gait(2), gt=truth)
    with pytest.raises(ValueError, match=r"'model\.v2' and 'other' differ \(by up to 0\.0\d+, in sequence 1\)"):
        survey(folder, n_questions=1, seed=0)


class TestAnyMotion:
    """Positions of a skeleton of four joints, in metres with z up, described by a meta."""

    PARENTS = (-1, 0, 1, 0)

    @pytest.fixture
    def write(self, tmp_path):
        rng = np.random.default_rng(0)
        truth = rng.normal(size=(2, 12, 4, 3))

        def write(model, moved=True, **changed):
            pred = truth + rng.normal(size=truth.shape) / 10
            pred[:, :, 0] = pred[:, :, 0] if moved else [1, 2, 3]
            meta = {
                "representation": "positions",
                "fps": 30,
                "parents": self.PARENTS,
                "unit": "m",
                "up": "z",
                **changed,
            }
            arrays = {"all/gt": truth, "all/pred": pred, "meta": json.dumps(meta)}
            np.savez(tmp_path / f"{model}.npz", **arrays)
            return truth, pred

        return write

    def motions(self, folder, **options):
        """Return the page, and the motions of the first question's recording and A, by its sequence and model."""
        page = Page(survey(folder, n_questions=1, seed=0, **options).page)
        (question,) = page.data["questions"]
        ((model, _, _),) = json.loads(base64.b64decode(page.data["key"]))
        shown = [unpack(page.data["motions"][question[place]], 4) for place in ("truth", "a")]
        return page.data, question["sequence"], model, shown

    def test_is_shown(self, write, tmp_path):
        of_models = {model: write(model) for model in ("one", "two")}
        data, sequence, model, shown = self.motions(tmp_path)
        assert data["figure"]["fps"] == 30
        assert data["figure"]["bones"] == [[1, 0, "centre"], [2, 1, "centre"], [3, 0, "centre"]]
        assert data["actions"] == [{"action": "all", "name": "All", "inPlace": False}]
        for motion, kept in zip(of_models[model], shown, strict=True):
            # z up is y up; the root begins at the origin of the floor.
            expected = motion[sequence][..., [1, 2, 0]] * 1000
            expected -= expected[0, 0] * [1, 0, 1]
            np.testing.assert_allclose(kept, expected, rtol=0, atol=0.5 + 1e-9)

    @pytest.mark.parametrize("options", [{}, {"root": "fixed"}])
    def test_a_root_that_does_not_move_keeps_all_in_place(self, write, tmp_path, options):
        write("one")
        write("two", moved=bool(options))
        data, _, _, shown = self.motions(tmp_path, **options)
        assert data["actions"][0]["inPlace"]
        for motion in shown:
            assert not motion[:, 0, [0, 2]].any()

    def test_errors(self, write, tmp_path):
        write("one")
        write("two", parents=(-1, 0, 0, 0))
        with pytest.raises(ValueError, match=r"^'two' on 'all': its parents or joint_names differ"):
            survey(tmp_path, n_questions=1, seed=0)
        write("two")
        with pytest.raises(
            ValueError, match=r"^root_steps: only for poses of Human3\.6M, and all is described by a meta"
        ):
            survey(tmp_path, n_questions=1, seed=0, root_steps=2)
        for model in ("one", "two"):
            meta = {"representation": "quaternion", "fps": 30}
            motion = np.ones((1, 5, 4))
            np.savez(tmp_path / f"{model}.npz", **{"all/gt": motion, "all/pred": motion, "meta": json.dumps(meta)})
        with pytest.raises(
            ValueError, match=r"^'ground truth' on 'all': cannot be shown: representation is 'quaternion'"
        ):
            survey(tmp_path, n_questions=1, seed=0)


def test_a_survey_of_real_predictions(samples_root, tmp_path):
    path = samples_root / "wookay_walking_10000.h5"
    (tmp_path / path.name).write_bytes(path.read_bytes())
    real = read_poses(path)[0]
    save(tmp_path / "zero-velocity.npz", np.repeat(real.gt[:, :1], 100, axis=1), gt=real.gt)
    html = survey(tmp_path, n_questions=8, seed=0, root="fixed").page
    data = Page(html).data
    assert len(html) < 26_000 * len(data["motions"]) + 60_000
    for kept in data["questions"]:
        motion = poses_to_positions(real.gt[kept["sequence"]])
        require_motion(data["motions"][kept["truth"]], data["figure"], motion)


class TestMotions:
    def test_motions_side_by_side(self):
        long, short = walks(2)[0], walks(2, 7)[1]
        html = motion_page(
            {EVIL: long, "after": short}, title=EVIL, fps=30, skeleton=H36M, truth=EVIL, notes=[EVIL, "a note"]
        )
        page = Page(html)
        assert [(panel["label"], panel["truth"]) for panel in page.data["panels"]] == [(EVIL, True), ("after", False)]
        for panel, positions in zip(page.data["panels"], (long, short), strict=True):
            require_motion(panel["motion"], page.data["figure"], positions)
        assert page.data["figure"]["fps"] == 30
        assert page.text.count(EVIL) == 3  # title, headline, note
        assert "a note" in page.text
        assert len(page.attributes("script")) == 2

    def test_nothing_more_is_needed(self):
        page = Page(motion_page({"walk": walks(1)[0]}, title="walk", fps=30, skeleton=H36M))
        assert [panel["truth"] for panel in page.data["panels"]] == [False]
        assert not page.attributes("ul")

    def test_spans_can_be_looked_at(self):
        spans = [("frames 12 to 23: held", 0.1, 0.2), (EVIL, 0.2, 0.3)]
        html = motion_page({"walk": walks(1)[0]}, title="", fps=30, skeleton=H36M, spans=spans, frame_rate=120)
        page = Page(html)
        assert page.data["spans"] == [[0.1, 0.2], [0.2, 0.3]]
        assert page.data["figure"]["rate"] == 120
        links = [button for button in page.attributes("button") if button.get("class") == "link"]
        assert [link["data-span"] for link in links] == ["0", "1"]
        assert page.text.count(EVIL) == 1
        for start, end in ((0.2, 0.2), (-1, 1)):
            with pytest.raises(
                ValueError, match=r"^spans: 'gap': expected seconds from 0 on, the first before the last"
            ):
                motion_page({"walk": walks(1)[0]}, title="", fps=30, skeleton=H36M, spans=[("gap", start, end)])

    @pytest.mark.parametrize(
        ("motions", "truth", "message"),
        [
            ({}, None, "motions: expected at least one"),
            ({"a": walks(1)[0]}, "b", "truth: expected one of a, got 'b'"),
            ({"a": walks(1)}, None, "motions['a']: expected shape (N, T, 32, 3), got (1, 1, 10, 32, 3)"),
            ({"a": 1e9 * walks(1)[0]}, None, "motions['a']: a joint is "),
        ],
    )
    def test_invalid_motions(self, motions, truth, message):
        with pytest.raises(ValueError, match=f"^{re.escape(message)}"):
            motion_page(motions, title="", fps=30, skeleton=H36M, truth=truth)
