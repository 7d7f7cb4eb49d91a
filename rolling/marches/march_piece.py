"""March of a piece, shown to observers; its arrays depend on the piece alone."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from acoustics.texts import printable
from rolling.check import cost, error_cost
from rolling.contact.march import march
from rolling.contact.processor_time import ProcessorTime
from rolling.contact.recovery import step_energy
from rolling.contact.solver import ContactError
from rolling.contact.state import ContactState, RollingContact
from rolling.contact.subcells import half_space_of
from rolling.in_si.contact_of_scene import rolling_contact
from rolling.in_si.scene_surface import continued_rows, heights, measured_rows
from rolling.marches.effort import ARRAY, PieceEffort
from rolling.marches.march_variables import FAILURE, SERIES_OF_KIND
from rolling.marches.observers import Events, Film, Maps, Observer, Series
from rolling.marches.passes import Sinking, run_in, unrolled
from rolling.marches.piece import Piece, contact_identity
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.surface.refined import cells_of_patch

# Side of a cell on a level, in the run's cells.
SIDES = {"tight": 1.0, "fine": 0.5, "coarse": 2.0, "detail": 0.5}


class _VirginContact(NamedTuple):
    """Contact of a piece over a virgin plate."""

    identity: str
    scene: Scene
    contact: RollingContact


_half_space = lru_cache(maxsize=4)(half_space_of)  # equal contacts share it
_last_contact: list[_VirginContact] = []  # at most one, which the next piece may share


def march_piece(piece: Piece) -> dict[str, NDArray[Any]]:
    """March a piece and return plain arrays by name.

    A piece beside the track returns its FAILURE where a contact has no solution: its run goes on
    without it.

    Raises
    ------
    ContactError : a contact of the track has no solution, or the height file was replaced.
    """
    began = ProcessorTime.now()
    contact = _contact_of(piece)
    surface = ProcessorTime.now().since(began)
    arrays = _marched(piece, contact)
    whole = ProcessorTime.now().since(began)
    effort = PieceEffort(
        surface_s=surface.work_s,
        march_s=whole.work_s - surface.work_s,
        compilation_s=whole.compilation_s,
    )
    return arrays | {ARRAY: np.array(effort)}


def _marched(piece: Piece, contact: RollingContact) -> dict[str, NDArray[Any]]:
    """March the contact of a piece and return its arrays."""
    scene = piece.scene
    first = piece.first
    last = piece.last
    if piece.kind == "error":  # its contact begins with the stretch
        first = 0
        last = piece.last - piece.first
    start = first
    sinking = None
    if scene.is_permanent and piece.kind in ("pass", "film"):
        start -= run_in(scene, first)
        contact = replace(contact, heights=unrolled(scene, contact.heights, last - start))
        sinking = Sinking(contact, start, first, scene.track.n_along)
    observers = _observers(piece, contact, first, last)
    try:
        _march(piece, contact, start, first, last, observers, sinking)
    except ContactError as error:
        if piece.kind in ("track", "pass"):
            raise
        return {FAILURE.name: np.array(str(error))}
    arrays: dict[str, NDArray[Any]] = {}
    for observer in observers:
        arrays |= observer.arrays()
    if piece.kind == "pass" and sinking is not None:
        arrays |= sinking.arrays()
    if piece.kind in SERIES_OF_KIND:
        return {name: arrays[name] for name in SERIES_OF_KIND[piece.kind]}
    return arrays


def _observers(piece: Piece, contact: RollingContact, first: int, last: int) -> list[Observer]:
    """Return the observers of a piece between two positions of its contact."""
    scene = piece.scene
    if piece.kind == "film":
        return [Film(contact, first, piece.stride)]
    observers: list[Observer] = [Series(first)]
    if piece.has_maps:
        observers.append(Maps(contact, first, last, scene.track.solved_steps))
        if scene.recovery.events:
            observers.append(Events(contact))
    return observers


def _march(
    piece: Piece,
    contact: RollingContact,
    start: int,
    first: int,
    last: int,
    observers: list[Observer],
    sinking: Sinking | None,
) -> None:
    """March from a start to a last position, and show all from a first position on to observers.

    An observer sees each state and the energies of the step that led to it. The plastic work is a
    part of the loading.
    """
    needs_energies = piece.kind not in ("load", "judge")
    left_end = piece.scene.recovery.rule == "left_end"
    half_space = _half_space(contact.spacing, contact.contact_modulus, contact.subcells)
    before: ContactState | None = None
    for state in march(contact, start, last, half_space):
        work = 0.0
        if sinking is not None:
            work = sinking.lower(state)
        if state.position < first:
            continue
        energy = None
        if before is not None and needs_energies:
            energy = step_energy(before, state, half_space, left_end)
            if work:
                energy = replace(energy, loading=energy.loading + work)
        for observer in observers:
            observer.observe(state, energy)
        before = state


def _contact_of(piece: Piece) -> RollingContact:
    """Return the contact that a piece marches.

    Raise ContactError if the height file is gone or has other bytes than the identity says.
    """
    scene = piece.scene
    try:
        if piece.sunk is None:
            contact = _virgin_contact(piece)
        else:
            contact = rolling_contact(scene, heights(scene) - piece.sunk)
        is_same = not scene.height_paths or contact_identity(scene) == piece.identity
    except SceneError as error:
        raise ContactError(
            f"the surface that was solved is gone or cannot be used: {error}"
        ) from error
    if not is_same:
        _last_contact.clear()
        files = printable(" or ".join(map(str, scene.height_paths.values())))
        raise ContactError(f"{files} is not the surface that was solved")
    if piece.kind == "error":
        virgin = contact if piece.sunk is None else None
        steps = piece.last - piece.first
        return level_contact(scene, piece.level, piece.first, steps, virgin)
    if piece.kind == "moving":
        return replace(contact, loads=piece.forces)
    if piece.kind in ("load", "judge"):
        return replace(contact, load=piece.load)
    return contact


def _virgin_contact(piece: Piece) -> RollingContact:
    """Return the contact of a piece over a virgin plate, which the next piece shares."""
    for last in _last_contact:
        if last.identity == piece.identity and last.scene == piece.scene:
            return last.contact
    contact = rolling_contact(piece.scene)
    _last_contact[:] = [_VirginContact(piece.identity, piece.scene, contact)]
    return contact


def _side(scene: Scene, level: str) -> float:
    """Return the side of a cell on a level, in the run's cells."""
    if level in SIDES:
        return SIDES[level]
    return 0.5 if error_cost.needs_finer_grid(scene) else 1.0


def level_contact(
    scene: Scene, level: str, first: int, steps: int, whole: RollingContact | None = None
) -> RollingContact:
    """Return the contact of a stretch on a level of accuracy, on the patch of surface around it.

    Position 0 of the contact is the first position of the stretch. All levels have the run's number
    of sub-cells per cell. The level "detail" has flat cells with the surface of the law at half the
    spacing, and so have "with_law" and "measured" where the own grid is too coarse for the law.
    `whole` is the contact of the run over a virgin plate, which is made by default.
    """
    if whole is None:
        whole = rolling_contact(scene)
    surface = heights(scene)
    side = _side(scene, level)
    spacing = whole.cell_spacing
    # Twice the radius of overlap holds the highest peaks, and a few nodes hold the run-in.
    rq, _ = cost.roughness(scene)
    margin = math.ceil((2 * cost.overlap_radius(scene, rq) + 8 * whole.step) / spacing)
    place = whole.position(first)
    row = math.floor(place / spacing) - margin
    rows = math.ceil(steps * whole.step / spacing) + 2 * margin
    if rows >= len(surface):
        row = 0
        rows = len(surface)
    rows += rows % 2
    if level == error_cost.DETAIL:
        slopes = False
        finer = continued_rows(scene, row, rows)
        cells = cells_of_patch(finer, 0, len(finer), 1.0, whole.subcells, slopes)
    elif level in (error_cost.WITH_LAW, error_cost.MEASURED):
        slopes = whole.slopes and side == 1
        finer = measured_rows(scene, row, rows, round(1 / side), level == error_cost.WITH_LAW)
        cells = cells_of_patch(finer, 0, len(finer), 1.0, whole.subcells, slopes)
    else:
        slopes = whole.slopes
        cells = cells_of_patch(surface, row, rows, side, whole.subcells, slopes)
    # Flat cells begin where the cells of the run begin, and places count from a centre. The nodes
    # of a surface with a law begin on a row.
    off_centre = 0.0
    if not slopes and level not in (error_cost.WITH_LAW, error_cost.MEASURED):
        off_centre = (side - 1) / 2 * spacing
    tolerance = scene.tolerance
    if level in ("tight", "fine"):
        tolerance = error_cost.tight_tolerance(scene)
    return replace(
        whole,
        heights=cells,
        slopes=slopes,
        spacing=whole.spacing * side,
        start=place - row * spacing - off_centre,
        tolerance=tolerance,
    )
