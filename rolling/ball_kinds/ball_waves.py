"""Linear response of the level of a ball to the waves of its plate, by third octave.

The contact answers a small change of the surface by the mean of this change under the pressures of
a small further load. Sphere, contact and plate then move as a linear chain.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from acoustics.arrays import Array
from rolling.ball_kinds.ball_heard import loss_factors_of
from rolling.ball_kinds.chain import stiffness_along, with_loss
from rolling.choice.heard_specimen import Specimen
from rolling.choice.wave_bands import PlateBands, PlateWaves
from rolling.contact.load_shares import approach_of_part, load_shares
from rolling.contact.subcells import half_space_of
from rolling.in_si.contact_of_scene import rolling_contact
from rolling.in_si.physics_of_scene import bodies_of, listener_of
from rolling.in_si.scene_surface import waves_of_plate
from rolling.kinds.run_folder import RESULT
from rolling.results import result_file
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.scene.surfaces import WavySurface
from rolling.sound.wave_response import shares_of_parts
from rolling.surface.lowered_waves import bands_of_track
from rolling.surface.refined import subcell_heights
from rolling.terminal import progress

SPECIMENS = 8  # whose mean response is taken, at most
POSITIONS = 2000  # of the stretch of a track whose response is computed


def plate_waves(scene: Scene) -> PlateWaves:
    """Return the waves of the plate of a scene.

    Raises
    ------
    SceneError : the level does not follow from them.
    """
    _refuse_without_waves(scene)
    ball = scene.sphere.surface
    return PlateWaves(
        has_other_sources=ball is not None or bool(scene.surface.faults),
        bands=wave_bands,
    )


def _refuse_without_waves(scene: Scene) -> None:
    """Refuse a scene whose level does not follow from the waves of its plate."""
    place = scene.place("surface")
    if not scene.keeps_its_load:
        raise SceneError(
            [
                f"{scene.place('rolling.drop_mm')}: rolling.drop_mm: the sphere falls, and an"
                " impact is no linear response to waves; allowed: a sphere that rolls"
            ]
        )
    if not isinstance(scene.surface, WavySurface):
        raise SceneError(
            [
                f"{place}: surface: {scene.name} has a plate without waves, so no vibration"
                " follows from them; allowed: a random surface or heights from a file"
            ]
        )


def wave_bands(specimens: Sequence[Specimen], correlation: Array | None) -> PlateBands:
    """Return the waves of the first specimens, and what each band does to their level.

    Parameters
    ----------
    specimens : sequence of Specimen
        Solved specimens.
    correlation : (specimens, specimens) array or None
        Correlation of places of a scan; None where each specimen has a surface of its own.

    Raises
    ------
    SceneError : nothing is heard of a specimen.
    ContactError : a contact has no solution.
    """
    scene = specimens[0].scene
    track = scene.track
    bands = bands_of_track(track.n_along * track.spacing, track.spacing)
    responses = []
    squares = []
    for number, specimen in enumerate(specimens[:SPECIMENS], start=1):
        with progress.step(f"response of the contact to waves, specimen {number}"):
            responses.append(_responses(specimen, bands))
        parts = waves_of_plate(specimen.scene, bands)
        squares.append([float(np.mean(np.square(part))) for part in parts])
    count = len(responses)
    return PlateBands(
        wavelength_m=bands,
        rms_m=np.sqrt(np.mean(squares, axis=0)),
        responses=np.array(responses),
        correlation=None if correlation is None else correlation[:count, :count],
    )


def _responses(specimen: Specimen, bands: Array) -> Array:
    """Return the fall of the level of a specimen per decibel of each band [dB/dB]."""
    scene = specimen.scene
    result = result_file.read_result(specimen.folder / RESULT, scene)
    approach = result.series["approach"]
    is_whole_lap = scene.track.closed and result.solved_steps <= POSITIONS
    closed = is_whole_lap and scene.motion.is_constant(scene.duration)
    if not is_whole_lap:
        approach = approach[: POSITIONS + 1]
    contact = rolling_contact(scene)
    half_space = half_space_of(contact.spacing, contact.contact_modulus, contact.subcells)
    shares = load_shares(contact, half_space, len(approach) - 1)
    parts = []
    for wave in waves_of_plate(scene, bands):
        on_nodes = wave
        if contact.subcells > 1:
            on_nodes = subcell_heights(wave, contact.subcells, contact.slopes)
        parts.append(approach_of_part(on_nodes, shares))
    stiffness = float(1 / np.mean(1 / stiffness_along(scene, result)))
    of_losses = []
    for loss_factor in loss_factors_of(specimen):
        damped = with_loss(scene, loss_factor)
        bodies = bodies_of(damped)
        share = shares_of_parts(
            bodies,
            listener_of(damped),
            bodies.chain(stiffness),
            damped.motion,
            approach,
            parts,
            result.step,
            closed,
        )
        if share is None:
            raise SceneError([f"{scene.name}: makes no sound within hearing"])
        of_losses.append(share)
    return np.asarray(np.mean(of_losses, axis=0))
