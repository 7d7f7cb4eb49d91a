// From engine steps to samples: a symmetric low-pass to 48 kHz.

const SPAN = 42; // samples on either side of the low-pass
const BLACKMAN = [0.42, 0.5, 0.08]; // window: -74 dB from 48 kHz less the upper edge of hearing

export const DECIMATION_DELAY = SPAN; // samples

/** Return the cubic through equally spaced values at a share t of the way from b to c. */
export function cubic(a, b, c, d, t) {
  return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

/** Low-pass from a number of steps per sample to samples, later by DECIMATION_DELAY. */
export class Decimator {
  constructor(steps) {
    this.steps = steps;
    const half = SPAN * steps;
    const cut = 0.5 / steps; // cycles per step: halfway between the edges of pass and stop band
    this.taps = new Float64Array(2 * half + 1);
    for (let i = -half; i <= half; i++) {
      const window = BLACKMAN.reduce((sum, share, k) => sum + share * Math.cos((Math.PI * k * i) / half), 0);
      this.taps[half + i] = window * (i === 0 ? 2 * cut : Math.sin(2 * Math.PI * cut * i) / (Math.PI * i));
    }
    const total = this.taps.reduce((sum, tap) => sum + tap, 0);
    this.taps = this.taps.map((tap) => tap / total);
    this.past = new Float64Array(this.taps.length);
  }

  /** Set samples to the low-passed values of as many times `steps` steps. */
  process(values, samples) {
    const { steps, taps } = this;
    const kept = taps.length - steps;
    const whole = new Float64Array(kept + values.length);
    whole.set(this.past.subarray(steps));
    whole.set(values, kept);
    for (let i = 0; i < samples.length; i++) {
      let sum = 0;
      for (let j = 0, k = i * steps; j < taps.length; j++, k++) sum += taps[j] * whole[k];
      samples[i] = sum;
    }
    this.past = whole.slice(whole.length - taps.length);
  }
}
