"""Measure how far the first bands of bearings with a pit are from those of their whole runs.

Bearings, pits, loads and seeds are drawn from a fixed seed: 6204, 608 and 6305 with a pit in the
inner raceway, the outer raceway or a ball, dry and in oil. Each is marched as a whole run does it.
Its ring is moved as a first answer moves it, and for the whole record over all marches. Both have
the same waves, damping and films, so of the parts of the ± only those in `DIFFERING` are compared.
Run as `python tests/benchmarks/first_bands_study.py`; it takes ten minutes of
one core.
"""

from __future__ import annotations

import argparse
import itertools
import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import rolling as rc
from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing.band_uncertainty import LINEAR, ONE_LOAD, RECORD
from rolling.bearing.ring_record import DIRECTIONS
from rolling.bearing_kind.bearing_simulation import move_bearing
from rolling.bearing_kind.contact_marches import march_contacts
from rolling.bearing_kind.contact_plan import contact_plan
from rolling.bearing_kind.contact_uncertainty import contact_uncertainty
from rolling.bearing_kind.first_motion import pilot_of
from rolling.bearing_kind.velocities import velocities_below_bending
from rolling.kinds.run_folder import RunFolder
from rolling.marches.piece import contact_identity
from rolling.numbers.bearing_numbers import RingVelocities
from rolling.run.march_files import Marches

SEED = 1
BEARINGS = ("6204", "608", "6305")
BODIES = ("inner", "outer", "balls")
PITS_UM = (200, 1000)  # least and largest width, drawn evenly over the logarithm
RADIAL_N = (20, 300)
AXIAL_N = (20, 150)
RECORD_S = 3.0
WINDOW_MM = 4.0  # of track, on which both have their roughness
DIFFERING = (RECORD, LINEAR, ONE_LOAD)
OIL = {"viscosity_40_mm2_s": 32, "temperature_c": 30}


class Case(NamedTuple):
    """A bearing with a pit, and what is drawn of it."""

    words: str
    scene: rc.BearingScene


class Compared(NamedTuple):
    """A band of a first answer and of the whole run [um/s], with both ± by their parts [dB]."""

    case: str
    direction: str
    band: str
    first: float
    whole: float
    first_parts: dict[str, float]
    whole_parts: dict[str, float]

    @property
    def difference_db(self) -> float:
        """Level of the first answer less that of the whole run."""
        return 20 * math.log10(self.first / self.whole)

    @property
    def spread_db(self) -> float:
        """Standard uncertainty of the difference by the parts in which both differ."""
        own = [self.first_parts.get(name, 0.0) for name in DIFFERING]
        return math.hypot(*own, self.whole_parts[RECORD])

    @property
    def stated_db(self) -> float:
        """Standard uncertainty that the first answer states, by all its parts."""
        return math.hypot(*self.first_parts.values())


def cases() -> list[Case]:
    """Return the bearings: each body dry and in oil, in bearings that take turns."""
    random = np.random.default_rng(SEED)
    drawn = []
    for number, (body, is_in_oil) in enumerate(itertools.product(BODIES, (False, True))):
        for place in range(2):
            named = BEARINGS[(number + place) % len(BEARINGS)]
            width_um = _drawn(random, *PITS_UM)
            radial_n = _drawn(random, *RADIAL_N)
            axial_n = _drawn(random, *AXIAL_N)
            seed = int(random.integers(1000))
            pit = {"kind": "pit", "at_mm": [2, 0], "size_um": width_um, "depth_um": width_um / 2}
            surfaces: dict[str, dict[str, Any]] = {
                "balls": {"kind": "graded", "grade": "G10", "seed": seed},
                "inner": {"kind": "raceway", "finish": "superfinished", "seed": seed + 1},
                "outer": {"kind": "raceway", "finish": "superfinished", "seed": seed + 2},
            }
            surfaces[body]["faults"] = [pit]
            bearing: dict[str, Any] = {
                "named": named,
                "speed_rpm": 1800,
                "axial_load_n": axial_n,
                "radial_load_n": radial_n,
                "surfaces": surfaces,
            }
            if is_in_oil:
                bearing["oil"] = OIL
            values = {
                "name": "first-bands",
                "bearing": bearing,
                "numerics": {"window_mm": WINDOW_MM},
                "sound": {"duration_s": RECORD_S, "listen_s": RECORD_S},
            }
            scene = rc.BearingScene.from_dict(values)
            condition = "in oil" if is_in_oil else "dry"
            words = (
                f"{named} {condition}, {width_um:g} um in {body}, {axial_n:g} N axial,"
                f" {radial_n:g} N radial"
            )
            drawn.append(Case(words, scene))
    return drawn


def _drawn(random: np.random.Generator, least: float, largest: float) -> float:
    """Return a value between two, drawn evenly over the logarithm, to two digits."""
    value = math.exp(random.uniform(math.log(least), math.log(largest)))
    return float(f"{value:.2g}")


def compare(case: Case, workers: int) -> list[Compared]:
    """March a bearing, and return its bands as of a first answer and of the whole run."""
    stages = contact_plan(case.scene).stages
    contacts = [contact for stage in stages for contact in stage]
    marches = march_contacts(contacts, name=case.words, workers=workers, shown=False)
    pilot = pilot_of(case.scene)
    assert pilot is not None
    needed = {contact_identity(march.scene) for march in pilot.marches}
    first_marches = {name: march for name, march in marches.items() if name in needed}
    first = velocities(pilot.scene, first_marches)
    whole = velocities(case.scene, marches)
    compared = []
    for direction, band in itertools.product(DIRECTIONS, VELOCITY_BANDS_HZ):
        of_first = getattr(first, direction).by_band[band]
        of_whole = getattr(whole, direction).by_band[band]
        compared.append(
            Compared(
                case=case.words,
                direction=direction,
                band=band,
                first=of_first.value,
                whole=of_whole.value,
                first_parts=dict(of_first.parts),
                whole_parts=dict(of_whole.parts),
            )
        )
    return compared


def velocities(scene: rc.BearingScene, marches: Marches) -> RingVelocities:
    """Move the ring of a scene over marches, and return its velocities with their ±."""
    plan = contact_plan(scene)
    bearing = move_bearing(RunFolder({}, scene, Path()), scene.name, plan, marches)
    uncertainty = contact_uncertainty(plan, marches, scene.model, bearing.record)
    return velocities_below_bending(bearing, uncertainty)


def share_within(over: list[float], limit: float) -> str:
    """Say which share of differences over their ± is within a limit."""
    return f"{100 * sum(abs(value) <= limit for value in over) / len(over):.0f} %"


def main() -> None:
    """Print a row for each bearing, and the shares of differences within the ± and twice the ±."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workers", type=int, default=0, help="processes; 0: one per core")
    workers = parser.parse_args().workers
    every: list[Compared] = []
    for case in cases():
        rows = compare(case, workers)
        every += rows
        words = ", ".join(f"{row.difference_db:+.2f} (± {row.spread_db:.2f})" for row in rows)
        print(f"{case.words}: {words}", flush=True)
    for direction in DIRECTIONS:
        rows = [row for row in every if row.direction == direction]
        over = [row.difference_db / row.spread_db for row in rows]
        stated = [row.difference_db / row.stated_db for row in rows]
        rms_db = math.sqrt(sum(row.difference_db**2 for row in rows) / len(rows))
        rms_over = math.sqrt(sum(value**2 for value in over) / len(over))
        print(f"{direction}: {len(rows)} bands, differences {rms_db:.2f} dB rms")
        print(f"  over the ± of what differs: {rms_over:.2f} rms")
        print(f"  within it {share_within(over, 1)}, within twice it {share_within(over, 2)}")
        print(f"  within the whole ± {share_within(stated, 1)}, twice {share_within(stated, 2)}")


if __name__ == "__main__":  # processes import this module
    main()
