"""Each caveat stands where it applies and nowhere else, in the same words everywhere."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from finished import caveat_texts, marched
from scene_text import PLAIN, TINY

from rolling.check import findings
from rolling.results import caveats
from rolling.results.caveats import Caveat
from rolling.scene import file
from rolling.scene.scene import Scene
from rolling.sound.contact_sound import ContactSound, contact_sound
from rolling.sound.vibration_sound import Vibration

STEP = 2e-6  # 0.1 m/s: 50,000 steps a second
ALWAYS = {"unvalidated", "uncertainty", "quasi_static"}


def scene_of(seconds: float, *overrides: str) -> Scene:
    return file.loads(PLAIN.replace("duration_s: 0.01", f"duration_s: {seconds}"), overrides)


def sound_of(scene: Scene, closed: bool = True, noise: float = 0.1) -> ContactSound:
    steps = round(scene.motion.distance(scene.rolling.duration_s) / STEP)
    share = noise * np.random.default_rng(1).standard_normal(steps)
    return contact_sound(scene, np.full(steps, 1e-9) * (1.0 + share), STEP, closed)


def said(
    seconds: float, *overrides: str, closed: bool = True, noise: float = 0.1
) -> dict[str, str]:
    """Return the texts of the standing caveats, and of the solver, by key."""
    scene = scene_of(seconds, *overrides)
    listed = caveats.caveats(scene, sound_of(scene, closed, noise), {})
    kept = (*caveats.STANDING, "solver")
    return {caveat["key"]: caveat["text"] for caveat in listed if caveat["key"] in kept}


def test_each_caveat_stands_where_it_applies_and_nowhere_else() -> None:
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


@pytest.mark.parametrize(("seconds", "rate"), [(0.03, "33"), (0.29, "3.4"), (0.31, None)])
def test_a_loop_that_is_heard_as_a_pitch_says_which(seconds: float, rate: str | None) -> None:
    """A record of 0.03 s repeats 33 times a second; from 0.3 s on there is no caveat."""
    looped = said(seconds)
    assert ("short_loop" in looped) == (rate is not None)
    assert rate is None or f"repeats {rate} times a second" in looped["short_loop"]
    assert ("short_loop" in said(seconds, closed=False)) == (rate is not None)


def test_a_short_track_gone_round_many_times_says_its_pitch(tmp_path: Path) -> None:
    """100 laps of 3 ms sound at 333 Hz, looped or not."""
    waves = 1e-8 * np.cos(2 * np.pi * np.arange(150) / 10)
    np.save(tmp_path / "waves.npy", np.tile(waves[:, None], (1, 64)))
    text = TINY.replace("0.0005}", "0.3}")
    begin, end = text.index("surface:"), text.index("rolling:")
    surface = f"surface: {{kind: file, path: {tmp_path}/waves.npy, spacing_um: 2}}\n"
    texts = caveat_texts(marched(text[:begin] + surface + text[end:]))
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
    listed = caveats.caveats(scene, sound_of(scene), {}, vibration)
    texts = {caveat["key"]: caveat["text"] for caveat in listed}
    assert ("plate_deflection" in texts) == bent
    assert not bent or "by 0.11 of its thickness" in texts["plate_deflection"]


def test_warnings_of_the_check_keep_their_keys_and_stand_last() -> None:
    scene = scene_of(0.03)
    listed = caveats.caveats(scene, sound_of(scene), {})
    warned = [finding for finding in findings.findings(scene) if finding.warning]
    assert warned and [caveat["key"] for caveat in listed[-len(warned) :]] == [
        w.key for w in warned
    ]
    texts = {caveat["text"] for caveat in listed}
    assert all(f"{w.quantity}: {w.warning}" in texts for w in warned)
    assert not set(caveats.STANDING) & {finding.key for finding in findings.findings(scene)}


def test_several_runs_say_each_caveat_once() -> None:
    def summary(**texts: str) -> dict[str, list[dict[str, str]]]:
        return {"caveats": [{"key": key, "text": text} for key, text in texts.items()]}

    runs = [("x", summary(a="All.")), ("y", summary(a="All.", b="Of one."))]
    assert caveats.gathered([*runs, ("z", summary(a="All.", b="Of another."))]) == [
        Caveat("a", "All."),
        Caveat("b", "Of one. (in the numbers of y; likewise z)"),
    ]
