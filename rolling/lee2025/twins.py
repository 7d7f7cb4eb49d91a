"""Criteria for the effect of yielding, which compare a case with its twin without hardness.

Both roll over the same surface. The uncertainty from the record's length treats them as
independent, so it is an upper bound.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from acoustics.bands import BAND_NAMES, MID_HZ, band_uncertainty_db, reliable
from rolling.lee2025.checks import GRID, NOT_RUN, Check, Finding, concluded, doubt
from rolling.lee2025.measures import AUDIBLE, Cases, Measure, newton, ra
from rolling.lee2025.study import Case

# third octaves up to 4 kHz: a grid of 2 um reads too high above it where the plate yields
HIGHEST_BAND_HZ = 4500.0
# share of the third octaves; by chance every twentieth differs by more than twice its uncertainty
LEAST_SHARE = 1 / 3
NO_TWIN = "no twin without hardness was run of it"

Pair = tuple[Case, Case]


def influences(study: Cases) -> Finding:
    """Judge whether yielding alters the sound: LAeq, or a third of the third octaves.

    Each roughness and load is a part.
    """
    checks = []
    for roughness, load, pairs in _pairs(study):
        step, error = _audible_step(study, pairs)
        bands, off, uncertain = _band_steps(study, pairs)
        grid_db, grid_band_db = (
            study.factor / 10 * reach
            for reach in (_reach(study, roughness, load), study.grid.band_db.get(roughness, 0.0))
        )

        def differs(
            level_grid: float,
            band_grid: float,
            step: Any = step,
            error: Any = error,
            off: Any = off,
            uncertain: Any = uncertain,
        ) -> bool:
            beyond = np.abs(off) > np.maximum(2 * uncertain, band_grid)
            return abs(step) > max(2 * error, level_grid) or (
                len(off) > 0 and float(beyond.mean()) >= LEAST_SHARE
            )

        nominal, strict = differs(0.0, 0.0), differs(grid_db, grid_band_db)
        count = int(np.count_nonzero(np.abs(off) > 2 * uncertain))
        text = f"{AUDIBLE.text(step, '+')} ± {error:.1f} dB"
        if bands:
            text += f", {count} of {len(bands)} third octaves ({bands[0]} to {bands[-1]} Hz)"
        numbers = {
            "level": step,
            "uncertainty": error,
            "third octaves": dict(zip(bands, (float(value) for value in off), strict=True)),
        }
        place = f"{ra(roughness)}, {newton(load)}"
        checks.append(
            Check(
                place,
                nominal,
                text,
                numbers,
                unsure=GRID if nominal != strict else "",
                places=((roughness, load),),
            )
        )
    return concluded(checks) if checks else Finding(NOT_RUN, NO_TWIN)


def louder(study: Cases) -> Finding:
    """Judge whether yielding makes the sound louder by more than twice the uncertainty.

    Each roughness and load is a part.
    """
    checks = []
    for roughness, load, pairs in _pairs(study):
        step, error = _audible_step(study, pairs)
        grid = _reach(study, roughness, load) * study.factor / 10
        holds = step > 2 * error
        text = f"{AUDIBLE.text(step, '+')} ± {error:.1f} dB"
        place = f"{ra(roughness)}, {newton(load)}"
        unsure = doubt(step - 2 * error, lambda beyond: beyond > 0, (-grid, grid), 0.0)
        places = ((roughness, load),)
        checks.append(Check(place, holds, text, step, unsure=unsure, places=places))
    return concluded(checks) if checks else Finding(NOT_RUN, NO_TWIN)


def less(study: Cases, measure: Measure) -> Finding:
    """Judge whether yielding lowers a measure on every surface.

    Each roughness and load is a part.
    """
    checks = []
    for roughness, load, pairs in _pairs(study):
        values = [
            (measure.of(case, study.factor), measure.of(twin, study.factor)) for case, twin in pairs
        ]
        known = [(a, b) for a, b in values if math.isfinite(a) and math.isfinite(b)]
        place = f"{ra(roughness)}, {newton(load)}"
        if not known:
            checks.append(Check(place, None))
            continue
        a, b = np.mean(known, axis=0)
        text = f"{measure.text(float(a))} instead of {measure.text(float(b))} {measure.unit}"
        checks.append(Check(place, all(a < b for a, b in known), text, float(a / b)))
    return concluded(checks) if checks else Finding(NOT_RUN, NO_TWIN)


def _pairs(study: Cases) -> Iterator[tuple[float, float, list[Pair]]]:
    """Yield each roughness and load with all its cases that have a twin."""
    for roughness in study.roughnesses:
        for load in study.loads:
            pairs = [
                (case, twin) for case in study.at(roughness, load) if (twin := study.twin(case))
            ]
            if pairs and all(
                math.isfinite(AUDIBLE.of(case, study.factor)) for pair in pairs for case in pair
            ):
                yield roughness, load, pairs


def _audible_step(study: Cases, pairs: Sequence[Pair]) -> tuple[float, float]:
    """Return the mean level with yielding minus the level without yielding [dB].

    The standard uncertainty of the difference is returned as well.
    """

    def uncertainty(case: Case) -> float:
        return (
            case.laeq_uncertainty_db
            if study.factor == 10
            else case.weighted_uncertainty_db * study.factor / 20
        )

    steps = [
        AUDIBLE.of(case, study.factor) - AUDIBLE.of(twin, study.factor) for case, twin in pairs
    ]
    square = [uncertainty(case) ** 2 + uncertainty(twin) ** 2 for case, twin in pairs]
    return float(np.mean(steps)), math.sqrt(sum(square)) / len(pairs)


def _band_steps(study: Cases, pairs: Sequence[Pair]) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Return names, mean differences [dB] and uncertainties of the resolved third octaves."""
    duration = min(case.duration_s for case, _ in pairs)
    there = reliable(duration) & (MID_HZ < HIGHEST_BAND_HZ)
    ratios = np.array([case.band_w / twin.band_w for case, twin in pairs])
    there &= np.isfinite(ratios).all(axis=0) & (ratios > 0).all(axis=0)
    off = study.factor * np.log10(ratios[:, there]).mean(axis=0)
    uncertain = band_uncertainty_db(duration)[there] * study.factor / 20 * math.sqrt(2 / len(pairs))
    return [name for name, reads in zip(BAND_NAMES, there, strict=True) if reads], off, uncertain


def _reach(study: Cases, roughness: float, load: float) -> float:
    """Return the maximum effect of the grid on a level [dB, 10 lg].

    The error of a twin is far smaller and does not count.
    """
    return max(abs(end) for end in study.grid.change_db(AUDIBLE.grid, roughness, load))
