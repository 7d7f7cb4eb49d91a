"""What a scene will cost and whether it can be believed, said before anything is computed.

Depends on `scenario` (what is asked), `cost`, `reference` (Hertz), `measured` (height files) and `acoustics.bands`; `report` on
`probe`, which solves.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from importlib.util import find_spec
from typing import TYPE_CHECKING

from acoustics import bands
from rolling import cost, measured, reference
from rolling.finding import Finding
from rolling.finding import byte_size as _bytes
from rolling.finding import clock as _clock
from rolling.finding import on_cores as _cores
from rolling.finding import rounded_down as _down
from rolling.finding import rounded_up as _up
from rolling.finding import si as _si
from rolling.scenario import Gaussian, HeightFile, Scene, SceneError, Track, expand, run_name, track

if TYPE_CHECKING:
    from rolling.probe import Probe

HEARING = (bands.NOMINAL_HZ[0], bands.NOMINAL_HZ[-1])  # [Hz]
SAMPLE_RATE = 48_000  # [Hz], acoustics.wav.SAMPLE_RATE_HZ, which is slow to import
STEEL = 7850.0  # [kg/m3]
LEAST_HERTZ_NODES = 10  # across the Hertz radius
LEAST_CORRELATION_NODES = 5  # across the correlation length
GREATEST_SLOPE = 0.3  # rms norm of the gradient that a half-space may have
GREATEST_CONTACT = 0.2  # contact radius over sphere radius
RUNS_ABREAST = 5  # columns of the report


def findings(scene: Scene, solved: Probe | None = None) -> list[Finding]:
    """Judge one run; a sweep is not looked at.

    Parameters
    ----------
    solved : positions that were solved; their numbers replace those of the closed forms. None: nothing is solved.

    Raises
    ------
    SceneError : the height file cannot be used.
    """
    way = track(scene)
    rq, slope = cost.roughness(scene)
    closed_forms = [
        *_size(scene, way),
        *_window(scene, way, rq),
        *_contact(scene, way),
        *_sampling(scene, way),
        *measured.findings(scene, way, _contact_radius(scene), LEAST_CORRELATION_NODES, cost.duration(scene, way)),
        *_validity(scene, slope),
        _resonance(scene),
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


def report(scene: Scene, fast: bool = False) -> str:
    """Write the findings of a scene as a table: values that all its runs share, then a column per run, the warnings below.

    Parameters
    ----------
    fast : solve no positions.

    Raises
    ------
    SceneError : a height file cannot be used, or something it asks for cannot be had.
    """
    refuse_unavailable(scene)
    expanded = expand(scene)
    runs = [
        (run_name(values) or scene.name, findings(run, solved))
        for (values, run), solved in zip(expanded, _solved([run for _, run in expanded], fast), strict=True)
    ]
    whats = list(dict.fromkeys(finding.what for _, found in runs for finding in found))
    cells = {what: [next((_cell(f) for f in found if f.what == what), "") for _, found in runs] for what in whats}
    shared = [what for what in whats if len(set(cells[what])) == 1]
    facts = [[what, cells[what][0]] for what in shared]
    if len(runs) > 1:
        seconds = sum(finding.seconds for _, found in runs for finding in found)
        facts.append(["expected time of all", f"about {_clock(seconds)} on {_cores()}, {len(runs)} runs"])
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
    lines = []
    for warning, names in warnings.items():
        some = names if len(names) <= RUNS_ABREAST else [*names[:RUNS_ABREAST], f"{len(names)} runs in all"]
        lines.append(f"warning: {warning}" + ("" if len(names) == len(runs) else f" ({', '.join(some)})"))
    return "\n\n".join(filter(None, [*blocks, "\n".join(lines)]))


def _solved(scenes: Sequence[Scene], fast: bool) -> Sequence[Probe | None]:
    if fast:
        return [None] * len(scenes)
    from rolling import probe  # the solver is slow to import

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
    memory = cost.memory(scene, way, nodes)
    machine = cost.machine_memory()
    too_much = (
        f"about {_bytes(memory)} are needed, this machine has {_bytes(machine)}: shorten rolling.duration_s or widen"
        " surface.spacing_um"
        if memory > machine
        else None
    )
    step_ms = cost.expected_step_ms(nodes)
    seconds = way.steps * step_ms * 1e-3 / cost.cores()
    return [
        Finding("window", "window", f"about {nodes:.0f} x {nodes:.0f} nodes", warning),
        Finding("memory", "memory", f"about {_bytes(memory)}", too_much),
        Finding("step_time", "time of a step", f"about {step_ms:.2g} ms on 1 core"),
        Finding("expected_time", "expected time", f"about {_clock(seconds)} on {_cores()}", seconds=seconds),
    ]


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
    slowest, fastest = _speeds(scene, way)
    low, high = slowest / (2 * way.step), fastest / (2 * way.step)
    warning = None
    if low < HEARING[1]:
        warning = (
            f"the simulated band ends at {_si(low, 'Hz')} at {slowest:g} m/s, hearing at {_si(HEARING[1], 'Hz')}:"
            f" choose a step of at most {_down(slowest / (2 * HEARING[1]) * 1e6)} um (numerics.step_nodes or"
            f" surface.spacing_um) or a speed of at least {_up(2 * HEARING[1] * way.step)} m/s"
        )
    nyquist = _si(low, "Hz") if low == high else f"{_si(low, 'Hz')} to {_si(high, 'Hz')}"
    result = [Finding("nyquist", "simulated Nyquist", nyquist, warning)]
    if scene.numerics.step_nodes < 1:
        tone = slowest / scene.spacing
        audible = None
        if tone < HEARING[1]:
            audible = (
                f"steps below one node sound a tone of the grid at {_si(tone, 'Hz')}: choose numerics.step_nodes 1 or a"
                f" surface.spacing_um of at most {_down(slowest / HEARING[1] * 1e6)}"
            )
        result.append(Finding("grid_tone", "tone of the grid", _si(tone, "Hz"), audible))
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


def _validity(scene: Scene, slope: float) -> list[Finding]:
    steep = wide = None
    if slope > GREATEST_SLOPE:
        advice = "filter the shortest wavelengths out of the heights" if isinstance(scene.surface, HeightFile) else ""
        advice = advice or "lower surface.roughness_ra_um or lengthen surface.correlation_length_um"
        steep = f"the rms slope is {slope:.2g}, a half-space holds up to {GREATEST_SLOPE:g}: {advice}"
    share = _contact_radius(scene) / scene.radius
    if share > GREATEST_CONTACT:
        wide = (
            f"the contact radius is {share:.2g} of the sphere's, a half-space holds up to {GREATEST_CONTACT:g}: lower"
            " rolling.load_n or enlarge sphere.radius_mm"
        )
    return [
        Finding("slope", "rms slope", f"{slope:.2g}", steep),
        Finding("contact_radius", "contact radius / radius", f"{share:.2g}", wide),
    ]


def _resonance(scene: Scene) -> Finding:
    a, _ = _hertz(scene)
    mass = STEEL * 4 / 3 * math.pi * scene.radius**3
    frequency = math.sqrt(2 * scene.contact_modulus * a / mass) / (2 * math.pi)
    warning = None
    if HEARING[0] < frequency < HEARING[1]:
        warning = (
            f"a free steel ball would bounce on its contact at {_si(frequency, 'Hz')}, inside hearing, and the load is"
            " held constant here: do not trust levels about that frequency, or choose another sphere.radius_mm or"
            " rolling.load_n"
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


def _contact_radius(scene: Scene) -> float:
    """About the radius of the contact [m]: of the elastic one, or of the one that yields everywhere where that is larger."""
    a, _ = _hertz(scene)
    return max(a, math.sqrt(scene.load / (math.pi * scene.hardness))) if math.isfinite(scene.hardness) else a


def _replaced(findings: Sequence[Finding], better: Sequence[Finding]) -> list[Finding]:
    """Findings with better ones in the place of those with the same key, whose warnings stay, and the others after these."""
    by_key = {finding.key: finding for finding in better}
    result: list[Finding] = []
    for finding in findings:
        instead = by_key.pop(finding.key, finding)
        result.append(replace(instead, warning=instead.warning or finding.warning))
    return [*result, *by_key.values()]


def _speeds(scene: Scene, way: Track) -> tuple[float, float]:
    """Least (not zero) and greatest speed [m/s] of the profile's points while the track lasts."""
    motion, end = scene.motion, cost.duration(scene, way)
    speeds = [v for t, v in zip(motion.times, motion.speeds, strict=True) if t < end] + [float(motion.speed(end))]
    moving = [v for v in speeds if v > 1e-9 * motion.fastest] or [motion.fastest]
    return min(moving), max(moving)
