"""The page's plate of free or clamped edges moves and sounds as the program's."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from live_engine import force_law, node, record, scene, vibration, vibration_data
from test_live_sound import differences

from acoustics import wav
from acoustics.plate_modes import Pair
from acoustics.ritz_plate import RitzPlate
from rolling.report.live import stored_arrays
from rolling.report.live_modes import stored_modes

FREE = ("free", "free")
KINDS = [FREE, ("clamped", "clamped"), ("free", "clamped")]
CONTACT = [0.129, 0.148]
SIDES = (0.3, 0.4)


def steel(
    edges: Pair, thickness_m: float, sides: tuple[float, float] = SIDES, loss_factor: float = 0.01
) -> RitzPlate:
    stiffness = 210e9 * thickness_m**3 / 12 / 0.91
    mass = 7850 * thickness_m
    return RitzPlate(
        mass,
        stiffness,
        loss_factor,
        length_m=sides[0],
        width_m=sides[1],
        poissons_ratio=0.3,
        edges=edges,
    )


def numbers_of(plate: RitzPlate, stored: RitzPlate) -> dict[str, Any]:
    """Return a plate for the engine, with the modes that the page of another plate holds."""
    modes = stored_modes(stored)
    assert modes is not None
    return {
        "massPerArea": plate.mass_per_area_kg_m2,
        "bendingStiffness": plate.bending_stiffness_n_m,
        "lossFactor": plate.loss_factor,
        "length": plate.length_m,
        "width": plate.width_m,
        "stored": stored_arrays(modes),
    }


SCRIPT = """
  const own = new ritz.ComputedPlate({ ...data, computed: ritz.computedModes(data.stored) });
  const shapes = own.modes.map((mode) => own.shape(mode, [0.129, 0.148]));
  const listener = { bodies: [], radiation: own.radiation([0.129, 0.148], [0.3, 0.2, 0.5]) };
  done({ modes: own.modes, shapes, ...response.impulseResponses([listener], 0.7) });
"""


@pytest.mark.parametrize(
    "edges", [FREE, *(pytest.param(edges, marks=pytest.mark.slow) for edges in KINDS[1:])]
)
def test_stored_modes_are_those_of_the_program(edges: Pair) -> None:
    """Frequencies as far as they converge, loss by sound within 5 %, the transfer within -25 dB.

    The page of a plate of 8 mm serves a larger one of 7 mm, too.
    """
    stored = steel(edges, 8e-3)
    larger = steel(edges, 7e-3, (0.33, 0.44))
    got = node(SCRIPT, numbers_of(larger, stored))
    frequency = np.array([mode["w"] for mode in got["modes"]])
    assert frequency == pytest.approx(larger.angular_frequency, rel=5e-5)
    loss = np.array([mode["loss"] for mode in got["modes"]])
    by_sound = larger.loss_factors - larger.loss_factor
    assert np.median(np.abs((loss - 0.01) / by_sound - 1)) < 0.05
    shapes = np.abs(larger.shapes(CONTACT)[0])
    error = np.abs(got["shapes"]) - shapes
    assert np.sqrt(np.mean(np.square(error))) < 0.05 * np.sqrt(np.mean(np.square(shapes)))
    samples = np.roll(got["responses"][0], -got["lead"])
    lines = np.unique(np.geomspace(100, len(samples) * 0.45, 300).astype(int))
    hertz = lines * wav.SAMPLE_RATE_HZ / len(samples)
    wanted = larger.pressure_transfer(hertz, CONTACT, (0.3, 0.2, 0.5), 0.7)
    missed = np.fft.rfft(samples)[lines] - wanted
    assert np.sum(np.abs(missed) ** 2) < 3e-3 * np.sum(np.abs(wanted) ** 2)


CHANGES = {"plate.length_mm": 300, "plate.width_mm": 400, "plate.contact_mm": [129, 148]}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("edges", "changes", "settings"),
    [
        ("free", {}, {}),
        ("clamped", {"plate.length_mm": 330, "plate.width_mm": 440}, {"length": 0.33}),
    ],
)
def test_a_record_is_that_of_the_program(
    edges: str, changes: dict[str, Any], settings: dict[str, Any]
) -> None:
    """As for simply supported edges: reliable third octaves within 0.5 dB, LAeq within 0.2 dB.

    The stored products leave 1 % of a shape.
    """
    begun = scene(CHANGES | {"plate.edges": edges, "plate.thickness_mm": 5})
    law = force_law(begun)
    run = vibration_data(begun, law, vibration(begun, law))
    assert "width" not in run["limits"] and run["limits"]["length"][0] < 0.3
    thinner = run["settings"] | {"thickness": 1e-3}  # more modes than the page holds
    assert node("done(data.map((at) => effort.isPlayable(...at)))", [[run, thinner]]) == [False]
    wanted = vibration(begun.with_(changes), law)
    got, _ = record(run, run["settings"] | settings, wanted.pressures.shape[1])
    bands, laeq = differences(got[0], wanted.listener_levels()[0])
    assert bands < 0.5 and laeq < 0.2
