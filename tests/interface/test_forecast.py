"""Forecasts hold all parts of a run, and a bar of progress never goes back."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from bearing_runs import loads_bearing
from finished import VIBRATING
from scene_text import PLAIN

import rolling
from rolling.archive.definition import in_group
from rolling.ball_kinds.balls import KIND
from rolling.ball_kinds.rolling_ball import ROLLING
from rolling.bearing_kind import bearing_forecast, bearing_simulation
from rolling.bearing_kind.bearing_forecast import BearingForecast, forecast_of
from rolling.bearing_kind.contact_plan import contact_plan
from rolling.check import cost, forecast
from rolling.check.findings import check_scene, conclusion
from rolling.kinds.registry import kind_of
from rolling.marches import march_piece
from rolling.marches.march_variables import MAPS_GROUP, STATE_SERIES, STEP_SERIES
from rolling.marches.observers import maps_arrays
from rolling.marches.piece import Piece
from rolling.run.executor import RunLoop
from rolling.run.pools import local_pool
from rolling.scene.bearing_scene import BearingScene
from rolling.scene.file import loads
from rolling.terminal import progress

# A ball whose force leaves the loads of its first marches.
LOUD = ("rolling.distance_mm=0.24", "surface.roughness_ra_um=0.3", "numerics.error_estimate=false")


class Recorded(progress.Bar):
    """A bar that notes the share that it shows and the sum of its progress."""

    def __init__(self, clock: list[float]) -> None:
        super().__init__(0.0, "recorded", False)
        self.clock = clock
        self.shares = list[float]()
        self.sums = [0.0]

    def grow(self, share: float) -> None:
        super().grow(share)
        self.sums.append(self.sums[-1] + share)

    def tick(self) -> None:
        self.clock[0] += 40.0  # each look comes after the time of a line
        super().tick()
        self.shares.append(self.share)


@pytest.mark.parametrize("changes", [LOUD, (*LOUD, "sweep.rolling.speed_m_s=[0.1, 0.3]")])
def test_the_progress_of_a_run_never_goes_back(
    changes: tuple[str, ...],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Marches at more loads turn up when the track is solved; they were forecast, or it rests."""
    clock = [0.0]
    monkeypatch.setattr("time.monotonic", lambda: clock[0])
    monkeypatch.setattr(progress, "LINE_SECONDS", 30.0)
    scenes = [run.scene for run in loads(VIBRATING, changes).runs()]
    with progress.begin(progress.Level.NORMAL), local_pool(1, scenes) as pool:
        bar = Recorded(clock)
        marches = [KIND.marches(scene) for scene in scenes]
        loop = RunLoop(marches, KIND.march_store(), bar)
        assert len([*loop.finished_runs(pool)]) == len(scenes)
    assert not loop.failures
    assert bar.shares == sorted(bar.shares) and bar.shares[-1] == pytest.approx(1.0)
    lines = [line for line in capsys.readouterr().err.splitlines() if " %, " in line]
    percents = [int(line.split(": ")[1].split(" %")[0]) for line in lines]
    assert len(percents) > 3 and percents == sorted(percents)
    # What was forecast at the start is most of what is marched.
    assert bar.sums[-1] < 2.5 * forecast.march_seconds(scenes[0]) * len(scenes)


def test_a_bar_whose_sum_grows_rests() -> None:
    bar = progress.Bar(10.0, "growing", False)
    bar.update(8.0)
    assert bar.share == pytest.approx(0.8)
    bar.grow(30.0)
    assert bar.share == pytest.approx(0.8)
    bar.update(28.0)
    assert bar.share == pytest.approx(0.9)


def test_a_forecast_counts_start_files_and_page() -> None:
    """A run of milliseconds takes seconds, and a sweep its figures and a part of the page a run."""
    short = ("surface.width_um=256", "rolling.load_n=1", "rolling.duration_s=0.002")
    single = check_scene(loads(PLAIN, short), solve=False)
    marched = next(x.seconds for x in single if x.key == "expected_time")
    assert marched < 1.0 < 3.0 * cost.cores() < single.seconds
    assert "in a few seconds" in conclusion(loads(PLAIN, short), single)
    swept = loads(PLAIN, (*short, "sweep.surface.seed=[1, 2, 3]"))
    many = check_scene(swept, solve=False)
    assert many.seconds > single.seconds + forecast.FIGURES * cost.cores()


def test_a_forecast_counts_the_pilots_of_a_scene() -> None:
    """Each load has its pilot, and a short track has none."""
    long = ("surface.width_um=256", "rolling.load_n=1", "rolling.duration_s=0.2")
    for changes, pilots in (
        (long, 1),
        ((*long, "sweep.rolling.load_n=[1, 2]"), 2),
        ((*long, "rolling.duration_s=0.002"), 0),
    ):
        scene = loads(PLAIN, changes)
        pilot = ROLLING.pilot(scene.runs()[0].scene)
        assert (pilot is not None) == (pilots > 0)
        without = check_scene(scene, solve=False).seconds
        seconds = kind_of(scene).check(scene, solve=False).seconds
        marched = 0.0 if pilot is None else pilots * forecast.march_seconds(pilot.scene)
        assert seconds >= without + marched
        assert (seconds > without) == (pilots > 0)


def test_a_long_run_is_forecast_in_numbers() -> None:
    """A motion over modes of a plate counts, and marches at further loads."""
    plate = ("plate.length_mm=300", "plate.width_mm=300", "sound.distance_m=1")
    scene = loads(VIBRATING, plate)
    assert forecast.motion_seconds(scene) > 2 * forecast.motion_seconds(loads(VIBRATING)) > 0
    assert forecast.march_seconds(scene) >= scene.dynamics.loads * cost.lap_seconds(scene)
    assert forecast.takes(100.0 * cost.cores()) == f"about 100 s on {cost.cores()} core" + (
        "s" if cost.cores() > 1 else ""
    )
    assert forecast.takes(5.0 * cost.cores()) == "a few seconds"


# ---- bearings

ROUGH_BEARING = """
name: rough
bearing:
  named: "6204"
  speed_rpm: 1800
  axial_load_n: 70
  surfaces:
    inner: {kind: gaussian, roughness_ra_um: 0.05, correlation_length_um: 20, seed: 1}
numerics: {window_mm: 3}
sound: {duration_s: 0.02, listen_s: 0.1}
"""
PIT = "bearing.surfaces.inner.faults=[{kind: pit, at_mm: [20, 0], size_um: 300, depth_um: 5}]"


class Counted:
    """Pieces and motions of a run, whose contacts are not solved."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.pieces: list[Piece] = []
        self.motions = 0
        moved_ring = bearing_simulation.moved_ring

        def counted_motion(*values: Any) -> Any:
            self.motions += 1
            return moved_ring(*values)

        monkeypatch.setattr(march_piece, "march_piece", self.march)
        monkeypatch.setattr(bearing_simulation, "moved_ring", counted_motion)

    def march(self, piece: Piece) -> dict[str, Any]:
        """Return a piece with approaches by chance."""
        self.pieces.append(piece)
        steps = piece.last - piece.first
        random = np.random.default_rng(len(self.pieces))
        approach = 1e-6 + 1e-9 * random.standard_normal(steps + 1)
        arrays = {name: np.ones(steps) for name in STEP_SERIES}
        arrays |= {name: np.ones(steps + 1) for name in STATE_SERIES}
        return arrays | {"approach": approach} | in_group(MAPS_GROUP, maps_arrays([]))


def bearing_forecast_of(scene: BearingScene) -> BearingForecast:
    """Return the forecast of the runs of a scene."""
    return forecast_of([(run, contact_plan(run)) for _, run in scene.runs()])


@pytest.mark.parametrize("changes", [[], [PIT]])
def test_a_forecast_of_a_bearing_counts_what_is_computed(
    changes: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Marches at all loads, stretches with a pit and without, motions, and the healthy sister."""
    scene = loads_bearing(ROUGH_BEARING, changes)
    expected = bearing_forecast_of(scene)
    counted = Counted(monkeypatch)
    rolling.simulate(scene, workers=1, progress=False)
    assert expected.marches == len({piece.identity for piece in counted.pieces})
    assert expected.starts == len(counted.pieces)
    assert expected.steps == sum(piece.last - piece.first for piece in counted.pieces)
    assert counted.motions == 1 + len(changes)
    assert expected.motions == counted.motions + 1  # a command has a pilot beside the run
    if changes:
        healthy = bearing_forecast_of(loads_bearing(ROUGH_BEARING))
        assert expected.marches > healthy.marches > 1


def test_a_smooth_bearing_moves_once_and_a_sweep_shares_its_marches(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    smooth = loads_bearing(ROUGH_BEARING, ["bearing.surfaces.inner={kind: smooth}"])
    counted = Counted(monkeypatch)
    rolling.simulate(smooth, workers=1, progress=False)
    expected = bearing_forecast_of(smooth)
    assert expected.motions == counted.motions == 1
    assert expected.marches == expected.steps == 0 == len(counted.pieces)
    single = bearing_forecast_of(loads_bearing(ROUGH_BEARING))
    balls = "{round: {kind: smooth}, wavy: {kind: smooth, waviness: {4: 0.1}}}"
    changes = [f"sweep.bearing.surfaces.balls={balls}"]
    swept = bearing_forecast_of(loads_bearing(ROUGH_BEARING, changes))
    assert swept.motions == 2 * single.motions  # each run is heard early
    assert swept.steps == single.steps and swept.march_s == single.march_s


def test_a_first_run_of_a_bearing_is_forecast_with_its_compilation(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rough = loads_bearing(ROUGH_BEARING)
    smooth = loads_bearing(ROUGH_BEARING, ["bearing.surfaces.inner={kind: smooth}"])
    monkeypatch.setattr(bearing_forecast, "is_kept", lambda kernel: True)
    kept = rough.check()
    assert bearing_forecast_of(rough).compilations == ()
    monkeypatch.setattr(bearing_forecast, "is_kept", lambda kernel: False)
    assert bearing_forecast_of(rough).compilations == ("march", "motion")
    assert bearing_forecast_of(smooth).compilations == ("motion",)
    compiling = rough.check()
    seconds = sum(bearing_forecast.COMPILATION.values())
    assert compiling.seconds == pytest.approx(kept.seconds + cost.cores() * seconds)
    ((_, text),) = compiling.of_all
    assert text.endswith("with compilation of the march and the motion")
    assert f"on {cost.cores()} core" in text
