"""Receivers of a ball on a plate: a listener of its sound, and transducers on ball and plate."""

from dataclasses import dataclass
from typing import Literal

from acoustics import rectangular_plate

Place = rectangular_plate.Listener  # (x, y, z) [m] from a corner of a plate with edges


@dataclass(frozen=True, kw_only=True)
class Listener:
    """Listener of the sound of ball and plate, and of the released power.

    Attributes
    ----------
    distance_m : float, m
        Distance from the contact, on the axis through it.
    places_m : tuple of (x, y, z), m
        Places above or below a plate with edges, from its corner. The levels belong to the first.
    hears_ball : bool
        If true, the ball is heard beside the plate.
    q : float
        Share of the released power that counts as radiated.
    gain_pa_per_w_m2 : float or None, Pa per W/m2
        Factor from the fluctuation of the released intensity to the sound pressure. None: the
        fluctuation of a record sets its own factor.
    """

    distance_m: float
    places_m: tuple[Place, ...]
    hears_ball: bool = True
    q: float = 1.0
    gain_pa_per_w_m2: float | None = None

    @property
    def has_own_factor(self) -> bool:
        """Whether the fluctuation of a record of the released power sets its own factor."""
        return self.gain_pa_per_w_m2 is None


@dataclass(frozen=True, kw_only=True)
class Transducer:
    """Accelerometer or force transducer: what it measures, and where.

    Attributes
    ----------
    of : str
        What moves or presses: plate, ball or contact.
    quantity : str
        acceleration, velocity or displacement of plate or ball, force or blocked_force of the
        contact.
    place_m : pair of float, m, or None
        Place on the plate: from the corner of a plate with edges, from the contact along the track
        on an infinite one. None for ball and contact.
    """

    of: Literal["plate", "ball", "contact"]
    quantity: Literal["acceleration", "velocity", "displacement", "force", "blocked_force"]
    place_m: tuple[float, float] | None = None
