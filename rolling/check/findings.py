"""Check of a scene before it is run: its cost, and whether its result can be believed.

`check_run` judges one run, `check_scene` all runs of a scene.
"""

from __future__ import annotations

import math
import sys
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from itertools import chain
from typing import TYPE_CHECKING, Any, NamedTuple

from acoustics.bands import BAND_NAMES, MID_HZ
from acoustics.numbers import byte_size, rounded, si
from acoustics.traps import ignoring_underflow
from acoustics.weighting import a_weighting_db
from rolling.check import (
    comb_spread,
    cost,
    error_cost,
    forecast,
    height_findings,
    level_doubts,
    long_steps,
    narrow_surface,
    refusals,
    resolution,
    validity,
    vibration_limits,
)
from rolling.check.finding import Finding
from rolling.check.memory_and_disk import SAMPLE_RATE, disk, memory
from rolling.check.run_size import RunSize, run_size
from rolling.in_si import scene_surface
from rolling.in_si.physics_of_scene import smooth_contact_of
from rolling.numbers.doubt import Doubt, Severity
from rolling.scene.identity import contact_keys, digest
from rolling.scene.scene import Scene
from rolling.scene.seeds import SEED_KEYS
from rolling.scene.surfaces import HeightFile
from rolling.scene.sweep import Value, run_name
from rolling.scene.swept import SweepRun
from rolling.terminal import progress
from rolling.terminal.streams import columns, line_width, wrapped

if TYPE_CHECKING:
    from rolling.check.probe import Probe

# Keys of the rows of marches whose time follows that of the track.
OTHER_MARCHES = ("error_estimate", "instrument_marches", "force_law", vibration_limits.OWN_MARCH)
# Keys of doubts that stand beside every level, and are no warnings.
BESIDE_LEVELS = (*level_doubts.SOURCES, resolution.LEVEL_KEY)
RUNS_ABREAST = 5  # columns of the table
MIN_HERTZ_NODES = 10  # across the Hertz radius


class RunCheck(NamedTuple):
    """Rows of one run in the order of the table, and the doubts about its numbers."""

    findings: list[Finding]
    doubts: list[Doubt]


@ignoring_underflow
@dataclass(frozen=True, repr=False)
class Findings(Sequence[Finding]):
    """Findings of all runs of a scene, one run after the other; printed, they are a table.

    Attributes
    ----------
    runs : dict of str to list of Finding
        Findings by run; its name is its swept values, or the name of the scene.
    doubts : dict of str to list of Doubt
        Doubts about the numbers of each run: `key`, `text`, `severity`, `decibels` and `advice`.
    quantities : dict of str to Forecasts
        `vibration` and `released_power` of each run, whose origin and verdict are a forecast.
    of_all : tuple of (str, str)
        Time of everything, and memory and disk of all runs together.
    excess : tuple of Doubt
        Memory and disk that all runs together need too much of.
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
    doubts: dict[str, list[Doubt]] = field(default_factory=dict)
    of_all: tuple[tuple[str, str], ...] = ()
    excess: tuple[Doubt, ...] = ()
    seconds: float = 0.0
    quantities: dict[str, level_doubts.Forecasts] = field(default_factory=dict)

    @property
    def warnings(self) -> list[str]:
        """Warnings in words, each once with the runs that it concerns unless it concerns all."""
        names = defaultdict[str, list[str]](list)
        for name, doubts in self.doubts.items():
            for doubt in doubts:
                if doubt.key not in BESIDE_LEVELS:
                    names[doubt.line].append(name)
        lines = [doubt.line for doubt in self.excess]
        for line, runs in names.items():
            if len(runs) == len(self.runs):
                lines.append(line)
                continue
            listed = runs[:RUNS_ABREAST]
            if len(runs) > RUNS_ABREAST:
                listed.append(f"{len(runs)} runs in all")
            lines.append(f"{line} ({', '.join(listed)})")
        return lines

    @property
    def refusal(self) -> Doubt | None:
        """The first doubt for which a run would be refused or have no solution; None without."""
        doubts = [*chain.from_iterable(self.doubts.values()), *self.excess]
        return next((doubt for doubt in doubts if doubt.severity is Severity.REFUSED), None)

    def __len__(self) -> int:
        return sum(map(len, self.runs.values()))

    def __iter__(self) -> Iterator[Finding]:
        return chain.from_iterable(self.runs.values())

    def __getitem__(self, index: Any) -> Any:
        return [*self][index]

    def __str__(self) -> str:
        shared, by_run = self._rows()
        blocks = [columns(shared)]
        if by_run[1:]:
            blocks += _abreast(by_run)
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
        for k, (name, of_run) in enumerate(self.runs.items()):
            doubtful = {doubt.key for doubt in self.doubts.get(name, ())}
            for finding in of_run:
                mark = " !" if finding.key in doubtful else ""
                cells[finding.quantity][k] = finding.value + mark
        shared = [[name, row[0]] for name, row in cells.items() if len({*row}) == 1]
        by_run = [[name, *row] for name, row in cells.items() if len({*row}) > 1]
        return shared + [list(row) for row in self.of_all], [["", *self.runs], *by_run]


def _abreast(rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Yield blocks of as many runs side by side as a terminal holds, at most RUNS_ABREAST."""
    width = line_width() if sys.stdout.isatty() else math.inf
    first = 1
    while first < len(rows[0]):
        last = min(first + RUNS_ABREAST, len(rows[0]))
        block = columns([[row[0], *row[first:last]] for row in rows])
        while last > first + 1 and max(map(len, block.splitlines())) > width:
            last -= 1
            block = columns([[row[0], *row[first:last]] for row in rows])
        yield block
        first = last


@ignoring_underflow
def check_scene(scene: Scene, solve: bool = True, pilots: Sequence[Scene] = ()) -> Findings:
    """Judge all runs of a scene before anything is computed.

    Parameters
    ----------
    scene : Scene
        Scene, with or without a sweep.
    solve : bool
        If true, solve a few positions of each run, which tell more than closed forms. Default true.
    pilots : sequence of Scene
        Short runs that are solved before, whose time counts. Default: none.

    Returns
    -------
    Findings
        Quantities and values of each run, and doubts about them; printed, they are a table.

    Raises
    ------
    SceneError
        A height file cannot be used, or the steps of the scene are too long.

    Examples
    --------
    >>> import rolling
    >>> len(check_scene(rolling.read_scene("quickstart"), solve=False).runs)
    3
    """
    runs = scene.runs()
    scenes = [run.scene for run in runs]
    sizes = {run_name(run.values): run_size(run.scene) for run in runs}
    long_steps.refuse_runs(scene, sizes)
    refusals.refuse_large_files(scenes)
    probes: Sequence[Probe | None] = [None] * len(runs)
    if solve:
        with progress.step("loading the solver"):
            from rolling.check import probe  # its compiled functions are slow to import
        probes = probe.probes(scenes)
    rows: dict[str, list[Finding]] = {}
    doubts: dict[str, list[Doubt]] = {}
    quantities: dict[str, level_doubts.Forecasts] = {}
    with progress.step("judging the numbers of the scene"):
        shared: dict[tuple[tuple[str, Value], ...], StatisticalRules] = {}
        for run, solved in zip(runs, probes, strict=True):
            name = run_name(run.values) or scene.name
            known_by = _values_known_without_heights(run)
            if known_by not in shared:
                shared[known_by] = statistical_rules(run.scene)
            rows[name], doubts[name] = check_run(run.scene, solved, shared[known_by])
            quantities[name] = level_doubts.forecasts(run.scene, doubts[name])
    seconds = _core_seconds(scenes, [*rows.values()]) + forecast.pilot_seconds(pilots)
    whole = f"{forecast.takes(seconds)}, with start, files and page"
    if len(runs) == 1:
        of_all = (("time of the whole run", whole),)
        return Findings(rows, doubts, of_all, seconds=seconds, quantities=quantities)
    of_every = (
        ("expected time of all", f"{whole}, {len(runs)} runs"),
        ("memory of all", refusals.memory_text(memory([*sizes.values()], cost.cores()))),
        ("disk of all", f"about {byte_size(disk([*sizes.values()]))}"),
    )
    excess = refusals.excess([*sizes.values()], cost.cores(), refusals.OUTPUTS, of=" of all")
    return Findings(rows, doubts, of_every, tuple(excess), seconds, quantities)


def _core_seconds(scenes: Sequence[Scene], rows: Sequence[Sequence[Finding]]) -> float:
    """Return the time of all runs with start, files and page, on all cores times their number.

    Runs that share a surface or a march count it once.
    """
    times: dict[tuple[str, object], float] = {}  # by row and surface, march or run
    for number, (scene, of_run) in enumerate(zip(scenes, rows, strict=True)):
        own = {vibration_limits.OWN_MARCH: number, forecast.SURFACE: scene_surface.identity(scene)}
        march = digest(contact_keys(scene))
        slow = _slowness(scene, of_run)
        for finding in of_run:
            factor = slow if finding.key in OTHER_MARCHES else 1.0
            key = finding.key, own.get(finding.key, march)
            times.setdefault(key, factor * finding.seconds)
    return sum(times.values()) + forecast.beside_seconds(scenes, cost.cores())


def _slowness(scene: Scene, of_run: Sequence[Finding]) -> float:
    """Return the time of a step on this machine over the expected time, 1 where none was solved.

    The impacts of a drop are solved on far wider contacts, whose time it does not tell.
    """
    if not scene.keeps_its_load:
        return 1.0
    expected = cost.expected_seconds(scene)
    measured = next((x.seconds for x in of_run if x.key == "expected_time"), 0.0)
    return measured / expected if measured > 0 and expected > 0 else 1.0


def conclusion(scene: Scene, findings: Findings) -> str:
    """State in one sentence whether a scene runs, how long, and with which verdict at best."""
    if findings.refusal is not None:
        return f"It does not run: {findings.refusal.text}."
    time = forecast.takes(findings.seconds)
    scenes = [run.scene for run in scene.runs()]
    if all(part.is_silent for part in scenes):
        return f"It runs in {time}. A smooth surface is silent."
    leading = [coming.leading for coming in findings.quantities.values()]
    judged = [quantity.judged for quantity in leading if quantity.judged is not None]
    if not judged:
        return f"It runs in {time}."
    worst = max(judged, key=lambda verdict: verdict.worst.severity)
    place = "" if len(judged) == 1 else " of the worst run"
    severity = worst.worst.severity
    expected = f"The verdict on the vibration{place} will be {worst.word}: {worst.worst.text}."
    if severity is Severity.TRUST:
        expected = "Nothing speaks against the vibration: the verdict will be trust."
    elif severity is Severity.INDICATIVE:
        expected = expected.replace("will be", "will at best be")
    return f"It runs in {time}. {expected}"


@dataclass(frozen=True)
class StatisticalRules:
    """What rules say that know no heights; runs that differ in their seeds alone share it.

    Attributes
    ----------
    fits : bool
        Whether memory holds the run, so that its heights may be made.
    first, last : list of Finding or Doubt
        Rows and doubts that stand before and after those of the heights.
    """

    fits: bool
    first: list[Finding | Doubt]
    last: list[Finding | Doubt]


def statistical_rules(scene: Scene) -> StatisticalRules:
    """Judge one run by its scene without random heights; a height file is read."""
    size = run_size(scene)
    fits = refusals.fits(size)
    first = [
        *_track(scene),
        *_march(scene),
        *_memory(size),
        *smooth_contact_rules(scene),
        *resolution.rules(scene),
    ]
    last = [*validity.rules(scene)]
    if scene.dynamics is not None:
        last += vibration_limits.rules(scene)
    if fits:
        last += comb_spread.rules(scene)
    return StatisticalRules(fits=fits, first=first, last=[*last, *resolution.record(scene)])


def scene_rules(scene: Scene, statistical: StatisticalRules | None = None) -> list[Finding | Doubt]:
    """Return rows and doubts of one run from its scene, in the order of the table.

    What is known without heights need not be found again.
    """
    known = statistical or statistical_rules(scene)
    of_heights = height_findings.rules(scene) if known.fits else ()
    return [*known.first, *of_heights, *known.last]


def check_run(
    scene: Scene, solved: Probe | None = None, statistical: StatisticalRules | None = None
) -> RunCheck:
    """Judge one run; solved positions replace the numbers of closed forms.

    Raise SceneError for a height file that cannot be used.
    """
    known = statistical or statistical_rules(scene)
    rows_and_doubts = [
        *level_doubts.of_source(scene),
        *scene_rules(scene, known),
        *level_doubts.of_grid(scene),
    ]
    is_narrow = any(x.key == "window" for x in rows_and_doubts if isinstance(x, Doubt))
    if known.fits and not is_narrow:
        rows_and_doubts += narrow_surface.rules(scene)
    if solved is not None:
        rows_and_doubts += solved.findings(scene)
    # A later rule replaces the row of an earlier rule with the same key.
    rows = {x.key: x for x in rows_and_doubts if isinstance(x, Finding)}
    doubts = {x.key: x for x in rows_and_doubts if isinstance(x, Doubt)}
    return RunCheck([*rows.values()], [*doubts.values()])


def _values_known_without_heights(run: SweepRun[Scene]) -> tuple[tuple[str, Value], ...]:
    """Return the swept values of a run but for its seeds, or all beside heights from a file.

    Rules that make no heights read those of a file.
    """
    left_out = () if run.scene.height_paths else SEED_KEYS
    return tuple((key, value) for key, value in run.values.items() if key not in left_out)


# ---- size and cost


def _track(scene: Scene) -> Iterator[Finding]:
    track = scene.track
    duration = scene.duration
    sides = f"{si(track.n_along * track.spacing, 'm')} x {si(track.n_across * track.spacing, 'm')}"
    closed = "" if track.closed else ", not closed"
    if track.turn_nodes:
        yield _turns(scene)
    yield Finding("steps", "steps", f"{track.steps} of {si(track.step, 'm')}")
    yield Finding("surface", "surface", f"{sides}, {track.n_along} x {track.n_across} nodes")
    yield Finding("distance", "distance rolled", f"{si(track.distance, 'm')}{closed}")
    yield Finding("duration", "duration", si(duration, "s"))
    if scene.length_choice is not None:
        name = f"{scene.length_choice.key.partition('.')[2]}: auto"
        yield Finding("length_choice", name, scene.length_choice.text)
    yield Finding("samples", "sound samples", f"{round(duration * SAMPLE_RATE)}")
    if scene.sound.room_db is not None:
        yield Finding("room", "room noise", f"{_room_laeq_db(scene.sound.room_db):.0f} dB(A)")


def _room_laeq_db(room_db: Mapping[str, float]) -> float:
    """Return the A-weighted level of third octaves, weighted at their mid frequencies [dB(A)]."""
    weighting_db = a_weighting_db(MID_HZ)
    levels_db = [level + weighting_db[BAND_NAMES.index(name)] for name, level in room_db.items()]
    return 10.0 * math.log10(sum(10.0 ** (level / 10.0) for level in levels_db))


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
        unit = math.lcm(nodes, max(1, math.ceil(scene.step_nodes)))
        least = math.ceil(track.distance / (unit * track.spacing) - 1e-9)
        distance = rounded(least * unit * track.spacing * 1e3, 8)
        value += f"; a rolling.distance_mm of {distance} closes"
    return Finding("turns", "turns of the sphere", value)


def _march(scene: Scene) -> Iterator[Finding | Doubt]:
    """State window, time, tolerance and the cost of the error estimate."""
    rq = cost.roughness(scene)[0]
    step_ms = cost.step_ms(scene)
    seconds = cost.expected_seconds(scene)
    time = cost.computing(seconds)
    if scene.is_permanent:
        time += f" for {scene.passes} passes"
    tolerance = rounded(scene.tolerance, 6)
    if scene.numerics.tolerance == "auto":
        tolerance += " (auto)"
    yield from _window(scene, rq)
    if scene.step_choice is not None:
        yield Finding("step_choice", "step_nodes: auto", scene.step_choice.text)
    yield Finding("step_time", "time of a step", f"about {rounded(step_ms)} ms on 1 core")
    yield Finding("expected_time", "time of the march", time, seconds)
    yield Finding("tolerance", "tolerance", tolerance)
    yield from forecast.surface_time(scene)
    if scene.numerics.error_estimate:
        seconds = error_cost.seconds(scene)
        reason = error_cost.too_short(scene) or "a smooth surface makes no sound"
        value = cost.computing(seconds) if seconds else f"none: {reason}"
        yield Finding("error_estimate", "error estimate", value, seconds)
    if seconds := error_cost.instrument_seconds(scene):
        value = cost.computing(seconds)
        yield Finding("instrument_marches", "marches for unseen waves", value, seconds)


def _window(scene: Scene, rq: float) -> Iterator[Finding | Doubt]:
    """Estimate the nodes of the window, and warn of a surface that is narrower than the contact."""
    track = scene.track
    width = 2 * cost.overlap_width(scene, rq)
    length = 2 * cost.overlap_radius(scene, rq)
    ahead = max(1.0, scene.step_nodes)
    rows, columns = (reach / scene.spacing + ahead for reach in (length, width))
    yield Finding("window", "window", f"about {rows:.0f} x {columns:.0f} nodes")
    across = width
    period = track.n_across * scene.spacing
    side = "width"
    key = "surface.width_um"
    if length / (track.n_along * scene.spacing) > width / period:
        across = length
        period = track.n_along * scene.spacing
        side = "length"
        key = "rolling.duration_s"
        if scene.rolling.distance_mm is not None:
            key = "rolling.distance_mm"
    if isinstance(scene.surface, HeightFile) and not (side == "width" and scene.surface.width_um):
        key = "height file"
    example = ""
    if key == "surface.width_um":
        wider = period * 2 ** math.ceil(math.log2(max(1.01 * across / period, 1.0)))
        example = f", such as {key}: {1e6 * wider:.10g}"
    if across > period:
        yield Doubt(
            "window",
            f"window: the contact is about {si(across, 'm')} across, the surface has a {side} of "
            f"{si(period, 'm')}",
            Severity.INDICATIVE,
            advice=f"choose a larger {key}, at least {1e6 * across:.0f} um of surface{example}",
        )


def _memory(size: RunSize) -> Iterator[Finding | Doubt]:
    """State memory and disk, and tell where the run does not fit."""
    workers = cost.cores()
    sizes = [size]
    yield Finding("memory", "memory", refusals.memory_text(memory(sizes, workers)))
    yield Finding("disk", "disk", f"about {byte_size(disk(sizes))}")
    yield from refusals.excess(sizes, workers, refusals.OUTPUTS)


# ---- contact of a smooth sphere


def smooth_contact_rules(scene: Scene) -> Iterator[Finding | Doubt]:
    """State the smooth elastic contact, its hardness, and the nodes that resolve it."""
    contact = smooth_contact_of(scene)
    length, width = contact.semi_axes_m()
    pressure = contact.maximum_pressure_pa()
    radius = min(length, width)
    shape = si(length, "m")
    if length != width:
        shape += f" along, {si(width, 'm')} across"
    yield Finding("hertz_radius", "Hertz radius", shape)
    yield Finding("hertz_pressure", "Hertz pressure", si(pressure, "Pa"))
    yield from _hardness(scene, pressure)
    nodes = radius / scene.spacing
    yield Finding("hertz_nodes", "nodes per Hertz radius", rounded(nodes, 3))
    if round(nodes) < MIN_HERTZ_NODES:
        coarsest_um = radius / MIN_HERTZ_NODES * 1e6
        yield Doubt(
            "hertz_nodes",
            f"the grid has {rounded(nodes)} nodes per Hertz radius, and {MIN_HERTZ_NODES} are "
            "wanted",
            Severity.INDICATIVE,
            advice=f"choose {resolution.finer(scene, coarsest_um)}",
        )


def _hardness(scene: Scene, pressure: float) -> Iterator[Finding | Doubt]:
    """Compare the hardness with the Hertz pressure [Pa], and the load with the capacity."""
    if not math.isfinite(scene.hardness):
        yield Finding("hardness", "hardness", "none, purely elastic")
        return
    says = "above the Hertz pressure of a smooth sphere; asperities may yield"
    if pressure > scene.hardness:
        says = "yields"
    yield Finding("hardness", "hardness", f"{si(scene.hardness, 'Pa')}, {says}")
    capacity = scene.hardness * scene.track.n_along * scene.track.n_across * scene.track.spacing**2
    yield Finding("capacity", "capacity", si(capacity, "N"))
    if scene.load >= capacity:
        yield Doubt(
            "capacity",
            f"capacity: the load is {rounded(scene.load, 6)} N, hardness times one period of the "
            f"surface is {si(capacity, 'N')}",
            Severity.REFUSED,
            advice="the run will be refused; lower rolling.load_n or enlarge the surface",
        )
