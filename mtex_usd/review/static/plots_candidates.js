// The candidates of all fragments, which of them follow on, and the path through them (figure 7).

import { el, short, svg, takeColour, variantColour } from "./plots_dom.js";

const CELL = { width: 50, height: 20, gap: 26, top: 22 };
const MOST_CELLS = 3000;
const MANY_LINKS = 300;

class Candidates {
  constructor(context) {
    Object.assign(this, context);
    const { data } = this;
    const most = Math.max(...data.fragments.map((fragment) => fragment.take.length));
    this.rows = Math.min(most, Math.max(5, Math.floor(MOST_CELLS / data.fragments.length)));
    this.offered = data.fragments.reduce((sum, fragment) => sum + fragment.joins.length / 2, 0);
    this.summary = el("p", { class: "plots-note" });
    this.scroller = el("div", {
      class: "plots-scroll",
      tabindex: "0",
      role: "region",
      "aria-label": "Candidate table; scrolls sideways",
    });
    this.body.append(this.summary, this.scroller);
    if (this.rows < most)
      this.body.append(
        el(
          "p",
          { class: "muted plots-note" },
          `The closest ${this.rows} of ${most} candidates; a path through others runs along the bottom.`,
        ),
      );
    this.now = svg("rect", {
      class: "plots-column",
      y: 0,
      width: CELL.width + 8,
      height: CELL.top + this.rows * (CELL.height + 4),
    });
  }

  x(q) {
    return 8 + q * (CELL.width + CELL.gap);
  }

  /** The top of a candidate's cell; those below the table share a place under it. */
  y(k) {
    return CELL.top + Math.min(k, this.rows) * (CELL.height + 4);
  }

  draw() {
    const { data } = this;
    const chosen = this.variant();
    const { choice } = data.variants[chosen];
    const height = this.y(this.rows) + CELL.height + 4;
    const picture = svg(
      "svg",
      { width: this.x(data.fragments.length), height, role: "img", "aria-label": this.describe(chosen) },
      this.now,
      ...this.links(choice, chosen),
      this.path(choice, chosen),
      ...data.fragments.flatMap((_, q) => this.column(q, choice[q], chosen)),
    );
    this.scroller.replaceChildren(picture);
    this.summary.textContent = this.describe(chosen);
    this.showFrame(this.player.frame);
  }

  describe(variant) {
    const { data } = this;
    const { name, continued } = data.variants[variant];
    return `${name}: ${continued.filter(Boolean).length} of ${continued.length} joins at no cost. The candidates could be linked at no cost in ${this.offered} places.`;
  }

  column(q, choice, variant) {
    const fragment = this.data.fragments[q];
    const head = svg(
      "text",
      { x: this.x(q) + CELL.width / 2, y: 14, "text-anchor": "middle", class: "plots-head" },
      String(q + 1),
    );
    const cells = fragment.take.slice(0, this.rows).map((_, k) => this.cell(q, k, k === choice, variant));
    return choice >= this.rows ? [head, ...cells, this.cell(q, choice, true, variant)] : [head, ...cells];
  }

  cell(q, k, chosen, variant) {
    const fragment = this.data.fragments[q];
    const take = fragment.take[k];
    const group = svg(
      "g",
      { class: chosen ? "plots-cell plots-chosen" : "plots-cell", onclick: () => this.pick(q) },
      svg("rect", { x: this.x(q), y: this.y(k), width: CELL.width, height: CELL.height, rx: 3, class: "plots-ground" }),
      svg("rect", { x: this.x(q), y: this.y(k), width: 8, height: CELL.height, rx: 2, fill: takeColour(take) }),
      svg("rect", {
        x: this.x(q),
        y: this.y(k),
        width: CELL.width,
        height: CELL.height,
        rx: 3,
        fill: "none",
        stroke: chosen ? variantColour(variant) : "var(--grid)",
        "stroke-width": chosen ? 2.5 : 1,
      }),
      svg(
        "text",
        { x: this.x(q) + 8 + (CELL.width - 8) / 2, y: this.y(k) + 14, "text-anchor": "middle" },
        `${take + 1}:${fragment.number[k]}`,
      ),
    );
    this.tip.attach(group, () => this.lines(q, k));
    return group;
  }

  lines(q, k) {
    const { data } = this;
    const fragment = data.fragments[q];
    const clip = data.takes[fragment.take[k]];
    const time = (frame) => short(clip.start + frame * clip.timeCodesPerFrame);
    return [
      `Fragment ${q + 1}, candidate ${k + 1}`,
      `${clip.name}, fragment ${fragment.number[k]} (${time(fragment.takeFirst[k])} to ${time(fragment.takeLast[k])})`,
      `distance ${short(fragment.distance[k])} · scale ${short(fragment.scale[k])}`,
    ];
  }

  /** A line between each two candidates that were consecutive in their take. */
  links(choice, variant) {
    const faint = this.offered > MANY_LINKS ? 0.3 : 1;
    return this.data.fragments.flatMap((fragment, q) => {
      const lines = [];
      for (let i = 0; i < fragment.joins.length; i += 2) {
        const [a, b] = [fragment.joins[i], fragment.joins[i + 1]];
        const used = choice[q] === a && choice[q + 1] === b;
        if (used || (a < this.rows && b < this.rows))
          lines.push(this.link(q, a, b, used ? variantColour(variant) : "var(--muted)", used ? 4 : 1.25, used ? 1 : faint));
      }
      return lines;
    });
  }

  link(q, a, b, stroke, width, opacity = 1) {
    return svg("line", {
      x1: this.x(q) + CELL.width,
      y1: this.y(a) + CELL.height / 2,
      x2: this.x(q + 1),
      y2: this.y(b) + CELL.height / 2,
      stroke,
      "stroke-width": width,
      opacity,
      "stroke-linecap": "round",
    });
  }

  /** The chosen path; dashed where it jumps. */
  path(choice, variant) {
    const group = svg("g", {});
    choice.slice(0, -1).forEach((a, q) => {
      const b = choice[q + 1];
      if (a < 0 || b < 0 || this.data.variants[variant].continued[q]) return;
      const line = this.link(q, a, b, variantColour(variant), 1.75);
      line.setAttribute("stroke-dasharray", "3 4");
      group.append(line);
    });
    return group;
  }

  pick(fragment) {
    this.player.setFrame(this.data.fragments[fragment].first);
    this.state.set({ fragment });
  }

  showFrame(frame) {
    const fragment = this.data.fragmentAt(frame);
    if (fragment === this.marked) return;
    this.marked = fragment;
    this.now.setAttribute("x", this.x(fragment) - 4);
  }
}

export const candidates = {
  id: "candidates",
  title: "Candidates and the path through them",
  figure: "figure 7",
  wide: true,
  height: 260,
  how: "A column per fragment of the sketch, the closest candidate on top, written take:fragment. Lines link fragments that were consecutive in their take, which joins at no cost; the framed path is the variant's.",
  make: (context) => new Candidates(context),
};
