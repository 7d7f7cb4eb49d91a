"""Command line `rolling`."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from rolling import __version__, _own_acoustics, actions
from rolling.actions import BAD_INPUT, FAILED, INTERRUPTED, OK, say
from rolling.terminal import arguments, progress, streams, usage
from rolling.terminal.progress import Level


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
            say(f"standard output: {output.error.strerror}; a part of the text is lost")
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
        say(message)
        return BAD_INPUT
    try:
        with progress.begin(_level(given)):
            return int(given.command(given))
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return INTERRUPTED
    except OSError as error:  # the message names the files that are kept
        say(str(error))
        return FAILED
    except Exception as error:
        if not _is_bad_input(error):
            raise
        say(str(error))
        return BAD_INPUT


def _level(given: argparse.Namespace) -> Level:
    """Return the detail in which the command reports."""
    if given.quiet:
        return Level.QUIET
    return Level.VERBOSE if given.verbose else Level.NORMAL


def _is_bad_input(error: Exception) -> bool:
    """Tell whether an error lies in the scene or the folder that a command was given."""
    from rolling.folders.files import FolderError
    from rolling.scene.messages import SceneError

    return isinstance(error, SceneError | FolderError)


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
        actions.run,
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
        actions.check,
        "validate a scene, estimate its cost and name its doubtful numbers",
        (arguments.scene, arguments.settings, arguments.fast),
    ),
    _Command(
        "resume",
        actions.resume,
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
        actions.status,
        "tell which runs of a folder are done, running (where), waiting or failed (why)",
        (arguments.folder, arguments.watch),
    ),
    _Command(
        "table",
        actions.table,
        "gather all numbers of a sweep, their statistics over the seeds, and plots of them",
        (arguments.folder, arguments.tabulated),
    ),
    _Command(
        "resound",
        actions.resound,
        "make a new sound from a stored run, without solving again",
        (arguments.folder, arguments.settings, arguments.target, arguments.drawn),
    ),
    _Command(
        "report",
        actions.report,
        "write one page to hear, see and read runs: a single HTML file that needs no network",
        (arguments.reported_folders,),
    ),
    _Command(
        "extend",
        actions.extend,
        "write a long record with the spectrum of a run's record, to listen to; it never repeats",
        (arguments.folder, arguments.extension),
    ),
    _Command(
        "accuracy",
        actions.accuracy,
        "speed against error: a scene on finer grids, with other edges, tolerances and steps",
        (
            arguments.scene,
            arguments.settings,
            arguments.accuracy_target,
            arguments.workers,
            arguments.trial,
        ),
    ),
    _Command(
        "reproduce",
        actions.reproduce,
        "run the study of an article in several readings and answer for its statements; again:"
        " goes on where it stopped",
        (arguments.study, arguments.workers, arguments.take_over),
    ),
    _Command(
        "scenes",
        actions.scenes,
        "list the scenes that come with the program",
        (arguments.all_scenes,),
    ),
    _Command(
        "init",
        actions.init,
        "copy a scene that comes with the program into the current folder",
        (arguments.library_scene,),
    ),
    _Command("schema", actions.schema, "print the JSON Schema of scene files, for editors"),
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
        )  # a default would undo an option before the command
        for part in command.parts:
            part(sub)
    return parser


if __name__ == "__main__":
    sys.exit(main())
