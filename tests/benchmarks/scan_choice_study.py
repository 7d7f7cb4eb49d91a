"""Sureness of `rolling choose` on single scans with lay, whose finishes are known.

`python tests/benchmarks/scan_choice_study.py` makes 440 pairs of tiny scans, 1.6 x 0.6 mm, with
ridges of 20 to 400 um across the track, or along it. A scan is cut from an endless surface of a
finish, so that its places share ridges and no place of it is special. Each pair is chosen by the
rule of the program, and what is heard of a place is its linear response in place of a march. The
mean level of a finish over many scans is the truth. In 40 pairs both scans have the same finish,
and a coin decides which one counts as quieter. Then it chooses between 20 pairs with marches, of
which the rougher one is the louder one.

It prints the tables of docs/accuracy.md and keeps each answer in outputs/scan-choice-study, so that
it goes on where it stopped. `python docs/_hooks/pictures.py calibration` draws its curve.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy import stats

import rolling as rc
from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES
from acoustics.pairs import FIRST_PAIRS, sureness
from acoustics.radiation import P_REF_PA
from rolling.ball_kinds import linear_response
from rolling.ball_kinds.ball_candidates import BallCandidate, candidate
from rolling.ball_kinds.ball_heard import HeardBall
from rolling.ball_kinds.ball_specimens import BallSpecimens
from rolling.choice import choosing
from rolling.choice.candidate import Candidate
from rolling.choice.choice import Choice
from rolling.choice.choice_numbers import Contender
from rolling.choice.choosing import HeardPairs, OpenChoice, choose_scenes
from rolling.choice.heard_specimen import Specimen
from rolling.run.budget import Budget
from rolling.terminal import progress

OUT = Path("outputs/scan-choice-study")
PAIRS = 400  # of different finishes
EQUAL = 40  # of one finish
MARCHED = 20
TRUTH_SCANS = 100  # of each finish, over which its mean level is taken
NODES = (400, 150)  # of a scan, along and across
SPACING_UM = 4.0
LIMITS = (0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99, 0.999, 1.0)  # of the rows of the table
BINOMIAL = 0.05  # probability of fewer right answers, below which a row fails
WITHIN_DB = 1.0
REFERENCE_DB = 20 * math.log10(P_REF_PA)
MARCHED_WITHIN_DB = 2.0
MARCHED_RA_UM = 0.05


class Finish(NamedTuple):
    """A finish by its law: roughness, and correlation lengths along and across the track [um]."""

    ra_um: float
    along_um: float
    across_um: float


FINISHES = (  # whose mean levels lie within some 3 dB
    Finish(0.023, 16, 20),
    Finish(0.0205, 16, 60),
    Finish(0.020, 16, 150),
    Finish(0.021, 16, 300),
    Finish(0.020, 14, 400),
    Finish(0.0195, 20, 200),
    Finish(0.0185, 20, 300),
    Finish(0.025, 20, 100),
    Finish(0.85, 150, 16),
    Finish(0.32, 100, 20),
)
# Length of the track [mm]; none: the whole scan is rolled over, so that places lie side by side.
TRACKS = (None, 0.5)


class Answer(NamedTuple):
    """What a choice stated of the first finish less the second, and the truth [dB]."""

    db: float
    uncertainty_db: float
    sureness: float
    truth_db: float
    is_equal: bool
    places: int
    independent: float
    sureness_of_windows: float

    @property
    def is_right(self) -> bool:
        """Whether the sign is that of the truth."""
        return self.db * self.truth_db > 0


# ---- scans


def make_scan(finish: Finish, rng: np.random.Generator) -> Array:
    """Cut a scan [m] from a surface of a finish that is so large that its ends are not related."""
    lengths = (finish.along_um, finish.across_um)
    sides = [
        nodes + math.ceil(4 * length / SPACING_UM)
        for nodes, length in zip(NODES, lengths, strict=True)
    ]
    along = 2 * np.pi * np.fft.fftfreq(sides[0], SPACING_UM) * lengths[0]
    across = 2 * np.pi * np.fft.rfftfreq(sides[1], SPACING_UM) * lengths[1]
    law = np.exp(-(along[:, None] ** 2 + across**2) / 8)
    whole = 2.0 * sides[1]  # of the waves across, of which half are listed
    power = 2 * np.sum(law**2) - np.sum(law[:, 0] ** 2)
    noise = rng.normal(size=sides)
    heights = np.fft.irfft2(np.fft.rfft2(noise) * law, s=sides)
    heights *= math.sqrt(whole / 2.0 * sides[0] / power)
    ra_of_normal = math.sqrt(2 / math.pi)
    return np.asarray(1e-6 * finish.ra_um / ra_of_normal * heights[: NODES[0], : NODES[1]])


def scene_of(path: Path, track_mm: float | None) -> rc.Scene:
    """Return the scene of a scan."""
    rolling: dict[str, Any] = {"load_n": 1, "speed_m_s": 0.1}
    if track_mm is not None:
        rolling["distance_mm"] = track_mm
    return rc.Scene.from_dict(
        {
            "name": path.stem,
            "sphere": {"radius_mm": 3, "material": "steel-100cr6"},
            "plate": {
                "material": "steel-100cr6",
                "thickness_mm": 3,
                "contact_loss_factor": 0.01,
            },
            "surface": {
                "kind": "file",
                "path": str(path.resolve()),
                "spacing_um": SPACING_UM,
                "periodic": "blend",
            },
            "rolling": rolling,
            "dynamics": {},
        }
    )


# ---- linear response in place of marches


class LinearWork(OpenChoice):
    """Places of scans, heard by their linear response."""

    def __init__(self, candidates: Sequence[Candidate], folder: Path) -> None:
        super().__init__(candidates, folder, solver=None)  # type: ignore[arg-type]
        self._heard = {one.label: linear_response.heard_places(one.scene) for one in candidates}

    def hear(self, candidates: Sequence[Candidate], count: int, are_all: bool = True) -> HeardPairs:
        """Return what is heard of the first places."""
        contenders = []
        for one in candidates:
            specimens = [self._specimen(one, number) for number in range(count)]
            heard = [self._heard_of(one, specimen) for specimen in specimens]
            contenders.append(Contender(one, heard, specimens, self._leading))
        return HeardPairs(contenders, [])

    def _heard_of(self, one: Candidate, specimen: Specimen) -> HeardBall:
        """Return what is heard of a place."""
        square = square_of(self._heard[one.label], specimen.scene)
        bands = np.zeros((1, len(BAND_NAMES)))
        bands[0, BAND_NAMES.index("1000")] = square
        return HeardBall(
            loss_factors=(0.01,),
            squares=np.array([square]),
            bands=bands,
            released_power_db=None,
            errors={},
        )


def square_of(heard: Array, scene: rc.Scene) -> float:
    """Return the mean square [Pa2] of what is heard along the track of a scene."""
    track = scene.track
    nodes = min(len(heard), round(track.steps * track.step / track.spacing))
    first = round(1e-6 * scene.rolling.start_um / track.spacing)
    column = round(1e-6 * scene.rolling.across_um / track.spacing)
    line = heard[(first + np.arange(nodes)) % len(heard), column % heard.shape[1]]
    return float(np.mean(np.square(line)))


def truths(out: Path) -> dict[str, float]:
    """Return the mean level of each finish and track over many scans [dB]; kept once known."""
    path = out / "truths.json"
    known: dict[str, float] = json.loads(path.read_text()) if path.exists() else {}
    for number, finish in enumerate(FINISHES):
        keys = {track_mm: f"{number} {track_mm}" for track_mm in TRACKS}
        if set(keys.values()) <= known.keys():
            continue
        rng = np.random.default_rng([99, number])
        levels: dict[str, list[float]] = {key: [] for key in keys.values()}
        for _ in range(TRUTH_SCANS):
            scene = written_scene(out / "truth", finish, None, rng)
            heard = linear_response.heard_places(scene)
            for track_mm, key in keys.items():
                one = candidate("truth", scene.with_({"rolling.distance_mm": track_mm}))
                specimens = BallSpecimens([one])
                for place in range(min(FIRST_PAIRS, specimens.count)):
                    levels[key].append(square_of(heard, specimens.scene(one, place)))
        for key, squares in levels.items():
            of_scans = 10 * np.log10(np.array(squares)).reshape(TRUTH_SCANS, -1).mean(axis=1)
            known[key] = float(np.mean(of_scans)) - REFERENCE_DB
            error = float(np.std(of_scans, ddof=1)) / math.sqrt(TRUTH_SCANS)
            print(f"{finish}, track {key}: {known[key]:.2f} ± {error:.2f} dB", flush=True)
        path.write_text(json.dumps(known))
    return known


def written_scene(
    stem: Path, finish: Finish, track_mm: float | None, rng: np.random.Generator
) -> rc.Scene:
    """Write a scan of a finish, and return its scene."""
    path = stem.with_suffix(".npy")
    np.save(path, make_scan(finish, rng))
    return scene_of(path, track_mm)


# ---- answers


def draw_pair(number: int) -> tuple[int, int, float | None]:
    """Return the numbers of both finishes of a pair, and its track."""
    rng = np.random.default_rng([7, number])
    track_mm = TRACKS[int(rng.integers(len(TRACKS)))]
    first = int(rng.integers(len(FINISHES)))
    if number >= PAIRS:
        return first, first, track_mm
    second = int(rng.integers(len(FINISHES) - 1))
    return first, second + (second >= first), track_mm


def answer_of(number: int, out: Path, known: dict[str, float]) -> Answer:
    """Choose between the scans of a pair."""
    first, second, track_mm = draw_pair(number)
    rng = np.random.default_rng([8, number])
    scenes = [
        written_scene(out / name, FINISHES[finish], track_mm, rng)
        for name, finish in (("first", first), ("second", second))
    ]
    candidates = [candidate(scene.name, scene) for scene in scenes]
    truth_db = known[f"{first} {track_mm}"] - known[f"{second} {track_mm}"]
    if first == second:
        truth_db = 1e-9 * float(rng.choice([-1, 1]))
    return stated(choice_of(candidates, out), truth_db, first == second)


def choice_of(candidates: Sequence[BallCandidate], out: Path) -> Choice:
    """Choose by the rule of the program, with linear responses in place of marches."""
    work = LinearWork(candidates, out)
    budget = Budget(within_db=WITHIN_DB)
    looks = budget.looks(work.specimens.count, work.specimens.noun)
    return choosing._until_known(work, candidates, budget, looks, None)


def stated(choice: Choice, truth_db: float, is_equal: bool) -> Answer:
    """Return what a choice states of the scan `first` less the scan `second`."""
    (difference,) = choice.differences
    assert difference.db is not None
    sign = 1 if choice.contenders[1].label == "first" else -1
    values = choice.contenders[1].levels_db - choice.contenders[0].levels_db
    scatter = float(np.std(values[:FIRST_PAIRS], ddof=1)) / math.sqrt(len(values))
    as_windows = sureness(float(np.mean(values)), scatter, FIRST_PAIRS - 1)
    return Answer(
        db=sign * difference.db,
        uncertainty_db=difference.uncertainty_db or math.nan,
        sureness=difference.sureness or 0.5,
        truth_db=truth_db,
        is_equal=is_equal,
        places=choice.pairs,
        independent=difference.independent or choice.pairs,
        sureness_of_windows=as_windows,
    )


def kept_answers(path: Path, count: int, ask: Any) -> list[Answer]:
    """Return the answers of a file, and ask for those that it lacks."""
    answers = []
    if path.exists():
        answers = [Answer(*json.loads(line)) for line in path.read_text().splitlines()]
    with path.open("a") as file:
        for number in range(len(answers), count):
            answers.append(ask(number))
            file.write(json.dumps(list(answers[-1])) + "\n")
            file.flush()
    return answers


# ---- marched pairs


def marched_answer(number: int, out: Path) -> Answer:
    """Choose between two scans of one lay with marches, of which one is rougher or none."""
    rng = np.random.default_rng([9, number])
    finish = FINISHES[number % 8]._replace(ra_um=MARCHED_RA_UM)
    is_equal = number % 10 == 9
    louder = 1.0 if is_equal else float(rng.choice([1.12, 1.25, 1.4]))
    finishes = {"first": finish._replace(ra_um=finish.ra_um * louder), "second": finish}
    if rng.random() < 0.5 and not is_equal:
        finishes = {"first": finish, "second": finishes["first"]}
    truth_db = 20 * math.log10(finishes["first"].ra_um / finishes["second"].ra_um)
    if is_equal:
        truth_db = 1e-9 * float(rng.choice([-1, 1]))
    folder = out / "marched" / f"{number:02d}"
    folder.mkdir(parents=True, exist_ok=True)
    scenes = []
    for name, of_scan in finishes.items():
        scenes.append(written_scene(folder / name, of_scan, None, rng))
    choice = choose_scenes(
        scenes, folder / "choice", Budget(within_db=MARCHED_WITHIN_DB), workers=1
    )
    return stated(choice, truth_db, is_equal)


# ---- tables


def calibration_rows(answers: Sequence[Answer], of_windows: bool = False) -> list[list[str]]:
    """Return the rows of the table: by sureness, the answers, the promised and the right share.

    A row holds if fewer right answers than it has are not less likely than 5 %.
    """
    rows = []
    for low, high in pairwise(LIMITS):
        inside = []
        for answer in answers:
            sure = answer.sureness_of_windows if of_windows else answer.sureness
            if low <= sure < high or (high == 1.0 and sure == 1.0):
                inside.append((sure, answer.is_right))
        if not inside:
            continue
        promised = float(np.mean([sure for sure, _ in inside]))
        right = sum(is_right for _, is_right in inside)
        chance = float(stats.binom.cdf(right, len(inside), promised))
        rows.append(
            [
                f"{100 * low:g} to {100 * high:g} %",
                str(len(inside)),
                f"{100 * promised:.1f} %",
                f"{100 * right / len(inside):.1f} %",
                f"{100 * chance:.0f} %",
                "yes" if chance >= BINOMIAL else "no",
            ]
        )
    return rows


def print_table(answers: Sequence[Answer], of_windows: bool = False) -> None:
    """Print the table of a calibration."""
    print("|sureness|answers|promised|right|chance of so few|holds|\n|---|---|---|---|---|---|")
    for row in calibration_rows(answers, of_windows):
        print(f"|{'|'.join(row)}|")


def print_summary(answers: Sequence[Answer]) -> None:
    """Print how many answers are sure, right and within their ±."""
    for name in ("sureness", "sureness_of_windows"):
        sure = [answer for answer in answers if getattr(answer, name) >= 0.95]
        wrong = sum(not answer.is_right for answer in sure)
        equal = [answer for answer in answers if answer.is_equal]
        of_equal = sum(getattr(answer, name) >= 0.95 for answer in equal)
        chance = float(stats.binom.sf(of_equal - 1, len(equal), 0.1)) if equal else math.nan
        print(
            f"{name}: {len(sure)} sure, {wrong} of them wrong; of {len(equal)} equal pairs"
            f" {of_equal} are called sure (chance of so many {100 * chance:.0f} %)"
        )
    ratio = np.array(
        [abs(answer.db - answer.truth_db) / answer.uncertainty_db for answer in answers]
    )
    ratio = ratio[np.isfinite(ratio)]
    places = np.mean([answer.places for answer in answers])
    independent = np.quantile([answer.independent for answer in answers], [0.1, 0.5, 0.9])
    print(f"within one ±: {np.mean(ratio < 1):.2f}, within two: {np.mean(ratio < 2):.2f}")
    print(f"places {places:.1f}, independent {np.round(independent, 1)} (10, 50, 90 %)")


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument("--pairs", type=int, default=PAIRS + EQUAL)
    parser.add_argument("--marched", type=int, default=MARCHED)
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    progress.begin(progress.Level.QUIET)
    known = truths(given.out)
    answers = kept_answers(
        given.out / "answers.jsonl",
        given.pairs,
        lambda number: answer_of(number, given.out, known),
    )
    print_table(answers)
    print_summary(answers)
    print("\neach place counted as one:")
    print_table(answers, of_windows=True)
    marched = kept_answers(
        given.out / "marched.jsonl", given.marched, lambda number: marched_answer(number, given.out)
    )
    if not marched:
        return
    print("\nmarched:")
    print_table(marched)
    print_summary(marched)


if __name__ == "__main__":
    main()
