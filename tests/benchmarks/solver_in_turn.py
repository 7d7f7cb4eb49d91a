"""Processor time of a step by two versions of the program, in turn: did a change of the solver pay?

    python tests/benchmarks/solver_in_turn.py OLD NEW [--rounds 5] [--steps 60]

OLD and NEW are interpreters of environments that hold a version each, from 0.5.1 on. The contacts
are the light ones of the quickstart and the sequences that public solvers are given, with the same
heights for both. Each version marches all of them in a process of its own, one after the other, in
each round. A position counts by its fastest round, and a contact by the mean of its positions
without the cold start, so that transforms of new sizes are part of it. Both versions compile once
before. It takes one to two minutes with one thread, in which nothing else should run.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

LOADS = (1, 5, 20)  # [N] of the quickstart
SEQUENCES = ("A", "B", "C", "D", "I", "L")
TOLERANCE = 5e-6  # of the sequences, as `speed.py` compares them with public solvers
FIELDS = (
    *("spacing", "radius", "contact_modulus", "hardness", "load", "step", "start", "tolerance"),
    *("single", "blended", "subcells", "slopes"),
)


def write_contacts(folder: Path) -> None:
    """Write the heights and numbers of all contacts into a folder."""
    from against_peers import sequence_track

    from rolling.in_si.contact_of_scene import rolling_contact
    from rolling.kinds.reading import read_scene

    contacts = {}
    for load in LOADS:
        words = ["sweep=", f"rolling.load_n={load}", "rolling.duration_s=0.01"]
        contacts[f"quickstart, {load} N"] = rolling_contact(read_scene("quickstart", words))
    for name in SEQUENCES:
        contacts[f"sequence {name}"] = sequence_track(name, TOLERANCE)
    for name, contact in contacts.items():
        np.save(folder / f"{name}.npy", contact.heights)
        numbers = {field: getattr(contact, field) for field in FIELDS}
        (folder / f"{name}.json").write_text(json.dumps(numbers))


def march_all(folder: Path, steps: int) -> dict[str, list[float]]:
    """March all contacts of a folder; return the milliseconds of each position but the first."""
    import rolling

    found = {}
    for path in sorted(folder.glob("*.json")):
        numbers: dict[str, Any] = json.loads(path.read_text())
        heights = np.load(path.with_suffix(".npy"))
        contact = rolling.RollingContact(heights=heights, **numbers)
        half_space = rolling.HalfSpace(contact.spacing, contact.contact_modulus)
        clock = []
        for _ in rolling.march(contact, 0, steps, half_space):
            clock.append(time.process_time())
        found[path.stem] = [1e3 * seconds for seconds in np.diff(clock)]
    return found


def marched_by(python: str, folder: Path, steps: int) -> dict[str, list[float]]:
    """March all contacts in a process of another interpreter."""
    threads = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    command = [python, "-P", __file__, "--march", str(folder), "--steps", str(steps)]
    done = subprocess.run(
        command,
        check=True,
        stdout=subprocess.PIPE,
        env=environment | dict.fromkeys(threads, "1"),
        cwd=folder,
    )
    found: dict[str, list[float]] = json.loads(done.stdout)
    return found


def main() -> None:
    """Compare two versions, or march for one."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("pythons", nargs="*", metavar="PYTHON", help="of the old and the new one")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--steps", type=int, default=60)
    parser.add_argument("--march", type=Path, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.march:
        print(json.dumps(march_all(given.march, given.steps)))
        return
    if len(given.pythons) != 2:
        parser.error("two interpreters are needed, of the old and the new version")
    pythons = []
    for python in given.pythons:
        found = shutil.which(python)
        if found is None:
            parser.error(f"{python}: got no interpreter, allowed: path or name of one")
        pythons.append(str(Path(found).absolute()))  # the march begins in another folder
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_contacts(folder)
        for python in pythons:
            marched_by(python, folder, 3)  # compiles
        rounds = [
            [marched_by(python, folder, given.steps) for python in pythons]
            for _ in range(given.rounds)
        ]
    print("|contact|old, ms|new, ms|old over new|\n|---|---|---|---|")
    for contact in rounds[0][0]:
        old, new = (
            float(np.mean(np.min([both[version][contact] for both in rounds], axis=0)))
            for version in (0, 1)
        )
        print(f"|{contact}|{old:.2f}|{new:.2f}|{old / new:.2f}|")


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parent))
    main()
