"""What a reader of a run's numbers must know: the one source for terminal, page and files. Depends on scenario and sound."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rolling.check import resolution
from rolling.check.finding import Finding
from rolling.scene.scene import Scene
from rolling.sound import ContactSound

SHORT_S = 0.3  # a record or a track that repeats sooner is heard as a tone
HEADLINE = ("upper_bound", "assumed_q", "fixed_gain", "unvalidated", "uncertainty")  # belong beside every level
REPEATS = ("short_loop", "short_track")  # belong beside every player
STANDING = (*HEADLINE, *REPEATS, "partial", "not_loopable", "quasi_static")  # all others are warnings of the check


@dataclass(frozen=True)
class Caveat:
    """A limit of a run's numbers.

    key : name for programs, which never changes with the wording.
    text : the caveat in plain sentences.
    """

    key: str
    text: str


@dataclass(frozen=True)
class Remark:
    """A caveat of several runs, said once.

    labels : the runs that it concerns; none: all.
    """

    key: str
    text: str
    labels: tuple[str, ...] = ()

    @property
    def line(self) -> str:
        """The text with the runs that it concerns."""
        return self.text + (f" ({'; '.join(self.labels)})" if self.labels else "")


def caveats(scene: Scene, sound: ContactSound, findings: Iterable[Finding], complete: bool) -> list[Caveat]:
    """List the caveats of a run: the standing ones that apply to it, then the warnings of its check and of its solver.

    Parameters
    ----------
    findings : Findings of the scene.
    complete : All steps are solved.
    """
    found = [*_of_levels(scene, sound), *_of_record(scene, sound)]
    if not complete:
        found.append(Caveat("partial", "Not all steps are solved: numbers and sound cover the solved beginning only."))
    found.append(
        Caveat("quasi_static", "The load is held constant: the sphere neither bounces nor rings on its contact.")
    )
    found += [Caveat(each.key, f"{each.quantity}: {each.warning}") for each in findings if each.warning]
    hidden = resolution.doubt(scene, sound.audible_rms, sound.resolved_rms)
    return [*found, Caveat("solver", f"solver: {hidden}")] if hidden else found


def loops(sound: ContactSound) -> bool:
    """Tell whether the record can be played round and round without a click."""
    return sound.loops


def stored(numbers: Mapping[str, Any]) -> list[Caveat]:
    """Read the caveats out of the numbers of summary.json."""
    return [Caveat(**each) for each in numbers["caveats"]]


def gathered(runs: Sequence[tuple[str, Sequence[Caveat]]]) -> list[Remark]:
    """Say each kind of caveat once, in the words of the first run that it concerns.

    Parameters
    ----------
    runs : Label and caveats of each run.
    """
    by_key: dict[str, dict[str, str]] = {}
    for label, each in runs:
        for caveat in each:
            by_key.setdefault(caveat.key, {})[label] = caveat.text
    found = []
    for key, texts in by_key.items():
        first, text = next(iter(texts.items()))
        if len(set(texts.values())) > 1:
            text += f" (in the numbers of {first})"
        found.append(Remark(key, text, () if len(texts) == len(runs) else tuple(texts)))
    return found


def _of_levels(scene: Scene, sound: ContactSound) -> list[Caveat]:
    """List what belongs beside the levels, if there are any."""
    if sound.steady_level is None and sound.levels.level_db is None:
        return []
    found, s = [], scene.sound
    fixed = s.gain_pa_per_w_m2 is not None
    if s.q == 1:
        levels = "The steady level is" if fixed or sound.levels.level_db is None else "Levels are"
        text = f"{levels} an upper bound: all released energy counts as radiated (q = 1)."
        found.append(Caveat("upper_bound", text))
    else:
        found.append(Caveat("assumed_q", f"The scene assumes that {s.q:g} of the released energy is radiated (q)."))
    if fixed:
        text = f"The scene's gain of {s.gain_pa_per_w_m2:g} Pa per W/m² decides every level but the steady one."
        found.append(Caveat("fixed_gain", text))
    found.append(Caveat("unvalidated", "No level has been validated against a microphone."))
    if sound.uncertainty.level_db is not None or sound.steady_uncertainty is not None:
        text = (
            "± covers the record's length alone, taken as stationary Gaussian noise; it holds no error of model, grid or"
            " solver."
        )
        found.append(Caveat("uncertainty", text))
    return found


def _of_record(scene: Scene, sound: ContactSound) -> list[Caveat]:
    """List what belongs beside the player: a record that does not loop, or is heard as the tone of its repetition."""
    found = []
    if not loops(sound):
        text = "The record does not close on itself: it is faded at both ends, and a loop of it has gaps."
        if sound.closed:
            text = "The ends of the record do not fit together: a loop of it clicks."
        found.append(Caveat("not_loopable", text))
    if sound.levels.level_db is None:
        return found
    lap = _lap_seconds(scene, sound)
    heard = f"{_times(lap)} a second: the pitch that is heard is the repetition, not the contact."
    if loops(sound) and sound.duration < SHORT_S:
        found.append(Caveat("short_loop", f"When it loops, the record of {sound.duration:.3g} s repeats {heard}"))
    elif lap < min(SHORT_S, 0.999 * sound.duration):
        found.append(Caveat("short_track", f"The track repeats in the record every {lap:.3g} s, {heard}"))
    return found


def _lap_seconds(scene: Scene, sound: ContactSound) -> float:
    """Measure the time after which a record repeats itself, on average where the speed changes [s]."""
    way = scene.track
    lap = way.lap_steps * way.step
    rolled = float(scene.motion.distance(sound.duration))
    return sound.duration * min(1.0, lap / rolled)


def _times(period: float) -> str:
    rate = 1.0 / period
    return f"{rate:.2g} times" if rate < 10 else f"{rate:.0f} times"
