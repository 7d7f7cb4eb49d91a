"""Levels beside that of a run: the estimate by a linear chain, and a compact source."""

from __future__ import annotations

import math

import numpy as np
import pytest
from finished import VIBRATING, WITHOUT_DYNAMICS, heard_again, marched

from acoustics.arrays import Array
from acoustics.level import laeq_db
from acoustics.radiation import RHO_C
from acoustics.uncertainty import record_scatter_db
from acoustics.weighting import a_weighting_db
from rolling.in_si.assumed_bodies import bodies_text, with_bodies
from rolling.in_si.physics_of_scene import bodies_of, listener_of, smooth_contact_of
from rolling.marches.stiffness import solved_stiffness
from rolling.numbers.ball_numbers import RunNumbers
from rolling.results.level_words import number_rows
from rolling.results.run_result import Run
from rolling.scene.file import loads
from rolling.scene.scene import Scene
from rolling.sound.radiators import VibrationEstimate, vibration_estimate


@pytest.fixture(scope="module")
def rolled() -> Run:
    return marched(VIBRATING)


def estimate_of(
    scene: Scene, approach: Array, step: float, closed: bool, stiffness: float | None = None
) -> VibrationEstimate:
    """Return the estimate of a scene, by default with the stiffness of a smooth contact."""
    described = scene if scene.dynamics is not None else with_bodies(scene)
    return vibration_estimate(
        bodies_of(described),
        listener_of(described),
        scene.motion,
        approach=approach,
        step=step,
        closed=closed,
        stiffness_n_m=stiffness or smooth_contact_of(scene).stiffness_n_m,
    )


def test_a_sine_follows_the_chain() -> None:
    """A plate alone radiates rho F / (2 pi r m''), F = approach over the receptances in a row.

    The gain is averaged over the interval of the line, which changes it by less than 0.1 dB here.
    """
    scene = loads(VIBRATING, (*WITHOUT_DYNAMICS, "sound.ball=false", "plate.density_kg_m3="))
    steps = 2400
    step = 2e-6
    lines = 64
    approach = 1e-9 * np.cos(2 * np.pi * lines * np.arange(steps + 1) / steps)
    frequency = lines * 0.3 / (steps * step)  # 4 kHz
    w = 2 * math.pi * frequency
    mass = 4 / 3 * math.pi * 5e-3**3 * 7850
    radius = (0.75 * 1 * 5e-3 / scene.contact_modulus) ** (1 / 3)
    stiffness = 2 * scene.contact_modulus * radius
    area = 7850 * 10e-3
    bending = 210e9 * 10e-3**3 / (12 * (1 - 0.3**2))
    mobility = 1 / (8 * math.sqrt(bending * area))
    force = 1e-9 / abs(-1 / (mass * w**2) + 1 / stiffness + mobility / (1j * w))
    pressure = 1.204 * force / (2 * math.pi * area) / math.sqrt(2)
    expected = 20 * math.log10(pressure / 2e-5) + float(a_weighting_db(np.array([frequency]))[0])
    estimate = estimate_of(scene, approach, step, closed=True)
    assert estimate.laeq_db == pytest.approx(expected, abs=0.1)
    assert estimate.force_ratio == pytest.approx(force / math.sqrt(2), rel=0.01)  # at 1 N


@pytest.mark.parametrize("density", [7850, 2500])
def test_the_estimate_meets_the_motion(rolled: Run, density: float) -> None:
    """The estimate lies within twice its ± of the motion where contact holds.

    Most of the ± is that of the comb: lines of this short lap are 625 Hz apart.
    """
    scene = rolled.scene.with_({"sphere.density_kg_m3": density})
    moved = heard_again(rolled, scene).numbers
    held = held_again(rolled, scene)
    departure = held.vibration.value - moved.levels.vibration.laeq_db
    assert abs(departure) < 2 * held.vibration.uncertainty < 12
    assert held.estimate.bodies.endswith("on a 10 mm plate of 7850 kg/m³")


def held_again(run: Run, scene: Scene) -> RunNumbers:
    """Return the numbers of a run at a constant load over the marches of a run with dynamics."""
    without = {"dynamics": None, "sound.source": None, "plate.thickness_mm": None}
    return heard_again(run, scene.with_({**without, "plate.loss_factor": None})).numbers


ROUGH = (
    "surface.roughness_ra_um=0.3",
    "rolling.load_n=1",
    "rolling.distance_mm=0.6",
    "surface.width_um=240",
    "plate.youngs_modulus_gpa=40",
    "plate.density_kg_m3=1200",
)


@pytest.fixture(scope="module", params=["plate.hardness_gpa=", "plate.hardness_gpa=0.6"])
def rough(request: pytest.FixtureRequest) -> Run:
    return marched(VIBRATING, (*ROUGH, request.param))


@pytest.mark.slow
def test_the_stiffness_of_a_rough_contact_is_that_of_its_force_law(rough: Run) -> None:
    """A smooth contact is 1.2 times as stiff or more; solved positions tell within 12 %.

    The study found 7 % rms on 38 scenes.
    """
    law = rough.numbers.motion.contact_stiffness_n_m
    smooth = smooth_contact_of(rough.scene).stiffness_n_m
    assert smooth > 1.2 * law
    stiffness = solved_stiffness(rough.scene, rough.result)
    assert 1 / np.mean(1 / stiffness) == pytest.approx(law, rel=0.12)


def test_the_estimate_of_a_rough_contact_is_within_3_db(rough: Run) -> None:
    """The resonance, below hearing's end, falls with the stiffness and carries the level."""
    held = held_again(rough, rough.scene)
    stated = held.vibration.uncertainty
    departure = held.vibration.value - rough.numbers.levels.vibration.laeq_db
    assert abs(departure) < max(3.0, stated)


def test_the_estimate_has_the_band_of_the_run(rolled: Run) -> None:
    """A resonance above the Nyquist frequency of the steps rings as it does in the motion.

    Splines join the positions in both. The stiffness, which changes along the track, excites the
    resonance as well. An estimate from the resolved waves alone is some 10 dB too low.
    """
    slow = rolled.scene.with_({"rolling.speed_m_s": 0.025})
    run = heard_again(rolled, slow)
    numbers = run.numbers
    law = run.numbers.motion.contact_stiffness_n_m
    assert numbers.record.highest_frequency_hz < 0.95 * numbers.motion.resonance_hz < 12e3
    approach = run.result.series["approach"]
    estimate = estimate_of(slow, approach, run.result.step, run.sound.closed, law)
    assert abs(estimate.laeq_db - numbers.levels.vibration.laeq_db) < 3.0
    assert estimate.uncertainty_db > 2.0  # most of the sound lies beyond the steps


def test_bodies_of_an_estimate() -> None:
    scene = loads(VIBRATING, (*WITHOUT_DYNAMICS, "sphere.density_kg_m3=", "plate.density_kg_m3="))
    assert bodies_text(scene) == "a ball of steel on a 10 mm plate of steel"


REMEMBERS = (
    "plate.hardness_gpa=2",
    "plate.plasticity=permanent",
    "rolling.passes=2",
    "numerics.edges=sharp",
)


@pytest.mark.parametrize(
    "limits", [("plate.hardness_gpa=90",), ("plate.yield_strength_gpa=15",), REMEMBERS]
)
def test_a_plate_with_other_limits_than_steel_has_an_estimate(limits: tuple[str, ...]) -> None:
    """Steel without limits replaces a plate without a density; diamond's are higher than its."""
    hard = ("plate.youngs_modulus_gpa=1050", "plate.hardness_gpa=", *limits)
    scene = loads(VIBRATING, (*WITHOUT_DYNAMICS, "plate.density_kg_m3=", *hard))
    approach = 1e-9 * np.sin(2 * np.pi * 64 * np.arange(2401) / 2400)
    laeq = estimate_of(scene, approach, 2e-6, closed=True).laeq_db
    assert laeq is not None and math.isfinite(laeq)


@pytest.mark.parametrize("thickness", [1, 10])
def test_a_compact_source_has_the_power_of_the_plate(rolled: Run, thickness: float) -> None:
    """p^2 = rho c P / (2 pi r^2) lies 8 to 17 dB above the axis where the ball rings.

    The ring of 8.5 kHz lies above the coincidence of 10 mm, and below that of 1 mm. The A-weighting
    of whole bands at their middle differs by some tenths of a decibel.
    """
    changes = {"plate.thickness_mm": thickness, "sound.ball": False, "sound.distance_m": 2}
    numbers = heard_again(rolled, rolled.scene.with_(changes)).numbers
    level = numbers.levels.compact_source_level_db
    bands = numbers.bands.plate_power.by_name
    names = [name for name, db in bands.items() if db is not None]
    weights = a_weighting_db(np.array([float(name) for name in names]))
    powers = [
        1e-12 * 10 ** ((bands[name] + w) / 10) for name, w in zip(names, weights, strict=True)
    ]
    square = RHO_C * sum(powers) / (2 * math.pi * 2**2)
    # Powers belong to the record. The level follows the stated LAeq, which is the mean over a comb.
    to_mean = numbers.of_record.laeq_db - numbers.record.laeq_db
    assert level - to_mean == pytest.approx(10 * math.log10(square / 2e-5**2), abs=0.5)
    assert thickness == 1 or 8 < level - numbers.of_record.laeq_db < 17


def test_no_compact_source_without_a_loss_factor(rolled: Run) -> None:
    lossless = heard_again(rolled, rolled.scene.with_({"plate.loss_factor": None}))
    assert lossless.numbers.levels.compact_source_level_db is None
    heads = [row.head for row in number_rows([rolled.numbers, lossless.numbers])]
    assert any("compact source" in head for head in heads)
    assert not any("compact source" in row.head for row in number_rows([lossless.numbers]))


def test_thirds_scatter_as_the_level_of_a_record_does() -> None:
    """Over 300 records of white noise the scatter, less Student's factor, is the level's spread.

    Both are estimated within 5 %.
    """
    rng = np.random.default_rng(1)
    scatters = []
    levels = []
    for _ in range(300):
        noise = rng.standard_normal(4800)
        scatters.append(record_scatter_db(noise, 48000) / 1.32)
        levels.append(laeq_db(noise, 48000))
    assert math.sqrt(np.mean(np.square(scatters))) == pytest.approx(np.std(levels), rel=0.1)
    burst = np.where(np.arange(4800) < 800, 10.0, 0.1) * rng.standard_normal(4800)
    assert record_scatter_db(burst, 48000) > 4
