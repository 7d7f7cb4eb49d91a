"""Errors of the solver by its tolerance on many scenes, beside the error of the grid by its rule.

`python tests/benchmarks/tolerance_study.py` marches stretches of 60 scenes on their own grids, and
prints the numbers of docs/accuracy.md in two minutes of one free core. The reference is a tolerance
of 1e-6 on the same grid. `--steps N` sets the number of steps, and further arguments choose the
scenes whose names contain one of them. Scenes with a star had no part in the choice of a constant.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from small_scenes import small_scene
from tqdm import tqdm

from acoustics.arrays import Array
from acoustics.weighting import a_weighting_db
from rolling.contact.march import march
from rolling.contact.recovery import step_energy
from rolling.contact.state import RollingContact
from rolling.contact.subcells import half_space_of
from rolling.in_si.contact_of_scene import rolling_contact
from rolling.scene.file import loads
from rolling.scene.grid_error import grid_signal_db
from rolling.scene.scene import Scene
from rolling.scene.sections import VIBRATING_PLATE

TOLERANCES = (1e-3, 5e-4, 2e-4, 1e-4)
REFERENCE = 1e-6
USUAL = 1e-4  # whose counts are one
STEPS = 200  # a piece of a march, with its cold start
SPEED = 0.1  # [m/s], for A-weighting

TEXT = f"""
name: study
sphere: {{radius_mm: 5}}
plate: {{youngs_modulus_gpa: 210, poissons_ratio: 0.3}}
surface: {{kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10, spacing_um: 2,
          width_um: 512, seed: 1}}
rolling: {{load_n: 20, speed_m_s: {SPEED}, distance_mm: 3}}
numerics: {{step_nodes: 1}}
"""


@dataclass(frozen=True)
class StudyScene:
    """A scene by its changes to `TEXT`.

    name : str. Name in the table: Ra and correlation length in um, hardness in GPa, load in N.
    overrides : tuple of str. Changes, as `--set` takes them.
    unseen : bool. True if no constant of the rule was chosen on the scene.
    """

    name: str
    overrides: tuple[str, ...]
    unseen: bool = False


def random_plate(
    ra_um: float,
    length_um: float,
    load_n: float,
    hardness_gpa: float | None = None,
    spacing_um: float = 2.0,
    law: str = "gaussian",
    edges: str = "blended",
    seed: int = 1,
    others: tuple[str, ...] = (),
    unseen: bool = False,
) -> StudyScene:
    """Return a scene with a random plate, named by its values."""
    name = f"Ra {ra_um:g}, L {length_um:g}, {load_n:g} N"
    name += ", elastic" if hardness_gpa is None else f", {hardness_gpa:g} GPa"
    overrides = [
        f"surface.roughness_ra_um={ra_um}",
        f"surface.correlation_length_um={length_um}",
        f"surface.autocorrelation={law}",
        f"surface.spacing_um={spacing_um}",
        f"surface.width_um={256 * spacing_um}",
        f"surface.seed={seed}",
        f"rolling.load_n={load_n}",
        f"numerics.edges={edges}",
    ]
    if hardness_gpa is not None:
        overrides.append(f"plate.hardness_gpa={hardness_gpa}")
    if law != "gaussian":
        name += f", {law.replace('_', ' ')}"
    if spacing_um != 2:
        name += f", {spacing_um:g} um"
    if edges == "sharp":
        name += ", sharp"
    if others:
        name += f", {', '.join(others)}"
    return StudyScene(name, (*overrides, *others), unseen)


def self_affine(
    hurst: float, rdq: float, load_n: float, hardness_gpa: float, seed: int, unseen: bool = False
) -> StudyScene:
    """Return a scene with a self-affine plate."""
    surface = (
        f"surface={{kind: self-affine, hurst: {hurst}, rolloff_um: 100, shortest_um: 8,"
        f" rdq: {rdq}, spacing_um: 2, width_um: 512, seed: {seed}}}"
    )
    name = f"self-affine {hurst:g}, Sdq {rdq:g}, {load_n:g} N, {hardness_gpa:g} GPa"
    overrides = (surface, f"rolling.load_n={load_n}", f"plate.hardness_gpa={hardness_gpa}")
    return StudyScene(name, overrides, unseen)


def rough_ball(
    ra_um: float, ball_ra_um: float, load_n: float, hardness_gpa: float, unseen: bool = False
) -> StudyScene:
    """Return a scene with a random sphere on a random plate, or on a smooth one without a Ra."""
    ball = (
        f"sphere.surface={{kind: gaussian, roughness_ra_um: {ball_ra_um},"
        " correlation_length_um: 15, seed: 3}"
    )
    others = (ball, "rolling.distance_mm=31.415")
    scene = random_plate(ra_um or 0.1, 12, load_n, hardness_gpa, others=others, unseen=unseen)
    if not ra_um:
        smooth = "surface={kind: smooth, spacing_um: 2, width_um: 512}"
        loads = (f"rolling.load_n={load_n}", f"plate.hardness_gpa={hardness_gpa}")
        scene = StudyScene("", (smooth, *loads, *others), unseen)
    name = f"ball Ra {ball_ra_um:g} on Ra {ra_um:g}, {load_n:g} N, {hardness_gpa:g} GPa"
    return replace(scene, name=name)


EXPONENTIAL = "exponential"
TENTH = "exponential_10pct"
SCENES = (
    random_plate(0.002, 10, 5, spacing_um=1),
    random_plate(0.003, 30, 20, 6.3, spacing_um=4),
    random_plate(0.005, 20, 10),
    random_plate(0.01, 10, 2, 2.1),
    random_plate(0.01, 10, 5),
    random_plate(0.01, 10, 20, 2.1),
    random_plate(0.01, 60, 20, 2.1, spacing_um=4),
    random_plate(0.02, 20, 40),
    random_plate(0.02, 10, 10, 2.1, law=EXPONENTIAL),
    random_plate(0.03, 15, 1, 3),
    random_plate(0.03, 12, 60, 2.1, edges="sharp", seed=5),
    random_plate(0.05, 10, 100, 4),
    random_plate(0.1, 10, 0.3),
    random_plate(0.1, 10, 5, 2.1),
    random_plate(0.1, 10, 5, 2.1, edges="sharp"),
    random_plate(0.1, 10, 20),
    random_plate(0.1, 10, 20, 2.1),
    random_plate(0.1, 10, 100, 2.1),
    random_plate(0.1, 20, 20, 6.3, spacing_um=3),
    random_plate(0.1, 15, 50, spacing_um=3),
    random_plate(0.2, 10, 100),
    random_plate(0.3, 20, 20, 2.1, spacing_um=4),
    random_plate(0.3, 20, 100, 2.1),
    random_plate(0.3, 10, 5, 4, law=EXPONENTIAL),
    random_plate(0.3, 8, 2, spacing_um=1),
    random_plate(1, 10, 20, 2.1),
    random_plate(1, 10, 5, 2.1, edges="sharp"),
    random_plate(1, 20, 100, 6.3),
    random_plate(1, 30, 20),
    random_plate(1, 10, 5, 6.3, law=TENTH),
    self_affine(0.8, 0.03, 20, 2.1, seed=1),
    rough_ball(0.05, 0.05, 10, 2.1),
    random_plate(0.015, 12, 8, 3, seed=41, unseen=True),
    random_plate(0.05, 12, 2, 3, seed=42, unseen=True),
    random_plate(0.4, 12, 3, seed=43, unseen=True),
    random_plate(0.25, 20, 10, 1.8, spacing_um=2.5, seed=44, unseen=True),
    random_plate(0.6, 20, 30, 4, seed=45, unseen=True),
    random_plate(0.03, 10, 4, spacing_um=1.5, seed=46, unseen=True),
    random_plate(0.15, 8, 1, 5, edges="sharp", seed=47, unseen=True),
    random_plate(0.06, 25, 60, 3, spacing_um=3, seed=48, unseen=True),
    random_plate(0.3, 15, 4, 3, law=EXPONENTIAL, seed=49, unseen=True),
    random_plate(0.02, 15, 1, law=TENTH, seed=50, unseen=True),
    random_plate(0.1, 10, 5, 2.1, seed=51, others=("numerics.step_nodes=2",), unseen=True),
    random_plate(0.1, 10, 40, 2.1, seed=52, others=("numerics.step_nodes=4",), unseen=True),
    random_plate(0.2, 10, 8, 4, seed=53, others=("numerics.step_nodes=0.5",), unseen=True),
    random_plate(0.5, 15, 5, seed=54, others=("numerics.step_nodes=4",), unseen=True),
    random_plate(0.1, 10, 3, 4, seed=55, others=("sphere.radius_across_mm=15",), unseen=True),
    random_plate(
        0.1, 60, 5, 2.1, seed=56, others=("surface.correlation_length_across_um=8",), unseen=True
    ),
    random_plate(
        0.2, 12, 3, 3, seed=57, others=("surface.skewness=-1.5", "surface.kurtosis=6"), unseen=True
    ),
    self_affine(0.6, 0.05, 12, 3, seed=58, unseen=True),
    rough_ball(0.1, 0.03, 1, 5, unseen=True),
    rough_ball(0, 0.1, 3, 4, unseen=True),
)  # fmt: skip
SMALL = range(100, 108)  # numbers of `small_scene`, unseen as well


@dataclass(frozen=True)
class Stretch:
    """The numbers of one march.

    release : (steps,) array, J. Release of each step.
    rise : (steps - 1,) array, m. Second difference of the approach, which the vibration follows.
    iterations, convolutions : int. Numbers of all positions.
    """

    release: Array
    rise: Array
    iterations: int
    convolutions: int


def roll(contact: RollingContact, steps: int) -> Stretch:
    """March a contact over some steps."""
    half_space = half_space_of(contact.spacing, contact.contact_modulus, contact.subcells)
    release = []
    approach = []
    iterations = 0
    convolutions = 0
    old = None
    for state in march(contact, 0, steps, half_space):
        if old is not None:
            release.append(step_energy(old, state, half_space).release)
        approach.append(state.approach)
        iterations += state.iterations
        convolutions += state.convolutions
        old = state
    return Stretch(np.array(release), np.diff(approach, 2), iterations, convolutions)


def error_db(values: Array, exact: Array) -> float:
    """Return the rms error of a series over its rms fluctuation [dB]."""
    return float(20 * np.log10(np.std(values - exact) / np.std(exact)))


def level_change_db(values: Array, exact: Array, step: float) -> float:
    """Return the change [dB] of the A-weighted level of a series, from a tapered record."""
    frequency = np.fft.rfftfreq(len(values), step / SPEED)
    gain = np.zeros(len(frequency))
    gain[1:] = 10 ** (a_weighting_db(frequency[1:]) / 10)
    powers = []
    for series in (values, exact):
        lines = np.fft.rfft((series - series.mean()) * np.hanning(len(series)))
        powers.append(float(gain @ np.abs(lines) ** 2))
    return float(10 * np.log10(powers[0] / powers[1]))


def rows(name: str, scene: Scene, steps: int) -> list[dict[str, object]]:
    """March a scene with all tolerances, and return their errors and counts."""
    contact = rolling_contact(scene)
    grid_db = grid_signal_db(scene)
    assert grid_db is not None
    exact = roll(replace(contact, tolerance=REFERENCE), steps)
    stretches = {
        tolerance: roll(replace(contact, tolerance=tolerance), steps)
        for tolerance in {*TOLERANCES, scene.tolerance}
    }
    usual = stretches[USUAL]
    table: list[dict[str, object]] = []
    for tolerance, stretch in sorted(stretches.items(), reverse=True):
        error = error_db(stretch.release, exact.release)
        table.append(
            {
                "scene": name,
                "tolerance": tolerance,
                "chosen": "auto" if tolerance == scene.tolerance else "",
                "release dB": error,
                "below grid": grid_db - error,
                "approach dB": error_db(stretch.rise, exact.rise),
                "dB(A)": level_change_db(stretch.release, exact.release, contact.step),
                "iterations": stretch.iterations / usual.iterations,
                "convolutions": stretch.convolutions / usual.convolutions,
            }
        )
    return table


def without_dynamics(number: int) -> Scene:
    """Return a small random scene of a number without dynamics, whose tolerance may rise."""
    values = small_scene(number, steps=400)[0].to_dict()
    values["plate"] = {
        key: value for key, value in values["plate"].items() if key not in VIBRATING_PLATE
    }
    del values["dynamics"]
    values["sound"] = {}
    return Scene.from_dict(values)


def scenes(names: Sequence[str]) -> dict[str, Scene]:
    """Return all scenes by name, or those whose names hold one of the given texts."""
    named = {
        f"{study.name} *" if study.unseen else study.name: loads(TEXT, study.overrides)
        for study in SCENES
    }
    named |= {f"small scene {number} *": without_dynamics(number) for number in SMALL}
    if not names:
        return named
    return {name: scene for name, scene in named.items() if any(text in name for text in names)}


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table of the chosen scenes."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("names", nargs="*")
    parser.add_argument("--steps", type=int, default=STEPS)
    options = parser.parse_args(arguments)
    chosen = scenes(options.names)
    table = pd.DataFrame(
        [row for name, scene in tqdm(chosen.items()) for row in rows(name, scene, options.steps)]
    )
    print(table.to_string(index=False, float_format="{:.4g}".format))
    return 0


if __name__ == "__main__":
    sys.exit(main())
