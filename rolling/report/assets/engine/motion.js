// Motion of a ball over a force law, in equal time steps.
//
// Ball, mean stiffness and plate are the poles of a linear chain. Each is moved exactly under the
// source s = k d - (F - W), which is a parabola through the ends of the step and the start
// of the step before, or linear within the step after a flight: then the line keeps the energy of
// impacts. The source at the end solves a scalar equation, in which the force is the law's.

import { ballMass, loadOf } from "./chain.js";
import { over, plus, times } from "./poles.js";

const FASTEST = 1.5; // phase of a pole in a step, beyond which it has no inertia,
const SHARP = 0.1; // if its damping over its frequency is less
const LEAST_RISE = 1e-6; // of the residual over the approach; a ball too light for the steps has none
const MOST = 60; // iterations; Newton takes three, and halving of the bracket ends it in any case
const PER_PERIOD = 18; // steps in a period of the resonance at least, which leave -50 dB of the force
const PER_IMPACT = 12; // steps in the time of an impact at least, which leave 0.1 % of its impulse
const CALM = 400; // steps without a flight after which the source is a parabola
const [FALL, ROUGH] = [1, 1e-4]; // speed [m/s] and height [m] that a ball on a track does not exceed
const HIGHER = 1.1; // height that a ball does not reach over the height of its fall
const STRONGEST = 1e9; // force over the load that a ball on a track does not reach
export const RATE = 48000; // samples per second
export const MOST_STEPS = 32; // per sample

/**
 * Return the number of time steps per sample: they resolve the period of the resonance, the impact
 * from a height [m], and the shortest waves of the law at a speed [m/s].
 */
export function stepsPerSample(run, settings, chain, height = settings.dropHeight ?? 0) {
  const { impactRadius, modulus, shortestWave } = run.fixed;
  const [mass, load] = [ballMass(run, settings), loadOf(run, settings)];
  let longest = (2 * Math.PI) / Math.sqrt(chain.stiffness / mass) / PER_PERIOD;
  const fall = Math.sqrt((2 * load * height) / mass);
  const impact = 2.868 * (mass ** 2 / (impactRadius * modulus ** 2 * fall)) ** 0.2; // [s], by Hertz
  if (fall > 0) longest = Math.min(longest, impact / PER_IMPACT);
  if (settings.speed > 0) longest = Math.min(longest, shortestWave / (2 * settings.speed));
  return Math.min(Math.max(Math.ceil(1 / (RATE * longest)), 3), MOST_STEPS);
}

const exponential = ([x, y]) => [Math.exp(x) * Math.cos(y), Math.exp(x) * Math.sin(y)];

/** Return phi_1, phi_2, phi_3 at z, the moments of exp(z t) over a step. */
function moments(z) {
  if (Math.hypot(...z) > 1) {
    let value = exponential(z);
    return [1, 1, 0.5].map((constant) => (value = over([value[0] - constant, value[1]], z)));
  }
  return [1, 2, 6].map((factorial, i) => {
    let [sum, term] = [[0, 0], [1 / factorial, 0]];
    for (let n = i + 2; n < 22; n++) [sum, term] = [plus(sum, term), times(term, [z[0] / n, z[1] / n])];
    return sum;
  });
}

/**
 * Return the weights of the source on a pole in a step [s], times its residue: `first` of a constant,
 * `second` of a rise within the step, `bend` of a second difference; `turn` is exp(p t).
 */
function heldPole(pole, residue, step) {
  const z = [pole[0] * step, pole[1] * step];
  const fast = z[1] > FASTEST && -z[0] < SHARP * z[1]; // then the pole follows the source at once
  const still = over([-1, 0], z);
  const phi = fast ? [still, still, [still[0] / 2, still[1] / 2]] : moments(z);
  const [first, second, third] = phi.map((moment) => times(moment, [step * residue[0], step * residue[1]]));
  return { first, second, bend: plus(third, second, -0.5), turn: fast ? [0, 0] : exponential(z) };
}

/** Return arrays for the real and the imaginary parts of complex numbers. */
const pairOfArrays = (count) => [new Float64Array(count), new Float64Array(count)];

/** Put a complex number into a pair of arrays. */
function put([re, im], j, [x, y]) {
  re[j] = x;
  im[j] = y;
}

/** Motion of a ball over a force law; its numbers belong to the end of the last step. */
export class Motion {
  constructor(law, chain, load, step) {
    Object.assign(this, { law, step, position: law.start, force: load, impacts: 0, calm: CALM });
    law.moveTo(law.start);
    this.approach = this.approachBefore = law.approach(load);
    this.forceBefore = load;
    this.setChain(chain, load, step);
  }

  /** Take a chain, a load [N] and a step [s]; approach, its velocity and the force go on. */
  setChain(chain, load = this.load, step = this.step, velocity = this.chain ? this.velocity : 0) {
    const stretch = step / this.step;
    this.approachBefore = this.approach + stretch * (this.approachBefore - this.approach);
    this.forceBefore = Math.max(this.force + stretch * (this.forceBefore - this.force), 0);
    Object.assign(this, { chain, load, step });
    this.ceiling = Math.max(ROUGH + (chain.mass * FALL ** 2) / (2 * load), this.ceiling ?? 0);
    const { stiffness, mobility, poles } = chain;
    // A state y = residue * x: the approach is the sum of the real parts.
    for (const name of ["pole", "turn", "bend", "state"]) this[name] = pairOfArrays(poles.length);
    // Weights of the source at the start, after a line or a parabola and before a line or a parabola.
    this.starts = [0, 1].map(() => [0, 1].map(() => pairOfArrays(poles.length)));
    this.holds = [0, 1].map(() => ({ give: 0, turn: mobility })); // d and d' per source at the end
    const held = poles.map(([pole, residue]) => heldPole(pole, residue, step));
    held.forEach(({ first, second, bend, turn }, j) => {
      const pole = poles[j][0];
      put(this.pole, j, pole);
      put(this.turn, j, turn);
      put(this.bend, j, bend);
      for (const bent of [0, 1]) {
        const end = plus(second, bend, bent);
        this.holds[bent].give += end[0];
        this.holds[bent].turn += times(end, pole)[0];
        // The state is kept without the source at the end, which is added at the next step.
        const start = plus(plus(first, second, -1), times(end, turn));
        for (const next of [0, 1]) put(this.starts[bent][next], j, plus(start, bend, -2 * next));
      }
    });
    for (const hold of this.holds) {
      hold.ease = hold.turn / hold.give;
      hold.rise = Math.max(1 - hold.give * stiffness, LEAST_RISE);
    }
    this.setState(velocity, held);
  }

  /** Set the states of the poles to the present approach, its velocity [m/s] and the force. */
  setState(velocity, held) {
    const { stiffness, mobility, mass, poles } = this.chain;
    [this.hold, this.bent] = [this.holds[0], 0];
    this.source = this.sourceOf(this.approach, this.force);
    this.before = this.sourceOf(this.approachBefore, this.forceBefore);
    // Under a force f beyond the load a plate with modes is at rest and displaced, and one without sinks.
    const excess = this.force - this.load;
    const speed = velocity + mobility * excess;
    const plate = mobility > 0 ? 0 : excess;
    poles.forEach(([pole, residue], j) => {
      const moved = plus(over([plate / mass, 0], pole), [-speed, 0]);
      const x = over(plus([plate - stiffness * this.approach, 0], over(moved, pole), stiffness), pole);
      put(this.state, j, plus(times(x, residue), held[j].second, -this.source));
    });
  }

  /** Return the source [N] at an approach [m] and a force [N]. */
  sourceOf(approach, force) {
    return this.chain.stiffness * approach - (force - this.load);
  }

  /** Hold the ball at a height [m] above its place and let it go at a velocity [m/s] to the plate. */
  release(height, velocity = 0) {
    this.law.moveTo(this.position);
    this.approach = this.law.liftOff - height;
    this.approachBefore = this.approach - velocity * this.step;
    this.calm = 0;
    this.ceiling = Math.max(this.ceiling, HIGHER * height);
    [this.force, this.forceBefore] = [this.law.force(this.approach), this.law.force(this.approachBefore)];
    this.setChain(this.chain, this.load, this.step, velocity);
  }

  /** Velocity [m/s] of the approach. */
  get velocity() {
    const known = this.state[0].reduce((sum, value) => sum + value, 0);
    return this.drift(known) + this.hold.ease * this.approach;
  }

  /** Height [m] of the ball above the place where it would touch. */
  get height() {
    return Math.max(this.law.liftOff - this.approach, 0);
  }

  /** Take one step to a position [m] and return the contact force [N] at its end. */
  advance(position) {
    const { law, load, source } = this;
    const smooth = this.calm >= CALM ? 1 : 0;
    const { give, rise } = (this.hold = this.holds[smooth]);
    const [y0, y1] = this.state;
    const [e0, e1] = this.turn;
    const [b0, b1] = this.bend;
    const [p0, p1] = this.starts[this.bent][smooth];
    const before = smooth * this.before;
    let known = 0;
    for (let j = 0; j < y0.length; j++) {
      const a = e0[j] * y0[j] - e1[j] * y1[j] + p0[j] * source + b0[j] * before;
      y1[j] = e1[j] * y0[j] + e0[j] * y1[j] + p1[j] * source + b1[j] * before;
      y0[j] = a;
      known += a;
    }
    law.moveTo(position);
    // rise d + give F = whole: without a force d is the largest.
    const whole = known + give * load;
    const free = whole / rise;
    const d = free > law.liftOff ? this.pressed(whole, free, known) : free;
    // The force of the equation, not of the law: the state then keeps it exactly.
    const force = d < free ? Math.max((whole - rise * d) / give, 0) : 0;
    const possible = d > law.liftOff - this.ceiling && force < STRONGEST * load;
    if (!possible) this.release(this.ceiling / HIGHER); // the steps are too long for the ball
    else this.end(d, force, (d - known) / give, smooth);
    this.position = position;
    return this.force;
  }

  /** Go on from approach [m], force [N] and source [N] at the end of a step. */
  end(d, force, source, smooth) {
    if (force > 0 && !(this.force > 0)) this.impacts++;
    this.before = this.source;
    this.source = source;
    this.calm = force > 0 ? this.calm + 1 : 0;
    this.bent = smooth; // the state lacks the source at the end, and its part of the bend
    this.approachBefore = this.approach;
    this.forceBefore = this.force;
    this.approach = d;
    this.force = force;
  }

  /** Return the velocity [m/s] of the approach less the part that rises with it. */
  drift(known) {
    const [y0, y1] = this.state;
    const [re, im] = this.pole;
    let velocity = 0;
    for (let j = 0; j < y0.length; j++) velocity += re[j] * y0[j] - im[j] * y1[j];
    return velocity - this.hold.ease * known;
  }

  /** Return the approach [m] of a step that ends in contact, by Newton's method in a bracket. */
  pressed(whole, free, known) {
    const { law } = this;
    const { contactTime } = this.chain;
    const drift = contactTime > 0 ? this.drift(known) : 0; // d' = drift + ease d
    const { give, rise, ease } = this.hold;
    let low = law.liftOff;
    let high = free;
    let d = 2 * this.approach - this.approachBefore;
    if (!(d > low && d < high)) d = high;
    for (let i = 0; i < MOST; i++) {
      const elastic = law.force(d);
      const drag = contactTime * law.stiffness;
      const force = Math.max(elastic + drag * (drift + ease * d), 0); // surfaces do not pull
      const residual = rise * d + give * force - whole;
      if (residual > 0) high = d;
      else low = d;
      let next = d - residual / (rise + give * (law.stiffness + drag * ease));
      if (!(next > low && next < high)) next = 0.5 * (low + high);
      const change = Math.abs(next - d);
      d = next;
      if (change <= 1e-13 * Math.abs(free - law.liftOff) + 1e-16 * Math.abs(d)) break;
    }
    return d;
  }
}
