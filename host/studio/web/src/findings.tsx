// SPDX-License-Identifier: Apache-2.0
// What should be known of the scene, in the server's words, each with a way to see it and a way to mend it.
import { Panel } from "./controls";
import { edit, having, project, type ProjectDocument } from "./document";
import type { Finding } from "./link";
import { type Actions, state } from "./state";

/** A remedy is an edit as any other; of a table, only the keys that it names change. */
function mended(now: ProjectDocument, changes: Record<string, unknown>): ProjectDocument {
  const whole = Object.entries(changes).map(([key, value]): [string, unknown] => {
    const before = now[key];
    const isTable = typeof value === "object" && !Array.isArray(value) && value !== null;
    return [key, isTable ? { ...(typeof before === "object" ? before : {}), ...value } : value];
  });
  return having(now, Object.fromEntries(whole));
}

export function Findings({ actions }: { actions: Actions }) {
  const { scene, analysis, current } = state;
  if (!scene.value) return null;
  const found = analysis.value?.findings ?? scene.value.findings;
  const show = (finding: Finding): void => {
    const at = scene.value?.tour.findIndex(({ record }) => finding.records.includes(record)) ?? -1;
    const entry = scene.value?.tour[at];
    if (!entry) return;
    actions.mark(at);
    actions.place(state.orientation.value, entry.at);
  };
  return (
    <Panel title={`Findings (${found.length})`}>
      {found.length === 0 && <p>{analysis.value ? "Nothing was found that is not as it should be." : "Nothing so far."}</p>}
      <ul class={current.value ? "findings" : "findings stale"}>
        {found.map((finding) => (
          <li key={finding.kind + finding.message} data-kind={finding.kind}>
            <p class="warning">▲ {finding.message}</p>
            <div class="buttons">
              {finding.records.length > 0 && <button type="button" disabled={!current.value} onClick={() => show(finding)}>Show {finding.records.length > 1 ? `the first of ${finding.records.length}` : "it"}</button>}
              {finding.remedies.map(({ label, changes }) => (
                <button key={label} type="button" disabled={!current.value} onClick={() => project.value && edit(mended(project.value, changes))}>{label}</button>
              ))}
            </div>
          </li>
        ))}
      </ul>
      {!analysis.value && <p class="hint">Each focus is being looked at…</p>}
    </Panel>
  );
}
