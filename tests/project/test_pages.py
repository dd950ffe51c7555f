"""Run the Python and the commands of all pages, and draw the picture of the README again."""

import importlib
import re
import shlex

import numpy as np
import pytest

import npss.commands
from command_line import samples
from pages import COMMAND, PAGES, PROJECT, blocks, commands, printed

#: Pages with tests of their own, which give the data, or compare all that is printed.
OWN = {"extending.md", "identify.md", "in-betweening.md", "pictures.md", "scale.md", "study.md", "write-results.md"}
#: How many programs there are in pages whose printed text is compared.
PROGRAMS = {"arrays.md": 1, "comparing.md": 1, "errors.md": 2}
#: What the programs of other pages print, among other things.
PRINTED = {
    "comparing.md": {
        *("of the score", "p = 0.000488", "12 constant predictions"),
        *("assumed independent", "NPSS paper", "npss|version:1|"),
    },
    "errors.md": {"euler_error|version:1|fps:60|average:sum|columns:set|still:zero", "over 10 samples", "draws:10"},
}
NEEDS = {"which-joints.md": "matplotlib", "training-loop.md": "torchmetrics"}

pytestmark = pytest.mark.skipif(not (PROJECT / "docs").exists(), reason="needs the documentation")


def with_blocks(language):
    return [pytest.param(page, id=page.name) for page in PAGES if page.name not in OWN and blocks(page, language)]


@pytest.mark.slow
@pytest.mark.parametrize("page", with_blocks("python"))
def test_python(page, tmp_path):
    """The blocks of a page run in order, in an empty folder, as one program."""
    for package in ("pandas", "scipy", NEEDS.get(page.name)):
        if package:
            pytest.importorskip(package)
    if page.name == "training-loop.md":
        pytest.importorskip("lightning")
    programs = blocks(page, "python")
    assert len(programs) == PROGRAMS.get(page.name, len(programs))
    program = "\n".join(programs)
    output = printed(program, tmp_path)
    assert {text for text in PRINTED.get(page.name, ()) if text not in output} == set()
    if page.name == "arrays.md":  # as a comment
        assert f"# {output}" in program


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with the files that commands name."""
    rng = np.random.default_rng(0)
    gt, pred, other = rng.normal(size=(3, 12, 50, 6)).cumsum(axis=2)
    np.save(tmp_path / "gt.npy", gt)
    np.save(tmp_path / "pred.npy", pred)
    for name, motion in (("mine", pred), ("theirs", other), ("results", pred)):
        np.savez(tmp_path / f"{name}.npz", **{"all/gt": gt, "all/pred": motion})
    (tmp_path / "DIR").mkdir()
    truth = rng.normal(size=(8, 100, 99)) * 0.3
    for name in ("samples.npz", "DIR/ours.npz", "DIR/theirs.npz"):
        np.savez(tmp_path / name, **samples((truth, truth + rng.normal(size=truth.shape) * 0.1)))
    (tmp_path / "package").mkdir()
    (tmp_path / "package" / "__init__.py").touch()
    (tmp_path / "package" / "module.py").write_text(
        "import npss\n\n\ndef my_npss(gt, pred):\n    return npss.score(gt, pred)\n", encoding="utf-8"
    )
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("page", [page for page in with_blocks("sh") if page.id in ("README.md", "score.md")])
def test_commands(page, folder, capsys):
    for package in ("matplotlib", "pandas"):
        pytest.importorskip(package)
    lines = "".join(blocks(page, "sh")).splitlines()
    commands = [shlex.split(line, comments=True) for line in lines if line.startswith("npss ")]
    assert len(commands) >= 4
    for words in commands:
        status = npss.commands.main(words[1:])
        captured = capsys.readouterr()
        assert status == 0, (words, captured.err)


def printed_commands():
    """Yield the commands that pages print, of either package, without what a shell reads."""
    for page in PAGES:
        for line in commands(page) if page.name != "extending.md" else ():  # its own tests have its plugins
            words = shlex.split(COMMAND.search(line)[1], comments=True)
            ends = [words.index(word) for word in (">", "|") if word in words]
            yield pytest.param(words[: min(ends, default=None)], id=f"{page.name}: {line}")


@pytest.mark.parametrize("words", [*printed_commands()])
def test_every_command_is_one(words):
    """Commands whose files a test cannot have, too, name options that there are."""
    if words[0] == "npss":
        parser = npss.commands._main._parser()
    else:
        pytest.importorskip("torch")
        parser = importlib.import_module("npss_baselines.__main__")._parser()
    options = parser.parse_args(words[1:])
    if words[1] == "train":  # its options depend on the model
        arguments = options.arguments
        if arguments[0] == "manifold":
            read = importlib.import_module("npss_baselines.commands.train_manifold").parse
        elif arguments[0] == "restorer":
            parser = importlib.import_module("npss_baselines.commands.train_restorer")._parser()
            read, arguments = parser.parse_args, arguments[1:]
        elif arguments[0] in importlib.import_module("npss_baselines.fitted").FITTED:
            parser = importlib.import_module("npss_baselines.commands.train_fitted")._parser(arguments[0])
            read, arguments = parser.parse_args, arguments[1:]
        else:
            read = importlib.import_module("npss_baselines.commands.train_options").parse
        if "--resume" not in arguments:
            read(arguments[1:] if arguments[0] == "manifold" else arguments)


def test_the_picture_of_the_readme_has_the_numbers_of_today(monkeypatch):
    pytest.importorskip("matplotlib")
    monkeypatch.syspath_prepend(PROJECT / "docs")
    import what_npss_sees

    drawn = (PROJECT / "docs" / "walks.svg").read_text(encoding="utf-8")
    words = [re.findall(r"<text[^>]*>(.*?)</text>", text) for text in (drawn, what_npss_sees.picture())]
    assert words[0] == words[1]
    assert sum("NPSS" in word for word in words[0]) == 3
