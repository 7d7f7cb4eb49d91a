"""Help is instant, usage errors give code 2, and the schema and the check print."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from rolling import cli

SCENES = Path(__file__).parents[2] / "scenarios"


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys, rolling.cli\n"
        "try: rolling.cli.main(['--help'])\n"
        "except SystemExit: pass\n"
        "print(sorted(sys.modules))"
    )
    printed = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout
    assert "usage: rolling" in printed
    for heavy in ("numpy", "numba", "pydantic", "matplotlib"):
        assert f"'{heavy}'" not in printed


def test_schema_is_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["schema"]) == 0
    assert json.loads(capsys.readouterr().out)["$schema"].endswith("2020-12/schema")


def test_check_says_what_a_scene_costs(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["check", str(SCENES / "quickstart.yaml")]) == 0
    printed = capsys.readouterr().out
    for word in ("steps", "window", "memory", "time", "Hertz", "Nyquist", "correlation"):
        assert word.lower() in printed.lower()


def test_missing_scene_is_bad_input(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["run", str(tmp_path / "none.yaml")]) == 2
    assert "none.yaml" in capsys.readouterr().err
    assert cli.main(["resume", str(tmp_path)]) == 2
    assert "not a run folder" in capsys.readouterr().err


def test_usage_error_is_2() -> None:
    for arguments in (["sing"], ["run"], ["run", "x.yaml", "--workers", "0"]):
        with pytest.raises(SystemExit) as stopped:
            cli.main(arguments)
        assert stopped.value.code == 2
