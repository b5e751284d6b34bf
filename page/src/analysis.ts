// The analysis in its worker: ask, and get the newest.

/** A device with an operator: where its walls are stable and passive depends on nothing else. */
export interface Bench {
  scheme: string;
  order: number;
  mass: number;
  damping: number;
  handStiffness: number;
  delay: number;
  lag: number;
  sampleTime: number;
}

/** A wall on a device. */
export interface Question extends Bench {
  stiffness: number;
  dissipation: number;
  /** rms of the position's noise, m. */
  noise: number;
  /** Frequencies of the effective stiffness and damping, rad/s; none if empty. */
  omega: number[];
}

/** Stability region and edge of the passive walls: B, K in pairs, NaN between polygons. */
export interface Walls {
  region: Float64Array;
  passive: Float64Array;
}

export interface Judged extends Walls {
  sentence: string;
  stable: boolean;
  gainMargin: number | undefined;
  gainMarginDown: number | undefined;
  /** Factor up to which every motion of contact that may pull is proved. */
  everyMotionMargin: number | undefined;
  delayMargin: number | undefined;
  sensitivity: number | undefined;
  sensitivityHz: number | undefined;
  requiredDamping: number;
  forceNoise: number;
  /** ES and ED of the wall, ES and ED felt, for each ω. */
  effective: Float64Array;
}

/** The memory of the tissue that is drawn: a law begins anew, depths go on. */
export type Remember = { law: { order: number; stiffness: number; dissipation: number; step: number } } | { depths: number[] };

/** A message to the worker. */
export type Task = { id: number; judge: Question } | { id: number; remember: Remember } | { id: number; parse: { key: string; text: string } };
/** Its answer. */
export type Done = { id: number; value: Judged | number } | { id: number; error: string };

/** The worker starts with the first question: its module is compiled after the tissue moves. */
export class Analysis {
  private worker: Worker | null = null;
  private waiting = new Map<number, { done: (value: never) => void; failed: (error: Error) => void }>();
  private next = 1;

  /** Judges a wall; fails with the library's sentence. */
  judge(question: Question): Promise<Judged> {
    return this.send((id) => ({ id, judge: question }));
  }

  /** A value with a unit for a key, SI, read by the code of the command line. */
  parse(key: string, text: string): Promise<number> {
    return this.send((id) => ({ id, parse: { key, text } }));
  }

  /** Tells the tissue's memory; the depth of the surface that follows, m. */
  remember(what: Remember): Promise<number> {
    return this.send((id) => ({ id, remember: what }));
  }

  private send<T>(task: (id: number) => Task): Promise<T> {
    const id = this.next++;
    this.worker ??= this.started();
    const { worker } = this;
    return new Promise<T>((done, failed) => {
      this.waiting.set(id, { done, failed });
      worker.postMessage(task(id));
    });
  }

  private started(): Worker {
    const worker = new Worker(new URL("worker.js", document.baseURI), { type: "module" });
    worker.onmessage = (event: MessageEvent<Done>) => {
      const answer = event.data;
      const waiting = this.waiting.get(answer.id);
      this.waiting.delete(answer.id);
      if ("error" in answer) waiting?.failed(new Error(answer.error));
      else waiting?.done(answer.value as never);
    };
    return worker;
  }
}
