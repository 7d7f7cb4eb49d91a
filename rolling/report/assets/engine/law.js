// Force law of a track: contact force of place and approach, read from the data of a run.
//
// At a place the slope g = da/ds of the approach a over s = F^(2/3) is a broken line over `breaks`,
// constant beyond the last. Along the track, lift-off and slopes are periodic cubic splines.

/** Return the numbers of a stored array {type, base64, scale, offset}, of type int16 or float32. */
export function numbersOf({ type, base64, scale, offset }) {
  const { buffer } = Uint8Array.from(atob(base64), (byte) => byte.charCodeAt(0));
  const stored = type === "float32" ? new Float32Array(buffer) : new Int16Array(buffer);
  return Float64Array.from(stored, (value) => offset + scale * value);
}

const BACK = 2 - Math.sqrt(3); // ratio of the weights of successive rows in the slope of a cubic spline
const REACH = 28; // rows with a weight: BACK^28 = 1e-16

/** Return the derivatives per row of the periodic cubic spline through a column. */
function splineSlopes(column) {
  const n = column.length;
  return column.map((_, i) => {
    let slope = 0;
    for (let m = 1, weight = 3 * BACK; m <= REACH; m++, weight *= -BACK) {
      slope += weight * (column[(i + m) % n] - column[(i + n * REACH - m) % n]);
    }
    return slope;
  });
}

/** Return the table of a stored law: arrays that a worker can transfer, row by row. */
export function lawTable({ start, spacing, breaks, columns }) {
  const stored = columns.map(numbersOf);
  const count = stored.length;
  const rows = Math.max(...stored.map((column) => column.length)); // a constant column has one row
  const values = new Float64Array(rows * count);
  const slopes = new Float64Array(rows * count);
  stored.forEach((column, j) => {
    const own = splineSlopes(column);
    for (let i = 0; i < rows; i++) {
      const k = column.length > 1 ? i : 0;
      const steepest = j > 0 ? 3 * column[k] : Infinity; // up to which a cubic between rows stays positive
      values[i * count + j] = column[k];
      slopes[i * count + j] = Math.max(-steepest, Math.min(steepest, own[k]));
    }
  });
  return { start, spacing, breaks: Float64Array.from(breaks), values, slopes };
}

/** Force law at one place at a time. */
export class ForceLaw {
  constructor({ start, spacing, breaks, values, slopes }) {
    Object.assign(this, { start, spacing, breaks, values, slopes });
    this.columns = breaks.length + 1;
    this.rows = values.length / this.columns; // the first row follows the last
    this.law = new Float64Array(this.columns); // at the present place
    this.at = new Float64Array(breaks.length); // approach at each break at the present place
    this.length = this.rows * spacing; // [m] of the closed track
    this.liftOff = 0; // [m] approach at the present place
    this.stiffness = 0; // [N/m] at the last force
    this.moveTo(start);
  }

  /** Go to a position [m] by cubics of Hermite between the rows. */
  moveTo(position) {
    const { columns, values, slopes, law, at, breaks } = this;
    let t = (position - this.start) / this.spacing;
    t -= this.rows * Math.floor(t / this.rows);
    const i = Math.min(Math.floor(t), this.rows - 1);
    t -= i;
    const h01 = t * t * (3 - 2 * t);
    const h10 = t * (t - 1) * (t - 1);
    const h11 = t * t * (t - 1);
    const first = i * columns;
    const next = i + 1 < this.rows ? first + columns : 0;
    for (let j = 0; j < columns; j++) {
      const p = first + j;
      const q = next + j;
      law[j] = values[p] + h01 * (values[q] - values[p]) + h10 * slopes[p] + h11 * slopes[q];
    }
    this.liftOff = at[0] = law[0];
    for (let p = 1; p < breaks.length; p++) at[p] = at[p - 1] + 0.5 * (law[p] + law[p + 1]) * (breaks[p] - breaks[p - 1]);
  }

  /** Return the change of the slope over s beyond a break, zero beyond the last. */
  bend(p) {
    const { breaks, law } = this;
    return p < breaks.length - 1 ? (law[p + 2] - law[p + 1]) / (breaks[p + 1] - breaks[p]) : 0;
  }

  /** Return the approach [m] under a force [N] at the present place. */
  approach(force) {
    const { breaks, law, at } = this;
    const s = Math.cbrt(force) ** 2;
    let p = breaks.length - 1;
    while (p > 0 && s < breaks[p]) p--;
    return at[p] + (s - breaks[p]) * (law[p + 1] + 0.5 * this.bend(p) * (s - breaks[p]));
  }

  /** Return the force [N] at an approach [m] at the present place, and set the stiffness there. */
  force(approach) {
    const { breaks, law, at } = this;
    if (!(approach > at[0])) {
      this.stiffness = 0;
      return 0;
    }
    let p = breaks.length - 1;
    while (approach < at[p]) p--;
    const left = approach - at[p];
    const g = law[p + 1];
    const root = Math.sqrt(Math.max(g * g + 2 * this.bend(p) * left, 0));
    const sigma = Math.sqrt(breaks[p] + (2 * left) / (g + root));
    this.stiffness = (1.5 * sigma) / root;
    return sigma * sigma * sigma;
  }

  /** Return the stiffness [N/m] of the mean compliance along the track under a load [N]. */
  meanStiffness(load) {
    let compliance = 0;
    for (let i = 0; i < this.rows; i++) {
      this.moveTo(this.start + i * this.spacing);
      this.force(this.approach(load));
      compliance += 1 / this.stiffness;
    }
    return this.rows / compliance;
  }
}
