// Numbers as text for people.

/** Returns about four digits, without a power of ten where that is readable. */
export function short(number, digits = 4) {
  if (number === null || number === undefined || Number.isNaN(number)) return '–';
  if (!Number.isFinite(number)) return number > 0 ? '∞' : '−∞';
  if (number === 0) return '0';
  const size = Math.abs(number);
  if (size >= 1e6 || size < 1e-4) return number.toExponential(digits - 1).replace(/\.?0+e/, 'e');
  return String(Number(number.toPrecision(Math.max(digits, Math.ceil(Math.log10(size + 1))))));
}

/** Returns bytes in the largest fitting power of 1024. */
export function bytes(count) {
  const units = ['B', 'KiB', 'MiB', 'GiB', 'TiB'];
  let power = 0, value = count;
  while (value >= 1024 && power + 1 < units.length) [power, value] = [power + 1, value / 1024];
  return `${power === 0 ? value : Number(value.toPrecision(3))} ${units[power]}`;
}

/** Returns a duration: ms below a second, s below two minutes, then minutes and hours. */
export function duration(seconds) {
  if (seconds < 1) return `${Math.round(1000 * seconds)} ms`;
  if (seconds < 120) return `${Number(seconds.toPrecision(3))} s`;
  if (seconds < 7200) return `${Math.round(seconds / 60)} min`;
  return `${Number((seconds / 3600).toPrecision(2))} h`;
}

/** Returns ticks of 1, 2 or 5 times a power of ten, about `count` of them. */
export function ticks(low, high, count) {
  const rough = (high - low) / count;
  if (!(rough > 0)) return [low];
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((factor) => factor * power >= rough);
  const out = [];
  for (let at = Math.ceil(low / step) * step; at <= high + 1e-9 * step; at += step) out.push(Number(at.toPrecision(12)));
  return out;
}

/** Returns the greatest 1, 2 or 5 times a power of ten that is at most `length`. */
export function roundLength(length) {
  const power = 10 ** Math.floor(Math.log10(length));
  return power * [5, 2, 1].find((factor) => factor * power <= length);
}
