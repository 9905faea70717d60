// The stage: camera, floor and figures. Drawn only when something changed.

import {
  BufferAttribute, BufferGeometry, DoubleSide, Mesh, MeshBasicMaterial, OrbitControls, PerspectiveCamera, Scene, Vector3,
  WebGLRenderer,
} from "three";
import { setShadowColour } from "./bones.js";
import { Figure, setContactColour, stageMatrix } from "./figure.js";
import { RESOLUTION } from "./streamers.js";
import { readColour, variantProperty } from "./theme.js";
import { unpackPlaces } from "./packing.js";

const FIELD_OF_VIEW = 28;
const LANE = 0.95; // from one figure to the next, in heights
const GRID_CELLS = 7; // either way
const LINE_WIDTH = 0.01;
const FOLLOW_S = 0.6;
const SLOW_MS = 45; // a drawing that takes longer than this, several times in a row, is drawn with fewer pixels

/** Where the camera stands: turn about up from the front, and rise, in degrees. */
export const CAMERAS = {
  "3/4": { turn: 38, rise: 14 }, Front: { turn: 0, rise: 6 }, Side: { turn: 90, rise: 6 }, Top: { turn: 0, rise: 84 },
};

export class Stage {
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new WebGLRenderer({ canvas, antialias: true, powerPreference: "high-performance" });
    this.ratio = Math.min(window.devicePixelRatio || 1, 2);
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(FIELD_OF_VIEW, 1, 0.05, 400);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.invalidate());
    this.controls.maxPolarAngle = Math.PI * 0.55;
    this.controls.zoomToCursor = true;
    this.figures = [];
    this.show = {
      layout: "lanes", names: new Set(), shadows: true, trails: true, trailSeconds: 1, before: true, strobes: false,
      contacts: true, follow: true, chosen: "",
    };
    this.view = "3/4";
    this.frame = 0;
    this.followed = new Vector3();
    this.slow = 0;
    this.drawn = 0;
    this.drawnListeners = new Set();
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    window.addEventListener("mtex:theme", () => this.setColours());
  }

  /** Put a character's sketch and variants on the stage. */
  load(character) {
    for (const figure of this.figures) {
      this.scene.remove(figure.group);
      figure.dispose();
    }
    this.character = character;
    const motions = [{ name: "sketch", ...character.sketch }, ...character.variants];
    const unpacked = motions.map((motion) => ({ ...motion, places: unpackPlaces(motion.places) }));
    const matrix = stageMatrix(character.body, unpacked[0].places);
    this.figures = unpacked.map((motion) => new Figure(motion.name, character, motion, matrix));
    for (const figure of this.figures.slice(1)) figure.addBefore(this.figures[0].streamers);
    for (const figure of this.figures) this.scene.add(figure.group);
    this.way = smoothWay(this.figures[0], character);
    this.makeFloor();
    this.setColours();
    this.frame = 0;
    this.lookFrom(this.view);
  }

  makeFloor() {
    if (this.floor) {
      this.scene.remove(this.floor);
      this.floor.geometry.dispose();
    }
    const meters = this.character.body.height * this.character.body.metersPerUnit;
    this.inMeters = meters > 0.2 && meters < 20;
    this.cell = this.inMeters ? 1 / meters : 1;
    this.floor = new Mesh(gridGeometry(this.cell), new MeshBasicMaterial({ depthWrite: false, depthTest: false, side: DoubleSide }));
    this.floor.renderOrder = -3;
    this.scene.add(this.floor);
  }

  setColours() {
    this.renderer.setClearColor(`rgb(${readColour("--stage").map((value) => Math.round(value * 255)).join()})`);
    if (this.floor) this.floor.material.color.setRGB(...readColour("--stage-line"), "srgb");
    setShadowColour(readColour("--shadow"));
    setContactColour(readColour("--contact"));
    this.figures.forEach((figure, i) => figure.setColour(readColour(variantProperty(i - 1))));
    this.invalidate();
  }

  get shown() { return this.figures.filter((figure) => this.show.names.has(figure.name)); }

  /** Change what is drawn, and how. */
  set(change) {
    const moved = "layout" in change || "names" in change || "follow" in change;
    Object.assign(this.show, change);
    if (moved && this.character) this.lookFrom(this.view);
    this.setFrame(this.frame);
  }

  setFrame(frame) {
    this.frame = frame;
    for (const figure of this.figures) {
      figure.group.visible = this.show.names.has(figure.name);
      figure.bones.setThickness(this.thickness(figure));
      figure.trail.renderOrder = figure.name === this.show.chosen ? 4 : 2;
      if (figure.group.visible) figure.setFrame(frame, this.showFor(figure));
    }
    this.follow();
    this.invalidate();
  }

  /** Where figures overlap the chosen one is on the outside. */
  thickness(figure) {
    if (this.show.layout === "lanes") return 1;
    if (figure.name === this.show.chosen) return 1.1;
    return figure.name === "sketch" ? 0.6 : 0.8;
  }

  showFor(figure) {
    const beside = this.show.layout === "lanes" || !this.show.names.has("sketch");
    return { ...this.show, before: beside && figure.name !== "sketch" };
  }

  follow() {
    if (!this.show.follow) return;
    const here = this.placeOf(this.frame);
    const moved = here.clone().sub(this.followed);
    this.followed.copy(here);
    this.camera.position.add(moved);
    this.controls.target.add(moved);
    this.camera.updateMatrixWorld();
  }

  placeOf(frame) { return new Vector3(this.way[frame * 2], 0, this.way[frame * 2 + 1]); }

  /** Look at all that is shown from one of CAMERAS, figures side by side as seen from there. */
  lookFrom(view) {
    this.view = view;
    const { turn, rise } = CAMERAS[view];
    const radians = (turn * Math.PI) / 180;
    const right = new Vector3(Math.cos(radians), 0, -Math.sin(radians));
    this.layOut(right);
    const { centre, width } = this.extent(right);
    const half = Math.tan((FIELD_OF_VIEW * Math.PI) / 360);
    const tall = rise > 45 ? 1.7 : 1.55;
    const far = Math.max(tall / (2 * half), width / (2 * half * this.camera.aspect));
    const up = (rise * Math.PI) / 180;
    const away = new Vector3(Math.sin(radians) * Math.cos(up), Math.sin(up), Math.cos(radians) * Math.cos(up));
    this.controls.target.copy(centre);
    this.camera.position.copy(centre).addScaledVector(away, far * 1.04);
    this.controls.update();
    this.setFrame(this.frame);
  }

  layOut(right) {
    const { shown } = this;
    const gap = this.show.layout === "lanes" ? LANE : 0;
    shown.forEach((figure, i) => figure.group.position.copy(right).multiplyScalar((i - (shown.length - 1) / 2) * gap));
  }

  /** What has to be in view: where the figures are now, or all the way they go. */
  extent(right) {
    const lanes = this.show.layout === "lanes" ? (this.shown.length - 1) * LANE : 0;
    this.followed.copy(this.placeOf(this.frame));
    const centre = this.followed.clone();
    let width = lanes + 1.1;
    if (!this.show.follow) {
      const along = [...Array(this.way.length / 2).keys()].map((frame) => this.placeOf(frame));
      const span = along.map((place) => place.dot(right));
      centre.set(0, 0, 0);
      for (const place of along) centre.addScaledVector(place, 1 / along.length);
      width += Math.max(...span) - Math.min(...span);
    }
    centre.y = 0.5;
    return { centre, width };
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    if (!width || !height) return;
    this.renderer.setPixelRatio(this.ratio);
    this.renderer.setSize(width, height, false);
    RESOLUTION.set(width, height);
    const before = this.camera.aspect;
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (this.character && Math.abs(before - this.camera.aspect) > 0.05) this.lookFrom(this.view);
    this.invalidate();
  }

  invalidate() { this.stale = true; }

  onDrawn(callback) { this.drawnListeners.add(callback); }

  /** Draw if something changed. */
  draw() {
    if (!this.stale || !this.character) return;
    this.stale = false;
    const { x, z } = this.controls.target;
    this.floor.position.set(Math.round(x / this.cell) * this.cell, 0, Math.round(z / this.cell) * this.cell);
    for (const figure of this.shown) figure.face(this.camera);
    this.renderer.render(this.scene, this.camera);
    this.drawn += 1;
    for (const callback of this.drawnListeners) callback();
  }

  /** Draw with fewer pixels where this machine is too slow for all of them. */
  relieve(milliseconds) {
    this.slow = milliseconds > SLOW_MS ? this.slow + 1 : 0;
    if (this.slow < 12 || this.ratio <= 0.75) return;
    this.slow = 0;
    this.ratio = this.ratio > 1 ? 1 : 0.75;
    this.resize();
  }

  /** Where a figure's name goes on the canvas, in CSS pixels: below its feet as the camera sees it. */
  project(figure) {
    const down = new Vector3().setFromMatrixColumn(this.camera.matrixWorld, 1);
    const fromAbove = Math.abs(new Vector3().setFromMatrixColumn(this.camera.matrixWorld, 2).y);
    const place = this.placeOf(this.frame).add(figure.group.position).addScaledVector(down, -0.07 - 0.5 * fromAbove ** 3);
    place.project(this.camera);
    const { clientWidth, clientHeight } = this.canvas;
    return { x: ((place.x + 1) / 2) * clientWidth, y: ((1 - place.y) / 2) * clientHeight };
  }

  figure(name) { return this.figures.find((figure) => figure.name === name); }
}

/** The sketch's way over the floor, smoothed, so that the camera does not bob; [frame, x and z]. */
function smoothWay(figure, character) {
  const [frames, joints] = figure.places.shape;
  const raw = new Float64Array(frames * 2);
  const place = new Vector3();
  const used = [...new Set(character.body.bones.flat())];
  const drawn = used.length ? used : [...Array(joints).keys()];
  for (let frame = 0; frame < frames; frame += 1) {
    for (const joint of drawn) {
      place.fromArray(figure.places.values, (frame * joints + joint) * 3).applyMatrix4(figure.toStage);
      raw[frame * 2] += place.x / drawn.length;
      raw[frame * 2 + 1] += place.z / drawn.length;
    }
  }
  return average(raw, frames, Math.round((FOLLOW_S * character.rate) / 2));
}

function average(values, frames, reach) {
  const smooth = new Float64Array(values.length);
  for (let frame = 0; frame < frames; frame += 1) {
    const near = Math.min(reach, frame, frames - 1 - frame);
    for (let other = frame - near; other <= frame + near; other += 1) {
      for (const axis of [0, 1]) smooth[frame * 2 + axis] += values[other * 2 + axis] / (2 * near + 1);
    }
  }
  return smooth;
}

/** Lines of some width, as two triangles each: lines proper are what software rendering takes longest for. */
function gridGeometry(cell) {
  const end = GRID_CELLS * cell;
  const half = LINE_WIDTH / 2;
  const places = [];
  const index = [];
  const addStrip = (left, right, near, far) => {
    const first = places.length / 3;
    places.push(left, 0, near, right, 0, near, left, 0, far, right, 0, far);
    index.push(first, first + 2, first + 1, first + 1, first + 2, first + 3);
  };
  for (let line = -GRID_CELLS; line <= GRID_CELLS; line += 1) {
    addStrip(line * cell - half, line * cell + half, -end, end);
    addStrip(-end, end, line * cell - half, line * cell + half);
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(places), 3));
  geometry.setIndex(index);
  return geometry;
}
