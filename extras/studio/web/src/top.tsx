// SPDX-License-Identifier: Apache-2.0
// The bar at the top: the design and its files, the three steps, and Play, which never moves.
import { Contrast, Eye, FolderOpen, Hand, Moon, PencilRuler, Play, Redo2, Save, Sun, Undo2 } from "lucide-preact";
import { useEffect, useRef } from "preact/hooks";
import { WordField } from "./controls";
import { canRedo, canUndo, designName, isSaved, redo, rename, undo } from "./document";
import { designs, keptAt } from "./keeper";
import { type Actions, boards, inSession, made, noProgram, state, type StepName, stepNames, whyNotMade } from "./state";
import { nextTheme, theme } from "./theme";

interface WithActions {
  actions: Actions;
}

const time = (when: number): string => new Date(when).toLocaleTimeString([], { hour: "2-digit", minute: "2-digit" });
const day = (when: number): string => new Date(when).toLocaleDateString([], { day: "numeric", month: "short" });

function DesignMenu({ actions }: WithActions) {
  const menu = useRef<HTMLDetailsElement>(null);
  const close = (): void => void (menu.current && (menu.current.open = false));
  useEffect(() => {
    const outside = (event: Event): void => void (menu.current?.contains(event.target as Node) || close());
    const escape = (event: KeyboardEvent): void => {
      if (event.key !== "Escape" || !menu.current?.open) return;
      close();
      menu.current.querySelector("summary")?.focus();
    };
    addEventListener("pointerdown", outside);
    addEventListener("keydown", escape);
    return () => {
      removeEventListener("pointerdown", outside);
      removeEventListener("keydown", escape);
    };
  }, []);
  const words = isSaved.value ? "file is up to date" : keptAt.value === undefined ? "not saved as a file" : `kept in this browser, ${time(keptAt.value)}`;
  return (
    <details class="menu" ref={menu}>
      <summary title="Open, save, recent designs"><b>{designName.value || "Haptogram studio"}</b> <small class="wide-only">{words}</small></summary>
      <div class="sheet">
        <WordField label="Name" id="design" value={designName.value} onWord={(name) => rename(name.replaceAll("/", "-"))} />
        <button type="button" class="wide" onClick={() => { close(); void actions.saveBundle(); }}><Save size={16} aria-hidden="true" /> Save as a bundle <kbd>Ctrl S</kbd></button>
        <label class="button wide"><FolderOpen size={16} aria-hidden="true" /> Open a file
          <input class="hidden" type="file" multiple accept=".haptogram,.toml,.ply,.obj,.stl,.off,.pcd,.3mf,.gltf,.glb,.svg,.xyz,.csv,.adaptics,.json,.lz,.pose,.wav" onChange={(e) => { close(); void actions.drop([...(e.currentTarget.files ?? [])]); e.currentTarget.value = ""; }} />
        </label>
        {designs.value.length > 0 && <h3>Recent</h3>}
        {designs.value.map((design) => (
          <button key={design.id} type="button" class="wide ghost" onClick={() => { close(); void actions.restore(design); }}>{design.name} <small>{day(design.when)} {time(design.when)}</small></button>
        ))}
      </div>
    </details>
  );
}

const icons = { Make: PencilRuler, See: Eye, Play: Hand };
const themeIcons = { light: Sun, dark: Moon, contrast: Contrast };

export function Tools({ actions }: WithActions) {
  const Theme = themeIcons[theme.value];
  return (
    <>
      <DesignMenu actions={actions} />
      <div class="steps" role="tablist" aria-label="Steps" onKeyDown={(event) => {
        const way = event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0;
        if (way === 0) return;
        const next = stepNames[(stepNames.indexOf(state.step.value) + way + stepNames.length) % stepNames.length] ?? "Make";
        state.step.value = next;
        event.currentTarget.querySelector<HTMLButtonElement>(`[data-step=${next}]`)?.focus();
      }}>
        {stepNames.map((step) => {
          const Icon = icons[step];
          return <button key={step} type="button" role="tab" data-step={step} aria-selected={state.step.value === step} tabIndex={state.step.value === step ? 0 : -1} onClick={() => choose(step)}><Icon size={16} aria-hidden="true" /> {step === "Play" ? "Use" : step}</button>;
        })}
      </div>
      {!noProgram.value && <button type="button" class={state.step.value === "Play" || state.studying.value ? "ghost" : "ghost away"} aria-pressed={state.studying.value} disabled={inSession.value} onClick={() => actions.study(!state.studying.value)}>Study</button>}
      <button type="button" class="ghost" disabled={!canUndo.value} onClick={undo} title="Undo (Ctrl+Z)" aria-label="Undo"><Undo2 size={16} /></button>
      <button type="button" class="ghost" disabled={!canRedo.value} onClick={redo} title="Redo (Ctrl+Shift+Z)" aria-label="Redo"><Redo2 size={16} /></button>
      <button type="button" class="ghost" onClick={nextTheme} title={`Theme: ${theme.value}`} aria-label="Theme"><Theme size={16} /></button>
    </>
  );
}

/** On a phone, a step also shows its panel, and folds it when it is pressed again. */
function choose(step: StepName): void {
  if (innerWidth <= 640) state.folded.value = { ...state.folded.value, right: state.step.peek() === step && !state.folded.peek().right };
  state.step.value = step;
  if (!inSession.value) state.studying.value = false;
}

const titles = { program: "Starts a virtual board and plays", serial: "Asks for a board and plays", none: "This browser cannot reach boards: Chrome, Edge and Chromium can" };

/** Plays on the board, and starts a virtual one when there is none, or asks for one. */
export function PlayButton({ actions }: WithActions) {
  const { device, work, playsNext } = state;
  const { connection } = device.value;
  const busy = work.value?.t === "progress" || playsNext.value;
  const ready = boards.value !== "none" && made.value !== undefined && !busy && (connection === "connected" || connection === "none");
  return <button type="button" class="play" disabled={!ready} onClick={() => actions.play()} title={whyNotMade.value || (connection !== "none" ? "Outputs on" : titles[boards.value])}><Play size={14} aria-hidden="true" /> Play</button>;
}
