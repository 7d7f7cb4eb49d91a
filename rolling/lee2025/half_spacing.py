"""Checks of verdicts at half the spacing, where twice the grid's error could turn them.

The cases of such a verdict are solved again on the first eighth of their track, on the same
surface. The changes of their numbers from grid to grid are added to the numbers of the study, and
the statement is judged again.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from rolling.accuracy import kept, variants
from rolling.accuracy.variants import Study, Variant
from rolling.check import cost
from rolling.lee2025 import claims, grid_error, study
from rolling.lee2025.checks import GRID, FinerGrid, Place
from rolling.lee2025.measures import HIGH_BAND, HIGH_HZ, newton, ra
from rolling.lee2025.results import READING, JudgedClaim, Judgement, Table
from rolling.lee2025.statements import Claim
from rolling.lee2025.study import Case
from rolling.simulation import pool, simulate
from rolling.simulation.batch import Run
from rolling.simulation.pool import Outcome
from rolling.simulation.result import Result
from rolling.terminal import progress

TIMES = 2  # divisor of the spacing
SHARE = 8  # the track over the part that is solved again
MARGIN = 2.0  # verdicts are checked within so many times the grid's error of their limit
FOLDER = "half-spacing"

Key = tuple[str, Place]  # reading, roughness and load


@dataclass(frozen=True)
class Pair:
    """The same eighth of a case's track on the grid of the study and at half its spacing."""

    own: Case
    fine: Case


def wanted(table: Table, cases: Sequence[Case]) -> list[Key]:
    """List the cases whose grid may turn a verdict of a reading, with a margin.

    Variations count for nothing and are not checked. Numbers whose grid error was not measured
    count as exact.
    """
    keys = {
        (judgement.reading, place): None
        for judged in table.claims
        for judgement in judged.judgements
        for place in _places(table, cases, judged.claim, judgement)
    }
    return sorted(keys)


def _places(
    table: Table, cases: Sequence[Case], claim: Claim, judgement: Judgement
) -> tuple[Place, ...]:
    """Return the cases that may turn a verdict with the grid's error times the margin."""
    grid = grid_error.MEASURED.get(judgement.reading)
    if grid is None or table.kind(judgement.reading) != READING:
        return ()
    group = claims.study_of(cases, judgement, grid.times(MARGIN))
    finding = claims.finding(claim, group)
    return finding.grid_places if GRID in finding.decided_by else ()


# ---- solving


def run_of(key: Key, runs: Mapping[str, Sequence[Run]]) -> Run:
    """Return the run of a case on its first surface."""
    reading, (roughness, load) = key
    return min(
        (
            run
            for run in runs[reading]
            if math.isclose(study.varied(run.scene)[0], roughness)
            and math.isclose(study.varied(run.scene)[1], load)
        ),
        key=lambda run: study.varied(run.scene)[2],
    )


def extent(run: Run) -> tuple[Study, Variant, int]:
    """Return the study of a run at half the spacing, its variant and its number of steps."""
    track = run.scene.track
    alone = Study(run.scene, track.n_along, track.closed, TIMES)
    return alone, alone.on_grid(TIMES, alone.own.edges), track.solved_steps // SHARE


def solve(
    folder: Path, chosen: Sequence[Run], workers: int, name: str
) -> tuple[Outcome, dict[Path, Result]]:
    """Solve the first eighth of runs at half the spacing, as far as it is not stored.

    Parameters
    ----------
    folder : Path. Folder of the checks; each piece is stored when it is done.
    chosen : sequence of Run. The runs.
    workers : int. Number of processes; 0: one per core.
    name : str. Name of the progress bar.

    Returns
    -------
    outcome, results : Outcome and dict. Failures by number of the run; the complete results by
        folder of the run.
    """
    folder.mkdir(exist_ok=True)
    results, todo = [], []
    for number, run in enumerate(chosen):
        _, variant, steps = extent(run)
        results.append(_empty(run, steps))
        for first, last in simulate.pieces(steps):
            piece = kept.load(_path(folder, run, variant, first, last), first, last)
            if piece is not None:
                results[-1].add(piece)
                continue
            arguments = (run.scene, variant, first, last)
            seconds = float(last - first) * run.scene.load ** (2 / 3)
            todo.append(pool.Task(number, variants.march_piece, arguments, seconds))

    def finished(number: int, piece: simulate.Piece) -> None:
        variant = extent(chosen[number])[1]
        kept.save(_path(folder, chosen[number], variant, piece.first, piece.last), piece)
        results[number].add(piece)

    todo.sort(key=lambda task: -task.cost)
    with progress.bar(len(todo), f"{name}: verdicts at half the spacing") as bar:

        def counted(number: int, piece: simulate.Piece) -> None:
            finished(number, piece)
            bar.update(1)

        outcome = pool.work(todo, workers or cost.cores(), counted)
    complete = {
        run.folder: result for run, result in zip(chosen, results, strict=True) if result.complete
    }
    return outcome, complete


def _path(folder: Path, run: Run, variant: Variant, first: int, last: int) -> Path:
    """Return the file of a piece, whose name holds a digest of the scene."""
    place = f"{run.folder.parent.name}_{run.folder.name}"
    digest = simulate.identity_of(run.scene).sha256[:12]
    return folder / f"{place}_{digest}_{variant.name}_{first}-{last}.npz"


def _empty(run: Run, steps: int) -> Result:
    """Return a result of the first steps of a run, without a solved step."""
    whole = Result.empty(run.scene.track, run.scene.start)
    states = dict.fromkeys(simulate.STATE_SERIES, steps + 1)
    lengths = dict.fromkeys(simulate.STEP_SERIES, steps) | states
    series = {name: np.full(length, np.nan) for name, length in lengths.items()}
    return Result(steps, steps, whole.step, whole.start, series)


def pair(reading: str, run: Run, whole: Result, fine: Result) -> Pair:
    """Compare the beginning of a solved run with the same at half the spacing."""
    own = _empty(run, fine.steps)
    for name, values in own.series.items():
        values[:] = whole.series[name][: len(values)]
    return Pair(
        *(study.case(reading, run, result, closed=False) for result in (own, fine)),
    )


# ---- judging


def corrected(case: Case, change: Pair) -> Case:
    """Return a case with the changes that half the spacing brings to its first surface."""
    own, fine = change.own, change.fine

    def more(name: str) -> float:
        before, after = getattr(own, name), getattr(fine, name)
        known = before is not None and after is not None
        return float(after - before) if known and math.isfinite(after - before) else 0.0

    def times(before: float, after: float) -> float:
        ratio = after / before if before else 1.0
        return ratio if math.isfinite(ratio) else 1.0

    high = HIGH_BAND.of(fine, 10) - HIGH_BAND.of(own, 10)
    raised = np.where(case.line_hz >= HIGH_HZ, high if math.isfinite(high) else 0.0, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        bands = fine.band_w / own.band_w
    bands = np.where(np.isfinite(bands) & (bands > 0), bands, 1.0)
    return replace(
        case,
        plastic_ratio=case.plastic_ratio * times(own.plastic_ratio, fine.plastic_ratio),
        contact_ratio=case.contact_ratio * times(own.contact_ratio, fine.contact_ratio),
        deflection=case.deflection * times(own.deflection, fine.deflection),
        laeq_db=None if case.laeq_db is None else case.laeq_db + more("laeq_db"),
        maximum_db=case.maximum_db + more("maximum_db"),
        maximum_20_db=case.maximum_20_db + more("maximum_20_db"),
        line_db=case.line_db + raised,
        band_w=case.band_w * bands,
        a_weighted_w=case.a_weighted_w * times(own.a_weighted_w, fine.a_weighted_w),
    )


def judge(table: Table, cases: Sequence[Case], pairs: Mapping[Key, Pair]) -> Table:
    """Mark the verdicts of a table that were checked at half the spacing."""
    changed = [
        corrected(case, known) if (known := _pair_of(case, pairs)) is not None else case
        for case in cases
    ]

    def marked(judged: JudgedClaim) -> JudgedClaim:
        judgements = tuple(
            _marked(judgement, judged.claim, _checked(judgement, judged.claim), cases, changed)
            for judgement in judged.judgements
        )
        return replace(judged, judgements=judgements)

    def _checked(judgement: Judgement, claim: Claim) -> tuple[Place, ...]:
        places = _places(table, cases, claim, judgement)
        return places if all((judgement.reading, place) in pairs for place in places) else ()

    return replace(table, claims=tuple(map(marked, table.claims)))


def _pair_of(case: Case, pairs: Mapping[Key, Pair]) -> Pair | None:
    """Return the pair of a case's reading, roughness and load."""
    return pairs.get((case.reading, (case.roughness_um, case.load_n)))


def _marked(
    judgement: Judgement,
    claim: Claim,
    places: tuple[Place, ...],
    cases: Sequence[Case],
    changed: Sequence[Case],
) -> Judgement:
    """Return a judgement with its verdict at half the spacing, if all its cases were checked."""
    if not places:
        return judgement
    before, after = (
        claims.finding(claim, claims.study_of(group, judgement, grid_error.NONE)).verdict
        for group in (cases, changed)
    )
    finer = FinerGrid(before, after, places)
    said = f"{before} as before" if not finer.turns else f"{after} instead of {before}"
    where = ", ".join(f"{ra(roughness)} at {newton(load)}" for roughness, load in places)
    measured = (
        f"{judgement.finding.measured}. At half the spacing on an eighth of the track"
        f" ({where}): {said}"
    )
    return replace(judgement, finding=replace(judgement.finding, finer=finer, measured=measured))


def checked(
    table: Table,
    cases: Sequence[Case],
    runs: Mapping[str, Sequence[Run]],
    results: Mapping[Path, Result],
    solver: Callable[[Sequence[Run]], tuple[Outcome, dict[Path, Result]]],
) -> tuple[Table, Outcome]:
    """Solve the cases that verdicts need at half the spacing and mark the verdicts.

    A check that fails leaves its verdicts as they are, and a line says why.
    """
    keys = wanted(table, cases)
    if not keys:
        return table, Outcome()
    chosen = [run_of(key, runs) for key in keys]
    outcome, fine = solver(chosen)
    for number, reason in outcome.failures.items():
        folder = chosen[number].folder
        print(f"not checked at half the spacing: {folder}: {reason}", file=sys.stderr)
    pairs = {
        key: pair(key[0], run, results[run.folder], fine[run.folder])
        for key, run in zip(keys, chosen, strict=True)
        if run.folder in fine
    }
    return judge(table, cases, pairs), outcome
