"""``npss study``, called as a user calls it; and the programs of docs/study, run as they are printed."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from command_line import run, samples
from npss import published, study
from npss.protocol import SLICES_MS
from pages import PROJECT, blocks, printed
from studies import HEADER, MODELS

PAGE = PROJECT / "docs" / "study.md"


@pytest.fixture
def call(capsys):
    """Return a function that runs the command and returns its exit status, standard output and standard error."""

    def call(*arguments):
        return run(capsys, "study", *arguments)

    return call


@pytest.fixture(scope="module")
def votes(tmp_path_factory):
    """A file of 1600 votes, of people who follow NPSS with some noise."""
    rng = np.random.default_rng(4)
    votes = []
    for action in ("walking", "eating", "smoking", "discussion"):
        scores = study.model_scores(published.records(), MODELS, action=action, metric="released")
        questions = study.design(MODELS, range(8), 20, seed=rng)
        strengths = {model: -score for model, score in scores.items()}
        votes += study.simulate_votes(questions, strengths, 20, action=action, seed=rng)
    path = tmp_path_factory.mktemp("votes") / "votes.csv"
    study.write_votes(path, votes)
    return path


@pytest.fixture
def small(tmp_path):
    """Four questions, which three participants answer: majorities A, B, none, B."""
    answers = {"p1": "A B tie B", "p2": "A B A tie", "p3": "tie A B B"}
    pairs = ["one,two", "two,three", "three,one", "two,one"]
    lines = [
        f"gait,{number},0,{pair},{who},{choice}"
        for who, choices in answers.items()
        for number, (pair, choice) in enumerate(zip(pairs, choices.split(), strict=True), start=1)
    ]
    path = tmp_path / "small.csv"
    path.write_text("\n".join([HEADER, *lines, ""]), encoding="utf-8")
    return path


def records(scores, **more):
    """Return records of scores by convention: {'paper': {'one': 1.0, ...}}."""
    models = next(iter(scores.values()))
    return [
        {"model": model, "action": "gait", "npss": {name: of[model] for name, of in scores.items()}, **more}
        for model in models
    ]


def write(path, value):
    path.write_text(json.dumps(value), encoding="utf-8")
    return path


class TestVotesAlone:
    def test_text(self, call, small):
        status, out, err = call(small)
        assert (status, err) == (0, "")
        rows = [line.split() for line in out.splitlines()]
        kappa = study.fleiss_kappa([[2, 0, 1], [1, 2, 0], [1, 1, 1], [0, 2, 1]])
        for name in ("gait", "all"):
            assert [name, "4", "3", "12", "1", "2", "1", f"{kappa:.3f}"] in rows
        # Of one and two: two A and one tie in question 1; two B and one tie, which is for one too, in question 4.
        # Three participants give no p-value.
        assert ["one", "two", "2", "4", "0", "2", "2", "0", "0", "3", "1.000", "-", "-", "-", "-"] in rows
        assert ["three", "two", "1", "2", "1", "0", "1", "0", "0", "3", "0.667", "-", "-", "-", "-"] in rows
        assert ["one", "three", "1", "1", "1", "1", "0", "0", "1", "2", "0.500", "-", "-", "-", "-"] in rows
        assert "preference_test: two-sided sign-flip test of the shares against 1/2, with the participant as" in out
        assert "    sides: left 4, right 5, tie 3; votes for the motion on the left (A)" in out
        assert "majorities: A or B, whichever has more votes" in out
        assert "NPSS" not in out

    def test_json(self, call, small):
        status, out, err = call(small, "--format", "json")
        assert (status, err) == (0, "")
        told = json.loads(out)
        assert list(told) == ["overall", "actions", "incomplete", "pairs", "meanings"]
        assert told["incomplete"] == {}
        assert told["overall"] == told["actions"]["gait"]
        assert told["overall"]["majorities"] == {"A": 1, "B": 2, "tie": 1}
        assert told["pairs"][0] == {
            "models": ["one", "three"],
            "questions": 1,
            "votes": [1, 1],
            "tied_votes": 1,
            "majorities": [0, 0],
            "tied_majorities": 1,
            "preference": {
                "participants": 2,
                "share": 0.5,
                "interval": None,
                "interval_method": None,
                "p_value": None,
                "corrected": None,
                "method": "sign-flip test over participants",
                "alternative": "two-sided",
            },
        }

    def test_preference(self, call, tmp_path):
        """Eight of nine participants prefer one; the ninth only sees ties."""
        path = tmp_path / "votes.csv"
        lines = [f"gait,{n},0,one,two,p{i},{'A' if i else 'B'}" for i in range(8) for n in (1, 2)]
        path.write_text("\n".join([HEADER, *lines, "gait,1,0,one,two,p8,tie", ""]), encoding="utf-8")
        (expected,) = study.preference_tests(study.read_votes(path))
        (pair,) = json.loads(call(path, "--format", "json")[1])["pairs"]
        assert pair["preference"] == {
            "participants": 8,
            "share": 7 / 8,
            "interval": list(expected.interval),
            "interval_method": "Wilson",
            "p_value": expected.p_value,
            "corrected": expected.p_value,
            "method": "sign-flip test over participants, all 256 flips",
            "alternative": "two-sided",
        }
        low, high = expected.interval
        row = f"one two 2 14 2 1 2 0 0 8 0.875 {low:.3f} {high:.3f} {expected.p_value:.3g} {expected.p_value:.3g}"
        out = call(path)[1]
        assert row.split() in [line.split() for line in out.splitlines()]
        assert "\n    Wilson's interval: one and two\n" in f"{out}\n"
        path.write_text("\n".join([HEADER, "gait,1,0,one,two,p8,tie", ""]), encoding="utf-8")
        row = ["one", "two", "1", "0", "0", "1", "0", "0", "1", "0", *"-----"]
        out = call(path)[1]
        assert row in [line.split() for line in out.splitlines()]
        assert "Wilson's interval:" not in out

    def test_without_kappa(self, call, small, tmp_path):
        fewer = tmp_path / "fewer.csv"
        fewer.write_text("\n".join(small.read_text(encoding="utf-8").splitlines()[:-1]) + "\n", encoding="utf-8")
        _, out, _ = call(fewer)
        assert (
            "fleiss_kappa of gait is not defined: question 1 of gait was answered by 3 participants, "
            "question 4 of gait by 2: kappa needs equal numbers\n"
        ) in out
        assert "    p3: 3 of 4 questions; counted\n" in out
        _, out, _ = call(fewer, "--format", "json")
        assert json.loads(out)["overall"]["fleiss_kappa"] is None
        assert json.loads(out)["incomplete"] == {"p3": 3}

    def test_a_file_of_each_participant(self, call, small, tmp_path):
        lines = small.read_text(encoding="utf-8").splitlines()[1:]
        parts = []
        for who in ("p1", "p2", "p3"):
            parts.append(tmp_path / f"{who}.csv")
            parts[-1].write_text(
                "\n".join([HEADER, *(line for line in lines if f",{who}," in line), ""]), encoding="utf-8"
            )
        assert call(*parts) == call(small)


class TestAttention:
    """Three participants, of whom p2 and p3 fail one of two checks."""

    @pytest.fixture
    def checked(self, tmp_path):
        real, fake = "ground truth", '"ground truth, upside down"'
        lines = [f"{HEADER},position,expected"]
        for who, choices in {"p1": "A A A A B", "p2": "A B B A A", "p3": "B A A tie B"}.items():
            pairs = ["one,two", "one,three", "two,three", f"{real},{fake}", f"{fake},{real}"]
            for number, (pair, choice) in enumerate(zip(pairs, choices.split(), strict=True), 1):
                expected = {4: "A", 5: "B"}.get(number, "")
                lines.append(f"gait,{number},0,{pair},{who},{choice},{number},{expected}")
        path = tmp_path / "checked.csv"
        path.write_text("\n".join([*lines, ""]), encoding="utf-8")
        return path

    def test_who_fails_is_listed_and_counted(self, call, checked):
        status, out, err = call(checked)
        assert (status, err) == (0, "")
        assert out.splitlines()[:3] == [
            "attention checks: 2 of 3 participants failed",
            "    p2: 1 of 2 right; counted",
            "    p3: 1 of 2 right; counted",
        ]
        assert ["all", "3", "3", "9", "3", "0", "0"] in [line.split()[:7] for line in out.splitlines()]
        told = json.loads(call(checked, "--format", "json")[1])
        assert told["attention"] == {
            "participants": 3,
            "failed": {"p2": {"checks": 2, "right": 1}, "p3": {"checks": 2, "right": 1}},
            "excluded": False,
        }

    def test_who_fails_is_excluded_on_request(self, call, checked):
        told = json.loads(call(checked, "--exclude-failed", "--format", "json")[1])
        assert told["attention"]["excluded"]
        overall = told["overall"]
        assert (overall["participants"], overall["votes"], overall["majorities"]["A"]) == (1, 3, 3)
        assert "    p3: 1 of 2 right; left out\n" in call(checked, "--exclude-failed")[1]

    def test_errors(self, call, checked, small):
        assert "VOTES: no attention checks in them, so nobody can be left out" in call(small, "--exclude-failed")[2]
        text = checked.read_text(encoding="utf-8").replace("p1,B,5,B", "p1,A,5,B")
        checked.write_text(text, encoding="utf-8")
        assert "VOTES: every participant failed an attention check" in call(checked, "--exclude-failed")[2]


class TestScores:
    def test_published(self, call, votes):
        status, out, err = call(votes, "--published", "--format", "json")
        assert (status, err) == (0, "")
        told = json.loads(out)
        counts = study.count_votes(study.read_votes(votes))
        majorities = [count.majority for count in counts]
        predictions = {}
        for metric in ("released", "euler_error"):
            ranks = {}
            for action, ranking in told["metrics"][metric]["rankings"].items():
                scores = study.model_scores(published.records(), MODELS, action=action, metric=metric)
                ranks[action] = study.rank(scores)
                assert {place["model"]: place["score"] for place in ranking} == scores
                assert {place["model"]: place["rank"] for place in ranking} == ranks[action]
            said = predictions[metric] = [study.predict(count.question, ranks[count.action]) for count in counts]
            agreement = study.agreement(said, majorities)
            found = told["metrics"][metric]["overall"]
            assert found["agreed"] == agreement.agreed > 0
            assert found["rate"] == agreement.rate()
            assert found["interval"] == list(study.wilson_interval(agreement.agreed, agreement.n))
            by_action = told["metrics"][metric]["actions"].values()
            for name in ("agreed", "disagreed", "tied_votes", "tied_metric"):
                assert sum(of[name] for of in by_action) == found[name] == getattr(agreement, name)
        (comparison,) = told["comparisons"]
        joint = study.joint_agreement(predictions["released"], predictions["euler_error"], majorities)
        assert comparison["joint"] == vars(joint)
        assert comparison["mcnemar_test"] == vars(study.mcnemar_test(joint.only_a, joint.only_b))
        a, b = (study.agreement(predictions[metric], majorities) for metric in ("released", "euler_error"))
        test = study.binomial_test(a.agreed, a.n, b.agreed, b.n)
        assert comparison["binomial_test"]["p_value"] == test.p_value < 0.01
        assert comparison["binomial_test"]["interval_difference"] == list(test.interval_difference)

    def test_text_has_every_number_with_what_it_means(self, call, votes):
        status, out, err = call(votes, "--published")
        assert (status, err) == (0, "")
        told = json.loads(call(votes, "--published", "--format", "json")[1])
        rows = [line.split() for line in out.splitlines()]
        assert ["walking", "VGRU-d", "0.887", "1", "7.165", "3"] in rows
        assert ["discussion", "VGRU-ac", "1.651", "1", "11.687", "2"] in rows
        for metric, name in (("released", "NPSS released"), ("euler_error", "Euler error")):
            of = told["metrics"][metric]["overall"]
            n = of["agreed"] + of["disagreed"]
            low, high = of["interval"]
            row = f"{name} all {of['agreed']}/{n} {of['rate']:.3f} {low:.3f} {high:.3f} {of['tied_votes']} 0"
            assert row.split() in rows
            assert f"    {name}: {told['metrics'][metric]['signatures']['walking']}\n" in out
        (comparison,) = told["comparisons"]
        assert comparison["pairs"] == 60
        assert "NPSS released against Euler error\n  80 questions are about 60 pairs of models on an action\n" in out
        assert f"Yates' correction, one-sided, greater: z = {comparison['binomial_test']['statistic']:.3f}, p = " in out
        assert (
            "McNemar's exact test, one-sided, greater: "
            f"p = {comparison['mcnemar_test']['p_value']:.5g}; both are right on" in out
        )
        for note in ("score", "rank", "rate", "alternative", "binomial_test", "mcnemar_test"):
            assert f"    {note}: {told['meanings'][note]}" in out

    @pytest.mark.parametrize("alternative", ["less", "two-sided"])
    def test_alternative(self, call, votes, alternative):
        _, out, _ = call(votes, "--published", "--alternative", alternative, "--format", "json")
        (comparison,) = json.loads(out)["comparisons"]
        joint = comparison["joint"]
        expected = study.mcnemar_test(joint["only_a"], joint["only_b"], alternative=alternative)
        side = {"less": "one-sided, less", "two-sided": "two-sided"}[alternative]
        assert f"McNemar's exact test, {side}: p =" in call(votes, "--published", "--alternative", alternative)[1]
        assert comparison["mcnemar_test"]["p_value"] == expected.p_value
        assert comparison["binomial_test"]["alternative"] == alternative

    def test_records_of_ones_own_every_convention(self, call, small, tmp_path):
        scores = {"paper": {"one": 1.0, "two": 2.0, "three": 2.0}, "released": {"one": 3.0, "two": 2.0, "three": 1.0}}
        errors = {str(time): 1.0 for time in (80, 160, 320, 400, 560, 1000)}
        path = write(tmp_path / "records.json", records(scores, euler_error=errors))
        status, out, err = call(small, "--scores", path)
        assert (status, err) == (0, "")
        assert "NPSS paper against Euler error" in out
        assert "NPSS released against Euler error" in out
        assert out.count("NPSS paper: signature not stated") == 1
        rows = [line.split() for line in out.splitlines()]
        # By paper, one is before two and three, which are equal: right on questions 1 and 4, silent on 2; 3 is a tie.
        assert ["NPSS", "paper", "all", "2/2", "1.000", "0.342", "1.000", "1", "1"] in rows
        assert ["NPSS", "released", "all", "1/3", "0.333", "0.061", "0.792", "1", "0"] in rows
        assert ["Euler", "error", "all", "0/0", "-", "-", "-", "1", "3"] in rows
        assert "z test" not in out  # of no questions there is none
        assert out.count("McNemar's exact test, one-sided, greater: p = 1; both are right on 0 questions") == 2
        _, out, _ = call(small, "--scores", path, "--convention", "paper")
        assert "NPSS released" not in out

    def test_records_of_each_number_alone(self, call, small, tmp_path):
        errors = {str(time): 1.0 for time in (80, 160, 320, 400, 560, 1000)}
        scores = {"paper": {"one": 1.0, "two": 2.0, "three": 3.0}}
        apart = [{"model": model, "action": "gait", "euler_error": errors} for model in scores["paper"]]
        for record in apart:
            record["signatures"] = {"euler_error": "e"}
        path = write(tmp_path / "records.json", apart + records(scores, signatures={"paper": "p"}))
        told = json.loads(call(small, "--scores", path, "--format", "json")[1])
        assert told["metrics"]["paper"]["signatures"] == {"gait": "p"}
        assert told["metrics"]["euler_error"]["signatures"] == {"gait": "e"}

    def test_of_one_metric_alone(self, call, small, tmp_path):
        path = write(tmp_path / "records.json", records({"paper": {"one": 1.0, "two": 2.0, "three": 3.0}}))
        told = json.loads(call(small, "--scores", path, "--format", "json")[1])
        assert list(told["metrics"]) == ["paper"]
        assert told["comparisons"] == []
        out = call(small, "--scores", path)[1]
        assert "McNemar" not in out
        assert out.endswith(
            "no comparison of metrics: records: they have no Euler error of the models in the votes, "
            "with which other metrics are compared\n"
        )
        errors = {str(time): 1.0 for time in (80, 160, 320, 400, 560, 1000)}
        alone = [{"model": model, "action": "gait", "euler_error": errors} for model in ("one", "two", "three")]
        out = call(small, "--scores", write(path, alone))[1]
        assert "no comparison of metrics: records: they have no other metric of the models" in out

    def test_samples_of_ones_own(self, call, capsys, tmp_path):
        """The folder that `npss study page` shows has the scores of `npss score`."""
        rng = np.random.default_rng(0)
        folder, truth = tmp_path / "samples", rng.normal(size=(2, 25, 99)) * 0.2
        folder.mkdir()
        expected = []
        for model, noise in (("near", 0.01), ("far", 0.3)):
            preds = truth + noise * rng.normal(size=truth.shape)
            path = folder / f"{model}.npz"
            np.savez(path, **samples((truth, preds), action="gait"))
            scored = json.loads(run(capsys, "score", path, "--format", "json")[1])
            expected += [{"model": model, **record} for record in scored]
        votes = tmp_path / "votes.csv"
        votes.write_text(f"{HEADER}\ngait,1,0,near,far,p1,A\n", encoding="utf-8")
        of_folder = call(votes, "--scores", folder, "--format", "json")
        assert of_folder[0] == 0
        assert of_folder == call(votes, "--scores", write(tmp_path / "records.json", expected), "--format", "json")
        told = json.loads(of_folder[1])
        assert told["metrics"]["paper"]["overall"]["agreed"] == 1
        assert {comparison["a"] for comparison in told["comparisons"]} == {"paper", "released", "literal"}

    def test_records_as_evaluate_prints_them(self, call, tmp_path):
        from npss.predictors import PREDICTORS
        from npss_baselines.commands.evaluate import evaluate
        from npss_baselines.data.synthetic import synthetic_task

        task = synthetic_task(2)
        measured = [evaluate(name, PREDICTORS[name], task) for name in ("zero-velocity", "repeat-50")]
        path = write(tmp_path / "records.json", measured)
        votes = tmp_path / "votes.csv"
        votes.write_text(f"{HEADER}\ngait,1,0,zero-velocity,repeat-50,p1,B\n", encoding="utf-8")
        told = json.loads(call(votes, "--scores", path, "--format", "json")[1])
        assert list(told["metrics"]) == ["paper", "released", "literal", "euler_error"]
        for metric, of in told["metrics"].items():
            assert of["signatures"] == {"gait": measured[0]["signatures"][metric]}


class TestErrors:
    def test_of_scores(self, call, small, tmp_path):
        path = tmp_path / "records.json"
        for value, message in (
            ({}, "records.json: expected a list of records"),
            ([1], "records.json: expected a list of records"),
            ([{"action": "gait"}], "records.json: record 0 has no model"),
            ([{"model": "one", "action": 3}], "records.json: record 0 has no action"),
            ([{"model": "one", "action": "gait", "npss": 3.0}], "records.json: record 0: npss is not an object"),
            (
                [{"model": "one", "action": "gait"}],
                "records: neither NPSS nor the Euler error of the models in the votes (gait:",
            ),
            (records({"paper": {"one": 1.0}}), "records: expected one with paper of 'two' on 'gait', got 0"),
        ):
            status, out, err = call(small, "--scores", write(path, value))
            assert (status, out) == (2, "")
            assert message in err
            assert err.count("\n") == 1
        for huge in (10**400, 1e308, float("inf")):
            one = {"model": "one", "action": "gait", "euler_error": dict.fromkeys(map(str, SLICES_MS), huge)}
            assert "records: expected finite numbers as euler_error" in call(small, "--scores", write(path, [one]))[2]
        one = {"model": "one", "action": "gait", "signatures": {"paper": ["npss"]}}
        assert "records.json: record 0: signatures are not strings" in call(small, "--scores", write(path, [one]))[2]
        path.write_text("{", encoding="utf-8")
        assert "records.json: invalid JSON" in call(small, "--scores", path)[2]
        path.write_bytes(b"\xff")
        assert "records.json: line 1 is not UTF-8 text" in call(small, "--scores", path)[2]
        assert "No such file" in call(small, "--scores", tmp_path / "none.json")[2]

    def test_of_votes(self, call, small):
        small.write_text(small.read_text(encoding="utf-8") + "gait,1,0,one,two,p1,A\n", encoding="utf-8")
        status, _, err = call(small)
        assert status == 2
        assert "small.csv: line 14: participant 'p1' answers question 1 of gait again" in err

    def test_models_that_are_not_in_the_tables(self, call, small):
        assert "records: neither NPSS nor the Euler error" in call(small, "--published")[2]

    def test_a_convention_that_is_not_in_the_tables(self, call, votes):
        status, _, err = call(votes, "--published", "--convention", "paper")
        assert status == 2
        assert "records: expected one with paper of" in err

    def test_of_options(self, call, small, tmp_path):
        assert "--convention and --alternative need scores" in call(small, "--alternative", "less")[2]
        assert "unrecognized arguments: -o x.html" in call(small, "-o", "x.html")[2]
        assert "--exclude-failed" in call("evaluate", "--help")[1]
        assert "unrecognized arguments: --published" in call("page", tmp_path, "-o", "x.html", "--published")[2]
        assert "the following arguments are required: -o/--output" in call("page", tmp_path)[2]
        assert "the following arguments are required: COMMAND" in call()[2]
        assert "not allowed with argument --published" in call(small, "--published", "--scores", "x.json")[2]


class TestForms:
    def test_files_alone_are_evaluated(self, call, small, monkeypatch):
        expected = call("evaluate", small, "--format", "json")
        assert expected[0] == 0
        assert call(small, "--format", "json") == call("--format", "json", small) == expected
        monkeypatch.chdir(small.parent)
        for name in ("page", "plan", "texts", "evaluate"):
            assert call("evaluate", small.rename(name)) == call(f"./{name}") == call("evaluate", name)
            Path(name).rename(small)

    def test_a_folder(self, call, small, tmp_path):
        expected = call(small)
        folder = tmp_path / "votes"
        folder.mkdir()
        small.rename(folder / "small.csv")
        assert call(folder) == expected

    @pytest.mark.parametrize("ask", ["-h", "--help"])
    def test_help(self, call, ask):
        status, out, _ = call(ask)
        assert status == 0
        assert all(f"npss study {form}" in out for form in ("plan", "page", "texts", "evaluate", "VOTES"))

    def test_names_of_several_lines_stay_in_theirs(self, call, tmp_path):
        votes = tmp_path / "votes.csv"
        votes.write_text(
            f'{HEADER}\n"slow\ngait",1,1,M1,"M2\nbig",p1,A\n"slow\ngait",1,1,M1,"M2\nbig",p2,B\n', encoding="utf-8"
        )
        scores = [
            {"model": model, "action": "slow\ngait", "npss": {"paper": 1.0}} for model in ("M1", "M2\nbig", "other")
        ]
        _, out, err = call(votes, "--scores", write(tmp_path / "records.json", scores))
        assert err == ""
        rows = [line.split() for line in out.splitlines()]
        assert ["M1", "M2", "big", "1", "1", "1", "0", "0", "0", "1", "2", "0.500", "-", "-", "-", "-"] in rows
        assert ["slow", "gait", "M2", "big", "1.000", "1"] in rows
        assert ["slow", "gait", "1", "2", "2", "0", "0", "1", "-1.000"] in rows
        assert not any(line.startswith(("big", "gait")) for line in out.splitlines())


class TestPlan:
    def test_text(self, call):
        assert call("plan", 0.8, 0.65) == (
            0,
            "122 questions tell 0.8 from 0.65 with a power of 0.802\n"
            "    two-proportion z test, pooled variance, Yates' correction, greater, level 0.05\n",
            "",
        )
        assert call("plan", 0.8, 0.65, "--questions", 80)[1].startswith(
            "80 questions tell 0.8 from 0.65 with a power of 0.621"
        )

    @pytest.mark.parametrize(
        ("options", "arguments"),
        [
            ([], {}),
            (["--power", 0.9], {"power": 0.9}),
            (["--alpha", 0.01, "--alternative", "two-sided"], {"alpha": 0.01, "alternative": "two-sided"}),
            (["--no-correction"], {"correction": False}),
        ],
    )
    def test_is_sample_size_and_power(self, call, options, arguments):
        n = study.sample_size(0.8, 0.65, **arguments)
        arguments.pop("power", None)
        told = json.loads(call("plan", 0.8, 0.65, *options, "--format", "json")[1])
        assert told == {
            **{"p_a": 0.8, "p_b": 0.65, "alternative": "greater", "alpha": 0.05, "correction": True, **arguments},
            **{"questions": n, "power": study.power(0.8, 0.65, n, **arguments)},
        }
        if "--power" not in options:
            told = json.loads(call("plan", 0.8, 0.65, *options, "--questions", 33, "--format", "json")[1])
            assert (told["questions"], told["power"]) == (33, study.power(0.8, 0.65, 33, **arguments))

    def test_errors(self, call):
        for arguments, message in (
            ((0.6, 0.8), "P_A: expected more than the other share, 0.8, for the alternative 'greater', got 0.6; swap"),
            ((1, 0.8), "P_A: expected a number between 0 and 1, exclusive, got 1.0"),
            ((0.8, 0.6, "--questions", 0), "--questions: expected a positive integer, got 0"),
            ((0.8, 0.6, "--power", 1), "power: expected a number between 0 and 1, exclusive, got 1.0"),
            ((0.8, 0.6, "--power", 0.9, "--questions", 9), "not allowed with argument --power"),
            ((0.8,), "the following arguments are required: P_B"),
        ):
            status, out, err = call("plan", *arguments)
            assert (status, out) == (2, "")
            assert message in err


class TestPage:
    @pytest.fixture
    def samples(self, tmp_path):
        rng = np.random.default_rng(0)
        truth = rng.normal(size=(3, 20, 99)) * 0.2
        for model in ("one", "two"):
            arrays = {f"expmap/gt/walking_{i}": motion for i, motion in enumerate(truth)}
            arrays |= {
                f"expmap/preds/walking_{i}": motion + 0.01 * rng.normal(size=motion.shape)
                for i, motion in enumerate(truth)
            }
            np.savez(tmp_path / f"{model}.npz", **arrays)
        return tmp_path

    def test_is_the_survey(self, call, samples):
        from npss._pages import survey

        path = samples / "survey.html"
        made = survey(samples, n_questions=20, seed=0)
        assert call("page", samples, "-o", path) == (0, f"{made}\n", "")
        assert path.read_text(encoding="utf-8") == made.page
        made = survey(samples, n_questions=3, seed=7, actions=["walking"])
        told = call("page", samples, "-o", path, "--questions", 3, "--seed", 7, "--action", "walking")
        assert told == (0, f"{made}\n", "")
        assert path.read_text(encoding="utf-8") == made.page

    def test_options(self, call, samples):
        from npss._pages import survey
        from npss._pages.texts import read_texts

        path, texts = samples / "survey.html", samples / "texts.json"
        texts.write_text('{"title": "Which?"}', encoding="utf-8")
        options = ["--ties", "--attention-checks", 2, "--root", "fixed", "--root-steps", 2, "--texts", texts]
        options.append("--no-recording")
        assert call("page", samples, "-o", path, *options)[0] == 0
        made = {"ties": True, "attention_checks": 2, "root": "fixed", "root_steps": 2, "texts": read_texts(texts)}
        made["recording"] = False
        assert path.read_text(encoding="utf-8") == survey(samples, n_questions=20, seed=0, **made).page

    def test_errors(self, call, samples):
        for options, message in (
            (["--actions", "eating"], "--actions: expected some of walking, which all files have, got 'eating'"),
            (["--attention-checks", -1], "--attention-checks: expected 0 or more, got -1"),
            (["--root-steps", 0], "--root-steps: expected a positive integer, got 0"),
            (["--questions", 0], "expected a positive integer, got 0"),
            (["--texts", samples / "none.toml"], "none.toml"),
            (["--root", "moving"], "argument --root: invalid choice: 'moving'"),
        ):
            status, out, err = call("page", samples, "-o", samples / "survey.html", *options)
            assert (status, out) == (2, "")
            assert message in err
        texts = samples / "texts.toml"
        texts.write_text('title = "Which?"', encoding="utf-8")
        assert "would overwrite an input" in call("page", samples, "-o", texts, "--texts", texts)[2]

    def test_texts(self, call, samples):
        from npss._pages import survey

        status, out, err = call("texts")
        assert (status, err) == (0, "")
        texts = samples / "texts.toml"
        texts.write_text(out, encoding="utf-8")
        made = survey(samples, n_questions=20, seed=0)
        assert call("page", samples, "-o", samples / "survey.html", "--texts", texts) == (0, f"{made}\n", "")
        assert (samples / "survey.html").read_text(encoding="utf-8") == made.page

    def test_a_page_that_cannot_be_written_costs_none(self, call, samples):
        status, _, err = call("page", samples, "-o", samples / "no" / "survey.html")
        assert status == 2
        assert err == f"npss: error: {samples / 'no' / 'survey.html'}: no such folder: {samples / 'no'}\n"


def programs():
    """Return the programs of the page, each with the block after it: what it prints."""
    if not PAGE.exists():
        return []
    text = PAGE.read_text(encoding="utf-8")
    return re.findall(r"^```python\n(.*?)^```\n\n```text\n(.*?)^```", text, flags=re.M | re.S)


@pytest.mark.skipif(not PAGE.exists(), reason="the documentation is not beside the tests")
def test_the_page_shows_what_each_program_prints():
    assert [program for program, _ in programs()] == blocks(PAGE, "python")
    assert len(programs()) == 6


@pytest.mark.parametrize(("program", "shown"), programs())
def test_programs_print_what_the_page_shows(program, shown, tmp_path):
    assert printed(program, tmp_path) == shown
