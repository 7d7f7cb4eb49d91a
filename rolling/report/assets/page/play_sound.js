// ---- the instrument: its processor, its worker, and their messages ----

import { $, FADE_S, runs, state } from "./core.js";
import { audioContext, soundAlone } from "./player.js";
import { showReport } from "./play_meter.js";
import { view, wakeStage } from "./play_view.js";
import { sayPlayed, showModes, showRolling, showSettings } from "./play_panel.js";
import { showExport } from "./play_export.js";
import { instrumentNode, leaveBody, throughBody } from "../engine/graph.js";

const LIMIT_DB = -1; // of full scale, above which the limiter compresses by 20
const UNDO_MAKEUP = 10 ** ((0.6 * LIMIT_DB * (1 - 1 / 20)) / 20); // of the gain that the limiter of the browser adds
const HOLD_S = 0.5; // that a lifted ball is held
const METER = 2048; // samples of the Fast level
export const SPECTRUM = 16384; // samples, whose lines resolve the third octave at 20 Hz

// `asked`: the worker prepares settings; `behind`: they have changed since. `push`: direction of a held arrow key. `fastest`: speed of the hand [m/s], which the time steps have to resolve. `dropped`: drops are wanted.
export const live = {
  number: -1, settings: {}, worker: null, opening: null, latest: null, asked: false, behind: false, refused: false,
  rolling: false, held: false, push: 0, direction: 1, fastest: 0, dropped: false, volume: 0, report: null, heardAt: 0,
  bus: null, meters: [], volumeNode: null, limiter: null, node: null, output: null, body: null,
};

export const liveOf = () => runs[live.number].live;
export const isPlayed = () => live.rolling || live.held || live.push !== 0;

export const engineUrl = () => `data:text/javascript;charset=utf-8,${encodeURIComponent($("#engine").textContent)}`;

/** Chooses the run that is played, with its own settings. */
export function takeRun(number) {
  if (number === live.number || !runs[number].live) return;
  const { settings } = runs[number].live;
  Object.assign(live, { number, settings: { ...settings }, dropped: settings.dropHeight !== null, direction: 1, fastest: 0 });
  showSettings();
  showExport();
  askSettings();
}

/** Starts the worker, which prepares the settings before anything is to be heard. */
export function openWorker() {
  if (live.worker) return;
  live.worker = new Worker(engineUrl());
  live.worker.onmessage = ({ data: message }) => {
    setAsked(false);
    if (message.failed) sayPlayed(`The engine cannot play these settings: ${message.failed}.`);
    else if (message.number === live.number) deliver(message);
    if (live.refused && !message.failed) sayPlayed("");
    live.refused = Boolean(message.failed);
    if (live.behind) askSettings();
  };
  live.worker.onerror = () => sayPlayed("The engine of the page does not start in this browser.");
  askSettings();
}

/** Asks for the present settings; while the worker prepares, only the last ones wait. */
export function askSettings() {
  if (!live.worker) return;
  live.behind = live.asked;
  if (live.asked) return;
  setAsked(true);
  live.worker.postMessage({ number: live.number, run: liveOf(), settings: preparedSettings() });
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

/** Lets prepared settings sound. */
function deliver({ number, settings, prepared }) {
  showModes(prepared.kept);
  live.latest = { number, settings, prepared };
  if (!live.bus) return;
  soundOn();
  sendVolume();
}

/** Fades into an instrument and a body of the latest settings, where the ball rolls on, or is lifted and falls. */
export function soundOn(falls = false) {
  const { body, node } = live;
  openNode(falls);
  live.body = throughBody(live.output, live.latest.prepared.responses, live.bus);
  if (body) leaveBody(body);
  setTimeout(() => node?.port.postMessage({ task: "end" }), 200); // it has faded by then
}

function openNode(falls) {
  const { latest: { number, settings, prepared }, report, heardAt } = live;
  const { position, speed } = report?.state ?? { position: prepared.start, speed: 0 };
  const from = { position: position + (speed * (performance.now() - heardAt)) / 1000, speed, hold: HOLD_S };
  const begun = { ...settings, dropHeight: falls ? settings.dropHeight : null };
  const { node, output } = instrumentNode(state.context, { run: runs[number].live, settings: begun, prepared, from });
  node.port.onmessage = ({ data: report }) => {
    if (node !== live.node) return;
    Object.assign(live, { report, heardAt: performance.now() });
    if (live.held) followHand(Math.abs(report.state.speed));
    showReport(report);
    wakeStage();
  };
  node.onprocessorerror = () => sayPlayed("The engine stopped because of an error.");
  Object.assign(live, { node, output });
  if (live.held) tellInstrument({ task: "drag", position: view.goal });
  else rollOn();
}

/** Starts the sound by a gesture of the user, and silences all other sound of the page. */
export async function startInstrument() {
  soundAlone(restBall);
  const context = audioContext();
  const started = context.resume();
  openWorker();
  await (live.opening ??= openGraph(context));
  await started;
}

/** Connects the pressure [Pa] with meters, and by its volume and a limiter with the output. */
async function openGraph(context) {
  if (!context.audioWorklet) {
    return sayPlayed("This browser has no AudioWorklet here (it takes a file, https or localhost), so the ball cannot be played; the rest of the page works.");
  }
  await context.audioWorklet.addModule(engineUrl());
  const bus = new GainNode(context);
  live.volumeNode = new GainNode(context, { gain: 0 });
  live.limiter = new DynamicsCompressorNode(context, { threshold: LIMIT_DB, knee: 0, ratio: 20, attack: 0, release: 0.25 });
  const clip = new WaveShaperNode(context, { curve: [-1, 0, 1] }); // of short peaks, which the limiter lets pass
  bus.connect(live.volumeNode).connect(live.limiter).connect(new GainNode(context, { gain: UNDO_MAKEUP })).connect(clip).connect(state.master);
  live.meters = [METER, SPECTRUM].map((fftSize) => new AnalyserNode(context, { fftSize, smoothingTimeConstant: 0, channelCount: 1, channelCountMode: "explicit", channelInterpretation: "discrete" }));
  for (const meter of live.meters) bus.connect(meter);
  live.bus = bus;
  if (live.latest) deliver(live.latest);
}

/** Sends a message to the processor; it is lost before the sound has started. */
export const tellInstrument = (message) => live.node?.port.postMessage(message);

export function sendVolume() {
  const scale = runs[live.number].playback.calibrated_pa ?? liveOf().fullScale;
  live.volumeNode?.gain.setTargetAtTime(10 ** (live.volume / 20) / scale, state.context.currentTime, FADE_S);
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
