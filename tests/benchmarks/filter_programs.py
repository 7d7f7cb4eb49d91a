"""Compare filters and forms of least squares with those of surfalize and SurfaceTopography.

    PYTHONPATH=. ENVIRONMENT/bin/python tests/benchmarks/filter_programs.py [FOLDER]

ENVIRONMENT holds both programs; without them the script says so and does nothing. Each row is one
made surface of 300 x 260 nodes of 2 um and Sq 1 um with a form: the Sq that both programs leave,
and the rms of the difference of their heights. They have no robust filter and no sphere, so the
sums of ISO 16610-31 and the form that was put in stand there. The files of FOLDER, such as those of
the tests of surfalize, are read by both programs, each with its own reader.
"""

from __future__ import annotations

import itertools
import sys
from collections.abc import Iterator
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
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


def of_printed_tests() -> Iterator[Row]:
    """Yield what the tests of surfalize print of their made surface: Sq of its long waves."""
    x, y = np.meshgrid(np.arange(1000), np.arange(700))
    fine = np.sin((np.sin(y / 10) + x) / 10 * 2 * np.pi)
    heights = np.sin(x / 200 * 2 * np.pi)
    heights += 0.15 * (np.sin((x - 100) / 200 * 2 * np.pi) + 1) * fine
    heights += np.random.RandomState(0).normal(size=heights.shape) / 5
    yield Row("Sq as made", "printed by surfalize", heights, of_sq(0.745961))
    for index_um, printed in ((1.5, 0.7050198), (2.0, 0.7023322), (5.0, 0.6779730)):
        long = smoothed(heights, (0.1, 0.1), index_um, wraps=False)
        yield Row(f"Gaussian lowpass {index_um:g} um", "printed by surfalize", long, of_sq(printed))


def of_sq(size: float) -> np.ndarray:
    """Return two heights [um] with an Sq [um], of which no more is known."""
    return np.array([-size, size])


def of_files(folder: Path) -> Iterator[Row]:
    """Yield steps of the files of a folder that both programs read without gaps."""
    from surfalize import Surface

    from rolling.scene import height_grid
    from rolling.scene.height_format import HeightFormatError

    name = f"surfalize {version('surfalize')}"
    for path in sorted(folder.iterdir()):
        try:
            read = height_grid.read(path, None, None, None)
            other = Surface.load(path)
        except (HeightFormatError, ValueError, KeyError) as error:
            print(f"{path.name}: {error}", file=sys.stderr)
            continue
        heights = 1e6 * read.heights
        if read.spacing_m is None or np.isnan(heights).any() or min(heights.shape) < 100:
            print(f"{path.name}: left out, with gaps or less than 100 nodes", file=sys.stderr)
            continue
        level = heights - heights.mean()
        yield Row(f"{path.name} as read", name, heights, other.data)
        for order in (1, 2, 4):
            ours = level - polynomial(level, order)
            step = f"{path.name}, order {order}"
            yield Row(step, name, ours, other.detrend_polynomial(order).data)
        sides = np.array(heights.shape) * read.spacing_m
        index_um = float(f"{1e6 * sides.min() / 5:.2g}")
        ours = level - polynomial(level, 1)
        long = smoothed(ours, [1e6 * step for step in read.spacing_m], index_um, wraps=False)
        filtered = other.level().filter("highpass", index_um).data
        yield Row(f"{path.name}, L-filter {index_um:g} um", name, ours - long, filtered)


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
    sources = [of_surfalize(), of_printed_tests(), of_surface_topography(), of_truth()]
    if len(sys.argv) > 1:
        sources = [of_files(Path(sys.argv[1]))]
    for row in itertools.chain(*sources):
        difference = "-"
        if row.ours.shape == row.other.shape:
            difference = f"{np.std(row.ours - row.other):.1e}"
        sizes = f"{row.ours.std():.6f}|{row.other.std():.6f}"
        print(f"|{row.step}|{row.program}|{sizes}|{difference}|", flush=True)


if __name__ == "__main__":
    main()
