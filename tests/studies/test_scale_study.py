"""The simulation of many cores: its closed cases, and which part limits."""

from __future__ import annotations

import numpy as np
import pytest

from rolling.commands import scale_study
from rolling.commands.scale_study import Overheads, forecast


def test_equal_tasks_take_turns() -> None:
    told = forecast([2.0] * 10, 5, 0.0, 0.0)
    assert told.seconds == 4.0 and told.efficiency == 1.0 and told.limit == "the cores"
    assert forecast([2.0] * 11, 5, 0.0, 0.0).seconds == 6.0


def test_the_longest_task_limits_many_cores() -> None:
    told = forecast([100.0] + [1.0] * 50, 100, 0.0, 0.0)
    assert told.seconds == 100.0 and told.limit == "the longest task"


def test_the_handing_process_limits_short_tasks() -> None:
    told = forecast([0.01] * 1000, 100, 0.1, 0.0)
    assert told.seconds == pytest.approx(100.0, rel=0.01)
    assert told.limit == "the process that hands out tasks"


def test_the_table_at_the_end_counts() -> None:
    told = forecast([1.0] * 100, 100, 0.0, 10.0)
    assert told.seconds == 11.0 and told.limit == "the table at the end"


def test_no_schedule_beats_its_bounds() -> None:
    random = np.random.default_rng(3)
    for _ in range(20):
        times = random.lognormal(0.0, 1.0, 200)
        cores = int(random.integers(1, 40))
        seconds = forecast(times, cores, 0.0, 0.0).seconds
        bound = max(times.max(), times.sum() / cores)
        assert bound * (1 - 1e-12) <= seconds <= bound * (4 / 3)  # longest first (Graham)


def test_a_way_that_was_not_measured_has_no_rows() -> None:
    measured = Overheads(1e-3, float("nan"), 0.05, 1e-3, 2.0, 3e4)
    rows = scale_study.forecasts(np.array([1e-3, 2e-3]), 0.01, measured)
    assert {row[1] for row in rows} == {"local"}
