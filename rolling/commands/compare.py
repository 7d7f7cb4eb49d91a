"""Compare runs with recordings: print tables, write them and a page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from acoustics.texts import printable
from rolling.commands.run import run_scene
from rolling.figures.picture import slug
from rolling.kinds.stated_conditions import conditions_of, with_conditions, write_answer_file
from rolling.recordings.agreement import sentences
from rolling.recordings.recorded import PRESSURE, quantity_of
from rolling.recordings.recorded_units import unit_of
from rolling.recordings.recording_comparison import Healthy, RecordingComparison, words
from rolling.recordings.recording_comparison import compare as compare_record
from rolling.recordings.series_files import FileLayout
from rolling.report import bench as benches
from rolling.report import recording_page, synthetic_bench
from rolling.results.notes import UNVALIDATED
from rolling.results.runs_table import csv_bytes
from rolling.run import folder as folders
from rolling.run.solving import open_runs
from rolling.scene.height_files import holds
from rolling.terminal import progress, whole_files
from rolling.terminal.streams import folded
from rolling.terminal.whole_files import FolderError


class RecordedSeries(NamedTuple):
    """What is said of a recording that is no sound file, and what is healthy.

    layout : FileLayout. Which series of the file are meant, and their rate.
    unit : str or None. Name of their unit.
    healthy : Path or None. Recording of the same without its fault, in the same unit.
    healthy_run : Path or None. Folder of the run without the fault.
    healthy_layout : FileLayout. As `layout`, of the healthy recording.
    """

    layout: FileLayout = FileLayout()
    unit: str | None = None
    healthy: Path | None = None
    healthy_run: Path | None = None
    healthy_layout: FileLayout = FileLayout()


def compare(
    folder: Path,
    recording: Path,
    calibration: str | None = None,
    background: Path | None = None,
    quantity: str | None = None,
    channels: Sequence[str] = (),
    series: RecordedSeries | None = None,
) -> list[Path]:
    """Compare a run with a recording: print a table, write it and a page, and return its path.

    Parameters
    ----------
    folder : Path. The folder of one run, which gets compare-NAME.html and compare-NAME.csv, with a
        number where another comparison has the name.
    recording : Path. Sound file of the real thing, whose name is NAME.
    calibration : str. TONE.wav=LEVEL, a recorded tone of known level (dB re 20 uPa of sound,
        otherwise the rms in the SI unit), or the value of full scale in the SI unit. Default: none;
        the recording gets the total level of the run.
    background : Path. Recording of the background alone, which is subtracted. Default: none.
    quantity : str. What is recorded: pressure, acceleration, velocity, displacement or force.
        Default: that of the unit, otherwise pressure.
    channels : sequence of str. Names of the run's channels, in the order of the recording's.
        Default: those of the quantity in their order.
    series : RecordedSeries. What is said of a file of series, and what is healthy. Default:
        nothing.

    Raises
    ------
    FolderError : the folder holds no single run that is done, or a recording cannot be compared.
        Nothing is written.
    """
    given = series or RecordedSeries()
    if given.unit is not None:
        unit = unit_of(given.unit, quantity, calibration)
        quantity, calibration = unit.quantity, f"{unit.si!r}"
    quantity = quantity or PRESSURE.name
    quantity_of(quantity)
    run = _run_to_compare(folder)
    healthy = _healthy(given)
    with progress.step("comparing it with the recording"):
        comparison = compare_record(
            run=run,
            path=recording,
            calibration=calibration,
            background=background,
            quantity=quantity,
            channels=channels,
            layout=given.layout,
            healthy=healthy,
        )
    return [_write_comparison(run, folder, recording, comparison)]


def _healthy(given: RecordedSeries) -> Healthy | None:
    """Return the healthy run and its recording; refuse one without the other."""
    if given.healthy is None and given.healthy_run is None:
        return None
    if given.healthy is None or given.healthy_run is None:
        raise FolderError(
            "--healthy and --healthy-run: got one of them, allowed: both; the rise of the run needs"
            " a run folder of the bearing without its fault, such as by --set"
            " bearing.surfaces.inner.faults="
        )
    return Healthy(_run_to_compare(given.healthy_run), given.healthy, given.healthy_layout)


def compare_bench(folder: Path) -> list[Path]:
    """Run the scene of a bench unless it has run, and compare it with each of its recordings.

    Parameters
    ----------
    folder : Path. Folder with scene, scan, recordings and calibration.txt; its run is in the folder
        run. The name synthetic-bench, where there is no such folder, makes one below outputs.

    Returns
    -------
    pages : list of Path. A page for each recording.

    Raises
    ------
    FolderError : something is missing in the folder, and nothing is written; or a run failed, or a
        recording cannot be compared, after all others were.
    """
    if folder == synthetic_bench.NAME and not folder.exists():
        folder = synthetic_bench.make(Path("outputs") / folder)
    bench = benches.read_bench(folder)
    place = benches.run_folder(bench)
    failures = run_scene(bench.scene, place)
    if failures:
        raise FolderError("; ".join(f"{place}: {reason}" for reason in failures.values()))
    run = _run_to_compare(place)
    pages = []
    problems = []
    for item in bench.recordings:
        try:
            with progress.step(f"comparing it with {item.path.name}"):
                comparison = benches.compare_recording(run, item)
        except FolderError as error:
            problems.append(str(error))
            continue
        pages.append(_write_comparison(run, place, item.path, comparison))
    if problems:
        raise FolderError("\n".join(problems))
    progress.line(f"as rows of the validation: rolling validate --bench {folder}")
    return pages


def _run_to_compare(folder: Path) -> Any:
    """Return the only run of a folder, with its sound."""
    stored = folders.done_run(folder, "compare")
    with progress.step("reading the run, making its sound"):
        (run,) = open_runs([stored])
    return run


def _write_comparison(
    run: Any, folder: Path, recording: Path, comparison: RecordingComparison
) -> Path:
    """Write page and table of a comparison into a run folder, and print them; return the page."""
    label = run.scene.name
    conditions = conditions_of({label: run.scene})
    answer = sentences(comparison)
    methods = conditions.paragraph(
        [f"It was compared with the recording {printable(recording.name)}.", *answer, UNVALIDATED]
    )
    content = recording_page.page(run, comparison, conditions, methods)
    table = comparison.table
    numbers = csv_bytes(with_conditions(table, conditions, [label] * len(table)))
    page = _free_page(folder / f"compare-{slug(recording.name)[:80]}.html", content, numbers)
    whole_files.write_bytes(page.with_suffix(".csv"), numbers)
    if len(comparison.figures):
        figures = page.with_name(f"{page.stem}-figures.csv")
        rows = [label] * len(comparison.figures)
        stated = with_conditions(comparison.figures, conditions, rows)
        whole_files.write_bytes(figures, csv_bytes(stated))
    write_answer_file(page.with_suffix(".json"), answer, conditions, methods)
    whole_files.write_bytes(page, content)
    if not progress.is_quiet():
        print(*map(folded, [*conditions.lines, *answer, *comparison.notes]), sep="\n")
        for heading, table in words(comparison).items():
            print(f"\n{heading}\n{table.to_string(index=False)}")
        print()
    return page


def _free_page(page: Path, content: bytes, numbers: bytes) -> Path:
    """Return a page, with a number where another comparison has its name.

    A comparison that is there already keeps its name.
    """
    free = page
    number = 1
    while free.exists() or free.with_suffix(".csv").exists():
        if holds(free, content) and holds(free.with_suffix(".csv"), numbers):
            return free
        number += 1
        free = page.with_name(f"{page.stem}-{number}{page.suffix}")
    return free
