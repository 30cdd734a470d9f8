"""fit.json: the same fit back, whole or not at all, and told when it is older than its readings."""

import hashlib
import json

import numpy as np
import pytest
import serpenoid as sn
from refusals import refused
from robots import copy_of_2005


@pytest.fixture
def folder(tmp_path):
    return copy_of_2005(tmp_path / "session")


def test_a_fit_comes_back_as_it_was_until_its_readings_change(folder):
    fit = sn.fit_friction(sn.load_session(folder))
    path = sn.save_fit(fit, folder)
    assert path == folder / "fit.json"
    back = sn.load_fit(folder)
    assert back.to_dict() == fit.to_dict()
    np.testing.assert_array_equal(back.sample_whole(16), fit.sample_whole(16))
    first = path.read_bytes()
    sn.save_fit(back, path)
    assert path.read_bytes() == first
    assert len(first) < 40_000
    text = (folder / "readings.csv").read_text().replace(",0.0,2.0,", ",0.0,2.1,", 1)
    (folder / "readings.csv").write_text(text)
    assert any("older than the readings" in note for note in sn.load_fit(path).notes)


def forged(folder, spoil):
    """Return a fit file that was changed, under a hash that is right."""
    path = sn.save_fit(sn.fit_friction(sn.load_session(folder)), folder)
    given = json.loads(path.read_text())
    spoil(given)
    del given["sha256"]
    plain = json.dumps(given, sort_keys=True).encode()
    path.write_text(json.dumps(given | {"sha256": hashlib.sha256(plain).hexdigest()}))
    return path


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda d: d.pop("covariance"), "'covariance' is missing"),
        (lambda d: d.update(format=99), "format is 99.*reads formats 2 to 3"),
        (lambda d: d.update(format=1), "format is 1.*writes it anew"),
        (lambda d: d["robot"].update(legs=4), "legs"),
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
        given["draws"]["values"] = [[*row, 0.001] for row in given["draws"]["values"]]
        for each in given["influence"]:
            each |= {"leverage": 0.1, "studentised": 1.0}

    back = sn.load_fit(forged(folder, older))
    assert (back.whole_snake, dict(back.intervals)) == (fit.whole_snake, dict(fit.intervals))
    np.testing.assert_array_equal(back.sample_whole(64), fit.sample_whole(64))


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (
            lambda text: text.replace('"value": 0', '"value": 1', 1),
            "sha256 is not .* writes it anew",
        ),
        (lambda text: text.replace('"value": 0', '"value": NaN', 1), "NaN is no number"),
        (lambda text: text[:100], "serpenoid fit DIR"),
        (lambda _: "[1, 2]", "serpenoid fit DIR"),
    ],
)
def test_a_file_that_was_edited_or_cut_is_refused(folder, edit, message):
    path = sn.save_fit(sn.fit_friction(sn.load_session(folder)), folder)
    path.write_text(edit(path.read_text()))
    with refused(message):
        sn.load_fit(folder)
    path.unlink()
    with refused("no such file"):
        sn.load_fit(folder)
