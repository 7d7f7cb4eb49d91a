"""The end of a command, which compares its runs: with the runs and processes that it still has."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import BrokenExecutor
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from rolling.run.kept_runs import KeptRuns
from rolling.run.pools import Pool, Task


class Ending(ExitStack):
    """Runs that a command has heard, and the processes that made them, used as a context.

    folder : Path. The run folder.
    kept : KeptRuns. Runs that the command has heard.
    pool : Pool. The processes of this machine, once some have solved; None without.
    first_page : function. It writes a page of pilots in a process; None without a page.
    prepare_page : function. It makes in a process what the page shows of a run alone; None without
        a page.
    """

    pool: Pool | None = None
    first_page: Callable[..., Any] | None = None
    prepare_page: Callable[..., Any] | None = None

    def __init__(self, folder: Path) -> None:
        super().__init__()
        self.folder = folder
        self.kept = KeptRuns(folder)

    def __enter__(self) -> Self:
        """Begin a command."""
        super().__enter__()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> bool:
        """End the processes, and remove the files of the runs."""
        handled = super().__exit__(kind, error, trace)
        self.kept.remove()
        return bool(handled)

    def each(self, function: Callable[..., Any], calls: Sequence[tuple[Any, ...]]) -> list[Any]:
        """Call a function of a module with some arguments each, on all processes; return values.

        The values must be small. What a process that was killed had in hand is done here.
        """
        pool = self.pool
        if pool is None or sum(pool.teams.values()) < 2 or len(calls) < 2:
            return [function(*arguments) for arguments in calls]
        teams = list(pool.teams)
        values = []
        try:
            futures = []
            for number, arguments in enumerate(calls):
                task = Task(("end", str(number)), function, arguments)
                futures.append(pool.submit(task, teams[number % len(teams)]))
            for future in futures:
                values.append(future.result())
        except BrokenExecutor:
            self.pool = None
            values += [function(*arguments) for arguments in calls[len(values) :]]
        return values
