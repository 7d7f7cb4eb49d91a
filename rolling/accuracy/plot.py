"""The work-precision diagram of a study: errors against cost, with a curve per varied setting."""

from __future__ import annotations

import math
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.text import Text
from matplotlib.ticker import FuncFormatter, NullFormatter
from matplotlib.transforms import Bbox

from acoustics.plots import COLOURS, LINE_STYLES, MARKERS
from rolling.accuracy.errors import (
    BAND_LIMIT,
    BANDS,
    LAEQ_LIMIT,
    Errors,
    Findings,
    decibel,
    worst_band,
)
from rolling.accuracy.variants import Study, Variant, tolerance_text
from rolling.folders.files import write_bytes

# variant, seconds of computing per second of sound, error
Curve = list[tuple[Variant, float, float]]
Labels = dict[tuple[float, float], str]  # labels by point
OFFSETS = (
    (8, 0),
    (0, 8),
    (0, -8),
    (-8, 0),
    (7, 7),
    (7, -7),
    (-7, 7),
    (-7, -7),
    (0, 18),
    (0, -18),
    (18, 12),
    (18, -12),
    (-18, 12),
    (-18, -12),
    (0, 30),
    (0, -30),
)

SOLVE_ALONE = "tolerance, error of the solve alone"
OTHERS = "others"
MOST_HIDDEN = 0.3  # share of a label's area
LEAST_DB = 1e-3  # smaller errors of a level are drawn at this value


def write(folder: Path, label: str, findings: Findings) -> None:
    """Draw accuracy.png and accuracy.svg: release signal, LAeq and the worst third octave."""
    figure = Figure(figsize=(10, 14.5), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(3, 1, sharex=True, height_ratios=(1.4, 1, 1))
    worst = max(
        (u for band in BANDS if math.isfinite(u := findings.uncertainty[band])), default=math.inf
    )
    labels = [
        _signal(panels[0], findings),
        _level(
            panels[1],
            findings,
            "|LAeq error| [dB]",
            LAEQ_LIMIT,
            lambda e: e["laeq_db"],
            findings.uncertainty["laeq_db"],
        ),
        _level(
            panels[2],
            findings,
            "largest third-octave error [dB]",
            BAND_LIMIT,
            lambda e: worst_band(e)[1],
            worst,
        ),
    ]
    for panel in panels:
        panel.set_xscale("log")
        panel.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        panel.xaxis.set_minor_formatter(NullFormatter())
        panel.grid(True, which="both", color="0.88", linewidth=0.5)
        panel.set_axisbelow(True)
    panels[2].set_xlabel("seconds of computing per second of sound, on one core")
    handles = {
        text: handle
        for p in panels
        for handle, text in zip(*p.get_legend_handles_labels(), strict=True)
    }
    figure.legend(
        handles.values(), handles.keys(), loc="outside lower center", ncols=3, fontsize="small"
    )
    figure.suptitle(_title(label, findings))
    figure.canvas.draw()
    for panel, texts in zip(panels, labels, strict=True):
        _place_labels(panel, texts)
    with matplotlib.rc_context({"svg.hashsalt": "accuracy"}):
        for kind in ("png", "svg"):
            content = BytesIO()
            figure.savefig(
                content, format=kind, dpi=110, metadata={"Date": None} if kind == "svg" else None
            )
            write_bytes(folder / f"accuracy.{kind}", content.getvalue())


def _title(label: str, findings: Findings) -> str:
    """Return the title: scene, length of track and reference."""
    study, best = findings.study, findings.reference
    assert best is not None
    length = study.nodes * study.scene.spacing * 1e3
    return (
        f"{study.scene.name}, {label}: speed against error over {length:.3g} mm of track\n"
        f"errors against spacing {study.spacing_um(best):g} µm, {best.edges} edges, tolerance"
        f" {tolerance_text(best.tolerance)}, step {study.step_um(best):g} µm"
    )


def _curves(findings: Findings, value: Callable[[Errors], float]) -> dict[str, Curve]:
    """Return a curve for each family of variants."""
    curves = {}
    for name, variants in findings.study.families().items():
        shown = [v for v in variants if v in findings.errors and v != findings.reference]
        if name != "references" and shown:
            curves[name] = [
                (v, findings.measurements[v].seconds_per_second, value(findings.errors[v]))
                for v in shown
            ]
    return curves


def _signal(ax: Axes, findings: Findings) -> Labels:
    """Draw the errors of the release signal, with the errors of the solve alone."""
    curves = _curves(findings, lambda e: decibel(e["signal"]))
    curves[SOLVE_ALONE] = [
        (
            v,
            findings.measurements[v].seconds_per_second,
            decibel(findings.solver_errors[v]["signal"]),
        )
        for v in findings.study.families()["tolerance"]
        if v in findings.solver_errors
    ]
    labels = _draw(ax, findings.study, curves)
    _uncertain(ax, decibel(findings.uncertainty["signal"]))
    ax.set_ylabel("release signal: rms error re rms of fluctuation [dB]")
    return labels


def _level(
    ax: Axes,
    findings: Findings,
    ylabel: str,
    limit: float,
    value: Callable[[Errors], float],
    uncertainty: float,
) -> Labels:
    """Draw the errors of a level, with the limit of a recommendation."""
    labels = _draw(ax, findings.study, _curves(findings, lambda e: max(abs(value(e)), LEAST_DB)))
    ax.axhline(
        limit,
        color="black",
        linewidth=1.0,
        linestyle=(0, (6, 3)),
        label="limit of a recommendation",
    )
    ax.set_yscale("log")
    ax.yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"{y:g}"))
    _uncertain(ax, uncertainty)
    ax.set_ylabel(ylabel)
    return labels


def _uncertain(ax: Axes, value: float) -> None:
    """Shade the range of the reference's own uncertainty."""
    if math.isfinite(value):
        low, high = ax.get_ylim()
        ax.axhspan(
            min(low, value),
            value,
            color="0.92",
            zorder=0,
            label="within the reference's own uncertainty",
        )
        ax.set_ylim(min(low, value), max(high, value))


def _draw(ax: Axes, study: Study, curves: dict[str, Curve]) -> Labels:
    """Draw curves by name, with the same look in every panel.

    A ring marks the scene's own settings.
    """
    labels: Labels = {}
    names = [n for n in study.families() if n not in ("references", OTHERS)] + [SOLVE_ALONE]
    for name, curve in curves.items():
        points = [(v, x, y) for v, x, y in curve if math.isfinite(y)]
        x, y = [p[1] for p in points], [p[2] for p in points]
        if name == OTHERS:
            ax.plot(x, y, "x", color="0.45", markersize=5, label="other combinations")
            continue
        k = names.index(name)
        look: dict[str, Any] = {
            "color": COLOURS[k % len(COLOURS)],
            "marker": MARKERS[k % len(MARKERS)],
        }
        ax.plot(
            x,
            y,
            linestyle=LINE_STYLES[k % len(LINE_STYLES)],
            markersize=6,
            linewidth=1.3,
            label=name,
            **look,
        )
        for v, at, off in points:
            own = v == study.own and name != SOLVE_ALONE
            labels.setdefault((at, off), "the scene" if own else _label(study, name, v))
            if own:
                ax.plot(
                    at,
                    off,
                    "o",
                    color="black",
                    markersize=13,
                    fillstyle="none",
                    label="the scene as it stands",
                )
    return labels


def _label(study: Study, name: str, variant: Variant) -> str:
    """Return the label of a point: the varied setting."""
    if name.startswith("spacing"):
        return f"{study.spacing_um(variant):g} µm"
    if name.startswith("tolerance"):
        return tolerance_text(variant.tolerance)
    if name == "width":
        return f"width {study.width_um(variant):g} µm"
    return f"step {study.step_um(variant):g} µm" if name == "step" else variant.precision


def _place_labels(ax: Axes, labels: Labels) -> None:
    """Place each label where it hides least of the points and of earlier labels.

    A label without a good place is left out.
    """
    points = [ax.transData.transform(point) for point in labels]
    taken = [Bbox.from_bounds(x - 5, y - 5, 10, 10) for x, y in points]
    inside = ax.get_window_extent()
    for (at, text), point in zip(labels.items(), points, strict=True):
        leader = {"arrowstyle": "-", "color": "0.4", "linewidth": 0.6, "shrinkA": 0, "shrinkB": 0}
        drawn = ax.annotate(
            text,
            at,
            xytext=(0, 0),
            textcoords="offset points",
            fontsize=7.5,
            arrowprops=leader,
            zorder=5,
        )
        # a white outline keeps labels legible over curves
        drawn.set_path_effects([withStroke(linewidth=2.5, foreground="white")])
        box = Text.get_window_extent(drawn)
        hidden, best = min(
            (_tried(point, offset, box, inside, taken) for offset in OFFSETS),
            key=lambda tried: tried[0],
        )
        if hidden > MOST_HIDDEN * box.width * box.height:
            drawn.remove()
            continue
        scale = 72 / ax.figure.dpi
        drawn.set_position(((best.x0 - point[0]) * scale, (best.y0 - point[1]) * scale))
        taken.append(best)


def _tried(
    point: Any, offset: tuple[float, float], text: Bbox, inside: Bbox, taken: list[Bbox]
) -> tuple[float, Bbox]:
    """Return the area that a label would hide [pixels] and its box there.

    The offset reaches to the nearest edge of the box, or to its middle.
    """
    (x, y), (dx, dy) = point, offset
    left = x + dx - (text.width if dx < 0 else text.width / 2 if dx == 0 else 0)
    low = y + dy - (text.height if dy < 0 else text.height / 2 if dy == 0 else 0)
    tried = Bbox.from_bounds(left, low, text.width, text.height)
    outside = not (
        inside.x0 < tried.x0
        and tried.x1 < inside.x1
        and inside.y0 < tried.y0
        and tried.y1 < inside.y1
    )
    return sum(_shared(tried, other) for other in taken) + 1e4 * outside, tried


def _shared(box: Bbox, other: Bbox) -> float:
    """Return the common area of two boxes."""
    both = Bbox.intersection(box, other)
    return both.width * both.height if both else 0.0
