"""Figures of balls on plates: those that compare runs, those of one run, and those on request."""

from collections.abc import Sequence

from rolling.figures import (
    article,
    channel_figures,
    contact_figures,
    level_figures,
    origins,
    place_figures,
    sound_figures,
    sweep_figures,
    vibration_figures,
)
from rolling.in_si.scene_surface import scene_surface
from rolling.kinds.figure_kind import FigureKind
from rolling.results.run_result import Run

# ---- runs that have a figure


def _has_swept_key(runs: Sequence[Run]) -> bool:
    return sweep_figures.swept_key(runs) is not None


def _have_a_second_sound(runs: Sequence[Run]) -> bool:
    """Return whether all runs have a released power beside the vibration that plays."""
    return all(run.scene.has_release and run.stated().source == "vibration" for run in runs)


def _has_turns(run: Run) -> bool:
    return run.numbers.turns is not None and run.numbers.turns.band_hz is not None


def _has_wavelengths(run: Run) -> bool:
    return bool(run.wavelength_octaves)


def _has_passes(run: Run) -> bool:
    return run.result.passes is not None


def _has_snapshot(run: Run) -> bool:
    return run.result.snapshot is not None


def _has_ball_surface(run: Run) -> bool:
    return run.scene.sphere.surface is not None


def _has_release(run: Run) -> bool:
    return run.scene.has_release


def _has_events(run: Run) -> bool:
    return run.event_statistics is not None


def _has_vibration(run: Run) -> bool:
    return run.vibration_sound is not None


def _has_channels(run: Run) -> bool:
    return bool(run.channels)


def _vibrates_on_a_rough_surface(run: Run) -> bool:
    return run.vibration_sound is not None and scene_surface(run.scene).statistics.rq > 0


# ---- the figures

FIGURES = {
    # that compare runs
    "third_octaves": FigureKind(sound_figures.third_octaves, sound_figures.third_octave_table),
    "third_octaves_a": FigureKind(
        sound_figures.third_octaves_a, sound_figures.third_octave_a_table
    ),
    "spectrum": FigureKind(sound_figures.spectrum, sound_figures.spectrum_table),
    "levels": FigureKind(level_figures.levels, level_figures.level_table, _has_swept_key),
    "contact_areas": FigureKind(
        sweep_figures.contact_areas, sweep_figures.area_table, _has_swept_key
    ),
    "places": FigureKind(
        place_figures.places,
        place_figures.place_table,
        place_figures.has_places,
        is_unasked=place_figures.are_tracks,
    ),
    "mean_third_octaves": FigureKind(
        sweep_figures.mean_third_octaves, sweep_figures.seed_table, sweep_figures.has_seeds
    ),
    "max_level_over_load": FigureKind(
        article.max_level_over_load,
        article.max_level_table,
        article.has_loads,
        is_unasked=article.has_loads_and_seeds,
    ),
    "released_third_octaves_a": FigureKind(
        sound_figures.released_third_octaves_a,
        sound_figures.released_third_octave_a_table,
        _have_a_second_sound,
        is_written=False,  # the page has it, and files of the sound that plays suffice
    ),
    "released_spectrum": FigureKind(
        sound_figures.released_spectrum,
        sound_figures.released_spectrum_table,
        _have_a_second_sound,
        is_written=False,  # the page has it, and files of the sound that plays suffice
    ),
    # of one run
    "release_power": FigureKind(
        sound_figures.release_power,
        sound_figures.release_power_table,
        _has_release,
        shares_scales=True,
        is_single=True,
    ),
    "spectrogram": FigureKind(sound_figures.spectrogram, shares_scales=True, is_single=True),
    "modulation": FigureKind(
        origins.modulation, origins.modulation_table, _has_turns, is_single=True
    ),
    "wavelengths": FigureKind(
        origins.wavelengths, origins.wavelength_table, _has_wavelengths, is_single=True
    ),
    "running_in": FigureKind(
        origins.running_in, origins.running_in_table, _has_passes, is_single=True
    ),
    "surface": FigureKind(contact_figures.surface, is_single=True),
    "ball_surface": FigureKind(
        contact_figures.ball_surface, is_shown=_has_ball_surface, is_single=True
    ),
    "contact_pressure": FigureKind(
        contact_figures.contact_pressure, is_shown=_has_snapshot, shares_scales=True, is_single=True
    ),
    "recovery_events": FigureKind(
        contact_figures.recovery_events,
        contact_figures.recovery_event_table,
        _has_events,
        is_single=True,
    ),
    "sources": FigureKind(
        vibration_figures.sources, vibration_figures.source_table, _has_vibration, is_single=True
    ),
    "contact_force": FigureKind(
        vibration_figures.contact_force,
        vibration_figures.contact_force_table,
        _has_vibration,
        is_single=True,
    ),
    "contact_filter": FigureKind(
        vibration_figures.contact_filter,
        vibration_figures.contact_filter_table,
        _vibrates_on_a_rough_surface,
        is_single=True,
    ),
    "mobilities": FigureKind(
        vibration_figures.mobilities,
        vibration_figures.mobility_table,
        _has_vibration,
        is_single=True,
    ),
    "channel_third_octaves": FigureKind(
        channel_figures.channel_third_octaves,
        channel_figures.channel_third_octave_table,
        _has_channels,
        is_single=True,
    ),
    "channel_spectrum": FigureKind(
        channel_figures.channel_spectrum,
        channel_figures.channel_spectrum_table,
        _has_channels,
        is_single=True,
    ),
    "channel_envelope": FigureKind(
        channel_figures.channel_envelope,
        channel_figures.channel_envelope_table,
        _has_channels,
        is_single=True,
    ),
    # on request
    "power_density": FigureKind(sound_figures.power_density, is_asked_only=True),
    "spectra_over_load": FigureKind(  # for all loads and seeds of the other swept values
        article.spectra_over_load,
        article.spectra_table,
        article.has_loads,
        is_asked_only=True,
        groups=article.runs_by_surface,
    ),
}
