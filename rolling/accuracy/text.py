"""The results of `rolling accuracy` in words and tables, for the terminal and for accuracy.md."""

from __future__ import annotations

import math
from collections.abc import Sequence

from acoustics.bands import BAND_NAMES, reliable
from rolling import tables
from rolling.accuracy import errors, record
from rolling.accuracy.errors import BANDS, ERRORS, ORDERED, Candidate, Errors, Findings, decibel
from rolling.accuracy.variants import Study, Variant, tolerance_text

WORDS = {
    "signal": "release signal",
    "laeq_db": "LAeq",
    "release_percent": "mean release",
    "contact_area_percent": "contact area",
    "plastic_area_percent": "plastic area",
    "max_pressure_percent": "maximum pressure",
}


def keys(study: Study, variant: Variant) -> str:
    """Return the scene keys of a variant."""
    numerics = (
        f"tolerance: {tolerance_text(variant.tolerance)}, step_nodes: "
        f"{variant.step_nodes * variant.times:g}"
    )
    words = (
        f"surface.spacing_um: {study.spacing_um(variant):g}, numerics: {{{numerics}, edges: "
        f"{variant.edges}"
    )
    return words + (", precision: double}" if variant.precision == "double" else "}")


def _settings(study: Study, v: Variant) -> list[str]:
    """Return the cells with the settings of a variant.

    A star marks a step that is too long for hearing.
    """
    step = f"{study.step_um(v):g}" + ("*" if study.highest(v) < errors.LEAST_NYQUIST else "")
    numerics = [f"{study.spacing_um(v):g}", v.edges, tolerance_text(v.tolerance), step, v.precision]
    return [*numerics, f"{study.width_um(v):g}"]


SETTINGS = ["spacing µm", "edges", "tolerance", "step µm", "precision", "width µm"]


def _shown(value: float, uncertainty: float, digits: int) -> str:
    """Write an error with its sign.

    Brackets mark an error within the reference's own uncertainty.
    """
    if not math.isfinite(value):
        return "lost" if math.isinf(value) else "-"
    text = f"{value:+.{digits}f}"
    return f"({text})" if abs(value) <= uncertainty else text


def _signal(value: float, uncertainty: float) -> str:
    """Write the signal's error in dB.

    Brackets mark an error within the reference's own uncertainty.
    """
    text = "-" if not value or not math.isfinite(value) else f"{decibel(value):.1f}"
    return f"({text})" if value and value <= uncertainty else text


def _errors(e: Errors, uncertainty: Errors, names: Sequence[str]) -> list[str]:
    """Return the cells with the errors of a variant."""
    band, _ = errors.worst_band(e)
    cells = [
        _signal(e["signal"], uncertainty["signal"]),
        _shown(e["laeq_db"], uncertainty["laeq_db"], 3),
    ]
    cells.append(f"{_shown(e[band], uncertainty[band], 2)} at {band}" if band else "-")
    return cells + [_shown(e[name], uncertainty[name], 3) for name in names]


def _main_table(findings: Findings, names: Sequence[str], cost: Sequence[str]) -> str:
    """Write the table of all variants with their costs and errors; failures come last."""
    study = findings.study
    head = [*SETTINGS, *cost, "signal dB", "LAeq dB", "worst third octave dB"]
    rows = [head + [f"{WORDS[name]} %" for name in names] + ["raw rms W"]]
    for v, measurement in findings.measurements.items():
        costs = {
            "ms/step": f"{measurement.step_ms:.2f}",
            "s per s": f"{measurement.seconds_per_second:.1f}",
            "iterations": f"{measurement.iterations:.2f}",
            "convolutions": f"{measurement.convolutions:.2f}",
        }
        cells = _settings(study, v) + [costs[c] for c in cost]
        if v == findings.reference:
            cells += ["reference"] + ["-"] * (2 + len(names))
        elif v in findings.errors:
            cells += _errors(findings.errors[v], findings.uncertainty, names)
        else:
            cells += ["-"] * (3 + len(names))
        rows.append([*cells, f"{measurement.raw_rms:.4g}"])
    for v, reason in findings.failures.items():
        rows.append([*_settings(study, v), f"failed: {reason}"])
    return tables.markdown(rows[0], rows[1:], padded=True)


def compact(findings: Findings) -> str:
    """Write the terminal's text: costs, errors against the reference, recommendation."""
    return "\n".join(
        [_main_table(findings, [], ["s per s"]), "", *_advice(findings), *_notes(findings)]
    )


def text(label: str, findings: Findings) -> str:
    """Write accuracy.md, the numbers of accuracy.json for people."""
    study = findings.study
    closed = "a closed lap" if study.closed else "not closed, faded at both ends"
    length = study.nodes * study.scene.spacing * 1e3
    all_costs = ["ms/step", "s per s", "iterations", "convolutions"]
    parts = [
        f"# Speed against error: {study.scene.name}, {label}",
        f"{length:.4g} mm of track ({study.nodes} nodes), {closed}. s per s: "
        "seconds of computing per second of sound,"
        " on one core.",
        _main_table(findings, ERRORS[2:], all_costs),
        *_notes(findings),
        "## Recommendation",
        "\n".join(f"- {line}" for line in _advice(findings)),
        "## The solve alone",
        "The errors are against the same grid and step, solved to 1e-8 in double precision.",
        _solver_table(findings),
        "## The reference's own error",
        "By edges: difference from the other edges on its grid. By refining: "
        "extrapolation of the ladder of spacings (Richardson,"
        " observed order from 0.5 to 2). The larger counts.",
        _uncertainty_table(findings),
        "## Third octaves",
        _bands_table(findings),
        "## Observed orders",
        "By spacing and step: from the differences between neighbours. By tolerance: "
        "from the errors of the solve alone.",
        _orders_table(findings),
        "## The raw fluctuation",
        _raw(findings),
        "## The width of the surface",
        _width(findings),
        "## The length of the record",
        _record(findings),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def _solver_table(findings: Findings) -> str:
    """Write the table of errors of the solve alone."""
    zero = dict.fromkeys((*ERRORS, *BANDS), 0.0)
    rows = [["tolerance", "precision", "ms/step", "signal dB", "LAeq dB", "worst third octave dB"]]
    rows[0] += [f"{WORDS[name]} %" for name in ERRORS[2:]]
    for v, e in sorted(
        findings.solver_errors.items(), key=lambda item: (-item[0].tolerance, item[0].precision)
    ):
        if v != findings.study.solver_reference:
            cost = f"{findings.measurements[v].step_ms:.2f}"
            rows.append(
                [tolerance_text(v.tolerance), v.precision, cost, *_errors(e, zero, ERRORS[2:])]
            )
    return tables.markdown(rows[0], rows[1:], padded=True)


def _uncertainty_table(findings: Findings) -> str:
    """Write the table of the reference's own error."""

    def number(name: str, e: Errors) -> str:
        if name == "signal":
            return _signal(e[name], 0.0)
        return f"{abs(e[name]):.3f}" if math.isfinite(e[name]) else "-"

    kinds = {
        "by edges": findings.by_edges,
        "by refining": findings.by_refining,
        "larger": findings.uncertainty,
    }
    rows = [["of", *kinds]]
    for name in (*ERRORS, *BANDS):
        word = WORDS.get(name, f"{name} Hz")
        unit = "%" if name.endswith("percent") else "dB"
        rows.append([f"{word} [{unit}]", *(number(name, e) for e in kinds.values())])
    return tables.markdown(rows[0], rows[1:], padded=True)


def _bands_table(findings: Findings) -> str:
    """Write the table of errors of third octaves."""
    rows = [[*SETTINGS, *BANDS]]
    for v, e in findings.errors.items():
        if v != findings.reference:
            cells = [_shown(e[band], findings.uncertainty[band], 2) for band in BANDS]
            rows.append(_settings(findings.study, v) + cells)
    return tables.markdown(rows[0], rows[1:], padded=True)


def _orders_table(findings: Findings) -> str:
    """Write the table of observed orders."""
    rows = [["by", *(WORDS[name] for name in ORDERED)]]
    for name, orders in findings.orders.items():
        rows.append([name, *("-" if math.isnan(p) else f"{p:.2f}" for p in orders.values())])
    return tables.markdown(rows[0], rows[1:], padded=True)


def _raw(findings: Findings) -> str:
    """Write the effect of the step on the unfiltered fluctuation and on the levels."""
    rows = [["step µm", "raw rms W", "level of the audible band: LAeq dB(A)"]]
    for v in findings.study.families()["step"]:
        if v in findings.measurements:
            measurement = findings.measurements[v]
            laeq = "silent" if measurement.laeq_db is None else f"{measurement.laeq_db:.2f}"
            rows.append([f"{findings.study.step_um(v):g}", f"{measurement.raw_rms:.4g}", laeq])
    return (
        "Rms of the release power of each step about its mean. Steps shorter than a node show the "
        "release of single nodes, above"
        " hearing. Where the plate yields, this rms need not converge as the step shrinks, "
        "least of all with sharp edges. The"
        " levels within hearing converge."
        "\n\n" + tables.markdown(rows[0], rows[1:], padded=True)
    )


def _width(findings: Findings) -> str:
    """Write the effect of a wider surface."""
    study, wider, off = findings.study, findings.study.wider, findings.wider
    if wider is None:
        return "Nothing is known beyond the edges of this surface, so it was not made wider."
    if off is None:
        return "The wider surface was not marched."
    band, worst = _wider_band(findings)
    bands = f", third octaves {worst:.2f} dB at most, at {band} Hz" if band else ""
    return (
        f"The scene as it stands, {study.width_um(study.own):g} µm wide, against a surface of"
        f" {study.width_um(wider):g} µm with the same asperities in its middle: release signal"
        f" {_signal(off['signal'], 0.0)} dB, LAeq {_shown(off['laeq_db'], 0.0, 3)} dB{bands},"
        f" mean release {_shown(off['release_percent'], 0.0, 2)} %. The differences are the"
        " influence of the period across."
        f" {_width_advice(findings)}"
    )


def _width_advice(findings: Findings) -> str:
    """Judge the width by the limits of a recommendation."""
    off = findings.wider
    assert off is not None
    band, worst = _wider_band(findings)
    if math.isnan(off["laeq_db"]):
        return "Without sound no level judges the width."
    if abs(off["laeq_db"]) <= errors.LAEQ_LIMIT and not worst > errors.BAND_LIMIT:
        return "The surface is wide enough."
    bands = f", third octaves by up to {worst:.2f} dB" if band else ""
    return (
        f"The width matters: LAeq by {abs(off['laeq_db']):.2f} dB{bands};"
        " take a larger surface.width_um."
    )


def _wider_band(findings: Findings) -> tuple[str, float]:
    """Return the third octave that the width changes most, and this change [dB].

    Bands that the record is too short to read are left out: they hold a few lines only.
    """
    study, off = findings.study, findings.wider
    assert off is not None
    duration = study.scene.motion.duration(study.nodes * study.scene.spacing)
    reads = dict(zip(BAND_NAMES, reliable(duration), strict=True))
    return errors.worst_band({band: off[band] for band in BANDS if reads[band]})


def _record(findings: Findings) -> str:
    """Write the levels of parts of the track against the whole."""
    check = findings.record
    if check is None:
        return "The record is silent or its speed changes, so its parts are not compared."
    rows = [
        [
            f"1/{each.parts}",
            f"{each.duration * 1e3:.3g}",
            f"{each.shift_db:+.2f}",
            f"{each.scatter_db:.2f}",
            f"{each.stated_db:.2f}",
            f"{each.bands_within} of {each.bands}",
        ]
        for each in check.parts
    ]
    head = ["part", "ms", "LAeq, mean less whole", "scatter dB", "stated dB", "bands within"]
    return (
        "Levels of equal parts of the track. *scatter*: standard deviation of their LAeq; *stated*:"
        " their stated uncertainty; *bands within*: third octaves that are off the mean of the"
        " parts by no more than twice the stated uncertainty, of those that a part is long enough"
        " to read.\n\n"
        f"{tables.markdown(head, rows, padded=True)}\n\n{_record_advice(findings)}"
    )


def _record_advice(findings: Findings) -> str:
    """Return the duration that a record needs."""
    check = findings.record
    assert check is not None
    return (
        f"LAeq of these {check.duration * 1e3:.3g} ms is uncertain by"
        f" {check.uncertainty_db:.2f} dB; {record.AIM_DB:g} dB take about"
        f" {check.needed_s:.2g} s of rolling"
    )


def _advice(findings: Findings) -> list[str]:
    """Return the lines of the recommendation."""
    if findings.reference is None:
        return ["no reference, no recommendation"]
    if findings.silent:
        return [
            "the reference is silent: release, areas and pressure can be compared, levels cannot"
        ]
    advice, lines = findings.recommendation, []
    limits = f"LAeq within {errors.LAEQ_LIMIT} dB and third octaves within {errors.BAND_LIMIT} dB"
    if advice.both:
        lines.append(f"cheapest with {limits}: {_offer(findings, advice.both)}")
    else:
        nearest = f"; nearest: {_offer(findings, advice.nearest)}" if advice.nearest else ""
        lines.append(f"none keeps {limits}, the reference's own uncertainty counted in{nearest}")
    band, off = errors.worst_band(
        {name: u for name, u in findings.uncertainty.items() if math.isfinite(u)}
    )
    if off > errors.BAND_LIMIT:
        finer = 2 * findings.study.finest
        lines.append(
            f"the reference itself may be off by {off:.2f} dB at {band} Hz; "
            f"--finest {finer} makes a finer one"
        )
    if advice.laeq_only:
        lines.append(
            f"cheapest with LAeq within {errors.LAEQ_LIMIT} dB: "
            f"{_offer(findings, advice.laeq_only)}"
        )
    lines.append(_tolerance_advice(findings))
    study = findings.study
    if findings.wider is not None and study.wider is not None:
        change = _shown(findings.wider["laeq_db"], 0.0, 3)
        lines.append(
            f"a surface of {study.width_um(study.wider):g} µm instead of"
            f" {study.width_um(study.own):g} µm changes LAeq by {change} dB. "
            + _width_advice(findings).rstrip(".")
        )
    return [*lines, *([_record_advice(findings)] if findings.record is not None else [])]


def _tolerance_advice(findings: Findings) -> str:
    """Return the recommended tolerance, compared with that of the run."""
    wanted = "error of the solve of at most a fifth of the grid's and -40 dB"
    own = findings.study.own.tolerance
    if findings.tolerance is None:
        return f"no tolerance that was tried keeps the {wanted}"
    comparison = (
        "the same"
        if math.isclose(findings.tolerance, own)
        else "tighter"
        if own < findings.tolerance
        else "looser"
    )
    loosest = tolerance_text(findings.tolerance)
    return (
        f"the loosest tolerance with an {wanted} is {loosest}; "
        f"the run's {tolerance_text(own)} is {comparison}"
    )


def _offer(findings: Findings, candidate: Candidate) -> str:
    """Return the keys, the cost and the errors of a candidate."""
    variant = next(v for v in findings.measurements if v.name == candidate.name)
    return (
        f"{keys(findings.study, variant)}: {candidate.seconds_per_second:.1f} s per s,"
        f" LAeq {candidate.laeq_db:.3f} dB, third octaves {candidate.band_db:.2f} dB at most"
    )


def _notes(findings: Findings) -> list[str]:
    """Return the notes on brackets and stars in the tables."""
    notes = (
        ["(in brackets): no larger than the reference's own uncertainty"] if findings.errors else []
    )
    if any(findings.study.highest(v) < errors.LEAST_NYQUIST for v in findings.measurements):
        notes.append(
            "*: the step is too long for hearing, its Nyquist frequency is below 20 kHz; "
            "third octaves above are lost"
        )
    return notes
