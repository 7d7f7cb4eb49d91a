"""Memory of heights between the nodes of a surface: sub-cells and the tops of cells.

The constants are bytes, measured as the peak of the resident memory.
"""

from __future__ import annotations

from dataclasses import dataclass

from rolling.check import cost
from rolling.scene.scene import Scene
from rolling.scene.surfaces import Gaussian

# Bytes per node of the surface while the end of its spectrum is examined.
EXAMINED = 32.0
# Bytes per node of the window: the contact, and transforms of all padded sizes that occur (310 to
# 660 bytes), and per sub-cell beyond the first.
WINDOW, WINDOW_SUBCELL = 720.0, 700.0


@dataclass(frozen=True)
class BetweenNodes:
    """Heights between the nodes, with blended edges or on sub-cells.

    Attributes
    ----------
    subcells : int
        Sub-cells along the side of a cell.
    blended : bool
        True if edges are blended.
    slopes : bool
        True if the surface continues between its nodes; otherwise cells are flat.
    is_zero : bool
        True for a smooth plate, whose zeros take no memory.
    """

    subcells: int
    blended: bool
    slopes: bool
    is_zero: bool

    @property
    def kept(self) -> float:
        """Bytes per node beside its height: sub-cells, and the tops of cells."""
        copies = 0 if self.is_zero else (self.subcells > 1) + (self.blended and self.slopes)
        return 8.0 * self.subcells**2 * copies

    @property
    def made(self) -> float:
        """Bytes per node beside its height while they are made."""
        r = self.subcells
        if self.is_zero or (r == 1 and not self.blended):
            return 0.0
        lines = 24.0 if self.slopes else 8.0  # per line of sub-cells, before their columns
        return max(EXAMINED, self.kept, lines * r + 8.0 * r**2 if r > 1 else 0.0)

    @property
    def window(self) -> float:
        """Bytes per node of the window."""
        return WINDOW + WINDOW_SUBCELL * (self.subcells**2 - 1)


def between_nodes(scene: Scene, rq: float) -> BetweenNodes:
    """Estimate the heights between the nodes of a scene with an rms roughness of rq [m].

    An exponential law has flat cells; any other surface may continue between its nodes.
    """
    surface = scene.surface
    flat = isinstance(surface, Gaussian) and surface.autocorrelation.startswith("exponential")
    subcells = cost.subcells(scene, is_read=rq > 0)
    return BetweenNodes(subcells, cost.has_blended_edges(scene), not flat, surface.kind == "smooth")
