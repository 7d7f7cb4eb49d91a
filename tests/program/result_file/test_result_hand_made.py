"""A result.h5 that another program changed is refused by the name of the damaged field."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from old_results import save_old
from stored_results import refusal

from rolling.simulation import result_file

Spoil = Callable[[h5py.File], object]


def put(name: str, index: Any, value: float) -> Spoil:
    def spoil(file: h5py.File) -> None:
        data = file[name]
        values = data[()]
        values[index] = value
        attributes = dict(data.attrs)
        del file[name]
        file[name] = values
        file[name].attrs.update({k: v for k, v in attributes.items() if k == "units"})

    return spoil


def shaped(name: str, change: Callable[[np.ndarray], Any]) -> Spoil:
    def spoil(file: h5py.File) -> None:
        values = file[name][()]
        del file[name]
        file[name] = change(values)

    return spoil


def attribute(name: str, value: Any, group: str = "/") -> Spoil:
    return lambda file: file[group].attrs.__setitem__(name, value)


def without(name: str) -> Spoil:
    return lambda file: file.__delitem__(name)


HAND_MADE: list[tuple[str, Spoil]] = [
    ("steps", attribute("steps", 0)),
    ("steps", attribute("steps", -1)),
    ("steps", attribute("steps", 10**12)),
    ("steps", attribute("steps", "many")),
    ("steps", attribute("steps", np.array([450, 450]))),
    ("steps", lambda file: file.attrs.__delitem__("steps")),
    ("solved_steps", attribute("solved_steps", 10**8)),
    ("solved_steps", attribute("solved_steps", 2.5)),
    ("step_m", attribute("step_m", 0.0)),
    ("step_m", attribute("step_m", np.nan)),
    ("step_m", attribute("step_m", "2 um")),
    ("start_m", attribute("start_m", np.inf)),
    ("complete", attribute("complete", False)),
    ("complete", attribute("complete", "yes")),
    ("release_energy", without("release_energy")),
    ("release_energy", shaped("release_energy", lambda values: values[:-1])),
    ("release_energy", shaped("release_energy", lambda values: values.reshape(2, -1))),
    ("release_energy", shaped("release_energy", lambda values: values.astype("S8"))),
    ("release_energy", shaped("release_energy", lambda values: 1.0)),
    ("release_energy", put("release_energy", 3, -1e-9)),
    ("release_energy", put("release_energy", 3, np.inf)),
    ("loading_energy", put("release_energy", 3, np.nan)),
    ("step_time", put("step_time", 0, np.nan)),
    ("energy_defect", put("energy_defect", 0, np.inf)),
    ("approach", put("approach", 5, np.nan)),
    ("approach", shaped("approach", lambda values: np.append(values, 1.0))),
    ("contact_area", put("contact_area", 5, -1.0)),
    ("stored_energy", put("stored_energy", 0, -1.0)),
    ("max_deflection", put("max_deflection", 5, -1.0)),
    ("iterations", put("iterations", 5, 2.5)),
    ("iterations", lambda file: (without("iterations")(file), file.create_group("iterations"))),
    (
        "residual",
        lambda file: (
            without("residual")(file),
            file.__setitem__("residual", h5py.SoftLink("/approach")),
        ),
    ),
    ("snapshot/pressure", put("snapshot/pressure", (0, 0), np.nan)),
    ("snapshot/pressure", shaped("snapshot/pressure", lambda values: values.ravel())),
    ("snapshot/deflection", shaped("snapshot/deflection", lambda values: values[1:])),
    ("snapshot/along_m", attribute("along_m", "here", "snapshot")),
    ("snapshot", lambda file: (without("snapshot")(file), file.__setitem__("snapshot", 1.0))),
    ("pressure_maps/position", put("pressure_maps/position", 3, 10**9)),
    ("pressure_maps/position", put("pressure_maps/position", 3, 0)),
    ("pressure_maps/cell", put("pressure_maps/cell", 3, 0.0)),
    ("pressure_maps/distance", put("pressure_maps/distance", 3, 1.0)),
    ("pressure_maps/along", shaped("pressure_maps/along", lambda values: values[1:])),
    ("pressure_maps/pressure", put("pressure_maps/pressure", (3,), -1.0)),
    ("events/energy", put("events/energy", 0, -1.0)),
    ("events/peak", put("events/peak", 0, 1.0)),
    ("events/last", put("events/last", 0, -5)),
    ("events/first", put("events/last", 0, 10**6)),
    ("events/node", shaped("events/node", lambda values: values[:, 0])),
    ("events/first", without("events/first")),
    ("events", lambda file: shorter(file["events"])),
]


def shorter(group: h5py.Group) -> None:
    for name in ("node", "first", "last", "energy", "peak"):
        shaped(f"{group.name}/{name}", lambda values: values[len(values) // 2 :])(group.file)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("field", "spoil"), HAND_MADE, ids=[f"{k}-{field}" for k, (field, _) in enumerate(HAND_MADE)]
)
def test_hand_made_damage_is_refused_by_its_field(
    field: str, spoil: Spoil, path: Path, monkeypatch
) -> None:
    """A file of this version and an old one without a digest are refused by the damaged field."""
    # half a second each; the library reads all of these
    monkeypatch.setattr(result_file, "_probed", lambda path: None)
    old = path.with_name("old.h5")
    save_old(old, result_file.load(path), True)
    for each in (path, old):
        with h5py.File(each, "r+") as file:
            spoil(file)
        assert f": {field}: " in refusal(each)


@pytest.mark.parametrize(
    ("field", "spoil"),
    [
        ("format", attribute("format", 3)),
        ("format", attribute("format", "two")),
        ("physics", attribute("physics", "{")),
        ("physics", attribute("physics", "[]")),
        ("physics_sha256", attribute("physics_sha256", "0")),
        ("physics_defaults", lambda file: file.attrs.__delitem__("physics_defaults")),
        ("heights_sha256", attribute("heights_sha256", 5)),
        ("pressure_maps/rows", put("pressure_maps/rows", 3, 10**6)),
        ("pressure_maps/pressure", put("pressure_maps/pressure", (3, 0, 0), np.nan)),
        ("max_deflection", without("max_deflection")),
        ("events", without("events")),
    ],
)
def test_hand_made_damage_of_this_format_is_refused(
    field: str, spoil: Spoil, path: Path, monkeypatch
) -> None:
    monkeypatch.setattr(result_file, "_probed", lambda path: None)
    with h5py.File(path, "r+") as file:
        spoil(file)
    assert f": {field}" in refusal(path)


def test_a_result_of_the_future_is_not_read_as_one_of_today(path: Path) -> None:
    with h5py.File(path, "r+") as file:
        file.attrs["format"] = 3
    assert "format 3, this version of the program reads up to 2" in refusal(path)
