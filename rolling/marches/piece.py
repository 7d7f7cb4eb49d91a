"""Pieces of work: each marches some positions from a cold start and depends on its fields alone.

The numbers are therefore equal for any number of workers, and for a run that was interrupted.
"""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from acoustics.arrays import Array
from rolling.scene.identity import contact_keys, digest
from rolling.scene.scene import Scene

PIECE_STEPS = 200  # a cold start costs 4 % of them

Kind = Literal["track", "pass", "load", "judge", "moving", "error", "film"]


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
    load : float, N. Load of the kinds "load" and "judge".
    forces : (positions,) array, N. Load at each position of a lap of the kind "moving".
    level : str. Level of the kind "error": "tight", "fine", "coarse", "detail", "with_law" or
        "measured".
    stride : int. Positions from one map to the next of the kind "film".
    number : int. Index of the pass of the kind "pass".
    sunk : (along, across) array, m. Depth of the plate before the piece. Default: a virgin plate.
    step_cost : float. Expected time of a step over that of a step of the run. Default: 1.
    """

    scene: Scene
    identity: str
    kind: Kind
    first: int
    last: int
    load: float = math.nan
    forces: Array | None = None
    level: str = ""
    stride: int = 0
    number: int = 0
    sunk: Array | None = None
    step_cost: float = 1.0

    @property
    def has_maps(self) -> bool:
        """Whether it keeps maps, and events on request: on the track, and in the last pass."""
        is_last_pass = self.kind == "pass" and self.number + 1 == self.scene.passes
        return self.kind == "track" or is_last_pass

    @cached_property
    def key(self) -> str:
        """File-safe text that is unique among the pieces of an identity."""
        parts = [self.kind, str(self.first), str(self.last)]
        if self.kind in ("load", "judge"):
            parts.append(_short_digest(self.load.hex().encode()))
        elif self.forces is not None:
            parts.append(_short_digest(self.forces.tobytes()))
        elif self.kind == "error":
            parts.append(self.level)
        elif self.kind == "film":
            parts.append(str(self.stride))
        elif self.kind == "pass":
            parts.append(str(self.number + 1))
        return "-".join(parts)


def _short_digest(content: bytes) -> str:
    """Return 16 hex digits of the SHA-256 of some bytes."""
    return hashlib.sha256(content).hexdigest()[:16]


def track_pieces(steps: int) -> list[tuple[int, int]]:
    """Return the first and last position of each piece of a track with `steps` steps."""
    return [(first, min(first + PIECE_STEPS, steps)) for first in range(0, steps, PIECE_STEPS)]
