// Discrete Fourier transforms of lengths that are powers of two, in place.

/** Complex transform of a length that is a power of two. */
export class Transform {
  constructor(length) {
    this.length = length;
    this.places = new Uint32Array(length);
    for (let i = 1; i < length; i++) this.places[i] = (this.places[i >> 1] >> 1) | (i & 1 ? length >> 1 : 0);
    this.cos = Float64Array.from({ length: length >> 1 }, (_, k) => Math.cos((2 * Math.PI * k) / length));
    this.sin = Float64Array.from({ length: length >> 1 }, (_, k) => Math.sin((2 * Math.PI * k) / length));
  }

  /** Replace values by the sums of x[i] exp(-2 pi i j k / n). */
  forward(re, im) {
    const { length, places, cos, sin } = this;
    for (let i = 0; i < length; i++) {
      const j = places[i];
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

  /** Undo `forward`. */
  inverse(re, im) {
    this.forward(im, re);
    for (let i = 0; i < this.length; i++) {
      re[i] /= this.length;
      im[i] /= this.length;
    }
  }
}

/** Transform between a real record of a length that is a power of two and its lines from 0 up. */
export class RealTransform {
  constructor(length) {
    this.whole = new Transform(length);
    [this.re, this.im] = [new Float64Array(length), new Float64Array(length)];
  }

  /** Set lines (n/2 + 1 each) to the transform of a record (n). */
  forward(record, linesRe, linesIm) {
    this.re.set(record);
    this.im.fill(0);
    this.whole.forward(this.re, this.im);
    linesRe.set(this.re.subarray(0, linesRe.length));
    linesIm.set(this.im.subarray(0, linesIm.length));
  }

  /** Set a record (n) to the inverse transform of its lines (n/2 + 1). */
  inverse(linesRe, linesIm, record) {
    const { re, im, whole } = this;
    for (let k = 0, mirror = 0; k < linesRe.length; k++, mirror = whole.length - k) {
      [re[mirror], im[mirror]] = [linesRe[k], -linesIm[k]];
      [re[k], im[k]] = [linesRe[k], linesIm[k]];
    }
    whole.inverse(re, im);
    record.set(re);
  }
}
