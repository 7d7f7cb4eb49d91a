"""Channels of a run: signals of plate, ball and contact with their levels, files and numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from acoustics import wav
from acoustics.arrays import Array, short_repr
from acoustics.modulation import EnvelopeSpectrum, envelope_spectrum, loudest_octave
from acoustics.numbers import si
from acoustics.spectrum import Psd, welch
from acoustics.traps import ignoring_underflow
from acoustics.vibration_level import REFERENCES, VibrationLevels, vibration_levels
from rolling.in_si.physics_of_scene import bodies_of, transducers_of
from rolling.numbers.ball_numbers import ChannelNumbers
from rolling.numbers.file_facts import ChannelFile
from rolling.numbers.quantity import BandQuantity
from rolling.scene.scene import Scene
from rolling.sound.channel_signals import channel_signals
from rolling.sound.vibration_sound import Vibration

if TYPE_CHECKING:
    from rolling.results.solved_run import SolvedRun

POSITIVE = {
    "plate": "positive away from the ball, into the plate",
    "ball": "positive towards the plate",
    "contact": "positive as ball and plate press more than under the load",
}


@ignoring_underflow
@dataclass(frozen=True, eq=False)
class Channel:
    """Signal of plate, ball or contact that a run records beside its sound.

    Attributes
    ----------
    name : str
        Name of the channel, such as `plate acceleration at (30, 40) mm`.
    of : str
        plate, ball or contact.
    quantity : str
        acceleration, velocity, displacement, force or blocked_force.
    unit : str
        SI unit of the samples: m/s2, m/s, m or N.
    place_m : pair of float, m, or None
        Place on the plate, from the corner of a plate with edges, from the contact on an infinite
        one. None for ball and contact.
    samples : (samples,) array
        Fluctuation about the rest under the load, 17.8 Hz to 22.4 kHz, at the rate of the sound.
    closed : bool
        If true, the record repeats without a click; otherwise it is faded.
    highest_hz : float, Hz
        Highest frequency that the steps of the run resolve.
    note : str
        What the reader of its levels must know; empty if nothing.

    Examples
    --------
    >>> import rolling
    >>> words = ["dynamics={}", "sphere.density_kg_m3=7850", "plate.density_kg_m3=7850"]
    >>> words += ["plate.thickness_mm=10", "rolling.load_n=1", "rolling.duration_s=0.005"]
    >>> words += ["sound.channels=[{of: ball, quantity: acceleration}]"]
    >>> run = rolling.simulate(rolling.read_scene("quickstart", words), workers=1, progress=False)
    >>> channel = run.channels[0]
    >>> channel.name, channel.unit, len(channel.samples), channel.reference
    ('ball acceleration', 'm/s2', 240, 're 1e-6 m/s2')
    """

    name: str
    of: str
    quantity: str
    unit: str
    place_m: tuple[float, float] | None
    samples: Array
    closed: bool = True
    highest_hz: float = math.inf
    note: str = ""

    __repr__ = short_repr

    @property
    def sample_rate(self) -> int:
        """Sample rate [Hz], that of the sound."""
        return wav.SAMPLE_RATE_HZ

    @property
    def reference(self) -> str:
        """Reference of the levels in words, as in `re 1e-6 m/s2` (ISO 1683)."""
        return REFERENCES[self.quantity].words

    @cached_property
    def levels(self) -> VibrationLevels:
        """Level of the whole, third octaves and octaves [dB], rms and peak."""
        return vibration_levels(self.samples, self.sample_rate, self.quantity, self.highest_hz)

    @cached_property
    def density(self) -> Psd:
        """Narrow bands: the spectral density in lines 10 Hz apart, unit squared per Hz."""
        return welch(self.samples, self.sample_rate)

    @cached_property
    def envelope(self) -> EnvelopeSpectrum | None:
        """Spectrum of the envelope in the octave with the most power; None without motion."""
        if not np.any(self.samples):
            return None
        band = loudest_octave(self.samples, self.sample_rate)
        return envelope_spectrum(self.samples, self.sample_rate, band, self.closed)

    @property
    def numbers(self) -> ChannelNumbers:
        """Facts and levels of the channel."""
        levels = self.levels
        place_mm = None
        if self.place_m is not None:
            place_mm = tuple(round(1e3 * coordinate, 9) for coordinate in self.place_m)
        return ChannelNumbers(
            name=self.name,
            of=self.of,
            quantity=self.quantity,
            unit=self.unit,
            reference=self.reference,
            positive=POSITIVE[self.of],
            place_mm=place_mm,
            level_db=levels.level_db,
            rms=levels.rms,
            peak=levels.peak,
            third_octaves=BandQuantity.of(levels.third_octave_db, "dB"),
            octaves=BandQuantity.of(levels.octave_db, "dB"),
            note=self.note,
        )


def channel_line(numbers: ChannelNumbers) -> str:
    """Write name, level with its reference, rms and peak of a channel in a line."""
    if numbers.level_db is None:
        return f"{numbers.name}: nothing moves within hearing"
    line = (
        f"{numbers.name}: {numbers.level_db:.1f} dB {numbers.reference}"
        f" (rms {si(numbers.rms, numbers.unit)}, peak {si(numbers.peak, numbers.unit)})"
    )
    if numbers.note:
        line += f"; {numbers.note}"
    return line


def channels_of(scene: Scene, vibration: Vibration | None) -> tuple[Channel, ...]:
    """Return the channels that a scene asks for, in its order."""
    asked = scene.sound.channels
    if not asked or vibration is None:
        return ()
    transducers = transducers_of(scene)
    signals = channel_signals(bodies_of(scene), scene.travel, vibration, transducers)
    channels = []
    for channel, transducer, signal in zip(asked, transducers, signals, strict=True):
        made = Channel(
            name=channel.label,
            of=channel.of,
            quantity=channel.quantity,
            unit=REFERENCES[channel.quantity].unit,
            place_m=transducer.place_m,
            samples=signal.samples,
            closed=signal.closed,
            highest_hz=vibration.highest,
            note=signal.note,
        )
        channels.append(made)
    return tuple(channels)


# ---- files


def by_quantity(channels: tuple[Channel, ...]) -> dict[str, list[Channel]]:
    """Return channels by their quantity, in the order of the scene."""
    groups: dict[str, list[Channel]] = {}
    for channel in channels:
        groups.setdefault(channel.quantity, []).append(channel)
    return groups


def channel_wavs(run: SolvedRun, title: str) -> dict[str, bytes]:
    """Return a WAV for each quantity by its file name, whose channels have the order of the scene.

    Samples are 32-bit floats in the SI unit of the quantity: 1.0 is 1 m/s2, 1 m/s, 1 m or 1 N.
    """
    files = {}
    for quantity, channels in by_quantity(run.channels).items():
        samples = np.stack([channel.samples for channel in channels], axis=1)
        loops = all(channel.closed for channel in channels)
        comment = wav_facts(channels).meaning
        heading = f"{title}, {quantity.replace('_', ' ')} in {channels[0].unit}"
        content = samples[:, 0] if len(channels) == 1 else samples
        files[wav_name(quantity)] = wav.calibrated(content, comment, heading, loops)
    return files


def wav_name(quantity: str) -> str:
    """Return the file name of the WAV of a quantity."""
    return f"{quantity}.wav"


def wav_facts(channels: list[Channel]) -> ChannelFile:
    """Say what the samples of the WAV of a quantity are, channel by channel."""
    unit = channels[0].unit
    names = "; ".join(f"{number}: {channel.name}" for number, channel in enumerate(channels, 1))
    return ChannelFile(
        meaning=f"1.0 is 1 {unit}; channel {names}",
        unit=unit,
        unit_per_full_scale=1.0,
        channels=tuple(channel.name for channel in channels),
    )
