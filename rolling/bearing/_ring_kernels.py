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

The displacement u has x, y and z, the cosine and the sine part of each bending mode
(`ring_bending`), and two turns if the ring is free to tilt, with masses M and the springs B of the
ring itself.
A step drifts to its middle, meets the forces there, and drifts on (leapfrog):

    u += h/2 v,   M (v1 - v0) / h = load - sum Q along n - B u - C v,   u += h/2 v

The viscous matrix is C = S^T (sum k n n^T + Q c t t^T) S with the stiffness k of each ball, its
load Q, and the turn c of its line for a way along t across it, which is 0 at a fixed angle. S is
made so that the mean of C gives each resonance its loss factor. A ball with mass has a viscous
force against its motion beside the place to which the ring would lead it without mass.
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
    masses: Array  # (m,) [kg], [kg m2] of tilts
    springs: Array  # (m,) [N/m] of the ring itself against its bending
    ball_mass: float  # [kg]
    load: Array  # (m,) [N] on the ring
    centrifugal: float  # [N] on a ball, along its contact line
    direction: float  # 1 if displacements press balls outwards, -1 if inwards
    tilt_radius: float  # [m] of the circle of the centres of the groove; 0 for a ring held in plane
    orders: Array  # (k,) ascending numbers of waves around the ring of its bending modes
    cosine: float  # of the contact angle without displacement
    sine: float
    curvature: float  # [1/m] of lines that turn (`contact_lines`), 0 at a fixed angle
    along: Array  # (contacts,)
    beside: Array  # (contacts,)
    gaps: Array  # (contacts,) [m]
    compliances: Array  # (contacts,) [m/N^(2/3)]
    spread: Array  # S, (m, m) [s^(1/2)]
    ball_time: float  # [s] viscosity over stiffness of a ball with mass
    cage_hz: float
    inner_hz: float
    outer_hz: float
    spin_hz: float
    fade_start: float  # [s] at which the tracks begin to grow
    fade_end: float  # [s] from which on they are whole


class RingState(NamedTuple):
    """State between two steps, and the middle of the last step; kernels change the arrays."""

    ring: Array  # (m,) [m]
    ring_velocity: Array  # (m,) [m/s]
    balls: Array  # (balls,) [m] outwards along the contact lines
    ball_velocity: Array  # (balls,) [m/s]
    last_ring: Array  # (m,) [m]
    last_balls: Array  # (balls,) [m]
    ways: Array  # (balls, m) of the groove at a ball, outwards or along the axis
    last_ways: Array
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
def set_ways(cage, bodies, ways):
    """Set the ways that the groove at a ball makes for a unit of each displacement.

    Those of x, y and bending lead outwards, and those of z and of turns along the axis. A bending
    mode of order n moves the groove by cos(n phi) and sin(n phi).
    """
    cosine = cos(2.0 * pi * cage)
    sine = sin(2.0 * pi * cage)
    ways[0] = bodies.direction * cosine
    ways[1] = bodies.direction * sine
    ways[2] = 1.0
    bent = 3 + 2 * bodies.orders.shape[0]
    order = 1
    of_cosine = bodies.direction * cosine
    of_sine = bodies.direction * sine
    for x in range(3, bent, 2):
        while order < bodies.orders[(x - 3) // 2]:
            turned = of_cosine * cosine - of_sine * sine
            of_sine = of_sine * cosine + of_cosine * sine
            of_cosine = turned
            order += 1
        ways[x] = of_cosine
        ways[x + 1] = of_sine
    if bodies.tilt_radius > 0.0:
        ways[bent] = bodies.tilt_radius * sine
        ways[bent + 1] = -bodies.tilt_radius * cosine


@inlined()
def set_laws(time, share, bodies, tables, ways, laws):
    """Set the ways of the groove at all balls, and the approaches of contacts at the nodes."""
    count = ways.shape[0]
    outer_contact = laws.shape[1] - 1  # the only one of a ball without mass
    spin = bodies.spin_hz * time
    for j in range(count):
        cage = bodies.cage_hz * time + j / count
        set_ways(cage, bodies, ways[j])
        laws[j] = 0.0
        add_track(cage - bodies.inner_hz * time, share, tables.inner, laws[j, 0])
        add_track(spin, share, tables.balls_on_inner[j], laws[j, 0])
        add_track(cage - bodies.outer_hz * time, share, tables.outer, laws[j, outer_contact])
        add_track(spin + 0.5, share, tables.balls_on_outer[j], laws[j, outer_contact])
        for c in range(laws.shape[1]):
            close_law(bodies.compliances[c], tables.nodes, laws[j, c])


@inlined()
def line_at(ways, ring, bodies):
    """Return the elongation [m] of a contact line, its direction, and its turn across it [1/m].

    The direction is its part outwards and its part along the axis (`contact_lines`).
    """
    bent = 3 + 2 * bodies.orders.shape[0]
    radial = ways[0] * ring[0] + ways[1] * ring[1]
    for x in range(3, bent):
        radial += ways[x] * ring[x]
    forth = ring[2]
    for x in range(bent, ring.shape[0]):
        forth += ways[x] * ring[x]
    along = bodies.cosine * radial + bodies.sine * forth
    if bodies.curvature == 0.0:
        return along, bodies.cosine, bodies.sine, 0.0
    across = bodies.cosine * forth - bodies.sine * radial
    stretched = 1.0 + bodies.curvature * along
    turned = bodies.curvature * across
    length = sqrt(stretched * stretched + turned * turned)
    bent = bodies.curvature * (along * along + across * across)
    elongation = (2.0 * along + bent) / (1.0 + length)
    outwards = (stretched * bodies.cosine - turned * bodies.sine) / length
    axial = (stretched * bodies.sine + turned * bodies.cosine) / length
    return elongation, outwards, axial, bodies.curvature / length


@inlined()
def set_line(outwards, axial, ways, bodies, line):
    """Set the derivative of a way by all displacements from its parts outwards and axially."""
    bent = 3 + 2 * bodies.orders.shape[0]
    line[0] = outwards * ways[0]
    line[1] = outwards * ways[1]
    line[2] = axial
    for x in range(3, bent):
        line[x] = outwards * ways[x]
    for x in range(bent, line.shape[0]):
        line[x] = axial * ways[x]


@inlined()
def approach_of(elongation, ball, c, bodies):
    """Return the approach [m] of contact c of a ball."""
    return bodies.along[c] * elongation + bodies.beside[c] * ball - bodies.gaps[c]


@inlined()
def energy_of(ring, balls, ways, laws, bodies, tables):
    """Return the energy [J] of all contacts."""
    total = 0.0
    for j in range(ways.shape[0]):
        elongation, _, _, _ = line_at(ways[j], ring, bodies)
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
    for x in range(state.ring.shape[0]):
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
def multiply(matrix, vector, product):
    """Set a product to a matrix times a vector."""
    for x in range(vector.shape[0]):
        total = 0.0
        for y in range(vector.shape[0]):
            total += matrix[x, y] * vector[y]
        product[x] = total


@inlined()
def add_reaction(stiffness, way, velocity, reaction):
    """Add the force k n (n . v) of a spring along n to the reaction of all balls to a velocity."""
    rate = 0.0
    for x in range(way.shape[0]):
        rate += way[x] * velocity[x]
    for x in range(way.shape[0]):
        reaction[x] += stiffness * rate * way[x]


@inlined()
def add_drag(reaction, bodies, drag):
    """Add S^T K S v to the viscous force on the ring, with the reaction K S v of all balls."""
    for x in range(drag.shape[0]):
        for y in range(drag.shape[0]):
            drag[x] += bodies.spread[y, x] * reaction[y]


@inlined()
def kick_ball(j, line, force, held, coupling, bodies, state, drag):
    """Change the velocity of a ball with mass; return its kinetic energy and what it loses [J].

    It is braked beside the velocity with which a ball without mass would follow the ring, and the
    reaction is added to the viscous force on the ring.
    """
    against = 0.0
    if held > 0.0:
        closing = 0.0
        for x in range(line.shape[0]):
            closing += line[x] * state.ring_velocity[x]
        slip = state.ball_velocity[j] + coupling / held * closing
        against = bodies.ball_time * held * slip
        for x in range(line.shape[0]):
            drag[x] += against * coupling / held * line[x]
    gain = bodies.step * (force - against) / bodies.ball_mass
    mean = state.ball_velocity[j] + 0.5 * gain
    state.ball_velocity[j] += gain
    return 0.5 * bodies.ball_mass * mean * mean, bodies.step * against * mean


@inlined()
def kick_ring(bodies, state, drag, row):
    """Change the velocity of the ring, and record it; return its own energy and loss [J].

    Its own energy is that of its motion and of its bending.
    """
    count = state.ring.shape[0]
    own = 0.0
    loss = 0.0
    for x in range(count):
        bent = bodies.springs[x] * state.ring[x]
        row[2 * count + x] -= drag[x] + bent
        gain = bodies.step * (bodies.load[x] + row[2 * count + x]) / bodies.masses[x]
        mean = state.ring_velocity[x] + 0.5 * gain
        row[x] = state.ring[x]
        row[count + x] = mean
        own += 0.5 * bodies.masses[x] * mean * mean + 0.5 * bent * state.ring[x]
        loss += bodies.step * drag[x] * mean
        state.ring_velocity[x] += gain
    return own, loss


@inlined()
def add_works(energy, share, bodies, tables, state, sums):
    """Add the work of the loads and of the turning tracks from the last middle to this one.

    The tracks' work is the change of the contacts' energy from the last laws to the new ones, half
    of it at the last place of ring and balls and half at the new one.
    """
    for x in range(state.ring.shape[0]):
        sums.load_work[0] += bodies.load[x] * (state.ring[x] - state.last_ring[x])
    for j in range(state.balls.shape[0]):
        moved = state.balls[j] - state.last_balls[j]
        sums.load_work[0] += share * bodies.centrifugal * moved
    here = energy - energy_of(
        state.ring, state.balls, state.last_ways, state.last_laws, bodies, tables
    )
    there = energy_of(state.last_ring, state.last_balls, state.ways, state.laws, bodies, tables)
    sums.track_work[0] += 0.5 * (here + there - sums.contact_energy[0])


@njit(cache=True)
def take_steps(first, bodies, tables, state, sums, record):
    """Take a step for each row of `record`, and set it to what the middle of the step has.

    `first` [s] is the time of the first middle. A row has the displacement of the ring, its
    velocity, and the force of balls, bending and viscosity on it, m numbers each, and the load of
    each ball on it.
    """
    balls = state.ways.shape[0]
    count = state.ring.shape[0]
    drag = np.empty(count)
    line = np.empty(count)
    spread_velocity = np.empty(count)
    reaction = np.empty(count)
    for i in range(record.shape[0]):
        time = first + i * bodies.step
        share = share_at(time, bodies)
        drift(0.5 * bodies.step, state)
        for j in range(balls):
            state.last_ways[j] = state.ways[j]
            state.last_laws[j] = state.laws[j]
        set_laws(time, share, bodies, tables, state.ways, state.laws)

        row = record[i]
        row[:] = 0.0
        drag[:] = 0.0
        reaction[:] = 0.0
        multiply(bodies.spread, state.ring_velocity, spread_velocity)
        energy = 0.0
        own = 0.0
        loaded = 0
        for j in range(balls):
            ways = state.ways[j]
            elongation, outwards, axial, turning = line_at(ways, state.ring, bodies)
            stored, load, pull, series, held, coupling = press_ball(
                j, elongation, bodies, tables, state
            )
            energy += stored
            row[3 * count + j] = load
            if load > 0.0:
                loaded += 1
            set_line(outwards, axial, ways, bodies, line)
            for x in range(count):
                row[2 * count + x] -= load * line[x]
            add_reaction(series, line, spread_velocity, reaction)
            if bodies.ball_mass > 0.0:
                force = pull + share * bodies.centrifugal
                moving, lost = kick_ball(j, line, force, held, coupling, bodies, state, drag)
                own += moving
                sums.loss[0] += lost
            if turning > 0.0:
                set_line(-axial, outwards, ways, bodies, line)  # across the contact line
                add_reaction(load * turning, line, spread_velocity, reaction)
        add_drag(reaction, bodies, drag)
        moving, lost = kick_ring(bodies, state, drag, row)
        own += moving
        sums.loss[0] += lost

        if sums.steps[0] > 0.0:
            add_works(energy, share, bodies, tables, state, sums)
        else:
            sums.first_energy[0] = energy + own
            sums.lowest[0] = energy
        sums.steps[0] += 1.0
        sums.last_energy[0] = energy + own
        sums.contact_energy[0] = energy
        sums.lowest[0] = min(sums.lowest[0], energy)
        sums.highest[0] = max(sums.highest[0], energy)
        sums.apart[0] += balls - loaded
        if loaded == 0:
            sums.free[0] += 1.0
        state.last_ring[:] = state.ring
        state.last_balls[:] = state.balls
        drift(0.5 * bodies.step, state)
