"""The command `rolling accuracy SCENE`: has the variants of a scene marched, and writes what they cost and how far they are off.

Depends on variants, accuracy and accuracy_plot, and on pool and store for the work and its files.
"""

from __future__ import annotations

import math
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from tqdm import tqdm

from rolling import accuracy, accuracy_plot, check, pool, scene_file, simulate, store, summary
from rolling.accuracy import BANDS, ERRORS, ORDERED, Candidate, Errors, Findings, Measured
from rolling.accuracy_plot import decibel, spacing_um, step_um, tolerance_text
from rolling.scenario import expand
from rolling.variants import Study, Variant, study, tasks

WORDS = {
    "signal": "release signal",
    "laeq_db": "LAeq",
    "release_percent": "mean release",
    "contact_area_percent": "contact area",
    "plastic_area_percent": "plastic area",
    "max_pressure_percent": "greatest pressure",
}


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
    scene = scene_file.load(scene_path, overrides)
    runs = expand(scene)
    values, single = runs[0]
    what = study(single, duration, finest)
    simulate.rolling_contact(what.scene)  # a surface that cannot be had shows before anything is written
    folder = store.new_folder(Path("outputs") / f"{scene.name}-accuracy", out, force)
    store.write_bytes(folder / "scene.yaml", scene_path.read_bytes())
    label = ", ".join(summary.worded(k, v) for k, v in (values or {"rolling.load_n": scene.load}).items())
    if len(runs) > 1:
        print(
            f"the first of {len(runs)} runs of the sweep: {label}; choose another with --set {next(iter(values))}=..."
        )
    found, interrupted = _marched(what, folder, workers or check.cores())
    _write(folder, label, found)
    print(_compact(found))
    print(f"\ntables, picture, numbers: {folder}")
    if interrupted:
        print("interrupted: the tables hold the variants that were finished", file=sys.stderr)
        return 130
    if found.reference is None:
        print("the reference failed: there are no errors to show", file=sys.stderr)
        return 1
    store.write_bytes(folder / store.FINISHED, (datetime.now(UTC).isoformat(timespec="seconds") + "\n").encode())
    return 0


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
            one = accuracy.measured(what, variants[number], pieces.pop(number))
            done[one.variant] = one
            store.write_json(folder / "variants" / f"{one.variant.name}.json", _row(one))

    total = sum(task.cost for task in todo)
    layout = "{desc} {percentage:3.0f}%|{bar}| {elapsed}<{remaining}"
    with tqdm(total=total, disable=None, desc=f"{what.scene.name}: {len(variants)} variants", bar_format=layout) as bar:
        outcome = pool.work(todo, workers, finished, bar.update)
    failures = {variants[number]: reason for number, reason in outcome.failures.items()}
    return accuracy.judge(what, {v: done[v] for v in sorted(done, key=_in_table)}, failures), outcome.interrupted


def _in_table(v: Variant) -> tuple:
    return v.times, v.edges, v.step_nodes, v.precision, -v.tolerance


# ---- numbers ---------------------------------------------------------------------------------------------------------


def _row(one: Measured) -> dict[str, Any]:
    facts = {k: v for k, v in vars(one).items() if k not in ("variant", "intensity")}
    return {"name": one.variant.name, **asdict(one.variant), **accuracy.plain(facts)}


def _numbers(label: str, found: Findings) -> dict[str, Any]:
    what, plain = found.study, accuracy.plain
    rows = []
    for variant, one in found.measured.items():
        row = _row(one) | {"keys": keys(what, variant), "highest_hz": what.highest(variant)}
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
        "limits_db": {"laeq": accuracy.LAEQ_LIMIT, "third_octave": accuracy.BAND_LIMIT},
        "recommendation": {
            name: plain(asdict(one)) if (one := getattr(advice, name)) else None
            for name in ("both", "laeq_only", "nearest")
        },
        "tolerance": {"recommended": found.tolerance, "default": accuracy.default_tolerance()},
        "provenance": summary.provenance(what.scene),
    }


def _write(folder: Path, label: str, found: Findings) -> None:
    store.write_json(folder / "accuracy.json", _numbers(label, found))
    store.write_bytes(folder / "accuracy.md", _text(label, found).encode())
    if found.errors:
        accuracy_plot.write(folder, label, found)


# ---- text ------------------------------------------------------------------------------------------------------------


def keys(what: Study, variant: Variant) -> str:
    """The scene keys of a variant."""
    numerics = f"tolerance: {tolerance_text(variant.tolerance)}, step_nodes: {variant.step_nodes * variant.times:g}"
    words = f"surface.spacing_um: {spacing_um(what, variant):g}, numerics: {{{numerics}, edges: {variant.edges}"
    return words + (", precision: double}" if variant.precision == "double" else "}")


def _settings(what: Study, v: Variant) -> list[str]:
    step = f"{step_um(what, v):g}" + ("*" if what.highest(v) < accuracy.LEAST_NYQUIST else "")
    return [f"{spacing_um(what, v):g}", v.edges, tolerance_text(v.tolerance), step, v.precision]


SETTINGS = ["spacing µm", "edges", "tolerance", "step µm", "precision"]


def _shown(value: float, uncertainty: float, digits: int) -> str:
    """An error with its sign, in brackets where it is not more than what the reference itself may be off."""
    if not math.isfinite(value):
        return "lost" if math.isinf(value) else "-"
    text = f"{value:+.{digits}f}"
    return f"({text})" if abs(value) <= uncertainty else text


def _signal(value: float, uncertainty: float) -> str:
    text = "-" if not value or not math.isfinite(value) else f"{decibel(value):.1f}"
    return f"({text})" if value and value <= uncertainty else text


def _errors(e: Errors, uncertainty: Errors, names: Sequence[str]) -> list[str]:
    band, worst = accuracy.worst_band(e)
    cells = [_signal(e["signal"], uncertainty["signal"]), _shown(e["laeq_db"], uncertainty["laeq_db"], 3)]
    cells.append(f"{_shown(e[band], uncertainty[band], 2)} at {band}" if band and worst else "-")
    return cells + [_shown(e[name], uncertainty[name], 3) for name in names]


def _main_table(found: Findings, names: Sequence[str], cost: Sequence[str]) -> str:
    what = found.study
    head = [*SETTINGS, *cost, "signal dB", "LAeq dB", "worst third octave dB"]
    rows = [head + [f"{WORDS[name]} %" for name in names] + ["raw rms W"]]
    for v, one in found.measured.items():
        costs = {
            "ms/step": f"{one.step_ms:.2f}",
            "s per s": f"{one.seconds_per_second:.1f}",
            "iterations": f"{one.iterations:.2f}",
            "convolutions": f"{one.convolutions:.2f}",
        }
        cells = _settings(what, v) + [costs[c] for c in cost]
        if v == found.reference:
            cells += ["reference"] + ["-"] * (2 + len(names))
        elif v in found.errors:
            cells += _errors(found.errors[v], found.uncertainty, names)
        else:
            cells += ["-"] * (3 + len(names))
        rows.append([*cells, f"{one.raw_rms:.4g}"])
    for v, reason in found.failures.items():
        rows.append([*_settings(what, v), f"failed: {reason}", *[""] * (len(rows[0]) - len(SETTINGS) - 1)])
    return _columns(rows)


def _columns(rows: Sequence[Sequence[str]]) -> str:
    """A table for people and for Markdown; cells that stand alone in their row (reasons of failure) widen nothing."""
    widths = [max(len(r[k]) for r in rows if not r[k].startswith("failed")) for k in range(len(rows[0]))]
    lines = ["| " + " | ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)) + " |" for row in rows]
    return "\n".join([lines[0], "|" + "|".join("-" * (w + 2) for w in widths) + "|", *lines[1:]])


def _compact(found: Findings) -> str:
    return "\n".join([_main_table(found, [], ["s per s"]), "", *_advice(found), *_notes(found)])


def _text(label: str, found: Findings) -> str:
    what = found.study
    closed = "a closed lap" if what.closed else "not closed, faded at both ends"
    length = what.nodes * what.scene.spacing * 1e3
    all_costs = ["ms/step", "s per s", "iterations", "convolutions"]
    parts = [
        f"# Speed against error: {what.scene.name}, {label}",
        f"{length:.4g} mm of track ({what.nodes} nodes), {closed}. s per s: seconds of computing per second of sound, on one core.",
        _main_table(found, ERRORS[2:], all_costs),
        *_notes(found),
        "## Recommendation",
        "\n".join(f"- {line}" for line in _advice(found)),
        "## The solve alone",
        "Against the same grid and step solved to 1e-8 in double precision.",
        _solver_table(found),
        "## The reference's own error",
        "By edges: the other edges on its grid. By refining: extrapolated from the ladder of spacings (Richardson, observed order"
        " from 0.5 to 2). The larger counts.",
        _uncertainty_table(found),
        "## Third octaves",
        _bands_table(found),
        "## Observed orders",
        "By spacing and step: of the differences between one and the next. By tolerance: of the errors of the solve alone.",
        _orders_table(found),
        "## The raw fluctuation",
        _raw(found),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def _solver_table(found: Findings) -> str:
    zero = dict.fromkeys((*ERRORS, *BANDS), 0.0)
    rows = [["tolerance", "precision", "ms/step", "signal dB", "LAeq dB", "worst third octave dB"]]
    rows[0] += [f"{WORDS[name]} %" for name in ERRORS[2:]]
    for v, e in sorted(found.solver_errors.items(), key=lambda item: (-item[0].tolerance, item[0].precision)):
        if v != found.study.solver_reference:
            cost = f"{found.measured[v].step_ms:.2f}"
            rows.append([tolerance_text(v.tolerance), v.precision, cost, *_errors(e, zero, ERRORS[2:])])
    return _columns(rows)


def _uncertainty_table(found: Findings) -> str:
    def number(name: str, e: Errors) -> str:
        if name == "signal":
            return _signal(e[name], 0.0)
        return f"{abs(e[name]):.3f}" if math.isfinite(e[name]) else "-"

    kinds = {"by edges": found.by_edges, "by refining": found.by_refining, "larger": found.uncertainty}
    rows = [["of", *kinds]]
    for name in (*ERRORS, *BANDS):
        word = WORDS.get(name, f"{name} Hz")
        unit = "%" if name.endswith("percent") else "dB"
        rows.append([f"{word} [{unit}]", *(number(name, e) for e in kinds.values())])
    return _columns(rows)


def _bands_table(found: Findings) -> str:
    rows = [[*SETTINGS, *BANDS]]
    for v, e in found.errors.items():
        if v != found.reference:
            cells = [_shown(e[band], found.uncertainty[band], 2) for band in BANDS]
            rows.append(_settings(found.study, v) + cells)
    return _columns(rows)


def _orders_table(found: Findings) -> str:
    rows = [["by", *(WORDS[name] for name in ORDERED)]]
    for name, orders in found.orders.items():
        rows.append([name, *("-" if math.isnan(p) else f"{p:.2f}" for p in orders.values())])
    return _columns(rows)


def _raw(found: Findings) -> str:
    """What the step does to the unfiltered fluctuation, and what it does to the levels."""
    rows = [["step µm", "raw rms W", "level of the audible band: LAeq dB(A)"]]
    for v in found.study.families()["step"]:
        if v in found.measured:
            one = found.measured[v]
            laeq = "silent" if one.laeq_db is None else f"{one.laeq_db:.2f}"
            rows.append([f"{step_um(found.study, v):g}", f"{one.raw_rms:.4g}", laeq])
    return (
        "Rms of the release power of each step about its mean. Steps shorter than a node show how nodes are released one by one,"
        " above hearing: where the plate yields this grows as the step shrinks and converges to nothing. The levels within hearing"
        " converge.\n\n" + _columns(rows)
    )


def _advice(found: Findings) -> list[str]:
    if found.reference is None:
        return ["no reference, no recommendation"]
    advice, lines = found.recommendation, []
    limits = f"LAeq within {accuracy.LAEQ_LIMIT} dB and third octaves within {accuracy.BAND_LIMIT} dB"
    if advice.both:
        lines.append(f"cheapest with {limits}: {_offer(found, advice.both)}")
    else:
        nearest = f"; nearest: {_offer(found, advice.nearest)}" if advice.nearest else ""
        lines.append(f"none keeps {limits}, the reference's own uncertainty counted in{nearest}")
    if advice.laeq_only:
        lines.append(f"cheapest with LAeq within {accuracy.LAEQ_LIMIT} dB: {_offer(found, advice.laeq_only)}")
    default = accuracy.default_tolerance()
    word = "no tolerance tried" if found.tolerance is None else f"tolerance {tolerance_text(found.tolerance)}"
    same = found.tolerance is not None and math.isclose(found.tolerance, default)
    lines.append(
        f"{word} is the loosest whose error lies 20 dB below that of the grid and at most at -40 dB;"
        f" the program's default {tolerance_text(default)} {'is the same' if same else 'is another'}"
    )
    return lines


def _offer(found: Findings, one: Candidate) -> str:
    variant = next(v for v in found.measured if v.name == one.name)
    return (
        f"{keys(found.study, variant)}: {one.seconds_per_second:.1f} s per s, LAeq {one.laeq_db:.3f} dB, third octaves"
        f" {one.band_db:.2f} dB at most"
    )


def _notes(found: Findings) -> list[str]:
    notes: list[tuple[bool, Callable[[], str]]] = [
        (bool(found.errors), lambda: "(in brackets): no more than what the reference itself may be off"),
        (
            any(found.study.highest(v) < accuracy.LEAST_NYQUIST for v in found.measured),
            lambda: (
                "*: too long a step for hearing, its Nyquist frequency is below 20 kHz; third octaves above are lost"
            ),
        ),
    ]
    return [text() for holds, text in notes if holds]
