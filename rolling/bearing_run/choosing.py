"""Choose between bearings: move the rings of pairs of specimens until the differences are known.

Specimens of a bearing have the same statistics and other random heights, forms and places of
balls. What a march says of the contact holds for all of them, so a specimen costs a motion. All
bearings are heard on the same draws, so that what they share cancels.
"""

from __future__ import annotations

import json
import math
from collections import deque
from collections.abc import Sequence
from concurrent.futures import BrokenExecutor, Future
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from acoustics.arrays import Array
from acoustics.level import a_weighted
from acoustics.pairs import FIRST_PAIRS, MOST_PAIRS, pairs_needed
from acoustics.ring_velocity import VELOCITY_BANDS_HZ, velocity_bands
from rolling.bearing.linear_ring import linear_ring
from rolling.bearing_contacts.band_gain import RoughBand, rough_bands
from rolling.bearing_contacts.joined_tracks import bearing_tracks
from rolling.bearing_contacts.plan import ContactPlan, contact_plan
from rolling.bearing_contacts.solving import Marches, march_contacts
from rolling.bearing_run import simulation
from rolling.bearing_run.band_difference import NAMES
from rolling.bearing_run.bearing_choice import BearingChoice
from rolling.bearing_run.heard_specimen import HeardSpecimen, StoredSpecimens
from rolling.bearing_run.housing import housing_of_scene
from rolling.bearing_run.moved_ring import moved_ring
from rolling.figures.picture import csv_bytes
from rolling.numbers.stored import from_bytes, to_bytes
from rolling.run import choice_folder
from rolling.run import folder as folders
from rolling.run.budget import Budget, Clock
from rolling.run.choice_folder import CHOICE, PICTURE, RUNS, TABLE
from rolling.run.executor import ended_by_signal
from rolling.run.pools import Pool, Task, pool_for_tasks
from rolling.scene.bearing_scene import BearingScene
from rolling.scene.identity import digest
from rolling.scene.messages import SceneError, quoted
from rolling.terminal import files, progress, shortage
from rolling.terminal.files import FolderError, read_regular
from rolling.terminal.streams import folded

ROUNDING_UM_S = 1e-7  # velocity of a ring at rest, of numbers that are rounded
MAX_BEARINGS = 12
UM_S = 1e6  # micrometres per second in a metre per second
FORMAT = "rolling-contact-noise choice of bearings, format 2"
FORMATS = (FORMAT, "rolling-contact-noise choice of bearings, format 1")  # with the older one
NOUN = "specimens"
USUAL = Budget()
SAME_KEYS = ("bearing.turning", "sound.distance_m")  # in all bearings of a choice


@dataclass(eq=False)
class BearingCandidate:
    """One of the bearings among which a person chooses, and what was heard of it.

    label : str. What it is called in sentences.
    scene : BearingScene. A scene without a sweep.
    plan : ContactPlan. Its rough contacts.
    heard : list of HeardSpecimen. Root mean squares of each specimen so far.
    rough_bands : dict of RoughBand. What its rough contacts make of each band.
    """

    label: str
    scene: BearingScene
    plan: ContactPlan
    heard: list[HeardSpecimen] = field(default_factory=list)
    rough_bands: dict[str, RoughBand] = field(default_factory=dict)

    @property
    def is_random(self) -> bool:
        """Whether specimens of this bearing differ."""
        return not self.scene.is_smooth


def choose_bearings(
    scenes: Sequence[BearingScene],
    folder: Path | None = None,
    budget: Budget = USUAL,
    workers: int = 0,
) -> BearingChoice:
    """Choose between bearings by the three bands of their rings, and by the sound of a housing.

    Parameters
    ----------
    scenes : sequence of BearingScene
        Scenes, or one with a sweep or with single faults.
    folder : Path
        Folder that keeps marches and specimens. Default: outputs/choice-DIGITS.
    budget : Budget
        How long it goes on.
    workers : int
        Number of processes that march and move rings; 0: one per core.

    Returns
    -------
    BearingChoice

    Raises
    ------
    SceneError
        There is nothing to choose between, the bearings are not comparable, so many specimens are
        not there, or one of the bearings does not fit into memory or on the disk.
    FolderError
        The folder holds something else.
    ContactError
        A contact has no solution.
    OSError, KeyboardInterrupt
        As `rolling.commands.run.run_scene`; what was heard is kept.
    """
    candidates = candidates_of(scenes)
    looks = _looks(candidates, budget)
    target = folder or default_folder(candidates)
    for candidate in candidates:
        simulation.refuse(candidate.scene, workers, target, [candidate.scene])
    target.mkdir(parents=True, exist_ok=True)
    with folders.locked(target), ExitStack() as stack:
        _take_heard(target, candidates)
        _keep_heard(target, candidates)  # so that marches belong to a choice
        marches = _marched(candidates, target, workers)
        with progress.step("judging the gains of the contacts"):
            for one in candidates:
                one.rough_bands = rough_bands(one.scene.model, one.plan, marches)
        hearing = _Hearing(candidates, marches, target, workers, stack)
        choice = _until_known(hearing, budget, looks)
        _write_files(choice, candidates)
    return choice


def default_folder(candidates: Sequence[BearingCandidate]) -> Path:
    """Return the folder of a choice that is given without --out."""
    return Path("outputs") / f"choice-{_identity(candidates)[:8]}"


def print_choice(choice: BearingChoice) -> None:
    """Print the answer of a choice, its table and its files; the folder if quiet."""
    if progress.is_quiet():
        print(choice.folder)
        return
    for sentence in choice.sentences:
        print(folded(sentence))
    print()
    print(choice.lines)
    print()
    print(f"picture: {choice.folder / PICTURE}")
    print(f"table: {choice.folder / TABLE}")
    if choice.command:
        print(f"the same answer again: {choice.command}")


# ---- candidates


def candidates_of(scenes: Sequence[BearingScene]) -> list[BearingCandidate]:
    """Return the bearings to choose between: each run of a sweep is one.

    A single bearing with faults is compared with itself without them.

    Raises
    ------
    SceneError
        There is nothing to choose between, or the bearings are not comparable.
    """
    found: list[tuple[str, BearingScene]] = []
    for scene in scenes:
        for values, run in scene.runs():
            swept = ", ".join(f"{key.rpartition('.')[2]} {value}" for key, value in values.items())
            found.append((swept or scene.name, run))
    if len(found) > MAX_BEARINGS:
        raise SceneError([f"{len(found)} bearings, allowed: at most {MAX_BEARINGS}"])
    if len(found) == 1:
        found = _with_and_without_faults(found[0][1])
    if len({label for label, _ in found}) < len(found):
        found = [(f"{number}: {label}", run) for number, (label, run) in enumerate(found, start=1)]
    faults = []
    first = found[0][1]
    for label, scene in found[1:]:
        for key in SAME_KEYS:
            mine = _value_at(first, key)
            theirs = _value_at(scene, key)
            if mine != theirs:
                faults.append(
                    f"{scene.place(key)}: {key}: got {quoted(theirs)} for {label}, and"
                    f" {quoted(mine)} for {found[0][0]}; a choice needs the same"
                )
    if faults:
        raise SceneError(faults)
    return [
        BearingCandidate(label=label, scene=scene, plan=contact_plan(scene))
        for label, scene in found
    ]


def _with_and_without_faults(scene: BearingScene) -> list[tuple[str, BearingScene]]:
    """Return a bearing without its single faults, and with them."""
    changes: dict[str, Any] = {}
    for body in ("balls", "inner", "outer"):
        surface = getattr(scene.bearing.surfaces, body)
        if surface is not None and surface.faults:
            changes[f"bearing.surfaces.{body}.faults"] = None
    if not changes:
        raise SceneError(
            [
                f"{scene.name}: a single bearing leaves nothing to choose between; give two scenes,"
                " a scene with a sweep or one with faults"
            ]
        )
    without = scene.with_(changes)
    return [("the bearing without faults", without), ("the bearing with faults", scene)]


def _value_at(scene: BearingScene, key: str) -> Any:
    """Return the value of a scene at a dotted key."""
    section, _, name = key.partition(".")
    return getattr(getattr(scene, section), name)


# ---- what is heard


def _marched(candidates: Sequence[BearingCandidate], folder: Path, workers: int) -> Marches:
    """March the rough contacts of all bearings; equal ones are marched once."""
    contacts = [contact for one in candidates for stage in one.plan.stages for contact in stage]
    home = folder / RUNS
    files.make_below(folder, home)
    return march_contacts(contacts, name="marching contacts", folder=home, workers=workers)


@dataclass
class _Hearing:
    """Bearings of a choice, and what is needed to hear their specimens.

    workers : int. Number of processes that move rings; 0: one per core.
    stack : ExitStack. It ends the processes.
    pool : Pool. The processes, once there is something to move.
    """

    candidates: Sequence[BearingCandidate]
    marches: Marches
    folder: Path
    workers: int
    stack: ExitStack
    pool: Pool | None = None

    def hear(self, count: int) -> None:
        """Hear the first specimens of each bearing as far as they lack, and keep each one.

        Raises
        ------
        OSError, KeyboardInterrupt
            A disk is full, or the work was stopped; what was heard is kept.
        """
        step = progress.step(f"moving the rings of {count} specimens")
        with step, shortage.as_memory_error(), ended_by_signal():
            try:
                self._hear_lacking(count)
            except BrokenExecutor:  # a process was killed; the rest is done in this one
                self.pool = self.stack.enter_context(Pool())
                self._hear_lacking(count)

    def _lacking(self, count: int) -> list[tuple[BearingCandidate, int]]:
        """Return bearings and numbers of the first specimens that are not heard yet."""
        lacking = []
        for number in range(count):
            lacking += [(one, number) for one in self.candidates if number >= len(one.heard)]
        return lacking

    def _hear_lacking(self, count: int) -> None:
        """Hear the first specimens of each bearing, as far as they lack."""
        lacking = self._lacking(count)
        if not lacking:
            return
        if self.pool is None:
            self.pool = self.stack.enter_context(pool_for_tasks(self.workers, len(lacking)))
        at_once = self.pool.slots * sum(self.pool.teams.values())
        in_hand: deque[tuple[BearingCandidate, Future[Any]]] = deque()
        for one, number in lacking:
            key = (one.label, str(number))
            motion = Task(key, heard_specimen, (one.scene, one.plan, self.marches, number))
            in_hand.append((one, self.pool.submit(motion)))
            if len(in_hand) >= at_once:
                self._keep(*in_hand.popleft())
        while in_hand:
            self._keep(*in_hand.popleft())

    def _keep(self, one: BearingCandidate, heard: Future[Any]) -> None:
        """Wait for a specimen of a bearing, and write it down."""
        one.heard.append(heard.result())
        _keep_heard(self.folder, self.candidates)


def _looks(candidates: Sequence[BearingCandidate], budget: Budget) -> list[int]:
    """Return the numbers of specimens after which the ± is looked at; refuse a wrong --pairs."""
    most = MOST_PAIRS if any(one.is_random for one in candidates) else 1
    return budget.looks(most, NOUN)


def _until_known(hearing: _Hearing, budget: Budget, looks: Sequence[int]) -> BearingChoice:
    """Hear specimens until each ± is the wanted one, or the time or the specimens end."""
    candidates = hearing.candidates
    folder = hearing.folder
    clock = Clock(budget)
    for count in looks:
        hearing.hear(count)
        choice = _choice(candidates, count, budget, folder)
        progress.line(f"{count} {NOUN}: {choice.in_short}")
        if specimens_needed(choice) <= count:
            return choice
        if clock.is_over and count < looks[-1]:
            return replace(choice, limit=budget.of_time, is_early=True)
    return replace(choice, limit=budget.why_no_more(NOUN))


def heard_specimen(
    scene: BearingScene, plan: ContactPlan, marches: Marches, number: int
) -> HeardSpecimen:
    """Return the root mean squares of a specimen: radial velocity [um/s] and housing [Pa]."""
    model = scene.model
    # The marched one, 0, is left out: its stretch has fewer waves than a turn, so it scatters more.
    tracks = bearing_tracks(plan, marches, draw=number + 1)
    motion = moved_ring(model, tracks, scene.duration)
    x = velocity_bands(motion.velocity_m_s[:, 0], motion.rate_hz)
    y = velocity_bands(motion.velocity_m_s[:, 1], motion.rate_hz)
    rms = {}
    for name in VELOCITY_BANDS_HZ:
        velocity = UM_S * math.sqrt((x.rms_m_s[name] ** 2 + y.rms_m_s[name] ** 2) / 2)
        rms[name] = velocity if velocity > ROUNDING_UM_S else 0.0
    sound = housing_of_scene(scene, linear_ring(model), motion.velocity_m_s[:, 0])
    housing = None
    if sound is not None:
        weighted = a_weighted(sound.pressure, motion.rate_hz)
        housing = float(np.sqrt(np.mean(np.square(weighted)))) if any(rms.values()) else 0.0
    return HeardSpecimen(**rms, housing=housing)


def _choice(
    candidates: Sequence[BearingCandidate],
    count: int,
    budget: Budget,
    folder: Path,
) -> BearingChoice:
    """Return the answer from the first specimens of all bearings."""
    bands = [band for band in NAMES if all(band in one.heard[0].by_band for one in candidates)]
    rms = {band: _of_band(candidates, band, count) for band in bands}
    return BearingChoice(
        labels=[one.label for one in candidates],
        rms=rms,
        limit="",
        within_db=budget.within_db,
        folder=folder,
        gain_levels={
            band: [
                one.rough_bands[band].levels_db(float(np.mean(np.square(of_one / UM_S))))
                for one, of_one in zip(candidates, rms[band], strict=True)
            ]
            for band in VELOCITY_BANDS_HZ
        },
    )


def _of_band(candidates: Sequence[BearingCandidate], band: str, count: int) -> Array:
    """Return the root mean squares of a band, (bearings, specimens)."""
    return np.array([[heard.by_band[band] for heard in one.heard[:count]] for one in candidates])


def specimens_needed(choice: BearingChoice) -> int:
    """Return the number of specimens after which every ± of a choice is the wanted one."""
    needed = 1
    for band in choice.rms.values():
        if not np.all(band > 0):
            continue
        levels = 20 * np.log10(band)
        for other in levels[1:]:
            apart = other - levels[0]
            if len(apart) > 1 and np.ptp(apart) > 0:
                needed = max(needed, FIRST_PAIRS, pairs_needed(apart, choice.within_db))
    return needed


# ---- files


def _identity(candidates: Sequence[BearingCandidate]) -> str:
    """Return a digest of the bearings of a choice."""
    return digest([[one.label, one.scene.to_dict()] for one in candidates])


def _take_heard(folder: Path, candidates: Sequence[BearingCandidate]) -> None:
    """Take what a folder has heard of the same bearings; refuse a folder of something else."""
    if choice_folder.take(folder, FORMATS) is None:
        return
    path = folder / CHOICE
    try:
        kept = from_bytes(StoredSpecimens, read_regular(path, choice_folder.MAX_CHOICE))
        is_same = kept.identity == _identity(candidates)
        if is_same and len(kept.heard) != len(candidates):
            raise ValueError("specimens of other bearings")
    except (OSError, ValueError, RecursionError) as error:
        raise FolderError(f"{path}: it is damaged; give another folder with --out") from error
    if not is_same:
        raise FolderError(f"{folder}: it holds another choice; give another folder with --out")
    for one, of_one in zip(candidates, kept.heard, strict=True):
        one.heard = [*of_one]


def _keep_heard(folder: Path, candidates: Sequence[BearingCandidate]) -> None:
    """Write what was heard so far."""
    files.write_json(folder / CHOICE, _as_json(candidates))


def _as_json(candidates: Sequence[BearingCandidate]) -> dict[str, Any]:
    """Return what was heard so far for JSON."""
    kept = StoredSpecimens(
        format=FORMAT,
        program=folders.this_program(),
        identity=_identity(candidates),
        labels=tuple(one.label for one in candidates),
        heard=tuple(tuple(one.heard) for one in candidates),
    )
    content: dict[str, Any] = json.loads(to_bytes(kept))
    return content


def _write_files(choice: BearingChoice, candidates: Sequence[BearingCandidate]) -> None:
    """Write table and picture of a choice, last its numbers."""
    from rolling.bearing_run.choice_picture import choice_picture

    with progress.step("drawing the picture"):
        png = choice_picture(choice).file("png")
    if png is not None:
        files.write_bytes(choice.folder / PICTURE, png)
    files.write_bytes(choice.folder / TABLE, csv_bytes(choice.table()))
    numbers = {
        "sentences": choice.sentences,
        "pairs": choice.pairs,
        "within_db": choice.within_db,
        "limit": choice.limit,
        "ended_early": choice.is_early,
    }
    files.write_json(choice.folder / CHOICE, _as_json(candidates) | numbers)
