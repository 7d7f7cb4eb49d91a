// A pole p of a linear chain over a time step, moved exactly under a source that is a line or a parabola.

const FASTEST = 1.5; // phase of a pole in a step, beyond which it has no inertia,
const SHARP = 0.1; // if its damping over its frequency is less

/** Return phi_1, phi_2, phi_3 at z = x + iy, the moments of exp(z t) over a step, as pairs. */
function moments(x, y) {
  const phi = [];
  if (Math.hypot(x, y) < 1) {
    for (let order = 1; order <= 3; order++) {
      let [sr, si, tr, ti] = [0, 0, 1 / (order > 2 ? 6 : order), 0];
      for (let n = 1; n < 20; n++) {
        sr += tr;
        si += ti;
        [tr, ti] = [(tr * x - ti * y) / (n + order), (tr * y + ti * x) / (n + order)];
      }
      phi.push([sr, si]);
    }
    return phi;
  }
  const square = x * x + y * y;
  let [ar, ai] = [Math.exp(x) * Math.cos(y), Math.exp(x) * Math.sin(y)];
  for (const constant of [1, 1, 0.5]) {
    ar -= constant;
    [ar, ai] = [(ar * x + ai * y) / square, (ai * x - ar * y) / square];
    phi.push([ar, ai]);
  }
  return phi;
}

/** Return the product of two complex numbers. */
export const times = (ar, ai, br, bi) => [ar * br - ai * bi, ar * bi + ai * br];

/**
 * Return the weights of the source on a pole of a chain in a step [s], times its residue: `first` of
 * a constant, `second` of a rise within the step, `bend` of a second difference; `turn` is exp(p t).
 */
export function heldPole({ re, im, residueRe, residueIm }, j, step) {
  const [x, y] = [re[j] * step, im[j] * step];
  const fast = y > FASTEST && -x < SHARP * y; // then the pole follows the source at once
  const still = times(-x, y, 1 / (x * x + y * y), 0);
  const moved = fast ? [still, still, [still[0] / 2, still[1] / 2]] : moments(x, y);
  const [first, second, third] = moved.map((pair) => times(...pair, step * residueRe[j], step * residueIm[j]));
  const bend = [third[0] - second[0] / 2, third[1] - second[1] / 2];
  const turn = fast ? [0, 0] : [Math.exp(x) * Math.cos(y), Math.exp(x) * Math.sin(y)];
  return { first, second, bend, turn };
}
