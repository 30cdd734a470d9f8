"""fit.json: the same fit back, whole or not at all, and told when it is older than its readings."""

import json
import shutil

import numpy as np
import pytest
import serpenoid as sn
from refusals import refused
from robots import NIRAKH_2005
from serpenoid.friction import file as fit_file


@pytest.fixture
def folder(tmp_path):
    copy = tmp_path / "session"
    copy.mkdir()
    for name in ("session.toml", "readings.csv", "events.csv"):
        shutil.copy(NIRAKH_2005 / name, copy)
    return copy


def test_a_fit_comes_back_as_it_was(folder):
    fit = sn.fit_friction(sn.load_session(folder))
    path = sn.save_fit(fit, folder)
    assert path == folder / "fit.json"
    back = sn.load_fit(folder)
    assert back.to_dict() == fit.to_dict()
    assert back.ground == fit.ground
    np.testing.assert_array_equal(back.sample_whole(16), fit.sample_whole(16))
    first = path.read_bytes()
    sn.save_fit(back, path)
    assert path.read_bytes() == first
    assert json.loads(first)["session"]["sha256"] == sn.load_session(folder).sha256
    assert len(first) < 40_000


def test_a_fit_that_is_older_than_its_readings_says_so(folder):
    path = sn.save_fit(sn.fit_friction(sn.load_session(folder)), folder)
    text = (folder / "readings.csv").read_text().replace(",0.0,2.0,", ",0.0,2.1,", 1)
    (folder / "readings.csv").write_text(text)
    assert any("older than the readings" in note for note in sn.load_fit(path).notes)
    assert not any("older" in note for note in sn.fit_friction(sn.load_session(folder)).notes)


def forged(folder, spoil):
    """Return a fit file that was changed, under a hash that is right."""
    path = sn.save_fit(sn.fit_friction(sn.load_session(folder)), folder)
    given = json.loads(path.read_text())
    spoil(given)
    del given["sha256"]
    path.write_text(json.dumps(given | {"sha256": fit_file.hash_of(given)}))
    return path


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda d: d.pop("covariance"), "'covariance' is missing"),
        (lambda d: d.update(format=99), "format is 99.*install a newer one"),
        (lambda d: d.update(format=1), "format is 1.*writes it anew"),
        (lambda d: d["robot"].update(legs=4), "legs"),
        (
            lambda d: d.update(method="robust"),
            "method is robust; this version fits by joint or naive",
        ),
        (lambda d: d["covariance"].update(values=[[1.0]]), "cannot reshape"),
    ],
)
def test_what_is_no_fit_is_refused(folder, spoil, message):
    with refused(message) as error:
        sn.load_fit(forged(folder, spoil))
    assert len(str(error.value)) < 300 + len(str(folder))


def test_a_file_of_format_2_is_read(folder):
    """It had draws of what readings share, too."""
    fit = sn.fit_friction(sn.load_session(folder))

    def older(given):
        given["format"] = 2
        given["draws"]["order"].append("incline_zero_rad")
        given["draws"]["values"] = [[*row, 0.001] for row in given["draws"]["values"]]
        for each in given["influence"]:
            each |= {"leverage": 0.1, "studentised": 1.0}

    back = sn.load_fit(forged(folder, older))
    assert (back.whole_snake, dict(back.intervals)) == (fit.whole_snake, dict(fit.intervals))
    np.testing.assert_array_equal(back.sample_whole(64), fit.sample_whole(64))


def test_a_fit_that_was_edited_is_refused(folder):
    """Ten times the friction under the old hash of the readings is no fit of them."""
    path = sn.save_fit(sn.fit_friction(sn.load_session(folder)), folder)
    given = json.loads(path.read_text())
    for part in given["parameters"].values():
        part.update({k: 10 * part[k] for k in ("value", "sigma")})
        part["interval"] = [10 * x for x in part["interval"]]
    path.write_text(json.dumps(given))
    with refused(r"sha256 is not that of its numbers.* writes it anew"):
        sn.load_fit(folder)
    path.write_text(path.read_text().replace('"value": 0', '"value": NaN', 1))
    with refused("NaN is no number"):
        sn.load_fit(folder)


@pytest.mark.parametrize("text", ["{", "[1, 2]"])
def test_half_a_file_is_refused(folder, text):
    (folder / fit_file.NAME).write_text(text)
    with refused("serpenoid fit DIR"):
        sn.load_fit(folder)


def test_no_file_says_what_writes_it(tmp_path):
    with refused("no such file"):
        sn.load_fit(tmp_path / "fit.json")
