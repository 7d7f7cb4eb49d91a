"""Waves around the bodies of a bearing: those of its scene, and those that files hold."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from rolling.bearing.assumed_surfaces import (
    AMPLITUDE_DB,
    FORM_DB,
    LENGTH,
    LENGTH_ACROSS,
    RA,
    ROUGHNESS_OFF,
    AssumedRoughness,
    AssumedSurface,
    AssumedWaves,
    RoughnessLaw,
    exponent_db,
)
from rolling.scene.bearing_scene import BearingScene
from rolling.scene.bearing_sources import USUAL_EXPONENT, assumed_of_surface
from rolling.scene.raceways import BearingSurface, Raceway
from rolling.scene.roundness_files import Waves, read_waves
from rolling.scene.surfaces import GradedBall
from rolling.surface.ball_form import BallForm, random_amplitudes

ORDERS = 4096  # of random waves that are looked at, more than a contact follows
POINTS_PER_WAVE = 8  # at least, so that a wave of a high order is not taken for one of a low order


def form_of(surface: BearingSurface, folder: Path, draw: int = 0) -> BallForm:
    """Return the waves around a body.

    Parameters
    ----------
    surface : section
        Surface of the body.
    folder : Path
        Folder from which paths of files start.
    draw : int
        Number of a specimen: others than 0 have other random waves around a raceway. Those of a
        ball follow from its seed.
    """
    form = surface.form
    if form.law is None:
        return form
    measured = measured_waves(surface, folder)
    law = form.law
    if measured:
        law = replace(law, first=measured[-1][0] + 1)
    if draw:
        law = replace(law, seed=(*law.seed, draw))
    return replace(form, law=law, measured_m=measured)


def isotropic_exponent(surface: BearingSurface) -> float | None:
    """Return the exponent of random waves that are isotropic; None where crests lie across."""
    if getattr(surface, "wave_crests", None) != "isotropic":
        return None
    exponent: float | None = getattr(surface, "wave_exponent", None)
    return exponent


def without_law(form: BallForm) -> BallForm:
    """Return the waves around a body without those that a law draws beyond known ones."""
    return replace(form, law=None, exponent=None)


def random_waves(scene: BearingScene) -> list[AssumedWaves]:
    """Return the random waves around balls and raceways, with what is assumed of them.

    A grade limits the form of balls only, and a finish by name gives a law that is assumed.
    """
    waves = []
    for body in ("balls", "inner", "outer"):
        surface = getattr(scene.bearing.surfaces, body)
        if surface is None or not surface.has_form:
            continue
        keys = assumed_of_surface(scene, body)
        is_graded = isinstance(surface, GradedBall)
        amplitude_db = AMPLITUDE_DB if "wave_amplitude_um" in keys else 0.0
        if is_graded:
            amplitude_db = FORM_DB
        is_assumed = is_graded or "wave_exponent" in keys
        assumed = AssumedWaves(
            body=body,
            amplitudes_m=random_amplitudes(form_of(surface, scene.folder), ORDERS),
            exponent=getattr(surface, "wave_exponent", None) or USUAL_EXPONENT,
            isotropic=isotropic_exponent(surface) is not None,
            amplitude_db=amplitude_db,
            exponent_db=exponent_db(ORDERS) if is_assumed else np.zeros(ORDERS),
        )
        waves.append(assumed)
    return waves


def assumed_waves(scene: BearingScene) -> list[AssumedWaves]:
    """Return the random waves around balls and raceways that rest on an assumption."""
    return [waves for waves in random_waves(scene) if not waves.is_stated]


# Keys of the roughness of a raceway that a finish may assume, by what they are in linear theory.
ROUGHNESS_KEYS = {
    RA: "roughness_ra_um",
    LENGTH: "correlation_length_um",
    LENGTH_ACROSS: "correlation_length_across_um",
}


def assumed_roughness(scene: BearingScene) -> list[AssumedRoughness]:
    """Return the roughness of raceways of which a finish by name assumes something."""
    assumed = []
    for body in ("inner", "outer"):
        surface = getattr(scene.bearing.surfaces, body)
        keys = assumed_of_surface(scene, body)
        names = [name for name, key in ROUGHNESS_KEYS.items() if key in keys]
        if not isinstance(surface, Raceway) or not names:
            continue
        others = {}
        for name in names:
            key = ROUGHNESS_KEYS[name]
            value = getattr(surface, key)
            ends = [value / ROUGHNESS_OFF, value * ROUGHNESS_OFF]
            if name == LENGTH_ACROSS:
                # A longer one would be filtered out by the stylus that reads Ra.
                ends[1] = min(ends[1], surface.longest_across_um)
            low, high = (_law_of(surface.model_dump() | {key: end}) for end in ends)
            others[name] = low, high
        assumed.append(AssumedRoughness(body, _law_of(surface.model_dump()), others))
    return assumed


def _law_of(values: dict[str, object]) -> RoughnessLaw:
    """Return the roughness of a raceway with some values, as linear theory takes it."""
    law = Raceway.model_validate(values).law
    along_um, across_um = law.lengths_um
    return RoughnessLaw(rq_m=law.rq_m, along_m=1e-6 * along_um, across_m=1e-6 * across_um)


def assumed_surfaces(scene: BearingScene) -> list[AssumedSurface]:
    """Return waves of bodies and roughness of raceways that rest on an assumption."""
    return [*assumed_waves(scene), *assumed_roughness(scene)]


def measured_waves(surface: BearingSurface, folder: Path) -> Waves:
    """Return the waves around a raceway that were measured; none without a file of roundness."""
    if not isinstance(surface, Raceway) or surface.roundness is None:
        return ()
    return read_waves(folder / surface.roundness.path, surface.roundness.height_unit)


def points_of_waves(surface: BearingSurface, folder: Path) -> int:
    """Return the points of a turn that hold the waves of known orders around a body.

    The random waves of a law have no highest order: they go as far as the points of a track.
    """
    orders = list(surface.waviness or {})
    orders += [order for order, _, _ in measured_waves(surface, folder)[-1:]]
    return POINTS_PER_WAVE * max(orders, default=0)
