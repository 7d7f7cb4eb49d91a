"""Sheets of a bearing: its vibration in three bands, and the declaration of its housing plate."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from acoustics.impulsiveness import ENDS_S, band_pulses
from acoustics.numbers import rounded
from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling import __version__
from rolling.bearing.ring_record import AXIAL, NOTHING_UM_S, RADIAL, UM_S
from rolling.bearing_kind import bearing_sentences
from rolling.numbers.bearing_numbers import LineVelocity
from rolling.numbers.doubt import Severity
from rolling.numbers.quantity import Quantity, spread_text
from rolling.numbers.sheet import NONE, Sheet, SheetCell, SheetRow, SheetTable
from rolling.results import noise_sheet
from rolling.results.description import plate_material, plate_size

if TYPE_CHECKING:
    from rolling.bearing_kind.bearing_run import BearingRun

VIBRATION = "bearing vibration"
NOISE = "noise"
NOTICE = (
    "These velocities were calculated. They are no result of a measurement by ISO 15242: they have "
    "its bands, for a reader who compares."
)
DEPARTURES = (
    "The bands have steep edges instead of the slopes of the standard's filters.",
    "No spikes are counted; crest factor and kurtosis stand beside the peak.",
    "One side of the load was computed; a measurement loads the bearing from both sides.",
)
_COLUMN_OF = {RADIAL: 0, AXIAL: 2}  # of the record, where pulses are looked for


def vibration_sheet(run: BearingRun) -> Sheet:
    """Return the vibration sheet of a run: bands, peaks and lines, from what is stored."""
    numbers = run.numbers
    words = bearing_sentences.condition(run.scene)
    not_iso = [f"Not ISO 15242: {text}." for text in numbers.departures]
    limits = [doubt.line for doubt in numbers.doubts if doubt.severity > Severity.TRUST]
    doubts = [f"{line[0].upper()}{line[1:]}." for line in limits]
    return Sheet(
        name=VIBRATION,
        title="Bearing vibration sheet in the bands of ISO 15242-1, calculated",
        subject=f"{words[0].upper()}{words[1:]}.",
        notice=NOTICE,
        tables=(_band_table(run), _pulse_table(run), _line_table(run), _envelope_table(run)),
        facts=tuple(_facts(run)),
        departures=(_class_words(run), *DEPARTURES, *not_iso, *doubts),
    )


def _class_words(run: BearingRun) -> str:
    """State the class of the computed velocities, which no maker has measured."""
    words = bearing_sentences.class_sentence(run.numbers)
    if not words:
        return "No class: the run is of a version that assigned none."
    return f"{words} A maker's class belongs to a measured bearing."


# ---- tables


def _band_table(run: BearingRun) -> SheetTable:
    """Return the velocities of the bands below the bending, and those of a rigid ring above it."""
    ring = run.numbers.ring
    rows = []
    for direction, velocities in run.numbers.below_bending.by_direction.items():
        for band, words in bearing_sentences.band_words(ring).items():
            cells = _velocity_cells(velocities.by_band[band])
            rows.append(SheetRow(symbol=f"{direction}, {band}", meaning=words, cells=cells))
    for direction, velocities in run.numbers.velocities.by_direction.items():
        for band, (_, end_hz) in run.bands_below_bending_hz.items():
            if end_hz < VELOCITY_BANDS_HZ[band][1]:
                words = f"{bearing_sentences.BAND_WORDS[band]}, {bearing_sentences.above(ring)}"
                cells = _velocity_cells(velocities.by_band[band])
                rows.append(SheetRow(symbol=f"{direction}, {band}", meaning=words, cells=cells))
    title = "Velocity of the ring, rms"
    return SheetTable(title=title, heads=("velocity", "uncertainty", "verdict"), rows=tuple(rows))


def _velocity_cells(velocity: Quantity) -> tuple[SheetCell, SheetCell, SheetCell]:
    """Return the cells of a velocity: its value, its ±, and its verdict."""
    text = bearing_sentences.velocity(velocity.value)
    if velocity.value is not None:
        text = f"{text} µm/s"
    spread = bearing_sentences.spread_of_velocity(velocity)
    uncertainty = velocity.uncertainty if spread.startswith("±") else None
    value = SheetCell(
        value=velocity.value,
        unit="um/s",
        text=text,
        uncertainty=uncertainty,
        uncertainty_unit="dB",
    )
    return (
        value,
        SheetCell(value=uncertainty, unit="dB", text=spread if uncertainty is not None else NONE),
        SheetCell(value=None, text=velocity.verdict or NONE),
    )


def _pulse_table(run: BearingRun) -> SheetTable:
    """Return peak, crest factor and kurtosis of the record of each band and direction."""
    rows = []
    words = bearing_sentences.band_words(run.numbers.ring)
    bands_hz = {band: run.bands_below_bending_hz[band] for band in words}
    for direction, column in _COLUMN_OF.items():
        seen = run.record.seen_velocity_m_s[:, column]
        for band, pulses in band_pulses(seen, run.record.rate_hz, bands_hz).items():
            cells = [SheetCell(value=None, text=NONE)] * 3
            peak = UM_S * pulses.peak
            if pulses.kurtosis is not None and peak >= NOTHING_UM_S:
                spread = pulses.kurtosis_uncertainty or 0.0
                cells = [
                    SheetCell(value=peak, unit="um/s", text=f"{rounded(peak)} µm/s"),
                    SheetCell(value=pulses.crest_factor, text=rounded(pulses.crest_factor or 0.0)),
                    SheetCell(
                        value=pulses.kurtosis,
                        text=f"{rounded(pulses.kurtosis)} (noise: 3 ± {spread_text(spread)})",
                        uncertainty=spread,
                    ),
                ]
            symbol = f"{direction}, {band}"
            at = "along the shaft" if direction == AXIAL else run.scene.seen_at("along the load")
            meaning = f"{words[band]}, {at}"
            rows.append(SheetRow(symbol=symbol, meaning=meaning, cells=tuple(cells)))
    heads = ("peak", "crest factor", "kurtosis")
    return SheetTable(title="Peaks of the same bands", heads=heads, rows=tuple(rows))


def _line_table(run: BearingRun) -> SheetTable:
    """Return the lines of the spectrum."""
    rows = []
    for line in run.numbers.lines:
        cells = [_frequency_cell(line.frequency_hz)]
        cells += [_line_cell(own) for own in line.by_direction.values()]
        rows.append(SheetRow(symbol=line.name, meaning=line.meaning, cells=tuple(cells)))
    heads = ["frequency", *run.numbers.velocities.by_direction]
    doubt = run.numbers.axial_doubt
    if doubt is not None:
        heads[-1] += f", {doubt.severity.word}"
    title = "Lines of the spectrum, rms"
    return SheetTable(title=title, heads=tuple(heads), rows=tuple(rows))


def _frequency_cell(frequency_hz: float) -> SheetCell:
    """Return the cell of the frequency of a line."""
    text = f"{bearing_sentences.hertz(frequency_hz)} Hz"
    return SheetCell(value=frequency_hz, unit="Hz", text=text)


def _line_cell(line: LineVelocity) -> SheetCell:
    """Return the velocity of a line, or that the record does not resolve it."""
    if line.um_s is None:
        return SheetCell(value=None, unit="um/s", text="not resolved")
    text = f"{bearing_sentences.velocity(line.um_s)} µm/s"
    return SheetCell(value=line.um_s, unit="um/s", text=text)


def _envelope_table(run: BearingRun) -> SheetTable:
    """Return the lines of the envelope, where faults show."""
    rows = []
    for line in run.numbers.envelope_lines:
        at = _frequency_cell(line.frequency_hz)
        text = "not resolved" if line.height is None else rounded(line.height)
        height = SheetCell(value=line.height, text=text)
        rows.append(SheetRow(symbol=line.name, meaning=line.meaning, cells=(at, height)))
    band = bearing_sentences.envelope_words(run.numbers)
    title = f"Lines of the envelope{band}, {run.scene.seen_at('along the load')}"
    return SheetTable(title=title, heads=("frequency", "over surroundings"), rows=tuple(rows))


# ---- facts


def _facts(run: BearingRun) -> Iterator[tuple[str, str]]:
    """Yield how the bearing ran, and where its velocity is."""
    bearing = run.scene.bearing
    numbers = run.numbers
    record_s = rounded(numbers.motion.duration_s, 3)
    yield "Speed", f"{rounded(bearing.speed_rpm, 4)} rpm, the {bearing.turning} ring turns"
    yield (
        "Load",
        f"{rounded(bearing.axial_load_n, 3)} N axial, {rounded(bearing.radial_load_n, 3)} N radial",
    )
    yield (
        "Side of the load",
        "one: along the shaft, to the side on which the balls touch both rings",
    )
    radially = (
        "rms radially as the mean over all directions by power, peaks radially along the load"
    )
    if bearing.sensor_deg is not None:
        radially = f"rms and peaks radially {run.scene.seen_at('')}"
    yield (
        "Sensor",
        f"the {numbers.ring.moving} ring, which does not turn: {radially}, and both axially",
    )
    mounting = "free and rigid"
    bands = f"up to the first bending of the ring at {numbers.ring.bending_hz:,.0f} Hz, above which"
    bands += " it is not rigid"
    if numbers.ring.left_out_hz is not None:
        mounting = "free and bends in its plane"
        bands = (
            f"up to {numbers.ring.left_out_hz:,.0f} Hz, from where on the ring has further modes"
        )
    yield "Mounting", f"the ring is {mounting}, {rounded(1e3 * numbers.ring.mass_kg, 3)} g"
    yield "Bands", bands
    yield "Record", f"{record_s} s at {run.record.rate_hz:,.0f} Hz"
    yield (
        "Method",
        f"rolling-contact-noise {__version__}: the ring moved in time over the tracks of all rough"
        " contacts. All of it is simulated; nothing was measured.",
    )
    yield (
        "Uncertainty",
        "one standard uncertainty of the calculation, in dB; no spread of production or of test"
        " stands",
    )
    yield (
        "Peaks",
        f"of the record in a band with steep edges, without its ends, up to {ENDS_S:g} s each",
    )


def housing_sheet(run: BearingRun) -> Sheet | None:
    """Return the declaration of the level of the housing plate; None without one."""
    housing = run.numbers.housing
    plate = run.scene.plate
    if housing is None or plate is None:
        return None
    level = housing.laeq
    parts = noise_sheet.parts_table(level)
    tables = [noise_sheet.declared_table(level)]
    if parts is not None and not noise_sheet.why_not_declared(level):
        tables.append(parts)
    words = bearing_sentences.condition(run.scene)
    facts = (
        ("Quantity", f"{level.measure}: {level.meaning}"),
        ("Position", f"{level.where}, in a free field without a room"),
        ("Mounting", f"a {plate_material(plate)} plate of {plate_size(plate)}, in a rigid baffle"),
        ("Operating conditions", f"{words[0].upper()}{words[1:]}"),
        ("Record", f"{rounded(run.numbers.motion.duration_s, 3)} s"),
        (
            "Method",
            f"rolling-contact-noise {__version__}: the force of the ring shakes the plate. All of"
            " it is simulated; nothing was measured.",
        ),
        ("Verdict", "" if level.judged is None else level.judged.sentence),
        ("Deviation behind K", noise_sheet.DEVIATION),
    )
    return Sheet(
        name=NOISE,
        title=noise_sheet.TITLE,
        subject=f"Housing plate of {words}.",
        notice=noise_sheet.NOTICE,
        tables=tuple(tables),
        facts=tuple((name, text) for name, text in facts if text),
        departures=tuple(noise_sheet.departures(level, has_peak=False)),
    )
