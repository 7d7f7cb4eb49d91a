"""Charts are drawn without a script, too: by their numbers, thinned to what pixels show."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from bearing_runs import turning
from matplotlib.figure import Figure
from report_runs import runs_of

from acoustics.arrays import Array
from rolling.figures.catalogue import comparing_pictures, single_names, single_picture
from rolling.figures.picture import finish, picture
from rolling.report.chart_scale import THIN, Scale, ticks
from rolling.report.chart_svg import STRAY, chart_svg, line_path
from rolling.report.charts import Chart, chart_of

AXIS = {"label": "x", "unit": "", "log": False, "names": []}


def places_of(path: str) -> list[Array]:
    """Return the places of each stretch of a path of relative lines."""
    stretches = []
    for x, y, steps in re.findall(r"M(-?\d+) (-?\d+)(?:l([^MZ]*))?", path):
        numbers = np.array([int(text) for text in re.findall(r"-?\d+", steps)]).reshape(-1, 2)
        stretches.append(np.vstack([[int(x), int(y)], numbers]).cumsum(axis=0))
    return stretches


def distance_to(line: Array, place: Array) -> float:
    """Return the distance of a place from a line of straight pieces."""
    begin, end = line[:-1], line[1:]
    along = end - begin
    length = np.maximum((along**2).sum(axis=1), 1e-30)
    share = np.clip(((place - begin) * along).sum(axis=1) / length, 0, 1)
    return float(np.hypot(*(begin + share[:, None] * along - place).T).min())


# ---- lines


@pytest.mark.parametrize("count", [2, 40, 300])
def test_a_thinned_line_passes_all_its_places(count: int) -> None:
    """A line strays by the tolerance and by half a unit of rounding along each axis."""
    rng = np.random.default_rng(count)
    x = np.linspace(0, 900, count)
    y = 200 + 80 * np.sin(x / 40) + rng.normal(0, 1, count)
    (line,) = places_of(line_path(x, y))
    strays = [distance_to(line, place) for place in np.column_stack((x, y))]
    assert max(strays) <= STRAY + math.sqrt(0.5)
    assert len(line) <= count


def test_a_dense_line_keeps_its_extremes_and_is_short() -> None:
    rng = np.random.default_rng(1)
    x = np.linspace(0, 900, 100_000)
    y = rng.normal(200, 20, len(x))
    path = line_path(x, y)
    (line,) = places_of(path)
    assert (line[:, 1].min(), line[:, 1].max()) == (round(y.min()), round(y.max()))
    assert len(path) < 8000


def test_a_line_breaks_where_a_number_is_missing() -> None:
    y = np.array([1.0, 2, math.nan, 4, 50, math.nan, 7])
    stretches = places_of(line_path(10.0 * np.arange(7), y))
    assert [stretch[0].tolist() for stretch in stretches] == [[0, 1], [30, 4], [60, 7]]
    assert line_path(np.arange(3.0), np.full(3, math.nan)) == ""


# ---- axes


@pytest.mark.parametrize(
    ("limits", "is_log", "unit", "room", "words"),
    [
        ([0, 100], False, "", 6, ["0", "20", "40", "60", "80", "100"]),
        ([-0.3, 0.3], False, "", 3, ["\u22120.2", "0", "0.2"]),
        ([20, 20000], True, "Hz", 4, ["100", f"1{THIN}k", f"10{THIN}k"]),
        ([1e-9, 1e-6], True, "W", 4, ["10⁻⁹", "10⁻⁸", "10⁻⁷", "10⁻⁶"]),
        ([0, 6000], False, "Hz", 8, ["0", f"2{THIN}k", f"4{THIN}k", f"6{THIN}k"]),
        ([5, 5], False, "", 6, ["5"]),
    ],
)
def test_ticks_are_round(
    limits: list[float], is_log: bool, unit: str, room: float, words: list[str]
) -> None:
    axis = AXIS | {"limits": limits, "log": is_log, "unit": unit}
    assert [text for _, text in ticks(axis, room)] == words


def test_named_ticks_leave_out_names_that_have_no_room() -> None:
    names = [(float(10 * k), f"{k}") for k in range(1, 13)]
    axis = AXIS | {"limits": [0, 130], "names": names}
    assert [text for _, text in ticks(axis, 12)] == [f"{k}" for k in range(1, 13)]
    assert [text for _, text in ticks(axis, 5)] == ["1", "4", "7", "10"]


def test_places_of_a_logarithmic_axis_are_even_by_decade() -> None:
    scale = Scale.of(AXIS | {"limits": [1, 1000], "log": True}, 0, 300)
    assert scale.places([1, 10, 100]).tolist() == pytest.approx([0, 100, 200])
    assert np.isnan(scale.places([0, -1, None])).all()


# ---- charts


def chart(draw) -> Chart:
    """Return the chart of what a function draws on axes."""
    return chart_of(picture("drawn", lambda ax: finish(draw(ax) or ax, "Title", ["note"])))


def test_a_drawing_has_the_numbers_of_its_chart() -> None:
    def draw(ax) -> None:
        ax.errorbar([1, 2, 3], [10, 20, 15], [1, 2, 3], label="levels <b>")
        ax.set(xlabel="load [N]", ylabel="level [dB]", xlim=(1, 3), ylim=(0, 40))

    drawn = chart(draw)
    svg = str(chart_svg(drawn))
    assert "levels &lt;b&gt;" in svg and "load [N]" in svg and "level [dB]" in svg
    (line,) = places_of(re.search(r'class="line"[^>]* d="([^"]+l[^"]+)"', svg)[1])
    left, right = line[0][0], line[-1][0]
    frame = re.search(r'class="frame" d="M(\d+) (\d+)H(\d+)"', svg)
    assert (left, right) == (int(frame[1]), int(frame[3]))
    heights = (int(frame[2]) - line[:, 1]) / 460
    assert heights == pytest.approx([10 / 40, 20 / 40, 15 / 40], abs=2 / 460)
    bars = re.findall(r"M\d+ (\d+)V(\d+)", re.search(r'class="errors"[^>]* d="([^"]+)"', svg)[1])
    spreads = [(int(low) - int(high)) / 460 * 40 for low, high in bars]
    assert spreads == pytest.approx([2, 4, 6], abs=0.2)


@pytest.mark.slow
def test_every_chart_of_runs_is_drawn_and_small() -> None:
    """Of all figures of balls and of a bearing; a curve of many points has those that one sees."""
    runs = runs_of("three")
    pictures = [*comparing_pictures(runs)]
    for run in (runs[0], turning()):
        pictures += [single_picture(name, run) for name in single_names(run)]
    charts = [chart_of(drawn) for drawn in pictures if drawn and not _is_polar(drawn.figure)]
    assert len(charts) > 10
    for drawn in charts:
        svg = str(chart_svg(drawn))
        assert re.search(r'<(?:path class="(?:line|dots|bar|band|errors)|image)', svg), drawn[
            "name"
        ]
        places = " ".join(re.findall(r' (?:d|x|y|width|height|viewBox)="([^"]*)"', svg))
        assert not re.search("nan|inf|None", places), drawn["name"]
        assert "<image" in svg or len(svg) < 40_000, drawn["name"]


def _is_polar(figure: Figure) -> bool:
    return any(ax.name == "polar" for ax in figure.axes)
