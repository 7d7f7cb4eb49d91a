"""Pictures of runs with dynamics, and their place on the page."""

from __future__ import annotations

import numpy as np
import pytest
from test_vibration_runs import SWEPT

from acoustics.bands import BAND_NAMES
from rolling.commands.interface import simulate_sweep
from rolling.commands.run_files import page_of
from rolling.figures import run_figures, vibration_figures
from rolling.report import page
from rolling.scene.file import loads
from rolling.simulation.run_result import RunResult, hear


@pytest.fixture(scope="module")
def runs() -> list[RunResult]:
    return list(simulate_sweep(loads(SWEPT), 1, False).values())


def test_a_run_has_four_pictures_with_their_curves(runs: list[RunResult]) -> None:
    drawn = {picture.name: picture for picture in vibration_figures.pictures(runs[3])}
    assert tuple(drawn) == page.VIBRATION
    sources = drawn["sources"].columns
    assert len(sources["mid_frequency_hz"]) == len(BAND_NAMES)
    assert np.nanmax(sources["release_level_db"]) > np.nanmax(sources["vibration_level_db"])
    force = drawn["contact_force"].columns
    assert force["minimum_ratio"].min() == pytest.approx(runs[3].summary["force_min_ratio"])
    assert force["maximum_ratio"].max() == pytest.approx(runs[3].summary["force_max_ratio"])
    through = drawn["contact_filter"].columns
    assert np.nanmin(through["contact_filter_db"]) < -6  # short waves are averaged out
    bodies = drawn["mobilities"].columns
    total, f = bodies["all_three_in_a_row_s_kg"], bodies["frequency_hz"]
    assert f[total.argmin()] == pytest.approx(runs[3].summary["resonance_hz"], rel=0.05)


def test_a_run_without_dynamics_has_none_of_them(runs: list[RunResult]) -> None:
    scene = runs[0].scene.with_(
        {"dynamics": None, "sound.source": "release", "plate.thickness_mm": None}
        | {"plate.loss_factor": None}
    )
    plain = hear("plain", {}, runs[0].folder, scene, runs[0].result)
    assert plain is not None and plain.vibration is None
    assert not list(vibration_figures.pictures(plain))
    assert vibration_figures.speed_slopes([plain]) is None


def test_slopes_are_of_the_levels_over_speed(runs: list[RunResult]) -> None:
    picture = vibration_figures.speed_slopes(runs)
    assert picture is not None
    levels = [run.summary["vibration_laeq_db"] for run in runs if run.scene.plate.thickness_mm == 1]
    slope = (levels[1] - levels[0]) / np.log10(1 / 0.3)
    names = set(picture.columns["curve"].tolist())
    assert f"vibration, thickness 1 mm: {slope:.1f} dB per decade" in names
    assert len(names) == 4
    assert vibration_figures.slope_db([0.1, 1, 10], [5, 38, 71]) == pytest.approx(33.0)


def test_the_page_shows_shared_pictures_once(runs: list[RunResult]) -> None:
    shelf = [
        (run, page.exhibit(picture))
        for run, picture in run_figures.gallery(runs)
        if page.belongs(run, picture.name, len(runs))
    ]
    text = page_of(runs, shelf, []).decode()
    assert '<h2 id="vibration">Vibration</h2>' in text
    for words, count in (("Contact filter: ", 1), ("Mobilities: ", 2), ("Contact force: ", 4)):
        assert text.count(f'alt="{words}') == count, words
    assert text.count('alt="Both sources over speed: ') == 1
    assert "LAeq of the vibration [dB]" in text and "q that equals them" in text
    assert "an infinite plate without modes" in text
