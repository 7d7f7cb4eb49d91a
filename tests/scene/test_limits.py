"""A scene that cannot fit is refused by measured numbers, before anything is written."""

from __future__ import annotations

import math
import os
import shutil
import subprocess
import sys
import threading
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from scene_text import PLAIN, TEXT, faults

from rolling import cli, commands
from rolling.check import cost, demand, findings, machine, refusals
from rolling.report import page
from rolling.scene import file as scene_file
from rolling.scene import yaml_text
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.scene.sections import Rolling
from rolling.simulation import simulate

STEEL = (
    "sphere: {radius_mm: 5}\n"
    "plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}\n"
)
MADE = (
    "surface: {kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10, "
    "spacing_um: 2, width_um: 200, seed: 3}\n"
)
FILE = "surface: {kind: file, path: heights.npy, spacing_um: 2}\n"


def scene_of(folder: Path, surface: str, rest: str) -> Path:
    path = folder / "scene.yaml"
    path.write_text(f"name: large\n{STEEL}{surface}rolling: {rest}\n")
    return path


def refusal(
    arguments: Sequence[str | Path], folder: Path, capsys: pytest.CaptureFixture[str]
) -> str:
    """Return the message of a command that ends with 2 and leaves the folder as it was."""
    before = sorted(folder.rglob("*"))
    assert cli.main([str(argument) for argument in arguments]) == 2
    assert sorted(folder.rglob("*")) == before
    return capsys.readouterr().err


# ---- the machine


def group(folder: Path, files: dict[str, str], lines: str) -> float:
    """Return the limit of the control groups in a folder."""
    for name, text in files.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    of_process = folder / "cgroup"
    of_process.write_text(lines)
    return machine.group_limit(of_process, folder / "sys")


def test_limit_of_a_control_group_of_version_2_is_the_smallest_on_the_way_up(
    tmp_path: Path,
) -> None:
    files = {
        "sys/a/b/memory.max": "max\n",
        "sys/a/memory.max": "3000\n",
        "sys/memory.max": "5000\n",
    }
    assert group(tmp_path, files, "0::/a/b\n") == 3000
    # a container that sees the path of its host
    assert group(tmp_path, {}, "0::/elsewhere\n") == 5000
    assert group(tmp_path, {"sys/memory.max": "max\n"}, "0::/\n") == math.inf


def test_limit_of_a_control_group_of_version_1(tmp_path: Path) -> None:
    files = {
        "sys/memory/job/memory.limit_in_bytes": "4000\n",
        "sys/memory/memory.limit_in_bytes": "9223372036854771712\n",
    }
    assert group(tmp_path, files, "9:cpu,cpuacct:/x\n4:memory:/job\n0::/\n") == 4000
    assert group(tmp_path, {}, "4:memory:/other\n") == 9223372036854771712  # as good as none


def test_control_groups_that_say_nothing_are_no_limit(tmp_path: Path) -> None:
    assert machine.group_limit(tmp_path / "none", tmp_path) == math.inf
    assert group(tmp_path, {"sys/memory.max": "many\n"}, "0::/../../..\nnonsense\n") == math.inf
    assert 0 < machine.memory() < 1e15  # what this machine says


def test_free_disk_is_that_of_the_nearest_folder_there_is(tmp_path: Path) -> None:
    assert machine.free_disk(tmp_path / "no" / "such" / "folder") == pytest.approx(
        machine.free_disk(tmp_path), rel=0.1
    )


# ---- the estimate

# Measured: the peak of the resident memory of all processes, and the size of the folder without the
# copy of result.h5 that stands beside it while it is written [MB]. The constants were fitted to the
# first nine; the others were predicted.
LAPS = "{load_n: 0.5, speed_m_s: %s, duration_s: %s}"
FORTY = f"sweep: {{rolling.load_n: {[round(0.01 * k, 2) for k in range(1, 41)]}}}"
MEASURED = [
    ("laps", FILE, LAPS % (0.1, 10), 1, 592, 106),
    ("many laps", FILE, LAPS % (10, 1), 1, 2498, 877),
    ("long and slow", FILE, LAPS % (0.001, 300), 1, 3917, 447),
    ("varying speed", FILE, LAPS % ("[[0, 0.01], [10, 0.01], [10.001, 1]]", 10.05), 1, 530, 30),
    (
        "oversampling",
        MADE,
        LAPS % ("[[0, 0.001], [2, 0.001], [2.0004, 5]]", 2.0005),
        1,
        1194,
        5,
    ),
    (
        "wide",
        MADE.replace("200", "20000"),
        "{load_n: 1, speed_m_s: 0.1, duration_s: 0.02}",
        2,
        1360,
        3,
    ),
    (
        "wide, smooth",
        "surface: {kind: smooth, spacing_um: 2, width_um: 40000}\n",
        LAPS % (0.1, 0.02),
        2,
        608,
        2,
    ),
    (
        "large window",
        MADE.replace("0.1, corr", "1, corr")
        .replace("_um: 2,", "_um: 0.5,")
        .replace("width_um: 200", "width_um: 640"),
        "{load_n: 100, speed_m_s: 0.1, duration_s: 0.0064}\nnumerics: {step_nodes: 16}",
        1,
        1408,
        17,
    ),
    (
        "steep, 2 x 2 sub-cells",
        MADE.replace("0.1, corr", "1, corr").replace("200", "10000"),
        "{load_n: 1, speed_m_s: 0.1, duration_s: 0.01}",
        1,
        626,
        3,
    ),
    (
        "4 x 4 sub-cells",
        MADE.replace("0.1, corr", "1, corr").replace("200", "6000"),
        "{load_n: 1, speed_m_s: 0.1, duration_s: 0.005}\nnumerics: {subcells: 4}",
        1,
        712,
        3,
    ),
    (
        "flat cells",
        MADE.replace("0.1, corr", "1, autocorrelation: exponential, corr").replace("200", "6000"),
        "{load_n: 1, speed_m_s: 0.1, duration_s: 0.005}",
        1,
        419,
        3,
    ),
    (
        "steep, large window",
        MADE.replace("0.1, corr", "1, corr").replace("_um: 2,", "_um: 1,").replace("200", "500"),
        "{load_n: 50, speed_m_s: 0.1, duration_s: 0.005}\nnumerics: {step_nodes: 10}",
        1,
        875,
        5,
    ),
    (
        "events",
        MADE.replace("spacing_um: 2", "spacing_um: 1"),
        "{load_n: 5, speed_m_s: 0.1, duration_s: 0.02}\nrecovery: {events: true}",
        1,
        371,
        7,
    ),
    ("one short run", MADE, "{load_n: 1, speed_m_s: 0.1, duration_s: 0.009}", 2, 626, 2),
    ("loudness", FILE, LAPS % (0.02, 60) + "\nsound: {loudness: true}", 1, 1061, 182),
    (
        "eight runs",
        FILE,
        LAPS % (0.1, 3) + "\nsweep: {rolling.load_n: [1, 2, 3, 4, 5, 6, 7, 8]}",
        1,
        542,
        289,
    ),
    (
        "forty runs",
        MADE.replace("200", "100"),
        "{load_n: 1, speed_m_s: 0.1, duration_s: 0.003}\n" + FORTY,
        2,
        643,
        13,
    ),
    (
        "wider",
        MADE.replace("200", "40000"),
        "{load_n: 1, speed_m_s: 0.1, duration_s: 0.04}",
        2,
        4162,
        3,
    ),
    (
        "coarse",
        MADE.replace("0.1, corr", "0.05, corr")
        .replace("_um: 10", "_um: 40")
        .replace("_um: 2,", "_um: 8,"),
        "{load_n: 0.2, speed_m_s: 0.4, duration_s: 1}",
        2,
        714,
        13,
    ),
]


@pytest.mark.parametrize(
    ("surface", "rest", "workers", "memory_mb", "disk_mb"),
    [case[1:] for case in MEASURED],
    ids=[case[0] for case in MEASURED],
)
def test_estimate_is_the_measured_size_to_twice_of_it(
    tmp_path: Path, surface: str, rest: str, workers: int, memory_mb: float, disk_mb: float
) -> None:
    np.save(tmp_path / "heights.npy", np.random.default_rng(1).standard_normal((64, 64)) * 2e-8)
    scene = scene_file.read_scene(scene_of(tmp_path, surface, rest))
    needed = demand.of_scenes(
        [(single, cost.roughness(single)[0]) for _, single in scene.runs()], workers
    )
    assert memory_mb <= needed.memory.total / 1e6 <= 2 * memory_mb
    if disk_mb > 100:
        assert disk_mb <= needed.disk.total / 1e6 <= 2 * disk_mb
    else:  # pictures, mostly: a few megabytes more or less
        assert disk_mb <= needed.disk.total / 1e6 <= 2 * disk_mb + 20


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a run of some steps."""
    folder = tmp_path_factory.mktemp("limits")
    commands.run(
        scene_of(folder, MADE, "{load_n: 1, speed_m_s: 0.1, duration_s: 0.002}"),
        out=folder / "run",
        wanted=commands.Wanted(workers=1),
    )
    return folder / "run"


def estimate_and_files(folder: Path) -> tuple[Scene, float, int]:
    """Return the scene of a run, its estimated bytes on disk, and its bytes on disk."""
    scene = scene_file.read_scene(folder / "scene.yaml")
    needed = demand.of_scenes([(scene, cost.roughness(scene)[0])], 1).disk.total
    return scene, needed, sum(file.stat().st_size for file in folder.iterdir())


@pytest.mark.slow
def test_files_of_a_run_take_no_more_than_estimated(finished: Path) -> None:
    _, needed, written = estimate_and_files(finished)
    assert 0.8 * written < needed < 3 * written  # pictures, mostly: a few megabytes more or less


def test_numbers_that_the_estimate_shares_with_slow_modules() -> None:
    assert (demand.MAPS, demand.MAP_CELLS) == (simulate.MAPS, simulate.MAP_CELLS)
    assert (demand.PIECE_STEPS, demand.PAGE_RUNS) == (simulate.PIECE_STEPS, page.MOST_RUNS)
    assert set(demand.ADVICE) >= {part for scene in (TEXT,) for part, _ in largest_parts(scene)}


def largest_parts(text: str) -> list[tuple[str, float]]:
    scene = scene_file.loads(
        text, ["recovery.events=true", "rolling.speed_m_s=[[0, 0.1], [1, 1000]]"]
    )
    needed = demand.of_scenes(
        [(single, cost.roughness(single)[0]) for _, single in scene.runs()], 2
    )
    return [*needed.memory.parts, *needed.disk.parts, *needed.process.parts]


# ---- the refusal


@pytest.mark.parametrize(
    ("surface", "rest", "says"),
    [
        (
            MADE.replace("200", "2e7"),
            "{load_n: 1, speed_m_s: 0.1, duration_s: 2}",
            ("memory: needs about", "surface.width_um"),
        ),
        (FILE, LAPS % (0.0001, 1e5), ("for the sound", "rolling.duration_s")),
        (FILE, LAPS % (1.0, 1000), ("for the steps", "rolling.duration_s", "disk: needs about")),
        (
            FILE,
            LAPS % ("[[0, 0.001], [99.9, 0.001], [100, 1000]]", 100),
            ("oversampling", "rolling.speed_m_s"),
        ),
        (
            FILE,
            LAPS % (0.1, 20) + f"\nsweep: {{rolling.start_um: {list(range(1000))}}}",
            ("runs of the sweep", "fewer values"),
        ),
    ],
    ids=["surface", "samples", "laps", "oversampling", "sweep"],
)
def test_run_refuses_what_does_not_fit_into_memory_or_on_disk(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    surface: str,
    rest: str,
    says: tuple[str, ...],
    monkeypatch,
) -> None:
    monkeypatch.setattr(machine, "memory", lambda: 32e9)
    monkeypatch.setattr(machine, "free_disk", lambda folder: 50e9)
    np.save(tmp_path / "heights.npy", np.random.default_rng(1).standard_normal((64, 64)) * 2e-8)
    message = refusal(
        ["run", scene_of(tmp_path, surface, rest), "--out", tmp_path / "out"], tmp_path, capsys
    )
    for part in says:
        assert part in message
    assert (
        "allowed: 26 GB, 80 % of the 32 GB" in message
        or "allowed: 40 GB, 80 % of the 50 GB" in message
    )


def test_resume_resound_and_accuracy_refuse_alike(
    finished: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    # 320 MB are allowed, less than the program takes
    monkeypatch.setattr(machine, "memory", lambda: 4e8)
    unfinished = finished.parent / "unfinished"
    shutil.copytree(finished, unfinished)
    (unfinished / "summary.json").unlink()  # a finished run asks for nothing
    for command in (
        ["resume", unfinished],
        ["resound", finished, "--out", finished.parent / "other"],
        ["accuracy", finished / "scene.yaml", "--out", finished.parent / "accuracy"],
    ):
        message = refusal(command, finished.parent, capsys)
        assert (
            "allowed: 320 MB, 80 % of the 400 MB this machine allows; give fewer --workers"
            in message
        )


def test_resume_does_not_ask_for_disk_twice(
    finished: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, needed, written = estimate_and_files(finished)
    monkeypatch.setattr(machine, "free_disk", lambda folder: needed / machine.SHARE - written / 2)
    refusals.refuse_what_cannot_fit(scene, 1, finished)
    with pytest.raises(SceneError, match="disk: needs about"):
        refusals.refuse_what_cannot_fit(scene, 1, finished.parent / "new")


def test_address_space_of_a_process_counts(monkeypatch) -> None:
    monkeypatch.setattr(machine, "address_space", lambda: 3e8)
    with pytest.raises(SceneError, match="240 MB, 80 % of the 300 MB one process may address"):
        refusals.refuse_what_cannot_fit(scene_file.loads(PLAIN))


def test_check_says_how_much_memory_and_disk(monkeypatch) -> None:
    scene = scene_file.loads(TEXT)
    said = str(findings.check_scene(scene))
    rows = dict(line.split("  ", 1) for line in said.splitlines() if "  " in line)
    assert "GB" in rows["memory of all"] or "MB for the program" in rows["memory of all"]
    assert "about" in rows["disk of all"]
    monkeypatch.setattr(machine, "free_disk", lambda folder: 1e6)
    assert "warning: disk of all: needs about" in str(findings.check_scene(scene))


SPARSE = """\
import resource, sys
resource.setrlimit(resource.RLIMIT_AS, (3_000_000_000, 3_000_000_000))
from rolling import cli
sys.exit(cli.main(sys.argv[1:]))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="limits of a process as on Linux")
@pytest.mark.parametrize("command", ["run", "check"])
def test_height_file_of_50_gb_is_refused_by_its_header(tmp_path: Path, command: str) -> None:
    """In 3 GB of address space a process that read or mapped the file would fail otherwise."""
    with (tmp_path / "heights.npy").open("wb") as stream:
        np.lib.format.write_array_header_1_0(
            stream, {"descr": "<f8", "fortran_order": False, "shape": (62500, 100000)}
        )
        stream.truncate(stream.tell() + 50_000_000_000)
    path = scene_of(tmp_path, FILE, LAPS % (0.1, 0.01))
    done = subprocess.run(
        [
            sys.executable,
            "-c",
            SPARSE,
            command,
            str(path),
            *(["--out", str(tmp_path / "out")] if command == "run" else []),
        ],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
    )
    assert (done.returncode, "Traceback" in done.stderr) == (2, False), done.stderr
    assert "for the height file" in done.stderr
    assert not (tmp_path / "out").exists()


# ---- scene files


def fault_of(path: Path) -> str:
    """Return the fault of a file; a thread reads it, so that no reader can hang the tests."""
    caught: list[str] = []

    def read() -> None:
        try:
            scene_file.read_scene(path)
        except SceneError as error:
            caught.append(str(error))

    thread = threading.Thread(target=read, daemon=True)
    thread.start()
    thread.join(20)
    assert caught, "still waiting"
    return caught[0]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names here")
def test_only_regular_files_are_scenes(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to(tmp_path / "pipe")
    (tmp_path / "zero").symlink_to("/dev/zero")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    assert fault_of(tmp_path / "pipe") == f"{tmp_path / 'pipe'}: is a pipe, a scene file is needed"
    assert fault_of(tmp_path / "link") == f"{tmp_path / 'link'}: is a pipe, a scene file is needed"
    assert (
        fault_of(tmp_path / "zero") == f"{tmp_path / 'zero'}: is a device, a scene file is needed"
    )
    assert "not readable" in fault_of(tmp_path / "loop")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names here")
def test_only_regular_files_are_heights(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "heights.npy")
    path = scene_of(tmp_path, FILE, LAPS % (0.1, 0.01))

    def fault() -> str:
        with pytest.raises(SceneError) as error:
            str(findings.check_scene(scene_file.read_scene(path)))
        return str(error.value)

    assert "heights.npy: is a pipe" in fault()
    (tmp_path / "heights.npy").unlink()
    (tmp_path / "heights.npy").symlink_to("/dev/zero")
    assert "heights.npy: is a device" in fault()
    (tmp_path / "heights.npy").unlink()
    (tmp_path / "heights.npy").mkdir()
    assert "heights.npy: is a folder" in fault()


def test_height_file_shorter_than_its_header_is_refused(tmp_path: Path) -> None:
    np.save(tmp_path / "heights.npy", np.zeros((64, 64)))
    content = (tmp_path / "heights.npy").read_bytes()
    (tmp_path / "heights.npy").write_bytes(content[:-1])
    with pytest.raises(
        SceneError, match="its header says 32,768 bytes of heights, it holds 32,767"
    ):
        str(
            findings.check_scene(
                scene_file.read_scene(scene_of(tmp_path, FILE, LAPS % (0.1, 0.01)))
            )
        )


def test_scene_file_of_more_than_a_megabyte_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(PLAIN + "#" * (1_000_000 - len(PLAIN)))
    scene_file.read_scene(path)
    path.write_text(PLAIN + "#" * (1_000_001 - len(PLAIN)))
    assert (
        fault_of(path)
        == f"{path}: is larger than 1,000,000 bytes, allowed: a scene file of at most that size"
    )


def bomb(letter: str = "*") -> str:
    """Return four lists of a hundred, each of the list before: 10^8 values in 2 kB."""
    lists = "".join(
        f"{b}: &{b} [{', '.join([f'{letter}{a}'] * 100)}]\n" for a, b in ("ab", "bc", "cd")
    )
    return f"a: &a [{', '.join(['x'] * 100)}]\n{lists}"


def test_aliases_count_as_what_they_stand_for() -> None:
    too_many = "more than 100,000 keys and values, each alias counted with all its values"
    assert faults(bomb()) == [f"s.yaml:3: {too_many}"]
    assert faults(PLAIN, f"rolling.speed_m_s=[&a [{'1, ' * 999}1], {'*a, ' * 100}*a]") == [
        f"--set: rolling.speed_m_s: {too_many}"
    ]
    # Merged maps: each holds the two before it.
    merges = "".join(f"m{i}: &m{i} {{k{i}: 1, <<: [*m{i - 1}, *m{i - 2}]}}\n" for i in range(2, 40))
    assert faults(f"m0: &m0 {{x: 1}}\nm1: &m1 {{y: 1}}\n{merges}")[0].endswith(too_many)
    assert faults("a: &a [1, *a]\n") == ["s.yaml:1: an alias of a value that contains it"]


def test_scene_whose_resolved_form_could_not_be_read_again_is_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # the scene holds 41 keys and values, with its defaults over 60
    monkeypatch.setattr(yaml_text, "MAX_VALUES", 45)
    scene_file.loads(PLAIN)
    monkeypatch.setattr(scene_file, "_LONG_TEXT", 10)
    assert faults(PLAIN)[0].startswith(
        "s.yaml: with every default filled in: more than 45 keys and values"
    )


def test_stumbles_of_the_reader_are_refusals() -> None:
    assert faults("%YAML 1.164\n---\n" + PLAIN)[0].startswith("s.yaml: not YAML: ")


@pytest.mark.parametrize("opening", ["[", "{a: ", "- ", "? "])
def test_deep_nesting_is_refused(opening: str) -> None:
    assert faults(opening * 5_000) == ["s.yaml:1: nested too deeply"]


def test_long_whole_numbers_are_refused() -> None:
    # Python refuses to write whole numbers of more than 4,300 digits: the resolved scene could not
    # be kept.
    for value in ("0x" + "f" * 5000, "1" * 400):
        assert (
            "a whole number of more than 301 digits"
            in faults(PLAIN.replace("seed: 1", f"seed: {value}"))[0]
        )


def swept(values: int, number: str = "{}") -> str:
    return (
        PLAIN
        + "sweep: {rolling.load_n: ["
        + ", ".join(number.format(k + 1) for k in range(values))
        + "]}\n"
    )


def test_number_of_runs_is_limited_before_any_of_them_is_made(monkeypatch) -> None:
    assert faults(swept(10_001)) == ["s.yaml:19: sweep: got 10001 runs, allowed: at most 10000"]
    text = (
        PLAIN
        + "sweep: {rolling.load_n: [1, 1], sphere.radius_mm: ["
        + ", ".join(map(str, range(1, 5002)))
        + "]}\n"
    )
    assert faults(text) == ["s.yaml:19: sweep: got 10002 runs, allowed: at most 10000"]


def test_faults_of_many_runs_are_named_up_to_a_hundred() -> None:
    """The words of a fault take longer than its check, and many runs share a fault."""
    named = faults(swept(2000, "-{}"))
    assert len(named) == 101
    assert named[99].startswith("s.yaml:19: sweep.rolling.load_n[99]: got -100")
    assert named[100] == "s.yaml:1: more than 100 faults, the others are not listed"
    keys = "".join(f"key{k}: 1\n" for k in range(2000))
    assert len(faults(PLAIN + keys)) == 101


def test_words_of_a_value_are_short() -> None:
    assert all(
        len(fault) < 300
        for fault in faults(PLAIN.replace("load_n: 20", "load_n: [" + "1, " * 5000 + "1]"))
    )
    assert all(len(fault) < 300 for fault in faults(PLAIN + '"' + "k" * 5000 + '": 1\n'))


# ---- keys and numbers that no scene has
# --------------------------------------------------------------------------------------------

LONG_HEX, LONG_DECIMAL = "0x" + "f" * 5000, "1" + "0" * 5000


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("[a, b]: 1", "got a list or section as a key, allowed: the name of a key"),
        ("{a: b}: 1", "got a list or section as a key"),
        ("? [a, {c: d}]\n: 1", "unhashable"),
        (f"? {LONG_HEX}\n: 1", "got a very long whole number as a key"),
        (f"x: {LONG_HEX}", "x: got a whole number of more than 301 digits"),
        (f"x: [{LONG_HEX}]", "x[0]: got a whole number of more than 301 digits"),
        (f"x: {LONG_DECIMAL}", "got a whole number of 5,001 digits, allowed: shorter ones"),
        (f"sweep: {{? {LONG_HEX} : [1]}}", "got a very long whole number as a key"),
    ],
)
def test_keys_and_numbers_that_no_scene_has_are_refused_in_words(line: str, message: str) -> None:
    with pytest.raises(SceneError) as error:
        scene_file.loads(f"name: odd\n{line}\n", where="s.yaml")
    (text,) = error.value.faults
    assert message in text and "set_int_max_str_digits" not in text
    assert text.startswith("s.yaml:2: ") or message == "unhashable"


def test_long_numbers_from_python_are_refused_in_words(monkeypatch: pytest.MonkeyPatch) -> None:
    ignored: list[object] = []
    monkeypatch.setattr(sys, "unraisablehook", ignored.append)  # would print a traceback
    for value in (16**5000, [16**5000], -(10**400)):
        with pytest.raises(SceneError, match="load_n: got"):
            Rolling(load_n=value, speed_m_s=1)  # type: ignore[arg-type]
        with pytest.raises(SceneError, match="speed_m_s: got"):
            Rolling(load_n=1, speed_m_s=value)  # type: ignore[arg-type]
        with pytest.raises(SceneError, match="load_n: got"):
            Scene.from_dict({"rolling": {"load_n": value}})
    assert not ignored
