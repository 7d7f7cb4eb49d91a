"""One sweep on one process, on two, as parts and on a Dask cluster.

`python tests/benchmarks/scale_study.py [--runs 200]` checks that all ways write the same results
and prints their times and files. Each way does a quarter of the runs first, so the time of a
further run holds no start of a process. One of the parts is killed and done again.
"""

from __future__ import annotations

import argparse
import hashlib
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
PARTS = 5  # of the sweep
LOST = 2  # number of the part that is killed


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
    process = rolling("run", scene, "--out", out, "--no-report", *words)
    if code := process.wait():
        raise subprocess.CalledProcessError(code, process.args)


def run_parts(scene: Path, out: Path) -> None:
    """Run the parts of the sweep in mixed order; one is killed and run again."""
    part = ("--workers", 1, "--part", f"{LOST}/{PARTS}")
    lost = rolling("run", scene, "--out", out, "--no-report", *part)
    time.sleep(3.0)
    lost.kill()
    lost.wait()
    for number in random.Random(1).sample(range(1, PARTS + 1), PARTS):
        run(scene, out, "--workers", 1, "--part", f"{number}/{PARTS}")


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


def _measured(way: Callable[[Path, Path], None], folder: Path, runs: int) -> dict[str, float]:
    """Return CPU and wall time [s] of so many runs in a way, and the number of their files."""
    folder.mkdir(exist_ok=True)
    scene = folder / f"{runs}.yaml"
    out = folder / str(runs)
    scene.write_text(SCENE.format(seeds=list(range(1, runs + 1))))
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    began = time.monotonic()
    way(scene, out)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    files = sum(path.is_file() for path in out.rglob("*"))
    return {"CPU s": cpu, "wall s": time.monotonic() - began, "files": files}


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure all ways, print their table, and return 1 if their results differ."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=200)
    runs = parser.parse_args(arguments).runs
    os.environ["OMP_NUM_THREADS"] = "1"
    ways: dict[str, Callable[[Path, Path], None]] = {
        "one process": lambda scene, out: run(scene, out, "--workers", 1),
        "two workers": lambda scene, out: run(scene, out, "--workers", 2),
        f"{PARTS} parts, one killed": run_parts,
        "Dask, two workers": run_on_cluster,
    }
    with tempfile.TemporaryDirectory() as name:
        costs: dict[str, dict[str, float]] = {}
        results: list[dict[str, str]] = []
        for way, act in ways.items():
            few, all_ = (_measured(act, Path(name) / way, count) for count in (runs // 4, runs))
            further = (all_["CPU s"] - few["CPU s"]) / (runs - runs // 4)
            costs[way] = all_ | {"CPU ms per further run": 1e3 * further}
            results.append(digests(Path(name) / way / str(runs)))
    print(pd.DataFrame.from_dict(costs, orient="index").to_string(float_format="{:.1f}".format))
    same = all(result == results[0] for result in results) and len(results[0]) == runs
    print("results of all ways:", "the same bytes" if same else "DIFFERENT")
    return int(not same)


if __name__ == "__main__":
    sys.exit(main())
