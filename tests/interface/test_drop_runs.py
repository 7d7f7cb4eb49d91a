"""A run whose sphere falls: numbers, verdict, record and sound."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from made_numbers import changed

import rolling
from acoustics.wav import SAMPLE_RATE_HZ
from rolling.figures import level_figures, vibration_figures
from rolling.results import answer, listening, run_lines
from rolling.results.level_words import number_texts
from rolling.results.run_quantities import with_quantities
from rolling.results.run_result import Run
from rolling.scene.file import loads

TEXT = """\
name: fall
sphere: {radius_mm: 5, density_kg_m3: 7850}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1, density_kg_m3: 7850,
  thickness_mm: 10, loss_factor: 0.01}
surface: {kind: smooth, spacing_um: 5, width_um: 200}
rolling: {speed_m_s: 0.05, distance_mm: 1, drop_mm: 0.1}
dynamics: {}
"""


@pytest.fixture(scope="module")
def run() -> Run:
    return rolling.simulate(loads(TEXT, []), progress=False, workers=1)


def test_numbers(run: Run) -> None:
    """A rigid ball at 0.0443 m/s on 10 mm: Zener's exp(-1.719 l) with l = 0.0298, 0.950."""
    numbers = run.numbers
    assert numbers.motion.drop_mm == 0.1
    # The marched law of a smooth contact is off by the error of its grid, some percent.
    assert numbers.motion.restitution == pytest.approx(0.950, abs=0.005)
    assert numbers.record.load_n == pytest.approx(9.80665 * numbers.motion.ball_mass_kg)
    assert numbers.motion.impacts > 1 and not numbers.motion.impacts_yield
    # Loads in the ratio of 4 up to the largest force, beyond which the law goes on as Hertz's.
    assert 1 / 4 < numbers.motion.force_law_max_n / numbers.motion.largest_force_n < 1
    assert numbers.motion.force_law_top_error < 0.01
    assert numbers.levels.release_over_vibration_db is None
    assert {"not_settled", "short_loop"}.isdisjoint(item.key for item in numbers.doubts)
    assert numbers.leading.verdict != "do not quote"


def test_record(run: Run) -> None:
    """It begins in silence, and is heard once: the sphere falls for 4.5 ms."""
    pressure = np.abs(run.sound.pressure)
    before = round(4.2e-3 * SAMPLE_RATE_HZ)
    # What comes before is the ringing of the filters of the sound.
    assert pressure[:before].max() < 0.02 * pressure.max()
    assert len(listening.record_in_laps(run.sound, run.scene.motion)) == len(pressure)
    assert "faded at its end" in listening.describe_laps(run.sound, run.scene.motion)


def test_an_impact_that_yields_is_not_quoted(run: Run) -> None:
    harder = rolling.simulate(
        run.scene.with_({"rolling.drop_mm": 0.4, "surface.width_um": 200}),
        progress=False,
        workers=1,
    )
    assert harder.numbers.motion.impacts_yield
    assert harder.numbers.leading.verdict == "do not quote"
    assert "would yield" in harder.numbers.leading.judged.worst.text


# ---- levels of single events


ROLLED = """\
name: rolled
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}
surface: {kind: gaussian, roughness_ra_um: 0.05, correlation_length_um: 20, seed: 1, spacing_um: 4,
  width_um: 256}
rolling: {load_n: 1, speed_m_s: 0.5, distance_mm: 1.024}
"""


def rolled(*changes: str) -> Run:
    """Return a run of a sphere that rolls for 2 ms without dynamics."""
    return rolling.simulate(loads(ROLLED, list(changes)), progress=False, workers=1)


@pytest.mark.law("Single events: LAE is LAeq plus 10 lg of the duration in seconds.")
def test_a_fall_has_a_sound_exposure_level(run: Run) -> None:
    numbers = run.numbers
    assert numbers.record.single_event
    expected = numbers.of_record.laeq_db + 10 * math.log10(len(run.sound.pressure) / SAMPLE_RATE_HZ)
    assert numbers.of_record.lae_db == pytest.approx(expected, abs=1e-9)
    assert numbers.of_record.spreads.lae_db == numbers.of_record.spreads.laeq_db


def test_terminal_and_page_show_events_by_what_can_be_compared(run: Run) -> None:
    """LAeq of 20 ms stays in the numbers. LAFmax of a record that began just before is below."""
    assert run.numbers.of_record.laf_max_db is run.numbers.of_record.las_max_db is None
    table = run_lines.levels_table([run])
    assert f"{run.numbers.of_record.lae_db:.1f}" in table and "silent" not in table
    assert "LAE, dB(A)" in table and "LAFmax" in table and "LAeq" not in table
    assert "released power" not in table  # it is computed for a ball that rolls
    rows = [row for row in number_texts(run.numbers) if row.is_of_record]
    assert rows[0].number_field.word.startswith("LAE") and rows[0].is_repeated
    assert not any("LAeq" in row.number_field.word for row in rows)
    assert repr(run).count("LAE") == 1 and "LAeq" not in repr(run)
    assert f"{run.numbers.of_record.lae_db:.1f}" in run._repr_html_()


def test_a_record_that_is_long_enough_shows_its_maximum(run: Run) -> None:
    """A loop has been played for ever; an open record of 2 ms ends before Fast has risen."""
    loop = rolled()
    opened = rolled("rolling.speed_m_s=[[0, 0.5], [0.002, 0.51]]")
    assert loop.sound.closed and not opened.sound.closed
    assert loop.numbers.of_record.laf_max_db >= loop.numbers.of_record.laeq_db
    assert (
        opened.numbers.of_record.laf_max_db is None and opened.sound.levels.laf_max_db is not None
    )
    for steady in (loop, opened):
        assert not steady.numbers.record.single_event
        words = [row.number_field.word for row in number_texts(steady.numbers) if row.is_of_record]
        assert not any("LAE" in word.replace("LAeq", "") for word in words)


def test_a_fall_is_drawn_without_the_release_of_a_ball_that_rolls(run: Run) -> None:
    columns = vibration_figures.source_table(run).columns
    assert "vibration_level_db" in columns and "release_level_db" not in columns
    legend = vibration_figures.sources(run).get_legend_handles_labels()[1]
    assert any("vibration" in label for label in legend)
    assert not any("release" in label for label in legend)


def test_falls_are_compared_by_their_exposure(run: Run) -> None:
    """The shorter record has the higher LAeq, and less energy."""
    own = run.numbers.of_record
    levels_db = {"lae_db": own.lae_db + 6, "laeq_db": own.laeq_db - 6}
    longer = changed(run.numbers, {"levels": {"vibration": levels_db}})
    longer = with_quantities(longer, run.vibration.parts, {}, {})
    run = replace(run, values={"rolling.drop_mm": 1})
    other = replace(run, values={"rolling.drop_mm": 2}, numbers=longer)
    assert "6.0 dB louder" in answer.follows([run, other])
    assert {*level_figures.level_table([run, other])["measure"]} == {"LAE"}
    lasting = changed(run.numbers, {"record": {"single_event": False}})
    lasting = with_quantities(lasting, run.vibration.parts, {}, {})
    steady = replace(run, label="steady", numbers=lasting)
    assert "louder" not in answer.follows([run, steady])  # LAE and LAeq cannot be compared
    assert {*level_figures.level_table([run, steady])["measure"]} == {"LAE", "LAeq"}


def test_loudness_of_a_fall_is_that_of_its_course_in_time(run: Run) -> None:
    fall = rolling.simulate(run.scene.with_({"sound.loudness": True}), progress=False, workers=1)
    assert fall.numbers.ears.loudness_sone is fall.numbers.ears.sharpness_acum is None
    assert 0 < fall.numbers.ears.loudness_n5_sone <= fall.numbers.ears.loudness_max_sone
    opened = rolled("sound.loudness=true", "rolling.speed_m_s=[[0, 0.5], [0.002, 0.51]]")
    assert opened.numbers.ears.loudness_sone is None and opened.numbers.ears.loudness_n5_sone > 0


@pytest.mark.slow
def test_loudness_of_a_short_loop_is_that_of_a_steady_sound(run: Run) -> None:
    """It is short, but heard in a loop. N5 and the stationary loudness of noise agree in 10 %."""
    loop = rolled("sound.loudness=true")
    steady = loop.numbers.ears.loudness_sone
    assert loop.numbers.ears.loudness_n5_sone == pytest.approx(steady, rel=0.1)
