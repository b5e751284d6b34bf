// The server of the browser tests: the mock, or the real one if HOST_CLI says where it is.
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { startMock } from "./mock-server.mjs";

export const REAL = process.env.HOST_CLI !== undefined;

/** Starts one: its address, and how it is killed. */
export async function startServer() {
  if (!REAL) {
    const mock = await startMock();
    return { address: mock.address, kill: () => mock.close(), again: () => startMock({ port: mock.port, token: mock.token }) };
  }
  const folder = mkdtempSync(join(tmpdir(), "page-"));
  const child = spawn(process.env.HOST_CLI, ["serve", "--port", "0", "--no-browser", "--runs", folder], { stdio: ["ignore", "pipe", "pipe"] });
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
    kill: async () => {
      child.kill("SIGKILL");
      await ended;
      rmSync(folder, { recursive: true, force: true });
    },
  };
}
