"""Forecasts hold all parts of a run, and a bar of progress never goes back."""

from __future__ import annotations

import pytest
from finished import VIBRATING
from scene_text import PLAIN

from rolling.check import cost, forecast
from rolling.check.findings import check_scene, conclusion
from rolling.run.executor import RunLoop
from rolling.run.pools import local_pool
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
        loop = RunLoop(scenes, bar)
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
