"""The command that reproduces the article is killed, continues, and answers in full."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from claim_cases import FIGURES

from rolling import cli
from rolling.lee2025 import study
from rolling.lee2025.standing import WORDS
from rolling.lee2025.statements import CLAIMS, OUTLOOK
from rolling.simulation import result_file, simulate

pytestmark = pytest.mark.slow

# a track longer than contact is wide
SHORT = study.Part(seeds=1, loads=(5, 10), duration_s=0.008, strides=4)
READINGS = ("as-stated", "hardness-3y-exponential")
TWIN = "elastic-gaussian"  # 5 N at two roughnesses
COMMAND = ("reproduce", "lee2025", "--quick", "--readings", *READINGS, TWIN, "--workers", "1")


# Kills the process as it begins the first piece after a case is complete.
KILLED = """\
import os, signal
from rolling.simulation import batch, simulate
march, complete = simulate._ordered_piece, []
end = batch._Work._end_run
def ended(*arguments):
    end(*arguments); complete.append(1)
def piece(*arguments):
    if complete: os.kill(os.getpid(), signal.SIGKILL)
    return march(*arguments)
batch._Work._end_run, simulate._ordered_piece = ended, piece
"""


def complete(out: Path) -> dict[Path, bytes]:
    """Return the whole results by file; a file that is being replaced is read again."""
    return {
        file: file.read_bytes()
        for file in out.rglob("result.h5")
        if result_file.load(file).complete
    }


def test_a_killed_study_goes_on_and_answers_for_each_statement(
    tmp_path: Path, monkeypatch, capsys
) -> None:
    out = tmp_path / "out"
    shortened = (
        f"from rolling import cli; from rolling.lee2025 import study; study.QUICK = study.{SHORT}; "
    )
    process = subprocess.run(
        [sys.executable, "-c", f"{KILLED}{shortened}cli.main({[*COMMAND, '--out', str(out)]})"],
        check=False,
    )
    assert process.returncode == -signal.SIGKILL
    before = complete(out)
    assert before and not (out / "claims.json").exists()

    solved: list[str] = []
    inner = simulate.simulate_piece

    def count(scene, *arguments, **more):
        solved.append(scene.name + str(study.varied(scene)))
        return inner(scene, *arguments, **more)

    monkeypatch.setattr(simulate, "simulate_piece", count)
    monkeypatch.setattr(study, "QUICK", SHORT)
    assert cli.main([*COMMAND, "--out", str(out)]) == 0
    printed = capsys.readouterr().out
    assert (
        "18 cases. " in printed
        and "judged statements" in printed
        and str(out / "index.html") in printed
    )
    assert len(set(solved)) == 18 - len(before) < 18
    assert all(file.read_bytes() == content for file, content in before.items())

    table = json.loads((out / "claims.json").read_text())
    assert [claim["key"] for claim in table["claims"]] == [
        claim.key for claim in (*CLAIMS, *OUTLOOK)
    ]
    assert len(CLAIMS) >= 16
    for claim in table["claims"]:
        found = claim["findings"]
        assert {one["reading"] for one in found} == set(READINGS)
        assert all(one["verdict"] in WORDS and one["measured"] for one in found)
    # 5 and 10 N are enough to judge most of it; what needs more says so.
    words = {
        claim["key"]: {one["verdict"] for one in claim["findings"]} for claim in table["claims"]
    }
    unknown = {key for key, found in words.items() if found == {"not run"}}
    assert unknown == {
        "high-frequency-gap",
        "maximum-load",
        "maximum-flattens",
        "loudest-20-50",
        "loudest-100",
        "length-frequency",
        "length-level",
    }
    yielding = {
        one["reading"]: one["verdict"]
        for one in next(c for c in table["claims"] if c["key"] == "yielding-noise")["findings"]
    }
    # whose twin was named
    assert yielding["hardness-3y-exponential"] == "not run" != yielding["as-stated"]
    assert table["twins"] == [TWIN] and not [*(out / TWIN).glob("fig*")]
    tables = (out / "tables.md").read_text()
    assert tables.startswith("<!--") and "### Readings" in tables and "Of " in tables
    said = (out / "claims.md").read_text()
    page = (out / "index.html").read_text()
    for claim in (*CLAIMS, *OUTLOOK):
        assert claim.statement in said and claim.statement.replace("'", "&#39;") in page
    for reading in READINGS:
        for name in FIGURES:
            svg = (out / reading / f"{name}.svg").read_text()
            assert (out / reading / f"{name}.png").is_file()
            assert name == "fig1_surfaces" or "Ra 5 µm (not valid: too steep)" in svg.replace(
                "<!--", ""
            ).replace("-->", "")


def test_without_workers_of_its_own_choice_it_takes_all_cores(tmp_path: Path, monkeypatch) -> None:
    asked: list[int] = []

    def remember(runs, results, workers, name, begun):
        asked.append(workers)
        raise KeyboardInterrupt

    monkeypatch.setattr(study, "solve_all", remember)
    assert (
        cli.main(
            [
                "reproduce",
                "lee2025",
                "--quick",
                "--readings",
                "as-stated",
                "--out",
                str(tmp_path / "out"),
            ]
        )
        == 130
    )
    assert asked == [0]  # one process per core
