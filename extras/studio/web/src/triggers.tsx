// SPDX-License-Identifier: Apache-2.0
// Triggers: what starts a part of the pass while the outputs are on.
import { Choice, MaybeField, NumberField, Panel, PointField, WordField } from "./controls";
import { edit, having, project, type ProjectDocument, type TriggerTable } from "./document";
import { labels } from "./labels";
import type { Trigger } from "./link";
import { type Actions, noProgram, state } from "./state";

const kinds = [["key", "a key"], ["pin", "the board's trigger pin"], ["region", "a hand that enters a region"], ["line", "a line of a script"]] as const;
type Kind = (typeof kinds)[number][0];
const kindOf = ({ on }: TriggerTable): Kind => (on.startsWith("key:") ? "key" : on.startsWith("line:") ? "line" : on === "region" ? "region" : "pin");
const wordOf = ({ on }: TriggerTable): string => on.slice(on.indexOf(":") + 1);
/** As buttons call it. */
const nameOf = (trigger: TriggerTable): string => ({ key: `Key ${wordOf(trigger)}`, line: `Line ${wordOf(trigger)}`, region: "Region", pin: "Pin" })[kindOf(trigger)];

/** The first word of this kind that no other trigger has. */
function freeWord(triggers: TriggerTable[], kind: "key" | "line"): string {
  const all = [..."abcdefghijklmnopqrstuvwxyz0123456789"].map((each) => (kind === "key" ? each : `go-${each}`));
  return all.find((word) => !triggers.some((each) => wordOf(each) === word)) ?? "";
}

function ofKind(of: TriggerTable, kind: Kind, others: TriggerTable[]): TriggerTable {
  const { on: _, center_mm: _c, size_mm: _s, ...part } = of;
  if (kind === "pin") return { on: "pin", ...part };
  if (kind === "region") return { on: "region", center_mm: [0, 0, 150], size_mm: 60, ...part };
  return { on: `${kind}:${freeWord(others, kind)}`, ...part };
}

export function Triggers({ now }: { now: ProjectDocument }) {
  const triggers = now.trigger ?? [];
  const pass = state.scene.value?.pass_s ?? 0;
  /** Changes what the design has now: a hand is quicker than the next drawing of this panel. */
  const put = (changed: (all: TriggerTable[]) => TriggerTable[]): void => {
    const design = project.peek() ?? now;
    const trigger = changed(design.trigger ?? []);
    edit(having(design, { trigger: trigger.length > 0 ? trigger : undefined }));
  };
  const add = (): void => put((all) => [...all, { on: `key:${freeWord(all, "key")}` }]);
  return (
    <Panel title={labels.trigger}>
      {triggers.map((each, i) => {
        const others = triggers.filter((_, k) => k !== i);
        const change = (changes: Partial<Record<keyof TriggerTable, unknown>>): void => put((all) => all.map((old, k) => (k === i ? (Object.fromEntries(Object.entries({ ...old, ...changes }).filter(([, value]) => value !== undefined)) as unknown as TriggerTable) : old)));
        const kind = kindOf(each);
        const word = (text: string): void => {
          const given = kind === "key" ? text.slice(-1) : text;
          if (/^[!-z|}~]([ -~]*[!-~])?$/.test(given) && given.length <= 40 && !others.some((other) => wordOf(other) === given)) change({ on: `${kind}:${given}` });
        };
        return (
          <fieldset key={i} class="trigger">
            <legend>Trigger {i + 1}</legend>
            <Choice label={`Trigger ${i + 1} is`} value={kind} choices={kinds.filter(([key]) => key !== "pin" || kind === "pin" || !others.some(({ on }) => on === "pin")).map(([key, name]): [string, string] => [key, name])} onValue={(key) => put((all) => all.map((old, k) => (k === i ? ofKind(old, key as Kind, all.filter((each) => each !== old)) : old)))} />
            {(kind === "key" || kind === "line") && <WordField label={kind === "key" ? "Key" : "Line"} name={`${kind === "key" ? "Key" : "Line"} of trigger ${i + 1}`} value={wordOf(each)} onWord={word} />}
            {kind === "region" && <PointField label="Centre" each={`Region ${i + 1}`} unit="mm" value={each.center_mm ?? [0, 0, 150]} onValue={(center_mm) => change({ center_mm })} />}
            {kind === "region" && <NumberField label={`Diameter of region ${i + 1}`} unit="mm" value={each.size_mm ?? 60} least={1} most={1000} onValue={(size_mm) => change({ size_mm })} />}
            <NumberField label={`Trigger ${i + 1} plays from`} unit="s" value={each.from_s ?? 0} step={0.1} least={0} onValue={(from_s) => change({ from_s: from_s || undefined })} />
            <MaybeField label={`Trigger ${i + 1} plays to`} unit="s" empty={pass > 0 ? `the end, ${Number(pass.toFixed(3))}` : "the end"} value={each.to_s} step={0.1} least={0.001} onValue={(to_s) => change({ to_s })} />
            <NumberField label={`Trigger ${i + 1} plays so often`} unit="×" value={each.loops ?? 1} least={0} most={65535} whole onValue={(loops) => change({ loops: loops === 1 ? undefined : loops })} />
            {each.loops === 0 && <p class="hint">Until another trigger.</p>}
            <button type="button" onClick={() => put((all) => all.filter((_, k) => k !== i))} aria-label={`Remove trigger ${i + 1}`}>Remove</button>
          </fieldset>
        );
      })}
      <button type="button" class="wide" onClick={add}>Add a trigger</button>
      {readsLines(now) && !noProgram.value && <WordField label="Lines from" name="Pipe of lines" hint="/tmp/lines" value={state.lines.value} onWord={(pipe) => (state.lines.value = pipe)} />}
      <p class="hint">{triggers.length === 0 ? "Play then turns the outputs on and waits: a key, a pin, a hand or a script starts a part of the movement." : "Keys and the pin work here, and each trigger's button in the step Use."}{readsLines(now) && (noProgram.value ? " Lines, and hands that enter a region, need the program." : " Lines come from a named pipe (mkfifo): a script's words, or what “haptogram live --scene PIPE” tells of hands, on a board of its own.")}</p>
    </Panel>
  );
}

/** Whether lines of another program fire some of them. */
export const readsLines = (now: ProjectDocument | undefined): boolean => (now?.trigger ?? []).some((each) => ["line", "region"].includes(kindOf(each)));

/** While a design that has triggers plays: a button for each that is not the board's own. */
export function Firing({ actions, triggers, now }: { actions: Actions; triggers: Trigger[]; now: ProjectDocument }) {
  const tables = now.trigger ?? [];
  if (tables.length !== triggers.length) return null;
  return <><div class="buttons" role="group" aria-label="Triggers">{tables.map((each, i) => (each.on === "pin" ? <span key={i} class="hint">Pin: the board starts it.</span> : <button key={i} type="button" onClick={() => actions.send("trigger", { number: i })}>{nameOf(each)}</button>))}</div>{state.wrongLine.value && <p class="warning">▲ {state.wrongLine.value}</p>}</>;
}

/** The number of the trigger that a key fires. */
export const firedBy = (key: string, now: ProjectDocument | undefined): number => (now?.trigger ?? []).findIndex(({ on }) => on === `key:${key}`);
