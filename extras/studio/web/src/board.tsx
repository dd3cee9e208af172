// SPDX-License-Identifier: Apache-2.0
// The board: connecting, playing, and what it says of itself.
import { useId, useState } from "preact/hooks";
import { Panel } from "./controls";
import { project } from "./document";
import type { Device } from "./link";
import { type Actions, boards, made, noProgram, outputsOn, playsOther, state, whyNotMade } from "./state";
import { Firing } from "./triggers";

function boardWords(device: Device): string {
  if (state.engine.value === "silent") return "No answer: outputs unknown";
  if (state.engine.value === "gone") return noProgram.value ? "The page's engine is gone" : "The server is gone";
  if (state.stopping.value) return "Stopping…";
  const outputs = `outputs ${outputsOn.value === undefined ? "unknown" : outputsOn.value ? "ON" : "off"}`;
  if (device.guest && device.connection !== "lent" && outputsOn.value) return `Board of the ${device.guest}, ${outputs}`;
  if (device.connection === "none") return { program: "No board: Play starts one", serial: "No board: Play asks for one", none: "No boards in this browser" }[boards.value];
  const name = device.port === "virtual" ? "Virtual board" : device.port === "virtual-rtl" ? "Verilog board" : device.port?.split("/").at(-1) || "Board"; // a whole path leaves no room for the rest
  if (device.connection === "lent") return `${name}, lent to the ${device.guest ?? "session"}, ${outputs}`;
  if (device.connection !== "connected") return `${name}, ${device.connection === "lost" ? "connection lost" : "connecting…"}${outputsOn.value === undefined ? `, ${outputs}` : ""}`;
  if (playsOther.value) return "Outputs ON, not as shown";
  return device.status?.mode === "live" && outputsOn.value ? "Outputs ON, one point" : `${name}, ${outputs}`;
}

/** The bar at the top and the window's title say what the board does. They are read aloud when they change, so they change seldom. */
export function tellBoard(): void {
  const device = state.device.value;
  const on = outputsOn.value === true;
  const place = document.getElementById("board");
  const words = boardWords(device);
  if (place) {
    if (place.textContent !== words) place.textContent = place.title = words;
    place.classList.toggle("on", on);
    place.classList.toggle("unknown", outputsOn.value === undefined);
    place.classList.toggle("ready", device.connection === "connected" && outputsOn.value === false);
  }
  document.body.classList.toggle("outputs-on", on);
  const title = `${on ? "● Outputs on: " : outputsOn.value === undefined ? "▲ Outputs unknown: " : ""}Haptogram studio`;
  if (document.title !== title) document.title = title;
}

interface Reach {
  actions: Actions;
  /** of the line; 0: it is found */
  baud: number;
  /** whether it can be one */
  known: boolean;
}

/** Boards at the ports of the computer that the browser is on. */
function OwnPorts({ actions, baud, known }: Reach) {
  return (
    <>
      <button type="button" class="wide" disabled={!known} onClick={() => actions.send("connect", { port: "", baud, scene: "" })}>Choose a board…</button>
      <p class="hint">The browser shows the serial ports of this computer. A port is used by one program at a time.</p>
      <NeedsProgram what="Boards with a network port, FTDI chips in their fast mode and virtual boards are driven" />
    </>
  );
}

/** Boards that the program reaches. */
function ProgramsBoards({ actions, baud, known }: Reach) {
  const scene = made.value;
  const [port, setPort] = useState("");
  const id = useId();
  return (
    <>
      <button type="button" class="wide" disabled={scene === undefined} onClick={() => actions.send("connect", { port: "virtual", scene: scene?.name ?? "" })}>Start a virtual board</button>
      <p class="hint">It answers and plays as a real board does, in real time. Play starts it by itself.</p>
      <button type="button" class="wide" disabled={scene === undefined} onClick={() => actions.send("connect", { port: "virtual-rtl", scene: scene?.name ?? "" })}>Simulate the FPGA's Verilog</button>
      <p class="hint">The same by the FPGA's own circuit, cycle by cycle; some ten times slower than a board.</p>
      <div class="field port">
        <label for={id}>Port</label>
        <input id={id} type="text" list="ports" value={port} placeholder="/dev/ttyUSB0" onInput={(e) => setPort(e.currentTarget.value)} />
        <datalist id="ports">{state.hello.value?.ports.map((each) => <option key={each.port} value={each.port}>{each.name}</option>)}</datalist>
        <button type="button" disabled={port === "" || !known} onClick={() => actions.send("connect", { port, baud, scene: scene?.name ?? "" })}>Connect</button>
      </div>
    </>
  );
}

export function Board({ actions }: { actions: Actions }) {
  const device = state.device.value;
  const scene = made.value;
  const work = state.work.value;
  const [rate, setRate] = useState("find");
  const baud = rate === "find" || rate === "" ? 0 : Number(rate);
  const known = Number.isInteger(baud) && (baud === 0 || (baud >= 300 && baud <= 12_000_000));
  const id = useId();
  const connected = device.connection === "connected";
  const busy = work?.t === "progress";
  const on = outputsOn.value === true;
  const ready = connected && scene !== undefined && !busy;
  const played = state.played.value;
  const another = busy && work?.work === "play" && work.stage === "play" && scene !== undefined && played !== "" && played !== scene.name;
  return (
    <Panel title="Board">
      {whyNotMade.value && <p class="warning">▲ {whyNotMade.value}</p>}
      {boards.value === "none" ? (
        <>
          <p class="hint">This browser lets no page use serial ports; Chrome, Edge and Chromium on a computer do. Open this page there, with a board at a USB port.</p>
          <NeedsProgram what="Every other board, and the virtual one, is driven" />
        </>
      ) : device.connection === "none" ? (
        <>
          {boards.value === "serial" ? <OwnPorts actions={actions} baud={baud} known={known} /> : <ProgramsBoards actions={actions} baud={baud} known={known} />}
          <div class="field">
            <label for={`${id}-rate`}>Rate</label>
            <span class="box"><input id={`${id}-rate`} type="text" inputMode="numeric" value={rate} onInput={(e) => setRate(e.currentTarget.value.trim())} /><span class="unit">baud</span></span>
          </div>
        </>
      ) : (
        <>
          <p>{boardWords(device)}{device.identity && connected && `; ${device.identity.channels} channels, ${device.identity.records} records`}{device.baud && connected && `; ${device.baud} baud`}{on && device.status?.index !== undefined && `; plays record ${device.status.index}`}{on && state.playsPoint.value !== undefined && `, point ${state.playsPoint.value + 1} of ${scene?.tour.length ?? 0}`}</p>
          {playsOther.value && <p class="warning">▲ The board plays another design than is shown, or this one as it was before. STOP ends it; Play then plays what is shown.</p>}
          {device.trouble && <p class="warning">▲ {device.trouble}</p>}
          <div class="buttons">
            <button type="button" disabled={!ready} onClick={() => actions.send("upload", { scene: scene?.name ?? "" })}>Upload</button>
            {another && <button type="button" onClick={() => actions.send("modulate", { scene: scene?.name ?? "" })}>Modulate as shown</button>}
            <button type="button" disabled={!ready || state.at.value === undefined} onClick={() => actions.stream()}>▶ Follow the slider</button>
            <button type="button" onClick={() => actions.send("disconnect")}>Disconnect</button>
          </div>
          {device.connection !== "lent" && <div class="field">
            <label for={`${id}-intensity`}>Intensity</label>
            <input id={`${id}-intensity`} type="range" min={0} max={100} step={1} value={Math.round(100 * (device.intensity ?? 1))} onInput={(e) => actions.send("intensity", { value: Number(e.currentTarget.value) / 100 })} />
            <span class="unit">{Math.round(100 * (device.intensity ?? 1))} %</span>
          </div>}
          <p class="hint">Playing turns the outputs on: ultrasound at these levels is loud though inaudible, so keep ears away. They go off when this page is closed, or hidden for 10 s.</p>
          {busy && work?.work === "play" && work.stage === "play" && scene !== undefined && scene.name === played && project.value && <Firing actions={actions} triggers={scene.triggers} now={project.value} />}
          <Work waits={scene?.name === played && (scene?.triggers.length ?? 0) > 0 && device.status?.mode === "idle"} />
        </>
      )}
    </Panel>
  );
}

/** What has no place of its own in a page without the program. */
export function LeftOut() {
  if (!noProgram.value) return null;
  return <Panel title="Studies, scattering"><NeedsProgram what="Studies are run, and what a hand scatters of the sound is computed," /></Panel>;
}

/** Says what this page leaves out, and how to have it. */
export function NeedsProgram({ what }: { what: string }) {
  return <p class="hint">{what} by the program, and none is behind this page. Save the design as a bundle, install Haptogram and open the bundle: <code>haptogram studio NAME.haptogram</code>.</p>;
}

/** @param waits  for a trigger */
function Work({ waits }: { waits: boolean }) {
  const work = state.work.value;
  if (!work) return null;
  if (work.t === "progress" && work.stage === "upload")
    return <div class="field"><label for="upload">Uploading</label><progress id="upload" max={1} value={work.fraction ?? 0} /><span class="unit">{Math.round(100 * (work.fraction ?? 0))} %</span></div>;
  if (work.t === "progress" && work.work === "stream") return <p>Playing the marked focal point for {(work.seconds ?? 0).toFixed(1)} s; the slider below the view moves it.</p>;
  if (work.t === "progress" && waits) return <p>Outputs are on; it waits for a trigger.</p>;
  if (work.t === "progress") return <p>Playing for {(work.seconds ?? 0).toFixed(1)} s.</p>;
  if (work.t === "done" && work.work === "upload") return <p>Uploaded: {work.report?.frames_written} of {work.report?.frames} pieces had to be written.</p>;
  if (work.t === "done") return <p>Played to its end.</p>;
  if (work.t === "stopped") return <p>Stopped.</p>;
  return null;
}
