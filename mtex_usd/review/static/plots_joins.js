// Joining fragments: as they were, made to meet, blended (figures 8 and 9).

import { TimeChart, drawBreaks } from "./plots_chart.js";
import { el, resolve, short, variantColour, withUnit } from "./plots_dom.js";
import { ChannelPicker, StepPicker, channelName } from "./plots_pickers.js";

const LEAST_REACH = 3;
const TITLES = ["(a) fragments as they were captured", "(b) skewed to meet half way", "(c)"];

class Joins {
  constructor(context) {
    Object.assign(this, context);
    this.picker = new ChannelPicker(this.controls, context, {
      key: "column",
      title: "Channel",
      columns: this.data.curves.joins.columns,
    });
    this.steps = new StepPicker(this.controls, {
      title: "Join",
      previous: "Join before",
      next: "Next join",
      onPick: (join) => this.pick(join),
    });
    const row = el("div", { class: "plots-triple" });
    this.titles = TITLES.map((title) => el("h4", {}, title));
    this.charts = this.titles.map((title) => {
      const host = el("div", {}, title);
      row.append(host);
      return new TimeChart(host, context, { height: 220, label: "" });
    });
    this.body.append(row);
  }

  pick(join) {
    this.player.setFrame(this.data.fragments[join].last);
    this.state.set({ join });
  }

  draw() {
    const { data, state } = this;
    this.column = data.pathColumn(state.column);
    this.picker.show(this.column);
    const variant = this.variant();
    const { captured, skewed, joined } = this.read(variant);
    const gaps = data.variants[variant].continued.map((_, q) =>
      Math.abs(captured[data.breaks[q + 1] + q] - captured[data.breaks[q + 1] + q + 1]),
    );
    const open = gaps.map((gap, q) => (data.variants[variant].continued[q] ? -2 : this.reach(q, variant) ? gap : -1));
    const join = state.join ?? open.indexOf(Math.max(...open));
    this.showSteps(gaps, variant, join);
    this.titles[2].textContent = `(c) ${this.describeBlend(join, variant)}`;
    this.content({ variant, join, captured, skewed, joined }).forEach((content, i) => this.charts[i].draw(content));
  }

  read(variant) {
    return Object.fromEntries(
      ["captured", "skewed", "joined"].map((stage) => [stage, this.data.joining(stage, this.column, variant)]),
    );
  }

  showSteps(gaps, variant, join) {
    const { data } = this;
    const { unit } = data.channels[this.column];
    this.steps.show(
      gaps.map((gap, q) => ({
        value: q,
        text: `${q + 1}: at ${short(data.timeOf(data.breaks[q + 1]))}, ${data.variants[variant].continued[q] ? "consecutive" : `gap ${withUnit(gap, unit)}`}`,
      })),
      join,
    );
  }

  /** N on either side that the blend may change: half the shorter fragment, as far as the recipe goes. */
  reach(join, variant) {
    const { data } = this;
    const lengths = [join, join + 1].map((q) => data.fragments[q].last - data.fragments[q].first);
    const reach = Math.min(Math.floor(Math.min(...lengths) / 2), data.joinFrames);
    return data.variants[variant].continued[join] || reach < LEAST_REACH ? 0 : reach;
  }

  describeBlend(join, variant) {
    const reach = this.reach(join, variant);
    if (reach) return `blended over ${reach} frames on either side`;
    return this.data.variants[variant].continued[join]
      ? "nothing to blend: consecutive in the take"
      : "not blended: a fragment is too short";
  }

  content({ variant, join, captured, skewed, joined }) {
    const { data } = this;
    const { unit } = data.channels[this.column];
    const name = `${channelName(data, this.column)} of ${data.variants[variant].name} around join ${join + 1}`;
    const from = data.fragments[Math.max(0, join - 1)].first;
    const to = data.fragments[Math.min(data.fragments.length - 1, join + 2)].last;
    const reach = this.reach(join, variant);
    const near = Math.max(reach, 4) + 4;
    const at = data.fragments[join].last;
    const window = (first, last) => [data.timeOf(Math.max(0, first)), data.timeOf(Math.min(data.frameCount - 1, last))];
    const apart = {
      name: "captured",
      values: data.withGaps((first, last, q) => captured.subarray(first + q, last + q + 1)),
      stroke: "var(--fg)",
      width: 1.75,
    };
    const meeting = { name: "skewed", values: skewed, stroke: "var(--sketch)", width: 2 };
    const blended = { name: "blended", values: joined, stroke: variantColour(variant), width: 2.25, dash: [7, 3] };
    const marks = drawBreaks(data, null, { solid: (i) => i === join + 1 });
    const spans = [window(from, to), window(from, to), window(at - near, at + near)];
    return [
      {
        times: data.gapped,
        lines: [apart],
        range: spans[0],
        unit,
        marks,
        label: `${name}, as captured.`,
        over: this.ends(captured, skewed, from, to, { rings: true }),
      },
      {
        times: data.times,
        lines: [{ ...meeting, stroke: variantColour(variant) }],
        range: spans[1],
        unit,
        marks,
        label: `${name}, skewed to meet.`,
        over: this.ends(captured, skewed, from, to, { rings: false }),
      },
      {
        times: data.times,
        lines: [meeting, blended],
        range: spans[2],
        unit,
        label: `${name}, before and after the blend over ${reach} frames on either side.`,
        marks: this.shade(at, reach, marks),
      },
    ].map((content, i) => ({ ...content, yRange: visibleRange(content, spans[i]) }));
  }

  /** Old end points as rings, new ones as crosses, and the lines through both that are taken off and put on. */
  ends(captured, skewed, from, to, { rings }) {
    const { data } = this;
    return (ctx, { x, y, ratio, left, top, width, height }) => {
      ctx.save();
      ctx.beginPath();
      ctx.rect(left, top, width, height);
      ctx.clip();
      data.fragments.forEach(({ first, last }, q) => {
        if (last < from || first > to) return;
        const old = [captured[first + q], captured[last + q]];
        const now = [skewed[first], skewed[last]];
        const places = [x(data.timeOf(first)), x(data.timeOf(last))];
        if (!rings) drawLine(ctx, places, old.map(y), [4 * ratio, 3 * ratio], resolve("var(--fg)"), ratio);
        if (!rings) drawLine(ctx, places, now.map(y), [], resolve("var(--accent)"), ratio);
        places.forEach((place, end) => {
          if (rings) drawRing(ctx, place, y(old[end]), ratio);
          drawCross(ctx, place, y(now[end]), ratio);
        });
      });
      ctx.restore();
    };
  }

  shade(at, reach, marks) {
    return (ctx, painter) => {
      marks(ctx, painter);
      const [begin, end] = [at - reach, at + reach].map((frame) => painter.x(this.data.timeOf(frame)));
      ctx.save();
      ctx.fillStyle = resolve("var(--accent)");
      ctx.globalAlpha = 0.1;
      ctx.fillRect(begin, painter.top, end - begin, painter.height);
      ctx.restore();
    };
  }

  showFrame(frame) {
    this.charts.forEach((chart) => chart.showFrame(frame));
  }

  destroy() {
    this.charts.forEach((chart) => chart.destroy());
  }
}

/** The range of what a window shows. */
function visibleRange({ times, lines }, [from, to]) {
  let low = Infinity;
  let high = -Infinity;
  for (const { values } of lines) {
    for (let i = 0; i < times.length; i += 1) {
      if (times[i] < from || times[i] > to || values[i] === null) continue;
      low = Math.min(low, values[i]);
      high = Math.max(high, values[i]);
    }
  }
  const air = 0.1 * (high - low) || 1;
  return [low - air, high + air];
}

function drawLine(ctx, [x1, x2], [y1, y2], dash, colour, ratio) {
  ctx.strokeStyle = colour;
  ctx.lineWidth = ratio;
  ctx.setLineDash(dash);
  ctx.beginPath();
  ctx.moveTo(x1, y1);
  ctx.lineTo(x2, y2);
  ctx.stroke();
}

function drawRing(ctx, x, y, ratio) {
  ctx.strokeStyle = resolve("var(--fg)");
  ctx.lineWidth = 1.5 * ratio;
  ctx.setLineDash([]);
  ctx.beginPath();
  ctx.arc(x, y, 4 * ratio, 0, 2 * Math.PI);
  ctx.stroke();
}

function drawCross(ctx, x, y, ratio) {
  const arm = 4 * ratio;
  ctx.strokeStyle = resolve("var(--accent)");
  ctx.lineWidth = 1.75 * ratio;
  ctx.setLineDash([]);
  ctx.beginPath();
  for (const [dx, dy] of [
    [arm, 0],
    [arm / 2, arm],
    [-arm / 2, arm],
  ]) {
    ctx.moveTo(x - dx, y - dy);
    ctx.lineTo(x + dx, y + dy);
  }
  ctx.stroke();
}

export const joins = {
  id: "joins",
  title: "Joining fragments",
  figure: "figures 8, 9",
  wide: true,
  height: 330,
  how: "Rings are the end points as captured, stars where they are made to meet. From each fragment the line through its old ends (dashed) is taken off and that through the new ones (solid) put on; then a fitted curve is blended in where the ground is tinted.",
  wanted: (data) => data.fragments.length > 1,
  make: (context) => new Joins(context),
};
