"""Charts of the page hold the numbers of figures, and are read, zoomed and saved in a browser."""

from __future__ import annotations

import base64
import io
import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure
from PIL import Image
from report_browser import MINUS, data_of, until, without_browser
from report_runs import runs_of

import rolling.report
from rolling.figures.catalogue import comparing_pictures, single_names, single_picture
from rolling.figures.picture import Caption, Picture
from rolling.report import templates, text
from rolling.report.chart_svg import chart_svg
from rolling.report.charts import COLUMNS, chart_of, numbers

ASSETS = Path(rolling.report.__file__).parent / "assets"
# columns of the table in the unit of the chart, in the order of its curves
TABLES = {
    "mobilities": ("flying", ["sphere", "contact", "plate", "all_three_in_a_row"]),
    "contact_filter": ("flying", ["surface_level", "approach_level", "contact_filter"]),
    "release_power": ("three", ["release_power_w"]),
}


def chart(name: str, runs: str) -> tuple[dict[str, Any], Picture]:
    """Return the chart of a figure, as it comes out of JSON, and its picture."""
    shown = runs_of(runs)
    if name in single_names(shown[0]):
        drawn = single_picture(name, shown[0], shown)
    else:
        (drawn,) = comparing_pictures(shown, [name])
    assert drawn is not None
    return json.loads(json.dumps(chart_of(drawn), allow_nan=False)), drawn


def drawing(plot, name: str = "any") -> dict[str, Any]:
    """Return the chart of axes that a function draws on."""
    ax = Figure().subplots()
    plot(ax)
    picture = Picture(name, ax.figure, table=None, caption=Caption("a title", "a note"))
    return json.loads(json.dumps(chart_of(picture), allow_nan=False))


def points(chart: dict[str, Any], part: dict[str, Any], key: str = "y") -> np.ndarray:
    """Return places and numbers of a part, without those that are missing."""
    both = np.array([chart["xs"][part["x"]], part[key]], dtype=float)
    return both[:, np.isfinite(both).all(axis=0)]


# ---- numbers


@pytest.mark.parametrize("name", TABLES)
def test_curves_are_those_of_the_table(name: str) -> None:
    """Four digits leave 5e-5 of a curve's range; 1e-3 with interpolation in thinned columns."""
    runs, columns = TABLES[name]
    read, picture = chart(name, runs)
    table = pd.read_csv(io.BytesIO(picture.file("csv") or b""))
    lines = [part for part in read["parts"] if part["kind"] == "line" and "of" in part]
    assert len(lines) == len(columns)
    for part, column in zip(lines, columns, strict=True):
        values = table.filter(like=column).iloc[:, 0]
        finite = values.notna()
        prefix = read["y"][0]["unit"][0] if column.endswith("_w") else ""
        factor = {"m": 1e-3, "µ": 1e-6, "n": 1e-9, "": 1.0}[prefix]
        second = 1e-3 if read["x"]["unit"] == "ms" else 1
        x, y = points(read, part)
        order = np.argsort(x)
        shown = np.interp(table.iloc[:, 0][finite], second * x[order], factor * y[order])
        span = np.ptp(values[finite]) or values.max()
        if len(x) < 2 * COLUMNS:
            assert np.abs(shown - values[finite]).max() < 1e-3 * span
        extremes = np.array([y.min(), y.max()]) * factor
        assert extremes == pytest.approx([values.min(), values.max()], rel=1e-3, abs=1e-3 * span)


def test_third_octaves_and_their_uncertainty_are_those_of_the_runs() -> None:
    """Marks and half the error bars, to 1e-3 of the range of 70 dB, of the released power."""
    runs = runs_of("three")
    read, _ = chart("released_third_octaves_a", "three")
    for run in runs:
        names = [curve["name"] for curve in read["curves"]]
        own = [part for part in read["parts"] if part.get("of") == names.index(run.label)]
        marks = np.hstack([points(read, part) for part in own if part["kind"] == "line"])
        levels = [x for x in run.sound.levels.third_octave_a_db.values() if x is not None]
        assert np.sort(marks[1]) == pytest.approx(np.sort(levels), abs=0.02)
        (bars,) = (part for part in own if part["kind"] == "errors")
        spread = np.subtract(*(points(read, bars, key)[1] for key in ("high", "low"))) / 2
        known = run.numbers.bands_of_record.uncertainty[-len(spread) :]
        assert spread == pytest.approx(np.array(known, dtype=float), abs=0.02)


@pytest.mark.parametrize("name", ["three", "flying", "seeds", "memory", "smooth"])
def test_every_figure_keeps_its_axes_and_the_names_of_its_curves(name: str) -> None:
    runs = runs_of(name)
    pictures = [*comparing_pictures(runs)]
    pictures += [x for kind in single_names(runs[0]) if (x := single_picture(kind, runs[0], runs))]
    for picture in pictures:
        read = chart_of(picture)
        ax = picture.figure.axes[0]
        axes = {"x": read["x"], "y": read["y"][0]}
        for side, own in axes.items():
            label = f"{own['label']} [{own['unit']}]" if own["unit"] else own["label"]
            shown = " ".join(getattr(ax, f"get_{side}label")().split())
            assert label == shown.replace(" [-]", ""), picture.name
            assert own["limits"] == pytest.approx(getattr(ax, f"get_{side}lim")(), rel=1e-6)
            assert own["log"] == (getattr(ax, f"get_{side}scale")() == "log")
        named = [curve["name"] for curve in read["curves"] if curve["name"]]
        legend = ax.get_legend_handles_labels()[1]
        assert list(dict.fromkeys(named)) == list(dict.fromkeys(legend))
        assert picture.caption == (read["title"], read["note"])
        kinds = {part["kind"] for part in read["parts"]}
        assert kinds and (kinds == {"image"}) == bool(ax.images)
        assert read["texts"] == [text.get_text() for text in ax.texts]


def test_thinning_keeps_every_peak_and_digits_follow_the_range() -> None:
    noise = np.random.default_rng(1).standard_normal(100_000)
    noise[[777, 54_321]] = 40.0, -30.0
    read = drawing(lambda ax: ax.plot(np.arange(100_000.0), 1e6 + noise))
    (part,) = read["parts"]
    x, y = points(read, part)
    assert len(x) == 2 * COLUMNS
    assert (y.max(), y.min()) == pytest.approx((1e6 + 40, 1e6 - 30), abs=7e-3)  # 1e-4 of 70
    assert x[y.argmax()] == pytest.approx(777, abs=100_000 / COLUMNS)


@pytest.mark.parametrize(
    ("values", "read"),
    [
        ([0.0, 2 / 3], [0, 0.6667]),
        ([1000.12341, 1000.62339], [1000.1234, 1000.6234]),
        ([np.nan, np.inf, 2.0], [None, None, 2]),
        ([1e-300, 1e300], [1e-300, 1e300]),
        ([], []),
        ([5.0, 5.0], [5, 5]),
    ],
)
def test_numbers_have_four_digits_of_their_differences(values: list[float], read: list) -> None:
    assert numbers(values) == read


def test_steps_of_a_band_and_values_of_an_image_are_read_back() -> None:
    low = np.array([0.0, 1.0, -1.0, 2.0])
    high = np.array([1.0, 2.0, 3.0, 2.5])
    read = drawing(lambda ax: ax.fill_between(np.arange(4.0), low, high, step="post", color="r"))
    (band,) = read["parts"]
    assert band["step"] and (band["low"], band["high"]) == ([0, 1, -1, 2], [1, 2, 3, 2.5])
    values = np.ma.masked_invalid([[0.0, 5.0, 10.0], [2.5, np.nan, 7.5]])

    def draw(ax) -> None:
        shown = ax.imshow(values, "magma", origin="lower", extent=(0, 3, 0, 2))
        ax.figure.colorbar(shown, ax=ax, label="height [µm]")

    (image,) = drawing(draw)["parts"]
    content = io.BytesIO(base64.b64decode(image["png"].partition(",")[2]))
    pixels = np.asarray(Image.open(content).convert("RGBA"))[::-1]
    shades = {colour: k for k, colour in enumerate(image["colours"])}
    for place, value in np.ndenumerate(values.filled(np.nan)):
        red, green, blue, opacity = pixels[place]
        if np.isnan(value):
            assert opacity == 0
            continue
        shade = shades[f"#{red:02x}{green:02x}{blue:02x}"]
        assert 10 * (shade + 0.5) / len(shades) == pytest.approx(value, abs=10 / len(shades))
    assert image["scale"]["label"] == "height" and image["scale"]["limits"] == [0, 10]


# ---- scales, ticks and zoom


def computed(expression: str) -> Any:
    """Return what an expression with the functions of scales is in Node."""
    if shutil.which("node") is None:
        without_browser("no node")
    names = "scaleOf, worded, quantity, ticksOf, nearest, zoomed, pointsOf"
    module = (ASSETS / "page" / "chart_scale.js").as_uri()
    code = f'import {{ {names} }} from "{module}"; console.log(JSON.stringify({expression}))'
    command = ["node", "--input-type=module", "-e", code]
    return json.loads(subprocess.run(command, check=True, capture_output=True).stdout)


@pytest.mark.parametrize(
    ("axis", "room", "ticks"),
    [
        ("limits: [20, 20000], log: true, unit: 'Hz'", 12, "20 50 100 200 500 1k 2k 5k 10k 20k"),
        ("limits: [20, 20000], log: true, unit: 'Hz'", 5, "100 1k 10k"),
        ("limits: [0, 0.35], log: false, unit: ''", 8, "0 0.05 0.1 0.15 0.2 0.25 0.3 0.35"),
        ("limits: [-15, 12], log: false, unit: 'dB'", 6, f"{MINUS}15 {MINUS}10 {MINUS}5 0 5 10"),
        ("limits: [3000, 3], log: true, unit: 'µm'", 4, "10 100 1000"),
        ("limits: [1e-15, 1e-6], log: true, unit: 'J'", 5, "10⁻¹⁴ 10⁻¹² 10⁻¹⁰ 10⁻⁸ 10⁻⁶"),
        ("limits: [0, 2], log: false, unit: '', names: [[0, 'a'], [1, 'b'], [2, 'c']]", 5, "a b c"),
        ("limits: [1, 1], log: false, unit: ''", 5, "1"),
        ("limits: [999.998, 1000.002], log: false, unit: ''", 2, "999.998 1000 1000.002"),
    ],
)
def test_ticks_are_few_round_and_readable(axis: str, room: int, ticks: str) -> None:
    made = computed(f"ticksOf({{ {axis} }}, {room}).sort((a, b) => a[0] - b[0])")
    assert [name.replace("\u202f", "") for _, name in made] == ticks.split()


def test_places_zoom_and_reading_agree_with_their_definitions() -> None:
    """A logarithmic axis halves in octaves, and no zoom leaves the whole axis."""
    assert computed("scaleOf([20, 20000], true, 0, 300).pixel(200)") == pytest.approx(100)
    assert computed("scaleOf([3000, 3], true, 0, 300).value(200)") == pytest.approx(30)
    axis = "{ limits: [1, 5], whole: [0, 8] }, scaleOf([1, 5], false, 0, 100)"
    assert computed(f"zoomed({axis}, 25, 75)") == pytest.approx([2, 4])
    assert computed(f"zoomed({axis}, -50, 50)") == pytest.approx([0, 3])
    assert computed(f"zoomed({axis}, -50, 900)") == [0, 8]
    assert computed(f"zoomed({axis}, 50, 50.0001)") == [1, 5]  # narrower than 1e-5 of 8
    falling = "{ limits: [1000, 1], whole: [1000, 1] }, scaleOf([1000, 1], true, 0, 300)"
    assert computed(f"zoomed({falling}, 0, 100)") == pytest.approx([1000, 100])
    near = computed("nearest([{ x: 1 }, { x: 10 }, { x: 100 }], Math.log10, 1.4)")
    assert near == {"x": 10}
    words = (
        "[quantity(-61.24, 'dB re 20 µPa'), quantity(1250, 'Hz'), quantity(3e-7, 'W'), worded(0)]"
    )
    assert computed(words) == [f"{MINUS}61.2 dB", "1.25 kHz", "3·10⁻⁷ W", "0"]


# ---- in a browser


@pytest.fixture
def opened_charts(tmp_path: Path, opened):
    """Open a page of charts alone."""

    def open_charts(*shown: dict[str, Any], **settings: Any):
        environment = templates.environment()
        environment.globals |= {"numbered": [*shown].index, "chart_svg": chart_svg}
        body = environment.from_string(
            "<!DOCTYPE html><html lang=en><meta charset=utf-8><title>charts</title>"
            "<style>{{ css }}</style><main><h1>charts</h1>"
            '{% from "macros.html" import exhibit %}'
            "{% for chart in data.charts %}{{ exhibit(chart) }}{% endfor %}</main>"
            '<script type="application/json" id="data">{{ data | tojson }}</script>'
            "<script>(() => { {{ js | safe }} document.documentElement.classList.add('scripted');"
            "openCharts(JSON.parse(document.querySelector('#data').textContent).charts, [])})();"
            "</script>"
        )
        css = text.asset("report.css") + text.asset("chart.css")
        js = templates.joined_script("page/chart.js")
        path = tmp_path / "charts.html"
        path.write_text(body.render(data={"charts": shown}, css=css, js=js))
        return opened(path, **settings)

    return open_charts


def figure(page, number: int = 0):
    drawn = page.locator("figure.chart").nth(number)
    drawn.scroll_into_view_if_needed()
    drawn.locator(".frame").wait_for(state="attached")
    return drawn


@pytest.mark.parametrize("width", [390, 1400])
def test_a_chart_is_read_toggled_and_zoomed(width: int, opened_charts) -> None:
    def draw(ax) -> None:
        ax.plot([1.0, 10.0, 100.0, 1000.0], [1.0, 2.0, 4.0, 3.0], label="one")
        ax.errorbar([1.0, 10.0, 100.0, 1000.0], [2.0, 3.0, 5.0, 1.0], 0.5, label="other")
        ax.set(xscale="log", xlabel="frequency [Hz]", ylabel="level [dB]", ylim=(0, 6))

    with opened_charts(drawing(draw), viewport={"width": width, "height": 900}) as page:
        shown = figure(page)
        svg = shown.locator(".plot > svg")
        reading = shown.locator(".reading")
        box = svg.bounding_box()
        assert box["x"] + box["width"] <= width
        texts = shown.locator(".axes text").all_text_contents()
        assert {"10", "100", "1\u202fk", "level [dB]", "frequency [Hz]"} <= {*texts}
        page.mouse.move(box["x"] + box["width"] * 0.66, box["y"] + 100)
        assert reading.inner_text().split("\n") == [
            "100 Hz",
            "one",
            "4.0 dB",
            "other",
            "5.0 ± 0.5 dB",
        ]
        assert shown.locator(".parts .top").count() == 1  # the nearest curve, in front
        svg.focus()
        page.keyboard.press("Home")
        assert reading.inner_text().startswith("1 Hz")
        page.keyboard.press("ArrowRight")
        assert reading.inner_text().startswith("10 Hz")
        button = shown.get_by_role("button", name="other")
        button.click()
        assert button.get_attribute("aria-pressed") == "false"
        assert not shown.locator(".errors").count()
        button.click()
        limits = "document.querySelector('figure').plot.view.x.limits"
        whole = page.evaluate(limits)
        svg.focus()
        page.keyboard.press("+")
        assert np.ptp(np.log(page.evaluate(limits))) == pytest.approx(np.ptp(np.log(whole)) / 2)
        assert shown.get_by_role("button", name="Whole chart").is_visible()
        page.keyboard.press("Escape")
        assert page.evaluate(limits) == whole
        svg.scroll_into_view_if_needed()
        box = svg.bounding_box()
        page.mouse.move(box["x"] + box["width"] * 0.4, box["y"] + 60)
        page.mouse.down()
        page.mouse.move(box["x"] + box["width"] * 0.7, box["y"] + 65, steps=3)
        page.mouse.up()
        low, high = page.evaluate(limits)
        assert 1 < low < 100 < high < 1000
        svg.dblclick(position={"x": 100, "y": 100})
        assert page.evaluate(limits) == whole
        shown.get_by_role("button", name="log x").click()
        assert not page.evaluate("document.querySelector('figure').plot.view.x.log")


def test_charts_of_any_numbers_are_drawn_without_a_complaint(opened_charts) -> None:
    rng = np.random.default_rng(2)
    hard = {
        "one point": ([1.0], [2.0]),
        "nothing finite": ([1.0, 2.0], [np.nan, np.inf]),
        "empty": ([], []),
        "many points": (np.arange(1e5), rng.standard_normal(100_000)),
        "huge range": ([1e-12, 1.0, 1e12], [1e-300, 1.0, 1e300]),
        "all equal": ([3.0, 3.0, 3.0], [7.0, 7.0, 7.0]),
        "negative": ([-5.0, -1e-9, 5.0], [-1e-30, 0.0, 1e-30]),
    }
    shown = [
        drawing(lambda ax, xy=xy, name=name: ax.plot(*xy, label=name), name)
        for name, xy in hard.items()
    ]
    with opened_charts(*shown) as page:
        for number in range(len(hard)):
            drawn = figure(page, number)
            drawn.locator(".plot > svg").focus()
            for key in ("ArrowRight", "End", "ArrowUp", "+", "+", "-", "Home", "Escape"):
                page.keyboard.press(key)
            drawn.locator(".plot > svg").hover(position={"x": 300, "y": 120})
            assert "NaN" not in drawn.locator(".plot").inner_html()


def test_saved_charts_hold_their_colours_and_the_table(opened_charts) -> None:
    read, picture = chart("third_octaves", "three")
    read["csv"] = (picture.file("csv") or b"").decode()
    saved = {}
    with opened_charts(read, accept_downloads=True, color_scheme="dark") as page:
        drawn = figure(page)
        for kind in ("svg", "png", "csv"):
            with page.expect_download() as download:
                drawn.locator(f"[data-save={kind}]").click()
            assert download.value.suggested_filename == f"third_octaves.{kind}"
            saved[kind] = Path(download.value.path()).read_bytes()
    assert saved["csv"] == picture.file("csv")
    words = saved["svg"].decode()
    assert "var(" not in words and read["title"] in words and "load 0.5 N" in words
    pixels = np.asarray(Image.open(io.BytesIO(saved["png"])).convert("RGB"))
    assert pixels.shape[1] == 1800 and (pixels[0] == 255).all()  # the paper, even in the dark
    colour = [int(read["curves"][0]["colour"][k : k + 2], 16) for k in (1, 3, 5)]
    assert (np.abs(pixels.astype(int) - colour).max(axis=2) < 3).sum() > 500


def test_the_numbers_of_a_chart_are_one_choice_away(opened_charts) -> None:
    """The table has the rows of the CSV file, and goes again."""
    read, picture = chart("third_octaves", "three")
    read["csv"] = (picture.file("csv") or b"").decode()
    table = pd.read_csv(io.StringIO(read["csv"]))
    with opened_charts(read) as page:
        drawn = figure(page)
        button = drawn.get_by_role("button", name="Numbers")
        button.click()
        assert button.get_attribute("aria-expanded") == "true"
        rows = drawn.locator(".numbers tbody tr")
        assert rows.count() == len(table)
        first = rows.first.locator("td").all_text_contents()
        assert len(first) == len(table.columns) and first[:2] == [table["run"][0], "20"]
        button.click()
        assert not rows.count()


def test_yielded_nodes_are_read_as_the_hardness_in_a_chart() -> None:
    """Their colour is the last one of the image, beyond those of the scale."""
    read, picture = chart("contact_pressure", "three")
    (image,) = [part for part in read["parts"] if part["kind"] == "image"]
    values = np.ma.filled(picture.figure.axes[0].images[0].get_array(), np.nan)
    limit = picture.figure.axes[0].images[0].get_clim()[1]
    content = io.BytesIO(base64.b64decode(image["png"].partition(",")[2]))
    pixels = np.asarray(Image.open(content).convert("RGB"))[::-1]
    last = [int(image["colours"][-1][k : k + 2], 16) for k in (1, 3, 5)]
    np.testing.assert_array_equal((pixels == last).all(axis=2), values > limit)
    assert image["over"] and (values > limit).any()


def test_runs_have_one_colour_and_charts_over_time_seek(pages, opened) -> None:
    """A click on a chart over time seeks within a pixel, and the playhead stands there."""
    path = pages("three")
    shown = data_of(path)["charts"]
    assert sum(len(json.dumps(chart)) for chart in shown) < 700e3
    with opened(path) as page:
        page.evaluate("document.querySelectorAll('details').forEach((d) => { d.open = true; })")
        colours = [
            page.evaluate(
                f"getComputedStyle(document.documentElement).getPropertyValue('--run-{k}')"
            )
            for k in range(3)
        ]
        assert len({*colours}) == 3 and all(colours)
        number = next(k for k, c in enumerate(shown) if c["name"] == "release_power")
        assert shown[number]["run"] == 0
        drawn = page.locator(f"figure[data-chart='{number}']")
        drawn.scroll_into_view_if_needed()
        drawn.locator(".frame").wait_for(state="attached")
        svg = drawn.locator(".plot > svg")
        places = drawn.evaluate(
            "f => { const { box } = f.plot.places; return [box.left, box.right]; }"
        )
        x = places[0] + 0.6 * (places[1] - places[0])
        svg.click(position={"x": x, "y": 120})
        seconds = float(page.input_value("#seek"))
        assert seconds == pytest.approx(0.6 * 0.9, abs=1.5 * 0.9 / (places[1] - places[0]))
        line = drawn.locator(".playhead").get_attribute("d")
        assert float(line[1:].split(" ")[0]) == pytest.approx(x, abs=1.5)


SEEN_ARE_DRAWN = """[...document.querySelectorAll('figure.chart')].every((figure) => {
  const { top, bottom, width } = figure.getBoundingClientRect();
  return !width || bottom < 0 || top > innerHeight || figure.querySelector('.frame');
})"""


def test_nothing_moves_when_a_chart_is_drawn(pages, opened) -> None:
    """A chart has its height before it is drawn: the page is as high at its end as at its head."""
    with opened(pages("three")) as page:
        page.evaluate("document.querySelectorAll('details').forEach((d) => { d.open = true; })")
        heights = []
        for share in np.linspace(0, 1, 11).tolist():
            page.evaluate("(share) => scrollTo(0, share * document.body.scrollHeight)", share)
            until(page, SEEN_ARE_DRAWN)
            heights.append(page.evaluate("document.body.scrollHeight"))
        assert page.locator("figure.chart svg .parts").count() > 5
    assert np.ptp(heights) <= 1
