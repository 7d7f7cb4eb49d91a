"""The loop that hands out the pieces of runs to a pool, and completes each run after its last."""

import errno
import signal
from collections import Counter, defaultdict, deque
from collections.abc import Callable, Hashable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from rolling.check import forecast
from rolling.contact.solver import ContactError
from rolling.marches.next_pieces import next_pieces, own_part
from rolling.marches.piece import contact_identity
from rolling.marches.result import Result
from rolling.run.backlog import Backlog
from rolling.run.pools import Pool, Task
from rolling.run.worker import KILLED, MAX_BREAKS, solve_piece
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.surface import scene_surface
from rolling.terminal import progress, shortage

LOOK_SECONDS = 0.5  # between two looks at the pool
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


class RunLoop:
    """Loop over the pieces that runs lack. Runs that need equal pieces share them.

    Runs with one contact identity begin together: the shortest march first, so that a person soon
    hears a run, and then the longest, so that no process waits at the end. A run begins when a team
    of the pool has no other task for a surface of its own, so that a sweep of many runs keeps few
    results in memory.

    Attributes
    ----------
    failures : dict. Reason of each failed run, by the number of the run.
    """

    def __init__(
        self,
        scenes: Sequence[Scene],
        start: Callable[[int], Result],
        finish: Callable[[int, Result], Task | None],
        bar: progress.Bar,
        finished: Callable[[int], object] = lambda number: None,
        pieces: Path | None = None,
        film: bool = False,
    ) -> None:
        """Prepare the runs.

        Parameters
        ----------
        scenes : sequence of Scene. Scenes without a sweep, one per run.
        start : callable. It receives the number of a run and returns its result so far.
        finish : callable. It receives number and result of a complete run, and returns the task
            that remains, or None.
        bar : Bar. It receives the expected time of pieces [s].
        finished : callable. It receives the number of a run that is done. Default: nothing.
        pieces : Path. Folder for files of pieces. Default: they are kept in memory.
        film : bool. Whether complete runs get a slow motion. Default: false.
        """
        self._scenes, self._pieces, self._film, self._bar = scenes, pieces, film, bar
        self._start, self._finish, self._finished = start, finish, finished
        self._results: dict[int, Result] = {}
        self._costs = {number: forecast.march_seconds(scene) for number, scene in enumerate(scenes)}
        # Expected seconds of each run that no piece has taken yet. Pieces that turn up take their
        # time from them, so that the sum of the progress seldom grows.
        self._left: dict[int, float] = {}
        groups = defaultdict(list)
        for number, scene in enumerate(scenes):
            groups[contact_identity(scene)].append(number)
        self._surfaces = [scene_surface.identity(scene) for scene in scenes]
        ordered = sorted(groups.values(), key=lambda group: -self._costs[group[0]])
        ordered = ordered[-1:] + ordered[:-1]
        # It holds tasks, and lists of runs that have to begin.
        self._backlog = Backlog((self._surfaces[group[0]], group) for group in ordered)
        self._suspects: deque[Task] = deque()
        self._flying: dict[Future[Any], tuple[Task, Hashable]] = {}  # with the team
        self._wanting: dict[tuple[str, str], list[int]] = {}  # runs by the key of their task
        self._breaks: Counter[tuple[str, str]] = Counter()
        self.failures: dict[int, str] = {}
        for first, *_ in ordered:  # the others share the marches of the first
            self._left[first] = self._costs[first]
        bar.grow(sum(self._left.values()))

    def run(self, pool: Pool) -> None:
        """Hand out all pieces and collect their results.

        Raises
        ------
        OSError : a disk is full or read-only, or a cluster is gone.
        KeyboardInterrupt : Ctrl-C or SIGTERM. Files of finished pieces are kept.
        """
        with ended_by_signal():
            while self._backlog or self._suspects or self._flying:
                self._hand_out(pool)
                done, _ = wait(self._flying, LOOK_SECONDS, FIRST_COMPLETED)
                pool.look()
                self._bar.tick()
                broken = [future for future in done if not self._collect(future, pool)]
                if broken:
                    self._suspect(pool)

    def _hand_out(self, pool: Pool) -> None:
        """Fill the slots of the pool; a suspect is alone in it."""
        while not any(self._breaks[task.key] for task, _ in self._flying.values()):
            if self._suspects and self._flying:
                return
            in_hand = Counter(team for _, team in self._flying.values())
            if self._suspects:
                team, task = next(iter(pool.teams)), self._suspects.popleft()
            elif taken := self._backlog.take(pool.teams, in_hand, pool.slots):
                team, task = taken
            else:
                return
            if isinstance(task, list):
                self._begin(task)
                continue
            if not self._wanting.get(task.key):  # its runs have failed
                self._wanting.pop(task.key, None)
                continue
            try:
                self._flying[pool.submit(task, team)] = task, team
            except BrokenExecutor:
                self._suspects.appendleft(task)
                self._suspect(pool)

    def _begin(self, group: Sequence[int]) -> None:
        """Begin the runs of one contact identity."""
        for number in group:
            self._results[number] = self._start(number)
            self._advance(number)

    def _advance(self, number: int) -> None:
        """Queue the pieces that a run lacks next, or the task that completes it."""
        result = self._results[number]
        try:
            scene = self._scenes[number]
            pieces = next_pieces(scene, result, self._film)
            own = result if pieces else own_part(scene, result, self._film)
            task = None if pieces else self._finish(number, own)
        except ContactError as error:
            self._fail(number, str(error))
            return
        tasks: list[Task] = []
        for piece in pieces:
            key = piece.identity, piece.key
            if key in self._wanting:
                self._wanting[key].append(number)
            else:
                self._wanting[key] = [number]
                tasks.append(Task(key, solve_piece, (piece, self._pieces), piece))
                taken = min(piece.cost, self._left.get(number, 0.0))
                self._bar.grow(piece.cost - taken)
                self._left[number] = self._left.get(number, 0.0) - taken
        if not pieces:
            self._bar.grow(-self._left.pop(number, 0.0))
            del self._results[number]
            if task is None:
                self._finished(number)
            else:
                self._wanting[task.key] = [number]
                tasks.append(task)  # it frees the memory of its run
        self._backlog.put(self._surfaces[number], tasks)

    def _collect(self, future: Future[Any], pool: Pool) -> bool:
        """Take the value of a task; return false where the pool broke."""
        (task, _), reason = self._flying[future], ""
        try:
            value = future.result()
            if value is None and task.piece is not None:  # its file holds the arrays
                value = solve_piece(task.piece, self._pieces)
        except BrokenExecutor:
            return False
        except CancelledError:
            pool.rebuild()
            raise
        except MemoryError as error:
            reason = shortage.sentence(error)
        except (ContactError, SceneError) as error:
            reason = str(error)
        except OSError as error:
            if task.piece is not None or error.errno in OF_A_DISK:
                raise
            reason = str(error)
        except Exception as error:
            reason = shortage.WORDS if shortage.is_of_memory(error) else pool.reason(error)
        if task.piece is not None and not reason:
            progress.solved()
        del self._flying[future]
        self._breaks.pop(task.key, None)
        self._bar.update(0.0 if task.piece is None else task.piece.cost)
        progress.detail(f"done: {' '.join(task.key)}")
        numbers = self._wanting.pop(task.key, [])
        for number in numbers:
            if reason:
                self._fail(number, reason)
            elif task.piece is None:
                self._finished(number)
            else:
                self._results[number].add(task.piece, value)
                if not any(number in waiting for waiting in self._wanting.values()):
                    self._advance(number)
        return True

    def _fail(self, number: int, reason: str) -> None:
        """Note that a run failed, with marks in its heights, and forget its other tasks."""
        scene = self._scenes[number]
        if scene.height_paths and number not in self.failures:
            with suppress(SceneError, MemoryError):  # the file is gone, or does not fit here
                suspicions = scene_surface.scene_surface(scene).suspicions
                reason = "; ".join((reason, *suspicions))
        self.failures.setdefault(number, reason)
        self._bar.grow(-self._left.pop(number, 0.0))
        self._results.pop(number, None)
        for numbers in self._wanting.values():
            if number in numbers:
                numbers.remove(number)

    def _suspect(self, pool: Pool) -> None:
        """Rebuild a broken pool; each task in hand is done again, alone."""
        progress.line(LOST)
        for task, _ in self._flying.values():
            self._breaks[task.key] += 1
            if self._breaks[task.key] < MAX_BREAKS:
                self._suspects.appendleft(task)
            else:
                for number in self._wanting.pop(task.key, []):
                    self._fail(number, KILLED)
        self._flying.clear()
        pool.rebuild()
