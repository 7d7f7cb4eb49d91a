"""Scenes have properties in SI and sweeps, and the scenes of the library have tracks."""

import math
import shlex
import subprocess
import sys
from pathlib import Path
from typing import get_args

import pytest
from scene_text import PLAIN, SCENES, TEXT

from rolling.kinds.reading import read_scene
from rolling.scene.file import loads
from rolling.scene.laws import AUTOCORRELATIONS
from rolling.scene.scene import Scene
from rolling.scene.surfaces import Gaussian
from rolling.scene.sweep import run_name


def test_si() -> None:
    scene = loads(
        PLAIN, ["sphere.youngs_modulus_gpa=100", "sphere.poissons_ratio=0.2", "rolling.start_um=-3"]
    )
    assert scene.radius == pytest.approx(5e-3)
    assert 1 / scene.contact_modulus == pytest.approx(
        (1 - 0.3**2) / 210e9 + (1 - 0.2**2) / 100e9, rel=1e-15
    )
    assert scene.hardness == pytest.approx(2.1e9)
    assert (scene.spacing, scene.step, scene.load) == pytest.approx((2e-6, 2e-6, 20))
    assert scene.start == pytest.approx(-3e-6)
    rigid = loads(PLAIN, ["plate.hardness_gpa="])
    assert rigid.contact_modulus == pytest.approx(210e9 / 0.91, rel=1e-15)
    assert rigid.hardness == math.inf


def test_step_of_a_third() -> None:
    assert loads(PLAIN, ["numerics.step_nodes=0.33333"]).numerics.step_nodes == 1 / 3


def test_scenes_are_frozen_and_folders_do_not_count() -> None:
    scene = loads(PLAIN, folder=Path("a"))
    with pytest.raises(AttributeError, match="with_"):
        scene.name = "other"  # type: ignore[misc]
    assert scene == loads(PLAIN, folder=Path("b"))
    assert scene != loads(PLAIN, ["rolling.load_n=21"])


def test_sweep_product() -> None:
    runs = loads(TEXT, folder=Path("here")).runs()
    values = [(load, radius) for load in (5, 20, 100) for radius in (2, 5)]
    assert [(run.load, run.sphere.radius_mm) for _, run in runs] == values
    assert all(not run.sweep and run.folder == Path("here") for _, run in runs)
    assert runs[0][0] == {"rolling.load_n": 5, "sphere.radius_mm": 2}
    assert run_name(runs[0][0]) == "load_n=5,radius_mm=2"


def test_no_sweep_is_one_run() -> None:
    scene = loads(PLAIN)
    assert scene.runs() == [({}, scene)]


def test_any_number_can_be_swept() -> None:
    scene = loads(
        PLAIN,
        ["sweep={surface.seed: [1, 2], numerics.step_nodes: [2, 0.5], plate.hardness_gpa: [1, 2]}"],
    )
    last = scene.runs()[-1][1]
    assert last.surface.seed == 2  # type: ignore[union-attr]
    assert (last.numerics.step_nodes, last.plate.hardness_gpa) == (0.5, 2)
    assert len({run_name(values) for values, _ in scene.runs()}) == 8
    across = loads(PLAIN, ["sweep.surface.correlation_length_um=[5, 20]"])
    assert all(
        "correlation_length_across_um" not in run.to_dict()["surface"] for _, run in across.runs()
    )


def test_the_laws_are_those_of_the_surface_module() -> None:
    annotation = Gaussian.model_fields["autocorrelation"].annotation
    assert set(get_args(annotation)) == set(AUTOCORRELATIONS)


@pytest.mark.parametrize("path", SCENES, ids=lambda p: p.stem)
def test_every_scene_says_what_it_shows_and_has_a_track(path: Path, tmp_path: Path) -> None:
    first, *rest = path.read_text().splitlines()
    assert first.startswith("# ")
    scene = read_scene(path)
    assert scene.name == path.stem
    if scene.height_path and not scene.height_path.exists():
        # The command in the file's head makes the heights; it is run as it stands.
        command = next(line for line in rest if "python -c" in line).removeprefix("#")
        subprocess.run([sys.executable, *shlex.split(command)[1:]], cwd=tmp_path, check=True)
        scene = Scene.from_dict(scene.to_dict(), tmp_path)
    for _, run in scene.runs():
        long = path.stem in ("quickstart", "vibrating-ball") or run.sound.listen_s
        assert 400 <= run.track.steps <= (26_000 if long else 5000)
        assert run.track.closed
