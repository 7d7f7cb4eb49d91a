"""Listener and transducers of a scene in SI, which sound takes in place of the scene."""

from rolling.scene.channels import SoundChannel
from rolling.scene.scene import Scene
from rolling.sound.channel_signals import Transducer
from rolling.sound.listener import Listener


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
