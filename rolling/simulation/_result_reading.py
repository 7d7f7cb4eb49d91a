"""Reading of result.h5, format 2 or older, with checks of every type, shape and range.

The parts of the file are also checked against each other. Files of version 0.1.0 and its direct
successors have no format number and no identity, store their maps one after the other, and have a
group for each piece of events.
"""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import fields
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from rolling._typing import Array
from rolling.check.error_cost import LEVELS
from rolling.scene.identity import STEPS, Identity
from rolling.simulation._result_layout import FORMAT
from rolling.simulation.load_marches import LoadMarches
from rolling.simulation.moving_load import MOVING_SERIES, MovingRelease
from rolling.simulation.result import Result
from rolling.simulation.simulate import STATE_SERIES, STEP_SERIES, PressureMap, Snapshot
from rolling.simulation.slow_motion import SlowMotion
from rolling.simulation.stretches import ErrorStretches, March, Trial

MOST_STEPS = 10**9
SIGNED = {"approach", "energy_defect"}  # no other series is ever negative
WHOLE = {"iterations", "convolutions"}
# Energy of all events and released energy are the same sum in another order.
SUM_TOLERANCE = 1e-6


class Damage(ValueError):
    """The first fault of a file and its place, on a single line."""


def read(file: h5py.File) -> Result:
    """Read and check a result.

    Raises
    ------
    Damage : the first fault; the message begins with its field. h5py raises its own errors for
        files that HDF5 cannot read.
    """
    steps = _number(file, "steps", 1, MOST_STEPS)
    solved = _number(file, "solved_steps", 1, steps)
    step, start = _real(file, "step_m"), _real(file, "start_m")
    if step <= 0:
        raise Damage(f"step_m: {step}, a step is longer than 0")
    result = Result(steps, solved, step, start, _series(file, steps, solved))
    result.identity = _identity(file, result)
    done = _checked_series(result)
    result.snapshot = _snapshot(file)
    result.maps = _maps(file, result)
    result.event_pieces = _events(file, result)
    _check_events(result, done)
    result.stretches = _stretches(file, result)
    result.trial = _trial(file)
    result.slow_motion = _slow_motion(file, result)
    result.load_marches = _load_marches(file, result)
    result.moving = _moving_release(file, result)
    complete = _attribute(file, "complete")
    if not isinstance(complete, bool | np.bool_) or bool(complete) != result.complete:
        raise Damage(
            f"complete: got {_shown(complete)}, {int((~done).sum())} of {solved} steps are not "
            "solved"
        )
    return result


# ---- single values


def format_of(file: h5py.File) -> int:
    """Read the format of a file, or return 1 for a file of version 0.1.0, which has none."""
    return _number(file, "format", 1, 2**31) if "format" in file.attrs else 1


def _number(group: h5py.Group, name: str, least: int, most: int) -> int:
    value = _attribute(group, name)
    if (
        not isinstance(value, int | np.integer)
        or isinstance(value, bool)
        or not least <= value <= most
    ):
        raise Damage(
            f"{name}: got {_shown(value)}, allowed is a whole number from {least} to {most}"
        )
    return int(value)


def _real(group: h5py.Group, name: str) -> float:
    value = _attribute(group, name)
    if not isinstance(value, int | float | np.integer | np.floating) or not math.isfinite(value):
        raise Damage(f"{_path(group, name)}: got {_shown(value)}, allowed is a number")
    return float(value)


def _text(group: h5py.Group, name: str) -> str:
    value = _attribute(group, name)
    if not isinstance(value, str):
        raise Damage(f"{name}: got {_shown(value)}, allowed is text")
    return value


def _attribute(group: h5py.Group, name: str) -> Any:
    if name not in group.attrs:
        raise Damage(f"{_path(group, name)}: missing")
    return group.attrs[name]


def _array(group: h5py.Group, name: str, kinds: str, shape: tuple[int | None, ...]) -> NDArray[Any]:
    """Read values of a kind (numpy's letters) and of a shape.

    None in the shape allows any length.
    """
    where = _path(group, name)
    link = group.get(name, getlink=True)
    if link is None:
        raise Damage(f"{where}: missing")
    # links to other files are refused
    data = group[name] if isinstance(link, h5py.HardLink) else None
    if not isinstance(data, h5py.Dataset) or data.is_virtual or data.external:
        raise Damage(f"{where}: got something else, allowed is a dataset")
    if data.dtype.kind not in kinds or data.shape is None or len(data.shape) != len(shape):
        raise Damage(
            f"{where}: got {data.dtype} of shape {data.shape}, "
            f"allowed are numbers in {len(shape)} dimensions"
        )
    if any(want is not None and got != want for got, want in zip(data.shape, shape, strict=True)):
        wanted = tuple("any" if want is None else want for want in shape)
        raise Damage(f"{where}: got shape {data.shape}, allowed is {wanted}")
    return np.asarray(data[()])


def _refuse(where: str, bad: NDArray[np.bool_], fault: str) -> None:
    """Raise a fault of values with the index of the first bad value."""
    if bad.any():
        first = np.argwhere(bad)[0].tolist()
        place = first[0] if len(first) == 1 else tuple(first)
        raise Damage(f"{where}: {int(bad.sum())} values {fault}, the first at {place}")


def _path(group: h5py.Group, name: str) -> str:
    return f"{group.name.strip('/')}/{name}".lstrip("/")


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


# ---- identity


def _identity(file: h5py.File, result: Result) -> Identity | None:
    if format_of(file) < FORMAT:
        return None
    physics, defaults = (_values(file, name) for name in ("physics", "physics_defaults"))
    heights = _text(file, "heights_sha256") if "heights_sha256" in file.attrs else None
    if hashlib.sha256(_text(file, "physics").encode()).hexdigest() != _text(file, "physics_sha256"):
        raise Damage("physics_sha256: not the digest of physics")
    if physics.get(STEPS) != result.steps:
        raise Damage(f"steps: got {result.steps}, the physics has {_shown(physics.get(STEPS))}")
    return Identity(physics, defaults, heights)


def _values(file: h5py.File, name: str) -> dict[str, Any]:
    try:
        values = json.loads(_text(file, name))
    except ValueError as error:
        raise Damage(f"{name}: not JSON ({error})") from error
    if not isinstance(values, dict):
        raise Damage(f"{name}: got {_shown(values)}, allowed are values by key")
    return values


# ---- series


def _series(file: h5py.File, steps: int, solved: int) -> dict[str, Array]:
    """Read the series of the solved part."""
    series = {name: _array(file, name, "f", (steps,))[:solved] for name in STEP_SERIES}
    for name in STATE_SERIES:
        # version 0.1.0 did not write this series
        if name == "max_deflection" and name not in file and format_of(file) < FORMAT:
            series[name] = np.full(solved + 1, np.nan)
        else:
            series[name] = _array(file, name, "f", (steps + 1,))[: solved + 1]
    return {name: values.astype(np.float64, copy=solved < steps) for name, values in series.items()}


def _checked_series(result: Result) -> NDArray[np.bool_]:
    """Check the series against their ranges and each other, and return the mask of solved steps."""
    done = ~np.isnan(result.series["release_energy"])
    # A state belongs to the step before it, and state 0 to the first step.
    states = np.append(done[0], done)
    for name, values in result.series.items():
        solved = done if name in STEP_SERIES else states
        # A resumed run of version 0.1.0 has this series only from the resumed step on.
        if name != "max_deflection":
            _refuse(name, np.isnan(values) & solved, "are NaN where release_energy is solved")
        _refuse(name, ~np.isnan(values) & ~solved, "are there where release_energy is NaN")
        _refuse(name, np.isinf(values), "are infinite")
        if name not in SIGNED:
            _refuse(name, values < 0, "are negative")
        if name in WHOLE:
            _refuse(name, ~np.isnan(values) & (values != np.floor(values)), "are no whole numbers")
    return done


# ---- snapshot and pressure maps


def _group(file: h5py.File, name: str) -> h5py.Group | None:
    if name not in file:
        return None
    group = file[name] if isinstance(file.get(name, getlink=True), h5py.HardLink) else None
    if not isinstance(group, h5py.Group):
        raise Damage(f"{name}: got something else, allowed is a group")
    return group


def _snapshot(file: h5py.File) -> Snapshot | None:
    group = _group(file, "snapshot")
    if group is None:
        return None
    distance, along, across = (_real(group, name) for name in ("distance_m", "along_m", "across_m"))
    pressure = _array(group, "pressure", "f", (None, None))
    deflection = _array(group, "deflection", "f", pressure.shape)
    for name, values in (("pressure", pressure), ("deflection", deflection)):
        if not values.size:
            raise Damage(f"snapshot/{name}: empty")
        _refuse(f"snapshot/{name}", ~np.isfinite(values), "are not finite")
    _refuse("snapshot/pressure", pressure < 0, "are negative")
    return Snapshot(
        distance, along, across, pressure.astype(np.float64), deflection.astype(np.float64)
    )


def _maps(file: h5py.File, result: Result) -> dict[int, PressureMap]:
    group = _group(file, "pressure_maps")
    if group is None:
        return {}
    positions = _array(group, "position", "iu", (None,))
    count = len(positions)
    places = {
        name: _array(group, name, "f", (count,)) for name in ("distance", "along", "across", "cell")
    }
    for name, values in places.items():
        _refuse(f"pressure_maps/{name}", ~np.isfinite(values), "are not finite")
    _refuse("pressure_maps/cell", places["cell"] <= 0, "are not greater than 0")
    _refuse(
        "pressure_maps/position",
        (positions < 0) | (positions > result.solved_steps),
        "are not on the track",
    )
    _refuse(
        "pressure_maps/position",
        np.diff(positions.astype(np.int64), prepend=-1) <= 0,
        "do not increase",
    )
    unsolved = np.isnan(result.series["approach"][positions.astype(np.int64)])
    _refuse("pressure_maps/position", unsolved, "are not solved")
    expected = result.start + positions * result.step
    wrong = np.abs(places["distance"] - expected) > 1e-6 * result.step + 1e-9 * np.abs(expected)
    _refuse("pressure_maps/distance", wrong, "are not the distances of their positions")
    pressures = (
        _padded_pressures(group, count) if "rows" in group else _flat_pressures(group, count)
    )
    for values in pressures:
        _refuse("pressure_maps/pressure", ~np.isfinite(values), "are not finite within a map")
        _refuse("pressure_maps/pressure", values < 0, "are negative")
    rows = zip(
        positions.tolist(), *(values.tolist() for values in places.values()), pressures, strict=True
    )
    return {row[0]: PressureMap(*row) for row in rows}


def _padded_pressures(group: h5py.Group, count: int) -> list[NDArray[np.float32]]:
    """Read the maps of format 2, which are padded with NaN to a common size."""
    padded = _array(group, "pressure", "f", (count, None, None)).astype(np.float32, copy=False)
    sizes = [_array(group, name, "iu", (count,)).astype(np.int64) for name in ("rows", "columns")]
    for name, values, most in zip(("rows", "columns"), sizes, padded.shape[1:], strict=True):
        _refuse(
            f"pressure_maps/{name}", (values < 1) | (values > most), f"are not from 1 to {most}"
        )
    shapes = list(zip(*(values.tolist() for values in sizes), strict=True))
    outside = ~np.isnan(padded)
    for block, (rows, columns) in zip(outside, shapes, strict=True):
        block[:rows, :columns] = False
    _refuse("pressure_maps/pressure", outside, "stand outside their map")
    return [
        block[:rows, :columns].copy() for block, (rows, columns) in zip(padded, shapes, strict=True)
    ]


def _flat_pressures(group: h5py.Group, count: int) -> list[NDArray[np.float32]]:
    """Read the maps of older formats, which are stored one after the other."""
    shapes = _array(group, "shape", "iu", (count, 2)).astype(np.int64)
    flat = _array(group, "pressure", "f", (None,)).astype(np.float32, copy=False)
    _refuse(
        "pressure_maps/shape", (shapes < 1) | (shapes > flat.size), f"are not from 1 to {flat.size}"
    )
    sizes = [rows * columns for rows, columns in shapes.tolist()]
    if sum(sizes) != flat.size:
        raise Damage(
            f"pressure_maps/pressure: got {flat.size} values, the shapes have {sum(sizes)}"
        )
    blocks = np.split(flat, np.cumsum(sizes)[:-1])
    return [block.reshape(shape) for block, shape in zip(blocks, shapes.tolist(), strict=True)]


# ---- events


def _events(file: h5py.File, result: Result) -> dict[int, dict[str, NDArray[Any]]]:
    """Read the tables of events by the first position of their piece.

    A complete run has a single table.
    """
    whole, parts = _group(file, "events"), _group(file, "event_pieces")
    if whole is not None and parts is not None:
        raise Damage("events: there beside event_pieces, allowed is one of them")
    if whole is not None:
        return {0: _table(whole)}
    if parts is None:
        return {}
    if "piece_first" not in parts:  # older formats have a group for each piece
        pieces = {}
        for name in parts:
            part = _group(file, f"event_pieces/{name}")
            if part is None or not (name.isascii() and name.isdigit()):
                raise Damage(f"event_pieces/{name}: not the first position of a piece")
            pieces[int(name)] = _table(part)
        return pieces
    table = _table(parts)
    firsts = _array(parts, "piece_first", "iu", (None,)).astype(np.int64)
    counts = _array(parts, "piece_events", "iu", (len(firsts),)).astype(np.int64)
    _refuse("event_pieces/piece_first", np.diff(firsts, prepend=-1) <= 0, "do not increase")
    _refuse(
        "event_pieces/piece_events",
        (counts < 0) | (counts > table["energy"].size),
        "are not possible",
    )
    if int(counts.sum()) != table["energy"].size:
        raise Damage(
            f"event_pieces/piece_events: got {int(counts.sum())} events, "
            f"the table has {table['energy'].size}"
        )
    ends = np.cumsum(counts)
    return {
        first: {name: column[end - count : end] for name, column in table.items()}
        for first, end, count in zip(firsts.tolist(), ends.tolist(), counts.tolist(), strict=True)
    }


def _table(group: h5py.Group) -> dict[str, NDArray[Any]]:
    where = group.name.strip("/")
    energy = _array(group, "energy", "f", (None,))
    count = energy.size
    table: dict[str, NDArray[Any]] = {
        "node": _array(group, "node", "i", (count, 2)).astype(np.int32),
        "first": _array(group, "first", "i", (count,)).astype(np.int64),
        "last": _array(group, "last", "i", (count,)).astype(np.int64),
        "energy": energy.astype(np.float64),
        "peak": _array(group, "peak", "f", (count,)).astype(np.float64),
    }
    for name in ("energy", "peak"):
        _refuse(
            f"{where}/{name}",
            ~(np.isfinite(table[name]) & (table[name] > 0)),
            "are not greater than 0",
        )
    _refuse(
        f"{where}/peak",
        table["peak"] > table["energy"] * (1 + SUM_TOLERANCE),
        "are greater than the event's energy",
    )
    _refuse(f"{where}/node", table["node"] < 0, "are negative")
    _refuse(f"{where}/last", table["last"] <= table["first"], "are not after the first position")
    return table


def _check_events(result: Result, done: NDArray[np.bool_]) -> None:
    """Compare the events with the solved steps."""
    for first, table in result.event_pieces.items():
        where = "events" if first == 0 and result.complete else f"event_pieces/{first}"
        if first >= result.solved_steps or not done[first]:
            raise Damage(f"{where}: step {first} is not solved")
        outside = (table["first"] < first) | (table["last"] > result.solved_steps)
        _refuse(f"{where}/first", outside, "are not on the piece")
    asked = result.identity is not None and result.identity.physics.get("recovery.events") is True
    if asked and done.any() and not result.event_pieces:
        raise Damage("events: missing, the physics says that they were recorded")
    if result.event_pieces:
        energy = math.fsum(float(table["energy"].sum()) for table in result.event_pieces.values())
        released = float(result.series["release_energy"][done].sum())
        if not math.isclose(energy, released, rel_tol=SUM_TOLERANCE):
            raise Damage(f"events: their energy is {energy:.6g} J, {released:.6g} J were released")


# ---- stretches of the error estimate


def _stretches(file: h5py.File, result: Result) -> ErrorStretches | None:
    group = _group(file, "error_estimate")
    if group is None:
        return None
    if (levels := _text(group, "levels")) != " ".join(LEVELS):
        raise Damage(f"error_estimate/levels: got {_shown(levels)}, allowed is {' '.join(LEVELS)}")
    firsts = _array(group, "first", "iu", (None,)).astype(np.int64)
    shape = len(firsts), len(LEVELS)
    release = _array(group, "release_energy", "f", (*shape, None))
    others = {name: _array(group, name, "f", shape) for name in ("plastic_area", "seconds")}
    steps = release.shape[2]
    outside = (firsts < 0) | (firsts + steps > result.solved_steps)
    _refuse("error_estimate/first", outside, "are not on the track")
    _refuse("error_estimate/first", np.diff(firsts, prepend=-1) <= 0, "do not increase")
    done, faults = ~np.isnan(others["seconds"]), _march_faults(group)
    for name, values in (("release_energy", release), *others.items()):
        _refuse(f"error_estimate/{name}", values < 0, "are negative")
        _refuse(f"error_estimate/{name}", np.isinf(values), "are infinite")
    approach = np.full((*shape, steps + 1), np.nan)
    if "approach" in group:  # in scenes with dynamics
        approach = _array(group, "approach", "f", approach.shape).astype(np.float64)
    _refuse("error_estimate/approach", np.isinf(approach), "are infinite")
    stretches = ErrorStretches(steps)
    for row, column in np.argwhere(done).tolist():
        first, level = int(firsts[row]), LEVELS[column]
        fault = faults.get(f"{first} {level}", "")
        numbers = release[row, column].astype(np.float64)
        if not fault and np.isnan(numbers).any():
            raise Damage(f"error_estimate/release_energy: NaN in a march at {(row, column)}")
        area, seconds = (float(values[row, column]) for values in others.values())
        places = approach[row, column]
        kept = np.empty(0) if np.isnan(places).any() else places
        stretches.add(March(first, level, numbers, area, seconds, fault, kept))
    return stretches


def _march_faults(group: h5py.Group) -> dict[str, str]:
    """Read the reasons of failed marches, by first position and level."""
    try:
        faults = json.loads(_text(group, "faults"))
    except ValueError as error:
        raise Damage(f"error_estimate/faults: not JSON ({error})") from error
    if not isinstance(faults, dict) or not all(isinstance(text, str) for text in faults.values()):
        raise Damage(f"error_estimate/faults: got {_shown(faults)}, allowed are texts by march")
    return faults


# ---- trial of the tolerance


def _trial(file: h5py.File) -> Trial | None:
    """Read the choice of a tolerance; None where the scene gave a number."""
    if "tolerance_trial" not in file.attrs:
        return None
    values = _values(file, "tolerance_trial")
    kinds = {field.name: str(field.type).split(" | ") for field in fields(Trial)}
    names = {float: "float", int: "int", str: "str", type(None): "None"}
    for name, kind in kinds.items():
        if name not in values or names.get(type(values[name])) not in kind:
            raise Damage(f"tolerance_trial: got {_shown(values.get(name))} for {name}")
    return Trial(**{name: values[name] for name in kinds})


# ---- slow motion


def _slow_motion(file: h5py.File, result: Result) -> SlowMotion | None:
    group = _group(file, "slow_motion")
    if group is None:
        return None
    positions = _array(group, "map_position", "iu", (None,)).astype(np.int64)
    apart = np.diff(positions)
    if len(positions) < 2 or apart[0] < 1 or (apart != apart[0]).any():
        raise Damage("slow_motion/map_position: not evenly apart")
    outside = (positions < 0) | (positions > result.solved_steps)
    _refuse("slow_motion/map_position", outside, "are not on the track")
    cell = _real(group, "cell_m")
    if cell <= 0:
        raise Damage(f"slow_motion/cell_m: {cell}, a cell is longer than 0")
    pressure = _array(group, "pressure", "u", (len(positions), None, None))
    release = _array(group, "release", "u", pressure.shape)
    if not pressure.size:
        raise Damage("slow_motion/pressure: empty")
    corner = [
        float(_array(group, name, "f", (count,))[0]) - cell / 2
        for name, count in zip(("along", "across"), pressure.shape[1:], strict=True)
    ]
    units = [_unit(group[name]) for name in ("pressure", "release")]
    return SlowMotion(
        int(positions[0]),
        int(apart[0]),
        corner[0],
        corner[1],
        cell,
        pressure.astype(np.uint8, copy=False),
        units[0],
        release.astype(np.uint16, copy=False),
        units[1],
    )


def _unit(data: h5py.Dataset) -> float:
    """Read the unit of packed values."""
    unit = data.attrs.get("scale_factor")
    if not isinstance(unit, float | np.floating) or not math.isfinite(unit) or unit <= 0:
        raise Damage(f"{data.name.lstrip('/')}: scale_factor {_shown(unit)}, allowed is above 0")
    return float(unit)


# ---- marches at other loads


def _load_marches(file: h5py.File, result: Result) -> LoadMarches | None:
    group = _group(file, "force_law")
    if group is None:
        return None
    loads = _array(group, "load", "f", (None,)).astype(np.float64)
    shape = len(loads), result.solved_steps + 1
    approach = _array(group, "approach", "f", shape).astype(np.float64)
    _refuse("force_law/load", ~(loads > 0) | ~np.isfinite(loads), "are not greater than 0")
    _refuse("force_law/load", np.diff(loads, prepend=0.0) <= 0, "do not increase")
    _refuse("force_law/approach", np.isinf(approach), "are infinite")
    complete = _attribute(group, "complete")
    if not isinstance(complete, bool | np.bool_):
        raise Damage(f"force_law/complete: got {_shown(complete)}, allowed is true or false")
    if complete and np.isnan(approach).any():
        raise Damage("force_law/approach: NaN in marches that are complete")
    seconds = _real(group, "seconds")
    marches = LoadMarches(result.solved_steps, seconds=seconds, complete=bool(complete))
    marches.fault = _text(group, "fault")
    own = result.identity.physics.get("rolling.load_n") if result.identity else None
    if own not in loads.tolist():
        raise Damage(f"force_law/load: the load of the run, {_shown(own)} N, is missing")
    marches.approach = {
        load: values for load, values in zip(loads.tolist(), approach, strict=True) if load != own
    }
    if "judging_load" in group:
        between = _array(group, "judging_load", "f", (None,)).astype(np.float64)
        judging = _array(group, "judging_approach", "f", (len(between), None)).astype(np.float64)
        _refuse("force_law/judging_approach", ~np.isfinite(judging), "are not finite")
        if judging.shape[1] > result.solved_steps + 1:
            raise Damage("force_law/judging_approach: longer than the track")
        marches.judging = dict(zip(between.tolist(), judging, strict=True))
    return marches


def _moving_release(file: h5py.File, result: Result) -> dict[str, MovingRelease]:
    group = _group(file, "moving_release")
    if group is None:
        return {}
    count, key = result.solved_steps, _text(group, "key")
    if fault := _text(group, "fault") if "fault" in group.attrs else "":
        return {key: MovingRelease.impossible(count, fault)}
    force, approach, of_motion = (
        _array(group, name, "f", (count + 1,)).astype(np.float64)
        for name in ("force", "approach", "motion_approach")
    )
    steps = {name: _array(group, name, "f", (count,)).astype(np.float64) for name in MOVING_SERIES}
    _refuse("moving_release/force", ~(force > 0) | ~np.isfinite(force), "are not greater than 0")
    _refuse("moving_release/motion_approach", ~np.isfinite(of_motion), "are not finite")
    _refuse("moving_release/release_energy", steps["release_energy"] < 0, "are negative")
    for name, values in steps.items():
        _refuse(f"moving_release/{name}", np.isinf(values), "are infinite")
    return {key: MovingRelease(force, of_motion, approach, steps)}
