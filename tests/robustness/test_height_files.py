"""Height files of each format and unit: the same heights whatever the format, and faults that name
file, line and what is allowed.
"""

from __future__ import annotations

import io
import os
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hard_cases.gaussian_heights import gaussian

from acoustics.numbers import rounded
from rolling import cli
from rolling.check import findings
from rolling.contact.kept import Kept
from rolling.in_si import scene_surface
from rolling.in_si.described_file import DescribedFile, FileOptions, described_file
from rolling.scene import file, height_files, height_grid, text_heights, text_look, text_table
from rolling.scene.height_format import HeightFormatError
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene

TEXT = """\
name: measured
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3}
surface: {kind: file, path: %s, spacing_um: 2}
rolling: {load_n: 0.2, speed_m_s: 0.1}
"""
Z = gaussian((24, 32), 2e-6, 2e-8, (1e-5, 1e-5), "gaussian", 1)
ROWS = [[repr(float(number)) for number in row] for row in Z]


def scene(folder: Path, name: str, *overrides: str) -> Scene:
    return file.loads(TEXT % name, overrides, folder=folder)


def fault(folder: Path, name: str, *overrides: str) -> str:
    """Return the one fault of a scene with a height file, which track and surface agree on."""
    with pytest.raises(SceneError) as error:
        findings.check_scene(scene(folder, name, *overrides), solve=False)
    (text,) = error.value.mistakes
    assert "pickle" not in text and "\n" not in text
    return text


def described(folder: Path, unit: str) -> DescribedFile:
    """Return h.csv as `rolling surface` describes it."""
    return described_file(folder / "h.csv", FileOptions(spacing_um=2.0, height_unit=unit))


def text_of(separator: str, end: str = "\n") -> str:
    return "".join(separator.join(row) + end for row in ROWS)


WRITERS: dict[str, Callable[[Path], object]] = {
    "h.npy": lambda path: np.save(path, Z),
    "H.NPY": lambda path: path.write_bytes(npy(Z)),
    "only.npz": lambda path: np.savez(path, anything=Z),
    "named.npz": lambda path: np.savez_compressed(path, heights=Z, mask=Z > 0, x=np.arange(3)),
    "comma.csv": lambda path: path.write_text(text_of(",")),
    "semicolon.csv": lambda path: path.write_text(text_of(" ; ", ";\n")),
    "tab.txt": lambda path: path.write_text(text_of("\t", "\r\n")),
    "space.txt": lambda path: path.write_text(text_of("   ", " \n")),
    "old_mac.txt": lambda path: path.write_bytes(text_of(" ", "\r").encode()),
    "mark.csv": lambda path: path.write_text(text_of(","), encoding="utf-8-sig"),
    "wide.csv": lambda path: path.write_text(text_of(","), encoding="utf-16"),
    "unmarked.csv": lambda path: path.write_text(text_of(","), encoding="utf-16-be"),
    "comments.csv": lambda path: path.write_bytes(
        b"# H\xf6he [m]\n\n" + text_of(", ").encode() + b"\n# end"
    ),
}


def npy(values: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.save(stream, values)
    return stream.getvalue()


@pytest.mark.parametrize("name", WRITERS)
def test_the_same_heights_come_out_of_every_format(tmp_path: Path, name: str) -> None:
    WRITERS[name](tmp_path / name)
    np.save(tmp_path / "reference.npy", Z)
    own = scene(tmp_path, name)
    assert (own.track.n_along, own.track.n_across) == Z.shape
    expected = scene_surface.scene_surface(scene(tmp_path, "reference.npy"))
    read = scene_surface.scene_surface(own)
    assert np.array_equal(read.heights, expected.heights)


@pytest.mark.parametrize(("unit", "factor"), [("m", 1), ("mm", 1e3), ("um", 1e6), ("nm", 1e9)])
def test_heights_are_in_the_unit_that_the_scene_says(
    tmp_path: Path, unit: str, factor: float
) -> None:
    np.savetxt(tmp_path / "h.txt", Z * factor)
    read = scene_surface.heights(scene(tmp_path, "h.txt", f"surface.height_unit={unit}"))
    np.testing.assert_allclose(read, Z - Z.mean(), rtol=1e-12, atol=1e-22)


def test_a_unit_that_cannot_be_is_refused(tmp_path: Path) -> None:
    np.save(tmp_path / "h.npy", Z * 1e6)
    assert "set surface.height_unit, m here, to the unit of the file (m, mm, um, nm)" in fault(
        tmp_path, "h.npy"
    )
    with pytest.raises(SceneError, match=r"got \"µm\", allowed: m, mm, um or nm"):
        scene(tmp_path, "h.npy", "surface.height_unit=µm")


# ---- profiles of one line
# --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "write"),
    [
        ("flat.npy", lambda path, z: np.save(path, z)),
        ("column.npy", lambda path, z: np.save(path, z[:, None])),
        ("row.npz", lambda path, z: np.savez(path, z[None, :])),
        ("column.csv", lambda path, z: path.write_text("\n".join(map(repr, z.tolist())))),
        ("row.csv", lambda path, z: path.write_text(",".join(map(repr, z.tolist())))),
    ],
)
def test_a_profile_of_one_line_runs_along_and_is_the_same_all_across(
    tmp_path: Path, name: str, write: Callable[[Path, np.ndarray], object]
) -> None:
    profile = Z[:, 0]
    write(tmp_path / name, profile)
    laid = scene(tmp_path, name, "surface.width_um=20")
    assert (laid.track.n_along, laid.track.n_across) == (24, 10)
    read = scene_surface.heights(laid)
    assert np.array_equal(read, np.repeat((profile - profile.mean())[:, None], 10, axis=1))
    assert "24 x 10 nodes" in str(findings.check_scene(laid, solve=False))


def test_a_profile_needs_a_width_and_nothing_else_may_have_one(tmp_path: Path) -> None:
    np.save(tmp_path / "profile.npy", Z[:, 0])
    np.save(tmp_path / "map.npy", Z)
    assert fault(tmp_path, "profile.npy") == (
        "surface.width_um: missing; profile.npy is a profile of one"
        " line, which is laid across the track over that width"
    )
    assert fault(tmp_path, "map.npy", "surface.width_um=20") == (
        "surface.width_um: only goes with a profile of one line, but map.npy has 32 lines side"
        " by side"
    )
    with pytest.raises(SceneError, match=r"at least 8; nearest: 16"):
        scene(tmp_path, "profile.npy", "surface.width_um=3")
    np.save(tmp_path / "profile.npy", Z[:7, 0])
    assert "got 7 x 10 nodes" in fault(tmp_path, "profile.npy", "surface.width_um=20")
    np.save(tmp_path / "profile.npy", np.zeros((1, 0)))
    assert "got 0 x 10 nodes" in fault(tmp_path, "profile.npy", "surface.width_um=20")


# ---- faults of text
# --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("line", "content", "message"),
    [
        (1, "1,2,3", "1: got 3 numbers by comma, allowed: 32, as on the lines behind; put #"),
        (3, "1,2,abc", '3: got "abc", allowed: numbers by comma, semicolon, tab or '),
        (3, "caf\u00e9", '3: got "caf\u00e9", allowed: numbers'),
        (3, "1,,3", "3: got 3 numbers, allowed: 32, as on the lines before"),
        (3, "1,-inf,3", '3: got "-inf", allowed: numbers'),
        (3, "1,1e999,3", '3: got "1e999", allowed: numbers'),
        (3, "1,1_0,3", '3: got "1_0", allowed: numbers'),
        (3, "1,2,3", "3: got 3 numbers, allowed: 32, as on the lines before"),
        (24, "caf\u00e9", '24: got "caf\u00e9", allowed: numbers'),
        (24, "\x00\x01", '24: got "\\u0000\\u0001", allowed: numbers'),
        (24, "1" * 5000, '24: got "11111'),
    ],
)
def test_a_line_without_numbers_is_named(
    tmp_path: Path, line: int, content: str, message: str
) -> None:
    lines = text_of(",").splitlines()
    lines[line - 1] = content
    (tmp_path / "h.csv").write_text("\n".join(lines), encoding="utf-8")
    assert fault(tmp_path, "h.csv").startswith(f"surface.path: h.csv:{message}")


def test_a_decimal_comma_among_points_gets_its_own_advice(tmp_path: Path) -> None:
    (tmp_path / "h.csv").write_text(text_of(";") + ";".join(["0,5"] * 32))
    message = fault(tmp_path, "h.csv")
    assert 'h.csv:25: got "0,5"' in message and "with a point before the decimals" in message


@pytest.mark.parametrize("text", ["1,25,0,07\n2,5,3,25\n", "1,5, -2,5\n0,7,-1,05\n"])
def test_decimal_commas_between_commas_are_no_columns(text: str, tmp_path: Path) -> None:
    (tmp_path / "h.csv").write_text(text)
    assert "a comma is either before decimals or between numbers" in fault(tmp_path, "h.csv")


def decimal_commas(values: np.ndarray, separator: str, digits: int) -> str:
    """Write rows of numbers with a comma before their decimals."""
    rows = [[f"{number:.{digits}f}".replace(".", ",") for number in row] for row in values]
    return "".join(separator.join(row) + "\n" for row in rows)


UM = Z * 1e9  # some tens


@pytest.mark.parametrize("separator", ["\t", ";", " ", "   ", " ; "])
@pytest.mark.parametrize("digits", [1, 4])
def test_decimal_commas_are_read_with_every_other_separator(
    tmp_path: Path, separator: str, digits: int
) -> None:
    (tmp_path / "h.csv").write_text(decimal_commas(UM, separator, digits))
    read = height_files.numbers(tmp_path / "h.csv")
    assert np.array_equal(read, np.round(UM, digits))


@pytest.mark.parametrize("digits", [1, 2, 3])
@pytest.mark.parametrize("offset", [0.0, 150.0])
def test_a_comma_before_decimals_and_between_numbers_is_refused(
    tmp_path: Path, digits: int, offset: float
) -> None:
    """Where zeros lead the decimals one number tells, otherwise the two kinds of columns do."""
    text = decimal_commas(UM + offset, ",", digits)
    (tmp_path / "h.csv").write_text(text)
    assert "decimals" in fault(tmp_path, "h.csv", "surface.height_unit=nm")
    (tmp_path / "h.csv").write_text(text.replace("\n", ",\n"))  # an end without a number
    assert "decimals" in fault(tmp_path, "h.csv", "surface.height_unit=nm")


RANDOM = np.random.default_rng(4)
WHOLE = {
    "8 bits": RANDOM.integers(0, 256, (24, 32)),
    "signed": RANDOM.integers(-50, 51, (24, 32)),
    "16 bits": RANDOM.integers(0, 65536, (24, 32)),
    "three digits": RANDOM.integers(100, 200, (24, 32)),
    "two digits and one with three": np.where(
        np.arange(24 * 32).reshape(24, 32) == 36, 101, RANDOM.integers(10, 100, (24, 32))
    ),
    "one digit": RANDOM.integers(0, 10, (24, 32)),
    "near a power of ten": RANDOM.integers(95, 105, (24, 32)),
    "odd": RANDOM.integers(-50, 51, (24, 31)),
}


@pytest.mark.parametrize("separator", [", ", ";"])
@pytest.mark.parametrize("name", WHOLE)
def test_whole_numbers_are_read(tmp_path: Path, name: str, separator: str) -> None:
    """Tables of counts are no decimals; where all have equal digits, commas are doubted aloud."""
    heights = WHOLE[name]
    np.savetxt(tmp_path / "h.csv", heights, "%d", separator)
    read = scene_surface.scene_surface(scene(tmp_path, "h.csv", "surface.height_unit=nm"))
    np.testing.assert_allclose(read.heights, 1e-9 * (heights - heights.mean()), rtol=0, atol=1e-18)
    is_open = separator.startswith(",") and name in ("three digits", "one digit")
    is_open |= separator.startswith(",") and name == "two digits and one with three"
    assert any("comma" in sentence for sentence in read.suspicions) == is_open


# ---- places among the heights


@pytest.mark.parametrize(
    ("kind", "order", "separator"),
    [
        ("whole", (0, 1, 2), ","),
        ("gaps", (1, 0, 2), ";"),
        ("rows", (2, 0, 1), "\t"),
        ("mixed", (0, 1, 2), " "),
        ("one line", (1, 0, 2), ","),
        ("lying", (0, 1, 2), ";"),
        ("lying", (2, 0, 1), " "),
    ],
)
def test_triples_are_no_matrix(
    tmp_path: Path, separator: str, order: tuple[int, ...], kind: str
) -> None:
    """Three columns, or three rows, of which two are the places of a grid."""
    x, y = np.meshgrid(0.002 * np.arange(32), 0.005 * np.arange(24))
    points = np.column_stack([x.ravel(), y.ravel(), Z.ravel()])
    expected = Z.copy()
    if kind == "gaps":
        is_left = RANDOM.random(len(points)) < 0.9
        expected.flat[~is_left] = np.nan
        points = points[is_left]
    elif kind == "rows":  # whole lines were not measured
        points = points[(y.ravel() != 0.025) & (x.ravel() != 0.01)]
        expected[5] = expected[:, 5] = np.nan
    elif kind == "mixed":
        points = RANDOM.permutation(points)
    elif kind == "one line":
        points = points[:32]
        expected = Z[:1]
    if order.index(0) > order.index(1):  # the first places are those of the lines
        expected = expected.T
    points = points[:, order]
    if kind == "lying":
        points = points.T
    np.savetxt(tmp_path / "h.csv", points, "%.9g", separator)
    read = height_grid.read(tmp_path / "h.csv", unit="m", xy_unit="mm")
    np.testing.assert_allclose(read.numbers, expected, rtol=1e-8)
    steps = {2e-6, 5e-6} if kind != "one line" else {2e-6}
    assert {round(step, 9) for step in read.spacing_m or ()} == steps


def test_three_columns_of_heights_are_described(tmp_path: Path) -> None:
    for heights in (Z[:, :3], Z[:3], np.round(UM[:, :3]), np.tile(Z[:1, :3], (24, 1))):
        np.savetxt(tmp_path / "h.csv", heights, "%.9g", ",")
        read = described(tmp_path, "nm")
        assert read.heights.shape == heights.shape and read.doubts == []


def test_a_profile_with_its_places_is_a_profile(tmp_path: Path) -> None:
    for places in (0.5 * np.arange(24), 24.0 - np.arange(24), np.arange(1, 25)):
        np.savetxt(tmp_path / "h.txt", np.column_stack([places, Z[:, 0]]), "%.9g")
        read = height_grid.read(tmp_path / "h.txt", xy_unit="um")
        order = slice(None, None, -1 if places[1] < places[0] else 1)
        np.testing.assert_allclose(read.numbers[:, 0], Z[order, 0], rtol=1e-8)
        assert read.spacing_m == pytest.approx((1e-6 * abs(places[1] - places[0]),) * 2)


@pytest.mark.parametrize(
    ("change", "names"),
    [
        (lambda z: z, []),
        (lambda z: np.column_stack([1e-9 * np.arange(24), z]), ["column"]),
        (lambda z: np.column_stack([1e-6 * np.arange(24, 0, -1), z]), ["column"]),
        (lambda z: np.vstack([2e-9 * np.arange(32), z]), ["row"]),
        (
            lambda z: np.vstack(
                [np.arange(33) * 1e-9, np.column_stack([np.arange(24) * 1e-9 + 5e-9, z])]
            ),
            [],
        ),
        (lambda z: 1e-7 * np.add.outer(np.arange(24.0), np.arange(32.0)), []),  # a tilt
        (lambda z: z + 1e-6 * np.arange(24.0)[:, None], []),
        (lambda z: 0 * z, []),
        (lambda z: np.tile(z[:1], (24, 1)), []),
    ],
)
def test_a_line_that_counts_is_named(
    tmp_path: Path, change: Callable[[np.ndarray], np.ndarray], names: list[str]
) -> None:
    np.savetxt(tmp_path / "h.csv", change(Z), "%.9g", ",")
    sentences = scene_surface.scene_surface(scene(tmp_path, "h.csv")).suspicions
    assert [name for name in ("column", "row") if f"the first {name}" in str(sentences)] == names
    assert described(tmp_path, "m").doubts == [*sentences]


@pytest.mark.parametrize("path", ["a" * 5000 + ".csv", "a/" * 2500 + "b.csv"])
def test_a_path_of_five_thousand_letters_is_a_fault_of_its_key(path: str, tmp_path: Path) -> None:
    message = fault(tmp_path, path)
    assert message.startswith("surface.path: a") and "File name too long" in message
    assert len(message) < 200


def test_text_without_numbers_and_text_that_is_too_large(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "h.txt").write_text("# nothing\n\n")
    assert "h.txt: holds no heights" in fault(tmp_path, "h.txt")
    (tmp_path / "h.txt").write_text(text_of(" "))
    monkeypatch.setattr(text_table, "MAX_LINE", 100)
    assert "h.txt:1: a line of more than 100 letters" in fault(tmp_path, "h.txt")
    monkeypatch.setattr(text_table, "MAX_BYTES", 100)
    assert "is larger than 100 bytes of text; a .npy file may be larger" in fault(tmp_path, "h.txt")


@pytest.mark.parametrize(
    "text",
    [
        "1_0 2\n3 4",
        "1e999 2\n3 4",
        "nan 2\n3 NaN",
        "infinity 2\n1 2",
        "0x10 2",
        "1,2,\n3,4,",
        "1,2,,\n3,4,,",
        "1;2;\n3;4",
        "1;2,5\n3;4,5",
        "1, 2\n 3 ,4",
        "1\t2\t\n3\t4",
        "#c\n\n1 2\n#d\n3 4",
        "1 2 # x\n3 4",
        "1,05\n2,06",
        "05,1\n2,3",
        "0.5,1,05",
        "1.5,1,05",
        "1.5,2.5\n1,05",
        "+1 -2",
        "1.,.5",
        "1 2\n3",
        "1,,2",
        '"1" 2',
        "1 2\r3 4\r\n5 6",
        "\xef\xbb\xbf1,2\n3,4",
        "1\xa02\n3\xa04",
        "",
    ],
)
def test_numpy_reads_what_the_explaining_reader_reads(text: str, tmp_path: Path) -> None:
    """Where the latter says what is wrong, the former leaves it to it."""
    path = tmp_path / "h.txt"
    path.write_bytes(text.encode("latin-1"))
    try:
        head = text_table._head(path, text_table._encoding(path))
        look = text_look.look_at(head)
    except HeightFormatError:
        return
    body = "".join(head[look.first - 1 :])
    fast = text_table._fast(body, look, text_look.Commas())
    try:
        slow, _ = text_table._slow(body, look, text_look.Commas(), 1)
    except HeightFormatError:
        assert fast is None
        return
    if fast is not None:
        np.testing.assert_array_equal(fast, slow)


def test_two_files_in_turn_are_parsed_once_each(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A choice between two scans reads them in turn; what is too large is not kept."""
    parsed = []
    read = text_heights.read_table
    monkeypatch.setattr(text_heights, "read_table", lambda path: parsed.append(path) or read(path))
    paths = [tmp_path / name for name in ("a.csv", "b.csv")]
    for path in paths:
        path.write_text("1,2\n3,4.5\n")
    for _ in range(3):
        for path in paths:
            height_files.numbers(path)
    assert parsed == paths
    small = Kept(40, lambda heights: heights.numbers.nbytes)  # bytes, of which a table takes 32
    monkeypatch.setattr(text_heights, "_kept", small)
    for path in (*paths, *paths):
        text_heights.text_heights(path)
    assert parsed == 3 * paths


def test_a_text_that_was_written_again_is_read_again(tmp_path: Path) -> None:
    path = tmp_path / "h.csv"
    path.write_text(text_of(","))
    before = scene_surface.heights(scene(tmp_path, "h.csv"))
    path.write_text("\n".join(text_of(",").splitlines()[::-1]))
    later = path.stat().st_mtime_ns + 10**9  # clocks of file systems may be slower than this test
    os.utime(path, ns=(later, later))
    after = scene_surface.heights(scene(tmp_path, "h.csv"))
    np.testing.assert_allclose(after, before[::-1], atol=1e-20)


# ---- faults of other files
# --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["h.stl", "h.mat", "h", "h.npy.bak"])
def test_other_formats_are_refused_with_what_can_be_read(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(npy(Z))
    message = fault(tmp_path, name)
    assert "allowed: .npy, .npz, .csv or .txt, of a plate .xyz" in message
    assert (f"the ending {Path(name).suffix}" if "." in name else "no ending") in message


def test_archives_must_say_which_array_holds_the_heights(tmp_path: Path) -> None:
    np.savez(tmp_path / "h.npz", x=Z, y=Z)
    assert fault(tmp_path, "h.npz") == (
        "surface.path: h.npz: got 2 arrays ('x', 'y'), allowed: one array, or one that is named"
        ' "heights"'
    )
    np.savez(tmp_path / "h.npz")
    assert "got no array" in fault(tmp_path, "h.npz")
    (tmp_path / "h.npz").write_bytes(npy(Z))
    assert "no readable .npz file" in fault(tmp_path, "h.npz")
    np.savez(tmp_path / "h.npz", np.array([[{}, 1]], dtype=object))
    assert "got 2-D object" in fault(tmp_path, "h.npz")


def with_header(shape: str, descr: str = "'<f8'", data: bytes = bytes(8 * 64)) -> bytes:
    head = f"{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}\n".encode()
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head + data


@pytest.mark.parametrize(
    ("shape", "message"),
    [
        ("(True, True)", "profile of one line"),
        ("(-1, 64)", "a negative shape"),
        ("(10000000000000000000000, 64)", "its header says 10^24 or more bytes of heights"),
        ("(99999999999999999999999, 0)", "nodes, allowed: at least 8"),
        ("(" + "9" * 5000 + ", 9)", "no readable .npy file (damaged, or another format)"),
        ("(9.0, 9)", "no readable .npy file (damaged, or another format)"),
        ("9", "no readable .npy file (damaged, or another format)"),
        ("(" * 200, "no readable .npy file (damaged, or another format)"),
        ("(9, 9), 'x': " + "0" * 20000, "no readable .npy file (damaged, or another format)"),
        ("()", "got a 0-D array"),
    ],
)
@pytest.mark.parametrize("ending", [".npy", ".npz"])
def test_headers_that_lie(tmp_path: Path, ending: str, shape: str, message: str) -> None:
    content = with_header(shape)
    path = tmp_path / f"h{ending}"
    if ending == ".npy":
        path.write_bytes(content)
    else:
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("heights.npy", content)
    assert message.replace(".npy", ending if "readable" in message else ".npy") in fault(
        tmp_path, path.name
    )


@pytest.mark.parametrize("height", [1.7e308, -1.7e308, 1e200, 1e7])
def test_heights_beyond_reason_are_refused(tmp_path: Path, height: float) -> None:
    for values in (np.full_like(Z, height), np.where(Z > 0, height, -height)):
        np.save(tmp_path / "h.npy", values)
        assert f"got a height of {rounded(abs(height), 4)} m, allowed: up to 1000000 m" in fault(
            tmp_path, "h.npy"
        )
    np.save(tmp_path / "h.npy", np.full_like(Z, np.longdouble("1e4000"), dtype=np.longdouble))
    assert "are not numbers" in fault(tmp_path, "h.npy")
    signalling = np.full(Z.shape, 0x7FA00000, dtype="<u4").view("<f4")  # a cast of it is invalid
    np.save(tmp_path / "h.npy", signalling)
    assert "768 of 768 heights are not numbers" in fault(tmp_path, "h.npy")
    np.save(tmp_path / "h.npy", np.full(Z.shape, 2**64 - 1, dtype=np.uint64))
    assert "allowed: up to" in fault(tmp_path, "h.npy")


def test_packed_heights_are_bounded_before_they_are_unpacked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """630 kB may hold 650 MB; heights that are not packed take as much in their file."""
    heights = np.zeros((64, 64))
    np.savez_compressed(tmp_path / "packed.npz", heights=heights)
    np.savez(tmp_path / "plain.npz", heights=heights)
    monkeypatch.setattr(height_files, "MAX_BYTES", 20_000)
    with pytest.raises(HeightFormatError, match="32,896 bytes of packed heights, allowed: 20,000"):
        height_files.nodes(tmp_path / "packed.npz")
    assert height_files.nodes(tmp_path / "plain.npz") == (64, 64)


def test_a_file_that_memory_does_not_hold_is_not_described(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A file with holes takes little of a disk."""
    path = tmp_path / "huge.npy"
    header = io.BytesIO()
    facts = {"descr": "<f8", "fortran_order": False, "shape": (100_000, 100_000)}
    np.lib.format.write_array_header_1_0(header, facts)
    path.write_bytes(header.getvalue())
    os.truncate(path, len(header.getvalue()) + 8 * 10**10)
    assert cli.main(["surface", str(path), "--spacing-um", "1"]) == 2
    said = capsys.readouterr().err
    assert "memory: needs about" in said and "take a part of the surface" in said
