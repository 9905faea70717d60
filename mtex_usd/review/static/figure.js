// One figure on the stage: bones and shadow, streamers, strobes and contact symbols of one motion.

import { BufferAttribute, BufferGeometry, Group, Matrix4, Mesh, MeshBasicMaterial, Vector3 } from "three";
import { Bones } from "./bones.js";
import { unpack } from "./packing.js";
import { Strobes, Streamers } from "./streamers.js";

// The support of engineering drawings: a triangle under the point that is held, facing the camera.
const SUPPORT = new BufferGeometry();
SUPPORT.setAttribute("position", new BufferAttribute(new Float32Array([0, 0, 0, -0.58, -1, 0, 0.58, -1, 0]), 3));
const SUPPORT_SIZE = 0.05; // heights
const CONTACT = new MeshBasicMaterial({ depthTest: false, transparent: true, toneMapped: false });

export function setContactColour(colour) { CONTACT.color.setRGB(...colour, "srgb"); }

function readContacts(contacts) {
  return (contacts ?? []).map((each) => ({ ...each, places: unpack(each.places).values }));
}

export class Figure {
  /**
   * @param {string} name "sketch" or the variant's
   * @param {object} character the character's data
   * @param {{places: object, contacts: object[]}} motion unpacked places and contacts
   * @param {Matrix4} toStage skeleton space to the stage
   */
  constructor(name, character, motion, toStage) {
    const { body, rate } = character;
    this.name = name;
    this.places = motion.places;
    this.toStage = toStage;
    this.group = new Group();
    this.inside = new Group();
    this.inside.matrixAutoUpdate = false;
    this.inside.matrix.copy(toStage);
    this.group.add(this.inside);
    this.bones = new Bones(body, motion.places);
    this.streamers = new Streamers(body, motion.places, rate, name === "sketch");
    this.trail = this.streamers.makeMesh();
    this.strobes = new Strobes(body, motion.places, rate);
    this.inside.add(this.bones.solid, this.bones.shadow, this.trail, this.strobes.mesh);
    this.contacts = readContacts(motion.contacts);
    this.supports = [];
  }

  /** The sketch's streamers, shown with this figure as well. */
  addBefore(streamers) {
    this.before = streamers.makeMesh();
    this.inside.add(this.before);
  }

  setColour(colour) {
    this.bones.setColour(colour);
    this.streamers.setColour(colour);
    this.strobes.setColour(colour);
  }

  /** @param {object} show which layers are on, and the length of trails */
  setFrame(frame, show) {
    this.bones.setFrame(frame);
    this.bones.shadow.visible = show.shadows;
    this.trail.visible = show.trails;
    if (this.before) this.before.visible = show.trails && show.before;
    if (show.trails) this.streamers.setWindow(frame, show.trailSeconds);
    this.strobes.mesh.visible = show.strobes;
    if (show.strobes) this.strobes.setFrame(frame);
    this.placeSupports(frame, show.contacts);
  }

  placeSupports(frame, shown) {
    const held = shown ? this.contacts.filter((each) => each.first <= frame && frame <= each.last) : [];
    while (this.supports.length < held.length) this.supports.push(this.makeSupport());
    this.supports.forEach((support, i) => {
      support.visible = i < held.length;
      if (!support.visible) return;
      support.position.fromArray(held[i].places, (frame - held[i].first) * 3).applyMatrix4(this.toStage);
    });
  }

  makeSupport() {
    const support = new Mesh(SUPPORT, CONTACT);
    support.renderOrder = 5;
    support.scale.setScalar(SUPPORT_SIZE);
    this.group.add(support);
    return support;
  }

  /** Turn flat symbols towards the camera. */
  face(camera) { for (const support of this.supports) support.quaternion.copy(camera.quaternion); }

  get held() { return this.supports.filter((support) => support.visible).length; }

  dispose() {
    this.bones.dispose();
    this.streamers.dispose();
    this.strobes.dispose();
  }
}

/** Skeleton space to the stage: floor at y = 0, front along z, the figure one unit tall, the start in the middle. */
export function stageMatrix(body, places) {
  const up = new Vector3(...body.up).normalize();
  const front = new Vector3(...body.front).normalize();
  const turn = new Matrix4().makeBasis(new Vector3().crossVectors(up, front), up, front).transpose();
  const [, joints] = places.shape;
  const origin = new Vector3();
  for (let joint = 0; joint < joints; joint += 1) origin.add(new Vector3().fromArray(places.values, joint * 3));
  origin.divideScalar(joints);
  origin.addScaledVector(up, body.floor - origin.dot(up));
  const size = 1 / body.height;
  return turn.scale(new Vector3(size, size, size)).multiply(new Matrix4().makeTranslation(-origin.x, -origin.y, -origin.z));
}
