"""Arguments of the command line: each function adds the arguments of a subject to a parser."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from rolling.terminal import defaults


def scene(sub: argparse.ArgumentParser) -> None:
    """Add the scene file of a command."""
    sub.add_argument(
        "scene",
        type=_path,
        metavar="SCENE",
        help="scene file (YAML), or a name of `rolling scenes`",
    )


def folder(sub: argparse.ArgumentParser) -> None:
    """Add a run folder."""
    sub.add_argument("folder", type=_path, metavar="RUN", help="run folder")


def settings(sub: argparse.ArgumentParser) -> None:
    """Add values of keys, `--set`."""
    sub.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="override, such as rolling.load_n=50",
    )


def target(sub: argparse.ArgumentParser, default: str = "outputs/NAME/TIME") -> None:
    """Add the folder to make, `--out` and `--force`."""
    sub.add_argument(
        "--out", type=_path, metavar="FOLDER", help=f"run folder to make (default: {default})"
    )
    _flag(
        sub,
        "--force",
        "replace the run in --out, which stays beside it as OUT.previous until the new one is done",
    )


def part(sub: argparse.ArgumentParser) -> None:
    """Add the share of a sweep."""
    sub.add_argument(
        "--part",
        type=_part,
        metavar="K/N",
        help="do every N-th run of a sweep from run K on, in an --out that the commands of all"
        " parts share: for array jobs",
    )


def accuracy_target(sub: argparse.ArgumentParser) -> None:
    """Add the folder of an accuracy study."""
    sub.add_argument(
        "--out",
        type=_path,
        metavar="FOLDER",
        help="folder of the study (default: outputs/NAME-accuracy-ID)",
    )


def workers(sub: argparse.ArgumentParser) -> None:
    """Add the number of processes."""
    sub.add_argument(
        "--workers", type=_count, default=0, metavar="N", help="processes (default: one per core)"
    )


def cluster(sub: argparse.ArgumentParser) -> None:
    """Add the scheduler of a cluster."""
    sub.add_argument(
        "--cluster",
        metavar="ADDRESS",
        help="solve on the workers of a Dask scheduler: its address, or its scheduler file (.json)",
    )


def drawn(sub: argparse.ArgumentParser) -> None:
    """Add the choice of pictures and page."""
    _flag(sub, "--no-report", "write no report page")
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


def opened(sub: argparse.ArgumentParser) -> None:
    """Add the option that opens the page."""
    _flag(sub, "--open", "open the report page in a browser")


def reported_folders(sub: argparse.ArgumentParser) -> None:
    """Add run folders and the file of their page."""
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
    _flag(sub, "--force", "replace the page in --out")


def extension(sub: argparse.ArgumentParser) -> None:
    """Add the length of an extended record."""
    sub.add_argument(
        "--seconds",
        type=_seconds,
        default=defaults.EXTENDED_SECONDS,
        metavar="S",
        help=f"length of the record to make (default {defaults.EXTENDED_SECONDS:g}), up to"
        f" {defaults.MOST_EXTENDED_SECONDS:g}",
    )


def fast(sub: argparse.ArgumentParser) -> None:
    """Add the check that solves nothing."""
    _flag(sub, "--fast", "solve no positions; use closed forms and estimates only")


def study(sub: argparse.ArgumentParser) -> None:
    """Add a study and the part that is run."""
    sub.add_argument(
        "study",
        choices=("lee2025",),
        metavar="STUDY",
        help="lee2025: Lee, Kim & Kim, Inventions 10(1), 17",
    )
    sub.add_argument(
        "--readings", nargs="+", default=[], metavar="NAME", help="readings to run (default: all)"
    )
    _flag(
        sub,
        "--quick",
        f"{defaults.QUICK_SEEDS} surface,"
        f" loads of {', '.join(map(str, defaults.QUICK_LOADS_N))} N,"
        f" {defaults.QUICK_SECONDS:g} s in steps {defaults.QUICK_STRIDES} times as long;"
        " without the outlook unless named",
    )
    sub.add_argument(
        "--out", type=_path, metavar="FOLDER", help="folder of the study (default: outputs/STUDY)"
    )


def take_over(sub: argparse.ArgumentParser) -> None:
    """Add the claim on a folder of another process."""
    _flag(
        sub,
        "--take-over",
        "go on although a process of another host is recorded; that process must have ended",
    )


def watch(sub: argparse.ArgumentParser) -> None:
    """Add the choice to follow a folder."""
    _flag(
        sub, "--watch", "print the status again when it changes, until no run is waiting or running"
    )


def tabulated(sub: argparse.ArgumentParser) -> None:
    """Add the numbers that are plotted, and the keys that they are plotted against."""
    sub.add_argument(
        "--plot",
        nargs="+",
        default=[],
        metavar="NUMBER",
        help="columns of runs.csv to plot (default: laeq_db)",
    )
    sub.add_argument(
        "--against",
        nargs="+",
        default=[],
        metavar="KEY",
        help="a swept key for lines, or two for a map (default: the first swept key)",
    )
    sub.add_argument(
        "--over",
        metavar="KEY",
        help="the swept key over which statistics are made (default: surface.seed)",
    )


def trial(sub: argparse.ArgumentParser) -> None:
    """Add the finest grid and the duration of an accuracy study."""
    sub.add_argument(
        "--finest",
        type=_power_of_two,
        default=defaults.FINEST,
        metavar="N",
        help=f"divide the spacing by 2, 4, ... up to N (default {defaults.FINEST})",
    )
    sub.add_argument(
        "--duration",
        type=_seconds,
        default=defaults.ACCURACY_SECONDS,
        metavar="S",
        help=f"seconds of rolling at most (default {defaults.ACCURACY_SECONDS:g}:"
        " no third octave from 100 Hz is empty)",
    )


def volume(parser: argparse.ArgumentParser, default: Any) -> None:
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


def all_scenes(sub: argparse.ArgumentParser) -> None:
    """Add the list of all scenes."""
    _flag(sub, "--all", "list the scenes of studies as well")


def library_scene(sub: argparse.ArgumentParser) -> None:
    """Add the name of a scene of the library."""
    sub.add_argument(
        "name",
        nargs="?",
        default="quickstart",
        metavar="NAME",
        help="name of the scene (default: quickstart)",
    )


def _flag(sub: argparse.ArgumentParser, name: str, text: str) -> None:
    """Add an option without a value."""
    sub.add_argument(name, action="store_true", help=text)


def _path(text: str) -> Path:
    if not text.strip():
        raise argparse.ArgumentTypeError("empty; is a variable of the shell not set?")
    return Path(text)


def _count(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError("at least 1")
    return value


def _part(text: str) -> tuple[int, int]:
    number, slash, count = text.partition("/")
    if not (slash and number.isdecimal() and count.isdecimal() and 1 <= int(number) <= int(count)):
        raise argparse.ArgumentTypeError(
            f"got {text!r}, allowed: K/N, such as 3/40, with K from 1 to N"
        )
    return int(number), int(count)


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
