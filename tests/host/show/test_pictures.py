"""Pictures of commands are what their suffix says; a page destroys no other."""

from __future__ import annotations

from pathlib import Path

from command_line import serpenoid
from robots import NIRAKH_2005
from show.test_view_page import LIMPING


def test_a_fits_picture_is_a_pdf_alone(tmp_path: Path) -> None:
    picture = tmp_path / "fit.pdf"
    done = serpenoid(f"fit {NIRAKH_2005} --plot {picture} --no-save", check=True)
    assert f"wrote {picture}" in " ".join(done.stderr.split())
    assert picture.read_bytes().startswith(b"%PDF")
    assert list(tmp_path.iterdir()) == [picture]


def test_a_page_has_the_name_of_its_scene(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert f"wrote {LIMPING.stem}.html" in serpenoid(f"view {LIMPING}").stdout
