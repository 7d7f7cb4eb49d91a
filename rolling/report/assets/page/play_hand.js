// ---- the hand: pointer, finger and keys on the ball, and the buttons below it ----

import { $, runs, say } from "./core.js";
import { live, liveOf, tellInstrument } from "./play_live.js";
import { giveSpeed, listenToSliders, showRun, takeRun } from "./play_panel.js";
import { shareAt, valueAt } from "./play_settings.js";
import { askSettings, openWorker, prepareSound, rollBall, rollOut, soundOn, startInstrument } from "./play_sound.js";
import { view, wakeStage } from "./play_view.js";
import { copyYaml, saveWav, showExport } from "./play_export.js";

const REST_M_S = 0.01; // below which a ball that is let go stays where it is
const IDLE_MS = 1000; // after which the sound is prepared, even if the page has never been idle
const KEY_STEP = 0.03; // of the slider of the speed

const STAGE_KEYS = {
  " ": turnRolling,
  ArrowLeft: () => rollBall(-1),
  ArrowRight: () => rollBall(1),
  ArrowUp: () => stepSpeed(KEY_STEP),
  ArrowDown: () => stepSpeed(-KEY_STEP),
  Home: showRun,
  d: dropBall,
};

/** Prepare the instrument of the first run that can be played, once its picture is in sight. */
export function beginPlaying() {
  const first = runs.findIndex((run) => run.live), stage = $("#play-stage");
  if (first < 0) return;
  const acts = { pointerdown: grab, pointermove: pull, pointerup: letGo, pointercancel: letGo, keydown: pressKey, keyup: releaseKey };
  for (const [type, act] of Object.entries(acts)) stage.addEventListener(type, act);
  const clicks = { roll: turnRolling, out: rollOut, drop: dropBall, back: showRun, copy: () => copyYaml($("#play-copy")), wav: saveWav };
  for (const [name, act] of Object.entries(clicks)) $(`#play-${name}`).addEventListener("click", act);
  listenToSliders();
  new ResizeObserver(wakeStage).observe(stage);
  new IntersectionObserver((entries) => {
    view.seen = entries.at(-1).isIntersecting;
    if (view.seen) openWorker();
    wakeStage();
  }, { rootMargin: "200px" }).observe(stage);
  if (live.number < 0) takeRun(first);
  whenIdle(prepareSound);
}

/** Do work once the page has nothing else to do. */
function whenIdle(work) {
  if (window.requestIdleCallback) requestIdleCallback(work, { timeout: IDLE_MS });
  else setTimeout(work, IDLE_MS);
}

const placeOf = ({ clientX }) => {
  const { left, width } = $("#play-stage").getBoundingClientRect();
  return view.camera + (clientX - left - width / 2) / view.scale;
};

function grab(event) {
  if (event.button > 0) return;
  const stage = event.currentTarget, away = placeOf(event) - view.ball;
  stage.setPointerCapture(event.pointerId);
  stage.focus({ preventScroll: true });
  stage.classList.add("touched");
  view.grip = Math.abs(away) * view.scale < 1.3 * view.radius ? away : 0; // a hand beside the ball calls it
  live.held = true;
  rollBall(0);
  startInstrument();
  pull(event);
}

function pull(event) {
  if (!live.held) return;
  view.goal = placeOf(event) - view.grip;
  tellInstrument({ task: "drag", position: view.goal });
  wakeStage();
}

/** Let the ball roll on at its present speed, or rest; before the first report, at the set speed. */
function letGo() {
  if (!live.held) return;
  const speed = live.report ? live.report.state.speed : live.settings.speed;
  Object.assign(live, { held: false, fastest: 0 });
  if (Math.abs(speed) > REST_M_S) giveSpeed(Math.abs(speed));
  else askSettings();
  rollBall(Math.abs(speed) > REST_M_S ? Math.sign(speed) : 0);
}

function turnRolling() {
  rollBall(live.rolling ? 0 : 1);
}

function pressKey(event) {
  if (event.ctrlKey || event.altKey || event.metaKey || !STAGE_KEYS[event.key]) return;
  event.preventDefault();
  if (!event.repeat || event.key.startsWith("Arrow")) STAGE_KEYS[event.key]();
}

function releaseKey({ key }) {
  if (key === "ArrowLeft" || key === "ArrowRight") rollBall(0);
}

function stepSpeed(by) {
  const range = liveOf().limits.speed;
  giveSpeed(valueAt(shareAt(live.settings.speed, range) + by, range));
}

/** Lift and drop the ball once the present settings are prepared. */
async function dropBall() {
  if ($("#play-drop").hidden) return;
  live.dropped = true;
  showExport();
  askSettings({ silent: true });
  await startInstrument({ silent: true });
  await live.preparing;
  if (live.refused || !live.bus) return;
  soundOn(true);
  say("lifted");
}
