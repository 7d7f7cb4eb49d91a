"""The command `rolling accuracy SCENE`: has the variants of a scene marched, and writes what they cost and how far they are off.

Depends on variants, accuracy, accuracy_text and accuracy_plot, and on pool and store for the work and its files.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from tqdm import tqdm

from rolling.accuracy import errors, plot, text
from rolling.accuracy.errors import Findings, Measured
from rolling.accuracy.variants import Study, Variant, study, tasks
from rolling.check import cost, findings, long_steps
from rolling.folders import claim, files, new_folder, run_record
from rolling.folders.claim import Claim
from rolling.scene import file
from rolling.scene.scene import expand
from rolling.simulation import pool, simulate, summary
from rolling.simulation.batch import Run
from rolling.surface import contact_of_scene


def report(
    scene_path: Path,
    overrides: Sequence[str] = (),
    out: Path | None = None,
    force: bool = False,
    workers: int = 0,
    finest: int = 4,
    duration: float = 0.045,
) -> int:
    """March all variants of the first run of a scene file, print the table and write the folder; returns the exit code.

    Raises
    ------
    SceneError, FolderError : before anything is computed or written.
    """
    scene = file.load(scene_path, overrides)
    runs = expand(scene)
    values, single = runs[0]
    long_steps.refuse_long_steps(single)
    what = study(single, duration, finest)
    findings.refuse_variants_that_cannot_fit(what.scene, finest, workers, out or findings.OUTPUTS)
    contact_of_scene.rolling_contact(what.scene)  # a surface that cannot be had shows before anything is written
    given = scene_path.read_bytes()
    inputs = [scene_path, *([scene.height_path] if scene.height_path is not None else [])]
    target = new_folder.aim(Path("outputs") / f"{scene.name}-accuracy", out, force, ["accuracy"], inputs)

    def fill(folder: Path) -> None:
        files.write_bytes(folder / "scene.yaml", given)

    label = Run(values, single, target.folder).label
    if len(runs) > 1:
        print(
            f"the first of {len(runs)} runs of the sweep: {label}; choose another with --set {next(iter(values))}=..."
        )
    with new_folder.make(target, run_record.new("accuracy"), fill) as held:
        found, interrupted = _marched(what, held.folder, workers or cost.cores())
        _write(held.folder, label, found)
        print(text.compact(found))
        print(f"\ntables, picture, numbers: {held.folder}")
        return _ended(held, found, interrupted)


def _ended(held: Claim, found: Findings, interrupted: bool) -> int:
    """Write the state that the study came to, say why it is not done, and return the exit code."""
    if interrupted:
        held.mark(held.folder, "waiting", claim.INTERRUPTED)
        reason = "interrupted: the tables hold the variants that were finished"
    elif found.reference is None:
        reason = "the reference failed: there are no errors to show"
        held.mark(held.folder, "failed", reason)
    else:
        held.mark(held.folder, "done")
        if stays := new_folder.drop_previous(held):
            print(f"{stays} stays: it holds what this program did not write, or is in use", file=sys.stderr)
        return 0
    print(reason, file=sys.stderr)
    if held.record.replaces:
        print(f"{new_folder.previous(held.folder)} stays until this study is done", file=sys.stderr)
    return 130 if interrupted else 1


def _marched(what: Study, folder: Path, workers: int) -> tuple[Findings, bool]:
    """Each variant is written as soon as its last piece is done."""
    variants = what.variants()
    todo = tasks(what, variants)
    missing = Counter(task.run for task in todo)
    pieces: dict[int, list[simulate.Piece]] = {number: [] for number in missing}
    done: dict[Variant, Measured] = {}
    (folder / "variants").mkdir()

    def finished(number: int, piece: simulate.Piece) -> None:
        pieces[number].append(piece)
        if len(pieces[number]) == missing[number]:
            one = errors.measured(what, variants[number], pieces.pop(number))
            done[one.variant] = one
            files.write_json(folder / "variants" / f"{one.variant.name}.json", _row(one))

    total = sum(task.cost for task in todo)
    layout = "{desc} {percentage:3.0f}%|{bar}| {elapsed}<{remaining}"
    with tqdm(total=total, disable=None, desc=f"{what.scene.name}: {len(variants)} variants", bar_format=layout) as bar:
        outcome = pool.work(todo, workers, finished, bar.update)
    failures = {variants[number]: reason for number, reason in outcome.failures.items()}
    return errors.judge(what, {v: done[v] for v in sorted(done, key=_in_table)}, failures), outcome.interrupted


def _in_table(v: Variant) -> tuple[Any, ...]:
    return v.times, v.edges != "sharp", v.step_nodes, v.precision, -v.tolerance


# ---- numbers ---------------------------------------------------------------------------------------------------------


def _row(one: Measured) -> dict[str, Any]:
    facts = {k: v for k, v in vars(one).items() if k not in ("variant", "intensity")}
    return {"name": one.variant.name, **asdict(one.variant), **errors.plain(facts)}


def _numbers(label: str, found: Findings) -> dict[str, Any]:
    what, plain = found.study, errors.plain
    rows = []
    for variant, one in found.measured.items():
        row = _row(one) | {"keys": text.keys(what, variant), "highest_hz": what.highest(variant)}
        row["errors"] = plain(found.errors[variant]) if variant in found.errors else None
        row["solver_errors"] = plain(found.solver_errors[variant]) if variant in found.solver_errors else None
        rows.append(row)
    advice = found.recommendation
    return {
        "name": what.scene.name,
        "run": label,
        "scene": what.scene.to_dict(),
        "track": {"nodes": what.nodes, "closed": what.closed, "length_m": what.nodes * what.scene.spacing},
        "own": what.own.name,
        "reference": found.reference.name if found.reference else None,
        "solver_reference": what.solver_reference.name,
        "variants": rows,
        "failures": {variant.name: reason for variant, reason in found.failures.items()},
        "reference_uncertainty": {
            "by_edges": plain(found.by_edges),
            "by_refining": plain(found.by_refining),
            "larger": plain(found.uncertainty),
        },
        "orders": {name: plain(orders) for name, orders in found.orders.items()},
        "limits_db": {"laeq": errors.LAEQ_LIMIT, "third_octave": errors.BAND_LIMIT},
        "recommendation": {
            name: plain(asdict(one)) if (one := getattr(advice, name)) else None
            for name in ("both", "laeq_only", "nearest")
        },
        "tolerance": {"recommended": found.tolerance, "default": errors.default_tolerance()},
        "provenance": summary.provenance(what.scene),
    }


def _write(folder: Path, label: str, found: Findings) -> None:
    files.write_json(folder / "accuracy.json", _numbers(label, found))
    files.write_bytes(folder / "accuracy.md", text.text(label, found).encode())
    if any(e["signal"] > 0 for e in found.errors.values()):  # neither silent nor only the reference
        plot.write(folder, label, found)
