"""Parts of a sweep, for array jobs: each command does its share of the runs, in any order.

The first command makes the folder. The last one that ends writes table, figures and page.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rolling.commands import run_tasks
from rolling.commands.run_files import Wanted
from rolling.commands.whole_runs import SOLVED
from rolling.commands.work import Report, Work, finish, make_sounds, told_on_error
from rolling.folders import claim, new_folder, run_record, status
from rolling.folders.files import FolderError
from rolling.scene import library
from rolling.scene.scene import Scene
from rolling.simulation import batch, labels
from rolling.simulation.batch import Run
from rolling.simulation.plan import Plan
from rolling.simulation.pool import Outcome
from rolling.simulation.result import Result
from rolling.simulation.stored_runs import read_runs, resolved_scene
from rolling.terminal import progress


@dataclass(frozen=True)
class Part:
    """A share of the runs of a sweep: every `count`-th run, from run `number` on.

    number, count : int. From 1/1 to n/n.
    """

    number: int
    count: int

    @property
    def name(self) -> str:
        """The name of its folder."""
        return f"{self.number}-of-{self.count}"

    def __str__(self) -> str:
        return f"part {self.number}/{self.count}"

    def numbers(self, runs: int) -> range:
        """Return the numbers of its runs, from 0."""
        return range(self.number - 1, runs, self.count)


def do_part(
    scene: Scene, scene_path: Path, out: Path, part: Part, wanted: Wanted, take_over: bool
) -> Report:
    """Do the share of a sweep in a folder that other commands share.

    Parameters
    ----------
    scene : Scene. The scene, which was not refused.
    scene_path : Path. Its file.
    out : Path. The folder, which the first command makes.
    part : Part. The share.
    wanted : Wanted. The files that are requested.
    take_over : bool. Whether claims that cannot be judged from here are ignored.

    Raises
    ------
    FolderError : the folder holds another scene, or another process works on these runs.
    """
    text = library.find(scene_path).read_bytes()
    plan = Plan(scene, text, wanted.whole_folders(len(scene.runs())))
    new_folder.make_shared(out, plan.record(), plan.write)
    _refuse_other_scene(out, batch.seen_from(out, scene))
    runs = plan.runs(out)
    own = part.numbers(len(runs))
    with claim.take_part(out, part.name, [plan.names[k] for k in own], take_over) as held:
        wanted.begun(out)
        progress.line(f"{part}: {len(own)} of {len(runs)} runs")
        with told_on_error(out, lambda: f"the same command goes on with {part}"):
            outcome, ends = run_tasks.solve(held, runs, wanted, take_over, own)
        failed = f"{len(outcome.failures)} of {len(own)} runs" if outcome.failures else None
        held.end(outcome.interrupted, failed)
    last = not outcome.interrupted and _is_last(out)
    if last and (report := _finished(out, wanted)) is not None:
        return report
    return _report(out, runs, own, ends.summaries, outcome)


def _report(
    folder: Path,
    runs: Sequence[Run],
    own: Sequence[int],
    summaries: Sequence[dict[str, Any] | None],
    outcome: Outcome,
) -> Report:
    """Report the runs of a part."""
    names = labels.labels(runs)
    return Report(
        folder,
        [(runs[k], summaries[k]) for k in own],
        {names[k]: reason for k, reason in outcome.failures.items()},
        outcome.interrupted,
        None,
        any(summaries[k] for k in own),
        None,
    )


def _is_last(folder: Path) -> bool:
    """Tell whether no run of an unfinished sweep is left."""
    record = run_record.read(folder)
    if record is None or record.state == "done":
        return False
    return all(
        each.state in ("done", "failed") or each.remark.startswith(SOLVED)
        for each in status.statuses(folder)
    )


def _finished(folder: Path, wanted: Wanted) -> Report | None:
    """Write table, figures and page of a sweep whose runs have all been done or have failed.

    Return None where another command does it.
    """
    runs = read_runs(folder)  # with the tolerances that were chosen meanwhile
    failures = {
        k: record.reason or "failed"
        for k, run in enumerate(runs)
        if (record := run_record.read(run.folder)) is not None and record.state == "failed"
    }
    try:
        claimed = claim.take(folder, "sweep", [run.folder.name for run in runs])
    except FolderError as error:
        progress.line(f"not finished here: {error}")
        return None
    with claimed as held:
        progress.line(f"that was the last run of {folder}; its table and figures follow")
        if not wanted.whole_folders(len(runs)):
            ends = run_tasks.gather(runs, wanted)
            return finish(Work(held, runs, [], wanted), ends, Outcome(failures))
        results = [
            batch.stored(run) or Result.empty(run.scene.track, run.scene.start) for run in runs
        ]
        work = Work(held, runs, results, wanted)
        outcome = Outcome(failures)
        return finish(work, make_sounds(work, {}, outcome), outcome)


def _refuse_other_scene(folder: Path, scene: Scene) -> None:
    """Raise FolderError if a folder holds another scene."""
    there, here = resolved_scene(folder).to_dict(), scene.to_dict()
    for key in {**there, **here}:
        if there.get(key) != here.get(key):
            raise FolderError(
                f"{folder}: holds another scene, which differs in {key}; all parts of a sweep need"
                " the same scene, or take another --out"
            )
    read_runs(folder)
