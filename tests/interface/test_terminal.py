"""A terminal that never leaves one waiting, usage errors, and streams that cost no work."""

from __future__ import annotations

import errno
import io
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from commands import ROOT, wait_for
from scene_text import BALLS

from rolling import cli
from rolling.contact import compiling
from rolling.run import folder as folders
from rolling.scene import library
from rolling.terminal import progress, streams
from rolling.terminal.progress import Level

SCENE = """\
name: tiny
description: Übergröße, µm and 北
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}
surface:
  {kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10, spacing_um: 2, width_um: 128,
   seed: 3}
rolling: {load_n: 0.5, speed_m_s: 0.1, duration_s: 0.004}
"""  # 200 steps
ASCII = {"PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "LC_ALL": "C"}


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "tiny.yaml"
    path.write_text(SCENE, encoding="utf-8")
    return path


def shell(command: str, folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run a command of bash, in which ROLLING stands for the program."""
    environment = {
        "ROLLING": f"{sys.executable} -m rolling",
        "PYTHONPATH": str(ROOT),
        **environment,
    }
    return subprocess.run(
        ["bash", "-c", command],
        capture_output=True,
        text=True,
        cwd=folder,
        env=os.environ | environment,
        timeout=900,
    )


# ---- usage


def test_alone_it_prints_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([]) == 0
    assert "reproduce" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "nearest"),
    [
        (["-q", "resounds"], "resound"),
        (["run", "x.yaml", "--worker-count=2"], "--workers"),
        (["report", "x", "--otu", "y"], "--out"),
    ],
)
def test_misspelt_words_get_the_nearest(words: list[str], nearest: str, capsys) -> None:
    with pytest.raises(SystemExit) as stopped:
        cli.main(words)
    printed = capsys.readouterr().err
    assert stopped.value.code == 2 and f", nearest: {nearest}" in printed


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        cli.main(["--version"])
    assert stopped.value.code == 0 and capsys.readouterr().out.startswith("rolling-contact-noise ")


@pytest.mark.parametrize(
    ("words", "level"),
    [
        (["-q", "schema"], Level.QUIET),
        (["schema", "-v"], Level.VERBOSE),
    ],
)
def test_volume_stands_before_or_after_the_command(
    words: list[str], level: Level, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun: list[Level] = []
    begin = progress.begin
    monkeypatch.setattr(progress, "begin", lambda level: begun.append(level) or begin(level))
    assert cli.main(words) == 0
    assert begun == [level]


@pytest.mark.parametrize(
    "words",
    [["sing"], ["run"], ["run", "x.yaml", "--workers", "0"], ["check", "s", "-q", "-v"]],
)
def test_usage_errors_have_code_2(words: list[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        cli.main(words)
    assert stopped.value.code == 2


def test_schema_is_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["schema"]) == 0
    assert json.loads(capsys.readouterr().out)["$schema"].endswith("2020-12/schema")


def test_scenes_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["scenes"]) == 0
    short = capsys.readouterr().out
    assert "\nquickstart " in short and "lee2025" not in short and "more scenes" in short
    assert cli.main(["scenes", "--all"]) == 0
    names = [line.split()[0] for line in capsys.readouterr().out.splitlines()]
    assert names == list(library.scenes())


def test_check_prints_the_cost_and_quiet_its_warnings(
    scene: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["check", "--fast", "-v", str(scene)]) == 0
    printed = capsys.readouterr().out.lower()
    for word in ("steps", "window", "memory", "time", "hertz", "nyquist"):
        assert word in printed
    assert cli.main(["check", "-q", "--fast", str(scene)]) == 0
    printed = capsys.readouterr()
    assert all(line.startswith("warning: ") for line in printed.out.splitlines())


@pytest.mark.parametrize("name", BALLS[::6])
def test_a_check_fits_on_a_screen(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """The verdict comes first, then at most ten lines of 80 letters on cost and doubts."""
    code = cli.main(["check", name, "--fast"])
    lines = capsys.readouterr().out.splitlines()
    if code == 2:  # its height file is not in this folder
        assert not lines
        return
    assert lines[0].startswith(("It runs in", "It does not run"))
    verdict = next(k for k, line in enumerate(lines) if " of memory and " in line)
    assert len(lines) - verdict <= 10 and max(map(len, lines)) <= 100
    assert lines[-1].startswith("-v shows")


def test_a_check_names_the_largest_doubt_first(
    scene: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rough = ["--set", "surface.roughness_ra_um=2", "--set", "surface.width_um=256"]
    cli.main(["check", "quickstart", "--fast", *rough])
    printed = capsys.readouterr().out
    doubts = [line for line in printed.splitlines() if line.startswith("- ")]
    assert "do not quote" in printed and doubts[0].startswith("- Rms slope")


# ---- refusals


LOADED = """
import sys
from rolling import cli
code = cli.main(sys.argv[1:])
print(code, *sorted(set(sys.modules) & {"numba", "scipy", "h5py", "matplotlib", "tqdm"}))
"""


@pytest.mark.parametrize(
    ("words", "message"),
    [
        *((f"{command} none.yaml", "no such file") for command in ("run", "accuracy", "check")),
        ("run tiny.yaml --set rolling.laod_n=3", "unknown key, nearest: rolling.load_n"),
        ("check tiny.yaml --set rolling.laod_n=3", "unknown key, nearest: rolling.load_n"),
        ("status .", "no run folder"),
    ],
)
def test_a_refusal_needs_no_solver(words: str, message: str, scene: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", LOADED, *words.split()],
        capture_output=True,
        text=True,
        cwd=scene.parent,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        check=False,
    )
    assert done.stdout == "2\n" and message in done.stderr


# ---- streams


class Broken(io.StringIO):
    """A stream whose writing fails."""

    def __init__(self, number: int) -> None:
        super().__init__()
        self.number = number
        self.tries = 0

    def write(self, text: str) -> int:
        self.tries += 1
        raise OSError(self.number, os.strerror(self.number))


@pytest.mark.parametrize(
    ("number", "kept"), [(errno.EPIPE, False), (errno.EIO, False), (errno.ENOSPC, True)]
)
def test_a_broken_stream_is_written_once(number: int, kept: bool) -> None:
    broken = Broken(number)
    stream = streams.LastingStream(broken)
    for _ in range(3):
        print("text", file=stream)
        stream.flush()
    assert broken.tries == 1 and not stream.isatty()
    assert (stream.error is not None) == kept


def test_a_mistake_of_the_program_is_no_broken_stream() -> None:
    with pytest.raises(UnicodeEncodeError):
        print("µ", file=streams.LastingStream(io.TextIOWrapper(io.BytesIO(), "ascii")))


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
def test_text_that_is_lost_to_a_full_disk_fails(scene: Path) -> None:
    done = shell("$ROLLING scenes >/dev/full", scene.parent)
    assert done.returncode == 1 and "standard output: No space left" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    "command",
    [
        "$ROLLING scenes >&-",
        "$ROLLING scenes 2>&-",
        "$ROLLING scenes <&- >&- 2>&-",
        "$ROLLING scenes | true; exit ${PIPESTATUS[0]}",
        "$ROLLING schema | head -1; exit ${PIPESTATUS[0]}",
        "PYTHONIOENCODING=ascii $ROLLING check --fast tiny.yaml",
        "PYTHONUTF8=0 PYTHONCOERCECLOCALE=0 LC_ALL=C $ROLLING check --fast tiny.yaml",
    ],
)
def test_streams_that_are_closed_or_ascii(command: str, scene: Path) -> None:
    done = shell(command, scene.parent)
    assert done.returncode == 0, done.stderr
    # On a slow machine there are lines about long steps.
    assert not re.search("Traceback|Error|ignored", done.stderr)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("redirected", "environment"),
    [("<&- >&- 2>&-", {}), ("2>&1 | true; exit ${PIPESTATUS[0]}", ASCII)],
)
def test_a_run_that_cannot_be_heard_is_done(
    redirected: str, environment: dict[str, str], scene: Path
) -> None:
    command = f"$ROLLING run tiny.yaml --out größe --workers 2 {redirected}"
    done = shell(command, scene.parent, **environment)
    assert done.returncode == 0 and "Traceback" not in done.stderr
    out = scene.parent / "größe"
    assert folders.states(out) == {"größe": ("done", "")} and (out / "report.html").is_file()


@pytest.mark.parametrize("encoding", ["utf-8", "ascii"])
def test_the_terminal_takes_a_folder_of_any_bytes(encoding: str, tmp_path: Path) -> None:
    folder = tmp_path / os.fsdecode(b"none \xff")
    done = subprocess.run(
        [sys.executable, "-m", "rolling", "status", os.fsencode(folder)],
        env=os.environ | {"PYTHONIOENCODING": f"{encoding}:strict"},
        capture_output=True,
        check=False,
    )
    assert done.returncode == 2 and b"Traceback" not in done.stderr
    assert b"\\xff" in done.stderr and b"no run folder" in done.stderr


# ---- lines


def test_a_long_step_says_its_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(progress, "PATIENCE", 0.01)
    said: list[str] = []
    for level, lines in ((Level.NORMAL, ["reading"]), (Level.QUIET, [])):
        with progress.begin(level), progress.step("reading"):
            wait_for(lambda: said.append(capsys.readouterr().err) or len(said) > 3)
        assert "".join(said).splitlines() == lines
        said.clear()
    monkeypatch.setattr(progress, "PATIENCE", 600.0)
    monkeypatch.setattr("time.monotonic", lambda: 7.0)
    with progress.begin(Level.VERBOSE), progress.step("fast"):
        pass
    assert capsys.readouterr().err == "fast: 0.00 s\n"


def test_rounded_shares_do_not_exceed_their_sum() -> None:
    """The sum of n shares of 1/n exceeds 1 for some n, at which tqdm warns."""
    assert max(sum([1 / n] * n) for n in range(2, 40)) > 1
    for n in range(2, 40):
        with progress.Bar(1.0, "solving", True) as bar:
            for _ in range(n + 1):
                bar.update(1 / n)


def test_a_silent_process_shows_no_bar(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A worker is killed at the end, and a lock of tqdm would be reported as leaked then."""
    monkeypatch.setattr(progress, "_commands", [progress._Command()])
    progress.silence()
    monkeypatch.setitem(sys.modules, "tqdm", None)  # an import of it fails
    with progress.Bar(1, "listening", True) as bar:
        bar.update(1)
    assert capsys.readouterr() == ("", "")


def test_a_bar_that_nobody_watches_is_a_line_now_and_then(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = {"now": 7.0}
    monkeypatch.setattr("time.monotonic", lambda: clock["now"])
    monkeypatch.setattr(progress, "LINE_SECONDS", 30.0)
    with progress.begin(Level.NORMAL), progress.Bar(4, "solving") as bar:
        for _ in range(4):
            clock["now"] += 16.0
            bar.update(1)
    assert capsys.readouterr().err.splitlines() == [
        "solving: 50 %, 32 s passed",
        "solving: 100 %, 64 s passed",
    ]
    with progress.begin(Level.QUIET), progress.Bar(4, "solving") as bar:
        clock["now"] += 60.0
        bar.update(4)
    assert not capsys.readouterr().err


def test_compiling_is_said_once_in_a_command(capsys: pytest.CaptureFixture[str]) -> None:
    from numba import njit

    first = njit(lambda x: x + 1)
    second = njit(lambda x: x + 2)
    with progress.begin(Level.NORMAL):
        with compiling.reporting(progress.compiling):
            assert first(1) + first(2) + second(3) == 10
        njit(lambda x: x + 3)(1)
    assert capsys.readouterr().err == f"{progress.COMPILING}\n"
