"""A looped record has force lines: the stated uncertainty covers the place of a sharp resonance."""

from __future__ import annotations

import math

import numpy as np
import pytest
from finished import VIBRATING
from helpers import hertz_law
from scene_sounds import vibration_over

from rolling.dynamics.force_law import ForceLaw
from rolling.scene.file import loads
from rolling.sound.vibration_sound import Vibration

NODES = 1500
SPACING = 2e-6
SCENE = ["rolling.load_n=20", f"rolling.distance_mm={NODES * SPACING * 1e3:g}", "sound.ball=false"]


def rough_law(rms: float = 2e-9, shortest: float = 30e-6, seed: int = 4) -> ForceLaw:
    """Return the law of a smooth ball on a closed track of noise."""
    lines = np.fft.rfft(np.random.default_rng(seed).standard_normal(NODES))
    lines *= np.exp(-np.square(np.fft.rfftfreq(NODES, SPACING) * shortest))
    height = np.fft.irfft(lines - lines[0] * (np.arange(lines.size) == 0), NODES)
    flat = hertz_law(20.0, 5e-3, 230e9)
    approach = flat.approach_m[:, :1] - height * (rms / height.std())
    return ForceLaw(np.arange(NODES) * SPACING, flat.load_n, approach, NODES * SPACING)


def smooth_noise(seed: int, shortest: float) -> np.ndarray:
    """Return closed noise of variance 1 along the track without waves shorter than a length [m]."""
    lines = np.fft.rfft(np.random.default_rng(seed).standard_normal(NODES))
    lines *= np.exp(-np.square(np.fft.rfftfreq(NODES, SPACING) * shortest))
    lines[0] = 0
    values = np.fft.irfft(lines, NODES)
    return np.asarray(values / values.std())


def uneven_law(seed: int) -> ForceLaw:
    """Return the law of a contact whose stiffness changes by 30 % along a closed track of noise."""
    flat = hertz_law(20.0, 5e-3, 230e9)
    approach = flat.approach_m[:, :1]
    under_load = approach[list(flat.load_n).index(20.0)]
    softness = np.exp(0.3 * smooth_noise(1000 + seed, 60e-6))
    height = 2e-9 * smooth_noise(seed, 15e-6)
    uneven = under_load + (approach - under_load) * softness - height
    return ForceLaw(np.arange(NODES) * SPACING, flat.load_n, uneven, NODES * SPACING)


LAW = rough_law()


def vibration(thickness: float, speed: float, law: ForceLaw = LAW) -> Vibration:
    keys = [f"plate.thickness_mm={thickness}", f"rolling.speed_m_s={speed}"]
    return vibration_over(loads(VIBRATING, [*SCENE, *keys]), law, 24e3)


PLATES = [(20, 0.3), (25, 1.3), (30, 2.0), (40, 0.5)]  # mm, m/s


@pytest.mark.law("Comb: speeds within 3 % have levels within the stated uncertainty.")
def test_uncertainty_covers_the_comb() -> None:
    """The level of the mean power over nine speeds is the level without luck.

    Twice a standard uncertainty holds 95 % of Gaussian errors; 33 of 36 levels are 92 %.
    """
    covered = by_length = 0
    for thickness, speed in PLATES:
        runs = [vibration(thickness, speed * ratio) for ratio in np.linspace(0.97, 1.03, 9)]
        levels = np.array([run.levels.laeq_db for run in runs])
        mean = 10 * np.log10(np.mean(10 ** (levels / 10)))
        for run, departure in zip(runs, np.abs(levels - mean), strict=True):
            covered += departure < 2 * run.uncertainty.laeq_db
            by_length += departure < 2 * run.spreads["record"]
        # The linear chain knows the mean; nine speeds may miss a peak.
        assert runs[4].mean_laeq == pytest.approx(mean, abs=2.5)
    assert covered >= 33 and by_length < 29


def test_a_broad_resonance_has_no_comb() -> None:
    broad = vibration(3, 0.1)
    assert "comb" not in broad.spreads and broad.mean_laeq is None
    assert broad.uncertainty.laeq_db == pytest.approx(broad.spreads["record"], rel=0.1)


@pytest.mark.slow
@pytest.mark.law("Comb: levels of seeds differ as much as their stated uncertainty.")
def test_seeds_differ_as_their_uncertainty_states() -> None:
    """Record and comb see the strengths of the same few lines, so their squares do not add up.

    Forty pairs are good to 11 %; added up, the parts gave 0.68.
    """
    runs = [vibration(16, 0.2, rough_law(seed=seed)) for seed in range(80)]
    assert all("comb" in run.spreads and not run.is_mean_of_comb for run in runs)
    levels = np.array([run.levels.laeq_db for run in runs])
    # The unknown loss of the contact is the same for all seeds.
    losses = np.array([run.spreads["contact_loss"] for run in runs])
    stated = np.sqrt(np.array([run.uncertainty.laeq_db for run in runs]) ** 2 - losses**2)
    ratio = (levels[::2] - levels[1::2]) / np.hypot(stated[::2], stated[1::2])
    assert 0.8 < np.sqrt(np.mean(ratio**2)) < 1.1


def test_a_wide_comb_states_its_mean_with_its_spread() -> None:
    """The level that is stated hardly depends on the speed; that of each record does."""
    runs = [vibration(40, 0.5 * ratio) for ratio in np.linspace(0.99, 1.01, 7)]
    assert all(run.is_mean_of_comb for run in runs)
    records = np.array([run.levels.laeq_db for run in runs])
    stated = np.array([run.stated_levels.laeq_db for run in runs])
    assert np.ptp(records) > 4 * np.ptp(stated)
    for run in runs:
        assert run.stated_levels.laeq_db == run.mean_laeq
        parts = run.spreads["comb"], run.spreads["contact_loss"]
        assert run.uncertainty.laeq_db == pytest.approx(math.hypot(*parts), rel=0.05)
        assert run.stated_levels.third_octave_db == run.levels.third_octave_db
        total = np.sqrt(sum(part**2 for part in run.parts.values()))
        assert run.uncertainty.laeq_db == pytest.approx(total)


@pytest.mark.law("Uncertainty: levels of contacts with uneven stiffness differ as they state.")
def test_levels_of_uneven_contacts_differ_as_their_uncertainty_states() -> None:
    """A resonance that moves along the track spreads the power over more lines than vary freely.

    A scatter of 40 levels is good to 11 %. The loss of the contact is the same for all.
    """
    runs = [vibration(6, 0.3, uneven_law(seed)) for seed in range(40)]
    scatter = np.std([run.levels.laeq_db for run in runs], ddof=1)
    stated = np.array([run.spreads["record"] for run in runs])
    gaussian = stated / np.sqrt([run.excess.laeq for run in runs])
    assert scatter > 1.3 * np.sqrt(np.mean(gaussian**2))
    assert scatter == pytest.approx(np.sqrt(np.mean(stated**2)), rel=0.25)
    for run in runs[:3]:
        assert run.uncertainty.laeq_db > run.spreads["record"]
        assert run.excess.third_octave.max() > 1.1
