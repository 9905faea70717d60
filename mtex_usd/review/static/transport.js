// Play, step, scrub, speed and loop.

import { byId, make, say } from "./dom.js";
import { SPEEDS } from "./player.js";
import { readColour } from "./theme.js";

function button(text, label, action) {
  const element = make("button", { type: "button", textContent: text, "aria-label": label, title: label });
  element.addEventListener("click", action);
  return element;
}

export class Transport {
  constructor(player, character) {
    this.player = player;
    this.character = character;
    this.scrub = byId("scrub");
    this.strip = byId("strip");
    this.scrub.max = player.frameCount - 1;
    this.scrub.value = player.frame;
    this.scrub.oninput = () => player.setFrame(Number(this.scrub.value));
    this.strip.title = "Drag to loop, click to go there";
    this.strip.onpointerdown = (event) => this.dragLoop(event);
    this.build();
    this.unsubscribe = [player.onFrame(() => this.showFrame()), player.onState(() => this.showState()), player.onVariant(() => this.drawStrip())];
    this.observer = new ResizeObserver(() => this.drawStrip());
    this.observer.observe(this.strip);
    this.redraw = () => this.drawStrip();
    window.addEventListener("mtex:theme", this.redraw);
    this.showFrame();
    this.showState();
  }

  build() {
    const { player } = this;
    this.playButton = button("Play", "Play or pause (space)", () => player.toggle());
    this.playButton.classList.add("wide");
    this.time = make("output", { className: "time" });
    this.code = make("input", { type: "number", step: "any", "aria-label": "Time code" });
    this.code.addEventListener("change", () => player.setFrame((Number(this.code.value) - player.start) / player.timeCodesPerFrame));
    this.speed = make("select", { "aria-label": "Speed" }, ...SPEEDS.map((speed) => make("option", { value: speed, textContent: `${speed}×` })));
    this.speed.addEventListener("change", () => player.setSpeed(Number(this.speed.value)));
    this.clear = button("All", "Play all (x)", () => player.setLoop(0, player.frameCount - 1));
    byId("transport").replaceChildren(
      button("|◀", "To the start (home)", () => player.step(-player.frameCount)), button("‹", "One frame back (left arrow)", () => player.step(-1)),
      this.playButton, button("›", "One frame on (right arrow)", () => player.step(1)),
      make("label", {}, "tc ", this.code), this.time, make("label", {}, make("span", { className: "word", textContent: "Speed" }), this.speed),
      button("In", "Loop from this frame (i)", () => this.setIn()), button("Out", "Loop to this frame (o)", () => this.setOut()), this.clear,
    );
  }

  setIn() { this.player.setLoop(this.player.frame, Math.max(this.player.frame, this.player.loop[1])); }

  setOut() { this.player.setLoop(Math.min(this.player.frame, this.player.loop[0]), this.player.frame); }

  showFrame() {
    const { player } = this;
    this.scrub.value = player.frame;
    this.scrub.setAttribute("aria-valuetext", `time code ${player.timeCode()}`);
    if (document.activeElement !== this.code) this.code.value = Number(player.timeCode().toFixed(3));
    this.time.textContent = `${player.frame + 1}/${player.frameCount} · ${(player.frame / player.rate).toFixed(2)} s`;
  }

  showState() {
    const { player } = this;
    this.playButton.textContent = player.playing ? "Pause" : "Play";
    this.playButton.setAttribute("aria-pressed", player.playing);
    this.speed.value = player.speed;
    this.clear.disabled = !player.looping;
    this.drawStrip();
  }

  faster(direction) {
    const at = SPEEDS.indexOf(this.player.speed);
    this.player.setSpeed(SPEEDS[Math.min(SPEEDS.length - 1, Math.max(0, at + direction))]);
    say(`Speed ${this.player.speed}`);
  }

  frameAt(event) {
    const box = this.strip.getBoundingClientRect();
    return ((event.clientX - box.left - this.inset) / (box.width - 2 * this.inset)) * (this.player.frameCount - 1);
  }

  /** Drag over the strip for a loop; click to go there. */
  dragLoop(event) {
    const first = this.frameAt(event);
    this.strip.setPointerCapture(event.pointerId);
    this.strip.onpointermove = (moved) => {
      if (Math.abs(moved.clientX - event.clientX) > 4) this.player.setLoop(first, this.frameAt(moved));
    };
    this.strip.onpointerup = (ended) => {
      if (Math.abs(ended.clientX - event.clientX) <= 4) this.player.setFrame(first);
      this.strip.onpointermove = null;
    };
  }

  get inset() { return 8; } // half of the slider's knob, so that both scales agree

  /** Fragments of the sketch as ticks, contacts of the chosen variant as bars, and the loop. */
  drawStrip() {
    const { strip, player } = this;
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    const { clientWidth: width, clientHeight: height } = strip;
    if (!width) return;
    strip.width = width * ratio;
    strip.height = height * ratio;
    const pen = strip.getContext("2d");
    pen.scale(ratio, ratio);
    const at = (frame) => this.inset + (frame / Math.max(1, player.frameCount - 1)) * (width - 2 * this.inset);
    this.drawLoop(pen, at, height);
    pen.fillStyle = css("--muted");
    for (const frame of this.character.breaks) pen.fillRect(at(frame) - 0.5, height - 7, 1, 7);
    this.drawContacts(pen, at);
  }

  drawLoop(pen, at, height) {
    const [first, last] = this.player.loop;
    pen.fillStyle = css("--grid");
    pen.fillRect(at(0), height - 3, at(this.player.frameCount - 1) - at(0), 2);
    if (!this.player.looping) return;
    pen.globalAlpha = 0.25;
    pen.fillStyle = css("--accent");
    pen.fillRect(at(first), 0, Math.max(2, at(last) - at(first)), height);
    pen.globalAlpha = 1;
    pen.fillRect(at(first) - 1, 0, 2, height);
    pen.fillRect(at(last) - 1, 0, 2, height);
  }

  drawContacts(pen, at) {
    const variant = this.character.variants.find((each) => each.name === this.player.variant);
    const points = [...new Set((variant?.contacts ?? []).map((each) => each.name.replace(/ \d+$/, "")))];
    pen.fillStyle = css("--contact");
    for (const { name, first, last } of variant?.contacts ?? []) {
      const row = points.indexOf(name.replace(/ \d+$/, "")) % 4;
      pen.fillRect(at(first), 1 + row * 3.5, Math.max(1, at(last) - at(first)), 2.5);
    }
  }

  destroy() {
    for (const off of this.unsubscribe) off();
    this.observer.disconnect();
    window.removeEventListener("mtex:theme", this.redraw);
  }
}

function css(property) { return `rgb(${readColour(property).map((value) => Math.round(value * 255)).join()})`; }
