"""Filters, forms and lay of a scan: what `rolling surface` decides, says and refuses."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from rolling import HeightFile, SceneError, cli
from rolling.ball_kinds.ball_conditions import preparation_words
from rolling.in_si import chosen_filters, measured, scene_surface
from rolling.in_si.described_file import FileOptions, described_file, offer_of_file
from rolling.in_si.offered_lines import line
from rolling.in_si.plate_file import scale_limited_file
from rolling.kinds.stated_conditions import conditions_of
from rolling.scene.file import loads
from rolling.surface.instrument import with_law
from rolling.terminal.whole_files import FolderError

SCENE = """\
name: scan
sphere: {radius_mm: 5, material: steel-100cr6}
plate: {material: steel-100cr6}
rolling: {load_n: 0.1, speed_m_s: 0.1, distance_mm: 0.1}
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def waves(seed: int = 1, across: float = 3.0) -> np.ndarray:
    """Return random heights [m] of Sq 0.1 um, 96 x 80 nodes."""
    white = np.random.default_rng(seed).normal(size=(192, 160))
    wave = np.hypot(3.0 * np.fft.fftfreq(192)[:, None], across * np.fft.rfftfreq(160))
    z = np.fft.irfft2(np.fft.rfft2(white) / (1 + (6 * wave) ** 2), white.shape)[:96, :80]
    return np.asarray(1e-7 * (z - z.mean()) / z.std())


def steps_of(name: str, **options: object) -> tuple[dict[str, str], dict[str, object]]:
    """Return the reasons of the chain of a file by its steps, and the keys of its line."""
    read = described_file(Path(name), FileOptions(spacing_um=1.0, **options))  # type: ignore[arg-type]
    offer = offer_of_file(Path(name), read.keys)
    scene = loads(SCENE + offer.line + "\n", folder=Path())
    assert np.array_equal(scale_limited_file(Path(name), scene.surface).heights, read.heights)
    return {step.name: f"{step.effect}; {step.reason}" for step in read.chain}, read.keys


def test_the_s_filter_takes_what_the_instrument_does_not_show() -> None:
    """Half of the lateral period limit is stated, and the index is the limit itself."""
    np.save("scan.npy", waves())
    steps, keys = steps_of("scan.npy")
    assert "s_filter_um" not in keys and "no waves below 2 um" in steps["S-filter"]
    steps, keys = steps_of("scan.npy", sampling_um=3.0)
    assert keys["s_filter_um"] == 6.0 and keys["instrument"] == {"sampling_um": 3.0}
    assert "no waves below 6 um (two sampling intervals)" in steps["S-filter"]
    steps, keys = steps_of("scan.npy", noise_nm=500.0)
    assert "s_filter_um" not in keys and "as large as the heights" in steps["S-filter"]


def test_an_s_filter_hides_nothing_of_the_instrument() -> None:
    """Noise and limits are those of the scan before the filter, and the law gives waves back."""
    np.save("scan.npy", waves())
    keys = {"path": "scan.npy", "spacing_um": 1, "periodic": "blend"}
    keys["instrument"] = {"sampling_um": 3, "noise_nm": 5}
    plain = loads(SCENE + line({"kind": "file", **keys}), folder=Path())
    filtered = plain.with_({"surface.s_filter_um": 6})
    of_plain, of_filtered = (scene_surface.scene_surface(one) for one in (plain, filtered))
    assert of_plain.seen is not None and of_filtered.seen is not None
    assert of_filtered.seen.cutoff == of_plain.seen.cutoff
    assert of_filtered.seen.noise == of_plain.seen.noise > 0
    restored = with_law(of_filtered.heights, 1e-6, of_filtered.seen, (1,))
    wanted = with_law(of_plain.heights, 1e-6, of_plain.seen, (1,))
    assert np.std(of_filtered.heights - of_plain.heights) > 4 * np.std(restored - wanted)


def test_the_l_filter_is_robust_where_pits_would_pull_it() -> None:
    np.save("scan.npy", waves())
    pitted = waves()
    for row, column in np.random.default_rng(3).integers(4, 70, (12, 2)):
        pitted[row : row + 5, column : column + 5] -= 2e-6
    np.save("pitted.npy", pitted)
    steps, keys = steps_of("scan.npy", l_filter_um=30.0)
    assert keys["l_filter_um"] == 30 and "l_filter" not in keys
    assert "Gaussian, nesting index 0.03 mm" in steps["L-filter"]
    steps, keys = steps_of("pitted.npy", l_filter_um=30.0)
    assert keys["l_filter"] == "robust" and "robust Gaussian" in steps["L-filter"]
    half = waves()
    half[:, :38] = np.nan
    np.save("half.npy", half)
    assert "l_filter" not in steps_of("half.npy", l_filter_um=30.0)[1]
    steps, keys = steps_of("pitted.npy")
    assert "l_filter_um" not in keys and "ISO 21920-3 has" in steps["L-filter"]
    for index_um in (1.5, 90.0):
        with pytest.raises(FolderError, match=r"--l-filter-um: got \S+, allowed: 2, .* to 80"):
            steps_of("scan.npy", l_filter_um=index_um)


def test_the_track_is_said_to_lie_across_or_along_a_lay() -> None:
    laid = waves(across=200.0)
    np.save("laid.npy", laid)
    np.save("turned.npy", np.ascontiguousarray(laid.T))
    np.save("even.npy", waves(2))
    assert "across the lay" in steps_of("laid.npy")[0]["direction"]
    assert "which is along the lay; --along turns it" in steps_of("turned.npy")[0]["direction"]
    assert "runs along x of" in steps_of("turned.npy", along="x")[0]["direction"]
    assert "there is no lay" in steps_of("even.npy")[0]["direction"]


def test_a_scene_with_a_scan_says_its_steps_and_the_lay(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rolling.commands.surface._parameters_and_picture", lambda *_: ([], {}))
    np.save("laid.npy", waves(across=200.0))
    section = {"kind": "file", "path": "laid.npy", "spacing_um": 1, "periodic": "blend"}
    Path("own.yaml").write_text(SCENE + line(section | {"level": "cylinder", "l_filter_um": 40}))
    assert cli.main(["surface", "own.yaml"]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "F-operation: cylinder, " in told and "L-filter: Gaussian, nesting index" in told
    assert "S-filter: none; by the scene" in told and "across the lay" in told


def test_nodes_that_are_not_square_keep_the_round_form() -> None:
    """A cylinder of 4 mm on nodes of 1 x 2.5 um leaves its roughness, in the file and the line."""
    y = 2.5e-6 * (np.arange(80) - 40)
    measured.write(Path("roller.xyz"), waves() - np.sqrt(4e-3**2 - y**2), (1e-6, 2.5e-6))
    read = described_file(Path("roller.xyz"), FileOptions())
    assert read.keys["level"] == "cylinder"
    assert np.std(read.heights) == pytest.approx(1e-7, rel=0.02)
    (step,) = [step for step in read.chain if step.name == "F-operation"]
    radius_mm = float(re.search(r"hollow, radius (\S+) mm", step.effect)[1])
    assert radius_mm == pytest.approx(4.0, rel=0.05)  # as the roughness bends by chance
    ball = scene_surface.scene_surface(
        loads(SCENE + offer_of_file(Path("roller.xyz"), read.keys).line + "\n", folder=Path())
    )
    assert np.std(ball.heights) == pytest.approx(1e-7, rel=0.06)


ROWS = np.arange(96)[:, None] * np.ones(80)


@pytest.mark.parametrize(
    "heights",
    [
        np.where((ROWS > 40) & (ROWS < 44), np.nan, waves()),
        waves() + 1e3,
        np.where(ROWS * 80 + np.arange(80) == 3000, -1e-6, 0.0),
        1e-5 * waves(),
        1e-293 * waves(),
        np.full((96, 80), 0.2),
        waves()[:3, :3],
        waves()[:12, :9],
    ],
    ids=["rows", "offset", "pit", "1e-12", "1e-300", "flat", "3 x 3", "few"],
)
@pytest.mark.filterwarnings("error")
def test_odd_scans_have_an_answer(heights: np.ndarray) -> None:
    """With and without an instrument a chain or a reason stands, and heights are finite."""
    np.save("odd.npy", heights)
    for options in ({}, {"tip_radius_um": 5.0, "noise_nm": 1.0}):
        read = described_file(Path("odd.npy"), FileOptions(spacing_um=1.0, **options))
        assert read.chain or "No scene rolls" in offer_of_file(Path("odd.npy"), read.keys).sentence
        if read.chain:
            assert np.isfinite(read.heights).all()


@pytest.mark.parametrize(
    ("keys", "reason"),
    [
        ({"level": "cilinder"}, "nearest: cylinder"),
        ({"level": "polynomial-12"}, "polynomial-8"),
        ({"l_filter": "robust"}, "only goes with surface.l_filter_um"),
        ({"l_filter": "gauss", "l_filter_um": 30}, "gaussian"),
    ],
)
def test_forms_and_filters_that_do_not_exist_are_refused(
    keys: dict[str, object], reason: str
) -> None:
    with pytest.raises((SceneError, ValueError), match=reason):
        loads(f"{SCENE}surface: {{kind: file, path: scan.csv}}\n", folder=Path()).with_(
            {f"surface.{name}": value for name, value in keys.items()}
        )


def test_the_conditions_name_every_step_after_its_standard() -> None:
    words = preparation_words(
        HeightFile(
            path="scan.x3p",
            level="polynomial-4",
            l_filter_um=800,
            l_filter="robust",
            instrument={"sampling_um": 0.5, "noise_nm": 2},
        ),
        spacing_um=2.0,
    )
    assert "F-operation (least-squares polynomial of order 4)" in words
    assert "L-filter (robust Gaussian, nesting index 0.8 mm)" in words
    assert "instrument (lateral period limit 1 µm, noise 2 nm rms)" in words


@pytest.mark.parametrize(
    ("keys", "wanted"),
    [
        ({}, "in the terms of ISO 25178-2."),
        ({"width_um": 64.0}, "in the terms of ISO 21920-2."),
        ({"l_filter_um": 40.0}, "with filters of ISO 16610-61."),
        ({"l_filter_um": 40.0, "l_filter": "robust"}, "with filters of ISO 16610-71."),
    ],
)
def test_the_paragraph_on_methods_names_the_standards(keys: dict[str, object], wanted: str) -> None:
    np.save("scan.npy", waves()[:, :1] if "width_um" in keys else waves())
    section = {"kind": "file", "path": "scan.npy", "spacing_um": 1, "periodic": "blend"}
    scene = loads(SCENE + line(section | keys), folder=Path())
    assert conditions_of({"scan": scene}).paragraph([]).count(wanted) == 1


def test_the_roughness_report_names_form_and_filters(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rolling.commands.surface._parameters_and_picture", lambda *_: ([], {}))
    y = 1e-6 * (np.arange(80) - 40)
    np.save("roller.npy", waves() - np.sqrt(1e-3**2 - y**2))
    words = ["--spacing-um", "1", "--sampling-um", "2", "--l-filter-um", "60", "--declare"]
    assert cli.main(["-q", "surface", "roller.npy", *words]) == 0
    read = json.loads(Path("outputs/roller.npy-surface/declaration.json").read_text())
    facts = read["runs"][0]["sheets"][0]["facts"]
    assert facts["Form"] == "the least-squares cylinder is removed"
    filters = (
        "S-filter, Gaussian, nesting index 0.004 mm; L-filter, Gaussian, nesting index 0.06 mm"
    )
    assert facts["Filters of the surface"] == filters


def test_the_usual_index_is_that_of_the_table() -> None:
    """Ra 0.08 um lies in the class up to 0.1 um, which has 0.25 mm."""
    assert chosen_filters.usual_index(0.8e-7 * np.sign(waves())) == 0.25e-3


def test_gaps_and_ends_of_a_curved_scan_keep_its_form() -> None:
    """A gap of 60 um on a ball of 2 mm is not flat, and the S-filter does not lift the ends.

    A harmonic filling would leave 0.2 um in the gap, and weights at the ends 0.1 um.
    """
    x = 1e-6 * (np.arange(96)[:, None] - 30)
    ball = 2e-3 - np.sqrt(2e-3**2 - x**2 - (1e-6 * (np.arange(80) - 50)) ** 2)
    ball[20:80, 10:70] = np.nan
    np.save("ball.npy", ball)
    keys = {"path": "ball.npy", "spacing_um": 1, "unmeasured": "fill", "periodic": "blend"}
    scan = HeightFile(**keys, level="sphere", s_filter_um=8)  # type: ignore[arg-type]
    left = scale_limited_file(Path("ball.npy"), scan).heights
    assert np.ptp(left) < 1e-12


def test_a_tilted_arc_is_round_and_not_sheared() -> None:
    """A stylus on a groove of 1 mm reads an arc, tilted by 2 degrees as the part lies."""
    x = 2e-6 * (np.arange(400) - 180)
    rough = 1e-8 * np.random.default_rng(5).normal(size=400)
    arc = rough - np.sqrt(1e-3**2 - (x - 4e-5) ** 2)
    np.save("arc.npy", arc[:, None])
    read = described_file(Path("arc.npy"), FileOptions(spacing_um=2.0))
    assert read.keys["level"] == "cylinder"
    assert np.std(read.heights) == pytest.approx(np.std(rough), rel=0.03)
