"""Parts of a step in lockstep, for many pieces: transforms and sweeps."""

# mypy: disable-error-code="no-untyped-def,no-untyped-call"
from __future__ import annotations

import numba
import numpy as np

from lockstep.batch_transforms import transform
from rolling.contact import _system as parts
from rolling.contact._descent_kernels import SWEEPS
from rolling.contact._far_field import stencils
from rolling.contact._linked import reference
from rolling.contact._model_kernels import settle_model
from rolling.contact._system import BORDER
from rolling.contact._transform_kernels import deflect_nodes


@numba.njit(nogil=True)
def settle_all(grids, values, node, strips, stiffness, sweeps):
    """Settle the models of grids (k, 6, rows, columns): the fields of Model from its change on."""
    for i in range(grids.shape[0]):
        g = grids[i]
        nothing = g[0, :0]
        model = parts.Model(
            values, g[0], g[1], g[2], g[3], g[4], g[5], nothing, node, strips, stiffness, 0.0
        )
        settle_model(reference(model), sweeps)


@numba.njit(nogil=True)
def transform_each(transforms, block, pieces):
    """Transform a block of nodes for each piece by the transforms of the present solver.

    `transforms` are the address of their kernel and their entry. No node is listed, so that nothing
    but the transforms takes time.
    """
    kernel, entry = transforms
    d = np.empty(0)
    nodes = np.empty(0, np.uint32), np.empty(0, np.int64)
    for _ in range(pieces):
        deflect_nodes(kernel, entry, (0, 0, block[0], block[1]), d, 1.0, d, nodes)


@numba.njit(nogil=True)
def transform_pairs(lines, spectrum, executable, pieces):
    """Transform the lines of a pair of pieces for each pair."""
    for _ in range(pieces // lines.shape[1] // 2):
        lines[:] = 0.0
        transform(lines, spectrum, executable)


class Sweeps:
    """Models of so many pieces on random states of a block.

    Parameters
    ----------
    unit : float, m/Pa
        Deflection per pressure and coefficient.
    block : (int, int)
        Rows and columns without the border.
    pieces : int
        Number of grids.
    """

    def __init__(self, unit: float, block: tuple[int, int], pieces: int) -> None:
        settle_model.link()
        rows, columns = (length + 2 * BORDER for length in block)
        made = stencils(unit)
        self.grids = np.zeros((pieces, 6, rows, columns), np.float32)
        noise = np.random.default_rng(1).standard_normal((pieces, *block))
        self.grids[:, 1, BORDER:-BORDER, BORDER:-BORDER] = noise
        self.grids[:, 2] = -1.0
        self.grids[:, 3] = 1.0
        self._numbers = (
            made.model,
            np.empty(0, np.uint32),
            np.array([[2 * columns, (rows - 2) * columns]], np.uint64),
            made.stiffness,
            SWEEPS,
        )

    def all_at_once(self) -> None:
        """Settle all models in one call."""
        settle_all(self.grids, *self._numbers)

    def one_by_one(self) -> None:
        """Settle each model in a call of its own."""
        for i in range(len(self.grids)):
            settle_all(self.grids[i : i + 1], *self._numbers)
