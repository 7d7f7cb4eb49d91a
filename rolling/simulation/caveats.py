"""The caveats of a run's numbers, shared by terminal, page and files."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from acoustics.bands import OFF_DB
from rolling.check import resolution
from rolling.check.finding import Finding
from rolling.scene.scene import Scene
from rolling.simulation.moving_load import MovingRelease
from rolling.simulation.run_errors import RunErrors
from rolling.sound import error_estimate, solver_error
from rolling.sound.contact_sound import ContactSound
from rolling.sound.vibration_sound import Vibration

BENT = 0.1  # range of the plate's displacement over its thickness up to which it is small
SHORT_S = 0.3  # a shorter period of repetition is heard as a tone
# these stand beside every level
HEADLINE = (
    "upper_bound",
    "assumed_q",
    "fixed_gain",
    "on_axis",
    "infinite_plate",
    "unvalidated",
    "uncertainty",
)
REPEATS = ("short_loop", "short_track")  # these stand beside every player
# all other caveats are warnings of the check
STANDING = (
    *HEADLINE,
    *REPEATS,
    "partial",
    "not_loopable",
    "quasi_static",
    "constant_load_release",
    "moving_load_release",
    "no_vibration",
)


@dataclass(frozen=True)
class Caveat:
    """A limit of a run's numbers.

    key : str. Name for programs, which never changes with the wording.
    text : str. The caveat in plain sentences.
    """

    key: str
    text: str


@dataclass(frozen=True)
class Remark:
    """A caveat that several runs share.

    key : str. The key of the caveat.
    text : str. The caveat in plain sentences.
    labels : tuple of str. The runs that it concerns; empty: all runs.
    """

    key: str
    text: str
    labels: tuple[str, ...] = ()

    @property
    def line(self) -> str:
        """The text with the labels of its runs."""
        return self.text + (f" ({'; '.join(self.labels)})" if self.labels else "")


def caveats(
    scene: Scene,
    sound: ContactSound,
    findings: Iterable[Finding],
    complete: bool,
    errors: RunErrors | None = None,
    vibration: Vibration | None = None,
    moving: MovingRelease | None = None,
) -> list[Caveat]:
    """List the caveats of a run: the standing caveats, then the warnings of check and solver.

    Parameters
    ----------
    scene : Scene. A scene without a sweep.
    sound : ContactSound. The sound of the run.
    findings : iterable of Finding. Findings of the scene.
    complete : bool. Whether all steps are solved.
    errors : RunErrors. Errors from grid and solver. Default: the scene does not ask for them.
    vibration : Vibration. Vibration of sphere and plate. Default: the run has none.
    moving : MovingRelease. The release under the moving load, or its fault. Default: none.
    """
    estimated = errors is not None and not errors.reason
    result = [*_of_levels(scene, sound, estimated), *_of_record(scene, sound)]
    if not complete:
        result.append(
            Caveat(
                "partial",
                "Not all steps are solved: numbers and sound cover the solved beginning only.",
            )
        )
    result.append(_of_load(scene, vibration, moving))
    result += [
        Caveat(each.key, f"{each.quantity}: {each.warning}")
        for each in findings
        # A measured error of the grid stands for the rule's estimate.
        if each.warning and (each.key != resolution.KEY or not _knows_grid(scene, errors))
    ]
    result += _of_errors(scene, errors)
    if vibration is not None:
        result += _of_vibration(scene, vibration)
    if sound.source == "vibration":
        return result
    hidden = solver_error.doubt(scene, sound.audible_rms, sound.resolved_rms)
    return [*result, Caveat("solver", f"solver: {hidden}")] if hidden else result


def loops(sound: ContactSound) -> bool:
    """Return whether the record can be repeated without a click."""
    return sound.loops


def stored(numbers: Mapping[str, Any]) -> list[Caveat]:
    """Read the caveats from the summary of a run."""
    return [Caveat(**each) for each in numbers["caveats"]]


def gathered(runs: Sequence[tuple[str, Sequence[Caveat]]]) -> list[Remark]:
    """Merge caveats of the same key, in the words of the first run.

    Parameters
    ----------
    runs : sequence of pairs. Label and caveats of each run.
    """
    by_key: dict[str, dict[str, str]] = {}
    for label, each in runs:
        for caveat in each:
            by_key.setdefault(caveat.key, {})[label] = caveat.text
    remarks = []
    for key, texts in by_key.items():
        first, text = next(iter(texts.items()))
        if len(set(texts.values())) > 1:
            text += f" (in the numbers of {first})"
        remarks.append(Remark(key, text, () if len(texts) == len(runs) else tuple(texts)))
    return remarks


def _of_load(scene: Scene, vibration: Vibration | None, moving: MovingRelease | None) -> Caveat:
    """Return the caveat of the load under which the release was computed."""
    if scene.dynamics is None:
        return Caveat(
            "quasi_static",
            "The load is held constant: the sphere neither bounces nor rings on its contact.",
        )
    if vibration is None:
        return Caveat(
            "no_vibration", "The vibration is missing, because its force law is not complete."
        )
    if moving is not None and moving.fault:
        return Caveat(
            "no_moving_release",
            f"release: of the constant load, because there is none under the moving load:"
            f" {moving.fault}",
        )
    if moving is not None:
        return Caveat(
            "moving_load_release",
            "The release is computed under the moving load; the series along the track are of the"
            " constant load.",
        )
    return Caveat(
        "constant_load_release",
        "The release is computed under the constant load; dynamics.release: true computes it under"
        " the moving load.",
    )


def _of_vibration(scene: Scene, vibration: Vibration) -> list[Caveat]:
    """List the warnings of a vibration: extrapolated forces, flight, drift, a plate far bent."""
    motion, result = vibration.motion, list[Caveat]()
    if motion.outside_share > 0:
        text = (
            f"force law: the contact force leaves the marched loads of"
            f" {vibration.law.load_n[0]:.3g} to {vibration.law.load_n[-1]:.3g} N for"
            f" {100 * motion.outside_share:.2g} % of the time, and is extrapolated there"
        )
        result.append(Caveat("force_outside", text))
    if motion.flight_share > 0:
        impacts = f"{motion.impacts} impact{'' if motion.impacts == 1 else 's'}"
        text = f"contact: lost for {100 * motion.flight_share:.2g} % of the time, with {impacts}"
        if motion.flight_share == 1:
            text += ": the record is shorter than a flight; choose a longer one"
        result.append(Caveat("impacts", text))
    if scene.track.closed and not motion.settled and scene.surface.kind != "smooth":
        text = "motion: it does not repeat from lap to lap, so its record does not loop" + (
            "; impacts need not repeat"
            if motion.flight_share > 0
            else "; it has not run in, so another record may have another level"
            if scene.motion.is_constant(scene.duration)
            else ""
        )
        result.append(Caveat("not_settled", text))
    thickness = scene.plate.thickness_mm
    if thickness is not None and (bent := 1e3 * np.ptp(motion.plate_m) / thickness) > BENT:
        text = (
            f"plate: it sinks and rises by {bent:.2g} of its thickness; thin-plate theory wants a"
            f" deflection that is small against it, at most about {BENT:g}"
        )
        result.append(Caveat("plate_deflection", text))
    return result


def _knows_grid(scene: Scene, errors: RunErrors | None) -> bool:
    """Return whether the error of the grid in the release was measured."""
    levels = errors.levels if errors and scene.sound.source == "release" else None
    return levels is not None and math.isfinite(levels.grid_signal_db)


def _of_errors(scene: Scene, errors: RunErrors | None) -> list[Caveat]:
    """List the caveats of the error estimate: its absence, its reach, and bands that are off."""
    if errors is None:
        return []
    if errors.levels is None or errors.effort is None:
        return [Caveat("no_error_estimate", f"error estimate: none, because {errors.reason}")]
    result = []
    signal = errors.levels.grid_signal_db
    if _knows_grid(scene, errors) and (coarse := resolution.measured(scene, signal)):
        result.append(Caveat(resolution.KEY, coarse))
    if not errors.effort.reached:
        text = (
            f"error estimate: its standard errors reach {errors.effort.worst_uncertainty_db:.1f} dB"
            f" between 1 and 16 kHz, {error_estimate.WANTED_DB:g} dB are wanted: a longer"
            f" rolling.{'duration_s' if scene.rolling.distance_mm is None else 'distance_mm'} pays"
            " for more stretches"
        )
        result.append(Caveat("error_estimate_reach", text))
    if off := errors.off_db():
        bands = ", ".join(f"{name} Hz ({error:+.1f})" for name, error in off.items())
        text = (
            f"grid and solver: third octaves off by more than {OFF_DB:g} dB: {bands};"
            " a smaller surface.spacing_um brings them down"
        )
        result.append(Caveat("band_errors", text))
    return result


def _of_levels(scene: Scene, sound: ContactSound, estimated: bool) -> list[Caveat]:
    """List the caveats of the levels; a silent run has none."""
    if sound.steady_level is None and sound.levels.level_db is None:
        return []
    if sound.source == "vibration":
        return _of_vibration_levels(scene, estimated)
    result, s = [], scene.sound
    fixed = s.gain_pa_per_w_m2 is not None
    if s.q == 1:
        levels = "The steady level is" if fixed or sound.levels.level_db is None else "Levels are"
        text = f"{levels} an upper bound: all released energy counts as radiated (q = 1)."
        result.append(Caveat("upper_bound", text))
    else:
        result.append(
            Caveat(
                "assumed_q",
                f"The scene assumes that {s.q:g} of the released energy is radiated (q).",
            )
        )
    if fixed:
        text = (
            f"The scene's gain of {s.gain_pa_per_w_m2:g} Pa per W/m² decides every level but the "
            "steady one."
        )
        result.append(Caveat("fixed_gain", text))
    result.append(_unvalidated())
    if sound.uncertainty.level_db is not None or sound.steady_uncertainty is not None:
        text = "± covers the record's length alone, taken as stationary Gaussian noise; it holds "
        text += (
            "no error of the model. Errors of grid and solver are estimated beside the levels,"
            " which are not corrected for them."
            if estimated
            else "no error of model, grid or solver."
        )
        result.append(Caveat("uncertainty", text))
    return result


def _unvalidated() -> Caveat:
    return Caveat("unvalidated", "No level has been validated against a microphone.")


def _of_vibration_levels(scene: Scene, estimated: bool) -> list[Caveat]:
    """List the caveats of levels that belong to the vibration."""
    sources = "plate and sphere" if scene.sound.ball else "plate"
    body = (
        "a half-space"
        if scene.plate.thickness_mm is None
        else "an infinite plate without modes, edges or supports"
    )
    return [
        Caveat(
            "on_axis",
            f"Levels are the pressure of {sources} on the axis through the contact, at one listener"
            f" at {scene.sound.distance_m:g} m without a room.",
        ),
        Caveat(
            "infinite_plate",
            f"The sphere rolls on {body}, pressed by a constant force without mass; friction,"
            " rocking and rotation are left out.",
        ),
        _unvalidated(),
        Caveat(
            "uncertainty",
            "± covers the record's length alone, taken as stationary Gaussian noise; it holds no"
            + (
                " error of the model. Errors of grid, solver and force law are estimated beside the"
                " levels, which are not corrected for them."
                if estimated
                else " error of model, grid or solver, and numerics.error_estimate: true estimates"
                " the last two."
            ),
        ),
    ]


def _of_record(scene: Scene, sound: ContactSound) -> list[Caveat]:
    """List the caveats of the record.

    They concern a record that does not loop, or a repetition that is heard as a tone.
    """
    result = []
    if not loops(sound):
        text = (
            "The record does not close on itself: it is faded at both ends, "
            "and a loop of it has gaps."
        )
        if sound.closed:
            text = "The ends of the record do not fit together: a loop of it clicks."
        result.append(Caveat("not_loopable", text))
    if sound.levels.level_db is None:
        return result
    lap = _lap_seconds(scene, sound)
    heard = f"{_times(lap)} a second: the pitch that is heard is the repetition, not the contact."
    if loops(sound) and sound.duration < SHORT_S:
        result.append(
            Caveat(
                "short_loop", f"When it loops, the record of {sound.duration:.3g} s repeats {heard}"
            )
        )
    elif lap < min(SHORT_S, 0.999 * sound.duration):
        result.append(
            Caveat("short_track", f"The track repeats in the record every {lap:.3g} s, {heard}")
        )
    return result


def _lap_seconds(scene: Scene, sound: ContactSound) -> float:
    """Return the time after which a record repeats itself [s].

    If the speed changes, this is the mean time.
    """
    rolled_track = scene.track
    lap = rolled_track.lap_steps * rolled_track.step
    rolled = float(scene.motion.distance(sound.duration))
    return sound.duration * min(1.0, lap / rolled)


def _times(period: float) -> str:
    rate = 1.0 / period
    return f"{rate:.2g} times" if rate < 10 else f"{rate:.0f} times"
