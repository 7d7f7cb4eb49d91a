"""March of the sphere along the track: one warm-started contact solve per position.

Each window holds all nodes that can come into contact. The march is in distance, because a
quasi-static contact depends on its position, not on its speed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import numpy as np

from acoustics.arrays import instance
from acoustics.numbers import rounded
from acoustics.traps import ignoring_underflow
from rolling.contact import _position_kernels, closed_forms, solver
from rolling.contact._transform_kernels import MAX_NODES
from rolling.contact.half_space import HalfSpace
from rolling.contact.solver import ContactError, ConvergenceError
from rolling.contact.state import ContactState, RollingContact, Window

# Up to a step of so many nodes a window includes the next position as well, whose deflection is
# then known in advance.
LOOK_AHEAD = 4
# The tolerance of a cold start is multiplied by this factor, so that its error does not stand out
# among warm starts.
COLD_TIGHTENING = 0.1
_NOTHING = np.empty((0, 0))
_NO_STATE = 0, 0, _NOTHING, _NOTHING, np.inf


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
        got, own = getattr(half_space, name), getattr(contact, name)
        if got != own:
            raise ValueError(f"half_space: got {name} {got:g}, allowed: that of contact, {own:g}")
    _refuse_the_impossible(contact)
    states: list[ContactState] = []  # the last two
    for k in range(first, last + 1):
        here = contact.loaded_at(k)
        try:
            following = None
            # A change of the load on a plate that mostly yields may lead nowhere.
            with suppress(ConvergenceError):
                following = _follow(here, k, half_space, states) if states else None
            following = following or _start(here, k, half_space)
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


def _start(contact: RollingContact, k: int, half_space: HalfSpace) -> ContactState:
    """Solve from a Winkler foundation that fits Hertz."""
    radius, *factors = closed_forms.hertz_ellipse(*contact.radii)
    hertz = closed_forms.hertz_radius(contact.load, radius, contact.contact_modulus)
    stiffness = 4 * contact.contact_modulus / (np.pi * hertz)
    reach = max(hertz, np.sqrt(contact.load / (np.pi * contact.hardness))) * 1.5
    rows, columns = (int(np.ceil(reach * factor / contact.spacing)) + 2 for factor in factors)
    place = contact.position(k), contact.mid_width
    centre, middle = (round(distance / contact.spacing) for distance in place)
    nodes = Window(centre - rows, middle - columns, 2 * rows + 1, 2 * columns + 1)
    nodes = Window.around([nodes, contact.overlap(k, hertz**2 / radius)])
    window = Window(*_position_kernels.room(tuple(nodes), contact.subcells))
    pressure = _NOTHING  # of a window that the solve refuses, because it is too large
    if max(window.cells(contact.subcells)[2:]) <= MAX_NODES:
        load, gap = contact.load, contact.gap(k, window)
        pressure = solver.foundation(gap, load, contact.spacing, stiffness, contact.hardness)
    whole_edges = 0.0, 0.0, 0.0, 0.0, 1.0
    cold = tuple(window), tuple(window), (pressure, _NOTHING), whole_edges, False
    return _solve(contact, k, half_space, (cold, _NO_STATE), COLD_TIGHTENING * contact.tolerance)


def _follow(
    contact: RollingContact, k: int, half_space: HalfSpace, states: list[ContactState]
) -> ContactState:
    """Solve the next position from one or two states."""
    old, before = states[-1], _NO_STATE
    known = old.approach, old.max_deflection, old.spread, old.sphere_share, old.edge_share
    fields, iterated = (old.pressure, old.deflection), old.iterations > 0
    last = tuple(old.window), tuple(old.loaded), fields, known, iterated
    if len(states) > 1:
        first = states[0]
        before = *first.window[:2], first.pressure, first.deflection, first.approach
    return _solve(contact, k, half_space, (last, before), contact.tolerance)


def _solve(
    contact: RollingContact, k: int, half_space: HalfSpace, given: tuple[Any, Any], tolerance: float
) -> ContactState:
    """Solve a position from the states that `solve_position` of the kernels takes."""
    spacing, sphere, cell = contact.spacing, contact.sphere(k), contact.spacing**2
    nodes = round(contact.step / spacing)
    nodes = nodes if nodes * spacing == contact.step else 0
    ahead = contact.sphere(k + 1)[3] if contact.step <= LOOK_AHEAD * spacing else np.nan
    numbers = float(contact.hardness), float(contact.load / cell), float(tolerance)
    # Most windows fit these arrays; the compiled code asks for larger ones.
    room = 500 + 5 * given[0][2][0].size // 4
    lines = (3 if given[0][3][4] else 5) if contact.has_blended_edges else 2
    fields, measures, counts, window, loaded, share, measured = solver.complete(
        half_space,
        _position_kernels.solve_position,
        np.empty((lines, room)),
        (contact.heights, tuple(contact.maxima)),
        (sphere, ahead, *contact.least_deflection, contact.subcells, nodes),
        given,
        (*numbers, solver.levelled_range(half_space, contact.hardness)),
        (contact.single, contact.has_blended_edges, contact.slopes),
    )
    size, shape = window[2] * window[3], window[2:]
    p, u, *edge = (line[:size].reshape(shape) for line in fields)
    approach, u_max, worst, edge_share, _ = measures
    count, capped, maximum, work, spread = measured
    _refuse_wide(contact, loaded[2] * spacing, loaded[3] * spacing)
    areas, energy = (count * cell, capped * cell), 0.5 * work * cell
    return ContactState(
        *(k, Window(*window), Window(*loaded), p, u, approach, *areas, maximum, u_max, energy),
        *(worst / u_max, *counts[:2], edge[0] if edge else None, edge_share, share, spread),
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
    for needed, nodes, way in (
        (along, rows, "along the track"),
        (across, columns, "across the track"),
    ):
        period = nodes * contact.spacing
        if needed > period:
            raise ContactError(
                f"contact is {rounded(needed * 1e6, 4)} um wide {way}, more than one period of the"
                f" surface ({rounded(period * 1e6, 4)} um); it needs a surface of more than"
                f" {rounded(needed * 1e6, 4)} um {way}"
            )
