"""`import rolling as rc`: the numbers of the command in memory, and runs saved and opened."""

from __future__ import annotations

import base64
import inspect
import json
import re
import shutil
import subprocess
import sys
from dataclasses import fields, is_dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from commands import ROOT, SWEEP, contents, words_of
from finished import untimed
from matplotlib.figure import Figure
from scene_text import TINY

import rolling as rc
from acoustics import wav
from rolling import cli
from rolling.interface import runs as interface
from rolling.results.run_result import Run
from rolling.run import pools
from rolling.terminal import progress as terminal_progress

SCRIPT = """\
import rolling as rc
print("main")
scene = rc.read_scene("scene.yaml", ["sweep.surface.seed=[1, 2]"])
runs = rc.simulate_sweep(scene, workers=2)
print({seed: run.vibration.value for seed, run in runs.items()})
"""
IN_A_POOL = """\
import multiprocessing
import sys

import rolling as rc


def level(load):
    # Three pieces, so that two workers would be started elsewhere.
    scene = rc.read_scene("scene.yaml").with_(load_n=load)
    return rc.simulate(scene, workers=2).sound.levels.laeq_db


if __name__ == "__main__":
    print(level(1.0))
    if sys.argv[1] == "multiprocessing":
        with multiprocessing.Pool(1) as pool:
            print(*pool.map(level, [1.0]))
    else:
        import distributed

        how = {"n_workers": 1, "threads_per_worker": 1, "dashboard_address": None}
        with distributed.LocalCluster(**how) as cluster, distributed.Client(cluster) as client:
            print(client.submit(level, 1.0).result())
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A scene with recovery events, and its run by the command."""
    folder = tmp_path_factory.mktemp("python")
    (folder / "scene.yaml").write_text(TINY + "recovery: {events: true}\n")
    assert cli.main(words_of(folder / "scene.yaml", folder / "out", "--workers", "1")) == 0
    return folder


@pytest.fixture(scope="module")
def run(folder: Path) -> Run:
    return rc.simulate(rc.read_scene(folder / "scene.yaml"), workers=1)


def executed(arguments: list[str], folder: Path) -> str:
    return subprocess.run(
        [sys.executable, *arguments], cwd=folder, capture_output=True, text=True, check=True
    ).stdout


def test_import_is_instant_and_names_are_public() -> None:
    code = "import sys, rolling; print(*rolling.__all__); print(*sys.modules)"
    names, modules = executed(["-c", code], ROOT).splitlines()
    assert not {"numpy", "numba", "pydantic", "matplotlib", "xarray", "h5py"} & {*modules.split()}
    for name in names.split():
        value = getattr(rc, name)
        assert inspect.ismodule(value) or value.__doc__, name
    assert {*names.split()} < {*dir(rc)}
    with pytest.raises(AttributeError, match="has no attribute 'simulat'"):
        rc.simulat  # noqa: B018
    assert (Path(rc.__file__).parent / "py.typed").is_file()


def test_same_numbers_as_the_command_bit_by_bit(folder: Path, run: Run) -> None:
    stored_run = rc.open_run(folder / "out")
    for name, values in run.series.items():
        if name != "step_time":
            np.testing.assert_array_equal(values, stored_run.series[name])
    np.testing.assert_array_equal(run.sound.pressure, stored_run.sound.pressure)
    assert untimed(run.numbers) == untimed(stored_run.numbers)
    assert run.events is not None and len(run.events["energy"]) > 0


def test_a_folder_states_processor_times(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    shutil.copytree(folder / "out", out)
    command = ["run", str(folder / "scene.yaml"), "--out", str(out), "-q"]
    assert cli.main(command) == 0  # with a page
    summary = json.loads((out / "summary.json").read_text())
    effort = summary["effort"]
    parts = effort["parts_cpu_s"]
    assert parts["page"] > 0 and parts["sound"] > 0
    assert 0 < parts["march"] == effort["march_cpu_s"]
    page = (out / "report.html").stat().st_mtime_ns
    assert page >= (out / "summary.json").stat().st_mtime_ns
    stored = rc.open_run(out).numbers.effort.parts_cpu_s["page"]
    assert parts["page"] == pytest.approx(stored, rel=5e-6)  # the summary has six digits


def test_a_saved_run_has_the_bytes_of_the_command_and_comes_back_equal(
    folder: Path, tmp_path: Path, run: Run
) -> None:
    saved = run.save(tmp_path / "mine", report=False)
    command = contents(folder / "out")
    mine = contents(saved)
    assert mine["signal.wav"] == command["signal.wav"]
    again = rc.open_run(saved)
    assert again.scene == run.scene and again.label == run.label
    np.testing.assert_array_equal(again.release_power, run.release_power)
    assert again.numbers.of_record.laeq_db == run.numbers.of_record.laeq_db
    with pytest.raises(rc.FolderError, match="mine-2"):
        run.save(saved)
    again.save(tmp_path / "other")
    assert (tmp_path / "other" / "report.html").is_file()


def test_tree_is_the_file(folder: Path) -> None:
    tree = rc.open_run(folder / "out").to_xarray()
    with xr.open_datatree(folder / "out" / "result.h5", engine="h5netcdf") as file:
        assert {*tree.groups} == {*file.groups}
        for group in tree.groups:
            here, there = (each[group].to_dataset(inherit=False) for each in (tree, file))
            assert here.equals(there)
        assert file["release_power"].dims == ("step",) and file["release_power"].units == "W"


def test_tables_and_wav_hold_the_numbers_of_the_files(
    folder: Path, tmp_path: Path, run: Run
) -> None:
    frame = run.to_dataframe()
    root = run.to_xarray()
    assert {*frame.columns} == {*root.data_vars} | {"position_time"} - {"step", "position"}
    for name in frame:
        np.testing.assert_array_equal(frame[name].dropna(), root[name])
        assert frame.attrs[name] == root[name].units
    np.testing.assert_array_equal(frame.index, root["position"])
    assert run.write_wav(tmp_path / "mine.wav") == tmp_path / "mine.wav"
    mine, stored = (wav.read(path) for path in (tmp_path / "mine.wav", folder / "out/signal.wav"))
    np.testing.assert_array_equal(mine[0], stored[0])
    assert mine[2] == "1.0 = 1 Pa" and stored[2].startswith("1.0 = 1 Pa; ")
    bands = run.sound.third_octaves()
    own = run.numbers.bands
    for name, stated in (
        ("third_octave_db", own.released_power.value),
        ("third_octave_a_db", own.released_power_a.value),
        ("third_octave_uncertainty_db", own.released_power.uncertainty),
    ):
        levels = [np.nan if x is None else x for x in stated]
        np.testing.assert_array_equal(bands[name], levels)
    assert len(bands.columns) == 3
    assert bands.index[bands.index == 31.5].name == "band_hz"


def test_table_of_runs_is_runs_csv(folder: Path, tmp_path: Path) -> None:
    loads = ["sweep.rolling.load_n=[0.005, 0.01]"]
    runs = rc.simulate_sweep(rc.read_scene(folder / "scene.yaml", loads), workers=1)
    words = words_of(folder / "scene.yaml", tmp_path / "out", "--workers", "1")
    assert cli.main([*words, "--set", *loads]) == 0
    stored = pd.read_csv(tmp_path / "out/runs.csv")
    table = runs.table().reset_index()
    assert [*stored] == [name for name in table if name in stored]
    for name in ("run", "rolling.load_n", "vibration_db", "released_power_verdict", "doubts"):
        assert table[name].tolist() == pytest.approx(stored[name].tolist()), name


def test_public_objects_have_units_and_examples_that_run() -> None:
    """Every field stands in the docstring; every class but sections and errors has an example."""
    for name in rc.__all__:
        value = getattr(rc, name)
        if is_dataclass(value):
            text = inspect.getdoc(value) or ""
            for field in fields(value):
                assert re.search(rf"^(\w+, )*{field.name}(, \w+)* : ", text, re.MULTILINE), (
                    field.name
                )
            assert ">>> " in text, name


def test_contact_knows_its_area_load_and_modulus() -> None:
    """A flat punch bears its load on its area; both bodies of a scene give its modulus."""
    gap = np.full((24, 24), 1e-6)
    gap[4:20, 4:20] = 0.0
    contact = rc.solve_contact(rc.HalfSpace(2e-6, 230e9), gap, 0.3)
    assert contact.contact_area == pytest.approx(256 * 4e-12, rel=1e-12)
    assert contact.load == pytest.approx(0.3, rel=1e-12)
    changes = {"sphere.youngs_modulus_gpa": 70, "sphere.poissons_ratio": 0.22}
    scene = rc.read_scene("quickstart").with_(changes)
    of_bodies = rc.closed_forms.contact_modulus(210e9, 0.3, 70e9, 0.22)
    assert of_bodies == pytest.approx(scene.contact_modulus, rel=1e-12)
    assert rc.closed_forms.contact_modulus(4.0, 0) == 4.0
    with pytest.raises(ValueError, match=r"other_ratio: got 0\.6, allowed: .* <= 0\.5"):
        rc.closed_forms.contact_modulus(210e9, 0.3, 70e9, 0.6)


def test_a_sweep_gives_runs_by_value_and_is_refused_by_simulate(folder: Path) -> None:
    loads = ["sweep.rolling.load_n=[0.005, 0.01]"]
    scene = rc.read_scene(folder / "scene.yaml", loads)
    with pytest.raises(rc.SceneError, match=r"sweeps rolling\.load_n; simulate_sweep"):
        rc.simulate(scene)
    runs = rc.simulate_sweep(scene, workers=1)
    assert [*runs] == [0.005, 0.01]
    assert [run.label for run in runs.values()] == ["load 0.005 N", "load 0.01 N"]
    with pytest.raises(rc.SceneError, match="no sweep; simulate"):
        rc.simulate_sweep(runs[0.005].scene)
    both = scene.with_(sweep={"rolling.load_n": [0.005], "surface.seed": [1, 2]})
    assert [*rc.simulate_sweep(both, workers=1)] == [(0.005, 1), (0.005, 2)]


def test_a_saved_run_of_a_sweep_keeps_its_label(tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_text(TINY + "sweep: {plate.hardness_gpa: [1, 2]}")
    runs = rc.simulate_sweep(rc.read_scene(tmp_path / "scene.yaml"), workers=1)
    again = rc.open_run(runs[2].save(tmp_path / "mine", report=False))
    assert again.label == runs[2].label == "hardness 2 GPa"


def test_failures_are_raised_beside_the_other_runs(folder: Path) -> None:
    heavy = rc.read_scene(folder / "scene.yaml", ["rolling.load_n=40"])
    with pytest.raises(rc.ContactError, match="more than the surface can carry"):
        rc.simulate(heavy, workers=1)
    swept = heavy.with_(sweep={"rolling.load_n": [40, 0.005]})
    with pytest.raises(rc.SweepError, match=r"load 40 N: .* than the surface can carry") as error:
        rc.simulate_sweep(swept, workers=1)
    assert [*error.value.runs] == [0.005] and [*error.value.failures] == ["load 40 N"]


def test_a_folder_that_holds_several_runs_or_none_is_refused(tmp_path: Path) -> None:
    with pytest.raises(rc.FolderError, match="no run folder"):
        rc.open_run(tmp_path)
    (tmp_path / "scene.yaml").write_text(TINY + "sweep: {surface.seed: [1, 2]}\n")
    out = tmp_path / "out"
    words = words_of(tmp_path / "scene.yaml", out, "--workers", "1", "--part", "1/2")
    assert cli.main(words) == 0
    with pytest.raises(rc.FolderError, match="holds 2 runs"):
        rc.open_run(out)
    assert rc.open_run(out / "seed=1").label == "seed 1"
    with pytest.raises(rc.FolderError, match="not done"):
        rc.open_run(out / "seed=2")


@pytest.mark.parametrize("source", ["file", pytest.param("input", marks=pytest.mark.slow)])
def test_a_script_needs_no_guard(source: str, folder: Path, tmp_path: Path) -> None:
    """Workers do not run the main module again, whose output would come twice."""
    (tmp_path / "scene.yaml").write_text((folder / "scene.yaml").read_text())
    (tmp_path / "script.py").write_text(SCRIPT)
    arguments = [sys.executable, "script.py" if source == "file" else "-"]
    done = subprocess.run(
        arguments, input=SCRIPT, cwd=tmp_path, capture_output=True, text=True, check=True
    )
    first, second = done.stdout.splitlines()
    assert first == "main" and second.startswith("{1: ")


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["multiprocessing", "dask"])
def test_a_process_of_a_pool_solves_itself(kind: str, tmp_path: Path) -> None:
    """Daemonic processes must not have children; the level is that of the main process."""
    if kind == "dask":
        pytest.importorskip("distributed")
    text = SWEEP.partition("sweep:")[0].replace("spacing_um: 2", "spacing_um: 4")
    (tmp_path / "scene.yaml").write_text(text.replace("duration_s: 0.009", "duration_s: 0.018"))
    (tmp_path / "script.py").write_text(IN_A_POOL)
    done = subprocess.run(
        [sys.executable, "script.py", kind], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    here, there = done.stdout.split()
    assert here == there


def test_progress_is_shown_where_it_is_asked_for(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = rc.read_scene(folder / "scene.yaml")
    for progress, is_shown in ((True, True), (None, False), (False, False)):
        rc.simulate(scene, workers=1, progress=progress)
        printed = capsys.readouterr()
        assert ("100%" in printed.err) == is_shown and not printed.out
    # A notebook is no terminal, but it has a reader.
    shell = type("ZMQInteractiveShell", (), {})()
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: shell))
    rc.simulate(scene, workers=1)
    assert "100%" in capsys.readouterr().err


@pytest.mark.parametrize("progress", [None, False])
def test_compilation_is_said_once_unless_silence_is_asked_for(
    progress: bool | None,
    folder: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A first run in a script compiles for a minute, and its terminal says so."""
    submit = pools.Pool.submit

    def compiling(pool: pools.Pool, task: pools.Task, team: int) -> Any:
        terminal_progress.compiling()
        return submit(pool, task, team)

    monkeypatch.setattr(terminal_progress, "_commands", [terminal_progress._Command()])
    monkeypatch.setattr(pools.Pool, "submit", compiling)
    rc.simulate(rc.read_scene(folder / "scene.yaml"), workers=1, progress=progress)
    told = capsys.readouterr().err.count(terminal_progress.COMPILING)
    assert told == (0 if progress is False else 1)


def test_levels_and_doubts_for_a_notebook(run: Run) -> None:
    html = run._repr_html_()
    assert "dB(A)" in html and html.index("vibration") < html.index("released power")
    text = repr(run)
    assert text.startswith("<run tiny, load 0.005 N: vibration ") and "estimated" in text
    assert text.index("vibration") < text.index("released power") and "upper bound" in text


def test_a_notebook_has_a_player_and_a_stored_run_its_file(
    run: Run, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert rc.open_run(folder / "out").play() is None
    assert capsys.readouterr().out.startswith(f"listen: {folder / 'out' / 'listen.wav'}   ")

    class Display:
        @staticmethod
        def Audio(samples, rate, normalize):
            return len(samples), rate, normalize

    shell = type("ZMQInteractiveShell", (), {})()
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: shell))
    monkeypatch.setitem(sys.modules, "IPython.display", Display)
    samples, rate, normalize = run.play()
    assert 5 * rate <= samples < 5 * rate + len(run.sound.pressure) and not normalize


def test_live_opens_a_page_and_a_notebook_frames_it(
    run: Run, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    """A stored run has its own page, a run in memory a temporary one; a frame holds it whole."""
    opened: list[str] = []
    monkeypatch.setattr(interface.webbrowser, "open", opened.append)
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    stored = rc.open_run(shutil.copytree(folder / "out", tmp_path / "out"))
    (stored.folder / "report.html").write_text("the page")
    pages = []
    for shown in (stored, [run, stored]):
        assert rc.live(shown) is None
        pages.append(Path(capsys.readouterr().out.removeprefix("live: ").strip()))
    assert opened == [f"{path.resolve().as_uri()}#play-it" for path in pages]
    assert pages[0] == stored.folder / "report.html"
    # a vibration and a release of two runs
    assert pages[1].read_text().count("audio controls") == 4
    pages[1].unlink()
    with pytest.raises(ValueError, match="got 0"):
        rc.live([])
    shell = type("ZMQInteractiveShell", (), {})()
    frames = SimpleNamespace(IFrame=lambda src, width, height: src)
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: shell))
    monkeypatch.setitem(sys.modules, "IPython.display", frames)
    kind, _, content = rc.live(stored).partition(",")
    assert kind == "data:text/html;base64"
    assert base64.b64decode(content.removesuffix("#play-it")) == b"the page"


def test_plots_take_and_return_axes(run: Run) -> None:
    axes = Figure().subplots(1, 4)
    for draw, ax in zip(
        (rc.plot.third_octaves, rc.plot.spectrum, rc.plot.release_power, rc.plot.contact_pressure),
        axes,
        strict=True,
    ):
        assert draw(run, ax=ax) is ax
        assert ax.get_xlabel() and ax.get_ylabel()
