"""The loop that hands out the pieces of runs to a pool, and yields each run when it is finished."""

import errno
import signal
from collections import Counter, defaultdict, deque
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

from rolling.check import cost, forecast
from rolling.contact.solver import ContactError
from rolling.marches.next_pieces import next_pieces, own_part
from rolling.marches.piece import Piece, contact_identity
from rolling.marches.result import Result
from rolling.results import result_file
from rolling.results.run_folder import RESULT, RunFolder
from rolling.run.backlog import Backlog
from rolling.run.pools import Pool, Task
from rolling.run.worker import KILLED, MAX_BREAKS, finish_run, solve_piece
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.surface import scene_surface
from rolling.terminal import progress, shortage

POLL_SECONDS = 0.5  # between two polls of the pool
LOST = "a worker process was killed; the tasks that it may have had are done again, one by one"
# Errors of a disk, which stop all runs. Another error of the system stops the run of its folder.
OF_A_DISK = (errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EIO)


@contextmanager
def ended_by_signal() -> Iterator[None]:
    """Raise KeyboardInterrupt for SIGTERM as for Ctrl-C, in the main thread."""
    try:
        before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    except ValueError:  # only the main thread may handle signals
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


@dataclass(frozen=True)
class RunFiles:
    """Files of the runs of a loop.

    runs : sequence of RunFolder. The folder of each run.
    labels : sequence of str. The label of each run.
    pieces : Path. Folder for the files of pieces.
    stored : mapping. Runs that are done, by contact identity; their marches are taken.
    film : bool. Whether runs get a slow motion.
    finish : function. It makes the sound of a complete run from its folder, label and result, and
        writes its files, in a process of the pool. It may return the digest of a run that is kept.
    """

    runs: Sequence[RunFolder]
    labels: Sequence[str]
    pieces: Path
    stored: Mapping[str, RunFolder]
    film: bool
    finish: Callable[[RunFolder, str, Result], str | None] = finish_run


class FinishedRun(NamedTuple):
    """Run that is finished.

    number : int. Its place among the scenes.
    result : Result. None where its files are written.
    digest : str. Digest of a run that is kept for the end of the command; empty without.
    """

    number: int
    result: Result | None
    digest: str = ""


class _TaskInHand(NamedTuple):
    """Task that a team of the pool has."""

    task: Task
    team: Hashable


class RunLoop:
    """Loop over the pieces that runs lack. Runs that need equal pieces share them.

    Runs with one contact identity begin together: the shortest march first, so that a person soon
    hears a run, and then the longest, so that no process waits at the end. A run begins when a team
    of the pool has no other task for a surface of its own, so that a sweep of many runs keeps few
    results in memory.

    Attributes
    ----------
    failures : dict. Reason of each failed run, by the number of the run.
    without_solution : set. Numbers of the failed runs whose contact has no solution.
    """

    def __init__(
        self, scenes: Sequence[Scene], bar: progress.Bar, files: RunFiles | None = None
    ) -> None:
        """Prepare the runs.

        Parameters
        ----------
        scenes : sequence of Scene. Scenes without a sweep, one per run.
        bar : Bar. It receives the expected time of pieces [s].
        files : RunFiles. Files that the runs get. Default: all is kept in memory.
        """
        self.failures: dict[int, str] = {}
        self.without_solution: set[int] = set()
        self._scenes = scenes
        self._bar = bar
        self._files = files
        self._identities = [contact_identity(scene) for scene in scenes]
        self._surfaces = [scene_surface.identity(scene) for scene in scenes]
        groups = defaultdict[str, list[int]](list)
        for number, identity in enumerate(self._identities):
            groups[identity].append(number)
        # Expected seconds of the first run of each group, whose march the others share. Pieces take
        # their time from them, so that the sum of the progress seldom grows.
        self._unplanned_seconds: dict[int, float] = {}
        self._step_seconds: dict[str, float] = {}  # expected, by contact identity
        for identity, group in groups.items():
            scene = scenes[group[0]]
            self._unplanned_seconds[group[0]] = forecast.march_seconds(scene)
            self._step_seconds[identity] = cost.lap_seconds(scene) / scene.track.solved_steps
        bar.grow(sum(self._unplanned_seconds.values()))
        longest_first = sorted(
            groups.values(), key=lambda group: self._unplanned_seconds[group[0]], reverse=True
        )
        ordered = longest_first[-1:] + longest_first[:-1]
        # The backlog holds tasks, and groups of runs that have to begin.
        self._backlog = Backlog((self._surfaces[group[0]], group) for group in ordered)
        self._results: dict[int, Result] = {}  # of runs that have begun
        self._finished: deque[FinishedRun] = deque()
        self._in_hand: dict[Future[Any], _TaskInHand] = {}
        self._wanting: dict[tuple[str, str], list[int]] = {}  # runs by the key of their task
        self._suspects: deque[Task] = deque()  # tasks that may have killed their process
        self._breaks: Counter[tuple[str, str]] = Counter()  # of the pool, by the key of a task

    def finished_runs(self, pool: Pool) -> Iterator[FinishedRun]:
        """Hand out all pieces, and yield each run when it is complete or its files are written.

        Raises
        ------
        OSError : a disk is full or read-only, or a cluster is gone.
        KeyboardInterrupt : Ctrl-C or SIGTERM. Files of finished pieces are kept.
        """
        while self._backlog or self._suspects or self._in_hand:
            self._hand_out(pool)
            done, _ = wait(self._in_hand, POLL_SECONDS, FIRST_COMPLETED)
            pool.poll()
            self._bar.tick()
            is_broken = False
            for future in done:
                try:
                    self._collect(future, pool)
                except BrokenExecutor:
                    is_broken = True
            if is_broken:
                self._repeat_lost_tasks(pool)
            while self._finished:
                yield self._finished.popleft()

    # ---- runs: begin, march, finish, fail

    def _begin(self, group: Sequence[int]) -> None:
        """Begin the runs of one contact identity."""
        for number in group:
            self._results[number] = self._first_result(number)
            self._plan(number)

    def _first_result(self, number: int) -> Result:
        """Return the result with which a run begins: empty, or with the march of a stored run."""
        scene = self._scenes[number]
        source = None
        if self._files is not None:
            source = self._files.stored.get(self._identities[number])
        if source is None:
            return Result.empty(scene)
        result = result_file.read_result(source.folder / RESULT, source.scene)
        film = result.slow_motion
        if film is not None and len(film.positions) == 0:
            film = None  # another stretch may have a solution
        return replace(result, steps=scene.track.steps, extremes={}, slow_motion=film)

    def _plan(self, number: int) -> None:
        """Queue the pieces that a run lacks next, or finish it."""
        scene = self._scenes[number]
        result = self._results[number]
        film = self._files is not None and self._files.film
        try:
            pieces = next_pieces(scene, result, film)
        except ContactError as error:
            self.without_solution.add(number)
            self.fail(number, str(error))
            return
        if not pieces:
            self._bar.grow(-self._unplanned_seconds.pop(number, 0.0))
            self._finish(number)
            return
        step_seconds = self._step_seconds[self._identities[number]]
        tasks = []
        for piece in pieces:
            key = piece.identity, piece.key
            if key in self._wanting:  # another run waits for an equal piece
                self._wanting[key].append(number)
                continue
            self._wanting[key] = [number]
            seconds = (piece.last - piece.first) * step_seconds * piece.step_cost
            self._expect(number, seconds)
            tasks.append(self._piece_task(piece, seconds))
        self._backlog.put(self._surfaces[number], tasks)

    def _piece_task(self, piece: Piece, seconds: float) -> Task:
        """Return the task of a piece with its expected time [s]."""
        pieces = None
        if self._files is not None:
            pieces = self._files.pieces
        return Task(
            key=(piece.identity, piece.key),
            function=solve_piece,
            arguments=(piece, pieces),
            piece=piece,
            seconds=seconds,
        )

    def _expect(self, number: int, seconds: float) -> None:
        """Take the time of a piece [s] from the forecast of its run; the progress gets the rest."""
        unplanned = self._unplanned_seconds.get(number, 0.0)
        taken = min(seconds, unplanned)
        self._unplanned_seconds[number] = unplanned - taken
        self._bar.grow(seconds - taken)

    def _finish(self, number: int) -> None:
        """Hand over a complete run, or queue the task that writes its files."""
        scene = self._scenes[number]
        film = self._files is not None and self._files.film
        try:
            result = own_part(scene, self._results.pop(number), film)
        except ContactError as error:
            self.without_solution.add(number)
            self.fail(number, str(error))
            return
        if self._files is None:
            self._finished.append(FinishedRun(number, result))
            return
        run = self._files.runs[number]
        task = Task(
            key=("finish", str(number)),
            function=self._files.finish,
            arguments=(run, self._files.labels[number], result),
        )
        self._wanting[task.key] = [number]
        self._backlog.put(self._surfaces[number], [task])

    def fail(self, number: int, reason: str) -> None:
        """Note that a run failed, with marks in its heights, and forget its other tasks."""
        scene = self._scenes[number]
        if scene.height_paths and number not in self.failures:
            with suppress(SceneError, MemoryError):  # the file is gone, or does not fit here
                suspicions = scene_surface.scene_surface(scene).suspicions
                reason = "; ".join((reason, *suspicions))
        self.failures.setdefault(number, reason)
        self._bar.grow(-self._unplanned_seconds.pop(number, 0.0))
        self._results.pop(number, None)
        for numbers in self._wanting.values():
            if number in numbers:
                numbers.remove(number)

    # ---- tasks: hand out, collect, repeat

    def _hand_out(self, pool: Pool) -> None:
        """Fill the slots of the pool; a suspect is alone in it."""
        while not any(self._breaks[in_hand.task.key] for in_hand in self._in_hand.values()):
            if self._suspects and self._in_hand:
                return
            if self._suspects:
                task = self._suspects.popleft()
                team = next(iter(pool.teams))
            else:
                counts = Counter(in_hand.team for in_hand in self._in_hand.values())
                taken = self._backlog.take(pool.teams, counts, pool.slots)
                if taken is None:
                    return
                team, item = taken
                if not isinstance(item, Task):
                    self._begin(item)
                    continue
                task = item
            if not self._wanting.get(task.key):  # its runs have failed
                self._wanting.pop(task.key, None)
                continue
            try:
                self._in_hand[pool.submit(task, team)] = _TaskInHand(task, team)
            except BrokenExecutor:
                self._suspects.appendleft(task)
                self._repeat_lost_tasks(pool)

    def _collect(self, future: Future[Any], pool: Pool) -> None:
        """Store the value of a task in its runs, or fail them; raise BrokenExecutor for retry."""
        task = self._in_hand[future].task
        value: Any = None
        reason = ""
        has_solution = True
        try:
            value = future.result()
            if value is None and task.piece is not None:  # its file holds the arrays
                value = solve_piece(*task.arguments)
        except BrokenExecutor:
            raise
        except CancelledError:
            pool.rebuild()
            raise
        except Exception as error:
            reason = _failure_reason(task, error, pool)
            has_solution = not isinstance(error, ContactError)
        if task.piece is not None and not reason:
            progress.solved()
        del self._in_hand[future]
        self._breaks.pop(task.key, None)
        self._bar.update(task.seconds)
        progress.detail(f"done: {' '.join(task.key)}")
        for number in self._wanting.pop(task.key, []):
            if reason:
                if not has_solution:
                    self.without_solution.add(number)
                self.fail(number, reason)
            elif task.piece is None:
                self._finished.append(FinishedRun(number, None, value or ""))
            else:
                self._results[number].add(task.piece, value)
                if not self._is_waiting(number):
                    self._plan(number)

    def _is_waiting(self, number: int) -> bool:
        """Return whether a run waits for a task."""
        return any(number in numbers for numbers in self._wanting.values())

    def _repeat_lost_tasks(self, pool: Pool) -> None:
        """Rebuild a broken pool, and queue each task in hand again, to be done alone."""
        progress.line(LOST)
        for in_hand in self._in_hand.values():
            key = in_hand.task.key
            self._breaks[key] += 1
            if self._breaks[key] < MAX_BREAKS:
                self._suspects.appendleft(in_hand.task)
            else:
                for number in self._wanting.pop(key, []):
                    self.fail(number, KILLED)
        self._in_hand.clear()
        pool.rebuild()


def _failure_reason(task: Task, error: Exception, pool: Pool) -> str:
    """Return the reason why the runs of a task fail, or raise an error that stops all runs."""
    if isinstance(error, MemoryError):
        return shortage.sentence(error)
    if isinstance(error, ContactError | SceneError):
        return str(error)
    if isinstance(error, OSError):
        if task.piece is not None or error.errno in OF_A_DISK:
            raise error
        return str(error)
    if shortage.is_of_memory(error):
        return shortage.WORDS
    return pool.failure_reason(error)
