// Audio nodes behind the instrument: convolvers turn the contact force into sound pressure.

const SETTLE_S = 0.03; // in which a ball that begins at rest takes the motion of the track
const FEED_S = 0.01; // time constant in which the force then goes over from one body to the next
const HIGH_PASS = { order: 8, frequency: 15.5 }; // Butterworth: -0.5 dB at 17.8 Hz, -0.07 dB at 20 Hz
const RUN_IN_S = 1; // before a record of rolling, for the high-pass and the modes of the plate

/** Make the node of the instrument in a context with its module, and its high-passed output. */
export function instrumentNode(context, processorOptions) {
  const node = new AudioWorkletNode(context, "instrument", { numberOfInputs: 0, outputChannelCount: [1], processorOptions });
  const { order, frequency } = HIGH_PASS;
  let output = node;
  for (let k = 1; k < order; k += 2) {
    const Q = -20 * Math.log10(2 * Math.sin((Math.PI * k) / (2 * order)));
    output = output.connect(new BiquadFilterNode(context, { type: "highpass", frequency, Q }));
  }
  return { node, output };
}

/** Make the limiter of two channels in a context with the module of the engine. */
export const limiterNode = (context) => new AudioWorkletNode(context, "limiter", {
  outputChannelCount: [2], channelCount: 2, channelCountMode: "explicit",
});

/** Connect a source through responses [Pa/N] of up to two listeners, at once or faded in. */
export function throughBody(source, responses, output, atOnce = false) {
  const { context } = source, heard = responses.slice(0, 2);
  const length = Math.max(...heard.map((response) => response.length));
  const buffer = new AudioBuffer({ length, numberOfChannels: heard.length, sampleRate: context.sampleRate });
  heard.forEach((response, i) => buffer.copyToChannel(Float32Array.from(response), i));
  const convolver = new ConvolverNode(context, { buffer, disableNormalization: true });
  const feed = new GainNode(context, { gain: atOnce ? 1 : 0 });
  source.connect(feed).connect(convolver).connect(output);
  if (!atOnce) feed.gain.setTargetAtTime(1, context.currentTime + SETTLE_S, FEED_S);
  return { source, feed, convolver };
}

/** Fade out the force on a body, which rings out. */
export function leaveBody({ source, feed, convolver }) {
  feed.gain.setTargetAtTime(0, feed.context.currentTime + SETTLE_S, FEED_S);
  setTimeout(() => {
    source.disconnect(feed);
    convolver.disconnect();
  }, 1e3 * (SETTLE_S + 10 * FEED_S + convolver.buffer.duration));
}

/** Render channels of pressure [Pa] of the steady state, or of a fall from its beginning, as a promise. */
export async function renderedRecord(url, run, settings, prepared, seconds) {
  const { responses, rate, delay } = prepared, heard = responses.slice(0, 2);
  const settled = Math.ceil(RUN_IN_S * rate) + Math.max(...heard.map((response) => response.length));
  const skipped = settings.dropHeight ? delay : settled;
  const context = new OfflineAudioContext(heard.length, skipped + Math.round(seconds * rate), rate);
  await context.audioWorklet.addModule(url);
  throughBody(instrumentNode(context, { run, settings, prepared }).output, heard, context.destination, true);
  const record = await context.startRendering();
  return heard.map((_, i) => record.getChannelData(i).subarray(skipped));
}
