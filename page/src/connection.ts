// The connection: requests with numbers, frames that carry them, and coming back after it was lost.

import { words } from "./dom";
import { completed, readFrame, type Frame } from "./frame";
import { VERSION, type Hello, type Unasked } from "./protocol";
import type { Told, Transport } from "./transport";

export interface Listener {
  /** The server answered `hello`: first time and after each loss. */
  open(hello: Hello): void;
  /** The socket is gone; the page tries again by itself. */
  lost(reason: string): void;
  unasked(message: Unasked): void;
}

type Answer = { id: number | null; ok: boolean; error?: string } & Record<string, unknown>;
type Waiting = { since: number; done: (answer: Answer) => void; failed: (error: Error) => void };
type Framed = { done: (frame: Frame) => void; failed: (error: Error) => void };

const RETRY_MS = 700;

export class Connection {
  private transport: Transport | null = null;
  private waiting = new Map<number, Waiting>();
  /** Who takes the frames of a request, by its number. */
  private frames = new Map<number, Framed>();
  private following = 0;
  private next = 1;
  /** When the server was heard last, ms on the clock of the page. */
  heard = 0;
  /** True between an answered `hello` and the loss of the socket. */
  ready = false;

  constructor(
    private readonly listener: Listener,
    private readonly carry: (told: Told) => Transport,
  ) {}

  /** How long the oldest question waits, ms. */
  get waits(): number {
    const [oldest] = this.waiting.values();
    return oldest === undefined ? 0 : performance.now() - oldest.since;
  }

  start(): void {
    this.transport = this.carry({
      opened: () => {
        this.ask<Hello>("hello", { version: VERSION }).then(
          (hello) => {
            this.ready = true;
            this.listener.open(hello);
          },
          (error: Error) => this.listener.lost(error.message),
        );
      },
      message: (data) => {
        this.heard = performance.now();
        if (typeof data === "string") this.text(data);
        else this.binary(data);
      },
      closed: (reason) => {
        this.ready = false;
        const lost = new Error("the connection was lost");
        for (const waiting of [...this.waiting.values(), ...this.frames.values()]) waiting.failed(lost);
        this.waiting.clear();
        this.frames.clear();
        this.listener.lost(reason);
        setTimeout(() => this.start(), RETRY_MS);
      },
    });
  }

  /** Asks; fails with the server's sentence. */
  ask<T = unknown>(what: string, keys: object = {}): Promise<T> {
    return this.numbered<T>(this.next++, what, keys);
  }

  /** A part of the page that asks for itself; its newest question counts, here and on the server. */
  panel(panel: "design" | "safety" | "control" | "loop" | "identify"): Panel {
    return new Panel((question) => this.ask("ask", { panel, question }));
  }

  /** A value with its unit in SI; the end of the key says which units it may have. */
  async quantity(key: string, text: string): Promise<number> {
    return (await this.ask<{ value: number }>("quantity", { key, text })).value;
  }

  /** The one frame of a span of the loop, or of a run. */
  async frame(keys: object): Promise<Frame> {
    const id = this.next++;
    const frame = new Promise<Frame>((done, failed) => this.frames.set(id, { done, failed }));
    try {
      const [taken] = await Promise.all([frame, this.numbered(id, "view", keys).catch((error: Error) => this.frames.get(id)?.failed(error))]);
      return taken;
    } finally {
      this.frames.delete(id);
    }
  }

  /** Takes the pictures of the loop as it goes on, until another follows. The server sends what was not acknowledged. */
  async follow(keys: object, done: (picture: Frame) => void): Promise<void> {
    const id = this.next++;
    this.frames.delete(this.following);
    this.following = id;
    let picture: Frame | null = null;
    const take = (frame: Frame) => {
      picture = completed(picture, frame);
      if (picture === null) {
        this.follow(keys, done).catch((error: Error) => this.listener.unasked({ notice: error.message }));
        return;
      }
      this.transport?.send(Uint32Array.of(frame.request, frame.number));
      done(picture);
    };
    this.frames.set(id, { done: take, failed: () => undefined });
    await this.numbered(id, "view", { source: "live", ...keys });
  }

  private numbered<T>(id: number, what: string, keys: object): Promise<T> {
    const transport = this.transport;
    if (!transport?.isOpen) return Promise.reject(new Error("there is no connection to the server"));
    return new Promise<T>((resolve, reject) => {
      this.waiting.set(id, { since: performance.now(), done: (answer) => resolve(answer as T), failed: reject });
      transport.send(JSON.stringify({ id, do: what, ...keys }));
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
      const frame = readFrame(bytes);
      // A frame that nobody waits for any more is dropped.
      this.frames.get(frame.request)?.done(frame);
    } catch (error) {
      this.listener.unasked({ notice: words(error) });
    }
  }
}

/** Sends the newest of many values that are each complete: one request under way at a time, the one in between is dropped. */
export function latest<T>(send: (value: T) => Promise<unknown>, failed: (error: Error) => void): (value: T) => void {
  let busy = false;
  let next: { value: T } | null = null;
  const run = (value: T) => {
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

/**
 * What a panel asks of the server. This is the one place where answers and refusals are dropped that are older than the
 * newest question of their panel; a slider that is dragged goes through `latest` besides, so that it is seen to move.
 */
export class Panel {
  private newest = 0;

  constructor(private readonly send: (question: object) => Promise<unknown>) {}

  /** The answer; null if something newer was asked meanwhile. A question may take its time to be made, as from a file. */
  async ask<T>(question: object | Promise<object>): Promise<T | null> {
    const number = ++this.newest;
    try {
      const asked = await question;
      if (number !== this.newest) return null;
      const answer = await this.send(asked);
      return number === this.newest ? (answer as T) : null;
    } catch (error) {
      if (number !== this.newest) return null;
      throw error;
    }
  }

  /** Nothing that was asked is waited for any more. */
  forget(): void {
    this.newest += 1;
  }
}
