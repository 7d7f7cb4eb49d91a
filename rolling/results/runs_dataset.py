"""Runs of a sweep as one xarray Dataset, whose dimensions are the swept keys."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import rolling
from acoustics.bands import MID_HZ, NOMINAL_HZ
from rolling.archive.definition import Variable
from rolling.kinds.registry import kind_of
from rolling.numbers import views
from rolling.numbers.fields import leaves
from rolling.numbers.quantity import BandQuantity
from rolling.results.labels import named
from rolling.scene.sweep import Value

if TYPE_CHECKING:
    import xarray


class _Swept(NamedTuple):
    """A swept key: its name in the Dataset, and its values."""

    key: str
    name: str
    values: list[Value]


def runs_dataset(runs: Sequence[Any], sweep: Mapping[str, Iterable[Value]]) -> xarray.Dataset:
    """Return the numbers and series of runs, with NaN for combinations without a run.

    `sweep` are the values of the swept keys; those of the runs count where it is empty.

    Raises
    ------
    ValueError : there is no run, or the runs have no swept values, or not the same swept keys.
    """
    import xarray  # slow to import

    swept = _swept_keys(runs, sweep)
    shape = tuple(len(key.values) for key in swept)
    dimensions = tuple(key.name for key in swept)
    places = {_place_of(run, swept): run for run in runs}
    taken = set(dimensions)
    dataset = xarray.Dataset(
        coords={key.name: _coordinate(key) for key in swept},
        attrs={
            "title": f"sweep of {runs[0].scene.name}: {', '.join(key.key for key in swept)}",
            "program": f"rolling-contact-noise {rolling.__version__}",
        },
    )
    for name, (values, attributes) in _numbers(places, shape).items():
        if name not in taken:
            dataset[name] = (dimensions, values, attributes)
    _add_bands(dataset, places, dimensions, shape)
    _add_series(dataset, places, dimensions, shape)
    return dataset


# ---- swept keys


def _swept_keys(runs: Sequence[Any], sweep: Mapping[str, Iterable[Value]]) -> list[_Swept]:
    """Return the swept keys with their values, by their last part where no two share it."""
    if not runs:
        raise ValueError("runs: there is none; a Dataset needs one at least")
    keys = list(sweep) or list(runs[0].values)
    if not keys:
        raise ValueError("runs: none of them is of a sweep; `run.to_xarray()` is for a single run")
    for run in runs:
        if set(run.values) != set(keys):
            got = ", ".join(run.values) or "nothing"
            raise ValueError(f"runs: {run.label} sweeps {got}, allowed: {', '.join(keys)}")
    last_parts = [key.rpartition(".")[2] for key in keys]
    swept = []
    for key, last in zip(keys, last_parts, strict=True):
        # The values of the sweep give the order; runs that were added later may have others.
        of_sweep = list(sweep.get(key, ()))
        of_runs = [run.values[key] for run in runs]
        values = list(dict.fromkeys(of_sweep + of_runs))
        is_unique = last_parts.count(last) == 1
        swept.append(_Swept(key, last if is_unique else key, values))
    return swept


def _place_of(run: Any, swept: Sequence[_Swept]) -> tuple[int, ...]:
    """Return the place of a run among the swept values."""
    return tuple(key.values.index(run.values[key.key]) for key in swept)


def _coordinate(swept: _Swept) -> Any:
    """Return the coordinate of a swept key: numbers, or texts where one of the values is a text."""
    word, unit = named(swept.key)
    attributes = {"long_name": word, "key": swept.key}
    if unit:
        attributes["units"] = unit
    if any(isinstance(value, str) for value in swept.values):
        texts = [value if isinstance(value, str) else f"{value:g}" for value in swept.values]
        return (swept.name, np.array(texts, dtype=object), attributes)
    return (swept.name, np.array(swept.values), attributes)


# ---- numbers

Places = Mapping[tuple[int, ...], Any]
Values = tuple[NDArray[Any], dict[str, str]]


def _numbers(places: Places, shape: tuple[int, ...]) -> dict[str, Values]:
    """Return the single numbers of runs, and the texts of the two quantities, by their columns."""
    arrays: dict[str, Values] = {}
    for place, run in places.items():
        for name, cell in views.columns(run.numbers).items():
            is_number = isinstance(cell.value, int | float) and not isinstance(cell.value, bool)
            is_text = isinstance(cell.value, str) and cell.number_field.in_table
            if not is_number and not is_text:
                continue
            if name not in arrays:
                empty = np.full(shape, np.nan) if is_number else np.full(shape, "", dtype=object)
                attributes = {"long_name": cell.number_field.meaning}
                if is_number:
                    attributes["units"] = cell.number_field.unit
                arrays[name] = empty, attributes
            arrays[name][0][place] = cell.value
    return arrays


def _add_bands(
    dataset: xarray.Dataset, places: Places, dimensions: tuple[str, ...], shape: tuple[int, ...]
) -> None:
    """Add the third octaves, by the nominal mid frequencies of their bands."""
    arrays: dict[str, Values] = {}
    for place, run in places.items():
        for path, number_field, bands in leaves(run.numbers):
            if not isinstance(bands, BandQuantity):
                continue
            name = "_".join(path)
            values = {name: (bands.value, bands.unit, number_field.meaning)}
            if bands.uncertainty is not None:
                words = f"standard uncertainty: {number_field.meaning}"
                values[f"{name}_uncertainty"] = (bands.uncertainty, "dB", words)
            for column, (numbers, unit, words) in values.items():
                if column not in arrays:
                    empty = np.full((*shape, len(NOMINAL_HZ)), np.nan)
                    arrays[column] = empty, {"units": unit, "long_name": words}
                arrays[column][0][place] = [
                    math.nan if number is None else number for number in numbers
                ]
    if not arrays:
        return
    of_band = {"units": "Hz", "long_name": "nominal mid frequency of the third octave"}
    of_exact = {"units": "Hz", "long_name": "exact mid frequency of the third octave"}
    dataset.coords["band"] = ("band", np.array(NOMINAL_HZ, dtype=float), of_band)
    dataset.coords["band_exact"] = ("band", MID_HZ.copy(), of_exact)
    for column, (array, attributes) in arrays.items():
        dataset[column] = ((*dimensions, "band"), array, attributes)


# ---- series


def _add_series(
    dataset: xarray.Dataset, places: Places, dimensions: tuple[str, ...], shape: tuple[int, ...]
) -> None:
    """Add the series of runs, each padded with NaN to the longest.

    Where all runs have the same places along a dimension, these are coordinates. Otherwise each run
    has its own, and the dimension counts them.
    """
    by_place = {place: _by_name(run) for place, run in places.items()}
    first, *others = by_place.values()
    lengths: dict[str, int] = {}
    for of_run in by_place.values():
        for variable, values in of_run.values():
            for axis, length in zip(variable.axes, values.shape, strict=True):
                lengths[axis] = max(length, lengths.get(axis, 0))
    axis_names = {}  # in the Dataset
    for axis in lengths:
        is_shared = axis not in first or all(
            np.array_equal(first[axis][1], other[axis][1]) for other in others
        )
        axis_names[axis] = axis if is_shared else f"{axis}_number"
    for name, (variable, values) in first.items():
        attributes = {"units": variable.unit, "long_name": variable.long_name}
        if axis_names.get(name) == name:  # the places along a dimension, which all runs share
            dataset.coords[name] = (name, values, attributes)
            continue
        longest = tuple(lengths[axis] for axis in variable.axes)
        padded = np.full(shape + longest, np.nan)
        for place, of_run in by_place.items():
            _, own = of_run[name]
            padded[place][tuple(map(slice, own.shape))] = own
        axes = tuple(axis_names[axis] for axis in variable.axes)
        stored = ((*dimensions, *axes), padded, attributes)
        if variable.is_coordinate:
            dataset.coords[name] = stored
        else:
            dataset[name] = stored


def _by_name(run: Any) -> dict[str, tuple[Variable, NDArray[Any]]]:
    """Return the arrays of a run with their definitions, by name."""
    series = kind_of(run.scene).series(run)
    return {variable.name: (variable, values) for variable, values in series.items()}
