// ---- the gallery: one sound at a time, all with one of two gains ----

const players = [...document.querySelectorAll("audio")];
const modes = [...document.querySelectorAll("input[name=mode]")];

/** Sets the volume of each sound by the chosen gain. */
function setGains() {
  const { value } = modes.find((radio) => radio.checked);
  for (const player of players) player.volume = Math.min(1, Number(player.dataset[value]));
}

document.documentElement.classList.add("scripted");
for (const radio of modes) radio.addEventListener("change", setGains);
for (const player of players) {
  player.addEventListener("play", () => players.forEach((other) => other !== player && other.pause()));
}
setGains();
