// Data of the page, the chosen bearing, its settings, and the latest motion of its ring.

export const $ = (selector) => document.querySelector(selector);
export const $$ = (selector) => [...document.querySelectorAll(selector)];
export const data = JSON.parse($("#data").textContent);

// `run`: the chosen run. `settings`: speed [1/min], axial and radial load [N]. `moved`: the latest answer of the worker.
// `turning`: the picture turns; `slow`: how much slower than the bearing. `time`: time of the picture [s].
export const state = { run: data.runs[0], settings: {}, moved: null, turning: false, slow: 100, time: 0 };

/** Return the numbers of a text of base 64, 16 bits each, times a unit. */
function numbersOf({ unit, text }) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const view = new DataView(bytes.buffer);
  return Float64Array.from({ length: bytes.length / 2 }, (_, k) => unit * view.getInt16(2 * k, true));
}

for (const run of data.runs) {
  const { inner, outer, ballsOnInner, ballsOnOuter } = run.bearing.tracks;
  run.bearing.tracks = {
    inner: inner.map(numbersOf),
    outer: outer.map(numbersOf),
    ballsOnInner: ballsOnInner.map((ball) => ball.map(numbersOf)),
    ballsOnOuter: ballsOnOuter.map((ball) => ball.map(numbersOf)),
  };
}

/** Write a number with so many digits, thousands apart by commas. */
export function digits(value, count = 3) {
  if (!(Math.abs(value) > 0)) return "0";
  const places = Math.max(count - 1 - Math.floor(Math.log10(Math.abs(value))), 0);
  return value.toLocaleString("en-US", { minimumFractionDigits: places, maximumFractionDigits: places });
}

const FLOOR = 0.1; // um/s, below which the small model rounds

/** Write a velocity [m/s] in micrometres per second; one that is not known is null. */
export const velocity = (metres) => {
  if (metres === null) return "-";
  return 1e6 * metres < FLOOR ? `< ${FLOOR}` : digits(1e6 * metres);
};
