// SPDX-License-Identifier: Apache-2.0
// The Worker that speaks to the board of a page without a program: hands on between the page, the libraries and the port.
import { lend } from "./lend";
import type { FromBoard, ToBoard } from "./page_board";
import { type FromPort, Port } from "./serial";
import start, { type Engine } from "./studio_engine.js";

const stepPause = 5; // ms until what is due is looked at again
const tell = (told: FromBoard): void => (postMessage as (message: FromBoard) => void)(told);
const utf8 = new TextEncoder();
let port: Port | undefined;

function hear(engine: Engine, told: FromPort): void {
  if ("received" in told) lend(engine, told.received, (place) => engine._board_received(place, told.received.length));
  else if ("lost" in told) lend(engine, utf8.encode(told.lost), (place) => engine._board_lost(place));
  else engine._board_opened();
}

function take(engine: Engine, told: ToBoard): void {
  if ("message" in told) {
    const text = utf8.encode(told.message);
    lend(engine, text, (place) => engine._board_message(place, text.length));
  } else if ("scene" in told) {
    lend(engine, utf8.encode(told.scene), (scene) => lend(engine, new Uint8Array(told.hex), (hex) => engine._board_image(scene, hex, told.hex.byteLength)));
  } else {
    const now: Port = new Port(told.port, (each) => now === port && hear(engine, each), port?.close() ?? Promise.resolve());
    port = now;
  }
}

/** What the engine wants of the port. */
function use(wish: Parameters<Parameters<typeof start>[0]["port"]>[0]): void {
  if ("open" in wish) port?.open(wish.open);
  else if ("write" in wish) port?.write(wish.write);
  else if ("discard" in wish) port?.discard();
  else if ("hold" in wish) port?.hold(wish.hold);
  else void port?.close();
}

// What comes before the engine is there waits here.
const early: ToBoard[] = [];
onmessage = ({ data }: MessageEvent<ToBoard>) => void early.push(data);
start({
  text: (text) => tell({ text: new TextDecoder().decode(text) }),
  bulk: () => undefined,
  answer: () => undefined,
  port: use,
}).then(
  (engine) => {
    onmessage = ({ data }: MessageEvent<ToBoard>) => take(engine, data);
    for (const told of early) take(engine, told);
    setInterval(() => engine._board_step(), stepPause);
  },
  (error: unknown) => tell({ broken: String(error) }),
);
