"""March of a lap under the moving load, as it is kept."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from rolling._typing import Array
from rolling.scene.identity import canonical
from rolling.scene.scene import Scene

KEYS = (
    "rolling.speed_m_s",
    "sphere.density_kg_m3",
    "plate.density_kg_m3",
    "plate.thickness_mm",
)  # of the vibration that moves the load
MOVING_SERIES = ("release_energy", "loading_energy", "energy_defect")


@dataclass(frozen=True)
class MovingPiece:
    """The march of a piece of the track under the moving load.

    key : str. The vibration that moves the load.
    first, last : int. Positions between which the piece lies.
    steps : dict. Series of its steps, J.
    approach : array, m. Approach at the positions first + 1 to last, and at 0 in the first piece.
    fault : str. Reason of a failure; empty if there is none.
    """

    key: str
    first: int
    last: int
    steps: dict[str, Array]
    approach: Array
    fault: str = ""


@dataclass
class MovingRelease:
    """The march of a lap under the moving load; its series are NaN where it is not solved yet.

    force : (steps + 1,) array, N. Contact force at each position.
    motion_approach : (steps + 1,) array, m. Approach of the motion at each position.
    approach : (steps + 1,) array, m. Approach of the march.
    steps : dict. Series of the steps, (steps,) J.
    fault : str. Reason why there is no such march; empty if there is one.
    """

    force: Array
    motion_approach: Array
    approach: Array = field(default_factory=lambda: np.empty(0))
    steps: dict[str, Array] = field(default_factory=dict)
    fault: str = ""

    def __post_init__(self) -> None:
        if not self.steps:
            self.approach = np.full(len(self.force), np.nan)
            self.steps = {name: np.full(len(self.force) - 1, np.nan) for name in MOVING_SERIES}

    @classmethod
    def impossible(cls, steps: int, fault: str) -> MovingRelease:
        """Return what stands for the march of a track that cannot have one."""
        unknown = np.full(steps + 1, np.nan)
        return cls(unknown, unknown, fault=fault)

    @property
    def complete(self) -> bool:
        """Whether all steps are solved, or none can be."""
        return bool(self.fault) or not np.isnan(self.steps["release_energy"]).any()

    @property
    def repeats(self) -> bool:
        """Whether the load ends as it began, so that a lap of the release repeats."""
        return bool(self.force[0] == self.force[-1])

    @property
    def law_error(self) -> float:
        """Maximum difference between the approaches of march and motion [m]."""
        return float(np.abs(self.approach - self.motion_approach).max())

    def add(self, piece: MovingPiece) -> None:
        """Add a piece; a piece that failed is a fault of the whole march."""
        if piece.fault:
            self.fault = self.fault or piece.fault
            return
        for name, values in piece.steps.items():
            self.steps[name][piece.first : piece.last] = values
        end = piece.last + 1
        self.approach[end - len(piece.approach) : end] = piece.approach


def moving_key(scene: Scene) -> str:
    """Return a text that is equal for scenes whose vibration moves the load equally."""
    data = scene.to_dict()
    values = {key: data[section].get(last) for key in KEYS for section, last in [key.split(".")]}
    return canonical(values)
