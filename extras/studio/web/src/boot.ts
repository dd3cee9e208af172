// SPDX-License-Identifier: Apache-2.0
// What must be there at once: the link to the engine and STOP. The view, which is large, comes after it.
import { InPage } from "./in_page";
import type { Link } from "./link";
import { Server } from "./server";
import "./theme";

function element(id: string): HTMLElement {
  const found = document.getElementById(id);
  if (!found) throw new Error(`the page has no element ${id}`);
  return found;
}

/** The token is in the address only until it has been read: an address is shown, copied and kept. */
function takeToken(): string {
  const given = location.hash.slice(1);
  if (/^[0-9a-f]{32}$/.test(given)) {
    sessionStorage.setItem("token", given);
    history.replaceState(null, "", location.pathname);
  }
  return sessionStorage.getItem("token") ?? "";
}

const banner = element("banner");
const told = { link: "", stop: "" };
function show(message: string, of: keyof typeof told = "link"): void {
  told[of] = message;
  banner.textContent = [told.link, told.stop].filter(Boolean).join(" ");
  banner.hidden = banner.textContent === "";
}

/** A page of a static site has its engine with it; one that the program serves has the program. */
function linkOf(): Link | undefined {
  if (document.documentElement.dataset["engine"] === "in-page") return new InPage();
  const token = takeToken();
  return token === "" ? undefined : new Server(token);
}

function begin(link: Link): void {
  // Two frames, so that what is there is drawn first.
  requestAnimationFrame(() =>
    requestAnimationFrame(() => {
      void import("./app").then((app) => app.start(link), (error: unknown) => show(`The view could not be loaded: ${String(error)}`));
    }),
  );
}

const notOff = "STOP was not confirmed: nobody has said that the outputs are off. The board's watchdog should have done it; to be sure, switch its power off.";
const stopPatience = 2500; // ms, a little more than the engine's own

/** STOP, and what a board says of its outputs. */
function takeStop(link: Link): void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  const stop = (): void => {
    element("board").textContent = "Stopping…";
    timer ??= setTimeout(() => show(notOff, "stop"), stopPatience);
    link.stop();
  };
  element("stop").addEventListener("click", stop);
  addEventListener("keydown", (event) => {
    if (event.key === "Escape") stop();
  });
  link.listen((event) => {
    if (event.t === "off") {
      clearTimeout(timer);
      timer = undefined;
      show(event.confirmed ? "" : notOff, "stop");
    }
    if (event.t === "notice") show(event.message);
  });
}

function beginWithServer(link: Link): void {
  takeStop(link);
  link.listen((event) => {
    if (event.t === "open" || event.t === "answers") show("");
    if (event.t === "silent") show("The server does not answer, so what stands here is old. If a board plays, switch its power off: STOP may not reach it.");
    if (event.t === "lost")
      show("The server is gone. If the board was playing, its watchdog has turned the outputs off. Trying to reach it again…");
    if (event.t === "refused") show("The server was started again and does not take this page's key: open the address that “haptogram studio” printed last. It offers the design that was open.");
  });
  begin(link);
}

function beginInPage(link: Link): void {
  if (link.boards === "none") element("stop").hidden = true; // nothing plays from here
  else takeStop(link);
  element("board").textContent = "Loading what computes in this page";
  link.listen((event) => {
    if (event.t === "lost") show("What computes in this page has ended: the browser gives it too little memory, or has no WebAssembly. Load the page again; it offers the design that was open.");
  });
  begin(link);
}

const link = linkOf();
if (link instanceof InPage) {
  beginInPage(link);
} else if (link) {
  beginWithServer(link);
} else {
  element("app").replaceChildren();
  element("stop").hidden = true;
  element("board").textContent = "";
  show("This page needs its key: open the address that “haptogram studio” printed.");
}
