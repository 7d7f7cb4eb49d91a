"""What is the level of a record of my own? Levels, third octaves and a WAV without a contact."""

import tempfile
from pathlib import Path

import numpy as np

import acoustics

RATE = acoustics.wav.SAMPLE_RATE_HZ
time = np.arange(RATE) / RATE
pressure = np.sqrt(2) * 0.02 * np.sin(2 * np.pi * 100 * time)  # 100 Hz, 0.02 Pa rms: 60 dB

levels = acoustics.sound_levels(pressure, RATE)
weighting = float(acoustics.a_weighting_db(100.0))
print(
    f"The tone has {levels.level_db:.1f} dB, and A-weighted {levels.laeq_db:.1f} dB(A),"
    f" because the weighting takes {-weighting:.1f} dB away at 100 Hz."
)
print(f"Its third octave at 100 Hz holds {levels.third_octave_db['100']:.1f} dB.")

with tempfile.TemporaryDirectory() as folder:
    file = Path(folder) / "tone.wav"
    file.write_bytes(acoustics.wav.calibrated(pressure, "a tone of 100 Hz; 1.0 is 1 Pa"))
    samples, rate, _ = acoustics.wav.read(file)
rms = np.sqrt(np.mean(samples**2))
print(f"A calibrated WAV keeps it: {len(samples)} samples at {rate} Hz with {rms:.4f} Pa rms.")
