// The live spectrum of velocity, with bands and lines of the bearing.

import { draw } from "./picture.js";
import { $, data, digits, state, velocity } from "./state.js";

const HEIGHT = 340;
const LEFT = 52; // of the axes
const RIGHT = 12;
const TOP = 76; // room for the names of bands and lines
const BOTTOM = 40;
const SHOWN_HZ = [20, 20000];
const DECADES = 5; // of velocity, at most
const NAME_ROWS = 3;
const NAME_ROW = 14;
const NARROW = 560; // width of a chart that has no room for units
const NAME_LETTER = 6.6; // width of a letter
const TICKS_HZ = [20, 50, 100, 200, 500, 1000, 2000, 5000, 10000, 20000];

/** Return an empty chart of the width of its box, and its scales. */
function openSpectrum(selector, [low, high]) {
  const svg = $(selector);
  const width = Math.max(svg.clientWidth, 280);
  svg.replaceChildren();
  svg.setAttribute("viewBox", `0 0 ${width} ${HEIGHT}`);
  const share = (hz) => Math.log(hz / low) / Math.log(high / low);
  const x = (hz) => LEFT + (width - LEFT - RIGHT) * share(hz);
  return { svg, width, x, low, high };
}

/** Return the largest line in each column of a chart, as points [place, value]. */
function thinned(chart, frequencies, values) {
  const points = new Map();
  for (let k = 0; k < values.length; k++) {
    const hz = frequencies(k);
    if (hz < chart.low || hz > chart.high) continue;
    const column = Math.round(chart.x(hz));
    if (!(values[k] <= points.get(column))) points.set(column, values[k]);
  }
  return [...points].sort(([one], [other]) => one - other);
}

/** Draw the names of lines above a chart, each where there is room for it. */
function drawLines(chart, lines, top, bottom) {
  const ends = new Array(NAME_ROWS).fill(-Infinity);
  const inside = lines.filter(({ hz }) => hz > chart.low && hz < chart.high).sort((one, other) => one.hz - other.hz);
  for (const { name, hz, minor } of inside) {
    const place = chart.x(hz);
    const half = (name.length * NAME_LETTER) / 2;
    const begin = Math.min(Math.max(place - half, 2), chart.width - 2 * half - 2);
    const row = minor ? -1 : ends.findIndex((end) => begin > end);
    const above = row < 0 ? top : top - 6 - NAME_ROW * row;
    draw(chart.svg, "path", { class: row < 0 ? "kinematic minor" : "kinematic", d: `M${place} ${above}V${bottom}` });
    if (row < 0) continue;
    ends[row] = begin + 2 * half + NAME_LETTER;
    draw(chart.svg, "text", { x: begin + half, y: above - 3, "text-anchor": "middle", class: "name" }, name);
  }
}

/** Mark the frequencies above the first bending mode of the ring. */
function drawBending(chart, top, bottom) {
  const { bendingHz } = state.run;
  if (!(bendingHz < chart.high)) return;
  const place = chart.x(Math.max(bendingHz, chart.low));
  draw(chart.svg, "path", { class: "bending", d: `M${place} ${bottom}V${top}H${chart.width - RIGHT}V${bottom}Z` });
  draw(chart.svg, "text", { class: "name", x: place + 4, y: bottom - 6 }, "rings bend");
}

/** Draw the axis of frequencies. */
function drawFrequencies(chart, ticks) {
  const bottom = HEIGHT - BOTTOM;
  draw(chart.svg, "path", { class: "axis", d: `M${LEFT} ${bottom}H${chart.width - RIGHT}` });
  for (const hz of ticks) {
    if (hz < chart.low || hz > chart.high) continue;
    const name = hz >= 1000 ? `${hz / 1000}k` : String(hz);
    draw(chart.svg, "path", { class: "axis", d: `M${chart.x(hz)} ${bottom}v4` });
    draw(chart.svg, "text", { x: chart.x(hz), y: bottom + 17, "text-anchor": "middle" }, name);
  }
  draw(chart.svg, "text", { x: (LEFT + chart.width - RIGHT) / 2, y: HEIGHT - 5, "text-anchor": "middle" }, "Frequency [Hz]");
}

/** Return the path of points under a scale of values. */
const lineOf = (points, y) => points.map(([place, value], k) => `${k ? "L" : "M"}${place} ${y(value).toFixed(1)}`).join("");

/** Return the lines of the chosen run at a speed. */
const linesAt = (rpm) => state.run.lines.map((line) => ({ ...line, hz: (line.hz * rpm) / state.run.bearing.rpm }));

/** Draw the spectrum of the radial velocity: that of the run, and the latest of the small model. */
export function drawSpectrum() {
  const chart = openSpectrum("#live-spectrum", SHOWN_HZ);
  const { run, moved, settings } = state;
  const own = thinned(chart, (k) => run.spectrum.hz[k], run.spectrum.um_s);
  const live = moved ? thinned(chart, (k) => k * moved.width, moved.radial.map((rms) => 1e6 * rms)) : [];
  const largest = Math.max(...[...own, ...live].map(([, value]) => value), 1e-9);
  const top = Math.ceil(Math.log10(largest) + 0.1);
  const bottom = HEIGHT - BOTTOM;
  const y = (value) => {
    const share = (top - Math.log10(Math.max(value, 1e-12))) / DECADES;
    return TOP + (bottom - TOP) * Math.min(Math.max(share, 0), 1);
  };
  run.bandsHz.forEach(([low, high], k) => {
    if (!(high > low)) return; // the ring bends from below the band on
    const from = chart.x(low);
    const width = chart.x(high) - from;
    draw(chart.svg, "rect", { class: k % 2 ? "band odd" : "band", x: from, y: TOP, width, height: bottom - TOP });
    const level = moved ? moved.levels[k].radial : run.bands[k];
    draw(chart.svg, "text", { class: "level", x: from + width / 2, y: 14, "text-anchor": "middle" }, chart.width < NARROW ? velocity(level) : `${velocity(level)} µm/s`);
  });
  for (let decade = top; decade >= top - DECADES; decade--) {
    const height = y(10 ** decade);
    draw(chart.svg, "path", { class: "grid", d: `M${LEFT} ${height}H${chart.width - RIGHT}` });
    const name = decade >= -3 && decade <= 3 ? String(Number((10 ** decade).toPrecision(1))) : `1e${decade}`;
    draw(chart.svg, "text", { x: LEFT - 6, y: height + 4, "text-anchor": "end" }, name);
  }
  draw(chart.svg, "text", { transform: `translate(12 ${(TOP + bottom) / 2}) rotate(-90)`, "text-anchor": "middle" }, "Velocity [µm/s]");
  drawFrequencies(chart, TICKS_HZ);
  drawBending(chart, TOP, bottom);
  drawLines(chart, linesAt(settings.rpm), TOP, bottom);
  if (own.length) draw(chart.svg, "path", { class: "curve own", d: lineOf(own, y) });
  if (live.length) draw(chart.svg, "path", { class: "curve live", d: lineOf(live, y) });
}
