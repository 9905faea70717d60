// Bones as rounded sticks: one instanced mesh per figure, placed by two points per instance, and its shadow.
//
// A stick is a rectangle that faces the camera and is shaded as if it were round: two triangles, where a solid of the
// same looks takes eighty, which is what software rendering spends its time on.

import {
  BufferAttribute, DoubleSide, DynamicDrawUsage, InstancedBufferAttribute, InstancedBufferGeometry, Mesh, ShaderMaterial, Vector3,
} from "three";

const LIGHT = new Vector3(0.45, 1, 0.55).normalize();
const THIN = "0.8"; // width at the second end, of that at the first

// From the two ends and the direction it is seen from, a corner of the rectangle; `across` runs from -1 to 1 over the
// width, `along` in radii from the first end.
const PLACE = `
  attribute vec3 first;
  attribute vec3 second;
  attribute vec3 tint;
  attribute float radius;
  varying float across;
  varying float along;
  varying float span;
  varying vec3 colour;
  vec3 corner(vec3 a, vec3 b, vec3 seen, float size, out vec3 side, out vec3 forth) {
    side = cross(b - a, seen);
    float turned = length(side);
    side = turned > 1e-7 ? side / turned : normalize(cross(seen, vec3(0.31, 0.9, 0.17)));
    forth = cross(seen, side);
    span = abs(dot(b - a, forth)) / size;
    bool atFirst = position.y < 0.0;
    float width = size * (atFirst ? 1.0 : ${THIN});
    across = position.x;
    along = atFirst ? -1.0 : span + ${THIN};
    return (atFirst ? a : b) + width * (position.x * side + position.y * forth);
  }`;

// How far beyond either end, 0 between them, 1 where the rounding ends.
const ROUND = `
  varying float across;
  varying float along;
  varying float span;
  float beyond() { return along < 0.0 ? -along : max(0.0, along - span) / ${THIN}; }`;

function makeSolid() {
  return new ShaderMaterial({
    uniforms: { light: { value: LIGHT } },
    vertexShader: `${PLACE}
      varying vec3 right;
      varying vec3 front;
      void main() {
        vec3 a = (modelViewMatrix * vec4(first, 1.0)).xyz;
        vec3 b = (modelViewMatrix * vec4(second, 1.0)).xyz;
        front = -normalize(a + b);
        vec3 forth;
        float size = radius * length(modelMatrix[0].xyz);
        vec3 place = corner(a, b, front, size, right, forth);
        colour = tint;
        gl_Position = projectionMatrix * vec4(place, 1.0);
        // As near as the round stick would be, so that of two in one place the thicker covers the thinner.
        vec4 near = projectionMatrix * vec4(place + size * front, 1.0);
        gl_Position.z = near.z / near.w * gl_Position.w;
      }`,
    fragmentShader: `${ROUND}
      uniform vec3 light;
      varying vec3 colour;
      varying vec3 right;
      varying vec3 front;
      void main() {
        float away = across * across + beyond() * beyond();
        float inside = clamp((1.0 - away) / max(fwidth(away), 1e-5) + 0.5, 0.0, 1.0);
        if (inside <= 0.0) discard;
        vec3 normal = right * across + front * sqrt(max(0.0, 1.0 - away));
        float lit = 0.5 + 0.5 * dot(normal, mat3(viewMatrix) * light);
        gl_FragColor = vec4(colour * (0.62 + 0.44 * lit), inside);
      }`,
    alphaToCoverage: true, // for smooth round ends
  });
}

function makeShadow() {
  return new ShaderMaterial({
    uniforms: { light: { value: LIGHT }, ground: { value: new Vector3() } },
    vertexShader: `${PLACE}
      uniform vec3 light;
      vec3 onFloor(vec3 end) {
        vec3 place = (modelMatrix * vec4(end, 1.0)).xyz;
        return place - light * (place.y / light.y);
      }
      void main() {
        vec3 side;
        vec3 forth;
        float size = radius * length(modelMatrix[0].xyz);
        vec3 place = corner(onFloor(first), onFloor(second), vec3(0.0, 1.0, 0.0), size, side, forth);
        gl_Position = projectionMatrix * viewMatrix * vec4(place, 1.0);
      }`,
    fragmentShader: `${ROUND}
      uniform vec3 ground;
      void main() {
        if (across * across + beyond() * beyond() > 1.0) discard;
        gl_FragColor = vec4(ground, 1.0);
      }`,
    depthWrite: false,
    depthTest: false,
  });
}

const SOLID = makeSolid();
const SHADOW = makeShadow();
for (const material of [SOLID, SHADOW]) material.side = DoubleSide;

export function setShadowColour(colour) { SHADOW.uniforms.ground.value.fromArray(colour); }

function stickGeometry(count) {
  const geometry = new InstancedBufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array([-1, -1, 0, 1, -1, 0, -1, 1, 0, 1, 1, 0]), 3));
  geometry.setIndex([0, 1, 2, 2, 1, 3]);
  geometry.instanceCount = count;
  const attributes = { first: 3, second: 3, tint: 3, radius: 1 };
  for (const [name, size] of Object.entries(attributes)) {
    const attribute = new InstancedBufferAttribute(new Float32Array(count * size), size);
    if (name === "first" || name === "second") attribute.setUsage(DynamicDrawUsage);
    geometry.setAttribute(name, attribute);
  }
  return geometry;
}

function shade(colour, side) {
  if (side === "left") return colour.map((value) => value + (1 - value) * 0.38);
  return side === "right" ? colour.map((value) => value * 0.62) : colour;
}

export class Bones {
  /**
   * @param {object} body bones, sides, head and height of the character's data
   * @param {{shape: number[], values: Float32Array}} places joint positions, skeleton space
   */
  constructor(body, places) {
    this.body = body;
    this.places = places;
    this.joints = places.shape[1];
    this.count = body.bones.length + (body.head === null ? 0 : 1);
    this.geometry = stickGeometry(this.count);
    this.solid = new Mesh(this.geometry, SOLID);
    this.shadow = new Mesh(this.geometry, SHADOW);
    this.shadow.renderOrder = -2;
    for (const mesh of [this.solid, this.shadow]) mesh.frustumCulled = false;
    this.setThickness(1);
  }

  /** @param {number} thickness factor on the width of all bones */
  setThickness(thickness) {
    if (thickness === this.thickness) return;
    this.thickness = thickness;
    const { bones, height } = this.body;
    const { radius } = this.geometry.attributes;
    bones.forEach(([parent, joint], i) => {
      const length = this.distance(parent, joint);
      radius.array[i] = thickness * Math.min(0.018 * height, Math.max(0.006 * height, 0.11 * length));
    });
    if (this.count > bones.length) radius.array[bones.length] = (0.04 + 0.015 * thickness) * height;
    radius.needsUpdate = true;
  }

  distance(a, b) {
    const { values } = this.places;
    return Math.hypot(values[a * 3] - values[b * 3], values[a * 3 + 1] - values[b * 3 + 1], values[a * 3 + 2] - values[b * 3 + 2]);
  }

  setColour(colour) {
    const { tint } = this.geometry.attributes;
    this.body.bones.forEach(([, joint], i) => tint.array.set(shade(colour, this.body.sides[joint]), i * 3));
    if (this.count > this.body.bones.length) tint.array.set(colour, this.body.bones.length * 3);
    tint.needsUpdate = true;
  }

  setFrame(frame) {
    const { first, second } = this.geometry.attributes;
    const { values } = this.places;
    const at = frame * this.joints * 3;
    const { bones, head } = this.body;
    for (let i = 0; i < bones.length; i += 1) {
      const from = at + bones[i][0] * 3;
      const to = at + bones[i][1] * 3;
      for (let axis = 0; axis < 3; axis += 1) {
        first.array[i * 3 + axis] = values[from + axis];
        second.array[i * 3 + axis] = values[to + axis];
      }
    }
    if (head !== null) {
      for (let axis = 0; axis < 3; axis += 1) {
        first.array[bones.length * 3 + axis] = values[at + head * 3 + axis];
        second.array[bones.length * 3 + axis] = values[at + head * 3 + axis];
      }
    }
    first.needsUpdate = true;
    second.needsUpdate = true;
  }

  /** Joint positions as they are in the buffers that are drawn; joints without a bone are NaN. */
  drawnPositions() {
    const { first, second } = this.geometry.attributes;
    const drawn = new Float32Array(this.joints * 3).fill(NaN);
    this.body.bones.forEach(([parent, joint], i) => {
      drawn.set(first.array.subarray(i * 3, i * 3 + 3), parent * 3);
      drawn.set(second.array.subarray(i * 3, i * 3 + 3), joint * 3);
    });
    return drawn;
  }

  dispose() { this.geometry.dispose(); }
}
