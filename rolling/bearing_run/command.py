"""Commands on bearings: run a scene into a folder, and report, tabulate and listen to stored runs.

A folder holds scene.yaml, report.html, runs.csv and contacts/, the marches that runs share. Each
run has result.h5, numbers.json, summary.json, spectrum.csv, lines.csv, acceleration.wav, listen.wav
and figures/, a single run in the folder itself, a run of a sweep in a folder below.
"""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pandas import DataFrame

from acoustics import resampling, wav
from acoustics.texts import printable
from rolling.bearing.motion import move_ring
from rolling.bearing_run import page, sentences, simulation, stored_run
from rolling.bearing_run.bearing_run import BearingRun, with_numbers
from rolling.bearing_run.solved_bearing import SolvedBearing
from rolling.contact.processor_time import ProcessorTime
from rolling.contact.solver import ContactError
from rolling.figures.picture import csv_bytes
from rolling.numbers import views
from rolling.numbers.bearing_numbers import BearingNumbers
from rolling.numbers.doubt import Doubt, Severity
from rolling.results.run_folder import (
    FAILED,
    PAGE,
    RESULT,
    SUMMARY,
    TABLE,
    BearingFolder,
    refuse_former,
)
from rolling.results.stored_numbers import with_page, write_stored
from rolling.run import folder as folders
from rolling.scene.bearing_scene import BearingScene
from rolling.scene.height_files import read_regular
from rolling.scene.messages import SceneError, table
from rolling.scene.sweep import Value
from rolling.terminal import defaults, files, pages, progress, system_errors
from rolling.terminal.files import FolderError
from rolling.terminal.streams import columns, folded

LONG = "long.wav"
WORDS = table("rolling.bearing_run", "words")
MAX_SCENE = 1_000_000  # bytes of a scene file on the page
_MOST_DOUBTS = 4  # that are printed unless all are asked for


# ---- run


def run_bearing(
    scene: BearingScene,
    out: Path | None = None,
    *,
    start_from: Path | None = None,
    workers: int = 0,
    report: bool = True,
    open: bool = False,
) -> dict[str, str]:
    """Run the scene of a bearing into a folder, or the part of it that the folder lacks.

    Parameters
    ----------
    scene : BearingScene. The scene.
    out : Path. Run folder. Default: outputs/NAME-DIGITS, which the scene decides.
    start_from : Path. Run folder of a bearing, whose equal marches are taken. Default: none.
    workers : int. Number of processes; 0: one per core. Default: 0.
    report : bool. Whether page and figures are written. Default: true.
    open : bool. Whether the page is opened in a browser. Default: false.

    Returns
    -------
    failures : dict. Reasons by the label of each run that failed.

    Raises
    ------
    SceneError, FolderError : before anything is computed or written.
    OSError : a disk is full; finished marches are kept.
    KeyboardInterrupt : Ctrl-C or SIGTERM; finished marches are kept.
    """
    folder = out or folders.default_folder(scene)
    folders.refuse_other(folder, scene)
    source = None if start_from is None else folders.bearing_home(start_from)
    if source is not None:
        refuse_former(folders.stored_bearing_runs(source))
    simulation.refuse(scene, workers, folder)
    folder.mkdir(parents=True, exist_ok=True)
    with folders.locked(folder):
        if not folders.refuse_other(folder, scene):
            folders.write_scene(folder, scene)
        if not progress.is_quiet():
            print(f"files: {folder}", flush=True)
        runs = folders.bearing_runs_in(folder, scene)
        folders.tidy(folder, runs, alone=True)
        failures = _solve_lacking(folder, runs, workers, source)
        done = [run for run in runs if run.is_done]
        if done:
            _write_derived(folder, runs, report)
    if done:
        _print_runs(folder, done)
    if open:
        pages.open_page(folder / PAGE)
    return failures


def _solve_lacking(
    folder: Path, runs: Sequence[BearingFolder], workers: int, source: Path | None
) -> dict[str, str]:
    """Solve the runs that are not done, one after the other; return failures by label."""
    lacking = [run for run in runs if not run.is_done]
    if not lacking:
        progress.line(f"{folder}: all runs are done")
        return {}
    failures = {}
    advice = f"finished marches are kept in {folder}; the same command goes on"
    try:
        for run in lacking:
            try:
                _solve(folder, run, workers, source, first=run is lacking[0])
            except (ContactError, ValueError) as error:
                failures[label_of(run)] = str(error)
                files.make_below(folder, run.folder)
                files.write_json(run.folder / FAILED, {"reason": str(error)})
    except OSError as error:
        text = system_errors.sentence(error)
        if system_errors.is_of_a_place(error) and not progress.has_solved():
            raise FolderError(text) from error
        raise OSError(f"{text}\n{advice}") from error
    except KeyboardInterrupt:
        progress.line(advice)
        raise
    if not failures:
        shutil.rmtree(folder / folders.PIECES, ignore_errors=True)
    return failures


def _solve(
    folder: Path, place: BearingFolder, workers: int, source: Path | None, first: bool
) -> None:
    """Solve a run and write its files; the first of a command is heard before all is marched."""
    files.make_below(folder, place.folder)
    stages = simulation.bearing_stages(
        place.scene, folder=folder, workers=workers, start_from=source
    )
    for stage in stages:
        label = label_of(place)
        if stage.run is not None:
            with progress.step("writing the files of the run"):
                run = replace(stage.run, values=place.values, label=label, folder=place.folder)
                stored_run.write_run(run, place.folder)
        elif first:
            bearing = replace(stage.bearing, label=label)
            sound = stored_run.write_acceleration(bearing, place.folder)
            stored_run.write_listen(bearing, place.folder, sound, sound.gain)
            path = place.folder / stored_run.LISTEN
            progress.line(f"the first sound, of contacts at one load: {path}")
        progress.solved()


def label_of(place: BearingFolder) -> str:
    """Return the label of a run, its swept values in words; empty for a single run."""
    return ", ".join(_worded(key, value) for key, value in place.values.items())


def _worded(key: str, value: Value) -> str:
    """Write a swept value with its word and unit: axial load 70 N."""
    words = WORDS.get(key, {"word": key.removeprefix("bearing.")})
    text = f"{value:g}" if isinstance(value, int | float) else printable(str(value))
    return f"{words['word']} {text} {words.get('unit', '')}".strip()


def opened(places: Sequence[BearingFolder]) -> list[BearingRun]:
    """Read runs that are done.

    Raises
    ------
    FolderError : a file is missing or damaged.
    """
    return [read_run(place) for place in places]


def save_run(run: BearingRun, folder: Path, report: bool) -> Path:
    """Write a run that is in memory into a new folder, and return the folder."""
    with folders.locked(folder):
        folders.write_scene(folder, run.scene)
        stored_run.write_run(replace(run, values={}, label="", folder=folder), folder)
        _write_derived(folder, folders.bearing_runs_in(folder, run.scene), report)
    return folder


def read_run(place: BearingFolder) -> BearingRun:
    """Read a run from its folder, with its stored numbers.

    Raises
    ------
    FolderError : a file is missing or damaged, or the result is that of another scene.
    """
    stored = stored_run.read_stored_bearing(place.folder)
    record, tracks = stored_run.read_result(place.folder / RESULT, place.scene)
    bearing = SolvedBearing(
        scene=place.scene,
        record=record,
        tracks=tracks,
        values=place.values,
        label=label_of(place),
        folder=place.folder,
    )
    return with_numbers(bearing, stored.numbers, stored)


def _numbers_of(place: BearingFolder) -> BearingNumbers:
    """Return the numbers of a run that is done, from its folder."""
    return stored_run.read_stored_bearing(place.folder).numbers


# ---- what follows from the runs that are done


def _write_derived(folder: Path, runs: Sequence[BearingFolder], report: bool) -> None:
    """Write table, common gain, figures and page of the runs that are done, unless they are new."""
    done = [run for run in runs if run.is_done]
    newest = max((run.folder / SUMMARY).stat().st_mtime_ns for run in done)
    last = folder / PAGE if report else folder / TABLE
    if last.is_file() and newest <= last.stat().st_mtime_ns:
        return
    if len(runs) > 1:
        with progress.step("writing listen.wav with one gain for the sweep"):
            write_with_common_gain(done)
    files.write_bytes(folder / TABLE, csv_bytes(run_table(done)))
    if not report:
        return
    began = ProcessorTime.now()
    content = _drawn_report(folder, done, [label_of(run) for run in runs if not run.is_done])
    spent = ProcessorTime.now().since(began)
    for run in done:  # before the page, which must not be older than a summary
        stored = stored_run.read_stored_bearing(run.folder)
        write_stored(run.folder, with_page(stored, spent, len(done)))
    files.write_bytes(folder / PAGE, content)


def write_report(folder: Path, done: Sequence[BearingFolder], unsolved: Sequence[str]) -> None:
    """Write the figures of runs that are done and the page of a folder."""
    files.write_bytes(folder / PAGE, _drawn_report(folder, done, unsolved))


def _drawn_report(folder: Path, done: Sequence[BearingFolder], unsolved: Sequence[str]) -> bytes:
    """Write the figures of runs that are done, and return the page of a folder."""
    with progress.step("drawing the figures"):
        runs = opened(done[: defaults.MAX_RUNS_ON_PAGE])
        not_shown = [*unsolved, *map(label_of, done[defaults.MAX_RUNS_ON_PAGE :])]
        for run in runs:
            stored_run.write_figures(run, run.folder)
    with progress.step("writing the page"):
        return page.page(runs, _scene_text(folder), not_shown)


def _scene_text(folder: Path) -> str:
    """Return the scene file of a folder, or of the folder of the sweep around it."""
    for place in (folder, folder.absolute().parent):
        if (place / folders.SCENE).is_file():
            return read_regular(place / folders.SCENE, MAX_SCENE).decode("utf-8", "replace")
    return ""


def write_with_common_gain(done: Sequence[BearingFolder]) -> None:
    """Write listen.wav of the runs of a sweep with one gain, that of the loudest run."""
    stored = {run: stored_run.read_stored_bearing(run.folder) for run in done}
    common = max(one.files.listen.own_full_scale_m_s2 for one in stored.values())
    for place, one in stored.items():
        listen = one.files.listen
        if listen.full_scale_m_s2 == common:
            continue
        run = read_run(place)
        sound = stored_run.ring_sound(run)
        stored_run.write_listen(run, place.folder, sound, 1 / common)
        facts = replace(one.files, listen=replace(listen, full_scale_m_s2=common))
        write_stored(place.folder, replace(one, files=facts))
    _write_housings([place for place in done if place.scene.plate is not None])


def _write_housings(done: Sequence[BearingFolder]) -> None:
    """Write housing.wav of the runs of a sweep with one gain, that of the loudest run."""
    sounds = [stored_run.housing_sound(read_run(place)) for place in done]
    common = min((sound.gain for sound in sounds if sound is not None), default=1.0)
    for place in done:
        stored_run.write_housing(read_run(place), place.folder, common)


def run_table(done: Sequence[BearingFolder]) -> DataFrame:
    """Tabulate runs that are done, a row each: the numbers that a person reads."""
    rows = []
    for place in done:
        numbers = _numbers_of(place)
        row: dict[str, Any] = {"run": label_of(place) or place.scene.name, **place.values}
        for name, cell in views.columns(numbers).items():
            if cell.said.in_table:
                row[name] = cell.value
        row["doubts"] = " ".join(dict.fromkeys(doubt.key for doubt in numbers.doubts))
        rows.append(row)
    return DataFrame(rows)


# ---- terminal


def _print_runs(folder: Path, done: Sequence[BearingFolder]) -> None:
    """Print answer, lines, doubts and files of runs; the folder if quiet."""
    if progress.is_quiet():
        print(folder)
        return
    stored = [_numbers_of(run) for run in done]
    if len(done) > 1:
        print(band_table(done))
    else:
        for sentence in stored[0].sentences:
            print(folded(sentence))
    _print_doubts(stored)
    print(f"listen: {printable(str(done[0].folder / stored_run.LISTEN))}")
    if (done[0].folder / stored_run.HOUSING).is_file():
        print(f"listen to the housing: {printable(str(done[0].folder / stored_run.HOUSING))}")
    if (folder / PAGE).is_file():
        print(f"page: {printable(str(folder / PAGE))}")
    else:
        print(f"folder: {printable(str(folder))}")
    if progress.is_verbose():
        for place, numbers in zip(done, stored, strict=True):
            print(f"\n{label_of(place) or place.scene.name}")
            print(line_lines(numbers))


def band_table(done: Sequence[BearingFolder]) -> str:
    """Write the radial bands of runs in aligned columns, a row each, [um/s].

    Bands end where the ring bends. The last column has the high band of a ring that stays rigid.
    """
    words = sentences.BAND_WORDS
    heads = [f"{text}, below the bending" for text in words.values()]
    rows = [["run, radial um/s", *heads, f"{words['high']}, rigid"]]
    for place in done:
        numbers = _numbers_of(place)
        shown = sentences.band_words(numbers.ring.bending_hz)
        velocities = [
            sentences.velocity(um_s) if band in shown else sentences.NO_VELOCITY
            for band, um_s in numbers.below_bending.radial.um_s.items()
        ]
        rigid = sentences.velocity(numbers.velocities.radial.high.value)
        rows.append([label_of(place), *velocities, rigid])
    return columns(rows)


def line_lines(numbers: BearingNumbers) -> str:
    """Write the lines of a run in aligned columns."""
    heads = ["line", "Hz"]
    for direction, bands in numbers.velocities.by_direction.items():
        head = f"{direction} um/s"
        verdicts = {velocity.verdict for velocity in bands.by_band.values()}
        if verdicts == {Severity.DO_NOT_QUOTE.word}:
            head += f" ({Severity.DO_NOT_QUOTE.word})"
        heads.append(head)
    rows = [heads]
    for line in numbers.lines:
        velocities = [
            "not resolved" if own.um_s is None else sentences.velocity(own.um_s)
            for own in line.by_direction.values()
        ]
        rows.append([line.name, f"{line.frequency_hz:.2f}", *velocities])
    return columns(rows)


def _print_doubts(stored: Sequence[BearingNumbers]) -> None:
    """Print each kind of doubt at its worst, the worst first; all of them if verbose."""
    every = [doubt for numbers in stored for doubt in numbers.doubts]
    every.sort(key=lambda doubt: doubt.rank, reverse=True)
    by_key: dict[str, Doubt] = {}
    for doubt in every:
        by_key.setdefault(doubt.key, doubt)
    doubts = list(by_key.values())
    shown = doubts if progress.is_verbose() else doubts[:_MOST_DOUBTS]
    for doubt in shown:
        print(folded(f"doubt: {doubt.line}."))
    if len(doubts) > len(shown):
        print(f"{len(doubts) - len(shown)} more on the page and in {SUMMARY}")


# ---- stored runs


def report_bearing(run_folders: Sequence[Path], out: Path | None = None) -> list[Path]:
    """Write the page of the runs of a bearing that are done; return its file.

    Parameters
    ----------
    run_folders : sequence of Path. One run folder.
    out : Path. File to write. Default: report.html in the run folder.

    Raises
    ------
    FolderError : there are several folders, no run is done, or `out` exists.
    """
    if len(run_folders) > 1:
        raise FolderError("a page shows the runs of one folder of a bearing; name one, or sweep")
    (folder,) = run_folders
    places = folders.stored_bearing_runs(folder)
    done = [place for place in places if place.is_done]
    if not done:
        raise FolderError(f"{folder}: no run is done yet")
    unsolved = [label_of(place) for place in places if not place.is_done]
    if out is None:
        write_report(folder, done, unsolved)
        return [folder / PAGE]
    pages.refuse_page(out)
    with progress.step("writing the page"):
        runs = opened(done[: defaults.MAX_RUNS_ON_PAGE])
        not_shown = [*unsolved, *map(label_of, done[defaults.MAX_RUNS_ON_PAGE :])]
        content = page.page(runs, _scene_text(folder), not_shown)
    out.parent.mkdir(parents=True, exist_ok=True)
    files.write_bytes(out, content)
    return [out]


def table_bearing(folder: Path) -> list[Path]:
    """Print the bands of the runs that are done, and write them into runs.csv; return its path.

    Raises
    ------
    FolderError : no run is done.
    """
    done = [place for place in folders.stored_bearing_runs(folder) if place.is_done]
    if not done:
        raise FolderError(f"{folder}: no run is done, so there is nothing to tabulate")
    if not progress.is_quiet():
        print(band_table(done))
        print()
    files.write_bytes(folder / TABLE, csv_bytes(run_table(done)))
    return [folder / TABLE]


def listen_bearing(folder: Path, seconds: float) -> list[Path]:
    """Let the ring of a stored run move for longer, and write long.wav; return its path.

    Parameters
    ----------
    folder : Path. The folder of one run.
    seconds : float, s. Length of the record.

    Raises
    ------
    FolderError : the folder holds several runs, or its run is not done, or of version 0.8.
    """
    place = folders.done_bearing_run(folder, "listen to")
    refuse_former([place])
    run = read_run(place)
    motion = move_ring(run.model, run.tracks, seconds, wav.SAMPLE_RATE_HZ)
    acceleration = motion.acceleration_m_s2[:, 0] - motion.acceleration_m_s2[:, 0].mean()
    samples = round(stored_run.FADE_S * wav.SAMPLE_RATE_HZ)
    faded = resampling.fade(acceleration, samples)
    gain = wav.listening_gain(faded)
    comment = f"acceleration of the ring along x; full scale is {1 / gain:.6g} m/s2"
    content = wav.listening(faded, gain, comment, printable(run.scene.name))
    files.write_bytes(folder / LONG, content)
    return [folder / LONG]


def refuse_sweep(scene: BearingScene) -> None:
    """Refuse a scene that sweeps where one run is wanted.

    Raises
    ------
    SceneError : the scene sweeps.
    """
    if scene.sweep:
        keys = ", ".join(scene.sweep)
        raise SceneError([f"sweep: the scene sweeps {keys}; simulate each scene of scene.runs()"])
