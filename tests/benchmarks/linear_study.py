"""Measure what the linear response of rough contacts leaves in the bands, and within which ± it is.

The inner contact of a 6204 at three loads, and of a 608 and a 6305, is marched over random raceways
of several Ra and correlation lengths. Run as `python tests/benchmarks/linear_study.py`; it takes
some minutes.
"""

from __future__ import annotations

import itertools
import math

import rolling as rc
from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing.ring_record import DIRECTIONS
from rolling.bearing_kind.contact_marches import march_contacts
from rolling.bearing_kind.contact_plan import contact_plan
from rolling.bearing_kind.contact_uncertainty import linear_contact_db, roughness_powers

CASES = [("6204", 20), ("6204", 70), ("6204", 400), ("608", 70), ("6305", 70)]  # N, axial
LENGTHS_UM = [(60, 10), (20, 20)]
RA_UM = [0.02, 0.05, 0.1, 0.2]


def changes_db(scene: rc.BearingScene) -> tuple[list[float], float]:
    """Return levels of the march less those of the linear response by band, and their ± [dB]."""
    plan = contact_plan(scene)
    contact = plan.rough["inner"]
    marches = march_contacts([contact.scene], name="linear", workers=1, shown=False)
    linear = roughness_powers(plan, {}, scene.model)["inner"]
    marched = roughness_powers(plan, marches, scene.model)["inner"]
    changes = []
    for direction, band in itertools.product(DIRECTIONS, VELOCITY_BANDS_HZ):
        ratio = marched.of_band(direction, band).sum() / linear.of_band(direction, band).sum()
        changes.append(10 * math.log10(ratio))
    return changes, linear_contact_db(contact)


def main() -> None:
    """Print a row for each case, and the share of all differences within the ± and twice the ±."""
    over = []
    for (named, load_n), (along, across), ra_um in itertools.product(CASES, LENGTHS_UM, RA_UM):
        raceway = {
            "kind": "gaussian",
            "roughness_ra_um": ra_um,
            "correlation_length_um": along,
            "correlation_length_across_um": across,
            "seed": 2,
        }
        scene = rc.BearingScene(
            bearing={
                "named": named,
                "speed_rpm": 1800,
                "axial_load_n": load_n,
                "surfaces": {"inner": raceway},
            }
        )
        changes, spread_db = changes_db(scene)
        over += [change / spread_db for change in changes]
        words = " ".join(f"{change:+.2f}" for change in changes)
        case = f"{named} {load_n} N, Ra {ra_um} um, {along} by {across} um"
        print(f"{case}: {words} (± {spread_db:.2f})")
    rms = math.sqrt(sum(value**2 for value in over) / len(over))
    print(f"rms over the ±: {rms:.2f}")
    for limit in (1, 2):
        share = sum(abs(value) <= limit for value in over) / len(over)
        print(f"within {limit} of it: {100 * share:.0f} %")


if __name__ == "__main__":  # processes import this module
    main()
