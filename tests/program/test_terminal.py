"""A terminal that never leaves one waiting, and standard streams that cost no work."""

from __future__ import annotations

import errno
import io
import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from rolling.folders import run_record
from rolling.verification import judge

from rolling import cli
from rolling.contact import compiling
from rolling.terminal import defaults, progress, streams
from rolling.terminal.progress import Level

ROOT = Path(__file__).parents[2]
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


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "tiny.yaml"
    path.write_text(SCENE, encoding="utf-8")
    return path


def shell(command: str, folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run a command of bash, in which ROLLING stands for the program."""
    environment = {
        "ROLLING": f"{sys.executable} -m rolling.cli",
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
# -------------------------------------------------------------------------------------------


def test_alone_it_prints_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([]) == 0
    assert "reproduce" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "nearest"),
    [
        (["rnu", "x.yaml"], "run"),
        (["Check"], "check"),
        (["-q", "resounds"], "resound"),
        (["run", "x.yaml", "--worker-count=2"], "--workers"),
        (["report", "x", "--focre"], "--force"),
    ],
)
def test_misspelt_words_get_the_nearest(words: list[str], nearest: str, capsys) -> None:
    with pytest.raises(SystemExit) as stopped:
        cli.main(words)
    printed = capsys.readouterr().err
    assert stopped.value.code == 2 and f", nearest: {nearest}, allowed: " in printed


def test_a_word_like_no_command_has_no_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        cli.main(["zzz"])
    printed = capsys.readouterr().err
    assert "got zzz, allowed: run, check" in printed and "nearest" not in printed


@pytest.mark.parametrize("option", ["-V", "--version"])
def test_version(option: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        cli.main([option])
    assert stopped.value.code == 0 and capsys.readouterr().out.startswith("rolling-contact-noise ")


@pytest.mark.parametrize(
    ("words", "level"),
    [
        (["check", "s"], Level.NORMAL),
        (["-q", "check", "s"], Level.QUIET),
        (["check", "s", "--quiet"], Level.QUIET),
        (["-v", "check", "s"], Level.VERBOSE),
        (["check", "-v", "s"], Level.VERBOSE),
    ],
)
def test_volume_stands_before_or_after_the_command(words: list[str], level: Level) -> None:
    assert cli._level(cli._parser().parse_args(words)) == level


def test_quiet_and_verbose_exclude_each_other() -> None:
    with pytest.raises(SystemExit) as stopped:
        cli.main(["check", "s", "-q", "-v"])
    assert stopped.value.code == 2


def help_of(command: str, capsys: pytest.CaptureFixture[str]) -> str:
    with pytest.raises(SystemExit):
        cli.main([command, "--help"])
    return re.sub(r"\s+", " ", capsys.readouterr().out)


def test_help_gives_the_numbers_that_are_used(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from rolling.verification import hard_cases, hard_report

    from rolling.accuracy import study
    from rolling.report import page

    text = help_of("accuracy", capsys)
    counts: list[int] = []
    monkeypatch.setattr(
        judge, "judge_all", lambda cases, *numbers: counts.extend(numbers[:4]) or 1 / 0
    )
    with pytest.raises(ZeroDivisionError):
        hard_report.main_report(tmp_path, defaults.RANDOM_SCENES)
    assert sum(counts) == 3500 and f"{sum(counts):,} in all" in text
    assert f"{hard_cases.LONG.steps // 1000},000 steps" in text
    made = study.run_study.__defaults__
    assert made is not None and {defaults.FINEST, defaults.ACCURACY_SECONDS} <= set(made)
    assert f"default {defaults.FINEST})" in text
    assert f"default {defaults.ACCURACY_SECONDS:g}:" in text
    assert f"more than {page.MOST_RUNS} runs" in help_of("run", capsys)
    text = help_of("reproduce", capsys)
    assert f"{defaults.QUICK_SEEDS} surface" in text and f"{defaults.QUICK_SECONDS:g} s" in text
    assert f"{defaults.QUICK_STRIDES} times as long" in text
    assert all(f"{load:g}" in text for load in defaults.QUICK_LOADS_N)


# ---- refusals
# ----------------------------------------------------------------------------------------


LOADED = """
import sys
from rolling import cli
code = cli.main(sys.argv[1:])
print(code, *sorted(set(sys.modules) & {"numpy", "numba", "scipy", "h5py", "matplotlib", "tqdm"}))
"""


@pytest.mark.parametrize(
    ("words", "loaded", "message"),
    [
        *((f"{command} none.yaml", "", "no such file") for command in ("run", "accuracy", "check")),
        ("run tiny.yaml --set rolling.laod_n=3", " numpy", "unknown key, nearest: rolling.load_n"),
        (
            "check tiny.yaml --set rolling.laod_n=3",
            " numpy",
            "unknown key, nearest: rolling.load_n",
        ),
        ("run tiny.yaml --set numerics.step_nodes=64", " numpy", "step_nodes: got 64"),
        ("accuracy tiny.yaml --out .", " numpy", "the working directory"),
    ],
)
def test_what_is_refused_needs_no_solver(
    words: str, loaded: str, message: str, scene: Path
) -> None:
    done = subprocess.run(
        [sys.executable, "-c", LOADED, *words.split()],
        capture_output=True,
        text=True,
        cwd=scene.parent,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )
    assert done.stdout == f"2{loaded}\n" and message in done.stderr


@pytest.mark.parametrize("command", ["resume", "resound", "report"])
def test_a_folder_of_no_run_is_refused_without_a_solver(command: str, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", LOADED, command, str(tmp_path)],
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )
    words = done.stdout.split()
    assert words[0] == "2" and "numba" not in words and "scipy" not in words
    assert "not a run folder" in done.stderr


# ---- streams
# -----------------------------------------------------------------------------------------


class Broken(io.StringIO):
    """A stream whose writing fails."""

    def __init__(self, number: int) -> None:
        super().__init__()
        self.number, self.tries = number, 0

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
    done = shell("$ROLLING check --fast tiny.yaml >/dev/full", scene.parent)
    assert done.returncode == 1 and "standard output: No space left" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    "command",
    [
        "$ROLLING check --fast tiny.yaml >&-",
        "$ROLLING check --fast tiny.yaml 2>&-",
        "$ROLLING check --fast tiny.yaml <&- >&- 2>&-",
        "$ROLLING check --fast tiny.yaml | true; exit ${PIPESTATUS[0]}",
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
    [
        ("<&- >&- 2>&-", {}),
        ("| true; exit ${PIPESTATUS[0]}", {}),
        ("2>&1 | true; exit ${PIPESTATUS[0]}", {}),
        ("", {"PYTHONIOENCODING": "ascii"}),
        ("", {"PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "LC_ALL": "C"}),
    ],
)
def test_a_run_that_cannot_be_heard_is_done(
    redirected: str, environment: dict[str, str], scene: Path
) -> None:
    command = f"$ROLLING run tiny.yaml --out größe --workers 2 {redirected}"
    done = shell(command, scene.parent, **environment)
    assert done.returncode == 0 and "Traceback" not in done.stderr
    record = run_record.read(scene.parent / "größe")
    assert record is not None and record.state == "done"
    assert (scene.parent / "größe" / "report.html").is_file()


# ---- lines
# -------------------------------------------------------------------------------------------


def test_a_long_step_says_its_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Timers of the program go off when the test says that it is time."""
    timers: list[Timer] = []

    class Timer:
        def __init__(self, seconds: float, act: Callable, words: tuple) -> None:
            assert seconds == progress.PATIENCE
            self.act = lambda: act(*words)
            timers.append(self)

        def start(self) -> None:
            pass

        def cancel(self) -> None:
            self.act = lambda: None

    monkeypatch.setattr(progress.threading, "Timer", Timer)
    for level, said in ((Level.NORMAL, "reading\n"), (Level.QUIET, "")):
        with progress.begin(level):
            with progress.step("reading"):
                for timer in timers:
                    timer.act()
            with progress.step("fast"):
                pass
        for timer in timers:
            timer.act()
        assert capsys.readouterr().err == said
        timers.clear()
    with progress.step("in a program of somebody else"):
        assert not timers
    monkeypatch.setattr("time.monotonic", lambda: 7.0)
    with progress.begin(Level.VERBOSE), progress.step("fast"):
        pass
    assert capsys.readouterr().err == "fast: 0.00 s\n"


def test_rounded_shares_do_not_exceed_their_sum() -> None:
    """The sum of n shares of 1/n exceeds 1 for some n, at which tqdm warns."""
    assert max(sum([1 / n] * n) for n in range(2, 40)) > 1
    for n in range(2, 40):
        with progress.bar(1.0, "solving", True) as bar:
            for _ in range(n + 1):
                bar.update(1 / n)


def test_a_bar_that_nobody_watches_is_a_line_now_and_then(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(progress, "FIRST_LINE", 0.0)
    monkeypatch.setattr("time.monotonic", lambda: 7.0)
    with progress.begin(Level.NORMAL), progress.bar(4, "solving") as bar:
        for _ in range(4):
            bar.update(1)
    assert capsys.readouterr().err == "solving: 25 %, 0:00 passed, 0:00 left\n"
    for level in (Level.QUIET, None):  # None: a program of somebody else
        before = progress._voice.level
        progress._voice.level = level
        with progress.bar(4, "solving") as bar:
            bar.update(4)
        progress._voice.level = before
    assert not capsys.readouterr().err


def test_time_left_is_told_once_it_can_be_foreseen(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first task includes compilation, and its share would tell hours for minutes."""
    clock = {"now": 0.0}
    monkeypatch.setattr("time.monotonic", lambda: clock["now"])
    monkeypatch.setattr(progress, "FIRST_LINE", 5.0)
    with progress.begin(Level.NORMAL), progress.bar(1, "solving") as bar:
        for now, share in ((36.0, 0.002), (90.0, 0.448)):
            clock["now"] = now
            bar.update(share)
    lines = capsys.readouterr().err.splitlines()
    assert lines == ["solving: 0 %, 0:36 passed", "solving: 45 %, 1:30 passed, 1:50 left"]


def test_compiling_is_said_once_in_a_command(capsys: pytest.CaptureFixture[str]) -> None:
    from numba import njit

    first, second = njit(lambda x: x + 1), njit(lambda x: x + 2)
    with progress.begin(Level.NORMAL):
        with compiling.told(progress.compiling):
            assert first(1) + first(2) + second(3) == 10
        njit(lambda x: x + 3)(1)
    assert capsys.readouterr().err == f"{progress.COMPILING}\n"


# ---- commands
# ----------------------------------------------------------------------------------------


def files_of(folder: Path) -> dict[str, tuple[int, bytes]]:
    """Return time and content of all files of a folder by name."""
    files = (path for path in folder.rglob("*") if path.is_file())
    return {str(path): (path.stat().st_mtime_ns, path.read_bytes()) for path in files}


def test_quiet_prints_the_folder_and_a_finished_run_is_left_alone(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    command = ["run", str(scene), "--out", str(out), "--workers", "1", "--no-report"]
    assert cli.main([*command, "-q"]) == 0
    assert capsys.readouterr() == (f"{out}\n", "")
    before = files_of(out)
    assert cli.main(["resume", str(out)]) == 0
    printed = capsys.readouterr()
    assert f"{out}: finished " in printed.err and "nothing to resume" in printed.err
    assert "dB(A)" in printed.out and str(out / "listen.wav") in printed.out
    assert f"`rolling report {out}` makes one" in printed.out and "too many" not in printed.out
    assert files_of(out) == before
    (out / "result.h5").unlink()  # then there is something to resume
    assert cli.main(["resume", str(out), "-v", "--no-report"]) == 0
    printed = capsys.readouterr()
    for words in ("1 pieces of 1 runs", "iterations per state", "window ", "steps solved"):
        assert words in printed.err
    assert cli.main(["check", "-q", "--fast", str(scene)]) == 0
    printed = capsys.readouterr()
    assert all(line.startswith("warning: ") for line in printed.out.splitlines())
    assert not printed.err


def test_the_last_run_that_is_resumed_finishes_its_sweep(
    scene: Path, tmp_path: Path, undrawn: None, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    command = ["run", str(scene), "--set", "sweep.rolling.load_n=[0.3, 0.5]", "--out", str(out)]
    assert cli.main([*command, "--workers", "1", "--no-report"]) == 0
    for folder in (out, out / "load_n=0.5"):
        record = run_record.read(folder)
        assert record is not None
        run_record.write(folder, record.with_state("waiting", "interrupted"))
    (out / "load_n=0.5" / "result.h5").unlink()
    (out / "sweep.json").unlink()
    capsys.readouterr()
    assert cli.main(["resume", str(out / "load_n=0.5"), "--workers", "1", "--no-report"]) == 0
    record = run_record.read(out)
    assert record is not None and record.state == "done"
    table = json.loads((out / "sweep.json").read_text())
    assert [row["folder"] for row in table] == ["load_n=0.3", "load_n=0.5"]
    assert f"the last run of {out}" in capsys.readouterr().err
