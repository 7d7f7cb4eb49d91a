"""Tables of a bearing run that its folder holds: the narrow spectra, and the lines."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pandas import DataFrame

from rolling.bearing.ring_record import AXIAL, RADIAL, UM_S
from rolling.bearing_kind import bearing_sentences
from rolling.numbers import views
from rolling.numbers.bearing_numbers import EnvelopeLine, VelocityLine

if TYPE_CHECKING:
    from rolling.bearing_kind.bearing_run import BearingRun

SHOWN_HZ = (20.0, 20_000.0)  # frequencies of the narrow spectra that are shown


def spectrum_table(run: BearingRun) -> DataFrame:
    """Tabulate the narrow spectra of the velocity [um/s] up to 20 kHz."""
    frequency_hz = run.record.spectra[RADIAL].frequency_hz
    shown = frequency_hz <= SHOWN_HZ[1]
    table = {"frequency_hz": frequency_hz[shown]}
    for direction in (RADIAL, AXIAL):
        table[f"{direction}_um_s"] = UM_S * run.record.spectra[direction].rms[shown]
    return DataFrame(table)


def line_table(run: BearingRun) -> DataFrame:
    """Tabulate the lines of a run, those of the envelope below, with a note on what is unknown."""
    numbers = run.numbers
    duration_s = numbers.motion.duration_s
    rows = [
        _cells(line) | {"of": "velocity", "note": _velocity_note(line, duration_s)}
        for line in numbers.lines
    ]
    rows += [
        _cells(line) | {"of": "envelope", "note": _unresolved(line.resolved_by_s, duration_s)}
        for line in numbers.envelope_lines
    ]
    return DataFrame(rows)


def _cells(line: VelocityLine | EnvelopeLine) -> dict[str, Any]:
    """Return the numbers of a line by the names of their columns."""
    return {name: cell.value for name, cell in views.columns(line).items()}


def _velocity_note(line: VelocityLine, duration_s: float) -> str:
    """Say in which directions a line is not resolved, and which length would; empty if in none."""
    notes = []
    for direction, own in line.by_direction.items():
        text = _unresolved(own.resolved_by_s, duration_s)
        if text:
            notes.append(f"{direction}: {text}")
    return "; ".join(notes)


def _unresolved(resolving_s: float | None, duration_s: float) -> str:
    """Say that a line is not resolved, and which length would; empty for one that is."""
    return "" if resolving_s is None else bearing_sentences.unresolved(duration_s, resolving_s)
