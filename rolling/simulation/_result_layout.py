"""The layout of result.h5, format 2: a netCDF-4 tree with named dimensions and units.

The root holds the series along the track. The groups are snapshot, pressure_maps, events
(event_pieces while steps are missing), error_estimate, slow_motion, force_law, contact_force and
sound.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from acoustics import wav
from acoustics.bands import MID_HZ
from rolling import __version__
from rolling.check.error_cost import LEVELS
from rolling.scene.identity import canonical
from rolling.scene.scene import Scene
from rolling.scene.surfaces import Gaussian
from rolling.simulation.moving_load import moving_key
from rolling.simulation.result import Result
from rolling.simulation.whole_series import whole_series
from rolling.sound.contact_sound import ContactSound
from rolling.sound.vibration_sound import Vibration

FORMAT = 2
CHUNK_BYTES = 1 << 19
UNITS = {
    "release_energy": "J",
    "loading_energy": "J",
    "energy_defect": "J",
    "step_time": "s",
    "speed": "m/s",
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
EVENT_UNITS = {
    "node": "1",
    "first": "position",
    "last": "position",
    "energy": "J",
    "peak": "J per step",
}
# netCDF-4 marks a dimension without values by this name.
_BARE = "This is a netCDF dimension but not a netCDF variable.{:10d}"


def image(
    result: Result,
    scene: Scene,
    scene_text: str,
    sound: ContactSound | None,
    vibration: Vibration | None = None,
) -> bytes:
    """Build the file in memory, so that the HDF5 library never meets a full disk."""
    with h5py.File(
        "result.h5", "w", driver="core", backing_store=False, block_size=1 << 20
    ) as file:
        _attributes(file, result, scene, scene_text)
        _series(file, result, scene)
        _snapshot(file, result, scene.spacing)
        _maps(file, result)
        _events(file, result)
        _stretches(file, result)
        _slow_motion(file, result)
        _force_law(file, result, scene.load)
        _moving_release(file, result, scene)
        if sound is not None:
            _sound(file, sound)
        if vibration is not None:
            _contact_force(file, vibration)
        file.flush()
        return bytes(file.id.get_file_image())


@dataclass(frozen=True)
class _Group:
    """A group of the file and its dimensions."""

    group: h5py.Group

    def dimension(self, name: str, length: int) -> None:
        """Make a dimension that has a length but no values."""
        _dataset(self.group, name, shape=(length,), dtype=">f4").make_scale(_BARE.format(length))

    def coordinate(self, name: str, values: NDArray[Any], units: str, long_name: str) -> None:
        """Make a dimension that has a value at each index."""
        scale = _dataset(self.group, name, values, packed=True)
        scale.attrs.update(units=units, long_name=long_name)
        scale.make_scale(name)

    def add(
        self,
        name: str,
        values: NDArray[Any],
        dimensions: Sequence[str],
        units: str,
        packed: bool = False,
        **more: str | float,
    ) -> None:
        """Add values along dimensions, compressed if `packed`, with the attributes `more`."""
        data = _dataset(self.group, name, values, packed)
        data.attrs.update(units=units, **more)
        for axis, dimension in enumerate(dimensions):
            data.dims[axis].attach_scale(self.group[dimension])


def _dataset(
    group: h5py.Group,
    name: str,
    values: NDArray[Any] | None = None,
    packed: bool = False,
    shape: tuple[int, ...] = (),
    dtype: Any = None,
) -> h5py.Dataset:
    """Make a dataset with checksums, in even chunks of about half a megabyte.

    `packed` datasets are compressed.
    """
    if values is not None:
        shape, dtype = values.shape, values.dtype
    row_bytes = max(1, np.dtype(dtype).itemsize * int(np.prod(shape[1:])))
    pieces = max(1, round(shape[0] * row_bytes / CHUNK_BYTES))
    chunks = (max(1, -(-shape[0] // pieces)), *(max(1, count) for count in shape[1:]))
    return group.create_dataset(
        name,
        data=values,
        shape=shape,
        dtype=dtype,
        chunks=chunks,
        # A chunk must not be larger than the data, unless they may grow.
        maxshape=None if all(shape) else (None,) * len(shape),
        fletcher32=True,
        shuffle=packed or None,
        compression="gzip" if packed else None,
        compression_opts=1 if packed else None,
    )


def _attributes(file: h5py.File, result: Result, scene: Scene, scene_text: str) -> None:
    file.attrs.update(
        title=f"rolling contact noise: {scene.name}",
        format=FORMAT,
        program=__version__,
        steps=result.steps,
        solved_steps=result.solved_steps,
        step_m=result.step,
        start_m=result.start,
        complete=result.complete,
        load_n=scene.load,
        scene=scene_text,
    )
    if isinstance(scene.surface, Gaussian):
        seed = scene.surface.seed
        file.attrs["seed"] = seed if seed < 1 << 63 else str(seed)
    if result.identity is not None:
        file.attrs.update(
            physics=result.identity.text,
            physics_defaults=canonical(result.identity.defaults),
            physics_sha256=result.identity.sha256,
        )
        if result.identity.heights_sha256 is not None:
            file.attrs["heights_sha256"] = result.identity.heights_sha256
    if result.trial is not None:
        file.attrs["tolerance_trial"] = canonical(vars(result.trial))


def _series(file: h5py.File, result: Result, scene: Scene) -> None:
    """Write the series along the track."""
    root, whole = _Group(file), whole_series(scene, result)
    for dimension, distance in (("step", whole.distance), ("position", whole.position)):
        root.coordinate(dimension, distance, "m", f"distance along the track, {dimension}")
    root.add(
        "time", whole.time, ["step"], "s", packed=True, long_name="time at the middle of each step"
    )
    root.add(
        "position_time",
        whole.position_time,
        ["position"],
        "s",
        packed=True,
        long_name="time at each position",
    )
    # With dynamics there is a second march, under the moving load.
    marked = {} if scene.dynamics is None else {"comment": "under the constant load"}
    for name, values in whole.of_steps.items():
        more = marked if name.startswith(("release", "loading")) else {}
        packed = name == "speed"
        root.add(name, values, ["step"], UNITS[name], packed, coordinates="time", **more)
    for name, values in whole.of_positions.items():
        root.add(name, values, ["position"], UNITS[name], coordinates="position_time")


def _snapshot(file: h5py.File, result: Result, spacing: float) -> None:
    snapshot = result.snapshot
    if snapshot is None:
        return
    group = _Group(file.create_group("snapshot"))
    group.group.attrs.update(
        distance_m=snapshot.distance, along_m=snapshot.along, across_m=snapshot.across
    )
    for name, corner, count in zip(
        ("along", "across"), (snapshot.along, snapshot.across), snapshot.pressure.shape, strict=True
    ):
        group.coordinate(
            name, corner + np.arange(count) * spacing, "m", f"place on the plate, {name} the track"
        )
    group.add("pressure", snapshot.pressure, ["along", "across"], "Pa")
    group.add("deflection", snapshot.deflection, ["along", "across"], "m")


def _maps(file: h5py.File, result: Result) -> None:
    maps = [result.maps[position] for position in sorted(result.maps)]
    if not maps:
        return
    group = _Group(file.create_group("pressure_maps"))
    shapes = np.array([each.pressure.shape for each in maps])
    rows, columns = shapes.max(axis=0).tolist()
    for name, length in (("map", len(maps)), ("row", rows), ("column", columns)):
        group.dimension(name, length)
    for name, values, unit in (
        ("position", [each.position for each in maps], "1"),
        ("distance", [each.distance for each in maps], "m"),
        ("along", [each.along for each in maps], "m"),
        ("across", [each.across for each in maps], "m"),
        ("cell", [each.cell for each in maps], "m"),
        ("rows", shapes[:, 0], "1"),
        ("columns", shapes[:, 1], "1"),
    ):
        group.add(name, np.asarray(values), ["map"], unit)
    # Each map covers its own contact only, so smaller maps are padded with NaN.
    padded = np.full((len(maps), rows, columns), np.nan, dtype=np.float32)
    for each, block in zip(maps, padded, strict=True):
        block[: each.pressure.shape[0], : each.pressure.shape[1]] = each.pressure
    group.add("pressure", padded, ["map", "row", "column"], "Pa", packed=True)


def _events(file: h5py.File, result: Result) -> None:
    """Write the events: one table for a complete run, otherwise a table with its pieces."""
    if not result.event_pieces:
        return
    group = _Group(file.create_group("events" if result.complete else "event_pieces"))
    if result.complete:
        table = result.events() or {}
    else:
        firsts = sorted(result.event_pieces)
        pieces = [result.event_pieces[first] for first in firsts]
        table = {name: np.concatenate([piece[name] for piece in pieces]) for name in EVENT_UNITS}
        group.dimension("piece", len(firsts))
        group.add("piece_first", np.array(firsts), ["piece"], "position")
        group.add(
            "piece_events", np.array([piece["energy"].size for piece in pieces]), ["piece"], "1"
        )
    group.dimension("event", table["energy"].size)
    group.dimension("axis", 2)
    for name, units in EVENT_UNITS.items():
        exact = table[name].dtype.kind == "i"  # energies do not compress
        group.add(
            name,
            table[name],
            ["event", "axis"] if name == "node" else ["event"],
            units,
            packed=exact,
        )


def _stretches(file: h5py.File, result: Result) -> None:
    """Write the stretches of the error estimate, with NaN for marches that are not done."""
    stretches = result.stretches
    if stretches is None:
        return
    group = _Group(file.create_group("error_estimate"))
    firsts = sorted({first for first, _ in stretches.marches})
    shape = len(firsts), len(LEVELS)
    release = np.full((*shape, stretches.steps), np.nan)
    approach = np.full((*shape, stretches.steps + 1), np.nan)
    plastic_area, seconds = np.full((2, *shape), np.nan)
    faults = {}
    for (first, level), march in stretches.marches.items():
        place = firsts.index(first), LEVELS.index(level)
        release[place], plastic_area[place] = march.release, march.plastic_area
        if march.approach.size:
            approach[place] = march.approach
        seconds[place] = march.seconds
        if march.fault:
            faults[f"{first} {level}"] = march.fault
    group.group.attrs.update(levels=" ".join(LEVELS), faults=canonical(faults))
    for name, length in zip(("stretch", "level", "stretch_step"), release.shape, strict=True):
        group.dimension(name, length)
    group.add("first", np.array(firsts), ["stretch"], "position")
    group.add("release_energy", release, ["stretch", "level", "stretch_step"], "J")
    if np.isfinite(approach).any():
        group.dimension("stretch_place", approach.shape[2])
        group.add("approach", approach, ["stretch", "level", "stretch_place"], "m")
    group.add("plastic_area", plastic_area, ["stretch", "level"], "m2")
    group.add("seconds", seconds, ["stretch", "level"], "s")


def _slow_motion(file: h5py.File, result: Result) -> None:
    """Write the maps of the slow motion as whole numbers of a unit, as netCDF packs values."""
    film = result.slow_motion
    if film is None or not film.pressure.size:
        return
    group = _Group(file.create_group("slow_motion"))
    group.coordinate("map_position", film.positions, "1", "position of each map")
    for name, corner, count in zip(
        ("along", "across"), (film.along, film.across), film.pressure.shape[1:], strict=True
    ):
        middles = corner + (np.arange(count) + 0.5) * film.cell
        group.coordinate(name, middles, "m", f"middle of each cell on the plate, {name} the track")
    group.group.attrs["cell_m"] = film.cell
    axes = ("map_position", "along", "across")
    group.add("pressure", film.pressure, axes, "Pa", True, scale_factor=film.pressure_unit)
    group.add("release", film.release, axes, "J", True, scale_factor=film.release_unit)


def _force_law(file: h5py.File, result: Result, own_load: float) -> None:
    """Write the approach at each load, with NaN where it is not marched yet, the scene's included.

    The loads in between, which judge the law, have a short stretch only.
    """
    marches = result.load_marches
    if marches is None:
        return
    group = _Group(file.create_group("force_law"))
    group.group.attrs.update(
        complete=marches.complete, seconds=marches.seconds, fault=marches.fault
    )
    by_load = marches.approach | {own_load: result.series["approach"]}
    loads = sorted(by_load)
    places = result.start + np.arange(result.solved_steps + 1) * result.step
    group.coordinate("load", np.array(loads), "N", "load of a march")
    group.coordinate("place", places, "m", "distance along the track")
    approach = np.array([by_load[load] for load in loads])
    group.add("approach", approach, ["load", "place"], "m", coordinates="load place")
    if marches.judging:
        between = sorted(marches.judging)
        judging = np.array([marches.judging[load] for load in between])
        group.coordinate("judging_load", np.array(between), "N", "load that judges the force law")
        group.dimension("judging_place", judging.shape[1])
        group.add("judging_approach", judging, ["judging_load", "judging_place"], "m")


def _moving_release(file: h5py.File, result: Result, scene: Scene) -> None:
    """Write the march under the moving load that belongs to the scene, if there is one."""
    key = moving_key(scene)
    if key not in result.moving:
        return
    moving, group = result.moving[key], _Group(file.create_group("moving_release"))
    group.group.attrs.update(key=key, fault=moving.fault)
    if moving.fault:
        return
    places = result.start + np.arange(result.solved_steps + 1) * result.step
    group.coordinate("place", places, "m", "distance along the track")
    group.dimension("place_step", result.solved_steps)
    for name, values, units in (
        ("force", moving.force, "N"),
        ("approach", moving.approach, "m"),
        ("motion_approach", moving.motion_approach, "m"),
    ):
        group.add(name, values, ["place"], units)
    for name, values in moving.steps.items():
        group.add(name, values, ["place_step"], "J")


def _sound(file: h5py.File, sound: ContactSound) -> None:
    group = _Group(file.create_group("sound"))
    group.group.attrs.update(sample_rate_hz=sound.sample_rate, closed=sound.closed)
    if sound.factor is not None:
        group.group.attrs["factor_pa_per_w_m2"] = sound.factor
    samples = np.arange(len(sound.pressure)) / sound.sample_rate
    group.coordinate("sound_time", samples, "s", "time of each sample")
    group.add("pressure", sound.pressure, ["sound_time"], "Pa", long_name="sound pressure")


def _contact_force(file: h5py.File, vibration: Vibration) -> None:
    """Write the contact force at the samples of the sound, within hearing, and its bands."""
    group, motion = _Group(file.create_group("contact_force")), vibration.motion
    group.group.attrs.update(
        sample_rate_hz=wav.SAMPLE_RATE_HZ,
        closed=vibration.closed,
        load_n=vibration.load,
        minimum_n=float(motion.force_n.min()),
        maximum_n=float(motion.force_n.max()),
        time_step_s=motion.time_step_s,
    )
    samples = np.arange(len(vibration.force)) / wav.SAMPLE_RATE_HZ
    group.coordinate("force_time", samples, "s", "time of each sample")
    group.add(
        "force",
        vibration.load + vibration.force,
        ["force_time"],
        "N",
        long_name="contact force, its fluctuation limited to 20 Hz to 20 kHz",
    )
    group.coordinate("band", np.array(MID_HZ), "Hz", "mid frequency of a third octave")
    group.add(
        "band_rms",
        vibration.force_bands,
        ["band"],
        "N",
        long_name="rms of the contact force in the third octave",
    )
