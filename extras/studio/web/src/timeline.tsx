// SPDX-License-Identifier: Apache-2.0
// The pass in time: what plays when, how strong it is, and which focal point is marked.
import { computed } from "@preact/signals";
import { PanelBottom } from "lucide-preact";
import { useId, useRef, useState } from "preact/hooks";
import { Choice } from "./controls";
import { project } from "./document";
import { KeyHandle } from "./key_frames";
import type { Analysis, Scene } from "./link";
import { short } from "./quantity";
import { type Actions, state } from "./state";
import { entryAt } from "./tour";

const height = 40; // of the lane, in its own units; its width is 1000
const width = 1000;
const zooms = [1, 4, 16, 64];
/** Tenths, and no minus before a zero. */
const tenths = (value: number): string => (Math.round(10 * value) / 10 || 0).toFixed(1);
const slowings = [1, 10, 100, 1000, 10_000];

/**
 * How strong each entry of the tour is, 1 the strongest: by its amplitude, and once the analysis has come also by what that gives at its
 * place. Of the records of a place, which a modulation makes differently strong, one alone is analysed.
 */
export function strengths(scene: Scene, analysis: Analysis | undefined): number[] {
  const pressures = new Map(analysis?.foci.map(({ record, radiation_pa: pressure }) => [record, Math.sqrt(pressure)]));
  const atFull = new Map<string, number>(); // by place
  for (const { record, at, amplitude } of scene.tour) {
    const pressure = pressures.get(record);
    if (pressure !== undefined && amplitude > 0) atFull.set(at.join(), Math.max(atFull.get(at.join()) ?? 0, pressure / amplitude));
  }
  const values = scene.tour.map(({ at, amplitude }) => amplitude * (analysis ? atFull.get(at.join()) ?? 0 : 1));
  const most = Math.max(...values, 1e-12);
  return values.map((value) => value / most);
}

/** The part of the pass that is shown: all of it, or a part around the marked point. */
export function windowOf(scene: Scene, zoom: number, at: number | undefined): { from: number; to: number } {
  const entry = scene.tour[at ?? 0];
  const length = scene.pass_s / zoom;
  const middle = entry ? entry.from_s + entry.dwell_s / 2 : 0;
  const from = Math.max(0, Math.min(scene.pass_s - length, middle - length / 2));
  return { from, to: from + length };
}

const strong = computed(() => (state.scene.value ? strengths(state.scene.value, state.analysis.value) : []));

/** Blocks as one path: an entry is as wide as it lasts and as high as it is strong. Those narrower than a quarter unit become one with what follows. */
function blocks(scene: Scene, { from, to }: { from: number; to: number }): string {
  const scale = width / (to - from);
  const round = (value: number): number => Math.round(value * 100) / 100;
  let path = "", end = -1;
  scene.tour.forEach((entry, i) => {
    const [left, right] = [(entry.from_s - from) * scale, (entry.from_s + entry.dwell_s - from) * scale];
    if (right < 0 || left > width || right < end + 0.25) return;
    end = right;
    const top = height - Math.max(1, (height - 2) * (strong.value[i] ?? 0));
    const gap = right - left > 4 ? 0.5 : 0; // so that neighbours are told apart
    path += `M${round(left + gap)} ${height}V${round(top)}H${round(right - gap)}V${height}Z`;
  });
  return path;
}

export function Timeline({ actions }: { actions: Actions }) {
  const id = useId();
  const lane = useRef<SVGSVGElement>(null);
  const [zoom, setZoom] = useState(1);
  const scene = state.scene.value;
  const at = state.at.value;
  if (!scene || scene.tour.length === 0) return null;
  const folded = state.folded.value.time;
  const { tour } = scene;
  const entry = at === undefined ? undefined : tour[at];
  const points = scene.foci.length;
  // A modulation plays each focal point in several steps.
  const number = !entry || tour.length === points ? (at ?? 0) + 1 : scene.foci.findIndex((each) => each.every((value, i) => value === entry.at[i])) + 1;
  const steps = tour.length === points || number === 0 ? "" : `, step ${(at ?? 0) + 1} of ${tour.length}`;
  const playing = tour[state.playsPoint.value ?? -1];
  const shown = windowOf(scene, zoom, at);
  const scale = width / (shown.to - shown.from);
  const keys = (project.value?.keyframe ?? []).map(({ time_s }) => time_s);
  const starts = [...new Set((project.value?.trigger ?? []).map(({ from_s }) => from_s ?? 0))];
  const scrub = (event: PointerEvent): void => {
    const box = lane.current?.getBoundingClientRect();
    if (!box || event.buttons !== 1) return;
    const seconds = shown.from + ((event.clientX - box.left) / box.width) * (shown.to - shown.from);
    actions.mark(entryAt(scene, seconds));
  };
  const ms = (seconds: number): string => `${short(seconds * 1e3)} ms`;
  return (
    <div class="scrubber" role="region" aria-label="Timeline">
      {!folded && <div class="lane-box"><svg ref={lane} class="lane" viewBox={`0 0 ${width} ${height}`} preserveAspectRatio="none" role="img" aria-label={`${tour.length} entries${keys.length > 0 ? ` and ${keys.length} key frames` : ""}${starts.length > 0 ? ` and ${starts.length} places where triggers begin` : ""} in ${ms(scene.pass_s)}, shown from ${ms(shown.from)} to ${ms(shown.to)}`} onPointerDown={scrub} onPointerMove={scrub}>
        <path class="blocks" d={blocks(scene, shown)} />
        {keys.map((time, i) => <path key={i} class="key" d={`M${(time - shown.from) * scale} 0v${height}`} />)}
        {starts.map((time) => <path key={`t${time}`} class="trigger-at" d={`M${(time - shown.from) * scale} 0l8 5l-8 5z`} />)}
        {entry && <rect class="mark-here" x={(entry.from_s - shown.from) * scale} y={0} width={Math.max(3, entry.dwell_s * scale)} height={height} />}
        {playing && <rect class="plays-here" x={(playing.from_s - shown.from) * scale} y={0} width={Math.max(3, playing.dwell_s * scale)} height={height} />}
      </svg>{keys.map((_, i) => <KeyHandle key={i} actions={actions} number={i} shown={shown} lane={lane} />)}</div>}
      <div class="row">
        <button type="button" class="ghost" aria-expanded={!folded} aria-label="Timeline in full" onClick={() => (state.folded.value = { ...state.folded.value, time: !folded })}><PanelBottom size={16} aria-hidden="true" /></button>
        <button type="button" aria-pressed={state.running.value} onClick={() => actions.run(!state.running.value)}>{state.running.value ? "❚❚ Hold" : "▶ Run"}</button>
        <label for={id}>Focal point</label>
        <input id={id} type="range" min={0} max={tour.length - 1} step={1} value={at ?? 0} onInput={(e) => actions.mark(Number(e.currentTarget.value))} />
        <output for={id}>{entry ? `${number || (at ?? 0) + 1} of ${number ? points : tour.length}${steps}: ${entry.at.map(tenths).join(", ")} mm` : `${points}, none marked`}</output>
        <Choice label="Time" value={String(state.slower.value)} choices={slowings.map((each) => [String(each), each === 1 ? "as on the board" : `1/${each.toLocaleString("en")} as fast`])} onValue={(value) => (state.slower.value = Number(value))} />
        <Choice label="Zoom" value={String(zoom)} choices={zooms.map((each) => [String(each), each === 1 ? "whole pass" : `× ${each}`])} onValue={(value) => setZoom(Number(value))} />
      </div>
      {entry && !folded && <Marked />}
    </div>
  );
}

/** What is known of the marked focal point, and what the discs' colours mean. */
function Marked() {
  const scene = state.scene.value;
  const entry = scene?.tour[state.at.value ?? -1];
  if (!scene || !entry) return null;
  const focus = state.analysis.value?.foci.find(({ record }) => record === entry.record);
  const level = state.analysis.value?.level;
  const { drives } = state;
  return (
    <p class="marked">
      <span>{short(entry.from_s * 1e3)} to {short((entry.from_s + entry.dwell_s) * 1e3)} ms of {short(scene.pass_s * 1e3)} ms</span>
      <span>record {entry.index}</span>
      {focus && <span title={level?.note}>{short(focus.radiation_pa)} Pa, {short(focus.width_mm)} mm wide, {short(focus.force_mn)} mN on 20 mm{level?.calibrated ? "" : ", nominal"}</span>}
      {drives.value?.record === entry.record && <span class="phases">discs: phase 0° <i aria-hidden="true" /> 360°, grey is off</span>}
    </p>
  );
}

const stillness = matchMedia("(prefers-reduced-motion: reduce)"); // four steps a second instead of a motion

/** Lets the marked point run through the tour in slow motion, a picture at a time. */
export class Runner {
  private begun: { at: number; seconds: number } | undefined;

  constructor(private readonly mark: (at: number) => void) {}

  start(): void {
    const scene = state.scene.peek();
    if (!scene || scene.tour.length === 0) return;
    this.begun = { at: performance.now(), seconds: scene.tour[state.at.peek() ?? 0]?.from_s ?? 0 };
    state.running.value = true;
    requestAnimationFrame(() => this.step());
  }

  stop(): void {
    this.begun = undefined;
    state.running.value = false;
  }

  private step(): void {
    const scene = state.scene.peek();
    if (!this.begun || !scene) return this.stop();
    const now = performance.now();
    const seconds = (this.begun.seconds + (now - this.begun.at) / 1000 / state.slower.peek()) % scene.pass_s;
    this.begun = { at: now, seconds };
    const at = entryAt(scene, seconds);
    if (at !== state.at.peek()) this.mark(at);
    if (stillness.matches) setTimeout(() => this.step(), 250);
    else requestAnimationFrame(() => this.step());
  }
}
