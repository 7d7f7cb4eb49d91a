"""What a listener hears of a specimen: A-weighted energy of the vibration by third octave.

The energy is the mean over speeds within 3 %, so that a sharp resonance does not fall on a line of
the surface for one candidate and between two lines for the other. A contact whose scene states no
loss factor is heard at two.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from acoustics import wav
from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES, third_octave_mean_square
from acoustics.spectrum import audible_lines
from acoustics.weighting import a_weighting_db
from rolling.choice.candidates import LOSS_KEY
from rolling.dynamics import of_scene
from rolling.dynamics.force_law import ForceLaw
from rolling.marches import force_law
from rolling.marches.piece import contact_identity
from rolling.marches.result import Result
from rolling.results import answer
from rolling.results.run_folder import FAILED, MAX_FAILURE, SUMMARY, RunFolder, read_summary
from rolling.run.worker import finish_run
from rolling.scene import file
from rolling.scene.height_files import read_regular
from rolling.scene.scene import Scene
from rolling.sound.radiators import baffle_bands_db, known_bands
from rolling.sound.vibration_sound import radiated_by_motion
from rolling.terminal.files import FolderError, write_json

HEARD = "heard.json"
# Speeds over that of the scene. The lines of a lap move by more than their distance between them.
SPEED_RATIOS = (0.97, 0.985, 1.0, 1.015, 1.03)
_MAX_BYTES = 1_000_000


class LevelError(NamedTuple):
    """Error of a level, the level less the true one, and its standard uncertainty [dB]."""

    db: float
    uncertainty_db: float


@dataclass(frozen=True, eq=False)
class Heard:
    """What a listener hears of one specimen of a candidate.

    loss_factors : tuple of float. Loss factors of the contact.
    squares : (losses,) array, Pa2. A-weighted mean square of the vibration, or its exposure in 1 s
        for a fall.
    bands : (losses, 31) array, Pa2. The same by third octave, NaN above the Nyquist frequency of
        the steps.
    released_power_db : float or None, dB(A). Level of the released power.
    errors : dict. Errors of the level that the run knows and does not correct, by their origin:
        grid and instrument.
    baffle_db : (31,) array, dB. What the missing baffle of a free plate leaves on each third
        octave; None for other plates.
    """

    loss_factors: tuple[float, ...]
    squares: Array
    bands: Array
    released_power_db: float | None
    errors: dict[str, LevelError]
    baffle_db: Array | None = None


@dataclass(frozen=True, eq=False)
class Specimen(RunFolder):
    """A specimen of a candidate: a run, and the loss factors at which it is heard."""

    loss_factors: tuple[float, ...]

    @property
    def is_heard(self) -> bool:
        """Whether the run is done and what is heard of it is stored."""
        return self.is_done and (self.folder / HEARD).is_file()

    @property
    def no_solution(self) -> str:
        """Why the contact of the specimen has no solution; empty unless that is remembered."""
        try:
            stored = json.loads(read_regular(self.folder / FAILED, MAX_FAILURE))
            reason = str(stored["reason"])
            identity = stored["contact"]
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            return ""
        return reason if identity == contact_identity(self.scene) else ""


def finish_specimen(run: RunFolder, label: str, result: Result) -> None:
    """Write the files of a specimen as those of any run, and then what is heard of it."""
    assert isinstance(run, Specimen)
    finish_run(run, label, result)
    write_heard(run, result)


def write_heard(specimen: Specimen, result: Result) -> None:
    """Write what is heard of a specimen whose run is done."""
    heard = hear(specimen, result)
    content: dict[str, Any] = {
        "loss_factors": list(heard.loss_factors),
        "squares_pa2": heard.squares.tolist(),
        "bands_pa2": [_json_numbers(row) for row in heard.bands],
        "released_power_db": heard.released_power_db,
        "errors_db": heard.errors,
        "baffle_db": None if heard.baffle_db is None else heard.baffle_db.tolist(),
    }
    write_json(specimen.folder / HEARD, content)


def _json_numbers(values: Array) -> list[float | None]:
    """Return numbers for JSON, None for those that are unknown."""
    return [value if math.isfinite(value) else None for value in values.tolist()]


def read_heard(specimen: Specimen) -> Heard:
    """Read what is heard of a specimen.

    Raises
    ------
    FolderError : the file is damaged, or was not written by this program.
    """
    path = specimen.folder / HEARD
    try:
        stored = json.loads(read_regular(path, _MAX_BYTES))
        baffle_db = stored.get("baffle_db")
        heard = Heard(
            loss_factors=tuple(map(float, stored["loss_factors"])),
            squares=np.array(stored["squares_pa2"], dtype=float),
            bands=np.array(stored["bands_pa2"], dtype=float),
            released_power_db=stored["released_power_db"],
            errors={
                name: LevelError(float(db), float(uncertainty_db))
                for name, (db, uncertainty_db) in stored["errors_db"].items()
            },
            baffle_db=None if baffle_db is None else np.array(baffle_db, dtype=float),
        )
        if heard.baffle_db is not None and heard.baffle_db.shape != (len(BAND_NAMES),):
            raise ValueError("bands of another shape")
        if heard.bands.shape != (len(specimen.loss_factors), len(BAND_NAMES)):
            raise ValueError("bands of another shape")
        if heard.squares.shape != (len(specimen.loss_factors),):
            raise ValueError("squares of another shape")
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise FolderError(
            f"{path}: not readable ({error}); delete it, and the same command makes it again"
        ) from error
    return heard


def hear(specimen: Specimen, result: Result) -> Heard:
    """Return what a listener hears of a specimen whose run is done.

    Parameters
    ----------
    specimen : Specimen. The run of the specimen.
    result : Result. Its marches.
    """
    scene = specimen.scene
    law = force_law.force_law(scene, result)
    squares = []
    bands = []
    for loss_factor in specimen.loss_factors:
        at_speeds = [
            _weighted_lines(_heard_scene(scene, loss_factor, ratio), law, result)
            for ratio in _speed_ratios(scene)
        ]
        squares.append(np.mean([lines.total for lines in at_speeds]))
        bands.append(np.mean([lines.bands for lines in at_speeds], axis=0))
    highest = scene.motion.fastest(scene.duration) / (2 * scene.step)
    if scene.rolling.drop_mm is not None:  # its time steps resolve an impact
        highest = wav.SAMPLE_RATE_HZ / 2
    summary = read_summary(specimen.folder / SUMMARY)
    return Heard(
        loss_factors=specimen.loss_factors,
        squares=np.array(squares),
        bands=np.where(known_bands(highest), np.array(bands), np.nan),
        released_power_db=answer.released_power(summary).level_db,
        errors=_errors(summary),
        baffle_db=baffle_bands_db(scene),
    )


def _errors(summary: Mapping[str, Any]) -> dict[str, LevelError]:
    """Return the errors of the level of a run that its summary knows."""
    errors = {}
    grid = summary.get("laeq_grid_error_db")
    if grid is not None:
        uncertainty = summary.get("laeq_grid_error_uncertainty_db") or 0.0
        errors["grid"] = LevelError(grid, uncertainty)
    instrument = summary.get("instrument", {})
    error = instrument.get("vibration_error_db")
    if error is not None:
        spread = instrument["vibration_spread_db"]  # holds the error itself
        uncertainty = math.sqrt(max(0.0, spread**2 - error**2))
        errors["instrument"] = LevelError(error, uncertainty)
    return errors


def _speed_ratios(scene: Scene) -> tuple[float, ...]:
    """Return the speeds over that of the scene; a fall and a ball that rolls out have their own."""
    if scene.rolling.drop_mm is not None or scene.rolling.resistance is not None:
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
    motion = of_scene.motion(scene, law)
    is_whole_laps = scene.track.closed and result.steps % result.solved_steps == 0
    constant = scene.motion.is_constant(scene.duration)
    closed = bool(is_whole_laps and constant and motion.settled)
    _, pressures = radiated_by_motion(scene, motion, closed, listeners=1)
    frequency, square = audible_lines(pressures[0], wav.SAMPLE_RATE_HZ)
    weighted = square * 10.0 ** (a_weighting_db(frequency) / 10.0)
    if scene.rolling.drop_mm is not None:  # the exposure in one second, as LAE
        weighted = weighted * (len(pressures[0]) / wav.SAMPLE_RATE_HZ)
    return _Lines(
        total=float(weighted.sum()),
        bands=third_octave_mean_square(frequency, weighted),
    )
