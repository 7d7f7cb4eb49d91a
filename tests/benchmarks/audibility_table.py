"""How many decibels of rolling noise are audible in a quiet room.

`python tests/benchmarks/audibility_table.py` hears the vibration of three scenes at levels from 5
to 57.5 dB(A) in the default room of 30 dB(A). It prints by how much a sound of each level must grow
until N5 of room and sound grows by 4 % and by 8 %. Seven minutes of one core; it needs mosqito.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import acoustics
import rolling as rc
from acoustics.arrays import Array
from acoustics.audibility import AUDIBLE_PERCENT, NOT_AUDIBLE_PERCENT

SCENARIOS = Path(__file__).parents[2] / "scenarios"
# Scenes with their settings: a thick plate, and a thin sheet at two speeds.
SCENES = {
    "steel ball on a plate of 10 mm": ("vibrating-ball", {"rolling.load_n": 20}, 0.1),
    "steel ball on a sheet of 1 mm": ("round-ball-on-sheet", {}, 0.02),
    "the same sheet at a third of the speed": (
        "round-ball-on-sheet",
        {"rolling.speed_m_s": 0.1},
        0.06,
    ),
}
HEARD_DB = np.linspace(5.0, 57.5, 22)  # levels at which a sound is heard, dB(A)
SHOWN_DB = (10, 15, 20, 25, 30, 35, 40, 50)  # dB(A)


def record(name: str, settings: dict[str, float], duration_s: float) -> rc.Run:
    """Return a short run of a scene that is heard by its vibration."""
    scene = rc.read_scene(SCENARIOS / f"{name}.yaml")
    changes = {**settings, "numerics.error_estimate": False, "sound.listen_s": None}
    if scene.rolling.distance_mm is not None:
        speed = settings.get("rolling.speed_m_s", scene.rolling.speed_m_s)
        changes["rolling.distance_mm"] = 1e3 * speed * duration_s
    else:
        changes["rolling.duration_s"] = duration_s
    scene = rc.Scene.from_dict({**scene.to_dict(), "sweep": {}}, scene.folder)
    return rc.simulate(scene.with_(changes), workers=1, progress=False)


def n5_by_level(pressure: Array, rate: float, closed: bool) -> Array:
    """Return N5 of room and sound at the levels HEARD_DB, in the same noises [sone]."""
    at_0_db = pressure * 10.0 ** (-acoustics.laeq_db(pressure, rate) / 20.0)
    values = []
    for lower_db, upper_db in HEARD_DB.reshape(-1, 2):
        pair = acoustics.audible_difference(
            records_a=[at_0_db * 10.0 ** (lower_db / 20.0)],
            records_b=[at_0_db * 10.0 ** (upper_db / 20.0)],
            sample_rate_hz=rate,
            closed_a=closed,
            closed_b=closed,
        )
        values += [pair.n5_a_sone, pair.n5_b_sone]
    return np.array(values)


def growth_db(n5: Array, level_db: float, percent: float) -> float:
    """Return the increase of a level that lets N5 grow by a percentage; NaN beyond the levels."""
    logarithm = np.log(n5)
    wanted = np.interp(level_db, HEARD_DB, logarithm) + np.log1p(percent / 100.0)
    rising = np.maximum.accumulate(logarithm)
    if wanted > rising[-1]:
        return float("nan")
    return float(np.interp(wanted, rising, HEARD_DB)) - level_db


def main() -> None:
    """Print one table for each scene."""
    for title, (name, settings, duration_s) in SCENES.items():
        run = record(name, settings, duration_s)
        sound = run.sound
        n5 = n5_by_level(sound.pressure, sound.sample_rate, sound.closed)
        print(f"\n{title}: LAeq {run.sound.levels.laeq_db:.1f} dB, {run.sound.source}\n")
        print("|level, dB(A)|N5, sone|not audible below, dB|audible above, dB|\n|---|---|---|---|")
        for level in SHOWN_DB:
            least = growth_db(n5, level, NOT_AUDIBLE_PERCENT)
            most = growth_db(n5, level, AUDIBLE_PERCENT)
            loudness = np.exp(np.interp(level, HEARD_DB, np.log(n5)))
            print(f"|{level}|{loudness:.2f}|{least:.1f}|{most:.1f}|", flush=True)


if __name__ == "__main__":
    main()
