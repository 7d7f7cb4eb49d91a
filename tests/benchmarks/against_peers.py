"""March and public solvers over the same sequences, judged by the same check, for speed.py."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parent / "peers"))
import sequences
from sequences import SEQUENCES, SPACING, N

from rolling.contact.half_space import HalfSpace
from rolling.contact.march import march
from rolling.contact.state import ContactState, RollingContact, Window

PEERS = Path(__file__).parent / "peers"
TOLERANCES = (1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7, 1e-7)


@dataclass(frozen=True)
class Solved:
    """The performance of a solver over a sequence.

    Medians and means leave the first position out. Gap errors [m] are of all positions, and the
    load error is of the last.
    """

    tolerance: float
    ms: float
    gap_error: float
    largest_gap_error: float
    last_gap_error: float
    last_load_error: float
    convolutions: float
    iterations: float | None = None


def judged(name: str, tolerance: float, answers: dict[str, Any]) -> Solved:
    """Check the answers of every position.

    They are `seconds` (CPU), `convolutions`, `pressures` (N, N) and perhaps `iterations`.
    """
    errors = [
        sequences.violation(name, k, pressure) for k, pressure in enumerate(answers["pressures"])
    ]
    return Solved(
        tolerance,
        ms=float(1e3 * np.median(answers["seconds"][1:])),
        gap_error=float(np.median(errors[1:])),
        largest_gap_error=max(errors),
        last_gap_error=errors[-1],
        last_load_error=sequences.load_error(name, answers["pressures"][-1]),
        convolutions=float(np.mean(answers["convolutions"][1:])),
        iterations=float(np.mean(answers["iterations"][1:])) if "iterations" in answers else None,
    )


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


def ours(name: str, tolerance: float, steps: int) -> Solved:
    track = sequence_track(name, tolerance)
    states = []
    clock = [time.process_time()]
    for state in march(track, 0, steps, HalfSpace(track.spacing, track.contact_modulus)):
        clock.append(time.process_time())
        states.append(state)
    answers = {
        name: [getattr(state, name) for state in states] for name in ("iterations", "convolutions")
    }
    answers |= {"seconds": np.diff(clock), "pressures": [on_full_grid(state) for state in states]}
    return judged(name, tolerance, answers)


def loosest(name: str, gap_error: float, steps: int) -> float:
    """Return the loosest tolerance whose median gap error is at most the allowed error."""
    return next(
        (t for t in TOLERANCES if ours(name, t, steps).gap_error <= gap_error), TOLERANCES[-1]
    )


def theirs(name: str, peer: str, python: str, tolerance: float, steps: int) -> Solved:
    """Return the answers of a public solver from its own interpreter, with one thread."""
    # it leads to our packages
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "answers.npz"
        command = [python, PEERS / f"{peer}_sequence.py", name, str(tolerance), str(steps), out]
        subprocess.run(command, check=True, env=environment, stdout=sys.stderr)
        with np.load(out) as answers:
            return judged(name, tolerance, dict(answers))


def quickest(runs: Iterable[Solved]) -> Solved:
    """Return the run that other processes disturbed least."""
    return min(runs, key=lambda run: run.ms)
