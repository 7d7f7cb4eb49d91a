"""The command `surface`: what it prints and writes of files and scenes, and what it refuses."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from rolling import cli, read_scene
from rolling.commands.replaced import source_name
from rolling.figures.picture import Picture
from rolling.in_si import measured, plate_file, scene_surface
from rolling.in_si.offered_lines import pair_of_scene
from rolling.scene.file import loads
from rolling.scene.scene import Scene
from rolling.scene.surfaces import HeightFile
from rolling.surface.character import character, plasticity_index
from rolling.surface.parameters import NAMES, parameters

SCENE = """\
name: plate
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3}
surface: {kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10, spacing_um: 2, \
width_um: 200, seed: 3}
rolling: {load_n: 1, speed_m_s: 0.1, duration_s: 0.004}
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Work in a folder of its own with a scene and a tilted measurement with a gap."""
    monkeypatch.chdir(tmp_path)
    Path("plate.yaml").write_text(SCENE)
    heights = 1e-7 * np.random.default_rng(1).standard_normal((40, 30))
    heights += np.add.outer(1e-6 * np.arange(40), 3e-6 * np.arange(30))
    heights[5, 6] = np.nan
    measured.write(Path("scan.xyz"), heights, (1e-6, 2e-6))
    return tmp_path


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Write dots in place of pictures, which take longer than all that the command prints."""
    file = Picture.file

    def dot(picture: Picture, form: str, facts: Mapping[str, str] | None = None) -> bytes | None:
        return png(facts["Source"]) if form == "png" and facts else file(picture, form)

    monkeypatch.setattr(Picture, "file", dot)


def table(path: str) -> dict[str, float]:
    """Return the values of a table of parameters."""
    rows = pd.read_csv(path)
    return dict(zip(rows["parameter"], rows["value"], strict=True))


def test_the_parameters_of_a_file_are_printed_and_written(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """They are the numbers of the prepared scan on its own nodes, to the nine digits of a CSV."""
    assert cli.main(["surface", "scan.xyz"]) == 0
    said = capsys.readouterr().out
    line = HeightFile(path="scan.xyz", unmeasured="fill")
    prepared = plate_file.scale_limited_file(Path("scan.xyz"), line)
    direct = parameters(prepared.heights, prepared.steps)
    written = table("outputs/scan.xyz-surface/surface.csv")
    assert [*written] == [*NAMES]
    for name, value in direct.items():
        assert written[name] == pytest.approx(value, rel=1e-8, nan_ok=True)
        assert f"\n{name} " in said
    assert 0.9e-7 < direct["Sq"] < 1.1e-7  # the noise without the plane of 90 um
    assert "40 x 30 nodes of 1.0 x 2.0 um, prepared as below, 1 unmeasured" in said
    for name in ("surface.png", "preparation.png"):
        assert Path(f"outputs/scan.xyz-surface/{name}").read_bytes().startswith(b"\x89PNG")


@pytest.mark.usefixtures("undrawn")
def test_an_aspect_ratio_that_half_the_surface_leaves_open_is_a_bound(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Grooves that are longer than the file say so on the terminal and in the table."""
    grooves = 1e-7 * np.random.default_rng(2).standard_normal(40)
    np.save("grooves.npy", np.tile(grooves, (60, 1)))
    assert cli.main(["surface", "grooves.npy", "--spacing-um", "2"]) == 0
    assert "upper bound" in capsys.readouterr().out
    rows = pd.read_csv("outputs/grooves.npy-surface/surface.csv").set_index("parameter")
    assert "upper bound" in rows["meaning"]["Str"]


@pytest.mark.usefixtures("undrawn")
def test_a_measurement_and_an_earlier_surface_are_not_replaced(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The table of a surface is a surface.csv too, and equal names lead to one folder."""
    heights = np.random.default_rng(0).normal(size=(16, 16)) * 1e-7
    np.savetxt("surface.csv", heights, delimiter=",")
    before = Path("surface.csv").read_bytes()
    assert cli.main(["surface", "surface.csv", "--spacing-um", "2", "--out", "."]) == 2
    assert "surface.csv: exists; take another folder" in capsys.readouterr().err
    assert Path("surface.csv").read_bytes() == before and not Path("surface.png").exists()
    for name, factor in (("a", 1), ("b", 2), ("a", 1)):
        Path(name).mkdir(exist_ok=True)
        np.save(f"{name}/scan.npy", factor * heights)
        code = cli.main(["surface", f"{name}/scan.npy", "--spacing-um", "2"])
        assert code == (2 if name == "b" else 0)


def test_the_same_source_described_otherwise_replaces_its_files(tmp_path: Path) -> None:
    """The option that the command advised changes the numbers, and both files are made anew."""
    x, y = np.meshgrid(2e-3 * np.arange(30), 2e-3 * np.arange(20))
    heights = 0.1 * np.random.default_rng(1).standard_normal(x.size)
    np.savetxt("two.xyz", np.column_stack([x.ravel(), y.ravel(), heights]))
    files = [Path("outputs/two.xyz-surface") / name for name in ("surface.csv", "surface.png")]
    assert cli.main(["surface", "two.xyz", "--height-unit", "um", "-q"]) == 0
    first = [path.read_bytes() for path in files]
    words = ["--height-unit", "um", "--xy-unit", "mm", "-q"]
    assert cli.main(["surface", "two.xyz", *words]) == 0
    second = [path.read_bytes() for path in files]
    assert all(old != new for old, new in zip(first, second, strict=True))
    absolute = source_name(tmp_path / "two.xyz", files[0].parent)
    assert absolute == source_name(Path("two.xyz"), files[0].parent) == "../../two.xyz"


@pytest.mark.parametrize(
    "change",
    [
        lambda table, picture: (b"parameter,value,unit,meaning\n", picture),
        lambda table, picture: (table.replace(b",source", b",source,mine"), picture),
        lambda table, picture: (table.replace(b"two.npy", b"other.npy"), picture),
        lambda table, picture: (b"1,2,3\n4,5,6\n", picture),
        lambda table, picture: (b"\xff\x00", picture),
        lambda table, picture: (table, picture.replace(b"two.npy", b"six.npy")),
        lambda table, picture: (table, picture[:40]),
        lambda table, picture: (table, b"no picture"),
    ],
)
def test_files_that_do_not_name_program_and_source_are_kept(
    change: Callable[[bytes, bytes], tuple[bytes, bytes]],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The table of an earlier version, of another source or of a person stays as it is."""

    def both(described: object, source: str) -> tuple[list[str], dict[str, bytes]]:
        table = f"parameter,value,unit,meaning,source\nSa,1,m,height,{source}\n".encode()
        return [], {"surface.csv": table, "surface.png": png(source)}

    monkeypatch.setattr("rolling.commands.surface._parameters_and_picture", both)
    np.save("two.npy", np.zeros((9, 9)))
    words = ["surface", "two.npy", "--spacing-um", "1", "--out", "here", "-q"]
    assert cli.main(words) == cli.main(words) == 0
    content = change(Path("here/surface.csv").read_bytes(), Path("here/surface.png").read_bytes())
    Path("here/surface.csv").write_bytes(content[0])
    Path("here/surface.png").write_bytes(content[1])
    assert cli.main(words) == 2
    assert ": exists; take another folder" in capsys.readouterr().err
    assert Path("here/surface.csv").read_bytes() == content[0]
    assert Path("here/surface.png").read_bytes() == content[1]


def png(source: str) -> bytes:
    """Return a picture of one point that names the program and a source."""
    facts = PngInfo()
    facts.add_text("Software", "rolling-contact-noise")
    facts.add_text("Source", source)
    stream = io.BytesIO()
    Image.new("L", (1, 1)).save(stream, "png", pnginfo=facts)
    return stream.getvalue()


@pytest.mark.usefixtures("undrawn")
def test_the_surface_of_a_scene_is_described_and_saved(capsys: pytest.CaptureFixture[str]) -> None:
    """A saved surface is the one that runs roll over, and as a file it has the same roughness."""
    words = ["surface", "plate.yaml", "--set", "surface.seed=4", "--save", "saved.npy"]
    assert cli.main([*words, "--out", "here", "-q"]) == 0
    assert capsys.readouterr().out == "here\n"
    scene = read_scene("plate.yaml", ["surface.seed=4"])
    saved = np.load("saved.npy")
    assert np.array_equal(saved, scene_surface.heights(scene))
    assert table("here/surface.csv")["Sa"] == pytest.approx(1e-7, rel=1e-9)
    assert cli.main(["surface", "saved.npy", "--spacing-um", "2", "--out", "again", "-q"]) == 0
    first = table("here/surface.csv")
    again = table("again/surface.csv")
    for name in ("Sq", "Sdq", "Sk", "Sal"):
        assert again[name] == pytest.approx(first[name], rel=0.05)


def pasted(said: str, number: int) -> Scene:
    """Return the scene with a line of YAML that the command printed."""
    lines = [line.strip() for line in said.splitlines() if line.startswith("  surface: {")]
    text = "".join(line for line in SCENE.splitlines(True) if not line.startswith("surface"))
    text = text.replace("width_um: 200, seed: 3}\n", "")
    return loads(text + lines[number] + "\n")


@pytest.mark.usefixtures("undrawn")
def test_the_line_for_a_scene_makes_a_surface_of_the_same_numbers(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Ra is equal, and the 1/e lengths scatter by some per cent over a surface of 400 um."""
    words = ["plate.yaml", "--set", "surface.correlation_length_across_um=20", "--out", "a"]
    assert cli.main(["surface", *words]) == 0
    scene = pasted(capsys.readouterr().out, 0)
    made = scene_surface.heights(scene)
    numbers = character(made, np.full(2, scene.spacing), True)
    assert numbers.ra == pytest.approx(1e-7, rel=1e-3)
    assert numbers.along == pytest.approx(10e-6, rel=0.2)
    assert numbers.across == pytest.approx(20e-6, rel=0.2)


@pytest.mark.usefixtures("undrawn")
def test_the_lines_for_a_scene_name_a_file_or_make_one_like_it(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """An array needs its spacing and unit, a measurement with a gap is filled in and blended."""
    heights = 0.1 * scene_surface.heights(read_scene("plate.yaml")) * 1e6
    np.save("scan of a.npy", heights[:, :150])
    words = ["scan of a.npy", "--spacing-um", "2", "--height-unit", "um"]
    assert cli.main(["surface", *words]) == 0
    said = capsys.readouterr().out
    assert np.std(scene_surface.heights(pasted(said, 0))) == pytest.approx(1.25e-8, rel=0.05)
    assert np.std(scene_surface.heights(pasted(said, 1))) == pytest.approx(1.25e-8, rel=0.05)
    assert cli.main(["surface", "scan.xyz"]) == 0
    surface = pasted(capsys.readouterr().out, 0).surface
    assert surface.unmeasured == "fill" and surface.made_periodic == "blend"


@pytest.mark.usefixtures("undrawn")
def test_a_profile_and_grooves_say_which_length_is_unknown(
    capsys: pytest.CaptureFixture[str],
) -> None:
    rows = 1e-7 * np.random.default_rng(2).standard_normal(400)
    np.savetxt("profile.txt", rows)
    assert cli.main(["surface", "profile.txt", "--spacing-um", "2"]) == 0
    said = capsys.readouterr().out
    assert "not across it" in said
    assert pasted(said, 0).surface.width_um == 256
    np.save("grooves.npy", np.tile(rows[:60], (60, 1)))
    assert cli.main(["surface", "grooves.npy", "--spacing-um", "2"]) == 0
    assert "not along it" in capsys.readouterr().out
    np.save("level.npy", np.zeros((20, 20)))
    assert cli.main(["surface", "level.npy", "--spacing-um", "2"]) == 0
    assert "is smooth" in capsys.readouterr().out


@pytest.mark.law("Plasticity: the index E' s/H of a cosine is its rms slope, in any direction.")
def test_the_plasticity_index_of_a_cosine_is_a_closed_form() -> None:
    """Neighbouring nodes see the slope sqrt(2) pi A/L up to (pi/200)^2/6, 4e-5."""
    amplitude = 1e-7
    length = 200e-6
    wave = amplitude * np.cos(2 * np.pi * np.arange(200) / 200)
    slope = np.sqrt(2) * np.pi * amplitude / length
    for heights in (np.tile(wave[:, None], (1, 16)), np.tile(wave, (16, 1))):
        numbers = character(heights, np.full(2, 1e-6), True)
        index = plasticity_index(numbers.rms_slope, 115e9, 7.9e9)
        assert index == pytest.approx(slope * 115e9 / 7.9e9, rel=1e-4)
        # The autocorrelation of a cosine is a cosine.
        expected = np.arccos(np.exp(-1)) / (2 * np.pi) * length
        lag = max(x for x in (numbers.along, numbers.across) if np.isfinite(x))
        assert lag == pytest.approx(expected, rel=1e-3)


def test_the_index_ranks_finishes_that_never_yield() -> None:
    """Half the height is half the index, with the hardness of the material of an elastic plate."""
    scene = read_scene("plate.yaml")
    pair = pair_of_scene(scene)
    assert np.isfinite(pair.hardness) and "steel-100cr6" in pair.words
    glass = pair_of_scene(scene.with_({"plate.material": "glass", "plate.hardness_gpa": "none"}))
    assert glass.hardness == 6e9
    heights = scene_surface.heights(scene)
    steps = np.full(2, scene.spacing)
    high, low = (character(factor * heights, steps, True).rms_slope for factor in (1.0, 0.5))
    assert low == pytest.approx(high / 2, rel=1e-12)


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["nowhere.x3p"], "nowhere.x3p: no such file"),
        (["scan.xyz", "--spacing-um", "1"], "the file holds its own spacing"),
        (["scan.xyz", "--set", "surface.seed=1"], "--set: only goes with a scene"),
        (["scan.xyz", "--save", "scan.xyz"], "scan.xyz: exists"),
        (["scan.xyz", "--out", "plate.yaml"], "plate.yaml: exists"),
        (["scan.xyz", "--save", "saved.doc"], "--save saved.doc: got the ending .doc"),
        (["scan.xyz", "--save", "none/z.npy"], "--save none/z.npy: no such folder"),
        (["plate.yaml", "--spacing-um", "1"], "only for a file of heights"),
        (["plate.yaml", "--set", "surface.sed=1"], "nearest: surface.seed"),
        (["flat.npy", "--spacing-um", "1", "--xy-unit", "mm"], "--xy-unit: only goes with a text"),
        (["flat.npy"], "--spacing-um: missing"),
        (["gaps.npy", "--spacing-um", "1"], "holds no heights"),
        (["metres.npy", "--spacing-um", "1"], "--height-unit: Ra would be more than 0.001 m"),
    ],
)
def test_bad_input_is_one_message_and_writes_nothing(
    words: list[str], reason: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    np.save("flat.npy", np.zeros((9, 9)))
    np.save("gaps.npy", np.full((9, 9), np.nan))
    np.save("metres.npy", np.random.default_rng(1).standard_normal((9, 9)))
    before = sorted(folder.rglob("*"))
    assert cli.main(["surface", *words, "-q"]) == 2
    message = capsys.readouterr().err
    assert reason in message and message.count("\n") == 1
    assert sorted(folder.rglob("*")) == before


@pytest.mark.parametrize(
    "heights",
    [
        np.zeros((1, 1)),
        np.full((9, 12), 0.1),
        np.random.default_rng(1).standard_normal((200, 1)) * 1e-7,
        np.where(np.arange(6000).reshape(60, 100) % 977 == 0, 1e-4, 0.0),
        np.random.default_rng(1).standard_cauchy((30, 900)) * 1e-9,
    ],
    ids=["one node", "flat", "profile", "spikes", "heavy tails"],
)
@pytest.mark.filterwarnings("error")
def test_any_surface_has_its_picture(heights: np.ndarray) -> None:
    np.save("odd.npy", heights)
    assert cli.main(["surface", "odd.npy", "--spacing-um", "1", "-q"]) == 0
    assert len(pd.read_csv("outputs/odd.npy-surface/surface.csv")) == len(NAMES)


@pytest.mark.usefixtures("undrawn")
def test_a_swept_surface_is_described_without_its_sweep(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """A sweep of the load leaves the surface as it is, so nothing is said of it."""
    for sweep, is_said in (("{surface.seed: [1, 2]}", True), ("{rolling.load_n: [1, 2]}", False)):
        Path("swept.yaml").write_text(f"{SCENE}sweep: {sweep}\n")
        assert cli.main(["surface", "swept.yaml"]) == 0
        assert ("without its sweep" in capsys.readouterr().err) == is_said


@pytest.mark.usefixtures("undrawn")
def test_a_mark_of_unmeasured_points_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    """The parameters are printed, with the value that spoils them and the way out."""
    heights = 0.1 * np.random.default_rng(1).standard_normal((40, 30))
    heights[5:7, 6:9] = -9999
    np.savetxt("scan.csv", heights)
    words = ["--spacing-um", "1", "--height-unit", "um"]
    assert cli.main(["surface", "scan.csv", *words]) == 0
    said = capsys.readouterr().err
    assert "6 of 1200 heights are exactly -9999 um" in said and "surface.outliers" in said
    heights[5:7, 6:9] = 1e37
    np.savetxt("scan.csv", heights)
    assert cli.main(["surface", "scan.csv", *words]) == 0
    said = capsys.readouterr()
    assert "6 of 1200 heights are exactly 1e+37 um" in said.err
    assert "6 unmeasured" in said.out
    ra_um = float(re.search(r"Ra (\S+) um", said.out)[1])
    assert ra_um == pytest.approx(0.0789, rel=0.01)  # as without marks


@pytest.mark.usefixtures("undrawn")
def test_triples_of_two_units_have_the_spacing_that_is_meant(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """With x and y in mm and z in um the spacing of 2 nm is doubted, and the option named."""
    x, y = np.meshgrid(2e-3 * np.arange(30), 2e-3 * np.arange(20))
    heights = 0.1 * np.random.default_rng(1).standard_normal(x.size)
    np.savetxt("two.xyz", np.column_stack([x.ravel(), y.ravel(), heights]))
    assert cli.main(["surface", "two.xyz", "--height-unit", "um", "--out", "a"]) == 0
    assert "set --xy-unit mm" in capsys.readouterr().err
    words = ["--height-unit", "um", "--xy-unit", "mm", "--out", "b"]
    assert cli.main(["surface", "two.xyz", *words]) == 0
    said = capsys.readouterr()
    assert "nodes of 2.0 x 2.0 um" in said.out and "warning" not in said.err
