"""Command line `rolling`.

Each command imports its modules itself, so that `--help` is instant.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from rolling import __version__, _own_acoustics
from rolling.terminal import arguments, defaults, progress, streams, usage
from rolling.terminal.progress import Level

if TYPE_CHECKING:
    from rolling.commands import Report

LOADING = "loading the program"  # with the solver in it, which takes seconds
OK, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code.

    The code is 0 when done, 1 after a failure, 2 for a bad scene or usage, 130 when interrupted.
    """
    # The solve runs in several processes, and threads of libraries only slow them down.
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    # Plugins of pydantic, which scenes do not use, would be searched in all packages.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "1")
    with streams.lasting() as (output, _):
        code = _act(argv)
        output.flush()
        if output.error is not None:
            _say(f"standard output: {output.error.strerror}; a part of the text is lost")
            code = code or FAILED
    return code


def _act(argv: Sequence[str] | None) -> int:
    """Parse the arguments and run their command; return the exit code."""
    parser = _parser()
    words = sys.argv[1:] if argv is None else list(argv)
    if not words:
        parser.print_help()
        return OK
    usage.refuse_unknown_command(parser, words, [command.name for command in _COMMANDS])
    given, unknown = parser.parse_known_args(words)
    if unknown:
        usage.refuse_unknown_arguments(given.parser, unknown)
    if message := _own_acoustics.fault():
        _say(message)
        return BAD_INPUT
    try:
        with progress.begin(_level(given)):
            return int(given.command(given))
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return INTERRUPTED
    except OSError as error:  # the message names the files that are kept
        _say(str(error))
        return FAILED
    except Exception as error:
        if not _is_bad_input(error):
            raise
        _say(str(error))
        return BAD_INPUT


def _level(given: argparse.Namespace) -> Level:
    """Return how much the command says."""
    if given.quiet:
        return Level.QUIET
    return Level.VERBOSE if given.verbose else Level.NORMAL


def _is_bad_input(error: Exception) -> bool:
    """Tell whether an error lies in the scene or the folder that a command was given."""
    from rolling.folders.files import FolderError
    from rolling.scene.messages import SceneError

    return isinstance(error, SceneError | FolderError)


# ---- commands


def _run(given: argparse.Namespace) -> int:
    from rolling.check import early

    out = None if given.part else given.out  # parts share a folder
    early.refuse_scene(given.scene, given.set, out, given.force, ("run", "sweep"))
    with progress.step(LOADING):
        from rolling import commands
        from rolling.commands.parts import Part
        from rolling.simulation.cluster import Cluster
    report = commands.run(
        given.scene,
        given.set,
        given.out,
        given.force,
        given.workers,
        not given.no_report,
        given.pictures,
        _print_folder,
        Part(*given.part) if given.part else None,
        given.take_over,
        Cluster(given.cluster) if given.cluster else None,
    )
    code = _reported(report)
    if given.open:
        _open(report)
    return code


def _open(report: Report) -> None:
    """Open the page of a report in a browser, or say why not."""
    import webbrowser

    if report.page is None:
        _say("--open: there is no report page to open")
    elif not webbrowser.open(report.page.resolve().as_uri()):
        _say(f"--open: no browser was found; open {report.page} in one")


def _resume(given: argparse.Namespace) -> int:
    from rolling.check import early

    early.refuse_folders([given.folder])
    with progress.step(LOADING):
        from rolling import commands
        from rolling.simulation.cluster import Cluster
    return _reported(
        commands.resume(
            given.folder,
            given.workers,
            not given.no_report,
            given.take_over,
            given.pictures,
            _print_folder,
            Cluster(given.cluster) if given.cluster else None,
        )
    )


def _resound(given: argparse.Namespace) -> int:
    from rolling.check import early

    early.refuse_folders([given.folder])
    with progress.step(LOADING):
        from rolling import commands
    return _reported(
        commands.resound(
            given.folder,
            given.set,
            given.out,
            given.force,
            not given.no_report,
            given.pictures,
            _print_folder,
        )
    )


def _report(given: argparse.Namespace) -> int:
    from rolling.check import early

    early.refuse_folders(given.folders)
    with progress.step(LOADING):
        from rolling import commands
    print(commands.report(given.folders, given.out, given.force))
    return OK


def _extend(given: argparse.Namespace) -> int:
    from rolling.check import early

    early.refuse_folders([given.folder])
    with progress.step(LOADING):
        from rolling.commands import extending
    for written in extending.extend(given.folder, given.seconds):
        print(written.path)
        progress.line(f"{written.label}: {written.text}")
    return OK


def _status(given: argparse.Namespace) -> int:
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


def _table(given: argparse.Namespace) -> int:
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
    else:
        solved = (
            f"the solved part is in {report.folder}" if report.solved else "nothing is solved yet"
        )
        _say(f"stopped early; {solved}, `rolling resume {report.folder}` goes on")
    if report.previous:
        why = (
            "stays, because it is in use or holds files that this program did not write"
            if report.exit_code == OK
            else "stays until this run is done"
        )
        _say(f"{report.previous}, which this run replaces, {why}")
    return report.exit_code


def _print_levels(report: Report) -> None:
    """Print the table of levels with its caveats unless the command is quiet, then the failures."""
    if report.runs and not progress.is_quiet():
        print(_levels(report))
    for label, reason in report.failures.items():
        _say(f"failed: {label}: {reason}")


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


def _check(given: argparse.Namespace) -> int:
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


def _accuracy(given: argparse.Namespace) -> int:
    of_scene = {"SCENE": given.scene, "--set": given.set, "--finest": given.finest}
    of_scene |= {"--duration": given.duration, "--force": given.force}
    of_hard = {"--random": given.random, "--long": given.long}
    if misplaced := [
        name for name, chosen in (of_scene if given.hard else of_hard).items() if chosen
    ]:
        _say(
            f"rolling accuracy: {', '.join(misplaced)} {'cannot' if given.hard else 'can only'}"
            " go with --hard"
        )
        return BAD_INPUT
    if given.hard:
        return _hard_cases(given)
    if given.scene is None:
        _say("rolling accuracy: give a SCENE, or --hard")
        return BAD_INPUT

    from rolling.check import early

    goes_on = given.out is not None and not given.force and _goes_on(given.out)
    new = None if goes_on else given.out  # the study itself refuses another scene
    early.refuse_scene(given.scene, given.set, new, given.force, ("accuracy",), first=True)
    with progress.step(LOADING):
        from rolling.accuracy import study
    chosen = {
        name: value
        for name in ("finest", "duration")
        if (value := getattr(given, name)) is not None
    }
    return study.run_study(given.scene, given.set, given.out, given.force, given.workers, **chosen)


def _goes_on(folder: Path) -> bool:
    """Tell whether a folder holds a study of accuracy that was stopped."""
    from rolling.folders import new_folder

    return new_folder.is_unfinished(folder, "accuracy")


def _hard_cases(given: argparse.Namespace) -> int:
    from rolling.check import cost
    from rolling.folders import new_folder, run_record

    target = new_folder.aim(Path("outputs") / "hard-cases", given.out, False, ["hard-cases"])
    with progress.step(LOADING):
        from rolling.verification import judge
    held = new_folder.make(target, run_record.new("hard-cases"))
    with held:
        workers = given.workers or cost.cores()
        random = given.random or defaults.RANDOM_SCENES
        code = judge.main_report(held.folder, random, workers, given.long)
        held.mark(
            held.folder, "failed" if code else "done", "not every case holds" if code else None
        )
    print(held.folder if progress.is_quiet() else f"\ntable, numbers: {held.folder}")
    return code


def _reproduce(given: argparse.Namespace) -> int:
    with progress.step(LOADING):
        from rolling.lee2025 import reproduce
    done = reproduce.reproduce(
        given.study, given.readings, given.out, given.quick, given.workers, given.take_over
    )
    for case, reason in done.failures.items():
        _say(f"failed: {case}: {reason}")
    if done.interrupted:
        solved = f"the solved part is in {done.folder}" if done.begun else "nothing is solved yet"
        _say(f"stopped early; {solved}, the same command goes on")
        return done.exit_code
    if done.failures:
        _say(f"{len(done.failures)} cases failed; the statements are judged without them")
    if progress.is_quiet():
        print(done.folder)
        return done.exit_code
    print(f"{len(done.cases)} cases. {done.headline}")
    print(
        f"all on one page: {done.folder / reproduce.PAGE}   statements:"
        f" {done.folder / reproduce.CLAIMS}"
    )
    return done.exit_code


def _scenes(given: argparse.Namespace) -> int:
    from rolling import tables
    from rolling.scene import library

    print(tables.columns(library.titles(given.all)))
    if not given.all:
        inner = len(library.scenes()) - len(library.titles())
        print(f"\n{inner} more scenes are of studies; `rolling scenes --all` lists them")
    return OK


def _init(given: argparse.Namespace) -> int:
    from rolling.scene import library

    try:
        written = library.copy(given.name, Path())
    except library.LibraryError as error:
        _say(str(error))
        return BAD_INPUT
    print(f"{' and '.join(map(str, written))} written; run it: rolling run {written[0]}")
    return OK


def _schema(given: argparse.Namespace) -> int:
    import json

    from rolling.scene import file

    print(json.dumps(file.schema(), indent=2))
    return OK


def _say(text: str) -> None:
    """Print a line for a person on the error stream, apart from the output."""
    print(text, file=sys.stderr)


@dataclass(frozen=True)
class _Command:
    """Command of the command line.

    Attributes
    ----------
    name : str
        Name on the command line.
    act : callable
        Function that carries the command out and returns the exit code.
    text : str
        Description in `--help`.
    parts : tuple of callable
        Functions that add the arguments of the command to its parser. Default: none.
    """

    name: str
    act: Callable[[argparse.Namespace], int]
    text: str
    parts: tuple[Callable[[argparse.ArgumentParser], None], ...] = ()


_COMMANDS = (
    _Command(
        "run",
        _run,
        "run a scene: release, sound, levels and plots",
        (
            arguments.scene,
            arguments.settings,
            arguments.target,
            arguments.part,
            arguments.workers,
            arguments.cluster,
            arguments.drawn,
            arguments.opened,
            arguments.take_over,
        ),
    ),
    _Command(
        "check",
        _check,
        "validate a scene, estimate its cost and name its doubtful numbers",
        (arguments.scene, arguments.settings, arguments.fast),
    ),
    _Command(
        "resume",
        _resume,
        "continue an interrupted run",
        (
            arguments.folder,
            arguments.workers,
            arguments.cluster,
            arguments.drawn,
            arguments.take_over,
        ),
    ),
    _Command(
        "status",
        _status,
        "tell which runs of a folder are done, running (where), waiting or failed (why)",
        (arguments.folder, arguments.watch),
    ),
    _Command(
        "table",
        _table,
        "gather all numbers of a sweep, their statistics over the seeds, and plots of them",
        (arguments.folder, arguments.tabulated),
    ),
    _Command(
        "resound",
        _resound,
        "make a new sound from a stored run, without solving again",
        (arguments.folder, arguments.settings, arguments.target, arguments.drawn),
    ),
    _Command(
        "report",
        _report,
        "write one page to hear, see and read runs: a single HTML file that needs no network",
        (arguments.reported_folders,),
    ),
    _Command(
        "extend",
        _extend,
        "write a long record with the spectrum of a run's record, to listen to; it never repeats",
        (arguments.folder, arguments.extension),
    ),
    _Command(
        "accuracy",
        _accuracy,
        "speed against error: a scene on finer grids, with other edges, tolerances, steps; or the"
        " solver on hard cases",
        (arguments.settings, arguments.accuracy_target, arguments.workers, arguments.trial),
    ),
    _Command(
        "reproduce",
        _reproduce,
        "run the study of an article in several readings and answer for its statements; again:"
        " goes on where it stopped",
        (arguments.study, arguments.workers, arguments.take_over),
    ),
    _Command(
        "scenes", _scenes, "list the scenes that come with the program", (arguments.all_scenes,)
    ),
    _Command(
        "init",
        _init,
        "copy a scene that comes with the program into the current folder",
        (arguments.library_scene,),
    ),
    _Command("schema", _schema, "print the JSON Schema of scene files, for editors"),
)


def _parser() -> argparse.ArgumentParser:
    """Build the parser of the command line."""
    parser = argparse.ArgumentParser(
        prog="rolling", description="Contact noise of a sphere rolling over a rough surface."
    )
    parser.add_argument(
        "-V", "--version", action="version", version=f"rolling-contact-noise {__version__}"
    )
    arguments.volume(parser, False)
    parsers = parser.add_subparsers(required=True, metavar="COMMAND")
    for command in _COMMANDS:
        sub = parsers.add_parser(command.name, help=command.text, description=command.text)
        sub.set_defaults(command=command.act, parser=sub)
        arguments.volume(
            sub, argparse.SUPPRESS
        )  # a default would undo what stands before the command
        for part in command.parts:
            part(sub)
    return parser


if __name__ == "__main__":
    sys.exit(main())
