// Columns and rows of the spectrogram: what is computed in a worker, and painted by the page.

import { RATE } from "./rate.js";

export const ACROSS = 800; // columns
export const ROWS = 120; // twelfths of an octave from 20 Hz to 20.5 kHz
export const ROWS_PER_OCTAVE = 12;
export const LOW_HZ = 20;
export const RANGE_DB = 60; // that the colours span below the maximum
export const LONGEST = 8192; // window

export const middleOf = (row) => LOW_HZ * 2 ** ((row + 0.5) / ROWS_PER_OCTAVE);

/** Return the longest window for a record of so many samples, of which it holds four at least. */
export const longestOf = (length) => Math.min(LONGEST, 2 ** Math.floor(Math.log2(Math.max(length / 4, 64))));

/** Return the lowest frequency [Hz] that a record of so many samples resolves. */
export const lowestOf = (length) => Math.max(LOW_HZ, (2 * RATE) / longestOf(length));
