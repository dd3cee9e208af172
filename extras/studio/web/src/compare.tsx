// SPDX-License-Identifier: Apache-2.0
// A scene that was put aside, and what became different since.
import { Panel } from "./controls";
import { edit } from "./document";
import type { Scene } from "./link";
import { short } from "./quantity";
import { type Actions, state } from "./state";

const rows: { name: string; unit: string; of: (scene: Scene) => number }[] = [
  { name: "Focal points", unit: "", of: (scene) => scene.foci.length },
  { name: "Elements", unit: "", of: (scene) => scene.array.elements.length },
  { name: "Tour", unit: "mm", of: (scene) => scene.numbers.tour_mm },
  { name: "Passes a second", unit: "Hz", of: (scene) => scene.numbers.rate_hz },
  { name: "Shortest dwell", unit: "µs", of: (scene) => scene.numbers.shortest_dwell_s * 1e6 },
  { name: "A focus forms in", unit: "µs", of: (scene) => scene.numbers.formation_with_ring_up_s * 1e6 },
  { name: "Bandwidth leaves", unit: "%", of: (scene) => 100 * scene.numbers.pressure_left_least },
];

export function Compare({ actions }: { actions: Actions }) {
  const { scene, current, showsKept } = state;
  const kept = state.kept.value;
  if (!scene.value) return null;
  const now = scene.value;
  if (!kept)
    return (
      <Panel title="Compare">
        <button type="button" class="wide" disabled={!current.value} onClick={() => actions.keep(true)}>Keep this to compare</button>
        <p class="hint">Then change anything, or open another object: both are told in numbers, drawn in the profile, and shown in turn.</p>
      </Panel>
    );
  return (
    <Panel title="Compare">
      <table>
        <thead><tr><th scope="col"><span class="hidden">Number</span></th><td>kept</td><td>now</td><td class="unit"><span class="hidden">unit</span></td></tr></thead>
        <tbody>
          {rows.map(({ name, unit, of }) => {
            const [before, after] = [short(of(kept.scene)), short(of(now))];
            return <tr key={name} class={before === after ? "" : "differs"}><th scope="row">{name}</th><td>{before}</td><td>{before === after ? "same" : after}</td><td class="unit">{unit}</td></tr>;
          })}
        </tbody>
      </table>
      <label class="check"><input type="checkbox" checked={showsKept.value} onChange={(e) => actions.showKept(e.currentTarget.checked)} /> Show the kept one</label>
      <div class="buttons">
        <button type="button" onClick={() => { actions.showKept(false); edit(kept.document); }}>Go back to it</button>
        <button type="button" onClick={() => actions.keep(false)}>Forget it</button>
      </div>
      <p class="hint">“Hold the top of the scale” gives both the same colours.</p>
    </Panel>
  );
}
