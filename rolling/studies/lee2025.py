"""The command that runs the study, judges the article's statements and draws its figures.

Each scene has a run folder of its own, so the same command continues a study that was stopped.
"""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from rolling.run import folder as folders
from rolling.scene import library
from rolling.scene.file import read_as
from rolling.scene.messages import nearest, table
from rolling.scene.scene import Scene
from rolling.studies import lee2025_conditions as conditions
from rolling.studies.lee2025_cases import (
    CURVES,
    Maps,
    by_reading,
    case_of,
    finished_runs,
    frame,
    maps_of,
)
from rolling.studies.lee2025_conditions import FAILS, HOLDS, IN_PART, NOT_RUN, OUTLOOK, ROUGHNESS
from rolling.studies.output import markdown_table, png
from rolling.terminal import defaults, progress
from rolling.terminal.whole_files import PARTIAL, FolderError, make_below, write_bytes

STUDY = "lee2025"
SWEEPS = ("correlation-length", "skewness")  # of the article's outlook
TABLES = "tables.md"
FIGURES = "figures"
OWN_FILES = {TABLES, FIGURES, "cases.csv", "statements.csv"}


def reproduce(
    readings: Sequence[str] = (), out: Path | None = None, quick: bool = False, workers: int = 0
) -> int:
    """Run the study or its missing part, write tables and figures, and return the exit code.

    Parameters
    ----------
    readings : sequence of str. Readings by name. Default: all, or with `quick` all but the sweeps
        of the outlook.
    out : Path or None. Folder of the study. Default: None, for a folder below outputs/.
    quick : bool. If true, solve one surface and three loads on a short track. Default: False.
    workers : int. Number of processes. Default: 0, for one per core.

    Raises
    ------
    FolderError : there is no such reading, or `out` holds something else.
    SceneError : a scene file cannot be used.
    """
    folder = out or Path("outputs") / (f"{STUDY}-quick" if quick else STUDY)
    scene_files = _scene_files(readings)
    if quick and not readings:  # its fine surfaces would add a third to the time
        scene_files = [(name, file) for name, file in scene_files if name not in SWEEPS]
    _refuse_foreign(folder)
    cases = [folder / reading / file.stem for reading, file in scene_files]
    programs = {folders.made_by(case) for case in cases}
    if len(programs) > 1:
        raise FolderError(
            f"{folder}: its cases are of {' and '.join(sorted(programs))}; numbers of two programs"
            " are not mixed, so take another --out, or delete the older cases"
        )
    rows: list[dict[str, Any]] = []
    maps: dict[str, Maps] = {}
    missing = 0
    for case, (reading, file) in zip(cases, scene_files, strict=True):
        overrides = quick_overrides(read_as(file, Scene)) if quick else []
        make_below(folder, case)
        runs = finished_runs(file, case, workers, overrides)
        missing += len(read_as(file, Scene, overrides).runs()) - len(runs)
        for run in runs:
            rows.append(case_of(reading, run))
            maps.setdefault(reading, {}).update(maps_of(run))
    if all(math.isnan(row["hardness_gpa"]) for row in rows):
        raise FolderError(f"{folder}: no case with a hardness is solved, so nothing can be judged")
    with progress.step("judging the statements, drawing the figures"):
        summary = _write(folder, frame(rows), maps, scene_files)
    progress.line(summary)
    if missing:
        progress.line(f"{missing} cases failed; the statements are judged without them")
    print(folder if progress.is_quiet() else f"verdicts: {folder / TABLES}")
    return 1 if missing else 0


def _write(
    folder: Path, cases: pd.DataFrame, maps: dict[str, Maps], scene_files: list[tuple[str, Path]]
) -> str:
    """Write tables and figures of the cases, and return the verdicts in a sentence."""
    from rolling.figures.settings import left_out_if_it_fails, own_settings  # matplotlib
    from rolling.studies import lee2025_figures as figures

    readings = by_reading(cases)
    table = verdicts(readings)
    write_bytes(folder / "cases.csv", cases.drop(columns=CURVES).to_csv(index=False).encode())
    write_bytes(folder / "statements.csv", table.to_csv(index=False).encode())
    write_bytes(folder / TABLES, tables(table, cases, scene_files).encode())
    make_below(folder, folder / FIGURES)
    pictures = dict[Path, bytes]()
    with own_settings(), left_out_if_it_fails("of the study, and with it those that follow,"):
        for reading, name, figure in figures.gallery(readings, maps):
            pictures[folder / FIGURES / f"{reading}-{name}.png"] = png(figure)
    for path, picture in pictures.items():
        write_bytes(path, picture)
    return f"{len(cases)} cases. {headline(table, cases)}"


def quick_overrides(scene: Scene) -> list[str]:
    """Return the settings of the quick study: one surface, three loads, long steps, short track."""
    step_nodes = defaults.QUICK_STRIDES * scene.step_nodes
    overrides = []
    if "surface.seed" in scene.sweep:
        overrides.append(f"sweep.surface.seed={list(range(1, defaults.QUICK_SEEDS + 1))}")
    if "rolling.load_n" in scene.sweep:
        overrides.append(f"sweep.rolling.load_n={list(defaults.QUICK_LOADS_N)}")
    overrides.append(f"rolling.duration_s={defaults.QUICK_SECONDS}")
    overrides.append(f"numerics.step_nodes={step_nodes:g}")
    return overrides


def _scene_files(chosen: Sequence[str] = ()) -> list[tuple[str, Path]]:
    """Return the readings and scene files of all readings, or of the chosen readings."""
    files = sorted((library.folder() / STUDY).glob("*/*.yaml"))
    known = list(dict.fromkeys(file.parent.name for file in files))
    for reading in chosen:
        if reading not in known:
            near = nearest(reading, known)
            raise FolderError(f"--readings: got {reading}, allowed: {', '.join(known)}{near}")
    return [(file.parent.name, file) for file in files if file.parent.name in (chosen or known)]


def _refuse_foreign(folder: Path) -> None:
    """Refuse a folder that holds anything but runs and tables of the study."""
    if not folder.exists():
        return
    names = {path.name for path in folder.iterdir() if path.suffix != PARTIAL}  # left by a kill
    readings = {reading for reading, _ in _scene_files()}
    if names and (names.isdisjoint(readings) or names - readings - OWN_FILES):
        raise FolderError(f"{folder}: holds no study of this program; choose another --out")


# ---- statements, which statements.toml lists in our words


Statement = dict[str, Any]  # a table of statements.toml, whose head explains its keys

STATEMENTS: list[Statement] = table("rolling.studies", "lee2025_statements")["statement"]
SCALES = (10, 20)  # factors of the logarithm in the level of a release power
COLUMNS = ["key", "source", "statement", "criterion", "reading", "scale", "verdict", "measured"]


def outlook(statement: Statement) -> str | None:
    """Return the column of the article's outlook that a statement concerns."""
    for name in OUTLOOK:
        if name in statement["condition"].values():
            return name
    return None


def judge(statement: Statement, cases: pd.DataFrame, scale: int) -> tuple[str, str]:
    """Return the verdict of a reading's cases on a statement, and the measured numbers."""
    if conditions.swept(cases) != outlook(statement):
        return NOT_RUN, ""
    if "roughnesses_um" in statement:
        cases = cases[cases[ROUGHNESS].isin(statement["roughnesses_um"])]
    arguments = dict(statement["condition"])
    condition = getattr(conditions, arguments.pop("name"))
    comparisons = [*condition(cases, statement["column"].format(scale=scale), **arguments)]
    measured = "; ".join(f"{place.place}: {place.measured}" for place in comparisons)
    return conditions.verdict(comparisons), measured


def verdicts(readings: dict[str, pd.DataFrame]) -> pd.DataFrame:
    """Judge all statements by the cases of each reading, with each scale of levels.

    Returns a row for each statement, reading and scale; the scale is 0 without levels.
    """
    rows = []
    for statement in STATEMENTS:
        scales = SCALES if "{scale}" in statement["column"] else (0,)
        for reading, cases in readings.items():
            for scale in scales:
                verdict, measured = judge(statement, cases, scale)
                row = {
                    "key": statement["key"],
                    "source": statement["source"],
                    "statement": statement["sentence"],
                    "criterion": statement["criterion"],
                    "reading": reading,
                    "scale": scale,
                    "verdict": verdict,
                    "measured": measured,
                }
                rows.append(row)
    return pd.DataFrame(rows, columns=COLUMNS)


# ---- tables


def headline(table: pd.DataFrame, cases: pd.DataFrame) -> str:
    """Count the statements that hold, or do not hold, in every reading with both scales."""
    stated = cases.loc[cases["as_stated"], "reading"].unique()
    rows = table[table["reading"].isin(stated) & (table["verdict"] != NOT_RUN)]
    statements = 0
    hold = 0
    partly = 0
    fail = 0
    for _, words in rows.groupby("key")["verdict"]:
        statements += 1
        different = set(words)
        hold += different == {HOLDS}
        partly += different == {IN_PART}
        fail += different == {FAILS}
    return (
        f"Of {statements} judged statements {hold} hold in every reading, {partly} hold in part,"
        f" {fail} do not hold, and {statements - hold - partly - fail} depend on the reading or on"
        " the scale of levels."
    )


def tables(table: pd.DataFrame, cases: pd.DataFrame, scene_files: list[tuple[str, Path]]) -> str:
    """Write tables.md: assumptions of the readings, and their verdicts on all statements."""
    cells = table.groupby(["key", "statement", "criterion", "reading"], sort=False)["verdict"]
    wide = cells.agg(_different_words).unstack("reading", sort=False).reset_index()
    titles = {reading: library.title(file) for reading, file in scene_files}
    assumptions = "\n".join(f"- **{reading}**: {title}" for reading, title in titles.items())
    intro = (
        "Levels are judged with 10 lg of the release power, as in the article's equation, and with"
        " 20 lg. Where the verdicts differ, the one with 10 lg stands first."
    )
    verdict_table = markdown_table(list(wide.columns), wide.to_numpy().tolist())
    parts = [f"**{headline(table, cases)}**", assumptions, intro, verdict_table]
    return "\n\n".join(parts) + "\n"


def _different_words(words: pd.Series) -> str:
    """Join the words of a column that differ, in their order."""
    return " / ".join(dict.fromkeys(words))
