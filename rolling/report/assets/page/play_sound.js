// ---- the instrument: its processor, its worker, and their messages ----

import { $, FADE_S, runs, say, state } from "./core.js";
import { RATE } from "../engine/rate.js";
import { RESTING_MS, audioContext, restContext, soundAlone, sounds, starting } from "./audio.js";
import { SPECTRUM, freeSpeed, heardPosition, live, liveOf, tellInstrument } from "./play_live.js";
import { isFaint, showReport } from "./play_meter.js";
import { sayPlayed, sayPreparing, showModes } from "./play_notes.js";
import { view, wakeStage } from "./play_view.js";
import { instrumentNode, leaveBody, limiterNode, throughBody } from "../engine/graph.js";
import { stepsPerSample } from "../engine/motion.js";

const OUT_MS = 40; // from one speed of a ball that rolls out to the next
const LATE_MS = 400; // after which the page says that it prepares settings
const FADED_MS = 200; // after which an instrument has faded out
const HOLD_S = 0.15; // that a lifted ball is held, long enough to be seen; an impact is heard within half a second
const METER = 2048; // samples of the Fast level

export const engineUrl = () => `data:text/javascript;charset=utf-8,${encodeURIComponent($("#engine").textContent)}`;

// ---- prepared settings ----

/** Start the worker and prepare the settings, before a sound is wanted. */
export function openWorker() {
  if (live.worker) return;
  live.worker = new Worker(engineUrl());
  askSettings();
}

/** Prepare the sound while the page is idle: a browser starts it by a gesture only, and may load it before. */
export async function prepareSound() {
  openWorker();
  if (window.AudioContext) await (live.opening ??= openGraph(audioContext()));
  setTimeout(restContext, RESTING_MS);
}

/** Prepare the present settings; while the worker prepares others, only the last ones wait. A caller that is `silent` makes the sound itself. */
export function askSettings({ silent = false } = {}) {
  const again = live.preparing ? null : steppedAgain(preparedSettings());
  if (again) {
    const isSame = again.prepared.steps === live.latest.prepared.steps;
    if (isSame && live.sounding === live.latest) live.sounding = again;
    live.latest = again;
    if (!isSame && !silent) soundOn();
    return;
  }
  live.behind = true;
  if (live.worker) live.preparing ??= prepareSettings();
}

/** Return the latest settings at another speed or fall, which change the time steps alone; null where more has changed. */
function steppedAgain(settings) {
  const { latest, number } = live;
  const isSame = (name) => name === "speed" || name === "dropHeight" || settings[name] === latest.settings[name];
  if (latest?.number !== number || !Object.keys(settings).every(isSame)) return null;
  const { prepared } = latest, isRelease = prepared.kind === "release";
  return { number, settings, prepared: isRelease ? prepared : { ...prepared, steps: stepsPerSample(liveOf(), settings, prepared.chain) } };
}

async function prepareSettings() {
  $(".stage").setAttribute("aria-busy", "true");
  const late = setTimeout(() => sayPreparing(live.node ? "Preparing the new settings; the old ones sound until then." : "Preparing the instrument."), LATE_MS);
  while (live.behind && live.worker) {
    live.behind = false;
    const { number, failed, settings, prepared } = await answerTo({ number: live.number, run: liveOf(), settings: preparedSettings() });
    if (failed) sayPlayed(`The engine cannot play these settings: ${failed}.`);
    else if (live.refused) sayPlayed("");
    if (failed && number === undefined) live.worker = null; // so that the next use starts another
    live.refused = Boolean(failed);
    if (failed || number !== live.number) continue;
    live.latest = { number, settings, prepared };
    showModes(prepared.kept);
    soundOn();
  }
  live.preparing = null;
  clearTimeout(late);
  sayPreparing("");
  $(".stage").setAttribute("aria-busy", "false");
  setTimeout(restContext, RESTING_MS);
}

const answerTo = (question) => new Promise((answered) => {
  live.worker.onmessage = ({ data: answer }) => answered(answer);
  live.worker.onerror = () => answered({ failed: "it does not start in this browser" });
  live.worker.postMessage(question);
});

/** Return the settings at the speed of the hand, with a drop height only after a drop. */
function preparedSettings() {
  const { settings, fastest, dropped } = live;
  const least = 0.01 * liveOf().limits.speed[1]; // for the choice of modes, which a ball at rest does not make
  return { ...settings, speed: Math.max(settings.speed, fastest, least), dropHeight: dropped ? settings.dropHeight : null };
}

/** Let the time steps follow a hand that has become faster. */
function followHand(speed) {
  if (speed <= Math.max(live.fastest, live.settings.speed)) return;
  live.fastest = Math.min(2 * speed, liveOf().limits.speed[1]);
  askSettings();
}

// ---- sound ----

/** Cross-fade to the instrument and responses of the latest settings; the ball rolls on or falls. */
export function soundOn(falls = false) {
  const { bus, latest, node, body } = live;
  if (latest?.number !== live.number || !bus || live.resting) return;
  live.sounding = latest;
  live.body = throughBody(openNode(latest, falls), latest.prepared.responses, bus);
  if (body) leaveBody(body);
  setTimeout(() => node?.port.postMessage({ task: "end" }), FADED_MS);
  sendVolume();
  if (state.context.state === "suspended") live.resting = true; // until the ball is touched
}

/** Make the instrument of prepared settings, and return its output. */
function openNode({ number, settings, prepared }, falls) {
  const from = { position: heardPosition(prepared.start), speed: live.report?.state.speed ?? 0, hold: HOLD_S };
  const begun = { ...settings, dropHeight: falls ? settings.dropHeight : null };
  const { node, output } = instrumentNode(state.context, { run: runs[number].live, settings: begun, prepared, from });
  node.port.onmessage = ({ data: report }) => {
    if (node !== live.node) return;
    Object.assign(live, { report, heardAt: performance.now() });
    if (live.held) followHand(Math.abs(report.state.speed));
    showReport(report);
    wakeStage();
    live.asleepAt = report.asleep ? live.asleepAt ?? state.context.currentTime : null;
    restContext();
  };
  node.onprocessorerror = () => sayPlayed("The engine stopped because of an error.");
  Object.assign(live, { node, asleepAt: null });
  if (live.held) tellInstrument({ task: "drag", position: view.goal });
  else rollOn();
  return output;
}

/** Start the sound by a gesture of the user, and silence all other sound of the page. */
export async function startInstrument({ silent = false } = {}) {
  soundAlone(restBall);
  live.asleepAt = null;
  await starting(async () => {
    const context = audioContext(), started = context.resume();
    openWorker();
    await (live.opening ??= openGraph(context));
    await started;
  });
  const isNew = live.resting && live.sounding !== live.latest;
  live.resting = false;
  joinGraph();
  if (isNew && !silent) soundOn();
}

/** Tell whether the ball is held, moves, rings out on its plate, or will sound once it is prepared. */
export function isBallHeard() {
  const { node, preparing, rolling, held, asleepAt, sounding } = live;
  if (preparing || rolling !== 0 || held) return true;
  if (!node || !live.joined) return false;
  const rings = sounding.prepared.responses[0].length / RATE;
  return asleepAt === null || (!isFaint() && state.context.currentTime < asleepAt + rings);
}

/** Connect the pressure [Pa] with the meters, and through volume and limiter with the output. */
async function openGraph(context) {
  if (!context.audioWorklet) {
    return sayPlayed("This browser has no AudioWorklet here (it takes a file, https or localhost), so the ball cannot be played.");
  }
  try {
    await context.audioWorklet.addModule(engineUrl());
  } catch (error) {
    live.opening = null; // the next touch tries again
    return sayPlayed(`The engine cannot be loaded: ${error.message}.`);
  }
  const bus = new GainNode(context), volume = new GainNode(context, { gain: 0 });
  const limiter = limiterNode(context);
  limiter.port.onmessage = ({ data: gain }) => { live.limited = gain; };
  volume.connect(limiter);
  const first = { smoothingTimeConstant: 0, channelCount: 1, channelCountMode: "explicit", channelInterpretation: "discrete" }; // channel
  const meters = [METER, SPECTRUM].map((fftSize) => new AnalyserNode(context, { fftSize, ...first }));
  Object.assign(live, { bus, volume, limiter, meters });
  soundOn();
}

/** Connect the instrument with its way out and its meters; before the first touch it takes no time of the processor. */
function joinGraph() {
  const { bus, volume, limiter, meters } = live;
  if (!bus) return;
  live.joined = true;
  limiter.connect(state.master);
  for (const node of [volume, ...meters]) bus.connect(node);
}

/** Let the gain glide to the volume of the slider and the scale of the chosen run. */
export function sendVolume() {
  const run = runs[live.number], { playback } = (liveOf().kind === "release" && run.released) || run;
  const scale = playback.calibrated_pa ?? liveOf().fullScale;
  live.volume?.gain.setTargetAtTime(10 ** ($("#play-volume").value / 20) / scale, state.context.currentTime, FADE_S);
}

/** Let the ball roll at the speed of the settings, or rest. */
export const rollOn = () => tellInstrument({ task: "roll", speed: live.rolling * freeSpeed() });

/** Roll the ball to one side (1, -1), or stop it (0); it keeps its speed. */
export async function rollBall(direction) {
  live.out = null;
  live.rolling = direction;
  $("#play-roll span").textContent = direction ? "Stop" : "Roll";
  $("#play-roll").toggleAttribute("data-playing", direction !== 0);
  if (direction) await startInstrument();
  else setTimeout(restContext, RESTING_MS);
  rollOn();
}

/** Return the slowing [m/s2] of a free ball: 5/7 c times load over mass. */
function slowingOf({ fixed, settings }) {
  const mass = fixed.mass * ((live.settings.ballDensity ?? 1) / (settings.ballDensity ?? 1));
  return (5 / 7) * fixed.resistance * (fixed.weight ? fixed.gravity : live.settings.load / mass);
}

/** Let the ball roll out from the set speed until it rests. */
export async function rollOut() {
  await rollBall(live.rolling || 1);
  const out = { speed: live.settings.speed, slowing: slowingOf(liveOf()), begun: performance.now() };
  live.out = out;
  const { resistance } = liveOf().fixed, seconds = Number((out.speed / out.slowing).toPrecision(2));
  say(`rolls out, at rest after ${seconds} s`);
  $("#play-out-words").textContent = `Rolling resistance of ${resistance}: at rest ${seconds} s after it begins.`;
  const clock = setInterval(() => {
    if (live.out !== out) return clearInterval(clock);
    if (freeSpeed() > 0) rollOn();
    else rollBall(0);
    return wakeStage();
  }, OUT_MS);
}

/** Stop the ball, because another sound of the page starts. */
export function restBall() {
  if (live.rolling || live.held) rollBall(0);
}

sounds.push({ stop: restBall, isHeard: isBallHeard, rest: () => { live.resting = live.node !== null; } });
