"""Command line `rolling`: its parser, and a function for each command.

Each command imports its modules itself, so that `--help` is instant.
"""

import argparse
import os
import sys
import time
from collections.abc import Callable, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path

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
    arguments.refuse_unknown_command(parser, words)
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
    except Exception as error:
        code = _code_of(error)
        _say(str(error) or "not enough memory; take fewer workers or nodes")
        return code


def _code_of(error: Exception) -> int:
    """Return the exit code of an error that a user can mend, or raise another error."""
    from rolling.scene.messages import SceneError
    from rolling.terminal.files import FolderError

    if isinstance(error, SceneError | FolderError):
        return BAD_INPUT
    if isinstance(error, OSError | MemoryError):  # the message names the files that are kept
        return FAILED
    from rolling.contact.solver import ContactError  # slow to import

    if isinstance(error, ContactError):
        return FAILED
    raise error


def _say(text: str) -> None:
    """Print a line for a person on the error stream, apart from the output."""
    print(text, file=sys.stderr)


# ---- commands


def _call(name: str, given: argparse.Namespace) -> int:
    """Call the function of a command, read its scene before; print its failures or its files."""
    own = ("command", "parser", "quiet", "verbose", "study")
    keywords = {key: value for key, value in vars(given).items() if key not in own}
    if "scene" in keywords:  # before the solver is loaded
        from rolling.scene import file

        keywords["scene"] = file.read_scene(given.scene, keywords.pop("overrides"))
    module, function = arguments.COMMANDS[name].get("call", f"rolling.commands:{name}").split(":")
    with progress.step(LOADING):
        act = getattr(import_module(module), function)
    result = act(**keywords)
    if isinstance(result, int):
        return result
    failures = result if isinstance(result, dict) else {}
    for label, reason in failures.items():
        _say(f"failed: {label}: {reason}")
    if failures:
        _say("the same command tries them again")
    for path in result if isinstance(result, list) else ():
        print(path)
    return FAILED if failures else OK


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


def _check(given: argparse.Namespace) -> int:
    """Check a scene and estimate its cost."""
    from rolling.scene import file

    scene = file.read_scene(given.scene, given.overrides)
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

    written = library.copy(given.name, Path())
    print(f"{' and '.join(map(str, written))} written; run it: rolling run {written[0]}")
    return OK


def _schema(given: argparse.Namespace) -> int:
    """Print the JSON Schema of scenes."""
    import json

    from rolling.scene import file

    print(json.dumps(file.schema(), indent=2))
    return OK


_ACTS: dict[str, Callable[[argparse.Namespace], int]] = {
    act.__name__.removeprefix("_"): act for act in (_check, _status, _scenes, _init, _schema)
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
    for name, command in arguments.COMMANDS.items():
        sub = parsers.add_parser(name, help=command["help"], description=command["help"])
        sub.set_defaults(command=_ACTS.get(name, partial(_call, name)), parser=sub)
        arguments.add_volume(sub, argparse.SUPPRESS)  # which keeps an option before the command
        arguments.add(sub, name)
    return parser


if __name__ == "__main__":
    sys.exit(main())
