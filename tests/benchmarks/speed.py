"""The speed targets, each measured beside a yardstick of the same run: writes speed.json and speed.md, prints the table.

python tests/benchmarks/speed.py [--quick] [--aspher PYTHON] [--slippy PYTHON] [--out FOLDER]    (two minutes; see README.md here)
"""
# ruff: noqa: E402

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

PINS = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
os.environ.update(PINS)  # read when numpy is imported: every solver here has one thread

import numpy as np

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "peers"))
import sequences
from sequences import SEQUENCES, SPACING, N

from rolling import scene_file
from rolling.half_space import HalfSpace
from rolling.march import ContactState, RollingContact, Window, march
from rolling.recovery import step_energy
from rolling.scenario import Scene, expand
from rolling.simulate import STATE_SERIES, STEP_SERIES, Piece, heights, pieces, rolling_contact, simulate

Array = np.ndarray
QUICKSTART = HERE.parent.parent / "scenarios" / "quickstart.yaml"
REFERENCE_TOLERANCE = 1e-8
TOLERANCES = (1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7, 1e-7)
PEERS = {  # sequence: peer, its tolerance, gap error [m] we must keep (None: what the peer reaches), least ratio, aim
    "A": ("aspher", 1e-6, 7e-12, 15.0, 40.0),
    "B": ("slippy", 1e-5, 5e-12, 60.0, 150.0),
    "C": ("slippy", 1e-5, None, 10.0, 30.0),
}


@dataclass
class Row:
    """One measured target: `met` is None where there is no target or nothing was run; numbers go to the JSON only."""

    measure: str
    value: str
    target: str = ""
    met: bool | None = None
    detail: str = ""
    iterations: float | None = None
    convolutions: float | None = None
    numbers: dict[str, Any] = field(default_factory=dict)


# ---- the scene -------------------------------------------------------------------------------------------------------


def scene_20_n(*overrides: str) -> Scene:
    """The quickstart's run under 20 N."""
    runs = expand(scene_file.load(QUICKSTART, overrides))
    return next(scene for values, scene in runs if values["rolling.load_n"] == 20)


def clocked(half_space: HalfSpace) -> HalfSpace:
    """The same half-space, adding up the CPU time spent in its public methods, all of them convolutions, in `.seconds`."""

    def timed(method: Callable) -> Callable:
        def call(*args: Any, **kwargs: Any) -> Any:
            outer, began = half_space.inside, time.process_time()
            half_space.inside = True
            try:
                return method(*args, **kwargs)
            finally:
                half_space.inside = outer
                half_space.seconds += 0.0 if outer else time.process_time() - began

        return call

    half_space.seconds, half_space.inside = 0.0, False
    for name in dir(half_space):
        if not name.startswith("_") and callable(getattr(half_space, name)):
            setattr(half_space, name, timed(getattr(half_space, name)))
    return half_space


@dataclass
class Timed:
    """A march: its states, the release [J], CPU seconds and those within convolutions, of each step."""

    states: list[ContactState]
    release: Array
    seconds: Array
    within: Array


def timed_march(track: RollingContact, steps: int) -> Timed:
    """March and release, as a run does them, step by step; the cold start has no place in seconds."""
    half_space = clocked(HalfSpace(track.spacing, track.contact_modulus))
    states, release, clock = [], [], []
    for state in march(track, 0, steps, half_space):
        if states:
            release.append(step_energy(states[-1], state, half_space).release)
        states.append(state)
        clock.append((time.process_time(), half_space.seconds))
    seconds, within = np.diff(clock, axis=0).T
    return Timed(states, np.array(release), seconds, within)


def bare_convolution(window: Window, track: RollingContact, repeats: int = 5, calls: int = 15) -> float:
    """CPU seconds of one convolution of a full random pressure on a window: the best of several medians."""
    half_space, clock = HalfSpace(track.spacing, track.contact_modulus), time.process_time
    pressure = np.random.default_rng(0).uniform(0, 1e9, (window.rows, window.columns))
    deflection = half_space.deflection(pressure)
    medians = []
    for _ in range(repeats):
        ticks = [clock()]
        for _ in range(calls):
            half_space.deflection(pressure, out=deflection)
            ticks.append(clock())
        medians.append(np.median(np.diff(ticks)))
    return float(min(medians))


def means(states: list[ContactState]) -> dict[str, float]:
    """Iterations and convolutions per step, of warm steps only."""
    return {name: float(np.mean([getattr(s, name) for s in states[1:]])) for name in ("iterations", "convolutions")}


def measure_steps(steps: int) -> list[Row]:
    """Time per step in bare convolutions, share of time outside them, release-signal error at this tolerance."""
    track = rolling_contact(scene_20_n())
    timed_march(track, 5)  # compiles
    run = timed_march(track, steps)
    windows = {(s.window.rows, s.window.columns): s.window for s in run.states[1:]}
    bare = {size: bare_convolution(window, track) for size, window in windows.items()}
    yardstick = np.array([bare[s.window.rows, s.window.columns] for s in run.states[1:]])
    ratio = float(np.median(run.seconds / yardstick))
    outside = 1 - run.within.sum() / run.seconds.sum()
    exact = timed_march(replace(track, tolerance=REFERENCE_TOLERANCE), steps).release
    error = float(20 * np.log10(np.sqrt(np.mean((run.release - exact) ** 2)) / np.std(exact)))
    step, one = 1e3 * np.median(run.seconds), 1e3 * np.median(yardstick)
    numbers = {
        "steps": steps, "tolerance": track.tolerance, "cpu_ms_per_step": step, "cpu_ms_bare_convolution": one,
        "mean_ratio": run.seconds.sum() / yardstick.sum(), "share_outside": outside, "release_error_db": error,
        "windows": sorted(windows),
    }  # fmt: skip
    scene, per_step = f"20 N, tolerance {track.tolerance:g}, {steps} steps", means(run.states)
    return [
        Row("time per step / bare convolution", f"{ratio:.1f}", "<= 12", ratio <= 12,
            f"{scene}; {step:.2f} ms / {one:.3f} ms", **per_step, numbers={"ratio": ratio, **numbers}),
        Row("release-signal error", f"{error:.1f} dB", "<= -40 dB", error <= -40,
            f"same march, against tolerance {REFERENCE_TOLERANCE:g}", **per_step, numbers=numbers),
        Row("share of time outside convolutions", f"{outside:.0%}", "<= 30 %", bool(outside <= 0.3),
            "same march", **per_step, numbers=numbers),
    ]  # fmt: skip


# ---- the peers -------------------------------------------------------------------------------------------------------


@dataclass
class Solved:
    """A solver over a sequence, without the first position: CPU seconds, gap errors [m], convolutions; last load error."""

    tolerance: float
    seconds: Array
    gap_errors: Array
    convolutions: Array
    load_error: float
    iterations: float | None = None

    @classmethod
    def checked(cls, name: str, tolerance: float, seconds, convolutions, pressures, iterations=None) -> Solved:
        errors = [sequences.violation(name, k, p) for k, p in enumerate(pressures)]
        load_error = sequences.load_error(name, pressures[-1])
        return cls(tolerance, seconds[1:], np.array(errors[1:]), convolutions[1:], load_error, iterations)

    def numbers(self) -> dict[str, Any]:
        return {
            "tolerance": self.tolerance, "cpu_ms_per_step": self.ms, "gap_error_m": self.gap_error,
            "last_gap_error_m": float(self.gap_errors[-1]), "last_load_error": self.load_error,
            "convolutions_per_step": float(np.mean(self.convolutions)), "iterations_per_step": self.iterations,
        }  # fmt: skip

    @property
    def ms(self) -> float:
        return float(1e3 * np.median(self.seconds))

    @property
    def gap_error(self) -> float:
        return float(np.median(self.gap_errors))


def sequence_track(name: str, tolerance: float) -> RollingContact:
    """Our march over a sequence: the same gaps, seen from the plate."""
    s, start = SEQUENCES[name], N // 2 * SPACING
    return RollingContact(
        sequences.heights(name), SPACING, sequences.RADIUS, sequences.CONTACT_MODULUS, s.hardness, s.load, SPACING, start,
        tolerance,
    )  # fmt: skip


def on_full_grid(state: ContactState) -> Array:
    """Pressure of a state on the N x N grid of the sequences, which moves with the sphere."""
    return state.window.moved(state.pressure, Window(state.position, 0, N, N))


def ours(name: str, tolerance: float, steps: int) -> Solved:
    track = sequence_track(name, tolerance)
    states, clock = [], [time.process_time()]
    for state in march(track, 0, steps, HalfSpace(track.spacing, track.contact_modulus)):
        clock.append(time.process_time())
        states.append(state)
    counts, pressures = np.array([s.convolutions for s in states]), [on_full_grid(s) for s in states]
    return Solved.checked(name, tolerance, np.diff(clock), counts, pressures, means(states)["iterations"])


def theirs(name: str, peer: str, python: str, tolerance: float, steps: int) -> Solved:
    """A peer's answers, from its own interpreter."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "answers.npz"
        program = HERE / "peers" / f"{peer}_sequence.py"
        command = [python, str(program), name, str(tolerance), str(steps), str(out)]
        subprocess.run(command, check=True, env=_environment(), stdout=sys.stderr)
        answers = np.load(out)
        return Solved.checked(name, tolerance, answers["seconds"], answers["convolutions"], answers["pressures"])


def _environment() -> dict[str, str]:
    """This environment without what leads Python to our packages."""
    return {key: value for key, value in os.environ.items() if key != "PYTHONPATH"} | PINS


def measure_sequence(name: str, python: str | None, steps: int) -> Row:
    """Peer and ours over one sequence; ours at the loosest tolerance whose median gap error is small enough."""
    peer, peer_tolerance, limit, least, aim = PEERS[name]
    measure, target = f"sequence {name}: {peer} / ours", f">= {least:g} (aim {aim:g})"
    other = theirs(name, peer, python, peer_tolerance, steps) if python else None
    most = limit or (other.gap_error if other else 5e-12)
    for tolerance in TOLERANCES:
        own = ours(name, tolerance, steps)
        if own.gap_error <= most:
            break
    own = ours(name, tolerance, steps)  # again: transforms of every window size are there now
    counts = (own.iterations, float(np.mean(own.convolutions)))
    numbers = {"steps": steps, "gap_error_limit_m": most, "ours": own.numbers()}
    detail = f"ours {own.ms:.1f} ms at {own.tolerance:g}, gap error {own.gap_error:.1e} m (limit {most:.1e})"
    if other is None:
        return Row(measure, f"not run: give --{peer} PYTHON", target, None, detail, *counts, numbers)
    ratio = other.ms / own.ms
    met = ratio >= least and own.gap_error <= most
    detail += f"; {peer} {other.ms:.0f} ms at {peer_tolerance:g}, {other.gap_error:.1e} m,"
    detail += f" {np.mean(other.convolutions):.1f} convolutions"
    numbers |= {"ratio": ratio, peer: other.numbers()}
    return Row(measure, f"{ratio:.1f}", target, met, detail, *counts, numbers)


# ---- whole runs, each in a fresh process -----------------------------------------------------------------------------


def peak_memory(reset: bool = False) -> int:
    """Peak resident bytes of this process; getrusage's would include the parent's before the program was loaded."""
    if reset:
        Path("/proc/self/clear_refs").write_text("5")
    status = Path("/proc/self/status").read_text().split()
    return 1024 * int(status[status.index("VmHWM:") + 1])


def whole_run(steps: int, workers: int) -> None:
    """Simulate and keep every piece; one JSON line of wall seconds, start-up of the workers and peak bytes."""
    scene = scene_20_n(f"rolling.duration_s={steps * 2e-6 / 0.1:.10g}")
    heights(scene)
    surface_peak = peak_memory()

    def seconds(todo: list[tuple[int, int]]) -> tuple[float, list[Piece]]:
        kept: list[Piece] = []
        began = time.perf_counter()
        outcome = simulate([scene], [(0, *piece) for piece in todo], workers, lambda _, piece: kept.append(piece))
        if outcome.failures or outcome.interrupted:
            raise SystemExit(f"the run of {steps} steps failed: {outcome}")
        return time.perf_counter() - began, kept

    single = [(0, 1)] * workers
    seconds(single)  # loads what is compiled
    start_up, _ = seconds(single)
    peak_memory(reset=True)
    took, kept = seconds(pieces(steps))
    numbers = {
        "steps": sum(piece.last - piece.first for piece in kept), "seconds": took, "start_up_s": start_up,
        "peak_bytes_march": peak_memory(), "peak_bytes_surface": surface_peak,
        "iterations": float(np.concatenate([p.states["iterations"] for p in kept]).mean()),
        "convolutions": float(np.concatenate([p.states["convolutions"] for p in kept]).mean()),
    }  # fmt: skip
    print(json.dumps(numbers))


def fresh(steps: int, workers: int) -> dict[str, Any]:
    command = [sys.executable, __file__, "--whole-run", str(steps), str(workers)]
    return json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout)


def measure_whole_runs(steps: int) -> list[Row]:
    """Two workers against one, memory of a run ten times as long, computing per second of sound."""
    short, one, two = fresh(max(steps // 10, 200), 1), fresh(steps, 1), fresh(steps, 2)
    speedup = (one["seconds"] - one["start_up_s"]) / (two["seconds"] - two["start_up_s"])
    growth = (one["peak_bytes_march"] - short["peak_bytes_march"]) / (one["steps"] - short["steps"])
    scalars, surface = 8 * len(STEP_SERIES + STATE_SERIES), 8 * 256
    sound = (two["seconds"] - two["start_up_s"]) / steps * 50_000 + two["start_up_s"]
    numbers = {"short": short, "one_worker": one, "two_workers": two, "load_average": os.getloadavg()}
    counts = (two["iterations"], two["convolutions"])
    return [
        Row("two workers / one", f"{speedup:.2f}", ">= 1.8", speedup >= 1.8,
            f"{steps} steps of the 20 N scene, {one['seconds']:.1f} s / {two['seconds']:.1f} s, less start-up"
            f" ({one['start_up_s']:.1f} s, {two['start_up_s']:.1f} s)", *counts, {"speedup": speedup, **numbers}),
        Row(f"memory of a run {steps / short['steps']:g}x as long", f"{growth:.0f} B per step", "", None,
            f"peak {short['peak_bytes_march'] / 1e6:.0f} MB at {short['steps']} steps, {one['peak_bytes_march'] / 1e6:.0f} MB"
            f" at {steps}; the surface is {surface} B per step, the scalars {scalars} B", *counts,
            {"bytes_per_step": growth, "bytes_scalars": scalars, "bytes_surface": surface, **numbers}),
        Row("computing per second of sound", f"{sound:.0f} s", "", None,
            "2 workers, 50,000 steps of the 20 N scene", *counts, {"seconds": sound, **numbers}),
    ]  # fmt: skip


# ---- the report ------------------------------------------------------------------------------------------------------


def table(rows: list[Row]) -> str:
    """Rows as Markdown."""
    lines = ["| measure | value | target | met | iterations | convolutions | detail |", "|---|---|---|---|---|---|---|"]
    for row in rows:
        met = "" if row.met is None else "yes" if row.met else "**no**"
        counts = " | ".join("" if count is None else f"{count:.1f}" for count in (row.iterations, row.convolutions))
        lines.append(f"| {row.measure} | {row.value} | {row.target} | {met} | {counts} | {row.detail} |")
    return "\n".join(lines) + "\n"


def machine() -> dict[str, Any]:
    info = Path("/proc/cpuinfo")
    models = [line.partition(":")[2].strip() for line in info.read_text().splitlines() if line.startswith("model name")]
    return {
        "cpu": models[0] if models else platform.processor(), "cores": os.cpu_count(), "load_average": os.getloadavg(),
        "python": platform.python_version(), "system": platform.system(),
        "versions": {name: version(name) for name in ("numpy", "scipy", "numba", "pyfftw")},
    }  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="fewer steps, under a minute: numbers are rougher")
    parser.add_argument("--aspher", metavar="PYTHON", help="interpreter of the virtual environment that holds aspher")
    parser.add_argument("--slippy", metavar="PYTHON", help="interpreter of the virtual environment that holds slippy")
    parser.add_argument("--out", metavar="FOLDER", type=Path, default=HERE.parent.parent / "outputs" / "benchmarks")
    parser.add_argument("--whole-run", nargs=2, type=int, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.whole_run:
        return whole_run(*given.whole_run)

    report = {"date": datetime.now(UTC).isoformat(timespec="seconds"), "quick": given.quick, "machine": machine()}
    rows: list[Row] = []
    parts: list[tuple[str, Callable[[], list[Row]]]] = [("steps", lambda: measure_steps(40 if given.quick else 200))]
    for name, (peer, *_) in PEERS.items():
        steps, python = 5 if given.quick else 20, getattr(given, peer)
        parts.append((f"sequence {name}", lambda n=name, p=python, s=steps: [measure_sequence(n, p, s)]))
    parts.append(("whole runs", lambda: measure_whole_runs(800 if given.quick else 4000)))
    for i, (name, part) in enumerate(parts, 1):
        print(f"[{i}/{len(parts)}] {name} ...", file=sys.stderr, flush=True)
        rows += part()
    given.out.mkdir(parents=True, exist_ok=True)
    text = json.dumps(report | {"rows": [asdict(row) for row in rows]}, indent=1, default=float)
    (given.out / "speed.json").write_text(text)
    (given.out / "speed.md").write_text(table(rows))
    print(table(rows))
    return None


if __name__ == "__main__":
    main()
