// SPDX-License-Identifier: Apache-2.0
// What takes long, in a Worker of its own, one after the other: the analysis of each focal point, paths, fields and reports as files. A
// Worker hears nothing while it computes, so work that nobody waits for any more ends with its Worker, and the next has another.
import type { Message } from "./link";
import { type FromWorker, startWorker, type ToWorker } from "./workers";

type Request = Extract<ToWorker, { request: number }>;
type Work = (Message & { n: number }) | Request;

const mostScenes = 16;
const isRequest = (work: Work): work is Request => "request" in work;

export class SlowWork {
  private worker: Worker | undefined; // none before its first work
  private known = new Set<string>(); // scenes that it has
  private readonly queue: Work[] = []; // the first is under way
  private readonly documents = new Map<string, unknown>(); // of scenes, by their name
  private readonly files = new Map<string, Request>(); // that were sent, by where to

  constructor(private readonly told: (told: FromWorker) => void) {}

  /** A scene that work may be for. */
  know(scene: string, document: unknown): void {
    this.documents.delete(scene);
    this.documents.set(scene, document);
    const [oldest] = this.documents.keys();
    if (this.documents.size > mostScenes && oldest !== undefined) this.documents.delete(oldest);
  }

  /** A file that scenes may name. */
  keep(file: Request): void {
    this.files.set(file.target, file);
    if (this.worker) this.send(file);
  }

  ask(work: Work): void {
    this.queue.push(work);
    if (this.queue.length === 1) this.begin();
  }

  /** Ends the messages of a kind. */
  cancel(what: string): void {
    const first = this.queue[0];
    const others = this.queue.filter((work) => isRequest(work) || work.t !== what);
    if (others.length === this.queue.length) return;
    this.queue.splice(0, this.queue.length, ...others);
    if (first === this.queue[0]) return;
    this.end();
    this.begin();
  }

  private begin(): void {
    const work = this.queue[0];
    if (!work) return;
    if (!this.worker) {
      this.worker = startWorker((told) => this.hear(told));
      for (const file of this.files.values()) this.send(file);
    }
    const scene = isRequest(work) ? new URLSearchParams(work.target.split("?")[1]).get("scene") : work["scene"];
    if (typeof scene === "string" && !this.known.has(scene) && this.documents.has(scene)) {
      if (this.known.size === mostScenes) this.known = new Set(); // it forgets the oldest
      this.known.add(scene);
      this.worker.postMessage({ message: JSON.stringify({ t: "scene", n: 0, document: this.documents.get(scene) }) } satisfies ToWorker);
    }
    this.worker.postMessage(isRequest(work) ? work : ({ message: JSON.stringify(work) } satisfies ToWorker));
  }

  /** A file's answer is not waited for: the other Worker gives it. */
  private send(file: Request): void {
    this.worker?.postMessage({ ...file, request: 0 });
  }

  private end(): void {
    this.worker?.terminate();
    this.worker = undefined;
    this.known = new Set();
  }

  /** What is under way cannot be done; the next work has another Worker. */
  private fail(why: string): void {
    this.end();
    const work = this.queue.shift();
    if (!work) return;
    const error = { where: "", message: `the browser ended this computation, perhaps for want of memory: ${why}` };
    if (isRequest(work)) this.told({ request: work.request, status: 500, body: new TextEncoder().encode(JSON.stringify({ error })).buffer });
    else this.told({ text: JSON.stringify({ t: "failed", n: work.n, error }) });
    this.begin();
  }

  private hear(told: FromWorker): void {
    if ("ready" in told) return;
    if ("lost" in told) return this.fail(told.lost);
    const work = this.queue[0];
    if (!work) return;
    const ends = isRequest(work)
      ? "request" in told && told.request === work.request
      : "text" in told && (JSON.parse(told.text) as { n?: number }).n === work.n;
    if (!ends) return; // of a scene or a file, which the page has already
    this.queue.shift();
    this.told(told);
    this.begin();
  }
}
