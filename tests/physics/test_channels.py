"""Channels of plate, ball and contact against a modal equation of motion and closed forms."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.signal import cont2discrete, lfilter

import rolling
from acoustics import vibration_levels
from acoustics.arrays import Array
from acoustics.radiation import ThinPlate
from acoustics.resampling import band_limit, resample_closed
from rolling.in_si.physics_of_scene import bodies_of, plate_of, transducers_of
from rolling.sound.channel_signals import channel_signals, transfer_mobility

RATE = 48000
STEEL = ["dynamics={}", "sphere.density_kg_m3=7850", "plate.density_kg_m3=7850"]
SHORT = [*STEEL, "rolling.load_n=1", "rolling.duration_s=0.02", "plate.loss_factor=0.03"]
EDGED = [*SHORT, "plate.thickness_mm=4", "plate.length_mm=200", "plate.width_mm=150"]
CONTACT = 0.43 * 0.2, 0.37 * 0.15  # [m] of EDGED
MOTIONS = ("acceleration", "velocity", "displacement")


def run_of(words: list[str], *channels: str) -> rolling.Run:
    """Return the run of the quickstart with some keys and channels."""
    listed = f"sound.channels=[{', '.join(channels)}]"
    scene = rolling.read_scene("quickstart", [*words, listed])
    return rolling.simulate(scene, workers=1, progress=False)


def third_octaves(samples: Array) -> Array:
    """Return the third octaves [dB] of an acceleration or force from 1 to 16 kHz."""
    levels = vibration_levels(samples, RATE, "acceleration").third_octave_db
    names = [*levels]
    return np.array([levels[name] for name in names[names.index("1000") : names.index("20000")]])


class Moved(NamedTuple):
    """A motion with a given force, as the channels read it."""

    force_n: Array
    time_step_s: float = 1 / RATE
    flight_share: float = 0.0
    settled: bool = True


class Vibrating(NamedTuple):
    """A vibration with a given force, as the channels read it."""

    motion: Moved
    force: Array
    closed: bool = True


def edged_signals(*places: tuple[float, float]) -> tuple[Array, list[Array], rolling.Scene]:
    """Return a random force [N], and the motions of a plate with edges at places [m]."""
    listed = []
    for x, y in places:
        place = f"x_mm: {1e3 * x:.9g}, y_mm: {1e3 * y:.9g}"
        listed += [f"{{of: plate, quantity: {name}, {place}}}" for name in MOTIONS]
    scene = rolling.read_scene("quickstart", [*EDGED, f"sound.channels=[{', '.join(listed)}]"])
    force = band_limit(np.random.default_rng(1).standard_normal(960), RATE)
    vibration: Any = Vibrating(Moved(force + scene.load), force)
    transducers = transducers_of(scene)
    signals = channel_signals(bodies_of(scene), scene.travel, vibration, transducers)
    return force, [signal.samples for signal in signals], scene


def modal_acceleration(force: Array, scene: rolling.Scene, place: tuple[float, float]) -> Array:
    """Step the modal equations of motion of an own plate, with all its modes up to 180 kHz.

    The force is linear between samples of 16 times the rate. It repeats lap by lap, until the
    modes do.
    """
    fine = 16
    laps = np.tile(resample_closed(force, fine * len(force)), 6)
    mass = 7850 * 4e-3 * 0.2 * 0.15 / 4
    ratio = np.sqrt(210e9 * 4e-3**2 / (12 * (1 - 0.3**2) * 7850))
    plate = plate_of(scene.plate).with_edges
    assert plate is not None
    radiating = dict(zip(plate.angular_frequency.round(3), plate.loss_factors, strict=True))
    total = np.zeros(fine * len(force))
    for m in range(1, 50):
        for n in range(1, 50):
            waves = np.pi * np.array([m / 0.2, n / 0.15])
            w = ratio * float(waves @ waves)
            if w > 2 * np.pi * 180e3:
                continue
            shapes = np.prod(np.sin(waves * CONTACT)) * np.prod(np.sin(waves * place))
            loss = radiating.get(round(w, 3), 0.03)
            system = ([1 / mass, 0, 0], [1, loss * w, w * w])
            rise, fall, _ = cont2discrete(system, 1 / (RATE * fine), method="foh")
            response = lfilter(rise.ravel(), fall, laps)
            total += shapes * response[-len(total) :]
    return band_limit(resample_closed(total, len(force)), RATE)


@pytest.mark.law("Channels: modal equations of motion give the acceleration of a plate with edges.")
def test_modal_equations() -> None:
    places = ((0.03, 0.02), (0.15, 0.11), CONTACT)
    force, signals, scene = edged_signals(*places)
    # At the contact the level between two resonances depends on the modes next above 30 kHz,
    # which the remainder takes as evenly spread.
    for place, acceleration, most in zip(places, signals[::3], (0.2, 0.2, 0.3), strict=True):
        own = modal_acceleration(force, scene, place)
        assert third_octaves(acceleration) == pytest.approx(third_octaves(own), abs=most)


@pytest.mark.law("Channels: acceleration and velocity are derivatives of the displacement.")
def test_derivatives() -> None:
    _, (acceleration, velocity, displacement), _ = edged_signals((0.03, 0.02))
    iw = 2j * np.pi * np.fft.rfftfreq(len(velocity), 1 / RATE)
    for rate, moved in ((velocity, displacement), (acceleration, velocity)):
        derived = np.fft.irfft(iw * np.fft.rfft(moved), len(moved))
        assert derived == pytest.approx(rate, abs=1e-9 * np.abs(rate).max())


@pytest.mark.slow
@pytest.mark.law("Channels: an infinite plate moves with Y F at the contact, and a ball with -F/M.")
def test_infinite_plate_and_ball() -> None:
    run = run_of(
        [*SHORT, "plate.thickness_mm=10"],
        "{of: plate, quantity: velocity, x_mm: 0, y_mm: 0}",
        "{of: ball, quantity: acceleration}",
        "{of: contact, quantity: force}",
        "{of: contact, quantity: blocked_force}",
    )
    velocity, acceleration, force, _ = (channel.samples for channel in run.channels)
    assert "contact_loss_factor" in run.channels[-1].note  # nothing else damps the ball
    mobility = 1 / (8 * np.sqrt(210e9 * 0.01**3 / (12 * 0.91) * 78.5))
    assert velocity == pytest.approx(mobility * force, abs=1e-9 * np.abs(velocity).max())
    mass = 7850 * 4 / 3 * np.pi * 0.005**3
    assert acceleration == pytest.approx(-force / mass, abs=1e-9 * np.abs(acceleration).max())


@pytest.mark.law("Channels: the transfer mobility of an infinite plate is its integral over waves.")
def test_transfer_mobility() -> None:
    # With the loss factor 0.05 the Hankel integral over wave numbers converges without a pole.
    plate = ThinPlate(78.5, 18.9e3, 0.05)
    from scipy.special import j0

    w = 2 * np.pi * 2000
    k = np.linspace(0, 4000, 4_000_001)
    lossy = 18.9e3 * (1 + 0.05j)
    integrand = 1j * w / (2 * np.pi) * j0(0.08 * k) * k / (lossy * k**4 - 78.5 * w**2)
    expected = np.trapezoid(integrand, k)
    got = transfer_mobility(plate, np.array([2000 + 0j]), 0.08)[0]
    assert got == pytest.approx(expected, rel=0.03)  # Y itself has the loss factor in it
    near = transfer_mobility(plate, np.array([2000 + 0j]), 1e-9)[0]
    assert near == pytest.approx(plate.mobility_s_kg, rel=1e-6)


@pytest.mark.slow
@pytest.mark.law("Channels: the blocked force of a heavy plate is the contact force.")
def test_blocked_force_of_a_heavy_plate() -> None:
    heavy = [*SHORT, "plate.thickness_mm=400", "plate.contact_loss_factor=0.02"]
    run = run_of(heavy, "{of: contact, quantity: force}", "{of: contact, quantity: blocked_force}")
    force, blocked = run.channels
    assert not blocked.note
    assert third_octaves(blocked.samples) == pytest.approx(third_octaves(force.samples), abs=0.1)
