"""What a card does with many pieces of a march at once: measured where there is one.

The script times the two operations that move most of the memory of a step, for many pieces in
flight: a convolution of all (k transforms in one plan, there and back) and the sweeps of the model
in an iteration. They are written for an array library (`lockstep/grids.py`). It needs cupy and a
card; with `--numpy` it runs on the processor, on one thread. `--arithmetic` measures nothing of
the kind: it counts the bytes of a step and prints the steps a second that a card of 4 TB/s would
reach at half its rate, beside the present solver on two cores of this machine.

python tests/benchmarks/gpu_trial.py [--numpy] [--pieces N ...]
python tests/benchmarks/gpu_trial.py --arithmetic
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable
from typing import Any, NamedTuple

if __name__ == "__main__":
    pinned = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
    os.environ.update(dict.fromkeys(pinned, "1"))

import numpy as np
from lockstep import grids
from lockstep_trial import blocks_of_descents, contact_of, half_space_for

from rolling.contact._descent_kernels import FIRST_SWEEPS, SWEEPS
from rolling.contact._far_field import inverse_stencil
from rolling.contact._model_kernels import LAST_SWEEPS
from rolling.contact.march import march

LOADS = (1, 5, 20, 100)  # [N]
BLOCKS = {1: (40, 40), 5: (60, 60), 20: (90, 90), 100: (180, 180)}  # nodes, some round sizes
RATE = 4e12  # bytes a second of a card
REACHED = 0.5  # of its rate
LAUNCH = 5e-6  # seconds from a call to the next, an assumption
CALLS = 30  # of the card in an iteration, an assumption
STEPS = 100

# Bytes that a node of the block takes to and from memory, if each pass is one kernel. Grids of the
# model and of transforms have 4 bytes, pressures and gaps of nodes 8.
FILL = 4 * 8 + 4 * 4  # approach and violation from p and g, then p and g to four grids
SWEEP = 6 * 4  # reads moves, gaps and two bounds, writes gaps and moves
BEGIN_SWEEPS = 6 * 4  # reads changes, gaps and bounds, writes gaps and moves
FAR_FIELD = (4 + 1 + 2 + 2) * 4  # marks free nodes, sums two grids, adds the field to the gaps
DIRECTION = 2 * 4 + 6 * 8 + 8 * 8 + 4 * 8  # targets, beta, eight passes for the shift, slope
STEP = (8 + 4) + (3 * 8 + 4 + 2 * 8)  # curvature from d and image, then the step
# Padded grids have four times the nodes. Each of five passes (rows, columns, product, columns,
# rows) reads and writes them once, before them the directions are padded, and the image is read.
CONVOLUTION = 4 * (5 * 2 * 4 + 4) + 2 * 8
CHECK = 2 * CONVOLUTION + 10 * 8  # in double precision, with gap, deformed gap and violation


class Counts(NamedTuple):
    """Means of a step at a load: nodes of window and block, convolutions, iterations, seconds."""

    window: float
    block: float
    convolutions: float
    iterations: float
    seconds: float


def counts_of(load: float) -> Counts:
    """March some steps at a load on one core, and count."""
    contact = contact_of(load)
    blocks: list[int] = []
    states = []
    with blocks_of_descents(blocks):
        for state in march(contact, 0, 1 + STEPS, half_space_for(load)):
            states.append(state)
            if state.position == 1:
                blocks.clear()
                began = time.process_time()
    seconds = (time.process_time() - began) / STEPS
    windows = [state.window.rows * state.window.columns for state in states[2:]]
    return Counts(
        window=float(np.mean(windows)),
        block=float(np.mean(blocks)),
        convolutions=float(np.mean([state.convolutions for state in states[2:]])),
        iterations=float(np.mean([state.iterations for state in states[2:]])),
        seconds=seconds,
    )


def bytes_of_step(counts: Counts) -> float:
    """Return the bytes that a step of a piece moves on whole grids, as counted from the code."""
    model = BEGIN_SWEEPS + FAR_FIELD + BEGIN_SWEEPS + LAST_SWEEPS * SWEEP
    first = FILL + model + FIRST_SWEEPS * SWEEP + DIRECTION
    iteration = STEP + FILL + model + SWEEPS * SWEEP + DIRECTION
    single = counts.convolutions - 1
    descent = first + counts.iterations * iteration + single * CONVOLUTION
    return counts.window * CHECK + counts.block * descent


def arithmetic() -> str:
    """Return the table of what a card would do, which is not measured."""
    lines = [
        "|load|nodes of the block|convolutions, iterations of a step|MB of a step|steps a second:"
        " two cores, card|ratio|pieces in flight that hide the calls|",
        "|---|---|---|---|---|---|---|",
    ]
    for load in LOADS:
        counts_of(load)  # compiles, and makes the transforms
        counts = counts_of(load)
        moved = bytes_of_step(counts)
        card = REACHED * RATE / moved
        cores = 2 / counts.seconds
        calls = CALLS * (counts.iterations + 2) * LAUNCH
        lines.append(
            f"|{load:g} N|{counts.block:.0f}|{counts.convolutions:.1f}, {counts.iterations:.1f}"
            f"|{moved / 1e6:.1f}|{cores:,.0f}, {card:,.0f}|{card / cores:.0f}|{calls * card:.0f}|"
        )
    return "\n".join(lines) + "\n"


def seconds_of(run: Callable[[], Any], wait: Callable[[], None]) -> float:
    """Return the seconds of a call, the median of five after a first one."""
    taken = []
    for _ in range(6):
        wait()
        began = time.perf_counter()
        run()
        wait()
        taken.append(time.perf_counter() - began)
    return float(np.median(taken[1:]))


def measure(xp: Any, wait: Callable[[], None], pieces: tuple[int, ...]) -> str:
    """Return the table of a convolution and of the sweeps of an iteration, for pieces in flight."""
    stencil = inverse_stencil()
    values = tuple((stencil[1:] / stencil[0]).astype(np.float32).tolist())
    lines = [
        "|block|pieces|convolution of a piece [us]|sweeps of an iteration of a piece [us]|GB/s of"
        " both|",
        "|---|---|---|---|---|",
    ]
    for rows, columns in BLOCKS.values():
        factors = grids.spectrum(xp, rows, columns, 1.0)
        for k in pieces:
            noise = np.random.default_rng(1).standard_normal((k, rows, columns))
            state = xp.asarray(noise.astype(np.float32))
            bounds = xp.full_like(state, -1.0), xp.full_like(state, 1.0)
            still = xp.zeros_like(state)

            def convolve(state: Any = state, factors: Any = factors) -> Any:
                return grids.deflect(xp, state, factors)

            def sweep(still: Any = still, state: Any = state, bounds: Any = bounds) -> Any:
                return grids.settle(xp, still, state, bounds, values, SWEEPS)

            seconds = seconds_of(convolve, wait), seconds_of(sweep, wait)
            moved = k * rows * columns * (CONVOLUTION + BEGIN_SWEEPS + SWEEPS * SWEEP)
            lines.append(
                f"|{rows} x {columns}|{k}|{1e6 * seconds[0] / k:.3g}|{1e6 * seconds[1] / k:.3g}"
                f"|{moved / sum(seconds) / 1e9:.3g}|"
            )
    return "\n".join(lines) + "\n"


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--numpy", action="store_true", help="on the processor")
    parser.add_argument("--arithmetic", action="store_true", help="count, and measure no card")
    parser.add_argument("--pieces", type=int, nargs="+", default=(16, 256, 4096))
    given = parser.parse_args(arguments)
    if given.arithmetic:
        print(arithmetic(), end="")
        return 0
    if given.numpy:
        print(measure(np, lambda: None, tuple(given.pieces)), end="")
        return 0
    try:
        import cupy

        wait = cupy.cuda.Device().synchronize
        wait()
    except Exception as error:  # of the import, or whatever the driver raises
        print(
            "gpu_trial.py needs the package cupy and a card that it can use, or --numpy"
            f" ({type(error).__name__}: {error})",
            file=sys.stderr,
        )
        return 2
    print(measure(cupy, wait, tuple(given.pieces)), end="")
    return 0


if __name__ == "__main__":
    sys.exit(main())
