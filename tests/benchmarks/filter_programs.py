"""Compare filters and forms of least squares with those of surfalize and SurfaceTopography.

    PYTHONPATH=. ENVIRONMENT/bin/python tests/benchmarks/filter_programs.py

ENVIRONMENT holds both programs; without them the script says so and does nothing. Each row is one
made surface of 300 x 260 nodes of 2 um and Sq 1 um with a form: the Sq that both programs leave,
and the rms of the difference of their heights. They have no robust filter and no sphere, so the
sums of ISO 16610-31 and the form that was put in stand there.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from importlib.metadata import version
from importlib.util import find_spec
from typing import NamedTuple

import numpy as np

from rolling.surface.form import polynomial, round_form
from rolling.surface.gaussian_filter import robust_smoothed, smoothed
from rolling.surface.stylus import ALPHA

SHAPE = (300, 260)
STEP_UM = 2.0
INDEX_UM = 80.0
MIDDLE = (slice(60, -60), slice(60, -60))  # one and a half nesting indices from the ends


class Row(NamedTuple):
    """Heights [um] that this program leaves, and those of another one."""

    step: str
    program: str
    ours: np.ndarray
    other: np.ndarray


def places() -> tuple[np.ndarray, np.ndarray]:
    """Return the places [um] along and across about the middle."""
    x = STEP_UM * (np.arange(SHAPE[0]) - (SHAPE[0] - 1) / 2)[:, None]
    y = STEP_UM * (np.arange(SHAPE[1]) - (SHAPE[1] - 1) / 2)
    return x + 0.0 * y, y + 0.0 * x


def rough() -> np.ndarray:
    """Return random heights [um] of Sq 1 um that fall beyond 10 um."""
    random = np.random.default_rng(1)
    waves = np.hypot(np.fft.fftfreq(SHAPE[0])[:, None], np.fft.rfftfreq(SHAPE[1]))
    gain = (1 + (2 * np.pi * 5 * waves) ** 2) ** -0.9
    heights = np.fft.irfft2(np.fft.rfft2(random.normal(size=SHAPE)) * gain, SHAPE)
    return np.asarray((heights - heights.mean()) / heights.std())


def of_surfalize() -> Iterator[Row]:
    """Yield the steps that surfalize has."""
    from surfalize import Surface

    x, y = places()
    heights = rough() + 3e-5 * x**2 - 2e-5 * y**2 + 4e-8 * x**3 + 1e-10 * y**4 + 0.01 * x
    name = f"surfalize {version('surfalize')}"
    for order in (1, 2, 3, 4, 6):
        other = Surface(heights, STEP_UM, STEP_UM).detrend_polynomial(order).data
        ours = heights - heights.mean() - polynomial(heights - heights.mean(), order)
        yield Row(f"polynomial of order {order}", name, ours, other)
    bent = rough() - np.sqrt(6e3**2 - (x - 50) ** 2)
    other = Surface(bent, STEP_UM, STEP_UM).remove_cylinder().data
    bent -= bent.mean()
    ours = bent - round_form(bent, (STEP_UM, STEP_UM), "cylinder").heights
    yield Row("cylinder of 6 mm", name, ours, other)
    level = Surface(rough(), STEP_UM, STEP_UM)
    steps = (STEP_UM, STEP_UM)
    ours = smoothed(rough(), steps, INDEX_UM, wraps=False)
    for kind, own in (("lowpass", ours), ("highpass", rough() - ours)):
        filtered = level.filter(kind, INDEX_UM).data
        yield Row(f"Gaussian {kind}, inside", name, own[MIDDLE], filtered[MIDDLE])
        yield Row(f"Gaussian {kind}, with ends", name, own, filtered)
    wrapped = level.filter("lowpass", INDEX_UM, endeffect_mode="wrap").data
    yield Row(
        "Gaussian lowpass of a period", name, smoothed(rough(), steps, INDEX_UM, True), wrapped
    )


def of_surface_topography() -> Iterator[Row]:
    """Yield the steps that SurfaceTopography has."""
    from SurfaceTopography import Topography

    x, y = places()
    heights = rough() + 3e-5 * x**2 - 2e-5 * y**2 + 2e-5 * x * y + 0.01 * x
    name = f"SurfaceTopography {version('SurfaceTopography')}"
    sides = (STEP_UM * SHAPE[0], STEP_UM * SHAPE[1])
    for order, mode in ((1, "height"), (2, "curvature")):
        other = Topography(heights, sides).detrend(mode).heights()
        ours = heights - heights.mean() - polynomial(heights - heights.mean(), order)
        yield Row(f"polynomial of order {order}", name, ours, other)

    def gain(along: np.ndarray, across: np.ndarray) -> np.ndarray:
        """Return the transmission at wave numbers [rad/um]."""
        waves = np.hypot(along, across) / (2 * np.pi)
        return np.asarray(np.exp(-np.pi * (ALPHA * INDEX_UM * waves) ** 2))

    other = Topography(rough(), sides, periodic=True).filter(gain, isotropic=False).heights()
    ours = smoothed(rough(), (STEP_UM, STEP_UM), INDEX_UM, wraps=True)
    yield Row("Gaussian lowpass of a period", name, ours, other)


def of_truth() -> Iterator[Row]:
    """Yield what has a truth or a sum beside it: round forms, and the robust filter."""
    x, y = places()
    left = rough() - rough().mean()
    steps = (STEP_UM, STEP_UM)
    form = -np.sqrt(6e3**2 - (x - 50) ** 2 - (y + 20) ** 2)
    both = left + form - form.mean()
    ours = both - round_form(both, steps, "sphere").heights
    yield Row("sphere of 6 mm", "no sphere", ours, left - round_form(left, steps, "sphere").heights)
    line = rough()[:, 7] + np.where(np.arange(SHAPE[0]) % 60 < 4, -15.0, 0.0)
    ours = robust_smoothed(line[:, None], (STEP_UM, STEP_UM), INDEX_UM, wraps=False)[:, 0]
    yield Row("robust Gaussian lowpass", "sums of ISO 16610-31", ours, summed(line))


def summed(heights: np.ndarray) -> np.ndarray:
    """Return the robust long waves of a profile [um] by the sums of ISO 16610-31, order 0."""
    node = np.arange(len(heights))
    distance = STEP_UM * np.subtract.outer(node, node)
    kernel = np.exp(-np.pi * (distance / (ALPHA * INDEX_UM)) ** 2)
    plane = np.polyval(np.polyfit(node, heights, 1), node)
    level = heights - plane
    long = kernel @ level / kernel.sum(axis=1)
    for _ in range(100):
        off = np.abs(level - long)
        far = 4.4478 * np.median(off)
        weights = np.where(off < far, (1 - (off / far) ** 2) ** 2, 0.0)
        long = kernel @ (weights * level) / (kernel @ weights)
    return np.asarray(plane + long)


def main() -> None:
    """Print the table."""
    missing = [name for name in ("surfalize", "SurfaceTopography") if find_spec(name) is None]
    if missing:
        print(f"skipped: {', '.join(missing)} not installed", file=sys.stderr)
        return
    print("|step|beside|Sq, this program [um]|Sq, beside [um]|rms of the difference [um]|")
    print("|---|---|---|---|---|")
    for rows in (of_surfalize, of_surface_topography, of_truth):
        for row in rows():
            ours = row.ours - row.ours.mean()
            other = row.other - row.other.mean()
            print(
                f"|{row.step}|{row.program}|{ours.std():.6f}|{other.std():.6f}"
                f"|{np.std(ours - other):.1e}|",
                flush=True,
            )


if __name__ == "__main__":
    main()
