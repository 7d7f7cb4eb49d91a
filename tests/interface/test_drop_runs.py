"""A run whose sphere falls: summary, verdict, record and sound."""

from __future__ import annotations

import numpy as np
import pytest

import rolling
from acoustics.wav import SAMPLE_RATE_HZ
from rolling.results import listening
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


def test_summary(run: Run) -> None:
    """A rigid ball at 0.0443 m/s on 10 mm: Zener's exp(-1.719 l) with l = 0.0298, 0.950."""
    summary = run.summary
    assert summary["drop_mm"] == 0.1
    # The marched law of a smooth contact is off by the error of its grid, some percent.
    assert summary["restitution"] == pytest.approx(0.950, abs=0.005)
    assert summary["load_n"] == pytest.approx(9.80665 * summary["ball_mass_kg"])
    assert summary["impacts"] > 1 and not summary["impacts_yield"]
    # Loads in the ratio of 4 up to the largest force, beyond which the law goes on as Hertz's.
    assert 1 / 4 < summary["force_law_max_n"] / summary["largest_force_n"] < 1
    assert summary["force_law_top_error"] < 0.01
    assert summary["release_over_vibration_db"] is None
    assert {"not_settled", "short_loop"}.isdisjoint(item["key"] for item in summary["caveats"])
    assert summary["verdict"]["word"] != "do not quote"


def test_record(run: Run) -> None:
    """It begins in silence, and is heard once: the sphere falls for 4.5 ms."""
    pressure = np.abs(run.sound.pressure)
    before = round(4.2e-3 * SAMPLE_RATE_HZ)
    # What comes before is the ringing of the filters of the sound.
    assert pressure[:before].max() < 0.02 * pressure.max()
    assert len(listening.laps(run.sound)) == len(pressure)
    assert "faded at its end" in listening.laps_in_words(run.sound)


def test_an_impact_that_yields_is_not_quoted(run: Run) -> None:
    harder = rolling.simulate(
        run.scene.with_({"rolling.drop_mm": 0.4, "surface.width_um": 200}),
        progress=False,
        workers=1,
    )
    assert harder.summary["impacts_yield"]
    assert harder.summary["verdict"]["word"] == "do not quote"
    assert "would yield" in harder.summary["verdict"]["reason"]
