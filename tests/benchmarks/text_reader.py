"""Measure how long 16 million numbers of text take, and how much memory.

    python tests/benchmarks/text_reader.py [matrix | points | commas | gaps ...]

Each kind is written into a temporary folder and read in a process of its own. Memory is the peak
above that before the file is read, in units of 8 bytes a number.
"""

import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from rolling.scene.text_heights import text_heights

SIDE = 4000  # numbers of each line of a matrix, and lines
POINTS_SIDE = 2300  # points each way
PATTERNS = 40  # different lines


def matrix(path: Path, separator: str = ",", decimal: str = ".", has_gaps: bool = False) -> None:
    """Write a matrix of random numbers."""
    random = np.random.default_rng(1)
    lines = []
    for _ in range(PATTERNS):
        cells = [f"{number:.4f}" for number in random.normal(size=SIDE)]
        if has_gaps:
            cells = ["" if k % 7 == 0 else cell for k, cell in enumerate(cells)]
        lines.append(separator.join(cells).replace(".", decimal) + "\n")
    with path.open("w", encoding="utf-8") as file:
        file.write("Pixel size;2 um\nHeight unit;um\n\n")
        for k in range(SIDE):
            file.write(lines[k % PATTERNS])


def points(path: Path) -> None:
    """Write points x, y, z with a heading."""
    heights = np.random.default_rng(1).normal(size=POINTS_SIDE)
    with path.open("w", encoding="utf-8") as file:
        file.write("x(mm) y(mm) z(um)\n")
        for i in range(POINTS_SIDE):
            places = ((0.002 * j, 0.002 * i, z) for j, z in enumerate(heights))
            file.write("".join(f"{x:.3f} {y:.3f} {z:.4f}\n" for x, y, z in places))


WRITERS: dict[str, Callable[[Path], None]] = {
    "matrix": matrix,
    "points": points,
    "commas": lambda path: matrix(path, ";", ","),
    "gaps": lambda path: matrix(path, ";", has_gaps=True),
}


def measure(kind: str, path: Path) -> None:
    """Read a file, and print time and memory."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    wall = time.perf_counter()
    processor = time.process_time()
    heights = text_heights(path)
    wall = time.perf_counter() - wall
    processor = time.process_time() - processor
    memory = 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
    count = heights.numbers.size * (3 if kind == "points" else 1)
    print(
        f"{kind}: {count / 1e6:.1f} million numbers, {path.stat().st_size / 1e6:.0f} MB,"
        f" {wall:.1f} s, {processor:.1f} s of processor time,"
        f" {memory / (8 * count):.2f} times their bytes"
    )


if __name__ == "__main__":
    if sys.argv[1:2] == ["--read"]:
        measure(sys.argv[2], Path(sys.argv[3]))
    else:
        with tempfile.TemporaryDirectory() as folder:
            for kind in sys.argv[1:] or WRITERS:
                path = Path(folder) / "numbers.csv"
                WRITERS[kind](path)
                subprocess.run([sys.executable, __file__, "--read", kind, str(path)], check=True)
