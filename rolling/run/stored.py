"""Stored runs, read as finished runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from rolling.results import labels
from rolling.results.run_files import read_run
from rolling.results.run_result import Run
from rolling.run.folder import RunFolder


def open_runs(runs: Sequence[RunFolder]) -> list[Run]:
    """Read runs that are done, with labels that tell them apart; a single run keeps its own."""
    opened = [
        read_run(run.folder, run.scene, run.values, label)
        for label, run in zip(labels.labels(runs), runs, strict=True)
    ]
    if len(opened) == 1:  # perhaps of a sweep, and saved alone
        label = opened[0].summary.get("provenance", {}).get("label") or opened[0].label
        opened[0] = replace(opened[0], label=labels.printable(label))
    return opened
