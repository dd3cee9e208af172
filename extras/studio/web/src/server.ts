// SPDX-License-Identifier: Apache-2.0
// The program as the page's engine: messages over the WebSocket, files and downloads over HTTP.
import { type Event, Link, type Message, wrongIn } from "./link";

const longestPause = 4000; // ms between attempts to reach the server
const beatPause = 200; // ms between signs of life
const mostUnheard = 5; // beats without an answer: a second
const stopPatience = 100; // ms until STOP also goes over HTTP

export class Server extends Link {
  readonly boards = "program";
  private socket: WebSocket | undefined;
  private pause = 250;
  private unheard = 0; // beats since the server said something

  constructor(private readonly token: string) {
    super();
    this.connect();
    setInterval(() => this.beat(), beatPause);
    document.addEventListener("visibilitychange", () => this.beat());
  }

  get open(): boolean {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  /** By the socket, and a moment later also by a request of its own if there is no answer. */
  stop(): void {
    const n = this.send({ t: "stop" });
    const timer = setTimeout(() => void this.request("POST", "/api/stop").catch(() => this.tell({ t: "off", n, confirmed: false })), stopPatience);
    const answered = (event: Event): void => {
      if (event.t !== "off" || event.n !== n) return;
      clearTimeout(timer);
      this.listeners.splice(this.listeners.indexOf(answered), 1);
    };
    this.listeners.push(answered);
  }

  protected post(message: Message): void {
    this.socket?.send(JSON.stringify(message));
  }

  protected async request(method: string, target: string, body: Blob | null = null): Promise<Blob> {
    const response = await fetch(target, { method, body, headers: this.headers() });
    if (response.ok) return await response.blob();
    throw wrongIn(await response.text());
  }

  private headers(): Record<string, string> {
    return { Authorization: `Bearer ${this.token}` };
  }

  /** The server answers each. Beats are counted, not time, as a page that was held up itself has not yet read what came. */
  private beat(): void {
    if (!this.open) return;
    this.unheard += 1;
    if (this.unheard === mostUnheard) this.tell({ t: "silent" });
    this.post({ t: "beat", hidden: document.hidden });
  }

  private connect(): void {
    const socket = new WebSocket(`ws://${location.host}/ws`, ["haptogram.1", `token.${this.token}`]);
    this.socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.pause = 250;
      this.unheard = 0;
      this.tell({ t: "open" });
    };
    socket.onmessage = (event: MessageEvent<string | ArrayBuffer>) => {
      if (this.unheard >= mostUnheard) this.tell({ t: "answers" });
      this.unheard = 0;
      this.receive(event.data);
    };
    socket.onclose = () => void this.closed();
  }

  /** One that was started again has another key, and no attempt helps. */
  private async closed(): Promise<void> {
    this.tell({ t: "lost" });
    await new Promise((done) => setTimeout(done, this.pause));
    this.pause = Math.min(longestPause, 2 * this.pause);
    const answer = await fetch("/api/hello", { headers: this.headers(), signal: AbortSignal.timeout(longestPause) }).catch(() => undefined);
    if (answer?.status === 401) this.tell({ t: "refused" });
    else this.connect();
  }
}
