"""What the node spacing does to the sound: one band-limited surface on grids of 2, 1 and 0.5 um, steps of 2 um, 5 N, Ra 0.1 um.

python tests/benchmarks/grid_error.py    (a minute and a half; prints the errors against 0.5 um, capped at 2.1 GPa and elastic)
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from acoustics import level, radiation, resampling
from rolling import surface
from rolling.half_space import HalfSpace
from rolling.march import RollingContact, march
from rolling.recovery import step_energy

STEP, SPEED, WIDTH = 2e-6, 0.1, 256
BANDS = ("500", "1000", "2000", "4000", "8000", "16000")


def refined(heights: np.ndarray, times: int) -> np.ndarray:
    """The same band-limited periodic surface on a grid `times` finer, moved across so that the sphere's line stays put."""
    n, m = heights.shape
    lines = np.zeros((n * times, m * times), dtype=complex)
    rows, columns = (np.fft.fftfreq(k, 1 / k).astype(int) for k in (n, m))
    lines[np.ix_(rows % (n * times), columns % (m * times))] = np.fft.fft2(heights)
    # Mid-width, (n_across - 1) / 2 spacings, lies (times - 1) / 2 fine nodes further on.
    shift = np.exp(-2j * np.pi * np.fft.fftfreq(m * times) * (times - 1) / 2)
    return np.fft.ifft2(lines * shift[None, :]).real * times**2


def release(heights: np.ndarray, times: int, hardness: float, steps: int, tolerance: float = 1e-4) -> np.ndarray:
    """Energy released in each step [J] with the grid refined so many times."""
    modulus, spacing = 210e9 / (1 - 0.3**2), STEP / times
    contact = RollingContact(
        refined(heights, times), spacing, 5e-3, modulus, hardness, 5.0, STEP, 0.0, tolerance / times
    )
    half_space = HalfSpace(spacing, modulus)
    states = march(contact, 0, steps, half_space)
    return np.array([step_energy(old, new, half_space).release for old, new in pairwise(states)])


def levels(energy: np.ndarray) -> level.SoundLevels:
    """Levels at 1 m of a closed lap."""
    intensity = radiation.intensity(resampling.undo_step_mean(energy * SPEED / STEP), 1.0)
    samples = round(len(energy) * STEP / SPEED * 48000)
    closed = resampling.resample_closed(intensity, samples)
    return level.sound_levels(radiation.sound_pressure(resampling.band_limit(closed, 48000))[0], 48000)


def signal_error_db(energy: np.ndarray, reference: np.ndarray) -> float:
    """Rms error of the release signal re the rms of its fluctuation [dB]."""
    return float(20 * np.log10(np.std(energy - reference) / np.std(reference)))


def main(steps: int = 500) -> None:
    heights = surface.gaussian((steps, WIDTH), STEP, 1e-7, (10e-6, 10e-6), "gaussian", 1)
    print(f"{'plate':10}{'spacing':>9}{'signal dB':>11}{'mean %':>9}{'LAeq dB':>9}" + "".join(f"{b:>8}" for b in BANDS))
    for name, hardness in (("2.1 GPa", 2.1e9), ("elastic", np.inf)):
        energies = {times: release(heights, times, hardness, steps) for times in (1, 2, 4)}
        reference, best = energies[4], levels(energies[4])
        for times in (1, 2):
            got, energy = levels(energies[times]), energies[times]
            errors = [got.third_octave_db[b] - best.third_octave_db[b] for b in BANDS]  # type: ignore[operator]
            print(
                f"{name:10}{STEP / times * 1e6:6.1f} um{signal_error_db(energy, reference):11.1f}"
                f"{100 * (energy.mean() / reference.mean() - 1):9.3f}{got.laeq_db - best.laeq_db:9.3f}"  # type: ignore[operator]
                + "".join(f"{error:8.2f}" for error in errors)
            )


if __name__ == "__main__":
    main()
