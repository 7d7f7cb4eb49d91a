"""Passes over a plate that remembers: keys, identity, numbers, files, figure and page."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from finished import run_of, same
from helpers import march_all
from memory_scenes import MEMORY

import rolling as rc
from acoustics import wav
from rolling import cli
from rolling.check import cost, refusals
from rolling.marches.piece import contact_identity
from rolling.report.report_page import page
from rolling.results.listening import PASS_S, PAUSE_S
from rolling.results.run_result import Run
from rolling.scene.file import loads
from rolling.scene.messages import SceneError

SMOOTH = "allowed with plate.plasticity: permanent"


@pytest.fixture(scope="module")
def run() -> Run:
    return run_of(loads(MEMORY))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (("numerics.edges=blended",), f'numerics.edges: got "blended", {SMOOTH}: "sharp"'),
        (("numerics.subcells=2",), f"numerics.subcells: got 2, {SMOOTH}: 1; nodes sink"),
        (("numerics.error_estimate=true",), f"error_estimate: got true, {SMOOTH}: false"),
        (("plate.hardness_gpa=",), "plate.hardness_gpa: missing; plasticity: permanent needs it"),
        (("plate.plasticity=memoryless",), "rolling.passes: got 2, which needs plate.plasticity"),
        (("rolling.passes=0",), "rolling.passes: got 0, allowed: greater than or equal to 1"),
        (("rolling.passes=101",), "rolling.passes: got 101, allowed: less than or equal to 100"),
        (
            ("sphere.surface={kind: graded, grade: G10, seed: 1}",),
            'plate.plasticity: got "permanent", which only goes with a smooth sphere',
        ),
    ],
)
def test_refused_scenes(changes: tuple[str, ...], message: str) -> None:
    with pytest.raises(SceneError, match=re.escape(message)):
        loads(MEMORY, changes)


def test_steps_that_interleave_on_a_file_are_refused(tmp_path: Path) -> None:
    """Steps of 3 nodes go round 64 nodes three times before they repeat."""
    np.save(tmp_path / "heights.npy", np.random.default_rng(1).normal(0, 1e-7, (64, 64)))
    surface = f"surface: {{kind: file, path: {tmp_path}/heights.npy, spacing_um: 2}}"
    text = re.sub(r"surface: {.*?}", surface, MEMORY, flags=re.S)
    scene = loads(text, ("numerics.step_nodes=3",))
    with pytest.raises(SceneError, match=r"got 3, .* a divisor of the 64 nodes"):
        refusals.refuse(scene)
    refusals.refuse(loads(text, ("numerics.step_nodes=2",)))


def test_identity() -> None:
    """Memory and passes change the march; to say the default changes nothing."""
    scene = loads(MEMORY)
    plain = scene.with_(plasticity=None, passes=None)
    spoken = scene.with_(plasticity="memoryless", passes=1)
    assert contact_identity(plain) == contact_identity(spoken)
    single = contact_identity(scene.with_(passes=None))
    assert single == contact_identity(scene.with_(passes=1))
    assert len({contact_identity(plain), single, contact_identity(scene)}) == 3
    assert (
        "plasticity" not in plain.to_dict()["plate"] and "passes" not in plain.to_dict()["rolling"]
    )
    ratio = cost.expected_seconds(scene) / cost.expected_seconds(plain)
    assert ratio == pytest.approx(2 * (1 + cost.RUN_IN_SHARE))


def test_numbers(run: Run) -> None:
    """The last pass is the run itself."""
    passes = run.numbers.passes
    numbers = run.numbers
    assert len(passes) == 2
    last = passes[-1]
    for of_pass, of_run in (
        (last.laeq_db, numbers.of_record.laeq_db),
        (last.level_db, numbers.of_record.level_db),
        (last.vibration_laeq_db, numbers.vibration.value),
        (last.release_power_mean_w, numbers.energy.release_power_mean_w),
    ):
        assert of_pass == pytest.approx(of_run, rel=1e-12)
    assert passes[0].plastic_work_j > passes[1].plastic_work_j > 0
    assert run.sound.loops and numbers.energy.balance_error < 1e-12
    doubts = {doubt.key: doubt.text for doubt in numbers.doubts}
    assert "without pile-up, hardening or residual stress" in doubts["permanent"]


def test_film_shows_the_last_pass(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its maps release as much as the steps between them; packing rounds to 1e-4."""
    monkeypatch.setattr("rolling.marches.next_pieces.SHARE", 0.3)
    result = march_all(loads(MEMORY), film=True)
    film = result.slow_motion
    series = result.series["release_energy"]
    assert film is not None
    steps = series[film.first : int(film.positions[-1])]
    assert film.release.sum() * film.release_unit == pytest.approx(steps.sum(), rel=1e-3)


def test_files(run: Run, tmp_path: Path) -> None:
    """The stored run is the same, with each pass for the ear and the plate as it was left."""
    saved = rc.simulate(run.scene, workers=1, progress=False).save(tmp_path / "run")
    opened = rc.open_run(saved)
    assert run.result.passes is not None and opened.result.passes is not None
    run.result.passes.before = None  # which is not stored
    assert same(opened.result.passes, run.result.passes)
    assert opened.numbers.passes == run.numbers.passes
    samples, rate, comment = wav.read(saved / "passes.wav")
    assert len(samples) == pytest.approx(2 * (PASS_S + PAUSE_S) * rate, abs=2)
    assert "1 (" in comment and not samples[round(PASS_S * rate) + 9 : round(1.7 * rate)].any()
    tree = opened.to_xarray()
    assert tree["passes/sunk"].attrs["units"] == "m" and tree["passes/depth"].shape == (2,)


def test_a_run_names_its_passes_for_the_ear(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "scene.yaml").write_text(MEMORY)
    words = ["run", str(tmp_path / "scene.yaml"), "--out", str(tmp_path / "run"), "--no-report"]
    assert cli.main([*words, "--workers", "1"]) == 0
    assert f"pass by pass: {tmp_path / 'run' / 'passes.wav'}" in capsys.readouterr().out


def test_check_says_that_a_vibration_waits_for_the_passes() -> None:
    """Two passes still yield, which only the march can tell."""
    table = {finding.key: finding for finding in loads(MEMORY, ("dynamics={}",)).check(solve=False)}
    assert table["running_in"].value.startswith("2 passes; the run is refused")
    assert "running_in" not in {finding.key for finding in loads(MEMORY).check(solve=False)}


def test_figure_and_page(run: Run) -> None:
    ax = rc.plot.running_in(run)
    curves = {line.get_label(): line.get_ydata() for line in ax.lines}
    release = next(
        y for label, y in curves.items() if str(label).startswith("mean released power, ")
    )
    power = [numbers.release_power_mean_w for numbers in run.numbers.passes]
    assert release == pytest.approx([0, 10 * np.log10(power[1] / power[0])])
    html = page([run]).decode()
    assert "Running-in<" in html and "pass by pass" in html and "permanent indentation" in html
    assert "<td>-0.0</td>" not in html  # falls of less than 0.05 dB, of either sign
    with pytest.raises(ValueError, match="its plate has no memory"):
        rc.plot.running_in(run_of(loads(MEMORY, ("plate.plasticity=", "rolling.passes="))))
