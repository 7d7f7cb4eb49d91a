// Entry of the engine: the audio processor of the page, and in a Worker the preparation and the records.

import { prepare } from "./prepare.js";
import { record } from "./record.js";
import { Stage } from "./stage.js";
import { arraysOf, waveFile } from "./wave.js";

/** Register the processor, which obeys messages of the page and reports to it. */
export function registerInstrument() {
  registerProcessor("instrument", class extends AudioWorkletProcessor {
    constructor({ outputChannelCount }) {
      super();
      this.stage = new Stage(outputChannelCount[0], sampleRate);
      this.port.onmessage = ({ data }) => this.stage.obey(data);
    }

    process(_, [channels]) {
      const report = this.stage.fill(channels);
      if (report) this.port.postMessage(report, [report.pressure.buffer, report.forces.buffer, report.flights.buffer]);
      return true;
    }
  });
}

const workerRuns = [];

/** Answer a message of the page: keep a run, prepare settings, or make a record. */
export function answer({ data: { task, number, run, settings, seconds } }) {
  if (task === "run") {
    workerRuns[number] = run;
    return;
  }
  try {
    const prepared = prepare(workerRuns[number], settings);
    if (task === "prepare") return postMessage({ task, number, settings, prepared }, arraysOf(prepared));
    const channels = record(workerRuns[number], settings, seconds, prepared, (share) => postMessage({ task: "progress", share }));
    const file = waveFile(channels.slice(0, 2));
    postMessage({ task, number, ...file }, [file.wav.buffer]);
  } catch (error) {
    postMessage({ task: "failed", failed: task, message: String(error?.message ?? error) });
  }
}

if (globalThis.registerProcessor) registerInstrument();
else if (globalThis.WorkerGlobalScope) onmessage = answer;
