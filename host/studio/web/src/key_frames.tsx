// SPDX-License-Identifier: Apache-2.0
// Key frames: where the shape is, and how strong, at times between which it moves.
import { Choice, MaybeField, More, NumberField, Panel, PointField } from "./controls";
import { edit, having, type KeyFrame, type ProjectDocument } from "./document";
import { formsFor, withForm, withoutOldForms } from "./placing";
import { type Actions, state } from "./state";
import { entryAt } from "./timeline";

const eases = [["linear", "goes on evenly"], ["smooth", "goes on gently"], ["step", "stays until the next"]] as const;
const fewPoints = 20; // each focal point of each pass is one that the board must hold

/** Without what a frame has anyway. */
function brief(frame: KeyFrame): KeyFrame {
  const usual: Partial<Record<keyof KeyFrame, unknown>> = { scale: 1, amplitude: 1, am_hz: 0, ease: "linear", mark: false };
  const isUsual = ([key, value]: [string, unknown]): boolean => value === undefined || value === usual[key as keyof KeyFrame] || (Array.isArray(value) && value.every((each) => each === 0));
  return Object.fromEntries(Object.entries(frame).filter((entry) => !isUsual(entry))) as unknown as KeyFrame;
}

const rounded = (seconds: number): number => Number(seconds.toFixed(3));

export function KeyFrames({ actions, now }: { actions: Actions; now: ProjectDocument }) {
  const frames = now.keyframe ?? [];
  const put = (keyframe: KeyFrame[] | undefined, of = now): void => edit(withoutOldForms(having(of, { keyframe }), frames));
  const begin = (): void => {
    edit(having(now, { keyframe: [{ time_s: 0 }, { time_s: 1 }], points: Math.min(now.points ?? 200, fewPoints) }));
    state.keyFrame.value = 1;
  };
  if (frames.length === 0)
    return (
      <Panel title="Movement">
        <button type="button" class="wide" onClick={begin}>Let it move</button>
        <p class="hint">From key frame to key frame: its place, size, turn and strength. It takes {fewPoints} focal points at most at first, because the board holds each one at each place.</p>
      </Panel>
    );
  const at = Math.min(state.keyFrame.value, frames.length - 1);
  const frame = frames[at] ?? { time_s: 0 };
  const change = (changes: { [Key in keyof KeyFrame]?: KeyFrame[Key] | undefined }): void => put(frames.map((each, i) => (i === at ? { ...brief({ ...each, ...changes } as KeyFrame), time_s: changes.time_s ?? each.time_s } : each)));
  const choose = (i: number): void => {
    state.keyFrame.value = i;
    const scene = state.scene.value;
    if (scene && state.current.value && scene.tour.length > 0) actions.mark(entryAt(scene, Math.min(frames[i]?.time_s ?? 0, scene.pass_s)));
  };
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
  const [least, most] = [(frames[at - 1]?.time_s ?? 0) + 0.001, next ? next.time_s - 0.001 : 3600];
  const become = (form: string): void => {
    if (form === "" || Number(form) > 0) return change({ shape: form === "" ? undefined : Number(form) });
    const more = withForm(now, form);
    put(frames.map((each, i) => (i === at ? { ...each, shape: more.shape?.length } as KeyFrame : each)), more);
  };
  return (
    <Panel title="Movement">
      <div class="buttons keys" role="group" aria-label="Key frames">
        {frames.map((each, i) => <button key={i} type="button" aria-pressed={i === at} aria-label={`Key frame ${i + 1}, at ${each.time_s} s`} onClick={() => choose(i)}>{each.time_s} s</button>)}
        <button type="button" onClick={add} aria-label="Add a key frame after this one">+</button>
      </div>
      {at > 0 && <NumberField label="At" unit="s" value={frame.time_s} step={0.1} least={rounded(least)} most={rounded(most)} onValue={(time_s) => change({ time_s: rounded(time_s) })} />}
      <Choice label="It has become" value={String(frame.shape ?? "")} choices={formsFor(now, state.hello.value?.primitives ?? [])} onValue={become} />
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
