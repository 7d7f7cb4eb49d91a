"""Specimens of a ball whose levels are given, written as marches would write them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from rolling.ball_kinds.ball_audition import BallAudition
from rolling.ball_kinds.ball_heard import loss_factors_of
from rolling.choice import omissions
from rolling.choice.heard_specimen import Specimen
from rolling.choice.specimen_solving import RunSolver
from rolling.scene.identity import scene_identity
from rolling.terminal.whole_files import write_json


def stand_in(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Write what is heard of specimens in place of marches, and list which were asked for.

    Specimens of a candidate whose name has an `x` fail from the third on, every third one.
    """
    asked: list[str] = []

    def solve(
        self: RunSolver, specimens: Sequence[Specimen], labels: Sequence[str], **_: object
    ) -> None:
        folder = self._folder
        for specimen, label in zip(specimens, labels, strict=True):
            if specimen.is_heard:
                continue
            asked.append(label)
            seed = specimen.scene.surface.seed
            if "x" in label.split(",")[0] and seed % 3 == 0:
                omissions.remember(folder, specimen, "no solution; take a larger surface.width_um")
                continue
            write_heard(specimen, seed)

    monkeypatch.setattr(RunSolver, "solve", solve)
    monkeypatch.setattr(BallAudition, "audible", lambda *_: ())
    return asked


def write_heard(specimen: Specimen, seed: int) -> None:
    """Write a level of a specimen: 20 dB(A) over Ra, and a scatter of 2 dB."""
    specimen.folder.mkdir(parents=True)
    random = np.random.default_rng((seed, round(1e3 * specimen.scene.surface.roughness_ra_um)))
    level_db = 40 + 20 * math.log10(specimen.scene.surface.roughness_ra_um) + random.normal(0, 2)
    square = (20e-6) ** 2 * 10 ** (level_db / 10)
    losses = len(loss_factors_of(specimen))
    content: dict[str, Any] = {
        "loss_factors": list(loss_factors_of(specimen)),
        "squares_pa2": [square] * losses,
        "bands_pa2": [[square] + [0.0] * 30] * losses,
        "released_power_db": 60.0,
        "errors_db": {},
        "parts_db": {"record": 1.0, "time_step": 0.3, "baffle": 6.0},
        "baffle_db": [6.0] * 31,
        "scene": scene_identity(specimen.scene),
    }
    for name in ("result.h5", "summary.json"):
        (specimen.folder / name).touch()
    write_json(specimen.folder / "heard.json", content)
