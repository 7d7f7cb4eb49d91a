"""The schema of summary.json and the pages of numbers say what runs have."""

from __future__ import annotations

import json
import re
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from finished import VIBRATING, WITHOUT_DYNAMICS, marched

from rolling import cli
from rolling.kinds.run_folder import SUMMARY
from rolling.numbers import views
from rolling.numbers.ball_numbers import RunNumbers
from rolling.numbers.run_file import StoredBearing, StoredNumbers
from rolling.numbers.summary_schema import summary_schema
from rolling.results.former_numbers import former_names
from rolling.results.run_result import Run, write_run

ROOT = Path(__file__).parents[2]
sys.path.append(str(ROOT / "docs" / "_hooks"))
import number_tables  # noqa: E402
import renamed_numbers  # noqa: E402

CHANNEL = "sound.channels=[{of: contact, quantity: force}]"


@pytest.fixture(scope="module")
def runs() -> list[Run]:
    """Return a run with dynamics and a channel, and one without dynamics."""
    return [marched(VIBRATING, [CHANNEL]), marched(VIBRATING, WITHOUT_DYNAMICS)]


def test_summaries_of_runs_meet_their_schema(runs: list[Run], tmp_path: Path) -> None:
    """The oracle is a validator of JSON Schema that knows nothing of this program."""
    jsonschema = pytest.importorskip("jsonschema", reason="the extra `docs` is not installed")
    schema = summary_schema(StoredNumbers)
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    for run in runs:
        write_run(replace(run, folder=tmp_path / run.vibration.how))
        content = json.loads((tmp_path / run.vibration.how / SUMMARY).read_text(encoding="utf-8"))
        assert list(validator.iter_errors(content)) == []
        for wrong in (
            content | {"format": content["format"] + 1},
            content | {"unknown": 1.0},
            content | {"contact": content["contact"] | {"plastic_ratio": "high"}},
            {name: value for name, value in content.items() if name != "levels"},
        ):
            assert not validator.is_valid(wrong)


@pytest.mark.parametrize(
    ("words", "stored"), [((), StoredNumbers), (("--kind", "bearing"), StoredBearing)]
)
def test_command_prints_the_schema_of_summaries(
    words: tuple[str, ...], stored: type, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["schema", "--summary", *words]) == 0
    assert json.loads(capsys.readouterr().out) == summary_schema(stored)


def test_tables_of_the_docs_have_all_columns_of_runs(runs: list[Run]) -> None:
    text = (ROOT / "docs" / "numbers.md").read_text(encoding="utf-8")
    for run in runs:
        columns = views.columns(run.numbers)
        of_quantities = {
            name
            for quantity in (run.vibration, run.released_power)
            for name in columns
            if name.startswith(f"{quantity.name}_")
        }
        for name in {*columns} - of_quantities | {"vibration_db", "released_power_db"}:
            bold = "**" if columns[name].number_field.in_table else ""
            assert f"{bold}`{name}`{bold}" in text, name
        for name in views.bands_of(run.numbers.bands):
            assert f"**bands.csv**: `{name}`" in text, name


def test_a_meaning_stands_alone() -> None:
    """It is the `long_name` of a variable and a description in a schema, without neighbours."""
    leaning = {
        name: cell.number_field.meaning
        for kind in number_tables.KINDS
        for name, cell in number_tables.columns_of(kind.root).items()
        if re.match(r"(its|the same|they|it)\b", cell.number_field.meaning)
    }
    assert not leaning


def test_each_former_name_has_a_present_one(runs: list[Run]) -> None:
    rows = list(renamed_numbers.renamed())
    places = number_tables.paths_of(RunNumbers)
    for row in rows:
        path = row.path.replace("played.", "levels.vibration.")
        assert path in places or path == "leading", row
    known = {row.former.partition(":")[0] for row in rows}
    for run in runs:
        assert {*former_names(run.numbers)} - known == {"name"}
