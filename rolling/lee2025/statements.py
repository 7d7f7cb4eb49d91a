"""The statements of Lee, Kim & Kim (2025) in our words, with their tolerances and criteria.

CLAIMS concern the study of roughness and load. OUTLOOK holds the statements that the article only
expects.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from rolling.lee2025 import bounds, trends, twins
from rolling.lee2025.bounds import LARGE_GAP_DB, LARGEST_STEP, LENGTHS, NO_AREA
from rolling.lee2025.checks import Finding
from rolling.lee2025.measures import (
    AUDIBLE,
    CENTROID,
    CONTACT_AREA,
    DEFLECTION,
    HIGH_BAND,
    HIGH_HZ,
    MAXIMUM,
    PLASTIC_AREA,
    PLASTIC_RATIO,
    PRESSURE,
    Cases,
)

SMOOTH, MIDDLE, ROUGH, ROUGHEST = 0.01, 0.1, 1.0, 5.0  # Ra [um] of the article
ROUGHNESSES = (SMOOTH, MIDDLE, ROUGH, ROUGHEST)
YIELDING = (MIDDLE, ROUGH, ROUGHEST)
LOADS = (5.0, 10.0, 20.0, 50.0, 100.0)  # [N]
SCALES = (10, 20)  # factor of the logarithm in the level of a release power
LIMIT = 2.1e9  # pressure at which the article's plate yields [Pa]
SQUEAL_DB = 70.0


@dataclass(frozen=True)
class Claim:
    """A statement of the article in our words, with its place, tolerance and criterion.

    Parameters
    ----------
    key : str. Its name in files and texts.
    where : str. The sections and figures of the article.
    statement : str. The statement in our words.
    tolerance : str. The condition for "reproduced" and for "partly", in words.
    judge : function from the cases of a reading to a finding.
    level : bool. True if it is judged with 10 lg and with 20 lg. Default: False.
    varied : str or None. The field of Case that a sweep must vary for it. Default: None, for the
        study of roughness and load.
    caution : str. Further numbers that limit the verdict. Default: empty.
    """

    key: str
    where: str
    statement: str
    tolerance: str
    judge: Callable[[Cases], Finding]
    level: bool = False
    varied: str | None = None
    caution: str = ""


_WHOLE = "A-weighted level of the whole sound: LAeq, or 20 lg of the weighted fluctuation."
# docs/accuracy.md says how the numbers in these cautions were measured.
PLASTIC_CAUTION = (
    "Under the exponential law the grid decides it, since many yielding places at Ra 0.1 µm are"
    " smaller than 2 µm. From 2 to 1 µm the plastic area in hardness-3y-exponential grows by 10, 7"
    " and 5 % at Ra 0.1 µm (5, 20, 100 N), and by 0.9, 0.6 and 0.3 % at Ra 1 µm. As stated it"
    " changes by 0.3 % at most."
)
TWIN_CAUTION = (
    "The uncertainty holds for two independent records; it is an upper bound, since both roll over"
    " the same surface. Purely elastic contact at Ra 5 µm is far beyond half-space theory and was"
    " not run."
)
RECORD_CAUTION = (
    "A line of noise falls by 5 dB (10 lg of an amplitude) as the record becomes ten times as long;"
    " the article gives no length. The verdict names, for each roughness, the length at which it"
    " would turn."
)
LEVEL_CAUTION = (
    "From 2 to 1 µm the level of the release changes by 0.1 dB (10 lg) at most up to Ra 1 µm, and"
    " as stated at Ra 5 µm by +0.2, +0.1 and -0.2 dB (5, 20, 100 N), over 60 to 120 steps. At Ra"
    " 5 µm and 20 N the lines from 700 to 2800 Hz fall by 1.1 dB, elsewhere they change by 0.3 dB"
    " at most."
)
_UP = (
    "Every step up by more than twice its standard error over the surfaces, "
    "with one surface by more than 0"
)

CLAIMS = (
    Claim(
        "pressure-below-limit",
        "section 3, Fig. 5a",
        "On the smoothest surface (Ra 0.01 µm) pressure stays below the 2.1 GPa at which the plate"
        " yields, even at 100 N.",
        "Maximum pressure of all surfaces below 2.1 GPa at each load; partly: at some loads.",
        partial(bounds.below_limit, roughness=SMOOTH, limit=LIMIT),
    ),
    Claim(
        "pressure-load",
        "section 3, Fig. 5a",
        "At Ra 0.01 µm the contact pressure grows with the load.",
        f"{_UP}; partly: some steps.",
        partial(trends.rises_with_load, measure=PRESSURE, roughnesses=(SMOOTH,)),
    ),
    Claim(
        "contact-area-load",
        "section 3, Fig. 5a",
        "At Ra 0.01 µm the contact area grows with the load.",
        f"{_UP}; partly: some steps.",
        partial(trends.rises_with_load, measure=CONTACT_AREA, roughnesses=(SMOOTH,)),
    ),
    Claim(
        "plastic-none",
        "section 3, Fig. 7",
        "At Ra 0.01 µm nothing yields at any load.",
        f"Plastic area below {NO_AREA:g} of the Hertz area at each load, "
        "less than a mark in the figure; partly: some loads.",
        partial(bounds.no_plastic_area, roughness=SMOOTH),
    ),
    Claim(
        "hardness-reached",
        "section 3, Fig. 5b to d",
        "From Ra 0.1 µm on, the maximum pressure is the pressure at which the plate yields.",
        "Some plastic area on every surface at each load, at any cap of the pressure; partly: "
        "some of them.",
        partial(bounds.hardness_reached, roughnesses=YIELDING),
    ),
    Claim(
        "plastic-area-load",
        "section 3, Fig. 5",
        "From Ra 0.1 µm on, a higher load makes the plastic area larger.",
        f"{_UP}, on each roughness; partly: some roughnesses.",
        partial(trends.rises_with_load, measure=PLASTIC_AREA, roughnesses=YIELDING),
    ),
    Claim(
        "plastic-area-roughness",
        "section 3, Fig. 5",
        "The rougher the surface, the larger the plastic area.",
        f"{_UP}, at each load; partly: some steps of roughness.",
        partial(trends.along_roughness, measure=PLASTIC_AREA, roughnesses=ROUGHNESSES),
    ),
    Claim(
        "plastic-ratio-load",
        "section 3, Fig. 7",
        "From Ra 0.1 µm on, the plastic area grows faster with the load than the Hertz area does.",
        f"{_UP}, on each roughness; partly: some roughnesses.",
        partial(trends.rises_with_load, measure=PLASTIC_RATIO, roughnesses=YIELDING),
    ),
    Claim(
        "plastic-ratio-1-over-0.1",
        "section 3, Fig. 7; conclusions",
        "At any load the plastic area at Ra 1 µm is about one and a half times the area at Ra 0.1 "
        "µm.",
        "Ratio of the means 1.3 to 1.7 at each load; partly: at some loads. "
        "Undecided where a fine grid may turn it.",
        partial(
            bounds.ratio_at_each_load,
            measure=PLASTIC_RATIO,
            over=ROUGH,
            under=MIDDLE,
            low=1.3,
            high=1.7,
        ),
        caution=PLASTIC_CAUTION,
    ),
    Claim(
        "plastic-ratio-5-like-1",
        "section 3, Fig. 7; conclusions",
        "The plastic area at Ra 5 µm is about as large as at Ra 1 µm.",
        "Ratio of the means 0.85 to 1.15 at each load; partly: at some loads.",
        partial(
            bounds.ratio_at_each_load,
            measure=PLASTIC_RATIO,
            over=ROUGHEST,
            under=ROUGH,
            low=0.85,
            high=1.15,
        ),
    ),
    Claim(
        "deflection-roughest",
        "section 3, Fig. 6",
        "The roughest plate (Ra 5 µm) is deflected least.",
        "Mean over the track of the maximum deflection lower than on each other roughness by more"
        " than twice the standard error, with one surface by more than 0, at each load; partly: at"
        " some loads.",
        partial(trends.lowest_of_all, measure=DEFLECTION, roughness=ROUGHEST),
    ),
    Claim(
        "deflection-roughness",
        "section 3, Fig. 6",
        "The rougher the surface, the less the plate is deflected.",
        "Mean over the track of the maximum deflection: every step of roughness down by more than"
        " twice its standard error over the surfaces, with one surface by more than 0, at each"
        " load; partly: some steps of roughness.",
        partial(trends.along_roughness, measure=DEFLECTION, roughnesses=ROUGHNESSES, rises=False),
    ),
    Claim(
        "yielding-deflection",
        "section 3, Fig. 6",
        "A plate that yields is deflected less than an elastic plate.",
        "Mean over the track of the maximum deflection below the one of the same scene without"
        " hardness, at Ra 0.1 and 1 µm, at 5, 20 and 100 N; partly: some of them.",
        partial(twins.less, measure=DEFLECTION),
    ),
    Claim(
        "yielding-noise",
        "abstract",
        "The change from elastic to plastic deformation alters the noise considerably.",
        "Against the same scene without hardness, at Ra 0.1 and 1 µm, at 5, 20 and 100 N:"
        " A-weighted level of the whole sound, or a third of the third octaves from the lowest that"
        " the record resolves up to 4 kHz, off by more than twice the uncertainty of the"
        " difference; partly: some of them.",
        twins.influences,
        level=True,
        caution=TWIN_CAUTION,
    ),
    Claim(
        "level-roughness",
        "abstract; section 3, Fig. 8",
        "Within hearing, a rougher surface is louder.",
        f"{_WHOLE} {_UP}, at each load; partly: some steps of roughness.",
        partial(trends.along_roughness, measure=AUDIBLE, roughnesses=ROUGHNESSES),
        level=True,
        caution=LEVEL_CAUTION,
    ),
    Claim(
        "level-load",
        "abstract; section 3, Fig. 8; conclusions",
        "Within hearing, a higher load is louder.",
        f"{_WHOLE} {_UP}, on each roughness; partly: some roughnesses.",
        partial(trends.rises_with_load, measure=AUDIBLE, roughnesses=ROUGHNESSES),
        level=True,
    ),
    Claim(
        "level-above-70",
        "abstract; section 3, Fig. 8; conclusions",
        "From Ra 0.1 µm on, levels pass the 70 dB of a squeal.",
        "Maximum line level above 70 dB at some load (the article does not say at which) on each "
        "roughness; partly: some"
        f" roughnesses. Undecided where a record up to {LENGTHS:g} times as long or as short "
        "would turn it.",
        partial(bounds.exceeds, measure=MAXIMUM, roughnesses=YIELDING, least_db=SQUEAL_DB),
        level=True,
        caution=RECORD_CAUTION,
    ),
    Claim(
        "high-frequency-gap",
        "section 3, Fig. 8a",
        "At Ra 0.01 µm the high-frequency spectra at 50 N and more lie far above the spectra at "
        "20 N and less.",
        f"Mean height of the curve above {HIGH_HZ / 1000:g} kHz: from the highest to 20 N to the "
        "lowest from 50 N at least"
        f" {LARGE_GAP_DB:g} dB, and {LARGEST_STEP:g} times any other step between loads; partly: "
        "one of the two.",
        partial(bounds.stands_apart, measure=HIGH_BAND, roughness=SMOOTH, low=20.0, high=50.0),
        level=True,
    ),
    Claim(
        "maximum-over-smooth",
        "abstract; section 3, Fig. 9; conclusions",
        "From Ra 0.1 µm on, the maximum line level lies some 10 to 15 dB above the one at Ra 0.01 "
        "µm.",
        "Mean over the loads 8 to 17 dB on each roughness; partly: some roughnesses.",
        partial(
            bounds.gap_over,
            measure=MAXIMUM,
            smooth=SMOOTH,
            roughnesses=YIELDING,
            low_db=8.0,
            high_db=17.0,
        ),
        level=True,
        caution=LEVEL_CAUTION,
    ),
    Claim(
        "maximum-load",
        "section 3, Fig. 9",
        "From 5 to 100 N the maximum line level rises by some 14 dB, "
        "averaged over the four surfaces.",
        "Average 12 to 16 dB; partly: not the average, but some roughness.",
        partial(
            bounds.rise_over_loads,
            measure=MAXIMUM,
            lowest=LOADS[0],
            highest=LOADS[-1],
            low_db=12.0,
            high_db=16.0,
        ),
        level=True,
    ),
    Claim(
        "maximum-flattens",
        "section 3, Fig. 9",
        "Beyond 50 N the maximum line level rises little.",
        "Per doubling of the load at most half of the gain per doubling from 5 to 50 N, on each"
        " roughness; partly: some roughnesses.",
        partial(
            bounds.flattens,
            measure=MAXIMUM,
            lowest=LOADS[0],
            knee=50.0,
            highest=LOADS[-1],
            most=0.5,
        ),
        level=True,
    ),
    Claim(
        "loudest-20-50",
        "section 3, Fig. 9",
        "At 20 and at 50 N, Ra 1 µm is the loudest.",
        "Highest mean of the maximum line level at both loads; partly: at one load, or another's"
        " lead is within twice its standard error.",
        partial(trends.loudest, measure=MAXIMUM, roughness=ROUGH, loads=(20.0, 50.0)),
        level=True,
        caution=LEVEL_CAUTION,
    ),
    Claim(
        "loudest-100",
        "section 3, Fig. 9",
        "At 100 N, Ra 5 µm is the loudest.",
        "Highest mean of the maximum line level; partly: another's lead is within twice its "
        "standard error.",
        partial(trends.loudest, measure=MAXIMUM, roughness=ROUGHEST, loads=(100.0,)),
        level=True,
        caution=LEVEL_CAUTION,
    ),
    Claim(
        "little-influence",
        "section 3, Fig. 9",
        "From Ra 0.1 µm on, roughness hardly affects the maximum line level.",
        "At each load the three lie within 5 dB, the width of the article's own 10 to 15 dB; "
        "partly: at some loads.",
        partial(bounds.within, measure=MAXIMUM, roughnesses=YIELDING, most_db=5.0),
        level=True,
        caution=LEVEL_CAUTION,
    ),
)

_DOWN = (
    "Every step up of the length lowers it by more than twice the standard error, "
    "with one surface by more than 0"
)

OUTLOOK = (
    Claim(
        "yielding-louder",
        "section 3, outlook",
        "Energy that is released where the plate yields can make the sound louder.",
        "A-weighted level of the whole sound above its twin without hardness by more than twice the"
        " uncertainty of the difference, at Ra 0.1 and 1 µm, at 5, 20 and 100 N; partly: some of"
        " them.",
        twins.louder,
        level=True,
        caution=TWIN_CAUTION,
    ),
    Claim(
        "length-frequency",
        "section 3, outlook",
        "A short autocorrelation length makes for high-frequency noise, a long one for low.",
        f"Spectral centroid of the fluctuation. {_DOWN}; partly: some steps.",
        partial(trends.falls_along, measure=CENTROID, varied="correlation_um", unit=" µm"),
        varied="correlation_um",
    ),
    Claim(
        "length-level",
        "section 3, outlook",
        "A short autocorrelation length makes for intense noise, a long one for quiet.",
        f"{_WHOLE} {_DOWN}; partly: some steps.",
        partial(trends.falls_along, measure=AUDIBLE, varied="correlation_um", unit=" µm"),
        level=True,
        varied="correlation_um",
    ),
)
