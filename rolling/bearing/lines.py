"""Lines of a bearing: frequencies of its kinematics, waves and faults, by their names."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from acoustics.ring_velocity import LineReading, NarrowSpectrum
from rolling.bearing.kinematics import Kinematics, lines_of
from rolling.bearing.model import BearingModel
from rolling.bearing.ring_record import AXIAL, DIRECTIONS, RADIAL
from rolling.bearing.wave_motion import BALLS, INNER, OUTER, WaveMotion

BODIES = (BALLS, INNER, OUTER)
_MAX_TURNS = 5  # multiples of the turn that are named
_MAX_COMPLIANCE = 6  # multiples of the varying compliance that are named
_MAX_BESIDE = 3  # turns beside a multiple that are named
_MAX_MULTIPLE = 400  # multiple of a family that is named; waves of higher orders move no ring
MAX_WAVE_LINES = 24  # of orders of waviness that are named
_FAINT = 0.1  # of the largest line of an order in a direction, below which one is not named

FAULT_LINES = {INNER: "BPFI", OUTER: "BPFO", BALLS: "2 x ball spin"}
"""Line of the envelope at which a fault of each body shows."""

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
    directions : tuple of str
        Directions in which it can move the ring. Default: radial and axial.
    """

    name: str
    meaning: str
    frequency_hz: float
    minor: bool = False
    directions: tuple[str, ...] = DIRECTIONS


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


def wave_lines(model: BearingModel, waves: Mapping[str, Iterable[int]]) -> list[BearingLine]:
    """Return the lines at which orders of waviness move the ring, each with its directions.

    Parameters
    ----------
    model : BearingModel
        Bearing, whose loads decide which orders move its ring (`wave_motion`).
    waves : mapping
        Orders of waviness by the body: inner, outer, balls.

    Returns
    -------
    lines : list of BearingLine
        None for an order that moves nothing.
    """
    motion = WaveMotion(model)
    lines = list[BearingLine]()
    for body, orders in waves.items():
        for order in sorted(orders):
            lines += _lines_of_order(motion, body, order)
    return lines[:MAX_WAVE_LINES]


def _lines_of_order(motion: WaveMotion, body: str, order: int) -> list[BearingLine]:
    """Return the lines of an order of a body, the largest first, without those that are faint."""
    wave_lines = motion.of_order(body, order)
    largest = {
        direction: max((line.velocity[direction] for line in wave_lines), default=0.0)
        for direction in DIRECTIONS
    }
    lines = list[BearingLine]()
    for line in wave_lines:
        shares = [line.velocity[direction] / largest[direction] for direction in line.directions]
        if max(shares) < _FAINT:
            continue
        if body == BALLS:
            name = f"ball {order}{_beside_in_words(line.part, 'cage')}"
            meaning = f"order {order} of a ball"
            minor = line.part != 0
        else:
            name = f"{body} {order}"
            beside = _signed(-line.part)
            q = (order + line.part) // motion.model.geometry.balls
            meaning = f"order {order} of the {body} raceway, {q} Z{beside}"
            minor = bool(lines)
            if minor:
                name += f" at {line.frequency_hz:.1f} Hz"
        lines.append(
            BearingLine(
                name=name,
                meaning=f"{meaning}, {' and '.join(line.directions)}",
                frequency_hz=line.frequency_hz,
                minor=minor,
                directions=line.directions,
            )
        )
    return lines


def _signed(number: int) -> str:
    """Write a number with its sign and spaces around; nothing for 0."""
    if not number:
        return ""
    return f" {'+' if number > 0 else '-'} {abs(number)}"


def family_lines(
    model: BearingModel,
    *,
    wavy: Collection[str],
    faulty: Collection[str],
    highest_hz: float,
    apart_hz: float = 0.0,
) -> list[BearingLine]:
    """Return all lines up to a frequency at which bodies can move the ring, the simplest first.

    Multiples of the turn, of BPFO and of BPFI with the turn of its ring beside them, and even
    multiples of the ball spin with the cage beside them: a peak of a spectrum is named by them.

    Parameters
    ----------
    model : BearingModel
        Bearing, whose loads decide which parts of a body move its ring, and in which direction.
    wavy : collection of str
        Bodies with waviness, form or roughness: inner, outer, balls.
    faulty : collection of str
        Bodies with single faults. A body without any cause has no lines.
    highest_hz : float, Hz
        Frequency up to which lines are returned.
    apart_hz : float, Hz
        A family whose multiples are nearer would name every peak, and is left out. Default: 0.
    """
    lines = kinematic_lines(model.kinematics)
    for times in range(2, _MAX_TURNS + 1):
        meaning = "multiple of the turn"
        lines.append(BearingLine(f"{times} turn", meaning, times * model.kinematics.turning_hz))
    motion = WaveMotion(model)
    causes = {body: _Cause(body in wavy, body in faulty) for body in BODIES}
    for body in (OUTER, INNER):
        lines += _raceway_family(motion, body, causes[body], highest_hz, apart_hz)
    lines += _ball_family(motion, causes[BALLS], highest_hz, apart_hz)
    lines.sort(key=lambda line: line.minor)  # stable: what has nothing beside it comes first
    named = dict[str, BearingLine]()
    for line in lines:
        if 0 < line.frequency_hz <= highest_hz:
            named.setdefault(line.name, line)
    return list(named.values())


class _Cause(NamedTuple):
    """What of a body can move the ring: waves of random or given heights, single faults."""

    waves: bool
    fault: bool

    def in_words(self, waves: str, fault: str) -> str:
        """Say what may move the ring."""
        if self.waves and self.fault:
            return f"{fault}, or {waves}"
        return fault if self.fault else waves


def _raceway_family(
    motion: WaveMotion, body: str, cause: _Cause, highest_hz: float, apart_hz: float
) -> list[BearingLine]:
    """Return multiples of BPFO or BPFI with some turns of their ring beside them."""
    speeds = motion.model.kinematics
    balls = motion.model.geometry.balls
    name = FAULT_LINES[body]
    pass_hz = speeds.ball_pass_outer_hz if body == OUTER else speeds.ball_pass_inner_hz
    ring_hz = speeds.outer_hz if body == OUTER else speeds.inner_hz
    # A wave of order q Z - p moves the ring by part p of the forces, p turns of its ring beside
    # q passes. Of a ring at rest all parts have the frequency of the passes.
    turns_forward = 1 if speeds.cage_hz > ring_hz else -1
    parts = [part for part in motion.parts if abs(part) <= _MAX_BESIDE]
    lines = []
    if pass_hz < apart_hz or not any(cause):
        return []
    for q in range(1, int(min(highest_hz / pass_hz, _MAX_MULTIPLE)) + 1 + _MAX_BESIDE):
        multiple = name if q == 1 else f"{q} {name}"
        fault = f"fault of the {body} raceway, harmonic {q}"
        for beside, own in _grouped(parts, turns_forward if ring_hz > 0 else 0):
            frequency_hz = q * pass_hz + beside * ring_hz
            if not 0 < frequency_hz <= highest_hz:
                continue
            orders = {part: motion.directions_of(part, frequency_hz) for part in own}
            directions = tuple(
                direction
                for direction in DIRECTIONS
                if any(direction in d for d in orders.values())
            )
            if not directions:
                continue
            of_orders = _orders_in_words({q * balls - part: d for part, d in orders.items()})
            lines.append(
                BearingLine(
                    name=multiple + _beside_in_words(beside, "turn"),
                    meaning=cause.in_words(f"waves of the {body} raceway, {of_orders}", fault),
                    frequency_hz=frequency_hz,
                    minor=beside != 0,
                    directions=directions,
                )
            )
    return lines


def _grouped(parts: Sequence[int], turns: int) -> list[tuple[int, list[int]]]:
    """Return turns beside a multiple, each with the parts of the forces that have it."""
    if not turns:
        return [(0, list(parts))]
    return [(turns * part, [part]) for part in parts]


def _orders_in_words(orders: Mapping[int, tuple[str, ...]]) -> str:
    """Say which orders move the ring in which direction: order 9 axially, orders 8, 10 radially."""
    texts = []
    for direction in (AXIAL, RADIAL):
        own = sorted(order for order, names in orders.items() if direction in names)
        if len(own) == 1:
            texts.append(f"order {own[0]} {direction}ly")
        elif own:
            words = " and ".join(map(str, own))
            if len(own) > 2:
                words = f"{own[0]} to {own[-1]}"
            texts.append(f"orders {words} {direction}ly")
    return ", ".join(texts)


def _ball_family(
    motion: WaveMotion, cause: _Cause, highest_hz: float, apart_hz: float
) -> list[BearingLine]:
    """Return even multiples of the ball spin with some turns of the cage beside them."""
    speeds = motion.model.kinematics
    if 2 * speeds.ball_spin_hz < apart_hz or not any(cause):
        return []
    lines = []
    most = int(min(highest_hz / speeds.ball_spin_hz, _MAX_MULTIPLE))
    for order in range(2, most + 2 + _MAX_BESIDE, 2):
        for line in motion.of_order(BALLS, order):
            if abs(line.part) > _MAX_BESIDE:
                continue
            lines.append(
                BearingLine(
                    name=f"{order} x ball spin" + _beside_in_words(line.part, "cage"),
                    meaning=cause.in_words(
                        f"waves of balls, order {order}", f"fault of a ball, harmonic {order // 2}"
                    ),
                    frequency_hz=line.frequency_hz,
                    minor=line.part != 0,
                    directions=line.directions,
                )
            )
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


def envelope_readings(
    envelope: NarrowSpectrum, kinematics: Kinematics
) -> list[tuple[BearingLine, LineReading]]:
    """Return the lines of faults with what the spectrum of an envelope shows of them."""
    fault_lines = envelope_lines(kinematics)
    frequencies = [line.frequency_hz for line in fault_lines]
    return [(line, envelope.read_line(line.frequency_hz, frequencies)) for line in fault_lines]
