"""Files of instruments: equal heights from every format, and one sentence for every fault."""

from __future__ import annotations

import subprocess
import sys
import warnings
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from rolling.in_si import measured, scene_surface
from rolling.scene import file, height_grid
from rolling.scene.height_format import HeightFormatError
from rolling.scene.messages import SceneError

pytest.importorskip("x3pio", reason="the extra `surfaces` is not installed")
STEPS = 2e-6, 3e-6  # m along (y) and across (x)
Z = np.round(1e3 * np.random.default_rng(5).standard_normal((24, 17))) * 1e-9  # m
Z[3, 11] = Z[20, 2] = np.nan
TEXT = """\
name: scan
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3}
surface: {kind: file, path: %s, unmeasured: fill}
rolling: {load_n: 0.1, speed_m_s: 0.1}
"""


def triples(unit: float) -> str:
    places = np.argwhere(np.isfinite(Z))
    np.random.default_rng(1).shuffle(places)
    rows = np.column_stack([places[:, 1] * 3e-6, places[:, 0] * 2e-6, Z[tuple(places.T)]]) / unit
    return "\n".join(" ".join(map(repr, row)) for row in rows.tolist())


def gwyddion(path: Path) -> None:
    """SurfaceTopography holds heights as (x, y), here in um."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it misses MPI
        from SurfaceTopography import Topography

    heights = np.ma.masked_invalid(Z.T * 1e6)
    sizes = 3.0 * Z.shape[1], 2.0 * Z.shape[0]
    Topography(heights, physical_sizes=sizes, unit="um").to_gwy(str(path))


def crystal(path: Path) -> None:
    """BCRF: a header of 2048 letters and single floats, in nm; voids are the largest number."""
    lines = ["fileformat = bcrf", "headersize = 2048", "xpixels = 17", "ypixels = 24"]
    lines += ["xlength = 51000", "ylength = 48000", "xunit = nm", "yunit = nm", "zunit = nm"]
    lines += ["bit2nm = 1", "zmin = 0", "voidpixels = 2", "intelmode = 1"]
    header = "\n".join(lines).encode().ljust(2048)
    path.write_bytes(header + np.where(np.isnan(Z), 3e38, Z * 1e9).astype("<f4").tobytes())


def ascii_sdf(path: Path) -> None:
    import sdfio

    form = sdfio.FileFormat.ASCII
    sdfio.write(path, Z, x_scale=3e-6, y_scale=2e-6, z_scale=1e-9, format=form)


WRITERS: dict[str, Callable[[Path], object]] = {
    "own.x3p": lambda path: measured.write(path, Z, STEPS),
    "OWN.SDF": lambda path: measured.write(path, Z, STEPS),
    "own.xyz": lambda path: measured.write(path, Z, STEPS),
    "ascii.sdf": ascii_sdf,
    "um.xyz": lambda path: path.write_text(triples(1e-6)),
    "um.gwy": gwyddion,
    "nm.bcrf": crystal,
}


@pytest.mark.parametrize("name", WRITERS)
def test_every_format_gives_the_same_heights(tmp_path: Path, name: str) -> None:
    """Shape, spacing, gaps and heights [m] of an unequal map are equal; float32 keeps 2e-13 m."""
    path = tmp_path / name
    WRITERS[name](path)
    got = height_grid.read(path, unit=name[:2] if name == "um.xyz" else "m")
    assert got.spacing_m == pytest.approx(STEPS, rel=1e-9)
    np.testing.assert_allclose(got.heights, Z, rtol=0, atol=3e-13)
    assert not got.heights.flags.writeable and len(got.channels) == (name[-3:] != "xyz")
    turned = file.loads(
        TEXT % name, ["surface.along=x", "surface.periodic=mirror"], folder=tmp_path
    )
    if name != "um.xyz":
        assert (turned.track.n_along, turned.track.n_across) == (2 * 25 - 2, 2 * 24 - 2)
        assert turned.spacing == pytest.approx(2e-6) and turned.surface.spacing_um is None


@pytest.mark.parametrize("name", ["own.x3p", "OWN.SDF", "um.gwy"])
def test_surfalize_reads_the_same_heights(tmp_path: Path, name: str) -> None:
    """Another program reads the same files, in um, where it is installed."""
    surfalize = pytest.importorskip("surfalize")
    path = (tmp_path / name).with_suffix(Path(name).suffix.lower())
    WRITERS[name](path)
    read = height_grid.read(path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of nodes that are not square
        other = surfalize.Surface.load(path)
    np.testing.assert_allclose(1e-6 * other.data, read.heights, rtol=0, atol=1e-15)
    assert (1e-6 * other.step_y, 1e-6 * other.step_x) == pytest.approx(read.spacing_m)


@pytest.mark.parametrize("xy_unit", ["m", "mm", "um"])
@pytest.mark.parametrize("unit", ["um", "nm"])
def test_triples_may_have_two_units(tmp_path: Path, xy_unit: str, unit: str) -> None:
    """A key says the unit of x and y; without it the slopes are doubted, and the unit is proposed.

    Neighbours differ by about 1 um over 2 um, a tenth of which is a slope as surfaces have it. In a
    unit that is 1000 times too small it is 50.
    """
    sizes = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}
    points = np.array([line.split() for line in triples(1.0).splitlines()], float)
    points[:, :2] /= sizes[xy_unit]
    points[:, 2] /= 10 * sizes[unit]
    path = tmp_path / "h.xyz"
    np.savetxt(path, points)
    right = height_grid.read(path, unit=unit, xy_unit=xy_unit)
    assert right.spacing_m == pytest.approx(STEPS, rel=1e-9)
    np.testing.assert_allclose(right.heights, Z / 10, rtol=0, atol=1e-18)
    assert measured.doubts(path, right) == []
    keys = [f"surface.height_unit={unit}", f"surface.xy_unit={xy_unit}"]
    assert file.loads(TEXT % "h.xyz", keys, folder=tmp_path).spacing == pytest.approx(2e-6)
    if xy_unit == unit:
        return
    if sizes[xy_unit] / sizes[unit] > 1e8:  # steps far below those of atoms
        with pytest.raises(HeightFormatError, match="the key xy_unit says the unit of x and y"):
            height_grid.read(path, unit=unit)
        return
    doubts = measured.doubts(path, height_grid.read(path, unit=unit))
    assert f"{xy_unit} " in str(doubts) and "set surface.xy_unit" in str(doubts)


def test_the_unit_of_x_and_y_goes_with_triples_only(tmp_path: Path) -> None:
    measured.write(tmp_path / "h.x3p", Z, STEPS)
    with pytest.raises(SceneError, match=r"surface.xy_unit: only goes with a text .* not .x3p"):
        file.loads(TEXT % "h.x3p", ["surface.xy_unit=mm"], folder=tmp_path)


@pytest.mark.parametrize("ending", [".npy", ".csv", ".x3p", ".sdf", ".xyz"])
def test_written_heights_are_read_again(tmp_path: Path, ending: str) -> None:
    whole = np.nan_to_num(Z)
    measured.write(tmp_path / f"h{ending}", whole, STEPS)
    np.testing.assert_allclose(height_grid.read(tmp_path / f"h{ending}").heights, whole, atol=1e-21)


def test_masked_heights_are_written_as_unmeasured(tmp_path: Path) -> None:
    masked = np.ma.masked_invalid(Z).copy()
    masked.data[masked.mask] = 7.0
    for name in ("h.npy", "h.xyz", "h.x3p"):
        measured.write(tmp_path / name, masked, STEPS)
        np.testing.assert_allclose(height_grid.read(tmp_path / name).heights, Z, atol=1e-21)


def test_what_cannot_be_written_is_refused(tmp_path: Path) -> None:
    for name, words in {
        "h.sur": "allowed: .npy",
        "h": "no end",
    }.items():
        with pytest.raises(HeightFormatError, match=words):
            measured.write(tmp_path / name, Z, STEPS)
    with pytest.raises(OSError, match="missing"):
        measured.write(tmp_path / "missing" / "h.x3p", Z, STEPS)
    assert not list(tmp_path.iterdir())


def test_a_profile_lies_along_the_track(tmp_path: Path) -> None:
    import x3pio

    x3pio.write(tmp_path / "p.x3p", Z[0], x_scale=2e-6)
    scene = file.loads(TEXT % "p.x3p", ["surface.width_um=40"], folder=tmp_path)
    assert (scene.track.n_along, scene.track.n_across) == (17 - 2, 20)
    assert np.ptp(scene_surface.heights(scene), axis=1).max() == 0


def test_a_channel_is_named(tmp_path: Path) -> None:
    import x3pio

    x3pio.write(tmp_path / "two.x3p", np.stack([Z, 2 * Z]), x_scale=3e-6, y_scale=2e-6)
    path = tmp_path / "two.x3p"
    assert height_grid.read(path).channels == ("layer 1", "layer 2")
    np.testing.assert_array_equal(height_grid.read(path, "layer 2").heights, 2 * Z)
    message = refused(path, "surface.channel=layer 3")
    assert message.endswith('two.x3p: got the channel "layer 3", allowed: "layer 1", "layer 2"')


def refused(path: Path, *overrides: str) -> str:
    """Return the one sentence that refuses a scene with a file."""
    with pytest.raises(SceneError) as error:
        scene_surface.heights(file.loads(TEXT % path.name, overrides, folder=path.parent))
    (text,) = error.value.mistakes
    assert "\n" not in text and len(text) < 400 and "surface." in text
    return text


DAMAGES: dict[str, Callable[[bytes], bytes]] = {
    "empty": lambda content: b"",
    "a tenth": lambda content: content[: len(content) // 10],
    "half": lambda content: content[: len(content) // 2],
    "noise": lambda content: np.random.default_rng(1).bytes(3000),
    "text": lambda content: b"1 2 3\n4 5 6\n",
    "reversed": lambda content: content[::-1],
}


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize("name", ["own.x3p", "OWN.SDF", "ascii.sdf", "um.gwy", "nm.bcrf"])
def test_damaged_files_are_refused_in_one_sentence(tmp_path: Path, name: str, damage: str) -> None:
    path = tmp_path / name
    WRITERS[name](path)
    path.write_bytes(DAMAGES[damage](path.read_bytes()))
    assert f"no readable {path.suffix.lower()} file (" in refused(path)


@pytest.mark.parametrize("name", ["h.sur", "h.al3d", "h.opdx", "h.plu", "h.mnt", "h.tif"])
def test_no_text_reader_takes_over(tmp_path: Path, name: str) -> None:
    """A text without sizes would be read as heights of an unknown spacing."""
    (tmp_path / name).write_text("1 2 3\n4 5 6\n7 8 9\n")
    said = refused(tmp_path / name)
    assert f"no readable {Path(name).suffix} file" in said and "a matrix of numbers" in said


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (
            "0 0 1\n1 0 2\n0 1 3\n1 1 4\n0.4 0.6 5",
            "the point 5 with x = 0.4 lies on no regular grid",
        ),
        ("0 0 1\n1 0 2\n0 0 3", "several points lie on the same node"),
        ("0 0\n1 1", "got 2 numbers on a line, allowed: x, y, z"),
        ("0 0 1\n0.001 5 1\n7 9 1\n1 2 3", "regular grid"),
        ("0 0 1\n0 nan 1", "the point 2 has no place"),
        ("0 0 1\n0 0 1", "several points"),
        ("0 0 1", "got a spacing of 0 m along and 0 m across"),
    ],
)
def test_triples_off_a_grid_are_refused(tmp_path: Path, lines: str, words: str) -> None:
    (tmp_path / "h.xyz").write_text(lines)
    assert words in refused(tmp_path / "h.xyz")


@pytest.mark.parametrize("spacing", ["0.0", "-1.0", "nan", "1e300", "0.9"])
def test_spacings_beyond_reason_are_refused(tmp_path: Path, spacing: str) -> None:
    path = tmp_path / "ascii.sdf"
    ascii_sdf(path)
    text = path.read_text().replace("Xscale = 3.00000000000000e-006", f"Xscale = {spacing}")
    path.write_text(text)
    assert "spacing" in refused(path) or "no readable .sdf file" in refused(path)


def test_packed_and_declared_sizes_are_limited(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A bomb packs a gigabyte into a megabyte; a header may promise more than the file holds."""
    path = tmp_path / "bomb.x3p"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("main.xml", b" " * 2_000_000)
    monkeypatch.setattr(height_grid, "MAX_BYTES", 1_000_000)
    assert "holds 2,000,000 bytes of heights, allowed: 1,000,000" in refused(path)
    monkeypatch.setattr(height_grid, "MAX_BYTES", 1000)
    path = tmp_path / "nm.bcrf"
    crystal(path)
    assert "bytes of heights, allowed: 1,000" in refused(path)


def test_heights_without_a_measured_point_or_with_few_are_refused(tmp_path: Path) -> None:
    for name, z, words in (
        ("none.x3p", np.full((9, 9), np.nan), "81 of 81 heights are not numbers"),
        ("few.x3p", np.where(np.arange(81).reshape(9, 9) > 30, np.nan, 0.0), "allowed: up to 50 %"),
        ("row.x3p", Z[:1], "surface.width_um: missing"),
        ("small.x3p", np.zeros((5, 5)), "allowed: at least 8 each way"),
        ("high.x3p", 1e7 * np.ones((9, 9)), "got a height of 1e7 m"),
    ):
        measured.write(tmp_path / name, z, STEPS[::-1] if name == "row.x3p" else (2e-6, 2e-6))
        assert words in refused(tmp_path / name, "surface.periodic=none")
    measured.write(tmp_path / "gaps.x3p", Z, STEPS)
    assert "2 of 408 heights are not numbers, the first at (3, 11)" in refused(
        tmp_path / "gaps.x3p", "surface.unmeasured=refuse"
    )


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("surface.overlap_um=1000", "surface.overlap_um: got 1000, allowed: 2 to 24"),
        ("surface.l_filter_um=60", "surface.l_filter_um: got 60, allowed: up to 48"),
        ("surface.s_filter_um=1e9", "surface.s_filter_um: got 1000000000, allowed: up to 48"),
        ("surface.height_unit=um", "but a .x3p file holds its own units"),
        ("surface.outliers=2", "surface.outliers: got 2"),
        ("surface.spacing_um=1e-12", "surface.spacing_um: got 1e-12, which makes"),
        ("surface.spacing_um=1e6", "nodes, allowed: at least 8"),
    ],
)
def test_keys_that_do_not_fit_the_file_are_refused(
    tmp_path: Path, setting: str, words: str
) -> None:
    measured.write(tmp_path / "h.x3p", Z, STEPS)
    assert words in refused(tmp_path / "h.x3p", setting)


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ("path: h.npy", "surface.spacing_um: missing; files of arrays"),
        ("path: h.npy, spacing_um: 2, channel: a", "surface.channel: only goes with a file of an"),
        (
            "path: h.npy, spacing_um: 2, overlap_um: 9",
            "surface.overlap_um: only goes with surface.p",
        ),
        ("path: h.sdf, outliers: 6", "surface.outliers: only goes with surface.unmeasured fill"),
        (
            "path: h.sdf, s_filter_um: 9, l_filter_um: 9",
            "surface.s_filter_um: got 9, allowed: less",
        ),
        ("path: h.sdf, along: z", 'surface.along: got "z", allowed: x or y'),
    ],
)
def test_keys_that_do_not_go_together_are_refused_with_their_line(keys: str, words: str) -> None:
    text = TEXT.replace("path: %s, unmeasured: fill", keys)
    with pytest.raises(SceneError) as error:
        file.loads(text, where="scan.yaml")
    assert str(error.value).startswith("scan.yaml:4: ") and words in str(error.value)


def test_a_sphere_with_a_surface_needs_the_spacing_in_the_scene() -> None:
    ball = "sphere: {radius_mm: 5, surface: {kind: smooth, waviness: {9: 0.1}}}"
    with pytest.raises(SceneError, match=r"4: surface.spacing_um: missing; the surface of the sp"):
        file.loads(TEXT.replace("sphere: {radius_mm: 5}", ball) % "h.x3p")


def test_readers_are_imported_when_a_file_asks_for_them(tmp_path: Path) -> None:
    """A missing package is one sentence with the command that installs it."""
    measured.write(tmp_path / "h.x3p", Z, STEPS)
    (tmp_path / "h.sur").write_bytes(b"DIGITAL SURF")
    code = f"""
import sys
from pathlib import Path
import rolling as rc
rc.read_scene("quickstart").check(solve=False)
names = "x3pio", "sdfio", "SurfaceTopography"
assert not [name for name in names if name in sys.modules]
sys.modules.update(dict.fromkeys(names))
from rolling.scene import height_grid
for name in ("h.x3p", "h.sur"):
    try:
        height_grid.read(Path({str(tmp_path)!r}) / name)
    except Exception as error:
        print(error)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    lines = done.stdout.splitlines()
    assert len(lines) == 2 and all("rolling-contact-noise[surfaces]" in line for line in lines)
