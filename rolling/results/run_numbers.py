"""The numbers of a run, made once after its solve: an assignment for each field.

The fields stand in `rolling.numbers.ball_numbers`, with unit, meaning and format.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from acoustics import ears, loudness, uncertainty, wav
from acoustics.arrays import Array
from acoustics.level import crest_factor_db, is_single_event, lae_db, level_db
from acoustics.modulation import MIN_PERIODS, envelope_spectrum, modulated_octave
from acoustics.numbers import rounded
from rolling.check import height_findings
from rolling.dynamics import drop
from rolling.in_si.assumed_bodies import bodies_text
from rolling.in_si.physics_of_scene import bodies_of, listener_of, plate_of, smooth_contact_of
from rolling.in_si.scene_surface import SceneSurface, scene_surface
from rolling.marches import effort, marched_law
from rolling.marches.passes import Passes
from rolling.marches.result import Result, released_energy
from rolling.numbers.ball_numbers import (
    BandNumbers,
    ContactNumbers,
    EarNumbers,
    EffortNumbers,
    EnergyNumbers,
    EstimateNumbers,
    InstrumentNumbers,
    LevellingNumbers,
    LevelNumbers,
    LevelSpreads,
    ListenerLevels,
    ListeningNumbers,
    MadeSurfaceNumbers,
    MotionNumbers,
    PassNumbers,
    PreparationStep,
    RunNumbers,
    RunRecord,
    SourceLevels,
    SurfaceNumbers,
    TurnNumbers,
    WavelengthNumbers,
)
from rolling.numbers.quantity import BandQuantity
from rolling.results.description import runs_sentence
from rolling.results.estimated_vibration import (
    approach_of,
    contact_stiffness,
    linear_vibration,
    vibration_estimate,
)
from rolling.results.instrument_spread import instrument_numbers
from rolling.results.release_sound import shift_to_listener_db
from rolling.results.run_doubts import doubts
from rolling.results.run_errors import (
    error_bands,
    error_numbers,
    known,
    known_bands,
    run_errors,
)
from rolling.results.run_quantities import UNKNOWN, judged, with_quantities
from rolling.results.solved_run import SolvedRun
from rolling.results.stated_sound import playing_source, sound_to_listen, whole_vibration_db
from rolling.results.uncertainty_parts import parts_of_record, vibration_parts, with_band_parts
from rolling.scene.scene import Scene
from rolling.sound import radiators
from rolling.sound.contact_sound import ContactSound
from rolling.sound.missing_band import MissingBand, VibrationSource, missing_band
from rolling.sound.vibration_sound import P_REF_W, Vibration, by_band, compact_source_db
from rolling.surface import levelling

STEADY_S = 1.0  # [s] of a record that does not close, from which on its loudness is that of a tone
_ROUNDING_DB = 1e-6


def run_numbers(run: SolvedRun, release: ContactSound) -> RunNumbers:
    """Make the numbers of a run, with the sound of its release; levels of silence are None."""
    scene = run.scene
    result = run.result
    vibration = run.vibration_sound
    surface = scene_surface(scene)
    is_event = _is_event(run.sound)
    motion = None if vibration is None else _motion(run, vibration)
    stiffness = None if scene.dynamics is not None else contact_stiffness(scene, result)
    instrument = instrument_numbers(run)
    errors = run_errors(run)
    band = _missing_band(run)
    estimate = None
    contact_loss_db = 0.0
    of_estimate: dict[str, float | None] = {}
    if stiffness is not None:
        approach = approach_of(result, release)
        linear = linear_vibration(scene, approach, result.step, release.closed, stiffness)
        chain_estimate = vibration_estimate(linear, stiffness)
        contact_loss_db = chain_estimate.contact_loss_db
        of_estimate = dict(chain_estimate.parts_db)
        if instrument is not None and instrument.vibration is not None:
            of_estimate["instrument"] = instrument.vibration.spread_db
        estimate = EstimateNumbers(
            laeq_db=chain_estimate.laeq_db,
            force_ratio=chain_estimate.force_ratio,
            bodies=bodies_text(scene),
            stiffness_n_m=chain_estimate.stiffness_n_m,
        )
    elif vibration is not None:
        contact_loss_db = vibration.contact_loss_db
    numbers = RunNumbers(
        name=scene.name,
        sentence=runs_sentence([run]),
        vibration=UNKNOWN,
        released_power=UNKNOWN,
        record=_record(run, is_event),
        levels=_levels(run, release),
        bands=with_band_parts(
            error_bands(errors, _bands(run, release)), run, motion, instrument, errors
        ),
        errors=error_numbers(errors, band),
        energy=_energy(run, release),
        contact=_contact(scene, result),
        effort=_effort(scene, result),
        surface=_surface(run, surface, instrument),
        ears=_ears(run, is_event),
        turns=_turns(scene, surface, run.sound),
        motion=motion,
        estimate=estimate,
        contact_loss_db=contact_loss_db,
        channels=tuple(channel.numbers for channel in run.channels) or None,
        passes=None if result.passes is None else _passes(run, result.passes, stiffness),
        listening=_listening(run),
    )
    numbers = with_quantities(
        numbers,
        of_sound=parts_of_record(run, motion, instrument, band, errors),
        of_vibration=vibration_parts(run, motion, instrument),
        of_estimate=of_estimate,
        whole_vibration_db=whole_vibration_db(run, numbers),
    )
    playing = sound_to_listen(run, numbers, playing_source(run, numbers))
    numbers = replace(numbers, heard=playing.numbers)
    if estimate is not None and playing.source == "vibration":
        numbers = replace(numbers, bands=_with_estimate(numbers.bands, playing.along_track))
    moving = result.moving if scene.moves_release else None
    return judged(numbers, doubts(scene, run.sound, numbers, vibration, moving))


def _listening(run: SolvedRun) -> ListeningNumbers | None:
    """Return the numbers of the long record that a scene asks for."""
    if run.scene.sound.listen_s is None:
        return None
    return run.long.numbers if run.long else ListeningNumbers(refused=run.no_long)


# ---- record and levels


def _record(run: SolvedRun, is_event: bool) -> RunRecord:
    """Return what was solved, and the record of the sound files."""
    scene = run.scene
    sound = run.sound
    has_q = sound.source == "release" and scene.sound.gain_pa_per_w_m2 is None
    laps = run.result.steps / run.result.solved_steps
    vibration = run.vibration_sound
    if sound.source == "vibration" and not (vibration and vibration.motion.settled):
        laps = 1.0  # the motion does not repeat from lap to lap
    return RunRecord(
        source=sound.source,
        load_n=scene.load,
        steps=run.result.steps,
        duration_s=sound.duration,
        loops=sound.loops,
        single_event=is_event,
        highest_frequency_hz=sound.highest,
        laeq_db=run.record_laeq_db,
        crest_factor_db=crest_factor_db(sound.pressure),
        scatter_db=record_scatter(sound.pressure, laps),
        q=scene.sound.q if has_q else None,
        factor_pa_per_w_m2=sound.factor,
    )


def _is_event(sound: ContactSound) -> bool:
    """Tell whether a record is a fall or another single event; one that closes repeats."""
    if sound.once:
        return True
    return not sound.closed and is_single_event(sound.pressure, sound.sample_rate)


def _levels(run: SolvedRun, release: ContactSound) -> LevelNumbers:
    """Return the levels of both sources, and those beside a vibration."""
    scene = run.scene
    vibration = run.vibration_sound
    if vibration is None:
        return LevelNumbers(released_power=_levels_of_sound(run, run.sound))
    if run.sound.source == "vibration":
        of_vibration = _levels_of_sound(run, run.sound)
        of_release = _levels_beside(release)
    else:
        stated = vibration.stated_levels
        of_vibration = SourceLevels(laeq_db=stated.laeq_db, level_db=stated.level_db)
        of_release = _levels_of_sound(run, run.sound)
    shift = shift_to_listener_db(scene)
    at_listener = _shifted(release.levels.laeq_db, shift)
    difference, equal = _difference(scene, at_listener, of_vibration.laeq_db)
    compact_db = compact_source_db(bodies_of(scene), listener_of(scene), vibration)
    mean = _shifted(compact_db, _to_mean_db(vibration))
    has_edges = plate_of(scene.plate).with_edges is not None
    return LevelNumbers(
        vibration=of_vibration,
        released_power=of_release,
        released_power_at_listener_db=at_listener,
        released_power_z_at_listener_db=_shifted(release.levels.level_db, shift),
        release_over_vibration_db=difference,
        equivalent_q=equal,
        compact_source_level_db=None if has_edges else mean,
        hemisphere_mean_level_db=mean if has_edges else None,
        plate_power_level_db=_total(vibration.plate_power),
        ball_power_level_db=_total(vibration.ball_power),
        listeners=_listeners(scene, vibration),
    )


def _levels_of_sound(run: SolvedRun, sound: ContactSound) -> SourceLevels:
    """Return the levels of the record that is measured, with their uncertainty.

    An open record begins in silence. If it ends before the time weighting has risen to the LAeq of
    the record, its maximum with this weighting says how short it is, and nothing of the sound.
    """
    levels = sound.levels
    spreads = sound.uncertainty
    is_fast = not _is_below_laeq(run, levels.laf_max_db)
    is_slow = not _is_below_laeq(run, levels.las_max_db)
    return SourceLevels(
        laeq_db=levels.laeq_db,
        lae_db=lae_db(sound.pressure, sound.sample_rate),
        laf_max_db=levels.laf_max_db if is_fast else None,
        las_max_db=levels.las_max_db if is_slow else None,
        level_db=levels.level_db,
        lz_peak_db=levels.lz_peak_db,
        steady_level_db=sound.steady_level,
        spreads=LevelSpreads(
            laeq_db=spreads.laeq_db,
            level_db=spreads.level_db,
            laf_max_db=spreads.laf_max_db if is_fast and levels.laf_max_db is not None else None,
            las_max_db=spreads.las_max_db if is_slow and levels.las_max_db is not None else None,
            lz_peak_db=spreads.lz_peak_db,
            # LAE and LAeq differ by the duration, or by a comb that ± covers.
            lae_db=spreads.laeq_db,
            steady_level_db=sound.steady_uncertainty,
        ),
    )


def _levels_beside(release: ContactSound) -> SourceLevels:
    """Return the levels of a release that does not play."""
    return SourceLevels(
        laeq_db=release.levels.laeq_db,
        level_db=release.levels.level_db,
        steady_level_db=release.steady_level,
    )


def _is_below_laeq(run: SolvedRun, maximum_db: float | None) -> bool:
    """Tell whether a maximum with a time weighting lies below the LAeq of its record."""
    if maximum_db is None or run.record_laeq_db is None:
        return False
    return maximum_db < run.record_laeq_db - _ROUNDING_DB


def _difference(
    scene: Scene, release_db: float | None, vibration_db: float | None
) -> tuple[float | None, float | None]:
    """Return the release over the vibration [dB], and the q that makes them equal.

    Both levels belong to the place where the vibration is heard. The impacts of a fall compare with
    no release.
    """
    if release_db is None or vibration_db is None or not scene.has_release:
        return None, None
    difference = release_db - vibration_db
    if scene.sound.gain_pa_per_w_m2 is not None:
        return difference, None
    # The level of a release follows 10 lg q.
    return difference, scene.sound.q * 10 ** (-difference / 10)


def _listeners(scene: Scene, vibration: Vibration) -> tuple[ListenerLevels, ...] | None:
    """Return places and levels of the listeners of a plate with edges.

    Where LAeq is the mean over a comb, the others differ from it as their records do.
    """
    if scene.plate.edges_mm is None:
        return None
    to_mean_db = _to_mean_db(vibration)
    return tuple(
        ListenerLevels(
            at_mm=tuple(round(1e3 * x, 6) for x in place_m),
            laeq_db=_shifted(levels.laeq_db, to_mean_db),
            level_db=levels.level_db,
        )
        for place_m, levels in zip(scene.listeners, vibration.listener_levels(), strict=True)
    )


def _to_mean_db(vibration: Vibration) -> float:
    """Return the stated LAeq less that of the record [dB]; 0 unless it is the mean over a comb."""
    stated = vibration.stated_levels.laeq_db
    own = vibration.levels.laeq_db
    if stated is None or own is None:
        return 0.0
    return stated - own


def _shifted(level: float | None, shift_db: float) -> float | None:
    """Return a level [dB] with a shift added; None of silence."""
    return None if level is None else level + shift_db


def _total(power: Array) -> float | None:
    """Return the level of the bands together [dB re 1 pW]; None where all are unknown."""
    finite = power[np.isfinite(power)]
    return level_db(float(finite.sum()), P_REF_W) if len(finite) else None


# ---- bands


def _bands(run: SolvedRun, release: ContactSound) -> BandNumbers:
    """Return the third octaves of both sources, of powers and of the force."""
    scene = run.scene
    sound = run.sound
    levels = sound.levels
    spreads = sound.uncertainty.third_octave_db
    own = BandQuantity.of(levels.third_octave_db, "dB", spreads)
    own_a = BandQuantity.of(levels.third_octave_a_db, "dB(A)", spreads)
    vibration = run.vibration_sound
    if vibration is None:
        return BandNumbers(released_power=own, released_power_a=own_a)
    shift = shift_to_listener_db(scene)
    at_listener = {
        band: _shifted(level, shift) for band, level in release.levels.third_octave_db.items()
    }
    bands = BandNumbers(
        released_power=BandQuantity.of(release.levels.third_octave_db, "dB"),
        released_power_at_listener=BandQuantity.of(at_listener, "dB"),
        vibration=BandQuantity.of(
            vibration.stated_levels.third_octave_db, "dB", vibration.uncertainty.third_octave_db
        ),
        plate_power=BandQuantity.of(by_band(vibration.plate_power), "dB re 1 pW"),
        ball_power=BandQuantity.of(by_band(vibration.ball_power), "dB re 1 pW"),
        force=BandQuantity.of(known_bands(vibration.force_bands), "N"),
    )
    if sound.source == "vibration":
        return replace(bands, vibration=own, vibration_a=own_a)
    return replace(bands, released_power=own, released_power_a=own_a)


def _with_estimate(bands: BandNumbers, sound: ContactSound) -> BandNumbers:
    """Return third octaves with those of an estimated vibration; its ± is known of LAeq alone."""
    return replace(
        bands,
        vibration=BandQuantity.of(sound.levels.third_octave_db, "dB"),
        vibration_a=BandQuantity.of(sound.levels.third_octave_a_db, "dB(A)"),
    )


# ---- uncertainty


def record_scatter(pressure: Array, laps: float = 1.0) -> float | None:
    """Return the scatter of LAeq between thirds of the different laps of a record [dB]."""
    lap = pressure[: round(len(pressure) / max(1.0, laps))]
    return uncertainty.record_scatter_db(lap, wav.SAMPLE_RATE_HZ)


def _missing_band(run: SolvedRun) -> MissingBand | None:
    """Return the part of the sound that the Nyquist frequency of the steps cuts off."""
    scene = run.scene
    result = run.result
    listener = listener_of(scene)
    source = None
    if run.sound.source == "vibration":
        series = result.series["approach"]
        if run.vibration_sound is not None:
            chain = run.vibration_sound.chain
            gain = radiators.roughness_gain(bodies_of(scene), listener, chain)
            source = VibrationSource(run.vibration_sound, gain)
    else:
        series, _ = released_energy(scene, result)
    return missing_band(
        run.sound,
        lap=series[: result.solved_steps],
        step=result.step,
        motion=scene.motion,
        own_factor=listener.has_own_factor,
        source=source,
    )


# ---- ears and turns


def _ears(run: SolvedRun, is_event: bool) -> EarNumbers | None:
    """Compute loudness, roughness and tones of the sound if the scene requests loudness.

    A steady sound has one loudness. The loudness of falls, impacts and changing speeds, and that of
    a short record, has numbers of its course in time. Roughness and tones are None where a record
    is too short, and tones where none is found.
    """
    if not run.scene.sound.loudness:
        return None
    sound = run.sound
    numbers = EarNumbers(
        roughness_asper=ears.roughness_asper(sound.pressure, sound.sample_rate),
    )
    is_short = sound.duration < STEADY_S
    is_steady = _is_steady(run, is_event)
    if is_steady and (sound.closed or not is_short):  # a short record that closes is looped
        steady = loudness.loudness(sound.pressure, sound.sample_rate, sound.closed)
        numbers = replace(numbers, loudness_sone=steady.sone, sharpness_acum=steady.acum)
    if is_short or not is_steady:
        varying = loudness.varying_loudness(sound.pressure, sound.sample_rate, sound.closed)
        numbers = replace(
            numbers, loudness_n5_sone=varying.n5_sone, loudness_max_sone=varying.max_sone
        )
    tones = ears.tones(sound.pressure, sound.sample_rate)
    if tones is None:
        return numbers
    ratio = tones.tone_to_noise
    prominence = tones.prominence
    return replace(
        numbers,
        tone_to_noise_db=None if ratio is None else ratio.decibels,
        tone_to_noise_hz=None if ratio is None else ratio.frequency_hz,
        tone_to_noise_prominent=ratio is not None and ratio.is_prominent,
        prominence_ratio_db=None if prominence is None else prominence.decibels,
        prominence_ratio_hz=None if prominence is None else prominence.frequency_hz,
        prominence_ratio_prominent=prominence is not None and prominence.is_prominent,
    )


def _is_steady(run: SolvedRun, is_event: bool) -> bool:
    """Tell whether a sound goes on evenly: at constant speed, without flights or impacts."""
    vibration = run.vibration_sound
    flies = False
    if run.sound.source == "vibration" and vibration is not None:
        flies = vibration.motion.flight_share > 0
    return run.sound.constant_speed and not flies and not is_event


def _turns(scene: Scene, surface: SceneSurface, sound: ContactSound) -> TurnNumbers | None:
    """Return the turns of a sphere with a surface, and how they modulate an octave."""
    track = scene.track
    if not track.turn_nodes or surface.part_ra is None:
        return None
    turn_hz = None
    if scene.motion.is_constant(sound.duration):
        turn_hz = track.turns / sound.duration
    numbers = TurnNumbers(turns=track.turns, frequency_hz=turn_hz)
    if sound.levels.laeq_db is None:
        return replace(numbers, reason="the record is silent")
    if sound.once:
        reason = "the sphere falls, and does not roll over the same places again and again"
        return replace(numbers, reason=reason)
    if turn_hz is None:
        reason = "the speed changes, so the turns have no single frequency"
        return replace(numbers, reason=reason)
    pressure = sound.pressure
    rate = sound.sample_rate
    band = modulated_octave(pressure, rate, turn_hz, sound.closed, sound.fade)
    spectrum = envelope_spectrum(pressure, rate, band, sound.closed, sound.fade)
    prominence = spectrum.prominence(turn_hz)
    if prominence is None:
        return replace(numbers, reason=_unknown_prominence(scene, turn_hz))
    return replace(
        numbers,
        modulation=spectrum.at(turn_hz),
        prominence=prominence,
        band_hz=tuple(spectrum.band_hz),
    )


def _unknown_prominence(scene: Scene, turn_hz: float) -> str:
    """Explain why nobody can tell whether a record at constant speed repeats with the turns."""
    turns = scene.track.turns
    turn = scene.track.turn_nodes * scene.track.spacing
    if turns < MIN_PERIODS:
        least_mm = math.ceil(MIN_PERIODS * turn * 1e4) / 10
        return (
            f"the record has {rounded(turns, 3)} turns of the sphere, and whether its sound repeats"
            f" with them can be told from {MIN_PERIODS} turns on; choose a rolling.distance_mm of"
            f" at least {least_mm:g}"
        )
    return (
        f"the octaves that are heard are narrower than six times the {turn_hz:.0f} turns per"
        " second, so their envelopes have no room for the lines of a turn; choose a lower"
        " rolling.speed_m_s"
    )


# ---- energy, contact and effort


def _energy(run: SolvedRun, release: ContactSound) -> EnergyNumbers:
    """Return the powers of a release, and the errors of the energy ledger."""
    scene = run.scene
    result = run.result
    defect = np.abs(result.whole_series("energy_defect")).max()
    balance = law_error = None
    moving = result.moving if scene.moves_release else None
    if moving is not None and not moving.failure:
        moving_defect = np.abs(moving.steps["energy_defect"]).max()
        balance = float(moving_defect / result.series["stored_energy"].max())
        law_error = moving.law_error
    return EnergyNumbers(
        release_power_mean_w=release.mean_power,
        release_power_rms_w=release.power_rms,
        release_power_audible_rms_w=release.audible_rms,
        release_power_resolved_rms_w=release.resolved_rms,
        balance_error=float(defect / result.whole_series("stored_energy").max()),
        joint_error=joint_error(scene, result),
        moving_balance_error=balance,
        moving_law_error_m=law_error,
    )


def _contact(scene: Scene, result: Result) -> ContactNumbers:
    """Return areas and pressure over all positions."""
    length, width = smooth_contact_of(scene).semi_axes_m()
    hertz_area = float(np.pi * (length * width))
    plastic = float(result.whole_series("plastic_area").mean())
    return ContactNumbers(
        hertz_area_m2=hertz_area,
        area_mean_m2=float(result.whole_series("contact_area").mean()),
        plastic_area_mean_m2=plastic,
        plastic_ratio=plastic / hertz_area,
        max_pressure_pa=float(result.whole_series("max_pressure").max()),
    )


def joint_error(scene: Scene, result: Result) -> float | None:
    """Return the largest difference of the stored energy at joints over its maximum.

    A position where two pieces join is solved twice: at the end of a piece, and from a cold start
    at the beginning of the next. A step has the energies of its own piece, and the series has the
    state of the piece before, so their balance misses the difference of both solves. The end of a
    closed lap is the solve of its beginning once more.

    It is None for a plate that remembers, whose loading includes the plastic work.
    """
    if scene.is_permanent:
        return None
    series = result.series
    stored = series["stored_energy"]
    own_change = series["loading_energy"] - series["release_energy"] - series["energy_defect"]
    differences = np.abs(own_change - np.diff(stored))
    largest = float(differences.max())
    if scene.track.steps >= scene.track.lap_steps:
        largest = max(largest, float(abs(stored[-1] - stored[0])))
    return largest / float(stored.max())


def _effort(scene: Scene, result: Result) -> EffortNumbers:
    """Return tolerance, work of the solver, and times, which a march from a file lacks."""
    times = result.series["step_time"]
    times = times[np.isfinite(times)]
    choice = scene.step_choice
    return EffortNumbers(
        tolerance=scene.tolerance,
        residual_max=float(result.whole_series("residual").max()),
        iterations_mean=float(result.whole_series("iterations").mean()),
        convolutions_mean=float(result.whole_series("convolutions").mean()),
        step_nodes=scene.step_nodes,
        step_choice=scene.step_reason,
        length_choice=scene.length_reason,
        step_lowest_speed_m_s=choice.lowest if choice is not None and choice.lowest else None,
        step_ms=float(np.median(times) * 1e3) if len(times) else None,
        march_cpu_s=result.effort.march_s,
        parts_cpu_s=result.effort.numbers(effort.OF_SPHERE),
    )


# ---- surface


def _surface(
    run: SolvedRun, surface: SceneSurface, instrument: InstrumentNumbers | None
) -> SurfaceNumbers:
    """Return the roughness of a surface, how its heights were made or prepared, and what sounds."""
    statistics = surface.statistics
    plate_ra = ball_ra = None
    if run.scene.track.turn_nodes and surface.part_ra is not None:
        plate_ra, ball_ra = surface.part_ra
    preparation = None
    if surface.preparation:
        preparation = tuple(PreparationStep(**asdict(step)) for step in surface.preparation)
    return SurfaceNumbers(
        ra_m=statistics.ra,
        rq_m=statistics.rq,
        skewness=statistics.skewness,
        kurtosis=statistics.kurtosis,
        rms_slope=statistics.rms_slope,
        highest_m=statistics.highest,
        lowest_m=statistics.lowest,
        plate_ra_m=plate_ra,
        ball_ra_m=ball_ra,
        levelling=None if surface.levelling is None else _levelling(surface.levelling),
        preparation=preparation,
        made=_made(surface.made.get("surface_made")),
        ball_made=_made(surface.made.get("ball_surface_made")),
        wavelength_octaves=tuple(
            WavelengthNumbers(**octave._asdict()) for octave in run.wavelength_octaves
        ),
        instrument=instrument,
    )


def _made(described: Mapping[str, Any] | None) -> MadeSurfaceNumbers | None:
    """Return how well a made surface meets its law; None for one that is not compared."""
    return None if described is None else MadeSurfaceNumbers(**described)


def _levelling(taken: levelling.Levelling) -> LevellingNumbers:
    """Return the tilt removed from the heights of a file, and the seam of the levelled heights."""
    seam = taken.seams[0]
    return LevellingNumbers(
        slope_along=taken.taken[0],
        slope_across=taken.taken[1],
        height_along_m=taken.rises[0],
        height_across_m=taken.rises[1],
        ra_before_m=taken.ra_before,
        ra_after_m=taken.ra_after,
        seam_step_m=seam.step,
        seam_neighbours_m=seam.neighbours,
        seam_stands_out=seam.stands_out,
        text=height_findings.tilt_text(taken),
    )


def _passes(run: SolvedRun, passes: Passes, stiffness: Array | None) -> tuple[PassNumbers, ...]:
    """Return levels, release power, plastic work and maximum depth of each pass.

    The level of the vibration is an estimate from the approach, for scenes without dynamics.
    """
    scene = run.scene
    result = run.result
    steps = np.arange(result.steps) % result.solved_steps
    places = np.append(steps, steps[-1] + 1)
    rows = []
    for k, sound in enumerate(run.pass_sounds):
        vibration_db = None
        if stiffness is not None:
            approach = passes.series["approach"][k, places]
            linear = linear_vibration(scene, approach, result.step, sound.closed, stiffness)
            vibration_db = vibration_estimate(linear, stiffness).laeq_db
        row = PassNumbers(
            laeq_db=sound.levels.laeq_db,
            level_db=sound.levels.level_db,
            vibration_laeq_db=vibration_db,
            release_power_mean_w=sound.mean_power,
            plastic_work_j=float(passes.series["plastic_work"][k].sum()),
            depth_um=float(passes.depth[k]) * 1e6,
        )
        rows.append(row)
    return tuple(rows)


# ---- vibration


def _motion(run: SolvedRun, vibration: Vibration) -> MotionNumbers:
    """Return force, impacts, linear chain, limits of the plate, and course of a motion."""
    scene = run.scene
    motion = vibration.motion
    chain = vibration.chain
    largest_n = float(motion.force_n.max())
    # A sphere that yields in an impact leaves a dent, and a contact without memory springs back.
    contact = smooth_contact_of(scene)
    body = plate_of(scene.plate)
    impacts_yield = False
    if motion.impacts and largest_n:
        impacts_yield = bool(contact.maximum_pressure_pa(largest_n) > scene.hardness)
    edges = body.with_edges
    plate = body.bending
    numbers = MotionNumbers(
        force_rms_n=vibration.rms_ratio * vibration.load,
        force_rms_ratio=vibration.rms_ratio,
        force_max_ratio=float(vibration.force_ratio.max()),
        force_min_ratio=float(vibration.force_ratio.min()),
        largest_force_n=largest_n,
        impacts=motion.impacts,
        impacts_yield=impacts_yield,
        flight_share=motion.flight_share,
        drop_mm=scene.rolling.drop_mm,
        restitution=drop.restitution(bodies_of(scene), motion) if scene.is_one_event else None,
        force_outside_share=motion.outside_share,
        comb_spread_db=vibration.spreads.get("comb"),
        comb_mean_laeq_db=vibration.mean_laeq,
        baffle_db=vibration.spreads.get("baffle", 0.0),
        time_step_s=motion.time_step_s,
        step_error_db=vibration.spreads.get("time_step"),
        balance_error=motion.energy_error,
        settled=bool(motion.settled),
        laps=motion.laps,
        transient_s=known(motion.transient_s),
        ball_mass_kg=chain.mass_kg,
        contact_stiffness_n_m=chain.stiffness_n_m,
        plate_mobility_s_kg=chain.mobility_s_kg,
        plate_modes=None if edges is None else edges.mode_count,
        resonance_hz=chain.resonance_hz,
        resonance_q=known(chain.quality),
        resonance_wavelength_m=scene.motion.fastest(scene.duration) / chain.resonance_hz,
        plate_deflection_m=float(np.ptp(motion.plate_m)),
        loss_factor=scene.plate.loss_factor,
    )
    if plate is not None:
        numbers = replace(
            numbers,
            critical_hz=plate.critical_hz,
            bending_limit_hz=body.bending_limit_hz,
            contact_radius_over_thickness=max(contact.semi_axes_m()) / body.thickness_m,
        )
    return _with_force_law(run, vibration, numbers)


def _with_force_law(run: SolvedRun, vibration: Vibration, numbers: MotionNumbers) -> MotionNumbers:
    """Return numbers of a motion with the loads of the force law and its error."""
    marches = run.result.load_marches
    if marches is None:
        return numbers
    loads = vibration.law.load_n.tolist()
    error = marched_law.law_error(run.scene, run.result, loads)
    return replace(
        numbers,
        force_law_loads=len(loads),
        force_law_min_n=loads[0],
        force_law_max_n=loads[-1],
        force_law_error_n=None if error is None else error.newtons,
        force_law_error_db=None if error is None else error.decibels,
        force_law_top_error=None if error is None else error.top,
        force_law_failure=marches.failure or None,
    )
