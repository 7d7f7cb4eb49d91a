// ---- the hand: pointer, finger and keys on the ball, and the buttons below it ----

import { $, $$ } from "./core.js";
import { choose, say } from "./choices.js";
import { SETTINGS, backToScene, changeSetting, giveSpeed, playedRuns, roundedIn, shareAt, showRolling, showVolume, valueAt } from "./play_panel.js";
import { followHand, live, liveOf, openWorker, rollBall, rollOn, startInstrument, takeRun, tellInstrument, askSettings } from "./play_sound.js";
import { ballAt, drawStage, view, wakeStage } from "./play_view.js";
import { drawSpectrum, drawStrip } from "./play_meter.js";
import { copyYaml, saveWav, showExport } from "./play_export.js";

const FALL_MS = 500; // that a lifted ball is held
export const POLL_MS = 30;
const REST_M_S = 0.01; // below which a ball that is let go stays where it is

const hand = { grip: 0, sent: false };

/** Prepares the instrument of the first run that can be played, once its picture is in sight. */
export function beginPlaying() {
  const [first] = playedRuns();
  if (first === undefined) return;
  const stage = $("#play-stage");
  const on = (element, type, act) => element.addEventListener(type, act);
  for (const [type, act] of [["pointerdown", grab], ["pointermove", pull], ["pointerup", letGo], ["pointercancel", letGo]]) on(stage, type, act);
  on(stage, "keydown", pressKey);
  on(stage, "keyup", ({ key }) => key.startsWith("Arrow") && push(0));
  on(stage, "blur", () => push(0));
  on($("#play-roll"), "click", () => rollBall(!live.rolling));
  on($("#play-drop"), "click", dropBall);
  on($("#play-back"), "click", backToScene);
  on($("#play-copy"), "click", () => copyYaml($("#play-copy")));
  on($("#play-wav"), "click", saveWav);
  on($("#play-volume"), "input", ({ target }) => { live.volume = Number(target.value); showVolume(); });
  for (const radio of $$("input[name=play-run]")) on(radio, "change", () => choose(Number(radio.value)));
  new ResizeObserver(redrawPlayed).observe(stage);
  new IntersectionObserver(([{ isIntersecting }]) => {
    view.seen = isIntersecting;
    if (isIntersecting) openWorker();
    wakeStage();
  }, { rootMargin: "200px" }).observe(stage);
  if (live.number < 0) takeRun(first);
  showVolume();
}

/** Draws the canvases again, in another size or other colours. */
export function redrawPlayed() {
  if (live.number < 0) return;
  drawStage();
  drawStrip();
  drawSpectrum();
}

const placeOf = (event) => {
  const box = $("#play-stage").getBoundingClientRect();
  return view.camera + (event.clientX - box.left - box.width / 2) / view.scale;
};

function grab(event) {
  if (event.button > 0) return;
  event.currentTarget.setPointerCapture(event.pointerId);
  event.currentTarget.focus({ preventScroll: true });
  const reach = Math.abs(placeOf(event) - view.ball) * view.scale;
  hand.grip = reach < 1.3 * view.radius ? placeOf(event) - view.ball : 0; // a hand beside the ball calls it
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

const KEYS_HELD = { ArrowLeft: -1, ArrowRight: 1 };

function pressKey(event) {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  const act = {
    " ": () => rollBall(!live.rolling),
    Enter: () => rollBall(!live.rolling),
    ArrowUp: () => stepSpeed(0.03),
    ArrowDown: () => stepSpeed(-0.03),
    Home: backToScene,
    d: dropBall,
  }[event.key];
  if (event.key in KEYS_HELD) push(KEYS_HELD[event.key]);
  else if (act) act();
  else return;
  event.preventDefault();
}

/** Rolls to one side as long as a key is held. */
function push(direction) {
  if (live.push === direction) return;
  live.push = direction;
  view.touched = true;
  if (direction) startInstrument().then(rollOn);
  else rollOn();
}

function stepSpeed(by) {
  const [setting] = SETTINGS, range = liveOf().limits.speed;
  const share = Math.min(Math.max(shareAt(live.settings.speed, range) + by, 0), 1);
  changeSetting(setting, roundedIn(valueAt(share, range), 1));
}

/** Lifts the ball and lets it fall. */
async function dropBall() {
  if ($("#play-drop").hidden) return;
  view.touched = live.dropped = true;
  showExport();
  askSettings();
  await startInstrument();
  await isReady();
  tellInstrument({ task: "lift", height: live.settings.dropHeight });
  say("lifted");
  await later(FALL_MS);
  tellInstrument({ task: "drop" });
}

export const later = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));

/** Waits until the instrument sounds and has taken the present settings. */
async function isReady() {
  while (!live.report || live.asked) await later(POLL_MS);
}
