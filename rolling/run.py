"""Scene to run folder: the only place that knows contact, sound and files.

A run is simulated, kept as it goes, and finished: sound, levels, plots, the report page, then a mark. Several runs of one scene
(a sweep) share a folder, their plots, a table and the page.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rolling import check, labels, run_folder, scene_file, simulate, solve, sound_files, store, summary
from rolling.heard import Heard, hear
from rolling.scenario import Scene, expand, run_name, track
from rolling.solve import Run
from rolling.store import Result

if TYPE_CHECKING:
    from rolling.report import Exhibit

PAGE = "report.html"


@dataclass(frozen=True)
class Report:
    """What a command did: its folder, the runs with their summaries, the failures by run, whether it was interrupted, the page."""

    folder: Path
    runs: list[tuple[Run, dict[str, Any] | None]]
    failures: dict[str, str]
    interrupted: bool
    page: Path | None

    @property
    def exit_code(self) -> int:
        return 130 if self.interrupted else 1 if self.failures else 0


def run(
    scene_path: Path,
    overrides: Sequence[str] = (),
    out: Path | None = None,
    force: bool = False,
    workers: int = 0,
    page: bool = True,
) -> Report:
    """Run a scene file: every combination of its sweep, each into a run folder, and a report page unless `page` is not wanted.

    Raises
    ------
    SceneError, FolderError : before anything is computed or written.
    """
    scene = scene_file.load(scene_path, overrides)
    check.refuse_unavailable(scene)
    for _, single in expand(scene):
        simulate.rolling_contact(single)  # a surface that cannot be had shows before anything is written
    folder = run_folder.new_folder(Path("outputs") / scene.name, out, force)
    run_folder.write_bytes(folder / "scene.yaml", scene_path.read_bytes())
    runs = _make_folders(folder, scene)
    results = [Result.empty(track(one.scene), one.scene.start) for one in runs]
    return _work(folder, runs, results, workers, page)


def resume(folder: Path, workers: int = 0, page: bool = True) -> Report:
    """Go on with a run folder that was interrupted or killed; what is solved is not solved again.

    Raises
    ------
    FolderError : no run folder, or results that do not fit its scene. SceneError : what it asks for cannot be had.
    """
    runs = read_runs(folder)
    for one in runs:
        check.refuse_unavailable(one.scene)
    results = []
    for one in runs:
        result = Result.empty(track(one.scene), one.scene.start)
        if (one.folder / solve.RESULT).is_file():
            kept = store.load(one.folder / solve.RESULT)
            if (kept.steps, kept.solved_steps) != (result.steps, result.solved_steps):
                raise run_folder.FolderError(
                    f"{one.folder}: result.h5 has {kept.steps} steps, its scene {result.steps}"
                )
            result = kept
        results.append(result)
    return _work(folder, runs, results, workers, page)


def resound(
    folder: Path, overrides: Sequence[str], out: Path | None = None, force: bool = False, page: bool = True
) -> Report:
    """New sound from stored runs, without solving: other speed, distance, q or gain.

    Raises
    ------
    FolderError : no run folder. SceneError : overrides that need a new solve, are not allowed or cannot be had.
    """
    stored = read_runs(folder)
    # All is read and checked before the new folder is made.
    scene = scene_file.resound(scene_file.load(folder / "resolved.yaml"), overrides)
    check.refuse_unavailable(scene)
    singles = expand(scene)
    if [values for values, _ in singles] != [one.values for one in stored]:
        raise run_folder.FolderError(f"{folder}: its sweep varies a key of --set; resound the runs in it one by one")
    results = [store.load(one.folder / solve.RESULT) for one in stored]
    target = run_folder.new_folder(Path("outputs") / scene.name, out, force)
    run_folder.write_bytes(target / "scene.yaml", (folder / "scene.yaml").read_bytes())
    runs = _make_folders(target, scene)
    return _finish(target, runs, results, {}, False, page)


def report(folders: Sequence[Path], out: Path | None = None, force: bool = False) -> Path:
    """One page of all the runs in run folders; returns its file.

    Parameters
    ----------
    out : file to write, an existing one with `force` only. None: report.html in the run folder, which it is derived from, so
        an older one is replaced; of several folders in a new folder.

    Raises
    ------
    FolderError, SceneError : no run folder, nothing solved in it, or `out` exists; nothing is written.
    """
    if out is not None and out.exists() and not (force and out.is_file()):
        raise run_folder.FolderError(
            f"{out}: {'exists; take another --out, or --force' if out.is_file() else 'is a folder'}"
        )
    from rolling import report as pages

    runs = list({one.folder.resolve(): one for folder in folders for one in read_runs(folder)}.values())
    if len(runs) > pages.MOST_RUNS:
        raise run_folder.FolderError(
            f"{len(runs)} runs, a page holds {pages.MOST_RUNS}: give the folders of those to compare"
        )
    heard: list[Heard] = []
    unheard: list[str] = []
    for one, label in zip(runs, labels.labels(runs), strict=True):
        check.refuse_unavailable(one.scene)
        solved = (one.folder / solve.RESULT).is_file()
        sounding = _heard(one, label, store.load(one.folder / solve.RESULT)) if solved else None
        if sounding is None:
            unheard.append(labels.title(one.scene.name, label))
        else:
            heard.append(sounding)
    if not heard:
        raise run_folder.FolderError(
            f"{', '.join(map(str, folders))}: nothing is solved yet, so there is nothing to report"
        )
    content = pages.page(heard, pages.exhibits(heard), unheard)
    if out is None:
        out = (
            folders[0] if len(folders) == 1 else run_folder.new_folder(Path("outputs") / "report", None, False)
        ) / PAGE
    out.parent.mkdir(parents=True, exist_ok=True)
    run_folder.write_bytes(out, content)
    return out


def read_runs(folder: Path) -> list[Run]:
    """The runs of a run folder.

    Raises
    ------
    FolderError : it is none.
    """
    if not (folder / "resolved.yaml").is_file():
        raise run_folder.FolderError(f"{folder}: not a run folder (no resolved.yaml in it)")
    scene = scene_file.load(folder / "resolved.yaml")
    return [Run(values, single, folder / run_name(values)) for values, single in expand(scene)]


def _make_folders(folder: Path, scene: Scene) -> list[Run]:
    """The runs of a scene, each in a folder of its own with its resolved scene (the folder itself where there is one run)."""
    runs = [Run(values, single, folder / run_name(values)) for values, single in expand(scene)]
    for one in runs:
        one.folder.mkdir(exist_ok=True)
        # A single run can be resumed and resounded on its own: it says what it was given, too.
        if one.folder != folder:
            run_folder.write_bytes(one.folder / "scene.yaml", (folder / "scene.yaml").read_bytes())
        run_folder.write_bytes(
            one.folder / "resolved.yaml", scene_file.dump(_seen_from(one.folder, one.scene)).encode()
        )
    run_folder.write_bytes(folder / "resolved.yaml", scene_file.dump(_seen_from(folder, scene)).encode())
    return runs


def _seen_from(folder: Path, scene: Scene) -> Scene:
    """The scene with its height file's path as it is from a run folder, from where it will be read again."""
    data = scene.to_dict()
    if scene.height_path is None or Path(data["surface"]["path"]).is_absolute():
        return scene
    data["surface"]["path"] = Path(os.path.relpath(scene.height_path, folder)).as_posix()
    return Scene.from_dict(data, folder)


def _work(folder: Path, runs: list[Run], results: list[Result], workers: int, page: bool) -> Report:
    outcome = solve.solve(runs, results, workers, runs[0].scene.name)
    names = labels.labels(runs)
    failures = {names[number]: reason for number, reason in outcome.failures.items()}
    return _finish(folder, runs, results, failures, outcome.interrupted, page)


def _finish(
    folder: Path, runs: list[Run], results: list[Result], failures: dict[str, str], interrupted: bool, page: bool
) -> Report:
    """Sound, numbers and plots of every run that has enough steps; of all together when there are several; the page last."""
    heard: list[Heard] = []
    done: list[tuple[Run, dict[str, Any] | None]] = []
    names = labels.labels(runs)
    for one, label, result in zip(runs, names, results, strict=True):
        sounding = _heard(one, label, result)
        done.append((one, sounding.numbers if sounding else None))
        if sounding is None:
            continue
        if not (one.folder / solve.RESULT).exists():  # new sound of a stored run
            solve.keep(one, result)
        sound_files.write(one.folder, one.scene, label, sounding.sound, sounding.numbers["caveats"])
        run_folder.write_json(one.folder / "summary.json", sounding.numbers)
        run_folder.write_json(one.folder / "provenance.json", summary.provenance(one.scene))
        heard.append(sounding)
    shelf = _write_pictures(folder, heard, page)
    if len(runs) > 1:
        run_folder.write_json(
            folder / "sweep.json",
            [
                {"values": one.values, "folder": one.folder.name, "label": label, "summary": numbers}
                for label, (one, numbers) in zip(names, done, strict=True)
            ],
        )
    if shelf:
        from rolling import report as pages

        unheard = [label for label, (_, numbers) in zip(names, done, strict=True) if numbers is None]
        run_folder.write_bytes(folder / PAGE, pages.page(heard, shelf, unheard))
    if not failures and not interrupted and all(result.complete for result in results):
        for finished in {one.folder for one in runs} | {folder}:
            run_folder.write_bytes(
                finished / run_folder.FINISHED, (datetime.now(UTC).isoformat(timespec="seconds") + "\n").encode()
            )
    return Report(folder, done, failures, interrupted, folder / PAGE if shelf else None)


def _heard(one: Run, label: str, result: Result) -> Heard | None:
    return hear(label, one.values, one.folder, one.scene, result)


def _write_pictures(folder: Path, heard: list[Heard], page: bool) -> list[tuple[Heard | None, Exhibit]]:
    """Pictures of each run into its folder, of all into theirs; returned for the page if it is wanted and not too long."""
    from rolling import figures  # matplotlib is slow to import, and a run that fails needs none
    from rolling import report as pages

    page = page and len(heard) <= pages.MOST_RUNS
    shelf = []
    for one, picture in figures.gallery(heard):
        picture.write(one.folder if one else folder)
        if page and pages.belongs(one, picture.name, len(heard)):
            shelf.append((one, pages.exhibit(picture)))
    return shelf
