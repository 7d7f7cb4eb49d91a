"""What is heard of a specimen of a bearing: velocity of its ring by band, sound of its housing.

Specimens of a bearing have the same statistics and other random heights, forms and places of
balls. What a march says of the contact holds for all of them, so a specimen costs a motion.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from concurrent.futures import BrokenExecutor, Future
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from acoustics.level import a_weighted
from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing.linear_ring import linear_ring
from rolling.bearing.ring_record import RADIAL, record_of
from rolling.bearing_kind.band_gain import RoughBand, rough_bands
from rolling.bearing_kind.contact_marches import march_contacts
from rolling.bearing_kind.contact_plan import ContactPlan, contact_plan
from rolling.bearing_kind.housing import housing_of_scene
from rolling.bearing_kind.joined_tracks import bearing_tracks
from rolling.bearing_kind.moved_ring import moved_ring
from rolling.choice.candidate import Candidate
from rolling.choice.heard_specimen import (
    Heard,
    HeardQuantity,
    Specimen,
    damaged,
    read_heard_file,
    write_heard_file,
)
from rolling.choice.specimen_solving import Solver, prepare
from rolling.run.choice_folder import RUNS
from rolling.run.march_files import ContactMarch, Marches
from rolling.run.pools import Pool, Task, pool_for_tasks
from rolling.scene.bearing_scene import BearingScene
from rolling.terminal import progress, shortage

UM_S = 1e6  # micrometres per second in a metre per second
ROUNDING_UM_S = 1e-7  # velocity of a ring at rest, of numbers that are rounded
LEADING = "medium"
HOUSING = HeardQuantity(
    name="housing",
    words="sound of the housing",
    column="housing_laeq_db",
    where="By the sound of the housing",
)
BANDS = tuple(
    HeardQuantity(
        name=name,
        words=f"{low:g} to {high:g} Hz",
        column="velocity_um_s",
        unit="um/s",
        is_level=False,
        drawn="radial velocity of the ring",
        where=f"From {low:g} to {high:g} Hz",
        verb="moves its ring",
        adverb="less",
        leads=name == LEADING,
    )
    for name, (low, high) in VELOCITY_BANDS_HZ.items()
)


@dataclass(frozen=True, kw_only=True)
class StoredRoughBand:
    """What the rough contacts make of a band [m2/s2], with and without each group of waves."""

    whole: float
    without_groups: tuple[float, ...]

    @property
    def band(self) -> RoughBand:
        """The same with an array."""
        return RoughBand(self.whole, np.array(self.without_groups))


@dataclass(frozen=True, kw_only=True)
class HeardRing(Heard):
    """Root mean squares of a specimen, as heard.json has them.

    low, medium, high : float, um/s. Radial velocity of the ring in each band.
    housing : float or None, Pa. A-weighted sound pressure of the housing plate, if there is one.
    rough : dict. What the rough contacts make of each band, by its name.
    """

    low: float
    medium: float
    high: float
    housing: float | None
    rough: dict[str, StoredRoughBand]

    def rms(self, quantity: str) -> float:
        """Return the root mean square of a band [um/s], or of the housing [Pa]."""
        value: float | None = getattr(self, quantity)
        assert value is not None  # a housing is compared only where all have one
        return value

    def level_db(self, quantity: str) -> float:
        """Return the level of a band [dB re 1 um/s], or of the housing [dB(A)]."""
        if quantity == HOUSING.name:
            return super().level_db(quantity)
        rms = self.rms(quantity)
        return 20 * math.log10(rms) if rms > 0 else -math.inf


def read_heard(specimen: Specimen) -> HeardRing:
    """Read what is heard of a specimen of a bearing.

    Raises
    ------
    FolderError : the file is damaged, or was not written by this program.
    """
    heard_ring = read_heard_file(specimen, HeardRing)
    if heard_ring.rough.keys() != VELOCITY_BANDS_HZ.keys():
        raise damaged(specimen, "other bands")
    if (heard_ring.housing is None) != (specimen.scene.plate is None):
        raise damaged(specimen, "another housing")
    return heard_ring


def heard_specimen(
    scene: BearingScene, plan: ContactPlan, marches: Marches, number: int
) -> dict[str, float | None]:
    """Return the root mean squares of a specimen: radial velocity [um/s] and housing [Pa]."""
    model = scene.model
    # The marched one, 0, is left out: its stretch has fewer waves than a turn, so it scatters more.
    tracks = bearing_tracks(plan, marches, draw=number + 1)
    motion = moved_ring(model, tracks, scene.duration)
    record = record_of(motion, scene.kinematics, scene.sensor)
    rms: dict[str, float | None] = {}
    for name, radial in record.bands[RADIAL].rms_m_s.items():
        velocity = UM_S * radial
        rms[name] = velocity if velocity > ROUNDING_UM_S else 0.0
    sound = housing_of_scene(scene, linear_ring(model), motion.velocity_m_s[:, 0])
    rms[HOUSING.name] = None
    if sound is not None:
        weighted = a_weighted(sound.pressure, motion.rate_hz)
        is_moving = any(rms.values())
        rms[HOUSING.name] = float(np.sqrt(np.mean(np.square(weighted)))) if is_moving else 0.0
    return rms


class RingSolver(Solver):
    """Marches the contacts of bearings once, and moves the ring of each specimen.

    stack : ExitStack. It ends the processes.
    folder : Path. Folder of the choice.
    workers : int. Number of processes that march and move rings; 0: one per core.
    """

    def __init__(self, stack: ExitStack, folder: Path, workers: int) -> None:
        self._stack = stack
        self._folder = folder
        self._workers = workers
        self._pool: Pool | None = None
        self._marches: dict[str, ContactMarch] = {}
        self._plans: dict[Candidate, ContactPlan] = {}
        self._rough: dict[Candidate, dict[str, StoredRoughBand]] = {}

    def solve(
        self, specimens: Sequence[Specimen], names: Sequence[str], stored: Sequence[Specimen]
    ) -> None:
        """Solve specimens that are not heard yet, and write what is heard of them."""
        lacking = [specimen for specimen in specimens if not specimen.is_heard]
        if not lacking:
            return
        for specimen in lacking:
            prepare(self._folder, specimen)
        self._march(dict.fromkeys(specimen.candidate for specimen in lacking))
        step = progress.step(f"moving the rings of {len(lacking)} specimens")
        with step, shortage.as_memory_error():
            try:
                self._move_rings(lacking)
            except BrokenExecutor:  # a process was killed; the rest is done in this one
                self._pool = self._stack.enter_context(Pool())
                self._move_rings([specimen for specimen in lacking if not specimen.is_heard])

    def _march(self, candidates: Mapping[Candidate, Any]) -> None:
        """March the rough contacts of candidates that are new; equal ones are marched once."""
        new = [candidate for candidate in candidates if candidate not in self._plans]
        plans = {candidate: contact_plan(candidate.scene) for candidate in new}
        contacts = [
            contact for plan in plans.values() for stage in plan.stages for contact in stage
        ]
        if contacts:
            home = self._folder / RUNS
            self._marches |= march_contacts(
                contacts, name="marching contacts", folder=home, workers=self._workers
            )
        with progress.step("judging the gains of the contacts"):
            for candidate, plan in plans.items():
                bands = rough_bands(candidate.scene.model, plan, self._marches)
                self._rough[candidate] = {
                    name: StoredRoughBand(
                        whole=band.whole, without_groups=tuple(band.without_groups.tolist())
                    )
                    for name, band in bands.items()
                }
        self._plans |= plans

    def _move_rings(self, lacking: Sequence[Specimen]) -> None:
        """Move the rings of specimens, and write what is heard of each in their order."""
        if self._pool is None:
            self._pool = self._stack.enter_context(pool_for_tasks(self._workers, len(lacking)))
        at_once = self._pool.slots * sum(self._pool.teams.values())
        in_hand: deque[tuple[Specimen, Future[Any]]] = deque()
        for specimen in lacking:
            plan = self._plans[specimen.candidate]
            arguments = (specimen.scene, plan, self._marches, specimen.number)
            key = (specimen.candidate.label, str(specimen.number))
            in_hand.append((specimen, self._pool.submit(Task(key, heard_specimen, arguments))))
            if len(in_hand) >= at_once:
                self._keep(*in_hand.popleft())
        while in_hand:
            self._keep(*in_hand.popleft())

    def _keep(self, specimen: Specimen, future: Future[Any]) -> None:
        """Wait for a specimen, and write down what is heard of it."""
        heard_ring = HeardRing(**future.result(), rough=self._rough[specimen.candidate])
        write_heard_file(specimen, heard_ring)
