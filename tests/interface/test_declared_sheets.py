"""Sheets that people hand on have the numbers of the run, K follows ±, and nothing is marched."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bearing_runs import PLATE, WAVY, loads_bearing, turning
from finished import VIBRATING, marched
from report_browser import axe_findings
from scene_text import TINY
from test_pages_of_parts import BEYOND

import rolling as rc
from rolling import cli
from rolling.bearing_kind import bearing_sentences
from rolling.in_si import measured
from rolling.kinds.kind import Kind
from rolling.kinds.registry import kind_of
from rolling.marches import march_piece
from rolling.numbers.doubt import Doubt, Severity
from rolling.numbers.quantity import Quantity
from rolling.numbers.sheet import Sheet, SheetCell
from rolling.report.report_page import page as page_of
from rolling.report.sheets import sheets_page
from rolling.results import noise_sheet
from rolling.surface.parameters import NAMES, parameters

NAME = "declaration"


def cells(sheet: Sheet) -> dict[str, SheetCell]:
    """Return the first cell of each row of a sheet by its symbol."""
    return {row.symbol: row.cells[0] for table in sheet.tables for row in table.rows if row.symbol}


def level(**changes: Any) -> Quantity:
    """Return a level of 11.04 ± 1.2 dB(A) with changes."""
    values = {"value": 11.04, "unit": "dB(A)", "measure": "LAeq", "uncertainty": 1.2}
    return Quantity("vibration", **{**values, **changes})


def declared(quantity: Quantity) -> dict[str, SheetCell]:
    """Return the cells of a declared level by their symbols."""
    return {row.symbol: row.cells[0] for row in noise_sheet.declared_table(quantity).rows}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a run of a ball that is done."""
    scene = tmp_path_factory.mktemp("sheets") / "tiny.yaml"
    scene.write_text(TINY)
    place = scene.parent / "run"
    assert cli.main(["-q", "run", str(scene), "--out", str(place), "--no-report"]) == 0
    return place


@pytest.fixture
def clean(folder: Path) -> Path:
    """Return the folder of the run without a declaration."""
    for path in folder.glob(f"{NAME}.*"):
        path.unlink()
    return folder


# ---- the level


@pytest.mark.law("Sheets: K is 1.645 times the ± of the run, and 95 % lie below L + K.")
@pytest.mark.parametrize("uncertainty", [0.31, 1.2, 2.9])
def test_k_follows_the_uncertainty(uncertainty: float) -> None:
    rows = declared(level(uncertainty=uncertainty))
    expanded, upper = rows["K"].value, rows["Ld"].value
    assert expanded is not None and upper == 11.04 + expanded
    drawn = 11.04 + uncertainty * np.random.default_rng(1).standard_normal(400_000)
    assert np.mean(drawn < upper) == pytest.approx(0.95, abs=0.001)
    assert expanded <= float(rows["K"].text.split()[0]) < expanded + 0.1
    assert f"K = {int(np.ceil(expanded))} dB" in rows["L, K"].text


@pytest.mark.parametrize("value", [-0.04, 11.04, 11.06, 14.9])
def test_the_level_has_the_digits_of_the_run(value: float) -> None:
    quantity = level(value=value)
    assert declared(quantity)["LpA"].text == f"{quantity.number.partition(' ')[0]} dB"


def test_an_event_is_declared_by_its_exposure() -> None:
    assert [*declared(level(measure="LAE"))][:2] == ["LpE,A", "K"]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"value": None, "reason": "nothing vibrates"}, "nothing vibrates"),
        ({"uncertainty": None}, "its uncertainty is not known"),
        (
            {"doubts": (Doubt("short", "the track is short", Severity.DO_NOT_QUOTE, 4.2),)},
            "do not quote, ± 4.2 dB: the track is short",
        ),
    ],
)
def test_a_level_that_is_not_to_be_quoted_is_not_declared(
    changes: dict[str, Any], words: str
) -> None:
    (cell,) = declared(level(**changes)).values()
    assert cell.text == f"not declared: {words}" and cell.value is None


def test_the_parts_add_up_to_the_uncertainty_of_the_run() -> None:
    run = marched(VIBRATING)
    assert run.vibration.uncertainty is not None
    table = noise_sheet.parts_table(run.vibration)
    assert table is not None
    whole, *parts = [row.cells[0].value for row in table.rows]
    assert whole == run.vibration.uncertainty
    assert np.hypot.reduce(parts) == pytest.approx(whole, rel=1e-12)
    assert len(parts) == len([part for part in run.vibration.parts.values() if part])


# ---- the sheets of a run


def test_the_sheets_of_a_ball_are_its_numbers_and_march_nothing(
    clean: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(*_: Any) -> None:
        raise AssertionError("a sheet marched")

    monkeypatch.setattr(march_piece, "march_piece", refuse)
    assert cli.main(["report", str(clean), "--declare"]) == 0
    paths = [clean / f"{NAME}.{ending}" for ending in ("html", "csv", "json")]
    assert capsys.readouterr().out.split() == [str(path) for path in paths]
    run = rc.open_run(clean)
    noise, roughness = json.loads(paths[2].read_text())["runs"][0]["sheets"]
    assert (noise["sheet"], roughness["sheet"]) == ("noise", "roughness")
    values = {value["symbol"]: value for value in roughness["values"] if value["column"] == "value"}
    surface = run.numbers.surface
    assert values["Sa"]["value"] == pytest.approx(surface.ra_m, rel=1e-12)
    assert values["Sdq"]["value"] == pytest.approx(surface.rms_slope, rel=1e-12)
    assert {*NAMES} <= {*values}
    rows = [*csv.DictReader(io.StringIO(paths[1].read_text()))]
    assert len(rows) == len(noise["values"]) + len(roughness["values"])
    first = noise["values"][0]
    quantity = run.vibration
    if noise_sheet.why_not_declared(quantity):
        assert first["value"] is None and quantity.judged is not None
        assert quantity.judged.sentence in first["printed"]
    else:
        assert first["value"] == quantity.value
    page = paths[0].read_text()
    for value in (*noise["values"], *roughness["values"]):
        assert value["printed"].replace(" ", "") in page.replace(" ", "").replace("\xa0", "")


@pytest.mark.parametrize("plate", [WAVY, WAVY + PLATE])
def test_the_sheet_of_a_bearing_has_its_bands(plate: str) -> None:
    words = ["sound.duration_s=0.2", "sound.listen_s=0.2"]
    run = turning() if plate == WAVY else rc.simulate(loads_bearing(plate, words), progress=False)
    vibration, *others = kind_of(run.scene).sheets(run)
    bands, pulses, lines, _ = vibration.tables
    below = run.numbers.below_bending
    shown = bearing_sentences.band_words(run.numbers.ring)
    for row in bands.rows[: 2 * len(shown)]:
        direction, band = row.symbol.split(", ")
        velocity = below.by_direction[direction].by_band[band]
        value, spread, verdict = row.cells
        assert value.value == velocity.value
        assert value.text == f"{bearing_sentences.velocity(velocity.value)} µm/s"
        assert verdict.text == velocity.verdict
        if direction == "axial":  # whose decibels are not known
            assert verdict.text == Severity.DO_NOT_QUOTE.word and value.uncertainty is None
        else:
            assert spread.text in (bearing_sentences.spread_of_velocity(velocity), "-")
    low = pulses.rows[0].cells  # one tone, along the load
    assert low[1].value == pytest.approx(np.sqrt(2), rel=0.02)
    assert low[2].value == pytest.approx(1.5, rel=0.05)
    assert len(lines.rows) == len(run.numbers.lines)
    assert vibration.departures[0].startswith("It has no class V0 to V4: ")
    assert [sheet.name for sheet in others] == ["noise"] * (run.numbers.housing is not None)


@pytest.mark.parametrize("of_ball", [True, False])
def test_the_page_of_a_run_has_the_same_sheets(of_ball: bool) -> None:
    run = marched(VIBRATING) if of_ball else turning()
    sheets = kind_of(run.scene).sheets(run)
    page = page_of([run]).decode()
    assert page.count('<article class="sheet">') == len(sheets)
    own = sheets_page("own", {"run": sheets}, "source").decode()
    begin, end = '<div class="scroll" tabindex="0" role="group" aria-label="', "</table>"
    for table in own.split(begin)[1:]:
        assert f"{begin}{table.partition(end)[0]}" in page


# ---- files


def test_a_declaration_is_replaced_by_its_own_alone(
    clean: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["-q", "report", str(clean), "--declare"]) == 0
    table = clean / f"{NAME}.csv"
    whole = table.read_bytes()
    table.write_bytes(b"".join(whole.splitlines(keepends=True)[:5]))  # of fewer runs
    assert cli.main(["-q", "report", str(clean), "--declare"]) == 0
    assert table.read_bytes() == whole
    for ending, text in (("html", "<p>mine</p>"), ("json", "{}"), ("csv", "mine\n1\n")):
        path = clean / f"{NAME}.{ending}"
        own = path.read_bytes()
        path.write_text(text)
        assert cli.main(["report", str(clean), "--declare"]) == 2
        assert f"{path}: exists" in capsys.readouterr().err
        assert path.read_text() == text
        path.write_bytes(own)
    out = clean.parent / "handed.html"
    assert cli.main(["-q", "report", str(clean), "--declare", "--out", str(out)]) == 0
    assert cli.main(["-q", "report", str(clean), "--declare", "--out", str(out)]) == 2


def test_what_declares_nothing_is_refused(
    clean: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """A kind without sheets, the folder of a choice or of nothing, and too many runs."""
    (tmp_path / "choice.html").write_text("")
    assert cli.main(["report", str(tmp_path), "--declare"]) == 2
    assert str(tmp_path) in capsys.readouterr().err
    kind = kind_of(rc.open_run(clean).scene)
    for name in ("sheets", "surface_sheets"):
        monkeypatch.setattr(type(kind), name, getattr(Kind, name), raising=False)
    assert cli.main(["report", str(clean), "--declare"]) == 2
    assert "a run of a ball has nothing to declare; allowed: " in capsys.readouterr().err
    monkeypatch.setattr("rolling.terminal.defaults.MAX_RUNS_ON_PAGE", 0)
    assert cli.main(["report", str(clean), "--declare"]) == 2
    assert "1 runs: --declare writes the sheets of 0 at most" in capsys.readouterr().err
    assert not [*clean.glob(f"{NAME}.*")]


def test_a_file_of_heights_has_its_report(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    heights = 1e-7 * np.random.default_rng(1).standard_normal((300, 30))
    heights += np.add.outer(1e-6 * np.arange(300), np.zeros(30))
    measured.write(Path("scan.xyz"), heights, (2e-6, 2e-6))
    for _ in range(2):  # its own files are replaced
        assert cli.main(["-q", "surface", "scan.xyz", "--declare"]) == 0
    read = json.loads(Path(f"outputs/scan.xyz-surface/{NAME}.json").read_text())
    (sheet,) = read["runs"][0]["sheets"]
    assert sheet["facts"]["Form"] == "the least-squares plane is removed"
    assert sheet["facts"]["Filters of the surface"] == "none"
    values = {value["symbol"]: value["value"] for value in sheet["values"]}
    table = Path("outputs/scan.xyz-surface/surface.csv").read_text()
    for row in csv.DictReader(io.StringIO(table)):
        assert values[row["parameter"]] == pytest.approx(float(row["value"]), rel=1e-8)
    assert parameters(heights, [2e-6, 2e-6])["Sa"] > 10 * values["Sa"]  # of the plane


@pytest.mark.slow
def test_a_declaration_needs_no_scripts_and_fits_its_paper(clean: Path, browser, opened) -> None:
    assert cli.main(["-q", "report", str(clean), "--declare"]) == 0
    page_file = clean / f"{NAME}.html"
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(page_file.as_uri())
    assert page.locator("article.sheet >> visible=true").count() == 2
    assert page.locator("td >> visible=true").count() == page.locator("td").count()
    page.emulate_media(media="print")
    page.set_viewport_size({"width": 672, "height": 980})  # A4 less its margins, at 96 dpi
    assert page.evaluate("document.scrollingElement.scrollWidth") <= 672
    context.close()
    with opened(page_file, viewport={"width": 390, "height": 844}) as page:
        assert page.evaluate(BEYOND) == []
        assert axe_findings(page) == []
