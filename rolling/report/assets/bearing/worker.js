// Entry of the worker: it moves the ring at new settings while the page turns the picture.

import { RATE } from "../engine/rate.js";
import { bandRms, narrowSpectrum } from "./fourier.js";
import { moveRing } from "./model.js";

const SAMPLES = 2 ** 17; // 2.7 s

onmessage = ({ data: { bearing, settings, bands } }) => {
  const moved = moveRing(bearing, settings, SAMPLES);
  const width = RATE / SAMPLES;
  const [x, y, axial] = moved.velocity.map(narrowSpectrum);
  const radial = x.map((rms, line) => Math.sqrt((rms ** 2 + y[line] ** 2) / 2)); // of a direction on average
  const levels = bands.map((band) => ({ radial: bandRms(radial, width, band), axial: bandRms(axial, width, band) }));
  const { loads, loadEvery, begin } = moved;
  const sound = Float32Array.from(moved.acceleration[0]);
  postMessage({ settings, radial, width, levels, loads, loadEvery, begin, sound }, [radial.buffer, loads.buffer, sound.buffer]);
};
