"""Files of a bearing run: result.h5, numbers, tables, sounds and figures of a run folder."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from acoustics import resampling, wav
from acoustics.arrays import Array
from acoustics.texts import printable
from acoustics.uncertainty import level_uncertainty
from rolling.archive.archive_file import archive_bytes, largest_size, read_archive, refusing
from rolling.archive.definition import (
    LETTERS,
    ROOT,
    Archive,
    ArchiveDefinition,
    ArchiveGroup,
    Arrays,
    Attribute,
    GroupDefinition,
    Series,
    Variable,
)
from rolling.archive.hdf5_writer import to_xarray
from rolling.bearing.model import BearingModel
from rolling.bearing.ring_record import RingRecord, record_of
from rolling.bearing.tracks import BearingTracks, BodyTrack
from rolling.bearing_kind import bearing_tables, needs
from rolling.bearing_kind.contact_plan import contact_plan
from rolling.bearing_kind.moved_ring import moved_ring
from rolling.bearing_kind.solved_bearing import SolvedBearing
from rolling.contact.processor_time import ProcessorTime
from rolling.kinds.heard_sound import HeardSound, PlainSound
from rolling.kinds.run_folder import LISTEN, RESULT
from rolling.marches import effort
from rolling.numbers.file_facts import BearingFiles
from rolling.numbers.run_file import StoredBearing
from rolling.results.provenance import program_provenance
from rolling.results.runs_table import csv_bytes
from rolling.results.stored_numbers import with_parts, write_stored
from rolling.scene.bearing_scene import BearingScene
from rolling.terminal import whole_files

if TYPE_CHECKING:
    import xarray

    from rolling.bearing_kind.bearing_run import BearingRun

SPECTRUM = "spectrum.csv"
LINES = "lines.csv"
ACCELERATION = "acceleration.wav"
LONG = "long.wav"
HOUSING = "housing.wav"
RING = "listen"  # group of the sounds of rings that share a gain
_TITLE_LETTERS = 400
FADE_S = 0.05  # at the ends of a sound
_RIGID_AXES = ("x", "y", "z")
_BENDING_AXES = ("a", "b", "c", "d")
_TURNS = ("u", "v")

_FACTS: dict[str, type[Attribute]] = {
    "energy_error": float,
    "lost_contact_share": float,
    "rate_hz": float,
    "cage_hz": float,
}
_MOTION = (
    Variable("velocity", "time axis", "m/s", "f4", "velocity of the ring"),
    Variable("acceleration", "time axis", "m/s2", "f4", "acceleration of the ring"),
    Variable("ball_load", "time ball", "N", "f4", "load of each ball"),
)
_TRACKS = (
    Variable(
        "inner_track",
        "load inner_place",
        "m",
        "f4",
        "change of the approach around the inner raceway",
    ),
    Variable(
        "outer_track",
        "load outer_place",
        "m",
        "f4",
        "change of the approach around the outer raceway",
    ),
    Variable(
        "balls_on_inner",
        "ball load ball_place",
        "m",
        "f4",
        "change around each ball on the inner raceway",
    ),
    Variable(
        "balls_on_outer",
        "ball load ball_place",
        "m",
        "f4",
        "change around each ball on the outer raceway",
    ),
)
_COORDINATES = (
    Variable("time", "time", "s", "f8", "time from the start of the record"),
    Variable(
        "axis",
        "axis",
        "1",
        LETTERS,
        "x to the middle of the load zone, z along the shaft; cosine a and sine b of bending with"
        " two waves, c and d with three; turns u and v about x and y, in rad",
    ),
    Variable("ball", "ball", "1", "u4", "number of the ball"),
    Variable("load", "load", "N", "f8", "load of a contact at which the tracks are known"),
    Variable("inner_place", "inner_place", "m", "f8", "length along the inner raceway"),
    Variable("outer_place", "outer_place", "m", "f8", "length along the outer raceway"),
    Variable("ball_place", "ball_place", "m", "f8", "length along the track of a ball"),
)
DEFINITION = ArchiveDefinition(
    name="a bearing's result",
    format=2,
    kind="bearing",
    groups={ROOT: GroupDefinition((*_MOTION, *_TRACKS, *_COORDINATES), _FACTS)},
)
_FORMER_LOADS = Variable("track_loads", "load", "N", "f4", "load of a contact")
_FORMER = ArchiveDefinition(  # of 0.8.0, without time and places
    name="a bearing's result",
    format=1,
    kind="bearing",
    groups={ROOT: GroupDefinition((*_MOTION, *_TRACKS, _FORMER_LOADS), _FACTS)},
)


# ---- result.h5


def archive_of(run: SolvedBearing) -> Archive:
    """Return the archive of a run: its motion, its tracks, and the facts about them."""
    tracks = run.tracks
    every = (tracks.inner, tracks.outer, *tracks.balls_on_inner, *tracks.balls_on_outer)
    loads = every[0].loads_n
    for track in every:
        loads = np.union1d(loads, track.loads_n)
    places = max(track.points for track in every[2:])

    def of_balls(balls: tuple[BodyTrack, ...]) -> Array:
        """Return the tracks of balls at the same loads and places, (balls, loads, places)."""
        return np.stack([track.resampled(places).at_loads(loads) for track in balls])

    turns = run.scene.circumferences
    arrays = {
        "velocity": run.record.velocity_m_s,
        "acceleration": run.record.acceleration_m_s2,
        "ball_load": run.record.ball_load_n,
        "inner_track": tracks.inner.at_loads(loads),
        "outer_track": tracks.outer.at_loads(loads),
        "balls_on_inner": of_balls(tracks.balls_on_inner),
        "balls_on_outer": of_balls(tracks.balls_on_outer),
        "time": np.arange(len(run.record.velocity_m_s)) / run.record.rate_hz,
        "axis": np.array(_axes(run.model)),
        "ball": np.arange(run.record.ball_load_n.shape[1]),
        "load": loads,
        "inner_place": _places(turns["inner"], tracks.inner.points),
        "outer_place": _places(turns["outer"], tracks.outer.points),
        "ball_place": _places(turns["balls"], places),
    }
    facts = {name: getattr(run.record, name) for name in _FACTS}
    return {ROOT: ArchiveGroup(arrays, facts)}


def _axes(model: BearingModel) -> list[str]:
    """Return the letters of the displacements of a ring."""
    turns = _TURNS if model.tilts else ()
    return [*_RIGID_AXES, *_BENDING_AXES[: 2 * len(model.bending)], *turns]


def _places(turn_m: float, points: int) -> Array:
    """Return the places [m] of equally spaced points around a turn of some length."""
    return turn_m * np.arange(points) / points


def series_of(run: SolvedBearing) -> Series:
    """Return the arrays of the result of a run."""
    definitions = DEFINITION.groups[ROOT].by_name
    return {definitions[name]: values for name, values in archive_of(run)[ROOT].arrays.items()}


def result_dataset(run: SolvedBearing) -> xarray.Dataset:
    """Return the arrays of a run with dimensions and units, and its facts as attributes."""
    return to_xarray(DEFINITION, archive_of(run)).to_dataset()


def result_bytes(run: SolvedBearing) -> bytes:
    """Return the bytes of result.h5; equal runs have equal arrays and attributes in it."""
    return archive_bytes(DEFINITION, archive_of(run))


def read_result(path: Path, scene: BearingScene) -> tuple[RingRecord, BearingTracks]:
    """Read the record of a ring and the tracks of its bearing.

    Raises
    ------
    FolderError : the file is missing or damaged, or holds no result of such a bearing.
    """
    archive = read_archive(
        path,
        [DEFINITION, _FORMER],
        lengths={
            "axis": len(_axes(scene.model)),
            "ball": scene.bearing.balls,
            "time": max(1, round(scene.moved * wav.SAMPLE_RATE_HZ)),
        },
        most_bytes=largest_size(needs.motion_disk(scene, contact_plan(scene))),
    )
    with refusing(path, DEFINITION):
        root = archive[ROOT]
        return _record(root, scene), _tracks(root.arrays)


def _record(root: ArchiveGroup, scene: BearingScene) -> RingRecord:
    """Return the motion of a ring from its arrays and facts."""
    facts = {name: root.attributes[name] for name in _FACTS}
    for name, number in facts.items():
        if not math.isfinite(number):
            raise ValueError(f"{name}: no finite number")
    if facts["rate_hz"] != wav.SAMPLE_RATE_HZ:
        raise ValueError(f"rate_hz: got {facts['rate_hz']:g}, allowed: {wav.SAMPLE_RATE_HZ}")
    return RingRecord(
        velocity_m_s=_finite(root.arrays, "velocity"),
        acceleration_m_s2=_finite(root.arrays, "acceleration"),
        ball_load_n=_finite(root.arrays, "ball_load"),
        sensor=scene.sensor,
        tilts=scene.model.tilts,
        **facts,
    )


def _tracks(arrays: Arrays) -> BearingTracks:
    """Return the tracks of a bearing from its arrays."""
    loads = _finite(arrays, "load" if "load" in arrays else _FORMER_LOADS.name)
    return BearingTracks(
        inner=BodyTrack(loads, _finite(arrays, "inner_track")),
        outer=BodyTrack(loads, _finite(arrays, "outer_track")),
        balls_on_inner=tuple(BodyTrack(loads, rows) for rows in _finite(arrays, "balls_on_inner")),
        balls_on_outer=tuple(BodyTrack(loads, rows) for rows in _finite(arrays, "balls_on_outer")),
    )


def _finite(arrays: Arrays, name: str) -> Array:
    """Return the values of an array, which are finite numbers."""
    values = arrays[name].astype(float)
    if not np.isfinite(values).all():
        raise ValueError(f"{name}: values that are no finite numbers")
    return values


# ---- sounds


def sounds(run: SolvedBearing) -> list[HeardSound]:
    """Return the acceleration of the ring to listen to, and the sound of a housing plate."""
    heard_sounds: list[HeardSound] = [ring_sound(run)]
    housing = housing_sound(run)
    if housing is not None:
        heard_sounds.append(housing)
    return heard_sounds


def ring_sound(run: SolvedBearing) -> PlainSound:
    """Return the acceleration of a run as it is heard: `sound.listen_s` long, with faded ends."""
    rate = wav.SAMPLE_RATE_HZ
    record = run.record.seen_acceleration_m_s2[:, 0]
    samples = min(len(record), round(run.scene.listened * rate))
    faded = resampling.fade(record[:samples] - record[:samples].mean(), round(FADE_S * rate))
    return PlainSound(
        file=LISTEN,
        unit="m/s2",
        group=RING,
        record=faded,
        heard=_heard(run),
        title=_title(run),
        comment=f"{_heard(run)} for listening",
    )


def housing_sound(run: SolvedBearing) -> PlainSound | None:
    """Return the sound of the housing plate as it is heard, None for a scene without one."""
    if run.housing is None:
        return None
    rate = wav.SAMPLE_RATE_HZ
    record = run.housing.pressure
    samples = min(len(record), round(run.scene.listened * rate))
    faded = resampling.fade(record[:samples], round(FADE_S * rate))
    levels = run.housing.levels
    of_record = level_uncertainty(record[:samples], rate, levels, False)
    return PlainSound(
        file=HOUSING,
        unit="Pa",
        group="housing",
        record=faded,
        heard=f"housing plate at {run.scene.sound.distance_m:g} m",
        title=_title(run),
        stated_db=levels.laeq_db,
        spread_db=of_record.laeq_db or 0.0,
    )


def write_acceleration(run: SolvedBearing, folder: Path) -> None:
    """Write acceleration.wav, in which 1.0 is 1 m/s2."""
    comment = f"{_heard(run)}; 1.0 is 1 m/s2"
    content = wav.calibrated(ring_sound(run).record, comment, _title(run))
    whole_files.write_bytes(folder / ACCELERATION, content)


def write_sounds(run: SolvedBearing, folder: Path) -> BearingFiles:
    """Write the sounds of a run with their own gains; return the facts about their files."""
    facts = {}
    for sound in sounds(run):
        whole_files.write_bytes(folder / sound.file, sound.wav())
        facts[Path(sound.file).stem] = sound.facts()
    return BearingFiles(**facts)


def _heard(run: SolvedBearing) -> str:
    """Say what is heard of a run."""
    return f"acceleration of the {run.moving} ring {run.scene.seen_at('along x')}"


def _title(run: SolvedBearing) -> str:
    """Return the title of the sounds of a run."""
    name = run.scene.title or run.scene.name
    return printable(f"{name}, {run.label}" if run.label else name)[:_TITLE_LETTERS]


# ---- a run folder


def write_run(run: BearingRun) -> None:
    """Write the files of a run into its folder, last summary.json, which tells that all are whole.

    Raises
    ------
    OSError : a file cannot be written. An earlier file of this name is kept.
    """
    began = ProcessorTime.now()
    folder = run.folder
    whole_files.make_below(run.home, folder)
    whole_files.write_bytes(folder / RESULT, result_bytes(run))
    write_acceleration(run, folder)
    facts = write_sounds(run, folder)
    whole_files.write_bytes(folder / SPECTRUM, csv_bytes(bearing_tables.spectrum_table(run)))
    whole_files.write_bytes(folder / LINES, csv_bytes(bearing_tables.line_table(run)))
    stored = StoredBearing(
        numbers=run.numbers,
        files=facts,
        provenance=program_provenance(run.label),
    )
    spent = ProcessorTime.now().since(began)
    known = run.numbers.effort.parts_cpu_s or {}
    write_stored(folder, with_parts(stored, effort.with_work(known, effort.SOUND, spent)))


def write_long(run: BearingRun, seconds: float) -> Path:
    """Let the ring move for longer, and write long.wav; return its path."""
    motion = moved_ring(run.model, run.tracks, seconds, wav.SAMPLE_RATE_HZ)
    record = record_of(motion, run.kinematics, run.scene.sensor)
    acceleration = record.seen_acceleration_m_s2[:, 0]
    acceleration = acceleration - acceleration.mean()
    faded = resampling.fade(acceleration, round(FADE_S * wav.SAMPLE_RATE_HZ))
    gain = wav.listening_gain(faded)
    comment = f"{_heard(run)}; full scale is {1 / gain:.6g} m/s2"
    content = wav.listening(faded, gain, comment, printable(run.scene.name))
    whole_files.write_bytes(run.folder / LONG, content)
    return run.folder / LONG
