// ---- the ball during the slow motion: its height, the contact force, and its flights ----

import { $, runs, state } from "./core.js";
import { film } from "./film.js";

export const sampleAt = ({ begin, step, force_n: force }, time) => Math.min(force.length - 1, Math.max(0, Math.round((time - begin) / step)));

export const flightAt = ({ motion }, time) => motion?.flights.find(([begin, end]) => begin <= time && time <= end);
export const flies = (shown, time) => Boolean(flightAt(shown, time));

export const FLASHING_PX = 21824; // on which more than three flashes a second are too many by WCAG 2.3.1
export const FLASH_S = 1 / 3;

/** Whether the map is left out: in flight, unless so much of the picture would then flash too often. */
export function isEmptied(shown, time) {
  const flight = flightAt(shown, time);
  if (!flight || !film.playing) return Boolean(flight);
  const cell = $("#film").clientWidth / shown.size[0];
  return shown.most_cells * cell ** 2 < FLASHING_PX || (flight[1] - flight[0]) * Number($("#film-rate").value) > FLASH_S;
}

/** The map at which the ball presses hardest; undefined without its motion. */
export function hardestMap({ motion, times }) {
  if (!motion) return undefined;
  const forces = times.map((time) => motion.force_n[sampleAt(motion, time)]);
  return forces.indexOf(Math.max(...forces));
}

/** Says why the map is empty. */
export function drawFlight(pen) {
  pen.font = "22px system-ui, sans-serif";
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
export const metres = (nm) => (Math.abs(nm) < 1000 ? `${Number(nm.toPrecision(3))} nm` : `${Number((nm / 1000).toPrecision(3))} µm`).replace("-", "−");

/** What the ball does at a time, in words; nothing without its motion. */
export function saidMotion(shown, time) {
  if (!shown.motion) return "";
  const { motion } = shown, at = sampleAt(motion, time);
  const presses = flies(shown, time) ? "flies" : `presses with ${newtons(motion.force_n[at])}`;
  return `; the ball is ${metres(motion.height_nm[at])} high and ${presses}`;
}

/** Height and force, pale where the film has not come yet, with the flights shaded. */
export function drawMotion(shown) {
  const { motion, times } = shown;
  if (!motion) return;
  const canvas = $("#film-motion"), pen = canvas.getContext("2d"), { width, height } = canvas;
  const { color, borderBottomColor } = getComputedStyle(canvas);
  const ink = getComputedStyle(document.body).color;
  const [first, last, now] = [times[0], times[times.length - 1], times[film.at]];
  const x = (time) => ((time - first) / (last - first)) * width;
  pen.clearRect(0, 0, width, height);
  for (const [begin, end] of motion.flights) {
    pen.fillStyle = borderBottomColor;
    pen.fillRect(x(begin), 0, Math.max(2, x(end) - x(begin)), height);
    pen.fillStyle = ink;
    pen.font = "22px system-ui, sans-serif";
    pen.textAlign = "center";
    if (x(end) - x(begin) > 80) pen.fillText("flies", (x(begin) + x(end)) / 2, height - 48);
  }
  const words = saidMotion(shown, now).replace("; t", "T");
  $("#film-motion").setAttribute("aria-label", `Height and contact force of ${runs[state.run].label}. ${words}`);
  const lane = (values, top, low, high, title) => {
    const y = (value) => top + 0.5 * height - 14 - ((value - low) / (high - low || 1)) * (0.5 * height - 62);
    const time = (k) => motion.begin + k * motion.step;
    const passed = sampleAt(motion, now);
    const curve = (from, to, alpha) => {
      pen.globalAlpha = alpha;
      pen.beginPath();
      for (let k = from; k <= to; k++) pen.lineTo(x(time(k)), y(values[k]));
      pen.stroke();
      pen.globalAlpha = 1;
    };
    pen.strokeStyle = pen.fillStyle = color;
    pen.lineWidth = 3;
    curve(passed, values.length - 1, 0.3);
    curve(0, passed, 1);
    pen.fillStyle = ink;
    pen.font = "22px system-ui, sans-serif";
    pen.textAlign = "left";
    pen.fillText(title, 8, top + 26);
    return { y, x: x(time(passed)), value: values[passed] };
  };
  const [lowest, highest] = [Math.min(...motion.height_nm), Math.max(...motion.height_nm)];
  const ball = lane(motion.height_nm, 0, lowest, highest, `ball’s height over its mean, ${metres(lowest)} to ${metres(highest)}`);
  const hardest = Math.max(...motion.force_n, motion.load_n);
  const force = lane(motion.force_n, height / 2, 0, hardest, `contact force, 0 to ${newtons(hardest)}; dashed: load ${newtons(motion.load_n)}`);
  pen.strokeStyle = ink;
  pen.lineWidth = 1.5;
  pen.setLineDash([8, 8]);
  pen.beginPath();
  pen.moveTo(0, force.y(motion.load_n));
  pen.lineTo(width, force.y(motion.load_n));
  pen.stroke();
  pen.setLineDash([]);
  for (const mark of [ball, force]) {
    pen.fillStyle = color;
    pen.beginPath();
    pen.arc(mark.x, mark.y(mark.value), 8, 0, 2 * Math.PI);
    pen.fill();
  }
  pen.fillStyle = ink;
  pen.textAlign = "right";
  const doing = flies(shown, now) ? "the ball flies" : newtons(force.value);
  pen.fillText(`${metres(ball.value)}, ${doing}`, width - 8, 26);
}
