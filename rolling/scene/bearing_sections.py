"""Bearing, its surfaces, the plate of its housing, sound and numerics: the sections of a bearing.

Units stand in the names of keys, and the properties of `BearingScene` are SI.
"""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import BeforeValidator, Field, field_validator, model_validator

from acoustics.numbers import bracketed
from rolling.bearing.contact_lines import Angle
from rolling.bearing.oil_film import USUAL_DENSITY_KG_M3, USUAL_PRESSURE_VISCOSITY_PER_GPA
from rolling.scene import bearing_rules, library, rules
from rolling.scene.messages import mistake, mistakes_together
from rolling.scene.models import Section
from rolling.scene.raceways import BallsSurface, RacewaySurface
from rolling.scene.sections import DENSITY, YOUNG, Material, Plate, Tolerance

Ring = Literal["inner", "outer"]
MAX_ENVELOPE_HZ = 20_000.0
MAX_RPM = 1e6  # the turbines of dentists reach half of it


def _as_text(name: Any) -> Any:
    """Return a name of digits, such as 6204, as text."""
    return str(name) if isinstance(name, int) and not isinstance(name, bool) else name


Named = Annotated[str, BeforeValidator(_as_text), library.begins_with(library.BEARINGS)]

LONGEST_S = 60.0  # record of the motion that a scene may ask for


class BearingSurfaces(Section):
    """Surfaces of balls and raceways.

    Attributes
    ----------
    balls : section, optional
        Surface around each ball. Balls differ by their random heights. Default: smooth.
    inner : section, optional
        Surface around the raceway of the inner ring. Default: smooth.
    outer : section, optional
        Surface around the raceway of the outer ring. Default: smooth.
    fault_ball : int
        Number of the ball that carries the single faults of `balls`, from 0

    Examples
    --------
    >>> import rolling
    >>> rolling.BearingSurfaces(balls={"kind": "graded", "grade": "G10"}).balls.grade
    'G10'
    """

    SECTION: ClassVar[str] = "bearing.surfaces"

    balls: BallsSurface | None = Field(default=None, discriminator="kind")
    inner: RacewaySurface | None = Field(default=None, discriminator="kind")
    outer: RacewaySurface | None = Field(default=None, discriminator="kind")
    fault_ball: int = Field(default=0, ge=0)


class BearingOil(Section):
    """Oil between balls and raceways, of which the contacts have as much as they draw in.

    Attributes
    ----------
    viscosity_40_mm2_s : float
        Kinematic viscosity at 40 degrees C [mm2/s], the number of a grade such as ISO VG 32
    viscosity_100_mm2_s : float, optional
        Kinematic viscosity at 100 degrees C [mm2/s]. Default: as usual mineral oils have it.
    temperature_c : float
        Temperature of the contacts [degrees C]
    density_kg_m3 : float
        Density [kg/m3]
    pressure_viscosity_per_gpa : float
        Growth of the logarithm of the viscosity with the pressure [1/GPa]
    roughness_rq_um : float, optional
        Rms roughness of ball and raceway together [um], to which the film is compared. Default:
        from the laws of both surfaces.

    Examples
    --------
    >>> import rolling
    >>> rolling.BearingOil(viscosity_40_mm2_s=32).temperature_c
    40.0
    """

    SECTION: ClassVar[str] = "bearing.oil"

    viscosity_40_mm2_s: float = Field(ge=2, le=1e4)
    viscosity_100_mm2_s: float | None = Field(default=None, ge=1, le=1e4)
    temperature_c: float = Field(default=40.0, ge=-20, le=150)
    density_kg_m3: float = Field(default=USUAL_DENSITY_KG_M3, ge=600, le=2000)
    pressure_viscosity_per_gpa: float = Field(default=USUAL_PRESSURE_VISCOSITY_PER_GPA, ge=1, le=60)
    roughness_rq_um: float | None = Field(default=None, ge=0, le=10)

    @model_validator(mode="after")
    def _thins_out(self) -> Self:
        """Refuse an oil that is not thinner at 100 degrees than at 40."""
        warm = self.viscosity_100_mm2_s
        if warm is not None and warm >= self.viscosity_40_mm2_s:
            raise mistake(
                f"got {warm:g}, allowed: below viscosity_40_mm2_s, {self.viscosity_40_mm2_s:g}",
                at=".viscosity_100_mm2_s",
            )
        return self


class Bearing(Section):
    """Ball bearing of one row.

    Attributes
    ----------
    named : str, optional
        Bearing by name, with suffixes such as -2RS or C3. It gives boundary dimensions, balls,
        pitch circle, conformities and clearance; values beside it win. A suffix of clearance, C2 to
        C5, sets the clearance by ISO 5753-1; other suffixes change nothing that is computed.
    bore_mm : float, optional
        Bore of the inner ring [mm]. Default: from pitch circle and balls, as in usual bearings.
    outside_diameter_mm : float, optional
        Outside diameter of the outer ring [mm]. Default: from pitch circle and balls.
    width_mm : float, optional
        Width of both rings [mm]. Default: from the balls.
    balls : int
        Number of balls
    ball_diameter_mm : float
        Diameter of the balls [mm]
    pitch_diameter_mm : float
        Diameter of the circle of the balls' centres [mm]
    contact_angle_deg : float, optional
        Contact angle without load [degrees], from a plane across the axis. Default: from the radial
        clearance. Under a purely radial load balls touch at an angle of 0.
    angle : str
        Whether the contact angle is `moving`, so that the loads and the motion of the ring turn the
        line of each contact, as exact geometry of the grooves has it, or stays `fixed`.
    ring : str
        Whether the ring that vibrates is `elastic`, so that it bends in its plane with two and with
        three waves around it, or `rigid`. Beside a plate, whose seat holds the ring, the default is
        rigid.
    tilt : str
        Whether the ring that vibrates is `held` in its plane, as its seat in a machine holds it, or
        `free` to tilt, as on a test stand. That needs a moving angle.
    sensor_deg : float, optional
        Angle [degrees] from the middle of the load zone at which the radial motion is seen on the
        cylinder of the ring. Default: the mean over all places by power, and signals at 0.
    radial_clearance_um : float, optional
        Radial internal clearance [um] as mounted. A negative one presses all balls. Default: from
        the contact angle.
    conformity_inner : float
        Radius of the inner groove over the ball's diameter [-]
    conformity_outer : float
        Radius of the outer groove over the ball's diameter [-]
    material : str
        Material of rings and balls by name. It gives Young's modulus, Poisson's ratio and density;
        values beside it win.
    youngs_modulus_gpa : float
        Young's modulus of rings and balls [GPa]
    poissons_ratio : float
        Poisson's ratio of rings and balls [-]
    density_kg_m3 : float
        Density of rings and balls [kg/m3]
    turning : str
        Ring that turns; the other one vibrates.
    speed_rpm : float
        Speed of the turning ring [1/min]
    axial_load_n : float
        Axial load [N]. It needs a contact angle above 0, or a moving angle.
    radial_load_n : float
        Radial load [N]
    ring_mass_kg : float, optional
        Mass of the ring that vibrates [kg], with what is fixed to it. Default: from its dimensions.
    contact_loss_factor : float
        Loss factor of the contact stiffness [-] at the resonances of the ring
    ball_inertia : bool
        Whether balls move with their mass, and with their centrifugal force. Otherwise they have
        none, which holds up to some 10 kHz.
    oil : BearingOil, optional
        Oil, whose film parts balls and raceways, presses waves flat and damps. Default: none, so
        the contacts are dry.
    surfaces : BearingSurfaces
        Surfaces of balls and raceways

    Examples
    --------
    >>> import rolling
    >>> rolling.Bearing(named="6204", speed_rpm=1800, axial_load_n=70).ball_diameter_mm
    7.938
    """

    NAMED: ClassVar[str] = "bearing"

    named: Named | None = None
    bore_mm: float | None = Field(default=None, gt=0)
    outside_diameter_mm: float | None = Field(default=None, gt=0)
    width_mm: float | None = Field(default=None, gt=0)
    balls: int = Field(ge=3, le=bearing_rules.MAX_BALLS)
    ball_diameter_mm: float = Field(ge=0.1, le=500)
    pitch_diameter_mm: float = Field(gt=0, le=1e4)
    contact_angle_deg: float | None = Field(default=None, ge=0, le=bearing_rules.MAX_ANGLE_DEG)
    angle: Angle = "moving"
    ring: Literal["rigid", "elastic"] = "elastic"
    tilt: Literal["held", "free"] = "held"
    sensor_deg: float | None = Field(default=None, ge=-360, le=360)
    radial_clearance_um: float | None = None
    conformity_inner: float = Field(default=0.52, gt=0.5, le=0.6)
    conformity_outer: float = Field(default=0.53, gt=0.5, le=0.6)
    material: Material = "steel-100cr6"
    youngs_modulus_gpa: float = Field(ge=YOUNG.least, le=YOUNG.most)
    poissons_ratio: float = Field(ge=0, le=0.5)
    density_kg_m3: float = Field(ge=DENSITY.least, le=DENSITY.most)
    turning: Ring = "inner"
    speed_rpm: float = Field(gt=0, le=MAX_RPM)
    axial_load_n: float = Field(default=0.0, ge=0)
    radial_load_n: float = Field(default=0.0, ge=0)
    ring_mass_kg: float | None = Field(default=None, gt=0)
    contact_loss_factor: float = Field(default=0.02, ge=0, le=1)
    ball_inertia: bool = False
    oil: BearingOil | None = None
    surfaces: BearingSurfaces = Field(default_factory=BearingSurfaces)

    @model_validator(mode="after")
    def _can_be_assembled(self) -> Self:
        """Refuse all that does not fit together in one message."""
        mistakes = list(bearing_rules.mistakes_of_bearing(self))
        if mistakes:
            raise mistakes_together(mistakes)
        return self


class HousingPlate(Plate):
    """Plate of the housing, which the ring shakes and which is heard.

    Attributes
    ----------
    hardness_gpa : float or "none", optional
        Hardness [GPa] that a material brings. It has no effect, because nothing rolls on the plate.
    yield_strength_gpa : optional
        Only goes with a sphere that rolls on the plate.
    plasticity : optional
        Only goes with a sphere that rolls on the plate.
    contact_path : optional
        Only goes with a sphere that rolls on the plate.
    contact_end_mm : optional
        Only goes with a sphere that rolls on the plate.
    contact_loss_factor : optional
        Only goes with a sphere that rolls on the plate.
    density_kg_m3 : float
        Density [kg/m3]
    thickness_mm : float
        Thickness [mm]
    length_mm : float
        Length [mm] along x
    width_mm : float
        Width [mm] along y
    contact_mm : pair of float, optional
        Point (x, y) [mm] from a corner at which the radial force of the ring acts. Default: 0.43 of
        the length, 0.37 of the width.

    Examples
    --------
    >>> import rolling
    >>> size = {"length_mm": 300, "width_mm": 200, "thickness_mm": 5}
    >>> rolling.HousingPlate(material="steel-s235", **size).edges_mm
    (300.0, 200.0)
    """

    SECTION: ClassVar[str] = "plate"

    @model_validator(mode="after")
    def _has_edges(self) -> Self:
        """Refuse a plate without edges or of too many modes, and keys that go with a sphere."""
        for key in ("length_mm", "width_mm", "density_kg_m3"):
            if getattr(self, key) is None:
                raise mistake("missing; the plate of a housing has edges and a mass", at=f".{key}")
        for key in (
            "plasticity",
            "yield_strength_gpa",
            "contact_path",
            "contact_end_mm",
            "contact_loss_factor",
        ):
            if getattr(self, key) is None:
                continue
            words = "only goes with a sphere that rolls on the plate"
            if key == "contact_loss_factor":
                words += "; that of the balls is bearing.contact_loss_factor"
            raise mistake(words, at=f".{key}")
        rules.refuse_modes(self, at="")
        return self


class BearingSound(Section):
    """Record of the vibration, and listener of the plate.

    Attributes
    ----------
    duration_s : float
        Time that is computed at least [s]; listen_s if that is longer
    listen_s : float, optional
        Length [s] of the record to listen to, all of which is computed. Default: 5 s, or the
        duration if it is longer.
    distance_m : float
        Distance of the listener from the plate of the housing [m]
    envelope_hz : [float, float], optional
        Edges of the band [Hz] in whose envelope pulses are looked for. Default: the band that the
        kurtogram chooses.

    Examples
    --------
    >>> import rolling
    >>> rolling.BearingSound(duration_s=2).distance_m
    1.0
    """

    SECTION: ClassVar[str] = "sound"

    duration_s: float = Field(default=1.0, gt=0, le=LONGEST_S)
    listen_s: float | None = Field(default=None, ge=0.1, le=120)
    distance_m: float = Field(default=1.0, gt=0)
    envelope_hz: Annotated[list[float], Field(min_length=2, max_length=2)] | None = None

    @field_validator("envelope_hz")
    @classmethod
    def _rising_edges(cls, value: list[float] | None) -> list[float] | None:
        """Refuse edges that do not rise."""
        if value is not None and not 0 < value[0] < value[1] <= MAX_ENVELOPE_HZ:
            raise mistake(
                f"got {bracketed(value)}, allowed: two edges that rise between 0 and"
                f" {MAX_ENVELOPE_HZ:,.0f} Hz"
            )
        return value


class BearingNumerics(Section):
    """Resolution and accuracy of the rough contacts.

    Attributes
    ----------
    spacing_um : float, optional
        Node spacing [um] of balls and raceways. Default: some nodes in the shortest correlation
        length, and in the narrow side of the lightest contact.
    window_mm : float
        Length of track [mm] that is marched for each kind of contact, beyond which the roughness
        continues with the same statistics
    tolerance : float or "auto"
        Allowed violation of the contact conditions, over the maximum deflection [-]

    Examples
    --------
    >>> import rolling
    >>> rolling.BearingNumerics(spacing_um=1).window_mm
    16.0
    """

    SECTION: ClassVar[str] = "numerics"

    spacing_um: float | None = Field(default=None, gt=0)
    window_mm: float = Field(default=16.0, gt=0)
    tolerance: Tolerance = "auto"
