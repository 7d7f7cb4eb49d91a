// ---- the seeds of a sweep in a row ----

const BLEND_S = 0.05;

/** All records one after the other and round again, each blended into the next at equal power. */
async function makeRow() {
  state.buffers = await decode();
  const overlap = Math.round(BLEND_S * RATE);
  const records = state.buffers.map(({ record }) => record.getChannelData(0));
  const samples = records.reduce((sum, record) => sum + record.length - overlap, 0);
  const all = new Float32Array(samples);
  state.row = [];
  records.reduce((at, record, number) => {
    const gain = runs[number].playback[state.mode];
    record.forEach((x, k) => {
      const edge = Math.min(1, (k + 0.5) / overlap, (record.length - k - 0.5) / overlap);
      all[(at + k) % samples] += gain * Math.sin((edge * Math.PI) / 2) * x;
    });
    state.row.push(at / RATE);
    return at + record.length - overlap;
  }, 0);
  const buffer = new AudioBuffer({ length: samples, sampleRate: RATE });
  const peak = peakOf(all); // two records together may be louder than each
  buffer.copyToChannel(peak > 1 ? all.map((x) => x / peak) : all, 0);
  return buffer;
}

/** Names the record that is heard in the row. */
function showRow() {
  const number = Math.max(0, state.row.findLastIndex((begin) => begin <= sharedTime()));
  const text = `now: ${runs[number].label}`;
  if ($("#row-run").textContent !== text) $("#row-run").textContent = text;
}
