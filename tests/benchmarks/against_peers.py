"""March and public solvers over the same problems, judged by the same check."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent / "peers"))
import sequences
from problem import Answers, Failed, Problem, Solved, peak_memory
from sequences import SEQUENCES, SPACING, N

from rolling.contact.half_space import HalfSpace
from rolling.contact.march import march
from rolling.contact.solver import ContactError
from rolling.contact.state import ContactState, RollingContact, Window

__all__ = ["SEQUENCES", "Failed", "Problem", "Solved", "peak_memory", "sequences"]

PEERS = Path(__file__).parent / "peers"
TOLERANCES = (1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7, 1e-7)
UNLIMITED = 1e9  # [s]


def sequence_track(name: str, tolerance: float) -> RollingContact:
    """Return a sequence as a track: the same gaps, seen from the plate."""
    return RollingContact(
        heights=sequences.heights(name),
        spacing=SPACING,
        radius=sequences.RADIUS,
        contact_modulus=sequences.CONTACT_MODULUS,
        hardness=SEQUENCES[name].hardness,
        load=SEQUENCES[name].load,
        step=SPACING,
        start=N // 2 * SPACING,
        tolerance=tolerance,
        blended=False,
    )


def on_full_grid(state: ContactState) -> np.ndarray:
    """Return the pressure of a state on the N x N grid that moves with the sphere."""
    return state.window.moved(state.pressure, Window(state.position, 0, N, N))


@dataclass(frozen=True)
class SharedProblem:
    """A problem, and the march that solves it here.

    track : RollingContact. The same gaps, seen from the plate.
    first : int. First position of the march.
    windows : tuple of Window. The grid of the problem on the plate, at each position.
    problem : Problem.
    """

    track: RollingContact
    first: int
    windows: tuple[Window, ...]
    problem: Problem


def sequence_problem(name: str, steps: int) -> SharedProblem:
    """Return a sequence of so many steps."""
    windows = tuple(Window(k, 0, N, N) for k in range(steps + 1))
    track = sequence_track(name, TOLERANCES[0])
    return SharedProblem(track, 0, windows, sequences.problem(name, steps))


def marched(shared: SharedProblem, tolerance: float) -> Solved:
    """March over the positions of a problem, and judge the pressures."""
    track = replace(shared.track, tolerance=tolerance)
    answers = Answers(shared.problem, tolerance)
    half_space = HalfSpace(track.spacing, track.contact_modulus)
    last = shared.first + len(shared.windows) - 1
    clock = [time.process_time()]
    states = []
    for state in march(track, shared.first, last, half_space):
        clock.append(time.process_time())
        states.append(state)
    answers.seconds.extend(np.diff(clock))
    for state, window in zip(states, shared.windows, strict=True):
        answers.convolutions.append(state.convolutions)
        answers.iterations.append(state.iterations)
        answers.pressures.append(state.window.moved(state.pressure, window))
    return answers.solved()


def our_curve(shared: SharedProblem, tolerances: Sequence[float]) -> list[Solved | Failed]:
    """March over a problem at several tolerances."""
    points: list[Solved | Failed] = []
    for tolerance in tolerances:
        try:
            points.append(marched(shared, tolerance))
        except ContactError as error:
            points.append(Failed.because(tolerance, error))
    return points


def ours(name: str, tolerance: float, steps: int) -> Solved:
    """March over a sequence."""
    return marched(sequence_problem(name, steps), tolerance)


def loosest(name: str, gap_error: float, steps: int) -> float:
    """Return the loosest tolerance whose median gap error is at most the allowed error."""
    return next(
        (t for t in TOLERANCES if ours(name, t, steps).gap_error <= gap_error), TOLERANCES[-1]
    )


def curves_of_peer(
    peer: str,
    python: str,
    problems: Mapping[str, Problem],
    tolerances: Sequence[float],
    seconds: float,
) -> dict[str, list[Solved | Failed]]:
    """Return the answers of a public solver to problems, by their names.

    It has its own interpreter, one thread, and these seconds of processor time for a problem.
    """
    # it leads to our packages
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "answers.json"
        files = []
        for number, problem in enumerate(problems.values()):
            files.append(Path(folder) / f"{number}.npz")
            problem.write(files[-1])
        told = ",".join(f"{tolerance:g}" for tolerance in tolerances)
        command = [python, PEERS / f"{peer}_solver.py", out, f"{seconds:g}", told, *files]
        subprocess.run(command, check=True, env=environment, stdout=sys.stderr)
        stored = json.loads(out.read_text())
    curves = zip(problems, stored.values(), strict=True)
    return {name: [_point(point) for point in points] for name, points in curves}


def _point(stored: Mapping[str, object]) -> Solved | Failed:
    """Return a point of a curve as it is stored."""
    make = Failed if "failure" in stored else Solved
    return make(**stored)  # type: ignore[arg-type]


def theirs(name: str, peer: str, python: str, tolerance: float, steps: int) -> Solved:
    """Return the answer of a public solver to a sequence."""
    problems = {name: sequences.problem(name, steps)}
    (point,) = curves_of_peer(peer, python, problems, [tolerance], UNLIMITED)[name]
    if isinstance(point, Failed):
        raise SystemExit(f"{peer} at tolerance {tolerance:g} of sequence {name}: {point.failure}")
    return point


def quickest(runs: Iterable[Solved]) -> Solved:
    """Return the run that other processes disturbed least."""
    return min(runs, key=lambda run: run.mean_ms)
