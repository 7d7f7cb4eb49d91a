// The spectrogram of a record: A-weighted levels by column and by twelfth of an octave.

import { linesOfRecord } from "./complex.js";
import { ACROSS, LONGEST, LOW_HZ, RANGE_DB, ROWS, ROWS_PER_OCTAVE, longestOf, middleOf } from "./picture_rows.js";
import { aWeight } from "./radiation.js";
import { RATE } from "./rate.js";

// Sizes of the windows, long ones for low frequencies and short ones for high ones, as the ear resolves them, with the frequency up to which each is taken.
const WINDOWS = [{ size: LONGEST, below: 250 }, { size: 2048, below: 2000 }, { size: 512, below: Infinity }];

/** Return levels from 0 (quiet) to 255 (the maximum) by column and row; `tell` hears which share is done. */
export function spectrogramOf(samples, tell) {
  const powers = new Float64Array(ACROSS * ROWS), longest = longestOf(samples.length);
  const parts = WINDOWS.map(({ size, below }) => ({ size: Math.min(size, longest), below }));
  const work = parts.map(({ size }) => 1 / size), whole = work.reduce((a, b) => a + b); // windows are as many as they are short
  let [from, done] = [0, 0];
  parts.forEach(({ size, below }, part) => {
    const rows = Array.from({ length: ROWS }, (_, row) => row).filter((row) => middleOf(row) >= from && middleOf(row) < below);
    addRows(powers, samples, size, rows, (share) => tell((done + share * work[part]) / whole));
    done += work[part];
    from = below;
  });
  const most = powers.reduce((a, b) => Math.max(a, b), 0);
  return Uint8Array.from(powers, (power) => Math.round(255 * Math.max(0, 1 + (10 * Math.log10(power / most)) / RANGE_DB)) || 0);
}

/** Add the A-weighted power of rows to a spectrogram, from windows of one size. */
function addRows(powers, samples, size, rows, tell) {
  const hop = size / 4, frames = Math.ceil(samples.length / hop) + 1, byFrame = [];
  const shape = Float64Array.from({ length: size }, (_, i) => Math.sin((Math.PI * (i + 0.5)) / size) ** 2);
  for (let frame = 0; frame < frames; frame++) {
    byFrame.push(rowsOfFrame(samples, frame * hop - size / 2, shape, rows));
    tell(frame / frames);
  }
  for (let column = 0; column < ACROSS; column++) {
    const [begin, end] = [column, column + 1].map((edge) => (edge * samples.length) / ACROSS / hop);
    const first = Math.floor(begin), last = Math.min(frames - 1, Math.ceil(end));
    rows.forEach((row, k) => {
      let sum = 0;
      for (let frame = first; frame <= last; frame++) sum += byFrame[frame][k];
      powers[column * ROWS + row] = sum / (last - first + 1);
    });
  }
}

/** Return the A-weighted power of rows in a window that begins at a sample, zero outside the record. */
function rowsOfFrame(samples, first, shape, rows) {
  const size = shape.length, windowed = new Float64Array(size);
  for (let i = Math.max(0, -first); i < Math.min(size, samples.length - first); i++) windowed[i] = shape[i] * samples[first + i];
  const { re, im } = linesOfRecord(windowed, size), sums = new Float64Array(size / 2 + 1); // over the lines below each
  for (let line = 0; line < size / 2; line++) sums[line + 1] = sums[line] + re[line] ** 2 + im[line] ** 2;
  const upTo = (hertz) => { // a line reaches half its distance to either side
    const place = Math.min(size / 2 - 1e-9, (hertz * size) / RATE + 0.5), line = Math.floor(place);
    return sums[line] + (place - line) * (sums[line + 1] - sums[line]);
  };
  return rows.map((row) => {
    const [from, to] = [row, row + 1].map((edge) => LOW_HZ * 2 ** (edge / ROWS_PER_OCTAVE));
    return ((upTo(to) - upTo(from)) / size ** 2) * aWeight(middleOf(row)) ** 2;
  });
}
