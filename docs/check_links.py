"""Look every link of the built pages up among what was built; no network."""

from __future__ import annotations

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    """The anchors of a page, and what it links to."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: set[str] = set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note ids, names and addresses."""
        for name, value in attrs:
            if name == "id" or (tag == "a" and name == "name"):
                self.anchors.add(value or "")
            elif name in ("href", "src") and tag != "link":
                self.links.add(value or "")


def broken(root: Path) -> list[str]:
    """Return every link that leads nowhere, and every script or picture from elsewhere."""
    pages = {path.resolve(): Page(path) for path in root.rglob("*.html")}
    wrong = []
    for path, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc or not link:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            target = target / "index.html" if target.is_dir() else target
            if not target.exists():
                wrong.append(f"{path.relative_to(root.resolve())}: {link} is not there")
            elif parts.fragment and target in pages and parts.fragment not in pages[target].anchors:
                wrong.append(f"{path.relative_to(root.resolve())}: {link} has no such anchor")
    return sorted(wrong)


if __name__ == "__main__":
    broken_links = broken(Path(sys.argv[1]))
    print("\n".join(broken_links) or "every link leads somewhere")
    sys.exit(bool(broken_links))
