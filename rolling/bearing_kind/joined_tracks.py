"""Tracks of a bearing from its plan: roughness, waves around, measured turns and faults."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from acoustics.arrays import Array
from rolling.bearing import waves
from rolling.bearing.oil_film import ContactFilm
from rolling.bearing.tracks import BearingTracks, BodyTrack, smooth_track
from rolling.bearing_kind.body_forms import (
    form_of,
    isotropic_exponent,
    points_of_waves,
    without_law,
)
from rolling.bearing_kind.contact_plan import (
    RINGS,
    ContactPlan,
    contact_of,
    kinds_of_contact,
    radius_of,
    ring_of,
)
from rolling.bearing_kind.faults import FaultStretch, added_at_angle
from rolling.bearing_kind.rough_contacts import RoughContact
from rolling.bearing_kind.specimen_turn import RoughBody, rough_body
from rolling.bearing_kind.turns import continued_turn
from rolling.in_si.in_metres import read_heights
from rolling.marches.piece import contact_identity
from rolling.run.march_files import ContactMarch, Marches
from rolling.scene.raceways import BearingSurface
from rolling.scene.scene import Scene
from rolling.scene.surfaces import BallHeightFile, GradedBall
from rolling.surface.ball_form import BallForm, form_heights
from rolling.surface.single_faults import add_faults

LEAST_POINTS = 4096  # of a turn without roughness
# Parts of seeds, so that roughness and place of balls differ.
_ROUGHNESS = 1
_PLACE = 2
# Laws of waves in films.
CIRCULAR_LAW = "circular"
LINE_LAW = "line"
BETWEEN_LAWS = "between"


def bearing_tracks(
    plan: ContactPlan, marches: Marches | None = None, draw: int = 0
) -> BearingTracks:
    """Return the tracks of a bearing from the marches of its contacts that are there.

    Without a march of a contact its roughness enters by the linear response. At a load that is not
    marched, the nonlinear part is that of the nearest load that is. Faults need their marches.

    Parameters
    ----------
    plan : ContactPlan
        Contacts of the bearing.
    marches : dict, optional
        Marches by contact identity, as of `march_contacts`. Default: none.
    draw : int
        Number of a specimen of equal statistics: others than 0 have other random heights around
        each body, other forms of graded balls, and begin at other angles. They need no march of
        their own, and have as many different waves as a turn has, where 0 has those of the marched
        stretch. Default 0.

    Returns
    -------
    BearingTracks
    """
    known = marches or {}
    rows = {name: acting_rows(plan, contact, known) for name, contact in plan.rough.items()}
    solved = _Solved(
        plan=plan,
        rows=rows,
        bodies={} if draw == 0 else _rough_bodies(plan, rows),
        changes=[_fault_change(stretch, known) for stretch in plan.faults],
    )
    rings = {ring: _ring_track(solved, ring, draw) for ring in RINGS}
    balls = [_ball_tracks(solved, ball, draw) for ball in range(plan.geometry.balls)]
    return BearingTracks(
        inner=rings["inner"],
        outer=rings["outer"],
        balls_on_inner=tuple(tracks[0] for tracks in balls),
        balls_on_outer=tuple(tracks[1] for tracks in balls),
    )


def points_of_turn(plan: ContactPlan, body: str) -> int:
    """Return the number of points of the track around "inner", "outer" or "balls"."""
    surface = plan.surfaces[body]
    if surface is None:
        return smooth_track().points
    name = kinds_of_contact(body)[0]
    turn = 2 * np.pi * radius_of(plan.geometry, body)
    points = LEAST_POINTS
    if name in plan.rough:
        points = round(turn / plan.rough[name].scene.step)
    for stretch in plan.faults:
        if stretch.name == name:
            points = max(points, int(np.ceil(turn / stretch.with_fault.step)))
    return max(points, points_of_waves(surface, plan.folder))


@dataclass(frozen=True)
class _Solved:
    """Contacts of a bearing with what their marches give, which all balls share.

    rows : dict. Changes of the approach by roughness [m], (loads, steps), by kind of contact.
    bodies : dict. Rough bodies of which further specimens are drawn; none for the first specimen.
    changes : list. Changes of the approach by each fault [m], (loads, steps); None without a march.
    """

    plan: ContactPlan
    rows: dict[str, Array]
    bodies: dict[str, RoughBody]
    changes: list[Array | None]


def _rough_bodies(plan: ContactPlan, rows: Mapping[str, Array]) -> dict[str, RoughBody]:
    """Return the rough bodies of which specimens are drawn; measured ones have one specimen."""
    bodies = {}
    for body in plan.surfaces:
        names = [name for name in kinds_of_contact(body) if name in plan.rough]
        contacts = [plan.rough[name] for name in names]
        if contacts and not contacts[0].scene.height_paths:
            bodies[body] = rough_body(contacts, [rows[name] for name in names])
    return bodies


def _ring_track(solved: _Solved, ring: str, draw: int) -> BodyTrack:
    """Return the track around a raceway, which begins as it is marched in the first specimen."""
    surface = solved.plan.surfaces[ring]
    if surface is None:
        return smooth_track()
    seed = (getattr(surface, "seed", 0), _ROUGHNESS, draw)
    body = _Body(ring, surface, form_of(surface, solved.plan.folder, draw))
    (track,) = _body_tracks(solved, body, seed=seed, keep_rows=draw == 0)
    if draw == 0:
        return track
    return _turned(track, np.random.default_rng((*seed, _PLACE)).uniform())


def _ball_tracks(solved: _Solved, ball: int, draw: int) -> list[BodyTrack]:
    """Return the tracks around a ball on the inner and on the outer raceway.

    Balls share their marches. Each has heights and form of its own, and begins at another angle.
    No ball begins as it is marched, because a raceway of equal seed may do so.
    """
    plan = solved.plan
    surface = plan.surfaces["balls"]
    if surface is None:
        return [smooth_track(), smooth_track()]
    own_seed = getattr(surface, "seed", 0)
    number = draw * plan.geometry.balls + ball
    if isinstance(surface, GradedBall):
        surface = surface.model_copy(update={"seed": own_seed + number})
    if surface.faults and ball != plan.fault_ball:
        surface = surface.model_copy(update={"faults": None})
    seed = (own_seed, _ROUGHNESS, draw, ball)
    body = _Body("balls", surface, form_of(surface, plan.folder))
    tracks = _body_tracks(solved, body, seed=seed, keep_rows=False)
    if number == 0:
        return tracks
    share = np.random.default_rng((*seed, _PLACE)).uniform()
    return [_turned(track, share) for track in tracks]


def _turned(track: BodyTrack, share: float) -> BodyTrack:
    """Return a track that begins a share of a turn earlier."""
    begin = round(share * track.points)
    return BodyTrack(track.loads_n, np.roll(track.approach_m, begin, axis=1))


@dataclass(frozen=True)
class _Body:
    """A body of a bearing with its surface and the waves around it."""

    name: str
    surface: BearingSurface
    form: BallForm


def _body_tracks(
    solved: _Solved, body: _Body, *, seed: tuple[int, ...], keep_rows: bool
) -> list[BodyTrack]:
    """Return the tracks of a body, one for each kind of contact that it meets."""
    plan = solved.plan
    surface = body.surface
    names = kinds_of_contact(body.name)
    radius = radius_of(plan.geometry, body.name)
    loads = np.array(plan.loads_n)
    parts = [np.zeros((len(loads), LEAST_POINTS))] * len(names)
    if names[0] in solved.rows:
        rows = np.concatenate([solved.rows[name] for name in names])
        if isinstance(surface, BallHeightFile):  # a whole turn was marched
            turn = without_eccentricity(rows)
        else:
            points = round(2 * np.pi * radius / plan.rough[names[0]].scene.step)
            number = int(np.random.SeedSequence(seed).generate_state(1)[0])
            if body.name in solved.bodies:
                turn = solved.bodies[body.name].turn(points, number)
            else:
                turn = continued_turn(rows, points, number, keep_rows)
        parts = np.split(turn, len(names))
    tracks = []
    for name, part in zip(names, parts, strict=True):
        track = BodyTrack(loads, part)
        faults = []
        if surface.faults:
            pairs = zip(plan.faults, solved.changes, strict=True)
            faults = [(stretch, change) for stretch, change in pairs if stretch.name == name]
        for stretch, _ in faults:
            points = int(np.ceil(2 * np.pi * radius / stretch.with_fault.step))
            track = track.resampled(max(points, track.points))
        track = track.resampled(max(points_of_waves(surface, plan.folder), track.points))
        for form in _forms(plan, name, body, track.points):
            track = track.plus(BodyTrack(loads, form))
        values = track.approach_m
        for stretch, change in faults:
            if change is not None:
                values = added_at_angle(values, stretch.places_m, change, stretch.angle, radius)
        tracks.append(BodyTrack(loads, values))
    return tracks


def _forms(plan: ContactPlan, name: str, body: _Body, points: int) -> list[Array]:
    """Return the changes of the approach by waves around a body, and by a narrow measured turn."""
    surface = body.surface
    radius = radius_of(plan.geometry, body.name)
    contact = contact_of(plan.geometry, name)
    turn = 2 * np.pi * radius
    film = film_of(plan, name)
    forms = []
    profile = np.zeros(points)
    if surface.has_form:
        profile += form_heights(body.form, points)
    exponent = isotropic_exponent(surface)
    if exponent is not None:
        known = form_heights(without_law(body.form), points)
        random = profile - known
        profile = known
        rows = waves.approach_of_profile(random, radius, contact, plan.loads_n, exponent)
        forms.append(rows_through_film(rows, plan.loads_n, turn, film))
    steps = [fault.in_si for fault in surface.faults or () if fault.kind == "step"]
    if steps:
        line = np.zeros((points, 1))
        add_faults(line, steps, turn / points)
        profile += line[:, 0]
    if profile.any():
        rows = waves.approach_of_profile(profile, radius, contact, plan.loads_n)
        forms.append(rows_through_film(rows, plan.loads_n, turn, film))
    if isinstance(surface, BallHeightFile) and name not in plan.rough:
        path = plan.folder / surface.path
        heights = read_heights(path, surface.height_unit, "bearing.surfaces")
        spacing = (turn / len(heights), surface.spacing_um * 1e-6)
        measured = waves.approach_of_heights(heights, spacing, contact, plan.loads_n)
        measured = rows_through_film(measured, plan.loads_n, turn, film)
        forms.append(without_eccentricity(measured))
    return forms


def without_eccentricity(rows: Array) -> Array:
    """Return rows around a turn without their wave of order 1, and with zero mean."""
    waves_of_rows = np.fft.rfft(rows, axis=1)
    waves_of_rows[:, :2] = 0.0
    return np.asarray(np.fft.irfft(waves_of_rows, rows.shape[1], axis=1))


# ---- films of oil


def film_of(plan: ContactPlan, name: str) -> ContactFilm | None:
    """Return the film of a kind of contact by its name; None for a dry one."""
    return plan.films.get(ring_of(name))


def acting_rows(
    plan: ContactPlan,
    contact: RoughContact,
    marches: Marches,
    law: str = BETWEEN_LAWS,
    weight: float | None = None,
) -> Array:
    """Return the changes of the approach that act at all loads [m], (loads, steps).

    They are those of the march in a dry contact, those of the linear response through a film where
    it parts the surfaces, and both by their weights between.

    Parameters
    ----------
    plan : ContactPlan
        Contacts of the bearing, and their films.
    contact : RoughContact
        Rough contact.
    marches : dict
        Marches by contact identity.
    law : str
        Law of waves in a film, as of `rows_through_film`.
    weight : float, optional
        Weight of the film. Default: that of its thickness over the roughness.
    """
    dry = rough_rows(contact, marches)
    film = film_of(plan, contact.name)
    if film is None:
        return dry
    weight = film.weight if weight is None else weight
    length_m = contact.steps * contact.scene.step
    wet = rows_through_film(
        contact.own_linear_rows, contact.loads_n, length_m, film, law=law, weight=1.0
    )
    return (1 - weight) * dry + weight * wet


def rows_through_film(
    rows: Array,
    loads_n: Sequence[float],
    length_m: float,
    film: ContactFilm | None,
    law: str = BETWEEN_LAWS,
    weight: float | None = None,
) -> Array:
    """Return the linear response at some loads as it acts through a film, (loads, points).

    Parameters
    ----------
    rows : array (loads, points), m
        Linear changes of the approach along a closed track.
    loads_n : sequence of float, N
        Loads.
    length_m : float, m
        Length of the track.
    film : ContactFilm or None
        Film; None for a dry contact.
    law : str
        Law of waves in a film: circular, line, or their geometric mean.
    weight : float, optional
        Weight of the film. Default: that of its thickness over the roughness.
    """
    if film is None:
        return rows
    weight = film.weight if weight is None else weight
    lines = np.fft.rfft(rows, axis=1)
    number = np.arange(1, lines.shape[1])
    for place, load in enumerate(loads_n):
        circular, line = film.at_load(load).pressed_shares(length_m / number)
        shares = {CIRCULAR_LAW: circular, LINE_LAW: line, BETWEEN_LAWS: np.sqrt(circular * line)}
        lines[place, 1:] *= 1 - weight + weight * shares[law]
    return np.asarray(np.fft.irfft(lines, rows.shape[1], axis=1))


# ---- marches


def rough_rows(contact: RoughContact, marches: Marches) -> Array:
    """Return the changes of the approach at all loads of a rough contact [m], (loads, steps)."""
    marched = {}
    for load, scene in contact.scenes.items():
        march = _march_of(scene, marches)
        if march is not None:
            marched[load] = march.approach_m - march.approach_m.mean()
    if len(marched) == len(contact.loads_n):
        return np.array(list(marched.values()))
    linear = contact.own_linear_rows
    if not marched:
        return linear
    by_load = dict(zip(contact.loads_n, linear, strict=True))
    rows = []
    for load in contact.loads_n:
        nearest = _nearest(load, marched)
        rows.append(by_load[load] + marched[nearest] - by_load[nearest])
    return np.array(rows)


def _fault_change(stretch: FaultStretch, marches: Marches) -> Array | None:
    """Return the changes of the approach by a fault at all loads [m], None without a march."""
    known = {}
    for load, (with_fault, without) in stretch.scenes.items():
        over = _march_of(with_fault, marches)
        beside = _march_of(without, marches)
        if over is not None and beside is not None:
            known[load] = over.approach_m - beside.approach_m
    if not known:
        return None
    return np.array([known[_nearest(load, known)] for load in stretch.loads_n])


def _march_of(scene: Scene, marches: Marches) -> ContactMarch | None:
    """Return the march of a scene, None where it is not there."""
    if not marches:
        return None
    return marches.get(contact_identity(scene))


def _nearest(load_n: float, known: Mapping[float, Array]) -> float:
    """Return the load among some that is nearest to a load, by their ratio."""
    return min(known, key=lambda other: abs(np.log(other / load_n)))
