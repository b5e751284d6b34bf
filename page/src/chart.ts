// Curves over time or frequency: uPlot with the page's colours, one look for all.

import uPlot from "uplot";
import type { Points } from "./columns";
import { el, onSize, style } from "./dom";
import { ends, niceStep, plain, ticks, tickTexts } from "./format";

export interface Line {
  label: string;
  /** A variable of the style sheet. */
  colour: string;
  dash?: number[];
  width?: number;
  /** Its points are marked, not joined. */
  marked?: boolean;
}

export interface ChartOptions {
  name: string;
  lines: Line[];
  /** Texts of the ticks across. */
  xTexts?: (ticks: number[]) => string[];
  logX?: boolean;
  /** The value axis is logarithmic: all values are above 0. */
  logY?: boolean;
  /** The value axis includes these. */
  yLeast?: number;
  /** Least span of the value axis. */
  ySpan?: number;
  /** A span was chosen with the mouse, or null for all again. */
  zoomed?: (span: [number, number] | null) => void;
  /** The cursor stands at a time, with the values there; null when it leaves. */
  cursor?: (x: number | null, values: (number | null)[]) => void;
  /** Vertical lines. */
  marks?: () => { x: number; text: string }[];
  group?: string;
}

/** All that are on the page. */
const all = new Set<Chart>();

/** Draws every chart in the colours of another theme. */
export function recolour(): void {
  for (const { plot } of all) plot.redraw(false, true);
}

export class Chart {
  readonly root: HTMLElement;
  readonly plot: uPlot;
  private readonly unsize: () => void;
  private y: [number, number] | null = null;

  constructor(private readonly options: ChartOptions) {
    this.root = el("div", { class: "chart", role: "img", "aria-label": options.name });
    this.plot = new uPlot(this.settings(), [[], ...options.lines.map(() => [])] as unknown as uPlot.AlignedData, this.root);
    this.unsize = onSize(this.root, (width, height) => {
      if (width > 0 && height > 0) this.plot.setSize({ width, height });
    });
    this.root.addEventListener("dblclick", () => options.zoomed?.(null));
    all.add(this);
  }

  /** Columns that the plot has pixels for. */
  get columns(): number {
    return Math.max(50, Math.round(this.plot.bbox.width / devicePixelRatio) || 600);
  }

  /** Draws points over `x`, of which `range` is shown; the value axis spans them, or `within`. */
  draw(x: number[], lines: Points[], range: readonly [number, number], within?: [number, number]): void {
    const y = this.span(within === undefined ? lines : [[...within]]);
    this.y = y;
    this.plot.batch(() => {
      this.plot.setData([x, ...lines] as uPlot.AlignedData, false);
      this.plot.setScale("x", { min: range[0], max: range[1] });
      this.plot.setScale("y", { min: y[0], max: y[1] });
    });
  }

  /** It is closed: nothing of the page holds it any more. */
  destroy(): void {
    all.delete(this);
    this.unsize();
    this.plot.destroy();
    this.root.remove();
  }

  private span(lines: Points[]): [number, number] {
    const { yLeast, ySpan = 0, logY } = this.options;
    let [low, high] = ends(lines.flat(), yLeast, yLeast === undefined ? undefined : yLeast + ySpan);
    // A decade at least, of which the axis has texts.
    if (logY) return [10 ** Math.floor(Math.log10(low)), 10 ** Math.ceil(Math.log10(high * (1 + 1e-9)))];
    if (!(high > low)) [low, high] = Number.isFinite(low) ? [low - 0.5 * (ySpan || 1), low + 0.5 * (ySpan || 1)] : [0, ySpan || 1];
    const step = niceStep((high - low) * 1.04, 4);
    const nice: [number, number] = [Math.floor(low / step + 1e-9) * step, Math.ceil((high * 1.0001) / step - 1e-9) * step];
    // Steps of the axis do not flicker: it grows at once and shrinks only when half of it is empty.
    if (this.y === null) return nice;
    const [kept, top] = this.y;
    const holds = kept <= nice[0] && top >= nice[1] && nice[1] - nice[0] > 0.5 * (top - kept);
    return holds ? this.y : nice;
  }

  private settings(): uPlot.Options {
    const { options } = this;
    const axis = (colour: string) => () => style(colour);
    const font = `${style("--tiny") || "12px"} Inter, system-ui, sans-serif`;
    const large = style("--tiny") === "15px" ? 1.25 : 1;
    const texts = options.xTexts ?? tickTexts;
    return {
      width: 600,
      height: 200,
      legend: { show: false },
      padding: [6, 20, 0, 0],
      cursor: {
        drag: { x: options.zoomed !== undefined, y: false, setScale: false },
        points: { size: 7 },
        ...(options.group === undefined ? {} : { sync: { key: options.group, setSeries: false } }),
      },
      select: { show: options.zoomed !== undefined, left: 0, top: 0, width: 0, height: 0 },
      scales: { x: { time: false, auto: false, ...(options.logX ? { distr: 3 } : {}) }, y: { auto: false, ...(options.logY ? { distr: 3 as const } : {}) } },
      axes: [
        {
          stroke: axis("--mute"),
          font,
          size: 28 * large,
          gap: 7,
          grid: { show: false },
          ticks: { show: false },
          space: 60,
          values: (_plot, splits) => {
            // Of a logarithmic axis some have no text.
            const said = texts(splits.filter((split) => split !== null));
            return splits.map((split) => (split === null ? "" : (said.shift() ?? "")));
          },
        },
        {
          stroke: axis("--mute"),
          font,
          // 6.6 px a letter, the exponent's are smaller.
          size: (_plot, texts) => Math.max(52, 12 + 6.6 * Math.max(0, ...(texts ?? []).map((text) => text.length))) * large,
          gap: 6,
          grid: { stroke: axis("--grid"), width: 1 },
          ticks: { show: false },
          splits: (_plot, _axis, min, max) => {
            if (!options.logY) return ticks(min, max, 4);
            const splits: number[] = [];
            const decades = Math.max(1, Math.round(Math.log10(max / min) / 4));
            for (let n = Math.round(Math.log10(min)); 10 ** n <= max * (1 + 1e-6); n += decades) splits.push(10 ** n);
            return splits;
          },
          // A logarithmic axis would leave some without a text.
          filter: (_plot, splits) => splits,
          values: (_plot, splits) => (options.logY ? splits.map(plain) : tickTexts(splits)),
        },
      ],
      series: [
        {},
        ...options.lines.map((line) => ({
          label: line.label,
          stroke: () => style(line.colour),
          width: line.marked ? 0 : (line.width ?? 2),
          ...(line.dash === undefined ? {} : { dash: line.dash }),
          points: line.marked ? { show: true, size: 8, stroke: () => style(line.colour), fill: () => style(line.colour) } : { show: false },
          spanGaps: false,
        })),
      ],
      hooks: {
        setSelect: [
          (plot) => {
            const { left, width } = plot.select;
            // The chart beside it, whose cursor follows, selects too.
            if (width > 4 && plot.root.matches(":hover")) options.zoomed?.([plot.posToVal(left, "x"), plot.posToVal(left + width, "x")]);
            plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
          },
        ],
        setCursor: [
          (plot) => {
            const index = plot.cursor.idx;
            const there = typeof index === "number" && (plot.cursor.left ?? -1) >= 0;
            const x = there ? (plot.data[0][index] ?? null) : null;
            options.cursor?.(x, there ? plot.data.slice(1).map((line) => at(line as (number | null | undefined)[], index)) : []);
          },
        ],
        draw: [
          (plot) => {
            this.drawMarks(plot);
            // Where data lie on the canvas: for those who check pixels.
            const { left, top, width, height } = plot.bbox;
            const { x, y } = plot.scales;
            this.root.dataset["scale"] = JSON.stringify({ left, top, width, height, x: [x?.min, x?.max], y: [y?.min, y?.max] });
          },
        ],
      },
    };
  }

  private drawMarks(plot: uPlot): void {
    const marks = this.options.marks?.() ?? [];
    if (marks.length === 0) return;
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.strokeStyle = ctx.fillStyle = style("--mute");
    ctx.lineWidth = devicePixelRatio;
    ctx.font = `${parseInt(style("--tiny"), 10) * devicePixelRatio}px Inter, system-ui, sans-serif`;
    for (const mark of marks) {
      const x = Math.round(plot.valToPos(mark.x, "x", true)) + 0.5;
      if (x < bbox.left || x > bbox.left + bbox.width) continue;
      ctx.beginPath();
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
      ctx.stroke();
      ctx.fillText(mark.text, x + 4 * devicePixelRatio, bbox.top + 12 * devicePixelRatio);
    }
    ctx.restore();
  }
}

/** The value of a line at a place; of one that has its points elsewhere, the nearest. */
export function at(line: ArrayLike<number | null | undefined>, index: number): number | null {
  for (let away = 0; away < line.length; away += 1) {
    for (const place of [index - away, index + away]) if (line[place] !== undefined) return line[place] ?? null;
  }
  return null;
}

/** Names of lines with their strokes, above a chart; behind each its value at the cursor. A name of several lines has none. */
export function legend(lines: Line[]): { root: HTMLElement; say: (values: string[]) => void } {
  const root = el("div", { class: "legend" });
  const said = lines.map(() => el("b"));
  lines.forEach(({ label, colour, dash, marked }, index) => {
    const alike = lines.flatMap((line, n) => (line.label === label && line.colour === colour ? [n] : []));
    if (alike[0] !== index) return;
    const top = marked || dash === undefined ? "solid" : (dash[0] ?? 0) < 4 ? "dotted" : "dashed";
    const stroke = el("i", { class: marked ? "dot" : undefined, style: `border-color: var(${colour}); border-top-style: ${top}` });
    root.append(el("span", {}, stroke, label, ...(alike.length === 1 ? [said[index] ?? ""] : [])));
  });
  return { root, say: (values) => said.forEach((element, index) => (element.textContent = values[index] ?? "")) };
}
