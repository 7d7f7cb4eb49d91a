"""Figures of balls on plates: those that compare runs, those of one run, and those on request."""

from collections.abc import Sequence

from rolling.ball.scene_surface import scene_surface
from rolling.figures import (
    article,
    channels,
    contact,
    levels,
    origins,
    places,
    sound,
    sweep,
    vibration,
)
from rolling.kinds.figure_kind import FigureKind
from rolling.results.run_result import Run

# ---- runs that have a figure


def _has_swept_key(runs: Sequence[Run]) -> bool:
    return sweep.swept_key(runs) is not None


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


def _rolls(run: Run) -> bool:
    return run.scene.rolling.drop_mm is None


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
    "third_octaves": FigureKind(sound.third_octaves, sound.third_octave_table),
    "third_octaves_a": FigureKind(sound.third_octaves_a, sound.third_octave_a_table),
    "spectrum": FigureKind(sound.spectrum, sound.spectrum_table),
    "levels": FigureKind(levels.levels, levels.level_table, _has_swept_key),
    "contact_areas": FigureKind(sweep.contact_areas, sweep.area_table, _has_swept_key),
    "places": FigureKind(
        places.places, places.place_table, places.has_places, is_unasked=places.are_tracks
    ),
    "mean_third_octaves": FigureKind(sweep.mean_third_octaves, sweep.seed_table, sweep.has_seeds),
    "max_level_over_load": FigureKind(
        article.max_level_over_load,
        article.max_level_table,
        article.has_loads,
        is_unasked=article.has_loads_and_seeds,
    ),
    # of one run
    "release_power": FigureKind(
        sound.release_power, sound.release_power_table, _rolls, shares_scales=True, is_single=True
    ),
    "spectrogram": FigureKind(sound.spectrogram, shares_scales=True, is_single=True),
    "modulation": FigureKind(
        origins.modulation, origins.modulation_table, _has_turns, is_single=True
    ),
    "wavelengths": FigureKind(
        origins.wavelengths, origins.wavelength_table, _has_wavelengths, is_single=True
    ),
    "running_in": FigureKind(
        origins.running_in, origins.running_in_table, _has_passes, is_single=True
    ),
    "surface": FigureKind(contact.surface, is_single=True),
    "ball_surface": FigureKind(contact.ball_surface, is_shown=_has_ball_surface, is_single=True),
    "contact_pressure": FigureKind(
        contact.contact_pressure, is_shown=_has_snapshot, shares_scales=True, is_single=True
    ),
    "recovery_events": FigureKind(
        contact.recovery_events, contact.recovery_event_table, _has_events, is_single=True
    ),
    "sources": FigureKind(
        vibration.sources, vibration.source_table, _has_vibration, is_single=True
    ),
    "contact_force": FigureKind(
        vibration.contact_force, vibration.contact_force_table, _has_vibration, is_single=True
    ),
    "contact_filter": FigureKind(
        vibration.contact_filter,
        vibration.contact_filter_table,
        _vibrates_on_a_rough_surface,
        is_single=True,
    ),
    "mobilities": FigureKind(
        vibration.mobilities, vibration.mobility_table, _has_vibration, is_single=True
    ),
    "channel_third_octaves": FigureKind(
        channels.channel_third_octaves,
        channels.channel_third_octave_table,
        _has_channels,
        is_single=True,
    ),
    "channel_spectrum": FigureKind(
        channels.channel_spectrum, channels.channel_spectrum_table, _has_channels, is_single=True
    ),
    "channel_envelope": FigureKind(
        channels.channel_envelope, channels.channel_envelope_table, _has_channels, is_single=True
    ),
    # on request
    "power_density": FigureKind(sound.power_density, is_asked_only=True),
    "spectra_over_load": FigureKind(  # for all loads and seeds of the other swept values
        article.spectra_over_load,
        article.spectra_table,
        article.has_loads,
        is_asked_only=True,
        groups=article.runs_by_surface,
    ),
}
