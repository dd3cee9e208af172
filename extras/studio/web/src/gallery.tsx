// SPDX-License-Identifier: Apache-2.0
// Designs to begin with. Each is a bundle that came with the page, with its picture; build.mjs makes their list.
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { type Actions, tell } from "./state";

interface Design {
  file: string;
  title: string;
  about: string;
}

const gallery = signal<Design[]>([]);

async function list(): Promise<void> {
  if (gallery.peek().length === 0) gallery.value = (await (await fetch("gallery.json")).json()) as Design[];
}

export function Gallery({ actions }: { actions: Actions }) {
  useEffect(() => void list().catch(tell), []);
  return (
    <details class="folding" open={innerHeight > 700}>
      <summary>Gallery</summary>
      <ul class="gallery">
        {gallery.value.map(({ file, title, about }) => (
          <li key={file}>
            <button type="button" onClick={() => void actions.openShipped(file, title)}>
              <img src={`${file}.svg`} alt="" width="80" height="52" />
              <b>{title}</b>
              <small>{about}</small>
            </button>
          </li>
        ))}
      </ul>
    </details>
  );
}
