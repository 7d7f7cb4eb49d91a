"""The numbers of a run of a bearing, made once after the motion of its ring."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from rolling.bearing.band_uncertainty import BandUncertainty
from rolling.bearing.linear_ring import linear_ring
from rolling.bearing.ring_record import PLACES
from rolling.bearing.static_load import angles_under_loads
from rolling.bearing_kind.bearing_doubts import JudgedBearing, doubts_of
from rolling.bearing_kind.bearing_sentences import sentences
from rolling.bearing_kind.housing_numbers import housing_numbers
from rolling.bearing_kind.line_numbers import envelope_band_numbers, envelope_lines, velocity_lines
from rolling.bearing_kind.maker_numbers import pulse_numbers, vibration_class
from rolling.bearing_kind.solved_bearing import SolvedBearing
from rolling.bearing_kind.standard_conditions import departures
from rolling.bearing_kind.velocities import rigid_velocities, velocities_below_bending
from rolling.marches import effort
from rolling.numbers.bearing_numbers import (
    AngleNumbers,
    BallLoads,
    BearingEffort,
    BearingNumbers,
    FaultlessNumbers,
    FilmNumbers,
    MarchedContact,
    MotionOfRing,
    RingNumbers,
    SpeedNumbers,
)
from rolling.numbers.doubt import Doubt


@dataclass(frozen=True)
class MarchFindings:
    """What the marches of the rough contacts say beside their tracks.

    doubts : tuple of Doubt. Doubts about the rough contacts.
    contacts : tuple of MarchedContact. Numbers of those that were marched.
    uncertainty : BandUncertainty. Parts of the ± of the bands that come from them.
    without_faults : FaultlessNumbers or None. The same bearing without its single faults.
    """

    doubts: tuple[Doubt, ...] = ()
    contacts: tuple[MarchedContact, ...] = ()
    uncertainty: BandUncertainty = field(default_factory=BandUncertainty)
    without_faults: FaultlessNumbers | None = None


def bearing_numbers(bearing: SolvedBearing, findings: MarchFindings) -> BearingNumbers:
    """Return the numbers of a bearing from the motion of its ring, and what its marches found.

    Processor times are not known yet.
    """
    scene = bearing.scene
    rigid = rigid_velocities(bearing, findings.uncertainty)
    below_bending = velocities_below_bending(bearing, findings.uncertainty)
    judged = JudgedBearing(bearing, rigid, below_bending, of_contacts=findings.doubts)
    doubts = tuple(doubts_of(judged))
    numbers = BearingNumbers(
        name=scene.name,
        title=scene.title,
        below_bending=below_bending,
        velocities=rigid,
        lines=velocity_lines(bearing),
        envelope_lines=envelope_lines(bearing),
        envelope_band=envelope_band_numbers(bearing),
        pulses=pulse_numbers(bearing),
        vibration_class=vibration_class(bearing, below_bending.radial, departures(scene)),
        without_faults=findings.without_faults,
        ring=RingNumbers(
            moving=bearing.moving,
            mass_kg=bearing.model.ring_mass_kg,
            resonances_hz=tuple(linear_ring(bearing.model).resonances_hz.tolist()),
            bending_hz=scene.ring_bending_hz,
            left_out_hz=scene.ring_holds_hz if scene.model.bending else None,
        ),
        motion=MotionOfRing(
            duration_s=bearing.record.duration_s,
            energy_error=bearing.record.energy_error,
            lost_contact_share=bearing.record.lost_contact_share,
        ),
        speeds=_speeds(bearing),
        loads=_loads(bearing),
        angles=_angles(bearing),
        housing=housing_numbers(bearing, radial=rigid.radial, doubts=doubts),
        films=_films(bearing),
        contacts=findings.contacts,
        effort=BearingEffort(march_cpu_s=None),
        departures=tuple(departures(scene)),
        doubts=doubts,
    )
    return replace(numbers, sentences=tuple(sentences(scene, numbers)))


def with_effort(numbers: BearingNumbers, parts_cpu_s: Mapping[str, float | None]) -> BearingNumbers:
    """Return numbers with the processor times [s] of the parts of the run."""
    own = BearingEffort(march_cpu_s=parts_cpu_s.get(effort.MARCH), parts_cpu_s=dict(parts_cpu_s))
    return replace(numbers, effort=own)


def _speeds(bearing: SolvedBearing) -> SpeedNumbers:
    """Return the turns and rates of a bearing."""
    kinematics = bearing.kinematics
    return SpeedNumbers(
        cage_hz=kinematics.cage_hz,
        ball_pass_outer_hz=kinematics.ball_pass_outer_hz,
        ball_pass_inner_hz=kinematics.ball_pass_inner_hz,
        ball_spin_hz=kinematics.ball_spin_hz,
        rolling_speed_m_s=kinematics.rolling_speed_m_s,
    )


def _loads(bearing: SolvedBearing) -> BallLoads:
    """Return the loads of the balls: their largest and least, and the mean at each angle."""
    loads = bearing.record.ball_load_n
    around = bearing.record.loads_around(PLACES).tolist()
    return BallLoads(
        largest_n=float(loads.max()),
        least_n=float(loads.min()),
        mean_n=float(loads.mean()),
        mean_at_angles_n=tuple(None if math.isnan(load) else load for load in around),
    )


def _films(bearing: SolvedBearing) -> tuple[FilmNumbers, ...]:
    """Return the films of oil on both raceways."""
    return tuple(
        FilmNumbers(
            raceway=ring,
            thickness_m=film.thickness_m,
            ratio=film.ratio if math.isfinite(film.ratio) else None,
            weight=film.weight,
        )
        for ring, film in bearing.scene.films.items()
    )


def _angles(bearing: SolvedBearing) -> AngleNumbers:
    """Return the free contact angle, and those under the loads."""
    least, largest = angles_under_loads(bearing.geometry, bearing.scene.loaded_ring)
    return AngleNumbers(
        free_deg=math.degrees(bearing.geometry.contact_angle),
        least_under_loads_deg=math.degrees(least),
        largest_under_loads_deg=math.degrees(largest),
    )
