// SPDX-License-Identifier: Apache-2.0
// Designs as files: a bundle is a zip of project.toml and the files that it names. What is in them is for the server to say.
import { strFromU8, strToU8, unzipSync, zipSync } from "fflate";

export const projectName = "project.toml";
const mostFiles = 1000;

/** Whether a file's text is a project, and not another TOML file. */
export const isProject = (text: string): boolean => /^\s*format\s*=\s*"haptogram-project/m.test(text);

/** A project's text and the files beside it. */
export interface Parts {
  text: string;
  files: File[];
}

/** @param mostBytes  of all files together, unpacked: what a bundle says of itself is believed only up to there */
export function unpack(name: string, bytes: Uint8Array, mostBytes: number): Parts {
  let total = 0, count = 0;
  let found: Record<string, Uint8Array>;
  try {
    found = unzipSync(bytes, {
      filter: ({ name: inner, originalSize }) => {
        total += originalSize;
        if (++count > mostFiles || total > mostBytes) throw new Error(`it has more than ${mostFiles} files or ${mostBytes} bytes`);
        return !inner.endsWith("/");
      },
    });
  } catch (error) {
    throw new Error(`${name}: it cannot be unpacked (${error instanceof Error ? error.message : String(error)}); a bundle is a zip file with a ${projectName} and its files`);
  }
  const project = found[projectName];
  if (!project) throw new Error(`${name}: there is no ${projectName} in it; a bundle has one at the top`);
  const files = Object.entries(found).filter(([inner]) => inner !== projectName);
  return { text: strFromU8(project), files: files.map(([inner, content]) => new File([content as Uint8Array<ArrayBuffer>], inner)) };
}

/** The same parts give the same bytes. */
export async function pack({ text, files }: Parts): Promise<Blob> {
  const all: Record<string, Uint8Array> = { [projectName]: strToU8(text) };
  for (const file of files) all[file.name] = new Uint8Array(await file.arrayBuffer());
  const bytes = zipSync(all, { mtime: "1980-01-01T00:00:00" });
  return new Blob([bytes as Uint8Array<ArrayBuffer>], { type: "application/zip" });
}
