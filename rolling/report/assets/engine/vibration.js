// Contact force of a rolling ball at 48 kHz: its motion in time steps, brought down to samples.

import { Decimator } from "./decimate.js";
import { ForceLaw } from "./law.js";
import { Motion, RATE } from "./motion.js";
import { BLOCK } from "./travel.js";

const LIFT_S = 0.1; // in which a ball that is lifted leaves the contact
const CHANGE_S = 0.03; // in which a motion fades into one with another chain
const LOAD_S = 0.02; // time constant of a change of the load, twice in a row

/** Fluctuation of the contact force [N] at 48 kHz while the ball travels. */
export class ForceSource {
  constructor(run, settings, prepared) {
    this.law = new ForceLaw(prepared.table);
    this.motion = new Motion(this.law, prepared.chain, prepared.load, 1 / (RATE * prepared.steps));
    this.rest = this.load = this.nearLoad = prepared.load; // the graph takes off the rest
    this.held = null; // height [m] of a ball in a hand
    this.steps = prepared.steps;
    this.decimator = new Decimator(this.steps);
    this.forces = new Float64Array(BLOCK * this.steps);
    if (!settings.dropHeight) return;
    this.motion.release(settings.dropHeight);
    this.rest = 0;
  }

  /** Take the chain and the load of other settings with as many time steps. */
  take(settings, prepared) {
    this.before = this.motion;
    this.faded = 0;
    this.motion = Object.assign(Object.create(Motion.prototype), this.motion);
    this.motion.setChain(prepared.chain);
    this.load = prepared.load;
  }

  /** Hold the ball at a height [m]. */
  lift(height) {
    this.held = { height, force: this.held?.force ?? this.motion.force, share: this.held?.share ?? 1 };
  }

  /** Let the ball go. */
  drop() {
    if (!this.held) return;
    this.motion.release(this.held.height);
    this.before = null;
    this.held = null;
  }

  /** Set a block of samples to the fluctuation of the contact force [N]. */
  block(travel, samples) {
    const { motion, forces, steps } = this;
    const share = 1 / (LOAD_S * RATE * steps);
    for (let i = 0; i < forces.length; i++) {
      const position = travel.advance(1 / (RATE * steps));
      this.nearLoad += share * (this.load - this.nearLoad);
      motion.load += share * (this.nearLoad - motion.load);
      if (this.held) {
        this.held.share = Math.max(this.held.share - 1 / (LIFT_S * RATE * steps), 0);
        motion.position = position;
        forces[i] = this.held.force * Math.sin((Math.PI / 2) * this.held.share) ** 2 - this.rest;
      } else {
        const force = motion.advance(position);
        forces[i] = (this.before ? this.mixed(force, position) : force) - this.rest;
      }
    }
    this.decimator.process(forces, samples);
  }

  /** Lowest and highest force [N] of the latest block, and the share of it that the ball flew. */
  get extremes() {
    const { forces, rest } = this;
    let [lowest, highest, flown] = [Infinity, -Infinity, 0];
    for (const force of forces) {
      lowest = Math.min(lowest, force);
      highest = Math.max(highest, force);
      flown += force + rest <= 0;
    }
    return { lowest: lowest + rest, highest: highest + rest, flies: flown / forces.length };
  }

  /** Return the force [N] of a step, faded from that of the motion before. */
  mixed(force, position) {
    this.before.load = this.motion.load;
    const old = this.before.advance(position);
    this.faded += 1 / (CHANGE_S * RATE * this.steps);
    if (this.faded >= 1) this.before = null;
    return old + Math.sin((Math.PI / 2) * Math.min(this.faded, 1)) ** 2 * (force - old);
  }

  get state() {
    const { motion, held } = this;
    const height = held ? held.height : motion.height;
    return { force: held ? 0 : motion.force, approach: motion.approach, height, flies: height > 0, impacts: motion.impacts };
  }
}
