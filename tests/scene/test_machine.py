"""The memory and the disk of this machine, as its control groups allow them."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from rolling.check import machine


def group(folder: Path, files: dict[str, str], lines: str) -> float:
    """Return the limit of the control groups in a folder."""
    for name, text in files.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    of_process = folder / "cgroup"
    of_process.write_text(lines)
    return machine.group_limit(of_process, folder / "sys")


def test_limit_of_a_control_group_of_version_2_is_the_smallest_on_the_way_up(
    tmp_path: Path,
) -> None:
    files = {
        "sys/a/b/memory.max": "max\n",
        "sys/a/memory.max": "3000\n",
        "sys/memory.max": "5000\n",
    }
    assert group(tmp_path, files, "0::/a/b\n") == 3000
    # a container that sees the path of its host
    assert group(tmp_path, {}, "0::/elsewhere\n") == 5000
    assert group(tmp_path, {"sys/memory.max": "max\n"}, "0::/\n") == math.inf


def test_limit_of_a_control_group_of_version_1(tmp_path: Path) -> None:
    files = {
        "sys/memory/job/memory.limit_in_bytes": "4000\n",
        "sys/memory/memory.limit_in_bytes": "9223372036854771712\n",
    }
    assert group(tmp_path, files, "9:cpu,cpuacct:/x\n4:memory:/job\n0::/\n") == 4000
    assert group(tmp_path, {}, "4:memory:/other\n") == 9223372036854771712  # as good as none


def test_control_groups_that_say_nothing_are_no_limit(tmp_path: Path) -> None:
    assert machine.group_limit(tmp_path / "none", tmp_path) == math.inf
    assert group(tmp_path, {"sys/memory.max": "many\n"}, "0::/../../..\nnonsense\n") == math.inf
    assert 0 < machine.memory() < 1e15  # what this machine says


def test_free_disk_is_that_of_the_nearest_folder_there_is(tmp_path: Path) -> None:
    assert machine.free_disk(tmp_path / "no" / "such" / "folder") == pytest.approx(
        machine.free_disk(tmp_path), rel=0.1
    )
