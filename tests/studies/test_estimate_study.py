"""The study that tests the error estimate, on a short and light scene."""

import json
from pathlib import Path

import pytest

from rolling.accuracy import estimate_study
from rolling.accuracy.estimate_study import SCENES, BandRow, compare, numbers, scene_of, table
from rolling.check import error_cost
from rolling.contact.solver import ContactError
from rolling.simulation.pool import Outcome

SHORT = {"rolling.load_n": 0.1, "surface.width_um": 128, "rolling.duration_s": 0.024}


@pytest.mark.slow
def test_estimates_agree_with_a_finer_grid_on_the_whole_track(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(error_cost, "SHARE", 3.0)
    scene = scene_of("Ra 0.1, 0.3 N", **SHORT)
    done = compare("short", scene, 4, workers=1, progress=False)
    assert done.right >= 0.9 * len(done.bands) > 10
    assert done.laeq.right and abs(done.laeq.off) < 0.3
    # It tells more than that bands are uncertain: errors above 1 dB are found.
    loud = [row for row in done.bands if abs(row.true) > 1.0]
    assert loud and all(row.estimated * row.true > 0 for row in loud)
    text = table([done])
    assert f"{done.right} of {len(done.bands)}" in text
    assert json.loads(json.dumps(numbers(done)))["rows"][0]["name"] == "LAeq"


@pytest.mark.parametrize(
    ("estimated", "uncertainty", "true", "right"),
    [
        (1.0, 0.1, 1.29, True),
        (1.0, 0.1, 1.31, False),
        (1.0, 0.5, 1.9, True),
        (0.0, 0.4, -0.9, False),
    ],
)
def test_an_estimate_is_right_if_it_is_near_or_within_twice_its_uncertainty(
    estimated: float, uncertainty: float, true: float, right: bool
) -> None:
    assert BandRow("1000", estimated, uncertainty, true).right is right


def test_all_scenes_of_the_study_pay_for_an_estimate() -> None:
    assert len(SCENES) == 8
    for name in SCENES:
        scene = scene_of(name)
        assert scene.numerics.error_estimate and error_cost.too_short(scene) is None


def test_failures_and_unknown_scenes_are_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(ContactError, match="no room"):
        estimate_study.raise_failures(Outcome({0: "no room"}))
    with pytest.raises(KeyboardInterrupt):
        estimate_study.raise_failures(Outcome(interrupted=True))
    with pytest.raises(SystemExit) as error:
        estimate_study.main(["Ra 7", "--out", str(tmp_path / "out.json")])
    assert error.value.code == 2 and "no scene 'Ra 7'" in capsys.readouterr().err
    assert not (tmp_path / "out.json").exists()
