"""A solved run: its marches and its sound, what follows from them, and its numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array
from acoustics.traps import ignoring_underflow
from rolling.contact.recovery import EventStatistics, event_statistics
from rolling.in_si.physics_of_scene import listener_of, smooth_contact_of
from rolling.in_si.scene_surface import scene_surface
from rolling.kinds.run_folder import RunFolder
from rolling.marches.march_variables import STATE_SERIES, STEP_SERIES
from rolling.marches.result import Result, released_energy
from rolling.numbers.ball_numbers import RunNumbers
from rolling.numbers.quantity import Quantity
from rolling.numbers.run_file import StoredNumbers
from rolling.results import labels, long_record
from rolling.results.channels import Channel, channels_of
from rolling.results.release_sound import shift_to_listener_db, sound_of_release
from rolling.scene.scene import Scene
from rolling.sound.contact_sound import ContactSound, contact_sound, middle_speeds
from rolling.sound.long_listening import Listening
from rolling.sound.sound_by_place import SoundByPlace, sound_by_place
from rolling.sound.vibration_sound import Vibration
from rolling.sound.wavelengths import (
    WavelengthOctave,
    linear_shares,
    mean_speed,
    wavelength_octaves,
)


@ignoring_underflow
@dataclass(frozen=True, eq=False, repr=False)
class SolvedRun(RunFolder):
    """Data of a run with its sound, from which its numbers are made.

    It equals no other run, so it can be the key of a dictionary. Its fields are described at `Run`.
    """

    MADE_ONCE = (
        "channels",
        "for_page",
        "long",
        "made_records",
        "release",
        "sound_by_place",
        "wavelength_octaves",
    )

    scene: Scene
    label: str
    result: Result
    sound: ContactSound
    vibration_sound: Vibration | None = None

    def __getstate__(self) -> dict[str, Any]:
        """Return the fields alone, for pickle and copies; what follows from them is made again."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @cached_property  # joining the pieces of the track takes time
    def events(self) -> dict[str, NDArray[Any]] | None:
        """The table of recovery events, or None if none were requested."""
        return self.result.events()

    @cached_property
    def event_statistics(self) -> EventStatistics | None:
        """Statistics of the recovery events on the solved track, or None without events."""
        length = self.result.solved_steps * self.result.step
        return event_statistics(self.events, length) if self.events else None

    @cached_property
    def pass_sounds(self) -> list[ContactSound]:
        """Sound of the release of each pass; empty for a plate without memory."""
        result = self.result
        if result.passes is None:
            return []
        _, is_closed = released_energy(self.scene, result)
        has_seam = scene_surface(self.scene).has_seam
        steps = np.arange(result.steps) % result.solved_steps
        sounds = []
        for lap in result.passes.series["release_energy"]:
            sound = contact_sound(
                lap[steps],
                step=result.step,
                motion=self.scene.motion,
                listener=listener_of(self.scene),
                tolerance=self.scene.tolerance,
                closed=is_closed,
                lap_steps=result.solved_steps,
                has_seam=has_seam,
            )
            sounds.append(sound)
        return sounds

    @cached_property
    def channels(self) -> tuple[Channel, ...]:
        """Signals of plate, ball and contact that the scene asks for; empty if it asks for none.

        They are made again from the marches of a run that is opened, as its sound is.
        """
        return channels_of(self.scene, self.vibration_sound)

    @property
    def title(self) -> str:
        """The scene and the label."""
        return labels.title(self.scene.name, self.label)

    @cached_property
    def wavelength_octaves(self) -> list[WavelengthOctave]:
        """Octaves of roughness wavelength with their parts of the sound.

        A run that is silent and a fall have none.
        """
        if not self.scene.has_release:
            return []
        linear = None
        if self.vibration_sound is not None and self.sound.source == "vibration":
            linear = self._linear_shares
        return wavelength_octaves(
            self.sound,
            speed=mean_speed(self.scene.motion, self.sound),
            own_factor=listener_of(self.scene).has_own_factor,
            linear=linear,
        )

    @property
    def _linear_shares(self) -> dict[int, float]:
        """Coherence of surface and approach by octave of wavelength."""
        scene = self.scene
        return linear_shares(
            heights=self.result.heights_after_passes(scene_surface(scene).heights),
            approach=self.result.series["approach"],
            track=scene.track,
            spacing=scene.spacing,
            start=scene.start,
            semi_axes=smooth_contact_of(scene).semi_axes_m(),
        )

    @cached_property
    def sound_by_place(self) -> SoundByPlace | None:
        """Level of each patch of the track, or None for a run that is silent or falls.

        Its `position` [m] counts along the surface, and its `level_db` is LAeq while the ball
        crosses a patch. By energy the levels add up to LAeq of the record.
        """
        scene = self.scene
        if not scene.has_release:
            return None
        return sound_by_place(
            scene.travel,
            start=scene.start,
            contact_length=2 * smooth_contact_of(scene).semi_axes_m()[0],
            sound=self.sound,
            vibration=self.vibration_sound,
        )

    @cached_property
    def release(self) -> ContactSound | None:
        """Sound of the release, where the vibration is heard; None for a ball that falls."""
        if self.sound.source == "release":
            return self.sound
        if not self.scene.has_release:
            return None
        release = sound_of_release(self.scene, self.result)
        return release.scaled(shift_to_listener_db(self.scene))

    @cached_property
    def made_records(self) -> dict[str, Any]:
        """Records of sources that are made already, which `stated_sound` keeps here."""
        return {}

    @cached_property
    def for_page(self) -> dict[Any, Any]:
        """Parts of the page that follow from the run alone, which the page keeps here."""
        return {}

    @property
    def laps(self) -> float:
        """Number of times that the record holds the solved track, at least 1."""
        return max(1.0, self.result.steps / self.result.solved_steps)

    @property
    def record_laeq_db(self) -> float | None:
        """LAeq of the record itself [dB].

        It differs from the LAeq that is stated where this is the mean over a comb.
        """
        if self.vibration_sound is not None and self.sound.source == "vibration":
            return self.vibration_sound.levels.laeq_db
        return self.sound.levels.laeq_db

    def ends_within(self, seconds: float) -> bool:
        """Tell whether a record of so many seconds is of something that ends."""
        return long_record.ends_within(self.sound, self.scene.motion, seconds)

    @cached_property
    def no_long(self) -> str:
        """Reason why a run has no long record; empty if it has one."""
        return long_record.reason_against_long_record(self.scene, self.result, self.sound)

    @cached_property
    def long(self) -> Listening | None:
        """The record of `sound.listen_s` seconds; None where there is none, or a reason against."""
        seconds = self.scene.sound.listen_s
        if seconds is None or self.no_long:
            return None
        return long_record.make_long_record(
            self.scene, self.result, self.sound, self.vibration_sound, seconds=seconds
        )

    @cached_property
    def series(self) -> Mapping[str, Array]:
        """All series of the whole run by name, in SI units.

        Energies, powers, `speed` and `step_time` have the shape (steps,) and stand at `distance`
        and `time`. States, such as `contact_area`, have the shape (steps + 1,) and stand at
        `position` and `position_time`. `step_time` is NaN in a run that was opened.
        """
        step = self.result.step
        _, speed = middle_speeds(self.scene.motion, self.result.steps, step)
        series = {name: self.result.whole_series(name) for name in STEP_SERIES}
        series["speed"] = speed
        for kind in ("release", "loading"):
            series[f"{kind}_per_metre"] = series[f"{kind}_energy"] * (1 / step)
            series[f"{kind}_power"] = series[f"{kind}_energy"] * (speed / step)
        for name in STATE_SERIES:
            series[name] = self.result.whole_series(name)
        return MappingProxyType(series)

    @property
    def release_power(self) -> Array:
        """(steps,) W. Elastic energy released per time, at `distance` and `time`."""
        return self.series["release_power"]

    @cached_property
    def distance(self) -> Array:
        """(steps,) m. Distance along the track at the middle of each step."""
        middles = (np.arange(self.result.steps) + 0.5) * self.result.step
        return np.asarray(self.result.start + middles, dtype=float)

    @cached_property
    def time(self) -> Array:
        """(steps,) s. Time at the middle of each step."""
        return middle_speeds(self.scene.motion, self.result.steps, self.result.step)[0]

    @cached_property
    def position(self) -> Array:
        """(steps + 1,) m. Distance along the track at each position; a step joins two positions."""
        ends = np.arange(self.result.steps + 1) * self.result.step
        return np.asarray(self.result.start + ends, dtype=float)

    @cached_property
    def position_time(self) -> Array:
        """(steps + 1,) s. Time at each position."""
        motion = self.scene.motion
        ends = np.arange(self.result.steps + 1) * self.result.step
        return np.asarray(motion.time(np.minimum(ends, motion.final_distance)), dtype=float)


@ignoring_underflow
@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class NumberedRun(SolvedRun):
    """A solved run with its numbers. Modules that write or tabulate a run read it by this class.

    `Run` adds player, tables and texts.
    """

    numbers: RunNumbers
    stored: StoredNumbers | None = None

    @property
    def vibration(self) -> Quantity:
        """The vibration: what a listener would hear."""
        return self.numbers.vibration

    @property
    def released_power(self) -> Quantity:
        """What one would hear if all elastic energy that is released became sound."""
        return self.numbers.released_power
