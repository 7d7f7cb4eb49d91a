"""The table, the advice and the work-precision diagram of a study of accuracy."""

from acoustics import matplotlib_import  # noqa: F401, before matplotlib

# isort: split

import math
from typing import Any

import pandas as pd
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from acoustics.numbers import rounded
from acoustics.plot_style import curve_style
from rolling.figures.settings import own_settings
from rolling.studies.accuracy_variants import OWN, REFERENCE, SOLVER, tolerance_text
from rolling.studies.output import png

LAEQ_LIMIT_DB = 0.1  # maximum error of a recommended variant
BAND_LIMIT_DB = 0.5  # maximum error of a recommended variant
# A solve whose error is a fifth of the error of the grid adds 0.2 dB to the whole.
SOLVER_BELOW_GRID_DB = 14.0
MAX_SOLVER_DB = -40.0
SETTINGS = ["spacing_um", "edges", "tolerance", "step_um", "precision"]
COSTS = ["seconds_per_second", "iterations", "convolutions"]
SHORT = {
    "seconds_per_second": "s per s",
    "error_signal_db": "signal dB",
    "error_laeq_db": "LAeq dB",
    "worst_band_db": "worst dB",
    "worst_band_hz": "at Hz",
}
MIN_DB = 1e-3  # smaller errors of a level are drawn at this value


def table(study: xr.Dataset) -> pd.DataFrame:
    """Return settings, costs and errors of all variants; a lost third octave counts as infinite."""
    frame = study.drop_dims(["band", "sample"]).to_dataframe()
    bands = study.error_third_octave_db.to_pandas()
    read = bands.loc[named(study, REFERENCE)].notna()
    off = bands.loc[:, read].abs().fillna(math.inf)
    worst = off.idxmax(axis=1) if read.any() else None
    frame = frame.assign(worst_band_hz=worst, worst_band_db=off.max(axis=1))
    errors = [name for name in frame if str(name).startswith(("error_", "solver_", "worst_"))]
    return frame[["curve", *SETTINGS, *COSTS, *errors]].join(bands.add_prefix("error_db_"))


def named(study: xr.Dataset, curve: str) -> str:
    """Return the name of the only variant of a curve."""
    return str(study.variant[study.curve == curve].item())


def text(study: xr.Dataset) -> str:
    """Write the short table and the advice for the terminal."""
    frame = table(study)
    shown = frame[list(SHORT)].rename(columns=SHORT)
    formatters = {
        "s per s": "{:.1f}".format,
        "signal dB": "{:.1f}".format,
        "LAeq dB": "{:+.3f}".format,
        "worst dB": "{:.2f}".format,
    }
    columns = shown.to_string(formatters=formatters, na_rep="-", index_names=False)
    columns = columns.replace(" inf", "lost")
    return "\n".join([columns, "", *advice(study, frame)])


def advice(study: xr.Dataset, frame: pd.DataFrame) -> list[str]:
    """Write the reference's own error, the cheapest variant and the tolerance."""
    lines = [f"failed: {line}" for line in study.attrs["failures"].splitlines()]
    if math.isnan(study.laeq_db.sel(variant=named(study, REFERENCE))):
        return [*lines, "the reference is silent: levels cannot be compared"]
    best = frame[frame.curve == REFERENCE].iloc[0]
    same = frame[(frame.edges == best.edges) & (frame.step_um == best.step_um)]
    next_grid = same[same.curve != REFERENCE].sort_values(["spacing_um", "tolerance"]).iloc[0]
    laeq = abs(next_grid.error_laeq_db)
    band = next_grid.worst_band_db
    lines.append(
        f"the reference is off by {laeq:.3f} dB of LAeq and {band:.2f} dB of a third octave at"
        f" most, if errors halve with the spacing (the errors at {next_grid.spacing_um:g} µm)"
    )
    good = frame[
        (frame.error_laeq_db.abs() + laeq <= LAEQ_LIMIT_DB)
        & (frame.worst_band_db + band <= BAND_LIMIT_DB)
        & ~frame.curve.isin([REFERENCE, SOLVER])
    ]
    limits = f"LAeq within {LAEQ_LIMIT_DB} dB and third octaves within {BAND_LIMIT_DB} dB"
    if good.empty:
        lines.append(f"no variant is known to have {limits}; --finest makes a finer reference")
    else:
        cheapest = good.sort_values("seconds_per_second").iloc[0]
        lines.append(f"cheapest with {limits}: {_settings(cheapest)}")
    return [*lines, *_tolerance_advice(frame)]


def _settings(row: pd.Series) -> str:
    """Write the settings and the cost of a variant."""
    return (
        f"spacing {row.spacing_um:g} µm, {row.edges} edges, tolerance"
        f" {tolerance_text(row.tolerance)}, step {row.step_um:g} µm, {row.precision} precision,"
        f" {row.seconds_per_second:.1f} s per s"
    )


def _tolerance_advice(frame: pd.DataFrame) -> list[str]:
    """Write the loosest tolerance whose error is small beside the error of the grid."""
    if "solver_error_signal_db" not in frame:
        return []
    own = frame[frame.curve == OWN].iloc[0]
    most = min(own.error_signal_db - SOLVER_BELOW_GRID_DB, MAX_SOLVER_DB)
    fitting = frame[(frame.solver_error_signal_db <= most) & frame.curve.isin([OWN, "tolerance"])]
    if fitting.empty:
        return [f"no tolerance that was tried leaves a solver error below {most:.0f} dB"]
    loosest = tolerance_text(fitting.tolerance.max())
    words = f"the loosest tolerance with a solver error below {most:.0f} dB is {loosest}"
    return [f"{words}; the scene has {tolerance_text(own.tolerance)}"]


# ---- the diagram


@own_settings()
def diagram_png(study: xr.Dataset) -> bytes:
    """Draw the diagram as a PNG file."""
    return png(diagram(study))


def diagram(study: xr.Dataset) -> Figure:
    """Draw the errors of release signal, LAeq and third octaves over the computing time."""
    figure = Figure(figsize=(8.5, 10), layout="constrained")
    axes = figure.subplots(3, 1, sharex=True)
    frame = table(study)
    for ax, name, label in (
        (axes[0], "error_signal_db", "error of the signal over its fluctuation [dB]"),
        (axes[1], "error_laeq_db", "size of the error of LAeq [dB]"),
        (axes[2], "worst_band_db", "largest error of a third octave [dB]"),
    ):
        work_precision(frame, name, ax)
        ax.set_ylabel(label)
    for ax, limit in ((axes[1], LAEQ_LIMIT_DB), (axes[2], BAND_LIMIT_DB)):
        ax.set_yscale("log")
        ax.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        ax.yaxis.set_major_formatter("{x:g}")
        ax.yaxis.set_minor_formatter(NullFormatter())
        ax.axhline(limit, color="black", linewidth=1, label="limit of a recommendation")
    axes[2].xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes[2].xaxis.set_major_formatter("{x:g}")
    axes[2].xaxis.set_minor_formatter(NullFormatter())
    axes[2].set_xlabel("computing time per second of sound, on one core [s]")
    handles, labels = axes[2].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize="small")
    best = frame[frame.curve == REFERENCE].iloc[0]
    length = f"{rounded(study.attrs['length_m'] * 1e3, 3)} mm of track"
    title = f"{study.attrs['name']}: error against time over {length}"
    figure.suptitle(f"{title}\nreference: {_settings(best)}")
    return figure


def work_precision(frame: pd.DataFrame, name: str, ax: Axes) -> Axes:
    """Draw one error over the computing time, with a curve for each varied setting."""
    own = frame[frame.curve == OWN]
    drawn = frame[~frame.curve.isin([REFERENCE, SOLVER])]
    curves = [curve for curve in dict.fromkeys(drawn.curve) if curve != OWN]
    for k, curve in enumerate(curves):
        rows = drawn[drawn.curve == curve]
        if not curve.endswith("edges") or own.edges.iloc[0] in curve:
            rows = pd.concat([own, rows])
        setting = curve.split(",")[0]
        column = setting if setting in ("tolerance", "precision") else f"{setting}_um"
        rows = rows.sort_values(column)
        seconds = rows.seconds_per_second
        errors = _drawn(rows, name)
        ax.plot(seconds, errors, label=curve, **curve_style(k, len(curves)))
        if setting in ("spacing", "step", "tolerance"):
            points = zip(seconds, errors, rows[column], rows.curve, strict=True)
            for at, error, value, kind in points:
                if kind == OWN or not math.isfinite(error):
                    continue
                word = f"{value:g} µm"
                if setting == "tolerance":
                    word = tolerance_text(value)
                ax.annotate(word, (at, error), (5, 4), textcoords="offset points", fontsize=8)
    ring: dict[str, Any] = {"color": "black", "markersize": 13, "fillstyle": "none"}
    seconds = own.seconds_per_second
    errors = _drawn(own, name)
    ax.plot(seconds, errors, "o", label="the scene as it stands", **ring)
    ax.set_xscale("log")
    ax.grid(True, which="both", color="0.88", linewidth=0.5)
    return ax


def _drawn(rows: pd.DataFrame, name: str) -> pd.Series:
    """Return the signal's error in dB, or the size of the error of a level, lost bands left out."""
    if name == "error_signal_db":
        return rows[name]
    return rows[name].abs().clip(lower=MIN_DB).replace(math.inf, math.nan)
