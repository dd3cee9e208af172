// SPDX-License-Identifier: Apache-2.0
// The line between the view and a panel at its side: it is dragged, or moved by keys, and remembered.
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";

type Side = "left" | "right";

const limits = [180, 520] as const; // px
const usual = { left: innerWidth < 1600 ? 248 : 270, right: innerWidth < 1100 ? 256 : innerWidth < 1600 ? 296 : 330 };
const kept = (side: Side): number => Number(localStorage.getItem(`width ${side}`)) || usual[side];
const widths = { left: signal(kept("left")), right: signal(kept("right")) };

function setWidth(side: Side, width: number): void {
  const within = Math.round(Math.min(limits[1], Math.max(limits[0], width)));
  widths[side].value = within;
  localStorage.setItem(`width ${side}`, String(within));
}

export function Splitter({ side }: { side: Side }) {
  const width = widths[side].value;
  useEffect(() => document.getElementById("app")?.style.setProperty(`--${side}`, `${width}px`), [width]);
  const drag = (event: PointerEvent): void => {
    if (event.buttons === 1) setWidth(side, side === "left" ? event.clientX : innerWidth - event.clientX);
  };
  const key = (event: KeyboardEvent): void => {
    const way = event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0;
    if (way !== 0) setWidth(side, width + 16 * way * (side === "left" ? 1 : -1));
  };
  return <div class={`splitter ${side}`} role="separator" aria-orientation="vertical" aria-label={`Width of the panel at the ${side}`} aria-valuenow={width} aria-valuemin={limits[0]} aria-valuemax={limits[1]} tabIndex={0} onPointerDown={(event) => event.currentTarget.setPointerCapture(event.pointerId)} onPointerMove={drag} onKeyDown={key} />;
}
