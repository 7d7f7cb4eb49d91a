"""Pages of every kind are lists of parts: their charts are SVG, and their answer is in sight."""

from __future__ import annotations

import html
import math
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import soundfile
from bearing_runs import WAVY, loads_bearing, turning
from finished import VIBRATING, marched
from matplotlib.figure import Figure
from report_browser import axe_findings, data_of
from report_runs import runs_of

import rolling as rc
from rolling.bearing_kind.bearing_sentences import BAND_WORDS
from rolling.choice import choice_page
from rolling.choice.advice_page import limit_page, sensitivities_page
from rolling.choice.audition import SOUND
from rolling.choice.difference import Difference
from rolling.choice.limit import Limit, Point
from rolling.choice.sensitivity import Sensitivities, Sensitivity
from rolling.figures.picture import finish, picture
from rolling.kinds.reading import read_scene
from rolling.kinds.registry import kind_of
from rolling.kinds.stated_conditions import conditions_of
from rolling.recordings import agreement
from rolling.recordings.recording_comparison import compare
from rolling.report import recording_page
from rolling.report.charts import chart_of
from rolling.report.gallery import gallery_page
from rolling.report.level_bars import Row, bars_around_zero, bars_over_decades
from rolling.report.report_page import page as page_of
from rolling.report.report_page import quantity_chart

MOST_WORDS = 150  # of a first view
# All words in sight when a page opens, numbers and units among them, but not the axes of charts.
WORDS_IN_SIGHT = """() => {
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  let words = 0;
  while (walker.nextNode()) {
    const { parentElement: box, textContent: text } = walker.currentNode;
    const isUnseen = box.closest('script, style, noscript, title, desc, .only-spoken');
    const isAxis = box.closest('.plot, .ticks');
    if (!text.trim() || !box.checkVisibility() || isUnseen || isAxis) continue;
    const range = document.createRange();
    range.selectNodeContents(walker.currentNode);
    const { top, bottom, width } = range.getBoundingClientRect();
    if (width && bottom > 0 && top < innerHeight) words += text.trim().split(/\\s+/).length;
  }
  return words;
}"""
BEYOND = """() => [...document.querySelectorAll('body *')].filter((e) => {
  const { left, right, width } = e.getBoundingClientRect();
  return width && !e.closest('.plot, pre, .only-spoken, .cards thead, audio, .seen')
    && (right > document.documentElement.clientWidth + 1 || left < -1);
}).map((e) => e.outerHTML.slice(0, 80))"""


# ---- a page of each kind


def bearing_page(folder: Path) -> bytes:
    return page_of([turning()])


def bearings_page(folder: Path) -> bytes:
    scene = loads_bearing(WAVY, ["sound.duration_s=0.2", "sound.listen_s=0.2"])
    return page_of(list(rc.simulate_sweep(scene.with_(sweep=SWEEP), progress=False).values()))


SWEEP = {"bearing.axial_load_n": [65, 75]}


def choice_page_of(folder: Path) -> bytes:
    scene = loads_bearing(WAVY, ["sound.duration_s=0.1", "sound.listen_s=0.2"])
    louder = scene.with_({"name": "louder", "bearing.surfaces.inner.waviness": {9: 0.2}})
    choice = rc.choose(
        [scene, louder], folder=folder / "choice", pairs=2, workers=1, progress=False
    )
    return choice_page.page(choice, choice_page.candidate_sounds(choice))


def comparison_page(folder: Path) -> bytes:
    run = marched(VIBRATING.replace("sound: {", "sound: {listen_s: 2, "))
    pressure = run.long.pressure
    soundfile.write(folder / "own.wav", pressure / np.abs(pressure).max() / 2, 48000)
    conditions = conditions_of({"run": run.scene})
    return recording_page.page(run, compare(run, folder / "own.wav"), conditions, "as it was done")


def gallery_page_of(folder: Path) -> bytes:
    return gallery_page(iter([*runs_of("smooth"), turning()]), 2, folder)


def search_page(folder: Path) -> bytes:
    scatter = np.linspace(-1, 1, 8)
    points = [Point(ra, 28 + 20 * math.log10(ra) + scatter) for ra in (1.0, 4.0, 2.0)]
    found = Limit(
        name="ball",
        key="surface.roughness_ra_um",
        quantity=SOUND,
        level_db=38.0,
        points=points,
        value=2.0,
        rises=True,
        falls=[],
        noun="surfaces",
        notes=[],
        folder=folder,
        scene=read_scene("vibrating-ball", ["sweep="]),
    )
    return limit_page(found)


def advice_page(folder: Path) -> bytes:
    rows = []
    for name, db in (("thickness", -1.2), ("load", 0.4)):
        difference = Difference("sound", 4, db, 0.1, 0.99, {})
        rows.append(sensitivity(name, difference))
    found = Sensitivities(
        name="ball",
        quantity=SOUND,
        rows=rows,
        left_out=[],
        noun="surfaces",
        within_db=0.2,
        limit="",
        folder=folder,
        scene=read_scene("bearing-6204"),
    )
    return sensitivities_page(found)


def sensitivity(name: str, difference: Difference) -> Sensitivity:
    """Return the change of a level by a value of some name."""
    change: Any = SimpleNamespace(
        name=name,
        key=f"plate.{name}",
        step="10 %",
        is_upwards=True,
        words=SimpleNamespace(larger=f"larger {name}", smaller=f"smaller {name}"),
    )
    return Sensitivity(change, difference, np.zeros(4), difference.db, 0.2, SOUND)


PAGES: dict[str, Callable[[Path], bytes]] = {
    "bearing": bearing_page,
    "bearings": bearings_page,
    "choice": choice_page_of,
    "comparison": comparison_page,
    "search": search_page,
    "advice": advice_page,
    "gallery": gallery_page_of,
    "ball": lambda folder: page_of(runs_of("filmed")),
    "balls": lambda folder: page_of(runs_of("three")),
}
LONG = ("ball", "bearings", "balls", "comparison", "gallery")  # to make
each_page = pytest.mark.parametrize(
    "kind",
    [pytest.param(kind, marks=pytest.mark.slow) if kind in LONG else kind for kind in PAGES],
)


@pytest.fixture(scope="module")
def page_file(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """Return the page of a kind, made once."""
    folder = tmp_path_factory.mktemp("parts")

    @cache
    def made(kind: str) -> Path:
        path = folder / f"{kind}.html"
        path.write_bytes(PAGES[kind](folder))
        return path

    return made


# ---- laws of all pages


@each_page
def test_no_chart_is_a_bitmap(kind: str, page_file: Callable[[str], Path]) -> None:
    """Images of charts are fields of pixels alone; axes, letters, lines and bars are SVG."""
    content = re.sub('<img class="field"[^>]*>', "", page_file(kind).read_text())
    assert "<img" not in content and "image/svg+xml;base64" not in content
    for chart in data_of(page_file(kind))["charts"]:
        kinds = {part["kind"] for part in chart["parts"]}
        assert "image" not in kinds or chart["y"][0]["label"] in FIELDS, chart["title"]
    assert content.count("data-chart=") == len(data_of(page_file(kind))["charts"])


FIELDS = ("frequency", "across", "y", "position across")  # along whose axis a field of pixels is


@pytest.mark.slow
@each_page
def test_a_phone_shows_all_and_the_first_view_is_short(
    kind: str, page_file: Callable[[str], Path], opened
) -> None:
    with opened(page_file(kind), viewport={"width": 390, "height": 844}) as page:
        assert page.evaluate(WORDS_IN_SIGHT) <= MOST_WORDS
        page.evaluate("document.querySelectorAll('details').forEach((d) => { d.open = true; })")
        assert page.evaluate("document.scrollingElement.scrollWidth") <= 390
        assert page.evaluate(BEYOND) == []
        assert axe_findings(page) == []
    with opened(page_file(kind), viewport={"width": 1440, "height": 900}) as page:
        assert page.evaluate(WORDS_IN_SIGHT) <= MOST_WORDS


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["bearing", "choice", "comparison", "advice"])
def test_the_answer_needs_no_scripts(kind: str, page_file: Callable[[str], Path], browser) -> None:
    """Bars, curves and sounds stand in the page itself."""
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(page_file(kind).as_uri())
    charts = page.locator("figure[data-chart] >> visible=true")
    assert page.locator("figure[data-chart] .drawn path >> visible=true").count() >= charts.count()
    for chart in charts.all():
        box = chart.locator(".drawn").bounding_box()
        assert box["width"] > 200 and box["height"] > 100
    assert page.locator(".bars .value b >> visible=true").count()
    assert page.locator(".bars svg rect").count()
    if kind != "advice":
        assert page.locator("audio >> visible=true").count()
    context.close()


@pytest.mark.parametrize(
    ("kind", "title"),
    [
        (
            "search",
            "Which Ra stays below 38 dB(A)? Steel ball of 10 mm on a steel plate",
        ),
        ("advice", "What would make it quieter? A 6204 bearing at 1,800 rpm"),
    ],
)
def test_advice_draws_the_machine_and_names_it(
    kind: str, title: str, page_file: Callable[[str], Path]
) -> None:
    content = page_file(kind).read_text()
    assert content.count('<svg class="machine"') == 1
    assert html.unescape(re.search("<h1>(.*?)</h1>", content)[1]).startswith(title)


# ---- charts


def test_lines_are_named_where_they_stand() -> None:
    """Names that a figure has no room for come last; those of the whole axes are said."""

    def draw(ax: Any) -> Any:
        ax.plot([0, 100], [0, 1], label="one")
        for at, text, visible in ((30, "BPFO", True), (31, "side", False)):
            ax.axvline(at, ymax=0.5)
            ax.text(
                at,
                0.9,
                text,
                transform=ax.get_xaxis_transform(),
                rotation=90,
                visible=visible,
            )
        ax.text(0.5, 0.5, "no sound", transform=ax.transAxes)
        ax.annotate("step", (1, 1), textcoords="offset points", xytext=(0, 7))
        ax.set(xlabel="frequency [Hz]", ylabel="level [dB]")
        return finish(ax, "lines", [])

    chart = chart_of(picture("lines", draw))
    assert [(name["text"], name["at"], name["last"]) for name in chart["named"]] == [
        ("BPFO", 30, False),
        ("side", 31, True),
    ]
    assert chart["texts"] == ["no sound"]
    assert [part["high"] for part in chart["parts"] if part["kind"] == "rule"] == [0.5, 0.5]


def test_the_lines_of_a_bearing_are_named_on_its_page(
    page_file: Callable[[str], Path], opened
) -> None:
    with opened(page_file("bearing")) as page:
        shown = page.locator("figure[data-name=spectrum]")
        shown.scroll_into_view_if_needed()
        shown.locator(".frame").wait_for(state="attached")
        names = shown.locator("text.name").all_text_contents()
        assert "BPFO" in names and any(name.endswith("µm/s") for name in names)


def test_pulses_have_the_frames_between_them() -> None:
    """A frame of the spectrogram is shorter than the time between two pulses of any fault."""
    run = turning()
    ax = rc.plot.velocity_spectrogram(run, Figure().subplots())
    frame_ms = float(re.search(r"frames of ([\d.]+) ms", ax.get_title("left"))[1])
    passes = 1e3 / max(run.kinematics.ball_pass_inner_hz, 2 * run.kinematics.ball_spin_hz)
    assert 1 <= frame_ms < passes / 2


def test_a_sweep_of_bearings_is_drawn_over_its_swept_value() -> None:
    """Bands are curves with the ends of their ± at the swept speeds; a ring at rest has no mark."""
    scene = loads_bearing(WAVY, ["sound.duration_s=0.1", "sound.listen_s=0.1"])
    speeds = [900, 1800, 2700]
    swept = scene.with_(sweep={"bearing.speed_rpm": speeds})
    runs = list(rc.simulate_sweep(swept, progress=False).values())
    chart = quantity_chart(runs, kind_of(scene).figures()["quantities"])
    assert chart is not None and (chart["x"]["label"], chart["x"]["unit"]) == ("speed", "rpm")
    assert [curve["name"] for curve in chart["curves"]] == [*BAND_WORDS.values()]
    low = next(part for part in chart["parts"] if part["kind"] == "line" and part["of"] == 0)
    assert chart["xs"][low["x"]] == speeds
    velocities = [run.numbers.below_bending.radial.low for run in runs]
    assert low["y"] == pytest.approx([velocity.value for velocity in velocities], rel=1e-3)
    bars = next(part for part in chart["parts"] if part["kind"] == "errors" and part["of"] == 0)
    factors = [10 ** (velocity.uncertainty / 20) for velocity in velocities]
    assert np.divide(bars["high"], bars["low"]) == pytest.approx(np.square(factors), rel=1e-3)
    assert quantity_chart(runs[:1], kind_of(scene).figures()["quantities"]) is None


# ---- bars


def test_bars_of_decades_have_the_places_of_their_values() -> None:
    rows = [Row("a", 1.0, None, None, "1"), Row("b", 10.0, 5.0, 20.0, "10")]
    bars = bars_over_decades("velocity", rows)
    assert bars.ticks == [(0.0, "1"), (500.0, "10"), (1000.0, "100")]
    assert [(bar.begin, bar.end) for bar in bars.bars] == [(0.0, 0.0), (0.0, 500.0)]
    low, high = bars.bars[1].spread_ends
    assert (low, high) == pytest.approx((500 * math.log10(5), 500 * math.log10(20)), abs=0.1)


@pytest.mark.parametrize("value", [0.0, -3.0, 1e-12, None])
def test_bars_of_nothing_have_no_length(value: float | None) -> None:
    (bar,) = bars_over_decades("velocity", [Row("a", value, None, None, "0")]).bars
    assert bar.begin in (None, 0.0) and bar.end in (None, 0.0, 1000.0) and bar.spread_ends is None


def test_bars_of_changes_stand_on_both_sides_of_zero() -> None:
    rows = [Row("a", -1.0, -1.5, -0.5, "-1", beside=2.0), Row("b", 0.5, None, None, "+0.5")]
    bars = bars_around_zero("change", rows)
    assert [(bar.begin, bar.end) for bar in bars.bars] == [(250.0, 500.0), (500.0, 625.0)]
    assert bars.bars[0].spread_ends == (125.0, 375.0) and bars.bars[0].beside == 1000.0


# ---- words


@pytest.mark.parametrize(
    ("close", "whole"),
    [
        ([9, 2, -1, 3, 9, 1, 1], (2, 4)),
        ([1, np.nan, 1, 1, 1, -9], (3, 5)),
        ([9, 9, 9], None),
        ([1, 1, 9], None),
    ],
)
def test_close_bands_are_the_widest_within_three_decibels(
    close: list[float], whole: tuple[int, int] | None
) -> None:
    """Bands are counted from 1 on; a gap divides, and two bands are too few."""
    differences = np.full(31, np.nan)
    differences[: len(close)] = close
    found = agreement.BandDifferences(differences, np.full(31, 0.5)).close
    if whole is None:
        assert found is None
        return
    assert found is not None and found.within_db <= agreement.CLOSE_DB
    assert not found.is_covered  # differences of 1 dB and more
    covered = agreement.BandDifferences(differences, np.full(31, 9.0)).close
    assert covered is not None and covered.is_covered
    nominal = agreement.NOMINAL_HZ
    assert (found.low_hz, found.high_hz) == (nominal[whole[0] - 1], nominal[whole[1] - 1])


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("quickstart", "Steel ball of 10 mm on steel (Ra 0.1 µm), 5 to 100 N"),
        ("marble-dropped", "Glass ball of 16 mm on a glass plate of 900 x 600 x 8 mm"),
        ("bearing-6204", "Bearing 6204 at 1800 rpm under 70 N axial"),
    ],
)
def test_a_page_says_what_rolls_on_what(name: str, words: str) -> None:
    scene = read_scene(name)
    runs = [SimpleNamespace(scene=run, values=values) for values, run in scene.runs()]
    assert kind_of(scene).subject(runs).startswith(words)
