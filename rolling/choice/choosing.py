"""Choose between scenes: hear pairs of specimens until the difference is known well enough."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from acoustics.arrays import Array
from acoustics.pairs import FEWEST_PAIRS, FIRST_PAIRS, LOOKS, independent_pairs, pairs_needed
from rolling.check import cost, forecast, refusals
from rolling.choice import choice_sentences
from rolling.choice.audition import Audition, audition_of
from rolling.choice.candidate import Candidate
from rolling.choice.choice import Choice
from rolling.choice.choice_numbers import Contender, OmittedPair, leading_of
from rolling.choice.heard_specimen import Specimen
from rolling.choice.linear_advice import linear_advice
from rolling.choice.omissions import refuse_many
from rolling.choice.specimen_solving import Solver
from rolling.kinds.registry import kind_of
from rolling.run import choice_folder
from rolling.run import folder as folders
from rolling.run.budget import Budget, Clock
from rolling.run.executor import ended_by_signal
from rolling.scene.identity import contact_keys, digest, scene_identity
from rolling.terminal import progress

GOES_ON = "it was interrupted"  # why a choice that is kept between batches has no more pairs
MORE = 1.1  # factor by which more places have to add independent ones, or none is marched
LONG_S = 60.0  # time of the first marches, from which on it is said
FORMAT = "rolling-contact-noise choice, format 4"
FORMATS = (  # with those of older versions
    FORMAT,
    "rolling-contact-noise choice, format 3",
    "rolling-contact-noise choice, format 2",
    "rolling-contact-noise choice, format 1",
    "rolling-contact-noise choice of bearings, format 2",
    "rolling-contact-noise choice of bearings, format 1",
)

USUAL = Budget()


def default_folder(name: str, scenes: Sequence[Any]) -> Path:
    """Return the folder of a choice that is given without --out."""
    return Path("outputs") / f"{name}-{digest([scene_identity(scene) for scene in scenes])[:8]}"


def choose_scenes(
    scenes: Sequence[Any],
    folder: Path | None = None,
    budget: Budget = USUAL,
    workers: int = 0,
    keep: Callable[[Choice], None] | None = None,
) -> Choice:
    """Choose between scenes; a folder keeps what is done.

    Parameters
    ----------
    scenes : sequence of scene. Scenes of one kind, or one with a sweep or with single faults.
    folder : Path. Folder of the choice. Default: outputs/choice-DIGITS.
    budget : Budget. How long it goes on.
    workers : int. Number of processes; 0: one per core.
    keep : function. It writes the present answer, after each batch of pairs. Default: none.

    Raises
    ------
    SceneError : the scenes are not comparable, cannot run, or so many pairs are not there.
    FolderError : the folder holds another choice.
    ContactError : a contact has no solution.
    OSError, KeyboardInterrupt : as `rolling.commands.run.run_scene`; finished pieces are kept.
    """
    audition = audition_of(scenes[0])
    candidates = audition.candidates(scenes)
    target = folder or default_folder("choice", [candidate.scene for candidate in candidates])
    specimens = audition.specimens(candidates)
    looks = budget.looks(specimens.count, specimens.noun)  # refused before anything is written
    with open_choice(candidates, target, workers) as work:
        choice = _until_known(work, candidates, budget, looks, keep)
        with progress.step("asking what would help the loudest"):
            advice = linear_advice(audition, choice.contenders[-1].candidate, workers, target)
        return replace(choice, audible=audition.audible(choice), advice=advice)


# ---- the work


class HeardPairs(NamedTuple):
    """What is heard of candidates on the pairs that all of them have, and the pairs left out."""

    contenders: list[Contender]
    omitted: list[OmittedPair]


class OpenChoice:
    """Specimens of candidates, solved in the folder of a choice as far as they are asked for.

    Attributes
    ----------
    audition : Audition
        How the scenes of the kind are compared.
    specimens : Specimens
        What varies from specimen to specimen.
    folder : Path
        Folder of the choice.
    """

    def __init__(self, candidates: Sequence[Candidate], folder: Path, solver: Solver) -> None:
        self.audition = audition_of(candidates[0].scene)
        self.specimens = self.audition.specimens(candidates)
        self.folder = folder
        self._leading = leading_of(self.audition.quantities(candidates)).name
        self._solver = solver
        self._known: dict[Path, Specimen] = {}

    def hear(self, candidates: Sequence[Candidate], count: int, are_all: bool = True) -> HeardPairs:
        """Return what is heard of the first pairs of specimens; solve what is missing.

        A specimen whose contact has no solution is left out, with its partners in all candidates.
        How many may be left out is judged where the pairs are all of a batch.

        Raises
        ------
        ContactError : so many pairs have no solution that the others do not stand for all.
        OSError, KeyboardInterrupt : finished pieces are kept.
        """
        omitted: dict[int, OmittedPair] = {}
        self._leave_out_failed(candidates, count, omitted, are_all)
        wanted = []
        names = []
        for number in range(count):
            if number in omitted:
                continue
            for candidate in candidates:
                wanted.append(self._specimen(candidate, number))
                names.append(f"{candidate.label}, specimen {number + 1}")
        self._solver.solve(wanted, names, stored=[*self._known.values()])
        self._leave_out_failed(candidates, count, omitted, are_all)
        contenders = []
        for candidate in candidates:
            numbers = [number for number in range(count) if number not in omitted]
            own = [self._specimen(candidate, number) for number in numbers]
            contenders.append(
                Contender(
                    candidate=candidate,
                    heard=[self.audition.read_heard(specimen) for specimen in own],
                    specimens=own,
                    leading=self._leading,
                )
            )
        return HeardPairs(contenders, [omitted[number] for number in sorted(omitted)])

    def correlation(self, first: Contender, second: Contender) -> Array | None:
        """Return the correlation of the differences of two contenders between their specimens.

        None where each specimen has a surface of its own.
        """
        numbers = [specimen.number for specimen in first.specimens]
        return self.specimens.correlation(first.candidate, second.candidate, numbers)

    def _leave_out_failed(
        self,
        candidates: Sequence[Candidate],
        count: int,
        omitted: dict[int, OmittedPair],
        are_all: bool,
    ) -> None:
        """Add the pairs to `omitted` that are known, or foreseen, to have no solution."""
        for number in range(count):
            if number in omitted:
                continue
            for candidate in candidates:
                specimen = self._specimen(candidate, number)
                reason = specimen.no_solution or self.audition.foresee(self.folder, specimen)
                if reason:
                    omitted[number] = OmittedPair(number + 1, candidate.label, reason)
                    break
        if are_all:
            refuse_many([*omitted.values()], count, self.specimens.noun)

    def _specimen(self, candidate: Candidate, number: int) -> Specimen:
        """Return a specimen of a candidate, which may not be solved yet."""
        above = self.folder / choice_folder.RUNS / candidate.folder_name
        place = above / f"{number + 1:02d}"
        if place not in self._known:
            self._known[place] = Specimen(
                values={},
                scene=self.specimens.scene(candidate, number),
                folder=place,
                candidate=candidate,
                number=number,
            )
        return self._known[place]


@contextmanager
def open_choice(
    candidates: Sequence[Candidate], folder: Path, workers: int = 0
) -> Iterator[OpenChoice]:
    """Open the folder of a choice, with a pool of processes.

    Raises
    ------
    SceneError : a candidate cannot run here.
    FolderError : the folder holds something else, or another command works on it.
    """
    scenes = [candidate.scene.runs()[0].scene for candidate in candidates]
    kind = kind_of(scenes[0])
    for scene in scenes:
        kind.refuse(scene, workers, folder)
    contacts = [march.scene for scene in scenes for march in kind.marches(scene)]
    if contacts:
        refusals.refuse_few_addresses(contacts)
    audition = audition_of(scenes[0])
    stored = choice_folder.take(folder, FORMATS)
    folder.mkdir(parents=True, exist_ok=True)
    with ExitStack() as stack:
        stack.enter_context(folders.locked(folder))
        if stored is None:
            choice_folder.begin(folder, FORMAT)
            _say_how_long(contacts, audition)
        solver = audition.open_solver(stack, contacts, folder, workers)
        stack.enter_context(ended_by_signal())
        yield OpenChoice(candidates, folder, solver)


def _say_how_long(contacts: Sequence[Any], audition: Audition) -> None:
    """Say how long the marches of the first specimens take, where somebody has to wait for them.

    Equal contacts are marched once.
    """
    marched = {digest(contact_keys(scene)): scene for scene in contacts}
    fewest = LOOKS[0] if audition.marches_each else 1
    seconds = fewest * sum(forecast.march_seconds(scene) for scene in marched.values())
    if seconds / cost.cores() > LONG_S:
        time_in_words = cost.computing(seconds)
        of_specimens = f" of the first {fewest} of each" if audition.marches_each else ""
        progress.line(f"the marches{of_specimens} take {time_in_words}")


def _until_known(
    work: OpenChoice,
    candidates: Sequence[Candidate],
    budget: Budget,
    looks: Sequence[int],
    keep: Callable[[Choice], None] | None,
) -> Choice:
    """Hear pairs until each difference is known well enough, or time or specimens end.

    The answer after each batch is said, and kept if wanted. That of the first two pairs ends
    nothing, so no number that is stated depends on it.
    """
    noun = work.specimens.noun
    clock = Clock(budget)

    def tell(choice: Choice) -> None:
        """Say the present answer, and keep it."""
        progress.line(f"{choice.pairs} {noun}: {choice_sentences.in_short(choice)}")
        if keep is not None:
            keep(replace(choice, limit=GOES_ON, is_early=True))

    if looks[0] > FEWEST_PAIRS and work.audition.marches_each:
        pairs = work.hear(candidates, FEWEST_PAIRS, are_all=False)
        if not pairs.omitted:
            tell(_choice(work, pairs, budget))
    for count in looks:
        choice = _choice(work, work.hear(candidates, count), budget)
        tell(choice)
        if pairs_needed_of(choice, work) <= choice.pairs:
            return choice
        if count < looks[-1] and not _more_would_help(work, choice, looks[-1]):
            return replace(choice, limit=f"there are no more independent {noun}")
        if clock.is_over and count < looks[-1]:
            return replace(choice, limit=budget.of_time, is_early=True)
    return replace(choice, limit=budget.why_no_more(noun))


def _choice(work: OpenChoice, pairs: HeardPairs, budget: Budget) -> Choice:
    """Return the present answer: the contenders in order, and how much louder each is."""
    ordered = sorted(pairs.contenders, key=lambda contender: contender.level_db)
    quietest = ordered[0]
    quantities = work.audition.quantities([contender.candidate for contender in ordered])
    by_quantity = []
    for other in ordered[1:]:
        of_one = {}
        for quantity in quantities:
            of_one[quantity.name] = work.audition.difference(
                quantity.name,
                other.heard,
                quietest.heard,
                omitted=len(pairs.omitted),
                correlation=work.correlation(other, quietest),
            )
        by_quantity.append(of_one)
    return Choice(
        contenders=ordered,
        by_quantity=by_quantity,
        audition=work.audition,
        noun=work.specimens.noun,
        limit="",
        within_db=budget.within_db,
        folder=work.folder,
        omitted=pairs.omitted,
    )


def _more_would_help(work: OpenChoice, choice: Choice, most: int) -> bool:
    """Tell whether more specimens, up to the most, add to the independent ones of a difference."""
    if choice.pairs < FIRST_PAIRS:
        return True
    quietest = choice.contenders[0]
    for other in choice.contenders[1:]:
        here = work.correlation(other, quietest)
        every = work.specimens.correlation(other.candidate, quietest.candidate, range(most))
        if here is None or every is None:
            return True
        if independent_pairs(every) >= MORE * independent_pairs(here):
            return True
    return False


def pairs_needed_of(choice: Choice, work: OpenChoice) -> int:
    """Return the number of pairs after which every ± of a choice is the wanted one."""
    if choice.pairs < FIRST_PAIRS:
        return FIRST_PAIRS
    needed = choice.pairs
    quietest = choice.contenders[0]
    for other, of_one in zip(choice.contenders[1:], choice.by_quantity, strict=True):
        correlation = work.correlation(other, quietest)
        for quantity, difference in of_one.items():
            if difference.db is None:
                continue
            wanted_db = difference.wanted_scatter_db(choice.within_db)
            values = other.levels_in(quantity) - quietest.levels_in(quantity)
            needed = max(needed, pairs_needed(values, wanted_db, correlation))
    return needed
