"""Size of a contact before it is solved: where it yields, and over a rough surface."""

import math

from rolling.contact.smooth_contact import SmoothContact

# A rough surface overlaps the sphere by this many rms roughnesses more than a smooth surface. The
# value is fitted to solved contacts at Ra 0.01 to 5 um and 1 to 100 N, where it lay between 0.2
# (elastic, light) and 2.4 (plastic, heavy).
RISE = 1.5


def contact_radius_m(contact: SmoothContact, hardness_pa: float) -> float:
    """Return the larger of the elastic and the fully plastic reach [m] of a smooth contact.

    It is the reach along the track. The hardness of an elastic plate is infinite.
    """
    plastic = math.sqrt(contact.load_n / (math.pi * hardness_pa))
    plastic *= math.sqrt(math.sqrt(contact.radius_m / contact.radius_across_m))
    return max(contact.semi_axes_m()[0], plastic)


def overlap_along_m(contact: SmoothContact, hardness_pa: float, rq_m: float) -> float:
    """Estimate the reach [m] along the track of the overlap with a surface of rms height rq_m.

    It is sqrt(2 R (a^2/R + 1.5 rq)) with the radius R of the sphere and the Hertz radius a.
    """
    approach = contact.approach_m()
    if math.isfinite(hardness_pa):
        # In rigid-plastic sinking the area of overlap times the hardness equals the load.
        radius = math.sqrt(contact.radius_m * contact.radius_across_m)
        approach = max(approach, contact.load_n / (2 * math.pi * radius * hardness_pa))
    return math.sqrt(2 * contact.radius_m * (approach + RISE * rq_m))


def overlap_across_m(contact: SmoothContact, hardness_pa: float, rq_m: float) -> float:
    """Estimate the reach [m] across the track of the overlap with a surface of rms height rq_m."""
    along = overlap_along_m(contact, hardness_pa, rq_m)
    return along * math.sqrt(contact.radius_across_m / contact.radius_m)


def window_nodes(
    contact: SmoothContact, hardness_pa: float, rq_m: float, spacing_m: float, step_nodes: float
) -> float:
    """Estimate the nodes along the side of a square of the area of the overlap, at both ends.

    The window is up to 15 % narrower (see `RollingContact.overlap`).
    """
    along = overlap_along_m(contact, hardness_pa, rq_m)
    across = overlap_across_m(contact, hardness_pa, rq_m)
    side = math.sqrt(along * across)
    return 2 * side / spacing_m + max(1.0, step_nodes)
