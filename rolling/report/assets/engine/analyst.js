// Entry of the worker that analyses records, while the page stays free to play and to scroll.

import { spectrogramOf } from "./spectrogram.js";

const TELL_MS = 150; // from one note on the progress to the next

onmessage = ({ data: { number, samples } }) => {
  let told = performance.now();
  const levels = spectrogramOf(samples, (share) => {
    if (performance.now() - told < TELL_MS) return;
    told = performance.now();
    postMessage({ number, share });
  });
  postMessage({ number, levels }, [levels.buffer]);
};
