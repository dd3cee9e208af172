// SPDX-License-Identifier: Apache-2.0
// The server as other programs meet it: who is let in, over real sockets; tests/studio/test_guard.cpp has every row.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { readdirSync, readFileSync } from "node:fs";
import { request } from "node:http";
import { connect, createServer } from "node:net";
import { test } from "node:test";
import { quantile, run, sleep, startStudio } from "./support.mjs";

/** A request; the answer's status, headers and body. */
function ask(studio, path, { method = "GET", headers = {}, body = "" } = {}) {
  const { port } = new URL(studio.origin);
  return new Promise((done, failed) => {
    const asked = request({ host: "127.0.0.1", port, path, method, headers: { Host: studio.host, ...headers } }, (answer) => {
      let text = "";
      answer.on("data", (bytes) => (text += bytes));
      answer.on("end", () => done({ status: answer.statusCode, headers: answer.headers, text }));
    });
    asked.on("error", failed);
    asked.end(body);
  });
}

/** What comes back for these bytes, until the server closes. */
function speak(studio, bytes) {
  const { port } = new URL(studio.origin);
  return new Promise((done, failed) => {
    let text = "";
    const socket = connect(port, "127.0.0.1", () => socket.write(bytes));
    socket.setTimeout(10_000, () => failed(new Error("no end")));
    socket.on("data", (more) => (text += more));
    socket.on("end", () => done(text));
    socket.on("error", () => done(text));
  });
}

test("the server lets in who has the token and comes from its own page", async (t) => {
  const studio = await startStudio(t);
  const key = { Authorization: `Bearer ${studio.token}` };
  const upgrade = { Connection: "Upgrade", Upgrade: "websocket", "Sec-WebSocket-Version": "13", "Sec-WebSocket-Key": "AAAAAAAAAAAAAAAAAAAAAA==" };
  const rows = [
    [200, "/", {}],
    [200, "/?x=1", {}],
    [200, "/", { "Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate", "Sec-Fetch-Dest": "document" }],
    [403, "/", { "Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate", "Sec-Fetch-Dest": "iframe" }],
    [403, "/boot.js", { "Sec-Fetch-Site": "same-site" }],
    [421, "/", { Host: "evil.example" }],
    [421, "/api/hello", { ...key, Host: `evil.example:${new URL(studio.origin).port}` }],
    [403, "/api/hello", { ...key, Origin: "http://evil.example" }],
    [403, "/api/hello", { ...key, Origin: "null" }],
    [401, "/api/hello", {}],
    [401, "/api/hello", { Authorization: `Bearer ${"0".repeat(32)}` }],
    [401, `/api/hello?token=${studio.token}`, { Cookie: `token=${studio.token}` }],
    [200, "/api/hello", key],
    [404, "/api/nothing", key],
    [404, "/../../etc/passwd", {}],
    [404, "/%2e%2e/%2e%2e/etc/passwd", {}],
    [403, "/ws", { ...upgrade, "Sec-WebSocket-Protocol": `haptogram.1, token.${studio.token}` }],
    [401, "/ws", { ...upgrade, Origin: studio.origin, "Sec-WebSocket-Protocol": "haptogram.1" }],
    [403, "/ws", { ...upgrade, Origin: "http://evil.example", "Sec-WebSocket-Protocol": `haptogram.1, token.${studio.token}` }],
  ];
  for (const [status, path, headers] of rows) {
    const answer = await ask(studio, path, { headers });
    assert.equal(answer.status, status, `${path} ${JSON.stringify(headers)}: ${answer.text}`);
    assert.match(answer.headers["content-security-policy"], /default-src 'none'.*frame-ancestors 'none'/);
    assert.equal(answer.headers["access-control-allow-origin"], undefined);
    assert.equal(answer.headers["set-cookie"], undefined);
    assert.ok(!answer.text.includes(studio.token));
  }
  for (const method of ["OPTIONS", "PUT", "DELETE"]) assert.equal((await ask(studio, "/api/hello", { method, headers: key })).status, 405);
  // The token is never in the list of processes.
  const words = (process) => {
    try {
      return readFileSync(`/proc/${process}/cmdline`, "latin1");
    } catch {
      return ""; // it has ended
    }
  };
  assert.match(words(studio.child.pid), /studio/);
  for (const process of readdirSync("/proc").filter((name) => /^\d+$/.test(name))) assert.ok(!words(process).includes(studio.token));
});

test("the server answers before it closes on what is too long or no HTTP", async (t) => {
  const studio = await startStudio(t);
  const head = `Host: ${studio.host}\r\nAuthorization: Bearer ${studio.token}\r\n`;
  assert.match(await speak(studio, `POST /api/files?name=a.ply HTTP/1.1\r\n${head}Content-Length: 99999999999\r\n\r\n`), /^HTTP\/1.1 413/);
  assert.match(await speak(studio, `GET / HTTP/1.1\r\n${head}X: ${"x".repeat(20_000)}\r\n\r\n`), /^HTTP\/1.1 431/);
  assert.match(await speak(studio, "\x16\x03\x01 no HTTP at all\r\n\r\n"), /^HTTP\/1.1 400/);
  assert.match(await speak(studio, "GET / HTTP/1.0\r\n\r\n"), /^HTTP\/1.1 421/);
  assert.equal((await ask(studio, "/")).status, 200);
});

test("files are kept by name, and taken away as they are", async (t) => {
  const studio = await startStudio(t);
  const headers = { Authorization: `Bearer ${studio.token}` };
  const send = (name, body) => ask(studio, `/api/files?name=${encodeURIComponent(name)}`, { method: "POST", headers, body });
  assert.equal((await send("a.xyz", "0 0 130\n")).status, 200);
  for (const name of ["../a.xyz", "a/../b.xyz", "/a.xyz", ".a.xyz", "a.exe", "", "a\nb.xyz"]) {
    const answer = await send(name, "0 0 130\n");
    assert.equal(answer.status, 422, name);
    assert.ok(JSON.parse(answer.text).error.message.length > 20);
  }
  assert.equal((await ask(studio, "/api/files", { method: "POST", headers })).status, 400);
  assert.equal((await ask(studio, "/api/take?scene=none&as=hex", { headers })).status, 422);
  assert.equal((await ask(studio, "/api/report?scene=none", { headers })).status, 422);
  assert.equal((await ask(studio, "/api/report?scene=none")).status, 401);
});

test("STOP is answered whatever else waits", async (t) => {
  const studio = await startStudio(t);
  const { port } = new URL(studio.origin);
  const stop = async () => {
    const begun = performance.now();
    const answer = await ask(studio, "/api/stop", { method: "POST", headers: { Authorization: `Bearer ${studio.token}` } });
    assert.equal(answer.status, 200, answer.text);
    return performance.now() - begun;
  };
  const alone = await stop();
  // From a process of their own, so that they do not wait for one another here; more keep coming.
  const strangers = spawn("python3", ["-c", `
import socket, time
kept = []
def come():
    kept.append(socket.create_connection(("127.0.0.1", ${port})))
    try:
        kept[-1].send(b"GET / HTTP/1.1\\r\\nHost: ")
    except OSError:
        pass
for _ in range(1500):
    come()
print("there", flush=True)
while True:
    for _ in range(20):
        kept.pop(0).close()
        come()
    time.sleep(0.05)
`], { stdio: ["ignore", "pipe", "inherit"] });
  t.after(() => strangers.kill("SIGKILL"));
  const there = new Promise((done) => strangers.stdout.once("data", done));
  const under = [];
  for (let i = 0, all = false; i < 20 || !all; i++) {
    under.push(await stop());
    all ||= await Promise.race([there.then(() => true), sleep(20).then(() => false)]);
  }
  const worst = Math.max(...under);
  t.diagnostic(`STOP alone ${alone.toFixed(1)} ms; with 1,500 half-open connections ${quantile(under, 0.5).toFixed(1)} ms, at worst ${worst.toFixed(1)} ms`);
  assert.ok(worst <= 100, `${worst} ms`);
  assert.equal((await ask(studio, "/api/hello", { headers: { Authorization: `Bearer ${studio.token}` } })).status, 200, "other requests are served, too");
});

test("who asks for files, shows no token and takes no answer keeps nobody out", async (t) => {
  const studio = await startStudio(t);
  const { port } = new URL(studio.origin);
  const headers = { Authorization: `Bearer ${studio.token}` };
  const script = (await ask(studio, "/boot.js")).text.match(/app-\w+\.js/)[0];
  assert.ok((await ask(studio, `/${script}`)).text.length > 100_000, "more than a connection takes unread");
  const greedy = spawn("python3", ["-c", `
import socket, time
kept = []
for _ in range(60):
    each = socket.socket()
    each.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
    each.connect(("127.0.0.1", ${port}))
    each.sendall(b"GET /${script} HTTP/1.1\\r\\nHost: ${studio.host}\\r\\n\\r\\n" * 12)
    kept.append(each)
time.sleep(1)
print("there", flush=True)
time.sleep(600)
`], { stdio: ["ignore", "pipe", "inherit"] });
  t.after(() => greedy.kill("SIGKILL"));
  await new Promise((done) => greedy.stdout.once("data", done));
  const took = [];
  for (let i = 0; i < 20; i++) {
    const begun = performance.now();
    assert.equal((await ask(studio, "/api/stop", { method: "POST", headers })).status, 200);
    took.push(performance.now() - begun);
    assert.equal((await ask(studio, "/api/hello", { headers })).status, 200);
    assert.equal((await ask(studio, "/")).status, 200);
  }
  t.diagnostic(`STOP with 60 that take nothing: ${quantile(took, 0.5).toFixed(1)} ms, at worst ${Math.max(...took).toFixed(1)} ms`);
  assert.ok(Math.max(...took) <= 100, `${Math.max(...took)} ms`);
});

test("whoever has shown no token is let go soon, and a second Host is refused", async (t) => {
  const studio = await startStudio(t);
  const begun = performance.now();
  assert.equal(await speak(studio, `GET /api/hello HTTP/1.1\r\nHost: ${studio.host}\r\n`), "");
  assert.ok(performance.now() - begun < 9_000);
  const head = `Authorization: Bearer ${studio.token}\r\n`;
  assert.match(await speak(studio, `GET /api/hello HTTP/1.1\r\nHost: ${studio.host}\r\nHost: evil.example\r\n${head}\r\n`), /^HTTP\/1.1 400/);
  assert.match(await speak(studio, `GET /api/hello HTTP/1.1\r\nHost: evil.example\r\nHost: ${studio.host}\r\n${head}\r\n`), /^HTTP\/1.1 400/);
});

test("a page that takes nothing is let go of; one that reads is not", async (t) => {
  const studio = await startStudio(t);
  const { port } = new URL(studio.origin);
  const hello = `GET /ws HTTP/1.1\r\nHost: ${studio.host}\r\nOrigin: ${studio.origin}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Protocol: haptogram.1, token.${studio.token}\r\n\r\n`;
  const open = () => new Promise((done) => {
    const socket = connect(port, "127.0.0.1", () => socket.write(hello));
    socket.once("data", () => done(socket));
  });
  /** A frame of text, masked by zeros. */
  const frame = (text) => {
    const head = Buffer.alloc(14);
    head.set([0x81, 0xff]);
    head.writeBigUInt64BE(BigInt(text.length), 2);
    return Buffer.concat([head, Buffer.from(text)]);
  };
  const long = frame(JSON.stringify({ t: "upload", n: 1, scene: "x".repeat(900_000) })); // its answer quotes the name
  const [dead, slow] = [await open(), await open()];
  let taken = 0;
  slow.on("data", (bytes) => (taken += bytes.length));
  dead.pause();
  let gone = false;
  for (const [socket, told] of [[dead, () => (gone = true)], [slow, () => assert.fail("it took all")]]) socket.on("error", () => undefined).on("close", told);
  for (let i = 0; i < 30; i++) {
    for (const socket of [dead, slow]) socket.write(long);
    await sleep(10);
  }
  const waited = performance.now();
  const beat = frame(JSON.stringify({ t: "beat", hidden: false }).padEnd(70_000)); // shorter ones have another head
  const again = setInterval(() => [dead, slow].forEach((socket) => socket.destroyed || socket.write(socket === dead ? long : beat)), 500);
  t.after(() => clearInterval(again));
  while (!gone) {
    assert.ok(performance.now() - waited < 30_000, "it was kept");
    await sleep(100);
  }
  for (const end = performance.now() + 30_000; taken < 30 * 900_000; await sleep(100)) assert.ok(performance.now() < end, `what is read is sent, and ${taken} bytes were`);
  slow.removeAllListeners("close");
  slow.destroy();
  assert.equal((await ask(studio, "/api/hello", { headers: { Authorization: `Bearer ${studio.token}` } })).status, 200);
});

test("a project's text becomes a document, and a document a project's text", async (t) => {
  const studio = await startStudio(t);
  const headers = { Authorization: `Bearer ${studio.token}` };
  const post = async (path, body) => ask(studio, path, { method: "POST", headers, body });
  const text = 'format = "haptogram-project-1"\nam = "csv:beat.csv"\n\n[[shape]]\nfile = "heart.ply"\nup = "y"\n';
  const read = JSON.parse((await post("/api/document", text)).text);
  assert.deepEqual(read, { document: { format: "haptogram-project-1", am: "csv:beat.csv", shape: [{ file: "heart.ply", up: "y" }] }, files: ["heart.ply", "beat.csv"] });
  const written = JSON.parse((await post("/api/project", JSON.stringify(read.document))).text);
  assert.deepEqual(written, { text, files: read.files });
  assert.equal((await post("/api/document", "format = 1")).status, 422);
  assert.equal((await post("/api/project", "{")).status, 422);
  assert.equal((await ask(studio, "/api/files?name=beat.csv", { headers })).status, 422);
  await post("/api/files?name=beat.csv", "1,2");
  assert.equal((await ask(studio, "/api/files?name=beat.csv", { headers })).text, "1,2");
  assert.equal((await ask(studio, "/api/files?name=beat.csv")).status, 401);
});

test("Ctrl-C ends the server, and a port that is taken is said", async (t) => {
  const studio = await startStudio(t);
  await assert.rejects(run("studio", "--no-browser", "--port", new URL(studio.origin).port), /cannot be listened at/);
  studio.child.kill("SIGINT");
  assert.deepEqual(await studio.ended, { code: 0, signal: null, said: "" });
});

test("only the loopback interface is listened at", async (t) => {
  const studio = await startStudio(t);
  const { port } = new URL(studio.origin);
  const listeners = ["tcp", "tcp6"].map((kind) => readFileSync(`/proc/net/${kind}`, "utf8")).join("\n").split("\n").map((line) => line.trim().split(/\s+/));
  const ours = listeners.filter((fields) => fields[3] === "0A" && fields[1].endsWith(`:${Number(port).toString(16).toUpperCase().padStart(4, "0")}`));
  assert.deepEqual(ours.map((fields) => fields[1].split(":")[0]), ["0100007F"]);
});

test("the usual port is taken when it is free, so that the browser finds what it kept", async (t) => {
  const free = await new Promise((done) => {
    const listener = createServer().on("error", () => done(false)).listen(41040, "127.0.0.1", () => listener.close(() => done(true)));
  });
  const [first, second] = [await startStudio(t), await startStudio(t)];
  if (free) assert.equal(new URL(first.origin).port, "41040");
  assert.notEqual(first.origin, second.origin);
});

test("a project that cannot be opened is said at once", async () => {
  await assert.rejects(run("studio", "--no-browser", "/nowhere/project.toml"), /nowhere/);
});

test("without the built page the server says what is missing", async (t) => {
  await assert.rejects(run("studio", "--no-browser", "--page", "/nowhere"), /page\.json/);
});
