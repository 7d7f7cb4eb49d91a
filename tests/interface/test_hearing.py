"""The sentences on the sound follow from the records, and stay within their uncertainty."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from report_runs import runs_of

from rolling.report import text
from rolling.results.run_result import Run


def with_record(run: Run, pressure: np.ndarray, laeq_db: float) -> Run:
    sound = replace(run.sound, pressure=pressure)
    return replace(run, sound=sound, summary=run.summary | {"laeq_db": laeq_db})


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


def test_the_loudest_run_is_compared_with_the_quietest(heard) -> None:
    low = with_record(heard[0], tone(500), 50.0)
    high = with_record(heard[2], tone(2000), 62.0)
    assert text.headline([low, high]) == ("Load 2 N is 12 dB louder than load 0.5 N and brighter.")
    assert "Load 2 N: 80 % of the A-weighted power lies between 2 kHz and 2 kHz" in text.reason(
        [low, high]
    )
    other = [replace(low, summary=low.summary | {"laeq_db": 70}), high]
    assert text.headline(other) == "Load 0.5 N is 8.0 dB louder than load 2 N and darker."
    (flying, _) = runs_of("flying")  # of another source, which is not compared
    place = "80 % of the sound lies between 2 kHz and 2 kHz."
    assert text.headline([high, flying]) == f"load 2 N: {place}"
    assert text.headline([high]) == place


def test_a_difference_within_the_uncertainty_is_not_claimed(heard) -> None:
    alike = []
    for k, run in enumerate(heard[:2]):
        spread = run.summary["uncertainty_db"] | {"laeq": 0.2}
        numbers = {"laeq_db": 60.0 + k / 10, "uncertainty_db": spread}
        alike.append(replace(run, summary=run.summary | numbers))
    assert "as loud as load 0.5 N within the uncertainty" in text.headline(alike)


def test_widths_and_rates_are_of_the_contact(heard) -> None:
    """Hertz: a = (3 F R / 4 E*)^(1/3), E* of a rigid sphere on 210 GPa, 0.3; at 0.1 m/s."""
    run = heard[2]
    width = 2 * (0.75 * 2 * 5e-3 / (210e9 / (1 - 0.3**2))) ** (1 / 3)
    place = text.reason([run])
    assert f"{width * 1e6:.3g} µm, once in {width / 0.1 * 1e3:.2g} ms" in place


def test_a_vibrating_ball_rings_and_flies() -> None:
    _, fast = runs_of("flying")
    said = text.reason([fast])
    assert text.headline([fast]) in said
    summary = fast.summary
    assert f"rings on its contact at {summary['resonance_hz'] / 1e3:.2g} kHz" in said
    assert f"flies for {100 * summary['flight_share']:.0f} % of the time" in said
    assert f"hits the plate {summary['impacts']} times" in said


def test_a_reason_that_covers_little_is_not_given_as_one(heard) -> None:
    (run,) = runs_of("smooth")
    rough = run.scene.with_(kind="gaussian", roughness_ra_um=0.1, correlation_length_um=10, seed=1)
    loud = replace(with_record(run, tone(100), 60.0), scene=rough)
    loud = replace(loud, sound=replace(loud.sound, levels=heard[0].sound.levels))
    said = text.reason([loud])
    assert "Only 0 % of the A-weighted power lies between the two rates" in said
    inside = replace(loud, sound=replace(loud.sound, pressure=tone(5000)))
    assert "fit into the contact: 100 % of the" in text.reason([inside])


def test_silence_has_no_sentence() -> None:
    (silent,) = runs_of("smooth")
    assert text.reason([silent]) == "" and "No sound" in text.headline([silent])
    assert text.colour(silent) is None


def test_weighting_is_explained_where_it_raises_a_level(heard) -> None:
    words = dict(text.explanations(heard))
    raised = any(run.summary["laeq_db"] > run.summary["level_db"] for run in heard)
    assert ("LAeq above LZeq" in words) == raised
    above = replace(heard[0], summary=heard[0].summary | {"laeq_db": 61.0, "level_db": 60.0})
    assert "LAeq above LZeq" in dict(text.explanations([above]))
    assert {"steady level", "plastic ratio"} == set(words) - {"LAeq above LZeq"}


def test_runs_heard_by_their_vibration_have_the_words_of_their_own_columns() -> None:
    flying = runs_of("flying")
    words = dict(text.explanations(flying))
    heads, _ = text.levels(flying)
    assert "steady level" not in words
    for word in ("q that equals them", "F/W"):
        assert word in words and any(word in head for head in heads)
