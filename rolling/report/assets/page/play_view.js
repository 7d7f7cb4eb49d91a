// ---- the picture of the ball on its track ----

import { $, modulo, motionUnwanted, runs } from "./core.js";
import { penOf, write } from "./play_meter.js";
import { live, liveOf } from "./play_sound.js";
import { sheetOf } from "./contact.js";

const LEVEL_AT = 0.68; // height of the plate's surface in the picture
const CENTRING_S = 0.35; // in which a ball that is let go comes back to the middle
const HAND_PX_S = 500; // speed of a hand that rolls the ball as fast as its run
const LENS_MS = 120; // that a map stays under the lens at least
const BLURRED_PX = 40; // between three frames, from which the numbers of the ruler are left out

// Lengths in metres, `scale` along the track in pixels per metre; the ball has a scale of its own. `camera` is in the middle of the picture, `ball` is where the ball is drawn, `goal` where the hand is.
export const view = { camera: 0, ball: 0, goal: 0, offset: 0, asked: false, seen: false, drawnAt: 0, touched: false, map: "", mapAt: 0, scale: 1, radius: 1 };

/** Draws the next frame soon, if the picture is in sight. */
export function wakeStage() {
  if (view.asked || !view.seen) return;
  view.asked = true;
  requestAnimationFrame(tickStage);
}

function tickStage(now) {
  view.asked = false;
  if (live.number < 0) return;
  moveBall(Math.min((now - view.drawnAt) / 1000, 0.1));
  view.drawnAt = now;
  drawStage();
  if (live.held || (live.report && !live.report.asleep)) wakeStage();
}

/** Moves ball and camera: the latest report is carried on by its speed, and the ball under a hand is where the hand is. */
function moveBall(passed) {
  const { report, heardAt, held } = live;
  if (held) view.ball = view.goal;
  else if (report?.state) view.ball = report.state.position + report.state.speed * Math.min((performance.now() - heardAt) / 1000, 0.1);
  if (held) return;
  view.offset *= motionUnwanted.matches ? 0 : Math.exp(-passed / CENTRING_S);
  view.camera = view.ball - view.offset;
}

export const ballAt = () => view.ball - view.camera;

/** Tells whether the picture stands still although the ball moves. */
const isStill = () => motionUnwanted.matches && !live.held;

/** Draws plate, ruler, ball and its handles. */
export function drawStage() {
  const canvas = $("#play-stage"), { pen, width, height, colour } = penOf(canvas);
  const run = liveOf(), { height: lift, speed } = live.report?.state ?? { height: 0, speed: 0 };
  const ground = Math.round(LEVEL_AT * height);
  view.radius = Math.min(0.24 * height, width / 7);
  view.scale = HAND_PX_S / run.settings.speed;
  const enlarged = view.radius / run.fixed.radius; // pixels per metre of the ball and of the plate below it
  const room = ground - 2 * view.radius - 10; // above the ball
  const x = width / 2 + ballAt() * view.scale, y = ground - view.radius - room * (1 - Math.exp((-lift * enlarged) / room));
  pen.fillStyle = colour("plate");
  pen.fillRect(0, ground, width, Math.max(Math.min(enlarged * (live.settings.thickness ?? Infinity), height - ground), 3));
  pen.fillStyle = colour("ink");
  pen.fillRect(0, ground - 1, width, 1.5);
  pen.fillStyle = colour("pale");
  drawRuler(pen, width, ground, Math.abs(speed));
  const ratio = enlarged / view.scale, times = Number(Math.max(ratio, 1 / ratio).toPrecision(2));
  write(pen, `mm along the track; ball ${times} times ${ratio > 1 ? "larger" : "smaller"}`, 12, height - 12);
  drawBall(pen, x, y, Math.abs(speed), colour);
  if (!view.touched) drawHint(pen, x, y, colour);
  const place = `${(1e3 * view.ball).toFixed(0)}`;
  const motion = live.held ? "held" : live.rolling || live.push ? `rolls at ${Number(live.settings.speed.toPrecision(3))} m/s` : "at rest";
  canvas.setAttribute("aria-valuenow", place);
  canvas.setAttribute("aria-valuetext", `${place} mm along the track, ${motion}`);
  drawLens();
}

/** Draws marks at equal distances, the wider apart the faster they pass. */
function drawRuler(pen, width, ground, speed) {
  const passing = motionUnwanted.matches || live.held ? 0 : speed * view.scale * 0.05; // in three frames
  const wanted = Math.max(70, passing) / view.scale, decade = 10 ** Math.floor(Math.log10(wanted));
  const step = [1, 2, 5, 10].map((digit) => digit * decade).find((length) => length >= wanted);
  const camera = isStill() ? 0 : view.camera, half = width / 2 / view.scale;
  for (let k = Math.ceil((camera - half) / step); k <= (camera + half) / step; k++) {
    const x = width / 2 + (k * step - camera) * view.scale;
    pen.fillRect(x - 0.75, ground + 1, 1.5, 9);
    if (passing < BLURRED_PX) write(pen, `${Number((1e3 * k * step).toPrecision(6))}`.replace("-", "−"), x, ground + 25, "center");
  }
}

function drawDisc(pen, x, y, radius) {
  pen.beginPath();
  pen.arc(x, y, radius, 0, 2 * Math.PI);
  pen.fill();
}

/** Draws the ball with three marks that turn, and fade where they would blur. */
function drawBall(pen, x, y, speed, colour) {
  const { radius, scale, ball, touched } = view;
  const shade = pen.createRadialGradient(x - 0.35 * radius, y - 0.4 * radius, 0.1 * radius, x, y, radius);
  shade.addColorStop(0, colour("ball-light"));
  shade.addColorStop(1, colour("ball"));
  pen.fillStyle = shade;
  drawDisc(pen, x, y, radius);
  const turned = (speed * scale) / radius / 60; // in a frame
  pen.globalAlpha = !touched ? 0.35 : live.held ? 1 : Math.max(0, Math.min(1, 1.4 - turned));
  pen.fillStyle = colour("ground");
  for (let k = 0; k < 3; k++) {
    const angle = (isStill() ? 0 : (ball * scale) / radius) + (2 * Math.PI * k) / 3;
    drawDisc(pen, x + 0.68 * radius * Math.sin(angle), y - 0.68 * radius * Math.cos(angle), 0.09 * radius);
  }
  pen.globalAlpha = 1;
}

/** Draws arrows on both sides of a ball that nobody has touched. */
function drawHint(pen, x, y, colour) {
  const { radius } = view;
  pen.strokeStyle = colour("accent");
  pen.lineWidth = 4;
  pen.lineCap = pen.lineJoin = "round";
  for (const side of [-1, 1]) {
    const to = x + side * (radius + 60);
    pen.stroke(new Path2D(`M ${to - side * 44} ${y} H ${to} m ${-side * 13} -13 L ${to} ${y} l ${-side * 13} 13`));
  }
  pen.fillStyle = colour("ball-text");
  pen.font = `600 ${Math.max(14, Math.round(radius / 4))}px system-ui, sans-serif`;
  write(pen, "drag me", x, y + radius / 12, "center");
}

/** Draws the solved contact nearest to the place of the ball, where the run has maps; its area is too small to flash. */
function drawLens() {
  const { maps } = runs[live.number], figure = $("#play-contact");
  if (!figure) return;
  figure.hidden = !maps;
  if (!maps) return;
  const now = performance.now(), tile = nearestMap(maps), sheet = sheetOf(live.number), map = `${live.number} ${tile} ${sheet.complete}`;
  if (map === view.map || now - view.mapAt < (isStill() ? 1000 : LENS_MS)) return;
  Object.assign(view, { map, mapAt: now });
  const canvas = $("#play-lens"), pen = canvas.getContext("2d"), { width } = canvas;
  const perUm = width / 2.6 / Math.max(...maps.hertz_um), middle = width / 2;
  pen.fillStyle = "#000";
  pen.fillRect(0, 0, width, width);
  if (!sheet.complete) return;
  const [left, top, cell] = maps.boxes[tile].map((um) => um * perUm), [, , wide, high] = maps.tiles[tile];
  pen.imageSmoothingEnabled = false; // a cell is what was computed
  pen.drawImage(sheet, ...maps.tiles[tile], middle + left, middle - top, wide * cell, high * cell);
}

/** Returns the map nearest to the place of the ball on the track, which closes. */
function nearestMap({ position_mm: places }) {
  if (!live.report?.state) return 0;
  const { shift, length } = live.report.state;
  const away = places.map((place) => Math.abs(modulo(view.ball - shift - 1e-3 * place + length / 2, length) - length / 2));
  return away.indexOf(Math.min(...away));
}
