// ---- the picture of the first view: a still of the slow motion, or a map ----

import { $, data, runs, state } from "./core.js";
import { sheetOf } from "./contact.js";
import { picturesOf } from "./film.js";
import { drawMoment, loudestMap } from "./film_still.js";
import { drawArrow, drawEllipse, drawScale } from "./marks.js";

export const ASPECT = 1.5; // width of the picture over its height

/** Draws the contact of the chosen run where it presses hardest. */
export function showStill() {
  const canvas = $("#still");
  if (!canvas) return;
  canvas.width = Math.min(1400, 2 * canvas.clientWidth || 1200); // small print stays legible
  canvas.height = Math.round(canvas.width / ASPECT);
  const { film, maps, label } = runs[state.run], pen = canvas.getContext("2d");
  pen.imageSmoothingEnabled = false; // a cell is what was computed
  pen.fillStyle = "#000";
  pen.fillRect(0, 0, canvas.width, canvas.height);
  const words = film ? drawFilmStill(pen, film) : maps ? drawMapStill(pen, maps) : "no map of the contact is kept";
  $("#still-note").textContent = words;
  canvas.setAttribute("aria-label", `The contact of ${label} seen from above`);
}

export function drawFilmStill(pen, film) {
  const k = loudestMap(film), [columns, rows] = film.size, width = Math.min(columns, ASPECT * rows), height = width / ASPECT;
  const [x, y] = film.centres[k], scale = pen.canvas.width / width;
  const left = Math.max(0, Math.min(columns - width, x - width / 2)), top = Math.max(0, Math.min(rows - height, y - height / 2));
  pen.setTransform(1, 0, 0, 1, -left * scale, -top * scale);
  drawMoment(pen, picturesOf(state.run, showStill), film, k, scale);
  pen.resetTransform();
  finishStill(pen, scale / film.cell_um);
  return "The contact from above: the surface (grey), the pressure on its asperities (warm), and the energy that they release (blue).";
}

export function drawMapStill(pen, maps) {
  const map = maps.tiles.length >> 1, sheet = sheetOf(state.run), { width, height } = pen.canvas;
  const perUm = height / (2 * data.view.half_um), [u, v, w, h] = maps.tiles[map];
  const [left, top, cell] = maps.boxes[map].map((um) => um * perUm);
  if (sheet.complete) pen.drawImage(sheet, u, v, w, h, width / 2 + left, height / 2 - top, w * cell, h * cell);
  else sheet.addEventListener("load", showStill, { once: true });
  drawEllipse(pen, width / 2, height / 2, maps.hertz_um.map((axis) => axis * perUm));
  finishStill(pen, perUm);
  return "The contact from above: the pressure on the asperities.";
}

export function finishStill(pen, perUm) {
  drawScale(pen, perUm, pen.canvas.width / perUm / 5);
  drawArrow(pen);
}
