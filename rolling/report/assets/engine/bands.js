// Levels of a sound pressure, after acoustics/level.py: A-weighting as a curve over frequency and as
// a filter in time, third octaves and LAeq of a record, and the Fast level of a stream.

import { realLines } from "./fft.js";

const REFERENCE_PA = 20e-6;
const FAST_S = 0.125;
const FILTER = 48; // coefficients of the weighting filter on either side
const SILENT = 1e-20; // share of a record that counts as rounding
export const THIRD_OCTAVES = [
  ...[20, 25, 31.5, 40, 50, 63, 80, 100, 125, 160, 200, 250, 315, 400, 500, 630, 800],
  ...[1000, 1250, 1600, 2000, 2500, 3150, 4000, 5000, 6300, 8000, 10000, 12500, 16000, 20000],
];
const THIRD_EDGES = Array.from({ length: 32 }, (_, i) => 10 ** ((25 + 2 * i) / 20));

/** Return the poles [Hz] of the A-weighting, two of them double, after IEC 61672-1, annex E. */
function weightingPoles() {
  const [low, high] = [10 ** 1.5, 10 ** 3.9];
  const d = Math.SQRT1_2;
  const c = (low * high) ** 2;
  const b = (1e6 + c / 1e6 - d * (low ** 2 + high ** 2)) / (1 - d);
  const root = Math.sqrt(b * b - 4 * c);
  const a = 10 ** 2.45;
  return [Math.sqrt((-b - root) / 2), ((3 - Math.sqrt(5)) / 2) * a, ((3 + Math.sqrt(5)) / 2) * a, Math.sqrt((-b + root) / 2)];
}
const POLES = weightingPoles();

function unscaledWeight(frequency) {
  const [f1, f2, f3, f4] = POLES.map((pole) => pole * pole);
  const f = frequency * frequency;
  return (f * f * f4) / ((f + f1) * Math.sqrt((f + f2) * (f + f3)) * (f + f4));
}

/** Return the factor of the A-weighting on a pressure at a frequency [Hz]. */
export function aWeight(frequency) {
  return unscaledWeight(frequency) / unscaledWeight(1000);
}

/** Return the level [dB] of a mean square [Pa2], null for silence. */
export function levelOf(meanSquare) {
  return meanSquare > 0 ? 10 * Math.log10(meanSquare / REFERENCE_PA ** 2) : null;
}

/** Return LZeq, LAeq and third octaves, Z and A, [dB] of a closed or faded record; null for silence. */
export function soundLevels(record, rate) {
  const n = record.length;
  const { re, im } = realLines(record);
  const [bands, weighted] = [new Float64Array(31), new Float64Array(31)];
  let [whole, wholeA] = [0, 0];
  for (let line = 0; line < re.length; line++) {
    const frequency = (line * rate) / n;
    const square = ((line === 0 || 2 * line === n ? 1 : 2) * (re[line] ** 2 + im[line] ** 2)) / n ** 2;
    const squareA = square * aWeight(frequency) ** 2;
    whole += square;
    wholeA += squareA;
    if (!(frequency >= THIRD_EDGES[0] && frequency < THIRD_EDGES[31])) continue;
    let band = Math.floor(10 * Math.log10(frequency) - 12.5);
    if (frequency < THIRD_EDGES[band]) band--;
    else if (frequency >= THIRD_EDGES[band + 1]) band++;
    bands[band] += square;
    weighted[band] += squareA;
  }
  const heard = (value) => (value > SILENT * whole ? levelOf(value) : null);
  return { level: heard(whole), laeq: heard(wholeA), bands: Array.from(bands, heard), weighted: Array.from(weighted, heard) };
}

/** Filter of the A-weighting: poles below 1 kHz by recursion, the rest by a symmetric filter. */
export class AWeighting {
  constructor(rate) {
    this.poles = [POLES[0], POLES[0], POLES[1], POLES[2]].map((pole) => Math.exp((-2 * Math.PI * pole) / rate));
    this.before = new Float64Array(8); // last input and output of each section
    const wanted = (frequency) => {
      const f = Math.max(frequency, 1);
      const w = (2 * Math.PI * f) / rate;
      const gain = (pole) => (2 * Math.sin(w / 2)) / Math.hypot(1 - pole * Math.cos(w), pole * Math.sin(w));
      return this.poles.reduce((weight, pole) => weight / gain(pole), aWeight(f));
    };
    const grid = 1024;
    this.taps = new Float64Array(2 * FILTER + 1);
    for (let lag = 0; lag <= FILTER; lag++) {
      let sum = (wanted(0) + wanted(rate / 2) * Math.cos(Math.PI * lag)) / 2;
      for (let i = 1; i < grid; i++) sum += wanted((i * rate) / (2 * grid)) * Math.cos((Math.PI * i * lag) / grid);
      const window = Math.cos((Math.PI * lag) / (2 * FILTER + 2)) ** 2;
      this.taps[FILTER + lag] = this.taps[FILTER - lag] = (sum * window) / grid;
    }
    this.past = new Float64Array(2 * this.taps.length);
    this.next = 0;
  }

  /** Return the weighted pressure for the next sample, later by FILTER samples. */
  advance(pressure) {
    const { poles, before, taps, past } = this;
    let value = pressure;
    for (let i = 0; i < 4; i++) {
      const output = value - before[2 * i] + poles[i] * before[2 * i + 1];
      before[2 * i] = value;
      value = before[2 * i + 1] = output;
    }
    const n = taps.length;
    past[this.next] = past[this.next + n] = value;
    this.next = (this.next + 1) % n;
    let sum = 0;
    for (let i = 0; i < n; i++) sum += taps[i] * past[this.next + i];
    return sum;
  }
}

/** Sound level meter of a stream: Fast level, and LAeq since the beginning, both in dB(A). */
export class SoundMeter {
  constructor(rate) {
    this.weighting = new AWeighting(rate);
    this.keep = Math.exp(-1 / (rate * FAST_S));
    this.square = this.total = this.count = 0;
  }

  /** Take the next pressures [Pa]. */
  take(pressures) {
    for (let i = 0; i < pressures.length; i++) {
      const square = this.weighting.advance(pressures[i]) ** 2;
      this.square += (1 - this.keep) * (square - this.square);
      this.total += square;
    }
    this.count += pressures.length;
  }

  get fast() {
    return levelOf(this.square);
  }

  get laeq() {
    return levelOf(this.total / this.count);
  }
}
