"""Compiled time steps of the ring that moves on the balls of a bearing, and of balls with mass.

A contact bears the force Q = s^(3/2) at the approach f(s), a broken line over s = Q^(2/3): the
compliance K^(-2/3) times s, plus the tracks, which are straight between the nodes of s and constant
beyond them. Its energy is the integral of Q df, so each piece of a line gives 2/5 of its slope
times the rise of s^(5/2).

Contact c of a ball whose contact line is longer by e, and which is displaced by b outwards along
it, has the approach `along[c]` e + `beside[c]` b - `gaps[c]`. A ball without mass has one contact,
both raceways in series, and no b. A ball with mass has one contact with the inner raceway and one
with the outer. The elongation e and the direction n of a line follow from the displacement u of the
ring, and n is the derivative of e by u (`contact_lines`). At a fixed angle e = n . u.

A step drifts to its middle, meets the forces there, and drifts on (leapfrog):

    u += h/2 v,   M (v1 - v0) / h = load - sum Q along n - C v,   u += h/2 v

The viscous matrix is C = S (sum k n n^T + Q c t t^T) S with the stiffness k of each ball, its load
Q, and the turn c of its line for a way along t across it, which is 0 at a fixed angle. S is made so
that the mean of C gives each resonance its loss factor. A ball with mass has a viscous force
against its motion beside the place to which the ring would lead it without mass.
"""

# mypy: disable-error-code="no-untyped-def"
from math import cos, floor, pi, sin, sqrt
from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array
from rolling.contact.compiling import inlined, njit

# Minimum slope of the approach over s, as a share of that of the smooth contact, so that the force
# rises with the approach whatever tracks add up to.
MIN_SLOPE = 0.2


class TrackTables(NamedTuple):
    """Tracks of all bodies at the same loads, as the kernels read them.

    A row is a place of the turn, a column a load. `nodes` are the values of s of the loads, after a
    zero.
    """

    nodes: Array  # (1 + k,)
    inner: Array  # (places, k)
    outer: Array
    balls_on_inner: Array  # (balls, places, k)
    balls_on_outer: Array


class RingBodies(NamedTuple):
    """Ring, balls and contacts as a time step moves them."""

    step: float  # [s]
    ring_mass: float  # [kg]
    ball_mass: float  # [kg]
    load: Array  # (3,) [N] on the ring
    centrifugal: float  # [N] on a ball, along its contact line
    direction: float  # 1 if displacements press balls outwards, -1 if inwards
    cosine: float  # of the contact angle without displacement
    sine: float
    curvature: float  # [1/m] of lines that turn (`contact_lines`), 0 at a fixed angle
    along: Array  # (contacts,)
    beside: Array  # (contacts,)
    gaps: Array  # (contacts,) [m]
    compliances: Array  # (contacts,) [m/N^(2/3)]
    spread: Array  # S, (3, 3) [s^(1/2)]
    ball_time: float  # [s] viscosity over stiffness of a ball with mass
    cage_hz: float
    inner_hz: float
    outer_hz: float
    spin_hz: float
    fade_start: float  # [s] at which the tracks begin to grow
    fade_end: float  # [s] from which on they are whole


class RingState(NamedTuple):
    """State between two steps, and the middle of the last step; kernels change the arrays."""

    ring: Array  # (3,) [m]
    ring_velocity: Array  # (3,) [m/s]
    balls: Array  # (balls,) [m] outwards along the contact lines
    ball_velocity: Array  # (balls,) [m/s]
    last_ring: Array  # (3,) [m]
    last_balls: Array  # (balls,) [m]
    around: Array  # (balls, 2) radial directions in which the ring presses the balls
    last_around: Array
    laws: Array  # (balls, contacts, 1 + k) approach [m] at the nodes
    last_laws: Array


class RingSums(NamedTuple):
    """Energies [J] and counts of the steps so far, each an array (1,) that kernels change."""

    steps: Array
    first_energy: Array
    last_energy: Array
    contact_energy: Array  # of the last step
    load_work: Array
    track_work: Array
    loss: Array
    lowest: Array  # contact energy
    highest: Array
    apart: Array  # balls without a load on the ring, summed over steps
    free: Array  # steps in which no ball has a load on the ring


@inlined()
def add_track(turns, share, track, law):
    """Add the track at a place [turns] to the approach at the nodes, by cubics through points."""
    count = track.shape[0]
    t = (turns - floor(turns)) * count
    i = min(int(t), count - 1)
    t -= i
    before = i - 1 if i > 0 else count - 1
    after = i + 1 if i + 1 < count else 0
    beyond = after + 1 if after + 1 < count else 0
    w0 = 0.5 * share * t * (t * (2.0 - t) - 1.0)
    w1 = 0.5 * share * (t * t * (3.0 * t - 5.0) + 2.0)
    w2 = 0.5 * share * t * (t * (4.0 - 3.0 * t) + 1.0)
    w3 = 0.5 * share * t * t * (t - 1.0)
    for k in range(track.shape[1]):
        value = w0 * track[before, k] + w1 * track[i, k]
        law[1 + k] += value + w2 * track[after, k] + w3 * track[beyond, k]


@inlined()
def close_law(compliance, nodes, law):
    """Add the smooth contact to the tracks at the nodes, and keep the approach rising."""
    law[0] = law[1]
    for k in range(1, nodes.shape[0]):
        law[k] += compliance * nodes[k]
        least = law[k - 1] + MIN_SLOPE * compliance * (nodes[k] - nodes[k - 1])
        law[k] = max(law[k], least)


@inlined()
def contact_at(approach, compliance, nodes, law):
    """Return force [N], stiffness [N/m] and energy [J] of a contact at an approach [m]."""
    if approach <= law[0]:
        return 0.0, 0.0, 0.0
    last = nodes.shape[0] - 1
    energy = 0.0
    p = 0
    low = 0.0  # s^(5/2) at node p
    slope = compliance
    while p < last:
        slope = (law[p + 1] - law[p]) / (nodes[p + 1] - nodes[p])
        if approach < law[p + 1]:
            break
        high = nodes[p + 1] * nodes[p + 1] * sqrt(nodes[p + 1])
        energy += 0.4 * slope * (high - low)
        low = high
        slope = compliance
        p += 1
    s = nodes[p] + (approach - law[p]) / slope
    root = sqrt(s)
    energy += 0.4 * slope * (s * s * root - low)
    return s * root, 1.5 * root / slope, energy


@inlined()
def set_laws(time, share, bodies, tables, around, laws):
    """Set the places of all balls, and the approaches of their contacts at the nodes."""
    count = around.shape[0]
    outer_contact = laws.shape[1] - 1  # the only one of a ball without mass
    spin = bodies.spin_hz * time
    for j in range(count):
        cage = bodies.cage_hz * time + j / count
        around[j, 0] = bodies.direction * cos(2.0 * pi * cage)
        around[j, 1] = bodies.direction * sin(2.0 * pi * cage)
        laws[j] = 0.0
        add_track(cage - bodies.inner_hz * time, share, tables.inner, laws[j, 0])
        add_track(spin, share, tables.balls_on_inner[j], laws[j, 0])
        add_track(cage - bodies.outer_hz * time, share, tables.outer, laws[j, outer_contact])
        add_track(spin + 0.5, share, tables.balls_on_outer[j], laws[j, outer_contact])
        for c in range(laws.shape[1]):
            close_law(bodies.compliances[c], tables.nodes, laws[j, c])


@inlined()
def line_at(around, ring, bodies):
    """Return the elongation [m] of a contact line, its direction, and its turn across it [1/m].

    The direction is its part along `around` and its part along the axis (`contact_lines`).
    """
    radial = around[0] * ring[0] + around[1] * ring[1]
    along = bodies.cosine * radial + bodies.sine * ring[2]
    if bodies.curvature == 0.0:
        return along, bodies.cosine, bodies.sine, 0.0
    across = bodies.cosine * ring[2] - bodies.sine * radial
    stretched = 1.0 + bodies.curvature * along
    turned = bodies.curvature * across
    length = sqrt(stretched * stretched + turned * turned)
    bent = bodies.curvature * (along * along + across * across)
    elongation = (2.0 * along + bent) / (1.0 + length)
    outwards = (stretched * bodies.cosine - turned * bodies.sine) / length
    axial = (stretched * bodies.sine + turned * bodies.cosine) / length
    return elongation, outwards, axial, bodies.curvature / length


@inlined()
def approach_of(elongation, ball, c, bodies):
    """Return the approach [m] of contact c of a ball."""
    return bodies.along[c] * elongation + bodies.beside[c] * ball - bodies.gaps[c]


@inlined()
def energy_of(ring, balls, around, laws, bodies, tables):
    """Return the energy [J] of all contacts."""
    total = 0.0
    for j in range(around.shape[0]):
        elongation, _, _, _ = line_at(around[j], ring, bodies)
        for c in range(laws.shape[1]):
            approach = approach_of(elongation, balls[j], c, bodies)
            total += contact_at(approach, bodies.compliances[c], tables.nodes, laws[j, c])[2]
    return total


@inlined()
def share_at(time, bodies):
    """Return the share of the tracks and of the centrifugal force at a time of the run-in."""
    if time >= bodies.fade_end:
        return 1.0
    if time <= bodies.fade_start:
        return 0.0
    past = (time - bodies.fade_start) / (bodies.fade_end - bodies.fade_start)
    return sin(0.5 * pi * past) ** 2


@inlined()
def drift(time, state):
    """Move ring and balls at their velocities for a time [s]."""
    for x in range(3):
        state.ring[x] += time * state.ring_velocity[x]
    for j in range(state.balls.shape[0]):
        state.balls[j] += time * state.ball_velocity[j]


@inlined()
def press_ball(j, elongation, bodies, tables, state):
    """Return what the contacts of a ball do at an elongation of its line.

    These are its energy [J], its load on the ring [N], the force on itself outwards [N], the
    stiffness [N/m] of its contacts in series, the stiffness that holds it along its contact line,
    and the force on it per displacement of the ring along that line, with its sign.
    """
    energy = 0.0
    load = 0.0
    pull = 0.0
    compliance = 0.0
    parted = False
    held = 0.0
    coupling = 0.0
    for c in range(bodies.along.shape[0]):
        approach = approach_of(elongation, state.balls[j], c, bodies)
        force, stiffness, stored = contact_at(
            approach, bodies.compliances[c], tables.nodes, state.laws[j, c]
        )
        energy += stored
        load += bodies.along[c] * force
        pull -= bodies.beside[c] * force
        held += bodies.beside[c] * bodies.beside[c] * stiffness
        coupling += bodies.beside[c] * bodies.along[c] * stiffness
        if stiffness > 0.0:
            compliance += 1.0 / stiffness
        else:
            parted = True
    series = 0.0 if parted else 1.0 / compliance
    return energy, load, pull, series, held, coupling


@inlined()
def add_stiffness(stiffness, way, tangent):
    """Add k n n^T of a direction n to the stiffness of all balls."""
    for x in range(3):
        for y in range(3):
            tangent[x, y] += stiffness * way[x] * way[y]


@inlined()
def add_drag(tangent, bodies, velocity, drag):
    """Add S K S v to the viscous force on the ring, with the stiffness K of all balls."""
    spread = bodies.spread
    for x in range(3):
        for y in range(3):
            rate = 0.0
            for z in range(3):
                rate += tangent[y, z] * (
                    spread[z, 0] * velocity[0]
                    + spread[z, 1] * velocity[1]
                    + spread[z, 2] * velocity[2]
                )
            drag[x] += spread[x, y] * rate


@inlined()
def kick_ball(j, line, force, held, coupling, bodies, state, drag):
    """Change the velocity of a ball with mass; return its kinetic energy and what it loses [J].

    It is braked beside the velocity with which a ball without mass would follow the ring, and the
    reaction is added to the viscous force on the ring.
    """
    against = 0.0
    if held > 0.0:
        closing = 0.0
        for x in range(3):
            closing += line[x] * state.ring_velocity[x]
        slip = state.ball_velocity[j] + coupling / held * closing
        against = bodies.ball_time * held * slip
        for x in range(3):
            drag[x] += against * coupling / held * line[x]
    gain = bodies.step * (force - against) / bodies.ball_mass
    mean = state.ball_velocity[j] + 0.5 * gain
    state.ball_velocity[j] += gain
    return 0.5 * bodies.ball_mass * mean * mean, bodies.step * against * mean


@inlined()
def kick_ring(bodies, state, drag, row):
    """Change the velocity of the ring, and record it; return its kinetic energy and loss [J]."""
    kinetic = 0.0
    loss = 0.0
    for x in range(3):
        row[6 + x] -= drag[x]
        gain = bodies.step * (bodies.load[x] + row[6 + x]) / bodies.ring_mass
        mean = state.ring_velocity[x] + 0.5 * gain
        row[x] = state.ring[x]
        row[3 + x] = mean
        kinetic += 0.5 * bodies.ring_mass * mean * mean
        loss += bodies.step * drag[x] * mean
        state.ring_velocity[x] += gain
    return kinetic, loss


@inlined()
def add_works(energy, share, bodies, tables, state, sums):
    """Add the work of the loads and of the turning tracks from the last middle to this one.

    The tracks' work is the change of the contacts' energy from the last laws to the new ones, half
    of it at the last place of ring and balls and half at the new one.
    """
    for x in range(3):
        sums.load_work[0] += bodies.load[x] * (state.ring[x] - state.last_ring[x])
    for j in range(state.balls.shape[0]):
        moved = state.balls[j] - state.last_balls[j]
        sums.load_work[0] += share * bodies.centrifugal * moved
    here = energy - energy_of(
        state.ring, state.balls, state.last_around, state.last_laws, bodies, tables
    )
    there = energy_of(state.last_ring, state.last_balls, state.around, state.laws, bodies, tables)
    sums.track_work[0] += 0.5 * (here + there - sums.contact_energy[0])


@njit(cache=True)
def take_steps(first, bodies, tables, state, sums, record):
    """Take a step for each row of `record`, and set it to what the middle of the step has.

    `first` [s] is the time of the first middle. A row has the displacement of the ring, its
    velocity, the force of balls and viscosity on it, three numbers each, and the load of each ball
    on it.
    """
    balls = state.around.shape[0]
    drag = np.empty(3)
    line = np.empty(3)
    tangent = np.empty((3, 3))
    for i in range(record.shape[0]):
        time = first + i * bodies.step
        share = share_at(time, bodies)
        drift(0.5 * bodies.step, state)
        for j in range(balls):
            state.last_around[j] = state.around[j]
            state.last_laws[j] = state.laws[j]
        set_laws(time, share, bodies, tables, state.around, state.laws)

        row = record[i]
        row[:] = 0.0
        drag[:] = 0.0
        tangent[:] = 0.0
        energy = 0.0
        kinetic = 0.0
        loaded = 0
        for j in range(balls):
            around = state.around[j]
            elongation, outwards, axial, turning = line_at(around, state.ring, bodies)
            line[0] = outwards * around[0]
            line[1] = outwards * around[1]
            line[2] = axial
            stored, load, pull, series, held, coupling = press_ball(
                j, elongation, bodies, tables, state
            )
            energy += stored
            row[9 + j] = load
            if load > 0.0:
                loaded += 1
            for x in range(3):
                row[6 + x] -= load * line[x]
            add_stiffness(series, line, tangent)
            if bodies.ball_mass > 0.0:
                force = pull + share * bodies.centrifugal
                moving, lost = kick_ball(j, line, force, held, coupling, bodies, state, drag)
                kinetic += moving
                sums.loss[0] += lost
            if turning > 0.0:
                line[0] = -axial * around[0]  # across the contact line
                line[1] = -axial * around[1]
                line[2] = outwards
                add_stiffness(load * turning, line, tangent)
        add_drag(tangent, bodies, state.ring_velocity, drag)
        moving, lost = kick_ring(bodies, state, drag, row)
        kinetic += moving
        sums.loss[0] += lost

        if sums.steps[0] > 0.0:
            add_works(energy, share, bodies, tables, state, sums)
        else:
            sums.first_energy[0] = energy + kinetic
            sums.lowest[0] = energy
        sums.steps[0] += 1.0
        sums.last_energy[0] = energy + kinetic
        sums.contact_energy[0] = energy
        sums.lowest[0] = min(sums.lowest[0], energy)
        sums.highest[0] = max(sums.highest[0], energy)
        sums.apart[0] += balls - loaded
        if loaded == 0:
            sums.free[0] += 1.0
        state.last_ring[:] = state.ring
        state.last_balls[:] = state.balls
        drift(0.5 * bodies.step, state)
