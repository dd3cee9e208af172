// SPDX-License-Identifier: Apache-2.0
// The Workers that have the page's own engine (worker.ts), and what is said to them.

/** What a Worker is told: a message, or a request that it answers by its number. */
export type ToWorker = { message: string } | { request: number; method: string; target: string; body: ArrayBuffer };
/** What it tells: that it is there or cannot be, an answer to a message as text or in bulk, or to a request. */
export type FromWorker = { ready: true } | { lost: string } | { text: string } | { bulk: ArrayBuffer } | { request: number; status: number; body: ArrayBuffer };

export function startWorker(told: (told: FromWorker) => void): Worker {
  const worker = new Worker("worker.js", { type: "module" });
  worker.onmessage = ({ data }: MessageEvent<FromWorker>) => told(data);
  worker.onerror = ({ message }) => told({ lost: message });
  return worker;
}
