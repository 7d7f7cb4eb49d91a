"""Data classes of physics in SI from a scene: bodies, contact, listener and transducers."""

import math

import numpy as np

from acoustics.arrays import Array
from rolling.bearing.waves import response
from rolling.contact.smooth_contact import SmoothContact
from rolling.dynamics.ball_on_plate import BallOnPlate, PlateBody
from rolling.dynamics.ball_turn import BallTurn
from rolling.scene.scene import Scene
from rolling.scene.sections import Plate
from rolling.scene.transducers import SoundChannel
from rolling.sound.receivers import Listener, Transducer
from rolling.surface.ball_form import BallForm, form_heights

BRIDGED = 1.0  # wave number times half of the contact, from which on waves count as roughness

# ---- bodies


def smooth_contact_of(scene: Scene) -> SmoothContact:
    """Return the contact of sphere and plate where they are smooth."""
    return SmoothContact(
        load_n=scene.load,
        radius_m=scene.radius,
        radius_across_m=scene.radius_across,
        modulus_pa=scene.contact_modulus,
    )


def plate_of(plate: Plate) -> PlateBody:
    """Return the plate of a section as a body that vibrates."""
    sides_m = None
    if plate.edges_mm is not None:
        length_mm, width_mm = plate.edges_mm
        sides_m = (1e-3 * length_mm, 1e-3 * width_mm)
    return PlateBody(
        youngs_modulus_pa=plate.youngs_modulus_gpa * 1e9,
        poissons_ratio=plate.poissons_ratio,
        density_kg_m3=plate.density_kg_m3,
        thickness_m=1e-3 * (plate.thickness_mm or 0.0),
        loss_factor=plate.loss_factor,
        sides_m=sides_m,
        edges=plate.edge_pair,
        contact_ends_m=tuple((1e-3 * x, 1e-3 * y) for x, y in plate.contact_ends_mm.values()),
    )


def bodies_of(scene: Scene) -> BallOnPlate:
    """Return sphere and plate of a scene as bodies that vibrate."""
    return BallOnPlate(
        mass_kg=scene.mass,
        ball_density_kg_m3=scene.sphere.density_kg_m3,
        contact=smooth_contact_of(scene),
        plate=plate_of(scene.plate),
        contact_loss_factor=scene.plate.contact_loss_factor,
        drop_height_m=1e-3 * (scene.rolling.drop_mm or 0.0),
        is_smooth=scene.is_smooth,
    )


def circumference_of(scene: Scene) -> float | None:
    """Return the circumference [m] of a sphere with a surface, None for a smooth sphere."""
    if scene.sphere.surface is None:
        return None
    return 2 * math.pi * scene.radius


def turn_of(scene: Scene) -> BallTurn | None:
    """Return the turn of a sphere with a surface, with its waves; None for a smooth sphere."""
    surface = scene.sphere.surface
    length_m = circumference_of(scene)
    if surface is None or length_m is None:
        return None
    if not surface.has_form:
        return BallTurn(length_m=length_m)
    return BallTurn(length_m=length_m, form_m=_approach_of_form(scene, surface.form))


def _approach_of_form(scene: Scene, form: BallForm) -> Array:
    """Return the approach [m] that waves around a sphere add at the nodes of a turn.

    The turn begins at the start of the track. Waves so short that the contact bridges them count as
    roughness.
    """
    nodes = scene.track.turn_nodes
    waves = np.fft.rfft(form_heights(form, nodes))
    length, _ = smooth_contact_of(scene).semi_axes_m()
    phase = length / scene.radius * np.arange(len(waves), dtype=np.float64)
    approach = -np.fft.irfft(np.where(phase < BRIDGED, waves * response(phase), 0.0), nodes)
    return np.roll(approach, -round(scene.start / scene.spacing))


# ---- receivers


def listener_of(scene: Scene) -> Listener:
    """Return the listener of a scene, with its places beside a plate with edges."""
    places_m = scene.listeners if scene.plate.edges_mm is not None else []
    return Listener(
        distance_m=scene.sound.distance_m,
        places_m=tuple(places_m),
        hears_ball=scene.sound.ball,
        q=scene.sound.q,
        gain_pa_per_w_m2=scene.sound.gain_pa_per_w_m2,
    )


def transducers_of(scene: Scene) -> list[Transducer]:
    """Return the transducers of the channels that a scene asks for."""
    transducers = []
    for channel in scene.sound.channels or []:
        transducer = Transducer(
            of=channel.of,
            quantity=channel.quantity,
            place_m=_place_of_channel(scene, channel),
        )
        transducers.append(transducer)
    return transducers


def _place_of_channel(scene: Scene, channel: SoundChannel) -> tuple[float, float] | None:
    """Return the place of a channel [m] on the plate; None for ball and contact.

    It counts from the corner of a plate with edges, and from the contact on an infinite plate.
    """
    if channel.of != "plate":
        return None
    if channel.place_mm is not None:
        x_mm, y_mm = channel.place_mm
        return 1e-3 * x_mm, 1e-3 * y_mm
    if scene.plate.edges_mm is None:
        return 0.0, 0.0
    x_mm, y_mm = scene.plate.contact_ends_mm["contact_mm"]
    return 1e-3 * x_mm, 1e-3 * y_mm
