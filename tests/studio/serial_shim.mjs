// SPDX-License-Identifier: Apache-2.0
// Web Serial for a browser without ports: the page's port leads to a board's, and what it writes is kept.
import { spawn } from "node:child_process";
import { fileURLToPath } from "node:url";

const script = fileURLToPath(new URL("./serial_line.py", import.meta.url));

/** Runs in the page before its own scripts: as much of the interface as a browser has. */
function install() {
  let give; // what arrives goes here
  class SerialPort extends EventTarget {
    readable = null;
    writable = null;
    getInfo() {
      return { usbVendorId: 0x0403, usbProductId: 0x6010 };
    }
    async open({ baudRate }) {
      if (this.readable) throw new DOMException("The port is already open.", "InvalidStateError");
      await window.shimOpen(baudRate);
      this.readable = new ReadableStream({ start: (controller) => void (give = controller), cancel: () => void (give = undefined) });
      this.#takeWrites();
    }
    #takeWrites() {
      this.writable = new WritableStream({
        write: async (bytes) => await window.shimWrite(Array.from(bytes)),
        abort: () => this.#takeWrites(),
      });
    }
    async setSignals(signals) {
      await window.shimSignals(signals);
    }
    async close() {
      if (this.readable?.locked || this.writable?.locked) throw new TypeError("Cannot close a port whose streams are locked");
      this.readable = this.writable = null;
      await window.shimClose();
    }
    unplug() {
      const controller = give;
      give = undefined;
      this.readable = null;
      controller?.error(new DOMException("The device has been lost.", "NetworkError"));
    }
  }
  const port = new SerialPort();
  window.shimGive = (bytes) => give?.enqueue(Uint8Array.from(bytes));
  window.shimUnplug = () => port.unplug();
  const requestPort = async () => {
    if (!navigator.userActivation.isActive) throw new DOMException("Must be handling a user gesture", "SecurityError");
    if (window.shimRefuses) throw new DOMException("No port selected by the user.", "NotFoundError");
    return port;
  };
  Object.defineProperty(navigator, "serial", { configurable: true, value: { requestPort } });
}

/** @param path  of the board's port */
export async function serialShim(page, path) {
  const shim = { written: [], rates: [], signals: [], child: undefined, cut: false, end() { this.child?.kill("SIGKILL"); this.child = undefined; } };
  await page.exposeFunction("shimOpen", (baud) => {
    shim.rates.push(baud);
    shim.end();
    const child = spawn("python3", [script, "port", path, baud], { stdio: ["pipe", "pipe", "inherit"] });
    shim.child = child;
    child.stdin.on("error", () => undefined);
    child.stdout.on("data", (bytes) => void page.evaluate((given) => window.shimGive(given), [...bytes]).catch(() => undefined));
  });
  await page.exposeFunction("shimWrite", (bytes) => {
    shim.written.push(...bytes.map((byte) => ({ byte, when: performance.now() })));
    if (!shim.cut) shim.child?.stdin.write(Uint8Array.from(bytes));
  });
  await page.exposeFunction("shimSignals", (signals) => void shim.signals.push(signals));
  await page.exposeFunction("shimClose", () => shim.end());
  await page.addInitScript(install);
  return shim;
}

/** Another port that leads to a board's, and what a host writes there. */
export async function tap(t, path) {
  const child = spawn("python3", [script, "tap", path, 1000000], { stdio: ["ignore", "pipe", "inherit"] });
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
