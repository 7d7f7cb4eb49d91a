"""Pictures of error over processor time of this program and of public solvers.

They draw what tests/benchmarks/speed_against_error.py measured and stored.
"""

from __future__ import annotations

import json
import statistics
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from build_cache import ROOT
from drawn_pictures import Drawn, new_figure
from matplotlib.figure import Figure

from acoustics.numbers import rounded
from acoustics.plot_style import COLOURS, MARKERS, gridded

STORED = ROOT / "tests" / "benchmarks" / "speed_against_error.json"
OURS = "this program"
NAMES = {
    OURS: OURS,
    "aspher": "aspher",
    "slippy": "slippy",
    "tamaas": "tamaas",
    "contactmechanics": "ContactMechanics",
}
SEQUENCES = {
    "A": "A: elastic, 0.1 µm, 20 N",
    "B": "B: yielding, 0.1 µm, 20 N",
    "C": "C: yielding, 1 µm, 100 N",
    "D": "D: elastic, 0.5 µm, 20 N",
    "L": "L: elastic, 1 µm, 60 N",
}
EASY_ERROR = 1e-11  # [m], at which the table compares
HARD_ERROR = 1e-6  # of the deflection
EXACT = 1e-10  # of the deflection: a smaller error is drawn here
NOT_REACHED = "-"

Curve = Sequence[Sequence[float]]  # points of tolerance, ms of a step, gap error, load error


def measured() -> dict[str, Any]:
    """Return the stored measurement: its programs, and what counts as solved."""
    content: dict[str, Any] = json.loads(STORED.read_text(encoding="utf-8"))
    return content


def ms_at(curve: Curve, error: float) -> float | None:
    """Return the time of a step [ms] at which a curve reaches an error, or None if it does not.

    It lies on the straight line between two points in logarithms. A curve whose first point is
    better than asked has the time of this point.
    """
    if not curve:
        return None
    if curve[0][2] <= error:
        return curve[0][1]
    for (_, slow_ms, large, _), (_, ms, small, _) in pairwise(curve):
        if small <= error < large:
            share = np.log(large / error) / np.log(large / max(small, 1e-3 * error))
            return float(slow_ms * (ms / slow_ms) ** share)
    return None


def easy(scenes: Mapping[str, Any]) -> Drawn:
    """Draw the gap error over the time of a step on sequences of a rolling sphere."""
    programs = measured()["programs"]
    curves = {
        words: {program: stored["easy"].get(name, []) for program, stored in programs.items()}
        for name, words in SEQUENCES.items()
    }
    figure = _panels(curves, "gap error [m]", floor=0.0)
    numbers = _facts(programs) | _comparison(curves, EASY_ERROR) | {"error": "1e-11 m"}
    return Drawn(figure, numbers)


def hard(scenes: Mapping[str, Any]) -> Drawn:
    """Draw the gap error over time on hard scenes, and count the scenes that are solved."""
    programs = measured()["programs"]
    titles = list(programs[OURS]["hard"])
    curves = {
        title: {program: stored["hard"].get(title, []) for program, stored in programs.items()}
        for title in titles
    }
    figure = _panels(curves, "gap error over deflection [-]", floor=EXACT)
    numbers = _comparison(curves, HARD_ERROR) | _counts(programs) | {"error": "1e-6"}
    return Drawn(figure, numbers)


def _panels(curves: Mapping[str, Mapping[str, Curve]], error_label: str, floor: float) -> Figure:
    """Draw a panel for each scene, with a curve for each program, and the legend."""
    figure = new_figure(5.2)
    axes = figure.subplots(2, 3, sharex=True, sharey=True).ravel()
    for ax, (title, by_program) in zip(axes, curves.items(), strict=False):
        for number, (program, name) in enumerate(NAMES.items()):
            points = by_program.get(program, [])
            ax.plot(
                [point[1] for point in points],
                [max(point[2], floor) for point in points],
                marker=MARKERS[number],
                markersize=4,
                linewidth=1.2,
                color=COLOURS[number],
                label=name,
            )
        ax.set(xscale="log", yscale="log")
        gridded(ax, xlabel="", ylabel="")
        ax.minorticks_off()
        ax.tick_params(length=0)
        ax.grid(visible=False, which="minor")
        ax.set_title(title, fontsize=9)
    for ax in axes[len(curves) :]:
        ax.set_visible(False)
    figure.supxlabel("processor time of a step [ms]", fontsize="medium")
    figure.supylabel(error_label, fontsize="medium")
    handles, names = axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper left", ncols=5, frameon=False, fontsize=9)
    axes[0].xaxis.set_major_formatter("{x:g}")
    return figure


def _facts(programs: Mapping[str, Any]) -> dict[str, str]:
    """Return when, with what and where it was measured."""
    versions = [f"{NAMES[program]} {programs[program]['version']}" for program in _peers(programs)]
    dates = sorted({stored["date"] for stored in programs.values()})
    machine = programs[OURS]["machine"]
    note = f"; {machine['note']}" if machine["note"] else ""
    words = f"Measured on {' and '.join(dates)} with {', '.join(versions)}, on one core"
    return {"measured": f"{words} ({machine['cpu']}{note})."}


def _peers(programs: Mapping[str, Any]) -> list[str]:
    """Return the names of the public solvers that were measured."""
    return [program for program in NAMES if program in programs and program != OURS]


def _comparison(curves: Mapping[str, Mapping[str, Curve]], error: float) -> dict[str, str]:
    """Return the rows of the table of times at equal error, and the ends of the ratios."""
    rows = {}
    ratios = []
    for number, (title, by_program) in enumerate(curves.items()):
        times = {program: ms_at(by_program.get(program, []), error) for program in NAMES}
        others = {
            program: ms for program, ms in times.items() if ms is not None and program != OURS
        }
        own_ms = times[OURS]
        ratio = NOT_REACHED
        if others and own_ms is not None:
            fastest = min(others, key=lambda program: others[program])
            ratios.append(others[fastest] / own_ms)
            ratio = f"{rounded(ratios[-1])} ({NAMES[fastest]})"
        cells = [NOT_REACHED if ms is None else rounded(ms) for ms in times.values()]
        rows[f"row {number}"] = f"|{'|'.join([title, *cells, ratio])}|"
    ends = {"least": rounded(min(ratios)), "most": rounded(max(ratios))}
    return rows | ends


def _counts(programs: Mapping[str, Any]) -> dict[str, str]:
    """Return rows on how many hard scenes each program solves, and its time over that of ours."""
    own = programs[OURS]["many"]
    texts = {"scenes": str(len(own)), "own": str(sum(ms is not None for ms in own.values()))}
    for program in _peers(programs):
        times = programs[program]["many"]
        solved = {name: ms for name, ms in times.items() if ms is not None}
        ratios = [ms / own[name] for name, ms in solved.items() if own.get(name) is not None]
        faster = sum(ratio < 1 for ratio in ratios)
        cells = [
            NAMES[program],
            f"{len(solved)} of {len(times)}",
            rounded(statistics.median(ratios)) if ratios else NOT_REACHED,
            str(faster),
        ]
        texts[f"count {program}"] = f"|{'|'.join(cells)}|"
    return texts
