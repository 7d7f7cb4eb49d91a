"""Specimens: surfaces, or places on a measured surface, on which every candidate is heard.

Candidates are compared on the same seeds, so that what their surfaces share cancels. A measured
surface has no seed. Tracks beside each other across the scan, and stretches along it, take the
place of seeds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from acoustics.pairs import LOOKS, MOST_PAIRS
from rolling.choice.audition import Specimens
from rolling.choice.candidate import Candidate
from rolling.in_si.physics_of_scene import smooth_contact_of
from rolling.scene.scene import Scene
from rolling.scene.seeds import seeds_of, with_seed

_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0  # places in this order are far apart at any count


class Place(NamedTuple):
    """Place of a track on a measured surface, from the start and middle of the scene [um]."""

    along_um: float
    across_um: float


class Places(NamedTuple):
    """Places on the measured surface of a candidate.

    places : list of Place. The places, in an order in which the first ones are far apart.
    overlap : bool. Whether the tracks overlap, because the scan has no room for enough of them.
    """

    places: list[Place]
    overlap: bool


class BallSpecimens(Specimens):
    """What varies from specimen to specimen of some candidates: seeds, or places of a scan.

    Attributes
    ----------
    count : int
        Number of specimens that there are.
    noun : str
        What the specimens are: surfaces, or places of the scan.
    overlap : bool
        Whether the places of a scan overlap.
    """

    def __init__(self, candidates: Sequence[Candidate]) -> None:
        """Find out what varies."""
        measured = []
        is_random = False
        for candidate in candidates:
            scan = _places(candidate.scene)
            if scan is not None:
                measured.append(scan)
            if seeds_of(candidate.scene):
                is_random = True
        self._first_seed = _first_seed(candidates)
        self.overlap = any(scan.overlap for scan in measured)
        self.noun = "surfaces"
        self.count = MOST_PAIRS if is_random else 1
        if measured:
            self.noun = "places of the scan" if len(measured) == 1 else "places of the scans"
            self.count = min(MOST_PAIRS, *(len(scan.places) for scan in measured))

    def shortage_words(self, wanted: int) -> str:
        """Say what a scene has in place of a wanted number of specimens."""
        if self.noun == Specimens.noun:
            return super().shortage_words(wanted)
        return f"room for {self.count} of the {wanted} places that it takes"

    def scene(self, candidate: Candidate, number: int) -> Scene:
        """Return the scene of a candidate on the specimen of a number, from 0 on."""
        scene = with_seed(candidate.scene, self._first_seed + number)
        changes: dict[str, Any] = {}
        scan = _places(scene)
        if scan is not None:
            place = scan.places[number]
            changes["rolling.start_um"] = scene.rolling.start_um + place.along_um
            changes["rolling.across_um"] = scene.rolling.across_um + place.across_um
        if changes:
            scene = scene.with_(changes)
        return scene.runs()[0].scene


def _first_seed(candidates: Sequence[Candidate]) -> int:
    """Return the seed of the first specimen, that of the first candidate that has one."""
    for candidate in candidates:
        for seed in seeds_of(candidate.scene).values():
            return seed
    return 1


def _places(scene: Scene) -> Places | None:
    """Return the places on a measured surface; None for a surface that the program makes.

    Tracks that are a contact width apart have little in common. A track round the whole scan has
    no other stretch along it.
    """
    if scene.surface.kind != "file":
        return None
    track = scene.track
    _, half_width = smooth_contact_of(scene).semi_axes_m()
    width = track.n_across * track.spacing
    rows = max(1, int(width / (2.0 * half_width)))
    columns = max(1, track.lap_steps // track.steps)
    fewest = LOOKS[0]
    overlap = rows * columns < fewest
    if overlap:
        rows = min(fewest, track.n_across)
    places = []
    for row in range(rows):
        for column in range(columns):
            along = column * track.lap_steps * track.step / columns
            places.append(Place(along_um=1e6 * along, across_um=1e6 * row * width / rows))
    return Places(places=_far_apart(places), overlap=overlap)


def _far_apart(places: Sequence[Place]) -> list[Place]:
    """Return places in an order in which neighbours in the list are far apart on the surface."""
    left = list(places)
    ordered = []
    at = 0.0
    while left:
        ordered.append(left.pop(int(at * len(left))))
        at = (at + _GOLDEN) % 1.0
    return ordered
