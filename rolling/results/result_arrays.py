"""The arrays of result.h5: their names, dimensions and units, from a run and into a result."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import rolling
from acoustics import wav
from acoustics.bands import MID_HZ
from rolling.check.error_cost import DETAIL, LEVELS
from rolling.marches import observers
from rolling.marches.observers import PLACES, PressureMap, SlowMotion, Snapshot
from rolling.marches.passes import SERIES as PASS_SERIES
from rolling.marches.passes import Passes
from rolling.marches.result import ErrorStretches, LoadMarches, MovingRelease, Result, StretchMarch
from rolling.scene import file as scene_file
from rolling.scene.messages import table
from rolling.sound.vibration_sound import Vibration

if TYPE_CHECKING:
    from rolling.results.run_result import Run

FORMAT = 4
Arrays = dict[str, NDArray[Any]]
# Dimensions, unit and type of each variable by its path.
TABLE: dict[str, tuple[str, str, str]] = table("rolling.results", "arrays")
Facts = dict[str, Any]
Group = tuple[Arrays, Facts]  # arrays and attributes of a group


def fixed_lengths(result: Result) -> dict[str, int]:
    """Return the lengths of the dimensions that the scene of a result fixes."""
    lengths = {}
    if result.passes is not None:
        shape = len(result.passes.depth), *result.passes.sunk.shape
        lengths = dict(zip(("pass", "node_along", "node_across"), shape, strict=True))
    return lengths | {
        "step": result.steps,
        "position": result.steps + 1,
        "place": result.solved_steps + 1,
        "place_step": result.solved_steps,
        "axis": 2,
        "level": len(_LEVELS),
        "band": len(MID_HZ),
    }


# ---- from a run


def groups_of(run: Run) -> dict[str, Group]:
    """Return the groups of the file of a run by name; the root, with the series, has none."""
    result, sound = run.result, run.sound
    arrays = {name: values for name, values in run.series.items() if name in TABLE}
    arrays |= {"step": run.distance, "position": run.position}
    arrays |= {"time": run.time, "position_time": run.position_time}
    facts = {
        "title": f"rolling contact noise: {run.scene.name}",
        "format": FORMAT,
        "program": rolling.__version__,
        "identity": result.identity,
        "scene": scene_file.dump(run.scene),
        "load_n": run.scene.load,
        "steps": result.steps,
        "solved_steps": result.solved_steps,
        "step_m": result.step,
        "start_m": result.start,
    }
    groups: dict[str, Group] = {"": (arrays, facts)}
    for name, (field, write, _) in _GROUPS.items():
        if content := getattr(result, field):
            groups[name] = write(content, run)
    if run.vibration is not None:
        groups["contact_force"] = _contact_force(run.vibration)
    samples = np.arange(len(sound.pressure)) / sound.sample_rate
    of_sound: dict[str, Any] = {"sample_rate_hz": sound.sample_rate, "closed": int(sound.closed)}
    if sound.factor is not None:
        of_sound["factor_pa_per_w_m2"] = sound.factor
    groups["sound"] = {"sound_time": samples, "pressure": sound.pressure}, of_sound
    if sound.right is not None:
        groups["sound"][0]["pressure_right"] = sound.right
    return groups


def fill(result: Result, groups: dict[str, Group]) -> None:
    """Fill an empty result with the arrays of the groups of its file."""
    series, _ = groups[""]
    for name in (*observers.STEP_SERIES, *observers.STATE_SERIES):
        if name in TABLE:
            result.series[name] = series[name][: len(result.series[name])].copy()
    for name, (field, _, read) in _GROUPS.items():
        if name in groups:
            setattr(result, field, read(*groups[name], result))


# ---- groups of a result, each written and read


def _write_snapshot(snapshot: Snapshot, run: Run) -> Group:
    """Return pressure [Pa] and deflection [m] with the places [m] of their cells."""
    rows, columns = (np.arange(count) * run.scene.spacing for count in snapshot.pressure.shape)
    return {
        "along": snapshot.along + rows,
        "across": snapshot.across + columns,
        "pressure": snapshot.pressure,
        "deflection": snapshot.deflection,
    }, {"distance_m": snapshot.distance}


def _read_snapshot(arrays: Arrays, facts: Facts, result: Result) -> Snapshot:
    """Return the snapshot of a group."""
    along, across = float(arrays["along"][0]), float(arrays["across"][0])
    return Snapshot(facts["distance_m"], along, across, arrays["pressure"], arrays["deflection"])


def _write_maps(maps: dict[int, PressureMap], run: Run) -> Group:
    """Return the maps [Pa], padded with NaN to a common shape, and their places [m]."""
    ordered = [maps[position] for position in sorted(maps)]
    shapes = np.array([drawn.pressure.shape for drawn in ordered])
    padded = np.full((len(maps), *shapes.max(axis=0)), np.nan, dtype=np.float32)
    for block, drawn, (rows, columns) in zip(padded, ordered, shapes, strict=True):
        block[:rows, :columns] = drawn.pressure
    arrays = {name: np.array([getattr(drawn, name) for drawn in ordered]) for name in PLACES}
    return arrays | {"rows": shapes[:, 0], "columns": shapes[:, 1], "pressure": padded}, {}


def _read_maps(arrays: Arrays, facts: Facts, result: Result) -> dict[int, PressureMap]:
    """Return the maps of a group by position, without their padding."""
    maps, shapes = {}, zip(arrays["rows"].tolist(), arrays["columns"].tolist(), strict=True)
    places = zip(*(arrays[name].tolist() for name in PLACES), strict=True)
    for place, (rows, columns), padded in zip(places, shapes, arrays["pressure"], strict=True):
        fields = dict(zip(PLACES, place, strict=True))
        maps[place[0]] = PressureMap(**fields, pressure=padded[:rows, :columns].copy())
    return maps


_LEVELS = (*LEVELS, DETAIL)  # that of detail is NaN where a stretch is not marched on it
_STRETCH = {"release_energy": "release", "approach": "approach", "plastic_area": "plastic_area"}


def _write_stretches(stretches: ErrorStretches, run: Run) -> Group:
    """Return the marches by stretch and level, and the reasons of those that failed."""
    firsts = sorted({first for first, _ in stretches.marches})
    none = StretchMarch.none(stretches.steps)
    marches = [[stretches.marches.get((k, level), none) for level in _LEVELS] for k in firsts]
    arrays = {
        name: np.array([[getattr(march, field) for march in row] for row in marches])
        for name, field in _STRETCH.items()
    }
    faults = [[march.fault for march in row] for row in marches]
    return {"first": np.array(firsts)} | arrays, {"faults": json.dumps(faults)}


def _read_stretches(arrays: Arrays, facts: Facts, result: Result) -> ErrorStretches:
    """Return the marches of stretches, whose time is not stored."""
    release, approach, areas = (arrays[name] for name in _STRETCH)
    stretches, faults = ErrorStretches(release.shape[2]), json.loads(facts["faults"])
    for row, first in enumerate(arrays["first"].tolist()):
        for column, level in enumerate(_LEVELS):
            at, fault = (row, column), faults[row][column]
            if level == DETAIL and not fault and np.isnan(areas[at]):
                continue
            march = StretchMarch(release[at], approach[at], float(areas[at]), 0.0, fault)
            stretches.marches[first, level] = march
    return stretches


_FILM = ("first", "stride", "along", "across", "cell", "pressure_unit", "release_unit")


def _write_film(film: SlowMotion, run: Run) -> Group:
    """Return the film; it has no arrays where its stretch could not be solved again."""
    facts = {name: getattr(film, name) for name in _FILM}
    rows, columns = ((np.arange(count) + 0.5) * film.cell for count in film.pressure.shape[1:])
    arrays = {
        "map_position": film.positions,
        "along": film.along + rows,
        "across": film.across + columns,
        "pressure": film.pressure,
        "release": film.release,
    }
    return arrays if film.pressure.size else {}, facts


def _read_film(arrays: Arrays, facts: Facts, result: Result) -> SlowMotion:
    """Return the film of a group."""
    if not arrays:
        return SlowMotion.none()
    fields = {name: facts[name] for name in _FILM}
    return SlowMotion(**fields, pressure=arrays["pressure"], release=arrays["release"])


def _write_law(marches: LoadMarches, run: Run) -> Group:
    """Return the approach at each load, the scene's own included."""
    by_load = marches.approach | {run.scene.load: run.result.series["approach"]}
    loads, between = sorted(by_load), sorted(marches.judging)
    arrays = {
        "load": np.array(loads),
        "place": run.position[: run.result.solved_steps + 1],
        "approach": np.array([by_load[load] for load in loads]),
    }
    if between:
        arrays["judging_load"] = np.array(between)
        arrays["judging_approach"] = np.array([marches.judging[load] for load in between])
    faults = {repr(load): marches.faults[load] for load in sorted(marches.faults)}
    return arrays, {"own_load_n": run.scene.load, "faults": json.dumps(faults)}


def _read_law(arrays: Arrays, facts: Facts, result: Result) -> LoadMarches:
    """Return the marches at other loads, without the run's own."""
    marches = LoadMarches(result.solved_steps)
    marches.approach = dict(zip(arrays["load"].tolist(), arrays["approach"], strict=True))
    del marches.approach[facts["own_load_n"]]
    if "judging_load" in arrays:
        judging = zip(arrays["judging_load"].tolist(), arrays["judging_approach"], strict=True)
        marches.judging = dict(judging)
    marches.faults = {float(load): text for load, text in json.loads(facts["faults"]).items()}
    return marches


def _write_moving(moving: MovingRelease, run: Run) -> Group:
    """Return force [N], approach [m] and energies [J] under the moving load, or its fault."""
    facts = {"key": moving.key, "fault": moving.fault}
    arrays = {"place": run.position[: len(moving.force)], "force": moving.force}
    arrays |= {"approach": moving.approach, "motion_approach": moving.motion_approach}
    arrays |= moving.steps
    return {} if moving.fault else arrays, facts


def _read_moving(arrays: Arrays, facts: Facts, result: Result) -> MovingRelease:
    """Return the march under the moving load, or its fault."""
    if facts["fault"]:
        return MovingRelease.impossible(facts["key"], result.solved_steps, facts["fault"])
    force, motion = arrays["force"], arrays["motion_approach"]
    steps = {name: arrays[name] for name in observers.MOVING_SERIES}
    return MovingRelease(facts["key"], force, motion, arrays["approach"], steps)


def _write_passes(passes: Passes, run: Run) -> Group:
    """Return the series of all passes, and the depth [m] of the plate after the last."""
    return passes.series | {"depth": passes.depth, "sunk": passes.sunk}, {}


def _read_passes(arrays: Arrays, facts: Facts, result: Result) -> Passes:
    """Return the passes of a group, without the surface before the last."""
    return Passes({name: arrays[name] for name in PASS_SERIES}, arrays["depth"], arrays["sunk"])


def _contact_force(vibration: Vibration) -> Group:
    """Return the contact force at the samples of the sound, and its bands."""
    force = vibration.motion.force_n
    return {
        "force_time": np.arange(len(vibration.force)) / wav.SAMPLE_RATE_HZ,
        "force": vibration.load + vibration.force,
        "band": np.array(MID_HZ),
        "band_rms": vibration.force_bands,
    }, {
        "closed": int(vibration.closed),
        "minimum_n": float(force.min()),
        "maximum_n": float(force.max()),
        "time_step_s": vibration.motion.time_step_s,
    }


# Name of the group, field of the result, writer and reader.
_GROUPS: dict[str, tuple[str, Callable[[Any, Run], Group], Callable[..., Any]]] = {
    "snapshot": ("snapshot", _write_snapshot, _read_snapshot),
    "pressure_maps": ("maps", _write_maps, _read_maps),
    "events": (  # as those of a single piece
        "event_pieces",
        lambda pieces, run: (dict(run.events or {}), {}),
        lambda arrays, facts, result: {0: {name: arrays[name] for name in observers.EVENT_COLUMNS}},
    ),
    "error_estimate": ("stretches", _write_stretches, _read_stretches),
    "slow_motion": ("slow_motion", _write_film, _read_film),
    "force_law": ("load_marches", _write_law, _read_law),
    "moving_release": ("moving", _write_moving, _read_moving),
    "passes": ("passes", _write_passes, _read_passes),
}
