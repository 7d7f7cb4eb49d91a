"""Public names of `acoustics`, which `__init__.py` imports when they are first used."""

from acoustics import plots as plots
from acoustics import wav as wav
from acoustics.audibility import Audibility as Audibility
from acoustics.audibility import audible_difference as audible_difference
from acoustics.audibility import default_room_db as default_room_db
from acoustics.audibility import room_noise as room_noise
from acoustics.bands import BAND_NAMES as BAND_NAMES
from acoustics.bands import EDGES_HZ as EDGES_HZ
from acoustics.bands import MID_HZ as MID_HZ
from acoustics.bands import band_uncertainty_db as band_uncertainty_db
from acoustics.bands import reliable as reliable
from acoustics.bands import third_octave_mean_square as third_octave_mean_square
from acoustics.level import SoundLevels as SoundLevels
from acoustics.level import is_single_event as is_single_event
from acoustics.level import lae_db as lae_db
from acoustics.level import laeq_db as laeq_db
from acoustics.level import level_db as level_db
from acoustics.level import sound_levels as sound_levels
from acoustics.modulation import EnvelopeSpectrum as EnvelopeSpectrum
from acoustics.modulation import envelope_spectrum as envelope_spectrum
from acoustics.modulation import loudest_octave as loudest_octave
from acoustics.modulation import modulated_octave as modulated_octave
from acoustics.radiation import I_REF_W_M2 as I_REF_W_M2
from acoustics.radiation import P_REF_PA as P_REF_PA
from acoustics.radiation import RHO_C as RHO_C
from acoustics.radiation import intensity as intensity
from acoustics.radiation import sound_pressure as sound_pressure
from acoustics.ring_velocity import VELOCITY_BANDS_HZ as VELOCITY_BANDS_HZ
from acoustics.ring_velocity import NarrowSpectrum as NarrowSpectrum
from acoustics.ring_velocity import VelocityBands as VelocityBands
from acoustics.ring_velocity import narrow_spectrum as narrow_spectrum
from acoustics.ring_velocity import squared_envelope_spectrum as squared_envelope_spectrum
from acoustics.ring_velocity import velocity_bands as velocity_bands
from acoustics.spectrum import Psd as Psd
from acoustics.spectrum import line_spectrum as line_spectrum
from acoustics.spectrum import welch as welch
from acoustics.uncertainty import LevelUncertainty as LevelUncertainty
from acoustics.uncertainty import kurtosis as kurtosis
from acoustics.uncertainty import kurtosis_uncertainty as kurtosis_uncertainty
from acoustics.uncertainty import level_uncertainty as level_uncertainty
from acoustics.vibration_level import REFERENCES as REFERENCES
from acoustics.vibration_level import VibrationLevels as VibrationLevels
from acoustics.vibration_level import vibration_levels as vibration_levels
from acoustics.weighting import a_weighting_db as a_weighting_db

__distribution__: str
