"""Write the figures of phonometry that `rolling validate` compares with.

    pip install phonometry==3.3.0     # Python 3.13; MIT licence
    python tests/benchmarks/phonometry_figures.py > scenarios/validation/phonometry.csv

The script imports nothing of this program, so that both compute alone. The test signal is defined
here and in `rolling.validate` in the same way: standard normal numbers of `default_rng(1)`, four
seconds at 48 kHz, 0.1 Pa rms.
"""

from __future__ import annotations

import math

import numpy as np
import phonometry as ph

SOUND_M_S = 343.2  # of this program, so that the laws alone differ
RATE = 48000
STEEL = 210e9, 0.3, 7850.0
GLASS = 71e9, 0.23, 2500.0
PLATES = {"steel 1 mm": (STEEL, 1e-3), "steel 10 mm": (STEEL, 1e-2), "glass 8 mm": (GLASS, 8e-3)}
RADIATOR = "steel 5 mm", (STEEL, 5e-3), (1.2, 0.8)  # metres
BANDS = (315, 500, 800, 1250, 2000, 3150, 5000, 8000)
TONES = (31.5, 100, 250, 1000, 4000, 8000)
NOMINAL = {20: 100, 24: 250, 28: 630, 32: 1600, 36: 4000, 40: 10000}


def plate(material: tuple[float, float, float], thickness: float) -> tuple[float, float]:
    """Return bending stiffness [N m] and mass per area [kg/m2]."""
    young, poisson, density = material
    return ph.plate_bending_stiffness(young, thickness, poisson), density * thickness


def row(quantity: str, item: object, unit: str, value: float) -> None:
    print(f"{quantity},{item},{unit},{value:.6g}")


def main() -> None:
    print(f"# phonometry {ph.__version__} (MIT): pip install phonometry=={ph.__version__}")
    print("# python tests/benchmarks/phonometry_figures.py > scenarios/validation/phonometry.csv")
    print("quantity,item,unit,value")
    for name, (material, thickness) in PLATES.items():
        stiffness, mass = plate(material, thickness)
        row("mobility", name, "mm/(N s)", 1e3 * ph.infinite_plate_mobility(stiffness, mass))
        critical = ph.coincidence_frequency(mass, stiffness, speed_of_sound=SOUND_M_S)
        row("critical frequency", name, "Hz", critical)
    _, (material, thickness), edges = RADIATOR
    stiffness, mass = plate(material, thickness)
    critical = ph.coincidence_frequency(mass, stiffness, speed_of_sound=SOUND_M_S)
    radiation = ph.radiation_efficiency(BANDS, *edges, critical, speed_of_sound=SOUND_M_S)
    for band, efficiency in zip(BANDS, radiation.radiation_efficiency, strict=True):
        row("radiation efficiency", band, "dB", 10 * math.log10(efficiency))
    times = np.arange(4 * RATE) / RATE
    for tone in TONES:
        sine = 0.1 * math.sqrt(2) * np.sin(2 * math.pi * tone * times)
        weighted = ph.weighting_filter(sine, RATE)[RATE:]
        row("A-weighting", tone, "dB", 20 * math.log10(np.sqrt(np.mean(weighted**2)) / 0.1))
    noise = 0.1 * np.random.default_rng(1).standard_normal(4 * RATE)
    row("LAeq", "noise", "dB", float(ph.laeq(noise, RATE)))
    levels, middles = ph.octave_filter(noise, RATE, fraction=3, limits=[100, 16000])
    for level, middle in zip(levels, middles, strict=True):
        if round(10 * math.log10(middle)) % 4 == 0:
            row("third octave", NOMINAL[round(10 * math.log10(middle))], "dB", level)
    tone = 0.02 * math.sqrt(2) * np.sin(2 * math.pi * 1000 * times)
    for name, signal in (("tone of 1 kHz", tone), ("noise", noise)):
        row("loudness", name, "sone", ph.loudness_zwicker(signal, RATE, stationary=True).loudness)
        row("sharpness", name, "acum", ph.sharpness_din(signal, RATE))


if __name__ == "__main__":
    main()
