"""Faults of raceways and balls as solved stretches of the tracks.

A contact is marched over a fault, and over the same stretch without it. The difference of both
approaches stands in the track at the angle of the fault. A fault wider than the contact is followed
to its bottom, and a narrow one is bridged.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from acoustics.arrays import Array, short_repr
from rolling.bearing_kind.rough_contacts import (
    HIGHEST,
    ROOM,
    WINDOW_NODES,
    ContactKind,
    MarchNumbers,
    contact_scene,
    overlap_reach,
)
from rolling.scene.laws import Roughness, SurfaceFault
from rolling.scene.scene import Scene
from rolling.scene.sections import STEP_NODES
from rolling.surface.single_faults import fault_places

NODES_PER_FAULT = 8.0  # minimum number of nodes in the size of a fault
STEPS_PER_FAULT = 8.0  # minimum number of steps in it
SINKING = 3.0  # of a ball into a hole, over the sagitta of its opening, at most


@dataclass(frozen=True)
class FaultStretch:
    """Stretch around a fault under a kind of contact, which is marched with and without it.

    name : str. Kind of contact, as of `RoughContact`.
    angle : float, rad. Place of the fault on its body.
    with_fault, without : Scene. The stretch at the middle load; the fault is in its middle.
    loads_n : tuple of float, N. Ascending loads.
    """

    __repr__ = short_repr

    name: str
    angle: float
    with_fault: Scene
    without: Scene
    loads_n: tuple[float, ...]

    @cached_property
    def scenes(self) -> dict[float, tuple[Scene, Scene]]:
        """Scenes with and without the fault by load [N]."""
        pairs = {}
        for load in self.loads_n:
            change = {"rolling.load_n": load}
            pairs[load] = (self.with_fault.with_(change), self.without.with_(change))
        return pairs

    @property
    def places_m(self) -> Array:
        """Distances of the positions from the fault [m]."""
        track = self.with_fault.track
        steps = np.arange(track.solved_steps)
        return np.asarray(steps * track.step - track.distance / 2, dtype=np.float64)


def fault_stretches(
    kind: ContactKind, faults: Sequence[SurfaceFault], *, radius_m: float, law: Roughness | None
) -> list[FaultStretch]:
    """Return the stretches around the faults of a body that a kind of contact meets.

    A fault beside the contact gives none, nor does a step, which is a form of the whole turn.
    Equal stretches on smooth surfaces share their marches.

    Parameters
    ----------
    kind : ContactKind
        Kind of contact; its grid is refined where a fault needs it.
    faults : sequence of SurfaceFault
        Faults with places (x, y) on the body: x along the turn, y from the middle of the track.
    radius_m : float, m
        Radius of the circle on the body on which the contact runs.
    law : Roughness or None
        Law of the surface around the fault, None for a smooth one.
    """
    stretches = []
    for fault in faults:
        if fault.kind == "step":
            continue
        width = kind.numbers.width_um * 1e-6
        for x, y in fault_places(fault.in_si, 2 * np.pi * radius_m, width):
            if abs(y) - reach_across(fault) > width / 2:
                continue
            stretches.append(_stretch(kind, fault, float(x) / radius_m, float(y), law))
    return stretches


def reach_across(fault: SurfaceFault) -> float:
    """Return how far a fault reaches across the track from its place [m]."""
    if fault.crosses:
        return math.inf
    placed = fault.in_si
    return placed.reach_m + abs(math.sin(placed.angle_rad)) * placed.length_m / 2


def _reach_along(fault: SurfaceFault) -> float:
    """Return how far a fault reaches along the track from its place [m]."""
    placed = fault.in_si
    return placed.reach_m + abs(math.cos(placed.angle_rad)) * placed.length_m / 2


def _stretch(
    kind: ContactKind, fault: SurfaceFault, angle: float, across_m: float, law: Roughness | None
) -> FaultStretch:
    """Return the stretch around a fault at an angle [rad] and a distance across the track."""
    numbers = _fault_numbers(kind, fault, across_m, law)
    middle_mm = numbers.distance_mm / 2
    placed = fault.model_copy(
        update={"at_mm": [middle_mm, across_m * 1e3], "count": None, "seed": None}
    )
    refined = replace(kind, numbers=numbers)
    return FaultStretch(
        name=kind.name,
        angle=angle,
        with_fault=contact_scene(refined, f"{kind.name}-{fault.kind}", law, [placed]),
        without=contact_scene(refined, f"{kind.name}-beside-{fault.kind}", law),
        loads_n=kind.loads_n,
    )


def _entered_um(kind: ContactKind, fault: SurfaceFault) -> float:
    """Return how deep a ball may sink into a fault [um]: not beyond its edges by far."""
    if fault.kind not in ("pit", "scratch", "groove"):
        return fault.depth_um
    sagitta_um = 1e-6 * fault.size_um**2 / (8 * kind.contact.radius_along_m)
    return min(fault.depth_um, SINKING * sagitta_um)


def _fault_numbers(
    kind: ContactKind, fault: SurfaceFault, across_m: float, law: Roughness | None
) -> MarchNumbers:
    """Return the grid of the stretch around a fault, which is closed and holds the contact."""
    numbers = kind.numbers
    roughness = law.rq_m if law is not None else 0.0
    height_um = max(_entered_um(kind, fault), fault.rises_um)
    reach_along, reach_beside = overlap_reach(
        kind.contact, max(kind.loads_n), roughness + 1e-6 * height_um / HIGHEST
    )
    # A small fault has fewer nodes where the window would have too many.
    least_um = 1e6 * math.sqrt(4 * reach_along * reach_beside / WINDOW_NODES)
    narrowest_um = fault.size_um
    if fault.in_si.rim_width_m > 0:
        narrowest_um = min(narrowest_um, 1e6 * fault.in_si.rim_width_m)
    wanted_um = min(max(narrowest_um / NODES_PER_FAULT, least_um), narrowest_um / 2)
    spacing_um = min(numbers.spacing_um, float(f"{wanted_um:.2g}"))
    step_um = min(numbers.spacing_um * numbers.step_nodes, fault.size_um / STEPS_PER_FAULT)
    fitting = [nodes for nodes in STEP_NODES if 1 <= nodes <= step_um / spacing_um]
    step_nodes = max(fitting, default=1.0)
    longest = 1e-6 * max(fault.size_um, fault.length_um or 0.0)
    length = ROOM * max(2 * (reach_along + _reach_along(fault)), longest)
    width = 2 * ROOM * reach_beside
    if not fault.crosses:
        width = max(width, 2 * ROOM * (abs(across_m) + reach_across(fault)), ROOM * longest)
    # An even number of steps puts a position on the fault.
    steps = 2 * math.ceil(length * 1e6 / (2 * step_nodes * spacing_um))
    nodes = 2 * math.ceil(max(width * 1e6, numbers.width_um) / (2 * spacing_um))
    return replace(
        numbers,
        spacing_um=spacing_um,
        step_nodes=step_nodes,
        distance_mm=steps * step_nodes * spacing_um * 1e-3,
        width_um=nodes * spacing_um,
    )


def added_at_angle(
    rows: Array, places_m: Array, change_m: Array, angle: float, radius_m: float
) -> Array:
    """Return rows around a turn with a change of the approach added at an angle.

    Parameters
    ----------
    rows : array (loads, n), m
        Change of the approach at n equally spaced angles.
    places_m : array (m,), m
        Ascending distances from the place.
    change_m : array (loads, m), m
        Change at these distances; it is zero beyond them.
    angle : float, rad
        Angle of the place.
    radius_m : float, m
        Radius of the circle on the body on which the contact runs.
    """
    points = rows.shape[1]
    turn = 2 * np.pi * np.arange(points) / points - angle
    distance = radius_m * ((turn + np.pi) % (2 * np.pi) - np.pi)
    changed = [
        row + np.interp(distance, places_m, change, left=0.0, right=0.0)
        for row, change in zip(rows, change_m, strict=True)
    ]
    return np.array(changed)
