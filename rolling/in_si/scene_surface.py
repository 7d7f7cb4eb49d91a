"""Surface of a scene, generated or read, centred and levelled.

March, statistics and pictures take the heights from this module. The last surface is kept, because
most runs of a sweep share it, and smaller ones before it, because a sweep or a choice alternates
between them. Tracks beside each other on a plate share its surface.
In pure rolling each place of the sphere meets the place of the plate that it rolled to, so both
surfaces add up to one that does not move: z(x, y) = plate(x, y) + sphere(x mod 2 pi R, y). A track
beside the middle of the plate's surface is made by moving the heights of the plate.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from acoustics.arrays import Array, short_repr
from rolling.contact.kept import Kept
from rolling.in_si import in_metres, measured, plate_file
from rolling.in_si.plate_file import prepared_file
from rolling.scene import height_files, height_grid, surfaces
from rolling.scene.height_files import reason_of
from rolling.scene.laws import HeightLaw
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.surface import heights as surface
from rolling.surface import made, markers
from rolling.surface.ball_form import form_heights, rolled_together, without_first_order
from rolling.surface.heights import Statistics
from rolling.surface.instrument import InstrumentSight, sight, with_law
from rolling.surface.levelling import Levelling
from rolling.surface.lowered_waves import lower_waves, waves_of_band
from rolling.surface.preparation import Effect
from rolling.surface.refined import cells_of_patch, median_step
from rolling.surface.single_faults import add_faults
from rolling.terminal import progress


@dataclass(frozen=True, eq=False)
class SceneSurface:
    """Heights of a scene and their statistics, which are computed when they are first needed."""

    __repr__ = short_repr

    heights: Array  # [m], shape (along, across)
    spacing: float  # [m]
    levelling: Levelling | None = None  # of heights from a file
    preparation: Sequence[Effect] = ()  # of heights from a file, step by step
    part_ra: tuple[float, float] | None = None  # [m] of plate and sphere, where both have a surface
    made: dict[str, Any] = field(default_factory=dict)  # by key in the summary
    # A sentence for each doubt about the height files: marks of points, columns and units.
    suspicions: tuple[str, ...] = ()
    seen: InstrumentSight | None = None  # by the instrument of a file, if the scene states one

    @cached_property
    def statistics(self) -> Statistics:
        """Roughness of the heights that are used."""
        with progress.step("roughness of the surface"):
            return surface.statistics(self.heights, self.spacing)

    @cached_property
    def median_step(self) -> float:
        """Median change of the heights [m] from node to node."""
        return median_step(self.heights)

    @property
    def has_seam(self) -> bool:
        """Tell whether the step from the end of the track to its beginning stands out."""
        return self.levelling is not None and self.levelling.seams[0].stands_out


@dataclass(frozen=True, eq=False)
class _Plate:
    """Surface of a plate with its faults, before the track is moved to its middle.

    Tracks beside each other on one surface share it.
    """

    heights: Array  # [m], shape (along, across)
    levelling: Levelling | None
    effects: Sequence[Effect]
    described: dict[str, Any]
    seen: InstrumentSight | None


MAX_KEPT = 64_000_000  # bytes of the heights of all surfaces that are kept, apart from the last
_kept: Kept[SceneSurface] = Kept(MAX_KEPT, lambda made: made.heights.nbytes)
_plates: Kept[_Plate] = Kept(MAX_KEPT, lambda made: made.heights.nbytes, fewest=0)


def scene_surface(scene: Scene) -> SceneSurface:
    """Generate or read the surface of a scene; raise SceneError where that fails."""

    def make() -> SceneSurface:
        try:
            with progress.step(_making(scene)):
                return _make(scene)
        except surface.SurfaceError as error:
            place = "surface.path" if scene.height_path else "surface"
            raise SceneError([f"{scene.place(place)}: {place}: {error}"]) from error

    return _kept.value(identity(scene), make)


def heights(scene: Scene) -> Array:
    """Return the surface heights of a scene [m], shape (along, across)."""
    return scene_surface(scene).heights


def identity(scene: Scene) -> tuple[Any, ...]:
    """Return values that are equal for scenes with the same surface.

    A file that was written again counts as another file.
    """
    track = scene.track
    ball = scene.sphere.surface
    of_ball = None
    if ball is not None:
        of_ball = (ball.model_dump_json(), track.turn_nodes, scene.start)
    return (
        scene.surface.model_dump_json(),
        of_ball,
        scene.across_nodes,
        scene.folder,
        track.n_along,
        track.n_across,
        *_stamps(scene),
    )


def _plate_identity(scene: Scene) -> tuple[Any, ...]:
    """Return values that are equal for scenes whose plates have the same surface."""
    track = scene.track
    shape = (track.n_along, track.n_across)
    return (scene.surface.model_dump_json(), scene.folder, shape, *_stamps(scene))


def _stamps(scene: Scene) -> list[tuple[int, ...]]:
    """Return what changes when a height file of a scene is written again."""
    stamps: list[tuple[int, ...]] = []
    for section, path in scene.height_paths.items():
        try:
            stamp = path.stat()
        except OSError as error:
            raise SceneError([f"{section}.path: {path}: {reason_of(error)}"]) from error
        stamps.append((stamp.st_mtime_ns, stamp.st_size, stamp.st_ino))
    return stamps


def _making(scene: Scene) -> str:
    """Name the work of `_make` in a few words."""
    if scene.height_paths:
        return f"reading the heights of {', '.join(map(str, scene.height_paths.values()))}"
    return f"making a surface of {scene.track.n_along:,} x {scene.track.n_across:,} nodes"


def _make(scene: Scene) -> SceneSurface:
    """Make the surface of plate and sphere of a scene."""
    made_plate = _plates.value(_plate_identity(scene), lambda: _make_plate(scene))
    plate = under_track(scene, made_plate.heights)
    if scene.sphere.surface is None:
        return SceneSurface(
            heights=plate,
            spacing=scene.spacing,
            levelling=made_plate.levelling,
            preparation=made_plate.effects,
            made=made_plate.described,
            suspicions=tuple(_suspicions(scene)),
            seen=made_plate.seen,
        )
    try:
        ball, described_ball = ball_heights(scene, scene.sphere.surface)
    except surface.SurfaceError as error:
        raise SceneError([f"sphere.surface: {error}"]) from error
    suspicions = tuple(_suspicions(scene))  # after the ball is read, which refuses damaged files
    part_ra = (_ra(plate), _ra(ball))  # before the sum, which may overwrite the plate
    if plate is made_plate.heights and plate.nbytes <= MAX_KEPT:  # it is kept as it is
        plate = plate.copy()
    return SceneSurface(
        heights=rolled_together(plate, ball, scene.track, scene.start),
        spacing=scene.spacing,
        levelling=made_plate.levelling,
        preparation=made_plate.effects,
        part_ra=part_ra,
        made=made_plate.described | described_ball,
        suspicions=suspicions,
        seen=made_plate.seen,
    )


def _make_plate(scene: Scene) -> _Plate:
    """Make the surface of the plate of a scene with its faults."""
    plate, plane, effects = _plate(scene)
    seen = _seen(scene, plate)
    if isinstance(scene.surface, surfaces.WavySurface):
        lower_waves(plate, scene.spacing, scene.surface.lowered_by_m)
    described = _described("surface_made", plate, scene.spacing, scene.surface.law)
    add_faults(plate, [fault.in_si for fault in scene.surface.faults or ()], scene.spacing)
    return _Plate(heights=plate, levelling=plane, effects=effects, described=described, seen=seen)


def waves_of_plate(scene: Scene, wavelengths: Array) -> Iterator[Array]:
    """Yield the part of the heights of a scene that its plate has in each third octave [m].

    These are the waves that `surface.lowered_db` lowers, without single faults and without the
    surface of the sphere.
    """
    plate, _, _ = _plate(scene)
    if isinstance(scene.surface, surfaces.WavySurface):
        lower_waves(plate, scene.spacing, scene.surface.lowered_by_m)
    for wavelength in wavelengths:
        yield under_track(scene, waves_of_band(plate, scene.spacing, float(wavelength)))


def _described(key: str, heights: Array, spacing: float, law: HeightLaw | None) -> dict[str, Any]:
    """Compare made heights [m] with a law that is self-affine or not Gaussian, under a key."""
    if law is None or not made.is_described(law.in_si):
        return {}
    return {key: made.described(heights, spacing, law.in_si)}


def under_track(scene: Scene, plate: Array) -> Array:
    """Move the heights of a plate across, so that its track lies in the middle of the width.

    Everything that follows knows a track in the middle only. The surface of a sphere does not move.
    """
    if scene.across_nodes == 0:
        return plate
    return np.roll(plate, -scene.across_nodes, axis=1)


def _seen(scene: Scene, plate: Array) -> InstrumentSight | None:
    """Find what the instrument of a file sees of the plate; None where the scene states none."""
    path = scene.height_path
    if not isinstance(scene.surface, surfaces.HeightFile) or path is None:
        return None
    if scene.surface.instrument is None:
        return None
    steps = height_grid.height_grid(path, scene.surface).steps
    file_spacing = steps[0] if scene.surface.width_um is not None else max(steps)
    index_um = scene.surface.s_filter_um
    if index_um is not None:  # which hides noise and limits
        plate, _, _ = prepared_file(path, scene.surface.model_copy(update={"s_filter_um": None}))
    seen = sight(plate, scene.spacing, scene.surface.instrument.in_si, file_spacing)
    return seen if index_um is None else replace(seen, s_filter=1e-6 * index_um)


def _ra(heights: Array) -> float:
    """Return the arithmetic mean roughness of heights [m]."""
    return float(np.abs(heights - heights.mean()).mean())


def _plate(scene: Scene) -> tuple[Array, Levelling | None, list[Effect]]:
    """Generate or read the heights of the plate [m], and prepare heights from a file."""
    plate = scene.surface
    path = scene.height_path
    if isinstance(plate, surfaces.HeightFile) and path:
        return prepared_file(path, plate)
    shape = (scene.track.n_along, scene.track.n_across)
    if plate.law is not None:
        return made.of_law(shape, scene.spacing, plate.law.in_si, plate.law.seed), None, []
    return np.zeros(shape), None, []


def _suspicions(scene: Scene) -> Iterator[str]:
    """Yield a sentence for each doubt about a height file: marks of points, columns and units.

    Such values of a plate whose outliers are replaced count as unmeasured, and need no word.
    """
    plate = scene.surface
    ball = scene.sphere.surface
    path = scene.height_path
    if path is not None and isinstance(plate, surfaces.HeightFile):
        read = height_grid.read(path, plate.channel, plate.height_unit, plate.xy_unit)
        yield from measured.doubts(path, read)
        if plate.outliers is None:
            suspects, _ = plate_file.suspected(path, plate)
            if suspects:
                yield markers.sentence(suspects, "surface")
    if isinstance(ball, surfaces.BallHeightFile):
        path = scene.height_paths["sphere.surface"]
        yield from height_files.doubts(path)
        suspects = markers.suspected(height_files.numbers(path), ball.height_unit)
        if suspects:
            yield markers.sentence(suspects, "sphere.surface")


def has_detail(scene: Scene) -> bool:
    """Return whether a scene's surface follows a law that goes on below the spacing."""
    return any(made.has_detail(scene.spacing, law.in_si) for law in scene.laws)


def continued_rows(scene: Scene, first: int, rows: int) -> Array:
    """Return rows of a generated surface at half the spacing, with the detail of its laws [m]."""
    whole = heights(scene)
    patch = whole[(first + np.arange(rows)) % len(whole)]
    seed = (scene.laws[0].seed, first % len(whole), rows)
    laws = [law.in_si for law in scene.laws]
    return made.continued(patch, scene.spacing, laws, seed)


def measured_rows(scene: Scene, first: int, rows: int, finer: int, law: bool) -> Array:
    """Return rows of a measured surface [m], with or without the law below the cut-off.

    The nodes are `finer` times as dense. The waves of the law stand in place of those that the
    instrument does not see, and its noise is removed with them.
    """
    surface_of_scene = scene_surface(scene)
    seen = surface_of_scene.seen
    assert seen is not None  # only asked for with an instrument
    whole = surface_of_scene.heights
    patch = whole[(first + np.arange(rows)) % len(whole)]
    dense = cells_of_patch(patch, 0, len(patch), 1 / finer, 1, smooth=True)
    if not law:
        return dense
    return with_law(dense, scene.spacing / finer, seen, (first % len(whole), rows))


# ---- surface of a sphere


# Part of the seed of a sphere, so that sphere and plate of equal seeds have other heights.
_ROUGHNESS_SEED = 1


def ball_heights(scene: Scene, ball: surfaces.BallSurface) -> tuple[Array, dict[str, Any]]:
    """Make the heights [m] of a sphere's surface, (nodes of a turn, across), and describe them.

    Raises
    ------
    SurfaceError
        The filter leaves nothing, or a file cannot be used.
    """
    track = scene.track
    law = ball.law
    shape = (track.turn_nodes, track.n_across)
    spacing = track.spacing
    if law is not None:
        heights = made.of_law(shape, spacing, law.in_si, (law.seed, _ROUGHNESS_SEED))
    elif isinstance(ball, surfaces.BallHeightFile):
        heights = _read_turn(scene, ball)
    else:
        heights = np.zeros(shape)
    described = _described("ball_surface_made", heights, spacing, law)
    if ball.has_form:
        heights += form_heights(ball.form, track.turn_nodes)[:, None]
    add_faults(heights, [fault.in_si for fault in ball.faults or ()], spacing)
    return heights, described


def _read_turn(scene: Scene, ball: surfaces.BallHeightFile) -> Array:
    """Read the heights [m] of a turn without its wave of order 1, which moves the centre only."""
    path = scene.height_paths["sphere.surface"]
    across = scene.track.n_across
    heights = in_metres.read_heights(path, ball.height_unit, "sphere.surface")
    if heights.shape[1] == 1:
        heights = np.repeat(heights, across, axis=1)
    return without_first_order(heights)
