"""The end of a command: no sound is made twice, and processes that are there draw for it."""

from __future__ import annotations

import pickle
import warnings
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Future
from pathlib import Path
from types import MappingProxyType
from typing import Any

import pytest
from commands import words_of
from finished import marched, same
from scene_text import TINY

from rolling import cli
from rolling.ball_kinds import one_ball
from rolling.commands import derived
from rolling.figures.picture import Picture
from rolling.figures.settings import PictureWarning
from rolling.kinds.run_folder import RunFolder
from rolling.report import ball_page
from rolling.report.charts import Chart
from rolling.report.report_page import page
from rolling.results import listening, long_record, run_result
from rolling.results.run_result import Run, read_run, write_run
from rolling.run import folder as folders
from rolling.run import kept_runs
from rolling.run.ending import Ending
from rolling.run.kept_runs import KeptRuns
from rolling.run.pools import Pool, Task

LOADS = "sweep: {rolling.load_n: [0.5, 1, 2]}\n"


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return a list of the runs whose sound is made from now on; pages are not drawn."""
    labels: list[str] = []
    make_run = one_ball.make_run

    def counted(place: RunFolder, label: str, *more: Any) -> Run:
        labels.append(label)
        return make_run(place, label, *more)

    monkeypatch.setattr(one_ball, "make_run", counted)
    monkeypatch.setattr(run_result, "make_run", counted)
    monkeypatch.setattr(
        "rolling.report.report_page.page", lambda runs, names: f"{len(runs)}".encode()
    )
    monkeypatch.setattr("rolling.figures.write_figures", lambda runs, folder: [])
    return labels


def test_the_sound_of_each_run_of_a_sweep_is_made_once(tmp_path: Path, made: list[str]) -> None:
    """The common gain, the figures and the page read the runs that were heard."""
    scene = tmp_path / "scene.yaml"
    scene.write_text(TINY + LOADS)
    out = tmp_path / "out"
    command = ["run", str(scene), "--out", str(out), "--workers", "1", "-q"]
    assert cli.main(command) == 0
    assert sorted(made) == ["load 0.5 N", "load 1 N", "load 2 N"]
    assert (out / "report.html").read_text() == "3"
    assert not (out / folders.PIECES).exists()
    # A further run of the sweep is made once; the others are made again from their results.
    made.clear()
    scene.write_text(TINY + LOADS.replace("2]", "2, 3]"))
    assert cli.main(command) == 0
    assert made.count("load 3 N") == 1


def test_runs_that_a_killed_command_kept_are_removed(tmp_path: Path, made: list[str]) -> None:
    scene = tmp_path / "scene.yaml"
    scene.write_text(TINY + LOADS)
    out = tmp_path / "out"
    assert cli.main(words_of(scene, out, "--workers", "1")) == 0
    left = out / folders.PIECES / folders.KEPT / "of-a-killed-command"
    left.parent.mkdir(parents=True)
    left.write_bytes(b"")
    assert cli.main(words_of(scene, out, "--workers", "1")) == 0
    assert not left.exists()


def test_runs_that_a_killed_part_kept_go_with_the_last_part(
    tmp_path: Path, made: list[str]
) -> None:
    scene = tmp_path / "scene.yaml"
    scene.write_text(TINY + LOADS)
    out = tmp_path / "out"
    assert cli.main(words_of(scene, out, "--workers", "1", "--part", "1/2")) == 0
    left = out / folders.PIECES / folders.KEPT / "of-a-killed-part"
    left.parent.mkdir(parents=True)
    left.write_bytes(b"")
    assert cli.main(words_of(scene, out, "--workers", "1", "--part", "2/2")) == 0
    assert (out / "runs.csv").is_file()
    assert not (out / folders.PIECES).exists()


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """A run that is done."""
    heard = marched(TINY, folder=tmp_path_factory.mktemp("run"))
    write_run(heard)
    return heard


def test_a_kept_run_is_the_run_that_is_read(run: Run) -> None:
    kept = KeptRuns(run.folder)
    kept.add(run, kept_runs.keep(run))
    again = kept.read(run, "again")
    read = read_run(run, "again")
    assert again.label == read.label and again.numbers == read.numbers
    assert same(again.sound, read.sound) and again.scene == read.scene
    for name, values in read.series.items():
        if name != "step_time":  # it is not stored
            assert same(again.series[name], values), name
    kept.remove()
    assert not (run.folder / folders.PIECES).exists()


def test_a_kept_run_is_found_by_another_spelling_of_its_folder(
    run: Run, made: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Workers of a cluster have the whole path of a folder that the command names from its own."""
    kept = KeptRuns(run.folder)
    kept.add(run, kept_runs.keep(run))
    monkeypatch.chdir(run.folder.parent)
    named = RunFolder(run.values, run.scene, Path(run.folder.name))
    assert kept.only(named).read(named, "again").label == "again"
    assert not made
    kept.remove()


def test_a_kept_run_has_the_records_that_were_made_for_its_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The common gain and the page play the long records of vibration and release."""
    heard = marched(TINY, ("sound.listen_s=6",), folder=tmp_path)
    write_run(heard)
    files = [sound.wav() for sound in listening.new_sounds(heard)]
    kept = KeptRuns(tmp_path)
    kept.add(heard, kept_runs.keep(heard))
    made: list[str] = []
    for name in ("make_long_record", "reason_against_long_record"):
        monkeypatch.setattr(long_record, name, lambda *_, **__: made.append("a record"))
    again = kept.read(heard, heard.label)
    assert [sound.wav() for sound in listening.new_sounds(again)] == files
    assert len(files) == 2 and not made


@pytest.mark.parametrize("changes", [(), ("sound.listen_s=6", "sound.q=0.5")])
def test_a_page_that_was_prepared_has_the_same_bytes(
    changes: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Charts and sounds of a run alone are made while others are solved, and not once more."""
    heard = marched(TINY, changes, folder=tmp_path)
    write_run(heard)
    expected = page([read_run(heard, heard.label)])
    kept = KeptRuns(tmp_path)
    first = kept_runs.keep(heard)
    kept.add(heard, first)
    digest = derived.prepare_page(kept.only(heard), heard, heard.label)
    assert digest and digest != first
    kept.exchange(heard, digest)
    (only,) = (tmp_path / folders.PIECES / folders.KEPT).iterdir()
    assert only.name == digest
    prepared = kept.read(heard, heard.label)
    kept.remove()
    drawn: list[str] = []
    exhibit = ball_page.exhibit

    def counted(picture: Picture) -> Chart:
        drawn.append(picture.name)
        return exhibit(picture)

    monkeypatch.setattr(ball_page, "exhibit", counted)
    assert page([prepared]) == expected
    assert "wavelengths" not in drawn and "spectrogram" in drawn


def test_a_page_that_cannot_be_prepared_is_made_at_the_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[str] = []

    def failing(run: Run) -> None:
        asked.append(run.label)
        raise ZeroDivisionError

    monkeypatch.setattr(ball_page, "prepare", failing)
    monkeypatch.setattr(
        "rolling.report.report_page.page", lambda runs, names: f"{len(runs)}".encode()
    )
    monkeypatch.setattr("rolling.figures.write_figures", lambda runs, folder: [])
    scene = tmp_path / "scene.yaml"
    scene.write_text(TINY + LOADS)
    out = tmp_path / "out"
    assert cli.main(["run", str(scene), "--out", str(out), "--workers", "1", "-q"]) == 0
    assert (out / "report.html").read_text() == "3" and len(asked) == 3


class Trap:
    """An object whose pickle runs code where it is read."""

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        return pytest.fail, ("a pickle of a stranger was read",)


@pytest.mark.parametrize("damage", ["another pickle", "a folder", "missing", "a link"])
def test_a_file_that_was_exchanged_is_never_unpickled(
    damage: str, run: Run, tmp_path: Path
) -> None:
    kept = KeptRuns(run.folder)
    digest = kept_runs.keep(run)
    kept.add(run, digest)
    path = run.folder / folders.PIECES / folders.KEPT / digest
    path.unlink()
    if damage == "another pickle":
        path.write_bytes(pickle.dumps(Trap()))
    elif damage == "a folder":
        path.mkdir()
    elif damage == "a link":
        (tmp_path / "trap").write_bytes(pickle.dumps(Trap()))
        path.symlink_to(tmp_path / "trap")
    assert same(kept.read(run, "again").sound, run.sound)
    if damage == "a folder":
        path.rmdir()
    kept.remove()


def test_a_run_for_which_the_disk_has_no_place_is_not_kept(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kept_runs, "MIN_FREE", 1e12)
    assert kept_runs.keep(run) == ""
    monkeypatch.setattr(kept_runs, "MIN_FREE", 20)
    monkeypatch.setattr(kept_runs, "MAX_BYTES", 10)
    assert kept_runs.keep(run) == ""
    assert not (run.folder / folders.PIECES).exists()


class BreakingPool(Pool):
    """Two processes, one of which is killed at a task."""

    teams = MappingProxyType({0: 2})

    def submit(self, task: Task, team: Any = 0) -> Future[Any]:
        """Do the first task, and break at the others."""
        future: Future[Any] = Future()
        if task.key[1] == "0":
            future.set_result(task.function(*task.arguments))
        else:
            future.set_exception(BrokenExecutor())
        return future


def test_the_end_goes_on_here_where_a_process_was_killed(tmp_path: Path) -> None:
    ending = Ending(tmp_path)
    ending.pool = BreakingPool()
    assert ending.each(divmod, [(7, 2), (9, 2), (11, 3)]) == [(3, 1), (4, 1), (3, 2)]
    assert ending.pool is None


def test_pictures_that_a_process_leaves_out_are_told() -> None:
    def draw() -> None:
        warnings.warn("the picture spectrum is left out", PictureWarning, stacklevel=1)

    spent, texts = derived._with_warnings(draw, ())
    assert texts == ["the picture spectrum is left out"]
    assert spent.work_s >= 0
