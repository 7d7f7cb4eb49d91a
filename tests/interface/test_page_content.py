"""The report is a single file that asks for nothing, with escaped text and right numbers."""

from __future__ import annotations

import io
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from report_runs import HOSTILE, NO_PAGE, Runs, run_results
from ruamel.yaml import YAML

from rolling import cli, commands
from rolling.commands import work
from rolling.folders import run_record
from rolling.report import citation, page, pressure_maps, text
from rolling.report.playback import PEAK, playbacks
from rolling.scene.motion import Motion
from rolling.simulation.simulate import PressureMap

SHORT = ("--set", "rolling.duration_s=0.0006", "--workers", "1")
MARKUP = re.compile(r"<(?P<tag>[a-z]+)[^>]*?(?:src|href)=\"(?P<target>[^\"]*)\"", re.S)


@pytest.fixture(scope="session")
def one_page(runs: Runs, tmp_path_factory: pytest.TempPathFactory) -> str:
    out = tmp_path_factory.mktemp("page") / "one.html"
    assert cli.main(["report", str(runs.one()), "--out", str(out)]) == 0
    return out.read_text()


@pytest.mark.slow
def test_page_is_one_file_that_asks_for_nothing(one_page) -> None:
    every = [match["target"] for match in MARKUP.finditer(one_page)]
    targets = [target for target in every if not target.startswith("#")]  # within the page
    assert len(targets) > 8
    assert {target.partition(":")[0] for target in targets} == {"data"}
    policy = re.search(r'Content-Security-Policy" content="([^"]+)"', one_page)
    assert policy and policy[1].startswith("default-src 'none'")
    assert not re.search(
        r"<link|@import|url\(|<[a-z]+\s[^<>]*\son[a-z]+=", re.sub(r"data:[^\"']+", "", one_page)
    )


def test_text_of_the_scene_is_escaped_in_markup_and_script(one_page) -> None:
    assert HOSTILE not in one_page
    assert (
        "<img src=x" not in one_page and "<!-- <script>" not in one_page and "z<i>" not in one_page
    )
    # The page's own two scripts, and what ends them.
    assert one_page.count("<script") == one_page.count("</script") == 2


def test_exit_codes_and_nothing_is_overwritten(runs, tmp_path, capsys, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(page, "page", lambda *_: b"the page")  # what is written where, not what
    monkeypatch.setattr(page, "exhibits", lambda *_: [])
    source = str(runs.smooth())
    out = tmp_path / "new" / "page.html"
    assert cli.main(["report", str(tmp_path / "none")]) == 2
    assert "not a run folder" in capsys.readouterr().err
    assert cli.main(["report", source, str(tmp_path), "--out", str(out)]) == 2
    assert list(tmp_path.iterdir()) == []
    assert cli.main(["report", source, "--out", str(out)]) == 0
    out.write_text("mine")
    capsys.readouterr()
    assert cli.main(["report", source, "--out", str(out)]) == 2
    assert "--force" in capsys.readouterr().err and out.read_text() == "mine"
    assert cli.main(["report", source, "--out", str(tmp_path), "--force"]) == 2
    assert cli.main(["report", source, "--out", str(out), "--force"]) == 2
    assert out.read_text() == "mine"  # a page replaces pages only
    assert cli.main(["report", source, str(runs.one())]) == 0
    (made,) = (tmp_path / "outputs" / "report").glob("*/report.html")
    assert (
        made.read_text() == "the page"
        and str(made.relative_to(tmp_path)) in capsys.readouterr().out
    )


def test_unsolved_runs_are_refused(runs, tmp_path, capsys) -> None:
    scene = tmp_path / "resolved.yaml"
    scene.write_bytes((runs.smooth() / "resolved.yaml").read_bytes())
    assert cli.main(["report", str(tmp_path)]) == 2
    assert "nothing is solved yet" in capsys.readouterr().err
    assert [f.name for f in tmp_path.iterdir()] == ["resolved.yaml"]


def test_many_runs_have_a_page_without_players(runs, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(page, "MOST_RUNS", 2)
    monkeypatch.setattr(page, "exhibits", lambda *_: [])
    out = tmp_path / "page.html"
    assert cli.main(["report", str(runs.three()), "--out", str(out)]) == 0
    html = out.read_text()
    assert page.is_page(out) and "3 runs are too many to be heard side by side" in html
    for label in ("load 0.5 N", "load 1 N", "load 2 N"):
        assert f'<th scope="row">{label}</th>' in html
    assert "<audio" not in html and "<script" not in html


@pytest.mark.slow
def test_runs_write_the_page_unless_told_not_to(runs, tmp_path, capsys) -> None:
    scene = runs.folder / "smooth.yaml"
    runs.smooth()
    first, second, third = tmp_path / "first", tmp_path / "second", tmp_path / "third"
    assert cli.main(["run", str(scene), *SHORT, "--out", str(first)]) == 0
    assert str(first / "report.html") in capsys.readouterr().out
    assert page.is_page(first / "report.html")
    assert (first / "report.html").stat().st_mtime <= (first / "run.json").stat().st_mtime
    assert cli.main(["run", str(scene), *SHORT, "--out", str(second), "--no-report"]) == 0
    assert not (second / "report.html").exists()
    assert (
        cli.main(
            [
                "resound",
                str(first),
                "--set",
                "sound.distance_m=2",
                "--out",
                str(third),
                "--no-report",
            ]
        )
        == 0
    )
    assert not (third / "report.html").exists()
    assert cli.main(["report", str(third)]) == 0
    assert (third / "report.html").is_file()


@pytest.mark.slow
def test_a_page_that_cannot_be_written_loses_nothing_of_the_run(
    runs, tmp_path, capsys, monkeypatch
) -> None:
    runs.smooth()
    out = tmp_path / "out"

    def full(*_):
        raise OSError("No space left on device")

    monkeypatch.setattr(page, "page", full)
    assert cli.main(["run", str(runs.folder / "smooth.yaml"), *SHORT, "--out", str(out)]) == 1
    assert "No space left" in capsys.readouterr().err
    for name in ("result.h5", "signal.wav", "summary.json", "spectrum.svg"):
        assert (out / name).is_file()
    assert run_record.read(out).state != "done"
    monkeypatch.undo()
    assert cli.main(["resume", str(out), "--workers", "1"]) == 0
    assert (out / "report.html").is_file() and run_record.read(out).state == "done"


@pytest.mark.slow
def test_three_records_of_ten_seconds_stay_below_15_mb(runs, tmp_path) -> None:
    """At 0.009 m/s the stored runs last 10 s, without a new solve."""
    slow = tmp_path / "slow"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(work, "write_pictures", lambda *_: [])
        speed = ["rolling.speed_m_s=0.009"]
        assert commands.resound(runs.three(), speed, slow, wanted=NO_PAGE).exit_code == 0
    assert commands.report([slow], tmp_path / "page.html").stat().st_size < 15e6


# ---- gains


def test_gains_keep_levels_or_make_them_equal_and_never_clip() -> None:
    """Gains by hand for peaks of 2, 1, 0.1 Pa and LAeq of 80, 70, 60 dB.

    The record with the maximum crest (20 lg of peak over level) limits the equal gains.
    """
    peaks, levels = [2.0, 1.0, 0.1], [80.0, 70.0, 60.0]
    found = playbacks(peaks, levels)
    for one, peak, level in zip(found, peaks, levels, strict=True):
        assert peak / one.full_scale_pa == pytest.approx(PEAK)
        assert one.calibrated == pytest.approx(one.full_scale_pa / one.calibrated_pa)
        assert one.calibrated_pa == pytest.approx(2 / PEAK)
        assert PEAK * one.calibrated <= PEAK * (1 + 1e-12) and PEAK * one.equal <= PEAK * (
            1 + 1e-12
        )
        # What is heard: the level less the pascals of full scale.
        assert level - 20 * np.log10(one.equal_pa) == pytest.approx(70 - 20 * np.log10(1 / PEAK))
        assert one.equal_db == pytest.approx(
            70 - 20 * np.log10(1 / PEAK) - (level - 20 * np.log10(2 / PEAK))
        )


def test_gains_of_silence_are_nought() -> None:
    silent, loud = playbacks([0.0, 0.5], [None, 60.0])
    assert (silent.calibrated, silent.equal, silent.calibrated_pa, silent.equal_db) == (
        0,
        0,
        None,
        None,
    )
    assert loud.calibrated == loud.equal == pytest.approx(1)
    assert playbacks([0.0], [None])[0].full_scale_pa == 1


# ---- sprites


def test_sheet_holds_every_pressure_where_it_says() -> None:
    """Another reader decodes each pressure as its shade and no pressure as transparent."""
    rng = np.random.default_rng(4)
    maps = []
    for k in range(7):
        pressure = rng.uniform(0, 2e9, (5 + k, 9 - k)).astype(np.float32)
        pressure[1, 2] = 0
        maps.append(PressureMap(k, k * 1e-4, k * 1e-4 - 1e-5, 4e-5, 2e-6, pressure))
    sheet = pressure_maps.sheet(maps, 5e-5, 2e9)
    picture = Image.open(io.BytesIO(sheet.png))
    assert picture.mode == "P"
    seen = np.asarray(picture.convert("RGBA"))
    palette = pressure_maps.palette()
    for one, (left, top, width, height), box in zip(maps, sheet.tiles, sheet.boxes, strict=True):
        assert (width, height) == one.pressure.shape
        # 10 um behind the centre; the uppermost edge is at 40 um + cells, the middle at 50 um.
        assert box == pytest.approx((-10, 40 + 2 * height - 50, 2))
        for i in range(width):
            for j in range(height):
                pixel = seen[top + height - 1 - j, left + i]
                expected = palette[1 + round(254 * float(one.pressure[i, j]) / 2e9)]
                if one.pressure[i, j]:
                    assert pixel.tolist() == [*expected.tolist(), 255]
                else:
                    assert pixel[3] == 0
    reach = max(
        max(10, 2 * one.pressure.shape[0] - 10, 2 * one.pressure.shape[1] - 10) for one in maps
    )
    assert pressure_maps.half_width([sheet], [3.0]) == pytest.approx(1.05 * reach)


@pytest.mark.parametrize("speed", [0.1, [[0.0, 0.05], [0.01, 0.2], [0.02, 0.1]]])
@pytest.mark.parametrize(("laps", "closes"), [(1.0, True), (1.0, False), (2.5, True), (0.4, False)])
def test_map_shown_is_the_nearest_one_at_any_time(speed, laps, closes) -> None:
    """At 500 times it is the nearest of all maps, across the seam where the lap closes."""
    motion, lap = Motion.of(speed), 1e-3
    distances = np.array([0, 0.7, 2.1, 4.0, 7.5, 9.2]) * 1e-4
    distances = distances[distances <= laps * lap]
    begins, order = pressure_maps.showing(distances, lap, laps * lap, closes, motion)
    assert begins[0] == 0 and np.all(np.diff(begins) > 0)
    for t in np.linspace(0, motion.duration(laps * lap), 500)[1:-1]:
        shown = order[np.searchsorted(begins, t, side="right") - 1]
        rolled = float(motion.distance(t))
        away = np.abs(distances - rolled % lap)
        if closes:
            away = np.minimum(away, lap - away)
        assert away[shown] == pytest.approx(away.min(), abs=1e-9)


# ---- words and tables


def test_numbers_that_are_missing_or_silent_are_said(runs) -> None:
    (silent,) = run_results(runs.smooth())
    table = text.levels([silent])
    assert table.rows[0][1][:5] == ["silent"] * 5
    assert "No sound" in text.sentence([silent])
    old = replace(
        silent, summary={k: v for k, v in silent.summary.items() if not k.startswith("la")}
    )
    assert "-" in text.levels([old]).rows[0][1]
    head, *rows = [
        line.split("\t") for line in text.tsv([old]).splitlines() if not line.startswith("#")
    ]
    assert rows and all(len(row) == len(head) for row in rows)


def test_table_gives_levels_with_their_uncertainty(runs) -> None:
    heard = run_results(runs.three())
    table = text.levels(heard)
    column = table.heads.index("LAeq [dB]")
    for one, (label, cells) in zip(heard, table.rows, strict=True):
        assert label == one.label
        value, uncertainty = cells[column].split(" ± ")
        assert float(value) == pytest.approx(one.summary["laeq_db"], abs=0.05)
        # Rounded up: never less than it is, never 0.0.
        assert 0.0 <= float(uncertainty) - one.summary["uncertainty_db"]["laeq"] < 0.1
    said = text.sentence(heard)
    assert "at 1 m" in said and heard[0].label in said and heard[-1].label in said


def test_each_kind_of_warning_and_equal_assumptions_are_said_once(runs) -> None:
    heard = run_results(runs.three())
    warnings = text.warnings(heard)
    keys = [each.key for each in warnings]
    assert keys and len(set(keys)) == len(keys)
    for each in warnings:
        texts = {
            one.label: c["text"]
            for one in heard
            for c in one.summary["caveats"]
            if c["key"] == each.key
        }
        assert list(each.labels or [one.label for one in heard]) == list(texts)
        first = next(iter(texts))
        assert each.text == texts[first] + (
            f" (in the numbers of {first})" if len(set(texts.values())) > 1 else ""
        )
    # each load has a resonance of its own
    assert any("in the numbers of" in each.text for each in warnings)
    facts = {fact.name: fact.values for fact in text.assumptions(heard)}
    assert facts["distance"] == [("", "1 m, spherical spreading")]
    assert any("rms slope 0.025 (holds up to 0.3)" in value for _, value in facts["half-space"])
    assert facts["load"] == [(one.label, f"{one.scene.load:g} N, constant") for one in heard]


def test_citation_is_that_of_the_citation_file() -> None:
    file = YAML(typ="safe").load(Path(__file__).parents[2] / "CITATION.cff")
    assert file["title"] in citation.PROGRAM and str(file["version"]) in citation.PROGRAM
    assert str(file["date-released"])[:4] in citation.PROGRAM
    assert file["authors"][0]["name"].lower() in citation.PROGRAM.lower()
    (article,) = file["references"]
    for author in article["authors"]:
        assert f"{author['family-names']}, {author['given-names'][0]}." in citation.ARTICLE
    for key in ("title", "journal", "year", "volume", "issue", "start", "doi"):
        assert str(article[key]) in citation.ARTICLE
