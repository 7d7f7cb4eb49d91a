"""Marches of a track at other loads than the scene's, as they are kept for its force law."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from rolling._typing import Array


@dataclass(frozen=True)
class LoadPiece:
    """The march of a piece of the track at one load.

    load : float, N. The load.
    first, last : int. Positions between which the piece lies.
    approach : array, m. Approach at the positions first + 1 to last, and at 0 in the first piece.
    seconds : float, s. Time of the march.
    judging : bool. Whether the march judges the force law instead of making it.
    fault : str. Reason of a failure; empty if there is none.
    """

    load: float
    first: int
    last: int
    approach: Array
    seconds: float
    judging: bool = False
    fault: str = ""


@dataclass
class LoadMarches:
    """All marches of a track at other loads.

    steps : int. Number of different steps of the track.
    approach : dict. Approach by load, (steps + 1,) m; NaN where it is not solved yet.
    judging : dict. Approach by load on the stretch that judges the force law, (n + 1,) m.
    seconds : float, s. Time of all marches.
    complete : bool. Whether no more marches are needed.
    fault : str. Reason why the track could not be marched at a further load; empty if it could.
    failed : set of float, N. Loads whose other pieces are dropped.
    extremes : dict. Minimum and maximum of the contact force [N] by vibration and loads of the law,
        which take a motion each; they are not stored.
    """

    steps: int
    approach: dict[float, Array] = field(default_factory=dict)
    judging: dict[float, Array] = field(default_factory=dict)
    seconds: float = 0.0
    complete: bool = False
    fault: str = ""
    failed: set[float] = field(default_factory=set)
    extremes: dict[tuple[str, tuple[float, ...]], tuple[float, float]] = field(default_factory=dict)

    def add(self, piece: LoadPiece) -> None:
        """Add a piece; a piece that failed removes its load."""
        self.seconds += piece.seconds
        if piece.fault:
            self.fault = self.fault or piece.fault
            self.failed.add(piece.load)
            self.approach.pop(piece.load, None)
        elif piece.load in self.failed:
            return
        elif piece.judging:
            self.judging[piece.load] = piece.approach
        else:
            whole = self.approach.setdefault(piece.load, np.full(self.steps + 1, np.nan))
            whole[piece.last + 1 - len(piece.approach) : piece.last + 1] = piece.approach
