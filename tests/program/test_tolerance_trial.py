"""The tolerance that a run chooses: its rule, its trial, and where the number stands."""

import json
import os
import signal
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from scene_text import BODIES, NARROW

from rolling import cli
from rolling.check import error_cost, tolerance
from rolling.check.findings import findings
from rolling.commands import Wanted, resound, resume, run
from rolling.commands.interface import open_run, simulate, simulate_sweep
from rolling.contact.solver import ContactError
from rolling.folders import run_record
from rolling.folders.files import FolderError
from rolling.report import text
from rolling.scene.file import loads, read_scene
from rolling.scene.scene import Scene
from rolling.simulation import (
    _result_reading,
    batch,
    chosen_tolerances,
    error_stretches,
    tolerance_trial,
)
from rolling.simulation.error_stretches import Grid, march_grid
from rolling.simulation.result import Result
from rolling.simulation.simulate import Order
from rolling.simulation.stretches import March, Trial

NO_PICTURES = Wanted(workers=1, pictures=False)
TEXT = f"""\
name: light
{BODIES}{NARROW}\
rolling: {{load_n: 0.05, speed_m_s: 0.1, duration_s: 0.04}}
"""
SWEEP = TEXT + "sweep: {rolling.load_n: [0.02, 0.05]}\n"
SHORT = ["rolling.duration_s=0.002"]


def chosen_of(scene: Scene, workers: int = 1) -> tuple[Scene, Trial]:
    """Choose the tolerance of a scene."""
    result = Result.empty(scene.track, scene.start)
    (pinned,) = tolerance_trial.choose([scene], [result], workers, False).scenes
    assert result.trial is not None and pinned.tolerance == result.trial.tolerance
    return pinned, result.trial


@pytest.fixture
def marches(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[tuple[str, int]]]:
    """Collect the marches of trials in this process."""
    made: list[tuple[str, int]] = []
    inner = error_stretches.contact_on

    def counted(scene: Scene, grid: Grid, first: int, steps: int) -> object:
        made.append((grid.name, first))
        return inner(scene, grid, first, steps)

    monkeypatch.setattr(error_stretches, "contact_on", counted)
    yield made


@pytest.fixture
def few_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let tracks of a hundred steps have trials."""
    monkeypatch.setattr(tolerance, "SHORT_STEPS", 100)
    monkeypatch.setattr(tolerance, "STRETCH_STEPS", (20, 20))


def written(tmp_path: Path, text: str = TEXT) -> Path:
    path = tmp_path / "s.yaml"
    path.write_text(text)
    return path


def summary(folder: Path) -> dict[str, Any]:
    numbers: dict[str, Any] = json.loads((folder / "summary.json").read_text())
    return numbers


# ---- the rule


def test_the_loosest_tolerance_with_the_distance_is_chosen() -> None:
    """At -29 dB from the grid the solver's error is wanted at -49 dB or less."""
    first_order = {1e-5: -70.0, 1e-3: -30.0}
    assert tolerance.choice(-29.0, first_order) == 1e-4  # -49 dB at 1.1e-4
    assert tolerance.choice(-30.1, first_order) == 5e-5  # -50.1 dB
    assert tolerance.choice(-5.0, first_order) == tolerance.MOST
    assert tolerance.choice(-80.0, first_order) == tolerance.LEAST  # -97 dB at 4.5e-7


def test_the_choice_keeps_its_limits_and_the_distance() -> None:
    for grid in range(-130, 20):
        for low, high in ((-70.0, -30.0), (-50.0, -10.0), (-46.0, -13.0), (-300.0, -300.0)):
            solver = {1e-5: low, 1e-3: high}
            chosen = tolerance.choice(grid, solver)
            assert tolerance.LEAST <= chosen <= tolerance.MOST
            kept = tolerance.solver_error_db(chosen, solver) <= grid - tolerance.BELOW_DB
            assert kept or chosen == tolerance.LEAST


def test_short_and_smooth_tracks_have_no_trial(marches: list[tuple[str, int]]) -> None:
    smooth = TEXT.replace("kind: gaussian", "kind: smooth").replace("  seed: 3\n", "")
    for line in ("  roughness_ra_um: 0.1\n", "  correlation_length_um: 10\n"):
        smooth = smooth.replace(line, "")
    cases = ((TEXT, SHORT, 1e-4), (smooth, [], 3e-5), (smooth, SHORT, 1e-4))
    for content, overrides, number in cases:
        pinned, trial = chosen_of(loads(content, overrides))
        assert pinned.numerics.tolerance == number and trial.reason and trial.stretches == 0
    assert not marches


def test_a_number_pins_the_tolerance(marches: list[tuple[str, int]]) -> None:
    scene = loads(TEXT, ["numerics.tolerance=3e-4"])
    result = Result.empty(scene.track, scene.start)
    assert tolerance_trial.choose([scene], [result], 1, False).scenes == [scene]
    assert result.trial is None and not marches


@pytest.mark.parametrize("steps", [2000, 2500, 25000, 60000, 500000])
def test_a_trial_costs_two_percent_of_a_run_of_25000_steps(steps: int) -> None:
    """A shorter track pays for the least trial; stretches lie on the track without overlap."""
    scene = loads(TEXT, [f"rolling.duration_s={steps * 2e-5}"])
    assert scene.track.solved_steps == steps
    stretches = tolerance.layout(scene)
    assert 2 <= len(stretches.firsts) <= 4 and 16 <= stretches.steps <= 60
    assert tolerance.cost(scene) <= max(tolerance.LEAST_BUDGET, 0.016 * steps)
    assert tolerance.cost(scene) > error_cost.START_STEPS * 8
    firsts = sorted(stretches.firsts)
    assert firsts[0] >= 0 and firsts[-1] + stretches.steps <= steps
    assert min(np.diff(firsts)) >= stretches.steps


# ---- the trial


@pytest.mark.parametrize(
    "overrides",
    [[], ["plate.hardness_gpa="], ["surface.roughness_ra_um=0.01", "rolling.load_n=0.5"]],
    ids=["yielding", "elastic", "gentle"],
)
def test_the_solver_stays_below_the_grid_on_other_stretches(overrides: list[str]) -> None:
    scene, trial = chosen_of(loads(TEXT, overrides))
    assert trial.grid_signal_db is not None and trial.solver_signal_db is not None
    grids = (
        Grid("own", 1.0, scene.tolerance),
        Grid("tight", 1.0, scene.tolerance / 100),
        Grid("fine", 0.5, max(scene.tolerance / 30, 1e-7)),
    )
    firsts = [scene.track.solved_steps * k // 8 for k in (1, 3, 5, 7)]
    own, tight, fine = (
        np.array(
            [
                march_grid(scene, grid, first, 40, Order(), lambda: False, lambda _: None).release
                for first in firsts
            ]
        )
        for grid in grids
    )
    solver, grid = (
        20 * np.log10(np.std(difference) / np.std(tight))
        for difference in (own - tight, fine - tight)
    )
    assert solver <= grid - tolerance.BELOW_DB
    assert grid == pytest.approx(trial.grid_signal_db, abs=8)  # two stretches of 18 steps


def test_the_choice_is_the_same_for_any_number_of_workers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tolerance_trial, "WORTH_PROCESSES", 0.0)
    one, two = (chosen_of(loads(TEXT), workers)[1] for workers in (1, 2))
    assert (one.tolerance, one.grid_signal_db, one.solver_signal_db) == (
        two.tolerance,
        two.grid_signal_db,
        two.solver_signal_db,
    )


def test_heights_that_do_not_fluctuate_leave_the_default(tmp_path: Path, few_steps: None) -> None:
    np.save(tmp_path / "flat.npy", np.zeros((120, 64)))
    start, end = TEXT.index("surface:"), TEXT.index("rolling:")
    text = f"{TEXT[:start]}surface: {{kind: file, path: flat.npy, spacing_um: 2}}\n{TEXT[end:]}"
    pinned, trial = chosen_of(loads(text, folder=tmp_path))
    assert pinned.tolerance == 3e-5 and "does not fluctuate" in trial.reason


def test_a_stretch_that_fails_is_left_out_and_a_trial_that_fails_is_named() -> None:
    release = np.random.default_rng(1).normal(1.0, 0.1, 30)

    def marched(first: int, level: str, error: float, fault: str = "") -> March:
        noise = np.random.default_rng(2).normal(0.0, error, 30)
        values = np.full(30, np.nan) if fault else release + noise
        return March(first, level, values, 0.0, 1.0, fault)

    errors = {"fine": 5e-3, "tight": 0.0, "middle": 1e-5, "loose": 1e-3}
    good = [marched(0, level, error) for level, error in errors.items()]
    bad = [
        marched(30, level, error, "tight: no solution" if level == "tight" else "")
        for level, error in errors.items()
    ]
    trial = tolerance_trial.trial_of([*good, *bad])
    assert trial.stretches == 1 and trial.tolerance == 5e-4  # -26 dB, wanted -46 dB; -40 at 1e-3
    failed = tolerance_trial.trial_of(bad)
    assert failed.tolerance == 1e-4 and failed.reason == "the trial failed: tight: no solution"


def test_a_run_whose_trial_fails_takes_the_default(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> object:
        raise ContactError("no contact")

    monkeypatch.setattr(tolerance_trial.error_stretches, "march_grid", refuse)
    pinned, trial = chosen_of(loads(TEXT))
    assert pinned.tolerance == 1e-4 and trial.reason == "the trial failed: no contact"


# ---- the number in folders


def test_the_number_stands_in_the_folder_and_is_never_tried_again(
    tmp_path: Path, few_steps: None, marches: list[tuple[str, int]]
) -> None:
    path = written(tmp_path, TEXT.replace("0.04}", "0.004}"))
    run(path, out=tmp_path / "out", wanted=NO_PICTURES)
    tried = len(marches)
    numbers = summary(tmp_path / "out")
    resolved = read_scene(tmp_path / "out" / "resolved.yaml")
    assert tried == 8 and numbers["tolerance_chosen"]
    assert numbers["tolerance"] == resolved.numerics.tolerance
    trial = numbers["tolerance_trial"]
    assert trial["stretches"] == 2 and trial["solver_signal_db"] < trial["grid_signal_db"] - 14
    assert "numerics" not in (tmp_path / "out" / "scene.yaml").read_text()
    told = " ".join(map(str, text.assumptions([open_run(tmp_path / "out")])))
    assert f"tolerance {resolved.tolerance:g} (chosen by a trial of 2 stretches" in told
    # All later commands take the number.
    assert open_run(tmp_path / "out").summary["tolerance_trial"] == trial
    resume(tmp_path / "out", wanted=NO_PICTURES)
    resound(tmp_path / "out", ["sound.distance_m=2"], out=tmp_path / "far", wanted=NO_PICTURES)
    assert summary(tmp_path / "far")["tolerance_trial"] == trial
    (tmp_path / "out" / "result.h5").unlink()
    resume(tmp_path / "out", wanted=NO_PICTURES)
    assert len(marches) == tried
    assert summary(tmp_path / "out")["tolerance"] == resolved.tolerance


def test_an_interrupted_trial_is_gone_on_with(
    tmp_path: Path, few_steps: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, out = written(tmp_path, TEXT.replace("0.04}", "0.004}")), tmp_path / "out"
    inner = error_stretches.march_grid

    def stopping(*arguments: Any) -> March:
        os.kill(os.getpid(), signal.SIGINT)
        return inner(*arguments)

    with monkeypatch.context() as patch:
        patch.setattr(error_stretches, "march_grid", stopping)
        assert run(path, out=out, wanted=NO_PICTURES).exit_code == 130
    assert read_scene(out / "resolved.yaml").numerics.tolerance == "auto"
    assert not (out / "result.h5").exists()
    assert resume(out, wanted=NO_PICTURES).exit_code == 0
    assert summary(out)["tolerance_chosen"]


@pytest.mark.parametrize("brief", [False, True], ids=["whole folders", "four files"])
def test_each_run_of_a_sweep_has_its_own(
    tmp_path: Path,
    few_steps: None,
    marches: list[tuple[str, int]],
    monkeypatch: pytest.MonkeyPatch,
    brief: bool,
) -> None:
    if brief:
        monkeypatch.setattr("rolling.check.demand.PAGE_RUNS", 1)
    path, out = written(tmp_path, SWEEP.replace("0.04}", "0.004}")), tmp_path / "out"
    run(path, out=out, wanted=NO_PICTURES)
    tried = len(marches)
    folders = sorted(child for child in out.iterdir() if child.is_dir())
    numbers = [summary(folder) for folder in folders]
    assert tried == 16 and len(numbers) == 2 and all(each["tolerance_chosen"] for each in numbers)
    assert read_scene(out / "resolved.yaml").numerics.tolerance == "auto"
    assert (folders[0] / "resolved.yaml").exists() != brief
    for folder, each in zip(folders, numbers, strict=True):
        assert open_run(folder).scene.numerics.tolerance == each["tolerance"]
    resume(out, wanted=NO_PICTURES)
    resume(folders[1], wanted=NO_PICTURES)
    resound(out, ["sound.distance_m=2"], out=tmp_path / "far", wanted=NO_PICTURES)
    again = [summary(tmp_path / "far" / folder.name) for folder in folders]
    assert [each["tolerance_trial"] for each in again] == [
        each["tolerance_trial"] for each in numbers
    ]
    # A run of the sweep that lost its result takes its own number again, if its folder has it.
    (folders[0] / "result.h5").unlink()
    (folders[0] / "run.json").write_text(
        (folders[0] / "run.json").read_text().replace('"done"', '"waiting"')
    )
    resume(out, wanted=NO_PICTURES)
    assert len(marches) == tried
    assert summary(folders[0])["tolerance"] == numbers[0]["tolerance"]


@pytest.mark.parametrize(
    ("sweep", "killed"),
    [
        *(("", killed) for killed in ("write_bytes", "keep", "identify")),
        ("whole", "write_bytes"),
        ("whole", "keep"),
        ("brief", "identify"),
    ],
)
@pytest.mark.parametrize("seconds", [0.004, 0.0018], ids=["tried", "too short to try"])
def test_a_kill_before_the_first_result_does_not_forget_who_chose(
    killed: str,
    sweep: str,
    seconds: float,
    tmp_path: Path,
    few_steps: None,
    marches: list[tuple[str, int]],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The record has the choice before scene and result have it."""
    if sweep == "brief":
        monkeypatch.setattr("rolling.check.demand.PAGE_RUNS", 1)
    text = (SWEEP if sweep else TEXT).replace("0.04}", f"{seconds}}}")
    path, out = written(tmp_path, text), tmp_path / "out"

    def kill(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    alone = replace(NO_PICTURES, workers=1)
    with monkeypatch.context() as patch, suppress(KeyboardInterrupt):
        patch.setattr(chosen_tolerances if killed == "write_bytes" else batch, killed, kill)
        run(path, out=out, wanted=alone)
    chosen = [path.parent for path in out.rglob("run.json") if run_record.read(path.parent).trial]
    assert chosen and not [*out.rglob("result.h5")]
    tried = len(marches)
    assert resume(out, wanted=alone).exit_code == 0
    runs = [path.parent for path in out.rglob("summary.json")]
    assert len(runs) == (2 if sweep else 1)
    assert all(summary(folder)["tolerance_chosen"] for folder in runs)
    # A run that had its number is not tried again.
    again = 8 * (len(runs) - len(chosen)) if seconds > 0.002 else 0
    assert len(marches) == tried + again


def test_a_damaged_record_of_a_trial_is_named(tmp_path: Path) -> None:
    record = run_record.new("run")
    for trial in ({"tolerance": "loose", "reason": ""}, {"tolerance": 1e-4}):
        run_record.write(tmp_path, replace(record, trial=trial))
        with pytest.raises(FolderError, match=r"run\.json: damaged: trial\.(tolerance|reason): "):
            chosen_tolerances.recorded_trial(tmp_path)


def test_a_sweep_over_the_tolerance_pins_it(
    tmp_path: Path, few_steps: None, marches: list[tuple[str, int]]
) -> None:
    text = TEXT.replace("0.04}", "0.004}") + "sweep: {numerics.tolerance: [1.0e-3, 1.0e-5]}\n"
    runs = simulate_sweep(loads(text), workers=1, progress=False)
    assert [each.summary["tolerance"] for each in runs.values()] == [1e-3, 1e-5]
    assert not any(each.summary["tolerance_chosen"] for each in runs.values()) and not marches


def test_a_run_in_memory_chooses_its_number(few_steps: None) -> None:
    finished = simulate(loads(TEXT, ["rolling.duration_s=0.004"]), workers=1, progress=False)
    assert finished.scene.numerics.tolerance == finished.summary["tolerance"]
    assert finished.summary["tolerance_trial"]["steps"] == 20


def test_a_damaged_trial_is_named(tmp_path: Path) -> None:
    values = vars(Trial(1e-4, "", 2, 24, -20.0, -40.0, 1.5))
    for change in ({"tolerance": "loose"}, {"steps": 2.5}, {"reason": None}):
        with h5py.File(tmp_path / "bare.h5", "w") as file:
            file.attrs["tolerance_trial"] = json.dumps(values | change)
            match = f"tolerance_trial: got .* for {next(iter(change))}"
            with pytest.raises(ValueError, match=match):
                _result_reading._trial(file)


def test_check_says_what_will_be_tried(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told = {each.key: each for each in findings(loads(TEXT))}["tolerance"]
    assert told.value.startswith("auto: a trial before the run chooses it from 1e-06 to 0.001")
    assert told.seconds > 0
    short = {each.key: each for each in findings(loads(TEXT, SHORT))}["tolerance"]
    assert short.value.startswith("0.0001 (auto, no trial: the track has 100 different steps")
    pinned = findings(loads(TEXT, ["numerics.tolerance=2e-5"]))
    assert {each.key: each for each in pinned}["tolerance"].value == "2e-05"
    assert cli.main(["check", str(written(tmp_path)), "--fast"]) == 0
    assert "auto: a trial before the run" in capsys.readouterr().out
