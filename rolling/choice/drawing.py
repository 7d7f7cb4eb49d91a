"""Values that stand on a drawing, and scenes in which one of them is a little larger.

A number is changed by a tenth, a ball to the next grade, a skewness by 0.1. The track keeps its
length, so that a change of the speed meets the same surface.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

from rolling.check import refusals
from rolling.choice.candidates import Candidate, candidate
from rolling.marches.piece import contact_identity
from rolling.results import labels
from rolling.scene import step_rule
from rolling.scene.messages import SceneError, is_number
from rolling.scene.scene import Scene
from rolling.scene.surfaces import GRADES, HeightFile

TENTH = 1.1  # factor of a value that is changed by a tenth
SKEWNESS_STEP = 0.1
DIGITS = 10  # of a changed value; the digits behind are rounding
AS_IT_IS = "as it is"  # label of the unchanged scene
GRADE = "sphere.surface.grade"
WAVINESS = "sphere.surface.waviness"
SPEED = "rolling.speed_m_s"
DISTANCE = "sound.distance_m"
LOSS = "plate.contact_loss_factor"


class Words(NamedTuple):
    """What a larger or a smaller value is called: a thicker or a thinner plate."""

    larger: str
    smaller: str


# Keys that are changed by a tenth, in the order of the scene file.
TENTHS = {
    "sphere.radius_mm": Words("larger sphere radius", "smaller sphere radius"),
    "sphere.radius_across_mm": Words("larger radius across", "smaller radius across"),
    "sphere.surface.roughness_ra_um": Words("rougher sphere", "smoother sphere"),
    "sphere.surface.correlation_length_um": Words(
        "longer correlation length of the sphere", "shorter correlation length of the sphere"
    ),
    "plate.thickness_mm": Words("thicker plate", "thinner plate"),
    "plate.loss_factor": Words("larger loss factor", "smaller loss factor"),
    LOSS: Words("larger loss factor of the contact", "smaller loss factor of the contact"),
    "plate.hardness_gpa": Words("harder plate", "softer plate"),
    "plate.yield_strength_gpa": Words("stronger plate", "weaker plate"),
    "surface.roughness_ra_um": Words("larger Ra", "smaller Ra"),
    "surface.rq_um": Words("larger Sq", "smaller Sq"),
    "surface.rdq": Words("larger Sdq", "smaller Sdq"),
    "surface.correlation_length_um": Words(
        "longer correlation length", "shorter correlation length"
    ),
    "surface.correlation_length_across_um": Words(
        "longer correlation length across", "shorter correlation length across"
    ),
    "surface.rolloff_um": Words("longer roll-off", "shorter roll-off"),
    "surface.shortest_um": Words("longer shortest wave", "shorter shortest wave"),
    "rolling.load_n": Words("larger load", "smaller load"),
    SPEED: Words("higher speed", "lower speed"),
    DISTANCE: Words("larger distance of the listener", "smaller distance of the listener"),
}
SKEWNESSES = ("surface.skewness", "sphere.surface.skewness")


@dataclass(frozen=True, eq=False)
class ChangedValue:
    """A scene in which one value is a little larger, or smaller where larger is refused.

    key : str. Dotted key; an order of the waviness has its number at the end.
    name : str. What the value is called.
    old, new : float or str. The value of the scene, and the changed one.
    step : str. The change in words: 10 %, one grade, 0.1.
    words : Words. What a larger or smaller value is called.
    is_upwards : bool. Whether the changed value is the larger one.
    candidate : Candidate. The changed scene.
    shares_march : bool. Whether the change leaves the contact as it is.
    """

    key: str
    name: str
    old: float | str
    new: float | str
    step: str
    words: Words
    is_upwards: bool
    candidate: Candidate
    shares_march: bool


class LeftOut(NamedTuple):
    """A value that could not be changed, and why."""

    key: str
    name: str
    reason: str


class _Wanted(NamedTuple):
    """A value that will be changed: its larger and its smaller form, None where there is none."""

    key: str
    name: str
    unit: str
    old: float | str
    larger: Any
    smaller: Any
    step: str
    words: Words


def unchanged(scene: Scene) -> Candidate:
    """Return the candidate of a scene without a sweep, with a track and steps that no change moves.

    Other steps would pass for another sound.
    """
    return with_shared_steps(with_free_steps(scene), [])


def with_free_steps(scene: Scene) -> Candidate:
    """Return the candidate of a scene without a sweep, with a track that no change moves."""
    return candidate(AS_IT_IS, with_kept_track(scene))


def with_shared_steps(base: Candidate, others: Sequence[Candidate]) -> Candidate:
    """Return a candidate with the shortest steps that `auto` takes for it or for others."""
    if base.scene.numerics.step_nodes != "auto":
        return base
    nodes = []
    for one in (base, *others):
        nodes.append(step_rule.choose(one.scene, one.scene.slowest_speed).nodes)
    steps = {"numerics.step_nodes": min(nodes), "numerics.slowest_m_s": None}
    return replace(base, scene=base.scene.with_(steps))


def with_kept_track(scene: Scene) -> Scene:
    """Return a scene whose track has a length in place of a duration."""
    rolling = scene.rolling
    is_file = isinstance(scene.surface, HeightFile)
    if rolling.distance_mm is not None or (is_file and rolling.duration_s is None):
        return scene
    distance = scene.track.distance
    if is_file and rolling.duration_s is not None:
        distance = float(scene.motion.distance(rolling.duration_s))
    return scene.with_(
        {"rolling.duration_s": None, "rolling.distance_mm": float(f"{1e3 * distance:.12g}")}
    )


def with_value(base: Candidate, key: str, value: Any, label: str) -> Candidate:
    """Return a candidate with another value of one key.

    Raises
    ------
    SceneError : the value is not allowed.
    """
    loss_factors = base.loss_factors
    if key == LOSS:
        loss_factors = (float(value),)
    scene = base.scene.with_({key: value})
    return replace(base, label=label, scene=scene, loss_factors=loss_factors)


def refuse(changed: Candidate, workers: int, folder: Path) -> None:
    """Raise SceneError for a candidate that cannot run here."""
    refusals.refuse(changed.scene, workers, folder)


def changes_of(
    scene: Scene, base: Candidate, workers: int, folder: Path
) -> tuple[list[ChangedValue], list[LeftOut]]:
    """Return a change of every value of a drawing that a scene has, and those that cannot change.

    Parameters
    ----------
    scene : Scene. The scene as it was given, whose values are changed.
    base : Candidate. Its candidate, by `unchanged`.
    workers, folder : int, Path. Number of processes and folder, for which changes are refused.
    """
    changes = []
    left_out = []
    same_contact = contact_identity(base.scene.runs()[0].scene)
    for wanted in _wanted(scene):
        if isinstance(wanted, LeftOut):
            left_out.append(wanted)
            continue
        reason = ""
        for value, is_upwards in ((wanted.larger, True), (wanted.smaller, False)):
            if value is None:
                continue
            new = _shown(wanted, value)
            label = labels.worded(wanted.key, new)
            if wanted.key.startswith(WAVINESS):
                label = f"{wanted.name} {new:g} {wanted.unit}"
            try:
                changed = with_value(base, _key_of_scene(wanted.key), value, label)
                refuse(changed, workers, folder)
            except SceneError as error:
                reason = reason or error.faults[0]
                continue
            identity = contact_identity(changed.scene.runs()[0].scene)
            changes.append(
                ChangedValue(
                    key=wanted.key,
                    name=wanted.name,
                    old=wanted.old,
                    new=new,
                    step=wanted.step,
                    words=wanted.words,
                    is_upwards=is_upwards,
                    candidate=changed,
                    shares_march=identity == same_contact,
                )
            )
            break
        else:
            left_out.append(LeftOut(wanted.key, wanted.name, reason))
    return changes, left_out


def _key_of_scene(key: str) -> str:
    """Return the key of the scene that holds a value."""
    return WAVINESS if key.startswith(WAVINESS) else key


def _shown(wanted: _Wanted, value: Any) -> float | str:
    """Return a changed value as tables show it."""
    if isinstance(value, dict):
        return float(value[int(wanted.key.rpartition(".")[2])])
    return value if isinstance(value, str) else float(value)


def _wanted(scene: Scene) -> Iterator[_Wanted | LeftOut]:
    """Yield the values of a drawing that a scene has."""
    for key, words in TENTHS.items():
        name, unit = labels.named(key)
        value = labels.value_at(scene, key)
        if key == DISTANCE and scene.sound.listener_mm is not None:
            continue  # which places the listener
        if key == SPEED and isinstance(value, tuple):
            yield LeftOut(key, name, "the speed changes along the track")
        elif isinstance(value, tuple):
            yield LeftOut(key, name, "the loss factor changes with the frequency")
        elif key == "rolling.load_n" and not is_number(value):
            yield LeftOut(key, name, "the load is the weight of the sphere")
        elif is_number(value) and value > 0:
            yield _Wanted(
                key=key,
                name=name,
                unit=unit,
                old=float(value),
                larger=_plain(value * TENTH),
                smaller=_plain(value / TENTH),
                step="10 %",
                words=words,
            )
    for key in SKEWNESSES:
        value = labels.value_at(scene, key)
        if is_number(value):
            name, unit = labels.named(key)
            yield _Wanted(
                key=key,
                name=name,
                unit=unit,
                old=float(value),
                larger=_plain(value + SKEWNESS_STEP),
                smaller=_plain(value - SKEWNESS_STEP),
                step=f"{SKEWNESS_STEP:g}",
                words=Words(f"larger {name}", f"smaller {name}"),
            )
    yield from _grades(scene)
    yield from _orders(scene)


def _grades(scene: Scene) -> Iterator[_Wanted]:
    """Yield the grade of the ball of a scene, if it has one."""
    grade = labels.value_at(scene, GRADE)
    if grade is None:
        return
    names = [*GRADES]
    place = names.index(grade)
    yield _Wanted(
        key=GRADE,
        name="grade",
        unit="",
        old=grade,
        larger=names[place + 1] if place + 1 < len(names) else None,
        smaller=names[place - 1] if place > 0 else None,
        step="one grade",
        words=Words("coarser grade", "finer grade"),
    )


def _orders(scene: Scene) -> Iterator[_Wanted]:
    """Yield the amplitudes of the waviness of the ball of a scene, by their orders."""
    orders = labels.value_at(scene, WAVINESS) or {}
    for order, amplitude in orders.items():
        name = f"waviness of order {order}"
        yield _Wanted(
            key=f"{WAVINESS}.{order}",
            name=name,
            unit="um",
            old=float(amplitude),
            larger={**orders, order: _plain(amplitude * TENTH)},
            smaller={**orders, order: _plain(amplitude / TENTH)},
            step="10 %",
            words=Words(f"larger {name}", f"smaller {name}"),
        )


def _plain(value: float) -> float:
    """Return a number without the digits of its rounding error."""
    return float(f"{value:.{DIGITS}g}")
