// A plain web server over a folder, as strangers have one: no headers but a type.
import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import { basename, extname, join } from "node:path";

const TYPES = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml" };

/** Serves the files of a folder below /some/where/: its address, and how it is closed. */
export async function serveFolder(folder) {
  const server = createServer(async ({ url }, response) => {
    const name = basename(new URL(url, "http://x").pathname.replace(/\/$/, "/index.html"));
    try {
      const bytes = await readFile(join(folder, name));
      response.setHeader("Content-Type", TYPES[extname(name)] ?? "application/octet-stream");
      response.end(bytes);
    } catch {
      response.statusCode = 404;
      response.end();
    }
  });
  await new Promise((listens) => server.listen(0, "127.0.0.1", listens));
  return { address: `http://127.0.0.1:${server.address().port}/some/where/`, close: () => server.close() };
}
