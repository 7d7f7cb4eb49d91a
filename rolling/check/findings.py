"""What a scene will cost and whether it can be believed, said before anything is computed.

Depends on `scenario` (what is asked), `cost`, `demand`, `machine`, `long_steps`, `resonance`, `reference` (Hertz), `measured`
(height files) and `acoustics.bands`; `report` on `probe`, which solves.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from acoustics import bands
from rolling.check import cost, demand, long_steps, machine, measured, resonance
from rolling.check.finding import Finding
from rolling.check.finding import byte_size as _bytes
from rolling.check.finding import clock as _clock
from rolling.check.finding import on_cores as _cores
from rolling.check.finding import rounded_down as _down
from rolling.check.finding import rounded_up as _up
from rolling.check.finding import si as _si
from rolling.contact import closed_forms as reference
from rolling.scene.messages import SceneError
from rolling.scene.run_names import run_name
from rolling.scene.scene import Scene
from rolling.scene.sections import Gaussian, HeightFile
from rolling.scene.track import Track

if TYPE_CHECKING:
    from rolling.check.probe import Probe

HEARING = (bands.NOMINAL_HZ[0], bands.NOMINAL_HZ[-1])  # [Hz]
SAMPLE_RATE = 48_000  # [Hz], acoustics.wav.SAMPLE_RATE_HZ, which is slow to import
LEAST_SHARE = 0.01  # of a record: a shorter stretch that is too slow for hearing is not worth a word
LEAST_HERTZ_NODES = 10  # across the Hertz radius
LEAST_CORRELATION_NODES = 5  # across the correlation length
GREATEST_SLOPE = 0.3  # rms norm of the gradient that a half-space may have
GREATEST_CONTACT = 0.2  # contact radius over sphere radius
RUNS_ABREAST = 5  # columns of the report
OUTPUTS = Path("outputs")  # where runs are written unless they are told otherwise
PURPOSES = {
    "sound samples": "the sound",
    "runs of the sweep": "the other runs of the sweep",
}  # parts of a demand in words


def findings(scene: Scene, solved: Probe | None = None) -> list[Finding]:
    """Judge one run; a sweep is not looked at.

    Parameters
    ----------
    solved : positions that were solved; their numbers replace those of the closed forms. None: nothing is solved.

    Raises
    ------
    SceneError : the height file cannot be used.
    """
    way = scene.track
    rq, slope = cost.roughness(scene)
    closed_forms = [
        *_size(scene, way),
        *_window(scene, way, rq),
        *_demand(scene, way, rq),
        *_contact(scene, way),
        *_sampling(scene, way),
        *measured.findings(
            scene, way, long_steps.contact_radius(scene), LEAST_CORRELATION_NODES, cost.duration(scene, way)
        ),
        *_validity(scene, slope),
        _resonance(scene, way),
        _record(scene, way),
    ]
    return closed_forms if solved is None else _replaced(closed_forms, solved.findings(scene))


def refuse_unavailable(scene: Scene) -> None:
    """Before anything is computed: can all be reported that the scene asks for?

    Raises
    ------
    SceneError : it asks for loudness, and the package for it is not installed.
    """
    if scene.sound.loudness and find_spec("mosqito") is None:
        raise SceneError(
            [
                "sound.loudness: needs the package mosqito, which is not installed;"
                ' pip install "rolling-contact-noise[loudness]", or set it to false'
            ]
        )


def refuse_what_cannot_fit(scene: Scene, workers: int = 0, folder: Path = OUTPUTS) -> None:
    """Refuse a scene whose runs need more memory or disk than they may take, before anything large is made or written.

    Parameters
    ----------
    workers : processes; 0: one per core.
    folder : where the files go; those of the run that are there already are not needed again.

    Raises
    ------
    SceneError : the runs do not fit, or a height file cannot be used.
    """
    scenes = [single for _, single in scene.runs()]

    def needed(roughness: Callable[[Scene], float]) -> demand.Demand:
        return demand.of_scenes([(single, roughness(single)) for single in scenes], workers or cost.cores())

    written = _written(folder) if (folder / "resolved.yaml").is_file() else 0.0
    _refuse_excess(scenes, needed, folder, written)


def refuse_variants_that_cannot_fit(scene: Scene, finest: int, workers: int = 0, folder: Path = OUTPUTS) -> None:
    """Refuse the variants of a scene without sweep, as `refuse_what_cannot_fit` its run; `finest` divides the spacing."""

    def needed(roughness: Callable[[Scene], float]) -> demand.Demand:
        return demand.of_variants(scene, scene.track, roughness(scene), finest, workers or cost.cores())

    _refuse_excess([scene], needed, folder)


def _refuse_excess(
    scenes: Sequence[Scene],
    needed: Callable[[Callable[[Scene], float]], demand.Demand],
    folder: Path,
    written: float = 0.0,
) -> None:
    """Refuse a demand, which depends on the rms roughness [m] of each scene, where it does not fit."""
    # By the header of a height file alone, before it is read.
    first = [lambda scene: 0.0] if any(scene.height_path is not None for scene in scenes) else []
    for roughness in (*first, _roughness_read_once()):
        if excess := _excess(needed(roughness), folder, written):
            raise SceneError([f"{key}: {fault}" for key, fault in excess.items()])


def _roughness_read_once() -> Callable[[Scene], float]:
    """Rms roughness [m] of a scene's surface; a height file that many runs share is read once."""
    known: dict[str, float] = {}

    def roughness(scene: Scene) -> float:
        key = f"{scene.surface.model_dump_json()} {scene.height_path}"
        if key not in known:
            known[key] = cost.roughness(scene)[0]
        return known[key]

    return roughness


def _written(folder: Path) -> float:
    """Bytes of the files in a folder."""
    return float(sum(file.stat().st_size for file in folder.rglob("*") if file.is_file()))


def _refuse_large_heights(scene: Scene) -> None:
    """Refuse a height file that does not fit into memory, by its header."""
    if scene.height_path is not None:
        excess = _excess(demand.reading(scene.track), OUTPUTS)
        if excess:
            raise SceneError([f"surface.path: {fault}" for fault in excess.values()])


def report(scene: Scene, fast: bool = False) -> str:
    """Write the findings of a scene as a table: values that all its runs share, then a column per run, the warnings below.

    Parameters
    ----------
    fast : solve no positions.

    Raises
    ------
    SceneError : a height file cannot be used, something it asks for cannot be had, or its steps are too long.
    """
    refuse_unavailable(scene)
    long_steps.refuse_long_steps(scene)
    singles = scene.runs()
    for _, single in singles:
        _refuse_large_heights(single)
    runs = [
        (run_name(values) or scene.name, findings(single, solved))
        for (values, single), solved in zip(singles, _solved([single for _, single in singles], fast), strict=True)
    ]
    whats = list(dict.fromkeys(finding.what for _, found in runs for finding in found))
    cells = {what: [next((_cell(f) for f in found if f.what == what), "") for _, found in runs] for what in whats}
    shared = [what for what in whats if len(set(cells[what])) == 1]
    facts = [[what, cells[what][0]] for what in shared]
    refused: list[str] = []
    if len(runs) > 1:
        seconds = sum(finding.seconds for _, found in runs for finding in found)
        facts.append(["expected time of all", f"about {_clock(seconds)} on {_cores()}, {len(runs)} runs"])
        roughness = _roughness_read_once()
        needed = demand.of_scenes([(single, roughness(single)) for _, single in singles], cost.cores())
        facts += [["memory of all", _amount(needed.memory)], ["disk of all", _amount(needed.disk)]]
        refused = [f"warning: {key} of all: {fault}" for key, fault in _excess(needed, OUTPUTS).items()]
    blocks = [_table(facts)]
    rows = [["", *(name for name, _ in runs)], *([what, *cells[what]] for what in whats if what not in shared)]
    if len(rows) > 1:
        columns = range(1, len(runs) + 1, RUNS_ABREAST)
        blocks += [_table([[row[0], *row[k : k + RUNS_ABREAST]] for row in rows]) for k in columns]
    warnings: dict[str, list[str]] = {}
    for what in whats:
        for name, found in runs:
            for finding in found:
                if finding.what == what and finding.warning:
                    warnings.setdefault(f"{what}: {finding.warning}", []).append(name)
    lines = refused
    for warning, names in warnings.items():
        some = names if len(names) <= RUNS_ABREAST else [*names[:RUNS_ABREAST], f"{len(names)} runs in all"]
        lines.append(f"warning: {warning}" + ("" if len(names) == len(runs) else f" ({', '.join(some)})"))
    return "\n\n".join(filter(None, [*blocks, "\n".join(lines)]))


def _solved(scenes: Sequence[Scene], fast: bool) -> Sequence[Probe | None]:
    if fast:
        return [None] * len(scenes)
    from rolling.check import probe  # the solver is slow to import

    return probe.probes(scenes)


def _cell(finding: Finding) -> str:
    return finding.value + (" !" if finding.warning else "")


def _table(rows: Sequence[Sequence[str]]) -> str:
    """Rows of cells, columns aligned."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join("  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip() for row in rows)


def _size(scene: Scene, way: Track) -> list[Finding]:
    duration = cost.duration(scene, way)
    size = f"{_si(way.n_along * way.spacing, 'm')} x {_si(way.n_across * way.spacing, 'm')}"
    return [
        Finding("steps", "steps", f"{way.steps} of {_si(way.step, 'm')}"),
        Finding("surface", "surface", f"{size}, {way.n_along} x {way.n_across} nodes"),
        Finding("distance", "distance rolled", f"{_si(way.distance, 'm')}{'' if way.closed else ', not closed'}"),
        Finding("duration", "duration", _si(duration, "s")),
        Finding("samples", "sound samples", f"{round(duration * SAMPLE_RATE)}"),
    ]


def _window(scene: Scene, way: Track, rq: float) -> list[Finding]:
    across = 2 * cost.overlap_radius(scene, rq)
    nodes = cost.window_nodes(scene, rq)
    warning = None
    period = min(way.n_along, way.n_across) * scene.spacing
    if across > period:
        side = "width" if way.n_across <= way.n_along else "length"
        key = {"width": "surface.width_um", "length": "rolling.duration_s"}[side]
        key = "height file" if isinstance(scene.surface, HeightFile) else key
        warning = (
            f"the contact is about {_si(across, 'm')} across, the surface has a {side} of {_si(period, 'm')}: choose a"
            f" larger {key}, at least {across * 1e6:.0f} um of surface"
        )
    step_ms = cost.expected_step_ms(nodes)
    seconds = way.steps * step_ms * 1e-3 / cost.cores()
    return [
        Finding("window", "window", f"about {nodes:.0f} x {nodes:.0f} nodes", warning),
        Finding("step_time", "time of a step", f"about {step_ms:.2g} ms on 1 core"),
        Finding("expected_time", "expected time", f"about {_clock(seconds)} on {_cores()}", seconds=seconds),
    ]


def _demand(scene: Scene, way: Track, rq: float) -> list[Finding]:
    needed = demand.demand([demand.size(scene, way, rq)], cost.cores())
    excess = _excess(needed, OUTPUTS)
    return [
        Finding(key, key, _amount(amount), f"{excess[key]}; the run will be refused" if key in excess else None)
        for key, amount in (("memory", needed.memory), ("disk", needed.disk))
    ]


def _amount(amount: demand.Amount) -> str:
    part, size = amount.largest
    return f"about {_bytes(amount.total)}, {_bytes(size)} for {PURPOSES.get(part, f'the {part}')}"


def _excess(needed: demand.Demand, folder: Path, written: float = 0.0) -> dict[str, str]:
    """Why a demand does not fit, by "memory" and "disk": the need, the limit, the part that dominates and its keys.

    Parameters
    ----------
    folder : where the files go.  written : bytes. Files of the run that are there already.
    """
    memory, address_space, disk = machine.memory(), machine.address_space(), machine.free_disk(folder)
    place = f"free where {folder} is" if folder.exists() else f"free where {folder} will be"
    limits = [
        ("memory", needed.memory, memory, "this machine allows"),
        ("memory", needed.process, address_space, "one process may address"),
        ("disk", needed.disk, disk + written, place),
    ]
    excess: dict[str, str] = {}
    for key, amount, limit, words in limits:
        if amount.total > machine.SHARE * limit and key not in excess:
            part = amount.largest[0]
            excess[key] = (
                f"needs {_amount(amount)}, allowed: {_bytes(machine.SHARE * limit)}, {100 * machine.SHARE:.0f} % of the"
                f" {_bytes(limit)} {words}; {demand.ADVICE[part]}"
            )
    return excess


def _contact(scene: Scene, way: Track) -> list[Finding]:
    a, p0 = _hertz(scene)
    result = [
        Finding("hertz_radius", "Hertz radius", _si(a, "m")),
        Finding("hertz_pressure", "Hertz pressure", _si(p0, "Pa")),
    ]
    if not math.isfinite(scene.hardness):
        result.append(Finding("hardness", "hardness", "none, purely elastic"))
    else:
        says = "yields" if p0 > scene.hardness else "above the Hertz pressure of a smooth sphere; asperities may yield"
        result.append(Finding("hardness", "hardness", f"{_si(scene.hardness, 'Pa')}, {says}"))
        capacity = scene.hardness * way.n_along * way.n_across * way.spacing**2
        warning = None
        if scene.load >= capacity:
            warning = (
                f"the load is {scene.load:g} N, hardness times one period of the surface is {_si(capacity, 'N')}:"
                " the run will be refused; lower rolling.load_n or enlarge the surface"
            )
        result.append(Finding("capacity", "capacity", _si(capacity, "N"), warning))
    nodes = a / scene.spacing
    coarse = None
    if nodes < LEAST_HERTZ_NODES:
        coarse = (
            f"{nodes:.2g} nodes across the Hertz radius, {LEAST_HERTZ_NODES} are wanted: choose a surface.spacing_um of"
            f" at most {_down(a / LEAST_HERTZ_NODES * 1e6)}"
        )
    return [*result, Finding("hertz_nodes", "nodes per Hertz radius", f"{nodes:.3g}", coarse)]


def _sampling(scene: Scene, way: Track) -> list[Finding]:
    result = [_nyquist(scene, way), _step_length(scene, way)]
    if scene.numerics.step_nodes < 1:
        result.append(_grid_tone(scene, way))
    if isinstance(scene.surface, Gaussian):
        shortest = min(cost.correlation_lengths(scene.surface))
        nodes = shortest / scene.surface.spacing_um
        coarse = None
        if nodes < LEAST_CORRELATION_NODES * (1 - 1e-9):
            coarse = (
                f"{nodes:.2g} nodes per correlation length, {LEAST_CORRELATION_NODES} are wanted: choose a"
                f" surface.spacing_um of at most {_down(shortest / LEAST_CORRELATION_NODES)}"
            )
        result.append(Finding("correlation_nodes", "nodes per correlation length", f"{nodes:.3g}", coarse))
    return result


def _nyquist(scene: Scene, way: Track) -> Finding:
    """Say up to where the steps carry sound, and for how much of the record that is below the end of hearing."""
    motion, duration = scene.motion, cost.duration(scene, way)
    low, high = (speed / (2 * way.step) for speed in (motion.slowest(duration), motion.fastest(duration)))
    if motion.is_constant(duration):
        return Finding("nyquist", "simulated Nyquist", _si(high, "Hz"), _short_band(way, motion.fastest(duration)))
    wanted = 2 * HEARING[1] * way.step
    seconds = motion.time_below(wanted, duration)
    warning = None
    if seconds >= LEAST_SHARE * duration:
        warning = (
            f"for {100 * seconds / duration:.3g} % of the record ({_si(seconds, 's')}) the simulated band ends below"
            f" {_si(HEARING[1], 'Hz')}, at {_si(low, 'Hz')} when the sphere is slowest ({motion.slowest(duration):.3g} m/s):"
            " the bands above hold the sound of the faster stretches alone; choose a step of at most"
            f" {_down(_usual_speed(scene, duration) / (2 * HEARING[1]) * 1e6)} um (numerics.step_nodes or"
            f" surface.spacing_um) or a speed of at least {_up(wanted)} m/s for {100 - 100 * LEAST_SHARE:g} % of the record"
        )
    return Finding("nyquist", "simulated Nyquist", f"{_si(low, 'Hz')} to {_si(high, 'Hz')}", warning)


def _short_band(way: Track, speed: float) -> str | None:
    """Warn of a simulated band that ends below hearing at a constant speed [m/s]."""
    if speed / (2 * way.step) >= HEARING[1]:
        return None
    return (
        f"the simulated band ends at {_si(speed / (2 * way.step), 'Hz')} at {speed:g} m/s, hearing at"
        f" {_si(HEARING[1], 'Hz')}: choose a step of at most {_down(speed / (2 * HEARING[1]) * 1e6)} um"
        f" (numerics.step_nodes or surface.spacing_um) or a speed of at least {_up(2 * HEARING[1] * way.step)} m/s"
    )


def _usual_speed(scene: Scene, duration: float) -> float:
    """Return the speed [m/s] below which the sphere rolls for less than `LEAST_SHARE` of the record."""
    low, high = 0.0, scene.motion.fastest(duration)
    for _ in range(60):
        middle = (low + high) / 2
        below = scene.motion.time_below(middle, duration) < LEAST_SHARE * duration
        low, high = (middle, high) if below else (low, middle)
    return low or high


def _grid_tone(scene: Scene, way: Track) -> Finding:
    """Name the tone that steps below a node sound."""
    motion, duration = scene.motion, cost.duration(scene, way)
    low, high = (speed / scene.spacing for speed in (motion.slowest(duration), motion.fastest(duration)))
    tone = _si(low, "Hz") if motion.is_constant(duration) else f"{_si(low, 'Hz')} to {_si(high, 'Hz')}"
    audible = None
    if motion.time_below(HEARING[1] * scene.spacing, duration) >= LEAST_SHARE * duration:
        audible = (
            f"steps below one node sound a tone of the grid at {tone}: choose numerics.step_nodes 1 or a"
            f" surface.spacing_um of at most {_down(_usual_speed(scene, duration) / HEARING[1] * 1e6)}"
        )
    return Finding("grid_tone", "tone of the grid", tone, audible)


def _step_length(scene: Scene, way: Track) -> Finding:
    """Compare the step with the contact, and say what a long one costs."""
    radius = long_steps.contact_radius(scene)
    radii = way.step / radius
    warning = None
    if radii > long_steps.DOUBTFUL_RADII:
        lost = long_steps.lost_release(radii)
        warning = (
            f"a step is {radii:.2g} contact radii of {_si(radius, 'm')}, at most {long_steps.DOUBTFUL_RADII:g} are wanted:"
            f" the mean release is up to about {100 * lost:.2g} % low, levels are off by up to"
            f" {long_steps.LEVEL_ERROR_DB * radii:.2g} dB; choose a step of at most"
            f" {_down(long_steps.DOUBTFUL_RADII * radius * 1e6)} um (numerics.step_nodes or surface.spacing_um)"
        )
    return Finding("step_length", "step / contact radius", f"{radii:.2g}", warning)


def _validity(scene: Scene, slope: float) -> list[Finding]:
    steep = wide = None
    if slope > GREATEST_SLOPE:
        advice = "filter the shortest wavelengths out of the heights" if isinstance(scene.surface, HeightFile) else ""
        advice = advice or "lower surface.roughness_ra_um or lengthen surface.correlation_length_um"
        steep = f"the rms slope is {slope:.2g}, a half-space holds up to {GREATEST_SLOPE:g}: {advice}"
    share = long_steps.contact_radius(scene) / scene.radius
    if share > GREATEST_CONTACT:
        wide = (
            f"the contact radius is {share:.2g} of the sphere's, a half-space holds up to {GREATEST_CONTACT:g}: lower"
            " rolling.load_n or enlarge sphere.radius_mm"
        )
    return [
        Finding("slope", "rms slope", f"{slope:.2g}", steep),
        Finding("contact_radius", "contact radius / radius", f"{share:.2g}", wide),
    ]


def _resonance(scene: Scene, way: Track) -> Finding:
    """Name the frequency at which the ball bounces, and weigh its part by the greatest speed, where the record holds it."""
    frequency = resonance.frequency(scene)
    speed = scene.motion.fastest(cost.duration(scene, way))
    highest = min(HEARING[1], speed / (2 * way.step))
    if not HEARING[0] < frequency < highest:
        return Finding("resonance", "contact resonance", _si(frequency, "Hz"))
    density = scene.sphere.density_kg_m3
    ball = "as if of steel, 7850 kg/m3 (sphere.density_kg_m3)" if density is None else f"of {density:g} kg/m3"
    wave = resonance.relative_wave(scene, speed)
    if wave < resonance.FELT:
        part = "its part is some 30 dB or more below the release, and the levels hold"
    elif wave < resonance.DOMINANT:
        part = "its part is heard: do not trust the bands about that frequency"
    else:
        part = (
            "it is a large part of the sound or most of it: do not trust levels, nor bands from a half of that frequency up,"
            " or choose a lower rolling.speed_m_s"
        )
    warning = (
        f"a free ball {ball} would bounce on its contact at {_si(frequency, 'Hz')}, inside hearing and the"
        f" simulated band, and the load is held constant here; at {speed:.3g} m/s waves of {_si(speed / frequency, 'm')} feed"
        f" it, {wave:.2g} of contact radius and correlation length: {part}"
    )
    return Finding("resonance", "contact resonance", _si(frequency, "Hz"), warning)


def _record(scene: Scene, way: Track) -> Finding:
    certain = bands.reliable(cost.duration(scene, way))
    warning = None
    if not certain.all():
        short = [name for name, sure in zip(bands.BAND_NAMES, certain, strict=True) if not sure]
        warning = (
            f"{len(short)} of {len(certain)} third octaves, up to {short[-1]} Hz, have a bandwidth times duration below"
            f" {bands.LEAST_BT:g} and are uncertain by 2 dB or more: for all of them choose a rolling.duration_s of at"
            f" least {_up(bands.LEAST_BT / float(bands.BANDWIDTH_HZ[0]))}"
        )
    return Finding("third_octaves", "certain third octaves", f"{certain.sum()} of {len(certain)}", warning)


def _hertz(scene: Scene) -> tuple[float, float]:
    """Radius [m] and peak pressure [Pa] of the smooth elastic contact."""
    three = (scene.load, scene.radius, scene.contact_modulus)
    return reference.hertz_radius(*three), reference.hertz_pressure(*three)


def _replaced(findings: Sequence[Finding], better: Sequence[Finding]) -> list[Finding]:
    """Findings with better ones in the place of those with the same key, whose warnings stay, and the others after these."""
    by_key = {finding.key: finding for finding in better}
    result: list[Finding] = []
    for finding in findings:
        instead = by_key.pop(finding.key, finding)
        result.append(replace(instead, warning=instead.warning or finding.warning))
    return [*result, *by_key.values()]
