// Colours of jobs: names of CSS, #rgb, #rrggbb, or three numbers of sRGB or of linear light.

const srgbFromLinear = (v) => (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);
const linearFromSrgb = (v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);

const hexOfByte = (v) => Math.round(255 * Math.max(0, Math.min(1, v))).toString(16).padStart(2, '0');
const hexOfSrgb = (rgb) => `#${rgb.slice(0, 3).map(hexOfByte).join('')}`;
export const hexOfLinear = (rgb) => hexOfSrgb(rgb.slice(0, 3).map(srgbFromLinear));

/** Returns the three sRGB numbers of "#rrggbb". */
const srgbOfHex = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16) / 255);

let painter = null;

/** Returns "#rrggbb" of a text that CSS accepts as a colour, else null. The browser knows the names. */
function hexOfText(text) {
  const hex = /^#([0-9a-f]{3}|[0-9a-f]{6})$/i.exec(text);
  if (hex) return hex[1].length === 6 ? text.toLowerCase() : `#${[...hex[1].toLowerCase()].map((c) => c + c).join('')}`;
  if (!/^[a-z]+$/i.test(text) || typeof document === 'undefined') return null;
  painter ??= document.createElement('canvas').getContext('2d');
  painter.fillStyle = '#010203';
  painter.fillStyle = text;
  return painter.fillStyle === '#010203' ? null : painter.fillStyle;
}

/** Returns "#rrggbb" of a colour in a job. `space` is that of numbers: "srgb" or "linear". */
export function hexOf(color, space = 'srgb') {
  if (typeof color === 'string') return hexOfText(color) ?? '#ffffff';
  return space === 'linear' ? hexOfLinear(color) : hexOfSrgb(color);
}

/** Returns linear light of a colour in a job. */
export function linearOf(color, space = 'srgb') {
  if (typeof color === 'string') return srgbOfHex(hexOf(color)).map(linearFromSrgb);
  return space === 'linear' ? color.slice(0, 3) : color.slice(0, 3).map(linearFromSrgb);
}
