"""Check that the lines which `rolling surface` offers give back what it printed.

    python tests/benchmarks/scan_lines.py

Thirteen scans are made with lay, form and marks of missing points, and written as texts. The line
with the file goes into a scene, which is described again: Ra, Sal and Str have the printed digits.
The random line is made with ten seeds on a track as long as the scan, and their means are compared.
"""

import os
import tempfile
from pathlib import Path

import numpy as np

from acoustics.arrays import Array
from rolling.figures.topography import written
from rolling.in_si.described_file import DescribedFile, FileOptions, described_file, offer_of_file
from rolling.in_si.offered_lines import offer_of_statistics
from rolling.in_si.plate_file import scale_limited_file
from rolling.scene.file import loads
from rolling.scene.scene import Scene
from rolling.scene.surfaces import HeightFile
from rolling.surface import made
from rolling.surface.character import character
from rolling.surface.parameters import is_upper_bound, parameters

SPACING_UM = 2.0
SHAPE = 450, 350
SEEDS = 10
NAMES = ("Sa", "Sal", "Str")
# Lengths along and across [um], exponent of the spectrum, Ra [um], form [um] or its name, share of
# marks.
SCANS = (
    (8.0, 8.0, 0.9, 0.08, 0.0, 0.0),
    (6.0, 18.0, 0.9, 0.30, 0.0, 0.004),
    (18.0, 6.0, 0.9, 0.30, 2.0, 0.004),
    (5.0, 30.0, 0.9, 0.20, 2.0, 0.0),
    (10.0, 10.0, 1.5, 0.05, 5.0, 0.01),
    (7.0, 14.0, 1.5, 0.10, 0.0, 0.01),
    (12.0, 4.0, 1.2, 0.40, 3.0, 0.0),
    (9.0, 9.0, 1.2, 0.15, 1.0, 0.03),
    (4.0, 16.0, 0.8, 0.25, 0.0, 0.002),
    (8.0, 300.0, 0.9, 0.30, 3.0, 0.004),
    (6.0, 15.0, 0.9, 0.30, "cylinder", 0.004),
    (8.0, 8.0, 0.9, 0.20, "sphere", 0.004),
    (7.0, 12.0, 0.9, 0.25, "polynomial", 0.0),
)
SCENE = """\
name: scan
sphere: {radius_mm: 5, material: steel-100cr6}
plate: {material: steel-100cr6}
rolling: {load_n: 0.1, speed_m_s: 0.1}
"""


def scan(number: int) -> Array:
    """Make the heights [um] of a scan with its form, its tilt and its marks."""
    along_um, across_um, exponent, ra_um, form_um, share = SCANS[number]
    random = np.random.default_rng(number)
    size = 2 * SHAPE[0], 2 * SHAPE[1]
    along = np.fft.fftfreq(size[0], SPACING_UM)[:, None] * along_um
    across = np.fft.rfftfreq(size[1], SPACING_UM) * across_um
    gain = (1 + 4 * np.pi**2 * (along**2 + across**2)) ** -exponent
    heights = np.fft.irfft2(np.fft.rfft2(random.normal(size=size)) * gain, size)
    heights = heights[: SHAPE[0], : SHAPE[1]]
    heights *= ra_um / np.abs(heights - heights.mean()).mean()
    x = np.linspace(-1, 1, SHAPE[0])[:, None]
    y = np.linspace(-1, 1, SHAPE[1])
    heights += 0.5 * x - 0.3 * y + _form(form_um, x, y)
    return np.where(random.random(SHAPE) < share, -9999.0, heights)


def _form(form: float | str, x: Array, y: Array) -> Array:
    """Return a form [um] over places from -1 to 1 along and across.

    The cylinder has a radius of 6 mm and its axis across, the sphere one of 20 mm off the middle,
    and the polynomial has terms up to the third order.
    """
    if isinstance(form, float):
        return np.asarray(form * (x**2 + 0.5 * y**2))
    along = 0.5 * SPACING_UM * SHAPE[0] * x
    across = 0.5 * SPACING_UM * SHAPE[1] * y
    if form == "cylinder":
        return np.asarray(np.sqrt(6e3**2 - along**2) + 0.0 * across)
    if form == "sphere":
        return np.asarray(np.sqrt(2e4**2 - (along - 50) ** 2 - (across + 30) ** 2))
    return np.asarray(4.0 * x**2 - 3.0 * y**2 + 2.0 * x * y + 1.5 * x**3)


def of_scene(scene: Scene) -> tuple[Array, Array]:
    """Return the heights [m] that the scene of a file is described by, and their steps."""
    assert isinstance(scene.surface, HeightFile) and scene.height_path is not None
    own = scale_limited_file(scene.height_path, scene.surface)
    return own.heights, np.array(own.steps)


def means_of_seeds(read: DescribedFile) -> tuple[Array, str]:
    """Return the mean parameters of the random line, and the line."""
    numbers = character(read.heights, read.steps, False)
    width = read.heights.shape[1] * read.steps[1]
    offer = offer_of_statistics(numbers, min(read.steps), width)
    assert offer is not None and offer.line, offer
    length_mm = 1e3 * read.heights.shape[0] * read.steps[0]
    track = SCENE.replace("0.1}\n", f"0.1, distance_mm: {length_mm:g}}}\n")
    law = loads(track + offer.line + "\n").surface
    shape = read.heights.shape[0], law.n_across
    values = []
    for seed in range(1, SEEDS + 1):
        heights = made.of_law(shape, 1e-6 * law.spacing_um, law.in_si, seed)
        of_seed = parameters(heights, read.steps, True)
        values.append([of_seed[name] for name in NAMES])
    return np.mean(values, axis=0), offer.line


def main() -> None:
    """Print the table."""
    print("|scan|form|lengths|Ra|Sal|Str|line with the file|random line, Ra|Sal|Str|")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for number in range(len(SCANS)):
        path = Path(f"scan-{number}.csv")
        np.savetxt(path, scan(number), fmt="%.4f", delimiter=";")
        options = FileOptions(spacing_um=SPACING_UM, height_unit="um")
        read = described_file(path, options)
        printed = parameters(read.heights, read.steps, False)
        again_heights, again_steps = of_scene(
            loads(SCENE + offer_of_file(path, read.keys).line + "\n", folder=Path())
        )
        again = parameters(again_heights, again_steps, False)
        is_same = all(written(name, printed) == written(name, again) for name in NAMES)
        means, _ = means_of_seeds(read)
        longest = printed["Sal"] / printed["Str"]
        bound = " at most" if is_upper_bound(read.heights, read.steps, False) else ""
        sides = np.array(read.heights.shape) * read.steps
        ratios = means / np.array([printed[name] for name in NAMES])
        cells = [f"{100 * (ratio - 1):+.1f} %" for ratio in ratios]
        print(
            f"|{number + 1}|{read.keys.get('level', 'plane')}"
            f"|{min(sides) / longest:.0f}|{written('Sa', printed)}"
            f"|{written('Sal', printed)}|{written('Str', printed)}{bound}"
            f"|{'same digits' if is_same else 'OTHER DIGITS'}|{'|'.join(cells)}|",
            flush=True,
        )


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        main()
