"""Count which form is chosen for made scans: random, laid and wavy ones, and round parts.

    python tests/benchmarks/form_study.py [COUNT]

Each row is COUNT scans (default 40) of 160 x 120 nodes of 2 um with other random heights. The first
rows have no form; the others have one whose rms over that of the roughness is in their name.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable

import numpy as np

from rolling.surface.chosen_form import chosen_form

SHAPE = (160, 120)
STEP_M = 2e-6
NAMES = ("plane", "sphere", "cylinder", "quadratic")
Made = Callable[[np.random.Generator], np.ndarray]
X = STEP_M * (np.arange(SHAPE[0]) - (SHAPE[0] - 1) / 2)[:, None] * np.ones(SHAPE[1])
Y = STEP_M * (np.arange(SHAPE[1]) - (SHAPE[1] - 1) / 2) * np.ones(SHAPE)


def rough(
    random: np.random.Generator, along: float, across: float, power: float = 0.9
) -> np.ndarray:
    """Return heights of Sq 1 whose spectrum falls beyond two lengths [nodes]."""
    size = (2 * SHAPE[0], 2 * SHAPE[1])
    waves = np.hypot(np.fft.fftfreq(size[0])[:, None] * along, np.fft.rfftfreq(size[1]) * across)
    gain = (1 + 4 * np.pi**2 * waves**2) ** -power
    heights = np.fft.irfft2(np.fft.rfft2(random.normal(size=size)) * gain, size)
    heights = heights[: SHAPE[0], : SHAPE[1]]
    return np.asarray(heights / heights.std())


def self_affine(random: np.random.Generator, hurst: float) -> np.ndarray:
    """Return heights of Sq 1 of a self-affine spectrum without an end at long waves."""
    size = (4 * SHAPE[0], 4 * SHAPE[1])
    waves = np.hypot(np.fft.fftfreq(size[0])[:, None], np.fft.rfftfreq(size[1]))
    waves[0, 0] = np.inf
    gain = waves ** -(1 + hurst)
    heights = np.fft.irfft2(np.fft.rfft2(random.normal(size=size)) * gain, size)
    heights = heights[: SHAPE[0], : SHAPE[1]]
    return np.asarray(heights / heights.std())


def wavy(random: np.random.Generator, waves: float) -> np.ndarray:
    """Return waves of which so many fit in along the track, on a roughness of a tenth."""
    phase = random.uniform(0, 2 * np.pi)
    wave = np.cos(np.pi * waves * X / X.max() + phase)
    return np.asarray(wave + 0.1 * rough(random, 4, 4))


def turned(random: np.random.Generator) -> np.ndarray:
    """Return the marks of a tool that feeds 40 um along the track."""
    marks = np.abs(np.sin(np.pi * (X / 40e-6 + random.uniform())))
    return np.asarray(marks / marks.std() + 0.1 * rough(random, 4, 4))


def round_part(random: np.random.Generator, name: str, ratio: float) -> np.ndarray:
    """Return a form of 5 mm off the middle, on a roughness of its rms over a ratio."""
    off = random.uniform(-5e-5, 5e-5, 2)
    turn = random.uniform(0, np.pi)
    x = (X - off[0]) * np.cos(turn) + (Y - off[1]) * np.sin(turn)
    y = (Y - off[1]) * np.cos(turn) - (X - off[0]) * np.sin(turn)
    if name == "sphere":
        form = -np.sqrt(5e-3**2 - x**2 - y**2)
    elif name == "cylinder":
        form = -np.sqrt(5e-3**2 - x**2)
    else:
        form = (x**2 - 0.6 * y**2) / 1e-2
    form = form - form.mean()
    return np.asarray(form + form.std() / ratio * rough(random, 2, 2) + 0.01 * X)


ROWS: dict[str, Made] = {
    "random, short waves": lambda random: rough(random, 4, 4),
    "random, long waves": lambda random: rough(random, 25, 25),
    "random, smooth": lambda random: rough(random, 20, 20, 3.0),
    "self-affine, H 0.3": lambda random: self_affine(random, 0.3),
    "self-affine, H 0.8": lambda random: self_affine(random, 0.8),
    "lay across": lambda random: rough(random, 3, 200),
    "lay across, long waves": lambda random: rough(random, 15, 200),
    "lay along": lambda random: rough(random, 200, 6),
    "marks of a tool": turned,
    "1 wave": lambda random: wavy(random, 1.0),
    "1.5 waves": lambda random: wavy(random, 1.5),
    "3 waves": lambda random: wavy(random, 3.0),
    "sphere, 1": lambda random: round_part(random, "sphere", 1.0),
    "sphere, 10": lambda random: round_part(random, "sphere", 10.0),
    "cylinder, 1": lambda random: round_part(random, "cylinder", 1.0),
    "cylinder, 10": lambda random: round_part(random, "cylinder", 10.0),
    "saddle, 1": lambda random: round_part(random, "quadratic", 1.0),
    "saddle, 10": lambda random: round_part(random, "quadratic", 10.0),
}


def main() -> None:
    """Print the table."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 40
    print(f"|of {count} scans|{'|'.join(NAMES)}|")
    print("|---|---|---|---|---|")
    for number, (name, make) in enumerate(ROWS.items()):
        random = np.random.default_rng(number)
        levels = Counter(chosen_form(make(random), (STEP_M, STEP_M)).level for _ in range(count))
        print(f"|{name}|{'|'.join(str(levels[level]) for level in NAMES)}|", flush=True)


if __name__ == "__main__":
    main()
