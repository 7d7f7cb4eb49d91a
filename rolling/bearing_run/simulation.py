"""Simulation of a bearing: contacts, tracks, motion of the ring, and the run that follows."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from acoustics import wav
from acoustics.arrays import short_repr
from rolling.bearing.kinematics import Kinematics
from rolling.bearing.motion import RingMotion, move_ring
from rolling.bearing.ring_record import RingRecord
from rolling.bearing_contacts import needs
from rolling.bearing_contacts.contact_doubts import contact_doubts, marched_contacts
from rolling.bearing_contacts.contact_uncertainty import contact_uncertainty
from rolling.bearing_contacts.joined_tracks import bearing_tracks
from rolling.bearing_contacts.plan import ContactPlan, contact_plan
from rolling.bearing_contacts.solving import Marches, solved_stages
from rolling.bearing_run.bearing_run import BearingRun, numbered, with_numbers
from rolling.bearing_run.numbers import MarchFindings, with_effort
from rolling.bearing_run.solved_bearing import SolvedBearing
from rolling.bearing_run.without_faults import without_faults_of_record
from rolling.contact.processor_time import ProcessorTime
from rolling.marches import effort
from rolling.marches.effort import Effort
from rolling.marches.piece import contact_identity
from rolling.numbers.bearing_numbers import FaultlessNumbers
from rolling.run import folder as folders
from rolling.scene import library
from rolling.scene.bearing_scene import BearingScene
from rolling.scene.messages import SceneError
from rolling.terminal import progress


@dataclass(frozen=True)
class BearingStage:
    """A bearing after a stage of its marches.

    bearing : SolvedBearing. Motion of its ring over the tracks that are known so far.
    run : BearingRun or None. The run with its numbers, once all marches are done.
    """

    __repr__ = short_repr

    bearing: SolvedBearing
    run: BearingRun | None = None


def bearing_stages(
    scene: BearingScene,
    *,
    folder: Path | None = None,
    workers: int = 0,
    shown: bool | None = None,
    start_from: Path | None = None,
) -> Iterator[BearingStage]:
    """Simulate a bearing, and yield it when its first marches are done, and when all are.

    A bearing without marches has the final run alone.

    Parameters
    ----------
    scene : BearingScene
        A scene without a sweep.
    folder : Path, optional
        Run folder that keeps the marches. Default: they are kept in memory.
    workers : int
        Number of processes; 0 means one per core. Default 0.
    shown : bool, optional
        Whether the progress is shown. Default: where somebody looks.
    start_from : Path, optional
        Run folder of another bearing, whose equal marches are taken.

    Raises
    ------
    SceneError, ContactError, OSError, KeyboardInterrupt
        As `solving.solved_stages`.
    """
    refuse(scene, workers, folder)
    plan = contact_plan(scene)
    stages = [stage for stage in plan.stages if stage]
    if not stages:
        run = _final(scene, plan, {}, motions=[])
        yield BearingStage(run, run)
        return
    solving = solved_stages(
        stages,
        name=scene.name,
        folder=folder,
        workers=workers,
        shown=shown,
        start_from=start_from,
    )
    motions: list[ProcessorTime] = []
    for number, marches in enumerate(solving, start=1):
        if number == len(stages):
            run = _final(scene, plan, marches, motions)
            yield BearingStage(run, run)
            return
        began = ProcessorTime.now()
        bearing = _moved(scene, plan, marches)
        motions.append(ProcessorTime.now().since(began))
        yield BearingStage(bearing)


def _final(
    scene: BearingScene, plan: ContactPlan, marches: Marches, motions: Sequence[ProcessorTime]
) -> BearingRun:
    """Return the run that all marches give, with its numbers.

    motions : sequence of ProcessorTime. What earlier motions of the ring took.
    """
    began = ProcessorTime.now()
    bearing = _moved(scene, plan, marches)
    found = _findings(bearing, plan, marches)
    with progress.step("making the numbers"):
        run = numbered(bearing, found)
    own = ProcessorTime.now().since(began)
    parts = march_effort(plan, marches).numbers(effort.OF_BEARING)
    for spent in [*motions, own]:
        parts = effort.with_work(parts, effort.SOUND, spent)
    return with_numbers(run, with_effort(run.numbers, parts))


def march_effort(plan: ContactPlan, marches: Marches) -> Effort:
    """Return the processor times of the marches of a bearing; equal contacts count once."""
    part_of: dict[str, str] = {}  # by contact identity
    for contact in plan.rough.values():
        for load, scene in contact.scenes.items():
            part = effort.MARCH if load == contact.middle_load_n else effort.LOAD_MARCHES
            part_of.setdefault(contact_identity(scene), part)
    for stretch in plan.faults:
        for pair in stretch.scenes.values():
            for scene in pair:
                part_of.setdefault(contact_identity(scene), effort.FAULT_STRETCHES)
    whole = Effort()
    for identity, part in part_of.items():
        if identity in marches:
            whole.add_piece(part, marches[identity].effort)
    return whole


def refuse(scene: BearingScene, workers: int, folder: Path | None = None) -> None:
    """Refuse a scene with a run that cannot be computed here, before anything is written.

    Raises
    ------
    SceneError : a height file cannot be used, or memory or disk do not suffice.
    """
    for place in folders.bearing_runs_in(folder or Path(), scene):
        if folder is not None and place.is_done:  # its files need no disk any more
            continue
        run = place.scene
        plan = contact_plan(run)
        lines = [need.line for need in needs.excess(run, plan, workers, folder)]
        if lines:
            raise SceneError(lines)


def _moved(scene: BearingScene, plan: ContactPlan, marches: Marches) -> SolvedBearing:
    """Move the ring of a bearing over the tracks that the marches give."""
    with progress.step("laying the rough contacts around balls and raceways"):
        tracks = bearing_tracks(plan, marches)
    motion = move_ring(scene.model, tracks, scene.moved, wav.SAMPLE_RATE_HZ)
    return SolvedBearing(scene, record_of(motion, scene.kinematics), tracks)


def _findings(bearing: SolvedBearing, plan: ContactPlan, marches: Marches) -> MarchFindings:
    """Return what the marches of a bearing say beside its tracks."""
    scene = bearing.scene
    with progress.step("judging the rough contacts"):
        uncertainty = contact_uncertainty(plan, marches, scene.model, bearing.record)
        return MarchFindings(
            doubts=contact_doubts(plan, marches, hardness_pa(scene), uncertainty),
            contacts=tuple(marched_contacts(plan, marches)),
            uncertainty=uncertainty,
            without_faults=_without_faults(bearing, plan, marches),
        )


def _without_faults(
    bearing: SolvedBearing, plan: ContactPlan, marches: Marches
) -> FaultlessNumbers | None:
    """Return the numbers of the same bearing without its single faults, None where it has none.

    The heights, the seeds and the places of the balls are the same.
    """
    if not bearing.faulty:
        return None
    tracks = bearing_tracks(plan.without_faults(), marches)
    scene = bearing.scene
    motion = move_ring(scene.model, tracks, scene.moved, wav.SAMPLE_RATE_HZ)
    record = record_of(motion, scene.kinematics)
    return without_faults_of_record(record, scene.kinematics)


def hardness_pa(scene: BearingScene) -> float:
    """Return the hardness [Pa] of rings and balls; infinite where it is unknown."""
    named = library.named_values("plate", scene.bearing.material)
    hardness_gpa = named.get("hardness_gpa")
    return 1e9 * hardness_gpa if isinstance(hardness_gpa, float | int) else math.inf


def record_of(motion: RingMotion, kinematics: Kinematics) -> RingRecord:
    """Return what a run keeps of the motion of its ring.

    The filter of the motion undershoots where a ball lifts off; no ball bears less than nothing.
    """
    return RingRecord(
        rate_hz=motion.rate_hz,
        velocity_m_s=motion.velocity_m_s,
        acceleration_m_s2=motion.acceleration_m_s2,
        ball_load_n=np.maximum(motion.ball_load_n, 0.0),
        cage_hz=kinematics.cage_hz,
        energy_error=motion.energy_error,
        lost_contact_share=motion.lost_contact_share,
    )
