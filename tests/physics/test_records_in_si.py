"""Sections of a scene in mm, um and GPa are records of physics in SI."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rolling.contact import closed_forms
from rolling.contact.track import Motion, Track, Travel
from rolling.in_si.physics_of_scene import (
    bodies_of,
    circumference_of,
    listener_of,
    smooth_contact_of,
    transducers_of,
)
from rolling.in_si.plate_file import steps_of
from rolling.scene.laws import Roughness, SelfAffineLaw, SurfaceFault
from rolling.scene.scene import Scene
from rolling.scene.surfaces import GradedBall, HeightFile, Instrument, SmoothBall
from rolling.surface.ball_form import BallForm
from rolling.surface.height_law import CorrelationLaw, SelfAffineSpectrum
from rolling.surface.instrument import InstrumentLimits
from rolling.surface.preparation import PreparationSteps
from rolling.surface.single_faults import SingleFault


def scene(**plate: object) -> Scene:
    values = {"youngs_modulus_gpa": 210, "poissons_ratio": 0.3, "density_kg_m3": 7850}
    return Scene.from_dict(
        {
            "name": "records",
            "sphere": {"radius_mm": 5, "radius_across_mm": 8, "density_kg_m3": 7800},
            "plate": values | plate,
            "surface": {"kind": "smooth", "spacing_um": 4, "width_um": 512},
            "rolling": {"load_n": 20, "speed_m_s": 0.1, "duration_s": 0.01, "drop_mm": 2},
            "dynamics": {},
        }
    )


def test_bodies_have_the_values_of_their_sections() -> None:
    edges = {"length_mm": 300, "width_mm": 200, "thickness_mm": 10, "loss_factor": 0.02}
    bodies = bodies_of(scene(**edges, contact_mm=[100, 90], contact_loss_factor=0.01))
    assert bodies.contact == smooth_contact_of(scene())
    assert (bodies.load_n, bodies.contact.radius_m, bodies.contact.radius_across_m) == (
        20.0,
        pytest.approx(5e-3),
        pytest.approx(8e-3),
    )
    assert bodies.contact.modulus_pa == pytest.approx(210e9 / (1 - 0.3**2))
    assert bodies.mass_kg == pytest.approx(7800 * 4 / 3 * math.pi * 5e-3**3)
    assert bodies.drop_height_m == pytest.approx(2e-3) and bodies.falls
    assert bodies.contact_loss_factor == 0.01
    plate = bodies.plate
    assert plate.sides_m == pytest.approx((0.3, 0.2)) and plate.thickness_m == pytest.approx(0.01)
    assert plate.contact_ends_m == (pytest.approx((0.1, 0.09)),) and not plate.has_path
    assert plate.with_edges is not None and plate.with_edges.length_m == plate.sides_m[0]
    assert circumference_of(scene()) is None


def test_receivers_stand_where_their_sections_say() -> None:
    """Places count from a corner of a plate with edges, and from the contact on an infinite one."""
    edges = {"length_mm": 300, "width_mm": 200, "thickness_mm": 10, "loss_factor": 0.02}
    edged = scene(**edges, contact_mm=[100, 90])
    listed = [
        {"of": "plate", "quantity": "velocity"},
        {"of": "plate", "quantity": "velocity", "x_mm": 30, "y_mm": 40},
        {"of": "ball", "quantity": "acceleration"},
    ]
    placed = edged.with_(
        {"sound.listener_mm": [[10, 20, 300]], "sound.ball": False, "sound.channels": listed}
    )
    listener = listener_of(placed)
    assert listener.places_m == (pytest.approx((0.01, 0.02, 0.3)),) and not listener.hears_ball
    on_plate, beside, on_ball = transducers_of(placed)
    assert on_plate.place_m == pytest.approx((0.1, 0.09))
    assert beside.place_m == pytest.approx((0.03, 0.04)) and on_ball.place_m is None
    (above,) = listener_of(edged).places_m
    assert above == pytest.approx((0.1, 0.09, edged.sound.distance_m))
    infinite = scene(thickness_mm=10).with_({"sound.channels": listed[:1]})
    assert listener_of(infinite).places_m == ()
    assert [x.place_m for x in transducers_of(infinite)] == [(0.0, 0.0)]


def test_a_plate_bends_with_a_thickness_and_a_density_alone() -> None:
    assert bodies_of(scene(thickness_mm=10)).plate.bending is not None
    assert bodies_of(scene()).plate.bending is None
    half_space = bodies_of(scene()).plate.ground
    speed = math.sqrt(210e9 * 0.7 / (1.3 * 0.4) / 7850)
    assert vars(half_space) == pytest.approx(
        dict(zip(vars(half_space), (7850, speed), strict=True))
    )


@pytest.mark.law("Smooth contact: stiffness and approach are those of the equivalent sphere.")
def test_a_smooth_contact_has_the_semi_axes_and_the_stiffness_of_hertz() -> None:
    """Pi a b times the maximum pressure is 1.5 times the load, and dW / d(approach) is 2 E* a."""
    contact = smooth_contact_of(scene())
    for load in (None, 7.0):
        along, across = contact.semi_axes_m(load)
        pressure = contact.maximum_pressure_pa(load)
        assert math.pi * along * across * pressure == pytest.approx(1.5 * (load or 20.0))
        assert across > along  # the radius across is larger
    step = 1e-4
    rise = contact.approach_m(20 * (1 + step)) - contact.approach_m(20 * (1 - step))
    assert 2 * step * 20 / rise == pytest.approx(contact.stiffness_n_m, rel=1e-6)
    equivalent = closed_forms.hertz_ellipse(5e-3, 8e-3)[0]
    assert contact.equivalent_radius_m == pytest.approx(equivalent)


def test_a_travel_ends_with_its_track_or_at_rest() -> None:
    track = Track(
        n_along=1000,
        n_across=64,
        steps=500,
        step=2e-6,
        spacing=1e-6,
        closed=True,
        lap_steps=500,
        plate_nodes=1000,
    )
    steady = Travel(motion=Motion.of(0.1), track=track)
    assert steady.duration_s == pytest.approx(1e-3 / 0.1) and steady.is_constant
    braking = Travel(motion=Motion.rolling_out(0.1, 10.0), track=track)
    assert braking.motion.final_distance == pytest.approx(5e-4)  # before the end of the track
    assert braking.duration_s == pytest.approx(0.01) and not braking.is_constant
    assert braking.fastest_m_s == pytest.approx(0.1)


def test_laws_faults_and_forms_of_surfaces_are_in_metres() -> None:
    law = Roughness(
        autocorrelation="exponential_10pct",
        roughness_ra_um=0.1,
        correlation_length_um=10,
        correlation_length_across_um=40,
        lay_deg=90,
        skewness=-1,
        kurtosis=5,
        seed=1,
    )
    assert law.in_si == CorrelationLaw(
        lengths_m=(40 * 1e-6, 10 * 1e-6),  # a lay across the track exchanges both
        decay=2.3,
        exponent=1,
        ra_m=0.1 * 1e-6,
        moments=(-1.0, 5.0),
    )
    assert not law.in_si.is_gaussian
    affine = SelfAffineLaw(hurst=0.8, rolloff_um=40, shortest_um=4, rdq=0.1, seed=1)
    assert affine.in_si == SelfAffineSpectrum(
        hurst=0.8, rolloff_rad_m=2e6 * math.pi / 40, end_ratio=10.0, rq_m=affine.rq_m, rdq=0.1
    )
    scratch = SurfaceFault(
        kind="scratch", at_mm=[1, -2], size_um=20, depth_um=3, length_um=500, angle_deg=30
    )
    assert scratch.in_si == SingleFault(
        kind="scratch",
        size_m=20 * 1e-6,
        depth_m=3 * 1e-6,
        at_m=(1 * 1e-3, -2 * 1e-3),
        length_m=500 * 1e-6,
        angle_rad=math.radians(30),
    )
    pits = SurfaceFault(kind="pit", count=3, seed=5, size_um=20, depth_um=3)
    assert (pits.in_si.at_m, pits.in_si.count, pits.in_si.seed) == (None, 3, 5)
    graded = GradedBall(grade="G10", seed=7, waviness={3: 0.05})
    assert graded.form == BallForm(deviation_m=0.25 * 1e-6, seed=7, waves_m=((3, 0.05 * 1e-6),))
    assert graded.has_form and not SmoothBall().has_form


def test_an_instrument_and_the_steps_of_a_preparation_are_in_metres() -> None:
    instrument = Instrument(tip_radius_um=2, sampling_um=0.5, noise_nm=3)
    limits = InstrumentLimits(tip_radius_m=2 * 1e-6, sampling_m=0.5 * 1e-6, noise_m=3 * 1e-9)
    assert instrument.in_si == limits
    assert Instrument(noise_nm=3).in_si == InstrumentLimits(noise_m=3 * 1e-9)
    scan = HeightFile(path="scan.sdf", unmeasured="fill", outliers=6, s_filter_um=5, width_um=64)
    assert steps_of(scan) == PreparationSteps(
        outliers=6.0,
        fills_unmeasured=True,
        s_filter_m=5 * 1e-6,
        closing="blend",
        is_profile=True,
    )


def test_the_contact_goes_to_and_fro_on_its_path() -> None:
    """The ends are 50 mm apart: after 125 mm the contact is in the middle, on its way back."""
    edges = {"length_mm": 300, "width_mm": 200, "thickness_mm": 10, "loss_factor": 0.02}
    path = {"contact_mm": [10, 10], "contact_path": "to-and-fro", "contact_end_mm": [40, 50]}
    plate = bodies_of(scene(**edges, **path)).plate
    places = plate.contact_points(np.array([0.0, 0.05, 0.125]))
    assert places == pytest.approx(1e-3 * np.array([[10, 10], [40, 50], [25, 30]]))
    assert plate.points_between_ends(3) == pytest.approx(places[[0, 2, 1]])
