"""March of the sphere along the track: one warm-started contact solve per position.

Each window holds all nodes that can come into contact. The march is in distance, because a
quasi-static contact depends on its position, not on its speed.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from math import sqrt
from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array, instance
from acoustics.numbers import rounded
from rolling.contact import _window_kernels, closed_forms, solver
from rolling.contact._system import Limits
from rolling.contact._transform_kernels import MAX_NODES
from rolling.contact.half_space import HalfSpace
from rolling.contact.solver import Contact, ContactError, ConvergenceError, Previous, WarmStart
from rolling.contact.state import ContactState, RollingContact, Window

# Up to a step of so many nodes a window includes the next position as well, whose deflection is
# then known in advance.
LOOK_AHEAD = 4
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
# The tolerance of a cold start is multiplied by this factor, so that its error does not stand out
# among warm starts.
COLD_TIGHTENING = 0.1


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
        The half-space has another spacing or modulus than the contact.

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
        instance(name, position, int, np.integer)
    for name in ("spacing", "contact_modulus", "subcells"):
        got, own = getattr(half_space, name), getattr(contact, name)
        if got != own:
            raise ValueError(f"half_space: got {name} {got:g}, allowed: that of contact, {own:g}")
    _refuse_the_impossible(contact)
    state: ContactState | None = None
    before: ContactState | None = None
    for k in range(first, last + 1):
        here = contact.loaded_at(k)
        try:
            following = None
            # A change of the load on a plate that mostly yields may lead nowhere.
            with suppress(ConvergenceError):
                following = state and _follow(here, k, half_space, state, before)
            following = following or _start(here, k, half_space)
        except ContactError as error:
            raise ContactError(
                f"step {k} (sphere at {contact.position(k) * 1e3:.4f} mm): {error}"
            ) from error
        state, before = following, state
        yield state


class _Problem(NamedTuple):
    """Contact to be solved at position k on a window that holds it up to an approach and spread."""

    contact: RollingContact
    k: int
    half_space: HalfSpace
    window: Window
    gap: Array
    approach: float
    spread: float

    def solve(self, start: WarmStart, tolerance: float) -> Contact:
        """Solve the contact from a warm start to a tolerance."""
        contact, gap = self.contact, self.gap
        shape = contact.shape(self.k, self.window, gap)
        limits = Limits(float(contact.hardness), float(contact.load / contact.spacing**2))
        accuracy = tolerance, contact.single
        return solver.Problem(self.half_space, gap, shape, limits, *accuracy).solve(start)

    def wider(self, state: ContactState) -> _Problem | None:
        """Return the problem on a window for a state; None if this window holds all contact."""
        if state.approach <= self.approach and state.spread <= self.spread:
            return None
        overlap = self.contact.overlap(self.k, state.approach, state.spread)
        if overlap is None or self.window.covers(overlap):
            return None
        window = _room([self.window, overlap], self.contact.subcells)
        return self._replace(window=window, gap=self.contact.gap(self.k, window))


def _solve(
    problem: _Problem, start: WarmStart, tolerance: float, sphere_share: float = 0.0
) -> ContactState:
    """Solve the problem, again on a larger window where contact may be outside of the window.

    `sphere_share` is the share of the start that moved with the sphere.
    """
    iterations, before = 0, problem.half_space.count
    while True:
        solved = problem.solve(start, tolerance)
        iterations += solved.iterations
        cost = iterations, problem.half_space.count - before
        state = _state(problem, solved, cost, sphere_share)
        wider = problem.wider(state)
        if wider is None:
            return state
        start = WarmStart(problem.window.moved(solved.pressure, wider.window), close=True)
        problem = wider


def _state(
    problem: _Problem, solved: Contact, cost: tuple[int, int], sphere_share: float
) -> ContactState:
    """Measure a solved contact: its loaded block, areas, maxima and energy."""
    contact, window = problem.contact, problem.window
    edge = np.empty((0, 0)) if solved.edge is None else solved.edge
    fields = solved.pressure, solved.deflection, contact.hardness
    spacing, *radii, x, y = contact.sphere(problem.k)
    overlap = max(contact.farthest_gap(solved.approach) + contact.maxima.highest, 0.0)
    reach = sqrt(2 * max(radii) * overlap) / spacing
    centre = x / spacing - window.row, y / spacing - window.column
    numbers = solver.levelled_range(problem.half_space, contact.hardness), *centre, reach
    measured = _window_kernels.measures(*fields, edge, *numbers)
    count, capped, maximum, work, spread, *block = measured
    if edge.size and maximum < contact.hardness:  # there is no patch that could end within a cell
        count, capped, *_ = _window_kernels.measures(*fields, np.empty((0, 0)), *numbers)
    cell = contact.spacing**2
    row, last_row, column, last_column = block
    rows, columns = last_row - row + 1, last_column - column + 1
    loaded = Window(window.row + row, window.column + column, rows, columns)
    _refuse_wide(contact, rows * contact.spacing, columns * contact.spacing)
    areas = count * cell, capped * cell
    largest = float(maximum), solved.max_deflection
    fields = solved.pressure, solved.deflection, solved.approach
    edges, energy = (solved.edge, solved.edge_share), 0.5 * float(work) * cell
    return ContactState(
        *(problem.k, window, loaded, *fields, *areas, *largest, energy, solved.residual),
        *(*cost, *edges, sphere_share, contact.spacing * float(spread)),
    )


def _start(contact: RollingContact, k: int, half_space: HalfSpace) -> ContactState:
    """Solve from a Winkler foundation that fits Hertz."""
    radius, *factors = closed_forms.hertz_ellipse(*contact.radii)
    hertz = closed_forms.hertz_radius(contact.load, radius, contact.contact_modulus)
    stiffness = 4 * contact.contact_modulus / (np.pi * hertz)
    reach = max(hertz, np.sqrt(contact.load / (np.pi * contact.hardness))) * 1.5
    rows, columns = (int(np.ceil(reach * factor / contact.spacing)) + 2 for factor in factors)
    place = contact.position(k), contact.mid_width
    centre, middle = (round(distance / contact.spacing) for distance in place)
    around = Window(centre - rows, middle - columns, 2 * rows + 1, 2 * columns + 1)
    window = _room([around, contact.overlap(k, hertz**2 / radius)], contact.subcells)
    gap = contact.gap(k, window)
    pressure = solver.foundation(gap, contact.load, contact.spacing, stiffness, contact.hardness)
    problem = _Problem(contact, k, half_space, window, gap, -np.inf, np.inf)
    return _solve(problem, WarmStart(pressure), COLD_TIGHTENING * contact.tolerance)


def _follow(
    contact: RollingContact,
    k: int,
    half_space: HalfSpace,
    state: ContactState,
    before: ContactState | None,
) -> ContactState:
    """Solve the next position from pressures that stayed with the plate.

    On a smooth plate pressures move with the sphere instead. The start is then the mixture of both
    with minimum energy, as long as this pays. Both deflections are known, so finding the mixture
    needs no convolution.
    """
    change = abs(state.approach - before.approach) if before else np.inf
    approach = state.approach + min(4 * change, 0.1 * state.max_deflection)
    limits = approach, ROOM * state.spread
    needed = Window.around([state.loaded, contact.overlap(k, *limits)])
    near = contact.step <= LOOK_AHEAD * contact.spacing
    ahead = contact.overlap(k + 1, *limits) if near else None
    window = _room([needed, ahead], contact.subcells)
    problem = _Problem(contact, k, half_space, window, contact.gap(k, window), *limits)
    pressure = state.window.moved(state.pressure, window)
    sphere_share, deflection, previous = 0.0, None, None
    if before is None or state.sphere_share > STEADY_SHARE:
        sphere_share, pressure, deflection = _towards_the_sphere(problem, state, needed, pressure)
    if sphere_share == 0 and state.window.covers(needed):
        deflection = state.window.moved(state.deflection, window, continued=True)
        if before is not None:
            row, column = before.window.row - window.row, before.window.column - window.column
            previous = Previous(before.pressure, before.deflection, row, column)
    start = WarmStart(pressure, deflection, previous, close=True, sharp=state.edge_share == 0.0)
    return _solve(problem, start, contact.tolerance, sphere_share)


def _towards_the_sphere(
    problem: _Problem, state: ContactState, needed: Window, start: Array
) -> tuple[float, Array, Array | None]:
    """Find the best share of sphere-fixed pressures and mix them with plate-fixed pressures.

    Returns the share, the mixed pressures, and their deflection. That is None where it is unknown
    on nodes that are needed, and unless the last such start had to be iterated: a smooth sphere
    accepts it as it is, after a check that computes the deflection anew.
    """
    contact, window = problem.contact, problem.window
    nodes = round(contact.step / contact.spacing)
    moved_on = state.window._replace(row=state.window.row + nodes)
    if nodes * contact.spacing != contact.step or not window.covers(
        state.loaded._replace(row=state.loaded.row + nodes)
    ):
        return 0.0, start, None
    offset = state.window.row - window.row, state.window.column - window.column
    slope, curvature = _window_kernels.towards_the_sphere(
        state.pressure, state.deflection, problem.gap, *offset, nodes
    )
    share = min(-slope / curvature, 1.0) if slope < 0 < curvature else 0.0
    if share < MIN_SHARE:
        return 0.0, start, None
    mixed = start + share * (moved_on.moved(state.pressure, window) - start)
    np.clip(mixed, 0.0, contact.hardness, out=mixed)
    iterated = state.sphere_share > 0 and state.iterations > 0
    if not (iterated and state.window.covers(needed) and moved_on.covers(needed)):
        return share, mixed, None
    deflection = state.window.moved(state.deflection, window, continued=True)
    deflection += share * (moved_on.moved(state.deflection, window, continued=True) - deflection)
    return share, mixed, deflection


def _room(windows: list[Window | None], subcells: int) -> Window:
    """Return the window of the solve: the given windows and a border, in whole cells."""
    window = Window.around(windows).bordered().whole(subcells)
    rows, columns = window.rows // subcells, window.columns // subcells
    # The transforms of sub-cells need a border of one cell all around.
    most = MAX_NODES if subcells == 1 else MAX_NODES - 4
    if max(rows, columns) > most:
        raise ContactError(
            f"the contact needs a window of {rows} by {columns} nodes, more than the"
            f" {most} there is room for; take a larger spacing"
        )
    return window


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
        (along, rows, "along the track", "rolling.duration_s or rolling.distance_mm"),
        (across, columns, "across the track", "surface.width_um"),
    ):
        period = nodes * contact.spacing
        if needed > period:
            raise ContactError(
                f"contact is {rounded(needed * 1e6, 4)} um wide {way}, more than one period of the"
                f" surface ({rounded(period * 1e6, 4)} um); raise {key} to more than"
                f" {rounded(needed * 1e6, 4)} um of surface"
            )
