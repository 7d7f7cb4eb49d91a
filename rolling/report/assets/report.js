(() => {
  "use strict";
  const RATE = 48000;
  const FADE_S = 0.01; // short enough to switch at once, long enough not to click
  const NEVER = 1e9; // seconds

  const $ = (selector) => document.querySelector(selector);
  const $$ = (selector) => [...document.querySelectorAll(selector)];
  const data = JSON.parse($("#data").textContent);
  const runs = data.runs;
  const total = Math.max(...runs.map((run) => run.seconds));
  const motionUnwanted = matchMedia("(prefers-reduced-motion: reduce)");
  const modulo = (value, period) => ((value % period) + period) % period;

  // All that changes. The playhead rests at `at`, or moves with the audio clock from `from` to `end`, zero at `origin`. While
  // looping it runs on beyond `total`, so that records of other lengths go round in their own time.
  const state = {
    run: 0, mode: "calibrated", loop: runs.every((run) => run.loops && !run.buzzes), wanted: false, playing: false,
    at: 0, from: 0, end: total, origin: 0,
    context: null, master: null, decoding: null, buffers: [], voices: [], sheets: [], drawn: "",
  };

  // ---- time ----

  function position() {
    if (!state.playing) return state.at;
    const heard = state.context.currentTime - (state.context.outputLatency || 0) - state.origin;
    return Math.min(state.end, Math.max(state.from, heard));
  }

  const sharedTime = () => (position() === state.end ? total : modulo(position(), total));

  /** Whether a record goes round again within the longest one; one so short that it buzzes does so only when asked to. */
  const goesRound = ({ loops, buzzes }) => loops && (state.loop || !buzzes);

  /** Time within a run's own record: round again if it loops, at its end if it is over. */
  function ownTime(number) {
    const { seconds } = runs[number];
    return goesRound(runs[number]) && seconds < total ? modulo(position(), seconds) : Math.min(sharedTime(), seconds);
  }

  // ---- sound ----

  function bytesOf(uri) {
    const text = atob(uri.slice(uri.indexOf(",") + 1));
    const bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
    return bytes;
  }

  /** The samples of a player, alone if they loop, and filled up with silence, so that all go round together. */
  async function decodeOne(player) {
    const offline = new OfflineAudioContext(1, 1, RATE); // may be had before the user has clicked anything
    const buffer = await offline.decodeAudioData(bytesOf(player.src).buffer);
    const { loops, buzzes } = runs[Number(player.dataset.run)];
    if (loops && !buzzes) return { round: buffer };
    const once = new AudioBuffer({ length: Math.round(total * RATE), sampleRate: RATE });
    once.copyToChannel(buffer.getChannelData(0), 0);
    return { round: loops ? buffer : once, once };
  }

  const decode = () => (state.decoding ??= Promise.all($$("audio").map(decodeOne)));
  const gainOf = (number) => (number === state.run ? runs[number].playback[state.mode] : 0);

  function glide(gain, target) {
    const now = state.context.currentTime;
    gain.cancelScheduledValues(now);
    gain.setValueAtTime(gain.value, now);
    gain.linearRampToValueAtTime(target, now + FADE_S);
  }

  /** All runs sound together, but only one is let through: switching moves gains and nothing else. */
  function mix() {
    state.voices.forEach(({ gain }, number) => glide(gain.gain, gainOf(number)));
  }

  function startVoices(at) {
    const { context, buffers } = state;
    const when = context.currentTime;
    Object.assign(state, { playing: true, from: at, origin: when - at });
    state.voices = buffers.map(({ round, once }, number) => {
      const buffer = goesRound(runs[number]) ? round : once;
      const source = new AudioBufferSourceNode(context, { buffer, loop: true });
      const gain = new GainNode(context, { gain: 0 });
      source.connect(gain).connect(state.master);
      source.start(when, modulo(at, buffer.duration));
      return { source, gain };
    });
    const voices = state.voices;
    voices[0].source.onended = () => voices === state.voices && finish();
    setEnd();
    mix();
  }

  /** Where it stops: at the end of this round, or never. */
  function setEnd() {
    state.end = state.loop ? Infinity : total * (Math.floor(position() / total + 1e-9) + 1);
    const when = state.loop ? NEVER : state.origin + state.end;
    for (const { source } of state.voices) source.stop(when);
  }

  function stopVoices() {
    const old = state.voices;
    state.voices = [];
    for (const { source, gain } of old) {
      glide(gain.gain, 0);
      source.stop(state.context.currentTime + FADE_S);
    }
  }

  async function play() {
    if (state.wanted) return;
    state.wanted = true;
    for (const player of $$("audio")) player.pause();
    state.context ??= new AudioContext({ sampleRate: RATE });
    state.master ??= new GainNode(state.context, { gain: Number($("#volume").value) });
    state.master.connect(state.context.destination);
    showButton();
    [state.buffers] = await Promise.all([decode(), state.context.resume()]);
    if (!state.wanted || state.playing) return;
    startVoices(state.at >= state.end ? 0 : state.at);
    tick();
  }

  function pause() {
    state.wanted = false;
    if (state.playing) {
      Object.assign(state, { at: position(), playing: false });
      stopVoices();
    }
    showButton();
    render();
  }

  function finish() {
    Object.assign(state, { wanted: false, playing: false, voices: [], at: total, end: total });
    showButton();
    render();
  }

  function seek(time) {
    const at = Math.min(Math.max(time, 0), total);
    if (state.playing) {
      stopVoices();
      startVoices(at < total ? at : 0);
    } else {
      Object.assign(state, { at, end: total });
    }
    render();
  }

  // ---- choices ----

  const signed = (value) => (Math.abs(value) < 0.05 ? "0.0" : `${value < 0 ? "−" : "+"}${Math.abs(value).toFixed(1)}`);

  function choose(number) {
    if (!(number in runs)) return;
    state.run = number;
    mix();
    for (const radio of $$("input[name=run]")) radio.checked = Number(radio.value) === number;
    if ($("#choose")) $("#choose").value = String(number);
    for (const figure of $$("[data-name=release_power]")) figure.hidden = Number(figure.dataset.run) !== number;
    for (const note of $$("[data-repeats]")) note.hidden = Number(note.dataset.repeats) !== number;
    say(runs[number].label);
    render();
  }

  function setMode(mode) {
    state.mode = mode;
    mix();
    for (const radio of $$("input[name=mode]")) radio.checked = radio.value === mode;
    for (const [number, { playback }] of runs.entries()) {
      if (playback.calibrated_pa === null) continue;
      const equal = mode === "equal";
      $(`[data-gain="${number}"]`).textContent = signed(equal ? playback.equal_db : 0);
      $(`[data-scale="${number}"]`).textContent = `${Number(playback[`${mode}_pa`].toPrecision(4))} Pa`;
    }
    say(mode === "equal" ? "equal LAeq" : "calibrated");
  }

  function setLoop(loop) {
    const changes = state.playing && runs.some((run) => run.buzzes); // records that now go round, or no longer do
    const at = position();
    if (changes) stopVoices();
    state.loop = $("#loop").checked = loop;
    if (changes) startVoices(at);
    else if (state.playing) setEnd();
    say(loop ? "loop" : "no loop");
  }

  function say(text) {
    $("#said").textContent = text;
  }

  // ---- what moves ----

  function tick() {
    if (!state.playing) return;
    render();
    requestAnimationFrame(tick);
  }

  function showButton() {
    const button = $("#play");
    button.textContent = state.wanted ? "Pause" : "Play";
  }

  const seconds = (time) => `${time.toFixed(total < 1 ? 3 : 2)} s`;

  function render() {
    const time = sharedTime();
    $("#seek").value = time;
    $("#seek").setAttribute("aria-valuetext", seconds(time));
    $("#time").textContent = `${seconds(time)} / ${seconds(total)}`;
    timelines.forEach(movePlayhead);
    if (data.view && !(state.playing && motionUnwanted.matches)) showMap();
  }

  const timelines = $$(".timeline").map((figure) => {
    const { run, ...rest } = figure.dataset;
    const [begin, end, left, right] = ["begin", "end", "left", "right"].map((name) => Number(rest[name]));
    return { figure, run: Number(run), begin, end, left, right, line: figure.querySelector(".playhead") };
  });

  function movePlayhead({ run, begin, end, left, right, line }) {
    const share = (ownTime(run) - begin) / (end - begin);
    line.hidden = false;
    line.style.left = `${left + (right - left) * Math.min(1, Math.max(0, share))}%`;
  }

  function seekByClick(event, { figure, run, begin, end, left, right }) {
    const sheet = figure.querySelector(".sheet").getBoundingClientRect();
    const share = ((100 * (event.clientX - sheet.left)) / sheet.width - left) / (right - left);
    if (run !== state.run) choose(run);
    seek(Math.min(Math.max(begin + share * (end - begin), 0), runs[run].seconds));
  }

  // ---- the contact ----

  /** Which of the stretches of time with one map each the chosen run is in. */
  function stretch() {
    const { begins } = runs[state.run].maps;
    const time = ownTime(state.run);
    let low = 0;
    for (let high = begins.length; high - low > 1; ) {
      const middle = (low + high) >> 1;
      if (begins[middle] <= time) low = middle;
      else high = middle;
    }
    return low;
  }

  function sheetOf(number) {
    if (!state.sheets[number]) {
      const sheet = new Image();
      sheet.onload = render;
      sheet.src = runs[number].maps.sheet;
      state.sheets[number] = sheet;
    }
    return state.sheets[number];
  }

  function showMap() {
    const run = runs[state.run];
    $("#map-run").textContent = run.label;
    $("#map-time").textContent = seconds(ownTime(state.run));
    const map = run.maps ? run.maps.order[stretch()] : -1;
    const ready = map >= 0 && sheetOf(state.run).complete;
    const drawn = `${state.run} ${map} ${ready}`;
    if (drawn === state.drawn) return;
    state.drawn = drawn;
    showReadings(run, map);
    drawMap(run, ready ? map : -1);
  }

  function showReadings({ label, maps }, map) {
    const read = (name, unit, factor = 1) => {
      const value = maps?.[name][map] ?? null;
      return value === null ? "-" : `${Number((value * factor).toPrecision(4))} ${unit}`;
    };
    $("#map-position").textContent = read("position_mm", "mm");
    $("#map-load").textContent = maps ? `${maps.load_n} N` : "-";
    $("#map-pressure").textContent = read("max_pressure_gpa", "GPa");
    $("#map-area").textContent = read("contact_um2", "µm²");
    $("#map-plastic").textContent = read("plastic_um2", "µm²");
    const number = maps ? `map ${map + 1} of ${maps.tiles.length}` : "no maps kept";
    $("#map-number").textContent = number;
    $("#map").setAttribute("aria-label", `Contact pressure, ${label}, ${number}`);
  }

  function drawMap({ maps }, map) {
    const canvas = $("#map");
    const pen = canvas.getContext("2d");
    const perUm = canvas.width / (2 * data.view.half_um);
    const middle = canvas.width / 2;
    pen.fillStyle = "#000";
    pen.fillRect(0, 0, canvas.width, canvas.height);
    if (map >= 0) {
      const [x, y, width, height] = maps.tiles[map];
      const [left, top, cell] = maps.boxes[map].map((um) => um * perUm);
      pen.imageSmoothingEnabled = false; // a cell is what was computed, nothing between cells was
      pen.drawImage(state.sheets[state.run], x, y, width, height, middle + left, middle - top, width * cell, height * cell);
    }
    if (maps) drawCircle(pen, middle, maps.hertz_um * perUm);
    drawScale(pen, perUm);
    drawArrow(pen);
  }

  function drawCircle(pen, middle, radius) {
    pen.setLineDash([9, 7]);
    for (const [colour, width] of [["#000", 5], ["#7fd4ff", 2]]) { // seen on the darkest pressure and on the lightest
      pen.strokeStyle = colour;
      pen.lineWidth = width;
      pen.beginPath();
      pen.arc(middle, middle, radius, 0, 2 * Math.PI);
      pen.stroke();
    }
    pen.setLineDash([]);
  }

  function drawScale(pen, perUm) {
    const longest = data.view.half_um / 1.5;
    const decade = 10 ** Math.floor(Math.log10(longest));
    const length = [5, 2, 1].find((digit) => digit * decade <= longest) * decade;
    const { height } = pen.canvas;
    pen.fillStyle = "#fff";
    pen.fillRect(16, height - 20, length * perUm, 4);
    pen.font = "22px system-ui, sans-serif";
    pen.textAlign = "left";
    pen.fillText(`${Number(length.toPrecision(1))} µm`, 16, height - 28);
  }

  function drawArrow(pen) {
    const { width, height } = pen.canvas;
    pen.fillStyle = pen.strokeStyle = "#fff";
    pen.lineWidth = 3;
    pen.beginPath();
    pen.moveTo(width - 90, height - 18);
    pen.lineTo(width - 28, height - 18);
    pen.stroke();
    pen.beginPath();
    pen.moveTo(width - 14, height - 18);
    pen.lineTo(width - 32, height - 26);
    pen.lineTo(width - 32, height - 10);
    pen.fill();
    pen.textAlign = "right";
    pen.fillText("rolls", width - 14, height - 36);
  }

  function stepMap(by) {
    const { maps, seconds: own } = runs[state.run];
    if (!maps) return;
    if (state.wanted) pause();
    const next = modulo(stretch() + by, maps.begins.length);
    seek((maps.begins[next] + (maps.begins[next + 1] ?? own)) / 2);
  }

  // ---- taking things away ----

  function download(content, type, name) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([content], { type }));
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  }

  function save(button) {
    const image = button.closest("figure").querySelector("img");
    const name = `${button.dataset.file}.${button.dataset.save}`;
    if (button.dataset.save === "svg") return download(bytesOf(image.src), "image/svg+xml", name);
    const canvas = document.createElement("canvas");
    canvas.width = 1700; // 2 pixels for each of a page this wide
    canvas.height = Math.round((1700 * image.naturalHeight) / image.naturalWidth);
    canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
    return canvas.toBlob((content) => download(content, "image/png", name), "image/png");
  }

  async function copy(text) {
    try {
      await navigator.clipboard.writeText(text);
    } catch { // not every browser lets a file use the clipboard
      const area = document.body.appendChild(document.createElement("textarea"));
      area.value = text;
      area.select();
      document.execCommand("copy");
      area.remove();
    }
    say("copied");
  }

  // ---- the user ----

  const toggle = () => (state.wanted ? pause() : play());
  const KEYS = {
    " ": toggle,
    ArrowLeft: () => seek(sharedTime() - total / 20),
    ArrowRight: () => seek(sharedTime() + total / 20),
    Home: () => seek(0),
    g: () => runs.length > 1 && setMode(state.mode === "equal" ? "calibrated" : "equal"),
    l: () => setLoop(!state.loop),
    "?": () => { $(".keys").open = !$(".keys").open; $(".keys summary").focus(); },
  };

  function onKey(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || event.defaultPrevented) return;
    const on = event.target;
    const { key } = event;
    if (on.matches("select, textarea, audio, [contenteditable], input:not([type=radio], [type=checkbox], [type=range])")) return;
    // Keys that the focused control has a use of its own for.
    if (key === " " && on.matches("button, summary, a, [type=checkbox], [type=radio]:not(:checked)")) return;
    if ((key.startsWith("Arrow") || key === "Home") && on.matches("[type=range], [type=radio], pre")) return;
    if (on.id === "map" && key.startsWith("Arrow")) stepMap(key === "ArrowLeft" || key === "ArrowUp" ? -1 : 1);
    else if (/^[1-9]$/.test(key) && runs.length > 1) choose(Number(key) - 1);
    else if (Object.hasOwn(KEYS, key.toLowerCase())) KEYS[key.toLowerCase()]();
    else if (Object.hasOwn(KEYS, key)) KEYS[key]();
    else return;
    event.preventDefault();
  }

  function listen() {
    const on = (selector, type, act) => $$(selector).forEach((element) => element.addEventListener(type, (event) => act(element, event)));
    document.addEventListener("keydown", onKey);
    on("#play", "click", toggle);
    on("#seek", "input", (slider) => seek(Number(slider.value)));
    on("#loop", "change", (box) => setLoop(box.checked));
    on("#volume", "input", (slider) => state.master && glide(state.master.gain, Number(slider.value)));
    on("#choose, input[name=run]", "change", (choice) => choose(Number(choice.value)));
    on("input[name=mode]", "change", (choice) => setMode(choice.value));
    on("#before", "click", () => stepMap(-1));
    on("#after", "click", () => stepMap(1));
    on("[data-save]", "click", save);
    on("#copy-levels", "click", () => copy(data.tsv));
    on("[data-copy]", "click", (button) => copy($(`#${button.dataset.copy}`).textContent));
    for (const line of timelines) line.figure.querySelector(".sheet").addEventListener("click", (event) => seekByClick(event, line));
    for (const player of $$("audio")) player.addEventListener("play", () => playAlone(player));
  }

  function playAlone(player) {
    if (state.wanted) pause();
    for (const other of $$("audio")) if (other !== player) other.pause();
  }

  function begin() {
    document.documentElement.classList.add("scripted");
    $("#transport").hidden = false;
    $(".singles").open = runs.length === 1;
    $("#seek").max = total;
    $("#loop").checked = state.loop;
    listen();
    choose(0);
    say("");
    (window.requestIdleCallback ?? setTimeout)(decode); // so that the first play is not late
  }

  begin();
})();
