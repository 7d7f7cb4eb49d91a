"""The rules of a bearing, each with the message for one that cannot be assembled or loaded so."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic_core import PydanticCustomError

from acoustics.numbers import rounded
from rolling.bearing.geometry import BearingGeometry, assemble
from rolling.bearing.kinematics import Kinematics, kinematics_of
from rolling.bearing.limits import broken_limits
from rolling.bearing.model import BearingModel
from rolling.bearing.static_load import (
    FREE_TO_TILT,
    LoadedRing,
    balances_around,
    least_axial_load,
    rolling_angle,
    static_balance,
)
from rolling.bearing.waves import hertz_pressure
from rolling.contact.track import MAX_NODES, MIN_NODES
from rolling.scene import height_files, roundness_files
from rolling.scene.bearing_lengths import angle_of, clearance_of, groove_distance
from rolling.scene.height_grid import mistakes_at
from rolling.scene.laws import refuse_misplaced
from rolling.scene.messages import Key, SceneError, mistake, plain_number
from rolling.scene.raceways import BearingSurface
from rolling.scene.surfaces import BallHeightFile
from rolling.surface.ball_form import WAVE_NODES

if TYPE_CHECKING:
    from rolling.scene.bearing_scene import BearingQuantities
    from rolling.scene.bearing_sections import Bearing, BearingNumerics, HousingPlate

MAX_BALLS = 300  # of one row, in the largest thin-section bearings
MAX_ANGLE_DEG = 60  # of radial bearings; thrust bearings beyond have other rings
STATIC_GPA = 4.2  # largest Hertz pressure under the static load rating of ISO 76
# Proportions of usual deep-groove bearings: within 5 % for bore and outside diameter of 608, 6204
# and 6305, within 15 % for their width.
BALL_SHARE = 0.3  # diameter of a ball over outside diameter less bore
WIDTH_OVER_BALL = 1.7
LEAST_BORE = 0.3  # of the inner groove, where the balls are large for their circle
FINEST_UM = 0.5  # spacing that holds all waves where numerics.spacing_um is automatic
HEAVY_KG = 1e6  # in place of a ring's mass that is not given, which follows from its dimensions
_STEPS = 50  # of a bisection, which halves its range each time
_ROUNDING = 1e-12  # of binary numbers
_LEAST_SHARE = 1e-12  # of the loads beside balls that a negative clearance presses
SAME_ANGLE_DEG = 0.1  # difference that the rounding of angle or clearance makes


def free_angle(bearing: Bearing) -> float:
    """Return the contact angle without load [rad], from the clearance where no angle is given."""
    if bearing.contact_angle_deg is not None:
        return math.radians(bearing.contact_angle_deg)
    clearance = 1e-6 * (bearing.radial_clearance_um or 0.0)
    return angle_of(clearance, _distance(bearing))


def free_clearance(bearing: Bearing) -> float:
    """Return the radial clearance without load [m], from the angle where no clearance is given."""
    if bearing.radial_clearance_um is not None:
        return 1e-6 * bearing.radial_clearance_um
    return clearance_of(free_angle(bearing), _distance(bearing))


def geometry_of(bearing: Bearing) -> BearingGeometry:
    """Return the geometry of a bearing.

    Under an axial load the balls touch at the free contact angle. Under a purely radial load they
    touch in the middle of the grooves.
    """
    compliance = 2 * (1 - bearing.poissons_ratio**2) / (1e9 * bearing.youngs_modulus_gpa)
    return assemble(
        balls=bearing.balls,
        ball_diameter_m=1e-3 * bearing.ball_diameter_mm,
        pitch_diameter_m=1e-3 * bearing.pitch_diameter_mm,
        contact_angle=free_angle(bearing) if bearing.axial_load_n > 0 else 0.0,
        conformity_inner=bearing.conformity_inner,
        conformity_outer=bearing.conformity_outer,
        contact_modulus=1 / compliance,
    )


def gap_of(bearing: Bearing) -> float:
    """Return the gap [m] of each ball with the ring centred.

    An axial load closes it. A negative one is the approach of each ball without a load.
    """
    gap = free_clearance(bearing) / 2
    return min(gap, 0.0) if bearing.axial_load_n > 0 else gap


def loaded_ring_of(bearing: Bearing) -> LoadedRing:
    """Return the ring that moves with its loads, rigid and held from tilting."""
    return LoadedRing(
        axial_load_n=bearing.axial_load_n,
        radial_load_n=bearing.radial_load_n,
        gap_m=gap_of(bearing),
        moving="outer" if bearing.turning == "inner" else "inner",
        angle=bearing.angle,
    )


def speeds_of(bearing: Bearing, geometry: BearingGeometry) -> Kinematics:
    """Return the speeds of a bearing, whose balls roll at the angle to which the loads turn it."""
    angle = None
    if bearing.angle == "moving":
        ring = loaded_ring_of(bearing)
        if bearing.tilt == "free":
            ring = replace(ring, moments_n_m=FREE_TO_TILT)
        balances = balances_around(geometry, ring)
        angle = rolling_angle(balances)
    return kinematics_of(geometry, bearing.turning, bearing.speed_rpm / 60, angle)


def usual_bore_mm(bearing: Bearing) -> float:
    """Return the bore [mm] of a usual bearing with such balls on such a pitch circle."""
    pitch = bearing.pitch_diameter_mm
    ball = bearing.ball_diameter_mm
    return max(pitch - ball / (2 * BALL_SHARE), LEAST_BORE * (pitch - ball))


def usual_outside_mm(bearing: Bearing) -> float:
    """Return the outside diameter [mm] of a usual bearing with such balls."""
    return bearing.pitch_diameter_mm + bearing.ball_diameter_mm / (2 * BALL_SHARE)


def usual_width_mm(bearing: Bearing) -> float:
    """Return the width [mm] of a usual bearing with such balls."""
    return WIDTH_OVER_BALL * bearing.ball_diameter_mm


def _distance(bearing: Bearing) -> float:
    """Return the distance of the centres of both grooves [m]."""
    return groove_distance(
        1e-3 * bearing.ball_diameter_mm, bearing.conformity_inner, bearing.conformity_outer
    )


def mistakes_of_bearing(bearing: Bearing) -> Iterator[PydanticCustomError]:
    """Yield all that does not fit together in a bearing."""
    assembly = [*_mistakes_of_balls(bearing), *_mistakes_of_rings(bearing)]
    angle = [*_mistakes_of_angle(bearing)]
    yield from assembly
    yield from angle
    if not bearing.axial_load_n and not bearing.radial_load_n:
        yield mistake(
            "missing; give it, a radial_load_n, or both",
            at=".axial_load_n",
            needs=[".radial_load_n"],
        )
    elif not angle and bearing.pitch_diameter_mm > bearing.ball_diameter_mm:
        load = [*_mistakes_of_load(bearing)]
        yield from load
        if not load:
            yield from _mistakes_of_motion(bearing)
    if bearing.tilt == "free" and bearing.angle == "fixed":
        yield mistake(
            "got free, allowed beside a fixed angle: held, because a tilt then presses the balls as"
            " a radial displacement does; or bearing.angle moving",
            at=".tilt",
        )
    if bearing.oil is not None and bearing.oil.roughness_rq_um is None:
        yield from _mistakes_of_film(bearing)
    if bearing.surfaces.fault_ball >= bearing.balls:
        yield mistake(
            f"got {bearing.surfaces.fault_ball}, allowed: 0 to {bearing.balls - 1}, the numbers of"
            " the balls",
            at=".surfaces.fault_ball",
        )


def _mistakes_of_film(bearing: Bearing) -> Iterator[PydanticCustomError]:
    """Yield the mistake of a film beside heights whose roughness no law tells."""
    for name in ("balls", "inner", "outer"):
        surface = getattr(bearing.surfaces, name)
        if isinstance(surface, BallHeightFile):
            yield mistake(
                f"missing; a film is compared to the rms roughness, which the file of {name} does"
                " not tell apart from form",
                at=".oil.roughness_rq_um",
            )
            return


def rms_roughness_m(bearing: Bearing, ring: str) -> float:
    """Return the rms roughness [m] of the balls and a raceway together."""
    assert bearing.oil is not None
    if bearing.oil.roughness_rq_um is not None:
        return 1e-6 * bearing.oil.roughness_rq_um
    square = 0.0
    for surface in (bearing.surfaces.balls, getattr(bearing.surfaces, ring)):
        law = getattr(surface, "law", None)
        if law is not None:
            square += law.rq_m**2
    return math.sqrt(square)


def _mistakes_of_balls(bearing: Bearing) -> Iterator[PydanticCustomError]:
    """Yield the mistake of balls that overlap their neighbours on the pitch circle."""
    ball = bearing.ball_diameter_mm
    pitch = bearing.pitch_diameter_mm
    if pitch * math.sin(math.pi / bearing.balls) > ball:
        return
    most = 0
    if pitch > ball:
        most = math.ceil(math.pi / math.asin(ball / pitch)) - 1
    if most >= 3:
        yield mistake(
            f"got {bearing.balls}, allowed: at most {most} balls of {ball:g} mm on a pitch circle"
            f" of {pitch:g} mm, where more overlap",
            at=".balls",
        )
        return
    smallest = ball / math.sin(math.pi / bearing.balls)
    yield mistake(
        f"got {plain_number(pitch)}, allowed: above {_above(smallest)} for {bearing.balls} balls of"
        f" {ball:g} mm, which overlap on a smaller circle",
        at=".pitch_diameter_mm",
    )


def _mistakes_of_rings(bearing: Bearing) -> Iterator[PydanticCustomError]:
    """Yield the mistakes of rings without a wall behind their grooves."""
    inner = bearing.pitch_diameter_mm - bearing.ball_diameter_mm
    outer = bearing.pitch_diameter_mm + bearing.ball_diameter_mm
    bore = bearing.bore_mm
    outside = bearing.outside_diameter_mm
    width = bearing.width_mm
    if bore is not None and bore >= inner > 0:
        yield mistake(
            f"got {plain_number(bore)}, allowed: below {_below(inner)}, the pitch diameter less a"
            " ball, where the inner groove is",
            at=".bore_mm",
        )
    if outside is not None and outside <= outer:
        yield mistake(
            f"got {plain_number(outside)}, allowed: above {_above(outer)}, the pitch diameter and a"
            " ball, where the outer groove is",
            at=".outside_diameter_mm",
        )
    if width is not None and width < bearing.ball_diameter_mm:
        yield mistake(
            f"got {plain_number(width)}, allowed: at least {_above(bearing.ball_diameter_mm)}, the"
            " diameter of a ball",
            at=".width_mm",
        )


def _mistakes_of_angle(bearing: Bearing) -> Iterator[PydanticCustomError]:
    """Yield the mistakes of contact angle and radial clearance."""
    distance = _distance(bearing)
    angle_deg = bearing.contact_angle_deg
    clearance_um = bearing.radial_clearance_um
    if clearance_um is not None:
        most_um = 1e6 * clearance_of(math.radians(MAX_ANGLE_DEG), distance)
        if clearance_um > most_um:
            yield mistake(
                f"got {plain_number(clearance_um)}, allowed: at most {_below(most_um)} with these"
                f" grooves, at which the contact angle is {MAX_ANGLE_DEG} degrees",
                at=".radial_clearance_um",
            )
            return
    is_used = bool(angle_deg or bearing.axial_load_n)  # a radial load alone sets the angle to 0
    if angle_deg is not None and clearance_um is not None and is_used:
        derived = math.degrees(angle_of(1e-6 * clearance_um, distance))
        if abs(derived - angle_deg) > SAME_ANGLE_DEG:
            fitting_um = 1e6 * clearance_of(math.radians(angle_deg), distance)
            yield mistake(
                f"got {plain_number(angle_deg)} beside radial_clearance_um"
                f" {plain_number(clearance_um)}, which gives {rounded(derived, 4)}; allowed: one of"
                f" them, or {rounded(fitting_um, 4)} um beside this angle",
                at=".contact_angle_deg",
            )
            return
    if not bearing.axial_load_n:
        return
    if angle_deg is None and clearance_um is None:
        yield mistake(
            "missing; an axial load needs it or a radial_clearance_um",
            at=".contact_angle_deg",
            needs=[".radial_clearance_um"],
        )
    elif bearing.angle == "fixed" and not free_angle(bearing):
        key = ".contact_angle_deg" if angle_deg is not None else ".radial_clearance_um"
        given = angle_deg or clearance_um or 0.0
        yield mistake(
            f"got {plain_number(given)}, allowed with an axial load: above 0, because balls at an"
            " angle of 0 bear no axial load; or bearing.angle moving",
            at=key,
        )


def _mistakes_of_load(bearing: Bearing) -> Iterator[PydanticCustomError]:
    """Yield the mistakes of loads that have no balance, or are beyond the static capacity."""
    axial = bearing.axial_load_n
    radial = bearing.radial_load_n
    geometry = geometry_of(bearing)
    least = least_axial_load(geometry, radial) if axial else 0.0
    if bearing.angle == "fixed" and axial and axial <= least:
        yield mistake(
            f"got {plain_number(radial)}, allowed beside axial_load_n {plain_number(axial)} at a"
            f" contact angle of {rounded(math.degrees(geometry.contact_angle), 3)} degrees: below"
            f" {_below(radial * axial / least)}; or an axial load above {_above(least)}, or none;"
            " or bearing.angle moving, at which all loads have a balance",
            at=".radial_load_n",
        )
        return
    limit = 1e9 * STATIC_GPA
    preload = pressure_by_clearance(bearing, geometry)
    if preload >= limit:
        # The pressure grows with the root of the approach.
        most = 2e6 * gap_of(bearing) * (limit / preload) ** 2
        yield mistake(
            f"got {plain_number(2e6 * gap_of(bearing))}, allowed: at least -{_below(-most)}:"
            f" the Hertz pressure would be {rounded(1e-9 * preload, 3)} GPa without a load, and the"
            f" static capacity ends at {STATIC_GPA} GPa",
            at=".radial_clearance_um",
        )
        return
    pressure = largest_pressure(bearing, geometry)
    if pressure <= limit:
        return
    share = _allowed_share(bearing, geometry, limit)
    key = "axial_load_n" if axial else "radial_load_n"
    load = axial or radial
    beside = ""
    if axial and radial:
        beside = f" beside radial_load_n {_below(share * radial)}"
    elif radial:
        beside = " beside axial_load_n 0"
    yield mistake(
        f"got {plain_number(load)}, allowed: at most {_below(share * load)}{beside}: the largest"
        f" Hertz pressure would be {rounded(1e-9 * pressure, 3)} GPa, and the static capacity ends"
        f" at {STATIC_GPA} GPa",
        at=f".{key}",
        needs=[".axial_load_n"],
    )


def _mistakes_of_motion(bearing: Bearing) -> Iterator[PydanticCustomError]:
    """Yield the mistakes of a ring or of balls that time steps cannot follow."""
    geometry = geometry_of(bearing)
    radius = 5e-4 * bearing.ball_diameter_mm
    model = BearingModel(
        geometry=geometry,
        kinematics=speeds_of(bearing, geometry),
        ring_mass_kg=bearing.ring_mass_kg or HEAVY_KG,
        ball_mass_kg=bearing.density_kg_m3 * 4 / 3 * math.pi * radius**3,
        axial_load_n=bearing.axial_load_n,
        radial_load_n=bearing.radial_load_n,
        gap_m=gap_of(bearing),
        ball_inertia=bearing.ball_inertia,
        angle=bearing.angle,
    )
    for entry in broken_limits(model):
        yield mistake(entry.text, at=f".{entry.key}")


def largest_pressure(bearing: Bearing, geometry: BearingGeometry, share: float = 1.0) -> float:
    """Return the largest Hertz pressure [Pa] of a ball under a share of both loads.

    One ball is in the middle of the load zone.
    """
    ring = loaded_ring_of(bearing)
    shared = replace(
        ring,
        axial_load_n=share * ring.axial_load_n,
        radial_load_n=share * ring.radial_load_n,
    )
    balance = static_balance(geometry, shared)
    load = float(balance.ball_load_n.max())
    if load <= 0:  # a load that is lost in the rounding of the gap
        return 0.0
    return max(hertz_pressure(contact, load) for contact in (geometry.inner, geometry.outer))


def pressure_by_clearance(bearing: Bearing, geometry: BearingGeometry) -> float:
    """Return the Hertz pressure [Pa] of all balls by a negative clearance alone, or 0."""
    load = geometry.series_stiffness * max(-gap_of(bearing), 0.0) ** 1.5
    if load <= 0:
        return 0.0
    return max(hertz_pressure(contact, load) for contact in (geometry.inner, geometry.outer))


def _allowed_share(bearing: Bearing, geometry: BearingGeometry, limit: float) -> float:
    """Return the share of both loads at which the largest pressure is at a limit [Pa]."""
    low = (limit / largest_pressure(bearing, geometry)) ** 3
    if bearing.angle == "fixed" and not gap_of(bearing):
        return low
    # With a gap fewer balls bear a smaller load, so that a larger share of it is on one. At a
    # moving angle the load of a ball falls with that on the ring, or with its power 3/4 at least.
    high = 1.0
    low = low ** (4 / 3) / bearing.balls if gap_of(bearing) >= 0 else _LEAST_SHARE
    for _ in range(_STEPS):
        share = math.sqrt(low * high)
        if largest_pressure(bearing, geometry, share) < limit:
            low = share
        else:
            high = share
    return low


def _below(limit: float) -> str:
    """Write a limit with four digits, rounded down."""
    digit = 10.0 ** (math.floor(math.log10(limit)) - 3)
    return f"{math.floor(limit / digit * (1 + _ROUNDING)) * digit:.10g}"


def _above(limit: float) -> str:
    """Write a limit with four digits, rounded up."""
    digit = 10.0 ** (math.floor(math.log10(limit)) - 3)
    return f"{math.ceil(limit / digit * (1 - _ROUNDING)) * digit:.10g}"


# ---- housing and surfaces


def mistakes_in_housing(
    bearing: Bearing, plate: HousingPlate | None
) -> Iterator[PydanticCustomError]:
    """Yield the mistakes of a ring that its seat in a housing holds."""
    if plate is None:
        return
    for key, held in (("ring", "rigid"), ("tilt", "held")):
        if getattr(bearing, key) != held:
            yield mistake(
                f"got {getattr(bearing, key)}, allowed beside a plate: {held}, because its seat in"
                " the housing holds the ring",
                at=("bearing", key),
            )


def mistakes_of_surfaces(
    bearing: Bearing, numerics: BearingNumerics
) -> Iterator[PydanticCustomError]:
    """Yield the mistakes of surfaces that do not fit their circumference in nodes."""
    pitch = bearing.pitch_diameter_mm
    projected = bearing.ball_diameter_mm * math.cos(geometry_of(bearing).contact_angle)
    diameters = {
        "balls": bearing.ball_diameter_mm,
        "inner": pitch - projected,
        "outer": pitch + projected,
    }
    for name, diameter in diameters.items():
        surface = getattr(bearing.surfaces, name)
        if surface is not None:
            yield from _mistakes_of_surface(
                surface=surface,
                length_um=1e3 * math.pi * diameter,
                width_um=1e3 * bearing.ball_diameter_mm,
                spacing_um=numerics.spacing_um or FINEST_UM,
                at=("bearing", "surfaces", name),
            )


def _mistakes_of_surface(
    surface: BearingSurface, length_um: float, width_um: float, spacing_um: float, at: Key
) -> Iterator[PydanticCustomError]:
    """Yield the mistakes of one surface; faults of a place lie within the diameter of a ball."""
    if not MIN_NODES <= length_um / spacing_um < MAX_NODES:
        yield mistake(
            f"got a circumference of {rounded(length_um, 4)} um, allowed: {MIN_NODES} to"
            f" {rounded(MAX_NODES)} nodes of {spacing_um:g} um",
            at=at,
        )
        return
    highest = max(surface.waviness or {0: 0.0})
    most = round(length_um / spacing_um) // WAVE_NODES
    if highest > most:
        yield mistake(
            f"got the order {highest}, allowed: up to {most}, waves of at least {WAVE_NODES} nodes",
            at=(*at, "waviness"),
        )
    try:
        refuse_misplaced(surface.faults or [], length_um, width_um, spacing_um, (*at, "faults"))
    except PydanticCustomError as error:
        yield error


def refuse_height_files(scene: BearingQuantities) -> None:
    """Refuse files of heights that are missing or hold no turn of their body, and bad roundness.

    Raise SceneError with all of them.
    """
    lines = []
    for name, path in scene.height_paths.items():
        key = f"{name}.path"
        try:
            if name.endswith(".roundness"):
                _refuse_roundness(scene, name, path)
            else:
                _refuse_turn(scene, name, path)
        except PydanticCustomError as error:
            message = (error.context or {})["message"]
            lines.append(f"{scene.place(key)}: {key}: {message}")
    if lines:
        raise SceneError(lines)


def _refuse_roundness(scene: BearingQuantities, name: str, path: Path) -> None:
    """Raise a mistake for a file that holds no measured waves."""
    raceway = getattr(scene.bearing.surfaces, name.split(".")[2])
    roundness = raceway.roundness
    with mistakes_at(path, roundness.path, f"{name}.path"):
        roundness_files.read_waves(path, roundness.height_unit)


def _refuse_turn(scene: BearingQuantities, name: str, path: Path) -> None:
    """Raise a mistake for a file whose nodes are no turn of its body."""
    body = name.rpartition(".")[2]
    surface = getattr(scene.bearing.surfaces, body)
    with mistakes_at(path, surface.path, f"{name}.path"):
        rows, _ = height_files.nodes(path)
    nodes = round(1e6 * scene.circumferences[body] / surface.spacing_um)
    if rows == nodes:
        return
    spacing_um = 1e6 * scene.circumferences[body] / rows
    raise mistake(
        f"{surface.path}: got {rows} nodes around, allowed: {nodes} nodes of"
        f" {surface.spacing_um:g} um; {rows} nodes are a turn with a spacing_um of"
        f" {rounded(spacing_um, 8)}"
    )
