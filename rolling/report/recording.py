"""A recording of the real thing beside a run: third octaves, LAeq, modulation, and a page of them.

Levels are in dB re 20 uPa, their uncertainties are standard uncertainties.
"""

import io
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import soundfile
from markupsafe import Markup
from matplotlib.axes import Axes

from acoustics import level, plots, resampling, spectrum, uncertainty
from acoustics.arrays import Array
from acoustics.bands import (
    BAND_NAMES,
    EDGES_HZ,
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
from rolling.report.page import environment
from rolling.results import listening
from rolling.results.run_result import Run
from rolling.scene.height_files import read_regular
from rolling.terminal.files import FolderError

MIN_S, MAX_S, MIN_RATE_HZ, MAX_RATE_HZ = 0.5, 120.0, 16_000, 192_000
MAX_BYTES = 200_000_000
FAINTEST, LARGEST = 1e-9, 1e6  # of full scale; less is silence, more is no sound
FULL_SCALE, FLAT = 0.99, 3  # equal extreme samples in a row, at full scale, are clipped
FADE_S, HEARD_S = 0.02, 20.0
STEADY_DB = 0.3  # largest uncertainty of the level of a tone
CLEAR_DB = 3.0  # least level of a recording above its background
MAX_DB = 10.0  # least uncertainty of a band that tells nothing
MODULATION_HZ = 2.0 ** np.arange(8)  # mid frequencies of octaves of modulation
COLUMNS = [f"{x}{y}_db" for x in ("run", "recording", "difference") for y in ("", "_uncertainty")]
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
        return 0.0 if self.is_drop else uncertainty.record_scatter_db(self.samples, RATE) or 0.0


# ---- records


def read(path: Path) -> Recording:
    """Read the first channel of a sound file, or raise FolderError if it is none."""
    try:
        with soundfile.SoundFile(io.BytesIO(read_regular(path, MAX_BYTES))) as file:
            rate, seconds = file.samplerate, file.frames / file.samplerate
            if not (MIN_S <= seconds <= MAX_S and MIN_RATE_HZ <= rate <= MAX_RATE_HZ):
                allowed = f"{MIN_S:g} to {MAX_S:g} s at {MIN_RATE_HZ} to {MAX_RATE_HZ} Hz"
                raise FolderError(f"{path}: got {seconds:.3g} s at {rate} Hz, allowed: {allowed}")
            heard = file.read(dtype="float64", always_2d=True)[:, 0]
    except (OSError, RuntimeError) as error:
        reason = getattr(error, "error_string", getattr(error, "strerror", error))
        words = f"no sound that can be read ({reason}), allowed: WAV, FLAC, OGG, MP3, AIFF"
        raise FolderError(f"{path}: {words}") from error
    if not FAINTEST < np.ptp(heard) < LARGEST:
        raise FolderError(f"{path}: its first channel is silent, or holds no finite numbers")
    window = resampling.fade(np.ones(len(heard)), round(FADE_S * rate))
    faded = window * (heard - heard.mean()) / math.sqrt(np.mean(np.square(window)))
    samples = resampling.resample_closed(faded, round(len(faded) * RATE / rate))
    flat = np.convolve(np.isin(heard, (heard.min(), heard.max())), np.ones(FLAT), "valid")
    is_clipped = bool(np.abs(heard).max() >= FULL_SCALE and flat.max() == FLAT)
    return Recording(printable(path.name), samples, rate / 2.0, seconds, is_clipped)


def of_run(run: Run) -> Recording:
    """Return the long record of a run if its scene asks for one, otherwise its signal."""
    if long := listening.recorded(run):
        seconds = len(long.pressure) / RATE
        return Recording("long record", long.pressure, run.sound.highest, seconds)
    seconds = run.sound.duration / run.laps
    return Recording("signal", run.sound.pressure, run.sound.highest, seconds)


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
    power = float(square[slice(*np.searchsorted(frequency, octave))].sum())
    if tone.is_clipped or power < 0.5 * square.sum() or tone.scatter_db > STEADY_DB:
        raise FolderError(f"{tone.name}: no steady tone, or it is clipped or lost in noise")
    return math.sqrt(power)


# ---- levels


def compare(
    run: Run, path: Path, calibration: str | None = None, background: Path | None = None
) -> tuple[pd.DataFrame, list[str], dict[str, Recording]]:
    """Compare a run with a recording; raise FolderError where nothing can be compared.

    Returns the table, sentences on it, and both records. Differences are the run less the
    recording. Without a calibration the LAeq is made equal.
    """
    is_drop = run.scene.rolling.drop_mm is not None
    own, recording = (record._replace(is_drop=is_drop) for record in (of_run(run), read(path)))
    # A long record tells no more about its bands than the solved track that it continues.
    computed, recorded = _bands(own, run.sound.duration / run.laps), _bands(recording)
    known = np.isfinite(computed[1] + recorded[1])
    if background is not None:
        recorded = _without(_bands(read(background)), recorded)
    clear = known & np.isfinite(recorded[1])
    common = clear & (np.hypot(computed[2], recorded[2]) < MAX_DB)
    faults = {
        f"not {CLEAR_DB:g} dB above the background": known & ~clear,
        f"uncertain by {MAX_DB:g} dB or more": clear & ~common,
    }
    left_out = [
        f"{fault}, left out: {', '.join(np.array(BAND_NAMES)[bands])} Hz"
        for fault, bands in faults.items()
        if bands.any()
    ]
    if not common.any():
        raise FolderError("; ".join([f"{path}: no third octave can be compared", *left_out]))
    computed, recorded = (np.where(common, bands, np.nan) for bands in (computed, recorded))
    loudest, laeq = int(np.nanargmax(computed[1])), len(common)  # place of LAeq, behind the bands
    octave = EDGES_HZ[max(loudest - 1, 0)], EDGES_HZ[min(loudest + 2, laeq)]
    run_db, run_u = _levels(own, computed, octave)
    db, u = _levels(recording, recorded, octave)
    shift, scale = run_db[laeq] - db[laeq], "not calibrated: its LAeq is made equal"
    if calibration is not None:
        full_scale = pascals(calibration)
        shift, scale = 20 * math.log10(full_scale), f"full scale is {full_scale:.4g} Pa"
    db[: laeq + 1] += shift
    pairs = run_db, run_u, db, u, run_db - db, np.hypot(run_u, u)
    table = pd.DataFrame(dict(zip(COLUMNS, pairs, strict=True)))
    quantities = ["third octave"] * laeq + ["LAeq"] + ["modulation"] * len(MODULATION_HZ)
    table.insert(0, "quantity", quantities)
    table.insert(1, "frequency_hz", [*NOMINAL_HZ, math.nan, *MODULATION_HZ])
    verdict = run.summary.get("verdict") or {}
    notes = [
        f"run: {own.name}, {own.seconds:.3g} s; its level: {verdict.get('word', '-')}",
        f"recording: {recording.name}, first channel, {recording.seconds:.3g} s; {scale}",
        f"modulation: from {octave[0]:.0f} to {octave[1]:.0f} Hz, where the run is loudest",
        *left_out,
    ]
    if recording.is_clipped:
        notes.append("the recording is clipped: repeat it with less gain")
    return table.dropna(subset="difference_db"), notes, {"run": own, "recording": recording}


def _bands(record: Recording, seconds: float | None = None) -> Array:
    """Return Z and A levels of third octaves and their uncertainty [dB], (3, 31), NaN if silent.

    The uncertainty is that of Gaussian noise of a duration [s], by default of a lap, joined with
    the part of the scatter of LAeq between thirds that noise rarely has: all bands rise and fall.
    """
    samples, laps = record.samples, len(record.samples) / RATE / (seconds or record.seconds)
    levels = level.sound_levels(samples, RATE, record.highest, closed=False)
    noise = uncertainty.level_uncertainty(samples, RATE, levels, False, laps)
    # A sharp resonance leaves fewer independent lines in a band than its width does.
    frequency, square = spectrum.line_spectrum(samples, RATE)
    sums, squares = (third_octave_mean_square(frequency, square**power) for power in (1, 2))
    lines = _DB * np.sqrt(laps * squares / 2) / np.where(sums > 0, sums, np.nan)
    parts = levels.third_octave_db, levels.third_octave_a_db, noise.third_octave_db
    bands = np.array([[part[name] for name in BAND_NAMES] for part in parts], dtype=float)
    beyond = max(0.0, record.scatter_db**2 - 9 * (noise.laeq_db or 0.0) ** 2)
    # A level that rises and falls couples neighbouring lines: a band has no more than its B T.
    even = band_uncertainty_db(len(samples) / RATE / laps)
    bands[2] = np.sqrt(np.maximum(np.fmax(bands[2], lines), even) ** 2 + beyond)
    return bands


def _without(noise: Array, recorded: Array) -> Array:
    """Subtract the background from a recording; bands less than 3 dB above it become NaN."""
    share = 10 ** ((np.nan_to_num(noise[0], nan=-400.0) - recorded[0]) / 10)
    net = np.where(share <= 10 ** (-CLEAR_DB / 10), 1 - share, np.nan)
    spread = np.hypot(recorded[2], share * np.nan_to_num(noise[2])) / net
    return np.array([*(recorded[:2] + 10 * np.log10(net)), spread])


def _levels(record: Recording, bands: Array, octave: tuple[float, float]) -> Array:
    """Return third octaves, their LAeq, and modulation, (2, 40), with their uncertainty [dB]."""
    power = 10 ** (bands[1] / 10)
    total, spread = np.nansum(power), np.sqrt(np.nansum(np.square(power * bands[2])))
    # The bands of impacts rise and fall together.
    laeq = [[10 * np.log10(total)], [max(spread / total, record.scatter_db)]]
    return np.hstack([bands[::2], laeq, _modulation(record, octave)])


def _modulation(record: Recording, band: tuple[float, float]) -> Array:
    """Return octaves of the modulation of a band, re full modulation, and their uncertainty [dB].

    They are NaN where the record is too short, or the band too narrow.
    """
    envelope, low = envelope_spectrum(record.samples, RATE, band), MODULATION_HZ / 2**0.5
    octaves = np.searchsorted(low, envelope.frequency_hz)  # 0 below the first
    squares = np.bincount(octaves, np.square(envelope.modulation), len(low) + 1)[1:] / _HANN
    levels = 10 * np.log10(np.maximum(squares, FAINTEST)), _DB / np.sqrt(low * record.seconds)
    return np.where((low * record.seconds >= 2) & (4 * low <= band[1] - band[0]), levels, np.nan)


# ---- text and page


def words(table: pd.DataFrame) -> pd.DataFrame:
    """Write levels and differences with their uncertainties [dB] as words."""
    frame = table[["quantity"]].assign(Hz=table["frequency_hz"].map("{:g}".format))
    for name in ("run", "recording", "difference"):
        pairs = zip(table[f"{name}_db"], table[f"{name}_uncertainty_db"], strict=True)
        frame[f"{name} [dB]"] = [f"{db:.1f} ± {u:.1f}" for db, u in pairs]
    return frame.replace({"Hz": {"nan": ""}})


def page(run: Run, table: pd.DataFrame, notes: list[str], both: dict[str, Recording]) -> bytes:
    """Write a page with the third octaves, all numbers, and both sounds at equal loudness."""
    bands = table.query("quantity == 'third octave'").set_index("frequency_hz")
    bands = bands.reindex(NOMINAL_HZ).set_axis(BAND_NAMES)

    def draw(ax: Axes) -> Axes:
        curves = [(name, bands[f"{name}_db"], bands[f"{name}_uncertainty_db"]) for name in both]
        plots.third_octaves(ax, curves, min(record.seconds for record in both.values()))
        return finish(ax, f"Third octaves: {run.title}", notes[1:2])

    drawn = None
    with left_out_if_it_fails("of the third octaves"):
        drawn = maps.uri("image/svg+xml", picture("third_octaves", draw).file("svg") or b"")
    heard = {
        name: record.samples[: round(HEARD_S * RATE)] / level.a_weighted_rms(record.samples, RATE)
        for name, record in both.items()
    }
    gain = PEAK / max(FAINTEST, *(np.abs(samples).max() for samples in heard.values()))
    content = {
        "title": run.title,
        "notes": notes,
        "table": Markup(words(table).to_html(index=False, border=0)),
        "picture": drawn,
        "sounds": {name: records.compressed(gain * samples) for name, samples in heard.items()},
        "css": Markup(text.asset("report.css")),
    }
    template = environment().get_template("recording.html")
    return template.render(version=__version__, seconds=HEARD_S, **content).encode()
