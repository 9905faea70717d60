// A take as it was matched: its band, cut like the sketch's (figure 4 b and d), and what a variant uses of it.

import uPlot from "uplot";
import { el, onWidth, resolve, short, variantColour } from "./plots_dom.js";

const HEIGHT = 170;

export class TakeChart {
  constructor(host) {
    this.now = el("div", { class: "plots-now" });
    this.box = el("div", { class: "plots-chart", role: "img", style: `height:${HEIGHT}px` });
    host.append(this.box);
    this.stop = onWidth(this.box, (width) => {
      this.width = width;
      this.build();
    });
  }

  /** @param {{clip: object, curve: Float64Array, breaks: number[], used: number[][], unit: string, variant: number, label: string, at: Function}} content */
  draw(content) {
    this.content = content;
    this.build();
  }

  build() {
    if (!this.content || !this.width) return;
    this.chart?.destroy();
    const { clip, curve, used, unit, variant, label } = this.content;
    this.box.setAttribute("aria-label", label);
    const times = Array.from(curve, (_, frame) => clip.start + frame * clip.timeCodesPerFrame);
    const within = (frame) => used.some(([first, last]) => frame >= first && frame <= last);
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
          { ...axis, size: 26, values: (_, splits) => splits.map((value) => short(value)) },
          { ...axis, size: 46, values: (_, splits) => splits.map((value) => short(value) + (unit === "°" ? "°" : "")) },
        ],
        cursor: { y: false, drag: { x: true, y: false }, points: { show: false } },
        series: [
          {},
          { stroke: resolve("var(--fg)"), width: 1, points: { show: false } },
          { stroke: resolve(variantColour(variant)), width: 3, points: { show: false } },
        ],
        hooks: { drawClear: [(u) => this.drawBreaks(u)], draw: [() => this.showFrame()] },
      },
      [times, Array.from(curve), Array.from(curve, (value, frame) => (within(frame) ? value : null))],
      this.box,
    );
    this.chart.over.append(this.now);
  }

  drawBreaks(u) {
    const { clip, breaks } = this.content;
    const { ctx, bbox } = u;
    ctx.save();
    ctx.strokeStyle = resolve("var(--muted)");
    ctx.globalAlpha = 0.55;
    ctx.lineWidth = devicePixelRatio || 1;
    for (const frame of breaks) {
      const x = Math.round(u.valToPos(clip.start + frame * clip.timeCodesPerFrame, "x", true)) + 0.5;
      ctx.beginPath();
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
      ctx.stroke();
    }
    ctx.restore();
  }

  /** A line where the variant reads the take at the player's frame; none where it reads another one. */
  showFrame() {
    if (!this.chart) return;
    const { clip, at } = this.content;
    const frame = at();
    const { min, max } = this.chart.scales.x;
    const part = frame === null ? -1 : (clip.start + frame * clip.timeCodesPerFrame - min) / (max - min);
    const inside = part >= 0 && part <= 1;
    this.now.style.visibility = inside ? "visible" : "hidden";
    if (inside)
      this.now.style.transform = `translateX(${((part * this.chart.bbox.width) / (devicePixelRatio || 1)).toFixed(1)}px)`;
  }

  destroy() {
    this.stop();
    this.chart?.destroy();
  }
}
