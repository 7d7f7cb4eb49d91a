"""What `rolling accuracy` found, in words and tables that people and Markdown can read. Depends on accuracy and variants."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rolling.accuracy import errors
from rolling.accuracy.errors import BANDS, ERRORS, ORDERED, Candidate, Errors, Findings, decibel
from rolling.accuracy.variants import Study, Variant, tolerance_text

WORDS = {
    "signal": "release signal",
    "laeq_db": "LAeq",
    "release_percent": "mean release",
    "contact_area_percent": "contact area",
    "plastic_area_percent": "plastic area",
    "max_pressure_percent": "greatest pressure",
}


def keys(what: Study, variant: Variant) -> str:
    """The scene keys of a variant."""
    numerics = f"tolerance: {tolerance_text(variant.tolerance)}, step_nodes: {variant.step_nodes * variant.times:g}"
    words = f"surface.spacing_um: {what.spacing_um(variant):g}, numerics: {{{numerics}, edges: {variant.edges}"
    return words + (", precision: double}" if variant.precision == "double" else "}")


def _settings(what: Study, v: Variant) -> list[str]:
    step = f"{what.step_um(v):g}" + ("*" if what.highest(v) < errors.LEAST_NYQUIST else "")
    return [f"{what.spacing_um(v):g}", v.edges, tolerance_text(v.tolerance), step, v.precision]


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
    band, _ = errors.worst_band(e)
    cells = [_signal(e["signal"], uncertainty["signal"]), _shown(e["laeq_db"], uncertainty["laeq_db"], 3)]
    cells.append(f"{_shown(e[band], uncertainty[band], 2)} at {band}" if band else "-")
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


def compact(found: Findings) -> str:
    """For the terminal: cost, errors against the reference, advice."""
    return "\n".join([_main_table(found, [], ["s per s"]), "", *_advice(found), *_notes(found)])


def text(label: str, found: Findings) -> str:
    """accuracy.md: everything that accuracy.json says, for people."""
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
            rows.append([f"{found.study.step_um(v):g}", f"{one.raw_rms:.4g}", laeq])
    return (
        "Rms of the release power of each step about its mean. Steps shorter than a node show how nodes are released one by one,"
        " above hearing: where the plate yields this need not converge as the step shrinks, least with sharp edges. The levels"
        " within hearing do."
        "\n\n" + _columns(rows)
    )


def _advice(found: Findings) -> list[str]:
    if found.reference is None:
        return ["no reference, no recommendation"]
    if found.silent:
        return ["the reference is silent: release, areas and pressure can be compared, levels cannot"]
    advice, lines = found.recommendation, []
    limits = f"LAeq within {errors.LAEQ_LIMIT} dB and third octaves within {errors.BAND_LIMIT} dB"
    if advice.both:
        lines.append(f"cheapest with {limits}: {_offer(found, advice.both)}")
    else:
        nearest = f"; nearest: {_offer(found, advice.nearest)}" if advice.nearest else ""
        lines.append(f"none keeps {limits}, the reference's own uncertainty counted in{nearest}")
    band, off = errors.worst_band({name: u for name, u in found.uncertainty.items() if math.isfinite(u)})
    if off > errors.BAND_LIMIT:
        finer = 2 * found.study.finest
        lines.append(
            f"the reference itself may be off by {off:.2f} dB at {band} Hz; --finest {finer} makes a finer one"
        )
    if advice.laeq_only:
        lines.append(f"cheapest with LAeq within {errors.LAEQ_LIMIT} dB: {_offer(found, advice.laeq_only)}")
    return [*lines, _tolerance_advice(found)]


def _tolerance_advice(found: Findings) -> str:
    wanted = "error of the solve of at most a fifth of the grid's and -40 dB"
    default = errors.default_tolerance()
    if found.tolerance is None:
        return f"no tolerance that was tried keeps the {wanted}"
    same = (
        "the same" if math.isclose(found.tolerance, default) else "tighter" if default < found.tolerance else "looser"
    )
    told = tolerance_text(found.tolerance)
    return (
        f"the loosest tolerance with an {wanted} is {told}; the program's default {tolerance_text(default)} is {same}"
    )


def _offer(found: Findings, one: Candidate) -> str:
    variant = next(v for v in found.measured if v.name == one.name)
    return (
        f"{keys(found.study, variant)}: {one.seconds_per_second:.1f} s per s, LAeq {one.laeq_db:.3f} dB, third octaves"
        f" {one.band_db:.2f} dB at most"
    )


def _notes(found: Findings) -> list[str]:
    notes = ["(in brackets): no more than what the reference itself may be off"] if found.errors else []
    if any(found.study.highest(v) < errors.LEAST_NYQUIST for v in found.measured):
        notes.append(
            "*: too long a step for hearing, its Nyquist frequency is below 20 kHz; third octaves above are lost"
        )
    return notes
