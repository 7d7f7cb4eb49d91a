"""The two numbers of a run, as quantities.

The first is the vibration: what a listener would hear. The second is the released power: what would
be heard if all elastic energy that asperities give back were sound, an upper bound.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from acoustics.numbers import rounded
from rolling.numbers.ball_numbers import DB_A, RunNumbers, SourceLevels
from rolling.numbers.doubt import Doubt
from rolling.numbers.quantity import (
    RELEASED_POWER,
    VIBRATION,
    How,
    Quantity,
    RecordOfNumber,
    joined,
)
from rolling.results.run_errors import LINEAR

LAEQ = "LAeq"
LAE = "LAE"  # re 1 s, of a single event
UNKNOWN = Quantity(VIBRATION, None, reason="it is not computed")

Parts = Mapping[str, float | None]


def with_quantities(
    numbers: RunNumbers,
    of_sound: Parts,
    of_vibration: Parts,
    of_estimate: Parts,
    whole_vibration_db: float | None = None,
) -> RunNumbers:
    """Return the numbers of a run with its two quantities, without doubts.

    Parameters
    ----------
    numbers : RunNumbers
        All other numbers of the run.
    of_sound : dict, dB
        Parts of the uncertainty of the record that is measured, by their source; None: unknown.
    of_vibration : dict, dB
        Parts of the uncertainty of a computed vibration that does not play.
    of_estimate : dict, dB
        Parts of the uncertainty of an estimated vibration.
    whole_vibration_db : float, dB(A)
        Level of the whole record of a vibration that ends, where the release is measured. Default:
        it has none, or it is not known.
    """
    if numbers.record.source == "vibration":
        of_vibration = of_sound
    return replace(
        numbers,
        vibration=_vibration(
            numbers, _known(of_vibration), _known(of_estimate), whole_vibration_db
        ),
        released_power=_released_power(numbers, _known(of_sound)),
    )


def judged(numbers: RunNumbers, doubts: Sequence[Doubt]) -> RunNumbers:
    """Return numbers with doubts about them and about their two quantities."""
    return replace(
        numbers,
        doubts=tuple(doubts),
        vibration=numbers.vibration.with_doubts(doubts),
        released_power=numbers.released_power.with_doubts(doubts),
    )


def _known(parts: Parts) -> dict[str, float]:
    """Return the parts that are known."""
    return {source: part for source, part in parts.items() if part is not None}


# ---- the record whose level leads


def measure(numbers: RunNumbers) -> str:
    """Return what the levels of a run measure: LAE of an event, or LAeq.

    LAeq of a knock depends on the length of the record, so knocks cannot be compared by it.
    """
    return LAE if numbers.record.single_event else LAEQ


def heard_levels(numbers: RunNumbers) -> SourceLevels:
    """Return the levels of the record that is measured, of the whole record of what ends.

    What ends is heard as a whole, so the levels of its long record lead.
    """
    own = numbers.of_record
    long = numbers.heard_whole
    if long is None:
        return own
    return replace(
        own,
        laeq_db=long.laeq_db,
        lae_db=long.lae_db,
        level_db=long.level_db,
        laf_max_db=long.laf_max_db,
        las_max_db=long.las_max_db,
        lz_peak_db=long.lz_peak_db,
    )


def as_heard(numbers: RunNumbers) -> RunNumbers:
    """Return numbers with the levels that people read beside the two numbers.

    The levels of what ends are those of the whole record, and other levels of the solved part are
    left out, as are those of a release that the run does not have. Levels that are measured like
    the one that leads are LAE for an event.
    """
    levels = numbers.levels
    is_whole = numbers.heard_whole is not None
    if numbers.record.source == "vibration":
        has_release = numbers.released_power.value is not None and not is_whole
        vibration: SourceLevels | None = heard_levels(numbers)
        released_power = levels.released_power if has_release else None
    else:
        has_release = not is_whole
        vibration = None if is_whole else levels.vibration
        released_power = heard_levels(numbers)
    at_listener_db = level_beside(numbers, levels.released_power_at_listener_db)
    shown = replace(
        levels,
        vibration=vibration,
        released_power=released_power,
        released_power_at_listener_db=at_listener_db if has_release else None,
        compact_source_level_db=level_beside(numbers, levels.compact_source_level_db),
        hemisphere_mean_level_db=level_beside(numbers, levels.hemisphere_mean_level_db),
        plate_power_level_db=None if is_whole else levels.plate_power_level_db,
        ball_power_level_db=None if is_whole else levels.ball_power_level_db,
    )
    return replace(numbers, levels=shown)


def heard_level_db(numbers: RunNumbers) -> float | None:
    """Return the level of the record that is measured [dB(A)]: LAE of an event, or LAeq."""
    levels = heard_levels(numbers)
    return levels.lae_db if numbers.record.single_event else levels.laeq_db


def exposure_db(numbers: RunNumbers) -> float:
    """Return the level that leads over LAeq of the record [dB], which other levels share; or 0.

    The other levels of an event are shown as LAE too, and those of what ends for the whole record.
    """
    level_db = heard_level_db(numbers)
    is_other = numbers.record.single_event or numbers.heard_whole is not None
    own = numbers.record.laeq_db  # LAeq that is stated may be a mean over a comb
    if not is_other or level_db is None or own is None:
        return 0.0
    return float(level_db - own)


def level_beside(numbers: RunNumbers, level_db: float | None) -> float | None:
    """Return another level of a run [dB], as LAE for an event; None if it is unknown."""
    return None if level_db is None else level_db + exposure_db(numbers)


def _record(numbers: RunNumbers) -> RecordOfNumber:
    """Return the record that the numbers of a run describe."""
    long = numbers.heard_whole
    if long is None:
        seconds = numbers.record.duration_s
        return RecordOfNumber(heard_s=seconds, solved_s=seconds, repeats=numbers.record.loops)
    seconds = long.seconds or 0.0
    share = 1.0 if long.solved_share is None else long.solved_share
    return RecordOfNumber(heard_s=seconds, solved_s=share * seconds, repeats=False)


# ---- the two numbers


def _vibration(
    numbers: RunNumbers,
    of_vibration: Mapping[str, float],
    of_estimate: Mapping[str, float],
    whole_db: float | None,
) -> Quantity:
    """Return the vibration of a run: computed with dynamics, otherwise estimated where possible."""
    if numbers.record.source == "vibration":
        return _computed(numbers, heard_level_db(numbers), of_vibration)
    if numbers.levels.vibration is not None:
        level_db = _level_of_vibration(numbers, numbers.levels.vibration.laeq_db, whole_db)
        return _computed(numbers, level_db, of_vibration)
    return _estimated(numbers, of_estimate, whole_db)


def _level_of_vibration(
    numbers: RunNumbers, level_db: float | None, whole_db: float | None
) -> float | None:
    """Return the level of a vibration beside the release that is measured [dB(A)].

    A vibration that ends falls by other decibels than the release, so it has a level of its own.
    """
    if numbers.heard_whole is None or level_db is None:
        return level_beside(numbers, level_db)
    return whole_db


def _computed(numbers: RunNumbers, level_db: float | None, parts: Mapping[str, float]) -> Quantity:
    """Return a vibration that was computed with the motion of ball and plate."""
    where = "on the axis through the contact"
    if numbers.levels.listeners:
        where = "at the listener of the scene"
    reason = ""
    if level_db is None:
        reason = "ball and plate do not vibrate within hearing"
        motion = numbers.motion
        if motion is not None and motion.flight_share == 1 and not motion.impacts:
            reason = "the record ends before the ball hits the plate"
    return Quantity(
        name=VIBRATION,
        value=level_db,
        unit=DB_A,
        measure=measure(numbers),
        how="computed",
        uncertainty=joined(parts) if parts and level_db is not None else None,
        parts=dict(parts),
        signed={"contact_loss": numbers.contact_loss_db},
        record=_record(numbers),
        where=where,
        meaning=(
            "What a listener would hear: the sound pressure of ball and plate as they vibrate, "
            f"{where}.{_event(numbers)}"
        ),
        reason=reason,
    )


def _estimated(numbers: RunNumbers, parts: Mapping[str, float], whole_db: float | None) -> Quantity:
    """Return the vibration that a linear chain estimates for a run without dynamics."""
    estimate = numbers.estimate
    solved_db = None if estimate is None else estimate.laeq_db
    level_db = _level_of_vibration(numbers, solved_db, whole_db)
    quantity = Quantity(
        name=VIBRATION,
        value=level_db,
        unit=DB_A,
        measure=measure(numbers),
        how="estimated",
        record=_record(numbers),
        where="at the listener",
        meaning="What a listener would hear.",
    )
    if estimate is None:
        return replace(quantity, reason="the run holds no estimate of it")
    if solved_db is None:
        reason = "a contact that does not fluctuate within hearing moves neither ball nor plate"
        return replace(quantity, reason=reason)
    if level_db is None:
        reason = "the level of its whole record is not known"
        return replace(quantity, reason=reason)
    meaning = (
        f"What a listener would hear, estimated by a linear chain for {estimate.bodies}; with a "
        "section dynamics it is computed."
    )
    if loses_contact_in_estimate(numbers):
        meaning += " It is too high, because the ball would lose contact."
    return replace(
        quantity,
        uncertainty=joined(parts) if parts else None,
        parts=dict(parts),
        signed={"contact_loss": numbers.contact_loss_db},
        meaning=meaning + _event(numbers),
    )


def loses_contact_in_estimate(numbers: RunNumbers) -> bool:
    """Tell whether a vibration is estimated for a ball that would lose contact."""
    return numbers.estimate is not None and numbers.estimate.force_ratio > LINEAR


def _released_power(numbers: RunNumbers, parts: Mapping[str, float]) -> Quantity:
    """Return the released power of a run, where the vibration is heard or at `distance_m`."""
    plays = numbers.record.source == "release"
    if plays:
        level_db = heard_level_db(numbers)
    else:
        level_db = level_beside(numbers, numbers.levels.released_power_at_listener_db)
    how: How = "upper bound"
    meaning = (
        "Released power: all elastic energy that asperities give back counts as sound (q = 1). "
        "It is an upper bound, and not what one would hear."
    )
    q = numbers.record.q if plays else 1.0
    if q is None:
        how = "assumed"
        meaning = "Released power under the gain that the scene fixes."
    elif q != 1:
        how = "assumed"
        meaning = f"Released power of which the scene takes a share of q = {q:g} as sound."
    reason = _no_released_power(numbers, level_db)
    has_level = not reason
    is_known = plays and has_level and bool(parts)
    return Quantity(
        name=RELEASED_POWER,
        value=level_db if has_level else None,
        unit=DB_A,
        measure=measure(numbers),
        how=how,
        uncertainty=joined(parts) if is_known else None,
        parts=dict(parts) if is_known else {},
        record=_record(numbers),
        where="at the distance of the listener",
        meaning=meaning + _event(numbers),
        reason=reason,
        is_solved=plays,
    )


def _no_released_power(numbers: RunNumbers, level_db: float | None) -> str:
    """Say why a run has no released power; empty where it has one."""
    if numbers.motion is not None and numbers.motion.drop_mm is not None:
        return "the release is computed for a ball that rolls, and this one falls"
    if level_db is None:
        return "the release does not fluctuate within hearing"
    long = _record(numbers)
    if numbers.record.source == "vibration" and long.solved_share < 1:
        own_db = level_db - exposure_db(numbers)
        return (
            f"it is known for the {rounded(long.solved_s, 2)} s that are solved, where its LAeq is"
            f" {own_db:.1f} dB(A)"
        )
    return ""


def _event(numbers: RunNumbers) -> str:
    """Explain the level of a single event; nothing for a steady sound."""
    if not numbers.record.single_event:
        return ""
    return " LAE is the level of one second that holds the whole sound."


def above_vibration_db(numbers: RunNumbers) -> float | None:
    """Return the level of a release over that of the vibration, or over its estimate [dB]."""
    if numbers.levels.release_over_vibration_db is not None:
        return numbers.levels.release_over_vibration_db
    if numbers.estimate is None or numbers.estimate.laeq_db is None:
        return None
    own = numbers.of_record.laeq_db
    return None if own is None else own - numbers.estimate.laeq_db
