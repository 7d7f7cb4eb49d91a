"""The counts of benchmarks/speed.py, its check and its table do not depend on the machine."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
from against_peers import marched, on_full_grid, ours, sequence_track, sequences
from hard_cases.named_cases import CASES
from hard_problems import hard_problem
from helpers import roll
from problem import Failed, Problem, Solve, Solved, curve
from speed import RIVALS, counts, measure_rival, table, timed_march
from whole_run import scene_20_n

from rolling.contact.half_space import HalfSpace
from rolling.contact.single_contact import solve_contact
from rolling.contact.state import Window
from rolling.in_si.contact_of_scene import rolling_contact

GUARDS = {  # most iterations and convolutions per step: what was measured and 15 %
    "scene": (2.8, 4.1),
    "scene, whole cells": (2.6, 3.7),
    "A": (3.9, 5.1),
    "B": (4.2, 5.5),
    "C": (5.5, 6.7),
}
TOLERANCES = {"A": 1e-5, "B": 1e-5, "C": 1e-6}  # at which speed.py compares us with the peers


def assert_guarded(name: str, iterations: float, convolutions: float) -> None:
    most_iterations, most_convolutions = GUARDS[name]
    assert iterations <= most_iterations and convolutions <= most_convolutions, (
        name,
        iterations,
        convolutions,
    )


@pytest.mark.slow
def test_counts_of_the_scene() -> None:
    march = timed_march(rolling_contact(scene_20_n()), 30)
    assert_guarded("scene", **counts(march.states))
    assert (march.convolving > 0).all() and (march.convolving < march.seconds).all()


def test_counts_of_the_scene_on_whole_cells() -> None:
    contact = replace(rolling_contact(scene_20_n()), blended=False)
    assert_guarded("scene, whole cells", **counts(timed_march(contact, 30).states))


@pytest.mark.parametrize(
    ("load", "elastic", "most"), [(5, False, 4.0), (100, False, 3.6), (20, True, 3.8)]
)
def test_convolutions_at_other_loads(load: float, elastic: bool, most: float) -> None:
    """The counts on whole cells at tolerance 1e-4 stay within 18 % of their measured values."""
    contact = replace(rolling_contact(scene_20_n()), load=load, blended=False)
    if elastic:
        contact = replace(contact, hardness=np.inf)
    states = roll(contact, 700, 715)[2:]
    assert np.mean([state.convolutions for state in states]) <= most


@pytest.mark.parametrize("name", sorted(TOLERANCES))
def test_counts_of_the_sequences(name: str) -> None:
    got = ours(name, TOLERANCES[name], 5)
    assert got.iterations is not None
    assert_guarded(name, got.iterations, got.convolutions)
    assert got.load_error < 1e-12


def test_peers_are_given_the_gaps_we_solve() -> None:
    track = sequence_track("C", 1e-6)
    k = 3
    on_plate = track.gap(k, Window(k, 0, sequences.N, sequences.N))
    given = sequences.problem("C", k).gaps[k]
    assert np.abs(on_plate - given).max() < 1e-18  # of gaps up to 26 um


def test_peers_are_given_the_gaps_of_hard_scenes() -> None:
    """Solving the stored arrays afresh finds the pressures that the march found on the plate."""
    case = next(case for case in CASES if case.name == "cliff along, elastic")
    shared = hard_problem(case.build(), case.first, 2)
    solved = marched(shared, 1e-8)
    assert solved.largest_gap_error < 1e-7 * solved.deflection
    problem = shared.problem
    half_space = HalfSpace(problem.spacing, problem.contact_modulus)
    contact = solve_contact(half_space, problem.gaps[2], problem.load, tolerance=1e-8)
    judged = problem.judge(2, contact.pressure)
    assert judged.gap_error < 1e-7 * judged.deflection
    assert judged.deflection == pytest.approx(solved.deflection, rel=1e-6)


@pytest.mark.parametrize("name", ["A", "B"])
def test_check_sees_a_wrong_pressure(name: str) -> None:
    """The right pressure has the error that the solver states, and wrong pressures far more."""
    k = 1
    tolerance = 1e-6
    state = roll(sequence_track(name, tolerance), 0, k)[k]
    right = on_full_grid(state)
    problem = sequences.problem(name, k)
    error = problem.judge(k, right).gap_error
    assert error < 2 * tolerance * state.deflection.max()
    # One node aside, one too far along, 0.1 % too much everywhere (in B above the hardness), a
    # loaded node forgotten, tension.
    forgotten = right.copy()
    pulled = right.copy()
    forgotten[np.unravel_index(right.argmax(), right.shape)] = 0.0
    pulled[0, 0] = -1e-3 * right.max()
    wrong = [np.roll(right, 1, axis=1), np.roll(right, 1, axis=0), 1.001 * right, forgotten, pulled]
    assert all(problem.judge(k, pressure).gap_error > 20 * error for pressure in wrong)
    assert problem.judge(k, 1.001 * right).load_error == pytest.approx(1e-3, rel=1e-6)


def test_a_solver_that_hangs_or_breaks_leaves_its_other_points() -> None:
    """A curve has the tolerances that are reached, and says why the others are not."""
    problem = sequences.problem("A", 1)
    right = [on_full_grid(state) for state in roll(sequence_track("A", 1e-5), 0, 1)]

    def solver(problem: Problem, tolerance: float) -> Solve:
        answers = iter(right)

        def solve(gap: np.ndarray, start: np.ndarray | None) -> tuple[np.ndarray, None]:
            if tolerance < 1e-4:
                raise ValueError("stalled\nfor ever")
            while tolerance < 1e-3:
                math.factorial(500)
            return next(answers), None

        return solve

    solved, stalled, hung = curve(problem, [1e-3, 1e-5, 1e-4], 1.5, solver)
    assert isinstance(solved, Solved) and solved.gap_error < 2e-5 * solved.deflection
    assert stalled == Failed(1e-5, "ValueError: stalled")
    assert hung == Failed(1e-4, "Unsolved: took too long")


def test_table_says_which_peer_is_absent() -> None:
    rows = [measure_rival(rival, None, 1, 1) for rival in RIVALS[:2]]
    lines = table(rows).splitlines()
    assert len(lines) == 2 + len(rows) and len({line.count("|") for line in lines}) == 1
    for rival, row, line in zip(RIVALS, rows, lines[2:], strict=False):
        assert row.met is None and row.numbers["ours"]["gap_error"] <= rival.gap_error
        assert line.startswith(
            f"| sequence {rival.sequence}: {rival.peer} / ours | not run: give --{rival.peer} "
            f"PYTHON |"
        )
