"""One sweep on one process, on two, as parts and on a Dask cluster, and many cores simulated.

`python tests/benchmarks/scale_study.py [--runs 200]` checks that all ways write the same results,
prints their CPU times and wall times, and simulates thousands of cores from the measured overheads.
One of the parts is killed and done again.
"""

from __future__ import annotations

import argparse
import hashlib
import heapq
import os
import random
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pandas as pd

SCENE = """\
name: tiny
sphere: {{radius_mm: 1}}
plate: {{youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}}
surface:
  {{kind: gaussian, roughness_ra_um: 0.02, correlation_length_um: 10, spacing_um: 2,
   width_um: 128, seed: 1}}
rolling: {{load_n: 0.005, speed_m_s: 0.1, duration_s: 0.0005}}
sweep: {{surface.seed: {seeds}}}
"""
PARTS, LOST = 5, 2  # parts of the sweep, and the part that is killed
CORES = (1, 16, 1000)
STEP_S, SCENE_S, STEPS_PER_S = 2e-3, 0.5, 50_000  # quickstart at 5 N: a step, sound, steps of 2 um
SCENES = 10_000


def rolling(*words: object) -> subprocess.Popen[bytes]:
    """Start a command of the program."""
    command = [sys.executable, "-m", "rolling", "--quiet", *map(str, words)]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL)


def run(scene: Path, out: Path, *words: object) -> None:
    """Run the sweep into a folder.

    Raises
    ------
    CalledProcessError : the command fails.
    """
    process = rolling("run", scene, "--out", out, *words)
    if code := process.wait():
        raise subprocess.CalledProcessError(code, process.args)


def run_parts(scene: Path, out: Path) -> None:
    """Run the parts of the sweep in mixed order; one is killed and run again."""
    lost = rolling("run", scene, "--out", out, "--workers", 1, "--part", f"{LOST}/{PARTS}")
    time.sleep(3.0)
    lost.kill()
    lost.wait()
    for part in random.Random(1).sample(range(1, PARTS + 1), PARTS):
        run(scene, out, "--workers", 1, "--part", f"{part}/{PARTS}")


@contextmanager
def cluster(workers: int) -> Iterator[Path]:
    """Start a Dask scheduler and workers on loopback, and yield the scheduler file."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scheduler.json"
        common = ["--host", "127.0.0.1", "--no-dashboard", "--scheduler-file", str(file)]
        own = ["--nthreads", "1", "--no-nanny", "--local-directory", folder]
        module = [sys.executable, "-m"]
        commands = [[*module, "distributed.cli.dask_scheduler", *common, "--port", "0"]]
        commands += [[*module, "distributed.cli.dask_worker", *common, *own]] * workers
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        processes = [subprocess.Popen(command, **quiet) for command in commands]
        try:
            while not file.exists():
                time.sleep(0.2)
            yield file
        finally:
            for process in reversed(processes):
                process.terminate()
                process.wait()


def run_on_cluster(scene: Path, out: Path, workers: int = 2) -> None:
    """Run the sweep on a cluster of this machine."""
    with cluster(workers) as scheduler:
        run(scene, out, "--cluster", scheduler)


def digests(folder: Path) -> dict[str, str]:
    """Return the digest of each result in a folder."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in folder.rglob("result.h5")
    }


def measured(way: Callable[[Path], object], out: Path) -> dict[str, float]:
    """Return CPU and wall time [s] of a way, and the number of files that it leaves."""
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    way(out)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    files = sum(path.is_file() for path in out.rglob("*"))
    return {"CPU s": cpu, "wall s": time.monotonic() - began, "files": files}


def forecast(times: Sequence[float], cores: int, dispatch: float) -> float:
    """Simulate tasks that one process hands out, the longest first; return the time of all [s].

    times : sequence of float, s. Times of the tasks.
    dispatch : float, s. Time of the handing process per task, in which it does nothing else.
    """
    free, handed = [0.0] * cores, 0.0
    for seconds in sorted(times, reverse=True):
        begin = max(heapq.heappop(free), handed)
        handed = begin + dispatch
        heapq.heappush(free, handed + seconds)
    return max(free)


def simulated(run_s: float, dispatch: dict[str, float]) -> pd.DataFrame:
    """Simulate many scenes on each number of cores.

    run_s : float, s. Time of a run besides its steps.
    dispatch : dict. Time of the handing process per run [s] by way.
    """
    spread = np.random.default_rng(1).lognormal(0.0, 0.5, SCENES)
    times = STEP_S * SCENE_S * STEPS_PER_S * spread / spread.mean() + run_s
    rows = []
    for way, seconds in dispatch.items():
        for cores in CORES:
            total = forecast(times.tolist(), cores, seconds)
            share = times.sum() / (cores * total)
            rows.append({"way": way, "cores": cores, "hours": total / 3600, "efficiency": share})
    return pd.DataFrame(rows)


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure all ways, print the tables, and return 1 if their results differ."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=200)
    given = parser.parse_args(arguments)
    os.environ["OMP_NUM_THREADS"] = "1"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        scene, first = folder / "tiny.yaml", folder / "first.yaml"
        scene.write_text(SCENE.format(seeds=list(range(1, given.runs + 1))))
        first.write_text(SCENE.format(seeds=[1]))
        ways: dict[str, Callable[[Path], None]] = {
            "one process": lambda out: run(scene, out, "--workers", 1),
            "two workers": lambda out: run(scene, out, "--workers", 2),
            f"{PARTS} parts, one killed": lambda out: run_parts(scene, out),
            "Dask, two workers": lambda out: run_on_cluster(scene, out),
            "one run": lambda out: run(first, out, "--workers", 1),
        }
        costs = {way: measured(act, folder / way) for way, act in ways.items()}
        results = {way: digests(folder / way) for way in ways if way != "one run"}
    table = pd.DataFrame.from_dict(costs, orient="index")
    print(table.to_string(float_format="{:.1f}".format), end="\n\n")
    seconds = table["CPU s"]
    run_s = (seconds["one process"] - seconds["one run"]) / (given.runs - 1)
    dispatch = {
        way: max(0.0, seconds[name] - seconds["one process"]) / given.runs
        for way, name in (("local", "two workers"), ("Dask", "Dask, two workers"))
    }
    print(f"a run besides long marches: {run_s * 1e3:.0f} ms of CPU")
    print(simulated(run_s, dispatch).to_string(index=False, float_format="{:.2f}".format))
    same = all(found == results["one process"] for found in results.values())
    print(f"results of all ways: {'the same bytes' if same else 'DIFFERENT'}")
    return int(not same or len(results["one process"]) != given.runs)


if __name__ == "__main__":
    sys.exit(main())
