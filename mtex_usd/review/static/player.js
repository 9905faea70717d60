// The state of playback, which everything on the page listens to. It knows nothing of how things are drawn.

export const SPEEDS = [0.1, 0.25, 0.5, 1, 1.5, 2];

function addListener(list, callback) {
  list.add(callback);
  return () => list.delete(callback);
}

export class Player {
  /**
   * @param {{frameCount: number, rate: number, start: number, timeCodesPerFrame: number}} clock
   * @param {string[]} variantNames best first
   */
  constructor(clock, variantNames) {
    Object.assign(this, clock);
    this.variantNames = variantNames;
    this.variant = variantNames[0] ?? "sketch";
    this.frame = 0;
    this.playing = false;
    this.speed = 1;
    this.loop = [0, this.frameCount - 1];
    this.listeners = { frame: new Set(), variant: new Set(), state: new Set() };
    this.origin = { time: 0, frame: 0 };
  }

  onFrame(callback) { return addListener(this.listeners.frame, callback); }

  onVariant(callback) { return addListener(this.listeners.variant, callback); }

  onState(callback) { return addListener(this.listeners.state, callback); }

  emit(kind, value) { for (const callback of this.listeners[kind]) callback(value); }

  get looping() { return this.loop[0] > 0 || this.loop[1] < this.frameCount - 1; }

  timeCode(frame = this.frame) { return this.start + frame * this.timeCodesPerFrame; }

  /** Go to a frame; playing goes on from there. */
  setFrame(frame) {
    this.show(frame);
    this.restart();
  }

  show(frame) {
    const whole = Math.min(this.frameCount - 1, Math.max(0, Math.round(frame)));
    if (whole === this.frame) return;
    this.frame = whole;
    this.emit("frame", whole);
  }

  setVariant(name) {
    if (name === this.variant || !this.variantNames.includes(name)) return;
    this.variant = name;
    this.emit("variant", name);
  }

  setSpeed(speed) {
    this.speed = speed;
    this.restart();
    this.emit("state");
  }

  /** Play only from one frame to another, both included. */
  setLoop(first, last) {
    const whole = (frame) => Math.min(this.frameCount - 1, Math.max(0, Math.round(frame)));
    this.loop = first <= last ? [whole(first), whole(last)] : [whole(last), whole(first)];
    this.restart();
    this.emit("state");
  }

  play() {
    if (this.playing) return;
    this.playing = true;
    if (this.frame < this.loop[0] || this.frame >= this.loop[1]) this.show(this.loop[0]);
    this.restart();
    this.emit("state");
  }

  pause() {
    if (!this.playing) return;
    this.playing = false;
    this.emit("state");
  }

  toggle() { if (this.playing) this.pause(); else this.play(); }

  step(frames) {
    this.pause();
    this.setFrame(this.frame + frames);
  }

  restart(time = performance.now()) { this.origin = { time, frame: this.frame }; }

  /** Move on to the frame that is due at a time in milliseconds; whole frames, as they will be rendered. */
  tick(time) {
    if (!this.playing) return;
    const [first, last] = this.loop;
    const due = this.origin.frame + Math.floor(((time - this.origin.time) / 1000) * this.rate * this.speed);
    if (due <= last) {
      this.show(Math.max(due, this.origin.frame));
    } else {
      this.show(first + ((due - first) % (last - first + 1)));
      this.restart(time);
    }
  }
}
