"""Doubts about the numbers of a run after it: rules, each with its sentence.

Some stand beside every level, others are warnings, and the errors of the level are known or
unknown. The worst of them is the verdict.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from acoustics.bands import BAND_NAMES, MID_HZ, OFF_DB
from acoustics.numbers import decibels_a, rounded, rounded_up, si
from rolling.check import findings, resolution
from rolling.dynamics.ball_on_plate import BENT
from rolling.dynamics.comb import COMB_MOST_DB, NEAR_SPEEDS
from rolling.marches.result import MovingRelease
from rolling.numbers.ball_numbers import RunNumbers, Source
from rolling.numbers.doubt import Doubt, Severity, sized
from rolling.numbers.quantity import RELEASED_POWER, VIBRATION, BandQuantity, joined
from rolling.results import notes
from rolling.results.instrument_spread import part_of_instrument
from rolling.results.run_errors import total_errors_db
from rolling.results.run_quantities import loses_contact_in_estimate
from rolling.scene.scene import Scene
from rolling.sound.contact_sound import ContactSound, solver_doubt
from rolling.sound.radiators import HALF, UNKNOWN_LOSS
from rolling.sound.vibration_sound import Vibration

MAX_OUTSIDE = 0.1  # share of the time with an extrapolated force, which counts as 3 dB
# Level of a half-space's pressure on the axis over the true level [dB] by frequency times distance
# [Hz m]; below, the first error is the least.
_NEAR_HALF_SPACE = (100.0, 13.5), (1e3, 5.2), (5e3, 1.4), (1e4, 0.5)
_ROUNDING = 1e-6  # share of a variance
_NEAR = f"{100 * NEAR_SPEEDS:g} %"

# Errors of the level, which the verdict weighs. They are in ± or have numbers of their own, so that
# no list of warnings repeats them.
ERRORS = (
    resolution.LEVEL_KEY,
    "record_length",
    "comb_spread",
    "time_step",
    "contact_loss",
    "baffle",
    "uncertainty_together",
    "solver_error",
    "force_law_error",
    "subgrid",
    "instrument",
    "vibration_estimate",
)
# Doubts about a vibration before it is computed, which its own numbers replace.
_FORECASTS = ("force_ratio", "impacts_yield", "comb")


def doubts(
    scene: Scene,
    sound: ContactSound,
    numbers: RunNumbers,
    vibration: Vibration | None = None,
    moving: MovingRelease | None = None,
) -> list[Doubt]:
    """List the doubts about the numbers of a run.

    scene : Scene. A scene without a sweep.
    sound : ContactSound. The sound of the run.
    numbers : RunNumbers. Its numbers, without doubts.
    vibration : Vibration. Vibration of sphere and plate. Default: the run has none.
    moving : MovingRelease. The release under the moving load, or its failure. Default: none.
    """
    plays = VIBRATION if numbers.record.source == "vibration" else RELEASED_POWER
    listed = [
        *notes.rules(scene, sound, numbers, vibration, moving),
        *_force(numbers, vibration),
        *_scene(scene, sound, numbers, vibration),
        *_about(plays, _estimate_of_errors(scene, sound, numbers)),
        *_motion(scene, numbers, vibration),
        *_comb_mean(sound, vibration),
        *_about(RELEASED_POWER, _solver(scene, sound)),
        *_played_level(numbers),
    ]
    if numbers.of_record.laeq_db is not None:
        listed += _about(plays, [*_spread(numbers), *_errors(scene, numbers)])
    # What was measured replaces what a rule for the scene expects.
    return [*{doubt.key: doubt for doubt in listed}.values(), *silent_vibration_doubts(numbers)]


def _about(quantity: str, listed: Iterable[Doubt]) -> list[Doubt]:
    """Return doubts that touch one of the two numbers only, or less."""
    return [replace(doubt, about=doubt.about or (quantity,)) for doubt in listed]


# ---- limits of scene and motion


def _scene(
    scene: Scene, sound: ContactSound, numbers: RunNumbers, vibration: Vibration | None
) -> Iterator[Doubt]:
    """Yield the doubts of the check that still hold after the run, with what was measured since.

    A measured error of the grid, or a computed force, stands for its estimate before the run.
    """
    is_measured = numbers.errors.grid_db is not None
    bands = numbers.bands.vibration_a
    for doubt in findings.scene_rules(scene):
        if not isinstance(doubt, Doubt) or doubt.severity is Severity.REFUSED:
            continue
        if is_measured and doubt.key in resolution.GRID_RULES:
            continue
        if vibration is not None and doubt.key in _FORECASTS:
            continue
        band_db = band_error_db(numbers)
        end_hz = numbers.errors.band_end_hz
        if doubt.key == "nyquist" and band_db is not None and end_hz is not None:
            cut_off = band_text(numbers, end_hz)
            yield sized(doubt.key, cut_off, band_db, doubt.advice)
        elif doubt.key == "half_space_sound":
            yield _half_space(doubt, scene, bands)
        elif doubt.key == "resonance":
            yield replace(doubt, about=(RELEASED_POWER,))
        else:
            yield doubt


def _half_space(doubt: Doubt, scene: Scene, bands: BandQuantity | None) -> Doubt:
    """Size the doubt about a half-space's sound by its third octaves; none of a release."""
    if bands is None:
        return replace(doubt, severity=Severity.TRUST)
    error = _half_space_error_db(bands.by_name, scene.sound.distance_m)
    text = f"the sound of the half-space is up to {rounded(error)} dB too loud so near"
    return sized(doubt.key, text, error, doubt.advice)


def _half_space_error_db(bands: Mapping[str, float | None], distance: float) -> float:
    """Return how far the A-weighted bands [dB] of a half-space are too loud at a distance [m]."""
    places, errors = np.array(_NEAR_HALF_SPACE).T
    levels = np.array([-np.inf if bands[name] is None else bands[name] for name in BAND_NAMES])
    power = 10 ** (levels / 10)
    true = power * 10 ** (-np.interp(np.log(MID_HZ * distance), np.log(places), errors) / 10)
    return 10 * math.log10(power.sum() / true.sum()) if true.sum() else 0.0


def _force(numbers: RunNumbers, vibration: Vibration | None) -> Iterator[Doubt]:
    """Yield the limits of the force law: impacts that yield, extrapolated forces, flights."""
    if vibration is None:
        return
    motion = vibration.motion
    if numbers.motion is not None and numbers.motion.impacts_yield:
        text = "impacts would yield, and the force law gives their work back"
        yield Doubt("impacts_yield", text, Severity.DO_NOT_QUOTE)
    if motion.outside_share > 0:
        least, *_, most = vibration.law.load_n
        yield sized(
            "force_outside",
            f"the contact force is extrapolated for {rounded(100 * motion.outside_share)} % of "
            "the time",
            3.0 * motion.outside_share / MAX_OUTSIDE,
            f"it leaves the marched loads of {rounded(least, 3)} to {rounded(most, 3)} N",
        )
    if motion.flight_share > 0:
        count = "1 impact" if motion.impacts == 1 else f"{motion.impacts} impacts"
        advice = ""
        if motion.flight_share == 1:
            advice = "the record is shorter than a flight; choose a longer one"
        text = (
            f"contact is lost for {rounded(100 * motion.flight_share)} % of the time, with {count}"
        )
        scatter = numbers.record.scatter_db
        is_fall = numbers.motion is not None and numbers.motion.drop_mm is not None
        if is_fall:  # one event, whose flights are no error of its level
            severity = Severity.NOTE if motion.impacts else Severity.INDICATIVE
            yield Doubt("impacts", text, severity, advice=advice)
        elif scatter is None:
            yield Doubt("impacts", text, Severity.INDICATIVE, advice=advice)
        else:
            yield sized("impacts", text, scatter, advice, least=Severity.INDICATIVE)


def _motion(scene: Scene, numbers: RunNumbers, vibration: Vibration | None) -> Iterator[Doubt]:
    """Warn of a motion that does not repeat, and of a plate that bends too far."""
    if vibration is None:
        return
    motion = vibration.motion
    thickness = scene.plate.thickness_mm
    may_repeat = not (scene.is_smooth or scene.is_one_event)
    if scene.track.closed and not motion.settled and may_repeat:
        text = "motion: it does not repeat from lap to lap, so its record does not loop"
        if motion.flight_share > 0:
            text += "; impacts need not repeat"
        elif len(scene.plate.contact_ends_mm) > 1:
            text += "; the contact moves on the plate"
        elif scene.motion.is_constant(scene.duration):
            text += "; it has not run in, so another record may have another level"
        scatter = numbers.record.scatter_db
        if scatter is None:
            yield Doubt("not_settled", text, Severity.INDICATIVE)
        else:  # another record differs as the parts of this one do
            yield sized("not_settled", text, scatter, least=Severity.INDICATIVE)
    if thickness is None:
        return
    bent = float(1e3 * np.ptp(motion.plate_m) / thickness)
    if bent > BENT:
        yield Doubt(
            "plate_deflection",
            f"plate: it sinks and rises by {rounded(bent)} of its thickness; thin-plate theory "
            f"wants a deflection that is small against it, at most about {BENT:g}",
            Severity.INDICATIVE,
        )


def _comb_mean(sound: ContactSound, vibration: Vibration | None) -> Iterator[Doubt]:
    """Explain that LAeq is the mean over the comb, and how loud the record itself is."""
    if vibration is None or sound.source != "vibration" or not vibration.is_mean_of_comb:
        return
    spread = vibration.spreads["comb"]
    record = decibels_a(vibration.levels.laeq_db)
    yield Doubt(
        "comb_mean",
        "comb: one undamped resonance decides the level of so short a track, so the LAeq that is "
        f"stated is the mean over speeds within {_NEAR} and ± is the spread over them, "
        f"{spread:.1f} dB; sound files, third octaves and the other levels belong to the one speed "
        f"of the record, whose LAeq is {record} (numbers.record.laeq_db)",
        Severity.TRUST,
    )


def _solver(scene: Scene, sound: ContactSound) -> Iterator[Doubt]:
    """Warn of a fluctuation of the release that the tolerance of the solver hides."""
    if sound.source == "release" and not scene.is_smooth:
        hidden = solver_doubt(scene.tolerance, sound.audible_rms, sound.resolved_rms)
        if hidden:
            yield Doubt("solver", f"solver: {hidden}", Severity.INDICATIVE)


# ---- errors of the level


def _estimate_of_errors(scene: Scene, sound: ContactSound, numbers: RunNumbers) -> Iterator[Doubt]:
    """Warn of the error estimate: of its absence, its reach, and bands that are off."""
    errors = numbers.errors
    if not errors.is_asked:
        return
    if errors.reason is not None:
        text = f"error estimate: none, because {errors.reason}"
        yield Doubt("no_error_estimate", text, Severity.TRUST)
        return
    if sound.source == "release" and errors.grid_signal_db is not None:
        spread = errors.grid_signal_uncertainty_db
        spread = math.nan if spread is None else spread
        source = f"measured within {spread:.0f} dB by the error estimate"
        of_level = _grid(scene, numbers)
        yield from resolution.too_coarse(scene, errors.grid_signal_db, source, of_level)
    if scene.height_paths:
        yield Doubt(
            "unknown_detail",
            "nothing is known of the surface below its spacing",
            Severity.INDICATIVE,
            advice="the error of the missing heights is in no number",
        )
    worst = errors.worst_uncertainty_db
    worst = math.inf if worst is None else worst
    if worst > OFF_DB:
        yield notes.note(
            "error_estimate_reach",
            f"error estimate: its standard errors for third octaves reach {worst:.1f} dB between 1 "
            "and 16 kHz",
        )
    grid = numbers.bands.grid_error
    spreads = {} if grid is None else grid.uncertainty_by_name
    bands = ", ".join(
        f"{name} Hz ({error:+.1f})"
        for name, error in total_errors_db(numbers).items()
        if error is not None and abs(error) > OFF_DB + (spreads[name] or 0.0)
    )
    if bands:
        yield Doubt(
            "band_errors",
            f"grid and solver: third octaves off by more than {OFF_DB:g} dB: {bands}; "
            f"{resolution.finer(scene)} brings them down",
            Severity.TRUST,
        )


def _played_level(numbers: RunNumbers) -> Iterator[Doubt]:
    """Yield the doubt about a sound that does not play at the level that is stated."""
    sound = numbers.heard
    if sound is None or sound.gain_db == sound.departure_db:
        return
    quantity = VIBRATION if sound.source == "vibration" else RELEASED_POWER
    size = abs(sound.departure_db)
    where = "below" if sound.departure_db > 0 else "above"
    yield Doubt(
        "played_level",
        f"what plays lies {size:.1f} dB {where} the level that is stated, more than its ±",
        Severity.TRUST,
        decibels=size,
        advice="compare by the numbers, not by ear; a longer track brings both together",
        about=(quantity,),
    )


def silent_vibration_doubts(numbers: RunNumbers) -> list[Doubt]:
    """Return the doubts about a vibration that does not play, computed or by a linear chain."""
    if numbers.record.source == "vibration" or numbers.vibration.value is None:
        return []
    listed = [*_computed(numbers), *_estimate(numbers)]
    if numbers.surface.instrument is not None:
        listed.append(instrument(numbers, "vibration"))
    return _about(VIBRATION, listed)


def _computed(numbers: RunNumbers) -> Iterator[Doubt]:
    """Yield the doubts about a vibration that is computed while the release is measured."""
    parts = numbers.vibration.parts
    if numbers.motion is None or not parts:  # runs of version 0.8 have no ± of it
        return
    spread = joined(parts, left_out=("force_law",))
    yield from _parts_of_spread(numbers, [*_of_motion(numbers)], spread)
    yield from _force_law_error(numbers)
    yield resolution.grid_of_silent_vibration()


def _estimate(numbers: RunNumbers) -> Iterator[Doubt]:
    """Yield the doubt about a vibration that a linear chain estimates."""
    estimate = numbers.estimate
    if estimate is None or numbers.vibration.value is None:
        return
    if loses_contact_in_estimate(numbers):
        text = "it is estimated too high, because the ball would lose contact"
        yield Doubt("vibration_estimate", text, Severity.DO_NOT_QUOTE)
        return
    text = f"a linear chain estimates it for {estimate.bodies}"
    parts = numbers.vibration.parts
    if not parts:
        yield Doubt("vibration_estimate", text, Severity.INDICATIVE)
        return
    spread = joined(parts, left_out=("instrument",))
    yield sized("vibration_estimate", text, spread, least=Severity.INDICATIVE)


def _spread(numbers: RunNumbers) -> Iterator[Doubt]:
    """Yield the parts of ±: length and comb of the record, time steps, contact loss, baffle."""
    # A release has no comb and no motion.
    of_motion = [*_of_motion(numbers)] if numbers.record.source == "vibration" else []
    spreads = numbers.of_record.spreads
    yield from _parts_of_spread(numbers, of_motion, None if spreads is None else spreads.laeq_db)


def _of_motion(numbers: RunNumbers) -> Iterator[Doubt]:
    """Yield the parts of the ± of a vibration beside the length of its record."""
    yield from _comb_spread(numbers)
    yield from _time_step(numbers)
    yield from _contact_loss(numbers)
    yield from _baffle(numbers)


def _parts_of_spread(
    numbers: RunNumbers, of_motion: Sequence[Doubt], spread: float | None
) -> Iterator[Doubt]:
    """Yield the parts of a ± [dB], what the length of the record adds, and all of them together."""
    parts = [*of_motion]
    yield from parts
    if spread is None:
        return
    # Length and comb overlap, so the length counts as what it leaves beyond the comb.
    rest = spread**2 - sum(part.decibels**2 for part in parts if part.decibels)
    if rest > _ROUNDING * spread**2:
        size = math.sqrt(rest)
        text = f"the length of the record leaves ± {rounded(size)} dB"
        parts.append(sized("record_length", text, size))
        yield parts[-1]
    names = "length, comb, time steps and loss of the contact"
    if numbers.motion is not None and numbers.motion.baffle_db:
        names = "length, comb, time steps, loss of the contact and the missing baffle"
    text = f"{names} together leave ± {rounded(spread)} dB"
    together = sized("uncertainty_together", text, spread)
    if all(together.severity > part.severity for part in parts):
        yield together


def _comb_spread(numbers: RunNumbers) -> Iterator[Doubt]:
    """Yield how far a level depends on the place of a sharp resonance among lines of a lap."""
    spread = None if numbers.motion is None else numbers.motion.comb_spread_db
    if spread is None:
        return
    text = (
        f"the track is short, so a sharp resonance makes LAeq differ by {rounded_up(spread)} dB "
        "(rms) between near speeds; contact damping or a longer track helps"
    )
    if spread > COMB_MOST_DB:
        text = (
            "the track is so short that one undamped resonance decides the level: at speeds within "
            f"{_NEAR} LAeq lies {rounded(spread)} dB (rms) from the mean that is stated"
        )
    yield sized("comb_spread", text, spread)


def _time_step(numbers: RunNumbers) -> Iterator[Doubt]:
    """Yield the error of the time steps of a motion."""
    error = None if numbers.motion is None else numbers.motion.step_error_db
    if error is not None:
        text = f"the time steps of the motion leave {rounded(abs(error))} dB"
        yield sized("time_step", text, error)


def _contact_loss(numbers: RunNumbers) -> Iterator[Doubt]:
    """Yield how far a loss factor of the contact, which the scene does not state, may matter."""
    change = numbers.contact_loss_db
    if change:
        size = HALF * abs(change)
        text = (
            "the damping of the contact is unknown (a loss factor of 0 is taken, up to"
            f" {UNKNOWN_LOSS:g} is usual), which leaves {rounded(size)} dB"
        )
        advice = "measure it, and give plate.contact_loss_factor"
        yield sized("contact_loss", text, size, advice=advice)


def _baffle(numbers: RunNumbers) -> Iterator[Doubt]:
    """Yield what the baffle of the computation leaves on the level of a free plate."""
    size = None if numbers.motion is None else numbers.motion.baffle_db
    if size:
        text = (
            "a free plate is computed as in a baffle, which it does not have; this leaves "
            f"{rounded_up(size)} dB"
        )
        yield sized("baffle", text, size)


def _errors(scene: Scene, numbers: RunNumbers) -> Iterator[Doubt]:
    """Yield the errors of solver, force law, grid and missing detail, known or unknown."""
    solver = numbers.errors.solver_db
    if solver is not None:
        yield sized("solver_error", f"the solver leaves {rounded(abs(solver))} dB", solver)
    if numbers.record.source == "vibration":
        yield from _force_law_error(numbers)
    yield _grid(scene, numbers)
    errors = numbers.errors
    detail = _whole_error(errors.subgrid_db, errors.subgrid_uncertainty_db)
    if detail is not None:
        text = f"the surface below its spacing changes LAeq by up to {rounded(detail)} dB"
        yield sized("subgrid", text, detail)
    if numbers.surface.instrument is not None:
        yield instrument(numbers, numbers.record.source)


def instrument(numbers: RunNumbers, source: Source) -> Doubt:
    """Return what the instrument of a measurement leaves of the level of a source.

    Raises
    ------
    ValueError : the run has no instrument.
    """
    seen = numbers.surface.instrument
    if seen is None:
        raise ValueError("the run has no instrument")
    cutoff = si(seen.cutoff_m, "m")
    of_source = part_of_instrument(numbers.surface, source)
    part = None if of_source is None else of_source.spread_db
    if part is None:
        text = f"what the measuring instrument did not see below {cutoff} leaves an unknown error"
        if seen.reason:
            text += f", because {seen.reason}"
        return Doubt("instrument", text, Severity.INDICATIVE)
    size = rounded_up(part)
    if seen.limit == "noise":
        share = rounded(100 * (seen.noise_over_sq or 0.0))
        text = (
            f"noise of the measuring instrument, {si(seen.noise_m or 0.0, 'm')} rms or {share} % "
            f"of Sq, and the waves below {cutoff} that it hides change the level by up to {size} dB"
        )
    else:
        text = (
            f"waves below {cutoff}, which the measuring instrument did not see, leave up to {size} "
            "dB"
        )
    return sized("instrument", text, part)


def _force_law_error(numbers: RunNumbers) -> Iterator[Doubt]:
    """Yield the error that the force law leaves in the level of a vibration."""
    law = None if numbers.motion is None else numbers.motion.force_law_error_db
    if law is not None:
        yield sized("force_law_error", f"the force law leaves {rounded(abs(law))} dB", law)


def _grid(scene: Scene, numbers: RunNumbers) -> Doubt:
    """Return the error that the grid leaves in the level: measured, by a rule, or unknown."""
    errors = numbers.errors
    error = _whole_error(errors.grid_db, errors.grid_uncertainty_db)
    if error is not None:
        text = f"the grid leaves up to {rounded(error)} dB"
        return sized(resolution.LEVEL_KEY, text, error)
    return resolution.grid_of_level(scene, errors.reason)


def band_error_db(numbers: RunNumbers) -> float | None:
    """Return what the steps cut off of LAeq, joined with its uncertainty [dB]; None: unknown."""
    return _whole_error(numbers.errors.band_db, numbers.errors.band_uncertainty_db)


def band_text(numbers: RunNumbers, highest_hz: float) -> str:
    """State what the end of the simulated band [Hz] does to LAeq."""
    error = numbers.errors.band_db or 0.0
    spread = numbers.errors.band_uncertainty_db or 0.0
    size = f"{rounded(abs(error))} ± {rounded(spread)} dB"
    end = si(highest_hz, "Hz")
    if error > 0:
        return f"the steps do not resolve sound above {end}, which makes LAeq about {size} too high"
    return f"the steps cut off sound above {end}, and LAeq is about {size} too low"


def _whole_error(error_db: float | None, spread_db: float | None) -> float | None:
    """Return an error joined with its uncertainty [dB], None where it is unknown."""
    return None if error_db is None else math.hypot(error_db, spread_db or 0.0)
