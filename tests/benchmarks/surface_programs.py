"""Print parameters of two surfaces by other programs, for scenarios/validation/surfaces.csv.

    python tests/benchmarks/surface_programs.py heights FOLDER
    ENVIRONMENT/bin/python tests/benchmarks/surface_programs.py table FOLDER

The first command takes this program, and writes the heights [m] of two scenes as FOLDER/NAME.npy.
The second one takes an environment with surfalize and SurfaceTopography, and prints the table.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path

import numpy as np

LENGTHS = ("Sa", "Sq", "Sp", "Sv", "Sz")
OTHERS = ("Ssk", "Sku", "Sdq", "Sdr")
MATERIAL = ("Sk", "Spk", "Svk", "Smr1", "Smr2")


def write_heights(folder: Path) -> None:
    """Write the heights of the runs of a scene without their plane, and their spacings."""
    from rolling.studies.printed_truths import surfaces

    for item, (heights, spacing) in surfaces().items():
        np.savez(folder / f"{item}.npz", heights=heights, spacing=spacing)


def by_surfalize(heights: np.ndarray, spacing: float) -> Iterator[tuple[str, float]]:
    """Yield parameters of heights [m] by surfalize, in micrometres."""
    from surfalize import Surface

    surface = Surface(1e6 * heights, 1e6 * spacing, 1e6 * spacing)
    for name in (*LENGTHS, *OTHERS, *MATERIAL):
        yield name, float(getattr(surface, name)())


def by_surface_topography(heights: np.ndarray, spacing: float) -> Iterator[tuple[str, float]]:
    """Yield parameters of periodic heights [m] by SurfaceTopography, in micrometres."""
    from SurfaceTopography import Topography

    sides = tuple(1e6 * float(spacing) * n for n in heights.shape)
    surface = Topography(1e6 * heights, sides, periodic=True)
    yield "Sq", float(surface.rms_height_from_area())
    yield "Sdq", float(surface.rms_gradient())


def print_table(folder: Path) -> None:
    """Print the parameters of both surfaces by both programs."""
    print("program,quantity,item,value")
    for path in sorted(folder.glob("*.npz")):
        stored = np.load(path)
        for program, values in (
            ("surfalize", by_surfalize),
            ("SurfaceTopography", by_surface_topography),
        ):
            for quantity, value in values(stored["heights"], float(stored["spacing"])):
                print(f"{program} {version(program)},{quantity},{path.stem},{value:.6g}")


if __name__ == "__main__":
    if sys.argv[1] == "heights":
        write_heights(Path(sys.argv[2]))
    else:
        print_table(Path(sys.argv[2]))
