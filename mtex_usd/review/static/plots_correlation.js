// One channel against another (figure 2): takes, sketch and result.

import { SKETCH_DASH, dashOf, el, onWidth, resolve, sample, short, variantColour } from "./plots_dom.js";
import { ChannelPicker, channelName } from "./plots_pickers.js";

const EDGE = { left: 52, right: 12, top: 10, bottom: 40 };
const HEIGHT = 400;

/** Round values about so far apart that `count` fit. */
function ticks(low, high, count) {
  const rough = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((size) => size >= rough);
  const out = [];
  for (let value = Math.ceil(low / step) * step; value <= high + 1e-9 * step; value += step) out.push(value);
  return out;
}

function range(curves) {
  let low = Infinity;
  let high = -Infinity;
  for (const curve of curves)
    for (const value of curve) {
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
  const air = 0.05 * (high - low) || 1;
  return [low - air, high + air];
}

/** Pearson's coefficient; not a number where one of the two does not move. */
function correlate(a, b) {
  const mean = (curve) => curve.reduce((sum, value) => sum + value, 0) / curve.length;
  const [ma, mb] = [mean(a), mean(b)];
  let [ab, aa, bb] = [0, 0, 0];
  for (let i = 0; i < a.length; i += 1) {
    ab += (a[i] - ma) * (b[i] - mb);
    aa += (a[i] - ma) ** 2;
    bb += (b[i] - mb) ** 2;
  }
  return aa < 1e-6 || bb < 1e-6 ? Number.NaN : ab / Math.sqrt(aa * bb);
}

class Correlation {
  constructor(context) {
    Object.assign(this, context);
    const { columns } = this.data.curves;
    this.pickers = [
      ["keyed", "Across"],
      ["column", "Up"],
    ].map(([key, title]) => new ChannelPicker(this.controls, context, { key, title, columns }));
    this.keys = el("div", { class: "plots-legend" });
    this.canvas = el("canvas", { role: "img", tabindex: "0" });
    this.dot = el("div", { class: "plots-here" });
    this.box = el("div", { class: "plots-scatter", style: `height:${HEIGHT}px` }, this.canvas, this.dot);
    this.body.append(this.keys, this.box);
    this.canvas.addEventListener("click", (event) => this.seek(event));
    this.stop = onWidth(this.box, (width) => {
      this.width = width;
      this.paint();
    });
  }

  draw() {
    const { data, state } = this;
    this.pickers.forEach((picker) => picker.show());
    const variant = this.variant();
    const takes = data.takes
      .map((_, take) => [data.takeCurve(state.keyed, take), data.takeCurve(state.column, take)])
      .filter(([a, b]) => a && b);
    this.takes = takes;
    this.own = [data.sketch(state.keyed), data.sketch(state.column)];
    this.made = [data.finished(state.keyed, variant), data.finished(state.column, variant)];
    this.paint();
    this.showKeys(variant);
  }

  showKeys(variant) {
    const { data, state } = this;
    const joined = [0, 1].map((axis) => this.takes.flatMap((pair) => Array.from(pair[axis])));
    const r = (a, b) => {
      const value = correlate(a, b);
      return Number.isNaN(value) ? "one does not move" : `r = ${value.toFixed(2)}`;
    };
    const entry = (mark, name, text) =>
      el("span", { class: "plots-key" }, mark, name, el("span", { class: "plots-value" }, text));
    this.keys.replaceChildren(
      this.takes.length
        ? entry(el("span", { class: "plots-dot", style: "background:var(--muted)" }), "takes", r(...joined))
        : entry("", "takes", "not in this page"),
      entry(sample("var(--sketch)", SKETCH_DASH), "sketch", r(...this.own)),
      entry(sample(variantColour(variant), dashOf(variant)), data.variants[variant].name, r(...this.made)),
    );
    this.canvas.setAttribute(
      "aria-label",
      `${channelName(data, state.column)} against ${channelName(data, state.keyed)}: takes ${this.takes.length ? r(...joined) : "left out"}, ${data.variants[variant].name} ${r(...this.made)}. A click goes to the nearest frame.`,
    );
  }

  paint() {
    if (!this.width || !this.made) return;
    const ratio = devicePixelRatio || 1;
    Object.assign(this.canvas, { width: this.width * ratio, height: HEIGHT * ratio });
    const ctx = this.canvas.getContext("2d");
    ctx.scale(ratio, ratio);
    const all = [...this.takes, this.own, this.made];
    this.ranges = [0, 1].map((axis) => range(all.map((pair) => pair[axis])));
    this.paintAxes(ctx);
    ctx.fillStyle = resolve("var(--muted)");
    ctx.globalAlpha = 0.65;
    for (const [a, b] of this.takes)
      for (let i = 0; i < a.length; i += 1) ctx.fillRect(this.x(a[i]) - 1, this.y(b[i]) - 1, 2, 2);
    ctx.globalAlpha = 1;
    const variant = this.variant();
    this.paintLine(ctx, this.own, "var(--sketch)", SKETCH_DASH, 1.5);
    this.paintLine(ctx, this.made, variantColour(variant), dashOf(variant), 1.5);
    this.showFrame(this.player.frame);
  }

  x(value) {
    return this.along(value, 0, EDGE.left, this.width - EDGE.right);
  }

  y(value) {
    return this.along(value, 1, HEIGHT - EDGE.bottom, EDGE.top);
  }

  along(value, axis, from, to) {
    const [low, high] = this.ranges[axis];
    return from + ((value - low) / (high - low)) * (to - from);
  }

  paintAxes(ctx) {
    const { data, state } = this;
    ctx.font = '11px system-ui, -apple-system, "Segoe UI", Roboto, sans-serif';
    ctx.strokeStyle = resolve("var(--grid)");
    ctx.fillStyle = resolve("var(--muted)");
    ctx.lineWidth = 1;
    const line = (...[x1, y1, x2, y2]) => {
      ctx.beginPath();
      ctx.moveTo(x1, y1);
      ctx.lineTo(x2, y2);
      ctx.stroke();
    };
    ctx.textAlign = "center";
    for (const value of ticks(...this.ranges[0], this.width / 80)) {
      line(this.x(value), EDGE.top, this.x(value), HEIGHT - EDGE.bottom);
      ctx.fillText(short(value), this.x(value), HEIGHT - EDGE.bottom + 14);
    }
    ctx.textAlign = "right";
    for (const value of ticks(...this.ranges[1], 7)) {
      line(EDGE.left, this.y(value), this.width - EDGE.right, this.y(value));
      ctx.fillText(short(value), EDGE.left - 5, this.y(value) + 4);
    }
    ctx.textAlign = "center";
    ctx.fillStyle = resolve("var(--fg)");
    ctx.fillText(
      `${channelName(data, state.keyed)} (${data.channels[state.keyed].unit})`,
      (EDGE.left + this.width) / 2,
      HEIGHT - 8,
    );
    ctx.save();
    ctx.translate(12, (HEIGHT - EDGE.bottom) / 2);
    ctx.rotate(-Math.PI / 2);
    ctx.fillText(`${channelName(data, state.column)} (${data.channels[state.column].unit})`, 0, 0);
    ctx.restore();
  }

  paintLine(ctx, [a, b], colour, dash, width) {
    ctx.strokeStyle = resolve(colour);
    ctx.lineWidth = width;
    ctx.setLineDash(dash);
    ctx.beginPath();
    for (let i = 0; i < a.length; i += 1) ctx.lineTo(this.x(a[i]), this.y(b[i]));
    ctx.stroke();
    ctx.setLineDash([]);
  }

  seek(event) {
    const box = this.canvas.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    const far = (i) => (this.x(this.made[0][i]) - x) ** 2 + (this.y(this.made[1][i]) - y) ** 2;
    let best = 0;
    for (let i = 1; i < this.made[0].length; i += 1) if (far(i) < far(best)) best = i;
    this.player.setFrame(best);
  }

  showFrame(frame) {
    if (!this.width || !this.ranges) return;
    const i = Math.min(this.made[0].length - 1, Math.max(0, Math.round(frame)));
    this.dot.style.transform = `translate(${this.x(this.made[0][i]).toFixed(1)}px, ${this.y(this.made[1][i]).toFixed(1)}px)`;
    if (!this.player.playing) this.dot.title = [0, 1].map((axis) => short(this.made[axis][i])).join(", ");
  }

  destroy() {
    this.stop();
  }
}

export const correlation = {
  id: "correlation",
  title: "Correlation of channels",
  figure: "figure 2",
  wide: false,
  height: 480,
  how: "Every frame of the takes is a grey point: where they form a shape, one channel tells the other. The result should lie on it; the sketch, where it has no motion in a channel, is a flat line.",
  make: (context) => new Correlation(context),
};
