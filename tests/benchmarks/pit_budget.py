"""What makes the rise of a band by a pit: each cause alone and together, beside recordings.

`python tests/benchmarks/pit_budget.py` prints the tables of docs/bearings.md:

- `dips` has how far a ball dips over each pit, dry and through a film of oil.
- `causes` has the rises over the healthy bearing in the medium and in the high band [dB].

The bearing is that of `rolling validate recordings` with the values that its fit finds, but dry.
Pits are marched over the surfaces of the fit, and what they change of the approach is added to the
tracks of all causes whose balls carry the same loads. Rough contacts respond linearly. Words of a
cause after `causes` print the rows that hold one of them.
"""

from __future__ import annotations

import argparse
import functools
import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from acoustics.arrays import Array
from rolling.bearing import waves
from rolling.bearing.model import BearingModel
from rolling.bearing.ring_motion import move_ring
from rolling.bearing.ring_record import RingRecord, record_of
from rolling.bearing.tracks import BearingTracks, BodyTrack
from rolling.bearing_kind.contact_marches import march_contacts
from rolling.bearing_kind.contact_plan import ContactPlan, contact_of, contact_plan, radius_of
from rolling.bearing_kind.joined_tracks import bearing_tracks, film_of, rows_through_film
from rolling.scene.bearing_scene import BearingScene
from rolling.scene.file import read_as
from rolling.studies import recording_truths, validate

RECORD_S = 0.5
SHORT_S = 0.2  # of balls with mass, whose motion takes six times as long
# As `rolling validate recordings` prints what it fits to the healthy record.
SURFACES = "without waves"
FITTED = {
    "bearing.radial_clearance_um": 2.0,
    "bearing.axial_load_n": 100.0,
    "bearing.radial_load_n": 200.0,
}
HOUSING_KG = 1.0
OIL = {"bearing.oil": {"viscosity_40_mm2_s": 100}}
DRY = {"bearing.oil": None, "bearing.contact_loss_factor": 0.02}
ELASTIC = {"bearing.ring": "elastic"}
BALL_MASS = {"bearing.ball_inertia": True}
RIM_WIDTH_UM = 40.0
SMALL_UM, LARGE_UM = 180.0, 530.0


class Pit(NamedTuple):
    """A pit of a ring: diameter [um] and height of its rim [um]."""

    ring: str
    size_um: float
    rim_um: float = 0.0


@dataclass(frozen=True)
class Cause:
    """What is another than in the dry bearing.

    changes : dict. Keys of the scene.
    surfaces : str. Name of surfaces that the fit tries.
    housing_kg : float. Mass that moves with the outer ring.
    dips : float. Factor of what a pit changes of the approach.
    film : bool. Whether a film of oil acts over the pit, too.
    rim_um : float. Height of the rims of pits.
    sizes_um : tuple of float. Pits.
    record_s : float. Length of the records.
    """

    changes: Mapping[str, Any] = field(default_factory=dict)
    surfaces: str = SURFACES
    housing_kg: float = HOUSING_KG
    dips: float = 1.0
    film: bool = False
    rim_um: float = 0.0
    sizes_um: tuple[float, ...] = recording_truths.PITS_UM
    record_s: float = RECORD_S


class Moved(NamedTuple):
    """A bearing that was moved: what `recording_truths.in_seat` reads of a run."""

    record: RingRecord
    model: BearingModel


ENDS = (SMALL_UM, LARGE_UM)  # of causes that need marches of their own, or take long
HALF_LOADS = {"bearing.axial_load_n": 50.0, "bearing.radial_load_n": 100.0}
CAUSES = {
    "none: dry, rigid, loss factor 0.02, raceways without waves": Cause(),
    "elastic ring": Cause(ELASTIC),
    "loss factor 0.1": Cause({"bearing.contact_loss_factor": 0.1}),
    "oil of 100 mm²/s, as in the fit": Cause(OIL),
    "the same, with the film over pits too": Cause(OIL, film=True),
    "half a kilogram": Cause(housing_kg=0.5),
    "5 kg": Cause(housing_kg=5.0),
    "superfinished raceways, waves across": Cause(surfaces="superfinished"),
    "superfinished raceways, isotropic waves": Cause(surfaces="superfinished, isotropic"),
    "dips ten times as deep": Cause(dips=10.0, sizes_um=(SMALL_UM,)),
    "dips twenty times as deep": Cause(dips=20.0, sizes_um=(SMALL_UM,)),
    "oil, film over pits, elastic ring": Cause(OIL | ELASTIC, film=True),
    "none, records of 0.2 s": Cause(sizes_um=ENDS, record_s=SHORT_S),
    "balls with mass, records of 0.2 s": Cause(BALL_MASS, sizes_um=ENDS, record_s=SHORT_S),
    "rim of 0.5 µm, 40 µm wide": Cause(rim_um=0.5, sizes_um=(SMALL_UM,)),
    "rim of 1 µm": Cause(rim_um=1.0, sizes_um=(SMALL_UM,)),
    "rim of 2 µm": Cause(rim_um=2.0, sizes_um=(SMALL_UM,)),
    "fixed angle": Cause({"bearing.angle": "fixed"}, sizes_um=ENDS),
    "half the loads": Cause(HALF_LOADS, sizes_um=ENDS),
}


def scene_of(cause: Cause) -> BearingScene:
    """Return the healthy bearing of a cause: that of the recordings as fitted, but dry."""
    scene = read_as(validate.FOLDER / "recorded-6205.yaml", BearingScene)
    surfaces = recording_truths.SURFACES[cause.surfaces]
    return scene.with_(FITTED | surfaces | DRY | dict(cause.changes))


# ---- pits


@functools.cache
def change_by(pit: Pit, loads: tuple[float, float, str]) -> BodyTrack:
    """March a pit, and return what it changes of the approach around its raceway.

    Parameters
    ----------
    pit : Pit
    loads : tuple
        Axial and radial load [N], and whether the angle moves or is fixed.
    """
    axial_n, radial_n, angle = loads
    changes = {
        "bearing.axial_load_n": axial_n,
        "bearing.radial_load_n": radial_n,
        "bearing.angle": angle,
    }
    healthy = scene_of(Cause(changes))
    fault = {
        "kind": "pit",
        "at_mm": recording_truths.PIT_AT_MM[pit.ring],
        "size_um": pit.size_um,
        "depth_um": recording_truths.PIT_DEPTH_UM,
    }
    if pit.rim_um:
        fault |= {"rim_height_um": pit.rim_um, "rim_width_um": RIM_WIDTH_UM}
    plan = contact_plan(healthy.with_({f"bearing.surfaces.{pit.ring}.faults": [fault]}))
    wanted = [
        scene for stretch in plan.faults for pair in stretch.scenes.values() for scene in pair
    ]
    marches = march_contacts(wanted, name=f"{pit.ring}-{pit.size_um:g}", workers=1, shown=False)
    over = getattr(bearing_tracks(plan, marches), pit.ring)
    beside = getattr(bearing_tracks(plan.without_faults()), pit.ring).resampled(over.points)
    return BodyTrack(over.loads_n, over.approach_m - beside.approach_m)


def change_of(scene: BearingScene, pit: Pit) -> BodyTrack:
    """Return what a pit changes in the bearing of a cause."""
    bearing = scene.bearing
    return change_by(pit, (bearing.axial_load_n, bearing.radial_load_n, bearing.angle))


def through_film(change: BodyTrack, plan: ContactPlan, ring: str) -> BodyTrack:
    """Return what a film of oil leaves of a change, by the law of waves."""
    turn_m = 2 * np.pi * radius_of(plan.geometry, ring)
    rows = rows_through_film(
        change.approach_m, change.loads_n.tolist(), turn_m, film_of(plan, ring), weight=1.0
    )
    return BodyTrack(change.loads_n, rows)


# ---- runs


def moved(scene: BearingScene, tracks: BearingTracks, record_s: float) -> Moved:
    """Move the ring over its tracks."""
    motion = move_ring(scene.model, tracks, record_s)
    return Moved(record_of(motion, scene.kinematics), scene.model)


def reading(run: Moved, housing_kg: float) -> recording_truths.Reading:
    """Read the acceleration of the housing."""
    rate_hz = run.record.rate_hz
    return recording_truths.read(
        recording_truths.in_seat(run, housing_kg), rate_hz, recording_truths.END_HZ[""]
    )


def levels_db(read: recording_truths.Reading) -> Array:
    """Return the levels of the medium and of the high band [dB re 1 um/s]."""
    return 20 * np.log10([read.um_s["medium"], read.um_s["high"]])


def row_of(words: str, cause: Cause) -> str:
    """Return the row of a cause."""
    scene = scene_of(cause)
    plan = contact_plan(scene)
    tracks = bearing_tracks(plan)
    healthy = levels_db(reading(moved(scene, tracks, cause.record_s), cause.housing_kg))
    cells = [words, _pair(healthy)]
    last = ""
    for ring, size_um in itertools.product(recording_truths.LINES, recording_truths.PITS_UM):
        if size_um not in cause.sizes_um:
            cells.append("")
            last = ""  # of the largest pit of the outer ring alone
            continue
        change = change_of(scene, Pit(ring, size_um, cause.rim_um))
        change = BodyTrack(change.loads_n, cause.dips * change.approach_m)
        if cause.film:
            change = through_film(change, plan, ring)
        pitted = replace(tracks, **{ring: getattr(tracks, ring).plus(change)})
        own = reading(moved(scene, pitted, cause.record_s), cause.housing_kg)
        cells.append(_pair(levels_db(own) - healthy))
        line_hz = getattr(scene.kinematics, recording_truths.LINES[ring])
        height = own.envelope.read_line(line_hz).height or 0.0
        last = f"{own.kurtosis:.1f}, {float(f'{height:.2g}'):g}"
    return "|" + "|".join([*cells, last]) + "|"


def _pair(levels: Array) -> str:
    """Write the numbers of two bands without negative zeros."""
    return ", ".join(f"{round(level, 1) + 0.0:.1f}" for level in levels.tolist())


# ---- tables


def recorded_row() -> str:
    """Return the row of the recordings, of both records of each pit."""
    figures = pd.read_csv(validate.FOLDER / "recorded-6205.csv", comment="#")
    known = {(row.quantity, row.item): float(row.value) for row in figures.itertuples()}
    bands = ("300 to 1800 Hz", "1800 to 10000 Hz")
    healthy = 20 * np.log10([known["healthy band", band] for band in bands])
    cells = ["recorded, two records each", _pair(healthy)]
    words = ""
    for ring, size_um in itertools.product(recording_truths.LINES, recording_truths.PITS_UM):
        words = f"{ring} {size_um / 1000:g} mm"
        records = [
            [known["rise", f"{words}, {band}{record}"] for band in ("medium", "high")]
            for record in recording_truths.END_HZ
        ]
        cells.append("; ".join(_pair(np.array(record)) for record in records))
    last = f"{known['kurtosis', words]:.2g}, {known['height of the line', words]:.2g}"
    return "|" + "|".join([*cells, last]) + "|"


def causes_table(only: list[str]) -> Iterator[str]:
    """Yield what each cause makes of the rises by pits."""
    pits = itertools.product(recording_truths.LINES, recording_truths.PITS_UM)
    names = "|".join(f"{ring}, {size_um / 1000:g} mm" for ring, size_um in pits)
    yield f"|cause|healthy, dB re 1 µm/s|{names}|kurtosis and line of the last|"
    yield "|---" * 9 + "|"
    yield recorded_row()
    for words, cause in CAUSES.items():
        if not only or any(word in words for word in only):
            yield row_of(words, cause)


def dips_table(only: list[str]) -> Iterator[str]:
    """Yield how far the centre of a ball dips over pits at the loads of its marches [nm]."""
    yield "|pit|loads|contact, along and across|dip, dry|through a film of 100 mm²/s|"
    yield "|---|---|---|---|---|"
    scene = scene_of(Cause(OIL))
    plan = contact_plan(scene)
    for ring, size_um in itertools.product(recording_truths.LINES, recording_truths.PITS_UM):
        change = change_of(scene, Pit(ring, size_um))
        loads = change.loads_n
        axes = [waves.semi_axes(contact_of(plan.geometry, ring), load) for load in loads]
        along = [2e3 * pair.along for pair in axes]
        across = [2e3 * pair.across for pair in axes]
        dry = 1e9 * change.approach_m.max(axis=1)
        rows = through_film(change, plan, ring).approach_m
        wet = 1e9 * (rows.max(axis=1) - np.median(rows, axis=1))
        yield (
            f"|{ring}, {size_um / 1000:g} mm|{loads[0]:.0f} to {loads[-1]:.0f} N"
            f"|{along[0]:.2f} to {along[-1]:.2f} mm, {across[0]:.1f} to {across[-1]:.1f} mm"
            f"|{dry.min():.0f} to {dry.max():.0f} nm|{wet.min():.0f} to {wet.max():.0f} nm|"
        )


TABLES = {"dips": dips_table, "causes": causes_table}


def main() -> None:
    """Print the tables that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("table", nargs="?", choices=list(TABLES), help="default: all")
    parser.add_argument("words", nargs="*", help="of causes, default: all")
    asked = parser.parse_args()
    for name in [asked.table] if asked.table else TABLES:
        for line in TABLES[name](asked.words):
            print(line, flush=True)
        print()


if __name__ == "__main__":
    main()
