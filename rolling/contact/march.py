"""Moves the sphere along the track, one contact solve per position, warm-started, on a window that contact cannot leave.

Depends on contact and half_space. The march is in distance: a quasi-static contact knows its position, not its speed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rolling.contact import _march_kernels, closed_forms, solver
from rolling.contact.half_space import MOST_NODES, HalfSpace
from rolling.contact.solver import ContactError

Array = NDArray[np.float64]

# Nodes: up to such a step a window reaches over the next position as well, whose deflection is then known in advance.
LOOK_AHEAD = 4
# Of pressures that move with the sphere: below it those of the plate alone are as good a start, for nothing.
LEAST_SHARE = 0.2
# Of half the range of gaps over a cell. By trial on the quickstart at 5 N (Ra 0.1 um, Gaussian law, 2.1 GPa), 2 um against
# 0.5 um: -20.1, -20.9, -19.8 dB at 0.5, 0.7, 0.9. Other scenes were not tried.
EDGE_SHARE = 0.7
# Of the largest deflection, so that cliffs do not make a contact soft; the edges of ground surfaces do not reach it.
MOST_EDGE = 0.2
# Positions before the first, in which blended edges forget most of the cold start. How much is left depends on the scene: over 100
# steps -66, -53, -57 dB of the release signal in the quickstart at 5, 20, 100 N, -97 dB at Ra 1 um, -46 dB and more on pits.
RUN_IN = 3
COLD_TIGHTENING = 0.1  # a cold start is solved this much tighter, so that its error does not stand out among warm ones


@dataclass(frozen=True)
class Window:
    """A block of nodes on the unrolled plate: its first row (along) and column (across), which may be negative, and its size."""

    row: int
    column: int
    rows: int
    columns: int

    @classmethod
    def spanning(cls, blocks: list[tuple[int, int, int, int]]) -> Window:
        """The smallest window over blocks given as (first row, last row, first column, last column)."""
        row, last_row = min(b[0] for b in blocks), max(b[1] for b in blocks)
        column, last_column = min(b[2] for b in blocks), max(b[3] for b in blocks)
        return cls(row, column, last_row - row + 1, last_column - column + 1)

    def covers(self, other: Window) -> bool:
        return (
            self.row <= other.row
            and self.column <= other.column
            and self.row + self.rows >= other.row + other.rows
            and self.column + self.columns >= other.column + other.columns
        )

    def bordered(self) -> Window:
        """With one more node on every side, open in any contact that this window cannot cut off."""
        return Window(self.row - 1, self.column - 1, self.rows + 2, self.columns + 2)

    def moved(self, values: Array, target: Window) -> Array:
        """Values (rows, columns) of this window as they stand in the target window; zero where this one does not reach."""
        out = np.empty((target.rows, target.columns))
        _march_kernels.copy_block(values, out, self.row - target.row, self.column - target.column)
        return out


@dataclass(frozen=True)
class RollingContact:
    """What is rolled over and by what. SI; heights (along, across), periodic both ways; hardness inf: purely elastic."""

    heights: Array
    spacing: float
    radius: float
    contact_modulus: float
    hardness: float
    load: float
    step: float
    start: float
    tolerance: float
    single: bool = True  # iterate on deflections of single precision (contact.solve)
    blended: bool = False  # nodes at the edge of yielding patches are loaded by the share of their cell in contact

    @cached_property
    def row_highest(self) -> Array:
        return self.heights.max(axis=1)

    @cached_property
    def highest(self) -> float:
        return float(self.row_highest.max())

    @property
    def has_blended_edges(self) -> bool:
        """An elastic contact has no patch at the hardness whose edge could be blended."""
        return self.blended and bool(np.isfinite(self.hardness))

    @property
    def mid_width(self) -> float:
        return (self.heights.shape[1] - 1) / 2 * self.spacing

    def position(self, k: int) -> float:
        """Distance along the track of the sphere's centre at position k [m]."""
        return self.start + k * self.step

    def overlap(self, k: int, approach: float) -> Window | None:
        """Where the undeformed gap is below the approach at position k: contact lies inside. None: nowhere."""
        block = _march_kernels.overlap_block(
            self.heights,
            self.row_highest,
            self.highest,
            self.spacing,
            self.radius,
            self.position(k),
            self.mid_width,
            approach,
        )
        return Window.spanning([block]) if block[1] >= block[0] else None

    def gap(self, k: int, window: Window) -> Array:
        """Undeformed gap [m] on a window at position k."""
        out = np.empty((window.rows, window.columns))
        _march_kernels.undeformed_gap(
            self.heights, self.spacing, self.radius, self.position(k), self.mid_width, window.row, window.column, out
        )
        return out


@dataclass(frozen=True)
class ContactState:
    """The solved contact at one position; SI. `loaded` is the bounding window of the nodes under pressure."""

    position: int
    window: Window
    loaded: Window
    pressure: Array
    deflection: Array
    approach: float
    contact_area: float
    plastic_area: float
    max_pressure: float
    max_deflection: float
    stored_energy: float
    residual: float
    iterations: int
    convolutions: int
    edge: Array | None = None  # half of the range of gaps over cells where a patch may end [m], of a blended march
    # Of the pressures the solve began with: moved with the sphere, the rest stayed with the plate.
    sphere_share: float = 0.0


def march(track: RollingContact, first: int, last: int, half_space: HalfSpace) -> Iterator[ContactState]:
    """Contact states at positions first, first + 1, ..., last; the first one from a cold start, a few positions earlier if blended.

    What comes out depends on `first`, not on what was marched before: pieces of a track may be marched anywhere.

    Raises
    ------
    ContactError : load above capacity, contact wider than the surface, or a solve that did not converge (with its position).
    """
    _refuse_the_impossible(track)
    state: ContactState | None = None
    before: ContactState | None = None
    for k in range(first - (RUN_IN if track.has_blended_edges else 0), last + 1):
        try:
            following = _start(track, k, half_space) if state is None else _follow(track, k, half_space, state, before)
        except ContactError as error:
            place = f"step {k}" if k >= first else f"on the way to step {first}"
            raise ContactError(f"{place} (sphere at {track.position(k) * 1e3:.4f} mm): {error}") from error
        state, before = following, state
        if k >= first:
            yield state


def _start(track: RollingContact, k: int, half_space: HalfSpace) -> ContactState:
    """A cold start: from springs that meet Hertz, on a window grown until contact cannot leave it."""
    hertz = closed_forms.hertz_radius(track.load, track.radius, track.contact_modulus)
    stiffness = 4 * track.contact_modulus / (np.pi * hertz)
    nodes = int(np.ceil(max(hertz, np.sqrt(track.load / (np.pi * track.hardness))) * 1.5 / track.spacing)) + 2
    centre, middle = round(track.position(k) / track.spacing), round(track.mid_width / track.spacing)
    approach = hertz**2 / track.radius
    window = _room(
        [Window(centre - nodes, middle - nodes, 2 * nodes + 1, 2 * nodes + 1), *_overlaps(track, k, approach)]
    )
    gap = track.gap(k, window)
    pressure = solver.foundation(gap, track.load, track.spacing, stiffness, track.hardness)
    state = _solve(track, k, half_space, window, gap, pressure, COLD_TIGHTENING * track.tolerance, -np.inf)
    return _blend(track, half_space, state) if track.has_blended_edges else state


def _blend(track: RollingContact, half_space: HalfSpace, state: ContactState) -> ContactState:
    """The same position once more, with its patches ending where its own gaps say."""
    gap = track.gap(state.position, state.window)
    edge = _edges(gap, state.pressure, state.deflection)
    return _solve(
        track,
        state.position,
        half_space,
        state.window,
        gap,
        state.pressure,
        COLD_TIGHTENING * track.tolerance,
        state.approach,
        nearby=True,
        edge=edge,
    )


def _edges(gap: Array, pressure: Array, deflection: Array, trend: Array | None = None) -> Array:
    """Half of the range of gaps [m] over cells that the edge of a patch at the hardness may cross (contact.solve's `edge`)."""
    out = np.empty_like(gap)
    most = MOST_EDGE * float(deflection.max())
    _march_kernels.cell_ranges(
        gap, deflection, np.empty((0, 0)) if trend is None else trend, pressure, EDGE_SHARE, most, out
    )
    return out


def _follow(
    track: RollingContact, k: int, half_space: HalfSpace, state: ContactState, before: ContactState | None
) -> ContactState:
    """The next position, from pressures that stayed with the plate, on a window of all that was loaded and all that can be.

    On a smooth plate pressures move with the sphere instead: the start is the mixture of both of least energy, as long as that is
    worth its while. Both deflections are known, so finding it takes no convolution.
    """
    change = abs(state.approach - before.approach) if before else np.inf
    approach = state.approach + min(4 * change, 0.1 * float(state.deflection.max()))
    needed = _span([state.loaded, *_overlaps(track, k, approach)])
    ahead = _overlaps(track, k + 1, approach) if track.step <= LOOK_AHEAD * track.spacing else []
    window = _room([needed, *ahead])
    gap = track.gap(k, window)
    start = state.window.moved(state.pressure, window)
    known = state.window.covers(needed)
    sphere_share = 0.0
    if before is None or state.sphere_share > 0:
        sphere_share, start = _towards_the_sphere(track, state, window, gap, start)
        known = known and sphere_share == 0
    deflection = state.window.moved(state.deflection, window) if known else None
    trend = None
    if before is not None and deflection is not None:
        trend = np.empty_like(start), np.empty_like(start)
        offset = before.window.row - window.row, before.window.column - window.column
        _march_kernels.trends(start, deflection, before.pressure, before.deflection, *offset, *trend)
    edge = None
    if track.has_blended_edges:
        deflection = half_space.deflection(start) if deflection is None else deflection
        edge = _edges(gap, start, deflection, trend[1] if trend else None)
    following = _solve(
        track,
        k,
        half_space,
        window,
        gap,
        start,
        track.tolerance,
        approach,
        nearby=True,
        deflection=deflection,
        trend=trend,
        edge=edge,
    )
    return replace(following, sphere_share=sphere_share)


def _towards_the_sphere(
    track: RollingContact, state: ContactState, window: Window, gap: Array, start: Array
) -> tuple[float, Array]:
    """Share of the pressures that best goes with the sphere, the rest staying with the plate, and the pressures so mixed."""
    nodes = round(track.step / track.spacing)
    moved_on = replace(state.window, row=state.window.row + nodes)
    if nodes * track.spacing != track.step or not window.covers(replace(state.loaded, row=state.loaded.row + nodes)):
        return 0.0, start
    offset = state.window.row - window.row, state.window.column - window.column
    slope, curvature = _march_kernels.towards_the_sphere(state.pressure, state.deflection, gap, *offset, nodes)
    share = min(-slope / curvature, 1.0) if slope < 0 < curvature else 0.0
    if share < LEAST_SHARE:
        return 0.0, start
    mixed = start + share * (moved_on.moved(state.pressure, window) - start)
    return share, np.clip(mixed, 0.0, track.hardness, out=mixed)


def _overlaps(track: RollingContact, k: int, approach: float) -> list[Window]:
    overlap = track.overlap(k, approach)
    return [] if overlap is None else [overlap]


def _solve(
    track: RollingContact,
    k: int,
    half_space: HalfSpace,
    window: Window,
    gap: Array,
    pressure: Array,
    tolerance: float,
    approach: float,
    **known: Any,
) -> ContactState:
    """Solve on the window, which holds the overlap up to `approach`; where the overlap of the answer is larger, on that.

    `known` goes to the solver: what is known of the start.
    """
    iterations, convolutions = 0, half_space.count
    while True:
        t = known.get("trend")
        solved = solver.solve_contact(
            half_space,
            gap,
            track.load,
            solver.WarmStart(
                pressure, known.get("deflection"), solver.Trend(*t) if t else None, known.get("nearby", False)
            ),
            track.hardness,
            known.get("edge"),
            solver.SolverOptions(tolerance, track.single),
        )
        iterations += solved.iterations
        if solved.approach <= approach:
            break
        overlap = track.overlap(k, solved.approach)
        if overlap is None or window.covers(overlap):
            break
        larger = _room([window, overlap])
        edge = known.get("edge")
        known = {"nearby": True, "edge": None if edge is None else window.moved(edge, larger)}
        pressure, window, gap = window.moved(solved.pressure, larger), larger, track.gap(k, larger)

    edge = known.get("edge")
    count, capped, greatest, work, *block = _march_kernels.loaded(
        solved.pressure, solved.deflection, track.hardness, edge is not None
    )
    cell = track.spacing**2
    loaded = Window(window.row + block[0], window.column + block[2], block[1] - block[0] + 1, block[3] - block[2] + 1)
    _refuse_wide(track, loaded.rows * track.spacing, loaded.columns * track.spacing)
    return ContactState(
        position=k,
        window=window,
        loaded=loaded,
        pressure=solved.pressure,
        deflection=solved.deflection,
        approach=solved.approach,
        contact_area=count * cell,
        plastic_area=capped * cell,
        max_pressure=float(greatest),
        max_deflection=float(solved.deflection.max()),
        edge=edge,
        stored_energy=0.5 * float(work) * cell,
        residual=solved.residual,
        iterations=iterations,
        convolutions=half_space.count - convolutions,
    )


def _room(windows: list[Window]) -> Window:
    """The window to solve on, over what it must hold."""
    window = _span(windows).bordered()
    if max(window.rows, window.columns) > MOST_NODES:
        raise ContactError(
            f"the contact needs a window of {window.rows} by {window.columns} nodes, more than the {MOST_NODES} there is room"
            " for; take a larger spacing"
        )
    return window


def _span(windows: list[Window]) -> Window:
    return Window.spanning([(w.row, w.row + w.rows - 1, w.column, w.column + w.columns - 1) for w in windows])


def _refuse_the_impossible(track: RollingContact) -> None:
    area = track.heights.size * track.spacing**2
    if track.load >= track.hardness * area:
        raise ContactError(
            f"a load of {track.load:g} N is more than the surface can carry: hardness {track.hardness:g} Pa times one period"
            f" of {area:.4g} m2 is {track.hardness * area:.4g} N; take a lower load, a harder plate or a larger surface"
        )
    # A rough or yielding contact is at least as wide as the smooth elastic one.
    width = 2 * closed_forms.hertz_radius(track.load, track.radius, track.contact_modulus)
    _refuse_wide(track, width, width)


def _refuse_wide(track: RollingContact, along: float, across: float) -> None:
    for needed, nodes, way, key in (
        (along, track.heights.shape[0], "along the track", "rolling.duration_s"),
        (across, track.heights.shape[1], "across the track", "surface.width_um"),
    ):
        period = nodes * track.spacing
        if needed > period:
            raise ContactError(
                f"contact is {needed * 1e6:.4g} um wide {way}, more than one period of the surface ({period * 1e6:.4g} um);"
                f" raise {key} to more than {needed * 1e6:.4g} um of surface"
            )
