// ---- the contact ----

import { $, HOLD_MS, data, modulo, ownTime, runs, state } from "./core.js";
import { pause, seek } from "./player.js";
import { render, seconds } from "./motion.js";
import { drawArrow, drawEllipse, drawScale } from "./marks.js";

/** Which of the stretches of time with one map each the chosen run is in. */
export function stretch() {
  const { begins } = runs[state.run].maps;
  const time = ownTime(state.run);
  let low = 0;
  for (let high = begins.length; high - low > 1; ) {
    const middle = (low + high) >> 1;
    if (begins[middle] <= time) low = middle;
    else high = middle;
  }
  return low;
}

export function sheetOf(number) {
  if (!state.sheets[number]) {
    const sheet = new Image();
    sheet.onload = render;
    sheet.src = runs[number].maps.sheet;
    state.sheets[number] = sheet;
  }
  return state.sheets[number];
}

/** Shows the map of the time that is heard; while it plays, a map stays long enough to be seen. */
export function showMap() {
  const run = runs[state.run];
  $("#map-run").textContent = run.label;
  $("#map-time").textContent = seconds(ownTime(state.run));
  const map = run.maps ? run.maps.order[stretch()] : -1;
  const ready = map >= 0 && sheetOf(state.run).complete;
  const drawn = `${state.run} ${map} ${ready}`;
  const now = performance.now();
  const held = state.playing && state.drawn.startsWith(`${state.run} `) && now - state.drawnAt < HOLD_MS;
  if (drawn === state.drawn || held) return;
  Object.assign(state, { drawn, drawnAt: now });
  showReadings(run, map);
  drawMap(run, ready ? map : -1);
}

export function showReadings({ label, maps }, map) {
  const read = (name, unit, factor = 1) => {
    const value = maps?.[name][map] ?? null;
    return value === null ? "-" : `${Number((value * factor).toPrecision(4))} ${unit}`;
  };
  $("#map-position").textContent = read("position_mm", "mm");
  $("#map-load").textContent = maps ? `${maps.load_n} N` : "-";
  $("#map-pressure").textContent = read("max_pressure_gpa", "GPa");
  $("#map-area").textContent = read("contact_um2", "µm²");
  $("#map-plastic").textContent = read("plastic_um2", "µm²");
  const number = maps ? `map ${map + 1} of ${maps.tiles.length}` : "no maps kept";
  $("#map-number").textContent = number;
  $("#map").setAttribute("aria-label", `Contact pressure, ${label}, ${number}`);
}

export function drawMap({ maps }, map) {
  const canvas = $("#map");
  const pen = canvas.getContext("2d");
  const perUm = canvas.width / (2 * data.view.half_um);
  const middle = canvas.width / 2;
  pen.fillStyle = "#000";
  pen.fillRect(0, 0, canvas.width, canvas.height);
  if (map >= 0) {
    const [x, y, width, height] = maps.tiles[map];
    const [left, top, cell] = maps.boxes[map].map((um) => um * perUm);
    pen.imageSmoothingEnabled = false; // a cell is what was computed, nothing between cells was
    pen.drawImage(state.sheets[state.run], x, y, width, height, middle + left, middle - top, width * cell, height * cell);
  }
  if (maps) drawEllipse(pen, middle, middle, maps.hertz_um.map((axis) => axis * perUm));
  drawScale(pen, perUm, data.view.half_um / 1.5);
  drawArrow(pen);
}

export function stepMap(by) {
  const { maps, seconds: own } = runs[state.run];
  if (!maps) return;
  if (state.wanted) pause();
  const next = modulo(stretch() + by, maps.begins.length);
  seek((maps.begins[next] + (maps.begins[next + 1] ?? own)) / 2);
}
