"""One list of commands over a small scene of each kind: a ball that rolls or falls, a bearing.

What a command says of a kind is tested beside the kind. Here each command has to take all of them.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
import soundfile
from finished import VIBRATING

import rolling as rc
from rolling import cli
from tests.support.bearing_runs import WAVY

FALLING = """\
name: fall
sphere: {radius_mm: 5, density_kg_m3: 7850}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1, density_kg_m3: 7850,
  thickness_mm: 10, loss_factor: 0.01}
surface: {kind: smooth, spacing_um: 5, width_um: 200}
rolling: {speed_m_s: 0.05, distance_mm: 1, drop_mm: 0.1}
dynamics: {}
sound: {listen_s: 0.5}
"""


class OfKind(NamedTuple):
    """A scene of a kind, and the words of commands that name something of it.

    text : str. The scene, marched in a second or not at all.
    sweep : str. Its sweep over two values.
    resound : str. An assignment that keeps its contacts.
    marched : str. An assignment that needs other contacts.
    figure : str. A figure of its runs.
    quantity : str. What a recording of it holds.
    channels : int. Channels of the recording.
    key : str. A key of its drawing.
    """

    text: str
    sweep: str
    resound: str
    marched: str
    figure: str
    quantity: str
    channels: int
    key: str


KINDS = {
    "rolling": OfKind(
        text=VIBRATING.replace("sound: {", "sound: {listen_s: 0.5, "),
        sweep="sweep: {rolling.load_n: [1, 1.5]}",
        resound="sound.distance_m=2",
        marched="rolling.load_n=2",
        figure="spectrum",
        quantity="pressure",
        channels=1,
        key="sound.distance_m",
    ),
    "falling": OfKind(
        text=FALLING,
        sweep="sweep: {rolling.drop_mm: [0.1, 0.15]}",
        resound="sound.distance_m=2",
        marched="sphere.radius_mm=4",
        figure="spectrum",
        quantity="pressure",
        channels=1,
        key="sound.distance_m",
    ),
    "bearing": OfKind(
        text=WAVY.replace("0.5}", "0.6}").replace("0.5,", "0.6,"),
        sweep="sweep: {bearing.axial_load_n: [65, 75]}",
        resound="bearing.ring_mass_kg=0.05",
        marched="",
        figure="envelope",
        quantity="acceleration",
        channels=3,
        key="bearing.axial_load_n",
    ),
}
SCHEMAS = {"rolling": "ball", "falling": "ball", "bearing": "bearing"}


class Kept(NamedTuple):
    """A kind, the file of its scene, and the folders of a run and of a sweep of it."""

    name: str
    of_kind: OfKind
    scene: Path
    run: Path
    sweep: Path


@pytest.fixture(scope="module", params=KINDS)
def kept(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Kept:
    """Run a scene of a kind, and a sweep of it in two parts."""
    of_kind = KINDS[request.param]
    home = tmp_path_factory.mktemp(request.param)
    scene = home / "scene.yaml"
    scene.write_text(of_kind.text)
    swept = home / "swept.yaml"
    text = of_kind.text.replace("0.6", "0.1")  # of a bearing, whose record is compared
    swept.write_text(f"{text}{of_kind.sweep}\n")
    assert command("run", scene, "--out", home / "run", "--workers", "1", "--no-report") == 0
    for part in ("1/2", "2/2"):
        words = ("--out", home / "sweep", "--workers", "1", "--part", part, "--no-report")
        assert command("run", swept, *words) == 0
    return Kept(request.param, of_kind, scene, home / "run", home / "sweep")


def command(*words: Any) -> int:
    """Run a command quietly, and return its exit code."""
    return cli.main([*map(str, words), "-q"])


def test_check_and_schema(kept: Kept, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["check", str(kept.scene), "--fast"]) == 0
    assert "It runs in" in capsys.readouterr().out
    assert cli.main(["schema", "--kind", SCHEMAS[kept.name]]) == 0
    schema = json.loads(capsys.readouterr().out)
    section = type(rc.read_scene(kept.scene)).SECTION
    assert section in schema["required"]


def test_run_report_status_and_listening(kept: Kept, capsys: pytest.CaptureFixture[str]) -> None:
    page = kept.run / "report.html"
    assert not page.exists()
    assert command("report", kept.run) == 0
    assert page.is_file() and (kept.run / "listen.wav").is_file()
    assert cli.main(["status", str(kept.sweep)]) == 0
    assert "2 runs: 2 done" in capsys.readouterr().out


def test_table_of_a_run_and_of_a_sweep(kept: Kept) -> None:
    assert command("table", kept.run) == 0
    assert command("table", kept.sweep) == 0
    for folder in (kept.run, kept.sweep):
        assert (folder / "runs.csv").is_file() and (folder / "statistics.csv").is_file()


def test_plot(kept: Kept, tmp_path: Path) -> None:
    assert (
        command("plot", kept.run, "--figure", kept.of_kind.figure, "--out", tmp_path / "figures")
        == 0
    )
    assert [path.stem for path in (tmp_path / "figures").iterdir()] == [kept.of_kind.figure]
    assert rc.open_run(kept.run).plot(kept.of_kind.figure).get_title(loc="left")


def test_gallery(kept: Kept, tmp_path: Path) -> None:
    page = tmp_path / "gallery.html"
    assert command("gallery", kept.run, kept.sweep, "--out", page) == 0
    assert page.read_text().count("<audio") >= 3


def test_resound_takes_what_keeps_the_contacts(
    kept: Kept, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rolling.run.worker.solve_piece", None)  # nothing is marched
    words = ("resound", kept.run, "--no-report", "--workers", "1")
    out = tmp_path / "other"
    assert command(*words, "--set", kept.of_kind.resound, "--out", out) == 0
    assert rc.open_run(out).numbers != rc.open_run(kept.run).numbers
    if kept.of_kind.marched:
        assert command(*words, "--set", kept.of_kind.marched) == 2
        key = kept.of_kind.marched.partition("=")[0]
        assert f"{key}: needs a new run" in capsys.readouterr().err


def test_compare_with_a_recording(kept: Kept, tmp_path: Path) -> None:
    noise = np.random.default_rng(1).normal(size=(48000, kept.of_kind.channels))
    recording = tmp_path / "recorded.wav"
    soundfile.write(recording, 0.1 * noise, 48000, subtype="FLOAT")
    quantity = kept.of_kind.quantity
    assert command("compare", kept.run, recording, "--quantity", quantity) == 0
    assert [*kept.run.glob("compare-*.csv")] and [*kept.run.glob("compare-*.html")]


@pytest.mark.slow
def test_choose(kept: Kept, tmp_path: Path) -> None:
    swept = kept.scene.with_name("swept.yaml")
    words = ("choose", swept, "--pairs", "2", "--out", tmp_path / "choice", "--workers", "1")
    if kept.name != "rolling":  # nothing is random in the others
        words = tuple(word for word in words if word not in ("--pairs", "2"))
    assert command(*words) == 0
    assert (tmp_path / "choice" / "choice.html").is_file()


def test_simulate_save_and_open(kept: Kept, tmp_path: Path) -> None:
    run = rc.simulate(rc.read_scene(kept.scene), workers=1, progress=False, start_from=kept.run)
    folder = run.save(tmp_path / "saved", report=False)
    opened = rc.open_run(folder)
    assert opened.label == run.label
    assert opened.scene == run.scene


def test_simulate_a_sweep(kept: Kept) -> None:
    runs = rc.simulate_sweep(rc.read_scene(kept.sweep / "scene.yaml"), workers=1, progress=False)
    assert len(runs) == 2 == len(runs.table())
    assert len(repr(runs).splitlines()) >= 3
    assert "</" in runs._repr_html_()
    data = runs.to_xarray()
    assert len(data.dims) >= 3
    for name, variable in data.data_vars.items():
        assert "long_name" in variable.attrs, name


@pytest.mark.slow
def test_sensitivities(kept: Kept) -> None:
    scene = rc.read_scene(kept.scene.with_name("swept.yaml"), ["sweep="])  # of a short record
    pairs = 2 if kept.name == "rolling" else None
    found = rc.sensitivities(scene, [kept.of_kind.key], pairs=pairs, workers=1, progress=False)
    assert [row.change.key for row in found.rows] == [kept.of_kind.key]
