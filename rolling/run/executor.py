"""The loop that hands out the pieces of runs to a pool, and yields each run when it is finished."""

import errno
import signal
from collections import Counter, defaultdict, deque
from collections.abc import Callable, Hashable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from rolling.check import cost, forecast
from rolling.contact.solver import ContactError
from rolling.in_si import scene_surface
from rolling.kinds.needed_marches import March, MarchStore
from rolling.kinds.run_folder import RunFolder
from rolling.marches.next_pieces import next_pieces
from rolling.marches.piece import Piece, contact_identity
from rolling.marches.result import Result
from rolling.run import folder as folders
from rolling.run.backlog import Backlog
from rolling.run.pools import Pool, Task
from rolling.run.worker import KILLED, MAX_BREAKS, finish_run, solve_piece
from rolling.scene.messages import SceneError
from rolling.terminal import progress, shortage

POLL_SECONDS = 0.5  # between two polls of the pool
FEW = 2  # processes, of which one alone makes a first answer sooner
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
    folder : Path. Folder above the runs, with the files of pieces.
    finish : function or None. It makes the sound of a complete run from its folder, label and
        marches, and writes its files, in a process of the pool. It may return the digest of a run
        that is kept. None for runs that have no files but those of their marches.
    """

    runs: Sequence[RunFolder]
    labels: Sequence[str]
    folder: Path
    finish: Callable[[RunFolder, str, Sequence[Any]], str | None] | None = finish_run

    @property
    def pieces(self) -> Path:
        """Folder of the files of pieces."""
        return self.folder / folders.PIECES


class FinishedRun(NamedTuple):
    """Run that is finished.

    number : int. Its place among the runs.
    marched : list. What is kept of each of its marches; empty where its files are written.
    digest : str. Digest of a run that is kept for the end of the command; empty without.
    """

    number: int
    marched: list[Any]
    digest: str = ""


class _TaskInHand(NamedTuple):
    """Task that a team of the pool has."""

    task: Task
    team: Hashable


class _OneMarch:
    """A march of the loop: its contact, and the runs that need it.

    march : March. The march.
    identity : str. Its contact identity.
    surface : hashable. Identity of its surface.
    runs : list of int. Numbers of the runs that need it and are not finished.
    """

    def __init__(self, march: March) -> None:
        self.march = march
        self.identity = contact_identity(march.scene)
        self.surface = scene_surface.identity(march.scene)
        self.runs: list[int] = []


FIRST_PAGE = "first page", ""  # key of its task, which is beside all runs


class RunLoop:
    """Loop over the pieces that the marches of runs lack, of runs of any kind.

    Marches that need equal pieces share them. Those of one contact identity begin together: the
    shortest first, so that a person soon hears a run, and then the longest, so that no process
    waits at the end. They begin when a team of the pool has no other task for a surface of its own,
    so that a sweep of many runs keeps few results in memory. Marches that no pilot needs begin when
    nothing else is left to hand out, and none of them waits in a process that a pilot will need.

    Attributes
    ----------
    failures : dict. Reason of each failed run, by the number of the run.
    without_solution : set. Numbers of the failed runs whose contact has no solution.
    """

    def __init__(
        self,
        runs: Sequence[Sequence[March]],
        store: MarchStore,
        bar: progress.Bar,
        files: RunFiles | None = None,
    ) -> None:
        """Prepare the runs.

        Parameters
        ----------
        runs : sequence of sequence of March. The marches that each run needs.
        store : MarchStore. It has the marches that are known, and keeps the others.
        bar : Bar. It receives the expected time of pieces [s].
        files : RunFiles. Files that the runs get. Default: all is kept in memory.
        """
        self.failures: dict[int, str] = {}
        self.without_solution: set[int] = set()
        self._store = store
        self._bar = bar
        self._files = files
        self._marches: list[_OneMarch] = []
        self._shared: dict[str, int] = {}  # marches that runs share, by their identity
        self._of_run = [self._numbers_of(run, needed) for run, needed in enumerate(runs)]
        self._kept: dict[int, Any] = {}  # of whole marches, as long as runs need it
        self._results: dict[int, Result] = {}  # of marches that have begun
        self._finished: deque[FinishedRun] = deque()
        self._in_hand: dict[Future[Any], _TaskInHand] = {}
        self._wanting: dict[tuple[str, str], list[int]] = {}  # marches by the key of their piece
        self._endings: dict[tuple[str, str], int] = {}  # runs by the key of their last task
        self._urgent: deque[Task] = deque()  # tasks for the next free process
        # What is done with the text of a task that is beside all runs, by its key.
        self._beside: dict[tuple[str, str], Callable[[str], None]] = {}
        self._suspects: deque[Task] = deque()  # tasks that may have killed their process
        self._breaks: Counter[tuple[str, str]] = Counter()  # of the pool, by the key of a task
        # Expected seconds of the first march of each group, which the others share. Pieces take
        # their time from them, so that the sum of the progress seldom grows.
        self._unplanned_seconds: dict[int, float] = {}
        self._step_seconds: dict[str, float] = {}  # expected, by contact identity
        self._backlog = Backlog()  # of tasks, and of groups of marches that have to begin
        self._later: list[list[int]] = []  # groups that no pilot needs
        # Runs that are not finished, and wait for none of these: pilots.
        self._answers: set[int] = set()
        if any(not march.is_first for needed in runs for march in needed):
            self._answers = {
                run for run, needed in enumerate(runs) if all(march.is_first for march in needed)
            }
        self._find_known()
        self._queue_groups()

    def _numbers_of(self, run: int, needed: Sequence[March]) -> list[int]:
        """Return the numbers of the marches of a run; one that is shared has one number."""
        numbers = []
        for march in needed:
            own = _OneMarch(march)
            number = len(self._marches)
            if march.is_shared:
                number = self._shared.setdefault(own.identity, number)
            if number == len(self._marches):
                self._marches.append(own)
            if run not in self._marches[number].runs:
                self._marches[number].runs.append(run)
            numbers.append(number)
        return numbers

    def _find_known(self) -> None:
        """Take the marches that are kept already, and finish the runs that need no other."""
        for number, own in enumerate(self._marches):
            known = self._store.find(own.march, own.identity)
            if known is not None:
                self._kept[number] = known
        for run in range(len(self._of_run)):
            self._finish_if_whole(run)

    def _queue_groups(self) -> None:
        """Queue the marches that are lacking, in groups of one contact identity."""
        groups = defaultdict[str, list[int]](list)
        for number, own in enumerate(self._marches):
            if number not in self._kept:
                groups[own.identity].append(number)
        for identity, group in groups.items():
            scene = self._marches[group[0]].march.scene
            self._unplanned_seconds[group[0]] = forecast.march_seconds(scene)
            self._step_seconds[identity] = cost.lap_seconds(scene) / scene.track.solved_steps
        self._bar.grow(sum(self._unplanned_seconds.values()))
        longest_first = sorted(
            groups.values(), key=lambda group: self._unplanned_seconds[group[0]], reverse=True
        )
        first = [group for group in longest_first if self._is_first(group)]
        self._later = [group for group in longest_first if not self._is_first(group)]
        for group in first[-1:] + first[:-1]:
            self._backlog.put_last(self._marches[group[0]].surface, group)

    def _is_first(self, group: Sequence[int]) -> bool:
        """Tell whether a first answer needs one of some marches."""
        return any(self._marches[number].march.is_first for number in group)

    def finished_runs(self, pool: Pool) -> Iterator[FinishedRun]:
        """Hand out all pieces, and yield each run when it is complete or its files are written.

        Raises
        ------
        OSError : a disk is full or read-only, or a cluster is gone.
        KeyboardInterrupt : Ctrl-C or SIGTERM. Files of finished pieces are kept.
        """
        while self._finished:
            yield self._finished.popleft()
        while self._backlog or self._later or self._urgent or self._suspects or self._in_hand:
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

    # ---- marches: begin, plan, keep

    def _begin(self, group: Sequence[int]) -> None:
        """Begin the marches of one contact identity."""
        for number in group:
            own = self._marches[number]
            if not own.runs:  # they have failed
                self._forget(number)
                continue
            begun = self._store.begin(own.march, own.identity)
            self._results[number] = Result.empty(own.march.scene) if begun is None else begun
            self._plan(number)

    def _plan(self, number: int) -> None:
        """Queue the pieces that a march lacks next, or keep it whole."""
        own = self._marches[number]
        result = self._results[number]
        try:
            pieces = next_pieces(own.march.scene, result, own.march.film)
            if not pieces:
                kept = self._store.keep(own.march, own.identity, self._results.pop(number))
        except ContactError as error:
            self._fail_march(number, str(error), has_solution=False)
            return
        if not pieces:
            self._bar.grow(-self._unplanned_seconds.pop(number, 0.0))
            self._keep(number, kept)
            return
        step_seconds = self._step_seconds[own.identity]
        tasks = []
        for piece in pieces:
            key = piece.identity, piece.key
            if key in self._wanting:  # another march waits for an equal piece
                self._wanting[key].append(number)
                continue
            self._wanting[key] = [number]
            seconds = (piece.last - piece.first) * step_seconds * piece.step_cost
            self._expect(number, seconds)
            tasks.append(self._piece_task(piece, seconds))
        self._backlog.put(own.surface, tasks)

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
        """Take the time of a piece [s] from the forecast of its march; the bar gets the rest."""
        unplanned = self._unplanned_seconds.get(number, 0.0)
        taken = min(seconds, unplanned)
        self._unplanned_seconds[number] = unplanned - taken
        self._bar.grow(seconds - taken)

    def _keep(self, number: int, kept: Any) -> None:
        """Note what is kept of a whole march, and finish the runs that needed nothing else."""
        own = self._marches[number]
        self._kept[number] = kept
        if self._files is not None and self._store.is_lasting:
            folders.drop_pieces(self._files.folder, own.identity)
        for run in list(own.runs):
            self._finish_if_whole(run)

    def _forget(self, number: int) -> None:
        """Forget a march that no run needs any more, and its pieces that wait."""
        self._bar.grow(-self._unplanned_seconds.pop(number, 0.0))
        self._results.pop(number, None)
        for numbers in self._wanting.values():
            if number in numbers:
                numbers.remove(number)

    def _fail_march(self, number: int, reason: str, has_solution: bool = True) -> None:
        """Note that the runs which need a march failed."""
        own = self._marches[number]
        for run in list(own.runs):
            if not has_solution:
                self.without_solution.add(run)
            self.fail(run, own.march.failure(reason))

    # ---- runs: finish, fail

    def _finish_if_whole(self, run: int) -> None:
        """Hand over a run all of whose marches are whole, or queue the task of its files."""
        numbers = self._of_run[run]
        if all(number in self._kept for number in numbers):
            marched = [self._kept[number] for number in numbers]
            if self._files is None or self._files.finish is None:
                self._leave(run)
                self._finished.append(FinishedRun(run, marched))
            else:
                self._queue_ending(("finish", str(run)), run, self._files.finish, marched)

    def _queue_ending(
        self,
        key: tuple[str, str],
        run: int,
        function: Callable[..., Any],
        marched: Sequence[Any],
    ) -> None:
        """Queue a task on the files of a run."""
        assert self._files is not None  # asked for by the callers
        arguments = (self._files.runs[run], self._files.labels[run], marched)
        self._endings[key] = run
        numbers = self._of_run[run]
        task = Task(key=key, function=function, arguments=arguments)
        if run in self._answers:
            self._urgent.append(task)
            return
        # None is no surface for the backlog, which would never hand out the task.
        surface = self._marches[numbers[0]].surface if numbers else key
        self._backlog.put(surface, [task])

    def queue_page(self, function: Callable[..., str], *arguments: Any) -> None:
        """Queue the page of what is known so far before all else; its failure is none of a run."""
        self._beside[FIRST_PAGE] = _tell_page
        self._urgent.append(Task(FIRST_PAGE, function, arguments))

    def queue_beside(
        self,
        run: int,
        function: Callable[..., str],
        arguments: tuple[Any, ...],
        then: Callable[[str], None],
    ) -> None:
        """Queue a task about a finished run, whose failure is none of the run.

        Parameters
        ----------
        run : int. Number of the run.
        function : function. It returns a text, empty where there is nothing to act on.
        arguments : tuple. Its arguments.
        then : function. It acts on the text in this process.
        """
        key = "beside", str(run)
        self._beside[key] = then
        self._backlog.put_last(key, Task(key=key, function=function, arguments=arguments))

    def _end(self, task: Task, value: Any, reason: str) -> None:
        """Act on the end of a task on the files of a run."""
        if task.key in self._beside:
            then = self._beside.pop(task.key)
            if value:
                then(value)
            return
        run = self._endings[task.key]
        if reason:
            self.fail(run, reason)
            return
        self._leave(run)
        self._finished.append(FinishedRun(run, [], value or ""))

    def fail(self, run: int, reason: str) -> None:
        """Note that a run failed, with marks in its heights, and forget the marches of it alone."""
        if run not in self.failures:
            self.failures[run] = "; ".join([reason, *self._suspicions(run)])
        self._answers.discard(run)
        for number in self._of_run[run]:
            if run in self._marches[number].runs:
                self._marches[number].runs.remove(run)
            if not self._marches[number].runs:
                self._forget(number)
                self._kept.pop(number, None)

    def _suspicions(self, run: int) -> list[str]:
        """Return what is suspicious in the measured heights of a run."""
        suspicions: list[str] = []
        for number in self._of_run[run]:
            scene = self._marches[number].march.scene
            if scene.height_paths:
                with suppress(SceneError, MemoryError):  # the file is gone, or does not fit here
                    suspicions += scene_surface.scene_surface(scene).suspicions
        return list(dict.fromkeys(suspicions))

    def _leave(self, run: int) -> None:
        """Let go what a finished run needed, and the pieces that no other run needs."""
        self._answers.discard(run)
        for number in self._of_run[run]:
            own = self._marches[number]
            if run in own.runs:
                own.runs.remove(run)
            if not own.runs:
                self._kept.pop(number, None)
            is_needed = any(other.runs for other in self._marches if other.identity == own.identity)
            if self._files is not None and not is_needed:
                folders.drop_pieces(self._files.folder, own.identity)

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
                taken = self._take_urgent(pool, counts)
                if taken is None:
                    # Before a first answer no task waits in a process that the answer will need.
                    slots = 1 if self._answers else pool.slots
                    taken = self._backlog.take(pool.teams, counts, slots)
                if taken is None and not self._backlog and self._later and not self._hold(pool):
                    self._queue_later()
                    continue
                if taken is None:
                    return
                team, item = taken
                if not isinstance(item, Task):
                    self._begin(item)
                    continue
                task = item
            if not self._is_wanted(task):  # its runs have failed
                self._wanting.pop(task.key, None)
                continue
            try:
                self._in_hand[pool.submit(task, team)] = _TaskInHand(task, team)
            except BrokenExecutor:
                self._suspects.appendleft(task)
                self._repeat_lost_tasks(pool)

    def _take_urgent(self, pool: Pool, counts: Counter[Hashable]) -> tuple[Hashable, Any] | None:
        """Take an urgent task for the idlest team that has a free slot; None without one."""
        if not self._urgent:
            return None
        idlest = min(pool.teams, key=lambda team: counts[team] / pool.teams[team])
        if counts[idlest] >= pool.slots * pool.teams[idlest]:
            return None
        return idlest, self._urgent.popleft()

    def _hold(self, pool: Pool) -> bool:
        """Tell whether other marches are held back for a first answer that is being made.

        One of two processes makes the answer. The other one would slow it down by about as much as
        it would get done itself.
        """
        is_answering = bool(self._answers and self._in_hand)
        return is_answering and sum(pool.teams.values()) <= FEW

    def _queue_later(self) -> None:
        """Queue the marches that no first answer needs."""
        for group in self._later:
            self._backlog.put_last(self._marches[group[0]].surface, group)
        self._later = []

    def _is_wanted(self, task: Task) -> bool:
        """Tell whether a run still needs a task."""
        if task.piece is not None:
            return bool(self._wanting.get(task.key))
        return task.key in self._beside or self._endings[task.key] not in self.failures

    def _collect(self, future: Future[Any], pool: Pool) -> None:
        """Store the value of a task, or fail what needs it; raise BrokenExecutor for retry."""
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
        if task.piece is None:
            if not has_solution and task.key in self._endings:
                self.without_solution.add(self._endings[task.key])
            self._end(task, value, reason)
            return
        for number in self._wanting.pop(task.key, []):
            if reason:
                self._fail_march(number, reason, has_solution)
                continue
            self._results[number].add(task.piece, value)
            if not self._is_waiting(number):
                self._plan(number)

    def _is_waiting(self, number: int) -> bool:
        """Return whether a march waits for a piece."""
        return any(number in numbers for numbers in self._wanting.values())

    def _repeat_lost_tasks(self, pool: Pool) -> None:
        """Rebuild a broken pool, and queue each task in hand again, to be done alone."""
        progress.line(LOST)
        for in_hand in self._in_hand.values():
            task = in_hand.task
            self._breaks[task.key] += 1
            if self._breaks[task.key] < MAX_BREAKS:
                self._suspects.appendleft(task)
            elif task.piece is None and task.key in self._endings:
                self.fail(self._endings[task.key], KILLED)
            else:
                for number in self._wanting.pop(task.key, []):
                    self._fail_march(number, KILLED)
        self._in_hand.clear()
        pool.rebuild()


def _tell_page(page: str) -> None:
    """Say where the page of what is known so far stands."""
    progress.line(f"the first page, which the whole one will replace: {page}")


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
