"""What ends is heard as a whole: it does not go round, and its level is that of what plays."""

from __future__ import annotations

import io
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import soundfile

import rolling
from acoustics.arrays import Array
from acoustics.level import lae_db, laeq_db
from acoustics.wav import SAMPLE_RATE_HZ
from rolling.report import records, text
from rolling.results import answer, listening, run_lines, runs_table
from rolling.results.run_folder import read_summary
from rolling.results.run_result import Run
from rolling.scene.file import loads
from rolling.terminal.files import FolderError, write_json

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
    content, facts = listening.listen_wav(run)
    samples, rate = soundfile.read(io.BytesIO(content))
    assert rate == SAMPLE_RATE_HZ
    assert b"smpl" not in content  # the chunk of a loop
    pressure = samples * facts["pascal_per_full_scale"]
    if "raised" in facts:
        begin = round(facts["raised"]["begin_s"] * rate)
        pressure[begin:] = samples[begin:] * facts["raised"]["pascal_per_full_scale"]
    return np.asarray(pressure)


@pytest.mark.parametrize(("name", "level"), [("falls", lae_db), ("rests", laeq_db)])
def test_the_level_that_leads_is_that_of_the_sound_file(name: str, level) -> None:
    """The file has 24 bits and short fades. The solved part alone is off by several decibels."""
    run = run_of(name)
    of_file = level(played(run), SAMPLE_RATE_HZ)
    heard = answer.vibration(run.summary)
    assert heard.level_db == pytest.approx(of_file, abs=0.05)
    assert abs(run.summary[answer.level_key(run.summary)] - of_file) > 1
    assert heard.solved_share == run.summary["listening"]["solved_share"] < 0.05
    # Terminal, summary.json, tables, page and notebook have the same level.
    shown = f"{of_file:.1f}"
    assert shown in run_lines.levels_table([run])
    assert run.summary["answer"]["vibration"]["level_db"] == heard.level_db
    assert run.summary["answer"]["vibration"]["solved_share"] == heard.solved_share
    (row,) = runs_table.runs_table([run]).to_dict("records")
    assert row["vibration_db"] == heard.level_db
    assert row["vibration_solved_share"] == heard.solved_share
    assert text.main_level(run) == heard.level_db
    assert any(cells[0].startswith(shown) for _, cells in text.levels([run])[1])
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
    assert answer.of_solved_part([run.summary, run.summary]) in sentence


def test_a_fast_maximum_belongs_to_the_record_beside_it() -> None:
    """The solved part of 20 ms is too short for the time weighting, and the whole fall is not."""
    summary = run_of("falls").summary
    fast = summary["listening"]["laf_max_db"]
    assert summary["laf_max_db"] is None
    assert runs_table.level_text(summary, "laf_max_db").startswith(f"{fast:.1f}")


def test_a_released_power_of_another_part_does_not_stand_beside_it() -> None:
    """The release is known for the solved part, which the reason says with its level."""
    summary = run_of("rests").summary
    released = answer.released_power(summary)
    assert released.level_db is None
    assert f"where its LAeq is {summary['release_laeq_db']:.1f} dB(A)" in released.reason
    assert answer.gap([summary]) == ""


@pytest.mark.parametrize("name", [*SCENES])
def test_what_ends_has_no_seam(name: str) -> None:
    """The page plays all of it once, and a record in laps has one."""
    run = run_of(name)
    (record,) = records.of_runs([run])
    seconds = run.summary.get("listening", run.summary).get("seconds", run.sound.duration)
    assert record.ends == run.ends_within(seconds) == (name != "rolls on")
    assert (record.lap["overlap"] == 0) == record.ends
    if record.ends:
        played(run)
        assert record.lap["begin"] == 0
    if name == "rests at once":
        assert len(listening.record_in_laps(run)) == len(run.sound.pressure)
        assert listening.describe_laps(run).startswith("the record, ")


def test_a_stored_record_that_ends_has_its_numbers(tmp_path: Path) -> None:
    """A summary that says so without them is refused, as any damaged one."""
    summary = run_of("rests").summary
    write_json(tmp_path / "summary.json", summary)
    assert answer.heard_whole(read_summary(tmp_path / "summary.json"))["seconds"] == 1.0
    write_json(tmp_path / "summary.json", summary | {"listening": {"ends": True, "seconds": None}})
    with pytest.raises(FolderError, match="listening lacks a number"):
        read_summary(tmp_path / "summary.json")


def test_a_level_has_no_negative_zero() -> None:
    assert answer.uncertain(-0.04, 0.01) == "0.0 ± 0.1" and answer.uncertain(-0.06, None) == "-0.1"


def test_runs_stored_without_these_levels_keep_the_solved_one() -> None:
    """Folders of version 0.8.0 have a long record that does not say whether it ends."""
    summary = dict(run_of("rests").summary)
    summary["listening"] = {"seconds": 1.0, "laeq_db": -20.0, "solved_share": 0.1}
    heard = answer.vibration(summary)
    assert (heard.level_db, heard.solved_share) == (summary["laeq_db"], 1.0)
    assert answer.released_power(summary).level_db == summary["release_laeq_db"]
    older = replace(run_of("rests"), summary=summary)
    assert text.lead_by_whole([run_of("rests"), older]) and not text.lead_by_whole([older])
