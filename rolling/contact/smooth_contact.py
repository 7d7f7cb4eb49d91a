"""Contact of a smooth elastic ball with a plane, elliptic where the radii of the ball differ."""

from dataclasses import dataclass

from rolling.contact import closed_forms


@dataclass(frozen=True, kw_only=True)
class SmoothContact:
    """Smooth elastic contact of a ball with a plane, after Hertz.

    Attributes
    ----------
    load_n : float, N
        Normal load.
    radius_m, radius_across_m : float, m
        Radii of the ball along the track and across it.
    modulus_pa : float, Pa
        Contact modulus E*, with 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2.
    """

    load_n: float
    radius_m: float
    radius_across_m: float
    modulus_pa: float

    @property
    def equivalent_radius_m(self) -> float:
        """Radius [m] of the sphere with the stiffness of the contact at any load."""
        return closed_forms.hertz_ellipse(self.radius_m, self.radius_across_m)[0]

    def semi_axes_m(self, load_n: float | None = None) -> tuple[float, float]:
        """Return the semi-axes [m] along and across the track, by default at the contact's load."""
        load = self.load_n if load_n is None else load_n
        radius, along, across = closed_forms.hertz_ellipse(self.radius_m, self.radius_across_m)
        contact_radius = closed_forms.hertz_radius(load, radius, self.modulus_pa)
        return contact_radius * along, contact_radius * across

    def maximum_pressure_pa(self, load_n: float | None = None) -> float:
        """Return the maximum pressure [Pa], by default at the contact's load."""
        load = self.load_n if load_n is None else load_n
        radius, along, across = closed_forms.hertz_ellipse(self.radius_m, self.radius_across_m)
        return closed_forms.hertz_pressure(load, radius, self.modulus_pa) / (along * across)

    @property
    def stiffness_n_m(self) -> float:
        """Stiffness [N/m] at the load, 2 E* a of the equivalent sphere."""
        radius = self.equivalent_radius_m
        contact_radius = closed_forms.hertz_radius(self.load_n, radius, self.modulus_pa)
        return 2 * self.modulus_pa * contact_radius

    def approach_m(self, load_n: float | None = None) -> float:
        """Return the approach [m], by default at the contact's load."""
        load = self.load_n if load_n is None else load_n
        return closed_forms.hertz_approach(load, self.equivalent_radius_m, self.modulus_pa)
