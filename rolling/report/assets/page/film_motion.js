// ---- the ball during the slow motion: its height, the contact force, and its flights ----

import { $, runs, state } from "./core.js";
import { film, filmRate } from "./film.js";
import { sampleAt } from "./film_still.js";

export const FLASHING_PX = 21824; // on which more than three flashes a second are too many by WCAG 2.3.1
export const FLASH_S = 1 / 3;
const FILM_FONT = "22px system-ui, sans-serif";

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
  pen.font = FILM_FONT;
  pen.textAlign = "center";
  pen.fillStyle = "#fff";
  pen.fillText("the ball flies: nothing touches", pen.canvas.width / 2, pen.canvas.height - 24);
}

export function prepareMotion({ motion }, width) {
  const canvas = $("#film-motion");
  if (!canvas) return;
  canvas.hidden = $("#film-motion-note").hidden = !motion;
  canvas.width = width; // small print stays legible
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

/** Draws height and force, pale where the film has not come yet, with the flights shaded. */
export function drawMotion(shown) {
  const { motion, times } = shown;
  if (!motion) return;
  const canvas = $("#film-motion"), { width, height } = canvas;
  const [first, last, now] = [times[0], times[times.length - 1], times[film.at]];
  const axis = { pen: canvas.getContext("2d"), x: (time) => ((time - first) / (last - first)) * width, passed: sampleAt(motion, now), ...inks(canvas) };
  axis.pen.clearRect(0, 0, width, height);
  drawFlights(axis, motion.flights);
  const words = saidMotion(shown, now).replace("; t", "T");
  canvas.setAttribute("aria-label", `Height and contact force of ${runs[state.run].label}. ${words}`);
  const [lowest, highest] = [Math.min(...motion.height_nm), Math.max(...motion.height_nm)];
  const hardest = Math.max(...motion.force_n, motion.load_n);
  const title = `height, ${heightText(lowest)} to ${heightText(highest)}`;
  drawLane(axis, motion, { values: motion.height_nm, top: 0, low: lowest, high: highest, title });
  const weakest = Math.min(...motion.force_n, motion.load_n); // zero with a flight
  const force = { values: motion.force_n, top: height / 2, low: weakest, high: hardest };
  drawLoad(axis, laneY(axis, force)(motion.load_n));
  drawLane(axis, motion, { ...force, title: `force, ${newtons(weakest)} to ${newtons(hardest)}; dashed: load ${newtons(motion.load_n)}` });
  drawReading(axis, `${heightText(motion.height_nm[axis.passed])}, ${flightAt(shown, now) ? "the ball flies" : newtons(motion.force_n[axis.passed])}`);
}

function inks(canvas) {
  const { color, borderBottomColor } = getComputedStyle(canvas);
  return { curve: color, shade: borderBottomColor, ink: getComputedStyle(document.body).color };
}

/** Returns the place of a value in one of two lanes, one above the other. */
function laneY({ pen }, { top, low, high }) {
  const { height } = pen.canvas;
  return (value) => top + 0.5 * height - 14 - ((value - low) / (high - low || 1)) * (0.5 * height - 62);
}

function drawFlights({ pen, x, shade, ink }, flights) {
  const { height } = pen.canvas;
  pen.font = FILM_FONT;
  pen.textAlign = "center";
  for (const [begin, end] of flights) {
    pen.fillStyle = shade;
    pen.fillRect(x(begin), 0, Math.max(2, x(end) - x(begin)), height);
    pen.fillStyle = ink;
    if (x(end) - x(begin) > 80) pen.fillText("flies", (x(begin) + x(end)) / 2, height - 48);
  }
}

/** Draws a curve over time with its title and a mark at the present. */
function drawLane(axis, { begin, step }, lane) {
  const { pen, x, passed } = axis, { values } = lane, y = laneY(axis, lane);
  const draw = (from, to, alpha) => {
    pen.globalAlpha = alpha;
    pen.beginPath();
    for (let k = from; k <= to; k++) pen.lineTo(x(begin + k * step), y(values[k]));
    pen.stroke();
    pen.globalAlpha = 1;
  };
  pen.strokeStyle = pen.fillStyle = axis.curve;
  pen.lineWidth = 3;
  draw(passed, values.length - 1, 0.3);
  draw(0, passed, 1);
  pen.beginPath();
  pen.arc(x(begin + passed * step), y(values[passed]), 8, 0, 2 * Math.PI);
  pen.fill();
  pen.fillStyle = axis.ink;
  pen.font = FILM_FONT;
  pen.textAlign = "left";
  pen.fillText(lane.title, 8, lane.top + 26);
}

/** Draws the load as a dashed line. */
function drawLoad({ pen, ink }, y) {
  pen.strokeStyle = ink;
  pen.lineWidth = 1.5;
  pen.setLineDash([8, 8]);
  pen.beginPath();
  pen.moveTo(0, y);
  pen.lineTo(pen.canvas.width, y);
  pen.stroke();
  pen.setLineDash([]);
}

function drawReading({ pen, ink }, text) {
  pen.fillStyle = ink;
  pen.textAlign = "right";
  pen.fillText(text, pen.canvas.width - 8, 26);
}
