"""Simulation of a bearing: contacts, tracks, motion of the ring, and the run that follows."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

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
from rolling.bearing_run.bearing_run import BearingRun
from rolling.bearing_run.without_faults import without_faults_of_record
from rolling.contact.processor_time import ProcessorTime
from rolling.marches import effort
from rolling.marches.effort import Effort
from rolling.marches.piece import contact_identity
from rolling.run import folder as folders
from rolling.scene import library
from rolling.scene.bearing_scene import BearingScene
from rolling.scene.messages import SceneError
from rolling.terminal import progress


@dataclass(frozen=True)
class BearingStage:
    """Run of a bearing after a stage of its marches; only the last one is final.

    run : BearingRun. The run with the tracks that are known so far.
    is_final : bool. Whether all marches are done.
    """

    __repr__ = short_repr

    run: BearingRun
    is_final: bool


def bearing_stages(
    scene: BearingScene,
    *,
    folder: Path | None = None,
    workers: int = 0,
    shown: bool | None = None,
    start_from: Path | None = None,
) -> Iterator[BearingStage]:
    """Simulate a bearing, and yield its run when its first marches are done, and when all are.

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
        run, spent = _heard(scene, plan, {}, is_final=True)
        yield BearingStage(_with_parts(run, Effort(), [spent]), is_final=True)
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
        is_final = number == len(stages)
        run, spent = _heard(scene, plan, marches, is_final)
        motions.append(spent)
        yield BearingStage(_with_parts(run, march_effort(plan, marches), motions), is_final)


def _heard(
    scene: BearingScene, plan: ContactPlan, marches: Marches, is_final: bool
) -> tuple[BearingRun, ProcessorTime]:
    """Return the run that the marches give, and the processor time that its motions took."""
    began = ProcessorTime.now()
    run = _moved(scene, plan, marches)
    if is_final:
        run = _final(run, plan, marches)
    return run, ProcessorTime.now().since(began)


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


def _with_parts(run: BearingRun, marched: Effort, motions: Sequence[ProcessorTime]) -> BearingRun:
    """Return a run with the processor times of its marches and motions."""
    parts = marched.numbers(effort.OF_BEARING)
    for spent in motions:
        parts = effort.with_work(parts, effort.SOUND, spent)
    return replace(run, parts_cpu_s=parts)


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


def _moved(scene: BearingScene, plan: ContactPlan, marches: Marches) -> BearingRun:
    """Move the ring of a bearing over the tracks that the marches give."""
    with progress.step("laying the rough contacts around balls and raceways"):
        tracks = bearing_tracks(plan, marches)
    motion = move_ring(scene.model, tracks, scene.moved, wav.SAMPLE_RATE_HZ)
    with progress.step("judging the rough contacts"):
        contacts = [asdict(contact) for contact in marched_contacts(plan, marches)]
        record = record_of(motion, scene.kinematics)
        uncertainty = contact_uncertainty(plan, marches, scene.model, record)
        doubts = contact_doubts(plan, marches, hardness_pa(scene), uncertainty)
    return BearingRun(
        scene=scene,
        record=record,
        tracks=tracks,
        solved=doubts,
        contacts=tuple(_without_unknown(contact) for contact in contacts),
        contact_uncertainty=uncertainty,
    )


def _final(run: BearingRun, plan: ContactPlan, marches: Marches) -> BearingRun:
    """Return a run with the numbers of the same bearing without its single faults, if it has some.

    The heights, the seeds and the places of the balls are the same.
    """
    if not run.faulty:
        return run
    tracks = bearing_tracks(plan.without_faults(), marches)
    scene = run.scene
    motion = move_ring(scene.model, tracks, scene.moved, wav.SAMPLE_RATE_HZ)
    record = record_of(motion, scene.kinematics)
    return replace(run, without_faults=without_faults_of_record(record, scene.kinematics))


def hardness_pa(scene: BearingScene) -> float:
    """Return the hardness [Pa] of rings and balls; infinite where it is unknown."""
    named = library.named_values("plate", scene.bearing.material)
    hardness_gpa = named.get("hardness_gpa")
    return 1e9 * hardness_gpa if isinstance(hardness_gpa, float | int) else math.inf


def _without_unknown(numbers: Mapping[str, Any]) -> dict[str, Any]:
    """Return numbers for JSON, with None for those that are not known."""
    plain = {}
    for name, value in numbers.items():
        is_unknown = isinstance(value, float) and not math.isfinite(value)
        plain[name] = None if is_unknown else value
    return plain


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
