"""The conformance page agrees with the tables of IEC 61672-1:2013 and IEC 61260-1:2014."""

import csv
import math
from pathlib import Path

import conformance_page
import pytest
from conformance import standards
from conformance.bands import min_lines_inside
from conformance.rows import Row, Table

from acoustics.bands import BAND_NAMES, MIN_BT, band_uncertainty_db

ROOT = Path(__file__).parents[2]
OPEN = "Third octaves: tones that do not fit the record"
BANDWIDTH = "Third octaves: effective bandwidth"

# All that the page states to be outside class 1: leakage of records that do not close, and bands of
# few lines.
OUTSIDE = {
    OPEN: {
        *((f"0.5 s, {ends}", "20", "inside") for ends in ("cut", "faded")),
        *(
            (f"{length}, {ends}", band, "outside")
            for length in ("0.5 s", "10 s")
            for ends, bands in (("cut", ("20", "100", "1000", "20000")), ("faded", ("20", "100")))
            for band in bands
        ),
    },
    BANDWIDTH: {("0.5 s", "20"), ("0.5 s", "31.5")},
}


@pytest.fixture(scope="module")
def tables() -> dict[str, Table]:
    return {table.title: table for table in conformance_page.tables()}


@pytest.mark.slow
def test_the_page_is_the_output_of_its_command(tables: dict[str, Table]) -> None:
    written = (ROOT / "acoustics" / "CONFORMANCE.md").read_text(encoding="utf-8")
    assert written == conformance_page.page(list(tables.values())), conformance_page.COMMAND


def test_every_row_is_within_its_limits_but_for_known_ones(tables: dict[str, Table]) -> None:
    for title, table in tables.items():
        outside = {row.keys[:2] + row.keys[4:] for row in table.outside}
        assert outside == OUTSIDE.get(title, set()), title


def test_the_sizes_are_those_of_the_standards(tables: dict[str, Table]) -> None:
    # 34 frequencies; 12 bursts with F and E, 9 with S; 19 frequencies of a third octave, 15 of them
    # below 24 kHz at 20 kHz.
    assert len(tables["A-weighting"].rows) == 34
    assert len(tables["Tone bursts"].rows) == 12 + 9 + 12
    assert len(tables["Third octaves: tones on a line"].rows) == 19 + 19 + 15


def test_the_table_of_a_weighting_is_the_file() -> None:
    with (ROOT / "tests" / "data" / "a_weighting_iec61672.csv").open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    names = ("n", "nominal_hz", "a_weighting_db", "class1_lower_db", "class1_upper_db")
    assert [tuple(float(row[name]) for name in names) for row in rows] == [
        tuple(row) for row in standards.A_WEIGHTING
    ]


def test_tabled_burst_responses_are_the_equations_of_the_standard_rounded() -> None:
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


@pytest.mark.parametrize(
    ("exponent", "ratio"),
    [(1 / 8, 1.02667), (1 / 4, 1.05575), (3 / 8, 1.08746), (1 / 2, 1.12202), (1, 1.29437),
     (2, 1.88173), (3, 3.05365), (4, 5.39195)],
)  # fmt: skip
def test_third_octave_frequency_ratios_are_those_of_the_standard(
    exponent: float, ratio: float
) -> None:
    """The edition of 1995 gives five decimals (annex B, base 10; the formula is the same)."""
    assert standards.third_octave_frequency_ratio(exponent) == pytest.approx(ratio, abs=6e-6)


def test_bands_of_few_lines_are_as_the_page_says(tables: dict[str, Table]) -> None:
    # The page prints one decimal of it beside the B T of reliable bands.
    assert min_lines_inside() == pytest.approx(MIN_BT, abs=0.25)
    for row in tables[BANDWIDTH].rows:
        uncertainty_db = band_uncertainty_db(float(row.keys[0].split()[0]))
        assert abs(row.computed) < 0.5 * uncertainty_db[BAND_NAMES.index(row.keys[1])]


@pytest.mark.parametrize(
    ("row", "share"),
    [
        (Row((), 1.0, 1.5, -2.0, 1.0), 50.0),
        (Row((), 1.0, 0.5, -2.0, 1.0), 25.0),
        (Row((), 1.0, -9.0, -math.inf, 1.0), 0.0),
        (Row((), 0.0, 1.01, -1.0, 1.0), 101.0),
        # an attenuation: required over computed, whatever its sign
        (Row((), math.inf, 80.0, 40.0, math.inf), 50.0),
        (Row((), math.inf, 39.0, 40.0, math.inf), 102.6),
        (Row((), math.inf, -1.0, 40.0, math.inf), math.inf),
    ],
)
def test_a_share_belongs_to_the_limit_on_its_side(row: Row, share: float) -> None:
    assert row.share == share
    assert row.within == (share <= 100.0)
