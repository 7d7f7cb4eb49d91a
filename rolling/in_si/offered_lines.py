"""Lines of a scene that make a surface like a measured one, and the bodies that roll on it."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any, NamedTuple

from acoustics.numbers import rounded
from rolling.contact.closed_forms import contact_modulus
from rolling.contact.track import MIN_NODES
from rolling.scene import library
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.scene.surfaces import Gaussian
from rolling.surface.character import Character, Pair, lengths_text
from rolling.surface.heights import SurfaceError, turned_reach
from rolling.surface.lay import EQUAL, Ellipse
from rolling.surface.parameters import DECAY

MATERIAL = "steel-100cr6"  # of ball and plate, where a file or an elastic plate names none
_SKEWED = 0.2  # skewness from which heights are not made Gaussian
_PEAKED = 0.5  # the same of the kurtosis about 3
PROFILE_NODES = 128  # width of a surface that is made after a profile
HOLDS = 2.5  # lengths across that the width of a made surface holds, so that it has them


def pair_of_steel() -> Pair:
    """Return a ball and a plate of bearing steel."""
    steel = library.named_values("plate", MATERIAL)
    young = 1e9 * steel["youngs_modulus_gpa"]
    poisson = steel["poissons_ratio"]
    modulus = contact_modulus(young, poisson, young, poisson)
    return Pair(modulus, 1e9 * steel["hardness_gpa"], f"a ball and a plate of {MATERIAL}")


def pair_of_scene(scene: Scene) -> Pair:
    """Return ball and plate of a scene; an elastic plate has the hardness of its material here."""
    if math.isfinite(scene.hardness):
        return Pair(scene.contact_modulus, scene.hardness, "ball and plate of the scene")
    material = scene.plate.material or MATERIAL
    hardness = library.named_values("plate", material).get("hardness_gpa")
    if not isinstance(hardness, float):
        material = MATERIAL
        hardness = library.named_values("plate", material)["hardness_gpa"]
    words = f"ball and plate of the scene, which is elastic, with the hardness of {material}"
    return Pair(scene.contact_modulus, 1e9 * hardness, words)


class Offer(NamedTuple):
    """A line of a scene and the sentence before it, which says why if there is no line."""

    sentence: str
    line: str = ""


def line(keys: Mapping[str, Any]) -> str:
    """Write the section `surface` of a scene on one line of YAML."""
    return f"surface: {{{_flow(keys)}}}"


def offer_of_statistics(numbers: Character, spacing: float, width: float) -> Offer | None:
    """Write the section `surface` of a random surface with the numbers of a surface, on one line.

    A smooth surface has no such line.

    Parameters
    ----------
    numbers : Character
        Numbers of the surface.
    spacing : float, m
        Spacing of its nodes, the finer one of two.
    width : float, m
        Its width; 0 of a profile.
    """
    if numbers.rq == 0:
        return None
    lay = _lay_of_law(numbers)
    if lay is None:
        return Offer(
            "No random surface is like it in a scene, because its autocorrelation falls to 1/e"
            f" {lengths_text(numbers)}."
        )
    sentence = "In a scene, this makes a random surface of this Ra, Sal and Str"
    if lay.is_continued:
        sentence += (
            "; the longer one continues the decay up to half the surface, at most to its whole side"
        )
    elif not width:
        sentence += "; a profile has no length across the track, so it is as along"
    moments = {}
    if abs(numbers.skewness) > _SKEWED or abs(numbers.kurtosis - 3) > _PEAKED:
        moments["skewness"] = float(rounded(numbers.skewness, 2))
        moments["kurtosis"] = float(rounded(numbers.kurtosis, 3))
    keys = _law_keys(numbers, lay)
    grid = _grid_keys(lay, spacing, width)
    reason = ""
    # No made surface has some moments.
    for made in ({**keys, **moments, **grid}, {**keys, **grid}):
        try:
            law = Gaussian(**made)
            if law.in_si.angle_rad:
                turned_reach(law.in_si, spacing)
        except (SceneError, SurfaceError) as error:
            reason = str(error)
            continue
        return Offer(f"{sentence}:", line(made))
    return Offer(f"No random surface is like it in a scene: {reason}")


def _lay_of_law(numbers: Character) -> Ellipse | None:
    """Return the 1/e lengths of the law whose autocorrelation falls to 0.2 as that of a surface.

    So the random surface has its Sal and Str. Of a surface that falls to 1/e and not to 0.2 along
    any axis these are its own 1/e lengths.
    """
    decay = numbers.decay
    if decay is None:
        return numbers.ellipse
    ratio = -math.log(DECAY) if numbers.is_exponential else math.sqrt(-math.log(DECAY))
    first = decay.first / ratio
    second = decay.second / ratio
    if max(first, second) < EQUAL * min(first, second):
        first = second = math.sqrt(first * second)
        return Ellipse(first, second, is_continued=decay.is_continued)
    return decay._replace(first=first, second=second)


def _law_keys(numbers: Character, lay: Ellipse) -> dict[str, Any]:
    """Return the keys of a random surface that say its roughness and its autocorrelation."""
    keys: dict[str, Any] = {"kind": "gaussian"}
    if numbers.is_exponential:
        keys["autocorrelation"] = "exponential"
    keys["roughness_ra_um"] = float(rounded(1e6 * numbers.ra, 4))
    first = float(rounded(1e6 * lay.first, 3))
    second = float(rounded(1e6 * lay.second, 3))
    keys["correlation_length_um"] = first
    if second != first:
        keys["correlation_length_across_um"] = second
    if lay.angle_deg:
        keys["lay_deg"] = lay.angle_deg
    return keys


def _grid_keys(lay: Ellipse, spacing: float, width: float) -> dict[str, Any]:
    """Return the grid of a random surface, wide enough for its length across, and its seed."""
    spacing_um = float(rounded(1e6 * spacing, 6))
    nodes = PROFILE_NODES if not width else max(MIN_NODES, round(1e6 * width / spacing_um))
    nodes = max(nodes, math.ceil(HOLDS * 1e6 * lay.across / spacing_um))
    width_um = float(f"{spacing_um * nodes:.10g}")
    return {"spacing_um": spacing_um, "width_um": width_um, "seed": 1}


_PLAIN = re.compile("[a-z][a-z_-]*")  # texts that YAML takes for texts, but for its own words
_YAML_WORDS = ("true", "false", "null", "yes", "no", "on", "off")


def _flow(keys: Mapping[str, Any]) -> str:
    """Write keys and values as YAML on one line, texts that need it in quotes."""
    return ", ".join(f"{name}: {_scalar(value)}" for name, value in keys.items())


def _scalar(value: Any) -> str:
    """Write a value as YAML, a section in braces."""
    if isinstance(value, Mapping):
        return f"{{{_flow(value)}}}"
    if isinstance(value, float):
        return f"{value:g}" if float(f"{value:g}") == value else repr(value)
    if isinstance(value, str) and (not _PLAIN.fullmatch(value) or value in _YAML_WORDS):
        doubled = value.replace("'", "''")
        return f"'{doubled}'"
    return str(value)
