"""Files of a bearing run: result.h5, summary.json, tables, sounds and figures of a run folder."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import h5py
import numpy as np

from acoustics import resampling, wav
from acoustics.arrays import Array
from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from acoustics.texts import printable
from rolling.bearing.band_uncertainty import stored_uncertainty
from rolling.bearing.ring_record import DIRECTIONS, RingRecord
from rolling.bearing.tracks import BearingTracks, BodyTrack
from rolling.bearing_run import figures
from rolling.bearing_run.without_faults import stored_without_faults
from rolling.contact.processor_time import ProcessorTime
from rolling.figures.picture import csv_bytes
from rolling.figures.settings import left_out_if_it_fails
from rolling.marches import effort
from rolling.results import result_file
from rolling.results.run_folder import MAX_SUMMARY, RESULT, SUMMARY
from rolling.results.summary import program_provenance
from rolling.scene.height_files import read_regular
from rolling.terminal import files, progress
from rolling.terminal.files import FolderError

if TYPE_CHECKING:
    import xarray

    from rolling.bearing_run.bearing_run import BearingRun

FORMAT = 1  # of result.h5
SPECTRUM = "spectrum.csv"
LINES = "lines.csv"
ACCELERATION = "acceleration.wav"
LISTEN = "listen.wav"
HOUSING = "housing.wav"
FIGURES = "figures"
_NEEDED = {
    "bands_um_s": dict,
    "bands_uncertainty_db": dict,
    "lines": list,
    "doubts": list,
    "contact_doubts": list,
    "sentences": list,
    "listen": dict,
}
_TITLE_LETTERS = 400
FADE_S = 0.05  # at the ends of a sound
_MOST_BYTES = 4_000_000_000  # of a result
_MIN_COMPRESSED = 10_000  # bytes of an array


class _Variable(NamedTuple):
    """An array of result.h5: its dimensions, unit and meaning."""

    dimensions: tuple[str, ...]
    unit: str
    long_name: str


_VARIABLES = {
    "velocity": _Variable(("time", "axis"), "m/s", "velocity of the ring along x, y and z"),
    "acceleration": _Variable(("time", "axis"), "m/s2", "acceleration of the ring"),
    "ball_load": _Variable(("time", "ball"), "N", "load of each ball"),
    "track_loads": _Variable(("load",), "N", "loads at which the tracks are known"),
    "inner_track": _Variable(
        ("load", "inner_place"), "m", "change of the approach around the inner raceway"
    ),
    "outer_track": _Variable(
        ("load", "outer_place"), "m", "change of the approach around the outer raceway"
    ),
    "balls_on_inner": _Variable(
        ("ball", "load", "ball_place"), "m", "change around each ball on the inner raceway"
    ),
    "balls_on_outer": _Variable(
        ("ball", "load", "ball_place"), "m", "change around each ball on the outer raceway"
    ),
}
_FACTS = ("energy_error", "lost_contact_share", "rate_hz", "cage_hz")


# ---- result.h5


def _arrays(run: BearingRun) -> dict[str, Array]:
    """Return the arrays of a run by their names."""
    tracks = run.tracks
    every = (tracks.inner, tracks.outer, *tracks.balls_on_inner, *tracks.balls_on_outer)
    loads = every[0].loads_n
    for track in every:
        loads = np.union1d(loads, track.loads_n)
    places = max(track.points for track in every[2:])

    def of_balls(balls: tuple[BodyTrack, ...]) -> Array:
        """Return the tracks of balls at the same loads and places, (balls, loads, places)."""
        return np.stack([track.resampled(places).at_loads(loads) for track in balls])

    return {
        "velocity": run.record.velocity_m_s,
        "acceleration": run.record.acceleration_m_s2,
        "ball_load": run.record.ball_load_n,
        "track_loads": loads,
        "inner_track": tracks.inner.at_loads(loads),
        "outer_track": tracks.outer.at_loads(loads),
        "balls_on_inner": of_balls(tracks.balls_on_inner),
        "balls_on_outer": of_balls(tracks.balls_on_outer),
    }


def result_dataset(run: BearingRun) -> xarray.Dataset:
    """Return the arrays of a run with dimensions and units, and its facts as attributes."""
    import xarray  # slow to import

    variables = {}
    for name, values in _arrays(run).items():
        definition = _VARIABLES[name]
        attributes = {"units": definition.unit, "long_name": definition.long_name}
        stored = values.astype("f4")
        encoding: dict[str, Any] = {"_FillValue": None}
        if stored.nbytes >= _MIN_COMPRESSED:
            encoding |= {"zlib": True, "complevel": 1, "shuffle": True}
        variables[name] = xarray.Variable(definition.dimensions, stored, attributes, encoding)
    facts = {name: float(getattr(run.record, name)) for name in _FACTS}
    return xarray.Dataset(variables, attrs={"format": FORMAT, "kind": "bearing", **facts})


def result_bytes(run: BearingRun) -> bytes:
    """Return the bytes of result.h5, which are equal for equal runs."""
    content = bytes(result_dataset(run).to_netcdf(engine="h5netcdf"))
    return content + result_file.seal(content)


def read_result(path: Path, balls: int) -> tuple[RingRecord, BearingTracks]:
    """Read the record of a ring and the tracks of its bearing.

    Raises
    ------
    FolderError : the file is missing or damaged, or holds no bearing with so many balls.
    """
    content = result_file.sealed_content(path, _MOST_BYTES)
    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            return _read(path, file, balls)
    except FolderError:
        raise
    except Exception as error:  # h5py raises errors of any kind on hostile files
        text = " ".join(str(error).split()) or type(error).__name__
        raise FolderError(f"{path}: not a bearing's result of this program ({text})") from error


def _read(path: Path, file: h5py.File, balls: int) -> tuple[RingRecord, BearingTracks]:
    """Read an open file whose digest holds."""
    attributes = {}
    for name in ("format", "kind", *_FACTS):
        attributes[name] = np.asarray(file.attrs[name]).item()
    if attributes["format"] != FORMAT or attributes["kind"] != "bearing":
        raise FolderError(f"{path}: no bearing's result of format {FORMAT}")
    arrays = {name: np.asarray(file[name][()], dtype=float) for name in _VARIABLES}
    shapes = {"axis": 3, "ball": balls}
    for name, values in arrays.items():
        for dimension, length in zip(_VARIABLES[name].dimensions, values.shape, strict=True):
            if shapes.setdefault(dimension, length) != length:
                raise ValueError(f"{name}: got {length} along {dimension}")
        if not np.isfinite(values).all():
            raise ValueError(f"{name}: values that are no finite numbers")
    facts = {name: float(attributes[name]) for name in _FACTS}
    record = RingRecord(
        velocity_m_s=arrays["velocity"],
        acceleration_m_s2=arrays["acceleration"],
        ball_load_n=arrays["ball_load"],
        **facts,
    )
    loads = arrays["track_loads"]
    tracks = BearingTracks(
        inner=BodyTrack(loads, arrays["inner_track"]),
        outer=BodyTrack(loads, arrays["outer_track"]),
        balls_on_inner=tuple(BodyTrack(loads, rows) for rows in arrays["balls_on_inner"]),
        balls_on_outer=tuple(BodyTrack(loads, rows) for rows in arrays["balls_on_outer"]),
    )
    return record, tracks


# ---- sounds


class RingSound(NamedTuple):
    """Acceleration of the ring along x, to listen to: its samples [m/s2] and its gain.

    gain : float. Full scale per m/s2.
    """

    acceleration_m_s2: Array
    gain: float


def ring_sound(run: BearingRun) -> RingSound:
    """Return the acceleration of a run as it is heard: `sound.listen_s` long, with faded ends."""
    rate = wav.SAMPLE_RATE_HZ
    record = run.record.acceleration_m_s2[:, 0]
    samples = min(len(record), round(run.scene.listened * rate))
    faded = resampling.fade(record[:samples] - record[:samples].mean(), round(FADE_S * rate))
    return RingSound(faded, wav.listening_gain(faded))


def write_acceleration(run: BearingRun, folder: Path) -> RingSound:
    """Write acceleration.wav, in which 1.0 is 1 m/s2, and return its sound."""
    sound = ring_sound(run)
    comment = f"{_heard(run)}; 1.0 is 1 m/s2"
    content = wav.calibrated(sound.acceleration_m_s2, comment, _title(run))
    files.write_bytes(folder / ACCELERATION, content)
    return sound


def write_listen(run: BearingRun, folder: Path, sound: RingSound, gain: float) -> None:
    """Write listen.wav, the sound with a gain [full scale per m/s2]."""
    comment = f"{_heard(run)} for listening; full scale is {1 / gain:.6g} m/s2"
    content = wav.listening(sound.acceleration_m_s2, gain, comment, _title(run))
    files.write_bytes(folder / LISTEN, content)


def write_housing(run: BearingRun, folder: Path, common: float | None = None) -> None:
    """Write housing.wav, the sound of the housing plate with a gain, where there is one.

    The gain [full scale per Pa] is that of the sound, unless it is given.
    """
    sound = housing_sound(run)
    if sound is None:
        return
    gain = sound.gain if common is None else common
    distance = run.scene.sound.distance_m
    comment = f"housing plate at {distance:g} m; full scale is {1 / gain:.6g} Pa"
    content = wav.listening(sound.pressure, gain, comment, _title(run))
    files.write_bytes(folder / HOUSING, content)


class HousingRecord(NamedTuple):
    """Sound of the housing plate to listen to: its samples [Pa] and its gain.

    gain : float. Full scale per Pa.
    """

    pressure: Array
    gain: float


def housing_sound(run: BearingRun) -> HousingRecord | None:
    """Return the sound of the housing plate as it is heard, None for a scene without one."""
    if run.housing is None:
        return None
    rate = wav.SAMPLE_RATE_HZ
    record = run.housing.pressure
    samples = min(len(record), round(run.scene.listened * rate))
    faded = resampling.fade(record[:samples], round(FADE_S * rate))
    return HousingRecord(faded, wav.listening_gain(faded))


def _heard(run: BearingRun) -> str:
    """Say what is heard of a run."""
    return f"acceleration of the {run.moving} ring along x"


def _title(run: BearingRun) -> str:
    """Return the title of the sounds of a run."""
    name = run.scene.title or run.scene.name
    return printable(f"{name}, {run.label}" if run.label else name)[:_TITLE_LETTERS]


def listen_facts(sound: RingSound, gain: float) -> dict[str, float]:
    """Return length and gains of a sound as summary.json has them."""
    return {
        "seconds": len(sound.acceleration_m_s2) / wav.SAMPLE_RATE_HZ,
        "own_full_scale_m_s2": 1 / sound.gain,
        "full_scale_m_s2": 1 / gain,
    }


def play(run: BearingRun) -> Any:
    """Return a player in a notebook; in a script, write a sound to listen to and name it."""
    housing = housing_sound(run)
    if housing is not None:
        samples = housing.gain * housing.pressure
    else:
        sound = ring_sound(run)
        samples = sound.gain * sound.acceleration_m_s2
    if progress.in_notebook():
        from IPython.display import Audio

        return Audio(samples, rate=wav.SAMPLE_RATE_HZ, normalize=False)
    content = wav.listening(samples, 1.0, _heard(run), _title(run))
    path = files.write_temporary(f"{run.scene.name}-listen-", ".wav", content)
    print(f"listen: {path}")
    return None


# ---- a run folder


def write_run(run: BearingRun, folder: Path) -> None:
    """Write the files of a run, last summary.json, which tells that all are whole.

    Raises
    ------
    OSError : a file cannot be written. An earlier file of this name is kept.
    """
    began = ProcessorTime.now()
    files.write_bytes(folder / RESULT, result_bytes(run))
    sound = write_acceleration(run, folder)
    write_listen(run, folder, sound, sound.gain)
    write_housing(run, folder)
    files.write_bytes(folder / SPECTRUM, csv_bytes(figures.spectrum_table(run)))
    files.write_bytes(folder / LINES, csv_bytes(figures.line_table(run)))
    facts = {
        "listen": listen_facts(sound, sound.gain),
        "provenance": program_provenance(run.label),
    }
    numbers = {**run.summary, **facts}
    spent = ProcessorTime.now().since(began)
    numbers[effort.PARTS] = effort.with_work(numbers[effort.PARTS], effort.SOUND, spent)
    files.write_json(folder / SUMMARY, numbers)


def write_figures(run: BearingRun, folder: Path) -> None:
    """Write the figures of a run as PNG files."""
    files.make_below(folder, folder / FIGURES)
    for name in figures.NAMES:
        with left_out_if_it_fails(name):
            content = figures.picture(run, name).file("png")
            assert content is not None
            files.write_bytes(folder / FIGURES / f"{name}.png", content)


def read_summary(path: Path) -> dict[str, Any]:
    """Read the numbers of a bearing run.

    Raises
    ------
    FolderError : the file is damaged, or not written by this program.
    """
    advice = "delete it, and the same command solves the run again"
    try:
        summary = json.loads(read_regular(path, MAX_SUMMARY))
        for key, kind in _NEEDED.items():
            if not isinstance(summary[key], kind):
                raise ValueError(f"{key} is of another kind")
        for bands in (summary["bands_um_s"], summary["bands_uncertainty_db"]):
            for direction in DIRECTIONS:
                for band in VELOCITY_BANDS_HZ:
                    float(bands[direction][band])
        float(summary["listen"]["own_full_scale_m_s2"])
        float(summary["listen"]["full_scale_m_s2"])
        stored_without_faults(summary.get("without_faults"))
        stored_uncertainty(summary.get("bands_uncertainty_parts_db", {}))
        for seconds in summary.get(effort.PARTS, {}).values():
            float(seconds or 0.0)
    except OSError as error:
        raise FolderError(f"{path}: not readable ({error.strerror or error}); {advice}") from error
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise FolderError(
            f"{path}: not readable ({type(error).__name__}: {error}); {advice}"
        ) from error
    return dict(summary)
