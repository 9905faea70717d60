// One small box that says what is under the pointer or has the focus.

import { el } from "./plots_dom.js";

export class Tip {
  constructor(root) {
    this.node = el("div", { class: "plots-tip", role: "status", hidden: true });
    root.append(this.node);
  }

  /** @param {string[]} lines the first is set off */
  show(lines, x, y) {
    this.node.replaceChildren(...lines.map((line, i) => el(i ? "div" : "strong", {}, line)));
    this.node.hidden = false;
    const { width, height } = this.node.getBoundingClientRect();
    const left = Math.min(Math.max(8, x + 14), document.documentElement.clientWidth - width - 8);
    const below = y + 18 + height < window.innerHeight;
    this.node.style.transform = `translate(${left}px, ${below ? y + 18 : Math.max(8, y - height - 12)}px)`;
  }

  hide() {
    this.node.hidden = true;
  }

  /** Show for a node, on pointing at it and on focus; `linesOf` is asked each time. */
  attach(node, linesOf) {
    node.addEventListener("pointermove", (event) => this.show(linesOf(event), event.clientX, event.clientY));
    node.addEventListener("pointerleave", () => this.hide());
  }
}
