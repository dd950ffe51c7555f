"""A run of a model that a plugin registers: its configuration names the plugin, and never imports it."""

import json
import sys
from contextlib import contextmanager

import pytest

from npss import plugins
from npss_baselines.__main__ import main
from npss_baselines.models import MODELS
from registered import restored

PLUGIN = """\
from npss_baselines.models import MODELS
from registered import restored
from trainings import TINY

MODELS.register("tiny", TINY)
"""
OPTIONS = ["--data", "synthetic", "--iterations", "3", "--recipe.batch", "2", "--device", "cpu"]


@contextmanager
def process():
    """Simulate a process of its own: forget the plugin afterwards."""
    with restored(MODELS):
        yield
    sys.modules.pop("my_model", None)
    plugins._named.clear()


@pytest.fixture(autouse=True)
def _process():
    with process():
        yield


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Return the folder of a run, in the current folder, beside the plugin."""
    folder = tmp_path_factory.mktemp("plugin")
    (folder / "my_model.py").write_text(PLUGIN, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr(sys, "path", list(sys.path))
        with process():
            assert main(["train", "tiny", *OPTIONS, "--out", "run", "--plugin", "my_model"]) == 0
        yield folder / "run"


def test_the_configuration_names_the_plugin(run):
    content = json.loads((run / "config.json").read_text(encoding="utf-8"))
    assert (content["name"], content["plugins"]) == ("tiny", ["my_model"])


@pytest.mark.parametrize(
    "arguments",
    [
        ["evaluate", "run", "--synthetic"],
        ["leaderboard", "run", "--synthetic"],
        ["predict", "run", "--synthetic", "--out", "predicted.npz"],
        ["train", "--resume", "--out", "run"],
        ["train", "--config", "run/config.json", "--out", "other"],
    ],
    ids=lambda arguments: arguments[0],
)
def test_without_the_option_commands_stop_and_print_it(capsys, run, arguments):
    if arguments[0] == "leaderboard":
        pytest.importorskip("pandas")
    assert main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    message = "config.json: a plugin is required; if you trust the module, add --plugin my_model\n"
    assert captured.err.endswith(message)
    assert "my_model" not in sys.modules
    assert main([*arguments[:1], "--plugin", "my_model", *arguments[1:]]) == 0
    assert "my_model" in sys.modules


def test_the_resume_command_names_the_plugin(capsys, run, monkeypatch):
    from npss_baselines.training import trainer

    def interrupted(*arguments, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr(trainer, "train_together", interrupted)
    with pytest.raises(SystemExit):
        main(["--plugin", "my_model", "train", "tiny", *OPTIONS, "--out", "interrupted"])
    assert capsys.readouterr().err.endswith("train --resume --out interrupted --device cpu --plugin my_model\n")
