"""What a listener hears of a specimen: A-weighted energy of the vibration by third octave.

The energy is the mean over speeds within 3 %, so that a sharp resonance does not fall on a line of
the surface for one candidate and between two lines for the other. A contact whose scene states no
loss factor is heard at two.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from acoustics import wav
from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES, third_octave_mean_square
from acoustics.radiation import P_REF_PA
from acoustics.spectrum import audible_lines
from acoustics.weighting import a_weighting_db
from rolling.ball_kinds.ball_candidates import LOSS_KEY, of_ball
from rolling.choice.heard_specimen import (
    Heard,
    Specimen,
    damaged,
    levels_of,
    read_heard_file,
    write_heard_file,
)
from rolling.dynamics.force_law import ForceLaw
from rolling.dynamics.motion_of_ball import motion_of_ball
from rolling.in_si.physics_of_scene import bodies_of, listener_of
from rolling.marches import marched_law
from rolling.marches.result import Result
from rolling.numbers.ball_numbers import RunNumbers
from rolling.results.instrument_spread import part_of_instrument
from rolling.results.stored_numbers import read_stored
from rolling.scene import file
from rolling.scene.scene import Scene
from rolling.sound.radiators import known_bands
from rolling.sound.vibration_sound import radiated_by_motion

BAFFLE = "baffle"  # source of a part of the ± of a free plate
# Speeds over that of the scene. The lines of a lap move by more than their distance between them.
SPEED_RATIOS = (0.97, 0.985, 1.0, 1.015, 1.03)


# A-weighted mean square of -200 dB, below which a contact without waves has its rounding errors.
ROUNDING_PA2 = 1e-20 * P_REF_PA**2


class LevelError(NamedTuple):
    """Error of a level, the level less the true one, and its standard uncertainty [dB]."""

    db: float
    uncertainty_db: float


@dataclass(frozen=True, eq=False)
class HeardBall(Heard):
    """What a listener hears of one specimen of a candidate.

    loss_factors : tuple of float. Loss factors of the contact.
    squares : (losses,) array, Pa2. A-weighted mean square of the vibration, or its exposure in 1 s
        for a fall.
    bands : (losses, 31) array, Pa2. The same by third octave, NaN above the Nyquist frequency of
        the steps.
    released_power_db : float or None, dB(A). Level of the released power.
    errors : dict. Errors of the level that the run knows and does not correct, by their origin:
        grid and instrument.
    parts_db : dict, dB. Parts of the ± of the vibration of the run, by their source.
    baffle_db : (31,) array, dB. What the missing baffle of a free plate leaves on each third
        octave; None for other plates.
    """

    loss_factors: tuple[float, ...]
    squares: Array
    bands: Array
    released_power_db: float | None
    errors: dict[str, LevelError]
    parts_db: dict[str, float] = field(default_factory=dict)
    baffle_db: Array | None = None

    def rms(self, quantity: str) -> float:
        """Return the A-weighted root mean square of the vibration [Pa]."""
        return math.sqrt(float(self.squares.mean()))

    def level_db(self, quantity: str) -> float:
        """Return the mean level of the vibration over the loss factors, dB(A)."""
        return float(levels_of(self.squares).mean())

    def highest_level_db(self, quantity: str) -> float:
        """Return the level of the vibration at the louder of the loss factors, dB(A)."""
        return float(levels_of(self.squares).max())

    @property
    def third_octaves(self) -> Array:
        """A-weighted mean squares by third octave, as means over the loss factors, (31,) [Pa2]."""
        return np.asarray(self.bands.mean(axis=0))

    @property
    def released_level_db(self) -> float | None:
        """Level of the released power, dB(A)."""
        return self.released_power_db


@dataclass(frozen=True, kw_only=True)
class StoredHeard:
    """The same as heard.json has it; None for what is not known of a third octave."""

    loss_factors: tuple[float, ...]
    squares_pa2: tuple[float, ...]
    bands_pa2: tuple[tuple[float | None, ...], ...]
    released_power_db: float | None
    errors_db: dict[str, LevelError]
    parts_db: dict[str, float]
    baffle_db: tuple[float, ...] | None


def write_heard(specimen: Specimen, result: Result) -> None:
    """Write what is heard of a specimen whose run is done."""
    heard_ball = hear(specimen, result)
    stored = StoredHeard(
        loss_factors=heard_ball.loss_factors,
        squares_pa2=tuple(heard_ball.squares.tolist()),
        bands_pa2=tuple(_known(row) for row in heard_ball.bands),
        released_power_db=heard_ball.released_power_db,
        errors_db=heard_ball.errors,
        parts_db=heard_ball.parts_db,
        baffle_db=None if heard_ball.baffle_db is None else tuple(heard_ball.baffle_db.tolist()),
    )
    write_heard_file(specimen, stored)


def _known(values: Array) -> tuple[float | None, ...]:
    """Return numbers for JSON, None for those that are unknown."""
    return tuple(value if math.isfinite(value) else None for value in values.tolist())


def read_heard(specimen: Specimen) -> HeardBall:
    """Read what is heard of a specimen.

    Raises
    ------
    FolderError : the file is damaged, or was not written by this program.
    """
    stored = read_heard_file(specimen, StoredHeard)
    losses = len(loss_factors_of(specimen))
    try:
        heard_ball = HeardBall(
            loss_factors=stored.loss_factors,
            squares=np.array(stored.squares_pa2),
            bands=np.array(stored.bands_pa2, dtype=float),
            released_power_db=stored.released_power_db,
            errors=stored.errors_db,
            parts_db=stored.parts_db,
            baffle_db=None if stored.baffle_db is None else np.array(stored.baffle_db),
        )
        if heard_ball.baffle_db is not None and heard_ball.baffle_db.shape != (len(BAND_NAMES),):
            raise ValueError("bands of another shape")
        if heard_ball.bands.shape != (losses, len(BAND_NAMES)):
            raise ValueError("bands of another shape")
        if heard_ball.squares.shape != (losses,):
            raise ValueError("squares of another shape")
    except ValueError as error:
        raise damaged(specimen, error) from error
    return heard_ball


def loss_factors_of(specimen: Specimen) -> tuple[float, ...]:
    """Return the loss factors of the contact at which a specimen is heard."""
    return of_ball(specimen.candidate).loss_factors


def hear(specimen: Specimen, result: Result) -> HeardBall:
    """Return what a listener hears of a specimen whose run is done.

    Parameters
    ----------
    specimen : Specimen. The run of the specimen.
    result : Result. Its marches.
    """
    scene = specimen.scene
    loss_factors = loss_factors_of(specimen)
    law = marched_law.force_law(scene, result)
    squares = []
    bands = []
    for loss_factor in loss_factors:
        at_speeds = [
            _weighted_lines(_heard_scene(scene, loss_factor, ratio), law, result)
            for ratio in _speed_ratios(scene)
        ]
        square = float(np.mean([lines.total for lines in at_speeds]))
        sounds = square > ROUNDING_PA2
        squares.append(square if sounds else 0.0)
        bands.append(np.mean([lines.bands for lines in at_speeds], axis=0) * sounds)
    highest = scene.motion.fastest(scene.duration) / (2 * scene.step)
    if scene.is_one_event:  # its time steps resolve an impact
        highest = wav.SAMPLE_RATE_HZ / 2
    numbers = read_stored(specimen.folder).numbers
    of_bands = numbers.bands.vibration
    baffle_db = None if of_bands is None else of_bands.parts.get(BAFFLE)
    return HeardBall(
        loss_factors=loss_factors,
        squares=np.array(squares),
        bands=np.where(known_bands(highest), np.array(bands), np.nan),
        released_power_db=numbers.released_power.value,
        errors=_errors(numbers),
        parts_db=numbers.vibration.parts,
        baffle_db=None if baffle_db is None else np.array(baffle_db),
    )


def _errors(numbers: RunNumbers) -> dict[str, LevelError]:
    """Return the errors of the level of the vibration that a run knows."""
    errors = {}
    grid_db = numbers.errors.grid_db
    if grid_db is not None:
        errors["grid"] = LevelError(grid_db, numbers.errors.grid_uncertainty_db or 0.0)
    of_source = part_of_instrument(numbers.surface, "vibration")
    if of_source is None or of_source.error_db is None or of_source.spread_db is None:
        return errors
    # The spread holds the error itself.
    square = of_source.spread_db**2 - of_source.error_db**2
    errors["instrument"] = LevelError(of_source.error_db, math.sqrt(max(0.0, square)))
    return errors


def _speed_ratios(scene: Scene) -> tuple[float, ...]:
    """Return the speeds over that of the scene; a fall and a ball that rolls out have their own."""
    if scene.is_one_event or scene.rolling.resistance is not None:
        return (1.0,)
    return SPEED_RATIOS


def _heard_scene(scene: Scene, loss_factor: float, speed_ratio: float) -> Scene:
    """Return the scene of a solved contact with another loss factor, at another speed."""
    changes = [f"{LOSS_KEY}={loss_factor!r}"]
    if speed_ratio != 1.0:
        speed = scene.rolling.speed_m_s
        faster: Any = []
        if isinstance(speed, float):
            faster = speed * speed_ratio
        else:
            faster = [[time / speed_ratio, value * speed_ratio] for time, value in speed]
        changes.append(f"rolling.speed_m_s={faster!r}")
    return file.resound(scene, changes)


class _Lines(NamedTuple):
    """A-weighted mean square of a record, and its third octaves [Pa2]."""

    total: float
    bands: Array


def _weighted_lines(scene: Scene, law: ForceLaw, result: Result) -> _Lines:
    """Return the A-weighted mean square of the vibration of a scene over a force law."""
    bodies = bodies_of(scene)
    motion = motion_of_ball(bodies, scene.travel, law)
    is_whole_laps = scene.track.closed and result.steps % result.solved_steps == 0
    constant = scene.motion.is_constant(scene.duration)
    closed = bool(is_whole_laps and constant and motion.settled)
    _, pressures = radiated_by_motion(
        bodies, listener_of(scene), scene.motion, motion, closed, count=1
    )
    frequency, square = audible_lines(pressures[0], wav.SAMPLE_RATE_HZ)
    weighted = square * 10.0 ** (a_weighting_db(frequency) / 10.0)
    if scene.is_one_event:  # the exposure in one second, as LAE
        weighted = weighted * (len(pressures[0]) / wav.SAMPLE_RATE_HZ)
    return _Lines(
        total=float(weighted.sum()),
        bands=third_octave_mean_square(frequency, weighted),
    )
