"""The gallery: all pictures of a run and of runs that are compared, on common axes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from rolling.figures import (
    contact_figures,
    level_figures,
    seed_figures,
    sound_figures,
    vibration_figures,
)
from rolling.figures.contact_figures import ContactScales
from rolling.figures.picture import Picture
from rolling.figures.sound_views import CurveScales, TimeScales
from rolling.simulation.run_result import RunResult


@dataclass(frozen=True)
class Scales:
    """Scales that the pictures of compared runs share.

    contact : None where no run has a snapshot.
    """

    curves: CurveScales
    times: TimeScales
    contact: ContactScales | None

    @classmethod
    def of(cls, runs: Sequence[RunResult]) -> Scales:
        """Derive the scales from all runs that are compared."""
        return cls(CurveScales.of(runs), TimeScales.of(runs), ContactScales.of(runs))


def gallery(runs: Sequence[RunResult]) -> Iterator[tuple[RunResult | None, Picture]]:
    """Draw all pictures of runs that are compared.

    Parameters
    ----------
    runs : sequence of runs. Their labels differ, as `labels.labels` makes them.

    Returns
    -------
    iterator of pairs. A picture with its run, or with None if it shows several runs.
    """
    scales = Scales.of(runs)
    for run in runs:
        for picture in on_scales(run, scales):
            yield run, picture
    if len(runs) > 1:
        for picture in of_runs(runs):
            yield None, picture


def of_run(run: RunResult, among: Sequence[RunResult] = ()) -> Iterator[Picture]:
    """Draw the pictures of one run on the axes of all the runs `among` which it is compared."""
    yield from on_scales(run, Scales.of([*among] or [run]))


def on_scales(run: RunResult, scales: Scales) -> Iterator[Picture]:
    """Draw the pictures of one run on scales that may hold for several."""
    for sheet in SHEETS:
        yield from sheet(run, scales)


def _spectra(run: RunResult, scales: Scales) -> Iterator[Picture]:
    yield from sound_figures.spectra([run], scales.curves)


def _third_octaves(run: RunResult, scales: Scales) -> Iterator[Picture]:
    yield from sound_figures.third_octaves([run], scales.curves)


def _over_time(run: RunResult, scales: Scales) -> Iterator[Picture]:
    yield sound_figures.spectrogram_of(run, scales.times)
    yield sound_figures.release_power(run, scales.times)


def _of_contact(run: RunResult, scales: Scales) -> Iterator[Picture]:
    yield contact_figures.surface(run)
    for picture in (
        contact_figures.contact(run, scales.contact),
        contact_figures.recovery_events(run),
    ):
        if picture is not None:
            yield picture
    yield from vibration_figures.pictures(run)


# The pictures of a run in parts of about equal cost, each of which a process can draw.
SHEETS: tuple[Callable[[RunResult, Scales], Iterator[Picture]], ...] = (
    _spectra,
    _third_octaves,
    _over_time,
    _of_contact,
)
SHEET_PICTURES = (3, 2, 2, 2)  # of each sheet, apart from recovery events and vibration


def of_runs(runs: Sequence[RunResult]) -> Iterator[Picture]:
    """Draw the pictures that compare runs.

    Levels are drawn against the first quantity that a sweep varies.
    """
    scales = CurveScales.of(runs)
    yield from sound_figures.spectra(runs, scales)
    yield from sound_figures.third_octaves(runs, scales)
    if seeds := seed_figures.third_octaves_of_seeds(runs, scales):
        yield seeds
    key = level_figures.swept_key(runs)
    if key is not None:
        yield level_figures.levels(key, runs)
    slopes = vibration_figures.speed_slopes(runs)
    if slopes is not None:
        yield slopes
