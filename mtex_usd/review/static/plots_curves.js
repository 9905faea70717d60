// Curves of a channel: the sketch against every variant, and keyed against captured (figure 1).

import { TimeChart, drawBreaks } from "./plots_chart.js";
import { SKETCH_DASH, dashOf, el, takeColour, variantColour } from "./plots_dom.js";
import { ChannelPicker, channelName } from "./plots_pickers.js";

const STILL = 1e-3;

/** The sketch's value at keyed frames, nothing elsewhere; null where every frame is keyed or the channel does not move. */
function keyed(data, curve) {
  if (data.keys.length > 0.8 * data.frameCount || Math.max(...curve) - Math.min(...curve) < STILL) return null;
  const frames = new Set(data.keys.map((frame) => Math.round(frame)));
  return Array.from(curve, (value, frame) => (frames.has(frame) ? value : null));
}

function sketchLines(data, column) {
  const curve = data.sketch(column);
  const keys = keyed(data, curve);
  const line = { name: "sketch", values: curve, stroke: "var(--sketch)", width: 2, dash: SKETCH_DASH };
  return keys ? [line, { name: "keys", values: keys, stroke: "var(--plots-key)", points: 6, line: false }] : [line];
}

function baked(data) {
  return data.keys.length > 0.8 * data.frameCount ? " The sketch has a key at every frame." : "";
}

class Curves {
  constructor(context) {
    Object.assign(this, context);
    this.picker = new ChannelPicker(this.controls, context, {
      key: "column",
      title: "Channel",
      columns: this.data.curves.columns,
    });
    this.chart = new TimeChart(this.body, context, { height: 260, label: "" });
    if (this.data.curves.left_out)
      this.body.append(
        el("p", { class: "muted plots-note" }, `${this.data.curves.left_out} channels that move less are not in this page.`),
      );
  }

  draw() {
    const { data, state } = this;
    this.picker.show();
    const chosen = this.variant();
    const variants = data.variants.map(({ name }, i) => ({
      name,
      values: data.finished(state.column, i),
      stroke: variantColour(i),
      dash: dashOf(i),
      width: i === chosen ? 2.5 : 1.25,
      alpha: i === chosen ? 1 : 0.75,
    }));
    this.chart.draw({
      times: data.times,
      lines: [...sketchLines(data, state.column), ...variants],
      unit: data.channels[state.column].unit,
      label: `${channelName(data, state.column)} over time: the sketch and ${data.variants.length} variants.${baked(data)}`,
    });
  }

  showFrame(frame) {
    this.chart.showFrame(frame);
  }

  destroy() {
    this.chart.destroy();
  }
}

export const curves = {
  id: "curves",
  title: "Curves",
  wide: true,
  height: 330,
  how: "The sketch (dashed, keys as dots) and every variant, contacts held. A name in the legend hides its curve; a click goes to that time, dragging zooms in, a double click zooms out.",
  make: (context) => new Curves(context),
};

class KeyedAgainstCaptured {
  constructor(context) {
    Object.assign(this, context);
    this.picker = new ChannelPicker(this.controls, context, {
      key: "keyed",
      title: "Channel",
      columns: this.data.curves.joins.columns,
    });
    const side = (title) => {
      const host = el("div", {}, el("h4", {}, title));
      this.pair.append(host);
      return new TimeChart(host, context, { height: 190, label: "" });
    };
    this.pair = el("div", { class: "plots-pair" });
    this.body.append(this.pair);
    this.charts = [side("(a) keyed"), side("(b) captured, as the chosen variant copies it")];
  }

  draw() {
    const { data } = this;
    this.column = data.pathColumn(this.state.keyed);
    this.picker.show(this.column);
    const unit = data.channels[this.column].unit;
    const name = channelName(data, this.column);
    const captured = this.capturedLines();
    const own = sketchLines(data, this.column);
    const yRange = commonRange([own[0].values, ...captured.map((line) => line.values)]);
    this.charts[0].draw({ times: data.times, lines: own, unit, yRange, label: `${name} of the sketch.${baked(data)}` });
    this.charts[1].draw({
      times: data.gapped,
      lines: captured,
      unit,
      yRange,
      label: `${name} of the takes' fragments, stretched into place.`,
      marks: drawBreaks(data, null),
    });
  }

  /** The captured fragments, one line per take. */
  capturedLines() {
    const { data } = this;
    const variant = this.variant();
    const whole = data.capturedWithGaps(this.column, variant);
    const owner = data.withGaps((first, last, q) => new Array(last - first + 1).fill(data.variants[variant].fragments[q].take));
    return [...new Set(data.variants[variant].fragments.map((use) => use.take))].map((take) => ({
      name: data.takes[take].label,
      values: whole.map((value, i) => (owner[i] === take ? value : null)),
      stroke: takeColour(take),
      width: 2,
    }));
  }

  showFrame(frame) {
    this.charts.forEach((chart) => chart.showFrame(frame));
  }

  destroy() {
    this.charts.forEach((chart) => chart.destroy());
  }
}

/** A range that holds all curves, with a little air. */
function commonRange(curves) {
  let low = Infinity;
  let high = -Infinity;
  for (const curve of curves) {
    for (const value of curve)
      if (value !== null) {
        low = Math.min(low, value);
        high = Math.max(high, value);
      }
  }
  const air = 0.06 * (high - low) || 1;
  return [low - air, high + air];
}

export const keyedAgainstCaptured = {
  id: "keyed",
  title: "Keyed against captured",
  figure: "figure 1",
  wide: true,
  height: 260,
  how: "The same channel as it was keyed and as it was recorded, on one scale: what the keys leave out are the irregularities of live motion.",
  make: (context) => new KeyedAgainstCaptured(context),
};
