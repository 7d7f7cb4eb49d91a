"""Model of a bearing whose ring moves: its geometry and speeds, masses, loads and damping."""

from dataclasses import dataclass

from acoustics.arrays import Array
from rolling.bearing.contact_lines import Angle, ContactLines, contact_lines
from rolling.bearing.geometry import BearingGeometry
from rolling.bearing.kinematics import Kinematics, centrifugal_force
from rolling.bearing.static_load import (
    StaticBalance,
    balances_around,
    load_vector,
    rolling_angle,
    static_balance,
)


@dataclass(frozen=True)
class BearingModel:
    """Bearing of which the ring that does not turn moves as a rigid body, in SI."""

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

    @property
    def load(self) -> Array:
        """Load on the ring that moves [N], (3,)."""
        return load_vector(self.axial_load_n, self.radial_load_n, self.kinematics.moving)

    @property
    def centrifugal_n(self) -> float:
        """Part along the contact line [N] of the centrifugal force on a ball."""
        return centrifugal_force(self.geometry, self.ball_mass_kg, self.kinematics.cage_hz)

    @property
    def rolling_angle(self) -> float:
        """Contact angle [rad] at which the balls roll under the loads."""
        return rolling_angle(self.balances())

    def balance(self, cage_angle: float = 0.0) -> StaticBalance:
        """Return the static balance with ball 0 at an angle [rad], of balls without mass."""
        return static_balance(
            self.geometry,
            axial_load_n=self.axial_load_n,
            radial_load_n=self.radial_load_n,
            cage_angle=cage_angle,
            gap_m=self.gap_m,
            moving=self.kinematics.moving,
            angle=self.angle,
        )

    def lines(self, places: Array) -> ContactLines:
        """Return the contact lines of balls at some angles [rad] from the middle of the zone."""
        return contact_lines(
            self.geometry,
            places,
            gap_m=self.gap_m,
            moving=self.kinematics.moving,
            angle=self.angle,
        )

    def balances(self) -> tuple[StaticBalance, ...]:
        """Return the balances at places of the cage from one ball to the next."""
        return balances_around(
            self.geometry,
            axial_load_n=self.axial_load_n,
            radial_load_n=self.radial_load_n,
            gap_m=self.gap_m,
            moving=self.kinematics.moving,
            angle=self.angle,
        )
