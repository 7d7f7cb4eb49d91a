// ---- the curves of the slow motion: power, height of the ball, contact force, and its flights ----

import { $, runs, state } from "./core.js";
import { openChart, shadesOf } from "./chart.js";
import { setPlayhead } from "./chart_touch.js";
import { film, filmRate } from "./film.js";
import { sampleAt } from "./film_still.js";

export const FLASHING_PX = 21824; // on which more than three flashes a second are too many by WCAG 2.3.1
export const FLASH_S = 1 / 3;
const CURVES_PX = 130; // height of the curves, so that the picture stays in sight above them
const MARGIN = 0.06; // of an axis beyond its values

const flightAt = ({ motion }, time) => motion?.flights.find(([begin, end]) => begin <= time && time <= end);

/** Returns whether the map is left out: in flight, unless so much of the picture would then flash too often. */
export function isEmptied(shown, time) {
  const flight = flightAt(shown, time);
  if (!flight || !film.playing) return Boolean(flight);
  const cell = $("#film").clientWidth / shown.size[0];
  return shown.most_cells * cell ** 2 < FLASHING_PX || (flight[1] - flight[0]) * filmRate() > FLASH_S;
}

/** Says why the map is empty. */
export function drawFlight(pen) {
  pen.font = "22px system-ui, sans-serif";
  pen.textAlign = "center";
  pen.fillStyle = "#fff";
  pen.fillText("the ball flies: nothing touches", pen.canvas.width / 2, pen.canvas.height - 24);
}

export const newtons = (force) => (force < 1 ? `${Number((1e3 * force).toPrecision(3))} mN` : `${Number(force.toPrecision(3))} N`);
const heightText = (nm) => (Math.abs(nm) < 1000 ? `${Number(nm.toPrecision(3))} nm` : `${Number((nm / 1000).toPrecision(3))} µm`).replace("-", "−");

/** Says what the ball does at a time; nothing without its motion. */
export function saidMotion(shown, time) {
  if (!shown.motion) return "";
  const { motion } = shown, at = sampleAt(motion, time);
  const presses = flightAt(shown, time) ? "flies" : `presses with ${newtons(motion.force_n[at])}`;
  return `; the ball is ${heightText(motion.height_nm[at])} high and ${presses}`;
}

/** Opens the charts of a film: its release power and, where it is known, the motion of the ball. */
export function openCurves({ times, power_uw: power, motion }) {
  const ms = times.map((time) => 1e3 * time), figure = $("#film-motion");
  const released = power.slice(1); // each belongs to the time since the map before
  const axis = axisOf("release power", "µW", released), line = lineOf(0, 0, released);
  openChart($("#film-power"), chartOver("Release power", ms, [ms.slice(1)], [axis], [{ name: "", colour: "#0072b2" }], [line]));
  if (!figure) return;
  figure.hidden = $("#film-motion-note").hidden = !motion;
  if (!motion) return;
  const { height_nm: height, force_n: force, load_n: load, flights } = motion;
  const at = height.map((_, k) => 1e3 * (motion.begin + k * motion.step));
  const curves = [{ name: "height", colour: "#0072b2" }, { name: "contact force", colour: "#d55e00" }, { name: "load", colour: "#d55e00", dash: ":" }];
  if (flights.length) curves.push({ name: "flight", colour: "#eceef0" });
  const axes = [axisOf("height", "nm", height), axisOf("contact force", "N", [...force, load])];
  openChart(figure, chartOver("Motion of the ball", ms, [at], axes, curves, [
    ...flights.map(([begin, end]) => ({ kind: "span", of: 3, ends: [1e3 * begin, 1e3 * end] })),
    lineOf(0, 0, height), { ...lineOf(1, 0, force), right: true }, { kind: "rule", of: 2, along: false, at: load, right: true },
  ]));
}

const lineOf = (of, x, y) => ({ kind: "line", of, x, y, width: 1 });

function axisOf(label, unit, values) {
  const low = Math.min(...values), high = Math.max(...values), margin = MARGIN * (high - low) || 1;
  return { label, unit, log: false, limits: [low - margin, high + margin], names: [] };
}

/** Returns a chart over the time of the film in ms. */
const chartOver = (title, ms, xs, y, curves, parts) => ({
  title, note: runs[state.run].label, run: state.run, second: 1e-3, high: CURVES_PX,
  xs, y, parts,
  x: { label: "time", unit: "ms", log: false, limits: [ms[0], ms.at(-1)], names: [] },
  curves: curves.map((curve) => ({ dash: "-", marker: "o", ...curve })),
  paints: curves.map(({ colour, name }) => (name === "flight" ? "var(--chart-shade)" : shadesOf(colour))),
});

/** Moves the playheads of the curves to the time of the map. */
export function showInCurves(time) {
  for (const selector of ["#film-power", "#film-motion"]) if ($(selector)?.plot) setPlayhead($(selector).plot, time);
}
