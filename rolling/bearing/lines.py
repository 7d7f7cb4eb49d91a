"""Lines of a bearing: frequencies of its kinematics, waves and faults, by their names."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from rolling.bearing.kinematics import Kinematics, lines_of

INNER = "inner"
OUTER = "outer"
BALLS = "balls"
BODIES = (BALLS, INNER, OUTER)
_MAX_TURNS = 5  # multiples of the turn that are named
_MAX_COMPLIANCE = 6  # multiples of the varying compliance that are named
_MAX_BESIDE = 3  # turns beside a multiple that are named
_MAX_MULTIPLE = 400  # multiple of a family that is named; waves of higher orders move no ring
MAX_WAVE_LINES = 24  # of orders of waviness that are named

_MEANINGS = {
    "cage": "turns of the cage",
    "turn": "turns of the ring that turns",
    "BPFO": "balls pass a place of the outer raceway",
    "BPFI": "balls pass a place of the inner raceway",
    "ball spin": "turns of a ball",
    "2 x ball spin": "a place of a ball meets a raceway",
}


@dataclass(frozen=True)
class BearingLine:
    """A frequency at which a bearing can vibrate.

    Parameters
    ----------
    name : str
        Short name, as figures mark it.
    meaning : str
        What happens at this frequency, in words.
    frequency_hz : float, Hz
    minor : bool
        Whether figures mark it without its name where there is little room.
    """

    name: str
    meaning: str
    frequency_hz: float
    minor: bool = False


def kinematic_lines(kinematics: Kinematics) -> list[BearingLine]:
    """Return the lines of a bearing that its speeds alone decide, lowest first."""
    lines = [BearingLine(name, _MEANINGS[name], hz) for name, hz in lines_of(kinematics).items()]
    return sorted(lines, key=lambda line: line.frequency_hz)


def varying_compliance(kinematics: Kinematics, balls: int) -> list[BearingLine]:
    """Return the lines of the stiffness that changes as balls pass under a radial load."""
    lines = []
    for times in range(1, _MAX_COMPLIANCE + 1):
        name = "varying compliance" if times == 1 else f"{times} varying compliance"
        line = BearingLine(
            name=name,
            meaning="the stiffness changes as balls pass under the radial load",
            frequency_hz=times * balls * kinematics.cage_hz,
            minor=times > 1,
        )
        lines.append(line)
    return lines


def wave_lines(
    kinematics: Kinematics, balls: int, waves: Mapping[str, Iterable[int]]
) -> list[BearingLine]:
    """Return the lines at which orders of waviness move the ring, radially and axially.

    Parameters
    ----------
    kinematics : Kinematics
    balls : int
        Number of balls Z.
    waves : mapping
        Orders of waviness by the body: inner, outer, balls.

    Returns
    -------
    lines : list of BearingLine
        None for an order that moves nothing. Order n of a raceway meets ball j with the phase
        n (theta_j - turn), and the sum over the balls of cos(m theta_j) times it (m = 0 axial,
        1 and -1 radial) is not zero for n = q Z + m, at |n (f_cage - f_ring) - m f_cage|. An even
        order n of a ball has n f_spin, and beside it the cage.
    """
    lines = list[BearingLine]()
    rings = {INNER: kinematics.inner_hz, OUTER: kinematics.outer_hz}
    for body, orders in waves.items():
        for order in sorted(orders):
            if body == BALLS:
                lines += _lines_of_ball(kinematics, order)
            else:
                lines += _lines_of_raceway(kinematics, balls, body, rings[body], order)
    return lines[:MAX_WAVE_LINES]


def _lines_of_raceway(
    kinematics: Kinematics, balls: int, body: str, ring_hz: float, order: int
) -> list[BearingLine]:
    """Return the line of an order of a raceway, if it moves the ring."""
    lines = []
    # Of two balls, an order is beside q Z on both sides.
    for beside in (-1, 0, 1):
        q = (order - beside) // balls
        hz = abs(order * (kinematics.cage_hz - ring_hz) - beside * kinematics.cage_hz)
        if (order - beside) % balls or (q == 0 and beside < 1) or not hz > 0:
            continue
        direction = "axial" if beside == 0 else "radial"
        sign = {-1: " - 1", 0: "", 1: " + 1"}[beside]
        meaning = f"order {order} of the {body} raceway, {q} Z{sign}, {direction}"
        lines.append(BearingLine(f"{body} {order}", meaning, hz))
    return lines


def _lines_of_ball(kinematics: Kinematics, order: int) -> list[BearingLine]:
    """Return the lines of an order of a ball: odd orders meet both raceways with opposite signs."""
    if order % 2:
        return []
    hz = order * kinematics.ball_spin_hz
    middle = BearingLine(f"ball {order}", f"order {order} of a ball, axial", hz)
    sides = [
        BearingLine(
            name=f"ball {order} {sign} cage",
            meaning=f"order {order} of a ball, radial",
            frequency_hz=hz + step,
            minor=True,
        )
        for sign, step in (("-", -kinematics.cage_hz), ("+", kinematics.cage_hz))
    ]
    return [sides[0], middle, sides[1]]


def family_lines(
    kinematics: Kinematics, balls: int, highest_hz: float, apart_hz: float = 0.0
) -> list[BearingLine]:
    """Return all lines up to a frequency at which waves can move the ring, the simplest first.

    Multiples of the turn, of BPFO and of BPFI with the turn of its ring beside them, and even
    multiples of the ball spin with the cage beside them: a peak of a spectrum is named by them.
    Under a radial load, waves that turn with a ring or the cage have more side bands. A family
    whose multiples are less than `apart_hz` apart would name every peak, and is left out.
    """
    lines = kinematic_lines(kinematics)
    for times in range(2, _MAX_TURNS + 1):
        meaning = "multiple of the turn"
        lines.append(BearingLine(f"{times} turn", meaning, times * kinematics.turning_hz))
    for beside in sorted(range(-_MAX_BESIDE, _MAX_BESIDE + 1), key=abs):
        lines += _raceway_family(kinematics, balls, highest_hz, apart_hz, beside)
        lines += _ball_family(kinematics, highest_hz, apart_hz, beside)
    named = dict[str, BearingLine]()
    for line in lines:
        if 0 < line.frequency_hz <= highest_hz:
            named.setdefault(line.name, line)
    return list(named.values())


def _raceway_family(
    kinematics: Kinematics, balls: int, highest_hz: float, apart_hz: float, beside: int
) -> list[BearingLine]:
    """Return multiples of BPFO and BPFI with some turns of their ring beside them."""
    lines = []
    rings = {
        "BPFO": (kinematics.ball_pass_outer_hz, kinematics.outer_hz, OUTER),
        "BPFI": (kinematics.ball_pass_inner_hz, kinematics.inner_hz, INNER),
    }
    for name, (pass_hz, ring_hz, body) in rings.items():
        if pass_hz < apart_hz or (beside and not ring_hz > 0):
            continue
        for q in range(1, int(min(highest_hz / pass_hz, _MAX_MULTIPLE)) + 1 + _MAX_BESIDE):
            multiple = name if q == 1 else f"{q} {name}"
            orders = f"order {q * balls + beside}"
            if not ring_hz > 0:
                orders = f"orders {q * balls - 1} to {q * balls + 1}"
            line = BearingLine(
                name=multiple + _beside_in_words(beside, "turn"),
                meaning=f"waves of the {body} raceway, {orders}",
                frequency_hz=q * pass_hz + beside * ring_hz,
            )
            lines.append(line)
    return lines


def _ball_family(
    kinematics: Kinematics, highest_hz: float, apart_hz: float, beside: int
) -> list[BearingLine]:
    """Return even multiples of the ball spin with some turns of the cage beside them."""
    if 2 * kinematics.ball_spin_hz < apart_hz:
        return []
    lines = []
    most = int(min(highest_hz / kinematics.ball_spin_hz, _MAX_MULTIPLE))
    for order in range(2, most + 2 + _MAX_BESIDE, 2):
        line = BearingLine(
            name=f"{order} x ball spin" + _beside_in_words(beside, "cage"),
            meaning=f"waves of balls, order {order}",
            frequency_hz=order * kinematics.ball_spin_hz + beside * kinematics.cage_hz,
        )
        lines.append(line)
    return lines


def _beside_in_words(beside: int, turn: str) -> str:
    """Write what is beside a multiple: nothing, - cage, + 2 turn."""
    if not beside:
        return ""
    sign = "+" if beside > 0 else "-"
    return f" {sign} {turn}" if abs(beside) == 1 else f" {sign} {abs(beside)} {turn}"


def envelope_lines(kinematics: Kinematics) -> list[BearingLine]:
    """Return the lines of faults in the envelope of one direction: rates of pulses, side bands.

    A fault that turns with a frequency f points along the direction twice a turn, so its line has
    side bands at 2 f; a load zone through which it goes once a turn makes those at f.
    """
    lines = [
        BearingLine("cage", _MEANINGS["cage"], kinematics.cage_hz),
        BearingLine("turn", _MEANINGS["turn"], kinematics.turning_hz),
    ]
    centres = {
        "BPFO": (kinematics.ball_pass_outer_hz, kinematics.outer_hz, "turn"),
        "BPFI": (kinematics.ball_pass_inner_hz, kinematics.inner_hz, "turn"),
        "2 x ball spin": (2 * kinematics.ball_spin_hz, kinematics.cage_hz, "cage"),
    }
    for name, (hz, side_hz, side) in centres.items():
        lines.append(BearingLine(name, _MEANINGS[name], hz))
        lines.append(BearingLine(f"2 ({name})", "its first multiple", 2 * hz, minor=True))
        for times in (1, 2) if side_hz > 0 else ():
            beside = side if times == 1 else f"{times} {side}"
            for sign, step in (("-", -times * side_hz), ("+", times * side_hz)):
                side_name = f"{name} {sign} {beside}"
                lines.append(BearingLine(side_name, f"side band of {name}", hz + step, minor=True))
    return sorted(lines, key=lambda line: line.frequency_hz)


FAULT_LINES = {INNER: "BPFI", OUTER: "BPFO", BALLS: "2 x ball spin"}
"""Line of the envelope at which a fault of each body shows."""
