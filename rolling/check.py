"""What a scene will cost and whether it can be believed, said before anything is computed.

Depends on `scenario` (what is asked), `cost`, `long_steps`, `resonance`, `reference` (Hertz) and `acoustics.bands`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec

from acoustics import bands
from rolling import cost, long_steps, reference, resonance
from rolling.scenario import Gaussian, HeightFile, Scene, SceneError, Track, expand, run_name, track

HEARING = (bands.NOMINAL_HZ[0], bands.NOMINAL_HZ[-1])  # [Hz]
SAMPLE_RATE = 48_000  # [Hz], acoustics.wav.SAMPLE_RATE_HZ, which is slow to import
LEAST_SHARE = 0.01  # of a record: a shorter stretch that is too slow for hearing is not worth a word
LEAST_HERTZ_NODES = 10  # across the Hertz radius
LEAST_CORRELATION_NODES = 5  # across the correlation length
GREATEST_SLOPE = 0.3  # rms norm of the gradient that a half-space may have
GREATEST_CONTACT = 0.2  # contact radius over sphere radius
RUNS_ABREAST = 5  # columns of the report


@dataclass(frozen=True)
class Finding:
    """One line of the check.

    key : name for programs, which never changes with the wording.
    what, value : quantity and its value as text with unit.
    warning : number that is doubtful and what to change, or None.
    seconds : of computing, which the runs of a sweep add up.
    """

    key: str
    what: str
    value: str
    warning: str | None = None
    seconds: float = 0.0


def findings(scene: Scene) -> list[Finding]:
    """All there is to say about one run; a sweep is not looked at.

    Raises
    ------
    SceneError : the height file cannot be used.
    """
    way = track(scene)
    rq, slope = cost.roughness(scene)
    return [
        *_size(scene, way),
        *_window(scene, way, rq),
        *_contact(scene, way),
        *_sampling(scene, way),
        *_validity(scene, slope),
        _resonance(scene, way),
        _record(scene, way),
    ]


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


def report(scene: Scene) -> str:
    """The findings of a scene as a table: what holds for all its runs, then a column per run, the warnings below.

    Raises
    ------
    SceneError : a height file cannot be used, something it asks for cannot be had, or its steps are too long.
    """
    refuse_unavailable(scene)
    long_steps.refuse_long_steps(scene)
    runs = [(run_name(values) or scene.name, findings(run)) for values, run in expand(scene)]
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
        says = "yields" if p0 > scene.hardness else "stays elastic"
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


def _si(value: float, unit: str) -> str:
    """Three digits and a prefix: 6.87e-5, "m" gives "68.7 um"."""
    for prefix, size in (("G", 1e9), ("M", 1e6), ("k", 1e3), ("", 1.0), ("m", 1e-3), ("u", 1e-6), ("n", 1e-9)):
        if (unit, prefix) not in (("m", "G"), ("m", "M"), ("m", "k")) and abs(value) >= 0.9995 * size:
            digits = f"{value / size:.3g}"
            return f"{float(digits):g} {prefix}{unit}"
    return f"{value:.3g} {unit}"


def _bytes(value: float) -> str:
    return f"{value / 1e9:.2g} GB" if value >= 1e9 else f"{max(value / 1e6, 1):.0f} MB"


def _cores() -> str:
    return f"{cost.cores()} cores" if cost.cores() > 1 else "1 core"


def _clock(seconds: float) -> str:
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * size:
            return f"{seconds / size:.2g} {unit}"
    return f"{seconds:.2g} s"


def _down(value: float) -> str:
    """Two digits, rounded so that the advice holds."""
    return f"{_rounded(value, math.floor):g}"


def _up(value: float) -> str:
    return f"{_rounded(value, math.ceil):g}"


def _rounded(value: float, towards: Callable[[float], int]) -> float:
    size = 10.0 ** (math.floor(math.log10(value)) - 1)
    # What is a whole number but for rounding stays.
    return towards(round(value / size, 9)) * size
