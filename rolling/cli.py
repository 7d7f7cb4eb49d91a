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
from typing import TYPE_CHECKING, Any

from rolling import __version__, _own_acoustics, defaults
from rolling.terminal import progress, streams, usage
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
    arguments, unknown = parser.parse_known_args(words)
    if unknown:
        usage.refuse_unknown_arguments(arguments.parser, unknown)
    if message := _own_acoustics.fault():
        _say(message)
        return BAD_INPUT
    try:
        with progress.begin(_level(arguments)):
            return int(arguments.command(arguments))
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


def _level(arguments: argparse.Namespace) -> Level:
    """Return how much the command says."""
    if arguments.quiet:
        return Level.QUIET
    return Level.VERBOSE if arguments.verbose else Level.NORMAL


def _is_bad_input(error: Exception) -> bool:
    """Tell whether an error lies in the scene or the folder that a command was given."""
    from rolling.folders.files import FolderError
    from rolling.scene.messages import SceneError

    return isinstance(error, SceneError | FolderError)


# ---- arguments of the commands


def _scene(sub: argparse.ArgumentParser) -> None:
    sub.add_argument(
        "scene",
        type=_path,
        metavar="SCENE",
        help="scene file (YAML), or a name of `rolling scenes`",
    )


def _folder(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("folder", type=_path, metavar="RUN", help="run folder")


def _settings(sub: argparse.ArgumentParser) -> None:
    sub.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="override, such as rolling.load_n=50",
    )


def _target(sub: argparse.ArgumentParser, default: str = "outputs/NAME/TIME") -> None:
    sub.add_argument(
        "--out", type=_path, metavar="FOLDER", help=f"run folder to make (default: {default})"
    )
    sub.add_argument(
        "--force",
        action="store_true",
        help="replace the run in --out, which stays beside it as OUT.previous until the new one"
        " is done",
    )


def _accuracy_target(sub: argparse.ArgumentParser) -> None:
    _target(sub, "outputs/NAME-accuracy/TIME")


def _workers(sub: argparse.ArgumentParser) -> None:
    sub.add_argument(
        "--workers", type=_count, default=0, metavar="N", help="processes (default: one per core)"
    )


def _drawn(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--no-report", action="store_true", help="write no report page")
    drawn = sub.add_mutually_exclusive_group()
    drawn.add_argument(
        "--pictures",
        action="store_const",
        const=True,
        help="write pictures and all other files of each run, also of more than"
        f" {defaults.MOST_RUNS_ON_PAGE} runs",
    )
    drawn.add_argument(
        "--no-pictures",
        action="store_const",
        const=False,
        dest="pictures",
        help="draw nothing: no pictures, none of their tables, no report page",
    )


def _reported_folders(sub: argparse.ArgumentParser) -> None:
    sub.add_argument(
        "folders", type=_path, nargs="+", metavar="RUN", help="run folder, of one run or of a sweep"
    )
    sub.add_argument(
        "--out",
        type=_path,
        metavar="FILE",
        help="page to write (default: RUN/report.html, of several RUN"
        " outputs/report/TIME/report.html)",
    )
    sub.add_argument("--force", action="store_true", help="replace the page in --out")


def _fast(sub: argparse.ArgumentParser) -> None:
    sub.add_argument(
        "--fast",
        action="store_true",
        help="solve no positions; use closed forms and estimates only",
    )


def _study(sub: argparse.ArgumentParser) -> None:
    sub.add_argument(
        "study",
        choices=("lee2025",),
        metavar="STUDY",
        help="lee2025: Lee, Kim & Kim, Inventions 10(1), 17",
    )
    sub.add_argument(
        "--readings", nargs="+", default=[], metavar="NAME", help="readings to run (default: all)"
    )
    sub.add_argument(
        "--quick",
        action="store_true",
        help=f"{defaults.QUICK_SEEDS} surface,"
        f" loads of {', '.join(map(str, defaults.QUICK_LOADS_N))} N,"
        f" {defaults.QUICK_SECONDS:g} s in steps {defaults.QUICK_STRIDES} times as long;"
        " without the outlook unless named",
    )
    sub.add_argument(
        "--out", type=_path, metavar="FOLDER", help="folder of the study (default: outputs/STUDY)"
    )


def _take_over(sub: argparse.ArgumentParser) -> None:
    sub.add_argument(
        "--take-over",
        action="store_true",
        help="go on although a process of another host is recorded; that process must have ended",
    )


def _trial(sub: argparse.ArgumentParser) -> None:
    sub.add_argument(
        "scene",
        type=_path,
        nargs="?",
        metavar="SCENE",
        help="scene file (YAML) or name, not with --hard",
    )
    sub.add_argument(
        "--finest",
        type=_power_of_two,
        metavar="N",
        help=f"divide the spacing by 2, 4, ... up to N (default {defaults.FINEST})",
    )
    sub.add_argument(
        "--duration",
        type=_seconds,
        metavar="S",
        help=f"seconds of rolling at most (default {defaults.ACCURACY_SECONDS:g}:"
        " no third octave from 100 Hz is empty)",
    )
    sub.add_argument("--hard", action="store_true", help="judge the solver on hard cases instead")
    random, part = defaults.RANDOM_SCENES, defaults.OTHER_SCENES
    sub.add_argument(
        "--random",
        type=_count,
        metavar="N",
        help=f"with --hard: N random scenes (default {random:,}),"
        f" and N/{part} odd and N/{part} blended ones"
        f" ({random + 2 * (random // part):,} in all by default)",
    )
    sub.add_argument(
        "--long",
        action="store_true",
        help=f"with --hard: the march of {defaults.LONG_STEPS:,} steps as well",
    )


def _volume(parser: argparse.ArgumentParser, default: Any) -> None:
    """Add the options that say more or less."""
    either = parser.add_mutually_exclusive_group()
    either.add_argument(
        "-q",
        "--quiet",
        action="store_true",
        default=default,
        help="print refusals, errors and the folder (or page) only",
    )
    either.add_argument(
        "-v",
        "--verbose",
        action="store_true",
        default=default,
        help="say more: pieces, windows, iterations and times",
    )


def _all(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--all", action="store_true", help="list the scenes of studies as well")


def _library_scene(sub: argparse.ArgumentParser) -> None:
    sub.add_argument(
        "name",
        nargs="?",
        default="quickstart",
        metavar="NAME",
        help="name of the scene (default: quickstart)",
    )


def _path(text: str) -> Path:
    if not text.strip():
        raise argparse.ArgumentTypeError("empty; is a variable of the shell not set?")
    return Path(text)


def _count(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError("at least 1")
    return value


def _power_of_two(text: str) -> int:
    value = _count(text)
    if value < 2 or value & (value - 1):
        raise argparse.ArgumentTypeError("2, 4, 8, ...")
    return value


def _seconds(text: str) -> float:
    value = float(text)
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError("more than 0")
    return value


# ---- commands


def _run(given: argparse.Namespace) -> int:
    from rolling import early

    early.refuse_scene(given.scene, given.set, given.out, given.force, ("run", "sweep"))
    with progress.step(LOADING):
        from rolling import commands
    return _reported(
        commands.run(
            given.scene,
            given.set,
            given.out,
            given.force,
            given.workers,
            not given.no_report,
            given.pictures,
            _print_folder,
        )
    )


def _resume(given: argparse.Namespace) -> int:
    from rolling import early

    early.refuse_folders([given.folder])
    with progress.step(LOADING):
        from rolling import commands
    return _reported(
        commands.resume(
            given.folder,
            given.workers,
            not given.no_report,
            given.take_over,
            given.pictures,
            _print_folder,
        )
    )


def _resound(given: argparse.Namespace) -> int:
    from rolling import early

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


def _report(arguments: argparse.Namespace) -> int:
    from rolling import early

    early.refuse_folders(arguments.folders)
    with progress.step(LOADING):
        from rolling import commands
    print(commands.report(arguments.folders, arguments.out, arguments.force))
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
    if not progress.is_quiet():
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
    return summary.table(rows)


def _print_files(report: Report) -> None:
    """Print the paths of the files that a person opens first, or the folder alone if quiet."""
    if progress.is_quiet():
        print(report.folder)
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


def _check(arguments: argparse.Namespace) -> int:
    from rolling import early

    scene = early.read_scene(arguments.scene, arguments.set)
    with progress.step(LOADING):
        from rolling.check.findings import check_scene
    findings = check_scene(scene, solve=not arguments.fast)
    if not progress.is_quiet():
        print(findings)
    for warning in findings.warnings if progress.is_quiet() else ():
        print(f"warning: {warning}")
    return OK


def _accuracy(arguments: argparse.Namespace) -> int:
    of_scene = {"SCENE": arguments.scene, "--set": arguments.set, "--finest": arguments.finest}
    of_scene |= {"--duration": arguments.duration, "--force": arguments.force}
    of_hard = {"--random": arguments.random, "--long": arguments.long}
    if misplaced := [
        name for name, given in (of_scene if arguments.hard else of_hard).items() if given
    ]:
        _say(
            f"rolling accuracy: {', '.join(misplaced)} {'cannot' if arguments.hard else 'can only'}"
            " go with --hard"
        )
        return BAD_INPUT
    if arguments.hard:
        return _hard_cases(arguments)
    if arguments.scene is None:
        _say("rolling accuracy: give a SCENE, or --hard")
        return BAD_INPUT

    from rolling import early

    early.refuse_scene(
        arguments.scene, arguments.set, arguments.out, arguments.force, ("accuracy",), first=True
    )
    with progress.step(LOADING):
        from rolling.accuracy import study
    given = {
        name: value
        for name in ("finest", "duration")
        if (value := getattr(arguments, name)) is not None
    }
    return study.run_study(
        arguments.scene, arguments.set, arguments.out, arguments.force, arguments.workers, **given
    )


def _hard_cases(arguments: argparse.Namespace) -> int:
    from rolling.check import cost
    from rolling.folders import new_folder, run_record

    target = new_folder.aim(Path("outputs") / "hard-cases", arguments.out, False, ["hard-cases"])
    with progress.step(LOADING):
        from rolling.verification import judge
    held = new_folder.make(target, run_record.new("hard-cases"))
    with held:
        workers = arguments.workers or cost.cores()
        random = arguments.random or defaults.RANDOM_SCENES
        code = judge.main_report(held.folder, random, workers, arguments.long)
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


def _scenes(arguments: argparse.Namespace) -> int:
    from rolling import tables
    from rolling.scene import library

    print(tables.columns(library.titles(arguments.all)))
    if not arguments.all:
        inner = len(library.scenes()) - len(library.titles())
        print(f"\n{inner} more scenes are of studies; `rolling scenes --all` lists them")
    return OK


def _init(arguments: argparse.Namespace) -> int:
    from rolling.scene import library

    try:
        written = library.copy(arguments.name, Path())
    except library.LibraryError as error:
        _say(str(error))
        return BAD_INPUT
    print(f"{' and '.join(map(str, written))} written; run it: rolling run {written[0]}")
    return OK


def _schema(arguments: argparse.Namespace) -> int:
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
        (_scene, _settings, _target, _workers, _drawn),
    ),
    _Command(
        "check",
        _check,
        "validate a scene, estimate its cost and name its doubtful numbers",
        (_scene, _settings, _fast),
    ),
    _Command(
        "resume",
        _resume,
        "continue an interrupted run",
        (_folder, _workers, _drawn, _take_over),
    ),
    _Command(
        "resound",
        _resound,
        "make a new sound from a stored run, without solving again",
        (_folder, _settings, _target, _drawn),
    ),
    _Command(
        "report",
        _report,
        "write one page to hear, see and read runs: a single HTML file that needs no network",
        (_reported_folders,),
    ),
    _Command(
        "accuracy",
        _accuracy,
        "speed against error: a scene on finer grids, with other edges, tolerances, steps; or the"
        " solver on hard cases",
        (_settings, _accuracy_target, _workers, _trial),
    ),
    _Command(
        "reproduce",
        _reproduce,
        "run the study of an article in several readings and answer for its statements; again:"
        " goes on where it stopped",
        (_study, _workers, _take_over),
    ),
    _Command("scenes", _scenes, "list the scenes that come with the program", (_all,)),
    _Command(
        "init",
        _init,
        "copy a scene that comes with the program into the current folder",
        (_library_scene,),
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
    _volume(parser, False)
    parsers = parser.add_subparsers(required=True, metavar="COMMAND")
    for command in _COMMANDS:
        sub = parsers.add_parser(command.name, help=command.text, description=command.text)
        sub.set_defaults(command=command.act, parser=sub)
        _volume(sub, argparse.SUPPRESS)  # a default would undo what stands before the command
        for part in command.parts:
            part(sub)
    return parser


if __name__ == "__main__":
    sys.exit(main())
