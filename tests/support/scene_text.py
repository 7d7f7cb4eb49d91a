"""The text of a scene, the faults of its variants, and the scenes of scenarios/ by their kind."""

from pathlib import Path
from typing import Any

import pytest

from rolling.kinds.registry import name_of_file
from rolling.scene import library
from rolling.scene.file import loads
from rolling.scene.messages import SceneError

# The kind of each scene of the library by its name. Each file is read once while tests are found.
KINDS = {name: name_of_file(path) for name, path in library.scenes().items()}
BALLS = [name for name, kind in KINDS.items() if kind == "ball"]
FILES = sorted((Path(__file__).parents[2] / "scenarios").glob("*.yaml"))
BEARINGS = [path for path in FILES if KINDS[path.stem] == "bearing"]
SCENES = [path for path in FILES if path not in BEARINGS]

TEXT = """\
name: trial
sphere: {radius_mm: 5}
plate:
  youngs_modulus_gpa: 210
  poissons_ratio: 0.3
  hardness_gpa: 2.1
surface:
  kind: gaussian
  roughness_ra_um: 0.1
  correlation_length_um: 10
  spacing_um: 2
  width_um: 64
  seed: 1
rolling:
  load_n: 20
  speed_m_s: 0.1
  duration_s: 0.01
numerics: {step_nodes: 1}
sweep:
  rolling.load_n: [5, 20, 100]
  sphere.radius_mm: [2, 5]
"""
PLAIN = TEXT[: TEXT.index("sweep:")]

# A run of 25 steps, solved in a tenth of a second.
TINY = """\
name: tiny
sphere: {radius_mm: 1}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}
surface:
  {kind: gaussian, roughness_ra_um: 0.02, correlation_length_um: 10, spacing_um: 2,
   width_um: 128, seed: 1}
rolling: {load_n: 0.005, speed_m_s: 0.1, duration_s: 0.0005}
"""

# A ball of 5 mm on a plate of steel that yields, and narrow rough surfaces for the pair.
BODIES = """\
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}
"""
NARROW = """\
surface:
  kind: gaussian
  roughness_ra_um: 0.1
  correlation_length_um: 10
  spacing_um: 2
  width_um: 128
  seed: 3
"""
MADE = """\
surface: {kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10, \
spacing_um: 2, width_um: 200, seed: 3}
"""
WIDE = f"""\
name: trial
{BODIES}\
surface: {{kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10, \
spacing_um: 2, width_um: 512, seed: 1}}
rolling: {{load_n: 20, speed_m_s: 0.1, duration_s: 0.5}}
"""

# The same bodies and a narrow surface as plain values.
SMALL: dict[str, Any] = {
    "name": "small",
    "sphere": {"radius_mm": 5},
    "plate": {"youngs_modulus_gpa": 210, "poissons_ratio": 0.3, "hardness_gpa": 2.1},
    "surface": {
        "kind": "gaussian",
        "roughness_ra_um": 0.1,
        "correlation_length_um": 10,
        "spacing_um": 2,
        "width_um": 128,
        "seed": 1,
    },
}


def faults(text: str, *overrides: str) -> list[str]:
    with pytest.raises(SceneError) as error:
        loads(text, overrides, "s.yaml")
    assert str(error.value) == "\n".join(error.value.mistakes)
    return error.value.mistakes
