"""A rolling contact as arrays, which every program solves, and the check of all answers.

The module needs numpy only, and shares no code with any solver. Numbers are SI, and arrays are
(along the track, across) on N x N nodes.
"""

from __future__ import annotations

import ctypes
import gc
import json
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, fields
from functools import lru_cache
from pathlib import Path
from time import process_time
from typing import Any, NamedTuple

import numpy as np

# pressure over the highest (or off the hardness, over the hardness) that counts as none
NEGLIGIBLE = 1e-9
TOO_LONG = "took too long"
SOONEST = 0.01  # [s] after which the processor time is asked for again
RESET_PEAK = Path("/proc/self/clear_refs")


class Unsolved(Exception):
    """A solver that gives up, with its reason."""


class Judgement(NamedTuple):
    """The errors of pressures at one position.

    gap_error [m] is the maximum violation of the contact conditions, deflection [m] the maximum
    deflection, and load_error the relative error of the load.
    """

    gap_error: float
    deflection: float
    load_error: float


@dataclass(frozen=True)
class Problem:
    """Contacts at successive positions of a sphere, each on N x N nodes that move along with it.

    Parameters
    ----------
    gaps : (positions, N, N) array, m
        Undeformed gaps.
    moves : (positions,) array of int
        Nodes by which the grid has moved along the plate since the position before.
    spacing, radius : float, m
        Node spacing, and radius of the sphere.
    contact_modulus, hardness : float, Pa
        E*, and the maximum pressure, infinite for an elastic plate.
    load : float, N
    """

    gaps: np.ndarray
    moves: np.ndarray
    spacing: float
    radius: float
    contact_modulus: float
    hardness: float
    load: float

    @classmethod
    def read(cls, path: Path) -> Problem:
        """Read a problem from a file of numpy."""
        with np.load(path) as stored:
            arrays = {name: stored[name] for name in ("gaps", "moves")}
            scalars = {
                field.name: float(stored[field.name])
                for field in fields(cls)
                if field.name not in arrays
            }
        return cls(**arrays, **scalars)

    def write(self, path: Path) -> None:
        """Write the problem to a file of numpy."""
        np.savez(path, **asdict(self))

    @property
    def nodes(self) -> int:
        """Number of nodes on a side of the grid."""
        return self.gaps.shape[1]

    @property
    def width(self) -> float:
        """Side of the grid [m]."""
        return self.nodes * self.spacing

    @property
    def mean_pressure(self) -> float:
        """Load over the area of the grid [Pa]."""
        return self.load / self.width**2

    @property
    def hertz_approach(self) -> float:
        """Approach of a smooth elastic contact [m]."""
        return float((9 * self.load**2 / (16 * self.radius * self.contact_modulus**2)) ** (1 / 3))

    @property
    def hertz_pressure(self) -> float:
        """Maximum pressure of a smooth elastic contact [Pa]."""
        return float(
            (6 * self.load * self.contact_modulus**2 / (np.pi**3 * self.radius**2)) ** (1 / 3)
        )

    def moved_on(self, k: int, pressure: np.ndarray) -> np.ndarray:
        """Return a warm start for position k: pressures of the last one that stay on the plate."""
        return np.roll(pressure, -int(self.moves[k]), axis=0)

    def judge(self, k: int, pressure: np.ndarray) -> Judgement:
        """Return the errors of pressures (N, N) at position k.

        The approach is the mean over the nodes that are neither unloaded nor capped, where the gap
        must be closed. Unloaded nodes must not interpenetrate, and capped nodes must not stand
        apart.
        """
        love = _influence(self.nodes) * (self.spacing / (np.pi * self.contact_modulus))
        double = (2 * self.nodes, 2 * self.nodes)
        bent = np.fft.irfft2(np.fft.rfft2(pressure, s=double) * love, s=double)
        deflection = bent[: self.nodes, : self.nodes]
        unloaded = pressure <= NEGLIGIBLE * pressure.max()
        capped = pressure >= self.hardness * (1 - NEGLIGIBLE)
        between = ~unloaded & ~capped
        open_by = self.gaps[k] + deflection
        if between.any():
            open_by -= open_by[between].mean()
        else:
            open_by -= (open_by[unloaded].min() + open_by[capped].max()) / 2
        wrong = np.where(unloaded, -open_by, np.where(capped, open_by, np.abs(open_by)))
        beyond = max(-pressure.min(), pressure.max() - self.hardness)
        is_possible = beyond <= NEGLIGIBLE * pressure.max()
        return Judgement(
            gap_error=max(float(wrong.max()), 0.0) if is_possible else np.inf,
            deflection=float(deflection.max()),
            load_error=float(pressure.sum() * self.spacing**2 / self.load - 1),
        )


@lru_cache(maxsize=4)
def _influence(nodes: int) -> np.ndarray:
    """Return the transform of Love's coefficients on the doubled grid, for pi E* = spacing = 1."""
    corner = np.arange(-nodes, nodes + 1) - 0.5  # of squares around nodes -N ... N - 1
    s = corner[:, None]
    t = corner[None, :]
    potential = s * np.arcsinh(t / np.abs(s)) + t * np.arcsinh(s / np.abs(t))
    love = np.diff(np.diff(potential, axis=0), axis=1)
    return np.fft.rfft2(np.fft.ifftshift(love))


@dataclass(frozen=True)
class Solved:
    """The performance of a solver over a problem.

    Medians and means leave the first position out. `ms` is the median time of a position; `mean_ms`
    holds the positions at which a program prepares new sizes of its transforms, too. Gap errors [m]
    and errors of the load are of all positions; deflection [m] is the maximum of the last. memory
    [bytes] is what the process takes at most beyond what it had before, and None where the system
    does not tell it.
    """

    tolerance: float
    ms: float
    mean_ms: float
    gap_error: float
    largest_gap_error: float
    last_gap_error: float
    deflection: float
    load_error: float
    convolutions: float | None
    iterations: float | None = None
    memory: int | None = None


@dataclass(frozen=True)
class Failed:
    """A tolerance that a solver does not reach, and why."""

    tolerance: float
    failure: str

    @classmethod
    def because(cls, tolerance: float, error: Exception) -> Failed:
        """Return a failure by the first line of an exception."""
        words = str(error).strip().splitlines() or [""]
        return cls(tolerance, f"{type(error).__name__}: {words[0]}")


class Answers:
    """The answers of a solver at the positions of a problem, one after another."""

    def __init__(self, problem: Problem, tolerance: float) -> None:
        self.problem = problem
        self.tolerance = tolerance
        self.resident = peak_memory(afresh=True)
        self.seconds: list[float] = []
        self.convolutions: list[int] = []
        self.iterations: list[int] = []
        self.pressures: list[np.ndarray] = []

    def solved(self) -> Solved:
        """Judge all positions."""
        memory = None
        if self.resident is not None:
            memory = peak_memory() - self.resident  # before the judge takes some itself
        judgements = [self.problem.judge(k, p) for k, p in enumerate(self.pressures)]
        errors = [judgement.gap_error for judgement in judgements]
        return Solved(
            tolerance=self.tolerance,
            ms=float(1e3 * np.median(self.seconds[1:])),
            mean_ms=float(1e3 * np.mean(self.seconds[1:])),
            gap_error=float(np.median(errors[1:])),
            largest_gap_error=max(errors),
            last_gap_error=errors[-1],
            deflection=judgements[-1].deflection,
            load_error=max(abs(judgement.load_error) for judgement in judgements),
            convolutions=_mean_after_first(self.convolutions),
            iterations=_mean_after_first(self.iterations),
            memory=memory,
        )


def peak_memory(afresh: bool = False) -> int | None:
    """Return the peak resident bytes of this process, or None where the system is not Linux.

    The peak is that since the start of the process, or since the last call `afresh`. The number of
    getrusage would begin with the bytes of the parent process.
    """
    if not RESET_PEAK.exists():
        return None
    if afresh:
        # what is free but still resident would hide what is taken from now on
        gc.collect()
        ctypes.CDLL(None).malloc_trim(0)
        RESET_PEAK.write_text("5")
    status = Path("/proc/self/status").read_text().split()
    return 1024 * int(status[status.index("VmHWM:") + 1])


def _mean_after_first(counts: Sequence[int]) -> float | None:
    """Return the mean of counts but the first, or None where nothing was counted."""
    return float(np.mean(counts[1:])) if counts else None


# ---- the side of the public solvers

# From a gap and a first pressure, or None, to pressure and number of convolutions, if it is known.
Solve = Callable[[np.ndarray, "np.ndarray | None"], "tuple[np.ndarray, int | None]"]


def roll(problem: Problem, tolerance: float, solve: Solve) -> Solved:
    """Solve all positions of a problem, each from the pressures of the last one."""
    answers = Answers(problem, tolerance)
    start = None
    for k, gap in enumerate(problem.gaps):
        if k:
            start = problem.moved_on(k, answers.pressures[-1])
        began = process_time()
        pressure, convolutions = solve(gap, start)
        answers.seconds.append(process_time() - began)
        if convolutions is not None:
            answers.convolutions.append(convolutions)
        answers.pressures.append(np.array(pressure).reshape(gap.shape))
    return answers.solved()


def curve(
    problem: Problem,
    tolerances: Sequence[float],
    seconds: float,
    solver: Callable[[Problem, float], Solve],
) -> list[Solved | Failed]:
    """Solve a problem at tolerances from loose to tight, and give up after these seconds."""
    points: list[Solved | Failed] = []
    end = process_time() + seconds
    for tolerance in tolerances:
        try:
            with at_most(end - process_time()):
                points.append(roll(problem, tolerance, solver(problem, tolerance)))
        except Exception as error:  # whatever a solver raises, the others go on
            points.append(Failed.because(tolerance, error))
    return points


@contextmanager
def at_most(seconds: float) -> Iterator[None]:
    """Raise Unsolved in this context after these seconds of processor time.

    A timer of the wall clock asks for the processor time, because a timer of the processor time
    would let that clock tick in steps of 4 ms.
    """
    end = process_time() + seconds

    def give_up(signal_number: int, frame: object) -> None:
        left = end - process_time()
        if left <= 0:
            raise Unsolved(TOO_LONG)
        signal.setitimer(signal.ITIMER_REAL, max(left, SOONEST))

    if seconds <= 0:
        raise Unsolved(TOO_LONG)
    signal.signal(signal.SIGALRM, give_up)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        # A signal that is on its way would otherwise give up whatever comes next.
        signal.signal(signal.SIGALRM, signal.SIG_IGN)
        signal.setitimer(signal.ITIMER_REAL, 0)


def answer(solver: Callable[[Problem, float], Solve]) -> None:
    """Write the curves of a solver over the problems of the command line.

    The command line has the file of answers, the seconds for a problem, the tolerances with commas
    between them, and the files of the problems.
    """
    out, seconds, tolerances, *files = sys.argv[1:]
    steps = [float(tolerance) for tolerance in tolerances.split(",")]
    curves: dict[str, list[dict[str, Any]]] = {}
    for file in files:
        points = curve(Problem.read(Path(file)), steps, float(seconds), solver)
        curves[Path(file).stem] = [asdict(point) for point in points]
    Path(out).write_text(json.dumps(curves))
