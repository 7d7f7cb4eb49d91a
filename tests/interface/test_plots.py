"""Public plots draw on given axes, keep texts off other axes, and depend on nothing around them."""

from __future__ import annotations

import hashlib
import io
import os
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache, partial
from itertools import combinations, pairwise
from pathlib import Path
from typing import Any

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pytest
from bearing_runs import turning
from commands import ROOT
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from report_runs import runs_of, single
from scene_text import TINY

from rolling import plot
from rolling.figures.catalogue import comparing_pictures
from rolling.figures.picture import picture as picture_of
from rolling.figures.topography import topography
from rolling.kinds.reading import read_scene
from rolling.numbers.ball_numbers import TurnNumbers
from rolling.report import film
from rolling.report.charts import chart_of
from rolling.results.run_result import Run
from rolling.scene.file import loads
from rolling.surface.parameters import parameters


@pytest.fixture(autouse=True)
def _no_warnings() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


_OF_BEARINGS = (
    "acceleration_signal",
    "ball_forces",
    "envelope",
    "load_distribution",
    "velocity_spectrogram",
)
# All plots by twos, the last one beside the first where their number is odd.
NEIGHBOURS = [*zip(plot.__all__[::2], [*plot.__all__[1::2], plot.__all__[0]], strict=False)]


@pytest.fixture
def three() -> list[Run]:
    return runs_of("three")


def drawing(name: str) -> Callable[[Axes], Axes]:
    """Return a public plot of runs that have all it needs."""
    if name in ("sources", "contact_force", "contact_filter", "mobilities"):
        runs = runs_of("flying")
    elif name == "running_in":
        runs = runs_of("memory")
    elif name.startswith("channel_"):
        (run, *_) = runs_of("flying")
        motion = {"of": "ball", "quantity": "velocity"}
        force = {"of": "contact", "quantity": "force"}
        runs = [replace(run, scene=run.scene.with_({"sound.channels": [motion, force]}))]
    elif name in _OF_BEARINGS:
        runs = [turning()]
    else:
        runs = runs_of("seeds")
    function = getattr(plot, name)
    if name in ("levels", "contact_areas", "quantities"):
        return lambda ax: function(runs, "rolling.load_n", ax=ax)
    if name == "ball_surface":
        return lambda ax: function(read_scene("ball-with-pit"), ax=ax)
    if name in ("mean_third_octaves", "max_level_over_load", "spectra_over_load"):
        return lambda ax: function(runs, ax=ax)
    run = runs[0]
    if name == "modulation":
        turns = TurnNumbers(turns=1.0, band_hz=(562.0, 1122.0), frequency_hz=300.0, prominence=2.0)
        run = replace(run, numbers=replace(run.numbers, turns=turns))
    return lambda ax: function(run, ax=ax)


@pytest.mark.parametrize("name", plot.__all__)
def test_each_plot_draws_on_the_axes_that_it_is_given(name: str) -> None:
    draw = drawing(name)
    for size, columns in (((6.4, 4.8), 2), ((3.5, 2.6), 1)):
        figure = Figure(size)  # without a layout, as `plt.subplots()` makes it
        ax = figure.subplots(1, columns, squeeze=False)[0, 0]
        assert draw(ax) is ax
        assert ax.get_title("left") and ax.get_xlabel() and ax.get_ylabel()
        if columns == 1:
            figure.savefig(io.BytesIO(), format="png", dpi=50)  # leaves no trace in its own dots
        figure.draw_without_rendering()
        names = [label for label in ax.get_xticklabels() if label.get_text()]
        low, high = sorted(ax.get_xlim())
        places = [x.get_window_extent() for x in names if low <= x.get_position()[0] <= high]
        assert all(a.x1 <= b.x0 + 1 or b.x1 <= a.x0 + 1 for a, b in pairwise(places))
        drawn = ax.get_tightbbox()
        assert drawn.y0 >= -1 and drawn.x0 >= -0.02 * figure.bbox.width


@pytest.mark.parametrize("names", NEIGHBOURS, ids="-".join)
def test_texts_stay_in_the_figure_and_off_other_axes(names: tuple[str, str]) -> None:
    """Each plot stands at two opposite corners, so each side is at an edge and at another plot.

    The figure has matplotlib's default size; 2 dots allow for the rounding of letters.
    """
    figure = Figure((6.4, 4.8))
    grid = figure.subplots(2, 2).ravel()
    for name, corners in zip(names, ((0, 3), (1, 2)), strict=True):
        draw = drawing(name)
        for corner in corners:
            draw(grid[corner])
    for _ in range(2):  # letters that were laid out once
        figure.draw_without_rendering()
    boxes = [ax.get_tightbbox() for ax in grid]
    twins = [ax for ax in figure.axes if ax not in grid]  # colour bars and second axes
    everything = [*boxes, *(ax.get_tightbbox() for ax in twins)]
    assert min(min(box.x0, box.y0) for box in everything) >= -2
    assert max(box.x1 - figure.bbox.x1 for box in everything) <= 2
    assert max(box.y1 - figure.bbox.y1 for box in everything) <= 2
    for box, other in combinations([box.padded(-1) for box in boxes], 2):
        assert not box.overlaps(other)


def pixels(figure: Figure) -> np.ndarray:
    """Return the drawn letters and curves of a figure, rows from below."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[::-1].astype(int)


@pytest.mark.slow
@pytest.mark.parametrize(("sides", "layout"), [(2, "constrained"), (3, None)])
def test_a_grid_of_plots_has_whole_titles_and_legends_within_the_axes(
    sides: int, layout: Any
) -> None:
    """All plots stand in grids of the default size; a legend changes dots of its axes only."""
    for first in range(0, len(plot.__all__), sides**2):
        figure = Figure((6.4, 4.8), layout=layout)
        grid = figure.subplots(sides, sides).ravel()
        titles = dict.fromkeys(grid, "")  # of the axes that are left free
        for name, ax in zip(plot.__all__[first:], grid, strict=False):
            draw = drawing(name)
            draw(ax)
            titles[ax] = picture_of(name, draw).caption.title
        for _ in range(2):  # letters that were laid out once
            figure.draw_without_rendering()
        figure.set_layout_engine("none")
        for ax in grid:
            title = ax.get_title("left").replace("\n", " ")
            assert title.startswith(titles[ax])
            extent = ax._left_title.get_window_extent()
            assert extent.x0 >= -2 and extent.x1 <= figure.bbox.x1 + 2
            if legend := ax.get_legend():
                for other in figure.axes:  # what they draw is the same with and without it
                    other.set_visible(other is ax)
                drawn = pixels(figure)
                legend.set_visible(False)
                changed = np.argwhere((pixels(figure) != drawn).any(axis=-1))
                assert len(changed)
                low = ax.bbox.min[::-1] - 5  # letters of the smallest size, in axes of 98 px
                high = ax.bbox.max[::-1] + 5
                assert ((low <= changed) & (changed <= high)).all()


def test_the_surface_of_a_scene_is_drawn_without_a_run(three) -> None:
    """The same picture as that of a run of the scene; a path is refused."""
    drawn = [plot.surface(source).images[0].get_array() for source in (three[0], three[0].scene)]
    np.testing.assert_array_equal(*drawn)
    with pytest.raises(TypeError, match="allowed: Run or Scene"):
        plot.surface("quickstart.yaml")


def test_plots_that_a_run_cannot_have_say_why(three) -> None:
    for draw in (plot.sources, plot.contact_force, plot.mobilities):
        with pytest.raises(ValueError, match="no dynamics"):
            draw(three[0])
    with pytest.raises(ValueError, match="recovery events"):
        plot.recovery_events(three[0])
    with pytest.raises(ValueError, match=r"rolling\.nothing"):
        plot.levels(three, "rolling.nothing")
    with pytest.raises(ValueError, match="no swept key"):
        plot.levels(runs_of("one"))


def test_labels_are_drawn_letter_by_letter() -> None:
    run = replace(runs_of("lap")[0], label="$x_1$ \u05e9 \x07")
    legend = plot.third_octaves([run, replace(run, label="b")], Figure().subplots()).get_legend()
    text = legend.get_texts()[0]
    assert not text.get_parse_math()
    assert single("release_power", run).file("png")


# ---- surroundings

# Settings that a person, a notebook or a matplotlibrc may have made; no TeX is needed to refuse it.
THEME: dict[str, Any] = {
    "axes.facecolor": "black",
    "figure.facecolor": "black",
    "savefig.facecolor": "black",
    "text.color": "white",
    "xtick.color": "red",
    "font.size": 40.0,
    "axes.titlesize": 50.0,
    "legend.fontsize": 50.0,
    "savefig.dpi": 33.0,
    "savefig.bbox": "tight",
    "figure.dpi": 200.0,
    "lines.linewidth": 9.0,
    "axes.prop_cycle": matplotlib.cycler(color=["pink"]),
    "path.sketch": (1.0, 100.0, 2.0),
    "image.cmap": "hot",
    "svg.fonttype": "none",
    "svg.hashsalt": "salt",
}
TEX = {"text.usetex": True, "axes.formatter.use_mathtext": True}


@cache
def drawn_files(surroundings: str) -> list[Any]:
    """Return the bytes of pictures of several runs and of one, and their charts of the page."""
    runs = runs_of("flying")
    pictures = [*comparing_pictures(runs, ["third_octaves"]), single("spectrogram", runs[0], runs)]
    heights = np.random.default_rng(1).standard_normal((40, 40)) * 1e-7
    steps = np.full(2, 1e-6)
    pictures.append(topography("plate", parameters(heights, steps, True), heights, steps, True))
    files = [picture.file("png") for picture in pictures]
    charts = [chart_of(picture) for picture in pictures[:2]]
    return [*files, pictures[0].file("svg"), charts, film.curves(runs[0])]


@pytest.mark.parametrize("surroundings", [THEME, TEX], ids=["theme", "tex"])
def test_files_do_not_depend_on_the_settings_of_the_process(surroundings: dict[str, Any]) -> None:
    clean = drawn_files("clean")
    with matplotlib.rc_context(surroundings):
        before = matplotlib.rcParams.copy()
        opened = plt.get_fignums()
        assert drawn_files(str(surroundings)) == clean
        assert matplotlib.rcParams.copy() == before and plt.get_fignums() == opened


def test_plots_on_own_axes_follow_the_settings_of_the_process(three) -> None:
    with matplotlib.rc_context(THEME):
        before = matplotlib.rcParams.copy()
        ax = plot.third_octaves(three, Figure().subplots())
        assert ax.get_facecolor() == (0.0, 0.0, 0.0, 1.0)
        assert ax.get_xticklabels()[0].get_color() == "red"
        assert matplotlib.rcParams.copy() == before


# Draws a file in surroundings in which matplotlib may refuse its own import, and prints what the
# session sees afterwards.
IN_A_FOLDER = """
import hashlib
import os
import sys
from functools import partial

from scene_text import TINY

variables, place = dict(os.environ), os.getcwd()
from rolling import plot
from rolling.figures.picture import picture
from rolling.kinds.reading import read_scene
from rolling.scene.file import loads

draw = partial(plot.surface, loads(TINY))
print(hashlib.sha256(picture("surface", draw).file("png")).hexdigest())
assert dict(os.environ) == variables and os.getcwd() == place
assert "matplotlib.pyplot" not in sys.modules
import matplotlib

print(matplotlib.get_backend(auto_select=False))
if not matplotlib.rcParams["text.usetex"]:  # TeX may be missing, which is the person's own affair
    print(draw().get_xlabel())
"""


@pytest.mark.parametrize(
    ("backend", "settings", "taken"),
    [
        ("nonsense", b"font.size: \xff\xfe", "None"),  # matplotlib chooses one for a window
        *(
            pytest.param(*values, marks=pytest.mark.slow)
            for values in (
                ("module://no_such.backend", b"", "module://no_such.backend"),
                ("agg", b"text.usetex: True\nfont.size: 30\nbackend: nonsense", "agg"),
            )
        ),
    ],
)
def test_backends_and_settings_files_that_matplotlib_refuses_cost_nothing(
    backend: str, settings: bytes, taken: str, tmp_path: Path
) -> None:
    """Environment, folder and the backend by `MPLBACKEND` stay as the session has them."""
    clean = picture_of("surface", partial(plot.surface, loads(TINY))).file("png")
    (tmp_path / "matplotlibrc").write_bytes(settings)
    paths = [str(ROOT), str(ROOT / "tests" / "support")]
    done = subprocess.run(
        [sys.executable, "-P", "-c", IN_A_FOLDER],
        cwd=tmp_path,
        env=os.environ | {"MPLBACKEND": backend, "PYTHONPATH": os.pathsep.join(paths)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    digest, own, *label = done.stdout.splitlines()
    assert digest == hashlib.sha256(clean or b"").hexdigest() and own == taken
    assert label == ([] if b"usetex" in settings else ["along the track [µm]"])
    assert ("backend cannot be loaded" in done.stderr) == backend.startswith("module://")
