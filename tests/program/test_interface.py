"""The interface for Python runs without a guard and gives the numbers of the command."""

from __future__ import annotations

import doctest
import inspect
import json
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import h5py
import matplotlib
import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

import rolling as rc
from rolling import cli
from rolling.commands import interface
from rolling.contact.solver import ContactError
from rolling.folders.files import FolderError
from rolling.scene.messages import SceneError
from rolling.simulation.run_result import RunResult
from rolling.terminal import progress as terminal

matplotlib.use("Agg")

SCENE = """\
name: small
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}
surface: {kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10, \
spacing_um: 2, width_um: 128, seed: 3}
rolling: {load_n: 0.5, speed_m_s: 0.1, duration_s: 0.009}
"""
SWEPT = SCENE + "sweep: {rolling.load_n: [0.25, 0.5]}\n"
# As a researcher types it, two pieces on two workers: without a guard.
PROGRAM = """\
import matplotlib; matplotlib.use("Agg")
import rolling as rc, matplotlib.pyplot as plt
scene = rc.read_scene("scene.yaml")
run = rc.simulate(scene, workers=2)
run.series["contact_area"], run.release_power
run.sound.levels.laeq_db, run.sound.pressure
fig, ax = plt.subplots(1, 2)
rc.plot.third_octaves([run], ax=ax[0]); rc.plot.contact_pressure(run, ax=ax[1])
run.play(); run.to_xarray()
runs = rc.simulate_sweep(rc.read_scene("swept.yaml", ["rolling.duration_s=0.002"]), workers=2)
print(len(run.release_power), *runs)
"""
DOCTEST = '''\
"""A module with an example.

>>> import rolling as rc
>>> scene = rc.read_scene("scene.yaml")
>>> run = rc.simulate(scene, workers=2)
>>> run.release_power.shape
(450,)
"""
'''


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a scene and the run that the command made of it."""
    folder = tmp_path_factory.mktemp("interface")
    (folder / "scene.yaml").write_text(SCENE)
    (folder / "swept.yaml").write_text(SWEPT)
    run = ["run", str(folder / "scene.yaml"), "--out", str(folder / "out"), "--workers", "2"]
    assert cli.main(run) == 0
    return folder


@pytest.fixture(scope="module")
def run(folder: Path) -> RunResult:
    return rc.simulate(rc.read_scene(folder / "scene.yaml"), workers=1)


def executed(arguments: list[str], folder: Path, given: str | None = None) -> str:
    """Run Python in the folder; return the output of a program that leaves nothing on stderr."""
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join(filter(None, [str(Path.cwd()), *sys.path]))
    }
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=folder,
        env=environment,
        input=given,
        capture_output=True,
        text=True,
        timeout=900,
    )
    assert done.returncode == 0, done.stderr
    assert not done.stderr, done.stderr  # no progress where nobody looks
    return done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("way", ["script", "standard input", "command", "namespace without a file"])
def test_the_lines_run_without_a_guard(folder: Path, tmp_path: Path, way: str) -> None:
    for name in ("scene.yaml", "swept.yaml"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    (tmp_path / "program.py").write_text(PROGRAM)
    before = sorted(file.name for file in tmp_path.iterdir())
    arguments, given = {
        "script": (["program.py"], None),
        "standard input": (["-"], PROGRAM),
        "command": (["-c", PROGRAM], None),
        "namespace without a file": (
            ["-c", "exec(open('program.py').read(), {'__name__': '__main__'})"],
            None,
        ),
    }[way]
    printed = executed(arguments, tmp_path, given)
    assert printed.splitlines()[-1] == "450 0.25 0.5"
    new = {file.name for file in tmp_path.iterdir()} - {*before}
    assert new <= {"listen.wav"}  # which `play` makes where IPython is not installed


@pytest.mark.slow
def test_a_doctest_runs_workers(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_bytes((folder / "scene.yaml").read_bytes())
    (tmp_path / "example.py").write_text(DOCTEST)
    assert executed(["-m", "doctest", "example.py"], tmp_path) == ""


def test_import_is_instant_and_names_are_public() -> None:
    code = "import sys, rolling; print(*rolling.__all__); print(*sys.modules)"
    names, modules = executed(["-c", code], Path.cwd()).splitlines()
    assert not {"numpy", "numba", "pydantic", "matplotlib", "xarray", "h5py"} & {*modules.split()}
    for name in names.split():
        value = getattr(rc, name)
        assert inspect.ismodule(value) or value.__doc__, name
    assert {*names.split()} == {*rc._PLACES} and {*names.split()} < {*dir(rc)}
    with pytest.raises(AttributeError, match="has no attribute 'simulat'"):
        rc.simulat  # noqa: B018
    assert (Path(rc.__file__).parent / "py.typed").is_file()


def test_same_numbers_as_the_command_bit_by_bit(folder: Path, run: RunResult) -> None:
    with h5py.File(folder / "out" / "result.h5") as file:
        for name, values in run.series.items():
            if name != "step_time":
                assert np.array_equal(values, file[name][:]), name
        for name, values in {
            "step": run.distance,
            "time": run.time,
            "position": run.position,
            "position_time": run.position_time,
            "release_power": run.release_power,
            "sound/pressure": run.sound.pressure,
        }.items():
            assert np.array_equal(values, file[name][:]), name
        assert {name for name, data in file.items() if isinstance(data, h5py.Dataset)} == {
            *run.series,
            *("step", "time", "position", "position_time"),
        }
    told = json.loads((folder / "out" / "summary.json").read_text())
    timed = {"step_ms", "seconds", "sound_seconds"}
    assert {k: v for k, v in told.items() if k not in timed} == {
        k: v for k, v in run.summary.items() if k not in timed
    }


@pytest.mark.slow
def test_saved_run_has_the_files_of_the_command_and_comes_back_equal(
    folder: Path, tmp_path: Path, run: RunResult
) -> None:
    saved = run.save(tmp_path / "mine")
    given = {"scene.yaml"}  # the text that the command was given
    assert {file.name for file in saved.iterdir()} == {
        file.name for file in (folder / "out").iterdir()
    } - given
    assert (saved / "signal.wav").read_bytes() == (folder / "out" / "signal.wav").read_bytes()
    again = rc.open_run(saved)
    assert again.scene == run.scene and again.summary == run.summary and again.label == run.label
    assert all(np.array_equal(values, again.series[name]) for name, values in run.series.items())
    assert np.array_equal(again.sound.pressure, run.sound.pressure)
    assert again.to_xarray().identical(run.to_xarray())
    with pytest.raises(FolderError, match="--force"):
        run.save(saved)
    assert (
        again.save(saved, force=True, report=False) == saved
        and not (saved / "report.html").exists()
    )


def test_tree_is_the_file(folder: Path, run: RunResult) -> None:
    tree = run.to_xarray()
    with xr.open_datatree(folder / "out" / "result.h5", engine="h5netcdf") as file:
        assert {*tree.groups} == {*file.groups}
        for group in tree.groups:
            here, there = (each[group].to_dataset(inherit=False) for each in (tree, file))
            assert here.drop_vars("step_time", errors="ignore").equals(
                there.drop_vars("step_time", errors="ignore")
            )


def test_sweep_gives_runs_by_value_and_is_refused_by_simulate(folder: Path, run: RunResult) -> None:
    swept = rc.read_scene(folder / "swept.yaml")
    with pytest.raises(SceneError, match=r"sweeps rolling\.load_n; simulate_sweep"):
        rc.simulate(swept)
    runs = rc.simulate_sweep(swept, workers=2)
    assert [*runs] == [0.25, 0.5]
    assert [each.label for each in runs.values()] == ["load 0.25 N", "load 0.5 N"]
    assert np.array_equal(runs[0.5].release_power, run.release_power)
    with pytest.raises(SceneError, match="no sweep; simulate"):
        rc.simulate_sweep(run.scene)
    ax = rc.plot.levels(runs, "rolling.load_n")
    assert ax.get_xlabel() == "load [N]" and len(ax.get_legend().texts) == 2
    with pytest.raises(ValueError, match=r"surface\.kind: .* no number"):
        rc.plot.levels(runs, "surface.kind")


def test_failures_are_raised(folder: Path) -> None:
    short = ["rolling.duration_s=0.002"]
    heavy = rc.read_scene(folder / "scene.yaml", [*short, "rolling.load_n=90"])
    with pytest.raises(ContactError, match="more than the surface can carry"):
        rc.simulate(heavy, workers=1)
    swept = rc.read_scene(folder / "swept.yaml", [*short, "sweep.rolling.load_n=[90, 0.5]"])
    with pytest.raises(
        rc.SweepError, match=r"load 90 N: .* more than the surface can carry"
    ) as error:
        rc.simulate_sweep(swept, workers=1)
    assert [*error.value.runs] == [0.5] and [*error.value.failures] == ["load 90 N"]
    with pytest.raises(FolderError, match="not a run folder"):
        rc.open_run(folder)


def test_progress_is_shown_where_it_is_asked_for(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = rc.read_scene(folder / "scene.yaml", ["rolling.duration_s=0.002"])
    for progress, shown in ((True, True), (None, False), (False, False)):
        rc.simulate(scene, workers=1, progress=progress)
        printed = capsys.readouterr()
        assert ("100%" in printed.err) == shown and not printed.out


def test_progress_is_shown_in_a_notebook(monkeypatch: pytest.MonkeyPatch) -> None:
    """A notebook is no terminal, but it has a reader."""
    assert terminal._is_hidden(None) is None  # tqdm looks for a terminal
    shell = type("ZMQInteractiveShell", (), {})()
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: shell))
    assert terminal._is_hidden(None) is False and terminal._is_hidden(False) is True


def test_example_of_the_docstring() -> None:
    failed, attempted = doctest.testmod(interface)
    assert attempted >= 4 and not failed


def test_levels_and_caveats_for_a_notebook(run: RunResult) -> None:
    html = run._repr_html_()
    assert "LAeq" in html and "dB(A)" in html and "upper bound" in html and "&lt;" not in run.title
    assert repr(run).startswith("<run small, load 0.5 N: LAeq ") and repr(run).endswith(
        "450 steps>"
    )


def test_player_of_a_notebook_or_the_name_of_the_file(
    run: RunResult,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, "IPython.display", None)
    assert run.play() is None
    assert capsys.readouterr().out == "listen: listen.wav\n" and (tmp_path / "listen.wav").is_file()

    class Display:
        @staticmethod
        def Audio(samples, rate, normalize):
            return len(samples), rate, normalize

    monkeypatch.setitem(sys.modules, "IPython.display", Display)
    assert run.play() == (len(run.sound.pressure), 48000, False)


def test_plots_take_and_return_axes(run: RunResult) -> None:
    figure = Figure()
    axes = figure.subplots(1, 6)
    draws = (
        rc.plot.third_octaves,
        rc.plot.spectrum,
        rc.plot.release_power,
        rc.plot.contact_pressure,
        rc.plot.surface,
    )
    for draw, ax in zip(draws, axes, strict=False):
        assert draw(run, ax=ax) is ax
        assert ax.get_xlabel() and ax.get_ylabel()
    assert rc.plot.surface(run.scene, axes[5]) is axes[5]
    assert rc.plot.third_octaves([run], a_weighted=True).get_ylabel().startswith("A-weighted")
