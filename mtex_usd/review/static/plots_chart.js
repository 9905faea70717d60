// A chart over time: uPlot with the page's colours, a line where the player is, and a legend that reads values.

import uPlot from "uplot";
import { el, onWidth, resolve, sample, short, withUnit } from "./plots_dom.js";

const FONT = '11px system-ui, -apple-system, "Segoe UI", Roboto, sans-serif';
const STEPS = { ArrowLeft: -1, ArrowRight: 1, PageUp: -12, PageDown: 12 };

function axes(unit, bare) {
  const line = { stroke: resolve("var(--grid)"), width: 1 };
  const look = { stroke: resolve("var(--muted)"), font: FONT, grid: line, ticks: { ...line, size: 4 } };
  return [
    {
      ...look,
      size: bare ? 6 : 26,
      gap: 3,
      space: 46,
      values: (_, splits) => splits.map((value) => (bare ? "" : String(Number(value.toFixed(2))))),
    },
    {
      ...look,
      size: 46,
      gap: 3,
      space: bare ? 22 : 30,
      values: (_, splits) => splits.map((value) => short(value) + (unit === "°" ? "°" : "")),
    },
  ];
}

/** A line with a gap at every null, also where the values on both sides of it are at one time. */
function brokenLine(u, index, from, to) {
  const path = new Path2D();
  let drawing = false;
  for (let i = from; i <= to; i += 1) {
    const value = u.data[index][i];
    if (value === null || value === undefined) {
      drawing = false;
      continue;
    }
    const [x, y] = [u.valToPos(u.data[0][i], "x", true), u.valToPos(value, "y", true)];
    if (drawing) path.lineTo(x, y);
    else path.moveTo(x, y);
    drawing = true;
  }
  return { stroke: path, fill: null, clip: null, band: null, gaps: null, flags: 0 };
}

function series({ stroke, width = 1.25, dash = [], points = 0, line = true, shown = true, alpha = 1, broken = false }) {
  const colour = resolve(stroke);
  return {
    ...(broken ? { paths: brokenLine } : {}),
    stroke: line ? colour : "transparent",
    width,
    dash,
    show: shown,
    alpha,
    points: points
      ? { show: true, size: points, width: 1.5, stroke: colour, fill: line ? resolve("var(--panel)") : colour }
      : { show: false },
  };
}

export class TimeChart {
  /**
   * @param {HTMLElement} host
   * @param {object} context data, player, state
   * @param {{height?: number, unit?: string, label: string, bare?: boolean, legend?: boolean, onPick?: Function}} options
   */
  constructor(host, { data, player, state }, { height = 220, legend = true, ...options }) {
    Object.assign(this, { data, player, state, height, options, hidden: new Set() });
    this.legend = legend ? el("div", { class: "plots-legend" }) : null;
    this.box = el("div", { class: "plots-chart", role: "img", tabindex: "0", style: `height:${height}px` });
    this.now = el("div", { class: "plots-now" });
    host.append(...(this.legend ? [this.legend] : []), this.box);
    this.box.addEventListener("keydown", (event) => this.key(event));
    this.stop = onWidth(this.box, (width) => {
      this.width = width;
      this.build();
    });
  }

  key(event) {
    const step = STEPS[event.key];
    if (step === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    this.player.setFrame(Math.round(this.player.frame) + step);
  }

  /**
   * Draw other curves.
   * @param {{times: ArrayLike<number>, lines: object[], unit?: string, label?: string, range?: number[], yRange?: number[], marks?: Function}} content
   *   lines have name, values, stroke and maybe width, dash, points, line, alpha
   */
  draw(content) {
    this.content = content;
    this.build();
  }

  build() {
    if (!this.content || !this.width) return;
    this.chart?.destroy();
    const { times, lines, yRange } = this.content;
    const unit = this.content.unit ?? this.options.unit ?? "°";
    this.box.setAttribute("aria-label", `${this.content.label ?? this.options.label} Arrow keys move through time.`);
    const range = this.content.range ?? (this.state.frames && this.state.span);
    this.chart = new uPlot(
      {
        width: this.width,
        height: this.height,
        legend: { show: false },
        padding: [8, 10, 0, 0],
        scales: { x: { time: false, ...(range ? { range } : {}) }, y: yRange ? { range: yRange } : {} },
        axes: axes(unit, this.options.bare),
        cursor: { points: { size: 6 }, y: false, drag: { x: !range, y: false, setScale: true } },
        series: [
          {},
          ...lines.map((line) => series({ ...line, broken: times === this.data.gapped, shown: !this.hidden.has(line.name) })),
        ],
        hooks: {
          drawClear: [(u) => this.content.marks?.(u.ctx, this.painter(u))],
          draw: [
            (u) => {
              this.content.over?.(u.ctx, this.painter(u));
              this.measure(u);
            },
          ],
          setCursor: [(u) => this.read(u)],
        },
      },
      [times, ...lines.map((line) => line.values)],
      this.box,
    );
    this.listen(this.chart.over);
    this.chart.over.append(this.now);
    this.buildLegend(unit);
  }

  /** Note where times are, once the chart has its scales; asked for at every frame. */
  measure(u) {
    const { min, max } = u.scales.x;
    this.span = { min, max, width: u.bbox.width / (devicePixelRatio || 1) };
    this.showFrame(this.player.frame);
  }

  /** What marks need to draw with: pixel places of times and values, and the area. */
  painter(u) {
    const ratio = devicePixelRatio || 1;
    return { x: (time) => u.valToPos(time, "x", true), y: (value) => u.valToPos(value, "y", true), ratio, ...u.bbox };
  }

  listen(over) {
    let pressed = 0;
    over.addEventListener("pointerdown", (event) => {
      pressed = event.clientX;
    });
    over.addEventListener("click", (event) => {
      if (Math.abs(event.clientX - pressed) > 4) return;
      const time = this.chart.posToVal(event.clientX - over.getBoundingClientRect().left, "x");
      this.player.setFrame(this.data.frameOf(time));
      this.options.onPick?.(time);
    });
  }

  buildLegend(unit) {
    if (!this.legend) return;
    this.values = [];
    const items = this.content.lines
      .filter((line) => line.name && !line.mute)
      .map((line) => {
        const value = el("span", { class: "plots-value" });
        this.values.push({ line, value, unit });
        const toggle = () => {
          if (this.hidden.has(line.name)) this.hidden.delete(line.name);
          else this.hidden.add(line.name);
          this.build();
          [...this.legend.querySelectorAll("button")].find((button) => button.dataset.name === line.name)?.focus();
        };
        const mark =
          line.line === false
            ? el("span", { class: "plots-dot", style: `background:${line.stroke}` })
            : sample(line.stroke, line.dash ?? [], line.width ?? 1.5);
        return el(
          "button",
          {
            type: "button",
            class: "plots-key",
            "data-name": line.name,
            "aria-pressed": String(!this.hidden.has(line.name)),
            onclick: toggle,
          },
          mark,
          line.name,
          value,
        );
      });
    this.at = el("span", { class: "plots-at" });
    this.legend.replaceChildren(...items, this.at);
    this.readAt(this.data.timeOf(this.player.frame));
  }

  read(u) {
    if (!this.legend) return;
    this.hovering = u.cursor.idx !== null && u.cursor.idx !== undefined && u.cursor.left >= 0;
    if (this.hovering) this.write(u.cursor.idx);
    else this.readAt(this.data.timeOf(this.player.frame));
  }

  readAt(time) {
    const { times } = this.content;
    let low = 0;
    let high = times.length - 1;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (times[middle] < time - 1e-9) low = middle + 1;
      else high = middle;
    }
    this.write(low);
  }

  write(index) {
    this.at.textContent = `at ${short(this.content.times[index])}`;
    for (const { line, value, unit } of this.values)
      value.textContent = line.line === false ? "" : withUnit(line.values[index], unit);
  }

  /** Move the line to where the player is; values are read only while it stands still. */
  showFrame(frame) {
    if (!this.span) return;
    const { min, max, width } = this.span;
    const part = (this.data.timeOf(frame) - min) / (max - min);
    const inside = part >= 0 && part <= 1;
    this.now.style.visibility = inside ? "visible" : "hidden";
    if (inside) this.now.style.transform = `translateX(${(part * width).toFixed(1)}px)`;
    if (this.legend && !this.player.playing && !this.hovering) this.readAt(this.data.timeOf(frame));
  }

  destroy() {
    this.stop();
    this.chart?.destroy();
  }
}

/** Vertical lines at fragment borders, and one fragment shaded. */
export function drawBreaks(data, chosen, { solid = () => true } = {}) {
  return (ctx, { x, top, height, ratio }) => {
    ctx.save();
    if (chosen !== null) {
      const { first, last } = data.fragments[chosen];
      ctx.fillStyle = resolve("var(--accent)");
      ctx.globalAlpha = 0.13;
      ctx.fillRect(x(data.timeOf(first)), top, x(data.timeOf(last)) - x(data.timeOf(first)), height);
      ctx.globalAlpha = 1;
    }
    ctx.strokeStyle = resolve("var(--muted)");
    ctx.lineWidth = ratio;
    data.breaks.forEach((frame, i) => {
      const at = Math.round(x(data.timeOf(frame))) + 0.5;
      ctx.globalAlpha = 0.55;
      ctx.setLineDash(solid(i) ? [] : [2 * ratio, 3 * ratio]);
      ctx.beginPath();
      ctx.moveTo(at, top);
      ctx.lineTo(at, top + height);
      ctx.stroke();
    });
    ctx.restore();
  };
}
