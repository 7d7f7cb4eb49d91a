"""Say whether a listener in a room hears the difference between two candidates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from acoustics import audibility
from acoustics.arrays import Array
from acoustics.audibility import AUDIBLE, NOT_AUDIBLE, NOT_AUDIBLE_PERCENT, Audibility

# Specimens that are heard. More take time, and the first ones know the difference well enough.
MOST_SPECIMENS = 8


class HeardRecord(NamedTuple):
    """Sound pressure of a specimen at the listener."""

    pressure: Array  # (n,), Pa
    sample_rate_hz: float
    closed: bool  # whether the end meets the beginning


@dataclass(frozen=True)
class HeardDifference:
    """Audibility of the difference between two candidates.

    Attributes
    ----------
    audibility : Audibility or None
        Loudness of both in the room, their difference and the verdict. None where it is unknown.
    text : str
        One or two sentences: the verdict with its numbers, or why there is none.
    """

    audibility: Audibility | None
    text: str


def heard_difference(
    records_a: Sequence[HeardRecord],
    records_b: Sequence[HeardRecord],
    room_db: Mapping[str, float] | None = None,
    names: tuple[str, str] = ("A", "B"),
) -> HeardDifference:
    """Judge whether the difference between two candidates is audible in the noise of a room.

    The records are those of a vibration, which a listener hears. The first 8 specimens are heard.

    Parameters
    ----------
    records_a, records_b : sequence of HeardRecord
        Paired specimens: the first of A belongs to the first of B.
    room_db : mapping, optional
        `sound.room_db` of the scene, dB re 20 uPa. Default: pink noise of 30 dB(A).
    names : pair of str
        Names of A and B in the sentence.

    Returns
    -------
    HeardDifference
        Its audibility is None where a sound is too loud for ISO 532-1.

    Raises
    ------
    ValueError
        As `acoustics.audible_difference`.
    """
    if not len(records_a) == len(records_b) > 0:
        raise ValueError(
            f"records: got {len(records_a)} of {names[0]} and {len(records_b)} of {names[1]}, "
            "allowed: equally many of both, and at least one"
        )
    heard_a = records_a[:MOST_SPECIMENS]
    heard_b = records_b[:MOST_SPECIMENS]
    levels_db = None
    if room_db is not None:
        levels_db = {float(name): level for name, level in room_db.items()}
    try:
        result = audibility.audible_difference(
            records_a=[record.pressure for record in heard_a],
            records_b=[record.pressure for record in heard_b],
            sample_rate_hz=heard_a[0].sample_rate_hz,
            closed_a=all(record.closed for record in heard_a),
            closed_b=all(record.closed for record in heard_b),
            room_db=levels_db,
        )
    except audibility.TooLoudError:
        text = (
            "It is not known whether the difference is audible: a third octave up to 250 Hz "
            "exceeds 120 dB, where the loudness of ISO 532-1 is not defined."
        )
        return HeardDifference(None, text)
    return HeardDifference(result, _sentence(result, names))


def _sentence(result: Audibility, names: tuple[str, str]) -> str:
    """Write the verdict with its numbers."""
    name_a, name_b = names
    percent = f"{abs(result.difference_percent):.1f} ± {result.uncertainty_percent:.1f} %"
    louder, quieter = name_a, name_b
    n5_louder, n5_quieter = result.n5_a_sone, result.n5_b_sone
    if result.difference_percent < 0:
        louder, quieter = name_b, name_a
        n5_louder, n5_quieter = result.n5_b_sone, result.n5_a_sone
    numbers = (
        f"in the room, the loudness N5 of {louder} is {percent} above N5 of {quieter} "
        f"({n5_louder:.3g} and {n5_quieter:.3g} sone; the room alone {result.n5_room_sone:.3g})"
    )
    if result.verdict == AUDIBLE:
        return f"The difference is audible: {numbers}."
    if result.verdict == NOT_AUDIBLE:
        sentence = f"The difference is not audible: {numbers}."
    else:
        sentence = f"The difference is perhaps audible: {numbers}."
    if n5_louder < result.n5_room_sone * (1.0 + NOT_AUDIBLE_PERCENT / 100.0):
        sentence += " The noise of the room masks both."
    return sentence
