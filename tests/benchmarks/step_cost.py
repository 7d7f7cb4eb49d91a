"""Time and memory of a step over nodes in contact, steps of a track and workers, beside peers.

    python tests/benchmarks/step_cost.py [FOLDER]

FOLDER has the environments of aspher and slippy, as README.md beside this script makes them; one
that is absent keeps its results with their date. The script marches spheres over plates under loads
from 0.03 to 10,000 N, gives some of these contacts to the public solvers, and rolls tracks of three
lengths, the longest on one worker and on two. It writes step_cost.json beside itself, from which
`python docs/_hooks/pictures.py --write growth` draws. Processor time counts, of one thread in each
process. It takes three to four minutes; `--quick` stops at 100 N, takes one, and needs another
`--out`.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

if __name__ == "__main__":
    pinned = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
    os.environ.update(dict.fromkeys(pinned, "1"))

import numpy as np
from against_peers import Solved, peak_memory
from hard_problems import hard_problem
from speed import answer, in_fresh_process, machine
from speed_against_error import (
    OURS,
    PEERS,
    SOLVED_GAP,
    SOLVED_LOAD,
    Contest,
    Points,
    solved_ms,
    version_of,
)

from rolling import __version__
from rolling.check import cost
from rolling.contact._transform_kernels import deflect_nodes, nodes_kernel
from rolling.contact.half_space import HalfSpace
from rolling.contact.march import march
from rolling.contact.recovery import step_energy
from rolling.contact.state import ContactState
from rolling.contact.subcells import half_space_of
from rolling.in_si.contact_of_scene import rolling_contact
from rolling.kinds.reading import read_scene
from rolling.scene.scene import Scene

HERE = Path(__file__).parent
STORED = Path(__file__).with_suffix(".json")
QUICKSTART = HERE.parent.parent / "scenarios" / "quickstart.yaml"
LOADS = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0, 10_000.0)  # [N]
QUICK_LOAD = 100.0
QUICK_STEPS = 400
FEWEST = 20  # nodes in contact: fewer are no contact whose growth can be seen
ELASTIC = "plate.hardness_gpa=null"
SHARP = "numerics.edges=sharp"
WHOLE = (SHARP, "numerics.subcells=1")
ELASTIC_ROUGH = "elastic, Ra 0.1 µm"
YIELDING_ROUGH = "yielding, Ra 0.1 µm, sharp edges"
KINDS = {
    "elastic, smooth": (ELASTIC, "surface.roughness_ra_um=0.0001", *WHOLE),
    ELASTIC_ROUGH: (ELASTIC, *WHOLE),
    YIELDING_ROUGH: WHOLE,
    "yielding, Ra 1 µm, sharp edges": ("surface.roughness_ra_um=1", *WHOLE),
    "yielding, Ra 0.1 µm, blended edges": ("numerics.subcells=1",),
}
FIRST = 2  # steps that a trend does not lead yet
PEER_STEPS = (4, 12)  # fewest and most
PEER_SECONDS = 60.0  # of processor time of a program for all tolerances of a contact
TRACKS = ((200, 1), (1000, 1), (5000, 1), (5000, 2))  # steps and workers


@dataclass(frozen=True)
class Rival:
    """A public solver, and the contacts that it solves in turn with this program.

    name : str. Name of its environment and of its script.
    kind : str. Key of KINDS.
    loads : tuple of float. [N], for about 100 to 100,000 nodes in contact.
    """

    name: str
    kind: str
    loads: tuple[float, ...]


RIVALS = (
    Rival("aspher", ELASTIC_ROUGH, (0.5, 8.0, 80.0, 800.0, 3500.0)),
    Rival("slippy", YIELDING_ROUGH, (0.5, 8.0, 80.0, 900.0)),
)


@dataclass(frozen=True)
class Cost:
    """Measured steps of one kind under one load.

    Parameters
    ----------
    load : float, N
    in_contact : float
        Nodes in contact: the contact area over that of a node, mean of the steps.
    width : float
        Geometric mean of rows and columns of the windows.
    ms, convolutions : float
        CPU time of a step with its release, lower quartile, and convolutions per step.
    bare_ms : float
        Milliseconds of so many bare convolutions, one of them in double precision.
    memory_mb : float or None
        What the march takes at most, its cold start included; None where the system is not Linux.
    """

    load: float
    in_contact: float
    width: float
    ms: float
    convolutions: float
    bare_ms: float
    memory_mb: float | None


@dataclass(frozen=True)
class PeerCost:
    """Times of a step of a public solver and of this program, at the same error of the gap.

    Parameters
    ----------
    load : float, N
    in_contact : float
        Nodes in contact.
    side : int
        Nodes on a side of the grid of the public solver: the smallest square around the contact
        whose transforms are fast.
    ms, own_ms : float or None
        CPU time of a step of the public solver and of this program, each at the fastest of its
        tolerances that solves the contact; None if none does.
    tolerance, own_tolerance : float or None
        Those tolerances, each by the program's own measure.
    memory_mb, own_memory_mb : float or None
        What each takes at most beyond the problem, at any of its tolerances.
    """

    load: float
    in_contact: float
    side: int
    ms: float | None
    own_ms: float | None
    tolerance: float | None
    own_tolerance: float | None
    memory_mb: float | None
    own_memory_mb: float | None


# ---- steps of this program


def scene_of(kind: str, load: float) -> Scene:
    """Return the scene of a kind under a load [N], with a plate that its window does not fill."""

    def on_nodes(nodes: int) -> Scene:
        """Return the scene on a plate of so many nodes along and across."""
        long = f"rolling.duration_s={nodes * 2e-6 / 0.1:g}"
        across = f"surface.width_um={nodes * 2}"
        pinned = ["numerics.tolerance=1e-4", "numerics.step_nodes=1"]
        pinned += ["numerics.error_estimate=false", f"rolling.load_n={load:g}"]
        return read_scene(QUICKSTART, [*KINDS[kind], *pinned, across, long]).runs()[0][1]

    width = window_nodes(on_nodes(4096))
    return on_nodes(1 << int(np.ceil(np.log2(max(256, 1.3 * width)))))


def window_nodes(scene: Scene) -> float:
    """Estimate the nodes on a side of the window of a scene."""
    return cost.window_nodes(scene, cost.roughness(scene)[0])


def measure(kind: str, load: float) -> Cost:
    """Measure a march of a few steps."""
    scene = scene_of(kind, load)
    contact = rolling_contact(scene)
    half_space = half_space_of(contact.spacing, contact.contact_modulus, contact.subcells)
    steps = int(np.clip(4000 / window_nodes(scene), 5, 40))
    states: list[ContactState] = []
    clock = []
    areas = []
    resident = peak_memory(afresh=True)
    for state in march(contact, 0, FIRST + steps, half_space):
        if states:
            step_energy(states[-1], state, half_space)
        states = [*states[-1:], state]
        clock.append((time.thread_time(), state.convolutions, state.window))
        areas.append(state.contact_area)
    memory = None if resident is None else (peak_memory() - resident) / 1e6
    seconds = np.diff([t for t, *_ in clock])[FIRST:]
    counts = np.mean([count for _, count, _ in clock[1 + FIRST :]])
    windows = [window for *_, window in clock[1 + FIRST :]]
    wide = float(np.mean([np.sqrt(w.rows * w.columns) for w in windows]))
    block = states[-1].loaded
    bare = bare_seconds(half_space, (windows[-1].rows, windows[-1].columns), False)
    bare += (counts - 1) * bare_seconds(half_space, (block.rows, block.columns), True)
    return Cost(
        load=load,
        in_contact=float(np.mean(areas[1 + FIRST :])) / contact.spacing**2,
        width=wide,
        ms=1e3 * float(np.quantile(seconds, 0.25)),
        convolutions=float(counts),
        bare_ms=1e3 * float(bare),
        memory_mb=memory,
    )


def bare_seconds(half_space: HalfSpace, nodes: tuple[int, int], single: bool) -> float:
    """Return the seconds of the transforms of a block of so many rows and columns of nodes."""
    transforms = half_space.convolution(nodes[0] - 1, nodes[1] - 1, single=single)
    entry = transforms.planned_entry(nodes[0])
    kernel, nothing = nodes_kernel(1, single), np.empty(0)
    block, listed = (0, 0, *nodes), (np.empty(0, np.uint32), np.empty(0, np.int64))
    taken = []
    for _ in range(9):
        began = time.thread_time()
        deflect_nodes(kernel, entry, block, nothing, 1.0, nothing, listed)
        taken.append(time.thread_time() - began)
    return float(np.min(taken))


def measure_kinds(most: float) -> dict[str, list[dict[str, Any]]]:
    """Return the costs of all kinds under loads of so many newtons at most."""
    costs: dict[str, list[dict[str, Any]]] = {kind: [] for kind in KINDS}
    for kind, of_kind in costs.items():
        for load in LOADS:
            if load > most:
                continue
            measured = measure(kind, load)
            _say(f"{kind}: {measured}")
            if measured.in_contact >= FEWEST:
                of_kind.append(asdict(measured))
    return costs


# ---- the public solvers


def measure_rival(rival: Rival, python: Path, most: float) -> list[dict[str, Any]]:
    """Return the costs of a public solver and of this program on the contacts of a rival."""
    contest = Contest({rival.name: python}, rounds=1)
    costs = []
    for load in rival.loads:
        if load > most:
            continue
        scene = scene_of(rival.kind, load)
        steps = int(np.clip(1200 / window_nodes(scene), *PEER_STEPS))
        shared = hard_problem(rolling_contact(scene), 0, steps, is_fast=True)
        curves = contest.curves({rival.kind: shared}, PEER_SECONDS)
        theirs, own = (curves[program][rival.kind] for program in (rival.name, OURS))
        costs.append(
            PeerCost(
                load=load,
                in_contact=measure(rival.kind, load).in_contact,
                side=shared.problem.nodes,
                ms=solved_ms(theirs),
                own_ms=solved_ms(own),
                tolerance=_solving_tolerance(theirs),
                own_tolerance=_solving_tolerance(own),
                memory_mb=_memory_mb(theirs),
                own_memory_mb=_memory_mb(own),
            )
        )
        _say(f"{rival.name}: {costs[-1]}")
    return [asdict(each) for each in costs]


def _solving_tolerance(points: Points) -> float | None:
    """Return the tolerance of the point whose time `solved_ms` returns."""
    ms = solved_ms(points)
    return next((point.tolerance for point in points if solved_ms([point]) == ms), None)


def _memory_mb(points: Points) -> float | None:
    """Return the largest memory of solved points [MB]."""
    taken = [point.memory for point in points if isinstance(point, Solved)]
    known = [memory for memory in taken if memory is not None]
    return max(known) / 1e6 if known else None


# ---- tracks


def measure_tracks(is_quick: bool) -> list[dict[str, float]]:
    """Return wall and processor time of a step of whole tracks, without the start of workers."""
    tracks = []
    for steps, workers in TRACKS:
        run = answer(
            in_fresh_process("run", min(steps, QUICK_STEPS) if is_quick else steps, workers)
        )
        began = workers > 1  # one worker is the process itself, which has begun by then
        wall = run["seconds"] - began * run["start_up_s"]
        of_processors = run["cpu_s"] - began * run["start_up_cpu_s"]
        tracks.append(
            {
                "steps": run["steps"],
                "workers": workers,
                "wall_ms": 1e3 * wall / run["steps"],
                "cpu_ms": 1e3 * of_processors / run["steps"],
                "memory_mb": run["peak_bytes"] / 1e6,
                "march_mb": run["march_bytes"] / 1e6,
            }
        )
        _say(f"track: {tracks[-1]}")
    return tracks


# ---- what is stored


def _say(words: str) -> None:
    print(words, file=sys.stderr, flush=True)


def stored_text(content: Any) -> str:
    """Return the content of the file with four digits, and each measurement on a line."""

    def rounded(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: rounded(each) for key, each in value.items()}
        if isinstance(value, list):
            return [rounded(each) for each in value]
        return float(f"{value:.4g}") if isinstance(value, float) else value

    text = json.dumps(rounded(content), indent=1, ensure_ascii=False)
    one_line = re.compile(r"\{\s+([^{}\[\]]+?)\s+\}")
    return one_line.sub(lambda found: f"{{{' '.join(found[1].split())}}}", text) + "\n"


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure steps, public solvers and tracks, and write the file."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, nargs="?", help="environments of the public solvers")
    parser.add_argument("--quick", action="store_true", help="loads of up to 100 N, short tracks")
    parser.add_argument("--out", type=Path, default=STORED, help="default: %(default)s")
    parser.add_argument("--note", default="", help="what the reader has to know of the machine")
    given = parser.parse_args(arguments)
    if given.quick and given.out == STORED:
        parser.error("--quick measures too little to be kept: give another file with --out")
    here = machine()
    about = {
        "version": __version__,
        "date": datetime.now(UTC).date().isoformat(),
        "machine": {"cpu": here["cpu"], "cores": here["cores"], "note": given.note},
    }
    content: dict[str, Any] = {"peers": {}}
    if given.out.exists():
        content = json.loads(given.out.read_text(encoding="utf-8"))
    most = QUICK_LOAD if given.quick else max(LOADS)
    for kind in KINDS:
        measure(kind, LOADS[0])  # compiles
    content |= about | {"kinds": measure_kinds(most), "tracks": measure_tracks(given.quick)}
    content["solved"] = {"gap_error": SOLVED_GAP, "load_error": SOLVED_LOAD}
    given.out.write_text(stored_text(content), encoding="utf-8")
    packages = {peer.name: peer.package for peer in PEERS}
    for rival in RIVALS if given.folder else ():
        python = given.folder / rival.name / "bin" / "python"
        if not python.exists():
            continue
        content["peers"][rival.name] = {
            "version": version_of(python, packages[rival.name]),
            "date": about["date"],
            "kind": rival.kind,
            "points": measure_rival(rival, python, most),
        }
        given.out.write_text(stored_text(content), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
