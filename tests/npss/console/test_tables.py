"""Text in Markdown and LaTeX is shown unchanged."""

import re
from html import unescape

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from npss.console._tables import markdown_code, markdown_text, table
from npss.ranking._render import _latex

#: Names of models are one line, without blanks at the ends or several in a row.
LINE = st.text(st.sampled_from(r"ab1 \`*_{}[]()<>#+-.!|~$^&:;='\"" + "é步"), min_size=1).map(
    lambda text: " ".join(text.split())
)


def shown(html):
    """The text of a piece of HTML, of which no element is left."""
    assert "<" not in html, html
    return unescape(html)


@pytest.fixture(scope="module")
def markdown():
    parser = pytest.importorskip("markdown_it").MarkdownIt("gfm-like", {"linkify": False, "typographer": False})
    return parser.render


@given(LINE)
@example("~x~")
@example("~~x~~")
@example("- a")
@example("1. a")
@example("12)")
@example("---")
@example("+")
@example("# a #")
@example("&amp;")
@example("<b>")
@example("[a](b)")
@example("![a](b)")
@example(r"\*a\*")
@example("a|b")
def test_markdown_shows_text_unchanged(markdown, text):
    if not text:
        return
    assert shown(re.fullmatch(r"<ul>\n<li>(.*)</li>\n</ul>\n", markdown(f"- {markdown_text(text)}"), re.S)[1]) == text
    assert shown(re.fullmatch(r"<h3>(.*)</h3>\n", markdown(f"### {markdown_text(text)}"), re.S)[1]) == text
    lines = table(["rank", "model"], [["1", markdown_text(text)]], "rl", markdown=True)
    cells = re.findall(r"<td[^>]*>(.*?)</td>", markdown(lines), re.S)
    assert [shown(cell) for cell in cells] == ["1", text]


@given(LINE)
@example("a`b``c")
@example("`")
def test_code_in_markdown_is_unchanged(markdown, text):
    if text:
        assert shown(re.fullmatch(r"<p><code>(.*)</code></p>\n", markdown(markdown_code(text)), re.S)[1]) == text


@pytest.mark.parametrize("sign", ["$", "^", "~"])  # formulas, and what is raised or lowered, in other dialects
def test_signs_of_other_dialects_are_escaped(sign):
    assert markdown_text(f"{sign}x{sign}") == f"\\{sign}x\\{sign}"


@pytest.mark.parametrize(
    ("text", "escaped"),
    [
        ("a--b---c", "a-{}-b-{}-{}-c"),  # else dashes of other lengths
        ("`x`", r"\textasciigrave{}x\textasciigrave{}"),
        ("$~^", r"\$\textasciitilde{}\textasciicircum{}"),
        ("1–2", "1--2"),
    ],
)
def test_latex(text, escaped):
    assert _latex(text) == escaped
