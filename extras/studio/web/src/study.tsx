// SPDX-License-Identifier: Apache-2.0
// The page of studies: the choice of a session, and what its participant sees. It shows what the runner says, and sends what a person does.
import { useEffect, useId, useLayoutEffect, useRef, useState } from "preact/hooks";
import { Choice, NumberField, Panel } from "./controls";
import type { StudyQuestion } from "./link";
import { type Actions, inSession, state, type StudyChoice, type StudySession } from "./state";

interface WithActions {
  actions: Actions;
}

const mostButtons = 21; // of a scale; a wider one is typed
const chosen = "study"; // where the choice is kept for the next session

function kept(): StudyChoice {
  const first = { protocol: "", participant: 1, seed: 1, results: "", port: "" };
  try {
    return { ...first, ...(JSON.parse(sessionStorage.getItem(chosen) ?? "{}") as Partial<StudyChoice>) };
  } catch {
    return first;
  }
}

export function StudyPage({ actions }: WithActions) {
  const session = state.session.value;
  return (
    <main id="study" class="study" hidden={!state.studying.value}>
      {!inSession.value && <button type="button" onClick={() => actions.study(false)}>← Back to the design</button>}
      {session ? <Session key={session.of.results} session={session} actions={actions} /> : <Choose actions={actions} />}
    </main>
  );
}

function Choose({ actions }: WithActions) {
  const [choice, setChoice] = useState(kept);
  const results = useId();
  const port = useId();
  const studies = state.studies.value;
  const failure = state.studyFailure.value;
  const device = state.device.value;
  const change = (changed: Partial<StudyChoice>): void => setChoice({ ...choice, ...changed });
  const listed = Object.entries(studies?.protocols ?? {});
  const about = studies?.protocols[choice.protocol] ?? listed[0]?.[1];
  const protocol = studies?.protocols[choice.protocol] ? choice.protocol : (listed[0]?.[0] ?? "");
  const good = about && !("error" in about) ? about : undefined;
  const suggested = `${protocol.replace(/\.toml$/, "")}-p${choice.participant}.jsonl`;
  const taken = choice.results || suggested;
  // A board that was there may be gone, and another apparatus presents what has no image.
  const playing = good?.playable ? choice.port : "";
  const where = playing === "" || playing === "studio" ? playing : "port";
  const named = /^[A-Za-z0-9_][A-Za-z0-9_.-]*$/.test(taken) && taken.endsWith(".jsonl") && taken.length <= 100;
  const ready = good && named && (where !== "studio" || device.connection === "connected") && playing !== " ";
  const begin = (): void => {
    const all = { ...choice, protocol, results: taken, port: playing.trim() };
    sessionStorage.setItem(chosen, JSON.stringify(choice));
    actions.beginStudy(all);
  };
  return (
    <Panel title="A participant's session">
      {failure && <p class="wrong" role="alert"><strong>{failure.where}</strong> {failure.message}</p>}
      {!studies && failure && <button type="button" onClick={() => actions.anotherStudy()}>Ask again</button>}
      {!studies && !failure && <p role="status">Asking which studies there are…</p>}
      {studies && (
        // No form: Enter in a field takes what stands there, and begins nothing.
        <>
          <Choice label="Protocol" value={protocol} choices={listed.map(([name, each]) => [name, "error" in each ? `${name} (not good)` : `${name}: ${each.title}`])} onValue={(value) => change({ protocol: value })} />
          {about && "error" in about && <p class="warning">▲ {about.error}</p>}
          {good && <p class="hint">{good.source}. {good.trials} trials a participant, {good.participants} participants.</p>}
          <NumberField label="Participant" unit="" value={choice.participant} least={1} onValue={(value) => change({ participant: Math.min(100_000, Math.round(value)) })} />
          <NumberField label="Seed" unit="" value={choice.seed} least={0} onValue={(value) => change({ seed: Math.min(4_294_967_295, Math.round(value)) })} />
          <div class="field">
            <label for={results}>Results file</label>
            <input id={results} type="text" class="name" value={choice.results} placeholder={suggested} onInput={(e) => change({ results: e.currentTarget.value })} />
          </div>
          {!named && <p class="warning">▲ A name that ends in .jsonl, of letters, digits, _, - and .</p>}
          <p class="hint">In {studies.folder}. A session in it that is not finished goes on; nothing is overwritten.</p>
          <Choice label="Stimuli" value={where} choices={[["", "nothing is played"], ...(good?.playable ? ([["studio", "played on the studio's board"], ["port", "played on a board at a port"]] as [string, string][]) : [])]} onValue={(value) => change({ port: value === "port" ? " " : value })} />
          {where === "port" && (
            <div class="field">
              <label for={port}>Board's port</label>
              <input id={port} type="text" class="name" list="ports" value={playing.trim()} placeholder="/dev/ttyUSB0" onInput={(e) => change({ port: e.currentTarget.value || " " })} />
            </div>
          )}
          {good && !good.playable && <p class="hint">Another apparatus presents this study's stimuli.</p>}
          {where === "" && <p class="warning">▲ Nothing is played: the results say so of each trial.</p>}
          {where === "studio" && <p class="hint">{device.connection === "connected" ? "The studio lets go of its board for the session, and takes it back after." : "Connect to a board first: on the object's page, at the right."}</p>}
          {where !== "" && <p class="hint">Ultrasound at these levels is loud though inaudible, so keep ears away. STOP, and closing or leaving this page, end the session and turn the outputs off.</p>}
          <button type="button" class="play wide" disabled={!ready} onClick={begin}>Begin, or go on</button>
        </>
      )}
    </Panel>
  );
}

const endings: Record<number, string> = {
  0: "The session is complete. Thank you.",
  1: "The session was stopped. The same choice goes on with it.",
};

function Session({ session, actions }: WithActions & { session: StudySession }) {
  const { now, of } = session;
  const place = useRef<HTMLDivElement>(null);
  const number = "number" in now ? now.number : 0;
  // Who answers by keys finds the focus where the next answer goes, at once: a key may come before the next picture is drawn.
  useLayoutEffect(() => place.current?.querySelector<HTMLElement>("[data-focus]")?.focus(), [now.show, number]);
  const ended = now.show === "ended";
  const folder = state.studies.value?.folder;
  const complete = ended && now.code === 0;
  const wrong = ended && now.code !== null && endings[now.code] === undefined;
  const done = complete ? session.trials : Math.min(session.trials, session.trial - 1);
  return (
    <section ref={place}>
      <h2>{of.protocol}, participant {of.participant}</h2>
      {session.trials > 0 && <div class="field"><label for="study-progress">Trials done</label><progress id="study-progress" max={session.trials} value={done} /><span>{done} of {session.trials}</span></div>}
      {of.port === "" && <p class="hint">Nothing is played.</p>}
      <div class="asked" aria-live="polite">
        {session.texts.map((text, i) => <p key={i}>{text}</p>)}
        {now.show === "starting" && <p>Starting…</p>}
        {now.show === "rest" && <Resting until={now.until} />}
        {now.show === "ask" && <Asked key={now.number} question={now} wrong={session.wrong} actions={actions} />}
        {now.show === "ready" && <p><button type="button" class="play" data-focus onClick={() => actions.answer("")}>Begin the trial</button></p>}
        {ended && <p tabIndex={-1} data-focus class={complete ? "good" : ""}>{now.code === null ? "The session was cut off. The same choice goes on with it." : (endings[now.code] ?? "The session ended with an error.")}</p>}
        {wrong && <p class="wrong" role="alert">{session.notes.at(-1)}</p>}
        {ended && !wrong && <p>Results: <code>{folder ? `${folder}/` : ""}{of.results}</code></p>}
      </div>
      {now.show === "ready" && <details><summary>For the experimenter: what is presented</summary><p>{now.presented}</p></details>}
      {!ended && <p><button type="button" onClick={() => actions.leaveStudy()}>Pause the session</button></p>}
      {ended && <p class="buttons"><button type="button" onClick={() => actions.beginStudy(of)} disabled={complete}>{wrong ? "Try again" : "Go on"}</button><button type="button" onClick={() => actions.anotherStudy()}>Another session</button></p>}
      {session.notes.length > 0 && <ul class="notes" aria-label="What the runner says">{session.notes.map((text, i) => <li key={i}>{text}</li>)}</ul>}
    </section>
  );
}

/** The seconds that are left, each half second anew. */
function useLeft(until: number): number {
  const [left, setLeft] = useState(until - performance.now());
  useEffect(() => {
    const timer = setInterval(() => setLeft(until - performance.now()), 500);
    return () => clearInterval(timer);
  }, [until]);
  return Math.max(0, Math.ceil(left / 1000));
}

function Resting({ until }: { until: number }) {
  return <p tabIndex={-1} data-focus>Rest: <span aria-live="off">{useLeft(until)} s</span></p>;
}

function Left({ seconds }: { seconds: number }) {
  const [until] = useState(performance.now() + 1000 * seconds);
  return <p class="hint" aria-live="off">{useLeft(until)} s left</p>;
}

function Asked({ question, wrong, actions }: WithActions & { question: StudyQuestion; wrong: string }) {
  const { text, kind, keys, from, to } = question;
  const id = useId();
  const [typed, setTyped] = useState("");
  const scale = kind === "scale" && from !== null && to !== null && to - from < mostButtons;
  const buttons: [string, string][] = scale ? Array.from({ length: to - from + 1 }, (_, i) => [String(from + i), ""]) : keys;
  // With a key that begins another one, a person could not say which is meant.
  const byKey = buttons.length > 0 && buttons.every(([key]) => key.length === 1);
  useLayoutEffect(() => {
    if (!byKey) return;
    const press = (event: KeyboardEvent): void => {
      if (event.ctrlKey || event.metaKey || event.altKey || event.repeat || !buttons.some(([key]) => key === event.key)) return;
      event.preventDefault();
      actions.answer(event.key);
    };
    addEventListener("keydown", press);
    return () => removeEventListener("keydown", press);
  }, [question.number]);
  return (
    <>
      {buttons.length > 0 ? (
        <div role="group" aria-labelledby={id}>
          <p id={id} class="question" tabIndex={-1} data-focus>{text}</p>
          <p class="buttons answers">{buttons.map(([key, meaning]) => <button key={key} type="button" onClick={() => actions.answer(key)}>{meaning ? <>{meaning} <kbd>{key}</kbd></> : key}</button>)}</p>
        </div>
      ) : (
        <form onSubmit={(event) => { event.preventDefault(); actions.answer(typed); }}>
          <p class="question"><label for={id}>{text}</label></p>
          <p class="buttons">
            {kind === "text"
              ? <textarea id={id} data-focus rows={3} maxLength={1000} value={typed} onInput={(e) => setTyped(e.currentTarget.value)} />
              : <input id={id} data-focus type="text" class="name" inputMode="decimal" maxLength={40} value={typed} onInput={(e) => setTyped(e.currentTarget.value)} />}
            <button type="submit">Answer</button>
          </p>
          {kind !== "text" && (from !== null || to !== null) && <p class="hint">{from !== null && `From ${from} `}{to !== null && `to ${to}`}</p>}
        </form>
      )}
      {question.limit_s && <Left seconds={question.limit_s} />}
      {wrong && <p class="warning" role="alert">▲ {wrong}</p>}
    </>
  );
}
