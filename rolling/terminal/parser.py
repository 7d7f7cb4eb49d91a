"""Parser of the command line `rolling`: a function for each command adds its arguments.

The parser imports nothing heavy, so that `--help` is instant. `build` sets `command`, the name of
the command, and `parser`, the parser of the command, beside the arguments.
"""

from __future__ import annotations

import argparse
from typing import Any

from rolling.terminal import arguments, defaults

LONG_SCENE = "scene file (YAML), or a name of `rolling scenes`"


def build(version: str) -> argparse.ArgumentParser:
    """Build the parser of the command line.

    Parameters
    ----------
    version : str
        Version that `--version` prints.

    Returns
    -------
    argparse.ArgumentParser
    """
    parser = argparse.ArgumentParser(
        prog="rolling",
        description="What does a ball sound like that rolls over a rough surface?",
        epilog="A first run: rolling run quickstart --open. Help on a command: rolling run -h.",
    )
    parser.add_argument(
        "-V", "--version", action="version", version=f"rolling-contact-noise {version}"
    )
    _add_volume(parser, default=False)
    commands = parser.add_subparsers(required=True, metavar="COMMAND", title="commands")
    _add_scenes(commands)
    _add_init(commands)
    _add_check(commands)
    _add_run(commands)
    _add_status(commands)
    _add_table(commands)
    _add_plot(commands)
    _add_resound(commands)
    _add_report(commands)
    _add_gallery(commands)
    _add_listen(commands)
    _add_choose(commands)
    _add_design(commands)
    _add_compare(commands)
    _add_surface(commands)
    _add_accuracy(commands)
    _add_reproduce(commands)
    _add_validate(commands)
    _add_schema(commands)
    return parser


# ---- one function for each command


def _add_run(commands: Any) -> None:
    run = _command(
        commands,
        name="run",
        help="run a scene: two numbers, sounds, pictures, one page",
        answer="What does this scene sound like? The command writes its two numbers, "
        "sounds, pictures and a page into a folder. The same command again goes on "
        "where it stopped, and adds new runs of its sweep.",
    )
    _add_scene(run)
    _add_out(run, help="run folder (default: outputs/NAME-DIGITS)")
    run.add_argument(
        "--from",
        dest="start_from",
        type=arguments.path,
        metavar="FOLDER",
        help="another run folder, whose marches of equal contacts are taken",
    )
    run.add_argument(
        "--part",
        type=arguments.part,
        metavar="K/N",
        help="for array jobs: do part K of N of a sweep, in a folder that all parts share",
    )
    _add_workers(run)
    run.add_argument(
        "--cluster",
        metavar="ADDRESS",
        help="solve on the workers of a Dask scheduler: its address, or its scheduler file (.json)",
    )
    _add_no_report(run)
    run.add_argument("--open", action="store_true", help="open the report page in a browser")


def _add_check(commands: Any) -> None:
    check = _command(
        commands,
        name="check",
        help="say before a run whether it runs and what to doubt",
        answer="Does the scene run, for how long, and what will be doubtful? The command "
        "solves a few positions; -v prints all quantities.",
    )
    _add_scene(check)
    check.add_argument(
        "--fast",
        action="store_true",
        help="solve nothing, and estimate by closed forms only",
    )


def _add_status(commands: Any) -> None:
    status = _command(
        commands,
        name="status",
        help="say which runs of a folder are done or failed",
        answer="Which runs of a folder are done, running or waiting, and why did one fail?",
    )
    _add_folder(status)
    status.add_argument(
        "--watch",
        action="store_true",
        help="print the status at each change, until no run is waiting or running",
    )


def _add_table(commands: Any) -> None:
    table = _command(
        commands,
        name="table",
        help="tabulate and plot the runs of a sweep",
        answer="How do the numbers of a sweep depend on its keys, and how far do they "
        "scatter over the seeds? The command writes runs.csv, statistics.csv and "
        "plots.",
    )
    _add_folder(table)
    table.add_argument(
        "--plot",
        dest="numbers",
        nargs="+",
        default=[],
        metavar="NUMBER",
        help="columns of runs.csv to plot (default: vibration_db and released_power_db)",
    )
    table.add_argument(
        "--against",
        nargs="+",
        default=[],
        metavar="KEY",
        help="a swept key for lines, or two for a map (default: the first swept key)",
    )
    table.add_argument(
        "--over",
        metavar="KEY",
        default="surface.seed",
        help="the swept key over which statistics are made (default: surface.seed)",
    )


def _add_plot(commands: Any) -> None:
    plot = _command(
        commands,
        name="plot",
        help="draw single figures of a run, or their numbers",
        answer="Draw figures of a run as PNG or SVG, or write their numbers as CSV.",
    )
    _add_folder(plot)
    plot.add_argument(
        "--figure",
        dest="names",
        nargs="+",
        default=[],
        metavar="NAME",
        help="figures to draw (default: all)",
    )
    plot.add_argument(
        "--format",
        dest="form",
        choices=["png", "svg", "csv"],
        default="png",
        help="picture, or its numbers (default: png)",
    )
    _add_out(plot, help="folder of the files (default: RUN/figures)")


def _add_resound(commands: Any) -> None:
    resound = _command(
        commands,
        name="resound",
        help="hear stored runs elsewhere, or at another speed",
        answer="What would a stored run sound like at another distance or speed, or with "
        "another mass or plate thickness? The command solves nothing that is stored "
        "already.",
    )
    _add_folder(resound)
    _add_set(resound)
    _add_out(resound, help="run folder (default: outputs/NAME-DIGITS)")
    _add_workers(resound)
    _add_no_report(resound)


def _add_report(commands: Any) -> None:
    report = _command(
        commands,
        name="report",
        help="write the page of runs anew, or one of several",
        answer="Write one page to hear, see and read runs: a single HTML file that needs "
        "no network.",
    )
    _add_run_folders(report)
    report.add_argument(
        "--declare",
        action="store_true",
        help="write the sheets that people hand on, with CSV and JSON: declared level, bearing"
        " vibration, roughness (default: RUN/declaration.html)",
    )
    _add_out(report, metavar="PAGE", help="page to write (default: RUN/report.html)")


def _add_gallery(commands: Any) -> None:
    gallery = _command(
        commands,
        name="gallery",
        help="write one page of many runs to listen to",
        answer="Write one page of many runs, each with a picture, a sound, its level and a "
        "sentence.",
    )
    _add_run_folders(gallery)
    _add_out(gallery, metavar="PAGE", help="page to write (default: gallery.html)")


def _add_listen(commands: Any) -> None:
    listen = _command(
        commands,
        name="listen",
        help="write a long record of a run",
        answer="How does the run sound for longer, or at another speed? The command writes "
        "long.wav: beyond the solved track the ball rolls on over a random "
        "continuation of it.",
    )
    _add_folder(listen)
    listen.add_argument(
        "--seconds",
        type=arguments.positive,
        default=defaults.LISTENED_SECONDS,
        metavar="S",
        help=f"length of the record to make (default {defaults.LISTENED_SECONDS:g}), up to"
        f" {defaults.MAX_LISTENED_SECONDS:g}",
    )
    listen.add_argument(
        "--speed",
        type=arguments.speed,
        metavar="V",
        help="speed in m/s, or start:end for an even change (default: the scene's, which goes on"
        " at its last speed)",
    )
    listen.add_argument(
        "--seed",
        type=arguments.whole,
        default=0,
        metavar="N",
        help="number of the random continuation (default 0)",
    )
    listen.add_argument(
        "--reverberation",
        type=arguments.positive,
        metavar="T",
        help="write room.wav instead, the record in a room with a reverberation time of T seconds,"
        " 0.1 to 10. It is for listening only: no level includes the room.",
    )


def _add_choose(commands: Any) -> None:
    choose = _command(
        commands,
        name="choose",
        help="say which of some scenes is quieter, and how sure that is",
        answer="Which one is quieter, by how much, and how sure is that? The command hears all "
        "scenes on the same random surfaces, or at several places of their scans, until the "
        "difference is known. Bearings are compared by the velocity of their rings in three "
        "bands. The same command goes on where it stopped, and adds surfaces to what is there.",
    )
    choose.add_argument(
        "scenes",
        type=arguments.path,
        nargs="+",
        metavar="SCENE",
        help=f"{LONG_SCENE}; one scene with a sweep or with single faults is enough",
    )
    _add_set(choose)
    choose.add_argument(
        "--within",
        dest="within_db",
        type=arguments.positive,
        metavar="DB",
        help=f"add surfaces until the difference is known within ± DB (default"
        f" {defaults.WITHIN_DB:g}, with --improve {defaults.IMPROVED_WITHIN_DB:g})",
    )
    choose.add_argument(
        "--minutes",
        type=arguments.positive,
        default=defaults.CHOICE_MINUTES,
        metavar="M",
        help="add no more surfaces after M minutes; four are always heard (default"
        f" {defaults.CHOICE_MINUTES:g})",
    )
    choose.add_argument(
        "--pairs",
        type=arguments.whole,
        metavar="N",
        help="hear N surfaces, whatever the ± and the time: the same N gives the same answer"
        " (default: as many as --within needs)",
    )
    inverse = choose.add_mutually_exclusive_group()
    inverse.add_argument(
        "--improve",
        action="store_true",
        help="say of one scene what would help: dB(A) per 10 %% of each value of its drawing",
    )
    inverse.add_argument(
        "--below",
        type=arguments.number,
        metavar="LEVEL",
        help="find the coarsest value of --key with which one scene stays below LEVEL dB(A);"
        " a band of a bearing below LEVEL dB re 1 um/s",
    )
    choose.add_argument(
        "--key", metavar="KEY", help="value that is searched, such as surface.roughness_ra_um"
    )
    choose.add_argument(
        "--quantity",
        metavar="NAME",
        help="quantity of a bearing that --improve and --below ask for: low, medium, high or"
        " housing (default: medium)",
    )
    choose.add_argument(
        "--between",
        nargs=2,
        metavar=("LOW", "HIGH"),
        help="range of the search (default: a fifth of the value to five times it)",
    )
    _add_out(choose, help="folder of the choice (default: outputs/choice-DIGITS)")
    _add_workers(choose)


def _add_design(commands: Any) -> None:
    design = _command(
        commands,
        name="design",
        help="say which waves of a surface must be lower for a quieter scene",
        answer="Which waves of the plate must be lower, and by how much, for a quieter scene with "
        "the least change of its roughness? The command names them by third octave of wavelength, "
        "marches the changed surface beside the surface as it is, and writes the target for a "
        "workshop. The same command goes on where it stopped.",
    )
    _add_scene(design)
    design.add_argument(
        "--quieter",
        dest="quieter_db",
        type=arguments.positive,
        required=True,
        metavar="DB",
        help="how much quieter the scene is to be",
    )
    design.add_argument(
        "--pairs",
        type=arguments.whole,
        default=defaults.DESIGN_PAIRS,
        metavar="N",
        help="number of surfaces that are marched with lower waves, and of others whose response"
        f" is taken (default {defaults.DESIGN_PAIRS})",
    )
    _add_out(design, help="folder of the design (default: outputs/design-DIGITS)")
    _add_workers(design)


def _add_compare(commands: Any) -> None:
    compare = _command(
        commands,
        name="compare",
        help="compare a run with a recording of the real thing",
        answer="How near is a run to a recording of sound, acceleration or force? The command "
        "compares third octaves, total levels and modulation, and of a bearing its bands, crest "
        "factor, kurtosis and lines of the envelope. It writes RUN/compare-RECORDING.html. Without "
        "RECORDING, the folder is a bench with scene, scan, recordings and calibration.txt: the "
        "command names what is missing, or runs the scene and compares. synthetic-bench makes an "
        "example.",
    )
    compare.add_argument(
        "folder", type=arguments.path, metavar="RUN", help="run folder, or the folder of a bench"
    )
    compare.add_argument(
        "recording",
        type=arguments.path,
        nargs="?",
        metavar="RECORDING",
        help="0.5 to 120 s at 16 kHz or more (4 kHz of vibrations): a sound file (WAV, FLAC, OGG,"
        " MP3, AIFF), or a file of series (CSV, npz, mat of version 5, UFF)",
    )
    compare.add_argument(
        "--quantity",
        metavar="NAME",
        help="what is recorded: pressure, acceleration, velocity, displacement or force (default:"
        " that of --unit, otherwise pressure)",
    )
    compare.add_argument(
        "--unit",
        metavar="UNIT",
        help="unit of the numbers of RECORDING, such as g, m/s2, mm/s or um/s, in place of a"
        " calibration",
    )
    _add_series_options(compare)
    compare.add_argument(
        "--calibration",
        metavar="TONE.wav=LEVEL",
        help="recorded tone and its level, in dB re 20 uPa of sound, otherwise its rms in m/s2,"
        " m/s, m or N; or the value of full scale in Pa, m/s2, m/s, m or N; several channels have"
        " one for all, or one for each with commas between (default: only shapes are compared)",
    )
    compare.add_argument(
        "--background",
        type=arguments.path,
        metavar="NOISE",
        help="recording of the background alone, which is subtracted",
    )
    compare.add_argument(
        "--channel",
        dest="channels",
        action="append",
        default=[],
        metavar="NAME",
        help="channel of the run that goes with the next channel of RECORDING, or - to leave it"
        " out; may stand several times (default: all channels of the quantity, in order)",
    )


def _add_series_options(compare: argparse.ArgumentParser) -> None:
    """Add what is said of files of series, and of what is healthy."""
    for prefix, word in (("", "RECORDING"), ("healthy-", "the healthy recording")):
        compare.add_argument(
            f"--{prefix}variable",
            dest=f"{prefix.replace('-', '_')}variables",
            action="append",
            default=[],
            metavar="NAME",
            help=f"series of {word}, by its name in the file; may stand several times, one for each"
            " channel (default: the only one; a message lists them)",
        )
        compare.add_argument(
            f"--{prefix}rate",
            type=arguments.positive,
            metavar="HZ",
            help=f"sample rate of {word}, if its file does not say it",
        )
    compare.add_argument(
        "--healthy",
        type=arguments.path,
        metavar="RECORDING",
        help="recording of the same bearing without its fault: the rise by the fault is compared",
    )
    compare.add_argument(
        "--healthy-run",
        type=arguments.path,
        metavar="RUN",
        help="run folder of the bearing without its fault, with --healthy",
    )


def _add_surface(commands: Any) -> None:
    surface = _command(
        commands,
        name="surface",
        help="say how rough a surface is, and how a scene has it",
        answer="How rough is a surface, which finish yields first, and which line gives it "
        "to a scene? The command describes a file of heights or the surface of a "
        "scene, with a picture and all parameters of ISO 25178-2.",
    )
    surface.add_argument(
        "source",
        type=arguments.path,
        metavar="FILE",
        help=f"file of heights in any format, {LONG_SCENE}",
    )
    _add_set(surface)
    surface.add_argument(
        "--spacing-um",
        type=arguments.positive,
        metavar="UM",
        help="node spacing, if FILE has none",
    )
    surface.add_argument("--channel", metavar="NAME", help="channel of FILE (default: the first)")
    surface.add_argument(
        "--height-unit",
        dest="unit",
        choices=["m", "mm", "um", "nm"],
        help="unit of the heights, if FILE names none or another one (default: m)",
    )
    surface.add_argument(
        "--xy-unit",
        choices=["m", "mm", "um", "nm"],
        help="unit of x and y of a text, if FILE names none (default: that of the heights)",
    )
    surface.add_argument(
        "--along",
        choices=["x", "y"],
        help="axis of FILE along the track (default: y, so that a row lies across)",
    )
    surface.add_argument(
        "--tip-radius-um",
        type=arguments.positive,
        metavar="UM",
        help="radius of the tip of the stylus, for the waves that it traced",
    )
    surface.add_argument(
        "--sampling-um",
        type=arguments.positive,
        metavar="UM",
        help="half of the lateral period limit of the instrument (default: the spacing)",
    )
    surface.add_argument(
        "--noise-nm",
        type=arguments.positive,
        metavar="NM",
        help="rms noise of the instrument (default: what the spectrum shows)",
    )
    surface.add_argument(
        "--l-filter-um",
        type=arguments.positive,
        metavar="UM",
        help="nesting index of the L-filter (default: none); its kind follows from the heights",
    )
    surface.add_argument(
        "--save",
        type=arguments.path,
        metavar="OUT",
        help="new file for the heights, in the format of its ending",
    )
    surface.add_argument(
        "--declare",
        action="store_true",
        help="write the roughness report, too: declaration.html, .csv and .json in the folder",
    )
    _add_out(surface, help="folder of picture and table (default: outputs/NAME-surface)")


def _add_accuracy(commands: Any) -> None:
    accuracy = _command(
        commands,
        name="accuracy",
        help="measure the error of a scene on finer grids",
        answer="How far are the numbers of a scene from those of finer grids, other edges, "
        "tolerances and steps, and what do these cost?",
    )
    _add_scene(accuracy)
    _add_out(accuracy, help="folder of the study")
    _add_workers(accuracy)
    accuracy.add_argument(
        "--finest",
        type=arguments.power_of_two,
        default=defaults.FINEST,
        metavar="N",
        help=f"divide the spacing by 2, 4, ... up to N (default {defaults.FINEST})",
    )
    accuracy.add_argument(
        "--duration",
        dest="duration_s",
        type=arguments.positive,
        default=defaults.ACCURACY_SECONDS,
        metavar="S",
        help=f"seconds of rolling at most (default {defaults.ACCURACY_SECONDS:g}: no third octave"
        " from 100 Hz is empty)",
    )


def _add_reproduce(commands: Any) -> None:
    reproduce = _command(
        commands,
        name="reproduce",
        help="repeat the study of Lee, Kim and Kim (2025)",
        answer="Do the statements of the article hold? The command runs its study in "
        "several readings and answers for each statement. The same command again "
        "goes on where it stopped.",
    )
    reproduce.add_argument(
        "study",
        choices=["lee2025"],
        metavar="STUDY",
        help="lee2025: Lee, Kim & Kim, Inventions 10(1), 17",
    )
    reproduce.add_argument(
        "--readings",
        nargs="+",
        default=[],
        metavar="NAME",
        help="readings to run (default: all)",
    )
    first, second, third = defaults.QUICK_LOADS_N
    reproduce.add_argument(
        "--quick",
        action="store_true",
        help=f"{defaults.QUICK_SEEDS} surface, loads of {first}, {second}, {third} N,"
        f" {defaults.QUICK_SECONDS:g} s in steps {defaults.QUICK_STRIDES} times as long",
    )
    _add_out(reproduce, help="folder of the study (default: outputs/STUDY)")
    _add_workers(reproduce)


def _add_validate(commands: Any) -> None:
    validate = _command(
        commands,
        name="validate",
        help="compare the program with published results",
        answer="How far is the program from published results? The command writes a page "
        "of all differences.",
    )
    validate.add_argument(
        "cases",
        nargs="*",
        default=[],
        metavar="CASE",
        help="headings of the page in short, such as impact (default: all); a wrong name lists"
        " them",
    )
    validate.add_argument(
        "--bench",
        dest="benches",
        nargs="+",
        type=arguments.path,
        default=[],
        metavar="FOLDER",
        help="folders of benches that are compared as `rolling compare FOLDER` does, and become"
        " rows (default: the synthetic one)",
    )
    _add_out(validate, metavar="PAGE", help="page to write (default: validation.md)")


def _add_scenes(commands: Any) -> None:
    scenes = _command(
        commands,
        name="scenes",
        help="list the scenes that come with the program",
        answer="List the scenes that come with the program. `rolling run NAME` runs one, "
        "and `rolling init NAME` copies it.",
    )
    scenes.add_argument("--all", action="store_true", help="list the scenes of studies as well")


def _add_init(commands: Any) -> None:
    init = _command(
        commands,
        name="init",
        help="copy such a scene here, to change it",
        answer="Copy a scene that comes with the program into the current folder, where "
        "you can change it.",
    )
    init.add_argument(
        "name",
        nargs="?",
        default="quickstart",
        metavar="NAME",
        help="name of the scene (default: quickstart)",
    )


def _add_schema(commands: Any) -> None:
    schema = _command(
        commands,
        name="schema",
        help="print the JSON Schema of scenes, for editors",
        answer="Print the JSON Schema of scene files, with which an editor completes and "
        "checks keys.",
    )
    schema.add_argument(
        "--kind", default="ball", metavar="KIND", help="ball or bearing (default: ball)"
    )
    schema.add_argument(
        "--summary",
        action="store_true",
        help="the schema of summary.json of a run of the kind",
    )


# ---- arguments of several commands


def _command(commands: Any, *, name: str, help: str, answer: str) -> argparse.ArgumentParser:
    """Add the parser of a command, with a line for the list and what the command answers."""
    parser: argparse.ArgumentParser = commands.add_parser(name, help=help, description=answer)
    parser.set_defaults(command=name, parser=parser)
    # An option before the command holds, too: the default of the command must not replace it.
    _add_volume(parser, default=argparse.SUPPRESS)
    return parser


def _add_volume(parser: argparse.ArgumentParser, *, default: Any) -> None:
    """Add the options that say more or less."""
    either = parser.add_mutually_exclusive_group()
    either.add_argument(
        "-q",
        "--quiet",
        action="store_true",
        default=default,
        help="print refusals, errors and the name of the folder or page only",
    )
    either.add_argument(
        "-v",
        "--verbose",
        action="store_true",
        default=default,
        help="say more: errors, notes and warnings, steps and times",
    )


def _add_scene(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scene", type=arguments.path, metavar="SCENE", help=LONG_SCENE)
    _add_set(parser)


def _add_set(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--set",
        dest="overrides",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="give a key another value, such as rolling.load_n=50; may stand several times",
    )


def _add_folder(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", type=arguments.path, metavar="RUN", help="run folder")


def _add_run_folders(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "run_folders",
        type=arguments.path,
        metavar="RUN",
        nargs="+",
        help="run folders, or folders of single runs in them",
    )


def _add_out(parser: argparse.ArgumentParser, *, help: str, metavar: str = "FOLDER") -> None:
    parser.add_argument("--out", type=arguments.path, metavar=metavar, help=help)


def _add_workers(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--workers",
        type=arguments.count,
        default=0,
        metavar="N",
        help="processes (default: one per core)",
    )


def _add_no_report(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--no-report",
        action="store_false",
        dest="report",
        help="write no report page and no figures",
    )
