// Elements, numbers and colours of the plots.

const SVG = "http://www.w3.org/2000/svg";

function fill(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else if (name === "style") node.style.cssText = value;
    else node.setAttribute(name, value === true ? "" : value);
  }
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

export function el(tag, attributes = {}, ...children) {
  return fill(document.createElement(tag), attributes, children);
}

export function svg(tag, attributes = {}, ...children) {
  return fill(document.createElementNS(SVG, tag), attributes, children);
}

/** Four significant digits at the most, without an exponent for sizes that angles and distances have. */
export function short(value) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (Math.abs(value) < 5e-3) return "0";
  const size = Math.abs(value);
  if (size >= 1e6) return value.toExponential(2);
  return String(Number(value.toFixed(size >= 100 ? 0 : size >= 10 ? 1 : 2)));
}

export function withUnit(value, unit) {
  return unit === "°" ? `${short(value)}°` : `${short(value)} ${unit}`;
}

// The second cue beside colour.
const DASHES = [[], [9, 4], [2, 3], [9, 3, 2, 3], [14, 4], [5, 3], [2, 5], [9, 3, 2, 3, 2, 3]];
export const SKETCH_DASH = [4, 4];

export function dashOf(variant) {
  return DASHES[variant % DASHES.length];
}

export function variantColour(variant) {
  return `var(--variant-${(variant % 8) + 1})`;
}

export function takeColour(take) {
  return `var(--take-${(take % 12) + 1})`;
}

/** What a colour of the style sheet is at this moment, for canvases. */
export function resolve(colour) {
  const name = /^var\((--[\w-]+)\)$/.exec(colour);
  return name ? getComputedStyle(document.documentElement).getPropertyValue(name[1]).trim() : colour;
}

/** Black or white, whichever reads better on a colour. */
export function inkOn(colour) {
  const [red, green, blue] = [1, 3, 5].map((at) => (parseInt(resolve(colour).slice(at, at + 2), 16) / 255) ** 2.2);
  return 0.2126 * red + 0.7152 * green + 0.0722 * blue > 0.2 ? "#000000" : "#ffffff";
}

/** Watch how wide an element is; tells at once and on every change. */
export function onWidth(node, callback) {
  let width = 0;
  const observer = new ResizeObserver(() => {
    const now = Math.floor(node.clientWidth);
    if (now > 0 && now !== width) {
      width = now;
      callback(width);
    }
  });
  observer.observe(node);
  return () => observer.disconnect();
}

/** A line as it is drawn, for legends. */
export function sample(colour, dash, width = 2) {
  const line = svg("line", {
    x1: 0,
    y1: 5,
    x2: 26,
    y2: 5,
    stroke: colour,
    "stroke-width": width,
    "stroke-dasharray": dash.join(" "),
  });
  return svg("svg", { width: 26, height: 10, "aria-hidden": "true" }, line);
}
