"""The command that runs the study of an article, judges its statements and draws its figures.

Solved cases are stored separately, so the same command continues a study that was stopped.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from rolling.figures.picture import Picture
from rolling.folders import claim, files, new_folder, run_record
from rolling.folders.claim import Claim
from rolling.folders.files import FolderError
from rolling.lee2025 import claims, claims_text, figure_data, figures, half_spacing, page, study
from rolling.lee2025.results import Table
from rolling.lee2025.study import Case
from rolling.scene import library
from rolling.scene.messages import nearest
from rolling.simulation.batch import Run
from rolling.simulation.pool import Outcome
from rolling.simulation.result_file import Result
from rolling.simulation.stored_runs import is_begun, records_of
from rolling.terminal import progress

SCENES = library.folder()
CASES = "cases.json"
CLAIMS = "claims.md"
TABLES = "tables.md"
PAGE = "index.html"
_Item = TypeVar("_Item")


@dataclass(frozen=True)
class Reproduction:
    """The outcome of the command.

    Parameters
    ----------
    folder : Path. Folder of the study.
    headline : str. The judgement in a sentence.
    cases : list of Case. All solved cases.
    failures : dict from str to str. Reasons by the folder of the case.
    interrupted : bool. True if the command was stopped.
    solved : frozenset of str. Folders of the solved cases, relative to the folder of the study.
    begun : bool. True if any step is solved.
    """

    folder: Path
    headline: str
    cases: list[Case]
    failures: dict[str, str]
    interrupted: bool
    solved: frozenset[str]
    begun: bool

    @property
    def exit_code(self) -> int:
        """The exit code of the command."""
        return 130 if self.interrupted else 1 if self.failures else 0


def reproduce(
    name: str,
    chosen: Sequence[str] = (),
    out: Path | None = None,
    quick: bool = False,
    workers: int = 0,
    take_over: bool = False,
) -> Reproduction:
    """Run the study of an article, or its missing part, and write its numbers.

    Parameters
    ----------
    name : str. Name of the study.
    chosen : sequence of str. Readings by name. Default: all, or with `quick` all readings with a
        single correlation length.
    out : Path or None. Folder of the study, new or of an earlier run. Default: None, for a folder
        below outputs/.
    quick : bool. If true, solve one surface and three loads on a short track. Default: False.
    workers : int. Number of processes. Default: 0, for one per core.
    take_over : bool. If true, continue even if the state of another process on the folder is
        unknown. Default: False.

    Raises
    ------
    FolderError : there is no such reading, or `out` holds something else.
    SceneError : a scene file cannot be used.
    """
    part = study.QUICK if quick else study.WHOLE
    folders = _readings(name, chosen)
    with progress.step("reading the scenes"):
        scenes = {folder.name: study.scenes(folder, part) for folder in folders}
    if quick and not chosen:  # the fine surfaces of the outlook would add a third to the time
        scenes = {
            name: swept
            for name, swept in scenes.items()
            if len({study.varied(scene)[3] for scene in swept}) == 1
        }
    folder = out or Path("outputs") / (f"{name}-quick" if quick else name)
    runs = {reading: study.runs(folder / reading, swept) for reading, swept in scenes.items()}
    flat = [run for each in runs.values() for run in each]
    with _claimed(
        folder, [run.folder.relative_to(folder).as_posix() for run in flat], take_over
    ) as held:
        done = _reproduced(held, name, folders, runs, workers, part.finer)
        _mark_all(held, flat, done)
    return done


def _claimed(folder: Path, runs: Sequence[str], take_over: bool) -> Claim:
    """Claim the folder of a study, new or of an earlier run.

    Raises
    ------
    FolderError : the folder holds something else, or another process works on it.
    """
    record = run_record.read(folder)
    if record is not None and record.kind == "study":
        return claim.take(folder, "study", runs, take_over)
    if record is None and (folder / CASES).is_file():
        records_of([folder])
        return claim.take(folder, "study", runs, take_over)
    return new_folder.make(
        new_folder.aim(folder, folder, False, ["study"]), run_record.new("study", runs)
    )


def _mark_all(held: Claim, runs: Sequence[Run], done: Reproduction) -> None:
    """Write the state of the study and of each case that this command solved or tried."""
    for run in runs:
        name = run.folder.relative_to(held.folder).as_posix()
        if name in done.failures:
            held.mark(run.folder, "failed", done.failures[name])
        elif name in done.solved:
            held.mark(run.folder, "done")
        else:
            held.mark(run.folder, "waiting", claim.INTERRUPTED)
    failed = f"{len(done.failures)} of {len(runs)} cases failed" if done.failures else None
    held.end(done.interrupted, failed)


def _reproduced(
    held: Claim,
    name: str,
    folders: Sequence[Path],
    runs: dict[str, list[Run]],
    workers: int,
    finer: bool,
) -> Reproduction:
    """Solve the missing cases of a study, judge the statements and draw the figures."""
    folder = held.folder
    if not (folder / CASES).is_file():
        files.write_json(folder / CASES, [])
    outcome, results = _solve(held, [run for each in runs.values() for run in each], workers, name)
    with progress.step("sound and numbers of the cases"):
        cases = [
            study.case(reading, run, results[run.folder])
            for reading, each in runs.items()
            for run in each
            if results[run.folder].complete
        ]
    files.write_json(folder / CASES, [_plain(asdict(case)) for case in cases])
    departures = {
        reading: study.departures([run.scene for run in each]) for reading, each in runs.items()
    }
    with progress.step("judging the statements"):
        table = claims.table(
            cases, {reading.name: study.description(reading) for reading in folders}, departures
        )
    interrupted = outcome.interrupted
    if finer and not interrupted and cases:

        def solver(chosen: Sequence[Run]) -> tuple[Outcome, dict[Path, Result]]:
            return half_spacing.solve(folder / half_spacing.FOLDER, chosen, workers, name)

        table, checks = half_spacing.checked(table, cases, runs, results, solver)
        interrupted = checks.interrupted
    files.write_json(folder / "claims.json", table.to_dict())
    files.write_bytes(folder / CLAIMS, claims_text.markdown(table).encode())
    files.write_bytes(folder / TABLES, claims_text.tables(table).encode())
    if not interrupted:
        _write_pictures(folder, runs, results, cases, table)
    flat = [run for each in runs.values() for run in each]
    failures = {
        flat[k].folder.relative_to(folder).as_posix(): reason
        for k, reason in outcome.failures.items()
    }
    solved = frozenset(
        run.folder.relative_to(folder).as_posix() for run in flat if results[run.folder].complete
    )
    begun = any(map(is_begun, results.values()))
    return Reproduction(
        folder, claims_text.headline(table), cases, failures, interrupted, solved, begun
    )


def _readings(name: str, chosen: Sequence[str]) -> list[Path]:
    """Return the folders of a study's readings, all or the chosen ones."""
    available = {
        folder.name: folder for folder in sorted((SCENES / name).glob("*")) if folder.is_dir()
    }
    if not available:
        raise FolderError(
            f"{SCENES / name}: no scene files of this study here; the installation is incomplete"
        )
    for reading in chosen:
        if reading not in available:
            raise FolderError(
                f"--readings: got {reading}, allowed: "
                f"{', '.join(available)}{nearest(reading, list(available))}"
            )
    return [available[reading] for reading in chosen or available]


def _solve(
    held: Claim, runs: Sequence[Run], workers: int, name: str
) -> tuple[Outcome, dict[Path, Result]]:
    """Solve the missing runs and return the outcome with all results by folder."""
    with progress.step("reading the cases that are solved"):
        results = study.open_results(runs)
    outcome = study.solve_all(
        runs, results, workers, name, lambda run: held.mark(run.folder, "running")
    )
    return outcome, {run.folder: result for run, result in zip(runs, results, strict=True)}


def _write_pictures(
    folder: Path,
    runs: dict[str, list[Run]],
    results: dict[Path, Result],
    cases: Sequence[Case],
    table: Table,
) -> None:
    """Draw the figures of each reading into its folder, and write the page of all readings."""
    readings = []
    for name, each in _watched(runs.items(), "surfaces"):
        solved = [run for run in each if results[run.folder].complete]
        if solved and name not in table.twins:
            own = [case for case in cases if case.reading == name]
            readings.append(
                figure_data.gather(name, solved, [results[run.folder] for run in solved], own)
            )
    if not readings:
        return
    scales = figure_data.scales(readings)
    pictures: dict[str, list[Picture]] = {}
    for reading in _watched(readings, "figures"):
        pictures[reading.name] = list(figures.gallery(reading, scales))
        for picture in pictures[reading.name]:
            picture.write(folder / reading.name)
    with progress.step("writing the page"):
        files.write_bytes(folder / PAGE, page.page(page.ordered(pictures, table), table, pictures))


def _watched(items: Collection[_Item], name: str) -> Iterator[_Item]:
    """Yield items and show how far they are."""
    with progress.bar(len(items), name) as bar:
        for item in items:
            yield item
            bar.update(1)


def _plain(value: Any) -> Any:
    """Convert to lists and numbers for JSON; a non-finite number becomes null."""
    if isinstance(value, dict):
        return {key: _plain(each) for key, each in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [_plain(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
