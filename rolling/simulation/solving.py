"""Scenes solved on all cores in memory, the longest scenes first, with a progress bar."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence

from rolling.check import cost
from rolling.contact.solver import ContactError
from rolling.dynamics import of_scene
from rolling.scene.scene import Scene
from rolling.simulation import (
    error_stretches,
    force_law,
    moving_release,
    pool,
    shared,
    simulate,
    slow_march,
)
from rolling.simulation.load_marches import LoadPiece
from rolling.simulation.moving_load import MovingPiece
from rolling.simulation.pool import Outcome
from rolling.simulation.result import Result
from rolling.simulation.slow_motion import SlowMotion
from rolling.simulation.stretches import March
from rolling.terminal import progress as terminal

Done = simulate.Piece | March | LoadPiece | MovingPiece | SlowMotion  # results of the tasks


def _ignore(run: int) -> None:
    """Do nothing with the number of a run."""


def solve(
    scenes: Sequence[Scene],
    results: list[Result],
    workers: pool.Workers,
    name: str,
    mapped: bool = True,
    progress: bool | None = None,
    begun: Callable[[int], object] = _ignore,
    added: Callable[[int], object] = _ignore,
    filmed: bool = False,
) -> Outcome:
    """Solve the missing steps of runs and add them to their results.

    Runs whose marches are equal share a result afterwards. The first of them is marched.

    Parameters
    ----------
    scenes : sequence of Scene. Scenes without a sweep, one per run.
    results : list of Result. Their solved steps are not solved again. Results of equal marches are
        replaced by one of them.
    workers : int or Cluster. Number of processes; 0: one per core.
    name : str. Name of the progress bar.
    mapped : bool. Whether pressure maps along the tracks are kept, some megabytes per run.
        Default: true.
    filmed : bool. Whether complete runs get a slow motion. Default: false.
    progress : bool. Whether a progress bar is shown. Default: on a terminal and in a notebook.
    begun : callable. It receives the number of a run when one of its pieces is handed to a process.
    added : callable. It receives the number of a run after each piece is added to its result.

    Both are called with the first of the runs that share a result.
    """
    shared.share(scenes, results)
    work = _Work(scenes, results, filmed)
    todo = work.pieces()
    failures: dict[int, str] = {}
    others = work.first_others(failures)
    total = sum((last - first) * work.step_seconds[k] for k, first, last in todo)
    total += sum(task.cost for task in others)

    workers = workers or cost.cores()
    terminal.detail(
        f"{name}: {len(todo)} pieces of {len({k for k, _, _ in todo})} runs, on"
        f" {_processes(workers, len(todo))}"
    )
    with terminal.bar(total, name, progress) as bar:

        def finished(number: int, done: Done) -> list[pool.Task]:
            following = work.add(number, done)
            added(number)
            bar.grow(sum(task.cost for task in following))
            if terminal.is_verbose() and isinstance(done, simulate.Piece):
                terminal.detail(f"run {number + 1} of {len(scenes)}, {_piece_text(done)}")
            return following

        outcome = simulate.march_pieces(
            scenes, todo, workers, finished, bar.update, work.orders(mapped), begun, others
        )
    outcome.failures |= failures
    for leader, members in work.members.items():
        if leader in outcome.failures:
            outcome.failures |= dict.fromkeys(members, outcome.failures[leader])
    return outcome


def solve_here(
    scene: Scene,
    result: Result,
    stopped: Callable[[], bool],
    progress: Callable[[float], object],
    added: Callable[[], object],
) -> None:
    """Solve the missing steps of a run in this process, without a bar.

    Parameters
    ----------
    scene, result : the run. Its solved steps are not solved again.
    stopped, progress : functions of a `pool.Task`.
    added : callable. It is called after each piece is added to the result.

    Raises
    ------
    ContactError, Interrupted : as in the tasks of the run.
    """
    work = _Work([scene], [result])
    waiting = deque(simulate.piece_tasks([scene], work.pieces(), work.orders(True)))
    waiting.extend([] if waiting else work.others(0))
    while waiting:
        task = waiting.popleft()
        waiting.extend(work.add(0, task.function(*task.arguments, stopped, progress)))
        added()


def _processes(workers: pool.Workers, pieces: int) -> str:
    """Name the processes that solve pieces."""
    if not isinstance(workers, int):
        return f"the workers of {workers.address}"
    return f"{min(workers, max(1, pieces))} processes"


def _piece_text(piece: simulate.Piece) -> str:
    """Write the effort of a piece: steps, iterations and time."""
    seconds = float(piece.steps["step_time"].sum())
    return (
        f"steps {piece.first} to {piece.last - 1}:"
        f" {float(piece.states['iterations'].mean()):.1f} iterations per state, {seconds:.2f} s"
    )


class _Work:
    """Work on runs: their missing pieces, and then the marches for error estimate and force law.

    Slow motions come last.

    scenes, results : sequences. The runs.
    members : dict. Numbers of the runs that share a result, by the first of them.
    filmed : bool. Whether complete runs get a slow motion.
    step_seconds : list of float. Expected time of a step of each run [s].
    waiting : list of int. Number of tasks of each run that are not done.
    """

    def __init__(
        self, scenes: Sequence[Scene], results: Sequence[Result], filmed: bool = False
    ) -> None:
        self.scenes, self.results, self.filmed = scenes, results, filmed
        self.members = shared.members(results)
        self.step_seconds = [
            cost.expected_seconds(scene) / result.solved_steps
            for scene, result in zip(scenes, results, strict=True)
        ]
        self.waiting = [0] * len(scenes)

    @property
    def longest_first(self) -> list[int]:
        """The numbers of the runs; no core then works alone on a long run at the end."""
        return sorted(self.members, key=lambda k: -self.step_seconds[k])

    def pieces(self) -> list[tuple[int, int, int]]:
        """Return run, first and last position of each missing piece."""
        todo = [
            (k, first, last)
            for k in self.longest_first
            for first, last in simulate.missing(
                self.results[k].solved_steps, self.results[k].series["release_energy"]
            )
        ]
        for k, _, _ in todo:
            self.waiting[k] += 1
        return todo

    def orders(self, mapped: bool) -> list[simulate.Order]:
        """Return the settings for the march of each run."""
        return [
            simulate.Order.of(result.identity, seconds, mapped)
            for seconds, result in zip(self.step_seconds, self.results, strict=True)
        ]

    def first_others(self, failures: dict[int, str]) -> list[pool.Task]:
        """Return the first marches beside the pieces, and note runs that cannot have them."""
        tasks = []
        for number in self.longest_first:
            try:
                tasks += self.others(number)
            except ContactError as error:
                failures[number] = str(error)
        return tasks

    def add(self, number: int, done: Done) -> list[pool.Task]:
        """Add a piece, a stretch or a slow motion to its run, and return the tasks that follow."""
        result = self.results[number]
        if isinstance(done, March):
            result.add_march(done)
        elif isinstance(done, SlowMotion):
            result.slow_motion = done
        elif isinstance(done, LoadPiece):
            assert result.load_marches is not None
            result.load_marches.add(done)
        elif isinstance(done, MovingPiece):
            result.moving[done.key].add(done)
        else:
            result.add(done)
        self.waiting[number] -= 1
        return [] if self.waiting[number] else self.others(number)

    def others(self, number: int) -> list[pool.Task]:
        """Return the marches beside its own that a run needs next; the slow motion is the last."""
        result, seconds = self.results[number], self.step_seconds[number]
        scenes = [self.scenes[k] for k in self.members[number]]
        tasks = [
            *error_stretches.tasks(scenes, result, number, seconds),
            *force_law.tasks(scenes, result, number, seconds, of_scene.extremes),
            *moving_release.tasks(scenes, result, number, seconds),
        ]
        if self.filmed and not tasks:
            film = slow_march.task(scenes, result, number, seconds)
            tasks = [film] if film else []
        self.waiting[number] += len(tasks)
        return tasks
