"""A ball on two plates, shortened: force and speed slopes of an independent program."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import rolling as rc

SCENE = Path(__file__).parents[2] / "scenarios" / "ball-on-plate.yaml"
SPEEDS = [0.1, 0.3, 1.0]
FORCE_N = {1: [2.0e-3, 9.9e-3, 41e-3], 10: [14.3e-3, 114e-3, 0.66]}  # rms, on 10 mm of track
SLOPE_DB = {1: 25.0, 10: 33.0}  # per decade of speed, of the plate alone on the axis


@pytest.mark.slow
@pytest.mark.law("Vibration: force and speed slopes of a ball on two plates are as computed apart.")
def test_force_and_slopes() -> None:
    shorter = ["rolling.distance_mm=2", "surface.width_um=256", "sound.ball=false"]
    shorter.append(f"sweep.rolling.speed_m_s={SPEEDS}")
    runs = rc.simulate_sweep(rc.read_scene(SCENE, shorter), workers=1)
    for thickness, forces in FORCE_N.items():
        own = [runs[speed, thickness].numbers for speed in SPEEDS]
        motions = [numbers.motion for numbers in own]
        # A fifth of the track is uncertain by 3 dB where the resonance rings.
        ratios = [motion.force_rms_n / force for motion, force in zip(motions, forces, strict=True)]
        assert np.all(np.abs(20 * np.log10(ratios)) < 3.0), ratios
        levels = [numbers.levels.vibration.level_db for numbers in own]
        slope = np.polyfit(np.log10(SPEEDS), levels, 1)[0]
        assert slope == pytest.approx(SLOPE_DB[thickness], abs=3.0)
        assert all(motion.balance_error < 1e-6 for motion in motions)
