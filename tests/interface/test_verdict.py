"""Verdicts follow from known errors and broken limits, the largest first."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from finished import VIBRATING
from scene_text import PLAIN

from acoustics.bands import BAND_NAMES
from rolling.check.findings import check_scene
from rolling.results import caveats, runs_table, verdict
from rolling.results.run_folder import RunFolder
from rolling.scene.file import loads
from rolling.scene.messages import SceneError
from rolling.terminal import streams

SCENE = loads(VIBRATING)
# A vibration of which all is known, with errors below 1 dB.
KNOWN: dict[str, Any] = {
    "laeq_db": 40.0,
    "source": "vibration",
    "uncertainty_db": {"laeq": 0.4},
    "laeq_grid_error_db": 0.2,
    "laeq_grid_error_uncertainty_db": 0.1,
    "laeq_solver_error_db": -0.1,
    "laeq_subgrid_error_db": 0.3,
    "laeq_subgrid_error_uncertainty_db": 0.1,
    "caveats": [],
}


def near_half_space(band: str) -> dict[str, Any]:
    """Return the changes for a ball on a half-space that is heard in one band, at 1 m."""
    caveat = {"key": "half_space_sound", "text": "sound of a half-space: too loud"}
    return {"caveats": [caveat], "third_octave_a_db": dict.fromkeys(BAND_NAMES) | {band: 40.0}}


def warned(key: str) -> dict[str, Any]:
    """Return the changes for a run with a warning."""
    return {"caveats": [{"key": key, "text": f"{key}: doubtful: choose another"}]}


def cut_off(error_db: float, uncertainty_db: float) -> dict[str, Any]:
    """Return the changes for a run whose steps end within hearing."""
    return {
        "laeq_band_error_db": error_db,
        "laeq_band_error_uncertainty_db": uncertainty_db,
        "laeq_band_end_hz": 5000.0,
    }


@pytest.mark.parametrize(
    ("changes", "word", "reason"),
    [
        ({}, "trust", "length of the record leaves ± 0.4 dB"),
        ({"uncertainty_db": {"laeq": 1.2}}, "indicative", "length of the record"),
        ({"uncertainty_db": {"laeq": 3.2}}, "do not quote", "length of the record"),
        ({"laeq_grid_error_db": -0.9, "laeq_grid_error_uncertainty_db": 0.9}, "indicative", "grid"),
        ({"laeq_solver_error_db": -4.0}, "do not quote", "solver leaves 4 dB"),
        ({"laeq_grid_error_db": None}, "indicative", "grid is unknown"),
        ({"laeq_subgrid_error_db": None}, "indicative", "below its spacing"),
        ({"laeq_subgrid_error_db": 5.6}, "do not quote", "below its spacing"),
        ({"uncertainty_db": {"laeq": 2.1}, "comb_spread_db": 2.0}, "indicative", "by 2 dB"),
        (
            {"uncertainty_db": {"laeq": 3.1}, "comb_spread_db": 2.2},
            "do not quote",
            "together leave ± 3.1",
        ),
        ({"motion_step_error_db": 4.0}, "do not quote", "the time steps of the motion leave 4 dB"),
        ({"laeq_grid_error_db": None, "force_law_error_db": 4.0}, "do not quote", "force law"),
        ({"source": "release", "force_law_error_db": 4.0}, "indicative", "upper bound"),
        ({"source": "release", "comb_spread_db": 4.0}, "indicative", "upper bound"),
        ({"force_outside_share": 0.02}, "trust", "extrapolated for 2 %"),
        ({"force_outside_share": 0.51}, "do not quote", "extrapolated for 51 %"),
        ({"flight_share": 0.1, "record_scatter_db": 0.2}, "indicative", "lost for 10 %"),
        ({"flight_share": 0.1, "record_scatter_db": 4.0}, "do not quote", "lost for 10 %"),
        ({"impacts_yield": True}, "do not quote", "impacts would yield"),
        (
            {"caveats": [{"key": "slope", "text": "slope: steep: lower"}]},
            "do not quote",
            "slope: steep",
        ),
        # The published excess of a half-space is 5.2 dB at 1 kHz m, and 0.5 dB from 10 kHz m on.
        (near_half_space("1000"), "do not quote", "5.2 dB too loud so near"),
        (near_half_space("12500"), "trust", "0.5 dB too loud so near"),
        ({"caveats": [{"key": "resonance", "text": ""}]}, "trust", "length of the record"),
        ({"source": "release", "release_over_vibration_db": 45.2}, "indicative", "upper bound"),
        ({"source": "release", "laeq_grid_error_db": 9}, "do not quote", "the grid leaves"),
        # A measured error of the grid decides, and not a rule of thumb.
        (warned("hertz_nodes"), "trust", "length of the record"),
        (warned("resonance_wave"), "trust", "length of the record"),
        (warned("hertz_nodes") | {"laeq_grid_error_db": None}, "indicative", "hertz_nodes"),
        # The part above the Nyquist frequency of the steps counts by its decibels.
        (warned("nyquist"), "indicative", "nyquist"),
        (warned("nyquist") | cut_off(-8.4, 3.4), "do not quote", "8.4 ± 3.4 dB too low"),
        (warned("nyquist") | cut_off(1.5, 0.6), "indicative", "1.5 ± 0.6 dB too high"),
        (warned("nyquist") | cut_off(-0.2, 0.1), "trust", "length of the record"),
    ],
)
def test_the_worst_contribution_is_the_verdict(
    changes: dict[str, Any], word: str, reason: str
) -> None:
    judged = verdict.verdict(KNOWN | changes, SCENE)
    assert judged is not None and judged["word"] == word and reason in judged["reason"]
    ranks = [part["word"] for part in judged["contributions"]]
    assert ranks == sorted(ranks, key=verdict.WORDS.index, reverse=True)


def test_an_assumed_share_and_silence() -> None:
    scene = SCENE.with_({"sound.source": "release", "sound.q": 0.5})
    judged = verdict.verdict(KNOWN | {"source": "release"}, scene)
    assert judged is not None and "q = 0.5" in judged["reason"]
    assert verdict.verdict(KNOWN | {"laeq_db": None}, SCENE) is None


def test_three_warnings_the_largest_first(monkeypatch: pytest.MonkeyPatch) -> None:
    keys = ["air_load", "nyquist", "step_length", "slope", "seam"]
    summary = KNOWN | {"caveats": [{"key": key, "text": f"{key}: of it."} for key in keys]}
    summary |= {"verdict": verdict.verdict(summary, SCENE)}
    ordered = [caveat.key for caveat in caveats.warnings([("run", summary)])]
    assert ordered == ["slope", "nyquist", "seam", "step_length", "air_load"]
    monkeypatch.setattr(runs_table, "stored_summary", lambda run: summary | FILLED)
    run = RunFolder({}, SCENE, Path())
    text = runs_table.levels_table([run])
    assert text.count("warning: ") == 3 and "2 more warnings" in text.splitlines()[-1]


FILLED = {
    "levelling": None,
    "plastic_ratio": 0.0,
    "surface": dict.fromkeys(("ra", "rq", "skewness", "kurtosis", "rms_slope"), 1.0),
}


def test_lines_are_as_wide_as_the_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    text = "warning: " + "word " * 40
    assert streams.wrapped(text) == text  # a pipe, whose reader breaks lines as it likes
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    monkeypatch.setenv("COLUMNS", "60")
    assert max(map(len, streams.wrapped(text).splitlines())) <= 60


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ((), "at best indicative: a level of the released power (q = 1)"),
        (("surface.roughness_ra_um=2",), "is do not quote: rms slope: the rms slope is"),
        (("plate.hardness_gpa=0.001",), "It does not run: capacity"),
    ],
)
def test_the_check_ends_with_its_conclusion(changes: tuple[str, ...], words: str) -> None:
    scene = loads(PLAIN, ("surface.width_um=256", *changes))
    text = verdict.conclusion(scene, check_scene(scene, solve=False))
    assert words in text and text.endswith(".")
    assert text.startswith(("It does not run", "It runs, in a few seconds; ", "It runs, in about "))


def test_a_rule_for_the_grid_does_not_limit_a_run_that_measures() -> None:
    """Few nodes across the Hertz radius allow *indicative* unless the error is estimated."""
    changes = {"rolling.load_n": 0.02, "dynamics.release": False, "rolling.speed_m_s": 0.5}
    scene = loads(VIBRATING).with_({**changes, "rolling.distance_mm": 1.0})
    words = []
    for measures in (False, True):
        asked = scene.with_({"numerics.error_estimate": measures})
        found = [x for x in check_scene(asked, solve=False) if x.key == "hertz_nodes"]
        assert found[0].warning
        words.append(verdict.expected(asked, found)[0])
    assert words == ["indicative", "trust"]


def random_texts(count: int) -> Iterator[str]:
    """Check random scenes, from a grain of dust to a wheel, and yield all that is printed."""
    rng = np.random.default_rng(28)

    def decades(low: float, high: float) -> float:
        return float(f"{10 ** rng.uniform(low, high):.3g}")

    for _ in range(count):
        spacing, modulus = decades(-2, 2), decades(-3, 3)
        changes = {
            "sphere.radius_mm": decades(-2, 2.9),
            "plate.youngs_modulus_gpa": modulus,
            "plate.hardness_gpa": max(0.001, modulus * decades(-4, -1)) if modulus > 0.01 else None,
            "surface.roughness_ra_um": decades(-4, 3),
            "surface.correlation_length_um": decades(-1, 4),
            "surface.spacing_um": spacing,
            "surface.width_um": spacing * round(decades(1, 5)),
            "rolling.load_n": decades(-6, 7),
            "rolling.speed_m_s": decades(-4, 3),
            "rolling.duration_s": decades(-4, 3),
            "numerics.step_nodes": float(rng.integers(1, 65)),
            "numerics.error_estimate": bool(rng.random() < 0.5),
        }
        if rng.random() < 0.6:
            densities = {f"{body}.density_kg_m3": decades(1, 4.3) for body in ("sphere", "plate")}
            changes |= densities | {"dynamics": {}, "plate.thickness_mm": decades(-1, 3)}
        try:
            scene = loads(PLAIN).with_(changes)
            findings = check_scene(scene, solve=False)
            yield f"{findings}\n{verdict.conclusion(scene, findings)}"
        except SceneError as error:
            yield str(error)


def test_no_message_has_a_number_that_nobody_writes() -> None:
    """Of 60 random scenes no text says 1e+02 % or 2e-05 m."""
    texts = list(random_texts(60))
    odd = [match for text in texts for match in re.findall(r".{30}\de[+-]0.{9}", text)]
    assert odd == []
    assert sum("expected verdict" in text for text in texts) > 5
