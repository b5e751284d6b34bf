// A server for tests that speaks the page's protocol (docs/page-protocol.md) without the Rust one: a spring-pot of
// ten modes at 1 kHz. Alone: node tests/mock-server.mjs [PORT]. It prints its address.
import { createServer } from "node:http";
import { readFileSync, existsSync } from "node:fs";
import { randomBytes } from "node:crypto";
import { extname, join, dirname } from "node:path";
import { fileURLToPath } from "node:url";
import { WebSocketServer } from "ws";

const ASSETS = join(dirname(fileURLToPath(import.meta.url)), "../../crates/haptic-page/assets");
const TYPES = { ".html": "text/html; charset=utf-8", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml", ".json": "application/json", ".txt": "text/plain" };
const CSP = "default-src 'self'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
const CHANNELS = ["position_m", "hand_m", "force_n", "ghost_short_n", "ghost_a3_n", "energy_j", "limiter"];
const T = 1e-3;
/** Time of a change of the law, ms: as of the real server on a busy machine. */
const SLOW_MS = 60;

const TISSUES = [
  ["prostate-cancerous", "prostate, cancerous", 0.2247, 173],
  ["prostate-healthy", "prostate, healthy", 0.2154, 72.2],
].map(([name, title, order, dissipation]) => ({
  name, title, model: "spring-pot", order, order_free: true,
  stiffness_n_per_m: 0, dissipation_n_s_mu_per_m: dissipation,
}));

/** t^(−μ)/Γ(1 − μ) as decaying modes; a short memory has none that last longer than a second. */
function spring_pot(order, short) {
  const modes = [];
  const gamma = (x) => (x < 0.5 ? Math.PI / (Math.sin(Math.PI * x) * gamma(1 - x)) : Math.exp(lgamma(x)));
  const lgamma = (x) => {
    const c = [76.18009172947146, -86.50532032941677, 24.01409824083091, -1.231739572450155, 1.208650973866179e-3, -5.395239384953e-6];
    let [y, sum] = [x, 1.000000000190015];
    for (const part of c) sum += part / ++y;
    return (x + 0.5) * Math.log(x + 5.5) - (x + 5.5) + Math.log((2.5066282746310005 * sum) / x);
  };
  const step = Math.log(4);
  for (let s = 1e-4; s < 4e3; s *= 4) modes.push({ rate: s, weight: (step * s ** order) / (gamma(order) * gamma(1 - order)), z: 0 });
  const rest = short ? 1 / gamma(1 - order) : 0;
  let before = 0;
  return (x) => {
    let force = rest * x * 0;
    for (const mode of modes) {
      mode.z = mode.z * Math.exp(-mode.rate * T) + (x - before);
      if (!short || mode.rate > 1) force += mode.weight * mode.z;
      else force += mode.weight * x * 0.8;
    }
    before = x;
    return force;
  };
}

class Loop {
  constructor(feel) {
    this.feel = feel;
    this.samples = CHANNELS.map(() => []);
    [this.position, this.velocity, this.hand, this.held, this.energy] = [-0.003, 0, -0.003, false, 0];
    [this.stopped, this.paused, this.tick, this.target] = [false, false, 0, -0.003];
    this.law();
  }

  law() {
    this.full = spring_pot(this.feel.order, false);
    this.short = spring_pot(this.feel.order, true);
  }

  step() {
    const { feel } = this;
    const move = Math.max(-5e-4, Math.min(5e-4, this.target - this.hand));
    this.hand += move * 0.2;
    const x = Math.max(0, this.position);
    const B = feel.dissipation_n_s_mu_per_m * feel.scale;
    const K = feel.stiffness_n_per_m * feel.scale;
    let force = this.stopped ? 0 : -Math.max(0, K * x + B * this.full(x));
    if (x === 0) force = 0;
    const short = x > 0 ? -Math.max(0, K * x + B * this.short(x)) : (this.short(x), 0);
    const a3 = -B * x * T ** -feel.order * 0.45;
    const spring = this.held && !this.stopped ? 300 * (this.hand - this.position) - 6 * this.velocity : 0;
    this.velocity += (T * (force + spring - 3.5 * this.velocity)) / 0.065;
    this.position += T * this.velocity;
    this.energy += force * this.velocity * T;
    const has = (name, value) => (feel.ghosts.includes(name) ? value : NaN);
    [this.position, this.held ? this.hand : NaN, force, has("short", short), has("a3", a3), this.energy, 0].forEach((value, n) => this.samples[n].push(value));
    this.tick += 1;
  }

  frame(source, from, to, columns) {
    const width = Math.max(1, Math.ceil((to - from) / columns));
    const first = Math.floor(from / width) * width;
    const count = Math.max(1, Math.ceil((to - first) / width));
    return frame(source, this.samples, first, width, count);
  }
}

function frame(source, samples, first, width, count) {
  const bytes = new ArrayBuffer(52 + 8 * samples.length * count);
  const view = new DataView(bytes);
  [0x32504846, source, samples.length, count].forEach((value, n) => view.setUint32(4 * n, value, true));
  view.setFloat64(16, first, true);
  view.setFloat64(24, width, true);
  view.setFloat64(32, T, true);
  view.setFloat64(40, first, true);
  samples.forEach((values, channel) => {
    for (let column = 0; column < count; column += 1) {
      let [low, high] = [NaN, NaN];
      for (let n = Math.max(0, first + column * width); n < first + (column + 1) * width && n < values.length; n += 1) {
        const value = values[n];
        if (Number.isNaN(value)) continue;
        if (!(low <= value)) low = value;
        if (!(high >= value)) high = value;
      }
      view.setFloat32(52 + 4 * (2 * channel * count + column), low, true);
      view.setFloat32(52 + 4 * ((2 * channel + 1) * count + column), high, true);
    }
  });
  return bytes;
}

const FORMS = [
  {
    kind: "wall",
    tables: [
      {
        title: "wall",
        parameters: [
          { key: "stiffness_n_per_m", kind: "number", default: null, least: 0, most: null, range: "at least 0", required: false, choices: null, help: "Stiffness K of the wall" },
          { key: "order", kind: "number", default: null, least: 0, most: 2, range: "from 0 to 2", required: true, choices: null, help: "Order of the dissipation" },
          { key: "one_sided", kind: "flag", default: false, least: null, most: null, range: null, required: false, choices: null, help: "It pushes only" },
        ],
      },
    ],
  },
  {
    kind: "touch",
    tables: [{ title: "touch", parameters: [{ key: "centre_m", kind: "list", default: "", least: null, most: null, range: null, required: false, choices: [], help: "Of a ball: its centre" }] }],
  },
  {
    kind: "zwidth",
    tables: [{ title: "Z-width", parameters: [{ key: "orders", kind: "list", default: "0,0.5,1", shown: "0,0.5,1", least: null, most: null, range: null, required: false, choices: [], help: "Orders of the dissipation" }] }],
  },
];

const ALL = ["shear", "tension", "compression", "punch", "sphere", "cone"];
const RECORD = [
  { key: "loading", kind: "text", default: "", range: null, choices: ALL, help: "How it is pressed", loadings: ALL },
  { key: "indenter_radius_m", kind: "number", default: null, range: "above 0 and at most 10", choices: [], help: "Radius of a punch or sphere", loadings: ["punch", "sphere"] },
  { key: "half_angle_rad", kind: "number", default: null, range: "from 0.001 to 1.57", choices: [], help: "Half angle of a cone", loadings: ["cone"] },
  { key: "bonded", kind: "flag", default: false, range: null, choices: [], help: "It cannot slide", loadings: ["tension", "compression", "sphere"] },
].map((field) => ({ option: false, ...field }));

/** The samples of a span as a table. */
function table(response, { run, channels, from_s: from = 0, to_s: to = Infinity }) {
  const rows = run.samples[0].flatMap((_, n) => (n * T < from || n * T > to ? [] : [[n * T, ...channels.map((name) => run.samples[run.channels.indexOf(name)][n])].join(",")]));
  response.writeHead(200, { "Content-Type": "text/csv", "Content-Disposition": "attachment" }).end(`${["time_s", ...channels].join(",")}\n${rows.join("\n")}\n`);
}

/** What a Z-width answers. */
function stiffestWalls(orders) {
  const boundary = [0, 1, 2, 3].map((n) => ({ dissipation: 10 * n, stiffness_max: 5000 - 400 * n * n, alpha: 0.3 - 0.024 * n * n, beta: 0.1 * n, analysis_stiffness_n_per_m: 5100 - 400 * n * n, analysis_agrees: n !== 2, held_by_friction_up_to_n_per_m: null }));
  return { orders: orders.map((order) => ({ order, dissipation_unit: "N·s^μ/m", boundary })), scheme: "full", device: "sim", sample_time_s: 0.002, delta: 0.1, criterion: "settling", impact_m_per_s: 0.1, push_n: 1, alpha_searched: 4, runs: 100, disagreements: 1, ended_early: null };
}

export function startMock({ port = 0, token = randomBytes(16).toString("hex") } = {}) {
  let loop = null;
  let running = null;
  let holder = null;
  const pages = new Set();
  const marks = [];
  const tables = [];
  let recording = null;
  let compared = null;
  const runs = [makeRun("relax-0001", "relax", 0.2), makeRun("wall-0002", "wall", 0.5), makeTouch("touch-0001")];

  const server = createServer((request, response) => {
    const { pathname } = new URL(request.url, "http://127.0.0.1");
    const asked = tables[/\/table\/(\d+)\.csv$/.exec(pathname)?.[1]];
    if (asked) return void table(response, asked);
    const name = pathname === `/${token}/` ? "index.html" : pathname.startsWith(`/${token}/`) ? pathname.slice(token.length + 2) : null;
    const file = name && join(ASSETS, name);
    const headers = { "Content-Security-Policy": CSP, "X-Content-Type-Options": "nosniff", "Referrer-Policy": "no-referrer", "Cache-Control": "no-store" };
    if (!file || name.includes("/") || !existsSync(file)) return void response.writeHead(404, headers).end("no such page: copy the address from the terminal");
    response.writeHead(200, { ...headers, "Content-Type": TYPES[extname(name)] ?? "application/octet-stream" }).end(readFileSync(file));
  });
  const sockets = new WebSocketServer({ server, path: `/${token}/ws` });

  sockets.on("connection", (socket) => {
    const page = { socket, live: null, bad: 0, sent: 0 };
    pages.add(page);
    holder ??= page;
    socket.on("close", () => {
      pages.delete(page);
      if (holder === page) {
        holder = null;
        if (loop) [loop.held, loop.stopped] = [false, true];
      }
    });
    socket.on("message", (data, binary) => {
      // Its frames are whole pictures, so what is acknowledged does not matter.
      if (binary) return;
      let message = null;
      try {
        message = JSON.parse(data.toString());
      } catch {
        // No JSON.
      }
      if (!Number.isInteger(message?.id)) {
        page.bad += 1;
        socket.send(JSON.stringify({ id: null, ok: false, error: "this message is no request" }));
        if (page.bad >= 3) socket.close(1008);
        return;
      }
      page.bad = 0;
      try {
        const answer = answers(page, message) ?? {};
        const { later = 0, then, ...now } = answer;
        const send = () => socket.send(JSON.stringify({ id: message.id, ok: true, ...now }));
        if (later > 0) setTimeout(send, later);
        else send();
        then?.();
      } catch (error) {
        socket.send(JSON.stringify({ id: message.id, ok: false, error: error.message }));
      }
    });
  });

  const controls = (page) => {
    if (holder !== page) throw new Error("another page holds the controls: take them first");
  };
  const apply = (message) => {
    for (const key of ["order", "stiffness_n_per_m", "dissipation_n_s_mu_per_m", "scale", "ghosts"]) if (message[key] !== undefined) loop.feel[key] = message[key];
  };
  const range = (least, most, value, step) => ({ least, most, default: value, step });

  function answers(page, message) {
    switch (message.do) {
      case "hello":
        return {
          version: 1, controls: holder === page, watching: pages.size - 1, sample_time_s: T, channels: CHANNELS,
          limiters: ["magnitude", "rate", "fault", "stopping", "start-up", "workspace", "velocity", "guard"], tissues: TISSUES,
          ranges: { order: range(0, 1, 0.2247, 0.01), stiffness_n_per_m: range(0, 2000, 0), dissipation_n_s_mu_per_m: range(0, 2000, 173), scale: range(0.1, 10, 1), mass_kg: range(0.01, 1, 0.065), damping_n_s_per_m: range(0, 20, 3.5), hand_m: range(-0.02, 0.02, 0) },
          feel: loop ? judged(loop.feel) : null, opens: null, device: DEVICE, view_columns_most: 8192, runs_folder: "results",
        };
      case "controls.take":
        if (holder !== null && holder !== page && !message.force) throw new Error("another page holds the controls");
        holder?.socket.send(JSON.stringify({ notice: "another page took the controls" }));
        holder = page;
        return { controls: true };
      case "feel.start": {
        controls(page);
        loop = new Loop(feelOf(message));
        apply(message);
        return { feel: judged(loop.feel) };
      }
      case "feel.set": {
        controls(page);
        if (message.environment) {
          const { feel } = loop;
          loop.feel = { ...feelOf({ ...message, device: feel, ghosts: message.ghosts ?? feel.ghosts }) };
        }
        if (message.order > 0.95) throw new Error("this would be unstable: use at most 0.5 of K and B");
        apply(message);
        if (message.order !== undefined || message.environment) loop.law();
        return { later: SLOW_MS, feel: judged({ ...loop.feel }) };
      }
      case "feel.hand":
        controls(page);
        if (message.held && !loop.held) loop.hand = loop.position;
        [loop.target, loop.held] = [Math.min(Math.max(message.position_m, -0.02), 0.02), message.held];
        return { position_m: loop.target };
      case "feel.pause":
        controls(page);
        loop.paused = message.paused;
        return {};
      case "feel.mark": {
        controls(page);
        const mark = { tick: loop.tick, time_s: loop.tick * T, text: message.text };
        marks.push(mark);
        for (const each of pages) each.socket.send(JSON.stringify({ mark }));
        return { tick: loop.tick };
      }
      case "feel.record":
        controls(page);
        recording = message.on ? "feel-0007.mcap" : null;
        return { name: "feel-0007.mcap", samples: 100, missing: 0 };
      case "stop":
        if (loop) [loop.stopped, loop.held] = [true, false];
        if (running) finish("stopped");
        return {};
      case "compare.start":
        controls(page);
        compared = { running: true, trial: 0, trials: message.trials, wall: 0, touched: true, right: null, table: "compare-0001/compare.csv" };
        return {};
      case "compare.feel":
        if (compared.wall > 0 && !compared.touched) throw new Error(`wall ${compared.wall} was not touched yet: press it first`);
        Object.assign(compared, { wall: compared.wall + 1, touched: false });
        return {};
      case "compare.answer":
        if (compared.wall < 2) throw new Error("an answer before both walls were felt: send `compare.feel`");
        Object.assign(compared, { trial: compared.trial + 1, wall: 0, touched: true });
        if (compared.trial === compared.trials) Object.assign(compared, { running: false, right: 1 });
        return {};
      case "compare.end":
        Object.assign(compared, { running: false, right: 0 });
        return {};
      case "arm":
        controls(page);
        Object.assign(loop, { stopped: false, held: false, position: -0.003, velocity: 0, hand: -0.003, target: -0.003 });
        loop.law();
        return {};
      case "view": {
        if (message.source === "live") {
          if (message.last_s !== undefined) page.live = message;
          if (message.last_s !== undefined || !loop) return { channels: CHANNELS };
          const bytes = loop.frame(message.id, message.from_s / T, message.to_s / T, message.columns);
          return { channels: CHANNELS, then: () => page.socket.send(bytes) };
        }
        const run = runs.find(({ entry }) => entry.name === message.source);
        if (!run) throw new Error(`there is no run ${message.source}`);
        const names = message.channels ?? run.channels;
        const chosen = names.map((name) => run.samples[run.channels.indexOf(name)]);
        const [from, to] = [(message.from_s ?? 0) / T, (message.to_s ?? run.samples[0].length * T) / T];
        const width = Math.max(1, Math.ceil((to - from) / message.columns));
        const bytes = frame(message.id, chosen, Math.floor(from), width, Math.ceil((to - from) / width));
        return { channels: names, then: () => page.socket.send(bytes) };
      }
      case "runs.table": {
        const run = runs.find(({ entry }) => entry.name === message.name);
        tables.push({ ...message, run });
        return { address: `table/${tables.length - 1}.csv` };
      }
      case "view.end":
        page.live = null;
        return {};
      case "runs.list":
        return { runs: runs.map(({ entry }) => entry) };
      case "runs.open": {
        const run = runs.find(({ entry }) => entry.name === message.name);
        if (!run) throw new Error(`there is no run ${message.name} any more`);
        if (run.answer) return { name: message.name, kind: run.entry.kind, verdict: run.entry.verdict, program: "mock", report: run.answer, lines: run.answer.orders.map((order) => ({ level: 1, key: "boundary", label: "boundary", columns: ["dissipation", "stiffness max"], rows: order.boundary.map((point) => [String(point.dissipation), String(point.stiffness_max)]), length: order.boundary.length })), experiment: null };
        return { name: message.name, channels: run.channels, samples: run.samples[0].length, sample_time_s: T, first_s: 0, last_s: run.samples[0].length * T, complete: true, damage: null, missing_samples: 0, axes: run.axes ?? 1, metadata: run.metadata ?? { kind: run.entry.kind, order: 0.2 }, events: [{ time_s: 1, kind: "phase", text: "hold" }], end: { ended: "finished", reason: "" }, curves: run.curves };
      }
      case "runs.forms":
        return { forms: FORMS, record: RECORD, plant_record: [], control_loop: LOOP };
      case "runs.start": {
        controls(page);
        if (message.kind === "zwidth") {
          const name = `zwidth-${String(runs.length + 1).padStart(4, "0")}/zwidth`;
          const run = { entry: { name, kind: "zwidth", started_utc: null, duration_s: null, samples: null, size_bytes: 1234, verdict: "stiffest wall: K = 5000 N/m, of order 0", running: true }, channels: [], samples: [[]], answer: stiffestWalls(message.parameters.orders ?? [0, 0.5, 1]) };
          runs.unshift(run);
          running = { run, done: 0, samples: 8000 };
          return { name, samples: running.samples };
        }
        if (!("order" in message.parameters)) throw new Error("`order` is missing: give a number from 0 to 2");
        const run = makeRun(`wall-${String(runs.length + 1).padStart(4, "0")}`, message.kind, message.parameters.order);
        run.entry.running = true;
        runs.unshift(run);
        running = { run, done: 0, samples: run.samples[0].length };
        return { name: run.entry.name, samples: running.samples };
      }
      case "tissue.keep":
        if (!/^[a-z0-9-]+$/.test(message.name)) throw new Error(`name "${message.name}" is not made of lower-case letters, digits and hyphens`);
        if (TISSUES.some(({ name }) => name === message.name)) throw new Error(`the library has a material "${message.name}" already; choose another name`);
        TISSUES.push({ ...TISSUES[0], name: message.name, title: `the tissue of ${message.name}` });
        return { path: `results/tissues/${message.name}.toml` };
      case "file": {
        const [, table] = /^\[(\w+)\]/m.exec(message.text) ?? [];
        if (table === "parameters") return { is: "tissue", name: /^name = "(.*)"/m.exec(message.text)[1] };
        if (table === "pid") return { is: "controller" };
        if (table === "transfer_function") return { is: "plant" };
        if (table !== "wall") throw new Error(`${message.name}: no experiment: [wall]`);
        return { is: "experiment", experiment: { kind: table, text: message.text, parameters: Object.fromEntries([...message.text.matchAll(/^(\w+) = (.*)$/gm)].map(([, key, value]) => [key, JSON.parse(value)])) } };
      }
      case "runs.stop":
        controls(page);
        if (running) finish("stopped");
        return {};
      case "quantity":
        return { value: quantity(message.key, message.text) };
      case "surface":
        // A tissue that comes back in three seconds.
        if (message.law) page.surface = 0;
        for (const depth of message.depths_m) page.surface = Math.max(depth, page.surface * Math.exp(-0.02 / 3));
        return { surface_m: page.surface };
      case "ask": {
        const { wall, record, explain_record: explained, control, analyze, simulate } = message.question;
        if (explained) return { read: [{ name: explained.name, lines: [{ level: 0, key: "columns", label: "columns", columns: ["name", "taken for"], rows: explained.text.split("\n")[0].split(",").map((name) => [name, "–"]), length: 3 }] }] };
        if (control) return designedControl(control);
        if (analyze || simulate) return askedLoop(analyze ?? simulate, simulate !== undefined);
        if (wall) return judgedWall(wall);
        const rows = record.text.trim().split("\n").map((row) => row.split(",").map(Number));
        if (rows.length < 5) throw new Error("the CSV has no table: give a header and two columns of numbers");
        const { loading = null, indenter_radius_m: radius, half_angle_rad: angle } = record;
        if (record.text.includes("force_n") && !(loading === "sphere" && radius === 0.004 && angle === undefined)) throw new Error("the columns make no record: give loading and indenter_radius_m");
        if (rows.slice(1).some((row) => row.length < 2 || row.some(Number.isNaN))) throw new Error("line 2 of the CSV is not two numbers: give time_s,force_n");
        const time = rows.slice(1).map(([t]) => t);
        const data = rows.slice(1).map(([, value]) => value);
        return { report: { kind: loading ? "record" : "relaxation", loading: { kind: loading, modulus: "young" }, samples: time.length, warnings: ["a note"], model: "spring-pot", candidates: [{ model: "spring-pot", rms_log_residual: 0.01, aic: 1, bic: 2, parameters: { order: { unit: "1", value: 0.2, standard_error: 0.01, low_95: 0.18, high_95: 0.22 } } }] }, lines: [], predicted: [data.map((v) => v * 1.01)], x: time, measured: data, tissue: { name: record.name.replace(/\.\w+$/, ""), text: "name = \"mock\"\n[parameters]\n" }, tissue_reason: null };
      }
      default:
        throw new Error(`there is no request ${message.do}`);
    }
  }

  function finish(state) {
    const { run } = running;
    run.entry.running = false;
    for (const page of pages) page.socket.send(JSON.stringify({ run: { name: run.entry.name, kind: run.entry.kind, state, samples_done: running.done, samples: running.samples, verdict: run.entry.verdict, error: null, report: run.answer ?? { verdict: "passed" } } }));
    running = null;
  }

  let then = performance.now();
  const clock = setInterval(() => {
    const now = performance.now();
    let steps = Math.min(200, Math.floor((now - then) / (1000 * T)));
    then += steps * 1000 * T;
    if (loop && !loop.paused) while (steps-- > 0) loop.step();
    for (const page of pages) {
      if (!page.live || !loop || page.socket.bufferedAmount > 1e6 || loop.tick === page.seen) continue;
      page.seen = loop.tick;
      const bytes = loop.frame(page.live.id, Math.max(0, loop.tick - page.live.last_s / T), loop.tick, page.live.columns);
      page.socket.send(bytes);
    }
    if (running) {
      running.done += 400;
      if (running.done >= running.samples) finish("done");
      else for (const page of pages) page.socket.send(JSON.stringify({ run: { name: running.run.entry.name, kind: running.run.entry.kind, state: "running", samples_done: running.done, samples: running.samples, verdict: null, error: null, report: null } }));
    }
  }, 16);
  const status = setInterval(() => {
    if (compared && loop?.position > 0) compared.touched = true;
    for (const page of pages) {
      page.socket.send(
        JSON.stringify({
          status: {
            tick: loop?.tick ?? 0, time_s: (loop?.tick ?? 0) * T, tick_p50_us: 0.18, tick_p999_us: 0.9, tick_max_us: 2, late: 0, skipped: 0, lost: 0, limiter: 0, limiters: [], fault: null,
            energy_j: loop?.energy ?? 0, position_m: loop?.position ?? 0, force_n: 0, armed: loop !== null && !loop.stopped, stopped: loop?.stopped ?? false, paused: loop?.paused ?? false, running: loop !== null,
            recording, compare: compared, recorded: 0, watching: pages.size - 1, controls: holder === page, samples_made: loop?.tick ?? 0, samples_kept: loop?.tick ?? 0, samples_sent: 0, samples_missed: 0, picture_late_s: 0,
          },
        }),
      );
    }
  }, 100);

  return new Promise((resolve) => {
    server.listen(port, "127.0.0.1", () => {
      const address = `http://127.0.0.1:${server.address().port}/${token}/`;
      resolve({
        address,
        token,
        port: server.address().port,
        loop: () => loop,
        close: () => {
          clearInterval(clock);
          clearInterval(status);
          for (const page of pages) page.socket.terminate();
          sockets.close();
          server.closeAllConnections();
          return new Promise((done) => server.close(done));
        },
      });
    });
  });
}

/** A verdict that no analysis of the page would find. */
function judged(feel) {
  const margin = 7.25 / feel.scale;
  return { ...feel, verdict: { stable: true, margin, passive: true, delay_s: 2e-4, current_lag_s: 0, mass_kg: feel.mass_kg, damping_n_s_per_m: feel.damping_n_s_per_m, hand_stiffness_n_per_m: 0, line: "stable and passive, as the mock says" } };
}

const UNITS = { "": 1, kg: 1, g: 1e-3, m: 1, mm: 1e-3, s: 1, ms: 1e-3, "N/m": 1, "kN/m": 1e3, "N·s/m": 1, "rad/s": 1, rad: 1, deg: Math.PI / 180 };

function quantity(key, text) {
  const [, number, unit] = /^\s*([-+\d.e]+)\s*(\S*)\s*$/.exec(text) ?? [];
  if (number === undefined || Number.isNaN(Number(number))) throw new Error(`"${text}" is not a number`);
  if (!(unit in UNITS)) throw new Error(`"${text}" is not ${key.endsWith("_kg") ? "a mass" : "a value"}`);
  return Number(number) * UNITS[unit];
}

const LOOP = ["controller", "sample_time_s"].map((key) => ({ key, kind: key.endsWith("_s") ? "number" : "text", default: null, shown: "", least: null, most: null, range: null, required: false, choices: [], help: key }));

/** A loop that comes to rest at half of its reference. */
function askedLoop({ plant, controller, sample_time_s: sample }, runs) {
  if (sample === undefined) throw new Error("a controller in notation has no sample time: give `sample_time_s`, as in 1ms");
  const time = Array.from({ length: 100 }, (_, n) => n * sample);
  const signals = runs ? { time_s: time, reference: time.map(() => 1), output: time.map((t) => 0.5 * (1 - Math.exp(-t))), command: time.map(() => 0.5) } : {};
  const row = (key, value) => ({ level: 0, key, label: key, value, reason: "" });
  return { report: { warnings: runs ? ["the output ends at 0.5: give a longer `duration_s`"] : [] }, lines: [row("plant", plant), row("controller", controller), row("stable", "yes")], ...signals };
}

/** First order for the reference, the more overshoot the smaller the margin. */
function designedControl({ plant, plant_file: file, controller_file: own, crossover_rad_s: crossover, phase_margin_rad: margin }) {
  if (!file && plant.endsWith("(s+")) throw new Error(`plant "${plant}": character 5: a term is missing`);
  const time = Array.from({ length: 300 }, (_, n) => (n * 60) / 300 / crossover);
  const omega = Array.from({ length: 200 }, (_, n) => crossover * 10 ** (n / 50 - 2));
  const of = (controller, order) => {
    const step = time.map((t) => 1 - Math.exp(-crossover * t) * Math.cos(0.5 * order * crossover * t));
    return {
      controller, gains: { proportional_gain: 1, integral_gain_per_s_lambda: 0.1, integral_order: order, derivative_gain_s_mu: 0, derivative_order: 1 }, stable: true, verdict: "stable, proved",
      margins: { phase_margin_deg: (180 / Math.PI) * margin, crossover_rad_s: crossover, gain_up: 3, gain_down: null, delay_margin_s: 2, sensitivity_peak: 1.4 }, shape: { overshoot: 0.1, settling_time_s: 30 },
      time_s: time, step, command: step.map((y, n) => (n === 0 ? 40 : 2 - y)), loaded: step.map((y) => 0.3 * (1 - y)), robustness: [0.5, 1, 2].map((gain) => ({ gain, stable: true, step: step.map((y) => y ** (1 / gain)) })),
      omega_rad_s: omega, open_real: omega.map(() => 0), open_imaginary: omega.map((w) => -crossover / w), phase_rad: omega.map(() => -Math.PI / 2),
    };
  };
  return { plant: file ? "1/(2s+1)" : plant, sample_time_s: 0.02 / crossover, fractional: of("1+0.1/s^0.9", 0.9), integer: of("1+0.1/s", 1), integer_reason: null, own: own ? of("2+1/s", 1) : null, notes: ["Every wish is met within 1 %."], file: "[pid]\nintegral_order = 0.9\n" };
}

/** A wall among those of a quarter of an ellipse, smaller for a larger order. */
function judgedWall({ order, stiffness_n_per_m: K, dissipation_n_s_mu_per_m: B, position_noise_m: noise, mass_kg: mass, sample_time_s: sample, points }) {
  const most = [(2 * mass) / sample ** (2 - order) / (1 + order), mass / sample ** 2 / (1 + order)];
  const edge = (share) => Array.from({ length: points }, (_, n) => (n * Math.PI) / 2 / (points - 1)).map((at) => [share * most[0] * Math.cos(at), share * most[1] * Math.sin(at)]);
  const margin = 1 / Math.hypot(B / most[0], K / most[1]);
  const stable = margin > 1;
  return {
    region: [[[0, 0], ...edge(1)]], passive_walls: edge(0.2).reverse(), stable, gain_margin: stable ? margin : null, gain_margin_down: null,
    pulling_contact_margin: stable ? 0.7 * margin : null, pulling_contact: stable ? `proved up to ${K > 0 ? "K" : "B"} = ${(0.7 * margin * (K || B)).toPrecision(4)} ${K > 0 ? "N/m" : "N·s^μ/m"}` : "unstable", delay_margin_s: stable ? 1e-3 : null, sensitivity_peak: stable ? 1.2 : null, sensitivity_peak_hz: stable ? 30 : null,
    passive: margin > 5, negative_at_rest: false, required_damping_n_s_per_m: 3.5 / margin, required_damping: `${(3.5 / margin).toPrecision(4)} N·s/m`, force_noise_n: K * noise,
    curves: Array.from({ length: 120 }, (_, n) => [0.1 * 5000 ** (n / 119), K, B, 0.9 * K, 0.9 * B]),
    hand: { difference: 1.6, felt: true, frequency_hz: 5, part: "damping", best_stiffness_n_per_m: K, best_damping_n_s_per_m: 0.1 * B, best_stable: true },
  };
}

const DEVICE = { mass_kg: 0.065, damping_n_s_per_m: 3.5, delay_s: 0, current_lag_s: 0, friction_n: 0, encoder_resolution_m: 0, sensor_noise_m: 0, sample_time_s: T };

function feelOf({ environment, device, ghosts }) {
  const tissue = TISSUES.find(({ name }) => name === environment.tissue);
  if (!tissue && !environment.wall) throw new Error(`there is no tissue ${environment.tissue}`);
  const { order, stiffness_n_per_m, dissipation_n_s_mu_per_m, scheme = "full", signed = false } = tissue ?? environment.wall;
  if (device?.mass_kg === 0) throw new Error("`mass_kg` = 0 is not above 0 and at most 100: change it");
  return {
    environment, title: tissue?.title ?? "own wall", order, order_free: true, stiffness_n_per_m, dissipation_n_s_mu_per_m, scale: 1,
    note: null, scheme: scheme === "exact" ? "full" : scheme, signed, ...DEVICE, ...device, hand_stiffness_n_per_m: 300, hand_damping_n_s_per_m: 6,
    ghosts: ghosts ?? [], force_limit_n: 10, force_rate_limit_n_per_s: 1000, memory_s: 500, paused: false,
  };
}

function makeRun(name, kind, order) {
  const law = spring_pot(order, false);
  const samples = [[], [], []];
  for (let n = 0; n < 8000; n += 1) {
    const x = Math.min(1, n / 1000) * 1e-3;
    const force = 173 * law(x);
    samples[0].push(x);
    samples[1].push(-force);
    samples[2].push(-force * 1.002);
  }
  return { entry: { name, kind, started_utc: "2026-11-20T22:00:00Z", duration_s: 8, samples: 8000, size_bytes: 412345, verdict: "passed", running: false }, channels: ["position_m", "commanded_force_n", "contact_force_n"], samples, curves: { title: name, quantity: "force", label: "force / N", time_s: samples[0].map((_, n) => n * T), values: samples[1].map((f) => -f), closed_form: samples[2].map((f) => -f) } };
}

/** A finger round a disc of 20 mm, 2 mm deep. */
function makeTouch(name) {
  const channels = ["reference_x_m", "reference_y_m", "position_x_m", "position_y_m", "commanded_force_x_n", "commanded_force_y_n", "commanded_force_norm_n", "limiter"];
  const samples = channels.map(() => []);
  for (let n = 0; n < 4000; n += 1) {
    const [angle, radius, force] = [(2 * Math.PI * n) / 2000, 0.02 - 0.002 * Math.min(1, n / 500), 0.5 * Math.min(1, n / 500)];
    const [x, y] = [Math.cos(angle), Math.sin(angle)];
    [(radius - 0.001) * x, (radius - 0.001) * y, radius * x, radius * y, force * x, force * y, force, 0].forEach((value, channel) => samples[channel].push(value));
  }
  const metadata = { experiment: { experiment: "touch", shape: "ball", centre_m: "0 0", radius_m: "0.02" } };
  return { entry: { name, kind: "touch", started_utc: null, duration_s: 4, samples: 4000, size_bytes: 312345, verdict: "passive", running: false }, axes: 2, channels, samples, metadata, curves: null };
}

if (process.argv[1] === fileURLToPath(import.meta.url)) startMock({ port: Number(process.argv[2] ?? 0) }).then(({ address }) => console.log(address));
