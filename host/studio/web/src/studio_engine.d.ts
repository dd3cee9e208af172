// SPDX-License-Identifier: Apache-2.0
// What Emscripten makes of ../../wasm, which lies beside the page's files.
export interface Engine {
  HEAPU8: Uint8Array;
  _malloc(bytes: number): number;
  _free(place: number): void;
  _take_message(text: number, bytes: number): void;
  _take_request(method: number, target: number, body: number, bytes: number): void;
}
export default function engine(told: {
  text(utf8: Uint8Array<ArrayBuffer>): void;
  bulk(bytes: Uint8Array<ArrayBuffer>): void;
  answer(status: number, body: Uint8Array<ArrayBuffer>): void;
}): Promise<Engine>;
