"""Sphinx configuration."""

import re
import subprocess
import sys
from pathlib import Path

import npss

sys.path.append(str(Path(__file__).parent))  # its own extensions

project = "npss"
author = "The npss developers"
copyright = "2026, The npss developers"
release = npss.__version__

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_design", "mathml"]
html_math_renderer = "mathml"
myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_heading_anchors = 3
nb_execution_mode = "off"  # the stored output is shown; the tests run the notebooks and compare
exclude_patterns = ["_build", "_drawn"]
html_theme = "furo"
html_static_path = ["style.css"]
html_css_files = ["style.css"]
html_title = f"npss {release}"

autodoc_typehints = "none"  # the docstrings say shapes, which types cannot
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False
napoleon_preprocess_types = False
nitpicky = True
# Type slots hold shapes, "(N, T, D) array_like", which are no classes: only this library's names must resolve.
nitpick_ignore_regex = [("py:class", r"(?!npss\.).*"), ("py:obj", r"(?!npss\.).*")]


def setup(app):
    """Draw the pictures of generated motion that pages show."""
    app.connect("builder-inited", draw)


def draw(app):
    import repaired_walk
    import what_npss_sees

    here = Path(__file__).parent
    drawn = here / "_drawn"
    drawn.mkdir(exist_ok=True)
    what_npss_sees.draw(drawn)
    repaired_walk.draw(drawn)
    page = (here / "pictures.md").read_text(encoding="utf-8")
    (program,) = re.findall(r"^```python\n(.*?)^```", page, flags=re.M | re.S)
    subprocess.run([sys.executable, "-c", program], cwd=drawn, check=True)
