// SPDX-License-Identifier: Apache-2.0
// What stands beside the view. Panels read the signals of the state, and call the actions.
import { useId } from "preact/hooks";
import { type ColourMap, colourMaps, stops } from "./colours";
import { NeedsProgram } from "./board";
import { commands } from "./commands";
import { Choice, More, NumberField, Panel, PointField, Row } from "./controls";
import { designName, project } from "./document";
import { Remedies } from "./feel";
import { headOf, wordsOf } from "./labels";
import type { Point, SliceData } from "./link";
import { look, quantities, type Quantity, short, squareOf, valueOf, valueOnScale } from "./quantity";
import { type Actions, boardOf, type Handles, made, noProgram, shownRecord, state, whyNotMade } from "./state";
import type { Orientation } from "./view";

interface WithActions {
  actions: Actions;
}

const fieldFiles = ["png", "csv", "npy", "vti"] as const;

export function TakeAway({ actions }: WithActions) {
  const ready = made.value !== undefined;
  const board = boardOf(project.value);
  const told = commands(state.edges.value, look.value.quantity, state.stepMm.value, shownRecord.value, board);
  return (
    <Panel title="Take away">
      <button type="button" class="wide" onClick={() => void actions.saveBundle()}>Bundle (.haptogram)</button>
      {whyNotMade.value && <p class="warning">▲ {whyNotMade.value}</p>}
      <div class="buttons">
        <button type="button" disabled={!ready} onClick={() => void actions.take("hex")}>Image (.hex)</button>
        <button type="button" disabled={!ready} onClick={() => void actions.take("manifest")}>Manifest (.json)</button>
        <button type="button" disabled={!ready} onClick={() => void actions.take("project")}>Project (.toml)</button>
        <button type="button" disabled={!ready} onClick={() => void actions.take("primary")} title="Primary memory for Verilog's $readmemh">Records (.mem)</button>
        <button type="button" disabled={!ready} onClick={() => void actions.take("sequence")} title="Sequence memory for Verilog's $readmemh">Sequence (.mem)</button>
      </div>
      <h3>Bitstream</h3>
      {noProgram.value ? <NeedsProgram what="Images are put into bitstreams" /> : <div class="buttons">
        <button type="button" disabled={!ready || !board || state.writing.value} onClick={() => void actions.takeBitstream(false)} title="For the FPGA: the core with this image in its memories">{board ? `${board.bitstream}` : "Bitstream"}</button>
        <button type="button" disabled={!ready || !board || state.writing.value} onClick={() => void actions.takeBitstream(true)} title="The same, and the board plays it at power-up, with no host and no watchdog">with autostart</button>
      </div>}
      {!board && !noProgram.value && <p class="hint">Choose a board first: Make, Sample and play, More.</p>}
      <h3>For a paper</h3>
      <div class="buttons">
        <button type="button" disabled={!ready || state.writing.value} onClick={() => void actions.take("report")}>Report (.html)</button>
        <button type="button" disabled={!ready} onClick={() => void actions.copyMethods()}>Copy methods text</button>
      </div>
      <h3>Field on the plane</h3>
      <NumberField label="Step" unit="mm" value={state.stepMm.value} step={0.1} least={0.05} onValue={(value) => (state.stepMm.value = value)} />
      <div class="buttons">
        {fieldFiles.filter((as) => as !== "png" || !noProgram.value).map((as) => <button key={as} type="button" disabled={!ready || told.field === undefined || state.writing.value} onClick={() => void actions.takeField(as)}>Field (.{as})</button>)}
      </div>
      {noProgram.value && <NeedsProgram what="Pictures (.png) of the field are drawn" />}
      {told.field === undefined && <p class="hint">The plane lies askew; files are of planes along the axes.</p>}
      <h3>The same by command</h3>
      <pre class="command" tabIndex={0} aria-label="Commands that make these files">{told.text}</pre>
      <button type="button" disabled={!ready} onClick={() => void actions.copy(told.text)}>Copy as command</button>
      <p class="hint">Run it beside the project and the files that were dropped.</p>
      <p class="hint"><a href="notices.html" target="_blank" rel="noreferrer">Licences of this page's parts</a></p>
    </Panel>
  );
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
  if (!scene) return <Panel title="Numbers"><p>{state.current.value ? "There is no image." : "Compiling…"}</p></Panel>;
  const { numbers } = scene;
  const { quantity: shown, top } = look.value;
  const drawn = object ? object.triangles.length / 3 : 0;
  return (
    <Panel title="Numbers">
      <table class={state.current.value ? "" : "stale"}>
        <tbody>
          <Row name="Focal points" value={String(scene.foci.length)} unit={numbers.clipped > 0 ? `, ${numbers.clipped} out of reach` : ""} />
          <Row name="Tour" value={short(numbers.tour_mm)} unit="mm" />
          <Row name="Passes a second" value={short(numbers.rate_hz)} unit="" />
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
    </Panel>
  );
}

const orientations: [Orientation, string][] = [["xy", "level (xy)"], ["xz", "upright, x (xz)"], ["yz", "upright, y (yz)"]];

const handles: [Handles, string][] = [["plane move", "move the plane"], ["plane turn", "turn the plane"], ["object move", "move the object"], ["object turn", "turn the object"]];

const surfaces = [3, 6, 12, 20]; // dB

export function SliceControls({ actions }: WithActions) {
  const middle = state.middle.value;
  const orientation = state.orientation.value;
  const slice = state.slice.value;
  const { quantity: shown, colours, rangeDb, top } = look.value;
  const height = useId();
  const move = (at: number, value: number): void => actions.place(orientation, middle.map((each, i) => (i === at ? value : each)) as Point);
  return (
    <Panel title="Field">
      <Choice label="Shown" value={shown} choices={Object.entries(quantities).map(([key, { name, unit }]) => [key, `${name}, ${unit}`])} onValue={(value) => (look.value = { ...look.value, quantity: value as Quantity })} />
      {quantities[shown].decibels && <NumberField label="Range" unit="dB" value={rangeDb} step={5} least={1} onValue={(range) => (look.value = { ...look.value, rangeDb: range })} />}
      <Choice label="Plane" value={orientation} choices={orientations} onValue={(value) => actions.place(value as Orientation, value === "xy" ? [0, 0, middle[2]] : [0, 0, Math.max(90, middle[2])])} />
      <div class="field">
        <label for={height}>Height</label>
        <input id={height} type="range" min={20} max={300} step={0.5} value={middle[2]} onInput={(e) => move(2, Number(e.currentTarget.value))} />
      </div>
      <PointField label="Middle" each="Middle" unit="mm" value={middle.map((each) => Number(each.toFixed(2)))} onValue={(value) => actions.place(orientation, value as Point)} />
      <button type="button" disabled={!state.object.value} onClick={actions.ontoObject}>Back onto the object</button>
      <label class="check"><input type="checkbox" checked={state.alone.value} disabled={state.reach.value || (state.at.value === undefined && !state.alone.value)} onChange={(e) => actions.showAlone(e.currentTarget.checked)} /> Only the marked point</label>
      <label class="check"><input type="checkbox" checked={state.skin.value} disabled={state.reach.value} onChange={(e) => actions.showSkin(e.currentTarget.checked)} /> On the skin of a hand, too</label>
      <More what="colours, surface, reach, handles">
        <Choice label="Colours" value={colours} choices={colourMaps.map((map) => [map, map])} onValue={(value) => (look.value = { ...look.value, colours: value as ColourMap })} />
        <label class="check"><input type="checkbox" checked={top !== undefined} disabled={!slice} onChange={(e) => (look.value = { ...look.value, top: e.currentTarget.checked ? slice?.greatest : undefined })} /> Keep this scale</label>
        {slice && top !== undefined && shown !== "below" && <NumberField label="Top" unit={quantities[shown].unit} value={Number(valueOf(top, shown, top, slice.skinPerSquare).toPrecision(6))} least={shown === "level" ? -100 : 1e-6} onValue={(value) => (look.value = { ...look.value, top: squareOf(value, shown, top, slice.skinPerSquare) })} />}
        <Choice label="Surface" value={String(state.surface.value ?? "")} choices={[["", "none"], ...surfaces.map((below): [string, string] => [String(below), `${below} dB below the greatest`])]} onValue={(value) => (state.surface.value = value === "" ? undefined : Number(value))} />
        {state.surfacing.value && <p class="hint">The surface is being computed.</p>}
        <label class="check"><input type="checkbox" checked={state.reach.value} onChange={(e) => actions.showReach(e.currentTarget.checked)} /> What one focus could have at each point</label>
        {state.reach.value && <p class="hint">The array's workspace, as “haptogram analyze --array” writes it; nothing where it cannot focus. Surface, profile and files stay those of the sequence.</p>}
        <Choice label="Handles" value={state.handles.value} choices={handles} onValue={(value) => actions.handle(value as Handles)} />
      </More>
    </Panel>
  );
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
      <figcaption>{name}, {unit}</figcaption>
      <svg viewBox="0 0 188 8" preserveAspectRatio="none" role="img" aria-label="Colours from low to high">
        <defs><linearGradient id="colours">{map.map((colour, i) => <stop key={i} offset={i / (map.length - 1)} stop-color={colour} />)}</linearGradient></defs>
        <rect width="188" height="8" rx="2" fill="url(#colours)" />
      </svg>
      <ol>{[0, 0.25, 0.5, 0.75, 1].map((part) => <li key={part} style={{ left: `${100 * part}%`, transform: `translateX(-${part === 0 ? 0 : part === 1 ? 100 : 50}%)` }}>{short(valueOnScale(part, look.value, upper, slice.skinPerSquare))}</li>)}</ol>
      {slice.greatest > 1.001 * upper && <p class="warning">Hatched: above the top.</p>}
      {probe && <p class="probe">{short(valueOf(probe.square, quantity, upper, slice.skinPerSquare))} {unit} at {probe.at.map((each) => each.toFixed(1)).join(", ")} mm</p>}
    </figure>
  );
}

const pointsOf = (count: number): string => `${count} focal point${count === 1 ? "" : "s"}`;

/** What a length is in the middle of the view. */
export function ScaleBar() {
  const mm = state.mmPerPixel.value;
  if (!(mm > 0)) return null;
  const length = [1, 2, 5, 10, 20, 50, 100, 200, 500].find((each) => each / mm >= 60) ?? 1000;
  return <p class="scale"><span>{length} mm</span><i style={{ width: `${Math.round(length / mm)}px` }} /></p>;
}

export function Failed() {
  const failure = state.failure.value;
  if (!failure) return null;
  const [first, ...others] = wordsOf(failure).split("\n");
  return (
    <div class="failed" role="alert">
      <strong>{headOf(failure)}</strong> {first} {others.length > 0 && <pre tabIndex={0} aria-label="In full">{others.join("\n")}</pre>}
      <Remedies remedies={failure.ways ?? []} /> <button type="button" onClick={() => (state.failure.value = undefined)}>Close</button>
    </div>
  );
}

export function Status() {
  const { slice, scene, current, refused } = state;
  const words = refused.value ? whyNotMade.value : !current.value ? "Compiling…" : !scene.value ? `${designName.value}: no image` : `${designName.value}: ${pointsOf(scene.value?.foci.length ?? 0)} for ${scene.value?.array.name ?? ""}`;
  return (
    <footer>
      <span>{words}</span>
      {slice.value && !refused.value && <span>slice {slice.value.width} × {slice.value.height}, computed in {short(slice.value.tookMs)} ms, here after {short(state.latencyMs.value)} ms</span>}
      <span>Haptogram {state.hello.value?.version}</span>
    </footer>
  );
}
