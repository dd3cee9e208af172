// SPDX-License-Identifier: Apache-2.0
// Parts that panels are made of.
import type { ComponentChildren, TargetedKeyboardEvent } from "preact";
import { useId, useState } from "preact/hooks";

/** A number with its unit. It is taken when the field is left or Enter is pressed; arrow keys take steps at once. */
export function NumberField({ label, unit, value, step = 1, least, most, onValue }: { label: string; unit: string; value: number; step?: number; least?: number; most?: number; onValue: (value: number) => void }) {
  const id = useId();
  const [text, setText] = useState(String(value));
  // At once, and not in an effect: one that came after the first key would undo it.
  const [last, setLast] = useState(value);
  if (last !== value) {
    setLast(value);
    setText(String(value));
  }
  const take = (given: string): void => {
    const number = Number(given.replace(",", "."));
    if (given.trim() === "" || !Number.isFinite(number) || (least !== undefined && number < least) || (most !== undefined && number > most)) return setText(String(value));
    if (number !== value) onValue(number);
  };
  // What stands in the field, not what was rendered last: keys may come faster than the page is drawn.
  const key = (event: TargetedKeyboardEvent<HTMLInputElement>): void => {
    const given = event.currentTarget.value;
    if (event.key === "Enter") take(given);
    const way = event.key === "ArrowUp" ? 1 : event.key === "ArrowDown" ? -1 : 0;
    if (way === 0) return;
    event.preventDefault();
    const size = step * (event.shiftKey ? 10 : event.altKey ? 0.1 : 1);
    take(String(Number((Number(given) + way * size).toPrecision(12))));
  };
  return (
    <div class="field">
      <label for={id}>{label}</label>
      <input id={id} type="text" inputMode="decimal" value={text} onInput={(e) => setText(e.currentTarget.value)} onBlur={(e) => take(e.currentTarget.value)} onKeyDown={key} />
      <span class="unit">{unit}</span>
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

export function Row({ name, value, unit, mark }: { name: string; value: string; unit: string; mark?: string | undefined }) {
  return <tr class={mark ? "low" : ""}><th scope="row">{name}</th><td>{value}</td><td class="unit">{unit}{mark && <span class="mark"> ▲ {mark}</span>}</td></tr>;
}
