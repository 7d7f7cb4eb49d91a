"""Runs of every kind of scene are drawn, heard and shown by the same code."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from bearing_runs import turning
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from report_runs import runs_of

from rolling import plot
from rolling.figures.catalogue import figures_of, names_of, plot_run

KINDS = ["ball", "bearing"]


def run_of_kind(kind: str) -> Any:
    """Return a run in memory of a kind."""
    return turning() if kind == "bearing" else runs_of("three")[0]


# ---- figures


@pytest.mark.parametrize("kind", KINDS)
def test_every_figure_of_a_kind_is_drawn_by_its_name(kind: str, tmp_path: Path) -> None:
    """By `plot_run`, by the method of the run, and where it has a table as CSV."""
    run = run_of_kind(kind)
    names = names_of([run])
    tabulated = [name for name in names if figures_of([run])[name].table is not None]
    assert len(names) >= 4 and len(tabulated) >= 3
    first = names[0]
    assert [path.name for path in plot_run(run, [first], "svg", tmp_path)] == [f"{first}.svg"]
    assert len(plot_run(run, form="csv", out=tmp_path)) == len(tabulated)
    ax = Figure().subplots()
    assert run.plot(first, ax) is ax and ax.get_title("left")
    assert isinstance(run.plot(ax=Figure().subplots()), Axes)


@pytest.mark.parametrize("kind", KINDS)
def test_a_figure_of_another_kind_is_refused_with_those_of_the_run(kind: str) -> None:
    other = {"ball": "ball_forces", "bearing": "contact_pressure"}[kind]
    own = {"ball": "contact_pressure", "bearing": "ball_forces"}[kind]
    with pytest.raises(ValueError, match=f"{other}: no figure of these runs.* allowed: .*{own}"):
        run_of_kind(kind).plot(other)


@pytest.mark.parametrize("kind", KINDS)
def test_the_spectrum_is_that_of_the_kind(kind: str) -> None:
    ax = plot.spectrum(run_of_kind(kind), Figure().subplots())
    assert ("velocity" if kind == "bearing" else "level") in ax.get_ylabel()


def test_runs_of_two_kinds_have_no_common_figure() -> None:
    with pytest.raises(ValueError, match="got ball, bearing, allowed: runs of one kind"):
        plot_run([run_of_kind(kind) for kind in KINDS])


def test_two_bearings_have_a_figure_each(tmp_path: Path) -> None:
    runs = [replace(turning(), label=label) for label in ("a", "b")]
    paths = plot_run(runs, ["envelope"], "csv", tmp_path)
    assert [path.name for path in paths] == ["envelope-a.csv", "envelope-b.csv"]
    with pytest.raises(ValueError, match="spectrum: got 2 runs, allowed: one run"):
        plot.spectrum(runs)


def test_a_load_distribution_stands_on_any_axes() -> None:
    """Polar axes have the angle around, others along."""
    figure = Figure()
    straight = turning().plot("load_distribution", figure.add_subplot(121))
    polar = turning().plot("load_distribution", figure.add_subplot(122, projection="polar"))
    assert straight.get_xlim() == (0, 360) and polar.name == "polar"
    assert turning().plot("load_distribution").name == "polar"
