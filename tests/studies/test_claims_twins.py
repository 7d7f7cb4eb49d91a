"""Claims about yielding compare each case with its twin without hardness."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from claim_cases import (
    finding,
    louder,
    study,
    twins,
    verdict,
    with_grid,
)

from acoustics.bands import MID_HZ
from rolling.lee2025 import claims, measures
from rolling.lee2025.checks import (
    GRID,
    NOT,
    NOT_RUN,
    REPRODUCED,
)
from rolling.lee2025.study import Case


def test_without_twins_nothing_is_said_of_yielding() -> None:
    table = claims.table([case for case in study() if case.hardness_gpa])
    findings = [
        row.judgements[0].finding for row in table.claims if row.claim.key.startswith("yielding-")
    ]
    assert len(findings) == 3
    assert all(one.verdict == NOT_RUN and "no twin" in one.measured for one in findings)


def test_a_twin_is_the_same_scene_in_everything_but_hardness() -> None:
    cases = [case for case in study() if case.hardness_gpa]
    study_of = measures.Cases(tuple(cases), 10, tuple(twins(cases)))
    (case,) = study_of.at(0.1, 5.0)
    match = study_of.twin(case)
    assert match is not None and match.hardness_gpa is None
    for other in (
        {"bodies": "two bodies"},
        {"seed": 2},
        {"load_n": 10.0},
        {"duration_s": 0.5},
        {"correlation_um": 5.0},
    ):
        assert study_of.twin(dataclasses.replace(case, **other)) is None


def test_yielding_is_heard_by_the_level_or_by_the_bands(monkeypatch: pytest.MonkeyPatch) -> None:
    """A difference of 1 dB is too small, unless a third of the bands differ.

    Levels uncertain by 0.4 dB each have a difference uncertain by 0.57 dB.
    """

    def off(db: float, bands: int) -> list[Case]:
        """Return cases `db` above their twins, with some of ten third octaves 6 dB above (10 lg).

        The third octaves are those from 500 Hz to 4 kHz.
        """
        reads = np.isin(np.arange(31), np.flatnonzero(MID_HZ > 450)[:bands])

        def changed(case: Case) -> dict[str, Any]:
            return {
                **louder(lambda c: db - 3.0)(case),
                "band_w": case.band_w / 2 * np.where(reads, 4.0, 1.0),
            }

        return study(changed=changed)

    expected = {
        (1.0, 0): NOT,
        (1.2, 0): REPRODUCED,
        (-1.2, 0): REPRODUCED,
        (0.0, 3): NOT,
        (0.0, 4): REPRODUCED,
    }
    for (db, bands), word in expected.items():
        assert verdict("yielding-noise", off(db, bands)) == word, (db, bands)
        assert verdict("yielding-noise", off(db, bands), 20) == word
    assert (
        verdict("yielding-louder", off(1.2, 0)) == REPRODUCED
        and verdict("yielding-louder", off(-1.2, 0)) == NOT
    )
    with_grid(monkeypatch, level_db={0.1: {5: (-0.2, 1.5)}, 1.0: {5: (-0.2, 1.5)}})
    assert finding("yielding-noise", off(1.2, 0))["decided_by"] == GRID
    assert verdict("yielding-noise", off(1.6, 0)) == REPRODUCED
