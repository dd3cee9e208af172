// SPDX-License-Identifier: Apache-2.0
// Parts that panels are made of.
import type { ComponentChildren, TargetedKeyboardEvent } from "preact";
import { useId, useState } from "preact/hooks";

const millimetresIn: Record<string, number> = { mm: 1, cm: 10, m: 1000 };

/** What was typed as a number in the field's unit: also "15 cm" for one in mm, and sums such as "130-12". */
export function numberOf(given: string, unit: string): number | undefined {
  const words = given.trim().replaceAll(",", ".").match(/^((?:[+-]?\s*\d*\.?\d+(?:e[+-]?\d+)?\s*)+)(mm|cm|m)?$/i);
  if (!words?.[1]) return undefined;
  const terms = words[1].match(/[+-]?\s*\d*\.?\d+(?:e[+-]?\d+)?/gi) ?? [];
  const sum = terms.reduce((total, term) => total + Number(term.replaceAll(/\s/g, "")), 0);
  const factor = words[2] === undefined ? 1 : unit === "mm" ? millimetresIn[words[2].toLowerCase()] : words[2] === unit ? 1 : undefined;
  return factor === undefined || !Number.isFinite(sum) ? undefined : sum * factor;
}

interface NumberProps {
  label: string;
  unit: string;
  value: number | undefined;
  step?: number;
  least?: number;
  most?: number;
  whole?: boolean;
  /** what an empty field means; without it, there is always a number */
  empty?: string;
  onValue: (value: number | undefined) => void;
}

/** The input of a number with its unit. What cannot be taken stays in it and is told; the last good value stays in use. */
function NumberInput({ id, label, axis, unit, value, step = 1, least, most, whole, empty, onValue, onWrong, wrong }: NumberProps & { id: string; axis?: string; onWrong: (wrong: string) => void; wrong: string }) {
  const shown = value === undefined ? "" : String(value);
  const [text, setText] = useState(shown);
  // At once, and not in an effect: one that came after the first key would undo it.
  const [last, setLast] = useState(shown);
  if (last !== shown) {
    setLast(shown);
    setText(shown);
  }
  const limits = `${least === undefined ? (most === undefined ? "" : `at most ${most}`) : most === undefined ? `at least ${least}` : `${least} to ${most}`}`;
  const take = (given: string): void => {
    if (given.trim() === "" && empty !== undefined) {
      onWrong("");
      return value === undefined ? undefined : onValue(undefined);
    }
    const number = numberOf(given, unit);
    if (number === undefined || (whole && !Number.isInteger(number)) || (least !== undefined && number < least) || (most !== undefined && number > most))
      return onWrong(`${label}: “${given}” is no ${whole ? "whole " : ""}number${limits === "" ? "" : ` of ${limits}${unit && ` ${unit}`}`}; ${shown === "" ? "it stays empty" : `${shown} stays`}.`);
    onWrong("");
    if (number !== value) onValue(number);
    else setText(shown);
  };
  // What stands in the field, not what was rendered last: keys may come faster than the page is drawn.
  const key = (event: TargetedKeyboardEvent<HTMLInputElement>): void => {
    const given = event.currentTarget.value;
    if (event.key === "Enter") take(given);
    const way = event.key === "ArrowUp" ? 1 : event.key === "ArrowDown" ? -1 : 0;
    if (way === 0) return;
    event.preventDefault();
    const size = step * (event.shiftKey ? 10 : event.altKey ? 0.1 : 1);
    take(String(Number(((numberOf(given, unit) ?? 0) + way * size).toPrecision(12))));
  };
  return (
    <span class={wrong ? "box wrong" : "box"}>
      {axis && <span class="axis" aria-hidden="true">{axis}</span>}
      <input id={id} type="text" inputMode="decimal" value={text} placeholder={empty} aria-label={axis && label} aria-invalid={wrong !== ""} aria-describedby={wrong ? `${id}-wrong` : undefined} onInput={(e) => setText(e.currentTarget.value)} onBlur={(e) => take(e.currentTarget.value)} onKeyDown={key} />
      {unit && <span class="unit">{unit}</span>}
    </span>
  );
}

/** A number with its unit. It is taken when the field is left or Enter is pressed; arrow keys take steps at once. */
export function NumberField(props: Omit<NumberProps, "onValue" | "value" | "empty"> & { value: number; onValue: (value: number) => void }) {
  return <MaybeField {...props} onValue={(value) => value !== undefined && props.onValue(value)} />;
}

/** A word that is taken when its field is left. What is typed stays while the page draws itself anew. @param onWord  what is not taken is gone */
export function WordField({ label, name, value, hint, id, onWord }: { label: string; name?: string; value: string; hint?: string; id?: string; onWord: (word: string) => void }) {
  const own = useId();
  const [typed, setTyped] = useState<string>();
  const take = (given: string): void => {
    setTyped(undefined);
    if (given.trim() !== value) onWord(given.trim());
  };
  return (
    <div class="field">
      <label for={id ?? own}>{label}</label>
      <input id={id ?? own} type="text" class="name" aria-label={name} placeholder={hint} value={typed ?? value} onInput={(e) => setTyped(e.currentTarget.value)} onBlur={(e) => take(e.currentTarget.value)} onKeyDown={(e) => e.key === "Enter" && take(e.currentTarget.value)} />
    </div>
  );
}

/** The same for a number that need not be there. */
export function MaybeField(props: NumberProps) {
  const id = useId();
  const [wrong, setWrong] = useState("");
  return (
    <>
      <div class="field">
        <label for={id}>{props.label}</label>
        <NumberInput {...props} id={id} wrong={wrong} onWrong={setWrong} />
      </div>
      {wrong && <p class="wrong-value" id={`${id}-wrong`} role="alert">{wrong}</p>}
    </>
  );
}

const axes = ["x", "y", "z"];

/** Three numbers, along or about the axes. @param each  what one is called, before the axis */
export function PointField({ label, each, unit, value, step, onValue }: { label: string; each: string; unit: string; value: number[]; step?: number; onValue: (value: number[]) => void }) {
  const id = useId();
  const [wrong, setWrong] = useState<string[]>(["", "", ""]);
  return (
    <div class="point" role="group" aria-label={label}>
      <span>{label}</span>
      <div class="three">
        {axes.map((axis, i) => (
          <NumberInput key={axis} id={`${id}-${axis}`} axis={axis} label={`${each} ${axis}`} unit={unit} value={value[i] ?? 0} {...(step === undefined ? {} : { step })} wrong={wrong[i] ?? ""} onWrong={(text) => setWrong((all) => all.map((old, k) => (k === i ? text : old)))} onValue={(number) => number !== undefined && onValue(axes.map((_, k) => (k === i ? number : value[k] ?? 0)))} />
        ))}
      </div>
      {axes.map((axis, i) => wrong[i] && <p key={axis} class="wrong-value" id={`${id}-${axis}-wrong`} role="alert">{wrong[i]}</p>)}
    </div>
  );
}

export function Choice({ label, value, choices, onValue }: { label: string; value: string; choices: [string, string][]; onValue: (value: string) => void }) {
  const id = useId();
  return (
    <div class="field">
      <label for={id}>{label}</label>
      <select id={id} value={value} onChange={(e) => onValue(e.currentTarget.value)}>
        {choices.map(([key, name]) => <option key={key} value={key}>{name}</option>)}
      </select>
    </div>
  );
}

export function Panel({ title, children }: { title: string; children: ComponentChildren }) {
  return <section><h2>{title}</h2>{children}</section>;
}

/** What is seldom needed. @param what  it hides */
export function More({ what, children }: { what: string; children: ComponentChildren }) {
  return <details class="more"><summary>More: {what}</summary>{children}</details>;
}

export function Row({ name, value, unit, mark }: { name: string; value: string; unit: string; mark?: string | undefined }) {
  return <tr class={mark ? "low" : ""}><th scope="row">{name}</th><td>{value}</td><td class="unit">{unit}{mark && <span class="mark"> ▲ {mark}</span>}</td></tr>;
}
