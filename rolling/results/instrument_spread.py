"""What the instrument of a measurement leaves uncertain of the two numbers of a run.

Stretches are marched twice: as measured, and with the law of the spectrum in place of the waves
that the instrument does not see. The difference of the levels is the error of the measured surface,
as far as the law holds. tests/benchmarks/instrument_study.py compares it with known surfaces.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array
from rolling.check import error_cost
from rolling.in_si.assumed_bodies import with_bodies
from rolling.in_si.physics_of_scene import bodies_of, listener_of
from rolling.in_si.scene_surface import scene_surface
from rolling.marches import error_stretches
from rolling.marches.result import Result
from rolling.numbers.ball_numbers import (
    InstrumentNumbers,
    InstrumentOfSource,
    Source,
    SurfaceNumbers,
)
from rolling.numbers.quantity import BandQuantity
from rolling.results.run_errors import known, known_bands, not_linear
from rolling.results.solved_run import SolvedRun
from rolling.scene.scene import Scene
from rolling.sound.error_estimate import refinement_factor, replaced_errors
from rolling.sound.radiators import roughness_gain

# Order by which missing detail converges on finer grids, as in `error_estimate.detail_errors`.
ORDER = 1.0
# Standard uncertainty of an error over the error, because the law is a guess. A ball does more than
# lose waves: it rounds peaks and sharpens valleys. Its errors of the released power exceeded those
# of lost waves 1.3 to 2.3 times on five surfaces of tests/benchmarks/instrument_study.py.
DOUBT = 0.5
TIP_DOUBT = 1.0
LEAST_DB = 0.01  # standard uncertainty of an error that is hardly there


class LevelSpread(NamedTuple):
    """Error that an instrument leaves in a level, and its standard uncertainty.

    An error is the level over the measured surface less that over the true one. Both arrays hold
    the third octaves and LAeq at their end [dB]; NaN: unknown.
    """

    error_db: Array
    uncertainty_db: Array

    @property
    def spread_db(self) -> Array:
        """Standard uncertainty of the levels as they are stated, without a correction [dB]."""
        return np.hypot(self.error_db, self.uncertainty_db)


class InstrumentSpread(NamedTuple):
    """What an instrument leaves uncertain of the vibration and of the released power.

    vibration, released_power : LevelSpread or None. None where it is unknown.
    reason : str. Why one of them is unknown; empty where both are known.
    """

    vibration: LevelSpread | None
    released_power: LevelSpread | None
    reason: str


def instrument_spread_db(run: SolvedRun) -> InstrumentSpread | None:
    """Return the error that the instrument of a measurement leaves in the two numbers of a run.

    Parameters
    ----------
    run : SolvedRun
        A run over a file of heights.

    Returns
    -------
    InstrumentSpread, or None
        Errors of LAeq and of the third octaves [dB], of the vibration and of the released power,
        with their standard uncertainties; `spread_db` of either joins both. None where the scene
        states no `surface.instrument`.
    """
    scene = run.scene
    if not error_cost.has_instrument(scene):
        return None
    reason = _reason(scene, run.result)
    if reason:
        return InstrumentSpread(vibration=None, released_power=None, reason=reason)
    of_vibration = None
    if run.vibration_sound is not None:
        reason = not_linear(run.vibration_sound)
    if not reason:
        of_vibration = _level_spread(scene, run.result, "vibration", own_factor=False)
    own_factor = scene.sound.gain_pa_per_w_m2 is None
    of_release = _level_spread(scene, run.result, "release", own_factor)
    return InstrumentSpread(of_vibration, of_release, reason)


def _level_spread(
    scene: Scene, result: Result, source: str, own_factor: bool
) -> LevelSpread | None:
    """Return the spread of the levels of a source."""
    powers = error_stretches.instrument_powers(scene, result, source)
    if powers is None or not powers.groups:
        return None
    factor = refinement_factor(ORDER) if error_cost.needs_finer_grid(scene) else 1.0
    gain = None
    if source == "vibration":
        described = scene if scene.dynamics is not None else with_bodies(scene)
        bodies = bodies_of(described)
        gain = roughness_gain(bodies, listener_of(described), bodies.smooth_chain)
    error, spread = replaced_errors(powers, own_factor, factor, gain)
    if not math.isfinite(error[-1]):
        return None
    seen = scene_surface(scene).seen
    doubt = TIP_DOUBT if seen is not None and seen.limit == "tip" else DOUBT
    return LevelSpread(
        error_db=error,
        uncertainty_db=np.sqrt(spread**2 + (doubt * error) ** 2 + LEAST_DB**2),
    )


def _reason(scene: Scene, result: Result) -> str:
    """Explain why stretches do not tell what an instrument leaves uncertain; empty if they do."""
    seen = scene_surface(scene).seen
    if scene.is_permanent:
        return "the stretches have no earlier passes over a plate that remembers"
    if scene.sphere.surface is not None:
        return "the short waves of the sphere's own surface are not those of the file"
    if seen is None or seen.law is None:
        return "the spectrum above the cut-off is too short for a law"
    layout = error_cost.instrument_layout(scene)
    if layout is None:
        least = error_cost.INSTRUMENT_STRETCHES * error_cost.MIN_STEPS
        return f"the track has {scene.track.solved_steps} different steps, and {least} are needed"
    stretches = result.stretches
    if stretches is None or not set(layout.marches) <= set(stretches.marches):
        return "its stretches are not marched"
    reasons = [stretches.marches[key].failure for key in layout.marches]
    failures = [reason for reason in reasons if reason]
    return f"a stretch could not be solved: {failures[0]}" if failures else ""


# ---- numbers


def instrument_numbers(run: SolvedRun) -> InstrumentNumbers | None:
    """Return what an instrument sees and leaves uncertain; None without one."""
    spread = instrument_spread_db(run)
    seen = scene_surface(run.scene).seen
    if spread is None or seen is None:
        return None
    return InstrumentNumbers(
        cutoff_m=seen.cutoff,
        limit=seen.limit,
        tip_cutoff_m=seen.tip_cutoff or None,
        sampling_cutoff_m=seen.sampling_cutoff,
        noise_cutoff_m=seen.noise_cutoff or None,
        law=None if seen.law is None else seen.law.words,
        noise_m=seen.noise or None,
        noise_recognized=seen.noise_is_recognized,
        noise_over_sq=seen.noise_share or None,
        reason=spread.reason or None,
        vibration=_of_source(spread.vibration),
        released_power=_of_source(spread.released_power),
    )


def _of_source(level: LevelSpread | None) -> InstrumentOfSource | None:
    """Return what an instrument leaves uncertain of a source; None where it is unknown."""
    if level is None:
        return None
    return InstrumentOfSource(
        error_db=known(float(level.error_db[-1])),
        spread_db=known(float(level.spread_db[-1])),
        bands=BandQuantity.of(known_bands(level.spread_db[:-1]), "dB"),
    )


def part_of_instrument(numbers: SurfaceNumbers, source: Source) -> InstrumentOfSource | None:
    """Return what an instrument leaves uncertain of a source; None without it, or unknown."""
    instrument = numbers.instrument
    if instrument is None:
        return None
    return instrument.vibration if source == "vibration" else instrument.released_power
