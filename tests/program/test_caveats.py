"""Each caveat stands where it applies and nowhere else, in the same words everywhere."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from report_runs import Runs, run_results
from scene_text import PLAIN

from rolling.check import findings as check
from rolling.figures import run_figures
from rolling.report import text as report_text
from rolling.scene import file
from rolling.simulation import caveats, summary
from rolling.simulation.caveats import Caveat, Remark
from rolling.sound.contact_sound import ContactSound, contact_sound
from rolling.sound.vibration_sound import Vibration

STEP = 2e-6  # 0.1 m/s: 50,000 steps a second


def scene_of(seconds: float, *overrides: str):
    return file.loads(PLAIN.replace("duration_s: 0.01", f"duration_s: {seconds}"), overrides)


def sound_of(scene, closed: bool = True, silent: bool = False) -> ContactSound:
    steps = round(scene.motion.distance(scene.rolling.duration_s) / STEP)
    noise = 0.0 if silent else 0.1 * np.random.default_rng(1).standard_normal(steps)
    return contact_sound(scene, np.full(steps, 1e-9) * (1.0 + noise), STEP, closed)


def said(
    seconds: float,
    *overrides: str,
    closed: bool = True,
    silent: bool = False,
    complete: bool = True,
) -> dict[str, str]:
    scene = scene_of(seconds, *overrides)
    found = caveats.caveats(scene, sound_of(scene, closed, silent), [], complete)
    assert len({each.key for each in found}) == len(found)
    assert all(each.key in (*caveats.STANDING, "solver") for each in found)
    return {each.key: each.text for each in found}


ALWAYS = {"unvalidated", "uncertainty", "quasi_static"}


def test_each_caveat_stands_where_it_applies_and_nowhere_else() -> None:
    long = said(0.5)
    assert set(long) == ALWAYS | {"upper_bound"}
    assert "upper bound" in long["upper_bound"] and "q = 1" in long["upper_bound"]
    assert "microphone" in long["unvalidated"] and "record's length alone" in long["uncertainty"]
    half = said(0.5, "sound.q=0.5")
    assert set(half) == ALWAYS | {"assumed_q"} and "0.5" in half["assumed_q"]
    fixed = said(0.5, "sound.gain_pa_per_w_m2=3")
    assert (
        set(fixed) == ALWAYS | {"upper_bound", "fixed_gain"}
        and "3 Pa per W/m²" in fixed["fixed_gain"]
    )
    assert fixed["upper_bound"].startswith("The steady level")  # the gain decides the others
    assert set(said(0.5, complete=False, closed=False)) == ALWAYS | {
        "upper_bound",
        "partial",
        "not_loopable",
    }
    braking = said(0.5, "rolling.speed_m_s=[[0, 0.1], [1, 0.2]]")
    assert "not_loopable" in braking and "short_loop" not in braking


def test_silence_has_no_level_to_bound_and_no_pitch() -> None:
    silent = said(0.03, silent=True)
    assert "short_loop" not in silent and silent["upper_bound"].startswith("The steady level")
    # The surface is rough: whether it is silent a tighter solve would tell.
    assert "counts as silent" in silent["solver"] and "numerics.tolerance" in silent["solver"]
    scene = scene_of(0.03)
    nothing = contact_sound(scene, np.zeros(1500), STEP, True)
    assert {each.key for each in caveats.caveats(scene, nothing, [], True)} == {"quasi_static"}


def test_a_loop_that_is_heard_as_a_pitch_says_which() -> None:
    """A record of 0.03 s repeats 33 times a second; from 0.3 s on there is no caveat."""
    assert "0.03 s repeats 33 times a second" in said(0.03)["short_loop"]
    assert "the repetition, not the contact" in said(0.03)["short_loop"]
    assert "3.4 times a second" in said(0.29)["short_loop"]
    assert "short_loop" not in said(0.31)
    assert "short_loop" not in said(0.03, closed=False)


@pytest.mark.slow
def test_a_short_track_gone_round_many_times_says_its_pitch(runs: Runs) -> None:
    """150 laps of 6 ms in 0.9 s sound at 167 Hz, looped or not, and so does the lap alone."""
    texts = {each.key: each.text for each in caveats.stored(run_results(runs.three())[0].summary)}
    assert "every 0.006 s, 167 times a second" in texts["short_track"] and "short_loop" not in texts
    (lap,) = run_results(runs.lap())
    texts = {each.key: each.text for each in caveats.stored(lap.summary)}
    assert (
        "0.006 s repeats 167 times a second" in texts["short_loop"] and "short_track" not in texts
    )


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
    given = caveats._of_vibration(scene, cast(Vibration, SimpleNamespace(motion=motion)))
    assert [each.key for each in given] == ["plate_deflection"] * bent
    assert not bent or "sinks and rises by 0.11 of its thickness" in given[0].text


def test_warnings_of_the_check_keep_their_keys() -> None:
    scene = scene_of(0.03)
    findings = check.findings(scene)
    found = [
        each
        for each in caveats.caveats(scene, sound_of(scene), findings, True)
        if each.key not in caveats.STANDING
    ]
    assert found and [each.key for each in found] == [each.key for each in findings if each.warning]
    assert all(
        f"{each.quantity}: {each.warning}" in {one.text for one in found}
        for each in findings
        if each.warning
    )
    assert not set(caveats.STANDING) & {each.key for each in findings}


def test_several_runs_say_each_caveat_once() -> None:
    a, b, c = Caveat("a", "All."), Caveat("b", "Of one."), Caveat("b", "Of another.")
    assert caveats.gathered([("x", [a]), ("y", [a, b]), ("z", [a, c])]) == [
        Remark("a", "All."),
        Remark("b", "Of one. (in the numbers of y)", ("y", "z")),
    ]


def test_summary_sidecars_tsv_and_table_say_the_same(runs: Runs) -> None:
    """All files have the same caveats word for word, from a single source."""
    heard = run_results(runs.three())
    one = heard[0]
    numbers = json.loads((one.folder / "summary.json").read_text())
    texts = [each["text"] for each in numbers["caveats"]]
    assert "warnings" not in numbers and {"upper_bound", "unvalidated", "uncertainty"} <= {
        each["key"] for each in numbers["caveats"]
    }
    for name in ("signal", "listen"):
        assert (
            json.loads((one.folder / f"{name}.json").read_text())["caveats"] == numbers["caveats"]
        )
    of_one = {
        picture.name: picture.csv().decode()
        for picture in run_figures.of_run(one)
        if picture.columns
    }
    together = {picture.name: picture.csv().decode() for picture in run_figures.of_runs(heard)}
    assert "levels" in together and "spectrum" in of_one
    for content in (*of_one.values(), *together.values()):
        assert "#" not in content  # tables of pictures hold nothing but numbers
    assert f"# {texts[0]}\n" in report_text.tsv(heard)
    table = summary.table([(each.label, "folder", each.summary) for each in heard]).splitlines()
    assert (
        texts[0] in table[4]
        and "microphone" in table[4]
        and "± covers" in table[5]
        and table[6] == ""
    )
    assert report_text.headline(heard) == f"{table[4]} {table[5]}"
    words = " ".join(
        fact.name + value for fact in report_text.assumptions(heard) for _, value in fact.values
    )
    for text in (words, report_text.LEVELS_NOTE, report_text.BANDS_NOTE):
        assert "upper bound" not in text and "stationary" not in text and "no error of" not in text


def test_tables_are_read_by_csv_readers_whatever_the_labels_hold(runs: Runs) -> None:
    """Commas, quotation marks and the sign of a comment in a label move no cell."""
    label = 'load 1 N (a,b "c" #d)'
    one = replace(run_results(runs.three())[0], label=label)
    for picture in run_figures.of_run(one):
        if picture.columns:
            head, *rows = csv.reader(picture.csv().decode().splitlines())
            assert head == list(picture.columns)
            assert all(len(first) == len(second) for first, second in pairwise([head, *rows]))
    lines = [line for line in report_text.tsv([one]).splitlines() if not line.startswith("#")]
    head, row = csv.reader(io.StringIO("\n".join(lines)), delimiter="\t")
    assert row[0] == label and len(row) == len(head)


def test_text_of_scenes_in_a_remark_stays_on_its_line(runs: Runs) -> None:
    (one,) = run_results(runs.lap())
    numbers = one.summary | {"caveats": [{"key": "x", "text": "first\nsecond,1,2\u2028"}]}
    first = report_text.tsv([replace(one, summary=numbers)]).splitlines()[0]
    assert first == "# first\\nsecond,1,2\\u2028"
