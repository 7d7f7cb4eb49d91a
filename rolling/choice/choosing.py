"""Choose between scenes: march pairs of specimens until the difference is known well enough."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from acoustics.pairs import FIRST_PAIRS, pairs_needed
from rolling.check import cost, forecast, refusals
from rolling.choice import words
from rolling.choice.candidates import Candidate, candidates_of
from rolling.choice.choice import Choice
from rolling.choice.comparison import Contender
from rolling.choice.difference import difference
from rolling.choice.heard import Specimen, read_heard
from rolling.choice.solving import solve
from rolling.choice.specimens import FEWEST, Specimens
from rolling.results.run_result import read_run
from rolling.run import folder as folders
from rolling.run.executor import ended_by_signal
from rolling.run.pools import Pool, local_pool
from rolling.scene.height_files import read_regular
from rolling.scene.identity import contact_keys, digest, scene_identity
from rolling.scene.scene import Scene
from rolling.sound.heard_in_room import (
    MOST_SPECIMENS,
    HeardDifference,
    HeardRecord,
    heard_difference,
)
from rolling.terminal import defaults, files, progress
from rolling.terminal.files import FolderError

BATCH = 6  # pairs between two looks at the clock
LONG_S = 60.0  # time of the first marches, from which on it is said
CHOICE = "choice.json"
FORMAT = "rolling-contact-noise choice, format 1"
MAX_CHOICE = 10_000_000  # bytes of its file


class Budget(NamedTuple):
    """How long a choice goes on.

    within_db : float, dB. The wanted ± of a difference.
    minutes : float. Time after which no more pairs begin; the first four are always heard.
    """

    within_db: float = defaults.WITHIN_DB
    minutes: float = defaults.CHOICE_MINUTES


USUAL = Budget()


def default_folder(name: str, scenes: Sequence[Scene]) -> Path:
    """Return the folder of a choice that is given without --out."""
    return Path("outputs") / f"{name}-{digest([scene_identity(one) for one in scenes])[:8]}"


def choose_scenes(
    scenes: Sequence[Scene],
    folder: Path | None = None,
    budget: Budget = USUAL,
    workers: int = 0,
) -> Choice:
    """Choose between scenes; a folder keeps what is done.

    Parameters
    ----------
    scenes : sequence of Scene. Scenes, or one with a sweep or with single faults.
    folder : Path. Folder of the choice. Default: outputs/choice-DIGITS.
    budget : Budget. How long it goes on.
    workers : int. Number of processes; 0: one per core.

    Raises
    ------
    SceneError : the scenes are not comparable, or cannot run.
    FolderError : the folder holds another choice.
    ContactError : a contact has no solution.
    OSError, KeyboardInterrupt : as `rolling.commands.run.run_scene`; finished pieces are kept.
    """
    candidates = candidates_of(scenes)
    target = folder or default_folder("choice", [one.scene for one in candidates])
    with open_choice(candidates, target, workers) as work:
        choice = _until_known(work, candidates, budget)
        with progress.step("listening to both in the noise of the room"):
            return replace(choice, audible=_audible(choice))


# ---- the work


class OpenChoice:
    """Specimens of candidates, solved in the folder of a choice as far as they are asked for.

    Attributes
    ----------
    specimens : Specimens
        What varies from specimen to specimen.
    folder : Path
        Folder of the choice.
    """

    def __init__(
        self, candidates: Sequence[Candidate], folder: Path, pool: Pool, bar: progress.Bar
    ) -> None:
        self.specimens = Specimens(candidates)
        self.folder = folder
        self._pool = pool
        self._bar = bar
        self._known: dict[Path, Specimen] = {}

    def hear(self, candidates: Sequence[Candidate], count: int) -> list[Contender]:
        """Return what is heard of the first specimens of candidates; solve what is missing."""
        wanted = []
        names = []
        for number in range(count):
            for one in candidates:
                wanted.append(self._specimen(one, number))
                names.append(f"{one.label}, specimen {number + 1}")
        solve(
            folder=self.folder,
            specimens=wanted,
            labels=names,
            stored=[*self._known.values()],
            pool=self._pool,
            bar=self._bar,
        )
        contenders = []
        for one in candidates:
            own = [self._specimen(one, number) for number in range(count)]
            heard = [read_heard(specimen) for specimen in own]
            contenders.append(Contender(candidate=one, heard=heard, specimens=own))
        return contenders

    def _specimen(self, candidate: Candidate, number: int) -> Specimen:
        """Return a specimen of a candidate, which may not be solved yet."""
        place = self.folder / candidate.folder_name / f"{number + 1:02d}"
        if place not in self._known:
            self._known[place] = Specimen(
                values={},
                scene=self.specimens.scene(candidate, number),
                folder=place,
                loss_factors=candidate.loss_factors,
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
    scenes = [one.scene.runs()[0].scene for one in candidates]
    for scene in scenes:
        refusals.refuse(scene, workers, folder)
    refusals.refuse_few_addresses(scenes)
    _refuse_foreign(folder)
    folder.mkdir(parents=True, exist_ok=True)
    with ExitStack() as stack:
        stack.enter_context(folders.locked(folder))
        if not (folder / CHOICE).is_file():
            files.write_json(folder / CHOICE, {"format": FORMAT, "program": folders.this_program()})
            _say_how_long(scenes)
        bar = stack.enter_context(progress.Bar(0.0, "marches"))
        pool = stack.enter_context(local_pool(workers, scenes * FEWEST))
        stack.enter_context(ended_by_signal())
        yield OpenChoice(candidates, folder, pool, bar)


def _say_how_long(scenes: Sequence[Scene]) -> None:
    """Say how long the marches of the first specimens take, where somebody has to wait for them.

    Candidates of equal contact are marched once.
    """
    marched = {digest(contact_keys(scene)): scene for scene in scenes}
    seconds = FEWEST * sum(forecast.march_seconds(scene) for scene in marched.values())
    if seconds / cost.cores() > LONG_S:
        time_in_words = cost.computing(seconds)
        progress.line(f"the marches of the first {FEWEST} of each take {time_in_words}")


def _refuse_foreign(folder: Path) -> None:
    """Raise FolderError for a folder that holds something else than a choice of this program."""
    if not folder.exists() and not folder.is_symlink():
        return
    if not folder.is_dir():
        raise FolderError(f"{folder}: not a folder")
    if not any(path.name != folders.LOCK for path in folder.iterdir()):
        return
    try:
        stored = json.loads(read_regular(folder / CHOICE, MAX_CHOICE))
        is_choice = stored["format"] == FORMAT
        maker = str(stored["program"])
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        is_choice = False
        maker = ""
    way_out = f"take another --out, such as {folders.free_name(folder)}"
    if not is_choice:
        raise FolderError(f"{folder}: holds no choice; {way_out}")
    if maker != folders.this_program():
        raise FolderError(
            f"{folder}: holds a choice of {maker}, and this is {folders.this_program()}; numbers"
            f" of two programs are not mixed, so {way_out}, or delete the folder"
        )


def _until_known(work: OpenChoice, candidates: Sequence[Candidate], budget: Budget) -> Choice:
    """Hear pairs until each difference is known well enough, or time or specimens end."""
    began = time.monotonic()
    count = min(FEWEST, work.specimens.count)
    while True:
        contenders = work.hear(candidates, count)
        choice = _choice(work, contenders, budget)
        progress.line(f"{count} {choice.noun}: {words.in_short(choice)}")
        needed = pairs_needed_of(choice)
        if needed <= count:
            return choice
        if count == work.specimens.count:
            return replace(choice, limit=f"there are no more {choice.noun}")
        if time.monotonic() - began > 60 * budget.minutes:
            return replace(choice, limit=f"the limit of {budget.minutes:g} min was reached")
        count = min(needed, count + BATCH, work.specimens.count)


def _choice(work: OpenChoice, contenders: Sequence[Contender], budget: Budget) -> Choice:
    """Return the present answer: the contenders in order, and how much louder each is."""
    ordered = sorted(contenders, key=lambda contender: contender.level_db)
    quietest = ordered[0]
    differences = []
    for other in ordered[1:]:
        differences.append(difference(other.heard, quietest.heard))
    return Choice(
        contenders=ordered,
        differences=differences,
        noun=work.specimens.noun,
        overlap=work.specimens.overlap,
        limit="",
        within_db=budget.within_db,
        folder=work.folder,
    )


def _audible(choice: Choice) -> tuple[HeardDifference, ...]:
    """Judge whether each candidate after the first is heard to differ from the quietest."""
    quietest, *others = choice.contenders
    records = _records(quietest)
    room_db = quietest.candidate.scene.sound.room_db
    judged = []
    for other in others:
        names = (other.label, quietest.label)
        judged.append(heard_difference(_records(other), records, room_db, names))
    return tuple(judged)


def _records(contender: Contender) -> list[HeardRecord]:
    """Return the sound of the first specimens of a candidate."""
    records = []
    for specimen in contender.specimens[:MOST_SPECIMENS]:
        sound = read_run(specimen, contender.label).sound
        records.append(HeardRecord(sound.pressure, sound.sample_rate, sound.closed))
    return records


def pairs_needed_of(choice: Choice) -> int:
    """Return the number of pairs after which every ± of a choice is the wanted one."""
    if choice.pairs < FIRST_PAIRS:
        return FIRST_PAIRS
    needed = choice.pairs
    quietest = choice.contenders[0]
    for other, apart in zip(choice.contenders[1:], choice.differences, strict=True):
        if apart.db is None:
            continue
        wanted_db = apart.wanted_scatter_db(choice.within_db)
        values = other.levels_db - quietest.levels_db
        needed = max(needed, pairs_needed(values, wanted_db))
    return needed
