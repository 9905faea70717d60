// The data of mtex_usd/review/plots, read back channel by channel as it is drawn.

import { unpack } from "./packing.js";

const KEPT_ROWS = 40;
const opened = new WeakMap();

function open(packed) {
  if (!opened.has(packed)) {
    if (packed.dtype !== "int16") throw new Error(`expected packed int16, found ${packed.dtype}`);
    const raw = atob(packed.data);
    const bytes = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; i += 1) bytes[i] = raw.charCodeAt(i);
    const numbers = new Int16Array(bytes.buffer);
    opened.set(packed, { numbers, middle: unpack(packed.middle).values, step: unpack(packed.step).values, rows: new Map() });
  }
  return opened.get(packed);
}

/**
 * Read one row of an array of quantized.py, or a part of it.
 * @param {object} packed shape [rows, ..., length]
 * @param {number} row
 * @param {number} [part] which of the runs along the last axis, where a row has several
 * @returns {Float64Array} kept for the next time; not to be written to
 */
export function unpackRow(packed, row, part = 0) {
  const { numbers, middle, step, rows } = open(packed);
  const length = packed.shape[packed.shape.length - 1];
  const parts = packed.shape.slice(1, -1).reduce((product, size) => product * size, 1);
  const begin = (row * parts + part) * length;
  if (!rows.has(begin)) {
    if (rows.size >= KEPT_ROWS) rows.delete(rows.keys().next().value);
    rows.set(
      begin,
      Float64Array.from(numbers.subarray(begin, begin + length), (number) => middle[row] + step[row] * number),
    );
  }
  return rows.get(begin);
}

/** Read a curve at even steps from one place to another, both included, by linear interpolation. */
export function stretch(curve, first, last, count) {
  const out = new Float64Array(count);
  for (let i = 0; i < count; i += 1) {
    const at = first + ((last - first) * i) / Math.max(count - 1, 1);
    const left = Math.min(Math.floor(at), Math.max(curve.length - 2, 0));
    const right = Math.min(left + 1, curve.length - 1);
    out[i] = curve[left] + (curve[right] - curve[left]) * (at - left);
  }
  return out;
}

/** What `build_plots` gives, with curves by channel and variant. */
export class PlotData {
  constructor(raw) {
    Object.assign(this, raw);
    this.times = Float64Array.from({ length: raw.frameCount }, (_, frame) => this.timeOf(frame));
    this.breaks = [0, ...raw.fragments.map((fragment) => fragment.last)];
    // Where fragments meet, time stands for three values: the end of one, a gap, the beginning of the next.
    this.gapped = Float64Array.from(this.withGaps((first, last) => this.times.subarray(first, last + 1), Number.NaN));
    for (let i = 0; i < this.gapped.length; i += 1) if (Number.isNaN(this.gapped[i])) this.gapped[i] = this.gapped[i - 1];
  }

  timeOf(frame) {
    return this.start + frame * this.timeCodesPerFrame;
  }

  frameOf(time) {
    return Math.min(this.frameCount - 1, Math.max(0, Math.round((time - this.start) / this.timeCodesPerFrame)));
  }

  fragmentAt(frame) {
    const found = this.fragments.findIndex(({ last }) => frame < last);
    return found < 0 ? this.fragments.length - 1 : found;
  }

  /** Lay a curve per fragment end to end with a gap between each two; gives an array. */
  withGaps(curveOf, gap = null) {
    const out = [];
    this.fragments.forEach(({ first, last }, q) => {
      if (q > 0) out.push(gap);
      const curve = curveOf(first, last, q);
      for (let i = 0; i <= last - first; i += 1) out.push(curve ? curve[i] : gap);
    });
    return out;
  }

  variantIndex(name) {
    return this.variants.findIndex((variant) => variant.name === name);
  }

  /** @returns {Float64Array|null} null where the channel is not in the page */
  sketch(column) {
    return this.read(this.curves, "sketch", column);
  }

  finished(column, variant) {
    return this.read(this.curves, "finished", column, variant);
  }

  /** @param {"captured"|"skewed"|"joined"} stage captured has the frames that fragments share twice */
  joining(stage, column, variant) {
    return this.read(this.curves.joins, stage, column, variant);
  }

  /** A column whose path is in the page: the one asked for, else the first. */
  pathColumn(column) {
    const { columns } = this.curves.joins;
    return columns.includes(column) ? column : columns[0];
  }

  /** The captured fragments in place, a gap at every join, on the times of `gapped`. */
  capturedWithGaps(column, variant) {
    const captured = this.joining("captured", column, variant);
    return captured && this.withGaps((first, last, q) => captured.subarray(first + q, last + q + 1));
  }

  takeCurve(column, take) {
    const { takes } = this.curves;
    const curve = this.read(takes, "values", column);
    return curve && curve.subarray(takes.starts[take], takes.starts[take] + this.takes[take].frameCount);
  }

  /** What was compared of a take, for one match channel; null where the take is too short or left out. */
  matchCurve(way, channel, take) {
    const begin = this.ways[way].starts[take];
    return begin < 0 ? null : unpackRow(this.ways[way].pool, channel).subarray(begin, begin + this.takes[take].frameCount);
  }

  read(group, name, column, part) {
    const row = group.columns.indexOf(column);
    return row < 0 ? null : unpackRow(group[name], row, part);
  }
}
