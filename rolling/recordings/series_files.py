"""Files of measured series that are no sound files: CSV, .npz, .mat of version 5, and UFF.

Anybody may have made them. Names, types and sizes are judged before a value is read, and series of
real numbers alone are read.
"""

from __future__ import annotations

import io
import tempfile
import warnings
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array
from acoustics.texts import printable
from rolling.archive.mat_file import mat_variables, read_mat_array
from rolling.archive.npz_file import npz_arrays, read_npz_array
from rolling.scene.messages import nearest
from rolling.terminal.whole_files import FolderError, read_regular, write_bytes

FORMATS = "CSV, npz, mat (version 5), UFF"
LEAST_SAMPLES = 1000  # of a series; fewer numbers are facts about the measurement
MAX_COLUMNS = 64  # of an array
_MAX_UFF_BYTES = 50_000_000  # which take some ten times as much memory
_MAX_LISTED = 12  # series that a message names
_MAX_NAME = 60  # letters of a name in a message
_EQUAL_STEPS = 0.02  # of a step, by which times that are rounded may differ from equal steps
_SEPARATORS = (";", "\t", ",")
_OF_TIME = 1  # type of a function in a file of UFF
_EVEN = 1  # spacing of its places


class FileLayout(NamedTuple):
    """What a file of series does not say, or which of its series are meant.

    variables : sequence of str. Names of series, one for each channel. Default: the only one.
    rate_hz : float or None, Hz. Sample rate. Default: the file says it.
    """

    variables: Sequence[str] = ()
    rate_hz: float | None = None


class MeasuredSeries(NamedTuple):
    """Series of a file.

    samples : (n, channels) array, in the unit of the file.
    rate_hz : float, Hz. Sample rate.
    """

    samples: Array
    rate_hz: float


class _Found(NamedTuple):
    """Series that a file has: its name, numbers and sample rate, and what reads it."""

    name: str
    length: int
    rate_hz: float | None
    read: Callable[[], NDArray[Any]]

    @property
    def words(self) -> str:
        """Name and size, for a message."""
        return f"{printable(self.name)[:_MAX_NAME]} ({self.length:,} numbers)"


def is_series_file(path: Path) -> bool:
    """Tell whether the ending of a name is of a file of series."""
    return path.suffix.lower() in _READERS


def read_series(
    path: Path, layout: FileLayout, *, most_bytes: int, most_sample_bytes: int
) -> MeasuredSeries:
    """Read the series of a file.

    Parameters
    ----------
    path : Path
        File with the ending .csv, .txt, .npz, .mat, .uff or .unv.
    layout : FileLayout
        Which series are meant, and their rate.
    most_bytes, most_sample_bytes : int
        Size of the file, and of a series that is unpacked.

    Raises
    ------
    FolderError : the file is damaged, too large or of another format; it has no such series, or
        several and none is named; or the sample rate is not known.
    """
    try:
        content = read_regular(path, most_bytes)
        series_list = _READERS[path.suffix.lower()](content, most_sample_bytes)
        chosen = _chosen(path, series_list, layout.variables)
        columns = [np.asarray(series.read(), dtype=float).ravel() for series in chosen]
    except FolderError:
        raise
    except OSError as error:
        raise FolderError(f"{path}: not readable ({error.strerror or error})") from error
    except Exception as error:  # values of a hostile file lead to any kind
        text = " ".join(str(error).split())[:200] or type(error).__name__
        raise FolderError(
            f"{path}: no series that can be read ({printable(text)}), allowed: {FORMATS} of real"
            " numbers"
        ) from error
    lengths = {len(column) for column in columns}
    if len(lengths) > 1:
        raise FolderError(
            f"{path}: got series of {' and '.join(f'{n:,}' for n in sorted(lengths))} numbers,"
            " allowed: equal lengths; name one by --variable"
        )
    return MeasuredSeries(np.stack(columns, axis=1), _rate_hz(path, chosen, layout.rate_hz))


def _chosen(path: Path, series_list: Sequence[_Found], names: Sequence[str]) -> list[_Found]:
    """Return the series that are meant: the named ones, or the only one that is long enough."""
    listed = ", ".join(series.words for series in series_list[:_MAX_LISTED]) or "nothing of numbers"
    if len(series_list) > _MAX_LISTED:
        listed += f", and {len(series_list) - _MAX_LISTED} more"
    by_name = {series.name: series for series in series_list}
    for name in names:
        if name not in by_name:
            near = nearest(name, [*by_name])
            raise FolderError(f"--variable: got {name}{near}; {path} has {listed}")
    if names:
        return [by_name[name] for name in names]
    long = [series for series in series_list if series.length >= LEAST_SAMPLES]
    if len(long) != 1:
        raise FolderError(
            f"{path}: got {len(long)} series of at least {LEAST_SAMPLES:,} numbers, allowed: one;"
            f" name it by --variable. The file has {listed}"
        )
    return long


def _rate_hz(path: Path, chosen: Sequence[_Found], given_hz: float | None) -> float:
    """Return the sample rate [Hz] of series by the file, or by the option."""
    own = {series.rate_hz for series in chosen if series.rate_hz is not None}
    if given_hz is not None:
        own.add(given_hz)
    if not own:
        raise FolderError(f"{path}: no sample rate in it; give it by --rate HZ")
    if max(own) > (1 + 1e-3) * min(own):
        rates = " and ".join(f"{rate:.6g}" for rate in sorted(own))
        raise FolderError(f"{path}: got sample rates of {rates} Hz, allowed: one for all series")
    return given_hz or min(own)


# ---- formats


def _series_of_array(name: str, shape: tuple[int, ...], read: Callable[[], Any]) -> list[_Found]:
    """Return the series of an array: all of it if it is one line, otherwise its columns."""
    count = int(np.prod(shape)) if shape else 0
    lengths = [length for length in shape if length != 1]
    if len(lengths) <= 1:
        return [_Found(name, count, None, read)] if count else []
    if len(shape) != 2 or min(shape) > MAX_COLUMNS:
        return []
    axis = 1 if shape[0] >= shape[1] else 0
    return [
        _Found(f"{name}:{number + 1}", max(shape), None, partial(_line_of, read, number, axis))
        for number in range(min(shape))
    ]


def _line_of(read: Callable[[], NDArray[Any]], number: int, axis: int) -> NDArray[Any]:
    """Read an array, and return one of its rows or columns."""
    return np.asarray(np.take(read(), number, axis=axis))


def _npz(content: bytes, most_bytes: int) -> list[_Found]:
    """Return the series of an archive of numpy."""
    series_list = []
    for array in npz_arrays(content, most_bytes):
        name = array.name
        series_list += _series_of_array(name, array.shape, partial(read_npz_array, content, name))
    return series_list


def _mat(content: bytes, most_bytes: int) -> list[_Found]:
    """Return the series of a file of MATLAB."""
    series_list = []
    for variable in mat_variables(content, most_bytes):
        series_list += _series_of_array(
            variable.name,
            variable.shape,
            partial(read_mat_array, content, variable),
        )
    return series_list


def _csv(content: bytes, most_bytes: int) -> list[_Found]:
    """Return the columns of a text, whose first line may name them, and their rate by a time."""
    import pandas as pd  # slow to import

    text = content.decode("latin-1").removeprefix("\xef\xbb\xbf")
    first = next((line for line in text.splitlines() if line.strip() and line[0] != "#"), "")
    separator = next((sign for sign in _SEPARATORS if sign in first), None)
    fields = [field.strip().strip('"') for field in first.strip().split(separator)]
    has_names = not all(_is_number(field) for field in fields)
    if has_names and len(set(fields)) < len(fields):
        raise ValueError("two columns with one name")
    table = pd.read_csv(
        io.StringIO(text),
        sep=separator or r"\s+",
        comment="#",
        header=None,
        skiprows=text.splitlines().index(first) + 1 if has_names else 0,
        dtype=float,
        index_col=False,
    )
    if table.shape[1] > MAX_COLUMNS:
        raise ValueError(f"{table.shape[1]} columns, allowed: {MAX_COLUMNS}")
    values = table.to_numpy()
    names = fields if has_names else [f"column {number + 1}" for number in range(values.shape[1])]
    if len(names) != values.shape[1]:
        raise ValueError(f"{len(names)} names for {values.shape[1]} columns")
    rate_hz = _rate_of_times(values[:, 0]) if values.shape[1] > 1 else None
    first_column = 0 if rate_hz is None else 1
    return [
        _Found(names[number], len(values), rate_hz, partial(np.take, values, number, axis=1))
        for number in range(first_column, values.shape[1])
    ]


def _is_number(field: str) -> bool:
    """Tell whether a text is a number."""
    try:
        float(field)
    except ValueError:
        return False
    return True


def _rate_of_times(times: Array) -> float | None:
    """Return the rate [Hz] of times [s] that rise in equal steps; None for other numbers."""
    if len(times) < LEAST_SAMPLES or not np.isfinite(times).all():
        return None
    step = (times[-1] - times[0]) / (len(times) - 1)
    even = times[0] + step * np.arange(len(times))
    is_even = step > 0 and np.abs(times - even).max() <= _EQUAL_STEPS * step
    return float(1 / step) if is_even else None


def _uff(content: bytes, most_bytes: int) -> list[_Found]:
    """Return the functions of time of a file of UFF, its sets of type 58."""
    try:
        import pyuff
    except ImportError as error:
        raise ValueError(
            'UFF needs the package pyuff: pip install "rolling-contact-noise[recordings]"'
        ) from error
    if len(content) > _MAX_UFF_BYTES:
        raise ValueError(f"a file of {len(content):,} bytes, allowed: {_MAX_UFF_BYTES:,}")
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of sets that are not read
        copy = Path(folder, "series.uff")
        write_bytes(copy, content)
        file = pyuff.UFF(str(copy))
        numbers = [number for number, kind in enumerate(file.get_set_types()) if int(kind) == 58]
        sets = [file.read_sets(number) for number in numbers]
    functions = list[_Found]()
    for function in sets:
        values = np.asarray(function["data"])
        is_series = function["func_type"] == _OF_TIME and function["abscissa_spacing"] == _EVEN
        if not is_series or values.ndim != 1 or values.dtype.kind not in "fiu":
            continue
        name = str(function.get("id1", "")).strip() or f"set {len(functions) + 1}"
        if name in [other.name for other in functions]:
            name = f"{name}, set {len(functions) + 1}"
        step_s = float(function["abscissa_inc"])
        rate_hz = 1 / step_s if step_s > 0 else None
        functions.append(_Found(name, len(values), rate_hz, partial(np.asarray, values)))
    return functions


_READERS: dict[str, Callable[[bytes, int], list[_Found]]] = {
    ".csv": _csv,
    ".txt": _csv,
    ".npz": _npz,
    ".mat": _mat,
    ".uff": _uff,
    ".unv": _uff,
}
