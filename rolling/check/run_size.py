"""Size of a run before it is run: the plain numbers from which memory, disk and steps are judged.

Laws and headers of files give them, so no heights are made or read.
"""

from dataclasses import dataclass

from rolling.contact.estimated_contact import contact_radius_m, overlap_across_m, window_nodes
from rolling.dynamics.drop import IMPACT_STEPS, impact_s
from rolling.in_si.physics_of_scene import bodies_of
from rolling.scene.grid_error import law_roughness, law_subcells
from rolling.scene.scene import Scene
from rolling.scene.surfaces import MadeSurface

TIME_STEPS = 40.0  # of a motion in a period of the resonance


@dataclass(frozen=True, kw_only=True)
class RunSize:
    """Numbers of a run that its memory, its files and the length of its steps depend on.

    Attributes
    ----------
    radius_mm : float
        Radius of the sphere, as the scene gives it.
    contact_radius_m : float, m
        Larger of the elastic and the fully plastic reach of the smooth contact along the track.
    window_nodes : float
        Nodes along the side of a square of the area of the overlap, at both ends.
    smooth_overlap_nodes : float
        Nodes across the overlap of the smooth contact.
    subcells : int
        Sub-cells along the side of a cell.
    spacing_m, step_m : float, m
        Distance of nodes, and of positions.
    step_nodes : float
        Nodes from one position to the next.
    steps, solved_steps : int
        Steps of the record, and those that are solved on the track.
    n_along, n_across : int
        Nodes of the track along and across.
    surface_nodes : int
        Nodes of the surface, and of a turn of a sphere that has a surface.
    is_made : bool
        Whether the surface of the plate is made, and not read from a file.
    is_smooth, has_moments : bool
        Whether the bodies are perfectly smooth, and whether some random heights are not Gaussian.
    kept_passes : int
        Passes over a plate with memory. 0: it has none.
    duration_s : float, s
        Time of the record.
    is_constant : bool
        Whether the speed is constant.
    fastest_m_s : float, m/s
        Highest speed.
    has_motion : bool
        Whether sphere and plate move.
    motion_rate_hz : float, Hz
        Time steps of their motion per second.
    keeps_events, estimates_error : bool
        Whether recovery events are recorded, and whether an error is estimated.
    channels : int
        Number of channels.
    """

    radius_mm: float
    contact_radius_m: float
    window_nodes: float
    smooth_overlap_nodes: float
    subcells: int
    spacing_m: float
    step_m: float
    step_nodes: float
    steps: int
    solved_steps: int
    n_along: int
    n_across: int
    surface_nodes: int
    is_made: bool
    is_smooth: bool
    has_moments: bool
    kept_passes: int
    duration_s: float
    is_constant: bool
    fastest_m_s: float
    has_motion: bool
    motion_rate_hz: float
    keeps_events: bool
    estimates_error: bool
    channels: int


def run_size(scene: Scene) -> RunSize:
    """Return the size of the run of a scene without a sweep.

    Raises
    ------
    SceneError
        A height file is missing or holds no heights, or the sphere never gets round it.
    """
    bodies = bodies_of(scene)
    contact = bodies.contact
    rq_m, _ = law_roughness(scene)  # 0 beside a height file, which counts as gentle
    subcells = law_subcells(scene)
    track = scene.track
    spacing = scene.spacing
    step_nodes = scene.step_nodes
    duration = scene.duration
    fastest = scene.motion.fastest(duration)
    rate = max(TIME_STEPS * bodies.bounce_hz, fastest / scene.step)
    if not scene.keeps_its_load:
        rate = max(rate, IMPACT_STEPS / impact_s(bodies))
    across = overlap_across_m(contact, scene.hardness, 0.0)
    window = window_nodes(contact, scene.hardness, rq_m, spacing, step_nodes)
    return RunSize(
        radius_mm=scene.sphere.radius_mm,
        contact_radius_m=contact_radius_m(contact, scene.hardness),
        window_nodes=window,
        smooth_overlap_nodes=2 * across / spacing,
        subcells=subcells,
        spacing_m=spacing,
        step_m=scene.step,
        step_nodes=step_nodes,
        steps=track.steps,
        solved_steps=track.solved_steps,
        n_along=track.n_along,
        n_across=track.n_across,
        surface_nodes=track.surface_nodes,
        is_made=isinstance(scene.surface, MadeSurface),
        is_smooth=scene.is_smooth,
        has_moments=scene.has_moments,
        kept_passes=scene.passes if scene.is_permanent else 0,
        duration_s=duration,
        is_constant=scene.motion.is_constant(duration),
        fastest_m_s=fastest,
        has_motion=scene.dynamics is not None,
        motion_rate_hz=rate,
        keeps_events=bool(scene.recovery.events),
        estimates_error=_estimates_error(scene),
        channels=len(scene.sound.channels or ()),
    )


def _estimates_error(scene: Scene) -> bool:
    """Tell whether windows of other grids are solved: for an error, or for an instrument."""
    instrument = getattr(scene.surface, "instrument", None)
    return bool(scene.numerics.error_estimate) or instrument is not None
