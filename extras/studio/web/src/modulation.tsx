// SPDX-License-Identifier: Apache-2.0
// What the strength of all focal points follows: a tone, a sound, or a curve.
import { Choice } from "./controls";
import type { ProjectDocument } from "./document";
import { labels } from "./labels";
import type { Actions } from "./state";

/** Waveforms of the amplitude, as a project file names them. */
const tones = [["", "none"], ["sine:50", "sine, 50 Hz"], ["sine:100", "sine, 100 Hz"], ["sine:200", "sine, 200 Hz"], ["square:200", "square, 200 Hz"]] as const;

const nameOf = (am: string): string => tones.find(([known]) => known === am)?.[1] ?? (am.startsWith("wav:") ? `sound of ${am.slice(4)}` : am.startsWith("csv:") ? `curve of ${am.slice(4)}` : am);

export function Modulation({ actions, now, set }: { actions: Actions; now: ProjectDocument; set: (changes: { am: string | undefined }) => void }) {
  const am = now.am ?? "";
  return (
    <>
      <Choice label={labels.am} value={am} choices={[...new Set([...tones.map(([key]) => key), am])].map((key) => [key, nameOf(key)])} onValue={(value) => set({ am: value || undefined })} />
      <label class="button">By a sound or a curve…
        <input class="hidden" type="file" accept=".wav,.csv" onChange={(e) => { void actions.drop([...(e.currentTarget.files ?? [])]); e.currentTarget.value = ""; }} />
      </label>
    </>
  );
}
