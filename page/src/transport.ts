// What carries messages to the server and back: a socket, or workers in which the server itself is.

/** Whoever hears what comes. */
export interface Told {
  opened(): void;
  message(data: string | ArrayBuffer): void;
  /** It is gone, for this reason. */
  closed(reason: string): void;
}

export interface Transport {
  readonly isOpen: boolean;
  send(message: string | Uint32Array<ArrayBuffer>): void;
}

/** The socket of the server that this page came from. */
export function bySocket(told: Told): Transport {
  const address = new URL("ws", location.href);
  address.protocol = "ws:";
  address.hash = "";
  const socket = new WebSocket(address);
  socket.binaryType = "arraybuffer";
  socket.onopen = () => told.opened();
  socket.onmessage = (event: MessageEvent<string | ArrayBuffer>) => told.message(event.data);
  socket.onclose = (event) => told.closed(event.reason);
  return {
    get isOpen() {
      return socket.readyState === WebSocket.OPEN;
    },
    send: (message) => socket.send(message),
  };
}

/** A question of a panel may take long: it has a worker of its own, so that the loop goes on. */
const ASKS = /^\{"id":\d+,"do":"ask"/;

/** Workers in which the server is, from the file of this name. */
export function byWorkers(file: string): (told: Told) => Transport {
  return (told) => {
    const transport = { isOpen: false, send: (_: string | Uint32Array<ArrayBuffer>) => undefined as void };
    if (typeof Worker === "undefined" || typeof WebAssembly === "undefined") {
      told.closed("this browser has no WebAssembly or no workers, in which the page computes: take a newer one, or start host-cli serve");
      return transport;
    }
    const workers = ["loop", "panels"].map((name) => new Worker(file, { name }));
    const [loop, panels] = workers as [Worker, Worker];
    const waits = new Set(workers);
    const end = (reason: string) => {
      for (const worker of workers) worker.terminate();
      const were = waits.size > 0 || transport.isOpen;
      transport.isOpen = false;
      waits.clear();
      if (were) told.closed(reason);
    };
    for (const worker of workers) {
      worker.onerror = (event) => end(`the page's worker has failed: ${event.message || "its file cannot be loaded"}`);
      worker.onmessage = (event: MessageEvent<string | ArrayBuffer | { failed: string } | null>) => {
        const { data } = event;
        if (typeof data === "string" || data instanceof ArrayBuffer) told.message(data);
        else if (data !== null) end(data.failed);
        else if (waits.delete(worker) && waits.size === 0) {
          transport.isOpen = true;
          told.opened();
        }
      };
    }
    transport.send = (message) => (typeof message === "string" && ASKS.test(message) ? panels : loop).postMessage(message);
    return transport;
  };
}
