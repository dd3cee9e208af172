// SPDX-License-Identifier: Apache-2.0
// The page of `make site` on a plain web host.
import { existsSync, readFileSync } from "node:fs";
import { createServer } from "node:http";
import { extname, join } from "node:path";
import { fileURLToPath } from "node:url";

export const site = process.env.HAPTOGRAM_SITE ?? fileURLToPath(new URL("../../build/site/studio", import.meta.url));
export const skip = existsSync(join(site, "studio_engine.wasm")) ? false : `there is no static page in ${site}: it needs Emscripten (tools/setup dev), then \`make site\``;
const types = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".json": "application/json", ".svg": "image/svg+xml", ".wasm": "application/wasm" };

/** Any web host: it knows the kinds of files, and sets no other header. @param other  serves what else there is, and says whether it has */
export async function host(t, other = () => false) {
  const server = createServer((request, response) => {
    const url = new URL(request.url, "http://any");
    if (other(url, request, response)) return;
    const path = url.pathname;
    const file = join(site, path === "/" ? "index.html" : path);
    if (!file.startsWith(site) || !existsSync(file)) return response.writeHead(404).end();
    response.writeHead(200, { "Content-Type": types[extname(file)] ?? "application/octet-stream" }).end(readFileSync(file));
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  t.after(() => {
    server.closeAllConnections();
    server.close();
  });
  const name = `127.0.0.1:${server.address().port}`;
  return { address: `http://${name}/`, host: name };
}
