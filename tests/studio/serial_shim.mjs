// SPDX-License-Identifier: Apache-2.0
// Web Serial for a browser without ports: the port of the page's Worker leads to a board's, and what it writes is kept.
import { spawn } from "node:child_process";
import { fileURLToPath } from "node:url";

const line = fileURLToPath(new URL("./serial_line.py", import.meta.url));

/** Runs in the page before its own scripts: a port that the user may choose. The test stands for the user. */
function inPage() {
  const port = { getInfo: () => ({ usbVendorId: 0x0403, usbProductId: 0x6010 }) };
  const requestPort = async () => {
    if (!navigator.userActivation.isActive) throw new DOMException("Must be handling a user gesture", "SecurityError");
    if (window.shimRefuses) throw new DOMException("No port selected by the user.", "NotFoundError");
    return port;
  };
  Object.defineProperty(navigator, "serial", { configurable: true, value: { requestPort, getPorts: async () => [port] } });
}

/** Runs in the board's Worker before its own script: as much of the interface as a browser has. Bytes go through the web host, and so past the page. */
function inWorker() {
  const ask = (what, body) => fetch(`/shim/${what}`, { method: "POST", body });
  class SerialPort extends EventTarget {
    readable = null;
    writable = null;
    #line; // ends what arrives
    getInfo() {
      return { usbVendorId: 0x0403, usbProductId: 0x6010 };
    }
    async open({ baudRate }) {
      if (this.readable) throw new DOMException("The port is already open.", "InvalidStateError");
      const line = (this.#line = new AbortController());
      const arriving = (await fetch(`/shim/open?${baudRate}`, { method: "POST", signal: line.signal })).body.getReader();
      const pull = async (controller) => {
        const { value, done } = await arriving.read().catch(() => ({ done: true }));
        if (!done) return controller.enqueue(value);
        if (line.signal.aborted) return;
        this.readable = null;
        controller.error(new DOMException("The device has been lost.", "NetworkError"));
      };
      this.readable = new ReadableStream({ pull, cancel: () => line.abort() });
      this.#takeWrites();
    }
    #takeWrites() {
      this.writable = new WritableStream({ write: async (bytes) => void (await ask("write", bytes)), abort: () => this.#takeWrites() });
    }
    async setSignals(signals) {
      await ask("signals", JSON.stringify(signals));
    }
    async close() {
      if (this.readable?.locked || this.writable?.locked) throw new TypeError("Cannot close a port whose streams are locked");
      this.readable = this.writable = null;
      this.#line.abort();
      await ask("close");
    }
  }
  const ports = [new SerialPort()];
  void ask(`begin?${"serial" in navigator}`);
  Object.defineProperty(navigator, "serial", { configurable: true, value: { getPorts: async () => ports } });
}

/** @param path  of the board's port. @return what the web host must serve beside the page, and what goes over the line */
export function serialShim(path) {
  const shim = { written: [], rates: [], signals: [], child: undefined, cut: false, workerHasSerial: undefined, end() { this.child?.kill("SIGKILL"); this.child = undefined; } };
  const script = { "Content-Type": "text/javascript" };
  const asked = {
    begin: (given) => void (shim.workerHasSerial = given === "true"),
    write(_, bytes) {
      shim.written.push(...[...bytes].map((byte) => ({ byte, when: performance.now() })));
      if (!shim.cut) shim.child?.stdin.write(bytes);
    },
    signals: (_, bytes) => void shim.signals.push(JSON.parse(String(bytes))),
    close: () => shim.end(),
  };
  function open(baud, response) {
    shim.rates.push(Number(baud));
    shim.end();
    const child = spawn("python3", [line, "port", path, baud], { stdio: ["pipe", "pipe", "inherit"] });
    shim.child = child;
    child.stdin.on("error", () => undefined);
    response.writeHead(200, { "Content-Type": "application/octet-stream" }).flushHeaders();
    child.stdout.on("data", (bytes) => response.write(bytes));
    child.on("exit", () => response.end()); // the cable is pulled
  }
  /** @return whether it was for the shim */
  function serve(url, request, response) {
    if (url.pathname === "/board_worker.js" && url.search === "") return response.writeHead(200, script).end('import "./shim/worker.js";\nimport "./board_worker.js?itself";\n');
    if (url.pathname === "/shim/worker.js") return response.writeHead(200, script).end(`(${inWorker})();\n`);
    const [, what] = url.pathname.match(/^\/shim\/(\w+)$/) ?? [];
    if (what === undefined) return false;
    const chunks = [];
    request.on("data", (chunk) => chunks.push(chunk));
    request.on("end", () => {
      if (what === "open") return open(url.search.slice(1), response);
      asked[what](url.search.slice(1), Buffer.concat(chunks));
      response.writeHead(204).end();
    });
    return true;
  }
  return Object.assign(shim, { serve, before: (page) => page.addInitScript(inPage) });
}

/** Another port that leads to a board's, and what a host writes there. */
export async function tap(t, path) {
  const child = spawn("python3", [line, "tap", path, 1000000], { stdio: ["ignore", "pipe", "inherit"] });
  t.after(() => child.kill("SIGKILL"));
  const chunks = [];
  let head = "";
  const name = new Promise((named) => child.stdout.on("data", (bytes) => {
    if (head.endsWith("\n")) return void chunks.push(...bytes);
    const end = bytes.indexOf(10) + 1 || bytes.length;
    head += String(bytes.subarray(0, end));
    chunks.push(...bytes.subarray(end));
    if (head.endsWith("\n")) named(head.trim());
  }));
  return { port: await name, written: () => chunks };
}

/** The requests in what was written to a line: command and payload as text; numbers and checks are of each session its own. */
export function requests(bytes) {
  const found = [];
  let frame = [];
  for (const byte of bytes) {
    if (byte !== 0) {
      frame.push(byte);
      continue;
    }
    const data = [];
    for (let at = 0; at < frame.length; at += frame[at]) {
      data.push(...frame.slice(at + 1, at + frame[at]));
      if (frame[at] !== 255 && at + frame[at] < frame.length) data.push(0);
    }
    if (data.length >= 4) found.push({ command: data[1], payload: data.slice(2, -2).join(" ") });
    frame = [];
  }
  return found;
}
