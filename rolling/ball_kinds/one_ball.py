"""What all balls on plates share, whether they roll or fall."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rolling.check import refusals
from rolling.check.findings import Findings, check_scene, conclusion
from rolling.check.in_short import lines_in_short
from rolling.in_si.measured import HeightArray, with_copy
from rolling.kinds.figure_kind import FigureKind
from rolling.kinds.heard_sound import FileGain, HeardSound
from rolling.kinds.kind import Kind
from rolling.kinds.needed_marches import March, MarchStore
from rolling.kinds.page_parts import PageParts
from rolling.kinds.run_folder import LISTEN, RELEASED, RESULT, RunFolder
from rolling.marches.next_pieces import own_part
from rolling.marches.piece import contact_identity
from rolling.marches.result import Result
from rolling.numbers.ball_numbers import RunNumbers
from rolling.numbers.conditions import Condition, Method
from rolling.numbers.quantity import RELEASED_POWER, VIBRATION, Quantity
from rolling.numbers.run_file import KIND as NAME
from rolling.numbers.run_file import StoredNumbers
from rolling.numbers.views import NumberRow
from rolling.results import (
    answer,
    description,
    labels,
    level_words,
    listening,
    result_file,
    run_lines,
    shared_lines,
)
from rolling.results.former_numbers import former_numbers
from rolling.results.result_arrays import series_of
from rolling.results.run_result import PASSES, Run, make_run, read_run, write_run
from rolling.results.stored_numbers import read_stored
from rolling.run.taken import OTHER_CONTACT, TakenMarches
from rolling.scene import file
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.scene.surfaces import HeightFile
from rolling.terminal import progress
from rolling.terminal.whole_files import FolderError

if TYPE_CHECKING:
    from rolling.archive.definition import Series
    from rolling.ball_kinds.ball_audition import BallAudition
    from rolling.numbers.sheet import Sheet
    from rolling.recordings.compared_run import ComparedRun
    from rolling.recordings.recorded import MeasuredQuantity


class ResultsOfRuns(MarchStore):
    """Marches in the results of runs that are done, from which other runs begin.

    by_identity : mapping. A run that is done by the contact identity of its march.
    """

    def __init__(self, by_identity: Mapping[str, RunFolder]) -> None:
        self._by_identity = by_identity

    def begin(self, march: March, identity: str) -> Result | None:
        """Return the march of another run with which a run begins; None without one."""
        source = self._by_identity.get(identity)
        if source is None:
            return None
        result = result_file.read_result(source.folder / RESULT, source.scene)
        film = result.slow_motion
        if film is not None and len(film.positions) == 0:
            film = None  # another stretch may have a solution
        steps = march.scene.track.steps
        return replace(result, steps=steps, extremes={}, slow_motion=film)

    def keep(self, march: March, identity: str, result: Result) -> Result:
        """Return the marches that the own scene of a run needs."""
        return own_part(march.scene, result, march.film)


class OneBall(Kind):
    """A ball on a plate; its file, folder and tables are the same however it moves."""

    name = NAME
    scene_type = Scene
    description = (
        "A sphere that rolls on a rough surface, how its contact is solved, and where it is heard."
    )
    stored_type = StoredNumbers
    former_format = None
    gallery_note = (
        "Vibration is what a listener would hear: ball and plate vibrate. Released power is an"
        " upper bound: all elastic energy that asperities give back, all of it sound (q = 1)."
        " Pictures: the surface (grey), the pressure on its asperities (warm) and the energy that"
        " they release (blue), from above; the ball rolls to the right."
    )
    leading = (f"{VIBRATION}_db", f"{RELEASED_POWER}_db")

    # ---- scenes

    def refuse(
        self,
        scene: Scene,
        workers: int,
        folder: Path | None,
        unsolved: Sequence[Scene] | None = None,
    ) -> None:
        """Refuse a scene that cannot be run here."""
        refusals.refuse(scene, workers, folder, unsolved)

    def check(self, scene: Scene, solve: bool = True) -> Findings:
        """Judge all runs of a scene before they are run."""
        return check_scene(scene, solve=solve)

    def conclusion(self, scene: Scene, findings: Findings) -> str:
        """State in a sentence how long a scene takes, and with which verdict at best."""
        return conclusion(scene, findings)

    def lines_in_short(self, scene: Scene, findings: Findings) -> list[str]:
        """Return the conclusion of a check, cost and the largest doubts."""
        return lines_in_short(scene, findings)

    def resound(self, scene: Scene, overrides: Sequence[str]) -> Scene:
        """Return the scene of stored runs with another speed, mass, thickness or sound."""
        return file.resound(scene, overrides)

    def with_heights(self, scene: Scene, heights: Any) -> Scene:
        """Return a scene on the heights of a file or an array."""
        if isinstance(heights, HeightFile):
            return scene.with_(surface=heights)
        return scene.with_(surface=HeightArray(heights, spacing_um=scene.spacing_um))

    def kept_scene(self, scene: Scene, folder: Path) -> Scene:
        """Return the scene as a folder keeps it, which gets a copy of heights in memory."""
        kept: Scene = with_copy(scene.with_auto_steps(), folder)
        return kept

    # ---- marches

    def marches(self, scene: Scene, film: bool = False) -> list[March]:
        """Return the only march, whose loads and stretches follow from the scene."""
        return [March(scene, is_shared=False, film=film)]

    def march_store(
        self,
        folder: Path | None = None,
        done: Sequence[RunFolder] = (),
        sources: Sequence[RunFolder] = (),
    ) -> ResultsOfRuns:
        """Return the results of runs that are done; those elsewhere count first."""
        by_identity: dict[str, RunFolder] = {}
        for run in (*sources, *done):
            by_identity.setdefault(contact_identity(run.scene), run)
        return ResultsOfRuns(by_identity)

    def take_marches(
        self, start_from: Path, elsewhere: Sequence[RunFolder], own: Sequence[RunFolder]
    ) -> list[RunFolder]:
        """Return runs elsewhere whose marches own runs lack, and say what is taken and what not.

        A result is read as the file of a stranger, and left out where it is damaged.
        """
        done: dict[str, RunFolder] = {}
        for run in elsewhere:
            with suppress(SceneError):  # its file of heights is gone
                if run.is_done:
                    done.setdefault(contact_identity(run.scene), run)
        solved = {contact_identity(run.scene) for run in own if run.is_done}
        taken = TakenMarches(start_from)
        sources = []
        for run, label in zip(own, labels.labels(own), strict=True):
            identity = contact_identity(run.scene)
            if identity in solved:
                continue
            solved.add(identity)
            if identity not in done:
                taken.leave(label, OTHER_CONTACT)
                continue
            source = done[identity]
            try:
                result_file.read_result(source.folder / RESULT, source.scene)
            except FolderError as error:
                taken.leave(label, str(error))
                continue
            taken.take(label)
            sources.append(source)
        for line in taken.lines():
            progress.line(line)
        return sources

    # ---- runs

    def make_run(self, place: RunFolder, label: str, marched: Sequence[Result]) -> Run:
        """Make the sound of a whole result and its numbers."""
        (result,) = marched
        return make_run(place, label, result)

    def write_run(self, run: Run) -> None:
        """Write the files of a run into its folder."""
        write_run(run)

    def read_run(self, place: RunFolder, label: str) -> Run:
        """Read a run from its folder, and make its sound again."""
        return read_run(place, label)

    def refuse_edited(self, runs: Sequence[RunFolder]) -> None:
        """Raise SceneError where the height file of a run that is done has other bytes now."""
        for run in runs:
            if run.scene.height_paths:
                result_file.read_result(run.folder / RESULT, run.scene)

    def former_stored(self, content: bytes) -> StoredNumbers:
        """Return the numbers of a run of version 0.8."""
        return former_numbers(content)

    def sounds(self, run: Run) -> list[HeardSound]:
        """Return the vibration for the ear, and the release; the one that plays is first."""
        return [*listening.listen_sounds(run)]

    def file_gains(self, stored: StoredNumbers) -> Iterator[FileGain]:
        """Yield the gains of the files for the ear, unless they are silent."""
        return listening.listen_gains(stored)

    def write_long(
        self,
        run: Run,
        seconds: float,
        speed: float | tuple[float, float] | None,
        seed: int,
        reverberation_s: float | None,
    ) -> Path:
        """Let the ball roll on beyond the solved track, and write long.wav, or room.wav."""
        if reverberation_s is not None:
            listening.refuse_reverberation(reverberation_s)
        long = run.listen(seconds, speed, seed)
        path = listening.write_long(run, long, reverberation_s)
        stated = run.stated()
        progress.line(listening.describe_long_record(stated, long))
        if reverberation_s is not None:
            progress.line(listening.words_of_room(reverberation_s))
        for text in long.numbers.limits or ():
            progress.line(f"warning: {text}")
        return path

    def series(self, run: Run) -> Series:
        """Return the series along the track."""
        return series_of(run)

    def compared(self, run: Run, quantity: MeasuredQuantity) -> ComparedRun:
        """Return the sound of a run, or its channels of a quantity."""
        from rolling.recordings.ball_records import records_of_ball

        return records_of_ball(run, quantity)

    # ---- how runs are shown

    def answer_lines(self, done: Sequence[RunFolder]) -> list[str]:
        """Return sentence, table and conclusion of runs."""
        return run_lines.answer_lines(done)

    def html_answer(self, done: Sequence[RunFolder]) -> str:
        """Return sentence, table and conclusion of runs as HTML."""
        return run_lines.html_table(done)

    def doubt_lines(self, done: Sequence[RunFolder]) -> list[str]:
        """Return the lines on channels and the largest doubts."""
        return [*run_lines.channel_lines(done), *run_lines.doubt_lines(done)]

    def further_lines(self, done: Sequence[RunFolder]) -> list[str]:
        """Return all other lines on runs."""
        return run_lines.further_lines(done)

    def listen_lines(self, done: Sequence[RunFolder]) -> list[str]:
        """Name the sounds of the first run, with what is heard."""
        stored = read_stored(done[0].folder)
        sounds = [
            ("listen", LISTEN, listening.content_words(stored)),
            ("listen to the release", RELEASED, ""),
            ("pass by pass", PASSES, ""),
        ]
        return shared_lines.listen_lines(done, sounds)

    def quantities(self, numbers: RunNumbers) -> dict[str, Quantity]:
        """Return vibration and released power."""
        return {"Vibration": numbers.vibration, "Released power": numbers.released_power}

    def number_rows(self, every: Sequence[RunNumbers]) -> list[NumberRow]:
        """Return the rows of the numbers that have a word."""
        return level_words.number_rows(every)

    def card_sentence(self, run: Run) -> str:
        """Return what follows from a run."""
        return answer.follows([run])

    def heard(self, run: Run, is_alone: bool) -> str:
        """Say what one hears of a run, or why it is silent."""
        from rolling.report import text

        return text.heard(run, is_alone, listening.listen_sounds(run)[0].stated)

    def figures(self) -> Mapping[str, FigureKind]:
        """Return the figures that compare runs, those of one run, and those on request."""
        from rolling.figures.ball_figures import FIGURES

        return FIGURES

    def subject(self, runs: Sequence[Run]) -> str:
        """Say which ball rolls on which plate, under which loads."""
        return description.subject([run.scene for run in runs])

    def page_parts(self, runs: Sequence[Run]) -> PageParts:
        """Return the parts of the page of balls."""
        from rolling.report.ball_page import ball_parts

        return ball_parts(runs)

    def prepare_page(self, run: Run) -> bool:
        """Make the charts and the sounds of the page that follow from a run alone."""
        from rolling.report.ball_page import prepare

        prepare(run)
        return True

    # ---- sheets

    def conditions(self, scene: Scene) -> list[Condition]:
        """Return the conditions of a ball, with how its surfaces were prepared."""
        from rolling.ball_kinds.ball_conditions import conditions

        return conditions(scene)

    def method(self, scene: Scene) -> Method:
        """Return how the numbers of a ball are computed."""
        from rolling.ball_kinds.ball_conditions import method

        return method(scene)

    def sheets(self, run: Run) -> list[Sheet]:
        """Return the declaration of the level of the vibration."""
        from rolling.ball_kinds.ball_sheets import noise_sheet_of

        return [noise_sheet_of(run)]

    def surface_sheets(self, run: Run) -> list[Sheet]:
        """Return the roughness report of the surface that the ball rolled over."""
        from rolling.ball_kinds.ball_sheets import roughness_sheet_of

        return [roughness_sheet_of(run)]

    # ---- choices

    def audition(self) -> BallAudition:
        """Return how balls on plates are compared."""
        from rolling.ball_kinds.ball_audition import BallAudition

        return BallAudition()
