// Colours come from the style sheet, so that what is drawn follows the dark and the light scheme.

/** @returns {number[]} red, green, blue from 0 to 1 of a custom property that holds #rrggbb */
export function readColour(name) {
  const text = getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  return [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16) / 255);
}

export function variantProperty(index) { return index < 0 ? "--sketch" : `--variant-${(index % 8) + 1}`; }

function isDark() {
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
}

/** Make a button switch the scheme; `mtex:theme` is sent to the window whenever colours change. */
export function mountTheme(button) {
  const tell = () => window.dispatchEvent(new Event("mtex:theme"));
  const name = () => { button.textContent = isDark() ? "Light" : "Dark"; };
  button.addEventListener("click", () => {
    document.documentElement.dataset.theme = isDark() ? "light" : "dark";
    name();
    tell();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { name(); tell(); });
  name();
}
