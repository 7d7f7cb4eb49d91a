"""How far the sounds of shipped scenes stand apart from noise of the same spectrum.

`python tests/benchmarks/random_phases.py [SCENE...]` runs scenes, takes the sound that plays, and
gives its lines random phases. It prints the modulation of both, the kurtosis, and the ratio of the
modulations, as in docs/gallery.md. A sound of noise has a ratio of 1 and a kurtosis of 3. All
scenes take some ten minutes of processor time. `--set KEY=VALUE` changes all of them.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import numpy as np
import pandas as pd
from recognition_study import markdown, modulation

import rolling as rc
from acoustics import kurtosis, wav
from acoustics.arrays import Array
from rolling.kinds.heard_sound import played_sound
from rolling.kinds.registry import kind_of

SCENES = (
    "ball-with-flat",
    "steel-sheet",
    "round-ball-on-sheet",
    "marble-rolling-out",
    "ball-with-pit",
    "bearing-inner-fault",
    "bearing-outer-fault",
    "quickstart",
)
BAND_HZ = (0.5, 50.0)
DRAWS = 8


def with_random_phases(record: Array, seed: int) -> Array:
    """Return noise with the lines of a record (n,) and random phases."""
    lines = np.fft.rfft(record)
    turns = np.random.default_rng(seed).random(len(lines))
    turns[[0, -1]] = 0.0  # these lines are real
    return np.asarray(np.fft.irfft(lines * np.exp(2j * np.pi * turns), len(record)))


def measured(name: str, record: Array) -> dict[str, str | float]:
    """Return a row of the table: the measures of a record beside those of random phases."""
    own = modulation(record, wav.SAMPLE_RATE_HZ, BAND_HZ)
    drawn = [with_random_phases(record, seed) for seed in range(DRAWS)]
    others = [modulation(noise, wav.SAMPLE_RATE_HZ, BAND_HZ) for noise in drawn]
    return {
        "scene": name,
        "modulation": f"{own:.3f}",
        "of random phases": f"{np.mean(others):.3f} ± {np.std(others, ddof=1):.3f}",
        "ratio": f"{own / np.mean(others):.2f}",
        "kurtosis": f"{kurtosis(record):.2f}",
        "kurtosis of random phases": f"{np.mean([kurtosis(noise) for noise in drawn]):.2f}",
    }


def played(name: str, settings: Sequence[str]) -> Array:
    """Run a scene, and return the first channel of the sound that plays."""
    scene = rc.read_scene(name, list(settings))
    if name == "quickstart":
        scene = rc.read_scene(name, ["sweep=", "rolling.load_n=20", *settings])
    run = rc.simulate(scene, workers=2, progress=False)
    sound = played_sound(kind_of(run.scene).sounds(run))
    if sound is None:
        raise SystemExit(f"{name}: nothing plays")
    samples = np.asarray(sound.samples, dtype=float)
    return samples if samples.ndim == 1 else samples[:, 0]


def main(argv: Sequence[str] | None = None) -> None:
    """Run the scenes, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("scenes", nargs="*", default=SCENES, metavar="SCENE")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    given = parser.parse_args(argv)
    rows = []
    for name in given.scenes:
        rows.append(measured(name, played(name, given.set)))
        print(rows[-1], flush=True)
    print(markdown(pd.DataFrame(rows)))


if __name__ == "__main__":
    main()
