"""Time the first answers of two installations in turn, and print the ratios of the second one.

Run: python tests/benchmarks/first_minute.py OLD NEW [--rounds N] [TASK ...]

OLD and NEW are the `rolling` commands of two environments. Each task runs N times with both, in
turn, in a folder of its own. All but the ten short runs begin without compiled kernels, as after an
installation. The table has medians of wall seconds to the first sound, to the first page and to the
end, and of processor seconds of all processes. Nothing else should run on the machine.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

NODES, SPACING_UM = 400, 2.0
FINISHES = """\
name: two-finishes
sphere: {radius_mm: 5, material: steel-100cr6}
plate: {material: steel-100cr6}
surface: {kind: file, path: ground.csv, spacing_um: 2, height_unit: um, periodic: blend}
rolling: {load_n: 5, speed_m_s: 0.1}
sweep:
  surface.path: [ground.csv, lapped.csv]
dynamics: {}
"""
SHORT_RUNS = """\
name: short-runs
sphere: {radius_mm: 1}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}
surface:
  {kind: gaussian, roughness_ra_um: 0.02, correlation_length_um: 10, spacing_um: 2, width_um: 128,
   seed: 1}
rolling: {load_n: 0.005, speed_m_s: 0.1, duration_s: 0.0005}
sweep: {surface.seed: [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]}
"""
PAIR = ["--set", "sweep=", "--set", "rolling.load_n=20", "--set", "rolling.duration_s=0.1"]
PAIR += ["--set", "sweep.surface.roughness_ra_um=[0.05, 0.2]"]


class Times(NamedTuple):
    """Seconds of a command: to its first sound, its first page and its end, and of processors."""

    first_sound: float
    first_page: float
    end: float
    processor: float


class Task(NamedTuple):
    """A command, how its folder is filled before, and whether it begins without kernels."""

    words: list[str]
    fill: Callable[[Path], None]
    is_cold: bool = True


def nothing(folder: Path) -> None:
    """Leave a folder empty."""


def finishes(folder: Path) -> None:
    """Write two scans of random surfaces as CSV, and the scene that compares them."""
    for name, ra_um, length_um, seed in (("ground", 0.25, 16, 1), ("lapped", 0.1, 30, 2)):
        noise = np.fft.fft2(np.random.default_rng(seed).normal(size=(NODES, NODES)))
        wave_number = 2 * np.pi * np.fft.fftfreq(NODES, SPACING_UM)
        square = np.add.outer(wave_number**2, wave_number**2)
        heights = np.fft.ifft2(noise * np.exp(-square * length_um**2 / 8)).real
        heights -= heights.mean()
        heights *= ra_um / np.abs(heights).mean()
        np.savetxt(folder / f"{name}.csv", heights, fmt="%.4f", delimiter=",")
    (folder / "scene.yaml").write_text(FINISHES)


def short_runs(folder: Path) -> None:
    """Write the scene of ten short runs."""
    (folder / "scene.yaml").write_text(SHORT_RUNS)


TASKS = {
    "quickstart": Task(["run", "quickstart"], nothing),
    "choose": Task(["choose", "quickstart", *PAIR], nothing),
    "choose-csv": Task(["choose", "scene.yaml"], finishes),
    "ten-short-runs": Task(["run", "scene.yaml"], short_runs, is_cold=False),
}


def timed(command: str, task: Task, kernels: Path) -> Times:
    """Run a task by a command, with its compiled kernels in a folder."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        task.fill(folder)
        out = folder / "out"
        began = time.perf_counter()
        process = subprocess.Popen(
            [command, *task.words, "--out", str(out), "-q"],
            cwd=folder,
            env={**os.environ, "NUMBA_CACHE_DIR": str(kernels), "MPLBACKEND": "Agg"},
            stdout=subprocess.DEVNULL,
        )
        seen: dict[str, float] = {}
        while True:
            finished, status, used = os.wait4(process.pid, os.WNOHANG)
            now = time.perf_counter() - began
            for name in ("*.wav", "*.html"):
                if name not in seen and any(out.rglob(name)):
                    seen[name] = now
            if finished:
                break
            time.sleep(0.1)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode:
            raise SystemExit(f"{command} {' '.join(task.words)}: exit code {process.returncode}")
    return Times(
        first_sound=seen.get("*.wav", now),
        first_page=seen.get("*.html", now),
        end=now,
        processor=used.ru_utime + used.ru_stime,
    )


def rounds(commands: list[str], task: Task, count: int) -> list[list[Times]]:
    """Return the times of a task by each command, in turn."""
    times: list[list[Times]] = [[] for _ in commands]
    with tempfile.TemporaryDirectory() as scratch:
        warm = [Path(scratch) / str(number) for number in range(len(commands))]
        if not task.is_cold:
            for command, kernels in zip(commands, warm, strict=True):
                timed(command, task, kernels)
        for number in range(count):
            for which, command in enumerate(commands):
                kernels = warm[which]
                if task.is_cold:
                    kernels = Path(scratch) / f"cold-{number}-{which}"
                times[which].append(timed(command, task, kernels))
    return times


def main() -> None:
    """Time the tasks, and print a row for each of them and each time."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("tasks", nargs="*", choices=[*TASKS, []], metavar="TASK")
    parser.add_argument("--rounds", type=int, default=3)
    chosen = parser.parse_args()
    commands = [str(Path(chosen.old).absolute()), str(Path(chosen.new).absolute())]
    print("|task|seconds|old|new|ratio|\n|---|---|---|---|---|")
    for name in chosen.tasks or TASKS:
        old, new = rounds(commands, TASKS[name], chosen.rounds)
        for field in Times._fields:
            before = statistics.median(getattr(times, field) for times in old)
            after = statistics.median(getattr(times, field) for times in new)
            words = field.replace("_", " ")
            print(f"|{name}|{words}|{before:.1f}|{after:.1f}|{after / before:.2f}|", flush=True)


if __name__ == "__main__":
    main()
