// Fragments and what was found for them (figures 4, 5 and 6).

import { TimeChart, drawBreaks } from "./plots_chart.js";
import { stretch, unpackRow } from "./plots_data.js";
import { el, short, takeColour, variantColour } from "./plots_dom.js";
import { FragmentChart } from "./plots_fragment.js";
import { ChannelPicker, StepPicker, channelName, segmented } from "./plots_pickers.js";
import { TakeChart } from "./plots_take.js";

const SHOWN = 5;

/** A curve about its mean over a fragment, for channels compared by their course alone. */
function centre(curve) {
  const mean = curve.reduce((sum, value) => sum + value, 0) / curve.length;
  return curve.map((value) => value - mean);
}

class Matches {
  constructor(context) {
    Object.assign(this, context, { stretched: true });
    const { data, controls, state } = this;
    this.fragments = new StepPicker(controls, {
      title: "Fragment",
      previous: "Fragment before",
      next: "Next fragment",
      onPick: (fragment) => this.pick(fragment),
    });
    this.fragments.show(
      data.fragments.map(({ first, last }, q) => ({
        value: q,
        text: `${q + 1}: ${short(data.timeOf(first))} to ${short(data.timeOf(last))}`,
      })),
      state.fragment,
    );
    this.channel = el("select", {
      "aria-label": "Match channel",
      onchange: () => state.set({ match: Number(this.channel.value) }),
    });
    const most = Math.max(...data.fragments.map((fragment) => fragment.take.length));
    this.shown = Math.min(SHOWN, most);
    this.count = el("input", {
      type: "number",
      min: 1,
      max: most,
      value: this.shown,
      "aria-label": "Candidates shown",
      onchange: () => this.setCount(most),
    });
    controls.append(
      el("div", { class: "plots-field" }, el("label", {}, "Match channel ", this.channel)),
      el("div", { class: "plots-field" }, el("label", {}, "Closest ", this.count, ` of ${most}`)),
    );
    this.make();
  }

  make() {
    const part = (title) => {
      const host = el("div", {}, el("h4", {}, title));
      return host;
    };
    const series = part(
      "The band that is matched, cut where its break channel turns, with the closest fragments of the takes laid on each",
    );
    this.series = new TimeChart(series, this, {
      height: 220,
      label: "",
      onPick: (time) => this.state.set({ fragment: this.data.fragmentAt(this.data.frameOf(time)) }),
    });
    const one = part("The chosen fragment and its candidates");
    segmented(
      one,
      "Length of candidates",
      [
        ["stretched", "stretched"],
        ["recorded", "as recorded"],
      ],
      "stretched",
      (way) => {
        this.stretched = way === "stretched";
        this.draw();
      },
    );
    this.one = new FragmentChart(one, this);
    this.list = el("div", { class: "plots-list", tabindex: "0", role: "region", "aria-label": "Candidates of the fragment" });
    const take = part("A take, cut in the same way; thick is what the chosen variant uses of it");
    this.takes = el("select", {
      "aria-label": "Take",
      onchange: () => {
        this.chosenTake = Number(this.takes.value);
        this.drawTake();
      },
    });
    take.append(el("div", { class: "plots-field" }, this.takes));
    this.take = new TakeChart(take);
    const copied = part("What comes with them: a copied channel at the same places of the takes, and the chosen path");
    this.picker = new ChannelPicker(copied, this, { key: "column", title: "Copied channel", columns: this.copiedColumns() });
    this.copied = new TimeChart(copied, this, {
      height: 200,
      label: "",
      onPick: (time) => this.state.set({ fragment: this.data.fragmentAt(this.data.frameOf(time)) }),
    });
    this.body.append(series, el("div", { class: "plots-pair" }, one, this.list), take, copied);
  }

  copiedColumns() {
    return this.data.curves.columns;
  }

  setCount(most) {
    this.shown = Math.min(most, Math.max(1, Math.round(Number(this.count.value)) || 1));
    this.count.value = this.shown;
    this.draw();
  }

  pick(fragment) {
    this.player.setFrame(this.data.fragments[fragment].first);
    this.state.set({ fragment });
  }

  get fragment() {
    return this.data.fragments[this.state.fragment];
  }

  get way() {
    return this.data.ways[this.fragment.way];
  }

  draw() {
    const { state } = this;
    this.fragments.show(
      this.data.fragments.map(({ first, last }, q) => ({
        value: q,
        text: `${q + 1}: ${short(this.data.timeOf(first))} to ${short(this.data.timeOf(last))}`,
      })),
      state.fragment,
    );
    this.channel.replaceChildren(...this.way.labels.map((label, i) => el("option", { value: i }, label)));
    this.match = Math.min(state.match, this.way.labels.length - 1);
    this.channel.value = String(this.match);
    this.drawSeries();
    this.drawOne();
    this.drawList();
    this.drawTake();
    this.drawCopied();
  }

  /** One candidate's compared curve; null where it is not in the page. */
  curveOf(q, k, frames = null) {
    const fragment = this.data.fragments[q];
    const take = this.data.matchCurve(
      fragment.way,
      Math.min(this.match, this.data.ways[fragment.way].labels.length - 1),
      fragment.take[k],
    );
    if (!take) return null;
    return stretch(
      take,
      fragment.takeFirst[k],
      fragment.takeLast[k],
      frames ?? Math.round(fragment.takeLast[k] - fragment.takeFirst[k]) + 1,
    );
  }

  place(curve) {
    return curve && this.way.centred[this.match] ? centre(curve) : curve;
  }

  drawSeries() {
    const { data, state, way, match } = this;
    const own = unpackRow(way.sketch, match);
    const chosen = this.variant();
    const same = (q) => data.fragments[q].way === this.fragment.way;
    const candidate = (rank) =>
      data.withGaps((first, last, q) =>
        same(q) && rank < data.fragments[q].take.length ? this.place(this.curveOf(q, rank, last - first + 1)) : null,
      );
    const taken = data.withGaps((first, last, q) =>
      same(q) && data.variants[chosen].choice[q] >= 0
        ? this.place(this.curveOf(q, data.variants[chosen].choice[q], last - first + 1))
        : null,
    );
    const ranks = Array.from({ length: this.shown }, (_, rank) => rank);
    this.series.draw({
      times: data.gapped,
      unit: way.units[match],
      lines: [
        ...ranks.map((rank) => ({
          name: rank ? "" : `closest ${this.shown}`,
          values: candidate(rank),
          stroke: "var(--fg)",
          width: 0.8,
          alpha: 0.6,
        })),
        {
          name: "sketch",
          values: data.withGaps((first, last) => this.place(own.slice(first, last + 1))),
          stroke: "var(--sketch)",
          width: 3,
        },
        { name: data.variants[chosen].name, values: taken, stroke: variantColour(chosen), width: 2 },
      ],
      label: `${way.labels[match]}, band ${way.band}${way.lower ? " and slower" : ""}, of the sketch in ${data.fragments.length} fragments with the closest ${this.shown} fragments of the takes on each.`,
      marks: drawBreaks(data, state.fragment),
    });
  }

  drawOne() {
    const { data, state, way, match, fragment } = this;
    const frames = fragment.last - fragment.first + 1;
    const choice = data.variants[this.variant()].choice[state.fragment];
    const curves = fragment.take
      .map((_, k) => ({ k, values: this.place(this.curveOf(state.fragment, k, this.stretched ? frames : null)) }))
      .filter(({ k, values }) => values && (k < this.shown || k === choice));
    const own = this.place(unpackRow(way.sketch, match).slice(fragment.first, fragment.last + 1));
    this.one.draw({
      own,
      curves,
      choice,
      unit: way.units[match],
      variant: this.variant(),
      label: `${way.labels[match]} of fragment ${state.fragment + 1}, and ${curves.length} candidates, ${this.stretched ? "stretched to its length" : "as recorded"}.`,
    });
  }

  drawList() {
    const { data, state, fragment } = this;
    const chosen = data.variants.map((variant) => variant.choice[state.fragment]);
    const rows = fragment.take.map((take, k) => {
      const clip = data.takes[take];
      const time = (frame) => short(clip.start + frame * clip.timeCodesPerFrame);
      const users = chosen.flatMap((choice, i) =>
        choice === k
          ? [el("span", { class: "plots-dot", style: `background:${variantColour(i)}`, title: data.variants[i].name })]
          : [],
      );
      return el(
        "tr",
        {
          class: chosen[this.variant()] === k ? "selected" : null,
          onpointerenter: () => this.one.highlight(k),
          onpointerleave: () => this.one.highlight(null),
        },
        el("td", {}, String(k + 1)),
        el(
          "td",
          { class: "name" },
          el("span", { class: "plots-dot", style: `background:${takeColour(take)}` }),
          `${clip.label}:${fragment.number[k]}`,
        ),
        el("td", {}, `${time(fragment.takeFirst[k])}–${time(fragment.takeLast[k])}`),
        el("td", {}, short(fragment.distance[k])),
        el("td", {}, short(fragment.scale[k])),
        el("td", {}, ...users),
      );
    });
    const head = ["", "take:fragment", "time codes", "distance", "scale", "used by"].map((name, i) =>
      el("th", { class: i === 1 ? "name" : null }, name),
    );
    this.list.replaceChildren(
      el("table", { class: "table" }, el("thead", {}, el("tr", {}, ...head)), el("tbody", {}, ...rows)),
    );
  }

  /** The take that was chosen, else the one the chosen variant uses in the chosen fragment. */
  drawTake() {
    const { data, state, way, match } = this;
    const variant = this.variant();
    const uses = data.variants[variant].fragments;
    const known = data.takes.map((_, i) => i).filter((i) => way.starts[i] >= 0);
    const take = known.includes(this.chosenTake) ? this.chosenTake : uses[state.fragment].take;
    this.takes.replaceChildren(...known.map((i) => el("option", { value: i }, data.takes[i].label)));
    this.takes.value = String(take);
    const begin = way.starts[take];
    const clip = data.takes[take];
    const inside = way.fragments.filter((frame) => frame >= begin && frame < begin + clip.frameCount);
    const used = uses.filter((use) => use.take === take).map((use) => [use.takeFirst, use.takeLast]);
    this.take.draw({
      clip,
      curve: data.matchCurve(this.fragment.way, match, take),
      breaks: [...new Set(inside)].map((frame) => frame - begin),
      used,
      unit: way.units[match],
      variant,
      label: `${way.labels[match]} of ${clip.name}, cut into ${inside.length / 2} fragments; ${data.variants[variant].name} uses ${used.length}.`,
      at: () => this.readFrom(take),
    });
  }

  /** The frame of a take that the chosen variant is made of at the player's frame. */
  readFrom(take) {
    const q = this.data.fragmentAt(this.player.frame);
    const use = this.data.variants[this.variant()].fragments[q];
    if (use.take !== take) return null;
    const { first, last } = this.data.fragments[q];
    return use.takeFirst + ((use.takeLast - use.takeFirst) * (this.player.frame - first)) / (last - first);
  }

  drawCopied() {
    const { data, state } = this;
    this.picker.show();
    const chosen = this.variant();
    const path = data.capturedWithGaps(state.column, chosen);
    const offset = data.channels[state.column].form === "offset";
    const captured = offset && data.joining("captured", state.column, chosen);
    const candidate = (rank) =>
      data.withGaps((first, last, q) => this.copiedCurve(q, rank, last - first + 1, captured ? captured[first + q] : null));
    const ranks = data.curves.takes.columns.includes(state.column) ? Array.from({ length: this.shown }, (_, rank) => rank) : [];
    const lines = ranks.map((rank) => ({
      name: rank ? "" : `closest ${this.shown}`,
      values: candidate(rank),
      stroke: "var(--fg)",
      width: 0.8,
      alpha: 0.6,
    }));
    if (path)
      lines.push({ name: `path of ${data.variants[chosen].name}`, values: path, stroke: variantColour(chosen), width: 2.5 });
    this.copied.draw({
      times: data.gapped,
      lines,
      unit: data.channels[state.column].unit,
      marks: drawBreaks(data, state.fragment),
      label: `${channelName(data, state.column)} at the places of the takes that were matched, and the path of ${data.variants[chosen].name}.`,
    });
  }

  /** A candidate's copied channel; root travel and other offsets are laid where the chosen path begins. */
  copiedCurve(q, rank, frames, begin) {
    const fragment = this.data.fragments[q];
    if (rank >= fragment.take.length) return null;
    const curve = stretch(
      this.data.takeCurve(this.state.column, fragment.take[rank]),
      fragment.takeFirst[rank],
      fragment.takeLast[rank],
      frames,
    );
    return begin === null ? curve : curve.map((value) => value - curve[0] + begin);
  }

  showFrame(frame) {
    this.series.showFrame(frame);
    this.take.showFrame();
    this.copied.showFrame(frame);
  }

  destroy() {
    [this.series, this.one, this.take, this.copied].forEach((chart) => chart.destroy());
  }
}

export const matches = {
  id: "matches",
  title: "Fragments and their matches",
  figure: "figures 4, 5, 6",
  wide: true,
  height: 1040,
  how: "The sketch's band (thick) is cut where its direction changes; each piece is compared with every piece of the takes, stretched to its length, and the closest are kept. A click chooses a fragment.",
  make: (context) => new Matches(context),
};
