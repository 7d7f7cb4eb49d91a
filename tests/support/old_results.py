"""result.h5 as version 0.1.0 and its followers wrote it, without format, identity and digest."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np

from rolling.simulation.result import Result
from rolling.simulation.simulate import STATE_SERIES, STEP_SERIES


def save_old(path: Path, result: Result, deflection: bool) -> None:
    """Write a result in format 1; version 0.1.0 had no series of the maximum deflection."""
    with h5py.File(path, "w") as file:
        file.attrs.update(
            title="rolling contact noise: old",
            steps=result.steps,
            solved_steps=result.solved_steps,
            step_m=result.step,
            start_m=result.start,
            complete=result.complete,
        )
        for name in STEP_SERIES + STATE_SERIES:
            if name != "max_deflection" or deflection:
                file[name] = result.whole(name)
        if result.snapshot is not None:
            group = file.create_group("snapshot")
            group.attrs.update(
                distance_m=result.snapshot.distance,
                along_m=result.snapshot.along,
                across_m=result.snapshot.across,
            )
            group["pressure"], group["deflection"] = (
                result.snapshot.pressure,
                result.snapshot.deflection,
            )
        maps = [result.maps[position] for position in sorted(result.maps)]
        if maps:
            group = file.create_group("pressure_maps")
            for name in ("position", "distance", "along", "across", "cell"):
                group[name] = [getattr(one, name) for one in maps]
            group["shape"] = [one.pressure.shape for one in maps]
            flat = np.concatenate([one.pressure.ravel() for one in maps])
            group.create_dataset("pressure", data=flat, compression="gzip", shuffle=True)
        tables = result.event_pieces.items()
        for first, columns in (
            [("events", result.events() or {})] if result.complete and tables else tables
        ):
            group = file.create_group(first if result.complete else f"event_pieces/{first}")
            for column, values in columns.items():
                group[column] = values
