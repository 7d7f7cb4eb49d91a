"""Coverage of the differences that `rolling choose` states, on pairs whose truth is known.

`python tests/benchmarks/choice_study.py` hears twelve pairs of small scenes on 60 seeds each. The
mean over all seeds is the truth. Then it chooses again and again, each time with seeds that no
other choice has, by the rule of the program: six pairs, and as many more as their scatter asks for.
It counts how many stated differences lie within one and within two ± of the truth, and how often a
sign was stated at 95 % and wrong. It prints the table of docs/accuracy.md, in about half an hour of
one core, and keeps what is heard in outputs/choice-study, so that a second call is quick.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import rolling as rc
from acoustics.pairs import FIRST_PAIRS, pairs_needed
from rolling.ball_kinds.ball_candidates import BallCandidate, candidate
from rolling.ball_kinds.ball_difference import difference
from rolling.choice.choice_numbers import Contender
from rolling.choice.choosing import OpenChoice, open_choice

SEEDS = 60
WITHIN_DB = (1.0, 0.4, 0.25)  # wanted ±; the smaller ones ask for more than six pairs
OUT = Path("outputs/choice-study")

BASES: dict[str, dict[str, Any]] = {
    "steel": {
        "sphere": {"radius_mm": 3, "material": "steel-100cr6"},
        "plate": {"material": "steel-100cr6", "thickness_mm": 3, "contact_loss_factor": 0.01},
        "surface": {
            "kind": "gaussian",
            "roughness_ra_um": 0.2,
            "correlation_length_um": 12,
            "spacing_um": 3,
            "width_um": 192,
            "seed": 1,
        },
        "rolling": {"load_n": 1, "speed_m_s": 0.1, "distance_mm": 6},
    },
    "glass": {
        "sphere": {"radius_mm": 8, "material": "glass"},
        "plate": {
            "material": "glass",
            "thickness_mm": 5,
            "length_mm": 120,
            "width_mm": 90,
            "loss_factor": 0.01,
            "contact_loss_factor": 0.01,
        },
        "surface": {
            "kind": "self-affine",
            "roughness_ra_um": 0.1,
            "hurst": 0.8,
            "rolloff_um": 80,
            "shortest_um": 16,
            "spacing_um": 4,
            "width_um": 256,
            "seed": 1,
        },
        "rolling": {"load_n": 0.5, "speed_m_s": 0.2, "distance_mm": 8},
    },
    "soft": {
        "sphere": {"radius_mm": 5, "material": "steel-100cr6"},
        "plate": {"material": "aluminium-6061-t6", "thickness_mm": 8, "contact_loss_factor": 0.01},
        "surface": {
            "kind": "gaussian",
            "roughness_ra_um": 0.4,
            "correlation_length_um": 20,
            "spacing_um": 5,
            "width_um": 320,
            "seed": 1,
        },
        "rolling": {"load_n": 2, "speed_m_s": 0.3, "distance_mm": 10},
    },
}
CHANGES: dict[str, dict[str, dict[str, Any]]] = {
    "steel": {
        "Ra halved": {"surface.roughness_ra_um": 0.1},
        "Ra 3 % lower": {"surface.roughness_ra_um": 0.194},
        "longer waves": {"surface.correlation_length_um": 20},
        "thrice the load": {"rolling.load_n": 3},
        "thicker plate": {"plate.thickness_mm": 5},
    },
    "glass": {
        "Ra halved": {"surface.roughness_ra_um": 0.05},
        "Ra 10 % lower": {"surface.roughness_ra_um": 0.09},
        "larger ball": {"sphere.radius_mm": 12},
    },
    "soft": {
        "Ra halved": {"surface.roughness_ra_um": 0.2},
        "Ra 10 % lower": {"surface.roughness_ra_um": 0.36},
        "skew heights": {"surface.skewness": -1},
        "half the load": {"rolling.load_n": 1},
    },
}


class Pair(NamedTuple):
    """Two contenders that are heard on the same seeds."""

    name: str
    first: Contender
    second: Contender


class Verdict(NamedTuple):
    """A stated difference less the truth, its ±, whether the sign is sure, and right; dB."""

    error: float
    uncertainty: float
    is_sure: bool
    is_right: bool
    pairs: int


def hear_pairs(out: Path, workers: int) -> list[Pair]:
    """Hear all pairs on all seeds; what is there already stays."""
    pairs = []
    for base, values in BASES.items():
        scene = rc.Scene.from_dict({"name": base, "dynamics": {}, **values})
        first = candidate(base, scene)
        others = [candidate(name, scene.with_(change)) for name, change in CHANGES[base].items()]
        with open_choice([first, *others], out / base, workers) as work:
            heard = _heard(work, [first, *others])
        pairs += [Pair(f"{base}: {one.label}", heard[0], one) for one in heard[1:]]
    return pairs


def _heard(work: OpenChoice, candidates: list[BallCandidate]) -> list[Contender]:
    """Hear candidates on all seeds, some seeds at a time."""
    for count in range(10, SEEDS, 10):
        work.hear(candidates, count)
    return work.hear(candidates, SEEDS).contenders


def choices(pair: Pair, within_db: float) -> Iterator[Verdict]:
    """Choose with disjoint groups of the seeds, by the rule of the program."""
    values = pair.first.levels_db - pair.second.levels_db
    truth = float(values.mean())
    begin = 0
    while begin + FIRST_PAIRS <= SEEDS:
        first_six = values[begin : begin + FIRST_PAIRS]
        count = max(FIRST_PAIRS, pairs_needed(first_six, within_db))
        if begin + count > SEEDS:
            return
        group = slice(begin, begin + count)
        apart = difference(pair.first.heard[group], pair.second.heard[group])
        assert apart.db is not None and apart.uncertainty_db is not None
        # The truth has the group in it, so that it lies nearer by the root of the other seeds.
        rest = math.sqrt(1 - count / SEEDS)
        yield Verdict(
            error=(apart.db - truth) / rest if rest else math.nan,
            uncertainty=apart.uncertainty_db,
            is_sure=apart.is_sure,
            is_right=apart.db * truth > 0,
            pairs=count,
        )
        begin += count


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument("--workers", type=int, default=0)
    given = parser.parse_args()
    pairs = hear_pairs(given.out, given.workers)
    print("|pair|heard, dB|scatter, dB|released power, dB|\n|---|---|---|---|")
    for pair in pairs:
        values = pair.first.levels_db - pair.second.levels_db
        apart = difference(pair.first.heard, pair.second.heard)
        print(
            f"|{pair.name}|{values.mean():+.2f}|{values.std(ddof=1):.2f}|{apart.released_db:+.2f}|"
        )
    print("\n|wanted ±, dB|choices|pairs each|within one ±|within two ±|sure|sure and wrong|")
    print("|---|---|---|---|---|---|---|")
    for within_db in WITHIN_DB:
        found = [verdict for pair in pairs for verdict in choices(pair, within_db)]
        ratio = np.array([abs(one.error) / one.uncertainty for one in found])
        ratio = ratio[np.isfinite(ratio)]
        sure = sum(one.is_sure for one in found)
        wrong = sum(one.is_sure and not one.is_right for one in found)
        mean = np.mean([one.pairs for one in found])
        cells = [f"{within_db:g}", str(len(ratio)), f"{mean:.1f}"]
        cells += [_share(ratio < 1), _share(ratio < 2), str(sure), str(wrong)]
        print(f"|{'|'.join(cells)}|")


def _share(inside: np.ndarray) -> str:
    """Write a share with its counting error in percent."""
    share = float(inside.mean())
    error = math.sqrt(share * (1 - share) / len(inside))
    return f"{100 * share:.0f} ± {100 * error:.0f} %"


if __name__ == "__main__":
    main()
