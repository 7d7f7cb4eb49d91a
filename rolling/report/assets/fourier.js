// ---- transforms ----

/** The Fourier transform of 2^k complex numbers in place, with the exponent's sign and without a factor. */
function transform(re, im, sign) {
  const n = re.length;
  for (let i = 1, j = 0; i < n; i++) {
    let bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j |= bit;
    if (i < j) [re[i], re[j], im[i], im[j]] = [re[j], re[i], im[j], im[i]];
  }
  const cos = Float64Array.from({ length: n / 2 }, (_, k) => Math.cos((2 * Math.PI * k) / n));
  const sin = Float64Array.from({ length: n / 2 }, (_, k) => sign * Math.sin((2 * Math.PI * k) / n));
  for (let half = 1; half < n; half *= 2) {
    const stride = n / (2 * half);
    for (let block = 0; block < n; block += 2 * half) {
      for (let k = 0, t = 0; k < half; k++, t += stride) {
        const a = block + k, b = a + half;
        const x = re[b] * cos[t] - im[b] * sin[t];
        const y = re[b] * sin[t] + im[b] * cos[t];
        re[b] = re[a] - x;
        im[b] = im[a] - y;
        re[a] += x;
        im[a] += y;
      }
    }
  }
}

/** Mean squares of the lines of a record of any length, by Bluestein's convolution with a chirp. */
function lineSpectrum(record) {
  const n = record.length;
  const size = 2 ** Math.ceil(Math.log2(2 * n));
  const chirp = (k, sign) => [Math.cos((Math.PI * ((k * k) % (2 * n))) / n), sign * Math.sin((Math.PI * ((k * k) % (2 * n))) / n)];
  const [re, im, cre, cim] = Array.from({ length: 4 }, () => new Float64Array(size));
  for (let k = 0; k < n; k++) {
    const [c, s] = chirp(k, -1);
    [re[k], im[k]] = [record[k] * c, record[k] * s];
    [cre[k], cim[k]] = [c, -s];
    if (k) [cre[size - k], cim[size - k]] = [c, -s];
  }
  transform(re, im, -1);
  transform(cre, cim, -1);
  for (let k = 0; k < size; k++) [re[k], im[k]] = [re[k] * cre[k] - im[k] * cim[k], re[k] * cim[k] + im[k] * cre[k]];
  transform(re, im, 1);
  const paired = (k) => (k === 0 || 2 * k === n ? 1 : 2);
  return Float64Array.from({ length: (n >> 1) + 1 }, (_, k) => (paired(k) * (re[k] ** 2 + im[k] ** 2)) / (size * n) ** 2);
}
