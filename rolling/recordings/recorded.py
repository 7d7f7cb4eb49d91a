"""Records of real things: channels of a sound file, their quantity, and their calibration."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import soundfile

from acoustics import resampling, spectrum, uncertainty
from acoustics.arrays import Array
from acoustics.radiation import P_REF_PA
from acoustics.texts import printable
from acoustics.vibration_level import REFERENCES
from acoustics.wav import SAMPLE_RATE_HZ as RATE
from rolling.recordings.series_files import FORMATS as SERIES_FORMATS
from rolling.recordings.series_files import (
    FileLayout,
    MeasuredSeries,
    is_series_file,
    read_series,
)
from rolling.scene.messages import nearest
from rolling.terminal.whole_files import FolderError, read_regular

MIN_S = 0.5  # shortest recording
MAX_S = 120.0
MIN_RATE_HZ = 16_000  # of sound
MIN_VIBRATION_RATE_HZ = 4_000  # of accelerations and forces
MAX_RATE_HZ = 192_000
MAX_BYTES = 200_000_000  # of a file
MAX_SAMPLE_BYTES = 500_000_000  # of all channels as they are read, or at 48 kHz if that is more
FAINTEST = 1e-9  # of full scale; less is silence
LARGEST = 1e6  # of full scale; more is no signal
FULL_SCALE = 0.99  # at which extreme samples may be clipped,
FLAT = 3  # if so many of them in a row are equal
FADE_S = 0.02
STEADY_DB = 0.3  # largest uncertainty of the level of a tone
MAX_TONE_DB = 200.0  # level of a tone of sound
FORMATS = "WAV, FLAC, OGG, MP3, AIFF"
SKIPPED = "-"  # in place of the name of a channel that is not compared


class MeasuredQuantity(NamedTuple):
    """Quantity of a record, its unit, and the reference value of its levels (ISO 1683).

    The total level of sound is A-weighted, that of all others is not weighted (Z).
    """

    name: str
    unit: str
    reference: float
    reference_text: str
    weighting: str


def _of_vibration(name: str) -> MeasuredQuantity:
    """Return a quantity of vibration or force."""
    reference = REFERENCES[name]
    return MeasuredQuantity(
        name=name,
        unit=reference.unit,
        reference=reference.value,
        reference_text=reference.words.removeprefix("re "),
        weighting="Z",
    )


QUANTITIES = {
    "pressure": MeasuredQuantity("pressure", "Pa", P_REF_PA, "20 uPa", "A"),
    "acceleration": _of_vibration("acceleration"),
    "velocity": _of_vibration("velocity"),
    "displacement": _of_vibration("displacement"),
    "force": _of_vibration("force"),
}
PRESSURE = QUANTITIES["pressure"]


def quantity_of(name: str) -> MeasuredQuantity:
    """Return a quantity by its name, or raise FolderError with the names that are allowed."""
    if name not in QUANTITIES:
        near = nearest(name, [*QUANTITIES])
        raise FolderError(f"--quantity: got {name}{near}, allowed: {', '.join(QUANTITIES)}")
    return QUANTITIES[name]


class Recording(NamedTuple):
    """Samples at 48 kHz, recorded [full scale] or computed [SI unit], closed or faded at both ends.

    `highest` [Hz] is the highest frequency that they resolve, `seconds` [s] the length of a lap.
    The parts of a drop differ by nature.
    """

    name: str
    samples: Array
    highest: float
    seconds: float
    is_clipped: bool = False
    is_drop: bool = False
    quantity: MeasuredQuantity = PRESSURE

    @property
    def scatter_db(self) -> float:
        """Standard uncertainty of the total level [dB] that the thirds show; 0 for a drop."""
        if self.is_drop:
            return 0.0
        is_weighted = self.quantity.weighting == "A"
        return uncertainty.record_scatter_db(self.samples, RATE, is_weighted) or 0.0

    def stretch(self, first: int, count: int) -> Recording:
        """Return a stretch of samples, faded at both ends, with the level that it has unfaded."""
        window = fade_window(count)
        samples = window * self.samples[first : first + count] / rms(window)
        return self._replace(samples=samples, seconds=min(self.seconds, count / RATE))

    def whole(self) -> Recording:
        """Return a record that was faded as it was read with the level that it has unfaded."""
        return self._replace(samples=self.samples / rms(fade_window(len(self.samples))))


def rms(samples: Array) -> float:
    """Return the root of the mean square."""
    return math.sqrt(float(np.mean(np.square(samples))))


def fade_window(count: int, rate: float = RATE) -> Array:
    """Return ones that are faded at both ends."""
    return resampling.fade(np.ones(count), min(round(FADE_S * rate), count // 4))


def read_channels(
    path: Path, quantity: MeasuredQuantity = PRESSURE, layout: FileLayout | None = None
) -> list[Recording]:
    """Read all channels of a recording without their means, faded at both ends.

    A channel that is silent, or holds NaN, is refused when it is used: `usable` does so.

    Parameters
    ----------
    path : Path. A sound file, or a file of series, by its ending.
    quantity : MeasuredQuantity. What it holds.
    layout : FileLayout. What a file of series does not say. Default: nothing.

    Raises
    ------
    FolderError : the file cannot be read, or is too short, long, slow or fast.
    """
    if is_series_file(path):
        series = read_series(
            path,
            layout or FileLayout(),
            most_bytes=MAX_BYTES,
            most_sample_bytes=MAX_SAMPLE_BYTES,
        )
        samples, rate = series
        _refuse_length(path, len(samples), rate, quantity)
        _refuse_many_samples(path, len(samples), rate, samples.shape[1])
    else:
        if layout is not None and any(layout):
            raise FolderError(
                f"{path}: got --variable or --rate, which only go with {SERIES_FORMATS}"
            )
        samples, rate = _read_sound(path, quantity)
    seconds = len(samples) / rate
    channels = []
    window = fade_window(len(samples), rate)
    for channel in samples.T:
        recorded = Recording(
            name=printable(path.name),
            samples=np.zeros(0),
            highest=rate / 2.0,
            seconds=seconds,
            quantity=quantity,
        )
        if FAINTEST < np.ptp(channel) < LARGEST:
            faded = window * (channel - channel.mean())
            recorded = recorded._replace(
                samples=resampling.resample_closed(faded, round(len(faded) * RATE / rate)),
                is_clipped=_is_clipped(channel),
            )
        channels.append(recorded)
    return channels


def _read_sound(path: Path, quantity: MeasuredQuantity) -> MeasuredSeries:
    """Read a sound file, which is judged by its header first."""
    try:
        with soundfile.SoundFile(io.BytesIO(read_regular(path, MAX_BYTES))) as file:
            rate = file.samplerate
            _refuse_length(path, file.frames, rate, quantity)
            _refuse_many_samples(path, file.frames, rate, file.channels)
            return MeasuredSeries(file.read(dtype="float64", always_2d=True), rate)
    except (OSError, RuntimeError) as error:
        reason = getattr(error, "error_string", getattr(error, "strerror", error))
        raise FolderError(
            f"{path}: no sound that can be read ({reason}), allowed: {FORMATS}, {SERIES_FORMATS}"
        ) from error


def _refuse_length(path: Path, frames: int, rate: float, quantity: MeasuredQuantity) -> None:
    """Refuse a recording that is too short, long, slow or fast."""
    least_hz = MIN_RATE_HZ if quantity is PRESSURE else MIN_VIBRATION_RATE_HZ
    seconds = frames / rate
    if not (MIN_S <= seconds <= MAX_S and least_hz <= rate <= MAX_RATE_HZ):
        allowed = f"{MIN_S:g} to {MAX_S:g} s at {least_hz} to {MAX_RATE_HZ} Hz"
        raise FolderError(f"{path}: got {seconds:.3g} s at {rate:.6g} Hz, allowed: {allowed}")


def _refuse_many_samples(path: Path, frames: int, own_rate: float, channels: int) -> None:
    """Refuse a recording whose channels together have too many samples."""
    rate = max(own_rate, RATE)
    seconds = frames / own_rate
    size = 8 * channels * seconds * rate
    if size > MAX_SAMPLE_BYTES:
        longest = MAX_SAMPLE_BYTES / (8 * channels * rate)
        raise FolderError(
            f"{path}: got {seconds:.3g} s of {_counted(channels)}, which take"
            f" {size / 1e6:,.0f} MB, allowed: {MAX_SAMPLE_BYTES / 1e6:,.0f} MB; save fewer"
            f" channels, or a stretch of at most {longest:.3g} s"
        )


def usable(path: Path, channels: list[Recording], number: int) -> Recording:
    """Return a channel by its number from 0 on; raise FolderError where it holds no signal."""
    if not len(channels[number].samples):
        name = "first channel" if number == 0 else f"channel {number + 1}"
        raise FolderError(f"{path}: its {name} is silent, or holds no finite numbers")
    return channels[number]


def _is_clipped(channel: Array) -> bool:
    """Tell whether samples stay at full scale for several in a row."""
    if np.abs(channel).max() < FULL_SCALE:
        return False
    is_extreme = np.isin(channel, (channel.min(), channel.max()))
    return bool(np.convolve(is_extreme, np.ones(FLAT), "valid").max() == FLAT)


# ---- calibration


class FullScale(NamedTuple):
    """Value of full scale [SI unit], and the uncertainty of its level [dB] by a recorded tone."""

    value: float
    uncertainty_db: float


def full_scales(
    calibration: str | Sequence[str], quantity: MeasuredQuantity, channels: int
) -> list[FullScale]:
    """Return the full scale of each channel of a recording.

    Parameters
    ----------
    calibration : str or sequence of str. A number, or TONE=LEVEL, a recorded tone and its level: in
        dB re 20 uPa for sound, otherwise its rms in the unit of the quantity. One stands for all
        channels; several, in a sequence or with commas between them, stand for one channel each. A
        tone of as many channels as the recording calibrates each channel by its own.
    quantity : MeasuredQuantity. What the recording holds.
    channels : int. Number of channels of the recording.

    Raises
    ------
    FolderError : there is no such calibration, or no steady tone.
    """
    if not isinstance(calibration, str):
        parts = list(calibration)
    elif Path(calibration.rpartition("=")[0]).is_file():
        parts = [calibration]
    else:
        parts = calibration.split(",")
    if len(parts) not in (1, channels):
        raise FolderError(
            f"--calibration: got {len(parts)} values for {_counted(channels)}, allowed: one for all"
            " channels, or one for each"
        )
    if len(parts) == 1:
        parts = parts * channels
    return [_full_scale(part, quantity, number, channels) for number, part in enumerate(parts)]


def _full_scale(text: str, quantity: MeasuredQuantity, number: int, channels: int) -> FullScale:
    """Return the full scale of a channel from a number, or from a tone."""
    path, sign, level = text.rpartition("=")
    try:
        value = float(level)
    except ValueError:
        value = math.nan
    if path and quantity is PRESSURE and 0 <= value <= MAX_TONE_DB:
        tone = _steady_tone(Path(path), quantity, number, channels)
        return FullScale(P_REF_PA * 10 ** (value / 20) / tone.rms, tone.uncertainty_db)
    if path and quantity is not PRESSURE and 1 / LARGEST <= value <= LARGEST:
        tone = _steady_tone(Path(path), quantity, number, channels)
        return FullScale(value / tone.rms, tone.uncertainty_db)
    if not sign and _is_scale(value, quantity):
        return FullScale(value, 0.0)
    if quantity is PRESSURE:
        allowed = (
            f"TONE.wav=DB, 0 to {MAX_TONE_DB:g} dB re {quantity.reference_text}, or the pressure of"
            " full scale, 1e-6 to 1e6 Pa"
        )
    else:
        allowed = (
            f"TONE.wav=RMS with the rms of the tone in {quantity.unit}, 1e-6 to 1e6, or the"
            f" {quantity.name} of full scale in {quantity.unit}, more than 0"
        )
    raise FolderError(f"--calibration: got {text}, allowed: {allowed}")


def _is_scale(value: float, quantity: MeasuredQuantity) -> bool:
    """Tell whether a number can be the value of full scale."""
    if quantity is PRESSURE:
        return 1 / LARGEST <= value <= LARGEST
    return 1e-15 <= value <= 1e15  # a displacement may be nanometres, a force kilonewtons


class _Tone(NamedTuple):
    """Rms of a recorded tone [full scale], and what its parts scatter [dB]."""

    rms: float
    uncertainty_db: float


def _steady_tone(path: Path, quantity: MeasuredQuantity, number: int, channels: int) -> _Tone:
    """Return a steady tone without the noise beyond half an octave from it.

    The tone of a file with one channel holds for all channels of a recording.
    """
    tones = read_channels(path, quantity)
    if len(tones) == 1 or quantity is PRESSURE:
        number = 0
    elif len(tones) != channels:
        raise FolderError(
            f"{path}: got a tone with {_counted(len(tones))}, allowed: one, or as many as the"
            f" recording has, {channels}"
        )
    tone = usable(path, tones, number).whole()
    frequency, square = spectrum.line_spectrum(tone.samples, RATE)
    octave = frequency[np.argmax(square)] * np.array([0.5, 2]) ** 0.5
    first, last = np.searchsorted(frequency, octave)
    power = float(square[first:last].sum())
    if tone.is_clipped or power < 0.5 * square.sum() or tone.scatter_db > STEADY_DB:
        of_channel = f", channel {number + 1}" if len(tones) > 1 and number else ""
        raise FolderError(
            f"{tone.name}{of_channel}: no steady tone, or it is clipped or lost in noise"
        )
    return _Tone(math.sqrt(power), tone.scatter_db)


def _counted(channels: int) -> str:
    """Return a number of channels in words."""
    return "1 channel" if channels == 1 else f"{channels} channels"
