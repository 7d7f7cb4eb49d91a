"""Each fault of a scene names line, key, value and allowed values."""

import pickle

import pytest
from scene_text import PLAIN, TEXT, faults

from rolling.scene.messages import SceneError

NUMBER = "allowed: greater than 0"
PAIRS = "a number > 0, or at least two [time_s, speed_m_s] pairs"
SECTION = "allowed: a section of keys"
STEPS = "a whole number from 1 to 64, or one over a whole number down to 1/16"
LOADS = "rolling.load_n: [5, 20, 100]"
PLATES = "plate:\n    steel: {youngs_modulus_gpa: 210, poissons_ratio: 0.3}\n    glass: "


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        # name and bodies
        ("name: trial", "name: a/b", '1: name: got "a/b", allowed: 1 to 64 letters'),
        ("name: trial", "name: 2024", "1: name: got 2024, allowed: 1 to 64 letters"),
        ("name: trial\n", "\n", "1: name: missing; 1 to 64 letters"),
        ("name: trial", "name: x\ndescription: 3", "2: description: got 3, allowed: text"),
        ("radius_mm: 5", "radius_mm: 0", f"2: sphere.radius_mm: got 0, {NUMBER}"),
        ("radius_mm: 5", 'radius_mm: "5"', '2: sphere.radius_mm: got "5", allowed: a number'),
        (
            "radius_mm: 5",
            "radius_mm: .nan",
            "got .nan, allowed: a finite number",
        ),
        ("radius_mm: 5", "radius_mm: 1e300", "got 1e+300, allowed: a size from 1e-15 to 1e15"),
        ("radius_mm: 5", "radius_mm: [5]", "2: sphere.radius_mm: got [5], allowed: a number"),
        (
            "radius_mm: 5",
            "radius_mm: 5, poissons_ratio: 0.3",
            "2: sphere.youngs_modulus_gpa: missing beside poissons_ratio",
        ),
        ("sphere: {radius_mm: 5}\n", "", "1: sphere: missing"),
        ("sphere: {radius_mm: 5}", "sphere: 5", f"2: sphere: got 5, {SECTION}"),
        ("sphere: {radius_mm: 5}", "sphere:", "2: sphere: missing"),
        ("ratio: 0.3", "ratio: 0.6", "poissons_ratio: got 0.6, allowed: less than or equal to 0.5"),
        (
            "hardness_gpa",
            "hardnes_gpa",
            "6: plate.hardnes_gpa: unknown key, nearest: hardness_gpa, allowed: material, youngs",
        ),
        ("hardness_gpa", "load_n", "6: plate.load_n: unknown key, nearest: rolling.load_n"),
        (
            "hardness_gpa: 2.1",
            "hardness_gpa: .inf",
            "got .inf, allowed: a finite number",
        ),
        *(
            ("hardness_gpa: 2.1", f"{key}: {got}", message)
            for key, got, message in (
                ("hardness_gpa", 2.1e9, "; did you mean 2.1 (2.1e9 Pa)?"),
                ("hardness_gpa", 200, "; did you mean 0.2 (200 MPa) or 1.961 (200 HV)?"),
                ("hardness_gpa", 42, "6: plate.hardness_gpa: got 42, allowed: below a fifth of"),
                ("hardness_gpa", 0, "0.001 to 150 GPa, from gels to diamond; nearest: 0.001"),
                ("density_kg_m3", 7.85, "; did you mean 7850 (7.85 g/cm3)?"),
                ("density_kg_m3", 26000, "10 to 25000 kg/m3, from foams to osmium; nearest: 25000"),
            )
        ),
        (
            "youngs_modulus_gpa: 210",
            "youngs_modulus_gpa: 208000",
            "4: plate.youngs_modulus_gpa: got 208000, allowed: 0.001 to 1200 GPa, from gels to"
            " diamond; did you mean 208 (208000 MPa)?",
        ),
        ("radius_mm: 5", "diameter_mm: 10", "unknown key, nearest: radius_mm, half of it, allowed"),
        (
            "radius_mm: 5",
            "radius_mm: 1000",
            "sound.distance_m: got 1, allowed: more than 1, the sphere's radius in m: the listener",
        ),
        # surface
        (
            "kind: gaussian",
            "kind: gausian",
            '8: surface.kind: got "gausian", allowed: gaussian, smooth, file, self-affine, nearest:'
            " gaussian",
        ),
        ("kind: gaussian", "kind: [smooth]", '8: surface.kind: got ["smooth"], allowed: gaussian,'),
        (
            "  kind: gaussian\n",
            "",
            "7: surface.kind: missing, allowed: gaussian, smooth, file",
        ),
        (
            "kind: gaussian",
            "kind: gaussian\n  autocorrelation: exponental",
            "exponential or exponential_10pct, nearest: exponential",
        ),
        (
            "ra_um: 0.1",
            "ra_um: 1001",
            "surface.roughness_ra_um: got 1001, allowed: less than",
        ),
        ("seed: 1", "seed: 1.5", "13: surface.seed: got 1.5, allowed: a whole number"),
        ("seed: 1", "seed: true", "13: surface.seed: got true, allowed: a whole number"),
        (
            "width_um: 64",
            "width_um: 65",
            "whole number of nodes of 2 um, at least 8; nearest: 64",
        ),
        ("width_um: 64", "width_um: 4", "12: surface.width_um: got 4, allowed: a whole number"),
        ("width_um: 64", "width_um: 1e12", "got 1000000000000, allowed: less than 1e9 nodes"),
        # rolling
        (
            "load_n: 20",
            "load_n: true",
            "15: rolling.load_n: got true, allowed: greater than 0, or weight",
        ),
        ("load_n: 20", "load_n:", "15: rolling.load_n: missing; give it, or sphere.density_kg_m3"),
        ("load_n: 20", "load_n: !big 20", "15: rolling.load_n: got the tag !big, allowed: plain"),
        ("load_n: 20", "load_n: [[[[[[1]]]]]]", "[0][0][0][0]: nested too deeply"),
        ("load_n: 20", "load: 20\n  load_n: 20", "15: rolling.load: unknown key, nearest: load_n"),
        ("speed_m_s: 0.1", "speed_m_s: 0", f"16: rolling.speed_m_s: got 0, allowed: {PAIRS}"),
        ("speed_m_s: 0.1", "speed_m_s: [[0, 1]]", f"got [[0, 1]], allowed: {PAIRS}"),
        ("speed_m_s: 0.1", "speed_m_s: [[0, 1], [1, true]]", f"allowed: {PAIRS}"),
        ("speed_m_s: 0.1", "speed_m_s: [[1, 1], [2, 1]]", "must increase strictly from 0"),
        ("speed_m_s: 0.1", "speed_m_s: [[0, 1], [2, 1], [2, 3]]", "must increase strictly from 0"),
        ("speed_m_s: 0.1", "speed_m_s: [[0, 1], [2, -1]]", "not negative, and not all zero"),
        ("speed_m_s: 0.1", "speed_m_s: [[0, 0], [2, 0]]", "not negative, and not all zero"),
        (
            "speed_m_s: 0.1",
            "speed_m_s: [[0, 1e-3], [0.01, 0]]",
            "the sphere comes to rest after 5 um, the shortest track is 8 nodes, 16 um: give it",
        ),
        (
            "  duration_s: 0.01\n",
            "",
            "14: rolling.duration_s: missing; give it or a",
        ),
        ("duration_s: 0.01", "duration_s: 1.0e-4", "track is 8 nodes, 16 um: at least 0.00016"),
        ("duration_s: 0.01", "duration_s: 1e9", "got 1000000000, which is more than 1e9 nodes"),
        # the other sections
        ("step_nodes: 1", "step_nodes: 1.6", f"got 1.6, allowed: {STEPS}; nearest: 2"),
        ("step_nodes: 1", "tolerance: 0.5", "18: numerics.tolerance: got 0.5, allowed: auto, or a"),
        ("numerics: {step_nodes: 1}", "numeric: {}", "18: numeric: unknown key, nearest: numerics"),
        ("numerics: {step_nodes: 1}", "17: 3", "18: 17: unknown key; a decimal point stands"),
        ("numerics: {step_nodes: 1}", "numeric:", "18: numeric: unknown key, nearest: numerics"),
        (
            "step_nodes: 1",
            "tolerence: , step_nodes: 1",
            "18: numerics.tolerence: unknown key, near",
        ),
        ("radius_mm: 5", "radius_mm: 5,5", "sphere.5: unknown key; a decimal point stands in plac"),
        ("{step_nodes: 1}", "{edges: {a: }}", "numerics.edges: got"),
        ("numerics: {step_nodes: 1}", "recovery: {events: on}", 'got "on", allowed: true or false'),
        (
            "numerics: {step_nodes: 1}",
            "sound: {q: 1.5}",
            "18: sound.q: got 1.5, allowed: less than",
        ),
        # sweep
        ("sweep:\n", "sweep: [1]\nx:\n", "19: sweep: got [1], allowed: lists of numbers by dotted"),
        (LOADS, "rolling.lod_n:", "20: sweep.rolling.lod_n: unknown key, nearest: rolling.load_n"),
        (LOADS, "load_n: [1]", "20: sweep.load_n: unknown key, nearest: rolling.load_n"),
        (LOADS, "surface.kind: [5]", "20: sweep.surface.kind[0]: got 5, allowed: gaussian, smooth"),
        (
            LOADS,
            "plate.contact_mm: [[5, 6]]",
            "got [5, 6], allowed: a number or a name; any other value has a label, as in plate."
            "contact_mm: {first: [5, 6]}",
        ),
        (LOADS, "rolling.load_n: []", "got [], allowed: a list of at least one number or name, or"),
        ("[5, 20, 100]", "[5, x]", '20: sweep.rolling.load_n[1]: got "x", allowed: greater than 0'),
        ("[5, 20, 100]", "[5, 6, 5.0]", "20: sweep.rolling.load_n[2]: got 5.0 twice, allowed: "),
        ("[5, 20, 100]", "\n  - 5\n  - -2", f"22: sweep.rolling.load_n[1]: got -2, {NUMBER}"),
        (
            LOADS,
            "surface.spacing_um: [2, 3]",
            "nearest: 63 (in the run spacing_um=3,radius_mm=2 of the sweep)",
        ),
        (LOADS, "numerics.edges: [blended, blunt]", '20: sweep.numerics.edges[1]: got "blunt", al'),
        (LOADS, "plate: [steel, glass]", '20: sweep.plate[0]: got "steel", allowed: a section of'),
        (LOADS, PLATES + "3", "22: sweep.plate.glass: got 3, allowed: a section"),
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
        ("[5, 20, 100]", str([*range(1, 6001)]), "19: sweep: got 12000 runs, allowed: at most"),
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
        "sphere.radius_mm",
        "sphere.radius",
        "surface.width_um",
        "rolling.load_n",
        "sound.q",
    ]
    assert [fault.split(": ")[1] for fault in faults(text, "rolling.lod_n=3", "x=3")] == [
        "rolling.lod_n",
        "x",
    ]


def test_keys_of_another_kind_of_surface() -> None:
    words = "unknown key of kind smooth, allowed: kind, spacing_um, width_um, faults"
    assert faults(PLAIN.replace("kind: gaussian", "kind: smooth")) == [
        f"s.yaml:{line}: surface.{key}: {words}"
        for line, key in ((9, "roughness_ra_um"), (10, "correlation_length_um"), (13, "seed"))
    ]


def test_errors_pass_between_processes() -> None:
    error = SceneError(["a", "b"])
    assert pickle.loads(pickle.dumps(error)).faults == ["a", "b"]
