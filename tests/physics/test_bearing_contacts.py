"""Rough contacts of a bearing: linear response, marches, continued turns and faults."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import rolling
from acoustics.arrays import Array
from acoustics.ring_velocity import velocity_bands
from rolling.bearing import waves
from rolling.bearing.band_uncertainty import BandUncertainty
from rolling.bearing.ring_motion import move_ring
from rolling.bearing.static_load import LoadedRing
from rolling.bearing_kind.band_gain import gain_uncertainty_db
from rolling.bearing_kind.contact_doubts import coarse_nodes_db, contact_doubts
from rolling.bearing_kind.contact_gain import GROUPS, contact_gain
from rolling.bearing_kind.contact_marches import march_contacts
from rolling.bearing_kind.contact_plan import contact_plan, plan_contacts
from rolling.bearing_kind.contact_uncertainty import DIP_EXPONENT, faults_at_one_load_db
from rolling.bearing_kind.faults import FaultStretch, fault_stretches
from rolling.bearing_kind.joined_tracks import bearing_tracks, rough_rows
from rolling.bearing_kind.rough_contacts import (
    ContactKind,
    MarchNumbers,
    RoughContact,
    contact_loads,
    march_numbers,
    rough_contact,
)
from rolling.bearing_kind.specimen_turn import linear_covariance, rough_body
from rolling.bearing_kind.turns import continued_turn
from rolling.marches.piece import contact_identity
from rolling.run.march_files import Marches
from rolling.scene.laws import Roughness, SurfaceFault
from rolling.scene.scene import Scene
from rolling.scene.surfaces import BallHeightFile, GradedBall, SmoothBall
from tests.support.bearings import STEEL, bearing

INNER = bearing().inner
LOAD = 10.0  # [N] on a ball
SPEED = 1.5  # [m/s]
BODY: dict[str, float | str] = {"youngs_modulus_gpa": 210.0, "poissons_ratio": 0.3}
FINE = Roughness(
    roughness_ra_um=0.002, correlation_length_um=40, correlation_length_across_um=20, seed=3
)


def marched(scenes: Sequence[Scene]) -> Marches:
    """Return the marches of scenes in this process."""
    marches = march_contacts(scenes, name="contacts", workers=1, shown=False)
    return marches


def kind_with(numbers: MarchNumbers) -> ContactKind:
    """Return the inner contact of a 6204 with a grid."""
    return ContactKind(
        name="inner", contact=INNER, numbers=numbers, loads_n=(LOAD,), speed_m_s=SPEED, body=BODY
    )


def contact_with(law: Roughness, window_mm: float = 1.0) -> RoughContact:
    """Return the inner contact of a 6204 over a rough surface."""
    numbers = march_numbers(
        INNER, [law], [LOAD], speed_m_s=SPEED, turn_m=0.08, window_mm=window_mm, spacing_um=5
    )
    return rough_contact(kind_with(numbers), law)


# ---- linear response


@pytest.mark.law("Contacts of bearings: a long wave of a raceway passes whole, with its sign.")
def test_a_long_wave_passes_whole() -> None:
    angle = 2 * np.pi * np.arange(4096) / 4096
    height = 1e-7 * np.cos(9 * angle)
    approach = waves.approach_of_profile(height, INNER.radius_m, INNER, [LOAD, 2 * LOAD])
    assert np.abs(approach + height).max() < 1e-3 * 1e-7


@pytest.mark.law("Contacts of bearings: a marched wave has the response sin(k a)/(k a).")
@pytest.mark.parametrize("length_um", [600, 200, 100])
def test_a_marched_wave_is_averaged_over_the_contact(length_um: int) -> None:
    spacing = 5e-6
    nodes = 120  # whole waves
    height = 1e-9 * np.cos(2 * np.pi * np.arange(nodes) * spacing / (length_um * 1e-6))
    surface = np.repeat(height[:, None], 180, axis=1)
    contact = rolling.RollingContact(
        heights=surface,
        spacing=spacing,
        radius=INNER.radius_along_m,
        radius_across=INNER.radius_across_m,
        contact_modulus=STEEL,
        hardness=np.inf,
        load=LOAD,
        step=2 * spacing,
        start=0.0,
        tolerance=1e-6,
    )
    half_space = rolling.HalfSpace(spacing, STEEL)
    approach = np.array([s.approach for s in rolling.march(contact, 0, nodes // 2 - 1, half_space)])
    linear = waves.approach_of_heights(surface, (spacing, spacing), INNER, [LOAD])[0, ::2]
    change = approach - approach.mean()
    gain = float(change @ linear / (linear @ linear))
    assert gain == pytest.approx(1.0, abs=0.03)  # a node is a sixth of the semi-axis
    phase = 2 * np.pi / (length_um * 1e-6) * waves.semi_axes(INNER, LOAD).along
    assert np.abs(linear).max() == pytest.approx(1e-9 * np.sin(phase) / phase, rel=0.01)


@pytest.mark.law("Contacts of bearings: a fine roughness is marched as its linear response.")
def test_a_fine_roughness_is_linear() -> None:
    contact = contact_with(FINE)
    rows = rough_rows(contact, marched([contact.scene]))
    linear = contact.linear_rows([LOAD])
    error = np.std(rows - linear) / np.std(rows)
    assert error < 0.1  # -20 dB; 5 nm of deflection at the edge are not closed


@pytest.mark.law("Contacts of bearings: twice the roughness of a closed contact is 6.0 dB more.")
def test_doubling_a_fine_roughness_doubles_the_track() -> None:
    single = contact_with(FINE)
    double = contact_with(FINE.model_copy(update={"roughness_ra_um": 0.004}))
    marches = marched([single.scene, double.scene])
    ratio = np.std(rough_rows(double, marches)) / np.std(rough_rows(single, marches))
    assert 20 * np.log10(ratio) == pytest.approx(6.02, abs=0.2)


# ---- further specimens


def of_specimen(contact: RoughContact, number: int) -> RoughContact:
    """Return a contact with other heights of equal statistics."""
    return replace(contact, scene=contact.scene.with_({"surface.seed": 1000 + number}))


def lines_of(rows: Array) -> NDArray[np.complex128]:
    """Return the waves 1, 2, ... of rows along a track."""
    return np.fft.rfft(rows, axis=1)[:, 1:]


@pytest.mark.law("Contacts of bearings: heights of another specimen act as if they were marched.")
def test_another_specimen_acts_as_its_own_march_would() -> None:
    """Within a fraction of the 3 dB by which octaves of both windows differ."""
    contact = contact_with(FINE, window_mm=2.0)
    other = of_specimen(contact, 3)
    marches = marched([contact.scene, other.scene])
    gain = contact_gain(contact, rough_rows(contact, marches))
    linear = lines_of(other.own_linear_rows)
    lines = gain.applied(linear, np.arange(1, linear.shape[1] + 1), seed=3)
    (specimen,) = np.fft.irfft(np.pad(lines, ((0, 0), (1, 0))), contact.steps, axis=1)
    (own,) = rough_rows(other, marches)
    heard = octaves(specimen)[-3:]  # waves longer than the contact
    assert heard == pytest.approx(octaves(own)[-3:], abs=0.5)
    assert np.abs(octaves(rough_rows(contact, marches)[0])[-3:] - heard).max() > 1


@pytest.mark.law(
    "Contacts of bearings: the law of heights gives the spectrum of a linear response."
)
@pytest.mark.parametrize("autocorrelation", ["gaussian", "exponential"])
def test_the_covariance_of_a_law_is_that_of_its_surfaces(autocorrelation: str) -> None:
    """Within 0.5 dB over sixty surfaces, at two loads, for a law that is turned as well."""
    law = FINE.model_copy(update={"autocorrelation": autocorrelation, "lay_deg": 30.0})
    contact = replace(contact_with(law), loads_n=(LOAD / 2, LOAD))
    found = np.zeros((2, 2))
    expected = linear_covariance([contact])[:15].sum(axis=0)
    for number in range(60):
        lines = lines_of(of_specimen(contact, number).own_linear_rows)[:, :15]
        found += (lines @ np.conj(lines.T)).real / 60
    assert 10 * np.log10(found / expected) == pytest.approx(np.zeros((2, 2)), abs=0.5)


def partly_open(contact: RoughContact, number: int) -> Array:
    """Return rows as of a march: 0.97 of the linear response, and a rest that it does not explain.

    The rest has 7 % of the power of the linear response in each wave, like that of the contact of a
    6204 at Ra 0.04 um.
    """
    rest = of_specimen(contact, 1000 + number).own_linear_rows
    return np.asarray(0.97 * contact.own_linear_rows + np.sqrt(0.07) * rest)


GAIN = 10 * np.log10(0.97**2 + 0.07)  # of these rows [dB]


@pytest.mark.law("Contacts of bearings: the gain of a march holds for its few long waves, too.")
def test_the_gain_of_few_waves_does_not_follow_their_luck() -> None:
    """Over six marches it is right within 0.5 dB rms, where ratios of single waves are 3 dB off.

    The long waves are three, as a band may have. The short ones lie where the spectrum is steep.
    """
    few = {"long": slice(0, 3), "short": slice(37, 49)}
    errors: dict[str, list[float]] = {"long": [], "short": []}
    for number in range(6):
        contact = of_specimen(contact_with(FINE, window_mm=4.0), number)
        body = rough_body([contact], [partly_open(contact, number)])
        heard = np.zeros(len(body.covariance))
        for seed in range(60):
            row = body.turn(contact.steps, seed)
            heard[: contact.steps // 2] += np.abs(lines_of(row)[0]) ** 2 / 60
        for name, some in few.items():
            ratio = heard[some].sum() / body.covariance[some, 0, 0].sum()
            errors[name].append(10 * np.log10(ratio) - GAIN)
    for of_waves in errors.values():
        assert np.sqrt(np.mean(np.square(of_waves))) < 0.5
        assert abs(np.mean(of_waves)) < 0.3


@pytest.mark.law("Contacts of bearings: the stated scatter of a gain is that over other marches.")
def test_the_scatter_of_a_gain_is_stated() -> None:
    errors = []
    stated = []
    for number in range(30):
        contact = of_specimen(contact_with(FINE, window_mm=4.0), number)
        gain = contact_gain(contact, partly_open(contact, number))
        errors.append(10 * np.log10(gain.power_gain()[0, 0]) - GAIN)
        parts = np.array([10 * np.log10(gain.power_gain(group)[0, 0]) for group in range(GROUPS)])
        stated.append(gain_uncertainty_db(np.zeros(GROUPS), parts))
    assert 0.7 < np.sqrt(np.mean(np.square(errors)) / np.mean(np.square(stated))) < 1.4


def test_twice_the_heights_of_a_linear_contact_are_twice_the_turn() -> None:
    """Specimens of equal seed have equal luck, so that a difference does not scatter."""
    turns = []
    for ra_um in (0.002, 0.004):
        contact = contact_with(FINE.model_copy(update={"roughness_ra_um": ra_um}))
        body = rough_body([contact], [contact.own_linear_rows])
        turns.append(body.turn(3000, seed=5))
    assert turns[1] == pytest.approx(2 * turns[0], rel=1e-6, abs=1e-15)
    assert turns[0].mean() == pytest.approx(0.0, abs=1e-15)


# ---- continued turns


def octaves(row: Array) -> Array:
    """Return the level of each octave of waves around a turn [dB]."""
    power = np.abs(np.fft.rfft(row) / len(row)) ** 2
    edges = len(row) // 2 >> np.arange(6)
    return np.array([10 * np.log10(power[low:high].sum()) for high, low in pairwise(edges)])


@pytest.mark.law("Contacts of bearings: a continued turn has the spectrum of what was marched.")
def test_a_continued_turn_has_the_spectrum_of_the_rows() -> None:
    random = np.random.default_rng(1)
    lines = np.fft.rfft(random.standard_normal((2, 2000)))
    lines[1] = 0.5 * lines[0]  # coherent rows
    rows = np.fft.irfft(lines / (1 + np.arange(lines.shape[1]) / 50), 2000)
    turn = continued_turn(rows, 9000, seed=2, keep_rows=False)
    difference = octaves(turn[0]) - octaves(rows[0])
    assert np.abs(difference).max() < 1.0  # the scatter of the 16 lines of the lowest octave
    assert np.allclose(turn[1], 0.5 * turn[0], atol=1e-9 * np.std(turn[0]))
    steps = np.abs(np.diff(turn[0], append=turn[0, 0]))
    assert steps[-1] < 5 * np.std(steps)  # it closes
    other = continued_turn(rows, 9000, seed=3, keep_rows=False)
    assert abs(np.corrcoef(turn[0], other[0])[0, 1]) < 0.2


def test_a_turn_that_is_marched_whole_stays_as_it_is() -> None:
    rows = np.random.default_rng(1).standard_normal((1, 400))
    turn = continued_turn(rows, 400, seed=2, keep_rows=True)
    assert np.allclose(turn, rows - rows.mean())


# ---- faults


def stretch_over(fault: SurfaceFault) -> FaultStretch:
    """Return the stretch of the inner contact around a fault of a smooth raceway."""
    numbers = march_numbers(
        INNER, [], [LOAD], speed_m_s=SPEED, turn_m=0.08, window_mm=1, spacing_um=8
    )
    (stretch,) = fault_stretches(
        kind_with(replace(numbers, step_nodes=4.0)), [fault], radius_m=INNER.radius_m, law=None
    )
    return stretch


def change_over(fault: SurfaceFault) -> Array:
    """Return the change of the approach over a fault [m]."""
    stretch = stretch_over(fault)
    (pair,) = stretch.scenes.values()
    over, beside = marched([pair[0]]), marched([pair[1]])
    (with_fault,) = over.values()
    (without,) = beside.values()
    return with_fault.approach_m - without.approach_m


@pytest.mark.law("Contacts of bearings: a fault wider than the contact is followed to its bottom.")
def test_a_wide_groove_is_followed_to_its_bottom() -> None:
    groove = SurfaceFault(kind="groove", at_mm=[10, 0], size_um=2000, depth_um=0.5)
    change = change_over(groove)
    assert change.max() == pytest.approx(0.5e-6, rel=0.03)
    assert change.argmax() == len(change) // 2
    assert abs(change[0]) < 1e-11


@pytest.mark.law("Contacts of bearings: a fault narrower than the contact is bridged.")
def test_a_narrow_pit_is_bridged() -> None:
    pit = SurfaceFault(kind="pit", at_mm=[10, 0], size_um=40, depth_um=0.5)
    assert 0 < change_over(pit).max() < 0.02 * 0.5e-6  # a part of its area over the ellipse's


def test_a_rim_lifts_the_ball_that_its_pit_lets_down() -> None:
    """It is lifted by less than the height of the rim, and by nothing if that is zero."""
    pit = {"kind": "pit", "at_mm": [0.0, 0.0], "size_um": 80, "depth_um": 10}
    bare = change_over(SurfaceFault(**pit))
    rimmed = change_over(SurfaceFault(**pit, rim_height_um=1, rim_width_um=48))
    assert bare.min() > -1e-11
    assert -1e-6 < rimmed.min() < -20e-9
    level = change_over(SurfaceFault(**pit, rim_height_um=0, rim_width_um=80))
    assert np.array_equal(level, bare)


def test_a_deep_pit_needs_no_window_for_its_bottom(monkeypatch: pytest.MonkeyPatch) -> None:
    """A ball sinks no deeper than its edges let it, and a window three times as deep holds that."""
    pit = SurfaceFault(kind="pit", at_mm=[0.0, 0.0], size_um=120, depth_um=40)
    small = stretch_over(pit).with_fault
    narrow = change_over(pit)
    monkeypatch.setattr("rolling.bearing_kind.faults.SINKING", 12.0)
    large = stretch_over(pit).with_fault
    wide = change_over(pit)
    assert large.surface.width_um > 1.3 * small.surface.width_um
    assert narrow.max() == pytest.approx(wide.max(), rel=0.01)


def test_what_a_fault_at_one_load_leaves_is_the_power_of_its_dip_over_the_loads() -> None:
    """Under an axial load all balls have one load, which the marches have not in the middle."""
    pit = {"kind": "pit", "at_mm": [2, 0], "size_um": 300, "depth_um": 20}
    values: dict[str, Any] = {
        "name": "pitted",
        "bearing": {
            "named": "6204",
            "speed_rpm": 1800,
            "axial_load_n": 70,
            "surfaces": {"inner": {"kind": "smooth", "faults": [pit]}},
        },
    }
    scene = rolling.BearingScene.from_dict(values)
    plan = contact_plan(scene)
    load = scene.model.balances()[0].ball_load_n[0]
    middle = plan.faults[0].with_fault.load
    expected_db = abs(20 * math.log10((load / middle) ** DIP_EXPONENT))
    assert faults_at_one_load_db(plan, scene.model) == pytest.approx(expected_db)
    marched = [contact_identity(contact) for stage in plan.stages for contact in stage]
    assert plan.has_faults_at_all_loads(marched)
    assert not plan.has_faults_at_all_loads(marched[:-1])
    assert plan.without_faults().has_faults_at_all_loads([])


def test_a_fault_stands_at_its_place_in_the_tracks() -> None:
    """The fault of a ball stands in both tracks of that ball alone."""
    geometry = bearing()
    groove = SurfaceFault(kind="groove", at_mm=[10, 0], size_um=400, depth_um=0.5)
    plan = plan_contacts(
        geometry,
        {"balls": SmoothBall(faults=[groove]), "inner": SmoothBall(faults=[groove]), "outer": None},
        contact_loads(
            geometry,
            LoadedRing(axial_load_n=LOAD * 8 * np.sin(geometry.contact_angle), radial_load_n=0.0),
        ),
        speed_m_s=SPEED,
        body=BODY,
        numerics=rolling.BearingNumerics(window_mm=1, spacing_um=10),
        fault_ball=2,
    )
    tracks = bearing_tracks(plan, marched(plan.stages[0] + plan.stages[1]))
    track = tracks.inner
    angle = track.approach_m[1].argmax() / track.points * 2 * np.pi
    assert angle * INNER.radius_m == pytest.approx(10e-3, abs=30e-6)
    for ball in range(8):
        for on_ring in (tracks.balls_on_inner[ball], tracks.balls_on_outer[ball]):
            assert (on_ring.approach_m.max() > 0.1e-6) == (ball == 2)
    assert not tracks.outer.approach_m.any()


@pytest.mark.parametrize("order", [3000, 4100])
def test_a_wave_of_a_high_order_is_no_wave_of_a_low_order(order: int) -> None:
    """A smooth raceway has points enough for its shortest wave."""
    plan = plan_contacts(
        bearing(),
        {"balls": None, "inner": SmoothBall(waviness={order: 0.05}), "outer": None},
        contact_loads(bearing(), LoadedRing(axial_load_n=LOAD, radial_load_n=0.0)),
        speed_m_s=SPEED,
        body=BODY,
        numerics=rolling.BearingNumerics(window_mm=1),
    )
    heights = bearing_tracks(plan).inner.approach_m[0]
    spectrum = np.abs(np.fft.rfft(heights))
    assert spectrum.argmax() == order
    assert np.delete(spectrum, order).max() < 1e-6 * spectrum[order]


# ---- plan


def test_the_scene_of_a_bearing_names_its_contacts() -> None:
    """A smooth raceway needs no march, and equal bearings have equal tracks."""
    scene = rolling.read_scene("bearing-6204").with_({"bearing.surfaces.outer": None})
    plan = contact_plan(scene)
    assert list(plan.rough) == ["inner", "balls-on-inner", "balls-on-outer"]
    angle = scene.model.rolling_angle
    assert plan.loads_n[1] == pytest.approx(70 / (8 * np.sin(angle)), rel=1e-3)


def test_other_specimens_have_other_heights_of_equal_level() -> None:
    geometry = bearing(balls=3)
    ball = GradedBall(grade="G10", seed=1)
    plan = plan_contacts(
        geometry,
        {"balls": ball, "inner": None, "outer": None},
        contact_loads(geometry, LoadedRing(axial_load_n=25.0, radial_load_n=0.0)),
        speed_m_s=SPEED,
        body=BODY,
        numerics=rolling.BearingNumerics(window_mm=4, spacing_um=10),
    )
    tracks = [bearing_tracks(plan, draw=draw).balls_on_inner for draw in (0, 1, 0)]
    high = [np.diff(track.approach_m[1]) for specimen in tracks for track in specimen]
    assert np.array_equal(high[0], high[6])
    correlations = np.corrcoef(high[:6])[np.triu_indices(6, 1)]
    assert np.abs(correlations).max() < 0.2  # balls of both specimens differ
    levels = 20 * np.log10(np.std(high, axis=1))
    assert np.ptp(levels) < 1.5


@pytest.mark.law("Contacts of bearings: a measured turn stands at its angles, without order 1.")
def test_a_measured_turn_is_marched_whole(tmp_path: Path) -> None:
    radius = bearing(ball_mm=3).ball_radius_m
    nodes = round(2 * np.pi * radius / 10e-6)
    angle = 2 * np.pi * np.arange(nodes) / nodes
    np.save(tmp_path / "turn.npy", 1e-8 * np.cos(6 * angle + 1) + 1e-7 * np.cos(angle))
    plan = plan_contacts(
        bearing(ball_mm=3),
        {
            "balls": BallHeightFile(path="turn.npy", spacing_um=10),
            "inner": None,
            "outer": None,
        },
        contact_loads(bearing(ball_mm=3), LoadedRing(axial_load_n=5.0, radial_load_n=0.0)),
        speed_m_s=SPEED,
        body=BODY,
        numerics=rolling.BearingNumerics(window_mm=1),
        folder=tmp_path,
    )
    tracks = bearing_tracks(plan, marched(plan.stages[0] + plan.stages[1]))
    for track in (tracks.balls_on_inner[0], tracks.balls_on_outer[0]):
        line = track.approach_m[1]
        waves_of_line = 2 * np.fft.rfft(line)[:12] / len(line)
        assert abs(waves_of_line[6]) == pytest.approx(1e-8, rel=0.01)
        assert np.angle(-waves_of_line[6]) == pytest.approx(1.0, abs=0.05)
        assert np.abs(np.delete(waves_of_line, 6)).max() < 0.03 * 1e-8


def test_a_rule_knows_when_nodes_are_too_far_apart() -> None:
    """The sum over nodes of a Gaussian law is its integral up to a spacing of its length."""
    law = Roughness(roughness_ra_um=0.1, correlation_length_um=10, seed=1)
    assert coarse_nodes_db(law, 4.0) == pytest.approx(0.0, abs=1e-6)
    assert coarse_nodes_db(law, 20.0) == pytest.approx(20 * np.log10(1.169), abs=0.01)


def test_a_bridged_wave_is_a_doubt() -> None:
    """A raceway of 0.5 um and 200 um waves is bridged at 20 N, and one of 1,000 um is not."""
    found = []
    for order in (404, 81):
        scene = rolling.read_scene("bearing-6204").with_(
            {"bearing.surfaces.inner": {"kind": "smooth", "waviness": {order: 0.5}}}
        )
        doubts = contact_doubts(contact_plan(scene), {}, np.inf, BandUncertainty())
        found.append([doubt.decibels for doubt in doubts if doubt.key == "steep_waves"])
    assert found[0][0] > 1.0 and not found[1]


def test_a_short_window_holds_the_contact() -> None:
    numbers = march_numbers(INNER, [FINE], [500.0], speed_m_s=SPEED, turn_m=0.08, window_mm=0.01)
    axes = waves.semi_axes(INNER, 500.0)
    assert numbers.distance_mm > 2 * 2e3 * axes.along
    assert numbers.width_um > 2e6 * axes.across


@pytest.mark.slow
@pytest.mark.law("Bearings: twice the roughness of the balls is 6 dB more in the high band.")
def test_twice_the_roughness_of_balls_is_6_db_in_the_high_band() -> None:
    """The contacts of the smaller roughness are closed. The heights are the same, times two."""
    levels = []
    for ra_um in (0.01, 0.02):
        balls = {
            "kind": "gaussian",
            "roughness_ra_um": ra_um,
            "correlation_length_um": 20,
            "seed": 1,
        }
        scene = rolling.read_scene("bearing-6204").with_(
            {
                "bearing.surfaces": {"balls": balls},
                "numerics.window_mm": 4,
                "numerics.spacing_um": 8,
            }
        )
        plan = contact_plan(scene)
        motion = move_ring(
            scene.model, bearing_tracks(plan, marched(plan.stages[0] + plan.stages[1])), 0.25
        )
        bands = velocity_bands(motion.velocity_m_s[:, 0], motion.rate_hz)
        levels.append(20 * np.log10(bands.rms_m_s["high"]))
    assert levels[1] - levels[0] == pytest.approx(6.02, abs=0.3)  # 0.1 to 0.2 dB of open contact


# ---- loads


def test_loads_reach_around_those_of_the_balls() -> None:
    geometry = bearing()
    axial = contact_loads(geometry, LoadedRing(axial_load_n=70, radial_load_n=0))
    load = 70 / (8 * np.sin(geometry.contact_angle))
    assert axial == pytest.approx([load / 2, load, 2 * load], rel=1e-3)
    zone = contact_loads(bearing(angle_deg=0), LoadedRing(axial_load_n=0, radial_load_n=200))
    assert zone[-1] == pytest.approx(2 * 4.35 * 200 / 8, rel=0.01)
    assert max(np.divide(zone[1:], zone[:-1])) <= 2.0 + 1e-3
