"""Lines of a bearing as its spectra show them: their velocities, and their heights."""

from __future__ import annotations

from collections.abc import Sequence

from acoustics.ring_velocity import VELOCITY_BANDS_HZ, LineReading, NarrowSpectrum
from rolling.bearing import lines
from rolling.bearing.lines import BearingLine
from rolling.bearing.ring_record import AXIAL, DIRECTIONS, NOTHING_UM_S, RADIAL, UM_S
from rolling.bearing_kind.solved_bearing import SolvedBearing
from rolling.numbers.bearing_numbers import (
    EnvelopeBandNumbers,
    EnvelopeLine,
    LineVelocity,
    VelocityLine,
)

LOWEST_HZ = VELOCITY_BANDS_HZ["low"][0]
HIGHEST_PEAK_HZ = VELOCITY_BANDS_HZ["medium"][1]  # beyond it roughness leads, not waves
MAX_PEAKS = 8  # of a spectrum that are listed
LEAST_SHARE = 0.01  # of the largest peak
LEAST_HEIGHT = 5.0  # of a peak over the median of its surroundings
MAX_NEAR = 3  # lines that are named beside a peak from which they are not told apart
NO_LINE = LineReading(rms=0.0, height=0.0)


def velocity_lines(bearing: SolvedBearing) -> tuple[VelocityLine, ...]:
    """Return lines and largest peaks with their velocity and height over surroundings.

    A line has no velocity in a direction in which it does not move the ring, and none is known
    where the record does not separate it from a stronger line.
    """
    named = {line.name: line for line in [*bearing.lines, *_peaks(bearing)]}
    every = sorted(named.values(), key=lambda line: line.frequency_hz)
    frequencies = {
        direction: [line.frequency_hz for line in every if direction in line.directions]
        for direction in DIRECTIONS
    }
    velocities = []
    for line in every:
        read = {
            direction: _velocity_of(bearing, line, direction, frequencies[direction])
            for direction in DIRECTIONS
        }
        velocities.append(
            VelocityLine(
                name=line.name,
                meaning=line.meaning,
                frequency_hz=line.frequency_hz,
                radial=read[RADIAL],
                axial=read[AXIAL],
            )
        )
    return tuple(velocities)


def _velocity_of(
    bearing: SolvedBearing, line: BearingLine, direction: str, beside_hz: Sequence[float]
) -> LineVelocity:
    """Return what the spectrum of a direction shows of a line."""
    reading = NO_LINE
    if direction in line.directions:
        reading = bearing.record.spectra[direction].read_line(line.frequency_hz, beside_hz)
    um_s = None if reading.rms is None else UM_S * reading.rms
    if um_s is not None and um_s < NOTHING_UM_S:  # rounding of a ring at rest
        reading = NO_LINE
    return LineVelocity(um_s=um_s, height=reading.height, resolved_by_s=reading.resolving_s)


def _peaks(bearing: SolvedBearing) -> list[BearingLine]:
    """Return the largest peaks below 1,800 Hz, radial and axial, as the lines that they are."""
    spectra = bearing.record.spectra
    families = lines.family_lines(
        bearing.model,
        wavy=bearing.wavy,
        faulty=bearing.faulty,
        highest_hz=HIGHEST_PEAK_HZ,
        apart_hz=2 * spectra[RADIAL].line_width_hz,
    )
    peaks = dict[str, BearingLine]()
    for direction, spectrum in spectra.items():
        known = [line for line in [*bearing.lines, *families] if direction in line.directions]
        peaks_hz = spectrum.peaks_hz(MAX_PEAKS, LOWEST_HZ, HIGHEST_PEAK_HZ, LEAST_HEIGHT)
        largest = 0.0
        for hz in peaks_hz:
            rms = spectrum.read_line(hz).rms or 0.0
            largest = max(largest, rms)
            if rms >= max(LEAST_SHARE * largest, NOTHING_UM_S / UM_S):
                line = _simplest(known, hz, spectrum, direction)
                peaks.setdefault(line.name, line)
    return list(peaks.values())


def _simplest(
    known: Sequence[BearingLine], hz: float, spectrum: NarrowSpectrum, direction: str
) -> BearingLine:
    """Return the first of known lines that a peak may be, or one that has no other name."""
    for line in known:
        if spectrum.is_at(line.frequency_hz, hz):
            return line
    near = [line.name for line in known if spectrum.hides(line.frequency_hz, hz)]
    meaning = "none of the kinematics"
    if near:
        meaning = f"not told apart from {', '.join(near[:MAX_NEAR])} by this record"
    return BearingLine(f"{hz:.1f} Hz", meaning, hz, directions=(direction,))


def envelope_band_numbers(bearing: SolvedBearing) -> EnvelopeBandNumbers:
    """Return the band of the envelope, and what chose it."""
    band = bearing.envelope_band
    low, high = band.band_hz
    return EnvelopeBandNumbers(
        low_hz=low, high_hz=high, chosen_by=band.chosen_by, kurtosis=band.kurtosis
    )


def envelope_lines(bearing: SolvedBearing) -> tuple[EnvelopeLine, ...]:
    """Return the lines of the envelope with their share of its mean, and their height.

    Both are unknown of a line that the record does not separate from a stronger one.
    """
    readings = lines.envelope_readings(bearing.envelope, bearing.kinematics)
    return tuple(
        EnvelopeLine(
            name=line.name,
            meaning=line.meaning,
            frequency_hz=line.frequency_hz,
            share=reading.rms,
            height=reading.height,
            resolved_by_s=reading.resolving_s,
        )
        for line, reading in readings
    )
