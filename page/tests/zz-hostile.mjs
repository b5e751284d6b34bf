import { WebSocket } from "ws";
const [address, count, seconds] = [process.argv[2], Number(process.argv[3]), Number(process.argv[4])];
const url = address.replace("http", "ws") + "ws", origin = new URL(address).origin;
const open = () => new Promise((done, failed) => { const s = new WebSocket(url, { origin, perMessageDeflate: false }); s.on("open", () => done(s)); s.on("error", failed); });
const idle=[];
const kinds = [
  (n) => JSON.stringify({ id: n, do: "quantity", key: "_s", text: "[".repeat(200_000) }),
  (n) => JSON.stringify({ id: n, do: "file", name: "x.toml", text: "a = [" + "1,".repeat(100_000) + "]" }),
  (n) => JSON.stringify({ id: n, do: "surface", law: { order: 0.5, stiffness_n_per_m: 1, dissipation_n_s_mu_per_m: 1, step_s: 0.02 }, depths_m: Array(3000).fill(0.001) }),
  (n) => JSON.stringify({ id: n, do: "hello", version: 1 }),
  (n) => `{"id": ${n}, "do": "x", "y": [${"[],".repeat(500_000)}1]}`,
  (n) => JSON.stringify({ id: n, do: "feel.hand", position_m: 0, held: true }),
  (n) => JSON.stringify({ id: n, do: "runs.forms" }),
  (n) => JSON.stringify({ id: n, do: "quantity", key: "_s", text: "1 x" }),
];
let sent = 0, answers = 0, closed = 0, longest = 0; const made = kinds.map((kind) => kind(7));
const hostile = await Promise.all(Array.from({ length: count }, open));
hostile.forEach((s, n) => {
  s.on("message", (data, binary) => { if (binary) return; const text = String(data); if (text.includes('"id"')) { answers += 1; longest = Math.max(longest, text.includes('"ok":false') ? text.length : 0); } });
  s.on("close", () => (closed += 1));
  const more = () => { if (s.readyState !== 1) return; for (let k = 0; k < (made[n % made.length].length > 5000 ? 1 : 10); k += 1) { s.send(made[n % made.length]); sent += 1; } setTimeout(more, s.bufferedAmount > 1e6 ? 200 : 10); };
  more();
});
setTimeout(() => { console.log({ sent, answers, closed, longest }); process.exit(0); }, 1000 * seconds);
