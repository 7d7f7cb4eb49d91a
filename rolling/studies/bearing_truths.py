"""Case of `rolling validate`: speeds, loads and vibration of ball bearings."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array
from rolling.bearing.geometry import BearingGeometry, Ring, assemble
from rolling.bearing.kinematics import kinematics_of
from rolling.bearing.model import BearingModel
from rolling.bearing.ring_motion import RingMotion, move_ring
from rolling.bearing.static_load import LoadedRing, static_balance
from rolling.bearing.tracks import smooth_tracks, with_waves
from rolling.contact import closed_forms
from rolling.scene.bearing_lengths import angle_of, groove_distance

INCH_M = 0.0254
STEEL = 210e9, 0.3  # Young's modulus [Pa] and Poisson's ratio
RADIAL_N = 500.0
MANY_BALLS = 40
SLOW_HZ = 5.0  # turns of the shaft per second, with all lines far below the resonances
AXIAL_N = 70.0
RING_KG = 0.06
BALL_KG = 2e-3
WAVE_M = 1e-9  # amplitude of a wave, far below the approach
RECORD_S = 0.4


class PrintedSpeeds(NamedTuple):
    """Lines of a bearing over the turns of its shaft, as the source prints them."""

    item: str
    balls: int
    ball_inch: float
    pitch_inch: float
    lines: dict[str, float]


SPEEDS = (
    PrintedSpeeds(
        item="6205",
        balls=9,
        ball_inch=0.3126,
        pitch_inch=1.537,
        lines={"inner": 5.4152, "outer": 3.5848, "cage": 0.39828, "ball": 4.7135},
    ),
    PrintedSpeeds(
        item="6203",
        balls=8,
        ball_inch=0.2656,
        pitch_inch=1.122,
        lines={"inner": 4.9469, "outer": 3.0530, "cage": 0.3817, "ball": 3.9874},
    ),
)


class PrintedDisplacements(NamedTuple):
    """Displacements of the rings under 1 kN along a radius, and along the axis from the plane."""

    clearance_um: float
    radial_um: float
    axial_um: float


DISPLACEMENTS = (
    PrintedDisplacements(clearance_um=0.0, radial_um=15.1101, axial_um=133.5381),
    PrintedDisplacements(clearance_um=10.0, radial_um=21.223, axial_um=149.1717),
)


def bearing_rows() -> Iterator[tuple[str, str, float, float]]:
    """Yield rule, item, published and own number of speeds, loads and waves."""
    yield from _speeds()
    yield from _largest_loads()
    yield from _displacements()
    yield from _waves()


def _geometry(
    balls: int,
    ball_m: float = 7.938e-3,
    pitch_m: float = 33.5e-3,
    angle: float = math.radians(12.0),
) -> BearingGeometry:
    """Return a bearing of steel, of which the sizes of a 6204 are the default."""
    return assemble(
        balls=balls,
        ball_diameter_m=ball_m,
        pitch_diameter_m=pitch_m,
        contact_angle=angle,
        conformity_inner=0.515,
        conformity_outer=0.525,
        contact_modulus=closed_forms.contact_modulus(*STEEL, *STEEL),
    )


def _speeds() -> Iterator[tuple[str, str, float, float]]:
    """Compare lines over the turns of the shaft with the printed ones."""
    for printed in SPEEDS:
        geometry = _geometry(
            balls=printed.balls,
            ball_m=printed.ball_inch * INCH_M,
            pitch_m=printed.pitch_inch * INCH_M,
            angle=0.0,
        )
        speeds = kinematics_of(geometry, "inner", 1.0)
        own = {
            "inner": speeds.ball_pass_inner_hz,
            "outer": speeds.ball_pass_outer_hz,
            "cage": speeds.cage_hz,
            "ball": 2 * speeds.ball_spin_hz,
        }
        for name, published in printed.lines.items():
            yield "line over turns", f"{printed.item}, {name}", published, own[name]


def _largest_loads() -> Iterator[tuple[str, str, float, float]]:
    """Compare the largest load of a ball, over the mean radial load, with sums over the balls."""
    for balls, cage, item in (
        (8, 0.0, "8 balls, one at the bottom"),
        (8, math.pi / 8, "8 balls, two beside the bottom"),
        (MANY_BALLS, 0.0, f"{MANY_BALLS} balls, Stribeck"),
    ):
        angles = cage + 2 * math.pi * np.arange(balls) / balls
        bearing = np.maximum(np.cos(angles), 0.0)
        exact = balls * bearing.max() ** 1.5 / float(np.sum(bearing**2.5))
        if balls == MANY_BALLS:
            exact = 4.37  # printed for many balls without clearance
        balance = static_balance(
            _geometry(balls, pitch_m=0.12, angle=0.0),
            LoadedRing(axial_load_n=0.0, radial_load_n=RADIAL_N),
            cage_angle=cage,
        )
        own = float(balance.ball_load_n.max()) * balls / RADIAL_N
        yield "largest load", item, exact, own


def _displacements() -> Iterator[tuple[str, str, float, float]]:
    """Compare displacements [um] at moving contact angles with those of another program."""
    for printed in DISPLACEMENTS:
        distance = groove_distance(11.5e-3, 0.52, 0.53)
        geometry = assemble(
            balls=7,
            ball_diameter_m=11.5e-3,
            pitch_diameter_m=43.5e-3,
            contact_angle=angle_of(1e-6 * printed.clearance_um, distance),
            conformity_inner=0.52,
            conformity_outer=0.53,
            contact_modulus=closed_forms.contact_modulus(*STEEL, *STEEL),
        )
        along_radius = _under(geometry, axial_n=0.0, radial_n=1000.0)
        along_axis = _under(geometry, axial_n=1000.0, radial_n=0.0)
        from_plane = distance * math.sin(geometry.contact_angle) + along_axis[2]
        item = f"clearance of {printed.clearance_um:g} um"
        yield "displacement", f"radial, {item}", printed.radial_um, 1e6 * float(along_radius[0])
        yield "displacement", f"axial, {item}", printed.axial_um, 1e6 * float(from_plane)


def _under(geometry: BearingGeometry, axial_n: float, radial_n: float) -> Array:
    """Return the displacement of the inner ring [m] under loads that turn the contact angles."""
    ring = LoadedRing(axial_load_n=axial_n, radial_load_n=radial_n, moving="inner", angle="moving")
    return static_balance(geometry, ring).displacement_m


def _waves() -> Iterator[tuple[str, str, float, float]]:
    """Compare the motion of the outer ring by waves with the linear theory, over the wave."""
    geometry = _geometry(balls=8)
    speeds = kinematics_of(geometry, "inner", SLOW_HZ)
    model = BearingModel(
        geometry=geometry,
        kinematics=speeds,
        ring_mass_kg=RING_KG,
        ball_mass_kg=BALL_KG,
        axial_load_n=AXIAL_N,
        radial_load_n=0.0,
    )
    angle = geometry.contact_angle
    radial = 1 / math.cos(angle)
    axial = 1 / math.sin(angle)
    inner = speeds.ball_pass_inner_hz
    outer = speeds.ball_pass_outer_hz
    cases: list[tuple[Ring, int, float, int, float]] = [
        ("inner", 8, inner, 2, axial),
        ("inner", 9, inner + SLOW_HZ, 0, radial),
        ("inner", 15, 2 * inner - SLOW_HZ, 0, radial),
        ("outer", 8, outer, 2, axial),
        ("outer", 9, outer, 0, radial),
        ("outer", 15, 2 * outer, 0, radial),
    ]
    for ring, order, line_hz, axis, expected in cases:
        smooth = smooth_tracks(geometry)
        if ring == "inner":
            tracks = with_waves(smooth, inner={order: WAVE_M})
        else:
            tracks = with_waves(smooth, outer={order: WAVE_M})
        moved = _line_amplitude(move_ring(model, tracks, RECORD_S), line_hz, axis)
        yield "motion over wave", f"{ring} ring, order {order}", expected, moved / WAVE_M
    for order in (2, 4):
        tracks = with_waves(smooth_tracks(geometry), balls={0: {order: WAVE_M}})
        motion = move_ring(model, tracks, RECORD_S)
        moved = _line_amplitude(motion, order * speeds.ball_spin_hz, 2)
        yield "motion over wave", f"one ball, order {order}", axial / 4, moved / WAVE_M


def _line_amplitude(motion: RingMotion, line_hz: float, axis: int) -> float:
    """Return the amplitude of a line along an axis [m], by least squares."""
    phase = 2 * np.pi * line_hz * motion.time_s
    waves: Array = np.stack((np.cos(phase), np.sin(phase)), axis=1)
    amplitudes = np.linalg.lstsq(waves, motion.displacement_m[:, axis], rcond=None)[0]
    return float(np.hypot(*amplitudes))
