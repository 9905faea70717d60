// The page: reads its data, puts the parts together, and keeps time.

import { byId, make, mountCopy } from "./dom.js";
import { mountKeyboard } from "./keyboard.js";
import { Labels, Layers } from "./layers.js";
import { Panel } from "./panel.js";
import { Player } from "./player.js";
import { mountPlots } from "./plots.js";
import { Stage } from "./stage.js";
import { mountTheme } from "./theme.js";
import { Transport } from "./transport.js";

const NARROW = 640;

const data = JSON.parse(byId("mtex-data").textContent);
const stage = new Stage(byId("canvas"));
let parts = null;

/** Show one of the characters. */
function show(index) {
  const character = data.characters[index];
  parts?.destroy();
  const player = new Player(character, character.variants.map((variant) => variant.name));
  const first = window.innerWidth <= NARROW ? character.variants.slice(0, 1) : character.variants;
  stage.show.names = new Set(["sketch", ...first.map((variant) => variant.name)]);
  stage.load(character);
  parts = assemble(character, player);
  for (const [i, tab] of [...byId("characters").children].entries()) tab.setAttribute("aria-pressed", String(i === index));
}

function assemble(character, player) {
  const panel = new Panel(character, player, stage);
  const transport = new Transport(player, character);
  const layers = new Layers(character, stage);
  const labels = new Labels(stage, player, panel);
  player.onFrame((frame) => stage.setFrame(frame));
  player.onVariant((chosen) => { panel.update(); stage.set({ chosen }); });
  stage.set({ chosen: player.variant });
  const keyboard = mountKeyboard({ player, panel, stage, transport, layers });
  const root = byId("plots");
  root.replaceChildren();
  const plots = mountPlots(root, character.plots, player);
  const destroy = () => [transport, keyboard, plots].forEach((part) => part?.destroy());
  return { player, panel, labels, destroy };
}

/** Frames drawn while playing, over the last two seconds. */
class Meter {
  constructor() { this.times = []; }

  add(time) {
    this.times.push(time);
    while (time - this.times[0] > 2000) this.times.shift();
  }

  get rate() {
    const { times } = this;
    return times.length > 1 ? ((times.length - 1) * 1000) / (times[times.length - 1] - times[0]) : 0;
  }
}

const meter = new Meter();
let previous = 0;

function tick(time) {
  const { player } = parts;
  const { frame } = player;
  player.tick(time);
  if (player.playing) {
    if (player.frame !== frame) meter.add(time);
    stage.relieve(time - previous);
  }
  previous = time;
  stage.controls.update();
  stage.draw();
  requestAnimationFrame(tick);
}

function mountTabs() {
  const names = data.characters.map(({ model, anim }) => [model.split("/").pop(), anim.split("/").pop()].join(" · "));
  const tabs = names.map((name, i) => {
    const tab = make("button", { type: "button", textContent: name });
    tab.addEventListener("click", () => show(i));
    return tab;
  });
  byId("characters").replaceChildren(...tabs);
  byId("characters").hidden = tabs.length < 2;
}

byId("title").textContent = data.title;
byId("command").textContent = data.command;
mountCopy(byId("copy-command"), byId("command"));
mountCopy(byId("copy-recipe"), byId("recipe"));
mountTheme(byId("theme"));
byId("help").addEventListener("click", () => byId("shortcuts").showModal());
mountTabs();
show(0);
stage.onDrawn(() => parts.labels.update());
requestAnimationFrame(tick);

/** For pipelines and tests: the page's own view of what it shows. */
window.mtexReview = {
  get player() { return parts.player; },
  setFrame: (frame) => parts.player.setFrame(frame),
  setVariant: (name) => parts.panel.choose(name),
  setLayout: (layout) => byId("layout").querySelector(`[data-name=${layout}]`).click(),
  show,
  /** Joint positions at a frame as they are in the buffers that are drawn, skeleton space; NaN for joints not drawn. */
  jointPositions(name, frame) {
    parts.player.setFrame(frame);
    const figure = stage.figure(name);
    figure.setFrame(parts.player.frame, stage.showFor(figure));
    return figure.bones.drawnPositions();
  },
  figures: () => stage.shown.map((figure) => ({
    name: figure.name, position: figure.group.position.toArray(), ...stage.project(figure), contacts: figure.held,
  })),
  get measuredRate() { return meter.rate; },
  get pixelRatio() { return stage.ratio; },
};
