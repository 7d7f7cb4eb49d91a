"""Cases made by hand, with known verdicts, for the tests of the claims."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest

from rolling.lee2025 import claims, grid_error
from rolling.lee2025.grid_error import GridError
from rolling.lee2025.statements import LOADS, ROUGHNESSES
from rolling.lee2025.study import Case

LINE_HZ = np.geomspace(100.0, 18000.0, 40)
# The maximum line at Ra 0.01 um and 5 N in 0.05 s: records of half a second still pass 70 dB.
SMOOTH_DB = 72.0
ABOVE_SMOOTH = {0.01: 0.0, 0.1: 11.0, 1.0: 12.0, 5.0: 12.5}  # dB at all loads
OVER_5_N = {5.0: 0.0, 10.0: 2.0, 20.0: 4.0, 50.0: 13.0, 100.0: 14.0}
PLASTIC = {0.01: 0.0, 0.1: 0.2, 1.0: 0.3, 5.0: 0.31}
FIGURES = (
    "fig1_surfaces",
    "fig5_contact_pressure",
    "fig6_deflection",
    "fig7_plastic_ratio",
    "fig8_spectra",
    "fig9_maximum_level",
)
Change = Callable[[Case], dict[str, Any]]


def as_the_article_says(
    roughness: float, load: float, seed: int = 1, reading: str = "article"
) -> Case:
    """Return a case of a study in which each statement about roughness and load holds (10 lg)."""
    level = SMOOTH_DB + ABOVE_SMOOTH[roughness] + OVER_5_N[load]
    if roughness == 1.0 and load < 100:
        level += 1.0
    audible = SMOOTH_DB + ABOVE_SMOOTH[roughness] + OVER_5_N[load]
    return Case(
        reading=reading,
        roughness_um=roughness,
        load_n=load,
        seed=seed,
        correlation_um=10.0,
        hardness_gpa=2.1,
        bodies="article",
        nodes_across=256,
        duration_s=0.05,
        plastic_ratio=PLASTIC[roughness] * (1.0 + load / 200.0),
        contact_ratio=0.9,
        max_pressure=2.1e9 if roughness > 0.01 else 0.4e9 * load ** (1 / 3),
        deflection=(0.2e-6 - 0.02e-6 * roughness) * load,
        laeq_db=audible,
        laeq_uncertainty_db=0.4,
        weighted_uncertainty_db=0.8,
        maximum_db=level,
        maximum_20_db=2 * level,
        line_hz=LINE_HZ,
        line_db=level - np.abs(np.log2(LINE_HZ / 1000.0)),
        band_w=np.full(31, 1e-5),
        a_weighted_w=1e-11 * 10 ** (audible / 10),
    )


def twin(case: Case) -> Case:
    """Return the case without hardness, 3 dB quieter and with a tenth more deflection."""
    return dataclasses.replace(
        case,
        reading="elastic",
        hardness_gpa=None,
        plastic_ratio=0.0,
        deflection=1.1 * case.deflection,
        band_w=case.band_w / 2,
        **louder(lambda c: -3.0)(case),
    )


def twins(cases: Sequence[Case]) -> list[Case]:
    return [
        twin(case)
        for case in cases
        if case.roughness_um in (0.1, 1.0) and case.load_n in (5.0, 20.0, 100.0)
    ]


def study(
    seeds: int = 1, loads: Sequence[float] = LOADS, changed: Change | None = None
) -> list[Case]:
    found = [
        as_the_article_says(ra, load, seed + 1)
        for ra in ROUGHNESSES
        for load in loads
        for seed in range(seeds)
    ]
    without = twins(found)
    return (
        [dataclasses.replace(case, **changed(case)) for case in found] + without
        if changed
        else found + without
    )


def finding(key: str, cases: Sequence[Case], factor: int = 10) -> dict[str, Any]:
    claim = next(row for row in claims.table(cases).to_dict()["claims"] if row["key"] == key)
    return next(one for one in claim["findings"] if one["scale"] in (None, factor))


def verdict(key: str, cases: Sequence[Case], factor: int = 10) -> str:
    return finding(key, cases, factor)["verdict"]


def louder(by: Callable[[Case], float]) -> Change:
    """Return a change that raises all levels and curves of a case by so many dB."""

    def changed(case: Case) -> dict[str, Any]:
        db = by(case)
        return {
            "maximum_db": case.maximum_db + db,
            "maximum_20_db": case.maximum_20_db + 2 * db,
            "line_db": case.line_db + db,
            "laeq_db": None if case.laeq_db is None else case.laeq_db + db,
            "a_weighted_w": case.a_weighted_w * 10 ** (db / 10),
        }

    return changed


def put(name: str, value: Callable[[Case], float]) -> Change:
    return lambda case: {name: value(case)}


def when(holds: Callable[[Case], bool], changed: Change) -> Change:
    return lambda case: changed(case) if holds(case) else {}


def on(roughness: float) -> Callable[[Case], bool]:
    return lambda case: case.roughness_um == roughness


def against_trend(case: Case) -> float:
    """Return the fall that undoes the rise with the load, and 1 dB per doubling more."""
    return -OVER_5_N[case.load_n] - math.log2(case.load_n)


def by_load(values: Sequence[float]) -> Change:
    """Return a change to levels at SMOOTH_DB plus a value for each load."""
    return louder(
        lambda case: (
            SMOOTH_DB + dict(zip(LOADS, values, strict=True))[case.load_n] - case.maximum_db
        )
    )


def as_quiet_as_the_twin(case: Case) -> dict[str, Any]:
    return {**louder(lambda c: -3.0)(case), "band_w": case.band_w / 2}


FALLING_PLASTIC = put("plastic_ratio", lambda case: 0.3 / case.load_n)


# What is changed of the study in which a statement holds, so that it holds in part, and so that it
# does not hold.
OTHERWISE: dict[str, tuple[Change, Change]] = {
    "pressure-below-limit": (
        when(lambda c: c.load_n > 20, put("max_pressure", lambda c: 2.1e9)),
        put("max_pressure", lambda c: 4.9e9),
    ),
    "pressure-load": (
        when(lambda c: c.load_n > 20, put("max_pressure", lambda c: 2.1e9)),
        put("max_pressure", lambda c: 2.1e9),
    ),
    "contact-area-load": (
        when(lambda c: c.load_n == 10, put("contact_ratio", lambda c: 0.1)),
        put("contact_ratio", lambda c: 1 / c.load_n),
    ),
    "plastic-none": (
        when(lambda c: c.load_n > 20, put("plastic_ratio", lambda c: 0.1)),
        put("plastic_ratio", lambda c: 0.01),
    ),
    "hardness-reached": (
        when(lambda c: c.load_n == 5, put("plastic_ratio", lambda c: 0.0)),
        put("plastic_ratio", lambda c: 0.0),
    ),
    "plastic-area-load": (when(on(5.0), FALLING_PLASTIC), FALLING_PLASTIC),
    "plastic-area-roughness": (
        when(on(5.0), put("plastic_ratio", lambda c: 0.2)),
        put("plastic_ratio", lambda c: 0.5 - 0.1 * c.roughness_um),
    ),
    "plastic-ratio-load": (when(on(1.0), FALLING_PLASTIC), FALLING_PLASTIC),
    "plastic-ratio-1-over-0.1": (
        when(lambda c: c.roughness_um == 1 and c.load_n > 20, put("plastic_ratio", lambda c: 0.25)),
        when(on(1.0), put("plastic_ratio", lambda c: 0.55)),
    ),
    "plastic-ratio-5-like-1": (
        when(lambda c: c.roughness_um == 5 and c.load_n > 20, put("plastic_ratio", lambda c: 0.25)),
        when(on(5.0), put("plastic_ratio", lambda c: 0.6)),
    ),
    "deflection-roughest": (
        when(lambda c: c.roughness_um == 5 and c.load_n > 20, put("deflection", lambda c: 1e-4)),
        when(on(5.0), put("deflection", lambda c: 1e-4)),
    ),
    "deflection-roughness": (
        when(on(5.0), put("deflection", lambda c: 1e-4)),
        put("deflection", lambda c: 1e-6 * c.roughness_um),
    ),
    "yielding-deflection": (
        when(on(1.0), put("deflection", lambda c: 1e-4)),
        put("deflection", lambda c: 1e-4),
    ),
    "yielding-noise": (
        when(on(1.0), lambda c: as_quiet_as_the_twin(c)),
        lambda c: as_quiet_as_the_twin(c),
    ),
    "level-roughness": (
        when(on(5.0), louder(lambda c: -3.0)),
        louder(lambda c: -2 * ABOVE_SMOOTH[c.roughness_um]),
    ),
    "level-load": (when(on(0.1), louder(against_trend)), louder(against_trend)),
    "level-above-70": (when(on(5.0), louder(lambda c: -45.0)), louder(lambda c: -45.0)),
    # 6 dB but not apart from the rest; apart from the rest but less than 6 dB; neither
    "high-frequency-gap": (by_load([0, 6, 12, 19, 26]), by_load([0, 3, 6, 9, 12])),
    "maximum-over-smooth": (
        when(on(0.1), louder(lambda c: -4.0)),
        when(lambda c: c.roughness_um > 0.01, louder(lambda c: -6.0)),
    ),
    "maximum-load": (
        when(lambda c: c.roughness_um > 0.01 and c.load_n == 100, louder(lambda c: -5.0)),
        when(lambda c: c.load_n == 100, louder(lambda c: -5.0)),
    ),
    "maximum-flattens": (
        when(lambda c: c.roughness_um < 1 and c.load_n == 100, louder(lambda c: 3.0)),
        when(lambda c: c.load_n == 100, louder(lambda c: 3.0)),
    ),
    "loudest-20-50": (
        when(lambda c: c.roughness_um == 5 and c.load_n == 50, louder(lambda c: 2.0)),
        when(on(5.0), louder(lambda c: 2.0)),
    ),
    "loudest-100": (
        # two of three surfaces of Ra 0.1 um are much louder, one is not: no lead that is certain
        when(lambda c: c.roughness_um == 0.1, louder(lambda c: -4.0 if c.seed == 1 else 9.0)),
        when(on(0.1), louder(lambda c: 9.0)),
    ),
    "little-influence": (
        when(lambda c: c.roughness_um == 5 and c.load_n == 5, louder(lambda c: -8.0)),
        when(on(5.0), louder(lambda c: -8.0)),
    ),
}


def with_grid(monkeypatch: pytest.MonkeyPatch, **ranges: Any) -> None:
    monkeypatch.setattr(grid_error, "MEASURED", {"article": GridError(**ranges)})


def reading(name: str, cases: Sequence[Case]) -> list[Case]:
    return [
        dataclasses.replace(case, reading=name) if case.hardness_gpa else case for case in cases
    ]
