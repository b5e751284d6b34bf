// The socket: requests with numbers, frames, and coming back after it was lost.

import { readFrame, type Frame } from "./frame";
import { VERSION, type Hello, type Unasked } from "./protocol";

export interface Listener {
  /** The server answered `hello`: first time and after each loss. */
  open(hello: Hello): void;
  /** The socket is gone; the page tries again by itself. */
  lost(reason: string): void;
  unasked(message: Unasked): void;
  frame(frame: Frame): void;
}

type Answer = { id: number | null; ok: boolean; error?: string } & Record<string, unknown>;
type Waiting = { done: (answer: Answer) => void; failed: (error: Error) => void };

const RETRY_MS = 700;

export class Connection {
  private socket: WebSocket | null = null;
  private waiting = new Map<number, Waiting>();
  private next = 1;
  /** True between an answered `hello` and the loss of the socket. */
  ready = false;

  constructor(private readonly listener: Listener) {}

  start(): void {
    const address = new URL("ws", location.href);
    address.protocol = "ws:";
    address.hash = "";
    const socket = new WebSocket(address);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.onopen = () => {
      this.ask<Hello>("hello", { version: VERSION }).then(
        (hello) => {
          this.ready = true;
          this.listener.open(hello);
        },
        (error: Error) => this.listener.lost(error.message),
      );
    };
    socket.onmessage = (event: MessageEvent<string | ArrayBuffer>) => {
      if (typeof event.data === "string") this.text(event.data);
      else this.binary(event.data);
    };
    socket.onclose = (event) => {
      this.ready = false;
      for (const waiting of this.waiting.values()) waiting.failed(new Error("the connection was lost"));
      this.waiting.clear();
      this.listener.lost(event.reason);
      setTimeout(() => this.start(), RETRY_MS);
    };
  }

  /** Asks; fails with the server's sentence. */
  ask<T = unknown>(what: string, keys: object = {}): Promise<T> {
    const socket = this.socket;
    if (socket === null || socket.readyState !== WebSocket.OPEN) return Promise.reject(new Error("there is no connection to the server"));
    const id = this.next++;
    return new Promise<T>((resolve, reject) => {
      this.waiting.set(id, { done: (answer) => resolve(answer as T), failed: reject });
      socket.send(JSON.stringify({ id, do: what, ...keys }));
    });
  }

  private text(text: string): void {
    const message = JSON.parse(text) as Answer & Unasked;
    if (message.id === undefined) {
      this.listener.unasked(message);
      return;
    }
    const waiting = message.id === null ? undefined : this.waiting.get(message.id);
    if (message.id !== null) this.waiting.delete(message.id);
    if (message.ok) waiting?.done(message);
    else if (waiting) waiting.failed(new Error(message.error ?? "refused"));
    else this.listener.unasked({ notice: message.error ?? "refused" });
  }

  private binary(bytes: ArrayBuffer): void {
    try {
      this.listener.frame(readFrame(bytes));
    } catch (error) {
      this.listener.unasked({ notice: error instanceof Error ? error.message : String(error) });
    }
  }
}

/** Sends the newest of many values: one request under way at a time, the one in between is dropped. */
export function latest<T>(send: (value: T) => Promise<unknown>, failed: (error: Error) => void): (value: T) => void {
  let busy = false;
  let next: { value: T } | null = null;
  const run = (value: T): void => {
    busy = true;
    send(value)
      .catch((error: Error) => failed(error))
      .finally(() => {
        busy = false;
        if (next) {
          const { value: following } = next;
          next = null;
          run(following);
        }
      });
  };
  return (value) => {
    if (busy) next = { value };
    else run(value);
  };
}
