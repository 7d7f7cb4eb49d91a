"""The sentences on the sound follow from the records, and stay within their uncertainty."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from report_runs import runs_of

from rolling.report import text
from rolling.report.number_table import number_table
from rolling.results.run_result import Run


def with_record(run: Run, pressure: np.ndarray, laeq_db: float) -> Run:
    sound = replace(run.sound, pressure=pressure)
    levels = replace(run.numbers.of_record, laeq_db=laeq_db)
    of_sources = replace(run.numbers.levels, released_power=levels)
    # Nothing vibrates, so that this record plays.
    silent = replace(run.numbers.vibration, value=None)
    numbers = replace(run.numbers, levels=of_sources, vibration=silent, heard=None)
    return replace(run, sound=sound, numbers=numbers)


def tone(hertz: float, samples: int = 48000) -> np.ndarray:
    return np.sin(2 * np.pi * hertz * np.arange(samples) / 48000)


@pytest.fixture
def heard() -> list[Run]:
    return runs_of("three")


def test_colour_is_the_mean_of_the_a_weighted_log_frequency(heard) -> None:
    both = tone(1000) + tone(4000) / 10 ** (0.964 / 20)  # equal after A-weighting
    colour = text.colour(with_record(heard[0], both, 60.0))
    assert colour is not None
    assert colour[0] == pytest.approx(2000, rel=2e-3) and colour[1:] == (1000, 4000)


def test_widths_and_rates_are_of_the_contact() -> None:
    """Hertz: a = (3 F R / 4 E*)^(1/3), E* of a rigid sphere on 210 GPa, 0.3; at 0.1 m/s."""
    run = runs_of("seeds")[-1]
    width = 2 * (0.75 * 0.2 * 5e-3 / (210e9 / (1 - 0.3**2))) ** (1 / 3)
    between = with_record(run, tone(6000), 60.0)  # below the rate of a correlation length
    place = text.reason([between])
    assert f"({width * 1e6:.3g} µm) {float(f'{0.1 / width:.2g}'):,.0f} times a second" in place
    assert "(10 µm) 10,000 times a second" in place


def test_a_reason_that_covers_little_is_not_given() -> None:
    run = runs_of("seeds")[-1]
    outside = with_record(run, tone(100), 60.0)
    assert "contact width" not in text.reason([outside])
    assert "contact width" not in text.reason(runs_of("flying"))  # a vibration has its resonances


def test_silence_has_no_reason() -> None:
    (silent,) = runs_of("smooth")
    assert text.reason([silent]) == ""
    assert text.colour(silent) is None


def test_weighting_is_explained_where_it_raises_a_level(heard) -> None:
    words = dict(number_table(heard).explained)
    raised = any(
        run.numbers.of_record.laeq_db > run.numbers.of_record.level_db  # type: ignore[operator]
        for run in heard
    )
    assert ("LAeq above LZeq" in words) == raised
    levels = replace(heard[0].numbers.of_record, level_db=heard[0].record_laeq_db - 1.0)
    of_sources = replace(heard[0].numbers.levels, released_power=levels)
    above = replace(heard[0], numbers=replace(heard[0].numbers, levels=of_sources))
    assert "LAeq above LZeq" in dict(number_table([above]).explained)
    assert {"steady level", "plastic ratio"} <= set(words)


def test_runs_heard_by_their_vibration_have_the_words_of_their_own_columns() -> None:
    flying = runs_of("flying")
    table = number_table(flying)
    words = dict(table.explained)
    for word in ("q that equals them", "maximum of F/W"):
        assert word in words and any(word in row.head for row in table.rows)
