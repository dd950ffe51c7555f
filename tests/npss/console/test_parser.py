"""The parser of commands: errors name arguments as users type them, and say which option took too many words."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from command_line import run
from npss.console import Parser


def parser(*words):
    made = Parser(prog="score")
    made.add_argument("files", nargs="*", metavar="FILE")
    made.add_argument("--at-ms", type=float)
    made.add_argument("--actions", "--action", nargs="+")
    made.add_argument("-o", "--output", dest="path")
    made.add_argument("--model.size", type=int)
    made.add_argument("--layers.epochs", type=int)
    made.add_argument("--whole.epochs", type=int)
    return made.parse_args([*words]).parser


@pytest.mark.parametrize(
    ("words", "message", "typed"),
    [
        ("", "at_ms: 85 ms", "--at-ms: 85 ms"),
        ("", "at_ms[3]: 85 ms", "--at-ms: 85 ms"),
        ("", "files: none", "FILE: none"),
        ("", "path: no folder", "--output: no folder"),
        ("-o x", "path: no folder", "-o: no folder"),
        ("--actions a", "actions: none", "--actions: none"),
        ("--action a", "actions: none", "--action: none"),
        ("--action=a", "actions: none", "--action: none"),
        ("", "size: 0", "--model.size: 0"),
        ("", "model.size:\nlines", "--model.size: lines"),
        ("", "epochs: 0", "epochs: 0"),
        ("--whole.epochs 1", "epochs: 0", "--whole.epochs: 0"),
        ("--layers.epochs 2 --whole.epochs 1", "epochs: 0", "epochs: 0"),
        ("--at-ms 3", "gt: nan at index (0, 0, 0)", "gt: nan at index (0, 0, 0)"),
        ("--at-ms 3", "walking: at_ms: 85 ms", "walking: at_ms: 85 ms"),
        ("--at-ms 3", "at_ms", "at_ms"),
        ("", "ms: 3", "ms: 3"),
        ("", "--at-ms: 3", "--at-ms: 3"),
    ],
)
def test_errors_name_arguments_as_typed(words, message, typed):
    assert parser(*words.split()).as_typed(message) == typed


@given(st.text())
def test_other_errors_are_unchanged(message):
    made = Parser(prog="none", add_help=False)
    made.parse_args([])
    assert made.as_typed(message) == message


HINT = "; --actions takes every word up to the next option, so give FILE before it"


@pytest.mark.parametrize(
    ("words", "message", "hint"),
    [
        ("--actions walk a.npy", "actions: unknown 'a.npy'", HINT),
        ("--actions walk a.npy b.npy --at-ms 3", "actions: unknown 'a.npy'", HINT),
        ("x --actions walk a.npy", "actions: unknown 'a.npy'", HINT),
        ("--actions a.npy", "actions: unknown 'a.npy'", ""),
        ("--actions walk a.npy", "actions: unknown 'walk'", ""),
        ("--actions walk --at-ms 3 a.npy", "actions: unknown 'a.npy'", ""),
        ("--actions walk a.npy", "actions: none", ""),
    ],
)
def test_a_word_of_another_argument(words, message, hint):
    assert parser(*words.split()).as_typed(message) == f"--{message}{hint}"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["score", "--metrics", "mse", "a.npz"],
            "the following arguments are required: FILE; --metrics takes every word",
        ),
        (
            ["score", "--at-ms", "80", "a.npz"],
            "argument --at-ms: invalid float value: 'a.npz'; --at-ms takes every word",
        ),
        (["score", "a.npz", "--metrics", "mse", "--fps", "x"], "argument --fps: invalid float value: 'x' (see"),
        (["score", "--fps", "3"], "the following arguments are required: FILE (see"),
        (["study", "plan", ".8", ".6", "--power", "2"], "npss: error: --power: expected a number between 0 and 1"),
        (["study", "plan", "8", ".6"], "npss: error: P_A: expected a number between 0 and 1"),
    ],
)
def test_commands(capsys, arguments, message):
    status, out, err = run(capsys, *arguments)
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert message in err


def test_options_that_a_command_reads_itself():
    other = Parser(prog="other", add_help=False)
    other.add_argument("--recipe.lr")
    made = parser()
    assert made.as_typed("lr: expected") == "lr: expected"
    made.also_reads(other)
    assert made.as_typed("lr: expected") == "--recipe.lr: expected"
