"""Third octaves against IEC 61260-1:2014."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from acoustics.bands import (
    BAND_NAMES,
    BANDWIDTH_HZ,
    EDGES_HZ,
    MID_HZ,
    MIN_BT,
    third_octave_mean_square,
)
from acoustics.resampling import fade
from acoustics.spectrum import line_spectrum
from acoustics.wav import SAMPLE_RATE_HZ
from conformance import standards
from conformance.rows import Row, Table, suppression_db, tone

# limit where the standard gives exact formulas and no tolerance: the fifth digit
FREQUENCY_LIMIT_PPM = 10.0

# The program fades a record that does not close over this time at both ends.
_FADE_S = 0.01

# From here on half a period is less than a thousandth of the frequency.
_MANY_PERIODS = 500

# Third octaves from 20 Hz to 20 kHz, counted from 1 kHz.
_OFFSETS = range(-17, 14)


def mid_band_frequencies() -> Table:
    """Compare mid-band frequencies and names."""
    return Table(
        "Third octaves: mid-band frequencies and names",
        f"the limit of {FREQUENCY_LIMIT_PPM:g} ppm",
        "IEC 61260-1:2014, 5.2 to 5.4 and annex E",
        "Are the bands where they should be? Expected is 1000 G^(x/3) Hz with G = "
        "10^(3/10) and x = -17 to 13, named by the R10 series. Computed are `bands.MID_HZ`, "
        "named by `bands.BAND_NAMES`. The standard gives no tolerance; 10 ppm is the fifth "
        "digit.",
        ("R10 Hz", "name"),
        "Hz",
        4,
        tuple(
            _frequency_row(
                (f"{standards.third_octave_nominal_hz(x):g}", name),
                standards.third_octave_mid_hz(x),
                mid_hz,
            )
            for x, name, mid_hz in zip(_OFFSETS, BAND_NAMES, MID_HZ, strict=True)
        ),
    )


def band_edges() -> Table:
    """Compare band-edge frequencies."""
    expected = [standards.third_octave_edge_hz(x, -1) for x in _OFFSETS]
    expected.append(standards.third_octave_edge_hz(_OFFSETS[-1], 1))
    names = [(f"lower edge of {name}",) for name in BAND_NAMES]
    names.append((f"upper edge of {BAND_NAMES[-1]}",))
    return Table(
        "Third octaves: band edges",
        f"the limit of {FREQUENCY_LIMIT_PPM:g} ppm",
        "IEC 61260-1:2014, 5.6",
        "Do the bands meet? Expected is the mid-band frequency times G^(-1/6) and "
        "G^(1/6). Computed are `bands.EDGES_HZ`. The upper edge of a band is the lower edge of "
        "the next, so no frequency is counted twice or left out.",
        ("edge",),
        "Hz",
        4,
        tuple(_frequency_row(*row) for row in zip(names, expected, EDGES_HZ, strict=True)),
    )


def _frequency_row(keys: tuple[str, ...], expected: float, computed: float) -> Row:
    limit = FREQUENCY_LIMIT_PPM * 1e-6 * expected
    return Row(keys, expected, float(computed), -limit, limit)


@dataclass(frozen=True)
class MaskPoint:
    """A frequency at which the standard limits the attenuation of a third octave.

    ``side`` is -1 below the mid-band frequency, 1 above; ``ratio`` is f/f_mid.
    """

    side: int
    ratio: float
    min_db: float
    max_db: float

    @property
    def inside(self) -> bool:
        """Whether the point lies inside the band."""
        return math.isfinite(self.max_db)

    @property
    def at_edge(self) -> bool:
        """Whether the point lies at a band edge."""
        return math.isclose(
            self.ratio**self.side, standards.third_octave_frequency_ratio(0.5), rel_tol=1e-6
        )


def mask_points() -> tuple[MaskPoint, ...]:
    """Return the standard's frequencies and limits for third octaves, in rising order."""
    points = []
    for exponent, min_db, max_db in standards.OCTAVE_ATTENUATION:
        ratio = standards.third_octave_frequency_ratio(exponent)
        for side in (-1, 1) if exponent > 0.0 else (1,):
            points.append(MaskPoint(side, ratio**side, min_db, max_db))
    return tuple(sorted(points, key=lambda point: (point.ratio, point.inside == (point.side < 0))))


def attenuation_db(
    frequency_hz: float,
    band: int,
    samples: int,
    rate_hz: float,
    phase: float = 0.4,
    fade_s: float = 0.0,
) -> float:
    """Return the level of a tone's record minus its level in a band, dB.

    It is infinite if the band holds only rounding.
    """
    record = fade(tone(frequency_hz, samples, rate_hz, phase), round(fade_s * rate_hz))
    lines_hz, mean_square = line_spectrum(record, rate_hz)
    in_band = third_octave_mean_square(lines_hz, mean_square)[band]
    return suppression_db(float(in_band / mean_square.sum()))


def closed_records() -> Table:
    """Measure the attenuation on records of a whole number of periods, as of closed tracks."""
    duration_s = 10.0
    samples = round(duration_s * SAMPLE_RATE_HZ)
    rows = []
    for band in (0, BAND_NAMES.index("1000"), len(BAND_NAMES) - 1):
        for point in mask_points():
            line = point.ratio * MID_HZ[band] * duration_s
            if point.at_edge:  # the lines on its two sides
                toward_mid = point.inside == (point.side < 0)
                line = math.ceil(line) if toward_mid else math.floor(line)
            frequency_hz = round(line) / duration_s
            if frequency_hz < SAMPLE_RATE_HZ / 2.0:
                keys = (BAND_NAMES[band], _ratio(point), f"{frequency_hz:.1f}")
                rows.append(
                    _attenuation_row(
                        keys, point, attenuation_db(frequency_hz, band, samples, SAMPLE_RATE_HZ)
                    )
                )
    return Table(
        "Third octaves: tones on a line",
        "class 1",
        "IEC 61260-1:2014, 5.10, Table 1 and formulas (9), (10)",
        "Do closed records meet class 1? The tones have the standard's normalised "
        "frequencies f/f_mid. Each is moved to the nearest of the 0.1 Hz lines of a 10 s record"
        " at 48 kHz, so the record holds a whole number of periods. Every sound at constant "
        "speed on a closed track is of this kind: the lines of the record are the signal "
        "itself. Computed is the level of the tone minus its level in the band. *in* and *out* "
        "name the line next to the edge, on this side of it. No record at 48 kHz holds a tone "
        "above 24 kHz.",
        ("band", "f/f_mid", "f Hz"),
        "dB",
        2,
        tuple(rows),
    )


def _ratio(point: MaskPoint) -> str:
    mark = "" if not point.at_edge else " in" if point.inside else " out"
    return f"{point.ratio:.4f}{mark}"


def _attenuation_row(keys: tuple[str, ...], point: MaskPoint, computed: float) -> Row:
    return Row(keys, 0.0 if point.inside else math.inf, computed, point.min_db, point.max_db)


@dataclass(frozen=True)
class OpenRecord:
    """A record that does not hold a whole number of periods."""

    duration_s: float
    fade_s: float

    @property
    def name(self) -> str:
        """Duration and ends, for a table."""
        return f"{self.duration_s:g} s, {'faded' if self.fade_s else 'cut'}"


OPEN_RECORDS = (
    OpenRecord(0.5, 0.0),
    OpenRecord(0.5, _FADE_S),
    OpenRecord(10.0, 0.0),
    OpenRecord(10.0, _FADE_S),
)

_PARTS: tuple[tuple[str, Callable[[MaskPoint], bool]], ...] = (
    ("inside", lambda point: point.inside and not point.at_edge),
    ("edges", lambda point: point.at_edge),
    ("outside", lambda point: not point.inside and not point.at_edge),
)


def open_attenuation(record: OpenRecord, band: int, part: Callable[[MaskPoint], bool]) -> Row:
    """Measure the worst attenuation of a band at the points of a part, for tones half a line off.

    The tones have the standard's frequencies. The record is lengthened or shortened by up to half a
    period until they lie midway between two lines. Many periods are changed in frequency instead,
    which keeps the length of the transform fast. Tones at the edges are one to two lines off. The
    two phases are a quarter period apart, because a tone's mirror at negative frequency adds or
    subtracts.
    """
    # The standard's highest frequency, 5.39 f_mid, and a fade of 10 ms need no more samples.
    rate_hz = float(np.clip(12.0 * math.ceil(MID_HZ[band]), 2400.0, SAMPLE_RATE_HZ))
    rows = []
    for point in filter(part, mask_points()):
        frequency_hz = point.ratio * float(MID_HZ[band])
        duration_s = record.duration_s
        line = frequency_hz * duration_s
        if point.at_edge:
            upwards = point.inside == (point.side < 0)
            half_line = math.ceil(line + 0.5) + 0.5 if upwards else math.floor(line - 0.5) - 0.5
            frequency_hz = half_line / duration_s
        elif line < _MANY_PERIODS:
            duration_s = (math.floor(line) + 0.5) / frequency_hz
        else:
            frequency_hz = (math.floor(line) + 0.5) / duration_s
        if frequency_hz >= rate_hz / 2.0:
            continue
        keys = (
            record.name,
            BAND_NAMES[band],
            f"{BANDWIDTH_HZ[band] * record.duration_s:.1f}",
            _ratio(point),
        )
        for phase in (0.0, 0.5 * math.pi):
            computed = attenuation_db(
                frequency_hz, band, round(duration_s * rate_hz), rate_hz, phase, record.fade_s
            )
            rows.append(_attenuation_row(keys, point, computed))
    return max(rows, key=lambda row: row.share)


def min_lines_inside() -> float:
    """Find the B T from which class 1 holds inside a band for every record length.

    The scan covers cut records from B T = 4 to 8; a scan up to 40 gave the same. The leakage of a
    cut record depends only on the number of lines in the band.
    """
    band = BAND_NAMES.index("100")
    rate_hz = 2400.0
    inside = [point for point in mask_points() if point.inside and not point.at_edge]
    minimum = lines = 4.0
    while lines < 8.0:
        samples = round(lines / BANDWIDTH_HZ[band] * rate_hz)
        for point in inside:
            for phase in (0.0, 0.5 * math.pi):
                computed = attenuation_db(
                    point.ratio * float(MID_HZ[band]), band, samples, rate_hz, phase
                )
                if not _attenuation_row((), point, computed).within:
                    minimum = lines + 0.02
        lines += 0.02
    return minimum


def open_records() -> Table:
    """Measure the attenuation on records that do not close.

    Their ends leak, whether cut or faded.
    """
    shown = (0, BAND_NAMES.index("100"), BAND_NAMES.index("1000"), len(BAND_NAMES) - 1)
    rows: list[Row] = []
    holds = [
        "| record | " + " | ".join(name for name, _ in _PARTS) + " |",
        "| --- |" + " --- |" * len(_PARTS),
    ]
    for record in OPEN_RECORDS:
        # Leakage falls with the frequency in lines, so a long record need not be searched up to the
        # highest band.
        searched = range(
            len(BAND_NAMES) if record.duration_s < 1.0 else BAND_NAMES.index("500") + 1
        )
        cells = [record.name]
        for name, part in _PARTS:
            results = {
                band: open_attenuation(record, band, part) for band in sorted({*searched, *shown})
            }
            rows += [replace(results[band], keys=(*results[band].keys, name)) for band in shown]
            cells.append(
                _from_band([band for band, row in results.items() if not row.within], len(results))
            )
        holds.append(f"| {' | '.join(cells)} |")
    worst_db = min(
        row.computed for row in rows if row.keys[0].endswith("faded") and row.keys[-1] == "outside"
    )
    return Table(
        "Third octaves: tones that do not fit the record",
        "class 1",
        "IEC 61260-1:2014, 5.10, Table 1 and formulas (9), (10)",
        "What do records lose that do not close? Their ends leak into all lines. A "
        "record is cut, or faded by 10 ms at both ends, as the program fades every record that "
        "does not close. Each tone has one of the standard's normalised frequencies and is "
        "midway between two lines of the record. To this end the record is lengthened or "
        "shortened by up to half a period; from 500 periods on the frequency changes instead. "
        "Computed is the level of the record minus its level in the band, at the worst "
        "frequency of each part: *inside* the band, *outside* of it, and at its *edges*. At the"
        " edges the tone is one to two lines off, because a tone that is nearer than a line "
        "counts with the nearest line. B T is the number of lines in the band. The sample rate "
        "is 12 times the mid-band frequency, at least 2.4 kHz and at most 48 kHz.",
        ("record", "band", "B T", "worst f/f_mid", "part"),
        "dB",
        2,
        tuple(rows),
        "Bands in which class 1 holds (records of 10 s searched up to the band of 500 Hz, "
        "and in the bands of the table):\n\n"
        + "\n".join(holds)
        + "\n\n**Inside the bands** class 1 holds for records of every length scanned from "
        f"B T = {min_lines_inside():.1f} on. The bands that `bands.reliable` names have B T of "
        f"{MIN_BT:g} or more.\n\n"
        "**Outside the bands** it holds from the bands above on only. In lower bands a strong "
        "tone, or a steep spectrum several octaves away, shows at the attenuations of the table: "
        f"{worst_db:.0f} dB in the worst faded case, where 70 dB are asked for.\n\n"
        "A record that closes has neither limit.",
    )


def _from_band(failing: list[int], searched: int) -> str:
    if not failing:
        return "all"
    return "none" if len(failing) == searched else f"{BAND_NAMES[max(failing) + 1]} Hz and above"


def effective_bandwidth() -> Table:
    """Measure the level of a flat spectrum in each band, in which lines replace bandwidth."""
    rows = []
    for duration_s in (0.5, 10.0):
        lines_hz = np.arange(round(duration_s * SAMPLE_RATE_HZ / 2.0) + 1) / duration_s
        held_hz = third_octave_mean_square(lines_hz, np.full(len(lines_hz), 1.0 / duration_s))
        for band, name in enumerate(BAND_NAMES):
            if MID_HZ[band] < 130.0 or name in ("1000", "20000"):
                keys = (f"{duration_s:g} s", name, f"{BANDWIDTH_HZ[band] * duration_s:.1f}")
                computed = float(10.0 * np.log10(held_hz[band] / BANDWIDTH_HZ[band]))
                limit = standards.EFFECTIVE_BANDWIDTH_LIMIT_DB
                rows.append(Row(keys, 0.0, computed, -limit, limit))
    return Table(
        "Third octaves: effective bandwidth",
        "class 1",
        "IEC 61260-1:2014, 5.12",
        "Does a band count white noise right? A band holds a whole number of lines, "
        "so of a flat spectrum it takes up to one line more or less than its bandwidth. Records"
        " that close are no exception. Computed is the level of the lines it holds, each 1/T "
        "wide, over that of its bandwidth. The error is less than half the random uncertainty "
        "of noise in such a band (`bands.band_uncertainty_db`).",
        ("record", "band", "B T"),
        "dB",
        2,
        tuple(rows),
    )
