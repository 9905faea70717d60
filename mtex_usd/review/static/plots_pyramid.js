// The pyramid of mtex_usd/texture/pyramid.py for one curve, so that the bands of any channel need not be in the page.

const KERNEL = [1 / 16, 4 / 16, 6 / 16, 4 / 16, 1 / 16];

/** The curve beyond its ends: reflected through the end points. */
function at(curve, i) {
  const last = curve.length - 1;
  if (i < 0) return 2 * curve[0] - curve[-i];
  if (i > last) return 2 * curve[last] - curve[2 * last - i];
  return curve[i];
}

function smooth(curve, step) {
  return Float64Array.from(curve, (_, i) =>
    KERNEL.reduce((sum, weight, tap) => sum + weight * at(curve, i + (tap - 2) * step), 0),
  );
}

/**
 * Split a curve into bands, the highest frequency first.
 * @param {Float64Array} curve
 * @param {number} count bands of the sketch's length
 * @returns {{bands: Float64Array[], residual: Float64Array}} which add up to the curve
 */
export function decompose(curve, count) {
  const bands = [];
  let low = Float64Array.from(curve);
  for (let level = 0; level < count; level += 1) {
    const smoother = smooth(low, 2 ** level);
    bands.push(low.map((value, i) => value - smoother[i]));
    low = smoother;
  }
  return { bands, residual: low };
}
