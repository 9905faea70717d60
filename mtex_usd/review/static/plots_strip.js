// What every variant is made of: a strip per variant, coloured by take, with its joins.

import { el, inkOn, onWidth, short, svg, takeColour, variantColour } from "./plots_dom.js";

const LABEL = 66;
const ROW = 30;
const BAR = 20;

function describe(data, variant, q) {
  const use = data.variants[variant].fragments[q];
  const length = (use.takeLast - use.takeFirst) / (data.fragments[q].last - data.fragments[q].first);
  return [
    `${data.variants[variant].name}, fragment ${q + 1}: ${short(use.start)} to ${short(use.end)}`,
    `${data.takes[use.take].name}, ${short(use.takeStart)} to ${short(use.takeEnd)}`,
    `distance ${short(use.distance)} · ${short(length)} × its length · scale ${short(use.scale)}`,
    q + 1 < data.fragments.length
      ? `next: ${data.variants[variant].continued[q] ? "consecutive in the take" : "another place, joined"}`
      : "last fragment",
  ];
}

class Strip {
  constructor({ data, player, tip, state, controls, body }) {
    Object.assign(this, { data, player, tip, state });
    const used = [...new Set(data.variants.flatMap((variant) => variant.fragments.map((use) => use.take)))].sort(
      (a, b) => a - b,
    );
    controls.append(
      el(
        "div",
        { class: "plots-legend" },
        ...used.map((take) =>
          el(
            "span",
            { class: "plots-key" },
            el("span", { class: "plots-dot", style: `background:${takeColour(take)}` }),
            data.takes[take].label,
          ),
        ),
      ),
    );
    this.now = el("div", { class: "plots-now" });
    this.area = el("div", { class: "plots-area", style: `left:${LABEL}px` }, this.now);
    this.rows = el("div", {});
    this.box = el("div", { class: "plots-stack" }, this.rows, this.area);
    body.append(this.box);
    this.stop = onWidth(this.box, (width) => {
      this.width = width;
      this.draw();
    });
  }

  draw() {
    if (!this.width) return;
    this.rows.replaceChildren(...this.data.variants.map((_, variant) => this.row(variant)));
    this.showFrame(this.player.frame);
  }

  x(frame) {
    return (frame / Math.max(this.data.frameCount - 1, 1)) * (this.width - LABEL);
  }

  row(variant) {
    const { name, zeroCostJoins, continued } = this.data.variants[variant];
    const chosen = this.player.variant === name;
    const picture = svg(
      "svg",
      {
        width: this.width - LABEL,
        height: ROW,
        role: "img",
        tabindex: "0",
        class: "plots-strip",
        "aria-label": `${name}: ${continued.length + 1} fragments, ${zeroCostJoins} of ${continued.length} joins consecutive in their take. Arrow keys go from fragment to fragment.`,
        onkeydown: (event) => this.key(event, variant),
        onclick: (event) => this.seek(event, variant),
        onblur: () => this.tip.hide(),
      },
      ...this.data.fragments.map((_, q) => this.piece(variant, q)),
      ...continued.map((follows, q) => this.joint(q, follows)),
      ...this.names(variant),
    );
    const button = el(
      "button",
      {
        type: "button",
        class: "plots-name",
        "aria-pressed": String(chosen),
        style: `border-color:${variantColour(variant)}`,
        onclick: () => this.player.setVariant(name),
      },
      name,
    );
    return el("div", { class: "plots-row" }, button, picture);
  }

  piece(variant, q) {
    const { first, last } = this.data.fragments[q];
    const { take } = this.data.variants[variant].fragments[q];
    const piece = svg("rect", {
      x: this.x(first),
      y: (ROW - BAR) / 2,
      width: this.x(last) - this.x(first),
      height: BAR,
      fill: takeColour(take),
      class: "plots-piece",
    });
    this.tip.attach(piece, () => describe(this.data, variant, q));
    return piece;
  }

  /** The takes' names, once for fragments of one take in a row, in the widest of them that has room. */
  names(variant) {
    const takes = this.data.variants[variant].fragments.map((use) => use.take);
    const width = (q) => this.x(this.data.fragments[q].last) - this.x(this.data.fragments[q].first);
    const runs = [];
    takes.forEach((take, q) => {
      if (take === takes[q - 1]) runs[runs.length - 1].push(q);
      else runs.push([q]);
    });
    return runs.flatMap((run) => {
      const q = run.reduce((widest, other) => (width(other) > width(widest) ? other : widest));
      const { label } = this.data.takes[takes[q]];
      if (label.length * 6.6 + 10 > width(q)) return [];
      const middle = this.x(this.data.fragments[q].first) + width(q) / 2;
      return [
        svg(
          "text",
          { x: middle, y: ROW / 2 + 4, "text-anchor": "middle", fill: inkOn(takeColour(takes[q])), class: "plots-take" },
          label,
        ),
      ];
    });
  }

  /** A join: a knot on the line where the take just goes on, a cut through the strip where it does not. */
  joint(q, follows) {
    const x = this.x(this.data.fragments[q].last);
    const dense = this.width - LABEL < 14 * this.data.fragments.length;
    if (follows) return svg("circle", { cx: x, cy: ROW / 2, r: dense ? 1.5 : 3, class: "plots-link" });
    return svg("rect", {
      x: x - 1.5,
      y: dense ? 2 : 0,
      width: dense ? 2 : 3,
      height: dense ? ROW - 4 : ROW,
      class: "plots-cut",
    });
  }

  seek(event, variant) {
    const box = event.currentTarget.getBoundingClientRect();
    const frame = Math.round(((event.clientX - box.left) / box.width) * (this.data.frameCount - 1));
    this.player.setVariant(this.data.variants[variant].name);
    this.state.set({ fragment: this.data.fragmentAt(frame) });
    this.player.setFrame(frame);
  }

  key(event, variant) {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!step) return;
    event.preventDefault();
    event.stopPropagation();
    const q = Math.min(this.data.fragments.length - 1, Math.max(0, this.state.fragment + step));
    this.state.fragment = q;
    this.player.setFrame(this.data.fragments[q].first);
    const box = event.currentTarget.getBoundingClientRect();
    this.tip.show(describe(this.data, variant, q), box.left + this.x(this.data.fragments[q].first), box.top);
  }

  showFrame(frame) {
    if (this.width) this.now.style.transform = `translateX(${this.x(frame).toFixed(1)}px)`;
  }

  destroy() {
    this.stop();
  }
}

export const strip = {
  id: "strip",
  title: "Where each variant comes from",
  wide: true,
  height: 180,
  how: "One strip per variant; a colour is a take, a fragment a stretch of it. A dot is a join where the take just goes on, a cut one where two places were joined.",
  make: (context) => new Strip(context),
};
