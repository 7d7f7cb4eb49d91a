// ---- the instrument: its processor, its worker, and their messages ----

import { $, playbackOf, runs, state } from "./core.js";
import { audioContext, pause } from "./player.js";
import { stopFilm } from "./film_sound.js";
import { showReport } from "./play_meter.js";
import { wakeStage } from "./play_view.js";
import { sayPlayed, showModes, showRolling, showSettings } from "./play_panel.js";
import { showExport, showProgress } from "./play_export.js";

// `asked`: the worker prepares settings; `behind`: they have changed since. `push`: direction of a held arrow key. `fastest`: speed of the hand [m/s], which the time steps have to resolve. `dropped`: drops are wanted.
export const live = {
  number: -1, settings: {}, worker: null, node: null, opening: null, waiting: null, asked: false, behind: false, refused: false,
  rolling: false, held: false, push: 0, direction: 1, fastest: 0, dropped: false, volume: 0, report: null, heardAt: 0,
};

export const liveOf = () => runs[live.number].live;
export const isPlayed = () => live.rolling || live.held || live.push !== 0;

const engineUrl = () => `data:text/javascript;charset=utf-8,${encodeURIComponent($("#engine").textContent)}`;

/** Chooses the run that is played, with its own settings. */
export function takeRun(number) {
  if (number === live.number || !runs[number].live) return;
  const { settings } = runs[number].live;
  Object.assign(live, { number, settings: { ...settings }, dropped: settings.dropHeight !== null, direction: 1, fastest: 0 });
  showSettings();
  showExport();
  if (live.worker) sendRun();
}

/** Starts the worker, which prepares the settings before anything is to be heard. */
export function openWorker() {
  if (live.worker) return;
  live.worker = new Worker(engineUrl());
  live.worker.onmessage = ({ data: message }) => {
    if (message.task !== "prepare" && message.failed !== "prepare") return showProgress(message);
    setAsked(false);
    if (message.failed) sayPlayed(`The engine cannot play these settings: ${message.message}.`);
    else if (message.number === live.number) deliver(message);
    if (live.refused && !message.failed) sayPlayed("");
    live.refused = Boolean(message.failed);
    if (live.behind) askSettings();
  };
  live.worker.onerror = () => sayPlayed("The engine of the page does not start in this browser.");
  sendRun();
}

function sendRun() {
  const message = { task: "run", number: live.number, run: liveOf() };
  live.worker.postMessage(message);
  live.node?.port.postMessage(message);
  askSettings();
}

/** Asks for the present settings; while the worker prepares, only the last ones wait. */
export function askSettings() {
  if (!live.worker) return;
  live.behind = live.asked;
  if (live.asked) return;
  setAsked(true);
  live.worker.postMessage({ task: "prepare", number: live.number, settings: preparedSettings() });
}

function setAsked(asked) {
  live.asked = asked;
  $(".stage").setAttribute("aria-busy", String(asked));
}

/** Returns the settings with the speed of the hand, and a height only where the ball is dropped. */
export function preparedSettings() {
  const { settings, fastest, dropped } = live;
  const least = 0.01 * liveOf().limits.speed[1]; // for the choice of modes, which a ball at rest does not make
  return { ...settings, speed: Math.max(settings.speed, fastest, least), dropHeight: dropped ? settings.dropHeight : null };
}

/** Lets the time steps follow a hand that has become faster, or rests. */
export function followHand(speed) {
  const most = liveOf().limits.speed[1];
  if (speed > 0 && speed <= Math.max(live.fastest, live.settings.speed)) return;
  live.fastest = Math.min(2 * speed, most);
  askSettings();
}

function deliver({ number, settings, prepared }) {
  showModes(prepared.kept);
  live.waiting = { task: "play", number, settings, prepared };
  if (!live.node) return;
  live.node.port.postMessage(live.waiting);
  live.waiting = null;
  sendVolume();
}

/** Starts the sound by a gesture of the user, and silences all other sound of the page. */
export async function startInstrument() {
  if (state.wanted) pause();
  stopFilm();
  const context = audioContext();
  const started = context.resume();
  openWorker();
  await (live.opening ??= openNode(context));
  await started;
}

async function openNode(context) {
  if (!context.audioWorklet) {
    return sayPlayed("This browser has no AudioWorklet here (it takes a file, https or localhost), so the ball cannot be played; the rest of the page works.");
  }
  await context.audioWorklet.addModule(engineUrl());
  const count = Math.max(...runs.map((run) => Math.min(run.live?.listeners?.length ?? 1, 2)));
  const node = new AudioWorkletNode(context, "instrument", { numberOfInputs: 0, outputChannelCount: [count] });
  node.connect(state.master);
  node.port.onmessage = ({ data: report }) => {
    if (!report.state) return;
    Object.assign(live, { report, heardAt: performance.now() });
    if (live.held) followHand(Math.abs(report.state.speed));
    showReport(report);
    wakeStage();
  };
  node.onprocessorerror = () => sayPlayed("The engine stopped because of an error.");
  live.node = node;
  node.port.postMessage({ task: "run", number: live.number, run: liveOf() });
  if (live.waiting) deliver(live.waiting);
  sendVolume();
}

/** Sends a message to the processor; it is lost before the sound has started. */
export const tellInstrument = (message) => live.node?.port.postMessage(message);

export function sendVolume() {
  const scale = playbackOf(live.number).calibrated_pa ?? liveOf().fullScale;
  tellInstrument({ task: "gain", gain: 10 ** (live.volume / 20) / scale });
}

/** Lets the ball roll at the speed of the settings, in the direction of a held key, or rest. */
export function rollOn() {
  const { rolling, push, direction, settings } = live;
  tellInstrument({ task: "roll", speed: (push || (rolling ? direction : 0)) * settings.speed });
}

/** Rolls or stops; a ball that rests at speed 0 takes that of its scene. */
export async function rollBall(rolling) {
  live.rolling = rolling;
  showRolling();
  if (rolling) await startInstrument();
  rollOn();
}

/** Lets the ball come to rest because another sound of the page starts. */
export function restBall() {
  if (isPlayed()) rollBall(false);
}
