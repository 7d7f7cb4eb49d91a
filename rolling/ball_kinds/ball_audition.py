"""How balls on plates are compared: by the vibration that is heard, on the same surfaces."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from acoustics.arrays import Array
from rolling.ball_kinds import (
    ball_candidates,
    ball_drawing,
    ball_heard,
    ball_waves,
    chain,
    linear_level,
)
from rolling.ball_kinds.ball_candidates import LOSS_FACTORS, BallCandidate, of_ball
from rolling.ball_kinds.ball_difference import BAND, VIBRATION, difference
from rolling.ball_kinds.ball_heard import BAFFLE, HeardBall
from rolling.ball_kinds.ball_specimens import BallSpecimens
from rolling.check import widest_places
from rolling.choice.audition import Audition, FirstSound
from rolling.choice.candidate import Candidate
from rolling.choice.choice_numbers import ChoiceNumbers, Contender
from rolling.choice.difference import Difference
from rolling.choice.drawing import LeftOut, WantedValue
from rolling.choice.heard_specimen import HeardQuantity, Specimen
from rolling.choice.omissions import remember
from rolling.choice.wave_bands import PlateWaves
from rolling.kinds.run_folder import RESULT
from rolling.numbers.doubt import Doubt, Severity
from rolling.numbers.file_facts import Provenance
from rolling.results import listening, result_file
from rolling.results.provenance import provenance
from rolling.results.run_result import Run, read_run
from rolling.scene.scene import Scene
from rolling.sound.heard_in_room import (
    MOST_SPECIMENS,
    HeardDifference,
    HeardRecord,
    heard_difference,
)
from rolling.terminal import progress

OF_BALLS = HeardQuantity(name=VIBRATION, words="vibration", column="vibration_db", leads=True)


class BallAudition(Audition):
    """How balls on plates are compared."""

    advice: Mapping[str, str] = {
        "loss_factor": (
            f"the loss factor of the contact, which no scene states ({LOSS_FACTORS[0]:g} to"
            f" {LOSS_FACTORS[1]:g}); measure it, or give plate.contact_loss_factor"
        ),
        "grid": "the error of the grid; choose a smaller surface.spacing_um",
        "instrument": "what the instrument could not see",
        BAFFLE: "the baffle in which free plates are computed and which they do not have",
        BAND: (
            "the ends of the simulated bands, which differ because the nodes do; let both roll"
            " faster, or take surfaces with nodes equally far apart"
        ),
    }

    # ---- candidates and specimens

    def candidates(self, scenes: Sequence[Scene]) -> list[Candidate]:
        """Return the candidates of scenes, with dynamics and the shortest steps of any of them."""
        return [*ball_candidates.candidates_of(scenes)]

    def specimens(self, candidates: Sequence[Candidate]) -> BallSpecimens:
        """Return what varies: seeds of surfaces, or places of a scan."""
        return BallSpecimens(candidates)

    def foresee(self, folder: Path, specimen: Specimen) -> str:
        """Return why a specimen has no solution, as far as its surface tells."""
        if specimen.is_done:
            return ""
        reason = widest_places.reason_against(specimen.scene)
        if reason:
            remember(folder, specimen, reason)
        return reason

    # ---- what is heard

    def quantities(self, candidates: Sequence[Candidate]) -> list[HeardQuantity]:
        """Return the vibration, which is all that is heard of a ball."""
        return [OF_BALLS]

    def hear_stored(self, specimen: Specimen) -> None:
        """Write what is heard of a specimen whose run is done."""
        result = result_file.read_result(specimen.folder / RESULT, specimen.scene)
        ball_heard.write_heard(specimen, result)

    def hear_marched(self, specimen: Specimen, marched: Sequence[Any]) -> None:
        """Write what is heard of a specimen from its marches."""
        (result,) = marched
        ball_heard.write_heard(specimen, result)

    def read_heard(self, specimen: Specimen) -> HeardBall:
        """Read what is heard of a specimen."""
        return ball_heard.read_heard(specimen)

    def difference(
        self,
        quantity: str,
        first: Sequence[HeardBall],
        second: Sequence[HeardBall],
        omitted: int = 0,
        correlation: Array | None = None,
    ) -> Difference:
        """Return the difference of two candidates, with its third octaves."""
        return difference(first, second, omitted, correlation)

    def audible(self, choice: ChoiceNumbers) -> tuple[HeardDifference, ...]:
        """Judge whether each candidate after the first is heard to differ from the quietest."""
        quietest, *others = choice.contenders
        with progress.step("listening to both in the noise of the room"):
            records = _records(quietest)
            room_db = quietest.candidate.scene.sound.room_db
            judged = []
            for other in others:
                names = (other.label, quietest.label)
                judged.append(heard_difference(_records(other), records, room_db, names))
        return tuple(judged)

    def second_opinion(self, specimens: Sequence[Specimen]) -> Array | None:
        """Return the levels of specimens by the linear chain."""
        return chain.chain_levels(specimens)

    # ---- values of a drawing

    def with_free_steps(self, scene: Scene) -> BallCandidate:
        """Return the candidate of a scene without a sweep, with a track that no change moves."""
        return ball_drawing.with_free_steps(scene)

    def with_shared_steps(self, base: Candidate, others: Sequence[Candidate]) -> Candidate:
        """Return a candidate with the shortest steps that `auto` takes for it or for others."""
        own = of_ball(base)
        return ball_candidates.with_steps_shared_by(own, [own, *map(of_ball, others)])

    def drawing_values(self, scene: Scene) -> Iterator[WantedValue | LeftOut]:
        """Yield the values of a drawing that a scene has."""
        return ball_drawing.values(scene)

    def with_value(self, base: Candidate, key: str, value: Any, label: str) -> Candidate:
        """Return a candidate with another value of one key."""
        return ball_drawing.with_value(of_ball(base), key, value, label)

    def plate_waves(self, scene: Scene) -> PlateWaves:
        """Return the waves of the plate, which `rolling design` lowers."""
        return ball_waves.plate_waves(scene)

    def linear_change(self, base: Candidate, changed: Candidate) -> float | None:
        """Return how much louder [dB(A)] a changed candidate is by its linear response."""
        return linear_level.linear_change_db(of_ball(base).scene, of_ball(changed).scene)

    def linear_error(self, key: str, change_db: float) -> float | None:
        """Return the standard uncertainty [dB] of that change by a key."""
        return linear_level.error_db(key, change_db)

    # ---- how a choice is shown

    def doubts(self, choice: ChoiceNumbers) -> Iterator[Doubt]:
        """Yield what is assumed of balls, and what their released power says."""
        for rule in RULES:
            yield from rule(choice)

    def facts(self, contender: Contender) -> dict[str, Any]:
        """Return the loss factors at which a candidate is heard, and its released power."""
        return {
            "loss_factors": list(of_ball(contender.candidate).loss_factors),
            "released_power_db": [heard_ball.released_power_db for heard_ball in contender.heard],
        }

    def provenance(self, scene: Scene, label: str) -> Provenance:
        """Return which program made the numbers of a choice, and from what."""
        return provenance(scene, label)

    def first_sound(self, choice: ChoiceNumbers, contender: Contender) -> FirstSound:
        """Return the record for the ear of the first specimen of a candidate.

        A short track goes on with a random continuation, as on the page of a run, and does not
        repeat.
        """
        run = _run_for_ear(contender)
        text = f"Vibration of this specimen: {run.vibration}."
        return FirstSound(listening.ListenSound(run), text)


def _records(contender: Contender) -> list[HeardRecord]:
    """Return the sound of the first specimens of a candidate."""
    records = []
    for specimen in contender.specimens[:MOST_SPECIMENS]:
        sound = read_run(specimen, contender.label).sound
        records.append(HeardRecord(sound.pressure, sound.sample_rate, sound.closed))
    return records


def _run_for_ear(contender: Contender) -> Run:
    """Return the run of the first specimen of a candidate, as it is heard."""
    run = read_run(contender.specimens[0], contender.label)
    ends = run.sound.once  # a fall is heard once, and a longer record as it is
    if ends or run.sound.duration >= listening.MIN_S:
        return run
    return replace(run, scene=run.scene.with_({"sound.listen_s": listening.MIN_S}))


# ---- notes


def _bodies(choice: ChoiceNumbers) -> Iterator[Doubt]:
    """Say which bodies are assumed of scenes that have no section dynamics."""
    added = dict.fromkeys(
        of_ball(contender.candidate).added
        for contender in choice.contenders
        if of_ball(contender.candidate).added
    )
    if added:
        text = (
            f"The scenes have no section dynamics: the vibration is that of {' and '.join(added)}."
        )
        yield Doubt("assumed_bodies", text, Severity.NOTE)


def _loss_factor(choice: ChoiceNumbers) -> Iterator[Doubt]:
    """Say that contacts are heard at two loss factors, because none is stated."""
    if any(len(of_ball(contender.candidate).loss_factors) > 1 for contender in choice.contenders):
        low, high = LOSS_FACTORS
        text = (
            f"The loss factor of the contact is not stated, so each is heard at {low:g} and"
            f" {high:g}, and half of what this changes is in the ±."
        )
        yield Doubt("contact_loss_factor", text, Severity.NOTE)


def _released_power(choice: ChoiceNumbers) -> Iterator[Doubt]:
    """Say that the released power has the other order."""
    difference = choice.differences[0] if choice.differences else None
    if difference is not None and difference.is_sure and (difference.released_db or 0.0) < 0:
        text = (
            "The released power is higher for the quieter one: it is an upper bound, and its order"
            " is not that of what one hears."
        )
        yield Doubt("released_power_order", text, Severity.NOTE)


RULES = (_bodies, _loss_factor, _released_power)
