// The pyramid of a channel (figure 3).

import { TimeChart } from "./plots_chart.js";
import { SKETCH_DASH, el, variantColour } from "./plots_dom.js";
import { ChannelPicker, channelName } from "./plots_pickers.js";
import { decompose } from "./plots_pyramid.js";

const ROW = 66;

/** What the method does with one band of a channel. */
function useOf(channel, number) {
  const uses = [];
  if (channel.matchBand === number) uses.push("matched on");
  if (channel.textureBands && number >= channel.textureBands[0] && number <= channel.textureBands[1])
    uses.push("taken from the takes");
  if (channel.synthesisBand !== null) uses.push(number < channel.synthesisBand ? "left out" : "taken from the takes");
  return uses;
}

class Bands {
  constructor(context) {
    Object.assign(this, context);
    this.picker = new ChannelPicker(this.controls, context, {
      key: "keyed",
      title: "Channel",
      columns: this.data.curves.columns,
    });
    this.keys = el("div", { class: "plots-legend" });
    this.body.append(this.keys);
    this.numbers = this.data.curves.bands.map((band) => band.number);
    this.rows = [...this.numbers, null].map((number) => this.row(number));
  }

  row(number) {
    const title = el("div", { class: "plots-band" });
    const host = el("div", { class: "plots-bandrow" }, title);
    this.body.append(host);
    const last = number === null;
    return {
      number,
      title,
      chart: new TimeChart(host, this, { height: last ? ROW + 22 : ROW, label: "", bare: !last, legend: false }),
    };
  }

  draw() {
    const { data, state } = this;
    this.picker.show();
    const channel = data.channels[state.keyed];
    const split = this.lines().map((line) => ({ ...line, ...decompose(line.curve, this.numbers.length) }));
    this.rows.forEach(({ number, title, chart }, i) => {
      const uses = number === null ? [] : useOf(channel, number);
      const hz = number === null ? "what is slower" : `${data.curves.bands[i].hz.toPrecision(2)} Hz`;
      title.replaceChildren(
        el("strong", {}, number === null ? "Rest" : `Band ${number}`),
        el("span", { class: "muted" }, hz),
        ...uses.map((use) => el("span", { class: "plots-use" }, use)),
      );
      title.parentElement.classList.toggle("plots-matched", uses.includes("matched on"));
      const lines = split.map((line) => ({ ...line, values: number === null ? line.residual : line.bands[i] }));
      chart.draw({
        times: data.times,
        lines,
        unit: channel.unit,
        label: `${channelName(data, state.keyed)}, ${number === null ? "below the last band" : `band ${number}`}.`,
      });
    });
    this.showKeys(split);
  }

  lines() {
    const { data, state } = this;
    const variant = this.variant();
    const own = { name: "sketch", curve: data.sketch(state.keyed), stroke: "var(--sketch)", width: 1.75, dash: SKETCH_DASH };
    const path = { name: "captured path", curve: data.joining("joined", state.keyed, variant), stroke: "var(--fg)", width: 1 };
    const result = {
      name: data.variants[variant].name,
      curve: data.finished(state.keyed, variant),
      stroke: variantColour(variant),
      width: 1.75,
    };
    return [own, path, result].filter((line) => line.curve);
  }

  showKeys(lines) {
    this.keys.replaceChildren(
      ...lines.map((line) =>
        el(
          "span",
          { class: "plots-key" },
          el("span", {
            class: "plots-rule",
            style: `border-top:${line.width + 0.5}px ${line.dash ? "dashed" : "solid"} ${line.stroke}`,
          }),
          line.name,
        ),
      ),
    );
  }

  showFrame(frame) {
    this.rows.forEach(({ chart }) => chart.showFrame(frame));
  }

  destroy() {
    this.rows.forEach(({ chart }) => chart.destroy());
  }
}

export const bands = {
  id: "bands",
  title: "Frequency bands",
  figure: "figure 3",
  wide: true,
  height: 700,
  how: "The channel split by frequency, fastest first; the bands of a row add up to its curve. A keyed curve is empty in the fast bands, which is where texture comes from the takes.",
  make: (context) => new Bands(context),
};
