"""Size and cost of a run: steps, nodes, window, expected time, memory and disk."""

from __future__ import annotations

from rolling.check import cost, demand, error_cost, refusals, tolerance
from rolling.check.finding import Finding, clock, on_cores, si
from rolling.scene.scene import Scene
from rolling.scene.surfaces import HeightFile


def findings(scene: Scene, rq: float) -> list[Finding]:
    """State size and cost of a run.

    Parameters
    ----------
    rq : float, m
        Rms roughness of the surface.
    """
    return [
        *_track(scene),
        *_window(scene, rq),
        _tolerance(scene, rq),
        *_errors(scene, rq),
        *_demand(scene, rq),
    ]


def _track(scene: Scene) -> list[Finding]:
    duration = scene.duration
    size = (
        f"{si(scene.track.n_along * scene.track.spacing, 'm')} x"
        f" {si(scene.track.n_across * scene.track.spacing, 'm')}"
    )
    return [
        Finding("steps", "steps", f"{scene.track.steps} of {si(scene.track.step, 'm')}"),
        Finding(
            "surface", "surface", f"{size}, {scene.track.n_along} x {scene.track.n_across} nodes"
        ),
        Finding(
            "distance",
            "distance rolled",
            f"{si(scene.track.distance, 'm')}{'' if scene.track.closed else ', not closed'}",
        ),
        Finding("duration", "duration", si(duration, "s")),
        Finding("samples", "sound samples", f"{round(duration * demand.SAMPLE_RATE)}"),
    ]


def _window(scene: Scene, rq: float) -> list[Finding]:
    across = 2 * cost.overlap_radius(scene, rq)
    nodes = cost.window_nodes(scene, rq)
    warning = None
    period = min(scene.track.n_along, scene.track.n_across) * scene.spacing
    if across > period:
        side = "width" if scene.track.n_across <= scene.track.n_along else "length"
        length = "duration_s" if scene.rolling.distance_mm is None else "distance_mm"
        key = {"width": "surface.width_um", "length": f"rolling.{length}"}[side]
        is_file = isinstance(scene.surface, HeightFile)
        is_profile = is_file and scene.surface.width_um is not None
        key = "height file" if is_file and not (is_profile and side == "width") else key
        warning = (
            f"the contact is about {si(across, 'm')} across, the surface has a {side} of"
            f" {si(period, 'm')}: choose a larger {key}, at least {across * 1e6:.0f} um of surface"
        )
    step_ms = cost.expected_step_ms(nodes, cost.subcells(scene), cost.step_law(scene, rq))
    seconds = scene.track.steps * step_ms * 1e-3 / cost.cores()
    return [
        Finding("window", "window", f"about {nodes:.0f} x {nodes:.0f} nodes", warning),
        Finding("step_time", "time of a step", f"about {step_ms:.2g} ms on 1 core"),
        Finding(
            "expected_time",
            "expected time",
            f"about {clock(seconds)} on {on_cores()}",
            seconds=seconds,
        ),
    ]


def _tolerance(scene: Scene, rq: float) -> Finding:
    """State the tolerance, or the trial that will choose it."""
    nodes, law = cost.window_nodes(scene, rq), cost.step_law(scene, rq)
    step_ms = cost.expected_step_ms(nodes, cost.subcells(scene), law)
    return tolerance.finding(scene, step_ms * 1e-3 / cost.cores())


def _errors(scene: Scene, rq: float) -> list[Finding]:
    """State the cost of the error estimate; nothing where the scene does not ask for it."""
    if not scene.numerics.error_estimate:
        return []
    nodes, law = cost.window_nodes(scene, rq), cost.step_law(scene, rq)
    step_ms = cost.expected_step_ms(nodes, cost.subcells(scene), law)
    share = error_cost.cost_share(scene, cost.STEP_LAWS[law][1])
    seconds = share * error_cost.marched_steps(scene) * step_ms * 1e-3 / cost.cores()
    if not share:
        reason = error_cost.too_short(scene) or "a smooth surface makes no sound"
        return [Finding("error_estimate", "error estimate", f"none: {reason}")]
    steps = error_cost.stretch_steps(scene)
    count = len(error_cost.layout(scene, steps).firsts)
    return [
        Finding(
            "error_estimate",
            "error estimate",
            f"up to {count} stretches of {steps} steps, about {clock(seconds)} on {on_cores()}"
            f" ({share:.0%} more)",
            seconds=seconds,
        )
    ]


def _demand(scene: Scene, rq: float) -> list[Finding]:
    needed = demand.demand([demand.size(scene, rq)], cost.cores())
    excess = refusals.excess(needed, refusals.OUTPUTS)
    return [
        Finding(
            key,
            key,
            refusals.amount_text(amount),
            f"{excess[key]}; the run will be refused" if key in excess else None,
        )
        for key, amount in (("memory", needed.memory), ("disk", needed.disk))
    ]
