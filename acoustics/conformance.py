"""What this package computes, measured against IEC 61672-1, IEC 61260-1 and its own requirements: a page of tables.

`python -m acoustics.conformance` prints it; every number on it is computed then. Depends on the numeric modules here.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from acoustics import standards
from acoustics.bands import BAND_NAMES, BANDWIDTH_HZ, EDGES_HZ, LEAST_BT, MID_HZ, third_octave_mean_square
from acoustics.level import P_REF_PA, level_db, sound_levels
from acoustics.resampling import band_limit, fade, interpolate_closed, resample_closed, undo_step_mean
from acoustics.spectrum import line_spectrum
from acoustics.wav import SAMPLE_RATE_HZ
from acoustics.weighting import a_weighting_db

COMMAND = "python -m acoustics.conformance > acoustics/CONFORMANCE.md"

# What lies further down is rounding, as in acoustics.level; its digits differ from machine to machine.
_ROUNDING_DB = 200.0

# Requirements of this package where no standard asks: resampling and interpolation, levels, frequencies (the fifth
# digit).
REJECTION_DB = 80.0
RIPPLE_DB = 0.1
LEVEL_DB = 0.01
FREQUENCY_PPM = 10.0

# A record that does not close is faded over this time at both ends before it gets here.
_FADE_S = 0.01


@dataclass(frozen=True)
class Row:
    """One comparison: what was measured, the design goal, what this package computes, and the limits.

    The limits are on computed - expected. Where the design goal is infinite (an attenuation), ``lower`` is the least
    value required and ``upper`` is infinite.
    """

    what: tuple[str, ...]
    expected: float
    computed: float
    lower: float
    upper: float

    @property
    def difference(self) -> float:
        return math.nan if math.isinf(self.expected) else self.computed - self.expected

    @property
    def share(self) -> float:
        """Share of the tolerance used, %: the difference over the limit on its side, or required over computed.

        Above 100 the limit is exceeded.
        """
        if math.isinf(self.expected):
            return 100.0 * self.lower / self.computed if self.computed > 0.0 else math.inf
        limit = self.upper if self.difference > 0.0 else self.lower
        return 100.0 * self.difference / limit

    @property
    def within(self) -> bool:
        return self.share <= 100.0


@dataclass(frozen=True)
class Table:
    """Rows of one kind.

    ``requirement`` names whose limits they are, ``source`` the clause, ``text`` how it is measured, ``heads`` the
    columns of `Row.what`, ``after`` what follows from the rows.
    """

    title: str
    requirement: str
    source: str
    text: str
    heads: tuple[str, ...]
    unit: str
    decimals: int
    rows: tuple[Row, ...]
    after: str = ""

    @property
    def worst(self) -> Row:
        return max(self.rows, key=lambda row: row.share)

    @property
    def outside(self) -> tuple[Row, ...]:
        return tuple(row for row in self.rows if not row.within)


def tables() -> tuple[Table, ...]:
    """All tables of the page, computed now."""
    return (
        a_weighting(),
        *third_octave_frequencies(),
        closed_third_octaves(),
        open_third_octaves(),
        effective_bandwidth(),
        resampled_levels(),
        step_mean_correction(),
        alias_rejection(),
        interpolation(),
        levels(),
    )


def tone(frequency_hz: float, samples: int, rate_hz: float = SAMPLE_RATE_HZ, phase: float = 0.4) -> np.ndarray:
    """A sine of 1 Pa rms (samples,)."""
    return math.sqrt(2.0) * np.sin(2.0 * np.pi * frequency_hz / rate_hz * np.arange(samples) + phase)


def whole_periods(frequency_hz: float, rate_hz: float = SAMPLE_RATE_HZ, longest_s: float = 2.0) -> int:
    """Samples of the record, up to ``longest_s``, that comes nearest to a whole number of periods."""
    samples = np.rint(np.arange(1, int(longest_s * frequency_hz) + 1) * rate_hz / frequency_hz)
    periods = samples * frequency_hz / rate_hz
    return int(samples[np.argmin(np.abs(periods - np.rint(periods)))])


def a_weighting() -> Table:
    """A sine through `sound_levels` at each frequency of the standard's table."""
    rows = []
    for row in standards.A_WEIGHTING:
        frequency_hz = 10.0 ** (row.n / 10.0)
        measured = sound_levels(tone(frequency_hz, whole_periods(frequency_hz)), SAMPLE_RATE_HZ)
        what = (f"{row.nominal_hz:g}", f"{frequency_hz:.2f}", _number(float(a_weighting_db(frequency_hz)), 2))
        rows.append(Row(what, row.a_db, _known(measured.laeq_db) - _known(measured.level_db), row.lower_db, row.upper_db))
    return Table(
        "A-weighting",
        "class 1",
        "IEC 61672-1:2013, 5.5 and Table 3",
        "Sines of 1 Pa rms at the exact frequencies 10^(n/10) Hz, 48 kHz, in records of up to 2 s nearest to a whole "
        "number of periods; computed: LAeq minus LZeq of `level.sound_levels`. The formula is that of annex E as in "
        "`weighting.a_weighting_db`; the table rounds it to 0.1 dB, which is all the difference there is.",
        ("nominal Hz", "exact Hz", "formula dB"),
        "dB",
        2,
        tuple(rows),
    )


def third_octave_frequencies() -> tuple[Table, Table]:
    """Mid-band and band-edge frequencies and names."""
    offsets = range(-17, 14)
    mids, edges = [], []
    for x, name, mid_hz, low_hz, high_hz in zip(
        offsets, BAND_NAMES, MID_HZ, EDGES_HZ[:-1], EDGES_HZ[1:], strict=True
    ):
        nominal = f"{standards.third_octave_nominal_hz(x):g}"
        mids.append(_frequency_row((nominal, name), standards.third_octave_mid_hz(x), float(mid_hz)))
        edges.append(_frequency_row((name, "lower"), standards.third_octave_edge_hz(x, -1), float(low_hz)))
    edges.append(_frequency_row((name, "upper"), standards.third_octave_edge_hz(x, 1), float(high_hz)))
    own = f"{FREQUENCY_PPM:g} ppm"
    return (
        Table(
            "Third octaves: mid-band frequencies and names",
            own,
            "IEC 61260-1:2014, 5.2 to 5.4 and annex E",
            f"Expected: 1000 G^(x/3) Hz, G = 10^(3/10), x = -17 to 13, and the names of series R10; computed: "
            f"`bands.MID_HZ` and `bands.BAND_NAMES`. The standard gives no tolerance; {own} is the fifth digit.",
            ("nominal Hz", "band"),
            "Hz",
            3,
            tuple(mids),
        ),
        Table(
            "Third octaves: band edges",
            own,
            "IEC 61260-1:2014, 5.6",
            "Expected: mid-band frequency times G^(-1/6) and G^(1/6); computed: `bands.EDGES_HZ`. The upper edge of a "
            "band is the lower one of the next, so no frequency is counted twice or left out.",
            ("band", "edge"),
            "Hz",
            3,
            tuple(edges),
        ),
    )


def _frequency_row(what: tuple[str, ...], expected: float, computed: float) -> Row:
    limit = FREQUENCY_PPM * 1e-6 * expected
    return Row(what, expected, computed, -limit, limit)


@dataclass(frozen=True)
class MaskPoint:
    """A frequency at which the standard limits the attenuation of a third octave.

    ``side`` is -1 below the mid-band frequency, 1 above; ``ratio`` is f/f_mid.
    """

    side: int
    ratio: float
    least_db: float
    greatest_db: float

    @property
    def inside(self) -> bool:
        return math.isfinite(self.greatest_db)

    @property
    def at_edge(self) -> bool:
        return math.isclose(self.ratio**self.side, standards.third_octave_frequency_ratio(0.5), rel_tol=1e-6)


def mask_points() -> tuple[MaskPoint, ...]:
    """The standard's frequencies and limits for third octaves, from the lowest to the highest."""
    points = []
    for exponent, least_db, greatest_db in standards.OCTAVE_ATTENUATION:
        ratio = standards.third_octave_frequency_ratio(exponent)
        for side in (-1, 1) if exponent > 0.0 else (1,):
            points.append(MaskPoint(side, ratio**side, least_db, greatest_db))
    return tuple(sorted(points, key=lambda point: (point.ratio, point.inside == (point.side < 0))))


def attenuation_db(
    frequency_hz: float, band: int, samples: int, rate_hz: float, phase: float = 0.4, fade_s: float = 0.0
) -> float:
    """Level of a tone's record minus its level in a band, dB; infinite where the band holds no more than rounding."""
    record = fade(tone(frequency_hz, samples, rate_hz, phase), round(fade_s * rate_hz))
    lines_hz, mean_square = line_spectrum(record, rate_hz)
    whole, in_band = mean_square.sum(), third_octave_mean_square(lines_hz, mean_square)[band]
    if in_band <= whole * 10.0 ** (-_ROUNDING_DB / 10.0):
        return math.inf
    return float(10.0 * np.log10(whole / in_band))


def closed_third_octaves() -> Table:
    """Attenuation on records that hold a whole number of periods: what records of closed tracks are."""
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
                what = (BAND_NAMES[band], _ratio(point), f"{frequency_hz:.1f}")
                rows.append(_attenuation_row(what, point, attenuation_db(frequency_hz, band, samples, SAMPLE_RATE_HZ)))
    return Table(
        "Third octaves: tones on a line",
        "class 1",
        "IEC 61260-1:2014, 5.10, Table 1 and formulas (9), (10)",
        "Tones at the standard's normalised frequencies, each moved to the nearest of the 0.1 Hz lines of a 10 s record "
        "at 48 kHz, so that the record holds a whole number of periods. The lines of a record that closes on itself are "
        "the signal itself: all records at constant speed on a closed track are of this kind. Computed: level of the "
        "tone minus its level in the band. The limits are on the attenuation; frequencies above 24 kHz do not exist.",
        ("band", "f/f_mid", "f Hz"),
        "dB",
        2,
        tuple(rows),
    )


def _ratio(point: MaskPoint) -> str:
    mark = "" if not point.at_edge else " in" if point.inside else " out"
    return f"{point.ratio:.4f}{mark}"


def _attenuation_row(what: tuple[str, ...], point: MaskPoint, computed: float) -> Row:
    return Row(what, 0.0 if point.inside else math.inf, computed, point.least_db, point.greatest_db)


@dataclass(frozen=True)
class OpenRecord:
    """A record whose tone does not fit."""

    duration_s: float
    fade_s: float

    @property
    def name(self) -> str:
        return f"{self.duration_s:g} s, {'faded' if self.fade_s else 'cut'}"


OPEN_RECORDS = (OpenRecord(0.5, 0.0), OpenRecord(0.5, _FADE_S), OpenRecord(10.0, 0.0), OpenRecord(10.0, _FADE_S))

_PARTS: tuple[tuple[str, Callable[[MaskPoint], bool]], ...] = (
    ("inside", lambda point: point.inside and not point.at_edge),
    ("edges", lambda point: point.at_edge),
    ("outside", lambda point: not point.inside and not point.at_edge),
)


def open_attenuation(record: OpenRecord, band: int, part: Callable[[MaskPoint], bool]) -> Row:
    """The worst attenuation of a band at the points of one part, for tones half a line off.

    The tones lie midway between two lines, nearest to the standard's frequency; those at the edges further off, by one
    to two lines. Two phases, a quarter period apart: the tone's own mirror at negative frequency adds or subtracts.
    """
    # No more samples than the standard's highest frequency, 5.39 f_mid, takes; a fade of 10 ms takes some, too.
    rate_hz = float(np.clip(12.0 * math.ceil(MID_HZ[band]), 6000.0, SAMPLE_RATE_HZ))
    samples = round(record.duration_s * rate_hz)
    rows = []
    for point in filter(part, mask_points()):
        line = point.ratio * MID_HZ[band] * record.duration_s
        if point.at_edge:
            upwards = point.inside == (point.side < 0)
            half_line = math.ceil(line + 0.5) + 0.5 if upwards else math.floor(line - 0.5) - 0.5
        else:
            half_line = math.floor(line) + 0.5
        frequency_hz = half_line / record.duration_s
        if not 0.0 < frequency_hz < rate_hz / 2.0:
            continue
        what = (record.name, BAND_NAMES[band], f"{BANDWIDTH_HZ[band] * record.duration_s:.1f}", _ratio(point))
        for phase in (0.0, 0.5 * math.pi):
            computed = attenuation_db(frequency_hz, band, samples, rate_hz, phase, record.fade_s)
            rows.append(_attenuation_row(what, point, computed))
    return max(rows, key=lambda row: row.share)


def open_third_octaves() -> Table:
    """Attenuation on records that do not close: leakage of their ends, cut or faded."""
    shown = (0, BAND_NAMES.index("100"), BAND_NAMES.index("1000"), len(BAND_NAMES) - 1)
    rows, holds = [], []
    for record in OPEN_RECORDS:
        # Leakage falls with the frequency in lines, so a long record need not be searched up to the highest band.
        searched = range(len(BAND_NAMES) if record.duration_s < 1.0 else BAND_NAMES.index("500") + 1)
        for name, part in _PARTS:
            results = {band: open_attenuation(record, band, part) for band in sorted({*searched, *shown})}
            rows += [replace(results[band], what=(*results[band].what, name)) for band in shown]
            failing = [band for band, row in results.items() if not row.within]
            holds.append(f"- {record.name}, {name}: {_from_band(failing, record.duration_s)}")
    return Table(
        "Third octaves: tones that do not fit the record",
        "class 1",
        "IEC 61260-1:2014, 5.10, Table 1 and formulas (9), (10)",
        "Tones midway between two lines, in records that are cut or faded by 10 ms at both ends (the program fades "
        "every record that does not close): their ends leak into all lines. Computed: level of the record minus its "
        "level in the band, the worst of the standard's frequencies inside the band, at its edges (one to two lines "
        "off; nearer to an edge than a line, a tone counts with the nearest line) and outside. B T is the number of "
        "lines in the band. Sampled at 12 times the mid-band frequency, at least 6 kHz, at most 48 kHz.",
        ("record", "band", "B T", "worst f/f_mid", "part"),
        "dB",
        2,
        tuple(rows),
        "Class 1 holds\n\n"
        + "\n".join(holds)
        + "\n\n(10 s searched up to the 500 Hz band, and the bands shown). So on records that do not close:\n\n"
        f"- Inside the bands class 1 holds wherever B T is at least {LEAST_BT:g}, that is in the bands the program calls "
        "reliable (`bands.reliable`).\n"
        "- Far outside the low bands it does not hold, however the record ends: a strong tone or steep spectrum leaks "
        "into bands several octaves away, at the attenuations above instead of the 70 dB asked for.\n",
    )


def _from_band(failing: Sequence[int], duration_s: float) -> str:
    first = max(failing) + 1 if failing else 0
    if first == len(BAND_NAMES):
        return "in not all bands up to the highest"
    return f"from the {BAND_NAMES[first]} Hz band on (B T = {BANDWIDTH_HZ[first] * duration_s:.1f})"


def effective_bandwidth() -> Table:
    """Level of a flat spectrum in each band: whole lines stand for the bandwidth."""
    rows = []
    for duration_s in (0.5, 10.0):
        lines_hz = np.arange(round(duration_s * SAMPLE_RATE_HZ / 2.0) + 1) / duration_s
        held_hz = third_octave_mean_square(lines_hz, np.full(len(lines_hz), 1.0 / duration_s))
        for band, name in enumerate(BAND_NAMES):
            if MID_HZ[band] < 130.0 or name in ("1000", "20000"):
                what = (f"{duration_s:g} s", name, f"{BANDWIDTH_HZ[band] * duration_s:.1f}")
                computed = float(10.0 * np.log10(held_hz[band] / BANDWIDTH_HZ[band]))
                limit = standards.EFFECTIVE_BANDWIDTH_LIMIT_DB
                rows.append(Row(what, 0.0, computed, -limit, limit))
    return Table(
        "Third octaves: effective bandwidth",
        "class 1",
        "IEC 61260-1:2014, 5.12",
        "A band holds a whole number of lines, a flat spectrum therefore up to one line more or less than its "
        "bandwidth. Computed: level of the lines it holds over that of its bandwidth, for lines at multiples of 1/T. "
        "Holds for noise on closed records, too; no more than the random uncertainty 4.34/sqrt(B T) dB of such a band "
        "(`bands.band_uncertainty_db`), which is not in the limits.",
        ("record", "band", "B T"),
        "dB",
        2,
        tuple(rows),
    )


STEP_RATE_HZ = 50_000  # steps of 2 um at 0.1 m/s


def step_means(frequency_hz: float, samples: int, rate_hz: float) -> np.ndarray:
    """Means over consecutive steps of a sine of 1 Pa rms, in closed form (samples,)."""
    omega = 2.0 * np.pi * frequency_hz / rate_hz
    return -math.sqrt(2.0) / omega * np.diff(np.cos(omega * np.arange(samples + 1)))


def resampled_levels() -> Table:
    """Sines from step means to 48 kHz, through every stage of the program."""
    rows = []
    for rate_hz, frequencies_hz in (
        (STEP_RATE_HZ, (20, 63, 200, 630, 2000, 6300, 12500, 16000, 20000)),
        (40_960, (20, 1000, 20000)),
        (52_361, (20, 1000, 20000)),
        (100_000, (20, 1000, 20000)),
        (250_000, (20, 1000, 20000)),
    ):
        for frequency_hz in frequencies_hz:
            at_steps = undo_step_mean(step_means(frequency_hz, rate_hz, rate_hz))
            record = band_limit(resample_closed(at_steps, SAMPLE_RATE_HZ), SAMPLE_RATE_HZ)
            measured = _known(sound_levels(record, SAMPLE_RATE_HZ).level_db) - _ONE_PA_DB
            rows.append(Row((f"{rate_hz}", f"{frequency_hz}"), 0.0, measured, -RIPPLE_DB, RIPPLE_DB))
    return Table(
        "Resampling: level of sines",
        f"{RIPPLE_DB:g} dB",
        "own requirement: ripple below 0.1 dB up to 20 kHz",
        "Step means of a sine of 1 Pa rms over 1 s in closed form, through `resampling.undo_step_mean`, "
        "`resample_closed` to 48 kHz and `band_limit`; computed: level minus 93.98 dB. 50 kHz is 2 um at 0.1 m/s.",
        ("steps per s", "f Hz"),
        "dB",
        3,
        tuple(rows),
    )


def step_mean_correction() -> Table:
    """What `undo_step_mean` gives back of the sinc of averaging."""
    rows = []
    for frequency_hz in (1000, 5000, 10000, 16000, 20000, 22000, 24000):
        means = step_means(frequency_hz, STEP_RATE_HZ, STEP_RATE_HZ)
        expected = float(-20.0 * np.log10(np.sinc(frequency_hz / STEP_RATE_HZ)))
        computed = float(10.0 * np.log10(np.mean(undo_step_mean(means) ** 2) / np.mean(means**2)))
        rows.append(Row((f"{frequency_hz}",), expected, computed, -RIPPLE_DB, RIPPLE_DB))
    return Table(
        "Resampling: correction of the step means",
        f"{RIPPLE_DB:g} dB",
        "own requirement: ripple below 0.1 dB up to 20 kHz",
        "Averaging over a step takes sinc(f/rate); expected: -20 lg sinc(f / 50 kHz); computed: gain of "
        "`resampling.undo_step_mean` on the step means of a sine.",
        ("f Hz",),
        "dB",
        3,
        tuple(rows),
    )


def alias_rejection() -> Table:
    """Tones above 24 kHz: nothing of them may be left at 48 kHz."""
    rows = []
    for rate_hz, frequencies_hz in (
        (STEP_RATE_HZ, (24_001, 24_500, 24_999)),
        (100_000, (24_001, 25_000, 30_000, 40_000, 49_999)),
        (250_000, (24_001, 48_000, 72_000, 124_999)),
    ):
        for frequency_hz in frequencies_hz:
            # The phase counted in whole steps of the record, so that the tone is pure to rounding.
            signal = np.sin(2.0 * np.pi * (np.arange(rate_hz) * frequency_hz % rate_hz) / rate_hz + 0.4)
            left = np.mean(resample_closed(signal, SAMPLE_RATE_HZ) ** 2) / np.mean(signal**2)
            rows.append(_suppression_row((f"{rate_hz}", f"{frequency_hz}"), left, REJECTION_DB))
    return Table(
        "Resampling: rejection of aliases",
        f"{REJECTION_DB:g} dB",
        "own requirement: rejection above 80 dB",
        "Tones above 24 kHz that would fold back into the record; computed: level before minus level after "
        "`resampling.resample_closed` to 48 kHz.",
        ("steps per s", "f Hz"),
        "dB",
        1,
        tuple(rows),
    )


def interpolation() -> Table:
    """Varying speed: values between the samples of a closed record."""
    samples, rows = 5000, []
    index = np.linspace(0.0, samples, 7 * samples, endpoint=False) + 0.123
    for share in (0.1, 0.25, 0.5, 0.8, 0.9):
        omega = 2.0 * np.pi * round(share * samples / 2.0) / samples
        exact = np.sin(omega * index + 0.3)
        computed = interpolate_closed(np.sin(omega * np.arange(samples) + 0.3), index)
        what = (f"f = {share:g} of Nyquist", "everywhere")
        rows.append(_suppression_row(what, np.mean((computed - exact) ** 2) / np.mean(exact**2), REJECTION_DB))
    for top_hz in (1000, 5000, 10000, 20000):
        rows.append(_suppression_row((f"sweep from {top_hz / 2:g} to {top_hz} Hz", "inner 90 %"), _sweep_error(top_hz), REJECTION_DB))
    return Table(
        "Resampling: varying speed",
        f"{REJECTION_DB:g} dB",
        "own requirement: error below -80 dB",
        "Sines at their Nyquist share, read by `resampling.interpolate_closed` at positions between the samples; and "
        "sines along a track of 2 um steps passed at 0.1 to 0.2 m/s, from step means to 48 kHz the way the program "
        "goes, faded by 10 ms. Computed: mean square of the signal over that of its error.",
        ("signal", "compared"),
        "dB",
        1,
        tuple(rows),
    )


def _sweep_error(top_hz: float) -> float:
    """Mean square error over mean square of a sine along a track that is passed faster and faster."""
    step_m, slow, fast, duration_s = 2e-6, 0.1, 0.2, 0.5
    samples = round(duration_s * SAMPLE_RATE_HZ)
    oversampling = math.ceil(fast / step_m / SAMPLE_RATE_HZ)
    steps = round(0.5 * (slow + fast) * duration_s / step_m)
    waves = round(steps * step_m * top_hz / fast)

    def steps_passed(time_s: np.ndarray) -> np.ndarray:
        return (slow * time_s + 0.5 * (fast - slow) / duration_s * time_s**2) / step_m

    at_steps = undo_step_mean(step_means(waves, steps, steps))
    fine_s = np.arange(samples * oversampling) / (SAMPLE_RATE_HZ * oversampling)
    in_time = fade(interpolate_closed(at_steps, steps_passed(fine_s)), round(_FADE_S * SAMPLE_RATE_HZ * oversampling))
    inner = slice(samples // 20, -samples // 20)
    computed = resample_closed(in_time, samples)[inner]
    time_s = np.arange(samples)[inner] / SAMPLE_RATE_HZ
    exact = math.sqrt(2.0) * np.sin(2.0 * np.pi * waves / steps * steps_passed(time_s))
    return float(np.mean((computed - exact) ** 2) / np.mean(exact**2))


def _suppression_row(what: tuple[str, ...], left: float, least_db: float) -> Row:
    """``left`` is what remains of a mean square that is to vanish."""
    computed = math.inf if left <= 10.0 ** (-_ROUNDING_DB / 10.0) else float(-10.0 * np.log10(left))
    return Row(what, math.inf, computed, least_db, math.inf)


_ONE_PA_DB = 20.0 * math.log10(1.0 / P_REF_PA)


def levels() -> Table:
    """Levels that follow from an amplitude, and sums that must close."""
    calibrator = sound_levels(tone(1000.0, SAMPLE_RATE_HZ), SAMPLE_RATE_HZ)
    threshold = sound_levels(P_REF_PA * tone(1000.0, SAMPLE_RATE_HZ), SAMPLE_RATE_HZ)
    noise = band_limit(np.random.default_rng(1).standard_normal(SAMPLE_RATE_HZ // 2), SAMPLE_RATE_HZ)
    of_noise = sound_levels(noise, SAMPLE_RATE_HZ)
    rows = [
        ("sine of 1 Pa rms, 1 kHz: LZeq", _ONE_PA_DB, calibrator.level_db),
        ("sine of 1 Pa rms, 1 kHz: LAeq", _ONE_PA_DB, calibrator.laeq_db),
        ("sine of 1 Pa rms, 1 kHz: third octave 1000", _ONE_PA_DB, calibrator.third_octave_db["1000"]),
        ("sine of 20 uPa rms, 1 kHz: LAeq", 0.0, threshold.laeq_db),
        ("noise, 0.5 s: LZeq against the mean square in time", level_db(float(np.mean(noise**2))), of_noise.level_db),
        ("noise, 0.5 s: third octaves added up against LZeq", of_noise.level_db, _sum_db(of_noise.third_octave_db)),
        ("noise, 0.5 s: A-weighted third octaves against LAeq", of_noise.laeq_db, _sum_db(of_noise.third_octave_a_db)),
    ]
    return Table(
        "Levels",
        f"{LEVEL_DB:g} dB",
        "own requirement: levels within 0.01 dB; Parseval's theorem",
        "`level.sound_levels`; the noise is Gaussian, from 20 Hz to 20 kHz, with a fixed seed.",
        ("what",),
        "dB",
        3,
        tuple(Row((what,), _known(expected), _known(computed), -LEVEL_DB, LEVEL_DB) for what, expected, computed in rows),
    )


def _sum_db(band_levels: dict[str, float | None]) -> float:
    return 10.0 * math.log10(sum(10.0 ** (band / 10.0) for band in band_levels.values() if band is not None))


def _known(level: float | None) -> float:
    if level is None:
        raise ValueError("a level that must exist is None")
    return level


def page(measured: Sequence[Table]) -> str:
    """The page in Markdown: what it is, a summary, and the tables."""
    summary = [
        (f"{number}. {table.title}", table.source, len(table.rows), f"{_number(table.worst.share, 1)}", verdict(table))
        for number, table in enumerate(measured, start=1)
    ]
    parts = [
        "# Conformance of the package `acoustics`",
        "Every number on this page is computed by\n\n"
        f"```sh\n{COMMAND}\n```\n\n"
        "and a test fails when the page differs from what that prints. *Limits* are on the difference between computed "
        "and expected. *Share* is the part of the tolerance that is used: the difference over the limit on its side, "
        "and for attenuations, which are ∞ ideally, the attenuation required over the one computed; above 100 % the "
        "limit is exceeded, in **bold**. `> 200` is rounding. Class 1 limits are the acceptance limits of the 2013 and "
        "2014 editions, which leave out the uncertainty of a testing laboratory. This is no pattern evaluation: "
        "there is no microphone, no display and no environment, only arithmetic.",
        "## Summary",
        _markdown(("section", "source", "rows", "worst share %", "verdict"), summary, "llrrl"),
    ]
    for number, table in enumerate(measured, start=1):
        cells = [(*row.what, *_cells(row, table.decimals)) for row in table.rows]
        heads = (*table.heads, *(f"{head} {table.unit}" for head in _HEADS), "share %")
        parts += [
            f"## {number}. {table.title}",
            f"{table.source}. {table.text}",
            _markdown(heads, cells, "l" * len(table.heads) + "r" * (len(_HEADS) + 1)),
            f"{len(table.rows)} rows, worst share {_number(table.worst.share, 1)} % "
            f"({', '.join(table.worst.what)}): {verdict(table)}.",
        ]
        if table.after:
            parts.append(table.after.rstrip())
    return "\n\n".join(parts) + "\n"


_HEADS = ("expected", "computed", "difference", "lower limit", "upper limit")


def verdict(table: Table) -> str:
    """All within, or how many rows are not."""
    if not table.outside:
        return f"all within {table.requirement}"
    return f"**{len(table.outside)} of {len(table.rows)} outside {table.requirement}**"


def _cells(row: Row, decimals: int) -> tuple[str, ...]:
    share = _number(row.share, 1)
    unexpected = math.isinf(row.expected)
    computed = f"> {_ROUNDING_DB:g}" if math.isinf(row.computed) else _number(row.computed, decimals)
    return (
        _number(row.expected, decimals),
        computed,
        "" if unexpected else _number(row.difference, decimals, signed=True),
        _number(row.lower, 1 if unexpected else decimals, signed=not unexpected),
        _number(row.upper, decimals, signed=not unexpected),
        share if row.within else f"**{share}**",
    )


def _number(value: float, decimals: int, signed: bool = False) -> str:
    """The number rounded, without the sign of a zero, so that rounding noise does not show."""
    if math.isinf(value):
        return "∞" if value > 0.0 else "-∞"
    rounded = round(value, decimals) + 0.0  # turns -0.0 into 0.0
    return f"{rounded:{'+' if signed and rounded else ''}.{decimals}f}"


def _markdown(heads: Sequence[str], rows: Iterable[Sequence[object]], align: str) -> str:
    """A Markdown table with padded columns; ``align`` holds l or r for each."""
    cells = [list(map(str, heads)), *(list(map(str, row)) for row in rows)]
    widths = [max(3, *(len(cell) for cell in column)) for column in zip(*cells, strict=True)]

    def line(row: Sequence[str]) -> str:
        padded = (
            cell.rjust(width) if side == "r" else cell.ljust(width)
            for cell, width, side in zip(row, widths, align, strict=True)
        )
        return f"| {' | '.join(padded)} |"

    rule = ("-" * (width - 1) + ":" if side == "r" else "-" * width for width, side in zip(widths, align, strict=True))
    return "\n".join([line(cells[0]), f"| {' | '.join(rule)} |", *map(line, cells[1:])])


def main() -> None:
    sys.stdout.reconfigure(encoding="utf-8")  # type: ignore[union-attr]
    sys.stdout.write(page(tables()))


if __name__ == "__main__":
    main()
