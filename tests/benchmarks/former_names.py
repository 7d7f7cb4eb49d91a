"""Whether the flat names of version 0.8 have the same values as in a checkout of that version.

`python tests/benchmarks/former_names.py CHECKOUT [RUN...]` simulates runs of frozen_scenes.toml,
all of them or those of some names, with the program of the checkout and with this one. It compares
the summary of the former with `former_names` of the latter, value by value and to the last bit. It
prints each difference that EXPECTED does not explain, and exits with 1 if there is one. CHECKOUT is
a folder with a working tree, such as that of `git worktree add CHECKOUT v0.8.1`.
"""

from __future__ import annotations

import argparse
import math
import os
import pickle
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
SCENES = HERE / "frozen_scenes.toml"
EXPECTED = {
    "answer": "stands in the quantities now",
    "verdict": "stands in the quantities now",
    "laeq_uncertainty_db": "was unknown where grid and solver are; is the ± of the level now",
    "laeq_uncertainty_parts_db": "had parts that are unknown, which are left out now",
    "third_octave_uncertainty_db": "has all parts now, that of the force law among them",
    "doubts": "has the doubts about an estimated vibration, too, and other words for ±",
}
TIMED = ("parts_cpu_s", "march_cpu_s", "step_ms")  # processor times

# Both programs make the scene and the run by this text.
_PROGRAM = """
import pickle, sys
import rolling as rc
words = pickle.load(sys.stdin.buffer)
run = rc.simulate(rc.read_scene(words[0], words[1:]), workers=1, progress=False)
if hasattr(run, "numbers"):
    from rolling.results.former_numbers import former_names
    summary = former_names(run.numbers)
else:
    summary = run.summary
pickle.dump(dict(summary), sys.stdout.buffer)
"""


def summary_of(checkout: Path, words: Sequence[str]) -> dict[str, Any]:
    """Return the numbers of a run by their flat names, of the program in a checkout."""
    environment = {**os.environ, "PYTHONPATH": str(checkout)}
    done = subprocess.run(
        [sys.executable, "-c", _PROGRAM],
        input=pickle.dumps(list(words)),
        stdout=subprocess.PIPE,
        env=environment,
        cwd=checkout,
        check=False,
    )
    if done.returncode:
        return {"fault": f"no run in {checkout}"}
    summary: dict[str, Any] = pickle.loads(done.stdout)
    return summary


def differences(before: Any, after: Any, path: str = "") -> Iterator[str]:
    """Yield where two values differ, at any depth, to the last bit."""
    if isinstance(before, Mapping) and isinstance(after, Mapping):
        for name in [*before, *(name for name in after if name not in before)]:
            place = f"{path}.{name}" if path else str(name)
            if name not in after:
                yield f"{place}: {before[name]!r} -> missing"
            elif name not in before:
                yield f"{place}: missing -> {after[name]!r}"
            else:
                yield from differences(before[name], after[name], place)
    elif isinstance(before, list | tuple) and isinstance(after, list | tuple):
        if len(before) != len(after):
            yield f"{path}: {len(before)} -> {len(after)} entries"
        for number, (one, other) in enumerate(zip(before, after, strict=False)):
            yield from differences(one, other, f"{path}[{number}]")
    elif type(before) is not type(after) or not _are_same(before, after):
        yield f"{path}: {before!r} -> {after!r}"


def _are_same(one: Any, other: Any) -> bool:
    """Tell whether two values of one type are equal, or both NaN."""
    if isinstance(one, float) and math.isnan(one):
        return math.isnan(other)
    return bool(one == other)


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare the numbers of runs, and print what differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("checkout", type=Path)
    parser.add_argument("runs", nargs="*", metavar="RUN", help="names of runs (all)")
    parser.add_argument("--scenes", type=Path, default=SCENES, help="table of scenes and words")
    given = parser.parse_args(arguments)
    scenes = tomllib.loads(given.scenes.read_text(encoding="utf-8"))["runs"]
    unexplained = 0
    for name in given.runs or scenes:
        words = [scenes[name]["scene"], *scenes[name]["words"]]
        before = summary_of(given.checkout.resolve(), words)
        after = summary_of(HERE.parents[1], words)
        for text in differences(before, after):
            key = text.split(":")[0].split(".")[0].split("[")[0]
            if key not in (*EXPECTED, *TIMED):
                print(f"{name}: {text}", flush=True)
                unexplained += 1
        print(f"{name}: {len(before)} names", file=sys.stderr, flush=True)
    for key, reason in EXPECTED.items():
        print(f"not compared: {key} {reason}", file=sys.stderr)
    return int(unexplained > 0)


if __name__ == "__main__":
    sys.exit(main())
