"""The archive of a run: the definition of result.h5, and the way from a run and into a result."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

import rolling
from acoustics import wav
from acoustics.bands import MID_HZ
from acoustics.vibration_level import REFERENCES
from rolling.archive.definition import (
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
from rolling.check.error_cost import DETAIL, LEVELS, MEASURED, WITH_LAW, has_instrument
from rolling.marches.march_variables import (
    EVENTS,
    FILM,
    MAPS,
    MOVING_SERIES,
    SNAPSHOT,
    STATE_SERIES,
    STATES,
    STEP_SERIES,
    STEPS,
)
from rolling.marches.observers import (
    SlowMotion,
    Snapshot,
    events_of,
    maps_arrays,
    maps_of,
)
from rolling.marches.passes import SERIES as PASS_SERIES
from rolling.marches.passes import Passes
from rolling.marches.result import ErrorStretches, LoadMarches, MovingRelease, Result, StretchMarch
from rolling.results.channels import Channel, by_quantity
from rolling.results.solved_run import SolvedRun
from rolling.scene import file as scene_file
from rolling.scene.scene import Scene
from rolling.sound.vibration_sound import Vibration

if TYPE_CHECKING:
    import pandas as pd


def _of_quantity(quantity: str) -> tuple[Variable, Variable]:
    """Return the definitions of the signals of a quantity, and of their third octaves."""
    unit = REFERENCES[quantity].unit
    words = quantity.replace("_", " ")
    row = f"{quantity}_channel"
    return (
        Variable(quantity, f"{row} channel_time", unit, "f8", f"{words} of each channel"),
        Variable(f"{quantity}_band_rms", f"{row} band", unit, "f8", f"rms of the {words} by band"),
    )


# Attributes with the reasons of marches that failed, by the names that files of 0.8 have.
_FAILURE = "fault"
_FAILURES = "faults"
_SERIES = (
    Variable("step", "step", "m", "f8", "distance along the track at the middle of each step"),
    Variable("position", "position", "m", "f8", "distance along the track at each position"),
    Variable("time", "step", "s", "f8", "time at the middle of each step", is_auxiliary=True),
    Variable("position_time", "position", "s", "f8", "time at each position", is_auxiliary=True),
    *STEPS,
    Variable("speed", "step", "m/s", "f8", "speed of the sphere"),
    Variable("release_power", "step", "W", "f8", "elastic energy released per time"),
    Variable("loading_power", "step", "W", "f8", "elastic energy loaded per time"),
    Variable("release_per_metre", "step", "J/m", "f8", "elastic energy released per length"),
    Variable("loading_per_metre", "step", "J/m", "f8", "elastic energy loaded per length"),
    *STATES,
)
_SNAPSHOT = (
    Variable("along", "along", "m", "f8", "plate coordinate along the track"),
    Variable("across", "across", "m", "f8", "plate coordinate across the track"),
    *SNAPSHOT,
)
_STRETCHES = (
    Variable("first", "stretch", "position", "u4", "first position of each stretch"),
    Variable("release_energy", "stretch level stretch_step", "J", "f8", "energy released per step"),
    Variable("approach", "stretch level stretch_place", "m", "f8", "approach at each position"),
    Variable("plastic_area", "stretch level", "m2", "f8", "mean area at the hardness"),
)
_FILM = (
    Variable("map_position", "map_position", "1", "u4", "number of the position of each map"),
    Variable("along", "along", "m", "f8", "plate coordinate of the cells along the track"),
    Variable("across", "across", "m", "f8", "plate coordinate of the cells across the track"),
    *FILM,
)
_LAW = (
    Variable("load", "load", "N", "f8", "load of each march"),
    Variable("place", "place", "m", "f8", "distance along the track"),
    Variable("approach", "load place", "m", "f8", "approach under each load"),
    Variable("judging_load", "judging_load", "N", "f8", "load of the marches that judge the law"),
    Variable("judging_approach", "judging_load judging_place", "m", "f8", "approach of each"),
)
_MOVING = (
    Variable("place", "place", "m", "f8", "distance along the track"),
    Variable("force", "place", "N", "f8", "contact force that moves the load"),
    Variable("approach", "place", "m", "f8", "approach of the march"),
    Variable("motion_approach", "place", "m", "f8", "approach of the motion"),
    Variable("release_energy", "place_step", "J", "f8", "elastic energy released in each step"),
    Variable("loading_energy", "place_step", "J", "f8", "elastic energy loaded in each step"),
    Variable("energy_defect", "place_step", "J", "f8", "defect of the energy balance of each step"),
)
_PASSES = (
    Variable("release_energy", "pass place_step", "J", "f8", "elastic energy released per step"),
    Variable("plastic_work", "pass place_step", "J", "f8", "plastic work in each step"),
    Variable("approach", "pass place", "m", "f8", "approach of sphere and plate"),
    Variable("depth", "pass", "m", "f8", "maximum depth below the virgin surface after each pass"),
    Variable("sunk", "node_along node_across", "m", "f8", "depth of each node after the last pass"),
)
_FORCE = (
    Variable("force_time", "force_time", "s", "f8", "time"),
    Variable("force", "force_time", "N", "f8", "contact force"),
    Variable("band", "band", "Hz", "f8", "mid-frequency of the third octave"),
    Variable("band_rms", "band", "N", "f8", "rms of the contact force in the third octave"),
)
_CHANNELS = (
    Variable("channel_time", "channel_time", "s", "f8", "time"),
    Variable("band", "band", "Hz", "f8", "mid-frequency of the third octave"),
    *_of_quantity("acceleration"),
    *_of_quantity("velocity"),
    *_of_quantity("displacement"),
    *_of_quantity("force"),
    *_of_quantity("blocked_force"),
)
_SOUND = (
    Variable("sound_time", "sound_time", "s", "f8", "time"),
    Variable("pressure", "sound_time", "Pa", "f8", "sound pressure, at the left of two listeners"),
    Variable("pressure_right", "sound_time", "Pa", "f8", "sound pressure at the right listener"),
)

_CHANNEL_FACTS: dict[str, type[Attribute]] = {
    "sample_rate_hz": int,
    **{f"{quantity}_channels": str for quantity in REFERENCES},
    **{f"{quantity}_reference": str for quantity in REFERENCES},
}

DEFINITION = ArchiveDefinition(
    name="a result",
    format=5,
    kind="",
    groups={
        ROOT: GroupDefinition(
            _SERIES,
            {
                "title": str,
                "program": str,
                "identity": str,
                "scene": str,
                "load_n": float,
                "steps": int,
                "solved_steps": int,
                "step_m": float,
                "step_choice": str,
                "start_m": float,
            },
        ),
        "snapshot": GroupDefinition(_SNAPSHOT, {"distance_m": float}),
        "pressure_maps": GroupDefinition(MAPS),
        "events": GroupDefinition(EVENTS),
        "error_estimate": GroupDefinition(_STRETCHES, {_FAILURES: str}),
        "slow_motion": GroupDefinition(
            _FILM,
            {
                "first": int,
                "stride": int,
                "along": float,
                "across": float,
                "cell": float,
                "pressure_unit": float,
                "release_unit": float,
            },
        ),
        "force_law": GroupDefinition(_LAW, {"own_load_n": float, _FAILURES: str}),
        "moving_release": GroupDefinition(_MOVING, {"key": str, _FAILURE: str}),
        "passes": GroupDefinition(_PASSES),
        "contact_force": GroupDefinition(
            _FORCE,
            {"closed": int, "minimum_n": float, "maximum_n": float, "time_step_s": float},
        ),
        "channels": GroupDefinition(_CHANNELS, _CHANNEL_FACTS),
        "sound": GroupDefinition(
            _SOUND, {"sample_rate_hz": int, "closed": int, "factor_pa_per_w_m2": float}
        ),
    },
)
SERIES = DEFINITION.groups[ROOT].by_name  # definitions of the series of a run


def fixed_lengths(scene: Scene, result: Result) -> dict[str, int]:
    """Return the lengths of the dimensions that the scene of a result fixes."""
    lengths = {
        "step": result.steps,
        "position": result.steps + 1,
        "place": result.solved_steps + 1,
        "place_step": result.solved_steps,
        "axis": 2,
        "level": len(_levels_of(scene)),
        "band": len(MID_HZ),
    }
    if result.passes is not None:
        lengths["pass"] = len(result.passes.depth)
        lengths["node_along"], lengths["node_across"] = result.passes.sunk.shape
    return lengths


def series_of(run: SolvedRun) -> Series:
    """Return the series along the track of a run, with the places and times of their entries."""
    places = {
        "step": run.distance,
        "position": run.position,
        "time": run.time,
        "position_time": run.position_time,
    }
    return {
        variable: np.asarray(places[name] if name in places else run.series[name])
        for name, variable in SERIES.items()
    }


# ---- all groups


def archive_of(run: SolvedRun) -> Archive:
    """Return the archive of a run, with its series in the root."""
    result = run.result
    groups = {ROOT: _series_group(run)}
    if result.snapshot is not None:
        groups["snapshot"] = _snapshot_group(result.snapshot, run.scene.spacing)
    if result.maps:
        maps = [result.maps[position] for position in sorted(result.maps)]
        groups["pressure_maps"] = ArchiveGroup(maps_arrays(maps))
    if run.events is not None:
        groups["events"] = ArchiveGroup(run.events)
    if result.stretches is not None:
        groups["error_estimate"] = _stretches_group(result.stretches, _levels_of(run.scene))
    if result.slow_motion is not None:
        groups["slow_motion"] = _film_group(result.slow_motion)
    if result.load_marches is not None:
        groups["force_law"] = _law_group(result.load_marches, run)
    if result.moving is not None:
        groups["moving_release"] = _moving_group(result.moving, run)
    if result.passes is not None:
        groups["passes"] = _passes_group(result.passes)
    if run.vibration_sound is not None:
        groups["contact_force"] = _force_group(run.vibration_sound)
    if run.channels:
        groups["channels"] = _channels_group(run.channels)
    groups["sound"] = _sound_group(run)
    return groups


def fill_result(result: Result, groups: Archive) -> None:
    """Fill an empty result with its archive."""
    _read_series(groups[ROOT], result)
    if "snapshot" in groups:
        result.snapshot = _read_snapshot(groups["snapshot"])
    if "pressure_maps" in groups:
        result.maps = maps_of(groups["pressure_maps"].arrays)
    if "events" in groups:
        result.event_pieces = {0: events_of(groups["events"].arrays)}
    if "error_estimate" in groups:
        result.stretches = _read_stretches(groups["error_estimate"])
    if "slow_motion" in groups:
        result.slow_motion = _read_film(groups["slow_motion"])
    if "force_law" in groups:
        result.load_marches = _read_law(groups["force_law"], result.solved_steps)
    if "moving_release" in groups:
        result.moving = _read_moving(groups["moving_release"], result.solved_steps)
    if "passes" in groups:
        result.passes = _read_passes(groups["passes"])


# ---- series


def _series_group(run: SolvedRun) -> ArchiveGroup:
    """Return the series of a whole run, and the facts of its scene."""
    result = run.result
    arrays = {
        "step": run.distance,
        "position": run.position,
        "time": run.time,
        "position_time": run.position_time,
    }
    for name in SERIES:
        if name not in arrays:
            arrays[name] = run.series[name]
    attributes: dict[str, Any] = {
        "title": f"rolling contact noise: {run.scene.name}",
        "program": rolling.__version__,
        "identity": result.identity,
        "scene": scene_file.dump(run.scene),
        "load_n": run.scene.load,
        "steps": result.steps,
        "solved_steps": result.solved_steps,
        "step_m": result.step,
        "step_choice": run.scene.step_reason,
        "start_m": result.start,
    }
    return ArchiveGroup(arrays, attributes)


def _read_series(group: ArchiveGroup, result: Result) -> None:
    """Read the series of the solved lap, all as floating-point numbers; times are not stored."""
    for name in (*STEP_SERIES, *STATE_SERIES):
        if name in SERIES:
            count = len(result.series[name])
            result.series[name] = group.arrays[name][:count].astype(np.float64)


# ---- snapshot


def _snapshot_group(snapshot: Snapshot, spacing: float) -> ArchiveGroup:
    """Return pressure [Pa] and deflection [m] with the places [m] of their cells."""
    rows, columns = snapshot.pressure.shape
    arrays = {
        "along": snapshot.along + np.arange(rows) * spacing,
        "across": snapshot.across + np.arange(columns) * spacing,
        "pressure": snapshot.pressure,
        "deflection": snapshot.deflection,
    }
    return ArchiveGroup(arrays, {"distance_m": snapshot.distance})


def _read_snapshot(group: ArchiveGroup) -> Snapshot:
    """Return the snapshot of a group."""
    return Snapshot(
        distance=group.attributes["distance_m"],
        along=float(group.arrays["along"][0]),
        across=float(group.arrays["across"][0]),
        pressure=group.arrays["pressure"],
        deflection=group.arrays["deflection"],
    )


# ---- error estimate and film

_LEVELS = (*LEVELS, DETAIL)  # that of detail is NaN where a stretch is not marched on it
# Levels of a scene that states an instrument; each is NaN where a stretch is not marched on it.
_INSTRUMENT_LEVELS = (*_LEVELS, WITH_LAW, MEASURED)


def _stretches_group(stretches: ErrorStretches, levels: Sequence[str]) -> ArchiveGroup:
    """Return the marches by stretch and level, and the reasons of those that failed."""
    firsts = sorted({first for first, _ in stretches.marches})
    none = StretchMarch.none(stretches.steps)
    marches = [[stretches.marches.get((k, level), none) for level in levels] for k in firsts]
    arrays = {
        "first": np.array(firsts),
        "release_energy": np.array([[march.release for march in row] for row in marches]),
        "approach": np.array([[march.approach for march in row] for row in marches]),
        "plastic_area": np.array([[march.plastic_area for march in row] for row in marches]),
    }
    failures = [[march.failure for march in row] for row in marches]
    return ArchiveGroup(arrays, {_FAILURES: json.dumps(failures)})


def _levels_of(scene: Scene) -> tuple[str, ...]:
    """Return the levels that the file of a scene has room for."""
    return _INSTRUMENT_LEVELS if has_instrument(scene) else _LEVELS


def _read_stretches(group: ArchiveGroup) -> ErrorStretches:
    """Return the marches of stretches, whose time is not stored."""
    arrays = group.arrays
    failures = json.loads(group.attributes[_FAILURES])
    stretches = ErrorStretches(steps=arrays["release_energy"].shape[2])
    levels = _INSTRUMENT_LEVELS[: arrays["plastic_area"].shape[1]]
    for row, first in enumerate(arrays["first"].tolist()):
        for column, level in enumerate(levels):
            area = float(arrays["plastic_area"][row, column])
            failure = failures[row][column]
            if not failure and np.isnan(area):
                continue  # this stretch is not marched on this level
            stretches.marches[first, level] = StretchMarch(
                release=arrays["release_energy"][row, column],
                approach=arrays["approach"][row, column],
                plastic_area=area,
                failure=failure,
            )
    return stretches


def _film_group(film: SlowMotion) -> ArchiveGroup:
    """Return the film; it has no arrays where its stretch could not be solved again."""
    attributes = {
        "first": film.first,
        "stride": film.stride,
        "along": film.along,
        "across": film.across,
        "cell": film.cell,
        "pressure_unit": film.pressure_unit,
        "release_unit": film.release_unit,
    }
    if not film.pressure.size:
        return ArchiveGroup({}, attributes)
    _, rows, columns = film.pressure.shape
    arrays = {
        "map_position": film.positions,
        "along": film.along + (np.arange(rows) + 0.5) * film.cell,
        "across": film.across + (np.arange(columns) + 0.5) * film.cell,
        "pressure": film.pressure,
        "release": film.release,
    }
    return ArchiveGroup(arrays, attributes)


def _read_film(group: ArchiveGroup) -> SlowMotion:
    """Return the film of a group."""
    if not group.arrays:
        return SlowMotion.none()
    return SlowMotion(
        first=group.attributes["first"],
        stride=group.attributes["stride"],
        along=group.attributes["along"],
        across=group.attributes["across"],
        cell=group.attributes["cell"],
        pressure_unit=group.attributes["pressure_unit"],
        release_unit=group.attributes["release_unit"],
        pressure=group.arrays["pressure"],
        release=group.arrays["release"],
    )


# ---- marches beside the track


def _law_group(marches: LoadMarches, run: SolvedRun) -> ArchiveGroup:
    """Return the approach at each load, the scene's own included."""
    approach = marches.approach | {run.scene.load: run.result.series["approach"]}
    loads = sorted(approach)
    arrays = {
        "load": np.array(loads),
        "place": run.position[: run.result.solved_steps + 1],
        "approach": np.array([approach[load] for load in loads]),
    }
    judging_loads = sorted(marches.judging)
    if judging_loads:
        arrays["judging_load"] = np.array(judging_loads)
        arrays["judging_approach"] = np.array([marches.judging[load] for load in judging_loads])
    failures = {repr(load): marches.failures[load] for load in sorted(marches.failures)}
    return ArchiveGroup(arrays, {"own_load_n": run.scene.load, _FAILURES: json.dumps(failures)})


def _read_law(group: ArchiveGroup, solved_steps: int) -> LoadMarches:
    """Return the marches at other loads, without the run's own."""
    arrays = group.arrays
    marches = LoadMarches(solved_steps)
    for load, approach in zip(arrays["load"].tolist(), arrays["approach"], strict=True):
        marches.approach[load] = approach
    del marches.approach[group.attributes["own_load_n"]]
    if "judging_load" in arrays:
        loads = arrays["judging_load"].tolist()
        for load, approach in zip(loads, arrays["judging_approach"], strict=True):
            marches.judging[load] = approach
    for load_text, failure in json.loads(group.attributes[_FAILURES]).items():
        marches.failures[float(load_text)] = failure
    return marches


def _moving_group(moving: MovingRelease, run: SolvedRun) -> ArchiveGroup:
    """Return force [N], approach [m] and energies [J] under the moving load, or why not."""
    attributes = {"key": moving.key, _FAILURE: moving.failure}
    if moving.failure:
        return ArchiveGroup({}, attributes)
    arrays = {
        "place": run.position[: len(moving.force)],
        "force": moving.force,
        "approach": moving.approach,
        "motion_approach": moving.motion_approach,
        **moving.steps,
    }
    return ArchiveGroup(arrays, attributes)


def _read_moving(group: ArchiveGroup, solved_steps: int) -> MovingRelease:
    """Return the march under the moving load, or why there is none."""
    key = group.attributes["key"]
    failure = group.attributes[_FAILURE]
    if failure:
        return MovingRelease.impossible(key, solved_steps, failure)
    return MovingRelease(
        key=key,
        force=group.arrays["force"],
        motion_approach=group.arrays["motion_approach"],
        approach=group.arrays["approach"],
        steps={name: group.arrays[name] for name in MOVING_SERIES},
    )


def _passes_group(passes: Passes) -> ArchiveGroup:
    """Return the series of all passes, and the depth [m] of the plate after the last."""
    return ArchiveGroup({**passes.series, "depth": passes.depth, "sunk": passes.sunk})


def _read_passes(group: ArchiveGroup) -> Passes:
    """Return the passes of a group, without the surface before the last."""
    return Passes(
        series={name: group.arrays[name] for name in PASS_SERIES},
        depth=group.arrays["depth"],
        sunk=group.arrays["sunk"],
    )


# ---- force and sound, which are made again from the marches and not read


def _force_group(vibration: Vibration) -> ArchiveGroup:
    """Return the contact force at the samples of the sound, and its bands."""
    arrays = {
        "force_time": np.arange(len(vibration.force)) / wav.SAMPLE_RATE_HZ,
        "force": vibration.load + vibration.force,
        "band": np.array(MID_HZ),
        "band_rms": vibration.force_bands,
    }
    attributes = {
        "closed": int(vibration.closed),
        "minimum_n": float(vibration.motion.force_n.min()),
        "maximum_n": float(vibration.motion.force_n.max()),
        "time_step_s": vibration.motion.time_step_s,
    }
    return ArchiveGroup(arrays, attributes)


def _channels_group(channels: tuple[Channel, ...]) -> ArchiveGroup:
    """Return the signals of the channels by quantity, and the names and places of their rows."""
    samples = len(channels[0].samples)
    arrays: Arrays = {
        "channel_time": np.arange(samples) / wav.SAMPLE_RATE_HZ,
        "band": np.array(MID_HZ),
    }
    attributes: dict[str, Any] = {"sample_rate_hz": wav.SAMPLE_RATE_HZ}
    for quantity, rows in by_quantity(channels).items():
        reference = REFERENCES[quantity]
        arrays[quantity] = np.array([channel.samples for channel in rows])
        levels = [[*channel.levels.third_octave_db.values()] for channel in rows]
        arrays[f"{quantity}_band_rms"] = reference.value * 10 ** (np.array(levels, float) / 20)
        facts = []
        for channel in rows:
            facts.append(
                {
                    "name": channel.name,
                    "of": channel.of,
                    "place_m": channel.place_m,
                    "closed": channel.closed,
                }
            )
        attributes[f"{quantity}_channels"] = json.dumps(facts)
        attributes[f"{quantity}_reference"] = reference.words
    return ArchiveGroup(arrays, attributes)


def _sound_group(run: SolvedRun) -> ArchiveGroup:
    """Return the sound pressure [Pa] at one listener or two."""
    sound = run.sound
    arrays = {
        "sound_time": np.arange(len(sound.pressure)) / sound.sample_rate,
        "pressure": sound.pressure,
    }
    if sound.right is not None:
        arrays["pressure_right"] = sound.right
    attributes: dict[str, Any] = {
        "sample_rate_hz": sound.sample_rate,
        "closed": int(sound.closed),
    }
    if sound.factor is not None:
        attributes["factor_pa_per_w_m2"] = sound.factor
    return ArchiveGroup(arrays, attributes)


# ---- table


def series_frame(run: SolvedRun) -> pd.DataFrame:
    """Return the series of a run as a table, one row per position, with units in `attrs`."""
    import pandas as pd  # slow to import, for tables only

    columns = {"position_time": pd.Series(run.position_time)}
    for name, values in run.series.items():
        if name in SERIES:
            columns[name] = pd.Series(values)
    table = pd.DataFrame(columns).set_index(pd.Index(run.position, name="position"))
    table.attrs = {name: SERIES[name].unit for name in ("position", *table)}
    return table
