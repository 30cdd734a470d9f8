"""Data beside a figure, tables that lose nothing, names that destroy nothing, and what to cite."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
import serpenoid as sn
from command_line import serpenoid
from serpenoid.show import citation
from show.test_view_page import LIMPING

ROOT = Path(__file__).parents[3]
FOLDER_2005 = ROOT / "calibration_data" / "nirakh-2005"


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open() as file:
        return list(csv.DictReader(file))


def test_a_fits_picture_has_its_points_and_lines_beside(tmp_path: Path) -> None:
    picture = tmp_path / "fit.pdf"
    done = serpenoid(f"fit {FOLDER_2005} --plot {picture} --no-save", check=True)
    assert f"wrote {picture} and {tmp_path / 'fit.csv'}" in " ".join(done.stderr.split())
    assert picture.read_bytes().startswith(b"%PDF")
    rows = rows_of(tmp_path / "fit.csv")
    readings = [row for row in rows if row["kind"] == "reading"]
    assert [row["part"] for row in readings] == 5 * ["straight"] + 6 * ["bent"]
    fit = sn.fit_friction(sn.load_session(FOLDER_2005))
    for row in rows:  # the readings of 2005 are made from the lines themselves
        axis = "t" if row["part"] == "straight" else "n"
        law = fit.parameters[f"c{axis}"].value * float(row["speed_m_s"])
        law += fit.parameters[f"f{axis}0"].value
        assert float(row["force_n"]) == pytest.approx(law, rel=1e-3)


def test_a_comparisons_picture_has_its_numbers_beside(tmp_path: Path) -> None:
    picture = tmp_path / "speeds.svg"
    serpenoid(f"compare {FOLDER_2005} --gait 40 75 2 --samples 20 --plot {picture}", check=True)
    rows = rows_of(tmp_path / "speeds.csv")
    assert {row["kind"] for row in rows} == {"curve", "gait"}
    assert all(float(r["low_m_s"]) <= float(r["exact_m_s"]) * (1 + 1e-9) for r in rows)


def test_a_page_that_is_there_stays_unless_it_is_named(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("view.html").write_text("mine")
    for name in ("view-2.html", "view-3.html"):
        assert f"wrote {name}" in serpenoid(f"view {LIMPING}").stdout
    assert Path("view.html").read_text() == "mine"


def test_what_to_cite_is_that_of_the_citation_file(tmp_path: Path) -> None:
    words = (ROOT / "CITATION.cff").read_text()
    entries = citation.entries()
    assert f"name: {citation.AUTHORS.strip('{}')}\n" in words
    assert f'title: "{citation.TITLE}"' in words
    title = "An Implicit Model for Snake Robot Locomotion and Gait Optimization"
    for text in (title, "IMECE2005-82742", "Nirakh", "Brennan", "Gandhi", "2005"):
        assert text in words
        assert text in entries
    assert entries.count("{") == entries.count("}")
    file = tmp_path / "cite.bib"
    serpenoid(f"report {FOLDER_2005} --out {tmp_path / 'r.html'} --bibtex {file}", check=True)
    assert file.read_text() == entries
