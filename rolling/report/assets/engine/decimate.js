// From engine steps to samples: a symmetric low-pass to 48 kHz.

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
