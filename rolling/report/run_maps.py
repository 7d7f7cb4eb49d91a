"""Pressure maps of runs for the page, on common scales, with times and contact numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from rolling.contact import closed_forms
from rolling.report import pressure_maps
from rolling.report.pressure_maps import Sheet
from rolling.simulation.run_result import RunResult
from rolling.simulation.simulate import PressureMap


@dataclass(frozen=True)
class MapScale:
    """The scales of length and colour that the maps of all runs share.

    Parameters
    ----------
    half_um : float, um. Half the side of the square shown.
    max_gpa : float, GPa. Pressure of the last colour.
    hardness : bool. Whether that pressure is the hardness of a plate.
    colours : list of str. CSS colours, from zero pressure to `max_gpa`.
    """

    half_um: float
    max_gpa: float
    hardness: bool
    colours: list[str]


@dataclass(frozen=True)
class RunMaps:
    """The maps of one run with the numbers shown beside them, one per position.

    Parameters
    ----------
    sheet : bytes. PNG that holds all maps.
    tiles, boxes : see `pressure_maps.Sheet`.
    begins : list of float, s. Times from which a map is shown.
    order : list of int. Index of the map shown from each of these times.
    hertz_um : float, um. Contact radius of the smooth elastic contact.
    load_n : float, N. Load.
    position_mm : list of float, mm. Position of the sphere.
    max_pressure_gpa, contact_um2, plastic_um2 : lists of float, GPa and um^2. None where unknown.
    """

    sheet: bytes
    tiles: list[tuple[int, int, int, int]]
    boxes: list[list[float]]
    begins: list[float]
    order: list[int]
    hertz_um: float
    load_n: float
    position_mm: list[float]
    max_pressure_gpa: list[float | None]
    contact_um2: list[float | None]
    plastic_um2: list[float | None]


def maps_of(runs: Sequence[RunResult]) -> tuple[MapScale | None, list[RunMaps | None]]:
    """Collect the pressure maps of all runs on common scales.

    Returns
    -------
    MapScale or None
        The common scales; None if no run has maps.
    list of RunMaps or None
        The maps of each run; None for a run without maps.
    """
    mapped = {index: run for index, run in enumerate(runs) if run.result.maps}
    if not mapped:
        return None, [None] * len(runs)
    hardness = max(run.scene.hardness for run in mapped.values())
    computed = max(
        float(each.pressure.max()) for run in mapped.values() for each in run.result.maps.values()
    )
    maximum = hardness if np.isfinite(hardness) else computed
    sheets = {
        k: pressure_maps.sheet(sounding_maps(run), _mid_width(run), maximum)
        for k, run in mapped.items()
    }
    radii_um = {k: 1e6 * _hertz_radius(run) for k, run in mapped.items()}
    scale = MapScale(
        half_um=pressure_maps.half_width(list(sheets.values()), list(radii_um.values())),
        max_gpa=maximum * 1e-9,
        hardness=bool(np.isfinite(hardness)),
        colours=[f"rgb({r},{g},{b})" for r, g, b in pressure_maps.palette()[1::2]],
    )
    return scale, [
        _run_maps(run, sheets[k], radii_um[k]) if k in mapped else None
        for k, run in enumerate(runs)
    ]


def sounding_maps(run: RunResult) -> list[PressureMap]:
    """Return the maps in the part of the track that the record covers."""
    maps: Mapping[int, PressureMap] = run.result.maps
    return [maps[position] for position in sorted(maps) if position <= run.result.done_steps]


def _mid_width(run: RunResult) -> float:
    """Return the position of the sphere across the plate [m]."""
    return (run.scene.track.n_across - 1) / 2 * run.scene.spacing


def _hertz_radius(run: RunResult) -> float:
    """Return the contact radius of the smooth elastic contact [m]."""
    return closed_forms.hertz_radius(run.scene.load, run.scene.radius, run.scene.contact_modulus)


def _run_maps(run: RunResult, sheet: Sheet, hertz_um: float) -> RunMaps:
    result, maps = run.result, sounding_maps(run)
    positions = np.array([each.position for each in maps])
    lap, rolled = result.solved_steps * result.step, result.done_steps * result.step
    closes = result.complete and run.scene.track.closed
    begins, order = pressure_maps.showing(
        positions * result.step, lap, rolled, closes, run.scene.motion
    )

    def series(name: str, factor: float) -> list[float | None]:
        values = result.series[name][positions] * factor
        return [float(f"{value:.4g}") if np.isfinite(value) else None for value in values]

    return RunMaps(
        sheet=sheet.png,
        tiles=sheet.tiles,
        boxes=[[round(value, 4) for value in box] for box in sheet.boxes],
        begins=np.round(begins, 7).tolist(),
        order=order.tolist(),
        hertz_um=hertz_um,
        load_n=run.scene.load,
        position_mm=[float(f"{each.distance * 1e3:.6g}") for each in maps],
        max_pressure_gpa=series("max_pressure", 1e-9),
        contact_um2=series("contact_area", 1e12),
        plastic_um2=series("plastic_area", 1e12),
    )
