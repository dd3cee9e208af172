// SPDX-License-Identifier: Apache-2.0
// What Emscripten makes of ../../wasm, which lies beside the page's files.
export interface Engine {
  HEAPU8: Uint8Array;
  _malloc(bytes: number): number;
  _free(place: number): void;
  _take_message(text: number, bytes: number): void;
  _take_request(method: number, target: number, body: number, bytes: number): void;
  _board_message(text: number, bytes: number): void;
  _board_image(scene: number, hex: number, bytes: number): void;
  _board_opened(): void;
  _board_lost(why: number): void;
  _board_received(bytes: number, count: number): void;
  _board_step(): void;
}
export default function engine(told: {
  text(utf8: Uint8Array<ArrayBuffer>): void;
  bulk(bytes: Uint8Array<ArrayBuffer>): void;
  answer(status: number, body: Uint8Array<ArrayBuffer>): void;
  port(wish: { open: number } | { write: Uint8Array } | { discard: true } | { hold: number } | { close: true }): void;
}): Promise<Engine>;
