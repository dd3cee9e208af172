// SPDX-License-Identifier: Apache-2.0
// How often an object is played and how strong it is, and what it is made for: the array, and the board that drives it.
import { Choice, NumberField } from "./controls";
import type { ProjectDocument } from "./document";
import type { Hello } from "./link";

type Changes = { loops?: number | undefined; amplitude?: number | undefined; array?: string | undefined; board?: string | undefined };

const named = (name: string): [string, string] => [name, name];

export function InstrumentFields({ hello, now, set }: { hello: Hello | undefined; now: ProjectDocument; set: (changes: Changes) => void }) {
  const array = now.array ?? "tile-10x10";
  const board = now.board ?? "";
  const boards = hello?.boards ?? [];
  // A board has as many channels as its own array has elements.
  const chosen = (name: string): void => set({ board: name || undefined, array: boards.find((each) => each.name === name)?.array ?? now.array });
  return (
    <>
      <NumberField label="Passes in all" unit="" value={now.loops ?? 0} least={0} most={65535} onValue={(passes) => set({ loops: Math.round(passes) || undefined })} />
      <p class="hint">0: it is played on and on.</p>
      <NumberField label="Amplitude" unit="%" value={Number((100 * (now.amplitude ?? 1)).toPrecision(12))} step={5} least={0.1} most={100} onValue={(percent) => set({ amplitude: percent === 100 ? undefined : Number((percent / 100).toPrecision(12)) })} />
      <Choice label="Array" value={array} choices={[...new Set([...(hello?.arrays ?? []), array])].map(named)} onValue={(name) => set({ array: name })} />
      <Choice label="For board" value={board} choices={[["", "any with enough channels"], ...[...new Set([...boards.map(({ name }) => name), ...(board ? [board] : [])])].map(named)]} onValue={chosen} />
    </>
  );
}
