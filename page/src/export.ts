// Pictures and tables of what is shown.

import { path } from "./columns";
import { style } from "./dom";
import { ends, ticks, tickTexts } from "./format";
import type { RunCurves } from "./protocol";

export interface Picture {
  title: string;
  x: number[];
  lines: { name: string; colour: string; dash?: number[]; width?: number; points: (number | null | undefined)[] }[];
}

const WIDTH = 880;
const HEIGHT = 300;
const EDGE = { left: 84, right: 16, top: 34, bottom: 44 };
/** Of a line of the legend, and of a letter in it. */
const LEGEND = { height: 18, stroke: 30, letter: 7 };

/** All samples of a run over its closed form in a span, with all their digits. */
export function csvOf(curves: RunCurves, span: readonly [number, number] | null): string {
  const rows = [`time_s,${curves.quantity ?? "value"},closed_form`];
  curves.time_s.forEach((time, index) => {
    if (span === null || (time >= span[0] && time <= span[1])) rows.push([time, curves.values?.[index] ?? "", curves.closed_form?.[index] ?? ""].join(","));
  });
  return `${rows.join("\n")}\n`;
}

function escaped(text: string): string {
  return text.replace(/[&<>"]/g, (letter) => `&#${letter.charCodeAt(0)};`);
}

/** The charts below each other, as text. */
export function svgOf(pictures: Picture[]): string {
  let height = 0;
  const parts = pictures.map((picture) => {
    const names = legend(picture);
    const part = `<g transform="translate(0 ${height})">${chart(picture, names)}</g>`;
    height += HEIGHT + names.height;
    return part;
  });
  height = Math.max(height, HEIGHT);
  return `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${WIDTH} ${height}" width="${WIDTH}" height="${height}" font-family="Inter, DejaVu Sans, sans-serif" font-size="13"><rect width="100%" height="100%" fill="${style("--panel")}"/>${parts.join("")}</svg>`;
}

/** Names of the lines with their strokes, in as many rows as they need. */
function legend({ lines }: Picture): { text: string; height: number } {
  let [x, row, text] = [EDGE.left, 0, ""];
  for (const line of lines) {
    const width = LEGEND.stroke + LEGEND.letter * line.name.length + 18;
    if (x > EDGE.left && x + width > WIDTH - EDGE.right) [x, row] = [EDGE.left, row + 1];
    const y = EDGE.top + LEGEND.height * row;
    text += `<line x1="${x}" x2="${x + LEGEND.stroke - 6}" y1="${y}" y2="${y}" ${stroke(line)}/><text x="${x + LEGEND.stroke}" y="${y + 4}" fill="${style("--ink")}">${escaped(line.name)}</text>`;
    x += width;
  }
  return { text, height: LEGEND.height * (row + 1) };
}

function stroke(line: Picture["lines"][number]): string {
  const dash = line.dash ? ` stroke-dasharray="${line.dash.join(" ")}"` : "";
  return `stroke="${style(line.colour)}" stroke-width="${line.width ?? 2}"${dash}`;
}

/** The same as pixels, twice as many. */
export async function pngOf(pictures: Picture[]): Promise<Blob> {
  const image = new Image();
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(svgOf(pictures))}`;
  await image.decode();
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [2 * image.width, 2 * image.height];
  canvas.getContext("2d")?.drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise((resolve, reject) => canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error("this browser made no PNG"))), "image/png"));
}

function chart(picture: Picture, names: { text: string; height: number }): string {
  const [x0, x1] = span(picture.x);
  const [y0, y1] = span(picture.lines.flatMap((line) => line.points));
  const [left, right, top, bottom] = [EDGE.left, WIDTH - EDGE.right, EDGE.top + names.height, HEIGHT + names.height - EDGE.bottom];
  const px = (x: number) => left + ((x - x0) / (x1 - x0)) * (right - left);
  const py = (y: number) => bottom - ((y - y0) / (y1 - y0)) * (bottom - top);
  const [ink, grid] = [style("--mute"), style("--grid")];
  let text = `<text x="${left}" y="20" fill="${style("--ink")}" font-weight="600">${escaped(picture.title)}</text>${names.text}`;
  const [across, up] = [ticks(x0, x1, 6), ticks(y0, y1, 6)];
  const [xTexts, yTexts] = [tickTexts(across), tickTexts(up)];
  up.forEach((y, index) => {
    text += `<line x1="${left}" x2="${right}" y1="${py(y)}" y2="${py(y)}" stroke="${grid}"/><text x="${left - 8}" y="${py(y) + 4}" text-anchor="end" fill="${ink}">${yTexts[index]}</text>`;
  });
  across.forEach((x, index) => (text += `<text x="${px(x)}" y="${bottom + 20}" text-anchor="middle" fill="${ink}">${xTexts[index]} s</text>`));
  for (const line of picture.lines) {
    text += `<path d="${path(picture.x, line.points, px, py)}" fill="none" ${stroke(line)} stroke-linejoin="round"><title>${escaped(line.name)}</title></path>`;
  }
  return text;
}

function span(values: readonly (number | null | undefined)[]): [number, number] {
  const [low, high] = ends(values);
  const middle = Number.isFinite(low) ? low : 0;
  return low < high ? [low, high] : [middle - 0.5, middle + 0.5];
}
