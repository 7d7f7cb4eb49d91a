"""Command line `rolling`: a function for each command.

Each command imports its modules itself, so that `--help` is instant.
"""

from __future__ import annotations

import argparse
import os
import shlex
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rolling import __version__, _own_acoustics
from rolling.terminal import (
    addresses,
    arguments,
    defaults,
    parser,
    progress,
    shortage,
    streams,
    system_errors,
)
from rolling.terminal.progress import Level

if TYPE_CHECKING:
    from rolling.run.budget import Budget

LOADING = "loading the program"  # with the solver in it, which takes seconds

# Exit codes
OK = 0
FAILED = 1
BAD_INPUT = 2
INTERRUPTED = 130


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code.

    The code is 0 when done, 1 after a failure or where a contact has no solution, 2 for a bad
    scene, path or usage, 130 when interrupted.
    """
    # The solve runs in several processes, and threads of libraries only slow them down.
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    # Escapes by which argparse colours its help would be printed as text.
    os.environ.setdefault("PYTHON_COLORS", "0")
    # Plugins of pydantic, which scenes do not use, would be searched in all packages.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "1")
    with streams.lasting() as (output, _):
        code = _run_command(argv)
        output.flush()
        if output.error is not None:
            _print_error(f"standard output: {output.error.strerror}; a part of the text is lost")
            code = code or FAILED
    return code


def _run_command(argv: Sequence[str] | None) -> int:
    """Parse the arguments and run their command; return the exit code."""
    command_line = parser.build(__version__)
    words = sys.argv[1:] if argv is None else list(argv)
    if not words:
        command_line.print_help()
        return OK
    arguments.refuse_unknown_command(command_line, words, list(COMMANDS))
    given, unknown = command_line.parse_known_args(words)
    try:
        addresses.refuse_few_for_libraries()
    except MemoryError as error:
        _print_error(str(error))
        return FAILED
    if unknown:
        _print_mistakes_of_scene(given)
        arguments.refuse_unknown_arguments(given.parser, unknown)
    if message := _own_acoustics.foreign_package():
        _print_error(message)
        return BAD_INPUT
    level = Level.NORMAL
    if given.quiet:
        level = Level.QUIET
    elif given.verbose:
        level = Level.VERBOSE
    try:
        with progress.begin(level), streams.plain_warnings():
            return COMMANDS[given.command](given)
    except KeyboardInterrupt:
        _print_error("interrupted")
        return INTERRUPTED
    except Exception as error:
        if shortage.is_of_memory(error):
            _print_error(shortage.sentence(error))
            return FAILED
        code = _code_of(error)
        if isinstance(error, OSError):
            _print_error(system_errors.sentence(error))
        else:
            _print_error(str(error))
        return code


def _print_mistakes_of_scene(given: argparse.Namespace) -> None:
    """Print the mistakes of the scene that a command names, before those of its options."""
    if "scene" not in given or _own_acoustics.foreign_package():
        return
    from rolling.kinds.reading import read_scene
    from rolling.scene.messages import SceneError

    try:
        read_scene(given.scene, given.overrides)
    except SceneError as error:
        _print_error(str(error))


def _code_of(error: Exception) -> int:
    """Return the exit code of an error that a user can mend, or raise another error."""
    from rolling.scene.messages import SceneError
    from rolling.terminal.whole_files import FolderError

    if isinstance(error, SceneError | FolderError):
        return BAD_INPUT
    if isinstance(error, OSError) and system_errors.is_of_a_place(error):
        # A path that cannot be used is bad input, unless it failed beneath the work.
        return FAILED if progress.has_solved() else BAD_INPUT
    if isinstance(error, OSError):  # the message names the files that are kept
        return FAILED
    from rolling.contact.solver import ContactError  # slow to import

    if isinstance(error, ContactError):
        return FAILED
    raise error


def _print_error(text: str) -> None:
    """Print a line for a person on the error stream, apart from the output."""
    print(text, file=sys.stderr)


# ---- commands: each imports what it needs, and returns the exit code


def _run(given: argparse.Namespace) -> int:
    """Run a scene of any kind."""
    scene = _read_scene(given)
    with progress.step(LOADING):
        from rolling.commands.run import run_scene
        from rolling.run.folder import default_folder
    failures = run_scene(
        scene,
        given.out or default_folder(scene),
        start_from=given.start_from,
        part=given.part,
        workers=given.workers,
        cluster=given.cluster,
        report=given.report,
        open=given.open,
    )
    return _code_of_failures(failures)


def _check(given: argparse.Namespace) -> int:
    """Check a scene, estimate its cost, and tell by the exit code whether it runs."""
    scene = _read_scene(given)
    with progress.step(LOADING):
        from rolling.kinds.registry import kind_of

        kind = kind_of(scene)
    findings = kind.check(scene, solve=not given.fast)
    if progress.is_quiet():
        for warning in findings.warnings:
            print(f"warning: {warning}")
    elif progress.is_verbose():
        print(f"{findings}\n\n{streams.folded(kind.conclusion(scene, findings), '')}")
    else:
        print("\n".join(kind.lines_in_short(scene, findings)))
    if findings.refusal is None:
        return OK
    if findings.refusal.key in ("memory", "disk"):
        return BAD_INPUT
    return FAILED  # a contact has no solution, as a run would find


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


def _table(given: argparse.Namespace) -> int:
    """Gather the numbers of a sweep."""
    with progress.step(LOADING):
        from rolling.commands.stored_runs import table
    return _print_paths(table(given.folder, given.numbers, given.against, given.over))


def _plot(given: argparse.Namespace) -> int:
    """Draw single figures of a run."""
    with progress.step(LOADING):
        from rolling.commands.stored_runs import plot
    paths = plot(given.folder, given.names, given.form, given.out)
    if not paths:  # a warning says why no picture could be drawn
        return FAILED
    return _print_paths(paths)


def _resound(given: argparse.Namespace) -> int:
    """Run a stored scene with another sound, speed or body."""
    with progress.step(LOADING):
        from rolling.commands.run import resound
    failures = resound(
        given.folder,
        given.overrides,
        given.out,
        workers=given.workers,
        report=given.report,
    )
    return _code_of_failures(failures)


def _report(given: argparse.Namespace) -> int:
    """Write the page of runs, or the sheets that people hand on."""
    if given.declare:
        with progress.step(LOADING):
            from rolling.commands.declare import declare
        return _print_paths(declare(given.run_folders, given.out))
    with progress.step(LOADING):
        from rolling.commands.stored_runs import report
    return _print_paths(report(given.run_folders, given.out))


def _gallery(given: argparse.Namespace) -> int:
    """Write one page of many runs."""
    with progress.step(LOADING):
        from rolling.commands.stored_runs import gallery
    return _print_paths(gallery(given.run_folders, given.out))


def _listen(given: argparse.Namespace) -> int:
    """Write a long record of a run."""
    with progress.step(LOADING):
        from rolling.commands.stored_runs import listen
    return _print_paths(
        listen(given.folder, given.seconds, given.speed, given.seed, given.reverberation)
    )


def _choose(given: argparse.Namespace) -> int:
    """Say which of some scenes is quieter."""
    _refuse_odd_choice(given)
    scenes = _scenes_of_one_kind(given)
    if given.improve:
        return _improve(scenes[0], given)
    if given.below is not None:
        return _below(scenes[0], given)
    with progress.step(LOADING):
        from rolling.choice.choose_command import print_choice, write_answer, write_choice
        from rolling.choice.choosing import choose_scenes
    choice = choose_scenes(
        scenes, given.out, _budget(given, defaults.WITHIN_DB), given.workers, keep=write_answer
    )
    choice = replace(choice, command=_repeating(given, choice.tried, choice.folder))
    write_choice(choice)
    print_choice(choice)
    return OK


def _scenes_of_one_kind(given: argparse.Namespace) -> list[Any]:
    """Read the scenes of a choice, which are of one kind."""
    from rolling.kinds.reading import read_scene
    from rolling.kinds.registry import name_of_file

    kinds = [name_of_file(path) for path in given.scenes]
    for path, kind in zip(given.scenes, kinds, strict=True):
        if kind != kinds[0]:
            given.parser.error(
                f"got {given.scenes[0]}, a scene of a {kinds[0]}, and {path}, of a {kind};"
                " allowed: scenes of one kind"
            )
    return [read_scene(path, given.overrides) for path in given.scenes]


def _budget(given: argparse.Namespace, within_db: float) -> Budget:
    """Return how long a choice goes on, to a usual ± [dB] where none is given."""
    from rolling.run.budget import Budget

    return Budget(within_db=given.within_db or within_db, minutes=given.minutes, pairs=given.pairs)


def _repeating(given: argparse.Namespace, pairs: int, folder: Path) -> str:
    """Return the command that gives the answer of a choice on some pairs again."""
    from acoustics.pairs import FEWEST_PAIRS

    words = ["rolling", "choose", *map(str, given.scenes)]
    for override in given.overrides:
        words += ["--set", override]
    if given.within_db is not None:
        words += ["--within", f"{given.within_db:g}"]
    if pairs >= FEWEST_PAIRS:  # otherwise nothing is random
        words += ["--pairs", str(pairs)]
    return shlex.join([*words, "--out", str(folder)])


def _refuse_odd_choice(given: argparse.Namespace) -> None:
    """Refuse options of a choice that do not go together."""
    option = "--improve" if given.improve else "--below"
    if given.improve or given.below is not None:
        if len(given.scenes) > 1:
            given.parser.error(f"{option}: got {len(given.scenes)} scenes, allowed: one")
    elif given.key is not None:
        given.parser.error("--key: only goes with --below, or with --improve")
    elif given.quantity is not None:
        given.parser.error("--quantity: only goes with --below, or with --improve")
    if given.below is not None and given.key is None:
        given.parser.error(
            "--below: needs --key, the value that is searched, such as"
            " --key surface.roughness_ra_um"
        )
    if given.below is not None and given.within_db is not None:
        given.parser.error("--within: does not go with --below, which hears twelve surfaces")
    if given.below is not None and given.pairs is not None:
        given.parser.error("--pairs: does not go with --below, which hears twelve surfaces")
    if given.between is not None and given.below is None:
        given.parser.error("--between: only goes with --below")


def _improve(scene: Any, given: argparse.Namespace) -> int:
    """Say what would make a scene quieter."""
    with progress.step(LOADING):
        from rolling.choice.choose_command import print_advice
        from rolling.choice.sensitivity import improve_scene, write_sensitivities
    sensitivities = improve_scene(
        scene=scene,
        folder=given.out,
        keys=None if given.key is None else [given.key],
        budget=_budget(given, defaults.IMPROVED_WITHIN_DB),
        workers=given.workers,
        quantity=given.quantity,
    )
    paths = write_sensitivities(sensitivities)
    print_advice(
        sensitivities.folder,
        sensitivities.conditions,
        sensitivities.sentences,
        sensitivities.lines,
        paths,
    )
    return OK


def _below(scene: Any, given: argparse.Namespace) -> int:
    """Find the coarsest value with which a scene stays below a level."""
    with progress.step(LOADING):
        from rolling.choice.choose_command import print_advice
        from rolling.choice.limit_search import coarsest_value, write_limit
    limit = coarsest_value(
        scene=scene,
        key=given.key,
        level_db=given.below,
        between=None if given.between is None else _ends(given.between),
        folder=given.out,
        workers=given.workers,
        quantity=given.quantity,
    )
    paths = write_limit(limit)
    print_advice(limit.folder, limit.conditions, limit.sentences, [], paths)
    return OK


def _design(given: argparse.Namespace) -> int:
    """Say which waves of a surface must be lower for a quieter scene."""
    scene = _read_scene(given)
    with progress.step(LOADING):
        from rolling.choice.choose_command import print_advice
        from rolling.choice.design_search import design_scene, write_design
    design = design_scene(
        scene=scene,
        quieter_db=given.quieter_db,
        folder=given.out,
        pairs=given.pairs,
        workers=given.workers,
    )
    paths = write_design(design)
    print_advice(design.folder, design.conditions, design.sentences, design.lines, paths)
    return OK


def _ends(texts: Sequence[str]) -> tuple[float | str, float | str]:
    """Return the ends of a range, numbers where the texts are numbers."""
    ends: list[float | str] = []
    for text in texts:
        try:
            ends.append(float(text))
        except ValueError:
            ends.append(text)
    return ends[0], ends[1]


def _compare(given: argparse.Namespace) -> int:
    """Compare a run with a recording, or all that the folder of a bench holds."""
    if given.recording is None:
        _refuse_options_of_bench(given)
    with progress.step(LOADING):
        from rolling.commands.compare import RecordedSeries, compare, compare_bench
        from rolling.recordings.series_files import FileLayout
    if given.recording is None:
        return _print_paths(compare_bench(given.folder))
    paths = compare(
        given.folder,
        given.recording,
        given.calibration,
        given.background,
        given.quantity,
        given.channels,
        RecordedSeries(
            layout=FileLayout(given.variables, given.rate),
            unit=given.unit,
            healthy=given.healthy,
            healthy_run=given.healthy_run,
            healthy_layout=FileLayout(given.healthy_variables, given.healthy_rate or given.rate),
        ),
    )
    return _print_paths(paths)


def _refuse_options_of_bench(given: argparse.Namespace) -> None:
    """Refuse options that a recording needs, where none is given."""
    for option in ("quantity", "calibration", "background", "unit", "rate", "healthy"):
        if getattr(given, option) is not None:
            given.parser.error(
                f"--{option}: only goes with a RECORDING; the folder of a bench says it by the"
                " names of its files and in calibration.txt"
            )
    for option, values in (("channel", given.channels), ("variable", given.variables)):
        if values:
            given.parser.error(f"--{option}: only goes with a RECORDING")


def _surface(given: argparse.Namespace) -> int:
    """Describe measured heights, or the surface of a scene."""
    with progress.step(LOADING):
        from rolling.commands.surface import surface
    paths = surface(
        given.source,
        given.overrides,
        given.spacing_um,
        given.channel,
        given.unit,
        given.xy_unit,
        along=given.along,
        instrument={
            "tip_radius_um": given.tip_radius_um,
            "sampling_um": given.sampling_um,
            "noise_nm": given.noise_nm,
        },
        l_filter_um=given.l_filter_um,
        save=given.save,
        out=given.out,
        declare=given.declare,
    )
    return _print_paths(paths)


def _accuracy(given: argparse.Namespace) -> int:
    """Study speed against error."""
    from rolling.scene.file import read_as
    from rolling.scene.scene import Scene

    scene = read_as(given.scene, Scene, given.overrides)
    with progress.step(LOADING):
        from rolling.studies.accuracy import run_study
    paths = run_study(scene, given.out, given.workers, given.finest, given.duration_s)
    return _print_paths(paths)


def _reproduce(given: argparse.Namespace) -> int:
    """Run the study of an article."""
    with progress.step(LOADING):
        from rolling.studies.lee2025 import reproduce
    return reproduce(given.readings, given.out, given.quick, given.workers)


def _validate(given: argparse.Namespace) -> int:
    """Compare the program with published results."""
    with progress.step(LOADING):
        from rolling.studies.validate import validate
    return validate(given.cases, given.out, given.benches)


def _scenes(given: argparse.Namespace) -> int:
    """List the scenes of the library."""
    from rolling.scene import library

    titles = library.titles(given.all)
    width = max(len(name) for name, _ in titles)
    for name, title in titles:
        print(streams.wrapped(f"{name:{width}}  {title}", " " * (width + 2)))
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
    """Print the JSON Schema of scenes, or of summary.json."""
    import json

    from rolling.kinds import reading
    from rolling.kinds.registry import kind_named, scene_types
    from rolling.numbers.summary_schema import summary_schema

    allowed = list(scene_types())
    if given.kind not in allowed:
        given.parser.error(f"--kind: got {given.kind}, allowed: {', '.join(allowed)}")
    if given.summary:
        schema = summary_schema(kind_named(given.kind).stored_type)
    else:
        schema = reading.schema(given.kind)
    print(json.dumps(schema, indent=2))
    return OK


COMMANDS: dict[str, Callable[[argparse.Namespace], int]] = {
    "run": _run,
    "check": _check,
    "status": _status,
    "table": _table,
    "plot": _plot,
    "resound": _resound,
    "report": _report,
    "gallery": _gallery,
    "listen": _listen,
    "choose": _choose,
    "design": _design,
    "compare": _compare,
    "surface": _surface,
    "accuracy": _accuracy,
    "reproduce": _reproduce,
    "validate": _validate,
    "scenes": _scenes,
    "init": _init,
    "schema": _schema,
}


def _read_scene(given: argparse.Namespace) -> Any:
    """Read the scene of a command with its overrides, before the solver is loaded."""
    from rolling.kinds.reading import read_scene

    return read_scene(given.scene, given.overrides)


def _code_of_failures(failures: Mapping[str, str]) -> int:
    """Print the runs that failed with their reasons, and return the exit code."""
    if not failures:
        return OK
    for label, reason in failures.items():
        _print_error(f"failed: {label}: {reason}")
    _print_error("the same command tries them again")
    return FAILED


def _print_paths(paths: Sequence[Path]) -> int:
    """Print the files that a command wrote, and return the exit code."""
    for path in paths:
        print(path)
    return OK


if __name__ == "__main__":
    sys.exit(main())
