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

from rolling import run_folder, solve
from rolling._wording import nearest
from rolling.article import claims, claims_text, figures, page, readings, study
from rolling.article.study import Case
from rolling.picture import Picture
from rolling.pool import Outcome
from rolling.run_folder import FolderError
from rolling.solve import Run
from rolling.store import Result

SCENES = Path(__file__).parents[2] / "scenarios"
CASES = "cases.json"
CLAIMS = "claims.md"
TABLES = "tables.md"
PAGE = "index.html"


@dataclass(frozen=True)
class Reproduction:
    """What a command did: its folder, its finding, the cases that are solved, failures by case, whether it was interrupted."""

    folder: Path
    headline: str
    cases: list[Case]
    failures: dict[str, str]
    interrupted: bool

    @property
    def exit_code(self) -> int:
        return 130 if self.interrupted else 1 if self.failures else 0


def reproduce(
    name: str, chosen: Sequence[str] = (), out: Path | None = None, quick: bool = False, workers: int = 0
) -> Reproduction:
    """Run the study of an article, or what is missing of it, and write its numbers.

    Parameters
    ----------
    chosen : readings by name; none: all there are, quick: all of roughness and load.
    out : folder of the study, new or of an earlier run of it; None: below outputs/.

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
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())) and not (folder / CASES).is_file():
        raise FolderError(f"{folder}: holds something that is no study of this program; take another --out")
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / CASES).is_file():
        run_folder.write_json(folder / CASES, [])
    runs = {reading: study.runs(folder / reading, found) for reading, found in scenes.items()}
    outcome, results = _solve([one for each in runs.values() for one in each], workers, name)
    cases = [
        study.case(reading, one, results[one.folder])
        for reading, each in runs.items()
        for one in each
        if results[one.folder].complete
    ]
    run_folder.write_json(folder / CASES, [_plain(asdict(case)) for case in cases])
    departures = {reading: study.departures(found) for reading, found in scenes.items()}
    table = claims.table(cases, {one.name: study.description(one) for one in folders}, departures)
    run_folder.write_json(folder / "claims.json", table)
    run_folder.write_bytes(folder / CLAIMS, claims_text.markdown(table).encode())
    run_folder.write_bytes(folder / TABLES, claims_text.tables(table).encode())
    if not outcome.interrupted:
        _write_pictures(folder, runs, results, cases, table)
    flat = [one for each in runs.values() for one in each]
    failures = {str(flat[k].folder.relative_to(folder)): reason for k, reason in outcome.failures.items()}
    return Reproduction(folder, claims_text.headline(table), cases, failures, outcome.interrupted)


def _readings(name: str, chosen: Sequence[str]) -> list[Path]:
    """The folders of a study's readings, all or those chosen."""
    found = {folder.name: folder for folder in sorted((SCENES / name).glob("*")) if folder.is_dir()}
    if not found:
        raise FolderError(f"{SCENES / name}: no scene files of this study here; they come with the repository")
    for each in chosen:
        if each not in found:
            raise FolderError(f"--readings: got {each}, allowed: {', '.join(found)}{nearest(each, list(found))}")
    return [found[each] for each in chosen or found]


def _solve(runs: Sequence[Run], workers: int, name: str) -> tuple[Outcome, dict[Path, Result]]:
    results = study.open_results(runs)
    outcome = study.solve_all(runs, results, workers, name)
    return outcome, {one.folder: result for one, result in zip(runs, results, strict=True)}


def _write_pictures(
    folder: Path, runs: dict[str, list[Run]], results: dict[Path, Result], cases: Sequence[Case], table: dict[str, Any]
) -> None:
    """The article's figures of each reading in its folder, and the page that puts the readings side by side."""
    found = []
    for name, each in tqdm(runs.items(), disable=None, desc="surfaces", bar_format=solve.BAR):
        solved = [one for one in each if results[one.folder].complete]
        if solved and name not in table["twins"]:
            own = [case for case in cases if case.reading == name]
            found.append(readings.gather(name, solved, [results[one.folder] for one in solved], own))
    if not found:
        return
    scales = readings.scales(found)
    pictures: dict[str, list[Picture]] = {}
    for one in tqdm(found, disable=None, desc="figures", bar_format=solve.BAR):
        pictures[one.name] = list(figures.gallery(one, scales))
        for picture in pictures[one.name]:
            picture.write(folder / one.name)
    run_folder.write_bytes(folder / PAGE, page.page(page.ordered(pictures, table), table, pictures))


def _plain(value: Any) -> Any:
    """Lists and numbers for JSON; what is no number is null."""
    if isinstance(value, dict):
        return {key: _plain(each) for key, each in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [_plain(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
