"""A full disk or a kill at any write of a bearing's run: the same command goes on."""

from __future__ import annotations

import errno
import json
import os
import signal
import time
from pathlib import Path

import pytest
from bearing_runs import WAVY, written
from commands import started

from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling import cli
from rolling.bearing.ring_record import DIRECTIONS
from rolling.bearing_run import stored_run
from rolling.terminal import files

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


@pytest.mark.parametrize("key", ["bands_verdict", "bands_below_bending_um_s", "parts_cpu_s"])
@pytest.mark.parametrize("damage", [["x"], {"radial": "much"}, {"radial": {"low": "much"}}, "text"])
def test_a_part_of_a_summary_that_a_stranger_wrote_is_refused(
    tmp_path: Path, key: str, damage: object
) -> None:
    """Parts that a summary of version 0.8.0 lacks may be missing, but of no other kind."""
    bands = {direction: dict.fromkeys(VELOCITY_BANDS_HZ, 1.0) for direction in DIRECTIONS}
    lists = {name: [] for name in ("lines", "doubts", "contact_doubts", "sentences")}
    listen = {"own_full_scale_m_s2": 1.0, "full_scale_m_s2": 1.0}
    whole = {"bands_um_s": bands, "bands_uncertainty_db": bands, "listen": listen, **lists}
    path = tmp_path / "summary.json"
    path.write_text(json.dumps(whole))
    assert stored_run.read_summary(path) == whole
    path.write_text(json.dumps(whole | {key: damage}))
    with pytest.raises(files.FolderError, match="not readable"):
        stored_run.read_summary(path)


@pytest.mark.slow
def test_a_full_disk_is_told_and_the_same_command_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = written(tmp_path, SHORT)
    words = ["run", str(scene), "--no-report", "-q", "--out"]
    assert cli.main([*words, str(tmp_path / "whole")]) == 0
    wanted = {path.name: path.read_bytes() for path in (tmp_path / "whole").iterdir()}
    write = files.write_bytes
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
            patch.setattr(files, "write_bytes", fill)
            code = cli.main([*words, str(out)])
        if left >= 0:
            break  # the disk had room for all files
        assert code in (1, 2)
        assert "No space left" in capsys.readouterr().err
        assert cli.main([*words, str(out)]) == 0
        for name in ("result.h5", "listen.wav", "acceleration.wav", "lines.csv", "spectrum.csv"):
            assert (out / name).read_bytes() == wanted[name]
    assert number == len(wanted)
    assert stored_run.read_summary(out / "summary.json")["kind"] == "bearing"


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
    doubts = json.loads((out / "summary.json").read_text())["contact_doubts"]
    assert isinstance(doubts, list)
