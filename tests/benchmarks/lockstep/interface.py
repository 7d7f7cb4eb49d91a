"""What a loop over pieces in lockstep asks of a batch of pieces."""

from __future__ import annotations

from typing import Protocol

MAX_DESCENTS = 20


class Batch(Protocol):
    """A batch of k pieces of a march that advance together, one method for all pieces.

    Pieces lie side by side in arrays (k, rows, columns), on windows of the same size with a corner
    for each piece. A method takes no node and no piece one by one, so that an array library on a
    GPU can stand behind it. It needs, over the last two axes of these arrays:

    - `move_on`: gathers at the corners, of pressures, deflections and heights, and the rows and
      columns at which a condition holds first and last (windows).
    - `begin`, `iterate`: sums, minima and maxima over a window with a mask (approach, violation,
      slope, step length, Newton's method for the common shift that restores the load); sums of 24
      shifted copies with bounds (a sweep of the model, see `grids.settle`); two small matrix
      products there and two back, and a conjugate gradient of matrix products between them (the far
      field, see `grids.restrict` and `grids.prolong`); multiply, add, clip and select.
    - `convolve`, `check`: k transforms in one plan there and back, with a product between them (see
      `grids.deflect`), in single precision and in double.

    A piece that has converged keeps its state under a mask. The host reads one number after each
    `iterate` and each `check`.
    """

    def move_on(self) -> None:
        """Move all pieces to their next position."""

    def begin(self) -> None:
        """Begin a descent of the pieces that are not accepted, and find its first directions."""

    def convolve(self) -> None:
        """Compute the deflection by the directions of all pieces that descend."""

    def iterate(self) -> int:
        """Step along the directions and find the next; return how many pieces still descend."""

    def check(self) -> int:
        """Judge in double precision; return how many pieces are not accepted."""


def follow(batch: Batch) -> None:
    """Solve the next position of all pieces."""
    batch.move_on()
    for _ in range(MAX_DESCENTS):
        batch.begin()
        descending = 1
        while descending:
            batch.convolve()
            descending = batch.iterate()
        if batch.check() == 0:
            return
    raise RuntimeError(f"pieces in lockstep are not solved after {MAX_DESCENTS} descents")
