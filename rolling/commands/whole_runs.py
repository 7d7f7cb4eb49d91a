"""Whole runs as tasks: a process solves a run, makes its sound and writes its files itself.

The process that has the folder gets a few numbers back. Runs of large sweeps are done this way.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from rolling.commands.run_files import write_run
from rolling.contact.solver import ContactError
from rolling.folders import claim, files
from rolling.folders.claim import Claim
from rolling.folders.files import FolderError, Keeper, Unwritable
from rolling.scene.messages import SceneError
from rolling.simulation import batch, chosen_tolerances, error_stretches, solving
from rolling.simulation.batch import Run
from rolling.simulation.pool import Interrupted
from rolling.simulation.result import Result
from rolling.simulation.run_result import RunResult, hear
from rolling.simulation.stored_runs import is_begun, with_chosen_tolerance

SOLVED = "solved; its pictures follow"


@dataclass(frozen=True)
class Order:
    """A run to be done by any process.

    run : Run. Values, scene and folder.
    label : str. The label that distinguishes the run from the other runs.
    whole : bool. Whether all files are written, not four only.
    heard : bool. Whether the run is returned with its sound, for pictures.
    take_over : bool. Whether a claim that cannot be judged from here is ignored.
    """

    run: Run
    label: str
    whole: bool
    heard: bool
    take_over: bool = False


@dataclass(frozen=True)
class Done:
    """The end of a run.

    summary : dict. The numbers of summary.json; None where too few steps are solved.
    complete : bool. Whether all of it is solved.
    begun : bool. Whether any step is solved.
    failure : str. The reason why the run failed; None otherwise.
    heard : RunResult. The run with its sound and without its maps, where the order asks for it.
    """

    summary: dict[str, Any] | None
    complete: bool
    begun: bool
    failure: str | None = None
    heard: RunResult | None = None


def do_run(order: Order, stopped: Callable[[], bool], progress: Callable[[float], object]) -> Done:
    """Solve the missing steps of a run, make its sound, and write its files and states.

    A run that another process works on, or whose folder has another scene or cannot be written,
    has failed.

    Raises
    ------
    OSError : no file can be written, in the folder of the run or beside it.
    """
    folder = order.run.folder
    try:
        with files.writing(folder), claim.take_run(folder, order.take_over) as held:
            return _do_claimed(order, held, stopped, progress)
    except Unwritable as error:
        if error.everywhere:
            raise
        return Done(None, False, False, str(error))
    except (FolderError, SceneError) as error:
        return Done(None, False, False, str(error))


def light(run: RunResult) -> RunResult:
    """Return a run with its sound and release only, which the pictures of many runs show."""
    series = {"release_energy": run.result.series["release_energy"]}
    result = replace(
        run.result, series=series, maps={}, event_pieces={}, snapshot=None, stretches=None
    )
    return replace(run, result=result, writer=None)


def _do_claimed(
    order: Order, held: Claim, stopped: Callable[[], bool], progress: Callable[[float], object]
) -> Done:
    """Do a run that this process has claimed."""
    run = with_chosen_tolerance(order.run)
    result = chosen_tolerances.stored_or_empty(run)
    try:
        run = chosen_tolerances.choose_tolerance(run, result, stopped, held.note_trial)
    except Interrupted:
        held.mark(run.folder, "waiting", claim.INTERRUPTED)
        return Done(None, False, False)
    order = replace(order, run=run)
    failure = _solve(run, result, stopped, progress) or batch.other_surface(run, result)
    finished = None if failure and batch.other_surface(run, result) else _hear(order, result)
    if finished is not None:
        write_run(finished, result, order.whole)
    elif is_begun(result):
        batch.keep(run, result)
    complete = result.complete and not error_stretches.missing(run.scene, result)
    if failure:
        held.mark(run.folder, "failed", failure)
    elif complete and not order.whole:
        held.mark(run.folder, "done")
    else:
        held.mark(run.folder, "waiting", SOLVED if complete else claim.INTERRUPTED)
    return Done(
        finished.summary if finished else None,
        complete,
        is_begun(result),
        failure,
        light(finished) if finished and order.heard else None,
    )


def _hear(order: Order, result: Result) -> RunResult | None:
    run = order.run
    return hear(order.label, run.values, run.folder, run.scene, result)


def _solve(
    run: Run, result: Result, stopped: Callable[[], bool], progress: Callable[[float], object]
) -> str | None:
    """Solve the missing steps of a run in this process; return the reason of a failure.

    A result of several pieces is kept as it grows.
    """
    keeper = Keeper()

    def added() -> None:
        if not result.complete and keeper.due():
            start = time.monotonic()
            batch.keep(run, result)
            keeper.wrote(time.monotonic() - start)

    try:
        batch.identify(run, result)
        solving.solve_here(run.scene, result, stopped, progress, added)
    except (ContactError, MemoryError) as error:
        return str(error) or "not enough memory"
    except Interrupted:
        pass
    return None
