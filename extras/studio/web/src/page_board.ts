// SPDX-License-Identifier: Apache-2.0
// The board of a page without a program. A Worker of its own speaks to it, and has its port (board_worker.ts), so that neither STOP nor a
// byte waits for a field or for the page; this hands on messages and the images of scenes.
import type { Message } from "./link";
import { type Chosen, choosePort } from "./serial";

/** What the board's Worker is told: a message, the image of a scene, or which port it has from now on. */
export type ToBoard = { message: string } | { scene: string; hex: ArrayBuffer } | { port: Chosen };
/** What it tells: that it cannot be, or an answer. */
export type FromBoard = { broken: string } | { text: string };

const ofBoards = new Set(["connect", "disconnect", "upload", "play", "trigger", "stream", "intensity", "modulate", "stop"]);
const mostImages = 4; // that the Worker keeps
const beatPause = 200; // ms between signs of life

export class PageBoard {
  private worker: Worker | undefined; // none before the first board
  private readonly sent: string[] = []; // scenes whose images the Worker has had last
  private stops = 0;

  constructor(
    private readonly told: (text: string) => void,
    private readonly imageOf: (scene: string) => Promise<Blob>,
  ) {}

  /** @return whether the message was one of a board */
  take(message: Message & { n: number }): boolean {
    if (!ofBoards.has(message.t)) return false;
    if (message.t === "stop") this.stops += 1;
    if (message.t === "connect") void this.connect(message).catch((error: unknown) => this.fail(message.n, error));
    else if (typeof message["scene"] === "string") void this.withImage(message, message["scene"]).catch((error: unknown) => this.fail(message.n, error));
    else this.send(message);
    return true;
  }

  private async connect(message: Message & { n: number }): Promise<void> {
    const port = await choosePort().catch((error: unknown) => {
      throw error instanceof DOMException && error.name === "NotFoundError" ? new Error("No board was chosen.") : error;
    });
    this.begin();
    this.tell({ port });
    this.send({ ...message, port: port.name, scene: "" });
  }

  private begin(): void {
    if (this.worker) return;
    const worker = new Worker("board_worker.js", { type: "module" });
    worker.onmessage = ({ data }: MessageEvent<FromBoard>) => this.hear(data);
    worker.onerror = ({ message }) => this.hear({ broken: message });
    this.worker = worker;
    const beat = (): void => this.tell({ message: JSON.stringify({ t: "beat", hidden: document.hidden }) });
    setInterval(beat, beatPause);
    document.addEventListener("visibilitychange", beat);
    addEventListener("pagehide", () => this.tell({ message: JSON.stringify({ t: "stop", n: 0 }) }));
  }

  /** A message about a scene goes behind its image. STOP overtakes it: then it is never sent. */
  private async withImage(message: Message, scene: string): Promise<void> {
    const { stops } = this;
    if (!this.sent.includes(scene)) {
      const hex = await (await this.imageOf(scene)).arrayBuffer();
      if (stops !== this.stops) return;
      this.tell({ scene, hex }, [hex]);
      this.sent.push(scene);
      if (this.sent.length > mostImages) this.sent.shift();
    }
    this.send(message);
  }

  private fail(n: number, error: unknown): void {
    this.told(JSON.stringify({ t: "failed", n, error: { where: "", message: error instanceof Error ? error.message : String(error) } }));
  }

  /** Without a board there is nothing to turn off. */
  private send(message: Message): void {
    if (this.worker) this.tell({ message: JSON.stringify(message) });
    else if (message.t === "stop") this.told(JSON.stringify({ t: "off", n: message["n"], confirmed: true }));
  }

  private tell(told: ToBoard, moved: Transferable[] = []): void {
    this.worker?.postMessage(told, moved);
  }

  private hear(told: FromBoard): void {
    if ("text" in told) this.told(told.text);
    else this.told(JSON.stringify({ t: "notice", message: `What speaks to the board has ended: ${told.broken}. Load the page again; the board's watchdog has turned its outputs off.` }));
  }
}
