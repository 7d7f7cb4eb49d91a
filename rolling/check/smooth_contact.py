"""Contact of a smooth sphere by closed forms: radius, pressure, hardness and load capacity."""

from __future__ import annotations

import math

from rolling.check.finding import Finding, rounded_down, si
from rolling.contact import closed_forms
from rolling.scene.scene import Scene

MIN_HERTZ_NODES = 10  # across the Hertz radius


def findings(scene: Scene) -> list[Finding]:
    """State the smooth elastic contact, its hardness, and the nodes that resolve it."""
    radius = closed_forms.hertz_radius(scene.load, scene.radius, scene.contact_modulus)
    pressure = closed_forms.hertz_pressure(scene.load, scene.radius, scene.contact_modulus)
    return [
        Finding("hertz_radius", "Hertz radius", si(radius, "m")),
        Finding("hertz_pressure", "Hertz pressure", si(pressure, "Pa")),
        *_hardness(scene, pressure),
        _nodes(scene, radius),
    ]


def _hardness(scene: Scene, pressure: float) -> list[Finding]:
    """Compare the hardness with the Hertz pressure [Pa].

    The load is compared with the plastic capacity of the surface.
    """
    if not math.isfinite(scene.hardness):
        return [Finding("hardness", "hardness", "none, purely elastic")]
    says = (
        "yields"
        if pressure > scene.hardness
        else "above the Hertz pressure of a smooth sphere; asperities may yield"
    )
    capacity = scene.hardness * scene.track.n_along * scene.track.n_across * scene.track.spacing**2
    warning = None
    if scene.load >= capacity:
        warning = (
            f"the load is {scene.load:g} N, hardness times one period of the surface is"
            f" {si(capacity, 'N')}: the run will be refused; lower rolling.load_n or enlarge the"
            " surface"
        )
    return [
        Finding("hardness", "hardness", f"{si(scene.hardness, 'Pa')}, {says}"),
        Finding("capacity", "capacity", si(capacity, "N"), warning),
    ]


def _nodes(scene: Scene, radius: float) -> Finding:
    """Count the nodes across the Hertz radius [m]."""
    nodes = radius / scene.spacing
    coarse = None
    if nodes < MIN_HERTZ_NODES:
        coarse = (
            f"{nodes:.2g} nodes across the Hertz radius, {MIN_HERTZ_NODES} are wanted: choose a"
            f" surface.spacing_um of at most {rounded_down(radius / MIN_HERTZ_NODES * 1e6)}"
        )
    return Finding("hertz_nodes", "nodes per Hertz radius", f"{nodes:.3g}", coarse)
