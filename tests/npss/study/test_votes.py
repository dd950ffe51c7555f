"""Votes: files are read strictly, votes are counted and simulated; kappa against statsmodels."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import stats

from npss import study
from studies import HEADER

FIRST, SECOND = study.Question(1, 4, "GRU-d", "VGRU-d"), study.Question(2, 0, "VGRU-ac", "GRU-d")


def write(path, *lines, end="\n"):
    path.write_bytes(end.join([*lines, ""]).encode())
    return path


@pytest.fixture
def path(tmp_path):
    return tmp_path / "votes.csv"


class TestFiles:
    def test_is_read_as_written(self, path):
        write(
            path,
            HEADER,
            "walking,1,4,GRU-d,VGRU-d,p1,A",
            "walking,1,4,GRU-d,VGRU-d,p2,tie",
            "eating,1,0,VGRU-ac,GRU-d,p1,B",
        )
        assert study.read_votes(path) == [
            study.Vote("walking", FIRST, "p1", "A"),
            study.Vote("walking", FIRST, "p2", "tie"),
            study.Vote("eating", study.Question(1, 0, "VGRU-ac", "GRU-d"), "p1", "B"),
        ]

    @given(st.data())
    def test_what_is_written_is_read(self, tmp_path_factory, data):
        names = st.text("Az1 ,;|'\"\n\u00e9", min_size=1, max_size=5).filter(lambda name: name == name.strip())
        models = data.draw(st.lists(names, min_size=2, max_size=3, unique=True))
        rng = np.random.default_rng(0)
        questions = study.design(models, range(3), data.draw(st.integers(1, 4)), seed=rng)
        votes = study.simulate_votes(questions, dict.fromkeys(models, 0.0), 2, action=data.draw(names), seed=rng)
        path = tmp_path_factory.mktemp("votes") / "votes.csv"
        study.write_votes(path, votes)
        assert study.read_votes(path) == votes

    @pytest.mark.parametrize("lead", ["", "\ufeff"])
    @pytest.mark.parametrize("end", ["\n", "\r\n"])
    def test_files_of_spreadsheets(self, path, lead, end):
        write(path, lead + HEADER, '"walking",1,4,GRU-d,"VGRU-d",p1,A', end=end)
        assert study.read_votes(str(path)) == [study.Vote("walking", FIRST, "p1", "A")]

    @pytest.mark.parametrize("separator", [";", "\t", ", ", " ; "])
    def test_separators(self, path, separator):
        lines = [HEADER, 'walking,1,4,GRU-d,"VGRU-d",p1,A', "walking,2,0,VGRU-ac,GRU-d,p1,tie"]
        if separator[0] == " ":
            lines[1] = lines[1].replace('"', "")
        write(path, *(line.replace(",", separator) for line in lines))
        expected = [study.Vote("walking", FIRST, "p1", "A"), study.Vote("walking", SECOND, "p1", "tie")]
        assert study.read_votes(path) == expected

    def test_the_first_line_that_is_not_blank_shows_the_separator(self, path):
        write(path, "", "  ", HEADER.replace(",", ";"), "walking;1;4;GRU-d;VGRU-d;p1;A")
        assert study.read_votes(path) == [study.Vote("walking", FIRST, "p1", "A")]

    def test_large_numbers(self, path):
        write(path, HEADER, "walking,999999999,0,GRU-d,VGRU-d,p1,A")
        assert study.read_votes(path)[0].question.number == 999999999
        write(path, HEADER, "walking,1,1000000000,GRU-d,VGRU-d,p1,A")
        with pytest.raises(ValueError, match=r"votes\.csv: line 2: sequence: expected a whole number"):
            study.read_votes(path)

    def test_a_separator_in_names(self, path):
        write(path, HEADER, 'walking,1,4,"a;b, c",VGRU-d,p;1,A')
        assert study.read_votes(path) == [study.Vote("walking", study.Question(1, 4, "a;b, c", "VGRU-d"), "p;1", "A")]
        write(path, HEADER.replace(",", ";"), "walking;1;4;a, b, c, d, e, f, g, h;VGRU-d;p,,,,,,1;A")
        assert study.read_votes(path) == [
            study.Vote("walking", study.Question(1, 4, "a, b, c, d, e, f, g, h", "VGRU-d"), "p,,,,,,1", "A")
        ]

    def test_blank_lines(self, path):
        write(
            path, "", HEADER, "", "walking,1,4,GRU-d,VGRU-d,p1,A", "   ", ",,,,,,", "walking,2,0,VGRU-ac,GRU-d,p1,B", ""
        )
        assert [vote.choice for vote in study.read_votes(path)] == ["A", "B"]
        write(path, "", HEADER, "", "walking,1,4,GRU-d,VGRU-d,p1,C")
        with pytest.raises(ValueError, match=r"votes\.csv: line 4: choice"):
            study.read_votes(path)

    def test_concatenated_files(self, path):
        """Each with the names of its columns, in its own order, and with its byte order mark."""
        write(
            path,
            HEADER,
            "walking,1,4,GRU-d,VGRU-d,p1,A",
            "\ufeff" + ",".join(reversed(HEADER.split(","))),
            "tie,p2,VGRU-d,GRU-d,4,1,walking",
        )
        expected = [study.Vote("walking", FIRST, "p1", "A"), study.Vote("walking", FIRST, "p2", "tie")]
        assert study.read_votes(path) == expected

    def test_a_folder(self, tmp_path):
        folder = tmp_path / "votes"
        folder.mkdir()
        with pytest.raises(ValueError, match=r"votes: no \.csv files in it"):
            study.read_votes(folder)
        for name, who in (
            ("b.csv", "p2"),
            ("a.CSV", "p1"),
            (".hidden.csv", "p3"),
            ("._b.csv", "p4"),
            ("notes.txt", "p5"),
        ):
            write(folder / name, HEADER, f"walking,1,4,GRU-d,VGRU-d,{who},A")
        extra = write(tmp_path / "extra.csv", HEADER, "walking,1,4,GRU-d,VGRU-d,p0,A")
        assert [vote.participant for vote in study.read_votes(extra, str(folder))] == ["p0", "p1", "p2"]
        write(folder / "c.csv", "name,age")
        with pytest.raises(ValueError, match=r"votes.c\.csv: line 1: expected the columns"):
            study.read_votes(folder)

    def test_columns_in_any_order(self, path):
        write(path, "choice,participant,model_b,model_a,sequence,question,action", "B,p1,VGRU-d,GRU-d,4,1,walking")
        assert study.read_votes(path) == [study.Vote("walking", FIRST, "p1", "B")]

    def test_a_file_of_each_participant(self, tmp_path):
        paths = [
            write(
                tmp_path / f"{who}.csv",
                HEADER,
                f"walking,1,4,GRU-d,VGRU-d,{who},A",
                f"walking,2,0,VGRU-ac,GRU-d,{who},B",
            )
            for who in ("p1", "p2")
        ]
        votes = study.read_votes(*paths)
        assert [(vote.participant, vote.question) for vote in votes] == [
            (who, question) for who in ("p1", "p2") for question in (FIRST, SECOND)
        ]
        copy = write(tmp_path / "copy.csv", *paths[0].read_text(encoding="utf-8").splitlines())
        for again in (copy, paths[0]):
            message = (
                rf"{again.name}: line 2: participant 'p1' answers question 1 of walking again, after .*p1.csv: line 2"
            )
            with pytest.raises(ValueError, match=message):
                study.read_votes(paths[0], again)
        with pytest.raises(TypeError, match=r"paths: expected at least one file$"):
            study.read_votes()

    @pytest.mark.parametrize(
        ("line", "message"),
        [
            ("walking,1,4,GRU-d,VGRU-d,p2", "expected 7 cells, got 6"),
            ("walking,1,4,GRU-d,VGRU-d,p2,A,", "expected 7 cells, got 8"),
            ("walking,1,4,GRU-d,VGRU-d,p2,C", "choice: expected A, B, tie, got 'C'"),
            ("walking,1,4,GRU-d,VGRU-d,p2,a", "choice: expected A, B, tie, got 'a'"),
            ("walking,1,4,GRU-d,VGRU-d,p2,A B", "choice: expected A, B, tie, got 'A B'"),
            ("walking,1,4,GRU-d,VGRU-d,,A", "participant is empty"),
            ('walking,1,4,GRU-d,VGRU-d," ",A', "participant is empty"),
            ("walking;1;4;GRU-d;VGRU-d;p2;A", "expected 7 cells, got 1"),
            (f"{HEADER},age", "expected 7 cells, got 8"),
            ("walking,one,4,GRU-d,VGRU-d,p2,A", "question: expected a whole number, got 'one'"),
            ("walking,1,-4,GRU-d,VGRU-d,p2,A", "sequence: expected a whole number, got '-4'"),
            ("walking,1,4.0,GRU-d,VGRU-d,p2,A", r"sequence: expected a whole number, got '4\.0'"),
            ("walking,1,٤,GRU-d,VGRU-d,p2,A", "sequence: expected a whole number, got '٤'"),
            (f"walking,1,{'9' * 5000},GRU-d,VGRU-d,p2,A", "sequence: expected a whole number, got '999"),
            ("walking,2,4,GRU-d,GRU-d,p2,A", "model_a and model_b are both 'GRU-d'"),
            ("walking,1,5,GRU-d,VGRU-d,p2,A", r"question 1 of walking differs from before: Question\(number=1"),
            ("walking,1,5,VGRU-d,GRU-d,p2,A", "question 1 of walking differs from before"),
            ("walking,1,4,VGRU-d,GRU-d,p1,A", "participant 'p1' answers question 1 of walking again, after .* line 2"),
            ("walking,1,4,GRU-d,VGRU-d,p1,B", "participant 'p1' answers question 1 of walking again, after .* line 2"),
            ('walking,1,4,GRU-d,VGRU-d,"p"2,A', "invalid CSV"),
            ('walking,1,4,GRU-d,"VGRU-d\n\n,p2,A', "invalid CSV"),
            ('walking,1,4,GRU-d,"VGRU\n-d",p2,C', "choice: expected A, B, tie, got 'C'"),
        ],
    )
    def test_bad_lines_are_named(self, path, line, message):
        write(path, HEADER, "walking,1,4,GRU-d,VGRU-d,p1,A", line)
        with pytest.raises(ValueError, match=rf"votes\.csv: line 3: {message}"):
            study.read_votes(path)

    def test_sides_may_be_swapped(self, path):
        write(path, HEADER, "walking,1,4,GRU-d,VGRU-d,p1,A", "walking,1,4,VGRU-d,GRU-d,p2,A")
        assert study.read_votes(path) == [
            study.Vote("walking", FIRST, "p1", "A"),
            study.Vote("walking", FIRST.mirrored(), "p2", "A"),
        ]

    def test_optional_columns(self, path):
        check = study.Question(9, 4, "ground truth", "ground truth, upside down", "A")
        votes = [
            study.Vote("walking", FIRST, "1", "A", 2),
            study.Vote("walking", check, "1", "A", 1),
            study.Vote("walking", FIRST.mirrored(), "2", "tie", 1),
            study.Vote("walking", check.mirrored(), "2", "A", 2),
        ]
        write(
            path,
            f"expected,{HEADER},position",
            ",walking,1,4,GRU-d,VGRU-d,1,A,2",
            'A,walking,9,4,ground truth,"ground truth, upside down",1,A,1',
            ",walking,1,4,VGRU-d,GRU-d,2,tie,1",
            'B,walking,9,4,"ground truth, upside down",ground truth,2,A,2',
        )
        assert study.read_votes(path) == votes
        study.write_votes(path, votes)
        assert path.read_text(encoding="utf-8").splitlines()[0] == f"{HEADER},position,expected"
        assert study.read_votes(path) == votes
        study.write_votes(path, votes[:1])
        assert path.read_text(encoding="utf-8").splitlines() == [f"{HEADER},position", "walking,1,4,GRU-d,VGRU-d,1,A,2"]

    @pytest.mark.parametrize(
        ("line", "message"),
        [
            ("walking,1,4,GRU-d,VGRU-d,p2,A,0,", "position: expected a whole number from 1, got '0'"),
            ("walking,1,4,GRU-d,VGRU-d,p2,A,two,", "position: expected a whole number from 1, got 'two'"),
            ("walking,1,4,GRU-d,VGRU-d,p2,A,1,tie", "expected: expected A, B, got 'tie'"),
            ("walking,1,4,GRU-d,VGRU-d,p2,A,1,A", "question 1 of walking differs from before"),
            ("walking,1,4,GRU-d,VGRU-d,p2,A,1", "expected 9 cells, got 8"),
        ],
    )
    def test_bad_optional_cells(self, path, line, message):
        write(path, f"{HEADER},position,expected", "walking,1,4,GRU-d,VGRU-d,p1,A,,", line)
        with pytest.raises(ValueError, match=rf"votes\.csv: line 3: {message}"):
            study.read_votes(path)

    @pytest.mark.parametrize(
        "header",
        [
            HEADER + ",position,position",
            "",
            HEADER.upper(),
            HEADER + ",age",
            HEADER.removesuffix(",choice"),
            HEADER + ",choice",
            HEADER.replace(",", "|"),
            HEADER.replace(",", ";", 3),
            f"walking,1,4,GRU-d,VGRU-d,p1,A\n{HEADER}",
        ],
    )
    def test_bad_headers(self, path, header):
        write(path, header, "walking,1,4,GRU-d,VGRU-d,p1,A")
        if not header:
            path.write_text(path.read_text(encoding="utf-8").lstrip(), encoding="utf-8")
        with pytest.raises(ValueError, match=r"votes\.csv: line 1: expected the columns action, question, .* got"):
            study.read_votes(path)

    def test_not_utf_8(self, path):
        path.write_bytes(f"{HEADER}\nwalking,1,4,GRU-d,VGRU-d,".encode() + "Jürgen,A\n".encode("latin-1"))
        with pytest.raises(ValueError, match=r"votes\.csv: line 2 is not UTF-8 text"):
            study.read_votes(path)

    def test_empty_or_missing(self, path):
        with pytest.raises(FileNotFoundError):
            study.read_votes(path)
        for lines in [], ["", "  "], [HEADER], [HEADER, "", HEADER]:
            write(path, *lines)
            with pytest.raises(ValueError, match=r"votes\.csv: no votes in it"):
                study.read_votes(path)

    def test_utf_16(self, path):
        path.write_text(HEADER, encoding="utf-16")
        with pytest.raises(ValueError, match=r"votes\.csv: the text is UTF-16; save it as UTF-8"):
            study.read_votes(path)

    @pytest.mark.parametrize("name", ["", " p1", "p1\n", "p\r1"])
    @pytest.mark.parametrize("field", ["action", "model_a", "model_b", "participant"])
    def test_unreadable_names_are_not_written(self, path, field, name):
        write(path, "old")
        of = {"action": "walking", "model_a": "GRU-d", "model_b": "VGRU-d", "participant": "p1", field: name}
        question = study.Question(2, 4, of["model_a"], of["model_b"])
        votes = [
            study.Vote("walking", FIRST, "p1", "A"),
            study.Vote(of["action"], question, of["participant"], "A"),
        ]
        with pytest.raises(ValueError, match=r"votes: expected names without .*, got '.*' in vote 2"):
            study.write_votes(path, votes)
        assert path.read_text(encoding="utf-8") == "old\n"


class TestCounts:
    @pytest.mark.parametrize(
        ("a", "b", "tie", "majority"),
        [(11, 9, 0, "A"), (9, 11, 0, "B"), (10, 10, 0, "tie"), (1, 0, 19, "A"), (0, 0, 20, "tie"), (3, 4, 13, "B")],
    )
    def test_majority(self, a, b, tie, majority):
        assert study.Count("walking", FIRST, a, b, tie).majority == majority

    def test_counts(self):
        answers = [("walking", FIRST, "AABt"), ("walking", SECOND, "tB"), ("eating", FIRST, "A")]
        votes = [
            study.Vote(action, question, f"p{i}", {"t": "tie"}.get(choice, choice))
            for action, question, choices in answers
            for i, choice in enumerate(choices)
        ]
        assert study.count_votes(votes) == [
            study.Count("walking", FIRST, a=2, b=1, tie=1),
            study.Count("walking", SECOND, a=0, b=1, tie=1),
            study.Count("eating", FIRST, a=1, b=0, tie=0),
        ]
        assert study.count_votes([]) == []

    @given(
        st.lists(st.tuples(st.integers(0, 5), st.booleans(), st.sampled_from("AABt")), min_size=1, max_size=30),
        st.randoms(use_true_random=False),
    )
    def test_votes_are_merged_by_question_and_not_by_side_or_place(self, cast, random):
        """Against a count of the models chosen."""
        votes, chosen = [], {}
        for who, (number, swapped, choice) in enumerate(cast):
            models = ("GRU-d", "VGRU-d") if number % 2 else ("VGRU-d", "GRU-d")
            question = study.Question(number, 4, *models)
            shown = question.mirrored() if swapped else question
            choice = {"t": "tie"}.get(choice, choice)
            votes.append(study.Vote("walking", shown, f"p{who}", choice, who + 1))
            model = {"A": shown.model_a, "B": shown.model_b, "tie": "tie"}[choice]
            chosen.setdefault(number, []).append(model)
        random.shuffle(votes)
        counts = study.count_votes(votes)
        assert len(counts) == len(chosen)
        for count in counts:
            asked, models = count.question, chosen[count.question.number]
            expected = [models.count(name) for name in (asked.model_a, asked.model_b, "tie")]
            assert [count.a, count.b, count.tie] == expected
            sides = {vote.question for vote in votes if vote.question.number == asked.number}
            in_order = (asked.model_a < asked.model_b) == bool(asked.number % 2)
            assert sides == {asked} or (len(sides) == 2 and in_order)

    def test_kappa_does_not_take_a_preference_for_chance(self):
        """All prefer one model, whatever its side: as many questions have it as A as B."""
        asked = {"walking": study.design(["one", "two"], range(8), 20, seed=0)}
        votes = [
            study.Vote("walking", question, f"p{who}", "A" if question.model_a == "one" else "B")
            for who, shown in enumerate(study.counterbalance(asked, seed=0))
            for _, question in shown
        ]
        counts = study.count_votes(votes)
        assert study.fleiss_kappa([[count.a, count.b] for count in counts]) == pytest.approx(1)

    def test_attention_checks_are_not_counted(self):
        check = study.Question(9, 4, "ground truth", "upside down", "A")
        votes = [study.Vote("walking", FIRST, "p1", "A"), study.Vote("walking", check, "p1", "A")]
        assert study.count_votes(votes) == study.count_votes(votes[:1])

    def test_attention(self):
        one = study.Question(8, 4, "ground truth", "upside down", "A")
        two = study.Question(9, 1, "upside down", "ground truth", "B")
        answers = {"p1": "AB", "p2": "AA", "p3": ["tie", "B"], "p4": ""}
        votes = [
            study.Vote("walking", question, who, choice)
            for who, choices in answers.items()
            for question, choice in zip([FIRST, one, two], ["B", *choices], strict=False)
        ]
        found = study.attention(votes)
        assert [(of.participant, of.checks, of.right, of.passed) for of in found] == [
            ("p1", 2, 2, True),
            ("p2", 2, 1, False),
            ("p3", 2, 1, False),
            ("p4", 0, 0, True),
        ]
        mirrored = [
            study.Vote(v.action, v.question.mirrored(), v.participant, {"A": "B", "B": "A"}.get(v.choice, v.choice))
            for v in votes
        ]
        assert study.attention(mirrored) == found

    def test_bad_choice(self):
        for function in study.count_votes, study.attention:
            with pytest.raises(ValueError, match="votes: expected a choice of A, B, tie, got 'both'"):
                function([study.Vote("walking", FIRST, "p1", "both")])


class TestSimulation:
    def test_follows_bradley_and_terry(self):
        strengths = {"GRU-d": 0.0, "VGRU-d": 0.7, "VGRU-ac": -40.0}
        votes = study.simulate_votes([FIRST, SECOND], strengths, 4000, action="walking", seed=5)
        first, second = study.count_votes(votes)
        assert stats.binomtest(first.a, 4000, 1 / (1 + np.exp(0.7))).pvalue > 0.001
        assert stats.binomtest(first.a, 4000, 0.5).pvalue < 1e-6
        assert (second.a, second.b) == (0, 4000)
        assert (first.tie, second.tie) == (0, 0)

    def test_attention_checks_are_passed(self):
        check = study.Question(9, 4, "ground truth", "upside down", "B")
        votes = study.simulate_votes([FIRST, check], {"GRU-d": 0, "VGRU-d": 0}, 20, action="walking", seed=0)
        assert all(of.passed and of.checks == 1 for of in study.attention(votes))

    def test_extreme_strengths(self):
        strengths = {"GRU-d": 1e308, "VGRU-d": -1e308}
        (count,) = study.count_votes(study.simulate_votes([FIRST], strengths, 5, action="a", seed=0))
        assert (count.a, count.b) == (5, 0)

    def test_everybody_answers_everything_and_by_the_seed(self):
        strengths = dict.fromkeys(("GRU-d", "VGRU-d", "VGRU-ac"), 0)
        one, same, other = (
            study.simulate_votes([FIRST, SECOND], strengths, 30, action="walking", seed=seed) for seed in (0, 0, 1)
        )
        assert one == same != other
        assert [(vote.participant, vote.question) for vote in one] == [
            (f"p{i}", question) for i in range(1, 31) for question in (FIRST, SECOND)
        ]

    def test_errors(self):
        rng = np.random.default_rng(0)
        for strength in (None, "1", np.inf, np.nan, True):
            strengths = {"GRU-d": 0.0, "VGRU-d": strength}
            with pytest.raises(ValueError, match="strengths: no finite number for 'VGRU-d', got"):
                study.simulate_votes([FIRST], strengths, 3, action="walking", seed=rng)
        with pytest.raises(ValueError, match="n_participants: expected a positive integer"):
            study.simulate_votes([FIRST], {}, 0, action="walking", seed=rng)
        with pytest.raises(TypeError, match=r"seed: expected a whole number or a numpy\.random\.Generator"):
            study.simulate_votes([FIRST], {}, 3, action="walking", seed=np.random.RandomState(0))


class TestKappa:
    def test_published_example(self):
        """Ten questions, fourteen raters, five categories: the example of many texts, .210."""
        counts = np.array(
            [
                *([0, 0, 0, 0, 14], [0, 2, 6, 4, 2], [0, 0, 3, 5, 6], [0, 3, 9, 2, 0], [2, 2, 8, 1, 1]),
                *([7, 7, 0, 0, 0], [3, 2, 6, 3, 0], [2, 5, 3, 2, 2], [6, 5, 2, 1, 0], [0, 2, 2, 3, 7]),
            ]
        )
        assert study.fleiss_kappa(counts) == pytest.approx(0.2099, abs=5e-5)

    @given(arrays(np.int64, st.tuples(st.integers(2, 12), st.just(7)), elements=st.integers(0, 2)))
    def test_is_that_of_statsmodels(self, answers):
        from statsmodels.stats.inter_rater import fleiss_kappa

        counts = np.stack([(answers == choice).sum(axis=1) for choice in range(3)], axis=1)
        if (counts.sum(axis=0) > 0).sum() > 1:
            assert study.fleiss_kappa(counts) == pytest.approx(fleiss_kappa(counts), abs=1e-9)

    def test_full_agreement_chance_and_less(self):
        assert study.fleiss_kappa([[9, 0], [0, 9]]) == pytest.approx(1)
        assert study.fleiss_kappa([[1, 1], [1, 1]]) == pytest.approx(-1)
        by_chance = np.random.default_rng(0).multinomial(20, [0.5, 0.3, 0.2], size=4000)
        assert study.fleiss_kappa(by_chance) == pytest.approx(0, abs=0.005)

    @given(arrays(np.int64, (6, 5), elements=st.integers(0, 1)), st.permutations(range(6)))
    def test_order_and_unused_categories_do_not_matter(self, answers, order):
        counts = np.stack([(answers == choice).sum(axis=1) for choice in range(2)], axis=1)
        if counts.sum(axis=0).all():
            kappa = study.fleiss_kappa(counts)
            assert study.fleiss_kappa(counts[order][:, ::-1]) == pytest.approx(kappa)
            assert study.fleiss_kappa(np.pad(counts, ((0, 0), (0, 1)))) == pytest.approx(kappa)

    @pytest.mark.parametrize(
        ("counts", "error", "message"),
        [
            ([[3, 1], [4, 0], [2, 3]], ValueError, "question 1 was answered by 4 participants, question 3 by 5"),
            ([[3, 1], [2, 3], [4, 0]], ValueError, "question 1 was answered by 4 participants, question 2 by 5"),
            ([[3, 0], [3, 0]], ValueError, "all answers are the same, so kappa is 0/0"),
            ([[1, 0], [0, 1]], ValueError, "agreement needs two participants or more, got 1"),
            ([[0, 0]], ValueError, "agreement needs two participants or more, got 0"),
            ([[3, 1], [5, -1]], ValueError, "negative in question 2"),
            ([3, 1], ValueError, r"expected shape \(questions, categories\), got \(2,\)"),
            (np.zeros((0, 2), int), ValueError, r"expected shape \(questions, categories\), got \(0, 2\)"),
            ([[3.0, 1.0]], TypeError, "expected whole numbers, got dtype float64"),
            ([["3", "1"]], TypeError, "expected real numbers, got strings"),
        ],
    )
    def test_errors(self, counts, error, message):
        with pytest.raises(error, match=f"counts: {message}"):
            study.fleiss_kappa(counts)
