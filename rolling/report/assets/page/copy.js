// ---- text to the clipboard ----

const COPIED_MS = 2000;

/** Copy a text, and confirm it on its button for a while. */
export async function copy(text, button) {
  try {
    await navigator.clipboard.writeText(text);
  } catch { // not every browser lets a file use the clipboard
    const area = document.body.appendChild(document.createElement("textarea"));
    area.value = text;
    area.select();
    document.execCommand("copy");
    area.remove();
  }
  const before = button.dataset.label ??= button.textContent;
  button.textContent = "Copied";
  setTimeout(() => { button.textContent = before; }, COPIED_MS);
}

/** Let the buttons of the page that name an element copy its text. */
export function listenToCopying(said = () => {}) {
  for (const button of document.querySelectorAll("[data-copy]")) {
    button.addEventListener("click", async () => {
      await copy(document.querySelector(`#${button.dataset.copy}`).textContent, button);
      said("copied");
    });
  }
}
