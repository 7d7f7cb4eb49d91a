"""The track of a scene closes, is rounded to whole nodes, and goes round a height file."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scene_text import PLAIN

from rolling.scene.file import dump, loads, resound
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.scene.sections import STEP_NODES


@settings(deadline=None, max_examples=200)
@given(
    st.floats(0.01, 10),
    st.sampled_from(STEP_NODES),
    st.floats(0.001, 10),
    st.floats(0.01, 1.0),
    st.floats(0.1, 10.0),
)
def test_made_tracks_close(
    spacing: float, step_nodes: float, speed: float, duration: float, start: float
) -> None:
    data: dict[str, Any] = loads(PLAIN).to_dict()
    data["surface"] |= {"spacing_um": spacing, "width_um": 16 * spacing}
    data["rolling"] |= {"speed_m_s": speed, "duration_s": duration, "start_um": start}
    data["numerics"] = {"step_nodes": step_nodes}
    try:
        scene = Scene.from_dict(data)
    except SceneError as error:  # the longest and shortest are refused, and nothing else
        assert "shortest track" in str(error) or "more than" in str(error)
        return
    way = scene.track
    assert way.closed
    assert way.lap_steps == way.steps
    assert way.n_across == 16
    assert way.n_along >= 8
    assert way.steps * way.step == pytest.approx(way.n_along * way.spacing, rel=1e-12)
    # Rounded, not cut: never further off than half of the larger of node and step.
    assert abs(way.distance - speed * duration) <= 0.500001 * max(way.step, way.spacing)


def test_the_shortest_track_that_is_named_is_enough() -> None:
    scene = loads(PLAIN, ["rolling.duration_s=0.00016"])
    assert scene.track.n_along == 8
    assert (
        loads(PLAIN, ["rolling.duration_s=0.00016", "numerics.step_nodes=0.25"]).track.steps == 32
    )
    coarse = loads(PLAIN, ["numerics.step_nodes=64", "rolling.duration_s=0.0013"]).track
    assert (coarse.n_along, coarse.steps) == (64, 1)


def test_a_sphere_that_stops_is_not_asked_for_more() -> None:
    # 9.9 nodes until it rests: ten would be nearer, and out of reach.
    scene = loads(PLAIN, ["rolling.speed_m_s=[[0, 0.00396], [0.01, 0]]", "rolling.duration_s=1"])
    assert scene.track.n_along == 9
    assert scene.motion.duration(scene.track.distance) < 0.01


def file_scene(folder: Path, heights: Any, *overrides: str) -> Scene:
    np.save(folder / "heights.npy", heights)
    text = (
        PLAIN[: PLAIN.index("surface:")]
        + "surface: {kind: file, path: heights.npy, spacing_um: 2}\n"
    )
    text += "rolling: {load_n: 20, speed_m_s: 0.1}\n"
    return loads(text, overrides, folder=folder)


@pytest.mark.parametrize(
    ("step_nodes", "lap_steps", "steps", "closed"),
    [
        (1, 100, 100, True),
        (2, 50, 50, True),
        (3, 100, 33, False),
        (0.5, 200, 200, True),
        (8, 25, 12, False),
    ],
)
def test_once_round_a_file(
    tmp_path: Path, step_nodes: float, lap_steps: int, steps: int, closed: bool
) -> None:
    scene = file_scene(tmp_path, np.zeros((100, 16)), f"numerics.step_nodes={step_nodes}")
    way = scene.track
    assert (way.n_along, way.n_across, way.lap_steps, way.steps, way.closed) == (
        100,
        16,
        lap_steps,
        steps,
        closed,
    )
    assert not (lap_steps * step_nodes) % 100


def test_a_file_goes_round_again(tmp_path: Path) -> None:
    scene = file_scene(tmp_path, np.zeros((100, 16), dtype=np.int16), "rolling.duration_s=0.004")
    assert (scene.track.steps, scene.track.closed) == (200, True)
    scene = file_scene(tmp_path, np.zeros((100, 16)), "rolling.duration_s=0.003")
    assert (scene.track.steps, scene.track.closed) == (150, False)
    assert file_scene(tmp_path, np.zeros((100, 16)), "rolling.duration_s=1e-9").track.steps == 1
    assert resound(scene, ["rolling.speed_m_s=0.2"]).rolling.duration_s == pytest.approx(0.0015)


@pytest.mark.parametrize(
    ("heights", "message"),
    [
        (
            np.zeros((9, 9, 9)),
            "got a 3-D array, allowed: one 2-D array of real heights, (along track, across), or a",
        ),
        (
            np.zeros((9, 9), dtype=complex),
            "got 2-D complex128, allowed: one 2-D array of real heights, ",
        ),
        (
            np.zeros((9, 9), dtype=bool),
            "got 2-D bool, allowed: one 2-D array of real heights, ",
        ),
        (np.zeros((9, 7)), "got 9 x 7 nodes, allowed: at least 8 each way"),
    ],
)
def test_files_of_wrong_shape(tmp_path: Path, heights: Any, message: str) -> None:
    with pytest.raises(SceneError) as error:
        _ = file_scene(tmp_path, heights).track
    assert str(error.value).startswith(f"surface.path: heights.npy: {message}")


def test_files_that_are_none(tmp_path: Path) -> None:
    scene = file_scene(tmp_path, np.zeros((9, 9)))
    path = tmp_path / "heights.npy"
    path.write_text("1 2 3\n")
    with pytest.raises(SceneError, match=r"^surface.path: heights.npy: no readable .npy file"):
        _ = scene.track
    with path.open("wb") as stream:
        np.savez(stream, a=np.zeros((9, 9)))
    with pytest.raises(SceneError, match=r"no readable .npy file"):
        _ = scene.track
    path.write_bytes(b"")
    with pytest.raises(SceneError, match="no readable"):
        _ = scene.track
    path.unlink()
    with pytest.raises(SceneError) as error:
        _ = scene.track
    assert str(error.value) == f"surface.path: heights.npy: no such file (looked in {tmp_path})"
    path.mkdir()
    with pytest.raises(SceneError, match="is a folder"):
        _ = scene.track


def test_a_file_that_is_never_rounded(tmp_path: Path) -> None:
    scene = file_scene(tmp_path, np.zeros((100, 16)), "rolling.speed_m_s=[[0, 0.1], [0.001, 0]]")
    with pytest.raises(SceneError) as error:
        _ = scene.track
    assert str(error.value) == (
        "rolling.speed_m_s: the sphere comes to rest after 5e-5 m, once round the height file is "
        "0.0002 m: give it"
        " more speed or set rolling.duration_s"
    )


def test_an_absolute_path_stays(tmp_path: Path) -> None:
    scene = file_scene(tmp_path, np.zeros((9, 9)), f"surface.path={tmp_path / 'heights.npy'}")
    assert loads(dump(scene), folder=Path("elsewhere")).height_path == tmp_path / "heights.npy"
