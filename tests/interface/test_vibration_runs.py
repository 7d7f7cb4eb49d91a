"""Runs with dynamics: shared marches, storage, resume, new sound, levels and caveats."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import h5py
import numpy as np
import pytest

from rolling.check import demand
from rolling.check.findings import check_scene
from rolling.commands import Wanted, resound, resume, run, run_tasks
from rolling.commands.interface import open_run, simulate
from rolling.contact.solver import ContactError
from rolling.dynamics import of_scene
from rolling.folders.claim import Claim
from rolling.folders.files import FolderError
from rolling.scene.file import loads, read_scene
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.simulation import batch, force_law, moving_release, result_file, solving
from rolling.simulation import simulate as pieces
from rolling.simulation.batch import Run
from rolling.simulation.moving_load import moving_key
from rolling.simulation.pool import Outcome
from rolling.simulation.result import Result
from rolling.simulation.run_result import hear
from rolling.simulation.stored_runs import read_runs
from rolling.terminal import progress

ALONE = Wanted(workers=1, page=False, pictures=False)
TEXT = """\
name: vibrating
sphere: {radius_mm: 5, density_kg_m3: 7850}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, density_kg_m3: 7850, thickness_mm: 10,
  loss_factor: 0.01}
surface: {kind: gaussian, roughness_ra_um: 0.05, correlation_length_um: 10, spacing_um: 2,
  width_um: 160, seed: 3}
rolling: {load_n: 1, speed_m_s: 0.3, distance_mm: 0.48}
dynamics: {}
sound: {source: vibration}
"""
SWEPT = TEXT + "sweep: {rolling.speed_m_s: [0.3, 1], plate.thickness_mm: [1, 10]}\n"


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("vibrating")
    (folder / "scene.yaml").write_text(SWEPT)
    out = folder / "out"
    run(folder / "scene.yaml", out=out, wanted=ALONE)
    return out


def summaries(folder: Path) -> list[dict]:
    return [json.loads((each.folder / "summary.json").read_text()) for each in read_runs(folder)]


def solved(scene: Scene) -> Result:
    results = [Result.empty(scene.track, scene.start)]
    results[0].identity = pieces.identity_of(scene)
    assert not solving.solve([scene], results, 1, "alone", progress=False).failures
    return results[0]


def test_a_sweep_over_speed_and_thickness_marches_once(
    monkeypatch: pytest.MonkeyPatch, swept: Path
) -> None:
    scenes = [single for _, single in loads(SWEPT).runs()]
    results = [Result.empty(scene.track, scene.start) for scene in scenes]
    counts: dict[str, int] = {"own": 0, "other": 0}
    own, other = pieces.simulate_piece, force_law.march_load
    monkeypatch.setattr(
        pieces,
        "simulate_piece",
        lambda *a, **k: counts.update(own=counts["own"] + 1) or own(*a, **k),
    )
    monkeypatch.setattr(
        force_law, "march_load", lambda *a: counts.update(other=counts["other"] + 1) or other(*a)
    )
    assert not solving.solve(scenes, results, 1, "sweep", progress=False).failures
    assert len({id(result) for result in results}) == 1
    marches = results[0].load_marches
    assert marches is not None and not marches.fault
    # Two pieces of the track per load, and a stretch between each two loads.
    assert counts == {"own": 2, "other": 2 * len(marches.approach) + len(marches.judging)}
    assert len(marches.judging) == len(marches.approach)


def test_two_speeds_of_one_march_equal_two_runs(swept: Path) -> None:
    for each in read_runs(swept)[::3]:
        alone, stored = simulate(each.scene, 1, False), open_run(each.folder)
        assert np.array_equal(alone.sound.pressure, stored.sound.pressure)
        assert alone.vibration is not None and stored.vibration is not None
        assert np.array_equal(alone.vibration.motion.force_n, stored.vibration.motion.force_n)


def test_each_folder_has_law_and_force(swept: Path) -> None:
    for each in read_runs(swept):
        with h5py.File(each.folder / "result.h5") as file:
            law, force = file["force_law"], file["contact_force"]
            assert law.attrs["complete"]
            load = law["load"][()]
            assert 1.0 in load and np.all(np.diff(load) > 0)
            own = law["approach"][load.tolist().index(1.0)]
            assert np.array_equal(own, file["approach"][()])
            assert np.all(np.diff(law["approach"][()], axis=0) > 0)
            assert force["force"][()].mean() == pytest.approx(1.0, rel=1e-9)
            low, high = force.attrs["minimum_n"], force.attrs["maximum_n"]
            assert load[0] <= low < 1 < high <= load[-1]
            assert force["band_rms"].shape == (31,)
            assert "factor_pa_per_w_m2" not in file["sound"].attrs


def test_a_stored_law_is_read_again(swept: Path) -> None:
    result = result_file.load(read_runs(swept)[0].folder / "result.h5")
    assert result.load_marches is not None and result.load_marches.complete
    again = solved(read_runs(swept)[0].scene)
    assert again.load_marches is not None
    assert result.load_marches.approach.keys() >= again.load_marches.approach.keys()
    for load, approach in again.load_marches.approach.items():
        assert np.array_equal(result.load_marches.approach[load], approach)


def test_a_killed_run_goes_on(swept: Path, tmp_path: Path) -> None:
    """A folder without one piece of one load marches that piece, and ends with the same bytes."""
    (tmp_path / "scene.yaml").write_text(TEXT)
    out = tmp_path / "out"
    run(tmp_path / "scene.yaml", out=out, wanted=ALONE)
    (each,) = read_runs(out)
    whole = result_file.load(out / "result.h5")
    assert whole.load_marches is not None
    marches = replace(
        whole.load_marches, complete=False, approach=dict(whole.load_marches.approach)
    )
    load = min(marches.approach)
    marches.approach[load] = np.where(np.arange(241) > 200, np.nan, marches.approach[load])
    batch.keep(each, replace(whole, load_marches=marches))
    (out / "summary.json").unlink()
    report = resume(out, wanted=ALONE)
    assert report.exit_code == 0
    after = result_file.load(out / "result.h5").load_marches
    assert after is not None and after.complete
    assert np.array_equal(after.approach[load], whole.load_marches.approach[load])


def test_levels_rise_with_speed_and_have_no_steady_level(swept: Path) -> None:
    numbers = summaries(swept)
    by_run = {
        (each.values["rolling.speed_m_s"], each.values["plate.thickness_mm"]): summary
        for each, summary in zip(read_runs(swept), numbers, strict=True)
    }
    for thickness in (1, 10):
        slow, fast = by_run[0.3, thickness], by_run[1, thickness]
        assert 2 < fast["vibration_laeq_db"] - slow["vibration_laeq_db"] < 25
        assert fast["laeq_db"] == fast["vibration_laeq_db"]
        assert fast["release_over_vibration_db"] == pytest.approx(
            -10 * np.log10(fast["equivalent_q"])
        )
    for summary in numbers:
        assert summary["steady_level_db"] is None
        assert summary["factor_pa_per_w_m2"] is None
        assert summary["motion_balance_error"] < 1e-6
        assert summary["force_min_ratio"] < 1 < summary["force_max_ratio"]
        keys = {caveat["key"] for caveat in summary["caveats"]}
        assert {"on_axis", "infinite_plate", "unvalidated", "constant_load_release"} <= keys
        assert not {"upper_bound", "quasi_static", "resonance"} & keys


def test_resound_changes_the_bodies_without_solving(swept: Path, tmp_path: Path) -> None:
    one = read_runs(swept)[0].folder
    heavy = tmp_path / "heavy"
    keys = ["sphere.density_kg_m3=15000", "plate.thickness_mm=3", "rolling.speed_m_s=0.7"]
    resound(one, keys, out=heavy, wanted=ALONE)
    before, after = open_run(one), open_run(heavy)
    assert after.vibration is not None and before.vibration is not None
    assert after.vibration.chain.mass_kg > 1.9 * before.vibration.chain.mass_kg
    assert np.array_equal(before.series["release_energy"], after.series["release_energy"])
    alone = simulate(read_scene(heavy / "resolved.yaml"), 1, False)
    assert np.array_equal(after.sound.pressure, alone.sound.pressure)
    release = tmp_path / "release"
    changes = ["sound.source=release", "sound.q=0.1", "dynamics.release=false"]
    resound(one, changes, out=release, wanted=ALONE)
    numbers = json.loads((release / "summary.json").read_text())
    assert numbers["laeq_db"] == numbers["release_laeq_db"]
    assert numbers["steady_level_db"] is not None


def test_a_run_without_marches_cannot_be_resounded_as_vibration(tmp_path: Path) -> None:
    plain = TEXT.replace("dynamics: {}\n", "").replace(
        ", thickness_mm: 10,\n  loss_factor: 0.01", ""
    )
    (tmp_path / "s.yaml").write_text(plain.replace("sound: {source: vibration}\n", ""))
    out = tmp_path / "out"
    run(
        tmp_path / "s.yaml",
        ["rolling.distance_mm=0.1"],
        out,
        wanted=Wanted(workers=1, pictures=False),
    )
    with h5py.File(out / "result.h5") as file:
        assert not {"force_law", "contact_force"} & set(file)
    assert not any(
        key.startswith("force") for key in json.loads((out / "summary.json").read_text())
    )
    with pytest.raises(SceneError, match="needs the section dynamics"):
        resound(out, ["sound.source=vibration"], tmp_path / "no")
    # A folder whose scene was changed by hand lacks the marches as well.
    text = (out / "resolved.yaml").read_text()
    (out / "resolved.yaml").write_text(text + "dynamics: {loads: 3, span: 1.4}\n")
    with pytest.raises(FolderError, match="the marches of its force law are missing"):
        resound(out, ["sound.source=vibration"], tmp_path / "no")
    assert not (tmp_path / "no").exists()


def test_loads_are_added_until_the_force_lies_inside() -> None:
    scene = loads(TEXT, ["dynamics.span=1.05", "rolling.speed_m_s=0.3"])
    result = solved(scene)
    needed = force_law.loads_of(scene, result, of_scene.extremes)
    assert len(needed.marched) > 3 and not needed.lacking
    least, most = of_scene.extremes(scene, force_law.force_law(scene, result, needed.marched))
    assert needed.marched[0] <= least < most <= needed.marched[-1]
    error = force_law.law_error(scene, result, needed.marched)
    assert error is not None and 0 < error.newtons < 1e-2 and error.decibels < 1


def test_a_flight_longer_than_the_record_is_told() -> None:
    """A load of 1 mN brings the sphere back after many laps; a silent lap is no settled motion."""
    changes = ["rolling.load_n=0.001", "rolling.distance_mm=0.2", "surface.width_um=120"]
    run = simulate(loads(TEXT, changes), 1, False)
    assert run.summary["flight_share"] == 1 and run.summary["laeq_db"] is None
    assert not run.summary["motion_settled"]
    texts = {caveat["key"]: caveat["text"] for caveat in run.summary["caveats"]}
    assert "the record is shorter than a flight" in texts["impacts"]
    assert "does not repeat from lap to lap" in texts["not_settled"]


def test_the_key_of_a_track_that_is_too_short_is_that_of_the_scene() -> None:
    scene = loads(TEXT, ["rolling.distance_mm=0.05", "rolling.load_n=5"])
    (run,) = check_scene(scene, False).runs
    assert "larger rolling.distance_mm" in str({f.key: f.warning for f in run.findings}["window"])
    with pytest.raises(ContactError, match=r"raise rolling.duration_s or rolling.distance_mm"):
        simulate(scene, 1, False)


def test_a_smooth_plate_is_silent() -> None:
    scene = loads(
        TEXT.replace(
            "{kind: gaussian, roughness_ra_um: 0.05, correlation_length_um: 10, spacing_um: 2,\n"
            "  width_um: 160, seed: 3}",
            "{kind: smooth, spacing_um: 2, width_um: 160}",
        ),
        ["rolling.distance_mm=0.1"],
    )
    run = simulate(scene, 1, False)
    assert run.summary["laeq_db"] is None
    assert run.vibration is not None and not run.vibration.pressure.any()
    assert run.vibration.rms_ratio < 1e-3


def test_the_check_names_the_key_and_falls_silent() -> None:
    vibrating = {each.key: each for each in check_scene(loads(TEXT), False).runs[0].findings}
    assert vibrating["resonance"].warning is None and "Q " in vibrating["resonance"].value
    assert "0." in vibrating["force_ratio"].value
    plain = loads(TEXT, ["dynamics=", "sound=", "plate.thickness_mm=", "plate.loss_factor="])
    still = {each.key: each for each in check_scene(plain, False).runs[0].findings}
    assert "`dynamics: {}`" in str(still["resonance"].warning)
    assert "force_ratio" not in still


PLAIN_KEYS = """
caveats complete contact_area_mean_m2 convolutions_mean duration_s energy_balance_error
factor_pa_per_w_m2 hertz_area_m2 highest_frequency_hz iterations_mean laeq_db laf_max_db las_max_db
level_db levelling load_n loops lz_peak_db max_pressure_pa name plastic_area_mean_m2 plastic_ratio
release_power_audible_rms_w release_power_mean_w release_power_resolved_rms_w release_power_rms_w
residual_max seconds sound_seconds steady_level_db step_ms steps surface third_octave_a_db
third_octave_db third_octave_uncertainty_db tolerance tolerance_chosen tolerance_trial
uncertainty_db
"""


def test_a_scene_without_dynamics_is_unchanged() -> None:
    """The constant load solves the same contact bit by bit; the plain run knows no vibration."""
    changes = ["rolling.distance_mm=0.1", "sound.source=release"]
    without = ["dynamics=", "plate.thickness_mm=", "plate.loss_factor="]
    plain = simulate(loads(TEXT, [*changes, *without]), 1, False)
    vibrating = simulate(loads(TEXT, [*changes, "dynamics.release=false"]), 1, False)
    assert vibrating.vibration is not None and plain.vibration is None
    assert set(plain.series) == set(vibrating.series)
    for name in set(plain.series) - {"step_time"}:  # a time of the clock
        assert np.array_equal(plain.series[name], vibrating.series[name]), name
    assert np.array_equal(plain.sound.pressure, vibrating.sound.pressure)
    assert set(plain.summary) == set(PLAIN_KEYS.split())
    assert vibrating.summary["laeq_db"] == plain.summary["laeq_db"]


@pytest.mark.parametrize(
    ("change", "key", "words"),
    [
        ("plate.thickness_mm=30", "bending", "shorter than 6 thicknesses"),
        ("plate.thickness_mm=0.1", "contact_thickness", "of the thickness"),
        ("plate.thickness_mm=0.1", "air_load", "the air loads a plate as light as this"),
        ("sound.distance_m=0.2", "coincidence", "pressure on the axis holds from"),
        ("rolling.speed_m_s=0.05", "resonance_wave", "the grid decides"),
        ("surface.roughness_ra_um=2", "force_ratio", "loses contact"),
        ("surface.roughness_ra_um=0.05", "force_ratio", "marched down to 0.25 of it"),
    ],
)
def test_validity_has_numbers(change: str, key: str, words: str) -> None:
    calm = "surface.roughness_ra_um=0.04"
    plain = {each.key: each for each in check_scene(loads(TEXT, [calm]), False).runs[0].findings}
    changed = check_scene(loads(TEXT, [calm, change]), False).runs[0].findings
    assert plain[key].warning is None
    assert words in str({each.key: each for each in changed}[key].warning)


def test_a_half_space_says_where_its_sound_holds() -> None:
    scene = loads(TEXT, ["plate.thickness_mm=", "plate.loss_factor="])
    finding = {each.key: each for each in check_scene(scene, False).runs[0].findings}
    assert "10 kHz at 1 m" in str(finding["half_space_sound"].warning)


@pytest.mark.law("Vibration: the plate alone makes a pressure of the force's wave form.")
def test_the_plate_alone_repeats_the_force(swept: Path) -> None:
    each = read_runs(swept)[3]
    silent_ball = each.scene.with_({"sound.ball": False})
    result = result_file.load(each.folder / "result.h5")
    run = hear("plate", {}, each.folder, silent_ball, result)
    assert run is not None and run.vibration is not None
    per_newton = -1.204 / (2 * np.pi * 78.5)  # at 1 m, of 10 mm of steel
    assert np.allclose(run.sound.pressure, per_newton * run.vibration.force, rtol=2e-3, atol=0)
    whole = open_run(each.folder)
    assert not np.allclose(whole.sound.pressure, run.sound.pressure, rtol=0.1)


def test_power_above_coincidence_needs_the_loss_factor(swept: Path) -> None:
    each = read_runs(swept)[3]
    result = result_file.load(each.folder / "result.h5")
    lossy, unknown = (
        hear("run", {}, each.folder, each.scene.with_({"plate.loss_factor": loss}), result)
        for loss in (0.1, None)
    )
    assert lossy is not None and unknown is not None
    assert unknown.summary["plate_power_third_octave_db"]["16000"] is None
    louder = open_run(each.folder).summary["plate_power_third_octave_db"]["16000"]
    quieter = lossy.summary["plate_power_third_octave_db"]["16000"]
    # Ten times the loss factor: ten decibels less, less where air takes some of the power.
    assert 6 < louder - quieter < 10.5
    assert np.array_equal(lossy.sound.pressure, unknown.sound.pressure)


MOVING = [
    "dynamics.release=true",
    "rolling.speed_m_s=0.6",
    "surface.roughness_ra_um=0.02",
    "rolling.distance_mm=0.4",
]


@pytest.mark.law("Vibration: a march under the moving load has the approach of the motion.")
def test_release_under_the_moving_load(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "s.yaml").write_text(TEXT)
    out = tmp_path / "out"
    run(tmp_path / "s.yaml", MOVING, out, wanted=ALONE)
    stored = open_run(out)
    moving = stored.result.moving[moving_key(stored.scene)]
    # The load moves by a tenth and more, and the approach with it.
    assert moving.force.min() < 0.9 < 1.1 < moving.force.max()
    fluctuation = np.std(moving.approach)
    assert fluctuation > 1.2 * np.std(stored.series["approach"])
    assert stored.summary["force_law_error_m"] < 0.03 * fluctuation
    assert stored.summary["moving_release_balance_error"] < 1e-12
    # Over a lap the surface takes up what it gives back.
    loading, release = (moving.steps[f"{kind}_energy"].sum() for kind in ("loading", "release"))
    assert loading == pytest.approx(release, rel=1e-3)
    keys = {caveat["key"] for caveat in stored.summary["caveats"]}
    assert "moving_load_release" in keys and "constant_load_release" not in keys
    # Another speed moves the load otherwise: its release takes one more march, or is left out.
    other, still = tmp_path / "other", tmp_path / "still"
    capsys.readouterr()
    with progress.begin(progress.Level.NORMAL):
        resound(out, ["rolling.speed_m_s=0.5"], other, wanted=ALONE)
    assert "release under the moving load: one march, about" in capsys.readouterr().err
    slower = open_run(other)
    of_other = slower.result.moving[moving_key(slower.scene)]
    assert not np.allclose(of_other.force, moving.force, atol=1e-3)
    assert slower.summary["force_law_error_m"] < 0.03 * np.std(of_other.approach)
    changes = ["rolling.speed_m_s=0.3", "dynamics.release=false"]
    with progress.begin(progress.Level.NORMAL):
        resound(out, changes, still, wanted=ALONE)
    assert "moving load" not in capsys.readouterr().err
    numbers = json.loads((still / "summary.json").read_text())
    assert "force_law_error_m" not in numbers
    assert "constant_load_release" in {caveat["key"] for caveat in numbers["caveats"]}


def test_runs_that_are_tasks_tell_their_releases(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A sweep of many runs, a part of it and a cluster say so before they start as well."""
    monkeypatch.setattr(run_tasks, "_work", lambda *_: Outcome())
    held = cast(Claim, None)  # it marks runs that fail, and none is solved here
    still = loads(TEXT, ["dynamics.release=false"])
    runs = [
        Run({"surface.seed": seed}, scene, tmp_path / str(seed))
        for seed, scene in enumerate([loads(TEXT, MOVING), loads(TEXT, MOVING), still])
    ]
    with progress.begin(progress.Level.NORMAL):
        run_tasks.solve(held, runs, replace(ALONE, pictures=False), False)
    assert "release under the moving load: 2 marches, about" in capsys.readouterr().err
    with progress.begin(progress.Level.NORMAL):
        run_tasks.solve(held, runs, replace(ALONE, pictures=False), False, [2])
    assert "moving load" not in capsys.readouterr().err


def test_a_killed_march_under_the_moving_load_goes_on() -> None:
    scene = loads(TEXT, MOVING)
    result = solved(scene)
    moving = result.moving[moving_key(scene)]
    whole = moving.steps["release_energy"].copy()
    moving.steps["release_energy"][:] = np.nan
    assert moving_release.is_missing(scene, result)
    assert not solving.solve([scene], [result], 1, "again", progress=False).failures
    assert np.array_equal(moving.steps["release_energy"], whole)


def test_a_release_that_is_heard_is_of_the_moving_load() -> None:
    """`source: release` computes it; `release: false` leaves it out and marks the series."""
    heard = [key for key in MOVING if not key.startswith("dynamics")] + ["sound.source=release"]
    moved = simulate(loads(TEXT, heard), 1, False)
    still = simulate(loads(TEXT, [*heard, "dynamics.release=false"]), 1, False)
    keys = [{each["key"] for each in run.summary["caveats"]} for run in (moved, still)]
    assert "moving_load_release" in keys[0] and "constant_load_release" in keys[1]
    assert moved.sound.power_rms > 1.02 * still.sound.power_rms
    tree = still.to_xarray()
    assert tree["release_energy"].attrs["comment"] == "under the constant load"
    assert np.array_equal(moved.series["release_energy"], still.series["release_energy"])


@pytest.mark.parametrize(
    ("surface", "speed", "words"),
    [
        ("{kind: file, path: waves.npy, spacing_um: 2}", "[[0, 0.5], [6e-4, 0.6]]", "more than"),
        ("{kind: gaussian, roughness_ra_um: 0.2, correlation_length_um: 10, spacing_um: 2,"
         " width_um: 160, seed: 3}", "1", "loses contact"),
    ],
)  # fmt: skip
def test_a_release_without_a_load_is_of_the_constant_load(
    surface: str, speed: str, words: str, tmp_path: Path
) -> None:
    waves = 2e-8 * np.cos(2 * np.pi * np.arange(80) / 40)
    np.save(tmp_path / "waves.npy", np.tile(waves[:, None], (1, 80)))
    changes = ["dynamics.release=true", "rolling.distance_mm=0.32", f"rolling.speed_m_s={speed}"]
    (tmp_path / "s.yaml").write_text(
        "\n".join([*TEXT.splitlines()[:4], f"surface: {surface}", *TEXT.splitlines()[6:]])
    )
    run = simulate(read_scene(tmp_path / "s.yaml", changes), 1, False)
    caveats = {each["key"]: each["text"] for each in run.summary["caveats"]}
    assert words in caveats["no_moving_release"]
    assert "force_law_error_m" not in run.summary
    again = open_run(run.save(tmp_path / "run", report=False))
    assert {each["key"]: each["text"] for each in again.summary["caveats"]} == caveats


def test_a_sphere_that_gets_faster_passes_each_place_under_one_load() -> None:
    """A record of one pass has a release under the moving load, whether it repeats or not."""
    faster = "rolling.speed_m_s=[[0, 0.5], [4e-4, 0.8]]"
    scene = loads(TEXT, [*MOVING[:1], *MOVING[2:], faster, "rolling.distance_mm=0.25"])
    run = simulate(scene, 1, False)
    moving = run.result.moving[moving_key(scene)]
    assert not moving.repeats and moving.complete and not moving.fault
    assert moving.law_error < 0.05 * np.std(moving.approach)
    assert run.vibration is not None
    motion = run.vibration.motion
    positions = np.arange(1, len(moving.force) - 1) * run.result.step
    between = np.interp(positions, motion.position_m, motion.force_n)
    assert np.allclose(moving.force[1:-1], between, rtol=0, atol=0.01)


@pytest.mark.parametrize("faster", [[], ["rolling.speed_m_s=[[0, 0.5], [4e-4, 0.8]]"]])
@pytest.mark.parametrize("samples", [0, 1, 5])
def test_a_sphere_that_stays_has_the_constant_load(
    samples: int, faster: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A spline needs two positions; a sphere at rest, or faster than its motion, has fewer."""
    once = [*MOVING[:1], *MOVING[2:], "rolling.distance_mm=0.25"]
    scene = loads(TEXT, [*once, *faster] if faster else MOVING)
    result = Result.empty(scene.track, scene.start)
    still = SimpleNamespace(
        settled=True,
        flight_share=0.0,
        force_n=np.full(samples, 1.0),
        approach_m=np.full(max(samples, 1), 2e-7),
        position_m=np.zeros(samples),
    )
    marched = SimpleNamespace(marched=None)
    monkeypatch.setattr(force_law, "loads_of", lambda *_: marched)
    monkeypatch.setattr(force_law, "force_law", lambda *_: None)
    monkeypatch.setattr(of_scene, "motion", lambda *_: still)
    moving = moving_release.load_along(scene, result)
    assert not moving.fault and moving.repeats
    np.testing.assert_array_equal(moving.force, np.full(result.solved_steps + 1, scene.load))
    np.testing.assert_array_equal(moving.motion_approach, np.full(result.solved_steps + 1, 2e-7))


def test_the_check_counts_the_steps_in_a_period() -> None:
    slow = check_scene(loads(TEXT, [*MOVING, "rolling.speed_m_s=0.1"]), False).runs[0].findings
    fast = check_scene(loads(TEXT, MOVING), False).runs[0].findings
    warnings = [{each.key: each.warning for each in run}["moving_release"] for run in (slow, fast)]
    assert "steps in a period of the resonance" in str(warnings[0]) and warnings[1] is None


def test_memory_counts_the_time_steps() -> None:
    """Twenty seconds have millions of time steps, for which there is no room everywhere."""
    long = ["rolling.distance_mm=20", "rolling.speed_m_s=0.001"]
    plain = [*long, "dynamics=", "sound=", "plate.thickness_mm=", "plate.loss_factor="]
    sizes = [demand.size(loads(TEXT, keys), 6e-8) for keys in (long, plain)]
    assert [size.times > 5e6 for size in sizes] == [True, False]
    alone, still = (demand.demand([size], 1).memory.total for size in sizes)
    assert alone - still > 150 * sizes[0].times
    run = simulate(loads(TEXT), 1, False)
    assert run.vibration is not None
    steps = len(run.vibration.motion.force_n)
    assert demand.size(loads(TEXT), 6e-8).times == pytest.approx(steps, rel=0.1)
