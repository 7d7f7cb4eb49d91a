"""Measures by which listeners tell the shipped scenes apart, with their scatter over seeds.

`python tests/benchmarks/recognition_study.py [SCENE...]` runs the scenes of `SCENES`, or some of
them, with several seeds of their surfaces, and prints the numbers of docs/gallery.md. All scenes
take about ten minutes on two cores.
"""

from __future__ import annotations

import argparse
import itertools
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from scipy import signal

import rolling as rc
from acoustics import kurtosis
from acoustics.arrays import Array
from acoustics.bands import AUDIBLE_HZ
from acoustics.spectrum import line_spectrum
from acoustics.weighting import a_weighting_db
from rolling.sound.long_listening import Listening

FOLDER = Path(__file__).parents[2] / "scenarios"
SCENES = (
    "round-ball-on-sheet",
    "marble-rolling-out",
    "bearing-grades",
    "ball-with-pit",
    "marble-dropped",
    "quickstart",
)
SEEDS = 4
APART = 3.0  # times the scatter over seeds by which two scenes differ in a measure
# Bands of the modulation.
SLOW_HZ = (0.5, 8.0)
FAST_HZ = (8.0, 50.0)
_ENVELOPE_HZ = 400.0  # rate of the envelope
_SEGMENT_S = 0.5  # of the mean spectrum, from which the decay of modes follows


def centroid_hz(pressure: Array, rate: float) -> float:
    """Return the mean of the A-weighted log frequency [Hz]."""
    frequency, power = line_spectrum(pressure, rate)
    inside = (frequency >= AUDIBLE_HZ[0]) & (frequency < AUDIBLE_HZ[1])
    frequency = frequency[inside]
    weights = power[inside] * 10 ** (a_weighting_db(frequency) / 10)
    return float(np.exp(np.average(np.log(frequency), weights=weights)))


def correlation_time_ms(pressure: Array, rate: float) -> float:
    """Return the correlation time [ms] of a record with a flat smoothed spectrum.

    Modes that ring for long correlate a record with its past; noise of any colour does not.
    """
    length = round(_SEGMENT_S * rate)
    frequency, density = signal.welch(pressure, rate, nperseg=length)
    inside = (frequency > 100) & (frequency < 10e3)
    log = np.log(np.maximum(density, 1e-30))
    octave = np.log2(np.maximum(frequency, 1.0))
    edges = np.searchsorted(octave, (octave - 1 / 6, octave + 1 / 6))
    sums = np.concatenate(([0.0], np.cumsum(np.exp(log))))
    smooth = (sums[edges[1]] - sums[edges[0]]) / np.maximum(edges[1] - edges[0], 1)
    white = np.where(inside, np.exp(log) / np.maximum(smooth, 1e-30), 0.0)
    correlation = np.fft.irfft(white)
    return float(1e3 * np.sum(np.square(correlation[: length // 2] / correlation[0])) / rate)


def modulation(pressure: Array, rate: float, band: tuple[float, float]) -> float:
    """Return the rms modulation of the envelope within a band [Hz], over its mean."""
    envelope = np.abs(signal.hilbert(pressure))
    step = round(rate / _ENVELOPE_HZ)
    whole = len(envelope) // step * step
    slow = envelope[:whole].reshape(-1, step).mean(axis=1)
    frequency, square = line_spectrum(slow / slow.mean() - 1, rate / step)
    inside = (frequency >= band[0]) & (frequency < band[1])
    return float(np.sqrt(square[inside].sum()))


def measures(listening: Listening) -> dict[str, float]:
    """Return the measures of a long record."""
    pressure = listening.pressure
    rate = listening.sample_rate
    numbers = listening.numbers
    return {
        "LAeq, dB(A)": numbers.laeq_db,
        "centroid, Hz": centroid_hz(pressure, rate),
        "correlation time, ms": correlation_time_ms(pressure, rate),
        "modulation 0.5 to 8 Hz": modulation(pressure, rate, SLOW_HZ),
        "modulation 8 to 50 Hz": modulation(pressure, rate, FAST_HZ),
        "log10 kurtosis": float(np.log10(kurtosis(pressure))),
        "impacts per second": (numbers.impacts or 0) / numbers.seconds,
    }


def records(name: str, seeds: int) -> Iterator[dict[str, float | str]]:
    """Run a scene with several seeds of its surfaces, and yield the measures of each run."""
    scene = rc.read_scene(FOLDER / f"{name}.yaml")
    if name == "quickstart":
        scene = scene.with_({"rolling.load_n": 20, "numerics.error_estimate": False})
    for seed in range(1, seeds + 1):
        changes = {"surface.seed": seed}
        if getattr(scene.sphere.surface, "seed", None) is not None:
            changes["sphere.surface.seed"] = 100 + seed
        seeded = scene.with_(changes)
        for swept in seeded.runs():
            run = rc.simulate(swept.scene, workers=2, progress=False)
            label = " ".join([name, *map(str, swept.values.values())])
            if run.long is None:
                raise SystemExit(f"{label}: {run.no_long}")
            yield {"scene": label, "seed": seed, **measures(run.long)}


def differing(table: pd.DataFrame) -> pd.DataFrame:
    """List for each pair of scenes the measures that differ by more than `APART` scatters."""
    means = table.groupby("scene").mean()
    scatters = table.groupby("scene").std()
    rows = []
    for first, second in itertools.combinations(means.index, 2):
        distance = np.abs(means.loc[first] - means.loc[second])
        scatter = np.hypot(scatters.loc[first], scatters.loc[second])
        names = means.columns[distance > APART * scatter]
        rows.append({"first": first, "second": second, "differ in": "; ".join(names)})
    return pd.DataFrame(rows)


def markdown(table: pd.DataFrame) -> str:
    """Write a table as Markdown."""
    rows = [list(table.columns), ["---"] * len(table.columns), *table.to_numpy().tolist()]
    return "\n".join("| " + " | ".join(map(str, row)) + " |" for row in rows)


def main(argv: Sequence[str] | None = None) -> None:
    """Run the scenes, and print both tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("scenes", nargs="*", default=SCENES, choices=SCENES, metavar="SCENE")
    parser.add_argument("--seeds", type=int, default=SEEDS)
    given = parser.parse_args(argv)
    rows = []
    for name in given.scenes:
        for row in records(name, given.seeds):
            rows.append(row)
            print(row, flush=True)
    table = pd.DataFrame(rows).drop(columns="seed")
    grouped = table.groupby("scene")
    text = grouped.mean().map("{:.3g}".format) + " ± " + grouped.std().map("{:.2g}".format)
    print(markdown(text.reset_index()), markdown(differing(table)), sep="\n\n")


if __name__ == "__main__":
    main()
