"""Folders that hold something else, or that are written badly: a sentence each, nothing lost."""

from __future__ import annotations

import errno
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from commands import (
    PATIENCE,
    SWEEP,
    contents,
    pieces,
    started,
    tree,
    wait_for,
    words_of,
)
from hostile_npz import strange
from scene_text import TINY

from rolling import cli, open_run
from rolling.run import folder as folders
from rolling.run import solving, worker
from rolling.terminal import program
from rolling.terminal.whole_files import FolderError

SEEDS = TINY + "sweep: {surface.seed: [1, 2, 3]}\n"


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.yaml"
    path.write_text(TINY)
    return path


@pytest.fixture
def seeds(scene: Path) -> Path:
    scene.write_text(SEEDS)
    return scene


def run(scene: Path, out: Path, *more: str) -> int:
    return cli.main(words_of(scene, out, "--workers", "1", *more))


# ---- two commands


@pytest.mark.slow
def test_a_second_command_is_refused_and_status_only_looks(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = tmp_path / "scene.yaml"
    out = tmp_path / "out"
    scene.write_text(SWEEP)
    with started(words_of(scene, out, "--workers", "1"), tmp_path) as first:
        wait_for(lambda: pieces(out))
        first.send_signal(signal.SIGSTOP)
        for part in ((), ("--part", "1/2")):
            assert run(scene, out, *part) == 2
            said = capsys.readouterr().err
            assert "another command works on it" in said and ".lock" in said
        assert cli.main(["status", str(out)]) == 0 and "2 running" in capsys.readouterr().out
        first.send_signal(signal.SIGCONT)
        assert first.wait(PATIENCE) == 0
    assert not [path for path in out.iterdir() if path.name.startswith(".")]
    assert cli.main(["status", str(out)]) == 0 and "2 done" in capsys.readouterr().out


def test_parts_work_side_by_side_and_not_twice(seeds: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert run(seeds, out, "--part", "2/2") == 0
    half = out / ".scene.yaml.0123456789abcdef.partial"
    half.write_text("which the other part renames in a moment")
    with folders.locked(out, (1, 2)):
        assert run(seeds, out, "--part", "1/2") == 2
        assert run(seeds, out) == 2
        assert run(seeds, out, "--part", "2/2") == 0
        assert folders.states(out)["seed=1"][0] == "running"
        assert half.is_file()
    assert run(seeds, out, "--part", "1/2") == 0
    assert (out / "runs.csv").is_file()


def test_the_lock_of_a_dead_command_holds_nobody(scene: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / ".lock").touch()  # as a kill leaves it
    assert run(scene, out) == 0 and not (out / ".lock").exists()


def test_a_lock_that_is_a_link_reaches_no_other_file(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    victim = tmp_path / "victim"
    out = tmp_path / "out"
    victim.write_text("precious")
    out.mkdir()
    (out / ".lock").symlink_to(victim)
    assert run(scene, out) == 2
    assert "cannot be written" in capsys.readouterr().err and victim.read_text() == "precious"


# ---- foreign folders


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("thesis.txt", "it holds thesis.txt"),
        ("scene.yaml", "its scene.yaml is not that of a run folder"),
        ("run.json", "it holds run.json"),
    ],
)
def test_a_foreign_folder_is_refused_and_left_as_it_was(
    name: str, words: str, scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / name).write_text(TINY)
    before = tree(out)
    for command in (words_of(scene, out), ["status", str(out)], ["resound", str(out)]):
        assert cli.main(command) == 2
        assert words in capsys.readouterr().err
    assert run(scene, out) == 2 and f"{out}-2" in capsys.readouterr().err  # a free name
    assert tree(out) == before


def test_another_scene_is_refused_with_its_differences(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert run(scene, out) == 0
    before = tree(out)
    assert run(scene, out, "--set", "rolling.load_n=0.006") == 2
    said = capsys.readouterr().err
    assert "rolling.load_n: got 0.006, has 0.005" in said and f"{out}-2" in said
    stored = out / "scene.yaml"
    stored.write_text(stored.read_text().replace("0.005", "0.006"))  # an edited scene
    assert run(scene, out) == 2
    assert "rolling.load_n: got 0.005, has 0.006" in capsys.readouterr().err
    with pytest.raises(FolderError, match="another scene"):
        open_run(out)
    stored.write_text(f"{folders.MARK}\nname: [")
    assert run(scene, out) == 2 and "scene.yaml" in capsys.readouterr().err
    stored.write_bytes(before["scene.yaml"].encode())
    assert run(scene, out) == 0 and tree(out) == before


@pytest.mark.slow
def test_runs_of_another_program_are_not_added_to(
    seeds: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The digest of the sources stands in the scene and in the provenance of each run."""
    out = tmp_path / "out"
    assert run(seeds, out, "--part", "1/3") == 0
    stored = out / "scene.yaml"
    sources = program.identity().sources
    summary = json.loads((out / "seed=1" / "summary.json").read_text())
    assert summary["provenance"]["sources"] == sources
    own = stored.read_text()
    edited = own.replace(sources[:12], "0123456789ab")
    assert edited != own
    stored.write_text(edited)
    before = tree(out)
    for more in ([], ["--part", "2/3"], ["--set", "sweep.surface.seed=[1, 2, 3, 4]"]):
        assert run(seeds, out, *more) == 2
        said = capsys.readouterr().err
        assert "sources 0123456789ab, and this is" in said and "take another --out" in said
    assert tree(out) == before
    stored.write_text(own)
    assert run(seeds, out) == 0
    stored.write_text(edited)
    assert run(seeds, out) == 0  # all is done, and nothing is added
    assert (
        cli.main(
            [
                "resound",
                str(out),
                "--no-report",
                "--set",
                "sound.distance_m=2",
                "--out",
                str(tmp_path / "x"),
            ]
        )
        == 0
    )
    assert "marched by version" in capsys.readouterr().err


def test_edited_heights_are_not_taken_for_the_solved_ones(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    heights = np.random.default_rng(1).standard_normal((40, 60)) * 2e-8
    np.save(tmp_path / "z.npy", heights)
    head, _, tail = TINY.partition("surface:")
    rest = tail[tail.index("rolling:") :]
    scene.write_text(f"{head}surface: {{kind: file, path: z.npy, spacing_um: 2}}\n{rest}")
    out = tmp_path / "out"
    assert run(scene, out) == 0
    before = contents(out)
    np.save(tmp_path / "z.npy", 2 * heights)
    assert run(scene, out) == 2
    assert "another scene or surface" in capsys.readouterr().err
    assert contents(out) == before


# ---- files that are damaged


@pytest.mark.parametrize(
    "damage", [b"", b"PK\x03\x04 half", "flipped"], ids=["empty", "half", "bit"]
)
def test_a_damaged_piece_is_marched_again(damage: bytes | str, scene: Path, tmp_path: Path) -> None:
    from rolling.kinds.reading import read_scene
    from rolling.marches.next_pieces import next_pieces
    from rolling.marches.result import Result

    single = read_scene(scene)
    (piece,) = next_pieces(single, Result.empty(single))
    expected = worker.solve_piece(piece, tmp_path)
    path = worker.piece_path(tmp_path, piece)
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(bytes(content) if damage == "flipped" else damage)
    assert worker.read_piece(tmp_path, piece) is None
    again = worker.solve_piece(piece, tmp_path)
    assert isinstance(expected, dict) and isinstance(again, dict)
    for name, values in expected.items():
        if name not in ("step_time", "effort"):
            np.testing.assert_array_equal(again[name], values)
    assert worker.read_piece(tmp_path, piece) is not None


def test_a_strange_piece_is_not_read(scene: Path, tmp_path: Path) -> None:
    """Names, types and shapes are judged first: one that states a terabyte is marched again."""
    from rolling.kinds.reading import read_scene
    from rolling.marches.next_pieces import next_pieces
    from rolling.marches.result import Result

    single = read_scene(scene)
    (piece,) = next_pieces(single, Result.empty(single))
    worker.solve_piece(piece, tmp_path)
    path = worker.piece_path(tmp_path, piece)
    content = path.read_bytes()
    for name, change in strange("approach").items():
        path.write_bytes(change(content))
        assert worker.read_piece(tmp_path, piece) is None, name
    path.write_bytes(content)
    assert worker.read_piece(tmp_path, piece) is not None


def test_a_piece_is_read_in_little_memory_or_not_at_all(
    scene: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A read makes room for the bytes that the file has, not for all that it may have."""
    from rolling.kinds.reading import read_scene
    from rolling.marches.next_pieces import next_pieces
    from rolling.marches.result import Result
    from rolling.terminal import whole_files

    single = read_scene(scene)
    (piece,) = next_pieces(single, Result.empty(single))
    worker.solve_piece(piece, tmp_path)
    path = worker.piece_path(tmp_path, piece)
    asked = []

    class Reader(whole_files.io.BufferedReader):
        def read(self, size: int | None = -1) -> bytes:
            asked.append(size)
            return super().read(size)

    monkeypatch.setattr(whole_files.io, "BufferedReader", Reader)
    assert worker.read_piece(tmp_path, piece) is not None
    assert max(asked) == path.stat().st_size + 1

    def exhausted(*_: object) -> bytes:
        raise MemoryError

    monkeypatch.setattr(worker, "read_regular", exhausted)
    with pytest.raises(MemoryError):  # a whole piece is no damaged one
        worker.read_piece(tmp_path, piece)


def test_little_memory_ends_in_a_sentence(
    scene: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def exhausted(*_: object, **__: object) -> int:
        raise MemoryError

    monkeypatch.setattr("rolling.commands.surface.surface", exhausted)
    assert cli.main(["surface", str(scene)]) == 1
    assert "not enough memory" in capsys.readouterr().err


def test_a_table_from_the_future_is_written_again(scene: Path, tmp_path: Path) -> None:
    """A clock was set back, or a shared folder has two."""
    out = tmp_path / "out"
    load = "sweep.rolling.load_n=[0.005, 0.01]"
    assert run(scene, out, "--set", load) == 0
    later = (out / "runs.csv").stat().st_mtime + 3600
    os.utime(out / "runs.csv", (later, later))
    assert run(scene, out, "--set", load.replace("]", ", 0.02]")) == 0
    assert "load_n=0.02" in (out / "runs.csv").read_text()


def test_a_folder_that_was_removed_meanwhile_is_whole_again(
    scene: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"

    def removed(*arguments: object) -> dict[str, str]:
        shutil.rmtree(out)
        out.mkdir()
        return {}

    monkeypatch.setattr(solving, "_solve_lacking", removed)
    run(scene, out)
    monkeypatch.undo()
    assert run(scene, out) == 0 and open_run(out).numbers.record.steps


# ---- disks


@pytest.mark.slow
def test_a_file_that_may_grow_no_more_is_a_full_disk(seeds: Path, tmp_path: Path) -> None:
    """A real limit of the system, in the workers too."""
    out = tmp_path / "out"
    limit = (20_000, resource.RLIM_INFINITY)
    done = subprocess.run(
        [sys.executable, "-m", "rolling", *words_of(seeds, out, "--workers", "2")],
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, limit),
        capture_output=True,
        text=True,
        cwd=tmp_path,
        check=False,
    )
    assert done.returncode == 1 and "Traceback" not in done.stderr, done.stderr
    assert "File too large" in done.stderr
    assert run(seeds, out) == 0


def test_a_run_whose_folder_cannot_be_written_fails_alone(
    seeds: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    out.mkdir()
    assert run(seeds, out, "--part", "1/3") == 0
    (out / "seed=2").write_text("no folder")
    assert run(seeds, out) == 1
    assert "failed: seed 2: " in capsys.readouterr().err
    assert [state for state, _ in folders.states(out).values()] == ["done", "waiting", "done"]


def test_a_folder_below_a_file_is_refused(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("mine")
    with pytest.raises(SystemExit, match="2"):
        run(scene, tmp_path / "file" / "out")
    assert "file/out', but " in (message := capsys.readouterr().err)
    assert message.endswith("file' is a file\n")
    assert (tmp_path / "file").read_text() == "mine"


# ---- errors of the system


COMMANDS_OF_A_FOLDER = ("status", "report", "listen", "gallery", "table", "plot", "resound")


def refused(words: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """Return what a command says that is refused as bad input, without a number of the system."""
    assert cli.main(words) == 2
    said = capsys.readouterr().err
    assert "Traceback" not in said and "[Errno" not in said
    return said


@pytest.mark.parametrize("kind", ["dangling", "loop", "long", "file", "below a missing link"])
def test_a_path_that_cannot_become_a_folder_is_named(
    kind: str, scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = named = tmp_path / "out"
    if kind == "dangling":
        out.symlink_to(tmp_path / "nowhere")
    elif kind == "loop":
        out.symlink_to(out)
    elif kind == "long":
        out = named = tmp_path / ("x" * 300)
    elif kind == "file":
        out.touch()
    else:
        named = tmp_path / "link"
        named.symlink_to(tmp_path / "nowhere")
        out = named / "out"
    words = words_of(scene, out, "--workers", "1")
    assert str(named) in refused(words, capsys)
    before = tree(tmp_path)
    for command in COMMANDS_OF_A_FOLDER:
        more = ["--set", "sound.distance_m=2"] if command == "resound" else []
        assert str(out) in refused([command, str(out), *more], capsys), command
    for command in ("check", "surface"):
        assert str(out) in refused([command, str(out)], capsys), command
    assert tree(tmp_path) == before


@pytest.mark.parametrize("number", [errno.EACCES, errno.EROFS, errno.EPERM])
def test_a_folder_above_that_refuses_is_named(
    number: int,
    scene: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The system is replaced, because root may write whatever is read-only."""

    def refuse(self: Path, *arguments: object, **keywords: object) -> None:
        raise OSError(number, os.strerror(number), str(self))

    monkeypatch.setattr(Path, "mkdir", refuse)
    out = tmp_path / "out"
    said = refused(words_of(scene, out, "--workers", "1"), capsys)
    assert str(out) in said and os.strerror(number) in said
    said = refused(["surface", str(scene), "--out", str(out)], capsys)
    assert str(out) in said


def test_a_scene_that_may_not_be_read_is_named(
    scene: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    own = os.open

    def refuse(path: str, *arguments: int, **keywords: int) -> int:
        if Path(path) == scene:
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))
        return own(path, *arguments, **keywords)

    monkeypatch.setattr(os, "open", refuse)
    for command in ("check", "run", "surface"):
        assert str(scene) in refused([command, str(scene)], capsys), command


def test_a_working_folder_that_was_deleted_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    for words in (["run", "quickstart", "-q"], ["status", "."], ["check", "quickstart", "--fast"]):
        assert "working folder was deleted" in refused(words, capsys)


@pytest.mark.parametrize(
    ("override", "code"),
    [("rolling.load_n=1e7", 1), ("surface.width_um=1e9", 2), ("rolling.load_n=0.3", 0)],
)
def test_check_says_by_its_code_that_a_scene_does_not_run(
    override: str, code: int, scene: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A load above the capacity has no solution, and a surface beyond the memory is bad input."""
    assert cli.main(["check", str(scene), "--fast", "--set", override]) == code
    said = capsys.readouterr().out
    assert ("It does not run" in said) == (code != 0)


def test_a_figure_that_there_is_not_leaves_no_folder(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert run(scene, out) == 0
    for name, word in (("nosuch", "no figure"), ("levels", "no such figure")):
        assert cli.main(["plot", str(out), "--figure", name]) == 2
        assert word in capsys.readouterr().err
        assert not (out / "figures").exists()
