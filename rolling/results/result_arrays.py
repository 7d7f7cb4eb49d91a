"""The arrays of result.h5: their names, dimensions and units, from a run and into a result."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import rolling
from acoustics import wav
from acoustics.bands import MID_HZ
from rolling.check.error_cost import LEVELS
from rolling.marches.observers import (
    EVENT_COLUMNS,
    STATE_SERIES,
    STEP_SERIES,
    PressureMap,
    SlowMotion,
    Snapshot,
)
from rolling.marches.result import (
    MOVING_SERIES,
    ErrorStretches,
    LoadMarches,
    MovingRelease,
    Result,
    StretchMarch,
)
from rolling.scene import file as scene_file
from rolling.scene.scene import Scene

if TYPE_CHECKING:
    from rolling.results.run_result import Run

FORMAT = 3
Arrays = dict[str, NDArray[Any]]
# Dimensions, unit and type of each variable by its path. A step series has an entry for the step
# from each position to the next, a state series one for each position.
TABLE = {
    "step": ("step", "m", "f8"),
    "position": ("position", "m", "f8"),
    "time": ("step", "s", "f8"),
    "position_time": ("position", "s", "f8"),
    "release_energy": ("step", "J", "f8"),
    "loading_energy": ("step", "J", "f8"),
    "energy_defect": ("step", "J", "f8"),
    "speed": ("step", "m/s", "f8"),
    "release_power": ("step", "W", "f8"),
    "loading_power": ("step", "W", "f8"),
    "release_per_metre": ("step", "J/m", "f8"),
    "loading_per_metre": ("step", "J/m", "f8"),
    "approach": ("position", "m", "f8"),
    "contact_area": ("position", "m2", "f8"),
    "plastic_area": ("position", "m2", "f8"),
    "max_pressure": ("position", "Pa", "f8"),
    "max_deflection": ("position", "m", "f8"),
    "stored_energy": ("position", "J", "f8"),
    "residual": ("position", "1", "f8"),
    "iterations": ("position", "1", "f8"),
    "convolutions": ("position", "1", "f8"),
    "snapshot/along": ("along", "m", "f8"),
    "snapshot/across": ("across", "m", "f8"),
    "snapshot/pressure": ("along across", "Pa", "f8"),
    "snapshot/deflection": ("along across", "m", "f8"),
    "pressure_maps/position": ("map", "1", "i8"),
    "pressure_maps/distance": ("map", "m", "f8"),
    "pressure_maps/along": ("map", "m", "f8"),
    "pressure_maps/across": ("map", "m", "f8"),
    "pressure_maps/cell": ("map", "m", "f8"),
    "pressure_maps/rows": ("map", "1", "i8"),
    "pressure_maps/columns": ("map", "1", "i8"),
    "pressure_maps/pressure": ("map row column", "Pa", "f4"),
    "events/node": ("event axis", "1", "i4"),
    "events/first": ("event", "position", "i8"),
    "events/last": ("event", "position", "i8"),
    "events/energy": ("event", "J", "f8"),
    "events/peak": ("event", "J per step", "f8"),
    "error_estimate/first": ("stretch", "position", "i8"),
    "error_estimate/release_energy": ("stretch level stretch_step", "J", "f8"),
    "error_estimate/approach": ("stretch level stretch_place", "m", "f8"),
    "error_estimate/plastic_area": ("stretch level", "m2", "f8"),
    "slow_motion/map_position": ("map_position", "1", "i8"),
    "slow_motion/along": ("along", "m", "f8"),
    "slow_motion/across": ("across", "m", "f8"),
    "slow_motion/pressure": ("map_position along across", "Pa", "u1"),
    "slow_motion/release": ("map_position along across", "J", "u2"),
    "force_law/load": ("load", "N", "f8"),
    "force_law/place": ("place", "m", "f8"),
    "force_law/approach": ("load place", "m", "f8"),
    "force_law/judging_load": ("judging_load", "N", "f8"),
    "force_law/judging_approach": ("judging_load judging_place", "m", "f8"),
    "moving_release/place": ("place", "m", "f8"),
    "moving_release/force": ("place", "N", "f8"),
    "moving_release/approach": ("place", "m", "f8"),
    "moving_release/motion_approach": ("place", "m", "f8"),
    "moving_release/release_energy": ("place_step", "J", "f8"),
    "moving_release/loading_energy": ("place_step", "J", "f8"),
    "moving_release/energy_defect": ("place_step", "J", "f8"),
    "contact_force/force_time": ("force_time", "s", "f8"),
    "contact_force/force": ("force_time", "N", "f8"),
    "contact_force/band": ("band", "Hz", "f8"),
    "contact_force/band_rms": ("band", "N", "f8"),
    "sound/sound_time": ("sound_time", "s", "f8"),
    "sound/pressure": ("sound_time", "Pa", "f8"),
}
Group = tuple[Arrays, dict[str, Any]]  # arrays and attributes of a group


def fixed_lengths(result: Result) -> dict[str, int]:
    """Return the lengths of the dimensions that the scene of a result fixes."""
    return {
        "step": result.steps,
        "position": result.steps + 1,
        "place": result.solved_steps + 1,
        "place_step": result.solved_steps,
        "axis": 2,
        "level": len(LEVELS),
        "band": len(MID_HZ),
    }


# ---- from a run


def groups_of(run: Run) -> dict[str, Group]:
    """Return the groups of the file of a run by name; the root, with the series, has none."""
    result, sound = run.result, run.sound
    arrays = {"step": run.distance, "position": run.position}
    arrays |= {"time": run.time, "position_time": run.position_time}
    arrays |= {name: values for name, values in run.series.items() if name in TABLE}
    facts = {
        "title": f"rolling contact noise: {run.scene.name}",
        "format": FORMAT,
        "program": rolling.__version__,
        "identity": result.identity,
        "scene": scene_file.dump(_seen_from(run.folder, run.scene)),
        "load_n": run.scene.load,
        "steps": result.steps,
        "solved_steps": result.solved_steps,
        "step_m": result.step,
        "start_m": result.start,
    }
    samples = np.arange(len(sound.pressure)) / sound.sample_rate
    heard = {"sound_time": samples, "pressure": sound.pressure}
    of_sound: dict[str, Any] = {"sample_rate_hz": sound.sample_rate, "closed": int(sound.closed)}
    if sound.factor is not None:
        of_sound["factor_pa_per_w_m2"] = sound.factor
    groups = {"": (arrays, facts)} | {name: make(run) for name, make in _GROUPS.items()}
    groups["sound"] = heard, of_sound
    return {name: group for name, group in groups.items() if group != ({}, {})}


def _seen_from(folder: Path, scene: Scene) -> Scene:
    """Return a scene whose relative path to a height file starts from a folder."""
    data = scene.to_dict()
    if scene.height_path is None or Path(data["surface"]["path"]).is_absolute():
        return scene
    # Links are resolved first, because ".." of a linked folder leads elsewhere.
    heights = scene.height_path.parent.resolve() / scene.height_path.name
    data["surface"]["path"] = Path(os.path.relpath(heights, folder.resolve())).as_posix()
    return Scene.from_dict(data, folder)


def _snapshot(run: Run) -> Group:
    snapshot, spacing = run.result.snapshot, run.scene.spacing
    if snapshot is None:
        return {}, {}
    rows, columns = snapshot.pressure.shape
    return {
        "along": snapshot.along + np.arange(rows) * spacing,
        "across": snapshot.across + np.arange(columns) * spacing,
        "pressure": snapshot.pressure,
        "deflection": snapshot.deflection,
    }, {"distance_m": snapshot.distance}


def _maps(run: Run) -> Group:
    maps = [run.result.maps[position] for position in sorted(run.result.maps)]
    if not maps:
        return {}, {}
    shapes = np.array([each.pressure.shape for each in maps])
    padded = np.full((len(maps), *shapes.max(axis=0)), np.nan, dtype=np.float32)
    for block, each in zip(padded, maps, strict=True):
        block[: each.pressure.shape[0], : each.pressure.shape[1]] = each.pressure
    places = ("position", "distance", "along", "across", "cell")
    arrays = {name: np.array([getattr(each, name) for each in maps]) for name in places}
    return arrays | {"rows": shapes[:, 0], "columns": shapes[:, 1], "pressure": padded}, {}


def _events(run: Run) -> Group:
    return dict(run.events or {}), {}


def _stretches(run: Run) -> Group:
    stretches = run.result.stretches
    if stretches is None:
        return {}, {}
    firsts = sorted({first for first, _ in stretches.marches})
    marches = [[stretches.marches[first, level] for level in LEVELS] for first in firsts]
    arrays = {
        name: np.array([[getattr(march, field) for march in row] for row in marches])
        for name, field in (
            ("release_energy", "release"),
            ("approach", "approach"),
            ("plastic_area", "plastic_area"),
        )
    }
    faults = [[march.fault for march in row] for row in marches]
    return {"first": np.array(firsts)} | arrays, {"faults": json.dumps(faults)}


def _slow_motion(run: Run) -> Group:
    film = run.result.slow_motion
    if film is None:
        return {}, {}
    names = ("first", "stride", "along", "across", "cell", "pressure_unit", "release_unit")
    facts = {name: getattr(film, name) for name in names}
    if not film.pressure.size:  # its stretch could not be solved again
        return {}, facts
    rows, columns = film.pressure.shape[1:]
    return {
        "map_position": film.positions,
        "along": film.along + (np.arange(rows) + 0.5) * film.cell,
        "across": film.across + (np.arange(columns) + 0.5) * film.cell,
        "pressure": film.pressure,
        "release": film.release,
    }, facts


def _places(run: Run) -> NDArray[np.float64]:
    """Return the positions of a lap [m]."""
    result = run.result
    return np.asarray(result.start + np.arange(result.solved_steps + 1) * result.step)


def _force_law(run: Run) -> Group:
    """Return the approach at each load, the scene's own included."""
    marches = run.result.load_marches
    if marches is None:
        return {}, {}
    by_load = marches.approach | {run.scene.load: run.result.series["approach"]}
    arrays = {
        "load": np.array(sorted(by_load)),
        "place": _places(run),
        "approach": np.array([by_load[load] for load in sorted(by_load)]),
    }
    if marches.judging:
        between = sorted(marches.judging)
        arrays["judging_load"] = np.array(between)
        arrays["judging_approach"] = np.array([marches.judging[load] for load in between])
    faults = {repr(load): marches.faults[load] for load in sorted(marches.faults)}
    return arrays, {"faults": json.dumps(faults)}


def _moving(run: Run) -> Group:
    moving = run.result.moving
    if moving is None:
        return {}, {}
    facts = {"key": moving.key, "fault": moving.fault}
    if moving.fault:
        return {}, facts
    arrays = {"place": _places(run), "force": moving.force, "approach": moving.approach}
    arrays |= {"motion_approach": moving.motion_approach, **moving.steps}
    return arrays, facts


def _contact_force(run: Run) -> Group:
    vibration = run.vibration
    if vibration is None:
        return {}, {}
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


_GROUPS = {
    "snapshot": _snapshot,
    "pressure_maps": _maps,
    "events": _events,
    "error_estimate": _stretches,
    "slow_motion": _slow_motion,
    "force_law": _force_law,
    "moving_release": _moving,
    "contact_force": _contact_force,
}


# ---- into a result


def fill(result: Result, load: float, groups: dict[str, Group]) -> None:
    """Fill an empty result with the arrays of the groups; `load` [N] is the run's own."""
    series, _ = groups[""]
    for name in (*STEP_SERIES, *STATE_SERIES):
        if name in TABLE:
            count = len(result.series[name])
            result.series[name] = np.array(series[name][:count])
    for group, (arrays, facts) in groups.items():
        if group in _READERS:
            _READERS[group](result, load, arrays, facts)


def _read_snapshot(result: Result, load: float, arrays: Arrays, facts: dict[str, Any]) -> None:
    corner = float(arrays["along"][0]), float(arrays["across"][0])
    result.snapshot = Snapshot(
        facts["distance_m"], *corner, arrays["pressure"], arrays["deflection"]
    )


def _read_maps(result: Result, load: float, arrays: Arrays, facts: dict[str, Any]) -> None:
    names = ("position", "distance", "along", "across", "cell")
    places = zip(*(arrays[name].tolist() for name in names), strict=True)
    shapes = zip(arrays["rows"].tolist(), arrays["columns"].tolist(), strict=True)
    for place, (rows, columns), padded in zip(places, shapes, arrays["pressure"], strict=True):
        result.maps[place[0]] = PressureMap(*place, padded[:rows, :columns].copy())


def _read_events(result: Result, load: float, arrays: Arrays, facts: dict[str, Any]) -> None:
    result.event_pieces = {0: {name: arrays[name] for name in EVENT_COLUMNS}}


def _read_stretches(result: Result, load: float, arrays: Arrays, facts: dict[str, Any]) -> None:
    release, approach, areas = (
        arrays[name] for name in ("release_energy", "approach", "plastic_area")
    )
    result.stretches = ErrorStretches(release.shape[2])
    for row, first in enumerate(arrays["first"].tolist()):
        for column, level in enumerate(LEVELS):
            at, fault = (row, column), json.loads(facts["faults"])[row][column]
            march = StretchMarch(release[at], approach[at], float(areas[at]), 0.0, fault)
            result.stretches.marches[first, level] = march


def _read_film(result: Result, load: float, arrays: Arrays, facts: dict[str, Any]) -> None:
    maps: dict[str, Any] = {name: arrays[name] for name in ("pressure", "release") if arrays}
    result.slow_motion = SlowMotion(**facts, **maps) if arrays else SlowMotion.none()


def _read_law(result: Result, load: float, arrays: Arrays, facts: dict[str, Any]) -> None:
    marches = LoadMarches(result.solved_steps)
    marches.approach = dict(zip(arrays["load"].tolist(), arrays["approach"], strict=True))
    del marches.approach[load]
    if "judging_load" in arrays:
        judging = zip(arrays["judging_load"].tolist(), arrays["judging_approach"], strict=True)
        marches.judging = dict(judging)
    marches.faults = {float(key): text for key, text in json.loads(facts["faults"]).items()}
    result.load_marches = marches


def _read_moving(result: Result, load: float, arrays: Arrays, facts: dict[str, Any]) -> None:
    if facts["fault"]:
        impossible = MovingRelease.impossible
        result.moving = impossible(facts["key"], result.solved_steps, facts["fault"])
        return
    steps = {name: arrays[name] for name in MOVING_SERIES}
    result.moving = MovingRelease(
        facts["key"], arrays["force"], arrays["motion_approach"], arrays["approach"], steps
    )


_READERS = {
    "snapshot": _read_snapshot,
    "pressure_maps": _read_maps,
    "events": _read_events,
    "error_estimate": _read_stretches,
    "slow_motion": _read_film,
    "force_law": _read_law,
    "moving_release": _read_moving,
}
