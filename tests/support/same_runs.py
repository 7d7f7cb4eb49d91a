"""Two folders of the same sweep compared: tables byte for byte, and series bit by bit."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import h5py
import numpy as np

from rolling.folders import run_record

# Ends of the columns that hold times of the machine. A run that was killed just after the choice of
# its tolerance finds it in resolved.yaml, and takes it as given.
LEFT_OUT = ("seconds", "step_ms", "tolerance_chosen")
TABLES = ("runs.csv", "bands.csv", "statistics.csv")  # of `rolling table`
SERIES = ("release_energy", "approach", "residual", "sound/pressure")


def table(path: Path) -> bytes:
    """Return a table of a sweep without the columns that are left out."""
    with path.open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    kept = [name for name in rows[0] if not name.endswith(LEFT_OUT)]
    written = io.StringIO()
    writer = csv.DictWriter(written, kept, extrasaction="ignore")
    writer.writeheader()
    writer.writerows(rows)
    return written.getvalue().encode()


def differences(one: Path, other: Path) -> list[str]:
    """Return the names of tables, series and records that differ between two folders."""
    faults = [name for name in TABLES if table(one / name) != table(other / name)]
    record = run_record.read(one)
    assert record is not None
    for run in record.runs:
        faults += [f"{run}/{name}" for name in series_that_differ(one / run, other / run)]
    return faults


def series_that_differ(one: Path, other: Path) -> list[str]:
    """Return the names of the series of two runs that differ in any bit."""
    with h5py.File(one / "result.h5") as first, h5py.File(other / "result.h5") as second:
        faults = [name for name in SERIES if not np.array_equal(first[name][:], second[name][:])]
    if (one / "signal.wav").read_bytes() != (other / "signal.wav").read_bytes():
        faults.append("signal.wav")
    return faults
