// ---- the hand: pointer, finger and keys on the ball, and the buttons below it ----

import { $, $$, say } from "./core.js";
import { choose } from "./begin.js";
import { SETTINGS, backToScene, giveSpeed, listenToSlider, playedRuns, setVolume, shareAt, showRolling, valueAt } from "./play_panel.js";
import { followHand, live, liveOf, openWorker, rollBall, rollOn, soundOn, startInstrument, takeRun, tellInstrument, askSettings } from "./play_sound.js";
import { ballAt, drawStage, view, wakeStage } from "./play_view.js";
import { drawSpectrum, drawStrip } from "./play_meter.js";
import { copyYaml, saveWav, showExport } from "./play_export.js";

export const POLL_MS = 30; // between questions whether the instrument is ready
const REST_M_S = 0.01; // below which a ball that is let go stays where it is
const KEY_STEP = 0.03; // of the slider of the speed

const hand = { grip: 0, sent: false };

/** Prepares the instrument of the first run that can be played, once its picture is in sight. */
export function beginPlaying() {
  const [first] = playedRuns();
  if (first === undefined) return;
  const stage = $("#play-stage");
  const acts = { pointerdown: grab, pointermove: pull, pointerup: letGo, pointercancel: letGo, keydown: pressKey, keyup: releaseKey, blur: () => push(0) };
  for (const [type, act] of Object.entries(acts)) stage.addEventListener(type, act);
  const clicks = { roll: turnRolling, drop: dropBall, back: backToScene, copy: () => copyYaml($("#play-copy")), wav: saveWav };
  for (const [name, act] of Object.entries(clicks)) $(`#play-${name}`).addEventListener("click", act);
  $("#play-volume").addEventListener("input", ({ target }) => setVolume(Number(target.value)));
  for (const radio of $$("input[name=play-run]")) radio.addEventListener("change", () => choose(Number(radio.value)));
  SETTINGS.forEach(listenToSlider);
  new ResizeObserver(redrawPlayed).observe(stage);
  new IntersectionObserver(([{ isIntersecting }]) => {
    view.seen = isIntersecting;
    if (isIntersecting) openWorker();
    wakeStage();
  }, { rootMargin: "200px" }).observe(stage);
  if (live.number < 0) takeRun(first);
  setVolume(0);
}

/** Draws the canvases again, in another size or other colours. */
export function redrawPlayed() {
  if (live.number < 0) return;
  drawStage();
  drawStrip();
  drawSpectrum();
}

const placeOf = ({ clientX }) => {
  const { left, width } = $("#play-stage").getBoundingClientRect();
  return view.camera + (clientX - left - width / 2) / view.scale;
};

function grab(event) {
  if (event.button > 0) return;
  event.currentTarget.setPointerCapture(event.pointerId);
  event.currentTarget.focus({ preventScroll: true });
  const away = placeOf(event) - view.ball;
  hand.grip = Math.abs(away) * view.scale < 1.3 * view.radius ? away : 0; // a hand beside the ball calls it
  Object.assign(live, { held: true, rolling: false });
  Object.assign(view, { touched: true, goal: view.ball });
  startInstrument();
  showRolling();
  pull(event);
}

function pull(event) {
  if (!live.held) return;
  view.goal = placeOf(event) - hand.grip;
  if (hand.sent) return;
  hand.sent = true; // at most one message in a frame
  requestAnimationFrame(() => {
    hand.sent = false;
    if (live.held) tellInstrument({ task: "drag", position: view.goal });
  });
  wakeStage();
}

/** Lets the ball roll on at its speed, or rest; at that of the run where a first touch has only opened the sound. */
function letGo() {
  if (!live.held) return;
  const speed = live.report ? live.report.state.speed : live.settings.speed;
  const rolls = Math.abs(speed) > REST_M_S;
  Object.assign(live, { held: false, direction: speed < 0 ? -1 : 1 });
  view.offset = ballAt();
  if (rolls) giveSpeed(Math.abs(speed));
  followHand(0);
  rollBall(rolls);
}

const turnRolling = () => rollBall(!live.rolling);

const STAGE_KEYS = {
  " ": turnRolling,
  ArrowLeft: () => push(-1),
  ArrowRight: () => push(1),
  ArrowUp: () => stepSpeed(KEY_STEP),
  ArrowDown: () => stepSpeed(-KEY_STEP),
  Home: backToScene,
  d: dropBall,
};

function pressKey(event) {
  if (event.ctrlKey || event.altKey || event.metaKey || !STAGE_KEYS[event.key]) return;
  STAGE_KEYS[event.key]();
  event.preventDefault();
}

function releaseKey({ key }) {
  if (key === "ArrowLeft" || key === "ArrowRight") push(0);
}

/** Rolls to one side as long as a key is held. */
async function push(direction) {
  if (live.push === direction) return;
  live.push = direction;
  view.touched = true;
  if (direction) await startInstrument();
  rollOn();
}

function stepSpeed(by) {
  const range = liveOf().limits.speed;
  giveSpeed(valueAt(shareAt(live.settings.speed, range) + by, range));
}

/** Lifts the ball and lets it fall. */
async function dropBall() {
  if ($("#play-drop").hidden) return;
  view.touched = live.dropped = true;
  showExport();
  askSettings();
  await startInstrument();
  while (!live.report || live.asked) await later(POLL_MS); // until it sounds with the present settings
  soundOn(true);
  say("lifted");
}

export const later = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));
