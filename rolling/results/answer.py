"""The answer of a run: two numbers of equal rank, and one sentence of what follows from runs.

The first number is the vibration: what a listener would hear. The second is the released power:
what would be heard if all elastic energy that asperities give back were sound, an upper bound.
`rolling.results.description` says in words what rolls on what, and what is special about a run.
"""

from __future__ import annotations

import math
import statistics
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal, NamedTuple

from acoustics.numbers import rounded
from acoustics.texts import printable
from rolling.results.description import listed, material_word, number_word, special
from rolling.results.labels import SEED, labels, worded
from rolling.results.run_errors import LINEAR
from rolling.results.run_folder import RunFolder, stored_summary
from rolling.scene.scene import Scene
from rolling.sound.radiators import HALF

DIFFERS = 2.0  # standard uncertainties of a difference of levels that is named
WHOLE_DB = 10.0  # a difference from which on tenths of a decibel say nothing
LEAST_DB = 0.05  # a smaller difference prints as 0.0 dB

How = Literal["computed", "estimated", "upper bound", "assumed", "none"]


class Answer(NamedTuple):
    """One of the two numbers of a run, with all that a reader needs to understand it.

    level_db : float or None, dB(A). None where there is no level; `reason` says why.
    uncertainty_db : float or None, dB. Standard uncertainty; None where it is unknown.
    how : str. `computed` (from the motion), `estimated` (by a linear chain), `upper bound` (a
        released power with q = 1), `assumed` (q or the gain of the scene), or `none`.
    quantity : str. LAeq, or LAE (re 1 s) of a single event.
    where : str. Where the level is heard.
    meaning : str. One sentence for the line below the number.
    reason : str. Why there is no level, or an empty text.
    contact_loss_db : float, dB. Change of the level by a loss factor of the contact where the scene
        states none. Half of it is in the uncertainty.
    solved_share : float. Share of the record, in time, that was solved; the rest of a long record
        of what ends follows the statistics of this part.
    """

    level_db: float | None
    uncertainty_db: float | None
    how: How
    quantity: Literal["LAeq", "LAE"]
    where: str
    meaning: str
    reason: str
    contact_loss_db: float = 0.0
    solved_share: float = 1.0

    @property
    def number(self) -> str:
        """The level with its uncertainty, such as `14.5 ± 0.6`; `-` where there is none."""
        if self.level_db is None:
            return "-"
        return uncertain(self.level_db, self.uncertainty_db)

    @property
    def text(self) -> str:
        """The level in words, such as `14.5 ± 0.6 dB(A), estimated`, or why there is none."""
        if self.level_db is None:
            return f"none, because {self.reason}"
        words = f"{self.number} dB(A)"
        if self.quantity == "LAE":
            words = f"LAE {words}"
        return f"{words}, {self.how}"


def uncertain(level: float, uncertainty: float | None) -> str:
    """Write a level with its standard uncertainty [dB], rounded up to a tenth.

    The uncertainty never prints as 0.0 dB, because no level is known exactly. A level that rounds
    to -0.0 is written as 0.0.
    """
    spread = "" if uncertainty is None else f" ± {math.ceil(uncertainty * 10) / 10:.1f}"
    return f"{round(level, 1) + 0.0:.1f}{spread}"


# ---- the record that plays


def heard_whole(summary: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the numbers of the long record of a fall or of a ball that comes to rest.

    What ends is heard as a whole, so the levels of its long record are read first. It is empty for
    a run that goes on, or without a long record.
    """
    long = summary.get("listening") or {}
    return long if long.get("ends") else {}


def leading(summary: Mapping[str, Any], key: str) -> float | None:
    """Return a level of the record that plays where that ends [dB], otherwise of the solved one."""
    level: float | None = heard_whole(summary).get(key, summary.get(key))
    return level


def of_solved_part(summaries: Iterable[Mapping[str, Any]]) -> str:
    """Say which part of the records whose levels lead is solved; empty where all of it is."""
    texts = dict.fromkeys(_of_solved_part(summary) for summary in summaries)
    known = [text for text in texts if text]
    if len(known) <= 1:
        return "".join(known)
    return (
        "Each level is that of the whole record that plays, which goes on at random with the"
        " statistics of its solved part."
    )


def _of_solved_part(summary: Mapping[str, Any]) -> str:
    """Say which part of the record whose level leads is solved; empty where all of it is."""
    long = heard_whole(summary)
    if not long or long["solved_share"] >= 1 or leading(summary, level_key(summary)) is None:
        return ""
    whole = "of the whole fall"
    if not summary.get("single_event"):
        whole = f"of the {rounded(long['seconds'], 3)} s that play"
    solved_s = long["solved_share"] * long["seconds"]
    return (
        f"The level is that {whole}: the first {rounded(solved_s, 2)} s are solved, and the rest"
        " goes on at random with their statistics."
    )


# ---- the two numbers


def vibration(summary: Mapping[str, Any]) -> Answer:
    """Return the vibration of a run: computed with dynamics, otherwise estimated where possible."""
    if summary["source"] == "vibration":
        return _heard_vibration(summary)
    if "vibration_laeq_db" in summary:
        level = level_beside(summary, "vibration_laeq_db")
        return _computed(summary, level, None)
    return _estimated(summary)


def _heard_vibration(summary: Mapping[str, Any]) -> Answer:
    """Return the vibration of a run whose sound files hold it."""
    level = leading(summary, level_key(summary))
    spread = summary["uncertainty_db"].get("laeq")
    return _computed(summary, level, spread)


def _computed(
    summary: Mapping[str, Any], level_db: float | None, uncertainty_db: float | None
) -> Answer:
    """Return a vibration that was computed with the motion of ball and plate."""
    where = "on the axis through the contact"
    if summary.get("listeners"):
        where = "at the listener of the scene"
    reason = ""
    if level_db is None:
        reason = "ball and plate do not vibrate within hearing"
        if summary.get("flight_share") == 1 and not summary.get("impacts"):
            reason = "the record ends before the ball hits the plate"
    return Answer(
        level_db=level_db,
        uncertainty_db=None if level_db is None else uncertainty_db,
        how="computed",
        quantity=_quantity(summary),
        where=where,
        meaning=(
            "What a listener would hear: the sound pressure of ball and plate as they vibrate, "
            f"{where}.{_event(summary)}"
        ),
        reason=reason,
        contact_loss_db=_contact_loss_db(summary),
        solved_share=_solved_share(summary),
    )


def _solved_share(summary: Mapping[str, Any]) -> float:
    """Return the share of the record, in time, that was solved."""
    return float(heard_whole(summary).get("solved_share", 1.0))


def _contact_loss_db(summary: Mapping[str, Any]) -> float:
    """Return the change of a vibration [dB] by a loss of the contact; 0 in runs that lack it."""
    return float(summary.get("contact_loss_db") or 0.0)


def _estimated(summary: Mapping[str, Any]) -> Answer:
    """Return the vibration that a linear chain estimates for a run without dynamics."""
    level_db = level_beside(summary, "vibration_estimate_laeq_db")
    where = "at the listener"
    if level_db is None:
        reason = "a contact that does not fluctuate within hearing moves neither ball nor plate"
        if "vibration_estimate_laeq_db" not in summary:
            reason = "the run holds no estimate of it"
        return Answer(
            level_db=None,
            uncertainty_db=None,
            how="none",
            quantity=_quantity(summary),
            where=where,
            meaning="What a listener would hear.",
            reason=reason,
        )
    meaning = (
        f"What a listener would hear, estimated by a linear chain for "
        f"{summary['vibration_estimate_bodies']}; with a section dynamics it is computed."
    )
    if loses_contact_in_estimate(summary):
        meaning += " It is too high, because the ball would lose contact."
    return Answer(
        level_db=level_db,
        uncertainty_db=summary.get("vibration_estimate_uncertainty_db"),
        how="estimated",
        quantity=_quantity(summary),
        where=where,
        meaning=meaning + _event(summary),
        reason="",
        contact_loss_db=_contact_loss_db(summary),
        solved_share=_solved_share(summary),
    )


def loses_contact_in_estimate(summary: Mapping[str, Any]) -> bool:
    """Tell whether a vibration is estimated for a ball that would lose contact."""
    ratio = summary.get("vibration_estimate_force_ratio", 0.0)
    return bool(ratio > LINEAR) and "vibration_laeq_db" not in summary


def released_power(summary: Mapping[str, Any]) -> Answer:
    """Return the released power of a run, where the vibration is heard or at `distance_m`."""
    if summary["source"] == "release":
        level_db = leading(summary, level_key(summary))
        spread = summary["uncertainty_db"].get("laeq")
    else:
        level_db = level_beside(summary, "release_laeq_db")
        spread = None
    how: How = "upper bound"
    meaning = (
        "Released power: all elastic energy that asperities give back counts as sound (q = 1). "
        "It is an upper bound, and not what one would hear."
    )
    q = 1.0 if summary["source"] == "vibration" else summary.get("q", 1.0)
    if q is None:
        how = "assumed"
        meaning = "Released power under the gain that the scene fixes."
    elif q != 1:
        how = "assumed"
        meaning = f"Released power of which the scene takes a share of q = {q:g} as sound."
    reason = ""
    long = heard_whole(summary)
    if "drop_mm" in summary:
        level_db = None
        reason = "the release is computed for a ball that rolls, and this one falls"
    elif level_db is None:
        reason = "the release does not fluctuate within hearing"
    elif long and summary["source"] == "vibration" and long["solved_share"] < 1:
        solved_s = rounded(long["solved_share"] * long["seconds"], 2)
        own_db = level_db - exposure_db(summary)
        level = f"{own_db:.1f} dB(A)"
        reason = f"it is known for the {solved_s} s that are solved, where its LAeq is {level}"
        level_db = None
    if level_db is None:
        how = "none"
        spread = None
    return Answer(
        level_db=level_db,
        uncertainty_db=spread,
        how=how,
        quantity=_quantity(summary),
        where="at the distance of the listener",
        meaning=meaning + _event(summary),
        reason=reason,
        solved_share=_solved_share(summary),
    )


def _quantity(summary: Mapping[str, Any]) -> Literal["LAeq", "LAE"]:
    """Return the quantity of the levels of a run."""
    return "LAE" if summary.get("single_event") else "LAeq"


def _event(summary: Mapping[str, Any]) -> str:
    """Explain the level of a single event; nothing for a steady sound."""
    if not summary.get("single_event"):
        return ""
    return " LAE is the level of one second that holds the whole sound."


def level_key(summary: Mapping[str, Any]) -> str:
    """Return the key of the level of a run that is read first: LAE of an event, or LAeq.

    LAeq of a knock depends on the length of the record, so knocks cannot be compared by it.
    """
    return "lae_db" if summary.get("single_event") else "laeq_db"


def exposure_db(summary: Mapping[str, Any]) -> float:
    """Return the level that leads over LAeq of the record [dB], which other levels share; or 0.

    The other levels of an event are shown as LAE too, and those of what ends for the whole record.
    """
    level_db = leading(summary, level_key(summary))
    is_other = bool(summary.get("single_event") or heard_whole(summary))
    if not is_other or level_db is None or summary["laeq_db"] is None:
        return 0.0
    own = summary.get("record_laeq_db", summary["laeq_db"])  # LAeq may be a mean over a comb
    return float(level_db - own)


def level_beside(summary: Mapping[str, Any], key: str) -> float | None:
    """Return another level of a run [dB], as LAE for an event; None if it is unknown."""
    level = summary.get(key)
    return None if level is None else float(level) + exposure_db(summary)


def listener_level(summary: Mapping[str, Any], listener: Mapping[str, Any]) -> float | None:
    """Return the level of a run at one of its listeners [dB], as LAE for an event."""
    level = listener["laeq_db"]
    return None if level is None else level + exposure_db(summary)


def above_vibration_db(summary: Mapping[str, Any]) -> float | None:
    """Return the level of a release over that of the vibration, or over its estimate [dB]."""
    difference = summary.get("release_over_vibration_db")
    if difference is not None:
        return float(difference)
    estimate = summary.get("vibration_estimate_laeq_db")
    laeq = summary.get("laeq_db")
    return None if estimate is None or laeq is None else float(laeq - estimate)


# ---- what follows


class _Level(NamedTuple):
    """A level or a difference of levels [dB], and its standard uncertainty.

    The uncertainty of a level is without the unknown loss of the contact, which changes the level
    by `contact_loss_db`.
    """

    decibels: float
    uncertainty_db: float
    contact_loss_db: float = 0.0

    @property
    def is_certain(self) -> bool:
        """Whether a difference exceeds its uncertainty."""
        size = abs(self.decibels)
        return size >= LEAST_DB and size > DIFFERS * self.uncertainty_db


def follows(runs: Sequence[RunFolder]) -> str:
    """Say in one sentence what follows from the two numbers of runs; empty without any level.

    A single run is described by what is special about it, or by the gap between its numbers. Runs
    that differ in one number are compared at its ends, others from the quietest to the loudest.
    Runs that differ in their seed are one side of the comparison, with the mean of their levels.
    "Louder" and "quieter" are said of the vibration only. Levels of records of which a part is
    solved say so.
    """
    solved = [run for run in runs if stored_summary(run) is not None]
    sentences = (_follows(solved), of_solved_part(map(_summary, solved)))
    return " ".join(filter(None, sentences))


def _follows(solved: Sequence[RunFolder]) -> str:
    """Say in one sentence what follows from the two numbers of solved runs."""
    if not solved:
        return ""
    if len(solved) == 1:
        return special(solved[0]) or gap([_summary(solved[0])])
    swept = {key for run in solved for key in run.values}
    if swept == {SEED}:
        return _scatter_of_seeds(solved)
    ends = _ends(_sides(solved))
    if ends is None:
        return gap([_summary(run) for run in solved])
    return _comparison(*ends)


def gap(summaries: Sequence[Mapping[str, Any]]) -> str:
    """Say how far the released power lies above the vibration; empty where one of them lacks."""
    known = [x for x in summaries if released_power(x).how == "upper bound"]
    apart = [above_vibration_db(summary) for summary in known]
    gaps = sorted(decibels for decibels in apart if decibels is not None)
    levels = sorted(x for x in (vibration(summary).level_db for summary in known) if x is not None)
    if not gaps or not levels:
        return ""
    hows = {vibration(summary).how for summary in known}
    name = "estimated vibration" if hows == {"estimated"} else "vibration"
    return f"Released power is {_range(gaps)} dB above the {name} ({_range(levels)} dB(A))."


def _range(values: Sequence[float]) -> str:
    """Write the lowest and the highest of sorted values in whole numbers."""
    ends = dict.fromkeys(f"{value:.0f}" for value in (values[0], values[-1]))
    return " to ".join(ends)


def _summary(run: RunFolder) -> dict[str, Any]:
    """Return the summary of a solved run."""
    return stored_summary(run) or {}


class _Side(NamedTuple):
    """One side of a comparison: runs that differ in their seed at most.

    runs : list of RunFolder. The runs.
    values : dict. Their swept values, but for the seed.
    words : str. Words that follow `the ball is louder`, such as `at 100 N`.
    """

    runs: list[RunFolder]
    values: dict[str, Any]
    words: str

    @property
    def summaries(self) -> list[dict[str, Any]]:
        """The summaries of the runs."""
        return [_summary(run) for run in self.runs]


def _sides(runs: Sequence[RunFolder]) -> list[_Side]:
    """Gather runs that differ in their seed at most, with the words for each side."""
    by_values: dict[tuple[Any, ...], list[RunFolder]] = {}
    for run in runs:
        values = {key: value for key, value in run.values.items() if key != SEED}
        by_values.setdefault((run.scene.name, *values.items()), []).append(run)
    firsts = [of_side[0] for of_side in by_values.values()]
    names = Counter(run.scene.name for run in firsts)
    sides = []
    for of_side, label in zip(by_values.values(), labels(firsts), strict=True):
        first = of_side[0]
        values = {key: value for key, value in first.values.items() if key != SEED}
        words = _words(values, label)
        if len(names) > 1:
            is_alone = names[first.scene.name] == 1 or not values
            words = f"in {first.scene.name}" + ("" if is_alone else f" {words}")
        sides.append(_Side(of_side, values, words))
    return sides


def _words(values: Mapping[str, Any], label: str) -> str:
    """Write what distinguishes a side: its only swept value, or its label."""
    if len(values) != 1:
        return f"with {label}"
    ((key, value),) = values.items()
    if key == "rolling.load_n":
        return f"at {value:g} N"
    if key == "rolling.speed_m_s" and not isinstance(value, str):
        return f"at {value:g} m/s"
    if key == "surface.finish":
        return f"on the {value} finish"
    if key == "plate.material":
        return f"on {material_word(str(value))}"
    if key == "surface.path":
        return f"on {printable(str(value))}"
    return f"with {worded(key, value)}"


def _ends(sides: Sequence[_Side]) -> tuple[_Side, _Side] | None:
    """Return the two sides that are compared, the first and the last; None where none compare."""
    if len({side.runs[0].scene.name for side in sides}) == 1:
        numbers = [_only_number(side) for side in sides]
        known = [number for number in numbers if number is not None]
        if len(known) == len(sides) > 1:
            return sides[numbers.index(min(known))], sides[numbers.index(max(known))]
    levels = [_mean(map(vibration, side.summaries)) for side in sides]
    if any(level is None for level in levels):
        levels = [_mean(map(released_power, side.summaries)) for side in sides]
    sounding = [
        (level.decibels, number) for number, level in enumerate(levels) if level is not None
    ]
    if len(sounding) < 2:
        return None
    return sides[min(sounding)[1]], sides[max(sounding)[1]]


def _only_number(side: _Side) -> float | None:
    """Return the only swept value of a side if it is a number."""
    if len(side.values) != 1:
        return None
    (value,) = side.values.values()
    return float(value) if isinstance(value, int | float) else None


def _comparison(first: _Side, last: _Side) -> str:
    """Compare two sides by vibration and released power."""
    heard = _heard_difference(first.summaries, last.summaries)
    released = _released_difference(first, last)
    opening = last.words[0].upper() + last.words[1:]
    if heard is None:
        if released is None:
            return _not_compared([*first.summaries, *last.summaries])
        sentence = f"{opening} the ball {_more_power(released)}"
        if released.is_certain:
            sentence += f" than {first.words}"
        if any(map(loses_contact_in_estimate, (*first.summaries, *last.summaries))):
            sentence += "; the vibrations are not compared, because the ball would lose contact"
        return f"{sentence}."
    hows = {vibration(summary).how for summary in (*first.summaries, *last.summaries)}
    sentence = f"{opening} the ball is {_louder(heard, first.words, 'estimated' in hows)}"
    if released is None:
        return f"{sentence}.{_means(first, last)}"
    is_opposite = released.is_certain and heard.decibels * released.decibels < 0
    is_one_sided = released.is_certain and not heard.is_certain
    joint = "although" if is_opposite or is_one_sided else "and"
    return f"{sentence}, {joint} it {_more_power(released)}.{_means(first, last)}"


def _not_compared(summaries: Sequence[Mapping[str, Any]]) -> str:
    """Say why runs are not compared, or how their two numbers compare."""
    if len({_quantity(summary) for summary in summaries}) > 1:
        return "A single event has an LAE and a lasting sound an LAeq, so they are not compared."
    return gap(summaries)


def _means(first: _Side, last: _Side) -> str:
    """Say that the levels of sides with several surfaces are means."""
    most = max(len(first.runs), len(last.runs))
    return f" Levels are means over {number_word(most)} surfaces." if most > 1 else ""


def _louder(heard: _Level, than: str, estimated: bool) -> str:
    """Write how much louder or quieter the ball is than in other words."""
    if not heard.is_certain:
        return f"as loud as {than} within the uncertainty"
    word = "louder" if heard.decibels > 0 else "quieter"
    size = _decibels(heard.decibels)
    if not estimated:
        return f"{size} {word} than {than}"
    spread = math.ceil(10 * heard.uncertainty_db) / 10
    return f"about {size} (± {spread:.1f} dB, estimated) {word} than {than}"


def _more_power(released: _Level) -> str:
    """Write how much more power the second of two runs releases."""
    if not released.is_certain:
        return "releases the same power"
    word = "more" if released.decibels > 0 else "less"
    return f"releases {_decibels(released.decibels)} {word} power"


def _decibels(difference: float) -> str:
    """Write the size of a difference with its unit."""
    size = abs(difference)
    return f"{size:.0f} dB" if size >= WHOLE_DB else f"{size:.1f} dB"


def _heard_difference(
    first: Sequence[Mapping[str, Any]], last: Sequence[Mapping[str, Any]]
) -> _Level | None:
    """Return the difference of the vibrations of two sides; None where they cannot be compared.

    The errors of two runs are taken as independent, which is on the safe side: the runs of a sweep
    meet the same heights, and the chain of an estimate errs in the same sense in both. Bodies and
    damping that an estimate assumes are those of both runs. A wrong one shifts both levels by
    nearly the same decibels, so it is in no uncertainty of the difference, which is why an
    estimated difference is called "about". Where the ball would lose contact, the chain is too loud
    by an unknown amount, and nothing is said.
    """
    if any(map(loses_contact_in_estimate, (*first, *last))):
        return None
    return _difference(map(vibration, first), map(vibration, last))


def _released_difference(first: _Side, last: _Side) -> _Level | None:
    """Return the difference of released powers; None where the levels say nothing of power."""
    scenes = [run.scene for run in (*first.runs, *last.runs)]
    if any(scene.sound.gain_pa_per_w_m2 is not None for scene in scenes):
        return None
    if len({_conversion(scene) for scene in scenes}) > 1:
        return None
    return _difference(map(released_power, first.summaries), map(released_power, last.summaries))


def _difference(first: Iterable[Answer], last: Iterable[Answer]) -> _Level | None:
    """Return the mean level of some answers less that of others; None where they do not compare."""
    before = [*first]
    after = [*last]
    low = _mean(before)
    high = _mean(after)
    if low is None or high is None or len({answer.quantity for answer in (*before, *after)}) > 1:
        return None
    # Both contacts have the same unknown loss: half the change of the difference is in doubt.
    loss_db = HALF * (high.contact_loss_db - low.contact_loss_db)
    return _Level(
        decibels=high.decibels - low.decibels,
        uncertainty_db=math.hypot(low.uncertainty_db, high.uncertainty_db, loss_db),
    )


def _mean(answers: Iterable[Answer]) -> _Level | None:
    """Return the mean level of answers; None if one of them has none.

    Its uncertainty joins the scatter between several surfaces with that of a single level, which
    the surfaces may have in common.
    """
    known = [*answers]
    levels = [answer.level_db for answer in known if answer.level_db is not None]
    if len(levels) < len(known):
        return None
    own = max(map(_without_contact_loss_db, known))
    scatter = 0.0
    if len(levels) > 1:
        scatter = statistics.stdev(levels) / math.sqrt(len(levels))
    return _Level(
        decibels=statistics.fmean(levels),
        uncertainty_db=math.hypot(own, scatter),
        contact_loss_db=statistics.fmean(answer.contact_loss_db for answer in known),
    )


def _without_contact_loss_db(answer: Answer) -> float:
    """Return the uncertainty of a level [dB] without the part of the contact's loss."""
    whole = answer.uncertainty_db or 0.0
    return math.sqrt(max(0.0, whole**2 - (HALF * answer.contact_loss_db) ** 2))


def _conversion(scene: Scene) -> tuple[float, ...]:
    """Return what turns a released power into a level: distances and the radiated share."""
    return scene.sound.distance_m, scene.vibration_distance_m, scene.sound.q


def _scatter_of_seeds(runs: Sequence[RunFolder]) -> str:
    """Say how far the numbers scatter between surfaces that differ in their seed alone."""
    texts = []
    heard = [vibration(_summary(run)).level_db for run in runs]
    released = [released_power(_summary(run)).level_db for run in runs]
    for name, levels in (("vibration", heard), ("released power", released)):
        known = sorted(level for level in levels if level is not None)
        if len(known) > 1:
            ends = f"{known[0]:.1f} and {known[-1]:.1f} dB(A)"
            texts.append(f"the {name} lies between {ends}")
    if not texts:
        return ""
    return f"On {number_word(len(runs))} surfaces of the same statistics {listed(texts)}."
