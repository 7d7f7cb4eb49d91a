// The small model of a bearing: a rigid ring with three displacements on the springs of its balls.
//
// Balls have no mass. A ball's force follows from Hertz' law of its two contacts in series, pressed by the
// elongation of its contact line less the tracks: the change of the approach as ball and
// raceways turn, as the run computed it, at the mean load that the balls have at the settings.

import { RATE } from "../engine/rate.js";

const FINE = 0.35; // phase of the fastest resonance in a time step
const MAX_STEPS = 32; // time steps per sample
const SETTLED_S = 0.25; // before the record begins
const MIN_STIFF = 1e-9; // of the stiffness: what is left of it in a direction that no ball holds
const ITERATIONS = 100; // of the search for the rest under the loads
const EXACT = 1e-9; // force that may lack at rest, over the load
const SHORTEST = 1e-6; // share of a step of the search
const PAIRS = [[0, 1], [0, 2], [1, 2]]; // of axes, which Jacobi's rotations turn one after the other
const ROTATIONS = 18;

/** Solve three linear equations whose matrix is symmetric and positive. */
function solve3(matrix, right) {
  const [[a, b, c], [, d, e], [, , f]] = matrix;
  const minors = [d * f - e * e, c * e - b * f, b * e - c * d, a * f - c * c, b * c - a * e, a * d - b * b];
  const determinant = a * minors[0] + b * minors[1] + c * minors[2];
  const [p, q, r, s, t, u] = minors.map((minor) => minor / determinant);
  const [x, y, z] = right;
  return [p * x + q * y + r * z, q * x + s * y + t * z, r * x + t * y + u * z];
}

/** Return the eigenvalues and eigenvectors of a symmetric matrix, by Jacobi's rotations. */
function eigensystem(matrix) {
  const a = matrix.map((row) => [...row]);
  const vectors = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]; // as columns
  for (let turn = 0; turn < ROTATIONS; turn++) {
    const [p, q] = PAIRS[turn % PAIRS.length];
    if (a[p][q] === 0) continue;
    const angle = 0.5 * Math.atan2(2 * a[p][q], a[q][q] - a[p][p]);
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    for (const row of [...a, ...vectors]) [row[p], row[q]] = [c * row[p] - s * row[q], s * row[p] + c * row[q]];
    [a[p], a[q]] = [a[p].map((value, k) => c * value - s * a[q][k]), a[q].map((value, k) => s * a[p][k] + c * value)];
  }
  return { values: [0, 1, 2].map((k) => Math.max(a[k][k], 0)), vectors };
}

/** Return the viscous matrix [N s/m] that gives each resonance of a ring on springs its loss factor, and films of oil their time [s] times the stiffness. */
function dampingOf({ values, vectors }, mass, lossFactor, filmTime) {
  const own = values.map((stiffness) => lossFactor * Math.sqrt(stiffness * mass) + filmTime * stiffness);
  const entry = (row, column) => own.reduce((sum, value, k) => sum + value * vectors[row][k] * vectors[column][k], 0);
  return [0, 1, 2].map((row) => [0, 1, 2].map((column) => entry(row, column)));
}

/** Set `line` to the elongation of a contact line [m], its parts outwards and along the axis, and its turn across it [1/m].
 *
 * `outwards` and `z` are the ways of the ring in the plane of the ball. A fixed angle has no curvature. */
function setLine(line, cosine, sine, curvature, outwards, z) {
  const along = cosine * outwards + sine * z;
  const across = cosine * z - sine * outwards;
  const stretched = 1 + curvature * along;
  const turned = curvature * across;
  const length = Math.sqrt(stretched * stretched + turned * turned);
  line[0] = (2 * along + curvature * (along * along + across * across)) / (1 + length);
  line[1] = (stretched * cosine - turned * sine) / length;
  line[2] = (stretched * sine + turned * cosine) / length;
  line[3] = curvature / length;
}

/** Return the load of a ball at an angle [N] where the ring is at a place. */
export function loadAt({ stiffness, alpha, curvature, sign, gap }, angle, [x, y, z]) {
  const line = new Float64Array(4);
  setLine(line, Math.cos(alpha), Math.sin(alpha), curvature, sign * (Math.cos(angle) * x + Math.sin(angle) * y), z);
  return stiffness * Math.max(line[0] - gap, 0) ** 1.5;
}

/** Return the ring's force on the balls [N] at a displacement, its stiffness [N/m], and the ball loads [N]. */
function balance(bearing, angle, [x, y, z]) {
  const { balls, stiffness, alpha, curvature, sign, gap } = bearing;
  const turned = new Float64Array(4);
  const force = [0, 0, 0];
  const matrix = [[0, 0, 0], [0, 0, 0], [0, 0, 0]];
  const loads = new Float64Array(balls);
  for (let j = 0; j < balls; j++) {
    const place = angle + (2 * Math.PI * j) / balls;
    const [outX, outY] = [sign * Math.cos(place), sign * Math.sin(place)];
    setLine(turned, Math.cos(alpha), Math.sin(alpha), curvature, outX * x + outY * y, z);
    const [elongation, outwards, axial, turn] = turned;
    const line = [outwards * outX, outwards * outY, axial];
    const across = [-axial * outX, -axial * outY, outwards];
    const pressed = Math.max(elongation - gap, 0);
    loads[j] = stiffness * pressed ** 1.5;
    const slope = 1.5 * stiffness * Math.sqrt(pressed);
    for (let row = 0; row < 3; row++) {
      force[row] += loads[j] * line[row];
      for (let column = 0; column < 3; column++) {
        matrix[row][column] += slope * line[row] * line[column] + loads[j] * turn * across[row] * across[column];
      }
    }
  }
  return { force, matrix, loads };
}

/** Return the rest under an axial and a radial load [N]: displacement [m], stiffness [N/m] and ball loads [N].
 *
 * The radial load presses the ring against the balls at angle 0. */
export function rest(bearing, axial, radial, angle = 0) {
  const { stiffness, sign, gap } = bearing;
  const wanted = [sign * radial, 0, axial];
  const size = Math.hypot(...wanted);
  const typical = (size / stiffness) ** (2 / 3);
  const lackingAt = (found) => wanted.map((force, row) => force - found.force[row]);
  let place = wanted.map((force) => ((gap + typical) * force) / size);
  let found = balance(bearing, angle, place);
  for (let i = 0; i < ITERATIONS; i++) {
    const lacking = lackingAt(found);
    const missing = Math.hypot(...lacking);
    if (missing < EXACT * size) break;
    const least = MIN_STIFF * (found.matrix[0][0] + found.matrix[1][1] + found.matrix[2][2] + stiffness * Math.sqrt(typical));
    const step = solve3(found.matrix.map((row, k) => row.map((value, l) => value + (k === l ? least : 0))), lacking);
    let share = 1;
    let next = found;
    do {
      next = balance(bearing, angle, place.map((value, row) => value + share * step[row]));
      share /= 2;
    } while (share > SHORTEST && Math.hypot(...lackingAt(next)) >= missing);
    place = place.map((value, row) => value + 2 * share * step[row]);
    found = next;
  }
  return { place, ...found };
}

/** Return the frequencies [Hz] of a bearing whose turning ring turns at a speed [1/min]. */
export function frequenciesAt(bearing, rpm) {
  const scale = rpm / bearing.rpm;
  return Object.fromEntries(Object.entries(bearing.hz).map(([name, hz]) => [name, hz * scale]));
}

/** Move the ring at settings { rpm, axial, radial }, and record `samples` of it at 48 kHz.
 *
 * Returns velocity [m/s] and acceleration [m/s2] of the ring, means over a sample each, as x, y and z, the loads of all balls [N] at every
 * `loadEvery`-th sample, and the time [s] that the bearing had turned before the first sample. */
export function moveRing(bearing, settings, samples, loadEvery = 20) {
  const { balls, stiffness, alpha, curvature, sign, gap, mass, lossFactor, filmTime, tracks } = bearing;
  const { axial, radial } = settings;
  const still = rest(bearing, axial, radial);
  const modes = eigensystem(still.matrix);
  const fastest = Math.sqrt(Math.max(...modes.values) / mass);
  const steps = Math.min(Math.max(Math.ceil(fastest / (RATE * FINE)), 2), MAX_STEPS);
  const step = 1 / (RATE * steps);
  const damping = dampingOf(modes, mass, lossFactor, filmTime);
  // Leapfrog steps raise a resonance; a heavier ring lowers it by as much.
  const [mx, my, mz] = [0, 1, 2].map((row) => {
    const half = (Math.sqrt(still.matrix[row][row] / mass) * step) / 2;
    return half > 0 ? mass * (half / Math.sin(half)) ** 2 : mass;
  });
  const hz = frequenciesAt(bearing, settings.rpm);
  const begin = Math.round(SETTLED_S * RATE);
  const record = () => [0, 1, 2].map(() => new Float64Array(samples));
  const velocity = record();
  const acceleration = record();
  const loads = new Float32Array(Math.ceil(samples / loadEvery) * balls);
  const now = new Float64Array(balls);
  const own = Float64Array.from({ length: balls }, (_, j) => j / balls);
  const across = own.map((share) => sign * Math.cos(2 * Math.PI * share));
  const along = own.map((share) => sign * Math.sin(2 * Math.PI * share));
  const [cosineOfLine, sineOfLine] = [Math.cos(alpha), Math.sin(alpha)];
  const line = new Float64Array(4);
  const meanLoad = still.loads.reduce((sum, load) => sum + load, 0) / balls;
  const atLoad = (rows) => trackAtLoad(bearing.loads, rows, meanLoad);
  const [inner, outer] = [tracks.inner, tracks.outer].map(atLoad);
  const [ballsOnInner, ballsOnOuter] = [tracks.ballsOnInner, tracks.ballsOnOuter].map((each) => each.map(atLoad));
  const [[dxx, dxy, dxz], [, dyy, dyz], [, , dzz]] = damping;
  let [x, y, z] = still.place;
  let vx = 0;
  let vy = 0;
  let vz = 0;
  for (let sample = -begin; sample < samples; sample++) {
    for (let fine = 0; fine < steps; fine++) {
      const time = ((sample + begin) * steps + fine) * step;
      const cosine = Math.cos(2 * Math.PI * hz.cage * time);
      const angleSine = Math.sin(2 * Math.PI * hz.cage * time);
      const innerTurn = (hz.cage - hz.inner) * time;
      const outerTurn = (hz.cage - hz.outer) * time;
      const spin = hz.spin * time;
      let px = sign * radial - dxx * vx - dxy * vy - dxz * vz;
      let py = -dxy * vx - dyy * vy - dyz * vz;
      let pz = axial - dxz * vx - dyz * vy - dzz * vz;
      for (let j = 0; j < balls; j++) {
        const nx = across[j] * cosine - along[j] * angleSine;
        const ny = along[j] * cosine + across[j] * angleSine;
        const waves = heightAt(inner, innerTurn + own[j]) + heightAt(outer, outerTurn + own[j])
          + heightAt(ballsOnInner[j], spin) + heightAt(ballsOnOuter[j], spin + 0.5);
        setLine(line, cosineOfLine, sineOfLine, curvature, nx * x + ny * y, z);
        const pressed = line[0] - gap - waves;
        const load = pressed > 0 ? stiffness * pressed * Math.sqrt(pressed) : 0;
        now[j] = load;
        px -= load * line[1] * nx;
        py -= load * line[1] * ny;
        pz -= load * line[2];
      }
      if (sample >= 0) { // means over the steps keep what is faster than the samples out of the low bands
        for (const [row, pull] of [px, py, pz].entries()) acceleration[row][sample] += pull / (mass * steps);
        for (const [row, speed] of [vx, vy, vz].entries()) velocity[row][sample] += speed / steps;
        if (fine === 0 && sample % loadEvery === 0) loads.set(now, (sample / loadEvery) * balls);
      }
      vx += (step * px) / mx;
      vy += (step * py) / my;
      vz += (step * pz) / mz;
      x += step * vx;
      y += step * vy;
      z += step * vz;
    }
  }
  return { velocity, acceleration, loads, loadEvery, begin: begin / RATE, still };
}

/** Return a track at a load, from rows at some ascending loads: linear in Q^(2/3), constant beyond them. */
function trackAtLoad(loads, rows, load) {
  const last = loads.length - 1;
  if (load <= loads[0]) return rows[0];
  if (load >= loads[last]) return rows[last];
  const above = loads.findIndex((known) => known > load);
  const [low, high, here] = [loads[above - 1], loads[above], load].map((each) => each ** (2 / 3));
  const share = (here - low) / (high - low);
  return rows[above].map((value, k) => rows[above - 1][k] + share * (value - rows[above - 1][k]));
}

/** Return the height of a track [m] at a number of turns of its body, between two places too. */
function heightAt(track, turn) {
  const where = (turn - Math.floor(turn)) * track.length;
  const first = Math.floor(where);
  const next = first + 1 === track.length ? 0 : first + 1;
  return track[first] + (where - first) * (track[next] - track[first]);
}
