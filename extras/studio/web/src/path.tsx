// SPDX-License-Identifier: Apache-2.0
// A path in place of an object: a file's, or one that is drawn by hand on the plane.
import { Choice, NumberField, Panel } from "./controls";
import { edit, having, type ProjectDocument } from "./document";
import { labels } from "./labels";
import { short } from "./quantity";
import { type Actions, state } from "./state";
import { lengthOf } from "./stroke";

const smoothings: [string, string][] = [["0", "not at all"], ["30", "over 30 ms"], ["100", "over 100 ms"]];

export function PathPanel({ actions, now }: { actions: Actions; now: ProjectDocument }) {
  const line = state.line.value;
  const smoothed = state.smoothed.value?.file === now.path ? state.smoothed.value : undefined;
  const { array, board, live } = now;
  return (
    <Panel title={labels.path}>
      <p class="file">{now.path}</p>
      {line ? (
        <>
          <p class="hint">{line.places.length} places, {short(lengthOf(line.places))} mm, {short(lengthOf(line.places) / 1000 / line.seconds)} m/s on average; then from the beginning again.</p>
          {smoothed && smoothed.ms > 0 && <p class="hint">Smoothed over {smoothed.ms} ms: no place was moved by more than {short(smoothed.mm)} mm.</p>}
          <NumberField label="Lasts" unit="s" value={Number(line.seconds.toFixed(3))} step={0.1} least={0.01} most={600} onValue={(seconds) => void actions.last(seconds)} />
        </>
      ) : (
        <p class="hint">It has places and times of its own.{state.whyPath.value?.file === now.path && ` It stays a path: ${state.whyPath.value?.why}.`}</p>
      )}
      <div class="buttons">
        <button type="button" onClick={() => actions.draw(true)}>Draw another path</button>
        <button type="button" onClick={() => edit(having({ format: now.format }, { array, board, live, shape: [{ kind: "hemisphere" }] }))}>Back to a built-in shape</button>
      </div>
    </Panel>
  );
}

/** Over the view, while a line is drawn. */
export function Drawing({ actions }: { actions: Actions }) {
  const pen = state.pen.value;
  if (!pen) return null;
  return (
    <div class="card drawing">
      <p><b>Draw on the plane:</b> press, draw, let go. Or move the pen by arrow keys; Enter begins and ends the line. As fast as you draw, it is played.</p>
      <p role="status">{pen.places > 1 ? `A line of ${pen.places} places, at` : "The pen is at"} {pen.at.map((each) => each.toFixed(1)).join(", ")} mm.</p>
      <Choice label="Smoothed" value={String(state.smoothing.value)} choices={smoothings} onValue={(ms) => (state.smoothing.value = Number(ms))} />
      <div class="buttons"><button type="button" onClick={() => actions.draw(false)}>Do not draw</button></div>
    </div>
  );
}
