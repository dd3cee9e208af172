// SPDX-License-Identifier: Apache-2.0
// The page's own engine, for a page that no program serves: the libraries as WebAssembly, in Workers (worker.ts). One answers what is
// shown while a design changes; another does what takes long, so that nothing waits for it.
import { type Event, Link, type Message, wrongIn } from "./link";
import { PageBoard } from "./page_board";
import { hasSerial } from "./serial";
import { SlowWork } from "./slow_work";
import { type FromWorker, startWorker, type ToWorker } from "./workers";

const takesLong = (target: string): boolean => target.startsWith("/api/field") || target.startsWith("/api/report");

export class InPage extends Link {
  readonly boards = hasSerial ? "serial" : "none";
  private readonly quick = startWorker((told) => this.hear(told));
  private readonly slow = new SlowWork((told) => this.hear(told));
  private readonly documents = new Map<number, unknown>(); // of scenes under way, by their message
  private readonly waiting = new Map<number, (answer: { status: number; body: ArrayBuffer }) => void>();
  private readonly board = new PageBoard(
    (text) => this.tell(JSON.parse(text) as Event),
    async (scene) => await this.request("GET", `/api/take?scene=${scene}&as=hex`),
  );
  private requests = 0;
  private ready = false;

  get open(): boolean {
    return this.ready;
  }

  /** The board has a Worker of its own, so what computes need not be there. */
  stop(): void {
    const n = this.send({ t: "stop" });
    if (!this.open) this.board.take({ t: "stop", n });
  }

  protected post(message: Message & { n: number }): void {
    if (this.board.take(message)) return;
    if (message.t === "cancel") return this.slow.cancel(String(message["what"]));
    if (message.t === "analyze" || message.t === "path") return this.slow.ask(message);
    if (message.t === "scene") this.documents.set(message.n, message["document"]);
    this.quick.postMessage({ message: JSON.stringify(message) } satisfies ToWorker);
  }

  protected async request(method: string, target: string, body?: Blob): Promise<Blob> {
    const request = ++this.requests;
    const asked = { request, method, target, body: body ? await body.arrayBuffer() : new ArrayBuffer(0) } satisfies ToWorker;
    const answer = await new Promise<{ status: number; body: ArrayBuffer }>((answered) => {
      this.waiting.set(request, answered);
      if (method === "POST" && target.startsWith("/api/files")) this.slow.keep(asked);
      if (takesLong(target)) this.slow.ask(asked);
      else this.quick.postMessage(asked);
    });
    if (answer.status === 200) return new Blob([answer.body]);
    throw wrongIn(new TextDecoder().decode(answer.body));
  }

  private hear(told: FromWorker): void {
    if ("ready" in told) {
      this.ready = true;
      this.tell({ t: "open" });
    } else if ("lost" in told) {
      this.ready = false;
      this.tell({ t: "lost" });
    } else if ("text" in told) {
      const event = JSON.parse(told.text) as Event;
      if (event.t === "scene") this.slow.know(event.scene.name, this.documents.get(event.n));
      if ("n" in event && event.n !== undefined) this.documents.delete(event.n);
      this.tell(event);
    } else if ("bulk" in told) {
      this.receive(told.bulk);
    } else {
      this.waiting.get(told.request)?.(told);
      this.waiting.delete(told.request);
    }
  }
}
