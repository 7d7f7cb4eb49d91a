// Discrete Fourier transforms of lengths that are powers of two.

/** Replace values by the sums of x[i] exp(-2 pi i j k / n). */
function transform(re, im) {
  const { length } = re;
  const [cos, sin] = [Math.cos, Math.sin].map((wave) => Float64Array.from({ length: length / 2 }, (_, k) => wave((2 * Math.PI * k) / length)));
  for (let i = 1, j = 0; i < length; i++) {
    let bit = length / 2;
    for (; j & bit; bit /= 2) j ^= bit;
    j ^= bit; // i with its bits in reverse
    if (j > i) {
      [re[i], re[j]] = [re[j], re[i]];
      [im[i], im[j]] = [im[j], im[i]];
    }
  }
  for (let half = 1; half < length; half *= 2) {
    const stride = length / (2 * half);
    for (let first = 0; first < length; first += 2 * half) {
      for (let i = first, k = 0; i < first + half; i++, k += stride) {
        const j = i + half;
        const a = re[j] * cos[k] + im[j] * sin[k];
        const b = im[j] * cos[k] - re[j] * sin[k];
        re[j] = re[i] - a;
        im[j] = im[i] - b;
        re[i] += a;
        im[i] += b;
      }
    }
  }
}

/** Return lines 0 to n/2 of a real record, which zeros extend to n samples. */
export function linesOfRecord(record, n) {
  const [re, im] = [new Float64Array(n), new Float64Array(n)];
  re.set(record.subarray(0, n));
  transform(re, im);
  return { re: re.subarray(0, n / 2 + 1), im: im.subarray(0, n / 2 + 1) };
}

/** Return the real record of n samples that has given lines from 0 up, and zeros beyond. */
export function recordOfLines({ re, im }, n) {
  const [a, b] = [new Float64Array(n), new Float64Array(n)];
  for (let k = 0; k < re.length; k++) {
    const share = (k === 0 || 2 * k === n ? 1 : 2) / n; // the real part of a line stands for its mirror image
    a[k] = share * re[k];
    b[k] = -share * im[k];
  }
  transform(a, b); // the real part of sum conj(x) exp(-i) is that of sum x exp(i)
  return a;
}
