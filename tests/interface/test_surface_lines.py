"""Lines of a scene that `rolling surface` offers: each runs and gives what was printed."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from acoustics.arrays import Array
from rolling import cli
from rolling.check import findings
from rolling.figures.topography import parameter_lines
from rolling.in_si import measured, scene_surface
from rolling.in_si.described_file import FileOptions, described_file, offer_of_file
from rolling.in_si.offered_lines import Offer, line, offer_of_statistics
from rolling.in_si.plate_file import scale_limited_file
from rolling.scene.file import loads
from rolling.scene.laws import Roughness
from rolling.scene.scene import Scene
from rolling.surface import made
from rolling.surface.character import character
from rolling.surface.parameters import parameters

SCENE = """\
name: offered
sphere: {radius_mm: 5, material: steel-100cr6}
plate: {material: steel-100cr6}
rolling: {load_n: 0.1, speed_m_s: 0.1%s}
"""
SPACING_UM = 2.0


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Work in a folder of its own, and draw no picture."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("rolling.commands.surface._parameters_and_picture", lambda *_: ([], {}))
    return tmp_path


def waves(shape: tuple[int, int], along_um: float, across_um: float, seed: int = 1) -> Array:
    """Make random heights [um] of Ra 0.3 um with a spectrum that falls beyond both lengths."""
    noise = np.random.default_rng(seed).normal(size=(2 * shape[0], 2 * shape[1]))
    along = np.fft.fftfreq(2 * shape[0], SPACING_UM)[:, None] * along_um
    across = np.fft.rfftfreq(2 * shape[1], SPACING_UM) * across_um
    gain = (1 + 4 * np.pi**2 * (along**2 + across**2)) ** -0.9
    heights = np.fft.irfft2(np.fft.rfft2(noise) * gain, noise.shape)[: shape[0], : shape[1]]
    heights -= heights.mean()
    return np.asarray(0.3 * heights / np.abs(heights).mean())


def ground() -> Array:
    """Return a ground scan [um]: lay across the track, valleys, tilt and form."""
    heights = waves((300, 160), 12.0, 300.0)
    heights = np.where(heights < 0, 1.5 * heights, 0.7 * heights)
    x = SPACING_UM * np.arange(300)[:, None]
    return np.asarray(
        heights + 0.0012 * x - 0.0008 * SPACING_UM * np.arange(160) - (x - x.mean()) ** 2 / 4e6
    )


def with_marks(heights: Array) -> Array:
    """Return heights with marks of unmeasured points, single ones and a patch."""
    marked = heights.copy()
    marked[np.random.default_rng(5).random(heights.shape) < 0.004] = -9999.0
    marked[100:120, 40:60] = -9999.0
    return marked


def scene_with(section: str, duration_s: float | None = None) -> Scene:
    """Return a scene with an offered section `surface`, which a check accepts."""
    length = "" if duration_s is None else f", duration_s: {duration_s}"
    scene = loads(SCENE % length + section, folder=Path())
    findings.check_scene(scene, solve=False)
    return scene


def ra_um(scene: Scene) -> float:
    """Return the arithmetic mean roughness [um] of the surface of a scene."""
    return 1e6 * scene_surface.scene_surface(scene).statistics.ra


def offers_of(path: str, **options: object) -> tuple[Offer, Offer, float]:
    """Return both offers of a file, and the Ra [um] that is printed of it."""
    read = described_file(Path(path), FileOptions(**options))
    numbers = character(read.heights, read.steps, False)
    width = 0.0 if read.heights.shape[1] == 1 else read.heights.shape[1] * read.steps[1]
    random = offer_of_statistics(numbers, min(read.steps), width)
    assert random is not None
    return offer_of_file(Path(path), read.keys), random, 1e6 * numbers.ra


# ---- scans of the command


@pytest.mark.parametrize(
    ("heights", "lengths"),
    [(ground(), "along"), (ground().T, "across"), (with_marks(ground()), "along")],
    ids=["ground", "ground across", "ground with marks"],
)
def test_both_lines_of_a_ground_scan_run_and_give_what_was_printed(
    heights: Array, lengths: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """The file keeps its repairs, and the random surface its lay; blended ends change Ra by 5 %.

    Four seeds scatter by 10 % of the short length and by 25 % of the long one.
    """
    np.savetxt("scan.csv", heights, fmt="%.4f", delimiter=",")
    assert cli.main(["surface", "scan.csv", "--spacing-um", "2", "--height-unit", "um"]) == 0
    said = capsys.readouterr().out
    read = described_file(Path("scan.csv"), FileOptions(spacing_um=2.0, height_unit="um"))
    printed = float(re.search(r"Roughness: Ra (\S+) um", said)[1])
    blended = float(re.search(r"with an Ra of (\S+) um once", said)[1])
    of_file, of_law = (text.strip() for text in said.splitlines() if "surface: {" in text)
    scene = scene_with(of_file)
    assert np.array_equal(scale_limited_file(Path("scan.csv"), scene.surface).heights, read.heights)
    assert float(f"{ra_um(scene):.3g}") == blended == pytest.approx(printed, rel=0.07)
    short_um = float(re.search(rf"1/e after (\S+) um {lengths} the track, and not", said)[1])
    offered = scene_with(of_law, duration_s=0.008)
    by_axis = dict(zip(("along", "across"), offered.surface.lengths_um, strict=True))
    assert by_axis.pop(lengths) == pytest.approx(short_um, rel=0.15)  # of another law
    (long_um,) = by_axis.values()
    assert 160 < long_um <= 320  # between half the side of the scan and all of it
    seeds = [offered.with_({"surface.seed": seed}) for seed in range(4)]
    assert np.mean([ra_um(scene) for scene in seeds]) == pytest.approx(printed, rel=2e-3)
    measured_um = []
    for scene in seeds:
        surface = scene_surface.scene_surface(scene)
        numbers = character(surface.heights, np.full(2, surface.spacing), True)
        measured_um.append((1e6 * numbers.along, 1e6 * numbers.across))
    expected = (short_um, long_um) if lengths == "along" else (long_um, short_um)
    assert np.nanmean(measured_um, axis=0) == pytest.approx(expected, rel=0.3)


def test_marks_are_repaired_in_the_numbers_and_in_the_line(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Ra is that of the scan without marks, as an engineer would have it."""
    np.savetxt("clean.csv", ground(), fmt="%.4f", delimiter=",")
    np.savetxt("marked.csv", with_marks(ground()), fmt="%.4f", delimiter=",")
    options = {"spacing_um": 2.0, "height_unit": "um"}
    _, _, clean = offers_of("clean.csv", **options)
    of_file, _, marked = offers_of("marked.csv", **options)
    assert marked == pytest.approx(clean, rel=0.01)
    surface = scene_with(of_file.line).surface
    assert (surface.outliers, surface.unmeasured, surface.height_unit) == (6, "fill", "um")


def test_a_turned_file_is_the_other_one(capsys: pytest.CaptureFixture[str]) -> None:
    """A lay along the track is told, and --along x is the axis of the description and the line."""
    np.savetxt("lying.csv", ground().T, fmt="%.4f", delimiter=",")
    np.savetxt("standing.csv", ground(), fmt="%.4f", delimiter=",")
    words = ["--spacing-um", "2", "--height-unit", "um"]
    assert cli.main(["surface", "lying.csv", *words]) == 0
    assert "add --along x" in capsys.readouterr().out
    assert cli.main(["surface", "lying.csv", "--along", "x", *words]) == 0
    turned = capsys.readouterr().out
    assert cli.main(["surface", "standing.csv", *words]) == 0
    expected = capsys.readouterr().out
    standing = turned.replace("lying", "standing").replace("along: x, ", "")
    assert standing.replace("along x of", "along y of") == expected
    (of_file,) = [text for text in turned.splitlines() if "kind: file" in text]
    assert scene_with(of_file.strip()).surface.along == "x"


# ---- other scans


SPACED = {"spacing_um": SPACING_UM}


@pytest.mark.parametrize(
    ("name", "heights", "factor", "options"),
    [
        ("isotropic in nm.npy", waves((200, 90), 10, 10), 1e3, {"height_unit": "nm", **SPACED}),
        ("in metres.csv", waves((90, 200), 8, 16), 1e-6, SPACED),
        ("scan, 1.txt", waves((200, 1), 10, 10), 1.0, {"height_unit": "um", **SPACED}),
        ("row.txt", waves((1, 200), 10, 10), 1.0, {"height_unit": "um", **SPACED}),
        ("long.npy", waves((400, 40), 10, 25), 1e-3, {"height_unit": "mm", **SPACED}),
        (
            "turned.npy",
            waves((60, 200), 25, 10),
            1.0,
            {"height_unit": "um", "along": "x", **SPACED},
        ),
    ],
)
def test_lines_of_other_scans_run_and_give_their_ra(
    name: str, heights: Array, factor: float, options: dict[str, object]
) -> None:
    """Blended ends of small scans change Ra by up to 12 %, which the sentence of the line says."""
    if name.endswith("npy"):
        np.save(name, factor * heights)
    else:
        np.savetxt(name, factor * heights, delimiter=",")
    of_file, of_law, printed = offers_of(name, **options)
    assert printed == pytest.approx(0.3, rel=0.05)  # less the plane of random waves
    ra = ra_um(scene_with(of_file.line))
    assert f"with an Ra of {ra:.3g} um" in of_file.sentence
    assert ra == pytest.approx(printed, rel=0.12)
    scene = scene_with(of_law.line, duration_s=0.005)
    assert ra_um(scene) == pytest.approx(printed, rel=1e-3)


def test_a_measurement_of_other_spacings_across_keeps_its_width() -> None:
    """The nodes of a random surface are as fine as the finer ones, over the width of the file."""
    measured.write(Path("scan.xyz"), 1e-6 * waves((200, 90), 10, 10), (1e-6, 2e-6))
    of_file, of_law, printed = offers_of("scan.xyz")
    law = scene_with(of_law.line, duration_s=0.005).surface
    assert (law.spacing_um, law.width_um) == (1.0, 180.0)
    assert ra_um(scene_with(of_file.line)) == pytest.approx(printed, rel=0.12)


def test_a_turned_lay_keeps_its_angle_and_both_lengths() -> None:
    """The axes cut a lay at 30 degrees in other lengths than its own."""
    law = Roughness(
        roughness_ra_um=0.3,
        correlation_length_um=10,
        correlation_length_across_um=50,
        lay_deg=30,
        seed=3,
    )
    np.save("turned.npy", made.of_law((300, 300), 2e-6, law.in_si, 3))
    _, of_law, _ = offers_of("turned.npy", **SPACED)
    offered = scene_with(of_law.line, duration_s=0.005).surface
    assert offered.lay_deg == pytest.approx(30, abs=3)
    lengths = (offered.correlation_length_um, offered.correlation_length_across_um)
    assert lengths == pytest.approx((10, 50), rel=0.2)


def test_a_file_that_no_scene_takes_has_a_reason_in_place_of_a_line() -> None:
    """Five lines side by side are no surface, and grooves along both axes have no length."""
    np.save("five.npy", 1e-6 * waves((100, 5), 10, 10))
    of_file, of_law, _ = offers_of("five.npy", **SPACED)
    assert not of_file.line and "at least 8 each way" in of_file.sentence
    assert scene_with(of_law.line, duration_s=0.005)
    np.save("bowl.npy", 1e-9 * np.add.outer(np.arange(60.0) ** 2, np.arange(60.0)))
    numbers = character(np.load("bowl.npy"), np.full(2, 2e-6), False)
    flat = offer_of_statistics(numbers._replace(rq=0.0), 2e-6, 1e-4)
    unknown = offer_of_statistics(numbers._replace(ellipse=None, decay=None), 2e-6, 1e-4)
    assert flat is None and unknown is not None and not unknown.line


@pytest.mark.parametrize("text", ["12", "true", "1e5", "a: b", "it's", "# 1", " x", "Ä", "y"])
def test_any_name_in_a_line_is_read_back_as_it_is(text: str) -> None:
    section = line({"kind": "file", "path": "scan.x3p", "channel": text, "unmeasured": "fill"})
    assert f"channel: {text}" in section or "'" in section
    from ruamel.yaml import YAML

    assert YAML(typ="safe").load(section)["surface"]["channel"] == text


# ---- the chain of the preparation


@pytest.mark.parametrize("form_um", [0.0, 3.0])
@pytest.mark.parametrize("marks", [None, -9999.0, 0.0])
def test_the_command_says_the_same_of_a_file_and_of_the_scene_with_its_line(
    form_um: float,
    marks: float | None,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Form and certain marks are repaired by the line itself; doubtful marks are told."""
    monkeypatch.setattr("rolling.commands.surface._parameters_and_picture", lines_alone)
    heights = waves((120, 90), 8.0, 16.0) + form_um * np.linspace(-1, 1, 120)[:, None] ** 2
    if marks is not None:
        heights[np.random.default_rng(5).random(heights.shape) < 0.004] = marks
        heights += 4.0 * (marks == 0.0) * (heights != 0.0)
    np.savetxt("scan.csv", heights, fmt="%.4f", delimiter=",")
    assert cli.main(["surface", "scan.csv", "--spacing-um", "2", "--height-unit", "um"]) == 0
    of_file = capsys.readouterr()
    (line_of_file,) = [text.strip() for text in of_file.out.splitlines() if "kind: file" in text]
    assert ("level: cylinder" in line_of_file) == (form_um > 0)
    assert ("outliers: 6" in line_of_file) == (marks == -9999.0)
    assert ("they count as heights here" in of_file.err) == (marks == 0.0)
    Path("own.yaml").write_text(SCENE % "" + line_of_file + "\n")
    assert cli.main(["surface", "own.yaml"]) == 0
    of_scene = capsys.readouterr().out
    names = ("Roughness", "The autocorrelation", "Sa ", "Sal ", "Str ", "Sdq ")
    for name in names:
        both = [
            next(text for text in said.splitlines() if text.startswith(name))
            for said in (of_file.out, of_scene)
        ]
        assert both[0] == both[1]


def lines_alone(described: Any, source: str) -> tuple[list[str], dict[str, bytes]]:
    """Return the lines of the parameters, and draw nothing."""
    return parameter_lines(
        parameters(described.heights, described.steps, described.is_periodic)
    ), {}
