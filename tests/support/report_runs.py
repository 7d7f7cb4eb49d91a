"""Run folders for the tests of reports.

Each takes a third of a second to solve and has up to a second of sound.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from rolling import commands
from rolling.commands import Wanted, work
from rolling.folders import run_record
from rolling.simulation import batch, result_file, simulate, slow_march
from rolling.simulation.run_result import RunResult
from rolling.surface import heights

NO_PAGE = Wanted(workers=1, page=False)
STEPS = 300  # once round: 0.6 mm, 6 ms
HOSTILE = "quoted \"one\" 'two' & </script><img src=x onerror=alert(1)><!-- <script>"

SCENE = """\
name: small
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}
surface: {kind: file, path: PATH, spacing_um: 2}
rolling: {load_n: 1, speed_m_s: 0.1, duration_s: 0.9}
"""
SMOOTH = """\
name: silence
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3}
surface: {kind: smooth, spacing_um: 2, width_um: 120}
rolling: {load_n: 1, speed_m_s: 0.1, duration_s: 0.002}
"""
FLYING = """\
name: flying
sphere: {radius_mm: 3, density_kg_m3: 7850}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, density_kg_m3: 7850, thickness_mm: 10}
surface: {kind: file, path: PATH, spacing_um: 2}
rolling: {load_n: 0.3, speed_m_s: 1, distance_mm: 0.6}
dynamics: {}
sound: {source: vibration}
sweep: {rolling.speed_m_s: [0.1, 1]}
"""


class Runs:
    """Run folders below one folder, each made when it is first asked for and never changed."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.heights = folder / "z<i>.npy"
        np.save(
            self.heights, heights.gaussian((STEPS, 100), 2e-6, 1e-7, (1e-5, 1e-5), "gaussian", 3)
        )

    def _made(self, name: str, text: str, *settings: str) -> Path:
        out = self.folder / name
        if not out.exists():
            scene = self.folder / f"{name}.yaml"
            scene.write_text(text.replace("PATH", f"'{self.heights}'"))
            with pytest.MonkeyPatch.context() as patch:
                # files beside the page, not in it
                patch.setattr(work, "write_pictures", lambda *_: [])
                assert commands.run(scene, settings, out, wanted=NO_PAGE).exit_code == 0
        return out

    def _copied(self, source: Path, name: str) -> tuple[Path, bool]:
        out = self.folder / name
        new = not out.exists()
        if new:
            shutil.copytree(source, out)
        return out, new

    def three(self) -> Path:
        return self._made("three", SCENE, "sweep.rolling.load_n=[0.5, 1, 2]")

    def one(self) -> Path:
        """Return a single run whose scene tries to break out of the page."""
        quoted = HOSTILE.replace("'", "''")
        return self._made("one", SCENE + f"description: '{quoted}'\n")

    def smooth(self) -> Path:
        return self._made("smooth", SMOOTH)

    def lap(self) -> Path:
        """Return a run of one lap: 6 ms that loop."""
        return self._made("lap", SCENE.replace("0.9", "0.006"))

    def filmed(self) -> Path:
        """Return a run of one lap with a slow motion, for which it is really too short."""
        return self._filmed("filmed", SCENE.replace("0.9", "0.006"))

    def flying(self) -> Path:
        """Return two speeds of a vibrating ball with a slow motion; the faster ball flies."""
        return self._filmed("flying", FLYING)

    def _filmed(self, name: str, text: str) -> Path:
        out = self.folder / name
        if not out.exists():
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(slow_march, "SHARE", 0.3)
                patch.setattr(work, "write_pictures", lambda *_: [])
                scene = self.folder / f"{name}.yaml"
                scene.write_text(text.replace("PATH", f"'{self.heights}'"))
                assert commands.run(scene, [], out, wanted=Wanted(workers=1)).exit_code == 0
        return out

    def partial(self) -> Path:
        """Return a run that stopped after 200 of the 300 steps of its only lap."""
        out, new = self._copied(self.lap(), "partial")
        if new:
            run_of = commands.read_runs(out)[0]
            result = result_file.load(out / "result.h5")
            for name in simulate.STEP_SERIES:
                result.series[name][200:] = np.nan
            for name in simulate.STATE_SERIES:
                result.series[name][201:] = np.nan
            result.maps = {
                position: one for position, one in result.maps.items() if position <= 200
            }
            batch.keep(run_of, result)
            run_record.write(out, run_record.new("run"))
        return out

    def old(self) -> Path:
        """Return a run folder from the time before pressure maps were kept."""
        out, new = self._copied(self.one(), "old")
        if new:
            result = result_file.load(out / "result.h5")
            result.maps = {}
            batch.keep(commands.read_runs(out)[0], result)
        return out

    def fast(self) -> Path:
        """Return the single run at twice the speed, half as long, which loops."""
        return self._resounded("fast", "rolling.speed_m_s=0.2")

    def braking(self) -> Path:
        """Return the single run at a changing speed, which is shorter and does not loop."""
        return self._resounded("braking", "rolling.speed_m_s=[[0, 0.4], [0.1, 0.2]]")

    def _resounded(self, name: str, setting: str) -> Path:
        out = self.folder / name
        if not out.exists():
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(work, "write_pictures", lambda *_: [])
                assert commands.resound(self.one(), [setting], out, wanted=NO_PAGE).exit_code == 0
        return out


def run_results(folder: Path) -> list[RunResult]:
    """Return the runs of a folder with their sound, in the order of its sweep."""
    results = [
        commands.hear(
            run.label, run.values, run.folder, run.scene, result_file.load(run.folder / "result.h5")
        )
        for run in commands.read_runs(folder)
    ]
    return [result for result in results if result]


_made: dict[Path, Runs] = {}


def runs_in(folder: Path) -> Runs:
    """Return the run folders of a test session, made once."""
    if folder not in _made:
        folder.mkdir(exist_ok=True)
        _made[folder] = Runs(folder)
    return _made[folder]
