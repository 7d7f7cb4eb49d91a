"""Candidates of a choice: scenes that are made comparable, or refused with the keys that differ."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rolling.choice.audition import nothing_to_choose
from rolling.choice.candidate import LONGEST_NAME, MAX_CANDIDATES, Candidate, slug
from rolling.in_si.assumed_bodies import bodies_text, with_bodies
from rolling.kinds.run_folder import RunFolder
from rolling.results import labels
from rolling.results.labels import SEED
from rolling.scene import step_rule
from rolling.scene.length_choice import longest_choice
from rolling.scene.messages import SceneError, plain_number, quoted
from rolling.scene.scene import Scene

SHORT_S = 0.2  # records that are shorter have to last equally long
SAME_DURATION = 0.01  # relative; tracks are whole nodes, so durations differ a little
LOSS_KEY = "plate.contact_loss_factor"
LOSS_FACTORS = (0.005, 0.02)  # of a contact whose scene states none
# Keys of the listener, which have the same value in all candidates.
LISTENER_KEYS = ("sound.distance_m", "sound.listener_mm", "sound.ball", "sound.room_db")


@dataclass(frozen=True, eq=False)
class BallCandidate(Candidate):
    """A scene of a ball with dynamics, whose vibration is heard.

    loss_factors : tuple of float. Loss factors of the contact at which it is heard.
    added : str. Bodies that were added to a scene without dynamics, in words; empty if none were.
    """

    scene: Scene
    loss_factors: tuple[float, ...]
    added: str


def of_ball(candidate: Candidate) -> BallCandidate:
    """Return a candidate of a choice of balls as what it is."""
    assert isinstance(candidate, BallCandidate)
    return candidate


def candidates_of(scenes: Sequence[Scene]) -> list[BallCandidate]:
    """Return the candidates of scenes: each run of a sweep is one.

    A single scene with faults is compared with the same scene without them.

    Raises
    ------
    SceneError : there is nothing to choose between, or the scenes are not comparable.
    """
    runs: list[RunFolder] = []
    for scene in scenes:
        runs += _runs_of(scene)
    if len(runs) > MAX_CANDIDATES:
        raise SceneError([f"{len(runs)} candidates, allowed: at most {MAX_CANDIDATES}"])
    names = _labels(runs)
    if len(runs) == 1:
        runs = [runs[0], _without_faults(runs[0])]
        names = ["the scene with faults", "the scene without faults"]
    candidates = [candidate(name, run.scene) for name, run in zip(names, runs, strict=True)]
    candidates = with_one_length(candidates)
    mistakes = [*_incomparable(candidates)]
    if mistakes:
        raise SceneError(mistakes)
    return [with_steps_shared_by(own, candidates) for own in candidates]


def _runs_of(scene: Scene) -> list[RunFolder]:
    """Return the runs of a scene; seeds that it sweeps are no candidates."""
    if SEED in scene.sweep:
        seed = labels.value_at(scene.runs()[0].scene, SEED)
        scene = scene.with_({SEED: seed})
    return [
        RunFolder(values, run.with_auto_steps().with_auto_length(), Path())
        for values, run in scene.runs()
    ]


def _labels(runs: Sequence[RunFolder]) -> list[str]:
    """Name candidates by their scenes where these differ, otherwise by what differs in them."""
    names = [run.scene.name for run in runs]
    if len(set(names)) < len(names):
        names = _swept_names(runs) or labels.labels(runs)
    if len({slug(name)[:LONGEST_NAME].lower() for name in names}) < len(names):
        return [f"{number}: {name}" for number, name in enumerate(names, start=1)]
    return names


def _swept_names(runs: Sequence[RunFolder]) -> list[str]:
    """Return the names among which one swept key chooses, of files without their ending."""
    values = [tuple(run.values.values()) for run in runs]
    if not all(len(value) == 1 and isinstance(value[0], str) for value in values):
        return []
    names = [str(value[0]) for value in values]
    if all("surface.path" in run.values for run in runs):
        names = [Path(name).stem for name in names]
    return names if len(set(names)) == len(names) else []


def _without_faults(run: RunFolder) -> RunFolder:
    """Return the only scene of a choice without its single faults."""
    scene = run.scene
    changes: dict[str, Any] = {}
    if scene.surface.faults:
        changes["surface.faults"] = None
    ball = scene.sphere.surface
    if ball is not None and ball.faults:
        changes["sphere.surface.faults"] = None
    if not changes:
        raise nothing_to_choose(scene)
    return replace(run, scene=scene.with_(changes))


def candidate(label: str, scene: Scene) -> BallCandidate:
    """Return a candidate of a scene without a sweep, whose vibration will be heard."""
    added = ""
    changes: dict[str, Any] = {
        "sound.source": "vibration",
        "sound.q": None,
        "sound.gain_pa_per_w_m2": None,
        "sound.listen_s": None,
        "sound.loudness": False,
    }
    if scene.dynamics is None:
        added = bodies_text(scene)
        scene = with_bodies(scene)
    elif scene.dynamics.release is None:
        changes["dynamics.release"] = False  # the release under the constant load tells enough
    loss_factors: tuple[float, ...] = LOSS_FACTORS
    if scene.plate.contact_loss_factor is not None:
        loss_factors = (scene.plate.contact_loss_factor,)
    else:
        changes[LOSS_KEY] = LOSS_FACTORS[0]
    return BallCandidate(
        label=label,
        scene=scene.with_(changes),
        loss_factors=loss_factors,
        added=added,
    )


def with_one_length(candidates: Sequence[BallCandidate]) -> list[BallCandidate]:
    """Return candidates with one length where `auto` chooses it, or where scans are rolled once.

    It is the longest that a scene states, because records of other lengths are no pair; where none
    states one, the longest that a candidate needs. Scans have the length of the shortest one.
    """
    candidates = _with_shortest_lap(candidates)
    choices = [candidate.scene.length_choice for candidate in candidates]
    needs = [choice for choice in choices if choice is not None]
    stated = [
        candidate.scene.duration
        for candidate, choice in zip(candidates, choices, strict=True)
        if choice is None
    ]
    if not needs:
        return list(candidates)
    shared = longest_choice(needs)
    made = []
    for own, choice in zip(candidates, choices, strict=True):
        scene = own.scene
        if choice is not None and stated:
            seconds = float(f"{max(stated):.12g}")
            scene = scene.with_({"rolling.duration_s": seconds, "rolling.distance_mm": None})
        elif choice is not None:
            scene = scene.with_length(shared)
        made.append(replace(own, scene=scene))
    return made


def _with_shortest_lap(candidates: Sequence[BallCandidate]) -> list[BallCandidate]:
    """Return candidates whose scans are rolled over once, as far as the shortest one lasts.

    A length that another scene states ends them, too.
    """
    scenes = [ball_candidate.scene for ball_candidate in candidates]
    if not any(scene.is_one_lap for scene in scenes):
        return list(candidates)
    given = [scene.duration for scene in scenes if scene.length_choice is None]
    shortest = min(given, default=SHORT_S)
    if shortest >= SHORT_S:
        return list(candidates)
    seconds = float(f"{shortest:.12g}")
    made = []
    for own in candidates:
        if own.scene.is_one_lap and _differ(own.scene.duration, shortest):
            own = replace(own, scene=own.scene.with_({"rolling.duration_s": seconds}))
        made.append(own)
    return made


def with_steps_shared_by(own: BallCandidate, candidates: Sequence[BallCandidate]) -> BallCandidate:
    """Return one of some candidates with the shortest steps that `auto` takes for any of them.

    Equal contacts then share their marches, and other steps do not pass for other sounds. A
    candidate whose scene states its steps keeps them. Each is judged at the slowest speed of all.
    """
    if not _has_automatic_steps(own):
        return own
    slowest = min(candidate.scene.slowest_speed for candidate in candidates)
    nodes = [
        step_rule.choose(candidate.scene, slowest).nodes
        for candidate in candidates
        if _has_automatic_steps(candidate)
    ]
    steps = {"numerics.step_nodes": min(nodes), "numerics.slowest_m_s": None}
    return replace(own, scene=own.scene.with_(steps))


def _has_automatic_steps(ball_candidate: BallCandidate) -> bool:
    """Tell whether the program chooses the steps of a candidate."""
    return ball_candidate.scene.numerics.step_nodes == "auto"


# ---- comparability


def _incomparable(candidates: Sequence[BallCandidate]) -> Iterator[str]:
    """Yield a sentence for each key whose difference makes a comparison void."""
    first = candidates[0].scene
    for other in candidates[1:]:
        scene = other.scene
        for key in LISTENER_KEYS:
            mine = labels.value_at(first, key)
            theirs = labels.value_at(scene, key)
            if mine != theirs:
                yield (
                    f"{scene.place(key)}: {key}: got {quoted(theirs)} for {other.label}, and"
                    f" {quoted(mine)} for {candidates[0].label}; a choice is made for one listener"
                )
        if first.is_one_event != scene.is_one_event:
            yield (
                f"{scene.place('rolling.drop_mm')}: rolling.drop_mm: one of {other.label} and"
                f" {candidates[0].label} falls and the other rolls; an event and a steady sound"
                " have no difference of levels"
            )
        yield from _other_duration(candidates[0], other)


def _other_duration(first: BallCandidate, other: BallCandidate) -> Iterator[str]:
    """Yield a sentence where two records differ in length and one is short."""
    mine = first.scene.duration
    theirs = other.scene.duration
    if _differ(mine, theirs) and min(mine, theirs) < SHORT_S:
        yield (
            f"{other.scene.place('rolling.duration_s')}: rolling.duration_s: {other.label} lasts"
            f" {plain_number(round(theirs, 6))} s and {first.label}"
            f" {plain_number(round(mine, 6))} s, allowed below {SHORT_S:g} s: equal durations;"
            f" give both rolling.duration_s: {SHORT_S:g}"
        )


def _differ(first_s: float, second_s: float) -> bool:
    """Tell whether two durations [s] differ by more than whole nodes of a track."""
    return abs(first_s - second_s) > SAME_DURATION * max(first_s, second_s)
