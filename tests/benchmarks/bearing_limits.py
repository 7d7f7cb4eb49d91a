"""Bearings beside the limits of makers, and what the defaults of a bearing change in its bands.

`python tests/benchmarks/bearing_limits.py` prints the tables of docs/bearings.md:

- `limits` has healthy 6204, 608 and 6305 of grade 10 under the loads of ISO 15242, in oil on
  superfinished raceways, beside the limits V0 to V4 of makers and a recorded 6205.
- `causes` has the same 6204 with each of its parts taken away alone.
- `defaults` has the scenes of the library with an elastic ring at a moving angle, over the same
  scenes with a rigid ring at a fixed angle.
- `time` has the time that the motion of a 6204 takes, both ways in turn.

A table alone takes its name as a word. Contacts are linear in their rough heights, so nothing is
marched: that is what a bearing in oil has anyway, and a pit does not count in `defaults`.
"""

from __future__ import annotations

import argparse
import csv
import math
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import rolling as rc
from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing.ring_motion import move_ring
from rolling.bearing.ring_record import record_of
from rolling.bearing.vibration_classes import limits_of_bore
from rolling.bearing_kind.contact_plan import contact_plan
from rolling.bearing_kind.joined_tracks import bearing_tracks

RECORD_S = 2.0  # of the bearings beside the limits
CHANGED_S = 0.5  # of bearings whose difference counts, which have the same tracks
LOADS_N = {"6204": 70, "6305": 150, "608": 20}  # of ISO 15242
OIL = {"viscosity_40_mm2_s": 32, "temperature_c": 30}
RACEWAY = {"kind": "raceway", "finish": "superfinished"}
SURFACES = {
    "balls": {"kind": "graded", "grade": "G10", "wave_exponent": 1, "seed": 1},
    "inner": RACEWAY | {"seed": 2},
    "outer": RACEWAY | {"seed": 3},
}
FORMER = {"bearing.ring": "rigid", "bearing.angle": "fixed", "bearing.tilt": "held"}
CAUSES: Mapping[str, dict[str, Any]] = {
    "no oil, a loss factor of 0.02": {"bearing.oil": None},
    "oil of 10 mm²/s": {"bearing.oil.viscosity_40_mm2_s": 10},
    "oil of 100 mm²/s": {"bearing.oil.viscosity_40_mm2_s": 100},
    "a rigid ring": {"bearing.ring": "rigid"},
    "a ring that does not tilt": {"bearing.tilt": "held"},
    "balls with crests across the track": {"bearing.surfaces.balls.wave_crests": "across"},
    "smooth raceways": {"bearing.surfaces.inner": None, "bearing.surfaces.outer": None},
}
ISOTROPIC = {
    "bearing.surfaces.inner.wave_crests": "isotropic",
    "bearing.surfaces.outer.wave_crests": "isotropic",
}
SMALLER_UM = 0.23 * 22 / 47  # amplitude of waves in proportion to a 608 beside a 6204
IN_PROPORTION = {
    "bearing.surfaces.inner.wave_amplitude_um": SMALLER_UM,
    "bearing.surfaces.outer.wave_amplitude_um": SMALLER_UM,
}
RECORDED = Path(__file__).parents[2] / "scenarios" / "validation" / "recorded-6205.csv"
# The scenes of faults have equal tracks beside their pits.
LIBRARY = ("bearing-6204", "bearing-waviness", "bearing-outer-fault", "bearing-in-housing")
TIMED_S = 0.5
REPEATS = 2


def healthy(named: str) -> rc.BearingScene:
    """Return a healthy bearing of grade 10 as a test stand has it."""
    return rc.BearingScene(
        name=f"healthy-{named}",
        bearing={
            "named": named,
            "speed_rpm": 1800,
            "axial_load_n": LOADS_N[named],
            "tilt": "free",
            "oil": OIL,
            "surfaces": SURFACES,
        },
        sound={"duration_s": RECORD_S, "listen_s": RECORD_S},
    )


def bands_um_s(scene: rc.BearingScene) -> dict[str, list[float]]:
    """Return the velocities of the three bands [um/s] by direction, on linear contacts."""
    tracks = bearing_tracks(contact_plan(scene))
    motion = move_ring(scene.model, tracks, CHANGED_S)
    record = record_of(motion, scene.kinematics)
    return {
        direction: [1e6 * rms for rms in bands.rms_m_s.values()]
        for direction, bands in record.bands.items()
    }


def changes_db(after: list[float], before: list[float]) -> str:
    """Write the changes of three bands [dB] as cells."""
    cells = []
    for new, old in zip(after, before, strict=True):
        decibels = round(20 * math.log10(new / old), 1) + 0.0  # no negative zero
        cells.append("0.0 dB" if decibels == 0 else f"{decibels:+.1f} dB")
    return "|".join(cells)


# ---- tables


def limits_table() -> Iterator[str]:
    """Yield the healthy bearings beside the limits of makers and a recorded bearing."""
    bands = "|".join(f"{low:,.0f} to {high:,.0f} Hz" for low, high in VELOCITY_BANDS_HZ.values())
    yield f"|µm/s rms, radial|{bands}|high over low|"
    yield "|---|---|---|---|---|"
    shown = set[tuple[float, float]]()
    for named in LOADS_N:
        scene = healthy(named)
        limits = limits_of_bore(1e3 * scene.bore)
        assert limits is not None
        bores = (limits.least_mm, limits.most_mm)
        if bores not in shown:
            shown.add(bores)
            for name, um_s in limits.um_s.items():
                cells = "|".join(f"{value:g}" for value in um_s)
                words = (
                    f"{name}, bores of {bores[0]:g} to {bores[1]:g} mm" if name == "V0" else name
                )
                yield f"|{words}|{cells}|{um_s[2] / um_s[0]:.2f}|"
        velocities = rc.simulate(scene, progress=False).numbers.velocities.radial
        cells = "|".join(
            f"{one.value:.0f} ± {one.uncertainty:.1f} dB" for one in velocities.by_band.values()
        )
        ratio = velocities.high.value / velocities.low.value
        yield f"|**`{named}`, G10, {LOADS_N[named]} N**|{cells}|{ratio:.1f}|"
    recorded = [float(row[2]) for row in _recorded("healthy band")]
    cells = "|".join(f"{value:.0f}" for value in recorded)
    ratio = recorded[2] / recorded[0]
    yield f"|a healthy 6205 in a motor, recorded on the housing (CWRU)|{cells}|{ratio:.2f}|"


def _recorded(quantity: str) -> list[list[str]]:
    """Return the rows of the figures of recordings that are of one quantity."""
    lines = [line for line in RECORDED.read_text().splitlines() if not line.startswith("#")]
    return [row for row in csv.reader(lines) if row[0] == quantity]


def causes_table() -> Iterator[str]:
    """Yield what each part of the healthy 6204 changes, taken away or exchanged alone."""
    yield "|in place of the above|50 to 300 Hz|300 to 1,800 Hz|1,800 to 10,000 Hz|"
    yield "|---|---|---|---|"
    causes = {
        "6204": {**CAUSES, "raceways with isotropic waves": ISOTROPIC},
        "608": {
            "raceways with isotropic waves": ISOTROPIC,
            "waves of raceways in proportion to its size": IN_PROPORTION,
        },
    }
    for named, of_named in causes.items():
        whole = healthy(named)
        radial = bands_um_s(whole)["radial"]
        for words, changes in of_named.items():
            changed = bands_um_s(whole.with_(changes))["radial"]
            yield f"|`{named}`: {words}|{changes_db(changed, radial)}|"


def defaults_table() -> Iterator[str]:
    """Yield what an elastic ring at a moving angle changes in the scenes of the library."""
    yield "|scene|direction|50 to 300 Hz|300 to 1,800 Hz|1,800 to 10,000 Hz|"
    yield "|---|---|---|---|---|"
    for name in LIBRARY:
        _, scene = rc.read_scene(name).runs()[0]
        now = bands_um_s(scene)
        before = bands_um_s(scene.with_(FORMER))
        for direction, um_s in now.items():
            yield f"|`{name}`|{direction}|{changes_db(um_s, before[direction])}|"


def time_table() -> Iterator[str]:
    """Yield the processor time of a motion of a 6204, both ways in turn, the least of some."""
    scene = healthy("6204").with_({"bearing.tilt": "held"})
    ways = {"rigid, fixed": scene.with_(FORMER), "elastic, moving": scene}
    ways["elastic, moving, free to tilt"] = healthy("6204")
    least = dict.fromkeys(ways, math.inf)
    for turn in range(REPEATS + 1):
        for words, own in ways.items():
            tracks = bearing_tracks(contact_plan(own))
            began = time.process_time()
            move_ring(own.model, tracks, TIMED_S)
            if turn:  # the first one compiles
                least[words] = min(least[words], time.process_time() - began)
    yield f"|ring|processor time of {TIMED_S:g} s|over rigid, fixed|"
    yield "|---|---|---|"
    for words, seconds in least.items():
        yield f"|{words}|{seconds:.2f} s|{seconds / least['rigid, fixed']:.2f}|"


TABLES = {
    "limits": limits_table,
    "causes": causes_table,
    "defaults": defaults_table,
    "time": time_table,
}


def main() -> None:
    """Print the tables that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tables", nargs="*", help="default: all")
    for name in parser.parse_args().tables or TABLES:
        for line in TABLES[name]():
            print(line, flush=True)
        print()


if __name__ == "__main__":
    main()
