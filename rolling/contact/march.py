"""March of the sphere along the track: one warm-started contact solve per position.

Each window holds all nodes that can come into contact. The march is in distance, because a
quasi-static contact depends on its position, not on its speed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from acoustics.arrays import Array, instance
from acoustics.numbers import rounded
from acoustics.traps import ignoring_underflow
from rolling.contact import _position_kernels as kernels
from rolling.contact import closed_forms, solver
from rolling.contact.half_space import MAX_NODES, HalfSpace
from rolling.contact.solver import (
    ContactError,
    ContactPlate,
    ConvergenceError,
    Problem,
    Solution,
    Start,
)
from rolling.contact.state import ContactState, RollingContact, Window

# Up to a step of so many nodes a window includes the next position as well, whose deflection is
# then known in advance.
LOOK_AHEAD = 4
# The tolerance of a cold start is multiplied by this factor, so that its error does not stand out
# among warm starts.
COLD_TIGHTENING = 0.1
# This is the minimum useful weight of the sphere-fixed start at the second position. Below it the
# plate-fixed start converges as fast and needs no mixing.
MIN_SHARE = 0.2
# Later positions mix above this weight only, which plates of Ra 1 nm or less reach, and yielding
# contacts of more than some 350 nodes across. Below it the extrapolation of two positions takes
# fewer convolutions: 5 instead of 7 or 8 per step at weights of 0.3 to 0.7, as many at 0.97, but 5
# instead of 3 at 1.
STEADY_SHARE = 0.98
# A window has room for a load spread so many times as wide as at the position before.
ROOM = 1.1
_NOTHING = np.empty((0, 0))
_FLAT = np.zeros((1, 1))


@ignoring_underflow
def march(
    contact: RollingContact, first: int, last: int, half_space: HalfSpace
) -> Iterator[ContactState]:
    """Solve the contact at the positions first, first + 1, ..., last.

    The march begins with a cold start at the first position. The states depend on `first` but not
    on earlier marches, so pieces of a track may be marched anywhere.

    Parameters
    ----------
    contact : RollingContact
        Sphere, plate and accuracy.
    first, last : int
        Positions; the step of the contact is their distance.
    half_space : HalfSpace
        Half-space with the spacing and modulus of the contact.

    Yields
    ------
    ContactState
        State at each position.

    Raises
    ------
    ContactError
        The load is above capacity, the contact is wider than the surface, or a solve did not
        converge; the message has the position.
    TypeError
        The contact or the half-space is of another type, or a position is no whole number.
    ValueError
        The half-space has another spacing or modulus than the contact, or a position lies so far
        from the beginning of the track that double precision does not tell places apart there.

    Examples
    --------
    A steel sphere of 5 mm radius rolls over a smooth plate under 5 N; Hertz gives a contact area of
    5906 um2:

    >>> import numpy as np, rolling
    >>> contact = rolling.RollingContact(
    ...     heights=np.zeros((128, 128)), spacing=4e-6, radius=5e-3, contact_modulus=230e9,
    ...     hardness=np.inf, load=5.0, step=4e-6, start=0.0, tolerance=1e-5,
    ... )
    >>> states = list(rolling.march(contact, 0, 3, rolling.HalfSpace(4e-6, 230e9)))
    >>> [round(state.contact_area * 1e12, -3) for state in states]
    [6000.0, 6000.0, 6000.0, 6000.0]
    """
    instance("contact", contact, RollingContact)
    instance("half_space", half_space, HalfSpace)
    for name, position in (("first", first), ("last", last)):
        _refuse_far(contact, name, position)
    for name in ("spacing", "contact_modulus", "subcells"):
        got = getattr(half_space, name)
        own = getattr(contact, name)
        if got != own:
            raise ValueError(f"half_space: got {name} {got:g}, allowed: that of contact, {own:g}")
    _refuse_the_impossible(contact)
    plate = ContactPlate(
        half_space=half_space,
        hardness=float(contact.hardness),
        single=contact.single,
        blended=contact.has_blended_edges,
        levelled=solver.levelled_range(half_space, float(contact.hardness)),
    )
    states: list[ContactState] = []  # the last two
    for k in range(first, last + 1):
        here = contact.loaded_at(k) if contact.loads is not None else contact
        try:
            following = None
            # A change of the load on a plate that mostly yields may lead nowhere.
            with suppress(ConvergenceError):
                following = _follow(here, k, plate, states) if states else None
            following = following or _start(here, k, plate)
        except ContactError as error:
            raise ContactError(
                f"step {k} (sphere at {contact.position(k) * 1e3:.4f} mm): {error}"
            ) from error
        states = [*states[-1:], following]
        yield following


def _refuse_far(contact: RollingContact, name: str, position: Any) -> None:
    """Raise TypeError for a position that is no whole number, and ValueError for one too far."""
    if isinstance(position, bool):
        raise TypeError(f"{name}: got {position}, allowed: int")
    instance(name, position, int, np.integer)
    lowest = math.ceil((-contact.farthest_m - contact.start) / contact.step)
    highest = math.floor((contact.farthest_m - contact.start) / contact.step)
    if not lowest <= position <= highest:
        raise ValueError(f"{name}: got {position}, allowed: {lowest} to {highest}")


@dataclass(frozen=True)
class PositionStart:
    """Window and start of a position.

    The window holds contact up to an approach [m] and a spread of the load [m]. Edges are sharp at
    first if `sharp`. `sphere_share` of the pressures moved with the sphere.
    """

    window: Window
    start: Start
    approach: float = -np.inf
    spread: float = np.inf
    sharp: bool = False
    sphere_share: float = 0.0


def _start(contact: RollingContact, k: int, plate: ContactPlate) -> ContactState:
    """Solve from a Winkler foundation that fits Hertz."""
    radius, *factors = closed_forms.hertz_ellipse(*contact.radii)
    hertz = closed_forms.hertz_radius(contact.load, radius, contact.contact_modulus)
    stiffness = 4 * contact.contact_modulus / (np.pi * hertz)
    reach = max(hertz, np.sqrt(contact.load / (np.pi * contact.hardness))) * 1.5
    rows, columns = (int(np.ceil(reach * factor / contact.spacing)) + 2 for factor in factors)
    place = contact.position(k), contact.mid_width
    centre, middle = (round(distance / contact.spacing) for distance in place)
    nodes = Window(centre - rows, middle - columns, 2 * rows + 1, 2 * columns + 1)
    window = Window.around([nodes, contact.overlap(k, hertz**2 / radius)]).room(contact.subcells)
    _refuse_large(window, contact.subcells)
    load = contact.load
    gap = contact.gap(k, window)
    pressure = solver.foundation(gap, load, contact.spacing, stiffness, contact.hardness)
    cold = PositionStart(window, Start(pressure, _NOTHING, close=False))
    return _solve(contact, k, plate, cold, COLD_TIGHTENING * contact.tolerance)


def _follow(
    contact: RollingContact, k: int, plate: ContactPlate, states: list[ContactState]
) -> ContactState:
    """Solve the next position from one or two states."""
    return _solve(contact, k, plate, _warm_start(contact, k, plate, states), contact.tolerance)


def _warm_start(
    contact: RollingContact, k: int, plate: ContactPlate, states: list[ContactState]
) -> PositionStart:
    """Start from pressures that stayed with the plate, or with the sphere on a smooth plate."""
    old = states[-1]
    before = states[0] if len(states) > 1 else None
    geometry = contact.geometry
    rise = np.inf if before is None else abs(old.approach - before.approach)
    approach = old.approach + min(4 * rise, 0.1 * old.max_deflection)
    spread = ROOM * old.spread
    needed = old.loaded.joined(geometry.overlap(k, approach, contact.load, spread))
    window = needed
    if contact.step <= LOOK_AHEAD * contact.spacing:
        window = window.joined(geometry.overlap(k + 1, approach, contact.load, spread))
    window = window.room(contact.subcells)
    _refuse_large(window, contact.subcells)
    pressure = np.empty((window.rows, window.columns))
    deflection = _NOTHING
    old.window.move(old.pressure, window, pressure)
    extrapolation = solver.NO_POSITION
    share = 0.0
    if before is None or old.sphere_share > STEADY_SHARE:
        share, deflection = _towards_the_sphere(contact, k, old, (window, needed), pressure)
    if share == 0 and old.window.covers(needed):
        deflection = plate.scratch.array("deflection of the start", pressure.shape)
        old.window.move(old.deflection, window, deflection, continued=True)
        if before is not None:
            row = before.window.row - window.row
            column = before.window.column - window.column
            extrapolation = before.pressure, before.deflection, row, column
    start = Start(pressure, deflection, close=True, before=extrapolation)
    return PositionStart(window, start, approach, spread, old.edge_share == 0.0, share)


def _towards_the_sphere(
    contact: RollingContact,
    k: int,
    old: ContactState,
    windows: tuple[Window, Window],
    pressure: Array,
) -> tuple[float, Array]:
    """Mix pressures that stayed with the plate with those that moved with the sphere.

    Returns the share of the latter, for a minimum of the energy, and the deflection. That is empty
    where it is unknown on nodes that are needed, and unless the last such start had to be iterated:
    a smooth sphere accepts it as it is, after a check that computes the deflection anew.
    """
    window, needed = windows
    nodes = round(contact.step / contact.spacing)
    if not nodes or nodes * contact.spacing != contact.step:
        return 0.0, _NOTHING
    onward = old.window.shifted(nodes)
    if not window.covers(old.loaded.shifted(nodes)):
        return 0.0, _NOTHING
    deflection = old.window.moved(old.deflection, window, continued=True)
    onward_p = onward.moved(old.pressure, window)
    onward_u = onward.moved(old.deflection, window, continued=True)
    gap = np.empty(pressure.shape)
    contact.geometry.gap(k, window, gap)
    share = kernels.share_of_the_sphere(gap, (pressure, deflection), (onward_p, onward_u))
    if share < MIN_SHARE:
        return 0.0, _NOTHING
    kernels.mix(pressure, onward_p, share, float(contact.hardness))
    kernels.mix(deflection, onward_u, share, np.inf)
    iterated = old.iterations > 0 and old.sphere_share > 0
    known = iterated and old.window.covers(needed) and onward.covers(needed)
    return share, deflection if known else _NOTHING


def _solve(
    contact: RollingContact, k: int, plate: ContactPlate, given: PositionStart, tolerance: float
) -> ContactState:
    """Solve a position, again on a larger window where contact may be outside of it."""
    window = given.window
    start = given.start
    sharp = given.sharp
    iterations = 0
    convolutions = 0
    while True:
        problem = _problem(contact, k, plate, window, tolerance)
        solution = solver.solve(problem, start, sharp or not plate.blended)
        iterations += solution.iterations
        convolutions += solution.convolutions
        cost = iterations, convolutions
        state = _state(contact, k, window, plate, solution, given.sphere_share, cost)
        if state.approach <= given.approach and state.spread <= given.spread:
            break
        overlap = contact.geometry.overlap(k, state.approach, contact.load, state.spread)
        wider = window.joined(overlap)
        if window.covers(wider):
            break
        wider = wider.room(contact.subcells)
        _refuse_large(wider, contact.subcells)
        pressure = window.moved(solution.pressure, wider)
        window = wider
        start = Start(pressure, _NOTHING, close=True)
        sharp = False
    loaded = state.loaded
    spacing = contact.spacing
    _refuse_wide(contact, loaded.rows * spacing, loaded.columns * spacing)
    return state


def _problem(
    contact: RollingContact, k: int, plate: ContactPlate, window: Window, tolerance: float
) -> Problem:
    """Return the contact on the window of a position."""
    geometry = contact.geometry
    shape = (window.rows, window.columns)
    gap = plate.scratch.array("gap", shape)
    geometry.gap(k, window, gap)
    within_cells = gap
    if plate.blended and not contact.slopes:
        within_cells = plate.scratch.array("gap within cells", shape)
        replace(geometry, heights=_FLAT).gap(k, window, within_cells)
    total = float(contact.load / contact.spacing**2)
    return Problem(plate, gap, within_cells, total, float(tolerance))


def _state(
    contact: RollingContact,
    k: int,
    window: Window,
    plate: ContactPlate,
    solution: Solution,
    sphere_share: float,
    cost: tuple[int, int],
) -> ContactState:
    """Measure a solution on its window; its cost is iterations and convolutions."""
    geometry = contact.geometry
    cell = contact.spacing**2
    loaded, (count, capped, maximum, work, spread) = kernels.measure(
        (solution.pressure, solution.deflection, solution.edge),
        (plate.hardness, plate.levelled),
        geometry.sphere(k),
        geometry.maxima[3],
        solution.approach,
        plate.blended,
        (window.row, window.column),
    )
    return ContactState(
        position=k,
        window=window,
        loaded=Window(*loaded),
        pressure=solution.pressure,
        deflection=solution.deflection,
        approach=solution.approach,
        contact_area=count * cell,
        plastic_area=capped * cell,
        max_pressure=maximum,
        max_deflection=solution.max_deflection,
        stored_energy=0.5 * work * cell,
        residual=solution.worst / solution.max_deflection,
        iterations=cost[0],
        convolutions=cost[1],
        edge=solution.edge if plate.blended else None,
        edge_share=solution.edge_share,
        sphere_share=sphere_share,
        spread=spread,
    )


def _refuse_large(window: Window, subcells: int) -> None:
    """Raise ContactError for a window that no transform is long enough for."""
    rows = window.rows // subcells
    columns = window.columns // subcells
    most = MAX_NODES if subcells == 1 else MAX_NODES - 4  # sub-cells need a border of one cell
    if max(rows, columns) > most:
        raise ContactError(
            f"the contact needs a window of {rows} by {columns} nodes, more than the {most} there"
            " is room for; take a larger spacing"
        )


def _refuse_the_impossible(contact: RollingContact) -> None:
    """Raise ContactError for a load above capacity or a contact wider than the surface."""
    area = contact.heights.size * contact.spacing**2
    if contact.load >= contact.hardness * area:
        raise ContactError(
            f"a load of {rounded(contact.load, 6)} N is more than the surface can carry: hardness"
            f" {rounded(contact.hardness, 6)} Pa times one period of {rounded(area, 4)} m2 is"
            f" {rounded(contact.hardness * area, 4)} N; take a lower load, a harder plate or a"
            " larger surface"
        )
    # A rough or yielding contact is at least as wide as the smooth elastic contact.
    radius, along, across = closed_forms.hertz_ellipse(*contact.radii)
    width = 2 * closed_forms.hertz_radius(contact.load, radius, contact.contact_modulus)
    _refuse_wide(contact, width * along, width * across)


def _refuse_wide(contact: RollingContact, along: float, across: float) -> None:
    """Raise ContactError for a contact [m] wider than one period of the surface."""
    rows, columns = contact.heights.shape
    for needed, nodes, way, key in (
        (along, rows, "along the track", "rolling.distance_mm"),
        (across, columns, "across the track", "surface.width_um"),
    ):
        period = nodes * contact.spacing
        if needed > period:
            wider = period * 2 ** math.ceil(math.log2(1.01 * needed / period))
            unit = 1e3 if key.endswith("_mm") else 1e6
            raise ContactError(
                f"contact is {rounded(needed * 1e6, 4)} um wide {way}, more than one period of the"
                f" surface ({rounded(period * 1e6, 4)} um); it needs a surface of more than"
                f" {rounded(needed * 1e6, 4)} um {way}, in a scene"
                f" {key}: {wider * unit:.10g}"
            )
