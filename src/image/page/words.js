// Elements of a page, and numbers in words.

const SVG = "http://www.w3.org/2000/svg";

const element = (id) => document.getElementById(id);

const css = ([r, g, b]) => `rgb(${r}, ${g}, ${b})`;

function make(name, properties = {}, ...children) {
  const element = Object.assign(document.createElement(name), properties);
  element.append(...children);
  return element;
}

function svg(name, attributes, ...children) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.append(...children);
  return element;
}

/** A number with three significant digits, without trailing zeros. */
function threeDigits(value) {
  const size = Math.abs(value);
  if (size !== 0 && !(size >= 1e-4 && size < 1e5)) {
    return value.toExponential(2).replace("e+", "e");
  }
  const digits = size === 0 ? 0 : Math.max(0, 2 - Math.floor(Math.log10(size)));
  const text = value.toFixed(digits);
  return text.includes(".") ? text.replace(/\.?0+$/, "") : text;
}

/** A value to read: four or five significant digits. */
function shortNumber(value) {
  if (Number.isNaN(value)) return "NaN";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  const size = Math.abs(value);
  if (size === 0) return "0";
  if (size < 1e-3 || size >= 99999.5) return minus(value.toExponential(2).replace("e+", "e"));
  return minus(value.toPrecision(size < 0.1 ? 4 : 5));
}

const minus = (text) => text.replace(/-/g, "−");
const degrees = (radians) => `${minus(((radians * 180) / Math.PI).toFixed(1))}°`;
const percent = (share) => `${(100 * share).toFixed(share < 0.0995 ? 2 : 1)}%`;
