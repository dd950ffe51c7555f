"""Plugins: who imports them, from where, and the errors of failed imports."""

import importlib.metadata
import os
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from command_line import run
from entry_points import declare
from npss import plugins
from npss.commands import main
from npss.console._parser import split_plugins
from npss.plugins import Registry

SIGNATURE = "npss|version:1|convention:paper"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Import plugins from a temporary current folder, and forget them afterwards."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.setattr(plugins, "_named", {})
    before = set(sys.modules)
    yield tmp_path
    for name in set(sys.modules) - before:
        del sys.modules[name]


def write(folder, **modules):
    for name, text in modules.items():
        (folder / f"{name}.py").write_text(text, encoding="utf-8")


class TestRegistry:
    def test_is_a_mapping_that_grows(self):
        registry = Registry("thing", {"a": 1})
        registry.register("b", 2)
        assert dict(registry) == {"a": 1, "b": 2}
        assert (len(registry), "b" in registry, registry.get("c")) == (2, True, None)
        with pytest.raises(TypeError):
            registry["c"] = 3

    @pytest.mark.parametrize("name", ["", " ", "a\nb", "\x1b[0m"])
    def test_names_can_be_printed(self, name):
        with pytest.raises(ValueError, match=r"^the name of a thing: expected printable text, got "):
            Registry("thing").register(name, 1)

    def test_names_are_text(self):
        with pytest.raises(TypeError, match=r"^the name of a thing: expected text, got 1"):
            Registry("thing").register(1, 1)

    def test_grows_while_it_is_read(self):
        registry = Registry("thing", {"a": 1, "b": 2})
        for name, value in registry.items():
            registry.register(f"{name}2", value)
        assert list(registry) == ["a", "b", "a2", "b2"]

    def test_replaces_only_registered_entries(self):
        registry = Registry("thing", {"a": 1})
        registry.register("b", 2)
        registry.register("b", 3, replace=True)
        assert dict(registry) == {"a": 1, "b": 3}
        with pytest.raises(ValueError, match=r"^the thing 'a' is registered already$"):
            registry.register("a", 2, replace=True)

    def test_knows_the_plugin_of_an_entry(self, folder, monkeypatch):
        registry = Registry("thing", {"a": 1})
        monkeypatch.setattr(plugins, "THINGS", registry, raising=False)
        write(folder, plugin_b="from npss.plugins import THINGS\nTHINGS.register('b', 2)")
        plugins.load("plugin_b")
        registry.register("c", 3)
        assert [registry.plugin(name) for name in registry] == [None, "plugin_b", None]
        with pytest.raises(KeyError):
            registry.plugin("d")
        with pytest.raises(ValueError, match=r"^the thing 'b' is registered already, by plugin_b$"):
            registry.register("b", 4)
        with pytest.raises(ValueError, match=r"^the thing 'c' is registered already$"):
            registry.register("c", 4)


class TestArguments:
    @pytest.mark.parametrize(
        "arguments",
        [
            ["--plugin", "a", "--plugin", "b.c", "explain", SIGNATURE],
            ["explain", "--plugin=a", SIGNATURE, "--plugin", "b.c"],
            ["explain", SIGNATURE, "--plugin=a", "--plugin=b.c"],
        ],
    )
    def test_before_and_after_the_command(self, arguments):
        assert split_plugins(arguments) == (["a", "b.c"], ["explain", SIGNATURE])

    def test_files_may_have_the_name_of_the_option(self):
        assert split_plugins(["score", "--", "--plugin", "a"]) == ([], ["score", "--", "--plugin", "a"])

    @given(st.lists(st.sampled_from(["a", "--pluginx", "--plugi", "-o", "plugin", "x=--plugin"])))
    def test_other_arguments_are_unchanged(self, arguments):
        assert split_plugins(arguments) == ([], arguments)

    @pytest.mark.parametrize("arguments", [["score", "--plugin"], ["--plugin="]])
    def test_without_a_module(self, capsys, arguments):
        message = "npss: error: --plugin: expected the name of a module, such as my.module\n"
        assert run(capsys, *arguments) == (2, "", message)

    def test_is_not_abbreviated(self, capsys):
        status, _, err = run(capsys, "explain", SIGNATURE, "--plug", "a")
        assert (status, "argument --plugin: cannot be abbreviated, write --plugin a" in err) == (2, True)

    @pytest.mark.parametrize("command", [[], ["score"], ["study", "plan"]])
    def test_help_mentions_the_option(self, capsys, command):
        assert "--plugin MODULE" in run(capsys, *command, "--help")[1]
        assert "did you mean --plugin?" in run(capsys, "explain", "a", "--plugins", "b")[2]


class TestLoad:
    def test_a_module_in_the_current_folder(self, capsys, folder):
        write(folder, plugin_a="print('imported')", plugin_b="import plugin_a")
        assert run(capsys, "explain", SIGNATURE, "--plugin", "plugin_b")[:2] == (
            0,
            "imported\n" + run(capsys, "explain", SIGNATURE)[1],
        )
        assert plugins.with_plugins(["a"]) == ["a", "--plugin", "plugin_b"]

    def test_a_module_of_a_package(self, folder):
        (folder / "its").mkdir()
        write(folder / "its", __init__="", plugin="from . import other", other="")
        plugins.load("its.plugin")
        assert "its.other" in sys.modules

    @pytest.mark.parametrize("module", ["json.tool", "npss.gait"])
    def test_installed_modules_come_first(self, folder, module):
        """A data folder must not replace installed code."""
        write(folder, json="raise RuntimeError", npss="raise RuntimeError", plistlib="raise RuntimeError")
        before = list(sys.path)
        plugins.load(module)
        assert sys.path == before

    def test_the_current_folder_comes_last(self, folder):
        write(folder, plugin_a="import wave", wave="raise RuntimeError")
        plugins.load("plugin_a")
        assert sys.path[-1] == str(folder)

    def test_by_the_installed_command(self, tmp_path):
        """In a separate process, whose path does not start with the current folder."""
        write(tmp_path, plugin_a="print('imported')")
        code = "import sys; sys.path[0] = ''; del sys.path[0]; from npss.commands import main; sys.exit(main())"
        command = [sys.executable, "-c", code, "explain", SIGNATURE, "--plugin", "plugin_a"]
        done = subprocess.run(command, capture_output=True, encoding="utf-8", cwd=tmp_path, env=os.environ)
        assert (done.returncode, done.stderr) == (0, "")
        assert done.stdout.startswith("imported\n")

    @pytest.mark.parametrize(
        ("name", "message"),
        [
            ("plugin_a.py", "--plugin: expected the name of a module, such as my.module, got 'plugin_a.py'"),
            ("./plugin_a", "--plugin: expected the name of a module, such as my.module, got './plugin_a'"),
            (".plugin_a", "--plugin: expected the name of a module, such as my.module, got '.plugin_a'"),
            ("nowhere", "--plugin nowhere: there is no module 'nowhere', installed or in the current folder"),
            ("broken.x", "--plugin broken.x: NameError: name 'broken' is not defined ({}/broken.py, line 2)"),
            ("package.x", "--plugin package.x: there is no module 'package.x', in {}/package/__init__.py"),
            ("namespace.x", "--plugin namespace.x: there is no module 'namespace.x', in {}/namespace"),
            ("leaves", "--plugin leaves: SystemExit: 0 ({}/leaves.py, line 1)"),
            ("needs", "--plugin needs: No module named 'nowhere' ({}/needs.py, line 1)"),
            ("syntax", "--plugin syntax: SyntaxError: invalid syntax (syntax.py, line 1)"),
            ("twice", "--plugin twice: ValueError: the thing 'a' is registered already ({}/twice.py, line 2)"),
        ],
    )
    def test_failed_imports(self, capsys, folder, name, message):
        write(
            folder,
            broken="\nbroken",
            needs="import nowhere",
            syntax="1 +* 2",
            leaves="raise SystemExit(0)",
            twice="from npss.plugins import Registry\nRegistry('thing', {'a': 1}).register('a', 2)",
        )
        (folder / "package").mkdir()
        (folder / "namespace").mkdir()
        write(folder / "package", __init__="")
        status, out, err = run(capsys, "explain", SIGNATURE, "--plugin", name)
        assert (status, out) == (2, "")
        assert err == f"npss: error: {message.format(folder)}\n"


BROKEN = """\
import numpy as np
from npss.metrics import Metric, register

def broken(gt, pred):
    {body}

register(Metric(name="broken", function=broken, says="nothing"))
"""


@pytest.mark.usefixtures("registry")
class TestErrors:
    """An error in what a plugin registered names the plugin and the line."""

    @pytest.fixture
    def command(self, folder):
        np.save(folder / "a.npy", np.arange(12.0).reshape(1, 4, 3))

        def command(body):
            write(folder, plugin_a=BROKEN.format(body=body))
            return ["score", "a.npy", "a.npy", "--metrics", "broken", "--plugin", "plugin_a"]

        return command

    @pytest.mark.parametrize(
        ("body", "message"),
        [
            ("raise ValueError('no luck')", "no luck"),
            ("np.zeros(2) + np.zeros(3)", "operands could not be broadcast together with shapes (2,) (3,)"),
            ("open('nowhere')", "nowhere: No such file or directory"),
        ],
    )
    def test_expected_errors_are_one_line(self, capsys, folder, command, body, message):
        status, out, err = run(capsys, *command(body))
        assert (status, out) == (2, "")
        where = f"(raised in the plugin plugin_a: {folder}/plugin_a.py, line 5)"
        assert err == f"npss: error: {message} {where}\n"

    def test_other_errors_keep_their_traceback(self, folder, command):
        with pytest.raises(ZeroDivisionError) as caught:
            main(command("1 / 0"))
        assert caught.value.__notes__ == [f"(raised in the plugin plugin_a: {folder}/plugin_a.py, line 5)"]

    def test_a_cause_counts(self, folder, command):
        with pytest.raises(RuntimeError) as caught:
            main(command("raise RuntimeError('wrapped')"))
        with pytest.raises(OSError, match="outer") as outer:
            raise OSError("outer") from caught.value
        assert plugins.raised_by(outer.value) == f"raised in the plugin plugin_a: {folder}/plugin_a.py, line 5"

    def test_an_error_of_the_library_names_no_plugin(self, capsys, folder, command):
        status, _, err = run(capsys, *command("return [1.0]"), "--fps", "0", "--at-ms", "80")
        assert (status, err) == (2, "npss: error: --fps: expected a positive, finite number, got 0.0\n")

    def test_a_result_that_is_invalid_names_the_metric(self, capsys, command):
        status, _, err = run(capsys, *command("return 'x'"))
        assert status == 2
        assert "broken" in err


class TestInstalled:
    def test_only_commands_import_entry_points(self, capsys, folder, monkeypatch):
        there = folder / "installed"
        declare(there, plugins.GROUP, {"its": "plugin_i"})
        monkeypatch.syspath_prepend(there)
        write(there, plugin_i="print('installed')")
        assert "plugin_i" not in sys.modules
        assert run(capsys, "explain", SIGNATURE)[1].startswith("installed\n")
        assert plugins.with_plugins(["a"]) == ["a"]
        code = "import npss, npss.plugins, sys; print('plugin_i' in sys.modules)"
        path = os.pathsep.join([str(there), os.environ.get("PYTHONPATH", "")])
        environment = os.environ | {"PYTHONPATH": path}
        done = subprocess.run(
            [sys.executable, "-c", code], capture_output=True, encoding="utf-8", env=environment, check=True
        )
        assert done.stdout == "False\n"

    def test_a_broken_one_is_named(self, capsys, folder, monkeypatch):
        there = folder / "installed"
        declare(there, plugins.GROUP, {"its": "plugin_i"})
        monkeypatch.syspath_prepend(there)
        write(there, plugin_i="1 / 0")
        message = (
            f"the installed plugin its (plugin_i): ZeroDivisionError: division by zero ({there}/plugin_i.py, line 1)"
        )
        assert run(capsys, "explain", SIGNATURE) == (2, "", f"npss: error: {message}\n")

    def test_none_is_installed_here(self):
        assert not importlib.metadata.entry_points(group=plugins.GROUP)


class TestRequire:
    def test_imported_plugins(self):
        plugins.require([])
        plugins.require(["npss", "npss.plugins"])

    def test_the_options_to_add(self):
        with pytest.raises(ValueError, match=r"; if you trust the module, add --plugin my_a --plugin my.b$"):
            plugins.require(["my_a", "npss", "my.b"])
        assert "my_a" not in sys.modules

    @pytest.mark.parametrize("names", ["npss", {"npss": 1}, [1], ["a; rm"], ["$(a)"], ["a b"], [""], ["a\n"], None])
    def test_invalid_lists_of_modules(self, names):
        with pytest.raises(ValueError, match=r"^plugins: expected a list of names of modules, got "):
            plugins.require(names)
