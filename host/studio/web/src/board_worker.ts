// SPDX-License-Identifier: Apache-2.0
// The Worker that speaks to the board of a page without a program: hands on between the page and the libraries.
import { lend } from "./lend";
import type { FromBoard, ToBoard } from "./page_board";
import start, { type Engine } from "./studio_engine.js";

const stepPause = 5; // ms until what is due is looked at again
const tell = (told: FromBoard, moved: Transferable[] = []): void => (postMessage as (message: FromBoard, moved: Transferable[]) => void)(told, moved);
const utf8 = new TextEncoder();

function take(engine: Engine, told: ToBoard): void {
  if ("message" in told) {
    const text = utf8.encode(told.message);
    lend(engine, text, (place) => engine._board_message(place, text.length));
  } else if ("scene" in told) {
    lend(engine, utf8.encode(told.scene), (scene) => lend(engine, new Uint8Array(told.hex), (hex) => engine._board_image(scene, hex, told.hex.byteLength)));
  } else if ("received" in told) {
    lend(engine, told.received, (place) => engine._board_received(place, told.received.length));
  } else if ("lost" in told) {
    lend(engine, utf8.encode(told.lost), (place) => engine._board_lost(place));
  } else {
    engine._board_opened();
  }
}

// What comes before the engine is there waits here.
const early: ToBoard[] = [];
onmessage = ({ data }: MessageEvent<ToBoard>) => void early.push(data);
start({
  text: (text) => tell({ text: new TextDecoder().decode(text) }),
  bulk: () => undefined,
  answer: () => undefined,
  port: (wish) => tell(wish),
}).then(
  (engine) => {
    onmessage = ({ data }: MessageEvent<ToBoard>) => take(engine, data);
    for (const told of early) take(engine, told);
    setInterval(() => engine._board_step(), stepPause);
  },
  (error: unknown) => tell({ broken: String(error) }),
);
