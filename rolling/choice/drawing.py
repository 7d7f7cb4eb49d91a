"""Values that stand on a drawing, and scenes in which one of them is a little larger.

Which values these are, the kind of a scene knows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rolling.choice.candidate import Candidate
from rolling.kinds.registry import kind_of
from rolling.marches.piece import contact_identity
from rolling.results import labels
from rolling.scene.messages import SceneError

if TYPE_CHECKING:
    from rolling.choice.audition import Audition

TENTH = 1.1  # factor of a value that is changed by a tenth
DIGITS = 10  # of a changed value; the digits behind are rounding
AS_IT_IS = "as it is"  # label of the unchanged scene
ONE_GRADE = "one grade"
DISTANCE = "sound.distance_m"


class Words(NamedTuple):
    """What a larger or a smaller value is called: a thicker or a thinner plate."""

    larger: str
    smaller: str


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


def helping_words(change: ChangedValue, louder_db: float) -> str:
    """Say by how much which value would be larger or smaller, so that a scene is quieter.

    Parameters
    ----------
    change : ChangedValue. The value.
    louder_db : float. Change of the level when the value is larger.
    """
    words = change.words.smaller if louder_db > 0 else change.words.larger
    if change.step == ONE_GRADE:
        return f"one step {words}"
    return f"{change.step} {words}"


class LeftOut(NamedTuple):
    """A value that could not be changed, and why."""

    key: str
    name: str
    reason: str


class WantedValue(NamedTuple):
    """A value that will be changed: its larger and its smaller form, None where there is none.

    key : str. Dotted key; an order of a waviness has its number at the end.
    set_key : str. Key of the scene that is given the larger or smaller form.
    """

    key: str
    set_key: str
    name: str
    unit: str
    old: float | str
    larger: Any
    smaller: Any
    step: str
    words: Words


def changes_of(
    audition: Audition, scene: Any, base: Candidate, workers: int, folder: Path
) -> tuple[list[ChangedValue], list[LeftOut]]:
    """Return a change of every value of a drawing that a scene has, and those that cannot change.

    Parameters
    ----------
    audition : Audition. How scenes of the kind are compared.
    scene : scene. The scene as it was given, whose values are changed.
    base : Candidate. Its candidate, by `unchanged`.
    workers, folder : int, Path. Number of processes and folder, for which changes are refused.
    """
    changes = []
    left_out = []
    same_contacts = _contacts(base)
    for wanted in audition.drawing_values(scene):
        if isinstance(wanted, LeftOut):
            left_out.append(wanted)
            continue
        reason = ""
        for value, is_upwards in ((wanted.larger, True), (wanted.smaller, False)):
            if value is None:
                continue
            new = _shown(wanted, value)
            label = labels.worded(wanted.key, new)
            if wanted.set_key != wanted.key:
                label = f"{wanted.name} {new:g} {wanted.unit}"
            try:
                changed = audition.with_value(base, wanted.set_key, value, label)
                refuse(changed, workers, folder)
            except SceneError as error:
                reason = reason or error.mistakes[0]
                continue
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
                    shares_march=_contacts(changed) <= same_contacts,
                )
            )
            break
        else:
            left_out.append(LeftOut(wanted.key, wanted.name, reason))
    return changes, left_out


def refuse(changed: Candidate, workers: int, folder: Path) -> None:
    """Raise SceneError for a candidate that cannot run here."""
    kind_of(changed.scene).refuse(changed.scene, workers, folder)


def _contacts(candidate: Candidate) -> set[str]:
    """Return the contact identities of the marches of a candidate."""
    marches = kind_of(candidate.scene).marches(candidate.scene.runs()[0].scene)
    return {contact_identity(march.scene) for march in marches}


def _shown(wanted: WantedValue, value: Any) -> float | str:
    """Return a changed value as tables show it."""
    if isinstance(value, dict):
        return float(value[int(wanted.key.rpartition(".")[2])])
    return value if isinstance(value, str) else float(value)


# ---- values of a drawing


def tenth_of(key: str, value: float, words: Words) -> WantedValue:
    """Return a number that will be a tenth larger, or smaller."""
    name, unit = labels.named(key)
    return WantedValue(
        key=key,
        set_key=key,
        name=name,
        unit=unit,
        old=float(value),
        larger=plain(value * TENTH),
        smaller=plain(value / TENTH),
        step="10 %",
        words=words,
    )


def grade_of(key: str, grade: str, grades: Sequence[str], words: Words) -> WantedValue:
    """Return a grade that will be the next coarser one, or finer one."""
    place = list(grades).index(grade)
    return WantedValue(
        key=key,
        set_key=key,
        name=labels.named(key)[0],
        unit="",
        old=grade,
        larger=grades[place + 1] if place + 1 < len(grades) else None,
        smaller=grades[place - 1] if place > 0 else None,
        step=ONE_GRADE,
        words=words,
    )


def orders_of(key: str, orders: dict[int, float], whose: str) -> list[WantedValue]:
    """Return the amplitudes of a waviness by their orders, each of which will be a tenth larger."""
    amplitudes = []
    for order, amplitude in orders.items():
        name = f"waviness of order {order}{whose}"
        amplitudes.append(
            WantedValue(
                key=f"{key}.{order}",
                set_key=key,
                name=name,
                unit="um",
                old=float(amplitude),
                larger={**orders, order: plain(amplitude * TENTH)},
                smaller={**orders, order: plain(amplitude / TENTH)},
                step="10 %",
                words=Words(f"larger {name}", f"smaller {name}"),
            )
        )
    return amplitudes


def plain(value: float) -> float:
    """Return a number without the digits of its rounding error."""
    return float(f"{value:.{DIGITS}g}")
