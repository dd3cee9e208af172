// SPDX-License-Identifier: Apache-2.0
// How often an object is played and how strong it is, and what it is made for: the array, and the board that drives it.
import { Choice, MaybeField, NumberField } from "./controls";
import type { ProjectDocument } from "./document";
import { labels } from "./labels";
import type { Hello } from "./link";

type Changes = { loops?: number | undefined; amplitude?: number | undefined; fade?: string | undefined; array?: string | undefined; board?: string | undefined };
interface Given {
  now: ProjectDocument;
  set: (changes: Changes) => void;
}

const named = (name: string): [string, string] => [name, name];

export function Strength({ now, set }: Given) {
  return <NumberField label={labels.amplitude} unit="%" value={Number((100 * (now.amplitude ?? 1)).toPrecision(12))} step={5} least={0.1} most={100} onValue={(percent) => set({ amplitude: percent === 100 ? undefined : Number((percent / 100).toPrecision(12)) })} />;
}

const sides: [string, string][] = [["", "evenly strong"], ["left", "at the left (−x)"], ["right", "at the right (+x)"], ["front", "in front (−y)"], ["back", "at the back (+y)"], ["below", "below (−z)"], ["above", "above (+z)"]];

/** A side at which the object is strongest, and how strong it is at the other. */
export function Strongest({ now, set }: Given) {
  const [side = "", share = "0.5"] = (now.fade ?? "").split(":");
  return (
    <>
      <Choice label={labels.fade} value={side} choices={sides} onValue={(chosen) => set({ fade: chosen === "" ? undefined : `${chosen}:${share}` })} />
      {side !== "" && <NumberField label="At the other side" unit="%" value={Number((100 * Number(share)).toPrecision(12))} step={5} least={0} most={99} onValue={(percent) => set({ fade: `${side}:${Number((percent / 100).toFixed(6))}` })} />}
    </>
  );
}

export function InstrumentFields({ hello, now, set }: Given & { hello: Hello | undefined }) {
  const array = now.array ?? "tile-10x10";
  const board = now.board ?? "";
  const boards = hello?.boards ?? [];
  // A board has as many channels as its own array has elements.
  const chosen = (name: string): void => set({ board: name || undefined, array: boards.find((each) => each.name === name)?.array ?? now.array });
  return (
    <>
      <MaybeField label={labels.loops} unit="" empty="on and on" whole value={now.loops || undefined} least={1} most={65535} onValue={(passes) => set({ loops: passes })} />
      <Choice label={labels.array} value={array} choices={[...new Set([...(hello?.arrays ?? []), array])].map(named)} onValue={(name) => set({ array: name })} />
      <Choice label={labels.board} value={board} choices={[["", "any with enough channels"], ...[...new Set([...boards.map(({ name }) => name), ...(board ? [board] : [])])].map(named)]} onValue={chosen} />
    </>
  );
}
