"""The answer of a bearing run in sentences, made from its numbers."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from acoustics.numbers import rounded, rounded_up, si
from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing.lines import FAULT_LINES
from rolling.bearing.ring_record import AXIAL, DIRECTIONS, NOTHING_UM_S
from rolling.bearing_kind.bearing_doubts import moves
from rolling.bearing_kind.solved_bearing import bands_below_hz, faulty_bodies
from rolling.numbers.bearing_numbers import (
    AXIAL_NAMES,
    MAKERS_REFERENCE,
    BandValues,
    BearingNumbers,
    EnvelopeLine,
    FaultlessNumbers,
    RingNumbers,
    VelocityLine,
    VibrationClass,
)
from rolling.numbers.quantity import Quantity, spread_text, uncertain
from rolling.scene.bearing_scene import BearingScene

BAND_WORDS = {
    name: f"{low:,.0f} to {high:,.0f} Hz" for name, (low, high) in VELOCITY_BANDS_HZ.items()
}
QUANTITY_NAMES = {name: f"Radial below the bending, {name} band" for name in VELOCITY_BANDS_HZ}
NO_VELOCITY = "-"  # of a band that lies above the bending, or where it is not known
HEARD_LINE = 5.0  # height from which on a line stands out of its surroundings
LEAST_SHARE = 0.1  # of the largest line, from which on another one is named
STRONG_LINE = 10.0  # height from which on a line of the envelope tells of a fault
RISE = 2.0  # of that height over the height without the fault, from which on the fault shows
_MOST_LINES = 3  # that a sentence names


def sentences(scene: BearingScene, numbers: BearingNumbers) -> list[str]:
    """Say what a run has: bands, axial bands, lines that lead, faults, and its departures."""
    texts = [answer(scene, numbers), axial_sentence(numbers)]
    texts += [rigid_sentence(numbers), housing_sentence(numbers)]
    texts += [pulse_sentence(scene, numbers), class_sentence(numbers)]
    texts += [leading_lines(numbers), unresolved_lines(numbers)]
    texts += fault_sentences(scene, numbers)
    texts += [load_sentence(numbers), film_sentence(numbers)]
    if numbers.departures:
        texts.append(f"Not ISO 15242: {'; '.join(numbers.departures)}.")
    return [text for text in texts if text]


# ---- words


def condition(scene: BearingScene) -> str:
    """Say how a bearing runs: its name, speed and loads."""
    bearing = scene.bearing
    name = scene.title or scene.name
    if bearing.named:
        name = f"bearing {bearing.named}"
    return f"{name} at {rounded(bearing.speed_rpm, 4)} rpm under {loads_words(scene)}"


def loads_words(scene: BearingScene) -> str:
    """Write the loads of a bearing with their directions."""
    bearing = scene.bearing
    loads = [
        f"{rounded(load, 3)} N {direction}"
        for load, direction in (
            (bearing.axial_load_n, "axial"),
            (bearing.radial_load_n, "radial"),
        )
        if load > 0
    ]
    return " and ".join(loads)


def band_words(ring: RingNumbers) -> dict[str, str]:
    """Return the bands in words, each up to the first mode that the ring lacks; none above it."""
    ending = "begins to bend"
    if ring.left_out_hz is not None:
        ending = "bends in modes that are left out"
    words = {}
    for band, (low, high) in bands_below_hz(ring.holds_hz).items():
        if high >= VELOCITY_BANDS_HZ[band][1]:
            words[band] = BAND_WORDS[band]
        elif high > low:
            words[band] = f"{low:,.0f} to {high:,.0f} Hz, where it {ending}"
    return words


def above(ring: RingNumbers) -> str:
    """Say what a band is whose end lies above the modes of the ring."""
    return "of a ring that stays rigid" if ring.left_out_hz is None else "with what is above"


def velocity(um_s: float | None) -> str:
    """Write a velocity [um/s]; what is below a thousandth is nothing."""
    if um_s is None:
        return NO_VELOCITY
    return "0" if um_s < NOTHING_UM_S else rounded(um_s, 2)


def spread_of_velocity(velocity: Quantity) -> str:
    """Write the ± of a velocity, or the verdict of an axial one that is not to be quoted.

    A ring at rest, and a velocity that is not known, have no ±.
    """
    for doubt in velocity.doubts:
        if doubt.about == AXIAL_NAMES:
            return doubt.severity.word
    spread_db = velocity.uncertainty
    if velocity.value is None or spread_db is None or velocity.value < NOTHING_UM_S:
        return ""
    return f"± {spread_text(spread_db)} dB"


def hertz(frequency_hz: float) -> str:
    """Write the frequency of a line with five digits."""
    return f"{frequency_hz:#.5g}"


def not_resolved_by(duration_s: float) -> str:
    """Say that a record does not separate a line from a stronger one."""
    return f"not resolved by {rounded(duration_s, 3)} s"


def unresolved(duration_s: float, resolving_s: float) -> str:
    """Say that a record does not separate a line from a stronger one, and which one would."""
    return f"{not_resolved_by(duration_s)}, {rounded_up(resolving_s)} s would"


def _listed(texts: Sequence[str]) -> str:
    """Join texts: a, b and c."""
    if len(texts) == 1:
        return texts[0]
    return f"{', '.join(texts[:-1])} and {texts[-1]}"


def _three(bands: BandValues) -> str:
    """Write three velocities with two digits."""
    return f"{velocity(bands.low)}, {velocity(bands.medium)} and {velocity(bands.high)}"


# ---- velocities


def answer(scene: BearingScene, numbers: BearingNumbers) -> str:
    """Say how fast the ring vibrates radially in the three bands, as far as it is rigid."""
    opening = condition(scene)
    opening = f"{opening[0].upper()}{opening[1:]}"
    moving = numbers.ring.moving
    bands = _radial_bands(numbers)
    if not bands:
        return f"{opening}: the {moving} ring bends below all three bands."
    return f"{opening}: the {moving} ring vibrates radially at {_listed(bands)}, rms."


def first_answer(numbers: BearingNumbers) -> str:
    """Say the radial velocity of each band with its ±, and the classes that bands have."""
    bands = _radial_bands(numbers)
    if not bands:
        return f"the {numbers.ring.moving} ring bends below all three bands"
    text = f"radially {_listed(bands)}"
    own = numbers.vibration_class
    if own is not None and own.by_band:
        text += f", by the limits of makers {_listed(_classes(own))}"
    return text


def _radial_bands(numbers: BearingNumbers) -> list[str]:
    """Write the radial velocity of each band with its ±, as far as the ring has its modes."""
    radial = numbers.below_bending.radial.by_band
    return [
        f"{_with_spread(radial[band])} ({words})"
        for band, words in band_words(numbers.ring).items()
    ]


def _with_spread(own: Quantity, is_spread: bool = True) -> str:
    """Write a velocity with its unit, and with its ± if that is asked for."""
    text = f"{velocity(own.value)} um/s"
    spread = spread_of_velocity(own) if is_spread else ""
    return f"{text} {spread}" if spread else text


def axial_sentence(numbers: BearingNumbers) -> str:
    """Say how fast the ring vibrates along its axis, and whether that is to be quoted."""
    axial = numbers.below_bending.axial.by_band
    bands = band_words(numbers.ring)
    if not bands:
        return "Axially, all three bands are above the bending as well."
    may_be_quoted = numbers.axial_doubt is None
    velocities = [_with_spread(axial[band], is_spread=may_be_quoted) for band in bands]
    text = f"Axially it vibrates at {_listed(velocities)} in the same bands"
    if may_be_quoted:
        return f"{text}."
    return (
        f"{text}: do not quote these, because the loads would turn the contact angle, which is kept"
        " here."
    )


def rigid_sentence(numbers: BearingNumbers) -> str:
    """Say what the bands have with what the ring does above its modes; empty for nothing."""
    holds_hz = numbers.ring.holds_hz
    radial = numbers.velocities.radial.um_s
    axial = numbers.velocities.axial.um_s
    cut = [band for band, (_, high) in VELOCITY_BANDS_HZ.items() if holds_hz < high]
    if not any(moves(radial[band]) for band in cut):
        return ""
    texts = []
    for band in cut:
        velocities = f"{velocity(radial[band])} um/s radially"
        if numbers.axial_doubt is None:
            velocities += f" and {velocity(axial[band])} um/s axially"
        texts.append(f"{velocities} ({BAND_WORDS[band]})")
    whole = "; ".join(texts)
    if numbers.ring.left_out_hz is not None:
        return f"From {si(holds_hz, 'Hz')} on it lacks modes. With what is above it has {whole}."
    return f"A real ring bends from {si(holds_hz, 'Hz')} on. One that stays rigid has {whole}."


def housing_sentence(numbers: BearingNumbers) -> str:
    """Say how loud the plate of the housing is; empty without one."""
    housing = numbers.housing
    if housing is None:
        return ""
    if housing.laeq.value is None:
        return "The plate of its housing is silent."
    level = uncertain(housing.laeq.value, housing.laeq.uncertainty)
    return f"The plate of its housing is heard at {level} dB(A) at {housing.distance_m:g} m."


# ---- as makers and diagnosticians read it


def pulse_sentence(scene: BearingScene, numbers: BearingNumbers) -> str:
    """State the level of acceleration with its reference, crest factor and kurtosis."""
    pulses = numbers.pulses
    if pulses is None or pulses.kurtosis is None or pulses.crest_factor is None:
        return ""
    spread = spread_text(pulses.kurtosis_uncertainty or 0.0)
    return (
        f"Its acceleration {scene.seen_at('along x')} has {pulses.acceleration_db:.1f} dB re"
        f" {MAKERS_REFERENCE} from {pulses.lowest_hz:,.0f} to {pulses.highest_hz:,.0f} Hz, with a"
        f" crest factor of {rounded(pulses.crest_factor)} and a kurtosis of"
        f" {rounded(pulses.kurtosis)} (noise has 3 ± {spread})."
    )


def class_sentence(numbers: BearingNumbers) -> str:
    """State the class by the limits of makers, or why there is none."""
    own = numbers.vibration_class
    if own is None:
        return ""
    if own.overall is not None:
        bands = ", ".join(_classes(own))
        return f"By the limits of {own.source}, it is of class {own.overall}: {bands}."
    text = f"It has no class V0 to V4: {own.none_because}."
    if own.by_band:
        text += f" By the limits of {own.source}, it has {' and '.join(_classes(own))}."
    return text


def _classes(own: VibrationClass) -> list[str]:
    """Say the class of each band."""
    return [f"{name} in the {band} band" for band, name in own.by_band.items()]


# ---- lines


def leading_lines(numbers: BearingNumbers) -> str:
    """Say which lines are the largest of those that stand out, radially and along the axis."""
    texts = []
    for direction in DIRECTIONS:
        named = _named_lines(numbers.lines, direction)
        if named:
            verdict = ""
            if direction == AXIAL and numbers.axial_doubt is not None:
                verdict = f" ({numbers.axial_doubt.severity.word} these)"
            texts.append(f"{direction} {', '.join(named)}{verdict}")
    if not texts:
        return "No line stands out."
    return f"The largest lines are {'; '.join(texts)}."


def _named_lines(lines: Sequence[VelocityLine], direction: str) -> list[str]:
    """Name the largest lines of a direction with their frequencies and velocities."""
    by_frequency = {}  # the last of equal ones, which names its cause
    for line in lines:
        own = line.by_direction[direction]
        if own.um_s is not None and (own.height or 0.0) >= HEARD_LINE:
            by_frequency[round(line.frequency_hz, 2)] = line, own.um_s
    largest_first = sorted(by_frequency.values(), key=lambda item: -item[1])
    least = LEAST_SHARE * largest_first[0][1] if largest_first else 0.0
    return [
        f"{line.name} ({rounded(line.frequency_hz, 4)} Hz, {velocity(um_s)} um/s)"
        for line, um_s in largest_first[:_MOST_LINES]
        if um_s >= max(least, NOTHING_UM_S)
    ]


def unresolved_lines(numbers: BearingNumbers) -> str:
    """Say which lines the record does not separate from stronger ones; empty for none."""
    needed_s: dict[str, float] = {}
    for line in numbers.lines:
        for own in line.by_direction.values():
            if own.resolved_by_s is not None:
                needed_s[line.name] = max(own.resolved_by_s, needed_s.get(line.name, 0.0))
    if not needed_s:
        return ""
    shown = [
        f"{name} ({rounded_up(seconds)} s would)"
        for name, seconds in list(needed_s.items())[:_MOST_LINES]
    ]
    more = len(needed_s) - len(shown)
    if more:
        shown.append(f"{more} more")
    return (
        f"{not_resolved_by(numbers.motion.duration_s).capitalize()} from stronger lines, so without"
        f" a velocity: {', '.join(shown)}."
    )


# ---- faults


def fault_sentences(scene: BearingScene, numbers: BearingNumbers) -> Iterator[str]:
    """Say for each body with faults whether its line rises in the envelope, and what they add.

    Balls meet the same roughness turn after turn, so a healthy bearing has these lines too.
    """
    bodies = faulty_bodies(scene)
    lines = {line.name: line for line in numbers.envelope_lines}
    for body in bodies:
        yield _fault_sentence(numbers, body, lines[FAULT_LINES[body]])
    if numbers.without_faults is not None:
        yield _added_by_faults(numbers, numbers.without_faults, len(bodies))


def envelope_words(numbers: BearingNumbers) -> str:
    """Write the band of the envelope behind its word; nothing for a run of an earlier version."""
    band = numbers.envelope_band
    return "" if band is None else f" of {band.low_hz:,.0f} to {band.high_hz:,.0f} Hz"


def _fault_sentence(numbers: BearingNumbers, body: str, line: EnvelopeLine) -> str:
    """Say whether the line of a body with faults rises in the envelope."""
    duration_s = numbers.motion.duration_s
    ring = "a ball" if body == "balls" else f"the {body} raceway"
    at = f"{line.name}, {rounded(line.frequency_hz, 4)} Hz"
    band = envelope_words(numbers)
    if line.height is None:
        text = not_resolved_by(duration_s)
        if line.resolved_by_s is not None:
            text = unresolved(duration_s, line.resolved_by_s)
        return f"The fault of {ring} may have a line in the envelope{band} at {at}: {text}."
    size = f"{rounded(line.height)} times its surroundings"
    rises = line.height >= STRONG_LINE
    if numbers.without_faults is not None:
        before = numbers.without_faults.heights.get(line.name, 0.0)
        if before is None:
            size += f"; {not_resolved_by(duration_s)} without the fault"
        else:
            size += f"; without the fault {rounded(before)} times"
            rises = rises and line.height >= RISE * before
    verb = "shows" if rises else "does not show"
    return f"The fault of {ring} {verb} in the envelope{band} at {at}: {size}."


def _added_by_faults(numbers: BearingNumbers, healthy: FaultlessNumbers, faulty: int) -> str:
    """Say by how many decibels faults raise the radial velocity in the three bands."""
    before = healthy.radial.by_band
    if min(before.values()) < NOTHING_UM_S:
        return f"Without faults the ring vibrates at {_three(healthy.radial)} um/s."
    added = []
    for band, um_s in numbers.velocities.radial.um_s.items():
        decibels = 20 * math.log10(max(um_s or 0.0, NOTHING_UM_S) / before[band])
        added.append(f"{round(decibels, 1) + 0.0:+.1f}")  # no "-0.0"
    low, medium, high = added
    noun = "The fault changes" if faulty == 1 else "The faults change"
    return f"{noun} the three bands by {low}, {medium} and {high} dB."


# ---- loads


def load_sentence(numbers: BearingNumbers) -> str:
    """Say between which loads the balls work."""
    least = rounded(numbers.loads.least_n, 3)
    largest = rounded(numbers.loads.largest_n, 3)
    if least == largest:
        return f"The load of a ball is {least} N."
    return f"The load of a ball is {least} to {largest} N."


def film_sentence(numbers: BearingNumbers) -> str:
    """Say how thick the films of oil are, and whether they part the surfaces; empty without oil."""
    if not numbers.films:
        return ""
    texts = []
    for film in numbers.films:
        ratio = "on a smooth surface"
        if film.ratio is not None:
            ratio = f"{rounded(film.ratio, 2)} times the rms roughness"
        texts.append(f"{si(film.thickness_m, 'm')} on the {film.raceway} raceway, {ratio}")
    weights = [film.weight for film in numbers.films]
    verdict = "The surfaces touch in part, and count so."
    if min(weights) >= 1:
        verdict = "It parts the surfaces."
    elif max(weights) <= 0:
        verdict = "The surfaces touch, as in a dry contact."
    return f"The film of oil is {_listed(texts)}. {verdict}"
