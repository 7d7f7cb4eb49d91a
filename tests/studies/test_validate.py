"""`rolling validate` judges each row by its bound and writes one table form for all cases."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rolling
from rolling import cli
from rolling.studies import validate
from rolling.studies.validate import PublishedValue

CONTENT = tomllib.loads((validate.FOLDER / "cases.toml").read_text(encoding="utf-8"))
TABLE = CONTENT["cases"]
CASE = {
    "title": "Numbers",
    "source": "here",
    "scenes": ["plates"],
    "text": "A text.",
    "rows": {
        "share": {"unit": "N", "truth": "norm", "relative": 0.1},
        "shown": {"unit": "m", "truth": "measurement", "published": 2.0, "origin": "choice"},
        "side": {"unit": "1", "truth": "formula", "allowed": [-0.5, 0.0]},
    },
}
FIGURES = [
    PublishedValue("share", "a", 10.0, 10.9),
    PublishedValue("shown", "", math.nan, np.array([6.0, 8.0])),
    PublishedValue("side", "b", 1.0, 0.8),
]


def figures() -> Iterator[PublishedValue]:
    yield from FIGURES


def wrong() -> Iterator[PublishedValue]:
    yield from [*FIGURES, PublishedValue("side", "above", 1.0, 1.001)]


def test_rows_are_judged_by_their_rules() -> None:
    """A share of the published number, no bound, and a bound that is 0 on one side."""
    rows = validate.rows_of(CASE, iter(FIGURES))
    assert [*zip(rows["quantity"], rows["holds"], strict=True)] == [
        ("share, a", True),
        ("shown", True),
        ("side, b", True),
    ]
    assert (rows.least[0], rows.largest[0]) == (-1.0, 1.0)
    assert (rows.published[1], rows.difference[1]) == (2.0, 5.0)
    assert rows.spread[1] == pytest.approx(2**0.5) and math.isnan(rows.spread[0])
    assert rows.share.tolist() == pytest.approx([0.9, 0.0, 0.4])
    for ours in (0.49, 1.001, math.nan):
        assert not validate.rows_of(CASE, iter([PublishedValue("side", "", 1.0, ours)])).holds.any()
    for ours, holds in ((1.19, True), (1.21, False), (0.79, False)):
        rows = validate.rows_of(CASE, iter([PublishedValue("side", "", 1.0, ours, bound=0.2)]))
        assert rows.holds[0] == holds


def test_form_of_the_page() -> None:
    """A table of kinds; a heading, source and table of eight cells a line for each case."""
    rows = validate.rows_of(CASE, wrong())
    page = validate.page({"numbers": rows}, CONTENT | {"cases": {"numbers": CASE}})
    table = [line for line in page.splitlines() if line.startswith("|")]
    kinds = table[:5]
    table = table[5:]
    assert kinds[3:] == [
        "|norm|a norm's table|1|1|0.90|yes|",
        "|formula|closed form|2|2|inf|**no**|",
    ]
    assert len(table) == 2 + 4 and {line.count("|") for line in table} == {9}
    assert table[2] == "|share, a|N|10|10.9|+0.9|±1|-|norm|"
    assert table[3] == "|shown|m|2|7±1.4|+5|-|choice|measurement|"
    assert table[5] == "|side, above|1|1|1.001|+0.001 **beyond**|-0.5 to 0|-|formula|"
    assert "## Numbers" in page and "Source: here." in page and page.endswith("|\n")


@pytest.mark.parametrize(("case", "code"), [(figures, 0), (wrong, 1)])
def test_exit_code(
    case: Any, code: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: Any
) -> None:
    """A single row beyond its bound fails the command, which names it."""
    monkeypatch.setitem(validate.CASES, "impact", case)
    table = (validate.FOLDER / "cases.toml").read_text(encoding="utf-8")
    rules = "".join(
        f"{name} = {{{', '.join(f'{key} = {value!r}' for key, value in rule.items())}}}\n"
        for name, rule in CASE["rows"].items()
    )
    (tmp_path / "cases.toml").write_text(
        table.replace("[cases.impact.rows]\n", f"[cases.impact.rows]\n{rules}"), encoding="utf-8"
    )
    template = "page.md.jinja"
    (tmp_path / template).write_text((validate.FOLDER / template).read_text(encoding="utf-8"))
    monkeypatch.setattr(validate, "FOLDER", tmp_path)
    page = tmp_path / "page.md"
    assert cli.main(["validate", "impact", "--out", str(page)]) == code
    shown = capfd.readouterr()
    assert str(page) in shown.out and ("side, above" in shown.err + shown.out) == bool(code)
    assert page.read_text(encoding="utf-8").startswith("# Validation\n")
    assert cli.main(["validate", "impact", "--out", str(page)]) == code  # it is refreshed
    page.write_text("my notes")
    assert cli.main(["validate", "impact", "--out", str(page)]) == 2
    assert page.read_text() == "my notes"


def test_cases_have_texts_scenes_and_functions() -> None:
    """Kinds of truth and origins of bounds are closed sets; a bound has an origin."""
    for name, case in TABLE.items():
        assert callable(getattr(validate, name.replace("-", "_")))
        assert case["title"] and case["source"] and case["text"]
        for rule in case["rows"].values():
            assert rule["truth"] in CONTENT["kinds"]
            assert rule.get("origin", "choice") in CONTENT["origins"]
            assert "origin" in rule or not {"allowed", "relative"} & {*rule}
        for scene in case["scenes"]:
            assert rolling.read_scene(validate.FOLDER / f"{scene}.yaml").name == scene


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["impakt"], "CASE: got impakt, nearest: impact, allowed: all, contact-filter, impact, "),
        (["impact", "--out", "no/where.md"], "--out: got no/where.md, allowed: a file in a folder"),
        (["impact", "--out", "."], "--out: got ., allowed: a file in a folder"),
    ],
)
def test_refusals(words: list[str], message: str, capfd: Any) -> None:
    """Wrong names are refused at once, in one line."""
    assert cli.main(["validate", *words]) == 2
    refusal = capfd.readouterr().err.splitlines()[-1]
    assert message in refusal


@pytest.mark.slow
def test_plates_and_levels_are_near_phonometry() -> None:
    """Three plates, five bands of radiation, four weightings, levels, and loudness."""
    rows = validate.rows_of(TABLE["phonometry"], validate.phonometry())
    assert len(rows) >= 19 and rows["holds"].all()


@pytest.mark.slow
def test_a_softer_plate_is_beyond_the_contacts_of_other_solvers(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Three solvers agree on ten contacts of a surface; at 1 % less stiffness all rows differ."""
    names = ("area", "plastic area", "pressure", "approach")
    monkeypatch.setattr(validate, "LOADS_N", ())
    monkeypatch.setattr(validate, "LARGE_N", ())
    rows = validate.rows_of(TABLE["rough-contact"], validate.rough_contact())
    assert rows["holds"].all() and len(rows) == 30
    assert {*rows["quantity"].str.partition(",")[0]} == {*names}
    solve = validate.solve_contact

    def softer(half_space: Any, *words: Any, **named: Any) -> Any:
        soft = rolling.HalfSpace(half_space.spacing, 0.99 * half_space.contact_modulus)
        return solve(soft, *words, **named)

    monkeypatch.setattr(validate, "solve_contact", softer)
    assert not validate.rows_of(TABLE["rough-contact"], validate.rough_contact())["holds"].any()


@pytest.mark.slow
def test_a_wrong_plate_is_beyond_its_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    """A plate that is 1 % thicker has a mobility that is 2 % lower."""
    right = validate.plate_of

    def thicker(plate: Any) -> Any:
        body = right(plate)
        return replace(body, thickness_m=1.01 * body.thickness_m)

    monkeypatch.setattr(validate, "plate_of", thicker)
    rows = validate.rows_of(TABLE["phonometry"], validate.phonometry())
    beyond = {*rows["quantity"][~rows["holds"]].str.partition(",")[0]}
    assert {"mobility", "critical frequency"} <= beyond


def test_zener_without_and_with_loss() -> None:
    """A rigid plate keeps all speed; for little loss the restitution is exp(-1.719 l)."""
    assert validate.restitution(0.0) == pytest.approx(1.0, abs=1e-6)
    assert validate.restitution(0.02) == pytest.approx(math.exp(-1.719 * 0.02), abs=2e-4)


@pytest.mark.slow
def test_restitution_on_plates() -> None:
    """The scene of the page, against Zener's equation; its plates share one march."""
    runs = rolling.simulate_sweep(validate._scene("restitution"), workers=1, progress=False)
    kept = [run.numbers.motion.restitution for run in runs.values()]
    assert kept == pytest.approx([0.9894, 0.9585, 0.8455, 0.6328], abs=0.003)


@pytest.mark.slow
def test_a_filter_is_found_and_a_wrong_one_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    """The bands stay within the stated uncertainty, but not with a gain that is 6 dB higher.

    Four short tracks of the six longer ones show it, and two of them the wrong gain.
    """
    scene = validate._scene("synthetic-recording")
    seeds = scene.sweep["surface.seed"][:4]
    shorter = scene.with_(distance_mm=6, sweep={"surface.seed": seeds})
    runs, _ = validate.simulate_runs(shorter, 1, False)  # for which processes start too slowly
    monkeypatch.setattr(validate, "_runs", lambda scene: runs)
    rows = validate.rows_of(TABLE["synthetic-recording"], validate.synthetic_recording())
    assert rows["holds"].all()
    played = validate._played
    monkeypatch.setattr(validate, "_runs", lambda scene: dict(list(runs.items())[:2]))
    monkeypatch.setattr(validate, "_played", lambda pressure: 2 * played(pressure))
    gained = validate.rows_of(TABLE["synthetic-recording"], validate.synthetic_recording())
    assert not gained.set_index("quantity")["holds"]["bands within 2 u"]
