"""Sessions on disk: the 2005 one as committed, and every way to get a file wrong."""

import importlib.util
import re
import shutil

import pytest
import serpenoid as sn
from command_line import serpenoid
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from robots import NIRAKH_2005, OF_2005
from serpenoid import BadInput, load_session


@pytest.fixture
def folder(tmp_path):
    for name in ("session.toml", "readings.csv", "events.csv"):
        shutil.copy(NIRAKH_2005 / name, tmp_path)
    return tmp_path


def rewrite(path, old, new):
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


def complaint(folder):
    with pytest.raises(BadInput) as caught:
        load_session(folder)
    return str(caught.value)


def test_regenerating_gives_the_committed_file():
    assert load_session(NIRAKH_2005).setup.robot == OF_2005
    spec = importlib.util.spec_from_file_location("regenerate", NIRAKH_2005 / "regenerate.py")
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    assert script.text() == (NIRAKH_2005 / "readings.csv").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        (
            ",2.0,0.181468,",
            ",nan,0.181468,",
            r":2: incline_deg is nan; .* more than 0 and at most 45",
        ),
        (",2.0,0.181468,", ",2,0,0.181468,", r":2: 21 cells where the header has 20"),
        (",0.181468,0.0,", ",0.181468,0.2,", r":2: belt_speed_m_s - drift_m_s is -0.018532 .*void"),
        ("\n6,station,", "\n5,station,", r":7: reading 5 is there already"),
        (",drift_m_s", "", r":1: missing column drift_m_s"),
        (
            "incline_deg",
            "incline_rad",
            r":1: unknown column 'incline_rad'; did you mean 'incline_deg'",
        ),
        (",regenerated", ',"regenerated', r":\d+: not CSV"),
    ],
)
def test_bad_readings_name_file_line_and_range(folder, old, new, says):
    rewrite(folder / "readings.csv", old, new)
    assert re.search(re.escape(str(folder / "readings.csv")) + says, complaint(folder))


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("format = 2", "format = 1", r":2: format is 1, which held stations alone"),
        ("format = 2", "format = 3", r":2: format is 3; .*up to 2; install a newer"),
        ("format = 2", "", r"toml: the file has no format"),
        ("links = 6", "links = 1", r":\d+: links is 1; .*2"),
        (
            "mass_kg = 0.4536",
            "mass_kg = 0.0",
            r":\d+: mass_kg is 0.0; .*at least 0.001",
        ),
        (
            "mass_kg = 0.4536",
            "link_mass_g = 75.6",
            r":\d+: unknown key 'link_mass_g'",
        ),
        ("mass_kg = 0.4536", "", r"toml: missing key mass_kg"),
        (
            "mass_kg = 0.4536",
            "mass_kg = 453.6",
            r':19: mass_kg is 453.6; .*solid metal. In grams.* 0.4536. .*"453.6 kg"',
        ),
        (
            "mass_kg = 0.4536",
            "mass_kg = 0.4536\nwheels_kg = 36",
            r"wheels_kg is 36; .*less than the whole robot, 0.4536 kg; were they given in grams",
        ),
        ("lambda_deg = [0.0, 7.5]", "lambda_deg = []", r":\d+: lambda_deg is \[\]"),
        ("[robot]", "[snake]", r":\d+: unknown key 'snake'"),
        ('name = "nirakh-2005"', 'name = ""', r":3: name is ''; it must be text"),
    ],
)
def test_bad_setups_name_file_line_and_range(folder, old, new, says):
    rewrite(folder / "session.toml", old, new)
    found = complaint(folder)
    assert found.startswith(str(folder / "session.toml"))
    assert re.search(says, found)


def test_an_older_file_has_the_mass_of_a_link_or_says_that_it_was_assumed(folder):
    path = folder / "session.toml"
    text = path.read_text()
    path.write_text(text.replace("mass_kg = 0.4536", "link_mass_kg = 0.1"))
    assert load_session(folder).setup.robot.mass_kg == pytest.approx(0.6)
    path.write_text(text.replace("mass_kg = 0.4536", "link_mass_kg = 0.1\nweighed = false"))
    assert load_session(folder).setup.mass_sigma == 0.05


def test_a_number_may_have_its_unit_and_a_doubtful_mass_must(folder):
    rewrite(folder / "session.toml", "mass_kg = 0.4536", 'mass_kg = "480 g"')
    assert load_session(folder).setup.robot.mass_kg == pytest.approx(0.48)
    rewrite(folder / "session.toml", '"480 g"', '"760 kg"')
    assert load_session(folder).setup.robot.mass_kg == pytest.approx(760.0)
    copy = folder / "copy"
    serpenoid("calibrate new", copy, "--template", folder, check=True)
    assert 'mass_kg = "760 kg"' in (copy / "session.toml").read_text()
    new = serpenoid("calibrate new", folder / "new", "--defaults", "--mass-kg", "760")
    assert new.returncode == 2
    assert "in kg it is 0.76" in new.stderr.lower()


def test_a_fit_remarks_on_a_length_in_another_unit(folder):
    rewrite(folder / "session.toml", "link_length_m = 0.076", "link_length_m = 3")
    assert "session.toml a link is 3 m long" in sn.fit_friction(load_session(folder)).notes[0]


def test_missing_and_empty_files_are_refused(folder, tmp_path):
    path = folder / "readings.csv"
    path.write_text(path.read_text().split("\n")[0] + "\n")
    assert "no reading to use among 0" in complaint(folder)
    shutil.copy(NIRAKH_2005 / "readings.csv", path)
    with (folder / "events.csv").open("a") as events:
        events.writelines(f",void,{number},slipped\n" for number in range(1, 12))
    assert "no reading to use among 11" in complaint(folder)
    path.write_text("")
    assert "missing or empty, but it belongs to the session; take it" in complaint(folder)
    path.write_bytes(b"\xff\xfe\x00")
    assert "not UTF-8" in complaint(folder)
    path.unlink()
    assert "missing or empty, but it belongs to the session; take it" in complaint(folder)
    assert "no session here" in complaint(tmp_path / "nowhere")


def test_a_voided_reading_may_have_stuck_wheels(folder):
    rewrite(folder / "readings.csv", "0.181468,0.0", "0.0,0.0")
    with (folder / "events.csv").open("a") as events:
        events.write(",void,1,stuck\n")
    assert load_session(folder).readings[0].slip_speed_m_s == 0.0


def test_spreadsheet_habits_are_read(folder):
    path = folder / "readings.csv"
    text = path.read_text(encoding="utf-8").replace(",2.0,", ', "2.0" ,'.replace('"', ""))
    path.write_bytes(b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode())
    assert load_session(folder).readings == load_session(NIRAKH_2005).readings


@settings(
    max_examples=300,
    derandomize=True,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(
    name=st.sampled_from(["session.toml", "readings.csv"]),
    start=st.integers(0, 2000),
    length=st.integers(0, 20),
    new=st.text(max_size=8) | st.sampled_from(["nan", "-1", "1e999", '"', "\n", "\0", ","]),
)
def test_whatever_is_typed_loads_or_is_refused_clearly(folder, name, start, length, new):
    good = (NIRAKH_2005 / name).read_text(encoding="utf-8")
    bad = good[:start] + new + good[start + length :]
    (folder / name).write_bytes(bad.encode("utf-8", "surrogatepass"))
    refused = ""
    try:
        assert load_session(folder).kept_stations
    except BadInput as error:
        refused = str(error)
    (folder / name).write_text(good, encoding="utf-8")
    assert not refused or refused.startswith(str(folder / name))


def test_a_session_keeps_the_voltage_and_the_frames_of_its_servos(folder):
    text, gait = (folder / "session.toml").read_text(), sn.Gait.degrees(70, 75, hertz=0.2)

    def driven(settings: str, kind: sn.ServoKind, links: int = 6) -> sn.ServoKind:
        new = text.replace("links = 6", f"links = {links}\n{settings}")
        (folder / "session.toml").write_text(new)
        found = sn.compare(load_session(folder), gaits=[gait], servo=kind, samples=4)
        assert found.servo is not None
        return found.servo

    measured = driven("supply_v = 5.2\nframe_ms = 5.0", sn.servo("S3003"))
    assert {servo.supply_v for servo in measured.draws(8)} == {5.2}
    assert {servo.frame_s for servo in measured.draws(8)} == {0.005}
    stated = sn.servo().at_volts(4.9).at_frames(0.01)
    assert driven("supply_v = 5.6\nframe_ms = 5.0", stated) == stated
    longer = driven("", sn.servo(), links=11)
    assert longer.servo.frame_s == 0.0275  # what the firmware has for ten
    assert longer.sigma["supply_v"] > 0
