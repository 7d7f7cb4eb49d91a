"""Messages about name, sphere, plate and surface say line, key, got and allowed."""

import pytest
from scene_text import TEXT, faults

NAME = (
    "1 to 64 letters, digits, dots, dashes or underscores, "
    "a letter or digit first (numbers in quotes)"
)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("name: trial", "name: a/b", f's.yaml:1: name: got "a/b", allowed: {NAME}'),
        ("name: trial", "name: ../x", f's.yaml:1: name: got "../x", allowed: {NAME}'),
        ("name: trial", "name: 2024", f"s.yaml:1: name: got 2024, allowed: {NAME}"),
        ("name: trial\n", "\n", f"s.yaml:1: name: missing, allowed: {NAME}"),
        (
            "name: trial",
            "name: trial\ndescription: 3",
            "s.yaml:2: description: got 3, allowed: text",
        ),
        (
            "radius_mm: 5",
            "radius_mm: 0",
            "s.yaml:2: sphere.radius_mm: got 0, allowed: a number > 0",
        ),
        (
            "radius_mm: 5",
            'radius_mm: "5"',
            's.yaml:2: sphere.radius_mm: got "5", allowed: a number > 0',
        ),
        (
            "radius_mm: 5",
            "radius_mm: .nan",
            "s.yaml:2: sphere.radius_mm: got .nan, allowed: a number > 0",
        ),
        (
            "radius_mm: 5",
            "radius_mm: 1e300",
            "s.yaml:2: sphere.radius_mm: got 1e+300, allowed: a size from 1e-15 to 1e+15",
        ),
        (
            "speed_m_s: 0.1",
            "speed_m_s: 1e-300",
            "s.yaml:16: rolling.speed_m_s: got 1e-300, allowed: a size from 1e-15 to 1e+15",
        ),
        (
            "radius_mm: 5",
            "radius_mm: [5]",
            "s.yaml:2: sphere.radius_mm: got [5], allowed: a number > 0",
        ),
        (
            "radius_mm: 5",
            "radius_mm: 5, youngs_modulus_gpa: 210",
            "s.yaml:2: sphere.poissons_ratio: missing beside youngs_modulus_gpa; an elastic sphere "
            "needs both, a"
            " rigid sphere neither",
        ),
        (
            "radius_mm: 5",
            "radius_mm: 5, poissons_ratio: 0.3",
            "s.yaml:2: sphere.youngs_modulus_gpa: missing beside poissons_ratio; an elastic sphere "
            "needs both, a"
            " rigid sphere neither",
        ),
        (
            "sphere: {radius_mm: 5}\n",
            "",
            "s.yaml:1: sphere: missing, allowed: a section of keys (radius_mm)",
        ),
        (
            "sphere: {radius_mm: 5}",
            "sphere: 5",
            "s.yaml:2: sphere: got 5, allowed: a section of keys (radius_mm)",
        ),
        (
            "sphere: {radius_mm: 5}",
            "sphere:",
            "s.yaml:2: sphere: missing, allowed: a section of keys (radius_mm)",
        ),
        (
            "ratio: 0.3",
            "ratio: 0.6",
            "s.yaml:5: plate.poissons_ratio: got 0.6, allowed: a number >= 0 and <= 0.5",
        ),
        (
            "ratio: 0.3",
            "ratio: -0.1",
            "s.yaml:5: plate.poissons_ratio: got -0.1, allowed: a number >= 0 and <= 0.5",
        ),
        (
            "hardness_gpa",
            "hardnes_gpa",
            "s.yaml:6: plate.hardnes_gpa: unknown key, nearest: hardness_gpa, allowed: "
            "youngs_modulus_gpa,"
            " poissons_ratio, hardness_gpa, density_kg_m3, thickness_mm, loss_factor",
        ),
        (
            "hardness_gpa",
            "load_n",
            "s.yaml:6: plate.load_n: unknown key, nearest: rolling.load_n, allowed: "
            "youngs_modulus_gpa, poissons_ratio,"
            " hardness_gpa, density_kg_m3, thickness_mm, loss_factor",
        ),
        (
            "hardness_gpa: 2.1",
            "hardness_gpa: .inf",
            "s.yaml:6: plate.hardness_gpa: got .inf, allowed: a number > 0",
        ),
        (
            "kind: gaussian",
            "kind: gausian",
            's.yaml:8: surface.kind: got "gausian", allowed: gaussian, smooth or file, nearest: '
            "gaussian",
        ),
        (
            "kind: gaussian",
            "kind: [smooth]",
            's.yaml:8: surface.kind: got ["smooth"], allowed: gaussian, smooth or file',
        ),
        (
            "  kind: gaussian\n",
            "",
            "s.yaml:7: surface.kind: missing, allowed: gaussian, smooth or file",
        ),
        (
            "kind: gaussian",
            "kind: gaussian\n  autocorrelation: exponental",
            's.yaml:9: surface.autocorrelation: got "exponental", allowed: gaussian, '
            "gaussian_10pct, exponential or"
            " exponential_10pct, nearest: exponential",
        ),
        (
            "ra_um: 0.1",
            "ra_um: 1001",
            "s.yaml:9: surface.roughness_ra_um: got 1001, allowed: a number > 0 and <= 1000",
        ),
        (
            "ra_um: 0.1",
            "ra_um: 0",
            "s.yaml:9: surface.roughness_ra_um: got 0, allowed: a number > 0 and <= 1000",
        ),
        ("seed: 1", "seed: 1.5", "s.yaml:13: surface.seed: got 1.5, allowed: a whole number >= 0"),
        ("seed: 1", "seed: -1", "s.yaml:13: surface.seed: got -1, allowed: a whole number >= 0"),
        (
            "seed: 1",
            "seed: true",
            "s.yaml:13: surface.seed: got true, allowed: a whole number >= 0",
        ),
        (
            "width_um: 64",
            "width_um: 65",
            "s.yaml:12: surface.width_um: got 65, allowed: a whole number of nodes of 2 um, at "
            "least 8; nearest: 64",
        ),
        (
            "width_um: 64",
            "width_um: 4",
            "s.yaml:12: surface.width_um: got 4, allowed: a whole number of nodes of 2 um, at "
            "least 8; nearest: 16",
        ),
        (
            "width_um: 64",
            "width_um: 1e12",
            "s.yaml:12: surface.width_um: got 1000000000000, allowed: less than 1e+09 nodes",
        ),
    ],
)
def test_message_about_a_body(old: str, new: str, message: str) -> None:
    assert old in TEXT
    assert message in faults(TEXT.replace(old, new, 1))
