// Complex arithmetic, and discrete Fourier transforms of lengths that are powers of two.

// Complex numbers are pairs [re, im].
export const plus = ([a, b], [c, d], share = 1) => [a + share * c, b + share * d];
export const times = ([a, b], [c, d]) => [a * c - b * d, a * d + b * c];

/** Return the quotient of two complex numbers. */
export function over(u, [c, d]) {
  const square = c * c + d * d || 1e-300;
  return times(u, [c / square, -d / square]);
}

const turns = new Map(); // cosine and sine of the parts of half a turn, by the number of parts

/** Return cosine and sine of half a turn in so many parts. */
function turnsOf(parts) {
  if (!turns.has(parts)) {
    const angles = Float64Array.from({ length: parts }, (_, p) => (Math.PI * p) / parts);
    turns.set(parts, { cosines: angles.map(Math.cos), sines: angles.map(Math.sin) });
  }
  return turns.get(parts);
}

/** Return the sums of x[i] exp(-2 pi i j k / n), after Stockham: every stage also sorts its values. */
function transform(re, im) {
  const { length } = re, { cosines, sines } = turnsOf(length / 2);
  let [xr, xi, yr, yi] = [re, im, new Float64Array(length), new Float64Array(length)];
  for (let half = length / 2, stride = 1; half >= 1; half /= 2, stride *= 2) {
    for (let p = 0; p < half; p++) {
      const cos = cosines[p * stride], sin = sines[p * stride];
      for (let a = p * stride; a < (p + 1) * stride; a++) {
        const b = a + half * stride, to = a + p * stride;
        const dr = xr[a] - xr[b], di = xi[a] - xi[b];
        yr[to] = xr[a] + xr[b];
        yi[to] = xi[a] + xi[b];
        yr[to + stride] = dr * cos + di * sin;
        yi[to + stride] = di * cos - dr * sin;
      }
    }
    [xr, xi, yr, yi] = [yr, yi, xr, xi];
  }
  return { re: xr, im: xi };
}

/** Return lines 0 to n - 1 of a real record, which zeros extend to n samples. */
export function linesOfRecord(record, n) {
  const re = new Float64Array(n);
  re.set(record.subarray(0, n));
  return transform(re, new Float64Array(n));
}

/** Return the real record of n samples that has given lines from 0 up, and zeros beyond. */
export function recordOfLines({ re, im }, n) {
  const [a, b] = [new Float64Array(n), new Float64Array(n)];
  for (let k = 0; k < re.length; k++) {
    const share = (k === 0 || 2 * k === n ? 1 : 2) / n; // the real part of a line stands for its mirror image
    a[k] = share * re[k];
    b[k] = -share * im[k];
  }
  return transform(a, b).re; // the real part of sum conj(x) exp(-i) is that of sum x exp(i)
}
