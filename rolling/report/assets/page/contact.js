// ---- pictures of the solved contact: in the first view, while it sounds, and in slow motion ----

import { $, $$, data, motionUnwanted, runs, seconds, solvedTime, state } from "./core.js";

const OF_CONTACT = ["load", "pressure", "area", "plastic"]; // readings that belong to a map
const HOLD_MS = 400; // of a map while it plays: at most 2.5 changes a second, which is 1.25 flashes
const STILL_WORDS = "The contact from above.";
const FALL_WORDS = "The ball falls and bounces: no picture of a contact under its load is shown.";

/** Draw the layers of a map about the sphere's centre at (x, y); call `again` when more are loaded. */
export function drawSolved(pen, { sheets }, at, { x, y, perUm }, again) {
  pen.imageSmoothingEnabled = false; // cells are computed values, with nothing between them
  pen.fillStyle = "#000";
  pen.fillRect(0, 0, pen.canvas.width, pen.canvas.height);
  for (const sheet of sheets) {
    const picture = sheet.picture ??= Object.assign(new Image(), { src: sheet.png });
    if (!picture.complete) {
      picture.addEventListener("load", again, { once: true });
      continue;
    }
    const tile = sheet.tiles[at], [left, top, cell] = sheet.boxes[at].map((um) => um * perUm);
    pen.drawImage(picture, ...tile, x + left, y - top, tile[2] * cell, tile[3] * cell);
  }
}

/** Return the width of a picture and the sphere's centre in it [um]; the surface of a film stays fixed. */
function frameOf({ size_um: size, sheets }, at, aspect) {
  const { half_um: half } = data.view;
  if (!size) return { width: 2 * half * aspect, x: half * aspect, y: half };
  const [along, across] = size, width = Math.min(along, aspect * across), [{ boxes }] = sheets;
  const inside = (place, room, part) => place - Math.max(0, Math.min(room - part, place - part / 2));
  return { width, x: inside(-boxes[at][0], along, width), y: inside(boxes[at][1], across, width / aspect) };
}

/** Draw a map or a moment of a film, with the ellipse of Hertz's contact and a scale bar. */
export function drawContact(canvas, solved, at, again) {
  const { width, height } = canvas, frame = frameOf(solved, at, width / height), perUm = width / frame.width;
  drawSolved(canvas.getContext("2d"), solved, at, { x: frame.x * perUm, y: frame.y * perUm, perUm }, again);
  const [ellipse, scale] = canvas.parentElement.querySelectorAll(".hertz, .scale"), percent = (um, whole) => `${(100 * um) / whole}%`;
  const [along, across] = solved.hertz_um, left = percent(frame.x, frame.width), top = percent(frame.y * perUm, height);
  Object.assign(ellipse.style, { left, top, width: percent(2 * along, frame.width), aspectRatio: along / across });
  const longest = frame.width / 5, decade = 10 ** Math.floor(Math.log10(longest));
  const length = [5, 2, 1].find((digit) => digit * decade <= longest) * decade;
  scale.style.width = percent(length, frame.width);
  scale.textContent = `${Number(length.toPrecision(1))} µm`;
}

/** Draw the part of a map that shows its contact on a round canvas; `again` draws it when its picture is loaded. */
export function drawLensMap(canvas, maps, at, again) {
  const { width } = canvas, [x, y, size] = maps.lens[at], perUm = width / size;
  drawSolved(canvas.getContext("2d"), maps, at, { x: width / 2 - x * perUm, y: width / 2 + y * perUm, perUm }, again);
}

/** Show the chosen run where its contact presses hardest, or in the middle of its maps. */
export function showStill() {
  const canvas = $("#still");
  showKeys();
  if (!canvas) return;
  const { film, maps, falls, label } = runs[state.run];
  canvas.parentElement.hidden = falls || (!film && !maps);
  $("#still-note").textContent = falls ? FALL_WORDS : film || maps ? STILL_WORDS : "No map of the contact is kept.";
  if (falls) return;
  canvas.setAttribute("aria-label", `The contact of ${label} seen from above`);
  if (film) drawContact(canvas, film, film.loudest, showStill);
  else if (maps) drawContact(canvas, maps, maps.position_mm.length >> 1, showStill);
}

/** Say in the keys of the pictures how much energy lights a cell fully; without a film none is shown. */
export function showKeys() {
  const { film, maps } = runs[state.run];
  for (const key of $$(".contact-key")) {
    key.hidden = !film && !maps;
    key.classList.toggle("bare", !film);
    key.querySelector(".releases").hidden = !film;
    key.querySelector(".most").textContent = film?.released ?? "";
  }
}

// ---- while it sounds ----

const last = { run: -1, map: -1, instead: null, at: 0 }; // what is shown, and when it was drawn

/** Show the map of the time that is heard; while it plays, a map stays long enough to be seen. */
export function showMap() {
  if (!data.view || (state.voices && motionUnwanted.matches)) return;
  const { maps, label } = runs[state.run], time = solvedTime(state.run), now = performance.now();
  $(".contact").hidden = !maps;
  $("#no-maps").hidden = Boolean(maps);
  if (!maps) return;
  $("#map-run").textContent = label;
  $("#map-time").textContent = seconds(time);
  const turn = maps.begins.findLastIndex((begin) => begin <= time), map = maps.order[turn], instead = maps.instead[turn];
  const held = state.voices && state.run === last.run && now - last.at < HOLD_MS;
  if (held || (state.run === last.run && map === last.map && instead === last.instead)) return;
  Object.assign(last, { run: state.run, map, instead, at: now });
  for (const [name, texts] of Object.entries(maps.readings)) $(`#map-${name}`).textContent = instead && OF_CONTACT.includes(name) ? "–" : texts[map];
  Object.assign($("#map-seek"), { max: maps.position_mm.length - 1, value: map });
  $("#map-seek").setAttribute("aria-valuetext", maps.readings.number[map]);
  $("#map").setAttribute("aria-label", `Contact pressure, ${label}, ${maps.readings.number[map]}`);
  showInstead(instead);
  drawContact($("#map"), instead ? { ...maps, sheets: [] } : maps, map, () => {
    last.map = -1;
    showMap();
  });
}

/** Show a sentence instead of a contact that was not computed. */
function showInstead(sentence) {
  $("#map-flies").hidden = !sentence;
  $("#map-flies").textContent = sentence ?? "";
  $("#map").parentElement.querySelector(".hertz").hidden = Boolean(sentence);
}

/** Return the time at which a map of the chosen run is first shown. */
export function timeOfMap(map) {
  const { begins, order } = runs[state.run].maps;
  return begins[order.indexOf(map)];
}
