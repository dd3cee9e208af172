// SPDX-License-Identifier: Apache-2.0
import type { Engine } from "./studio_engine.js";

/** Calls with bytes that lie in the engine's memory for so long, with a zero behind them. */
export function lend(engine: Engine, bytes: Uint8Array, call: (place: number) => void): void {
  const place = engine._malloc(bytes.length + 1);
  engine.HEAPU8.set(bytes, place);
  engine.HEAPU8[place + bytes.length] = 0;
  call(place);
  engine._free(place);
}
