"""Rules of the check against marches and numbers by hand: grid, tolerance, resonance, memory."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from checked import Row, checked
from large_scenes import FILE, LAPS, scene_of
from scene_text import MADE, WIDE

from acoustics.arrays import Array
from rolling.check import findings, resolution
from rolling.check.memory_and_disk import memory
from rolling.check.run_size import run_size
from rolling.contact.half_space import HalfSpace
from rolling.contact.march import march
from rolling.contact.recovery import step_energy
from rolling.contact.state import RollingContact
from rolling.contact.subcells import half_space_of
from rolling.in_si.contact_of_scene import rolling_contact
from rolling.in_si.physics_of_scene import bodies_of
from rolling.kinds.reading import read_scene
from rolling.scene import grid_error
from rolling.scene.file import loads
from rolling.scene.identity import contact_keys
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
STEPS = 40


def finding(scene: Scene, key: str) -> Row:
    return next(each for each in checked(scene) if each.key == key)


def release(contact: RollingContact) -> Array:
    """Return the release [J] of the first steps of a march."""
    half_space = HalfSpace(contact.spacing, contact.contact_modulus)
    states = list(march(contact, 0, STEPS, half_space))
    pairs = pairwise(states)
    return np.array([step_energy(*pair, half_space).release for pair in pairs])


def error_db(coarse: Array, fine: Array) -> float:
    return float(20 * np.log10(np.std(coarse - fine) / np.std(fine)))


# ---- error of the grid


@pytest.mark.parametrize(
    "overrides",
    [
        [],
        [ELASTIC, "rolling.load_n=0.5", "surface.correlation_length_um=5"],
        ["numerics.edges=sharp", "rolling.load_n=2"],
        ["surface.spacing_um=4", "surface.width_um=300"],
        ["surface.width_um=254"],
    ],
    ids=["light", "elastic", "sharp", "4 um", "odd"],
)
def test_the_named_spacing_does(overrides: list[str]) -> None:
    """It silences the warning, the scene accepts it, and a little more would not do."""
    scene = loads(TEXT, overrides)
    warning = finding(scene, resolution.KEY).warning
    assert warning is not None
    spacing = float(warning.rpartition("spacing_um of at most ")[2].split(",")[0])
    finer = scene.with_({"surface.spacing_um": spacing})
    error = grid_error.grid_signal_db(finer)
    assert error is not None and resolution.WANTED_DB - 6 < error <= resolution.WANTED_DB - 0.5
    assert finding(finer, resolution.KEY).warning is None


def test_the_rule_knows_edges_sub_cells_and_laws() -> None:
    def error(*overrides: str) -> float:
        value = grid_error.grid_signal_db(loads(TEXT, overrides))
        assert value is not None
        return value

    assert error("numerics.edges=sharp") > error() + 5
    assert error("numerics.subcells=2") == pytest.approx(error() - 6)
    assert error(ELASTIC, "numerics.edges=sharp") == error(ELASTIC)
    assert error("rolling.load_n=5") < error() - 5
    assert error("surface.correlation_length_um=5") > error() + 3
    # shorter waves, in spite of its flat cells
    assert error("surface.autocorrelation=exponential") > error()


@pytest.mark.parametrize(
    "overrides",
    [
        ["rolling.load_n=0.5", "surface.correlation_length_um=5"],
        ["rolling.load_n=5", "surface.correlation_length_um=24"],
    ],
    ids=["coarse", "fine"],
)
def test_the_grid_rule_holds_for_marches_on_every_fourth_node(overrides: list[str]) -> None:
    """Short stretches scatter by 3 dB, and the rule was off by 10 dB at most."""
    scene = loads(TEXT, [*overrides, ELASTIC, "numerics.tolerance=1e-5"])
    own = rolling_contact(scene)
    fine = rolling_contact(scene.with_(spacing_um=0.5))
    fine = replace(fine, step=own.step)
    coarse = replace(fine, heights=fine.heights[::4, ::4].copy(), spacing=own.spacing)
    measured = error_db(release(coarse), release(fine))
    assert measured == pytest.approx(grid_error.grid_signal_db(scene), abs=10)


# ---- tolerance


@pytest.mark.parametrize(
    ("overrides", "tolerance"),
    [
        # Hertz deflections of 0.95, 0.38 and 2.8 um, contact radii of 34, 22 and 59 steps, and an
        # rms roughness of 1.25 Ra. The rule for the grid gives -29.7, -26.7 and -33.1 dB.
        ([], 1e-4),
        (["rolling.load_n=5"], 2e-4),  # 0.1 (1 + 1.53) / (21.7^2 sqrt(3.0)) = 3e-4, a little less
        (["rolling.load_n=100"], 7e-5),  # 10^(-43.1 / 20) / (4 x 22) = 7.9e-5
        (["rolling.load_n=0.5", "surface.roughness_ra_um=0.5"], 1e-3),
        (["surface.roughness_ra_um=0.01"], 3e-5),
        (["surface.roughness_ra_um=1e-6"], 1e-6),
        (["rolling.load_n=5", "plate.plasticity=permanent", "numerics.edges=sharp"], 1e-4),
        (["rolling.load_n=5", "surface.faults=[{kind: pit, at_mm: [1, 0], size_um: 40, "
          "depth_um: 1}]"], 1e-4),
        (["rolling.load_n=0.5", "numerics.step_nodes=0.25"], 1e-4),
        (["rolling.load_n=5", "sphere.density_kg_m3=7850", "plate.density_kg_m3=7850",
          "dynamics={}"], 1e-4),
        (["numerics.tolerance=0.003"], 0.003),
    ],
)  # fmt: skip
def test_tolerance_by_hand(overrides: list[str], tolerance: float) -> None:
    assert loads(WIDE, overrides).tolerance == tolerance


@pytest.mark.parametrize("roughness_um", [0.003, 0.01, 0.1])
def test_the_tolerance_keeps_the_solver_below_the_grid(roughness_um: float) -> None:
    """At 1e-4 on the smoothest surface it would be 5 dB above the limit."""
    scene = loads(WIDE, [f"surface.roughness_ra_um={roughness_um}", ELASTIC])
    scene = scene.with_(duration_s=0.002)
    contact = rolling_contact(scene)
    grid_db = grid_error.grid_signal_db(scene)
    assert grid_db is not None
    tight = release(replace(contact, tolerance=1e-7))
    assert error_db(release(contact), tight) < grid_db - 10


@pytest.mark.slow
@pytest.mark.law("Tolerance: the solver stays 10 dB below the grid, and the level within 0.01 dB.")
@pytest.mark.parametrize(
    ("overrides", "tolerance"),
    [
        (["rolling.load_n=0.4", ELASTIC, "surface.roughness_ra_um=0.15"], 1e-3),
        (["rolling.load_n=2", "numerics.edges=sharp", "surface.seed=8"], 6e-4),
        (["rolling.load_n=3", "numerics.step_nodes=2", "surface.roughness_ra_um=0.3"], 1e-3),
    ],
    ids=["elastic", "sharp", "steps of two nodes"],
)
def test_a_tolerance_above_the_usual_leaves_the_level(
    overrides: list[str], tolerance: float
) -> None:
    """None of these scenes had a part in the choice of a constant."""
    scene = loads(TEXT, [*overrides, "surface.width_um=384"])
    assert scene.tolerance == tolerance
    contact = rolling_contact(scene)
    grid_db = grid_error.grid_signal_db(scene)
    assert grid_db is not None
    half_space = half_space_of(contact.spacing, contact.contact_modulus, contact.subcells)
    series = []
    for accuracy in (tolerance, 1e-6):
        states = march(replace(contact, tolerance=accuracy), 0, 200, half_space)
        pairs = pairwise(states)
        series.append(np.array([step_energy(*pair, half_space).release for pair in pairs]))
    own, tight = series
    assert error_db(own, tight) < grid_db - 10
    assert abs(20 * np.log10(np.std(own) / np.std(tight))) < 0.01


@pytest.mark.parametrize(
    "change",
    [
        ["rolling.duration_s=0.01"],
        ["rolling.speed_m_s=2", "rolling.duration_s=0.01"],
        ["surface.seed=9"],
        ["numerics.error_estimate=true"],
        ["sound.source=release"],
    ],
)
def test_the_tolerance_is_the_same_for_all_tracks_over_a_surface(change: list[str]) -> None:
    light = ["rolling.load_n=5", "numerics.step_nodes=1"]  # the step counts, and auto may change it
    assert loads(WIDE, [*light, *change]).tolerance == loads(WIDE, light).tolerance == 2e-4


def test_the_number_of_the_automatic_tolerance_is_the_same_march() -> None:
    automatic = loads(WIDE, ["rolling.load_n=5"])
    assert contact_keys(automatic) == contact_keys(automatic.with_({"numerics.tolerance": 2e-4}))


# ---- resonance


def bounce_hz(*overrides: str) -> float:
    return bodies_of(loads(WIDE, overrides)).bounce_hz


def test_frequency_by_hand() -> None:
    # 2 E* a = 2 x 230.77 GPa x 68.75 um = 3.173e7 N/m; 7850 kg/m3 x 4/3 pi (5 mm)^3 = 4.110 g;
    # sqrt(k/m) / 2 pi = 13.98 kHz.
    assert bounce_hz() == pytest.approx(13.98e3, rel=1e-3)
    assert bounce_hz("sphere.density_kg_m3=2500") == pytest.approx(
        bounce_hz() * math.sqrt(7850 / 2500), rel=1e-12
    )
    # Two bodies of steel: E* halves, a grows by 2^(1/3), the stiffness falls by 2^(2/3), the
    # frequency by 2^(1/3).
    both = bounce_hz("sphere.youngs_modulus_gpa=210", "sphere.poissons_ratio=0.3")
    assert both == pytest.approx(bounce_hz() / 2 ** (1 / 3), rel=1e-12)


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        # a model of the dynamics at 20 N gives -44 dB at 0.1 m/s, -25 at 0.3 and -6 at 1 m/s
        ([], "30 dB or more below"),
        (["rolling.speed_m_s=0.3"], "of the sound is heard"),
        (["rolling.speed_m_s=1"], "a large part of the sound"),
        # without waves of the resonance there is little: -23 dB by the model
        (["rolling.speed_m_s=1", "surface.correlation_length_um=100"], "of the sound is heard"),
        ([], "a free ball of steel would ring"),
        (["sphere.density_kg_m3=2500", "rolling.load_n=5"], "of 2500 kg/m3 would ring on its"),
        # outside of the record: the steps carry 6.25 kHz; 35 kHz; 24.8 kHz; 12.5 kHz are reached
        (["numerics.step_nodes=4"], None),
        (["sphere.radius_mm=2"], None),
        (["sphere.density_kg_m3=2500"], None),
        (["rolling.speed_m_s=[[0, 0.05], [1, 0.05], [2, 1]]"], None),
    ],
)
def test_resonance_is_weighed(overrides: list[str], words: str | None) -> None:
    warning = finding(loads(WIDE, overrides), "resonance").warning
    assert warning is None if words is None else words in str(warning)


# ---- memory


STEEP = MADE.replace("0.1, corr", "1, corr")


@pytest.mark.parametrize(
    ("surface", "rest", "workers", "measured_mb"),
    [
        (FILE, LAPS % (5, 1), 1, 2007),
        (FILE, LAPS % (0.001, 100), 1, 1646),
        (MADE.replace("200", "16000"), "{load_n: 1, speed_m_s: 0.1, duration_s: 0.02}", 2, 879),
        (STEEP.replace("200", "10000"), "{load_n: 1, speed_m_s: 0.1, duration_s: 0.01}", 1, 591),
        (
            STEEP.replace("_um: 2,", "_um: 1,").replace("200", "600"),
            "{load_n: 50, speed_m_s: 0.1, duration_s: 0.005}\nnumerics: {step_nodes: 20}",
            1,
            546,
        ),
    ],
    ids=["laps", "long and slow", "wide", "sub-cells", "large window"],
)
def test_memory_is_the_measured_peak_within_a_factor_of_1_5(
    tmp_path: Path, surface: str, rest: str, workers: int, measured_mb: float
) -> None:
    """The peaks are those of the memory of all processes of `rolling run` without shared pages."""
    np.save(tmp_path / "heights.npy", np.random.default_rng(1).standard_normal((64, 64)) * 2e-8)
    scene = read_scene(scene_of(tmp_path, surface, rest))
    needed = sum(memory([run_size(run) for _, run in scene.runs()], workers).values())
    assert measured_mb / 1.5 < needed / 1e6 < 1.5 * measured_mb


# ---- keys that a kind of surface has

KINDS = {
    "gaussian": "{kind: gaussian, roughness_ra_um: 1, correlation_length_um: 10, spacing_um: 2, "
    "width_um: 64, seed: 1}",
    "self-affine": "{kind: self-affine, roughness_ra_um: 1, hurst: 0.8, rolloff_um: 50, "
    "shortest_um: 10, spacing_um: 2, width_um: 64, seed: 1}",
    "smooth": "{kind: smooth, spacing_um: 2, width_um: 64}",
    "file": "{kind: file, path: h.npy, spacing_um: 2}",
}
BALLS = {
    "plain": "",
    "gaussian": ", surface: {kind: gaussian, roughness_ra_um: 1, seed: 2, "
    "correlation_length_um: 5}",
    "graded": ", surface: {kind: graded, grade: G200, correlation_length_um: 3}",
}
MOTIONS = {
    "contact": ("", "", "load_n: 20, speed_m_s: 2, duration_s: 0.002"),
    "vibration": (
        "thickness_mm: 1, ",
        "dynamics: {}",
        "load_n: 2, speed_m_s: 2, duration_s: 0.002",
    ),
    "drop": (
        "thickness_mm: 1, ",
        "dynamics: {}",
        "load_n: weight, speed_m_s: 0.1, drop_mm: 300, distance_mm: 1",
    ),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("ball", BALLS)
@pytest.mark.parametrize("motion", MOTIONS)
def test_advice_names_keys_that_the_surface_has(
    kind: str, ball: str, motion: str, tmp_path: Path
) -> None:
    """Scenes in which nearly everything is wrong: each key in their advice may be set."""
    np.save(tmp_path / "h.npy", 1e-6 * np.random.default_rng(1).standard_normal((64, 64)))
    thickness, dynamics, rolling = MOTIONS[motion]
    scene = loads(
        f"name: wrong\n"
        f"sphere: {{radius_mm: 1, density_kg_m3: 7850{BALLS[ball]}}}\n"
        f"plate: {{{thickness}youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2,"
        f" density_kg_m3: 7850}}\n"
        f"surface: {KINDS[kind]}\nrolling: {{{rolling}}}\n{dynamics}\n",
        folder=tmp_path,
    )
    text = "\n".join(findings.check_scene(scene, solve=False).warnings)
    known = {"surface": scene.surface, "sphere.surface": scene.sphere.surface}
    named = re.findall(r"((?:sphere\.)?surface)\.(\w+)", text)
    assert text
    for section, key in named:
        part = known[section]
        assert part is not None and key in type(part).model_fields, (section, key, text)
