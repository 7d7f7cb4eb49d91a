"""Command line `rolling`: its parser, and a function for each command.

Each command imports its modules itself, so that `--help` is instant.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from rolling import __version__, _own_acoustics
from rolling.terminal import arguments, defaults, progress, streams
from rolling.terminal.progress import Level

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
    arguments.refuse_unknown_command(parser, words, [*_COMMANDS])
    given, unknown = parser.parse_known_args(words)
    if unknown:
        arguments.refuse_unknown_arguments(given.parser, unknown)
    if message := _own_acoustics.fault():
        _say(message)
        return BAD_INPUT
    level = Level.QUIET if given.quiet else Level.VERBOSE if given.verbose else Level.NORMAL
    try:
        with progress.begin(level):
            return int(given.command(given))
    except KeyboardInterrupt:
        _say("interrupted")
        return INTERRUPTED
    except OSError as error:  # the message names the files that are kept
        _say(str(error))
        return FAILED
    except Exception as error:
        if not _is_bad_input(error):
            raise
        _say(str(error))
        return BAD_INPUT


def _is_bad_input(error: Exception) -> bool:
    """Return whether an error lies in the scene or the folder that a command was given."""
    from rolling.scene.messages import SceneError
    from rolling.terminal.files import FolderError

    return isinstance(error, SceneError | FolderError)


def _say(text: str) -> None:
    """Print a line for a person on the error stream, apart from the output."""
    print(text, file=sys.stderr)


# ---- commands


def _run(given: argparse.Namespace) -> int:
    """Run a scene, or a part of its sweep."""
    from rolling.scene import file

    scene = file.read_scene(given.scene, given.set)  # before the solver is loaded
    with progress.step(LOADING):
        from rolling import commands
    folder = given.out or commands.default_folder(scene)
    failures = commands.run_scene(
        scene,
        out=folder,
        part=given.part,
        workers=given.workers,
        cluster=given.cluster,
        report=not given.no_report,
    )
    if given.open:
        _open(folder / "report.html")
    return _code(failures)


def _open(page: Path) -> None:
    """Open a report page in a browser, or say why not."""
    import webbrowser

    if not page.is_file():
        _say("--open: there is no report page to open")
    elif not webbrowser.open(page.resolve().as_uri()):
        _say(f"--open: no browser was found; open {page} in one")


def _code(failures: dict[str, str]) -> int:
    """Print the runs that failed; return the exit code."""
    for label, reason in failures.items():
        _say(f"failed: {label}: {reason}")
    if failures:
        _say("the same command tries them again")
    return FAILED if failures else OK


def _resound(given: argparse.Namespace) -> int:
    """Run the scene of a run folder with other values, with the marches stored there."""
    with progress.step(LOADING):
        from rolling import commands
    return _code(
        commands.resound(
            given.folder, given.set, given.out, workers=given.workers, report=not given.no_report
        )
    )


def _status(given: argparse.Namespace) -> int:
    """Print the states of the runs of a folder, with --watch until all are at rest."""
    from rolling.run import folder

    before = ""
    while True:
        text = folder.status(given.folder)
        if text != before:
            print(text, flush=True)
        if not given.watch or folder.is_at_rest(given.folder):
            return OK
        before = text
        time.sleep(defaults.WATCH_SECONDS)


def _report(given: argparse.Namespace) -> int:
    """Write a page of run folders."""
    with progress.step(LOADING):
        from rolling import commands
    print(commands.report(given.folders, given.out))
    return OK


def _table(given: argparse.Namespace) -> int:
    """Write the tables and plots of a sweep."""
    with progress.step(LOADING):
        from rolling import commands
    for path in commands.tabulate(given.folder, given.plot, given.against, given.over):
        print(path)
    return OK


def _plot(given: argparse.Namespace) -> int:
    """Draw single figures of a run."""
    with progress.step(LOADING):
        from rolling import commands
    for path in commands.plot(given.folder, given.figure, given.format, given.out):
        print(path)
    return OK


def _surface(given: argparse.Namespace) -> int:
    """Describe a surface of a file or a scene."""
    with progress.step(LOADING):
        from rolling import commands
    height_keys = given.spacing_um, given.channel, given.height_unit
    commands.surface(given.source, given.set, *height_keys, save=given.save, out=given.out)
    return OK


def _listen(given: argparse.Namespace) -> int:
    """Write a long record of a run, which goes on beyond its solved track."""
    with progress.step(LOADING):
        from rolling import commands
    print(commands.listen(given.folder, given.seconds, given.speed, given.seed))
    return OK


def _check(given: argparse.Namespace) -> int:
    """Check a scene and estimate its cost."""
    from rolling.scene import file

    scene = file.read_scene(given.scene, given.set)
    with progress.step(LOADING):
        from rolling.check.findings import check_scene
    findings = check_scene(scene, solve=not given.fast)
    if not progress.is_quiet():
        from rolling.results import verdict

        print(findings)
        print(f"\n{streams.wrapped(verdict.conclusion(scene, findings), '')}")
    for warning in findings.warnings if progress.is_quiet() else ():
        print(f"warning: {warning}")
    return OK


def _accuracy(given: argparse.Namespace) -> int:
    """Study speed against error."""
    from rolling.scene import file

    scene = file.read_scene(given.scene, given.set)
    with progress.step(LOADING):
        from rolling.accuracy import study
        from rolling.contact.solver import ContactError
    try:
        print(study.run_study(scene, given.out, given.workers, given.finest, given.duration))
    except ContactError as error:
        _say(str(error))
        return FAILED
    return OK


def _reproduce(given: argparse.Namespace) -> int:
    """Reproduce a study."""
    with progress.step(LOADING):
        from rolling.lee2025 import reproduce
    return reproduce.reproduce(given.readings, given.out, given.quick, given.workers)


def _scenes(given: argparse.Namespace) -> int:
    """List the scenes of the library."""
    from rolling.scene import library

    titles = library.titles(given.all)
    width = max(len(name) for name, _ in titles)
    for name, title in titles:
        print(f"{name:{width}}  {title}")
    if not given.all:
        inner = len(library.scenes()) - len(titles)
        print(f"\n{inner} more scenes are of studies; `rolling scenes --all` lists them")
    return OK


def _init(given: argparse.Namespace) -> int:
    """Copy a scene of the library."""
    from rolling.scene import library

    try:
        written = library.copy(given.name, Path())
    except library.LibraryError as error:
        _say(str(error))
        return BAD_INPUT
    print(f"{' and '.join(map(str, written))} written; run it: rolling run {written[0]}")
    return OK


def _schema(given: argparse.Namespace) -> int:
    """Print the JSON Schema of scenes."""
    import json

    from rolling.scene import file

    print(json.dumps(file.schema(), indent=2))
    return OK


class _Command(NamedTuple):
    """Command: its function, its text in `--help`, and the names of its arguments."""

    act: Callable[[argparse.Namespace], int]
    text: str
    names: Sequence[str] = ()


_COMMANDS = {
    "run": _Command(
        _run,
        "run a scene: release, sound, levels and page; again: goes on, or adds runs of its sweep",
        (
            *("scene", "--set", "--out", "--part"),
            *("--workers", "--cluster", "--no-report", "--open"),
        ),
    ),
    "check": _Command(
        _check,
        "validate a scene, estimate its cost and name its doubtful numbers",
        ("scene", "--set", "--fast"),
    ),
    "status": _Command(
        _status,
        "tell which runs of a folder are done, running, waiting or failed (why)",
        ("folder", "--watch"),
    ),
    "table": _Command(
        _table,
        "gather all numbers of a sweep, their statistics over the seeds, and plots of them",
        ("folder", "--plot", "--against", "--over"),
    ),
    "plot": _Command(
        _plot,
        "draw single figures of a run as PNG or SVG, or write their numbers as CSV",
        ("folder", "--figure", "--format", "--out"),
    ),
    "resound": _Command(
        _resound,
        "run a stored scene with another sound, speed or body; stored marches are not solved again",
        ("folder", "--set", "--out", "--workers", "--no-report"),
    ),
    "report": _Command(
        _report,
        "write one page to hear, see and read runs: a single HTML file that needs no network",
        ("folders", "--out"),
    ),
    "listen": _Command(
        _listen,
        "write a long record of a run: the ball rolls on beyond the solved track, over a random"
        " continuation of it, at any speed",
        ("folder", "--seconds", "--speed", "--seed"),
    ),
    "surface": _Command(
        _surface,
        "describe measured heights, or the surface of a scene: parameters of ISO 25178-2, picture",
        ("source", "--set", *("--spacing-um", "--channel", "--height-unit"), "--save", "--out"),
    ),
    "accuracy": _Command(
        _accuracy,
        "speed against error: a scene on finer grids, with other edges, tolerances and steps",
        ("scene", "--set", "--out", "--workers", "--finest", "--duration"),
    ),
    "reproduce": _Command(
        _reproduce,
        "run the study of an article in several readings and answer for its statements; again:"
        " goes on where it stopped",
        ("study", "--readings", "--quick", "--out", "--workers"),
    ),
    "scenes": _Command(_scenes, "list the scenes that come with the program", ("--all",)),
    "init": _Command(
        _init, "copy a scene that comes with the program into the current folder", ("name",)
    ),
    "schema": _Command(_schema, "print the JSON Schema of scene files, for editors"),
}
_OUT = {
    "run": "run folder (default: outputs/NAME-DIGITS); again: goes on there",
    "report": "page to write (default: RUN/report.html)",
    "reproduce": "folder of the study (default: outputs/STUDY); again: goes on there",
    "plot": "folder of the files (default: RUN/figures)",
    "surface": "folder of picture and table (default: outputs/NAME-surface)",
}


def _parser() -> argparse.ArgumentParser:
    """Build the parser of the command line."""
    parser = argparse.ArgumentParser(
        prog="rolling", description="Contact noise of a sphere rolling over a rough surface."
    )
    parser.add_argument(
        "-V", "--version", action="version", version=f"rolling-contact-noise {__version__}"
    )
    arguments.add_volume(parser, False)
    parsers = parser.add_subparsers(required=True, metavar="COMMAND")
    for name, command in _COMMANDS.items():
        sub = parsers.add_parser(name, help=command.text, description=command.text)
        sub.set_defaults(command=command.act, parser=sub)
        arguments.add_volume(sub, argparse.SUPPRESS)  # which keeps an option before the command
        arguments.add(sub, command.names, **{"out": _OUT[name]} if name in _OUT else {})
    return parser


if __name__ == "__main__":
    sys.exit(main())
