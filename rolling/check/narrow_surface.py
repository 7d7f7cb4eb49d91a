"""Surfaces that are narrower than the contact: which of them a choice would have to leave out.

Surfaces of one law differ: over twelve seeds the widest contact of a track has 84 to 136 um. Only
where the highest summits that a law may have lie near enough to be loaded, the surfaces are made.
"""

from __future__ import annotations

from collections.abc import Iterator

from rolling.check.highest_summit import is_surely_wide_enough
from rolling.numbers.doubt import Doubt, Severity
from rolling.scene.scene import Scene
from rolling.scene.seeds import seeds_of, with_seed
from rolling.scene.surfaces import HeightFile

OF_CHOICE = "narrow_specimens"  # key of the doubt that concerns no number of a run
SPECIMENS = 12  # of a choice that are foreseen
MAX_NODES = 300_000  # of all surfaces that are made for it, so that it takes a part of a second


def rules(scene: Scene) -> Iterator[Doubt]:
    """Doubt surfaces that are narrower than the contact: the own one, and those of a choice."""
    if is_surely_wide_enough(scene):
        return
    from rolling.check.widest_places import may_be_too_narrow  # compiled, and slow to import

    seeds = seeds_of(scene)
    nodes = scene.track.n_along * scene.track.n_across
    if nodes > MAX_NODES:
        return
    is_narrow = may_be_too_narrow(scene)
    if is_narrow:
        yield Doubt(
            "window",
            "window: at the widest place of the track the contact is probably wider than the"
            " surface, and then the run has no solution",
            Severity.INDICATIVE,
            advice=_wider(scene),
        )
    if not seeds:
        return
    first = next(iter(seeds.values()))  # as `rolling.ball_kinds.ball_specimens` takes it
    count = min(SPECIMENS, MAX_NODES // nodes)
    known = {first: is_narrow} if set(seeds.values()) == {first} else {}
    narrow = []
    for seed in range(first, first + count):
        if seed not in known:
            known[seed] = may_be_too_narrow(with_seed(scene, seed))
        if known[seed]:
            narrow.append(seed)
    if narrow:
        named = ", ".join(map(str, narrow))
        yield Doubt(
            OF_CHOICE,
            f"on {len(narrow)} of the first {count} surfaces of `rolling choose` (seed {named}) the"
            " contact is probably wider than the surface, and it leaves them out",
            Severity.TRUST,
            advice=_wider(scene),
        )


def _wider(scene: Scene) -> str:
    """Advise to take a wider surface."""
    if isinstance(scene.surface, HeightFile):
        return "choose a larger height file"
    wider = 2 * 1e6 * scene.track.n_across * scene.spacing
    return f"choose a larger surface.width_um, such as {wider:.10g}"
