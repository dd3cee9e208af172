// SPDX-License-Identifier: Apache-2.0
// A serial port of the browser (Web Serial), which carries bytes for the engine's board and knows nothing of what they mean. The page lets
// the user choose it; the board's Worker opens it, so that no byte waits for what the page draws.

/** As much of Web Serial as is used; TypeScript's own types have none of it. */
interface SerialPort extends EventTarget {
  readonly readable: ReadableStream<Uint8Array<ArrayBuffer>> | null;
  readonly writable: WritableStream<Uint8Array> | null;
  open(options: { baudRate: number; bufferSize: number }): Promise<void>;
  close(): Promise<void>;
  setSignals(signals: { break: boolean }): Promise<void>;
  getInfo(): { usbVendorId?: number; usbProductId?: number };
}

const serial = (navigator as { serial?: { requestPort(): Promise<SerialPort>; getPorts(): Promise<SerialPort[]> } }).serial;

/** Whether this browser lets pages use serial ports. */
export const hasSerial = serial !== undefined;

const bufferSize = 16_384; // for what arrives while the Worker computes
const mostAtOnce = 512; // bytes that are handed to the browser before the next can be taken back

export type FromPort = { opened: true } | { lost: string } | { received: Uint8Array<ArrayBuffer> };

/** A port that the user has chosen, as one thread tells another: ports themselves cannot be sent. */
export interface Chosen {
  /** of the ports that the page may use, in the browser's order */
  place: number;
  /** what it is called: browsers tell of its adapter alone */
  name: string;
}

function nameOf(port: SerialPort): string {
  const { usbVendorId, usbProductId } = port.getInfo();
  const hex = (number: number): string => number.toString(16).padStart(4, "0");
  return usbVendorId === undefined ? "a serial port" : `USB ${hex(usbVendorId)}:${hex(usbProductId ?? 0)}`;
}

/** Lets the user choose, which a browser only does when a button was pressed. @throws DOMException when none is chosen */
export async function choosePort(): Promise<Chosen> {
  if (!serial) throw new Error("This browser cannot reach boards: Chrome, Edge and Chromium can");
  const port = await serial.requestPort();
  return { place: (await serial.getPorts()).indexOf(port), name: nameOf(port) };
}

async function find({ place, name }: Chosen): Promise<SerialPort> {
  if (!serial) throw new Error("this browser lets no Worker use ports; take a newer Chrome, Edge or Chromium");
  const port = (await serial.getPorts())[place];
  if (!port || nameOf(port) !== name) throw new Error("ports were plugged or pulled meanwhile; choose the board again");
  return port;
}

export class Port {
  private port: SerialPort | undefined; // once it is found
  private queue: Uint8Array[] = [];
  private writer: WritableStreamDefaultWriter<Uint8Array> | undefined;
  private reader: ReadableStreamDefaultReader<Uint8Array<ArrayBuffer>> | undefined;
  private reading: Promise<void> = Promise.resolve();
  private pumping = false;
  private isOpen = false; // and can be used
  private isHeld = false; // until it is closed, whatever became of it
  private steps: Promise<void> = Promise.resolve(); // opening and closing, one after the other

  /** @param before  what must have ended before this one is used */
  constructor(private readonly chosen: Chosen, private readonly told: (told: FromPort) => void, before: Promise<void>) {
    this.steps = before;
  }

  open(baudRate: number): void {
    this.next(async () => {
      await this.end();
      this.port ??= await find(this.chosen);
      await this.port.open({ baudRate, bufferSize });
      this.isOpen = this.isHeld = true;
      this.writer = this.port.writable?.getWriter();
      this.reading = this.read();
      this.told({ opened: true });
    });
  }

  async close(): Promise<void> {
    this.next(async () => await this.end());
    await this.steps;
  }

  write(bytes: Uint8Array): void {
    for (let at = 0; at < bytes.length; at += mostAtOnce) this.queue.push(bytes.subarray(at, at + mostAtOnce));
    if (!this.pumping) void this.pump();
  }

  /** Takes back what has not left: what waits here, and what the browser's own buffers hold. */
  discard(): void {
    this.queue = [];
    const writer = this.writer;
    this.writer = undefined;
    void writer?.abort().catch(() => undefined).then(() => {
      writer.releaseLock();
      if (!this.isOpen || this.writer) return;
      this.writer = this.port?.writable?.getWriter();
      if (!this.pumping) void this.pump();
    });
  }

  /** Holds the line low. */
  hold(milliseconds: number): void {
    const signals = async (): Promise<void> => {
      await this.port?.setSignals({ break: true });
      await new Promise((done) => setTimeout(done, milliseconds));
      await this.port?.setSignals({ break: false });
    };
    if (this.isOpen) void signals().catch((error: unknown) => this.lose(error));
  }

  private next(step: () => Promise<void>): void {
    this.steps = this.steps.then(step).catch((error: unknown) => this.lose(error));
  }

  private async end(): Promise<void> {
    if (!this.isHeld) return;
    this.isHeld = false;
    for (const end = performance.now() + 100; this.isOpen && this.queue.length > 0 && performance.now() < end; ) await new Promise((done) => setTimeout(done, 5)); // the last words
    this.isOpen = false;
    this.queue = [];
    const writer = this.writer;
    this.writer = undefined;
    await this.reader?.cancel().catch(() => undefined);
    await this.reading;
    await writer?.close().catch(() => undefined);
    writer?.releaseLock();
    await this.port?.close().catch(() => undefined); // one that was pulled is closed already
  }

  private lose(error: unknown): void {
    this.isOpen = false;
    void this.close();
    this.told({ lost: `the port cannot be used: ${error instanceof Error ? error.message : String(error)}` });
  }

  private async pump(): Promise<void> {
    this.pumping = true;
    while (this.writer && this.queue.length > 0) {
      const [next] = this.queue.splice(0, 1);
      const writer = this.writer;
      try {
        if (next) await writer.write(next);
      } catch (error) {
        if (writer === this.writer && this.isOpen) this.lose(error); // else it was taken back
        break;
      }
    }
    this.pumping = false;
    if (this.writer && this.queue.length > 0 && this.isOpen) void this.pump();
  }

  /** Damaged bytes end a stream, and another begins; a port that is gone has no other. */
  private async read(): Promise<void> {
    while (this.isOpen && this.port?.readable) {
      const reader = this.port.readable.getReader();
      this.reader = reader;
      try {
        for (let more = true; more; ) {
          const { value, done } = await reader.read();
          more = !done;
          if (value) this.told({ received: value });
        }
      } catch {
        // the next reader goes on
      } finally {
        reader.releaseLock();
      }
    }
    if (this.isOpen) this.lose(new Error("it is gone; was its cable pulled?"));
  }
}
