"""Digests of the series of all scenes, to see which numbers a change of the program changes.

`python tests/benchmarks/frozen_series.py write FILE [SCENE...]` simulates every run of all scenes,
or of some, shortened to at most SHORTENED_S seconds of rolling. It writes a digest of each series,
and word and decibels of each verdict. `... compare FILE` does so again and prints what differs; it
exits with 1 if a series does. All scenes take an hour of two cores.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

import rolling as rc
from rolling.scene import library
from rolling.scene.bearing_file import is_bearing_file

SHORTENED_S = 0.03
SKIPPED = {"measured-surface"}  # its heights are made by a command that the scene names


def shortened(scene: rc.Scene) -> rc.Scene:
    """Return a scene that rolls for at most SHORTENED_S."""
    if scene.rolling.duration_s is not None and scene.rolling.duration_s > SHORTENED_S:
        return scene.with_({"rolling.duration_s": SHORTENED_S})
    return scene


def digests(run: rc.Run) -> dict[str, str]:
    """Return the digest of the bytes of each series of a run, and its verdict."""
    found = {
        name: hashlib.sha256(np.ascontiguousarray(values).tobytes()).hexdigest()[:16]
        for name, values in run.series.items()
        if name != "seconds" and not name.endswith("_time")
    }
    verdict = run.summary["verdict"] or {}
    found["verdict"] = str(verdict.get("word"))
    found["verdict_db"] = repr(verdict.get("decibels"))
    found["laeq_db"] = repr(run.summary.get("laeq_db"))
    return found


def frozen(names: Sequence[str]) -> dict[str, Any]:
    """Simulate every run of the scenes of these names, or of all, and return its digests."""
    table: dict[str, Any] = {}
    for name, path in sorted(library.scenes().items()):
        if names and name not in names:
            continue
        if (
            is_bearing_file(path)
            or name in SKIPPED
            or (name.startswith("lee2025") and "as-stated" not in name)
        ):
            continue  # the other readings of the article differ in numbers of the plate only
        scene = rc.read_scene(path)
        for number, part in enumerate(scene.runs()):
            label = f"{name}/{number}"
            try:
                run = rc.simulate(shortened(part.scene), workers=2, progress=False)
                table[label] = digests(run)
            except (rc.ContactError, rc.SceneError) as error:
                table[label] = {"error": str(error)}
            print(label, table[label].get("laeq_db"), file=sys.stderr, flush=True)
    return table


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the digests, or compare them with those of a file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("action", choices=["write", "compare"])
    parser.add_argument("file", type=Path)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="names of scenes (all)")
    given = parser.parse_args(arguments)
    now = frozen(given.scenes)
    if given.action == "write":
        given.file.write_text(json.dumps(now, indent=1), encoding="utf-8")
        return 0
    before = json.loads(given.file.read_text(encoding="utf-8"))
    if given.scenes:
        before = {label: old for label, old in before.items() if label in now}
    changed = 0
    for label in sorted(before.keys() | now.keys()):
        old = before.get(label, {})
        new = now.get(label, {})
        for series in sorted(old.keys() | new.keys()):
            if old.get(series) != new.get(series):
                print(f"{label}: {series}: {old.get(series)} -> {new.get(series)}")
                changed += series not in ("verdict", "verdict_db", "laeq_db")
    print(f"{len(now)} runs, {changed} series changed")
    return int(changed > 0)


if __name__ == "__main__":
    sys.exit(main())
