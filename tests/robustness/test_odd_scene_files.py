"""Files, keys and numbers that no scene has are refused in bounded time and in few words."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np
import pytest
from large_scenes import FILE, LAPS, scene_of
from scene_text import PLAIN, faults

from rolling.check import findings
from rolling.kinds.reading import read_scene
from rolling.scene import file as scene_file
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.scene.sections import Rolling


def fault_of(path: Path) -> str:
    with pytest.raises(SceneError) as error:
        read_scene(path)
    return str(error.value)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names here")
def test_only_regular_files_are_scenes(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to(tmp_path / "pipe")
    (tmp_path / "zero").symlink_to("/dev/zero")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    for name, kind in (("pipe", "a pipe"), ("link", "a pipe"), ("zero", "a device")):
        assert fault_of(tmp_path / name).endswith(f"{name}: is {kind}, a scene file is needed")
    assert "not readable" in fault_of(tmp_path / "loop")


def test_heights_in_place_of_a_scene_are_told_how_to_get_into_one(tmp_path: Path) -> None:
    heights = np.arange(400.0).reshape(20, 20)
    np.save(tmp_path / "scan.npy", heights)
    np.savetxt(tmp_path / "scan.csv", heights, delimiter=";")
    (tmp_path / "scan.txt").write_text("Höhe in µm\n1,5\t2,5\n", encoding="latin-1")
    (tmp_path / "scan.sdf").write_bytes(bytes(2000))
    (tmp_path / "large.xyz").write_text("1 2 3\n" * 200_000)
    for path in tmp_path.iterdir():
        told = fault_of(path)
        assert f"`rolling surface {path}`" in told and "a scene is needed" in told
    (tmp_path / "scene.txt").write_text("name: odd\nplate: 1\n")
    assert "a scene is needed" not in fault_of(tmp_path / "scene.txt")
    assert fault_of(tmp_path / "gone.csv").endswith("no such file")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names here")
def test_only_regular_files_are_heights(tmp_path: Path) -> None:
    path = scene_of(tmp_path, FILE, LAPS % (0.1, 0.01))
    heights = tmp_path / "heights.npy"
    for make, kind in (
        (lambda: os.mkfifo(heights), "a pipe"),
        (lambda: heights.symlink_to("/dev/zero"), "a device"),
        (heights.mkdir, "a folder"),
    ):
        make()
        with pytest.raises(SceneError, match=f"heights.npy: is {kind}"):
            findings.check_scene(read_scene(path))
        heights.rmdir() if heights.is_dir() else heights.unlink()


def test_height_file_shorter_than_its_header_is_refused(tmp_path: Path) -> None:
    np.save(tmp_path / "heights.npy", np.zeros((64, 64)))
    content = (tmp_path / "heights.npy").read_bytes()
    (tmp_path / "heights.npy").write_bytes(content[:-1])
    with pytest.raises(
        SceneError, match="its header says 32,768 bytes of heights, it holds 32,767"
    ):
        str(findings.check_scene(read_scene(scene_of(tmp_path, FILE, LAPS % (0.1, 0.01)))))


def test_scene_file_of_more_than_a_megabyte_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(PLAIN + "#" * (1_000_000 - len(PLAIN)))
    read_scene(path)
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


def test_aliases_and_their_values_are_limited() -> None:
    assert faults(bomb())[0].endswith("more than 100,000 keys and values")
    long = f"rolling.speed_m_s=[&a [{'1, ' * 1999}1], {'*a, ' * 59}*a]"
    assert "more than 100,000 keys and values" in faults(PLAIN, long)[0]
    # Merged maps: each holds the two before it.
    merges = "".join(f"m{i}: &m{i} {{k{i}: 1, <<: [*m{i - 1}, *m{i - 2}]}}\n" for i in range(2, 60))
    assert faults(f"m0: &m0 {{x: 1}}\nm1: &m1 {{y: 1}}\n{merges}")[0].endswith(
        "more than 100 sections are merged in"
    )
    assert faults("a: &a [1, *a]\n")[0].endswith("nested too deeply")
    assert faults("a: &a {<<: *a}\n")[0].endswith("more than 100 sections are merged in")


def test_stumbles_of_the_reader_are_refusals() -> None:
    assert faults("%YAML 1.164\n---\n" + PLAIN)[0].startswith("s.yaml: not YAML: ")


@pytest.mark.parametrize("opening", ["[", "{a: ", "- ", "? "])
def test_deep_nesting_is_refused(opening: str) -> None:
    assert faults(opening * 5_000) == ["s.yaml: nested too deeply"]


def test_long_whole_numbers_are_refused() -> None:
    # Python refuses to write whole numbers of more than 4,300 digits: the resolved scene could not
    # be kept.
    for value in ("0x" + "f" * 5000, "1" * 400):
        assert (
            f"surface.seed: got a number of {len(value):,} digits, allowed: at most 300"
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


def test_the_first_mistakes_of_many_are_named() -> None:
    keys = "".join(f"key{k}: 1\n" for k in range(2000))
    named = faults(PLAIN + keys)
    assert len(named) == 21 and named[20] == "s.yaml:1: 1,980 more mistakes are not listed"
    named = faults(swept(2000, "-{}"))
    assert len(named) == 21 and named[20] == "s.yaml:1: further mistakes are not listed"
    assert named[0] == (
        "s.yaml:19: sweep.rolling.load_n[0]: got -1, allowed: greater than 0, or weight"
    )


def test_words_of_a_value_are_short() -> None:
    assert all(
        len(fault) < 300
        for fault in faults(PLAIN.replace("load_n: 20", "load_n: [" + "1, " * 5000 + "1]"))
    )
    assert all(len(fault) < 300 for fault in faults(PLAIN + '"' + "k" * 5000 + '": 1\n'))


LONG_HEX = "0x" + "f" * 5000
LONG_DECIMAL = "1" + "0" * 5000


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("[a, b]: 1", "got a list or section as a key, allowed: the name of a key"),
        ("? [a, {c: d}]\n: 1", "got a list or section as a key"),
        (f"x: {LONG_HEX}", "x: got a number of 5,002 digits, allowed: at most 300"),
        (f"x: [{LONG_DECIMAL}]", "x[0]: got a number of 5,001 digits"),
    ],
)
def test_keys_and_numbers_that_no_scene_has_are_refused_in_words(line: str, message: str) -> None:
    with pytest.raises(SceneError) as error:
        scene_file.loads(f"name: odd\n{line}\n", where="s.yaml")
    about = [text for text in error.value.mistakes if message in text]
    assert len(about) == 1 and about[0].startswith("s.yaml:2: ")


def test_a_number_that_is_a_key_is_an_unknown_key() -> None:
    lines = faults(f"name: odd\n? {LONG_HEX}\n: 1\nsweep: {{? {LONG_HEX} : [1]}}\n")
    assert sum("unknown key" in line for line in lines) == 2
    assert all(len(line) < 300 for line in lines)


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
