"""Numbers of a bearing run as plain data: bands, lines, loads, doubts, and sentences last."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from acoustics.numbers import decibels_a, rounded, rounded_up, si
from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing import assumed_damping
from rolling.bearing.band_uncertainty import LOSS_FACTOR
from rolling.bearing.linear_ring import linear_ring
from rolling.bearing.lines import FAULT_LINES
from rolling.bearing.ring_record import AXIAL, DIRECTIONS, NOTHING_UM_S, RADIAL, UM_S
from rolling.bearing_contacts.bearing_check import scene_rules
from rolling.marches import effort
from rolling.numbers.doubt import Doubt, Severity, severity_of, sized

if TYPE_CHECKING:
    from rolling.bearing_run.bearing_run import BearingRun
    from rolling.bearing_run.without_faults import WithoutFaults

FORMAT = 1  # of summary.json
BAND_WORDS = {
    name: f"{low:,.0f} to {high:,.0f} Hz" for name, (low, high) in VELOCITY_BANDS_HZ.items()
}
NO_VELOCITY = "-"  # of a band that lies above the bending, or where it is not known
HEARD_LINE = 5.0  # height from which on a line stands out of its surroundings
LEAST_SHARE = 0.1  # of the largest line, from which on another one is named
STRONG_LINE = 10.0  # height from which on a line of the envelope tells of a fault
RISE = 2.0  # of that height over the height without the fault, from which on the fault shows
_MOST_LINES = 3  # that a sentence names
_UNCERTAIN_DB = 0.05  # from which on a band is stated as uncertain
_LEAST_DB = 0.1  # effects below it have no sentence
_ENERGY_DB = 10 / math.log(10)


# ---- numbers


def summarize(run: BearingRun) -> dict[str, Any]:
    """Return the numbers of a run: plain data in the units of their names, sentences last."""
    doubts = list(doubts_of(run))
    bending_hz = run.scene.ring_bending_hz
    return {
        "format": FORMAT,
        "kind": "bearing",
        "name": run.scene.name,
        "title": run.scene.title,
        "label": run.label,
        "bands_um_s": run.bands_um_s,
        "bands_uncertainty_db": run.uncertainty.totals_db,
        "bands_uncertainty_parts_db": run.uncertainty.to_dict(),
        "bands_verdict": band_verdicts(run),
        "bands_below_bending_um_s": run.bands_below_bending_um_s,
        "bands_below_bending_uncertainty_db": run.below_bending_uncertainty_db,
        "iso_departures": run.departures,
        "housing": _housing(run),
        "moving_ring": run.moving,
        "duration_s": run.record.duration_s,
        "lines": run.lines_with_levels,
        "envelope_lines": run.envelope_lines,
        "without_faults": None if run.without_faults is None else run.without_faults.to_dict(),
        "kinematics": {
            "cage_hz": run.kinematics.cage_hz,
            "ball_pass_outer_hz": run.kinematics.ball_pass_outer_hz,
            "ball_pass_inner_hz": run.kinematics.ball_pass_inner_hz,
            "ball_spin_hz": run.kinematics.ball_spin_hz,
            "rolling_speed_m_s": run.kinematics.rolling_speed_m_s,
        },
        "loads": _loads(run),
        "contact_angle_deg": math.degrees(run.geometry.contact_angle),
        "contact_angles_under_loads_deg": [math.degrees(one) for one in run.angles_under_loads],
        "ring_mass_kg": run.model.ring_mass_kg,
        "resonances_hz": linear_ring(run.model).resonances_hz.tolist(),
        "ring_bending_hz": bending_hz,
        "ring_bending_note": f"above {bending_hz:.0f} Hz the rigid ring does not hold",
        "contacts": list(run.contacts),
        "march_cpu_s": run.parts_cpu_s.get(effort.MARCH),
        effort.PARTS: dict(run.parts_cpu_s),
        "contact_doubts": [doubt_as_json(doubt) for doubt in run.solved],
        "energy_error": run.record.energy_error,
        "lost_contact_share": run.record.lost_contact_share,
        "doubts": [doubt_as_json(doubt) for doubt in doubts],
        "sentences": sentences(run),
    }


def band_verdicts(run: BearingRun) -> dict[str, dict[str, str]]:
    """Return how far each band is to be trusted, by direction and band, in words.

    The ± decides, and for the axial bands also an angle that the loads would turn.
    """
    verdicts = {
        direction: {band: severity_of(decibels).word for band, decibels in bands.items()}
        for direction, bands in run.uncertainty.totals_db.items()
    }
    if run.axial_doubt is not None:
        verdicts[AXIAL] = dict.fromkeys(VELOCITY_BANDS_HZ, run.axial_doubt.severity.word)
    return verdicts


def _housing(run: BearingRun) -> dict[str, Any] | None:
    """Return the sound of the housing plate, None for a scene without one."""
    sound = run.housing
    if sound is None:
        return None
    return {
        "laeq_db": sound.levels.laeq_db,
        "third_octave_db": dict(sound.levels.third_octave_db),
        "distance_m": run.scene.sound.distance_m,
        "force_n": float(sound.force_n.std()),
        "velocity_um_s": UM_S * float(sound.velocity_m_s.std()),
    }


def _loads(run: BearingRun) -> dict[str, Any]:
    """Return the loads of the balls [N]: their largest and least, and the mean at each angle."""
    loads = run.record.ball_load_n
    around = run.mean_loads_n
    return {
        "largest_n": float(loads.max()),
        "least_n": float(loads.min()),
        "mean_n": float(loads.mean()),
        "mean_at_angles_n": [None if math.isnan(load) else load for load in around.tolist()],
    }


def stored_doubts(stored: Mapping[str, Any]) -> Iterator[Doubt]:
    """Yield the doubts about the rough contacts that stored numbers have."""
    severities = {severity.word: severity for severity in Severity}
    for doubt in stored["contact_doubts"]:
        yield Doubt(
            key=doubt["key"],
            text=doubt["text"],
            severity=severities[doubt["severity"]],
            decibels=doubt["decibels"],
            advice=doubt["advice"],
        )


def doubt_as_json(doubt: Doubt) -> dict[str, Any]:
    """Return a doubt as summary.json has it."""
    return {
        "key": doubt.key,
        "text": doubt.text,
        "severity": doubt.severity.word,
        "decibels": doubt.decibels,
        "advice": doubt.advice,
    }


# ---- sentences


def condition(run: BearingRun) -> str:
    """Say how a bearing runs: its name, speed and loads."""
    bearing = run.scene.bearing
    name = run.scene.title or run.scene.name
    if bearing.named:
        name = f"bearing {bearing.named}"
    loads = [
        f"{rounded(load, 3)} N {direction}"
        for load, direction in (
            (bearing.axial_load_n, "axial"),
            (bearing.radial_load_n, "radial"),
        )
        if load > 0
    ]
    return f"{name} at {rounded(bearing.speed_rpm, 4)} rpm under {' and '.join(loads)}"


def answer(run: BearingRun) -> str:
    """Say how fast the ring vibrates radially in the three bands, as far as it is rigid."""
    said = condition(run)
    velocities = run.bands_below_bending_um_s[RADIAL]
    bands = [
        f"{velocity(velocities[band])} um/s ({words})" for band, words in band_words(run).items()
    ]
    if not bands:
        return f"{said[0].upper()}{said[1:]}: the {run.moving} ring bends below all three bands."
    return (
        f"{said[0].upper()}{said[1:]}: the {run.moving} ring vibrates radially at"
        f" {_listed(bands)}, rms."
    )


def _listed(texts: Sequence[str]) -> str:
    """Join texts: a, b and c."""
    if len(texts) == 1:
        return texts[0]
    return f"{', '.join(texts[:-1])} and {texts[-1]}"


def band_words(run: BearingRun) -> dict[str, str]:
    """Return the bands in words, each up to the first bending mode of the ring; none above it."""
    words = {}
    for band, (low, high) in run.bands_below_bending_hz.items():
        if high >= VELOCITY_BANDS_HZ[band][1]:
            words[band] = BAND_WORDS[band]
        elif high > low:
            words[band] = f"{low:,.0f} to {high:,.0f} Hz, where it begins to bend"
    return words


def sentences(run: BearingRun) -> list[str]:
    """Say what a run has: bands, axial bands, lines that lead, faults, and its departures."""
    texts = [answer(run), axial_sentence(run)]
    texts += [rigid_sentence(run), housing_sentence(run)]
    texts += [leading_lines(run), unresolved_lines(run), *fault_sentences(run)]
    texts.append(load_sentence(run))
    if run.departures:
        texts.append(f"Not ISO 15242: {'; '.join(run.departures)}.")
    return [text for text in texts if text]


def axial_sentence(run: BearingRun) -> str:
    """Say how fast the ring vibrates along its axis, and whether that is to be quoted."""
    velocities = [velocity(run.bands_below_bending_um_s[AXIAL][band]) for band in band_words(run)]
    if not velocities:
        return "Axially, all three bands are above the bending as well."
    text = f"Axially it vibrates at {_listed(velocities)} um/s in the same bands"
    if run.axial_doubt is None:
        return f"{text}."
    return (
        f"{text}: do not quote these, because the loads would turn the contact angle, which is kept"
        " here."
    )


def rigid_sentence(run: BearingRun) -> str:
    """Say what the bands have with what a rigid ring does above its bending; empty for nothing."""
    bending_hz = run.scene.ring_bending_hz
    cut = [band for band, (_, high) in VELOCITY_BANDS_HZ.items() if bending_hz < high]
    if not cut or max(run.bands_um_s[RADIAL][band] for band in cut) < NOTHING_UM_S:
        return ""
    texts = []
    for band in cut:
        velocities = f"{velocity(run.bands_um_s[RADIAL][band])} um/s radially"
        if run.axial_doubt is None:
            velocities += f" and {velocity(run.bands_um_s[AXIAL][band])} um/s axially"
        texts.append(f"{velocities} ({BAND_WORDS[band]})")
    return (
        f"A real ring bends from {si(bending_hz, 'Hz')} on. One that stays rigid has"
        f" {'; '.join(texts)}."
    )


def _three(bands: Mapping[str, float]) -> str:
    """Write three velocities with two digits."""
    low, medium, high = (velocity(value) for value in bands.values())
    return f"{low}, {medium} and {high}"


def velocity(um_s: float) -> str:
    """Write a velocity [um/s]; what is below a thousandth is nothing."""
    return "0" if um_s < NOTHING_UM_S else rounded(um_s, 2)


def housing_sentence(run: BearingRun) -> str:
    """Say how loud the plate of the housing is; empty without one."""
    sound = run.housing
    if sound is None:
        return ""
    if sound.levels.laeq_db is None:
        return "The plate of its housing is silent."
    level = decibels_a(sound.levels.laeq_db)
    return f"The plate of its housing is heard at {level} at {run.scene.sound.distance_m:g} m."


def leading_lines(run: BearingRun) -> str:
    """Say which lines are the largest of those that stand out, radially and along the axis."""
    texts = []
    for direction in DIRECTIONS:
        by_frequency = {}  # the last of equal ones, which names its cause
        for row in run.lines_with_levels:
            if (row[f"{direction}_height"] or 0.0) >= HEARD_LINE:
                by_frequency[round(row["frequency_hz"], 2)] = row
        rows = sorted(by_frequency.values(), key=lambda row: -row[f"{direction}_um_s"])
        least = LEAST_SHARE * rows[0][f"{direction}_um_s"] if rows else 0.0
        named = [
            f"{row['name']} ({rounded(row['frequency_hz'], 4)} Hz,"
            f" {velocity(row[f'{direction}_um_s'])} um/s)"
            for row in rows[:_MOST_LINES]
            if row[f"{direction}_um_s"] >= max(least, NOTHING_UM_S)
        ]
        if named:
            verdict = ""
            if direction == AXIAL and run.axial_doubt is not None:
                verdict = f" ({run.axial_doubt.severity.word} these)"
            texts.append(f"{direction} {', '.join(named)}{verdict}")
    if not texts:
        return "No line stands out."
    return f"The largest lines are {'; '.join(texts)}."


def unresolved_lines(run: BearingRun) -> str:
    """Say which lines the record does not separate from stronger ones; empty for none."""
    needed_s: dict[str, float] = {}
    for row in run.lines_with_levels:
        for direction in DIRECTIONS:
            resolving_s = row[f"{direction}_resolved_by_s"]
            if resolving_s is not None:
                needed_s[row["name"]] = max(resolving_s, needed_s.get(row["name"], 0.0))
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
        f"{not_resolved_by(run.record.duration_s).capitalize()} from stronger lines, so without a"
        f" velocity: {', '.join(shown)}."
    )


def fault_sentences(run: BearingRun) -> Iterator[str]:
    """Say for each body with faults whether its line rises in the envelope, and what they add.

    Balls meet the same roughness turn after turn, so a healthy bearing has these lines too.
    """
    rows = {row["name"]: row for row in run.envelope_lines}
    for body in run.faulty:
        name = FAULT_LINES[body]
        row = rows[name]
        ring = "a ball" if body == "balls" else f"the {body} raceway"
        at = f"{name}, {rounded(row['frequency_hz'], 4)} Hz"
        if row["height"] is None:
            text = unresolved(run.record.duration_s, row["resolved_by_s"])
            yield f"The fault of {ring} may have a line in the envelope at {at}: {text}."
            continue
        size = f"{rounded(row['height'])} times its surroundings"
        rises = row["height"] >= STRONG_LINE
        if run.without_faults is not None:
            before = run.without_faults.heights.get(name, 0.0)
            if before is None:
                size += f", and {not_resolved_by(run.record.duration_s)} without the fault"
            else:
                size += f", and {rounded(before)} times without the fault"
                rises = rises and row["height"] >= RISE * before
        verb = "shows" if rises else "does not show"
        yield f"The fault of {ring} {verb} in the envelope at {at}: {size}."
    if run.without_faults is not None:
        yield _added_by_faults(run, run.without_faults)


def not_resolved_by(duration_s: float) -> str:
    """Say that a record does not separate a line from a stronger one."""
    return f"not resolved by {rounded(duration_s, 3)} s"


def unresolved(duration_s: float, resolving_s: float) -> str:
    """Say that a record does not separate a line from a stronger one, and which one would."""
    return f"{not_resolved_by(duration_s)}, {rounded_up(resolving_s)} s would"


def _added_by_faults(run: BearingRun, healthy: WithoutFaults) -> str:
    """Say by how many decibels faults raise the radial velocity in the three bands."""
    if min(healthy.bands_um_s[RADIAL].values()) < NOTHING_UM_S:
        return f"Without faults the ring vibrates at {_three(healthy.bands_um_s[RADIAL])} um/s."
    added = []
    for band, um_s in run.bands_um_s[RADIAL].items():
        decibels = 20 * math.log10(max(um_s, NOTHING_UM_S) / healthy.bands_um_s[RADIAL][band])
        added.append(f"{round(decibels, 1) + 0.0:+.1f}")  # no "-0.0"
    low, medium, high = added
    noun = "The fault changes" if len(run.faulty) == 1 else "The faults change"
    return f"{noun} the three bands by {low}, {medium} and {high} dB."


def load_sentence(run: BearingRun) -> str:
    """Say between which loads the balls work."""
    loads = run.record.ball_load_n
    least = rounded(float(loads.min()), 3)
    largest = rounded(float(loads.max()), 3)
    if least == largest:
        return f"The load of a ball is {least} N."
    return f"The load of a ball is {least} to {largest} N."


# ---- doubts


def doubts_of(run: BearingRun) -> Iterator[Doubt]:
    """Yield what makes the bands of a run uncertain, one sentence each."""
    yield from run.solved
    yield from _short_record(run)
    yield from _assumed_damping(run)
    for doubt in scene_rules(run.scene):
        if isinstance(doubt, Doubt):
            yield _with_share(run, doubt) if doubt.key == "ring_bending" else doubt
    yield from _lost_contact(run)
    yield from _energy(run)


def _short_record(run: BearingRun) -> Iterator[Doubt]:
    """Doubt bands that scatter within a short record."""
    uncertain = {
        name: db
        for name, db in run.record.bands[RADIAL].uncertainty_db.items()
        if run.bands_um_s[RADIAL][name] >= NOTHING_UM_S
    }
    if not uncertain:
        return
    name, largest = max(uncertain.items(), key=lambda item: item[1])
    if largest < _UNCERTAIN_DB:
        return
    yield sized(
        "short_record",
        f"the record of {rounded(run.record.duration_s, 3)} s leaves ± {largest:.1f} dB in the"
        f" {name} band",
        largest,
        "four times sound.duration_s halve it",
    )


def _assumed_damping(run: BearingRun) -> Iterator[Doubt]:
    """Doubt bands that an assumed loss factor of the contacts moves."""
    part = run.uncertainty.parts_db.get(LOSS_FACTOR)
    if part is None:
        return
    largest = max(max(bands.values()) for bands in part.values())
    if largest < _UNCERTAIN_DB:
        return
    most = assumed_damping.LARGEST_LOSS_FACTOR
    change = assumed_damping.band_change_db(run.record, run.model, most)
    radial, axial = (
        ", ".join(f"{decibels:+.1f}" for decibels in _without_minus_zero(change[direction]))
        for direction in DIRECTIONS
    )
    yield sized(
        "loss_factor",
        f"the loss factor of the contacts, {run.model.contact_loss_factor:g}, is assumed; at"
        f" {most:g}, which a lubricated bearing may have, the three bands would be {radial} dB"
        f" radially and {axial} dB axially",
        largest,
        advice="give bearing.contact_loss_factor as measured, such as by a tap on the ring",
    )


def _without_minus_zero(bands: Mapping[str, float]) -> list[float]:
    """Return decibels with one digit and without a negative zero."""
    return [round(decibels, 1) + 0.0 for decibels in bands.values()]


def _with_share(run: BearingRun, doubt: Doubt) -> Doubt:
    """Return the doubt about a ring that bends, with the part of the high band that it has."""
    if run.bands_um_s[RADIAL]["high"] < NOTHING_UM_S:
        return doubt
    decibels = run.share_above_bending_db
    if math.isinf(decibels):
        text = f"{doubt.text}; all of the high band lies above"
        return replace(doubt, text=text, severity=Severity.DO_NOT_QUOTE)
    text = f"{doubt.text}; what lies above raises the high band by {decibels:.1f} dB"
    return replace(doubt, text=text, severity=severity_of(decibels), decibels=decibels)


def _lost_contact(run: BearingRun) -> Iterator[Doubt]:
    """Say that balls lose contact, where an axial load presses all of them."""
    share = run.record.lost_contact_share
    if share > 0 and run.housing is not None:
        yield Doubt(
            key="housing_linear",
            text=f"balls bear nothing for {rounded(100 * share)} % of the time, and the level of"
            " the housing holds for balls that stay in contact",
            severity=Severity.INDICATIVE,
        )
    if share > 0 and not run.scene.radial_load > 0:
        yield Doubt(
            key="lost_contact",
            text=f"a ball bears nothing for {rounded(100 * share)} % of the time",
            severity=Severity.NOTE,
            advice="a larger axial load holds the balls",
        )


def _energy(run: BearingRun) -> Iterator[Doubt]:
    """Doubt a motion whose energy does not balance."""
    error = abs(run.record.energy_error)
    decibels = _ENERGY_DB * error
    if decibels > _LEAST_DB:
        text = f"the energy of the motion lacks {rounded(100 * error)} %: {decibels:.1f} dB"
        yield sized("energy_balance", text, decibels)
