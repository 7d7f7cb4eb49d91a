"""Pieces of work: each marches some positions from a cold start and depends on its fields alone.

The numbers are therefore equal for any number of workers, and for a run that was interrupted.
"""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array
from acoustics.texts import printable
from rolling.check import cost, error_cost
from rolling.contact.march import march
from rolling.contact.recovery import step_energy
from rolling.contact.solver import ContactError
from rolling.contact.state import ContactState, RollingContact
from rolling.contact.subcells import half_space_of
from rolling.marches.observers import Events, Film, Maps, Observer, Series
from rolling.marches.passes import Sinking, run_in, unrolled
from rolling.scene.identity import contact_keys, digest
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.surface.contact_of_scene import rolling_contact
from rolling.surface.refined import cells_of_patch
from rolling.surface.scene_surface import continued_rows, heights

_half_space = lru_cache(maxsize=4)(half_space_of)  # which equal contacts share
_last: list[Any] = []  # identity and scene of a piece, and their contact, which the next shares
PIECE_STEPS = 200  # a cold start costs 4 % of them
# Side of a cell on a level, in the run's cells.
SIDES = {"tight": 1.0, "fine": 0.5, "coarse": 2.0, "detail": 0.5}
# Names of the arrays of each kind. Kinds other than the track and its passes return a `fault` where
# a contact cannot be solved, because the run goes on without them.
_SERIES = {
    "load": ("approach", "step_time"),
    "judge": ("approach", "step_time"),
    "moving": ("release_energy", "loading_energy", "energy_defect", "approach"),
    "error": ("release_energy", "approach", "plastic_area", "step_time"),
}


def contact_identity(scene: Scene) -> str:
    """Return the digest of all that changes the contact of a scene, without making its surface.

    A height file counts with the digest of its bytes. Raise SceneError if it is unreadable.
    """
    return digest(contact_keys(scene))


@dataclass(frozen=True, eq=False)
class Piece:
    """Positions that are marched from a cold start.

    scene : Scene. A scene without a sweep.
    identity : str. Contact identity, which the scene must still have when the piece is marched.
    kind : str. "track"; "pass", over a plate that remembers; "load", at another load; "judge", at a
        load between the others; "moving", under the load of each position; "error", on a level of
        accuracy; "film", for slow motion.
    first, last : int. First and last position.
    cost : float, s. Expected time.
    load : float, N. Load of the kinds "load" and "judge".
    forces : (positions,) array, N. Load at each position of a lap of the kind "moving".
    level : str. Level of the kind "error": "tight", "fine", "coarse" or "detail".
    stride : int. Positions from one map to the next of the kind "film".
    number : int. Index of the pass of the kind "pass".
    sunk : (along, across) array, m. Depth of the plate before the piece. Default: a virgin plate.
    """

    scene: Scene
    identity: str
    kind: str
    first: int
    last: int
    cost: float
    load: float = math.nan
    forces: Array | None = None
    level: str = ""
    stride: int = 0
    number: int = 0
    sunk: Array | None = None

    @cached_property
    def key(self) -> str:
        """File-safe text that is unique among the pieces of an identity."""
        suffixes = {"error": self.level, "film": str(self.stride), "pass": str(self.number + 1)}
        suffix = suffixes.get(self.kind, "")
        if self.kind in ("load", "judge"):
            suffix = _short_digest(self.load.hex().encode())
        elif self.forces is not None:
            suffix = _short_digest(self.forces.tobytes())
        return "-".join(filter(None, (self.kind, str(self.first), str(self.last), suffix)))


def _short_digest(content: bytes) -> str:
    """Return 16 hex digits of the SHA-256 of some bytes."""
    return hashlib.sha256(content).hexdigest()[:16]


def track_pieces(steps: int) -> list[tuple[int, int]]:
    """Return the first and last position of each piece of a track with `steps` steps."""
    return [(first, min(first + PIECE_STEPS, steps)) for first in range(0, steps, PIECE_STEPS)]


def march_piece(piece: Piece) -> dict[str, NDArray[Any]]:
    """March a piece and return plain arrays by name.

    Raises
    ------
    ContactError : a contact of the track cannot be solved, or the height file was replaced.
    """
    contact, scene = _contact_of(piece), piece.scene
    first, last = piece.first, piece.last
    if piece.kind == "error":
        first, last = 0, last - first
    observers: list[Observer] = [Series(first)]
    if piece.kind == "track" or (piece.kind == "pass" and piece.number + 1 == scene.passes):
        observers.append(Maps(contact, first, last, scene.track.solved_steps))
        if scene.recovery.events:
            observers.append(Events(contact))
    elif piece.kind == "film":
        observers = [Film(contact, first, piece.stride)]
    start, sinking = first, None
    if scene.is_permanent and piece.kind in ("pass", "film"):
        start -= run_in(scene, first)
        contact = replace(contact, heights=unrolled(scene, contact.heights, last - start))
        sinking = Sinking(contact, start, first, scene.track.n_along)
    try:
        _observe(piece, contact, (start, first, last), observers, sinking)
    except ContactError as error:
        if piece.kind in ("track", "pass"):
            raise
        return {"fault": np.array(str(error))}
    arrays: dict[str, NDArray[Any]] = {}
    for observer in observers:
        arrays |= observer.arrays()
    if piece.kind == "pass" and sinking is not None:
        arrays |= sinking.arrays()
    names = _SERIES.get(piece.kind)
    return arrays if names is None else {name: arrays[name] for name in names}


def _observe(
    piece: Piece,
    contact: RollingContact,
    positions: tuple[int, int, int],
    observers: list[Observer],
    sinking: Sinking | None,
) -> None:
    """March from a start, and show states and energies of steps to observers from a first position.

    The plastic work is a part of the loading.
    """
    energies = piece.kind not in ("load", "judge")
    left_end = piece.scene.recovery.rule == "left_end"
    old: ContactState | None = None
    start, first, last = positions
    half_space = _half_space(contact.spacing, contact.contact_modulus, contact.subcells)
    for state in march(contact, start, last, half_space):
        work = sinking(state) if sinking else 0.0
        if state.position < first:
            continue
        energy = None
        if old is not None:
            energy = step_energy(old, state, half_space, left_end) if energies else None
            if energy and work:
                energy = replace(energy, loading=energy.loading + work)
        for observer in observers:
            observer(state, energy)
        old = state


def _contact_of(piece: Piece) -> RollingContact:
    """Return the contact that a piece marches.

    Raise ContactError if the height file is gone or has other bytes than the identity says.
    """
    scene = piece.scene
    try:
        if piece.sunk is not None:
            contact = rolling_contact(scene, heights(scene) - piece.sunk)
        else:
            own = piece.identity, scene
            if not (_last and own == _last[0]):
                _last[:] = [own, rolling_contact(scene)]
            contact = _last[1]
        same = not scene.height_paths or contact_identity(scene) == piece.identity
    except SceneError as error:
        raise ContactError(
            f"the surface that was solved is gone or cannot be used: {error}"
        ) from error
    if not same:
        _last.clear()
        files = printable(" or ".join(map(str, scene.height_paths.values())))
        raise ContactError(f"{files} is not the surface that was solved")
    if piece.kind == "error":
        return level_contact(scene, piece.level, piece.first, piece.last - piece.first)
    if piece.kind == "moving":
        return replace(contact, loads=piece.forces)
    return contact if math.isnan(piece.load) else replace(contact, load=piece.load)


def level_contact(scene: Scene, level: str, first: int, steps: int) -> RollingContact:
    """Return the contact of a stretch on a level of accuracy, on the patch of surface around it.

    Position 0 of the contact is the first position of the stretch. All levels have the run's number
    of sub-cells per cell. The level of the detail holds that of the surface's law on flat cells.
    """
    side, detail = SIDES[level], level == error_cost.DETAIL
    tight = level in ("tight", "fine")
    whole, surface = rolling_contact(scene), heights(scene)
    # Twice the radius of overlap holds the highest peaks, and a few nodes hold the run-in.
    spacing = whole.cell_spacing
    reach = 2 * cost.overlap_radius(scene, cost.roughness(scene)[0])
    margin = math.ceil((reach + 8 * whole.step) / spacing)
    place = whole.position(first)
    row = math.floor(place / spacing) - margin
    rows = math.ceil(steps * whole.step / spacing) + 2 * margin
    if rows >= len(surface):
        row, rows = 0, len(surface)
    rows += rows % 2
    # Flat cells begin where the cells of the run begin, and places count from a centre.
    slopes = whole.slopes and not detail
    off_centre = 0.0 if slopes else (side - 1) / 2 * spacing
    if detail:
        finer = continued_rows(scene, row, rows)
        cells = cells_of_patch(finer, 0, len(finer), 1.0, whole.subcells, slopes)
    else:
        cells = cells_of_patch(surface, row, rows, side, whole.subcells, slopes)
    return replace(
        whole,
        heights=cells,
        slopes=slopes,
        spacing=whole.spacing * side,
        start=place - row * spacing - off_centre,
        tolerance=error_cost.tight_tolerance(scene) if tight else scene.tolerance,
    )
