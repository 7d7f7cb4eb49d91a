// Simply supported rectangular plate in a baffle, after acoustics/rectangular_plate.py and
// rolling/dynamics/modes.py: its modes, as they move the contact and as a listener hears them.

import { AIR, SOUND } from "./radiation.js";
import { POINTS, radiationResistance, rayleighTable } from "./rayleigh.js";

export const MODES_HZ = 30e3; // highest natural frequency of the modes that move
const BEYOND = 100; // times this: modes up to there are summed for their static compliance
export const TAIL_RATIO = 1.5; // of the edges of the bands of the tail
export const TAIL_DAMPING = (TAIL_RATIO ** 0.5 - TAIL_RATIO ** -0.5) / Math.PI; // its damping ratio
const TAIL_BANDS = 6;

/** A thin plate by mass per area [kg/m2], bending stiffness [N m], loss factor and edges [m]. */
export class EdgedPlate {
  constructor({ massPerArea, bendingStiffness, lossFactor, length, width }) {
    this.edges = [length, width];
    this.ratio = Math.sqrt(bendingStiffness / massPerArea);
    this.mobility = 1 / (8 * Math.sqrt(bendingStiffness * massPerArea)); // [s/kg] of an infinite plate
    this.modalMass = (massPerArea * length * width) / 4;
    this.modes = this.between(0, MODES_HZ);
    for (const mode of this.modes) {
      mode.loss = lossFactor + (2 * radiationResistance(this.edges, mode)) / (this.modalMass * mode.w);
    }
  }

  /** Return the modes above one frequency [Hz] up to another, by rising frequency. */
  between(above, to) {
    const most = this.edges.map((edge) => (edge / Math.PI) * Math.sqrt((2 * Math.PI * to) / this.ratio));
    const modes = [];
    for (let m = 1; m <= most[0]; m++) {
      for (let n = 1; n <= most[1]; n++) {
        const w = this.ratio * (((Math.PI * m) / this.edges[0]) ** 2 + ((Math.PI * n) / this.edges[1]) ** 2);
        if (w > 2 * Math.PI * above && w <= 2 * Math.PI * to) modes.push({ m, n, w });
      }
    }
    return modes.sort((a, b) => a.w - b.w);
  }

  /** Return the shape of a mode at a point [m]. */
  shape({ m, n }, [x, y]) {
    return Math.sin((Math.PI * m * x) / this.edges[0]) * Math.sin((Math.PI * n * y) / this.edges[1]);
  }

  /** Return frequencies [rad/s], damping ratios and reach [m/J^0.5] at a point [m] of the modes, then of their tail. */
  moving(point) {
    const frequency = this.modes.map(({ w }) => w);
    const damping = this.modes.map(({ loss }) => loss / 2);
    const reach = this.modes.map((mode) => this.shape(mode, point) / (mode.w * Math.sqrt(this.modalMass)));
    let beyond = this.mobility / (Math.PI ** 2 * BEYOND * MODES_HZ);
    for (const mode of this.between(MODES_HZ, BEYOND * MODES_HZ)) beyond += (this.shape(mode, point) / mode.w) ** 2 / this.modalMass;
    for (let band = 0; band < TAIL_BANDS; band++) {
      const share = TAIL_RATIO ** -band - (band < TAIL_BANDS - 1 ? TAIL_RATIO ** -(band + 1) : 0);
      frequency.push(2 * Math.PI * MODES_HZ * TAIL_RATIO ** (band + 0.5));
      damping.push(TAIL_DAMPING);
      reach.push(Math.sqrt(beyond * share));
    }
    return { frequency, damping, reach, own: this.modes.length };
  }

  /** Return the sound of the modes at a listener for a force at a contact point [m]. */
  radiation(contact, listener) {
    return new ModalRadiation(this, contact, listener);
  }
}

/** Pressure per contact force at a listener, as lines over frequency and as modes that ring. */
class ModalRadiation {
  constructor(plate, contact, listener) {
    const table = rayleighTable(plate.edges, plate.modes, listener);
    const size = (Math.sign(listener[2]) * AIR) / (2 * Math.PI * plate.modalMass);
    Object.assign(this, { table, modes: plate.modes, nearest: table.nearest });
    this.shapes = Float64Array.from(plate.modes, (mode) => size * plate.shape(mode, contact));
    this.weights = { re: new Float64Array(POINTS), im: new Float64Array(POINTS) };
  }

  /** Set Lagrange's weights at a frequency re + i im [Hz] of the table; return its first row. */
  interpolate(re, im) {
    const { table, weights } = this;
    const place = Math.min(re / table.step, table.rows.length - 1);
    const first = Math.min(Math.max(Math.floor(place) - POINTS / 2 + 1, 0), table.rows.length - POINTS);
    for (let i = 0; i < POINTS; i++) {
      let [a, b] = [1, 0];
      for (let j = 0; j < POINTS; j++) {
        if (j === i) continue;
        const [c, d] = [(place - first - j) / (i - j), im / table.step / (i - j)];
        [a, b] = [a * c - b * d, a * d + b * c];
      }
      weights.re[i] = a;
      weights.im[i] = b;
    }
    return first;
  }

  /** Return the pressure [re, im] of modes [first, last) of given answers, at w [rad/s], without the delay of a path [m]. */
  combine(wr, wi, path, answers, begin, end) {
    const start = this.interpolate(wr / (2 * Math.PI), wi / (2 * Math.PI));
    let [tr, ti] = [0, 0];
    for (let j = 0; j < POINTS; j++) {
      const row = this.table.rows[start + j];
      let [sr, si] = [0, 0];
      for (let i = begin; i < end; i++) {
        sr += answers.re[i] * row.re[i] - answers.im[i] * row.im[i];
        si += answers.re[i] * row.im[i] + answers.im[i] * row.re[i];
      }
      tr += this.weights.re[j] * sr - this.weights.im[j] * si;
      ti += this.weights.re[j] * si + this.weights.im[j] * sr;
    }
    const delay = (this.table.middle - path) / SOUND;
    const size = Math.exp(wi * delay);
    const [cr, ci] = [size * Math.cos(wr * delay), -size * Math.sin(wr * delay)];
    const [dr, di] = [tr * cr - ti * ci, tr * ci + ti * cr];
    const [xr, xi] = [wr * wr - wi * wi, 2 * wr * wi];
    return [dr * xr - di * xi, dr * xi + di * xr];
  }

  /** Set lines i * step [Hz] below a limit to the pressure [Pa/N] of phasors that grow as exp(growth t). */
  lines(step, limit, growth, path) {
    const count = this.modes.length;
    const answers = { re: new Float64Array(count), im: new Float64Array(count) };
    const lines = { re: new Float64Array(Math.ceil(limit / step)), im: new Float64Array(Math.ceil(limit / step)) };
    const wi = -growth;
    for (let line = 0; line < lines.re.length; line++) {
      const wr = 2 * Math.PI * line * step;
      for (let i = 0; i < count; i++) {
        const { w, loss } = this.modes[i];
        const cr = w * w - wr * wr + wi * wi - loss * w * wi;
        const ci = -2 * wr * wi + loss * w * wr;
        const share = this.shapes[i] / (cr * cr + ci * ci);
        answers.re[i] = share * cr;
        answers.im[i] = -share * ci;
      }
      [lines.re[line], lines.im[line]] = this.combine(wr, wi, path, answers, 0, count);
    }
    return lines;
  }

  /** Return modes as they ring at last: re(amplitude exp((i w - decay) t)) [Pa/(N s)]. */
  rings(path) {
    const count = this.modes.length;
    const answers = { re: new Float64Array(count), im: new Float64Array(count) };
    return this.modes.map(({ w, loss }, i) => {
      const [wr, wi] = [w * Math.sqrt(1 - (loss * loss) / 4), (w * loss) / 2];
      answers.im[i] = -this.shapes[i] / wr; // 2 i times the residue 1 / -(2 wr)
      const [re, im] = this.combine(wr, wi, path, answers, i, i + 1);
      return { w: wr, decay: wi, re, im };
    });
  }
}
