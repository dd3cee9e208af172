// SPDX-License-Identifier: Apache-2.0
// The Worker of a page without a server: hands on between the page and the libraries. One thing is done at a time, in the order in which
// it was asked for.
import type { FromWorker, ToWorker } from "./workers";
import { lend } from "./lend";
import start, { type Engine } from "./studio_engine.js";

const tell = (told: FromWorker, moved: Transferable[] = []): void => (postMessage as (message: FromWorker, moved: Transferable[]) => void)(told, moved);
const utf8 = new TextEncoder();
let answering = 0; // number of the request

function take(engine: Engine, asked: ToWorker): void {
  if ("message" in asked) {
    const text = utf8.encode(asked.message);
    return lend(engine, text, (place) => engine._take_message(place, text.length));
  }
  answering = asked.request;
  lend(engine, utf8.encode(asked.method), (method) =>
    lend(engine, utf8.encode(asked.target), (target) =>
      lend(engine, new Uint8Array(asked.body), (body) => engine._take_request(method, target, body, asked.body.byteLength)),
    ),
  );
}

// Messages that come before the engine is there wait here.
const early: ToWorker[] = [];
onmessage = ({ data }: MessageEvent<ToWorker>) => void early.push(data);
start({
  text: (text) => tell({ text: new TextDecoder().decode(text) }),
  bulk: ({ buffer }) => tell({ bulk: buffer }, [buffer]),
  answer: (status, { buffer }) => tell({ request: answering, status, body: buffer }, [buffer]),
  port: () => undefined,
}).then(
  (engine) => {
    onmessage = ({ data }: MessageEvent<ToWorker>) => take(engine, data);
    tell({ ready: true });
    for (const asked of early) take(engine, asked);
  },
  (error: unknown) => tell({ lost: String(error) }),
);
