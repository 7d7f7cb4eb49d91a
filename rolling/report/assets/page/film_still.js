// ---- a map of the slow motion as a picture ----

import { drawEllipse } from "./marks.js";

export const MOST_PX = 1200; // width of a picture

/** Reads the pictures of a film, and calls back whenever one of them is ready. */
export function readFilm({ ground, pressure, release }, onload = null) {
  const read = (src) => Object.assign(new Image(), { onload, src });
  return { ground: read(ground), pressure: read(pressure.png), release: read(release.png) };
}

export const sampleAt = ({ begin, step, force_n: force }, time) => Math.min(force.length - 1, Math.max(0, Math.round((time - begin) / step)));

/** Returns the map at which the ball presses hardest; without its motion, at which most power is released. */
export function loudestMap({ motion, times, power_uw: power }) {
  const values = motion ? times.map((time) => motion.force_n[sampleAt(motion, time)]) : power;
  return values.indexOf(Math.max(...values));
}

/** Gives a canvas two pixels per CSS pixel, so that small print stays legible, and the shape of the film. */
export function fitCanvas(canvas, { size: [along, across] }) {
  canvas.width = Math.min(MOST_PX, 2 * canvas.clientWidth || MOST_PX);
  canvas.height = Math.round((canvas.width * across) / along);
}

function drawPart(pen, picture, { tiles, places }, at, scale) {
  if (!picture.complete) return;
  const [x, y, width, height] = tiles[at], [left, top] = places[at];
  pen.drawImage(picture, x, y, width, height, left * scale, top * scale, width * scale, height * scale);
}

/** Draws surface, pressure, release and Hertz's circle of a map, so many pixels per cell; only the surface and the circle if nothing touches. */
export function drawMoment(pen, pictures, shown, at, scale, isEmpty = false) {
  const [columns, rows] = shown.size;
  pen.imageSmoothingEnabled = false; // a cell is what was computed
  if (pictures.ground.complete) pen.drawImage(pictures.ground, 0, 0, columns * scale, rows * scale);
  if (!isEmpty) {
    drawPart(pen, pictures.pressure, shown.pressure, at, scale);
    drawPart(pen, pictures.release, shown.release, at, scale);
  }
  const [x, y] = shown.centres[at];
  drawEllipse(pen, x * scale, y * scale, shown.hertz_um.map((axis) => (axis / shown.cell_um) * scale));
}
