"""Compute levels, third octaves and a WAV of any record, without a contact."""

import tempfile
from pathlib import Path

import numpy as np

from acoustics import level, wav, weighting

RATE = wav.SAMPLE_RATE_HZ
time = np.arange(RATE) / RATE
pressure = np.sqrt(2) * 0.02 * np.sin(2 * np.pi * 100 * time)  # 100 Hz, 0.02 Pa rms: 60 dB

levels = level.sound_levels(pressure, RATE)
print(f"LZeq {levels.level_db:.2f} dB, LAeq {levels.laeq_db:.2f} dB(A)")
print(f"A-weighting at 100 Hz: {float(weighting.a_weighting_db(100.0)):.2f} dB")
print(f"third octave of 100 Hz: {levels.third_octave_db['100']:.2f} dB")

with tempfile.TemporaryDirectory() as folder:
    file = Path(folder) / "tone.wav"
    file.write_bytes(wav.calibrated(pressure, "a tone of 100 Hz; 1.0 is 1 Pa"))
    samples, rate, _ = wav.read(file)
print(
    f"the WAV holds {len(samples)} samples at {rate} Hz, rms {np.sqrt(np.mean(samples**2)):.4f} Pa"
)
