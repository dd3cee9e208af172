// SPDX-License-Identifier: Apache-2.0
// Key frames: where the shape is, and how strong, at times between which it moves.
import { useState } from "preact/hooks";
import { Choice, MaybeField, More, NumberField, Panel, PointField } from "./controls";
import { edit, endGesture, having, type KeyFrame, project, type ProjectDocument } from "./document";
import { labels } from "./labels";
import { formsFor, withForm, withoutOldForms } from "./placing";
import { type Actions, state } from "./state";
import { entryAt } from "./tour";

const eases = [["linear", "goes on evenly"], ["smooth", "goes on gently"], ["step", "stays until the next"]] as const;
export const fewPoints = 20; // each focal point of each pass is one that the board must hold
const mostSteps = 190; // in the first second, so that every board holds them
const usualRate = 10; // passes a second

/** Without what a frame has anyway. */
function brief(frame: KeyFrame): KeyFrame {
  const usual: Partial<Record<keyof KeyFrame, unknown>> = { scale: 1, amplitude: 1, am_hz: 0, ease: "linear", mark: false };
  const isUsual = ([key, value]: [string, unknown]): boolean => value === undefined || value === usual[key as keyof KeyFrame] || (Array.isArray(value) && value.every((each) => each === 0));
  return Object.fromEntries(Object.entries(frame).filter((entry) => !isUsual(entry))) as unknown as KeyFrame;
}

const rounded = (seconds: number): number => Number(seconds.toFixed(3));

/** Between its neighbours; the first stays at 0. */
function limitsOf(frames: KeyFrame[], at: number): [number, number] {
  const next = frames[at + 1];
  return at === 0 ? [0, 0] : [rounded((frames[at - 1]?.time_s ?? 0) + 0.001), next ? rounded(next.time_s - 0.001) : 3600];
}

/** Edits a key frame, and marks where the pass is then. */
function choose(actions: Actions, i: number): void {
  state.keyFrame.value = i;
  const [scene, frame] = [state.scene.peek(), project.peek()?.keyframe?.[i]];
  if (scene && frame && state.current.peek() && scene.tour.length > 0) actions.mark(entryAt(scene, Math.min(frame.time_s, scene.pass_s)), false);
}

/** A key frame in the timeline: a click chooses it, dragging and arrow keys move it. @param shown  the times at the timeline's ends */
export function KeyHandle({ actions, number, shown, lane }: { actions: Actions; number: number; shown: { from: number; to: number }; lane: { current: Element | null } }) {
  const [held, setHeld] = useState<{ x: number; time: number; perPixel: number }>();
  const frames = project.value?.keyframe ?? [];
  const time = frames[number]?.time_s ?? 0;
  const part = (time - shown.from) / (shown.to - shown.from);
  if (!held && (part < -1e-6 || part > 1 + 1e-6)) return null;
  const [least, most] = limitsOf(frames, number);
  const move = (to: number): void => {
    const now = project.peek();
    const time_s = Math.min(most, Math.max(least, rounded(to)));
    if (now) edit(having(now, { keyframe: frames.map((each, i) => (i === number ? { ...each, time_s } : each)) }), `key frame ${number}`);
  };
  const take = (event: PointerEvent): void => {
    const width = lane.current?.getBoundingClientRect().width ?? 0;
    if (event.button !== 0 || width === 0) return;
    event.preventDefault();
    (event.currentTarget as Element).setPointerCapture(event.pointerId);
    (event.currentTarget as HTMLElement).focus();
    setHeld({ x: event.clientX, time, perPixel: (shown.to - shown.from) / width });
    state.step.value = "Make";
    choose(actions, number);
  };
  const letGo = (): void => {
    setHeld(undefined);
    endGesture();
  };
  const key = (event: KeyboardEvent): void => {
    const way = event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0;
    if (event.key === "Enter") choose(actions, number);
    if (way === 0) return;
    event.preventDefault();
    state.keyFrame.value = number;
    move(time + way * (event.shiftKey ? 0.1 : 0.01));
    endGesture();
  };
  return (
    <div
      class={state.keyFrame.value === number ? "key-handle chosen" : "key-handle"} role="slider" tabIndex={0} style={{ left: `${100 * Math.min(1, Math.max(0, part))}%` }}
      aria-label={`Time of key frame ${number + 1}`} aria-valuemin={least} aria-valuemax={most} aria-valuenow={time} aria-valuetext={`${time} s`} title={number === 0 ? "The first key frame" : `Key frame ${number + 1}: drag it to another time`}
      onPointerDown={take} onPointerMove={(event) => held && number > 0 && event.clientX !== held.x && move(held.time + (event.clientX - held.x) * held.perPixel)} onPointerUp={letGo} onPointerCancel={letGo} onKeyDown={key}
    />
  );
}

export function KeyFrames({ actions, now }: { actions: Actions; now: ProjectDocument }) {
  const frames = now.keyframe ?? [];
  const put = (keyframe: KeyFrame[] | undefined, of = now): void => edit(withoutOldForms(having(of, { keyframe }), frames));
  const begin = (): void => {
    const points = Math.min(now.points ?? 200, fewPoints);
    const rate_hz = Math.min(now.rate_hz ?? usualRate, Math.floor(mostSteps / points));
    edit(having(now, { keyframe: [{ time_s: 0 }, { time_s: 1 }], points, rate_hz, speed_m_s: undefined, frequency_hz: undefined }));
    state.keyFrame.value = 1;
  };
  if (frames.length === 0)
    return (
      <Panel title={labels.keyframe}>
        <button type="button" class="wide" onClick={begin}>Let it move</button>
        <p class="hint">From key frame to key frame: its place, size, turn and strength. It takes {fewPoints} focal points at most at first, because the board holds each one at each place.</p>
      </Panel>
    );
  const at = Math.min(state.keyFrame.value, frames.length - 1);
  const frame = frames[at] ?? { time_s: 0 };
  const change = (changes: { [Key in keyof KeyFrame]?: KeyFrame[Key] | undefined }): void => put(frames.map((each, i) => (i === at ? { ...brief({ ...each, ...changes } as KeyFrame), time_s: changes.time_s ?? each.time_s } : each)));
  const next = frames[at + 1];
  const add = (): void => {
    const time_s = rounded(next ? (frame.time_s + next.time_s) / 2 : frame.time_s + 1);
    const { mark: _, ...same } = frame;
    put([...frames.slice(0, at + 1), { ...same, time_s }, ...frames.slice(at + 1)]);
    state.keyFrame.value = at + 1;
  };
  const remove = (): void => {
    const left = frames.filter((_, i) => i !== at).map((each, i) => (i === 0 ? { ...each, time_s: 0 } : each));
    put(left.length > 1 ? left : undefined);
  };
  const [least, most] = limitsOf(frames, at);
  const become = (form: string): void => {
    if (form === "" || Number(form) > 0) return change({ shape: form === "" ? undefined : Number(form) });
    const more = withForm(now, form);
    put(frames.map((each, i) => (i === at ? { ...each, shape: more.shape?.length } as KeyFrame : each)), more);
  };
  return (
    <Panel title={labels.keyframe}>
      <div class="buttons keys" role="group" aria-label="Key frames">
        {frames.map((each, i) => <button key={i} type="button" aria-pressed={i === at} aria-label={`Key frame ${i + 1}, at ${each.time_s} s`} onClick={() => choose(actions, i)}>{each.time_s} s</button>)}
        <button type="button" onClick={add} aria-label="Add a key frame after this one">+</button>
      </div>
      {at > 0 && <NumberField label="At" unit="s" value={frame.time_s} step={0.1} least={least} most={most} onValue={(time_s) => change({ time_s: rounded(time_s) })} />}
      <Choice label="Shape here" value={String(frame.shape ?? "")} choices={formsFor(now, state.hello.value?.primitives ?? [])} onValue={become} />
      <PointField label="Moved by" each="Moved by" unit="mm" value={frame.move_mm ?? [0, 0, 0]} onValue={(move_mm) => change({ move_mm })} />
      <NumberField label="Grown to" unit="×" value={frame.scale ?? 1} step={0.1} least={0.01} most={100} onValue={(scale) => change({ scale })} />
      <PointField label="Turned by" each="Turned by" unit="°" step={5} value={frame.rotate_deg ?? [0, 0, 0]} onValue={(rotate_deg) => change({ rotate_deg })} />
      <NumberField label="Strength here" unit="%" value={Math.round(100 * (frame.amplitude ?? 1))} least={0} most={100} onValue={(percent) => change({ amplitude: percent / 100 })} />
      {next && <Choice label="From here it" value={frame.ease ?? "linear"} choices={eases.map(([key, name]): [string, string] => [key, name])} onValue={(ease) => change({ ease: ease as KeyFrame["ease"] })} />}
      <More what="beats, trigger">
        <MaybeField label="Beats" unit="Hz" empty="steady" value={frame.am_hz} step={10} least={0} most={500} onValue={(am_hz) => change({ am_hz })} />
        <label class="check"><input type="checkbox" checked={frame.mark ?? false} onChange={(e) => change({ mark: e.currentTarget.checked || undefined })} /> The board's trigger output tells it</label>
      </More>
      <div class="buttons">
        <button type="button" onClick={remove}>{frames.length > 2 ? "Remove this key frame" : "Let it stay in its place"}</button>
      </div>
    </Panel>
  );
}
