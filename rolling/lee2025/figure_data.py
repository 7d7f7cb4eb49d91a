"""The data of a reading's figures, and the common axes for comparing all readings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from acoustics import plots as sound_plots
from rolling._typing import Array
from rolling.lee2025.study import Case
from rolling.scene.scene import Scene
from rolling.scene.surfaces import Gaussian
from rolling.simulation import simulate
from rolling.simulation.batch import Run
from rolling.simulation.result_file import Result
from rolling.surface import heights as surface
from rolling.surface import scene_surface

PATCH_M = 512e-6  # side of the surfaces of the article's Fig. 1
NOTHING_DB = -300.0  # levels at or below this value mean no sound


@dataclass(frozen=True)
class Patch:
    """A square of a surface.

    Parameters
    ----------
    heights : array (n, n), m. Heights of the nodes.
    spacing : float, m. Spacing of the nodes.
    """

    heights: Array
    spacing: float


@dataclass(frozen=True)
class Contact:
    """The solved contact at one position of the sphere.

    Parameters
    ----------
    along, across : arrays (m,) and (n,), m. Positions of the nodes from the sphere.
    pressure, deflection : arrays (m, n), Pa and m. Pressure and deflection of the nodes.
    """

    along: Array
    across: Array
    pressure: Array
    deflection: Array

    @property
    def reach(self) -> float:
        """The distance from the sphere to the farthest loaded node, along or across [m]."""
        row, column = np.nonzero(self.pressure > 0.0)
        farthest = np.concatenate([np.abs(self.along[row]), np.abs(self.across[column])])
        return float(farthest.max(initial=0.0))


@dataclass(frozen=True)
class Reading:
    """The data of a reading's figures.

    Parameters
    ----------
    name : str. Name of the reading.
    cases : sequence of Case. Its solved cases.
    slopes : mapping from (Ra, correlation length), um, to float. Rms norm of the surface's
        gradient. Default: none.
    patches : mapping from Ra, um, to Patch. Surfaces. Default: none.
    contacts : mapping from (Ra, load), um and N, to Contact. Contacts of those surfaces. Default:
        none.
    """

    name: str
    cases: Sequence[Case]
    slopes: Mapping[tuple[float, float], float] = field(default_factory=dict)
    patches: Mapping[float, Patch] = field(default_factory=dict)
    contacts: Mapping[tuple[float, float], Contact] = field(default_factory=dict)

    @property
    def lengths(self) -> list[float]:
        """The correlation lengths [um], rising."""
        return sorted({case.correlation_um for case in self.cases})

    def at(self, **values: float) -> list[Case]:
        """Return the cases with these values, such as load_n=5."""
        return [
            case
            for case in self.cases
            if all(getattr(case, name) == value for name, value in values.items())
        ]


@dataclass(frozen=True)
class Scales:
    """Axes that are the same for all readings.

    The colours of roughnesses and loads follow from their places in the lists.

    Parameters
    ----------
    roughnesses, loads : lists of float, um and N. Values of all readings, rising.
    height_um : float, um. Height of the highest point of a surface, or depth of the deepest.
    reach_um : float, um. Distance of the farthest loaded node from the sphere.
    pressure_gpa, deflection_um, plastic_ratio : float, GPa, um and 1. Maxima over all readings.
    spectrum_db, maximum_db : pairs of float, dB. Limits of the axes of levels.
    """

    roughnesses: list[float]
    loads: list[float]
    height_um: float
    reach_um: float
    pressure_gpa: float
    deflection_um: float
    plastic_ratio: float
    spectrum_db: tuple[float, float]
    maximum_db: tuple[float, float]

    @property
    def ends(self) -> list[float]:
        """The lowest and the highest load, for which maps are drawn."""
        return sorted({self.loads[0], self.loads[-1]}) if self.loads else []


def gather(
    name: str, runs: Sequence[Run], results: Sequence[Result], cases: Sequence[Case]
) -> Reading:
    """Gather the data of a reading's figures.

    The data are the slopes of all its surfaces, and surface and contacts of the first seed.

    Parameters
    ----------
    name : str. Name of the reading.
    runs, results : sequences of Run and Result. The lists of `study.runs` and `study.open_results`,
        in the same order. Results may be empty.
    cases : sequence of Case. The solved cases.
    """
    slopes: dict[tuple[float, float], float] = {}
    patches: dict[float, Patch] = {}
    contacts: dict[tuple[float, float], Contact] = {}
    for run, result in zip(runs, results, strict=True):
        scene, gaussian = run.scene, run.scene.surface
        assert isinstance(gaussian, Gaussian)
        roughness, length = gaussian.roughness_ra_um, gaussian.correlation_length_um
        if (roughness, length) not in slopes:
            heights = scene_surface.heights(scene)
            nodes = round(PATCH_M / scene.spacing)
            slopes[roughness, length] = surface.statistics(heights, scene.spacing).rms_slope
            patches[roughness] = Patch(heights[:nodes, :nodes].copy(), scene.spacing)
        if result.snapshot is not None:
            contacts.setdefault((roughness, scene.load), _contact(scene, result.snapshot))
    return Reading(name, tuple(cases), slopes, patches, contacts)


def _contact(scene: Scene, snapshot: simulate.Snapshot) -> Contact:
    """Return the contact of a snapshot, with positions from the sphere."""
    middle = (scene.track.n_across - 1) / 2 * scene.spacing
    rows, columns = (positions(count, scene.spacing) for count in snapshot.pressure.shape)
    along, across = snapshot.along - snapshot.distance, snapshot.across - middle
    return Contact(along + rows, across + columns, snapshot.pressure, snapshot.deflection)


def scales(readings: Sequence[Reading]) -> Scales:
    """Compute axes on which all these readings can be compared."""
    cases = [case for reading in readings for case in reading.cases]
    contacts = [contact for reading in readings for contact in reading.contacts.values()]
    heights = [patch.heights for reading in readings for patch in reading.patches.values()]
    roughnesses = sorted(
        {case.roughness_um for case in cases}
        | {ra for reading in readings for ra in reading.patches}
    )
    loads = sorted(
        {case.load_n for case in cases}
        | {load for reading in readings for _, load in reading.contacts}
    )
    maxima = [case.maximum_db for case in cases if case.maximum_db > NOTHING_DB]
    return Scales(
        roughnesses,
        loads,
        height_um=1e6 * max((float(np.abs(patch).max()) for patch in heights), default=1e-6),
        reach_um=1e6 * max((contact.reach for contact in contacts), default=1e-4),
        pressure_gpa=1e-9
        * max((float(contact.pressure.max()) for contact in contacts), default=1e9),
        deflection_um=1e6
        * max((float(contact.deflection.max()) for contact in contacts), default=1e-6),
        plastic_ratio=1.05 * max((case.plastic_ratio for case in cases), default=1.0) or 1.0,
        spectrum_db=sound_plots.level_limits(level for case in cases for level in case.line_db),
        maximum_db=sound_plots.level_limits(maxima),
    )


def positions(count: int, spacing: float) -> Array:
    """Return the positions [m] of `count` nodes from the first."""
    return np.linspace(0.0, (count - 1) * spacing, count)
