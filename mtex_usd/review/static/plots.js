// The plots of the review page: each a section with a sentence on how to read it, drawn when it comes into view.
// Figures are those of Pullen & Bregler 2002.

import { PlotData } from "./plots_data.js";
import { el } from "./plots_dom.js";
import { segmented } from "./plots_pickers.js";
import { Tip } from "./plots_tip.js";
import { strip } from "./plots_strip.js";
import { curves, keyedAgainstCaptured } from "./plots_curves.js";
import { bands } from "./plots_bands.js";
import { matches } from "./plots_matches.js";
import { candidates } from "./plots_candidates.js";
import { joins } from "./plots_joins.js";
import { correlation } from "./plots_correlation.js";
import { contacts } from "./plots_contacts.js";

const PLOTS = [strip, curves, keyedAgainstCaptured, bands, matches, candidates, joins, correlation, contacts];

function spread(values) {
  let low = Infinity;
  let high = -Infinity;
  for (const value of values) {
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  return high - low;
}

/** What is chosen: the same channel, fragment and join in all plots. */
class State {
  constructor(data) {
    this.listeners = new Set();
    const { columns } = data.curves;
    const matched = columns.filter((column) => data.channels[column].roles.includes("match"));
    const made = columns.filter((column) =>
      data.channels[column].roles.some((role) => role === "synthesize" || role === "texture"),
    );
    const filled = made.filter((column) => data.channels[column].roles.includes("synthesize"));
    const most = (among) =>
      among.reduce((best, column) => (spread(data.finished(column, 0)) > spread(data.finished(best, 0)) ? column : best));
    this.keyed = matched[0] ?? columns[0];
    this.column = most(filled.length ? filled : made.length ? made : columns);
    this.fragment = 0;
    this.match = 0;
    this.join = null;
    this.seconds = null;
    this.page = 0;
    this.data = data;
  }

  /** First and last time that is shown; the whole shot, or a page of some seconds with the player's frame on it. */
  get span() {
    const { data } = this;
    const [first, last] = this.frames ?? [0, data.frameCount - 1];
    return [data.timeOf(first), data.timeOf(last)];
  }

  get frames() {
    if (this.seconds === null) return null;
    const length = Math.min(this.data.frameCount - 1, Math.round(this.seconds * this.data.rate));
    const first = Math.min(this.page * length, this.data.frameCount - 1 - length);
    return [first, first + length];
  }

  /** Turn to the page a frame is on; tells whether that is another one. */
  turnTo(frame) {
    if (this.seconds === null) return false;
    const [first, last] = this.frames;
    if (frame >= first && frame <= last) return false;
    this.page = Math.floor(frame / Math.max(1, Math.round(this.seconds * this.data.rate)));
    return true;
  }

  set(changes) {
    Object.assign(this, changes);
    for (const listener of this.listeners) listener();
  }
}

/** One section; its plot is made when it is first seen, and drawn again only while it can be seen. */
class Section {
  constructor(plot, context) {
    Object.assign(this, { plot, context, dirty: true, seen: false });
    this.controls = el("div", { class: "plots-controls" });
    this.body = el("div", { class: "plots-body", style: `min-height:${plot.height}px` });
    this.node = el(
      "section",
      { class: `plot plots-${plot.id}${plot.wide ? " plots-wide" : ""}`, "data-plot": plot.id },
      el("h3", {}, plot.title, plot.figure ? el("span", { class: "plots-figure" }, plot.figure) : null),
      el("p", { class: "muted plots-how" }, plot.how),
      this.controls,
      this.body,
    );
  }

  see(visible) {
    this.seen = visible;
    if (visible) this.refresh();
  }

  refresh() {
    this.dirty = true;
    if (!this.seen) return;
    this.made ??= this.plot.make({ ...this.context, controls: this.controls, body: this.body, section: this.node });
    this.made.draw();
    this.body.style.minHeight = "";
    this.dirty = false;
    this.node.dataset.drawn = "true";
    this.made.showFrame?.(this.context.player.frame);
  }

  showFrame(frame) {
    if (this.seen && this.made) this.made.showFrame?.(frame);
  }

  destroy() {
    this.made?.destroy?.();
  }
}

/** How much of a long shot the curves show at once. */
function bar(data, state, player) {
  const length = (data.frameCount - 1) / data.rate;
  const spans = [
    ["", "whole shot"],
    ...[10, 4, 1.5].filter((seconds) => seconds < length).map((seconds) => [seconds, `${seconds} s`]),
  ];
  const node = el("div", { class: "plots-bar", hidden: spans.length === 1 }, el("span", { class: "muted" }, "Time shown"));
  segmented(node, "Time shown in the curves", spans, "", (seconds) => {
    state.seconds = seconds === "" ? null : seconds;
    state.page = 0;
    state.turnTo(player.frame);
    state.set({});
  });
  return node;
}

/**
 * Fill an element with the plots of one character.
 * @param {HTMLElement} rootElement
 * @param {object} plotsData what `build_plots` gives
 * @param {object} player frame, setFrame, onFrame, variant, setVariant, onVariant
 * @returns {{destroy: () => void}}
 */
export function mountPlots(rootElement, plotsData, player) {
  const data = new PlotData(plotsData);
  const state = new State(data);
  const tip = new Tip(rootElement);
  const context = { data, state, player, tip, variant: () => Math.max(0, data.variantIndex(player.variant)) };
  const sections = PLOTS.filter((plot) => plot.wanted?.(data) ?? true).map((plot) => new Section(plot, context));
  const grid = el("div", { class: "plots-grid" }, ...sections.map((section) => section.node));
  rootElement.append(bar(data, state, player), grid);

  const observer = new IntersectionObserver(
    (entries) => {
      for (const entry of entries) sections.find(({ node }) => node === entry.target).see(entry.isIntersecting);
    },
    { rootMargin: "200px 0px" },
  );
  for (const section of sections) observer.observe(section.node);

  const refresh = () => sections.forEach((section) => section.refresh());
  state.listeners.add(refresh);
  window.addEventListener("mtex:theme", refresh);
  const follow = (frame) => {
    if (state.turnTo(frame)) refresh();
    else sections.forEach((section) => section.showFrame(frame));
  };
  const stops = [player.onVariant(refresh), player.onFrame(follow)];
  return {
    destroy() {
      observer.disconnect();
      window.removeEventListener("mtex:theme", refresh);
      stops.forEach((stop) => stop());
      sections.forEach((section) => section.destroy());
      rootElement.replaceChildren();
    },
  };
}
