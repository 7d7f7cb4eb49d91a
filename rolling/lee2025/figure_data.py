"""What the figures of a reading are drawn from, and the axes on which all readings can be compared. Depends on study."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from acoustics import plots as sound_plots
from rolling.lee2025.study import Case
from rolling.scene.scene import Scene
from rolling.scene.sections import Gaussian
from rolling.simulation import simulate
from rolling.simulation.batch import Run
from rolling.simulation.result_file import Result
from rolling.surface import heights as surface
from rolling.surface import scene_surface

Array = NDArray[np.float64]

PATCH_M = 512e-6  # side of the surfaces of the article's Fig. 1
NOTHING_DB = -300.0  # and below: no sound


@dataclass(frozen=True)
class Patch:
    """A square of a surface: heights (n, n) [m] at a spacing [m]."""

    heights: Array
    spacing: float


@dataclass(frozen=True)
class Contact:
    """Pressure [Pa] and deflection [m] (m, n) of nodes at the positions along (m,) and across (n,) from the sphere [m]."""

    along: Array
    across: Array
    pressure: Array
    deflection: Array

    @property
    def reach(self) -> float:
        """How far from below the sphere the farthest loaded node lies, along or across [m]."""
        row, column = np.nonzero(self.pressure > 0.0)
        farthest = np.concatenate([np.abs(self.along[row]), np.abs(self.across[column])])
        return float(farthest.max(initial=0.0))


@dataclass(frozen=True)
class Reading:
    """What the figures of a reading are drawn from.

    slopes : rms norm of the surface's gradient by Ra and correlation length [um].
    patches : a surface by Ra [um].  contacts : of that surface, by Ra [um] and load [N].
    """

    name: str
    cases: Sequence[Case]
    slopes: Mapping[tuple[float, float], float] = field(default_factory=dict)
    patches: Mapping[float, Patch] = field(default_factory=dict)
    contacts: Mapping[tuple[float, float], Contact] = field(default_factory=dict)

    @property
    def lengths(self) -> list[float]:
        return sorted({one.correlation_um for one in self.cases})

    def at(self, **values: float) -> list[Case]:
        """The cases with these values, such as load_n=5."""
        return [one for one in self.cases if all(getattr(one, name) == value for name, value in values.items())]


@dataclass(frozen=True)
class Scales:
    """Axes that are the same for all readings; colours of roughnesses and loads go by their place in the lists.

    reach_um : of contacts from the sphere.  height_um : of a surface's highest or deepest point.
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
        """The least and the greatest load, of which maps are drawn."""
        return sorted({self.loads[0], self.loads[-1]}) if self.loads else []


def gather(name: str, runs: Sequence[Run], results: Sequence[Result], cases: Sequence[Case]) -> Reading:
    """What is drawn of a reading: slopes of all its surfaces; surface and contacts of the first seed.

    Parameters
    ----------
    runs, results : as `study.runs` and `study.open_results` give them, in that order; results may be empty.
    cases : of those that are solved.
    """
    slopes: dict[tuple[float, float], float] = {}
    patches: dict[float, Patch] = {}
    contacts: dict[tuple[float, float], Contact] = {}
    for one, result in zip(runs, results, strict=True):
        scene, s = one.scene, one.scene.surface
        assert isinstance(s, Gaussian)
        roughness, length = s.roughness_ra_um, s.correlation_length_um
        if (roughness, length) not in slopes:
            heights = scene_surface.heights(scene)
            nodes = round(PATCH_M / scene.spacing)
            slopes[roughness, length] = surface.statistics(heights, scene.spacing).rms_slope
            patches[roughness] = Patch(heights[:nodes, :nodes].copy(), scene.spacing)
        if result.snapshot is not None:
            contacts.setdefault((roughness, scene.load), _contact(scene, result.snapshot))
    return Reading(name, tuple(cases), slopes, patches, contacts)


def _contact(scene: Scene, snapshot: simulate.Snapshot) -> Contact:
    middle = (scene.track.n_across - 1) / 2 * scene.spacing
    rows, columns = (positions(count, scene.spacing) for count in snapshot.pressure.shape)
    along, across = snapshot.along - snapshot.distance, snapshot.across - middle
    return Contact(along + rows, across + columns, snapshot.pressure, snapshot.deflection)


def scales(readings: Sequence[Reading]) -> Scales:
    """Axes on which all these readings can be compared."""
    cases = [one for reading in readings for one in reading.cases]
    contacts = [one for reading in readings for one in reading.contacts.values()]
    heights = [one.heights for reading in readings for one in reading.patches.values()]
    roughnesses = sorted({one.roughness_um for one in cases} | {ra for each in readings for ra in each.patches})
    loads = sorted({one.load_n for one in cases} | {load for each in readings for _, load in each.contacts})
    maxima = [one.maximum_db for one in cases if one.maximum_db > NOTHING_DB]
    return Scales(
        roughnesses,
        loads,
        height_um=1e6 * max((float(np.abs(one).max()) for one in heights), default=1e-6),
        reach_um=1e6 * max((one.reach for one in contacts), default=1e-4),
        pressure_gpa=1e-9 * max((float(one.pressure.max()) for one in contacts), default=1e9),
        deflection_um=1e6 * max((float(one.deflection.max()) for one in contacts), default=1e-6),
        plastic_ratio=1.05 * max((one.plastic_ratio for one in cases), default=1.0) or 1.0,
        spectrum_db=sound_plots.level_limits(level for one in cases for level in one.line_db),
        maximum_db=sound_plots.level_limits(maxima),
    )


def positions(count: int, spacing: float) -> Array:
    return np.linspace(0.0, (count - 1) * spacing, count)
