"""What frozen_series.py freezes has one name in all versions of the program, and changes count."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

import frozen_numbers
import frozen_series
import numpy as np
import pytest
from frozen_numbers import Frozen

from rolling.numbers.doubt import Doubt, Severity
from rolling.scene import library

PLACES = {
    "arrays": {"force": ["motion.force", "vibration.force"]},
    "values": {
        "laeq_db": ["numbers.levels.laeq.value", "summary.laeq_db"],
        "lines.*.height": ["numbers.lines.*.height_over", "summary.lines.*.height"],
        "first_angle": ["numbers.angles.0", "summary.angle"],
        "impacts": ["numbers.motion.impacts", "summary.impacts"],
    },
    "bands": {"third_octave_db": ["numbers.bands", "summary.third_octave_db"]},
    "doubts": {"doubts": ["doubts", "summary.doubts"]},
    "verdicts": {"verdict": ["numbers.verdict", "summary.verdict.word"]},
    "left_out": {"times": ["summary.cpu_s", "numbers.*.cpu_s"]},
}
FORCE = np.array([1.0, 2.0])


@dataclass(frozen=True)
class Quantity:
    """A number as a record."""

    value: float | None


@dataclass(frozen=True)
class Levels:
    """Numbers of a subject."""

    laeq: Quantity


@pytest.fixture(autouse=True)
def _few_places(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(frozen_numbers.PLACES, "few", PLACES)


def run_with_summary(**changes: object) -> SimpleNamespace:
    """Return a run whose numbers stand in a dictionary."""
    summary = {
        "laeq_db": 1 / 3,
        "third_octave_db": dict.fromkeys(frozen_numbers.BAND_NAMES) | {"1000": 30},
        "doubts": [{"key": "grid", "text": "", "severity": "trust", "decibels": 0.1, "advice": ""}],
        "verdict": {"word": "trust"},
        "cpu_s": 1.5,
    }
    return SimpleNamespace(summary=summary | changes, vibration=SimpleNamespace(force=FORCE))


def run_with_records(level_db: float | None) -> SimpleNamespace:
    """Return the same run with its numbers in records."""
    bands = [30.0 if name == "1000" else math.nan for name in frozen_numbers.BAND_NAMES]
    numbers = SimpleNamespace(
        levels=Levels(Quantity(level_db)), bands=np.array(bands), verdict="trust"
    )
    return SimpleNamespace(
        numbers=numbers,
        doubts=[Doubt("grid", "in other words", Severity.TRUST, 0.1)],
        motion=SimpleNamespace(force=FORCE.copy()),
    )


def test_a_number_has_the_same_name_and_value_wherever_it_stands():
    old = Frozen.of(run_with_summary(), "few")
    assert old == Frozen.of(run_with_records(1 / 3), "few")
    assert old.values == {
        "laeq_db": 1 / 3,
        "third_octave_db.1000": 30.0,
        "doubts.grid.severity": "trust",
        "doubts.grid.decibels": 0.1,
    }
    assert old.verdicts == {"verdict": "trust"} and set(old.series) == {"force"}


def test_a_number_that_is_unknown_has_no_entry():
    frozen = [Frozen.of(run_with_records(level), "few") for level in (None, math.nan)]
    assert frozen[0] == frozen[1] and "laeq_db" not in frozen[0].values


def test_an_entry_of_a_list_has_its_number_in_the_name_or_in_the_place():
    old = run_with_summary(lines=[{"height": 2.0}, {"height": None}, {"height": 5.0}], angle=12.5)
    lines = [{"height_over": over} for over in (2.0, None, 5.0)]
    new = SimpleNamespace(numbers={"lines": lines, "angles": (12.5, 15)})
    for run in (old, new):
        values = Frozen.of(run, "few").values
        assert (values["lines.0.height"], values["lines.2.height"]) == (2.0, 5.0)
        assert values["first_angle"] == 12.5 and "lines.1.height" not in values


def test_a_number_below_a_subject_that_a_run_has_not_is_not_looked_for_elsewhere():
    run = SimpleNamespace(numbers={"motion": None}, summary={"impacts": 3})
    assert "impacts" not in Frozen.of(run, "few").values
    assert Frozen.of(run_with_summary(impacts=3), "few").values["impacts"] == 3


def test_numbers_that_the_table_has_not_are_named():
    assert frozen_numbers.unread(run_with_summary(), "few") == []
    run = run_with_summary(flights=3, lines=[{"height": 2.0, "width": 1.0}], unknown=None)
    assert frozen_numbers.unread(run, "few") == ["summary.flights", "summary.lines.*.width"]
    new = run_with_records(1 / 3)
    new.numbers = {"levels": new.numbers.levels, "effort": {"cpu_s": 1.5, "steps": 3}}
    assert frozen_numbers.unread(new, "few") == ["numbers.effort.steps"]


def test_a_word_in_angle_brackets_stands_for_each_of_its_words(tmp_path: Path):
    table = tmp_path / "places.toml"
    table.write_text(
        '[words]\nband = ["low", "high"]\n[run.values]\n"um_s.<band>" = ["numbers.<band>.value"]\n'
        '[run.left_out]\nunits = ["numbers.<band>.unit"]\n',
        encoding="utf-8",
    )
    assert frozen_numbers.read_table(table)["run"] == {
        "values": {"um_s.low": ["numbers.low.value"], "um_s.high": ["numbers.high.value"]},
        "left_out": {"units": ["numbers.low.unit", "numbers.high.unit"]},
    }


def test_a_last_bit_is_a_change_and_a_word_of_a_verdict_fails_nothing():
    run = run_with_summary()
    before = {"run": Frozen.of(run, "few")._asdict()}
    assert frozen_series.changes(before, before).exit_code == 0
    run.summary["verdict"] = {"word": "bound"}
    of_word = frozen_series.changes(before, {"run": Frozen.of(run, "few")._asdict()})
    assert of_word.counts == "0 series changed, 0 values changed, 1 verdicts changed"
    assert of_word.exit_code == 0
    run.summary["laeq_db"] = np.nextafter(1 / 3, 1)
    of_value = frozen_series.changes(before, {"run": Frozen.of(run, "few")._asdict()})
    assert len(of_value.values) == 1 and of_value.exit_code == 1
    run.vibration.force = np.nextafter(FORCE, 3)
    of_series = frozen_series.changes(before, {"run": Frozen.of(run, "few")._asdict()})
    assert len(of_series.series) == 1
    assert frozen_series.changes(before, {}).exit_code == 1


def test_the_order_of_pieces_changes_no_digest():
    assert frozen_numbers.digest({1: FORCE, 2: -FORCE}) == frozen_numbers.digest(
        {2: -FORCE, 1: FORCE}
    )


def test_no_two_places_give_the_same_name():
    for kind, sections in frozen_numbers.PLACES.items():
        names = [name for section in sections.values() for name in section]
        assert len(names) == len(set(names)), kind


def test_every_job_of_the_short_set_is_of_a_known_kind_and_on_a_scene_of_the_library():
    jobs = frozen_series.short_jobs()
    assert {job.kind for job in jobs} == set(frozen_series.FREEZE) - {"library"}
    assert {job.entry["scene"] for job in jobs} <= set(library.scenes())
