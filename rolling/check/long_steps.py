"""Steps over which a sphere leaves its contact: refused, with the longest that are allowed."""

from collections.abc import Iterator, Mapping

from acoustics.numbers import micrometres, rounded, si
from rolling.check.resolution import finer_heights
from rolling.check.run_size import RunSize, run_size
from rolling.scene.messages import SceneError, plain_number
from rolling.scene.scene import Scene
from rolling.scene.sections import STEP_NODES
from rolling.scene.sweep import run_name

METRES_MM = 0.1  # [mm]; a smaller radius is no ball that rolls, and probably in metres
MAX_RADII = 4.0  # step over contact radius, above which half of the release is lost


def refuse_long_steps(scene: Scene) -> None:
    """Raise SceneError for the runs of a scene with steps longer than `MAX_RADII` contact radii."""
    refuse_runs(scene, {run_name(values): run_size(run) for values, run in scene.runs()})


def refuse_runs(scene: Scene, runs: Mapping[str, RunSize]) -> None:
    """Raise SceneError for runs with long steps, by their names in the sweep of a scene."""
    mistakes = [*_mistakes(runs)]
    if mistakes:
        raise SceneError([f"{scene.place(key)}: {key}: {text}" for key, text in mistakes])


def _mistakes(runs: Mapping[str, RunSize]) -> Iterator[tuple[str, str]]:
    """Yield the key that makes steps too long, and what is wrong with it."""
    for name, run in runs.items():
        if run.step_m <= MAX_RADII * run.contact_radius_m:
            continue
        which = f" (in the run {name} of the sweep)" if name else ""
        unit = unit_of_radius(run.radius_mm)
        if unit:
            yield "sphere.radius_mm", f"{_mistake_of_radius(run)}; {unit}{which}"
        else:
            yield "numerics.step_nodes", f"{_mistake_of_steps(run)}{which}"


def unit_of_radius(radius_mm: float) -> str:
    """Say that a radius is likely in metres, because it makes a sphere of micrometres; or nothing.

    Steps, half-space and memory are at fault in its place.
    """
    if radius_mm >= METRES_MM:
        return ""
    return (
        f"this is a sphere of {si(2e-3 * radius_mm, 'm')}, and likely a radius in metres: write"
        f" {plain_number(float(rounded(1e3 * radius_mm, 6)))}"
    )


def _mistake_of_radius(run: RunSize) -> str:
    """Write that the contact of a sphere is too small for a step."""
    return (
        f"got {plain_number(run.radius_mm)}, whose contact has a radius of"
        f" {rounded(run.contact_radius_m * 1e6, 3)} um; allowed: a contact radius of at least"
        f" {micrometres(run.step_m / MAX_RADII)} um, a quarter of a step"
    )


def _mistake_of_steps(run: RunSize) -> str:
    """Write the length of the steps, the longest that are allowed, and the nearest number."""
    radius = run.contact_radius_m
    longest = MAX_RADII * radius
    return (
        f"got {run.step_nodes:g}, steps of {micrometres(run.step_m)} um, "
        f"{rounded(run.step_m / radius, 3)} times the contact radius of "
        f"{rounded(radius * 1e6, 3)} um; allowed: steps of at most {MAX_RADII:g} times the "
        f"radius, {micrometres(longest)} um here; nearest: {_shorter_steps(run, longest)}"
    )


def _shorter_steps(run: RunSize, longest_m: float) -> str:
    """Name the number of nodes that is allowed, or the heights that have closer nodes."""
    fitting = [nodes for nodes in STEP_NODES if nodes * run.spacing_m <= longest_m]
    if fitting and run.is_made:
        return f"{max(fitting):g}, or {finer_heights(run.is_made)}"
    if fitting:
        return f"{max(fitting):g}"
    if run.is_made:
        return f"{finer_heights(run.is_made)}, {rounded(longest_m * 1e6, 3)} at steps of one node"
    return finer_heights(run.is_made, longest_m * 1e6)
