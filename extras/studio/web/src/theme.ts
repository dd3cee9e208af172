// SPDX-License-Identifier: Apache-2.0
// Light, dark or high contrast: as the system has it, unless another was chosen.
import { effect, signal } from "@preact/signals";

const themes = ["light", "dark", "contrast"] as const;
export type Theme = (typeof themes)[number];

const dark = matchMedia("(prefers-color-scheme: dark)");
const contrast = matchMedia("(prefers-contrast: more)");
const ofSystem = (): Theme => (contrast.matches ? "contrast" : dark.matches ? "dark" : "light");
const chosen = (): Theme | undefined => themes.find((each) => each === localStorage.getItem("theme"));

export const theme = signal<Theme>(chosen() ?? ofSystem());

for (const query of [dark, contrast]) query.addEventListener("change", () => (theme.value = chosen() ?? ofSystem()));

/** The page takes the theme's colours. */
effect(() => void (document.documentElement.dataset["theme"] = theme.value));

export function nextTheme(): void {
  theme.value = themes[(themes.indexOf(theme.value) + 1) % themes.length] ?? "light";
  localStorage.setItem("theme", theme.value);
}
