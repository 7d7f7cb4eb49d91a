// Motion of a ball over a force law, in equal time steps.
//
// Ball, mean stiffness and plate are the poles of a linear chain. Each is moved exactly under the
// source s = k (d + tau d') - (F - W), which is a parabola through the ends of the step and the start
// of the step before, or linear within the step after a flight: then the line keeps the energy of
// impacts. The source at the end solves a scalar equation, in which the force is the law's.

import { ballMass, loadOf } from "./chain.js";
import { heldPole, times } from "./hold.js";

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

/** Return the time [s] of an impact of a mass [kg] with a speed [m/s] by Hertz. */
export function impactTime(mass, speed, radius, modulus) {
  return 2.868 * (mass ** 2 / (radius * modulus ** 2 * speed)) ** 0.2;
}

/**
 * Return the number of time steps per sample: they resolve the period of the resonance, the impact
 * from a height [m], and the shortest waves of the law at a speed [m/s].
 */
export function stepsPerSample(run, settings, chain, height = settings.dropHeight ?? 0) {
  const { radius, modulus, shortestWave } = run.fixed;
  const [mass, load] = [ballMass(run, settings), loadOf(run, settings)];
  let longest = (2 * Math.PI) / Math.sqrt(chain.stiffness / mass) / PER_PERIOD;
  const fall = Math.sqrt((2 * load * height) / mass);
  if (fall > 0) longest = Math.min(longest, impactTime(mass, fall, radius, modulus) / PER_IMPACT);
  if (settings.speed > 0) longest = Math.min(longest, shortestWave / (2 * settings.speed));
  return Math.min(Math.max(Math.ceil(1 / (RATE * longest)), 3), MOST_STEPS);
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
    const { stiffness, contactTime, mobility, re, im } = chain;
    const n = (this.count = re.length);
    // A state y = residue * x: the approach is the sum of the real parts.
    for (const name of ["e0", "e1", "b0", "b1", "y0", "y1"]) this[name] = new Float64Array(n);
    // Weights of the source at the start, after a line or a parabola and before a line or a parabola.
    this.starts = [0, 1].map(() => [0, 1].map(() => [new Float64Array(n), new Float64Array(n)]));
    const jump = mobility / (1 + stiffness * contactTime * mobility); // d' per source at once
    this.holds = [0, 1].map(() => ({ give: 0, turn: jump })); // d and d' per source at the end
    const ends = [];
    for (let j = 0; j < n; j++) {
      const { first, second, bend, turn } = heldPole(chain, j, step);
      // The state is kept without the source at the end, which is added at the next step.
      const late = [times(...second, ...turn), times(second[0] + bend[0], second[1] + bend[1], ...turn)];
      [this.e0[j], this.e1[j]] = turn;
      [this.b0[j], this.b1[j]] = bend;
      for (const i of [0, 1]) {
        for (const after of [0, 1]) {
          for (const next of [0, 1]) {
            this.starts[after][next][i][j] = first[i] - second[i] + late[after][i] - 2 * next * bend[i];
          }
        }
      }
      ends.push(second);
      this.holds.forEach((hold, share) => {
        hold.give += second[0] + share * bend[0];
        hold.turn += times(second[0] + share * bend[0], second[1] + share * bend[1], re[j], im[j])[0];
      });
    }
    for (const hold of this.holds) {
      hold.ease = hold.turn / hold.give;
      hold.rise = Math.max(1 - hold.give * stiffness * (1 + contactTime * hold.ease), LEAST_RISE);
    }
    this.setState(velocity, ends);
  }

  /** Set the states of the poles to the present approach, its velocity [m/s] and the force. */
  setState(velocity, ends) {
    const { load } = this;
    const { stiffness, contactTime, mobility, mass, re, im, residueRe, residueIm } = this.chain;
    [this.hold, this.bent] = [this.holds[0], 0];
    this.source = this.sourceOf(this.approach, velocity, this.force);
    this.before = this.sourceOf(this.approachBefore, velocity, this.forceBefore);
    // Under a force f beyond the load a plate with modes is at rest and displaced, and one without sinks.
    const excess = this.force - load;
    const speed = velocity + mobility * excess;
    const plate = mobility > 0 ? 0 : excess;
    for (let j = 0; j < this.count; j++) {
      const inverse = times(re[j], -im[j], 1 / (re[j] ** 2 + im[j] ** 2), 0);
      const loop = times(stiffness * (1 + contactTime * re[j]), stiffness * contactTime * im[j], ...times(...inverse, ...inverse));
      const x0 = (plate - stiffness * this.approach) * inverse[0];
      const x1 = (plate - stiffness * this.approach) * inverse[1];
      const moved = times(...loop, (plate / mass) * inverse[0] - speed, (plate / mass) * inverse[1]);
      const state = times(x0 + moved[0], x1 + moved[1], residueRe[j], residueIm[j]);
      this.y0[j] = state[0] - ends[j][0] * this.source;
      this.y1[j] = state[1] - ends[j][1] * this.source;
    }
  }

  /** Return the source [N] at an approach [m], its velocity [m/s] and a force [N]. */
  sourceOf(approach, velocity, force) {
    const { stiffness, contactTime } = this.chain;
    return stiffness * (approach + contactTime * velocity) - (force - this.load);
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
    let known = 0;
    for (let j = 0; j < this.count; j++) known += this.y0[j];
    return this.drift(known) + this.hold.ease * this.approach;
  }

  /** Height [m] of the ball above the place where it would touch. */
  get height() {
    return Math.max(this.law.liftOff - this.approach, 0);
  }

  /** Take one step to a position [m] and return the contact force [N] at its end. */
  advance(position) {
    const { law, load, count, e0, e1, b0, b1, y0, y1, source } = this;
    const smooth = this.calm >= CALM ? 1 : 0;
    const { give, rise, ease } = (this.hold = this.holds[smooth]);
    const start = this.starts[this.bent][smooth];
    const p0 = start[0]; // destructuring takes as long as some modes
    const p1 = start[1];
    const before = smooth * this.before;
    let known = 0;
    for (let j = 0; j < count; j++) {
      const a = e0[j] * y0[j] - e1[j] * y1[j] + p0[j] * source + b0[j] * before;
      y1[j] = e1[j] * y0[j] + e0[j] * y1[j] + p1[j] * source + b1[j] * before;
      y0[j] = a;
      known += a;
    }
    const { stiffness, contactTime } = this.chain;
    let drift = 0; // d' = drift + ease d
    let damping = 0;
    if (contactTime > 0) {
      drift = this.drift(known);
      damping = stiffness * contactTime * drift;
    }
    law.moveTo(position);
    // rise d + give F = whole: without a force d is the largest.
    const whole = known + give * (load + damping);
    const free = whole / rise;
    const d = free > law.liftOff ? this.pressed(whole, free, drift) : free;
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
    const { count, y0, y1 } = this;
    const { re, im } = this.chain;
    let velocity = 0;
    for (let j = 0; j < count; j++) velocity += re[j] * y0[j] - im[j] * y1[j];
    return velocity - this.hold.ease * known;
  }

  /** Return the approach [m] of a step that ends in contact, by Newton's method in a bracket. */
  pressed(whole, free, drift) {
    const { law, chain } = this;
    const { give, rise, ease } = this.hold;
    let low = law.liftOff;
    let high = free;
    let d = 2 * this.approach - this.approachBefore;
    if (!(d > low && d < high)) d = high;
    for (let i = 0; i < MOST; i++) {
      const elastic = law.force(d);
      const drag = chain.contactTime * law.stiffness;
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
