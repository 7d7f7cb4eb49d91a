// Simply supported rectangular plate in a baffle, after acoustics/rectangular_plate.py and
// rolling/dynamics/modes.py: its modes, as they move the contact and as a listener hears them, and the
// change of the level by those that do not move in real time.

import { linesOfRecord, over, plus } from "./complex.js";
import { MODES_HZ } from "./effort.js";
import { lossAt } from "./loss.js";
import { RATE } from "./rate.js";
import { AIR, AUDIBLE, aWeight } from "./radiation.js";
import { distances, radiationResistance, rayleighIntegrals } from "./rayleigh.js";

const BEYOND = 100; // times this: modes up to there are summed for their static compliance
const TAIL_RATIO = 1.5; // of the edges of the bands of the tail
const TAIL_DAMPING = (TAIL_RATIO ** 0.5 - TAIL_RATIO ** -0.5) / Math.PI; // its damping ratio
const TAIL_BANDS = 6;
const HEARD_LINES = 8192; // samples of the response
const MAX_LINES = 1200; // of the force

/** A thin plate by mass per area [kg/m2], bending stiffness [N m], loss factor with its curve over the frequency, and edges [m]. */
export class EdgedPlate {
  constructor({ massPerArea, bendingStiffness, lossFactor, lossCurve, length, width, computed }) {
    this.edges = [length, width];
    this.ratio = Math.sqrt(bendingStiffness / massPerArea);
    this.mobility = 1 / (8 * Math.sqrt(bendingStiffness * massPerArea)); // [s/kg] of an infinite plate
    this.modalMass = (massPerArea * length * width) / 4;
    this.computed = computed;
    this.modes = this.modesWith((w) => lossAt(lossFactor, lossCurve, w));
  }

  /** Return the modes up to the highest, with a loss factor of the plate over frequency and by their sound. */
  modesWith(lossOf) {
    const modes = this.between(0, MODES_HZ).sort((a, b) => a.w - b.w);
    for (const mode of modes) {
      mode.loss = lossOf(mode.w) + (2 * radiationResistance(this.edges, mode)) / (this.modalMass * mode.w);
    }
    return modes;
  }

  /** Return the modes above one frequency [Hz] up to another. */
  between(above, to) {
    const most = this.edges.map((edge) => (edge / Math.PI) * Math.sqrt((2 * Math.PI * to) / this.ratio));
    const modes = [];
    for (let m = 1; m <= most[0]; m++) {
      for (let n = 1; n <= most[1]; n++) {
        const w = this.ratio * (((Math.PI * m) / this.edges[0]) ** 2 + ((Math.PI * n) / this.edges[1]) ** 2);
        if (w > 2 * Math.PI * above && w <= 2 * Math.PI * to) modes.push({ m, n, w });
      }
    }
    return modes;
  }

  /** Return the shape of a mode at a point [m]. */
  shape({ m, n }, [x, y]) {
    return Math.sin((Math.PI * m * x) / this.edges[0]) * Math.sin((Math.PI * n * y) / this.edges[1]);
  }

  // Bands have the static compliance of the audible modes beyond `most`, and a tail that of all higher modes.
  /** Return frequencies [rad/s], damping ratios and reach [m/J^0.5] at a point [m] of modes, bands and tail. */
  moving(point, most = Infinity) {
    const reachOf = (mode) => this.shape(mode, point) / (mode.w * Math.sqrt(this.modalMass));
    const [kept, rest] = [this.modes.slice(0, most), this.modes.slice(most)];
    const moving = { frequency: kept.map(({ w }) => w), damping: kept.map(({ loss }) => loss / 2), reach: kept.map(reachOf) };
    const addBand = (w, compliance) => {
      moving.frequency.push(w * TAIL_RATIO ** 0.5);
      moving.damping.push(TAIL_DAMPING);
      moving.reach.push(Math.sqrt(compliance));
    };
    const edge = 2 * Math.PI * MODES_HZ, complianceOf = (modes) => modes.reduce((sum, mode) => sum + reachOf(mode) ** 2, 0);
    for (let low = rest[0]?.w; low < edge; low *= TAIL_RATIO) {
      addBand(low, complianceOf(rest.filter(({ w }) => w >= low && w < low * TAIL_RATIO)));
    }
    const beyond = this.beyond(complianceOf);
    for (let band = 0; band < TAIL_BANDS; band++) {
      const share = TAIL_RATIO ** -band - (band < TAIL_BANDS - 1 ? TAIL_RATIO ** -(band + 1) : 0);
      addBand(edge * TAIL_RATIO ** band, beyond * share);
    }
    return moving;
  }

  /** Return the static compliance [m/N] of the modes above the highest. */
  beyond(complianceOf) {
    return this.mobility / (Math.PI ** 2 * BEYOND * MODES_HZ) + complianceOf(this.between(MODES_HZ, BEYOND * MODES_HZ));
  }

  /** Return modes, their distances [m] to a listener and their pressures per stiffness force for a contact [m]. */
  radiation(contact, listener) {
    const { edges } = this;
    const size = (Math.sign(listener[2]) * AIR) / (2 * Math.PI * this.modalMass);
    const modes = this.modes.map((mode) => ({ ...mode, share: size * this.shape(mode, contact) }));
    const at = (frequency, path) => this.integrals(modes, listener, path, frequency);
    return { modes, distances: distances(edges, listener), at };
  }

  /** Return the pressures of modes per stiffness force at a frequency [Hz]. */
  integrals(modes, listener, path, frequency) {
    return rayleighIntegrals(this.edges, modes, listener, path, frequency);
  }
}

/** Return the square of the receptance [m2/N2] of ball, contact and modes at a frequency [Hz]. */
function squaredReceptance({ mass, stiffness, contactTime }, { frequency, damping, reach }, hertz) {
  const w = 2 * Math.PI * hertz;
  let sum = plus([-1 / (mass * w * w), 0], over([1 / stiffness, 0], [1, contactTime * w]));
  for (let i = 0; i < frequency.length; i++) {
    const ratio = w / frequency[i];
    sum = plus(sum, over([reach[i] ** 2, 0], [1 - ratio * ratio, 2 * damping[i] * ratio]));
  }
  return sum[0] ** 2 + sum[1] ** 2;
}

/** Return the change of LAeq [dB] between two sets of modes over a law, by the linear chain. */
export function costOfModes(law, { chain, load, speed }, response, sets) {
  const rows = 2 ** Math.ceil(Math.log2(law.rows));
  const approach = Float64Array.from({ length: rows }, (_, i) => {
    law.moveTo(law.start + (i * law.length) / rows);
    return law.approach(load);
  });
  const [track, heard] = [linesOfRecord(approach, rows), linesOfRecord(response, HEARD_LINES)];
  const square = ({ re, im }, line) => (line > 0 && 2 * line < re.length ? re[line] ** 2 + im[line] ** 2 : 0);
  const powers = [0, 0];
  const lowest = speed / law.length;
  const stride = Math.max(1, Math.ceil(AUDIBLE[1] / lowest / MAX_LINES));
  for (let k = Math.ceil(AUDIBLE[0] / lowest); k * lowest < AUDIBLE[1]; k += stride) {
    const f = k * lowest;
    const power = square(track, k) * square(heard, Math.round((f * HEARD_LINES) / RATE)) * aWeight(f) ** 2;
    if (power > 0) sets.forEach((modes, i) => (powers[i] += power / squaredReceptance(chain, modes, f)));
  }
  return powers[0] > 0 ? Math.abs(10 * Math.log10(powers[0] / powers[1])) : 0;
}
