// The server in a worker: carries messages between the page and haptic.wasm, and tells it the time. It computes nothing.
// packaging/browser puts it beside the page.

const PERIOD_MS = 8;

/** Messages that came before the server was there. */
const early = [];
let server = null;

/** Puts a message into the server's memory, and has it heard. */
function put(bytes, hear) {
  const at = server.room(bytes.length);
  new Uint8Array(server.memory.buffer, at, bytes.length).set(bytes);
  hear();
}

/** Posts what the server has to say. */
function post() {
  for (let kind = server.take(); kind !== 0; kind = server.take()) {
    const bytes = new Uint8Array(server.memory.buffer, server.taken(), server.taken_bytes()).slice();
    if (kind === 1) postMessage(new TextDecoder().decode(bytes));
    else postMessage(bytes.buffer, [bytes.buffer]);
  }
}

/** Does something with the server; one that has failed does nothing more. */
function tried(work) {
  try {
    work();
    post();
  } catch (error) {
    server = null;
    postMessage({ failed: `the page's server has failed (${error})` });
  }
}

function hear(message) {
  if (typeof message === "string") put(new TextEncoder().encode(message), server.hear);
  else put(new Uint8Array(message.buffer, message.byteOffset, message.byteLength), server.hear_bytes);
}

onmessage = ({ data }) => {
  if (server === null) early.push(data);
  else tried(() => hear(data));
  // What has come until then is heard before a question is answered.
  if (name === "panels") setTimeout(() => server && tried(() => server.work()));
};

async function begin() {
  const response = await fetch("haptic.wasm");
  if (!response.ok) throw new Error(`haptic.wasm: ${response.status}`);
  // A web server may not know the type of the file, which compileStreaming would need.
  const { instance } = await WebAssembly.instantiate(await response.arrayBuffer());
  server = instance.exports;
  put(new TextEncoder().encode(new Date().toISOString().slice(0, 10)), server.begin);
  postMessage(null);
  for (const message of early) tried(() => hear(message));
  if (name === "loop") setInterval(() => server && tried(() => server.advance(performance.now())), PERIOD_MS);
}

begin().catch((error) => postMessage({ failed: `the page's server cannot be loaded (${error.message})` }));
