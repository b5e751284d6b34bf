// Numbers for people: three significant digits, a unit always. Exports have all digits.

const MINUS = "−";
const NARROW = "\u202f";

/** Three significant digits without an exponent between 1e-4 and 1e6; a true minus. */
export function number(value: number | null | undefined, digits = 3): string {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : MINUS + "∞";
  const size = Math.abs(value);
  if (size === 0) return "0";
  let text: string;
  if (size < 1e-4 || size >= 1e6) {
    const [mantissa = "", exponent = ""] = value.toExponential(digits - 1).split("e");
    text = `${mantissa}·10${superscript(Number(exponent))}`;
  } else {
    const places = Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
    text = value.toFixed(places);
    // 9.996 has become 10.00.
    if (Number(text) !== 0 && Math.floor(Math.log10(Math.abs(Number(text)))) > Math.floor(Math.log10(size)) && places > 0) {
      text = value.toFixed(places - 1);
    }
  }
  return text.replace("-", MINUS);
}

function superscript(exponent: number): string {
  const digits = "⁰¹²³⁴⁵⁶⁷⁸⁹";
  return (exponent < 0 ? "⁻" : "") + [...String(Math.abs(exponent))].map((digit) => digits[Number(digit)]).join("");
}

/** Factors that are used on screen, the largest first. */
const PREFIXES: readonly [number, string][] = [
  [1e6, "M"],
  [1e3, "k"],
  [1, ""],
  [1e-3, "m"],
  [1e-6, "µ"],
  [1e-9, "n"],
];

/** A value with its SI unit and a prefix, as `1.23 mm`. Units in which a prefix would be read wrongly have none. */
export function quantity(value: number | null | undefined, unit: string): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return `${number(value)}${NARROW}${unit}`;
  if (!/^(s|m|N|J|Pa|Hz|N\/m|W)$/.test(unit)) return unit ? `${number(value)}${NARROW}${unit}` : number(value);
  const size = Math.abs(value);
  const [factor, prefix] = PREFIXES.find(([least]) => size >= least * 0.9995) ?? (size === 0 ? [1, ""] : [1e-9, "n"]);
  return `${number(value / factor)}${NARROW}${prefix}${unit}`;
}

/** A number without digits that say nothing, as on an axis. */
export function plain(value: number): string {
  return String(Number(value.toPrecision(6))).replace("-", MINUS);
}

/** Texts of the ticks of an axis, evenly apart: as many digits as tell them apart. */
export function tickTexts(ticks: number[]): string[] {
  const step = Math.abs((ticks[1] ?? 1) - (ticks[0] ?? 0)) || 1;
  const largest = Math.max(...ticks.map(Math.abs), step);
  const places = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  if (largest < 1e5 && places <= 5) return ticks.map((tick) => tick.toFixed(places).replace(/^-(0[.0]*)$/, "$1").replace("-", MINUS));
  // The largest has a digit for the step, and the others as many places as it.
  const power = Math.floor(Math.log10(largest) + 1e-9);
  const digits = Math.max(0, power - Math.floor(Math.log10(step) + 1e-9));
  return ticks.map((tick) => (Math.abs(tick) < 1e-6 * step ? "0" : `${(tick / 10 ** power).toFixed(Math.min(digits, 15)).replace("-", MINUS)}·10${superscript(power)}`));
}

/** A value that changes all the time: so many places, so that its digits stand still. */
export function steady(value: number | null | undefined, places: number, unit: string): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return `–${NARROW}${unit}`;
  const text = value.toFixed(places).replace(/^-(0[.0]*)$/, "$1");
  return `${text.replace("-", MINUS)}${NARROW}${unit}`;
}

/** A size of a file. */
export function bytes(value: number): string {
  const [factor, unit] = value >= 1e9 ? [1e9, "GB"] : value >= 1e6 ? [1e6, "MB"] : value >= 1e3 ? [1e3, "kB"] : [1, "B"];
  return `${number(value / factor)}${NARROW}${unit}`;
}

/** A duration. */
export function duration(seconds: number): string {
  if (seconds < 120) return quantity(seconds, "s");
  if (seconds < 7200) return `${number(seconds / 60)}${NARROW}min`;
  return `${number(seconds / 3600)}${NARROW}h`;
}

/** Steps of 1, 2 and 5 that divide a span into about `count`. */
export function niceStep(span: number, count: number): number {
  const raw = span / Math.max(1, count);
  if (!(raw > 0) || !Number.isFinite(raw)) return 1;
  const power = 10 ** Math.floor(Math.log10(raw));
  const rest = raw / power;
  return power * (rest <= 1 ? 1 : rest <= 2 ? 2 : rest <= 5 ? 5 : 10);
}

/** Multiples of a step between two ends, which count. */
export function multiples(step: number, low: number, high: number): number[] {
  const first = Math.ceil(low / step - 1e-9);
  return Array.from({ length: Math.max(0, Math.floor(high / step + 1e-9) - first + 1) }, (_, n) => (first + n) * step);
}

/** Ticks of an axis between two ends, about `count` steps apart. */
export function ticks(low: number, high: number, count: number): number[] {
  return multiples(niceStep(high - low, count), low, high);
}

/** The least and the largest of the finite values, and of two ends that count too. */
export function ends(values: readonly (number | null | undefined)[], low = Infinity, high = -Infinity): [number, number] {
  for (const value of values) {
    if (typeof value !== "number" || !Number.isFinite(value)) continue;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return [low, high];
}
