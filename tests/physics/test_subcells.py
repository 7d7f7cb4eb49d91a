"""Sub-cells: their operator against the fine one, its symmetry, and the rule of `auto`."""

from __future__ import annotations

from dataclasses import replace

import edge_study
import numpy as np
import pytest
from hard_cases import optimality, subcell_deflection
from helpers import STEEL, assert_solved, make_track, releases, roll, rough, step_energies

from rolling.contact.half_space import HalfSpace
from rolling.contact.recovery import EventTable
from rolling.contact.subcells import SubcellSpace, cell_means
from rolling.in_si.contact_of_scene import rolling_contact
from rolling.marches.march_piece import march_piece
from rolling.marches.piece import Piece, contact_identity
from rolling.scene.file import loads
from rolling.scene.scene import Scene
from rolling.surface.refined import dies_out, subcell_heights
from rolling.surface.subcell_contact import auto_subcells, on_subcells

CLOSED = """\
name: closed
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}
surface: {kind: gaussian, roughness_ra_um: 1, correlation_length_um: 10, \
spacing_um: 2, width_um: 400, seed: 3}
rolling: {load_n: 0.5, speed_m_s: 0.1, duration_s: 0.004}
"""


def patches(subcells: int) -> np.ndarray:
    """Return pressures at the hardness on patches of sub-cells."""
    z = subcell_heights(rough(40, 40, 1e-6), subcells, smooth=True)
    p = np.where(z > np.quantile(z, 0.7), 2.1e9, 0.0)
    p[: 4 * subcells] = p[-4 * subcells :] = 0.0
    p[:, : 4 * subcells] = p[:, -4 * subcells :] = 0.0
    return p


@pytest.mark.law("Sub-cells: the deflection by way of whole cells is that of the fine grid.")
@pytest.mark.parametrize(("subcells", "error"), [(2, 0.010), (4, 0.018)])
def test_deflection_is_that_of_the_fine_grid(subcells: int, error: float) -> None:
    """Rms over the rms of the deflection about its mean, on patches: measured 0.8 and 1.4 %."""
    p = patches(subcells)
    spacing = 2e-6 / subcells
    fine = HalfSpace(spacing, STEEL).deflection(p)
    by_cells = SubcellSpace(spacing, STEEL, subcells).deflection(p)
    loaded = p > 0
    assert np.std((by_cells - fine)[loaded]) < error * np.std(fine[loaded])
    assert abs((by_cells - fine)[loaded].mean()) < 1e-3 * fine[loaded].mean()


@pytest.mark.law("Sub-cells: the deflection agrees with a second implementation to rounding.")
@pytest.mark.parametrize("subcells", [2, 4])
def test_deflection_agrees_with_a_second_implementation(subcells: int) -> None:
    p = patches(subcells)
    space = SubcellSpace(1e-6, STEEL, subcells)
    other = subcell_deflection.deflection(p, subcells, optimality.love_coefficients) * space.unit
    assert np.abs(space.deflection(p) - other).max() < 1e-13 * other.max()


@pytest.mark.law("Sub-cells: the operator is symmetric and positive.")
@pytest.mark.parametrize("subcells", [2, 4])
def test_operator_is_symmetric_and_positive(subcells: int) -> None:
    n = 4 * subcells
    space = SubcellSpace(1e-6, STEEL, subcells)
    unit = np.eye(n * n).reshape(n * n, n, n)
    matrix = np.array([space.deflection(p).ravel() for p in unit])
    assert np.abs(matrix - matrix.T).max() < 1e-14 * matrix.max()
    # the true coefficients have 0.52 of their own one as the lowest of all, on a large grid
    assert np.linalg.eigvalsh(matrix)[0] > 0.5 * matrix.max()


@pytest.mark.parametrize("subcells", [2, 4])
def test_blocks_of_a_transform_leave_nothing_behind(subcells: int) -> None:
    """A wide and a tall window share transforms, and each has the deflection it has alone."""
    tall = patches(subcells)[: 36 * subcells]
    wide = tall.T.copy()
    shared = SubcellSpace(1e-6, STEEL, subcells)
    for pressure in (tall, wide, tall, wide):
        alone = SubcellSpace(1e-6, STEEL, subcells).deflection(pressure)
        assert np.array_equal(shared.deflection(pressure), alone)


def test_further_contacts_on_a_surface_share_its_maxima() -> None:
    """They are those of the surface, and other heights or edges have their own."""
    scene = loads(CLOSED)
    first = rolling_contact(scene)
    second = rolling_contact(scene.with_(load_n=1.0))
    assert second.maxima is first.maxima
    assert np.array_equal(first.maxima.rows, first.maxima.tops.max(axis=1))
    assert first.maxima.highest == first.maxima.tops.max() > first.heights.max()
    sharp = rolling_contact(scene.with_({"numerics.edges": "sharp", "numerics.subcells": 1}))
    assert sharp.maxima.tops is sharp.heights
    higher = replace(first, heights=first.heights + 1e-6)
    assert higher.maxima.highest == pytest.approx(first.maxima.highest + 1e-6)
    assert replace(higher, blended=False).maxima.highest == higher.heights.max()


@pytest.mark.slow
@pytest.mark.law("Sub-cells: sharp edges on them are the sharp edges of the fine grid.")
def test_release_on_sub_cells_is_that_of_the_fine_grid() -> None:
    track = make_track(rough(100, 100, 3e-7), load=1.0, hardness=2.1e9, tolerance=1e-6)
    by_cells = on_subcells(track, 2)
    fine = edge_study.finer(track, 2)
    one, other = (releases(t, roll(t, 0, 20)) for t in (by_cells, replace(fine, blended=False)))
    assert np.std(one - other) < 0.03 * np.std(other)


def test_contact_conditions_hold_with_sharp_edges_and_elastic_plates() -> None:
    for hardness in (2.1e9, np.inf):
        track = make_track(rough(60, 60, 1e-7), load=0.5, hardness=hardness, tolerance=1e-7)
        by_cells = replace(on_subcells(replace(track, blended=True), 2), blended=False)
        if hardness == np.inf:
            fine = edge_study.finer(track, 2)
            by_cells = replace(track, heights=fine.heights, spacing=fine.spacing, subcells=2)
        for state in roll(by_cells, 0, 2):
            assert_solved(by_cells, state)


@pytest.mark.slow
@pytest.mark.law("Sub-cells: a piece has the same numbers, whatever was solved before it.")
@pytest.mark.parametrize("subcells", [2, 4])
def test_pieces_do_not_depend_on_other_pieces(subcells: int) -> None:
    """Bit by bit, on a closed track, with transforms that another surface and load have used."""
    scene = loads(CLOSED, [f"numerics.subcells={subcells}"])
    other = loads(CLOSED, ["numerics.subcells=2", "surface.seed=5", "rolling.load_n=3"])
    assert scene.track.closed
    steps = scene.track.steps
    borders = [(0, 12), (12, 24), (steps - 12, steps)]

    def marched(scene: Scene, first: int, last: int) -> dict[str, np.ndarray]:
        piece = Piece(scene, contact_identity(scene), "track", first, last)
        return {
            name: x for name, x in march_piece(piece).items() if name not in ("step_time", "effort")
        }

    forth = [marched(scene, a, b) for a, b in borders]
    marched(other, 0, 3)
    back = [marched(scene, a, b) for a, b in borders[::-1]][::-1]
    for arrays, again in zip(forth, back, strict=True):
        assert "release_energy" in arrays
        for name, values in arrays.items():
            assert np.array_equal(values, again[name], equal_nan=True), name  # padded maps


@pytest.mark.law("Sub-cells: events of nodes add up to the release of sub-cells.")
def test_events_of_cells_add_up() -> None:
    track = on_subcells(
        make_track(rough(60, 60, 1e-7), load=0.5, hardness=2.1e9, tolerance=1e-6, blended=True), 2
    )
    states = roll(track, 0, 6)
    table = EventTable(track.cell_shape)
    for state, step in zip(states, step_energies(track, states), strict=False):
        table.add(state.position, step, track.subcells)
    columns = table.columns()
    assert columns["energy"].sum() == pytest.approx(releases(track, states).sum(), rel=1e-12)
    assert columns["node"].max() < 60


def test_surfaces_whose_spectrum_dies_out() -> None:
    """One pit of a node on a large surface is enough; a law that falls slowly does not die out."""
    smooth = rough(200, 100, 1e-7)
    assert dies_out(smooth) and dies_out(np.zeros((20, 20)))
    pit = smooth.copy()
    pit[100, 50] -= 1e-7
    assert not dies_out(pit)
    assert not dies_out(edge_study.rough(1, 10, edge_study.EXPONENTIAL))


def test_heights_of_sub_cells() -> None:
    """Flat cells keep their height; a wave is known at the centres of sub-cells."""
    z = rough(20, 30, 1e-7)
    np.testing.assert_array_equal(cell_means(subcell_heights(z, 2, smooth=False), 2), z)
    wave = np.sin(2 * np.pi * 3 * np.arange(32) / 32)[:, None] * np.ones(8)
    centres = (np.arange(64) - 0.5) / 2
    expected = np.sin(2 * np.pi * 3 * centres / 32)
    np.testing.assert_allclose(subcell_heights(wave, 2, smooth=True)[:, 3], expected, atol=1e-14)


def test_auto_takes_sub_cells_on_steep_surfaces_that_yield() -> None:
    """Ra 0.1 um at 2.1 GPa is gentle, Ra 1 um steep; sharp edges and elastic plates have none."""
    for ra, hardness, blended, subcells in (
        (1e-7, 2.1e9, True, 1),
        (1e-6, 2.1e9, True, 2),
        (1e-6, 2.1e9, False, 1),
        (1e-6, np.inf, True, 1),
        (1e-6, 2.1e11, True, 1),
    ):
        track = make_track(rough(100, 100, ra), hardness=hardness, blended=blended)
        assert auto_subcells(track) == subcells, (ra, hardness, blended)
    pits = rough(100, 100, 1e-7)
    pits[::7, ::7] -= 2e-6
    assert auto_subcells(make_track(pits, hardness=2.1e9, blended=True)) == 1


@pytest.mark.slow
@pytest.mark.law("Blended edges: on unseen surfaces the release is closer to a fine grid, too.")
def test_study_of_edges_in_short() -> None:
    """Two scenes of the study in 24 steps, one with pits (-11 dB, sharp -5) and a steep one."""
    for name in ("1 % pits", "Ra 0.7"):
        scene = next(scene for scene in edge_study.SCENES if scene.name.startswith(name))
        contact = scene.contact()
        fine = edge_study.roll(edge_study.reference(contact), 24)
        variants = edge_study.variants(contact)
        off = {
            key: edge_study.errors(edge_study.roll(variants[key], 24), fine)
            for key in ("sharp", "auto")
        }
        assert off["auto"]["signal"] < off["sharp"]["signal"] - 5, off
        assert abs(off["auto"]["contact area %"]) < abs(off["sharp"]["contact area %"]) / 2, off
        assert abs(off["auto"]["plastic area %"]) < abs(off["sharp"]["plastic area %"]) / 2, off
