"""Size and cost of a run: steps, nodes, window, expected time, memory and disk."""

from __future__ import annotations

from rolling.check import cost, demand, refusals
from rolling.check.finding import Finding, clock, on_cores, si
from rolling.scene.scene import Scene
from rolling.scene.sections import HeightFile
from rolling.scene.track import Track


def findings(scene: Scene, track: Track, rq: float) -> list[Finding]:
    """State size and cost of a run.

    Parameters
    ----------
    rq : float, m
        Rms roughness of the surface.
    """
    return [*_track(scene, track), *_window(scene, track, rq), *_demand(scene, track, rq)]


def _track(scene: Scene, track: Track) -> list[Finding]:
    duration = cost.duration(scene, track)
    size = f"{si(track.n_along * track.spacing, 'm')} x {si(track.n_across * track.spacing, 'm')}"
    return [
        Finding("steps", "steps", f"{track.steps} of {si(track.step, 'm')}"),
        Finding("surface", "surface", f"{size}, {track.n_along} x {track.n_across} nodes"),
        Finding("distance", "distance rolled", f"{si(track.distance, 'm')}{'' if track.closed else ', not closed'}"),
        Finding("duration", "duration", si(duration, "s")),
        Finding("samples", "sound samples", f"{round(duration * demand.SAMPLE_RATE)}"),
    ]


def _window(scene: Scene, track: Track, rq: float) -> list[Finding]:
    across = 2 * cost.overlap_radius(scene, rq)
    nodes = cost.window_nodes(scene, rq)
    warning = None
    period = min(track.n_along, track.n_across) * scene.spacing
    if across > period:
        side = "width" if track.n_across <= track.n_along else "length"
        key = {"width": "surface.width_um", "length": "rolling.duration_s"}[side]
        key = "height file" if isinstance(scene.surface, HeightFile) else key
        warning = (
            f"the contact is about {si(across, 'm')} across, the surface has a {side} of {si(period, 'm')}: choose a"
            f" larger {key}, at least {across * 1e6:.0f} um of surface"
        )
    step_ms = cost.expected_step_ms(nodes)
    seconds = track.steps * step_ms * 1e-3 / cost.cores()
    return [
        Finding("window", "window", f"about {nodes:.0f} x {nodes:.0f} nodes", warning),
        Finding("step_time", "time of a step", f"about {step_ms:.2g} ms on 1 core"),
        Finding("expected_time", "expected time", f"about {clock(seconds)} on {on_cores()}", seconds=seconds),
    ]


def _demand(scene: Scene, track: Track, rq: float) -> list[Finding]:
    needed = demand.demand([demand.size(scene, track, rq)], cost.cores())
    excess = refusals.excess(needed, refusals.OUTPUTS)
    return [
        Finding(
            key, key, refusals.amount_text(amount), f"{excess[key]}; the run will be refused" if key in excess else None
        )
        for key, amount in (("memory", needed.memory), ("disk", needed.disk))
    ]
