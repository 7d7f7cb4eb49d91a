// Radiation of sine shaped modes of a rectangle in a baffle: pressure at a listener by Rayleigh's
// integral, and sound power over wave numbers. Quadratures of Gauss and Legendre resolve the phase.

import { AIR, AUDIBLE, SOUND } from "./radiation.js";

const MARGIN = 10; // nodes beyond half the phase of a panel
const PANEL = 60; // [rad] phase along a panel
const PHASE = 0.8; // [rad] between frequencies of a table
export const POINTS = 6; // frequencies of a table that a polynomial joins
const RULES = new Map();

/** Return nodes and weights of Gauss-Legendre quadrature on [-1, 1]. */
export function legendre(count) {
  if (RULES.has(count)) return RULES.get(count);
  const [nodes, weights] = [new Float64Array(count), new Float64Array(count)];
  for (let i = 0; i < count; i++) {
    let [x, slope, change] = [Math.cos((Math.PI * (i + 0.75)) / (count + 0.5)), 1, 1];
    for (let round = 0; round < 100 && Math.abs(change) > 1e-15; round++) {
      let [before, value] = [1, x];
      for (let k = 2; k <= count; k++) [before, value] = [value, ((2 * k - 1) * x * value - (k - 1) * before) / k];
      slope = (count * (x * value - before)) / (x * x - 1);
      change = value / slope;
      x -= change;
    }
    nodes[i] = x;
    weights[i] = 2 / ((1 - x * x) * slope * slope);
  }
  RULES.set(count, { nodes, weights });
  return RULES.get(count);
}

/** Return the sound power to one side per mean square velocity [W s2/m2] of a mode at w [rad/s]. */
export function radiationResistance(edges, { m, n, w }) {
  const k = w / SOUND;
  const [along, across] = edges.map((edge) => legendre(Math.ceil((k * edge) / 2) + MARGIN));
  let total = 0;
  along.nodes.forEach((node, i) => {
    const alpha = (Math.PI / 4) * (node + 1);
    let sum = 0;
    for (let j = 0; j < across.nodes.length; j++) {
      const beta = (Math.PI / 4) * (across.nodes[j] + 1);
      sum += across.weights[j] * squaredWave(n, edges[1], k * Math.cos(alpha) * Math.sin(beta));
    }
    total += sum * along.weights[i] * Math.cos(alpha) * squaredWave(m, edges[0], k * Math.sin(alpha));
  });
  return AIR * SOUND * (k / Math.PI) ** 2 * total * (Math.PI / 4) ** 2;
}

/** Return the squared Fourier transform [m2] of a sine along an edge at a wave number [rad/m]. */
function squaredWave(order, edge, k) {
  const p = (order * Math.PI) / edge;
  const beyond = p * p - k * k;
  if (Math.abs(beyond) < 1e-6 * p * p) return (edge / 2) ** 2;
  const wave = order % 2 ? Math.cos((k * edge) / 2) : Math.sin((k * edge) / 2);
  return (wave * ((2 * p) / beyond)) ** 2;
}

/**
 * Return integrals of exp(-i k R) / R [m] over modes (m, n) at a listener: rows of re and im by
 * frequency, a step [Hz] apart, without exp(-i k middle) of a middle distance [m].
 */
export function rayleighTable(edges, modes, [x, y, z]) {
  const place = [x, y];
  const beside = edges.map((edge, i) => Math.max(-place[i], place[i] - edge, 0));
  const beyond = edges.map((edge, i) => Math.max(place[i], edge - place[i]));
  const [nearest, farthest] = [Math.hypot(...beside, z), Math.hypot(...beyond, z)];
  const spread = Math.max(farthest - nearest, 0.02 * Math.min(...edges));
  const step = (PHASE * SOUND) / (Math.PI * spread);
  const middle = (nearest + farthest) / 2;
  const rows = [];
  const count = Math.max(POINTS, Math.ceil(AUDIBLE[1] / step) + 2);
  for (let i = 0; i < count; i++) rows.push(rayleighRow(edges, modes, [x, y, Math.abs(z)], middle, i * step));
  return { step, nearest, middle, rows };
}

/** Return the integrals at one frequency [Hz]. */
function rayleighRow(edges, modes, listener, middle, frequency) {
  const k = (2 * Math.PI * frequency) / SOUND;
  const [along, across] = edges.map((edge, i) => {
    const most = modes.reduce((order, mode) => Math.max(order, i ? mode.n : mode.m), 1);
    const { nodes, weights } = panels(edge, listener[i], listener[2], k + (Math.PI * most) / edge);
    const wave = (order) => nodes.map((node, j) => weights[j] * Math.sin((Math.PI * order * node) / edge));
    return { offsets: nodes.map((node) => node - listener[i]), shapes: Array.from({ length: most }, (_, m) => wave(m + 1)) };
  });
  const n = across.offsets.length;
  const sums = along.shapes.map(() => [new Float64Array(n), new Float64Array(n)]);
  along.offsets.forEach((offset, a) => {
    for (let b = 0; b < n; b++) {
      const distance = Math.sqrt(offset * offset + across.offsets[b] ** 2 + listener[2] ** 2);
      const phase = k * (middle - distance);
      const [c, s] = [Math.cos(phase) / distance, Math.sin(phase) / distance];
      for (let m = 0; m < sums.length; m++) {
        sums[m][0][b] += along.shapes[m][a] * c;
        sums[m][1][b] += along.shapes[m][a] * s;
      }
    }
  });
  const [re, im] = [new Float64Array(modes.length), new Float64Array(modes.length)];
  modes.forEach((mode, i) => {
    const [c, s] = sums[mode.m - 1];
    const shape = across.shapes[mode.n - 1];
    for (let b = 0; b < n; b++) {
      re[i] += c[b] * shape[b];
      im[i] += s[b] * shape[b];
    }
  });
  return { re, im };
}

/** Return nodes and weights [m] of a quadrature in panels that grow away from the listener. */
function panels(edge, place, near, waveNumber) {
  const ends = new Set([0, edge]);
  const count = Math.max(1, Math.ceil(Math.log2((Math.abs(place) + edge) / near)) + 1);
  for (let i = 0; i < count; i++) {
    for (const sign of [-1, 1]) ends.add(Math.min(Math.max(place + sign * near * 2 ** i, 0), edge));
  }
  const sorted = [...ends].sort((a, b) => a - b);
  const [nodes, weights] = [[], []];
  for (let i = 1, left = sorted[0]; i < sorted.length; i++) {
    const right = sorted[i];
    if (right - left <= 1e-12 * edge) continue;
    const pieces = Math.max(1, Math.ceil((waveNumber * (right - left)) / PANEL));
    const half = (right - left) / pieces / 2;
    const rule = legendre(Math.ceil(waveNumber * half) + MARGIN);
    for (let piece = 0; piece < pieces; piece++) {
      rule.nodes.forEach((node, j) => {
        nodes.push(left + half * (1 + 2 * piece + node));
        weights.push(half * rule.weights[j]);
      });
    }
    left = right;
  }
  return { nodes: Float64Array.from(nodes), weights: Float64Array.from(weights) };
}
