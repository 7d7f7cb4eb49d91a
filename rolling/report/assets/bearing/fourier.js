// Fourier transform of a power of two of samples, and what is read from a narrow spectrum.

/** Transform complex samples in place; their number is a power of two. */
function transform(real, imaginary) {
  const count = real.length;
  for (let place = 1, mirrored = 0; place < count; place++) {
    let bit = count >> 1;
    for (; mirrored & bit; bit >>= 1) mirrored ^= bit;
    mirrored ^= bit;
    if (place < mirrored) {
      [real[place], real[mirrored]] = [real[mirrored], real[place]];
      [imaginary[place], imaginary[mirrored]] = [imaginary[mirrored], imaginary[place]];
    }
  }
  for (let length = 2; length <= count; length *= 2) {
    const half = length / 2;
    for (let wave = 0; wave < half; wave++) {
      const angle = (-2 * Math.PI * wave) / length;
      const c = Math.cos(angle);
      const s = Math.sin(angle);
      for (let even = wave; even < count; even += length) {
        const odd = even + half;
        const re = c * real[odd] - s * imaginary[odd];
        const im = c * imaginary[odd] + s * real[odd];
        real[odd] = real[even] - re;
        imaginary[odd] = imaginary[even] - im;
        real[even] += re;
        imaginary[even] += im;
      }
    }
  }
}

/** Return the rms of a tone at each line of a record under a Hann window, from 0 Hz to the middle.
 *
 * Samples are means over the time from one to the next, which lower a tone; the lines are raised by as much. */
export function narrowSpectrum(record) {
  const count = record.length;
  let mean = 0;
  for (const value of record) mean += value / count;
  const real = new Float64Array(count);
  const imaginary = new Float64Array(count);
  for (let n = 0; n < count; n++) real[n] = (record[n] - mean) * (0.5 - 0.5 * Math.cos((2 * Math.PI * n) / count));
  transform(real, imaginary);
  const rms = new Float64Array(count / 2 + 1);
  for (let line = 0; line < rms.length; line++) {
    const phase = (Math.PI * line) / count;
    const lowered = phase > 0 ? Math.sin(phase) / phase : 1;
    rms[line] = ((2 * Math.hypot(real[line], imaginary[line])) / (0.5 * count * lowered)) * Math.SQRT1_2;
  }
  return rms;
}

const HANN_BANDWIDTH = 1.5; // lines

/** Return the rms of a band of a narrow spectrum whose lines are `width` Hz apart. */
export function bandRms(rms, width, [low, high]) {
  let square = 0;
  for (let line = Math.ceil(low / width); line < Math.min(high / width, rms.length); line++) square += rms[line] ** 2;
  return Math.sqrt(square / HANN_BANDWIDTH);
}
