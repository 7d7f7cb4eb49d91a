// Plate with free or clamped edges in a baffle, after acoustics/ritz_plate.py. The page holds the modes of
// its side ratio, as sums of products of functions along both sides: the shapes of beams.

import { numbersOf } from "./law.js";
import { MODES_HZ } from "./effort.js";
import { EdgedPlate } from "./plate.js";
import { AIR, SOUND } from "./radiation.js";
import { integralsOfProducts } from "./rayleigh.js";

const SUPPORT_HZ = 2; // natural frequency of a free plate on its soft support, at most
const BELOW_BENDING = 20; // of the lowest bending mode over that of the rigid-body motions, at least
const SUPPORT_LOSS = 2; // critical damping

/** Return stored modes with their numbers as arrays. */
export function computedModes(stored) {
  const arrays = Object.fromEntries(["numbers", "places", "values", "efficiencies"].map((name) => [name, numbersOf(stored[name])]));
  return { ...stored, ...arrays, beams: stored.beams.map(numbersOf) };
}

/** Return Legendre functions at a place from -1 to 1, orthonormal, of so many degrees; see SideFunctions. */
function legendreFunctions(count, power, x) {
  const shift = 2 * power;
  let weight = 0.5; // of a constant
  for (let i = 1; i <= shift; i++) weight *= (i + 0.5) / i;
  const values = new Float64Array(count);
  values[0] = Math.sqrt(weight) * (1 - x * x) ** power;
  for (let i = 1, before = 0; i < count; i++) {
    const factor = Math.sqrt((i * (i + 2 * shift)) / ((2 * i + 2 * shift) ** 2 - 1));
    values[i] = (x * values[i - 1] - (i > 1 ? before * values[i - 2] : 0)) / factor;
    before = factor;
  }
  return values;
}

/** Plate whose shapes stand in `computed`. */
export class ComputedPlate extends EdgedPlate {
  modesWith(lossOf) {
    const { numbers, starts, rigid } = this.computed;
    const area = this.edges[0] * this.edges[1];
    const support = Math.min(2 * Math.PI * SUPPORT_HZ, ((numbers[rigid] ?? Infinity) * this.ratio) / area / BELOW_BENDING);
    this.functions = [new Map(), new Map()];
    const modes = [];
    numbers.forEach((number, i) => {
      const w = i < rigid ? support : (number * this.ratio) / area;
      if (w > 2 * Math.PI * MODES_HZ) return;
      const bySound = (2 * this.efficiency(i, (w / SOUND) * Math.sqrt(area)) * AIR * SOUND * area) / 4 / (this.modalMass * w);
      modes.push({ w, loss: i < rigid ? SUPPORT_LOSS : lossOf(w) + bySound, first: starts[i], last: starts[i + 1] });
    });
    return modes;
  }

  /** Return the radiation efficiency of a mode at a wave number times the root of the area. */
  efficiency(mode, phase) {
    const { efficiencies, phases } = this.computed;
    const count = efficiencies.length / this.computed.numbers.length;
    const step = Math.log(phases[1] / phases[0]) / (count - 1);
    const place = Math.min(Math.max(Math.log(phase / phases[0]) / step, 0), count - 1 - 1e-9);
    const row = Math.floor(place), at = mode * count + row;
    return Math.exp(efficiencies[at] + (place - row) * (efficiencies[at + 1] - efficiencies[at]));
  }

  /** Return the shapes of beams of a side at nodes [m], each an array over the nodes. */
  beamsAt(side, nodes) {
    const { counts, powers, beams } = this.computed;
    const count = counts[side];
    const values = nodes.map((node) => legendreFunctions(count, powers[side], (2 * node) / this.edges[side] - 1));
    return Array.from({ length: count }, (_, beam) => Float64Array.from(values, (own) => {
      let sum = 0;
      for (let i = beam % 2; i < count; i += 2) sum += beams[side][i * count + beam] * own[i];
      return sum;
    }));
  }

  shape({ first, last }, [x, y]) {
    const [along, across] = [this.beamsAt(0, [x]), this.beamsAt(1, [y])];
    return this.sumOf(first, last, (m, n) => along[m][0] * across[n][0]);
  }

  /** Return the sum over the products of a mode of its coefficients times a number. */
  sumOf(first, last, numberOf) {
    const { places, values, counts } = this.computed;
    let sum = 0;
    for (let i = first; i < last; i++) {
      const place = Math.round(places[i]);
      sum += values[i] * numberOf(Math.floor(place / counts[1]), place % counts[1]);
    }
    return sum;
  }

  beyond() {
    return this.mobility / (Math.PI ** 2 * MODES_HZ);
  }

  integrals(modes, listener, path, frequency) {
    const beamsAt = (side, nodes) => {
      const kept = this.functions[side];
      if (!kept.has(nodes.length)) kept.set(nodes.length, this.beamsAt(side, nodes));
      return kept.get(nodes.length);
    };
    const { counts } = this.computed;
    const integralOf = integralsOfProducts(this.edges, counts, beamsAt, listener, path, frequency);
    const [real, imaginary] = [new Float64Array(counts[0] * counts[1]), new Float64Array(counts[0] * counts[1])];
    for (let m = 0; m < counts[0]; m++) {
      for (let n = 0; n < counts[1]; n++) [real[m * counts[1] + n], imaginary[m * counts[1] + n]] = integralOf(m, n);
    }
    return modes.map(({ first, last, share }) => [
      share * this.sumOf(first, last, (m, n) => real[m * counts[1] + n]),
      share * this.sumOf(first, last, (m, n) => imaginary[m * counts[1] + n]),
    ]);
  }
}
