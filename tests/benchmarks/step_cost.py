"""The time of a step over the width of its window, with a fit and the machine's limit.

The script marches spheres over plates under loads whose windows are 40 to 2,000 nodes wide, writes
step-cost.json and step-cost.md, draws step-cost.svg, and prints the tables. It takes five
to ten minutes on a machine on which nothing else runs, `--quick` stops at 350 nodes.

python tests/benchmarks/step_cost.py [--quick] [--out FOLDER]
python tests/benchmarks/step_cost.py --draw scenarios/pictures/step-cost.png    from the last json
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
import tracemalloc
from dataclasses import asdict, dataclass
from pathlib import Path

if __name__ == "__main__":
    pinned = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
    os.environ.update(dict.fromkeys(pinned, "1"))

import numpy as np

from rolling.check import cost
from rolling.contact._transform_kernels import deflect_nodes, nodes_kernel
from rolling.contact.half_space import HalfSpace
from rolling.contact.march import march
from rolling.contact.recovery import step_energy
from rolling.contact.state import ContactState
from rolling.contact.subcells import half_space_of
from rolling.in_si.contact_of_scene import rolling_contact
from rolling.kinds.reading import read_scene
from rolling.scene.scene import Scene

HERE = Path(__file__).parent
QUICKSTART = HERE.parent.parent / "scenarios" / "quickstart.yaml"
OUTPUTS = HERE.parent.parent / "outputs" / "benchmarks"
WIDTHS = (40, 70, 110, 180, 350, 600, 1000, 2000)
ELASTIC = "plate.hardness_gpa=null"
SHARP = "numerics.edges=sharp"
WHOLE = (SHARP, "numerics.subcells=1")
KINDS = {
    "elastic, smooth": (ELASTIC, "surface.roughness_ra_um=0.0001", *WHOLE),
    "elastic, Ra 0.1 µm": (ELASTIC, *WHOLE),
    "yielding, Ra 0.1 µm, sharp edges": WHOLE,
    "yielding, Ra 1 µm, sharp edges": ("surface.roughness_ra_um=1", *WHOLE),
    "yielding, Ra 0.1 µm, blended edges": ("numerics.subcells=1",),
}
LIMIT = "bare transforms, rough"
FIRST = 2  # steps that a trend does not lead yet


@dataclass(frozen=True)
class Cost:
    """Measured steps of one kind at one width.

    Parameters
    ----------
    kind : str
        Key of KINDS.
    width : float
        Geometric mean of rows and columns of the windows.
    milliseconds, convolutions : float
        CPU time of a step with its release, lower quartile, and convolutions per step.
    bare : float
        Milliseconds of so many bare convolutions, one of them in double precision.
    bytes_per_node : float
        Maximum memory of the arrays of the march, its cold start included, per node of the window.
    """

    kind: str
    width: float
    milliseconds: float
    convolutions: float
    bare: float
    bytes_per_node: float

    @property
    def law(self) -> float:
        """n^2 log n of the width n."""
        return float(self.width**2 * np.log(self.width))


def scene_of(kind: str, width: float) -> Scene | None:
    """Return the scene of a kind under the load whose window is so many nodes wide.

    Return None where the roughness alone makes the window wider.
    """

    def under(load: float) -> Scene:
        nodes = 1 << int(np.ceil(np.log2(max(256, 1.3 * width))))
        long = f"rolling.duration_s={nodes * 2e-6 / 0.1:g}"
        across = f"surface.width_um={nodes * 2}"
        overrides = [*KINDS[kind], f"rolling.load_n={load:.6g}", across, long]
        pinned = ["numerics.tolerance=1e-4", "numerics.error_estimate=false"]
        return read_scene(QUICKSTART, [*overrides, *pinned]).runs()[0][1]

    def wide(scene: Scene) -> bool:
        return cost.window_nodes(scene, cost.roughness(scene)[0]) > width

    low = 0.1
    high = 1e6
    if wide(under(low)):
        return None
    for _ in range(24):
        middle = float(np.sqrt(low * high))
        low, high = (low, middle) if wide(under(middle)) else (middle, high)
    return under(low)


def measure(kind: str, scene: Scene, width: int) -> Cost:
    """Measure a march of a few steps."""
    contact = rolling_contact(scene)
    half_space = half_space_of(contact.spacing, contact.contact_modulus, contact.subcells)
    steps = int(np.clip(4000 / width, 5, 40))
    states: list[ContactState] = []
    clock = []
    tracemalloc.start()  # the first steps only: it takes time itself
    for state in march(contact, 0, FIRST + steps, half_space):
        if states:
            step_energy(states[-1], state, half_space)
        states = [*states[-1:], state]
        if state.position == FIRST:
            peak = tracemalloc.get_traced_memory()[1]
            tracemalloc.stop()
        clock.append((time.thread_time(), state.convolutions, state.window))
    seconds = np.diff([t for t, *_ in clock])[FIRST:]
    counts = np.mean([count for _, count, _ in clock[1 + FIRST :]])
    windows = [window for *_, window in clock[1 + FIRST :]]
    wide = float(np.mean([np.sqrt(w.rows * w.columns) for w in windows]))
    block = states[-1].loaded
    bare = bare_seconds(half_space, (windows[-1].rows, windows[-1].columns), False)
    bare += (counts - 1) * bare_seconds(half_space, (block.rows, block.columns), True)
    step = 1e3 * float(np.quantile(seconds, 0.25))
    return Cost(kind, wide, step, float(counts), 1e3 * bare, peak / wide**2)


def bare_seconds(half_space: HalfSpace, nodes: tuple[int, int], single: bool) -> float:
    """Return the seconds of the transforms of a block of so many rows and columns of nodes."""
    transforms = half_space.convolution(nodes[0] - 1, nodes[1] - 1, single=single)
    entry = transforms.planned_entry(nodes[0])
    kernel, nothing = nodes_kernel(1, single), np.empty(0)
    block, listed = (0, 0, *nodes), (np.empty(0, np.uint32), np.empty(0, np.int64))
    taken = []
    for _ in range(9):
        began = time.thread_time()
        deflect_nodes(kernel, entry, block, nothing, 1.0, nothing, listed)
        taken.append(time.thread_time() - began)
    return float(np.min(taken))


def fit(costs: list[Cost], of: str = "milliseconds") -> tuple[float, float]:
    """Fit a power law; return the milliseconds at 100 nodes and the power."""
    x = np.log([c.width / 100 for c in costs])
    y = np.log([getattr(c, of) for c in costs])
    power, at_100 = np.polyfit(x, y, 1) if len(costs) > 1 else (np.nan, y[0])
    return float(np.exp(at_100)), float(power)


def table(costs: list[Cost]) -> str:
    """Return the fits of the kinds and the rows of their widths as two Markdown tables."""
    fits = [
        "| scene | nodes | fit, n x n nodes | power of n^2 log n | of bare transforms |",
        "|---|---|---|---|---|",
    ]
    rows = [
        "| scene | nodes | ms per step | convolutions | over bare transforms | bytes per node |",
        "|---|---|---|---|---|---|",
    ]
    for kind in dict.fromkeys(c.kind for c in costs):
        mine = [c for c in costs if c.kind == kind]
        at_100, power = fit(mine)
        nodes = f"{mine[0].width:.0f} to {mine[-1].width:.0f}"
        law = fit(mine, "law")[1]
        bare = fit(mine, "bare")[1]
        fits.append(
            f"| {kind} | {nodes} | {at_100:.1f} ms (n/100)^{power:.2f} | {law:.2f} | {bare:.2f} |"
        )
        rows += [
            f"| {kind} | {c.width:.0f} | {c.milliseconds:.3g} | {c.convolutions:.1f}"
            f" | {c.milliseconds / c.bare:.1f} | {c.bytes_per_node:.0f} |"
            for c in mine
        ]
    return "\n".join([*fits, "", *rows]) + "\n"


def draw(costs: list[Cost], path: Path) -> None:
    """Draw times, fits and bare transforms over the width of the window."""
    from matplotlib.figure import Figure

    from acoustics.plot_style import curve_style

    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    ax = figure.subplots()
    kinds = dict.fromkeys(c.kind for c in costs)
    for number, kind in enumerate(kinds):
        mine = [c for c in costs if c.kind == kind]
        style = curve_style(number, len(kinds))
        line = {"color": style["color"], "linestyle": style["linestyle"]}
        mark = {"color": style["color"], "marker": style["marker"]}
        ax.plot([c.width for c in mine], [c.milliseconds for c in mine], linestyle="none", **mark)
        at_100, power = fit(mine)
        widths = np.array([mine[0].width, mine[-1].width])
        ax.plot(widths, at_100 * (widths / 100) ** power, linewidth=1, **line)
        ax.plot([], [], label=kind, **style)
    rough = sorted((c for c in costs if "smooth" not in c.kind), key=lambda c: c.width)
    at_100, power = fit(rough, "bare")
    widths = np.array([rough[0].width, rough[-1].width])
    ax.plot(widths, at_100 * (widths / 100) ** power, "k--", lw=1, label=LIMIT)
    ax.set(xscale="log", yscale="log", xlabel="width of the window [nodes]")
    ax.set_ylabel("time of a step [ms]")
    ax.grid(alpha=0.3, which="both")
    ax.legend(fontsize="small")
    figure.savefig(path, metadata={"Date": None})


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help="windows of up to 350 nodes")
    parser.add_argument("--out", metavar="FOLDER", type=Path, default=OUTPUTS)
    parser.add_argument("--draw", metavar="PICTURE", type=Path, help="draw the last measurement")
    given = parser.parse_args()
    kept = given.out / "step-cost.json"
    if given.draw:
        draw([Cost(**each) for each in json.loads(kept.read_text())], given.draw)
        return
    given.out.mkdir(parents=True, exist_ok=True)
    costs = []
    for kind in KINDS:
        for width in WIDTHS:
            if given.quick and width > 350:
                continue
            scene = scene_of(kind, width)
            if scene is None:
                continue
            costs.append(measure(kind, scene, width))
            print(costs[-1], file=sys.stderr, flush=True)
    kept.write_text(json.dumps([asdict(each) for each in costs], indent=1) + "\n")
    (given.out / "step-cost.md").write_text(table(costs))
    draw(costs, given.out / "step-cost.svg")
    print(table(costs), end="")


if __name__ == "__main__":
    main()
