// The buttons over the view: layout, camera and what is drawn; and the names at the figures' feet.

import { byId, make } from "./dom.js";
import { CAMERAS } from "./stage.js";
import { variantProperty } from "./theme.js";

const LAYOUTS = { lanes: "Side by side", overlay: "Overlay" };
const LAYERS = { trails: "Trails", strobes: "Strobes", contacts: "Contacts", shadows: "Shadows", follow: "Follow" };
const TRAILS = [["1", "1 s"], ["3", "3 s"], ["all", "all"]];

function press(button, on) { button.setAttribute("aria-pressed", String(on)); }

function buttons(names, action) {
  return Object.entries(names).map(([name, text]) => {
    const button = make("button", { type: "button", textContent: text, "data-name": name });
    button.addEventListener("click", () => action(name));
    return button;
  });
}

export class Layers {
  constructor(character, stage) {
    this.stage = stage;
    this.hasContacts = character.variants.some((variant) => variant.contacts.length);
    byId("layout").replaceChildren(...buttons(LAYOUTS, (name) => this.setLayout(name)));
    byId("cameras").replaceChildren(...buttons(Object.fromEntries(Object.keys(CAMERAS).map((name) => [name, name])), (name) => {
      stage.lookFrom(name);
      this.update();
    }));
    this.length = make("select", { className: "small", "aria-label": "Length of trails" }, ...TRAILS.map(([value, textContent]) => make("option", { value, textContent })));
    this.length.addEventListener("change", () => {
      stage.set({ trailSeconds: this.length.value === "all" ? null : Number(this.length.value) });
    });
    byId("layers").replaceChildren(...buttons(LAYERS, (name) => this.toggle(name)));
    byId("layers").firstChild.after(this.length);
    const contacts = byId("layers").querySelector("[data-name=contacts]");
    contacts.disabled = !this.hasContacts;
    contacts.title = this.hasContacts ? "" : "The recipe holds no contacts";
    byId("scale").textContent = stage.inMeters ? "grid 1 m" : "grid one figure’s height";
    this.update();
  }

  setLayout(layout) {
    this.stage.set({ layout });
    this.update();
  }

  toggle(name) {
    if (name === "contacts" && !this.hasContacts) return;
    this.stage.set({ [name]: !this.stage.show[name] });
    this.update();
  }

  update() {
    const { show, view } = this.stage;
    for (const button of byId("layout").children) press(button, button.dataset.name === show.layout);
    for (const button of byId("cameras").children) press(button, button.dataset.name === view);
    for (const button of byId("layers").querySelectorAll("button")) press(button, show[button.dataset.name] && !button.disabled);
  }
}

/** Names at the feet of the figures, which choose a variant. */
export class Labels {
  constructor(stage, player, panel) {
    this.stage = stage;
    this.player = player;
    this.labels = stage.figures.map((figure, i) => {
      const chip = make("span", { className: "chip" });
      chip.style.color = `var(${variantProperty(i - 1)})`;
      const label = make("button", { type: "button", tabIndex: -1 }, chip, figure.name);
      label.addEventListener("click", () => { if (i > 0) panel.choose(figure.name); });
      return { figure, label };
    });
    byId("labels").replaceChildren(...this.labels.map(({ label }) => label));
  }

  update() {
    const lanes = this.stage.show.layout === "lanes";
    for (const { figure, label } of this.labels) {
      const shown = lanes && this.stage.show.names.has(figure.name);
      label.hidden = !shown;
      if (!shown) continue;
      press(label, figure.name === this.player.variant);
      const { x, y } = this.stage.project(figure);
      label.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px) translate(-50%, 0)`;
    }
  }
}
