"""The command that runs the study of an article and answers for its statements. Depends on study, claims and figures.

What is solved is kept case by case: the same command again goes on where it was stopped.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from rolling.figures.picture import Picture
from rolling.folders import claim, files, new_folder, run_record
from rolling.folders.claim import Claim
from rolling.folders.files import FolderError
from rolling.lee2025 import claims, claims_text, figure_data, figures, page, study
from rolling.lee2025.results import Table
from rolling.lee2025.study import Case
from rolling.scene.messages import nearest
from rolling.simulation import batch
from rolling.simulation.batch import Run
from rolling.simulation.pool import Outcome
from rolling.simulation.result_file import Result
from rolling.simulation.stored_runs import records_of

SCENES = Path(__file__).parents[2] / "scenarios"
CASES = "cases.json"
CLAIMS = "claims.md"
TABLES = "tables.md"
PAGE = "index.html"


@dataclass(frozen=True)
class Reproduction:
    """The outcome of a command: its folder, its finding, the cases that are solved, failures by case, whether it was interrupted.

    solved : folders of the cases that are solved, below that of the study.
    """

    folder: Path
    headline: str
    cases: list[Case]
    failures: dict[str, str]
    interrupted: bool
    solved: frozenset[str]

    @property
    def exit_code(self) -> int:
        return 130 if self.interrupted else 1 if self.failures else 0


def reproduce(
    name: str,
    chosen: Sequence[str] = (),
    out: Path | None = None,
    quick: bool = False,
    workers: int = 0,
    take_over: bool = False,
) -> Reproduction:
    """Run the study of an article, or what is missing of it, and write its numbers.

    Parameters
    ----------
    chosen : readings by name; none: all there are, quick: all of roughness and load.
    out : folder of the study, new or of an earlier run of it; None: below outputs/.
    take_over : go on, too, if the process that works on it cannot be seen from here.

    Raises
    ------
    FolderError : no such reading, or `out` holds something else. SceneError : a scene file that cannot be used.
    """
    part = study.QUICK if quick else study.WHOLE
    folders = _readings(name, chosen)
    scenes = {folder.name: study.scenes(folder, part) for folder in folders}
    if quick and not chosen:  # the outlook's fine surfaces would take a third as long again
        scenes = {name: found for name, found in scenes.items() if len({study.varied(one)[3] for one in found}) == 1}
    folder = out or Path("outputs") / (f"{name}-quick" if quick else name)
    runs = {reading: study.runs(folder / reading, found) for reading, found in scenes.items()}
    flat = [one for each in runs.values() for one in each]
    with _claimed(folder, [one.folder.relative_to(folder).as_posix() for one in flat], take_over) as held:
        done = _reproduced(held, name, folders, runs, workers)
        _mark_all(held, flat, done)
    return done


def _claimed(folder: Path, runs: Sequence[str], take_over: bool) -> Claim:
    """Claim the folder of a study, new or of an earlier run of it.

    Raises
    ------
    FolderError : it holds something else, or another process works on it.
    """
    record = run_record.read(folder)
    if record is not None and record.kind == "study":
        return claim.take(folder, "study", runs, take_over)
    if record is None and (folder / CASES).is_file():
        records_of([folder])
        return claim.take(folder, "study", runs, take_over)
    return new_folder.make(new_folder.aim(folder, folder, False, ["study"]), run_record.new("study", runs))


def _mark_all(held: Claim, runs: Sequence[Run], done: Reproduction) -> None:
    """Write the state of each case that this command solved or tried, and of the study."""
    for one in runs:
        name = one.folder.relative_to(held.folder).as_posix()
        if name in done.failures:
            held.mark(one.folder, "failed", done.failures[name])
        elif name in done.solved:
            held.mark(one.folder, "done")
        else:
            held.mark(one.folder, "waiting", claim.INTERRUPTED)
    if done.interrupted:
        held.mark(held.folder, "waiting", claim.INTERRUPTED)
    elif done.failures:
        held.mark(held.folder, "failed", f"{len(done.failures)} of {len(runs)} cases failed")
    else:
        held.mark(held.folder, "done")


def _reproduced(
    held: Claim, name: str, folders: Sequence[Path], runs: dict[str, list[Run]], workers: int
) -> Reproduction:
    """Solve what is missing of a study, judge the statements and draw the figures."""
    folder = held.folder
    if not (folder / CASES).is_file():
        files.write_json(folder / CASES, [])
    outcome, results = _solve(held, [one for each in runs.values() for one in each], workers, name)
    cases = [
        study.case(reading, one, results[one.folder])
        for reading, each in runs.items()
        for one in each
        if results[one.folder].complete
    ]
    files.write_json(folder / CASES, [_plain(asdict(case)) for case in cases])
    departures = {reading: study.departures([one.scene for one in each]) for reading, each in runs.items()}
    table = claims.table(cases, {one.name: study.description(one) for one in folders}, departures)
    files.write_json(folder / "claims.json", table.to_dict())
    files.write_bytes(folder / CLAIMS, claims_text.markdown(table).encode())
    files.write_bytes(folder / TABLES, claims_text.tables(table).encode())
    if not outcome.interrupted:
        _write_pictures(folder, runs, results, cases, table)
    flat = [one for each in runs.values() for one in each]
    failures = {flat[k].folder.relative_to(folder).as_posix(): reason for k, reason in outcome.failures.items()}
    solved = frozenset(one.folder.relative_to(folder).as_posix() for one in flat if results[one.folder].complete)
    return Reproduction(folder, claims_text.headline(table), cases, failures, outcome.interrupted, solved)


def _readings(name: str, chosen: Sequence[str]) -> list[Path]:
    """The folders of a study's readings, all or those chosen."""
    found = {folder.name: folder for folder in sorted((SCENES / name).glob("*")) if folder.is_dir()}
    if not found:
        raise FolderError(f"{SCENES / name}: no scene files of this study here; they come with the repository")
    for each in chosen:
        if each not in found:
            raise FolderError(f"--readings: got {each}, allowed: {', '.join(found)}{nearest(each, list(found))}")
    return [found[each] for each in chosen or found]


def _solve(held: Claim, runs: Sequence[Run], workers: int, name: str) -> tuple[Outcome, dict[Path, Result]]:
    results = study.open_results(runs)
    outcome = study.solve_all(runs, results, workers, name, lambda one: held.mark(one.folder, "running"))
    return outcome, {one.folder: result for one, result in zip(runs, results, strict=True)}


def _write_pictures(
    folder: Path, runs: dict[str, list[Run]], results: dict[Path, Result], cases: Sequence[Case], table: Table
) -> None:
    """The article's figures of each reading in its folder, and the page that puts the readings side by side."""
    found = []
    for name, each in tqdm(runs.items(), disable=None, desc="surfaces", bar_format=batch.BAR):
        solved = [one for one in each if results[one.folder].complete]
        if solved and name not in table.twins:
            own = [case for case in cases if case.reading == name]
            found.append(figure_data.gather(name, solved, [results[one.folder] for one in solved], own))
    if not found:
        return
    scales = figure_data.scales(found)
    pictures: dict[str, list[Picture]] = {}
    for one in tqdm(found, disable=None, desc="figures", bar_format=batch.BAR):
        pictures[one.name] = list(figures.gallery(one, scales))
        for picture in pictures[one.name]:
            picture.write(folder / one.name)
    files.write_bytes(folder / PAGE, page.page(page.ordered(pictures, table), table, pictures))


def _plain(value: Any) -> Any:
    """Lists and numbers for JSON; what is no number is null."""
    if isinstance(value, dict):
        return {key: _plain(each) for key, each in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [_plain(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
