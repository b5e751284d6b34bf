// Bundles the page into a folder: node bundle.mjs FOLDER DIGEST-OF-SOURCES. Called by build.
import { build } from "esbuild";
import { createHash } from "node:crypto";
import { copyFileSync, mkdirSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { join } from "node:path";

const [folder, sources] = process.argv.slice(2);
mkdirSync(folder, { recursive: true });
for (const name of readdirSync(folder)) rmSync(join(folder, name), { recursive: true });

await build({
  entryPoints: { page: "src/main.ts" },
  outdir: folder,
  bundle: true,
  minify: true,
  format: "esm",
  target: "es2022",
  legalComments: "none",
  charset: "utf8",
  logLevel: "warning",
});
await build({ entryPoints: ["src/page.css"], outdir: folder, bundle: true, minify: true, legalComments: "none", logLevel: "warning", loader: { ".woff2": "file" }, assetNames: "[name]" });
for (const name of ["index.html", "icon.svg"]) copyFileSync(join("src", name), join(folder, name));
// Both ask to be named.
copyFileSync("node_modules/uplot/LICENSE", join(folder, "uplot-license.txt"));
copyFileSync("node_modules/@fontsource-variable/inter/LICENSE", join(folder, "inter-license.txt"));

const files = Object.fromEntries(
  readdirSync(folder).sort().map((name) => [name, createHash("sha256").update(readFileSync(join(folder, name))).digest("hex")]),
);
writeFileSync(join(folder, "manifest.json"), `${JSON.stringify({ sources, files }, null, 2)}\n`);
// The server's table of them; it has them in the program.
const KINDS = { css: "text/css; charset=utf-8", html: "text/html; charset=utf-8", js: "text/javascript; charset=utf-8", svg: "image/svg+xml", txt: "text/plain; charset=utf-8", woff2: "font/woff2" };
const rows = Object.entries(files).map(([name, digest]) => `    File { name: "${name}", kind: "${KINDS[name.split(".").at(-1)]}", tag: "\\"${digest.slice(0, 16)}\\"", bytes: include_bytes!("${name}") },\n`);
writeFileSync(join(folder, "files.in"), `&[\n${rows.join("")}]\n`);
