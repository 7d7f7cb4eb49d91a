"""Scenes solved on all cores in memory, the longest scenes first, with a progress bar."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rolling.check import cost
from rolling.scene.scene import Scene
from rolling.simulation import simulate
from rolling.simulation.pool import Outcome
from rolling.simulation.result import Result
from rolling.terminal import progress as terminal


def _ignore(run: int) -> None:
    """Do nothing with the number of a run."""


def solve(
    scenes: Sequence[Scene],
    results: Sequence[Result],
    workers: int,
    name: str,
    mapped: bool = True,
    progress: bool | None = None,
    begun: Callable[[int], object] = _ignore,
    added: Callable[[int], object] = _ignore,
) -> Outcome:
    """Solve the missing steps of runs and add them to their results.

    Parameters
    ----------
    scenes : sequence of Scene. Scenes without a sweep, one per run.
    results : sequence of Result. Their solved steps are not solved again.
    workers : int. Number of processes; 0: one per core.
    name : str. Name of the progress bar.
    mapped : bool. Whether pressure maps along the tracks are kept, some megabytes per run.
        Default: true.
    progress : bool. Whether a progress bar is shown. Default: on a terminal and in a notebook.
    begun : callable. It receives the number of a run when one of its pieces is handed to a process.
    added : callable. It receives the number of a run after each piece is added to its result.
    """
    missing = [
        [*simulate.missing(result.solved_steps, result.series["release_energy"])]
        for result in results
    ]
    step_seconds = [
        cost.expected_seconds(scene) / result.solved_steps
        for scene, result in zip(scenes, results, strict=True)
    ]
    # The longest runs come first, so that no core works alone on a long run at the end.
    order = sorted((k for k in range(len(scenes)) if missing[k]), key=lambda k: -step_seconds[k])
    todo = [(k, first, last) for k in order for first, last in missing[k]]
    orders = [
        simulate.Order(seconds, mapped, result.identity.heights_sha256 if result.identity else None)
        for seconds, result in zip(step_seconds, results, strict=True)
    ]
    total = sum((last - first) * step_seconds[k] for k, first, last in todo)

    def finished(number: int, piece: simulate.Piece) -> None:
        results[number].add(piece)
        added(number)
        if terminal.is_verbose():
            terminal.detail(f"run {number + 1} of {len(scenes)}, {_piece_text(piece)}")

    workers = workers or cost.cores()
    terminal.detail(
        f"{name}: {len(todo)} pieces of {len(order)} runs, on {min(workers, len(todo))} processes"
    )
    with terminal.bar(total, name, progress) as bar:
        return simulate.march_pieces(scenes, todo, workers, finished, bar.update, orders, begun)


def _piece_text(piece: simulate.Piece) -> str:
    """Write what a piece took: steps, iterations and time."""
    seconds = float(piece.steps["step_time"].sum())
    return (
        f"steps {piece.first} to {piece.last - 1}:"
        f" {float(piece.states['iterations'].mean()):.1f} iterations per state, {seconds:.2f} s"
    )
