// SPDX-License-Identifier: Apache-2.0
// What a hand will feel of the scene, beside it all the time: the program's verdict, how strong its places are and what is not known of
// that, the size of a focus, loudness; and what should be known, in the server's words, each with a way to see and to mend it.
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

/** A place of the verdict, and how much it has over what a palm just feels, dB. */
interface Felt {
  over: number;
  place: Point;
}

/** The weakest and the strongest place of the verdict, and between what all of them may be with what is not known. Without any that alternates, none. */
export function feltOf({ places }: Analysis): { weakest: Felt; strongest: Felt; least: number; most: number } | undefined {
  const all = places.map(({ at, over_db }): Felt => ({ over: over_db ?? -Infinity, place: at }));
  const by = (better: (a: number, b: number) => boolean): Felt | undefined => all.reduce<Felt | undefined>((best, each) => (!best || better(each.over, best.over) ? each : best), undefined);
  const [weakest, strongest] = [by((a, b) => a < b), by((a, b) => a > b)];
  if (!weakest || !strongest || strongest.over === -Infinity) return undefined;
  return { weakest, strongest, least: Math.min(...places.map(({ least_db }) => least_db ?? -Infinity)), most: Math.max(...places.map(({ most_db }) => most_db ?? -Infinity)) };
}

/** The first entry of the tour at a place. */
const entryOf = ({ tour }: Scene, place: Point): number => tour.findIndex(({ at }) => at.every((each, i) => Math.abs(each - (place[i] ?? 0)) < 1e-3));

/** How wide the focus at a place is, mm; of the records of a place, one is analysed. */
function widthAt(scene: Scene, { foci }: Analysis, place: Point): number | undefined {
  const there = new Set(scene.tour.filter(({ at }) => at.every((each, i) => Math.abs(each - (place[i] ?? 0)) < 1e-3)).map(({ record }) => record));
  return foci.find(({ record }) => there.has(record))?.width_mm;
}

type Verdict = "clear" | "perhaps" | "unfelt" | "notes" | "looking" | "nothing" | "refused";

/** The program's verdict in a word. */
function verdictOf({ verdict }: Analysis, found: Finding[]): Verdict {
  // What an ear hears says nothing of what a hand feels.
  if (verdict.startsWith("felt")) return found.some(({ kind }) => kind !== "loud") ? "notes" : "clear";
  return verdict.startsWith("perhaps") ? "perhaps" : "unfelt";
}

/** How sure it is: the rest of the program's sentence, without the level that it is of. */
const bandOf = ({ verdict }: Analysis): string => verdict.slice(verdict.indexOf(":") + 1).replace(/;[^;]*$/, "").trim();

/** The ends of the bar, dB over what is just felt. */
const ends = [-20, 40] as const;
/** Where decibels are on the bar, from 0 to 200. */
const onBar = (db: number): number => 200 * Math.min(1, Math.max(0, (db - ends[0]) / (ends[1] - ends[0])));
const signed = (db: number): string => (db === -Infinity ? "nothing" : `${db < 0 ? "−" : "+"}${Math.abs(db).toFixed(1)} dB`);

/** The places of the verdict, from the weakest to the strongest, and around them what is not known. */
function Meter({ weakest, strongest, least, most }: NonNullable<ReturnType<typeof feltOf>>) {
  const [low, high, from, to, felt] = [onBar(weakest.over), onBar(strongest.over), onBar(least), onBar(most), onBar(0)];
  const left = Math.min(low, 197); // a single place is seen, too
  return (
    <svg class="meter" viewBox="0 0 200 26" preserveAspectRatio="none" role="img" aria-label={`From ${signed(weakest.over)} to ${signed(strongest.over)} over what is just felt; with what is not known, from ${signed(least)} to ${signed(most)}`}>
      <rect class="track" x="0" y="6" width="200" height="12" rx="3" />
      <rect class="unfelt" x="0" y="6" width={felt} height="12" rx="3" />
      <rect class="unknown" x={from} y="9" width={Math.max(0, to - from)} height="6" />
      <rect class="range" x={left} y="6" width={Math.max(3, high - left)} height="12" rx="2" />
      {low < felt && <rect class="below" x={left} y="6" width={Math.max(3, Math.min(high, felt) - left)} height="12" rx="2" />}
      <rect class="threshold" x={felt - 1} y="1" width="2" height="22" />
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
  const felt = now && analysis.value ? feltOf(analysis.value) : undefined;
  const width = now && analysis.value && felt ? widthAt(now, analysis.value, felt.strongest.place) : undefined;
  const weakestAt = now && felt ? entryOf(now, felt.weakest.place) : -1;
  const verdict: Verdict = refused ? "refused" : !now ? "nothing" : !analysis.value || !current.value ? "looking" : verdictOf(analysis.value, found);
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
          {felt && (
            <>
              <Meter {...felt} />
              <p class="ends"><span>nothing</span><span class="just">just felt</span><span>strong</span></p>
            </>
          )}
          {now && analysis.value && (
            <>
              <dl>
                {felt && <><dt>Weakest place</dt><dd><button type="button" class="link" disabled={weakestAt < 0} onClick={() => actions.mark(weakestAt)}>{signed(felt.weakest.over)}, at {felt.weakest.place.map((each) => Math.round(each) || 0).join(", ")} mm</button></dd></>}
                {felt && <><dt>Strongest place</dt><dd>{signed(felt.strongest.over)}</dd></>}
                {felt && width !== undefined && <><dt>Focus there</dt><dd>{short(width)} mm wide</dd></>}
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
    if (at >= 0) actions.point(at);
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
