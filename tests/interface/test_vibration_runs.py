"""Runs with dynamics: their levels, numbers and doubts, and other bodies over the same marches."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from checked import checked
from finished import VIBRATING, WITHOUT_DYNAMICS, doubt_lines, heard_again, marched, run_of
from scipy import ndimage

from acoustics.bands import BAND_NAMES
from acoustics.level import a_weighted, level_db
from acoustics.radiation import P_REF_PA
from rolling.check import comb_spread, error_cost, force_estimate
from rolling.dynamics.motion_of_ball import motion_of_ball
from rolling.figures.catalogue import single_picture
from rolling.in_si.physics_of_scene import bodies_of
from rolling.kinds.run_folder import RunFolder
from rolling.marches.marched_law import force_law
from rolling.numbers.ball_numbers import RunNumbers
from rolling.numbers.quantity import PART_WORDS, joined
from rolling.results.run_errors import LINEAR
from rolling.results.run_result import Run, make_run, read_run, write_run
from rolling.scene.file import loads
from rolling.sound.vibration_sound import with_impacts


@pytest.fixture(scope="module")
def steady() -> Run:
    return marched(VIBRATING)


@pytest.fixture(scope="module")
def fast(steady: Run) -> Run:
    return heard_again(steady, steady.scene.with_({"rolling.speed_m_s": 1}))


# Parts of ± that are known beside the sound of a vibration itself.
OF_ERRORS = ("force_law", "grid", "solver", "subgrid", "band", "instrument")


def test_the_parts_of_a_vibration_are_its_whole_uncertainty(steady: Run, fast: Run) -> None:
    for run in (steady, fast):
        own = joined(run.vibration.parts, left_out=OF_ERRORS)
        assert own == pytest.approx(run.sound.uncertainty.laeq_db, rel=1e-12)
        assert run.vibration.uncertainty >= own
        bands = run.numbers.bands.vibration
        for k, spread in enumerate(bands.uncertainty):
            if spread is not None:
                parts = [part[k] for part in bands.parts.values()]
                assert spread == pytest.approx(math.hypot(*parts), rel=1e-9)


def test_impacts_are_a_part_of_their_own(fast: Run) -> None:
    """A record with impacts scatters more than noise of its spectrum: all levels by one factor."""
    vibration = fast.vibration_sound
    assert with_impacts(vibration, 0.5 * vibration.uncertainty.laeq_db) is vibration
    scatter = 2.5 * vibration.uncertainty.laeq_db
    wide = with_impacts(vibration, scatter)
    assert joined(wide.parts) == pytest.approx(scatter, rel=1e-12)
    assert wide.uncertainty.laeq_db == pytest.approx(scatter, rel=1e-12)
    of_band = joined({name: float(part[20]) for name, part in wide.band_parts.items()})
    assert of_band == pytest.approx(wide.uncertainty.third_octave_db[BAND_NAMES[20]], rel=1e-9)


def test_levels_rise_with_speed_and_have_no_steady_level(steady: Run, fast: Run) -> None:
    # Six to nine decibels for three times the speed in practice, 2 to 25 in this short record.
    assert 2 < fast.numbers.of_record.laeq_db - steady.numbers.of_record.laeq_db < 25
    for run in (steady, fast):
        numbers = run.numbers
        released_db = numbers.levels.released_power_at_listener_db
        assert numbers.of_record.laeq_db == numbers.levels.vibration.laeq_db != released_db
        difference = numbers.levels.release_over_vibration_db
        assert difference == pytest.approx(-10 * np.log10(numbers.levels.equivalent_q))
        assert (
            numbers.of_record.steady_level_db is None and numbers.record.factor_pa_per_w_m2 is None
        )
        assert numbers.motion.balance_error < 1e-6  # the integrator's own tolerance
        assert numbers.motion.force_min_ratio < 1 < numbers.motion.force_max_ratio
        assert numbers.motion.force_law_min_n < 1 < numbers.motion.force_law_max_n
        keys = doubt_lines(run).keys()
        assert {"on_axis", "infinite_plate", "unvalidated", "constant_load_release"} <= keys
        assert not {"upper_bound", "quasi_static", "resonance"} & keys


def test_a_release_beside_a_vibration_is_heard_at_the_distance_of_its_listener(
    steady: Run,
) -> None:
    """Half as far its level is 6 dB higher; a listener at distance_m changes nothing."""
    edges = {"plate.length_mm": 120, "plate.width_mm": 100, "plate.loss_factor": 0.1}
    above = {"plate.contact_mm": [50, 40], "sound.distance_m": 0.5}
    scene = steady.scene.with_(edges | above)
    own = heard_again(steady, scene).numbers
    near = heard_again(steady, scene.with_({"sound.listener_mm": [50, 40, 500]})).numbers
    far = scene.with_({"sound.listener_mm": [50, 40, 1000]})
    released = heard_again(steady, far.with_({"sound.source": "release"})).numbers
    farther = heard_again(steady, far).numbers
    fall = 20 * np.log10(2)
    assert _beside(near) == _beside(own)
    for of_farther, of_near in zip(_beside(farther), _beside(near), strict=True):
        assert of_farther == pytest.approx(of_near - fall, abs=1e-9)
    # The headline of a release stays at distance_m.
    for beside, level in zip(
        _beside(released), (released.of_record.laeq_db, released.of_record.level_db), strict=True
    ):
        assert beside == pytest.approx(level - fall, abs=1e-9)
    for numbers in (own, near, farther, released):
        released_db = numbers.levels.released_power_at_listener_db
        difference = released_db - numbers.levels.vibration.laeq_db
        assert numbers.levels.release_over_vibration_db == pytest.approx(difference)


def _beside(numbers: RunNumbers) -> tuple[float | None, float | None]:
    """Return LAeq and LZeq of the released power where the vibration is heard."""
    levels = numbers.levels
    return levels.released_power_at_listener_db, levels.released_power_z_at_listener_db


def test_other_bodies_over_the_same_marches_sound_as_if_solved_alone(steady: Run) -> None:
    keys = {"sphere.density_kg_m3": 15000, "plate.thickness_mm": 3, "rolling.speed_m_s": 0.7}
    scene = steady.scene.with_(keys)
    again = heard_again(steady, scene)
    alone = run_of(scene)
    assert np.array_equal(again.sound.pressure, alone.sound.pressure)
    assert np.array_equal(again.series["release_energy"], steady.series["release_energy"])
    assert again.vibration_sound is not None and steady.vibration_sound is not None
    heavier = again.vibration_sound.chain.mass_kg / steady.vibration_sound.chain.mass_kg
    assert heavier > 1.9  # 15000 / 7850


def test_the_constant_load_solves_the_contact_of_a_scene_without_dynamics() -> None:
    # The automatic tolerance is higher without dynamics.
    common = ["rolling.distance_mm=0.1", "numerics.tolerance=1e-4"]
    plain = marched(VIBRATING, [*WITHOUT_DYNAMICS, *common])
    still = marched(VIBRATING, [*common, "sound.source=release", "dynamics.release=false"])
    assert still.vibration_sound is not None and plain.vibration_sound is None
    for name in set(plain.series) - {"step_time"}:  # a time of the clock
        assert np.array_equal(plain.series[name], still.series[name]), name
    assert np.array_equal(plain.sound.pressure, still.sound.pressure)
    assert still.numbers.of_record.laeq_db == plain.numbers.of_record.laeq_db
    assert plain.numbers.motion is None and plain.numbers.estimate is not None
    assert still.numbers.motion is not None and still.numbers.estimate is None
    assert still.to_xarray()["force_law"].attrs["own_load_n"] == 1.0


@pytest.mark.law("Vibration: the plate alone makes a pressure of the force's wave form.")
def test_the_plate_alone_repeats_the_force(steady: Run) -> None:
    run = heard_again(steady, steady.scene.with_({"sound.ball": False}))
    assert run.vibration_sound is not None
    # -rho_air / (2 pi rho_plate h) at 1 m, of 10 mm of steel; 0.2 %: the plate's own impedance
    per_newton = -1.204 / (2 * np.pi * 78.5)
    assert np.allclose(
        run.sound.pressure, per_newton * run.vibration_sound.force, rtol=2e-3, atol=0
    )
    assert not np.allclose(steady.sound.pressure, run.sound.pressure, rtol=0.1)


def test_power_above_coincidence_needs_the_loss_factor(steady: Run) -> None:
    lossy, unknown = (
        heard_again(steady, steady.scene.with_({"plate.loss_factor": loss})) for loss in (0.1, None)
    )
    powers = [run.numbers.bands.plate_power.by_name["16000"] for run in (steady, lossy, unknown)]
    # Ten times the loss factor: ten decibels less, less where air takes some of the power.
    assert powers[2] is None and 6 < powers[0] - powers[1] < 10.5
    assert np.array_equal(lossy.sound.pressure, unknown.sound.pressure)


def test_a_smooth_plate_is_silent() -> None:
    text = VIBRATING.split("surface:")
    smooth = f"{text[0]}surface: {{kind: smooth, spacing_um: 2, width_um: 160}}\nrolling:"
    run = marched(smooth + text[1].split("rolling:")[1], ["rolling.distance_mm=0.1"])
    assert run.numbers.of_record.laeq_db is None and run.vibration_sound is not None
    assert not run.vibration_sound.pressure.any()
    assert run.vibration_sound.rms_ratio < 1e-3  # what the solver's error of 1e-4 leaves
    assert single_picture("contact_filter", run) is None  # there are no heights to filter
    assert single_picture("sources", run) is not None


def test_a_flight_longer_than_the_record_is_told() -> None:
    """A load of 1 mN brings the sphere back after many laps; a silent lap is no settled motion."""
    changes = ["rolling.load_n=0.001", "rolling.distance_mm=0.2", "surface.width_um=120"]
    run = marched(VIBRATING, changes)
    assert run.numbers.motion.flight_share == 1 and run.numbers.of_record.laeq_db is None
    assert not run.numbers.motion.settled
    texts = doubt_lines(run)
    assert "the record is shorter than a flight" in texts["impacts"]
    assert "does not repeat from lap to lap" in texts["not_settled"]


MARBLE = """\
name: marble-on-wood
sphere: {radius_mm: 8, density_kg_m3: 2500, youngs_modulus_gpa: 70, poissons_ratio: 0.22}
plate: {youngs_modulus_gpa: 10, poissons_ratio: 0.35, hardness_gpa: 0.03, density_kg_m3: 600,
  thickness_mm: 20}
surface: {kind: gaussian, roughness_ra_um: 2, correlation_length_um: 50, spacing_um: 8,
  width_um: 512, seed: 1}
rolling: {load_n: 0.1, speed_m_s: 0.5, distance_mm: 0.64}
dynamics: {}
sound: {source: vibration}
"""


@pytest.mark.slow
def test_a_force_law_reaches_as_far_as_the_motion() -> None:
    """Approaches of a yielding contact rise too unevenly for a spline through all loads."""
    numbers = marched(MARBLE).numbers
    assert numbers.motion.balance_error < 1e-6
    assert numbers.motion.largest_force_n == pytest.approx(0.1 * numbers.motion.force_max_ratio)
    assert numbers.motion.largest_force_n > 1.2 * 0.1 * 1.4**0.5  # beyond the loads of the scene
    assert numbers.motion.force_outside_share == 0 and numbers.motion.force_law_top_error is None
    # The force between the loads is off by less than it departs from the load.
    assert 0 < numbers.motion.force_law_error_db < 3


def test_the_check_knows_that_a_sharp_resonance_misses_the_lines_of_a_lap() -> None:
    """Between the lines the force is 4 to 22 times smaller than the mean over all resonances.

    A lap of 24 correlation lengths makes the spectrum uncertain by half.
    """
    run = marched(VIBRATING, ["surface.roughness_ra_um=0.005", "rolling.distance_mm=0.24"])
    law = force_law(run.scene, run.result)
    for thickness, speed in [(20, 0.6), (40, 0.8), (40, 1.2)]:
        scene = run.scene.with_({"plate.thickness_mm": thickness, "rolling.speed_m_s": speed})
        speeds = [scene.with_({"rolling.speed_m_s": speed * near}) for near in (0.97, 1, 1.03)]
        forces = [
            np.std(motion_of_ball(bodies_of(near), near.travel, law).force_n) for near in speeds
        ]
        assert 0.5 < force_estimate.force_rms(scene) / np.median(forces) < 2


@pytest.mark.slow
def test_impacts_that_yield_are_marked() -> None:
    """The Hertz pressure is 0.75 GPa at the load; a cap without memory gives the work back."""
    changes = ["surface.roughness_ra_um=0.2", "rolling.speed_m_s=1", "rolling.distance_mm=0.32"]
    run = marched(VIBRATING, changes)
    assert run.numbers.motion.impacts > 0 and run.numbers.motion.impacts_yield is False
    # The same motion over a plate whose hardness lies below the pressure of the impacts.
    soft = run.scene.with_({"plate.hardness_gpa": 0.8})
    soft_run = make_run(RunFolder({}, soft, run.folder), "soft", run.result)
    assert soft_run.numbers.motion.impacts_yield is True


CALM = ["surface.roughness_ra_um=0.02", "rolling.distance_mm=0.4", "rolling.speed_m_s=0.6"]


@pytest.mark.slow
def test_a_release_that_is_heard_is_of_the_moving_load() -> None:
    """`release: false` leaves the march under the moving load out."""
    changes = [*CALM, "sound.source=release"]
    moved = marched(VIBRATING, [*changes, "dynamics.release=true"])
    still = marched(VIBRATING, [*changes, "dynamics.release=false"])
    assert "moving_load_release" in doubt_lines(moved)
    assert "constant_load_release" in doubt_lines(still)
    # The law interpolates between loads, so march and motion agree to a few percent.
    assert moved.result.moving is not None and moved.numbers.energy.moving_law_error_m > 0
    fluctuation = np.std(moved.result.moving.approach)
    assert moved.numbers.energy.moving_law_error_m < 0.03 * fluctuation
    assert moved.numbers.energy.moving_balance_error < 1e-12  # rounding
    assert still.numbers.energy.moving_law_error_m is None
    assert moved.sound.power_rms > 1.02 * still.sound.power_rms
    assert np.array_equal(moved.series["release_energy"], still.series["release_energy"])


def test_a_release_without_a_load_is_of_the_constant_load(tmp_path: Path) -> None:
    changes = ["dynamics.release=true", "surface.roughness_ra_um=0.2", "rolling.speed_m_s=1"]
    run = marched(VIBRATING, [*changes, "rolling.distance_mm=0.32"], tmp_path)
    assert "loses contact" in doubt_lines(run)["no_moving_release"]
    assert run.numbers.energy.moving_law_error_m is None
    write_run(run)
    again = read_run(RunFolder({}, run.scene, tmp_path), "run")
    assert doubt_lines(again) == doubt_lines(run)


JUDGED = ["numerics.error_estimate=true", "rolling.load_n=0.5", "surface.width_um=120"]


def test_levels_have_errors_of_grid_solver_and_force_law(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(error_cost, "SHARE", 3.0)  # a short run pays for its stretches
    monkeypatch.setattr(error_cost, "MIN_STEPS", 16)
    monkeypatch.setattr(error_cost, "MAX_STEPS", 50)
    run = marched(VIBRATING, [*JUDGED, "rolling.speed_m_s=0.1", "rolling.distance_mm=0.4"])
    numbers = run.numbers
    parts = numbers.vibration.parts
    assert set(parts) == {
        "record",
        "grid",
        "solver",
        "force_law",
        "comb",
        "time_step",
        "contact_loss",
    }
    assert parts["comb"] == numbers.motion.comb_spread_db
    assert parts["force_law"] == numbers.motion.force_law_error_db
    total = np.sqrt(sum(part**2 for part in parts.values()))
    assert numbers.vibration.uncertainty == pytest.approx(total)
    assert 0 < parts["solver"] < parts["grid"] < 6
    assert numbers.errors.stretches >= 4
    words = doubt_lines(run)["uncertainty"]
    assert all(PART_WORDS[part] in words for part in parts if parts[part])
    assert "not corrected for their errors of grid and solver" in words
    # The short waves are the grid's, and a faster ball does not hear them.
    faster = heard_again(run, run.scene.with_({"rolling.speed_m_s": 0.3}))
    assert faster.numbers.errors.grid_signal_db < numbers.errors.grid_signal_db
    # Edges weigh the same errors of the approach by their modes.
    edged = heard_again(run, run.scene.with_({"plate.length_mm": 200, "plate.width_mm": 150}))
    errors = [numbers.errors.grid_db, edged.numbers.errors.grid_db]
    assert errors[0] != errors[1] == pytest.approx(errors[0], abs=2.0)


@pytest.mark.parametrize(
    ("roughness", "reason"), [(0.3, "contact is lost"), (0.06, "the contact force fluctuates by")]
)
def test_no_estimate_where_no_linear_chain_carries_it(roughness: float, reason: str) -> None:
    """Near lift-off the level on one grid says nothing about that on another."""
    changes = [f"surface.roughness_ra_um={roughness}", "rolling.distance_mm=0.2"]
    run = marched(VIBRATING, ["numerics.error_estimate=true", "rolling.speed_m_s=1", *changes])
    assert run.vibration_sound is not None and run.vibration_sound.rms_ratio > LINEAR
    texts = doubt_lines(run)
    assert (
        f"{reason}" in texts["no_error_estimate"]
        and "no linear chain" in texts["no_error_estimate"]
    )
    assert not {"grid", "solver", "subgrid"} & run.vibration.parts.keys()
    assert PART_WORDS["grid"] not in texts["uncertainty"]


@pytest.mark.parametrize(
    ("change", "key", "words"),
    [
        ("plate.thickness_mm=30", "bending", "shorter than 6 thicknesses"),
        ("plate.thickness_mm=0.1", "contact_thickness", "a half-space, which holds up to 0.1"),
        ("plate.thickness_mm=0.1", "air_load", "the load of the air is left out"),
        ("sound.distance_m=0.2", "coincidence", "pressure on the axis holds from"),
        ("rolling.speed_m_s=0.05", "resonance_wave", "the grid decides"),
        ("surface.roughness_ra_um=1", "force_ratio", "loses contact"),
    ],
)
def test_limits_of_the_model_become_warnings_with_numbers(
    change: str, key: str, words: str
) -> None:
    calm = "surface.roughness_ra_um=0.04"
    plain = {finding.key: finding for finding in checked(loads(VIBRATING, [calm]))}
    changed = {finding.key: finding for finding in checked(loads(VIBRATING, [calm, change]))}
    assert plain[key].warning is None
    assert words in str(changed[key].warning)


# A thick plate hardly damps the ball.
UNDAMPED = ["plate.thickness_mm=30"]


@pytest.fixture(scope="module")
def undamped() -> Run:
    return marched(VIBRATING, UNDAMPED)


def test_a_short_track_states_the_mean_over_its_comb(undamped: Run) -> None:
    numbers = undamped.numbers
    assert undamped.vibration_sound is not None
    record = level_db(
        float(np.mean(np.square(a_weighted(undamped.sound.pressure, 48000)))), P_REF_PA**2
    )
    assert numbers.motion.comb_spread_db > 3
    assert numbers.record.laeq_db == pytest.approx(record, abs=1e-6)
    stated = numbers.vibration.value
    assert stated == numbers.levels.vibration.laeq_db == numbers.motion.comb_mean_laeq_db
    assert undamped.sound.levels.laeq_db == stated != numbers.record.laeq_db
    spread = numbers.motion.comb_spread_db
    step = numbers.motion.step_error_db
    loss = numbers.contact_loss_db / 2
    assert numbers.of_record.spreads.laeq_db == pytest.approx(math.hypot(spread, step, loss))
    # Sound files and third octaves belong to the record.
    bands = [db for db in numbers.bands.vibration_a.value if db is not None]
    together = 10 * np.log10(np.sum(10 ** (np.array(bands) / 10)))
    assert together == pytest.approx(numbers.record.laeq_db, abs=0.01)
    assert numbers.leading.verdict == "do not quote"
    # An undamped half-space: the loss of the contact, which is unknown, would matter still more.
    assert numbers.leading.judged.worst.key == "contact_loss"
    assert "comb" not in [doubt.key for doubt in numbers.doubts]
    assert "comb_mean" in doubt_lines(undamped)


@pytest.mark.slow
@pytest.mark.law("Free plates: the uncertainty of a level holds what the missing baffle changes.")
def test_a_free_plate_has_a_part_for_its_missing_baffle(undamped: Run) -> None:
    edges = {"plate.length_mm": 100, "plate.width_mm": 75, "plate.edges": "free"}
    run = heard_again(undamped, undamped.scene.with_(edges | {"plate.loss_factor": 0.01}))
    free = run.numbers
    assert undamped.numbers.motion.baffle_db == 0
    assert 2.5 <= free.motion.baffle_db <= 10
    assert free.of_record.spreads.laeq_db > free.motion.baffle_db
    assert free.bands.vibration.uncertainty_by_name["8000"] > 2.5  # far above coincidence
    lines = doubt_lines(run)
    assert "a free plate is computed as in a baffle" in lines["baffle"]
    assert PART_WORDS["baffle"] in lines["uncertainty"]


def test_a_damped_contact_states_the_level_of_its_record(undamped: Run) -> None:
    damped = heard_again(undamped, undamped.scene.with_({"plate.contact_loss_factor": 0.3}))
    numbers = damped.numbers
    assert numbers.of_record.laeq_db == numbers.record.laeq_db
    assert "comb_mean" not in doubt_lines(damped)


def test_the_check_foresees_the_comb(undamped: Run) -> None:
    """The estimate before the run needs no solve; few lines make it right within a factor of 2."""
    found = {x.key: x for x in checked(undamped.scene)}["comb"]
    assert found.warning and "plate.contact_loss_factor" in found.warning
    assert "plate.thickness_mm" in found.warning and "rolling.distance_mm" in found.warning
    scene = undamped.scene
    chain = bodies_of(undamped.scene).smooth_chain
    lap = scene.track.lap_steps * scene.track.step
    spread = comb_spread.comb_spread_db(scene, chain, lap, scene.motion.fastest(scene.duration))
    assert spread is not None and 0.5 < spread / undamped.numbers.motion.comb_spread_db < 2
    damped = scene.with_({"plate.contact_loss_factor": 0.3})
    assert {x.key: x for x in checked(damped)}["comb"].warning is None


def test_the_check_foresees_the_comb_of_a_file(tmp_path: Path) -> None:
    heights = tmp_path / "heights.npy"
    z = 1e-7 * np.random.default_rng(1).standard_normal((240, 80))
    np.save(heights, ndimage.gaussian_filter(z, 4, mode="wrap") * 4)
    keys = {"surface": {"kind": "file", "path": str(heights), "spacing_um": 2}}
    scene = loads(VIBRATING, UNDAMPED).with_(keys)
    found = {x.key: x for x in checked(scene)}["comb"]
    assert found.warning and "measure a longer track" in found.warning
