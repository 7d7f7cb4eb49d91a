"""Actions of the command line: a function for each command, which returns the exit code.

Each imports its modules itself, so that `--help` is instant.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from rolling.terminal import defaults, progress

if TYPE_CHECKING:
    from rolling.commands import Report, Wanted

LOADING = "loading the program"  # with the solver in it, which takes seconds
OK, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130


def run(given: argparse.Namespace) -> int:
    """Run a scene, or a part of its sweep."""
    from rolling.check import early
    from rolling.folders import files

    out = None if given.part else given.out  # parts share a folder
    early.refuse_scene(given.scene, given.set, out, given.force, ("run", "sweep"))
    if given.part and (given.out is None or given.force):
        raise files.FolderError(
            "a part needs the folder of all parts, --out FOLDER without --force"
        )
    with progress.step(LOADING):
        from rolling import commands
    wanted = _wanted(given, given.workers, given.cluster)
    if given.part:
        part = commands.Part(*given.part)
        report = commands.run_part(given.scene, given.set, given.out, part, wanted, given.take_over)
    else:
        report = commands.run(given.scene, given.set, given.out, given.force, wanted)
    code = _reported(report)
    if given.open:
        _open(report)
    return code


def _wanted(given: argparse.Namespace, workers: int = 0, scheduler: str | None = None) -> Wanted:
    """Return the files that a command is asked for, and who makes them."""
    from rolling import commands
    from rolling.simulation.cluster import Cluster

    cluster = Cluster(scheduler) if scheduler else None
    return commands.Wanted(not given.no_report, given.pictures, workers, _print_folder, cluster)


def _open(report: Report) -> None:
    """Open the page of a report in a browser, or say why not."""
    import webbrowser

    if report.page is None:
        say("--open: there is no report page to open")
    elif not webbrowser.open(report.page.resolve().as_uri()):
        say(f"--open: no browser was found; open {report.page} in one")


def resume(given: argparse.Namespace) -> int:
    """Continue a run folder."""
    from rolling.check import early

    early.refuse_folders([given.folder])
    with progress.step(LOADING):
        from rolling import commands
    wanted = _wanted(given, given.workers, given.cluster)
    return _reported(commands.resume(given.folder, wanted, given.take_over))


def resound(given: argparse.Namespace) -> int:
    """Make new sound from a run folder."""
    from rolling.check import early

    early.refuse_folders([given.folder])
    with progress.step(LOADING):
        from rolling import commands
    return _reported(
        commands.resound(given.folder, given.set, given.out, given.force, _wanted(given))
    )


def report(given: argparse.Namespace) -> int:
    """Write a page of run folders."""
    from rolling.check import early

    early.refuse_folders(given.folders)
    with progress.step(LOADING):
        from rolling import commands
    print(commands.report(given.folders, given.out, given.force))
    return OK


def extend(given: argparse.Namespace) -> int:
    """Write extended records of a run folder."""
    from rolling.check import early

    early.refuse_folders([given.folder])
    with progress.step(LOADING):
        from rolling.commands import extending
    for written in extending.extend(given.folder, given.seconds):
        print(written.path)
        progress.line(f"{written.label}: {written.text}")
    return OK


def status(given: argparse.Namespace) -> int:
    """Print the states of the runs of a folder."""
    from rolling.folders import status

    if given.watch:
        return _watched(given.folder)
    print(status.text(given.folder))
    return OK


def _watched(folder: Path) -> int:
    """Print the status of a run folder whenever it changes, until no run is waiting or running."""
    import time

    from rolling.folders import status

    before = ""
    while True:
        text = status.text(folder)
        if text != before:
            print(text, flush=True)
        before = text
        if status.is_at_rest(status.statuses(folder)):
            return OK
        time.sleep(defaults.WATCH_SECONDS)


def table(given: argparse.Namespace) -> int:
    """Write the tables and plots of a sweep."""
    from rolling.check import early

    early.refuse_folders([given.folder])
    with progress.step(LOADING):
        from rolling.commands import table
    over = {} if given.over is None else {"over": given.over}
    for path in table.tabulate(given.folder, given.plot, given.against, **over):
        print(path)
    return OK


def _print_folder(folder: Path) -> None:
    """Print the folder of a command before it begins, unless the command is quiet."""
    if not progress.is_quiet():
        print(f"files: {folder}", flush=True)


def _reported(report: Report) -> int:
    """Print the outcome of a command that worked on a run folder."""
    if report.finished_before:
        progress.line(f"{report.folder}: finished {report.finished_before}, nothing to resume")
    _print_levels(report)
    if report.exit_code == OK:
        _print_files(report)
    elif report.unmade and not (report.failures or report.interrupted):
        say(f"all runs are solved; `rolling resume {report.folder}` makes the rest")
    else:
        solved = (
            f"the solved part is in {report.folder}" if report.solved else "nothing is solved yet"
        )
        say(f"stopped early; {solved}, `rolling resume {report.folder}` goes on")
    if report.previous:
        why = (
            "stays, because it is in use or holds files that this program did not write"
            if report.exit_code == OK
            else "stays until this run is done"
        )
        say(f"{report.previous}, which this run replaces, {why}")
    return report.exit_code


def _print_levels(report: Report) -> None:
    """Print the table of levels with its caveats unless the command is quiet, then the failures."""
    if report.runs and not progress.is_quiet():
        print(_levels(report))
    for label, reason in report.failures.items():
        say(f"failed: {label}: {reason}")
    for text in report.unmade:
        say(f"not made: {text}")


def _levels(report: Report) -> str:
    """Return the table of levels with its caveats."""
    from rolling.simulation import labels, summary

    names = labels.labels([run for run, _ in report.runs])
    rows = [
        (label, str(run.folder), numbers)
        for label, (run, numbers) in zip(names, report.runs, strict=True)
    ]
    if len(rows) <= defaults.MOST_RUNS_COMPARED:
        return summary.table(rows)
    shown = defaults.FEW_RUNS
    return f"{summary.table(rows[:shown])}\n{len(rows) - shown} more runs, a row each in runs.csv"


def _print_files(report: Report) -> None:
    """Print the paths of the files that a person opens first, or the folder alone if quiet."""
    if progress.is_quiet():
        print(report.folder)
        return
    if not report.runs:  # a part beyond the last run of its sweep
        return
    first = report.runs[0][0].folder
    record = "listen.wav" if (first / "listen.wav").is_file() else "signal.wav"
    print(f"\nlisten: {first / record}   all files: {report.folder}")
    if len(report.runs) > 1:
        print(f"a row per run: {report.folder / 'runs.csv'}")
    if report.page:
        print(f"all on one page: {report.page}")
    elif report.finished_before:
        print(f"no page: `rolling report {report.folder}` makes one")


def check(given: argparse.Namespace) -> int:
    """Check a scene and estimate its cost."""
    from rolling.check import early

    scene = early.read_scene(given.scene, given.set)
    with progress.step(LOADING):
        from rolling.check.findings import check_scene
    findings = check_scene(scene, solve=not given.fast)
    if not progress.is_quiet():
        print(findings)
    for warning in findings.warnings if progress.is_quiet() else ():
        print(f"warning: {warning}")
    return OK


def accuracy(given: argparse.Namespace) -> int:
    """Study speed against error of a scene."""
    from rolling.check import early

    early.read_scene(given.scene, given.set)
    with progress.step(LOADING):
        from rolling.accuracy import study
        from rolling.contact.solver import ContactError
    try:
        study.measure_accuracy(
            given.scene, given.set, given.out, given.workers, given.finest, given.duration
        )
    except ContactError as error:
        say(str(error))
        return FAILED
    return OK


def reproduce(given: argparse.Namespace) -> int:
    """Reproduce a study."""
    with progress.step(LOADING):
        from rolling.lee2025 import reproduce
    done = reproduce.reproduce(
        given.study, given.readings, given.out, given.quick, given.workers, given.take_over
    )
    for case, reason in done.failures.items():
        say(f"failed: {case}: {reason}")
    if done.interrupted:
        solved = f"the solved part is in {done.folder}" if done.begun else "nothing is solved yet"
        say(f"stopped early; {solved}, the same command goes on")
        return done.exit_code
    if done.failures:
        say(f"{len(done.failures)} cases failed; the statements are judged without them")
    if progress.is_quiet():
        print(done.folder)
        return done.exit_code
    print(f"{len(done.cases)} cases. {done.headline}")
    print(
        f"all on one page: {done.folder / reproduce.PAGE}   statements:"
        f" {done.folder / reproduce.CLAIMS}"
    )
    return done.exit_code


def scenes(given: argparse.Namespace) -> int:
    """List the scenes of the library."""
    from rolling import tables
    from rolling.scene import library

    print(tables.columns(library.titles(given.all)))
    if not given.all:
        inner = len(library.scenes()) - len(library.titles())
        print(f"\n{inner} more scenes are of studies; `rolling scenes --all` lists them")
    return OK


def init(given: argparse.Namespace) -> int:
    """Copy a scene of the library."""
    from rolling.scene import library

    try:
        written = library.copy(given.name, Path())
    except library.LibraryError as error:
        say(str(error))
        return BAD_INPUT
    print(f"{' and '.join(map(str, written))} written; run it: rolling run {written[0]}")
    return OK


def schema(given: argparse.Namespace) -> int:
    """Print the JSON Schema of scenes."""
    import json

    from rolling.scene import file

    print(json.dumps(file.schema(), indent=2))
    return OK


def say(text: str) -> None:
    """Print a line for a person on the error stream, apart from the output."""
    print(text, file=sys.stderr)
