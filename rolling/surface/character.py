"""The few numbers by which finishes are compared, in sentences.

They are roughness, the 1/e lengths of the autocorrelation, the rms slope and the plasticity index.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array
from acoustics.numbers import rounded
from rolling.surface.lay import E_FOLD, EQUAL, LAY, Ellipse, ellipse
from rolling.surface.parameters import DECAY, about_mean, autocorrelation, roughness

# Mikic's limits of E' tan(theta)/H are 1/3 and 3 with the mean absolute slope of a profile. On
# isotropic Gaussian heights it is 1/sqrt(pi) of the rms slope of the surface.
ELASTIC_BELOW = math.sqrt(math.pi) / 3
PLASTIC_ABOVE = math.sqrt(math.pi) * 3
# Lag of a decay to 0.2 over that to 1/e: 1.27 of a Gaussian autocorrelation, 1.61 of an exponential
# one. Between them lies the geometric mean.
_EXPONENTIAL_ABOVE = 1.43


class Character(NamedTuple):
    """Numbers of a surface.

    ra, rq : float, m. Arithmetic mean and root mean square of the heights.
    skewness, kurtosis : float. Moments of the heights.
    along, across : float, m. Lag at which the autocorrelation falls to 1/e; NaN where it does not
        up to half the surface, or where the surface is a profile.
    is_exponential : bool. Whether the autocorrelation is nearer to exp(-r/L) than to exp(-(r/L)^2).
    rms_slope : float. Root mean square gradient Sdq, of neighbouring nodes.
    ellipse : Ellipse or None. Lags at which the autocorrelation falls to 1/e in the directions of
        the lay; of a profile both are the one along. None where it falls along no axis.
    decay : Ellipse or None. The same of the decay to 0.2, by which ISO 25178-2 has Sal and Str.
    """

    ra: float
    rq: float
    skewness: float
    kurtosis: float
    along: float
    across: float
    is_exponential: bool
    rms_slope: float
    ellipse: Ellipse | None
    decay: Ellipse | None


class Pair(NamedTuple):
    """Ball and plate, by which the plasticity index is reckoned.

    modulus : float, Pa. Contact modulus E'.
    hardness : float, Pa. Hardness H of the plate.
    words : str. Origin of both numbers.
    """

    modulus: float
    hardness: float
    words: str


def character(heights: Array, steps: Array, wrap: bool) -> Character:
    """Compute the numbers of heights [m] with spacings [m] along and across."""
    values = roughness(heights, steps, wrap)
    z = about_mean(heights)
    lengths = [math.nan, math.nan]
    decays = [math.nan, math.nan]
    share = None
    if values["Sq"] > 0:
        share = autocorrelation(z, wrap)
        middle = np.array(share.shape) // 2
        curves = share[middle[0] :, middle[1]], share[middle[0], middle[1] :]
        for axis, curve in enumerate(curves):
            lengths[axis] = _lag(curve, E_FOLD) * steps[axis]
            decays[axis] = _lag(curve, DECAY) * steps[axis]
    pairs = zip(decays, lengths, strict=True)
    known = [decay / length for decay, length in pairs if math.isfinite(decay)]
    is_exponential = bool(known) and float(np.mean(known)) > _EXPONENTIAL_ABOVE
    of_lay = None
    of_decay = None
    exponent = 1 if is_exponential else 2
    if share is not None and 1 not in heights.shape:
        of_lay = ellipse(share, lengths, steps, wrap, exponent)
        # A weak lay between the axes has equal lengths along both.
        of_decay = ellipse(share, decays, steps, wrap, exponent, DECAY, EQUAL)
    elif math.isfinite(lengths[0]):
        of_lay = Ellipse(lengths[0], lengths[0])
        if math.isfinite(decays[0]):
            of_decay = Ellipse(decays[0], decays[0])
    return Character(
        ra=values["Sa"],
        rq=values["Sq"],
        skewness=values["Ssk"],
        kurtosis=values["Sku"],
        along=lengths[0],
        across=lengths[1],
        is_exponential=is_exponential,
        rms_slope=values["Sdq"],
        ellipse=of_lay,
        decay=of_decay,
    )


def _lag(curve: Array, level: float) -> float:
    """Return the lag [nodes] at which a curve first falls to a level; NaN where it does not."""
    below = np.flatnonzero(curve <= level)
    if not below.size:
        return math.nan
    k = int(below[0])
    return float(k - 1 + (curve[k - 1] - level) / (curve[k - 1] - curve[k]))


# ---- plasticity index


def plasticity_index(rms_slope: float, modulus: float, hardness: float) -> float:
    """Return E' s/H of an rms slope s, a contact modulus E' and a hardness H [Pa].

    It is the inverse of Mikic's ratio H/(E' tan(theta)), with the rms slope in place of the mean
    absolute slope tan(theta) of a profile (B. B. Mikic, Int. J. Heat Mass Transfer 17 (1974) 205,
    as usually quoted). It needs no load: it tells whether asperities yield at their first touch.
    """
    return rms_slope * modulus / hardness


# ---- sentences


def sentences(numbers: Character, pair: Pair) -> list[str]:
    """Write the numbers of a surface in sentences, one for each comparison of finishes."""
    if numbers.rq == 0:
        return ["The surface is smooth."]
    index = plasticity_index(numbers.rms_slope, pair.modulus, pair.hardness)
    if index < ELASTIC_BELOW:
        outcome = "its asperities stay elastic"
    elif index < PLASTIC_ABOVE:
        outcome = "a part of its asperities yields"
    else:
        outcome = "its asperities yield"
    return [
        f"Roughness: Ra {_um(numbers.ra)} and Rq {_um(numbers.rq)}.",
        f"The autocorrelation falls to 1/e {lengths_text(numbers)}.{_lay_words(numbers.ellipse)}",
        f"The rms slope is {rounded(numbers.rms_slope, 3)} between neighbouring nodes.",
        f"Mikic's plasticity index E' s/H is {rounded(index, 2)}: {outcome}. The rms slope is s; E'"
        f" {rounded(1e-9 * pair.modulus, 3)} GPa and H {rounded(1e-9 * pair.hardness, 3)} GPa are"
        f" those of {pair.words}.",
        "The index ranks finishes of one spacing on one material, also those that never yield:"
        f" elastic below {ELASTIC_BELOW:.1f}, plastic above {PLASTIC_ABOVE:.0f} (Mikic 1974).",
    ]


def _um(length: float) -> str:
    """Write a length in um."""
    return f"{rounded(1e6 * length, 3)} um"


def lengths_text(numbers: Character) -> str:
    """Write where the autocorrelation falls along and across the track."""
    ends = {"along": numbers.along, "across": numbers.across}
    known = {name: length for name, length in ends.items() if math.isfinite(length)}
    if not known:
        return "nowhere up to half the surface"
    if len(known) == len(ends):
        return f"after {_um(numbers.along)} along the track and {_um(numbers.across)} across it"
    ((name, length),) = known.items()
    (other,) = ends.keys() - known.keys()
    return f"after {_um(length)} {name} the track, and not {other} it up to half the surface"


def _lay_words(lay: Ellipse | None) -> str:
    """Say how a lay is turned; empty where it is not."""
    if lay is None or not lay.angle_deg:
        return ""
    along_lay = f"{_um(lay.second)} along it"
    if lay.is_continued:
        along_lay = "farther than half the surface along it"
    return (
        f" The lay is turned: the autocorrelation falls after {_um(lay.first)} at"
        f" {lay.angle_deg:.0f} degrees from the track, square to the lay, and {along_lay}."
    )


def lies_along(numbers: Character) -> bool:
    """Tell whether the lay of a surface runs along the track."""
    lay = numbers.ellipse
    return lay is not None and not lay.angle_deg and lay.first > LAY * lay.second
