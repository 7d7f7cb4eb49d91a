"""Runs with the same march: one of them is solved, and all of them have its result.

The march does not depend on speed, mass, thickness, or the listener, so the runs of a sweep over
them share it where they roll the same distance.
"""

from __future__ import annotations

from collections.abc import Sequence

from rolling.scene.scene import Scene
from rolling.simulation import simulate
from rolling.simulation.result import Result


def share(scenes: Sequence[Scene], results: list[Result]) -> None:
    """Replace the results of runs with the same march by the result that is solved furthest.

    The stretches of an error estimate depend on the speed, but for runs with dynamics: others with
    an estimate share nothing.
    """
    for numbers in _alike(scenes, results).values():
        if len(numbers) > 1:
            best = max((results[k] for k in numbers), key=_solved)
            for k in numbers:
                best.moving = results[k].moving | best.moving
                results[k] = best


def members(results: Sequence[Result]) -> dict[int, list[int]]:
    """Return the numbers of the runs that share a result, by the first of them."""
    groups: dict[int, list[int]] = {}
    for number, result in enumerate(results):
        groups.setdefault(id(result), []).append(number)
    return {numbers[0]: numbers for numbers in groups.values()}


def _alike(
    scenes: Sequence[Scene], results: Sequence[Result]
) -> dict[tuple[str, str | None], list[int]]:
    """Return the numbers of runs by the physics and the surface of their march."""
    groups: dict[tuple[str, str | None], list[int]] = {}
    if len(scenes) == 1:
        return groups
    for number, (scene, result) in enumerate(zip(scenes, results, strict=True)):
        if not scene.numerics.error_estimate or scene.dynamics is not None:
            identity = result.identity or simulate.identity_of(scene)
            groups.setdefault((identity.text, identity.heights_sha256), []).append(number)
    return groups


def _solved(result: Result) -> tuple[bool, int, int]:
    """Return the progress of a result, for a comparison."""
    marches = result.load_marches
    complete = marches is not None and marches.complete
    return complete, result.done_steps, 0 if marches is None else len(marches.approach)
