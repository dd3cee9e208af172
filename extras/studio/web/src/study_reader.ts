// SPDX-License-Identifier: Apache-2.0
// A participant's session, as its runner tells it: every order, check and file is the runner's.
import type { Failure, Link, Studies, StudyShown } from "./link";
import { state, type StudyChoice, type StudySession } from "./state";

const mostNotes = 20;

export class StudyReader {
  private listed: number | undefined; // message that asks which studies there are
  private begun: number | undefined; // message that begins a session

  constructor(private readonly link: Link) {}

  list(): void {
    state.studyFailure.value = undefined;
    this.listed = this.link.send({ t: "studies" });
  }

  begin(of: StudyChoice): void {
    state.studyFailure.value = undefined;
    state.session.value = { of, now: { show: "starting" }, texts: [], notes: [], wrong: "", trial: 1, trials: 0 };
    this.begun = this.link.send({ t: "study", ...of });
  }

  answer(text: string): void {
    const session = state.session.peek();
    if (!session || (session.now.show !== "ready" && session.now.show !== "ask")) return;
    this.link.send({ t: "answer", number: session.now.number, text });
    // The same question comes back when the runner does not take the answer.
    state.session.value = { ...session, wrong: "", texts: session.now.show === "ready" ? [] : session.texts };
  }

  leave(): void {
    this.link.send({ t: "leave" });
  }

  came(n: number, studies: Studies): void {
    if (n === this.listed) state.studies.value = studies;
  }

  show(shown: StudyShown): void {
    const session = state.session.peek();
    if (!session) return;
    const change = (changed: Partial<StudySession>): void => void (state.session.value = { ...session, ...changed });
    if (shown.show === "begun") this.begun = undefined;
    else if (shown.show === "note") change({ notes: [...session.notes, shown.text].slice(-mostNotes) });
    else if (shown.show === "wrong") change({ wrong: shown.text });
    else if (shown.show === "tell") change(after(session, { texts: [...told(session), shown.text] }));
    else if (shown.show === "ready") change({ now: shown, wrong: "", texts: told(session), trial: shown.trial, trials: shown.of });
    else if (shown.show === "ask") change({ now: shown, wrong: "", texts: session.now.show === "ask" ? [] : told(session), trial: shown.trial, trials: shown.of });
    else if (shown.show === "late") change({ now: { show: "working" }, wrong: "", texts: ["Time is up."] });
    else if (shown.show === "rest") change({ now: { show: "rest", until: performance.now() + 1000 * shown.seconds }, wrong: "", texts: [] });
    else change({ now: shown, wrong: "", texts: [] });
  }

  fail(n: number | undefined, error: Failure): boolean {
    if (n === undefined || (n !== this.listed && n !== this.begun)) return false;
    if (n === this.begun) state.session.value = undefined;
    state.studyFailure.value = error;
    return true;
  }

  /** The server ended the session with the page's connection. */
  lose(): void {
    const session = state.session.peek();
    if (session && session.now.show !== "ended") state.session.value = { ...session, now: { show: "ended", code: null }, texts: [] };
    if (state.studying.peek()) this.list();
  }
}

/** What was told before a question was answered is not told again. */
const told = (session: StudySession): string[] => (session.now.show === "ask" ? [] : session.texts);
const after = (session: StudySession, changed: Partial<StudySession>): Partial<StudySession> =>
  session.now.show === "ask" || session.now.show === "rest" ? { now: { show: "working" }, ...changed } : changed;
