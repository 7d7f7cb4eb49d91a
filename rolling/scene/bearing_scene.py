"""Scene of a bearing: its sections, its sweep, and its quantities in SI."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import (
    BeforeValidator,
    Field,
    ValidationInfo,
    WithJsonSchema,
    field_validator,
    model_validator,
)

from rolling.bearing.geometry import BearingGeometry
from rolling.bearing.kinematics import Kinematics
from rolling.bearing.linear_ring import gyration_squared
from rolling.bearing.model import BearingModel
from rolling.bearing.oil_film import (
    TIME_S,
    USUAL_SLOPE,
    ContactFilm,
    Oil,
    contact_film,
    kinematic_viscosity_mm2_s,
    viscosity_slope,
)
from rolling.bearing.ring_bending import GroovedSection, RingBending
from rolling.bearing.static_load import LoadedRing, balances_around
from rolling.scene import bearing_rules
from rolling.scene import sweep as sweeps
from rolling.scene.bearing_lengths import RingSection, ring_section
from rolling.scene.bearing_sections import (
    Bearing,
    BearingNumerics,
    BearingSound,
    HousingPlate,
    Ring,
)
from rolling.scene.messages import mistakes_together
from rolling.scene.raceways import Raceway
from rolling.scene.surfaces import BallHeightFile
from rolling.scene.swept import DEFAULT_NAME, PATTERN, SceneName, SweptScene

RING_IN_SEAT = "rigid"  # the ring beside a plate
LISTENED_S = 5.0  # length of a record to listen to, where the scene does not say


class BearingQuantities(SweptScene):
    """Sections of the scene of a bearing, and its quantities in SI."""

    SECTION: ClassVar[str] = "bearing"
    TITLE: ClassVar[str] = "Scene of a bearing that turns"
    FORMER_VALUES: ClassVar[Mapping[str, Any]] = MappingProxyType(
        {"bearing.angle": "fixed", "bearing.ring": "rigid"}
    )

    name: SceneName = Field(default=DEFAULT_NAME, pattern=PATTERN)
    title: str | None = None
    description: str | None = None
    listen_for: str | None = None
    bearing: Bearing
    plate: HousingPlate | None = None
    numerics: BearingNumerics = Field(default_factory=BearingNumerics, validate_default=True)
    sound: BearingSound = Field(default_factory=BearingSound)

    @model_validator(mode="before")
    @classmethod
    def _hold_in_seat(cls, values: Any) -> Any:
        """Take a rigid ring beside a plate, whose seat holds it, where the scene names none."""
        if not isinstance(values, Mapping) or values.get("plate") is None:
            return values
        bearing = values.get("bearing")
        if not isinstance(bearing, Mapping) or bearing.get("ring") is not None:
            return values
        return {**values, "bearing": {**bearing, "ring": RING_IN_SEAT}}

    @property
    def height_paths(self) -> dict[str, Path]:
        """Files of heights and of roundness by the section that reads them."""
        paths = {}
        for name in ("balls", "inner", "outer"):
            surface = getattr(self.bearing.surfaces, name)
            if isinstance(surface, BallHeightFile):
                paths[f"bearing.surfaces.{name}"] = self._folder / surface.path
            if isinstance(surface, Raceway) and surface.roundness is not None:
                key = f"bearing.surfaces.{name}.roundness"
                paths[key] = self._folder / surface.roundness.path
        return paths

    @property
    def is_smooth(self) -> bool:
        """Whether balls and raceways are perfectly smooth."""
        surfaces = self.bearing.surfaces
        for surface in (surfaces.balls, surfaces.inner, surfaces.outer):
            if surface is not None and (surface.kind != "smooth" or surface.has_form):
                return False
        return not self.has_faults

    @property
    def has_faults(self) -> bool:
        """Whether balls or raceways have single faults."""
        surfaces = self.bearing.surfaces
        for surface in (surfaces.balls, surfaces.inner, surfaces.outer):
            if surface is not None and surface.faults:
                return True
        return False

    # ---- geometry

    @property
    def ball_radius(self) -> float:
        """Radius of the balls [m]."""
        return 5e-4 * self.bearing.ball_diameter_mm

    @property
    def pitch_radius(self) -> float:
        """Radius of the circle of the balls' centres [m]."""
        return 5e-4 * self.bearing.pitch_diameter_mm

    @cached_property
    def geometry(self) -> BearingGeometry:
        """Geometry at the contact angle at which the balls touch."""
        return bearing_rules.geometry_of(self.bearing)

    @property
    def contact_angle(self) -> float:
        """Contact angle [rad] at which the balls touch; 0 under a purely radial load."""
        return self.geometry.contact_angle

    @property
    def radial_clearance(self) -> float:
        """Radial internal clearance [m] of the bearing without load."""
        return bearing_rules.free_clearance(self.bearing)

    @property
    def gap(self) -> float:
        """Gap [m] of each ball with the ring centred; an axial load closes it."""
        return bearing_rules.gap_of(self.bearing)

    @property
    def groove_radii(self) -> dict[Ring, float]:
        """Radius of the groove [m] of each ring, across the track."""
        diameter = 2 * self.ball_radius
        return {
            "inner": self.bearing.conformity_inner * diameter,
            "outer": self.bearing.conformity_outer * diameter,
        }

    @property
    def circumferences(self) -> dict[str, float]:
        """Length of a turn [m] of balls, inner and outer raceway at their contacts."""
        radii = {
            "balls": self.ball_radius,
            "inner": self.geometry.inner.radius_m,
            "outer": self.geometry.outer.radius_m,
        }
        return {name: 2 * math.pi * radius for name, radius in radii.items()}

    @property
    def bore(self) -> float:
        """Bore of the inner ring [m]."""
        return self._boundary("bore_mm", bearing_rules.usual_bore_mm)

    @property
    def outside_diameter(self) -> float:
        """Outside diameter of the outer ring [m]."""
        return self._boundary("outside_diameter_mm", bearing_rules.usual_outside_mm)

    @property
    def width(self) -> float:
        """Width of both rings [m]."""
        return self._boundary("width_mm", bearing_rules.usual_width_mm)

    def _boundary(self, key: str, usual: Callable[[Bearing], float]) -> float:
        """Return a boundary dimension [m], by default that of a usual bearing with such balls."""
        given = getattr(self.bearing, key)
        return 1e-3 * (usual(self.bearing) if given is None else given)

    @property
    def ring_section(self) -> RingSection:
        """Cross-section of the ring that vibrates."""
        diameter = self.outside_diameter if self.moving_ring == "outer" else self.bore
        return ring_section(
            surface_radius=diameter / 2,
            pitch_radius=self.pitch_radius,
            ball_radius=self.ball_radius,
            groove_radius=self.groove_radii[self.moving_ring],
            width=self.width,
        )

    # ---- material, masses, loads and speed

    @property
    def contact_modulus(self) -> float:
        """Contact modulus E* [Pa] of ball and raceway."""
        bearing = self.bearing
        return 0.5e9 * bearing.youngs_modulus_gpa / (1 - bearing.poissons_ratio**2)

    @property
    def ball_mass(self) -> float:
        """Mass of a ball [kg]."""
        return self.bearing.density_kg_m3 * 4 / 3 * math.pi * self.ball_radius**3

    @property
    def moving_ring(self) -> Ring:
        """Ring that does not turn, and vibrates."""
        return "outer" if self.bearing.turning == "inner" else "inner"

    @property
    def ring_mass(self) -> float:
        """Mass of the ring that vibrates [kg], by default from its dimensions."""
        if self.bearing.ring_mass_kg is not None:
            return self.bearing.ring_mass_kg
        section = self.ring_section
        return self.bearing.density_kg_m3 * section.area * 2 * math.pi * section.radius

    @property
    def axial_load(self) -> float:
        """Axial load [N]."""
        return self.bearing.axial_load_n

    @property
    def radial_load(self) -> float:
        """Radial load [N]."""
        return self.bearing.radial_load_n

    @property
    def turns_hz(self) -> float:
        """Turns of the turning ring per second [Hz]."""
        return self.bearing.speed_rpm / 60

    @cached_property
    def kinematics(self) -> Kinematics:
        """Speeds of rings, cage and balls."""
        return bearing_rules.speeds_of(self.bearing, self.geometry)

    @property
    def loaded_ring(self) -> LoadedRing:
        """The ring that vibrates with its loads, rigid and held from tilting."""
        return bearing_rules.loaded_ring_of(self.bearing)

    @cached_property
    def model(self) -> BearingModel:
        """Model of the bearing whose ring moves."""
        return BearingModel(
            geometry=self.geometry,
            kinematics=self.kinematics,
            ring_mass_kg=self.ring_mass,
            ball_mass_kg=self.ball_mass,
            axial_load_n=self.axial_load,
            radial_load_n=self.radial_load,
            gap_m=self.gap,
            contact_loss_factor=self.bearing.contact_loss_factor,
            ball_inertia=self.bearing.ball_inertia,
            angle=self.bearing.angle,
            bending=self.ring_bending.modes if self.bearing.ring == "elastic" else (),
            tilt_inertia_kg_m2=self._tilt_inertia if self.bearing.tilt == "free" else None,
            film_time_s=self._film_time,
        )

    @property
    def _film_time(self) -> float:
        """Viscosity of the films over the contact stiffness [s], 0 in dry contacts."""
        films = self.films.values()
        return TIME_S * sum(film.weight for film in films) / 2

    @cached_property
    def films(self) -> dict[str, ContactFilm]:
        """Films of oil on the inner and on the outer raceway, none in dry contacts."""
        given = self.bearing.oil
        if given is None:
            return {}
        slope = USUAL_SLOPE
        if given.viscosity_100_mm2_s is not None:
            slope = viscosity_slope(given.viscosity_40_mm2_s, given.viscosity_100_mm2_s)
        kinematic = kinematic_viscosity_mm2_s(given.temperature_c, given.viscosity_40_mm2_s, slope)
        oil = Oil(
            viscosity_pa_s=1e-6 * kinematic * given.density_kg_m3,
            pressure_viscosity_per_pa=1e-9 * given.pressure_viscosity_per_gpa,
        )
        load = self._mean_ball_load
        return {
            ring: contact_film(
                contact=getattr(self.geometry, ring),
                load_n=load,
                rolling_speed_m_s=self.kinematics.rolling_speed_m_s,
                oil=oil,
                roughness_m=bearing_rules.rms_roughness_m(self.bearing, ring),
            )
            for ring in ("inner", "outer")
        }

    @property
    def _mean_ball_load(self) -> float:
        """Mean load of a ball that bears some [N], over the places of the cage."""
        balances = balances_around(self.geometry, self.loaded_ring)
        loads = np.concatenate([balance.ball_load_n for balance in balances])
        return float(loads[loads > 0].mean())

    @property
    def _tilt_inertia(self) -> float:
        """Moment of inertia [kg m2] of the ring that vibrates about a diameter."""
        return self.ring_mass * gyration_squared(self.ring_section.radius, self.width)

    @cached_property
    def ring_bending(self) -> RingBending:
        """Bending of the ring that vibrates, without what holds it."""
        outer = self.moving_ring == "outer"
        shape = self.ring_section
        section = GroovedSection(
            wall_m=shape.wall,
            depth_m=shape.depth,
            groove_radius_m=self.groove_radii[self.moving_ring],
            width_m=self.width,
        )
        surface = (self.outside_diameter if outer else self.bore) / 2
        return RingBending(
            section=section,
            radius_m=surface - section.centroid_m if outer else surface + section.centroid_m,
            youngs_modulus=1e9 * self.bearing.youngs_modulus_gpa,
            poissons_ratio=self.bearing.poissons_ratio,
            density=self.bearing.density_kg_m3,
        )

    @property
    def ring_bending_hz(self) -> float:
        """First bending mode [Hz] of the ring that vibrates, up to which it is rigid."""
        return self.ring_bending.in_plane_hz(2)

    @property
    def ring_holds_hz(self) -> float:
        """Frequency [Hz] up to which the ring moves as its key `ring` has it."""
        if self.model.bending:
            return self.ring_bending.left_out_hz
        return self.ring_bending_hz

    @property
    def sensor(self) -> float | None:
        """Angle [rad] of the sensor from the middle of the load zone, None for a mean."""
        given = self.bearing.sensor_deg
        return None if given is None else math.radians(given)

    def seen_at(self, without: str) -> str:
        """Say where signals of the ring are seen; `without` says it where there is no sensor."""
        given = self.bearing.sensor_deg
        return without if given is None else f"at the sensor, {given:g} degrees from the load"

    @property
    def spacing(self) -> float | None:
        """Node spacing [m], None where it is automatic."""
        given = self.numerics.spacing_um
        return None if given is None else 1e-6 * given

    @property
    def duration(self) -> float:
        """Time [s] that is computed."""
        return self.sound.duration_s

    @property
    def listened(self) -> float:
        """Length [s] of the record to listen to."""
        if self.sound.listen_s is not None:
            return self.sound.listen_s
        return max(LISTENED_S, self.sound.duration_s)

    @property
    def moved(self) -> float:
        """Time [s] in which the ring moves: that which is computed, or heard if that is longer."""
        return max(self.duration, self.listened)


def _sweep(value: Any) -> dict[str, Any]:
    """Return a sweep of a bearing with its lists as tuples, or refuse it."""
    return sweeps.check_lists(value, BearingQuantities)


class BearingScene(BearingQuantities):
    """Scene of a bearing that turns: its geometry, surfaces, loads and speed.

    Scenes are equal when all their values are equal, wherever they were read from.

    Attributes
    ----------
    name : str
        Name, used for the folder of the results
    title : str, optional
        Title of the page, any text
    description : str, optional
        Subject of the scene
    listen_for : str, optional
        What to listen for, in one line
    bearing : Bearing
        Geometry, loads, speed and surfaces
    plate : HousingPlate, optional
        Plate of the housing, whose sound is heard. Default: none, so the vibration is heard.
    numerics : BearingNumerics
        Resolution and accuracy of the rough contacts
    sound : BearingSound
        Record of the vibration, and listener of the plate
    sweep : dict
        Lists of values by dotted key, or values by label. All combinations are run.

    Raises
    ------
    SceneError
        Some values are missing, unknown or not allowed, in the scene or in a run of its sweep.

    Examples
    --------
    >>> import math, rolling
    >>> scene = rolling.BearingScene(
    ...     bearing=rolling.Bearing(named="6204", speed_rpm=1800, axial_load_n=70)
    ... )
    >>> f"{math.degrees(scene.contact_angle):.1f} degrees, {scene.turns_hz:g} turns/s"
    '11.4 degrees, 30 turns/s'
    """

    sweep: Annotated[
        dict[str, Any],
        BeforeValidator(_sweep),
        WithJsonSchema({"type": "object"}),
    ] = Field(default={})

    @field_validator("numerics")
    @classmethod
    def _check_surfaces(cls, numerics: BearingNumerics, info: ValidationInfo) -> BearingNumerics:
        bearing = info.data.get("bearing")
        if bearing is not None:
            mistakes = list(bearing_rules.mistakes_of_surfaces(bearing, numerics))
            mistakes += bearing_rules.mistakes_in_housing(bearing, info.data.get("plate"))
            if mistakes:
                raise mistakes_together(mistakes)
        return numerics

    def _data_to_change(self, changes: Mapping[str, Any]) -> dict[str, Any]:
        data = super()._data_to_change(changes)
        return self._without_usual_ring(data) if "plate" in changes else data

    def _data_of_runs(self) -> dict[str, Any]:
        data = super()._data_of_runs()
        return self._without_usual_ring(data) if "plate" in self.sweep else data

    def _without_usual_ring(self, data: dict[str, Any]) -> dict[str, Any]:
        """Return plain values without a ring that is the default, which follows the plate."""
        usual = Bearing.model_fields["ring"].default if self.plate is None else RING_IN_SEAT
        if self.bearing.ring == usual:
            del data["bearing"]["ring"]
        return data

    def __copy__(self) -> Self:
        copied = super().__copy__()
        # a copy may be given other values
        for name in ("geometry", "kinematics", "model", "ring_bending", "films"):
            copied.__dict__.pop(name, None)
        return copied

    def __repr__(self) -> str:
        bearing = self.bearing
        size = f"{bearing.balls} balls of {bearing.ball_diameter_mm:g} mm"
        if bearing.named is not None:
            size = f"{bearing.named}, {size}"
        loads = f"{bearing.axial_load_n:g} N axial, {bearing.radial_load_n:g} N radial"
        text = f"{self.name}: {size}, {loads}, {bearing.speed_rpm:g} rpm"
        if self.sweep:
            text += f", sweep of {', '.join(self.sweep)}"
        return f"BearingScene({text})"
