// Motion of a ball over a force law, in equal time steps.
//
// Ball, mean stiffness and plate are the poles of a linear chain. Each is moved exactly under the
// source s = k d - (F - W), which is linear within the step. The source at the end solves a scalar
// equation, in which the force is the law's; the next step adds the part by which the parabola through
// three sources departs from the line. A line alone keeps the energy of impacts, for some steps after a flight.

import { ballMass, loadOf } from "./chain.js";
import { over, plus, times } from "./complex.js";
import { RATE } from "./rate.js";

const FASTEST = 1.5; // phase of a pole in a step, beyond which it has no inertia,
const SHARP = 0.1; // if its damping over its frequency is less
const MIN_RISE = 1e-6; // of the residual over the approach; a ball too light for the steps has none
const MAX_ITERATIONS = 60; // iterations; Newton takes three, and halving of the bracket ends it in any case
const PER_PERIOD = 18; // steps in a period of the resonance at least, which leave -50 dB of the force
const PER_IMPACT = 12; // steps in the time of an impact at least, which leave 0.1 % of its impulse
const CALM = 400; // steps without a flight after which the source becomes a parabola
const [FALL, ROUGH] = [1, 1e-4]; // speed [m/s] and height [m] that a ball on a track does not exceed
const HIGHER = 1.1; // height that a ball does not reach over the height of its fall
const STRONGEST = 1e9; // force over the load that a ball on a track does not reach
const MAX_STEPS = 32; // per sample

// The steps resolve the period of the resonance, the impact from the height, and the shortest waves of the law.
/** Return the number of time steps per sample at settings and a height [m] of fall. */
export function stepsPerSample(run, settings, chain, height = settings.dropHeight ?? 0) {
  const { impactRadius, modulus, shortestWave } = run.fixed;
  const [mass, load] = [ballMass(run, settings), loadOf(run, settings)];
  let longest = (2 * Math.PI) / Math.sqrt(chain.stiffness / mass) / PER_PERIOD;
  const fall = Math.sqrt((2 * load * height) / mass);
  const impact = 2.868 * (mass ** 2 / (impactRadius * modulus ** 2 * fall)) ** 0.2; // [s], by Hertz
  if (fall > 0) longest = Math.min(longest, impact / PER_IMPACT);
  if (settings.speed > 0) longest = Math.min(longest, shortestWave / (2 * settings.speed));
  return Math.min(Math.max(Math.ceil(1 / (RATE * longest)), 3), MAX_STEPS);
}

const exponential = ([x, y]) => [Math.exp(x) * Math.cos(y), Math.exp(x) * Math.sin(y)];

/** Return phi_1, phi_2, phi_3 at z, the moments of exp(z t) over a step. */
function moments(z) {
  let third = [0, 0];
  if (Math.hypot(...z) > 1) third = [1, 1, 0.5].reduce((value, constant) => over(plus(value, [-constant, 0]), z), exponential(z));
  else for (let n = 22; n >= 3; n--) third = over(plus([1, 0], times(third, z)), [n === 3 ? 6 : n, 0]);
  const second = plus([0.5, 0], times(third, z));
  return [plus([1, 0], times(second, z)), second, third];
}

// `turn` is the weight of the state. Times the residue, `start` and `end` are the weights of a source that is linear
// within the step, `bend` is the weight of the second difference of a parabola, and `late` the same a step later.
/** Return the weights of a pole over a step [s]. */
function heldPole(pole, residue, step) {
  const z = [pole[0] * step, pole[1] * step];
  const fast = z[1] > FASTEST && -z[0] < SHARP * z[1]; // then the pole follows the source at once
  const still = over([-1, 0], z);
  const phi = fast ? [still, still, [still[0] / 2, still[1] / 2]] : moments(z);
  const [first, end, third] = phi.map((moment) => times(moment, [step * residue[0], step * residue[1]]));
  const turn = fast ? [0, 0] : exponential(z);
  const start = plus(plus(first, end, -1), times(turn, end));
  const bend = plus(third, end, -0.5);
  return { turn, start, end, bend, late: times(turn, bend) };
}

/** Return arrays of the real and of the imaginary parts of complex numbers. */
const partsOf = (numbers) => [0, 1].map((part) => Float64Array.from(numbers, (number) => number[part]));

/** Motion of a ball over a force law; its numbers belong to the end of the last step. */
export class Motion {
  constructor(law, chain, load, step, position = law.start) {
    Object.assign(this, { law, chain, load, step, impacts: 0 });
    this.ceiling = ROUGH + (chain.mass * FALL ** 2) / (2 * load);
    const held = chain.poles.map(([pole, residue]) => heldPole(pole, residue, step));
    for (const name of ["turn", "start", "end", "bend", "late"]) this[name] = partsOf(held.map((weights) => weights[name]));
    [this.give, this.lead] = [this.end, this.bend].map(([re]) => re.reduce((sum, value) => sum + value, 0));
    this.rise = Math.max(1 - this.give * chain.stiffness, MIN_RISE);
    law.moveTo(position);
    this.settle(law.approach(load), load);
  }

  /** Hold the ball at a height [m] above its place and let it go. */
  release(height) {
    this.ceiling = Math.max(this.ceiling, HIGHER * height);
    this.settle(this.law.liftOff - height, 0);
  }

  /** Begin at rest at an approach [m], where the plate had carried a force [N] and the ball was held. */
  settle(approach, force) {
    const { load } = this, { stiffness, mass, poles } = this.chain;
    const excess = force - load, source = stiffness * approach - excess;
    const [calm, curve] = [excess ? 0 : CALM, 0];
    Object.assign(this, { approach, before: approach, force, source, sourceBefore: source, calm, curve });
    // A state y = residue * x, whose real parts add up to the approach, lacks the source at the end of the step.
    this.state = partsOf(poles.map(([pole, residue], j) => {
      const x = over(plus(over([(stiffness * excess) / mass, 0], times(pole, pole)), [-source, 0]), pole);
      return plus(times(x, residue), [this.end[0][j], this.end[1][j]], -source);
    }));
  }

  /** Return the height [m] of the ball above the place where it would touch. */
  get height() {
    return Math.max(this.law.liftOff - this.approach, 0);
  }

  /** Take one step to a position [m] and return the contact force [N] at its end. */
  advance(position) {
    const { law, load, give, rise, source, curve } = this;
    const [y0, y1] = this.state;
    const [e0, e1] = this.turn;
    const [b0, b1] = this.late;
    const [p0, p1] = this.start;
    let known = this.lead * curve;
    for (let j = 0; j < y0.length; j++) {
      const a = e0[j] * y0[j] - e1[j] * y1[j] + p0[j] * source + b0[j] * curve;
      y1[j] = e1[j] * y0[j] + e0[j] * y1[j] + p1[j] * source + b1[j] * curve;
      y0[j] = a;
      known += a;
    }
    law.moveTo(position);
    // rise d + give F = whole: without a force d is the largest.
    const whole = known + give * load;
    const free = whole / rise;
    const d = free > law.liftOff ? this.pressed(whole, free) : free;
    // The force of the equation, not of the law: the state then keeps it exactly.
    const force = d < free ? Math.max((whole - rise * d) / give, 0) : 0;
    const possible = d > law.liftOff - this.ceiling && force < STRONGEST * load;
    if (possible) this.keep(d, force, (d - known) / give);
    else this.release(this.ceiling / HIGHER); // the steps are too long for the ball
    return this.force;
  }

  /** Go on from approach [m], force [N] and source [N] at the end of a step. */
  keep(d, force, source) {
    if (force > 0 && !(this.force > 0)) this.impacts++;
    this.calm = force > 0 ? this.calm + 1 : 0;
    this.curve = this.calm > CALM ? source - 2 * this.source + this.sourceBefore : 0;
    this.sourceBefore = this.source;
    this.source = source;
    this.before = this.approach;
    this.approach = d;
    this.force = force;
  }

  /** Return the approach [m] of a step that ends in contact, by Newton's method in a bracket. */
  pressed(whole, free) {
    const { law, give, rise, approach, before, step } = this;
    const viscosity = this.chain.contactTime / step;
    let low = law.liftOff;
    let high = free;
    let d = 2 * approach - before;
    if (!(d > low && d < high)) d = high;
    for (let i = 0; i < MAX_ITERATIONS; i++) {
      const elastic = law.force(d);
      const drag = viscosity * law.stiffness;
      // The velocity is that of the parabola through the latest three; surfaces do not pull.
      const force = Math.max(elastic + drag * (1.5 * d - 2 * approach + 0.5 * before), 0);
      const residual = rise * d + give * force - whole;
      if (residual > 0) high = d;
      else low = d;
      let next = d - residual / (rise + give * (law.stiffness + 1.5 * drag));
      if (!(next > low && next < high)) next = 0.5 * (low + high);
      const change = Math.abs(next - d);
      d = next;
      if (change <= 1e-13 * Math.abs(free - law.liftOff) + 1e-16 * Math.abs(d)) break;
    }
    return d;
  }
}
