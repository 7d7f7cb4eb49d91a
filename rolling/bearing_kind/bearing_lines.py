"""Lines about runs of bearings for a terminal: the answer, bands, lines and doubts."""

from __future__ import annotations

from collections.abc import Sequence

from rolling.bearing_kind import bearing_sentences
from rolling.kinds.run_folder import RunFolder
from rolling.numbers.bearing_numbers import BearingNumbers
from rolling.numbers.doubt import Severity
from rolling.results.labels import labels
from rolling.results.stored_numbers import numbers_of
from rolling.terminal.streams import columns, folded


def answer_lines(done: Sequence[RunFolder]) -> list[str]:
    """Return the sentences of a run, or the bands of several."""
    if len(done) > 1:
        return [band_table(done)]
    numbers: BearingNumbers = _numbers_of(done[0])
    return [folded(sentence) for sentence in numbers.sentences]


def _numbers_of(run: RunFolder) -> BearingNumbers:
    """Return the numbers of a run that is done."""
    numbers = numbers_of(run)
    assert isinstance(numbers, BearingNumbers)  # of a run that is done
    return numbers


def band_table(done: Sequence[RunFolder]) -> str:
    """Write the radial bands of runs in aligned columns, a row each, [um/s].

    Bands end where the ring bends. The last column has the high band of a ring that stays rigid.
    """
    words = bearing_sentences.BAND_WORDS
    heads = [f"{text}, below the bending" for text in words.values()]
    rows = [["run, radial um/s", *heads, f"{words['high']}, rigid"]]
    for place, label in zip(done, labels(done), strict=True):
        numbers = _numbers_of(place)
        shown = bearing_sentences.band_words(numbers.ring)
        velocities = [
            bearing_sentences.velocity(um_s) if band in shown else bearing_sentences.NO_VELOCITY
            for band, um_s in numbers.below_bending.radial.um_s.items()
        ]
        rigid = bearing_sentences.velocity(numbers.velocities.radial.high.value)
        rows.append([label, *velocities, rigid])
    return columns(rows)


def line_lines(numbers: BearingNumbers) -> str:
    """Write the lines of a run in aligned columns."""
    heads = ["line", "Hz"]
    for direction, bands in numbers.velocities.by_direction.items():
        head = f"{direction} um/s"
        verdicts = {velocity.verdict for velocity in bands.by_band.values()}
        if verdicts == {Severity.DO_NOT_QUOTE.word}:
            head += f" ({Severity.DO_NOT_QUOTE.word})"
        heads.append(head)
    rows = [heads]
    for line in numbers.lines:
        velocities = [
            "not resolved" if own.um_s is None else bearing_sentences.velocity(own.um_s)
            for own in line.by_direction.values()
        ]
        rows.append([line.name, bearing_sentences.hertz(line.frequency_hz), *velocities])
    return columns(rows)


def further_lines(done: Sequence[RunFolder]) -> list[str]:
    """Return the lines of all runs in aligned columns."""
    lines = []
    for run, label in zip(done, labels(done), strict=True):
        lines += ["", label, line_lines(_numbers_of(run))]
    return lines
