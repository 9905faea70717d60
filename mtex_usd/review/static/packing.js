// Arrays of mtex_usd/review/packing.py.

function toBytes(text) {
  const raw = atob(text);
  const bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i += 1) bytes[i] = raw.charCodeAt(i);
  return bytes.buffer;
}

/**
 * Read an array back: base64 of little-endian float32.
 * @param {{dtype: string, shape: number[], data: string}} packed
 * @returns {{shape: number[], values: Float32Array}} values in row-major order
 */
export function unpack(packed) {
  if (packed.dtype !== "float32") throw new Error(`expected packed float32, found ${packed.dtype}`);
  return { shape: packed.shape, values: new Float32Array(toBytes(packed.data)) };
}

/**
 * Read positions back: 16 bits each, about a middle per frame.
 * @param {{middle: object, low: number[], step: number[], shape: number[], data: string}} packed
 * @returns {{shape: number[], values: Float32Array}} values in row-major order, shape [frames, joints, 3]
 */
export function unpackPlaces(packed) {
  const [frames, joints] = packed.shape;
  const middle = unpack(packed.middle).values;
  const steps = new Uint16Array(toBytes(packed.data));
  const values = new Float32Array(steps.length);
  for (let frame = 0, i = 0; frame < frames; frame += 1) {
    for (let joint = 0; joint < joints; joint += 1) {
      for (let axis = 0; axis < 3; axis += 1, i += 1) {
        values[i] = middle[frame * 3 + axis] + packed.low[axis] + steps[i] * packed.step[axis];
      }
    }
  }
  return { shape: packed.shape, values };
}
