// Shortcuts, and the dialog that lists them.

import { byId, make } from "./dom.js";

/** [keys as event.key, as shown, what it does, action] */
function listShortcuts({ player, panel, stage, transport, layers }) {
  const variant = (offset) => {
    const { variantNames } = player;
    const next = (variantNames.indexOf(player.variant) + offset + variantNames.length) % variantNames.length;
    panel.choose(variantNames[next]);
  };
  return [
    [[" ", "k"], "Space", "Play or pause", () => player.toggle()],
    [["ArrowLeft", "ArrowRight"], "← →", "One frame; with Shift a second", (event) => {
      player.step((event.key === "ArrowLeft" ? -1 : 1) * (event.shiftKey ? Math.round(player.rate) : 1));
    }],
    [["Home", "End"], "Home End", "First and last frame", (event) => player.step((event.key === "Home" ? -1 : 1) * player.frameCount)],
    [["[", "]"], "[ ]", "Slower, faster", (event) => transport.faster(event.key === "[" ? -1 : 1)],
    [["i"], "I", "Loop from this frame", () => transport.setIn()],
    [["o"], "O", "Loop to this frame", () => transport.setOut()],
    [["x"], "X", "Play all", () => player.setLoop(0, player.frameCount - 1)],
    [["n", "p"], "N P", "Next, previous variant", (event) => variant(event.key === "n" ? 1 : -1)],
    [[..."123456789"], "1 … 9", "Choose a variant", (event) => {
      const name = player.variantNames[Number(event.key) - 1];
      if (name) panel.choose(name);
    }],
    [["h"], "H", "Show or hide the sketch", () => panel.toggle("sketch")],
    [["v"], "V", "Side by side, overlay", () => layers.setLayout(stage.show.layout === "lanes" ? "overlay" : "lanes")],
    [["t"], "T", "Trails of hands and feet", () => layers.toggle("trails")],
    [["s"], "S", "Strobed poses", () => layers.toggle("strobes")],
    [["c"], "C", "Contact symbols", () => layers.toggle("contacts")],
    [["g"], "G", "Shadows on the ground", () => layers.toggle("shadows")],
    [["f"], "F", "Camera follows", () => layers.toggle("follow")],
    [["r"], "R", "Camera back to where it was", () => stage.lookFrom(stage.view)],
    [["?"], "?", "This list", () => byId("shortcuts").showModal()],
  ];
}

const OWN_KEYS = { range: ["ArrowLeft", "ArrowRight", "Home", "End"], radio: ["ArrowLeft", "ArrowRight"] };

/** Whether the focused control has use of the key itself. */
function isTaken(event) {
  const { target } = event;
  if (byId("shortcuts").open || event.ctrlKey || event.metaKey || event.altKey) return true;
  if (target.matches("input[type=number], input[type=text], select, textarea")) return true;
  if (target.matches("button, input[type=checkbox], input[type=radio], a, summary") && event.key === " ") return true;
  return target !== byId("scrub") && (OWN_KEYS[target.type] ?? []).includes(event.key);
}

/** @returns {{destroy: function}} */
export function mountKeyboard(parts) {
  const shortcuts = listShortcuts(parts);
  byId("keys").replaceChildren(...shortcuts.flatMap(([, shown, text]) => [make("dt", { textContent: shown }), make("dd", { textContent: text })]));
  const listen = (event) => {
    if (isTaken(event)) return;
    const found = shortcuts.find(([keys]) => keys.includes(event.key) || keys.includes(event.key.toLowerCase()));
    if (!found) return;
    event.preventDefault();
    found[3](event);
  };
  window.addEventListener("keydown", listen);
  return { destroy: () => window.removeEventListener("keydown", listen) };
}
