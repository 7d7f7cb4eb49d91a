"""Write the figures of phonometry that `rolling validate` compares with.

    pip install phonometry==3.3.0     # Python 3.13; MIT licence
    python tests/benchmarks/phonometry_figures.py > scenarios/validation/phonometry.csv

The script imports nothing of this program, so that both compute alone. The test signal is defined
here and in `rolling.studies.validate` in the same way: standard normal numbers of `default_rng(1)`,
four seconds at 48 kHz, 0.1 Pa rms.
"""

from __future__ import annotations

import math

import numpy as np
import phonometry as ph

SOUND_M_S = 343.2  # of this program, so that the laws alone differ
RATE = 48000
# The plates of plates.yaml.
YOUNG_PA = 210e9
POISSON = 0.3
DENSITY_KG_M3 = 7850.0
THICKNESSES_MM = (2, 5, 10)
RADIATOR_MM = 5
EDGES_M = (1.2, 0.8)
BANDS = (315, 800, 2000, 3150, 8000)
TONES = (31.5, 250, 1000, 8000)
NOMINAL = {20: 100, 32: 1600, 40: 10000}


def plate(thickness_mm: float) -> tuple[float, float]:
    """Return mass per area [kg/m2] and bending stiffness [N m]."""
    thickness = 1e-3 * thickness_mm
    stiffness = ph.plate_bending_stiffness(YOUNG_PA, thickness, POISSON)
    return DENSITY_KG_M3 * thickness, stiffness


def row(quantity: str, item: str, value: float) -> None:
    print(f"{quantity},{item},{value:.6g}")


def main() -> None:
    print(f"# phonometry {ph.__version__} (MIT): pip install phonometry=={ph.__version__}")
    print("# python tests/benchmarks/phonometry_figures.py > scenarios/validation/phonometry.csv")
    print("quantity,item,value")
    for thickness in THICKNESSES_MM:
        mass, stiffness = plate(thickness)
        mobility = ph.infinite_plate_mobility(stiffness, mass)
        row("mobility", f"{thickness} mm", 1e3 * mobility)
        critical = ph.coincidence_frequency(mass, stiffness, speed_of_sound=SOUND_M_S)
        row("critical frequency", f"{thickness} mm", critical)
    critical = ph.coincidence_frequency(*plate(RADIATOR_MM), speed_of_sound=SOUND_M_S)
    radiation = ph.radiation_efficiency(BANDS, *EDGES_M, critical, speed_of_sound=SOUND_M_S)
    for band, efficiency in zip(BANDS, radiation.radiation_efficiency, strict=True):
        row("radiation efficiency", f'"{RADIATOR_MM} mm, {band} Hz"', 10 * math.log10(efficiency))
    times = np.arange(4 * RATE) / RATE
    for tone in TONES:
        sine = 0.1 * math.sqrt(2) * np.sin(2 * math.pi * tone * times)
        weighted = ph.weighting_filter(sine, RATE)[RATE:]
        row("A-weighting", f"{tone} Hz", 20 * math.log10(np.sqrt(np.mean(weighted**2)) / 0.1))
    noise = 0.1 * np.random.default_rng(1).standard_normal(4 * RATE)
    row("LAeq", "noise", float(ph.laeq(noise, RATE)))
    # Nominal middles by ten times the logarithm of the exact ones.
    levels, middles = ph.octave_filter(noise, RATE, fraction=3, limits=[100, 16000])
    for level, middle in zip(levels, middles, strict=True):
        if round(10 * math.log10(middle)) in NOMINAL:
            row("third octave", f"{NOMINAL[round(10 * math.log10(middle))]} Hz", level)
    tone = 0.02 * math.sqrt(2) * np.sin(2 * math.pi * 1000 * times)
    for name, signal in (("tone of 1 kHz", tone), ("noise", noise)):
        row("loudness", name, ph.loudness_zwicker(signal, RATE, stationary=True).loudness)
        row("sharpness", name, ph.sharpness_din(signal, RATE))


if __name__ == "__main__":
    main()
