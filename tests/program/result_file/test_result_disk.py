"""A full disk costs no finished work, and a long run is kept in bounded time and space."""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from stored_results import same

from rolling import cli, commands
from rolling.commands import work
from rolling.simulation import batch, result_file, simulate
from rolling.simulation.result import Result

COMMAND = """\
import sys, resource
from rolling import cli
from rolling.commands import work
from rolling.folders import files as run_folder
work.write_pictures = lambda *_: []
run_folder.Keeper.due = lambda self: True
LIMIT
sys.exit(cli.main(sys.argv[1:]))
"""


FREE = "from rolling.check import machine; machine.free_disk = lambda folder: 1e12"


def limited(arguments: list[str], limit: str = "") -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", COMMAND.replace("LIMIT", limit), *arguments, "--workers", "1"]
    return subprocess.run(command, capture_output=True, text=True, timeout=900)


@pytest.mark.slow
def test_a_file_that_may_not_grow_ends_in_one_message(whole: Path, tmp_path: Path) -> None:
    """A limit on the size of result.h5 ends in exit code 1 and keeps earlier work whole."""
    size = (whole / "result.h5").stat().st_size
    limit = f"resource.setrlimit(resource.RLIMIT_FSIZE, ({size // 2}, {size // 2}))"
    done = limited(["run", str(whole.parent / "s.yaml"), "--out", str(tmp_path / "out")], limit)
    assert done.returncode == 1, done.stderr
    assert done.stderr.count("cannot be written (File too large)") == 1 and "resume" in done.stderr
    assert "Traceback" not in done.stderr and "HDF5" not in done.stderr
    # The limit is below the size of any part, so nothing is there, and nothing half written.
    assert not (tmp_path / "out" / "result.h5").exists()
    assert not list((tmp_path / "out").glob(".*partial"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(work, "write_pictures", lambda *_: [])
        assert cli.main(["resume", str(tmp_path / "out"), "--workers", "1"]) == 0
    assert np.array_equal(
        result_file.load(tmp_path / "out" / "result.h5").series["approach"],
        result_file.load(whole / "result.h5").series["approach"],
    )


@pytest.mark.slow
def test_a_full_disk_ends_in_one_message(whole: Path, tmp_path: Path) -> None:
    disk = tmp_path / "disk"
    disk.mkdir()
    size = (whole / "result.h5").stat().st_size
    mounted = ["mount", "-t", "tmpfs", "-o", f"size={int(1.2 * size)}", "tmpfs", str(disk)]
    if (
        os.getuid()
        or shutil.which("mount") is None
        or subprocess.run(mounted, capture_output=True).returncode
    ):
        pytest.skip("no file system may be mounted here; the limit on files covers it")
    try:
        # Somebody else fills the disk after the run has begun: it was free when the run asked.
        done = limited(["run", str(whole.parent / "s.yaml"), "--out", str(disk / "out")], FREE)
        assert done.returncode == 1, done.stderr
        assert done.stderr.count("No space left on device") == 1 and "Traceback" not in done.stderr
        assert result_file.load(disk / "out" / "result.h5").done_steps >= 0
        assert not list((disk / "out").glob(".*partial"))
    finally:
        subprocess.run(["umount", "-l", str(disk)], check=True)


def test_a_long_run_is_kept_in_bounded_time_memory_and_space(whole: Path, tmp_path: Path) -> None:
    """2500 pieces of events in 500,000 steps do not slow the writing.

    With a group for each piece it took minutes.
    """
    steps, each = 500_000, 8
    scene = commands.read_runs(whole)[0].scene.to_dict()
    scene["rolling"] |= {"speed_m_s": 0.1, "duration_s": steps * 2e-5}
    one = batch.Run({}, type(commands.read_runs(whole)[0].scene).from_dict(scene), tmp_path)
    result = Result.empty(one.scene.track, 0.0)
    rng = np.random.default_rng(0)
    for name, values in result.series.items():
        values[: len(values) - 200] = (
            1e-9 if name == "release_energy" else np.floor(rng.uniform(1, 9, len(values) - 200))
        )
    peak = np.full(each, 200e-9 / each)
    for first, last in simulate.pieces(steps)[:-1]:
        first_column = np.full(each, first)
        result.event_pieces[first] = {
            "node": np.zeros((each, 2), np.int32),
            "first": first_column,
            "last": np.full(each, last),
            "energy": peak,
            "peak": peak,
        }
    assert len(result.event_pieces) == 2499
    resident = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    began = time.process_time()
    batch.keep(one, result)
    written = time.process_time() - began
    assert written < 10  # 1 s measured; the Keeper writes for a twentieth of the time at most
    size = (tmp_path / "result.h5").stat().st_size
    values = 19 * 8 * steps  # of the series, without coordinates
    assert size < 1.1 * values
    assert 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - resident) < 5 * size
    assert same(result_file.load(tmp_path / "result.h5"), result)
