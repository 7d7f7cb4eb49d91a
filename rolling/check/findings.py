"""Check of a scene before it is run: its cost, and whether its result can be believed.

`findings` judges one run, `check_scene` all runs of a scene.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from html import escape
from itertools import chain
from typing import TYPE_CHECKING, Any

from acoustics.numbers import byte_size, rounded, si
from acoustics.traps import ignoring_underflow
from rolling.check import (
    comb,
    cost,
    error_cost,
    forecast,
    heights,
    refusals,
    resolution,
    validity,
)
from rolling.check.finding import SURFACE, Finding, computing, judged, surface_time
from rolling.dynamics.smooth_contact import maximum_pressure, semi_axes
from rolling.scene.identity import contact_keys, digest
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.scene.surfaces import HeightFile
from rolling.scene.sweep import run_name
from rolling.surface import scene_surface
from rolling.terminal import progress
from rolling.terminal.streams import columns, wrapped

if TYPE_CHECKING:
    from rolling.check.probe import Probe

# Keys of the findings of marches whose time follows that of the track.
OTHER_MARCHES = ("error_estimate", "force_law", validity.OWN_MARCH)
RUNS_ABREAST = 5  # columns of the table
MIN_HERTZ_NODES = 10  # across the Hertz radius


@ignoring_underflow
@dataclass(frozen=True, repr=False)
class Findings(Sequence[Finding]):
    """Findings of all runs of a scene, one run after the other; printed, they are a table.

    Attributes
    ----------
    runs : dict of str to list of Finding
        Findings by run; its name is its swept values, or the name of the scene.
    of_all : tuple of (str, str)
        Time of everything, and memory and disk of all runs together.
    excess : tuple of str
        Warnings where all runs together need too much memory or disk.
    seconds : float, s
        Time of all runs with start, files and page, on all cores times their number.

    Examples
    --------
    >>> import rolling
    >>> findings = rolling.read_scene("quickstart").check()
    >>> [*findings.runs], len(findings) > 30
    (['load_n=5', 'load_n=20', 'load_n=100'], True)
    """

    runs: dict[str, list[Finding]]
    of_all: tuple[tuple[str, str], ...] = ()
    excess: tuple[str, ...] = ()
    seconds: float = 0.0

    @property
    def warnings(self) -> list[str]:
        """Warnings in words, each once with the runs that it concerns unless it concerns all."""
        names = defaultdict[str, list[str]](list)
        for name, of_run in self.runs.items():
            for finding in of_run:
                if finding.warning:
                    names[f"{finding.quantity}: {finding.warning}"].append(name)
        lines = list(self.excess)
        for warning, runs in names.items():
            few = len(runs) <= RUNS_ABREAST
            listed = runs if few else [*runs[:RUNS_ABREAST], f"{len(runs)} runs in all"]
            every = len(runs) == len(self.runs)
            lines.append(warning if every else f"{warning} ({', '.join(listed)})")
        return lines

    def __len__(self) -> int:
        return sum(map(len, self.runs.values()))

    def __iter__(self) -> Iterator[Finding]:
        return chain.from_iterable(self.runs.values())

    def __getitem__(self, index: Any) -> Any:
        return [*self][index]

    def __str__(self) -> str:
        shared, by_run = self._rows()
        blocks = [columns(shared)]
        for k in range(1, len(by_run[0]), RUNS_ABREAST) if by_run[1:] else ():
            blocks.append(columns([[row[0], *row[k : k + RUNS_ABREAST]] for row in by_run]))
        warnings = "\n".join(wrapped(f"warning: {line}") for line in self.warnings)
        return "\n\n".join(filter(None, [*blocks, warnings]))

    __repr__ = __str__  # the table at a prompt

    def _repr_html_(self) -> str:
        parts = []
        for rows in self._rows():
            cells = ["".join(f"<td>{escape(cell)}</td>" for cell in row) for row in rows]
            lines = "".join(f"<tr>{line}</tr>" for line in cells)
            parts.append(f"<table>{lines}</table>" if len(rows) > 1 else "")
        items = "".join(f"<li>{escape(line)}</li>" for line in self.warnings)
        return "".join(parts) + (f"<ul>{items}</ul>" if items else "")

    def _rows(self) -> tuple[list[list[str]], list[list[str]]]:
        """Return the rows that all runs share, and the rows with a column per run and a header."""
        cells = {finding.quantity: [""] * len(self.runs) for finding in self}
        for k, of_run in enumerate(self.runs.values()):
            for finding in of_run:
                cells[finding.quantity][k] = finding.value + " !" * bool(finding.warning)
        shared = [[name, row[0]] for name, row in cells.items() if len({*row}) == 1]
        by_run = [[name, *row] for name, row in cells.items() if len({*row}) > 1]
        return shared + [list(row) for row in self.of_all], [["", *self.runs], *by_run]


@ignoring_underflow
def check_scene(scene: Scene, solve: bool = True) -> Findings:
    """Judge all runs of a scene before anything is computed.

    Parameters
    ----------
    scene : Scene
        Scene, with or without a sweep.
    solve : bool
        If true, solve a few positions of each run, which tell more than closed forms. Default true.

    Returns
    -------
    Findings
        Quantities, values and warnings of each run; printed, they are a table.

    Raises
    ------
    SceneError
        A height file cannot be used, a package that the scene asks for is missing, or its steps are
        too long.

    Examples
    --------
    >>> import rolling
    >>> len(check_scene(rolling.read_scene("quickstart"), solve=False).runs)
    3
    """
    refusals.refuse_unavailable(scene)
    resolution.refuse_long_steps(scene)
    runs = scene.runs()
    scenes = [run.scene for run in runs]
    for run in scenes:  # a file is judged by its header before it is read
        if run.height_paths and (faults := refusals.excess([run], 1, None)):
            section = next(iter(run.height_paths))
            raise SceneError([f"{section}.path: {fault}" for fault in faults.values()])
    probes: Sequence[Probe | None] = [None] * len(runs)
    if solve:
        with progress.step("loading the solver"):
            from rolling.check import probe  # its compiled functions are slow to import
        probes = probe.probes(scenes)
    with progress.step("judging the numbers of the scene"):
        by_run = {
            run_name(run.values) or scene.name: findings(run.scene, probe)
            for run, probe in zip(runs, probes, strict=True)
        }
    times: dict[tuple[str, object], float] = {}  # by finding and surface, march or run
    for number, (run, of_run) in enumerate(zip(scenes, by_run.values(), strict=True)):
        own = {validity.OWN_MARCH: number, SURFACE: scene_surface.identity(run)}
        march = digest(contact_keys(run))
        slow = _slowness(run, of_run)
        for finding in of_run:
            factor = slow if finding.key in OTHER_MARCHES else 1.0
            key = finding.key, own.get(finding.key, march)
            times.setdefault(key, factor * finding.seconds)
    seconds = sum(times.values()) + forecast.beside_seconds(scenes, cost.cores())
    whole = f"{forecast.takes(seconds)}, with start, files and page"
    if len(runs) == 1:
        return Findings(by_run, (("time of the whole run", whole),), seconds=seconds)
    of_all = (
        ("expected time of all", f"{whole}, {len(runs)} runs"),
        ("memory of all", refusals.memory_text(cost.memory(scenes, cost.cores()))),
        ("disk of all", f"about {byte_size(cost.disk(scenes))}"),
    )
    excess = tuple(f"{key} of all: {fault}" for key, fault in _excess(scenes).items())
    return Findings(by_run, of_all, excess, seconds)


def _slowness(scene: Scene, of_run: Sequence[Finding]) -> float:
    """Return the time of a step on this machine over the expected time, 1 where none was solved.

    The impacts of a drop are solved on far wider contacts, whose time it does not tell.
    """
    if scene.rolling.drop_mm is not None:
        return 1.0
    expected = cost.expected_seconds(scene)
    measured = next((x.seconds for x in of_run if x.key == "expected_time"), 0.0)
    return measured / expected if measured > 0 and expected > 0 else 1.0


def _excess(scenes: Sequence[Scene]) -> dict[str, str]:
    return refusals.excess(scenes, cost.cores(), refusals.OUTPUTS)


def findings(scene: Scene, solved: Probe | None = None) -> list[Finding]:
    """Judge one run; solved positions replace the numbers of closed forms.

    Raise SceneError for a height file that cannot be used.
    """
    by_key = {finding.key: finding for rule in _RULES for finding in rule(scene)}
    for finding in solved.findings(scene) if solved else ():
        before = by_key.get(finding.key, finding)
        by_key[finding.key] = replace(finding, warning=finding.warning or before.warning)
    return list(by_key.values())


# ---- size and cost


def _track(scene: Scene) -> Iterator[Finding]:
    track, duration = scene.track, scene.duration
    sides = f"{si(track.n_along * track.spacing, 'm')} x {si(track.n_across * track.spacing, 'm')}"
    closed = "" if track.closed else ", not closed"
    if track.turn_nodes:
        yield _turns(scene)
    yield Finding("steps", "steps", f"{track.steps} of {si(track.step, 'm')}")
    yield Finding("surface", "surface", f"{sides}, {track.n_along} x {track.n_across} nodes")
    yield Finding("distance", "distance rolled", f"{si(track.distance, 'm')}{closed}")
    yield Finding("duration", "duration", si(duration, "s"))
    yield Finding("samples", "sound samples", f"{round(duration * cost.SAMPLE_RATE)}")


def _turns(scene: Scene) -> Finding:
    """State turns, circumference in nodes, and the distance after which the record closes."""
    track = scene.track
    turn = track.turn_nodes * track.spacing
    off = si(abs(turn - 2 * math.pi * scene.radius), "m")
    value = f"{rounded(track.turns, 4)} of {track.turn_nodes} nodes ({off} off the circumference)"
    if not track.closed:
        nodes = track.turn_nodes
        if isinstance(scene.surface, HeightFile):
            nodes = math.lcm(track.plate_nodes, nodes)  # after which both close together
        unit = math.lcm(nodes, max(1, math.ceil(scene.numerics.step_nodes)))
        least = math.ceil(track.distance / (unit * track.spacing) - 1e-9)
        distance = rounded(least * unit * track.spacing * 1e3, 8)
        value += f"; a rolling.distance_mm of {distance} closes"
    return Finding("turns", "turns of the sphere", value)


def _march(scene: Scene) -> Iterator[Finding]:
    """State window, time, tolerance and the cost of the error estimate."""
    rq = cost.roughness(scene)[0]
    step_ms, seconds = cost.step_ms(scene), cost.expected_seconds(scene)
    time = computing(seconds) + f" for {scene.passes} passes" * scene.is_permanent
    rule = " (auto)" if scene.numerics.tolerance == "auto" else ""
    yield _window(scene, rq)
    yield Finding("step_time", "time of a step", f"about {rounded(step_ms)} ms on 1 core")
    yield Finding("expected_time", "time of the march", time, None, seconds)
    yield Finding("tolerance", "tolerance", f"{rounded(scene.tolerance, 6)}{rule}")
    yield from surface_time(scene)
    if scene.numerics.error_estimate:
        seconds = error_cost.seconds(scene)
        reason = error_cost.too_short(scene) or "a smooth surface makes no sound"
        value = computing(seconds) if seconds else f"none: {reason}"
        yield Finding("error_estimate", "error estimate", value, None, seconds)


def _window(scene: Scene, rq: float) -> Finding:
    """Estimate the nodes of the window, and warn of a surface that is narrower than the contact."""
    track = scene.track
    lengths = 2 * cost.overlap_width(scene, rq), 2 * cost.overlap_radius(scene, rq)
    periods = track.n_across * scene.spacing, track.n_along * scene.spacing
    side = "width" if lengths[0] / periods[0] >= lengths[1] / periods[1] else "length"
    across, period = (lengths[0], periods[0]) if side == "width" else (lengths[1], periods[1])
    key = "duration_s" if scene.rolling.distance_mm is None else "distance_mm"
    key = "surface.width_um" if side == "width" else f"rolling.{key}"
    if isinstance(scene.surface, HeightFile) and not (side == "width" and scene.surface.width_um):
        key = "height file"
    numbers = {"across": across, "side": side, "period": period, "key": key, "least": 1e6 * across}
    ahead = max(1.0, scene.numerics.step_nodes)
    columns, rows = (length / scene.spacing + ahead for length in lengths)
    return judged("window", f"about {rows:.0f} x {columns:.0f} nodes", across > period, **numbers)


def _memory(scene: Scene) -> Iterator[Finding]:
    needs = refusals.memory_text(cost.memory([scene], cost.cores())), cost.disk([scene])
    excess = {key: f"{fault}; the run will be refused" for key, fault in _excess([scene]).items()}
    yield Finding("memory", "memory", needs[0], excess.get("memory"))
    yield Finding("disk", "disk", f"about {byte_size(needs[1])}", excess.get("disk"))


# ---- contact of a smooth sphere


def _smooth_contact(scene: Scene) -> Iterator[Finding]:
    """State the smooth elastic contact, its hardness, and the nodes that resolve it."""
    (length, width), pressure = semi_axes(scene), maximum_pressure(scene)
    radius, shape = min(length, width), si(length, "m")
    if length != width:
        shape += f" along, {si(width, 'm')} across"
    nodes, coarse = radius / scene.spacing, radius / MIN_HERTZ_NODES * 1e6
    few = nodes < MIN_HERTZ_NODES
    numbers = {"nodes": nodes, "least": MIN_HERTZ_NODES}
    finer = resolution.finer(scene, coarse)
    yield Finding("hertz_radius", "Hertz radius", shape)
    yield Finding("hertz_pressure", "Hertz pressure", si(pressure, "Pa"))
    yield from _hardness(scene, pressure)
    yield judged("hertz_nodes", rounded(nodes, 3), few, finer=finer, **numbers)


def _hardness(scene: Scene, pressure: float) -> Iterator[Finding]:
    """Compare the hardness with the Hertz pressure [Pa], and the load with the capacity."""
    if not math.isfinite(scene.hardness):
        yield Finding("hardness", "hardness", "none, purely elastic")
        return
    gentle = "above the Hertz pressure of a smooth sphere; asperities may yield"
    says = "yields" if pressure > scene.hardness else gentle
    capacity = scene.hardness * scene.track.n_along * scene.track.n_across * scene.track.spacing**2
    numbers = {"load": scene.load, "capacity": capacity}
    yield Finding("hardness", "hardness", f"{si(scene.hardness, 'Pa')}, {says}")
    yield judged("capacity", si(capacity, "N"), scene.load >= capacity, **numbers)


# In the order of the table. A rule replaces the finding of an earlier rule with the same key.
_RULES: tuple[Callable[[Scene], Iterable[Finding]], ...] = (
    *(_track, _march, _memory, _smooth_contact),
    *(resolution.findings, heights.findings, validity.findings, comb.findings, resolution.record),
)
