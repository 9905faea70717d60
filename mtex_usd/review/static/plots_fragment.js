// One fragment of the sketch with its candidates over each other (figure 5).

import uPlot from "uplot";
import { el, onWidth, resolve, short, variantColour } from "./plots_dom.js";

const HEIGHT = 230;

export class FragmentChart {
  constructor(host) {
    this.box = el("div", { class: "plots-chart", role: "img", style: `height:${HEIGHT}px` });
    host.append(this.box);
    this.stop = onWidth(this.box, (width) => {
      this.width = width;
      this.build();
    });
  }

  draw(content) {
    this.content = content;
    this.build();
  }

  /** Bring one candidate forward, or none. */
  highlight(k) {
    if (!this.chart) return;
    this.content.curves.forEach((curve, i) => {
      const line = this.chart.series[i + 1];
      line.alpha = k === null || curve.k === k ? 1 : 0.25;
      line.width = curve.k === k ? 3 : this.widthOf(curve);
    });
    this.chart.redraw(false);
  }

  widthOf({ k }) {
    return (k === this.content.choice ? 2.25 : 1.1) * (devicePixelRatio || 1);
  }

  build() {
    if (!this.content || !this.width) return;
    this.chart?.destroy();
    const { own, curves, unit, label } = this.content;
    this.box.setAttribute("aria-label", label);
    const length = Math.max(own.length, ...curves.map(({ values }) => values.length));
    const frames = Array.from({ length }, (_, i) => i);
    const fill = (values) => frames.map((i) => (i < values.length ? values[i] : null));
    const line = { stroke: resolve("var(--grid)"), width: 1 };
    const axis = {
      stroke: resolve("var(--muted)"),
      font: "11px system-ui, sans-serif",
      grid: line,
      ticks: { ...line, size: 4 },
      gap: 3,
    };
    this.chart = new uPlot(
      {
        width: this.width,
        height: HEIGHT,
        legend: { show: false },
        padding: [8, 10, 0, 0],
        scales: { x: { time: false } },
        axes: [
          { ...axis, size: 38, label: "frames of the fragment", labelFont: axis.font, labelSize: 14 },
          { ...axis, size: 46, values: (_, splits) => splits.map((value) => short(value) + (unit === "°" ? "°" : "")) },
        ],
        cursor: { y: false, drag: { x: false, y: false }, points: { show: false } },
        series: [
          {},
          ...curves.map((curve) => this.series(curve)),
          { stroke: resolve("var(--sketch)"), width: 4, points: { show: false } },
        ],
      },
      [frames, ...curves.map(({ values }) => fill(values)), fill(own)],
      this.box,
    );
  }

  series({ k }) {
    const { choice, variant } = this.content;
    const chosen = k === choice;
    return {
      stroke: resolve(chosen ? variantColour(variant) : "var(--fg)"),
      width: chosen ? 2.25 : 1.1,
      points: { show: false },
    };
  }

  destroy() {
    this.stop();
    this.chart?.destroy();
  }
}
