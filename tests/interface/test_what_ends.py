"""What ends is heard as a whole: it does not go round, and its level is that of what plays."""

from __future__ import annotations

import io
import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import soundfile

import rolling
from acoustics.arrays import Array
from acoustics.level import lae_db, laeq_db
from acoustics.wav import SAMPLE_RATE_HZ
from rolling.numbers.ball_numbers import ListeningNumbers, RunNumbers
from rolling.numbers.number_files import from_bytes, summary_of, to_bytes
from rolling.numbers.quantity import uncertain
from rolling.report import page_sounds, text
from rolling.results import answer, level_words, listening, run_lines, runs_table
from rolling.results.run_quantities import with_quantities
from rolling.results.run_result import Run
from rolling.scene.file import loads

BODIES = """\
name: ends
sphere: {radius_mm: 5, density_kg_m3: 7850}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1, density_kg_m3: 7850,
  thickness_mm: 10, loss_factor: 0.01}
dynamics: {}
"""
ROUGH = """\
surface: {kind: gaussian, roughness_ra_um: 0.02, correlation_length_um: 10, spacing_um: 2,
  width_um: 128, seed: 1}
"""
SCENES = {
    "falls": BODIES
    + """\
surface: {kind: smooth, spacing_um: 5, width_um: 200}
rolling: {speed_m_s: 0.05, distance_mm: 1, drop_mm: 0.1}
sound: {listen_s: 1}
""",
    # From 0.05 m/s it rests after 0.36 s.
    "rests": BODIES
    + ROUGH
    + """\
rolling: {load_n: weight, speed_m_s: 0.05, resistance: 0.02, distance_mm: 0.3}
sound: {listen_s: 1}
""",
    "rolls on": BODIES
    + ROUGH
    + """\
rolling: {load_n: weight, speed_m_s: 0.05, distance_mm: 0.3}
sound: {listen_s: 1}
""",
    # From 0.01 m/s it rests after 0.0714 s, in the fade of its solved record.
    "rests at once": BODIES
    + ROUGH
    + "rolling: {load_n: weight, speed_m_s: 0.01, resistance: 0.02, duration_s: 0.07}\n",
}


@cache
def run_of(name: str) -> Run:
    """Return a run by the name of its scene, solved once."""
    return rolling.simulate(loads(SCENES[name], []), progress=False, workers=1)


def played(run: Run) -> Array:
    """Return the pressure [Pa] in the bytes of listen.wav, less what raises its end."""
    listen = listening.ListenSound(run)
    content, facts = listen.wav(), listen.facts()
    samples, rate = soundfile.read(io.BytesIO(content))
    assert rate == SAMPLE_RATE_HZ
    assert b"smpl" not in content  # the chunk of a loop
    pressure = samples * facts.pascal_per_full_scale
    if facts.raised is not None:
        begin = round(facts.raised.begin_s * rate)
        pressure[begin:] = samples[begin:] * facts.raised.pascal_per_full_scale
    return np.asarray(pressure)


@pytest.mark.parametrize(("name", "level"), [("falls", lae_db), ("rests", laeq_db)])
def test_the_level_that_leads_is_that_of_the_sound_file(name: str, level) -> None:
    """The file has 24 bits and short fades. The solved part alone is off by several decibels."""
    run = run_of(name)
    of_file = level(played(run), SAMPLE_RATE_HZ)
    heard = run.vibration
    assert heard.value == pytest.approx(of_file, abs=0.05)
    own = run.numbers.of_record
    of_part = own.lae_db if run.numbers.record.single_event else own.laeq_db
    assert abs(of_part - of_file) > 1
    assert heard.solved_share == pytest.approx(run.numbers.listening.solved_share)
    assert heard.solved_share < 0.05
    # Terminal, summary.json, tables, page and notebook have the same level.
    shown = f"{of_file:.1f}"
    assert shown in run_lines.levels_table([run])
    view = summary_of(run.numbers)["vibration"]
    assert view["value"] == pytest.approx(heard.value, rel=1e-5)
    (row,) = runs_table.runs_table([run]).to_dict("records")
    assert row["vibration_db"] == heard.value
    assert row["vibration_solved_share"] == heard.solved_share
    assert text.main_level(run) == heard.value
    rows = [row for row in level_words.number_texts(run.numbers) if row.is_of_record]
    assert rows[0].text.startswith(shown)
    assert shown in run._repr_html_() and "solved" in run._repr_html_()


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("falls", "of the whole fall: the first 0.02 s are solved"),
        ("rests", "of the 1 s that play: the first 0.0061 s are solved"),
        ("rolls on", ""),
        ("rests at once", ""),
    ],
)
def test_the_sentence_says_which_part_is_solved(name: str, part: str) -> None:
    run = run_of(name)
    sentence = answer.follows([run])
    assert ("solved" in sentence) == bool(part)
    assert part in sentence
    assert answer.of_solved_part([run.numbers, run.numbers]) in sentence


def test_a_fast_maximum_belongs_to_the_record_beside_it() -> None:
    """The solved part of 20 ms is too short for the time weighting, and the whole fall is not."""
    numbers = run_of("falls").numbers
    fast = numbers.listening.laf_max_db
    assert numbers.of_record.laf_max_db is None
    rows = level_words.number_texts(numbers)
    texts = {one.number_field.word: one.text for one in rows if one.is_of_record}
    assert texts["LAFmax"].startswith(f"{fast:.1f}")


def test_a_released_power_of_another_part_does_not_stand_beside_it() -> None:
    """The release is known for the solved part, which the reason says with its level."""
    numbers = run_of("rests").numbers
    released = numbers.released_power
    own_db = numbers.levels.released_power_at_listener_db
    assert released.value is None
    assert f"where its LAeq is {own_db:.1f} dB(A)" in released.reason
    assert answer.gap([numbers]) == ""


@pytest.mark.parametrize("name", [*SCENES])
def test_what_ends_has_no_seam(name: str) -> None:
    """The page plays all of it once, and a record in laps has one."""
    run = run_of(name)
    (record,) = page_sounds.of_runs([run])
    long = run.numbers.listening
    seconds = run.sound.duration if long is None or long.seconds is None else long.seconds
    assert record.ends == run.ends_within(seconds) == (name != "rolls on")
    assert (record.lap["overlap"] == 0) == record.ends
    if record.ends:
        played(run)
        assert record.lap["begin"] == 0
    if name == "rests at once":
        assert len(listening.record_in_laps(run.sound, run.scene.motion)) == len(run.sound.pressure)
        assert listening.describe_laps(run.sound, run.scene.motion).startswith("the record, ")


def test_a_stored_record_that_ends_has_its_numbers() -> None:
    """A file that says so without them is refused, as any damaged one."""
    numbers = run_of("rests").numbers
    again = from_bytes(RunNumbers, to_bytes(numbers))
    assert again == numbers
    assert again.heard_whole is not None and again.heard_whole.seconds == 1.0
    content = json.loads(to_bytes(numbers))
    content["listening"]["seconds"] = None
    with pytest.raises(ValueError, match=r"^listening: .*seconds"):
        from_bytes(RunNumbers, json.dumps(content).encode())


def test_a_level_has_no_negative_zero() -> None:
    assert uncertain(-0.04, 0.01) == "0.0 ± 0.1" and uncertain(-0.06, None) == "-0.1"


def test_runs_stored_without_these_levels_keep_the_solved_one() -> None:
    """Folders of version 0.8.0 have a long record that does not say whether it ends."""
    run = run_of("rests")
    long = ListeningNumbers(seconds=1.0, laeq_db=-20.0, solved_share=0.1)
    numbers = replace(run.numbers, listening=long)
    numbers = with_quantities(numbers, {"record": 0.1}, {}, {})
    assert numbers.vibration.value == numbers.of_record.laeq_db
    assert numbers.vibration.solved_share == 1.0
    own_db = numbers.levels.released_power_at_listener_db
    assert numbers.released_power.value == own_db
    older = replace(run, numbers=numbers)
    assert text.lead_by_whole([run_of("rests"), older]) and not text.lead_by_whole([older])
