"""Compare the uncertainty that an instrument leaves with the error over surfaces that are known.

A fine random surface is the truth. It is measured by styluses with balls of 2 and 5 um (the grey
dilation by a ball), by optics without waves below 4 um, with noise, and with every other node. Each
measurement runs with `surface.instrument`, and the truth runs without. The error of a level is that
over the measurement less that over the truth. The table counts how many errors lie within one and
two of the stated uncertainties.

    python tests/benchmarks/instrument_study.py 1 20            # seeds from 1 to 20, 20 minutes
    python tests/benchmarks/instrument_study.py --cutoff 1 14   # the constant of the cut-off
"""

from __future__ import annotations

import argparse
import math
from typing import Any, NamedTuple

import numpy as np
from scipy import ndimage

import rolling as rc
from acoustics.arrays import Array
from rolling.surface.instrument import InstrumentLimits, sight

SPACING = 0.5e-6
NODES = 2048
LEAST_DB = 0.02  # a smaller error and uncertainty count as agreement, and not as a case


class Case(NamedTuple):
    """A surface and a scene without a surface."""

    words: str
    heights: Array
    scene: dict[str, Any]
    rng: np.random.Generator


def random_surface(
    rng: np.random.Generator, shape: tuple[int, int], spacing: float, law: tuple[float, ...]
) -> Array:
    """Make heights [m] of rms 1 of a Gaussian law (L,) or a self-affine law (roll-off, H)."""
    along = np.fft.fftfreq(shape[0], spacing)[:, None]
    across = np.fft.rfftfreq(shape[1], spacing)[None]
    wave = 2 * np.pi * np.hypot(along, across)
    if len(law) == 1:
        density = np.exp(-np.square(wave * law[0]) / 4)
    else:
        density = (1 + np.square(wave * law[0] / (2 * np.pi))) ** -(1 + law[1])
    density[0, 0] = 0.0
    lines = np.fft.rfft2(rng.standard_normal(shape)) * np.sqrt(density)
    heights = np.fft.irfft2(lines, s=shape)
    return np.asarray(heights / heights.std())


def traced(heights: Array, spacing: float, radius: float) -> Array:
    """Return the trace of a stylus with a spherical tip: the grey dilation by its ball."""
    reach = int(radius / spacing)
    offsets = np.arange(-reach, reach + 1) * spacing
    square = offsets[:, None] ** 2 + offsets[None] ** 2
    ball = square <= radius**2 * (1 + 1e-9)
    drop = np.where(ball, np.sqrt(np.maximum(radius**2 - square, 0.0)) - radius, 0.0)
    return np.asarray(ndimage.grey_dilation(heights, footprint=ball, structure=drop, mode="wrap"))


def without_waves_below(heights: Array, spacing: float, wavelength: float) -> Array:
    """Return heights without the waves below a wavelength [m]."""
    along = np.fft.fftfreq(heights.shape[0], spacing)[:, None]
    across = np.fft.rfftfreq(heights.shape[1], spacing)[None]
    kept = np.hypot(along, across) < 1 / wavelength
    return np.asarray(np.fft.irfft2(np.fft.rfft2(heights) * kept, s=heights.shape))


def case(seed: int) -> Case:
    """Draw a surface and a scene, whose march takes seconds."""
    rng = np.random.default_rng(seed)

    def decade(low: float, high: float) -> float:
        return float(math.exp(rng.uniform(math.log(low), math.log(high))))

    rq = decade(0.03e-6, 0.2e-6)
    if seed % 4 == 0:
        length = decade(4e-6, 10e-6)
        law: tuple[float, ...] = (length,)
        words = f"Gaussian, {1e6 * length:.1f} um"
    else:
        length = decade(8e-6, 30e-6)
        law = (length, rng.uniform(0.3, 0.95))
        words = f"self-affine, {1e6 * length:.0f} um, H {law[1]:.2f}"
    radius = decade(1.5e-3, 4e-3)
    pressure = decade(0.4e9, 1.0e9)
    modulus = 210e9 / (1 - 0.3**2)
    load = (pressure * math.pi) ** 3 * radius**2 / (6 * modulus**2)
    contact = (3 * load * radius / (4 * modulus)) ** (1 / 3)
    wide = 2 * (1.5 * contact + math.sqrt(2 * radius * 5 * rq)) / SPACING
    nodes = 4 * math.ceil(min(max(wide, 64), 220) / 4)
    plate = {"youngs_modulus_gpa": 210, "poissons_ratio": 0.3, "density_kg_m3": 7850}
    plate |= {"thickness_mm": decade(0.5, 1.5), "contact_loss_factor": 0.1}
    if seed % 2:
        plate["hardness_gpa"] = 6.0
    scene = {
        "name": "study",
        "sphere": {"radius_mm": 1e3 * radius, "density_kg_m3": 7850},
        "plate": plate,
        "rolling": {
            "load_n": load,
            "speed_m_s": decade(0.02, 0.3),
            "distance_mm": 1e3 * NODES * SPACING,
        },
        "numerics": {"tolerance": 1e-3, "step_nodes": 2},
        "sound": {"source": "release"},
        "dynamics": {"release": False},
    }
    heights = rq * random_surface(rng, (NODES, nodes), SPACING, law)
    return Case(f"{words}, Sq {1e6 * rq:.2f} um", heights, scene, rng)


class Measurement(NamedTuple):
    """Heights as an instrument has them, and its keys."""

    name: str
    heights: Array
    spacing: float
    instrument: dict[str, float]


def measurements(drawn: Case) -> list[Measurement]:
    """Measure a surface with each instrument."""
    z = drawn.heights
    noise = z.std() * float(10 ** drawn.rng.uniform(-1.7, -0.7))
    noisy = z + noise * drawn.rng.standard_normal(z.shape)
    sharp = without_waves_below(z, SPACING, 4e-6)
    return [
        Measurement("2 um tip", traced(z, SPACING, 2e-6), SPACING, {"tip_radius_um": 2.0}),
        Measurement("5 um tip", traced(z, SPACING, 5e-6), SPACING, {"tip_radius_um": 5.0}),
        Measurement("optics", sharp, SPACING, {"sampling_um": 2.0}),
        Measurement("noise", noisy, SPACING, {"sampling_um": 0.5}),
        Measurement("1 um nodes", z[::2, ::2], 2 * SPACING, {"sampling_um": 1.0}),
    ]


def solved(scene: dict[str, Any], heights: Array, spacing: float, keys: dict[str, Any]) -> Any:
    """Return the numbers of a run over heights."""
    values = dict(scene)
    if spacing > SPACING:
        values["numerics"] = scene["numerics"] | {"step_nodes": 1}
    surface = rc.HeightArray(heights, spacing_um=1e6 * spacing, level="none", **keys)
    values["surface"] = surface.model_dump(exclude_none=True)
    return rc.simulate(rc.Scene.from_dict(values), workers=1, progress=False).numbers


def levels(first: int, last: int, only: str) -> None:
    """Print the errors and the uncertainties of all cases, and count them."""
    counts: dict[str, list[float]] = {}
    for seed in range(first, last + 1):
        drawn = case(seed)
        try:
            truth = solved(drawn.scene, drawn.heights, SPACING, {})
        except rc.ContactError as error:
            print(f"{seed}: no contact: {error}", flush=True)
            continue
        for made in measurements(drawn):
            if only not in made.name:
                continue
            keys = {"instrument": made.instrument}
            numbers = solved(drawn.scene, made.heights, made.spacing, keys)
            seen = numbers.surface.instrument
            line = f"{seed} {drawn.words}; {made.name}: above {1e6 * seen.cutoff_m:.2f} um"
            if seen.noise_m:
                line += f", noise {1e9 * seen.noise_m:.2f} nm"
            for stated, true in (
                (numbers.vibration, truth.vibration),
                (numbers.released_power, truth.released_power),
            ):
                name = stated.name
                spread = stated.parts.get("instrument")
                if spread is None or stated.value is None or true.value is None:
                    continue
                error = stated.value - true.value
                line += f"; {name} {error:+.2f}, stated {spread:.2f}"
                if max(abs(error), spread) > LEAST_DB:
                    for group in (f"{made.name}, {name}", f"all, {name}"):
                        counts.setdefault(group, []).append(abs(error) / spread)
            print(line, flush=True)
    for group, ratios in sorted(counts.items()):
        within = [sum(ratio <= limit for ratio in ratios) for limit in (1, 2, 3)]
        print(f"{group}: {within[0]}, {within[1]}, {within[2]} of {len(ratios)} within 1, 2, 3")


def cutoffs(first: int, last: int) -> None:
    """Print rms curvature times radius at the wavelength of half the coherence with the truth."""
    spacing = SPACING / 2
    for seed in range(first, last + 1):
        rng = np.random.default_rng(seed)
        rq = float(10 ** rng.uniform(-1.3, -0.2)) * 1e-6
        law = (float(10 ** rng.uniform(0.8, 1.5)) * 1e-6, rng.uniform(0.3, 0.95))
        z = rq * random_surface(rng, (512, 512), spacing, law)
        wave = np.hypot(*np.meshgrid(*2 * [np.fft.fftfreq(512, spacing)], indexing="ij"))
        edges = np.geomspace(2 / (512 * spacing), 0.5 / spacing, 25)
        band = np.digitize(wave.ravel(), edges)
        true = np.fft.fft2(z)
        for radius in (2e-6, 5e-6):
            trace = np.fft.fft2(traced(z, spacing, radius))
            sums = [
                np.bincount(band, values.ravel(), 26)[1:-1]
                for values in (np.abs(true) ** 2, np.abs(trace) ** 2, (true * trace.conj()).real)
            ]
            lost = np.flatnonzero(sums[2] ** 2 < 0.5 * sums[0] * sums[1])
            if not len(lost):
                continue
            end = math.sqrt(edges[lost[0]] * edges[lost[0] + 1])
            lines = np.abs(trace) ** 2 / z.size**2 * (2 * np.pi * wave) ** 4 * 3 / 8
            curvature = math.sqrt(float(lines[(wave > 0) & (wave < end)].sum()))
            ours = sight(
                np.fft.ifft2(trace).real,
                spacing,
                InstrumentLimits(tip_radius_m=radius),
            )
            print(
                f"{seed} H {law[1]:.2f}, Sq {1e6 * rq:.2f} um, {1e6 * radius:g} um tip: "
                f"half the coherence at {1e6 / end:.2f} um, where curvature times radius is "
                f"{curvature * radius:.2f}; cut-off {1e6 * ours.cutoff:.2f} um"
            )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("first", type=int)
    parser.add_argument("last", type=int)
    parser.add_argument("--cutoff", action="store_true")
    parser.add_argument("--only", default="", help="part of the name of the measurements")
    given = parser.parse_args()
    if given.cutoff:
        cutoffs(given.first, given.last)
    else:
        levels(given.first, given.last, given.only)
