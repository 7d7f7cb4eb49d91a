"""Are levels known as well as `rolling.duration_s: auto` aims at? Short tracks against long ones.

`python tests/benchmarks/length_study.py` draws 20 small scenes at random, by a fixed seed. Of each
it marches 10 surfaces of the length that auto takes, and one that is eight times as long. It counts
how many levels of the short tracks lie within one and within two wanted ± of the long one, for LAeq
and for the third octaves within 10 dB of the loudest one, A-weighted. Beside the wanted ± stands
the ± that the rule expects at this length, which is smaller where another need is longer.

The levels are those of the vibration that the linear chain makes of the solved approach, as a mean
over the places at which a sharp resonance may lie between two lines. The stiffness of the contact
is that of the long track, and levels end with the third octave that the steps resolve, because
these have a ± of their own. Each finished track is a line at the end of a file, so the study goes
on where it stopped. It takes some minutes of one core; scenes whose track of auto has more than
5,000 steps are left out.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from small_scenes import small_scene

import rolling as rc
from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES, EDGES_HZ, third_octave_mean_square
from acoustics.spectrum import audible_lines
from acoustics.weighting import a_weighting_db
from rolling.check import cost
from rolling.in_si.length_rule import expected_vibration, numbers_of
from rolling.in_si.physics_of_scene import bodies_of, listener_of
from rolling.marches.stiffness import solved_stiffness
from rolling.sound.needed_record import BAND_RATIO, LOUD_DB, record_uncertainty
from rolling.sound.radiators import approach_in_time, places_of_lines, roughness_gain

SCENES = 20
SURFACES = 10  # of the length of auto, for each scene
LONGER = 8  # times the length of auto, for the track that stands for the truth
LONG = 0  # number of its surface
MAX_STEPS = 5000  # of a track of auto
MAX_STEP_MS = 1.0
MAX_MODES = 300  # of a plate with edges
OUT = Path("outputs/length_study.jsonl")
# Keys of a vibration, which a march of the contact alone has not.
OF_VIBRATION = ["thickness_mm", "loss_factor", "contact_loss_factor", "length_mm", "width_mm"]


class Levels(NamedTuple):
    """A-weighted levels of a track, to one reference, and the stiffness of its contact [N/m]."""

    laeq_db: float
    bands_db: list[float]  # (31,), -inf in a silent one
    stiffness: float


def scenes(first: int, count: int) -> Iterator[tuple[int, rc.Scene, float]]:
    """Yield scenes with the number of their draw and the distance [mm] that auto takes."""
    number = first
    while count:
        drawn, _ = small_scene(number, steps=1200)
        auto = drawn.with_({"rolling.distance_mm": "auto"})
        ((_, run),) = auto.runs()
        modes = bodies_of(drawn).smooth_chain.modes
        is_small = modes is None or len(modes.angular_frequency) <= MAX_MODES
        if run.track.steps <= MAX_STEPS and cost.step_ms(run) <= MAX_STEP_MS and is_small:
            assert run.rolling.stated_distance_mm is not None  # as auto took it
            yield number, auto, run.rolling.stated_distance_mm
            count -= 1
        number += 1


def levels_of(scene: rc.Scene, stiffness: float | None) -> Levels:
    """March the contact of a scene, and return the levels of its linear vibration.

    The stiffness [N/m] is that of another track, or None for its own.
    """
    changes: dict[str, Any] = {"dynamics": None, "numerics.error_estimate": False}
    changes |= {f"plate.{name}": None for name in OF_VIBRATION}
    bare = scene.with_(changes)
    run = rc.simulate(bare, workers=1, progress=False)
    if stiffness is None:
        stiffness = float(1 / np.mean(1 / solved_stiffness(bare, run.result)))
    bodies = bodies_of(scene)
    chain = bodies.chain(stiffness)
    approach = np.append(run.series["approach"], run.series["approach"][0])
    signal = approach_in_time(scene.motion, approach, run.result.step, looped=True)
    frequency, squares = audible_lines(signal - signal.mean(), len(signal) / scene.duration)
    points = places_of_lines(bodies.plate, chain, frequency, 1 / scene.duration)
    gain = roughness_gain(bodies, listener_of(scene), chain)(points.ravel()).reshape(points.shape)
    weighted = squares * (gain * 10 ** (a_weighting_db(points) / 10)).mean(axis=1)
    bands = third_octave_mean_square(frequency, weighted)
    with np.errstate(divide="ignore"):
        return Levels(
            laeq_db=10 * math.log10(weighted.sum()),
            bands_db=(10 * np.log10(bands)).tolist(),
            stiffness=stiffness,
        )


def solve(first: int, count: int, surfaces: int, out: Path) -> None:
    """Solve the tracks that a file lacks, and write each at its end."""
    done = {_key(entry): entry["stiffness"] for entry in read(out)}
    out.parent.mkdir(parents=True, exist_ok=True)
    began = time.process_time()
    for number, scene, distance_mm in scenes(first, count):
        for surface in range(surfaces + 1):
            longer = LONGER if surface == LONG else 1
            entry: dict[str, Any] = {"scene": number, "surface": surface}
            entry["distance_mm"] = longer * distance_mm
            if _key(entry) in done:
                continue
            seed = 1000 * number + surface
            track = {"rolling.distance_mm": entry["distance_mm"], "surface.seed": seed}
            long = {"scene": number, "surface": LONG, "distance_mm": LONGER * distance_mm}
            levels = levels_of(scene.with_(track), done.get(_key(long)))
            entry |= levels._asdict()
            done[_key(entry)] = levels.stiffness
            with out.open("a") as stream:
                stream.write(json.dumps(entry) + "\n")
        seconds = time.process_time() - began
        print(f"scene {number}: {seconds:.0f} s so far", file=sys.stderr, flush=True)


def _key(entry: Mapping[str, Any]) -> tuple[int, int, float]:
    """Return what tells tracks apart: scene, surface and length, which another rule may change."""
    return entry["scene"], entry["surface"], entry["distance_mm"]


def read(out: Path) -> list[dict[str, Any]]:
    """Return the tracks of a file; a last line that was cut off is left out."""
    entries = []
    for line in out.read_text().splitlines() if out.is_file() else []:
        try:
            entries.append(json.loads(line))
        except ValueError:
            continue
    return entries


class Ratios(NamedTuple):
    """Differences of levels from the long track, over a ± of both."""

    laeq: list[float]
    bands: list[float]


def compare(first: int, count: int, most: int, out: Path) -> dict[str, Ratios]:
    """Return the differences over the wanted and over the expected ±, of at most some surfaces."""
    known = {
        _key(entry): Levels(entry["laeq_db"], entry["bands_db"], entry["stiffness"])
        for entry in read(out)
    }
    found = {"wanted": Ratios([], []), "expected": Ratios([], [])}
    of_both = math.sqrt(1 + 1 / LONGER)  # the long track is uncertain as well
    for number, scene, distance_mm in scenes(first, count):
        truth = known.get((number, LONG, LONGER * distance_mm))
        if truth is None:
            continue
        every = [known.get((number, surface, distance_mm)) for surface in range(1, most + 1)]
        tracks = [levels for levels in every if levels is not None]
        own = scene.with_({"rolling.distance_mm": distance_mm})
        expected = record_uncertainty(expected_vibration(numbers_of(own)), own.duration)
        within_db = scene.numerics.within_db
        # What the steps do not resolve is another part of the uncertainty.
        resolved = EDGES_HZ[1:] <= max(own.rolling.speed_m_s / (2 * own.step), EDGES_HZ[1])
        bands_db = np.where(resolved, truth.bands_db, -np.inf)
        loud = np.flatnonzero(bands_db > bands_db.max() - LOUD_DB)
        every_db = [
            (_joined_db(levels, resolved) - _joined_db(truth, resolved)) for levels in tracks
        ]
        for levels, off_db in zip(tracks, every_db, strict=True):
            off = off_db / of_both
            found["wanted"].laeq.append(off / within_db)
            found["expected"].laeq.append(off / expected.laeq_db)
            in_bands = (np.array(levels.bands_db)[loud] - bands_db[loud]) / of_both
            found["wanted"].bands.extend(in_bands / (BAND_RATIO * within_db))
            found["expected"].bands.extend(in_bands / expected.third_octave_db[loud])
        print(_line_of_scene(number, own, every_db, loud), file=sys.stderr)
    return found


def _joined_db(levels: Levels, resolved: NDArray[np.bool_]) -> float:
    """Return the level of the third octaves that the steps resolve [dB]."""
    return float(10 * np.log10(np.sum(10 ** (np.array(levels.bands_db)[resolved] / 10))))


def _line_of_scene(
    number: int, scene: rc.Scene, every_db: Sequence[float], loud: NDArray[np.int_]
) -> str:
    """Write what one scene needs, and how far its levels are off."""
    off = np.array(every_db)
    names = [BAND_NAMES[k] for k in loud]
    bands = names[0] if len(names) == 1 else f"{names[0]} to {names[-1]}"
    return (
        f"scene {number}: {scene.track.steps} steps, {scene.duration:.3g} s; LAeq off by"
        f" {off.mean():+.2f}, rms {np.sqrt(np.mean(off**2)):.2f} dB; bands {bands} Hz"
    )


def table(found: dict[str, Ratios]) -> str:
    """Write the shares of levels within one and two ±."""
    lines = ["|±|level|levels|within one, %|within two, %|rms|", "|---|---|---|---|---|---|"]
    for name, ratios in found.items():
        for level, values in (("LAeq", ratios.laeq), ("third octaves", ratios.bands)):
            sizes = np.abs(np.array(values))
            if not len(sizes):
                continue
            one, two = (_share(sizes, limit) for limit in (1, 2))
            rms = math.sqrt(np.mean(np.square(sizes)))
            lines.append(f"|{name}|{level}|{len(sizes)}|{one}|{two}|{rms:.2f}|")
    return "\n".join(lines)


def _share(sizes: Array, limit: float) -> str:
    """Write the share of sizes within a limit with its counting error [%]."""
    count = len(sizes)
    share = float(np.mean(sizes < limit))
    likely = (share * count + 1) / (count + 2)
    return f"{100 * share:.0f} ± {100 * math.sqrt(likely * (1 - likely) / count):.0f}"


def main(arguments: Sequence[str] | None = None) -> int:
    """March the tracks that are lacking, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=SCENES, help=f"number ({SCENES})")
    parser.add_argument("--first", type=int, default=0, help="number of the first draw (0)")
    parser.add_argument("--surfaces", type=int, default=SURFACES, help=f"short ones ({SURFACES})")
    parser.add_argument("--out", type=Path, default=OUT, help=f"file of tracks ({OUT})")
    parser.add_argument("--table", action="store_true", help="only the table of the file")
    given = parser.parse_args(arguments)
    if not given.table:
        solve(given.first, given.scenes, given.surfaces, given.out)
    print(table(compare(given.first, given.scenes, given.surfaces, given.out)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
