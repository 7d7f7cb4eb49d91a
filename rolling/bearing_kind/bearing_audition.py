"""How bearings are compared: by three bands of their rings, and by the sound of a housing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from acoustics import wav
from acoustics.arrays import Array
from acoustics.pairs import MOST_PAIRS
from rolling.bearing.ring_record import record_of
from rolling.bearing_kind import bearing_drawing, bearing_heard, stored_run
from rolling.bearing_kind.band_gain import gain_uncertainty_db
from rolling.bearing_kind.bearing_heard import BANDS, HOUSING, UM_S, HeardRing, RingSolver
from rolling.bearing_kind.contact_marches import march_contacts
from rolling.bearing_kind.contact_plan import contact_plan
from rolling.bearing_kind.joined_tracks import bearing_tracks
from rolling.bearing_kind.moved_ring import moved_ring
from rolling.bearing_kind.solved_bearing import SolvedBearing
from rolling.choice.audition import Audition, FirstSound, Specimens, nothing_to_choose
from rolling.choice.candidate import Candidate
from rolling.choice.choice_numbers import ChoiceNumbers, Contender
from rolling.choice.difference import Difference, paired_difference
from rolling.choice.drawing import WantedValue
from rolling.choice.heard_specimen import HeardQuantity, Specimen
from rolling.numbers.file_facts import Provenance
from rolling.results.provenance import program_provenance
from rolling.run.choice_folder import RUNS
from rolling.scene.bearing_scene import BearingScene

GAINS = "gains"  # part of the ± that all specimens share


class RingSpecimens(Specimens):
    """Draws of the heights, forms and places of the balls of bearings."""

    noun = "specimens"

    def __init__(self, candidates: Sequence[Candidate]) -> None:
        """Find out whether anything is random."""
        is_random = any(not candidate.scene.is_smooth for candidate in candidates)
        self.count = MOST_PAIRS if is_random else 1

    def scene(self, candidate: Candidate, number: int) -> BearingScene:
        """Return the scene of a candidate, whose random numbers are drawn anew for each number."""
        scene: BearingScene = candidate.scene
        return scene


class BearingAudition(Audition):
    """How bearings are compared: on the same draws, so that what they share cancels."""

    marches_each = False
    same_keys = ("bearing.turning", "sound.distance_m")
    why_no_waves = (
        "a bearing has waves on balls and on two raceways, which reach the ring by their orders and"
        " by other gains in each band"
    )
    advice: Mapping[str, str] = {
        GAINS: (
            "the gains of the rough contacts; choose a longer numerics.window_mm, since more"
            " specimens do not lower them"
        ),
    }

    # ---- candidates and specimens

    def with_and_without_faults(self, scene: BearingScene) -> list[tuple[str, Any]]:
        """Return a bearing without its single faults, and with them."""
        changes: dict[str, Any] = {}
        for body in ("balls", "inner", "outer"):
            surface = getattr(scene.bearing.surfaces, body)
            if surface is not None and surface.faults:
                changes[f"bearing.surfaces.{body}.faults"] = None
        if not changes:
            raise nothing_to_choose(scene)
        without = scene.with_(changes)
        return [("the bearing without faults", without), ("the bearing with faults", scene)]

    def specimens(self, candidates: Sequence[Candidate]) -> RingSpecimens:
        """Return what varies: the draws of all that is random."""
        return RingSpecimens(candidates)

    # ---- what is heard

    def quantities(self, candidates: Sequence[Candidate]) -> list[HeardQuantity]:
        """Return the bands of a ring, and the sound of the housing where all scenes have one."""
        if all(candidate.scene.plate is not None for candidate in candidates):
            return [*BANDS, HOUSING]
        return [*BANDS]

    def open_solver(
        self, stack: ExitStack, contacts: Sequence[Any], folder: Path, workers: int
    ) -> RingSolver:
        """Return what marches the contacts of bearings, and moves their rings."""
        return RingSolver(stack, folder, workers)

    def read_heard(self, specimen: Specimen) -> HeardRing:
        """Read what is heard of a specimen."""
        return bearing_heard.read_heard(specimen)

    def difference(
        self,
        quantity: str,
        first: Sequence[HeardRing],
        second: Sequence[HeardRing],
        omitted: int = 0,
        correlation: Array | None = None,
    ) -> Difference:
        """Return the difference of two bearings in a band, or of the sound of their housings.

        All specimens share the gains of the contacts. The sound of a housing has those of its most
        uncertain band.
        """
        first_rms = np.array([heard_ring.rms(quantity) for heard_ring in first])
        second_rms = np.array([heard_ring.rms(quantity) for heard_ring in second])
        if not (np.all(first_rms > 0) and np.all(second_rms > 0)):
            silent = np.full(len(first_rms), np.nan)
            return paired_difference(quantity, silent, {}, omitted, correlation)
        bands = [band.name for band in BANDS]
        if quantity != HOUSING.name:
            bands = [quantity]
        gains_db = max(
            gain_uncertainty_db(_levels_by_group(second, band), _levels_by_group(first, band))
            for band in bands
        )
        differences_db = 20 * np.log10(first_rms / second_rms)
        return paired_difference(quantity, differences_db, {GAINS: gains_db}, omitted, correlation)

    # ---- values of a drawing

    def drawing_values(self, scene: BearingScene) -> Iterator[WantedValue]:
        """Yield the values of a drawing that a bearing has."""
        return bearing_drawing.values(scene)

    # ---- how a choice is shown

    def provenance(self, scene: BearingScene, label: str) -> Provenance:
        """Return which program made the numbers of a choice."""
        return program_provenance(label)

    def first_sound(self, choice: ChoiceNumbers, contender: Contender) -> FirstSound:
        """Return the sound of the housing, or else the acceleration of the ring along x."""
        bearing = _first_bearing(choice, contender)
        heard_ring: HeardRing = contender.heard[0]
        sound = stored_run.housing_sound(bearing) if HOUSING in choice.quantities else None
        if sound is not None:
            level_db = heard_ring.level_db(HOUSING.name)
            return FirstSound(
                sound, f"Sound of the housing of this specimen: {level_db:.1f} dB(A)."
            )
        words = [f"{heard_ring.rms(band.name):.3g} um/s from {band.words}" for band in BANDS]
        text = f"Radial velocity of the ring of this specimen: {', '.join(words)}."
        return FirstSound(stored_run.ring_sound(bearing), text)


def _levels_by_group(heard_rings: Sequence[HeardRing], band: str) -> Array:
    """Return the level of a band without each group of waves of the marches, less that with all."""
    rms = np.array([heard_ring.rms(band) for heard_ring in heard_rings])
    return heard_rings[0].rough[band].band.levels_db(float(np.mean(np.square(rms / UM_S))))


def _first_bearing(choice: ChoiceNumbers, contender: Contender) -> SolvedBearing:
    """Move the ring of the first specimen of a candidate for as long as it is heard."""
    specimen = contender.specimens[0]
    scene: BearingScene = specimen.scene
    plan = contact_plan(scene)
    contacts = [contact for stage in plan.stages for contact in stage]
    marches = march_contacts(contacts, name="reading marches", folder=choice.folder / RUNS)
    tracks = bearing_tracks(plan, marches, draw=specimen.number + 1)
    motion = moved_ring(scene.model, tracks, scene.moved, wav.SAMPLE_RATE_HZ)
    return SolvedBearing(
        values={},
        scene=scene,
        folder=specimen.folder,
        label=contender.label,
        record=record_of(motion, scene.kinematics, scene.sensor),
        tracks=tracks,
    )
