// SPDX-License-Identifier: Apache-2.0
// What an object is made for: the array, and the board that drives it.
import { Choice } from "./controls";
import type { ProjectDocument } from "./document";
import type { Hello } from "./link";

type Changes = Partial<Record<"array" | "board", string | undefined>>;

const named = (name: string): [string, string] => [name, name];

export function InstrumentFields({ hello, now, set }: { hello: Hello | undefined; now: ProjectDocument; set: (changes: Changes) => void }) {
  const array = now.array ?? "tile-10x10";
  const board = now.board ?? "";
  const boards = hello?.boards ?? [];
  // A board has as many channels as its own array has elements.
  const chosen = (name: string): void => set({ board: name || undefined, array: boards.find((each) => each.name === name)?.array ?? now.array });
  return (
    <>
      <Choice label="Array" value={array} choices={[...new Set([...(hello?.arrays ?? []), array])].map(named)} onValue={(name) => set({ array: name })} />
      <Choice label="For board" value={board} choices={[["", "any with enough channels"], ...[...new Set([...boards.map(({ name }) => name), ...(board ? [board] : [])])].map(named)]} onValue={chosen} />
    </>
  );
}
