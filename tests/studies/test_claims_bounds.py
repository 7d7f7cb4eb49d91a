"""Verdicts that grid, number of surfaces or length of the record may turn are undecided."""

from __future__ import annotations

import numpy as np
import pytest
from claim_cases import (
    Change,
    finding,
    louder,
    on,
    put,
    study,
    verdict,
    when,
    with_grid,
)

from acoustics.spectrum import article_line_level_db
from rolling.lee2025 import bounds, claims, claims_text
from rolling.lee2025.checks import (
    GRID,
    NOT,
    PARTLY,
    RECORD,
    REPRODUCED,
    SURFACES,
    UNDECIDED,
)
from rolling.lee2025.grid_error import GridError


@pytest.mark.parametrize(
    ("fine", "expected"),
    [
        ((1.0, 1.1), REPRODUCED),  # 1.5 to 1.36: still within 1.3 to 1.7
        ((1.0, 1.3), UNDECIDED),  # 1.5 to 1.15
        ((0.8, 1.0), UNDECIDED),  # 1.5 to 1.88
    ],
)
def test_a_ratio_that_a_fine_grid_may_turn_is_undecided(
    monkeypatch: pytest.MonkeyPatch, fine: tuple[float, float], expected: str
) -> None:
    """The plastic ratio at Ra 0.1 um grows by these factors on a fine grid."""
    assert verdict("plastic-ratio-1-over-0.1", study()) == REPRODUCED
    with_grid(monkeypatch, plastic={0.1: {20: fine}})  # of one load: taken for all
    found = finding("plastic-ratio-1-over-0.1", study())
    assert found["verdict"] == expected
    if expected == UNDECIDED:
        assert found["decided_by"] == GRID and found["between"] == [NOT, REPRODUCED]
        assert (
            f"fine grid: {min(1.5, 1.5 / fine[1]):.2f} to {max(1.5, 1.5 / fine[0]):.2f}"
            in found["measured"]
        )
        assert f"{UNDECIDED} (the grid)" in claims_text.markdown(claims.table(study()))


def test_errors_of_loads_between_measured_ones_are_those_of_both() -> None:
    error = GridError(
        plastic={0.1: {5: (1.1, 1.6), 20: (1.0, 1.3)}}, level_db={1.0: {5: (-3.0, 0.1)}}
    )
    assert [error.factor("plastic", 0.1, w) for w in (1, 5, 10, 20, 100)] == [
        (1.1, 1.6), (1.1, 1.6), (1.0, 1.6), (1.0, 1.3), (1.0, 1.3)
    ]  # fmt: skip
    assert error.factor("plastic", 1.0, 5) == (1.0, 1.0) and error.factor("", 0.1, 5) == (1.0, 1.0)
    assert error.ratio("plastic", 1.0, 0.1, 5) == (1 / 1.6, 1.0)  # with the study's own grid in it
    assert error.shift_db("level_db", (1.0, 5), (0.1, 5), 20) == (-6.0, 0.2)
    assert error.shift_db("level_db", (0.1, 5), (1.0, 5), 10) == (-0.1, 3.0)


def test_a_failed_ratio_may_hold_on_a_fine_grid(monkeypatch: pytest.MonkeyPatch) -> None:
    changed = when(on(1.0), put("plastic_ratio", lambda c: 0.38 * (1.0 + c.load_n / 200.0)))  # 1.9
    assert verdict("plastic-ratio-1-over-0.1", study(changed=changed)) == NOT
    with_grid(monkeypatch, plastic={0.1: {20: (1.0, 1.25)}})  # 1.9 to 1.52
    assert verdict("plastic-ratio-1-over-0.1", study(changed=changed)) == UNDECIDED
    with_grid(monkeypatch, plastic={0.1: {20: (1.0, 1.05)}})  # 1.9 to 1.81
    assert verdict("plastic-ratio-1-over-0.1", study(changed=changed)) == NOT


def test_steps_smaller_than_the_grids_error_are_undecided(monkeypatch: pytest.MonkeyPatch) -> None:
    """An error of the grid above a step makes its verdict undecided.

    The steps are: plastic area 0.30 to 0.31, deflection 0.18 to 0.1 per newton, and levels by
    0.5 dB from Ra 1 to 5 um.
    """
    with_grid(
        monkeypatch,
        plastic={5: {5: (0.99, 1)}},
        deflection={5: {5: (1, 1.02)}},
        level_db={5: {5: (-0.4, 0)}},
    )
    keys = (
        "plastic-area-roughness",
        "deflection-roughness",
        "deflection-roughest",
        "level-roughness",
    )
    assert [verdict(key, study()) for key in keys] == [REPRODUCED] * 4
    with_grid(
        monkeypatch,
        plastic={5: {5: (0.96, 1)}},
        deflection={5: {5: (1, 1.9)}},
        level_db={5: {5: (-0.6, 0)}},
    )
    assert [verdict(key, study()) for key in keys] == [UNDECIDED] * 4
    assert verdict("level-roughness", study(), 20) == UNDECIDED  # both double
    assert finding("level-roughness", study())["between"] == [PARTLY, REPRODUCED]


def test_bounds_within_twice_the_standard_error_are_undecided() -> None:
    """With a spread of 0.1 a mean ratio of 1.66 is not certainly below the bound of 1.7."""

    def spread(by: float) -> Change:
        return when(
            on(1.0),
            put("plastic_ratio", lambda c: (0.332 + by * (c.seed - 3)) * (1.0 + c.load_n / 200.0)),
        )

    assert verdict("plastic-ratio-1-over-0.1", study(5, changed=spread(0.0))) == REPRODUCED
    found = finding("plastic-ratio-1-over-0.1", study(5, changed=spread(0.02)))
    assert (found["verdict"], found["decided_by"]) == (UNDECIDED, SURFACES)


def test_level_above_70_turns_with_the_length_of_the_record() -> None:
    """A maximum line of 72 dB at 0.05 s falls to 70 dB at 0.13 s, 10^(2/5) times that.

    A line of 76 dB falls to it at 16 times.
    """
    for above, expected in ((2.0, UNDECIDED), (-2.0, UNDECIDED), (6.0, REPRODUCED), (-6.0, NOT)):
        wanted = 70.0 + above
        cases = study(
            changed=lambda case, wanted=wanted: louder(lambda c: wanted - c.maximum_db)(case)
        )
        found = finding("level-above-70", cases)
        assert found["verdict"] == expected
        assert (
            f"turns at a record of {0.05 * 10 ** (above / 5):.2g} s instead of 0.05 s"
            in found["measured"]
        )
        assert found["decided_by"] == (RECORD if expected == UNDECIDED else "")


def test_lines_of_noise_fall_by_5_db_in_a_record_ten_times_as_long() -> None:
    """The amplitude of a line, in 10 lg, follows 1 / sqrt(T).

    The median of 3000 lines is known to 0.07 dB.
    """
    noise = np.random.default_rng(1).standard_normal(60000)
    short, long = (article_line_level_db(noise[:n], 48000, 1.0)[1][1:] for n in (6000, 60000))
    assert np.median(short) - np.median(long) == pytest.approx(bounds.LG_LENGTH_DB, abs=0.2)
