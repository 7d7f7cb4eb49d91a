// ---- the picture of the ball on its track ----

import { $, modulo, motionUnwanted, runs } from "./core.js";
import { penOf } from "./play_meter.js";
import { live, liveOf } from "./play_sound.js";
import { sheetOf } from "./contact.js";

const LEVEL_AT = 0.68; // height of the plate's surface in the picture
const CENTRING_S = 0.35; // in which a ball that is let go comes back to the middle
const HAND_PX_S = 500; // speed of a hand that rolls the ball as fast as its run
const LENS_MS = 120; // that a map stays under the lens at least

// Lengths in metres, `scale` along the track in pixels per metre; the ball has a scale of its own. `camera` is in the middle of the picture, `ball` is where the ball is drawn, `goal` where the hand is.
export const view = { camera: 0, ball: 0, goal: 0, offset: 0, asked: false, seen: false, drawnAt: 0, touched: false, map: -1, mapAt: 0, scale: 1, radius: 1 };

/** Draws the next frame soon, if the picture is in sight. */
export function wakeStage() {
  if (view.asked || !view.seen) return;
  view.asked = true;
  requestAnimationFrame(tickStage);
}

function tickStage(now) {
  view.asked = false;
  if (live.number < 0) return;
  const passed = Math.min((now - view.drawnAt) / 1000, 0.1);
  view.drawnAt = now;
  moveBall(passed);
  drawStage();
  const asleep = !live.report || live.report.asleep;
  if (live.held || !asleep) wakeStage();
}

/** Moves ball and camera: the latest report is carried on by its speed, and the ball under a hand is where the hand is. */
function moveBall(passed) {
  const { report, heardAt, held } = live;
  const state = report?.state;
  const heard = state ? state.position + state.speed * Math.min((performance.now() - heardAt) / 1000, 0.1) : view.ball;
  view.ball = held ? view.goal : heard;
  if (held) return;
  view.offset *= motionUnwanted.matches ? 0 : Math.exp(-passed / CENTRING_S);
  view.camera = view.ball - view.offset;
}

export const ballAt = () => view.ball - view.camera;

/** Draws plate, ruler, ball and its handles. */
export function drawStage() {
  const canvas = $("#play-stage");
  const { pen, width, height, colour } = penOf(canvas);
  const run = liveOf(), { radius } = run.fixed, { settings, report } = live;
  const ground = Math.round(LEVEL_AT * height);
  view.radius = Math.min(0.24 * height, width / 7);
  view.scale = HAND_PX_S / run.settings.speed;
  const enlarged = view.radius / radius; // pixels per metre of the ball and of the plate below it
  drawPlate(pen, width, height, ground, colour, enlarged * (settings.thickness ?? Infinity));
  drawRuler(pen, width, ground, colour, report?.state?.speed ?? 0);
  const lifted = (report?.state?.height ?? 0) * enlarged, room = ground - 2 * view.radius - 10;
  const x = width / 2 + ballAt() * view.scale, y = ground - view.radius - room * (1 - Math.exp(-lifted / room));
  drawBall(pen, x, y, (view.ball * view.scale) / view.radius, colour);
  drawNote(pen, height, colour, enlarged / view.scale);
  if (!view.touched) drawHint(pen, x, y, colour);
  canvas.setAttribute("aria-valuenow", String(Math.round(1e3 * view.ball)));
  canvas.setAttribute("aria-valuetext", `${(1e3 * view.ball).toFixed(0)} mm along the track, ${live.held ? "held" : live.rolling || live.push ? `rolls at ${Number(settings.speed.toPrecision(3))} m/s` : "at rest"}`);
  drawLens();
}

function drawPlate(pen, width, height, ground, colour, thickness) {
  pen.fillStyle = colour("plate");
  pen.fillRect(0, ground, width, Math.max(Math.min(thickness, height - ground), 3));
  pen.fillStyle = colour("ink");
  pen.fillRect(0, ground - 1, width, 1.5);
}

/** Draws marks at equal distances, the wider apart the faster they pass. */
function drawRuler(pen, width, ground, colour, speed) {
  const passing = motionUnwanted.matches || live.held ? 0 : Math.abs(speed) * view.scale * 0.05; // in three frames
  const wanted = Math.max(70, passing) / view.scale;
  const decade = 10 ** Math.floor(Math.log10(wanted));
  const step = [1, 2, 5, 10].map((digit) => digit * decade).find((length) => length >= wanted);
  const camera = motionUnwanted.matches && !live.held ? 0 : view.camera;
  const first = Math.ceil((camera - width / 2 / view.scale) / step), last = (camera + width / 2 / view.scale) / step;
  pen.fillStyle = colour("pale");
  pen.font = "13px system-ui, sans-serif";
  pen.textAlign = "center";
  for (let k = first; k <= last; k++) {
    const x = width / 2 + (k * step - camera) * view.scale;
    pen.fillRect(x - 0.75, ground + 1, 1.5, 9);
    if (!passing || passing < 40) pen.fillText(`${Number((1e3 * k * step).toPrecision(6))}`.replace("-", "−"), x, ground + 25);
  }
}

/** Says how the scales of ball and ruler differ. */
function drawNote(pen, height, colour, ratio) {
  pen.fillStyle = colour("pale");
  pen.font = "13px system-ui, sans-serif";
  pen.textAlign = "left";
  const words = ratio > 1 ? `${Number(ratio.toPrecision(2))} times larger` : `${Number((1 / ratio).toPrecision(2))} times smaller`;
  pen.fillText(`mm along the track; ball ${words}`, 12, height - 12);
}

function drawBall(pen, x, y, angle, colour) {
  const { radius } = view;
  const shade = pen.createRadialGradient(x - 0.35 * radius, y - 0.4 * radius, 0.1 * radius, x, y, radius);
  shade.addColorStop(0, colour("ball-light"));
  shade.addColorStop(1, colour("ball"));
  pen.fillStyle = shade;
  pen.beginPath();
  pen.arc(x, y, radius, 0, 2 * Math.PI);
  pen.fill();
  const speed = (Math.abs(live.report?.state?.speed ?? 0) * view.scale) / view.radius / 60; // turn per frame
  pen.globalAlpha = !view.touched ? 0.35 : live.held ? 1 : Math.max(0, Math.min(1, 1.4 - speed));
  pen.fillStyle = colour("ground");
  for (let k = 0; k < 3; k++) {
    const turn = (motionUnwanted.matches && !live.held ? 0 : angle) + (2 * Math.PI * k) / 3;
    pen.beginPath();
    pen.arc(x + 0.68 * radius * Math.sin(turn), y - 0.68 * radius * Math.cos(turn), 0.09 * radius, 0, 2 * Math.PI);
    pen.fill();
  }
  pen.globalAlpha = 1;
}

/** Draws arrows on both sides of a ball that nobody has touched. */
function drawHint(pen, x, y, colour) {
  const { radius } = view;
  pen.strokeStyle = pen.fillStyle = colour("accent");
  pen.lineWidth = 4;
  pen.lineCap = pen.lineJoin = "round";
  for (const side of [-1, 1]) {
    const from = x + side * (radius + 16), to = from + side * 44;
    pen.beginPath();
    pen.moveTo(from, y);
    pen.lineTo(to, y);
    pen.moveTo(to - side * 13, y - 13);
    pen.lineTo(to, y);
    pen.lineTo(to - side * 13, y + 13);
    pen.stroke();
  }
  pen.font = `600 ${Math.max(14, Math.round(radius / 4))}px system-ui, sans-serif`;
  pen.textAlign = "center";
  pen.fillStyle = colour("ball-text");
  pen.fillText("drag me", x, y + radius / 12);
}

/** Draws the solved contact nearest to the place of the ball, where the run has maps; its area is too small to flash. */
function drawLens() {
  const { maps } = runs[live.number], figure = $("#play-contact");
  if (!figure) return;
  figure.hidden = !maps;
  if (!maps) return;
  const now = performance.now(), map = nearestMap(maps);
  const ready = sheetOf(live.number).complete;
  if ((map === view.map && view.mapReady === ready) || now - view.mapAt < (motionUnwanted.matches && !live.held ? 1000 : LENS_MS)) return;
  Object.assign(view, { map, mapAt: now, mapReady: ready });
  const canvas = $("#play-lens"), pen = canvas.getContext("2d"), { width } = canvas;
  const perUm = width / 2.6 / maps.hertz_um, middle = width / 2;
  pen.fillStyle = "#000";
  pen.fillRect(0, 0, width, width);
  if (!ready) return;
  const [x, y, wide, high] = maps.tiles[map], [left, top, cell] = maps.boxes[map].map((um) => um * perUm);
  pen.imageSmoothingEnabled = false; // a cell is what was computed
  pen.drawImage(sheetOf(live.number), x, y, wide, high, middle + left, middle - top, wide * cell, high * cell);
}

/** Returns the map nearest to the place of the ball on the track, which closes. */
function nearestMap({ position_mm: places }) {
  const { shift, length } = live.report?.state ?? { shift: 0, length: Infinity };
  const away = places.map((place) => modulo(view.ball - shift - 1e-3 * place + length / 2, length) - length / 2);
  return Number.isFinite(length) ? away.reduce((best, distance, map) => (Math.abs(distance) < Math.abs(away[best]) ? map : best), 0) : 0;
}
