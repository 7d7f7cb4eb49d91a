"""Sound from a released power or a force: levels, spectra, weighting, uncertainty, WAVs, plots.

The package works on arrays and sample rates and knows nothing about contact. Every name below is
imported when it is first used, so ``import acoustics`` takes no time.

>>> import numpy as np
>>> import acoustics
>>> tone = np.sqrt(2) * np.sin(2 * np.pi * 1000 * np.arange(48000) / 48000)  # 1 Pa rms
>>> round(acoustics.laeq_db(tone, 48000), 2)
93.98
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

__distribution__ = "rolling-contact-noise"  # tells this package from others of its name

if TYPE_CHECKING:
    from acoustics import plots, wav
    from acoustics.bands import (
        BAND_NAMES,
        EDGES_HZ,
        MID_HZ,
        band_uncertainty_db,
        reliable,
        third_octave_mean_square,
    )
    from acoustics.level import SoundLevels, laeq_db, level_db, sound_levels
    from acoustics.modulation import (
        EnvelopeSpectrum,
        envelope_spectrum,
        loudest_octave,
        modulated_octave,
    )
    from acoustics.radiation import I_REF_W_M2, P_REF_PA, RHO_C, intensity, sound_pressure
    from acoustics.spectrum import Psd, line_spectrum, welch
    from acoustics.uncertainty import (
        LevelUncertainty,
        kurtosis,
        kurtosis_uncertainty,
        level_uncertainty,
    )
    from acoustics.weighting import a_weighting_db

__all__ = [
    "BAND_NAMES", "EDGES_HZ", "I_REF_W_M2", "MID_HZ", "P_REF_PA", "RHO_C", "EnvelopeSpectrum",
    "LevelUncertainty", "Psd", "SoundLevels", "a_weighting_db", "band_uncertainty_db",
    "envelope_spectrum", "intensity", "kurtosis", "kurtosis_uncertainty", "laeq_db", "level_db",
    "level_uncertainty", "line_spectrum", "loudest_octave", "modulated_octave", "plots", "reliable",
    "sound_levels", "sound_pressure", "third_octave_mean_square", "wav", "welch",
]  # fmt: skip

_SUBMODULES = ("plots", "wav")
_MODULES = (
    *("bands", "level", "modulation"),
    *("radiation", "spectrum", "uncertainty", "weighting"),
)


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used."""
    if name in _SUBMODULES:
        return import_module(f"{__name__}.{name}")
    if name in __all__:
        for module in _MODULES:
            names = vars(import_module(f"{__name__}.{module}"))
            if name in names:
                globals()[name] = names[name]
                return names[name]
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    """List the public names, for completion."""
    return sorted({*globals(), *__all__})
