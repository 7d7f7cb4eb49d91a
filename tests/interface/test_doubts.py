"""Each doubt stands where it applies and nowhere else, and the worst is the verdict."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from finished import VIBRATING, doubt_lines, marched
from made_numbers import bands, changed, computed, released, run_with
from scene_sounds import sound_of_release
from scene_text import PLAIN, TINY

from acoustics.bands import BAND_NAMES
from rolling.check import level_doubts
from rolling.check.findings import check_run, check_scene, conclusion
from rolling.numbers.ball_numbers import RunNumbers
from rolling.numbers.doubt import Doubt, Severity, severity_of
from rolling.numbers.quantity import Quantity, Verdict, worst_of
from rolling.results import notes, run_doubts, run_lines, verdict
from rolling.results.run_quantities import judged
from rolling.results.run_result import Run
from rolling.scene.file import loads
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.sound.contact_sound import ContactSound
from rolling.sound.vibration_sound import Vibration
from rolling.terminal import streams

STEP = 2e-6  # 0.1 m/s: 50,000 steps a second
ALWAYS = {"unvalidated", "uncertainty", "quasi_static"}


def scene_of(seconds: float, *overrides: str) -> Scene:
    return loads(PLAIN.replace("duration_s: 0.01", f"duration_s: {seconds}"), overrides)


def sound_of(scene: Scene, closed: bool = True, noise: float = 0.1) -> ContactSound:
    steps = round(scene.motion.distance(scene.rolling.duration_s) / STEP)
    share = noise * np.random.default_rng(1).standard_normal(steps)
    return sound_of_release(scene, np.full(steps, 1e-9) * (1.0 + share), STEP, closed)


def said(
    seconds: float, *overrides: str, closed: bool = True, noise: float = 0.1
) -> dict[str, str]:
    """Return the lines of the standing doubts, and of the solver, by key."""
    scene = scene_of(seconds, *overrides)
    sound = sound_of(scene, closed, noise)
    listed = run_doubts.doubts(scene, sound, released(sound.levels.laeq_db))
    kept = (*notes.HEADLINE, "solver")
    return {x.key: x.line for x in listed if x.severity is Severity.NOTE or x.key in kept}


# ---- notes


def test_each_note_stands_where_it_applies_and_nowhere_else() -> None:
    long = said(0.5)
    assert set(long) == ALWAYS | {"upper_bound"}
    assert "26 to 70 dB above the vibration" in long["upper_bound"]
    assert "microphone" in long["unvalidated"] and "covers the length" in long["uncertainty"]
    half = said(0.5, "sound.q=0.5")
    assert set(half) == ALWAYS | {"assumed_q"} and "0.5" in half["assumed_q"]
    fixed = said(0.5, "sound.gain_pa_per_w_m2=3")
    assert set(fixed) == ALWAYS | {"upper_bound", "fixed_gain"}
    assert "3 Pa per W/m²" in fixed["fixed_gain"]
    assert fixed["upper_bound"].startswith("The steady level")  # the gain decides the others
    assert set(said(0.5, closed=False)) == ALWAYS | {"upper_bound", "not_loopable"}
    braking = said(0.5, "rolling.speed_m_s=[[0, 0.1], [1, 0.2]]")
    assert "not_loopable" in braking and "short_loop" not in braking


def test_silence_has_no_level_to_bound_and_no_pitch() -> None:
    silent = said(0.03, noise=0.0)
    assert "short_loop" not in silent and silent["upper_bound"].startswith("The steady level")
    # The surface is rough: whether it is silent a tighter solve would tell.
    assert "counts as silent" in silent["solver"] and "numerics.tolerance" in silent["solver"]


def test_a_perfectly_smooth_contact_has_no_sound_that_the_solver_could_hide() -> None:
    smooth = "surface={kind: smooth, spacing_um: 2, width_um: 160}"
    assert "solver" not in said(0.03, smooth, noise=0.0)


@pytest.mark.parametrize(("seconds", "rate"), [(0.03, "33"), (0.29, "3.4"), (0.31, None)])
def test_a_loop_that_is_heard_as_a_pitch_says_which(seconds: float, rate: str | None) -> None:
    """A record of 0.03 s repeats 33 times a second; from 0.3 s on there is no note."""
    looped = said(seconds)
    assert ("short_loop" in looped) == (rate is not None)
    assert rate is None or f"repeats {rate} times a second" in looped["short_loop"]
    assert ("short_loop" in said(seconds, closed=False)) == (rate is not None)


def test_a_short_track_gone_round_many_times_says_its_pitch(tmp_path: Path) -> None:
    """100 laps of 3 ms sound at 333 Hz, looped or not."""
    waves = 1e-8 * np.cos(2 * np.pi * np.arange(150) / 10)
    np.save(tmp_path / "waves.npy", np.tile(waves[:, None], (1, 64)))
    text = TINY.replace("0.0005}", "0.3}")
    begin = text.index("surface:")
    end = text.index("rolling:")
    surface = f"surface: {{kind: file, path: {tmp_path}/waves.npy, spacing_um: 2}}\n"
    texts = doubt_lines(marched(text[:begin] + surface + text[end:]))
    assert "every 0.003 s, 333 times a second" in texts["short_track"]
    assert "short_loop" not in texts


@pytest.mark.parametrize(("thickness", "bent"), [(0.9, True), (1.1, False), (None, False)])
def test_a_plate_that_bends_by_a_tenth_of_its_thickness(
    thickness: float | None, bent: bool
) -> None:
    """It moves by 0.1 mm: from -0.04 to 0.06 mm."""
    scene = scene_of(0.01, "dynamics={}", "sphere.density_kg_m3=7850", "plate.density_kg_m3=7850")
    scene = scene.with_({"plate.thickness_mm": thickness})
    motion = SimpleNamespace(
        plate_m=np.array([0.0, -4e-5, 6e-5]), outside_share=0.0, flight_share=0.0, settled=True
    )
    law = SimpleNamespace(load_n=np.array([10.0, 20.0]))
    vibration = cast(Vibration, SimpleNamespace(motion=motion, law=law))
    listed = run_doubts.doubts(scene, sound_of(scene), released(), vibration)
    texts = {doubt.key: doubt.text for doubt in listed}
    assert ("plate_deflection" in texts) == bent
    assert not bent or "by 0.11 of its thickness" in texts["plate_deflection"]


def test_doubts_of_the_check_stand_after_the_run_too() -> None:
    scene = scene_of(0.03)
    _, before = check_run(scene)
    after = run_doubts.doubts(scene, sound_of(scene), released())
    about = {x.key: x.about for x in after}
    before = [replace(x, about=about.get(x.key, ())) for x in before]
    assert before and set(before) <= set(after)
    assert len({doubt.key for doubt in after}) == len(after)


def test_several_runs_say_each_doubt_once() -> None:
    def numbers(**texts: str) -> RunNumbers:
        return judged(released(), [Doubt(key, x, Severity.NOTE) for key, x in texts.items()])

    runs = [("x", numbers(a="All.")), ("y", numbers(a="All.", b="Of one."))]
    assert verdict.gathered([*runs, ("z", numbers(a="All.", b="Of another."))]) == [
        Doubt("a", "All.", Severity.NOTE),
        Doubt("b", "Of one. (for y; similarly for z)", Severity.NOTE),
    ]


# ---- verdict


@cache
def vibrating() -> Run:
    """Return a run whose vibration the tests change."""
    return marched(VIBRATING, ["plate.loss_factor=0.3", "rolling.load_n=5"])


# A vibration of which all is known, with errors below 1 dB.
KNOWN: dict[str, float | None] = {
    "grid_db": 0.2,
    "grid_uncertainty_db": 0.1,
    "solver_db": -0.1,
    "subgrid_db": 0.3,
    "subgrid_uncertainty_db": 0.1,
}


def verdict_of(
    changes: dict[str, Any], overrides: tuple[str, ...] = (), **motion: float
) -> tuple[Quantity, Verdict]:
    """Return the quantity that leads and its verdict, with other numbers, keys and a motion."""
    run = vibrating()
    assert run.vibration_sound is not None
    calm = {"outside_share": 0.0, "flight_share": 0.0, "settled": True} | motion
    vibration = replace(run.vibration_sound, motion=replace(run.vibration_sound.motion, **calm))
    numbers = known(**changes)
    sound = replace(run.sound, source=numbers.record.source)
    scene = loads(VIBRATING, [*overrides, f"sound.source={sound.source}"])
    found = run_doubts.doubts(scene, sound, numbers, vibration)
    leading = judged(numbers, found).leading
    assert leading.judged is not None
    return leading, leading.judged


def known(source: str = "vibration", spread_db: float = 0.4, **changes: Any) -> RunNumbers:
    """Return numbers of which all is known, with errors below 1 dB, and with changes."""
    own = {"laeq_db": 40.0, "spreads": {"laeq_db": spread_db}}
    if source == "vibration":
        numbers = computed(40.0, levels={"vibration": own}, errors=KNOWN)
    else:
        numbers = released(40.0, levels={"released_power": own}, errors=KNOWN)
    return changed(numbers, changes)


def near_half_space(band: str) -> dict[str, Any]:
    """Return the changes for a ball that is heard in one band."""
    return {"bands": {"vibration_a": bands(dict.fromkeys(BAND_NAMES) | {band: 40.0})}}


def cut_off(error_db: float, uncertainty_db: float) -> dict[str, Any]:
    """Return the changes for a run whose steps end within hearing."""
    band = {"band_db": error_db, "band_uncertainty_db": uncertainty_db, "band_end_hz": 5000.0}
    return {"errors": band}


BESIDE_RELEASE = {
    "source": "release",
    "vibration": Quantity("vibration", 30.0, parts={"record": 0.1}),
    "motion": {"laps": 1.0},
}
HALF_SPACE = ("plate.thickness_mm=", "plate.loss_factor=")
SLOW = ("rolling.speed_m_s=0.02",)
LIGHT = ("rolling.load_n=0.05",)
STEEP = ("surface.roughness_ra_um=2", "numerics.error_estimate=true")


@pytest.mark.parametrize(
    ("changes", "overrides", "motion", "word", "reason"),
    [
        ({}, (), {}, "trust", "length of the record leaves ± 0.4 dB"),
        ({"spread_db": 1.2}, (), {}, "indicative", "length of the record"),
        ({"spread_db": 3.2}, (), {}, "do not quote", "length of the record"),
        (
            {"errors": {"grid_db": -0.9, "grid_uncertainty_db": 0.9}},
            *((), {}, "indicative", "grid"),
        ),
        ({"errors": {"solver_db": -4.0}}, (), {}, "do not quote", "solver leaves 4 dB"),
        ({"errors": {"grid_db": None}}, (), {}, "indicative", "grid is unknown"),
        ({"errors": {"subgrid_db": 5.6}}, (), {}, "do not quote", "below its spacing"),
        (
            {"spread_db": 2.1, "motion": {"comb_spread_db": 2.0}},
            *((), {}, "indicative", "by 2 dB"),
        ),
        (
            {"spread_db": 3.1, "motion": {"comb_spread_db": 2.2}},
            *((), {}, "do not quote", "together leave ± 3.1"),
        ),
        (
            {"motion": {"step_error_db": 4.0}},
            (),
            {},
            "do not quote",
            "the time steps of the motion",
        ),
        (
            {"errors": {"grid_db": None}, "motion": {"force_law_error_db": 4.0}},
            *((), {}, "do not quote", "force law"),
        ),
        # An upper bound is a property of a released power, and no doubt about it.
        (
            {"source": "release", "motion": {"force_law_error_db": 4.0}},
            (),
            {},
            "trust",
            "length of the record",
        ),
        (
            {"source": "release", "motion": {"comb_spread_db": 4.0}},
            (),
            {},
            "trust",
            "length of the record",
        ),
        # A vibration that is computed while the release is measured leads, and has its own errors.
        (BESIDE_RELEASE, (), {}, "indicative", "estimated for the record that is measured"),
        (
            {**BESIDE_RELEASE, "motion": {"comb_spread_db": 4.0}},
            *((), {}, "do not quote", "lies 4 dB (rms) from the mean"),
        ),
        (
            {**BESIDE_RELEASE, "motion": {"force_law_error_db": 4.0}},
            *((), {}, "do not quote", "force law"),
        ),
        ({**BESIDE_RELEASE, "contact_loss_db": -8.0}, (), {}, "do not quote", "leaves 4 dB"),
        (
            {"source": "release", "errors": {"grid_db": 9.0}},
            (),
            {},
            "do not quote",
            "the grid leaves",
        ),
        (
            {"source": "release", "record": {"q": 0.5}},
            ("sound.q=0.5",),
            {},
            "indicative",
            "q = 0.5",
        ),
        ({}, (), {"outside_share": 0.02}, "trust", "extrapolated for 2 %"),
        ({}, (), {"outside_share": 0.51}, "do not quote", "extrapolated for 51 %"),
        ({"record": {"scatter_db": 0.2}}, (), {"flight_share": 0.1}, "indicative", "lost for 10 %"),
        (
            {"record": {"scatter_db": 4.0}},
            (),
            {"flight_share": 0.1},
            "do not quote",
            "lost for 10 %",
        ),
        ({"motion": {"impacts_yield": True}}, (), {}, "do not quote", "impacts would yield"),
        ({}, STEEP, {}, "do not quote", "rms slope: the rms slope is"),
        # The published excess of a half-space is 5.2 dB at 1 kHz m, and 0.5 dB from 10 kHz m on.
        (near_half_space("1000"), HALF_SPACE, {}, "do not quote", "5.2 dB too loud so near"),
        (near_half_space("12500"), HALF_SPACE, {}, "trust", "0.5 dB too loud so near"),
        # A measured error of the grid decides, and not a rule of thumb.
        ({}, LIGHT, {}, "trust", "length of the record"),
        ({"errors": {"grid_db": None}}, LIGHT, {}, "indicative", "nodes per Hertz radius"),
        # The part above the Nyquist frequency of the steps counts by its decibels.
        ({}, SLOW, {}, "indicative", "simulated Nyquist"),
        (cut_off(-8.4, 3.4), SLOW, {}, "do not quote", "8.4 ± 3.4 dB too low"),
        (cut_off(1.5, 0.6), SLOW, {}, "indicative", "1.5 ± 0.6 dB too high"),
        (cut_off(-0.2, 0.1), SLOW, {}, "trust", "length of the record"),
    ],
)
def test_the_worst_doubt_is_the_verdict(
    changes: dict[str, Any],
    overrides: tuple[str, ...],
    motion: dict[str, float],
    word: str,
    reason: str,
) -> None:
    quantity, found = verdict_of(changes, overrides, **motion)
    assert found.worst.severity.word == word and reason in found.worst.text
    # A bound and an assumption keep their own word; the error stands beside it.
    own = {"upper bound": "bound", "assumed": "assumed"}
    assert found.word == own.get(quantity.how, word)


def test_a_check_foresees_that_the_grid_of_a_silent_vibration_is_unknown() -> None:
    for estimate in ("true", "false"):
        keys = ["sound.source=release", f"numerics.error_estimate={estimate}"]
        found = level_doubts.forecasts(loads(VIBRATING, keys), []).leading.judged
        assert found is not None and (found.word, found.worst.key) == ("indicative", "grid")


def test_decibels_decide_the_severity() -> None:
    found = [severity_of(decibels) for decibels in (0.0, -1.0, 1.01, 3.0, -3.01)]
    trust = Severity.TRUST
    indicative = Severity.INDICATIVE
    assert found == [trust, trust, indicative, indicative, Severity.DO_NOT_QUOTE]
    assert worst_of([]).text == "no limit is broken"
    assert worst_of([Doubt("a", "Standing.", Severity.NOTE)]).severity is trust


def test_three_warnings_the_worst_first() -> None:
    listed = [
        Doubt("air_load", "air_load", Severity.TRUST),
        Doubt("nyquist", "nyquist", Severity.INDICATIVE),
        Doubt("step_length", "step_length", Severity.TRUST, 0.6),
        Doubt("slope", "slope", Severity.DO_NOT_QUOTE),
        Doubt("seam", "seam", Severity.INDICATIVE, advice="cut it off"),
    ]
    numbers = judged(known(), listed)
    assert [*numbers.doubts] == listed
    ordered = [doubt.key for doubt in verdict.warnings([("run", numbers)])]
    assert ordered == ["slope", "nyquist", "seam", "step_length", "air_load"]
    runs = [run_with(vibrating().scene, numbers)]
    assert len(" ".join(run_lines.doubt_lines(runs))) < 400
    text = "\n".join(run_lines.further_lines(runs))
    assert text.count("warning: ") == 5 and "warning: seam: cut it off" in text


def test_lines_are_as_wide_as_the_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    text = "warning: " + "word " * 40
    assert streams.wrapped(text) == text  # a pipe, whose reader breaks lines as it likes
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    monkeypatch.setenv("COLUMNS", "60")
    assert max(map(len, streams.wrapped(text).splitlines())) <= 60


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ((), "on the vibration will at best be indicative: a linear chain will estimate it"),
        (("surface.roughness_ra_um=2",), "will be do not quote: rms slope: the rms slope is"),
        (("plate.hardness_gpa=0.001",), "It does not run: capacity"),
    ],
)
def test_the_check_ends_with_its_conclusion(changes: tuple[str, ...], words: str) -> None:
    scene = loads(PLAIN, ("surface.width_um=256", *changes))
    text = conclusion(scene, check_scene(scene, solve=False))
    assert words in text and text.endswith(".")
    assert text.startswith(("It does not run", "It runs in a few seconds. ", "It runs in about "))


def random_texts(count: int) -> Iterator[str]:
    """Check random scenes, from a grain of dust to a wheel, and yield all that is printed."""
    rng = np.random.default_rng(28)

    def decades(low: float, high: float) -> float:
        return float(f"{10 ** rng.uniform(low, high):.3g}")

    for _ in range(count):
        spacing = decades(-2, 2)
        modulus = decades(-3, 3)
        changes = {
            "sphere.radius_mm": decades(-2, 2.9),
            "plate.youngs_modulus_gpa": modulus,
            "plate.hardness_gpa": max(0.001, modulus * decades(-4, -1)) if modulus > 0.01 else None,
            "surface.roughness_ra_um": decades(-4, 3),
            "surface.correlation_length_um": decades(-1, 4),
            "surface.spacing_um": spacing,
            "surface.width_um": spacing * round(decades(1, 5)),
            "rolling.load_n": decades(-6, 7),
            "rolling.speed_m_s": decades(-4, 3),
            "rolling.duration_s": decades(-4, 3),
            "numerics.step_nodes": float(rng.integers(1, 65)),
            "numerics.error_estimate": bool(rng.random() < 0.5),
        }
        if rng.random() < 0.6:
            densities = {f"{body}.density_kg_m3": decades(1, 4.3) for body in ("sphere", "plate")}
            changes |= densities | {"dynamics": {}, "plate.thickness_mm": decades(-1, 3)}
        try:
            scene = loads(PLAIN).with_(changes)
            findings = check_scene(scene, solve=False)
            yield f"{findings}\n{conclusion(scene, findings)}"
        except SceneError as error:
            yield str(error)


def test_no_message_has_a_number_that_nobody_writes() -> None:
    """Of 60 random scenes no text says 1e+02 % or 2e-05 m."""
    texts = list(random_texts(60))
    odd = [match for text in texts for match in re.findall(r".{30}\de[+-]0.{9}", text)]
    assert odd == []
    assert sum("The verdict on" in text for text in texts) > 5
