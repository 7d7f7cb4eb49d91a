// Contact force of a rolling ball at 48 kHz: its motion in time steps, brought down to samples.

import { BLOCK, Decimator } from "./decimate.js";
import { ForceLaw } from "./law.js";
import { Motion, RATE } from "./motion.js";

/** Fluctuation of the contact force [N] at 48 kHz while the ball travels, which may fall first. */
export class ForceSource {
  constructor(run, { dropHeight }, { table, chain, load, steps }, { position, hold }) {
    this.motion = new Motion(new ForceLaw(table), chain, load, 1 / (RATE * steps), position);
    if (dropHeight) this.motion.release(dropHeight);
    this.rest = this.motion.force; // a sound begins without a step; its constant part is not heard
    this.held = dropHeight ? Math.round((hold * RATE) / BLOCK) : 0; // blocks until the ball is let go
    this.forces = new Float64Array(BLOCK * steps);
    this.decimator = new Decimator(steps);
  }

  /** Set a block of samples to the fluctuation of the contact force [N]. */
  block(travel, samples) {
    const { motion, forces, rest } = this;
    const held = this.held > 0;
    if (held) this.held--;
    for (let i = 0; i < forces.length; i++) {
      const position = travel.advance(motion.step);
      forces[i] = (held ? 0 : motion.advance(position)) - rest;
    }
    this.decimator.process(forces, samples);
  }

  /** Return the lowest and highest force [N] of the latest block, and its share of flight. */
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

  get state() {
    const { force, height } = this.motion;
    return { force, height };
  }
}
