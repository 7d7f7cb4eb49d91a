"""The statements of Lee, Kim & Kim (2025) in our words, each with its measure and condition."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import pandas as pd

from rolling.lee2025 import conditions
from rolling.lee2025.conditions import LENGTH, LOAD, NOT_RUN, ROUGHNESS, Comparison

SMOOTH, MIDDLE, ROUGH, ROUGHEST = 0.01, 0.1, 1.0, 5.0  # Ra [um] of the article
ROUGHNESSES = (SMOOTH, MIDDLE, ROUGH, ROUGHEST)
YIELDING = (MIDDLE, ROUGH, ROUGHEST)
SCALES = (10, 20)  # factors of the logarithm in the level of a release power
COLUMNS = ["key", "source", "statement", "criterion", "reading", "scale", "verdict", "measured"]
NO_AREA = 0.005  # share of the Hertz area, less than a mark in a figure from 0 to 1


@dataclass(frozen=True)
class Statement:
    """A statement of the article in our words, with the measure and the condition that judge it.

    Parameters
    ----------
    key : str. Its name in tables.
    source : str. Sections and figures of the article.
    sentence : str. The statement in our words.
    criterion : str. The condition in words; a statement holds in part where some places meet it.
    column : str. The measure; a level with `{scale}` is judged with 10 lg and with 20 lg.
    condition : function from cases and column to comparisons.
    roughnesses : tuple of float, um. The roughnesses that it concerns. Default: all.
    of_lengths : bool. True if it concerns the sweep of the correlation length. Default: False.
    """

    key: str
    source: str
    sentence: str
    criterion: str
    column: str
    condition: Callable[[pd.DataFrame, str], list[Comparison]]
    roughnesses: tuple[float, ...] = ROUGHNESSES
    of_lengths: bool = False


UP_LOADS = "rises at every step of the load"
UP_ROUGHNESSES = "rises at every step of the roughness, at each load"
with_load = partial(conditions.monotonic, along=LOAD, across=ROUGHNESS)
with_roughness = partial(conditions.monotonic, along=ROUGHNESS, across=LOAD, by_step=True)
with_length = partial(conditions.monotonic, along=LENGTH, across=LOAD, by_step=True)
over_smooth = partial(conditions.mean_change, along=ROUGHNESS, start=SMOOTH)
over_loads = partial(conditions.mean_change, along=LOAD, any_is_near=True)
MAXIMUM, AUDIBLE = "maximum_{scale}_db", "audible_{scale}_db"

STATEMENTS = (
    Statement(
        "pressure-below-limit",
        "section 3, Fig. 5a",
        "At Ra 0.01 µm the pressure stays below the 2.1 GPa of yielding, even at 100 N.",
        "maximum over all surfaces below 2.1 GPa at each load",
        "max_pressure_gpa",
        partial(conditions.bounded, statistic="max", high=2.1),
        (SMOOTH,),
    ),
    Statement(
        "pressure-load",
        "section 3, Fig. 5a",
        "At Ra 0.01 µm the contact pressure grows with the load.",
        UP_LOADS,
        "max_pressure_gpa",
        partial(with_load, by_step=True),
        (SMOOTH,),
    ),
    Statement(
        "contact-area-load",
        "section 3, Fig. 5a",
        "At Ra 0.01 µm the contact area grows with the load.",
        UP_LOADS,
        "contact_area_um2",
        partial(with_load, by_step=True),
        (SMOOTH,),
    ),
    Statement(
        "plastic-none",
        "section 3, Fig. 7",
        "At Ra 0.01 µm nothing yields at any load.",
        f"plastic area below {NO_AREA:g} of the Hertz area, less than a mark in the figure",
        "plastic_ratio",
        partial(conditions.bounded, statistic="mean", high=NO_AREA),
        (SMOOTH,),
    ),
    Statement(
        "hardness-reached",
        "section 3, Fig. 5b to d",
        "From Ra 0.1 µm on, the maximum pressure is the pressure at which the plate yields.",
        "some plastic area on every surface, at whichever limit of the pressure",
        "plastic_ratio",
        partial(conditions.bounded, statistic="min", low=0.0),
        YIELDING,
    ),
    Statement(
        "plastic-area-load",
        "section 3, Fig. 5",
        "From Ra 0.1 µm on, a higher load makes the plastic area larger.",
        UP_LOADS,
        "plastic_area_um2",
        with_load,
        YIELDING,
    ),
    Statement(
        "plastic-area-roughness",
        "section 3, Fig. 5",
        "The rougher the surface, the larger the plastic area.",
        UP_ROUGHNESSES,
        "plastic_area_um2",
        with_roughness,
    ),
    Statement(
        "plastic-ratio-load",
        "section 3, Fig. 7",
        "From Ra 0.1 µm on, the plastic area grows faster with the load than the Hertz area does.",
        UP_LOADS,
        "plastic_ratio",
        with_load,
        YIELDING,
    ),
    Statement(
        "plastic-ratio-1-over-0.1",
        "section 3, Fig. 7; conclusions",
        "At any load the plastic area at Ra 1 µm is about 1.5 times the area at Ra 0.1 µm.",
        "ratio of the means 1.3 to 1.7",
        "plastic_ratio",
        partial(conditions.ratio, over=ROUGH, under=MIDDLE, low=1.3, high=1.7),
    ),
    Statement(
        "plastic-ratio-5-like-1",
        "section 3, Fig. 7; conclusions",
        "The plastic area at Ra 5 µm is about as large as at Ra 1 µm.",
        "ratio of the means 0.85 to 1.15",
        "plastic_ratio",
        partial(conditions.ratio, over=ROUGHEST, under=ROUGH, low=0.85, high=1.15),
    ),
    Statement(
        "deflection-roughest",
        "section 3, Fig. 6",
        "The roughest plate (Ra 5 µm) is deflected least.",
        "lower than on each other roughness",
        "deflection_um",
        partial(conditions.lowest, roughness=ROUGHEST),
    ),
    Statement(
        "deflection-roughness",
        "section 3, Fig. 6",
        "The rougher the surface, the less the plate is deflected.",
        "falls at every step of the roughness, at each load",
        "deflection_um",
        partial(with_roughness, sign=-1),
    ),
    Statement(
        "yielding-deflection",
        "section 3, Fig. 6",
        "A plate that yields is deflected less than an elastic plate.",
        "below its twin's, at Ra 0.1 and 1 µm, at 5, 20 and 100 N",
        "deflection_um",
        conditions.less_than_twin,
    ),
    Statement(
        "yielding-noise",
        "abstract",
        "The change from elastic to plastic deformation alters the noise considerably.",
        "level, or a third of the third octaves, off its twin's by twice the uncertainty",
        AUDIBLE,
        partial(conditions.beside_twin, louder=False),
    ),
    Statement(
        "level-roughness",
        "abstract; section 3, Fig. 8",
        "Within hearing, a rougher surface is louder.",
        f"A-weighted level of the whole sound {UP_ROUGHNESSES}",
        AUDIBLE,
        with_roughness,
    ),
    Statement(
        "level-load",
        "abstract; section 3, Fig. 8; conclusions",
        "Within hearing, a higher load is louder.",
        f"A-weighted level of the whole sound {UP_LOADS}",
        AUDIBLE,
        with_load,
    ),
    Statement(
        "level-above-70",
        "abstract; section 3, Fig. 8; conclusions",
        "From Ra 0.1 µm on, levels pass the 70 dB of a squeal.",
        "some load, also in a record ten times as long; in part: in one a tenth as long",
        "maximum_10_db",
        partial(conditions.exceeds, level_db=70.0),
        YIELDING,
    ),
    Statement(
        "high-frequency-gap",
        "section 3, Fig. 8a",
        "At Ra 0.01 µm the spectra from 50 N on lie far above the others at high frequencies.",
        "mean height above 5 kHz: gap of 6 dB, and 1.5 times any other step of the load",
        "high_{scale}_db",
        partial(conditions.stands_apart, low=20.0, high=50.0),
        (SMOOTH,),
    ),
    Statement(
        "maximum-over-smooth",
        "abstract; section 3, Fig. 9; conclusions",
        "From Ra 0.1 µm on, the maximum line is some 10 to 15 dB higher than at Ra 0.01 µm.",
        "mean over the loads 8 to 17 dB",
        MAXIMUM,
        partial(over_smooth, ends=YIELDING, bounds=(8.0, 17.0)),
    ),
    Statement(
        "maximum-load",
        "section 3, Fig. 9",
        "From 5 to 100 N the maximum line rises by some 14 dB, averaged over the roughnesses.",
        "average 12 to 16 dB; in part: on some roughness",
        MAXIMUM,
        partial(over_loads, start=5.0, ends=(100.0,), bounds=(12.0, 16.0)),
    ),
    Statement(
        "maximum-flattens",
        "section 3, Fig. 9",
        "Beyond 50 N the maximum line level rises little.",
        "per doubling of the load at most half of the rise from 5 to 50 N",
        MAXIMUM,
        partial(conditions.flattens, start=5.0, knee=50.0, end=100.0, share=0.5),
    ),
    Statement(
        "loudest-20-50",
        "section 3, Fig. 9",
        "At 20 and at 50 N, Ra 1 µm is the loudest.",
        "highest mean of the maximum line; in part: another's lead is within its margin",
        MAXIMUM,
        partial(conditions.loudest, roughness=ROUGH, loads=(20.0, 50.0)),
    ),
    Statement(
        "loudest-100",
        "section 3, Fig. 9",
        "At 100 N, Ra 5 µm is the loudest.",
        "highest mean of the maximum line; in part: another's lead is within its margin",
        MAXIMUM,
        partial(conditions.loudest, roughness=ROUGHEST, loads=(100.0,)),
    ),
    Statement(
        "little-influence",
        "section 3, Fig. 9",
        "From Ra 0.1 µm on, roughness hardly affects the maximum line level.",
        "the three lie within 5 dB, the width of the article's own 10 to 15 dB",
        MAXIMUM,
        partial(conditions.within, span_db=5.0),
        YIELDING,
    ),
    Statement(
        "yielding-louder",
        "section 3, outlook",
        "Energy that is released where the plate yields can make the sound louder.",
        "A-weighted level above its twin's by more than twice the uncertainty",
        AUDIBLE,
        partial(conditions.beside_twin, louder=True),
    ),
    Statement(
        "length-frequency",
        "section 3, outlook",
        "A short autocorrelation length makes for high-frequency noise, a long one for low.",
        "spectral centroid falls at every step of the length",
        "centroid_hz",
        partial(with_length, sign=-1),
        of_lengths=True,
    ),
    Statement(
        "length-level",
        "section 3, outlook",
        "A short autocorrelation length makes for intense noise, a long one for quiet.",
        "A-weighted level of the whole sound falls at every step of the length",
        AUDIBLE,
        partial(with_length, sign=-1),
        of_lengths=True,
    ),
)


def judge(statement: Statement, cases: pd.DataFrame, scale: int) -> tuple[str, str]:
    """Return the verdict of a reading's cases on a statement, and the measured numbers."""
    sweeps_lengths = cases[LENGTH].nunique() > 1
    if sweeps_lengths != statement.of_lengths:
        return NOT_RUN, ""
    chosen = cases[cases[ROUGHNESS].isin(statement.roughnesses)]
    comparisons = statement.condition(chosen, statement.column.format(scale=scale))
    measured = "; ".join(f"{place.place}: {place.measured}" for place in comparisons)
    return conditions.verdict(comparisons), measured


def verdicts(readings: dict[str, pd.DataFrame]) -> pd.DataFrame:
    """Judge all statements by the cases of each reading, with each scale of levels.

    Returns a row for each statement, reading and scale; the scale is 0 without levels.
    """
    rows = []
    for statement in STATEMENTS:
        scales = SCALES if "{scale}" in statement.column else (0,)
        for reading, cases in readings.items():
            for scale in scales:
                word, measured = judge(statement, cases, scale)
                words = statement.source, statement.sentence, statement.criterion
                rows.append((statement.key, *words, reading, scale, word, measured))
    return pd.DataFrame(rows, columns=COLUMNS)
