"""Scenes that are hard for contact solvers, by name.

The budget of a case is twice the number of iterations measured when the case was added. A slower
solver is therefore noticed before it hangs.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from acoustics.arrays import Array
from hard_cases.gaussian_heights import gaussian
from rolling.contact import closed_forms
from rolling.contact.state import RollingContact

STEEL = 210e9 / (1 - 0.3**2)  # E* [Pa] of the plate under a rigid sphere
CELL = 4e-12  # [m2], area of a node at the common spacing of 2 um

SOLVED = "solved"
CAPACITY = "load above capacity"
WIDTH = "contact wider than the surface"
ROOM = "window beyond all room"


@dataclass(frozen=True)
class HardCase:
    """A scene, the reason why it is hard, and its right outcome.

    Parameters
    ----------
    name, why : str. Name and reason.
    build : function. Makes the scene.
    budget : int. Maximum number of iterations of a state.
    steps, first : int. Number of steps and first position of the march. Default: 3 and 0.
    right : tuple of str. The right outcomes, from SOLVED, CAPACITY, WIDTH and ROOM. Default:
        SOLVED.
    lap : int. Steps of a lap. If it is positive, later laps must equal the first within the
        tolerance.
        Default: 0.
    group, feature : str. Group and surface in the report. Default: "named" and empty.
    """

    name: str
    why: str
    build: Callable[[], RollingContact]
    budget: int
    steps: int = 3
    first: int = 0
    right: tuple[str, ...] = (SOLVED,)
    lap: int = 0
    group: str = "named"
    feature: str = ""


def rough(
    along: int, across: int, ra: float, seed: int = 1, spacing: float = 2e-6, length: float = 10e-6
) -> Array:
    """Make Gaussian heights [m] (along, across) with this Ra and correlation length [m]."""
    return gaussian((along, across), spacing, ra, (length, length), "gaussian", seed)


def make_track(heights: Array, **changes: Any) -> RollingContact:
    """Make a steel plate under a 5 mm sphere at 5 N, with steps of a 2 um node."""
    scene: dict[str, Any] = {
        "spacing": 2e-6,
        "radius": 5e-3,
        "contact_modulus": STEEL,
        "hardness": np.inf,
        "load": 5.0,
        "start": 0.0,
        "blended": False,
        "tolerance": 1e-8,
    } | changes
    scene.setdefault("step", scene["spacing"])
    return RollingContact(heights=heights, **scene)


def rough_track(
    along: int, across: int, ra: float, length: float = 10e-6, **changes: Any
) -> RollingContact:
    """Make a rough plate, or a smooth plate for an Ra of 0."""
    heights = rough(along, across, ra, length=length) if ra else np.zeros((along, across))
    return make_track(heights, **changes)


def plastic_track(
    nodes: float, ra: float = 3e-7, size: int = 40, length: float = 10e-6, **changes: Any
) -> RollingContact:
    """Make a rough plate whose hardness makes the load span `nodes` capped nodes."""
    return rough_track(size, size, ra, length, load=nodes * changes["hardness"] * CELL, **changes)


def filled_track(share: float, ra: float) -> RollingContact:
    """Make a plate under a share of the maximum load that a period of the surface can carry."""
    return rough_track(30, 20, ra, hardness=1e6, load=share * 1e6 * 600 * CELL)


def stepped_track(
    height: float, where: tuple[Any, ...], ra: float = 1e-8, **changes: Any
) -> RollingContact:
    """Make a nearly smooth plate with raised nodes.

    The nodes at the index `where` stand out by `height` [m].
    """
    heights = rough(60, 60, ra)
    heights[where] += height
    return make_track(heights, **changes)


def extreme_track(
    load: float, radius: float, modulus: float, spacing: float, capped: bool
) -> RollingContact:
    """Make a plate whose roughness is a tenth of Hertz's approach.

    A capped plate has a hardness of 0.7 times Hertz's pressure.
    """
    heights = rough(
        100,
        90,
        0.1 * closed_forms.hertz_approach(load, radius, modulus),
        spacing=spacing,
        length=5 * spacing,
    )
    hardness = 0.7 * closed_forms.hertz_pressure(load, radius, modulus) if capped else np.inf
    return make_track(
        heights,
        load=load,
        radius=radius,
        contact_modulus=modulus,
        spacing=spacing,
        hardness=hardness,
        tolerance=1e-7,
    )


def ridged_track(along: int, across: int) -> RollingContact:
    """Make a plate with ridges along its shorter side."""
    rng = np.random.default_rng(1)
    heights = 2e-7 * rng.standard_normal((along, 1) if along < across else (1, across))
    return make_track(np.broadcast_to(heights, (along, across)).copy(), load=0.2, hardness=2.1e9)


def rolled_track(nodes: int) -> RollingContact:
    """Make a rough plate whose seam is moved along by `nodes` nodes."""
    return make_track(np.roll(rough(60, 60, 2e-7), nodes, axis=0), load=0.3, hardness=2.1e9)


def noise_track(hardness: float) -> RollingContact:
    """Make a plate of white noise of 13 um on a 2 um grid.

    The sphere is small, because a large sphere would also touch the periodic images.
    """
    heights = np.random.default_rng(5).standard_normal((60, 60)) * 1.3e-5
    return make_track(heights, load=0.001, radius=1e-4, hardness=hardness, tolerance=1e-7)


def vast_track() -> RollingContact:
    """Make 24 mm of smooth plate that is so soft that contact is 11 mm wide."""
    return make_track(np.broadcast_to(np.zeros(1), (12000, 12000)), hardness=1e5, load=28.0)


EXTREMES = {  # load [N], radius [m], E* [Pa], spacing [m]
    "1 uN": (1e-6, 5e-3, STEEL, 1e-8),
    "10 kN": (1e4, 1.0, STEEL, 2e-4),
    "10 kN on 5 mm": (1e4, 5e-3, STEEL, 4e-5),
    "R 1 m": (5.0, 1.0, STEEL, 2e-5),
    "R 50 um": (0.01, 50e-6, STEEL, 1e-7),
    "gel": (1e-6, 5e-3, 1e3 / 0.75, 5e-6),
    "diamond": (5.0, 5e-3, 1.15e12, 2e-6),
}
PLATES = {"elastic": np.inf, "capped": 2.1e9}


def _symmetric_and_plastic() -> list[HardCase]:
    """Return cases of symmetric or fully plastic contact."""
    ring = "by symmetry, all nodes of a ring change their bounds at once"
    trace = "heights of 1e-12 m under deflections of 4e-7 m hardly break the symmetry"
    whole = (
        "W / (H dA) is a whole number: p is 0 or H everywhere, no node is free, "
        "and the approach has an interval to lie in"
    )
    limit = "the contact area tends to W / H as E* rises: fewer and fewer nodes between the bounds"
    cases = [
        HardCase("smooth sphere", ring, partial(rough_track, 60, 61, 0.0, load=2.0), 40),
        HardCase("Ra 1e-12 m", trace, partial(rough_track, 60, 61, 1e-12, load=2.0), 40),
    ]
    for nodes in (1, 9, 21, 100):
        build = partial(plastic_track, nodes, hardness=1e6, radius=5e-4, tolerance=1e-6)
        cases.append(HardCase(f"all plastic, {nodes} nodes", whole, build, 80))
    for stiffer in (1, 10, 1000):
        changes = {
            "load": 0.2,
            "hardness": 2e8,
            "contact_modulus": stiffer * STEEL,
            "tolerance": 1e-6,
        }
        build = partial(rough_track, 60, 60, 5e-8, **changes)
        cases.append(HardCase(f"nearly rigid-plastic, {stiffer} E*", limit, build, 80, steps=0))
    return cases


def _refused() -> list[HardCase]:
    """Return cases that the solver must refuse."""
    beyond = (
        "no pressure below the hardness carries the load: a solver that only iterates would not end"
    )
    full = (
        "99 % of the capacity fills the period to its corners, more than a window of contact can "
        "hold"
    )
    wide = "the Hertz contact is wider than the surface: its periodic images would touch each other"
    vast = "the capacity suffices, but contact is 11 mm wide: no transform is large enough"
    cases = [
        HardCase(
            f"load {share:g} of the capacity",
            beyond,
            partial(filled_track, share, 1e-7),
            0,
            0,
            right=(CAPACITY,),
        )
        for share in (1.0, 1.001, 1e6)
    ]
    smooth = partial(rough_track, 30, 20, 0.0, load=5.0)
    return [
        *cases,
        HardCase(
            "load 0.99 of the capacity",
            full,
            partial(filled_track, 0.99, 1e-9),
            0,
            0,
            right=(WIDTH,),
        ),
        HardCase("contact wider than the surface", wide, smooth, 0, 0, right=(WIDTH,)),
        HardCase("window beyond all room", vast, vast_track, 0, 0, right=(ROOM,)),
    ]


def _steps_in_height() -> list[HardCase]:
    """Return cases with spikes, cliffs, trenches and steep slopes."""
    spike = (
        "one node stands out by up to 50 spacings; its pressure swings through the whole range as "
        "the sphere passes"
    )
    cliff = (
        "half of the plate lies 20 um lower, through the middle of the contact: "
        "pressure is singular along the edge"
    )
    trench = (
        "a groove 3 nodes wide and 100 um deep splits the contact in halves that only the "
        "deflection couples"
    )
    outlier = (
        "1 mm from a faulty instrument: the search for overlap covers a disc of 6 mm, "
        "and one node carries the load"
    )
    dwarf = (
        "springs turn 20 um into 1e8 times the pressures: the load loses its digits in a "
        "difference and must be restored"
    )
    slopes = "rms slope 9 each way: a few tips, far apart, 1e4 times their deflection high"
    cases = []
    for height, plate in (
        *((height, "elastic") for height in (1e-9, 1e-6, 1e-4, -1e-4)),
        *((height, "capped") for height in (1e-6, -1e-4)),
    ):
        name = f"{'spike' if height > 0 else 'hole'} of {abs(height):g} m, {plate}"
        build = partial(
            stepped_track, height, (2, 30), load=0.5, hardness=PLATES[plate], tolerance=1e-7
        )
        cases.append(HardCase(name, spike, build, 80, steps=6))
    halves: dict[str, tuple[Any, ...]] = {"along": (slice(30),), "across": (slice(None), slice(30))}
    grooves: dict[str, tuple[Any, ...]] = {
        "along": (slice(29, 32),),
        "across": (slice(None), slice(29, 32)),
    }
    for way, where in halves.items():
        for plate, hardness in PLATES.items():
            build = partial(stepped_track, 2e-5, where, load=0.3, hardness=hardness, tolerance=1e-7)
            cases.append(HardCase(f"cliff {way}, {plate}", cliff, build, 80, steps=8, first=24))
    for way, where in grooves.items():
        build = partial(stepped_track, -1e-4, where, load=0.5, hardness=2.1e9, tolerance=1e-7)
        cases.append(HardCase(f"trench {way}", trench, build, 80, first=28))
    for plate, hardness in PLATES.items():
        cases.append(
            HardCase(f"slopes of 9, {plate}", slopes, partial(noise_track, hardness), 80, steps=6)
        )
    build = partial(stepped_track, 1e-3, (40, 7), 1e-7, load=0.05, tolerance=1e-7)
    cases.append(HardCase("outlier of 1 mm", outlier, build, 20))
    # 1 uN is a round number of Pa; a third of it is not.
    build = partial(stepped_track, 2e-5, (slice(30),), load=1e-6 / 3, tolerance=1e-6)
    cases.append(HardCase("cliff of 20 um under 1/3 uN", dwarf, build, 40, first=10))
    return cases


def _sizes() -> list[HardCase]:
    """Return cases of extreme sizes, units and shapes, and a contact across the seam."""
    touch = (
        "one node carries the load: no iteration is needed, and its deflection is known in closed "
        "form"
    )
    units = "SI numbers from 1e-12 m to 1e12 Pa reveal any absolute threshold in the solver"
    odd = "ridges make the contact long and narrow: its windows differ in the two directions"
    seam = "contact lies across the seam of the periodic surface"
    cases = [HardCase("first touch", touch, partial(rough_track, 60, 60, 1e-7, load=1e-9), 10)]
    for name, numbers in EXTREMES.items():
        for plate in PLATES:
            build = partial(extreme_track, *numbers, capped=plate == "capped")
            cases.append(HardCase(f"{name}, {plate}", units, build, 60))
    for along, across in ((37, 61), (61, 37), (51, 200), (200, 51)):
        cases.append(
            HardCase(f"ridges on {along} x {across}", odd, partial(ridged_track, along, across), 80)
        )
    return [
        *cases,
        HardCase("seam", seam, partial(rolled_track, 0), 80, first=58),
        HardCase(
            "seam moved away",
            "the same heights without the seam",
            partial(rolled_track, 30),
            80,
            first=28,
        ),
    ]


def _many_bounds() -> list[HardCase]:
    """Return cases in which nearly all nodes change their bounds at once."""
    bound = (
        "a step is longer than the contact: half of the window starts on the wrong bound, "
        "and hardly a node is free"
    )
    trace = (
        "ten capped nodes carry all but a trace of the load, which no deflection shows but the "
        "load needs"
    )
    cases = []
    for nodes, hardness, radius, step in (
        (50.5, 1e6, 5e-5, 10),
        (0.5, 1e8, 5e-5, 10),
        (20.5, 1e6, 2e-5, 5),
        (5.5, 1e7, 2e-5, 10),
        (1.5, 1e8, 2e-5, 10),
    ):
        changes = {"hardness": hardness, "radius": radius, "step": step * 2e-6, "tolerance": 1e-4}
        build = partial(plastic_track, nodes, 1e-6, 50, 4e-6, **changes)
        cases.append(HardCase(f"{nodes} nodes bound at once", bound, build, 100, steps=12))
    for excess in (1e-6, 1e-10, -1e-10, 1e-12):
        build = partial(
            plastic_track, 10 + excess, 1e-6, 64, hardness=1e6, radius=2e-4, tolerance=1e-4
        )
        cases.append(HardCase(f"10 capped nodes {excess:+g}", trace, build, 20))
    return cases


def laps(count: int) -> HardCase:
    """Return a case of `count` laps of 30 steps on a tiny surface.

    Errors must not accumulate from lap to lap.
    """
    why = "a warm-started march must not gather error: each lap equals the first to its tolerance"
    build = partial(rough_track, 30, 36, 5e-8, load=0.03, hardness=2.1e9, tolerance=1e-5)
    return HardCase(f"{count} laps without drift", why, build, 40, steps=30 * count, lap=30)


CASES = [
    *_symmetric_and_plastic(),
    *_refused(),
    *_steps_in_height(),
    *_sizes(),
    *_many_bounds(),
    laps(10),
]
