// Radiation of sine shaped modes of a rectangle in a baffle: pressure at a listener by Rayleigh's
// integral, and sound power over wave numbers.

import { AIR, SOUND } from "./radiation.js";

// Positive nodes and weights of Gauss-Legendre quadrature with ten nodes on [-1, 1].
const NODES = [0.1488743389816312, 0.4333953941292472, 0.6794095682990244, 0.8650633666889845, 0.9739065285171717];
const WEIGHTS = [0.2955242247147529, 0.2692667193099963, 0.219086362515982, 0.1494513491505806, 0.0666713443086881];
const PANEL = 18; // [rad] phase along a panel of ten nodes, which leaves 5e-5
const WIDEST = 3; // width of a panel over the distance of the listener, which leaves 4e-6
const MAX_PANELS = 32; // near a listener

/** Return nodes and weights of a quadrature over [0, width] for a phase [rad] along it. */
function quadrature(width, phase, near = width) {
  const panels = Math.max(Math.ceil(phase / PANEL), Math.min(Math.ceil(width / (WIDEST * near)), MAX_PANELS));
  const half = width / panels / 2;
  const [nodes, weights] = [[], []];
  for (let panel = 0; panel < panels; panel++) {
    NODES.forEach((node, i) => {
      nodes.push(half * (2 * panel + 1 - node), half * (2 * panel + 1 + node));
      weights.push(half * WEIGHTS[i], half * WEIGHTS[i]);
    });
  }
  return { nodes, weights };
}

/** Return the sound power to one side per mean square velocity [W s2/m2] of a mode at w [rad/s]. */
export function radiationResistance([length, width], { m, n, w }) {
  const k = w / SOUND;
  const [along, across] = [length, width].map((edge) => quadrature(Math.PI / 2, k * edge));
  let total = 0;
  along.nodes.forEach((alpha, i) => {
    let sum = 0;
    across.nodes.forEach((beta, j) => {
      sum += across.weights[j] * squaredWave(n, width, k * Math.cos(alpha) * Math.sin(beta));
    });
    total += sum * along.weights[i] * Math.cos(alpha) * squaredWave(m, length, k * Math.sin(alpha));
  });
  return AIR * SOUND * (k / Math.PI) ** 2 * total;
}

/** Return the squared Fourier transform [m2] of a sine along an edge at a wave number [rad/m]. */
function squaredWave(order, edge, k) {
  const p = (order * Math.PI) / edge;
  const beyond = p * p - k * k;
  if (Math.abs(beyond) < 1e-6 * p * p) return (edge / 2) ** 2;
  const wave = order % 2 ? Math.cos((k * edge) / 2) : Math.sin((k * edge) / 2);
  return (wave * ((2 * p) / beyond)) ** 2;
}

/** Return the shortest and the longest distance [m] from a listener to a rectangle. */
export function distances(edges, [x, y, z]) {
  const place = [x, y];
  const beside = edges.map((edge, i) => Math.max(-place[i], place[i] - edge, 0));
  const beyond = edges.map((edge, i) => Math.max(place[i], edge - place[i]));
  return [Math.hypot(...beside, z), Math.hypot(...beyond, z)];
}

/** Return integrals of exp(-i k (R - path)) / R [m] over modes (m, n, share) at a frequency [Hz]. */
export function rayleighIntegrals(edges, modes, listener, path, frequency) {
  const counts = edges.map((_, i) => modes.reduce((order, mode) => Math.max(order, i ? mode.n : mode.m), 1));
  const sines = (i, nodes) => {
    const wave = (order) => Float64Array.from(nodes, (node) => Math.sin((Math.PI * order * node) / edges[i]));
    return Array.from({ length: counts[i] }, (_, m) => wave(m + 1));
  };
  const integralOf = integralsOfProducts(edges, counts, sines, listener, path, frequency);
  return modes.map(({ m, n, share }) => integralOf(m - 1, n - 1).map((part) => share * part));
}

// `functionsOf` returns so many functions of a side (0 or 1) at nodes [m], as `counts` says, with as many half waves.
/** Return the function that gives the integral [re, im] [m] of a product of functions of both sides. */
export function integralsOfProducts(edges, counts, functionsOf, listener, path, frequency) {
  const k = (2 * Math.PI * frequency) / SOUND;
  const [near] = distances(edges, listener);
  const [along, across] = edges.map((edge, i) => {
    const { nodes, weights } = quadrature(edge, k * edge + Math.PI * counts[i], near);
    const shapes = functionsOf(i, nodes).map((values) => values.map((value, j) => weights[j] * value));
    return { squares: nodes.map((node) => (node - listener[i]) ** 2), shapes };
  });
  const count = across.squares.length;
  const [cos, sin] = [new Float64Array(count), new Float64Array(count)];
  const sums = along.shapes.map(() => [new Float64Array(count), new Float64Array(count)]);
  along.squares.forEach((square, a) => {
    for (let b = 0; b < count; b++) {
      const distance = Math.sqrt(square + across.squares[b] + listener[2] ** 2);
      const phase = k * (path - distance);
      cos[b] = Math.cos(phase) / distance;
      sin[b] = Math.sin(phase) / distance;
    }
    sums.forEach(([c, s], m) => {
      const weight = along.shapes[m][a];
      for (let b = 0; b < count; b++) {
        c[b] += weight * cos[b];
        s[b] += weight * sin[b];
      }
    });
  });
  return (m, n) => {
    const [[c, s], shape] = [sums[m], across.shapes[n]];
    let [re, im] = [0, 0];
    for (let b = 0; b < count; b++) {
      re += c[b] * shape[b];
      im += s[b] * shape[b];
    }
    return [re, im];
  };
}
