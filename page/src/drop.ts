// Files that fall on the page: what they are, and which view takes them.

import type { App, Dropped } from "./app";
import { certificate } from "./certificate";
import type { View } from "./fragment";
import { VERSION, type Hello, type RunEntry, type Values } from "./protocol";

/** Puts a file that was dropped where it would stand if it had been chosen. */
export function choose(input: HTMLInputElement, file: File): void {
  const chosen = new DataTransfer();
  chosen.items.add(file);
  input.files = chosen.files;
}

/** The text of a file as the command reads it: UTF-8, UTF-16 with its mark or without, else Windows-1252. */
export async function textOf(file: Blob): Promise<string> {
  const bytes = new Uint8Array(await file.arrayBuffer());
  const [a, b, c, d] = bytes;
  const little = (a === 0xff && b === 0xfe) || (a && b === 0 && c && d === 0);
  if (little || (a === 0xfe && b === 0xff) || (a === 0 && b && c === 0 && d)) {
    // Some programs end the text with a byte of its own.
    const whole = bytes.length % 2 === 1 && bytes.at(-1) === 10 ? bytes.subarray(0, -1) : bytes;
    return new TextDecoder(little ? "utf-16le" : "utf-16be").decode(whole);
  }
  try {
    return new TextDecoder("utf-8", { fatal: true }).decode(bytes);
  } catch {
    return new TextDecoder("windows-1252").decode(bytes);
  }
}

/** A text larger than this does not fit into a message. */
const SIZE_MOST = 15e6;

/** Hears of files anywhere on the page. */
export function listenForFiles(taken: (file: File) => void): void {
  const marked = (on: boolean) => void document.body.classList.toggle("dropping", on);
  addEventListener("dragover", (event) => {
    event.preventDefault();
    marked(true);
  });
  addEventListener("dragleave", () => marked(false));
  addEventListener("drop", (event) => {
    event.preventDefault();
    marked(false);
    for (const file of [...(event.dataTransfer?.files ?? [])].slice(0, 1)) taken(file);
  });
}

/** What a file is and where it belongs; null if it was dealt with. Fails with a sentence for a file that the page cannot use. */
export async function look(app: App, file: File): Promise<{ view: View; dropped: Dropped } | null> {
  const { name } = file;
  if (/\.mcap$/i.test(name)) return { view: "runs", dropped: { is: "log", name: await runOf(app, file) } };
  if (file.size > SIZE_MOST) throw new Error(`${name} is larger than 15 MB: cut it into pieces.`);
  if (/\.(csv|tsv|txt|tab|dat)$/i.test(name)) {
    // Beside a plant a table of frequencies is a measured response, and any other one a record of its input and output.
    if (app.state.view === "control") {
      const text = await textOf(file);
      return { view: "control", dropped: /omega_rad_s|frequency_hz/.test(text) ? { is: "plant", file: { name, text } } : { is: "record", file } };
    }
    return { view: "runs", dropped: { is: "record", file } };
  }
  const text = await textOf(file);
  if (/\.json$/i.test(name)) {
    const answer = certificate(name, text);
    if (answer !== null) return { view: "runs", dropped: { is: "certificate", answer } };
    throw new Error(`${name} is not the certificate of a self-test: drop what device selftest --json has written.`);
  }
  if (!/\.toml$/i.test(name)) throw new Error(`${name} is no file for this page: drop a CSV of a measurement, a TOML file of host-cli, or an MCAP log.`);
  const found = await app.connection.ask<{ is: string; name?: string; experiment?: { kind: string; parameters: Values } }>("file", { name, text });
  if (found.is === "plant" || found.is === "controller") return { view: "control", dropped: { is: found.is, file: { name, text } } };
  if (found.experiment) return { view: "runs", dropped: { is: "experiment", ...found.experiment } };
  await keepTissue(app, found.name ?? "", text);
  feelTissue(app, found.name ?? "");
  return null;
}

/** The run that a log is, by its name and size: a browser does not say where it lies. */
async function runOf(app: App, file: File): Promise<string> {
  const { runs } = await app.connection.ask<{ runs: RunEntry[] }>("runs.list");
  const stem = file.name.replace(/\.mcap$/i, "");
  const run = runs.find(({ name, size_bytes }) => size_bytes === file.size && name.split("/").at(-1) === stem);
  if (run !== undefined) return run.name;
  throw new Error(`${file.name} is not in the folder of the runs, ${app.state.hello?.runs_folder}: copy it there, or give its folder to host-cli serve --runs.`);
}

/** Keeps a tissue in the library under a name; where its file is. */
export async function keepTissue(app: App, name: string, text: string): Promise<string> {
  const { path } = await app.connection.ask<{ path: string }>("tissue.keep", { name, text });
  // The library has one more.
  app.dispatch({ do: "hello", hello: await app.connection.ask<Hello>("hello", { version: VERSION }) });
  return path;
}

/** Opens Feel with a tissue of the library. */
export function feelTissue(app: App, name: string): void {
  app.dispatch({ do: "start", values: new Map([["tissue", name]]) });
}
