// The server of the browser tests: host-cli, over a folder with a wall and a relaxation.
import { execFileSync, spawn } from "node:child_process";
import { mkdtempSync, rmSync, statSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

const root = fileURLToPath(new URL("../../", import.meta.url));
const HOST_CLI = process.env.HOST_CLI ?? join(root, "target/debug/host-cli");

/** Runs of the folder. */
export const [WALL, RELAX] = ["first/wall", "second/relax"];

/** Starts one: its address, the size of the wall's log, and how it is killed. */
export async function startServer() {
  const runs = mkdtempSync(join(tmpdir(), "page-"));
  for (const [folder, words] of [
    ["first", ["run", join(root, "experiments/wall.toml")]],
    ["second", ["relax", "--duration", "4s"]],
  ]) execFileSync(HOST_CLI, [...words, "--out", join(runs, folder), "-q"]);
  const child = spawn(HOST_CLI, ["serve", "--port", "0", "--no-browser", "--runs", runs], { stdio: ["ignore", "pipe", "pipe"] });
  const address = await new Promise((resolve, reject) => {
    let said = "";
    const heard = (data) => {
      said += data;
      const found = /http:\/\/\S+\//.exec(said);
      if (found) resolve(found[0]);
    };
    child.stdout.on("data", heard);
    child.stderr.on("data", heard);
    child.on("exit", () => reject(new Error(`host-cli ended: ${said}`)));
  });
  const ended = new Promise((resolve) => child.on("exit", resolve));
  return {
    address,
    wallBytes: statSync(join(runs, `${WALL}.mcap`)).size,
    kill: async () => {
      child.kill("SIGKILL");
      await ended;
      rmSync(runs, { recursive: true, force: true });
    },
  };
}
