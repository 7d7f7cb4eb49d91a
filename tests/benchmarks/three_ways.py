"""The same sweep on local processes, as parts, and on a Dask cluster: the same table, at what cost.

python tests/benchmarks/three_ways.py [--runs 200] [--seconds 0.0005] [--load 0.005] [--workers 2]

Parts are done in mixed order, and one of them is killed and done again. Costs are CPU times of all
processes, which a busy machine changes little, and wall times, which it changes much.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "support"))
sys.path.insert(0, str(HERE.parents[1]))
import same_runs  # noqa: E402

from rolling import tables  # noqa: E402
from rolling.commands import scale_study, table  # noqa: E402
from rolling.folders import run_record  # noqa: E402

ROOT = HERE.parents[1]
PARTS = 5
LOST = 2  # the part that is killed
TICK = os.sysconf("SC_CLK_TCK")
SCENE = """\
name: tiny
sphere: {{radius_mm: 1}}
plate: {{youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}}
surface:
  {{kind: gaussian, roughness_ra_um: 0.02, correlation_length_um: 10, spacing_um: 2,
   width_um: 128, seed: 1}}
rolling: {{load_n: {load}, speed_m_s: 0.1, duration_s: {seconds}}}
sweep:
  rolling.load_n: [{load}, {twice}]
  surface.seed: {seeds}
"""


@dataclass
class Cost:
    """Time of a way.

    wall : float, s.
    processes : dict. CPU time [s] by process id, of all processes below this one.
    """

    wall: float = 0.0
    processes: dict[int, float] = field(default_factory=dict)

    @property
    def cpu(self) -> float:
        """CPU time of all processes [s]."""
        return sum(self.processes.values())


class Watch(threading.Thread):
    """Watch of the CPU times of all processes below this one, until it is left."""

    def __init__(self) -> None:
        super().__init__(daemon=True)
        self.cost, self.ended = Cost(), threading.Event()

    def __enter__(self) -> Cost:
        self.began = time.monotonic()
        self.start()
        return self.cost

    def __exit__(self, *_: object) -> None:
        self.ended.set()
        self.join()
        self.cost.wall = time.monotonic() - self.began

    def run(self) -> None:
        own = {os.getpid()}
        while not self.ended.wait(0.05):
            for path in Path("/proc").glob("[0-9]*/stat"):
                with suppress(OSError):
                    words = path.read_text().rpartition(")")[2].split()
                    pid, parent = int(path.parent.name), int(words[1])
                    if parent in own and pid != os.getpid():
                        own.add(pid)
                        self.cost.processes[pid] = (int(words[11]) + int(words[12])) / TICK


def write_scene(folder: Path, runs: int, load: float, seconds: float) -> Path:
    """Write a sweep over two loads and many seeds."""
    path = folder / "tiny.yaml"
    seeds = [*range(1, runs // 2 + 1)]
    path.write_text(SCENE.format(load=load, twice=2 * load, seconds=seconds, seeds=seeds))
    return path


def rolling(*words: object, **more: object) -> subprocess.Popen[bytes]:
    """Start a command of the program."""
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "rolling.cli", *map(str, words), "-q"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    return subprocess.Popen(command, env=environment, **quiet, **more)  # type: ignore[call-overload]


def kill_after_a_run(command: subprocess.Popen[bytes], folder: Path) -> None:
    """Kill a command as soon as a run in the folder is done that was not done before."""
    before = len([*folder.glob("*/summary.json")])
    while command.poll() is None:
        if len([*folder.glob("*/summary.json")]) > before:
            command.send_signal(signal.SIGKILL)
        time.sleep(0.01)
    assert command.wait() == -signal.SIGKILL, "it ended before it was killed"


def do_parts(scene: Path, out: Path, start: Sequence[object]) -> None:
    """Do the parts in mixed order; kill one, and do it again last."""
    order = [*range(1, PARTS + 1)]
    random.Random(1).shuffle(order)
    for part in [*order, LOST]:
        command = rolling("run", scene, "--out", out, "--part", f"{part}/{PARTS}", *start)
        if part == LOST and not (out / "parts" / f"{LOST}-of-{PARTS}").exists():
            kill_after_a_run(command, out)
        else:
            assert command.wait() == 0, f"part {part}"


def compare(folder: Path, ways: Sequence[str]) -> list[str]:
    """Return the differences of the folders from the first of them."""
    for way in ways:
        assert run_record.read(folder / way).state == "done", way
        table.tabulate(folder / way)
    return [
        f"{way}: {fault}"
        for way in ways[1:]
        for fault in same_runs.differences(folder / ways[0], folder / way)
    ]


def measure(folder: Path, scene: Path, workers: int, more: Sequence[str]) -> dict[str, Cost]:
    """Do the sweep in all ways into folders of their names, and measure their costs."""
    costs: dict[str, Cost] = {}
    for way, count in (("one", 1), ("pool", workers)):
        with Watch() as costs[way]:
            command = rolling("run", scene, "--out", folder / way, "--workers", count, *more)
            assert command.wait() == 0
    with Watch() as costs["parts"]:
        do_parts(scene, folder / "parts", ["--workers", 1, *more])
    with Watch() as costs["cluster"], scale_study.loopback(workers) as cluster:
        words = ["--out", folder / "cluster", "--cluster", cluster.address, *more]
        assert rolling("run", scene, *words).wait() == 0
    return costs


def main() -> int:
    """Measure and compare all ways; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--seconds", type=float, default=0.0005, help="25 steps")
    parser.add_argument("--load", type=float, default=0.005, help="load of half of the runs [N]")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--no-pictures", action="store_true")
    given = parser.parse_args()
    more = ["--no-pictures"] if given.no_pictures else []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        scene = write_scene(folder, given.runs, given.load, given.seconds)
        costs = measure(folder, scene, given.workers, more)
        rows = []
        for way, cost in costs.items():
            files = sum(path.is_file() for path in (folder / way).rglob("*"))
            largest = sorted(cost.processes.values(), reverse=True)[: given.workers + 1]
            shares = " ".join(f"{seconds:.1f}" for seconds in largest)
            rows.append((way, f"{cost.cpu:.1f}", shares, f"{cost.wall:.1f}", str(files)))
        head = ("way", "CPU, s", "of its largest processes", "wall, s", "files")
        print(tables.markdown(head, rows))
        faults = compare(folder, [*costs])
    print(f"\n{given.runs} runs: " + ("; ".join(faults) or "the same tables, series and records"))
    return 1 if faults else 0


if __name__ == "__main__":
    raise SystemExit(main())
