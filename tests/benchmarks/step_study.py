"""Error that steps of 2 and 4 nodes leave in a release, and the rule of `step_nodes: auto`.

`python tests/benchmarks/step_study.py` draws scenes at random and marches a stretch of each at
steps of 1, 2 and 4 nodes over the same surface. It prints the constants of
`rolling/scene/step_rule.py`, fitted to some scenes, and judges the rule on others at the slowest
speeds that it allows. It takes four minutes of one core. `--fit` prints the fit alone, `--judge`
the judgement alone.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from scipy.optimize import least_squares
from tqdm import tqdm

import rolling as rc
from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES
from rolling.contact.march import march
from rolling.contact.recovery import step_energy
from rolling.contact.subcells import half_space_of
from rolling.in_si.contact_of_scene import rolling_contact
from rolling.in_si.physics_of_scene import listener_of
from rolling.scene import grid_error, step_rule
from rolling.sound.contact_sound import ContactSound, contact_sound
from rolling.studies.accuracy_variants import Variant, march_variant

NODES = 800  # of a stretch, which closes on itself
GRID_NODES = 400  # of the stretch on which the error of the grid is measured
FINEST = 4  # divisor of the spacing there
MARGINS = (1.25, 1.5, 2.0, 3.0, 5.0, 8.0)  # Nyquist frequency of the steps over the end of hearing
BANDS = [name for name in BAND_NAMES if 1000 <= float(name) <= 16000]
_BASE: dict[str, Any] = {
    "name": "steps",
    "sphere": {"radius_mm": 5},
    "plate": {"youngs_modulus_gpa": 210, "poissons_ratio": 0.3, "hardness_gpa": 2.1},
    "surface": {
        "kind": "gaussian",
        "roughness_ra_um": 0.1,
        "correlation_length_um": 10,
        "spacing_um": 2,
        "width_um": 512,
        "seed": 1,
    },
    "rolling": {"load_n": 5, "speed_m_s": 1.0, "distance_mm": 1.0},
    "numerics": {"step_nodes": 1},
}
_KEYS = {  # short names of the keys that vary
    "ra": "surface.roughness_ra_um",
    "length": "surface.correlation_length_um",
    "law": "surface.autocorrelation",
    "spacing": "surface.spacing_um",
    "width": "surface.width_um",
    "seed": "surface.seed",
    "hardness": "plate.hardness_gpa",
    "load": "rolling.load_n",
    "radius": "sphere.radius_mm",
    "across": "sphere.radius_across_mm",
}
FITTED = range(48)  # random scenes
JUDGED = range(100, 116)  # others


@dataclass(frozen=True)
class Stretch:
    """Releases of a stretch [J] by the length of its steps in nodes."""

    scene: rc.Scene
    releases: Mapping[int, Array]

    def sound(self, nodes: int, speed: float) -> ContactSound:
        """Return the sound of a release at a speed [m/s]."""
        scene = self.scene.with_({"rolling.speed_m_s": speed})
        return contact_sound(
            self.releases[nodes],
            step=nodes * scene.spacing,
            motion=scene.motion,
            listener=listener_of(scene),
            tolerance=scene.tolerance,
            closed=True,
        )

    def error_db(self, nodes: int, speed: float) -> float:
        """Return the error of the audible release from long steps over its fluctuation [dB]."""
        exact = fluctuation(self.sound(1, speed))
        error = fluctuation(self.sound(nodes, speed)) - exact
        return float(10 * np.log10(np.mean(error**2) / np.mean(exact**2)))


def fluctuation(sound: ContactSound) -> Array:
    """Return the fluctuation of the intensity within hearing [W/m2]."""
    return sound.pressure / (sound.factor or 1.0)


def scene_of(changes: Mapping[str, Any], nodes: int = NODES) -> rc.Scene:
    """Return a scene of the study, whose track has so many nodes."""
    scene = rc.Scene.from_dict(_BASE).with_({_KEYS[name]: v for name, v in changes.items()})
    return scene.with_({"rolling.distance_mm": nodes * scene.spacing * 1e3})


def marched(scene: rc.Scene) -> Stretch:
    """March the closed track of a scene at each length of step."""
    releases = {}
    for nodes in (1, *step_rule.CHOICES):
        contact = rolling_contact(scene.with_({"numerics.step_nodes": nodes}))
        half_space = half_space_of(contact.spacing, contact.contact_modulus, contact.subcells)
        release = np.empty(scene.track.n_along // nodes)
        old = None
        for state in march(contact, 0, len(release), half_space):
            if old is not None:
                release[old.position] = step_energy(old, state, half_space).release
            old = state
        releases[nodes] = release
    return Stretch(scene, releases)


# ---- fit


def fitted() -> pd.Series:
    """Fit the constants of the rule to the errors of the scenes of FITTED."""
    rows = []
    for seed in tqdm(FITTED, "fit", leave=False):
        scene = scene_of(random_changes(seed))
        rq, slope = grid_error.law_roughness(scene)
        steps = {nodes: nodes * scene.spacing for nodes in step_rule.CHOICES}
        fit = {nodes: step for nodes, step in steps.items() if step_rule.is_fitted(scene, step)}
        if not fit:
            continue
        stretch = marched(scene)
        for nodes, step in fit.items():
            radii = step / step_rule.contact_radius(scene)
            smoothness = max(1.0, step_rule.smoothness(scene))
            for margin in MARGINS:
                error_db = stretch.error_db(nodes, step_rule.speed_at(step, margin))
                rows.append((radii, smoothness, step * slope / rq, margin, error_db))
    table = np.array(rows)
    radii, smooth, lengths, margins = np.log10(table[:, :4].T)

    def difference(constants: Array) -> Array:
        """Return the rule's errors less the measured ones [dB]."""
        contact_db = constants[0] + constants[1] * radii + constants[2] * smooth
        folded_db = constants[3] - constants[4] * margins + constants[5] * lengths
        together = 10 * np.log10(10 ** (contact_db / 10) + 10 ** (folded_db / 10))
        return np.asarray(together - table[:, 4])

    found = least_squares(difference, [-19.0, 37.0, 8.0, -26.0, 35.0, 17.0])
    names = ["CONTACT_DB", "PER_RADIUS_DB", "PER_SMOOTHNESS_DB"]
    names += ["FOLDED_DB", "PER_MARGIN_DB", "PER_LENGTH_DB"]
    constants = pd.Series(found.x, names)
    constants["rms_db"] = np.sqrt(np.mean(found.fun**2))
    constants["most_too_low_db"] = -found.fun.min()
    return constants


# ---- judgement


def random_changes(seed: int) -> dict[str, Any]:
    """Draw the changes of a scene, evenly over the logarithm of each value."""
    rng = np.random.default_rng([seed, 55])

    def between(low: float, high: float) -> float:
        return float(f"{math.exp(rng.uniform(math.log(low), math.log(high))):.2g}")

    length = between(6, 40)
    spacing = float(f"{min(4.0, max(1.0, length / rng.uniform(4, 8))):.2g}")
    radius = between(1, 15)
    laws = ["gaussian", "gaussian", "gaussian_10pct", "exponential", "exponential_10pct"]
    changes: dict[str, Any] = {
        "length": length,
        "spacing": spacing,
        "ra": float(f"{between(0.02, 3) * length / 40:.2g}"),
        "radius": radius,
        "load": between(0.5, 100) * min(1.0, radius / 5),
        "law": str(rng.choice(laws)),
        "hardness": None if rng.random() < 0.3 else between(1.2, 6),
        "seed": 100 + seed,
    }
    if rng.random() < 0.25:
        changes["across"] = radius * float(rng.choice([0.5, 2.0]))
    nodes = 64
    while nodes * spacing < 3.5 * contact_width_um(changes):
        nodes += 32
    return changes | {"width": round(nodes * spacing, 6)}


def contact_width_um(changes: Mapping[str, Any]) -> float:
    """Estimate the width [um] of the overlap of a scene of the study."""
    scene = scene_of(changes | {"width": 4096 * changes["spacing"]})
    rq, _ = grid_error.law_roughness(scene)
    radius = math.sqrt(scene.radius * scene.radius_across)
    depth = grid_error.hertz_radius(scene) ** 2 / radius + 1.5 * rq
    if math.isfinite(scene.hardness):
        depth += scene.load / (2 * math.pi * radius * scene.hardness)
    return 2e6 * math.sqrt(2 * scene.radius_across * depth)


def grid_db(changes: Mapping[str, Any]) -> float:
    """Measure the error of the release from the grid over its fluctuation [dB], below hearing.

    The speed lets two nodes pass in a period of the highest frequency that is heard.
    """
    scene = scene_of(changes, GRID_NODES)
    speed = step_rule.speed_at(2 * scene.spacing, 2.0)
    sounds = []
    for times, tolerance in ((1, scene.tolerance), (FINEST, 1e-6)):
        variant = Variant(times, 1.0, tolerance, scene.numerics.edges, "single")
        release = march_variant(scene, variant, GRID_NODES)["release_energy"]
        sounds.append(Stretch(scene, {1: release}).sound(1, speed))
    own, exact = map(fluctuation, sounds)
    return float(10 * np.log10(np.mean((own - exact) ** 2) / np.mean(exact**2)))


def judged(seed: int, with_grid: bool) -> list[dict[str, Any]]:
    """Return a row for each length of step of a random scene, at the slowest speed of the rule."""
    changes = random_changes(seed)
    stretch = marched(scene_of(changes))
    scene = stretch.scene
    measured_db = grid_db(changes) if with_grid else math.nan
    rows = []
    for nodes in sorted(step_rule.CHOICES):
        row = {
            "scene": seed,
            "Ra um": changes["ra"],
            "L um": changes["length"],
            "law": changes["law"],
            "GPa": changes["hardness"] or math.inf,
            "N": scene.load,
            "R mm": changes["radius"],
            "node um": changes["spacing"],
            "grid rule dB": grid_error.grid_signal_db(scene),
            "grid dB": measured_db,
            "nodes": nodes,
        }
        speed = step_rule.lowest_speed(scene, nodes)
        if math.isfinite(speed):
            exact = stretch.sound(1, speed).levels
            levels = stretch.sound(nodes, speed).levels
            octaves = [
                own - other
                for name in BANDS
                if (own := levels.third_octave_db[name]) is not None
                and (other := exact.third_octave_db[name]) is not None
            ]
            assert levels.laeq_db is not None and exact.laeq_db is not None
            row |= {
                "from m/s": speed,
                "rule dB": step_rule.error_db(scene, nodes * scene.spacing, speed),
                "error dB": stretch.error_db(nodes, speed),
                "LAeq dB": levels.laeq_db - exact.laeq_db,
                "octave dB": max(octaves, key=abs),
            }
        rows.append(row)
    return rows


def main() -> None:
    """Print the fit and the judgement."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--fit", action="store_true", help="the fit alone")
    parser.add_argument("--judge", action="store_true", help="the judgement alone")
    parser.add_argument("--no-grid", action="store_true", help="without the errors of the grid")
    asked = parser.parse_args()
    pd.set_option("display.width", 250, "display.max_columns", None)
    if not asked.judge:
        print(fitted().round(1).to_string(), flush=True)
    if asked.fit:
        return
    rows = []
    for seed in tqdm(JUDGED, "judge", leave=False):
        rows += judged(seed, not asked.no_grid)
    table = pd.DataFrame(rows)
    print(table.to_string(index=False, float_format=lambda value: f"{value:.3g}"))
    off = (table["error dB"] - table["rule dB"]).dropna()
    above = table["error dB"] - table["grid rule dB"]
    print(f"rule off by {np.sqrt(np.mean(off**2)):.1f} dB rms, low by {off.max():.1f} at most")
    print(f"steps' error less the grid's by rule: at most {above.max():.1f} dB")
    print(f"LAeq changes by {table['LAeq dB'].abs().max():.3f} dB at most")


if __name__ == "__main__":
    main()
