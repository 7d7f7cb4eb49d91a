"""Errors of contact edges on many kinds of surface, against a fine grid of the same surface.

`python tests/benchmarks/edge_study.py` prints the numbers of docs/accuracy.md, which takes five
minutes of one free core. Arguments choose the scenes whose names contain one of them.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from hard_cases.gaussian_heights import gaussian
from tqdm import tqdm

from acoustics.arrays import Array
from rolling.contact.march import march
from rolling.contact.recovery import step_energy
from rolling.contact.state import RollingContact
from rolling.contact.subcells import half_space_of
from rolling.surface.refined import dies_out, subcell_heights
from rolling.surface.subcell_contact import auto_subcells, on_subcells

SPACING = 2e-6
NODES = (256, 192)
SPEED = 0.1  # [m/s], for the frequencies of the bands
FINEST = 4
REFERENCE_TOLERANCE = 1e-6
TOLERANCE = 1e-4
STEPS = 60  # positions of the stretch
START = 20  # position of its beginning
BANDS_HZ = (4000.0, 8000.0, 16000.0)  # octaves


@dataclass(frozen=True)
class EdgeScene:
    """A surface under a sphere of 5 mm radius on a steel plate that yields.

    name : str. Name in the table.
    make : callable. Function that makes the heights, an (along, across) array [m].
    hardness_gpa, load_n : float, GPa and N. Hardness of the plate and normal load.
    unseen : bool. True if no constant of the edges was fitted on the scene.
    """

    name: str
    make: Callable[[], Array]
    hardness_gpa: float
    load_n: float
    unseen: bool = False

    def contact(self) -> RollingContact:
        """Make the contact with sharp edges on cells of one node."""
        return RollingContact(
            heights=self.make(),
            spacing=SPACING,
            radius=5e-3,
            contact_modulus=210e9 / (1 - 0.3**2),
            hardness=self.hardness_gpa * 1e9,
            load=self.load_n,
            step=SPACING,
            start=START * SPACING,
            tolerance=TOLERANCE,
            blended=False,
        )


def rough(ra_um: float, length_um: float, law: str = "gaussian", seed: int = 1) -> Array:
    """Make random heights [m]."""
    lengths = (length_um * 1e-6, length_um * 1e-6)
    return gaussian(NODES, SPACING, ra_um * 1e-6, lengths, law, seed)


def pitted(ra_um: float, share: float, depth_um: float, seed: int) -> Array:
    """Make random heights [m] with pits of one node on a share of the nodes."""
    z = rough(ra_um, 10, seed=seed)
    z[np.random.default_rng(seed + 98).random(NODES) < share] -= depth_um * 1e-6
    return z


def grooved(ra_um: float, width: int, depth_um: float, seed: int) -> Array:
    """Make random heights [m] with grooves across the track, so many nodes wide, 20 nodes apart."""
    z = rough(ra_um, 10, seed=seed)
    z[np.arange(NODES[0]) % 20 < width] -= depth_um * 1e-6
    return z


def scratched(ra_um: float, seed: int) -> Array:
    """Make random heights [m] with scratches along the track, a node wide and 0.5 um deep."""
    z = rough(ra_um, 10, seed=seed)
    z[:, np.random.default_rng(seed).random(NODES[1]) < 0.08] -= 0.5e-6
    return z


EXPONENTIAL = "exponential_10pct"
SCENES = (
    EdgeScene("Ra 0.1, 2.1 GPa, 5 N", lambda: rough(0.1, 10), 2.1, 5),
    EdgeScene("Ra 0.3, L 20, 2.1 GPa, 5 N", lambda: rough(0.3, 20), 2.1, 5),
    EdgeScene("Ra 1, 2.1 GPa, 20 N", lambda: rough(1, 10, seed=5), 2.1, 20),
    EdgeScene("Ra 1, 2.1 GPa, 5 N", lambda: rough(1, 10), 2.1, 5),
    EdgeScene("Ra 1 exponential 10 %, 6.3 GPa, 5 N", lambda: rough(1, 10, EXPONENTIAL), 6.3, 5),
    EdgeScene("Ra 0.01, 2.1 GPa, 20 N", lambda: rough(0.01, 10), 2.1, 20),
    EdgeScene("Ra 0.1, 6.3 GPa, 20 N", lambda: rough(0.1, 10, seed=7), 6.3, 20),
    EdgeScene("Ra 0.01, 6.3 GPa, 5 N", lambda: rough(0.01, 10, seed=3), 6.3, 5),
    EdgeScene("2 % pits of one node, 2.1 GPa, 5 N", lambda: pitted(0.1, 0.02, 2, 1), 2.1, 5),
    EdgeScene("Ra 0.1, seed 11, 2.1 GPa, 8 N", lambda: rough(0.1, 10, seed=11), 2.1, 8, True),
    EdgeScene("Ra 0.2, L 8, 3 GPa, 5 N", lambda: rough(0.2, 8, seed=12), 3.0, 5, True),
    EdgeScene("Ra 0.5, L 15, 2.1 GPa, 5 N", lambda: rough(0.5, 15, seed=13), 2.1, 5, True),
    EdgeScene("Ra 0.7, L 10, 4 GPa, 5 N", lambda: rough(0.7, 10, seed=14), 4.0, 5, True),
    EdgeScene("Ra 1, seed 15, 2.1 GPa, 5 N", lambda: rough(1, 10, seed=15), 2.1, 5, True),
    EdgeScene(
        "Ra 0.3 exponential, 4 GPa, 5 N", lambda: rough(0.3, 10, "exponential", 16), 4, 5, True
    ),
    EdgeScene("grooves of 2 nodes, 2.1 GPa, 5 N", lambda: grooved(0.1, 2, 1, 17), 2.1, 5, True),
    EdgeScene("scratches of a node, 3 GPa, 5 N", lambda: scratched(0.05, 18), 3.0, 5, True),
    EdgeScene("1 % pits, Ra 0.3, 4 GPa, 5 N", lambda: pitted(0.3, 0.01, 1, 19), 4.0, 5, True),
    EdgeScene("Ra 0.02, seed 20, 1.5 GPa, 8 N", lambda: rough(0.02, 10, seed=20), 1.5, 8, True),
)  # fmt: skip


@dataclass(frozen=True)
class Stretch:
    """The numbers of one march.

    release : (steps,) array, J. Release of each step.
    contact_area, plastic_area : float, m2. Mean areas.
    convolutions : float. Mean number per step.
    step_ms : float, ms. Processor time per step.
    """

    release: Array
    contact_area: float
    plastic_area: float
    convolutions: float
    step_ms: float


def finer(contact: RollingContact, times: int) -> RollingContact:
    """Return a contact on cells `times` finer, with each node in the middle of its cells."""
    smooth = dies_out(contact.heights)
    spacing = contact.spacing / times
    return replace(
        contact,
        heights=subcell_heights(contact.heights, times, smooth),
        spacing=spacing,
        start=contact.start + (times - 1) / 2 * spacing,
        slopes=smooth,
    )


def roll(contact: RollingContact, steps: int) -> Stretch:
    """March a contact over some steps.

    A step in advance prepares compiled code and transforms.
    """
    half_space = half_space_of(contact.spacing, contact.contact_modulus, contact.subcells)
    list(march(contact, 0, 1, half_space))
    began = time.process_time()
    states = []
    release = []
    old = None
    for state in march(contact, 0, steps, half_space):
        if old is not None:
            release.append(step_energy(old, state, half_space).release)
        states.append((state.contact_area, state.plastic_area, state.convolutions))
        old = state
    area, plastic, convolutions = np.mean(states, axis=0)
    step_ms = 1e3 * (time.process_time() - began) / steps
    return Stretch(
        release=np.array(release),
        contact_area=float(area),
        plastic_area=float(plastic),
        convolutions=float(convolutions),
        step_ms=step_ms,
    )


def variants(contact: RollingContact) -> dict[str, RollingContact]:
    """Return the contact with sharp edges, and blended on 1, 2 x 2 and `auto` sub-cells."""
    blended = replace(contact, blended=True)
    chosen = auto_subcells(blended)
    return {
        "sharp": contact,
        "blended, 1": on_subcells(blended, 1),
        "blended, 2": on_subcells(blended, 2),
        "auto": on_subcells(blended, chosen),
    }


def reference(contact: RollingContact, times: int = FINEST) -> RollingContact:
    """Return the contact on a fine grid, with blended edges where its surface is smooth.

    Flat cells have sharp edges, because their own borders are the borders of patches.
    """
    fine = replace(finer(contact, times), tolerance=REFERENCE_TOLERANCE)
    return replace(fine, blended=fine.slopes)


def band_power(release: Array, middle_hz: float) -> float:
    """Return the power of the release's fluctuation in an octave, from a tapered record."""
    taper = np.hanning(len(release))
    lines = np.abs(np.fft.rfft((release - release.mean()) * taper)) ** 2
    frequency = np.fft.rfftfreq(len(release), SPACING / SPEED)
    inside = (frequency >= middle_hz / np.sqrt(2)) & (frequency < middle_hz * np.sqrt(2))
    return float(lines[inside].sum())


def errors(stretch: Stretch, fine: Stretch) -> dict[str, float]:
    """Return the errors of a stretch: signal, octaves and level in dB, means in percent."""
    spread = fine.release.std()
    return {
        "signal": 20 * np.log10(np.std(stretch.release - fine.release) / spread),
        "level": 20 * np.log10(stretch.release.std() / spread),
        **{
            f"{middle / 1000:g} kHz": 10
            * np.log10(band_power(stretch.release, middle) / band_power(fine.release, middle))
            for middle in BANDS_HZ
        },
        "release %": 100 * (stretch.release.mean() / fine.release.mean() - 1),
        "contact area %": 100 * (stretch.contact_area / fine.contact_area - 1),
        "plastic area %": 100 * (stretch.plastic_area / fine.plastic_area - 1)
        if fine.plastic_area
        else 0.0,
    }


def rows(scene: EdgeScene, steps: int = STEPS) -> list[dict[str, object]]:
    """March the variants of a scene and return their errors."""
    contact = scene.contact()
    fine = roll(reference(contact), steps)
    name = f"{scene.name} *" if scene.unseen else scene.name
    table: list[dict[str, object]] = []
    for edges, variant in variants(contact).items():
        stretch = roll(variant, steps)
        label = f"auto: {variant.subcells}" if edges == "auto" else edges
        costs = {"convolutions": stretch.convolutions, "ms per step": stretch.step_ms}
        table.append({"scene": name, "edges": label} | errors(stretch, fine) | costs)
    return table


def main(names: Sequence[str] = ()) -> int:
    """Print the table of all scenes, or of those whose names hold one of the given texts."""
    chosen = [s for s in SCENES if not names or any(name in s.name for name in names)]
    table = pd.DataFrame([row for scene in tqdm(chosen) for row in rows(scene)])
    print(table.to_string(index=False, float_format="{:.2f}".format))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
