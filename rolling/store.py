"""Result files: written whole or not at all, readable at every moment of a run.

`result.h5` holds the series of the whole run (NaN where not solved yet) with named dimensions and units; it opens in xarray.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from rolling.recovery import join_events
from rolling.run_folder import FolderError
from rolling.scenario import Track
from rolling.simulate import STATE_SERIES, STEP_SERIES, Piece, PressureMap, Snapshot

Array = NDArray[np.float64]

UNITS = {
    "release_energy": "J",
    "loading_energy": "J",
    "energy_defect": "J",
    "step_time": "s",
    "release_power": "W",
    "loading_power": "W",
    "release_per_metre": "J/m",
    "loading_per_metre": "J/m",
    "approach": "m",
    "contact_area": "m2",
    "plastic_area": "m2",
    "max_pressure": "Pa",
    "max_deflection": "m",
    "stored_energy": "J",
    "residual": "1",
    "iterations": "1",
    "convolutions": "1",
}


@dataclass
class Result:
    """Series of a run: of one lap of the track or less, which is all that is ever solved; NaN where not solved yet.

    steps : steps of the whole run; `solved_steps` of them are different, the rest go round again.
    maps : pressure maps along the track, by position.
    """

    steps: int
    solved_steps: int
    step: float
    start: float
    series: dict[str, Array]
    snapshot: Snapshot | None = None
    maps: dict[int, PressureMap] = field(default_factory=dict)
    event_pieces: dict[int, dict[str, NDArray[Any]]] = field(default_factory=dict)

    @classmethod
    def empty(cls, track: Track, start: float) -> Result:
        solved = track.solved_steps
        series = {name: np.full(solved, np.nan) for name in STEP_SERIES}
        series |= {name: np.full(solved + 1, np.nan) for name in STATE_SERIES}
        return cls(track.steps, solved, track.step, start, series)

    def add(self, piece: Piece) -> None:
        for name, values in piece.steps.items():
            self.series[name][piece.first : piece.last] = values
        for name, values in piece.states.items():
            self.series[name][piece.last + 1 - len(values) : piece.last + 1] = values
        self.snapshot = piece.snapshot or self.snapshot
        self.maps |= {one.position: one for one in piece.maps}
        if piece.events is not None:
            self.event_pieces[piece.first] = piece.events

    @property
    def complete(self) -> bool:
        return not np.isnan(self.series["release_energy"]).any()

    @property
    def done_steps(self) -> int:
        """Length of the unbroken beginning that is solved."""
        gaps = np.flatnonzero(np.isnan(self.series["release_energy"]))
        return int(gaps[0]) if len(gaps) else self.steps

    def whole(self, name: str) -> Array:
        """A series over the whole run, laps repeated."""
        values = self.series[name]
        if name in STEP_SERIES:
            return values[np.arange(self.steps) % self.solved_steps]
        return values[np.append(np.arange(self.steps) % self.solved_steps, (self.steps - 1) % self.solved_steps + 1)]

    def events(self) -> dict[str, NDArray[Any]] | None:
        """The table of recovery events of what is solved; None when none were asked for."""
        if not self.event_pieces:
            return None
        return join_events([self.event_pieces[first] for first in sorted(self.event_pieces)])


def save(path: Path, result: Result, speed: Array, name: str) -> None:
    """Write result.h5; `speed` [m/s] at the middle of each step of the whole run."""
    partial = path.with_name(f".{path.name}.partial")
    try:
        with h5py.File(partial, "w") as file:
            file.attrs.update(
                title=f"rolling contact noise: {name}",
                steps=result.steps,
                solved_steps=result.solved_steps,
                step_m=result.step,
                start_m=result.start,
                complete=result.complete,
            )
            middles = result.start + (np.arange(result.steps) + 0.5) * result.step
            ends = result.start + np.arange(result.steps + 1) * result.step
            for dimension, distances in (("step", middles), ("position", ends)):
                scale = file.create_dataset(dimension, data=distances)
                scale.attrs.update(units="m", long_name=f"distance along the track, {dimension}")
                scale.make_scale(dimension)
            derived = {
                f"{kind}_{name}": result.whole(f"{kind}_energy") * factor
                for kind in ("release", "loading")
                for name, factor in (("per_metre", 1 / result.step), ("power", speed / result.step))
            }
            for name, values in [(n, result.whole(n)) for n in STEP_SERIES + STATE_SERIES] + list(derived.items()):
                data = file.create_dataset(name, data=values)
                data.attrs["units"] = UNITS[name]
                data.dims[0].attach_scale(file["step" if len(values) == result.steps else "position"])
            if result.snapshot is not None:
                group = file.create_group("snapshot")
                group.attrs.update(
                    distance_m=result.snapshot.distance, along_m=result.snapshot.along, across_m=result.snapshot.across
                )
                group["pressure"], group["deflection"] = result.snapshot.pressure, result.snapshot.deflection
                group["pressure"].attrs["units"], group["deflection"].attrs["units"] = "Pa", "m"
            _save_maps(file, [result.maps[position] for position in sorted(result.maps)])
            _save_events(file, result)
        partial.replace(path)
    except (OSError, RuntimeError) as error:  # h5py reports a full disk as either
        partial.unlink(missing_ok=True)
        raise OSError(f"{path}: could not be written ({error})") from error


def _save_maps(file: h5py.File, maps: list[PressureMap]) -> None:
    if not maps:
        return
    group = file.create_group("pressure_maps")
    for name, values, unit in (
        ("position", [one.position for one in maps], "1"),
        ("distance", [one.distance for one in maps], "m"),
        ("along", [one.along for one in maps], "m"),
        ("across", [one.across for one in maps], "m"),
        ("cell", [one.cell for one in maps], "m"),
        ("shape", [one.pressure.shape for one in maps], "1"),
    ):
        group[name] = values
        group[name].attrs["units"] = unit
    # One after the other: each is as large as its contact.
    flat = np.concatenate([one.pressure.ravel() for one in maps])
    group.create_dataset("pressure", data=flat, compression="gzip", shuffle=True).attrs["units"] = "Pa"


def _load_maps(group: h5py.Group) -> dict[int, PressureMap]:
    shapes, flat = group["shape"][:], group["pressure"][:]
    ends = np.cumsum(shapes.prod(axis=1))
    columns = (group[name][:].tolist() for name in ("position", "distance", "along", "across", "cell"))
    pressures = [flat[end - np.prod(shape) : end].reshape(shape) for shape, end in zip(shapes, ends, strict=True)]
    return {row[0]: PressureMap(*row) for row in zip(*columns, pressures, strict=True)}


def _save_events(file: h5py.File, result: Result) -> None:
    if not result.event_pieces:
        return
    if result.complete:
        tables = {"events": result.events() or {}}
    else:  # as the pieces left them, to be joined when all are there
        tables = {f"event_pieces/{first}": columns for first, columns in result.event_pieces.items()}
    units = {"node": "1", "first": "position", "last": "position", "energy": "J", "peak": "J per step"}
    for name, columns in tables.items():
        group = file.create_group(name)
        for column, values in columns.items():
            group[column] = values
            group[column].attrs["units"] = units[column]


def _states(file: h5py.File, name: str, count: int) -> Array:
    """Read a state series; NaN for the greatest deflection, which files of version 0.1.0 lack."""
    if name == "max_deflection" and name not in file:
        return np.full(count, np.nan)
    return np.asarray(file[name][:count], dtype=float)


def load(path: Path) -> Result:
    """Read result.h5.

    Raises
    ------
    FolderError : missing, or not such a file.
    """
    try:
        with h5py.File(path, "r") as file:
            solved = int(file.attrs["solved_steps"])
            result = Result(
                steps=int(file.attrs["steps"]),
                solved_steps=solved,
                step=float(file.attrs["step_m"]),
                start=float(file.attrs["start_m"]),
                series={name: file[name][:solved] for name in STEP_SERIES}
                | {name: _states(file, name, solved + 1) for name in STATE_SERIES},
            )
            if "snapshot" in file:
                group = file["snapshot"]
                distance, along, across = (float(group.attrs[name]) for name in ("distance_m", "along_m", "across_m"))
                result.snapshot = Snapshot(distance, along, across, group["pressure"][:], group["deflection"][:])
            if "pressure_maps" in file:
                result.maps = _load_maps(file["pressure_maps"])
            for first, group in file.get("event_pieces", {}).items():
                result.event_pieces[int(first)] = {column: values[:] for column, values in group.items()}
            if "events" in file:
                result.event_pieces[0] = {column: values[:] for column, values in file["events"].items()}
            return result
    except (OSError, KeyError) as error:
        raise FolderError(f"{path}: not a result of this program ({error})") from error
