"""Pages of the browser that move: the crawling snake, from a file or live; their server."""

from __future__ import annotations

from pathlib import Path


def filled(html: str, **files: str) -> str:
    """Return a page with files of this folder in place of their marks: NAME stands for @NAME@."""
    for mark, name in files.items():
        text = Path(__file__).with_name(name).read_text(encoding="utf-8")
        html = html.replace(f"@{mark}@", text)
    return html
