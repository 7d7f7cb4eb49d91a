"""How scenes of a kind are compared: candidates, specimens, and what is heard of each.

A kind without an audition of its own is heard by the A-weighted sound of its runs, on specimens
with other seeds.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from acoustics import wav
from acoustics.arrays import Array
from acoustics.level import a_weighted
from acoustics.pairs import LOOKS, MOST_PAIRS
from acoustics.texts import printable
from rolling.choice.candidate import MAX_CANDIDATES, Candidate
from rolling.choice.difference import Difference, paired_difference
from rolling.choice.drawing import AS_IT_IS, LeftOut, WantedValue
from rolling.choice.heard_specimen import (
    Heard,
    HeardQuantity,
    Specimen,
    read_heard_file,
    write_heard_file,
)
from rolling.choice.specimen_solving import RunSolver, Solver
from rolling.contact.solver import ContactError
from rolling.kinds.heard_sound import HeardSound, PlainSound, played_sound
from rolling.kinds.registry import kind_of
from rolling.kinds.run_folder import LISTEN, RunFolder
from rolling.numbers.file_facts import Provenance
from rolling.results.labels import value_at, worded
from rolling.results.provenance import program_provenance
from rolling.run.pools import local_pool
from rolling.run.worker import finish_run
from rolling.scene.messages import SceneError, quoted
from rolling.terminal import progress

if TYPE_CHECKING:
    from rolling.choice.choice_numbers import ChoiceNumbers, Contender
    from rolling.choice.wave_bands import PlateWaves
    from rolling.numbers.doubt import Doubt

SOUND = HeardQuantity(name="sound", words="sound", column="sound_db", leads=True)


class FirstSound(NamedTuple):
    """Sound of the first specimen of a candidate, and what its numbers are in words."""

    sound: HeardSound
    text: str


class Specimens:
    """What varies from specimen to specimen of some candidates: the seeds of their surfaces.

    Attributes
    ----------
    count : int
        Number of specimens that there are.
    noun : str
        What the specimens are.
    """

    noun = "surfaces"

    def __init__(self, candidates: Sequence[Candidate]) -> None:
        """Find out what varies."""
        seeds = [seed for candidate in candidates for seed in self.seeds(candidate.scene).values()]
        self._first_seed = next(iter(seeds), 1)
        self.count = MOST_PAIRS if seeds else 1

    def seeds(self, scene: Any) -> dict[str, int]:
        """Return the seeds that a scene has, by their dotted keys."""
        return dict(_seeds(scene.to_dict(), ""))

    def scene(self, candidate: Candidate, number: int) -> Any:
        """Return the scene of a candidate on the specimen of a number, from 0 on.

        All surfaces of it have the same seed.
        """
        seed = self._first_seed + number
        changes = dict.fromkeys(self.seeds(candidate.scene), seed)
        return candidate.scene.with_(changes) if changes else candidate.scene

    def correlation(
        self, first: Candidate, second: Candidate, numbers: Sequence[int]
    ) -> Array | None:
        """Return the correlation of the differences of two candidates between specimens.

        None, the default, where each specimen has a surface of its own.

        Parameters
        ----------
        first, second : Candidate
            The candidates.
        numbers : sequence of int
            Numbers of the specimens, from 0 on.
        """
        return None

    def shortage_words(self, wanted: int) -> str:
        """Say what a scene has in place of a wanted number of specimens."""
        return "no random surface"


def _seeds(values: Mapping[str, Any], above: str) -> Iterable[tuple[str, int]]:
    """Yield the seeds in plain values with their dotted keys."""
    for name, value in values.items():
        if isinstance(value, Mapping):
            yield from _seeds(value, f"{above}{name}.")
        elif name == "seed" and value is not None:
            yield f"{above}{name}", int(value)


@dataclass(frozen=True, kw_only=True)
class HeardRun(Heard):
    """A-weighted root mean square of the sound of a run in its unit, as heard.json has it."""

    sound_rms: float

    def rms(self, quantity: str) -> float:
        """Return the root mean square of the sound."""
        return self.sound_rms


class Audition:
    """How scenes of a kind are compared.

    Attributes
    ----------
    marches_each : bool
        Whether each specimen needs marches of its own.
    same_keys : tuple of str
        Dotted keys that have the same value in all candidates.
    why_no_waves : str
        Why scenes of the kind have no plate whose waves could be lowered.
    advice : mapping of str
        What to do against each part of the ± of a difference, by its origin.
    """

    marches_each = True
    why_no_waves = "this scene has none"
    advice: Mapping[str, str] = MappingProxyType({})
    same_keys: tuple[str, ...] = ()

    # ---- candidates and specimens

    def candidates(self, scenes: Sequence[Any]) -> list[Candidate]:
        """Return the candidates of scenes: each run of a sweep is one.

        A single scene with faults is compared with the same scene without them.

        Raises
        ------
        SceneError : there is nothing to choose between, or the scenes are not comparable.
        """
        labelled_scenes: list[tuple[str, Any]] = []
        for scene in scenes:
            for values, run in scene.runs():
                swept = [worded(key, value) for key, value in values.items()]
                labelled_scenes.append((", ".join(swept) or scene.name, run))
        if len(labelled_scenes) > MAX_CANDIDATES:
            raise SceneError(
                [f"{len(labelled_scenes)} candidates, allowed: at most {MAX_CANDIDATES}"]
            )
        if len(labelled_scenes) == 1:
            labelled_scenes = self.with_and_without_faults(labelled_scenes[0][1])
        if len({label for label, _ in labelled_scenes}) < len(labelled_scenes):
            labelled_scenes = [
                (f"{number}: {label}", run)
                for number, (label, run) in enumerate(labelled_scenes, 1)
            ]
        self._refuse_other_values(labelled_scenes)
        return [Candidate(label=label, scene=scene) for label, scene in labelled_scenes]

    def with_and_without_faults(self, scene: Any) -> list[tuple[str, Any]]:
        """Return the only scene of a choice without its single faults, and with them.

        Raises
        ------
        SceneError : it has none.
        """
        raise nothing_to_choose(scene)

    def _refuse_other_values(self, labelled_scenes: Sequence[tuple[str, Any]]) -> None:
        """Refuse candidates in which a key differs that makes the comparison void."""
        mistakes = []
        first_label, first = labelled_scenes[0]
        for label, scene in labelled_scenes[1:]:
            for key in self.same_keys:
                mine = value_at(first, key)
                theirs = value_at(scene, key)
                if mine != theirs:
                    mistakes.append(
                        f"{scene.place(key)}: {key}: got {quoted(theirs)} for {label}, and"
                        f" {quoted(mine)} for {first_label}; a choice needs the same"
                    )
        if mistakes:
            raise SceneError(mistakes)

    def specimens(self, candidates: Sequence[Candidate]) -> Specimens:
        """Return what varies from specimen to specimen."""
        return Specimens(candidates)

    def foresee(self, folder: Path, specimen: Specimen) -> str:
        """Return why a specimen surely has no solution; empty if it may have one.

        What is foreseen is remembered in the folder of the choice.
        """
        return ""

    # ---- what is heard

    def quantities(self, candidates: Sequence[Candidate]) -> list[HeardQuantity]:
        """Return what candidates are compared by; one of them leads."""
        return [SOUND]

    def open_solver(
        self, stack: ExitStack, contacts: Sequence[Any], folder: Path, workers: int
    ) -> Solver:
        """Return what solves specimens, with processes that end with a stack.

        Parameters
        ----------
        stack : ExitStack. Its end is that of the work.
        contacts : sequence of Scene. The contacts that the candidates need.
        folder : Path. Folder of the choice.
        workers : int. Number of processes; 0: one per core.
        """
        bar = stack.enter_context(progress.Bar(0.0, "marches"))
        pool = stack.enter_context(local_pool(workers, list(contacts) * LOOKS[0]))
        return RunSolver(
            folder=folder,
            pool=pool,
            bar=bar,
            finish=finish_specimen,
            hear_stored=self.hear_stored,
        )

    def hear_stored(self, specimen: Specimen) -> None:
        """Write what is heard of a specimen whose run is done."""
        sound = _sound_of(self.open_run(specimen), specimen.candidate.label)
        first = sound.record if sound.record.ndim == 1 else sound.record[:, 0]
        weighted = a_weighted(first, wav.SAMPLE_RATE_HZ)
        rms = float(np.sqrt(np.mean(np.square(weighted))))
        write_heard_file(specimen, HeardRun(sound_rms=rms))

    def hear_marched(self, specimen: Specimen, marched: Sequence[Any]) -> None:
        """Write what is heard of a specimen whose run has just been written, with its marches."""
        self.hear_stored(specimen)

    def read_heard(self, specimen: Specimen) -> Heard:
        """Read what is heard of a specimen.

        Raises
        ------
        FolderError : the file is damaged, or was not written by this program.
        """
        return read_heard_file(specimen, HeardRun)

    def open_run(self, specimen: Specimen) -> Any:
        """Read the run of a specimen."""
        return kind_of(specimen.scene).read_run(specimen, specimen.candidate.label)

    def difference(
        self,
        quantity: str,
        first: Sequence[Any],
        second: Sequence[Any],
        omitted: int = 0,
        correlation: Array | None = None,
    ) -> Difference:
        """Return the difference of two candidates in a quantity, first less second.

        Parameters
        ----------
        quantity : str
            Name of the quantity.
        first, second : sequences of Heard
            What is heard of each specimen, in the same order.
        omitted : int
            Number of pairs that are left out, because a contact has no solution.
        correlation : (pairs, pairs) array, optional
            Correlation of the pairs on the places of a scan. Default: they are independent.
        """
        levels = np.array([of_specimen.level_db(quantity) for of_specimen in first])
        other_levels = np.array([of_specimen.level_db(quantity) for of_specimen in second])
        with np.errstate(invalid="ignore"):  # two silences have no difference
            differences_db = levels - other_levels
        return paired_difference(quantity, differences_db, {}, omitted, correlation)

    def audible(self, choice: ChoiceNumbers) -> tuple[Any, ...]:
        """Judge whether each candidate after the first is heard to differ from the quietest."""
        return ()

    def second_opinion(self, specimens: Sequence[Specimen]) -> Array | None:
        """Return the levels of specimens by another model, (specimens,) [dB]; None without one."""
        return None

    # ---- values of a drawing

    def unchanged(self, scene: Any) -> Candidate:
        """Return the candidate of a scene without a sweep, which no change of a value moves."""
        return self.with_shared_steps(self.with_free_steps(scene), [])

    def with_free_steps(self, scene: Any) -> Candidate:
        """Return the candidate of a scene without a sweep, whose steps may follow from a value."""
        return Candidate(label=AS_IT_IS, scene=scene)

    def with_shared_steps(self, base: Candidate, others: Sequence[Candidate]) -> Candidate:
        """Return a candidate with steps that suit it and others; other steps pass for a sound."""
        return base

    def drawing_values(self, scene: Any) -> Iterable[WantedValue | LeftOut]:
        """Yield the values of a drawing that a scene has, and those that cannot change."""
        return ()

    def with_value(self, base: Candidate, key: str, value: Any, label: str) -> Candidate:
        """Return a candidate with another value of one key.

        Raises
        ------
        SceneError : the value is not allowed.
        """
        return replace(base, label=label, scene=base.scene.with_({key: value}))

    def plate_waves(self, scene: Any) -> PlateWaves:
        """Return the waves of the plate of a scene, which `rolling design` lowers.

        Raises
        ------
        SceneError : the sound of the scene does not follow from waves of a plate.
        """
        raise SceneError(
            [
                f"{scene.name}: a design lowers the waves of a plate under a ball that rolls, and"
                f" {self.why_no_waves}; `rolling choose --improve` says what else would help"
            ]
        )

    def linear_change(self, base: Candidate, changed: Candidate) -> float | None:
        """Return how much louder [dB] a changed candidate is by its linear response, unmarched.

        None, the default, where a kind has none.
        """
        return None

    def linear_error(self, key: str, change_db: float) -> float | None:
        """Return the standard uncertainty [dB] of that change by a key.

        None, the default, where the linear response does not hold.
        """
        return None

    # ---- how a choice is shown

    def doubts(self, choice: ChoiceNumbers) -> Iterable[Doubt]:
        """Yield what this kind of scene has to say beside the doubts of all choices."""
        return ()

    def facts(self, contender: Contender) -> dict[str, Any]:
        """Return what choice.json says of a candidate beside its levels."""
        return {}

    def provenance(self, scene: Any, label: str) -> Provenance:
        """Return which program made the numbers of a choice, and from what."""
        seed = next(iter(Specimens([]).seeds(scene).values()), None)
        return replace(program_provenance(label), seed=seed)

    def first_sound(self, choice: ChoiceNumbers, contender: Contender) -> FirstSound:
        """Return the sound of the first specimen of a candidate, and its numbers in words."""
        sound = _sound_of(self.open_run(contender.specimens[0]), contender.label)
        level_db = contender.heard[0].level_db(SOUND.name)
        text = "no sound within hearing"
        if math.isfinite(level_db):
            text = f"Sound of this specimen: {level_db:.1f} dB(A)."
        return FirstSound(sound, text)


def _sound_of(run: Any, label: str) -> PlainSound:
    """Return the sound of a run that is played first, with the label of its candidate.

    Raises
    ------
    ContactError : the run has no sound.
    """
    sound = played_sound(kind_of(run.scene).sounds(run))
    if sound is None:
        raise ContactError(f"{label}: its runs have no sound, by which they would be compared")
    return PlainSound(
        file=LISTEN,
        unit=sound.unit,
        group="sound",
        record=sound.samples,
        heard=sound.words,
        title=printable(label),
    )


def nothing_to_choose(scene: Any) -> SceneError:
    """Return the error of a single scene without faults."""
    return SceneError(
        [
            f"{scene.name}: a single scene leaves nothing to choose between; give two scenes,"
            " a scene with a sweep or one with faults, or ask for --improve or --below"
        ]
    )


def audition_of(scene: Any) -> Audition:
    """Return how scenes of the kind of a scene are compared."""
    own = kind_of(scene).audition()
    return Audition() if own is None else own


def finish_specimen(run: RunFolder, label: str, marched: Sequence[Any]) -> None:
    """Write the files of a specimen as those of any run, and then what is heard of it."""
    assert isinstance(run, Specimen)
    finish_run(run, label, marched)
    audition_of(run.scene).hear_marched(run, marched)
