// SPDX-License-Identifier: Apache-2.0
// A recorded hand that feels an object by an algorithm: what is chosen at the left, and what became of the frame at the right.
import { useId, useRef } from "preact/hooks";
import { renderCommand } from "./commands";
import { Choice, MaybeField, NumberField, Panel, PointField, Row } from "./controls";
import { edit, endGesture, having, type HandTable, project, type ProjectDocument } from "./document";
import { ofAllFrames } from "./hand_reader";
import { InstrumentFields, Strength } from "./instrument";
import { labels } from "./labels";
import type { FrameReport } from "./link";
import { Modulation } from "./modulation";
import { fileUnits, touchedAt } from "./placing";
import { short } from "./quantity";
import { type Actions, state } from "./state";

interface WithDocument {
  actions: Actions;
  now: ProjectDocument;
  hand: HandTable;
}

const prefix = "synthetic:";
const usualHeight = 200; // mm, of a synthetic hand's palm
const scripts: [string, string][] = [["press", "an open hand goes down and up"], ["slide", "an open hand slides"], ["grasp", "the fingers bend"], ["wave", "the hand turns"]];
const withHeight = ["cone", "pyramid", "cylinder"];
const rounded = (value: number): number => Number(value.toPrecision(12));

/** The document with other settings of its hand; undefined takes one out. */
function changed(now: ProjectDocument, changes: { [Key in keyof HandTable]?: HandTable[Key] | undefined }): ProjectDocument {
  const all = Object.entries({ ...now.hand, ...changes }).filter(([, value]) => value !== undefined);
  return having(now, { hand: Object.fromEntries(all) });
}
const change = (now: ProjectDocument, changes: Parameters<typeof changed>[1], gesture?: string): void => edit(changed(now, changes), gesture);

function Recording({ now, hand }: Omit<WithDocument, "actions">) {
  const synthetic = hand.recording.startsWith(prefix);
  const [script = "", height = String(usualHeight)] = hand.recording.slice(prefix.length).split(":");
  const choose = (chosen: string, at: number): void => change(now, { recording: at === usualHeight ? `${prefix}${chosen}` : `${prefix}${chosen}:${rounded(at)}`, model: undefined, frames_hz: undefined, frame: synthetic && chosen === script ? hand.frame : 1 });
  return (
    <Panel title={labels.hand}>
      <Choice label="Recording" value={synthetic ? script : "file"} choices={[...scripts.map(([key, about]): [string, string] => [key, `${key}: ${about}`]), ...(synthetic ? [] : [["file", hand.recording] as [string, string]])]} onValue={(value) => value !== "file" && choose(value, usualHeight)} />
      {synthetic && <NumberField label="Palm height" unit="mm" value={Number(height)} least={1} onValue={(value) => choose(script, value)} />}
      {!synthetic && <p class="file">{hand.recording}{hand.model !== undefined && `, bones of ${hand.model}`}</p>}
      {hand.recording.endsWith(".pose") && <NumberField label="Frames a second" unit="Hz" value={hand.frames_hz ?? 60} least={0.001} onValue={(frames_hz) => change(now, { frames_hz })} />}
    </Panel>
  );
}

/** How strong each frame is, as a path of blocks; its width is 1000 and its height 36. */
function blocks(reports: FrameReport[], frames: number): string {
  const most = Math.max(...reports.map((each) => each.strength_pa), 1e-12);
  return reports.filter((each) => each.foci > 0).map(({ frame, strength_pa }) => `M${((frame - 1) / frames) * 1000} 36V${36 - Math.max(2, 34 * (strength_pa / most))}h${1000 / frames}V36Z`).join("");
}

function Frames({ actions, now, hand }: WithDocument) {
  const id = useId();
  const lane = useRef<SVGSVGElement>(null);
  const shown = state.hand.value;
  const frame = hand.frame ?? 1;
  const frames = Math.max(shown?.frames ?? 1, frame);
  const all = state.frames.value;
  const known = all?.of === JSON.stringify(ofAllFrames(now)) ? all.reports : undefined;
  const take = (value: number): void => change(now, { frame: Math.min(frames, Math.max(1, Math.round(value))) }, "frame");
  const scrub = (event: PointerEvent): void => {
    const box = lane.current?.getBoundingClientRect();
    if (box && event.buttons === 1) take(1 + Math.floor(((event.clientX - box.left) / box.width) * frames));
  };
  return (
    <Panel title="Frame">
      {known && (
        <svg ref={lane} class="frames" viewBox="0 0 1000 36" preserveAspectRatio="none" role="img" aria-label={`How strong each of ${frames} frames is; ${known.filter((each) => each.foci > 0).length} touch the object`} onPointerDown={scrub} onPointerMove={scrub} onPointerUp={endGesture}>
          <path class="blocks" d={blocks(known, frames)} />
          <rect class="mark-here" x={((frame - 1) / frames) * 1000} y={0} width={Math.max(4, 1000 / frames)} height={36} />
        </svg>
      )}
      <div class="field">
        <label for={id}>Frame</label>
        <input id={id} type="range" min={1} max={frames} step={1} value={frame} onInput={(e) => take(Number(e.currentTarget.value))} onChange={endGesture} />
      </div>
      <output class="frame" for={id}>{frame} of {frames}{shown && shown.frame === frame ? `, at ${shown.time_s.toFixed(3)} of ${shown.end_s.toFixed(3)} s` : ""}</output>
      <NumberField label="Frame number" unit="" value={frame} least={1} whole onValue={(value) => change(now, { frame: value })} />
      <button type="button" disabled={state.rendering.value} onClick={() => void actions.renderHand("look")}>{state.rendering.value ? "Rendering…" : "Look through all frames"}</button>
    </Panel>
  );
}

function Touched({ actions, now, hand }: WithDocument) {
  const kinds = state.hello.value?.touched ?? [];
  const object = hand.object ?? "sphere";
  const file = object.includes(".");
  const [centre, turned] = [hand.center_mm ?? touchedAt, hand.rotate_deg ?? [0, 0, 0]];
  return (
    <Panel title="Touched object">
      <Choice label="Kind" value={object} choices={[...kinds, ...(kinds.includes(object) ? [] : [object])].map((kind) => [kind, kind])} onValue={(kind) => change(now, { object: kind, unit: undefined, height_mm: undefined, size_mm: kinds.includes(object) ? hand.size_mm : undefined })} />
      {file && <Choice label="Unit of the file" value={hand.unit ?? "mm"} choices={fileUnits.map((unit): [string, string] => [unit, unit])} onValue={(unit) => change(now, { unit })} />}
      {object !== "half-space" && <MaybeField label={labels.size} unit="mm" empty={file ? "its own" : "100"} value={hand.size_mm} least={0.001} onValue={(size_mm) => change(now, { size_mm })} />}
      {withHeight.includes(object) && <NumberField label="Height" unit="mm" value={hand.height_mm ?? hand.size_mm ?? 100} least={0.001} onValue={(height_mm) => change(now, { height_mm })} />}
      <PointField label={labels.center} each={labels.center} unit="mm" value={centre} onValue={(center_mm) => change(now, { center_mm })} />
      <PointField label={labels.rotate} each={labels.rotate} unit="°" step={5} value={turned} onValue={(rotate_deg) => change(now, { rotate_deg })} />
      <div class="buttons">
        <label class="button" title="Leap JSON or LZ; poses with their model_hand.json; PLY, OBJ, STL, OFF, 3MF or glTF">Open a file…
          <input class="hidden" type="file" multiple accept=".json,.lz,.pose,.ply,.obj,.stl,.off,.3mf,.gltf,.glb" onChange={(e) => { void actions.drop([...(e.currentTarget.files ?? [])]); e.currentTarget.value = ""; }} />
        </label>
      </div>
      <p class="hint">A recording or a closed mesh; or drop it anywhere.</p>
    </Panel>
  );
}

const paces: [string, string][] = [["", "the algorithm's own"], ["speed_m_s", "speed of the focus"], ["frequency_hz", "passes a second"]];

function Algorithm({ actions, now, hand }: WithDocument) {
  const hello = state.hello.value;
  const pace = now.speed_m_s !== undefined ? "speed_m_s" : now.frequency_hz !== undefined ? "frequency_hz" : "";
  const set = (changes: Parameters<typeof having>[1]): void => edit(having(now, changes));
  return (
    <Panel title="Algorithm">
      <Choice label="Algorithm" value={hand.algorithm ?? "A"} choices={(hello?.algorithms ?? []).map(({ letter, about }) => [letter, `${letter}: ${about}`])} onValue={(algorithm) => change(now, { algorithm })} />
      <Choice label="Pace" value={pace} choices={paces} onValue={(key) => set({ speed_m_s: key === "speed_m_s" ? 7 : undefined, frequency_hz: key === "frequency_hz" ? 30 : undefined })} />
      {pace === "speed_m_s" && <NumberField label={labels.speed_m_s} unit="m/s" value={now.speed_m_s ?? 7} least={0.000001} onValue={(speed_m_s) => set({ speed_m_s })} />}
      {pace === "frequency_hz" && <NumberField label="Passes a second" unit="" value={now.frequency_hz ?? 30} least={0.000001} onValue={(frequency_hz) => set({ frequency_hz })} />}
      <Choice label="Between lines" value={String(now["jump"] ?? "hop")} choices={[["hop", "hop at once"], ["blank", "silent on the way"]]} onValue={(jump) => set({ jump: jump === "hop" ? undefined : jump })} />
      <NumberField label="Points of a pass" unit="" value={now.points ?? 200} step={10} least={1} most={65535} whole onValue={(points) => set({ points })} />
      <Modulation actions={actions} now={now} set={set} />
      <Strength now={now} set={set} />
      <InstrumentFields hello={hello} now={now} set={set} />
    </Panel>
  );
}

function Path({ actions, now }: Omit<WithDocument, "hand">) {
  const busy = state.rendering.value;
  const text = [renderCommand(now), renderCommand(ofAllFrames(now))].join("\n");
  return (
    <Panel title={labels.path}>
      <div class="buttons">
        <button type="button" disabled={busy || !state.hand.value?.report} onClick={() => void actions.renderHand("frame")}>Path of this frame (.json)</button>
        <button type="button" disabled={busy} onClick={() => void actions.renderHand("all")}>Path of all frames (.json)</button>
      </div>
      <pre class="command" tabIndex={0} aria-label="Commands that make these paths">{text}</pre>
      <button type="button" onClick={() => void actions.copy(text)}>Copy the paths' commands</button>
      <p class="hint">“haptogram stream --path” plays a path of any length on a board that computes foci.</p>
    </Panel>
  );
}

/** The settings of a hand, in place of those of an object that is sampled. */
export function HandSettings({ actions, now, hand }: WithDocument) {
  const back = (): void => edit(having({ format: now.format, rate_hz: 7, shape: [{ kind: "hemisphere" }] }, { array: now.array, board: now.board }));
  return (
    <>
      <Recording now={now} hand={hand} />
      <Frames actions={actions} now={now} hand={hand} />
      <Algorithm actions={actions} now={now} hand={hand} />
      <Touched actions={actions} now={now} hand={hand} />
      <Path actions={actions} now={now} />
      <Panel title="Without a hand">
        <button type="button" onClick={back}>Back to an object of focal points</button>
      </Panel>
    </>
  );
}

const percent = (part: number): string => short(100 * part);

/** What became of the frame, in numbers; also the lines, for those who do not see them. */
export function HandReport() {
  const shown = state.hand.value;
  if (!project.value?.hand) return null;
  if (!shown) return <Panel title="This frame"><p>Not rendered.</p></Panel>;
  const { report, nothing, warnings } = shown;
  return (
    <Panel title="This frame">
      {nothing && <p class="warning" role="status">▲ Nothing is drawn: {nothing.message}</p>}
      {report && (
        <table>
          <tbody>
            <Row name="Strength on the lines" value={short(report.strength_pa)} unit="Pa" />
            <Row name="of a focus that rests" value={short(report.focus_pa)} unit="Pa" />
            <Row name="Width of a focus" value={short(report.width_mm)} unit="mm" />
            <Row name="Passes a second" value={short(report.draw_hz)} unit="" />
            <Row name="Lines" value={String(report.lines)} unit="" />
            <Row name="Length of all lines" value={short(report.length_mm)} unit="mm" />
            <Row name="Foci at a time" value={String(report.foci)} unit="" />
            <Row name="Tilt leaves" value={percent(report.tilt)} unit="%" />
            <Row name="Under the least mean force" value={percent(report.weak)} unit="%" />
            <Row name="Out of reach" value={percent(report.out_of_reach)} unit="%" mark={report.out_of_reach > 0 ? "silent" : undefined} />
            <Row name="Lines missed" value={String(report.lines_missed)} unit="" mark={report.lines_missed > 0 ? "take more points" : undefined} />
            <Row name="One pass" value={short(1e3 * shown.pass_s)} unit="ms" />
            <Row name="Computed in" value={short(report.compute_ms)} unit="ms" />
          </tbody>
        </table>
      )}
      {warnings.map((text) => <p key={text} class="warning">▲ {text}</p>)}
      {shown.lines.length > 0 && (
        <>
          <p class="hint">Each line, in its order: {shown.lines.map(({ kind, length_mm }) => `${kind} ${short(length_mm)} mm`).join(", ")}</p>
          <p class="hint key">In the view:<i class="felt" />over the least mean force<i class="weak" />under it<i class="focus" />focal points</p>
        </>
      )}
    </Panel>
  );
}
