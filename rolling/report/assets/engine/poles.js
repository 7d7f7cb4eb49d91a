// Poles of a ball on a contact and on the modes of a plate, all at once, with their damping.
//
// With G(p) = 1 / (M p^2) + sum gain / (p^2 + 2 zeta w p + w^2) they are the roots of
// D(p) = 1 + k (1 + tau p) G. Without damping each lies between two neighbouring modes.

const ROUNDS = 200; // of the search for poles, which takes about ten

/** Return frequency, damping and gain of ball and modes by rising frequency, the ball first. */
export function elementsOf(mass, modes) {
  const order = modes.frequency.map ? [...modes.frequency.keys()] : [];
  order.sort((i, j) => modes.frequency[i] - modes.frequency[j]);
  const elements = { w: [0], loss: [0], gain: [1 / mass] };
  const { w, loss, gain } = elements;
  for (const i of order) {
    const frequency = modes.frequency[i];
    const square = (frequency * modes.reach[i]) ** 2;
    const last = w.length - 1;
    if (square < 1e-9 / mass) continue; // a nodal line at the contact
    if (last > 0 && frequency - w[last] < 1e-9 * frequency) gain[last] += square; // equal modes are one
    else {
      w.push(frequency);
      loss.push(modes.damping[i] * frequency);
      gain.push(square);
    }
  }
  return elements;
}

/** Return G and G' at p = x + iy, and the sum of the logarithmic derivatives of the poles of G. */
function receptance({ w, loss, gain }, x, y) {
  let [gr, gi, dr, di, qr, qi] = [0, 0, 0, 0, 0, 0];
  for (let i = 0; i < w.length; i++) {
    // c = p^2 + 2 zeta w p + w^2, G += g / c, G' -= g c' / c^2, and c' / c for the poles of G.
    const cr = x * x - y * y + 2 * loss[i] * x + w[i] * w[i];
    const ci = 2 * y * (x + loss[i]);
    const square = cr * cr + ci * ci || 1e-300;
    const [ir, ii] = [cr / square, -ci / square];
    const er = 2 * (x + loss[i]);
    const [fr, fi] = [er * ir - 2 * y * ii, er * ii + 2 * y * ir];
    gr += gain[i] * ir;
    gi += gain[i] * ii;
    dr -= gain[i] * (fr * ir - fi * ii);
    di -= gain[i] * (fr * ii + fi * ir);
    qr += fr;
    qi += fi;
  }
  return [gr, gi, dr, di, qr, qi];
}

/** Return D and D' at p = x + iy from G and G'. */
function loopOf(k, tau, x, y, [gr, gi, dr, di]) {
  const [ar, ai] = [k * (1 + tau * x), k * tau * y];
  const [D, Di] = [1 + ar * gr - ai * gi, ar * gi + ai * gr];
  return [D, Di, k * tau * gr + ar * dr - ai * di, k * tau * gi + ar * di + ai * dr];
}

/** Return first poles: without damping, from the secular equation, then damped by their shares. */
function firstPoles({ w, loss, gain }, k, tau) {
  const n = w.length;
  const squares = w.map((value) => value * value);
  const total = gain.reduce((sum, value) => sum + value, 0);
  const [re, im] = [new Float64Array(n), new Float64Array(n)];
  for (let j = 0; j < n; j++) {
    let low = squares[j];
    let high = j + 1 < n ? squares[j + 1] : squares[j] + k * total;
    for (let halving = 0; halving < 50; halving++) {
      const middle = (low + high) / 2;
      let sum = 1;
      for (let i = 0; i < n; i++) sum += (k * gain[i]) / (squares[i] - middle);
      if (sum < 0) low = middle;
      else high = middle;
    }
    let [norm, damping] = [0, 0];
    for (let i = 0; i < n; i++) {
      const share = gain[i] / ((squares[i] - high) ** 2 || 1e-30 * (1 + squares[i] ** 2));
      norm += share;
      damping += share * loss[i];
    }
    re[j] = -damping / norm - tau / (2 * k * norm);
    im[j] = Math.sqrt(high);
  }
  return [re, im];
}

/**
 * Move pairs of poles to the roots of D, all at once (Aberth): a pair is complex and conjugate, or
 * real, with re + im and re - im.
 */
function settlePoles(elements, k, tau, re, im, real) {
  const n = re.length;
  const step = (j, x, y) => {
    const at = receptance(elements, x, y);
    const [hr, hi, sr, si] = loopOf(k, tau, x, y, at);
    const square = hr * hr + hi * hi;
    if (square === 0) return [0, 0];
    let ar = (sr * hr + si * hi) / square + at[4];
    let ai = (si * hr - sr * hi) / square + at[5];
    const repel = (ux, uy) => {
      const r2 = ux * ux + uy * uy;
      if (r2 === 0) return;
      ar -= ux / r2;
      ai += uy / r2;
    };
    for (let l = 0; l < n; l++) {
      if (real[l]) {
        repel(x - re[l] - im[l], y);
        repel(x - re[l] + im[l], y);
      } else {
        repel(x - re[l], y - im[l]);
        repel(x - re[l], y + im[l]);
      }
    }
    const norm = ar * ar + ai * ai;
    return norm > 0 ? [-ar / norm, ai / norm] : [0, 0];
  };
  for (let round = 0; round < ROUNDS; round++) {
    let largest = 0;
    for (let j = 0; j < n; j++) {
      const size = Math.hypot(re[j], im[j]);
      if (real[j]) {
        const upper = re[j] + im[j] + step(j, re[j] + im[j], 0)[0];
        const lower = re[j] - im[j] + step(j, re[j] - im[j], 0)[0];
        largest = Math.max(largest, Math.hypot(upper - re[j] - im[j], lower - re[j] + im[j]) / size);
        const flips = round % 20 === 19 && largest > 1e-3; // real poles that do not settle may be complex
        [re[j], im[j], real[j]] = [(upper + lower) / 2, (upper - lower) / 2 || 1e-6 * size, flips ? 0 : 1];
      } else {
        const [dx, dy] = step(j, re[j], im[j]);
        largest = Math.max(largest, Math.hypot(dx, dy) / size);
        re[j] += dx;
        im[j] += dy;
        if (!(im[j] > 0)) [im[j], real[j]] = [Math.abs(im[j]) || 1e-6 * size, 1];
      }
    }
    if (largest < 1e-13) break;
  }
}

/** Return the poles of a ball on modes, each with the residue that it and its conjugate add. */
export function modalPoles(elements, stiffness, contactTime) {
  const [re, im] = firstPoles(elements, stiffness, contactTime);
  const real = new Uint8Array(re.length);
  settlePoles(elements, stiffness, contactTime, re, im, real);
  const poles = [];
  for (let j = 0; j < re.length; j++) {
    const places = real[j] ? [[re[j] + im[j], 0], [re[j] - im[j], 0]] : [[re[j], im[j]]];
    for (const [x, y] of places) {
      const at = receptance(elements, x, y);
      const [, , sr, si] = loopOf(stiffness, contactTime, x, y, at);
      const share = (y === 0 ? 1 : 2) / (sr * sr + si * si);
      poles.push([x, y, share * (at[0] * sr + at[1] * si), share * (at[1] * sr - at[0] * si)]);
    }
  }
  return poles;
}
