"""Messages about rolling and all sections after it say line, key, got and allowed."""

import pickle

import pytest
from scene_text import PLAIN, TEXT, faults

from rolling.scene.messages import SceneError

SECTIONS = (
    "name, title, description, sphere, plate, surface, rolling, numerics, recovery, dynamics, "
    "sound, sweep"
)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "load_n: 20",
            "load_n: true",
            "s.yaml:15: rolling.load_n: got true, allowed: a number > 0",
        ),
        ("load_n: 20", "load_n:", "s.yaml:15: rolling.load_n: missing, allowed: a number > 0"),
        (
            "load_n: 20",
            "load_n: !big 20",
            "s.yaml:15: rolling.load_n: got the tag !big, allowed: plain values",
        ),
        ("load_n: 20", "load_n: [[[1]]]", "s.yaml:15: rolling.load_n[0][0][0]: nested too deeply"),
        (
            "load_n: 20",
            "load: 20\n  load_n: 20",
            "s.yaml:15: rolling.load: unknown key, nearest: load_n, allowed: load_n, speed_m_s, "
            "duration_s, distance_mm, start_um",
        ),
        (
            "speed_m_s: 0.1",
            "speed_m_s: 0",
            "s.yaml:16: rolling.speed_m_s: got 0, allowed: a number > 0, or at least two [time_s, "
            "speed_m_s] pairs",
        ),
        (
            "speed_m_s: 0.1",
            "speed_m_s: [[0, 1]]",
            "s.yaml:16: rolling.speed_m_s: got [[0, 1]], allowed: a number > 0, or at least two "
            "[time_s, speed_m_s]"
            " pairs",
        ),
        (
            "speed_m_s: 0.1",
            "speed_m_s:\n  - [0, 1]\n  - [1, true]",
            "s.yaml:18: rolling.speed_m_s[1]: got [1, true], allowed: [time_s, speed_m_s], two "
            "numbers",
        ),
        (
            "speed_m_s: 0.1",
            "speed_m_s: [[0, 1], 2]",
            "s.yaml:16: rolling.speed_m_s[1]: got 2, allowed: [time_s, speed_m_s], two numbers",
        ),
        (
            "speed_m_s: 0.1",
            "speed_m_s: [[1, 1], [2, 1]]",
            "s.yaml:16: rolling.speed_m_s[0]: got 1, allowed: 0, the time of the first pair",
        ),
        (
            "speed_m_s: 0.1",
            "speed_m_s: [[0, 1], [2, 1], [2, 3]]",
            "s.yaml:16: rolling.speed_m_s[2]: got time 2 after 2, allowed: increasing times",
        ),
        (
            "speed_m_s: 0.1",
            "speed_m_s: [[0, 1], [2, -1]]",
            "s.yaml:16: rolling.speed_m_s[1]: got speed -1, allowed: a number >= 0",
        ),
        (
            "speed_m_s: 0.1",
            "speed_m_s: [[0, 0], [2, 0]]",
            "s.yaml:16: rolling.speed_m_s: got speeds that are all 0, allowed: at least one > 0",
        ),
        (
            "speed_m_s: 0.1",
            "speed_m_s: [[0, 1e-3], [0.01, 0]]",
            "s.yaml:16: rolling.speed_m_s: the sphere comes to rest after 5 um, the shortest track "
            "is 16 um: give it"
            " more speed",
        ),
        (
            "  duration_s: 0.01\n",
            "",
            "s.yaml:14: rolling.duration_s: missing, allowed: a number > 0, or a"
            " rolling.distance_mm",
        ),
        (
            "duration_s: 0.01",
            "duration_s: 1.0e-4",
            "s.yaml:17: rolling.duration_s: got 0.0001, in which the sphere rolls 10 um; the "
            "shortest track is 8 nodes,"
            " 16 um: at least 0.00016",
        ),
        (
            "duration_s: 0.01",
            "duration_s: 1e9",
            "s.yaml:17: rolling.duration_s: got 1000000000, which is more than 1e+09 nodes or "
            "steps",
        ),
        (
            "step_nodes: 1",
            "step_nodes: 1.6",
            "s.yaml:18: numerics.step_nodes: got 1.6, allowed: a whole number from 1 to 64, or one "
            "over a whole"
            " number down to 1/16; nearest: 2",
        ),
        (
            "step_nodes: 1",
            "step_nodes: 0.3",
            "s.yaml:18: numerics.step_nodes: got 0.3, allowed: a whole number from 1 to 64, or one "
            "over a whole"
            " number down to 1/16; nearest: 0.3333333333333333",
        ),
        (
            "step_nodes: 1",
            "tolerance: 0.5",
            "s.yaml:18: numerics.tolerance: got 0.5, allowed: auto, or a number >= 1e-12 and"
            " <= 0.1",
        ),
        (
            "step_nodes: 1",
            "tolerance: 1e-13",
            "s.yaml:18: numerics.tolerance: got 1e-13, allowed: auto, or a number >= 1e-12 and"
            " <= 0.1",
        ),
        (
            "numerics: {step_nodes: 1}",
            "numeric: {step_nodes: 1}",
            f"s.yaml:18: numeric: unknown key, nearest: numerics, allowed: {SECTIONS}",
        ),
        ("numerics: {step_nodes: 1}", "17: 3", f"s.yaml:18: 17: unknown key, allowed: {SECTIONS}"),
        (
            "numerics: {step_nodes: 1}",
            "recovery: {events: on}",
            's.yaml:18: recovery.events: got "on", allowed: true or false',
        ),
        (
            "numerics: {step_nodes: 1}",
            "recovery: {rule: left}",
            's.yaml:18: recovery.rule: got "left", allowed: mean or left_end, nearest: left_end',
        ),
        (
            "numerics: {step_nodes: 1}",
            "sound: {q: 1.5}",
            "s.yaml:18: sound.q: got 1.5, allowed: a number > 0 and <= 1",
        ),
        (
            "numerics: {step_nodes: 1}",
            "sound: {gain_pa_per_w_m2: 0}",
            "s.yaml:18: sound.gain_pa_per_w_m2: got 0, allowed: a number > 0",
        ),
    ],
)
def test_message_about_rolling(old: str, new: str, message: str) -> None:
    assert old in TEXT
    assert message in faults(TEXT.replace(old, new, 1))


def test_a_missing_duration_is_told_beside_other_faults() -> None:
    got = faults(PLAIN.replace("  duration_s: 0.01\n", "").replace("radius_mm: 5", "radius_mm: -5"))
    assert [fault.split(": ")[1] for fault in got] == ["sphere.radius_mm", "rolling.duration_s"]


def test_keys_of_another_kind_of_surface() -> None:
    assert faults(PLAIN.replace("kind: gaussian", "kind: smooth")) == [
        f"s.yaml:{line}: surface.{key}: unknown key of kind smooth, allowed: kind, spacing_um, "
        f"width_um"
        for line, key in ((9, "roughness_ra_um"), (10, "correlation_length_um"), (13, "seed"))
    ]


def test_errors_pass_between_processes() -> None:
    error = SceneError(["a", "b"])
    assert pickle.loads(pickle.dumps(error)).faults == ["a", "b"]
