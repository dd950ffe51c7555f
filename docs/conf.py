"""Sphinx configuration."""

import npss

project = "npss"
author = "The npss developers"
copyright = "2026, The npss developers"
release = npss.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.mathjax"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
exclude_patterns = ["_build"]
html_theme = "furo"
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
