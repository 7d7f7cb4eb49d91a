// Contact force of a rolling ball at 48 kHz: its motion in time steps, brought down to samples.

import { ForceLaw } from "./law.js";
import { Motion } from "./motion.js";
import { RATE } from "./rate.js";

export const BLOCK = 128; // samples that are computed at once
export const DECIMATION_DELAY = 42; // samples on either side of the low-pass

/** Return the cubic through equally spaced values at a share t of the way from b to c. */
export function cubic(a, b, c, d, t) {
  return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

/** Low-pass filter from steps to samples, which come later by DECIMATION_DELAY. */
export class Decimator {
  constructor(steps) {
    this.steps = steps;
    const half = DECIMATION_DELAY * steps;
    this.taps = Float64Array.from({ length: 2 * half + 1 }, (_, k) => {
      const phase = (Math.PI * (k - half)) / steps; // the band ends halfway between the edges of pass and stop band
      const angle = (Math.PI * (k - half)) / half;
      const window = 0.42 + 0.5 * Math.cos(angle) + 0.08 * Math.cos(2 * angle); // Blackman: -74 dB from 28 kHz on
      return (window * (phase === 0 ? 1 : Math.sin(phase) / phase)) / steps;
    });
    this.whole = new Float64Array(2 * half + 1 + (BLOCK - 1) * steps); // a block, and before it the values for its first samples
  }

  /** Set a block of samples to the low-passed values of its steps. */
  process(values, samples) {
    const { steps, taps, whole } = this;
    whole.set(values, whole.length - values.length);
    for (let i = 0; i < samples.length; i++) {
      let sum = 0;
      for (let j = 0, k = i * steps; j < taps.length; j++, k++) sum += taps[j] * whole[k];
      samples[i] = sum;
    }
    whole.copyWithin(0, values.length);
  }
}

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
