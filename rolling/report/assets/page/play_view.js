// ---- the picture of the ball on its track ----

import { $, modulo, motionUnwanted, runs } from "./core.js";
import { digits } from "./play_meter.js";
import { heardPosition, live, liveOf } from "./play_live.js";
import { drawLensMap } from "./contact.js";
import { drawPlan } from "./play_plan.js";

const CENTRING_S = 0.35; // in which a ball that is let go comes back to the middle
const HAND_PX_S = 500; // speed of a hand that rolls the ball as fast as its run
const MARKS_PX = 100; // distance of marks on the plate, as the style has it
const BLURRED_PX = 35; // travel of the plate in a frame beyond which all marks are invisible
const LENS_MS = 120; // that a map stays under the lens at least

// Lengths in metres, `scale` along the track in pixels per metre; the ball has a scale of its own. `camera` is in the middle of the picture, `ball` is where the ball is drawn, `goal` where the hand is, `grip` away from the middle of the ball.
export const view = { camera: 0, ball: 0, goal: 0, grip: 0, asked: false, seen: false, drawnAt: 0, map: "", mapAt: 0, scale: 1, radius: 1 };

/** Draw the next frame soon, if the picture is in sight. */
export function wakeStage() {
  if (view.asked || !view.seen) return;
  view.asked = true;
  requestAnimationFrame((now) => {
    view.asked = false;
    moveBall(Math.min((now - view.drawnAt) / 1000, 0.1));
    view.drawnAt = now;
    drawStage();
    drawLens();
    drawPlan(view.ball);
    if (live.held || (live.report && !live.report.asleep)) wakeStage();
  });
}

/** Move ball and camera: the ball follows a hand, and the camera follows a free ball. */
function moveBall(passed) {
  const before = view.ball;
  view.ball = live.held ? view.goal : heardPosition(view.ball);
  if (live.held) return;
  view.camera += view.ball - before;
  view.camera += (view.ball - view.camera) * (motionUnwanted.matches ? 1 : 1 - Math.exp(-passed / CENTRING_S));
}

/** Set the lengths that place plate and ball by their styles. */
function drawStage() {
  const stage = $("#play-stage"), ball = $("#play-ball"), run = liveOf();
  const { height = 0, speed = 0 } = live.report?.state ?? {};
  view.radius = ball.offsetWidth / 2;
  view.scale = HAND_PX_S / run.settings.speed;
  const enlarged = view.radius / run.fixed.radius, room = ball.offsetTop - 10; // pixels per metre of the ball; pixels above it
  const ratio = enlarged / view.scale, isStill = motionUnwanted.matches && !live.held;
  const passing = live.held ? 0 : (Math.abs(speed) * view.scale) / 60; // in a frame
  const lengths = {
    "--x": (view.ball - view.camera) * view.scale,
    "--lift": room * (1 - Math.exp((-height * enlarged) / room)),
    "--depth": enlarged * Math.min(live.settings.thickness ?? 1, 1),
    "--shift": stage.clientWidth / 2 - (isStill ? 0 : modulo(view.camera * view.scale, MARKS_PX)),
  };
  for (const [name, length] of Object.entries(lengths)) stage.style.setProperty(name, `${length}px`);
  stage.style.setProperty("--turn", `${isStill ? 0 : (view.ball * view.scale) / view.radius}rad`);
  stage.style.setProperty("--clear", Math.max(0, 1 - passing / BLURRED_PX));
  const size = `${digits(Math.max(ratio, 1 / ratio), 2)} times ${ratio > 1 ? "larger" : "smaller"}`, place = (1e3 * view.ball).toFixed(0);
  const motion = live.held ? "held" : live.rolling ? `rolls at ${digits(live.settings.speed, 3)} m/s` : "at rest";
  $("#play-ruler").textContent = `at ${place} mm; marks every ${digits((1e3 * MARKS_PX) / view.scale, 3)} mm; ball ${size}`;
  stage.setAttribute("aria-valuenow", place);
  stage.setAttribute("aria-valuetext", `${place} mm along the track, ${motion}`);
}

/** Draw the solved contact nearest to the ball if the run has maps; its area is too small to flash. */
function drawLens() {
  const { maps } = runs[live.number];
  if (!maps) return;
  const now = performance.now(), map = isFlying() ? -1 : nearestMap(maps), key = `${live.number} ${map}`;
  if (key === view.map || now - view.mapAt < (motionUnwanted.matches && !live.held ? 1000 : LENS_MS)) return;
  Object.assign(view, { map: key, mapAt: now });
  const canvas = $("#play-lens");
  $("#play-lens-words").textContent = map < 0 ? "nothing touches" : "contact under the ball";
  if (map < 0) canvas.getContext("2d").clearRect(0, 0, canvas.width, canvas.height);
  else drawLensMap(canvas, maps, map, () => {
    Object.assign(view, { map: "", mapAt: 0 });
    drawLens();
  });
}

/** Tell whether the ball has mostly flown in the time of the last report: impacts are short. */
function isFlying() {
  const { flies } = live.report ?? { flies: [0] };
  return flies.reduce((sum, share) => sum + share, 0) > flies.length / 2;
}

/** Return the map nearest to the place of the ball on the track, which closes. */
function nearestMap({ position_mm: places }) {
  if (!live.report) return 0;
  const { length } = live.report.state, { start } = live.sounding.prepared;
  const ball = start + modulo(view.ball - start, length); // of a long track the page has a part
  const away = places.map((place) => Math.abs(ball - 1e-3 * place));
  return away.indexOf(Math.min(...away));
}
