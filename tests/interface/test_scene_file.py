"""Scene files report faults with their lines, and survive a round trip."""

import pickle
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ruamel.yaml import YAML
from scene_text import PLAIN, SCENES, TEXT, faults

from rolling.kinds.reading import read_scene, schema
from rolling.scene.file import RESOUND_KEYS, dump, loads, resound
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.scene.sections import STEP_NODES

# ---- Messages


NEEDED = "empty, a scene needs at least name, sphere, plate, surface, rolling"
FIRST = "allowed: a scene of keys and values, the first being name"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", f" {NEEDED}"),
        ("# only a comment\n", f" {NEEDED}"),
        ("- name: x\n", f'1: got [{{"name": "x"}}], {FIRST}'),
        ("hello", f'1: got "hello", {FIRST}'),
        ("name: x\nsphere: {radius_mm: 5\n", "3: not YAML: expected ',' or '}', but got 'the end'"),
        (
            PLAIN.replace("ratio: 0.3\n", "ratio: 0.3\n  poissons_ratio: 0.2\n"),
            "6: plate.poissons_ratio: given twice",
        ),
        ("name: x\n---\nname: y\n", "2: not YAML: but found another document"),
        ("name: x\nsphere: \x07\n", "2: not YAML: special characters are not allowed"),
    ],
)
def test_message_of_text_that_is_no_scene(text: str, message: str) -> None:
    (fault,) = faults(text)
    assert fault.startswith(f"s.yaml:{message}")


def test_messages_of_files(tmp_path: Path) -> None:
    def fault(path: Path) -> str:
        with pytest.raises(SceneError) as error:
            read_scene(path)
        return str(error.value)

    assert fault(tmp_path / "no.yaml") == f"{tmp_path / 'no.yaml'}: no such file"
    assert fault(tmp_path) == f"{tmp_path}: is a folder, a scene file is needed"
    latin = tmp_path / "latin.yaml"
    latin.write_bytes("name: x\ndescription: Stöße\n".encode("latin-1"))
    assert fault(latin) == f"{latin}:2: not UTF-8 text (byte 0xf6)"
    bad = tmp_path / "bad.yaml"
    bad.write_text(PLAIN.replace("load_n: 20", "load_n: 0"))
    assert fault(bad) == f"{bad}:15: rolling.load_n: got 0, allowed: greater than 0, or weight"


def test_aliases_and_merges_keep_a_line() -> None:
    text = PLAIN.replace("sphere: {radius_mm: 5}", "sphere: {radius_mm: &r -5}").replace(
        "load_n: 20", "load_n: *r"
    )
    assert faults(text) == [
        "s.yaml:2: sphere.radius_mm: got -5, allowed: greater than 0",
        "s.yaml:15: rolling.load_n: got -5, allowed: greater than 0, or weight",
    ]
    assert loads(PLAIN.replace("load_n: 20", "<<: {load_n: 20}")).load == 20


# ---- Reading and writing


def test_numbers_of_yaml() -> None:
    scene = loads(
        PLAIN.replace("gpa: 210", "gpa: 210e0").replace(
            "step_nodes: 1", "step_nodes: 1, tolerance: 1e-3"
        )
    )
    assert scene.plate.youngs_modulus_gpa == 210.0
    assert scene.numerics.tolerance == 1e-3


@pytest.mark.parametrize("path", SCENES, ids=lambda p: p.stem)
def test_round_trip(path: Path) -> None:
    scene = read_scene(path)
    again = loads(dump(scene))
    assert again == scene
    assert Scene.from_dict(scene.to_dict()) == scene
    assert pickle.loads(pickle.dumps(scene)).folder == scene.folder == path.parent


def test_dump_fills_in_defaults_and_no_folder(tmp_path: Path) -> None:
    path = tmp_path / "s.yaml"
    path.write_text(PLAIN)
    text = dump(read_scene(path))
    for line in (
        "tolerance: auto",
        "rule: mean",
        "events: false",
        "distance_m: 1.0",
        "autocorrelation: gaussian",
    ):
        assert line in text
    assert str(tmp_path) not in text


@pytest.mark.slow
@settings(deadline=None, max_examples=100)
@given(
    st.floats(1e-12, 1e12),
    st.sampled_from(STEP_NODES),
    st.text(st.characters(codec="utf-8", exclude_categories=["Cs", "Cc"]), max_size=50),
    st.from_regex(r"\A[A-Za-z0-9][A-Za-z0-9._-]{0,63}\Z"),
)
def test_round_trip_of_any_value(
    load_n: float, step_nodes: float, description: str, name: str
) -> None:
    data = loads(PLAIN).to_dict()
    data["rolling"]["load_n"] = load_n
    data["numerics"]["step_nodes"] = step_nodes
    data["name"] = name
    data["description"] = description
    scene = Scene.from_dict(data)
    assert loads(dump(scene)) == scene


# ---- Overrides


def test_overrides() -> None:
    scene = loads(
        PLAIN,
        [
            "rolling.load_n = 50",
            "recovery.events=true",
            "sound={distance_m: 2}",
            "plate.hardness_gpa=null",
        ],
    )
    assert scene.load == 50
    assert scene.recovery.events
    assert scene.sound.distance_m == 2
    assert scene.plate.hardness_gpa is None
    assert loads(PLAIN, ["rolling.speed_m_s=[[0, 0.1], [1, 0.2]]"]).rolling.speed_m_s == (
        (0, 0.1),
        (1, 0.2),
    )


def test_overrides_of_the_sweep() -> None:
    assert loads(TEXT, ["sweep=null"]).sweep == {}
    assert loads(TEXT, ["sweep.rolling.load_n=[1, 2]"]).sweep["rolling.load_n"] == (1, 2)
    assert list(loads(TEXT, ["sweep.rolling.load_n="]).sweep) == ["sphere.radius_mm"]
    assert loads(PLAIN, ["sweep.surface.seed=[1, 2]"]).sweep == {"surface.seed": (1, 2)}


def test_a_swept_key_that_is_set_is_no_longer_swept() -> None:
    scene = loads(TEXT, ["rolling.load_n=50"])
    assert scene.load == 50
    assert list(scene.sweep) == ["sphere.radius_mm"]


@pytest.mark.parametrize(
    ("override", "message"),
    [
        (
            "rolling.lod_n=5",
            "rolling.lod_n: unknown key, nearest: rolling.load_n, allowed: load_n, ",
        ),
        ("load_n=5", "load_n: unknown key, nearest: rolling.load_n"),
        (
            "youngs_modulus_gpa=3",
            "youngs_modulus_gpa: stands for sphere.youngs_modulus_gpa or plate.youngs_modulus_gpa,",
        ),
        ("sweep.rolling.lod_n=[5]", "sweep.rolling.lod_n: unknown key, nearest: sweep.rolling."),
        ("=5", 'got "=5", allowed: key=value, as in rolling.load_n=50'),
        ("numerics.step_nodes=[1", "numerics.step_nodes:1: not YAML: expected ',' or ']', but got"),
        ("rolling.load_n=", "rolling.load_n: missing; give it, or sphere.density"),
        ("sound={q: 2}", "sound.q: got 2, allowed: less than or equal to 1"),
        ("sweep.rolling.load_n=[5, -1]", "sweep.rolling.load_n[1]: got -1, allowed: greater"),
    ],
)
def test_message_of_override(override: str, message: str) -> None:
    (fault,) = faults(PLAIN, override)
    assert fault.startswith(f"--set: {message}")


# ---- New sound


def test_resound() -> None:
    scene = loads(PLAIN)
    new = resound(scene, ["rolling.speed_m_s=0.2", "sound.distance_m=3"])
    assert (new.rolling.speed_m_s, new.rolling.duration_s, new.sound.distance_m) == (0.2, 0.005, 3)
    assert new.track == scene.track
    slow = resound(scene, ["rolling.speed_m_s=[[0, 0], [1, 0.002]]"])
    assert slow.track == scene.track


def test_resound_slower_than_the_shortest_track_would_take() -> None:
    assert resound(loads(PLAIN), ["rolling.speed_m_s=1e-6"]).rolling.duration_s == pytest.approx(
        1000
    )


def test_resound_refusals() -> None:
    with pytest.raises(SceneError) as error:
        resound(loads(PLAIN), ["rolling.load_n=5", "sound.q=0", "sound.z=1"])
    allowed = ", ".join(RESOUND_KEYS)
    unsolved, wrong, unknown = sorted(error.value.mistakes)
    assert unsolved == (
        f"--set: rolling.load_n: needs a new run; without solving again allowed: {allowed}"
    )
    assert wrong.startswith("--set: sound.q: got 0")
    assert unknown.startswith("--set: sound.z: unknown key")
    with pytest.raises(
        SceneError,
        match=r"^--set: rolling.speed_m_s: the sphere comes to rest after 0.0005 m and never",
    ):
        resound(loads(PLAIN), ["rolling.speed_m_s=[[0, 0.1], [0.01, 0]]"])
    with pytest.raises(
        SceneError, match=r"^--set: rolling.speed_m_s: got -1, allowed: a number > 0"
    ):
        resound(loads(PLAIN), ["rolling.speed_m_s=-1"])


# ---- The schema


@pytest.mark.parametrize("path", SCENES, ids=lambda p: p.stem)
def test_schema_knows_the_keys_of_the_scenes(path: Path) -> None:
    root = schema("ball")
    assert root["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    assert root["additionalProperties"] is False and "name" in root["required"]
    for data in (YAML(typ="safe").load(path.read_text()), read_scene(path).to_dict()):
        assert set(data) <= set(root["properties"])
        for section in (value for name, value in data.items() if name != "sweep"):
            if isinstance(section, dict):
                assert any(
                    {*model.get("required", [])} <= {*section} <= {*model["properties"]}
                    for model in root["$defs"].values()
                )


def test_schema_describes_every_key() -> None:
    root = schema("ball")
    for section in root["$defs"].values():
        assert section["additionalProperties"] is False
        for name, key in section["properties"].items():
            assert key.get("description"), name
    for name, unit in (("radius_mm", "[mm]"), ("youngs_modulus_gpa", "[GPa]")):
        assert unit in root["$defs"]["Sphere"]["properties"][name]["description"]
