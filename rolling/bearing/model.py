"""Model of a bearing whose ring moves: its geometry and speeds, masses, loads and damping."""

from dataclasses import dataclass
from math import pi

from acoustics.arrays import Array
from rolling.bearing.geometry import BearingGeometry
from rolling.bearing.kinematics import Kinematics, centrifugal_force
from rolling.bearing.static_load import StaticBalance, load_vector, static_balance


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

    @property
    def load(self) -> Array:
        """Load on the ring that moves [N], (3,)."""
        return load_vector(self.axial_load_n, self.radial_load_n, self.kinematics.moving)

    @property
    def centrifugal_n(self) -> float:
        """Part along the contact line [N] of the centrifugal force on a ball."""
        return centrifugal_force(self.geometry, self.ball_mass_kg, self.kinematics.cage_hz)

    def balance(self, cage_angle: float = 0.0) -> StaticBalance:
        """Return the static balance with ball 0 at an angle [rad], of balls without mass."""
        return static_balance(
            self.geometry,
            axial_load_n=self.axial_load_n,
            radial_load_n=self.radial_load_n,
            cage_angle=cage_angle,
            gap_m=self.gap_m,
            moving=self.kinematics.moving,
        )

    def balances(self, places: int = 8) -> list[StaticBalance]:
        """Return the balances at places of the cage from one ball to the next."""
        spacing = 2 * pi / self.geometry.balls
        return [self.balance(spacing * place / places) for place in range(places)]
