"""Variants of a scene: the same stretch of track with another grid or other numerics."""

import math
import time
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from acoustics.arrays import Array
from rolling.contact.march import march
from rolling.contact.recovery import step_energy
from rolling.contact.state import RollingContact
from rolling.contact.subcells import half_space_of
from rolling.in_si import contact_of_scene
from rolling.in_si.scene_surface import heights
from rolling.scene.scene import Scene
from rolling.surface.refined import dies_out, refined, subcell_heights
from rolling.surface.subcell_contact import auto_subcells, on_subcells

TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
REFERENCE_TOLERANCE = 1e-6
SOLVER_TOLERANCE = 1e-8
STEP_NODES = (0.5, 1.0, 2.0, 4.0)
OWN = "the scene"
REFERENCE = "reference"
SOLVER = "exact solve"
STATES = ("contact_area", "plastic_area", "max_pressure", "iterations", "convolutions")


@dataclass(frozen=True)
class Variant:
    """The grid, the step, and the solver settings of one march.

    times : int. Divisor of the scene's spacing.
    step_nodes : float. Length of a step in nodes of the scene's own grid.
    tolerance, edges, precision : float, str, str. Numerics as in a scene.
    curve : str. Setting that is varied: the name of a curve in the diagram.
    """

    times: int
    step_nodes: float
    tolerance: float
    edges: str
    precision: str
    curve: str = field(default=OWN, compare=False)

    @property
    def cost(self) -> float:
        """Expected time of a stretch, relative to the scene's own grid at tolerance 1e-4."""
        work = float(self.times**2.3) * max(0.5, -math.log10(self.tolerance) / 4)
        return work / self.step_nodes


def tolerance_text(value: float) -> str:
    """Write a tolerance as 1e-4, not as 0.0001 or 1e-04."""
    mantissa, exponent = f"{value:.3e}".split("e")
    return f"{float(mantissa):g}e{int(exponent)}"


def label(scene: Scene, variant: Variant) -> str:
    """Name a variant of a scene by the setting that it varies."""
    spacing = scene.spacing * 1e6
    tolerance = tolerance_text(variant.tolerance)
    grid = f"spacing {spacing / variant.times:g} µm, {variant.edges} edges"
    labels = {
        REFERENCE: f"reference: {grid}, tolerance {tolerance}",
        SOLVER: f"tolerance {tolerance}, double precision",
        "tolerance": f"tolerance {tolerance}",
        "step": f"step {spacing * variant.step_nodes:g} µm",
        "precision": f"{variant.precision} precision",
        OWN: f"{OWN}: {grid}, tolerance {tolerance}",
    }
    return labels.get(variant.curve, grid)


def stretch_of(scene: Scene, duration_s: float) -> tuple[Scene, int]:
    """Cut a scene to a whole number of all tried steps, and return it with its length in nodes.

    The stretch is a closed lap of a generated surface. A height file is used unchanged.
    """
    unit = math.lcm(round(STEP_NODES[-1]), max(1, math.ceil(scene.step_nodes)))
    track = scene.track
    motion = scene.motion
    rolled = float(motion.distance(duration_s))
    distance = min(track.distance, track.n_along * track.spacing, rolled)
    nodes = unit * max(math.floor(distance / track.spacing / unit + 1e-6), math.ceil(8 / unit))
    changes: dict[str, Any] = {"recovery.events": False, "numerics.tolerance": scene.tolerance}
    if scene.height_path is None:
        seconds = motion.duration(nodes * track.spacing)
        changes |= {"rolling.duration_s": seconds, "rolling.distance_mm": None}
    return scene.with_(changes), nodes


def variants_of(scene: Scene, finest: int) -> list[Variant]:
    """List the variants of a scene, each once; the first is the scene as it stands.

    Tolerance and spacing shrink together, because the larger error would hide the smaller. `finest`
    is the divisor of the spacing for the reference, a power of two.
    """
    numerics = scene.numerics
    all_edges = ("blended", "sharp") if math.isfinite(scene.hardness) else ("sharp",)
    edges = numerics.edges if numerics.edges in all_edges else "sharp"
    own = Variant(
        times=1,
        step_nodes=scene.step_nodes,
        tolerance=scene.tolerance,
        edges=edges,
        precision=numerics.precision,
    )
    reference = replace(
        own,
        times=finest,
        tolerance=REFERENCE_TOLERANCE,
        edges=all_edges[0],
        precision="single",
        curve=REFERENCE,
    )
    exact = replace(own, tolerance=SOLVER_TOLERANCE, precision="double", curve=SOLVER)
    variants = [own, reference, exact]
    for kind in all_edges:
        times = 1
        while times < finest:
            finer = replace(own, times=times, tolerance=own.tolerance / times, edges=kind)
            variants.append(replace(finer, curve=f"spacing, {kind} edges"))
            times *= 2
    for tolerance in TOLERANCES:
        variants.append(replace(own, tolerance=tolerance, curve="tolerance"))
    for step_nodes in STEP_NODES:
        variants.append(replace(own, step_nodes=step_nodes, curve="step"))
    for precision in ("single", "double"):
        variants.append(replace(own, precision=precision, curve="precision"))
    return list(dict.fromkeys(variants))  # each once


def variant_contact(scene: Scene, variant: Variant) -> RollingContact:
    """Make the contact of a variant, on a refined surface without new detail.

    Where cells are flat, the cells of a node are as many as the grid is finer, and the node lies in
    their middle.
    """
    plain = scene.with_({"numerics.edges": "sharp", "numerics.subcells": 1})
    own = heights(scene)
    coarse = contact_of_scene.rolling_contact(plain, own)
    smooth = contact_of_scene.continues(scene)
    spacing = coarse.spacing / variant.times
    if smooth is None:
        smooth = dies_out(own)
    fine = refined(own, variant.times) if smooth else subcell_heights(own, variant.times, smooth)
    contact = replace(
        coarse,
        heights=fine,
        spacing=spacing,
        step=variant.step_nodes * coarse.spacing,
        start=coarse.start + (0.0 if smooth else (variant.times - 1) / 2 * spacing),
        tolerance=variant.tolerance,
        single=variant.precision == "single",
        blended=variant.edges == "blended",
        slopes=smooth,
    )
    chosen = scene.numerics.subcells
    subcells = auto_subcells(contact) if chosen == "auto" else chosen
    return on_subcells(contact, subcells, smooth)


def march_variant(scene: Scene, variant: Variant, nodes: int) -> dict[str, Array]:
    """March a variant over a stretch of so many nodes of the scene.

    Returns
    -------
    release_energy : (steps,) array, J.
    contact_area, plastic_area, max_pressure, iterations, convolutions : (steps,) arrays in SI.
    seconds : array without dimension, s. Processor time of the march.

    Raises
    ------
    ContactError : as in `march`.
    """
    contact = variant_contact(scene, variant)
    half_space = half_space_of(contact.spacing, contact.contact_modulus, contact.subcells)
    left_end = scene.recovery.rule == "left_end"
    list(march(contact, 0, 1, half_space))  # compiles kernels and prepares transforms
    steps = round(nodes / variant.step_nodes)
    series = {name: np.empty(steps) for name in ("release_energy", *STATES)}
    old = None
    began = time.process_time()
    for state in march(contact, 0, steps, half_space):
        if old is not None:
            k = old.position
            series["release_energy"][k] = step_energy(old, state, half_space, left_end).release
            for name in STATES:
                series[name][k] = getattr(state, name)
        old = state
    return series | {"seconds": np.array(time.process_time() - began)}
