"""Texts after the forms of instruments: one known surface comes out of each, or a remedy.

Each form is written here from the same heights, with the heading, the separators, the order and the
marks of missing points that exports of that kind have.
"""

from __future__ import annotations

import gzip
import re
from pathlib import Path

import numpy as np
import pytest

from acoustics.arrays import Array
from rolling import cli
from rolling.in_si.described_file import FileOptions, described_file
from rolling.scene import height_grid
from rolling.scene.height_format import HeightFormatError
from rolling.terminal.whole_files import FolderError

SHAPE = 24, 15  # rows (y) and columns (x)
STEP_UM = 2.0
Z = np.round(np.random.default_rng(7).normal(size=SHAPE), 4)  # um
HOLES = Z.copy()
HOLES[5, 6] = HOLES[12, 0] = HOLES[23, 14] = np.nan
PROFILE = Z.ravel()[:200]


def rows(
    z: Array, between: str = "\t", missing: str = "NaN", comma: bool = False, digits: int = 4
) -> str:
    """Write a matrix as lines of numbers."""
    lines = []
    for row in z:
        cells = [missing if np.isnan(number) else f"{number:.{digits}f}" for number in row]
        lines.append(between.join(cells) + "\n")
    text = "".join(lines)
    return text.replace(".", ",") if comma else text


def points(
    z: Array,
    order: str = "xyz",
    between: str = " ",
    xy: float = STEP_UM,
    missing: str | None = None,
) -> list[str]:
    """Write points, a line each, in the order of the letters; missing ones are left out."""
    lines = []
    for (i, j), height in np.ndenumerate(z):
        if np.isnan(height) and missing is None:
            continue
        text = missing if np.isnan(height) else f"{height:.4f}"
        cells = {"x": f"{j * xy:.6g}", "y": f"{i * xy:.6g}", "z": text or "", "i": "17"}
        lines.append(between.join(cells[letter] for letter in order))
    return lines


def shuffled(lines: list[str]) -> str:
    """Put lines in an order of chance."""
    return "\n".join(np.random.default_rng(3).permutation(lines).tolist()) + "\n"


def profile(between: str, comma: bool = False, step: float = STEP_UM / 1e3) -> str:
    """Write places in mm beside heights in um."""
    text = "".join(f"{k * step:.4f}{between}{z:.4f}\n" for k, z in enumerate(PROFILE))
    return text.replace(".", ",") if comma else text


KEYENCE = """"Measurement data"
"Measured on","2025/03/11 10:00:00"
"XY calibration","2.0","um/pixel"
"Output image data","Height"
"Horizontal","15"
"Vertical","24"
"Unit","um"

"Height"
"""
KEYENCE_DE = KEYENCE.replace("XY calibration", "XY-Kalibrierung").replace('"Unit"', '"Einheit"')
KEYENCE_JA = """"測定日時","2025/03/11 10:00:00"
"XYキャリブレーション","2.0","um"
"出力画像データ","高さ"
"横","15"
"縦","24"
"単位","um"

"高さ"
"""
ZYGO = """Zygo XYZ Data File - Format 1
0 3 0 0 "Tue Mar 11 10:00:00 2025"
0 0 15 24 1 255
0 0 15 24
""
""
""
0 0.5 6.328e-07 0.5 1 0 2e-06 1741687200
3 2 0 0 0 666666 0 ""
0 0 1 33 0 0 0.1 60.4318 2 50
0 1 100 0 0 0 0 0 0 0
0 ""
1 5 0
#
"""
WYKO = """Wyko ASCII Data File Format\t0\t{flag}\t1
X Size\t15
Y Size\t24
Block Name\tType\tLength\tValue
Wavelength\t7\t4\t500
Aspect\t7\t4\t1
Pixel_size\t7\t4\t0.002
Title\t5\t20\tplate
RAW_DATA\t3\t1440\t
"""
GWYDDION = "# Channel: Height\n# Width: 30.00 µm\n# Height: 48.00 µm\n# Value units: m\n"
ESRI = "ncols 15\nnrows 24\nxllcorner 0\nyllcorner 0\ncellsize 2.0\nNODATA_value -9999\n"

# Each form: name of the file, content, and whether it has the holes.
MATRICES: dict[str, tuple[str, str | bytes, bool]] = {
    "Gwyddion matrix": (
        "g.txt",
        GWYDDION + "\n".join("\t".join(f"{z * 1e-6:.6e}" for z in row) for row in Z),
        False,
    ),
    "Gwyddion matrix in German": (
        "g.txt",
        "# Kanal: Höhe\n# Breite: 30,0 µm\n# Höhe: 48,0 µm\n# Einheiten: µm\n"
        + rows(Z, comma=True),
        False,
    ),
    "MountainsMap text with sizes": (
        "m.txt",
        "Name: plate\nX length: 30 µm\nY length: 48 µm\nX points: 15\nY points: 24\nZ unit: µm\n\n"
        + rows(HOLES, " ", "***"),
        True,
    ),
    "MountainsMap matrix with places": (
        "m.csv",
        "Z unit: µm\nY\\X [µm];"
        + ";".join(f"{2 * k}" for k in range(15))
        + "\n"
        + "".join(
            f"{2 * i};" + ";".join(f"{z:.4f}" for z in row) + "\n" for i, row in enumerate(Z)
        ),
        False,
    ),
    "Keyence VK": ("vk.csv", KEYENCE + rows(Z, '","').replace("\n", '"\n"')[:-1], False),
    "Keyence VK in German": (
        "vk.csv",
        KEYENCE_DE.replace(",", ";").replace("2.0", "2,0") + rows(Z, ";", comma=True),
        False,
    ),
    "Keyence VK in Japanese": ("vk.csv", (KEYENCE_JA + rows(Z, ",")).encode("cp932"), False),
    "Keyence VK in UTF-16": ("vk.csv", (KEYENCE + rows(Z, "\t")).encode("utf-16"), False),
    "Olympus LEXT": (
        "lext.csv",
        "Model,OLS5000\nDate,2025-03-11\nPixel size X[um],2.0\nPixel size Y[um],2.0\n"
        "Height unit,um\nData\n" + rows(Z, ","),
        False,
    ),
    "Bruker Vision in nm": (
        "v.asc",
        WYKO.format(flag=1) + rows(1e3 * HOLES.T, missing="Bad", digits=1),
        True,
    ),
    "Wyko in waves": ("w.asc", WYKO.format(flag=0) + rows(2 * HOLES.T, missing="Bad"), True),
    "NanoFocus": (
        "n.txt",
        "NanoFocus AG µsurf\nPixel X: 15\nPixel Y: 24\nPunktabstand X = 2,0 µm\n"
        "Punktabstand Y = 2,0 µm\nZ-Einheit = µm\n[Daten]\n" + rows(HOLES, missing="", comma=True),
        True,
    ),
    "Alicona matrix": (
        "a.txt",
        "% Alicona InfiniteFocus\n% PixelSizeXMeter=2e-6 m\n% Invalid value: 1e+37\n% unit: m\n"
        + "\n".join(
            " ".join("1e+37" if np.isnan(z) else f"{z * 1e-6:.6e}" for z in row) for row in HOLES
        ),
        True,
    ),
    "ESRI grid in um": ("e.asc", ESRI + "unit um\nxy unit um\n" + rows(HOLES, " ", "-9999"), True),
    "spreadsheet with metadata": (
        "s.csv",
        "Instrument;Confocal\nDate;2025-03-11\nX-Pixels;15\nY-Pixels;24\nPixel size;2.0 um\n"
        "Height unit;um\n[Data]\n" + rows(HOLES, ";", ""),
        True,
    ),
    "German spreadsheet": (
        "s.csv",
        "Messgerät;Konfokal\nPunktabstand;2,0 µm\nHöheneinheit;µm\n\n" + rows(Z, ";", comma=True),
        False,
    ),
    "spreadsheet with empty edges": (
        "s.csv",
        "\ufeffPixel size;2.0 um\nHeight unit;um\n\n"
        + rows(Z, ";").replace("\n", ";;\n")
        + 2 * (16 * ";" + "\n"),
        False,
    ),
    "quoted decimal commas": (
        "q.csv",
        "Pixel size [um],2\nHeights [um],plate\n"
        + "".join(",".join(f'"{z:.4f}"'.replace(".", ",") for z in row) + "\n" for row in Z),
        False,
    ),
    "numbered rows and columns": (
        "n.tsv",
        "Pixel size\t2 um\nUnit\tum\n\t"
        + "\t".join(str(k) for k in range(1, 16))
        + "\n"
        + "".join(f"{i}\t" + rows(row[None]) for i, row in enumerate(Z, 1)),
        False,
    ),
    "rows with names": (
        "n.csv",
        "Spacing,2,um\nUnit,um\n"
        + "".join(f"Row {i}," + rows(row[None], ",") for i, row in enumerate(Z)),
        False,
    ),
    "unicode minus": (
        "u.csv",
        "Spacing: 2 µm\nZ unit: µm\n" + rows(Z, ";").replace("-", "\u2212"),
        False,
    ),
    "thin spaces between thousands": (
        "t.csv",
        "Schrittweite: 2 µm\nZ-Einheit: nm\n"
        + "\n".join(
            ";".join(f"{1e3 * z:,.1f}".replace(",", "\u202f").replace(".", ",") for z in row)
            for row in Z
        ),
        False,
    ),
    "points between thousands": (
        "t.csv",
        "Schrittweite: 2 µm\nZ-Einheit: nm\n"
        + "\n".join(
            ";".join(
                f"{1e3 * z:,.1f}".replace(",", "_").replace(".", ",").replace("_", ".") for z in row
            )
            for row in Z
        ),
        False,
    ),
    "a column for a row": (
        "c.csv",
        "columns: 15\nrows: 24\nspacing: 2 um\nunit: um\n" + rows(Z.T, ","),
        False,
    ),
    "text behind the numbers": (
        "f.txt",
        "step 2 um\nheights in um\n\n" + rows(Z) + "\nEnd of data: 24 lines\n",
        False,
    ),
    "sides in mm": (
        "f.txt",
        "# width 0.03 mm\n# height 0.048 mm\n# unit mm\n" + rows(Z / 1e3, digits=7),
        False,
    ),
    "Zygo XYZ": (
        "z.xyz",
        ZYGO + "\n".join(points(HOLES, xy=1, missing="No Data")) + "\n#\n",
        True,
    ),
    "triples with a heading": (
        "t.xyz",
        "X(mm)\tY(mm)\tZ(um)\n" + "\n".join(points(HOLES, between="\t", xy=0.002)),
        True,
    ),
    "triples with a line of units": (
        "t.csv",
        "X;Y;Z\nmm;mm;µm\n" + "\n".join(points(HOLES, between=";", xy=0.002)).replace(".", ","),
        True,
    ),
    "triples in another order": (
        "t.txt",
        "Height [um], Y [mm], X [mm]\n" + shuffled(points(HOLES, "zyx", ", ", 0.002)),
        True,
    ),
    "scattered order": ("t.csv", "x_um,y_um,z_um\n" + shuffled(points(HOLES, between=",")), True),
    "Sensofar triples": (
        "s.dat",
        "SENSOFAR plate\nDate: 2025-03-11\nx(µm)\ty(µm)\tz(µm)\n"
        + "\n".join(points(HOLES, between="\t", missing="***")),
        True,
    ),
    "triples and an intensity": (
        "i.csv",
        "X [µm],Y [µm],Z [µm],Intensity\n" + "\n".join(points(HOLES, "xyzi", ",")),
        True,
    ),
    "Alicona points in m": (
        "a.txt",
        "x[m] y[m] z[m]\n"
        + "\n".join(
            f"{2e-6 * j:.7g} {2e-6 * i:.7g} {Z[i, j] * 1e-6:.6e}" for i, j in np.ndindex(SHAPE)
        ),
        False,
    ),
}
PROFILES: dict[str, tuple[str, str]] = {
    "Mahr": ("p.txt", "MarSurf XC\nX [mm]\tZ [µm]\n" + profile("\t")),
    "Mahr in German": ("p.txt", "Profil;R\nWeg [mm];Höhe [µm]\n" + profile(";", comma=True)),
    "Hommel": (
        "p.csv",
        "Tastschnitt\nTaststreckenlänge: 0,4 mm\nPos. (mm);Profil (µm)\n"
        + profile(";", comma=True),
    ),
    "Taylor Hobson": (
        "p.prf",
        "Form Talysurf\nSpacing = 0.002 mm\nZ unit = um\n[DATA]\n"
        + "".join(f"{z:.4f}\n" for z in PROFILE),
    ),
    "Bruker Dektak": (
        "p.csv",
        "Scan Length,400,um\nLateral um,Raw um\n" + profile(",", step=STEP_UM),
    ),
    "a column with decimal commas": (
        "p.txt",
        "Schrittweite 2 µm\nEinheit µm\n\n"
        + "".join(f"{z:.4f}\n" for z in PROFILE).replace(".", ","),
    ),
    "a number for each point": (
        "p.csv",
        "Spacing;2 um\nNo.;Height [um]\n"
        + "".join(f"{k};{z:.4f}\n" for k, z in enumerate(PROFILE, 1)),
    ),
}


def write(path: Path, content: str | bytes) -> Path:
    """Write a file; text in UTF-8."""
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


@pytest.mark.parametrize("name", MATRICES)
def test_an_export_of_a_surface_gives_its_heights(name: str, tmp_path: Path) -> None:
    """Heights, spacing and missing points are those that were written, and nothing is doubted."""
    file_name, content, has_holes = MATRICES[name]
    path = write(tmp_path / file_name, content)
    read = height_grid.read(path)
    expected = HOLES if has_holes else Z
    np.testing.assert_allclose(1e6 * read.heights, expected, rtol=0, atol=6e-5)
    assert read.spacing_m == pytest.approx((2e-6, 2e-6), rel=1e-6)
    assert read.names_unit and "\n" not in read.taken
    described = described_file(path, FileOptions())
    assert described.doubts == []
    assert described.steps == pytest.approx(2e-6)


@pytest.mark.parametrize("name", PROFILES)
def test_an_export_of_a_profile_gives_its_heights(name: str, tmp_path: Path) -> None:
    file_name, content = PROFILES[name]
    read = height_grid.read(write(tmp_path / file_name, content))
    np.testing.assert_allclose(1e6 * read.heights[:, 0], PROFILE, rtol=0, atol=6e-5)
    assert read.spacing_m == pytest.approx((2e-6, 2e-6), rel=1e-6)
    assert read.names_unit and "profile" in read.taken


# ---- what is refused, with the line and the remedy

HEAD = "Pixel size;2.0 um\nHeight unit;um\n"
REFUSALS: dict[str, tuple[str, str | bytes, str]] = {
    "gzip by name": ("z.csv", gzip.compress(rows(Z).encode()), "packed by gzip: unpack it"),
    "workbook": ("z.csv", b"PK\x03\x04" + bytes(300), "save the sheet as CSV"),
    "binary": (
        "z.csv",
        np.random.default_rng(1).bytes(4000),
        "is no text; give a file of an instr",
    ),
    "array": ("z.txt", b"\x93NUMPY\x01\x00" + bytes(200), "give it the ending .npy"),
    "zero bytes": ("z.csv", bytes(5000), "is no text"),
    "a zero byte in a row": ("z.csv", rows(Z, ";").replace(".", "\x00", 1), 'z.csv:1: got "'),
    "one line is short": (
        "z.csv",
        HEAD + rows(Z[:9], ";") + "1.5;2.5\n" + rows(Z[9:], ";"),
        "z.csv:12: got 2 numbers, allowed: 15",
    ),
    "the first line is short": ("z.csv", "1.5;2.5\n" + rows(Z, ";"), "z.csv:1: got 2 numbers"),
    "a word among numbers": (
        "z.csv",
        HEAD + rows(Z, ";").replace(f"{Z[7, 3]:.4f}", "4.5.6"),
        'z.csv:10: got "4.5.6"',
    ),
    "beyond all numbers": (
        "z.csv",
        HEAD + rows(Z, ";").replace(f"{Z[7, 3]:.4f}", "1e999"),
        'z.csv:10: got "1e999"',
    ),
    "nothing measured": ("z.csv", HEAD + rows(np.full(SHAPE, np.nan), ";"), "a row of numbers"),
    "no numbers": ("z.csv", "this is\nno table\n", "no line is a row of numbers"),
    "empty": ("z.csv", "", "holds no heights"),
    "two tables": ("z.txt", "step 2 um\n" + rows(Z) + "\nIntensity\n" + rows(Z), "several tables"),
    "half a file": (
        "z.csv",
        "columns;15\nrows;30\n" + HEAD + rows(Z, ";"),
        "names 15 points in x and 30 in y: it is not whole",
    ),
    "no spacing": (
        "z.csv",
        rows(Z, ";"),
        "--spacing-um: missing; the file holds no spacing, nor a unit of its heights",
    ),
    "no unit": ("z.csv", "Pixel size;2.0 um\n" + rows(Z, ";"), "give --height-unit um or nm"),
    "points off a grid": (
        "z.csv",
        "x[um] y[um] z[um]\n"
        + "\n".join(f"{x} {y} {z}" for x, y, z in np.random.default_rng(2).random((40, 3))),
        "interpolate the points onto one",
    ),
    "places without end": (
        "z.csv",
        "x[um] y[um] z[um]\n" + "\n".join([*points(Z), "1e308 0 1"]),
        "no places",
    ),
    "a header of other words": (
        "z.asc",
        WYKO.format(flag=1).replace("0.002", "small").replace("Size\t15", "Size\tplate") + rows(Z),
        "--spacing-um: missing",
    ),
    "a number of points without end": ("z.csv", "columns;1e999\n" + rows(Z, ";"), "--spacing-um"),
    "places of a profile in unequal steps": (
        "z.csv",
        "x[mm] z[um]\n" + "\n".join(f"{0.002 * k * k:.4f} {z:.4f}" for k, z in enumerate(PROFILE)),
        "regular grid",
    ),
}


@pytest.mark.parametrize("name", REFUSALS)
def test_what_cannot_be_read_is_refused_with_the_remedy(name: str, tmp_path: Path) -> None:
    file_name, content, words = REFUSALS[name]
    path = write(tmp_path / file_name, content)
    with pytest.raises(FolderError) as error:
        read = described_file(path, FileOptions())
        pytest.fail(read.taken)
    text = str(error.value)
    assert words in text and "\n" not in text and len(text) < 600


@pytest.mark.parametrize("ending", ["\n", ""])
def test_a_huge_line_is_read_or_refused_before_it_fills_memory(
    ending: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write(tmp_path / "z.csv", "1.5," * 30_000 + "2.5" + ending)
    assert height_grid.read(path).numbers.shape == (30_001, 1)
    monkeypatch.setattr("rolling.scene.text_table.MAX_LINE", 50_000)
    write(path, "1.5," * 30_001 + "2.5" + ending)
    with pytest.raises(HeightFormatError, match="more than 50,000 letters"):
        height_grid.read(path)


def test_blocks_that_numpy_reads_end_anywhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A block ends within a line, behind an empty cell, or before the last line."""
    path = write(tmp_path / "z.csv", HEAD + rows(HOLES, ";", ""))
    for size in (1, 57, 100, 1000):
        monkeypatch.setattr("rolling.scene.text_table._BLOCK", size)
        path = write(tmp_path / f"{size}.csv", HEAD + rows(HOLES, ";", ""))
        np.testing.assert_array_equal(height_grid.read(path).numbers, HOLES)


def test_an_extreme_height_is_a_mark(tmp_path: Path) -> None:
    path = write(tmp_path / "z.csv", HEAD + rows(Z, ";").replace(f"{Z[7, 3]:.4f}", "1e308"))
    read = described_file(path, FileOptions())
    assert "exactly 1e+308 um" in str(read.doubts) and np.isnan(read.measured_heights[7, 3])
    assert np.nanmax(np.abs(read.heights)) < 5e-6


# ---- from the file to the scene


def test_two_commands_lead_from_an_export_to_a_scene(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """What was taken for what is one line, and the offered line needs no option."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("rolling.commands.surface._parameters_and_picture", lambda *_: ([], {}))
    file_name, content, _ = MATRICES["triples with a line of units"]
    write(Path(file_name), content)
    assert cli.main(["surface", file_name]) == 0
    said = capsys.readouterr()
    (taken,) = [line for line in said.err.splitlines() if "taken for" in line]
    assert "360 points x, y, z, by the heading" in taken or "357 points" in taken
    line = next(line.strip() for line in said.out.splitlines() if "surface: {" in line)
    assert re.fullmatch(r"surface: \{kind: file, path: 't\.csv', unmeasured: fill, .*\}", line)
    text = f"name: own\nsphere: {{radius_mm: 5}}\nplate: {{material: steel-100cr6}}\n{line}\n"
    Path("own.yaml").write_text(text + "rolling: {load_n: 0.1, speed_m_s: 0.1}\n")
    assert cli.main(["surface", "own.yaml", "-q"]) == 0
