"""Run a scene into a folder, or make new sound of the marches that a folder holds."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from acoustics.texts import printable
from rolling.commands.answers import print_answers
from rolling.commands.derived import prepare_page, write_derived_alone, write_first_page
from rolling.kinds.former_folder import refuse_former
from rolling.kinds.registry import kind_of
from rolling.kinds.run_folder import PAGE, RunFolder
from rolling.marches.piece import contact_identity
from rolling.run import folder as folders
from rolling.run.ending import Ending
from rolling.run.solving import runs_of_part, solve_folder
from rolling.scene.file import SET
from rolling.scene.messages import SceneError
from rolling.terminal import pages, progress
from rolling.terminal.whole_files import FolderError


def run_scene(
    scene: Any,
    folder: Path,
    *,
    start_from: Path | None = None,
    part: folders.Part | None = None,
    workers: int = 0,
    cluster: str | None = None,
    report: bool = True,
    open: bool = False,
) -> dict[str, str]:
    """Run a scene into a folder, or the part of it that the folder lacks.

    Parameters
    ----------
    scene : scene of any kind. The scene.
    folder : Path. Run folder.
    start_from : Path. Another run folder, whose equal marches are taken. Default: none.
    part : pair. Number K and count N: every N-th march from march K on. Default: all.
    workers : int. Number of processes; 0: one per core. Default: 0.
    cluster : str. Address of a Dask scheduler, whose workers solve. Default: none.
    report : bool. Whether page and figures are written. Default: true.
    open : bool. Whether the page is opened in a browser. Default: false.

    Returns
    -------
    failures : dict. Reasons by the label of each run that failed.

    Raises
    ------
    SceneError, FolderError : before anything is computed or written.
    OSError : a disk is full, or a cluster is gone; finished pieces are kept.
    KeyboardInterrupt : Ctrl-C or SIGTERM; finished pieces are kept.
    """
    with Ending(folder) as ending:
        if report and part is None:
            ending.first_page = write_first_page
            ending.prepare_page = prepare_page
        failures = solve_folder(
            scene,
            folder,
            start_from=start_from,
            part=part,
            workers=workers,
            cluster=cluster,
            ending=ending,
        )
        runs = folders.runs_in(folder, scene)
        write_derived_alone(ending, runs, report, part)
    _print_runs(folder, runs_of_part(runs, part))
    if open:
        pages.open_page(folder / PAGE)
    return failures


def resound(
    folder: Path,
    overrides: Sequence[str],
    out: Path | None = None,
    *,
    workers: int = 0,
    report: bool = True,
) -> dict[str, str]:
    """Run the scene of a run folder with other values, with the marches that are stored there.

    Parameters
    ----------
    folder : Path. The run folder.
    overrides : sequence of str. Assignments such as "sound.distance_m=2".
    out : Path. Run folder of the new runs. Default: outputs/NAME-DIGITS, which the scene decides.
    workers, report : as in `run_scene`.

    Returns
    -------
    failures : dict. Reasons by the label of each run that failed.

    Raises
    ------
    FolderError : nothing is solved in the run folder, or `out` holds another scene.
    SceneError : the overrides are not allowed, or need contacts that were not marched.
    """
    stored = [run for run in folders.stored_runs(folder) if run.is_done]
    if not stored:
        raise FolderError(f"{folder}: no run in it is done, so there is no march to take")
    refuse_former(stored)
    before = folders.stored_scene(folder)
    scene = kind_of(before).resound(before, overrides)
    refuse_other_contacts(before, scene, overrides)
    program = folders.made_by(stored[0].home)
    if program != folders.this_program():
        progress.line(f"{folder}: marched by {program}, heard by {folders.this_program()}")
    target = out or folders.default_folder(scene)
    with Ending(target) as ending:
        if report:
            ending.first_page = write_first_page
            ending.prepare_page = prepare_page
        failures = solve_folder(scene, target, sources=stored, workers=workers, ending=ending)
        runs = folders.runs_in(target, scene)
        write_derived_alone(ending, runs, report)
    _print_runs(target, runs)
    return failures


def refuse_other_contacts(before: Any, scene: Any, overrides: Sequence[str]) -> None:
    """Refuse overrides of a stored scene with which its runs need contacts that it has not.

    A key is named where it needs other contacts without the others; otherwise all of them are.
    """
    known = _contacts(before)
    if _contacts(scene) <= known:
        return
    kind = kind_of(before)
    alone = []
    for override in overrides:
        with suppress(SceneError):  # a value that is allowed beside the others only
            if not _contacts(kind.resound(before, [override])) <= known:
                alone.append(override)
    names = [override.partition("=")[0].strip() for override in alone or overrides]
    needed = "needs a new run, because its contacts are not those of the stored run"
    raise SceneError([f"{SET}: {name}: {needed}" for name in names])


def _contacts(scene: Any) -> set[str]:
    """Return the identities of the contacts that the runs of a scene march."""
    kind = kind_of(scene)
    return {contact_identity(march.scene) for _, run in scene.runs() for march in kind.marches(run)}


def _print_runs(folder: Path, runs: Sequence[RunFolder]) -> None:
    """Print the answer of runs and the files that a person opens first; the folder if quiet."""
    if progress.is_quiet():
        print(folder)
        return
    done = [run for run in runs if run.is_done]
    if not done:
        return
    kind = kind_of(done[0].scene)
    shown = print_answers(done)
    lines = [*kind.doubt_lines(shown), *kind.listen_lines(done)]
    if (folder / PAGE).is_file():
        lines.append(f"page: {printable(str(folder / PAGE))}")
    else:
        lines.append(f"folder: {printable(str(folder))}")
    if progress.is_verbose():
        lines += ["", *kind.further_lines(shown)]
    for line in lines:
        print(line)
