"""Coverage of the differences that `rolling choose` states of bearings, against linear theory.

`python tests/benchmarks/bearing_choice_study.py` draws pairs of small bearings at random, with
nearly closed contacts, and chooses between the two of each pair as the command does. Linear theory
knows the truth from the laws of the surfaces alone: Hertz's ellipses, the mean of each wave over an
ellipse, the orders that move a ring, and the mobility of a ring on springs. None of it is code of
the program. The truth is the mean over specimens of the difference in decibels. The study counts
how many stated differences lie within one and within two ± of it, and prints the table of
docs/bearings.md, in some minutes of one core. With `--gains` it prints the other table instead, the
gains of a contact of a 6204 on four tracks.
"""

from __future__ import annotations

import argparse
import math
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

import rolling as rc
from acoustics.arrays import Array
from rolling.bearing import waves
from rolling.bearing_kind.contact_gain import contact_gain
from rolling.bearing_kind.contact_marches import march_contacts
from rolling.bearing_kind.contact_plan import contact_plan
from rolling.bearing_kind.joined_tracks import rough_rows

CHOICES = 20
WITHIN_DB = 1.0  # wanted ±
RECORD_S = 0.3
SPECIMENS = 4000  # of linear theory, over which the difference in decibels is averaged
CHANGES = ("inner", "outer", "balls", "length", "load")
BANDS_HZ = {"low": (50.0, 300.0), "medium": (300.0, 1800.0), "high": (1800.0, 10000.0)}
YOUNG_GPA = 208.0
POISSON = 0.3
GAIN_RA_UM = (0.02, 0.04, 0.1)
GAIN_SEEDS = (3, 11, 12, 13)
GAIN_WAVES = 6  # the longest, whose single gains are listed
GAIN_SURFACE = {
    "kind": "gaussian",
    "correlation_length_um": 60,
    "correlation_length_across_um": 10,
}
ACROSS_WAVES = 600  # wave numbers across the track, over which spectra are summed


# ---- pairs


def pair_of(number: int) -> tuple[str, dict[str, Any], dict[str, Any]]:
    """Return what differs between two bearings, and the values of both, drawn at random."""
    random = np.random.default_rng(number)

    def drawn(low: float, high: float) -> float:
        """Return a number between two others, evenly over the logarithm."""
        return float(np.exp(random.uniform(math.log(low), math.log(high))))

    diameter = drawn(5, 11)
    bearing: dict[str, Any] = {
        "balls": int(random.integers(7, 11)),
        "ball_diameter_mm": diameter,
        "pitch_diameter_mm": diameter * drawn(3.8, 4.6),
        "contact_angle_deg": drawn(10, 25),
        "conformity_inner": float(random.uniform(0.515, 0.53)),
        "conformity_outer": float(random.uniform(0.515, 0.53)),
        "youngs_modulus_gpa": YOUNG_GPA,
        "poissons_ratio": POISSON,
        "density_kg_m3": 7800.0,
        "speed_rpm": drawn(1500, 3000),
        "ring_mass_kg": 0.06 * (diameter / 8) ** 3,
        "contact_loss_factor": drawn(0.03, 0.1),
        "axial_load_n": 70 * (diameter / 8) ** 2 * drawn(0.7, 2),
    }
    surfaces = {}
    for body in ("inner", "outer", "balls"):
        surfaces[body] = {
            "kind": "gaussian",
            "roughness_ra_um": drawn(0.008, 0.03),
            "correlation_length_um": drawn(30, 80),
            "correlation_length_across_um": drawn(15, 40),
            "seed": int(random.integers(1, 1_000_000)),
        }
    if random.uniform() < 0.5:
        del surfaces["balls"]
    bearing["surfaces"] = surfaces
    values: dict[str, Any] = {
        "name": f"pair-{number}",
        "bearing": bearing,
        "sound": {"duration_s": RECORD_S},
        "numerics": {"window_mm": drawn(4, 12)},
    }
    changed = CHANGES[number % len(CHANGES)]
    if changed == "balls" and "balls" not in surfaces:
        changed = "inner"
    if changed in surfaces:
        key = f"bearing.surfaces.{changed}.roughness_ra_um"
        value = surfaces[changed]["roughness_ra_um"] * drawn(1.2, 2.5)
    elif changed == "length":
        key = "bearing.surfaces.outer.correlation_length_um"
        value = surfaces["outer"]["correlation_length_um"] * drawn(1.3, 2)
    else:
        key = "bearing.axial_load_n"
        value = bearing["axial_load_n"] * drawn(1.3, 2)
    return changed, values, {key: value}


# ---- linear theory


@dataclass(frozen=True)
class Ellipse:
    """Contact of a ball with a raceway: semi-axes [m], approach [m] and stiffness [N/m]."""

    along: float
    across: float
    approach: float
    stiffness: float


def hertz(radius_along: float, radius_across: float, load: float) -> Ellipse:
    """Solve a Hertz contact by elliptic integrals (Johnson, Contact Mechanics, section 4.2)."""
    modulus = YOUNG_GPA * 1e9 / (1 - POISSON**2) / 2
    wanted = radius_across / radius_along

    def mismatch(ratio: float) -> float:
        """Return how far the radii of an ellipse of axes a/b are from those given."""
        m = 1 - ratio**-2
        return float((ratio**2 * ellipe(m) - ellipk(m)) / (ellipk(m) - ellipe(m)) - wanted)

    ratio = brentq(mismatch, 1.0001, 1e3)
    m = 1 - ratio**-2
    shape = ratio**2 * ellipe(m) - ellipk(m)
    across = (3 * load * shape * radius_along / (math.pi * modulus * m)) ** (1 / 3)
    approach = 3 * load * ellipk(m) / (2 * math.pi * across * modulus)
    return Ellipse(across / ratio, across, approach, 1.5 * load / approach)


def wave_power(
    law: dict[str, Any], orders: Array, radius: float, ellipses: Sequence[Ellipse]
) -> Array:
    """Return the mean square [m2] of the sum of the approaches of contacts, by orders of a turn.

    Heights of a Gaussian law have the spectrum pi sigma^2 l_x l_y exp(-(k_x l_x)^2/4
    - (k_y l_y)^2/4). A contact averages a wave by sin(q)/q, with q^2 = (k_x a)^2 + (k_y b)^2.
    """
    sigma = 1e-6 * law["roughness_ra_um"] * math.sqrt(math.pi / 2)
    along = 1e-6 * law["correlation_length_um"]
    across = 1e-6 * law["correlation_length_across_um"]
    k_x = orders[:, None] / radius
    k_y = np.linspace(0, 8 / across, ACROSS_WAVES * 4)[None, :]
    spectrum = math.pi * sigma**2 * along * across
    spectrum = spectrum * np.exp(-((k_x * along) ** 2 + (k_y * across) ** 2) / 4)
    shares = [np.sinc(np.hypot(k_x * one.along, k_y * one.across) / math.pi) for one in ellipses]
    one_sided = 2 * np.trapezoid(spectrum * sum(shares) ** 2, k_y[0], axis=1) / (2 * math.pi)
    return 2 * one_sided / (2 * math.pi * radius)


def power_below(offset_hz: Array) -> Array:
    """Return the share of a line's power below an offset from it, in a Hann window's spectrum."""
    samples = 256
    spectrum = np.abs(np.fft.fft(np.hanning(samples), 64 * samples)) ** 2
    cumulative = np.cumsum(np.fft.fftshift(spectrum)) / spectrum.sum()
    lines = (np.arange(64 * samples) - 32 * samples + 0.5) / 64  # of the window
    return np.interp(offset_hz * RECORD_S / 2, lines, cumulative)


class LinearBearing:
    """Lines of a bearing whose ring moves along its radius, by linear theory.

    Parameters
    ----------
    bearing : dict. Keys of a scene's section `bearing`.
    """

    def __init__(self, bearing: dict[str, Any]) -> None:
        ball = 5e-4 * bearing["ball_diameter_mm"]
        pitch = 5e-4 * bearing["pitch_diameter_mm"]
        angle = math.radians(bearing["contact_angle_deg"])
        self.bearing = bearing
        self.balls = bearing["balls"]
        self.turn_hz = bearing["speed_rpm"] / 60
        reach = ball * math.cos(angle)
        self.radii = {"inner": pitch - reach, "outer": pitch + reach, "balls": ball}
        self.cage_hz = self.turn_hz * (1 - reach / pitch) / 2
        self.spin_hz = pitch / (2 * ball) * self.turn_hz * (1 - (reach / pitch) ** 2)
        load = bearing["axial_load_n"] / (self.balls * math.sin(angle))
        self.ellipses = {}
        for ring, sign in (("inner", 1), ("outer", -1)):
            curved = 1 / ball + sign * math.cos(angle) / self.radii[ring]
            across = 1 / (1 / ball - 1 / (2 * ball * bearing[f"conformity_{ring}"]))
            self.ellipses[ring] = hertz(1 / curved, across, load)
        series = 1 / sum(1 / one.stiffness for one in self.ellipses.values())
        self.push = series * math.cos(angle)  # force along a radius by an approach of its ball
        self.stiffness = self.balls / 2 * math.cos(angle) ** 2 * series

    @property
    def openness(self) -> float:
        """Largest rms roughness over the approach of its contact."""
        found = []
        for ring, ellipse in self.ellipses.items():
            for body in (ring, "balls"):
                law = self.bearing["surfaces"].get(body)
                if law is not None:
                    rq = 1e-6 * law["roughness_ra_um"] * math.sqrt(math.pi / 2)
                    found.append(rq / ellipse.approach)
        return max(found)

    def mobility(self, frequency_hz: Array) -> Array:
        """Return the amount of velocity over force [m/s/N] along a radius."""
        omega = 2 * math.pi * frequency_hz
        mass = self.bearing["ring_mass_kg"]
        loss = self.bearing["contact_loss_factor"] * math.sqrt(mass * self.stiffness)
        return omega / np.abs(self.stiffness - mass * omega**2 + 1j * omega * loss)

    def lines(self) -> Iterator[tuple[Array, Array]]:
        """Yield frequencies [Hz] and mean squares of the velocity [m2/s2], a row for each wave."""
        surfaces = self.bearing["surfaces"]
        together = self.balls / 2 * self.push
        for ring in ("inner", "outer"):
            passing = self.balls * (
                self.cage_hz if ring == "outer" else self.turn_hz - self.cage_hz
            )
            count = np.arange(1, int(12e3 / passing) + 2)
            for side in (-1, 1):
                orders = count * self.balls + side
                frequency = count * passing
                if ring == "inner":
                    frequency = frequency + side * self.turn_hz
                power = wave_power(surfaces[ring], orders, self.radii[ring], [self.ellipses[ring]])
                yield (
                    frequency[:, None],
                    (power * together**2)[:, None] * self.mobility(frequency)[:, None] ** 2,
                )
        if "balls" in surfaces:
            orders = np.arange(2, int(12e3 / self.spin_hz) + 2, 2)
            power = wave_power(
                surfaces["balls"], orders, self.radii["balls"], list(self.ellipses.values())
            )
            middle = orders * self.spin_hz
            frequency = np.stack([middle - self.cage_hz, middle + self.cage_hz], axis=1)
            # Each wave of a ball has two lines, along x with a quarter of its power each.
            square = (power * self.push**2)[:, None] / 4 * self.mobility(frequency) ** 2
            for _ in range(self.balls):
                yield frequency, square

    def levels(self) -> dict[str, float]:
        """Return the mean over specimens of the level [dB] in each band.

        The power of each wave of a Gaussian surface is exponentially distributed. A record spreads
        a line by the Hann windows of half its length, so that bands share lines at their edges.
        """
        random = np.random.default_rng(0)
        power = {band: np.zeros(SPECIMENS) for band in BANDS_HZ}
        for frequency, square in self.lines():
            luck = random.exponential(size=(SPECIMENS, len(square)))
            for band, (low, high) in BANDS_HZ.items():
                inside = power_below(high - frequency) - power_below(low - frequency)
                power[band] += luck @ np.sum(square * inside, axis=1)
        return {band: float(np.mean(10 * np.log10(of_band))) for band, of_band in power.items()}


# ---- choices


def chosen(number: int, within_db: float, folder: Path) -> list[dict[str, Any]]:
    """Choose between the bearings of a pair, and return a row for each band."""
    changed, values, change = pair_of(number)
    first = rc.BearingScene.from_dict(values)
    second = first.with_({"name": f"{values['name']}-changed", **change})
    choice = rc.choose(
        [first, second], folder=folder, within_db=within_db, workers=1, progress=False
    )
    (differences,) = choice.by_quantity
    sign = 1 if choice.labels[0] == first.name else -1  # the quieter one stands first
    theory = []
    openness = 0.0
    for scene in (first, second):
        linear = LinearBearing(scene.to_dict()["bearing"])
        openness = max(openness, linear.openness)
        theory.append(linear.levels())
    rows = []
    for band, apart in differences.items():
        truth = sign * (theory[1][band] - theory[0][band])
        rows.append(
            {
                "pair": number,
                "changed": changed,
                "window_mm": values["numerics"]["window_mm"],
                "openness": openness,
                "band": band,
                "specimens": apart.pairs,
                "theory_db": truth,
                "stated_db": apart.db,
                "uncertainty_db": apart.uncertainty_db,
                "gain_db": apart.parts_db["gains"],
                "ratio": (apart.db - truth) / apart.uncertainty_db,
            }
        )
    return rows


def table(found: pd.DataFrame) -> str:
    """Count the differences within one and within two ±, by band."""
    lines = ["|band|differences|within one ±|within two ±|rms error, dB|median ±, dB|"]
    lines.append("|---|---|---|---|---|---|")
    for band in (*BANDS_HZ, "all"):
        some = found if band == "all" else found[found.band == band]
        size = np.abs(some.ratio.to_numpy())
        rms = float(np.sqrt(np.mean((some.stated_db - some.theory_db) ** 2)))
        median = float(some.uncertainty_db.median())
        counts = f"{len(size)}|{_share(size < 1)}|{_share(size < 2)}"
        lines.append(f"|{band}|{counts}|{rms:.2f}|{median:.2f}|")
    return "\n".join(lines)


def _share(inside: np.ndarray) -> str:
    """Write a share with its counting error in percent."""
    count = len(inside)
    share = float(inside.mean())
    likely = (share * count + 1) / (count + 2)
    return f"{100 * share:.0f} ± {100 * math.sqrt(likely * (1 - likely) / count):.0f} %"


# ---- gains


def gain_table() -> str:
    """March the outer contact of a 6204 on some tracks, and state the gain of its long waves."""
    lines = ["|Ra, um|rms roughness over approach|gain, dB|its scatter, dB|single waves, dB|"]
    lines.append("|---|---|---|---|---|")
    for ra_um in GAIN_RA_UM:
        gains = []
        single: list[float] = []
        for seed in GAIN_SEEDS:
            rough = {**GAIN_SURFACE, "roughness_ra_um": ra_um, "seed": seed}
            surfaces = {"balls": None, "inner": None, "outer": rough}
            scene = rc.read_scene("bearing-6204").with_({"bearing.surfaces": surfaces})
            contact = contact_plan(scene).rough["outer"]
            only = replace(contact, loads_n=(contact.middle_load_n,))
            marches = march_contacts([only.scene], name="gains", workers=1, shown=False)
            rows = rough_rows(only, marches)
            gains.append(10 * math.log10(contact_gain(only, rows).power_gain()[0, 0]))
            before, after = (
                np.abs(np.fft.rfft(row[0])[1 : GAIN_WAVES + 1])
                for row in (only.own_linear_rows, rows)
            )
            single += (20 * np.log10(after / before)).tolist()
            approach = waves.hertz_approach(only.contact, only.middle_load_n)
        share = 1e-6 * ra_um * math.sqrt(math.pi / 2) / approach
        lines.append(
            f"|{ra_um:g}|{100 * share:.1f} %|{np.mean(gains):+.1f}|{np.std(gains, ddof=1):.1f}"
            f"|{min(single):+.0f} to {max(single):+.0f}|"
        )
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> int:
    """Choose between the pairs, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--choices", type=int, default=CHOICES, help=f"number ({CHOICES})")
    parser.add_argument("--first", type=int, default=0, help="number of the first pair (0)")
    parser.add_argument("--within", type=float, default=WITHIN_DB, help=f"wanted ± ({WITHIN_DB})")
    parser.add_argument("--out", type=Path, help="CSV of all differences (default: none)")
    parser.add_argument("--gains", action="store_true", help="print the table of gains instead")
    given = parser.parse_args(arguments)
    if given.gains:
        print(gain_table())
        return 0
    rows: list[dict[str, Any]] = []
    for number in range(given.first, given.first + given.choices):
        with tempfile.TemporaryDirectory() as folder:
            rows += chosen(number, given.within, Path(folder) / "choice")
        if given.out is not None:
            pd.DataFrame(rows).to_csv(given.out, index=False)
        print(f"pair {number}: {time.process_time():.0f} s so far", file=sys.stderr, flush=True)
    print(table(pd.DataFrame(rows)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
