// SPDX-License-Identifier: Apache-2.0
// What is felt: objects, where they are, and how they are sampled and played.
import { Choice, MaybeField, More, NumberField, Panel, PointField } from "./controls";
import { edit, having, project, type ProjectDocument, type ShapeEntry } from "./document";
import { HandSettings } from "./hand";
import { InstrumentFields, Strength, Strongest } from "./instrument";
import { fewPoints, KeyFrames } from "./key_frames";
import { labels } from "./labels";
import { Modulation } from "./modulation";
import { PathPanel } from "./path";
import { inUnit, moved, nameOf, placed, placeOf, sizesOf, unitOf, withAnother, withNext, without } from "./placing";
import { short } from "./quantity";
import { type Actions, state } from "./state";
import { Triggers } from "./triggers";

/** What says how fast the object is played; the others follow. `usual` is what a change of pace begins with. */
const paces = [
  { key: "rate_hz", name: "passes a second", label: labels.rate_hz, unit: "", usual: 10 },
  { key: "speed_m_s", name: "speed of the focus", label: labels.speed_m_s, unit: "m/s", usual: 7 },
  { key: "frequency_hz", name: "drawings a second", label: labels.frequency_hz, unit: "", usual: 10 },
] as const;
const noPace = { rate_hz: undefined, speed_m_s: undefined, frequency_hz: undefined };

/** What the object is. Without measures of a kind of shape, the project file's default stands. */
function ObjectPanel({ actions, now, primitives }: { actions: Actions; now: ProjectDocument; primitives: string[] }) {
  const shapes = now.shape ?? [];
  const several = shapes.length > 1;
  const chosen = several ? placed(now, state.chosen.value) : 0;
  const shape: ShapeEntry = (chosen === undefined ? undefined : shapes[chosen]) ?? {};
  const size = shape.file === undefined ? undefined : state.sizes.value[shape.file];
  const change = (i: number, changes: ShapeEntry): void => edit(having(now, { shape: shapes.map((each, k) => (k === i ? { ...each, ...changes } : each)) }));
  /** Another kind has other measures, and stands where the old one did. */
  const become = (i: number, kind: string): void => {
    const { scale, size_mm, rotate_deg, center_mm } = shapes[i] ?? {};
    const place = Object.fromEntries(Object.entries({ scale, size_mm, rotate_deg, center_mm }).filter(([, value]) => value !== undefined));
    edit(having(now, { shape: shapes.map((each, k) => (k === i ? { kind, ...place } : each)) }));
  };
  return (
    <Panel title={labels.shape}>
      {several && <Choice label="Of several" value={String(chosen ?? "")} choices={[["", "all together"], ...shapes.map((each, i): [string, string] => [String(i), nameOf(each, i)])]} onValue={(value) => actions.choose(value === "" ? undefined : Number(value))} />}
      {chosen !== undefined && shape.file === undefined && <Choice label="Shape" value={shape.kind ?? ""} choices={primitives.map((kind) => [kind, kind])} onValue={(kind) => become(chosen, kind)} />}
      {chosen !== undefined && shape.file !== undefined && (
        <>
          <p class="file">{shape.file}</p>
          <Choice label="Unit of the file" value={unitOf(now, chosen)} choices={sizesOf(size)} onValue={(unit) => edit(inUnit(now, chosen, unit))} />
          {size && <p class="hint">{size.own_unit ? "It says its unit:" : "It says no unit; its numbers are"} {size.extent.map(short).join(" × ")}{size.own_unit && " mm"}.</p>}
          <Choice label="Upwards in the file" value={String(shape["up"] ?? "z")} choices={[["z", "z"], ["y", "y"]]} onValue={(up) => change(chosen, { up })} />
          {!several && <button type="button" onClick={() => edit(having(now, { shape: [{ kind: "hemisphere" }], place: undefined }))}>Back to a built-in shape</button>}
        </>
      )}
      {chosen === undefined && <p class="file">{shapes.map(nameOf).join(", ")}</p>}
      {several && chosen !== undefined && <button type="button" onClick={() => { actions.choose(undefined); edit(without(now, chosen)); }}>Remove this one</button>}
    </Panel>
  );
}

/** What a design begins with, before anything else in the panel. */
export function Begin({ actions }: { actions: Actions }) {
  const now = project.value;
  if (!now || now.hand) return null;
  const shapes = now.shape ?? [];
  const beside = (): void => {
    const lowest = Math.max(130, ...shapes.map((each) => each.center_mm?.[2] ?? 130));
    edit(withAnother(now, { kind: "circle", diameter_mm: 30, center_mm: [0, 0, lowest] }));
    actions.choose(shapes.length);
  };
  const afterwards = (): void => {
    edit(withNext(now, "circle", fewPoints));
    state.keyFrame.value = Math.max(1, (now.keyframe?.length ?? 2) - 1);
  };
  return (
    <Panel title="Begin">
      <div class="buttons">
        <label class="button" title="PLY, OBJ, STL, OFF, PCD, 3MF, glTF, SVG, XYZ, CSV; a path, an AdapTics pattern; a sound (WAV) to modulate by; a bundle, or a project with its files">Open a file…
          <input class="hidden" type="file" multiple accept=".haptogram,.toml,.ply,.obj,.stl,.off,.pcd,.3mf,.gltf,.glb,.svg,.xyz,.csv,.json,.adaptics,.wav" onChange={(e) => { void actions.drop([...(e.currentTarget.files ?? [])]); e.currentTarget.value = ""; }} />
        </label>
        {!now.path && <button type="button" onClick={() => actions.draw(true)}>Draw a path by hand</button>}
        {shapes.length > 0 && <button type="button" title="Another object beside the one that is there" onClick={beside}>+ Add an object</button>}
        {shapes.length > 0 && <button type="button" title="Another object after the one that is there, in its place" onClick={afterwards}>+ One afterwards</button>}
      </div>
      <p class="hint">Or drop a file anywhere.</p>
    </Panel>
  );
}

/** Where the chosen object is, or all together. */
function PlacePanel({ now }: { now: ProjectDocument }) {
  const shapes = now.shape ?? [];
  const object = placed(now, state.chosen.value);
  const place = placeOf(now, object);
  const apart = object === undefined && place.center_mm === undefined && shapes.some((shape) => shape.center_mm !== undefined);
  const change = (changes: Parameters<typeof moved>[2]): void => edit(moved(now, object, changes));
  const turned = place.rotate_deg ?? [0, 0, 0];
  const turn = <PointField label={labels.rotate} each={labels.rotate} unit="°" step={5} value={turned} onValue={(rotate_deg) => change({ rotate_deg })} />;
  return (
    <Panel title={object === undefined ? labels.place : `${labels.place} of ${nameOf(shapes[object] ?? {}, object)}`}>
      {apart ? (
        <>
          <p class="hint">Each object has a centre of its own.</p>
          <button type="button" onClick={() => change({ center_mm: [0, 0, 130] })}>Centre all together</button>
        </>
      ) : (
        <PointField label={labels.center} each={labels.center} unit="mm" value={place.center_mm ?? [0, 0, object === undefined ? 130 : 0]} onValue={(center_mm) => change({ center_mm })} />
      )}
      <MaybeField label={labels.size} unit="mm" empty="its own" value={place.size_mm} least={0.001} onValue={(size_mm) => change({ size_mm })} />
      {turned.some((each) => each !== 0) ? turn : <More what="turn">{turn}</More>}
    </Panel>
  );
}

/** An object is what it is; a path file has places and times of its own. */
export function Subject({ actions }: { actions: Actions }) {
  const hello = state.hello.value;
  const now = project.value;
  if (!hello || !now) return <Panel title={labels.shape}><p>Waiting for the server…</p></Panel>;
  if (now.hand) return <HandSettings actions={actions} now={now} hand={now.hand} />;
  if (now.path) return <PathPanel actions={actions} now={now} />;
  return <ObjectPanel actions={actions} now={now} primitives={hello.primitives} />;
}

/** Where it is, and how it is sampled and played. */
export function Properties({ actions }: { actions: Actions }) {
  const hello = state.hello.value;
  const now = project.value;
  if (!hello || !now || now.hand) return null;
  const change = (changes: Partial<Record<keyof ProjectDocument, unknown>>): void => edit(having(now, changes));
  const led = paces.find(({ key }) => now[key] !== undefined) ?? paces[0];
  const pace = led.key;
  return (
    <>
      {!now.path && <PlacePanel now={now} />}
      <Panel title="Sample and play">
        {!now.path?.endsWith(".csv") && <NumberField label={labels.points} unit="" value={now.points ?? 200} step={10} least={1} most={65535} whole onValue={(points) => change({ points })} />}
        {!now.path && <NumberField label={led.label} unit={led.unit} value={(now[pace] as number | undefined) ?? led.usual} least={0.000001} onValue={(value) => change({ [pace]: value })} />}
        <Strength now={now} set={change} />
        {!now.path && <Strongest now={now} set={change} />}
        <Modulation actions={actions} now={now} set={change} />
        <More what="pace, weak points, end, array, board">
          {!now.path && <Choice label="Pace" value={pace} choices={paces.map(({ key, name }) => [key, name])} onValue={(key) => change({ ...noPace, [key]: paces.find((each) => each.key === key)?.usual })} />}
          {!now.path && <label class="check"><input type="checkbox" checked={now.even ?? false} onChange={(e) => change({ even: e.currentTarget.checked || undefined })} /> {labels.even}</label>}
          <InstrumentFields hello={hello} now={now} set={change} />
        </More>
      </Panel>
      {!now.path && <KeyFrames actions={actions} now={now} />}
      <Triggers now={now} />
    </>
  );
}
