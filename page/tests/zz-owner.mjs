import { WebSocket } from "ws";
const [address, count, seconds] = [process.argv[2], Number(process.argv[3]), Number(process.argv[4])];
const url = address.replace("http", "ws") + "ws", origin = new URL(address).origin;
const open = () => new Promise((done, failed) => { const s = new WebSocket(url, { origin, perMessageDeflate: false }); s.on("open", () => done(s)); s.on("error", failed); });
const owner = await open();
let id = 0; const waiting = new Map();
owner.on("message", (data, binary) => { if (binary) return; const m = JSON.parse(data); if (waiting.has(m.id)) { waiting.get(m.id)(m); waiting.delete(m.id); } });
const ask = (what, keys = {}) => new Promise((done) => { id += 1; waiting.set(id, done); owner.send(JSON.stringify({ id, do: what, ...keys })); });
await ask("hello", { version: 1 });
await ask("feel.start", { environment: { tissue: "prostate-cancerous" } });
const idle = []; 
const measure = async (list) => { const t = performance.now(); await ask("stop"); list.push(performance.now() - t); await ask("arm"); };
for (let n = 0; n < 20; n += 1) { await measure(idle); await new Promise((r) => setTimeout(r, 20)); }
process.stdout.write('ready\n'); await new Promise((r)=>setTimeout(r,3000));
const busy = []; const end = performance.now() + 1000 * seconds;
while (performance.now() < end) { const t = performance.now(); await ask("stop"); busy.push(performance.now() - t); await new Promise((r) => setTimeout(r, 50)); }
const show = (list) => { const s = [...list].sort((a, b) => a - b); return { n: s.length, p50: s[s.length >> 1].toFixed(2), p99: s[Math.floor(0.99 * s.length)].toFixed(2), max: s.at(-1).toFixed(2) }; };
await 0; console.log("idle ms", show(idle), "busy ms", show(busy), '');
process.exit(0);
