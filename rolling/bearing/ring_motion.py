"""Motion in time of the ring that does not turn, on the nonlinear contacts of all balls.

The ring is rigid, or bends with two and three waves around it (`ring_bending`), and it is held in
its plane or free to tilt. Balls without mass serve up to a third of the frequency at
which a ball bounces between its raceways, sqrt((k_i + k_o) / m) / (2 pi), some 30 kHz in small
bearings at their loads. With mass, a ball moves along its contact line, and the part along that
line of its centrifugal force acts on it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import ceil, pi

import numpy as np

from acoustics import resampling
from acoustics.arrays import Array, short_repr
from rolling.bearing import _ring_kernels, limits
from rolling.bearing._ring_kernels import RingBodies, RingState, RingSums, TrackTables
from rolling.bearing.contact_lines import line_curvature
from rolling.bearing.linear_ring import linear_ring
from rolling.bearing.model import BearingModel
from rolling.bearing.static_load import StaticBalance
from rolling.bearing.tracks import BearingTracks, BodyTrack

FINER = 4  # points of a slow track for each given one, so that cubics between them are exact
MIN_POINTS = 4  # of a track, for a cubic
_ROUNDING = 1e-11  # of the contacts' energy
_LARGEST_RECORD = 2**22  # numbers of steps times columns at once


@dataclass(frozen=True)
class RingMotion:
    """Motion of the ring at n equally spaced times, and the balance of its energies."""

    __repr__ = short_repr

    time_s: Array  # (n,)
    displacement_m: Array  # (n, m) about the mean: x, y radial and z axial, bending, turns
    velocity_m_s: Array  # (n, m)
    acceleration_m_s2: Array  # (n, m)
    ball_load_n: Array  # (n, balls) of each ball on the ring
    ball_angle: Array  # (n,) [rad] of ball 0, from the middle of the load zone
    ring_force_n: Array  # (n, m) of balls and bending on the ring
    mean_displacement_m: Array  # (m,)
    rate_hz: int
    step_s: float
    run_in_s: float
    energy_error: float  # over the energy that moves: losses plus range of the contacts' energy
    lost_contact_share: float  # share of time in which a ball has no load, mean over the balls
    free_share: float  # share of time in which no ball has a load
    tilts: bool = False  # whether the last two displacements are turns of the ring


def move_ring(
    bearing: BearingModel,
    tracks: BearingTracks,
    duration_s: float,
    rate_hz: int = 48000,
    per_period: int = limits.PER_PERIOD,
    progress: Callable[[float], object] | None = None,
) -> RingMotion:
    """Move the ring of a bearing over the tracks of its bodies.

    Parameters
    ----------
    bearing : BearingModel
    tracks : BearingTracks
        A track for each ball on each raceway, and one for each raceway.
    duration_s : float, s
        Duration of the record, after a run-in from rest in which the tracks grow.
    rate_hz : int, Hz
        Rate of the record. Steps in time are finer, and a filter leads from one to the other.
    per_period : int
        Minimum number of steps in a period of the fastest resonance.
    progress : function, optional
        It is called with the share of run-in and record, from 0 to 1, that was added since its last
        call. The shares may add up to a little more than 1.

    Returns
    -------
    RingMotion

    Raises
    ------
    ValueError
        If tracks are missing, the loads have no balance, or `limits.broken_limits` has one.
    """
    if len(tracks.balls_on_inner) != bearing.geometry.balls:
        raise ValueError(
            f"tracks: got {len(tracks.balls_on_inner)} balls, allowed: {bearing.geometry.balls}"
        )
    for limit in limits.broken_limits(bearing):
        raise ValueError(f"{limit.key}: {limit.text}")
    balances = bearing.balances()
    samples = max(1, round(duration_s * rate_hz))
    factor = _steps_per_sample(bearing, balances, tracks, rate_hz, per_period)
    step = 1 / (rate_hz * factor)
    ring = linear_ring(bearing)
    run_in = ceil(limits.run_in_s(ring) * rate_hz) / rate_hz
    bodies = _bodies(bearing, balances, ring.spread, step, run_in)
    tables = _tables(bearing, tracks, step)
    run = _Run(bodies=bodies, tables=tables, balls=bearing.geometry.balls)
    state = _start(bearing, bodies, run.tables)
    record = _record(run, state, factor, round(run_in * rate_hz), samples, progress)
    time = np.arange(samples) / rate_hz
    count = len(bodies.masses)
    place, velocity, force, loads = np.split(record, [count, 2 * count, 3 * count], axis=1)
    mean = place.mean(axis=0)
    return RingMotion(
        time_s=time,
        displacement_m=place - mean,
        velocity_m_s=velocity,
        acceleration_m_s2=(bodies.load + force) / bodies.masses,
        ball_load_n=loads,
        ball_angle=2 * pi * bearing.kinematics.cage_hz * time,
        ring_force_n=force,
        mean_displacement_m=mean,
        rate_hz=rate_hz,
        step_s=step,
        run_in_s=run_in,
        energy_error=run.energy_error(),
        lost_contact_share=float(run.sums.apart[0] / run.sums.steps[0]) / bearing.geometry.balls,
        free_share=float(run.sums.free[0] / run.sums.steps[0]),
        tilts=bearing.tilts,
    )


@dataclass
class _Run:
    """Steps of a motion, and their energies."""

    bodies: RingBodies
    tables: TrackTables
    balls: int

    @property
    def columns(self) -> int:
        """Numbers of a step: displacement, velocity and force of the ring, and loads of balls."""
        return 3 * len(self.bodies.masses) + self.balls

    def __post_init__(self) -> None:
        self.begin_balance()

    def begin_balance(self) -> None:
        """Count energies from the next step on."""
        self.sums = RingSums(*np.zeros((len(RingSums._fields), 1)))

    def advance(self, state: RingState, first: int, steps: int) -> Array:
        """Take steps, of which the first has its middle at `first` steps; return their rows."""
        record = np.empty((steps, self.columns))
        _ring_kernels.take_steps(
            first * self.bodies.step,
            self.bodies,
            self.tables,
            state,
            self.sums,
            record,
        )
        return record

    def energy_error(self) -> float:
        """Return what the balance of energies lacks, over the energy that moves."""
        sums = self.sums
        change = sums.last_energy[0] - sums.first_energy[0]
        missing = change + sums.loss[0] - sums.load_work[0] - sums.track_work[0]
        moved = abs(sums.loss[0]) + sums.highest[0] - sums.lowest[0]
        if moved <= _ROUNDING * sums.highest[0]:  # nothing moves
            return 0.0
        return float(abs(missing) / moved)


def _record(
    run: _Run,
    state: RingState,
    factor: int,
    run_in: int,
    samples: int,
    progress: Callable[[float], object] | None,
) -> Array:
    """Return the rows (samples, columns) of a record after a run-in of some samples.

    A sample has `factor` steps, and a filter leads from one to the other.
    """
    columns = run.columns
    longest = max(1, _LARGEST_RECORD // (factor * columns))
    reach = resampling.DECIMATOR_REACH
    decimator = resampling.Decimator(factor)

    def advance(first: int, count: int) -> Array:
        """Take the steps of some samples, and return their rows."""
        rows = run.advance(state, first * factor, count * factor)
        if progress is not None:
            progress(count / (run_in + samples))
        return rows

    for first, count in _parts(-run_in, run_in - 2 * reach, longest):
        advance(first, count)
    run.begin_balance()
    record = np.empty((samples, columns))
    done = -2 * reach
    for first, count in _parts(-2 * reach, samples + 3 * reach, longest):
        rows = decimator.add(advance(first, count))
        kept = rows[max(-done, 0) :]
        record[max(done, 0) : max(done, 0) + len(kept)] = kept
        done += len(rows)
    return record


def _parts(first: int, samples: int, longest: int) -> list[tuple[int, int]]:
    """Return the first sample and the number of samples of each part of a stretch."""
    parts = []
    done = 0
    while done < samples:
        count = min(longest, samples - done)
        parts.append((first + done, count))
        done += count
    return parts


def _steps_per_sample(
    bearing: BearingModel,
    balances: Sequence[StaticBalance],
    tracks: BearingTracks,
    rate_hz: int,
    per_period: int,
) -> int:
    """Return the number of steps per sample that resolve resonances and tracks."""
    points_hz = 0.0
    for track, turns_hz in _turning_tracks(bearing, tracks):
        points_hz = max(points_hz, track.points * turns_hz)
    needed = limits.steps_hz(bearing, balances, points_hz, per_period)
    return ceil(max(needed, 2 * rate_hz) / rate_hz)


def _turning_tracks(bearing: BearingModel, tracks: BearingTracks) -> list[tuple[BodyTrack, float]]:
    """Return all tracks with the turns per second of their bodies under a contact."""
    speeds = bearing.kinematics
    pairs = [
        (tracks.inner, abs(speeds.inner_hz - speeds.cage_hz)),
        (tracks.outer, abs(speeds.outer_hz - speeds.cage_hz)),
    ]
    for track in (*tracks.balls_on_inner, *tracks.balls_on_outer):
        pairs.append((track, speeds.ball_spin_hz))
    return pairs


def _tables(bearing: BearingModel, tracks: BearingTracks, step: float) -> TrackTables:
    """Return the tracks at all loads of all of them, at points that suit the steps."""
    pairs = _turning_tracks(bearing, tracks)
    loads = pairs[0][0].loads_n
    for track, _ in pairs:
        loads = np.union1d(loads, track.loads_n)

    def table(track: BodyTrack, points: int) -> Array:
        """Return a track at the loads, (points, loads)."""
        return np.ascontiguousarray(track.resampled(points).at_loads(loads).T)

    def points_of(given: int, turns_hz: float) -> int:
        """Return the number of points of a turn: not more than steps, nor many times the given."""
        if given <= MIN_POINTS:  # a smooth track
            return MIN_POINTS
        return max(MIN_POINTS, min(FINER * given, ceil(1 / (turns_hz * step))))

    ball_tracks = (*tracks.balls_on_inner, *tracks.balls_on_outer)
    ball_points = points_of(max(t.points for t in ball_tracks), bearing.kinematics.ball_spin_hz)
    return TrackTables(
        nodes=np.concatenate(([0.0], loads ** (2 / 3))),
        inner=table(tracks.inner, points_of(tracks.inner.points, pairs[0][1])),
        outer=table(tracks.outer, points_of(tracks.outer.points, pairs[1][1])),
        balls_on_inner=np.stack([table(track, ball_points) for track in tracks.balls_on_inner]),
        balls_on_outer=np.stack([table(track, ball_points) for track in tracks.balls_on_outer]),
    )


def _bodies(
    bearing: BearingModel,
    balances: Sequence[StaticBalance],
    spread: Array,
    step: float,
    run_in: float,
) -> RingBodies:
    """Return what the time steps read of a bearing."""
    geometry = bearing.geometry
    speeds = bearing.kinematics
    direction = 1.0 if speeds.moving == "inner" else -1.0
    inner = geometry.inner.stiffness_n_m15 ** (-2 / 3)
    outer = geometry.outer.stiffness_n_m15 ** (-2 / 3)
    bodies = RingBodies(
        step=step,
        masses=bearing.masses,
        springs=bearing.springs,
        ball_mass=0.0,
        load=bearing.load,
        centrifugal=0.0,
        direction=direction,
        tilt_radius=geometry.groove_circle_m(speeds.moving) if bearing.tilts else 0.0,
        orders=np.array(bearing.orders, dtype=float),
        cosine=float(np.cos(geometry.contact_angle)),
        sine=float(np.sin(geometry.contact_angle)),
        curvature=line_curvature(geometry, bearing.gap_m, bearing.angle),
        along=np.ones(1),
        beside=np.zeros(1),
        gaps=np.array([bearing.gap_m]),
        compliances=np.array([inner + outer]),
        spread=spread,
        ball_time=0.0,
        cage_hz=speeds.cage_hz,
        inner_hz=speeds.inner_hz,
        outer_hz=speeds.outer_hz,
        spin_hz=speeds.ball_spin_hz,
        fade_start=-run_in,
        fade_end=-run_in / 2,
    )
    if not bearing.ball_inertia:
        return bodies
    along = np.array([0.0, 1.0]) if speeds.moving == "outer" else np.array([1.0, 0.0])
    bounce = 2 * pi * limits.bounce_hz(bearing, balances)
    return bodies._replace(
        ball_mass=bearing.ball_mass_kg,
        centrifugal=bearing.centrifugal_n,
        along=along,
        beside=np.array([-1.0, 1.0]),
        gaps=np.array([bearing.gap_m, 0.0]),
        compliances=np.array([inner, outer]),
        ball_time=bearing.contact_loss_factor / bounce + bearing.film_time_s,
    )


def _start(bearing: BearingModel, bodies: RingBodies, tables: TrackTables) -> RingState:
    """Return the ring at rest in its static balance at the start of the run-in."""
    count = bearing.geometry.balls
    cage_angle = 2 * pi * bearing.kinematics.cage_hz * bodies.fade_start
    balance = bearing.balance(cage_angle)
    ring = balance.displacements[bearing.columns]
    balls = np.zeros(count)
    if bodies.ball_mass > 0:
        lines = bearing.lines(bearing.geometry.ball_angles(cage_angle))
        elongation = lines.at(balance.displacements).approach_m + bearing.gap_m
        on_outer = bodies.compliances[1] * balance.ball_load_n ** (2 / 3)
        balls = on_outer - bodies.along[1] * elongation
    contacts = len(bodies.along)
    nodes = len(tables.nodes)
    return RingState(
        ring=ring,
        ring_velocity=np.zeros(len(ring)),
        balls=balls,
        ball_velocity=np.zeros(count),
        last_ring=ring.copy(),
        last_balls=balls.copy(),
        ways=np.zeros((count, len(ring))),
        last_ways=np.zeros((count, len(ring))),
        laws=np.zeros((count, contacts, nodes)),
        last_laws=np.zeros((count, contacts, nodes)),
    )
