"""Memory and disk that runs will take, estimated from their scenes alone.

The constants are bytes, measured on whole runs: the peak of the resident memory of all processes,
and the size of the folder. They are on the safe side: an estimate lies between the measured size
and twice that size.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from rolling.check import cost, error_cost
from rolling.check.between_nodes import BetweenNodes, between_nodes
from rolling.scene.scene import Scene
from rolling.scene.track import Track

SAMPLE_RATE = 48_000  # [Hz], acoustics.wav.SAMPLE_RATE_HZ, which is slow to import
MAPS, MAP_CELLS = 120, 96  # pressure maps of a run and cells along their sides (`simulate`)
PIECE_STEPS = 200  # minimum share of the work of a process (`simulate`)
PAGE_RUNS = 24  # maximum number of runs on a page (`report`)
HEARING_SHARE = 20_000 / SAMPLE_RATE  # spectral lines per sample on a picture

# Bytes of a process: the program with its libraries, compiled code and transforms, pictures and
# page.
PROGRAM, SOLVER, PICTURES, WORKER, TRACKER = 210e6, 100e6, 110e6, 230e6, 15e6
# Bytes per node of the surface: while it is made or read, as long as it is kept, and while its
# statistics are computed.
MADE = {"gaussian": 44.0, "file": 50.0, "smooth": 0.0}
KEPT = {"gaussian": 8.0, "file": 8.0, "smooth": 0.0}
STATISTICS = {"gaussian": 26.0, "file": 46.0, "smooth": 17.0}
# Nodes of a window at half the spacing over nodes at the spacing, which is kept beside it.
FINE_NODES = 5.0
# Bytes per solved step, as long as it is kept, and per step, while result.h5 is written.
RESULT, RESULT_FILE = 112.0, 270.0
TABLE = 180.0  # per number of a CSV file, while it is written
STEP_SOUND, STEP_DENSE = 60.0, 210.0  # per step, for its sound at constant and at varying speed
# Bytes per sample, and per oversampled sample at a varying speed. Loudness takes less, later.
SAMPLE_SOUND, FINE_SOUND = 262.0, 64.0
AWKWARD = 150.0  # per value of a transform whose length has a large prime factor
# Bytes per step and per sample of each run, kept to compare runs, and bytes of its page.
STEP_HEARD, SAMPLE_HEARD, RUN_HEARD = 60.0, 16.0, 4e6
# Bytes per time step of a motion of sphere and plate, while it sounds and as long as it is kept.
TIME_SOUND, TIME_HEARD = 240.0, 66.0
PAGE_COPIES, LAP_MAP = 5.0, 60.0  # copies of the page while it is composed; per map and lap
EVENTS_PER_NODE = 0.6  # approximate recovery events of a node that the contact passes over
EVENT = 260.0  # per recovery event, while events are joined

# Bytes on disk.
# result.h5 per step, per event and per node of the window:
STEP_FILE, EVENT_FILE, SNAPSHOT_FILE = 153.0, 41.0, 16.0
ROW_FILE = 25.0  # per row of a table with two columns
LABELLED_ROW_FILE = 45.0  # per row of such a table with the labels of runs
FEW_FILES = 0.2e6  # short tables and files of a run that has no pictures
SAMPLE_FILE, SAMPLE_PAGE, LAP_MAP_PAGE = 15.0, 2.7, 13.5  # in WAV files; on the page
MAP_FILE = 1.0  # per cell of the pressure maps, compressed
# Pictures and short tables of a run, its part of the page, and the page itself:
RUN_FILES, PAGE_RUN, PAGE = 1.7e6, 0.6e6, 0.8e6

ADVICE = {
    "program": "give fewer --workers",
    "surface": "choose a smaller surface.width_um or rolling.duration_s, a larger"
    " surface.spacing_um, or fewer --workers",
    "height file": "cut the height file or take every second node of it, or give fewer --workers",
    "window": "choose a larger surface.spacing_um, or fewer --workers",
    "steps": "shorten rolling.duration_s, or choose a larger step"
    " (numerics.step_nodes, surface.spacing_um)",
    "sound samples": "shorten rolling.duration_s",
    "oversampling of the varying speed": "lower the maximum of rolling.speed_m_s,"
    " or shorten rolling.duration_s",
    "time steps of the motion": "shorten rolling.duration_s or rolling.distance_mm",
    "recovery events": "set recovery.events to false, or shorten rolling.duration_s",
    "pressure maps": "shorten rolling.duration_s",
    "runs of the sweep": "give sweep fewer values",
}


@dataclass(frozen=True)
class Amount:
    """Amount of bytes in parts, each with a key of ADVICE."""

    parts: tuple[tuple[str, float], ...]

    @property
    def total(self) -> float:
        """Sum of the parts [bytes]."""
        return sum(size for _, size in self.parts)

    @property
    def largest(self) -> tuple[str, float]:
        """Name and size of the largest part, with parts of the same name added up."""
        sizes: dict[str, float] = {}
        for name, size in self.parts:
            sizes[name] = sizes.get(name, 0.0) + size
        return max(sizes.items(), key=lambda item: item[1])


@dataclass(frozen=True)
class Demand:
    """Maximum memory of all processes together, memory of the largest process, and disk."""

    memory: Amount
    process: Amount
    disk: Amount


@dataclass(frozen=True)
class Size:
    """Numbers of a run that determine its demand.

    Attributes
    ----------
    kind : str
        Kind of the surface.
    nodes, window : float
        Nodes of the surface and of the window, which are cells.
    between : Between
        Heights between the nodes.
    steps, solved : int
        Steps, and the steps that are solved.
    samples, fine : int
        Samples of the sound, and of its oversampling at a varying speed; the latter is 0 at a
        constant speed.
    lines : (int, int)
        Lines of both spectra that are written.
    map_cells, lap_maps : float
        Cells of all pressure maps, and maps counted in every lap.
    events : float
        Expected number of recovery events.
    times : int
        Time steps of the motion of sphere and plate; 0 without dynamics.
    estimated : bool
        If true, the run estimates its errors on windows at half the spacing. Default: false.
    """

    kind: str
    nodes: int
    window: float
    between: BetweenNodes
    steps: int
    solved: int
    samples: int
    fine: int
    lines: tuple[int, int]
    map_cells: float
    lap_maps: int
    events: float
    times: int
    estimated: bool = False

    @property
    def surface(self) -> str:
        """Key of ADVICE for the surface."""
        return "height file" if self.kind == "file" else "surface"

    @property
    def numbers(self) -> int:
        """Count of numbers in the longest table."""
        return 2 * max(self.steps, *self.lines)

    @property
    def solver(self) -> float:
        """Bytes of a process that solves, apart from the program."""
        window = self.between.window * self.window * (FINE_NODES if self.estimated else 1.0)
        return window + (8.0 * self.nodes if self.events else 0.0)

    @property
    def made(self) -> float:
        """Bytes of the surface in a process that solves, while it is made."""
        return max(MADE[self.kind], KEPT[self.kind] + self.between.made) * self.nodes

    @property
    def kept(self) -> float:
        """Bytes of the surface in a process that solves, as long as it is kept."""
        return (KEPT[self.kind] + self.between.kept) * self.nodes


def size(scene: Scene, rq: float) -> Size:
    """Estimate the size of a run whose surface has an rms roughness of rq [m]."""
    track, duration = scene.track, scene.duration
    samples = max(2, round(duration * SAMPLE_RATE))
    dense = max(1, math.ceil(scene.motion.fastest(duration) / track.step / SAMPLE_RATE))
    across = 2 * cost.overlap_radius(scene, rq) / scene.spacing
    # The window holds the overlap and the padding of its transforms; it never exceeds the surface
    # by much.
    side = min(cost.window_nodes(scene, rq), 2.0 * max(track.n_along, track.n_across))
    seen = min(across, track.n_along, track.n_across)
    cells = math.ceil(seen / max(1, math.ceil(seen / MAP_CELLS))) ** 2
    maps = min(MAPS, track.solved_steps)
    events = (
        EVENTS_PER_NODE * seen * track.solved_steps * scene.numerics.step_nodes
        if scene.recovery.events
        else 0.0
    )
    return Size(
        kind=scene.surface.kind,
        nodes=track.n_along * track.n_across,
        window=side**2,
        between=between_nodes(scene, rq),
        steps=track.steps,
        solved=track.solved_steps,
        samples=samples,
        fine=0 if scene.motion.is_constant(duration) else samples * dense,
        lines=(round(samples * HEARING_SHARE), min(track.steps // 2, round(duration * 20_000))),
        map_cells=float(maps * cells),
        lap_maps=math.ceil(track.steps / track.solved_steps) * maps,
        events=events,
        times=_time_steps(scene),
        estimated=error_cost.cost_share(scene) > 0,
    )


def _time_steps(scene: Scene) -> int:
    """Estimate the number of time steps of the motion; 0 without dynamics."""
    if scene.dynamics is None:
        return 0
    # The compiled law is slow to import, and a refusal waits for it otherwise.
    from rolling.check import force_estimate
    from rolling.dynamics.motion import steps_per_period

    chain, speed = force_estimate.smooth_chain(scene), scene.motion.fastest(scene.duration)
    rate = max(steps_per_period(chain) * chain.resonance_hz, speed / scene.step)
    return math.ceil(scene.duration * rate)


def demand(sizes: Sequence[Size], workers: int) -> Demand:
    """Estimate memory and disk of runs that some processes solve and one process finishes."""
    tasks = sum(math.ceil(each.solved / PIECE_STEPS) for each in sizes)
    workers = max(1, min(workers, tasks))
    results = [
        ("steps", RESULT * sum(each.solved for each in sizes)),
        ("pressure maps", 4.0 * sum(each.map_cells for each in sizes)),
    ]
    moments: list[Amount] = []
    processes: list[Amount] = []
    for each in sizes:
        process = [
            *_solving(each, workers, results),
            *_finishing(each, sizes, workers, results),
        ]
        processes += process
        moments += process
        if workers > 1:
            main = _parts([("program", PROGRAM + TRACKER), *results, *_keeping(each)])
            worker = [("program", WORKER), *_in_solver(each)]
            processes.append(_parts(worker))
            moments.append(
                _parts([*main.parts, *((name, workers * bytes_) for name, bytes_ in worker)])
            )
    largest = max(processes, key=lambda amount: amount.total)
    return Demand(max(moments, key=lambda amount: amount.total), largest, _disk(sizes))


def of_variants(scene: Scene, rq: float, finest: int, workers: int) -> Demand:
    """Estimate the demand of `rolling accuracy`.

    Its processes hold the surface on the finest grid and its window.
    """
    track, fine, cells = scene.track, finest**2, between_nodes(scene, rq)
    surface = max(MADE["gaussian"], KEPT["gaussian"] + cells.made)
    worker = [
        ("program", WORKER + SOLVER),
        ("surface", surface * track.n_along * track.n_across * fine),
        ("window", cells.window * cost.window_nodes(scene, rq) ** 2 * fine),
    ]
    process = _parts(worker)
    every = _parts(
        [("program", PROGRAM + PICTURES), *((name, workers * bytes_) for name, bytes_ in worker)]
    )
    return Demand(every, process, _parts([("program", 10e6)]))


def reading(track: Track) -> Demand:
    """Estimate the demand of reading a height file."""
    amount = _parts(
        [("program", PROGRAM), ("height file", MADE["file"] * track.n_along * track.n_across)]
    )
    return Demand(amount, amount, _parts([("program", 0.0)]))


def _parts(parts: Sequence[tuple[str, float]]) -> Amount:
    """Put parts together."""
    return Amount(tuple(parts))


def _in_solver(each: Size) -> list[tuple[str, float]]:
    """List the parts of a process that solves, apart from the program."""
    window = each.solver
    if each.made > each.kept + window:
        return [(each.surface, each.made)]
    return [(each.surface, each.kept), ("window", window)]


def _keeping(each: Size) -> list[tuple[str, float]]:
    """List the parts in memory while result.h5 is written."""
    return [("steps", RESULT_FILE * each.steps), ("pressure maps", 4.0 * each.map_cells)]


def _solving(each: Size, workers: int, results: list[tuple[str, float]]) -> list[Amount]:
    """List the moments of the main process until all is solved.

    Without workers the main process solves as well.
    """
    made = _parts([("program", PROGRAM), *results, (each.surface, MADE[each.kind] * each.nodes)])
    own = (
        [("program", PROGRAM + SOLVER), *_in_solver(each)]
        if workers == 1
        else [("program", PROGRAM)]
    )
    return [made, _parts([*own, *results, *_keeping(each)])]


def _finishing(
    each: Size, sizes: Sequence[Size], workers: int, results: list[tuple[str, float]]
) -> list[Amount]:
    """List the moments of the main process while it finishes a run.

    It makes sound, numbers, files and page of the run, and keeps the other runs.
    """
    before = [("program", PROGRAM + (SOLVER if workers == 1 else 0.0)), *results]
    before += [
        ("window", each.solver if workers == 1 else 0.0),
        (each.surface, each.kept if workers == 1 else KEPT[each.kind] * each.nodes),
    ]
    others = len(sizes) - 1
    heard = [
        (
            "runs of the sweep",
            others
            * (
                STEP_HEARD * each.steps
                + SAMPLE_HEARD * each.samples
                + TIME_HEARD * each.times
                + RUN_HEARD
            ),
        ),
        ("steps", STEP_HEARD * each.steps),
        ("sound samples", SAMPLE_HEARD * each.samples),
        ("time steps of the motion", TIME_HEARD * each.times),
    ]
    statistics = [
        *before,
        *heard,
        (each.surface, (STATISTICS[each.kind] - KEPT[each.kind]) * each.nodes),
    ]
    sounding = [*before, *heard[:1], *_sounding(each), ("recovery events", EVENT * each.events)]
    before[0] = ("program", before[0][1] + PICTURES)
    tables = [*before, *heard, ("recovery events", EVENT * each.events)]
    longest = "steps" if each.steps >= max(each.lines) else "sound samples"
    moments = [
        _parts(statistics),
        _parts([*before, *heard[:1], *_keeping(each)]),
        _parts(sounding),
        _parts([*tables, (longest, TABLE * each.numbers)]),
    ]
    if others:  # curves of all runs side by side
        compared = max(sum(size.lines[k] for size in sizes) for k in (0, 1)) + max(each.lines)
        moments.append(_parts([*tables, ("runs of the sweep", TABLE * compared)]))
    if len(sizes) <= PAGE_RUNS:
        page = [(name, PAGE_COPIES * bytes_) for name, bytes_ in _page(sizes)]
        moments.append(
            _parts([*tables, *page, ("steps", LAP_MAP * sum(size.lap_maps for size in sizes))])
        )
    return moments


def _sounding(each: Size) -> list[tuple[str, float]]:
    """List the parts in memory while the sound of a run is made."""
    parts = [("sound samples", SAMPLE_SOUND * each.samples + _transform(each.samples))]
    parts.append(("steps", STEP_SOUND * each.steps + _transform(each.steps)))
    parts.append(("time steps of the motion", TIME_SOUND * each.times + _transform(each.times)))
    if not each.fine:
        return parts
    dense = [
        ("steps", STEP_DENSE * each.steps + _transform(8 * each.steps)),
        ("oversampling of the varying speed", FINE_SOUND * each.fine + _transform(each.fine)),
    ]
    return max(parts, dense, key=lambda moment: sum(bytes_ for _, bytes_ in moment))


def _page(sizes: Sequence[Size]) -> list[tuple[str, float]]:
    """List the parts of the page [bytes on disk]."""
    return [
        ("sound samples", SAMPLE_PAGE * sum(each.samples for each in sizes)),
        ("steps", LAP_MAP_PAGE * sum(each.lap_maps for each in sizes)),
        ("pressure maps", 0.5 * sum(each.map_cells for each in sizes)),
        ("program", PAGE + PAGE_RUN * len(sizes)),
    ]


def _disk(sizes: Sequence[Size]) -> Amount:
    """Estimate all files, and the largest result.h5 once more.

    A new result.h5 is complete before it replaces the old file.
    """
    stored = [
        [
            ("steps", STEP_FILE * each.steps),
            ("recovery events", EVENT_FILE * each.events),
            ("pressure maps", MAP_FILE * each.map_cells),
            ("window", SNAPSHOT_FILE * each.window),
        ]
        for each in sizes
    ]
    parts = [part for each in stored for part in each]
    parts += max(stored, key=lambda each: sum(bytes_ for _, bytes_ in each))
    whole = len(sizes) <= PAGE_RUNS
    # per run, and with all runs side by side
    row = ROW_FILE * whole + LABELLED_ROW_FILE * (len(sizes) > 1)
    for each in sizes:
        parts += [
            ("steps", ROW_FILE * each.steps * whole),
            ("sound samples", (row * HEARING_SHARE + SAMPLE_FILE) * each.samples),
            ("steps", row * each.lines[1]),
            ("program", RUN_FILES if whole else FEW_FILES),
        ]
    return _parts([*parts, *(_page(sizes) if whole else [("program", PAGE)])])


def _transform(length: int) -> float:
    """Return the additional bytes of a Fourier transform.

    Only a long transform whose length has a large prime factor needs them.
    """
    return AWKWARD * length if length > 100_000 and _awkward(length) else 0.0


@lru_cache(maxsize=1024)
def _awkward(length: int) -> bool:
    """Tell whether the largest prime factor of a length is above its square root.

    The transform then has twice the length or more.
    """
    rest, factor = length, 2
    while factor * factor <= rest:
        if rest % factor:
            factor += 1 + factor % 2
        else:
            rest //= factor
    return max(rest, factor if rest == 1 else 1) ** 2 > length


def of_scenes(scenes: Sequence[tuple[Scene, float]], workers: int) -> Demand:
    """Estimate the demand of runs.

    Each run is a scene without sweep with the rms roughness [m] of its surface.
    """
    return demand([size(scene, rq) for scene, rq in scenes], workers)
