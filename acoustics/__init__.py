"""Sound from a released power or a force: levels, spectra, weighting, uncertainty, WAVs, plots.

The package works on arrays and sample rates and knows nothing about contact. Public names, which
the stub `__init__.pyi` lists, are imported when they are first used, so ``import acoustics`` takes
no time.

>>> import numpy as np
>>> import acoustics
>>> tone = np.sqrt(2) * np.sin(2 * np.pi * 1000 * np.arange(48000) / 48000)  # 1 Pa rms
>>> round(acoustics.laeq_db(tone, 48000), 2)
93.98
"""

from importlib import import_module
from inspect import isfunction
from typing import Any

__distribution__ = "rolling-contact-noise"  # tells this package from others of its name

# Public names by the module that has them.
_NAMES = {
    "acoustics.audibility": ("Audibility", "audible_difference", "default_room_db", "room_noise"),
    "acoustics.bands": (
        "BAND_NAMES",
        "EDGES_HZ",
        "MID_HZ",
        "band_uncertainty_db",
        "reliable",
        "third_octave_mean_square",
    ),
    "acoustics.impulsiveness": (
        "BandPulses",
        "Kurtogram",
        "band_pulses",
        "kurtogram",
        "pulse_kurtogram",
    ),
    "acoustics.level": (
        "SoundLevels",
        "is_single_event",
        "lae_db",
        "laeq_db",
        "level_db",
        "sound_levels",
    ),
    "acoustics.modulation": (
        "EnvelopeSpectrum",
        "envelope_spectrum",
        "loudest_octave",
        "modulated_octave",
    ),
    "acoustics.radiation": ("I_REF_W_M2", "P_REF_PA", "RHO_C", "intensity", "sound_pressure"),
    "acoustics.ring_velocity": (
        "VELOCITY_BANDS_HZ",
        "NarrowSpectrum",
        "VelocityBands",
        "narrow_spectrum",
        "squared_envelope_spectrum",
        "velocity_bands",
    ),
    "acoustics.room": ("in_room",),
    "acoustics.spectrum": ("Psd", "line_spectrum", "welch"),
    "acoustics.uncertainty": (
        "LevelUncertainty",
        "kurtosis",
        "kurtosis_uncertainty",
        "level_uncertainty",
    ),
    "acoustics.vibration_level": (
        "REFERENCES",
        "VibrationLevels",
        "velocity_of",
        "vibration_levels",
    ),
    "acoustics.weighting": ("a_weighting_db",),
}
_SUBMODULES = {
    "plots": "acoustics.plots",
    "wav": "acoustics.wav",
}
_HOMES = {name: home for home, names in _NAMES.items() for name in names}

__all__ = sorted([*_HOMES, *_SUBMODULES])


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used; a function ignores underflow from here on."""
    if name in _SUBMODULES:
        return import_module(_SUBMODULES[name])
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    if isfunction(value):
        value = import_module(f"{__name__}.traps").ignoring_underflow(value)
        value.__module__ = __name__  # where pickle finds it
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """List the public names, for completion."""
    return sorted({*globals(), *__all__})
