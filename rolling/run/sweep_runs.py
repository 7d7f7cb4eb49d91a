"""Runs of a sweep by their swept values, and the error of a sweep in which some failed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from acoustics.traps import ignoring_underflow
from rolling.contact.solver import ContactError
from rolling.kinds.registry import kind_of
from rolling.results.runs_table import runs_table
from rolling.run.solving import Values
from rolling.scene.sweep import Value

if TYPE_CHECKING:
    import pandas as pd
    import xarray


@ignoring_underflow
class Runs(dict[Values, Any]):
    """Runs of a sweep by their swept value, or by a tuple of values if several keys are swept.

    Parameters
    ----------
    runs : mapping
        Runs by their swept values. Default: none.
    sweep : mapping
        Lists of the swept values by dotted key, with those of runs that failed. Default: the values
        of the runs.

    Examples
    --------
    >>> import rolling
    >>> words = ["sweep.rolling.load_n=[1, 2]", "rolling.duration_s=0.002"]
    >>> scene = rolling.read_scene("quickstart", words)
    >>> runs = rolling.simulate_sweep(scene, workers=1, progress=False)
    >>> runs[2.0].label
    'load 2 N'
    >>> runs.table().index.get_level_values("rolling.load_n").to_list()
    [1, 2]
    >>> runs.to_xarray().released_power_db.sel(load_n=2).item() == runs[2].released_power.value
    True
    """

    def __init__(
        self,
        runs: Mapping[Values, Any] | None = None,
        sweep: Mapping[str, Sequence[Value]] | None = None,
    ) -> None:
        super().__init__(runs or {})
        self._sweep = dict(sweep or {})

    def __missing__(self, values: Values) -> Any:
        """Refuse values that no run has, and name those of the runs."""
        raise KeyError(f"{values!r} is no run; the runs are {', '.join(map(repr, self))}")

    def __repr__(self) -> str:
        runs = [*self.values()]
        if not runs:
            return "no run"
        return "\n".join(kind_of(runs[0].scene).answer_lines(runs))

    def _repr_html_(self) -> str:
        """Write the answer of the runs, with the numbers of each, for a notebook."""
        runs = [*self.values()]
        if not runs:
            return "<p>no run</p>"
        return kind_of(runs[0].scene).html_answer(runs)

    def table(self) -> pd.DataFrame:
        """Tabulate the numbers of the runs, one row per run.

        Returns
        -------
        table : pandas.DataFrame
            All single numbers by label, folder and swept keys; runs.csv has those that a person
            reads. Names join subject and field, as in `contact_plastic_ratio`, and end in units.
        """
        return runs_table([*self.values()])

    def to_xarray(self) -> xarray.Dataset:
        """Return the numbers and series of all runs in one Dataset.

        Each swept key is a dimension, named by its last part (`load_n`), or by the whole key where
        two share it (`plate.material`). Values without a run, such as those of a run that failed,
        have NaN.

        Returns
        -------
        dataset : xarray.Dataset
            All numbers of `table`: of a sphere `vibration_db` and `released_power_db` with their
            uncertainties, and in `vibration_how` and `released_power_how` whether they are
            computed, estimated or an upper bound; third octaves by `band`, the nominal mid
            frequency; the series of a sphere by `position` and `step` [m], those of a bearing by
            `time` [s]. Runs with places of their own, as under different speeds, are padded with
            NaN, and `position` and `step` have a row per run. Every variable has `units` and
            `long_name` in `attrs`, and the Dataset has the version of the program.

        Raises
        ------
        ValueError
            There is no run, or the runs are not of one sweep.
        """
        from rolling.results.runs_dataset import runs_dataset

        return runs_dataset([*self.values()], self._sweep)


class SweepError(ContactError):
    """Runs of a sweep that failed, beside the successful runs.

    Attributes
    ----------
    failures : dict
        Reasons by the label of the run.
    runs : Runs
        The successful runs, as `simulate_sweep` returns them.

    Examples
    --------
    >>> import rolling
    >>> words = ["sweep.rolling.load_n=[1, 1e7]", "rolling.duration_s=0.002"]
    >>> try:
    ...     rolling.simulate_sweep(rolling.read_scene("quickstart", words), 1, progress=False)
    ... except rolling.SweepError as error:
    ...     print([*error.failures], [*error.runs])
    ['load 1e+07 N'] [1]
    """

    def __init__(self, failures: dict[str, str], runs: Runs) -> None:
        super().__init__("\n".join(f"{label}: {reason}" for label, reason in failures.items()))
        self.failures = failures
        self.runs = runs
