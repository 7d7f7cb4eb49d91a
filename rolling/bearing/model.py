"""Model of a bearing whose ring moves: its geometry and speeds, masses, loads and damping."""

from dataclasses import dataclass

import numpy as np

from acoustics.arrays import Array
from rolling.bearing.contact_lines import Angle, ContactLines, contact_lines, free_columns
from rolling.bearing.geometry import BearingGeometry
from rolling.bearing.kinematics import Kinematics, centrifugal_force
from rolling.bearing.ring_bending import BendingMode
from rolling.bearing.static_load import (
    FREE_TO_TILT,
    LoadedRing,
    StaticBalance,
    balances_around,
    rolling_angle,
    static_balance,
)


@dataclass(frozen=True)
class BearingModel:
    """Bearing of which the ring that does not turn moves, in SI.

    Its displacements are x and y radial and z axial, the cosine and the sine part of each bending
    mode, and its turns about x and y where it is free to tilt.
    """

    geometry: BearingGeometry
    kinematics: Kinematics
    ring_mass_kg: float  # of the ring that moves
    ball_mass_kg: float
    axial_load_n: float
    radial_load_n: float
    gap_m: float = 0.0  # of each ball along its contact line, with the ring centred
    contact_loss_factor: float = 0.02  # of the contact stiffness, at each resonance of the ring
    ball_inertia: bool = False  # whether balls have mass
    angle: Angle = "fixed"  # whether loads turn the contact angle
    bending: tuple[BendingMode, ...] = ()  # modes of a ring that bends
    tilt_inertia_kg_m2: float | None = None  # of a ring that is free to tilt, about a diameter
    film_time_s: float = 0.0  # viscosity of films of oil over the contact stiffness

    @property
    def tilts(self) -> bool:
        """Whether the ring is free to tilt."""
        return self.tilt_inertia_kg_m2 is not None

    @property
    def orders(self) -> tuple[int, ...]:
        """Waves around the ring of its bending modes."""
        return tuple(mode.order for mode in self.bending)

    @property
    def columns(self) -> list[int]:
        """Displacements of the ring that are free, of those that contact lines have, (m,)."""
        return free_columns(self.tilts, len(self.bending))

    @property
    def masses(self) -> Array:
        """Mass of each displacement [kg], of turns [kg m2], (m,)."""
        masses = [self.ring_mass_kg] * 3
        masses += [mode.mass_kg for mode in self.bending for _ in range(2)]
        if self.tilt_inertia_kg_m2 is not None:
            masses += [self.tilt_inertia_kg_m2] * 2
        return np.array(masses)

    @property
    def springs(self) -> Array:
        """Stiffness [N/m] of the ring itself against each displacement, (m,)."""
        springs = np.zeros(len(self.columns))
        for number, mode in enumerate(self.bending):
            springs[3 + 2 * number : 5 + 2 * number] = mode.stiffness_n_m
        return springs

    @property
    def radial(self) -> list[int]:
        """Displacements that move a place of the ring along its radius: x, y and bending."""
        return [0, 1, *range(3, 3 + 2 * len(self.bending))]

    @property
    def load(self) -> Array:
        """Load on each displacement of the ring [N], (m,)."""
        rigid = self.loaded_ring.load
        return np.append(rigid, np.zeros(len(self.columns) - len(rigid)))

    @property
    def centrifugal_n(self) -> float:
        """Part along the contact line [N] of the centrifugal force on a ball."""
        return centrifugal_force(self.geometry, self.ball_mass_kg, self.kinematics.cage_hz)

    @property
    def rolling_angle(self) -> float:
        """Contact angle [rad] at which the balls roll under the loads."""
        return rolling_angle(self.balances())

    @property
    def loaded_ring(self) -> LoadedRing:
        """The ring with its loads and what holds it."""
        return LoadedRing(
            axial_load_n=self.axial_load_n,
            radial_load_n=self.radial_load_n,
            gap_m=self.gap_m,
            moving=self.kinematics.moving,
            angle=self.angle,
            moments_n_m=FREE_TO_TILT if self.tilts else None,
            bending=self.bending,
        )

    def balance(self, cage_angle: float = 0.0) -> StaticBalance:
        """Return the static balance with ball 0 at an angle [rad], of balls without mass."""
        return static_balance(self.geometry, self.loaded_ring, cage_angle)

    def lines(self, places: Array) -> ContactLines:
        """Return the contact lines of balls at some angles [rad] from the middle of the zone."""
        return contact_lines(
            self.geometry,
            places,
            gap_m=self.gap_m,
            moving=self.kinematics.moving,
            angle=self.angle,
            orders=self.orders,
        )

    def balances(self) -> tuple[StaticBalance, ...]:
        """Return the balances at places of the cage from one ball to the next."""
        return balances_around(self.geometry, self.loaded_ring)
