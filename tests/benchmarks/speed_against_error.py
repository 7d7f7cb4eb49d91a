"""Error over processor time of this program and of public solvers, on easy and on hard scenes.

    python tests/benchmarks/speed_against_error.py FOLDER

FOLDER has an environment for each solver: aspher, slippy, tamaas and contactmechanics, as README.md
beside this script makes them. One that is absent keeps its curves with their date. The command
takes some nine minutes of one core a round, in which nothing else should run, and writes
speed_against_error.json beside itself, from which docs/_hooks/pictures.py draws. In each round all
programs solve the same problem in turn, each at many tolerances. Processor time of one thread
counts, and the median of the rounds.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

# Read when numpy is imported, here and in the peers' interpreters: every solver has one thread.
if __name__ == "__main__":
    pinned = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
    os.environ.update(dict.fromkeys(pinned, "1"))

import hard_problems
import numpy as np
from against_peers import (
    Failed,
    SharedProblem,
    Solved,
    curves_of_peer,
    our_curve,
    sequence_problem,
)
from speed import machine

from rolling import __version__

STORED = Path(__file__).with_suffix(".json")
OURS = "this program"
EASY = ("A", "B", "C", "D", "L")
STEPS = 3
ROUNDS = 3
RANDOM = 24  # random hard scenes
OUR_TOLERANCES = (1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7, 1e-7, 3e-8, 1e-8)
SLOW = 1000.0  # [ms] a step, above which one round is enough
EASY_SECONDS = 40.0  # of processor time of a program for all tolerances of a problem
HARD_SECONDS = 3.0
MANY_SECONDS = 1.0
# A scene counts as solved where at all positions the gap error is at most this share of the
# deflection, and the error of the load at most that.
SOLVED_GAP = 1e-5
SOLVED_LOAD = 1e-4

Points = list[Solved | Failed]


@dataclass(frozen=True)
class Peer:
    """A public solver.

    name : str. Name of its environment and of its script.
    package : str. Name of its distribution.
    tolerances : tuple of float. From loose to tight, by its own measure.
    is_elastic : bool. Whether it solves elastic contacts only. Default: False.
    """

    name: str
    package: str
    tolerances: tuple[float, ...]
    is_elastic: bool = False


PEERS = (
    Peer("aspher", "aspher", (1e-4, 1e-5, 1e-6, 1e-7, 1e-8), is_elastic=True),
    Peer("slippy", "slippy", (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)),
    Peer("tamaas", "tamaas", (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)),
    Peer("contactmechanics", "ContactMechanics", (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)),
)


class Contest:
    """Programs that solve the same problems in turn, and their points by program and problem."""

    def __init__(self, pythons: Mapping[str, Path], rounds: int) -> None:
        self.pythons = pythons
        self.rounds = rounds

    def curves(
        self, problems: Mapping[str, SharedProblem], seconds: float, rounds: int | None = None
    ) -> dict[str, dict[str, Points]]:
        """Return the median points of some rounds, or all, by program and problem."""
        found: dict[str, list[dict[str, Points]]] = {}
        for number in range(rounds or self.rounds):
            found.setdefault(OURS, []).append(
                {name: our_curve(shared, OUR_TOLERANCES) for name, shared in problems.items()}
            )
            for peer in PEERS:
                if peer.name in self.pythons:
                    first = found[peer.name][0] if number else {}
                    curves = self._curves_of(peer, problems, seconds, first)
                    found.setdefault(peer.name, []).append(curves)
        return {program: _medians(curves) for program, curves in found.items()}

    def _curves_of(
        self,
        peer: Peer,
        problems: Mapping[str, SharedProblem],
        seconds: float,
        first: Mapping[str, Points],
    ) -> dict[str, Points]:
        """Return the points of a peer in a round; after the first one those that are not slow."""
        groups: dict[tuple[float, ...], dict[str, Any]] = {}
        for name, shared in problems.items():
            if peer.is_elastic and np.isfinite(shared.problem.hardness):
                continue
            tolerances = peer.tolerances
            if name in first:
                tolerances = tuple(
                    point.tolerance
                    for point in first[name]
                    if isinstance(point, Solved) and point.ms < SLOW
                )
            if tolerances:
                groups.setdefault(tolerances, {})[name] = shared.problem
        curves: dict[str, Points] = {}
        for tolerances, group in groups.items():
            python = str(self.pythons[peer.name])
            curves |= curves_of_peer(peer.name, python, group, tolerances, seconds)
        return curves


def _medians(rounds: Sequence[Mapping[str, Points]]) -> dict[str, Points]:
    """Return the points of the first round with the medians of the times of all rounds."""
    medians = {}
    for name, points in rounds[0].items():
        others = [point for curves in rounds for point in curves.get(name, [])]
        medians[name] = [_median_point(point, others) for point in points]
    return medians


def _median_point(point: Solved | Failed, others: Sequence[Solved | Failed]) -> Solved | Failed:
    """Return a point with the median time of the points at its tolerance."""
    if isinstance(point, Failed):
        return point
    times = [
        other.ms
        for other in others
        if isinstance(other, Solved) and other.tolerance == point.tolerance
    ]
    return Solved(**(vars(point) | {"ms": float(np.median(times))}))


# ---- what is stored


def stored_curve(points: Points, is_relative: bool) -> list[list[float]]:
    """Return points as tolerance, ms of a step, gap error, and error of the load.

    The gap error is in m, or relative to the deflection.
    """
    curve = []
    for point in points:
        if isinstance(point, Solved) and np.isfinite(point.gap_error):
            error = point.gap_error / (point.deflection if is_relative else 1.0)
            curve.append([float(f"{x:.3g}") for x in (point.tolerance, point.ms, error)])
            curve[-1].append(float(f"{point.load_error:.1e}"))
    return curve


def solved_ms(points: Points) -> float | None:
    """Return the ms of a step at the fastest tolerance that solves a scene, or None."""
    times = [
        point.ms
        for point in points
        if isinstance(point, Solved)
        and point.largest_gap_error <= SOLVED_GAP * point.deflection
        and point.load_error <= SOLVED_LOAD
    ]
    return float(f"{min(times):.3g}") if times else None


def measure(contest: Contest) -> dict[str, dict[str, Any]]:
    """Return the results of each program: curves of easy and hard scenes, and times of many."""
    results: dict[str, dict[str, Any]] = {
        program: {"easy": {}, "hard": {}, "many": {}} for program in (OURS, *contest.pythons)
    }
    for name in EASY:
        _say(f"sequence {name}")
        problems = {name: sequence_problem(name, STEPS)}
        for program, curves in contest.curves(problems, EASY_SECONDS).items():
            for points in curves.values():
                results[program]["easy"][name] = stored_curve(points, is_relative=False)
    _say("hard scenes")
    drawn = hard_problems.drawn(STEPS)
    for program, curves in contest.curves(drawn, HARD_SECONDS).items():
        for title, points in curves.items():
            results[program]["hard"][title] = stored_curve(points, is_relative=True)
    _say("many hard scenes")
    many = hard_problems.many(RANDOM, STEPS)
    for program, curves in contest.curves(many, MANY_SECONDS, rounds=1).items():
        times = {name: solved_ms(points) for name, points in curves.items()}
        results[program]["many"] = times
    return results


def _say(words: str) -> None:
    print(f"{words} ...", file=sys.stderr, flush=True)


def version_of(python: Path, package: str) -> str:
    """Return the version of a package in an environment."""
    code = f"from importlib.metadata import version; print(version({package!r}))"
    return subprocess.run(
        [python, "-c", code], check=True, capture_output=True, text=True
    ).stdout.strip()


def stored_text(content: Mapping[str, Any]) -> str:
    """Return the content of the file with each curve on a line."""
    text = json.dumps(content, indent=1, ensure_ascii=False)
    points = re.sub(
        r"\[\s+([^\[\]{}]+?)\s+\]", lambda found: f"[{' '.join(found[1].split())}]", text
    )
    return re.sub(r"\],\s+\[", "], [", points) + "\n"


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure all programs, and write the file."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path, help="folder of the environments of the solvers")
    parser.add_argument("--out", type=Path, default=STORED, help="default: %(default)s")
    parser.add_argument("--rounds", type=int, default=ROUNDS, help="default: %(default)s")
    parser.add_argument("--note", default="", help="what the reader has to know of the machine")
    given = parser.parse_args(arguments)
    pythons = {
        peer.name: given.folder / peer.name / "bin" / "python"
        for peer in PEERS
        if (given.folder / peer.name / "bin" / "python").exists()
    }
    versions = {OURS: __version__}
    versions |= {
        peer.name: version_of(pythons[peer.name], peer.package)
        for peer in PEERS
        if peer.name in pythons
    }
    for shared in hard_problems.drawn(1).values():
        our_curve(shared, OUR_TOLERANCES[:1])  # compiles
    results = measure(Contest(pythons, given.rounds))
    content: dict[str, Any] = {"programs": {}}
    if given.out.exists():
        content = json.loads(given.out.read_text(encoding="utf-8"))
    today = datetime.now(UTC).date().isoformat()
    here = machine()
    of_machine = {"cpu": here["cpu"], "cores": here["cores"], "note": given.note}
    for program, result in results.items():
        about = {
            "version": versions[program],
            "date": today,
            "rounds": given.rounds,
            "machine": of_machine,
        }
        content["programs"][program] = about | result
    content["solved"] = {"gap_error": SOLVED_GAP, "load_error": SOLVED_LOAD}
    content["points"] = "tolerance, ms per step, gap error (easy: m; hard: of the deflection), load"
    given.out.write_text(stored_text(content), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
