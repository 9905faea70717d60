// The ways of hands and feet as streamers (Gleicher 2000), striped for the motion before the edit; strobed poses.

import { BufferAttribute, BufferGeometry, DoubleSide, LineSegments, Mesh, ShaderMaterial, Vector2, Vector3 } from "three";

export const RESOLUTION = new Vector2(1, 1);

const STREAMER_PIXELS = 3.5;
const WHOLE = 1e9;

/** Two vertices per end and frame, frames first, so that a time window is one range of the index. */
function streamerGeometry({ shape, values }, ends) {
  const [frames, joints] = shape;
  const count = frames * ends.length * 2;
  const place = new Float32Array(count * 3);
  const ahead = new Float32Array(count * 3);
  const edge = new Float32Array(count * 2);
  const at = (frame, joint) => (Math.min(frames - 1, Math.max(0, frame)) * joints + joint) * 3;
  for (let frame = 0, vertex = 0; frame < frames; frame += 1) {
    for (const joint of ends) {
      const here = at(frame, joint);
      const before = at(frame - 1, joint);
      const after = at(frame + 1, joint);
      for (const side of [-1, 1]) {
        for (let axis = 0; axis < 3; axis += 1) {
          place[vertex * 3 + axis] = values[here + axis];
          ahead[vertex * 3 + axis] = values[after + axis] - values[before + axis];
        }
        edge.set([side, frame], vertex * 2);
        vertex += 1;
      }
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(place, 3));
  geometry.setAttribute("ahead", new BufferAttribute(ahead, 3));
  geometry.setAttribute("edge", new BufferAttribute(edge, 2));
  geometry.setIndex(new BufferAttribute(streamerIndex(frames, ends.length), 1));
  return geometry;
}

function streamerIndex(frames, ends) {
  const index = new Uint32Array(Math.max(0, frames - 1) * ends * 6);
  for (let frame = 0, i = 0; frame < frames - 1; frame += 1) {
    for (let end = 0; end < ends; end += 1, i += 6) {
      const a = (frame * ends + end) * 2;
      const b = a + ends * 2;
      index.set([a, a + 1, b, b, a + 1, b + 1], i);
    }
  }
  return index;
}

function streamerMaterial(stripe) {
  return new ShaderMaterial({
    uniforms: {
      colour: { value: new Vector3() }, now: { value: 0 }, span: { value: 24 }, stripe: { value: stripe },
      resolution: { value: RESOLUTION }, width: { value: STREAMER_PIXELS },
    },
    vertexShader: `
      attribute vec3 ahead;
      attribute vec2 edge;
      uniform vec2 resolution;
      uniform float width;
      varying float time;
      void main() {
        vec4 here = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
        vec4 there = projectionMatrix * modelViewMatrix * vec4(position + 0.01 * ahead, 1.0);
        vec2 along = (there.xy / there.w - here.xy / here.w) * resolution;
        along = length(along) > 1e-6 ? normalize(along) : vec2(1.0, 0.0);
        here.xy += vec2(-along.y, along.x) * edge.x * width / resolution * here.w;
        time = edge.y;
        gl_Position = here;
      }`,
    fragmentShader: `
      uniform vec3 colour;
      uniform float now;
      uniform float span;
      uniform float stripe;
      varying float time;
      void main() {
        float age = (now - time) / span;
        if (age < 0.0 || age > 1.0) discard;
        if (stripe > 0.0 && fract(time / stripe) > 0.5) discard;
        gl_FragColor = vec4(colour, 0.9 * (1.0 - 0.8 * age));
      }`,
    transparent: true, depthWrite: false, side: DoubleSide,
  });
}

export class Streamers {
  /**
   * @param {object} body ends of the character's data
   * @param {object} places joint positions
   * @param {number} rate frames per second
   * @param {boolean} striped for the motion before the edit
   */
  constructor(body, places, rate, striped) {
    this.frames = places.shape[0];
    this.perFrame = body.ends.length * 6;
    this.rate = rate;
    this.striped = striped;
    this.geometry = streamerGeometry(places, body.ends);
    this.material = streamerMaterial(striped ? Math.max(2, Math.round(rate / 6)) : 0);
  }

  /** A mesh of the same streamers: a striped one is shown beside every variant. */
  makeMesh() {
    const mesh = new Mesh(this.geometry, this.material);
    mesh.frustumCulled = false;
    mesh.renderOrder = 1;
    return mesh;
  }

  setColour(colour) { this.material.uniforms.colour.value.fromArray(colour); }

  /** Show what lies up to `seconds` before a frame; null for all of it, before and after. */
  setWindow(frame, seconds) {
    const { now, span } = this.material.uniforms;
    const whole = seconds === null;
    now.value = whole ? this.frames : frame;
    span.value = whole ? WHOLE : Math.max(1, seconds * this.rate);
    const first = whole ? 0 : Math.max(0, Math.floor(frame - span.value));
    const last = whole ? this.frames - 1 : frame;
    this.geometry.setDrawRange(first * this.perFrame, Math.max(0, last - first) * this.perFrame);
  }

  dispose() {
    this.geometry.dispose();
    this.material.dispose();
  }
}

const STROBE_S = 1 / 3;
const STROBE_REACH_S = 2;

export class Strobes {
  constructor(body, places, rate) {
    this.every = Math.max(1, Math.round(STROBE_S * rate));
    this.reach = STROBE_REACH_S * rate;
    this.perPose = body.bones.length * 2;
    this.geometry = this.makeGeometry(body, places);
    this.material = strobeMaterial(this.reach);
    this.mesh = new LineSegments(this.geometry, this.material);
    this.mesh.frustumCulled = false;
  }

  makeGeometry(body, { shape, values }) {
    const [frames, joints] = shape;
    this.poses = Math.ceil(frames / this.every);
    const place = new Float32Array(this.poses * this.perPose * 3);
    const time = new Float32Array(this.poses * this.perPose);
    let vertex = 0;
    for (let frame = 0; frame < frames; frame += this.every) {
      for (const joint of body.bones.flat()) {
        const at = (frame * joints + joint) * 3;
        place.set(values.subarray(at, at + 3), vertex * 3);
        time[vertex] = frame;
        vertex += 1;
      }
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(place, 3));
    geometry.setAttribute("time", new BufferAttribute(time, 1));
    return geometry;
  }

  setColour(colour) { this.material.uniforms.colour.value.fromArray(colour); }

  setFrame(frame) {
    this.material.uniforms.now.value = frame;
    const first = Math.max(0, Math.floor((frame - this.reach) / this.every));
    const last = Math.min(this.poses, Math.ceil((frame + this.reach) / this.every));
    this.geometry.setDrawRange(first * this.perPose, (last - first) * this.perPose);
  }

  dispose() {
    this.geometry.dispose();
    this.material.dispose();
  }
}

function strobeMaterial(reach) {
  return new ShaderMaterial({
    uniforms: { colour: { value: new Vector3() }, now: { value: 0 }, reach: { value: reach } },
    vertexShader: `
      attribute float time;
      uniform float now;
      uniform float reach;
      varying float strength;
      void main() {
        strength = 0.75 * max(0.0, 1.0 - abs(time - now) / reach);
        gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
      }`,
    fragmentShader: "uniform vec3 colour; varying float strength; void main() { gl_FragColor = vec4(colour, strength); }",
    transparent: true, depthWrite: false,
  });
}
