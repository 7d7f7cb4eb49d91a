"""The variants of a scene for `rolling accuracy`.

They differ in grid, edges, tolerance, step, precision or width. All variants roll over the same
stretch of the same surface.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

from rolling._typing import Array
from rolling.contact import of_scene
from rolling.contact.state import RollingContact
from rolling.scene.scene import Scene
from rolling.simulation import pool, simulate
from rolling.surface import scene_surface
from rolling.surface.refined import dies_out, refined, subcell_heights
from rolling.surface.scene_surface import wider_heights, wider_times

TOLERANCES = (1e-2, 1e-3, 3e-4, 1e-4, 1e-5, 1e-6)
FINE_TOLERANCES = (1e-3, 1e-4)  # tolerance on finer grids
REFERENCE_TOLERANCE, SOLVER_REFERENCE_TOLERANCE = 1e-6, 1e-8
STEP_NODES = (0.5, 1.0, 2.0, 4.0)


@dataclass(frozen=True)
class Variant:
    """The grid, step and solver settings of one computation.

    Parameters
    ----------
    times : int. Divisor of the scene's spacing.
    step_nodes : float. Length of a step in nodes of the scene's own grid.
    tolerance, edges, precision : float, str, str. Numerics as in a scene.
    width : int. Factor on the width of the surface. Default: 1.
    """

    times: int
    step_nodes: float
    tolerance: float
    edges: str
    precision: str
    width: int = 1

    @property
    def name(self) -> str:
        """The name of the variant in files."""
        step = f"{self.step_nodes:g}"
        grid, tolerance = f"spacing-over-{self.times}", tolerance_text(self.tolerance)
        width = "" if self.width == 1 else f"_width-{self.width}"
        return f"{grid}_step-{step}_{tolerance}_{self.edges}_{self.precision}{width}"


def tolerance_text(value: float) -> str:
    """Write a tolerance as 1e-4, not as 0.0001 or 1e-04."""
    mantissa, exponent = f"{value:.3e}".split("e")
    return f"{float(mantissa):g}e{int(exponent)}"


@dataclass(frozen=True)
class Study:
    """A scene without a sweep and the stretch of track that all variants roll over.

    Parameters
    ----------
    scene : Scene. The scene, cut to the stretch.
    nodes : int. Length of the stretch in nodes of the scene.
    closed : bool. True if the stretch is the whole period.
    finest : int. Divisor of the spacing for the references.
    """

    scene: Scene
    nodes: int
    closed: bool
    finest: int

    @property
    def own(self) -> Variant:
        """The variant of the scene as it stands."""
        n = self.scene.numerics
        return Variant(
            1, n.step_nodes, self.scene.tolerance, n.edges if self.yields else "sharp", n.precision
        )

    @property
    def yields(self) -> bool:
        """True if the plate has a hardness."""
        return math.isfinite(self.scene.hardness)

    @property
    def all_edges(self) -> tuple[str, ...]:
        """The edges to compare; an elastic plate has sharp edges only."""
        return ("sharp", "blended") if self.yields else ("sharp",)

    @property
    def ladder(self) -> list[int]:
        """The divisors of the spacing, without the divisor of the references."""
        return [2**k for k in range(round(math.log2(self.finest)))]

    def reference(self, edges: str) -> Variant:
        """Return the reference with these edges."""
        return Variant(self.finest, self.own.step_nodes, REFERENCE_TOLERANCE, edges, "single")

    @property
    def solver_reference(self) -> Variant:
        """The reference for the tolerance and the precision of the scene's own grid."""
        return replace(self.own, tolerance=SOLVER_REFERENCE_TOLERANCE, precision="double")

    @property
    def wider(self) -> Variant | None:
        """The scene as it stands on a wider surface, or None where no surface can be wider."""
        times = wider_times(self.scene)
        return None if times is None else replace(self.own, width=times)

    def on_grid(self, times: int, edges: str) -> Variant:
        """Return the variant on a finer grid.

        Tolerance and spacing shrink together, because the larger error would hide the smaller.
        """
        return replace(self.own, times=times, edges=edges, tolerance=self.own.tolerance / times)

    def families(self) -> dict[str, list[Variant]]:
        """Return families of variants that differ in a single setting, by the name of the setting.

        The references come first.
        """
        own, finer = self.own, self.ladder[1:2]
        families = {"references": [self.reference(e) for e in self.all_edges[::-1]]}
        for edges in self.all_edges:
            grids = [self.on_grid(t, edges) for t in self.ladder]
            families[f"spacing, {edges} edges"] = [*grids, self.reference(edges)]
        families["tolerance"] = [
            replace(own, tolerance=t) for t in sorted({*TOLERANCES, own.tolerance}, reverse=True)
        ]
        for times in finer:
            families["tolerance, half the spacing"] = [
                replace(own, times=times, tolerance=t) for t in FINE_TOLERANCES
            ]
        steps = sorted({*STEP_NODES, own.step_nodes}, reverse=True)
        families["step"] = [replace(own, step_nodes=s) for s in steps]
        families["precision"] = [replace(own, precision=p) for p in ("single", "double")]
        if self.wider is not None:
            families["width"] = [own, self.wider]
        rest = [
            replace(own, times=t, edges=e, tolerance=loose)
            for t in self.ladder
            for e in self.all_edges
            for loose in FINE_TOLERANCES
        ]
        rest += [
            replace(self.on_grid(t, own.edges), step_nodes=s)
            for t in finer
            for s in steps
            if s < own.step_nodes
        ]
        rest += [replace(own, tolerance=1e-6, precision=p) for p in ("single", "double")]
        named = {variant for variants in families.values() for variant in variants}
        families["others"] = [variant for variant in dict.fromkeys(rest) if variant not in named]
        return families

    def variants(self) -> list[Variant]:
        """Return all variants, the finest grids first, because all errors need the reference."""
        every = [
            *(v for variants in self.families().values() for v in variants),
            self.solver_reference,
        ]
        return sorted(dict.fromkeys(every), key=lambda v: (-v.times, v != self.solver_reference))

    def spacing_um(self, variant: Variant) -> float:
        """Return the spacing of a variant [um]."""
        return self.scene.spacing * 1e6 / variant.times

    def width_um(self, variant: Variant) -> float:
        """Return the width of the surface of a variant [um]."""
        return self.scene.track.n_across * self.scene.spacing * 1e6 * variant.width

    def step_um(self, variant: Variant) -> float:
        """Return the length of a step of a variant [um]."""
        return self.scene.spacing * 1e6 * variant.step_nodes

    def highest(self, variant: Variant) -> float:
        """Return the Nyquist frequency of the steps [Hz] at the maximum speed."""
        motion = self.scene.motion
        duration = motion.duration(self.nodes * self.scene.spacing)
        return motion.fastest(duration) / (2 * variant.step_nodes * self.scene.spacing)

    def as_solved(self, variant: Variant) -> Scene:
        """Return the scene with the numerics of a variant.

        They set the resolution of its release.
        """
        changed = {
            "tolerance": variant.tolerance,
            "edges": variant.edges,
            "precision": variant.precision,
            "step_nodes": variant.step_nodes * variant.times,
        }
        return self.scene.model_copy(
            update={"numerics": self.scene.numerics.model_copy(update=changed)}
        )


def study_of(scene: Scene, duration: float, finest: int) -> Study:
    """Cut a scene to a stretch that is a whole number of every tried step.

    The stretch is a closed lap where possible. A height file is used unchanged: where it is longer
    than the stretch, or not a whole number of the longest step, the record does not close.

    Parameters
    ----------
    scene : Scene. A scene without a sweep.
    duration : float, s. Duration of rolling.
    finest : int. Divisor of the spacing for the references.
    """
    unit = math.lcm(round(STEP_NODES[-1]), max(1, math.ceil(scene.numerics.step_nodes)))
    rolled, motion = scene.track, scene.motion
    wanted = min(rolled.distance, rolled.n_along * rolled.spacing, float(motion.distance(duration)))
    nodes = unit * max(math.floor(wanted / rolled.spacing / unit + 1e-6), math.ceil(8 / unit))
    data = scene.to_dict()
    data["recovery"]["events"] = False
    if scene.height_path is None:
        data["rolling"]["duration_s"] = motion.duration(nodes * rolled.spacing)
    cut = Scene.from_dict(data, scene.folder)
    return Study(cut, nodes, nodes == cut.track.n_along, finest)


# ---- marching


_kept: list[tuple[Array, int, bool, Array]] = []  # the last refined surface is kept


def _refined(heights: Array, times: int) -> tuple[bool, Array]:
    """Return whether a surface continues between its nodes, and its heights on a finer grid."""
    if not _kept or _kept[0][0] is not heights or _kept[0][1] != times:
        smooth = dies_out(heights)
        fine = refined(heights, times) if smooth else subcell_heights(heights, times, smooth)
        _kept[:] = [(heights, times, smooth, fine)]
    return _kept[0][2:]


def rolling_contact(scene: Scene, variant: Variant) -> RollingContact:
    """Return the input of the march for a variant of a scene.

    Where cells are flat, those of a node are as many as the grid is finer, and the node lies in
    their middle.
    """
    plain = scene.numerics.model_copy(update={"edges": "sharp", "subcells": 1})
    coarse = of_scene.rolling_contact(
        scene.model_copy(update={"numerics": plain}), _heights(scene, variant.width)
    )
    smooth, fine = _refined(coarse.heights, variant.times)
    spacing = coarse.spacing / variant.times
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
    return of_scene.on_subcells(contact, subcells_of(scene, contact), smooth)


_wide: list[tuple[tuple[Any, ...], int, Array]] = []  # the last wider surface is kept


def _heights(scene: Scene, width: int) -> Array:
    """Return the heights of a scene [m], or of its surface `width` times as wide."""
    if width == 1:
        return scene_surface.heights(scene)
    key = scene_surface.identity(scene)
    if not _wide or _wide[0][:2] != (key, width):
        _wide[:] = [(key, width, wider_heights(scene, width))]
    return _wide[0][2]


def subcells_of(scene: Scene, contact: RollingContact) -> int:
    """Return the sub-cells of a variant from its scene.

    `auto` chooses them on the variant's own grid.
    """
    chosen = scene.numerics.subcells
    return of_scene.auto_subcells(contact) if chosen == "auto" else chosen


_warm: set[tuple[int, bool, bool]] = set()


def march_piece(
    scene: Scene,
    variant: Variant,
    first: int,
    last: int,
    stopped: Callable[[], bool],
    progress: Callable[[float], object],
) -> simulate.Piece:
    """March one piece of a variant's track from a cold start.

    A first step outside the timing compiles the solver and prepares the transforms.
    """
    contact = rolling_contact(scene, variant)
    kind = (variant.times, contact.single, contact.blended)
    if kind not in _warm:
        simulate.simulate_piece(scene, first, first + 1, stopped, contact=contact)
        _warm.add(kind)
    cost = _step_cost(variant)
    return simulate.simulate_piece(
        scene, first, last, stopped, lambda steps: progress(steps * cost), contact
    )


def _step_cost(variant: Variant) -> float:
    """Return the expected time of a step, relative to the scene's own grid at tolerance 1e-4."""
    return float(variant.times**2.3) * max(0.5, -math.log10(variant.tolerance) / 4)


def tasks(study: Study, variants: Sequence[Variant]) -> list[pool.Task]:
    """Return the pieces of all variants as tasks, with the number of the variant as their run.

    All pieces have the same length of track, about the length of a piece of a run.
    """
    unit = math.lcm(round(STEP_NODES[-1]), max(1, math.ceil(study.own.step_nodes)))
    length = unit * max(1, round(simulate.PIECE_STEPS * study.own.step_nodes / unit))
    borders = [*range(0, study.nodes, length), study.nodes]
    return [
        pool.Task(
            number,
            march_piece,
            (study.scene, v, round(a / v.step_nodes), round(b / v.step_nodes)),
            (b - a) / v.step_nodes * _step_cost(v),
        )
        for number, v in enumerate(variants)
        for a, b in pairwise(borders)
    ]
