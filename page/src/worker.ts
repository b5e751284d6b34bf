// haptic-analysis as WebAssembly, off the page's own thread.

import init, { Bench as Made, Device, parse_quantity, Remembered } from "../generated/page_analysis";
import type { Bench, Done, Judged, Question, Remember, Task } from "./analysis";

const ready = init({ module_or_path: new URL("analysis.wasm", self.location.href) });

/** The last bench: a wall that moves on it costs a verdict only. */
let bench: { key: string; bench: Made } | null = null;

function made({ scheme, order, mass, damping, handStiffness, delay, lag, sampleTime }: Bench): Made {
  const key = JSON.stringify([scheme, order, mass, damping, handStiffness, delay, lag, sampleTime]);
  if (bench?.key === key) return bench.bench;
  const device = new Device(mass, damping, handStiffness, delay, lag, sampleTime);
  try {
    const next = new Made(scheme, order, device);
    bench?.bench.free();
    bench = { key, bench: next };
    return next;
  } finally {
    device.free();
  }
}

function judge(question: Question): Judged {
  const on = made(question);
  const judgement = on.judge(question.stiffness, question.dissipation, question.noise);
  const omega = new Float64Array(question.omega);
  const judged: Judged = {
    region: on.region(),
    passive: on.passive(),
    sentence: judgement.sentence,
    stable: judgement.stable,
    gainMargin: judgement.gain_margin,
    gainMarginDown: judgement.gain_margin_down,
    everyMotionMargin: judgement.every_motion_margin,
    delayMargin: judgement.delay_margin_s,
    sensitivity: judgement.sensitivity,
    sensitivityHz: judgement.sensitivity_hz,
    requiredDamping: judgement.required_damping_n_s_per_m,
    forceNoise: judgement.force_noise_n,
    effective: on.effective(question.stiffness, question.dissipation, omega),
  };
  judgement.free();
  return judged;
}

/** The memory of the tissue that is drawn. */
let memory: Remembered | null = null;

function remember(what: Remember): number {
  if ("law" in what) {
    memory?.free();
    memory = null;
    memory = new Remembered(what.law.order, what.law.stiffness, what.law.dissipation, what.law.step);
  } else memory?.pushed(new Float64Array(what.depths));
  return memory?.set_m() ?? 0;
}

self.onmessage = async (event: MessageEvent<Task>) => {
  const task = event.data;
  const answer = (done: Done): void => self.postMessage(done);
  try {
    await ready;
    if ("judge" in task) answer({ id: task.id, value: judge(task.judge) });
    else if ("remember" in task) answer({ id: task.id, value: remember(task.remember) });
    else answer({ id: task.id, value: parse_quantity(task.parse.key, task.parse.text) });
  } catch (error) {
    answer({ id: task.id, error: error instanceof Error ? error.message : String(error) });
  }
};
