"""The command `rolling`. Each command imports its modules itself, so that --help is instant."""

from __future__ import annotations

import argparse
import io
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from rolling import __version__

if TYPE_CHECKING:
    from rolling.commands import Report

OK, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code: 0 done, 1 failed, 2 bad scene or usage, 130
    interrupted.
    """
    # The solve is cut into processes; threads of libraries only get in their way.
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    for stream in (sys.stdout, sys.stderr):
        # a folder's name may be no UTF-8, and a terminal may lack a sign
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    arguments = _parser().parse_args(argv)
    try:
        return int(arguments.command(arguments))
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:  # the reader of our output went away
        sys.stderr.close()
        return FAILED
    except OSError as error:  # the message says what is kept, where a run was under way
        _say(str(error))
        return FAILED
    except Exception as error:
        if not _is_bad_input(error):
            raise
        _say(str(error))
        return BAD_INPUT


def _is_bad_input(error: Exception) -> bool:
    """Return whether an error is of the scene or the folder that a command was given."""
    from rolling.folders.files import FolderError
    from rolling.scene.messages import SceneError

    return isinstance(error, SceneError | FolderError)


# ---- the arguments of the commands
# -----------------------------------------------------------------------------------


def _scene(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("scene", type=_path, metavar="SCENE", help="scene file (YAML)")


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
        help="replace the run in --out, which stays beside it as OUT.previous until the new one is done",
    )


def _accuracy_target(sub: argparse.ArgumentParser) -> None:
    _target(sub, "outputs/NAME-accuracy/TIME")


def _workers(sub: argparse.ArgumentParser) -> None:
    sub.add_argument(
        "--workers", type=_count, default=0, metavar="N", help="processes (default: one per core)"
    )


def _drawn(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--no-report", action="store_true", help="leave out the report page")
    drawn = sub.add_mutually_exclusive_group()
    drawn.add_argument(
        "--pictures",
        action="store_const",
        const=True,
        help="write pictures and all other files of each run, also of more than 24 runs",
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
        help="page to write (default: RUN/report.html, of several RUN outputs/report/TIME/report.html)",
    )
    sub.add_argument("--force", action="store_true", help="replace the page in --out")


def _fast(sub: argparse.ArgumentParser) -> None:
    sub.add_argument(
        "--fast", action="store_true", help="solve no positions: closed forms and estimates only"
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
        help="one surface, three loads, 0.015 s in steps of 6 um; without the outlook unless named",
    )
    sub.add_argument(
        "--out", type=_path, metavar="FOLDER", help="folder of the study (default: outputs/STUDY)"
    )


def _take_over(sub: argparse.ArgumentParser) -> None:
    sub.add_argument(
        "--take-over",
        action="store_true",
        help="go on although a process of another host is said to work on it: it must have ended",
    )


def _trial(sub: argparse.ArgumentParser) -> None:
    sub.add_argument(
        "scene", type=_path, nargs="?", metavar="SCENE", help="scene file (YAML), not with --hard"
    )
    sub.add_argument(
        "--finest",
        type=_power_of_two,
        metavar="N",
        help="divide the spacing by 2, 4, ... up to N (default 4)",
    )
    sub.add_argument(
        "--duration",
        type=_seconds,
        metavar="S",
        help="seconds of rolling at most (default 0.045: no third octave from 100 Hz is empty)",
    )
    sub.add_argument("--hard", action="store_true", help="judge the solver on hard cases instead")
    sub.add_argument(
        "--random", type=_count, metavar="N", help="with --hard: random scenes (default 2000)"
    )
    sub.add_argument(
        "--long", action="store_true", help="with --hard: the march of 1e5 steps as well"
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


# ---- the commands
# ----------------------------------------------------------------------------------------------------


def _run(given: argparse.Namespace) -> int:
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
    from rolling import commands

    print(commands.report(arguments.folders, arguments.out, arguments.force))
    return OK


def _print_folder(folder: Path) -> None:
    """Print where the files of a command will be, before it begins."""
    print(f"files: {folder}", flush=True)


def _reported(report: Report) -> int:
    """Print the outcome of a command that worked on a run folder."""
    _print_levels(report)
    if report.exit_code == OK:
        _print_files(report)
    else:
        solved = (
            f"what is solved is in {report.folder}" if report.solved else "nothing is solved yet"
        )
        _say(f"stopped early; {solved}, `rolling resume {report.folder}` goes on")
    if report.previous:
        why = (
            "holds what this program did not write, or is in use, and stays"
            if report.exit_code == OK
            else "stays until this one is done"
        )
        _say(f"{report.previous}, which this run replaces, {why}")
    return report.exit_code


def _print_levels(report: Report) -> None:
    """Print the table of levels with its caveats, then the failures."""
    from rolling.simulation import labels, summary

    names = labels.labels([run for run, _ in report.runs])
    rows = [
        (label, str(run.folder), numbers)
        for label, (run, numbers) in zip(names, report.runs, strict=True)
    ]
    print(summary.table(rows))
    for label, reason in report.failures.items():
        _say(f"failed: {label}: {reason}")


def _print_files(report: Report) -> None:
    """Print where the files are that a person opens first."""
    first = report.runs[0][0].folder
    record = "listen.wav" if (first / "listen.wav").is_file() else "signal.wav"
    print(f"\nlisten: {first / record}   all files: {report.folder}")
    if len(report.runs) > 1:
        print(f"a row per run: {report.folder / 'runs.csv'}")
    if report.page:
        print(f"all on one page: {report.page}")


def _check(arguments: argparse.Namespace) -> int:
    from rolling.check import findings
    from rolling.scene import file

    print(
        findings.check_scene(
            file.read_scene(arguments.scene, arguments.set), solve=not arguments.fast
        )
    )
    return OK


def _accuracy(arguments: argparse.Namespace) -> int:
    of_scene = {"SCENE": arguments.scene, "--set": arguments.set, "--finest": arguments.finest}
    of_scene |= {"--duration": arguments.duration, "--force": arguments.force}
    of_hard = {"--random": arguments.random, "--long": arguments.long}
    if misplaced := [
        name for name, given in (of_scene if arguments.hard else of_hard).items() if given
    ]:
        _say(
            f"rolling accuracy: {', '.join(misplaced)} {'cannot' if arguments.hard else 'can only'} go with --hard"
        )
        return BAD_INPUT
    if arguments.hard:
        return _hard_cases(arguments)
    if arguments.scene is None:
        _say("rolling accuracy: give a SCENE, or --hard")
        return BAD_INPUT

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
    from rolling.verification import judge

    target = new_folder.aim(Path("outputs") / "hard-cases", arguments.out, False, ["hard-cases"])
    held = new_folder.make(target, run_record.new("hard-cases"))
    with held:
        workers = arguments.workers or cost.cores()
        code = judge.main_report(held.folder, arguments.random or 2000, workers, arguments.long)
        held.mark(
            held.folder, "failed" if code else "done", "not every case holds" if code else None
        )
    print(f"\ntable, numbers: {held.folder}")
    return code


def _reproduce(given: argparse.Namespace) -> int:
    from rolling.lee2025 import reproduce

    done = reproduce.reproduce(
        given.study, given.readings, given.out, given.quick, given.workers, given.take_over
    )
    for case, reason in done.failures.items():
        _say(f"failed: {case}: {reason}")
    if done.interrupted:
        _say(f"stopped early; what is solved is in {done.folder}, the same command goes on")
        return done.exit_code
    if done.failures:
        _say(f"{len(done.failures)} cases failed; the statements are judged without them")
    print(f"{len(done.cases)} cases. {done.headline}")
    print(
        f"all on one page: {done.folder / reproduce.PAGE}   statements: {done.folder / reproduce.CLAIMS}"
    )
    return done.exit_code


def _schema(arguments: argparse.Namespace) -> int:
    import json

    from rolling.scene import file

    print(json.dumps(file.schema(), indent=2))
    return OK


def _say(text: str) -> None:
    """Print a line for a person, apart from the output."""
    print(text, file=sys.stderr)


@dataclass(frozen=True)
class _Command:
    """A command of the command line.

    act : does it and returns the exit code.
    parts : add its arguments to its parser.
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
        "validate a scene and say what it will cost and where it is doubtful",
        (_scene, _settings, _fast),
    ),
    _Command(
        "resume",
        _resume,
        "go on with a run that was interrupted",
        (_folder, _workers, _drawn, _take_over),
    ),
    _Command(
        "resound",
        _resound,
        "new sound from a stored run, without solving again",
        (_folder, _settings, _target, _drawn),
    ),
    _Command(
        "report",
        _report,
        "one page to hear, see and read runs: a single HTML file that needs no network",
        (_reported_folders,),
    ),
    _Command(
        "accuracy",
        _accuracy,
        "speed against error: a scene on finer grids, with other edges, tolerances, steps; or the solver on hard cases",
        (_settings, _accuracy_target, _workers, _trial),
    ),
    _Command(
        "reproduce",
        _reproduce,
        "run the study of an article in several readings and answer for its statements; again: goes on where it stopped",
        (_study, _workers, _take_over),
    ),
    _Command("schema", _schema, "print the JSON Schema of scene files, for editors"),
)


def _parser() -> argparse.ArgumentParser:
    """Build the parser of the command line."""
    parser = argparse.ArgumentParser(
        prog="rolling", description="Contact noise of a sphere rolling over a rough surface."
    )
    parser.add_argument(
        "--version", action="version", version=f"rolling-contact-noise {__version__}"
    )
    parsers = parser.add_subparsers(required=True, metavar="COMMAND")
    for command in _COMMANDS:
        sub = parsers.add_parser(command.name, help=command.text, description=command.text)
        sub.set_defaults(command=command.act)
        for part in command.parts:
            part(sub)
    return parser


if __name__ == "__main__":
    sys.exit(main())
