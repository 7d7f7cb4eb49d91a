"""A recording of the real thing beside a run: third octaves, LAeq, modulation, and a page of them.

Levels are in dB re 20 uPa, uncertainties are standard uncertainties.
"""

from __future__ import annotations

import io
import math
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import soundfile
from markupsafe import Markup
from matplotlib.axes import Axes

from acoustics import plots, resampling, wav
from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES, EDGES_HZ, reliable
from acoustics.level import laeq_db, sound_levels
from acoustics.modulation import OCTAVE, envelope_spectrum
from acoustics.radiation import P_REF_PA
from acoustics.spectrum import line_spectrum
from acoustics.uncertainty import level_uncertainty, record_scatter_db
from rolling import __version__
from rolling.figures.picture import finish, picture
from rolling.report import maps, records, text
from rolling.report.page import environment
from rolling.results import listening
from rolling.results.labels import printable
from rolling.results.run_result import Run
from rolling.scene.height_files import read_regular
from rolling.terminal.files import FolderError

LEAST_S, MOST_S, LEAST_RATE_HZ, MOST_BYTES = 0.5, 120.0, 16_000, 200_000_000
LARGEST, FAINTEST = 1e6, 1e-9  # samples beyond are no sound, or silence
FULL_SCALE, FLAT = 0.99, 3  # equal extreme samples in a row, at full scale, are clipped
FADE_S, HEARD_S = 0.02, 20.0
SEGMENTS = 8  # of a record, whose mean squares show the spread of its bands
STEADY_DB = 0.3  # standard uncertainty of a tone
CLEAR_DB = 3.0  # of a recording above its background
MODULATION_HZ = 2.0 ** np.arange(8)  # mid frequencies of octaves of modulation
KINDS = ("db", "uncertainty_db")
_HANN = 1.5  # sum of the squared lines of a tone in a Hann window
_DB = 10.0 / math.log(10.0)


class Recording(NamedTuple):
    """A channel that is recorded [full scale] or computed [Pa]; it is closed or faded.

    `highest` [Hz] is the highest frequency that it resolves. The noise in it is a lap long.
    """

    name: str
    samples: Array
    rate: int
    highest: float
    channel: int = 0
    laps: float = 1.0
    clipped: bool = False

    @property
    def seconds(self) -> float:
        """Duration of a lap [s]."""
        return len(self.samples) / self.rate / self.laps


class Comparison(NamedTuple):
    """Table of a run and a recording, sentences on it, and both records."""

    table: pd.DataFrame
    notes: list[str]
    run: Recording
    recording: Recording


# ---- records


def read(path: Path, channel: int | None = None) -> Recording:
    """Read a channel of a sound file, the loudest by default; refuse what is no recording."""
    try:
        with soundfile.SoundFile(io.BytesIO(read_regular(path, MOST_BYTES))) as file:
            rate, seconds = file.samplerate, file.frames / file.samplerate
            if rate < LEAST_RATE_HZ or not LEAST_S <= seconds <= MOST_S:
                raise FolderError(
                    f"{path}: got {seconds:.3g} s at {rate} Hz, allowed: {LEAST_S:g} to "
                    f"{MOST_S:g} s at {LEAST_RATE_HZ} Hz or more"
                )
            channels = file.read(dtype="float64", always_2d=True).T
    except (OSError, RuntimeError) as error:
        raise FolderError(
            f"{path}: cannot be read as a sound ({error}); allowed: WAV, FLAC, OGG, MP3, AIFF"
        ) from error
    if not np.abs(channels).max(initial=0.0) <= LARGEST:
        raise FolderError(f"{path}: holds samples that are no finite numbers up to {LARGEST:g}")
    number = int(np.argmax(channels.std(axis=1))) if channel is None else channel
    if number >= len(channels) or np.ptp(heard := channels[number]) < FAINTEST:
        raise FolderError(f"{path}: channel {number + 1} is silent or missing")
    fade = round(FADE_S * rate)
    window = resampling.fade(np.ones(len(heard)), fade)
    samples = window * (heard - heard.mean()) / math.sqrt(np.mean(np.square(window)))
    flat = np.convolve((heard == heard.max()) | (heard == heard.min()), np.ones(FLAT), "valid")
    clipped = bool(np.abs(heard).max() >= FULL_SCALE and flat.max() == FLAT)
    return Recording(printable(path.name), samples, rate, rate / 2.0, number, clipped=clipped)


def of_run(run: Run) -> Recording:
    """Return the long record of a run [Pa] if its scene asks for one, otherwise its signal."""
    sound = run.sound
    if long := listening.recorded(run):
        highest = min(sound.highest, long.numbers["highest_frequency_hz"])
        return Recording("long record of the run", long.pressure, long.sample_rate, highest)
    record = sound.pressure, sound.sample_rate, sound.highest
    return Recording("signal of the run", *record, laps=run.laps)


def pascals(calibration: str, channel: int) -> float:
    """Return the pressure [Pa] of full scale by a tone FILE=LEVEL, or by a number."""
    path, sign, level = calibration.rpartition("=")
    try:
        number = float(level)
    except ValueError:
        number = math.nan
    if path and 0 <= number <= 200:
        return P_REF_PA * 10 ** (number / 20) / _tone_rms(read(Path(path), channel))
    if not sign and 1 / LARGEST <= number <= LARGEST:
        return number
    raise FolderError(
        f"--calibration: got {calibration}, allowed: TONE.wav=LEVEL with the level of the tone in "
        "dB re 20 uPa, 0 to 200, or the pressure of full scale in Pa"
    )


def _tone_rms(tone: Recording) -> float:
    """Return the rms of a steady tone without the noise beyond half an octave from it."""
    frequency, square = line_spectrum(tone.samples, tone.rate)
    strongest = frequency[np.argmax(square)]
    edges = strongest / 2**0.5, strongest * 2**0.5
    power = float(square[slice(*np.searchsorted(frequency, edges))].sum())
    if tone.clipped or power < 0.5 * square.sum() or _scatter_db(tone, edges)[0] > STEADY_DB:
        raise FolderError(f"{tone.name}: no steady tone, or it is clipped or lost in noise")
    return math.sqrt(power)


# ---- levels


def _scatter_db(record: Recording, edges_hz: Array | tuple[float, ...]) -> Array:
    """Return the standard uncertainty of neighbouring bands that the segments of a record show.

    The transform of the lines of a band is its complex envelope. Narrow bands have 0 dB.
    """
    lines = np.fft.rfft(record.samples)
    places = np.searchsorted(np.fft.rfftfreq(len(record.samples), 1 / record.rate), edges_hz)
    scatter = np.zeros(len(edges_hz) - 1)
    for band, (first, last) in enumerate(pairwise(places)):
        if last - first >= SEGMENTS and lines[first:last].any():
            envelope = np.square(np.abs(np.fft.ifft(lines[first:last])))
            means = np.array([part.mean() for part in np.array_split(envelope, SEGMENTS)])
            scatter[band] = _DB * means.std(ddof=1) / math.sqrt(SEGMENTS) / means.mean()
    return scatter


def _bands(record: Recording) -> tuple[pd.DataFrame, float]:
    """Return third octaves with their uncertainty, and the uncertainty of LAeq [dB].

    An uncertainty is that of Gaussian noise, or what parts of the record show if that is larger.
    """
    levels = sound_levels(record.samples, record.rate, record.highest, closed=False)
    noise = level_uncertainty(record.samples, record.rate, levels, False, record.laps)
    columns = {"db": levels.third_octave_db, "a_db": levels.third_octave_a_db}
    bands = pd.DataFrame(columns | {"u_db": noise.third_octave_db}, dtype=float)
    bands["u_db"] = np.maximum(bands["u_db"], _scatter_db(record, EDGES_HZ))
    scatter = record_scatter_db(record.samples, record.rate)
    return bands, max(noise.laeq_db or 0.0, scatter or 0.0)


def _without(noise: pd.DataFrame, recorded: pd.DataFrame) -> pd.DataFrame:
    """Subtract the background from a recording; bands less than 3 dB above it become NaN."""
    share = 10 ** ((noise["db"] - recorded["db"]).fillna(-400.0) / 10)  # of the recording
    net = 1 - share.where(share <= 10 ** (-CLEAR_DB / 10))
    less = 10 * np.log10(net)
    spread = np.hypot(recorded["u_db"], share * noise["u_db"].fillna(0.0)) / net
    return recorded.assign(db=recorded["db"] + less, a_db=recorded["a_db"] + less, u_db=spread)


def _modulation(record: Recording, band: tuple[float, float]) -> pd.DataFrame:
    """Return the modulation of a band in octaves with its uncertainty, re full modulation [dB]."""
    spectrum, low = envelope_spectrum(record.samples, record.rate, band), MODULATION_HZ / 2**0.5
    octaves = np.floor(np.log2(spectrum.frequency_hz / low[0]))
    squares = [np.square(spectrum.modulation[octaves == k]).sum() for k in range(len(low))]
    levels = 10 * np.log10(np.maximum(squares, FAINTEST) / _HANN)
    frame = pd.DataFrame({"db": levels, "u_db": _DB / np.sqrt(low * record.seconds)})
    return frame[(low * record.seconds >= 2) & (4 * low <= band[1] - band[0])]


def compare(
    run: Run, path: Path, calibration: str | None = None, background: Path | None = None
) -> Comparison:
    """Compare a run with a recording; raise FolderError where nothing can be compared.

    Differences are those of the run from the recording. Without a calibration the LAeq is equal.
    """
    own, recording = of_run(run), read(path)
    (computed, own_u), (recorded, u) = _bands(own), _bands(recording)
    known = (computed["db"] + recorded["db"]).notna()
    if background is not None:
        noise = read(background, recording.channel)
        if noise.rate != recording.rate:
            raise FolderError(f"{background}: {noise.rate} Hz, but {path} has {recording.rate} Hz")
        recorded = _without(_bands(noise)[0], recorded)
    common = (computed["db"] + recorded["db"]).notna()
    if not common.any():
        raise FolderError(f"{path}: no third octave in which both the run and the recording sound")
    (own_laeq, laeq) = (_DB * math.log(_power(x)[common].sum()) for x in (computed, recorded))
    shift = own_laeq - laeq
    if calibration is not None:
        shift = 20 * math.log10(pascals(calibration, recording.channel))
    recorded["db"] += shift
    bands = _beside("third octave", computed, recorded)
    is_short = ~reliable(min(own.seconds, recording.seconds))
    remarks = ["not in both", "background", "short"]
    bands["remark"] = np.select([~known, ~common, is_short], remarks, "")
    levels = [
        pd.DataFrame({"db": [own_laeq], "u_db": [own_u]}, index=[math.nan]),
        pd.DataFrame({"db": [laeq + shift], "u_db": [u]}, index=[math.nan]),
    ]
    parts = [bands, _beside("LAeq", *levels)]
    octaves = _power(computed).where(common).rolling(OCTAVE).sum()
    if octaves.notna().any():
        last = int(np.nanargmax(octaves))
        band = float(EDGES_HZ[last + 1 - OCTAVE]), float(EDGES_HZ[last + 1])
        quantity = f"modulation of {band[0]:.0f} to {band[1]:.0f} Hz"
        parts.append(_beside(quantity, *(_modulation(x, band) for x in (own, recording))).dropna())
    table = pd.concat(parts, ignore_index=True).fillna({"remark": ""})
    return Comparison(table, _notes(run, own, recording, calibration, shift), own, recording)


def _power(bands: pd.DataFrame) -> pd.Series[float]:
    """Return the A-weighted mean squares of third octaves [(20 uPa)^2]."""
    return 10 ** (bands["a_db"] / 10)


def _beside(quantity: str, own: pd.DataFrame, other: pd.DataFrame) -> pd.DataFrame:
    """Return levels of a run and a recording side by side, with their difference."""
    columns: dict[str, Any] = {"quantity": quantity, "frequency_hz": own.index.astype(float)}
    for name, levels in (("run", own), ("recording", other.reindex(own.index))):
        columns |= {f"{name}_db": levels["db"], f"{name}_uncertainty_db": levels["u_db"]}
    frame = pd.DataFrame(columns)
    frame["difference_db"] = frame["run_db"] - frame["recording_db"]
    spreads = frame["run_uncertainty_db"], frame["recording_uncertainty_db"]
    return frame.assign(difference_uncertainty_db=np.hypot(*spreads))


def _notes(
    run: Run, own: Recording, recording: Recording, calibration: str | None, shift: float
) -> list[str]:
    """Say which records are compared, how the recording is calibrated, and what is doubtful."""
    notes = [
        f"{own.name}, {own.seconds:.3g} s, and {recording.name}, {recording.seconds:.3g} s, "
        f"channel {recording.channel + 1}; LAeq of the third octaves that have a difference",
        f"full scale of the recording is {10 ** (shift / 20):.4g} Pa"
        if calibration
        else "the recording is not calibrated: its LAeq is made equal, only shapes are compared",
    ]
    if judged := run.summary.get("verdict"):
        notes.append(f"level of the run: {judged['word']}; {judged['reason']}")
    if recording.clipped:
        notes.append("the recording is clipped: repeat it with less gain")
    return notes


# ---- text and page


def rows(comparison: Comparison) -> list[list[str]]:
    """Write the quantities that have a difference, and the bands in the background, as words."""
    table, words = comparison.table, [["dB", "run", "recording", "difference", ""]]
    for row in table[table["remark"] != "not in both"].to_dict("records"):
        hz = "" if math.isnan(row["frequency_hz"]) else f"{row['frequency_hz']:g} Hz"
        pairs = ((row[f"{x}_db"], row[f"{x}_uncertainty_db"]) for x in words[0][1:4])
        cells = ["-" if math.isnan(db) else f"{db:.1f} ± {u:.1f}" for db, u in pairs]
        words.append([f"{row['quantity']} {hz}".strip(), *cells, row["remark"]])
    return words


def page(run: Run, comparison: Comparison) -> bytes:
    """Write a page with the third octaves, all numbers, and both sounds at equal loudness."""
    both = {"run": comparison.run, "recording": comparison.recording}
    bands, heard = comparison.table[: len(BAND_NAMES)], [*map(_excerpt, both.values())]

    def draw(ax: Axes) -> Axes:
        curves = [
            (
                record.name,
                *(dict(zip(BAND_NAMES, bands[f"{name}_{kind}"], strict=True)) for kind in KINDS),
            )
            for name, record in both.items()
        ]
        plots.third_octaves(ax, curves, min(record.seconds for record in both.values()))
        return finish(ax, f"Third octaves: {run.title}", comparison.notes[1:2])

    drawn = picture("third_octaves", draw).file("svg") or b""
    gains = records.gains(
        [float(np.abs(x).max()) for x in heard], [laeq_db(x, wav.SAMPLE_RATE_HZ) for x in heard]
    )
    sounds = [
        (
            record.name,
            records.compressed(x * (gain["equal"] or 0.0) / (gain["full_scale_pa"] or 1.0)),
        )
        for record, x, gain in zip(both.values(), heard, gains, strict=True)
    ]
    return (
        environment()
        .get_template("recording.html")
        .render(
            version=__version__,
            title=run.title,
            notes=comparison.notes,
            rows=rows(comparison),
            picture=maps.uri("image/svg+xml", drawn),
            sounds=sounds,
            seconds=HEARD_S,
            css=Markup(text.asset("report.css")),
        )
        .encode()
    )


def _excerpt(record: Recording) -> Array:
    """Return the beginning of a record at 48 kHz."""
    part = record.samples[: round(HEARD_S * record.rate)]
    return resampling.resample_closed(part, round(len(part) * wav.SAMPLE_RATE_HZ / record.rate))
