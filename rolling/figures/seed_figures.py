"""Picture of runs over several surfaces of one kind: their mean spectrum and its spread."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from acoustics import plots as sound_plots
from acoustics.bands import BAND_NAMES, MID_HZ
from acoustics.plot_style import look_of
from rolling._typing import Array
from rolling.figures import captions
from rolling.figures.picture import Picture, single
from rolling.figures.sound_views import CurveScales
from rolling.scene.sweep import Value
from rolling.simulation import labels
from rolling.simulation.run_result import RunResult

SEED = "surface.seed"
FEWEST = 3  # seeds that have a spread worth drawing


@dataclass(frozen=True)
class Seeds:
    """Third octaves of runs that differ in their seed alone.

    label : str. The other swept values and the number of seeds.
    mean_db : dict, dB. Level of the mean square of all records, by band; None without sound.
    spread_db : dict, dB. Standard deviation of the levels from seed to seed.
    """

    label: str
    mean_db: Mapping[str, float | None]
    spread_db: Mapping[str, float | None]


def merged(runs: Sequence[RunResult]) -> list[Seeds]:
    """Merge the runs that differ in their seed alone; empty where any of them has few seeds."""
    groups: dict[tuple[tuple[str, Value], ...], list[RunResult]] = {}
    for run in runs:
        others = tuple((key, value) for key, value in run.values.items() if key != SEED)
        groups.setdefault(others, []).append(run)
    seeds = [{run.values.get(SEED) for run in group} - {None} for group in groups.values()]
    alike = len({run.scene.name for run in runs}) == 1
    if not alike or min(map(len, seeds), default=0) < FEWEST:
        return []
    return [_merge(others, group) for others, group in groups.items()]


def _merge(others: Sequence[tuple[str, Value]], group: Sequence[RunResult]) -> Seeds:
    """Merge the third octaves of one group."""
    words = [labels.worded(*value) for value in others]
    mean: dict[str, float | None] = {}
    spread: dict[str, float | None] = {}
    for band in BAND_NAMES:
        levels = [run.sound.levels.third_octave_db[band] for run in group]
        known = np.array([level for level in levels if level is not None])
        whole = len(known) == len(levels)
        mean[band] = float(10 * np.log10(np.mean(10 ** (known / 10)))) if whole else None
        spread[band] = float(known.std(ddof=1)) if whole else None
    return Seeds(", ".join([*words, f"{len(group)} seeds"]), mean, spread)


def third_octaves_of_seeds(runs: Sequence[RunResult], scales: CurveScales) -> Picture | None:
    """Draw mean and spread of the third octaves over seeds; None without several seeds."""
    groups = merged(runs)
    if not groups:
        return None
    curves = [(each.label, each.mean_db, each.spread_db) for each in groups]
    limits = scales.third_octaves["Z"]

    def draw(ax: Axes) -> None:
        sound_plots.third_octaves(ax, curves, scales.shortest_s, limits)
        for number, each in enumerate(groups):
            middle, spread = _column(each.mean_db), _column(each.spread_db)
            colour = look_of(number, len(groups))["color"]
            ax.fill_between(
                MID_HZ, middle - spread, middle + spread, color=colour, alpha=0.2, linewidth=0
            )

    columns = {
        "run": np.repeat([each.label for each in groups], len(BAND_NAMES)),
        "mid_frequency_hz": np.tile(MID_HZ, len(groups)),
        "level_db": np.concatenate([_column(each.mean_db) for each in groups]),
        "standard_deviation_db": np.concatenate([_column(each.spread_db) for each in groups]),
    }
    facts = [
        captions.distance(runs),
        captions.duration(runs),
        "band: standard deviation from seed to seed",
    ]
    title = f"Third octaves over all seeds: {captions.subject(runs)}"
    return single("third_octaves_of_seeds", title, captions.note(facts), columns, draw)


def _column(levels: Mapping[str, float | None]) -> Array:
    """Return levels by band as an array, with NaN in place of None."""
    return captions.gaps(levels[band] for band in BAND_NAMES)
