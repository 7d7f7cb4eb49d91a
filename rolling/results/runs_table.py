"""Tables of runs: numbers and third octaves as data frames, and statistics over seeds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from acoustics.bands import BAND_NAMES, MID_HZ
from acoustics.texts import cell
from rolling.kinds.run_folder import RunFolder
from rolling.numbers import views
from rolling.numbers.ball_numbers import RunNumbers
from rolling.results import verdict
from rolling.results.labels import SEED, labels
from rolling.results.stored_numbers import numbers_of

if TYPE_CHECKING:
    import pandas as pd

BAND = "band_hz"  # nominal mid frequency
EXACT = "mid_frequency_hz"


def runs_table(runs: Sequence[RunFolder], shown: bool = False) -> pd.DataFrame:
    """Return the numbers of runs, one row per run.

    The index holds label, folder and the swept keys. The first columns are the two numbers,
    vibration and released power, with their uncertainties and verdicts. The others are all single
    numbers, and the keys of the doubts. A run without numbers has empty cells.

    Parameters
    ----------
    runs : sequence of RunFolder
    shown : bool
        If true, only the columns that a person reads, as runs.csv has them. Default: all.
    """
    import pandas as pd  # slow to import, for tables only

    swept = _swept(runs)
    rows = []
    for run, label in zip(runs, labels(runs), strict=True):
        row: dict[str, Any] = {"run": label, "folder": run.folder.name}
        row |= {key: run.values.get(key) for key in swept}
        numbers = numbers_of(run)
        if numbers is not None:
            row |= _cells(numbers, shown)
        rows.append(row)
    return pd.DataFrame(rows).convert_dtypes().set_index(["run", "folder", *swept])


def _swept(runs: Sequence[RunFolder]) -> list[str]:
    """Return the swept keys of runs."""
    return list(dict.fromkeys(key for run in runs for key in run.values))


def _cells(numbers: RunNumbers, shown: bool) -> dict[str, Any]:
    """Return the single numbers of a run by the names of their columns."""
    cells = {
        name: cell.value
        for name, cell in views.columns(numbers).items()
        if cell.number_field.in_table or not shown
    }
    cells["doubts"] = " ".join(doubt.key for doubt in verdict.listed(numbers))
    return cells


def bands_table(runs: Sequence[RunFolder]) -> pd.DataFrame:
    """Return the third octaves of runs in long form: a row for each run, quantity and band.

    The index holds label, folder and the swept keys. Columns are the quantity, the nominal and the
    exact mid frequency of the band [Hz], the value, its standard uncertainty and the unit.
    """
    import pandas as pd

    swept = _swept(runs)
    exact_hz = dict(zip(BAND_NAMES, MID_HZ.tolist(), strict=True))
    rows = []
    for run, label in zip(runs, labels(runs), strict=True):
        place: dict[str, Any] = {"run": label, "folder": run.folder.name}
        place |= {key: run.values.get(key) for key in swept}
        numbers = numbers_of(run)
        if numbers is None:
            continue
        for name, bands in views.bands_of(numbers).items():
            name = name.removeprefix("bands_")
            spreads = bands.uncertainty_by_name
            for band, value in bands.by_name.items():
                row = {
                    "quantity": name,
                    BAND: float(band),
                    EXACT: exact_hz[band],
                    "value": value,
                    "uncertainty": spreads[band],
                    "unit": bands.unit,
                }
                rows.append(place | row)
    names = ["run", "folder", *swept, "quantity", BAND, EXACT, "value", "uncertainty", "unit"]
    frame = pd.DataFrame(rows, columns=names)
    return frame.convert_dtypes().set_index(["run", "folder", *swept])


def without_formulas(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table whose texts no spreadsheet takes for formulas, in its index too."""
    import pandas as pd
    from pandas.api.types import is_numeric_dtype

    known = dict[str, str]()  # labels of runs stand in many rows

    def safe(value: Any) -> Any:
        if not isinstance(value, str):
            return value
        if value not in known:
            known[value] = cell(value)
        return known[value]

    named = table.apply(lambda column: column if is_numeric_dtype(column) else column.map(safe))
    if table.index.nlevels > 1:
        rows = [tuple(map(safe, row)) for row in table.index]
        named.index = pd.MultiIndex.from_tuples(rows, names=table.index.names)
    elif table.index.dtype == object:
        named.index = pd.Index([safe(name) for name in table.index], name=table.index.name)
    return named


def csv_bytes(table: pd.DataFrame) -> bytes:
    """Write a table as CSV, numbers with nine digits; a missing value leaves its cell empty."""
    from pandas.api.types import is_float_dtype

    safe = without_formulas(table)
    written = safe.apply(lambda column: _texts(column) if is_float_dtype(column) else column)
    return str(written.to_csv(index=False, lineterminator="\n")).encode()


def _texts(column: pd.Series) -> pd.Series:
    """Write the numbers of a column, for which pandas takes several times as long."""
    import pandas as pd

    numbers = column.to_numpy(dtype=float, na_value=np.nan).tolist()
    texts = ["" if number != number else f"{number:.9g}" for number in numbers]
    return pd.Series(texts, column.index, dtype=object)


def seed_statistics(runs: Sequence[RunFolder], over: str = SEED) -> pd.DataFrame:
    """Return statistics of levels and third octaves over runs that differ in one key alone.

    A sweep of seeds repeats an experiment: `deviation_over_stated` near 1 confirms the uncertainty
    that a record states.

    runs : sequence of RunFolder. Runs of a sweep.
    over : str. The swept key over which the statistics are made. Default: the seed.
    """
    import pandas as pd

    keys = [key for key in _swept(runs) if key != over]
    rows = []
    for run in runs:
        numbers = numbers_of(run)
        if numbers is None:
            continue
        place = {key: run.values.get(key) for key in keys}
        cells = views.columns(numbers)
        for name, spread in views.spread_columns(numbers).items():
            row = {
                "level": name,
                BAND: None,
                EXACT: None,
                "value": cells[name].value,
                "uncertainty": cells[spread].value,
            }
            rows.append(place | row)
    bands = bands_table(runs).reset_index().rename(columns={"quantity": "level"})
    names = [*keys, "level", BAND, EXACT, "value", "uncertainty"]
    rows += bands[names].to_dict("records")
    table = pd.DataFrame(rows, columns=names).astype({"value": float, "uncertainty": float})
    known = table[table["value"].notna()].assign(
        square=lambda frame: np.square(frame["uncertainty"])
    )
    groups = known.groupby(names[:-2], sort=False, dropna=False)
    statistics = groups["value"].agg(["count", "mean", "std", "sem"])
    statistics.columns = pd.Index(["runs", "mean", "standard_deviation", "standard_error"])
    statistics["stated_uncertainty"] = np.sqrt(groups["square"].mean())
    statistics["deviation_over_stated"] = (
        statistics["standard_deviation"] / statistics["stated_uncertainty"]
    )
    return statistics.reset_index()
