"""Quantities of a scene in SI, from the values of its sections."""

import math
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import Field, field_validator
from pydantic_core import PydanticCustomError

from acoustics.numbers import bracketed
from rolling.contact.track import Motion, Track, Travel
from rolling.scene import library, step_rule
from rolling.scene.automatic_tolerance import automatic_tolerance
from rolling.scene.height_grid import height_grid, refuse_turn
from rolling.scene.laws import HeightLaw, SurfaceFault, refuse_misplaced
from rolling.scene.messages import SceneError, dotted
from rolling.scene.sections import (
    LENGTH_KEYS,
    Dynamics,
    Numerics,
    Plate,
    Recovery,
    Rolling,
    Sound,
    Sphere,
)
from rolling.scene.surfaces import BallHeightFile, HeightFile, MadeSurface, Surface, turn_nodes
from rolling.scene.swept import DEFAULT_NAME, PATTERN, SceneName, SweptScene
from rolling.scene.track_length import WantedDistance, file_track, made_track, wanted_distance

if TYPE_CHECKING:
    from rolling.sound.needed_record import Need

STEEL_GPA = 210.0
STEEL_POISSON = 0.3
STEEL_DENSITY = 7850.0  # [kg/m3]
GRAVITY = 9.80665  # [m/s2]
_FREE = 5 / 7  # of the force over the mass: a solid sphere that rolls has 7/5 of its mass
AUTO_NODES = 4  # of which a track of auto has a whole number, as long as the longest steps of auto
HEARD_MODES_HZ = 30e3  # highest frequency of the modes of a plate with edges


class SceneQuantities(SweptScene):
    """Sections of a scene, and its quantities in SI."""

    name: SceneName = Field(default=DEFAULT_NAME, pattern=PATTERN)
    title: str | None = None
    description: str | None = None
    listen_for: str | None = None
    sphere: Sphere
    plate: Plate
    surface: Surface
    rolling: Rolling
    numerics: Numerics = Field(default_factory=Numerics, validate_default=True)
    recovery: Recovery = Field(default_factory=Recovery)
    dynamics: Dynamics | None = Field(default=None, validate_default=True)
    sound: Sound = Field(default_factory=Sound, validate_default=True)

    @field_validator("surface", mode="before")
    @classmethod
    def _of_kind(cls, surface: Any) -> Any:
        """Fill in a surface with a finish, whose kind may be missing."""
        return library.fill_in("surface", surface)

    @property
    def height_path(self) -> Path | None:
        """File of the plate's heights; None when its surface is generated."""
        return self._folder / self.surface.path if isinstance(self.surface, HeightFile) else None

    @property
    def height_paths(self) -> dict[str, Path]:
        """Files of heights by the section that reads them."""
        sections = {"surface": self.surface, "sphere.surface": self.sphere.surface}
        return {
            name: self._folder / section.path
            for name, section in sections.items()
            if isinstance(section, HeightFile | BallHeightFile)
        }

    @property
    def laws(self) -> tuple[HeightLaw, ...]:
        """Laws of the random heights of plate and sphere, none beside heights from a file."""
        if self.height_paths:
            return ()
        surfaces = [self.surface, self.sphere.surface]
        laws = [surface.law for surface in surfaces if surface is not None]
        return tuple(law for law in laws if law is not None)

    @property
    def has_moments(self) -> bool:
        """Whether some random heights of plate and sphere are not Gaussian."""
        return not all(law.is_gaussian for law in self.laws)

    @property
    def faults(self) -> list[SurfaceFault]:
        """Single faults of plate and sphere."""
        faults = list(self.surface.faults or ())
        if self.sphere.surface is not None:
            faults += self.sphere.surface.faults or ()
        return faults

    @property
    def is_smooth(self) -> bool:
        """Whether plate and sphere are perfectly smooth."""
        ball = self.sphere.surface
        formed = ball is not None and ball.has_form
        return not (self.height_paths or self.laws or self.faults or formed)

    # What follows from a fall. Rooms above ask for the fact that matters to them.

    @property
    def is_silent(self) -> bool:
        """Whether nothing moves the sphere: a smooth one that rolls on a smooth plate."""
        return self.is_smooth and not self.rolling.falls

    @property
    def is_one_event(self) -> bool:
        """Whether the record is one event that is heard once, and no steady sound."""
        return self.rolling.falls

    @property
    def keeps_its_load(self) -> bool:
        """Whether the contact force stays about the load, without impacts of many times as much."""
        return not self.rolling.falls

    @property
    def has_release(self) -> bool:
        """Whether what the contact releases along the track is heard; in flight there is none."""
        return not self.rolling.falls

    @cached_property
    def track(self) -> Track:
        """Positions of the sphere.

        The track lasts for the duration on a generated surface, and by default once round a height
        file.

        A track over a generated surface is rounded to whole nodes and whole steps, so that it
        closes on itself. Only the header of a height file in the format of numpy is read.

        Raises
        ------
        SceneError
            The height file is missing or holds no heights, or the sphere never gets round it.
        """
        try:
            track = track_of(self.sphere, self.surface, self.rolled, self.step_nodes, self.folder)
            ball = self.sphere.surface
            if isinstance(ball, BallHeightFile):
                refuse_turn(self.folder / ball.path, ball.path, track)
            return track
        except PydanticCustomError as error:
            context = error.context or {}
            raise SceneError([f"{dotted(context['at'])}: {context['message']}"]) from error

    @cached_property
    def motion(self) -> Motion:
        """Distance and speed over time."""
        return motion_of(self.sphere, self.rolling)

    @property
    def travel(self) -> Travel:
        """Motion along the track."""
        return Travel(motion=self.motion, track=self.track)

    @cached_property
    def duration(self) -> float:
        """Time [s] that the track takes."""
        return self.travel.duration_s

    @property
    def radius(self) -> float:
        """Radius of the sphere [m]."""
        return self.sphere.radius_mm * 1e-3

    @property
    def radius_across(self) -> float:
        """Radius of the sphere across the track [m]."""
        return 1e-3 * (self.sphere.radius_across_mm or self.sphere.radius_mm)

    @property
    def mass(self) -> float:
        """Mass of the sphere [kg]; it is of steel unless the scene gives a density."""
        return mass(self.sphere)

    @property
    def contact_modulus(self) -> float:
        """Contact modulus E* [Pa].

        1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2 holds, without the first term for a rigid sphere.
        """
        return contact_modulus(self.sphere, self.plate)

    @property
    def listeners(self) -> list[tuple[float, float, float]]:
        """Listeners [m] of a plate with edges from its corner, by default one above the contact."""
        if self.sound.listener_mm is not None:
            return [(1e-3 * x, 1e-3 * y, 1e-3 * z) for x, y, z in self.sound.listener_mm]
        x, y = self._middle_of_path
        return [(x, y, self.sound.distance_m)]

    @property
    def _middle_of_path(self) -> tuple[float, float]:
        """Contact point (x, y) [m] of a plate with edges, or the middle of its path."""
        ends = list(self.plate.contact_ends_mm.values())
        x, y = ends[0]
        to_x, to_y = ends[-1]
        return 5e-4 * (x + to_x), 5e-4 * (y + to_y)

    @property
    def is_listener_placed(self) -> bool:
        """Whether the levels belong to sound.listener_mm; otherwise they belong to distance_m."""
        return self.sound.listener_mm is not None and self.sound.source == "vibration"

    @property
    def listener_distance_m(self) -> float:
        """Distance [m] at which the sound is heard: of the vibration, or of the release."""
        return self.vibration_distance_m if self.is_listener_placed else self.sound.distance_m

    @property
    def vibration_distance_m(self) -> float:
        """Distance [m] from the contact, or the middle of its path, to who hears the vibration."""
        if self.sound.listener_mm is None:
            return self.sound.distance_m
        x, y = self._middle_of_path
        return math.dist((x, y, 0.0), self.listeners[0])

    @property
    def listener_place(self) -> str:
        """Place of the first listener in words: a distance, or coordinates from the corner."""
        if not self.is_listener_placed:
            return f"{self.sound.distance_m:g} m"
        assert self.sound.listener_mm is not None  # as it is placed
        place = bracketed(self.sound.listener_mm[0])
        return f"{place} mm, {self.listener_distance_m:.3g} m from the contact"

    @property
    def hardness(self) -> float:
        """Maximum pressure that the plate bears [Pa], infinite for a purely elastic plate."""
        return self.plate.cap_gpa * 1e9

    @property
    def is_permanent(self) -> bool:
        """Whether the plastic overlap stays in the surface of the plate."""
        return self.plate.plasticity == "permanent"

    @property
    def passes(self) -> int:
        """Number of passes over the track."""
        return self.rolling.passes or 1

    @property
    def spacing(self) -> float:
        """Node spacing [m], by default that of the height file."""
        given = self.surface.spacing_um
        return self.track.spacing if given is None else given * 1e-6

    @property
    def spacing_um(self) -> float:
        """Node spacing [um]."""
        return self.surface.spacing_um or self.track.spacing * 1e6

    @property
    def step(self) -> float:
        """Distance from one position to the next [m]."""
        return self.spacing * self.step_nodes

    @property
    def step_nodes(self) -> float:
        """Nodes from one position to the next, by the rule of `auto` unless there is a number."""
        given = self.numerics.step_nodes
        if isinstance(given, str):
            return step_rule.choose(self, self.slowest_speed).nodes
        return given

    @property
    def taken_values(self) -> dict[str, float]:
        """Numbers that stand for `auto` by dotted key, or those of the scene."""
        rolled = self.rolled
        lengths = {f"rolling.{key}": getattr(rolled, key) for key in LENGTH_KEYS}
        stated = {key: length for key, length in lengths.items() if length is not None}
        if isinstance(self.surface, HeightFile):
            stated = {key: length for key, length in stated.items() if length != "auto"}
        return {"numerics.step_nodes": self.step_nodes, **stated}

    @property
    def chosen_keys(self) -> frozenset[str]:
        """Dotted keys for which `auto` chooses numbers."""
        keys = set[str]()
        if self.numerics.step_nodes == "auto":
            keys.add("numerics.step_nodes")
        if self.chooses_length:
            keys.add(f"rolling.{self.rolling.length_key}")
        return frozenset(keys)

    @property
    def chooses_length(self) -> bool:
        """Whether `auto` chooses the length of the track; once round a file is no choice."""
        return isinstance(self.surface, MadeSurface) and self.rolling.length_key is not None

    @property
    def length_need(self) -> "Need":
        """Time [s] that the levels of the scene need alone, with the reason."""
        from rolling.in_si.length_rule import needed_length

        return needed_length(self)

    @property
    def rolled(self) -> Rolling:
        """Section `rolling` with a number in place of a length that `auto` chooses."""
        if not self.chooses_length:
            return self.rolling
        return self.rolling_for(self.length_need.seconds)

    def rolling_for(self, seconds: float) -> Rolling:
        """Return the section `rolling` of a scene whose `auto` takes at least a time [s].

        The track has a number of nodes that the longest steps divide, or whole turns of a ball with
        a surface, so that it closes on itself.
        """
        speed = self.motion.speeds[0]
        unit = AUTO_NODES
        if self.sphere.surface is not None:
            unit = turn_nodes(self.sphere.radius_mm, self.spacing_um)
        units = max(1, math.ceil(seconds * speed / (unit * self.spacing) - 1e-6))
        distance = units * unit * self.spacing
        key = self.rolling.length_key or LENGTH_KEYS[0]
        value = 1e3 * distance if key == "distance_mm" else distance / speed
        lengths: dict[str, float | None] = {**dict.fromkeys(LENGTH_KEYS)}
        lengths[key] = float(f"{value:.12g}")
        return self.rolling.model_copy(update=lengths)

    @property
    def slowest_speed(self) -> float:
        """Speed [m/s] for which `auto` chooses steps: the slowest that is heard, or less."""
        given = self.numerics.slowest_m_s
        return self.heard_speed if given is None else min(given, self.heard_speed)

    @property
    def heard_speed(self) -> float:
        """Speed [m/s] that the sphere reaches for all but 1 % of the time."""
        motion = self.motion
        if self.chooses_length:  # at one speed
            return motion.speeds[0]
        wanted = wanted_length(self.rolling, motion)
        if wanted is None:  # once round a height file
            return motion.usual_speed(motion.times[-1] or 1.0)
        return motion.usual_speed(motion.duration(min(wanted.distance, motion.final_distance)))

    @property
    def node_track(self) -> Track:
        """Positions of the sphere with steps of one node."""
        return track_of(self.sphere, self.surface, self.rolled, 1.0, self.folder)

    @property
    def tolerance(self) -> float:
        """Tolerance of the solver [-], by the rule of `auto` unless the scene gives a number."""
        given = self.numerics.tolerance
        return automatic_tolerance(self) if isinstance(given, str) else given

    @property
    def load(self) -> float:
        """Normal load [N]."""
        return load(self.sphere, self.rolling)

    @property
    def moves_release(self) -> bool:
        """Whether the release is wanted under the moving load.

        It is the default where the release is heard.
        """
        if self.dynamics is None:
            return False
        wanted = self.dynamics.release
        return self.sound.source == "release" if wanted is None else wanted

    @property
    def start(self) -> float:
        """First position along the track [m]."""
        return self.rolling.start_um * 1e-6

    @property
    def across_nodes(self) -> int:
        """Nodes across from the middle line of the plate's surface to the track, over its width."""
        nodes = round(self.rolling.across_um * 1e-6 / self.spacing)
        return nodes % self.track.n_across


def mass(sphere: Sphere) -> float:
    """Return the mass of a sphere [kg], of steel without a density."""
    radius = sphere.radius_mm * 1e-3
    return (sphere.density_kg_m3 or STEEL_DENSITY) * 4 / 3 * math.pi * radius**3


def load(sphere: Sphere, rolling: Rolling) -> float:
    """Return the load [N], by default the weight of the sphere."""
    return GRAVITY * mass(sphere) if isinstance(rolling.load_n, str) else rolling.load_n


def motion_of(sphere: Sphere, rolling: Rolling) -> Motion:
    """Return distance and speed over time of a sphere that keeps its speed, or rolls out."""
    if rolling.resistance is None or not isinstance(rolling.speed_m_s, float):
        return Motion.of(rolling.speed_m_s)
    acceleration = load(sphere, rolling) / mass(sphere)
    return Motion.rolling_out(rolling.speed_m_s, _FREE * rolling.resistance * acceleration)


def contact_modulus(sphere: Sphere, plate: Plate) -> float:
    """Return the contact modulus [Pa] of sphere and plate."""
    compliance = (1 - plate.poissons_ratio**2) / plate.youngs_modulus_gpa
    if sphere.youngs_modulus_gpa is not None and sphere.poissons_ratio is not None:
        compliance += (1 - sphere.poissons_ratio**2) / sphere.youngs_modulus_gpa
    return 1e9 / compliance


def plate_modes(plate: Plate) -> float:
    """Estimate the number of modes of a plate with edges up to 30 kHz; 0 without edges."""
    if plate.edges_mm is None or plate.thickness_mm is None:
        return 0.0
    area = plate.edges_mm[0] * plate.edges_mm[1] * 1e-6
    density = plate.density_kg_m3 or STEEL_DENSITY
    stretch = plate.youngs_modulus_gpa * 1e9 / (12 * density * (1 - plate.poissons_ratio**2))
    return area * HEARD_MODES_HZ / (2 * math.sqrt(stretch) * plate.thickness_mm * 1e-3)


def wanted_length(rolling: Rolling, motion: Motion) -> WantedDistance | None:
    """Return the distance that a section asks for; None without one."""
    return wanted_distance(
        rolling.stated_duration_s, rolling.stated_distance_mm, rolling.resistance, motion
    )


def track_of(
    sphere: Sphere, surface: Surface, rolling: Rolling, step_nodes: float, folder: Path
) -> Track:
    """Return the track over a surface in steps of some nodes.

    A wrong length or a misplaced single fault raises a mistake.
    """
    motion = motion_of(sphere, rolling)
    wanted = wanted_length(rolling, motion)
    ball = sphere.surface
    turn = 0
    if ball is not None and surface.spacing_um is not None:
        turn = turn_nodes(sphere.radius_mm, surface.spacing_um)
    if isinstance(surface, HeightFile):
        grid = height_grid(folder / surface.path, surface)
        track = file_track(
            nodes=grid.nodes,
            spacing=grid.spacing,
            step_nodes=step_nodes,
            motion=motion,
            wanted=wanted,
            turn_nodes=turn,
        )
    else:
        assert wanted is not None  # refused before
        track = made_track(
            n_across=surface.n_across,
            spacing=surface.spacing_um * 1e-6,
            step_nodes=step_nodes,
            motion=motion,
            wanted=wanted,
            turn_nodes=turn,
        )
    spacing_um = surface.spacing_um or track.spacing * 1e6
    width_um = track.n_across * spacing_um
    if surface.faults:
        length_um = track.plate_nodes * spacing_um
        refuse_misplaced(surface.faults, length_um, width_um, spacing_um, ("surface", "faults"))
    if ball is not None and ball.faults:
        at = ("sphere", "surface", "faults")
        refuse_misplaced(ball.faults, turn * spacing_um, width_um, spacing_um, at)
    return track
