"""Runs of a sweep as tasks: the runs that are left, their ends, and their sound for pictures."""

from __future__ import annotations

import json
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

from rolling.check import cost
from rolling.commands import details, whole_runs
from rolling.commands.run_files import Wanted
from rolling.commands.whole_runs import Done, Order
from rolling.folders import run_record
from rolling.folders.claim import Claim
from rolling.folders.files import FolderError
from rolling.simulation import batch, error_stretches, labels, pool, simulate
from rolling.simulation.batch import Run
from rolling.simulation.pool import Outcome
from rolling.simulation.result import Result
from rolling.simulation.run_result import RunResult, hear
from rolling.simulation.stored_runs import is_begun, with_chosen_tolerance
from rolling.terminal import defaults, progress

PER_WORKER = 4  # runs; with fewer of them a process may be idle while another ends a long run
SHORT_PIECES = 4  # pieces of a run for which that does not matter
SUMMARY = "summary.json"


@dataclass
class Ends:
    """The runs of a folder after solving, by their numbers.

    sounds : list. Each run with its sound; None where too little is solved, or where there are too
        many runs for common pictures.
    summaries : list. The numbers of summary.json; None where too little is solved.
    complete, begun : lists of bool. Whether all steps, and whether any step is solved.
    """

    sounds: list[RunResult | None]
    summaries: list[dict[str, Any] | None]
    complete: list[bool]
    begun: list[bool]

    @classmethod
    def of(
        cls, runs: Sequence[Run], results: Sequence[Result], sounds: list[RunResult | None]
    ) -> Ends:
        """Describe runs whose results are in memory."""
        return cls(
            sounds,
            [None if each is None else each.summary for each in sounds],
            [
                result.complete and not error_stretches.missing(run.scene, result)
                for run, result in zip(runs, results, strict=True)
            ],
            [is_begun(result) for result in results],
        )

    @classmethod
    def unsolved(cls, runs: int) -> Ends:
        """Describe runs of which nothing is solved."""
        return cls([None] * runs, [None] * runs, [False] * runs, [False] * runs)

    def take(self, number: int, done: Done) -> None:
        """Note the end of a run."""
        self.sounds[number], self.summaries[number] = done.heard, done.summary
        self.complete[number], self.begun[number] = done.complete, done.begun


def are_tasks(runs: Sequence[Run], wanted: Wanted) -> bool:
    """Tell whether each run is one task, not each piece of its track.

    On local processes runs of small sweeps stay in memory for their pictures.
    """
    if len(runs) == 1 or (wanted.cluster is None and wanted.whole_folders(len(runs))):
        return False
    solvers = wanted.solvers
    if len(runs) >= PER_WORKER * (solvers if isinstance(solvers, int) else wanted.cluster_workers):
        return True
    return all(
        each.scene.track.solved_steps <= SHORT_PIECES * simulate.PIECE_STEPS for each in runs
    )


def solve(
    held: Claim,
    runs: Sequence[Run],
    wanted: Wanted,
    take_over: bool,
    numbers: Sequence[int] | None = None,
) -> tuple[Outcome, Ends]:
    """Do the runs that are not done, each as a task that writes its own files.

    Parameters
    ----------
    held : Claim. The claim on the folder of the sweep, or on a part of it.
    runs : sequence of Run. All runs of the sweep.
    wanted : Wanted. The files that are requested.
    take_over : bool. Whether claims that cannot be judged from here are ignored.
    numbers : sequence of int. The runs of a part, which draws nothing. Default: all runs.
    """
    names, ends = labels.labels(runs), Ends.unsolved(len(runs))
    drawn = numbers is None and _are_drawn(runs, wanted)
    whole = wanted.whole_folders(len(runs))
    tasks = []
    for number in range(len(runs)) if numbers is None else numbers:
        run = runs[number]
        if (done := _done_before(run)) is not None:
            ends.take(number, done)
        else:
            if wanted.cluster:  # whose workers have other working folders
                run = replace(run, folder=run.folder.resolve())
            heard = drawn and wanted.cluster is None
            order = Order(run, names[number], whole, heard, take_over or bool(wanted.cluster))
            seconds = cost.expected_seconds(run.scene)
            tasks.append(pool.Task(number, whole_runs.do_run, (order,), seconds))
    tasks.sort(key=lambda task: -task.cost)
    details.tell_marches([runs[task.run].scene for task in tasks])
    outcome = _work(tasks, wanted, runs[0].scene.name, ends)
    for number, reason in outcome.failures.items():  # such as that its worker was killed
        with suppress(OSError, FolderError):  # a folder that cannot be written says so
            held.mark(runs[number].folder, "failed", reason)
    if drawn:
        _hear(runs, names, ends, whole)
    return outcome, ends


def gather(runs: Sequence[Run], wanted: Wanted) -> Ends:
    """Return the ends of runs that are done, from their files, without solving any."""
    ends = Ends.unsolved(len(runs))
    for number, run in enumerate(runs):
        if (done := _done_before(run)) is not None:
            ends.take(number, done)
    if _are_drawn(runs, wanted):
        _hear(runs, labels.labels(runs), ends, wanted.whole_folders(len(runs)))
    return ends


def _are_drawn(runs: Sequence[Run], wanted: Wanted) -> bool:
    return wanted.pictures is not False and len(runs) <= defaults.MOST_RUNS_COMPARED


def are_summarized(runs: Sequence[Run], wanted: Wanted) -> bool:
    """Tell whether runs are too many for a curve each in common pictures, which show their means.

    Such a sweep has no page.
    """
    return wanted.pictures is not False and len(runs) > defaults.MOST_RUNS_COMPARED


def _work(tasks: Sequence[pool.Task], wanted: Wanted, name: str, ends: Ends) -> Outcome:
    """Do the tasks and note their ends."""
    failures: dict[int, str] = {}
    with progress.bar(sum(task.cost for task in tasks), name) as bar:

        def finished(number: int, done: Done) -> None:
            ends.take(number, done)
            if done.failure:
                failures[number] = done.failure

        outcome = pool.work(tasks, wanted.solvers, finished, bar.update)
    outcome.failures = dict(sorted((outcome.failures | failures).items()))
    return outcome


def _done_before(run: Run) -> Done | None:
    """Read the end of a run that is done with all its files, or return None."""
    try:
        record = run_record.read(run.folder)
    except FolderError:  # its task names the fault
        return None
    summary = run.folder / SUMMARY
    files = [run.folder / batch.RESULT, run.folder / "signal.wav", summary]
    if record is None or record.state != "done" or not all(path.is_file() for path in files):
        return None
    numbers = json.loads(summary.read_text(encoding="utf-8"))
    numbers.pop("provenance", None)  # which a run of a large sweep has nowhere else
    return Done(numbers, True, True)


def _hear(runs: Sequence[Run], names: Sequence[str], ends: Ends, whole: bool) -> None:
    """Make the sound of the runs that are in the folder alone, for pictures.

    Pictures of each run, in whole folders, need all of its result.
    """
    silent = [k for k in range(len(runs)) if ends.summaries[k] and ends.sounds[k] is None]
    with progress.bar(len(silent), "sound") as bar:
        for k in silent:
            run = with_chosen_tolerance(runs[k])
            result = batch.stored(run)
            heard = hear(names[k], run.values, run.folder, run.scene, result) if result else None
            ends.sounds[k] = whole_runs.light(heard) if heard and not whole else heard
            bar.update(1)
