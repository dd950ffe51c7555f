"""Names of models: one line each, never empty, unique."""

import re
from pathlib import Path, PurePosixPath

import pytest
from hypothesis import given
from hypothesis import strategies as st

from npss.ranking._names import model_name, names_of_paths, one_line

FOLDERS = st.sampled_from(["a", "b", "runs", "seed-0", "zero-velocity", "x y"])


@given(st.text())
def test_a_line_is_one_and_can_be_written(name):
    line = one_line(name)
    assert len(line.splitlines()) <= 1
    assert line == line.strip() == one_line(line)
    assert "  " not in line
    line.encode("utf-8")


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("  a \r\n b ", "a b"),
        ("a\x1b[31m\x00b", "a [31m b"),  # else it colours the terminal, or breaks the XML of a picture
        ("a\u2028b\x85c", "a b c"),
        ("a\udcffb", "a\N{REPLACEMENT CHARACTER}b"),  # a byte of a file's name that is no UTF-8
        ("步行 é", "步行 é"),
    ],
)
def test_replaced_characters(name, line):
    assert one_line(name) == model_name(name) == line


@pytest.mark.parametrize("name", ["", " ", "\n\t", "\x00", "\u200b", "\u3000 \u202e"])
def test_a_model_has_a_name(name):
    with pytest.raises(ValueError, match="the name of a model is empty"):
        model_name(name)


@given(st.lists(st.lists(FOLDERS, min_size=1, max_size=4), max_size=8, unique_by=tuple), st.sets(FOLDERS))
def test_each_path_has_a_name_of_its_own_which_ends_it(several, taken):
    paths = [Path("/", "nowhere", *folders) for folders in several]
    names = names_of_paths(paths, taken=taken)
    assert list(names.values()) == paths
    assert not names.keys() & taken
    for name, path in names.items():
        end = PurePosixPath(name).parts
        assert path.parts[-len(end) :] == end
        # No shorter end would do: it is another's, or the end of another one that had to grow, too.
        shorter = end[1:]
        if shorter:
            alike = [other for other in paths if other != path and other.parts[-len(shorter) :] == shorter]
            assert alike or "/".join(shorter) in taken


def test_only_duplicates_get_longer_names(tmp_path):
    for run in ("A/seed-0", "A/seed-1", "C/seed-0", "D/walking.v2"):
        (tmp_path / run).mkdir(parents=True)
    paths = [tmp_path / run for run in ("A/seed-0", "A/seed-1", "C/seed-0", "D/walking.v2")]
    assert list(names_of_paths(paths)) == ["A/seed-0", "seed-1", "C/seed-0", "walking.v2"]


def test_files_are_called_without_their_suffix_and_samples_by_their_folder(tmp_path):
    paths = [tmp_path / name for name in ("model.v2.h5", "other/samples.npz", "more/model.v2.npz")]
    parent = tmp_path.name
    assert list(names_of_paths(paths)) == [f"{parent}/model.v2", "other", "more/model.v2"]


def test_taken_names_are_not_used():
    names = names_of_paths([Path("/d/linear"), Path("/d/pca.h5")], taken=["linear", "pca"])
    assert list(names) == ["d/linear", "d/pca"]


def test_paths_are_named_as_they_are_written(tmp_path, monkeypatch):
    (tmp_path / "seed-7").mkdir()
    (tmp_path / "best").symlink_to("seed-7")
    monkeypatch.chdir(tmp_path / "seed-7")
    for path, name in ((".", "seed-7"), ("..", tmp_path.name), ("../best", "best"), ("../seed-7/", "seed-7")):
        assert list(names_of_paths([Path(path)])) == [name]


@pytest.mark.parametrize(
    "paths",
    [
        ("a/model.h5", "a/model.h5"),
        ("a/model.h5", "b/../a/model.h5"),
        ("a/model.h5", "a/model.npz"),
        ("a/model/samples.h5", "a/model.h5"),
        ("a/my model.h5", "a/my  model.h5"),
    ],
)
def test_duplicate_paths(paths):
    first, second = map(re.escape, paths)
    with pytest.raises(ValueError, match=f"^{second}: duplicate model '.*model', also in {first}$"):
        names_of_paths(map(Path, paths))


@pytest.mark.parametrize("path", ["/", " .h5", "\n"])
def test_paths_without_a_name(path):
    with pytest.raises(ValueError, match="the name of a model is empty"):
        names_of_paths([Path(path)])
