"""Studies in chunks: what they hold, a folder of something else, the command's --vary."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import serpenoid as sn
from command_line import serpenoid
from refusals import refused
from robots import PAPER, VISCOUS, gait_in_deg
from serpenoid.periodic.grid import FIELDS

AXES = {"alpha_rad": [0.4, 0.9], "beta_rad": [0.5, 1.3], "omega_rad_s": [1.0, 5.0, 9.0]}


def test_robot_and_gait_together_in_chunks(tmp_path: Path, monkeypatch) -> None:
    """Every row names its robot, its ground and its gait, and is what that gait gives alone."""
    monkeypatch.setattr("serpenoid.periodic.study.stretch_length", lambda grid: 3)
    robots = [sn.Robot(n, 1.0, 0.1) for n in (3, 6)]
    grounds = [VISCOUS, sn.Ground(0.2, 3.0)]
    study = sn.sweep_study(robots, grounds, out=tmp_path / "new" / "study", **AXES)
    assert [len(chunk["robot"]) for chunk in study] == [3, 3, 3, 3, 3, 1]
    for chunk in sn.load_study(study.folder):
        for row in range(len(chunk["robot"])):
            gait = sn.Gait(chunk["alpha_rad"][row], chunk["beta_rad"][row], 5.0)
            robot = study.grid.robots[chunk["robot"][row]]
            alone = sn.steady_gait(robot, study.grid.grounds[chunk["ground"][row]], gait)
            assert chunk["speed_m_s"][row, 1] == pytest.approx(alone.speed_m_s, rel=1e-6)
            assert chunk["settling_time_s"][row, 1] == pytest.approx(
                alone.settling_time_s, rel=1e-4
            )
        assert set(chunk) == {"robot", "ground", *AXES, *FIELDS}


def test_a_folder_of_something_else_is_left_alone(tmp_path: Path) -> None:
    study = sn.sweep_study(PAPER, VISCOUS, out=tmp_path / "study", **AXES)
    with refused("holds another study, of 12 gaits"):
        sn.sweep_study(PAPER, VISCOUS, out=study.folder, **AXES, rtol=1e-5)
    (tmp_path / "mine.txt").write_text("mine")
    with refused("is not empty and holds no study"):
        sn.sweep_study(PAPER, VISCOUS, out=tmp_path, **AXES)
    with refused("holds no study"):
        sn.load_study(tmp_path)


def test_vary_is_a_study_of_designs(tmp_path: Path) -> None:
    """A uniform rod stays one: its inertia goes with mass and length."""
    out = tmp_path / "designs"
    varied = "--vary links=3:4:1 --vary length_m=0.1:0.2:0.1 --vary cn=5:10:5"
    gait = "--alpha-deg 30 --beta-deg 80 --omega-rad-s 5"
    serpenoid(f"sweep --robot paper {varied} {gait} --out", out, check=True)
    study = sn.load_study(out)
    assert study.grid.robots == tuple(sn.Robot(n, 1.0, L) for n in (3, 4) for L in (0.1, 0.2))
    assert [ground.cn for ground in study.grid.grounds] == [5.0, 10.0]
    speeds = np.concatenate([chunk["speed_m_s"] for chunk in study])
    gait = gait_in_deg(30, 80, 5.0)
    last = sn.steady_gait(sn.Robot(4, 1.0, 0.2), VISCOUS, gait)
    assert speeds[-1, 0] == pytest.approx(last.speed_m_s, rel=1e-6)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("--vary cn=1:2:1 --out x.csv", "give --out a folder"),
        ("--vary grip=1:2:1 --out x", "with a NAME of links, mass_kg"),
        ("--vary links=3:4:0.5 --out x", "links must be whole numbers"),
        ("--out x --json", "a study is a folder"),
        ("--out x.xlsx", "must end in .csv or .npz or .json"),
    ],
)
def test_what_makes_no_study_is_told(
    options: str, message: str, tmp_path: Path, monkeypatch
) -> None:
    monkeypatch.chdir(tmp_path)
    done = serpenoid(f"sweep {options}")
    assert done.returncode == 2
    assert message in done.stderr


@pytest.mark.parametrize("kept", [0, 40, 2000])
def test_a_chunk_that_was_damaged_is_named(tmp_path: Path, kept: int) -> None:
    study = sn.sweep_study(PAPER, VISCOUS, out=tmp_path / "study", **AXES)
    file = study.path(study.chunks[0])
    file.write_bytes(file.read_bytes()[:kept])
    with refused(r"chunk-0+\.npz is damaged .* delete it"):
        list(study)
    file.unlink()
    assert len(list(sn.sweep_study(PAPER, VISCOUS, out=study.folder, **AXES))) == 1


def some_study(folder: Path, **changed: object) -> sn.Study:
    return sn.sweep_study(PAPER, VISCOUS, out=folder, **(AXES | changed))


def test_a_chunk_of_elsewhere_is_not_summed_up(tmp_path: Path, monkeypatch) -> None:
    """Another chunk's file, and one of another study."""
    monkeypatch.setattr("serpenoid.periodic.study.stretch_length", lambda grid: 2)
    study, other = some_study(tmp_path / "a"), some_study(tmp_path / "b", beta_rad=[0.6, 1.4])
    first, second = (study.path(chunk) for chunk in study.chunks)
    for wrong in (second, other.path(other.chunks[0])):
        first.write_bytes(wrong.read_bytes())
        with refused(r"of another study, or another chunk.* delete it"):
            list(sn.load_study(study.folder))


@pytest.mark.parametrize("shapes", ["-1", "0", "1.5", "true", "5", "1e30", "1" + 30 * "0", '"2"'])
def test_a_head_with_impossible_chunks(tmp_path: Path, shapes: str) -> None:
    study = some_study(tmp_path / "study")
    head = study.folder / "study.json"
    head.write_text(head.read_text().replace('"shapes": 4', f'"shapes": {shapes}'))
    with refused(r"study\.json is no head of a study .*shapes is"):
        sn.load_study(study.folder)
