"""Formulas as SVG within the page, set by matplotlib: no LaTeX, no script from elsewhere."""

from __future__ import annotations

import io
import re
from html import escape

from docutils import nodes
from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.mathtext import MathTextParser

POINTS, DPI = 11, 72


def svg(latex: str, points: float = POINTS) -> tuple[str, float]:
    """Return a formula as an SVG element, and how far it reaches below the line, in points."""
    text = f"${' '.join(latex.split())}$"
    width, height, depth, *_ = MathTextParser("path").parse(text, dpi=DPI)
    scale = points / 10
    figure = Figure(figsize=((width * scale + 2) / DPI, (height * scale + 2) / DPI))
    figure.text(0, (depth * scale + 1) / DPI / figure.get_figheight(), text, fontsize=points)
    with io.StringIO() as file, rc_context({"svg.hashsalt": latex, "mathtext.fontset": "stix"}):
        figure.savefig(file, format="svg", transparent=True, metadata={"Date": None})
        drawn = file.getvalue()
    drawn = drawn[drawn.index("<svg") :]
    drawn = re.sub(r"<metadata>.*?</metadata>|<!--.*?-->", "", drawn, flags=re.S)
    drawn = drawn.replace("<svg ", f'<svg role="img" aria-label="{escape(latex, True)}" ', 1)
    return drawn, depth * scale


def inline(self, node: nodes.math) -> None:
    """Put a formula into a line of text."""
    drawn, depth = svg(node.astext())
    self.body.append(
        f'<span class="formula" style="vertical-align:{-depth - 1:.1f}pt">{drawn}</span>'
    )
    raise nodes.SkipNode


def block(self, node: nodes.math_block) -> None:
    """Put formulas on lines of their own; an empty line or `\\\\` parts them."""
    for line in re.split(r"\\\\|\n\s*\n", node.astext()):
        if line.strip():
            self.body.append(f'<div class="formula">{svg(line, 1.15 * POINTS)[0]}</div>')
    raise nodes.SkipNode


def setup(app) -> dict[str, bool]:
    """Register the renderer with Sphinx."""
    app.add_html_math_renderer("mathtext", (inline, None), (block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
