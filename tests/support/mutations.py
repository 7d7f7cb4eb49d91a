"""Scenes and height files broken at random, each by a number: `python tests/support/mutations.py`.

Each is checked, or refused in words; anything else is a fault of the program. The command takes
the count of numbers, the first of them, and `scene`, `values` or `heights` for one kind only.
"""

from __future__ import annotations

import copy
import io
import random
import struct
import sys
import tempfile
import time
import traceback
import warnings
import zipfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from mutated_texts import WORDS, mutated
from scene_text import SCENES

from rolling.check import findings
from rolling.scene import file
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene

SCENARIOS = Path(__file__).parents[2] / "scenarios"
PLATE = "plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}\n"
BENDING_PLATE = PLATE.replace("}", ", density_kg_m3: 7850, thickness_mm: 3, loss_factor: 0.01}")
HEIGHTS = f"""\
name: measured
sphere: {{radius_mm: 5}}
{PLATE}surface:
  kind: file
  path: %s
  spacing_um: 2
rolling: {{load_n: 0.2, speed_m_s: 0.1}}
"""
SWEPT = f"""\
name: trial
sphere: {{radius_mm: 5, density_kg_m3: 7850, youngs_modulus_gpa: 210, poissons_ratio: 0.3}}
{BENDING_PLATE}dynamics: {{loads: 5, span: 1.3}}
surface:
  kind: gaussian
  roughness_ra_um: 0.1
  correlation_length_um: 10
  correlation_length_across_um: 20
  autocorrelation: exponential
  spacing_um: 2
  width_um: 64
  seed: 1
rolling:
  load_n: 20
  speed_m_s: [[0, 0.1], [0.005, 0.2]]
  duration_s: 0.01
  start_um: 7
numerics: {{step_nodes: 1, tolerance: 1e-4, edges: blended, precision: single}}
recovery: {{events: true, rule: mean}}
sound: {{source: release, distance_m: 1, q: 0.5, gain_pa_per_w_m2: 2}}
sweep:
  rolling.load_n: [5, 20, 100]
  sphere.radius_mm: [2, 5]
"""
VALUES: tuple[Any, ...] = (
    *(None, True, False, 0, 1, -1, 0.0, -0.0, 1e-15, 1e15, 1e-16, 5e-324, 1.7e308, 10**400),
    *(-(16**5000), float("inf"), float("-inf"), float("nan"), "", "1", "a" * 999, "\x00", "\ud800"),
    *([], {}, [1], [[0, 1], [1, 2]], [[0, 0]], {"a": {"b": {"c": 1}}}, (1, 2), b"x", 1j, object()),
    *({1: 2}, {None: 3}, {(1, 2): 3}, np.float64(2), np.int64(3), np.arange(3), np.nan, {1, 2}),
    *(np.array([[0, 1.0], [1, 2]]), Path("x"), np.zeros((2, 0)), [[[[[[[1]]]]]]], np.bool_(True)),
)


# ---- scenes
# --------------------------------------------------------------------------------------------


def texts() -> list[str]:
    """List the texts that are broken."""
    return [SWEPT, *(path.read_text(encoding="utf-8") for path in SCENES)]


def scene_case(number: int, folder: Path) -> Scene:
    """Read the broken text of a number, with a broken override for some."""
    chance = random.Random(number)
    text = mutated(chance.choice(texts()), chance)
    overrides = []
    if chance.random() < 0.3:
        key = chance.choice(
            ["rolling.load_n", "surface", "sweep.rolling.load_n", "name", "x.y", ""]
        )
        overrides = [mutated(f"{key}={chance.choice(WORDS)}", chance)]
    return file.loads(text, overrides, where="s.yaml", folder=SCENARIOS)


def values_case(number: int, folder: Path) -> Scene:
    """Build a scene from plain values, of which some are swapped for others."""
    chance = random.Random(number)
    data = file.parse(SWEPT, "s.yaml").value
    for _ in range(chance.choice([1, 1, 1, 3])):
        inside: Any = data
        while True:
            keys = list(inside) if isinstance(inside, dict) else list(range(len(inside)))
            key = chance.choice(keys) if keys else None
            if key is None:
                break
            if isinstance(inside[key], dict | list) and chance.random() < 0.7:
                inside = inside[key]
                continue
            inside[key] = _value(chance, inside[key])
            if isinstance(inside, dict) and chance.random() < 0.1:
                inside[chance.choice(["x", "", "load_n", "\ud800", "a" * 200])] = inside.pop(key)
            break
    if chance.random() < 0.5:
        return Scene.from_dict(data)
    scene = file.loads(SWEPT)
    key = chance.choice(["load_n", "rolling.load_n", "width_um", "sweep.rolling.load_n", "nothing"])
    return scene.with_(**{key: _value(chance, 1)})


def _value(chance: random.Random, before: Any) -> Any:
    """Return another value, of the same size for half of the numbers."""
    if isinstance(before, int | float) and abs(before) < 1e300 and chance.random() < 0.5:
        return before * chance.choice([1e-9, 1e-3, 0.1, 0.5, 2, 10, 1e3, 1e9])
    # A copy: a list that a case changed would change the cases after it.
    return copy.deepcopy(chance.choice(VALUES))


# ---- height files
# --------------------------------------------------------------------------------------------


def _heights(chance: random.Random) -> np.ndarray:
    """Make an array of heights, most of them usable."""
    shapes: list[tuple[int, ...]] = [(7, 9), (0, 9), (), (8, 8, 8), (1, 1), (0,)]
    usual: list[tuple[int, ...]] = [(16, 16), (24, 9), (8, 8), (30,), (1, 30), (30, 1)]
    shape = chance.choice(usual if chance.random() < 0.9 else shapes)
    noise = np.random.default_rng(chance.randrange(1000)).standard_normal(shape)
    scales = [1e-6, 0.0, 1e-300, 1.0, 1e200, 1.7e308]
    scale = 1e-8 if chance.random() < 0.8 else chance.choice(scales)
    dtypes = ["<f4", "<f2", "<i4", "<u8", "?", "<c16", "U3", "O", "<M8[s]"]
    dtype = chance.choice(["<f8", ">f8"]) if chance.random() < 0.8 else chance.choice(dtypes)
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        values = np.asarray(np.clip(noise, -1, 1) * scale)
        for _ in range(chance.choice([0, 0, 0, 0, 0, 0, 1, 3])):
            if values.size:
                odd = [np.nan, np.inf, -np.inf, 1.7e308, -1.7e308, 5e-324, -0.0, 1e-3]
                values.flat[chance.randrange(values.size)] = chance.choice(odd)
        return values.astype(dtype)


def _binary(values: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.lib.format.write_array(stream, values, allow_pickle=True)
    return stream.getvalue()


def _odd_header(chance: random.Random) -> bytes:
    shapes = [
        "(True, True)",
        "(-1, 64)",
        "(64, -1)",
        "(8, 8)",
        "(8.0, 8)",
        "8",
        "()",
        "None",
        "(8,)",
    ]
    shapes += [
        "(" + "9" * 23 + ", 64)",
        "(0, " + "9" * 23 + ")",
        "(9" * 500,
        "('8', 8)",
        "(8, 8, 8)",
    ]
    descrs = ["'<f8'", "'|O'", "'<M8[ns]'", "[('a', '<f8')]", "('<f8', (2,))", "'f'", "1", "'<f99'"]
    keys = [
        ("descr", chance.choice(descrs)),
        ("fortran_order", chance.choice(["False", "True", "3"])),
    ]
    keys.append(("shape", chance.choice(shapes)))
    text = "{" + ", ".join(f"'{key}': {value}" for key, value in keys) + "}"
    text = mutated(text, chance) if chance.random() < 0.3 else text
    head = text.encode("latin-1", "replace") + b"\n"
    version = chance.choice([b"\1\0"] * 8 + [b"\2\0", b"\3\0", b"\xff\xff"])
    size = struct.pack(
        "<H" if version == b"\1\0" else "<I", len(head) + chance.choice([0, 0, 0, 1, -1])
    )
    return b"\x93NUMPY" + version + size + head + bytes(chance.choice([0, 8, 512, 4096]))


def _flipped(content: bytes, chance: random.Random) -> bytes:
    """Return bytes with flips, most of them at the beginning or end, cuts, or insertions."""
    data = bytearray(content)
    for _ in range(chance.choice([0, 1, 1, 2, 8])):
        if not data:
            break
        near = min(len(data), 160)
        at = chance.choice(
            [
                chance.randrange(near),
                len(data) - 1 - chance.randrange(near),
                chance.randrange(len(data)),
            ]
        )
        match chance.randrange(6):
            case 0:
                del data[at:]
            case 1:
                data[at:at] = bytes(chance.randrange(256) for _ in range(chance.randint(1, 9)))
            case 2:
                del data[at : at + chance.randint(1, 9)]
            case _:
                data[at] = chance.randrange(256) if chance.random() < 0.5 else data[at] ^ 1
    return bytes(data)


def _text(values: np.ndarray, chance: random.Random) -> bytes:
    """Write heights as text with broken fields and lines of other lengths."""
    separator = chance.choice([",", ";", "\t", " ", ", "])
    end = chance.choice(["\n", "\r\n", "\r"])
    rows = [[str(x) for x in row] for row in np.atleast_2d(values).tolist()]
    for _ in range(chance.choice([0, 0, 1, 2])):
        if rows and rows[0]:
            row = rows[chance.randrange(len(rows))]
            match chance.randrange(4):
                case 0:
                    row[chance.randrange(len(row)) if row else 0 :] = []
                case 1:
                    row.append(chance.choice(WORDS))
                case _:
                    row[:1] = [chance.choice(WORDS)]
    text = end.join(separator.join(row) for row in rows)
    if chance.random() < 0.3:
        text = mutated(text or " ", chance)
    encoding = chance.choice(["utf-8", "utf-8", "utf-8", "utf-8-sig", "utf-16", "latin-1"])
    return text.encode(encoding, "replace")


def _archive(values: np.ndarray, chance: random.Random) -> bytes:
    stream = io.BytesIO()
    method = chance.choice([zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_LZMA])
    with zipfile.ZipFile(stream, "w", method) as archive, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of names given twice
        for name in chance.choices(["heights.npy", "a.npy", "x.txt", ".npy", "b/c.npy"], k=2):
            content = _binary(values) if chance.random() < 0.8 else _odd_header(chance)
            archive.writestr(name, _flipped(content, chance) if chance.random() < 0.2 else content)
    return stream.getvalue()


def heights_case(number: int, folder: Path) -> Scene:
    """Read a scene with the broken height file of a number."""
    chance = random.Random(number)
    values = _heights(chance)
    ending = chance.choice([".npy", ".npy", ".npz", ".npz", ".csv", ".txt", ".CSV"])
    ending = ".sur" if chance.random() < 0.01 else ending
    if ending == ".npy":
        content = _odd_header(chance) if chance.random() < 0.15 else _binary(values)
    elif ending == ".npz":
        content = _archive(values, chance)
    else:
        content = _text(values, chance)
    if chance.random() < 0.3:
        content = _flipped(content, chance)
    path = folder / f"h{ending}"
    path.write_bytes(content)
    overrides = []
    if chance.random() < 0.2:
        overrides.append(
            "surface.height_unit=" + chance.choice(["mm", "um", "nm"] * 5 + ["km", "1"])
        )
    if 1 in values.shape or values.ndim == 1 or chance.random() < 0.03:
        overrides.append("surface.width_um=" + chance.choice(["20"] * 20 + ["3", "1e15"]))
    if chance.random() < 0.2:
        overrides.append("surface.level=" + chance.choice(["plane", "none"]))
    if chance.random() < 0.2:
        overrides.append("rolling.duration_s=" + chance.choice(["1e-10", "1e-3", "1e-3", "1e15"]))
    return file.loads(HEIGHTS % path.name, overrides, folder=folder)


# ---- outcomes
# --------------------------------------------------------------------------------------------

CASES: dict[str, Callable[[int, Path], Scene]] = {
    "scene": scene_case,
    "values": values_case,
    "heights": heights_case,
}


def outcome(make: Callable[[], Scene]) -> str:
    """Make and check a scene; return "read" or "refused", and let anything else pass as an error.

    Warnings of libraries are errors too: the program says what is wrong itself.
    """
    ignored: list[Any] = []
    before = sys.unraisablehook
    sys.unraisablehook = ignored.append
    try:
        with warnings.catch_warnings(), np.errstate(divide="raise", invalid="raise", over="raise"):
            warnings.simplefilter("error")
            str(findings.check_scene(make(), solve=False))
    except SceneError as error:
        assert error.mistakes and all(fault.strip() for fault in error.mistakes)
        assert len(str(error)) < 100_000
        assert "pickle" not in str(error) and "set_int_max_str" not in str(error)
        return "refused"
    finally:
        sys.unraisablehook = before
        assert not ignored, ignored
    return "read"


def main(arguments: list[str]) -> int:
    """Check mutated scenes and heights; print each that ends in a traceback, and counts."""
    count, first = (int(text) for text in [*arguments[:2], *("1000", "0")[len(arguments[:2]) :]])
    kinds = arguments[2:] or list(CASES)
    counts: Counter[str] = Counter()
    slowest = (0.0, "")
    with tempfile.TemporaryDirectory() as folder:
        for number in range(first, first + count):
            kind = kinds[number % len(kinds)]
            began = time.process_time()
            try:
                result = outcome(lambda: CASES[kind](number, Path(folder)))  # noqa: B023
            except Exception as error:
                result = "error"
                print(f"\n{kind} {number}: {type(error).__name__}: {str(error)[:200]}")
                traceback.print_exc(limit=-4)
            slowest = max(slowest, (time.process_time() - began, f"{kind} {number}"))
            counts[f"{kind} {result}"] += 1
    print(dict(sorted(counts.items())), f"slowest {slowest[0]:.2f} s: {slowest[1]}")
    return 1 if any("error" in key for key in counts) else 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
