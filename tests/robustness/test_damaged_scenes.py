"""Scenes with several damaged keys at once: every damaged key is named, and nothing is run."""

from __future__ import annotations

import io
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML
from scene_text import SCENES, WIDE

from rolling import cli
from rolling.scene import file
from rolling.scene.messages import SceneError

SHORT = 60
LONG = 500  # scenes of the slow test
SECTIONS = ("sphere", "plate", "surface", "rolling", "numerics", "recovery", "dynamics", "sound")
# Values that no key of a scene allows.
WRONG = (["a", ["b"]], -1e300, {"no such": {"thing": 1}}, "\u2007")
FREE = ("name", "title", "description", "listen_for", "path", "channel")  # keys that take any text

Place = tuple[str, ...]


def places(data: dict[str, Any], above: Place = ()) -> Iterator[Place]:
    """Yield the keys that may be damaged: sections, their keys, and swept keys."""
    for name, value in data.items():
        at = (*above, name)
        if name in FREE:
            continue
        yield at
        is_section = at == ("sweep",) or (at[0] in SECTIONS and len(at) < 3)
        if isinstance(value, dict) and is_section:
            yield from places(value, at)


def damaged(number: int) -> tuple[str, list[str]]:
    """Damage one to four keys of a scene; return its text, and the names that must be named."""
    chance = random.Random(number)
    source = chance.choice(SCENES).read_text(encoding="utf-8")
    data = YAML(typ="safe", pure=True).load(source)
    taken: list[Place] = []
    named: list[Place] = []
    for place in chance.sample(list(places(data)), chance.randint(1, 4)):
        if any(place[: len(other)] == other or other[: len(place)] == place for other in taken):
            continue  # one of both holds the other
        taken.append(place)
        inside = data
        for name in place[:-1]:
            inside = inside[name]
        last = place[-1]
        if chance.random() < 0.5:
            inside[last + "x"] = inside.pop(last)
            named.append((*place[:-1], last + "x"))
        else:
            inside[last] = chance.choice(WRONG)
            named.append(place)
    stream = io.BytesIO()
    YAML(typ="safe", pure=True).dump(data, stream)
    return stream.getvalue().decode(), [".".join(place) for place in named]


def assert_named(number: int) -> None:
    text, names = damaged(number)
    with pytest.raises(SceneError) as error:
        file.loads(text, where="s.yaml", folder=SCENES[0].parent)
    faults = error.value.mistakes
    assert len(set(faults)) == len(faults)
    for name in names:
        assert any(f": {name}" in fault for fault in faults), (number, name, faults)
    lines = [int(fault.split(":")[1]) for fault in faults]
    assert lines == sorted(lines), (number, faults)


@pytest.mark.parametrize("number", range(SHORT))
def test_every_damaged_key_is_named(number: int) -> None:
    assert_named(number)


@pytest.mark.slow
def test_every_damaged_key_of_many_scenes_is_named() -> None:
    for number in range(SHORT, SHORT + LONG):
        assert_named(number)


def test_a_command_names_all_and_writes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Faults of the file, of --set and of the options stand together, and the code is 2."""
    text = WIDE.replace("load_n: 20", "load_n: -20").replace("seed: 1", "sed: 1")
    (tmp_path / "scene.yaml").write_text(text)
    monkeypatch.chdir(tmp_path)
    words = ["run", "scene.yaml", "--set", "rolling.laod_n=5", "--set", "7", "--worker=2", "--opn"]
    with pytest.raises(SystemExit) as ended:
        cli.main(words)
    assert ended.value.code == 2
    printed = capsys.readouterr().err
    for name in ("surface.sed", "rolling.load_n", "rolling.laod_n", "key=value"):
        assert name in printed, printed
    assert "--workers" in printed and "--open" in printed
    assert [path.name for path in tmp_path.iterdir()] == ["scene.yaml"]
