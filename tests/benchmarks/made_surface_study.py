"""Skewness, kurtosis and spectrum of made surfaces against the requested ones.

`python tests/benchmarks/made_surface_study.py` prints the numbers of docs/made-surfaces.md: five
pairs, three laws and three seeds on 1024 x 256 nodes of 1 um.
"""

from __future__ import annotations

import time

import numpy as np

from rolling.scene.laws import HeightLaw, Roughness, SelfAffineLaw
from rolling.surface import made

SHAPE = (1024, 256)
SPACING = 1e-6
SEEDS = (1, 2, 3)
PAIRS = ((-0.8, 4.0), (-2.0, 8.0), (0.0, 2.0), (0.9, 3.1), (0.5, 10.0))
HARDER = (3, -3, 15), (10, 0, 1.2), (10, 1.5, 4), (30, 5, 60), (85, 0, 10), (85, -3, 15)


def law(name: str, seed: int, pair: tuple[float, float] = (0.0, 3.0)) -> HeightLaw:
    """Return a law of the study by its name."""
    shape = {"skewness": pair[0], "kurtosis": pair[1], "seed": seed}
    if name == "self-affine":
        return SelfAffineLaw(hurst=0.8, rolloff_um=50, shortest_um=4, rq_um=0.2, **shape)
    lengths = {"correlation_length_um": 10}
    if name == "exponential":
        lengths = {"correlation_length_um": 40, "correlation_length_across_um": 10, "lay_deg": 60}
    return Roughness(autocorrelation=name, roughness_ra_um=0.1, **lengths, **shape)


def described(of_law: HeightLaw) -> tuple[dict, float]:
    """Make the heights of a law, and return their description and the CPU time [s]."""
    start = time.process_time()
    heights = made.of_law(SHAPE, SPACING, of_law.in_si, of_law.seed)
    seconds = time.process_time() - start
    plain = of_law if not of_law.is_gaussian else of_law.model_copy(update={"kurtosis": 3.001})
    return made.described(heights, SPACING, plain.in_si), seconds


def main() -> None:
    """Print obtained moments by pair and law, and errors of the spectrum by octave and law."""
    print("| requested | law | obtained skewness, kurtosis (seeds 1, 2, 3) | largest difference |")
    print("|---|---|---|---|")
    spectra: dict[str, list[str]] = {}
    slowest = 0.0
    for name in ("gaussian", "exponential", "self-affine"):
        plain = {seed: described(law(name, seed))[0] for seed in SEEDS}
        octaves = [*plain[1]["spectrum_error_db"]]
        off = np.zeros(len(octaves))  # from the Gaussian surface of the seed
        for pair in PAIRS:
            results = []
            for seed in SEEDS:
                result, seconds = described(law(name, seed, pair))
                results.append((result["skewness"], result["kurtosis"]))
                slowest = max(slowest, seconds)
                for k, octave in enumerate(octaves):
                    both = (x["spectrum_error_db"][octave] for x in (result, plain[seed]))
                    off[k] = max(off[k], abs(np.subtract(*both)))
            texts = "; ".join("{:.4f}, {:.4f}".format(*result) for result in results)
            largest = np.abs(np.array(results) - pair).max()
            print(f"| {pair[0]:g}, {pair[1]:g} | {name} | {texts} | {largest:.4f} |")
        errors = np.array(
            [[plain[seed]["spectrum_error_db"][o] for o in octaves] for seed in SEEDS]
        )
        chances = [plain[1]["spectrum_chance_db"][octave] for octave in octaves]
        spectra[name] = [
            f"| {name} | {octave} | {' '.join(f'{x:+.2f}' for x in row)} | {chance:.2f} | {d:.3f} |"
            for octave, row, chance, d in zip(octaves, errors.T, chances, off, strict=True)
        ]
    print(f"\nslowest: {slowest:.1f} s of one core\n")
    print("| law | octave, um | error, dB (seeds 1, 2, 3) | chance, dB | by the pairs, dB |")
    print("|---|---|---|---|---|")
    print("\n".join(line for lines in spectra.values() for line in lines))
    print("\n| L, um | requested | obtained |\n|---|---|---|")
    for length, *pair in HARDER:
        hard = law("gaussian", 3, pair).model_copy(update={"correlation_length_um": float(length)})
        result = described(hard)[0]
        obtained = f"{result['skewness']:.3f}, {result['kurtosis']:.2f}"
        print(f"| {length} | {pair[0]:g}, {pair[1]:g} | {obtained} |")


if __name__ == "__main__":
    main()
