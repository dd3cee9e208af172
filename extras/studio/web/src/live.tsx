// SPDX-License-Identifier: Apache-2.0
// A live session: where the hand comes from, what it feels, and how late.
import { useId, useState } from "preact/hooks";
import { NeedsProgram } from "./board";
import { Choice, Panel, Row } from "./controls";
import { project } from "./document";
import { medianOf, wordsOf } from "./live_reader";
import { short } from "./quantity";
import { type Actions, type LiveSession, made, noProgram, outputsOn, state } from "./state";

interface WithActions {
  actions: Actions;
}

export function Live({ actions }: WithActions) {
  const live = state.live.value;
  if (noProgram.value) return <Panel title="Live hand"><NeedsProgram what="A hand that a tracker sees now is felt with and drawn" /></Panel>;
  return (
    <Panel title="Live hand">
      {live && <Told live={live} />}
      {live && live.now !== "ended" ? <button type="button" class="wide" onClick={() => actions.stop()}>Stop the live session</button> : <Begin actions={actions} again={live !== undefined} />}
    </Panel>
  );
}

function Begin({ actions, again }: WithActions & { again: boolean }) {
  const [pipe, setPipe] = useState<string>();
  const id = useId();
  const hand = project.value?.hand;
  const { connection } = state.device.value;
  const playing = state.work.value?.t === "progress" || state.playsNext.value || state.livesNext.value !== undefined;
  if (!hand)
    return (
      <>
        <p class="hint">This design has no hand, and a live session needs one: a design with a hand says which object it feels, and by which algorithm.</p>
        <button type="button" class="wide" onClick={() => void actions.openShipped("touch", "Touched ball")}>Begin with a ball</button>
      </>
    );
  const ready = !playing && !state.showsKept.value && pipe !== "" && (connection === "connected" || (connection === "none" && made.value !== undefined));
  return (
    <>
      <Choice label="Hand from" value={pipe === undefined ? "recording" : "pipe"} choices={[["recording", hand.recording], ["pipe", "a tracker at a named pipe"]]} onValue={(value) => setPipe(value === "pipe" ? "" : undefined)} />
      {pipe !== undefined && <div class="field"><label for={id}>Pipe</label><input id={id} type="text" class="name" value={pipe} placeholder="/tmp/hands" onInput={(e) => setPipe(e.currentTarget.value.trim())} /></div>}
      <button type="button" class="play wide" disabled={!ready} onClick={() => actions.live(pipe ?? "")}>{again ? "Feel it again" : "Feel it live"}</button>
      <p class="hint">On the board that is connected, else on a virtual one. Outputs are on: ultrasound at these levels is loud though inaudible, so keep ears away. They go off by STOP, and when this page is closed, or hidden for 10 s.</p>
    </>
  );
}

const running: Record<string, string> = { true: "Outputs are on.", false: "Outputs are off.", undefined: "Nobody says whether outputs are on." };
const endings: Record<number, string> = { 0: "The session is over; outputs are off." };

function Told({ live }: { live: LiveSession }) {
  const { now, code, notes, shots, last } = live;
  const latency = medianOf(live.latencies);
  return (
    <>
      <p role="status">{now === "starting" ? "Starting…" : now === "running" ? running[String(outputsOn.value)] : code === null ? "The session was cut off. What its board says of the outputs stands at the top." : (endings[code] ?? "The session ended with an error.")}</p>
      {last && (
        <table>
          <tbody>
            <Row name="Time" value={last.time_s.toFixed(2)} unit="s" />
            <Row name="Parts that touch" value={String(last.fingers)} unit="" />
            <Row name="Lines on the skin" value={String(last.contacts_mm.length)} unit="" />
            <Row name="Foci in turn" value={String(last.foci.length)} unit="" />
            <Row name="Latency, median" value={latency === undefined ? "–" : short(latency)} unit="ms" />
            <Row name="Computed in" value={short(last.compute_ms)} unit="ms" />
            <Row name="Pictures" value={String(shots)} unit="" />
          </tbody>
        </table>
      )}
      {last && now === "running" && <p class="hint">In the view: {wordsOf(last)}.</p>}
      {notes.length > 0 && <details open={now === "ended" && code !== 0}><summary>What the session says</summary><ul class="notes">{notes.map((text, i) => <li key={i}>{text}</li>)}</ul></details>}
    </>
  );
}
