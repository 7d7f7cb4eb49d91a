"""Sampling of contact, surface and sound: Nyquist frequency, steps, nodes, length of the record."""

from __future__ import annotations

from acoustics import bands
from rolling.check import cost, long_steps, resolution
from rolling.check.finding import Finding, rounded_down, rounded_up, si
from rolling.scene.scene import Scene
from rolling.scene.surfaces import Gaussian

HEARING = (bands.NOMINAL_HZ[0], bands.NOMINAL_HZ[-1])  # [Hz]
MIN_SHARE = 0.01  # share of a record; shorter stretches that are too slow for hearing are ignored
MIN_CORRELATION_NODES = 5  # of a measurement, across the correlation length


def findings(scene: Scene) -> list[Finding]:
    """Judge the step against hearing and contact, and the spacing against the heights."""
    tone = [_grid_tone(scene)] if scene.numerics.step_nodes < 1 else []
    return [_nyquist(scene), _step_length(scene), *tone, *_correlation(scene)]


def _correlation(scene: Scene) -> list[Finding]:
    """Count the nodes per correlation length of a made surface, and judge their resolution."""
    if not isinstance(scene.surface, Gaussian):
        return []
    nodes = min(cost.correlation_lengths(scene.surface)) / scene.surface.spacing_um
    count = Finding("correlation_nodes", "nodes per correlation length", f"{nodes:.3g}")
    return [count, *resolution.findings(scene)]


def _nyquist(scene: Scene) -> Finding:
    """Judge the Nyquist frequency of the steps against the end of hearing.

    At a varying speed the share of the record with a short band counts.
    """
    motion, duration = scene.motion, scene.duration
    low, high = (
        speed / (2 * scene.track.step)
        for speed in (motion.slowest(duration), motion.fastest(duration))
    )
    if motion.is_constant(duration):
        return Finding(
            "nyquist",
            "simulated Nyquist",
            si(high, "Hz"),
            _short_band(scene, motion.fastest(duration)),
        )
    wanted = 2 * HEARING[1] * scene.track.step
    seconds = motion.time_below(wanted, duration)
    warning = None
    if seconds >= MIN_SHARE * duration:
        warning = (
            f"for {100 * seconds / duration:.3g} % of the record ({si(seconds, 's')}) the simulated"
            f" band ends below {si(HEARING[1], 'Hz')}, at {si(low, 'Hz')} when the sphere is"
            f" slowest ({motion.slowest(duration):.3g} m/s): the bands above hold the sound of the"
            " faster stretches alone; choose a step of at most"
            f" {rounded_down(_usual_speed(scene, duration) / (2 * HEARING[1]) * 1e6)} um"
            " (numerics.step_nodes or surface.spacing_um) or a speed of at least"
            f" {rounded_up(wanted)} m/s for {100 - 100 * MIN_SHARE:g} % of the record"
        )
    return Finding("nyquist", "simulated Nyquist", f"{si(low, 'Hz')} to {si(high, 'Hz')}", warning)


def _short_band(scene: Scene, speed: float) -> str | None:
    """Warn of a simulated band that ends below hearing at a constant speed [m/s]."""
    if speed / (2 * scene.track.step) >= HEARING[1]:
        return None
    return (
        f"the simulated band ends at {si(speed / (2 * scene.track.step), 'Hz')} at {speed:g} m/s,"
        f" hearing at {si(HEARING[1], 'Hz')}: choose a step of at most"
        f" {rounded_down(speed / (2 * HEARING[1]) * 1e6)} um (numerics.step_nodes or"
        " surface.spacing_um) or a speed of at least"
        f" {rounded_up(2 * HEARING[1] * scene.track.step)} m/s"
    )


def _usual_speed(scene: Scene, duration: float) -> float:
    """Return the speed [m/s] that the sphere reaches for most of the record.

    It rolls more slowly for less than `MIN_SHARE` of the record.
    """
    low, high = 0.0, scene.motion.fastest(duration)
    for _ in range(60):
        middle = (low + high) / 2
        below = scene.motion.time_below(middle, duration) < MIN_SHARE * duration
        low, high = (middle, high) if below else (low, middle)
    return low or high


def _grid_tone(scene: Scene) -> Finding:
    """Name the tone of the grid that steps below a node make audible."""
    motion, duration = scene.motion, scene.duration
    low, high = (
        speed / scene.spacing for speed in (motion.slowest(duration), motion.fastest(duration))
    )
    tone = si(low, "Hz") if motion.is_constant(duration) else f"{si(low, 'Hz')} to {si(high, 'Hz')}"
    audible = None
    if motion.time_below(HEARING[1] * scene.spacing, duration) >= MIN_SHARE * duration:
        audible = (
            f"steps below one node sound a tone of the grid at {tone}: choose numerics.step_nodes 1"
            " or a surface.spacing_um of at most"
            f" {rounded_down(_usual_speed(scene, duration) / HEARING[1] * 1e6)}"
        )
    return Finding("grid_tone", "tone of the grid", tone, audible)


def _step_length(scene: Scene) -> Finding:
    """Compare the step with the contact, and state the error of a long step."""
    radius = long_steps.contact_radius(scene)
    radii = scene.track.step / radius
    warning = None
    if radii > long_steps.DOUBTFUL_RADII:
        lost = long_steps.lost_release(radii)
        warning = (
            f"a step is {radii:.2g} contact radii of {si(radius, 'm')}, at most"
            f" {long_steps.DOUBTFUL_RADII:g} are wanted: the mean release is up to about"
            f" {100 * lost:.2g} % low, levels are off by up to"
            f" {long_steps.LEVEL_ERROR_DB * radii:.2g} dB; choose a step of at most"
            f" {rounded_down(long_steps.DOUBTFUL_RADII * radius * 1e6)} um (numerics.step_nodes or"
            " surface.spacing_um)"
        )
    return Finding("step_length", "step / contact radius", f"{radii:.2g}", warning)


def record(scene: Scene) -> Finding:
    """Count the third octaves whose level the length of the record makes certain."""
    certain = bands.reliable(scene.duration)
    warning = None
    if not certain.all():
        short = [name for name, sure in zip(bands.BAND_NAMES, certain, strict=True) if not sure]
        seconds = bands.LEAST_BT / float(bands.BANDWIDTH_HZ[0])
        longer = f"rolling.duration_s of at least {rounded_up(seconds)}"
        if scene.rolling.distance_mm is not None:
            rolled = seconds * scene.track.distance / scene.duration
            longer = f"rolling.distance_mm of at least {rounded_up(1e3 * rolled)}"
        warning = (
            f"{len(short)} of {len(certain)} third octaves, up to {short[-1]} Hz, have a bandwidth"
            f" times duration below {bands.LEAST_BT:g} and are uncertain by 2 dB or more: for all"
            f" of them choose a {longer}"
        )
    return Finding(
        "third_octaves", "certain third octaves", f"{certain.sum()} of {len(certain)}", warning
    )
