"""The page is a single file that asks for nothing, with escaped text and right numbers."""

from __future__ import annotations

import base64
import io
import re
from dataclasses import fields, is_dataclass, replace
from importlib.resources import files
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image
from report_browser import data_of
from report_runs import HOSTILE, runs_of, solved
from ruamel.yaml import YAML

from acoustics.wav import PEAK
from rolling.contact.track import Motion
from rolling.numbers import ball_numbers
from rolling.numbers.doubt import sized
from rolling.numbers.fields import number_field_of
from rolling.numbers.quantity import Quantity
from rolling.report import film, leading_numbers, maps, page_sounds, text
from rolling.report.assumed import assumptions
from rolling.report.number_table import number_table
from rolling.report.report_page import page
from rolling.report.templates import css_text
from rolling.results import verdict
from rolling.results.run_result import Run
from rolling.scene.file import loads
from rolling.scene.scene import Scene

TARGET = re.compile(r"<(?P<tag>[a-z]+)[^>]*?(?:src|href)=\"(?P<target>[^\"]*)\"", re.S)


@pytest.fixture
def three() -> list[Run]:
    return runs_of("three")


# ---- the file


def test_a_page_is_one_file_that_asks_for_nothing(pages) -> None:
    content = pages("one").read_text()
    targets = [match["target"] for match in TARGET.finditer(content)]
    links = {target.partition(":")[0] for target in targets if not target.startswith("#")}
    assert len(targets) > 5 and links == {"data"}
    policy = re.search(r'Content-Security-Policy" content="([^"]+)"', content)
    assert policy and policy[1].startswith("default-src 'none'")
    bare = re.sub(r"data:[^\"']+", "", content)
    assert not re.search(r"<link|@import|url\((?!#)|<[a-z]+\s[^<>]*\son[a-z]+=", bare)


def test_text_of_a_scene_is_escaped_in_markup_and_script(pages) -> None:
    content = pages("one").read_text()
    for markup in (HOSTILE, "<img src=x", "<!-- <script>", "z<i>"):
        assert markup not in content
    assert content.count("<script") == content.count("</script") == 4  # the page's own


@pytest.mark.parametrize(
    "title", ['"; } body { display: none; } a { b: "', "</style><b>", "ö\\音\n"]
)
def test_any_title_is_text_in_the_style_sheet(title: str) -> None:
    assert re.fullmatch(r"[0-9A-Za-z\\]*", css_text(title))


def test_ten_seconds_of_white_noise_take_less_than_300_kb() -> None:
    """No sound takes more than white noise; three such records leave 3 MB of 4 to the rest."""
    noise = np.random.default_rng(1).uniform(-0.9, 0.9, 480_000)
    assert len(page_sounds.compressed(noise)) < 3e5


def test_many_runs_have_a_short_page_without_players() -> None:
    runs = [replace(runs_of("lap")[0], label=f"run {k}") for k in range(30)]
    content = page(runs, ["run 30"]).decode()
    assert "30 runs are too many to be heard side by side" in content
    assert "<audio" not in content and "AudioContext" not in content and len(content) < 1e6
    assert content.count('<th scope="row">run ') == 30 and "run 30: these runs" in content


def test_the_scene_on_the_page_is_the_scene_of_the_runs(three) -> None:
    (recipe,) = text.recipes([replace(three[0], values={}, folder=Path("nowhere"))])
    again = loads(recipe["scene"], [], three[0].scene.folder / "scene.yaml")
    assert again.with_(load_n=1) == three[0].scene.with_(load_n=1)
    assert recipe["command"].endswith("rolling run small.yaml")


# ---- gains of the player


def test_gains_keep_levels_or_make_them_equal_and_never_clip() -> None:
    """Gains by hand for peaks of 2, 1, 0.1 Pa and LAeq of 80, 70, 60 dB.

    The record with the maximum crest (20 lg of peak over level) limits the equal gains.
    """
    peaks = [2.0, 1.0, 0.1]
    levels = [80.0, 70.0, 60.0]
    heard = 70 - 20 * np.log10(1 / PEAK)  # digital level of the record that limits the others
    for gain, peak, level in zip(page_sounds.gains(peaks, levels), peaks, levels, strict=True):
        assert peak / gain["full_scale_pa"] == pytest.approx(PEAK)
        assert gain["calibrated_pa"] == pytest.approx(2 / PEAK)
        assert gain["calibrated"] == pytest.approx(gain["full_scale_pa"] / gain["calibrated_pa"])
        assert max(gain["calibrated"], gain["equal"]) <= 1 + 1e-12
        equal_pa = gain["full_scale_pa"] / gain["equal"]
        assert level - 20 * np.log10(equal_pa) == pytest.approx(heard)
        assert gain["equal_db"] == pytest.approx(heard - (level - 20 * np.log10(2 / PEAK)))


def test_gains_of_silence_are_zero() -> None:
    silent, loud = page_sounds.gains([0.0, 0.5], [None, 60.0])
    assert (silent["calibrated"], silent["equal"]) == (0, 0)
    assert silent["calibrated_pa"] is None and silent["equal_db"] is None
    assert loud["calibrated"] == loud["equal"] == pytest.approx(1)
    assert page_sounds.gains([0.0], [None])[0]["full_scale_pa"] == 1


# ---- maps


def image_of(uri: str) -> np.ndarray:
    """Decode a PNG in a data URI as RGBA."""
    content = base64.b64decode(uri.partition(",")[2])
    return np.asarray(Image.open(io.BytesIO(content)).convert("RGBA"))


def test_the_sheet_of_maps_holds_every_pressure_at_its_place() -> None:
    """Another reader decodes each pressure as its shade and no pressure as transparent."""
    (run,) = runs_of("lap")
    shown = maps.run_maps(run, 2.1, ends_at_hardness=True)
    assert shown is not None
    (sheet,) = shown["sheets"]
    seen = image_of(sheet["png"])
    palette = maps.palette(ends_at_hardness=True)
    stored = [run.result.maps[position] for position in sorted(run.result.maps)]
    for own, tile, box in zip(stored, sheet["tiles"], sheet["boxes"], strict=True):
        left, top, width, height = tile
        assert (width, height) == own.pressure.shape
        assert box[0] == pytest.approx((own.along - own.distance) * 1e6, abs=1e-3)
        drawn = seen[top : top + height, left : left + width][::-1].swapaxes(0, 1)
        shade = 1 + np.rint(254 * np.clip(own.pressure.astype(float) / 2.1e9, 0, 1)).astype(int)
        loaded = own.pressure > 0
        assert np.array_equal(drawn[..., 3] == 255, loaded)
        assert np.array_equal(drawn[loaded][:, :3], palette[shade[loaded]])


@pytest.mark.parametrize("speed", [0.1, [[0.0, 0.05], [0.01, 0.2], [0.02, 0.1]]])
@pytest.mark.parametrize(("laps", "closes"), [(1.0, True), (1.0, False), (2.5, True), (0.4, False)])
def test_the_map_shown_is_the_nearest_at_any_time(speed, laps, closes) -> None:
    """At 500 times it is the nearest of all maps, across the seam where the lap closes."""
    motion = Motion.of(speed)
    lap = 1e-3
    distances = np.array([0, 0.7, 2.1, 4.0, 7.5, 9.2]) * 1e-4
    distances = distances[distances <= laps * lap]
    begins, order = maps.showing(distances, lap, laps * lap, closes, motion)
    assert begins[0] == 0 and np.all(np.diff(begins) > 0)
    for t in np.linspace(0, motion.duration(laps * lap), 500)[1:-1]:
        shown = order[np.searchsorted(begins, t, side="right") - 1]
        away = np.abs(distances - float(motion.distance(t)) % lap)
        if closes:
            away = np.minimum(away, lap - away)
        assert away[shown] == pytest.approx(away.min(), abs=1e-9)


# ---- film


def test_the_curves_of_a_film_are_the_motion_of_the_run() -> None:
    """Values of a chart have four digits of their differences: 1 mN of 2 N, 1 nm of 2000 nm."""
    _, fast = runs_of("flying")
    motion = fast.vibration_sound.motion
    slow = fast.result.slow_motion
    times = fast.position_time[slow.positions]
    _, chart = film.curves(fast)
    assert chart["title"] == "Motion of the ball"
    height, force = (part["y"] for part in chart["parts"] if part["kind"] == "line")
    ms = chart["xs"][0]
    (rule,) = [part for part in chart["parts"] if part["kind"] == "rule"]
    assert rule["at"] == fast.vibration_sound.load == 0.3
    # A film that begins with the record begins with the first step of the motion.
    assert ms[0] <= 1e3 * max(times[0], motion.time_s[0])
    assert ms[-1] >= 1e3 * (times[-1] - motion.time_step_s)
    above = 1e9 * (motion.displacement_m.mean() - motion.displacement_m)
    for drawn, moved in ((force, motion.force_n), (height, above)):
        shown = np.interp(ms, 1e3 * motion.time_s, moved)
        assert drawn == pytest.approx(shown, abs=1e-3 * np.ptp(shown))


def test_the_flights_of_a_film_are_the_times_without_force() -> None:
    _, fast = runs_of("flying")
    motion = fast.vibration_sound.motion
    begin = motion.time_s[40] + 1e-9
    end = motion.time_s[-40]
    flown = film.flights(fast, np.array([begin, end]))
    assert flown and all(begin <= a < b <= end for a, b in flown)
    within = (motion.time_s >= begin) & (motion.time_s <= end)
    share = float(np.mean(motion.force_n[within] == 0))
    assert sum(b - a for a, b in flown) / (end - begin) == pytest.approx(share, abs=0.01)


# ---- words and tables


def test_levels_have_their_uncertainty_rounded_up(three) -> None:
    table = number_table(three)
    assert table.labels == [run.label for run in three]
    rows = dict(table.rows)
    for run, own, peak in zip(
        three,
        rows["released power, upper bound [dB(A)]"],
        rows["LZpeak of the released power [dB]"],
        strict=True,
    ):
        levels = run.numbers.of_record
        for cell, level, spread in (
            (own, run.released_power.value, run.released_power.uncertainty),
            (peak, levels.lz_peak_db, levels.spreads.lz_peak_db),
        ):
            value, uncertainty = cell.split(" ± ")
            assert float(value) == pytest.approx(level, abs=0.05)
            assert 0.0 <= float(uncertainty) - spread < 0.1


def test_a_number_has_one_uncertainty_on_the_page(three) -> None:
    """The table repeats no level with another ± than that of the quantity."""
    for runs in (three, runs_of("flying"), runs_of("falling")):
        for run in runs:
            for quantity in (run.vibration, run.released_power):
                if quantity.value is None:
                    continue
                cells = [row.cells[0] for row in number_table([run]).rows if "dB(A)]" in row.head]
                same = [cell for cell in cells if cell.split(" ± ")[0] == f"{quantity.value:.1f}"]
                assert quantity.number in same


def test_the_table_of_numbers_is_a_view_of_the_fields(three) -> None:
    """Each number with a word has a row where a run has it, and is written as its field says."""
    (run,) = runs_of("falling")
    rows = dict(number_table([*three, run]).rows)
    contact = three[0].numbers.contact
    assert rows["maximum pressure [GPa]"][0] == f"{contact.max_pressure_pa * 1e-9:.3g}"
    assert rows["restitution of the first impact"][:3] == ["-"] * 3
    assert rows["restitution of the first impact"][3] == f"{run.numbers.motion.restitution:.3f}"
    heads = [*rows]
    assert heads.index("released power, upper bound [dB(A)]") < heads.index("plastic ratio")
    # A level of lasting sound says nothing of an event, and LAE nothing of a lasting sound.
    assert rows["LZeq of the released power [dB]"][3] == "-"
    assert "vibration, computed, LAE (re 1 s) [dB(A)]" in rows
    # The release belongs to a ball that rolls, so the fall has no level of it.
    assert {cells[3] for head, cells in rows.items() if "released power" in head} == {"-"}


def test_the_vibration_stands_before_the_released_power(three) -> None:
    """Both are there for each run, the released power never in the place of the vibration."""
    content = page(three).decode()
    first = re.search(r"<table class=\"answers\">.*?</table>", content, re.S)
    assert first and first[0].index("Vibration") < first[0].index("Released power")
    rows = re.findall(r"<tr>(.*?)</tr>", first[0].partition("<tbody>")[2], re.S)
    for run, row in zip(three, rows, strict=True):
        heard, released = re.findall(r"<td.*?</td>", row, re.S)
        assert f"{run.vibration.value:.1f}" in heard and "beside" not in heard
        assert f"{run.released_power.value:.1f}" in released and 'class="beside"' in released


def test_a_bound_is_never_trusted(three) -> None:
    """Its word is its own, and its numerical error stands beside it."""
    for runs in (three, runs_of("flying"), runs_of("seeds")):
        vibration, released = leading_numbers.shown_columns(runs)
        assert {cell.verdict for cell in released.cells} == {"bound"}
        assert not any(cell.leads for cell in released.cells)
        assert not {cell.verdict for cell in vibration.cells} & {"bound", "assumed"}
        words = dict(leading_numbers.verdict_words(runs))
        assert "bound" in words and "assumed" not in words
    assert 'data-verdict="bound"' in page(three).decode()
    coarse = replace(
        three[0],
        numbers=replace(
            three[0].numbers,
            released_power=three[0].released_power.with_doubts(
                [sized("coarse", "the grid is coarse", 4.2)]
            ),
        ),
    )
    _, released = leading_numbers.shown_columns([coarse])
    (cell,) = released.cells
    assert (cell.verdict, cell.error) == ("bound", "numerically do not quote, ± 4.2 dB")
    assert "Released power is numerically do not quote, ± 4.2 dB: the grid is coarse." in (
        leading_numbers.doubts([coarse])
    )


@pytest.mark.parametrize(("uncertainty", "shown"), [(0.02, "0.1"), (0.1, "0.1"), (0.41, "0.5")])
def test_an_uncertainty_has_one_form(
    uncertainty: float, shown: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Tenths, rounded up, beside a number in another unit; the verdict, whose ± is the same, does
    not repeat it.
    """
    (run,) = runs_of("lap")
    doubt = sized("line", "a line is off", uncertainty)
    quantity = Quantity(
        "v", 81.0, unit="um/s", uncertainty=uncertainty, uncertainty_unit="dB", doubts=(doubt,)
    )
    monkeypatch.setattr(leading_numbers, "_quantities", lambda runs: {"v": [quantity]})
    ((cell,),) = [column.cells for column in leading_numbers.shown_columns([run])]
    assert cell.spread == f"± {shown} dB"
    assert cell.error == ""


def test_an_assumed_share_has_a_word_of_its_own() -> None:
    (run,) = runs_of("lap")
    assumed = solved(run.scene.with_({"sound.q": 0.5}))
    _, released = leading_numbers.shown_columns([assumed])
    assert released.cells[0].verdict == "assumed" and "assumed" in released.remark
    assert "assumed" in dict(leading_numbers.verdict_words([assumed]))
    assert "as if a share of 0.5 became sound" in text.heard(
        assumed, is_alone=True, stated=assumed.stated("release")
    )
    fixed = solved(run.scene.with_({"sound.gain_pa_per_w_m2": 0.1}))
    assert leading_numbers.shown_columns([fixed])[1].cells[0].verdict == "assumed"
    assert "under the gain that the scene fixes" in text.heard(
        fixed, is_alone=True, stated=fixed.stated("release")
    )


@pytest.mark.parametrize("names", [["three"], ["one", "flying"], ["falling"], ["smooth"]])
def test_louder_is_said_of_no_release(names: list[str]) -> None:
    """Only a vibration is louder or quieter than another one, so its sentence has a ball."""
    content = page(runs_of(*names)).decode()
    lead = re.search(r'<p class="lead">(.*?)</p>', content, re.S)
    if re.search("louder|quieter", lead[1]):
        assert re.search(r"the ball is (about )?[0-9.]+\sdB", lead[1])


def test_silence_and_missing_numbers_are_named() -> None:
    (silent,) = runs_of("smooth")
    cells = dict(number_table([silent]).rows)
    for name in ("LZeq", "LZpeak"):
        assert cells[f"{name} of the released power [dB]"] == ["silent"]
    assert cells["LAFmax of the released power [dB(A)]"] == ["silent"]
    assert "is silent" in text.heard(silent, is_alone=True)
    both = runs_of("smooth", "one")
    short = both[1].numbers.of_record
    levels = replace(both[1].numbers.levels, released_power=replace(short, laf_max_db=None))
    few = replace(both[1], numbers=replace(both[1].numbers, levels=levels))
    rows = dict(number_table([both[0], few, both[1]]).rows)
    assert rows["LAFmax of the released power [dB(A)]"][:2] == ["silent", "-"]
    steady = silent.numbers.of_record.steady_level_db  # a constant power has a level, and no sound
    assert f"{steady:.1f}" in cells["steady level of the released power [dB re 1 pW/m²]"][0]


def test_no_row_of_the_numbers_is_empty(three) -> None:
    for runs in (three, runs_of("flying"), runs_of("smooth"), runs_of("falling", "one")):
        table = number_table(runs)
        for head, cells in table.rows:
            assert len(cells) == len(table.labels) and set(cells) != {"-"}, head


def test_templates_and_scripts_know_no_number_by_its_name() -> None:
    """Python hands over what is shown, so a new number needs no change of the page."""
    names = {
        field.name
        for kind in vars(ball_numbers).values()
        if is_dataclass(kind) and kind.__module__ == ball_numbers.__name__
        for field in fields(kind)
        if number_field_of(field) is not None and "_" in field.name
    }
    assert {"max_pressure_pa", "laf_max_db", "released_power"} < names
    assets = Path(str(files("rolling.report").joinpath("assets")))
    shown = [*assets.rglob("*.html"), *assets.rglob("*.js")]
    assert len(shown) > 50
    for path in shown:
        # A slider names the key of the scene that it moves.
        content = re.sub(r'"[a-z]+\.[a-z_]+"', "", path.read_text())
        assert not names & {*re.findall(r"\w+", content)}, path


def test_letters_that_turn_the_text_around_are_escaped() -> None:
    (run,) = runs_of("lap")
    scene = Scene.from_dict(
        run.scene.to_dict() | {"title": "ab\u202egnp.exe\x07"}, run.scene.folder
    )
    assert text.titles([replace(run, scene=scene)]) == r"ab\u202egnp.exe\x07"


def test_each_kind_of_warning_and_equal_assumptions_stand_once(three) -> None:
    warnings = verdict.warnings([(run.label, run.numbers) for run in three])
    keys = [warning.key for warning in warnings]
    assert keys and len(set(keys)) == len(keys)
    assert any("similarly for" in warning.text for warning in warnings)  # other resonances
    facts = dict(text.facts(three, [assumptions(run) for run in three]))
    assert facts["distance"] == [("", "1 m, spherical spreading")]
    assert facts["load"] == [(run.label, f"{run.scene.load:g} N, constant") for run in three]


def test_the_citation_is_that_of_the_citation_file() -> None:
    file = YAML(typ="safe").load(Path(__file__).parents[2] / "CITATION.cff")
    cited = re.findall(r'<p class="cite">(.*)</p>', page(runs_of("lap")).decode())
    for key in ("title", "version"):
        assert str(file[key]) in cited[0]
    assert str(file["date-released"])[:4] in cited[0]
    assert file["authors"][0]["name"].lower() in cited[0].lower()
    (article,) = file["references"]
    for author in article["authors"]:
        assert f"{author['family-names']}, {author['given-names'][0]}." in cited[1]
    for key in ("title", "journal", "year", "volume", "issue", "start", "doi"):
        assert str(article[key]) in cited[1]


def test_levels_that_are_missing_are_gaps_in_the_data_of_the_page(tmp_path) -> None:
    (lap,) = runs_of("lap")
    none = dict.fromkeys(lap.sound.levels.third_octave_db)
    quiet = replace(lap.sound, levels=replace(lap.sound.levels, third_octave_db=none))
    gaps = replace(lap, label="gaps", sound=quiet)
    path = tmp_path / "page.html"
    path.write_bytes(page([lap, gaps]))
    assert data_of(path)["runs"][1]["bands"] == [None] * 31


def test_a_fall_without_an_impact_is_silent_for_a_reason() -> None:
    (run,) = runs_of("edged")
    levels = replace(run.sound.levels, laeq_db=None)
    motion = replace(run.numbers.motion, flight_share=1.0, impacts=0)
    numbers = replace(run.numbers, motion=motion)
    silent = SimpleNamespace(numbers=numbers, sound=replace(run.sound, levels=levels))
    assert "ends before the ball hits the plate" in text.silence(silent)
