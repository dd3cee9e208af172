// SPDX-License-Identifier: Apache-2.0
// The profile as a drawing. It is SVG, so that it follows the page's theme and its words are text.
import { useRef, useState } from "preact/hooks";
import { Choice, Panel } from "./controls";
import { type Line, lines, ticks, widthOf } from "./profile";
import { look, quantities, short, valueOf } from "./quantity";
import { type Actions, type Profile, state } from "./state";
import { signal } from "@preact/signals";

/** The axis along which the profile runs. */
export const line = signal<Line>("x");

const frame = { left: 44, right: 8, top: 8, bottom: 30, width: 300, height: 190 };
const inner = { width: frame.width - frame.left - frame.right, height: frame.height - frame.top - frame.bottom };

const lengthOf = ({ from, to }: Profile): number => Math.hypot(...to.map((each, i) => each - (from[i] ?? 0)));

/** Values in the unit that is shown. Levels count from the greatest value of all. */
function converted(profile: Profile, greatest: number): number[] {
  const { quantity } = look.value;
  return [...profile.values].map((square) => valueOf(Math.max(square, 1e-12 * greatest), quantity, greatest, profile.skinPerSquare));
}

function curve(values: number[], x: (i: number) => number, y: (value: number) => number): string {
  return values.map((value, i) => `${i === 0 ? "M" : "L"}${x(i).toFixed(1)} ${y(value).toFixed(1)}`).join("");
}

export function ProfilePlot({ actions }: { actions: Actions }) {
  const drawing = useRef<SVGSVGElement>(null);
  const [hover, setHover] = useState<number | undefined>(undefined);
  const { now, kept } = state.profiles.value;
  const axis = lines.indexOf(line.value);
  const choice = <Choice label="Along" value={line.value} choices={lines.map((each) => [each, each])} onValue={(value) => (line.value = value as Line)} />;
  if (!now) return <Panel title="Profile">{choice}<p>Computing…</p></Panel>;
  const { quantity, rangeDb } = look.value;
  const { unit, decibels } = quantities[quantity];
  const greatest = Math.max(...now.values, ...(kept?.values ?? []), 1e-30);
  const values = converted(now, greatest), others = kept ? converted(kept, greatest) : [];
  const most = Math.max(...values, ...others);
  const least = decibels ? most - rangeDb : 0;
  const [start, end] = [now.from[axis] ?? 0, now.to[axis] ?? 0];
  const x = (i: number): number => frame.left + (inner.width * i) / (now.values.length - 1);
  const y = (value: number): number => frame.top + inner.height * (1 - Math.max(0, (value - least) / (most - least || 1)));
  const place = (mm: number): number => frame.left + (inner.width * (mm - start)) / (end - start);
  const width = widthOf(now.values);
  const point = (event: PointerEvent): void => {
    const box = drawing.current?.getBoundingClientRect();
    if (!box) return;
    const i = Math.round((((event.clientX - box.left) / box.width) * frame.width - frame.left) / inner.width * (now.values.length - 1));
    setHover(i >= 0 && i < now.values.length ? i : undefined);
  };
  const at = (i: number): string => `${(start + ((end - start) * i) / (now.values.length - 1)).toFixed(1)} mm: ${short(values[i] ?? 0)} ${unit}${kept ? `, kept ${short(others[i] ?? 0)} ${unit}` : ""}`;
  const csv = (): string =>
    [`x_mm,y_mm,z_mm,mean_square_pa2${kept ? ",kept_mean_square_pa2" : ""}`, ...[...now.values].map((value, i) => {
      const part = i / (now.values.length - 1);
      const where = now.from.map((each, k) => Number((each + part * ((now.to[k] ?? 0) - each)).toFixed(6)));
      return [...where, value, ...(kept ? [kept.values[i]] : [])].join(",");
    })].join("\n") + "\n";
  const peak = values.indexOf(Math.max(...values));
  return (
    <Panel title="Profile">
      {choice}
      <svg ref={drawing} class="plot" viewBox={`0 0 ${frame.width} ${frame.height}`} role="img" aria-label={`${quantities[quantity].name} along ${line.value}: greatest ${short(values[peak] ?? 0)} ${unit} at ${(start + ((end - start) * peak) / (values.length - 1)).toFixed(1)} mm`} onPointerMove={point} onPointerLeave={() => setHover(undefined)}>
        {ticks(least, most, 4).map((value) => (
          <g key={value}>
            <line class="grid" x1={frame.left} x2={frame.width - frame.right} y1={y(value)} y2={y(value)} />
            <text x={frame.left - 4} y={y(value) + 4} text-anchor="end">{short(value)}</text>
          </g>
        ))}
        {ticks(start, end, 5).map((mm) => (
          <g key={mm}>
            <line class="grid" x1={place(mm)} x2={place(mm)} y1={frame.top} y2={frame.height - frame.bottom} />
            <text x={place(mm)} y={frame.height - frame.bottom + 13} text-anchor="middle">{mm}</text>
          </g>
        ))}
        <text x={frame.left + inner.width / 2} y={frame.height - 4} text-anchor="middle">{line.value} / mm</text>
        {width && <rect class="width" x={frame.left + width.low * inner.width} width={(width.high - width.low) * inner.width} y={frame.top} height={inner.height} />}
        {kept && <path class="curve kept" d={curve(others, x, y)} />}
        <path class="curve" d={curve(values, x, y)} />
        {hover !== undefined && <line class="cross" x1={x(hover)} x2={x(hover)} y1={frame.top} y2={frame.height - frame.bottom} />}
      </svg>
      <p class="hint">{hover !== undefined ? at(hover) : width ? `Half of the radiation pressure within ${short((width.high - width.low) * lengthOf(now))} mm (shaded).` : "It does not fall to half on both sides."}{kept && " Dashed: the kept object."}</p>
      <p class="hint">Through {now.from.map((each, i) => (i === axis ? line.value : each.toFixed(1))).join(", ")} mm: {state.at.value === undefined ? "the plane's middle" : "the marked focal point"}.</p>
      <button type="button" onClick={() => actions.save(csv(), "profile.csv")}>Profile (.csv)</button>
    </Panel>
  );
}
