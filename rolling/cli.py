"""The command `rolling`. Imports what a command needs inside it, so that --help is instant."""

from __future__ import annotations

import argparse
import io
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rolling import __version__

OK, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code: 0 done, 1 failed, 2 bad scene or usage, 130 interrupted."""
    # The solve is cut into processes; libraries that start threads of their own only get in their way.
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # a folder's name may be no UTF-8, and a terminal may lack a sign
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


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="rolling", description="Contact noise of a sphere rolling over a rough surface."
    )
    parser.add_argument("--version", action="version", version=f"rolling-contact-noise {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def command(name: str, function: Any, text: str, *parts: Any) -> Any:
        sub = commands.add_parser(name, help=text, description=text)
        sub.set_defaults(command=function)
        for part in parts:
            part(sub)

    def scene(sub: argparse.ArgumentParser) -> None:
        sub.add_argument("scene", type=_path, metavar="SCENE", help="scene file (YAML)")

    def folder(sub: argparse.ArgumentParser) -> None:
        sub.add_argument("folder", type=_path, metavar="RUN", help="run folder")

    def settings(sub: argparse.ArgumentParser) -> None:
        sub.add_argument(
            "--set", action="append", default=[], metavar="KEY=VALUE", help="override, such as rolling.load_n=50"
        )

    def target(sub: argparse.ArgumentParser, default: str = "outputs/NAME/TIME") -> None:
        sub.add_argument("--out", type=_path, metavar="FOLDER", help=f"run folder to make (default: {default})")
        sub.add_argument(
            "--force",
            action="store_true",
            help="replace the run in --out, which stays beside it as OUT.previous until the new one is done",
        )

    def workers(sub: argparse.ArgumentParser) -> None:
        sub.add_argument("--workers", type=_count, default=0, metavar="N", help="processes (default: one per core)")

    def page(sub: argparse.ArgumentParser) -> None:
        sub.add_argument("--no-report", action="store_true", help="leave out the report page (of 24 runs at most)")

    def pages(sub: argparse.ArgumentParser) -> None:
        sub.add_argument("folders", type=_path, nargs="+", metavar="RUN", help="run folder, of one run or of a sweep")
        sub.add_argument(
            "--out",
            type=_path,
            metavar="FILE",
            help="page to write (default: RUN/report.html, of several RUN outputs/report/TIME/report.html)",
        )
        sub.add_argument("--force", action="store_true", help="replace the page in --out")

    def fast(sub: argparse.ArgumentParser) -> None:
        sub.add_argument("--fast", action="store_true", help="solve no positions: closed forms and estimates only")

    def studied(sub: argparse.ArgumentParser) -> None:
        sub.add_argument(
            "study", choices=("lee2025",), metavar="STUDY", help="lee2025: Lee, Kim & Kim, Inventions 10(1), 17"
        )
        sub.add_argument("--readings", nargs="+", default=[], metavar="NAME", help="readings to run (default: all)")
        sub.add_argument(
            "--quick",
            action="store_true",
            help="one surface, three loads, 0.015 s in steps of 6 um; without the outlook unless named",
        )
        sub.add_argument("--out", type=_path, metavar="FOLDER", help="folder of the study (default: outputs/STUDY)")

    def claimed(sub: argparse.ArgumentParser) -> None:
        sub.add_argument(
            "--take-over",
            action="store_true",
            help="go on although a process of another host is said to work on it: it must have ended",
        )

    def trial(sub: argparse.ArgumentParser) -> None:
        sub.add_argument("scene", type=_path, nargs="?", metavar="SCENE", help="scene file (YAML), not with --hard")
        sub.add_argument(
            "--finest", type=_power_of_two, metavar="N", help="divide the spacing by 2, 4, ... up to N (default 4)"
        )
        sub.add_argument(
            "--duration",
            type=_seconds,
            metavar="S",
            help="seconds of rolling at most (default 0.045: no third octave from 100 Hz is empty)",
        )
        sub.add_argument("--hard", action="store_true", help="judge the solver on hard cases instead")
        sub.add_argument("--random", type=_count, metavar="N", help="with --hard: random scenes (default 2000)")
        sub.add_argument("--long", action="store_true", help="with --hard: the march of 1e5 steps as well")

    command("run", _run, "run a scene: release, sound, levels and plots", scene, settings, target, workers, page)
    command(
        "check", _check, "validate a scene and say what it will cost and where it is doubtful", scene, settings, fast
    )
    command("resume", _resume, "go on with a run that was interrupted", folder, workers, page, claimed)
    command("resound", _resound, "new sound from a stored run, without solving again", folder, settings, target, page)
    command("report", _report, "one page to hear, see and read runs: a single HTML file that needs no network", pages)
    command(
        "accuracy",
        _accuracy,
        "speed against error: a scene on finer grids, with other edges, tolerances, steps; or the solver on hard cases",
        settings,
        lambda sub: target(sub, "outputs/NAME-accuracy/TIME"),
        workers,
        trial,
    )
    command(
        "reproduce",
        _reproduce,
        "run the study of an article in several readings and answer for its statements; again: goes on where it stopped",
        studied,
        workers,
        claimed,
    )
    command("schema", _schema, "print the JSON Schema of scene files, for editors")
    return parser


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


def _run(arguments: argparse.Namespace) -> int:
    from rolling import commands as run

    a = arguments
    return _reported(lambda: run.run(a.scene, a.set, a.out, a.force, a.workers, not a.no_report), not a.no_report)


def _resume(arguments: argparse.Namespace) -> int:
    from rolling import commands as run

    a = arguments
    return _reported(lambda: run.resume(a.folder, a.workers, not a.no_report, a.take_over), not a.no_report)


def _resound(arguments: argparse.Namespace) -> int:
    from rolling import commands as run

    a = arguments
    return _reported(lambda: run.resound(a.folder, a.set, a.out, a.force, not a.no_report), not a.no_report)


def _report(arguments: argparse.Namespace) -> int:
    from rolling import commands as run
    from rolling.folders.files import FolderError
    from rolling.scene.scene import SceneError

    try:
        print(run.report(arguments.folders, arguments.out, arguments.force))
    except (SceneError, FolderError) as error:
        _say(str(error))
        return BAD_INPUT
    return OK


def _reported(act: Any, page: bool) -> int:
    from rolling.folders.files import FolderError
    from rolling.scene.scene import SceneError
    from rolling.simulation import labels, summary

    try:
        report = act()
    except (SceneError, FolderError) as error:
        _say(str(error))
        return BAD_INPUT
    names = labels.labels([one for one, _ in report.runs])
    rows = [(label, str(one.folder), numbers) for label, (one, numbers) in zip(names, report.runs, strict=True)]
    print(summary.table(rows))
    for label, reason in report.failures.items():
        _say(f"failed: {label}: {reason}")
    if report.exit_code == OK:
        print(f"\nlisten: {report.runs[0][0].folder / 'listen.wav'}   pictures, numbers: {report.folder}")
        if report.page:
            print(f"all on one page: {report.page}")
        elif page:
            print(
                f"{len(report.runs)} runs are too many for a page: `rolling report RUN...` makes one of those to compare"
            )
    else:
        solved = f"what is solved is in {report.folder}" if report.solved else "nothing is solved yet"
        _say(f"stopped early; {solved}, `rolling resume {report.folder}` goes on")
    if report.previous:
        why = (
            "holds what this program did not write, or is in use, and stays"
            if report.exit_code == OK
            else "stays until this one is done"
        )
        _say(f"{report.previous}, which this run replaces, {why}")
    return report.exit_code


def _check(arguments: argparse.Namespace) -> int:
    from rolling.check import findings
    from rolling.scene import file
    from rolling.scene.scene import SceneError

    try:
        print(findings.report(file.load(arguments.scene, arguments.set), arguments.fast))
    except SceneError as error:
        _say(str(error))
        return BAD_INPUT
    return OK


def _accuracy(arguments: argparse.Namespace) -> int:
    of_scene = {"SCENE": arguments.scene, "--set": arguments.set, "--finest": arguments.finest}
    of_scene |= {"--duration": arguments.duration, "--force": arguments.force}
    of_hard = {"--random": arguments.random, "--long": arguments.long}
    if misplaced := [name for name, given in (of_scene if arguments.hard else of_hard).items() if given]:
        _say(f"rolling accuracy: {', '.join(misplaced)} {'cannot' if arguments.hard else 'can only'} go with --hard")
        return BAD_INPUT
    if arguments.hard:
        return _hard_cases(arguments)
    if arguments.scene is None:
        _say("rolling accuracy: give a SCENE, or --hard")
        return BAD_INPUT

    from rolling.accuracy import study
    from rolling.folders.files import FolderError
    from rolling.scene.scene import SceneError

    given = {name: value for name in ("finest", "duration") if (value := getattr(arguments, name)) is not None}
    try:
        return study.report(arguments.scene, arguments.set, arguments.out, arguments.force, arguments.workers, **given)
    except (SceneError, FolderError) as error:
        _say(str(error))
        return BAD_INPUT


def _hard_cases(arguments: argparse.Namespace) -> int:
    from rolling.check import cost
    from rolling.folders import new_folder, run_record
    from rolling.folders.files import FolderError
    from rolling.verification import judge

    try:
        target = new_folder.aim(Path("outputs") / "hard-cases", arguments.out, False, ["hard-cases"])
        held = new_folder.make(target, run_record.new("hard-cases"))
    except FolderError as error:
        _say(str(error))
        return BAD_INPUT
    with held:
        workers = arguments.workers or cost.cores()
        code = judge.main_report(held.folder, arguments.random or 2000, workers, arguments.long)
        held.mark(held.folder, "failed" if code else "done", "not every case holds" if code else None)
    print(f"\ntable, numbers: {held.folder}")
    return code


def _reproduce(arguments: argparse.Namespace) -> int:
    from rolling.folders.files import FolderError
    from rolling.lee2025 import reproduce
    from rolling.scene.scene import SceneError

    a = arguments
    try:
        done = reproduce.reproduce(a.study, a.readings, a.out, a.quick, a.workers, a.take_over)
    except (SceneError, FolderError) as error:
        _say(str(error))
        return BAD_INPUT
    for case, reason in done.failures.items():
        _say(f"failed: {case}: {reason}")
    if done.interrupted:
        _say(f"stopped early; what is solved is in {done.folder}, the same command goes on")
        return done.exit_code
    if done.failures:
        _say(f"{len(done.failures)} cases failed; the statements are judged without them")
    print(f"{len(done.cases)} cases. {done.headline}")
    print(f"all on one page: {done.folder / reproduce.PAGE}   statements: {done.folder / reproduce.CLAIMS}")
    return done.exit_code


def _schema(arguments: argparse.Namespace) -> int:
    import json

    from rolling.scene import file

    print(json.dumps(file.schema(), indent=2))
    return OK


def _say(text: str) -> None:
    print(text, file=sys.stderr)


if __name__ == "__main__":
    sys.exit(main())
