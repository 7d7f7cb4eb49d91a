"""The speed targets, each measured beside a yardstick of the same run.

The script writes speed.json and speed.md, and prints the table. It takes five minutes; README.md
defines the rows.

python tests/benchmarks/speed.py [--quick] [--aspher PYTHON] [--slippy PYTHON] [--out FOLDER]
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import time
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

# Read when numpy is imported, here and in the peers' interpreters: every solver has one thread.
if __name__ == "__main__":
    pinned = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
    os.environ.update(dict.fromkeys(pinned, "1"))

import numpy as np
from against_peers import SEQUENCES, loosest, ours, quickest, theirs
from whole_run import scene_20_n

from rolling.contact._transform_kernels import deflect_nodes, nodes_kernel
from rolling.contact.half_space import HalfSpace
from rolling.contact.march import march
from rolling.contact.recovery import step_energy
from rolling.contact.state import ContactState, RollingContact, Window
from rolling.in_si.contact_of_scene import rolling_contact
from rolling.marches.march_variables import STATE_SERIES, STEP_SERIES

HERE = Path(__file__).parent
REFERENCE_TOLERANCE = 1e-8
STEPS_PER_SECOND = 50_000  # of sound: 0.1 m/s over steps of 2 um


@dataclass(frozen=True)
class Rival:
    """The target that a public solver sets on a sequence.

    gap_error [m] is the maximum allowed for the program; None allows the error of the other
    solver.
    """

    sequence: str
    peer: str
    tolerance: float
    gap_error: float | None
    target: float
    aim: float


RIVALS = (
    Rival("A", "aspher", 1e-6, 7e-12, 15, 40),
    Rival("B", "slippy", 1e-5, 5e-12, 60, 150),
    Rival("C", "slippy", 1e-5, None, 10, 30),
)
# Ratios at an equal tolerance, the maximum violation over the maximum deflection. Sequences without
# a number of their own have the last target.
EQUAL_TOLERANCE = 5e-6
EQUAL_TARGETS = {"A": 50.0, "B": 100.0, "D": 40.0}
UNTUNED_TARGET = 30.0


@dataclass
class Row:
    """A line of the table; `met` is None without a target, and numbers go to the JSON only."""

    measure: str
    value: str
    target: str = ""
    met: bool | None = None
    detail: str = ""
    iterations: float | None = None
    convolutions: float | None = None
    numbers: dict[str, Any] = field(default_factory=dict)


# ---- one step


def convolving_seconds(half_space: HalfSpace, states: list[ContactState]) -> np.ndarray:
    """Return the time of the convolutions of each step but the first.

    Compiled code convolves without a clock, so that one convolution on the last window is timed in
    each precision. The check of a solve takes one in double precision, its descents all others: the
    scene of 20 N has too many candidates for direct sums.
    """
    rows, columns = states[-1].window[2:]
    seconds = {}
    for single in (False, True):
        entry = half_space.convolution(rows - 1, columns - 1, single).planned_entry(rows)
        kernel, nothing = nodes_kernel(1, single), np.empty(0)
        block = 0, 0, rows, columns
        nodes = np.empty(0, np.uint32), np.empty(0, np.int64)
        clock = []
        for _ in range(31):
            began = time.perf_counter()
            deflect_nodes(kernel, entry, block, nothing, 1.0, nothing, nodes)
            clock.append(time.perf_counter() - began)
        seconds[single] = np.median(clock)
    counts = np.array([state.convolutions for state in states[1:]])
    return seconds[False] + (counts - 1) * seconds[True]


@dataclass
class Timed:
    """A march with the release [J] of each step, its seconds, and those of its convolutions."""

    states: list[ContactState]
    release: np.ndarray
    seconds: np.ndarray
    convolving: np.ndarray


def timed_march(track: RollingContact, steps: int) -> Timed:
    """March and compute the release as a run does, without the cold start."""
    half_space = HalfSpace(track.spacing, track.contact_modulus)
    states = []
    release = []
    clock = []
    for state in march(track, 0, steps, half_space):
        if states:
            release.append(step_energy(states[-1], state, half_space).release)
        states.append(state)
        clock.append(time.perf_counter())
    convolving = convolving_seconds(half_space, states)
    return Timed(states, np.array(release), np.diff(clock), convolving)


def bare_convolution(
    window: Window, track: RollingContact, repeats: int = 5, calls: int = 15
) -> float:
    """Return the seconds of a convolution of a full random pressure on a window."""
    half_space = HalfSpace(track.spacing, track.contact_modulus)
    pressure = np.random.default_rng(0).uniform(0, 1e9, (window.rows, window.columns))
    half_space.deflection(pressure)  # plans its transforms
    medians = []
    for _ in range(repeats):
        clock = [time.perf_counter()]
        for _ in range(calls):
            half_space.deflection(pressure)
            clock.append(time.perf_counter())
        medians.append(np.median(np.diff(clock)))
    return float(min(medians))


def counts(states: list[ContactState]) -> dict[str, float]:
    """Return iterations and convolutions per step, without the cold start."""
    return {
        name: float(np.mean([getattr(s, name) for s in states[1:]]))
        for name in ("iterations", "convolutions")
    }


def measure_steps(steps: int) -> list[Row]:
    """Measure time per step, error of the release signal, and time outside the convolutions."""
    track = rolling_contact(scene_20_n())
    timed_march(track, 5)  # compiles
    march_20_n = min(
        (timed_march(track, steps) for _ in range(3)), key=lambda one: np.median(one.seconds)
    )
    windows = {(s.window.rows, s.window.columns): s.window for s in march_20_n.states[1:]}
    bare = {size: bare_convolution(window, track) for size, window in windows.items()}
    yardstick = np.array([bare[s.window.rows, s.window.columns] for s in march_20_n.states[1:]])
    ratio = float(np.median(march_20_n.seconds / yardstick))
    outside = float(1 - march_20_n.convolving.sum() / march_20_n.seconds.sum())
    exact = timed_march(replace(track, tolerance=REFERENCE_TOLERANCE), steps).release
    error = float(
        20 * np.log10(np.sqrt(np.mean((march_20_n.release - exact) ** 2)) / np.std(exact))
    )
    step_ms = 1e3 * np.median(march_20_n.seconds)
    bare_ms = 1e3 * np.median(yardstick)
    scene = f"20 N, tolerance {track.tolerance:g}, {steps} steps"
    per_step = counts(march_20_n.states)
    detail = f"{scene}; {step_ms:.2f} ms / {bare_ms:.3f} ms"
    numbers = {
        "ratio": ratio,
        "step_ms": step_ms,
        "bare_convolution_ms": bare_ms,
        "windows": sorted(windows),
    }
    numbers["mean_ratio"] = march_20_n.seconds.sum() / yardstick.sum()
    against = f"{scene}; against tolerance {REFERENCE_TOLERANCE:g}"
    return [
        Row(
            "time per step / bare convolution",
            f"{ratio:.1f}",
            "<= 12",
            ratio <= 12,
            detail,
            **per_step,
            numbers=numbers,
        ),
        Row(
            "release-signal error",
            f"{error:.1f} dB",
            "<= -40 dB",
            error <= -40,
            against,
            numbers={"db": error},
        ),
        Row(
            "time outside convolutions",
            f"{outside:.0%}",
            "<= 30 %",
            outside <= 0.3,
            scene,
            numbers={"share": outside},
        ),
    ]


# ---- the peers


def measure_rival(rival: Rival, python: str | None, steps: int, repeats: int) -> Row:
    """Measure a public solver and the program over a sequence.

    The program uses the loosest tolerance whose median gap error is small enough.
    """
    name = rival.sequence
    peer = rival.peer
    other = None
    if python:
        other = quickest(theirs(name, peer, python, rival.tolerance, steps) for _ in range(repeats))
    most = rival.gap_error or (other.gap_error if other else 5e-12)
    tolerance = loosest(name, most, steps)
    # one more, to plan its transforms
    own = quickest(ours(name, tolerance, steps) for _ in range(repeats + 1))
    detail = (
        f"ours {own.mean_ms:.1f} ms at tolerance {tolerance:g}, "
        f"gap error {own.gap_error:.1e} m (limit {most:.1e} m)"
    )
    row = Row(
        f"sequence {name}: {peer} / ours",
        "",
        f">= {rival.target:g} (aim {rival.aim:g})",
        None,
        detail,
    )
    row.iterations = own.iterations
    row.convolutions = own.convolutions
    row.numbers = {"steps": steps, "gap_error_limit_m": most, "ours": asdict(own)}
    if other is None:
        row.value = f"not run: give --{peer} PYTHON"
        return row
    ratio = other.mean_ms / own.mean_ms
    row.value = f"{ratio:.1f}"
    row.met = ratio >= rival.target and own.gap_error <= most
    row.detail += (
        f"; {peer} {other.mean_ms:.0f} ms at {other.tolerance:g}, gap error {other.gap_error:.1e} m"
    )
    row.detail += f", {other.convolutions:.1f} convolutions"
    row.numbers |= {"ratio": ratio, peer: asdict(other)}
    return row


def measure_equal(name: str, pythons: dict[str, str | None], steps: int, repeats: int) -> Row:
    """Measure a public solver and the program at the same tolerance, in turn.

    aspher solves the elastic sequences, and slippy those with a hardness.
    """
    sequence = SEQUENCES[name]
    peer = "slippy" if np.isfinite(sequence.hardness) else "aspher"
    target = EQUAL_TARGETS.get(name, UNTUNED_TARGET)
    row = Row(f"sequence {name} at {EQUAL_TOLERANCE:g}: {peer} / ours", "", f">= {target:g}")
    python = pythons[peer]
    own_runs = [ours(name, EQUAL_TOLERANCE, steps)]  # plans its transforms
    other_runs = []
    for _ in range(repeats):
        if python:
            other_runs.append(theirs(name, peer, python, EQUAL_TOLERANCE, steps))
        own_runs.append(ours(name, EQUAL_TOLERANCE, steps))
    own = quickest(own_runs)
    row.iterations = own.iterations
    row.convolutions = own.convolutions
    row.detail = f"ours {own.mean_ms:.2f} ms, gap error {own.gap_error:.1e} m"
    row.numbers = {"steps": steps, "ours": asdict(own)}
    if not other_runs:
        row.value = f"not run: give --{peer} PYTHON"
        return row
    other = quickest(other_runs)
    ratio = other.mean_ms / own.mean_ms
    row.value = f"{ratio:.1f}"
    row.met = ratio >= target
    row.detail += f"; {peer} {other.mean_ms:.0f} ms, gap error {other.gap_error:.1e} m"
    row.detail += f", {other.convolutions:.1f} convolutions"
    row.numbers |= {"ratio": ratio, peer: asdict(other)}
    return row


# ---- whole runs


def in_fresh_process(*arguments: object) -> subprocess.Popen:
    command = [sys.executable, HERE / "whole_run.py", *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True)


def answer(process: subprocess.Popen) -> Any:
    out, _ = process.communicate()
    if process.returncode:
        raise SystemExit(f"{' '.join(map(str, process.args))} failed")
    return json.loads(out)


def attainable(seconds: float) -> float:
    """Return the gain of two independent processes in bare convolutions per second."""
    alone = answer(in_fresh_process("convolutions", seconds))
    return sum(map(answer, [in_fresh_process("convolutions", seconds) for _ in range(2)])) / alone


def measure_whole_runs(steps: int) -> list[Row]:
    """Measure two workers against one, memory of a longer run, and time per second of sound."""
    fewer = max(steps // 10, 200)
    short, one, two = (
        answer(in_fresh_process("run", *pair)) for pair in ((fewer, 1), (steps, 1), (steps, 2))
    )
    gain = attainable(2.0)
    # One worker is the process itself, warm by then; two are started for the run, at a cost that
    # does not grow with it.
    speedup = one["seconds"] / (two["seconds"] - two["start_up_s"])
    by_cpu = 2 * one["cpu_s"] / (two["cpu_s"] - two["start_up_cpu_s"])
    met = speedup >= 1.8 if gain >= 1.8 else None
    busy = "" if gain >= 1.8 else ", the machine was too busy"
    growth, of_march = (
        (one[b] - short[b]) / (steps - fewer) for b in ("peak_bytes", "march_bytes")
    )
    scalars = 8 * len(STEP_SERIES + STATE_SERIES)
    surface = 8 * scene_20_n().surface.n_across
    sound = (two["seconds"] - two["start_up_s"]) / steps * STEPS_PER_SECOND + two["start_up_s"]
    per_step = {name: two[name] for name in ("iterations", "convolutions")}
    split = (
        f"{steps} steps of 20 N: {one['seconds']:.1f} s / "
        f"({two['seconds']:.1f} s less start-up {two['start_up_s']:.1f} s)"
    )
    peaks = " and ".join(
        f"{r['peak_bytes'] / 1e6:.0f} MB at {r['steps']} steps" for r in (short, one)
    )
    memory = {"bytes_per_step": growth, "march_bytes_per_step": of_march}
    memory |= {"surface_bytes_per_step": surface, "scalar_bytes_per_step": scalars}
    numbers = {
        "short": short,
        "one_worker": one,
        "two_workers": two,
        "attainable": gain,
        "speedup": speedup,
    }
    numbers["speedup_by_cpu_time"] = by_cpu
    return [
        Row(
            "two workers / one",
            f"{speedup:.2f}",
            ">= 1.8",
            met,
            f"{split}; by CPU time {by_cpu:.2f}; "
            f"two processes of bare convolutions {gain:.2f}{busy}",
            **per_step,
            numbers=numbers,
        ),
        Row(
            f"memory of a run {steps / fewer:g}x as long",
            f"{of_march:.0f} B per step",
            "",
            None,
            f"of the march, scalars are {scalars} B; peak of all {growth:.0f} B per step, heights "
            f"are {surface} B; {peaks}",
            numbers=memory,
        ),
        Row(
            "computing per second of sound",
            f"{sound:.0f} s",
            "",
            None,
            f"2 workers, {STEPS_PER_SECOND:,} steps of 20 N",
            **per_step,
            numbers={"seconds": sound},
        ),
    ]


# ---- the report


def table(rows: list[Row]) -> str:
    """Return the rows as Markdown."""
    lines = [
        "| measure | value | target | met | iterations | convolutions | detail |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        met = ""
        if row.met is not None:
            met = "yes" if row.met else "**no**"
        per_step = " | ".join(
            "" if n is None else f"{n:.1f}" for n in (row.iterations, row.convolutions)
        )
        lines.append(
            f"| {row.measure} | {row.value} | {row.target} | {met} | {per_step} | {row.detail} |"
        )
    return "\n".join(lines) + "\n"


def machine() -> dict[str, Any]:
    info = Path("/proc/cpuinfo").read_text().splitlines() if platform.system() == "Linux" else []
    models = [line.partition(":")[2].strip() for line in info if line.startswith("model name")]
    return {
        "cpu": models[0] if models else platform.processor(),
        "cores": os.cpu_count(),
        "load_average": os.getloadavg(),
        "python": platform.python_version(),
        "versions": {name: version(name) for name in ("numpy", "scipy", "numba", "pyfftw")},
    }


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--quick", action="store_true", help="fewer steps, half a minute: the numbers are rougher"
    )
    for peer in ("aspher", "slippy"):
        parser.add_argument(
            f"--{peer}", metavar="PYTHON", help=f"interpreter of the environment that holds {peer}"
        )
    parser.add_argument(
        "--out", metavar="FOLDER", type=Path, default=HERE.parent.parent / "outputs" / "benchmarks"
    )
    given = parser.parse_args()
    quick = given.quick
    report = {
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "quick": quick,
        "machine": machine(),
    }
    rows: list[Row] = []
    print("one step ...", file=sys.stderr, flush=True)
    rows += measure_steps(40 if quick else 200)
    for rival in RIVALS:
        print(f"sequence {rival.sequence} ...", file=sys.stderr, flush=True)
        rows.append(
            measure_rival(rival, getattr(given, rival.peer), *((5, 1) if quick else (20, 2)))
        )
    pythons = {"aspher": given.aspher, "slippy": given.slippy}
    for name in SEQUENCES:
        print(f"sequence {name} at an equal tolerance ...", file=sys.stderr, flush=True)
        rows.append(measure_equal(name, pythons, *((5, 1) if quick else (20, 2))))
    print("whole runs ...", file=sys.stderr, flush=True)
    rows += measure_whole_runs(400 if quick else 4000)
    report["rows"] = [asdict(row) for row in rows]
    given.out.mkdir(parents=True, exist_ok=True)
    (given.out / "speed.json").write_text(json.dumps(report, indent=1, default=float) + "\n")
    (given.out / "speed.md").write_text(table(rows))
    print(table(rows), end="")


if __name__ == "__main__":
    main()
