"""Tables of runs: numbers as a data frame, statistics over seeds, and levels in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from acoustics.bands import BAND_NAMES, MID_HZ
from acoustics.texts import cell
from rolling.results import verdict
from rolling.results.answer import leading, released_power, uncertain, vibration
from rolling.results.labels import SEED, labels
from rolling.results.run_folder import RunFolder, stored_summary
from rolling.scene.messages import table

if TYPE_CHECKING:
    import pandas as pd

LEVELS, MEANS = table("rolling.results", "levels").values()  # keys of the summary with their words
ANSWERS = ("vibration", "released_power")  # the two numbers of a run, in the order of reading
BANDS = ("third_octave_db", "third_octave_a_db", "third_octave_uncertainty_db")
MAXIMA = ("laf_max_db", "las_max_db")  # with a time weighting that a short record may not reach
_METRES = ("ra", "rq", "highest", "lowest")  # statistics of a surface that are lengths


def runs_table(runs: Sequence[RunFolder]) -> pd.DataFrame:
    """Return the numbers of runs, one row per run.

    The index holds label, folder and the swept keys. The first columns are the two numbers,
    vibration and released power. The others are all single numbers of summary.json, the keys of
    the doubts, and the third octaves, such as `third_octave_db_1000`. A run without a summary has
    empty cells.
    """
    import pandas as pd  # slow to import, for tables only

    swept = list(dict.fromkeys(key for run in runs for key in run.values))
    rows = []
    for run, label in zip(runs, labels(runs), strict=True):
        names = {"run": label, "folder": run.folder.name}
        places = names | {key: run.values.get(key) for key in swept}
        summary = stored_summary(run)
        if summary is not None:
            places |= _two_numbers(summary) | numbers(summary)
        rows.append(places)
    return pd.DataFrame(rows).convert_dtypes().set_index(["run", "folder", *swept])


def _two_numbers(summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return vibration and released power with uncertainty and origin, by their columns."""
    cells: dict[str, Any] = {}
    for name, answer in (
        ("vibration", vibration(summary)),
        ("released_power", released_power(summary)),
    ):
        cells[f"{name}_db"] = answer.level_db
        cells[f"{name}_uncertainty_db"] = answer.uncertainty_db
        cells[f"{name}_how"] = answer.how
        cells["quantity"] = answer.quantity
        if answer.solved_share < 1:
            cells[f"{name}_solved_share"] = answer.solved_share
    return cells


def without_formulas(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table whose texts no spreadsheet takes for formulas, in its index too."""
    import pandas as pd

    def safe(value: Any) -> Any:
        return cell(value) if isinstance(value, str) else value

    named = table.map(safe)
    rows = [tuple(map(safe, x)) if isinstance(x, tuple) else safe(x) for x in table.index]
    if table.index.nlevels > 1:
        named.index = pd.MultiIndex.from_tuples(rows, names=table.index.names)
    elif table.index.dtype == object:
        named.index = pd.Index(rows, name=table.index.name)
    return named


def numbers(summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return the numbers of a summary by the names of their columns.

    The uncertainty of LAeq from the length of the record has the column `laeq_uncertainty_db`, like
    that of any other level; the one with grid and solver has `laeq_total_uncertainty_db`.
    """
    cells: dict[str, Any] = {}
    for key, value in summary.items():
        if key == "doubts":
            cells[key] = " ".join(doubt.key for doubt in verdict.listed(summary))
        elif key == "uncertainty_db":
            cells |= {f"{name}_uncertainty_db": spread for name, spread in value.items()}
        elif key == "surface":
            for name, number in value.items():
                unit = "_m" if name in _METRES else ""
                cells[f"surface_{name}{unit}"] = number
        elif key == "levelling" and value:
            cells |= {f"levelling_{name}": inner for name, inner in value.items()}
        elif key == "verdict" and value:
            cells |= {"verdict": value["word"], "verdict_reason": value["reason"]}
        elif key == "laeq_uncertainty_db":
            cells["laeq_total_uncertainty_db"] = value
        elif key not in ("name", "levelling", "preparation") and not isinstance(value, Mapping):
            cells[key] = value
    for key in BANDS:
        cells |= {f"{key}_{name}": level for name, level in summary.get(key, {}).items()}
    return cells


def seed_statistics(table: pd.DataFrame, over: str = SEED) -> pd.DataFrame:
    """Return statistics of levels and third octaves over runs that differ in one key alone.

    A sweep of seeds repeats an experiment: `deviation_over_stated` near 1 confirms the uncertainty
    that a record states.

    table : DataFrame. A table of runs, as `runs_table` returns it.
    over : str. The swept key over which the statistics are made. Default: the seed.
    """
    import pandas as pd

    keys = [name for name in table.index.names if name not in ("run", "folder", over)]
    uncertainties = {f"{name}_db": f"{name}_uncertainty_db" for name in ANSWERS}
    uncertainties |= {name: f"{_spread(name)}_uncertainty_db" for name in LEVELS}
    for kind in ("third_octave_db", "third_octave_a_db"):
        for band in BAND_NAMES:
            uncertainties[f"{kind}_{band}"] = f"third_octave_uncertainty_db_{band}"
    stated = {name: spread for name, spread in uncertainties.items() if name in table}
    values = table[[*stated]].astype(float)
    spreads = table[[*stated.values()]].astype(float).set_axis([*stated], axis=1)
    groups = [table.index.get_level_values(key) for key in keys] or [np.zeros(len(table), int)]
    of_levels = values.groupby(groups, sort=False, dropna=False)
    square = np.square(spreads.where(values.notna()))
    parts = {
        "runs": of_levels.count(),
        "mean": of_levels.mean(),
        "standard_deviation": of_levels.std(),
        "standard_error": of_levels.sem(),
        "stated_uncertainty": np.sqrt(square.groupby(groups, sort=False, dropna=False).mean()),
    }
    parts["deviation_over_stated"] = parts["standard_deviation"] / parts["stated_uncertainty"]
    statistics = pd.concat(parts, axis=1).stack(level=1, future_stack=True)
    statistics = statistics.rename_axis([*(keys or ["all"]), "level"]).reset_index()
    names = statistics["level"].str.extract(r"^(third_octave(?:_a)?_db)_(.+)$")
    statistics["level"] = names[0].fillna(statistics["level"])
    statistics.insert(len(keys or ["all"]) + 1, "band_hz", names[1])
    exact_hz = dict(zip(BAND_NAMES, MID_HZ, strict=True))
    statistics.insert(len(keys or ["all"]) + 2, "mid_frequency_hz", names[1].map(exact_hz))
    statistics = statistics[statistics["runs"] > 0].astype({"runs": int})
    return statistics if keys else statistics.drop(columns="all")


# ---- texts


def level_text(summary: Mapping[str, Any], key: str) -> str:
    """Write a level of a summary, or of the whole of what ends, with its uncertainty [dB]."""
    if (level := leading(summary, key)) is None:
        no_level = key == "steady_level_db" and summary["source"] == "vibration"
        too_short = key in MAXIMA and summary["laeq_db"] is not None
        return "-" if no_level or too_short else "silent"
    return uncertain(level, summary["uncertainty_db"][_spread(key)])


def shown_levels(summary: Mapping[str, Any]) -> list[str]:
    """Return the keys of the levels of a run that tables show, the first read first."""
    levels = [key for key in LEVELS if key in summary]
    if summary.get("single_event"):
        first = ["lae_db", "laf_max_db"]
        return first + [key for key in levels if key not in (*first, "laeq_db", "level_db")]
    return [key for key in levels if key != "lae_db"]


def level_name(summary: Mapping[str, Any]) -> str:
    """Name the level of a run: LAeq of the vibration, or of the released power with its q.

    A single event has the sound exposure level LAE.
    """
    event = summary.get("single_event")
    quantity, reference = ("LAE", " (re 1 s)") if event else ("LAeq", "")
    if summary["source"] == "vibration":
        place = "at the listener" if summary.get("listeners") else "on the axis"
        return f"{quantity} {place}{reference}"
    if _fixed_gain(summary):
        return f"{quantity} under the fixed gain{reference}"
    q = f"q = {summary.get('q') or 1:g}"
    if event:
        return f"LAE of the released power (re 1 s, {q})"
    return f"level of the released power ({q})"


def _fixed_gain(summary: Mapping[str, Any]) -> bool:
    """Tell whether the gain of the scene decides the level of a release."""
    return summary["source"] == "release" and summary.get("q", 1) is None


def _spread(key: str) -> str:
    """Return the name of a level in `uncertainty_db`."""
    return "steady" if key.startswith("steady") else key.removesuffix("_db")
