"""Simulation of a bearing: contacts, tracks, motion of the ring, and the run that follows."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from acoustics import wav
from rolling.bearing.ring_record import record_of
from rolling.bearing_kind import needs, stored_run
from rolling.bearing_kind.bearing_run import BearingRun, numbered, with_numbers
from rolling.bearing_kind.bearing_run_numbers import MarchFindings, with_effort
from rolling.bearing_kind.contact_doubts import contact_doubts, marched_contacts
from rolling.bearing_kind.contact_plan import ContactPlan, contact_plan
from rolling.bearing_kind.contact_uncertainty import contact_uncertainty
from rolling.bearing_kind.joined_tracks import bearing_tracks
from rolling.bearing_kind.moved_ring import moved_ring
from rolling.bearing_kind.solved_bearing import SolvedBearing
from rolling.bearing_kind.without_faults import without_faults_of_record
from rolling.contact.processor_time import ProcessorTime
from rolling.contact.solver import ContactError
from rolling.kinds.registry import kind_of
from rolling.kinds.run_folder import RESULT, RunFolder
from rolling.marches import effort
from rolling.marches.effort import Effort
from rolling.marches.piece import contact_identity
from rolling.numbers.bearing_numbers import FaultlessNumbers
from rolling.results.stored_numbers import read_stored
from rolling.run.march_files import Marches
from rolling.scene import library
from rolling.scene.bearing_scene import BearingScene
from rolling.scene.messages import SceneError
from rolling.terminal import progress


def make_run(place: RunFolder, label: str, marches: Marches) -> BearingRun:
    """Return the run that all marches of a bearing give, with its numbers.

    Parameters
    ----------
    place : RunFolder
        Scene, swept values and folder.
    label : str
        Label of the run.
    marches : dict
        Marches of its contacts by contact identity.

    Raises
    ------
    ContactError
        The ring cannot be moved.
    """
    began = ProcessorTime.now()
    plan = contact_plan(place.scene)
    bearing = move_bearing(place, label, plan, marches)
    findings = _findings(bearing, plan, marches)
    with progress.step("making the numbers"):
        run = numbered(bearing, findings)
    parts = march_effort(plan, marches).numbers(effort.OF_BEARING)
    parts = effort.with_work(parts, effort.SOUND, ProcessorTime.now().since(began))
    return with_numbers(run, with_effort(run.numbers, parts))


def read_run(place: RunFolder, label: str) -> BearingRun:
    """Read a run from its folder, with its stored numbers, under a label.

    Raises
    ------
    FolderError : a file is missing or damaged, or the result is that of another scene.
    """
    stored = read_stored(place.folder, kind_of(place.scene).name)
    record, tracks = stored_run.read_result(place.folder / RESULT, place.scene)
    bearing = SolvedBearing(
        values=place.values,
        scene=place.scene,
        folder=place.folder,
        label=label,
        record=record,
        tracks=tracks,
    )
    return with_numbers(bearing, stored.numbers, stored)


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


def refuse(
    scene: BearingScene, workers: int, folder: Path | None, unsolved: Sequence[BearingScene]
) -> None:
    """Refuse a scene with a run that cannot be computed here, before anything is written.

    Parameters
    ----------
    scene : BearingScene
        A scene with or without a sweep.
    workers : int
        Number of processes; 0 means one per core.
    folder : Path or None
        Folder of the results; None if nothing is written.
    unsolved : sequence of BearingScene
        Runs whose files the folder lacks.

    Raises
    ------
    SceneError : a height file cannot be used, or memory or disk do not suffice.
    """
    for run in unsolved:
        lines = [need.line for need in needs.excess(run, contact_plan(run), workers, folder)]
        if lines:
            raise SceneError(lines)


def move_bearing(
    place: RunFolder, label: str, plan: ContactPlan, marches: Marches
) -> SolvedBearing:
    """Move the ring of a bearing over the tracks that the marches give.

    Raises
    ------
    ContactError : the ring cannot be moved.
    """
    scene = place.scene
    with progress.step("laying the rough contacts around balls and raceways"):
        tracks = bearing_tracks(plan, marches)
    try:
        motion = moved_ring(scene.model, tracks, scene.moved, wav.SAMPLE_RATE_HZ)
    except ValueError as error:
        raise ContactError(str(error)) from error
    return SolvedBearing(
        values=place.values,
        scene=scene,
        folder=place.folder,
        label=label,
        record=record_of(motion, scene.kinematics, scene.sensor),
        tracks=tracks,
    )


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

    The heights, the seeds and the places of the balls are the same. A first answer, which lacks
    marches, does without them.
    """
    if not bearing.faulty or not plan.is_marched(marches):
        return None
    tracks = bearing_tracks(plan.without_faults(), marches)
    scene = bearing.scene
    motion = moved_ring(scene.model, tracks, scene.moved, wav.SAMPLE_RATE_HZ)
    record = record_of(motion, scene.kinematics, scene.sensor)
    return without_faults_of_record(record, scene.kinematics, bearing.envelope_band.band_hz)


def hardness_pa(scene: BearingScene) -> float:
    """Return the hardness [Pa] of rings and balls; infinite where it is unknown."""
    named = library.named_values("plate", scene.bearing.material)
    hardness_gpa = named.get("hardness_gpa")
    return 1e9 * hardness_gpa if isinstance(hardness_gpa, float | int) else math.inf
