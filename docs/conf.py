"""Settings of Sphinx; `.ci/docs` first draws the figures and writes the reference pages."""

from __future__ import annotations

import re
import sys
from importlib.metadata import version as version_of
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "ext"))

project = "serpenoid"
author = "The serpenoid authors"
project_copyright = "the serpenoid authors; MIT licence"
version = version_of("serpenoid")
release = version
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "mathml"]
html_math_renderer = "mathml"
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3
exclude_patterns = ["_build", "ext", "paper", "generated/front.md"]
html_theme = "furo"
html_title = f"serpenoid {release}"
html_static_path = ["_static", "generated/static"]
html_extra_path = ["generated/pages"]
html_css_files = ["serpenoid.css"]
html_theme_options = {"top_of_page_buttons": []}
html_copy_source = False
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_rtype = False
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
autodoc_type_aliases = {"ArrayLike": "ArrayLike", "Array": "Array"}
python_maximum_signature_line_length = 76
smartquotes = False
# Pages of the repository that are included unchanged link to files beside them.
suppress_warnings = ["myst.xref_missing", "myst.header"]


def escape_markup(_app, _what, _name, _obj, _options, lines: list[str]) -> None:
    """Escape markup in docstrings, which are plain text: |P| and ct_ mean themselves."""
    text = re.sub(r"([|*\\])|_(?=\W|$)", lambda m: "\\" + m[0], "\n".join(lines))
    lines[:] = re.sub(r"`([^`\n]+)`", r"``\1``", text).split("\n")


NAMED_PARTS = {  # parts of a page to which a screen reader needs a name, level or focus
    '<aside class="sidebar-drawer">': '<aside class="sidebar-drawer" aria-label="Contents">',
    '<aside class="toc-drawer': '<aside aria-label="On this page" class="toc-drawer',
    '<p class="caption" role="heading">': '<p class="caption" role="heading" aria-level="2">',
    '<div class="formula"': '<div tabindex="0" class="formula"',
    '<div class="table-wrapper': '<div tabindex="0" class="table-wrapper',
    "<p><img ": '<p tabindex="0"><img ',
}


def whole_percentages(text: str) -> str:
    """Return a page with unbreakable spaces between numbers and %, except in code."""
    typed_or_percent = r"<(code|pre)\b.*?</\1>|(?<=\d) %"
    return re.sub(typed_or_percent, lambda m: m[0] if m[1] else "\u00a0%", text, flags=re.S)


def improve_pages(app, error) -> None:
    """Change every page that Sphinx has written."""
    for path in Path(app.outdir).glob("*.html") if error is None else ():
        text = path.read_text(encoding="utf-8")
        for old, new in NAMED_PARTS.items():
            text = text.replace(old, new)
        path.write_text(whole_percentages(text), encoding="utf-8")


def setup(app) -> None:
    """Register the functions above with Sphinx."""
    app.connect("autodoc-process-docstring", escape_markup, priority=100)  # before napoleon
    app.connect("build-finished", improve_pages)
