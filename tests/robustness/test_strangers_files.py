"""Files and links that a stranger leaves in a folder reach nothing outside it and run nothing."""

from __future__ import annotations

import os
import re
import shutil
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from commands import ROOT, words_of
from finished import run_of
from scene_text import TINY

from rolling import cli, open_run
from rolling.kinds.reading import read_scene
from rolling.marches.piece import contact_identity
from rolling.results.run_result import write_run
from rolling.scene.file import loads
from rolling.scene.messages import SceneError
from rolling.terminal.whole_files import FolderError, write_bytes

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no pipes and links on Windows")


def test_a_guessed_temporary_name_leads_nowhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("secrets.token_hex", lambda count: "0" * 2 * count)
    victim = tmp_path / "victim"
    victim.write_text("precious")
    (tmp_path / f".report.html.{'0' * 16}.partial").symlink_to(victim)
    with pytest.raises(FileExistsError):
        write_bytes(tmp_path / "report.html", b"page")
    assert victim.read_text() == "precious"
    assert not (tmp_path / "report.html").exists()


def test_files_are_written_by_one_function() -> None:
    """Two others open files: the null device, and a new copy of a scene, which replaces nothing."""
    writing = re.compile(
        r"""write_text\(|\w\.write_bytes\(|(?<!fd)open\(.*["'][wax]b?["']|to_csv\(\w*path"""
    )
    others = {
        path.name
        for path in (ROOT / "rolling").rglob("*.py")
        if writing.search(path.read_text().replace("files.write_bytes(", ""))
    }
    assert others == {"streams.py", "library.py"}


def test_a_written_file_has_the_permissions_of_the_umask(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        write_bytes(tmp_path / "a", b"")
    finally:
        os.umask(before)
    assert (tmp_path / "a").stat().st_mode & 0o777 == 0o640


SEEDS = TINY + "sweep: {surface.seed: [1, 2]}\n"
COMMANDS = (["status"], ["table"], ["plot"], ["listen"], ["report"], ["resound", "-q"])


def place(kind: str, path: Path, victim: Path) -> None:
    """Put something else than a file of its own at a path."""
    path.unlink(missing_ok=True)
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "socket":
        with socket.socket(socket.AF_UNIX) as server:
            server.bind(os.path.relpath(path))  # whose length is limited
    elif kind == "folder":
        path.mkdir()
    elif kind == "zeros":
        path.symlink_to("/dev/zero")
    elif kind == "link":
        path.symlink_to(victim)
    else:
        path.hardlink_to(victim)


@pytest.fixture(scope="module")
def half(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder in which the first of two runs is done."""
    folder = tmp_path_factory.mktemp("half")
    (folder / "scene.yaml").write_text(SEEDS)
    words = words_of(folder / "scene.yaml", folder / "out", "--workers", "1", "--part", "1/2")
    assert cli.main(words) == 0
    return folder


@pytest.fixture
def out(half: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Return a copy of the folder; a command that waits for a pipe ends after 60 s."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "victim").write_text("precious")
    shutil.copytree(half, tmp_path, dirs_exist_ok=True)
    before = signal.signal(signal.SIGALRM, lambda *_: pytest.fail("a command hangs"))
    signal.alarm(60)
    yield tmp_path / "out"
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)
    assert (tmp_path / "victim").read_text() == "precious"


KINDS = ("pipe", "socket", "folder", "zeros", "link", "hard link")


@pytest.mark.parametrize("kind", KINDS)
def test_a_scene_that_is_no_file_is_refused(kind: str, out: Path) -> None:
    place(kind, out / "scene.yaml", out.parent / "victim")
    for words in COMMANDS:
        assert cli.main([*words, str(out)]) == 2
    assert cli.main(words_of(out.parent / "scene.yaml", out, "--workers", "1")) == 2


@pytest.mark.parametrize("kind", KINDS)
def test_whatever_stands_at_the_names_of_files_is_replaced_or_refused(
    kind: str, out: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (out / "seed=2").mkdir()
    names = ("result.h5", "summary.json", "signal.wav", "listen.wav", "failed.json")
    for path in (
        *(out / "seed=2" / name for name in names),
        out / "runs.csv",
        out / ".lock-1-of-2",
    ):
        place(kind, path, out.parent / "victim")
    cli.main(["status", str(out)])
    code = cli.main(words_of(out.parent / "scene.yaml", out, "--workers", "1"))
    said = capsys.readouterr().err
    # A folder is not replaced, and a regular file that holds no summary is not taken for one.
    expected = {"folder": 1, "link": 2, "hard link": 2}.get(kind, 0)
    assert code == expected, said
    assert code != 2 or "summary.json: not readable" in said
    assert kind != "folder" or "Is a directory" in said


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ["seed=1/summary.json", "seed=1/result.h5", ".lock"])
def test_whatever_is_read_ends_in_a_sentence(kind: str, name: str, out: Path) -> None:
    place(kind, out / name, out.parent / "victim")
    assert all(cli.main([*words, str(out)]) in (0, 2) for words in COMMANDS[:4])


@pytest.mark.parametrize("name", ["seed=2", "pieces", "pieces/identity", "seed=1/figures"])
@pytest.mark.parametrize("dangling", [True, False])
def test_no_folder_that_is_a_link_is_written(
    name: str, dangling: bool, out: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    elsewhere = out.parent / "elsewhere"
    single = loads(TINY, ["surface.seed=2"])
    path = out / name.replace("identity", contact_identity(single)[:16])
    path.parent.mkdir(exist_ok=True)
    path.symlink_to(elsewhere)
    if not dangling:
        elsewhere.mkdir()
    if name == "seed=1/figures":
        assert cli.main(["plot", str(out / "seed=1"), "--figure", "spectrum"]) == 2
    else:
        assert cli.main(words_of(out.parent / "scene.yaml", out, "--workers", "1")) == 2
    assert "a link" in capsys.readouterr().err
    assert not elsewhere.exists() if dangling else not [*elsewhere.iterdir()]


@pytest.mark.parametrize("kind", ["pipe", "zeros", "hard link"])
def test_a_study_that_is_no_file_of_its_own_is_refused(kind: str, out: Path) -> None:
    (out.parent / "study").mkdir()
    place(kind, out.parent / "study" / "accuracy.nc", out.parent / "victim")
    assert cli.main(["accuracy", str(out.parent / "scene.yaml"), "--out", "study"]) == 2


def test_the_run_folder_itself_may_be_a_link(out: Path) -> None:
    out.rename(out.parent / "real")
    out.symlink_to("real")
    assert cli.main(words_of(out.parent / "scene.yaml", out, "--workers", "1")) == 0


def test_a_folder_that_becomes_a_link_is_not_written(tmp_path: Path) -> None:
    """The check comes with each writing, not at the start of the command alone."""
    run = replace(run_of(loads(TINY), tmp_path / "out" / "seed=1"), values={"surface.seed": 1})
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "out").mkdir()
    run.folder.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(FolderError, match="a link"):
        write_run(run)
    assert not [*(tmp_path / "elsewhere").iterdir()]


@pytest.mark.slow
def test_workers_import_nothing_from_the_working_directory(tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_text(SEEDS)
    for name in ("pickle", "numpy", "struct", "multiprocessing"):
        (tmp_path / f"{name}.py").write_text("open('hijacked', 'a').close(); raise SystemExit(1)")
    program = (
        tmp_path / "bin" / "program.py"
    )  # as the console script, which is no part of the folder
    program.parent.mkdir()
    program.write_text("from rolling.cli import main\nraise SystemExit(main())\n")
    command = [sys.executable, program, "run", "scene.yaml", "--out", "out", "--workers", "2"]
    done = subprocess.run(
        [*command, "--no-report"], cwd=tmp_path, capture_output=True, text=True, timeout=300
    )
    assert not (tmp_path / "hijacked").exists(), done.stderr
    assert done.returncode == 0, done.stderr


STEERING = "\x1b]0;stolen\x07\x1b[31m\u202e\x9b2J"
AS_YAML = "\\e]0;stolen\\a\\e[31m\\u202e\\x9b2J"
PLACES_OF_A_TEXT = {
    "duplicate key": f'"{AS_YAML}": 1\n"{AS_YAML}": 2\n',
    "duplicate value": f'name: x\nname: "{AS_YAML}"\n',
    "unknown key": TINY + f'"{AS_YAML}": 1\n',
    "name": TINY.replace("name: ", f'name: "{AS_YAML}" #', 1),
    "title": TINY + f'title: "{AS_YAML}"\nplate: 3\n',
    "word": TINY.replace("kind: gaussian", f'kind: "{AS_YAML}"'),
    "swept label": TINY + f'sweep: {{rolling: {{"{AS_YAML}": {{load_n: -1}}}}}}\n',
    "tag": TINY + f"title: !{AS_YAML.replace(' ', '')} x\n",
    "anchor": "a: *nobody\x85\n",
    "path": TINY.replace("kind: gaussian", f'kind: file, path: "{AS_YAML}.npy", x: 1'),
}


def steers(text: str) -> list[str]:
    """Return the letters of a text that steer a terminal."""
    return [letter for letter in text if not letter.isprintable() and letter not in "\n\t"]


@pytest.mark.parametrize("place", PLACES_OF_A_TEXT)
def test_no_text_of_a_scene_steers_the_terminal(
    place: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(PLACES_OF_A_TEXT[place], encoding="utf-8")
    for command in ("check", "run", "surface"):
        assert cli.main([command, str(path)]) == 2
        said = capsys.readouterr()
        assert not steers(said.out + said.err), command
    with pytest.raises(SceneError) as error:
        read_scene(path)
    assert not steers(str(error.value))


def test_no_name_of_a_file_steers_the_terminal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / f"a{STEERING}"
    path.mkdir()
    (path / "scene.yaml").write_text(STEERING)
    words = ["status", "report", "listen", "gallery", "table", "plot", "check", "surface"]
    for command in words:
        for file in (path, path / "scene.yaml", path / "none.csv"):
            assert cli.main([command, str(file)]) == 2
            said = capsys.readouterr()
            assert not steers(said.out + said.err), command
    with pytest.raises(FolderError) as error:
        open_run(path)
    assert not steers(str(error.value))


# ---- pipes, devices and files without an end that are named on the command line


@pytest.mark.parametrize(
    "words",
    [
        ["validate", "impact", "--out"],
        ["surface", "quickstart", "--out"],
        ["surface", "quickstart", "--save"],
        ["run", "quickstart", "--out"],
        ["report", "out", "--out"],
        ["gallery", "out", "--out"],
        ["plot", "out", "--out"],
        ["resound", "out", "--out"],
        ["choose", "quickstart", "quickstart", "--out"],
        ["accuracy", "quickstart", "--out"],
        ["reproduce", "lee2025", "--out"],
        ["compare", "out"],
        ["surface"],
        ["check"],
        ["validate", "--bench"],
    ],
    ids=" ".join,
)
@pytest.mark.parametrize("kind", ["pipe", "zeros"])
def test_a_pipe_or_a_device_is_refused_at_once(
    kind: str, words: list[str], out: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    place(kind, out.parent / "odd", out.parent / "victim")
    with pytest.raises(SystemExit, match="2"):
        cli.main([*words, "odd"])
    said = capsys.readouterr().err
    assert f"got 'odd', a {'pipe' if kind == 'pipe' else 'device'}; allowed: a regular" in said


@pytest.mark.parametrize("kind", ["pipe", "zeros", "endless"])
def test_whatever_stands_at_the_target_of_a_study_is_not_read(kind: str, out: Path) -> None:
    from rolling.studies.validate import validate

    page = out.parent / "page.md"
    if kind == "endless":
        page.touch()
        os.truncate(page, 60 * 2**30)  # sparse
    else:
        place(kind, page, out.parent / "victim")
    with pytest.raises(FolderError, match="exists and is no page of validation"):
        validate(["impact"], page)


@pytest.mark.parametrize("kind", ["pipe", "zeros", "endless"])
def test_whatever_stands_at_the_files_of_a_surface_is_not_read(kind: str, out: Path) -> None:
    folder = out.parent / "described"
    folder.mkdir()
    if kind == "endless":
        (folder / "surface.csv").touch()
        os.truncate(folder / "surface.csv", 60 * 2**30)
    else:
        place(kind, folder / "surface.csv", out.parent / "victim")
    assert cli.main(["surface", str(out.parent / "scene.yaml"), "--out", str(folder)]) == 2


def test_a_pipe_is_no_scheduler_file(out: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("distributed")
    place("pipe", out.parent / "scheduler.json", out.parent / "victim")
    words = words_of(out.parent / "scene.yaml", out.parent / "new", "--cluster", "scheduler.json")
    assert cli.main(words) == 2
    assert "no scheduler answers" in capsys.readouterr().err
