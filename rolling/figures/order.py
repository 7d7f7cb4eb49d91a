"""Whether the runs of a picture have an order, so that their colours can show it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from rolling.simulation.run_result import RunResult
from rolling.simulation.seed_statistics import SEED


def is_ordered(runs: Sequence[RunResult]) -> bool:
    """Return whether runs differ in one swept number, other than the seed, that ascends."""
    keys = {tuple(run.values) for run in runs}
    if len(keys) != 1 or len(key := keys.pop()) != 1 or key == (SEED,):
        return False
    values = [run.values[key[0]] for run in runs]
    numbers = [v for v in values if isinstance(v, int | float) and not isinstance(v, bool)]
    return len(numbers) == len(values) and all(a < b for a, b in pairwise(numbers))
