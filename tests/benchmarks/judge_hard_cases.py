"""The solver on 3,603 hard scenes: `python tests/benchmarks/judge_hard_cases.py` judges it.

The command prints a table in Markdown with the violations, and exits with 1 if there is any. It
takes about a minute of computing time.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict

import pandas as pd
from hard_cases.judge import CONDITIONS, FAILED, Outcome, judge
from hard_cases.named_cases import CASES, SOLVED, HardCase, laps
from hard_cases.random_cases import GENERATORS, found_cases, random_case
from tqdm import tqdm

RANDOM = 2000  # random scenes
SHARE = 4  # of random scenes over those of each other generator
LONG_STEPS = 100_000

Task = HardCase | tuple[str, int]  # a case, or the generator and the seed of one


def judge_task(task: Task) -> Outcome:
    """Judge a case, or the random scene of a generator and a seed."""
    return judge(task if isinstance(task, HardCase) else random_case(*task))


def tasks(random: int, long: bool = False) -> list[Task]:
    """List the named cases, the failures of earlier searches, and scenes of each generator."""
    counts = {name: random if name == "random" else random // SHARE for name in GENERATORS}
    return [
        *CASES,
        *found_cases(),
        *([laps(-(-LONG_STEPS // 30))] if long else []),
        *((name, seed) for name, count in counts.items() for seed in range(count)),
    ]


def report(outcomes: Sequence[Outcome]) -> str:
    """Write the conditions, the counts by group and plate, the iterations and the violations."""
    frame = pd.DataFrame([asdict(outcome) for outcome in outcomes])
    counts = pd.crosstab([frame.group, frame.plate], frame.result, margins=True, margins_name="all")
    solved = frame[frame.result == SOLVED].iterations.map(max)
    lines = [f"- {condition}" for condition in CONDITIONS]
    lines += ["", counts.to_string(), ""]
    lines += [f"iterations: 95 % of the solved scenes at most {solved.quantile(0.95):.0f}, all at"]
    lines[-1] += f" most {solved.max():.0f}"
    lines += [f"violations: {int((frame.result == FAILED).sum())}"]
    return "\n".join(
        lines + [f"- {o.name}: {'; '.join(o.violations[:3])}" for o in outcomes if o.violations]
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Judge all scenes, print the report, and return 1 if there is a violation."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--random", type=int, default=RANDOM, help=f"random scenes ({RANDOM})")
    parser.add_argument("--long", action="store_true", help=f"add a march of {LONG_STEPS} steps")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="processes")
    given = parser.parse_args(arguments)
    scenes = tasks(given.random, given.long)
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(given.workers, context) as pool:
        outcomes = list(tqdm(pool.map(judge_task, scenes, chunksize=8), total=len(scenes)))
    print(report(outcomes))
    return int(any(outcome.violations for outcome in outcomes))


if __name__ == "__main__":
    sys.exit(main())
