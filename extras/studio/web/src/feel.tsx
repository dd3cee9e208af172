// SPDX-License-Identifier: Apache-2.0
// What a hand will feel of the scene, beside it all the time: the program's verdict, how strong a focus would be that
// rests and buzzes, the weakest part, the size of a focus, loudness; and what should be known, in the server's words, each with a way to see and to mend it.
import { ChevronDown, ChevronUp, CircleCheck, LoaderCircle, TriangleAlert } from "lucide-preact";
import { edit, having, project, type ProjectDocument } from "./document";
import { wordsOf } from "./labels";
import type { Analysis, Finding, Point, Remedy, Scene } from "./link";
import { short } from "./quantity";
import { type Actions, state } from "./state";

/** A remedy is an edit as any other. */
function mended(now: ProjectDocument, changes: Record<string, unknown>): ProjectDocument {
  const whole = Object.entries(changes).map(([key, value]): [string, unknown] => {
    const before = now[key];
    const isTable = typeof value === "object" && !Array.isArray(value) && value !== null;
    return [key, isTable ? { ...(typeof before === "object" ? before : {}), ...value } : value ?? undefined];
  });
  return having(now, Object.fromEntries(whole));
}

export function Remedies({ remedies, disabled = false }: { remedies: Remedy[]; disabled?: boolean }) {
  return <>{remedies.map(({ label, changes }) => <button key={label} type="button" class="remedy" disabled={disabled} onClick={() => project.value && edit(mended(project.value, changes))}>{label}</button>)}</>;
}

/** A focal point and its force over what a palm just feels, if it rested and buzzed. */
interface Felt {
  times: number;
  at: number;
  place: Point;
  width_mm: number;
}

/** The weakest and the strongest focal point, without those that a modulation makes weak on purpose. */
export function feltOf(scene: Scene, analysis: Analysis): { weakest: Felt; strongest: Felt } | undefined {
  const most = Math.max(...scene.tour.map(({ amplitude }) => amplitude));
  const whole = new Map(scene.tour.map((entry, at) => [entry.record, { ...entry, number: at }] as const).filter(([, { amplitude }]) => amplitude >= 0.99 * most));
  const all = analysis.foci.flatMap(({ record, force_mn, width_mm }): Felt[] => {
    const entry = whole.get(record);
    return entry ? [{ times: force_mn / analysis.least_felt_mn, at: entry.number, place: entry.at, width_mm }] : [];
  });
  if (all.length === 0) return undefined;
  const by = (better: (a: number, b: number) => boolean): Felt => all.reduce((best, each) => (better(each.times, best.times) ? each : best));
  return { weakest: by((a, b) => a < b), strongest: by((a, b) => a > b) };
}

type Verdict = "clear" | "perhaps" | "unfelt" | "notes" | "looking" | "nothing" | "refused";

/** The program's verdict in a word. */
function verdictOf({ verdict }: Analysis, found: number): Verdict {
  if (verdict.startsWith("felt")) return found > 0 ? "notes" : "clear";
  return verdict.startsWith("perhaps") ? "perhaps" : "unfelt";
}

/** How sure it is: the rest of the program's sentence, without the level that it is of. */
const bandOf = ({ verdict }: Analysis): string => verdict.slice(verdict.indexOf(":") + 1).replace(/;[^;]*$/, "").trim();

/** From a tenth to a hundred times what is just felt, as a part of the bar. */
const onBar = (times: number): number => 100 * Math.min(1, Math.max(0, (Math.log10(Math.max(times, 1e-6)) + 1) / 3));

function Meter({ weakest, strongest }: { weakest: Felt; strongest: Felt }) {
  const [low, high, felt] = [onBar(weakest.times), onBar(strongest.times), onBar(1)];
  return (
    <svg class="meter" viewBox="0 0 200 26" preserveAspectRatio="none" role="img" aria-label={`From ${short(weakest.times)} to ${short(strongest.times)} times what is just felt`}>
      <rect class="track" x="0" y="6" width="200" height="12" rx="3" />
      <rect class="unfelt" x="0" y="6" width={2 * felt} height="12" rx="3" />
      <rect class="range" x={2 * low} y="6" width={Math.max(4, 2 * (high - low))} height="12" rx="3" />
      {low < felt && <rect class="below" x={2 * low} y="6" width={2 * (Math.min(high, felt) - low)} height="12" rx="3" />}
      <rect class="threshold" x={2 * felt - 1} y="2" width="2" height="20" />
    </svg>
  );
}

const verdicts: Record<Verdict, (scene: Scene | undefined, found: number) => string> = {
  clear: () => "Clear everywhere",
  perhaps: () => "Perhaps felt",
  unfelt: () => "Not felt",
  notes: (_, found) => `Felt, with ${found} ${found === 1 ? "remark" : "remarks"}`,
  looking: (scene) => `Each of ${scene?.foci.length ?? 0} points is being looked at…`,
  nothing: () => "Nothing is played yet",
  refused: () => "Cannot be made",
};

export function Feel({ actions }: { actions: Actions }) {
  const { scene, analysis, current, folded } = state;
  const now = state.refused.value ? undefined : scene.value;
  const { value: refused } = state.refused;
  // As long as the box over the view says so, it is said there alone.
  const found = refused ? (state.failure.value ? [] : [{ kind: "refused", message: wordsOf(refused), records: [], remedies: refused.ways ?? [] }]) : now ? analysis.value?.findings ?? now.findings : [];
  const felt = now && analysis.value ? feltOf(now, analysis.value) : undefined;
  const verdict: Verdict = refused ? "refused" : !now ? "nothing" : !analysis.value || !current.value ? "looking" : verdictOf(analysis.value, found.length);
  const closed = folded.value.feel;
  const Icon = verdict === "clear" ? CircleCheck : ["perhaps", "unfelt", "notes", "refused"].includes(verdict) ? TriangleAlert : LoaderCircle;
  return (
    <section id="feel" aria-label="What it will feel like" class={closed ? "closed" : ""}>
      <div class="verdict-row">
        <h2>What it will feel like</h2>
        <p class={`verdict is-${verdict}`} role="status" data-verdict-of-feel={verdict}><Icon size={16} aria-hidden="true" /> {verdicts[verdict](now, found.length)}</p>
        {closed && now && analysis.value && current.value && <p class="band" title={`By models: ${analysis.value.verdict}.`}>{bandOf(analysis.value)}</p>}
        <button type="button" class="ghost" aria-expanded={!closed} aria-label={closed ? "Show what it will feel like in full" : "Fold what it will feel like"} onClick={() => (folded.value = { ...folded.value, feel: !closed })}>{closed ? <ChevronUp size={16} /> : <ChevronDown size={16} />}</button>
      </div>
      {!closed && (
        <div class={current.value || refused ? "feel-body" : "feel-body stale"}>
          {now && analysis.value && <p class="hint">By models: {analysis.value.verdict}.</p>}
          {felt && analysis.value && (
            <>
              <p class="hint">If each focus rested and buzzed:</p>
              <Meter {...felt} />
              <p class="ends"><span>nothing</span><span class="just">just felt</span><span>strong</span></p>
              <dl>
                <dt>Weakest part</dt><dd><button type="button" class="link" onClick={() => actions.mark(felt.weakest.at)}>{short(felt.weakest.times)} ×, at {felt.weakest.place.map((each) => Math.round(each) || 0).join(", ")} mm</button></dd>
                <dt>Strongest part</dt><dd>{short(felt.strongest.times)} ×</dd>
                <dt>Focus</dt><dd>{short(felt.strongest.width_mm)} mm wide</dd>
                <dt>At an ear, 300 mm</dt><dd class={analysis.value.at_300_mm_db > analysis.value.most_at_300_mm_db ? "warning" : ""}>{Math.round(analysis.value.at_300_mm_db)} dB of {Math.round(analysis.value.most_at_300_mm_db)}</dd>
              </dl>
              {!analysis.value.level.calibrated && <details class="more"><summary>At which level</summary><p class="hint">{analysis.value.level.note}</p></details>}
            </>
          )}
          <Findings actions={actions} found={found} />
        </div>
      )}
    </section>
  );
}

function Findings({ actions, found }: { actions: Actions; found: Finding[] }) {
  const { scene, current } = state;
  const show = (finding: Finding): void => {
    const at = scene.value?.tour.findIndex(({ record }) => finding.records.includes(record)) ?? -1;
    const entry = scene.value?.tour[at];
    if (!entry) return;
    actions.mark(at);
    actions.place(state.orientation.value, entry.at);
  };
  return (
    <ul class="findings">
      {found.map((finding) => (
        <li key={finding.kind + finding.message} data-kind={finding.kind}>
          <p class="warning"><TriangleAlert size={14} aria-hidden="true" /> {finding.message}</p>
          <div class="buttons">
            {finding.records.length > 0 && <button type="button" disabled={!current.value} onClick={() => show(finding)}>Show {finding.records.length > 1 ? `the first of ${finding.records.length}` : "it"}</button>}
            <Remedies remedies={finding.remedies} disabled={!current.value && finding.kind !== "refused"} />
          </div>
        </li>
      ))}
    </ul>
  );
}
