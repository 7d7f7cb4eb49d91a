"""Cost of the error estimate of a run, and the stretches of track that its share pays for.

The cost is counted in steps of the run. It is a function of the scene alone, so that the stretches
do not depend on the speed of a machine.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from acoustics.bands import BAND_NAMES, BANDWIDTH_HZ
from rolling.scene.scene import Scene

SHARE = 0.25  # maximum cost of the estimate over the cost of the run
FIRST_STRETCHES = 4  # stretches of the first round; each round doubles them
STRETCH_STEPS = 64, 400  # minimum and maximum number of steps of a stretch
# Steps that a cold start costs beside its own: 6.5 on the run's grid and 7.7 at half the spacing,
# the mean of ten scenes at three to five places (3 at Ra 0.01 um and 20 N, 12 to 15 at Ra 1 um).
START_STEPS = 7
TIGHTER = 10.0  # the scene's tolerance over the tight tolerance
LEAST_TOLERANCE = 1e-10  # rounding does not let a solve come closer
LINES = 2  # lines of a stretch in the third octave of 1 kHz, if the cost allows
# The cost of a step, as it is counted here, grows with this power of the nodes along a side. It
# does not follow `cost.STEP_LAWS`, whose powers are 1.45 to 2.3: when they are measured anew, the
# stretches of a scene, and all numbers that follow from them, have to stay.
COST_POWER = 1.95
LEVELS = ("tight", "fine", "coarse")  # marches of a stretch, beside the run itself


@dataclass(frozen=True)
class Layout:
    """The stretches of a track in the order in which they are marched.

    steps : int. Number of steps of a stretch.
    firsts : tuple of int. First position of each stretch that the share of the cost pays for.
    """

    steps: int
    firsts: tuple[int, ...]


def tight_tolerance(scene: Scene) -> float:
    """Return the tolerance against which the tolerance of a scene is judged."""
    own = scene.tolerance
    return min(own, max(own / TIGHTER, LEAST_TOLERANCE))


def level_cost(scene: Scene, level: str, power: float = COST_POWER) -> float:
    """Return the expected cost of a step on a level, in steps of the run.

    Parameters
    ----------
    power : float
        The cost grows with this power of the nodes along a side. Default: COST_POWER.
    """
    if level == "coarse":  # at twice the spacing and the scene's own tolerance
        return math.pow(2.0, -power)
    # The number of iterations is proportional to the logarithm of the tolerance.
    tighter = math.log(tight_tolerance(scene)) / math.log(scene.tolerance)
    return tighter * (math.pow(2.0, power) if level == "fine" else 1.0)


def stretch_cost(scene: Scene, steps: int, power: float = COST_POWER) -> float:
    """Return the cost of all marches of a stretch, in steps of the run, as in `level_cost`."""
    return (steps + START_STEPS) * sum(level_cost(scene, level, power) for level in LEVELS)


def marched_steps(scene: Scene) -> int:
    """Return the number of steps that a run marches: those of its track, at each of its loads."""
    loads = 1 if scene.dynamics is None else scene.dynamics.loads
    return loads * scene.track.solved_steps


def stretch_steps(scene: Scene) -> int:
    """Return the number of steps of a stretch, or 0 where the track is too short for stretches.

    A stretch resolves 1 kHz where the share of the cost allows it. With dynamics it is as long as
    it may be, because runs at several speeds share it.
    """
    track = scene.track
    speed = track.distance / scene.duration
    wanted = LINES * speed / (track.step * BANDWIDTH_HZ[BAND_NAMES.index("1000")])
    if scene.dynamics is not None:
        wanted = math.inf
    per_step = stretch_cost(scene, 1) - stretch_cost(scene, 0)
    paid = SHARE * marched_steps(scene) / FIRST_STRETCHES / per_step - START_STEPS
    least, most = STRETCH_STEPS
    room = min(paid, track.solved_steps / FIRST_STRETCHES)
    return 0 if room < least else int(min(max(wanted, least), most, room))


def layout(scene: Scene, steps: int) -> Layout:
    """Spread stretches of `steps` steps evenly over the track, each round between the last ones.

    The order is the low-discrepancy sequence of van der Corput, so that every round covers the
    whole track. Stretches do not overlap.
    """
    slots = scene.track.solved_steps // steps
    most = min(slots, int(SHARE * marched_steps(scene) / stretch_cost(scene, steps) + 1e-9))
    return Layout(steps, spread(slots, steps, most))


def spread(slots: int, steps: int, count: int) -> tuple[int, ...]:
    """Return first positions of `count` slots of `steps` steps in the order of van der Corput."""
    chosen: dict[int, None] = {}
    number = 0
    while len(chosen) < count:
        chosen.setdefault(int(_van_der_corput(number) * slots))
        number += 1
    return tuple(slot * steps for slot in chosen)


def _van_der_corput(number: int) -> float:
    """Return the number with its binary digits mirrored at the point, between 0 and 1."""
    value, place = 0.0, 0.5
    while number:
        value += place * (number & 1)
        number, place = number >> 1, place / 2
    return value


def too_short(scene: Scene) -> str | None:
    """Explain that a track is too short for an estimate, or return None."""
    if stretch_steps(scene):
        return None
    least = FIRST_STRETCHES * stretch_cost(scene, STRETCH_STEPS[0]) / SHARE
    least *= scene.track.solved_steps / marched_steps(scene)
    return (
        f"the track has {scene.track.solved_steps} different steps, and the estimate needs"
        f" {math.ceil(least)} to stay below {SHARE:.0%} of the run's cost"
    )


def cost_share(scene: Scene, power: float = COST_POWER) -> float:
    """Return the maximum cost of the estimate over the cost of the run; 0 without an estimate.

    Parameters
    ----------
    power : float
        As in `level_cost`; the power of `cost.STEP_LAWS` makes it a share of time.
    """
    steps = stretch_steps(scene) if scene.numerics.error_estimate else 0
    if not steps or scene.surface.kind == "smooth":
        return 0.0
    count = len(layout(scene, steps).firsts)
    return count * stretch_cost(scene, steps, power) / marched_steps(scene)
