// SPDX-License-Identifier: Apache-2.0
// What stands beside the view. Panels read the signals of the state, and call the actions.
import type { ComponentChildren, TargetedKeyboardEvent } from "preact";
import { useEffect, useId, useState } from "preact/hooks";
import { type Actions, type Handles, state } from "./app";
import { type ColourMap, colourMaps, stops } from "./colours";
import { commands } from "./commands";
import { canRedo, canUndo, edit, having, project, type ProjectDocument, redo, type ShapeEntry, undo } from "./document";
import type { Device, Point, SliceData } from "./link";
import { library } from "./library";
import { look, quantities, type Quantity, short, squareOf, valueOf, valueOnScale } from "./quantity";
import type { Orientation } from "./view";

interface WithActions {
  actions: Actions;
}

/** A number with its unit. It is taken when the field is left or Enter is pressed; arrow keys take steps at once. */
function NumberField({ label, unit, value, step = 1, least, onValue }: { label: string; unit: string; value: number; step?: number; least?: number; onValue: (value: number) => void }) {
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
    if (given.trim() === "" || !Number.isFinite(number) || (least !== undefined && number < least)) return setText(String(value));
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

function Choice({ label, value, choices, onValue }: { label: string; value: string; choices: [string, string][]; onValue: (value: string) => void }) {
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

function Panel({ title, children }: { title: string; children: ComponentChildren }) {
  return <section><h2>{title}</h2>{children}</section>;
}

export function Tools({ actions }: WithActions) {
  const toggle = (): void => {
    const system = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
    const theme = (document.documentElement.dataset["theme"] ?? system) === "dark" ? "light" : "dark";
    document.documentElement.dataset["theme"] = theme;
    localStorage.setItem("theme", theme);
    actions.paint();
  };
  return (
    <>
      <button type="button" disabled={!canUndo.value} onClick={undo} title="Undo (Ctrl+Z)">↶ Undo</button>
      <button type="button" disabled={!canRedo.value} onClick={redo} title="Redo (Ctrl+Shift+Z)">↷ Redo</button>
      <button type="button" onClick={toggle}>◐ Theme</button>
    </>
  );
}

/** What says how fast the object is played; the others follow. `usual` is what a change of pace begins with. */
const paces = [
  { key: "rate_hz", name: "passes a second", label: "Passes a second", unit: "Hz", usual: 10 },
  { key: "speed_m_s", name: "speed of the focus", label: "Speed", unit: "m/s", usual: 7 },
  { key: "frequency_hz", name: "drawings a second", label: "Drawings a second", unit: "Hz", usual: 10 },
] as const;
const noPace = { rate_hz: undefined, speed_m_s: undefined, frequency_hz: undefined };

/** Waveforms of the amplitude, as a project file names them. */
const modulations = [["", "none"], ["sine:50", "sine, 50 Hz"], ["sine:100", "sine, 100 Hz"], ["sine:200", "sine, 200 Hz"], ["square:200", "square, 200 Hz"]] as const;

/** Without measures of a kind of shape, the project file's default stands. */
export function Shape({ actions }: WithActions) {
  const hello = state.hello.value;
  const now = project.value;
  if (!hello || !now) return <Panel title="Object"><p>Waiting for the server…</p></Panel>;
  const shapes = now.shape ?? [];
  const first: ShapeEntry = shapes[0] ?? {};
  const files = shapes.filter((shape) => shape.file !== undefined);
  const change = (changes: Partial<Record<keyof ProjectDocument, unknown>>): void => edit(having(now, changes));
  const placed = (changes: Record<string, unknown>): void => change({ place: having((now.place ?? {}) as ProjectDocument, changes) });
  const centre = (now.place?.center_mm ?? [0, 0, 130]) as Point;
  const turned = (now.place?.rotate_deg ?? [0, 0, 0]) as Point;
  const replaced = (list: Point, at: number, value: number): number[] => list.map((each, i) => (i === at ? value : each));
  const axes = ["x", "y", "z"];
  const led = paces.find(({ key }) => now[key] !== undefined) ?? paces[0];
  const pace = led.key;
  return (
    <>
      <Panel title="Object">
        <Choice label="Library" value="" choices={[["", "choose…"], ...Object.keys(library).map((name): [string, string] => [name, name])]} onValue={(name) => { const chosen = library[name]; if (chosen) edit(having(chosen, { array: now.array, board: now["board"] })); }} />
        {shapes.length > 1 && <p>{shapes.length} shapes together.</p>}
        {files.length === 0 ? (
          <Choice label="Shape" value={first.kind ?? ""} choices={hello.primitives.map((kind) => [kind, kind])} onValue={(kind) => change({ shape: [{ kind }] })} />
        ) : (
          <>
            <p class="file">{files.map((shape) => shape.file).join(", ")}</p>
            <Choice label="Unit of the file" value={first.unit ?? "mm"} choices={[["mm", "mm"], ["cm", "cm"], ["m", "m"]]} onValue={(unit) => change({ shape: shapes.map((shape) => ({ ...shape, unit })) })} />
            <button type="button" onClick={() => edit(having(now, { shape: [{ kind: "hemisphere" }], place: undefined }))}>Back to a built-in shape</button>
          </>
        )}
        <label class="drop">
          Drop a file anywhere, or choose one
          <input type="file" multiple accept=".ply,.obj,.stl,.xyz,.csv" onChange={(e) => void actions.drop([...(e.currentTarget.files ?? [])])} />
          <small>PLY, OBJ, STL, XYZ or CSV</small>
        </label>
      </Panel>
      <Panel title="Place">
        {axes.map((axis, i) => <NumberField key={axis} label={`Centre ${axis}`} unit="mm" value={centre[i] ?? 0} onValue={(value) => placed({ center_mm: replaced(centre, i, value) })} />)}
        <NumberField label="Largest extent" unit="mm" value={now.place?.size_mm ?? 0} least={0} onValue={(size) => placed({ size_mm: size > 0 ? size : undefined })} />
        <p class="hint">An extent of 0 leaves the size as it is.</p>
        {axes.map((axis, i) => <NumberField key={axis} label={`Turn about ${axis}`} unit="°" value={turned[i] ?? 0} step={5} onValue={(value) => placed({ rotate_deg: replaced(turned, i, value) })} />)}
      </Panel>
      <Panel title="Sample and play">
        <NumberField label="Focal points" unit="" value={now.points ?? 200} step={10} least={1} onValue={(points) => change({ points: Math.round(points) })} />
        <Choice label="Pace" value={pace} choices={paces.map(({ key, name }) => [key, name])} onValue={(key) => change({ ...noPace, [key]: paces.find((each) => each.key === key)?.usual })} />
        <NumberField label={led.label} unit={led.unit} value={(now[pace] as number | undefined) ?? led.usual} least={0} onValue={(value) => change({ [pace]: value })} />
        <label class="check"><input type="checkbox" checked={now.even ?? false} onChange={(e) => change({ even: e.currentTarget.checked || undefined })} /> All points feel alike</label>
        <Choice label="Modulation" value={now.am ?? ""} choices={[...new Set([...modulations.map(([key]) => key), now.am ?? ""])].map((key) => [key, modulations.find(([known]) => known === key)?.[1] ?? key])} onValue={(am) => change({ am: am || undefined })} />
        <Choice label="Array" value={now.array ?? "tile-10x10"} choices={[...new Set([...hello.arrays, now.array ?? "tile-10x10"])].map((name) => [name, name])} onValue={(array) => change({ array })} />
      </Panel>
    </>
  );
}

const fieldFiles = ["png", "csv", "npy", "vti"] as const;

export function TakeAway({ actions }: WithActions) {
  const ready = state.scene.value !== undefined && state.current.value;
  const told = commands(state.edges.value, look.value.quantity, state.stepMm.value);
  return (
    <Panel title="Take away">
      <div class="buttons">
        <button type="button" disabled={!ready} onClick={() => void actions.take("hex")}>Image (.hex)</button>
        <button type="button" disabled={!ready} onClick={() => void actions.take("manifest")}>Manifest (.json)</button>
        <button type="button" disabled={!ready} onClick={() => void actions.take("project")}>Project (.toml)</button>
      </div>
      <h3>Field on the plane</h3>
      <NumberField label="Step" unit="mm" value={state.stepMm.value} step={0.1} least={0.05} onValue={(value) => (state.stepMm.value = value)} />
      <div class="buttons">
        {fieldFiles.map((as) => <button key={as} type="button" disabled={!ready || told.field === undefined || state.writing.value} onClick={() => void actions.takeField(as)}>Field (.{as})</button>)}
      </div>
      {told.field === undefined && <p class="hint">The plane lies askew; files are of planes along the axes.</p>}
      <h3>The same by command</h3>
      <pre class="command" tabIndex={0} aria-label="Commands that make these files">{told.text}</pre>
      <button type="button" disabled={!ready} onClick={() => void actions.copy(told.text)}>Copy as command</button>
      <p class="hint">Run it beside the project and the files that were dropped.</p>
      <p class="hint"><a href="notices.html" target="_blank" rel="noreferrer">Licences of this page's parts</a></p>
    </Panel>
  );
}

function Row({ name, value, unit, mark }: { name: string; value: string; unit: string; mark?: string | undefined }) {
  return <tr class={mark ? "low" : ""}><th scope="row">{name}</th><td>{value}</td><td class="unit">{unit}{mark && <span class="mark"> ▲ {mark}</span>}</td></tr>;
}

/** The mean of the points around the middle: one, two or four of them. */
function middleOf({ width, height, values }: SliceData): number {
  const [i, j] = [(width - 1) / 2, (height - 1) / 2];
  const around = [Math.floor(j), Math.ceil(j)].flatMap((row) => [Math.floor(i), Math.ceil(i)].map((column) => values[row * width + column] ?? 0));
  return around.reduce((sum, value) => sum + value, 0) / around.length;
}

export function Numbers() {
  const scene = state.scene.value;
  const object = state.object.value;
  const slice = state.slice.value;
  if (!scene) return <Panel title="Numbers"><p>Compiling…</p></Panel>;
  const { numbers } = scene;
  const { quantity: shown, top } = look.value;
  const drawn = object ? object.triangles.length / 9 : 0;
  return (
    <Panel title="Numbers">
      <table class={state.current.value ? "" : "stale"}>
        <tbody>
          <Row name="Focal points" value={String(scene.foci.length)} unit={numbers.clipped > 0 ? `, ${numbers.clipped} out of reach` : ""} />
          <Row name="Tour" value={short(numbers.tour_mm)} unit="mm" />
          <Row name="Passes a second" value={short(numbers.rate_hz)} unit="Hz" />
          <Row name="Shortest dwell" value={short(numbers.shortest_dwell_s * 1e6)} unit="µs" mark={numbers.shortest_dwell_s < numbers.formation_s ? "too short" : undefined} />
          <Row name="A focus forms in" value={short(numbers.formation_s * 1e6)} unit="µs" />
          <Row name="with ring-up" value={short(numbers.formation_with_ring_up_s * 1e6)} unit="µs" />
          <Row name="Most points at this rate" value={String(numbers.most_points)} unit="" />
          <Row name="Bandwidth leaves" value={short(100 * numbers.pressure_left_least)} unit="% at least" />
          {slice && <Row name="Greatest on the plane" value={short(valueOf(slice.greatest, shown, top ?? slice.greatest, slice.skinPerSquare))} unit={quantities[shown].unit} />}
          {slice && <Row name="At the plane's middle" value={short(valueOf(middleOf(slice), shown, top ?? slice.greatest, slice.skinPerSquare))} unit={quantities[shown].unit} />}
          <Row name="Image" value={short(numbers.image_bytes / 1000)} unit="kB" />
        </tbody>
      </table>
      {object && object.allTriangles > drawn && <p class="hint">The object's {short(object.allTriangles)} triangles are drawn as {short(drawn)}; all of them are sampled.</p>}
      {scene.warnings.map((warning) => <p key={warning} class="warning">▲ {warning}</p>)}
    </Panel>
  );
}

const orientations: [Orientation, string][] = [["xy", "level (xy)"], ["xz", "upright, x (xz)"], ["yz", "upright, y (yz)"]];

const handles: [Handles, string][] = [["plane move", "move the plane"], ["plane turn", "turn the plane"], ["object move", "move the object"], ["object turn", "turn the object"]];

export function SliceControls({ actions }: WithActions) {
  const middle = state.middle.value;
  const orientation = state.orientation.value;
  const slice = state.slice.value;
  const { quantity: shown, colours, rangeDb, top } = look.value;
  const height = useId();
  const move = (at: number, value: number): void => actions.place(orientation, middle.map((each, i) => (i === at ? value : each)) as Point);
  return (
    <Panel title="Field">
      <Choice label="Shown" value={shown} choices={Object.entries(quantities).map(([key, { name, unit }]) => [key, `${name} / ${unit}`])} onValue={(value) => (look.value = { ...look.value, quantity: value as Quantity })} />
      <Choice label="Colours" value={colours} choices={colourMaps.map((map) => [map, map])} onValue={(value) => (look.value = { ...look.value, colours: value as ColourMap })} />
      {quantities[shown].decibels && <NumberField label="Range" unit="dB" value={rangeDb} step={5} least={1} onValue={(range) => (look.value = { ...look.value, rangeDb: range })} />}
      <label class="check"><input type="checkbox" checked={top !== undefined} disabled={!slice} onChange={(e) => (look.value = { ...look.value, top: e.currentTarget.checked ? slice?.greatest : undefined })} /> Hold the top of the scale</label>
      {slice && top !== undefined && shown !== "below" && <NumberField label="Top" unit={quantities[shown].unit} value={Number(valueOf(top, shown, top, slice.skinPerSquare).toPrecision(6))} least={shown === "level" ? -100 : 1e-6} onValue={(value) => (look.value = { ...look.value, top: squareOf(value, shown, top, slice.skinPerSquare) })} />}
      <Choice label="Plane" value={orientation} choices={orientations} onValue={(value) => actions.place(value as Orientation, value === "xy" ? [0, 0, middle[2]] : [0, 0, Math.max(90, middle[2])])} />
      <div class="field">
        <label for={height}>Height</label>
        <input id={height} type="range" min={20} max={300} step={0.5} value={middle[2]} onInput={(e) => move(2, Number(e.currentTarget.value))} />
      </div>
      {["x", "y", "z"].map((axis, i) => <NumberField key={axis} label={`Middle ${axis}`} unit="mm" value={Number((middle[i] ?? 0).toFixed(2))} onValue={(value) => move(i, value)} />)}
      <Choice label="Handles" value={state.handles.value} choices={handles} onValue={(value) => actions.handle(value as Handles)} />
    </Panel>
  );
}

function boardWords(device: Device): string {
  if (device.connection === "none") return "Board: none";
  const name = device.port === "virtual" ? "virtual board" : device.port === "virtual-rtl" ? "virtual board of Verilog" : `board at ${device.port ?? ""}`;
  if (device.connection !== "connected") return `Board: ${name}, ${device.connection === "lost" ? "connection lost" : "connecting…"}`;
  const status = device.status;
  return `Board: ${name}, outputs ${status?.outputs === "on" ? "ON" : "off"}${status?.mode === "idle" ? "" : `, ${status?.mode ?? ""}`}`;
}

export function Board({ actions }: WithActions) {
  const device = state.device.value;
  const scene = state.scene.value;
  const work = state.work.value;
  const [port, setPort] = useState("");
  const id = useId();
  const connected = device.connection === "connected";
  const busy = work?.t === "progress";
  const on = device.status?.outputs === "on";
  const ready = connected && scene !== undefined && state.current.value && !busy;
  useEffect(() => {
    const words = document.getElementById("board");
    if (words) {
      words.textContent = boardWords(device);
      words.classList.toggle("on", on);
    }
    document.title = on ? "● Outputs on: Haptogram studio" : "Haptogram studio";
  }, [device]);
  return (
    <Panel title="Board">
      {device.connection === "none" ? (
        <>
          <button type="button" class="wide" disabled={scene === undefined} onClick={() => actions.send("connect", { port: "virtual", scene: scene?.name ?? "" })}>Start a virtual board</button>
          <p class="hint">It answers and plays as a real board does, in real time.</p>
          <button type="button" class="wide" disabled={scene === undefined} onClick={() => actions.send("connect", { port: "virtual-rtl", scene: scene?.name ?? "" })}>Simulate the FPGA's Verilog</button>
          <p class="hint">The same by the FPGA's own circuit, cycle by cycle; some ten times slower than a board.</p>
          <div class="field port">
            <label for={id}>Port</label>
            <input id={id} type="text" list="ports" value={port} placeholder="/dev/ttyUSB0" onInput={(e) => setPort(e.currentTarget.value)} />
            <datalist id="ports">{state.hello.value?.ports.map((each) => <option key={each.port} value={each.port}>{each.name}</option>)}</datalist>
            <button type="button" disabled={port === ""} onClick={() => actions.send("connect", { port, scene: scene?.name ?? "" })}>Connect</button>
          </div>
        </>
      ) : (
        <>
          <p>{boardWords(device)}{device.identity && connected && `; ${device.identity.channels} channels, ${device.identity.records} records`}{on && device.status && `; plays record ${device.status.index}`}</p>
          {device.trouble && <p class="warning">▲ {device.trouble}</p>}
          <div class="buttons">
            <button type="button" disabled={!ready} onClick={() => actions.send("upload", { scene: scene?.name ?? "" })}>Upload</button>
            <button type="button" class="play" disabled={!ready} onClick={() => actions.send("play", { scene: scene?.name ?? "" })}>▶ Play</button>
            <button type="button" disabled={!ready || state.at.value === undefined} onClick={() => actions.stream()}>▶ Follow the slider</button>
            <button type="button" onClick={() => actions.send("disconnect")}>Disconnect</button>
          </div>
          <p class="hint">Playing turns the outputs on: ultrasound at these levels is loud though inaudible, so keep ears away. They go off when this page is closed, or hidden for 10 s.</p>
          <Work />
        </>
      )}
    </Panel>
  );
}

function Work() {
  const work = state.work.value;
  if (!work) return null;
  if (work.t === "progress" && work.stage === "upload")
    return <div class="field"><label for="upload">Uploading</label><progress id="upload" max={1} value={work.fraction ?? 0} /><span class="unit">{Math.round(100 * (work.fraction ?? 0))} %</span></div>;
  if (work.t === "progress" && work.work === "stream") return <p>Playing the marked focal point for {(work.seconds ?? 0).toFixed(1)} s; the slider below the view moves it.</p>;
  if (work.t === "progress") return <p>Playing for {(work.seconds ?? 0).toFixed(1)} s.</p>;
  if (work.t === "done" && work.work === "upload") return <p>Uploaded: {work.report?.frames_written} of {work.report?.frames} pieces had to be written.</p>;
  if (work.t === "done") return <p>Played to its end.</p>;
  if (work.t === "stopped") return <p>Stopped.</p>;
  return null;
}

export function Bar() {
  const slice = state.slice.value;
  if (!slice) return null;
  const { quantity, colours, top } = look.value;
  const { name, unit } = quantities[quantity];
  const upper = top ?? slice.greatest;
  const map = stops(colours);
  const probe = state.probe.value;
  return (
    <figure class="bar">
      <figcaption>{name} / {unit}</figcaption>
      <svg width="14" height="160" role="img" aria-label="Colours from low to high">
        <defs><linearGradient id="colours" x1="0" y1="1" x2="0" y2="0">{map.map((colour, i) => <stop key={i} offset={i / (map.length - 1)} stop-color={colour} />)}</linearGradient></defs>
        <rect width="14" height="160" fill="url(#colours)" />
      </svg>
      <ol>{[1, 0.75, 0.5, 0.25, 0].map((part) => <li key={part}>{short(valueOnScale(part, look.value, upper, slice.skinPerSquare))}</li>)}</ol>
      {slice.greatest > 1.001 * upper && <p class="warning">Hatched: above the top.</p>}
      {probe && <p class="probe">{short(valueOf(probe.square, quantity, upper, slice.skinPerSquare))} {unit} at<br />{probe.at.map((each) => each.toFixed(1)).join(", ")} mm</p>}
    </figure>
  );
}

/** The focal points one by one, in the order of play. */
export function Scrubber({ actions }: WithActions) {
  const id = useId();
  const tour = state.scene.value?.tour ?? [];
  const at = state.at.value;
  const entry = at === undefined ? undefined : tour[at];
  if (tour.length === 0) return null;
  return (
    <div class="scrubber">
      <label for={id}>Focal point</label>
      <input id={id} type="range" min={0} max={tour.length - 1} step={1} value={at ?? 0} onInput={(e) => actions.mark(Number(e.currentTarget.value))} />
      <output for={id}>{entry ? `${(at ?? 0) + 1} of ${tour.length}: ${entry.at.map((each) => each.toFixed(1)).join(", ")} mm` : `none of ${tour.length}`}</output>
    </div>
  );
}

export function Failed() {
  const failure = state.failure.value;
  if (!failure) return null;
  return <p class="failed" role="alert"><strong>{failure.where}</strong> {failure.message} <button type="button" onClick={() => (state.failure.value = undefined)}>Close</button></p>;
}

export function Status() {
  const { slice, scene, current } = state;
  const words = !current.value ? "Compiling…" : `${state.hello.value?.project ?? ""}: ${scene.value?.foci.length ?? 0} focal points for ${scene.value?.array.name ?? ""}`;
  return (
    <footer>
      <span>{words}</span>
      {slice.value && <span>slice {slice.value.width} × {slice.value.height}, computed in {short(slice.value.tookMs)} ms, here after {short(state.latencyMs.value)} ms</span>}
      <span>Haptogram {state.hello.value?.version}</span>
    </footer>
  );
}
