"""Plan of the contacts that a bearing needs: rough contacts and stretches around faults.

A smooth raceway or ball needs none. A bearing has four kinds of rough contact at most: the surface
of each raceway, and that of the balls on each raceway. Waves around a body need no march either:
they enter by the linear response of the contact.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

from acoustics.arrays import short_repr
from acoustics.numbers import rounded, rounded_down
from rolling.bearing import waves
from rolling.bearing.geometry import BearingGeometry, RacewayContact
from rolling.bearing.oil_film import ContactFilm
from rolling.bearing_kind.faults import FaultStretch, fault_stretches
from rolling.bearing_kind.rough_contacts import (
    ContactKind,
    MarchNumbers,
    RoughContact,
    contact_loads,
    march_numbers,
    measured_contact,
    overlap_reach,
    rough_contact,
)
from rolling.check import long_steps, resolution
from rolling.marches.piece import contact_identity
from rolling.scene import height_files
from rolling.scene.bearing_rules import refuse_height_files
from rolling.scene.bearing_scene import BearingScene
from rolling.scene.bearing_sections import BearingNumerics
from rolling.scene.laws import Roughness
from rolling.scene.messages import SceneError
from rolling.scene.raceways import BearingSurface
from rolling.scene.scene import Scene
from rolling.scene.surfaces import BallHeightFile

RINGS = ("inner", "outer")


@dataclass(frozen=True)
class ContactPlan:
    """Contacts of a bearing.

    geometry : BearingGeometry.
    loads_n : tuple of float, N. Ascending loads of the marches.
    surfaces : dict. Surfaces of "inner", "outer" and "balls"; None for a smooth one.
    fault_ball : int. Number of the ball that has the faults of the balls.
    folder : Path. Folder from which relative paths of height files start.
    rough : dict. Rough contacts by name.
    faults : tuple of FaultStretch.
    films : dict. Films of oil on the inner and on the outer raceway; none in dry contacts.
    """

    __repr__ = short_repr

    geometry: BearingGeometry
    loads_n: tuple[float, ...]
    surfaces: dict[str, BearingSurface | None]
    fault_ball: int
    folder: Path
    rough: dict[str, RoughContact]
    faults: tuple[FaultStretch, ...]
    films: Mapping[str, ContactFilm] = field(default_factory=dict)

    @property
    def stages(self) -> list[list[Scene]]:
        """Scenes to march, the most urgent first: faults, rough contacts, then all other loads.

        After the first stage the tracks hold the faults at the middle load, and the roughness by
        its linear response. After the second one they hold the roughness at the middle load. That
        is all for a measured turn, which is long: other loads change its linear response only. A
        contact that a film of oil parts is not marched, because its linear response acts alone.
        """
        touching = [contact for name, contact in self.rough.items() if not self.is_parted(name)]
        faults: list[Scene] = []
        rough = [contact.scene for contact in touching]
        rest: list[Scene] = []
        for contact in touching:
            if not contact.scene.height_paths:
                rest += contact.scenes.values()
        for stretch in self.faults:
            faults += [stretch.with_fault, stretch.without]
            rest += [scene for pair in stretch.scenes.values() for scene in pair]
        return [faults, rough, rest]

    def is_marched(self, marches: Collection[str]) -> bool:
        """Tell whether all contacts are among marches by their contact identities."""
        return all(contact_identity(scene) in marches for stage in self.stages for scene in stage)

    def has_faults_at_all_loads(self, marches: Collection[str]) -> bool:
        """Tell whether all faults are among marches by their contact identities, at all loads."""
        pairs = [pair for stretch in self.faults for pair in stretch.scenes.values()]
        return all(contact_identity(scene) in marches for pair in pairs for scene in pair)

    def is_parted(self, name: str) -> bool:
        """Tell whether a film of oil parts the surfaces of a kind of contact."""
        film = self.films.get(ring_of(name))
        return film is not None and film.weight >= 1

    def without_faults(self) -> ContactPlan:
        """Return the plan of the same bearing without its single faults; it needs no more march."""
        surfaces = {
            body: None if surface is None else surface.model_copy(update={"faults": None})
            for body, surface in self.surfaces.items()
        }
        return replace(self, surfaces=surfaces, faults=())


def contact_plan(scene: BearingScene) -> ContactPlan:
    """Return the contacts that the scene of a bearing needs.

    Parameters
    ----------
    scene : BearingScene
        A scene without a sweep.

    Raises
    ------
    SceneError
        A contact cannot be made with these values, or a file of heights cannot be used.
    """
    refuse_height_files(scene)
    bearing = scene.bearing
    surfaces = bearing.surfaces
    plan = plan_contacts(
        scene.geometry,
        {"inner": surfaces.inner, "outer": surfaces.outer, "balls": surfaces.balls},
        contact_loads(scene.geometry, scene.loaded_ring),
        speed_m_s=scene.kinematics.rolling_speed_m_s,
        body={
            "youngs_modulus_gpa": bearing.youngs_modulus_gpa,
            "poissons_ratio": bearing.poissons_ratio,
        },
        numerics=scene.numerics,
        fault_ball=surfaces.fault_ball,
        folder=scene.folder,
    )
    plan = replace(plan, films=scene.films)
    _refuse_long_steps(scene, plan)
    return plan


def _refuse_long_steps(scene: BearingScene, plan: ContactPlan) -> None:
    """Refuse nodes so far apart that a step leads over several contacts.

    Raise SceneError with the distance of nodes that would fit, for each key that gives one.
    """
    allowed_um: dict[str, float] = {}
    step_um: dict[str, float] = {}
    for march in (march for stage in plan.stages for march in stage):
        longest = long_steps.MAX_RADII * resolution.contact_radius(march)
        if march.step <= longest:
            continue
        key = "numerics.spacing_um"
        if march.height_paths:
            key = f"bearing.surfaces.{body_of(march.name)}.spacing_um"
        nodes_um = 1e6 * longest / march.step_nodes
        allowed_um[key] = min(nodes_um, allowed_um.get(key, nodes_um))
        step_um[key] = max(1e6 * march.step, step_um.get(key, 0.0))
    lines = []
    for key, longest_um in allowed_um.items():
        lines.append(
            f"{scene.place(key)}: {key}: steps of {rounded(step_um[key], 4)} um are longer than"
            f" {long_steps.MAX_RADII:g} semi-axes of a contact at the least load; allowed: at most"
            f" {rounded_down(longest_um)}"
        )
    if lines:
        raise SceneError(lines)


def body_of(name: str) -> str:
    """Return the body whose roughness a kind of contact meets: inner, outer or balls."""
    return name.partition("-")[0]


def ring_of(name: str) -> str:
    """Return the raceway of a kind of contact by its name: inner or outer."""
    return "inner" if name.endswith("inner") else "outer"


def contact_of(geometry: BearingGeometry, name: str) -> RacewayContact:
    """Return the smooth contact of a kind of contact by its name."""
    return geometry.inner if name.endswith("inner") else geometry.outer


def radius_of(geometry: BearingGeometry, body: str) -> float:
    """Return the radius of the circle of "inner", "outer" or "balls" on which a contact runs."""
    if body == "balls":
        return geometry.ball_radius_m
    return contact_of(geometry, body).radius_m


def kinds_of_contact(body: str) -> tuple[str, ...]:
    """Return the names of the kinds of contact that meet the surface of a body."""
    if body == "balls":
        return tuple(f"balls-on-{ring}" for ring in RINGS)
    return (body,)


def plan_contacts(
    geometry: BearingGeometry,
    surfaces: dict[str, BearingSurface | None],
    loads_n: tuple[float, ...],
    *,
    speed_m_s: float,
    body: dict[str, float | str],
    numerics: BearingNumerics,
    fault_ball: int = 0,
    folder: Path = Path(),
) -> ContactPlan:
    """Return the contacts that a bearing needs.

    Parameters
    ----------
    geometry : BearingGeometry
    surfaces : dict
        Surfaces of "inner", "outer" and "balls"; None for a smooth one.
    loads_n : tuple of float, N
        Ascending loads of the marches, as of `contact_loads`.
    speed_m_s : float, m/s
        Rolling speed.
    body : dict
        Keys of the material of rings and balls, as of `sphere` and `plate`.
    numerics : BearingNumerics
        Length of the closed track that is marched, distance of its nodes, tolerance.
    fault_ball : int
        Number of the ball that has the faults of the balls. Default: the first.
    folder : Path
        Folder from which relative paths of height files start.

    Raises
    ------
    SceneError
        A contact cannot be made with these values.
    """
    rough: dict[str, RoughContact] = {}
    faults: list[FaultStretch] = []
    for body_name, surface in surfaces.items():
        if surface is None:
            continue
        names = kinds_of_contact(body_name)
        law = law_of(surface)
        nodes_um = numerics.spacing_um
        if isinstance(surface, BallHeightFile):
            nodes_um = surface.spacing_um
        radius = radius_of(geometry, body_name)
        numbers = _shared_numbers(
            [contact_of(geometry, name) for name in names],
            law,
            loads_n,
            speed_m_s=speed_m_s,
            turn_m=2 * math.pi * radius,
            window_mm=numerics.window_mm,
            spacing_um=nodes_um,
            tolerance=numerics.tolerance,
        )
        kinds = [
            ContactKind(
                name=name,
                contact=contact_of(geometry, name),
                numbers=numbers,
                loads_n=loads_n,
                speed_m_s=speed_m_s,
                body=body,
            )
            for name in names
        ]
        if isinstance(surface, BallHeightFile):
            contacts = _measured_contacts(kinds, surface, folder)
        elif law is not None:
            contacts = [rough_contact(kind, law) for kind in kinds]
        else:
            contacts = []
        rough |= {contact.name: contact for contact in contacts}
        for kind in kinds:
            faults += fault_stretches(kind, surface.faults or (), radius_m=radius, law=law)
    return ContactPlan(
        geometry=geometry,
        loads_n=loads_n,
        surfaces=surfaces,
        fault_ball=fault_ball,
        folder=folder,
        rough=rough,
        faults=tuple(faults),
    )


def _measured_contacts(
    kinds: Sequence[ContactKind], turn: BallHeightFile, folder: Path
) -> list[RoughContact]:
    """Return the contacts over a measured turn; none where it is narrower than a contact."""
    _, columns = height_files.nodes(folder / turn.path)
    contacts = []
    for kind in kinds:
        profile_width_um = None
        if columns == 1:
            nodes = math.ceil(kind.numbers.width_um / turn.spacing_um)
            profile_width_um = nodes * turn.spacing_um
        _, reach = overlap_reach(kind.contact, max(kind.loads_n), 0.0)
        if columns > 1 and columns * turn.spacing_um * 1e-6 < 2 * reach:
            return []
        contacts.append(measured_contact(kind, turn, profile_width_um, folder))
    return contacts


def law_of(surface: BearingSurface) -> Roughness | None:
    """Return the law of the random heights of a surface, None for a smooth or measured one."""
    if isinstance(surface, BallHeightFile):
        return None
    law = surface.law
    assert law is None or isinstance(law, Roughness)  # the only law of bodies that turn
    return law


def _shared_numbers(
    contacts: Sequence[RacewayContact],
    law: Roughness | None,
    loads_n: Sequence[float],
    *,
    speed_m_s: float,
    turn_m: float,
    window_mm: float,
    spacing_um: float | None,
    tolerance: float | Literal["auto"],
) -> MarchNumbers:
    """Return the grid on which all contacts of a surface are marched, so that they see it alike.

    The shortest contact sets nodes and steps, and the largest one width and length.
    """
    laws = [] if law is None else [law]
    shortest = min(contacts, key=lambda contact: waves.semi_axes(contact, min(loads_n)).along)
    numbers = march_numbers(
        shortest,
        laws,
        loads_n,
        speed_m_s=speed_m_s,
        turn_m=turn_m,
        window_mm=window_mm,
        spacing_um=spacing_um,
        tolerance=tolerance,
    )
    each = [
        march_numbers(
            contact,
            laws,
            loads_n,
            speed_m_s=speed_m_s,
            turn_m=turn_m,
            window_mm=window_mm,
            spacing_um=numbers.spacing_um,
        )
        for contact in contacts
    ]
    longest = max(other.distance_mm for other in each)
    return replace(
        numbers,
        width_um=max(other.width_um for other in each),
        distance_mm=max(numbers.distance_mm, longest),
    )
