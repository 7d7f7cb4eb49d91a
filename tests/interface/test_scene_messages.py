"""Each fault of a scene names line, key, value and allowed values."""

import pickle

import pytest
from pydantic import BaseModel, ValidationError
from scene_text import PLAIN, TEXT, faults

from rolling.scene.file import loads
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene

PAIRS = "a number > 0, or at least two [time_s, speed_m_s] pairs"
LOADS = "rolling.load_n: [5, 20, 100]"
PLATES = "plate:\n    steel: {youngs_modulus_gpa: 210, poissons_ratio: 0.3}\n    glass: "


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        # a value that is not allowed: of a name, a bound, a kind, a type, a size
        ("name: trial", "name: a/b", '1: name: got "a/b", allowed: 1 to 64 letters'),
        ("radius_mm: 5", "radius_mm: 0", "2: sphere.radius_mm: got 0, allowed: greater than 0"),
        ("radius_mm: 5", 'radius_mm: "5"', '2: sphere.radius_mm: got "5", allowed: a number'),
        ("radius_mm: 5", "radius_mm: .nan", "got .nan, allowed: a finite number"),
        ("radius_mm: 5", "radius_mm: 1e300", "got 1e+300, allowed: a size from 1e-15 to 1e15"),
        ("seed: 1", "seed: true", "13: surface.seed: got true, allowed: a whole number"),
        ("sphere: {radius_mm: 5}", "sphere: 5", "2: sphere: got 5, allowed: a section of keys"),
        ("kind: gaussian", "kind: [smooth]", '8: surface.kind: got ["smooth"], allowed: gaussian,'),
        (
            "kind: gaussian",
            "kind: gausian",
            '8: surface.kind: got "gausian", allowed: gaussian, smooth, file, self-affine, nearest:'
            " gaussian",
        ),
        (
            "kind: gaussian",
            "kind: gaussian\n  autocorrelation: exponental",
            "exponential or exponential_10pct, nearest: exponential",
        ),
        ("step_nodes: 1", "step_nodes: 1.6", "one over a whole number down to 1/16; nearest: 2"),
        ("width_um: 64", "width_um: 65", "whole number of nodes of 2 um, at least 8; nearest: 64"),
        ("load_n: 20", "load_n: true", "15: rolling.load_n: got true, allowed: greater than 0, or"),
        ("load_n: 20", "load_n: !big 20", "15: rolling.load_n: got the tag !big, allowed: plain"),
        ("load_n: 20", "load_n: [[[[[[1]]]]]]", "[0][0][0][0]: nested too deeply"),
        ("speed_m_s: 0.1", "speed_m_s: [[0, 1], [1, true]]", f"allowed: {PAIRS}"),
        ("speed_m_s: 0.1", "speed_m_s: [[1, 1], [2, 1]]", "must increase strictly from 0"),
        # a slip of units
        ("hardness_gpa: 2.1", "hardness_gpa: 2.1e9", "; did you mean 2.1 (2.1e9 Pa)?"),
        ("hardness_gpa: 2.1", "density_kg_m3: 7.85", "; did you mean 7850 (7.85 g/cm3)?"),
        ("hardness_gpa: 2.1", "hardness_gpa: 0", "from gels to diamond; nearest: 0.001"),
        # a missing key
        ("name: trial\n", "\n", "1: name: missing; 1 to 64 letters"),
        ("sphere: {radius_mm: 5}", "sphere:", "2: sphere: missing"),
        ("  kind: gaussian\n", "", "7: surface.kind: missing, allowed: gaussian, smooth, file"),
        ("load_n: 20", "load_n:", "15: rolling.load_n: missing; give it, or sphere.density_kg_m3"),
        # an unknown key
        (
            "hardness_gpa",
            "hardnes_gpa",
            "6: plate.hardnes_gpa: unknown key, nearest: hardness_gpa, allowed: material, youngs",
        ),
        ("hardness_gpa", "load_n", "6: plate.load_n: unknown key, nearest: rolling.load_n"),
        ("radius_mm: 5", "diameter_mm: 10", "unknown key, nearest: radius_mm, half of it, allowed"),
        ("radius_mm: 5", "radius_mm: 5,5", "sphere.5: unknown key; a decimal point stands in plac"),
        ("numerics: {step_nodes: 1}", "numeric:", "18: numeric: unknown key, nearest: numerics"),
        # keys that do not go together
        (
            "radius_mm: 5",
            "radius_mm: 5, poissons_ratio: 0.3",
            "2: sphere.youngs_modulus_gpa: missing beside poissons_ratio",
        ),
        (
            "hardness_gpa: 2.1",
            "hardness_gpa: 42",
            "6: plate.hardness_gpa: got 42, allowed: below",
        ),
        (
            "radius_mm: 5",
            "radius_mm: 1000",
            "sound.distance_m: got 1, allowed: more than 1, the",
        ),
        (
            "speed_m_s: 0.1\n  duration_s: 0.01\n",
            "speed_m_s: [[0, 0.1], [1, 0.2]]\n",
            "rolling.duration_s: missing; give it or a rolling.distance_mm: auto is not for",
        ),
        (
            "  duration_s: 0.01\n",
            "  duration_s: auto\n  drop_mm: 1\n",
            "rolling.duration_s: got auto, which is not for a fall: give a number",
        ),
        ("duration_s: 0.01", "duration_s: 1.0e-4", "track is 8 nodes, 16 um: at least 0.00016"),
        ("duration_s: 0.01", "duration_s: 1e9", "got 1000000000, which is more than 1e9 nodes"),
        ("speed_m_s: 0.1", "speed_m_s: [[0, 1e-3], [0.01, 0]]", "the sphere comes to rest after 5"),
        # sweep
        ("sweep:\n", "sweep: [1]\nx:\n", "19: sweep: got [1], allowed: lists of numbers by dotted"),
        (LOADS, "rolling.lod_n:", "20: sweep.rolling.lod_n: unknown key, nearest: rolling.load_n"),
        (LOADS, "surface.kind: [5]", "20: sweep.surface.kind[0]: got 5, allowed: gaussian, smooth"),
        (
            LOADS,
            "plate.contact_mm: [[5, 6]]",
            "got [5, 6], allowed: a number or a name; any other value has a label, as in plate."
            "contact_mm: {first: [5, 6]}",
        ),
        (LOADS, "rolling.load_n: []", "got [], allowed: a list of at least one number or name, or"),
        ("[5, 20, 100]", "[5, 6, 5.0]", "20: sweep.rolling.load_n[2]: got 5.0 twice, allowed: "),
        ("[5, 20, 100]", "\n  - 5\n  - -2", "22: sweep.rolling.load_n[1]: got -2, allowed: great"),
        (
            LOADS,
            "surface.spacing_um: [2, 3]",
            "nearest: 63 (in the run spacing_um=3,radius_mm=2 of the sweep)",
        ),
        (LOADS, "plate: [steel, glass]", '20: sweep.plate[0]: got "steel", allowed: a section of'),
        (
            LOADS,
            PLATES + "{youngs_modulus_gpa: -70, poissons_ratio: 0.2}",
            "22: sweep.plate.glass.youngs_modulus_gpa: got -70, allowed: 0.001 to 1200 GPa",
        ),
        (
            LOADS,
            "surface: {A: {kind: smooth}, a: {kind: smooth}}",
            '20: sweep.surface: got "a" beside "A", allowed: texts that differ in more than upper',
        ),
    ],
)
def test_message(old: str, new: str, message: str) -> None:
    assert old in TEXT
    lines = faults(TEXT.replace(old, new, 1))
    line, colon, _ = message.partition(": ")
    begin = f"s.yaml:{message}" if colon and line.isdigit() else message
    assert any(begin in fault and fault.startswith("s.yaml:") for fault in lines), lines


def test_all_faults_at_once() -> None:
    text = PLAIN.replace("radius_mm: 5", "radius: 5").replace("load_n: 20", "load_n: -1")
    text = text.replace("width_um: 64", "width_um: 65")
    assert [fault.split(": ")[1] for fault in faults(text, "sound.q=2")] == [
        "sphere.radius",
        "surface.width_um",
        "rolling.load_n",
        "sound.q",
    ]
    assert [fault.split(": ")[1] for fault in faults(text, "rolling.lod_n=3", "x=3")] == [
        "sphere.radius",
        "surface.width_um",
        "rolling.load_n",
        "rolling.lod_n",
        "x",
    ]


def test_five_faults_of_different_kinds_stand_in_the_order_of_their_lines() -> None:
    """A misspelt key, a wrong value, a broken rule, a value given twice, and a swept value.

    The rule joins sections that are valid, and stands beside the fault of another section.
    """
    text = TEXT.replace("hardness_gpa: 2.1", "hardnes_gpa: 2.1\n  thickness_mm: 3")
    text = text.replace("seed: 1", "seed: 1\n  seed: 2").replace("width_um: 64", "width_um: wide")
    text = text.replace("[5, 20, 100]", "[5, -20, 100]")
    lines = faults(text)
    assert [line.split(": ")[:2] for line in lines] == [
        ["s.yaml:6", "plate.hardnes_gpa"],
        ["s.yaml:7", "plate.thickness_mm"],
        ["s.yaml:13", "surface.width_um"],
        ["s.yaml:15", "surface.seed"],
        ["s.yaml:22", "sweep.rolling.load_n[1]"],
    ]
    assert "only goes with dynamics" in lines[1] and "first in line 14" in lines[3]


def test_a_fault_that_follows_from_another_is_not_listed() -> None:
    """Without its material the plate lacks constants, and without its thickness a loss factor."""
    text = PLAIN.replace("youngs_modulus_gpa: 210\n  poissons_ratio: 0.3", "material: stel")
    assert len(faults(text)) == 1
    text = PLAIN.replace("hardness_gpa: 2.1", "thicknes_mm: 2\n  loss_factor: 0.01")
    assert len(faults(text)) == 1
    assert len(faults(PLAIN.replace("  seed: 1", "  seed: !t 1"))) == 1


BENT = PLAIN.replace("radius_mm: 5", "radius_mm: 5, density_kg_m3: 7850").replace(
    "hardness_gpa: 2.1", "density_kg_m3: 7850\n  thickness_mm: 2\n  loss_factor: 0.01"
)
WEIGHED = PLAIN.replace("radius_mm: 5", "radius_mm: 5, material: steel-100cr6").replace(
    "20", "weight"
)


@pytest.mark.parametrize(
    ("text", "key"),
    [
        (BENT + "dynamics: 3\n", "dynamics"),  # with dynamics the plate may bend and lose
        (BENT + "dynamcs: {}\n", "dynamcs"),
        (
            BENT.replace("thickness_mm: 2", "thickness_mm: -2") + "dynamics: {}\n",
            "plate.thickness_mm",
        ),
        (WEIGHED.replace("material", "materal"), "sphere.materal"),  # which gives the density
        (PLAIN.replace("kind: gaussian", "knd: gaussian"), "surface.knd"),
        (PLAIN.replace("duration_s: 0.01", "distance_mm: -1"), "rolling.distance_mm"),
        (PLAIN.replace("name: trial", "nam: trial"), "nam"),
    ],
)
def test_a_rule_that_needs_a_faulty_value_is_not_called_broken(text: str, key: str) -> None:
    (line,) = faults(text)
    assert line.split(": ")[1] == key


def test_a_section_is_a_model_of_pydantic_like_any_other() -> None:
    assert type(Scene) is type(BaseModel)
    with pytest.raises(ValidationError):  # by the door of pydantic with the error of pydantic
        Scene.model_validate({})
    with pytest.raises(SceneError):
        Scene()  # type: ignore[call-arg]


def test_values_in_place_of_a_list_and_a_list_in_place_of_a_value_are_answered_by_example() -> None:
    text = PLAIN.replace("load_n: 20", "load_n: [5, 20]")
    (line,) = faults(text)
    assert "`sweep: {rolling.load_n: [5, 20]}`" in line
    example = "sweep: {rolling.load_n: [5, 20]}\n"
    assert len(loads(PLAIN + example).runs()) == 2
    assert "write [5, 10] for two runs" in faults(PLAIN + "sweep: {rolling.load_n: 5}\n")[0]


def test_keys_of_another_kind_of_surface() -> None:
    words = "unknown key of kind smooth, allowed: kind, spacing_um, width_um, faults"
    assert faults(PLAIN.replace("kind: gaussian", "kind: smooth")) == [
        f"s.yaml:{line}: surface.{key}: {words}"
        for line, key in ((9, "roughness_ra_um"), (10, "correlation_length_um"), (13, "seed"))
    ]


def test_errors_pass_between_processes() -> None:
    error = SceneError(["a", "b"])
    assert pickle.loads(pickle.dumps(error)).mistakes == ["a", "b"]
