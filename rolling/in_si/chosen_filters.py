"""Filters of a measurement, decided from its heights and its instrument, and its lay in words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from acoustics.arrays import Array
from acoustics.numbers import rounded
from rolling.contact.track import MIN_NODES
from rolling.scene.surfaces import Instrument
from rolling.surface.gaussian_filter import FAR, smoothed
from rolling.surface.instrument import InstrumentSight, faded, sight
from rolling.surface.markers import Nodes
from rolling.surface.parameters import parameters
from rolling.surface.profile_parameters import CLASSES

# Share of heights beyond three robust standard deviations from which on pits or scratches pull the
# Gaussian filter. Gaussian heights have 0.27 %, those of an exponential law 4.4 %, and a tenth of
# the area in pits nearly 10 %.
PITTED = 0.02
SQUARE = 1e-3  # relative difference of spacings up to which the spectrum is taken
LAID = 0.5  # Str below which a surface has a lay
UPRIGHT_DEG = 5.0  # up to which a lay lies along an axis
_LEAST_WAVE = 2.01  # spacings, above which a file holds waves that an instrument may not see


@dataclass(frozen=True, kw_only=True)
class StatedLimits:
    """What a person states of a measurement.

    instrument : Instrument or None. Its limits; None where they are not stated.
    l_filter_um : float or None, um. Nesting index of the L-filter; None for no such filter.
    """

    instrument: Instrument | None
    l_filter_um: float | None


@dataclass(frozen=True)
class ChosenFilters:
    """Keys of the section `surface` that filter a measurement, and the reasons by step."""

    keys: dict[str, Any]
    reasons: dict[str, str]


def chosen_filters(
    heights: Array, steps: Sequence[float], limits: StatedLimits, measured: Nodes
) -> ChosenFilters:
    """Choose the S-filter and the kind of the L-filter of heights [m] without form.

    The S-filter takes what the instrument does not see, where the file holds such waves. The
    L-filter is only taken if a nesting index is given, because the ball rolls over long waves, too.
    Its kind follows from the measured nodes, as filled ones are smooth.
    """
    s_filter_um, of_short = _s_filter(heights, steps, limits.instrument)
    keys: dict[str, Any] = {}
    if s_filter_um is not None:
        keys["s_filter_um"] = s_filter_um
    index_um = limits.l_filter_um
    if index_um is None:
        usual = usual_index(heights)
        of_long = (
            "the ball rolls over long waves, too; --l-filter-um takes one (of this Ra, ISO 21920-3"
            f" has {1e3 * usual:g} mm)"
        )
        return ChosenFilters(keys=keys, reasons={"s_filter": of_short, "l_filter": of_long})
    share = far_share(heights, steps, 1e-6 * index_um, measured)
    keys["l_filter_um"] = index_um
    words = (
        f"{rounded(100 * share, 2)} % of the heights lie beyond three robust standard deviations"
    )
    of_long = f"{words}, too few to pull the linear filter"
    if share > PITTED:
        keys["l_filter"] = "robust"
        of_long = f"{words}, and such pits or scratches do not pull the robust filter"
    return ChosenFilters(keys=keys, reasons={"s_filter": of_short, "l_filter": of_long})


def usual_index(heights: Array) -> float:
    """Return the nesting index [m] that ISO 21920-3 has for the Ra of heights."""
    ra = float(np.mean(np.abs(heights - heights.mean())))
    return next(usual.index_m for usual in CLASSES if ra <= usual.up_to_ra_m)


def far_share(heights: Array, steps: Sequence[float], index_m: float, measured: Nodes) -> float:
    """Return the share of measured heights three robust standard deviations off the long waves."""
    distance = np.abs(heights - smoothed(heights, steps, index_m, wraps=False))[measured]
    far = FAR * float(np.median(distance))
    return float(np.mean(distance > far)) if far > 0 else 0.0


def _s_filter(
    heights: Array, steps: Sequence[float], instrument: Instrument | None
) -> tuple[float | None, str]:
    """Return the nesting index [um] of the S-filter, None without one, and the reason."""
    along, across = steps
    coarsest = along if heights.shape[1] == 1 else max(along, across)
    shortest = f"the nodes hold no waves below {1e6 * 2 * coarsest:.4g} um"
    if instrument is None:
        return None, f"{shortest}, and no instrument is stated"
    seen = sight_of(heights, steps, instrument)
    if seen is not None:
        if seen.noise_share >= 1:
            return None, "the noise is as large as the heights, which a filter cannot tell from it"
        cutoff = seen.cutoff
        words = seen.limit_words
    elif instrument.sampling_um is not None:
        cutoff = 2e-6 * instrument.sampling_um
        words = "two sampling intervals"
    else:
        return None, f"{shortest}, and nodes that are not square show no limit of the instrument"
    if cutoff <= _LEAST_WAVE * coarsest:
        return None, f"{shortest}, and the instrument sees all others"
    index_um = rounded_up_um(cutoff)
    if index_um > 1e6 * _shorter_side(heights, steps):
        return None, f"the instrument shows no waves below {index_um:g} um, longer than the scan"
    return index_um, f"the instrument shows no waves below {index_um:g} um ({words})"


def _shorter_side(heights: Array, steps: Sequence[float]) -> float:
    """Return the length [m] of the shorter side of heights, that of a profile."""
    sides = [count * step for count, step in zip(heights.shape, steps, strict=True) if count > 1]
    return float(min(sides))


def sight_of(
    heights: Array, steps: Sequence[float], instrument: Instrument | None
) -> InstrumentSight | None:
    """Return what an instrument sees of heights with ends; None where no spectrum tells it.

    Nodes that are not square are resampled by a run, and the spectrum is not taken before.
    """
    along, across = steps
    is_square = heights.shape[1] == 1 or abs(across / along - 1) < SQUARE
    if len(heights) < MIN_NODES or not is_square:
        return None
    limits = None if instrument is None else instrument.in_si
    return sight(faded(heights), float(along), limits)


def sight_words(heights: Array, steps: Sequence[float], instrument: Instrument | None) -> str:
    """Write what an instrument sees of measured heights; empty where there is nothing to say.

    Without an instrument only noise is told that stands out of the spectrum.
    """
    seen = sight_of(heights, steps, instrument)
    if seen is None or (instrument is None and not seen.noise):
        return ""
    return f"The measuring instrument sees {seen.words}."


def rounded_up_um(length: float) -> float:
    """Return a length [m] in um with two digits, rounded up."""
    exponent = math.floor(math.log10(length * 1e6)) - 1
    return float(f"{math.ceil(length * 1e6 / 10.0**exponent - 1e-9) * 10.0**exponent:.6g}")


def direction_words(heights: Array, steps: Sequence[float], axis: str) -> str:
    """Say how the track lies to the lay, along an axis of the file."""
    values = parameters(heights, steps)
    track = f"the track runs along {axis} of the file"
    ratio = values["Str"]
    if not ratio < LAID:
        shape = "" if math.isnan(ratio) else f" (Str {rounded(ratio, 2)})"
        return f"{track}, and there is no lay{shape} that asks for another one"
    angle = abs(values["Std"])
    evidence = f"Str {rounded(ratio, 2)}, lay at {rounded(angle, 2)} degrees to the track"
    if angle >= 90 - UPRIGHT_DEG:
        return f"{track}, across the lay, as a ball meets it as roughness ({evidence})"
    if angle <= UPRIGHT_DEG:
        return f"{track}, which is along the lay; --along turns it ({evidence})"
    return f"{track}, oblique to the lay ({evidence})"
