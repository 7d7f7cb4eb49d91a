"""A full disk or a kill at any write of a bearing's run: the same command goes on."""

from __future__ import annotations

import errno
import json
import os
import signal
import time
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest
from bearing_runs import WAVY, loads_bearing, written
from commands import started, tree
from stored_arrays import content_of

import rolling
from rolling import cli
from rolling.bearing_kind.bearing_run import BearingRun
from rolling.bearing_kind.former_bearing import former_names
from rolling.numbers.bearing_numbers import BearingNumbers
from rolling.numbers.number_files import to_bytes
from rolling.results.provenance import program_provenance
from rolling.results.stored_numbers import read_stored
from rolling.terminal import whole_files

SHORT = WAVY.replace("0.5", "0.1")
ROUGH = """
name: rough
bearing:
  named: "608"
  speed_rpm: 1800
  axial_load_n: 20
  surfaces: {balls: {kind: graded, grade: G20, seed: 1}}
sound: {duration_s: 0.1, listen_s: 0.1}
numerics: {window_mm: 2}
"""


@pytest.fixture(scope="module")
def run() -> BearingRun:
    return rolling.simulate(loads_bearing(SHORT), progress=False)


def former_summary(run: BearingRun) -> dict[str, Any]:
    """Return the summary.json of a run as version 0.8 wrote it."""
    gains = {"seconds": 0.1, "own_full_scale_m_s2": 1.5, "full_scale_m_s2": 3.0}
    provenance = program_provenance(run.label)
    facts = {"listen": gains, "provenance": json.loads(to_bytes(provenance))}
    return {**former_names(run.numbers, run.label), **facts}


def velocities_of(numbers: BearingNumbers) -> list[tuple[object, ...]]:
    """Return value, ±, verdict and parts of all velocities."""
    return [
        (one.name, one.value, one.uncertainty, one.verdict, one.parts)
        for velocities in (numbers.velocities, numbers.below_bending)
        for bands in velocities.by_direction.values()
        for one in bands.by_band.values()
    ]


def test_a_summary_of_version_0_8_has_the_same_numbers(run: BearingRun, tmp_path: Path) -> None:
    """Parts below the bending follow from the stored ± there, so they have its rounding."""
    (tmp_path / "summary.json").write_text(json.dumps(former_summary(run)))
    read = read_stored(tmp_path)
    numbers = read.numbers
    assert read.files.listen.full_scale == 3.0
    for own, stored in zip(velocities_of(run.numbers), velocities_of(numbers), strict=True):
        assert stored[:2] == own[:2] and stored[3] == own[3]
        assert stored[2] == pytest.approx(own[2], rel=1e-9, abs=1e-15)
        assert stored[4] == pytest.approx(own[4], rel=1e-6, abs=1e-9)
    unknown = {"envelope_band", "pulses", "vibration_class"}  # to that version
    assert all(getattr(numbers, name) is None for name in unknown)
    same = {field.name for field in fields(BearingNumbers)} - {"velocities", "below_bending"}
    for name in same - unknown:
        assert getattr(numbers, name) == getattr(run.numbers, name), name


def test_a_summary_of_version_0_8_0_lacks_what_it_did_not_know(
    run: BearingRun, tmp_path: Path
) -> None:
    """It has the ± of the record alone, and no velocity of a band that the bending cuts."""
    summary = former_summary(run)
    for name in [*summary]:
        if name.startswith("bands_") and name not in ("bands_um_s", "bands_uncertainty_db"):
            del summary[name]
    del summary["contact_angles_under_loads_deg"]
    summary["contact_angle_under_load_deg"] = 13.9
    (tmp_path / "summary.json").write_text(json.dumps(summary))
    numbers = read_stored(tmp_path).numbers
    own = run.numbers.velocities.radial
    assert numbers.below_bending.radial.low.value == own.low.value
    assert numbers.below_bending.radial.high.value is None
    assert "0.8" in str(numbers.below_bending.radial.high)
    assert numbers.velocities.radial.high.uncertainty == own.high.uncertainty
    assert numbers.angles.largest_under_loads_deg == 13.9


@pytest.mark.parametrize(
    "key", ["bands_um_s", "bands_below_bending_um_s", "bands_uncertainty_parts_db", "parts_cpu_s"]
)
@pytest.mark.parametrize("damage", [["x"], {"radial": "much"}, {"radial": {"low": "much"}}, "text"])
def test_a_part_of_a_summary_that_a_stranger_wrote_is_refused(
    tmp_path: Path, run: BearingRun, key: str, damage: object
) -> None:
    (tmp_path / "summary.json").write_text(json.dumps(former_summary(run) | {key: damage}))
    with pytest.raises(whole_files.FolderError, match="not readable"):
        read_stored(tmp_path)


@pytest.mark.parametrize("damage", [None, "much", [1.0], {"value": "much"}])
def test_a_number_that_a_stranger_wrote_is_refused(
    tmp_path: Path, run: BearingRun, damage: object
) -> None:
    folder = rolling.save_run(run, tmp_path / "run", report=False)
    content = json.loads((folder / "numbers.json").read_text())
    content["numbers"]["velocities"]["radial"]["low"] = damage
    (folder / "numbers.json").write_text(json.dumps(content))
    with pytest.raises(whole_files.FolderError, match=r"numbers\.velocities\.radial\.low"):
        read_stored(folder)


def test_a_folder_of_version_0_8_is_shown_and_not_resumed(
    tmp_path: Path, run: BearingRun, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = rolling.save_run(run, tmp_path / "run", report=False)
    (folder / "numbers.json").unlink()
    (folder / "summary.json").write_text(json.dumps(former_summary(run)))
    before = tree(folder)
    for words in (
        ["run", str(folder / "scene.yaml"), "--out", str(folder)],
        ["listen", str(folder)],
    ):
        assert cli.main(words) == 2
        said = capsys.readouterr().err
        assert "a run of version 0.8" in said and "Version 0.8.1 does" in said
    assert tree(folder) == before
    assert cli.main(["table", str(folder)]) == 0
    assert cli.main(["report", str(folder), "-q"]) == 0
    shown = rolling.open_run(folder).numbers
    assert shown.sentences == run.numbers.sentences
    page = (folder / "report.html").read_text().replace("\N{NO-BREAK SPACE}", " ")
    assert shown.sentences[0].replace(" um/s", " µm/s") in page


@pytest.mark.slow
def test_a_full_disk_is_told_and_the_same_command_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = written(tmp_path, SHORT)
    words = ["run", str(scene), "--no-report", "-q", "--out"]
    assert cli.main([*words, str(tmp_path / "whole")]) == 0
    wanted = {path.name: content_of(path) for path in (tmp_path / "whole").iterdir()}
    write = whole_files.write_bytes
    left = 0

    def fill(path: Path, content: bytes) -> None:
        nonlocal left
        left -= 1
        if left < 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
        write(path, content)

    for number in range(len(wanted) + 1):
        left = number
        out = tmp_path / f"full-{number}"
        with monkeypatch.context() as patch:
            patch.setattr(whole_files, "write_bytes", fill)
            code = cli.main([*words, str(out)])
        if left >= 0:
            break  # the disk had room for all files
        assert code in (1, 2)
        assert "No space left" in capsys.readouterr().err
        assert cli.main([*words, str(out)]) == 0
        for name in ("result.h5", "listen.wav", "acceleration.wav", "lines.csv", "spectrum.csv"):
            assert content_of(out / name) == wanted[name]
    assert number == len(wanted)
    assert read_stored(out).kind == "bearing"


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="no SIGINT to another process on Windows")
def test_ctrl_c_keeps_finished_marches(tmp_path: Path) -> None:
    """Marches that are kept are not marched again."""
    scene = written(tmp_path, ROUGH)
    out = tmp_path / "out"
    words = ["run", scene, "--out", out, "--no-report", "--workers", "1"]
    with started(words, tmp_path) as process:
        while not list(out.glob("contacts/*.npz")) and process.poll() is None:
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        assert process.wait() == 130
    assert "the same command goes on" in (tmp_path / "said").read_text()
    assert not (out / "summary.json").exists()
    kept = {path: path.stat().st_mtime_ns for path in out.glob("contacts/*.npz")}
    assert kept and cli.main([*map(str, words), "-q"]) == 0
    assert all(path.stat().st_mtime_ns == then for path, then in kept.items())
    assert read_stored(out).numbers.contacts
