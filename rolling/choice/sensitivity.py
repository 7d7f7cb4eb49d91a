"""What would help: how much louder a scene becomes when a value of its drawing is a little larger.

The scene and the changed scene meet the same specimens, so that what they share cancels. Marches
are shared where the value does not change the contact. Of balls, the linear chain gives every
change a second time.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from acoustics.arrays import Array
from acoustics.pairs import FIRST_PAIRS, SURE, paired_mean, pairs_needed
from acoustics.texts import printable
from rolling.choice import drawing
from rolling.choice.advice import Advice, write_advice
from rolling.choice.audition import audition_of
from rolling.choice.candidate import Candidate
from rolling.choice.change_words import SHOWN_DB, in_words, two_digits
from rolling.choice.choice_doubts import left_out_text
from rolling.choice.choice_numbers import Contender, OmittedPair, leading_of
from rolling.choice.choice_sentences import capital, counted
from rolling.choice.choosing import OpenChoice, default_folder, open_choice
from rolling.choice.difference import Difference
from rolling.choice.drawing import ChangedValue, LeftOut
from rolling.choice.heard_specimen import HeardQuantity
from rolling.contact.solver import ContactError
from rolling.results.description import listed
from rolling.run.budget import Budget, Clock
from rolling.scene.messages import SceneError, quoted
from rolling.scene.models import full_key
from rolling.terminal import defaults, progress

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

TOLD_DB = 0.1  # distance of the linear chain from which on it is told
NEXT = 2  # values that the sentence names after the first
USUAL = Budget(within_db=defaults.IMPROVED_WITHIN_DB)


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Change of the level when one value of a scene is a little larger.

    Attributes
    ----------
    change : ChangedValue
        The value and the changed scene.
    difference : Difference
        Level of the changed scene less that of the scene, over the same specimens.
    levels_apart_db : (specimens,) array, dB
        The same of each specimen.
    chain_db, chain_uncertainty_db : float or None, dB
        The same by the linear chain, for a larger value; None where it has no level.
    quantity : HeardQuantity
        The quantity whose level changes.
    correlation : (specimens, specimens) array or None
        Correlation of the changes on the places of a scan; None where each specimen has a surface
        of its own.
    """

    change: ChangedValue
    difference: Difference
    levels_apart_db: Array
    chain_db: float | None
    chain_uncertainty_db: float | None
    quantity: HeardQuantity
    correlation: Array | None = None

    @property
    def db(self) -> float:
        """Change of the level when the value is larger, dB(A) or dB."""
        assert self.difference.db is not None  # a silent scene is refused
        return self._for_larger(self.difference.db)

    @property
    def released_db(self) -> float | None:
        """Change of the level of the released power when the value is larger, dB(A)."""
        if self.difference.released_db is None:
            return None
        return self._for_larger(self.difference.released_db)

    @property
    def uncertainty_db(self) -> float | None:
        """Standard uncertainty of the change, dB; None for a single specimen."""
        return self.difference.uncertainty_db

    @property
    def differs_from_chain(self) -> bool:
        """Whether the linear chain differs by more than both uncertainties, and by 0.1 dB."""
        if self.chain_db is None:
            return False
        both = (self.uncertainty_db or 0.0) + (self.chain_uncertainty_db or 0.0)
        return abs(self.db - self.chain_db) > max(both, TOLD_DB)

    def _for_larger(self, db: float) -> float:
        """Return a change for the larger value, from that of the value that was computed."""
        return db if self.change.is_upwards else -db


@dataclass(frozen=True, eq=False, repr=False)
class Sensitivities(Advice):
    """Changes of the level of a scene by the values of its drawing, the largest first.

    Attributes
    ----------
    name : str
        Name of the scene.
    quantity : HeardQuantity
        The quantity whose level changes: the vibration of a ball, a band of a bearing.
    rows : list of Sensitivity
        The changes.
    left_out : list of LeftOut
        Values that could not be changed, with the reason.
    noun : str
        What the specimens are: surfaces, or places of the scan.
    within_db : float, dB
        The wanted ±.
    limit : str
        Why some ± are above the wanted one; empty if none is.
    folder : Path
        Folder of the specimens.
    omitted : list of OmittedPair
        Specimens that are left out of some changes, because a contact has no solution.
    scene : scene, optional
        The scene whose values are changed, which the page draws. Default: none.

    Examples
    --------
    >>> from pathlib import Path
    >>> import rolling
    >>> from rolling.choice.audition import SOUND
    >>> found = rolling.Sensitivities(
    ...     name="empty", quantity=SOUND, rows=[], left_out=[], noun="surfaces", within_db=0.1,
    ...     limit="", folder=Path(),
    ... )
    >>> found.sentences
    ['The scene has no value of a drawing that can be changed.']
    """

    name: str
    quantity: HeardQuantity
    rows: list[Sensitivity]
    left_out: list[LeftOut]
    noun: str
    within_db: float
    limit: str
    folder: Path
    omitted: Sequence[OmittedPair] = ()
    scene: Any = None

    def table(self) -> pd.DataFrame:
        """Tabulate the changes, the largest first.

        Returns
        -------
        table : pandas.DataFrame
            One row per value: key, value, changed_to, per (the step that the changes are for),
            vibration_db, or medium_db of a bearing, and released_power_db (changes of the levels
            when the value is larger, with their uncertainties), chain_db (the same by the linear
            chain), specimens, shares_march, and note. Values that could not be changed stand last,
            with the reason as their note.
        """
        import pandas as pd  # slow to import, for tables only

        rows: list[dict[str, Any]] = []
        name = self.quantity.name
        has_chain = any(row.chain_db is not None for row in self.rows)
        has_released = any(row.released_db is not None for row in self.rows)
        for row in self.rows:
            change = row.change
            columns: dict[str, Any] = {
                "key": change.key,
                "value": change.old,
                "changed_to": change.new,
                "per": f"+{change.step}",
                f"{name}_db": row.db,
                f"{name}_uncertainty_db": row.uncertainty_db,
            }
            if has_chain:
                columns["chain_db"] = row.chain_db
                columns["chain_uncertainty_db"] = row.chain_uncertainty_db
            if has_released:
                columns["released_power_db"] = row.released_db
                columns["released_power_uncertainty_db"] = row.difference.released_uncertainty_db
            columns["specimens"] = row.difference.pairs
            columns["shares_march"] = change.shares_march
            columns["note"] = _note(row)
            rows.append(columns)
        for left in self.left_out:
            rows.append({"key": left.key, "note": left.reason})
        return pd.DataFrame(rows)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the changes as bars, with their ± and the linear chain beside them."""
        from rolling.choice.advice_pictures import plot_sensitivities

        return plot_sensitivities(self, ax)

    @property
    def lines(self) -> list[str]:
        """One line per change, the largest first: the value, computed, by the linear chain."""
        names = [f"{row.change.name} +{row.change.step}" for row in self.rows]
        width = max(map(len, names), default=0)
        lines = []
        for name, row in zip(names, self.rows, strict=True):
            line = f"{name:{width}}  {in_words(row.db, row.uncertainty_db, self.quantity)}"
            if row.chain_db is not None:
                of_chain = in_words(row.chain_db, row.chain_uncertainty_db, self.quantity)
                line += f", linear chain {of_chain}"
            lines.append(line)
        return lines

    @property
    def found_by(self) -> list[str]:
        """Sentences on how the answer was found."""
        return [
            "Each value of the drawing was changed by its step, and both scenes met the same"
            f" {self.noun}. The ± is one standard uncertainty of the mean change by Student's t."
        ]

    @property
    def sentences(self) -> list[str]:
        """The answer in words: what would help most, and what to doubt."""
        return [*_sentences(self)]


def improve_scene(
    scene: Any,
    folder: Path | None = None,
    keys: Sequence[str] | None = None,
    budget: Budget = USUAL,
    workers: int = 0,
    quantity: str | None = None,
) -> Sensitivities:
    """Find how much louder a scene becomes when a value of its drawing is a little larger.

    Parameters
    ----------
    scene : scene. A scene without a sweep.
    folder : Path. Folder of the specimens. Default: outputs/improve-DIGITS.
    keys : sequence of str. Keys of the values. Default: all that stand on a drawing.
    budget : Budget. How long it goes on; the first six specimens are always heard.
    workers : int. Number of processes; 0: one per core.
    quantity : str. Name of the quantity whose level changes. Default: the leading one.

    Raises
    ------
    SceneError : the scene sweeps, cannot run, makes no sound, or has no value of a key, or there is
        no such quantity.
    FolderError : the folder holds something else.
    ContactError : the contact of the scene has no solution.
    OSError, KeyboardInterrupt : finished pieces are kept.
    """
    refuse_sweep(scene)
    audition = audition_of(scene)
    base = audition.unchanged(scene)
    asked = quantity_of(audition.quantities([base]), quantity)
    target = folder or default_folder("improve", [base.scene])
    changes, left_out = drawing.changes_of(audition, scene, base, workers, target)
    if keys is not None:
        changes, left_out = _chosen(scene, keys, changes, left_out)
    specimens = audition.specimens([base])
    looks = budget.looks(specimens.count, specimens.noun)  # refused before anything is written
    with open_choice([base], target, workers) as work:
        search = _SpecimenLoop(work, base, asked, budget, looks)
        rows = search.rows(changes)
    rows.sort(key=lambda row: -abs(row.db))
    return Sensitivities(
        name=scene.name,
        quantity=asked,
        rows=rows,
        left_out=[*left_out, *search.failed],
        noun=work.specimens.noun,
        within_db=budget.within_db,
        limit=search.limit,
        folder=target,
        omitted=[*search.omitted.values()],
        scene=base.scene,
    )


def quantity_of(quantities: Sequence[HeardQuantity], name: str | None) -> HeardQuantity:
    """Return the quantity of a name, the leading one without a name; refuse an unknown one."""
    if name is None:
        return leading_of(quantities)
    by_name = {quantity.name: quantity for quantity in quantities}
    if name not in by_name:
        raise SceneError(
            [f"quantity: got {quoted(name)}, allowed for this scene: {', '.join(by_name)}"]
        )
    return by_name[name]


def _chosen(
    scene: Any, keys: Sequence[str], changes: list[ChangedValue], left_out: list[LeftOut]
) -> tuple[list[ChangedValue], list[LeftOut]]:
    """Return the changes of some keys; refuse a key that is unknown or has no value."""
    known = [*(change.key for change in changes), *(left.key for left in left_out)]
    full = []
    for key in keys:
        name = key if key in known else full_key(key, type(scene))
        if name not in known:
            raise SceneError(
                [
                    f"{scene.place(name)}: {name}: has no value that stands on a drawing and can"
                    f" change, allowed: {', '.join(known)}"
                ]
            )
        full.append(name)
    return (
        [change for change in changes if change.key in full],
        [left for left in left_out if left.key in full],
    )


def refuse_sweep(scene: Any) -> None:
    """Refuse a scene with a sweep."""
    if scene.sweep:
        keys = ", ".join(scene.sweep)
        raise SceneError(
            [
                f"{scene.place('sweep')}: sweep: the scene sweeps {keys}, allowed: one scene"
                " without a sweep; --set of each swept key chooses one"
            ]
        )


class _SpecimenLoop:
    """Hears changed scenes on the specimens of a scene until their changes are known."""

    def __init__(
        self,
        work: OpenChoice,
        base: Candidate,
        quantity: HeardQuantity,
        budget: Budget,
        looks: Sequence[int],
    ) -> None:
        self._work = work
        self._base = base
        self._quantity = quantity
        self._budget = budget
        # The scatter of all pairs is that of the first six.
        self._looks = [count for count in looks if count >= FIRST_PAIRS] or looks[-1:]
        self._clock = Clock(budget)
        self.limit = ""
        self.failed: list[LeftOut] = []
        self.omitted: dict[int, OmittedPair] = {}  # by the number of the pair

    def rows(self, changes: list[ChangedValue]) -> list[Sensitivity]:
        """Return the changes of the level; those that fail are kept in `failed`."""
        rows = []
        for change in changes:
            row = self._row(change, self._looks[0])
            if row is not None:
                rows.append(row)
        for number, row in enumerate(rows):
            rows[number] = self._until_known(row)
        failed = [left.key for left in self.failed]
        return [row for row in rows if row.change.key not in failed]

    def _until_known(self, row: Sensitivity) -> Sensitivity:
        """Return a change over so many specimens that it is known, or that time or places end."""
        for count in self._looks[1:]:
            if self._needed(row) <= row.difference.pairs:
                return row
            if self._clock.is_over:
                self.limit = self._budget.of_time
                return row
            more = self._row(row.change, count)
            if more is None:
                return row
            row = more
        if self._needed(row) > row.difference.pairs:
            self.limit = self._budget.why_no_more(self._work.specimens.noun)
        return row

    def _row(self, change: ChangedValue, count: int) -> Sensitivity | None:
        """Return the change of the level over some specimens; None where its contacts fail."""
        ((base,), _) = self._work.hear([self._base], count)
        if not np.all(np.isfinite(base.levels_in(self._quantity.name))):
            raise SceneError([f"{change.candidate.scene.name}: makes no sound within hearing"])
        try:
            (base, changed), omitted = self._work.hear([self._base, change.candidate], count)
        except ContactError as error:
            self.failed.append(LeftOut(change.key, change.name, str(error)))
            return None
        for pair in omitted:
            self.omitted.setdefault(pair.number, pair)
        if not np.all(np.isfinite(changed.levels_in(self._quantity.name))):
            self.failed.append(LeftOut(change.key, change.name, "then nothing sounds"))
            return None
        row = self._sensitivity(change, base, changed, len(omitted))
        text = in_words(row.db, row.uncertainty_db, self._quantity)
        progress.line(f"{change.name}: {text} per +{change.step}")
        return row

    def _needed(self, row: Sensitivity) -> int:
        """Return the specimens after which the ± of a change is the wanted one."""
        difference = row.difference
        if difference.uncertainty_db is None or difference.uncertainty_db <= self._budget.within_db:
            return difference.pairs
        wanted_db = difference.wanted_scatter_db(self._budget.within_db)
        return pairs_needed(row.levels_apart_db, wanted_db, row.correlation)

    def _sensitivity(
        self, change: ChangedValue, base: Contender, changed: Contender, omitted: int
    ) -> Sensitivity:
        """Return the change of a level between two contenders on the same specimens.

        Some of their pairs are left out.
        """
        audition = self._work.audition
        name = self._quantity.name
        correlation = self._work.correlation(changed, base)
        chain_db = None
        chain_uncertainty_db = None
        of_base = audition.second_opinion(base.specimens)
        of_changed = audition.second_opinion(changed.specimens)
        if of_base is not None and of_changed is not None:
            of_pairs = paired_mean(of_changed - of_base, correlation)
            chain_db = of_pairs.mean if change.is_upwards else -of_pairs.mean
            if math.isfinite(of_pairs.error):
                chain_uncertainty_db = of_pairs.uncertainty
        return Sensitivity(
            change=change,
            difference=audition.difference(
                name, changed.heard, base.heard, omitted=omitted, correlation=correlation
            ),
            levels_apart_db=changed.levels_in(name) - base.levels_in(name),
            chain_db=chain_db,
            chain_uncertainty_db=chain_uncertainty_db,
            quantity=self._quantity,
            correlation=correlation,
        )


def write_sensitivities(result: Sensitivities) -> list[Path]:
    """Write table, answer, picture and page of the changes, and return the files."""
    from rolling.choice.advice_page import sensitivities_page
    from rolling.choice.advice_pictures import sensitivities_picture

    picture = sensitivities_picture if result.rows else None
    return write_advice(result, "improve", picture, sensitivities_page)


# ---- sentences


def _sentences(result: Sensitivities) -> Iterator[str]:
    """Yield the answer and its doubts."""
    sure = [row for row in result.rows if _is_sure(row)]
    # Who stands farther away hears less, but the drawing stays as it is.
    helpful = [row for row in sure if row.change.key != drawing.DISTANCE] or sure
    if helpful:
        best = helpful[0]
        amount = f"{_amount(best)} {result.quantity.decibels} quieter{_in_band(result)}"
        text = f"{capital(_help(best))} is {amount}, which helps most{_of_which(best, result)}"
        others = [
            f"a {drawing.helping_words(row.change, row.db)} ({_amount(row)})"
            for row in helpful[1 : 1 + NEXT]
        ]
        if others:
            text += f"; then come {' and '.join(others)}"
        yield f"{text} ({counted(best.difference, result.noun)})."
    elif result.rows:
        yield "No value of the drawing surely makes the sound quieter."
    else:
        yield "The scene has no value of a drawing that can be changed."
    for row in result.rows:
        if row.differs_from_chain:
            yield (
                f"The linear chain does not confirm the change by {row.change.name}:"
                f" {in_words(row.chain_db, row.chain_uncertainty_db, result.quantity)} in place of"
                f" {in_words(row.db, row.uncertainty_db, result.quantity)} per +{row.change.step}."
            )
    wide = [row for row in result.rows if (row.uncertainty_db or 0.0) > result.within_db]
    if wide:
        names = listed(dict.fromkeys(row.change.name for row in wide))
        text = f"The ± stays above {result.within_db:g} dB for {names}"
        if result.limit:
            text += f", because {result.limit}"
        yield f"{text}."
    downwards = [row.change.name for row in result.rows if not row.change.is_upwards]
    if downwards:
        yield (
            f"A larger value is not allowed for {' and '.join(downwards)}, so the change is that"
            " of a smaller one with the other sign."
        )
    for pair in result.omitted:
        yield (
            f"Number {pair.number} of the {result.noun} is left out, because a contact has no"
            f" solution ({printable(pair.label)}: {printable(pair.reason)}); it counts as one that"
            " speaks against a change."
        )
    left_out = left_out_text(row.difference for row in result.rows)
    if left_out:
        yield left_out
    for left in result.left_out:
        yield f"Left out: {left.name} ({printable(left.reason)})."


def _of_which(best: Sensitivity, result: Sensitivities) -> str:
    """Say of which changes one helps most, where others have larger numbers."""
    larger = [row for row in result.rows if abs(row.db) > abs(best.db)]
    text = ""
    if any(not _is_sure(row) for row in larger):
        text += " of the changes whose sign is sure"
    if any(row.change.key == drawing.DISTANCE for row in larger):
        text += ", apart from a greater distance"
    return text


def _is_sure(row: Sensitivity) -> bool:
    """Return whether the sign of a change is sure, and the change shows in two digits."""
    sureness = row.difference.sureness
    return sureness is not None and sureness >= SURE and abs(row.db) >= SHOWN_DB


def _help(row: Sensitivity) -> str:
    """Say what would make a scene quieter: a 10 % thicker plate."""
    return f"a {drawing.helping_words(row.change, row.db)}"


def _amount(row: Sensitivity) -> str:
    """Write the size of a change with its ±, without a sign."""
    return two_digits(abs(row.db), row.uncertainty_db)


def _in_band(result: Sensitivities) -> str:
    """Say in which band a level is, where it is that of a band."""
    return "" if result.quantity.is_level else f" from {result.quantity.words}"


def _note(row: Sensitivity) -> str:
    """Return what to know about a row of the table."""
    notes = []
    if not row.change.is_upwards:
        notes.append("a larger value is not allowed, so a smaller one was computed")
    if row.differs_from_chain:
        notes.append("the linear chain differs")
    return "; ".join(notes)
