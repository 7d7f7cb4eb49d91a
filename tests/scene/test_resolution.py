"""The rule for the error of the grid, and the spacing that it names."""

import time
from dataclasses import replace

import numpy as np
import pytest

from rolling.accuracy.edge_study import reference, roll
from rolling.check import resolution
from rolling.contact.of_scene import rolling_contact
from rolling.scene.file import loads
from rolling.scene.scene import Scene

TEXT = """\
name: coarse
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}
surface: {kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10, \
spacing_um: 2, width_um: 256, seed: 5}
rolling: {load_n: 0.1, speed_m_s: 0.1, duration_s: 0.005}
"""
ELASTIC = "plate.hardness_gpa="
EXPONENTIAL = "surface.autocorrelation=exponential"
COARSE = [
    [],
    [ELASTIC, "rolling.load_n=0.5", "surface.correlation_length_um=5"],
    ["numerics.edges=sharp", "rolling.load_n=2"],
    ["surface.spacing_um=4", "surface.width_um=300"],
    ["surface.width_um=254"],
]


def error_of(*overrides: str) -> float:
    error = resolution.grid_signal_db(loads(TEXT, overrides))
    assert error is not None
    return error


def warning_of(scene: Scene) -> str | None:
    (finding,) = resolution.findings(scene)
    return finding.warning


@pytest.mark.parametrize("overrides", COARSE, ids=["light", "elastic", "sharp", "4 um", "odd"])
def test_the_named_spacing_does(overrides: list[str]) -> None:
    """It silences the warning, the scene accepts it, and a little more would not do."""
    scene = loads(TEXT, overrides)
    warning = warning_of(scene)
    assert warning is not None
    spacing = float(warning.rpartition("spacing_um of at most ")[2].split(",")[0])
    finer = scene.with_({"surface.spacing_um": spacing})  # the scene accepts it
    error = resolution.grid_signal_db(finer)
    assert error is not None and resolution.WANTED_DB - 6 < error <= resolution.WANTED_DB - 0.5
    assert warning_of(finer) is None


def test_the_rule_knows_edges_sub_cells_and_laws() -> None:
    assert error_of("numerics.edges=sharp") > error_of() + 5
    assert error_of("numerics.subcells=2") == pytest.approx(error_of() - 6)
    assert error_of(ELASTIC, "numerics.edges=sharp") == error_of(ELASTIC)
    assert error_of("rolling.load_n=5") < error_of() - 5
    assert error_of("surface.correlation_length_um=5") > error_of() + 3
    assert error_of(EXPONENTIAL) > error_of()  # shorter waves, in spite of its flat cells
    warning = warning_of(loads(TEXT, ["numerics.edges=sharp"]))
    assert warning is not None and "choose numerics.edges: blended, or" in warning


def test_smooth_surfaces_have_no_error_of_the_grid() -> None:
    text = TEXT.replace(
        "kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10", "kind: smooth"
    )
    assert resolution.findings(loads(text.replace(", seed: 5", ""))) == []


@pytest.mark.parametrize(
    "overrides",
    [
        [ELASTIC, "rolling.load_n=0.5", "surface.correlation_length_um=5"],
        ["rolling.load_n=1", "surface.correlation_length_um=24"],
    ],
    ids=["coarse", "fine"],
)
def test_the_rule_holds_for_marches_at_a_quarter_of_the_spacing(overrides: list[str]) -> None:
    """Short stretches scatter by 3 dB, and the rule was off by 10 dB at most."""
    scene = loads(TEXT, [*overrides, "numerics.tolerance=1e-5"])
    own = rolling_contact(scene)
    sharp = rolling_contact(scene.with_({"numerics.edges": "sharp"}))
    fine = roll(reference(replace(sharp, start=own.start)), 40).release
    off = roll(own, 40).release - fine
    measured = 20 * np.log10(np.std(off) / np.std(fine))
    assert measured == pytest.approx(resolution.grid_signal_db(scene), abs=10)
    assert (measured > resolution.WANTED_DB) == (warning_of(scene) is not None)


def test_a_spacing_for_millions_of_nodes_is_found_at_once() -> None:
    scene = loads(TEXT, ["surface.width_um=60000", "surface.spacing_um=1"])
    began = time.process_time()
    assert resolution.fitting_spacing(scene, 1.2345678e-3) <= 1.2345678e-3
    assert time.process_time() - began < 1.0
