"""Rough contacts of a bearing, each an ordinary scene: a sphere that rolls over a flat surface.

A rough raceway is marched under a smooth ball, and the surface of the balls under a smooth
raceway, at the loads that the balls bear. Both surfaces together would need a march for each pair
of places that meet. The sum of both approaches stands for it (`contact_doubts` says how well).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Literal

import numpy as np

from acoustics.arrays import Array, short_repr
from rolling.bearing import waves
from rolling.bearing.geometry import BearingGeometry, RacewayContact
from rolling.bearing.static_load import LoadedRing, balances_around
from rolling.contact.track import MIN_NODES
from rolling.in_si.scene_surface import heights
from rolling.scene.laws import Roughness, SurfaceFault
from rolling.scene.scene import Scene
from rolling.scene.sections import STEP_NODES
from rolling.scene.surfaces import BallHeightFile

# ---- numbers of a march

# Against nodes of 1 um, nodes of 2, 4 and 5 um left errors of -48, -37 and -33 dB of the approach's
# fluctuation (inner contact of a 6204, 42 N, Ra 0.05 um, 60 by 10 um).

NODES_PER_LENGTH = 2.5  # minimum number of nodes in a correlation length
NODES_PER_AXIS = 6.0  # minimum number of nodes in the shorter semi-axis at the lightest load
# Maximum nodes of a window at the largest load, for which a step takes some 15 ms. Contacts of
# short correlation lengths have coarser nodes than wanted, and a doubt.
WINDOW_NODES = 60_000
# Steps fold waves shorter than two of them back into hearing. A contact averages waves shorter than
# itself, and a Gaussian law has few much shorter than its correlation length: steps of 0.8 lengths
# left -40 dB of what is heard (lengths of 10 and 20 um, semi-axes of 36 to 64 um, 1.5 m/s).
STEPS_PER_AXIS = 2.0  # minimum number of steps in the shorter semi-axis
STEPS_PER_LENGTH = 1.25  # minimum number of steps in a correlation length along the track
HEARD_HZ = 24e3  # that the steps hold with a margin
MARGIN = 2.0  # of the Nyquist frequency of the steps over it
HIGHEST = 4.0  # peaks of rough surfaces over their rms height
LEAST_CONTACTS = 2.0  # minimum length of a track over that of the contact's overlap
ROOM = 1.1  # of the width of a surface over that of the contact's overlap

# ---- loads

LOAD_RATIO = 2.0  # of neighbouring loads, at most
LEAST_OF_LARGEST = 1 / 8  # lightest marched load over the largest load of a ball


@dataclass(frozen=True)
class RoughContact:
    """A kind of contact with the surface of one of its bodies, at some loads.

    name : str. "inner", "outer", "balls-on-inner" or "balls-on-outer".
    contact : RacewayContact. The smooth contact.
    scene : Scene. The rough contact at the middle load.
    loads_n : tuple of float, N. Ascending loads.
    """

    __repr__ = short_repr

    name: str
    contact: RacewayContact
    scene: Scene
    loads_n: tuple[float, ...]

    @property
    def middle_load_n(self) -> float:
        """Load that is marched first [N]."""
        return self.scene.load

    @cached_property
    def scenes(self) -> dict[float, Scene]:
        """Scenes by load [N]."""
        return {load: self.at_load(load) for load in self.loads_n}

    @property
    def steps(self) -> int:
        """Positions of a march, without the last, which is the first."""
        return self.scene.track.solved_steps

    def at_load(self, load_n: float) -> Scene:
        """Return the scene at a load [N]."""
        if load_n == self.scene.load:
            return self.scene
        return self.scene.with_({"rolling.load_n": load_n})

    @cached_property
    def own_linear_rows(self) -> Array:
        """Linear change of the approach [m] at the loads of the contact, (loads, steps)."""
        return self.linear_rows(self.loads_n)

    def linear_rows(self, loads_n: Sequence[float]) -> Array:
        """Return the linear change of the approach [m] at the positions of the march.

        It needs no march, and is accurate where the contact is closed. Shape (loads, steps).
        """
        spacing = self.scene.spacing
        rows = waves.approach_of_heights(
            heights(self.scene), (spacing, spacing), self.contact, loads_n
        )
        places = np.arange(self.steps) * round(self.scene.step_nodes) % rows.shape[1]
        return np.asarray(rows[:, places])


# ---- loads


def contact_loads(geometry: BearingGeometry, ring: LoadedRing) -> tuple[float, ...]:
    """Return the ascending loads [N] at which the contacts of a bearing are marched.

    They reach from half of the least load of a ball to twice the largest, in ratios of two at
    most. Loads below an eighth of the largest, at the edge of a load zone, are left out: they carry
    little force.
    """
    balances = balances_around(geometry, ring)
    balls = [balance.ball_load_n for balance in balances]
    largest = float(np.max(balls))
    least = max(float(np.min(balls)) / 2, LEAST_OF_LARGEST * largest)
    most = 2 * largest
    count = math.ceil(round(math.log(most / least, LOAD_RATIO), 6)) + 1
    return tuple(float(f"{load:.4g}") for load in np.geomspace(least, most, count))


# ---- scenes


@dataclass(frozen=True)
class MarchNumbers:
    """Grid of a march: spacing, width, length and step; tolerance of the solver."""

    spacing_um: float
    width_um: float
    distance_mm: float
    step_nodes: float
    tolerance: float | Literal["auto"] = "auto"


def march_numbers(
    contact: RacewayContact,
    laws: Sequence[Roughness],
    loads_n: Sequence[float],
    *,
    speed_m_s: float,
    turn_m: float,
    window_mm: float,
    spacing_um: float | None = None,
    tolerance: float | Literal["auto"] = "auto",
) -> MarchNumbers:
    """Return the grid on which a contact is marched.

    Parameters
    ----------
    contact : RacewayContact
        Smooth contact.
    laws : sequence of Roughness
        Laws of the surface, none for a smooth one.
    loads_n : sequence of float, N
        Loads of the marches, which share the grid.
    speed_m_s : float, m/s
        Rolling speed.
    turn_m : float, m
        Circumference of the body, which the track does not exceed.
    window_mm : float, mm
        Wanted length of the closed track; it holds two contacts at least.
    spacing_um : float, optional, um
        Distance of nodes. Default: as the contact and the surface need it.
    tolerance : float or "auto"
        Tolerance of the solver. Default: as the roughness needs it.
    """
    lightest = waves.semi_axes(contact, min(loads_n)).along
    roughness = math.sqrt(sum(law.rq_m**2 for law in laws))
    reach = overlap_reach(contact, max(loads_n), roughness)
    if spacing_um is None:
        lengths = [min(law.lengths_um) / NODES_PER_LENGTH for law in laws]
        wanted_um = min([lightest * 1e6 / NODES_PER_AXIS, *lengths])
        least_um = 1e6 * math.sqrt(4 * reach[0] * reach[1] / WINDOW_NODES)
        spacing_um = float(f"{max(wanted_um, least_um):.2g}")
    spacing = spacing_um * 1e-6
    longest = min(lightest / STEPS_PER_AXIS, speed_m_s / (2 * MARGIN * HEARD_HZ))
    for law in laws:
        shortest = law.lengths_um[0] * 1e-6 / STEPS_PER_LENGTH
        longest = min(longest, shortest / 2 if law.goes_on else shortest)
    fitting = [nodes for nodes in STEP_NODES if nodes >= 1 and nodes * spacing <= longest]
    step_nodes = max(fitting, default=1.0)
    width_nodes = rounded_width(2 * ROOM * reach[1] / spacing)
    length = min(max(window_mm * 1e-3, LEAST_CONTACTS * 2 * reach[0]), turn_m)
    steps = max(round(length / (step_nodes * spacing)), 2 * MIN_NODES)
    return MarchNumbers(
        spacing_um=spacing_um,
        width_um=width_nodes * spacing_um,
        distance_mm=steps * step_nodes * spacing_um * 1e-3,
        step_nodes=step_nodes,
        tolerance=tolerance,
    )


def rounded_width(least_nodes: float) -> int:
    """Return the nodes of a width, in quarters of an octave.

    A little more roughness or load then seldom changes the width, and with it the random heights.
    """
    octave = 1 << math.floor(math.log2(max(least_nodes, MIN_NODES)))
    quarters = math.ceil(4 * max(least_nodes, MIN_NODES) / octave)
    return max(octave * quarters // 4, MIN_NODES)


def overlap_reach(
    contact: RacewayContact, load_n: float, roughness_m: float
) -> tuple[float, float]:
    """Return how far contact can reach along and across the track [m] on a rough surface."""
    highest = waves.hertz_approach(contact, load_n) + HIGHEST * roughness_m
    along = math.sqrt(2 * contact.radius_along_m * highest)
    across = math.sqrt(2 * contact.radius_across_m * highest)
    return along, across


@dataclass(frozen=True)
class ContactKind:
    """What all marches of a kind of contact share.

    name : str. "inner", "outer", "balls-on-inner" or "balls-on-outer".
    contact : RacewayContact. The smooth contact.
    numbers : MarchNumbers. Grid.
    loads_n : tuple of float, N. Ascending loads.
    speed_m_s : float, m/s. Rolling speed.
    body : dict. Keys of the material of rings and balls, as of `sphere` and `plate`.
    """

    __repr__ = short_repr

    name: str
    contact: RacewayContact
    numbers: MarchNumbers
    loads_n: tuple[float, ...]
    speed_m_s: float
    body: dict[str, float | str]

    @property
    def middle_load_n(self) -> float:
        """Load that is marched first [N]."""
        return self.loads_n[len(self.loads_n) // 2]

    def scene_values(
        self, name: str, surface: dict[str, object], tolerance: float | str
    ) -> dict[str, object]:
        """Return the values of a scene at the middle load over a flat surface.

        The track over a file is as long as the file.
        """
        rolling = {"load_n": self.middle_load_n, "speed_m_s": self.speed_m_s}
        if surface["kind"] != "file":
            rolling["distance_mm"] = self.numbers.distance_mm
        radii = {
            "radius_mm": self.contact.radius_along_m * 1e3,
            "radius_across_mm": self.contact.radius_across_m * 1e3,
        }
        return {
            "name": name,
            "sphere": radii | self.body,
            "plate": self.body | {"hardness_gpa": "none"},
            "surface": surface,
            "rolling": rolling,
            "numerics": {"step_nodes": self.numbers.step_nodes, "tolerance": tolerance},
        }


def contact_scene(
    kind: ContactKind, name: str, law: Roughness | None, faults: Sequence[SurfaceFault] = ()
) -> Scene:
    """Return the scene of a contact at the middle load over a flat surface.

    Parameters
    ----------
    kind : ContactKind
        Kind of contact.
    name : str
        Name of the scene.
    law : Roughness or None
        Law of the surface, None for a smooth one.
    faults : sequence of SurfaceFault
        Single faults with their places on the flat surface.

    Raises
    ------
    SceneError
        A value is not allowed.
    """
    tolerance: float | str = kind.numbers.tolerance
    if tolerance == "auto":
        tolerance = _tolerance(kind.contact, law, kind.middle_load_n)
    surface: dict[str, object] = {"kind": "smooth"}
    if law is not None:
        fields = Roughness.model_fields
        values = law.model_dump(exclude_none=True)
        surface = {"kind": "gaussian"} | {key: values[key] for key in fields if key in values}
    surface |= {"spacing_um": kind.numbers.spacing_um, "width_um": kind.numbers.width_um}
    if faults:
        surface["faults"] = [fault.model_dump(exclude_none=True) for fault in faults]
    return Scene.from_dict(kind.scene_values(name, surface, tolerance))


def rough_contact(kind: ContactKind, law: Roughness) -> RoughContact:
    """Return the contacts of a kind over a rough surface, at all loads of the kind."""
    return RoughContact(
        name=kind.name,
        contact=kind.contact,
        scene=contact_scene(kind, kind.name, law),
        loads_n=kind.loads_n,
    )


def measured_contact(
    kind: ContactKind, turn: BallHeightFile, profile_width_um: float | None, folder: Path
) -> RoughContact:
    """Return the contacts of a kind over a measured turn, all of which is marched.

    Parameters
    ----------
    kind : ContactKind
        Kind of contact.
    turn : BallHeightFile
        File of the turn.
    profile_width_um : float or None, um
        Width of a single line, which is repeated across; None for a file that has a width.
    folder : Path
        Folder from which its path starts.

    Raises
    ------
    SceneError
        The file cannot be used.
    """
    surface: dict[str, object] = {
        "kind": "file",
        "path": turn.path,
        "height_unit": turn.height_unit,
        "spacing_um": turn.spacing_um,
        "level": "none",
    }
    if profile_width_um is not None:
        surface["width_um"] = profile_width_um
    values = kind.scene_values(kind.name, surface, kind.numbers.tolerance)
    return RoughContact(
        name=kind.name,
        contact=kind.contact,
        scene=Scene.from_dict(values, folder),
        loads_n=kind.loads_n,
    )


TOLERANCE = 1e-4  # of the solver, as `numerics.tolerance: auto` has it for moving bodies
SMOOTHEST = 0.1  # rms roughness over the approach, below which the tolerance falls
LEAST_TOLERANCE = 2e-6


def _tolerance(contact: RacewayContact, law: Roughness | None, load_n: float) -> float:
    """Return a tolerance that keeps the solver's error below the changes of the approach."""
    if law is None:
        return LEAST_TOLERANCE
    ratio = law.rq_m / waves.hertz_approach(contact, load_n) / SMOOTHEST
    return float(f"{max(LEAST_TOLERANCE, TOLERANCE * min(1.0, ratio)):.1g}")
