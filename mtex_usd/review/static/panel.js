// The table of candidates with the numbers of each, and what made them.

import { byId, make } from "./dom.js";
import { variantProperty } from "./theme.js";

const COLUMNS = [
  ["", "Shown and chosen"], ["rank", "1 is the best"], ["distance", "Sum of the matching distances of its fragments"],
  ["joins", "Consecutive joins, which cost nothing, of all"],
  ["jerk", "Third difference relative to the takes’"], ["detail", "Energy near 1.6 and 3.4 Hz relative to the takes’"],
  ["slide", "How far planted feet slide, mean over contacts, cm"], ["turn", "Largest turn of a copied joint in one frame, degrees"],
];

function digits(value, places) { return value === null || value === undefined ? "–" : value.toFixed(places); }

function distanceText(value) { return value >= 1000 ? Math.round(value).toLocaleString("en") : Number(value.toPrecision(3)).toString(); }

function numberCells(numbers) {
  return [digits(numbers.jerk, 2), digits(numbers.detail, 2), digits(numbers.slide_cm, 1), `${digits(numbers.turn, 0)}°`];
}

export class Panel {
  /** @param {Player} player @param {Stage} stage */
  constructor(character, player, stage) {
    this.player = player;
    this.stage = stage;
    this.rows = new Map();
    this.fillTable(character);
    byId("notes").replaceChildren(...character.notes.map((note) => make("li", { textContent: note })));
    byId("anim").textContent = `${character.anim}  →  ${character.model} {${character.variantSet}}`;
    byId("recipe").textContent = character.recipe;
    this.update();
  }

  fillTable(character) {
    const head = make("tr", {}, ...COLUMNS.map(([text, title]) => make("th", { scope: "col", textContent: text, title })));
    const sketch = this.makeRow("sketch", -1, ["–", "–", "–", ...numberCells(character.sketch.numbers)]);
    const rows = character.variants.map((variant, i) => this.makeRow(variant.name, i, [
      variant.rank, distanceText(variant.distance), `${variant.zeroCostJoins}/${variant.joins}`, ...numberCells(variant.numbers),
    ]));
    byId("variants").replaceChildren(make("thead", {}, head), make("tbody", {}, sketch, ...rows));
  }

  makeRow(name, index, cells) {
    const shown = make("input", { type: "checkbox", "aria-label": `Show ${name}` });
    shown.addEventListener("change", () => this.toggle(name));
    shown.style.accentColor = `var(${variantProperty(index)})`;
    const label = make("label", {}, ...(index >= 0 ? [this.makeChoice(name)] : []), name);
    const first = make("div", { className: "name" }, shown, label);
    const row = make("tr", {}, make("td", {}, first), ...cells.map((cell) => make("td", { textContent: cell })));
    this.rows.set(name, { row, shown });
    return row;
  }

  makeChoice(name) {
    const choice = make("input", { type: "radio", name: "variant", value: name, "aria-label": `Choose ${name}` });
    choice.addEventListener("change", () => this.player.setVariant(name));
    return choice;
  }

  /** Show a figure or not; one at least stays. */
  toggle(name) {
    const names = new Set(this.stage.show.names);
    if (!names.delete(name)) names.add(name);
    if (names.size) this.stage.set({ names });
    this.update();
  }

  /** Choose a variant and see to it that it is shown. */
  choose(name) {
    this.player.setVariant(name);
    if (!this.stage.show.names.has(name)) this.toggle(name);
  }

  update() {
    for (const [name, { row, shown }] of this.rows) {
      const chosen = name === this.player.variant;
      row.classList.toggle("selected", chosen);
      shown.checked = this.stage.show.names.has(name);
      const radio = row.querySelector("input[type=radio]");
      if (radio) radio.checked = chosen;
    }
  }
}
