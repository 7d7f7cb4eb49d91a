"""The command `rolling accuracy SCENE`, which marches the variants of a scene and compares them."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rolling.accuracy import errors, kept, plot, text
from rolling.accuracy.errors import Findings, Measurement
from rolling.accuracy.record import AIM_DB, RecordCheck
from rolling.accuracy.variants import Study, Variant, study_of, tasks
from rolling.check import cost, long_steps, refusals
from rolling.contact import of_scene
from rolling.folders import claim, files, new_folder, own_files, run_record
from rolling.folders.claim import Claim
from rolling.scene import file, library
from rolling.simulation import pool, simulate, summary, tolerance_trial
from rolling.simulation.batch import Run
from rolling.simulation.result import Result
from rolling.terminal import defaults, progress


def run_study(
    scene_path: Path,
    overrides: Sequence[str] = (),
    out: Path | None = None,
    force: bool = False,
    workers: int = 0,
    finest: int = defaults.FINEST,
    duration: float = defaults.ACCURACY_SECONDS,
) -> int:
    """March all variants of the first run of a scene file, print the table, write the folder.

    A study in `out` that was stopped goes on with the pieces of variants that it holds.

    Parameters
    ----------
    scene_path : Path. The scene file, or the name of a scene of the library.
    overrides : sequence of str. Values of keys, as after --set. Default: none.
    out : Path or None. Folder of the study. Default: None, for a folder below outputs/.
    force : bool. If true, replace an earlier study. Default: False.
    workers : int. Number of processes. Default: 0, for one per core.
    finest : int. Divisor of the spacing for the reference. Default: `defaults.FINEST`.
    duration : float, s. Duration of rolling. Default: `defaults.ACCURACY_SECONDS`.

    Returns
    -------
    code : int. The exit code.

    Raises
    ------
    SceneError, FolderError : before anything is computed or written.
    """
    scene = file.read_scene(scene_path, overrides)
    runs = scene.runs()
    values, single = runs[0]
    long_steps.refuse_long_steps(single)
    study = study_of(single, duration, finest)
    refusals.refuse_variants_that_cannot_fit(study.scene, finest, workers, out or refusals.OUTPUTS)
    # this refuses a missing surface before anything is written
    of_scene.rolling_contact(study.scene)
    label = Run(values, single, Path()).label
    if len(runs) > 1:
        progress.line(
            f"the first of {len(runs)} runs of the sweep: {label}; choose another with --set "
            f"{next(iter(values))}=..."
        )
    # `auto` is the tolerance that the run of the scene would take. The trial is the same again.
    choices = tolerance_trial.choose([single], [Result.empty(single.track, single.start)], workers)
    if choices.interrupted:
        print("interrupted in the trial of the tolerance: nothing was written", file=sys.stderr)
        return 130
    study = study_of(choices.scenes[0], duration, finest)
    with _claimed(study, library.find(scene_path), out, force) as held:
        results, interrupted = _march(study, held.folder, workers or cost.cores())
        with progress.step("writing tables and picture"):
            _write(held.folder, label, results)
        if progress.is_quiet():
            print(held.folder)
        else:
            print(text.compact(results))
            print(f"\ntables, picture, numbers: {held.folder}")
        return _ended(held, results, interrupted)


def _claimed(study: Study, scene_path: Path, out: Path | None, force: bool) -> Claim:
    """Claim the folder of a study, new or of the same study that was stopped.

    Raises
    ------
    FolderError : the folder holds something else, or another process works on it.
    """
    if out is not None and not force and new_folder.is_unfinished(out, "accuracy"):
        kept.refuse_other_study(out, study)
        return claim.take(out, "accuracy")
    scene = study.scene
    given = scene_path.read_bytes()
    inputs = [scene_path, *([scene.height_path] if scene.height_path is not None else [])]
    target = new_folder.aim(
        Path("outputs") / f"{scene.name}-accuracy", out, force, ["accuracy"], inputs
    )

    def fill(folder: Path) -> None:
        files.write_bytes(folder / "scene.yaml", given)
        kept.write_study(folder, study)

    return new_folder.make(target, run_record.new("accuracy"), fill)


def _ended(held: Claim, results: Findings, interrupted: bool) -> int:
    """Write the state of the study, give the reason if it is not done, and return the exit code."""
    if interrupted:
        held.mark(held.folder, "waiting", claim.INTERRUPTED)
        count = len(results.measurements)
        reason = (
            f"interrupted: the tables hold the {count} variants that were finished"
            if count
            else "interrupted before a variant was finished"
        )
        reason += f"; the same command with --out {held.folder} goes on"
    elif results.reference is None:
        reason = "the reference failed: there are no errors to show"
        held.mark(held.folder, "failed", reason)
    else:
        held.mark(held.folder, "done")
        kept.remove_pieces(held.folder)
        if stays := new_folder.drop_previous(held):
            print(
                f"{stays} stays: it holds files that this program did not write, or is in use",
                file=sys.stderr,
            )
        return 0
    print(reason, file=sys.stderr)
    if held.record.replaces:
        print(f"{new_folder.previous(held.folder)} stays until this study is done", file=sys.stderr)
    return 130 if interrupted else 1


def _march(study: Study, folder: Path, workers: int) -> tuple[Findings, bool]:
    """March the pieces that the folder lacks, and write each as it is done.

    A variant's numbers follow its last piece.
    """
    variants = study.variants()
    every = tasks(study, variants)
    missing = Counter(task.run for task in every)
    pieces: dict[int, list[simulate.Piece]] = {number: [] for number in missing}
    done: dict[Variant, Measurement] = {}

    def added(number: int, piece: simulate.Piece) -> None:
        pieces[number].append(piece)
        if len(pieces[number]) == missing[number]:
            measurement = errors.measure(study, variants[number], pieces.pop(number))
            done[measurement.variant] = measurement
            progress.detail(_measurement_text(measurement))
            files.write_json(
                folder / own_files.VARIANTS / f"{measurement.variant.name}.json", _row(measurement)
            )

    def finished(number: int, piece: simulate.Piece) -> None:
        kept.write_piece(folder, variants[number], piece)
        added(number, piece)

    todo = []
    for task in every:
        _, variant, first, last = task.arguments
        piece = kept.read_piece(folder, variant, first, last)
        if piece is None:
            todo.append(task)
        else:
            added(task.run, piece)
    if len(todo) < len(every):
        progress.line(f"going on: {len(every) - len(todo)} of {len(every)} pieces were marched")
    total = sum(task.cost for task in todo)
    with progress.bar(total, f"{study.scene.name}: {len(variants)} variants") as bar:
        outcome = pool.work(todo, workers, finished, bar.update)
    failures = {variants[number]: reason for number, reason in outcome.failures.items()}
    with progress.step("comparing the variants"):
        measurements = {v: done[v] for v in sorted(done, key=_in_table)}
        return errors.judge(study, measurements, failures), outcome.interrupted


def _in_table(variant: Variant) -> tuple[Any, ...]:
    """Return the sorting key of a variant in the tables."""
    return (
        variant.times,
        variant.edges != "sharp",
        variant.step_nodes,
        variant.precision,
        -variant.tolerance,
        variant.width,
    )


def _measurement_text(measurement: Measurement) -> str:
    """Write steps, iterations and time of a variant."""
    return (
        f"{measurement.variant.name}: {measurement.steps} steps of {measurement.step_ms:.2f} ms,"
        f" {measurement.iterations:.1f} iterations per step"
    )


# ---- numbers


def _row(measurement: Measurement) -> dict[str, Any]:
    """Return the numbers of a variant for JSON."""
    facts = {
        name: value
        for name, value in vars(measurement).items()
        if name not in ("variant", "intensity", "release_energy")
    }
    return {"name": measurement.variant.name, **asdict(measurement.variant), **errors.plain(facts)}


def _numbers(label: str, results: Findings) -> dict[str, Any]:
    """Return all numbers of the study for accuracy.json."""
    study, plain = results.study, errors.plain
    rows = []
    for variant, measurement in results.measurements.items():
        row = _row(measurement) | {
            "keys": text.keys(study, variant),
            "highest_hz": study.highest(variant),
        }
        row["errors"] = plain(results.errors[variant]) if variant in results.errors else None
        row["solver_errors"] = (
            plain(results.solver_errors[variant]) if variant in results.solver_errors else None
        )
        rows.append(row)
    advice = results.recommendation
    return {
        "name": study.scene.name,
        "run": label,
        "scene": study.scene.to_dict(),
        "track": {
            "nodes": study.nodes,
            "closed": study.closed,
            "length_m": study.nodes * study.scene.spacing,
        },
        "own": study.own.name,
        "reference": results.reference.name if results.reference else None,
        "solver_reference": study.solver_reference.name,
        "variants": rows,
        "failures": {variant.name: reason for variant, reason in results.failures.items()},
        "reference_uncertainty": {
            "by_edges": plain(results.by_edges),
            "by_refining": plain(results.by_refining),
            "larger": plain(results.uncertainty),
        },
        "orders": {name: plain(orders) for name, orders in results.orders.items()},
        "wider": plain(results.wider) if results.wider is not None else None,
        "record": _record(results.record),
        "limits_db": {"laeq": errors.LAEQ_LIMIT, "third_octave": errors.BAND_LIMIT},
        "recommendation": {
            name: plain(asdict(candidate)) if (candidate := getattr(advice, name)) else None
            for name in ("both", "laeq_only", "nearest")
        },
        "tolerance": {"recommended": results.tolerance, "own": study.own.tolerance},
        "provenance": summary.provenance(study.scene),
    }


def _record(check: RecordCheck | None) -> dict[str, Any] | None:
    """Return the numbers of the record's length for JSON."""
    if check is None:
        return None
    return asdict(check) | {"needed_s": check.needed_s, "aim_db": AIM_DB}


def _write(folder: Path, label: str, results: Findings) -> None:
    """Write accuracy.json, accuracy.md and the picture."""
    files.write_json(folder / "accuracy.json", _numbers(label, results))
    files.write_bytes(folder / "accuracy.md", text.text(label, results).encode())
    # a plot needs sound and more than the reference
    if any(e["signal"] > 0 for e in results.errors.values()):
        plot.write(folder, label, results)
