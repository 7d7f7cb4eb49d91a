"""A recording of the real thing beside a run: third octaves, LAeq, modulation, and a page of them.

Levels are in dB re 20 uPa, their uncertainties are standard uncertainties.
"""

from __future__ import annotations

import io
import math
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import soundfile
from markupsafe import Markup
from matplotlib.axes import Axes
from numpy.typing import NDArray

from acoustics import level, plots, resampling, spectrum, uncertainty
from acoustics.arrays import Array
from acoustics.bands import (
    BAND_NAMES,
    EDGES_HZ,
    MID_HZ,
    NOMINAL_HZ,
    band_uncertainty_db,
    third_octave_mean_square,
)
from acoustics.modulation import envelope_spectrum
from acoustics.radiation import P_REF_PA
from acoustics.texts import printable
from acoustics.wav import PEAK
from acoustics.wav import SAMPLE_RATE_HZ as RATE
from rolling import __version__
from rolling.figures.picture import finish, picture
from rolling.figures.settings import left_out_if_it_fails
from rolling.report import maps, records, text
from rolling.report.templates import environment
from rolling.results import listening
from rolling.results.run_result import Run
from rolling.scene.height_files import read_regular
from rolling.terminal.files import FolderError

MIN_S = 0.5  # shortest recording
MAX_S = 120.0
MIN_RATE_HZ = 16_000
MAX_RATE_HZ = 192_000
MAX_BYTES = 200_000_000
FAINTEST = 1e-9  # of full scale; less is silence
LARGEST = 1e6  # of full scale; more is no sound
FULL_SCALE = 0.99  # at which extreme samples may be clipped,
FLAT = 3  # if so many of them in a row are equal
FADE_S = 0.02
HEARD_S = 20.0  # of each sound on the page
STEADY_DB = 0.3  # largest uncertainty of the level of a tone
CLEAR_DB = 3.0  # least level of a recording above its background
MAX_DB = 10.0  # least uncertainty of a band that tells nothing
MODULATION_HZ = 2.0 ** np.arange(8)  # mid frequencies of octaves of modulation
_HANN = 1.5  # sum of the squared lines of a tone in a Hann window
_DB = 10.0 / math.log(10.0)


class Recording(NamedTuple):
    """Samples at 48 kHz, recorded [full scale] or computed [Pa], closed or faded at both ends.

    `highest` [Hz] is the highest frequency that they resolve, `seconds` [s] the length of a lap.
    The parts of a drop differ by nature.
    """

    name: str
    samples: Array
    highest: float
    seconds: float
    is_clipped: bool = False
    is_drop: bool = False

    @property
    def scatter_db(self) -> float:
        """Standard uncertainty of LAeq [dB] that the thirds of the record show; 0 for a drop."""
        if self.is_drop:
            return 0.0
        return uncertainty.record_scatter_db(self.samples, RATE) or 0.0


class Bands(NamedTuple):
    """Levels of third octaves and their standard uncertainty [dB], (31,); NaN is unknown."""

    level_db: Array
    a_weighted_db: Array
    uncertainty_db: Array

    def only(self, known: NDArray[np.bool_]) -> Bands:
        """Return the bands of a mask, all others NaN."""
        return Bands(
            level_db=np.where(known, self.level_db, np.nan),
            a_weighted_db=np.where(known, self.a_weighted_db, np.nan),
            uncertainty_db=np.where(known, self.uncertainty_db, np.nan),
        )


class RecordingComparison(NamedTuple):
    """Table of levels and differences, sentences on them, and both records by their names.

    Differences are the run less the recording.
    """

    table: pd.DataFrame
    notes: list[str]
    records: dict[str, Recording]


# ---- records


def read(path: Path) -> Recording:
    """Read the first channel of a sound file, or raise FolderError if it is none."""
    try:
        with soundfile.SoundFile(io.BytesIO(read_regular(path, MAX_BYTES))) as file:
            rate = file.samplerate
            seconds = file.frames / rate
            if not (MIN_S <= seconds <= MAX_S and MIN_RATE_HZ <= rate <= MAX_RATE_HZ):
                allowed = f"{MIN_S:g} to {MAX_S:g} s at {MIN_RATE_HZ} to {MAX_RATE_HZ} Hz"
                raise FolderError(f"{path}: got {seconds:.3g} s at {rate} Hz, allowed: {allowed}")
            channel = file.read(dtype="float64", always_2d=True)[:, 0]
    except (OSError, RuntimeError) as error:
        reason = getattr(error, "error_string", getattr(error, "strerror", error))
        raise FolderError(
            f"{path}: no sound that can be read ({reason}), allowed: WAV, FLAC, OGG, MP3, AIFF"
        ) from error
    if not FAINTEST < np.ptp(channel) < LARGEST:
        raise FolderError(f"{path}: its first channel is silent, or holds no finite numbers")
    window = resampling.fade(np.ones(len(channel)), round(FADE_S * rate))
    faded = window * (channel - channel.mean()) / math.sqrt(np.mean(np.square(window)))
    return Recording(
        name=printable(path.name),
        samples=resampling.resample_closed(faded, round(len(faded) * RATE / rate)),
        highest=rate / 2.0,
        seconds=seconds,
        is_clipped=_is_clipped(channel),
    )


def _is_clipped(channel: Array) -> bool:
    """Tell whether samples stay at full scale for several in a row."""
    if np.abs(channel).max() < FULL_SCALE:
        return False
    is_extreme = np.isin(channel, (channel.min(), channel.max()))
    return bool(np.convolve(is_extreme, np.ones(FLAT), "valid").max() == FLAT)


def of_run(run: Run) -> Recording:
    """Return the long record of a run if its scene asks for one, otherwise its signal."""
    is_drop = run.scene.rolling.drop_mm is not None
    long = listening.long_record_of(run)
    if long is not None:
        return Recording(
            name="long record",
            samples=long.pressure,
            highest=run.sound.highest,
            seconds=len(long.pressure) / RATE,
            is_drop=is_drop,
        )
    return Recording(
        name="signal",
        samples=run.sound.pressure,
        highest=run.sound.highest,
        seconds=run.sound.duration / run.laps,
        is_drop=is_drop,
    )


def pascals(calibration: str) -> float:
    """Return the pressure [Pa] of full scale from a tone FILE=LEVEL, or from a number."""
    path, sign, number = calibration.rpartition("=")
    try:
        value = float(number)
    except ValueError:
        value = math.nan
    if path and 0 <= value <= 200:
        return P_REF_PA * 10 ** (value / 20) / _tone_rms(read(Path(path)))
    if not sign and 1 / LARGEST <= value <= LARGEST:
        return value
    allowed = "TONE.wav=DB, 0 to 200 dB re 20 uPa, or the pressure of full scale, 1e-6 to 1e6 Pa"
    raise FolderError(f"--calibration: got {calibration}, allowed: {allowed}")


def _tone_rms(tone: Recording) -> float:
    """Return the rms of a steady tone without the noise beyond half an octave from it."""
    frequency, square = spectrum.line_spectrum(tone.samples, RATE)
    octave = frequency[np.argmax(square)] * np.array([0.5, 2]) ** 0.5
    first, last = np.searchsorted(frequency, octave)
    power = float(square[first:last].sum())
    if tone.is_clipped or power < 0.5 * square.sum() or tone.scatter_db > STEADY_DB:
        raise FolderError(f"{tone.name}: no steady tone, or it is clipped or lost in noise")
    return math.sqrt(power)


# ---- levels


def compare(
    run: Run, path: Path, calibration: str | None = None, background: Path | None = None
) -> RecordingComparison:
    """Compare a run with a recording; raise FolderError where nothing can be compared.

    Without a calibration the LAeq is made equal.
    """
    own = of_run(run)
    recording = read(path)._replace(is_drop=own.is_drop)
    # A long record tells no more about its bands than the solved track that it continues.
    computed = _bands(own, run.sound.duration / run.laps)
    recorded = _bands(recording)
    is_known = np.isfinite(computed.a_weighted_db + recorded.a_weighted_db)
    if background is not None:
        recorded = _without(_bands(read(background)), recorded)
    is_clear = is_known & np.isfinite(recorded.a_weighted_db)
    spread_db = np.hypot(computed.uncertainty_db, recorded.uncertainty_db)
    is_common = is_clear & (spread_db < MAX_DB)
    left_out = [
        *_left_out(f"not {CLEAR_DB:g} dB above the background", is_known & ~is_clear),
        *_left_out(f"uncertain by {MAX_DB:g} dB or more", is_clear & ~is_common),
    ]
    if not is_common.any():
        raise FolderError("; ".join([f"{path}: no third octave can be compared", *left_out]))
    computed = computed.only(is_common)
    recorded = recorded.only(is_common)
    loudest = int(np.nanargmax(computed.a_weighted_db))
    octave = EDGES_HZ[max(loudest - 1, 0)], EDGES_HZ[min(loudest + 2, len(BAND_NAMES))]
    run_db, run_uncertainty_db = _levels(own, computed, octave)
    recording_db, recording_uncertainty_db = _levels(recording, recorded, octave)
    laeq = len(BAND_NAMES)  # place of LAeq, behind the bands
    if calibration is None:
        shift_db = run_db[laeq] - recording_db[laeq]
        scale = "not calibrated: its LAeq is made equal"
    else:
        full_scale = pascals(calibration)
        shift_db = 20 * math.log10(full_scale)
        scale = f"full scale is {full_scale:.4g} Pa"
    recording_db[: laeq + 1] += shift_db
    bands = ["third octave"] * len(BAND_NAMES)
    table = pd.DataFrame(
        {
            "quantity": [*bands, "LAeq", *["modulation"] * len(MODULATION_HZ)],
            "frequency_hz": [*NOMINAL_HZ, math.nan, *MODULATION_HZ],
            "mid_frequency_hz": [*MID_HZ, math.nan, *MODULATION_HZ],
            "run_db": run_db,
            "run_uncertainty_db": run_uncertainty_db,
            "recording_db": recording_db,
            "recording_uncertainty_db": recording_uncertainty_db,
            "difference_db": run_db - recording_db,
            "difference_uncertainty_db": np.hypot(run_uncertainty_db, recording_uncertainty_db),
        }
    )
    notes = [
        f"run: {_quantity(run)}, {own.name} of {own.seconds:.3g} s",
        f"recording: {recording.name}, first channel, {recording.seconds:.3g} s; {scale}",
        f"modulation: from {octave[0]:.0f} to {octave[1]:.0f} Hz, where the run is loudest",
    ]
    if run.summary["source"] == "release":
        notes.append(
            "a recording holds what is heard, and the run its released power: compare the shape of"
            " the spectrum, not its level"
        )
    notes += left_out
    if recording.is_clipped:
        notes.append("the recording is clipped: repeat it with less gain")
    return RecordingComparison(
        table=table.dropna(subset="difference_db"),
        notes=notes,
        records={"run": own, "recording": recording},
    )


def _quantity(run: Run) -> str:
    """Name what the levels of a run are of, with the verdict on them."""
    verdict = run.summary.get("verdict") or {}
    word = verdict.get("word", "-")
    if run.summary["source"] == "vibration":
        return f"levels of the vibration (verdict: {word})"
    if run.summary.get("q", 1) is None:
        return f"levels of the released power under the gain of the scene (verdict: {word})"
    q = run.summary.get("q") or 1
    bound = ", an upper bound" if q == 1 else ""
    return f"levels of the released power with q = {q:g}{bound} (verdict: {word})"


def _left_out(fault: str, bands: NDArray[np.bool_]) -> list[str]:
    """Name the bands that are left out for a fault; nothing if there are none."""
    if not bands.any():
        return []
    return [f"{fault}, left out: {', '.join(np.array(BAND_NAMES)[bands])} Hz"]


def _bands(record: Recording, seconds: float | None = None) -> Bands:
    """Return the levels of third octaves of a record, NaN if silent.

    The uncertainty is that of Gaussian noise of a duration [s], by default of a lap, joined with
    the part of the scatter of LAeq between thirds that noise rarely has: all bands rise and fall.
    """
    samples = record.samples
    laps = len(samples) / RATE / (seconds or record.seconds)
    levels = level.sound_levels(samples, RATE, record.highest, closed=False)
    noise = uncertainty.level_uncertainty(samples, RATE, levels, False, laps)
    # A sharp resonance leaves fewer independent lines in a band than its width does.
    frequency, square = spectrum.line_spectrum(samples, RATE)
    sums = third_octave_mean_square(frequency, square)
    squares = third_octave_mean_square(frequency, square**2)
    of_lines = _DB * np.sqrt(laps * squares / 2) / np.where(sums > 0, sums, np.nan)
    # A level that rises and falls couples neighbouring lines: a band has no more than its B T.
    of_length = band_uncertainty_db(len(samples) / RATE / laps)
    of_noise = np.maximum(np.fmax(_by_band(noise.third_octave_db), of_lines), of_length)
    beyond = max(0.0, record.scatter_db**2 - 9 * (noise.laeq_db or 0.0) ** 2)
    return Bands(
        level_db=_by_band(levels.third_octave_db),
        a_weighted_db=_by_band(levels.third_octave_a_db),
        uncertainty_db=np.sqrt(of_noise**2 + beyond),
    )


def _by_band(levels: Mapping[str, float | None]) -> Array:
    """Return levels of third octaves by name as an array, NaN in place of None."""
    return np.array([levels[name] for name in BAND_NAMES], dtype=float)


def _without(noise: Bands, recorded: Bands) -> Bands:
    """Subtract the background from a recording; bands less than 3 dB above it become NaN."""
    share = 10 ** ((np.nan_to_num(noise.level_db, nan=-400.0) - recorded.level_db) / 10)
    net = np.where(share <= 10 ** (-CLEAR_DB / 10), 1 - share, np.nan)
    of_noise = share * np.nan_to_num(noise.uncertainty_db)
    return Bands(
        level_db=recorded.level_db + 10 * np.log10(net),
        a_weighted_db=recorded.a_weighted_db + 10 * np.log10(net),
        uncertainty_db=np.hypot(recorded.uncertainty_db, of_noise) / net,
    )


def _levels(record: Recording, bands: Bands, octave: tuple[float, float]) -> tuple[Array, Array]:
    """Return levels and uncertainties [dB], (40,), of third octaves, LAeq and modulation."""
    power = 10 ** (bands.a_weighted_db / 10)
    total = np.nansum(power)
    spread = np.sqrt(np.nansum(np.square(power * bands.uncertainty_db)))
    # The bands of impacts rise and fall together.
    laeq_uncertainty_db = max(spread / total, record.scatter_db)
    modulation_db, modulation_uncertainty_db = _modulation(record, octave)
    levels_db = np.hstack([bands.level_db, 10 * np.log10(total), modulation_db])
    uncertainties_db = np.hstack(
        [bands.uncertainty_db, laeq_uncertainty_db, modulation_uncertainty_db]
    )
    return levels_db, uncertainties_db


def _modulation(record: Recording, band: tuple[float, float]) -> tuple[Array, Array]:
    """Return octaves of the modulation of a band, re full modulation, and their uncertainty [dB].

    They are NaN where the record is too short, or the band too narrow.
    """
    envelope = envelope_spectrum(record.samples, RATE, band)
    low = MODULATION_HZ / 2**0.5
    octaves = np.searchsorted(low, envelope.frequency_hz)  # 0 below the first
    squares = np.bincount(octaves, np.square(envelope.modulation), len(low) + 1)[1:] / _HANN
    levels_db = 10 * np.log10(np.maximum(squares, FAINTEST))
    uncertainties_db = _DB / np.sqrt(low * record.seconds)
    is_known = (low * record.seconds >= 2) & (4 * low <= band[1] - band[0])
    return np.where(is_known, levels_db, np.nan), np.where(is_known, uncertainties_db, np.nan)


# ---- text and page


def words(table: pd.DataFrame) -> pd.DataFrame:
    """Write levels and differences with their uncertainties [dB] as words."""
    frame = table[["quantity"]].assign(Hz=table["frequency_hz"].map("{:g}".format))
    for name in ("run", "recording", "difference"):
        pairs = zip(table[f"{name}_db"], table[f"{name}_uncertainty_db"], strict=True)
        frame[f"{name} [dB]"] = [f"{db:.1f} ± {u:.1f}" for db, u in pairs]
    return frame.replace({"Hz": {"nan": ""}})


def page(run: Run, comparison: RecordingComparison) -> bytes:
    """Write a page with the third octaves, all numbers, and both sounds at equal loudness."""
    drawn = None
    with left_out_if_it_fails("of the third octaves"):
        content = picture("third_octaves", partial(_third_octaves, run, comparison)).file("svg")
        drawn = maps.uri("image/svg+xml", content or b"")
    sounds = {
        name: record.samples[: round(HEARD_S * RATE)] / level.a_weighted_rms(record.samples, RATE)
        for name, record in comparison.records.items()
    }
    loudest = max(np.abs(samples).max() for samples in sounds.values())
    gain = PEAK / max(FAINTEST, loudest)
    template = environment().get_template("recording.html")
    return template.render(
        version=__version__,
        seconds=HEARD_S,
        title=run.title,
        notes=comparison.notes,
        table=Markup(words(comparison.table).to_html(index=False, border=0)),
        picture=drawn,
        sounds={name: records.compressed(gain * samples) for name, samples in sounds.items()},
        css=Markup(text.asset("report.css")),
    ).encode()


def _third_octaves(run: Run, comparison: RecordingComparison, ax: Axes) -> Axes:
    """Plot the third octaves of a run and of a recording."""
    bands = comparison.table.query("quantity == 'third octave'").set_index("frequency_hz")
    bands = bands.reindex(NOMINAL_HZ).set_axis(BAND_NAMES)
    curves = [
        (name, bands[f"{name}_db"], bands[f"{name}_uncertainty_db"]) for name in comparison.records
    ]
    duration_s = min(record.seconds for record in comparison.records.values())
    plots.third_octaves(ax, curves, duration_s)
    return finish(ax, f"Third octaves: {run.title}", comparison.notes[1:2])
