// When which point is held, in every variant.

import { el, onWidth, short, svg, variantColour } from "./plots_dom.js";

const LABEL = 104;
const BAR = 7;

class Contacts {
  constructor(context) {
    Object.assign(this, context);
    const { data } = this;
    this.points = [...new Set(data.variants.flatMap((variant) => variant.contacts.map((contact) => contact.point)))];
    this.now = el("div", { class: "plots-now" });
    this.area = el("div", { class: "plots-area", style: `left:${LABEL}px` }, this.now);
    this.rows = el("div", {});
    this.box = el("div", { class: "plots-stack" }, this.rows, this.area);
    this.body.append(this.box);
    this.stop = onWidth(this.box, (width) => {
      this.width = width;
      this.draw();
    });
  }

  x(frame) {
    return (frame / Math.max(this.data.frameCount - 1, 1)) * (this.width - LABEL);
  }

  draw() {
    if (!this.width) return;
    this.rows.replaceChildren(...this.points.map((point) => this.row(point)));
    this.showFrame(this.player.frame);
  }

  row(point) {
    const { data } = this;
    const height = data.variants.length * (BAR + 2) + 8;
    const chosen = this.variant();
    const bars = data.variants.flatMap((variant, i) =>
      variant.contacts
        .filter((contact) => contact.point === point)
        .map((contact) => {
          const bar = svg("rect", {
            x: this.x(contact.first),
            y: 4 + i * (BAR + 2),
            width: Math.max(2, this.x(contact.last) - this.x(contact.first)),
            height: BAR,
            rx: 2,
            fill: variantColour(i),
            opacity: i === chosen ? 1 : 0.45,
          });
          this.tip.attach(bar, () => [
            `${contact.name}, ${variant.name}`,
            `held from ${short(data.timeOf(contact.first))} to ${short(data.timeOf(contact.last))}`,
          ]);
          return bar;
        }),
    );
    const picture = svg(
      "svg",
      {
        width: this.width - LABEL,
        height,
        role: "img",
        class: "plots-strip",
        onclick: (event) => this.seek(event),
        "aria-label": `${point}: held ${data.variants[chosen].contacts.filter((contact) => contact.point === point).length} times in ${data.variants[chosen].name}.`,
      },
      svg("rect", { x: 0, y: 1, width: this.width - LABEL, height: height - 2, class: "plots-track" }),
      ...bars,
    );
    return el(
      "div",
      { class: "plots-row" },
      el("span", { class: "plots-point", style: `width:${LABEL - 8}px` }, point),
      picture,
    );
  }

  seek(event) {
    const box = event.currentTarget.getBoundingClientRect();
    this.player.setFrame(Math.round(((event.clientX - box.left) / box.width) * (this.data.frameCount - 1)));
  }

  showFrame(frame) {
    if (this.width) this.now.style.transform = `translateX(${this.x(frame).toFixed(1)}px)`;
  }

  destroy() {
    this.stop();
  }
}

export const contacts = {
  id: "contacts",
  title: "Contacts",
  wide: false,
  height: 200,
  how: "A bar is a time in which a point of the body is held, one line per variant in its colour; the chosen one is in full colour.",
  wanted: (data) => data.variants.some((variant) => variant.contacts.length > 0),
  make: (context) => new Contacts(context),
};
