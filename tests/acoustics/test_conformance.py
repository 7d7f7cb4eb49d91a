"""The conformance page agrees with the tables of IEC 61672-1:2013 and IEC 61260-1:2014."""

import csv
import math
from pathlib import Path

import pytest

from acoustics.bands import BAND_NAMES, LEAST_BT, band_uncertainty_db
from conformance import __main__, standards
from conformance.bands import min_lines_inside
from conformance.rows import Row, Table

ROOT = Path(__file__).parents[2]
OPEN = "Third octaves: tones that do not fit the record"
BANDWIDTH = "Third octaves: effective bandwidth"

# What the page states to be outside class 1, and nothing else: leakage of records that do not
# close, and bands of few lines.
OUTSIDE = {
    OPEN: {
        ("0.5 s, cut", "20", "inside"),
        ("0.5 s, faded", "20", "inside"),
        *(("0.5 s, cut", band, "outside") for band in ("20", "100", "1000", "20000")),
        *(("0.5 s, faded", band, "outside") for band in ("20", "100")),
        *(("10 s, cut", band, "outside") for band in ("20", "100", "1000", "20000")),
        *(("10 s, faded", band, "outside") for band in ("20", "100")),
    },
    BANDWIDTH: {("0.5 s", "20"), ("0.5 s", "31.5")},
}


@pytest.fixture(scope="module")
def tables() -> dict[str, Table]:
    return {table.title: table for table in __main__.tables()}


@pytest.mark.slow
def test_the_page_is_what_the_command_prints_now(tables):
    written = (ROOT / "acoustics" / "CONFORMANCE.md").read_text(encoding="utf-8")
    now = __main__.page(list(tables.values()))
    assert written == now, f"acoustics/CONFORMANCE.md is out of date: {__main__.COMMAND}"


def test_every_row_is_within_its_limits_but_those_the_page_states(tables):
    for title, table in tables.items():
        outside = {named(title, row) for row in table.outside}
        assert outside == OUTSIDE.get(title, set()), title
        assert ("outside" in __main__.verdict(table)) == (title in OUTSIDE)


def named(title: str, row: Row) -> tuple[str, ...]:
    """Return the parts of a row that do not depend on the place of its worst point."""
    if title == OPEN:
        return row.keys[0], row.keys[1], row.keys[4]
    return row.keys[:2]


def test_the_sizes_are_those_of_the_standards(tables):
    # 34 frequencies; 12 bursts with F and E, 9 with S; 19 frequencies of a third octave, 15 of them
    # below 24 kHz at 20 kHz.
    assert len(tables["A-weighting"].rows) == 34
    assert len(tables["Tone bursts"].rows) == 12 + 9 + 12
    assert len(tables["Third octaves: tones on a line"].rows) == 19 + 19 + 15


def test_the_table_of_a_weighting_is_the_file():
    with (ROOT / "tests" / "data" / "a_weighting_iec61672.csv").open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    names = ("n", "nominal_hz", "a_weighting_db", "class1_lower_db", "class1_upper_db")
    assert [tuple(float(row[name]) for name in names) for row in rows] == [
        tuple(row) for row in standards.A_WEIGHTING
    ]


def test_tabled_burst_responses_are_the_standards_equations_rounded():
    # Equations (7) and (8): half a unit of the tenth, and 0.05 more where the standard rounds -4.05
    # to -4.1 and the like.
    for row in standards.TONE_BURSTS:
        duration_s = row.duration_ms / 1000.0
        assert abs(row.fast_db - 10.0 * math.log10(-math.expm1(-duration_s / 0.125))) < 0.051
        assert abs(row.exposure_db - 10.0 * math.log10(duration_s)) < 0.051
        if row.slow_db is not None:
            assert abs(row.slow_db - 10.0 * math.log10(-math.expm1(-duration_s))) < 0.051
    for decay, time_constant_s in zip(standards.DECAY_RATES, (0.125, 1.0), strict=True):
        assert abs(decay.rate_db_s - 10.0 * math.log10(math.e) / time_constant_s) < 0.05


def test_third_octave_frequency_ratios_are_those_the_standard_tables():
    # IEC 61260 gives them for third octaves to five decimals (1995 edition, annex B, base 10; the
    # formula is the same).
    for exponent, ratio in (
        (1 / 8, 1.02667),
        (1 / 4, 1.05575),
        (3 / 8, 1.08746),
        (1 / 2, 1.12202),
        (1, 1.29437),
    ):
        assert standards.third_octave_frequency_ratio(exponent) == pytest.approx(ratio, abs=6e-6)
    for exponent, ratio in ((2, 1.88173), (3, 3.05365), (4, 5.39195)):
        assert standards.third_octave_frequency_ratio(exponent) == pytest.approx(ratio, abs=6e-6)


def test_what_the_page_says_of_few_lines_is_so(tables):
    # The page prints one decimal of it beside the B T of reliable bands.
    assert min_lines_inside() == pytest.approx(LEAST_BT, abs=0.25)
    for row in tables[BANDWIDTH].rows:
        uncertainty_db = band_uncertainty_db(float(row.keys[0].split()[0]))[
            BAND_NAMES.index(row.keys[1])
        ]
        assert abs(row.computed) < 0.5 * uncertainty_db


def test_a_share_is_of_the_limit_on_its_side():
    assert Row((), 1.0, 1.5, -2.0, 1.0).share == 50.0
    assert Row((), 1.0, 0.5, -2.0, 1.0).share == 25.0
    assert Row((), 1.0, -9.0, -math.inf, 1.0).share == 0.0
    assert Row((), 0.0, 1.01, -1.0, 1.0).within is False
    # An attenuation: required over computed, whatever its sign.
    assert Row((), math.inf, 80.0, 40.0, math.inf).share == 50.0
    assert Row((), math.inf, 39.0, 40.0, math.inf).within is False
    assert Row((), math.inf, -1.0, 40.0, math.inf).within is False
    assert Row((), math.inf, math.inf, 40.0, math.inf).share == 0.0


def test_rounding_does_not_show():
    table = Table(
        "t", "class 1", "s", "x", ("what",), "dB", 2, (Row(("a",), 0.0, -1e-13, -1.0, 1.0),)
    )
    noisy = __main__.page([table])
    exact = __main__.page(
        [Table("t", "class 1", "s", "x", ("what",), "dB", 2, (Row(("a",), 0.0, 0.0, -1.0, 1.0),))]
    )
    assert noisy == exact and "-0.00" not in noisy
