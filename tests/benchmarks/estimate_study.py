"""Test of the error estimate: estimated errors against errors from a fine grid on the whole track.

`python -m rolling.accuracy.estimate_study [SCENE...]` runs the scenes of `SCENES` or some of them,
prints a table in Markdown and writes all numbers to a JSON file.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tqdm import tqdm

from acoustics.bands import BAND_NAMES, reliable
from rolling import tables
from rolling.accuracy import errors
from rolling.accuracy.variants import Study, tasks
from rolling.check import cost
from rolling.contact.solver import ContactError
from rolling.folders import files
from rolling.scene.scene import Scene
from rolling.simulation import pool, simulate, solving, tolerance_trial
from rolling.simulation.result import Result
from rolling.simulation.run_result import RunResult, hear

DURATION_S = 0.16  # 8,000 steps
NEAR_DB = 0.3  # an estimate is right within this error, or within twice its standard error
SCENES: dict[str, dict[str, Any]] = {  # changes of the base scene
    "Ra 0.01, 0.3 N": {"surface.roughness_ra_um": 0.01},
    "Ra 0.1, 0.3 N": {},
    "Ra 0.3, L 20, 0.5 N": {
        "surface.roughness_ra_um": 0.3,
        "surface.correlation_length_um": 20,
        "surface.width_um": 224,
        "rolling.load_n": 0.5,
    },
    "Ra 0.5, 3 GPa, 0.3 N": {
        "surface.roughness_ra_um": 0.5,
        "surface.width_um": 224,
        "plate.hardness_gpa": 3,
    },
    "Ra 1, 0.3 N": {"surface.roughness_ra_um": 1.0, "surface.width_um": 384},
    "L 6, 6.3 GPa, 0.5 N": {
        "plate.hardness_gpa": 6.3,
        "surface.correlation_length_um": 6,
        "rolling.load_n": 0.5,
    },
    "exponential, 4 GPa, 0.3 N": {
        "plate.hardness_gpa": 4,
        "surface.autocorrelation": "exponential",
        "surface.width_um": 192,
    },
    "elastic, 0.5 N": {
        "plate.hardness_gpa": None,
        "surface.width_um": 192,
        "rolling.load_n": 0.5,
    },
}
_BASE: dict[str, Any] = {
    "name": "estimate",
    "sphere": {"radius_mm": 5},
    "plate": {"youngs_modulus_gpa": 210, "poissons_ratio": 0.3, "hardness_gpa": 2.1},
    "surface": {
        "kind": "gaussian",
        "roughness_ra_um": 0.1,
        "correlation_length_um": 10,
        "spacing_um": 2,
        "width_um": 128,
        "seed": 11,
    },
    "rolling": {"load_n": 0.3, "speed_m_s": 0.1, "duration_s": DURATION_S},
    "numerics": {"error_estimate": True, "tolerance": 1e-4},
}


@dataclass(frozen=True)
class BandRow:
    """Errors [dB] of a band or of LAeq: estimated, its standard error, and the true error."""

    name: str
    estimated: float
    uncertainty: float
    true: float

    @property
    def off(self) -> float:
        """Estimated error less true error [dB]."""
        return self.estimated - self.true

    @property
    def right(self) -> bool:
        """Whether the estimate is near, or within twice its standard error."""
        return abs(self.off) <= max(NEAR_DB, 2 * self.uncertainty)


@dataclass(frozen=True)
class Comparison:
    """The estimate of a scene and its errors against the reference.

    name : str. Name of the scene.
    laeq : BandRow. LAeq.
    bands : list of BandRow. Third octaves.
    stretches, steps : int. Effort of the estimate.
    order, seconds_share : float. Order of convergence, and share of the run's time.
    """

    name: str
    laeq: BandRow
    bands: list[BandRow]
    stretches: int
    steps: int
    order: float
    seconds_share: float

    @property
    def right(self) -> int:
        """Number of bands that are estimated right."""
        return sum(row.right for row in self.bands)


def scene_of(name: str, **changes: Any) -> Scene:
    """Return a scene of the study with further changes."""
    return Scene.from_dict(_BASE).with_(SCENES[name] | changes)


def compare(
    name: str, scene: Scene, finest: int, workers: int = 0, progress: bool | None = None
) -> Comparison:
    """Run a scene with its estimate, march its whole track on a fine grid, and compare.

    Bands that are uncertain by 2 dB or more are left out: they hold a few lines only, whose errors
    scatter.

    Parameters
    ----------
    name : str. Name in the table.
    scene : Scene. A scene without a sweep that asks for an estimate.
    finest : int. Divisor of the spacing for the reference.
    workers : int. Number of processes. Default: 0, for one per core.
    progress : bool. Whether progress bars are shown. Default: on a terminal.

    Raises
    ------
    ContactError : a march failed.
    """
    result = Result.empty(scene.track, scene.start)
    (scene,) = tolerance_trial.choose([scene], [result], workers, progress).scenes
    run = _run(name, scene, result, workers, progress)
    reference = _reference(scene, finest, workers, progress)
    assert run.errors is not None and run.errors.levels is not None and run.errors.effort
    levels, effort = run.errors.levels, run.errors.effort
    total = run.errors.total_db
    spread = run.errors.grid_uncertainty_db
    rows = []
    certain = dict(zip(BAND_NAMES, reliable(run.sound.duration), strict=True))
    for band in errors.BANDS:
        own, fine = run.sound.levels.third_octave_db[band], reference.third_octave_db[band]
        estimated = total[band]
        if own is None or fine is None or estimated is None or not certain[band]:
            continue
        rows.append(BandRow(band, estimated, spread[band] or math.inf, own - fine))
    assert run.sound.levels.laeq_db is not None and reference.laeq_db is not None
    laeq = BandRow(
        "LAeq",
        levels.laeq_grid_db + levels.laeq_solver_db,
        levels.laeq_grid_uncertainty_db,
        run.sound.levels.laeq_db - reference.laeq_db,
    )
    return Comparison(
        name,
        laeq,
        rows,
        effort.stretches,
        effort.steps,
        levels.order,
        effort.seconds_share,
    )


def _run(name: str, scene: Scene, result: Result, workers: int, progress: bool | None) -> RunResult:
    """Run a scene in memory."""
    result.identity = simulate.identity_of(scene)
    outcome = solving.solve([scene], [result], workers, name, mapped=False, progress=progress)
    raise_failures(outcome)
    run = hear(name, {}, Path(), scene, result)
    assert run is not None
    return run


def _reference(
    scene: Scene, finest: int, workers: int, progress: bool | None
) -> errors.Measurement:
    """March the whole track of a scene on a fine grid at a tight tolerance."""
    track = scene.track
    study = Study(scene, track.n_along, track.closed, finest)
    variant = study.reference(study.own.edges)
    pieces: list[simulate.Piece] = []
    todo = tasks(study, [variant])
    show = progress if progress is None else not progress

    def finished(run: int, piece: simulate.Piece) -> None:
        pieces.append(piece)

    with tqdm(total=sum(task.cost for task in todo), disable=show, desc="reference") as bar:
        outcome = pool.work(todo, workers or cost.cores(), finished, bar.update)
    raise_failures(outcome)
    return errors.measure(study, variant, pieces)


def raise_failures(outcome: pool.Outcome) -> None:
    """Raise the failure or the interruption of a march.

    Raises
    ------
    ContactError : a march failed.
    KeyboardInterrupt : the work was interrupted.
    """
    if outcome.interrupted:
        raise KeyboardInterrupt
    for reason in outcome.failures.values():
        raise ContactError(reason)


def table(comparisons: Sequence[Comparison]) -> str:
    """Write a row for each scene, in Markdown."""
    rows = [
        (
            each.name,
            f"{each.laeq.estimated:+.2f} ± {each.laeq.uncertainty:.2f}",
            f"{each.laeq.true:+.2f}",
            f"{each.right} of {len(each.bands)}",
            f"{max(abs(row.off) for row in each.bands):.1f}",
            f"{each.order:.1f}",
            f"{each.stretches} x {each.steps}",
            f"{each.seconds_share:.0%}",
        )
        for each in comparisons
    ]
    head = (
        "scene",
        "LAeq error, estimated dB",
        "true dB",
        "bands right",
        "worst off dB",
        "order",
        "stretches",
        "time",
    )
    return tables.markdown(head, rows)


def numbers(each: Comparison) -> dict[str, Any]:
    """Return all numbers of a comparison for JSON."""
    rows = [each.laeq, *each.bands]
    return {
        "name": each.name,
        "rows": [vars(row) | {"right": row.right} for row in rows],
        "order": each.order,
        "stretches": each.stretches,
        "steps": each.steps,
        "seconds_share": each.seconds_share,
    }


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the study from the command line and return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m rolling.accuracy.estimate_study")
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help=f"of {', '.join(SCENES)}")
    parser.add_argument("--finest", type=int, default=4, help="divisor of the spacing (4)")
    parser.add_argument("--workers", type=int, default=0, help="processes; 0: one per core")
    parser.add_argument("--seed", type=int, default=11, help="seed of the surfaces (11)")
    parser.add_argument("--duration", type=float, default=DURATION_S, help="seconds of rolling")
    parser.add_argument("--out", type=Path, default=Path("estimate-study.json"))
    given = parser.parse_args(arguments)
    if unknown := [name for name in given.scenes if name not in SCENES]:
        parser.error(f"no scene {unknown[0]!r}; the scenes are {', '.join(SCENES)}")
    done: list[Comparison] = []
    for name in given.scenes or SCENES:
        changes = {"surface.seed": given.seed, "rolling.duration_s": given.duration}
        done.append(compare(name, scene_of(name, **changes), given.finest, given.workers))
        files.write_bytes(
            given.out, json.dumps([numbers(each) for each in done], indent=1).encode()
        )
        print(table(done[-1:]) if len(given.scenes) == 1 else table(done), flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
