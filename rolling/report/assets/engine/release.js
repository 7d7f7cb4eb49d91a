// Sound of a run without dynamics, after rolling/sound/contact_sound.py: the energy that each step
// releases becomes power by the speed, and its fluctuation within hearing becomes sound pressure.

import { BLOCK, cubic, Decimator } from "./vibration.js";
import { recordOfLines } from "./complex.js";
import { numbersOf } from "./law.js";
import { RATE } from "./rate.js";
import { AUDIBLE, IMPEDANCE } from "./radiation.js";

const FINER = 8; // values per step of the track at least, between which cubics interpolate
const SMOOTH_S = 0.02; // time constant of the factor from intensity to pressure
const MAX_RELEASE_STEPS = 16; // readings per sample

/** Return the release per metre [J/m] on a fine grid, and the mean squares of its waves summed up. */
export function prepareRelease(run) {
  const { start, length } = run.energy;
  const [re, im] = [numbersOf(run.energy.re), numbersOf(run.energy.im)];
  const waves = new Float64Array(re.length + 1); // waves[k]: of all waves below k in the track
  for (let k = 0; k < re.length; k++) waves[k + 1] = waves[k] + 2 * (re[k] ** 2 + im[k] ** 2);
  const count = 2 ** Math.ceil(Math.log2(2 * FINER * re.length));
  const fine = recordOfLines({ re, im }, count).map((value) => count * value);
  const steps = Math.min(Math.max(Math.ceil((run.limits.speed[1] * 2 * re.length) / length / RATE), 1), MAX_RELEASE_STEPS);
  const spacing = length / count;
  return { kind: "release", rate: RATE, delay: 0, responses: [Float32Array.of(1)], start, length, spacing, steps, waves, fine };
}

/** Pressure of the release at 48 kHz while the ball travels. */
export class ReleaseSource {
  constructor(run, settings, prepared) {
    Object.assign(this, { run, prepared, factor: null, extremes: {} });
    this.decimator = new Decimator(prepared.steps);
    this.powers = new Float64Array(BLOCK * prepared.steps);
    this.spread = settings.q / (4 * Math.PI * settings.distance ** 2);
  }

  /** Return the release per metre [J/m] at a position [m], by cubics through four values. */
  releaseAt(position) {
    const { fine, start, spacing } = this.prepared;
    const place = (position - start) / spacing;
    const first = Math.floor(place);
    const at = (row) => fine[(first + row) & (fine.length - 1)]; // a power of two, so that the track closes
    return cubic(at(-1), at(0), at(1), at(2), place - first);
  }

  /** Return the factor [Pa m2/W] from the fluctuation of the power at a speed [m/s] to the pressure. */
  factorAt(speed) {
    const { gain } = this.run.energy;
    if (this.run.fixed.silent) return 0;
    if (gain) return gain * this.spread;
    const { waves, length } = this.prepared;
    const line = (frequency) => Math.min(Math.ceil((frequency * length) / speed), waves.length - 1);
    const square = speed > 0 ? waves[line(AUDIBLE[1])] - waves[line(AUDIBLE[0])] : 0;
    return square > 0 ? Math.sqrt((IMPEDANCE * this.spread) / (speed * Math.sqrt(square))) : 0;
  }

  /** Set a block of samples to the pressure [Pa]. */
  block(travel, samples) {
    const { steps } = this.prepared;
    for (let i = 0; i < this.powers.length; i++) {
      const position = travel.advance(1 / (RATE * steps));
      this.powers[i] = Math.abs(travel.speed) * this.releaseAt(position);
    }
    this.decimator.process(this.powers, samples);
    const wanted = this.factorAt(Math.abs(travel.speed));
    this.factor ??= wanted;
    const share = 1 / (SMOOTH_S * RATE);
    for (let i = 0; i < BLOCK; i++) {
      this.factor += share * (wanted - this.factor);
      samples[i] *= this.factor;
    }
    this.extremes = { lowest: Math.min(...samples), highest: Math.max(...samples), flies: 0 };
  }

  get state() {
    return { force: null, height: 0 };
  }
}
