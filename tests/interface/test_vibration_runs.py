"""Runs with dynamics: their levels, numbers and doubts, and other bodies over the same marches."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from checked import checked
from finished import VIBRATING, WITHOUT_DYNAMICS, doubt_lines, heard_again, marched, run_of
from scipy import ndimage

from acoustics.level import a_weighted, level_db
from acoustics.radiation import P_REF_PA
from rolling.check import comb, error_cost, force_estimate
from rolling.dynamics import of_scene
from rolling.figures.catalogue import single_picture
from rolling.marches.force_law import force_law
from rolling.results.run_errors import LINEAR
from rolling.results.run_folder import RunFolder
from rolling.results.run_result import Run, make_run, read_run, write_run
from rolling.scene.file import loads


@pytest.fixture(scope="module")
def steady() -> Run:
    return marched(VIBRATING)


@pytest.fixture(scope="module")
def fast(steady: Run) -> Run:
    return heard_again(steady, steady.scene.with_({"rolling.speed_m_s": 1}))


def test_levels_rise_with_speed_and_have_no_steady_level(steady: Run, fast: Run) -> None:
    # Six to nine decibels for three times the speed in practice, 2 to 25 in this short record.
    assert 2 < fast.summary["laeq_db"] - steady.summary["laeq_db"] < 25
    for run in (steady, fast):
        numbers = run.summary
        assert numbers["laeq_db"] == numbers["vibration_laeq_db"] != numbers["release_laeq_db"]
        difference = numbers["release_over_vibration_db"]
        assert difference == pytest.approx(-10 * np.log10(numbers["equivalent_q"]))
        assert numbers["steady_level_db"] is None and numbers["factor_pa_per_w_m2"] is None
        assert numbers["motion_balance_error"] < 1e-6  # the integrator's own tolerance
        assert numbers["force_min_ratio"] < 1 < numbers["force_max_ratio"]
        assert numbers["force_law_min_n"] < 1 < numbers["force_law_max_n"]
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
    own = heard_again(steady, scene).summary
    near = heard_again(steady, scene.with_({"sound.listener_mm": [50, 40, 500]})).summary
    far = scene.with_({"sound.listener_mm": [50, 40, 1000]})
    released = heard_again(steady, far.with_({"sound.source": "release"})).summary
    farther = heard_again(steady, far).summary
    fall = 20 * np.log10(2)
    for key in ("laeq_db", "level_db"):
        assert near[f"release_{key}"] == own[f"release_{key}"]
        assert farther[f"release_{key}"] == pytest.approx(near[f"release_{key}"] - fall, abs=1e-9)
        # The headline of a release stays at distance_m.
        assert released[f"release_{key}"] == pytest.approx(released[key] - fall, abs=1e-9)
    for numbers in (own, near, farther, released):
        difference = numbers["release_laeq_db"] - numbers["vibration_laeq_db"]
        assert numbers["release_over_vibration_db"] == pytest.approx(difference)


def test_other_bodies_over_the_same_marches_sound_as_if_solved_alone(steady: Run) -> None:
    keys = {"sphere.density_kg_m3": 15000, "plate.thickness_mm": 3, "rolling.speed_m_s": 0.7}
    scene = steady.scene.with_(keys)
    again = heard_again(steady, scene)
    alone = run_of(scene)
    assert np.array_equal(again.sound.pressure, alone.sound.pressure)
    assert np.array_equal(again.series["release_energy"], steady.series["release_energy"])
    assert again.vibration is not None and steady.vibration is not None
    assert again.vibration.chain.mass_kg > 1.9 * steady.vibration.chain.mass_kg  # 15000 / 7850


def test_the_constant_load_solves_the_contact_of_a_scene_without_dynamics() -> None:
    # The automatic tolerance is higher without dynamics.
    common = ["rolling.distance_mm=0.1", "numerics.tolerance=1e-4"]
    plain = marched(VIBRATING, [*WITHOUT_DYNAMICS, *common])
    still = marched(VIBRATING, [*common, "sound.source=release", "dynamics.release=false"])
    assert still.vibration is not None and plain.vibration is None
    for name in set(plain.series) - {"step_time"}:  # a time of the clock
        assert np.array_equal(plain.series[name], still.series[name]), name
    assert np.array_equal(plain.sound.pressure, still.sound.pressure)
    assert still.summary["laeq_db"] == plain.summary["laeq_db"]
    assert not any(key.startswith(("force", "motion")) for key in plain.summary)
    assert still.to_xarray()["force_law"].attrs["own_load_n"] == 1.0


@pytest.mark.law("Vibration: the plate alone makes a pressure of the force's wave form.")
def test_the_plate_alone_repeats_the_force(steady: Run) -> None:
    run = heard_again(steady, steady.scene.with_({"sound.ball": False}))
    assert run.vibration is not None
    # -rho_air / (2 pi rho_plate h) at 1 m, of 10 mm of steel; 0.2 %: the plate's own impedance
    per_newton = -1.204 / (2 * np.pi * 78.5)
    assert np.allclose(run.sound.pressure, per_newton * run.vibration.force, rtol=2e-3, atol=0)
    assert not np.allclose(steady.sound.pressure, run.sound.pressure, rtol=0.1)


def test_power_above_coincidence_needs_the_loss_factor(steady: Run) -> None:
    lossy, unknown = (
        heard_again(steady, steady.scene.with_({"plate.loss_factor": loss})) for loss in (0.1, None)
    )
    powers = [
        run.summary["plate_power_third_octave_db"]["16000"] for run in (steady, lossy, unknown)
    ]
    # Ten times the loss factor: ten decibels less, less where air takes some of the power.
    assert powers[2] is None and 6 < powers[0] - powers[1] < 10.5
    assert np.array_equal(lossy.sound.pressure, unknown.sound.pressure)


def test_a_smooth_plate_is_silent() -> None:
    text = VIBRATING.split("surface:")
    smooth = f"{text[0]}surface: {{kind: smooth, spacing_um: 2, width_um: 160}}\nrolling:"
    run = marched(smooth + text[1].split("rolling:")[1], ["rolling.distance_mm=0.1"])
    assert run.summary["laeq_db"] is None and run.vibration is not None
    assert not run.vibration.pressure.any()
    assert run.vibration.rms_ratio < 1e-3  # what the solver's error of 1e-4 leaves
    assert single_picture("contact_filter", run) is None  # there are no heights to filter
    assert single_picture("sources", run) is not None


def test_a_flight_longer_than_the_record_is_told() -> None:
    """A load of 1 mN brings the sphere back after many laps; a silent lap is no settled motion."""
    changes = ["rolling.load_n=0.001", "rolling.distance_mm=0.2", "surface.width_um=120"]
    run = marched(VIBRATING, changes)
    assert run.summary["flight_share"] == 1 and run.summary["laeq_db"] is None
    assert not run.summary["motion_settled"]
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
    numbers = marched(MARBLE).summary
    assert numbers["motion_balance_error"] < 1e-6
    assert numbers["largest_force_n"] == pytest.approx(0.1 * numbers["force_max_ratio"])
    assert numbers["largest_force_n"] > 1.2 * 0.1 * 1.4**0.5  # beyond the loads of the scene
    assert numbers["force_outside_share"] == 0 and numbers["force_law_top_error"] is None
    # The force between the loads is off by less than it departs from the load.
    assert 0 < numbers["force_law_error_db"] < 3


def test_the_check_knows_that_a_sharp_resonance_misses_the_lines_of_a_lap() -> None:
    """Between the lines the force is 4 to 22 times smaller than the mean over all resonances.

    A lap of 24 correlation lengths makes the spectrum uncertain by half.
    """
    run = marched(VIBRATING, ["surface.roughness_ra_um=0.005", "rolling.distance_mm=0.24"])
    law = force_law(run.scene, run.result)
    for thickness, speed in [(20, 0.6), (40, 0.8), (40, 1.2)]:
        scene = run.scene.with_({"plate.thickness_mm": thickness, "rolling.speed_m_s": speed})
        speeds = [scene.with_({"rolling.speed_m_s": speed * near}) for near in (0.97, 1, 1.03)]
        forces = [np.std(of_scene.motion(near, law).force_n) for near in speeds]
        assert 0.5 < force_estimate.force_rms(scene) / np.median(forces) < 2


@pytest.mark.slow
def test_impacts_that_yield_are_marked() -> None:
    """The Hertz pressure is 0.75 GPa at the load; a cap without memory gives the work back."""
    changes = ["surface.roughness_ra_um=0.2", "rolling.speed_m_s=1", "rolling.distance_mm=0.32"]
    run = marched(VIBRATING, changes)
    assert run.summary["impacts"] > 0 and run.summary["impacts_yield"] is False
    # The same motion over a plate whose hardness lies below the pressure of the impacts.
    soft = run.scene.with_({"plate.hardness_gpa": 0.8})
    soft_run = make_run(RunFolder({}, soft, run.folder), "soft", run.result)
    assert soft_run.summary["impacts_yield"] is True


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
    assert moved.result.moving is not None and moved.summary["force_law_error_m"] > 0
    fluctuation = np.std(moved.result.moving.approach)
    assert moved.summary["force_law_error_m"] < 0.03 * fluctuation
    assert moved.summary["moving_release_balance_error"] < 1e-12  # rounding
    assert "force_law_error_m" not in still.summary
    assert moved.sound.power_rms > 1.02 * still.sound.power_rms
    assert np.array_equal(moved.series["release_energy"], still.series["release_energy"])


def test_a_release_without_a_load_is_of_the_constant_load(tmp_path: Path) -> None:
    changes = ["dynamics.release=true", "surface.roughness_ra_um=0.2", "rolling.speed_m_s=1"]
    run = marched(VIBRATING, [*changes, "rolling.distance_mm=0.32"], tmp_path)
    assert "loses contact" in doubt_lines(run)["no_moving_release"]
    assert "force_law_error_m" not in run.summary
    write_run(run)
    again = read_run(RunFolder({}, run.scene, tmp_path), "run")
    assert doubt_lines(again) == doubt_lines(run)


JUDGED = ["numerics.error_estimate=true", "rolling.load_n=0.5", "surface.width_um=120"]


def test_levels_have_errors_of_grid_solver_and_force_law(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(error_cost, "SHARE", 3.0)  # a short run pays for its stretches
    monkeypatch.setattr(error_cost, "MIN_STEPS", 16)
    monkeypatch.setattr(error_cost, "MAX_STEPS", 50)
    run = marched(VIBRATING, [*JUDGED, "rolling.speed_m_s=0.1", "rolling.distance_mm=0.4"])
    numbers = run.summary
    parts = numbers["laeq_uncertainty_parts_db"]
    assert set(parts) == {
        "record",
        "grid",
        "solver",
        "force_law",
        "comb",
        "time_step",
        "contact_loss",
    }
    assert parts["comb"] == numbers["comb_spread_db"]
    assert parts["force_law"] == numbers["force_law_error_db"]
    total = np.sqrt(sum(part**2 for part in parts.values()))
    assert numbers["laeq_uncertainty_db"] == pytest.approx(total)
    assert 0 < parts["solver"] < parts["grid"] < 6
    assert numbers["error_estimate"]["stretches"] >= 4
    assert "Errors of grid, solver and force law are" in doubt_lines(run)["uncertainty"]
    # The short waves are the grid's, and a faster ball does not hear them.
    faster = heard_again(run, run.scene.with_({"rolling.speed_m_s": 0.3}))
    assert faster.summary["grid_signal_db"] < numbers["grid_signal_db"]
    # Edges weigh the same errors of the approach by their modes.
    edged = heard_again(run, run.scene.with_({"plate.length_mm": 200, "plate.width_mm": 150}))
    errors = [numbers["laeq_grid_error_db"], edged.summary["laeq_grid_error_db"]]
    assert errors[0] != errors[1] == pytest.approx(errors[0], abs=2.0)


@pytest.mark.parametrize(
    ("roughness", "reason"), [(0.3, "contact is lost"), (0.06, "the contact force fluctuates by")]
)
def test_no_estimate_where_no_linear_chain_carries_it(roughness: float, reason: str) -> None:
    """Near lift-off the level on one grid says nothing about that on another."""
    changes = [f"surface.roughness_ra_um={roughness}", "rolling.distance_mm=0.2"]
    run = marched(VIBRATING, ["numerics.error_estimate=true", "rolling.speed_m_s=1", *changes])
    assert run.vibration is not None and run.vibration.rms_ratio > LINEAR
    texts = doubt_lines(run)
    assert (
        f"{reason}" in texts["no_error_estimate"]
        and "no linear chain" in texts["no_error_estimate"]
    )
    assert run.summary["laeq_uncertainty_db"] is None
    assert "it holds no error of model, grid or solver" in texts["uncertainty"]


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
    numbers = undamped.summary
    assert undamped.vibration is not None
    record = level_db(
        float(np.mean(np.square(a_weighted(undamped.sound.pressure, 48000)))), P_REF_PA**2
    )
    assert numbers["comb_spread_db"] > 3
    assert numbers["record_laeq_db"] == pytest.approx(record, abs=1e-6)
    assert numbers["laeq_db"] == numbers["vibration_laeq_db"] == numbers["comb_mean_laeq_db"]
    assert undamped.sound.levels.laeq_db == numbers["laeq_db"] != numbers["record_laeq_db"]
    spread = numbers["comb_spread_db"]
    step = numbers["motion_step_error_db"]
    loss = numbers["contact_loss_db"] / 2
    assert numbers["uncertainty_db"]["laeq"] == pytest.approx(math.hypot(spread, step, loss))
    # Sound files and third octaves belong to the record.
    bands = [db for db in numbers["third_octave_a_db"].values() if db is not None]
    together = 10 * np.log10(np.sum(10 ** (np.array(bands) / 10)))
    assert together == pytest.approx(numbers["record_laeq_db"], abs=0.01)
    assert numbers["verdict"]["word"] == "do not quote"
    # An undamped half-space: the loss of the contact, which is unknown, would matter still more.
    assert numbers["verdict"]["key"] == "contact_loss"
    assert "comb" not in [doubt["key"] for doubt in numbers["doubts"]]
    assert "comb_mean" in doubt_lines(undamped)


@pytest.mark.slow
@pytest.mark.law("Free plates: the uncertainty of a level holds what the missing baffle changes.")
def test_a_free_plate_has_a_part_for_its_missing_baffle(undamped: Run) -> None:
    edges = {"plate.length_mm": 100, "plate.width_mm": 75, "plate.edges": "free"}
    run = heard_again(undamped, undamped.scene.with_(edges | {"plate.loss_factor": 0.01}))
    free = run.summary
    assert undamped.summary["baffle_db"] == 0
    assert 2.5 <= free["baffle_db"] <= 10
    assert free["uncertainty_db"]["laeq"] > free["baffle_db"]
    assert free["third_octave_uncertainty_db"]["8000"] > 2.5  # far above coincidence
    lines = doubt_lines(run)
    assert "a free plate is computed as in a baffle" in lines["baffle"]
    assert "because the free plate has no baffle" in lines["uncertainty"]


def test_a_damped_contact_states_the_level_of_its_record(undamped: Run) -> None:
    damped = heard_again(undamped, undamped.scene.with_({"plate.contact_loss_factor": 0.3}))
    numbers = damped.summary
    assert numbers["laeq_db"] == numbers["record_laeq_db"]
    assert "comb_mean" not in doubt_lines(damped)


def test_the_check_foresees_the_comb(undamped: Run) -> None:
    """The estimate before the run needs no solve; few lines make it right within a factor of 2."""
    found = {x.key: x for x in checked(undamped.scene)}["comb"]
    assert found.warning and "plate.contact_loss_factor" in found.warning
    assert "plate.thickness_mm" in found.warning and "rolling.distance_mm" in found.warning
    scene = undamped.scene
    chain = of_scene.smooth_chain(undamped.scene)
    lap = scene.track.lap_steps * scene.track.step
    spread = comb.comb_spread_db(scene, chain, lap, scene.motion.fastest(scene.duration))
    assert spread is not None and 0.5 < spread / undamped.summary["comb_spread_db"] < 2
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
