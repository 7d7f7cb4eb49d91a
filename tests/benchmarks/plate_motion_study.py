"""Motion over plates with edges: against the linear chain, and against shorter time steps.

`python tests/benchmarks/plate_motion_study.py` marches the track of `ball-on-plate` and prints the
numbers of docs/dynamics.md, in a minute of one core.
"""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

import rolling as rc
from acoustics.arrays import Array
from rolling.dynamics.bodies import Chain
from rolling.dynamics.force_law import ForceLaw
from rolling.dynamics.motion import BodyMotion, Stepping, move
from rolling.in_si.physics_of_scene import bodies_of
from rolling.scene.scene import Scene

SCENE = Path(__file__).parents[2] / "scenarios" / "ball-on-plate.yaml"
EDGES_MM = 300, 400
CASES = (  # thickness [mm], speed [m/s], loss factor
    *((1, 0.3, 0.01), (3, 0.3, 0.01), (3, 1, 0.01), (10, 0.3, 0.01), (10, 1, 0.01)),
    *((3, 1, 0.001), (10, 0.3, 0.001)),
)
STEPS = (28, 40, 80)  # in a period of the resonance
REFERENCE = 320  # steps in a period of the resonance
HEARD_HZ = 20, 20e3


def bodies(scene: Scene, law: ForceLaw, thickness_mm: float, loss_factor: float) -> Chain:
    """Return ball and plate with edges."""
    plate = {"thickness_mm": thickness_mm, "loss_factor": loss_factor}
    plate |= {"length_mm": EDGES_MM[0], "width_mm": EDGES_MM[1]}
    return bodies_of(scene.with_({f"plate.{k}": v for k, v in plate.items()})).chain_over(law)


def lines(motion: BodyMotion) -> tuple[Array, Array]:
    """Return frequencies [Hz] within hearing and phasors [N] of the force, from time zero."""
    count = len(motion.force_n)
    order = np.arange(count // 2 + 1)
    force = np.fft.rfft(motion.force_n) / count * np.exp(-1j * np.pi * order / count)
    frequency = order / (motion.time_step_s * count)
    heard = (frequency > HEARD_HZ[0]) & (frequency < HEARD_HZ[1])
    return frequency[heard], force[heard]


def rms(force: Array) -> float:
    """Return the rms [N] of phasors of one sign of the frequency."""
    return float(np.sqrt(2 * np.sum(np.square(np.abs(force)))))


def main() -> None:
    """Print both tables."""
    scene = rc.read_scene(SCENE).with_(sweep={}, error_estimate=False, speed_m_s=0.3)
    run = rc.simulate(scene, workers=2, progress=False)
    assert run.vibration_sound is not None
    law = run.vibration_sound.law
    load = scene.load
    assert law.period_m is not None
    roughness = -np.fft.rfft(law.approach(law.position_m, load)) / len(law.position_m)
    print("| plate, speed, loss factor | motion | linear chain |\n|---|---|---|")
    for thickness, speed, loss in CASES:
        parts = bodies(scene, law, thickness, loss)
        frequency, force = lines(move(law, parts, load, speed))
        order = np.round(frequency * law.period_m / speed).astype(int)
        chain = parts.force(frequency, roughness[order])
        row = f"{thickness} mm, {speed} m/s, {loss}"
        print(f"| {row} | {1e3 * rms(force):.3g} mN | {1e3 * rms(chain):.3g} mN |", flush=True)
    print("\n| plate, speed, steps in a period | error | level | s per s |\n|---|---|---|---|")
    for thickness, speed, loss in CASES[1:5]:
        parts = bodies(scene, law, thickness, loss)
        reference = lines(move(law, parts, load, speed, stepping=Stepping(REFERENCE)))[1]
        for steps in STEPS:
            begin = time.process_time()
            motion = move(law, parts, load, speed, stepping=Stepping(steps))
            taken = (motion.laps + 1) * law.period_m / speed
            cost = (time.process_time() - begin) / taken
            force = lines(motion)[1]
            error = 20 * np.log10(rms(force - reference) / rms(reference))
            level = 20 * np.log10(rms(force) / rms(reference))
            row = f"{thickness} mm, {speed} m/s, {steps}"
            print(f"| {row} | {error:.0f} dB | {level:.3f} dB | {cost:.2f} |", flush=True)


if __name__ == "__main__":
    main()
