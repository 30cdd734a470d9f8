"""Tables of other programs by the names of their columns: numbers, and what is wrong in words."""

import pytest
from refusals import refused
from serpenoid.base.tables import number_columns


@pytest.mark.parametrize(
    "text",
    [
        "t_s,angle_deg\n0.5,-3.25\n\n1,4\n",
        "sep=;\nANGLE_DEG;extra;t_s\n-3,25;9;0,5\n4;;1\n",
        "a title\nt_s\tangle_deg\n0,5\t−3,25\n1,0\t4,0\n",
        "t_s angle_deg\n5e-1 -3.25\n1 4\n",
    ],
)
def test_columns_of_numbers(tmp_path, text):
    path = tmp_path / "log.csv"
    path.write_text(text)
    assert number_columns(path, "t_s", "angle_deg") == [[0.5, 1.0], [-3.25, 4.0]]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("t,angle\n0,1\n", "first line is 't,angle'; make the names of the columns t_s,angle_deg"),
        ("t_s,angle_deg\n0,\n", ":2: angle_deg is no finite number"),
        ("t_s,angle_deg\n0\n", ":2: angle_deg is no finite number"),
        ("t_s;angle_deg\n1.234,5;1,234.5\n", ":2: t_s is no finite number"),
    ],
)
def test_what_is_no_number_is_refused(tmp_path, text, told):
    path = tmp_path / "log.csv"
    path.write_text(text)
    with refused(told):
        number_columns(path, "t_s", "angle_deg")
