"""Cold solves of wide windows begin on coarser cells, and end at the same contact."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import rough

from rolling.contact import single_contact
from rolling.contact.half_space import HalfSpace
from rolling.contact.single_contact import Contact, solve_contact
from rolling.contact.solver import ContactError

SPACING = 2e-6  # [m]
MODULUS = 115e9  # [Pa]
RADIUS = 5e-3  # [m]
TOLERANCE = 5e-6


def _gap(rows: int, columns: int, ra: float) -> np.ndarray:
    """Return the gap below a sphere [m], over a rough plate."""
    x = (np.arange(rows) - rows / 2) * SPACING
    y = (np.arange(columns) - columns / 2) * SPACING
    gap = (x[:, None] ** 2 + y**2) / (2 * RADIUS) - rough(rows, columns, ra)
    return gap - gap.min()


def _load(nodes: int, share: float = 0.3) -> float:
    """Return the load [N] of a smooth contact whose radius is a share of so many nodes."""
    return 4 / 3 * MODULUS * (share * nodes * SPACING) ** 3 / RADIUS


def _violation(half_space: HalfSpace, gap: np.ndarray, contact: Contact, hardness: float) -> float:
    """Return the maximum violation of the contact conditions over the maximum deflection."""
    deflection = half_space.deflection(contact.pressure)
    opening = gap + deflection - contact.approach
    violation = np.abs(opening)
    open_nodes = contact.pressure <= 0
    capped = contact.pressure >= hardness
    violation[open_nodes] = np.maximum(-opening[open_nodes], 0)
    violation[capped] = np.maximum(opening[capped], 0)
    return float(violation.max() / deflection.max())


@pytest.mark.law("Wide cold solves: the contact conditions hold, and iterations do not grow.")
@pytest.mark.parametrize("hardness", [np.inf, 6e9], ids=["elastic", "capped"])
@pytest.mark.parametrize("shape", [(257, 300), (512, 512), (640, 401)])
def test_a_wide_cold_solve_takes_few_iterations(shape: tuple[int, int], hardness: float) -> None:
    """Without coarser cells the same surfaces take 9 to 58 iterations."""
    half_space = HalfSpace(SPACING, MODULUS)
    gap = _gap(*shape, 5e-7)
    load = _load(min(shape))
    contact = solve_contact(half_space, gap, load, hardness=hardness, tolerance=TOLERANCE)
    assert contact.iterations <= 12
    assert contact.load == pytest.approx(load, rel=1e-12)
    assert contact.pressure.min() >= 0 and contact.pressure.max() <= hardness
    assert _violation(half_space, gap, contact, hardness) <= 1.01 * TOLERANCE


@pytest.mark.law("Wide cold solves: coarser cells lead to the contact that a foundation leads to.")
@pytest.mark.parametrize("blended", [False, True])
def test_coarser_cells_change_the_start_alone(
    blended: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    half_space = HalfSpace(SPACING, MODULUS)
    gap = _gap(300, 260, 3e-7)
    shape = gap if blended else None
    load = _load(260)
    arguments = {"hardness": 5e9, "shape": shape, "tolerance": TOLERANCE}
    cascade = solve_contact(half_space, gap, load, **arguments)
    monkeypatch.setattr(single_contact, "CASCADE_NODES", 10**9)
    foundation = solve_contact(half_space, gap, load, **arguments)
    allowed = TOLERANCE * foundation.max_deflection
    assert abs(cascade.approach - foundation.approach) <= 2 * allowed
    assert cascade.contact_area == pytest.approx(foundation.contact_area, rel=5e-3)
    assert cascade.edge_share == pytest.approx(foundation.edge_share, abs=1e-3)


def test_an_impossible_load_is_told_in_its_own_numbers() -> None:
    """The window's own area stands in the message, not that of coarser cells without odd rows."""
    half_space = HalfSpace(SPACING, MODULUS)
    gap = np.zeros((301, 257))
    load = 1.1 * 1e9 * gap.size * SPACING**2
    with pytest.raises(ContactError, match=f"a load of {load:.6g} N .* 3.094e-7 m2"):
        solve_contact(half_space, gap, load, hardness=1e9)


def test_a_window_that_yields_nearly_as_a_whole_is_solved() -> None:
    """Coarser cells without the odd rows could not carry this load."""
    half_space = HalfSpace(SPACING, MODULUS)
    gap = _gap(301, 257, 1e-7)
    load = 0.9995 * 1e9 * gap.size * SPACING**2
    contact = solve_contact(half_space, gap, load, hardness=1e9, tolerance=TOLERANCE)
    assert contact.load == pytest.approx(load, rel=1e-12)
    assert _violation(half_space, gap, contact, 1e9) <= 1.01 * TOLERANCE


def test_a_window_longer_than_the_transforms_is_solved_on_a_single_peak() -> None:
    """The mean of the coarse cells has no such peak, and would load the whole window."""
    half_space = HalfSpace(SPACING, MODULUS)
    gap = np.full((8, 13_000), 1e-6)
    gap[4, 6_500] = 0.0
    contact = solve_contact(half_space, gap, load=1e-6)
    assert contact.contact_area == pytest.approx(SPACING**2)
