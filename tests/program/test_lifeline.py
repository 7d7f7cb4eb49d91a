"""Real workers end with their parent, even if it is killed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import happenings
import pytest

SCENE = """\
name: long
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}
surface: {kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10, \
spacing_um: 2, width_um: 200, seed: 3}
rolling: {load_n: 1, speed_m_s: 0.1, duration_s: 0.016}
"""
# One task holds Python's lock for ever, as a compiled step of the march does while it lasts; one
# sleeps.
TASKS = """\
import ctypes, os, sys, time

def begin():
    open(os.path.join(sys.argv[1], str(os.getpid())), "w").close()

def busy(stopped, progress):
    begin()
    ctypes.PyDLL(None).sleep(3600)

def asleep(stopped, progress):
    begin()
    time.sleep(3600)
"""
PROGRAM = """\
from rolling.simulation import pool
from tasks import asleep, busy

if __name__ == "__main__":
    tasks = [pool.Task(0, busy, (), 1.0), pool.Task(1, asleep, (), 1.0)]
    pool.work(tasks, 2, lambda run, result: None)
"""

PATIENCE = 120.0  # [s] until something surely does not happen; the tasks would last an hour

pytestmark = pytest.mark.skipif(
    not Path("/proc/self/stat").exists(), reason="processes are found in /proc"
)


def parents() -> dict[int, int]:
    """Return the parent of every running process, without zombies."""
    found = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                # The name stands in brackets and may hold spaces.
                state, parent = (entry / "stat").read_text().rpartition(") ")[2].split()[:2]
            except OSError:
                continue
            if state not in "ZX":
                found[int(entry.name)] = int(parent)
    return found


def descendants(process: int) -> set[int]:
    every, found, grown = parents(), {process}, 0
    while grown != len(found):
        grown = len(found)
        found |= {child for child, parent in every.items() if parent in found}
    return found - {process}


def wait_for(condition) -> bool:
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.05)
    return bool(condition())


def write_program(folder: Path, tasks: str = TASKS) -> str:
    """Write the program and, beside it, the module of its tasks; return the program's path."""
    (folder / "tasks.py").write_text(tasks)
    (folder / "program.py").write_text(PROGRAM)
    return str(folder / "program.py")


def start(arguments: Sequence[str], folder: Path) -> subprocess.Popen:
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    # Imports are found from another folder, too.
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join(filter(None, [str(folder), *sys.path]))
    }
    return subprocess.Popen([sys.executable, *arguments], cwd=folder, env=environment, **quiet)


def assert_all_end(main: subprocess.Popen) -> None:
    """Kill a process, and assert that every process below it ends."""
    below = descendants(main.pid)
    main.send_signal(signal.SIGKILL)
    main.wait()
    try:
        assert wait_for(lambda: not below & set(parents())), f"{below & set(parents())} are left"
    finally:
        for process in below & set(parents()):  # a failed test leaves nothing behind
            os.kill(process, signal.SIGKILL)


def test_workers_that_hold_the_lock_or_sleep_end_with_their_parent(tmp_path: Path) -> None:
    running = tmp_path / "running"
    running.mkdir()
    main = start([write_program(tmp_path), str(running)], tmp_path)
    assert wait_for(lambda: len(list(running.iterdir())) == 2)
    assert {int(file.name) for file in running.iterdir()} <= descendants(main.pid)
    assert_all_end(main)


@pytest.mark.slow
def test_workers_of_a_run_end_with_it(tmp_path: Path) -> None:
    """Both march without end when their parent is killed."""
    (tmp_path / "scene.yaml").write_text(SCENE)
    words = ["run", tmp_path / "scene.yaml", "--out", tmp_path / "out", "--workers", "2"]
    marching = tmp_path / "marching"
    with happenings.started(words, happenings.ENDLESS, tmp_path) as main:
        assert wait_for(lambda: marching.exists() and len([*marching.iterdir()]) == 2)
        assert {int(file.name) for file in marching.iterdir()} <= descendants(main.pid)
        assert_all_end(main)


@pytest.mark.slow
@pytest.mark.parametrize("delay", [0.0, 0.3, 1.0])
def test_workers_that_are_starting_end_with_their_parent(tmp_path: Path, delay: float) -> None:
    main = start([write_program(tmp_path), str(tmp_path)], tmp_path)
    assert wait_for(lambda: len(descendants(main.pid)) >= 2)
    time.sleep(delay)
    assert_all_end(main)


def test_thread_alone_ends_a_worker_where_the_kernel_does_not(tmp_path: Path) -> None:
    """Without prctl, as on other systems, a sleeping worker ends at once."""
    running = tmp_path / "running"
    running.mkdir()
    # Every interpreter of this test imports it when it starts.
    without = "from rolling.simulation import lifeline\nlifeline._ask_kernel = lambda: None\n"
    (tmp_path / "sitecustomize.py").write_text(without)
    main = start(
        [write_program(tmp_path, TASKS.replace("ctypes.PyDLL(None)", "time")), str(running)],
        tmp_path,
    )
    assert wait_for(lambda: len(list(running.iterdir())) == 2)
    assert_all_end(main)
