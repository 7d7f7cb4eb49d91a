"""Answer of runs as the terminal prints it first."""

from __future__ import annotations

from collections.abc import Sequence

from rolling.kinds.registry import kind_of
from rolling.kinds.run_folder import TABLE, RunFolder
from rolling.terminal import defaults


def print_answers(done: Sequence[RunFolder]) -> Sequence[RunFolder]:
    """Print sentence, table and conclusion of runs, only the first of very many; return these."""
    shown = done
    if len(done) > defaults.MAX_RUNS_COMPARED:
        shown = done[: defaults.FEW_RUNS]
    print("\n".join(kind_of(shown[0].scene).answer_lines(shown)))
    if len(done) > len(shown):
        print(f"{len(done) - len(shown)} more runs, a row each in {TABLE}")
    print()
    return shown
