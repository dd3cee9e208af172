// SPDX-License-Identifier: Apache-2.0
// What the FPGA's own circuit does at its pins: the verdict of a simulation, and the pulses of the marked focal point.
import { useState } from "preact/hooks";
import { NeedsProgram } from "./board";
import { Choice, Panel } from "./controls";
import type { PinReport, PulseWindow } from "./link";
import { ticks } from "./profile";
import { short } from "./quantity";
import { type Actions, noProgram, state } from "./state";

const whole = (value: number): string => value.toLocaleString("en");

/** Whether no contract was broken and every focus is where it was asked. */
const good = (report: PinReport): boolean => report.contract_violations === 0 && report.points_off === 0;

function verdict(report: PinReport): string {
  const pulses = `${whole(report.pulses_equal_to_image)} of ${whole(report.pulses)} pulses are compared and equal to the image`;
  const foci = `the worst focus is ${short(report.worst_focus_error_mm)} mm off, and ${(100 * report.least_pressure_kept).toFixed(4)} % of the pressure is kept at least`;
  return good(report) ? `${pulses}; ${foci}.` : `${whole(report.contract_violations)} contracts are broken and ${report.points_off} foci are off; ${pulses}; ${foci}.`;
}

export function Pins({ actions }: { actions: Actions }) {
  const { pins, scene, current } = state;
  const now = pins.value;
  if (!scene.value) return null;
  if (noProgram.value) return <Panel title="Pins"><NeedsProgram what="The FPGA's own circuit is simulated" /></Panel>;
  const stale = now.scene !== scene.value.name || !current.value;
  return (
    <Panel title="Pins">
      {now.underWay ? (
        <>
          <p role="status">Simulating one pass of {short(scene.value.pass_s * 1e3)} ms…</p>
          <button type="button" class="wide" onClick={() => actions.simulate(false)}>Stop simulating</button>
        </>
      ) : (
        <button type="button" class="wide" disabled={!current.value} onClick={() => actions.simulate(true)}>Simulate and measure the pins</button>
      )}
      {!now.report && !now.underWay && <p class="hint">Plays one pass on the FPGA's own circuit, clock by clock, and compares what comes out of the pins with the image.</p>}
      {now.report && (
        <div class={stale ? "stale" : ""}>
          <p class={good(now.report) ? "good" : "warning"} data-verdict={good(now.report) ? "good" : "bad"}>{good(now.report) ? "✓" : "▲"} {verdict(now.report)}</p>
          {now.report.violations.map((each) => <p key={each} class="warning">▲ {each}</p>)}
          {stale ? <p class="hint">This is of an older image; simulate again.</p> : <Lanes actions={actions} window={now.window} />}
        </div>
      )}
    </Panel>
  );
}

const frame = { left: 34, right: 6, top: 6, bottom: 30, width: 300, height: 230 };
const inner = { width: frame.width - frame.left - frame.right, height: frame.height - frame.top - frame.bottom };

/** Channels over time: a block is a pulse that was measured. */
function Lanes({ actions, window }: { actions: Actions; window: PulseWindow | undefined }) {
  const [periods, setPeriods] = useState(2);
  const scene = state.scene.value;
  if (!scene) return null;
  const choice = <Choice label="Carrier periods" value={String(periods)} choices={[1, 2, 4, 10, 40].map((each) => [String(each), String(each)])} onValue={(value) => { setPeriods(Number(value)); actions.showPulses(Number(value)); }} />;
  if (!window) return <><p class="hint">Mark a focal point in the timeline to see its pulses.</p>{choice}</>;
  const { channels } = scene;
  const length = window.to_clk - window.from_clk;
  const row = inner.height / channels;
  const x = (clk: number): number => frame.left + (inner.width * Math.min(length, clk - window.from_clk)) / length;
  const micros = (length / window.clock_hz) * 1e6;
  const path = window.pulses.map(([channel, rise, fall]) => `M${x(rise).toFixed(2)} ${(frame.top + row * channel).toFixed(2)}H${x(fall).toFixed(2)}v${(0.8 * row).toFixed(2)}H${x(rise).toFixed(2)}Z`).join("");
  return (
    <>
      {choice}
      <svg class="plot" viewBox={`0 0 ${frame.width} ${frame.height}`} role="img" aria-label={`${window.pulses.length} pulses of ${channels} channels in ${short(micros)} µs, from the first of record ${window.index} on`}>
        {ticks(0, micros, 5).map((each) => (
          <g key={each}>
            <line class="grid" x1={frame.left + (inner.width * each) / micros} x2={frame.left + (inner.width * each) / micros} y1={frame.top} y2={frame.height - frame.bottom} />
            <text x={frame.left + (inner.width * each) / micros} y={frame.height - frame.bottom + 13} text-anchor="middle">{short(each)}</text>
          </g>
        ))}
        {ticks(0, channels, 5).map((each) => <text key={each} x={frame.left - 4} y={frame.top + row * each + 4} text-anchor="end">{each}</text>)}
        <text x={frame.left + inner.width / 2} y={frame.height - 4} text-anchor="middle">µs since the record's first pulse</text>
        <path class="blocks" d={path} />
      </svg>
      <p class="hint">Channels from top to bottom, for record {window.index}: {whole(window.pulses.length)} pulses.</p>
    </>
  );
}
