"""Specimens: surfaces, or places on a measured surface, on which every candidate is heard.

Candidates are compared on the same seeds, so that what their surfaces share cancels. A measured
surface has no seed. Tracks beside each other across the scan, and stretches along it, take the
place of seeds. Places of one scan share its ridges, so that they are correlated.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from acoustics.arrays import Array
from acoustics.pairs import LOOKS, MOST_PAIRS
from rolling.ball_kinds import linear_response
from rolling.choice.audition import Specimens
from rolling.choice.candidate import Candidate
from rolling.contact.kept import Kept
from rolling.in_si import scene_surface
from rolling.in_si.physics_of_scene import smooth_contact_of
from rolling.scene.identity import digest
from rolling.scene.scene import Scene
from rolling.scene.seeds import seeds_of, with_seed
from rolling.surface.alike_places import alike_levels

_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0  # places in this order are far apart at any count


class Place(NamedTuple):
    """Place of a track on a measured surface, from the start and middle of the scene [um]."""

    along_um: float
    across_um: float


class AlikePlaces(NamedTuple):
    """How much alike the levels of the places of a candidate are.

    correlation : (places, places) array. Correlations of the levels of the first places.
    variance : float. Variance of a mean square over the square of its mean; levels scatter with it.
    """

    correlation: Array
    variance: float


MAX_KEPT = 4_000_000  # bytes of correlations that are kept
_kept: Kept[AlikePlaces | None] = Kept(
    MAX_KEPT, lambda alike: 0 if alike is None else alike.correlation.nbytes
)


class BallSpecimens(Specimens):
    """What varies from specimen to specimen of some candidates: seeds, or places of a scan.

    Attributes
    ----------
    count : int
        Number of specimens that there are.
    noun : str
        What the specimens are: surfaces, or places of the scan.
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
        self.noun = "surfaces"
        self.count = MOST_PAIRS if is_random else 1
        if measured:
            self.noun = "places of the scan" if len(measured) == 1 else "places of the scans"
            fewest_places = min(len(scan) for scan in measured)
            self.count = min(MOST_PAIRS, fewest_places)

    def shortage_words(self, wanted: int) -> str:
        """Say what a scene has in place of a wanted number of specimens."""
        if self.noun == Specimens.noun:
            return super().shortage_words(wanted)
        return f"room for {self.count} of the {wanted} places that it takes"

    def correlation(
        self, first: Candidate, second: Candidate, numbers: Sequence[int]
    ) -> Array | None:
        """Return the correlation of the differences of two candidates between places of scans.

        It is the mean of the correlations of both, by how much their levels scatter. Places on the
        same scan have the same one. A surface with seeds takes the correlation of the other's scan,
        so that its own independence is not counted. None where no candidate has a scan.
        """
        most = min(MOST_PAIRS, self.count)
        alike = [_alike_places(candidate.scene, most) for candidate in (first, second)]
        scans = [of_one for of_one in alike if of_one is not None]
        if not scans:
            return None
        weights = [of_one.variance for of_one in scans]
        mean = np.average([of_one.correlation for of_one in scans], axis=0, weights=weights)
        return np.asarray(mean[np.ix_(numbers, numbers)])

    def scene(self, candidate: Candidate, number: int) -> Scene:
        """Return the scene of a candidate on the specimen of a number, from 0 on."""
        scene = with_seed(candidate.scene, self._first_seed + number)
        changes: dict[str, Any] = {}
        scan = _places(scene)
        if scan is not None:
            place = scan[number]
            changes["rolling.start_um"] = scene.rolling.start_um + place.along_um
            changes["rolling.across_um"] = scene.rolling.across_um + place.across_um
        if changes:
            scene = scene.with_(changes)
        return scene.runs()[0].scene


def _alike_places(scene: Scene, count: int) -> AlikePlaces | None:
    """Return how much alike the levels of the first places of a scene are.

    None for a surface that the program makes, and where nothing is heard by the linear response.
    """
    places = _places(scene)
    if places is None:
        return None
    key = (digest(scene.to_dict()), scene_surface.identity(scene), count)
    return _kept.value(key, lambda: _made_alike(scene, places[:count]))


def _made_alike(scene: Scene, places: Sequence[Place]) -> AlikePlaces | None:
    """Return how much alike the levels of places of a scene are, from its heights."""
    pressures = linear_response.heard_places(scene)
    if not np.any(pressures):
        return None
    track = scene.track
    nodes = min(len(pressures), max(1, round(track.steps * track.step / track.spacing)))
    levels = alike_levels(pressures, nodes)
    along = np.array([round(1e-6 * place.along_um / track.spacing) for place in places])
    across = np.array([round(1e-6 * place.across_um / track.spacing) for place in places])
    return AlikePlaces(levels.between(along, across), levels.variance)


def _first_seed(candidates: Sequence[Candidate]) -> int:
    """Return the seed of the first specimen, that of the first candidate that has one."""
    for candidate in candidates:
        for seed in seeds_of(candidate.scene).values():
            return seed
    return 1


def _places(scene: Scene) -> list[Place] | None:
    """Return the places on a measured surface; None for a surface that the program makes.

    They stand in an order in which the first ones are far apart. Tracks are a contact width apart,
    or nearer where the scan has no room for enough of them. A track round the whole scan has no
    other stretch along it.
    """
    if scene.surface.kind != "file":
        return None
    track = scene.track
    _, half_width = smooth_contact_of(scene).semi_axes_m()
    width = track.n_across * track.spacing
    rows = max(1, int(width / (2.0 * half_width)))
    columns = max(1, track.lap_steps // track.steps)
    fewest = LOOKS[0]
    if rows * columns < fewest:
        rows = min(fewest, track.n_across)
    places = []
    for row in range(rows):
        for column in range(columns):
            along = column * track.lap_steps * track.step / columns
            places.append(Place(along_um=1e6 * along, across_um=1e6 * row * width / rows))
    return _far_apart(places)


def _far_apart(places: Sequence[Place]) -> list[Place]:
    """Return places in an order in which neighbours in the list are far apart on the surface."""
    left = list(places)
    ordered = []
    at = 0.0
    while left:
        ordered.append(left.pop(int(at * len(left))))
        at = (at + _GOLDEN) % 1.0
    return ordered
