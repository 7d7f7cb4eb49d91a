"""Small random scenes with dynamics, on which nothing was tuned, for studies of estimates."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import rolling as rc
from rolling.check import cost, force_estimate
from rolling.scene.messages import SceneError

GROUNDS = ("infinite plate", "plate with edges", "half-space")
# Limits of a window and a step with which a scene takes seconds.
MAX_NODES = 150
MAX_STEP_MS = 2.5
MAX_FORCE_RATIO = 0.4  # expected fluctuation of the force over the load
GRAVITY = 9.81


def small_scene(seed: int, steps: int = 1200, step_nodes: int = 1) -> tuple[rc.Scene, str]:
    """Return a scene and the name of its ground, which goes round with the seed.

    Radii are 1 to 20 mm, moduli 3 to 400 GPa, correlation lengths 5 to 40 um, speeds 0.02 to 3 m/s.
    Half of the plates yield.
    """
    rng = np.random.default_rng(seed)
    ground = GROUNDS[seed % len(GROUNDS)]
    while True:
        values = _values(rng, ground, seed, steps, step_nodes)
        try:
            scene = rc.Scene.from_dict(values)
            window = cost.window_nodes(scene, cost.roughness(scene)[0])
            nodes = max(48, 2 * math.ceil(1.15 * window))
            values["surface"]["width_um"] = nodes * values["surface"]["spacing_um"]
            scene = rc.Scene.from_dict(values)
        except SceneError:
            continue
        force = (force_estimate.force_rms(scene) or 0.0) / scene.load
        if nodes <= MAX_NODES and force <= MAX_FORCE_RATIO and cost.step_ms(scene) <= MAX_STEP_MS:
            return scene, ground


def _values(
    rng: np.random.Generator, ground: str, seed: int, steps: int, step_nodes: int
) -> dict[str, Any]:
    """Draw the values of a scene, which may not fit together."""

    def decade(low: float, high: float) -> float:
        return float(f"{math.exp(rng.uniform(math.log(low), math.log(high))):.4g}")

    radius = decade(1, 20)
    modulus = decade(3, 400)
    length = decade(5, 40)
    sphere = {"radius_mm": radius, "density_kg_m3": float(rng.choice([1200, 2500, 7850]))}
    if rng.random() < 0.5:
        sphere |= {"youngs_modulus_gpa": decade(10, 300), "poissons_ratio": 0.28}
    plate = {
        "youngs_modulus_gpa": modulus,
        "poissons_ratio": 0.25,
        "density_kg_m3": float(rng.choice([1200, 2500, 2700, 7850])),
    }
    if rng.random() < 0.5:
        plate["hardness_gpa"] = modulus * decade(0.003, 0.03)
    if ground != GROUNDS[2]:
        plate |= {"thickness_mm": decade(1.5, 15), "loss_factor": decade(0.005, 0.05)}
    if ground == GROUNDS[1]:
        plate |= {"length_mm": decade(80, 300), "width_mm": decade(80, 300)}
    spacing = float(f"{length / rng.uniform(3.5, 6):.3g}") / step_nodes
    weight = GRAVITY * sphere["density_kg_m3"] * 4 / 3 * math.pi * (radius * 1e-3) ** 3
    return {
        "name": f"small-{seed}",
        "sphere": sphere,
        "plate": plate,
        "surface": {
            "kind": "gaussian",
            "roughness_ra_um": min(decade(0.02, 1), 0.05 * length),
            "correlation_length_um": length,
            "spacing_um": spacing,
            "width_um": 48 * spacing,
            "seed": seed,
        },
        "rolling": {
            "load_n": decade(max(weight, 0.02), max(3 * weight, 10)),
            "speed_m_s": decade(0.02, 3),
            "distance_mm": steps * step_nodes * spacing * 1e-3,
        },
        "numerics": {"step_nodes": step_nodes},
        "dynamics": {},
        "sound": {"distance_m": 0.5},
    }
