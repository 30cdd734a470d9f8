"""The pages that a newcomer reads first: short, and no sentence over 30 words."""

from __future__ import annotations

import re

import pytest
from docs.documents import ROOT

MOST_WORDS, LONGEST_SENTENCE = 900, 30
PAGES = [
    "README.md",
    "CONTRIBUTING.md",
    "docs/paper/paper.md",
    *sorted(f"docs/{p.name}" for p in (ROOT / "docs").glob("*.md")),
]


def prose(text: str) -> str:
    """Return a page without code, tables, formulas and addresses."""
    text = re.sub(r"\A---\n.*?\n---\n", "", text, flags=re.S)
    text = re.sub(r"^```.*?^```", "", text, flags=re.M | re.S)
    text = re.sub(r"\$\$.*?\$\$", "", text, flags=re.S)
    text = re.sub(r"^( {4,}|\|).*$", "", text, flags=re.M)
    return re.sub(r"\]\([^)]*\)", "]", text)


def too_long(text: str) -> list[str]:
    """Return the sentences with too many words; an item of a list ends a sentence."""
    paragraphs = re.split(r"\n\s*\n|\n(?=- |\d+\. |#|: |<)", prose(text))
    sentences = [s for p in paragraphs for s in re.split(r"(?<=[.!?])[*)]*\s+", p)]
    return [" ".join(s.split()) for s in sentences if words(s) > LONGEST_SENTENCE]


def words(text: str) -> int:
    return sum(1 for word in text.split() if re.search(r"\w", word))


@pytest.mark.parametrize("page", PAGES)
def test_no_sentence_is_too_long(page) -> None:
    assert too_long((ROOT / page).read_text()) == []


def test_the_readme_is_short() -> None:
    assert words(prose((ROOT / "README.md").read_text())) <= MOST_WORDS


def test_the_paper_cites_what_its_list_has_and_the_list_has_no_more() -> None:
    folder = ROOT / "docs" / "paper"
    _, head, text = (folder / "paper.md").read_text().split("---\n", 2)
    assert "bibliography: paper.bib" in head
    listed = re.findall(r"^@\w+\{(\w+),", (folder / "paper.bib").read_text(), re.M)
    assert sorted(set(re.findall(r"@([a-z]+\d*)", text))) == sorted(listed)
    assert len(set(listed)) == len(listed)
