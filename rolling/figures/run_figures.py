"""The gallery: all pictures of a run and of runs that are compared, on common axes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rolling.figures import contact_figures, sound_figures
from rolling.figures.picture import Picture
from rolling.simulation.run_result import RunResult


def gallery(runs: Sequence[RunResult]) -> Iterator[tuple[RunResult | None, Picture]]:
    """Draw all pictures of runs that are compared.

    Parameters
    ----------
    runs : sequence of runs. Their labels differ, as `labels.labels` makes them.

    Returns
    -------
    iterator of pairs. A picture with its run, or with None if it shows several runs.
    """
    for run in runs:
        for picture in of_run(run, runs):
            yield run, picture
    if len(runs) > 1:
        for picture in of_runs(runs):
            yield None, picture


def of_run(run: RunResult, among: Sequence[RunResult] = ()) -> Iterator[Picture]:
    """Draw the pictures of a run on the axes of all the runs `among` which it is compared."""
    runs = [*among] or [run]
    yield from sound_figures.spectra([run], runs)
    yield from sound_figures.third_octaves([run], runs)
    yield sound_figures.spectrogram_of(run, runs)
    yield sound_figures.release_power(run, runs)
    yield contact_figures.surface(run)
    for picture in (contact_figures.contact(run, runs), contact_figures.recovery_events(run)):
        if picture is not None:
            yield picture


def of_runs(runs: Sequence[RunResult]) -> Iterator[Picture]:
    """Draw the pictures that compare runs.

    Levels are drawn against the first quantity that a sweep varies.
    """
    yield from sound_figures.spectra(runs, runs)
    yield from sound_figures.third_octaves(runs, runs)
    key = sound_figures.swept_key(runs)
    if key is not None:
        yield sound_figures.levels(key, runs)
