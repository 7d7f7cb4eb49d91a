"""Scenes that come with the program are listed, copied and found by name; `python -m rolling`."""

from __future__ import annotations

import re
import resource
from pathlib import Path

import pytest

from rolling import cli, read_scene
from rolling.scene import library
from rolling.scene.messages import SceneError

ROOT = Path(__file__).parents[2]


@pytest.fixture(autouse=True)
def empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_every_scene_has_a_name_and_a_title() -> None:
    scenes = library.scenes()
    assert set(scenes.values()) == set((ROOT / "scenarios").rglob("*.yaml"))
    for name, title in library.titles(inner=True):
        assert title[-1] in ".?" and len(title) < 160 and "$schema" not in title, name
        if "/" not in name:
            assert read_scene(scenes[name]).name == name


def test_scenes_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["scenes"]) == 0
    short = capsys.readouterr().out
    assert re.search(r"\nquickstart +A 10 mm ball rolls on ground steel under three loads", short)
    inner = [name for name in library.scenes() if "/" in name]
    assert "lee2025" not in short and f"{len(inner)} more scenes" in short
    assert cli.main(["scenes", "--all"]) == 0
    names = [line.split()[0] for line in capsys.readouterr().out.splitlines()]
    assert names == list(library.scenes())


def test_a_scene_is_copied_with_its_schema_and_nothing_is_replaced(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert cli.main(["init"]) == 0
    assert "rolling run quickstart.yaml" in capsys.readouterr().out
    for name in ("quickstart.yaml", "scene.schema.json"):
        assert Path(name).read_bytes() == (ROOT / "scenarios" / name).read_bytes()
        Path(name).write_text("mine")
    assert cli.main(["init", "quickstart"]) == 2
    assert capsys.readouterr().err.startswith("quickstart.yaml: exists, ")
    assert cli.main(["init", "smooth.yaml"]) == 0
    assert cli.main(["init", "lee2025/as-stated/rough"]) == 0
    assert cli.main(["init", "bearing-6204"]) == 0
    assert {path.name for path in Path().iterdir()} == {
        "quickstart.yaml",
        "scene.schema.json",
        "smooth.yaml",
        "rough.yaml",
        "bearing-6204.yaml",
        "bearing.schema.json",
    }
    assert Path("quickstart.yaml").read_text() == Path("scene.schema.json").read_text() == "mine"


@pytest.mark.parametrize("name", ["quikstart", "../quickstart", "/quickstart", "lee2025", ""])
def test_an_unknown_scene_is_not_copied(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["init", name]) == 2
    message = capsys.readouterr().err
    assert message.startswith(f"{name}: no such scene") and "`rolling scenes`" in message
    assert ("nearest: quickstart" in message) == ("quickstart" in name or name == "quikstart")
    assert not list(Path().iterdir())


def test_a_copy_that_fails_leaves_nothing(tmp_path: Path) -> None:
    """The largest allowed file is shorter than the scene, as on a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, hard))
    try:
        with pytest.raises(OSError, match="File too large"):
            library.copy("quickstart", tmp_path)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert not list(tmp_path.iterdir())


def test_a_scene_is_found_by_name_unless_a_file_has_it() -> None:
    assert read_scene("quickstart", ["rolling.load_n=7"]).load == 7
    assert read_scene("lee2025/as-stated/rough").name
    Path("smooth").mkdir()
    assert read_scene("smooth").name == "smooth"
    Path("quickstart").write_text((ROOT / "scenarios" / "events.yaml").read_text())
    assert read_scene("quickstart").name == "events"


def test_a_scene_found_by_name_reads_heights_from_the_current_folder(tmp_path: Path) -> None:
    path = read_scene("measured-surface").height_path
    assert path is not None and path.resolve() == tmp_path / "heights.npy"


def test_heights_of_the_library_come_with_their_scene(tmp_path: Path) -> None:
    path = read_scene("measured-scan").height_path
    assert path == ROOT / "scenarios" / "measured-scan.sdf"
    written = library.copy("measured-scan", tmp_path)
    assert [file.suffix for file in written] == [".yaml", ".sdf", ".json"]
    assert read_scene(written[0]).height_path == tmp_path / "measured-scan.sdf"


@pytest.mark.parametrize(
    ("path", "hint"),
    [
        ("quickstart.yaml", "; `rolling init quickstart` copies the scene of that name"),
        ("quikstart", ", nearest: quickstart, a scene of the library"),
        ("elsewhere/nothing.yaml", ""),
    ],
)
def test_a_missing_file_that_looks_like_a_scene_of_the_library(path: str, hint: str) -> None:
    with pytest.raises(SceneError) as raised:
        read_scene(path)
    assert str(raised.value).startswith(f"{path}: no such file{hint}")
    assert hint or str(raised.value) == f"{path}: no such file"
