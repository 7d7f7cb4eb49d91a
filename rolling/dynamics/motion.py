"""Motion of ball and plate in time over a force law, with the energy balance of the record."""

from collections.abc import Callable
from dataclasses import dataclass
from math import ceil
from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array, short_repr
from rolling.dynamics import _mode_kernels, _motion_kernels
from rolling.dynamics._mode_kernels import StepBodies
from rolling.dynamics._motion_kernels import LawTable, State
from rolling.dynamics.bodies import Chain
from rolling.dynamics.force_law import ForceLaw

PER_PERIOD = 40  # minimum number of steps in a period of the resonance
DECAYS = 14  # decay times in which a transient falls to 1e-6
FADE_DECAYS = 7  # decay times in which it falls to 1e-3
MAX_LAPS = 400  # laps of a run-in that does not settle; more if they are short, up to MAX_STEPS
MAX_STEPS = 2_000_000  # of a run-in, as many as 28 decay times of a quality of 5,600 take
MODAL_HZ = 90e3  # minimum rate of the steps of a plate with edges, three in a period of its modes
SEAM = 1e-3  # change of the force from lap to lap over its rms, with which a lap loops
Path = Callable[[Array], Array]  # contact points (n, 2) [m] at times [s]


@dataclass(frozen=True)
class TabulatedTravel:
    """Position of the ball along the track as a function of time, by monotone cubics."""

    time_s: Array  # (m,) ascending from 0, at least two
    position_m: Array  # (m,) not descending

    def at(self, time_s: Array) -> Array:
        """Return the positions [m] at times [s]."""
        from scipy.interpolate import PchipInterpolator  # slow to import, for motions only

        return np.asarray(PchipInterpolator(self.time_s, self.position_m)(time_s), dtype=float)

    @property
    def fastest_m_s(self) -> float:
        """Maximum of the mean speeds [m/s] between the times."""
        return float(np.max(np.diff(self.position_m) / np.diff(self.time_s)))


@dataclass(frozen=True)
class Stepping:
    """Choices of the time steps and of the run-in."""

    per_period: int = PER_PERIOD  # minimum number of steps in a period of the resonance
    time_step_s: float | None = None  # instead of the step from resonance and track
    # Approach and velocity at the start, without a run-in; modes rest under the force of the start.
    start: tuple[float, float] | None = None
    settled: float = 1e-7  # change of the force in all laps to come, over the load, when settled


@dataclass(frozen=True)
class BodyMotion:
    """Motion of ball and plate at the middles of n uniform time steps."""

    __repr__ = short_repr

    time_s: Array
    position_m: Array
    force_n: Array  # mean contact force of each step
    displacement_m: Array  # z of the ball, towards the plate
    velocity_m_s: Array  # of the ball
    plate_m: Array  # w of the plate at the contact
    time_step_s: float
    energy_error: float  # over the energy that moves: loss to the plate plus range of the energy U
    flight_share: float  # share of time without contact
    impacts: int  # returns to contact
    outside_share: float  # share of time with a force outside the marched loads
    laps: int  # of the run-in
    settled: bool  # whether the motion repeats from lap to lap, so that whole laps loop
    transient_s: float  # in which the ringing of the start falls to 1e-3; 0 after a run-in

    @property
    def approach_m(self) -> Array:
        """Approach z - w [m]."""
        return self.displacement_m - self.plate_m


def move(
    law: ForceLaw,
    chain: Chain,
    load_n: float,
    speed: float | TabulatedTravel,
    duration_s: float | None = None,
    stepping: Stepping | None = None,
    path: Path | None = None,
) -> BodyMotion:
    """Move a ball at a speed [m/s] over a force law: M z.. = W - F(x, z - w), w. = Y (F - W).

    The plate has modes instead of the mobility Y if the chain has. The time step is the shorter of
    a fraction of the resonance's period and the time from position to position. On a closed track
    at constant speed the ball runs in until two laps agree, and a lap is a whole number of time
    steps; modes start as the linear chain repeats them. At changing speed, and on a path, the ball
    runs in at its first speed. On an open track it starts at rest in equilibrium. The default
    duration is that of a lap.
    """
    choices = stepping or Stepping()
    run = _MotionOfSteps(law, chain, load_n, speed, duration_s, choices, path)
    if choices.start is not None:
        approach, velocity = choices.start
        force = float(law.force(run.places(1)[0], approach)) - load_n
        return run.record_from(at_rest(run.bodies, run.points(1), approach, velocity, force))
    if law.period_m is None:
        return run.record_from(run.equilibrium(), transient=FADE_DECAYS * run.decay_s)
    if isinstance(speed, TabulatedTravel):
        return run.record_from(run.state_after_run_in(speed))
    if path is not None:
        return run.record_from(
            run.state_after_run_in(TabulatedTravel(np.array([0.0, 1.0]), np.array([0.0, speed])))
        )
    return run.run_in_and_record()


def longest_step_s(
    law: ForceLaw, chain: Chain, fastest_m_s: float, per_period: int = PER_PERIOD
) -> float:
    """Return the longest time step [s] that resolves resonance, track and modes at a speed."""
    longest = 1 / (per_period * chain.resonance_hz)
    if fastest_m_s > 0:
        longest = min(longest, law.spacing_m / fastest_m_s)
    if chain.modes is not None:
        longest = min(longest, 1 / MODAL_HZ)
    return longest


class Energies(NamedTuple):
    """Energies [J] of a stretch of steps."""

    change: float  # of kinetic, contact and modal energy
    load_work: float
    track_work: float
    plate_loss: float
    contact_loss: float
    contact_range: float  # of the contact's energy, from its minimum to its maximum


class Steps(NamedTuple):
    """Steps taken: their positions, the rows of the kernel, the last state, and energies.

    A row has the force [N], the approach [m], the velocity of the ball [m/s] and the displacement
    of the plate [m] at the middle of a step.
    """

    places: Array
    record: Array
    end: State
    energies: Energies


def advance(
    table: LawTable, bodies: StepBodies, load_n: float, state: State, places: Array, points: Array
) -> Steps:
    """Advance a state by one step to each position, and return the record and the last state.

    `Chain.steps` gives the bodies for a time step. The next stretch goes on from the last state,
    over the same or another force law. The contact points (n, 2) [m] of a plate with edges are one
    that is fixed, or one for each step.
    """
    record = np.empty((len(places), 4))
    state = state._replace(modes=state.modes.copy())
    end, energies = _motion_kernels.advance(state, load_n, bodies, places, points, table, record)
    last = State(approach=end[0], velocity=end[1], plate=end[2], modes=state.modes)
    return Steps(places=places, record=record, end=last, energies=Energies(*energies))


def at_rest(
    bodies: StepBodies, point_m: Array, approach_m: float, velocity_m_s: float, force_n: float
) -> State:
    """Return a state with a plate with edges at rest under a force [N] beyond the load.

    `point_m` (1, 2) is the contact point.
    """
    shape = np.empty(len(bodies.reach))
    if len(shape):
        _mode_kernels.set_shapes(point_m[0], bodies, shape)
    modes = np.stack((force_n * shape, np.zeros_like(shape)))
    plate = float(force_n * shape @ shape)
    return State(approach=approach_m, velocity=velocity_m_s, plate=plate, modes=modes)


def on_level(state: State) -> State:
    """Return a state with the displacement of a plate without modes counted from there."""
    has_modes = state.modes.shape[1] > 0
    if has_modes:
        return state
    return state._replace(plate=0.0)


def run_in(law: ForceLaw, bodies: StepBodies, load_n: float, places: Array, points: Array) -> State:
    """Return the state after a way over places [m], from the equilibrium at the first."""
    state = at_rest(bodies, points, float(law.approach(places[0], load_n)), 0.0, 0.0)
    return on_level(advance(law.table, bodies, load_n, state, places, points).end)


@dataclass
class _MotionOfSteps:
    """A motion with its time step, its positions and its run-in."""

    law: ForceLaw
    chain: Chain
    load: float
    speed: float | TabulatedTravel
    duration: float | None
    choices: Stepping
    path: Path | None

    def __post_init__(self) -> None:
        law = self.law
        chain = self.chain
        speed = self.speed
        choices = self.choices
        self.first = float(law.position_m[0])
        fastest = speed.fastest_m_s if isinstance(speed, TabulatedTravel) else speed
        self.decay_s = chain.decay_s
        self.slow_decay_s = 0.0
        modes = chain.modes
        if modes is not None:
            self.decay_s = max(self.decay_s, modes.decay_s(2 * np.pi * chain.resonance_hz))
            slowest = modes.lowest_angular_frequency(chain.mass_kg)
            self.slow_decay_s = max(modes.decay_s(slowest), chain.own_decay_s)
        longest = choices.time_step_s or longest_step_s(law, chain, fastest, choices.per_period)
        self.lap_s: float | None = None
        if law.period_m and fastest > 0:
            self.lap_s = law.period_m / fastest
        duration = self.duration or self.lap_s
        if not duration:
            raise ValueError("a motion that is no lap at constant speed needs a duration")
        # A lap at constant speed is a whole number of steps, so that laps can be compared.
        period = duration
        if self.lap_s and not isinstance(speed, TabulatedTravel):
            period = self.lap_s
        self.lap_steps = ceil(period / longest * (1 - 1e-12))
        self.step = period / self.lap_steps
        self.bodies = chain.steps(self.step)
        self.steps = max(1, round(duration / self.step))

    def places(self, steps: int) -> Array:
        """Return the positions [m] at the middles of the steps from the start."""
        middle = np.asarray((np.arange(steps) + 0.5) * self.step)
        if isinstance(self.speed, TabulatedTravel):
            return self.speed.at(np.minimum(middle, self.speed.time_s[-1]))
        return np.asarray(self.first + self.speed * middle)

    def advance(self, state: State, places: Array) -> Steps:
        """Advance by a step to each of these positions at the first contact point."""
        return advance(self.law.table, self.bodies, self.load, state, places, self.chain.point)

    def equilibrium(self) -> State:
        """Return the static equilibrium at the first position."""
        approach = float(self.law.approach(self.places(1)[0], self.load))
        return at_rest(self.bodies, self.chain.point, approach, 0.0, 0.0)

    def points(self, steps: int) -> Array:
        """Return the contact points [m] at the middles of the steps, or the only one."""
        if self.path is None:
            return self.chain.point
        return self.path(np.asarray((np.arange(steps) + 0.5) * self.step))

    def steady_state(self) -> State:
        """Return the state at the start of a lap as the linear chain repeats it."""
        rest = self.equilibrium()
        if self.chain.modes is None or self.lap_s is None:
            return rest
        approach = self.law.approach(self.law.position_m, self.load)
        lines = 2 / len(approach) * np.fft.rfft(approach)[1 : (len(approach) + 1) // 2]
        frequency = np.arange(1, len(lines) + 1) / self.lap_s
        resolved = frequency < 0.5 / self.step
        frequency = frequency[resolved]
        force = self.chain.force(frequency, -lines[resolved])
        shape = at_rest(self.bodies, self.chain.point, 0.0, 0.0, 1.0).modes[0]
        modes = shape * self.chain.modes.steady_state(frequency, force)
        start_force = self.load + float(np.sum(force.real))
        velocity = np.sum((1j * force / (2 * np.pi * frequency * self.chain.mass_kg)).real)
        return State(
            approach=float(self.law.approach(self.first, max(start_force, 0.0))),
            velocity=float(velocity),
            plate=float(shape @ modes[0]),
            modes=modes,
        )

    def state_after_run_in(self, travel: TabulatedTravel) -> State:
        """Return the state at the start of a travel after a run-in at its first speed."""
        begin, after = travel.at(np.array([0.0, min(self.step, travel.time_s[-1])]))
        speed = (after - begin) / self.step
        if speed <= 0:
            return self.equilibrium()
        lap_s = (self.law.period_m or 0.0) / speed
        steps = ceil(min(DECAYS * self.decay_s, lap_s) / self.step)
        places = begin - speed * self.step * (np.arange(steps, 0, -1) - 0.5)
        return run_in(self.law, self.bodies, self.load, places, self.chain.point)

    def run_in_and_record(self) -> BodyMotion:
        """Run in lap by lap until the force repeats, and return the record that then follows."""
        places = self.places(self.lap_steps)
        lap_s = self.lap_steps * self.step
        rings = 2 * DECAYS * self.decay_s / lap_s
        limit = max(MAX_LAPS, MAX_STEPS // self.lap_steps)
        most_with_impacts = 1
        if np.isfinite(rings):
            most_with_impacts = ceil(min(2 + rings, limit))
        # Impacts need not repeat; without them slow modes may take their time.
        slow_laps = ceil(min(FADE_DECAYS * self.slow_decay_s / lap_s, limit))
        most_without = max(most_with_impacts, slow_laps)
        # The laps to come change by a geometric series of the last change.
        allowed = self.choices.settled * self.load * -np.expm1(-lap_s / self.decay_s)
        lap = self.advance(self.steady_state(), places)
        laps = 0
        difference = np.inf
        while difference > allowed:
            has_impacts = np.any(lap.record[:, 0] == 0)
            if laps >= (most_with_impacts if has_impacts else most_without):
                break
            laps += 1
            before = lap
            lap = self.advance(on_level(before.end), places)
            difference = float(np.max(np.abs(lap.record[:, 0] - before.record[:, 0])))
            if len(self.bodies.reach):  # low modes decay over many laps, and move little
                allowed = max(allowed, SEAM * float(np.std(lap.record[:, 0])))
            if not lap.record[:, 0].any():  # a flight longer than a lap repeats nothing
                difference = np.inf
        if self.steps != self.lap_steps:
            return self.record_from(on_level(before.end), laps, difference <= allowed)
        return self.motion_of(lap, laps, difference <= allowed)

    def record_from(
        self, state: State, laps: int = 0, settled: bool = False, transient: float = 0.0
    ) -> BodyMotion:
        """Return the motion of the record from a state, after laps of a run-in."""
        places = self.places(self.steps)
        points = self.points(self.steps)
        end = float(self.law.position_m[-1] + 1e-6 * self.law.spacing_m)
        if self.law.period_m is None and places.max() > end:
            raise ValueError(f"the ball leaves the track, which ends at {end:.6g} m")
        steps = advance(self.law.table, self.bodies, self.load, state, places, points)
        return self.motion_of(steps, laps, settled, transient)

    def motion_of(self, lap: Steps, laps: int, settled: bool, transient: float = 0.0) -> BodyMotion:
        """Return the motion of steps taken."""
        force, approach, velocity, plate = np.ascontiguousarray(lap.record.T)
        energies = lap.energies
        loss = energies.plate_loss + energies.contact_loss
        energy_error = 0.0
        if energies.contact_range:
            missing = abs(energies.change - energies.load_work - energies.track_work + loss)
            energy_error = missing / (loss + energies.contact_range)
        is_free = force == 0
        return BodyMotion(
            time_s=np.asarray((np.arange(len(force)) + 0.5) * self.step),
            position_m=lap.places,
            force_n=force,
            displacement_m=approach + plate,
            velocity_m_s=velocity,
            plate_m=plate,
            time_step_s=self.step,
            energy_error=energy_error,
            flight_share=float(np.mean(is_free)),
            impacts=int(np.sum(is_free[:-1] & ~is_free[1:])),
            outside_share=self.law.outside(force),
            laps=laps,
            settled=settled,
            transient_s=transient,
        )
