// Choosing a channel, a fragment, a join: a search field, a list and two buttons, all of them the browser's own.

import { el } from "./plots_dom.js";

const GROUPS = [
  ["match", "Matched"],
  ["synthesize", "Synthesized"],
  ["texture", "Textured"],
  ["contact", "Held by contacts"],
  ["break", "Cut by"],
];
let numbers = 0;

function groupOf(channel) {
  return GROUPS.find(([role]) => channel.roles.includes(role))[1];
}

/** A channel as lists call it; a joint that is matched by angle and copied whole has both. */
export function channelName(data, column) {
  const channel = data.channels[column];
  const twice = data.channels.some((other, i) => i !== column && other.label === channel.label);
  return twice ? `${channel.label} (${channel.form === "vector" ? "copied" : "matched"})` : channel.label;
}

/** Search and list of channels, kept with `state[key]`. */
export class ChannelPicker {
  constructor(host, { data, state }, { key, title, columns }) {
    Object.assign(this, { data, state, key, columns });
    numbers += 1;
    this.search = el("input", {
      type: "search",
      placeholder: "Find channel",
      "aria-label": `${title}: find`,
      oninput: () => this.fill(),
      onkeydown: (event) => this.enter(event),
    });
    this.list = el("select", { id: `plots-channel-${numbers}`, onchange: () => state.set({ [key]: Number(this.list.value) }) });
    host.append(el("div", { class: "plots-field" }, el("label", { for: this.list.id }, title), this.list, this.search));
    this.fill();
  }

  enter(event) {
    if (event.key !== "Enter" || !this.list.options.length) return;
    event.preventDefault();
    this.state.set({ [this.key]: Number(this.list.options[0].value) });
  }

  fill() {
    const words = this.search.value.toLowerCase().split(/\s+/).filter(Boolean);
    const found = this.columns.filter((column) =>
      words.every((word) =>
        `${this.data.channels[column].token} ${groupOf(this.data.channels[column])}`.toLowerCase().includes(word),
      ),
    );
    const groups = GROUPS.map(([, name]) => [name, found.filter((column) => groupOf(this.data.channels[column]) === name)]);
    this.list.replaceChildren(
      ...groups
        .filter(([, members]) => members.length)
        .map(([name, members]) =>
          el(
            "optgroup",
            { label: name },
            ...members.map((column) => el("option", { value: column }, channelName(this.data, column))),
          ),
        ),
    );
    this.show();
  }

  /** Show what is chosen, or another channel where a plot cannot show that one. */
  show(column = this.state[this.key]) {
    this.list.value = String(column);
  }
}

/** A list with buttons for the one before and the next. */
export class StepPicker {
  /** @param {{title: string, previous: string, next: string, onPick: (value: number) => void}} options */
  constructor(host, { title, previous, next, onPick }) {
    numbers += 1;
    this.list = el("select", { id: `plots-step-${numbers}`, onchange: () => onPick(Number(this.list.value)) });
    const button = (name, text, step) =>
      el("button", { type: "button", class: "small", "aria-label": name, title: name, onclick: () => this.step(step) }, text);
    host.append(
      el(
        "div",
        { class: "plots-field" },
        el("label", { for: this.list.id }, title),
        button(previous, "◀", -1),
        this.list,
        button(next, "▶", 1),
      ),
    );
  }

  step(by) {
    const index = this.list.selectedIndex + by;
    if (index < 0 || index >= this.list.options.length) return;
    this.list.selectedIndex = index;
    this.list.dispatchEvent(new Event("change"));
  }

  /** @param {{value: number, text: string}[]} options */
  show(options, value) {
    const key = options.map((option) => option.text).join("|");
    if (key !== this.key) {
      this.key = key;
      this.list.replaceChildren(...options.map((option) => el("option", { value: option.value }, option.text)));
    }
    this.list.value = String(value);
  }
}

/** One of a few, as buttons side by side. */
export function segmented(host, title, options, value, onPick) {
  const buttons = options.map(([key, text]) =>
    el(
      "button",
      {
        type: "button",
        "aria-pressed": String(key === value),
        onclick: () => {
          show(key);
          onPick(key);
        },
      },
      text,
    ),
  );
  const show = (key) => buttons.forEach((button, i) => button.setAttribute("aria-pressed", String(options[i][0] === key)));
  host.append(el("div", { class: "segmented", role: "group", "aria-label": title }, ...buttons));
}
