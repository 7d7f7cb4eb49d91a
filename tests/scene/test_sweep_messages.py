"""Messages about a sweep say line, key, got and allowed."""

import pytest
from scene_text import TEXT, faults


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "sweep:\n",
            "sweep: [1]\nx:\n",
            "s.yaml:19: sweep: got [1], allowed: lists of numbers by dotted key, as in "
            "rolling.load_n: [5, 20]",
        ),
        (
            "rolling.load_n: [",
            "rolling.lod_n: [",
            "s.yaml:20: sweep.rolling.lod_n: unknown key, nearest: rolling.load_n",
        ),
        (
            "rolling.load_n: [",
            "load_n: [",
            "s.yaml:20: sweep.load_n: unknown key, nearest: rolling.load_n",
        ),
        (
            "rolling.load_n: [",
            "surface.kind: [",
            "s.yaml:20: sweep.surface.kind[0]: got 5, allowed: text",
        ),
        (
            "[5, 20, 100]",
            "[]",
            "s.yaml:20: sweep.rolling.load_n: got [], allowed: a list of numbers, at least one",
        ),
        (
            "[5, 20, 100]",
            "5",
            "s.yaml:20: sweep.rolling.load_n: got 5, allowed: a list of numbers, at least one",
        ),
        (
            "[5, 20, 100]",
            "[5, x]",
            's.yaml:20: sweep.rolling.load_n[1]: got "x", allowed: a number',
        ),
        (
            "[5, 20, 100]",
            "[5, 6, 5.0]",
            "s.yaml:20: sweep.rolling.load_n[2]: got 5.0 twice, allowed: different values",
        ),
        (
            "[5, 20, 100]",
            "\n  - 5\n  - -2",
            "s.yaml:22: sweep.rolling.load_n[1]: got -2, allowed: a number > 0",
        ),
        (
            "rolling.load_n: [5, 20, 100]",
            "surface.spacing_um: [2, 3]",
            "s.yaml:12: surface.width_um: got 64, allowed: a whole number of nodes of 3 um, at "
            "least 8; nearest: 63"
            " (in the run spacing_um=3,radius_mm=2 of the sweep)",
        ),
        (
            "rolling.load_n: [5, 20, 100]",
            "surface.seed: [1, 1.5]",
            "s.yaml:20: sweep.surface.seed[1]: got 1.5, allowed: a whole number >= 0",
        ),
        (
            "rolling.load_n: [5, 20, 100]",
            "numerics.edges: [blended, blunt]",
            's.yaml:20: sweep.numerics.edges[1]: got "blunt", allowed: sharp or blended',
        ),
        (
            "rolling.load_n: [5, 20, 100]",
            "plate: [steel, glass]",
            's.yaml:20: sweep.plate: got ["steel", "glass"], allowed: sections by label, as in'
            " plate: {first: {...}, second: {...}}",
        ),
        (
            "rolling.load_n: [5, 20, 100]",
            "plate:\n    steel: {youngs_modulus_gpa: 210, poissons_ratio: 0.3}\n    glass: 3",
            "s.yaml:22: sweep.plate.glass: got 3, allowed: a section",
        ),
        (
            "rolling.load_n: [5, 20, 100]",
            "plate:\n    steel: {youngs_modulus_gpa: 210, poissons_ratio: 0.3}\n"
            "    glass: {youngs_modulus_gpa: -70, poissons_ratio: 0.2}",
            "s.yaml:22: sweep.plate.glass.youngs_modulus_gpa: got -70, allowed: a number > 0",
        ),
        (
            "rolling.load_n: [5, 20, 100]",
            "zip: {rolling.load_n: [5, 20], surface.seed: [1, 2, 3]}",
            "s.yaml:20: sweep.zip: got 2 of rolling.load_n, 3 of surface.seed, allowed: equally"
            " many values of each key",
        ),
        (
            "rolling.load_n: [5, 20, 100]",
            "zip: {rolling.load_n: [5, 20, 5], surface.seed: [1, 2, 1]}",
            "s.yaml:20: sweep.zip: the same values stand together twice, allowed: different ones",
        ),
        (
            "rolling.load_n: [5, 20, 100]",
            "rolling.load_n: [5]\n  zip: {rolling.load_n: [6]}",
            "s.yaml:21: sweep.zip.rolling.load_n: is swept beside it, too",
        ),
        (
            "rolling.load_n: [5, 20, 100]",
            "zip: {rolling.load_n: [5, -2], surface.seed: [1, 2]}",
            "s.yaml:20: sweep.zip.rolling.load_n[1]: got -2, allowed: a number > 0",
        ),
        (
            "[5, 20, 100]",
            str(list(range(1, 6001))),
            "s.yaml:19: sweep: got 12000 runs, allowed: at most 10000",
        ),
    ],
)
def test_message_about_a_sweep(old: str, new: str, message: str) -> None:
    assert old in TEXT
    assert message in faults(TEXT.replace(old, new, 1))
