"""Pictures of answers: a choice between finishes, values of a drawing, and a bench."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from drawn_pictures import Drawn, legend_below, new_figure, plain
from matplotlib.ticker import NullLocator
from picture_parts import run_folder

import rolling
from acoustics.numbers import rounded
from acoustics.plot_style import COLOURS, band_ticks, gridded
from rolling.recordings.recording_comparison import THIRD_OCTAVE
from rolling.report import bench as benches
from rolling.report import synthetic_bench
from rolling.run.folder import done_run
from rolling.run.solving import open_runs
from rolling.scene.identity import scene_identity

PAIRS = 6  # of specimens that are heard
SHOWN_DB = 60.0  # below the loudest third octave of a bench


def finishes(scenes: Mapping[str, Any]) -> Drawn:
    """Draw how much louder finishes are than the quietest, by third octave."""
    scene = scenes["finishes"]
    folder = run_folder(f"choice-{scene_identity(scene)[:16]}")
    choice = rolling.choose(scene, folder=folder, pairs=PAIRS, progress=False)
    figure = new_figure(4.0)
    ax = plain(choice.plot(figure.add_subplot()))
    limits_hz = ax.get_xlim()
    band_ticks(ax, octaves=True)
    ax.set_xlim(limits_hz)
    others = choice.contenders[1:]
    for line, contender in zip(ax.lines, others, strict=False):  # the last line is that of 0 dB
        line.set_label(contender.label)
    legend_below(figure, ax)
    numbers = {"quietest": choice.contenders[0].label, "pairs": f"{PAIRS}"}
    for contender, difference in zip(others, choice.differences, strict=True):
        numbers[contender.label] = f"{difference.db:.1f} ± {difference.uncertainty_db:.1f} dB"
    return Drawn(figure, numbers)


def improve(scenes: Mapping[str, Any]) -> Drawn:
    """Draw what a tenth more of each value of a drawing does to the level."""
    scene = scenes["ball"]
    folder = run_folder(f"improve-{scene_identity(scene)[:16]}")
    advice = rolling.sensitivities(scene, folder=folder, pairs=PAIRS, progress=False)
    figure = new_figure(4.6)
    ax = plain(advice.plot(figure.add_subplot()))
    ax.set_xlabel("change of the level [dB(A)]; left is quieter")
    legend_below(figure, ax)
    numbers = {f"line {k}": line for k, line in enumerate(advice.lines)}
    return Drawn(figure, numbers)


def bench(scenes: Mapping[str, Any]) -> Drawn:
    """Draw the levels of a recording and of its run, and their differences."""
    folder = synthetic_bench.make(run_folder("bench"))
    read = benches.read_bench(folder)
    (run,) = open_runs([done_run(benches.run_folder(read), "compare")])
    comparison = benches.compare_recording(run, read.recordings[0])
    table = comparison.table
    channel = table["channel"].iloc[0]
    bands = table[(table["quantity"] == THIRD_OCTAVE) & (table["channel"] == channel)]
    bands = bands[bands["run_db"] > bands["run_db"].max() - SHOWN_DB]
    figure = new_figure(4.8)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[1.6, 1])
    hz = bands["mid_frequency_hz"].to_numpy()
    for k, (name, label) in enumerate((("recording", "recording"), ("run", "run"))):
        above.errorbar(
            hz,
            bands[f"{name}_db"],
            bands[f"{name}_uncertainty_db"],
            color=COLOURS[k],
            marker="os"[k],
            markersize=4,
            linewidth=1.2,
            capsize=2,
            linestyle=("-", "--")[k],
            label=label,
        )
    difference = bands["difference_db"].to_numpy()
    spread = bands["records_uncertainty_db"].to_numpy()
    below.axhline(0.0, color="0.4", linewidth=0.8)
    below.errorbar(
        hz,
        difference,
        spread,
        color=COLOURS[2],
        marker="o",
        markersize=4,
        capsize=2,
        linestyle="none",
    )
    limit = 1.3 * float(np.max(np.abs(difference) + spread))
    below.set(xscale="log", ylim=(-limit, limit))
    gridded(above, ylabel="level of the acceleration\n[dB re 1 µm/s²]")
    gridded(below, xlabel="third octave [Hz]", ylabel="run less\nrecording [dB]")
    below.xaxis.set_minor_locator(NullLocator())
    band_ticks(below, octaves=True)
    below.set_xlim(hz[0] / 1.2, hz[-1] * 1.2)
    legend_below(figure, above)
    numbers = {
        "sensor": str(channel),
        "from": f"{bands['frequency_hz'].iloc[0]:,.0f} Hz",
        "to": f"{bands['frequency_hz'].iloc[-1]:,.0f} Hz",
        "largest": f"{rounded(float(np.abs(difference).max()), 2)} dB",
    }
    return Drawn(figure, numbers)
